//! stub

use crate::{arguments::SweepOptions, failure::Failure};

pub(crate) fn run(_: &SweepOptions) -> Result<(), Failure> {
    Err(Failure::Other("not yet".into()))
}
