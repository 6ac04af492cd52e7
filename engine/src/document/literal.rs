//! Parameter values as a graph file writes them, before any spec gives them a type.

use std::fmt::Write;

use orograph_core::ParamValue;

use super::syntax::{Entry, Shape, Tree};

/// A value in a graph file.
#[derive(Clone, Debug, PartialEq)]
pub enum Literal {
    /// `true` or `false`.
    Boolean(bool),
    /// Digits without point or exponent.
    Integer(i64),
    /// A finite number with point or exponent.
    Number(f64),
    /// A string.
    Text(String),
    /// A bare word, such as the name of an option.
    Word(String),
    /// `[a, b]`
    List(Vec<Literal>),
    /// `(a, b)`
    Tuple(Vec<Literal>),
    /// `(a: 1, b: 2)`
    Fields(Vec<(String, Literal)>),
    /// `{a: 1, b: 2}`
    Map(Vec<(Literal, Literal)>),
    /// Anything else as it was written, such as a number too large to hold.
    Other(String),
}

impl Literal {
    /// Reads one value.
    ///
    /// # Errors
    /// Why it is none, as a sentence.
    pub fn parse(text: &str) -> Result<Self, String> {
        let tree = super::syntax::read(text).map_err(|error| error.message)?;
        Ok(Self::of(&tree, text))
    }

    pub(crate) fn of(tree: &Tree, text: &str) -> Self {
        let raw = &text[tree.span.clone()];
        let all = |items: &[Tree]| items.iter().map(|item| Self::of(item, text)).collect();
        match &tree.shape {
            Shape::Text(value) => Self::Text(value.clone()),
            Shape::Word => match raw {
                "true" => Self::Boolean(true),
                "false" => Self::Boolean(false),
                _ => Self::Word(raw.into()),
            },
            Shape::Number => Self::number(raw),
            Shape::List(items) => Self::List(all(items)),
            Shape::Tuple(items) => Self::Tuple(all(items)),
            Shape::Fields(entries) => {
                let field = |entry: &Entry| {
                    let name = entry.key.name(text).unwrap_or_default().to_owned();
                    (name, Self::of(&entry.value, text))
                };
                // A key that is no name makes the group unreadable; keep such a group as it is.
                if entries.iter().any(|entry| !matches!(entry.key.shape, Shape::Word)) {
                    return Self::Other(raw.into());
                }
                Self::Fields(entries.iter().map(field).collect())
            }
            Shape::Map(entries) => {
                let pair = |entry: &Entry| (Self::of(&entry.key, text), Self::of(&entry.value, text));
                Self::Map(entries.iter().map(pair).collect())
            }
            Shape::Other => Self::Other(raw.into()),
        }
    }

    fn number(raw: &str) -> Self {
        if let Ok(integer) = raw.parse().or_else(|_| ron::from_str(raw)) {
            return Self::Integer(integer);
        }
        let based = raw.trim_start_matches(['+', '-']).starts_with("0x");
        let fractional = !based && raw.contains(['.', 'e', 'E']);
        let number = raw.parse().or_else(|_| ron::from_str::<f64>(raw));
        match number {
            Ok(number) if fractional && number.is_finite() => Self::Number(number),
            _ => Self::Other(raw.into()),
        }
    }

    /// What this is, for messages.
    pub(crate) fn noun(&self) -> String {
        match self {
            Self::Boolean(value) => format!("`{value}`"),
            Self::Integer(_) => "an integer".into(),
            Self::Number(_) => "a number".into(),
            Self::Text(_) => "a string".into(),
            Self::Word(word) => format!("the bare word `{word}`"),
            Self::List(_) => "a list".into(),
            Self::Tuple(_) => "a tuple".into(),
            Self::Fields(_) => "a group of fields".into(),
            Self::Map(_) => "a map".into(),
            Self::Other(raw) => format!("`{}`", raw.chars().take(40).collect::<String>()),
        }
    }

    /// The value as RON on one line; reading it gives it back.
    #[must_use]
    pub fn to_ron(&self) -> String {
        let mut out = String::new();
        self.write(&mut out);
        out
    }

    fn write(&self, out: &mut String) {
        // Writing to a string cannot fail.
        let _ = match self {
            Self::Boolean(value) => write!(out, "{value}"),
            Self::Integer(value) => write!(out, "{value}"),
            Self::Number(value) => write!(out, "{value:?}"),
            Self::Text(text) => write!(out, "{}", quote(text)),
            Self::Word(raw) | Self::Other(raw) => write!(out, "{raw}"),
            Self::List(items) => return list(out, "[", items, "]", |out, item| item.write(out)),
            Self::Tuple(items) => return list(out, "(", items, ")", |out, item| item.write(out)),
            Self::Fields(fields) => {
                return list(out, "(", fields, ")", |out, (name, value)| {
                    out.push_str(name);
                    out.push_str(": ");
                    value.write(out);
                });
            }
            Self::Map(entries) => {
                return list(out, "{", entries, "}", |out, (key, value)| {
                    key.write(out);
                    out.push_str(": ");
                    value.write(out);
                });
            }
        };
    }
}

impl From<&ParamValue> for Literal {
    fn from(value: &ParamValue) -> Self {
        fn tuple(numbers: &[f64]) -> Literal {
            Literal::Tuple(numbers.iter().map(|number| Literal::Number(*number)).collect())
        }
        match value {
            ParamValue::Number(number) => Self::Number(*number),
            ParamValue::Integer(integer) => Self::Integer(*integer),
            ParamValue::Boolean(value) => Self::Boolean(*value),
            ParamValue::Text(text) => Self::Text(text.clone()),
            ParamValue::Curve(points) => Self::List(points.iter().map(|point| tuple(point)).collect()),
            ParamValue::Lines(lines) => {
                let line = |line: &Vec<[f64; 3]>| Self::List(line.iter().map(|point| tuple(point)).collect());
                Self::List(lines.iter().map(line).collect())
            }
        }
    }
}

fn list<T>(out: &mut String, open: &str, items: &[T], close: &str, each: impl Fn(&mut String, &T)) {
    out.push_str(open);
    for (index, item) in items.iter().enumerate() {
        if index > 0 {
            out.push_str(", ");
        }
        each(out, item);
    }
    out.push_str(close);
}

/// A string as RON writes it.
pub(crate) fn quote(text: &str) -> String {
    let mut out = String::with_capacity(text.len() + 2);
    out.push('"');
    for c in text.chars() {
        match c {
            '"' => out.push_str("\\\""),
            '\\' => out.push_str("\\\\"),
            '\n' => out.push_str("\\n"),
            '\r' => out.push_str("\\r"),
            '\t' => out.push_str("\\t"),
            c if c.is_control() => {
                let _ = write!(out, "\\u{{{:x}}}", u32::from(c));
            }
            c => out.push(c),
        }
    }
    out.push('"');
    out
}
