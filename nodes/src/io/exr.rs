//! OpenEXR: heights as one channel of floating point.

use std::io::{BufReader, Cursor, Seek, Write};

use exr::prelude::*;
use orograph_core::prelude::{Error, Grid, Heightfield, Job};

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
    let meta =
        exr::meta::MetaData::read_from_buffered(BufReader::new(Cursor::new(bytes)), false).map_err(fail)?;
    let mut promised = 0u64;
    for header in &meta.headers {
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
    job.check()?;
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(fail)?;
    let layer = image.layer_data;
    let channels = &layer.channel_data.list;
    let named = |wanted: &&str| channels.iter().find(|channel| channel.name.eq(wanted));
    let channel = NAMES.iter().find_map(named).or(channels.first());
    let channel = channel.ok_or_else(|| Error::format(name, "the picture has no channel"))?;
    if channels.len() > 1 {
        job.warn(format!("{name}: channel `{}` of {} is read as heights", channel.name, channels.len()));
    }
    let grid = Grid::new(layer.size.height(), layer.size.width(), cell)?;
    if grid.is_empty() {
        return Err(Error::EmptyInput { what: name.into() });
    }
    if channel.sample_data.len() != grid.len() {
        return Err(Error::format(name, format!("channel `{}` is subsampled", channel.name)));
    }
    job.admit(grid.len() as u64 * 4, || format!("the picture {name}"))?;
    let cells: Vec<f32> = channel.sample_data.values_as_f32().collect();
    let terrain = Heightfield::new(grid, cells)?;
    refuse_infinite(&terrain, name)?;
    Ok(terrain)
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
    Image::from_layer(layer)
        .write()
        .non_parallel()
        .to_buffered(out)
        .map_err(|error| Error::writing(name, error))
}

fn smallvec(channel: AnyChannel<FlatSamples>) -> exr::prelude::SmallVec<[AnyChannel<FlatSamples>; 4]> {
    std::iter::once(channel).collect()
}
