//! `#[derive(Inputs)]` and `#[derive(Outputs)]`.

use proc_macro2::TokenStream;
use quote::{ToTokens, quote};
use syn::{DeriveInput, Lifetime};

use crate::{Core, doc_of, named_fields};

pub(crate) fn expand_inputs(input: &DeriveInput, core: Core) -> syn::Result<TokenStream> {
    let name = &input.ident;
    let fields = named_fields(input)?;
    let mut specs = Vec::new();
    let mut reads = Vec::new();
    for (index, field) in fields.iter().enumerate() {
        let ident = &field.ident;
        let label = ident.to_token_stream().to_string();
        let ty = &field.ty;
        let doc = doc_of(&field.attrs, ident)?;
        specs.push(quote!(<#ty as #core::InputField<'a>>::spec(#label, #doc)));
        reads.push(quote! {
            #ident: <#ty as #core::InputField<'a>>::read(&slots[#index])
                .ok_or(#core::Error::InputType { name: #label.into() })?
        });
    }
    let lifetime = Lifetime::new("'a", proc_macro2::Span::call_site());
    let arguments = (input.generics.lifetimes().count() > 0).then(|| quote!(<#lifetime>));
    let count = specs.len();
    Ok(quote! {
        impl<'a> #core::Inputs<'a> for #name #arguments {
            fn specs() -> ::std::vec::Vec<#core::PortSpec> {
                vec![#(#specs),*]
            }
            fn read(slots: &'a [#core::Slot]) -> #core::Result<Self> {
                if slots.len() != #count {
                    return Err(#core::Error::PortCount { expected: #count, found: slots.len() });
                }
                Ok(Self { #(#reads),* })
            }
        }
    })
}

pub(crate) fn expand_outputs(input: &DeriveInput, core: Core) -> syn::Result<TokenStream> {
    let name = &input.ident;
    let fields = named_fields(input)?;
    let mut specs = Vec::new();
    let mut writes = Vec::new();
    for field in &fields {
        let ident = &field.ident;
        let label = ident.to_token_stream().to_string();
        let ty = &field.ty;
        let doc = doc_of(&field.attrs, ident)?;
        specs.push(quote! {
            #core::PortSpec {
                name: #label.into(),
                doc: #doc.into(),
                value_type: <#ty as #core::Wire>::TYPE,
                arity: #core::Arity::One,
            }
        });
        writes.push(quote!(#core::Wire::into_value(self.#ident)));
    }
    Ok(quote! {
        impl #core::Outputs for #name {
            fn specs() -> ::std::vec::Vec<#core::PortSpec> {
                vec![#(#specs),*]
            }
            fn into_values(self) -> ::std::vec::Vec<#core::Value> {
                vec![#(#writes),*]
            }
        }
    })
}
