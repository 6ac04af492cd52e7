//! Parameter values and the field types that hold them.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::{Colour, Error, Gradient, Hasher, ParamField, ParamKind, ParamSpec, Result};

/// The value of a parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum ParamValue {
    /// Of [`ParamKind::Number`].
    Number(f64),
    /// Of [`ParamKind::Integer`].
    Integer(i64),
    /// Of [`ParamKind::Boolean`].
    Boolean(bool),
    /// Of [`ParamKind::Text`], [`ParamKind::Choice`], [`ParamKind::InputPath`], [`ParamKind::OutputPath`],
    /// [`ParamKind::Colour`] and [`ParamKind::Gradient`].
    Text(String),
    /// Of [`ParamKind::Curve`].
    Curve(Vec<[f64; 2]>),
    /// Of [`ParamKind::Lines`].
    Lines(Vec<Vec<[f64; 3]>>),
}

impl ParamValue {
    /// Adds the value to a key.
    pub fn feed(&self, hasher: &mut Hasher) {
        // Adding zero turns -0.0 into 0.0: the two are written alike and mean the same.
        let number = |hasher: &mut Hasher, x: f64| {
            hasher.number((x + 0.0).to_bits());
        };
        match self {
            Self::Number(x) => number(hasher.number(0), *x),
            Self::Integer(i) => {
                hasher.number(1).number(*i as u64);
            }
            Self::Boolean(b) => {
                hasher.number(2).number(u64::from(*b));
            }
            Self::Text(text) => {
                hasher.number(3).text(text);
            }
            Self::Curve(points) => {
                hasher.number(4).number(points.len() as u64);
                points.iter().flatten().for_each(|x| number(hasher, *x));
            }
            Self::Lines(lines) => {
                hasher.number(5).number(lines.len() as u64);
                for line in lines {
                    hasher.number(line.len() as u64);
                    line.iter().flatten().for_each(|x| number(hasher, *x));
                }
            }
        }
    }
}

impl ParamSpec {
    /// Checks a value against the hard limits.
    ///
    /// # Errors
    /// [`Error::ParamType`], [`Error::OutOfRange`], or [`Error::Invalid`] for an unknown option, an
    /// unordered curve or a path that leaves the output folder.
    pub fn check(&self, value: &ParamValue) -> Result<()> {
        let name = &self.name;
        let inside = |x: f64, (low, high): (f64, f64)| {
            if (low..=high).contains(&x) {
                return Ok(());
            }
            Err(Error::OutOfRange { name: name.to_string(), value: x, low, high, unit: self.unit })
        };
        match (&self.kind, value) {
            (ParamKind::Number { range, .. }, ParamValue::Number(x)) => inside(*x, *range),
            (ParamKind::Integer { range, .. }, ParamValue::Integer(i)) => {
                inside(*i as f64, (range.0 as f64, range.1 as f64))
            }
            (ParamKind::Boolean, ParamValue::Boolean(_))
            | (ParamKind::Text | ParamKind::InputPath, ParamValue::Text(_)) => Ok(()),
            (ParamKind::Choice { options }, ParamValue::Text(text)) => {
                if options.iter().any(|option| option.name == *text) {
                    return Ok(());
                }
                let names: Vec<_> = options.iter().map(|option| option.name.as_ref()).collect();
                Err(Error::invalid(
                    format!("`{name}` has no option `{text}`"),
                    format!("choose one of {}", names.join(", ")),
                ))
            }
            (ParamKind::OutputPath, ParamValue::Text(text)) => check_output_path(name, text),
            (ParamKind::Colour, ParamValue::Text(text)) => written(name, text.parse::<Colour>()),
            (ParamKind::Gradient, ParamValue::Text(text)) => written(name, text.parse::<Gradient>()),
            (ParamKind::Curve { x, y }, ParamValue::Curve(points)) => {
                for point in points {
                    inside(point[0], *x)?;
                    inside(point[1], *y)?;
                }
                if points.is_empty() || points.windows(2).any(|pair| pair[0][0] >= pair[1][0]) {
                    return Err(Error::invalid(
                        format!("the curve `{name}` needs points with x ascending"),
                        "sort the points by x and give each its own",
                    ));
                }
                Ok(())
            }
            (ParamKind::Lines { range }, ParamValue::Lines(lines)) => {
                lines.iter().flatten().flatten().try_for_each(|x| inside(*x, *range))
            }
            _ => Err(Error::ParamType { name: name.to_string() }),
        }
    }
}

/// Whether a value could be read, told with the parameter's name.
fn written<T>(name: &str, value: Result<T>) -> Result<()> {
    match value {
        Ok(_) => Ok(()),
        Err(error) => {
            let hint = error.hint().unwrap_or_default();
            Err(Error::invalid(format!("`{name}`: {error}"), hint))
        }
    }
}

/// Refuses every name that could write outside the output folder, on any system.
fn check_output_path(param: &str, path: &str) -> Result<()> {
    let refuse = |why: &str| {
        Err(Error::invalid(
            format!("`{param}` is `{}`, {why}", path.escape_debug()),
            "give a plain relative name such as `terrain.tif` or `maps/slope.png`",
        ))
    };
    if path.is_empty() || path.ends_with('/') {
        return refuse("which names no file");
    }
    if path.len() > 200 {
        return refuse("which is longer than 200 bytes");
    }
    if path.starts_with('/') || path.contains('\\') || path.contains(':') {
        return refuse("which is no relative path");
    }
    if path.chars().any(char::is_control) {
        return refuse("which holds a control character");
    }
    if path.split('/').any(|part| part.is_empty() || part == "." || part == "..") {
        return refuse("which could leave the output folder");
    }
    Ok(())
}

/// A curve through points with x ascending, linear between them and constant beyond.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve(pub Vec<[f64; 2]>);

impl Curve {
    /// The value at `x`.
    #[must_use]
    pub fn at(&self, x: f64) -> f64 {
        let points = &self.0;
        let after = points.partition_point(|point| point[0] <= x);
        match (after.checked_sub(1).and_then(|before| points.get(before)), points.get(after)) {
            (Some(a), Some(b)) => a[1] + (b[1] - a[1]) * ((x - a[0]) / (b[0] - a[0])),
            (Some(only), None) | (None, Some(only)) => only[1],
            (None, None) => 0.0,
        }
    }
}

impl<const N: usize> From<[[f64; 2]; N]> for Curve {
    fn from(points: [[f64; 2]; N]) -> Self {
        Self(points.to_vec())
    }
}

/// Polylines of (x, y, height).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lines(pub Vec<Vec<[f64; 3]>>);

impl From<Vec<Vec<[f64; 3]>>> for Lines {
    fn from(lines: Vec<Vec<[f64; 3]>>) -> Self {
        Self(lines)
    }
}

/// A file to read, as the graph names it. [`Job::input_path`](crate::Job::input_path) finds it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct InputPath(pub String);

impl From<&str> for InputPath {
    fn from(path: &str) -> Self {
        Self(path.into())
    }
}

/// A file to write, relative to the run's output folder. [`Job::create`](crate::Job::create) makes it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct OutputPath(pub String);

impl From<&str> for OutputPath {
    fn from(path: &str) -> Self {
        Self(path.into())
    }
}

type Limits = Option<(f64, f64)>;

fn whole(limits: Limits, fallback: (i64, i64)) -> (i64, i64) {
    limits.map_or(fallback, |(low, high)| (low as i64, high as i64))
}

macro_rules! integer_field {
    ($($ty:ty),*) => {$(
        impl ParamField for $ty {
            fn kind(range: Limits, slider: Limits) -> ParamKind {
                let range = whole(range, (0, 0));
                ParamKind::Integer { range, slider: whole(slider, range) }
            }
            fn to_value(&self) -> ParamValue {
                ParamValue::Integer(i64::try_from(*self).unwrap_or(i64::MAX))
            }
            fn from_value(value: &ParamValue) -> Option<Self> {
                match value {
                    ParamValue::Integer(i) => Self::try_from(*i).ok(),
                    _ => None,
                }
            }
        }
    )*};
}
integer_field!(i64, u32, u64);

impl ParamField for f64 {
    fn kind(range: Limits, slider: Limits) -> ParamKind {
        let range = range.unwrap_or((0.0, 0.0));
        ParamKind::Number { range, slider: slider.unwrap_or(range) }
    }
    fn to_value(&self) -> ParamValue {
        ParamValue::Number(*self)
    }
    fn from_value(value: &ParamValue) -> Option<Self> {
        match value {
            ParamValue::Number(x) => Some(*x),
            _ => None,
        }
    }
}

impl ParamField for bool {
    fn kind(_: Limits, _: Limits) -> ParamKind {
        ParamKind::Boolean
    }
    fn to_value(&self) -> ParamValue {
        ParamValue::Boolean(*self)
    }
    fn from_value(value: &ParamValue) -> Option<Self> {
        match value {
            ParamValue::Boolean(b) => Some(*b),
            _ => None,
        }
    }
}

macro_rules! text_field {
    ($($ty:ty, $kind:expr, $get:expr, $make:expr;)*) => {$(
        impl ParamField for $ty {
            fn kind(_: Limits, _: Limits) -> ParamKind {
                $kind
            }
            fn to_value(&self) -> ParamValue {
                let get: fn(&Self) -> &String = $get;
                ParamValue::Text(get(self).clone())
            }
            fn from_value(value: &ParamValue) -> Option<Self> {
                let make: fn(String) -> Self = $make;
                match value {
                    ParamValue::Text(text) => Some(make(text.clone())),
                    _ => None,
                }
            }
        }
    )*};
}
text_field! {
    String, ParamKind::Text, |text| text, |text| text;
    InputPath, ParamKind::InputPath, |path| &path.0, InputPath;
    OutputPath, ParamKind::OutputPath, |path| &path.0, OutputPath;
}

impl ParamField for Curve {
    /// `range` limits y and `slider` limits x; both are 0..=1 when left out.
    fn kind(range: Limits, slider: Limits) -> ParamKind {
        ParamKind::Curve { x: slider.unwrap_or((0.0, 1.0)), y: range.unwrap_or((0.0, 1.0)) }
    }
    fn to_value(&self) -> ParamValue {
        ParamValue::Curve(self.0.clone())
    }
    fn from_value(value: &ParamValue) -> Option<Self> {
        match value {
            ParamValue::Curve(points) => Some(Self(points.clone())),
            _ => None,
        }
    }
}

impl ParamField for Lines {
    fn kind(range: Limits, _: Limits) -> ParamKind {
        ParamKind::Lines { range: range.unwrap_or((-1e9, 1e9)) }
    }
    fn to_value(&self) -> ParamValue {
        ParamValue::Lines(self.0.clone())
    }
    fn from_value(value: &ParamValue) -> Option<Self> {
        match value {
            ParamValue::Lines(lines) => Some(Self(lines.clone())),
            _ => None,
        }
    }
}

/// Parameters of an older version of a node, by name: what [`Node::upgrade`](crate::Node::upgrade) lifts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RawParams(pub BTreeMap<String, ParamValue>);

impl RawParams {
    /// Moves a parameter to its new name; does nothing when the graph did not set it.
    pub fn rename(&mut self, old: &str, new: &str) {
        if let Some(value) = self.0.remove(old) {
            self.0.insert(new.into(), value);
        }
    }

    /// Takes a parameter out.
    pub fn remove(&mut self, name: &str) -> Option<ParamValue> {
        self.0.remove(name)
    }

    /// Sets a parameter.
    pub fn set(&mut self, name: &str, value: ParamValue) {
        self.0.insert(name.into(), value);
    }

    /// Multiplies a number, for a change of unit; does nothing when the graph did not set it.
    pub fn scale(&mut self, name: &str, factor: f64) {
        match self.0.get_mut(name) {
            Some(ParamValue::Number(x)) => *x *= factor,
            // A file may write a whole number without its point.
            Some(value) => {
                if let ParamValue::Integer(i) = *value {
                    *value = ParamValue::Number(i as f64 * factor);
                }
            }
            None => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_output_path_leaves_its_folder() {
        for good in ["a.tif", "maps/slope.png", "ä ö.png", "..a.png", "a..b"] {
            assert_eq!(check_output_path("file", good), Ok(()), "{good}");
        }
        for bad in ["", "/etc/passwd", "../a", "a/../../b", "C:\\x", "a\\b", "a//b", "a/", ".", "a\0b", "c:x"]
        {
            assert!(check_output_path("file", bad).is_err(), "{bad:?}");
        }
    }

    #[test]
    fn curves_interpolate_and_hold_their_ends() {
        let curve = Curve::from([[0.0, 1.0], [0.5, 3.0], [1.0, 0.0]]);
        for (x, y) in [(-1.0, 1.0), (0.0, 1.0), (0.25, 2.0), (0.5, 3.0), (0.75, 1.5), (1.0, 0.0), (9.0, 0.0)]
        {
            assert_eq!(curve.at(x), y, "at {x}");
        }
    }
}
