//! Nodes on tiny, void and ordinary terrain: outputs as declared, errors with a hint, never a panic.

use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    sync::atomic::Ordering,
};

use orograph_core::{Context, Error, Job, NodeType, Result, Value};

use crate::{
    defaults,
    host::MemoryHost,
    inputs::{Cover, grid_of, slots, terrain},
    needs_no_file, sweep,
};

const CONTEXT: Context = Context { seed: 5, resolution: Some(24) };

/// One run at defaults. `None` when it panicked.
fn run(
    node: &NodeType,
    host: &MemoryHost,
    size: (usize, usize),
    cover: Cover,
    all: bool,
) -> Option<Result<Vec<Value>>> {
    let field = terrain(size.0, size.1, cover);
    let slots = slots(node.spec(), &field, all);
    let instance = node.instantiate(&defaults(node)).unwrap();
    catch_unwind(AssertUnwindSafe(|| instance.run(&slots, &Job::new(host, CONTEXT)))).ok()
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
        if let Some(grid) = grid_of(value).filter(|grid| rasters_in && grid.size() == size)
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

#[test]
fn ordinary_terrain_gives_what_the_spec_declares() {
    sweep(|node| {
        if node.spec().writes || !needs_no_file(node) {
            return vec![];
        }
        let mut complaints = Vec::new();
        for (cover, all) in [(Cover::Whole, true), (Cover::Whole, false), (Cover::Holes, true)] {
            match run(node, &MemoryHost::default(), (33, 29), cover, all) {
                None => complaints.push(format!("it panics ({cover:?})")),
                Some(Ok(outputs)) => complaints.extend(judge(node, &outputs, (33, 29))),
                Some(Err(error)) if error.hint().is_some() => {}
                Some(Err(error)) => complaints.push(format!("an error without hint ({cover:?}): {error}")),
            }
        }
        complaints
    });
}

#[test]
fn tiny_and_void_terrain_never_panics() {
    sweep(|node| {
        if !needs_no_file(node) {
            return vec![];
        }
        let mut complaints = Vec::new();
        for size in [(0, 0), (0, 5), (1, 1), (1, 7), (2, 2), (9, 8)] {
            for cover in [Cover::Whole, Cover::Nothing] {
                match run(node, &MemoryHost::default(), size, cover, true) {
                    None => complaints.push(format!("it panics on {size:?} cells ({cover:?})")),
                    Some(Ok(outputs)) => complaints.extend(judge(node, &outputs, size)),
                    Some(Err(error)) if error.hint().is_some() => {}
                    Some(Err(error)) => complaints.push(format!("{size:?}: an error without hint: {error}")),
                }
            }
        }
        complaints
    });
}

#[test]
fn a_cancelled_run_ends_as_cancelled() {
    sweep(|node| {
        if !needs_no_file(node) || !node.spec().inputs.iter().any(|port| is_raster(port.value_type)) {
            return vec![];
        }
        let host = MemoryHost::default();
        host.cancelled.store(true, Ordering::Relaxed);
        match run(node, &host, (64, 64), Cover::Whole, true) {
            Some(Err(Error::Cancelled)) => vec![],
            Some(Err(other)) => vec![format!("it fails with another error: {other}")],
            Some(Ok(_)) => vec!["it completes".into()],
            None => vec!["it panics".into()],
        }
    });
}

fn is_raster(of: orograph_core::ValueType) -> bool {
    use orograph_core::ValueType::{Heightfield, Mask, Texture};
    matches!(of, Heightfield | Mask | Texture)
}

#[test]
fn writers_write_one_whole_file_or_say_why_not() {
    sweep(|node| {
        if !node.spec().writes || !needs_no_file(node) {
            return vec![];
        }
        let host = MemoryHost::default();
        let result = run(node, &host, (33, 29), Cover::Whole, true);
        let files = host.files.lock().unwrap();
        match result {
            Some(Ok(_)) if files.values().any(|bytes| !bytes.is_empty()) => vec![],
            Some(Ok(_)) => vec!["it writes nothing and is content".into()],
            Some(Err(error)) if error.hint().is_some() && files.is_empty() => vec![],
            Some(Err(error)) => vec![format!("an error without hint, or after a file: {error}")],
            None => vec!["it panics".into()],
        }
    });
}
