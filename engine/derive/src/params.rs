//! `#[derive(Params)]`.

use proc_macro2::TokenStream;
use quote::{ToTokens, quote};
use syn::{DeriveInput, Expr, Field, LitStr, RangeLimits};

use crate::{doc_of, named_fields};

/// What `#[param(…)]` says of one field.
#[derive(Default)]
struct ParamAttr {
    default: Option<Expr>,
    range: Option<(Expr, Expr)>,
    slider: Option<(Expr, Expr)>,
    unit: Option<LitStr>,
}

pub(crate) fn expand(input: &DeriveInput) -> syn::Result<TokenStream> {
    let name = &input.ident;
    let doc = doc_of(&input.attrs, name)?;
    let mut specs = Vec::new();
    let mut defaults = Vec::new();
    let mut reads = Vec::new();
    let mut writes = Vec::new();
    for (index, field) in named_fields(input)?.into_iter().enumerate() {
        let ident = &field.ident;
        let label = ident.to_token_stream().to_string();
        let ty = &field.ty;
        let attr = parse(field)?;
        let field_doc = doc_of(&field.attrs, ident)?;
        let Some(default) = attr.default else {
            return Err(syn::Error::new_spanned(ident, "needs #[param(default = …)]"));
        };
        let numeric = is_numeric(ty);
        if numeric && (attr.range.is_none() || attr.unit.is_none()) {
            return Err(syn::Error::new_spanned(ident, "a number needs `range = a..=b` and `unit = \"…\"`"));
        }
        // A bare literal takes the field's type, so that `default = 10` serves every number.
        let default = if numeric { quote!((#default) as #ty) } else { quote!((#default).into()) };
        let limits = |pair: &Option<(Expr, Expr)>| match pair {
            Some((low, high)) => quote!(Some(((#low) as f64, (#high) as f64))),
            None => quote!(None),
        };
        let range = limits(&attr.range);
        let slider = limits(&attr.slider);
        let unit = match &attr.unit {
            Some(unit) => {
                quote!(const { ::orograph_core::Unit::parse(#unit) })
            }
            None => quote!(::orograph_core::Unit::One),
        };
        specs.push(quote! {
            ::orograph_core::ParamSpec {
                name: #label.into(),
                doc: #field_doc.into(),
                unit: #unit,
                kind: <#ty as ::orograph_core::ParamField>::kind(#range, #slider),
                default: ::orograph_core::ParamField::to_value(&defaults.#ident),
            }
        });
        defaults.push(quote!(#ident: #default));
        reads.push(quote! {
            #ident: ::orograph_core::ParamField::from_value(&values[#index])
                .ok_or(::orograph_core::Error::ParamType { name: #label.into() })?
        });
        writes.push(quote!(::orograph_core::ParamField::to_value(&self.#ident)));
    }
    let count = specs.len();
    Ok(quote! {
        impl ::core::default::Default for #name {
            fn default() -> Self {
                Self { #(#defaults),* }
            }
        }
        impl ::orograph_core::Params for #name {
            const DOC: &'static str = #doc;
            fn specs() -> ::std::vec::Vec<::orograph_core::ParamSpec> {
                #[allow(unused_variables)]
                let defaults = Self::default();
                vec![#(#specs),*]
            }
            fn from_values(values: &[::orograph_core::ParamValue]) -> ::orograph_core::Result<Self> {
                if values.len() != #count {
                    return Err(::orograph_core::Error::ParamCount { expected: #count, found: values.len() });
                }
                Ok(Self { #(#reads),* })
            }
            fn to_values(&self) -> ::std::vec::Vec<::orograph_core::ParamValue> {
                vec![#(#writes),*]
            }
        }
    })
}

fn parse(field: &Field) -> syn::Result<ParamAttr> {
    let mut found = ParamAttr::default();
    for attr in field.attrs.iter().filter(|attr| attr.path().is_ident("param")) {
        attr.parse_nested_meta(|meta| {
            let value = meta.value()?;
            if meta.path.is_ident("default") {
                found.default = Some(value.parse()?);
            } else if meta.path.is_ident("range") {
                found.range = Some(closed(value.parse()?)?);
            } else if meta.path.is_ident("slider") {
                found.slider = Some(closed(value.parse()?)?);
            } else if meta.path.is_ident("unit") {
                found.unit = Some(value.parse()?);
            } else {
                return Err(meta.error("expected `default`, `range`, `slider` or `unit`"));
            }
            Ok(())
        })?;
    }
    Ok(found)
}

/// Splits `a..=b`; any other range is refused, since both ends are part of the promise.
fn closed(expr: Expr) -> syn::Result<(Expr, Expr)> {
    if let Expr::Range(range) = &expr
        && matches!(range.limits, RangeLimits::Closed(_))
        && let (Some(low), Some(high)) = (&range.start, &range.end)
    {
        return Ok((low.as_ref().clone(), high.as_ref().clone()));
    }
    Err(syn::Error::new_spanned(expr, "expected a closed range `a..=b`"))
}

fn is_numeric(ty: &syn::Type) -> bool {
    matches!(ty.to_token_stream().to_string().as_str(), "f64" | "i64" | "u32" | "u64")
}
