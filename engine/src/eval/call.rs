//! The call of a node, fenced: a panic becomes its error, and what it gives is what its spec promises.

use std::{
    any::Any,
    panic::{AssertUnwindSafe, catch_unwind},
};

use orograph_core::{Error, Job, Slot, Value};

use crate::graph::{Action, GraphNode};

/// # Errors
/// What the node returns, [`Error::Panicked`], and [`Error::Invalid`] for outputs of other types than promised.
pub(super) fn call(node: &GraphNode, slots: &[Slot], job: &Job) -> Result<Vec<Value>, Error> {
    let Action::Run { node_type, instance, .. } = &node.action else {
        return Err(Error::invalid("this node type is unknown here", "install the plugin that supplies it"));
    };
    job.check()?;
    let values = catch_unwind(AssertUnwindSafe(|| instance.run(slots, job)))
        .unwrap_or_else(|panic| Err(Error::Panicked { message: panic_message(panic.as_ref()) }))?;
    let promised = &node_type.spec().outputs;
    let kept = values.len() == promised.len()
        && values.iter().zip(promised).all(|(value, port)| value.value_type() == port.value_type);
    if kept {
        return Ok(values);
    }
    Err(Error::invalid(
        "the node's outputs are not those that its spec declares",
        "report it to the node's author",
    ))
}

fn panic_message(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_else(|| "no message".into())
}
