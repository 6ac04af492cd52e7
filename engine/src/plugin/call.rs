//! Calls into a plugin that is loaded in this process.

use std::{
    collections::BTreeMap,
    ffi::c_void,
    ptr,
    sync::{Mutex, PoisonError},
};

use orograph_abi::{
    Cells, Lender, OROGRAPH_CANCELLED, OROGRAPH_FAILED, OROGRAPH_OK, OROGRAPH_PANICKED, OrographJob,
    OrographReply, OrographText, read_text,
};
use orograph_core::{CellSize, Error, Job, ParamValue, RawParams, Result, Slot, Value};

use super::{
    host::{HOST, defect},
    library::Library,
    live::{self, Keep, Running},
};

impl Library {
    /// Runs a node: what it gives, in its spec's order.
    pub(super) fn run(
        &self,
        node: u32,
        params: &[ParamValue],
        slots: &[Slot],
        job: &Job,
    ) -> Result<Vec<Value>> {
        let values = Values(Mutex::new(BTreeMap::new()));
        self.run_into(node, params, slots, job, &values)?;
        let values = values.0.into_inner().unwrap_or_else(PoisonError::into_inner);
        Ok(values.into_values().collect())
    }

    /// Runs a node, whose outputs go to `keeper`, each once.
    pub(super) fn run_into(
        &self,
        node: u32,
        params: &[ParamValue],
        slots: &[Slot],
        job: &Job,
        keeper: &dyn Keep,
    ) -> Result<()> {
        let (Some(run), Some(spec)) = (self.entry.run, self.spec.nodes.get(node as usize)) else {
            return Err(defect("the plugin has no such node"));
        };
        let entered = live::enter(Running { job: *job, ports: &spec.outputs, keeper });
        let mut lender = Lender::new();
        let params = lender.params(params);
        let inputs = lender.inputs(slots);
        let view = OrographJob {
            size: size_of::<OrographJob>() as u32,
            node,
            id: entered.id,
            host: ptr::from_ref(&HOST),
            param_count: params.len(),
            params: params.as_ptr(),
            input_count: inputs.len(),
            inputs: inputs.as_ptr(),
            seed: job.seed(),
            resolution: job.resolution().unwrap_or(0),
            reserved: 0,
            memory_limit: job.memory_limit(),
        };
        // SAFETY: the view and all that it points to live until the call returns.
        let status = unsafe { run(&view) };
        let state = entered.leave();
        match status {
            // An output that was refused is a failure, whatever the node makes of it.
            OROGRAPH_OK => state.failure.map_or(Ok(()), Err)?,
            OROGRAPH_CANCELLED => {
                job.check()?;
                let unasked = || defect("the node says that it was cancelled, but it was not");
                return Err(state.failure.unwrap_or_else(unasked));
            }
            OROGRAPH_FAILED => {
                return Err(state.failure.unwrap_or_else(|| defect("the node failed and did not say why")));
            }
            OROGRAPH_PANICKED => {
                let message = state.failure.map_or_else(|| "no message".into(), |error| error.to_string());
                return Err(Error::Panicked { message });
            }
            other => {
                return Err(defect(format!("the node returned {other}, which ABI 1 has no meaning for")));
            }
        }
        match spec.outputs.iter().zip(&state.given).find(|(_, given)| !**given) {
            Some((port, _)) => Err(defect(format!("the node gave no output `{}`", port.name))),
            None => Ok(()),
        }
    }

    /// Whether settings go together.
    pub(super) fn check(&self, node: u32, params: &[ParamValue]) -> Result<()> {
        let Some(check) = self.settings.and_then(|settings| settings.check) else { return Ok(()) };
        let mut lender = Lender::new();
        let params = lender.params(params);
        let mut answer = Answer::default();
        // SAFETY: what is lent lives until the call returns.
        let status = unsafe { check(node, params.len(), params.as_ptr(), &answer.reply()) };
        if status == OROGRAPH_OK { Ok(()) } else { Err(answer.error()) }
    }

    /// The halo of a local node.
    pub(super) fn halo(&self, node: u32, params: &[ParamValue], cell: CellSize) -> usize {
        let Some(halo) = self.settings.and_then(|settings| settings.halo) else { return 0 };
        let mut lender = Lender::new();
        let params = lender.params(params);
        // SAFETY: as above.
        let cells = unsafe { halo(node, params.len(), params.as_ptr(), cell.x, cell.y) };
        usize::try_from(cells).unwrap_or(usize::MAX)
    }

    /// Rough work per cell.
    pub(super) fn cost(&self, node: u32, params: &[ParamValue]) -> f64 {
        let Some(cost) = self.settings.and_then(|settings| settings.cost) else { return 1.0 };
        let mut lender = Lender::new();
        let params = lender.params(params);
        // SAFETY: as above.
        let cost = unsafe { cost(node, params.len(), params.as_ptr()) };
        if cost.is_finite() { cost.clamp(0.0, 1e9) } else { 1.0 }
    }

    /// Lifts parameters of an older version.
    pub(super) fn upgrade(&self, node: u32, from: u32, params: &mut RawParams) -> Result<()> {
        let Some(upgrade) = self.settings.and_then(|settings| settings.upgrade) else { return Ok(()) };
        let text = ron::to_string(&params.0).map_err(|error| defect(error.to_string()))?;
        let mut answer = Answer::default();
        // SAFETY: as above.
        let status = unsafe { upgrade(node, from, OrographText::of(&text), &answer.reply()) };
        if status != OROGRAPH_OK {
            return Err(answer.error());
        }
        let lifted = ron::from_str(&answer.text);
        params.0 =
            lifted.map_err(|error| defect(format!("the lifted parameters are no RON map: {error}")))?;
        Ok(())
    }
}

/// Outputs as values, by port.
struct Values(Mutex<BTreeMap<usize, Value>>);

impl Keep for Values {
    fn cells(&self) -> Cells {
        Cells::Copied
    }
    fn keep(&self, port: usize, value: Value) -> Result<()> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).insert(port, value);
        Ok(())
    }
}

/// What a plugin answers to a question about settings.
#[derive(Default)]
struct Answer {
    text: String,
    hint: String,
}

impl Answer {
    fn reply(&mut self) -> OrographReply {
        OrographReply { context: ptr::from_mut(self).cast(), put }
    }

    fn error(self) -> Error {
        if self.text.is_empty() {
            return defect("the node refused its settings and did not say why");
        }
        Error::invalid(self.text, self.hint)
    }
}

unsafe extern "C" fn put(context: *mut c_void, text: OrographText, hint: OrographText) {
    if context.is_null() {
        return;
    }
    // SAFETY: the plugin hands back the context of the reply that it was given, before it returns.
    let answer = unsafe { &mut *context.cast::<Answer>() };
    // SAFETY: the texts stay until this returns.
    let read = |text| unsafe { read_text(text) }.map_or_else(|malformed| malformed.0, str::to_owned);
    (answer.text, answer.hint) = (read(text), read(hint));
}
