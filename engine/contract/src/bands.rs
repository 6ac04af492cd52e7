//! What is made or written some rows at a time is what is made or written at once.

use orograph_core::{Band, Instance, Job, NodeType, Result, Slot, Value, rows_of};

use crate::{
    defaults,
    determinism::CONTEXT,
    host::MemoryHost,
    inputs::{Cover, digests, slots, terrain},
    needs_no_file,
};

/// A source gives in bands what it gives as a whole, and a writer writes the same file of bands.
#[must_use]
pub fn band_by_band(node: &NodeType) -> Vec<String> {
    if !needs_no_file(node) {
        return vec![];
    }
    let Ok(instance) = node.instantiate(&defaults(node)) else { return vec![] };
    let differs = |what: &str, equal: Result<bool>| match equal {
        Ok(true) => None,
        Ok(false) => Some(format!("{what} in bands differs from {what} at once")),
        Err(error) => Some(format!("{what} in bands fails: {error}")),
    };
    [1, 7, 32]
        .into_iter()
        .flat_map(|rows| {
            let made = differs("what it makes", same_made(node, instance.as_ref(), rows));
            let written = differs("what it writes", same_written(node, instance.as_ref(), rows));
            made.into_iter().chain(written)
        })
        .collect()
}

/// Whether bands of so many rows join to what a run gives; so for a node that gives none.
fn same_made(node: &NodeType, instance: &dyn Instance, rows: usize) -> Result<bool> {
    let host = MemoryHost::default();
    let job = Job::new(&host, CONTEXT);
    let Some(source) = instance.source(&job)? else { return Ok(true) };
    let unwired = vec![Slot::Empty; node.spec().inputs.len()];
    let all = source.grid().rows;
    let band = |first: usize| -> Result<Band> {
        Ok(Band { first, value: source.band(first, rows.min(all - first), &job)? })
    };
    let bands: Vec<Band> = (0..all).step_by(rows).map(band).collect::<Result<_>>()?;
    Ok(digests(&[rows_of(&bands, 0, all, &job)?]) == digests(&instance.run(&unwired, &job)?))
}

/// Whether a file written of bands of so many rows is the one written at once; so for a node that takes no bands.
fn same_written(node: &NodeType, instance: &dyn Instance, rows: usize) -> Result<bool> {
    if !instance.takes_bands() {
        return Ok(true);
    }
    let slots = slots(node.spec(), &terrain(70, 53, Cover::Holes), true);
    let whole: Vec<&Value> = slots
        .iter()
        .filter_map(|slot| match slot {
            Slot::One(value) => Some(value),
            _ => None,
        })
        .collect();
    let (&[whole], Some(grid)) = (whole.as_slice(), whole.first().and_then(|value| value.grid())) else {
        return Ok(false);
    };
    let (at_once, in_bands) = (MemoryHost::default(), MemoryHost::default());
    instance.run(&slots, &Job::new(&at_once, CONTEXT))?;
    let job = Job::new(&in_bands, CONTEXT);
    let mut sink = instance.sink(grid, &job)?;
    let all = [Band { first: 0, value: whole.clone() }];
    for first in (0..grid.rows).step_by(rows) {
        sink.take(&rows_of(&all, first, (first + rows).min(grid.rows), &job)?, &job)?;
    }
    sink.finish(&job)?;
    Ok(at_once.written() == in_bands.written())
}
