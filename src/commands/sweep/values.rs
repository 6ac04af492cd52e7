//! The values that a sweep gives its parameters.

use crate::failure::Failure;

/// A parameter and the values that it takes, as RON text.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Axis {
    pub(crate) name: String,
    pub(crate) values: Vec<String>,
}

impl Axis {
    /// Parses `name=v1,v2,v3` or `name=from..to/count`.
    pub(crate) fn parse(text: &str) -> Result<Self, Failure> {
        let wrong = |why: &str| {
            Failure::usage(format!("`--param {text}` {why}"), "write name=v1,v2,v3 or name=from..to/count")
        };
        let (name, values) = text.split_once('=').ok_or_else(|| wrong("has no `=`"))?;
        let values = match values.split_once("..") {
            Some((from, rest)) => {
                let (to, count) = rest.split_once('/').ok_or_else(|| wrong("has no count"))?;
                let number = |text: &str| text.trim().parse::<f64>().ok().filter(|x| x.is_finite());
                let ends =
                    number(from).zip(number(to)).ok_or_else(|| wrong("has an end that is no number"))?;
                let count = count.trim().parse::<usize>().ok().filter(|count| (2..=10_000).contains(count));
                steps(ends, count.ok_or_else(|| wrong("needs a count from 2 to 10000"))?)
            }
            None => split(values),
        };
        if values.is_empty() || values.iter().any(String::is_empty) {
            return Err(wrong("has an empty value"));
        }
        Ok(Self { name: name.trim().to_owned(), values })
    }
}

/// `count` numbers from one end to the other, both included.
fn steps((from, to): (f64, f64), count: usize) -> Vec<String> {
    (0..count)
        .map(|i| {
            let x = from + (to - from) * i as f64 / (count - 1) as f64;
            // Twelve digits tell values apart and hide what binary fractions add.
            let x: f64 = format!("{x:.12e}").parse().unwrap_or(x);
            x.to_string()
        })
        .collect()
}

/// Splits at the commas that stand outside brackets and quotes.
fn split(text: &str) -> Vec<String> {
    let (mut depth, mut quoted, mut start) = (0_i32, false, 0);
    let mut values = Vec::new();
    for (at, c) in text.char_indices() {
        match c {
            '"' => quoted = !quoted,
            '(' | '[' | '{' if !quoted => depth += 1,
            ')' | ']' | '}' if !quoted => depth -= 1,
            ',' if !quoted && depth == 0 => {
                values.push(text[start..at].trim().to_owned());
                start = at + 1;
            }
            _ => {}
        }
    }
    values.push(text[start..].trim().to_owned());
    values
}

/// Every combination, the last axis changing fastest.
pub(crate) fn combinations(axes: &[Axis]) -> Vec<Vec<(String, String)>> {
    let mut all = vec![Vec::new()];
    for axis in axes {
        all = all
            .into_iter()
            .flat_map(|head: Vec<(String, String)>| {
                axis.values.iter().map(move |value| {
                    let mut combination = head.clone();
                    combination.push((axis.name.clone(), value.clone()));
                    combination
                })
            })
            .collect();
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(text: &str) -> Vec<String> {
        Axis::parse(text).unwrap().values
    }

    #[test]
    fn lists_and_ranges_are_read() {
        assert_eq!(values("a=1,2 , x"), ["1", "2", "x"]);
        assert_eq!(values("a=[(0,1),(1,0)],\"b,c\""), ["[(0,1),(1,0)]", "\"b,c\""]);
        assert_eq!(values("a=0..0.3/4"), ["0", "0.1", "0.2", "0.3"]);
        assert_eq!(values("a=-1..1/3"), ["-1", "0", "1"]);
        for bad in ["a", "a=", "a=1,,2", "a=0..1", "a=0..x/3", "a=0..1/1"] {
            assert!(Axis::parse(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn the_last_axis_changes_fastest() {
        let axes = [Axis::parse("a=1,2").unwrap(), Axis::parse("b=x,y").unwrap()];
        let all: Vec<String> = combinations(&axes)
            .iter()
            .map(|combination| combination.iter().map(|(_, value)| value.as_str()).collect())
            .collect();
        assert_eq!(all, ["1x", "1y", "2x", "2y"]);
    }
}
