//! `#[derive(Choice)]`.

use proc_macro2::TokenStream;
use quote::quote;
use syn::{Data, DeriveInput, Fields};

use crate::{Core, doc_of};

pub(crate) fn expand(input: &DeriveInput, core: Core) -> syn::Result<TokenStream> {
    let name = &input.ident;
    let Data::Enum(data) = &input.data else {
        return Err(syn::Error::new_spanned(name, "only an enum can be a choice"));
    };
    let mut variants = Vec::new();
    let mut options = Vec::new();
    let mut names = Vec::new();
    for variant in &data.variants {
        if !matches!(variant.fields, Fields::Unit) {
            return Err(syn::Error::new_spanned(variant, "a choice's variants carry no fields"));
        }
        let doc = doc_of(&variant.attrs, variant)?;
        let option = snake_case(&variant.ident.to_string());
        options.push(quote!(#core::ChoiceOption { name: #option.into(), doc: #doc.into() }));
        variants.push(&variant.ident);
        names.push(option);
    }
    Ok(quote! {
        impl #core::Choice for #name {
            fn options() -> ::std::vec::Vec<#core::ChoiceOption> {
                vec![#(#options),*]
            }
            fn name(&self) -> &'static str {
                match self { #(Self::#variants => #names),* }
            }
            fn parse(name: &str) -> Option<Self> {
                match name { #(#names => Some(Self::#variants),)* _ => None }
            }
        }
        impl #core::ParamField for #name {
            fn kind(_: Option<(f64, f64)>, _: Option<(f64, f64)>) -> #core::ParamKind {
                #core::ParamKind::Choice { options: <Self as #core::Choice>::options() }
            }
            fn to_value(&self) -> #core::ParamValue {
                #core::ParamValue::Text(#core::Choice::name(self).into())
            }
            fn from_value(value: &#core::ParamValue) -> Option<Self> {
                match value {
                    #core::ParamValue::Text(name) => <Self as #core::Choice>::parse(name),
                    _ => None,
                }
            }
        }
    })
}

fn snake_case(name: &str) -> String {
    let mut out = String::new();
    for (i, c) in name.chars().enumerate() {
        if c.is_uppercase() && i > 0 {
            out.push('_');
        }
        out.extend(c.to_lowercase());
    }
    out
}
