//! `#[derive(Inputs)]` and `#[derive(Outputs)]`.

use proc_macro2::TokenStream;
use quote::{ToTokens, quote};
use syn::{DeriveInput, Lifetime};

use crate::{doc_of, named_fields};

pub(crate) fn expand_inputs(input: &DeriveInput) -> syn::Result<TokenStream> {
    let name = &input.ident;
    let fields = named_fields(input)?;
    let mut specs = Vec::new();
    let mut reads = Vec::new();
    for (index, field) in fields.iter().enumerate() {
        let ident = &field.ident;
        let label = ident.to_token_stream().to_string();
        let ty = &field.ty;
        let doc = doc_of(&field.attrs, ident)?;
        specs.push(quote!(<#ty as ::orograph_core::InputField<'a>>::spec(#label, #doc)));
        reads.push(quote! {
            #ident: <#ty as ::orograph_core::InputField<'a>>::read(&slots[#index])
                .ok_or(::orograph_core::Error::InputType { name: #label.into() })?
        });
    }
    let lifetime = Lifetime::new("'a", proc_macro2::Span::call_site());
    let arguments = (input.generics.lifetimes().count() > 0).then(|| quote!(<#lifetime>));
    let count = specs.len();
    Ok(quote! {
        impl<'a> ::orograph_core::Inputs<'a> for #name #arguments {
            fn specs() -> ::std::vec::Vec<::orograph_core::PortSpec> {
                vec![#(#specs),*]
            }
            fn read(slots: &'a [::orograph_core::Slot]) -> ::orograph_core::Result<Self> {
                if slots.len() != #count {
                    return Err(::orograph_core::Error::PortCount { expected: #count, found: slots.len() });
                }
                Ok(Self { #(#reads),* })
            }
        }
    })
}

pub(crate) fn expand_outputs(input: &DeriveInput) -> syn::Result<TokenStream> {
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
            ::orograph_core::PortSpec {
                name: #label.into(),
                doc: #doc.into(),
                value_type: <#ty as ::orograph_core::Wire>::TYPE,
                arity: ::orograph_core::Arity::One,
            }
        });
        writes.push(quote!(::orograph_core::Wire::into_value(self.#ident)));
    }
    Ok(quote! {
        impl ::orograph_core::Outputs for #name {
            fn specs() -> ::std::vec::Vec<::orograph_core::PortSpec> {
                vec![#(#specs),*]
            }
            fn into_values(self) -> ::std::vec::Vec<::orograph_core::Value> {
                vec![#(#writes),*]
            }
        }
    })
}
