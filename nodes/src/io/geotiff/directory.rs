//! The directory of a file being written: its tags, and where their values stand.

use orograph_core::prelude::*;

use super::{
    cells::Described,
    geokeys::GeoTags,
    tag,
    write::{Compression, Layout, Storage},
};

/// The tags of a file being written.
pub(super) struct Directory {
    big: bool,
    /// (tag, type, count, little-endian values).
    entries: Vec<(u16, u16, u64, Vec<u8>)>,
}

impl Directory {
    pub(super) fn new(big: bool) -> Self {
        Self { big, entries: Vec::new() }
    }

    /// The file's first bytes, which say where the directory stands.
    pub(super) fn header(&self, directory: u64) -> Vec<u8> {
        let mut bytes = b"II".to_vec();
        if self.big {
            bytes.extend_from_slice(&[43, 0, 8, 0, 0, 0]);
            bytes.extend_from_slice(&directory.to_le_bytes());
        } else {
            bytes.extend_from_slice(&[42, 0]);
            bytes.extend_from_slice(&(directory as u32).to_le_bytes());
        }
        bytes
    }

    /// Adds every tag: chunks of `rows` × `cols` at `offsets`, each of `counts` bytes.
    pub(super) fn describe(
        &mut self,
        grid: &Grid,
        cells: &Described,
        storage: &Storage,
        (rows, cols): (usize, usize),
        (offsets, counts): (&[u64], &[u64]),
        job: &Job,
    ) {
        let geo = GeoTags::of(grid);
        if let Some(remark) = &geo.remark {
            job.warn(remark);
        }
        let compression = match storage.compression {
            Compression::None => 1,
            Compression::Lzw => 5,
            Compression::Deflate => 8,
        };
        self.longs(tag::IMAGE_WIDTH, &[grid.cols as u64]);
        self.longs(tag::IMAGE_LENGTH, &[grid.rows as u64]);
        self.shorts(tag::BITS_PER_SAMPLE, &cells.bits);
        self.shorts(tag::COMPRESSION, &[compression]);
        self.shorts(tag::PHOTOMETRIC, &[cells.photometric]);
        self.shorts(tag::SAMPLES_PER_PIXEL, &[cells.bits.len() as u16]);
        self.shorts(tag::PLANAR_CONFIGURATION, &[1]);
        self.shorts(tag::SAMPLE_FORMAT, &vec![cells.format; cells.bits.len()]);
        if compression != 1 {
            self.shorts(tag::PREDICTOR, &[cells.predictor]);
        }
        if cells.alpha {
            const UNASSOCIATED: u16 = 2;
            self.shorts(tag::EXTRA_SAMPLES, &[UNASSOCIATED]);
        }
        match storage.layout {
            Layout::Tiles => {
                self.shorts(tag::TILE_WIDTH, &[cols as u16]);
                self.shorts(tag::TILE_LENGTH, &[rows as u16]);
                self.words(tag::TILE_OFFSETS, offsets);
                self.longs(tag::TILE_BYTE_COUNTS, counts);
            }
            Layout::Strips => {
                self.longs(tag::ROWS_PER_STRIP, &[rows as u64]);
                self.words(tag::STRIP_OFFSETS, offsets);
                self.longs(tag::STRIP_BYTE_COUNTS, counts);
            }
        }
        let mut doubles = |tag, values: Option<&[f64]>| {
            if let Some(values) = values.filter(|values| !values.is_empty()) {
                let bytes = values.iter().flat_map(|value| value.to_le_bytes()).collect();
                self.entries.push((tag, 12, values.len() as u64, bytes));
            }
        };
        doubles(tag::MODEL_PIXEL_SCALE, geo.scale.as_ref().map(<[f64; 3]>::as_slice));
        doubles(tag::MODEL_TIEPOINT, geo.tie.as_ref().map(<[f64; 6]>::as_slice));
        doubles(tag::MODEL_TRANSFORMATION, geo.matrix.as_ref().map(<[f64; 16]>::as_slice));
        doubles(tag::GEO_DOUBLE_PARAMS, Some(&geo.doubles));
        self.shorts(tag::GEO_KEY_DIRECTORY, &geo.directory);
        if !geo.texts.is_empty() {
            self.text(tag::GEO_ASCII_PARAMS, &geo.texts);
        }
        if let Some(nodata) = cells.nodata {
            self.text(tag::GDAL_NODATA, &format!("{nodata}"));
        }
        self.entries.sort_by_key(|entry| entry.0);
    }

    fn shorts(&mut self, tag: u16, values: &[u16]) {
        let bytes = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        self.entries.push((tag, 3, values.len() as u64, bytes));
    }

    fn longs(&mut self, tag: u16, values: &[u64]) {
        let bytes = values.iter().flat_map(|&value| (value as u32).to_le_bytes()).collect();
        self.entries.push((tag, 4, values.len() as u64, bytes));
    }

    /// File positions: as wide as the file's own.
    fn words(&mut self, tag: u16, values: &[u64]) {
        if !self.big {
            return self.longs(tag, values);
        }
        let bytes = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        self.entries.push((tag, 16, values.len() as u64, bytes));
    }

    fn text(&mut self, tag: u16, text: &str) {
        let bytes = [text.as_bytes(), &[0]].concat();
        self.entries.push((tag, 2, bytes.len() as u64, bytes));
    }

    /// The directory as bytes at `position`, values that do not fit an entry behind it.
    pub(super) fn bytes(&self, position: u64) -> Vec<u8> {
        let word = if self.big { 8 } else { 4 };
        let put = |out: &mut Vec<u8>, value: u64| out.extend_from_slice(&value.to_le_bytes()[..word]);
        let count_len = if self.big { 8 } else { 2 };
        let len = count_len + self.entries.len() * (4 + 2 * word) + word;
        let (mut out, mut behind) = (Vec::new(), Vec::new());
        out.extend_from_slice(&(self.entries.len() as u64).to_le_bytes()[..count_len]);
        for (tag, kind, count, values) in &self.entries {
            out.extend_from_slice(&tag.to_le_bytes());
            out.extend_from_slice(&kind.to_le_bytes());
            put(&mut out, *count);
            if values.len() <= word {
                out.extend_from_slice(values);
                out.resize(out.len() + word - values.len(), 0);
            } else {
                put(&mut out, position + (len + behind.len()) as u64);
                behind.extend_from_slice(values);
                behind.resize(behind.len().next_multiple_of(8), 0);
            }
        }
        put(&mut out, 0);
        out.extend_from_slice(&behind);
        out
    }
}
