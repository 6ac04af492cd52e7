//! How typed ports read and write the values on wires.

use std::sync::Arc;

use crate::{
    Arity, Features, Heightfield, Mask, Mesh, Placement, Points, PortSpec, Table, Texture, Value, ValueType,
};

/// What is connected to an input.
#[derive(Clone, Debug)]
pub enum Slot {
    /// Nothing.
    Empty,
    /// One wire.
    One(Value),
    /// The wires of a port that takes many.
    Many(Vec<Value>),
}

/// A Rust type that travels along a wire.
pub trait Wire: Sized {
    /// The wire's type.
    const TYPE: ValueType;
    /// Puts the value on a wire.
    fn into_value(self) -> Value;
    /// Borrows the value on a wire; `None` when the wire is of another type.
    fn borrow(value: &Value) -> Option<&Self>;
}

macro_rules! shared_wire {
    ($($ty:ident),*) => {$(
        impl Wire for $ty {
            const TYPE: ValueType = ValueType::$ty;
            fn into_value(self) -> Value {
                Value::$ty(Arc::new(self))
            }
            fn borrow(value: &Value) -> Option<&Self> {
                match value {
                    Value::$ty(inner) => Some(inner),
                    _ => None,
                }
            }
        }
    )*};
}
shared_wire!(Heightfield, Mask, Texture, Features, Points, Placement, Table, Mesh);

macro_rules! scalar_wire {
    ($($ty:ty => $variant:ident),*) => {$(
        impl Wire for $ty {
            const TYPE: ValueType = ValueType::$variant;
            fn into_value(self) -> Value {
                Value::$variant(self)
            }
            fn borrow(value: &Value) -> Option<&Self> {
                match value {
                    Value::$variant(inner) => Some(inner),
                    _ => None,
                }
            }
        }
    )*};
}
scalar_wire!(f64 => Number, i64 => Integer, bool => Boolean, Arc<str> => Text);

/// A field of an [`Inputs`](crate::Inputs) struct: `&T`, `Option<&T>` or `Vec<&T>`.
pub trait InputField<'a>: Sized {
    /// The port that the field declares.
    fn spec(name: &'static str, doc: &'static str) -> PortSpec;
    /// The field from what is connected; `None` when that does not fit.
    fn read(slot: &'a Slot) -> Option<Self>;
}

fn port<T: Wire>(name: &'static str, doc: &'static str, arity: Arity) -> PortSpec {
    PortSpec { name: name.into(), doc: doc.into(), value_type: T::TYPE, arity }
}

impl<'a, T: Wire> InputField<'a> for &'a T {
    fn spec(name: &'static str, doc: &'static str) -> PortSpec {
        port::<T>(name, doc, Arity::One)
    }
    fn read(slot: &'a Slot) -> Option<Self> {
        match slot {
            Slot::One(value) => T::borrow(value),
            _ => None,
        }
    }
}

impl<'a, T: Wire> InputField<'a> for Option<&'a T> {
    fn spec(name: &'static str, doc: &'static str) -> PortSpec {
        port::<T>(name, doc, Arity::Optional)
    }
    fn read(slot: &'a Slot) -> Option<Self> {
        match slot {
            Slot::Empty => Some(None),
            Slot::One(value) => T::borrow(value).map(Some),
            Slot::Many(_) => None,
        }
    }
}

impl<'a, T: Wire> InputField<'a> for Vec<&'a T> {
    fn spec(name: &'static str, doc: &'static str) -> PortSpec {
        port::<T>(name, doc, Arity::Many)
    }
    fn read(slot: &'a Slot) -> Option<Self> {
        match slot {
            Slot::Empty => Some(Vec::new()),
            Slot::One(value) => T::borrow(value).map(|value| vec![value]),
            Slot::Many(values) => values.iter().map(T::borrow).collect(),
        }
    }
}
