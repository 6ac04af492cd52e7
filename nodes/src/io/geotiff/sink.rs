//! A GeoTIFF file that takes its rows as they come.

use std::{io::BufWriter, marker::PhantomData};

use orograph_core::{Kind, OutputStream, Wire, prelude::*};

use super::{cells::Cells, write::Writer};
use crate::io::file;

/// A file under way that is given rasters of kind `K`.
pub(crate) struct GeotiffSink<K, C: Cells> {
    writer: Writer<BufWriter<Box<dyn OutputStream>>, C>,
    path: OutputPath,
    kind: PhantomData<K>,
}

impl<K: Kind, C: Cells> GeotiffSink<K, C> {
    /// The file at `path`, which `begin` begins.
    pub(crate) fn new(
        path: &OutputPath,
        job: &Job,
        begin: impl FnOnce(
            BufWriter<Box<dyn OutputStream>>,
        ) -> Result<Writer<BufWriter<Box<dyn OutputStream>>, C>>,
    ) -> Result<Self> {
        Ok(Self { writer: begin(file::begin(path, job)?)?, path: path.clone(), kind: PhantomData })
    }
}

impl<K: Kind, C: Cells<Cell = K::Cell> + Send> BandSink for GeotiffSink<K, C>
where
    Raster<K>: Wire,
{
    fn take(&mut self, band: &Value, job: &Job) -> Result<()> {
        let band = Raster::<K>::borrow(band)
            .ok_or_else(|| Error::invalid("these are not the cells that the file takes", "report it"))?;
        self.writer.take(band.cells(), job)
    }

    fn finish(self: Box<Self>, job: &Job) -> Result<()> {
        file::end(self.writer.finish(job)?, &self.path, job)
    }
}
