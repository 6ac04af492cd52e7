//! `#[derive(Params)]`.

use proc_macro2::TokenStream;
use quote::{ToTokens, quote};
use syn::{DeriveInput, Expr, Field, LitStr, RangeLimits};

use crate::{Core, doc_of, named_fields};

/// What `#[param(…)]` says of one field.
#[derive(Default)]
struct ParamAttr {
    default: Option<Expr>,
    range: Option<(Expr, Expr)>,
    slider: Option<(Expr, Expr)>,
    unit: Option<LitStr>,
    /// The field is a settings struct that several nodes share; its parameters stand in its place.
    flatten: bool,
}

/// One field's share of every generated function.
struct Member {
    /// Pushes the field's specs.
    spec: TokenStream,
    /// The field's default.
    default: TokenStream,
    /// The field from its values, given where they start.
    read: TokenStream,
    /// Pushes the field's values.
    write: TokenStream,
    /// How many parameters the field is.
    count: TokenStream,
}

pub(crate) fn expand(input: &DeriveInput, core: Core) -> syn::Result<TokenStream> {
    let name = &input.ident;
    let doc = doc_of(&input.attrs, name)?;
    let mut specs = Vec::new();
    let mut defaults = Vec::new();
    let mut reads = Vec::new();
    let mut writes = Vec::new();
    let mut count = quote!(0);
    for field in named_fields(input)? {
        let ident = &field.ident;
        let attr = parse(field)?;
        let member = if attr.flatten { flattened(field, attr, core)? } else { single(field, attr, core)? };
        let (default, read, width) = (member.default, member.read, member.count);
        specs.push(member.spec);
        writes.push(member.write);
        defaults.push(quote!(#ident: #default));
        reads.push(quote!(#ident: { const AT: usize = #count; #read }));
        count.extend(quote!(+ #width));
    }
    Ok(quote! {
        impl ::core::default::Default for #name {
            fn default() -> Self {
                Self { #(#defaults),* }
            }
        }
        impl #core::Params for #name {
            const DOC: &'static str = #doc;
            const COUNT: usize = #count;
            fn specs() -> ::std::vec::Vec<#core::ParamSpec> {
                #[allow(unused_variables)]
                let defaults = Self::default();
                #[allow(unused_mut)]
                let mut specs = ::std::vec::Vec::with_capacity(Self::COUNT);
                #(#specs)*
                specs
            }
            fn from_values(values: &[#core::ParamValue]) -> #core::Result<Self> {
                let expected = Self::COUNT;
                if values.len() != expected {
                    return Err(#core::Error::ParamCount { expected, found: values.len() });
                }
                Ok(Self { #(#reads),* })
            }
            fn to_values(&self) -> ::std::vec::Vec<#core::ParamValue> {
                #[allow(unused_mut)]
                let mut values = ::std::vec::Vec::with_capacity(Self::COUNT);
                #(#writes)*
                values
            }
        }
    })
}

fn single(field: &Field, attr: ParamAttr, core: Core) -> syn::Result<Member> {
    let (ident, ty) = (&field.ident, &field.ty);
    let label = ident.to_token_stream().to_string();
    let doc = doc_of(&field.attrs, ident)?;
    let Some(default) = attr.default else {
        return Err(syn::Error::new_spanned(ident, "needs #[param(default = …)]"));
    };
    let numeric = is_numeric(ty);
    if numeric && (attr.range.is_none() || attr.unit.is_none()) {
        return Err(syn::Error::new_spanned(ident, "a number needs `range = a..=b` and `unit = \"…\"`"));
    }
    let limits = |pair: &Option<(Expr, Expr)>| match pair {
        Some((low, high)) => quote!(Some(((#low) as f64, (#high) as f64))),
        None => quote!(None),
    };
    let range = limits(&attr.range);
    let slider = limits(&attr.slider);
    let unit = match &attr.unit {
        Some(unit) => {
            quote!(const { #core::Unit::parse(#unit) })
        }
        None => quote!(#core::Unit::One),
    };
    Ok(Member {
        spec: quote! {
            specs.push(#core::ParamSpec {
                name: #label.into(),
                doc: #doc.into(),
                unit: #unit,
                kind: <#ty as #core::ParamField>::kind(#range, #slider),
                default: #core::ParamField::to_value(&defaults.#ident),
            });
        },
        // A bare literal takes the field's type, so that `default = 10` serves every number.
        default: if numeric { quote!((#default) as #ty) } else { quote!((#default).into()) },
        read: quote! {
            #core::ParamField::from_value(&values[AT])
                .ok_or(#core::Error::ParamType { name: #label.into() })?
        },
        write: quote!(values.push(#core::ParamField::to_value(&self.#ident));),
        count: quote!(1),
    })
}

fn flattened(field: &Field, attr: ParamAttr, core: Core) -> syn::Result<Member> {
    let (ident, ty) = (&field.ident, &field.ty);
    if attr.range.is_some() || attr.slider.is_some() || attr.unit.is_some() {
        return Err(syn::Error::new_spanned(
            ident,
            "ranges and units belong to the flattened struct's fields",
        ));
    }
    let count = quote!(<#ty as #core::Params>::COUNT);
    Ok(Member {
        // The defaults are those of this field, which may differ from those of its type.
        spec: quote! {
            for (spec, default) in <#ty as #core::Params>::specs()
                .into_iter()
                .zip(#core::Params::to_values(&defaults.#ident))
            {
                specs.push(#core::ParamSpec { default, ..spec });
            }
        },
        default: match attr.default {
            Some(default) => quote!(#default),
            None => quote!(<#ty as ::core::default::Default>::default()),
        },
        read: quote!(#core::Params::from_values(&values[AT..AT + #count])?),
        write: quote!(values.extend(#core::Params::to_values(&self.#ident));),
        count,
    })
}

fn parse(field: &Field) -> syn::Result<ParamAttr> {
    let mut found = ParamAttr::default();
    for attr in field.attrs.iter().filter(|attr| attr.path().is_ident("param")) {
        attr.parse_nested_meta(|meta| {
            if meta.path.is_ident("flatten") {
                found.flatten = true;
                return Ok(());
            }
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
                return Err(meta.error("expected `default`, `range`, `slider`, `unit` or `flatten`"));
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
