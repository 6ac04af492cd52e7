//! A folder of tiles repaired by one command, each with the ground of its neighbours.

// A helper that fails is a test that fails.
#![allow(clippy::unwrap_used)]

mod support;

use std::{fs, path::Path};

use libm::{cos, hypot, sin};
use support::{Place, computed};

const SIDE: usize = 1201;
const VOID: i16 = i16::MIN;
/// Two by two tiles, named by their south-west corners.
const TILES: [[&str; 2]; 2] = [["N46E008", "N46E009"], ["N45E008", "N45E009"]];

/// Rough hills over all tiles.
fn height(row: usize, col: usize) -> i16 {
    let wave = |length: f64, turn: f64| {
        let (y, x) = (row as f64 / length, col as f64 / length);
        length * (sin(y * cos(turn) + x * sin(turn)) + cos(x * cos(turn) - y * sin(turn)))
    };
    (1500.0 + wave(90.0, 0.3) + wave(37.0, 1.1) + wave(15.0, 2.3) + wave(6.0, 0.7)).round() as i16
}

fn square(difference: i16) -> f64 {
    f64::from(difference) * f64::from(difference)
}

/// Voids across each of the inner edges and across the middle.
fn is_void(row: usize, col: usize) -> bool {
    let within = |at: [f64; 2], radius: f64| hypot(row as f64 - at[0], col as f64 - at[1]) < radius;
    within([1200.0, 1200.0], 30.0)
        || within([300.0, 1190.0], 40.0)
        || within([1204.0, 500.0], 25.0)
        || within([1900.0, 1200.5], 20.0)
        || within([1195.0, 2000.0], 45.0)
        || within([600.0, 600.0], 30.0)
}

/// A folder with the tiles, and a graph that repairs one.
fn tiles() -> Place {
    let graph = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("graphs/repair-tile.ron"));
    let place = Place::with(&graph.unwrap());
    fs::create_dir(place.path("tiles")).unwrap();
    for (down, names) in TILES.iter().enumerate() {
        for (across, name) in names.iter().enumerate() {
            let cells = (0..SIDE * SIDE).map(|i| (down * 1200 + i / SIDE, across * 1200 + i % SIDE));
            let heights = cells.map(|(row, col)| if is_void(row, col) { VOID } else { height(row, col) });
            let bytes: Vec<u8> = heights.flat_map(i16::to_be_bytes).collect();
            place.write(&format!("tiles/{name}.hgt"), bytes);
        }
    }
    place
}

/// The heights of a tile in a folder.
fn read(place: &Place, file: &str) -> Vec<i16> {
    let bytes = fs::read(place.path(file)).unwrap();
    assert_eq!(bytes.len(), SIDE * SIDE * 2);
    bytes.as_chunks::<2>().0.iter().map(|pair| i16::from_be_bytes(*pair)).collect()
}

const EACH: &str = "run g.ron --each file=tiles/*.hgt --set hgt={stem}.hgt";

#[test]
fn a_folder_of_tiles_is_repaired_without_seams() {
    let place = tiles();
    place.ok(EACH);
    let mut error = [0.0, 0.0];
    let repaired =
        TILES.map(|names| names.map(|name| (name, read(&place, &format!("out/{name}/{name}.hgt")))));
    for (down, names) in repaired.iter().enumerate() {
        for (across, (name, filled)) in names.iter().enumerate() {
            for (i, &found) in filled.iter().enumerate() {
                let (row, col) = (down * 1200 + i / SIDE, across * 1200 + i % SIDE);
                if is_void(row, col) {
                    assert_ne!(found, VOID, "{name}: row {row}, column {col}");
                    error[0] += square(found - height(row, col));
                    error[1] += 1.0;
                } else {
                    assert_eq!(found, height(row, col), "{name}: row {row}, column {col}");
                }
            }
        }
    }
    let [[(_, nw), (_, ne)], [(_, sw), (_, se)]] = &repaired;
    for i in 0..SIDE {
        assert_eq!(nw[i * SIDE + 1200], ne[i * SIDE], "row {i} of the northern tiles");
        assert_eq!(sw[i * SIDE + 1200], se[i * SIDE], "row {i} of the southern tiles");
        assert_eq!(nw[1200 * SIDE + i], sw[i], "column {i} of the western tiles");
        assert_eq!(ne[1200 * SIDE + i], se[i], "column {i} of the eastern tiles");
    }
    // Alone, each of the tiles knows one side of a void at its edge, and is farther from the truth.
    place.ok(&format!("{EACH} --out alone --set margin=0"));
    let alone: f64 = TILES
        .iter()
        .enumerate()
        .flat_map(|(down, names)| names.iter().enumerate().map(move |(across, name)| (down, across, name)))
        .flat_map(|(down, across, name)| {
            let filled = read(&place, &format!("alone/{name}/{name}.hgt"));
            let off = move |(i, found): (usize, i16)| {
                let (row, col) = (down * 1200 + i / SIDE, across * 1200 + i % SIDE);
                square(found - height(row, col))
            };
            filled.into_iter().enumerate().map(off).collect::<Vec<_>>()
        })
        .sum();
    let [together, alone] = [error[0], alone].map(|sum| (sum / error[1]).sqrt());
    assert!(together < 0.8 * alone, "{together} m with neighbours, {alone} m without");
}

#[test]
fn only_a_neighbours_change_computes_a_tile_again() {
    let place = tiles();
    let run = |expected: bool, why: &str| {
        let manifest = place.manifest("g.ron --set file=tiles/N46E008.hgt --explain", 0);
        assert_eq!(computed(&manifest) > 0, expected, "{why}: {manifest}");
    };
    run(true, "the first run");
    run(false, "nothing changed");
    fs::copy(place.path("tiles/N45E008.hgt"), place.path("tiles/N48E008.hgt")).unwrap();
    place.write("tiles/notes.txt", "no tile");
    run(false, "files that are no neighbours");
    let mut bytes = fs::read(place.path("tiles/N46E009.hgt")).unwrap();
    bytes[1] ^= 1;
    place.write("tiles/N46E009.hgt", bytes);
    run(true, "a neighbour's heights changed");
    run(false, "nothing changed since");
    fs::remove_file(place.path("tiles/N45E009.hgt")).unwrap();
    run(true, "a neighbour is gone");
    place.write("tiles/N46E009.hgt", "no tile");
    let line = "run g.ron --set file=tiles/N46E008.hgt";
    place.run(line).code(1).tells(&["node `dem` (io.read_tile)", "N46E009.hgt", "hint: "]);
}
