//! Derives that write Orograph's spec tables, and nothing else.
//!
//! `Params`, `Inputs`, `Outputs` and `Choice` read a declaration's doc comments and attributes and emit
//! the trait implementations of the same names in `orograph_core`. A missing doc comment, unit, range or
//! default is a compile error at the field that lacks it.
//!
//! Each comes twice: built-in nodes know the traits by the name of `orograph_core`, a plugin's nodes by that of
//! `orograph_plugin`, the only crate that its author depends on and which names the second set like the first.

mod choice;
mod params;
mod ports;

use proc_macro::TokenStream;
use quote::quote;
use syn::{Attribute, DeriveInput, Expr, ExprLit, Fields, Lit, Meta, parse_macro_input};

/// Derives `orograph_core::Params` and `Default` for a node's settings.
///
/// Every field takes `#[param(default = …)]`; numbers also need `range = a..=b` and `unit = "…"`, and may
/// narrow what an inspector offers with `slider = a..=b`.
///
/// A field with `#[param(flatten)]` is a settings struct that several nodes share: its parameters stand in the
/// field's place under their own names. `default = …` beside it gives this node other defaults.
#[proc_macro_derive(Params, attributes(param))]
pub fn derive_params(input: TokenStream) -> TokenStream {
    expand(parse_macro_input!(input as DeriveInput), params::expand, Core::Itself)
}

/// Derives `orograph_core::Choice` for an enum of unit variants; the variants' docs are the options' docs.
#[proc_macro_derive(Choice)]
pub fn derive_choice(input: TokenStream) -> TokenStream {
    expand(parse_macro_input!(input as DeriveInput), choice::expand, Core::Itself)
}

/// Derives `orograph_core::Inputs`; `Option<_>` marks an optional port and `Vec<_>` one taking many links.
#[proc_macro_derive(Inputs)]
pub fn derive_inputs(input: TokenStream) -> TokenStream {
    expand(parse_macro_input!(input as DeriveInput), ports::expand_inputs, Core::Itself)
}

/// Derives `orograph_core::Outputs`: one port per field.
#[proc_macro_derive(Outputs)]
pub fn derive_outputs(input: TokenStream) -> TokenStream {
    expand(parse_macro_input!(input as DeriveInput), ports::expand_outputs, Core::Itself)
}

/// [`derive_params`] in a plugin.
#[doc(hidden)]
#[proc_macro_derive(PluginParams, attributes(param))]
pub fn derive_plugin_params(input: TokenStream) -> TokenStream {
    expand(parse_macro_input!(input as DeriveInput), params::expand, Core::Sdk)
}

/// [`derive_choice`] in a plugin.
#[doc(hidden)]
#[proc_macro_derive(PluginChoice)]
pub fn derive_plugin_choice(input: TokenStream) -> TokenStream {
    expand(parse_macro_input!(input as DeriveInput), choice::expand, Core::Sdk)
}

/// [`derive_inputs`] in a plugin.
#[doc(hidden)]
#[proc_macro_derive(PluginInputs)]
pub fn derive_plugin_inputs(input: TokenStream) -> TokenStream {
    expand(parse_macro_input!(input as DeriveInput), ports::expand_inputs, Core::Sdk)
}

/// [`derive_outputs`] in a plugin.
#[doc(hidden)]
#[proc_macro_derive(PluginOutputs)]
pub fn derive_plugin_outputs(input: TokenStream) -> TokenStream {
    expand(parse_macro_input!(input as DeriveInput), ports::expand_outputs, Core::Sdk)
}

/// Which crate the traits are reached through.
#[derive(Clone, Copy)]
enum Core {
    /// `orograph_core`.
    Itself,
    /// `orograph_plugin`, which hands on all of it.
    Sdk,
}

impl quote::ToTokens for Core {
    fn to_tokens(&self, tokens: &mut proc_macro2::TokenStream) {
        tokens.extend(match self {
            Self::Itself => quote!(::orograph_core),
            Self::Sdk => quote!(::orograph_plugin),
        });
    }
}

type Expansion = fn(&DeriveInput, Core) -> syn::Result<proc_macro2::TokenStream>;

fn expand(input: DeriveInput, expansion: Expansion, core: Core) -> TokenStream {
    match expansion(&input, core) {
        Ok(tokens) => tokens.into(),
        Err(error) => {
            let error = error.to_compile_error();
            quote!(#error).into()
        }
    }
}

/// The doc comment as one string, lines trimmed; an error naming `what` when there is none.
fn doc_of(attrs: &[Attribute], what: &dyn quote::ToTokens) -> syn::Result<String> {
    let mut lines = Vec::new();
    for attr in attrs.iter().filter(|attr| attr.path().is_ident("doc")) {
        if let Meta::NameValue(pair) = &attr.meta
            && let Expr::Lit(ExprLit { lit: Lit::Str(text), .. }) = &pair.value
        {
            lines.push(text.value().trim().to_owned());
        }
    }
    let doc = lines.join("\n").trim().to_owned();
    if doc.is_empty() {
        return Err(syn::Error::new_spanned(what, "needs a doc comment: it is the text that users read"));
    }
    Ok(doc)
}

/// The named fields of a struct; none for a unit struct.
fn named_fields(input: &DeriveInput) -> syn::Result<Vec<&syn::Field>> {
    match &input.data {
        syn::Data::Struct(data) => match &data.fields {
            Fields::Named(fields) => Ok(fields.named.iter().collect()),
            Fields::Unit => Ok(Vec::new()),
            Fields::Unnamed(_) => Err(syn::Error::new_spanned(&input.ident, "needs named fields")),
        },
        _ => Err(syn::Error::new_spanned(&input.ident, "only a struct can derive this")),
    }
}
