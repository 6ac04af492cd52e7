//! GeoTIFF and BigTIFF on byte slices: reading any single-band raster that GDAL writes by default and the
//! older layouts around it, and writing files that GDAL reads as its own.
//!
//! Sources: TIFF 6.0, Adobe Photoshop TIFF Technical Note 3 (predictor 3), the BigTIFF design page, OGC
//! GeoTIFF 1.1. The container is our own, over `flate2` and `weezl`: the `tiff` crate writes neither tiles nor
//! predictor 3 and decodes on one thread, and `geotiff-writer` is weeks old. The headers of a file are never
//! believed: an array or a buffer is made only when the bytes that would fill it are there.

mod bytes;
mod cells;
mod codec;
mod directory;
mod feet;
mod geokeys;
mod ifd;
mod read;
mod sample;
mod sink;
mod write;

pub use cells::{Cells, Colours, Described, Heights};
pub use read::{GeotiffSource, read};
pub(crate) use sink::GeotiffSink;
pub use write::{Compression, Layout, Options, SampleType, Storage, Writer, heights, write};

/// Whether these are the first bytes of a TIFF file, classic or big.
pub(crate) fn looks_like(bytes: &[u8]) -> bool {
    matches!(bytes.get(..4), Some(b"II*\0" | b"MM\0*" | b"II+\0" | b"MM\0+"))
}

/// Tags, by their names in the specification.
mod tag {
    pub(super) const IMAGE_WIDTH: u16 = 256;
    pub(super) const IMAGE_LENGTH: u16 = 257;
    pub(super) const BITS_PER_SAMPLE: u16 = 258;
    pub(super) const COMPRESSION: u16 = 259;
    pub(super) const PHOTOMETRIC: u16 = 262;
    pub(super) const FILL_ORDER: u16 = 266;
    pub(super) const STRIP_OFFSETS: u16 = 273;
    pub(super) const SAMPLES_PER_PIXEL: u16 = 277;
    pub(super) const ROWS_PER_STRIP: u16 = 278;
    pub(super) const STRIP_BYTE_COUNTS: u16 = 279;
    pub(super) const PLANAR_CONFIGURATION: u16 = 284;
    pub(super) const PREDICTOR: u16 = 317;
    pub(super) const TILE_WIDTH: u16 = 322;
    pub(super) const TILE_LENGTH: u16 = 323;
    pub(super) const TILE_OFFSETS: u16 = 324;
    pub(super) const TILE_BYTE_COUNTS: u16 = 325;
    pub(super) const EXTRA_SAMPLES: u16 = 338;
    pub(super) const SAMPLE_FORMAT: u16 = 339;
    pub(super) const MODEL_PIXEL_SCALE: u16 = 33550;
    pub(super) const MODEL_TIEPOINT: u16 = 33922;
    pub(super) const MODEL_TRANSFORMATION: u16 = 34264;
    pub(super) const GEO_KEY_DIRECTORY: u16 = 34735;
    pub(super) const GEO_DOUBLE_PARAMS: u16 = 34736;
    pub(super) const GEO_ASCII_PARAMS: u16 = 34737;
    pub(super) const GDAL_METADATA: u16 = 42112;
    pub(super) const GDAL_NODATA: u16 = 42113;
}
