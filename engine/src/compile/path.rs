//! Paths of files to read, as graphs write them.

use std::path::{Path, PathBuf};

/// How variables begin that graphs see. What else the environment holds, such as passwords, is none of the business of a
/// graph, which may come from anyone: it would end up in messages, or on its way to another machine.
const SEEN: &str = "OROGRAPH_";

/// Why a path in a graph names no file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PathError {
    /// A variable has no value, and the path gives it none.
    #[error("`{path}` needs the variable {name}, which is not set")]
    Unset {
        /// The path as written.
        path: String,
        /// The variable.
        name: String,
    },
    /// A variable that graphs do not see.
    #[error("`{path}` asks for the variable {name}, and graphs see only those that begin with {SEEN}")]
    Hidden {
        /// The path as written.
        path: String,
        /// The variable.
        name: String,
    },
    /// A `${` is no variable.
    #[error("`{path}`: {reason}")]
    Malformed {
        /// The path as written.
        path: String,
        /// What is wrong.
        reason: &'static str,
    },
}

impl PathError {
    /// What would mend it.
    #[must_use]
    pub fn hint(&self) -> String {
        match self {
            Self::Unset { name, .. } => {
                format!("set {name}, or give a default in the graph: `${{{name}:-folder}}`")
            }
            Self::Hidden { name, .. } => {
                format!("set {SEEN}{name} and write `${{{SEEN}{name}}}`, or write the path out")
            }
            Self::Malformed { .. } => "write `${NAME}` or `${NAME:-default}`".into(),
        }
    }
}

/// The file that `text` names in a graph of the folder `base_dir`.
///
/// `${NAME}` stands for a variable, one whose name begins with `OROGRAPH_`, and `${NAME:-default}` gives it a default, for
/// when it is unset or empty. A relative default starts, as every relative path, from the graph's folder. A path that begins with a
/// variable's value is the user's own: when relative, it starts from the working folder.
///
/// # Errors
/// A variable without value, or that graphs do not see, or a `${` that is no variable.
pub fn expand_path(
    text: &str,
    base_dir: &Path,
    variable: &dyn Fn(&str) -> Option<String>,
) -> Result<PathBuf, PathError> {
    let malformed = |reason| PathError::Malformed { path: text.into(), reason };
    let mut expanded = String::new();
    let mut rest = text;
    // A path that starts with the user's own value is the user's path.
    let mut is_users = false;
    while let Some(start) = rest.find("${") {
        expanded.push_str(&rest[..start]);
        let inside = &rest[start + 2..];
        let Some(end) = inside.find('}') else { return Err(malformed("a `${` has no `}`")) };
        let (name, default) = match inside[..end].split_once(":-") {
            Some((name, default)) => (name, Some(default)),
            None => (&inside[..end], None),
        };
        if name.is_empty() || !name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
            return Err(malformed("a variable's name has letters, digits and `_` alone"));
        }
        if !name.starts_with(SEEN) {
            return Err(PathError::Hidden { path: text.into(), name: name.into() });
        }
        match (variable(name).filter(|value| !value.is_empty()), default) {
            (Some(value), _) => {
                is_users |= expanded.is_empty();
                expanded.push_str(&value);
            }
            (None, Some(default)) => expanded.push_str(default),
            (None, None) => return Err(PathError::Unset { path: text.into(), name: name.into() }),
        }
        rest = &inside[end + 1..];
    }
    expanded.push_str(rest);
    Ok(if is_users { PathBuf::from(expanded) } else { base_dir.join(expanded) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variables_defaults_and_folders() {
        let variable = |name: &str| match name {
            "OROGRAPH_DEM" => Some("/dems".to_owned()),
            "OROGRAPH_NEAR" => Some("near".to_owned()),
            "OROGRAPH_EMPTY" => Some(String::new()),
            _ => None,
        };
        let expand = |text| expand_path(text, Path::new("graphs"), &variable);
        for (text, path) in [
            ("data/x.tif", "graphs/data/x.tif"),
            ("../x.tif", "graphs/../x.tif"),
            ("/abs/x.tif", "/abs/x.tif"),
            ("${OROGRAPH_DEM}/x.tif", "/dems/x.tif"),
            ("${OROGRAPH_DEM:-../dem}/x.tif", "/dems/x.tif"),
            ("${OROGRAPH_NEAR}/x.tif", "near/x.tif"),
            ("data/${OROGRAPH_NEAR}.tif", "graphs/data/near.tif"),
            ("${OROGRAPH_UNSET:-../dem}/x.tif", "graphs/../dem/x.tif"),
            ("${OROGRAPH_EMPTY:-../dem}/x.tif", "graphs/../dem/x.tif"),
            ("${OROGRAPH_UNSET:-}x.tif", "graphs/x.tif"),
            ("a$b{c}.tif", "graphs/a$b{c}.tif"),
        ] {
            assert_eq!(expand(text), Ok(PathBuf::from(path)), "{text}");
        }
        let unset = PathError::Unset { path: "${OROGRAPH_UNSET}/x".into(), name: "OROGRAPH_UNSET".into() };
        assert_eq!(expand("${OROGRAPH_UNSET}/x"), Err(unset));
        for malformed in ["${OROGRAPH_DEM", "${}", "${a b}", "x/${OROGRAPH_DEM:-"] {
            assert!(matches!(expand(malformed), Err(PathError::Malformed { .. })), "{malformed}");
        }
        // Not even to be passed over for a default.
        for hidden in ["${HOME}/x", "x/${TOKEN}", "${TOKEN:-x}"] {
            let error = expand(hidden).unwrap_err();
            assert!(
                matches!(error, PathError::Hidden { .. }) && error.hint().contains("OROGRAPH_"),
                "{hidden}"
            );
        }
    }
}
