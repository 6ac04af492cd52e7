//! The extension `orograph.settings/1`: what a node knows of its settings without running.

use std::sync::Arc;

use orograph_abi::{
    OROGRAPH_FAILED, OROGRAPH_OK, OrographParam, OrographReply, OrographSettings, OrographText, read_text,
};
use orograph_core::{CellSize, Error, Instance, NodeType, RawParams, Result};

use crate::{
    entry::{Export, no_node, read_params},
    fence,
};

/// The plugin's table.
pub(crate) const fn table<E: Export>() -> &'static OrographSettings {
    const {
        &OrographSettings {
            size: size_of::<OrographSettings>() as u32,
            reserved: 0,
            check: Some(check::<E>),
            halo: Some(halo::<E>),
            cost: Some(cost::<E>),
            upgrade: Some(upgrade::<E>),
        }
    }
}

fn node_of<E: Export>(index: u32) -> Result<&'static NodeType> {
    E::plugin().nodes.get(index as usize).ok_or_else(|| no_node(index))
}

/// # Safety
/// `params` must lead to `count` parameters.
unsafe fn instance<E: Export>(
    node: u32,
    count: usize,
    params: *const OrographParam,
) -> Result<Arc<dyn Instance>> {
    // SAFETY: as the caller vouches.
    node_of::<E>(node)?.instantiate(&unsafe { read_params(count, params) }?)
}

unsafe extern "C" fn check<E: Export>(
    node: u32,
    count: usize,
    params: *const OrographParam,
    reply: *const OrographReply,
) -> i32 {
    // SAFETY: the host gives as many parameters as it says.
    let outcome = fence::guard(|| unsafe { instance::<E>(node, count, params) }.map(drop));
    // SAFETY: the host's reply is good until this returns.
    unsafe { answer(outcome.map(|checked| checked.map(|()| None)), reply) }
}

unsafe extern "C" fn halo<E: Export>(
    node: u32,
    count: usize,
    params: *const OrographParam,
    x: f64,
    y: f64,
) -> u64 {
    // SAFETY: the host gives as many parameters as it says.
    let halo = fence::guard(|| {
        unsafe { instance::<E>(node, count, params) }.map(|node| node.halo(CellSize { x, y }) as u64)
    });
    // A node that does not know looks at everything.
    halo.ok().and_then(Result::ok).unwrap_or(u64::from(u32::MAX))
}

unsafe extern "C" fn cost<E: Export>(node: u32, count: usize, params: *const OrographParam) -> f64 {
    // SAFETY: the host gives as many parameters as it says.
    let cost = fence::guard(|| unsafe { instance::<E>(node, count, params) }.map(|node| node.cost()));
    cost.ok().and_then(Result::ok).unwrap_or(1.0)
}

unsafe extern "C" fn upgrade<E: Export>(
    node: u32,
    from: u32,
    params: OrographText,
    reply: *const OrographReply,
) -> i32 {
    let outcome = fence::guard(|| {
        // SAFETY: the host's text is good until this returns.
        let text = unsafe { read_text(params) }.map_err(|error| unreadable(&error.0))?;
        let mut params = RawParams(ron::from_str(text).map_err(|error| unreadable(&error.to_string()))?);
        node_of::<E>(node)?.upgrade(&mut params, from)?;
        ron::to_string(&params.0).map(Some).map_err(|error| unreadable(&error.to_string()))
    });
    // SAFETY: the host's reply is good until this returns.
    unsafe { answer(outcome, reply) }
}

fn unreadable(why: &str) -> Error {
    Error::invalid(format!("the parameters of an older version are no map of values: {why}"), "report it")
}

/// Tells the host an outcome: an error, a panic, or new text where there is any.
///
/// # Safety
/// `reply` must be null or the host's.
unsafe fn answer(outcome: Result<Result<Option<String>>, String>, reply: *const OrographReply) -> i32 {
    let put = |text: &str, hint: &str| {
        // SAFETY: as the caller vouches; the host copies both texts before it returns.
        if let Some(reply) = unsafe { reply.as_ref() } {
            unsafe { (reply.put)(reply.context, OrographText::of(text), OrographText::of(hint)) };
        }
    };
    match outcome {
        Ok(Ok(text)) => {
            if let Some(text) = text {
                put(&text, "");
            }
            OROGRAPH_OK
        }
        Ok(Err(error)) => {
            put(&error.to_string(), &error.hint().unwrap_or_default());
            OROGRAPH_FAILED
        }
        Err(panic) => {
            let error = Error::Panicked { message: panic };
            put(&error.to_string(), &error.hint().unwrap_or_default());
            OROGRAPH_FAILED
        }
    }
}
