//! Names of wire types, as `serde` gives them to the variants.

use orograph_core::ValueType;
use serde::{Deserialize, de::IntoDeserializer};

use crate::registry::nearest;

/// The type of that name, or help in choosing one.
pub(super) fn value_type(name: &str) -> Result<ValueType, String> {
    let deserializer: serde::de::value::StrDeserializer<'_, Unknown> = name.into_deserializer();
    ValueType::deserialize(deserializer).map_err(|Unknown(known)| {
        match nearest(name, known.iter().copied()) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("the types are {}", known.join(", ")),
        }
    })
}

/// Carries the known names out of a failed lookup.
#[derive(Debug, thiserror::Error)]
#[error("unknown name")]
struct Unknown(&'static [&'static str]);

impl serde::de::Error for Unknown {
    fn custom<T: std::fmt::Display>(_: T) -> Self {
        Self(&[])
    }

    fn unknown_variant(_: &str, expected: &'static [&'static str]) -> Self {
        Self(expected)
    }
}
