//! OpenEXR: heights as one channel of floating point.

use std::{
    collections::BTreeSet,
    io::{Cursor, Seek, Write},
};

use exr::{
    block::{UncompressedBlock, lines::LineRef, reader::ChunksReader, writer::ChunksWriter},
    image::write::layers::{LayersWriter, WritableLayers},
    io::Data,
    meta::attribute::SampleType,
    prelude::*,
};
use orograph_core::prelude::{Error, Grid, Heightfield, Job};

use rayon::prelude::*;

use super::file::{refuse_empty, refuse_infinite};

type Outcome<T> = orograph_core::Result<T>;

/// Channels that hold heights by custom, best first; the first of the file comes after all of them.
const NAMES: [&str; 6] = ["height", "Height", "Y", "Z", "R", "depth"];

/// The heights in an OpenEXR picture, in metres; NaN is a void. The first layer's channel named `height`, `Y`,
/// `Z`, `R` or, failing these, its first is read.
///
/// # Errors
/// [`Error::Format`] for what is no sound picture; [`Error::NonFinite`]; [`Error::TooLarge`]; [`Error::Cancelled`].
pub fn read(bytes: &[u8], name: &str, cell: orograph_core::CellSize, job: &Job) -> Outcome<Heightfield> {
    let fail = |error: exr::error::Error| Error::format(name, error);
    let reader = exr::block::read(Cursor::new(bytes), false).map_err(fail)?;
    let mut promised = 0u64;
    for header in reader.headers() {
        let Vec2(width, height) = header.layer_size;
        let Grid { .. } = Grid::new(height, width, cell)?;
        let samples = (width as u64 * height as u64).saturating_mul(header.channels.bytes_per_pixel as u64);
        promised = promised.saturating_add(samples);
    }
    // Even run-length and zip blocks pack no better than deflate can.
    if promised > (bytes.len() as u64).saturating_mul(1032) {
        return Err(Error::format(name, "it promises more pixels than its bytes can hold"));
    }
    job.admit(promised, || format!("the picture {name}"))?;
    let layer = reader.headers().iter().position(|header| !header.deep);
    let layer = layer.ok_or_else(|| Error::format(name, "the picture has deep layers alone"))?;
    let header = reader.headers()[layer].clone();
    let channels = &header.channels.list;
    let named = |wanted: &&str| channels.iter().position(|channel| channel.name.eq(wanted));
    let wanted = NAMES.iter().find_map(named).unwrap_or(0);
    let channel = channels.get(wanted).ok_or_else(|| Error::format(name, "the picture has no channel"))?;
    if channels.len() > 1 {
        job.warn(format!("{name}: channel `{}` of {} is read as heights", channel.name, channels.len()));
    }
    let grid = Grid::new(header.layer_size.height(), header.layer_size.width(), cell)?;
    if grid.is_empty() {
        return Err(Error::EmptyInput { what: name.into() });
    }
    let cols = grid.cols;
    let mut terrain = Heightfield::filled(grid, f32::NAN, job)?;
    let cells = terrain.cells_mut();
    let largest = Vec2(0, 0);
    let chunks = reader
        .filter_chunks(false, |_, tile, block| block.layer == layer && tile.level_index == largest)
        .map_err(fail)?;
    let done = job.stage(chunks.expected_chunk_count() as u64);
    let mut places = BTreeSet::new();
    for block in chunks.sequential_decompressor(false) {
        job.check()?;
        let block = block.map_err(fail)?;
        // The table of blocks may lead to one of another layer or size, or to one twice, which the crate believes.
        let (index, Vec2(x, y)) = (block.index, block.index.pixel_position);
        if index.layer != layer || index.level != largest || !places.insert((y, x)) {
            return Err(Error::format(name, "its table of blocks is wrong"));
        }
        for line in block.lines(&header.channels).filter(|line| line.location.channel == wanted) {
            let Vec2(col, row) = line.location.position;
            let end = col.saturating_add(line.location.sample_count);
            let row = cells.get_mut(row.saturating_mul(cols)..).and_then(|rest| rest.get_mut(..cols));
            let Some(out) = row.and_then(|row| row.get_mut(col..end)) else {
                return Err(Error::format(name, "a block of pixels lies outside the picture"));
            };
            match channel.sample_type {
                SampleType::F16 => copy(&line, out, f16::to_f32),
                SampleType::F32 => copy(&line, out, |sample: f32| sample),
                SampleType::U32 => copy(&line, out, |sample: u32| sample as f32),
            }
            .map_err(fail)?;
        }
        done.advance(1);
    }
    refuse_infinite(&terrain, name)?;
    Ok(terrain)
}

/// Reads the samples of a line as heights.
fn copy<T: Data>(line: &LineRef<'_>, out: &mut [f32], height: impl Fn(T) -> f32) -> exr::error::UnitResult {
    for (out, sample) in out.iter_mut().zip(line.read_samples()) {
        *out = height(sample?);
    }
    Ok(())
}

/// Writes heights as the channel `Y` of 32-bit floats, zip-packed; voids are NaN.
///
/// # Errors
/// [`Error::EmptyInput`]; [`Error::NonFinite`]; [`Error::TooLarge`]; [`Error::Io`] from the stream, with `name`.
pub fn write(terrain: &Heightfield, out: &mut (impl Write + Seek), name: &str, job: &Job) -> Outcome<()> {
    refuse_empty(terrain, "terrain")?;
    refuse_infinite(terrain, "terrain")?;
    job.admit(terrain.cells().len() as u64 * 4, || format!("the picture {name}"))?;
    job.check()?;
    let samples = FlatSamples::F32(terrain.cells().to_vec());
    let channels = AnyChannels::sort(smallvec(AnyChannel::new("Y", samples)));
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let layer = Layer::new((terrain.cols(), terrain.rows()), LayerAttributes::default(), encoding, channels);
    let image = Image::from_layer(layer);
    let headers = image.layer_data.infer_headers(&image.attributes);
    let source = image.layer_data.create_writer(&headers);
    // Packed in parallel, written in order.
    let written = exr::block::write(out, headers, true, |meta, chunks| {
        let headers = &meta.headers;
        let blocks: Vec<_> = exr::block::enumerate_ordered_header_block_indices(headers).collect();
        let done = job.stage(blocks.len() as u64);
        for batch in blocks.chunks(BATCH) {
            let packed = batch.par_iter().map(|(_, index)| {
                job.check().map_err(|_| exr::error::Error::Aborted)?;
                let data = source.extract_uncompressed_block(headers, *index);
                UncompressedBlock { index: *index, data }.compress_to_chunk(headers)
            });
            for ((place, _), chunk) in batch.iter().zip(packed.collect::<exr::error::Result<Vec<_>>>()?) {
                chunks.write_chunk(*place, chunk)?;
            }
            done.advance(batch.len() as u64);
        }
        Ok(())
    });
    job.check()?;
    written.map_err(|error| Error::writing(name, error))
}

/// Blocks that are packed before they are written: enough for many threads, few enough for little memory.
const BATCH: usize = 64;

fn smallvec(channel: AnyChannel<FlatSamples>) -> exr::prelude::SmallVec<[AnyChannel<FlatSamples>; 4]> {
    std::iter::once(channel).collect()
}
