//! The functions of the exported struct.

use std::{
    ffi::{CStr, c_char, c_void},
    ptr,
    sync::Arc,
};

use orograph_abi::{
    Cells, Lender, Malformed, OROGRAPH_ABI_MAJOR, OROGRAPH_ABI_MINOR, OROGRAPH_CANCELLED, OROGRAPH_FAILED,
    OROGRAPH_OK, OROGRAPH_PANICKED, OrographInput, OrographJob, OrographPlugin, OrographText, PluginSpec,
    SETTINGS, read_param, read_value,
};
use orograph_core::{Arity, Context, Error, Job, NodeType, ParamValue, PortSpec, Result, Slot, Value};

use crate::{fence, host::Caller, pool, settings};

/// A plugin's nodes and what it says of them.
pub struct Plugin {
    pub(crate) nodes: Vec<NodeType>,
    spec: String,
}

/// What [`export!`](crate::export) implements.
pub trait Export {
    /// The plugin, made on the first call.
    fn plugin() -> &'static Plugin;
}

/// A plugin from what [`export!`](crate::export) is given.
#[must_use]
pub fn describe(name: &str, version: &str, nodes: Vec<NodeType>) -> Plugin {
    let spec = PluginSpec {
        name: name.into(),
        version: version.into(),
        nodes: nodes.iter().map(|node| node.spec().clone()).collect(),
    };
    // Plain data is always written; a host refuses a plugin that says nothing.
    Plugin { nodes, spec: ron::to_string(&spec).unwrap_or_default() }
}

/// The struct that a plugin exports.
#[must_use]
pub const fn plugin<E: Export>() -> OrographPlugin {
    OrographPlugin {
        size: size_of::<OrographPlugin>() as u32,
        abi_major: OROGRAPH_ABI_MAJOR,
        abi_minor: OROGRAPH_ABI_MINOR,
        reserved: 0,
        describe: Some(describe_entry::<E>),
        run: Some(run_entry::<E>),
        extension: Some(extension_entry::<E>),
    }
}

unsafe extern "C" fn describe_entry<E: Export>() -> OrographText {
    fence::guard(E::plugin).map_or(OrographText::EMPTY, |plugin| OrographText::of(&plugin.spec))
}

unsafe extern "C" fn extension_entry<E: Export>(name: *const c_char) -> *const c_void {
    if name.is_null() {
        return ptr::null();
    }
    // SAFETY: the host gives a terminated name.
    if unsafe { CStr::from_ptr(name) } == SETTINGS {
        ptr::from_ref(settings::table::<E>()).cast()
    } else {
        ptr::null()
    }
}

unsafe extern "C" fn run_entry<E: Export>(job: *const OrographJob) -> i32 {
    // SAFETY: the host keeps the job, and what it points to, until this returns; every host of this major version
    // has the fields that were there in its first minor one.
    let Some((job, caller)) = (unsafe { job.as_ref() }).and_then(|job| Some((job, Caller::of(job)?))) else {
        return OROGRAPH_FAILED;
    };
    // Outside the fence: a panic must not hide that an input was kept.
    let mut slots = Vec::new();
    let outcome = fence::guard(|| {
        let plugin = E::plugin();
        let node = plugin.nodes.get(job.node as usize).ok_or_else(|| no_node(job.node))?;
        // SAFETY: the views are good until this function returns, and `given_back` sees to it that no input is
        // looked at later.
        slots = unsafe { read_inputs(job, &node.spec().inputs) }?;
        // SAFETY: as above.
        let params = unsafe { read_params(job.param_count, job.params) }?;
        run(node, &params, &slots, job, &caller)
    });
    if !given_back(slots) {
        let message = "the plugin kept an input after the end of its run; what it points to will go away";
        caller.fail(message, "borrow inputs, or copy what has to stay");
        caller.abort(message);
    }
    match outcome {
        Ok(Ok(())) => OROGRAPH_OK,
        Ok(Err(Failure::Told)) => OROGRAPH_FAILED,
        Ok(Err(Failure::Of(Error::Cancelled))) => OROGRAPH_CANCELLED,
        Ok(Err(Failure::Of(error))) => {
            caller.fail(&error.to_string(), &error.hint().unwrap_or_default());
            OROGRAPH_FAILED
        }
        Err(panic) => {
            caller.fail(&panic, "");
            OROGRAPH_PANICKED
        }
    }
}

/// Why a run failed.
enum Failure {
    Of(Error),
    /// The host refused an output and knows why.
    Told,
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Self::Of(error)
    }
}

fn run(
    node: &NodeType,
    params: &[ParamValue],
    slots: &[Slot],
    job: &OrographJob,
    caller: &Caller<'_>,
) -> Result<(), Failure> {
    let instance = node.instantiate(params)?;
    let context = Context { seed: job.seed, resolution: (job.resolution != 0).then_some(job.resolution) };
    let outputs = pool::run(caller.threads(), || instance.run(slots, &Job::new(caller, context)))?;
    for (port, value) in outputs.iter().enumerate() {
        let mut lender = Lender::new();
        if !caller.output(port, &lender.value(value)) {
            return Err(Failure::Told);
        }
    }
    Ok(())
}

pub(crate) fn no_node(index: u32) -> Error {
    Error::invalid(
        format!("the plugin has no node of index {index}"),
        "load the plugin again: it was built anew",
    )
}

fn broken(what: Malformed) -> Error {
    Error::invalid(
        format!("the host gave what the plugin cannot read: {}", what.0),
        "report it with the graph",
    )
}

/// # Safety
/// `params` must lead to `count` parameters.
pub(crate) unsafe fn read_params(
    count: usize,
    params: *const orograph_abi::OrographParam,
) -> Result<Vec<ParamValue>> {
    // SAFETY: as the caller vouches.
    let params = unsafe { list(params, count) };
    // SAFETY: as the caller vouches.
    params.iter().map(|param| unsafe { read_param(param) }.map_err(broken)).collect()
}

/// # Safety
/// The job's inputs must be good until the slots are dropped.
unsafe fn read_inputs(job: &OrographJob, ports: &[PortSpec]) -> Result<Vec<Slot>> {
    // SAFETY: as the caller vouches.
    let inputs: &[OrographInput] = unsafe { list(job.inputs, job.input_count) };
    if inputs.len() != ports.len() {
        return Err(Error::PortCount { expected: ports.len(), found: inputs.len() });
    }
    let slots = inputs.iter().zip(ports).map(|(input, port)| {
        // SAFETY: as the caller vouches.
        let views = unsafe { list(input.values, input.count) };
        // SAFETY: as the caller vouches.
        let values = views.iter().map(|view| unsafe { read_value(view, Cells::Lent) }.map_err(broken));
        let mut values = values.collect::<Result<Vec<_>>>()?;
        Ok(match (port.arity, values.len()) {
            (Arity::Many, _) => Slot::Many(values),
            (_, 1) => values.pop().map_or(Slot::Empty, Slot::One),
            (Arity::Optional, 0) => Slot::Empty,
            _ => return Err(Error::InputType { name: port.name.to_string() }),
        })
    });
    slots.collect()
}

/// # Safety
/// Where `count` is not 0, `place` must lead to so many items for `'a`.
unsafe fn list<'a, T>(place: *const T, count: usize) -> &'a [T] {
    if count == 0 || place.is_null() {
        return &[];
    }
    // SAFETY: as the caller vouches.
    unsafe { std::slice::from_raw_parts(place, count) }
}

/// Whether nobody but `slots` holds any input: then nothing reads their cells from here on.
fn given_back(slots: Vec<Slot>) -> bool {
    fn sole<T>(mut value: Arc<T>) -> bool {
        Arc::get_mut(&mut value).is_some()
    }
    let values = slots.into_iter().flat_map(|slot| match slot {
        Slot::Empty => Vec::new(),
        Slot::One(value) => vec![value],
        Slot::Many(values) => values,
    });
    values.fold(true, |all, value| {
        all & match value {
            Value::Heightfield(raster) => sole(raster),
            Value::Mask(raster) => sole(raster),
            Value::Texture(raster) => sole(raster),
            // The rest was copied.
            _ => true,
        }
    })
}
