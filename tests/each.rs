//! One graph for a folder of files.

// A helper that fails is a test that fails.
#![allow(clippy::unwrap_used)]

mod support;

use std::fs;

use support::Place;

/// Small tiles in a folder, and a graph that fills one.
fn tiles() -> Place {
    let place = Place::nodes(
        r#""dem": (node: "io.read_dem", version: 1, params: (file: "none.asc")),
        "fill": (node: "repair.harmonic_fill", version: 1, inputs: {"terrain": "dem.terrain"}),
        "w": (node: "io.write_ascii", version: 1, params: (file: "filled.asc"), inputs: {"terrain": "fill.terrain"}),"#,
    );
    fs::create_dir(place.path("tiles")).unwrap();
    for (name, height) in [("a.asc", 1), ("b.asc", 2), ("c.asc.old", 3)] {
        let rows =
            format!("{height} {height} {height}\n{height} -9999 {height}\n{height} {height} {height}\n");
        let head = "ncols 3\nnrows 3\nxllcorner 0\nyllcorner 0\ncellsize 10\nNODATA_value -9999\n";
        place.write(&format!("tiles/{name}"), format!("{head}{rows}"));
    }
    place
}

#[test]
fn every_file_of_a_folder_is_run_into_a_folder_of_its_own() {
    let place = tiles();
    let line = "run g.ron --each dem.file=tiles/*.asc --set w.file={stem}-filled.asc";
    place
        .ok(line)
        .gives(&["out/a/a-filled.asc", "out/b/b-filled.asc"])
        .tells(&["tiles/a.asc:", "tiles/b.asc:"]);
    let files = place.files("out");
    assert_eq!(files.keys().collect::<Vec<_>>(), ["a/a-filled.asc", "b/b-filled.asc"]);
    for (name, bytes) in &files {
        let text = String::from_utf8(bytes.clone()).unwrap();
        let height = if name.starts_with('a') { "1" } else { "2" };
        assert!(
            text.lines()
                .skip(6)
                .all(|line| line.split_whitespace().all(|cell| cell.parse::<f64>() == height.parse()))
        );
    }
    let manifests = place.ok(&format!("{line} --json --quiet")).out;
    assert_eq!(manifests.lines().filter(|line| line.contains("\"status\"")).count(), 2);
}

#[test]
fn one_bad_file_does_not_keep_the_others_from_being_run() {
    let place = tiles();
    place.write("tiles/a.asc", "ncols x");
    place.run("run g.ron --each dem.file=tiles/*.asc").code(1).tells(&["a.asc", "1 of 2 files failed"]);
    assert_eq!(place.files("out").keys().collect::<Vec<_>>(), ["b/filled.asc"]);
}

#[test]
fn patterns_that_cannot_be_followed_are_refused() {
    let place = tiles();
    for (each, part) in [
        ("dem.file", "has no `=`"),
        ("dem.file=tiles/[", "is no pattern"),
        ("dem.file=tiles/*.hgt", "matches no file"),
        ("dem.nope=tiles/*.asc", "nope"),
    ] {
        place.run(&format!("run g.ron --each {each}")).code(2).tells(&[part]);
    }
    place.write("tiles/a.hgt", "");
    place.run("run g.ron --each dem.file=tiles/a.*").code(2).tells(&["would both write into a"]);
}
