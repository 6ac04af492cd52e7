//! Where processes of their own are not to be had yet.

use std::{io, path::PathBuf};

use orograph_core::{CellSize, Error, Job, NodeSpec, ParamValue, RawParams, Result, Slot, Value};

use super::Limits;
use crate::plugin::{node::Calls, program::Program};

pub(in crate::plugin) struct Workers;

fn refusal<T>() -> Result<T> {
    Err(Error::invalid("plugins run apart on Unix systems alone", "run it without `--isolate`"))
}

impl Workers {
    pub(in crate::plugin) fn new(_: PathBuf, _: Program, _: Limits) -> Self {
        Self
    }
}

impl Calls for Workers {
    fn run(&self, _: (u32, &NodeSpec), _: &[ParamValue], _: &[Slot], _: &Job) -> Result<Vec<Value>> {
        refusal()
    }
    fn check(&self, _: u32, _: &[ParamValue]) -> Result<()> {
        refusal()
    }
    fn halo(&self, _: u32, _: &[ParamValue], _: CellSize) -> Result<usize> {
        refusal()
    }
    fn cost(&self, _: u32, _: &[ParamValue]) -> Result<f64> {
        refusal()
    }
    fn upgrade(&self, _: u32, _: u32, _: &mut RawParams) -> Result<()> {
        refusal()
    }
}

pub(in crate::plugin) fn serve() -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}
