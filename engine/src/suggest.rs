//! What errors say of names that there are.

use crate::registry::nearest;

/// Names in a sentence; the first of many.
pub(crate) fn list<T: AsRef<str>>(names: impl IntoIterator<Item = T>) -> String {
    const MOST: usize = 24;
    let mut names: Vec<_> = names.into_iter().map(|name| format!("`{}`", name.as_ref())).collect();
    if names.len() > MOST {
        let more = names.len() - MOST;
        names.truncate(MOST);
        names.push(format!("and {more} more"));
    }
    if names.is_empty() { "none".into() } else { names.join(", ") }
}

/// `did you mean`, or what there is.
pub(crate) fn suggest<'n>(name: &str, known: impl IntoIterator<Item = &'n str>, what: &str) -> String {
    /// Comparing with more names than this takes time, and such a graph was written by a machine.
    const MOST: usize = 5000;
    let known: Vec<_> = known.into_iter().collect();
    match nearest(name, known.iter().copied().take(MOST)) {
        Some(near) => format!("did you mean `{near}`?"),
        None if known.is_empty() => format!("it has no {what}"),
        None => format!("its {what}: {}", list(known)),
    }
}
