//! What holds for every format: what is written reads back, and no broken file does worse than an error.

mod bands;

use std::{
    fs,
    io::{Cursor, Write},
    path::{Path, PathBuf},
    sync::Mutex,
};

use orograph_core::{Context, Host, OutputStream, prelude::*};
use proptest::prelude::*;

use super::{
    geotiff::{self, Compression, Layout, Options, SampleType},
    raw::{self, RawFormat, RawLayout},
    write_png::Depth,
    *,
};
use crate::test_fields::field;

/// A host with a folder to write to, little memory, and a record of what it was told.
struct Folder {
    path: PathBuf,
    told: Mutex<Vec<String>>,
}

impl Folder {
    fn new(path: &Path) -> Self {
        Self { path: path.into(), told: Mutex::default() }
    }

    fn job(&self) -> Job<'_> {
        Job::new(self, Context::default())
    }
}

struct File(fs::File);

impl Write for File {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.write(bytes)
    }
    fn flush(&mut self) -> std::io::Result<()> {
        self.0.flush()
    }
}

impl std::io::Seek for File {
    fn seek(&mut self, to: std::io::SeekFrom) -> std::io::Result<u64> {
        self.0.seek(to)
    }
}

impl OutputStream for File {
    fn finish(self: Box<Self>) -> Result<()> {
        Ok(())
    }
}

impl Host for Folder {
    fn cancelled(&self) -> bool {
        false
    }
    fn progress(&self, _: f64) {}
    fn warn(&self, message: &str) {
        self.told.lock().unwrap().push(message.into());
    }
    fn memory_limit(&self) -> u64 {
        1 << 26
    }
    fn input_path(&self, path: &str) -> Result<PathBuf> {
        Ok(self.path.join(path))
    }
    fn create(&self, path: &str) -> Result<Box<dyn OutputStream>> {
        Ok(Box::new(File(fs::File::create(self.path.join(path)).unwrap())))
    }
}

fn bits(terrain: &Heightfield) -> Vec<u32> {
    let canonical = |height: &f32| if height.is_nan() { f32::NAN.to_bits() } else { height.to_bits() };
    terrain.cells().iter().map(canonical).collect()
}

/// Whole heights with a void, on a georeferenced grid of oblong cells.
fn sample(rows: usize, cols: usize) -> Heightfield {
    let terrain = field(rows, cols, |row, col| {
        if row == 1 && col == 2 { f64::NAN } else { ((row * 37 + col * 101) % 3001) as f64 - 200.0 }
    });
    let mut grid = terrain.grid().clone();
    grid.cell = CellSize { x: 20.0, y: 30.0 };
    let transform = [500_000.5, 20.0, 0.0, 4_000_000.25, 0.0, -30.0];
    grid.georef = Some(Georef { transform, crs: "EPSG:32632".into() }.into());
    terrain.with_grid(grid).unwrap()
}

fn geotiff_of(terrain: &Heightfield, options: &Options) -> Result<Vec<u8>> {
    let mut out = Cursor::new(Vec::new());
    geotiff::write(terrain, options, &mut out, "x.tif", &Job::detached())?;
    Ok(out.into_inner())
}

fn every_option() -> Vec<Options> {
    let mut all = Vec::new();
    for sample in [SampleType::Float32, SampleType::Int16, SampleType::Int32, SampleType::Float64] {
        for compression in [Compression::Deflate, Compression::Lzw, Compression::None] {
            for layout in [Layout::Tiles, Layout::Strips] {
                for big in [false, true] {
                    all.push(Options { sample, compression, layout, big, ..Options::default() });
                }
            }
        }
    }
    all
}

#[test]
fn geotiff_round_trips_in_every_variant() {
    for (rows, cols) in [(3, 5), (1, 1), (257, 300), (700, 513)] {
        let terrain = sample(rows, cols);
        for options in every_option() {
            let bytes = geotiff_of(&terrain, &options).unwrap();
            let back = geotiff::read(&bytes, "x.tif", &Job::detached()).unwrap();
            assert_eq!(bits(&back), bits(&terrain), "{rows} × {cols}, {options:?}");
            assert_eq!(back.grid(), terrain.grid(), "{options:?}");
        }
    }
}

#[test]
fn georeferences_survive() {
    let keys = "geokeys|1024:s1|1026:tmy 100 %25 own|2049:tDatum = x%7CPrimem = y%7C|3072:s32767|3075:s8|3076:s9001|3078:d29.5|3080:d-96.25,1.5";
    let cases = [
        ("EPSG:4326", [7.0, 0.001, 0.0, 46.0, 0.0, -0.002], CellSize { x: 77.0, y: 222.0 }),
        ("EPSG:3857", [7.0e5, 76.0, 0.0, 4.3e6, 0.0, -76.0], CellSize::square(61.0)),
        ("EPSG:2225", [6.0e6, 10.0, 0.0, 2.0e6, 0.0, -10.0], CellSize::square(12000.0 / 3937.0)),
        ("EPSG:32632", [4.0e5, 3.0, 4.0, 5.0e6, 4.0, -3.0], CellSize::square(5.0)),
        ("EPSG:32632+5773", [4.0e5, 3.0, 0.0, 5.0e6, 0.0, -3.0], CellSize::square(3.0)),
        (keys, [4.0e5, 3.0, 0.0, 5.0e6, 0.0, -3.0], CellSize::square(3.0)),
        ("", [4.0e5, 3.0, 0.0, 5.0e6, 0.0, -3.0], CellSize::square(3.0)),
    ];
    for (crs, transform, cell) in cases {
        let mut grid = sample(4, 6).grid().clone();
        grid.cell = cell;
        grid.georef = Some(Georef { transform, crs: crs.into() }.into());
        let terrain = sample(4, 6).with_grid(grid).unwrap();
        let bytes = geotiff_of(&terrain, &Options::default()).unwrap();
        let back = geotiff::read(&bytes, "x.tif", &Job::detached()).unwrap();
        assert_eq!(back.grid().georef, terrain.grid().georef, "{crs}");
        let found = back.grid().cell;
        // The geographic and the Mercator case are given rounded.
        assert!(
            (found.x / cell.x - 1.0).abs() < 0.01 && (found.y / cell.y - 1.0).abs() < 0.01,
            "{crs}: {found:?}"
        );
    }
}

#[test]
fn a_crop_is_written_where_it_lies() {
    let job = Job::detached();
    let crop = sample(9, 9).crop(2, 3, 4, 5, &job).unwrap();
    let back = geotiff::read(&geotiff_of(&crop, &Options::default()).unwrap(), "x", &job).unwrap();
    assert_eq!(back.grid().georef_here(), crop.grid().georef_here());
}

#[test]
fn what_a_sample_type_cannot_hold_is_refused() {
    let int16 = Options { sample: SampleType::Int16, ..Options::default() };
    let uint16 = Options { sample: SampleType::Uint16, nodata: 65535.0, ..Options::default() };
    for (height, options) in [(32767.5, int16), (-32767.6, int16), (-0.6, uint16), (65534.7, uint16)] {
        let terrain = field(2, 2, |_, _| height);
        assert!(matches!(geotiff_of(&terrain, &options), Err(Error::Invalid { .. })), "{height}");
    }
    assert!(Options { nodata: -1.0, ..uint16 }.check().is_err());
    assert!(Options { nodata: 0.5, ..int16 }.check().is_err());
    let infinite = field(2, 2, |_, _| f64::INFINITY);
    assert!(matches!(geotiff_of(&infinite, &int16), Err(Error::NonFinite { .. })));
    assert!(matches!(geotiff_of(&infinite, &Options::default()), Err(Error::NonFinite { .. })));
    assert!(matches!(geotiff_of(&field(0, 0, |_, _| 0.0), &int16), Err(Error::EmptyInput { .. })));
}

#[test]
fn heights_round_half_away_from_zero() {
    let heights = [0.5, -0.5, 1.499, -1.5, 0.499_999_97, 2.5];
    let terrain = field(1, heights.len(), |_, col| heights[col]);
    let options = Options { sample: SampleType::Int16, ..Options::default() };
    let back = geotiff::read(&geotiff_of(&terrain, &options).unwrap(), "x", &Job::detached()).unwrap();
    assert_eq!(back.cells(), [1.0, -1.0, 1.0, -2.0, 0.0, 3.0]);
}

/// One small file of each format, with its name.
fn samples() -> Vec<(String, Vec<u8>)> {
    let job = Job::detached();
    let terrain = sample(9, 11);
    let mut all: Vec<(String, Vec<u8>)> = every_option()
        .iter()
        .enumerate()
        .map(|(i, options)| (format!("{i}.tif"), geotiff_of(&terrain, options).unwrap()))
        .collect();
    let mut text = Vec::new();
    ascii::write(&terrain, &mut text, "x.asc", &job).unwrap();
    all.push(("x.asc".into(), text));
    let mut picture = Vec::new();
    write_png::write(&terrain, Depth::Sixteen, (-200.0, 3000.0), &mut picture, "x.png", &job).unwrap();
    all.push(("x.png".into(), picture));
    let mut picture = Cursor::new(Vec::new());
    exr::write(&terrain, &mut picture, "x.exr", &job).unwrap();
    all.push(("x.exr".into(), picture.into_inner()));
    let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
    zip.start_file("inner.tif", zip::write::SimpleFileOptions::default()).unwrap();
    zip.write_all(&all[0].1.clone()).unwrap();
    all.push(("x.zip".into(), zip.finish().unwrap().into_inner()));
    all
}

fn open(bytes: &[u8], name: &str, job: &Job) -> Result<Heightfield> {
    let cell = CellSize::square(1.0);
    match name.rsplit('.').next() {
        Some("png") => read_png::read(bytes, name, (0.0, 1.0), cell, job),
        Some("exr") => exr::read(bytes, name, cell, job),
        _ => read_dem::read(bytes, name, job),
    }
}

#[test]
fn no_truncation_or_flipped_bit_panics() {
    let folder = Folder::new(Path::new("."));
    let job = folder.job();
    for (name, whole) in samples() {
        assert!(open(&whole, &name, &job).is_ok(), "{name}: {:?}", open(&whole, &name, &job).err());
        for &end in &telling_offsets(whole.len()) {
            let _ = open(&whole[..end], &name, &job);
        }
        let mut flipped = whole.clone();
        for &i in &telling_offsets(whole.len()) {
            for mask in [0x01, 0x80, 0xff] {
                flipped[i] = whole[i] ^ mask;
                let _ = open(&flipped, &name, &job);
            }
            flipped[i] = whole[i];
        }
    }
}

/// Every offset near both ends, where headers stand, and a few hundred between.
fn telling_offsets(len: usize) -> Vec<usize> {
    const END: usize = 700;
    let between = (len / 300).max(1);
    (0..len).filter(|&i| i < END || i + END >= len || i.is_multiple_of(between)).collect()
}

#[test]
fn a_truncated_geotiff_is_refused() {
    // The directory stands at the end, so every cut loses a part of it.
    let whole = geotiff_of(&sample(40, 40), &Options::default()).unwrap();
    for end in 0..whole.len() - 8 {
        assert!(geotiff::read(&whole[..end], "x", &Job::detached()).is_err(), "cut at {end}");
    }
}

#[test]
fn absurd_dimensions_take_no_memory() {
    let whole = geotiff_of(&sample(4, 4), &Options { layout: Layout::Strips, ..Options::default() }).unwrap();
    for tag in [256_u16, 257] {
        let entry = [tag.to_le_bytes(), 4_u16.to_le_bytes()].concat();
        let at = whole.windows(4).position(|bytes| bytes == entry).unwrap();
        for size in [u32::MAX, 1 << 31, 1 << 20] {
            let mut bytes = whole.clone();
            bytes[at + 8..at + 12].copy_from_slice(&size.to_le_bytes());
            assert!(geotiff::read(&bytes, "x", &Job::detached()).is_err(), "{tag} {size}");
        }
    }
    let text = b"ncols 2000000000\nnrows 2000000000\ncellsize 1\n1 2 3";
    assert!(ascii::read(text, "x", &Job::detached()).is_err());
}

/// Packed as LZW packs, a tile may be thousands of times larger than its bytes, and much larger than the image.
#[test]
fn a_tile_that_the_run_may_not_hold_is_refused_before_it_is_unpacked() {
    let mut bytes = geotiff_of(&sample(4, 4), &Options::default()).unwrap();
    for tag in [322_u16, 323] {
        let entry = [tag.to_le_bytes(), 3_u16.to_le_bytes()].concat();
        let at = bytes.windows(4).position(|bytes| bytes == entry).unwrap();
        bytes[at + 8..at + 10].copy_from_slice(&65520_u16.to_le_bytes());
    }
    let error = geotiff::read(&bytes, "x", &Job::detached()).unwrap_err();
    assert!(matches!(error, Error::TooLarge { .. }), "{error}");
}

#[test]
fn an_unsupported_compression_is_named() {
    let mut bytes = geotiff_of(&sample(4, 4), &Options::default()).unwrap();
    let entry = [259_u16.to_le_bytes(), 3_u16.to_le_bytes()].concat();
    let at = bytes.windows(4).position(|bytes| bytes == entry).unwrap();
    bytes[at + 8..at + 10].copy_from_slice(&50000_u16.to_le_bytes());
    let error = geotiff::read(&bytes, "x", &Job::detached()).unwrap_err();
    assert!(error.to_string().contains("Zstandard"), "{error}");
}

#[test]
fn formats_are_told_by_content_and_strangers_are_named() {
    let job = Job::detached();
    for (bytes, word) in [
        (&b""[..], "empty"),
        (b"\x89PNG\r\n\x1a\n", "read_png"),
        (b"\x76\x2f\x31\x01", "read_exr"),
        (b"hello, world", "read_raw"),
    ] {
        let error = read_dem::read(bytes, "x.tif", &job).unwrap_err();
        assert!(error.to_string().contains(word), "{error}");
    }
    let tiff = geotiff_of(&sample(2, 3), &Options::default()).unwrap();
    assert!(read_dem::read(&tiff, "wrong.hgt", &job).is_ok());
}

#[test]
fn ascii_reads_what_others_write() {
    let text = "NCOLS 3\r\nNROWS 2\r\nXLLCENTER 10\r\nYLLCENTER 20\r\nCELLSIZE 2\r\nNODATA_VALUE -1\r\n1 2 -1\r\n4 5e0\r\n6\r\n";
    let terrain = ascii::read(text.as_bytes(), "x", &Job::detached()).unwrap();
    assert!(terrain.at(0, 2).is_nan());
    assert_eq!(terrain.row(1), [4.0, 5.0, 6.0]);
    assert_eq!(terrain.grid().georef_here().unwrap().transform, [9.0, 2.0, 0.0, 23.0, 0.0, -2.0]);
    for bad in [
        "ncols 2 nrows 1 cellsize 1 1",
        "ncols 2 nrows 1 cellsize 1 1 2 3",
        "ncols 2 nrows 1 cellsize 1 1 x",
        "ncols 2 nrows 1 1 2",
        "ncols 2.5 nrows 1 cellsize 1 1 2",
        "ncols 2 nrows 1 cellsize 0 1 2",
        "ncols 2 nrows 1 cellsize 1 1 inf",
        "ncols 0 nrows 0 cellsize 1",
        "ncols 2 size 1 cellsize 1 1 2",
    ] {
        assert!(ascii::read(bad.as_bytes(), "x", &Job::detached()).is_err(), "{bad}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_heights_round_trip(
        rows in 1usize..40,
        cols in 1usize..40,
        seed in any::<u64>(),
        which in 0usize..48,
        oblong in 0.5f64..2.0,
    ) {
        let job = Job::detached();
        let value = |row: usize, col: usize| {
            let roll = orograph_core::unit(orograph_core::key(seed, 0, row as i64, col as i64));
            if roll < 0.1 { f64::NAN } else { roll * 9000.0 - 500.0 }
        };
        let fine = field(rows, cols, value);
        let whole = field(rows, cols, |row, col| value(row, col).round());
        let options = every_option()[which];
        let floats = matches!(options.sample, SampleType::Float32 | SampleType::Float64);
        let terrain = if floats { &fine } else { &whole };
        let mut grid = terrain.grid().clone();
        grid.cell = CellSize { x: 10.0, y: 10.0 * oblong };
        let transform = [1e5, 10.0, 0.0, 2e6, 0.0, -10.0 * oblong];
        grid.georef = Some(Georef { transform, crs: "EPSG:32610".into() }.into());
        let terrain = terrain.clone().with_grid(grid).unwrap();
        let back = geotiff::read(&geotiff_of(&terrain, &options).unwrap(), "x", &job).unwrap();
        prop_assert_eq!(bits(&back), bits(&terrain));
        prop_assert_eq!(back.grid(), terrain.grid());

        let mut text = Vec::new();
        ascii::write(&terrain, &mut text, "x", &job).unwrap();
        let back = ascii::read(&text, "x", &job).unwrap();
        prop_assert_eq!(bits(&back), bits(&terrain));
        prop_assert!((back.grid().cell.y - 10.0 * oblong).abs() < 1e-9);

        let mut picture = Cursor::new(Vec::new());
        exr::write(&terrain, &mut picture, "x", &job).unwrap();
        let back = exr::read(&picture.into_inner(), "x", terrain.grid().cell, &job).unwrap();
        prop_assert_eq!(bits(&back), bits(&terrain));

        let layout = RawLayout { format: RawFormat::R32, range: (0.0, 1.0), south_first: false };
        let back = raw::read(&raw::write(&terrain, &layout, &job).unwrap(), "x", terrain.grid().clone(), &layout, &job);
        prop_assert_eq!(bits(&back.unwrap()), bits(&terrain));

        let (low, high) = (-500.0, 8500.0);
        let mut picture = Vec::new();
        write_png::write(&terrain, Depth::Sixteen, (low, high), &mut picture, "x", &job).unwrap();
        let back = read_png::read(&picture, "x", (low, high), terrain.grid().cell, &job).unwrap();
        let step = (high - low) as f32 / 65535.0;
        for (&found, &height) in back.cells().iter().zip(terrain.cells()) {
            let stored = if height.is_nan() { low as f32 } else { height };
            prop_assert!((found - stored).abs() <= step * 0.51);
        }
    }
}

#[test]
fn every_writer_writes_what_its_reader_reads() {
    let folder = tempfile::tempdir().unwrap();
    let host = Folder::new(folder.path());
    let job = host.job();
    let terrain = &field(33, 33, |row, col| (row * 33 + col) as f64);
    let file = |name: &str| OutputPath(name.into());
    let input = |name: &str| InputPath(name.into());
    write_geotiff::WriteGeotiff::default().run(write_geotiff::WriteGeotiffIn { terrain }, &job).unwrap();
    write_ascii::WriteAscii::default().run(write_ascii::WriteAsciiIn { terrain }, &job).unwrap();
    for name in ["terrain.tif", "terrain.asc"] {
        let node = read_dem::ReadDem { file: input(name), ..Default::default() };
        let back = node.run((), &job).unwrap().terrain;
        assert_eq!((back.cells(), back.grid().cell), (terrain.cells(), terrain.grid().cell), "{name}");
    }
    write_exr::WriteExr::default().run(write_exr::WriteExrIn { terrain }, &job).unwrap();
    let node = read_exr::ReadExr { file: input("terrain.exr"), ..Default::default() };
    assert_eq!(node.run((), &job).unwrap().terrain.cells(), terrain.cells());
    for target in [target::Target::Unity, target::Target::Any] {
        let node = write_raw::WriteRaw { target, south_first: true, ..Default::default() };
        node.run(write_raw::WriteRawIn { terrain }, &job).unwrap();
    }
    let node = write_raw::WriteRaw { target: target::Target::Unreal, ..Default::default() };
    assert!(node.run(write_raw::WriteRawIn { terrain }, &job).is_err());
    let node = read_raw::ReadRaw {
        file: input("terrain.r16"),
        highest: 1088.0,
        south_first: true,
        ..Default::default()
    };
    let back = node.run((), &job).unwrap().terrain;
    assert!(back.cells().iter().zip(terrain.cells()).all(|(a, b)| (a - b).abs() < 0.01));
    write_png::WritePng::default().run(write_png::WritePngIn { terrain }, &job).unwrap();
    assert!(host.told.lock().unwrap().iter().any(|text| text.contains("range 0 to 1088 m")));
    let mask = &terrain.map::<orograph_core::Share>(&job, |height| height / 1088.0).unwrap();
    write_mask::WriteMask::default().run(write_mask::WriteMaskIn { mask }, &job).unwrap();
    let back = read_mask::ReadMask { file: input("mask.png"), cell: 10.0 }.run((), &job).unwrap().mask;
    assert!(back.cells().iter().zip(mask.cells()).all(|(a, b)| (a - b).abs() < 1e-5));
    let cols = terrain.grid().cols;
    // Grey, few colours, more colours than a palette holds, each opaque and not.
    let colours: [fn(usize, f32) -> [u8; 3]; 3] =
        [|_, h| [h as u8; 3], |_, h| [h as u8, 7, 200], |i, h| [h as u8, i as u8, (i >> 8) as u8]];
    for (alpha, colour) in [255, 128].into_iter().flat_map(|alpha| colours.map(|colour| (alpha, colour))) {
        let cells = terrain.cells().iter().enumerate().map(|(i, &height)| {
            let [red, green, blue] = colour(i, height);
            [red, green, blue, if i < cols { 255 } else { alpha }]
        });
        let texture = &Texture::new(terrain.grid().clone(), cells.collect()).unwrap();
        for packing in [write_texture::Packing::Fast, write_texture::Packing::Small] {
            let node = write_texture::WriteTexture { packing, ..Default::default() };
            node.run(write_texture::WriteTextureIn { texture }, &job).unwrap();
            let node = read_texture::ReadTexture { file: input("texture.png"), cell: 10.0 };
            assert_eq!(node.run((), &job).unwrap().texture.cells(), texture.cells(), "{packing:?}");
        }
    }
    let table = &Table::metrics([("rmse", orograph_core::Unit::Metre, 1.5)]).unwrap();
    for name in ["t.json", "t.csv"] {
        let node = write_table::WriteTable { file: file(name), ..Default::default() };
        node.run(write_table::WriteTableIn { table }, &job).unwrap();
    }
    assert_eq!(fs::read_to_string(folder.path().join("t.csv")).unwrap(), "rmse [m]\n1.5\n");
    for name in ["terrain.tif", "../x"] {
        assert!(write_png::WritePng { file: file(name), ..Default::default() }.check().is_err());
    }
    let missing = read_dem::ReadDem { file: input("missing.tif"), ..Default::default() };
    assert!(matches!(missing.run((), &job), Err(Error::Io { .. })));
    assert!(matches!(read_dem::ReadDem::default().run((), &job), Err(Error::Invalid { .. })));
}
