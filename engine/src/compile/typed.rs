//! Typed values out of what files and overrides write.

use orograph_core::{Error, ParamKind, ParamSpec, ParamValue};

use crate::{
    document::Literal,
    suggest::{list, suggest},
};

/// A value as it was given.
#[derive(Clone)]
pub(super) enum Given {
    /// As a file writes it.
    Literal(Literal),
    /// The text of an override.
    Bare(String),
    /// Out of a node's own upgrade.
    Lifted(ParamValue),
}

impl Given {
    /// The value that a node's upgrade gave: what kept name and value keeps its own text too, so that integers stay
    /// integers.
    pub(super) fn after_upgrade(before: Option<&Self>, value: ParamValue) -> Self {
        let kept = before.filter(|given| untyped(given).as_ref() == Some(&value));
        kept.cloned().unwrap_or(Self::Lifted(value))
    }
}

/// A message and what would mend it.
pub type Refused = (String, Option<String>);

/// The value that a parameter of this spec gets, inside its hard range.
pub(super) fn typed(given: &Given, spec: &ParamSpec) -> Result<ParamValue, Refused> {
    let value = match given {
        Given::Literal(literal) => literal_value(literal, spec)?,
        Given::Bare(text) => {
            let is_text = matches!(
                spec.kind,
                ParamKind::Text
                    | ParamKind::Choice { .. }
                    | ParamKind::InputPath
                    | ParamKind::OutputPath
                    | ParamKind::Colour
                    | ParamKind::Gradient
            );
            match Literal::parse(text) {
                Ok(literal @ Literal::Text(_)) => literal_value(&literal, spec)?,
                _ if is_text => ParamValue::Text(text.clone()),
                Ok(literal) => literal_value(&literal, spec)?,
                Err(message) => {
                    return Err((message, Some(format!("`{}` takes {}", spec.name, takes(spec)))));
                }
            }
        }
        Given::Lifted(value) => match (&spec.kind, value) {
            (ParamKind::Number { .. }, ParamValue::Integer(integer)) => ParamValue::Number(*integer as f64),
            (ParamKind::Integer { .. }, ParamValue::Number(number)) => {
                ParamValue::Integer(whole(*number).unwrap_or(i64::MAX))
            }
            _ => value.clone(),
        },
    };
    spec.check(&value).map_err(|error| (error.to_string(), hint(&error, spec, &value)))?;
    Ok(value)
}

/// What would mend a refused value: the nearest option where there is one.
fn hint(error: &Error, spec: &ParamSpec, value: &ParamValue) -> Option<String> {
    match (&spec.kind, value) {
        (ParamKind::Choice { options }, ParamValue::Text(text)) => {
            Some(suggest(text, options.iter().map(|option| &*option.name), "options"))
        }
        _ => error.hint(),
    }
}

fn takes(spec: &ParamSpec) -> String {
    match &spec.kind {
        ParamKind::Number { .. } => "a number".into(),
        ParamKind::Integer { .. } => "a whole number".into(),
        ParamKind::Boolean => "`true` or `false`".into(),
        ParamKind::Text => "a string".into(),
        ParamKind::Choice { options } => {
            format!("one of {}", list(options.iter().map(|option| &option.name)))
        }
        ParamKind::InputPath | ParamKind::OutputPath => "a path as a string".into(),
        ParamKind::Colour => "a colour, as in `\"#c83c28\"`".into(),
        ParamKind::Gradient => "a gradient, as in `\"0 #203040, 1 #ffffff\"`".into(),
        ParamKind::Curve { .. } => "a curve, as in `[(0.0, 0.0), (1.0, 1.0)]`".into(),
        ParamKind::Lines { .. } => "lines, as in `[[(x, y, height), (x, y, height)]]`".into(),
        _ => "another kind of value".into(),
    }
}

fn literal_value(literal: &Literal, spec: &ParamSpec) -> Result<ParamValue, Refused> {
    let value = match &spec.kind {
        ParamKind::Number { .. } => number(literal).map(ParamValue::Number),
        ParamKind::Integer { .. } => match literal {
            Literal::Integer(integer) => Some(ParamValue::Integer(*integer)),
            Literal::Number(number) => whole(*number).map(ParamValue::Integer),
            _ => None,
        },
        ParamKind::Boolean => match literal {
            Literal::Boolean(value) => Some(ParamValue::Boolean(*value)),
            _ => None,
        },
        ParamKind::Choice { .. } => match literal {
            Literal::Text(text) | Literal::Word(text) => Some(ParamValue::Text(text.clone())),
            _ => None,
        },
        ParamKind::Text
        | ParamKind::InputPath
        | ParamKind::OutputPath
        | ParamKind::Colour
        | ParamKind::Gradient => match literal {
            Literal::Text(text) => Some(ParamValue::Text(text.clone())),
            _ => None,
        },
        ParamKind::Curve { .. } => points(literal).map(ParamValue::Curve),
        ParamKind::Lines { .. } => lines(literal),
        _ => None,
    };
    value.ok_or_else(|| match literal {
        Literal::Other(raw) if raw.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c)) => {
            let raw: String = raw.chars().take(40).collect();
            (format!("`{}` is {raw}, which is more than a number can hold", spec.name), None)
        }
        _ => (format!("`{}` takes {}, not {}", spec.name, takes(spec), literal.noun()), None),
    })
}

fn number(literal: &Literal) -> Option<f64> {
    match literal {
        Literal::Number(number) => Some(*number),
        Literal::Integer(integer) => Some(*integer as f64),
        _ => None,
    }
}

/// A number without fraction as an integer, where it holds one exactly.
fn whole(number: f64) -> Option<i64> {
    (number.trunc() == number && number.abs() <= 9_007_199_254_740_992.0).then_some(number as i64)
}

fn items(literal: &Literal) -> Option<&[Literal]> {
    match literal {
        Literal::List(items) | Literal::Tuple(items) => Some(items),
        _ => None,
    }
}

fn point<const N: usize>(literal: &Literal) -> Option<[f64; N]> {
    let numbers: Option<Vec<_>> = items(literal)?.iter().map(number).collect();
    numbers?.try_into().ok()
}

fn points<const N: usize>(literal: &Literal) -> Option<Vec<[f64; N]>> {
    items(literal)?.iter().map(point).collect()
}

fn lines(literal: &Literal) -> Option<ParamValue> {
    Some(ParamValue::Lines(items(literal)?.iter().map(points).collect::<Option<_>>()?))
}

/// A value as its text alone tells its type, for parameters that the current spec may not have.
pub(super) fn untyped(given: &Given) -> Option<ParamValue> {
    let literal = match given {
        Given::Literal(literal) => literal.clone(),
        Given::Bare(text) => Literal::parse(text).unwrap_or_else(|_| Literal::Text(text.clone())),
        Given::Lifted(value) => return Some(value.clone()),
    };
    Some(match &literal {
        Literal::Boolean(value) => ParamValue::Boolean(*value),
        Literal::Integer(integer) => ParamValue::Integer(*integer),
        Literal::Number(number) => ParamValue::Number(*number),
        Literal::Text(text) | Literal::Word(text) => ParamValue::Text(text.clone()),
        Literal::List(_) => match points(&literal) {
            Some(points) => ParamValue::Curve(points),
            None => lines(&literal)?,
        },
        _ => return None,
    })
}
