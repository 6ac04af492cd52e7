use std::{fs, path::Path};

use super::*;

const SIDE: usize = 1201;

/// A height that tells its place: rows count from 90° N, columns from 180° W and on around the globe.
fn height(row: i64, col: i64) -> f32 {
    ((row * 7 + col.rem_euclid(360 * 1200) * 3) % 4001) as f32
}

/// First row and column of a tile.
fn first(name: &str) -> [i64; 2] {
    let (latitude, longitude) = hgt::corner(name).unwrap();
    [(89 - i64::from(latitude)) * 1200, (i64::from(longitude) + 180) * 1200]
}

/// Writes a tile, void where `is_void` says so of its own row and column.
fn write(folder: &Path, name: &str, is_void: impl Fn(usize, usize) -> bool) {
    let [row0, col0] = first(name);
    let mut bytes = Vec::with_capacity(SIDE * SIDE * 2);
    for (row, col) in (0..SIDE * SIDE).map(|i| (i / SIDE, i % SIDE)) {
        let whole = height(row0 + row as i64, col0 + col as i64) as i16;
        bytes.extend(if is_void(row, col) { i16::MIN } else { whole }.to_be_bytes());
    }
    fs::write(folder.join(name), bytes).unwrap();
}

fn read(folder: &Path, name: &str, margin: f64) -> Result<ReadTileOut> {
    let file = InputPath(folder.join(name).display().to_string());
    ReadTile { file, margin }.run((), &Job::detached())
}

/// Expects every known cell to be that of its place, and tells how many are void.
fn voids(terrain: &Heightfield, name: &str) -> usize {
    let [row0, col0] = first(name);
    let grid = terrain.grid();
    for (i, &found) in terrain.cells().iter().enumerate().filter(|(_, height)| !height.is_nan()) {
        let (row, col) = grid.base(i / grid.cols, i % grid.cols);
        assert_eq!(found, height(row0 + row, col0 + col), "{name}: row {row}, column {col}");
    }
    terrain.void_count()
}

#[test]
fn ground_of_all_neighbours_lies_where_it_belongs() {
    // Somewhere, around the crossing of equator and Greenwich, at the date line from both sides.
    for name in ["N46E008.hgt", "N00E000.hgt", "S01W001.hgt", "S17E179.hgt", "S17W180.hgt"] {
        let folder = tempfile::tempdir().unwrap();
        write(folder.path(), name, |_, _| false);
        for (_, names) in hgt::neighbours(name) {
            write(folder.path(), &names[0], |_, _| false);
        }
        let ReadTileOut { terrain, around } = read(folder.path(), name, 0.01).unwrap();
        assert_eq!(around.grid().size(), (SIDE + 24, SIDE + 24));
        assert_eq!((around.grid().row0, around.grid().col0), (-12, -12));
        assert_eq!(voids(&around, name) + voids(&terrain, name), 0);
        assert_eq!(terrain.grid(), read(folder.path(), name, 0.0).unwrap().around.grid());
    }
}

#[test]
fn a_tile_without_neighbours_is_read_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "N46E008.hgt", |row, _| row == 0);
    write(folder.path(), "N48E008.hgt", |_, _| false);
    let ReadTileOut { terrain, around } = read(folder.path(), "N46E008.hgt", 0.1).unwrap();
    assert_eq!((voids(&terrain, "N46E008.hgt"), voids(&around, "N46E008.hgt")), (SIDE, SIDE));
    assert_eq!(terrain.grid(), around.grid());
    assert!(read(folder.path(), "N47E008.hgt", 0.1).is_err());
}

#[test]
fn shared_samples_come_from_whoever_has_them_and_measured_ones_stay() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "N46E008.hgt", |row, col| row == 1200 && col < 100);
    // South of it lies a tile whose first row has its own void, and other heights.
    write(folder.path(), "N45E008.hgt", |row, col| row == 0 && col < 40);
    let mut bytes = fs::read(folder.path().join("N45E008.hgt")).unwrap();
    bytes[2 * 500..2 * 501].copy_from_slice(&7_i16.to_be_bytes());
    fs::write(folder.path().join("N45E008.hgt"), bytes).unwrap();
    let north = read(folder.path(), "N46E008.hgt", 0.05).unwrap();
    let south = read(folder.path(), "N45E008.hgt", 0.05).unwrap();
    assert_eq!(voids(&north.terrain, "N46E008.hgt"), 40);
    assert_eq!(south.terrain.at(0, 500), 7.0);
    assert_ne!(north.terrain.at(1200, 500), 7.0);
    // The ground around is the same for both.
    assert_eq!(north.around.grid().size(), (SIDE + 60, SIDE));
    for row in 0..=120 {
        let [north, south] = [north.around.row(1140 + row), south.around.row(row)];
        assert!(north.iter().zip(south).all(|(a, b)| a.to_bits() == b.to_bits()), "row {row}");
    }
}

#[test]
fn zipped_neighbours_are_found_and_the_likeliest_name_comes_first() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let zip = |name: &str| {
        let file = fs::File::create(at(&format!("{name}.zip"))).unwrap();
        let mut zip = zip::ZipWriter::new(file);
        zip.start_file(name, zip::write::SimpleFileOptions::default()).unwrap();
        std::io::Write::write_all(&mut zip, &fs::read(at(name)).unwrap()).unwrap();
        zip.finish().unwrap();
        fs::remove_file(at(name)).unwrap();
    };
    for name in ["N46E008.hgt", "N46E009.hgt"] {
        write(folder.path(), name, |_, _| false);
        zip(name);
    }
    // Beside a zipped tile its zipped neighbour comes first, whatever an unpacked one holds.
    fs::write(at("N46E009.hgt"), "no tile").unwrap();
    write(folder.path(), "N46E007.hgt", |_, _| false);
    let ReadTileOut { terrain, around } = read(folder.path(), "N46E008.hgt.zip", 0.01).unwrap();
    assert_eq!((around.grid().size(), around.grid().col0), ((SIDE, SIDE + 24), -12));
    assert_eq!(voids(&around, "N46E008.hgt") + voids(&terrain, "N46E008.hgt"), 0);
}

#[test]
fn missing_corners_are_void_and_sides_without_neighbour_are_not_there() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["N46E008.hgt", "N47E008.hgt", "N46E007.hgt", "N45E009.hgt"] {
        write(folder.path(), name, |_, _| false);
    }
    let ReadTileOut { terrain, around } = read(folder.path(), "N46E008.hgt", 0.02).unwrap();
    assert_eq!((around.grid().size(), around.grid().row0, around.grid().col0), ((1225, 1225), -24, -24));
    assert_eq!(voids(&around, "N46E008.hgt"), 24 * 24);
    assert_eq!(voids(&terrain, "N46E008.hgt"), 0);
}

#[test]
fn neighbours_of_another_kind_are_left_out_and_broken_ones_told() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "N46E008.hgt", |_, _| false);
    fs::write(folder.path().join("N46E009.hgt"), vec![0; 3601 * 3601 * 2]).unwrap();
    let ReadTileOut { terrain, around } = read(folder.path(), "N46E008.hgt", 0.1).unwrap();
    assert_eq!(terrain.grid(), around.grid());
    fs::write(folder.path().join("N46E009.hgt"), "no tile").unwrap();
    let error = read(folder.path(), "N46E008.hgt", 0.1).err().unwrap();
    assert!(error.to_string().contains("N46E009.hgt"), "{error}");
}

#[test]
fn tiles_of_one_arc_second_are_read_alike() {
    let folder = tempfile::tempdir().unwrap();
    let flat = |height: i16| height.to_be_bytes().repeat(3601 * 3601);
    fs::write(folder.path().join("N46E008.hgt"), flat(1)).unwrap();
    fs::write(folder.path().join("N46E009.hgt"), flat(2)).unwrap();
    let ReadTileOut { around, .. } = read(folder.path(), "N46E008.hgt", 0.1).unwrap();
    assert_eq!(around.grid().size(), (3601, 3601 + 360));
    assert_eq!([around.at(9, 3600), around.at(9, 3601)], [1.0, 2.0]);
}
