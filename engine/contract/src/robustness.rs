//! Nodes on tiny, void and ordinary terrain: outputs as declared, errors with a hint, never a panic.

use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    sync::{PoisonError, atomic::Ordering},
};

use orograph_core::{Context, Error, Job, NodeType, ParamKind, ParamValue, Value};

use crate::{
    defaults,
    host::MemoryHost,
    inputs::{Cover, slots, terrain},
    needs_no_file,
};

const CONTEXT: Context = Context { seed: 5, resolution: Some(24) };

/// How a run ended.
enum Ended {
    Well(Vec<Value>),
    /// With an error.
    Refused(Error),
    /// In a way that no node may end in.
    Badly(String),
}

fn run(
    node: &NodeType,
    values: &[ParamValue],
    host: &MemoryHost,
    size: (usize, usize),
    cover: Cover,
    all: bool,
) -> Ended {
    let slots = slots(node.spec(), &terrain(size.0, size.1, cover), all);
    let run = || node.instantiate(values)?.run(&slots, &Job::new(host, CONTEXT));
    match catch_unwind(AssertUnwindSafe(run)) {
        Ok(Ok(values)) => Ended::Well(values),
        Ok(Err(error @ (Error::Panicked { .. } | Error::Crashed { .. }))) => Ended::Badly(error.to_string()),
        Ok(Err(error)) => Ended::Refused(error),
        Err(_) => Ended::Badly("it panics".into()),
    }
}

/// What is wrong with how a run ended; an error is fine when it helps.
fn faults(node: &NodeType, ended: Ended, size: (usize, usize), what: &str) -> Vec<String> {
    match ended {
        Ended::Well(outputs) => {
            judge(node, &outputs, size).into_iter().map(|fault| format!("{what}: {fault}")).collect()
        }
        Ended::Refused(error) if error.hint().is_some() => vec![],
        Ended::Refused(error) => vec![format!("{what}: an error without hint: {error}")],
        Ended::Badly(how) => vec![format!("{what}: {how}")],
    }
}

/// What is wrong with the outputs, by the spec and the input's grid.
fn judge(node: &NodeType, outputs: &[Value], size: (usize, usize)) -> Vec<String> {
    let spec = node.spec();
    if outputs.len() != spec.outputs.len() {
        return vec![format!("{} outputs instead of {}", outputs.len(), spec.outputs.len())];
    }
    let mut complaints = Vec::new();
    for (port, value) in spec.outputs.iter().zip(outputs) {
        if value.value_type() != port.value_type {
            complaints.push(format!("`{}` carries a {}", port.name, value.value_type()));
        }
        let rasters_in = spec.inputs.iter().any(|input| input.value_type == port.value_type);
        if let Some(grid) = value.grid().filter(|grid| rasters_in && grid.size() == size)
            && grid.georef.is_none()
        {
            complaints.push(format!("`{}` lost its georeference", port.name));
        }
        if let Value::Mask(mask) = value
            && !mask.cells().iter().all(|share| (0.0..=1.0).contains(share))
        {
            complaints.push(format!("`{}` leaves 0..=1", port.name));
        }
        if let Value::Heightfield(field) = value
            && field.cells().iter().any(|height| height.is_infinite())
        {
            complaints.push(format!("`{}` holds an infinite height", port.name));
        }
    }
    complaints
}

/// On ordinary terrain the outputs are as the spec declares them.
#[must_use]
pub fn ordinary_terrain(node: &NodeType) -> Vec<String> {
    if node.spec().writes || !needs_no_file(node) {
        return vec![];
    }
    let covers = [(Cover::Whole, true), (Cover::Whole, false), (Cover::Holes, true)];
    let run = |(cover, all)| {
        let ended = run(node, &defaults(node), &MemoryHost::default(), (33, 29), cover, all);
        faults(node, ended, (33, 29), &format!("{cover:?}"))
    };
    covers.into_iter().flat_map(run).collect()
}

/// Tiny and void terrain gives outputs or an error that helps.
#[must_use]
pub fn odd_terrain(node: &NodeType) -> Vec<String> {
    if !needs_no_file(node) {
        return vec![];
    }
    let mut complaints = Vec::new();
    for size in [(0, 0), (0, 5), (1, 1), (1, 7), (2, 2), (9, 8)] {
        for cover in [Cover::Whole, Cover::Nothing] {
            let ended = run(node, &defaults(node), &MemoryHost::default(), size, cover, true);
            complaints.extend(faults(node, ended, size, &format!("{size:?} cells, {cover:?}")));
        }
    }
    complaints
}

/// Each setting at the ends of what it may be gives outputs or an error that helps.
#[must_use]
pub fn limits_of_settings(node: &NodeType) -> Vec<String> {
    if !needs_no_file(node) {
        return vec![];
    }
    let mut complaints = Vec::new();
    for (index, param) in node.spec().params.iter().enumerate() {
        let ends = match &param.kind {
            ParamKind::Number { range, .. } => [range.0, range.1].map(ParamValue::Number).to_vec(),
            ParamKind::Integer { range, .. } => [range.0, range.1].map(ParamValue::Integer).to_vec(),
            ParamKind::Boolean => [false, true].map(ParamValue::Boolean).to_vec(),
            ParamKind::Choice { options } => {
                options.iter().map(|option| ParamValue::Text(option.name.to_string())).collect()
            }
            ParamKind::Colour => ["#00000000", "#ffffff"].map(|text| ParamValue::Text(text.into())).to_vec(),
            ParamKind::Gradient => ["", "0.5 #00000000", "0 #000000, 1 #ffffff"]
                .map(|text| ParamValue::Text(text.into()))
                .to_vec(),
            ParamKind::Text => ["", "\u{0}", "näher"].map(|text| ParamValue::Text(text.into())).to_vec(),
            _ => continue,
        };
        for end in ends {
            let what = format!("`{}` at {end:?}", param.name);
            let mut values = defaults(node);
            values[index] = end;
            let ended = run(node, &values, &MemoryHost::default(), (33, 29), Cover::Holes, true);
            complaints.extend(faults(node, ended, (33, 29), &what));
        }
    }
    complaints
}

/// A cancelled run ends as cancelled.
#[must_use]
pub fn cancelled_run(node: &NodeType) -> Vec<String> {
    if !needs_no_file(node) || !node.spec().inputs.iter().any(|port| is_raster(port.value_type)) {
        return vec![];
    }
    let host = MemoryHost::default();
    host.cancelled.store(true, Ordering::Relaxed);
    match run(node, &defaults(node), &host, (64, 64), Cover::Whole, true) {
        Ended::Refused(Error::Cancelled) => vec![],
        Ended::Refused(other) => vec![format!("cancelled, it fails with another error: {other}")],
        Ended::Well(_) => vec!["cancelled, it completes: ask the host whether to stop".into()],
        Ended::Badly(how) => vec![how],
    }
}

fn is_raster(of: orograph_core::ValueType) -> bool {
    use orograph_core::ValueType::{Heightfield, Mask, Texture};
    matches!(of, Heightfield | Mask | Texture)
}

/// A writer writes one whole file, or says why not.
#[must_use]
pub fn writers(node: &NodeType) -> Vec<String> {
    if !node.spec().writes || !needs_no_file(node) {
        return vec![];
    }
    let host = MemoryHost::default();
    let ended = run(node, &defaults(node), &host, (33, 29), Cover::Whole, true);
    let files = host.files.lock().unwrap_or_else(PoisonError::into_inner);
    match ended {
        Ended::Well(_) if files.values().any(|bytes| !bytes.is_empty()) => vec![],
        Ended::Well(_) => vec!["it writes nothing and is content".into()],
        Ended::Refused(error) if error.hint().is_some() && files.is_empty() => vec![],
        Ended::Refused(error) => vec![format!("an error without hint, or after a file: {error}")],
        Ended::Badly(how) => vec![how],
    }
}
