//! Whether a spec makes sense: what a derive cannot get wrong, and a spec that came as text can.

use std::collections::BTreeSet;

use crate::{NodeSpec, ParamKind, ParamSpec};

impl NodeSpec {
    /// What keeps the node from being used: names that are none or come twice, limits and defaults that do not go
    /// together. Empty for a sound spec.
    #[must_use]
    pub fn complaints(&self) -> Vec<String> {
        let mut complaints = Vec::new();
        let mut expect = |holds: bool, complaint: String| {
            if !holds {
                complaints.push(complaint);
            }
        };
        match self.id.split_once('.') {
            Some((family, algorithm)) => {
                let word = !family.is_empty() && family.chars().all(|c| c.is_ascii_lowercase());
                expect(word, format!("`{family}` is no family: give a lower-case word"));
                expect(is_snake_case(algorithm), format!("`{algorithm}` is not in snake case"));
            }
            None => expect(false, format!("the id `{}` has no dot: write family.algorithm", self.id)),
        }
        expect(self.version > 0, "its version is 0: count from 1".into());
        expect(!self.doc.trim().is_empty(), "it has no docs".into());
        expect(
            self.writes == self.outputs.is_empty(),
            "it must either write files or have outputs, and not both".into(),
        );
        let names = |names: Vec<&str>| {
            let mut seen = BTreeSet::new();
            let wrong = names.into_iter().filter_map(|name| match name {
                name if !is_snake_case(name) => Some(format!("the name `{name}` is not in snake case")),
                name if !seen.insert(name) => Some(format!("the name `{name}` comes twice")),
                _ => None,
            });
            wrong.collect::<Vec<_>>()
        };
        complaints.extend(names(self.inputs.iter().map(|port| port.name.as_ref()).collect()));
        complaints.extend(names(self.outputs.iter().map(|port| port.name.as_ref()).collect()));
        complaints.extend(names(self.params.iter().map(|param| param.name.as_ref()).collect()));
        complaints.extend(self.params.iter().flat_map(ParamSpec::complaints));
        complaints
    }
}

impl ParamSpec {
    /// What keeps the parameter from being used.
    fn complaints(&self) -> Vec<String> {
        let name = &self.name;
        let mut complaints = Vec::new();
        let limits = match &self.kind {
            ParamKind::Number { range, slider } => Some((*range, Some(*slider))),
            ParamKind::Integer { range, slider } => {
                let real = |(low, high): (i64, i64)| (low as f64, high as f64);
                Some((real(*range), Some(real(*slider))))
            }
            ParamKind::Curve { y, .. } => Some((*y, None)),
            ParamKind::Lines { range } => Some((*range, None)),
            ParamKind::Choice { options } => {
                if options.is_empty() {
                    complaints.push(format!("the choice `{name}` has no options"));
                }
                None
            }
            _ => None,
        };
        if let Some((range, slider)) = limits {
            let slider = slider.unwrap_or(range);
            if ![range.0, range.1, slider.0, slider.1].iter().all(|end| end.is_finite()) {
                complaints.push(format!("`{name}` has an infinite limit"));
            } else if range.0 >= range.1 {
                complaints.push(format!("`{name}` has an empty range"));
            } else if !(range.0 <= slider.0 && slider.0 < slider.1 && slider.1 <= range.1) {
                complaints.push(format!("`{name}` has a slider outside its range"));
            }
        }
        if let Err(error) = self.check(&self.default) {
            complaints.push(format!("the default of `{name}`: {error}"));
        }
        complaints
    }
}

fn is_snake_case(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_lowercase())
        && name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_')
}
