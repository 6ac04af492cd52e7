//! `orograph sweep`: every combination runs, and the sheet and the tables tell them apart.

// A helper that fails is a test that fails.
#![allow(clippy::unwrap_used)]

mod support;

use std::fs;

use orograph_core::{InputPath, Job, Node};
use orograph_nodes::io::read_texture::ReadTexture;
use support::{CHAIN, Place};

/// Level ground and hills under three limits.
const GRID: &str = "sweep g.ron --param flat.highest=20,40,60 --param hills.amplitude=0,500 --thumbnail 64";

fn csv(place: &Place) -> Vec<Vec<String>> {
    let text = fs::read_to_string(place.path("out/sweep.csv")).unwrap();
    text.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

#[test]
fn the_tables_have_a_row_for_each_combination() {
    let place = Place::with(CHAIN);
    place.ok(GRID).gives(&["flat.highest", "hills.amplitude", "sweep.csv", "sweep.json", "sweep-ground.png"]);
    let rows = csv(&place);
    assert_eq!(rows[0][..2], ["flat.highest", "hills.amplitude"]);
    let set: Vec<_> = rows[1..].iter().map(|row| (row[0].as_str(), row[1].as_str())).collect();
    assert_eq!(set, [("20", "0"), ("20", "500"), ("40", "0"), ("40", "500"), ("60", "0"), ("60", "500")]);
    let highest = rows[0].iter().position(|name| name == "stats.highest [m]").unwrap();
    let values: Vec<f64> = rows[1..].iter().map(|row| row[highest].parse().unwrap()).collect();
    assert_eq!(values, [0.0, 20.0, 0.0, 40.0, 0.0, 60.0]);
    // A combination's metrics are those of a run with its settings.
    let mean = rows[0].iter().position(|name| name == "stats.mean [m]").unwrap();
    let single = place.manifest("g.ron stats --set flat.highest=60 --set hills.amplitude=500", 0);
    assert_eq!(rows[6][mean].parse::<f64>().ok(), single["results"]["stats"]["mean"]["values"][0].as_f64());
    // JSON says the same as CSV.
    let json: serde_json::Value =
        serde_json::from_slice(&fs::read(place.path("out/sweep.json")).unwrap()).unwrap();
    assert_eq!(json["units"]["stats.highest"], "m");
    let told = json["rows"].as_array().unwrap().iter().map(|row| row["stats.highest"].as_f64().unwrap());
    assert_eq!(told.collect::<Vec<_>>(), values);
}

#[test]
fn the_sheet_shows_each_combination_with_its_label() {
    let place = Place::with(CHAIN);
    place.ok(GRID);
    let file = InputPath(place.path("out/sweep-ground.png").display().to_string());
    let sheet = ReadTexture { file, cell: 1.0 }.run((), &Job::detached()).unwrap().texture;
    let (rows, cols) = sheet.grid().size();
    // Two columns, as the last parameter has two values, of 64 pixels with 12 between.
    assert_eq!(cols, 12 + 2 * (64 + 12));
    let paper = sheet.at(0, 0);
    let ink = |row: usize, left: usize| (left..left + 64).any(|col| sheet.at(row, col) != paper);
    for left in [12, 12 + 76] {
        // Down a column: bands of ink are the pictures and the labels beneath them, title aside.
        let bands: Vec<usize> = (1..rows).filter(|&row| ink(row, left) && !ink(row - 1, left)).collect();
        let tall = |&from: &usize| (from..rows).take_while(|&row| ink(row, left)).count() >= 64;
        let pictures = bands.iter().filter(|from| tall(from)).count();
        assert_eq!(pictures, 3, "{bands:?}");
        assert!(bands.len() >= 6, "a label is missing: {bands:?}");
    }
    assert!(rows > 3 * (64 + 12));
}

#[test]
fn what_cannot_be_swept_ends_with_2() {
    let place = Place::with(CHAIN);
    for (params, parts) in [
        ("--param flat.highest=20,1e9", &["outside its range -20000 to 20000"] as &[_]),
        ("--param flat.highest=20,high", &["takes a number"]),
        ("--param flat.hihest=20", &["no parameter `hihest`", "did you mean `highest`?"]),
        ("--param flat.highest", &["has no `=`", "name=v1,v2,v3"]),
        ("--param flat.highest=1,,2", &["has an empty value"]),
        ("--param flat.highest=0..10", &["has no count"]),
        ("--param flat.highest=0..10/3 --limit 2", &["3 combinations, more than 2"]),
        ("", &["--param"]),
    ] {
        let ended = place.run(&format!("sweep g.ron {params}")).code(2).tells(parts);
        assert_eq!(ended.out, "", "{params}");
    }
    assert!(!place.path("out").exists());
}

#[test]
fn a_combination_that_fails_leaves_the_others() {
    let place = Place::with(CHAIN);
    let ended = place.run("sweep g.ron --param hills.cells=16,65536 --memory 16MiB --thumbnail 64").code(1);
    ended.tells(&["65536 × 65536", "hint: "]);
    let rows = csv(&place);
    let highest = rows[0].iter().position(|name| name == "stats.highest [m]").unwrap();
    assert_eq!((rows.len(), rows[1][0].as_str(), rows[2][0].as_str()), (3, "16", "65536"));
    assert!(rows[1][highest].parse::<f64>().is_ok() && rows[2][highest].parse::<f64>().is_err(), "{rows:?}");
    assert!(place.path("out/sweep-ground.png").is_file());
}

#[test]
fn a_graph_that_names_no_picture_is_swept_by_those_that_it_writes() {
    let place = Place::nodes(
        r#""hills": (node: "generate.fbm", version: 1, params: (cells: 16)),
        "shade": (node: "look.hillshade", version: 1, inputs: {"terrain": "hills.terrain"}),
        "write": (node: "io.write_texture", version: 1, inputs: {"texture": "shade.picture"}),"#,
    );
    place
        .ok("sweep g.ron --param hills.seed=1,2 --thumbnail 64")
        .gives(&["sweep-shade-picture.png", "sweep.csv"]);
}
