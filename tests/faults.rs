//! What goes wrong around the command: bad input, no room, damaged caches, crowds, and sudden death.

// A helper that fails is a test that fails.
#![allow(clippy::unwrap_used)]

mod support;

use std::{collections::BTreeMap, fs, thread, time::Duration};

use support::{CHAIN, Ended, Place, computed};

/// Cells of the graph that the faults are tried on: enough work for a process to die in the midst of it.
fn larger() -> Place {
    Place::with(&CHAIN.replace("cells: 64", "cells: 256"))
}

#[test]
fn an_output_folder_that_cannot_be_is_told() {
    let place = Place::with(CHAIN);
    place.write("file", "in the way");
    for folder in ["file", "file/deeper"] {
        // Before anything is computed.
        let ended = place.run(&format!("run g.ron --out {folder}")).code(2);
        let ended = ended.tells(&["nothing can be written into", "file is a file, not a folder", "--out"]);
        assert!(!ended.err.contains("computed"), "{ended:?}");
    }
    assert_eq!(fs::read(place.path("file")).unwrap(), b"in the way");
    fs::create_dir_all(place.path("out/flat.tif")).unwrap();
    place.run("run g.ron").code(1).gives(&["flat.asc"]).tells(&["a folder is in the way"]);
}

#[test]
fn a_cache_folder_that_cannot_be_costs_one_warning() {
    let place = Place::with(CHAIN);
    place.write("file", "in the way");
    let ended = place.ok("run g.ron --cache file").tells(&["warning: no cache folder at file", "5 computed"]);
    assert_eq!(ended.err.matches("warning").count(), 1);
    place.run("cache stat --cache file").code(1).tells(&["error: the cache folder file"]);
}

#[cfg(unix)]
mod no_room {
    use std::process::Command;

    use super::*;

    /// Runs where no file may grow beyond `blocks` of 512 or 1024 bytes, as the shell counts.
    fn limited(place: &Place, blocks: u32, line: &str) -> Ended {
        let script = format!("ulimit -f {blocks}; exec \"$0\" {line}");
        let mut command = Command::new("sh");
        command.args(["-c", &script, env!("CARGO_BIN_EXE_orograph")]);
        place.settle(&mut command);
        Ended::new(line, command.output().unwrap())
    }

    #[test]
    fn outputs_without_room_fail_and_leave_nothing() {
        let place = larger();
        limited(&place, 8, "run g.ron --cache none").code(1).gives(&["stats:"]).tells(&[
            "node `tif` (io.write_geotiff): writing out/flat.tif: File too large",
            "node `asc` (io.write_ascii): writing out/flat.asc: File too large",
            "the disk has room",
        ]);
        assert!(place.files("out").is_empty());
    }

    /// Limits that stop a write at its first byte, early, half-way and at its end, up to where everything fits.
    fn limits() -> impl Iterator<Item = u32> {
        (0..12).chain((12..48).step_by(3)).chain((48..1024).step_by(61)).chain([1 << 14])
    }

    #[test]
    fn wherever_an_output_ends_it_is_whole_or_not_there() {
        let place = larger();
        place.ok("run g.ron --cache none --out expected");
        let expected = place.files("expected");
        let (mut none, mut some, mut all) = (0, 0, 0);
        for blocks in limits() {
            let out = format!("out{blocks}");
            let ended = limited(&place, blocks, &format!("run g.ron --cache none --out {out}"));
            let files = place.files(&out);
            for (name, bytes) in &files {
                assert!(expected.get(name) == Some(bytes), "{name} is torn at {blocks} blocks: {ended:?}");
            }
            // What is missing is told, by its name.
            let missing: Vec<_> = expected.keys().filter(|name| !files.contains_key(*name)).collect();
            for name in &missing {
                let told = format!("writing {out}/{name}: File too large");
                assert!(ended.err.contains(&told), "{blocks} blocks: {ended:?}");
            }
            ended.code(i32::from(!missing.is_empty())).gives(&["stats:"]);
            *[&mut all, &mut some, &mut none][missing.len()] += 1;
        }
        assert!(
            none > 5 && some > 0 && all > 0,
            "{none} without any, {some} with one and {all} with all outputs"
        );
    }

    #[test]
    fn wherever_a_write_of_the_cache_ends_results_are_right_and_nothing_torn_is_left() {
        let place = larger();
        place.ok("run g.ron --cache none --out expected");
        let expected = place.files("expected");
        let (mut failed, mut kept) = (0, 0);
        for blocks in limits() {
            // No output is written, so that every write that fails is one of the cache.
            let ended = limited(&place, blocks, "run g.ron stats").code(0).gives(&["stats:"]);
            let warnings = ended.err.matches("warning: ").count();
            assert!(warnings <= 1, "{blocks} blocks: {ended:?}");
            let left = place.files("cache");
            let is_torn = |name: &str, bytes: &[u8]| name.starts_with("v1/tmp") || bytes.is_empty();
            assert!(
                !left.iter().any(|(name, bytes)| is_torn(name, bytes)),
                "{blocks} blocks: {:?}",
                left.keys()
            );
            failed += warnings;
            kept += 1 - warnings;
            // What did get in is good: the next run, with room, builds on it.
            place.ok(&format!("run g.ron --out out{blocks}"));
            assert!(place.files(&format!("out{blocks}")) == expected, "{blocks} blocks");
            fs::remove_dir_all(place.path("cache")).unwrap();
        }
        assert!(failed > 5 && kept > 0, "{failed} runs with a failing cache, {kept} with a whole one");
    }

    #[test]
    fn a_cache_without_room_degrades_to_memory() {
        let place = larger();
        place.ok("run g.ron --cache none --out expected");
        let line = "run g.ron stats ground --set hills.cells=256";
        let ended = limited(&place, 8, "run g.ron stats").code(0).gives(&["stats:"]);
        assert_eq!(ended.err.matches("warning: results are kept in memory alone").count(), 1, "{ended:?}");
        assert!(place.files("cache/v1/tmp").is_empty());
        place.ok(line);
        place.ok("run g.ron");
        let (expected, out) = (place.files("expected"), place.files("out"));
        assert!(expected.iter().all(|(name, bytes)| out.get(name) == Some(bytes)));
    }
}

/// Bytes that are no elevation model, or were one.
fn spoiled(good: &[u8]) -> Vec<Vec<u8>> {
    let mut all = vec![Vec::new(), b"x".to_vec(), vec![0; 64], vec![0xff; 4096]];
    for part in [1, 4, 8, 16, 40, good.len() / 2, good.len() - 1] {
        all.push(good[..part.min(good.len())].to_vec());
    }
    // Headers hold sizes and offsets; each byte of them becomes the worst it can be in turn.
    for at in (0..good.len().min(96)).step_by(3) {
        let mut bytes = good.to_vec();
        bytes[at..(at + 4).min(good.len())].fill(0xff);
        all.push(bytes);
    }
    all
}

#[test]
fn spoiled_rasters_are_an_error_and_never_a_fall() {
    let place = Place::nodes(
        r#""a": (node: "generate.fbm", version: 1, params: (cells: 24)),
        "tif": (node: "io.write_geotiff", version: 1, params: (file: "x.tif"), inputs: {"terrain": "a.terrain"}),
        "asc": (node: "io.write_ascii", version: 1, params: (file: "x.asc"), inputs: {"terrain": "a.terrain"}),
        "png": (node: "io.write_png", version: 1, params: (file: "x.png"), inputs: {"terrain": "a.terrain"}),
        "exr": (node: "io.write_exr", version: 1, params: (file: "x.exr"), inputs: {"terrain": "a.terrain"}),"#,
    );
    place.ok("run g.ron");
    let read = |reader: &str, extension: &str| {
        let mut nodes = String::new();
        let good = fs::read(place.path(&format!("out/x.{extension}"))).unwrap();
        let all = spoiled(&good);
        for (index, bytes) in all.iter().enumerate() {
            let file = format!("{index}.{extension}");
            place.write(&file, bytes);
            nodes += &format!(
                r#""r{index}": (node: "{reader}", version: 1, params: (file: "{file}")),
                "m{index}": (node: "measure.statistics", version: 1, inputs: {{"terrain": "r{index}.terrain"}}),
                "w{index}": (node: "io.write_table", version: 1, params: (file: "{extension}{index}.csv"),
                    inputs: {{"table": "m{index}.metrics"}}),"#
            );
        }
        place.write("r.ron", format!("(format: 1, nodes: {{{nodes}}})"));
        // Some spoiled bytes are heights, which nothing tells from true ones; the rest must fail, each by itself.
        let manifest = place.manifest("r.ron --cache none --memory 256MiB", 1);
        let nodes = manifest["nodes"].as_array().unwrap();
        let failed: BTreeMap<_, _> = nodes
            .iter()
            .filter(|node| node["outcome"] == "failed")
            .map(|node| (node["name"].as_str().unwrap(), node))
            .collect();
        for (name, node) in &failed {
            let error = node["error"].as_str().unwrap();
            assert!(!error.contains("the node panicked") && node["hint"].is_string(), "{name}: {node}");
        }
        for index in 0..8 {
            assert!(failed.contains_key(&*format!("r{index}")), "{extension} {index} was read: {manifest}");
        }
    };
    read("io.read_dem", "tif");
    read("io.read_dem", "asc");
    read("io.read_png", "png");
    read("io.read_exr", "exr");
    // Every length is a tile of some kind or none; these are none.
    for (index, bytes) in [0, 1, 2, 1201 * 1201 * 2 - 1, 1201 * 1201 * 2 + 2].into_iter().enumerate() {
        place.write("N45E007.hgt", vec![0; bytes]);
        place.write(
            "h.ron",
            r#"(format: 1, nodes: {"r": (node: "io.read_dem", version: 1, params: (file: "N45E007.hgt"))})"#,
        );
        place.run("run h.ron r.terrain").code(1).tells(&["node `r`", "N45E007.hgt", "hint: "]);
        assert!(!place.path("out/r.terrain.tif").exists(), "{index}");
    }
}

#[test]
fn absurd_sizes_are_refused_before_memory_is_taken() {
    let place = Place::with("");
    place.write(
        "big.asc",
        "ncols 4000000000\nnrows 4000000000\nxllcorner 0\nyllcorner 0\ncellsize 1\nNODATA_value -9999\n1 2 3\n",
    );
    // A PNG header of 2³⁰ × 2³⁰ grey cells of 16 bits,.
    let mut png = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR".to_vec();
    png.extend([0x40, 0, 0, 0, 0x40, 0, 0, 0, 16, 0, 0, 0, 0, 0, 0, 0, 0]);
    place.write("big.png", png);
    for (reader, file) in [("io.read_dem", "big.asc"), ("io.read_png", "big.png")] {
        place.write(
            "g.ron",
            format!(
                r#"(format: 1, nodes: {{"r": (node: "{reader}", version: 1, params: (file: "{file}"))}})"#
            ),
        );
        place.run("run g.ron r.terrain").code(1).tells(&["node `r`", "hint: "]);
    }
}

#[test]
fn rasters_of_voids_and_of_one_cell_pass_or_say_why() {
    let place = Place::with("");
    let head = |n: usize| {
        format!("ncols {n}\nnrows {n}\nxllcorner 0\nyllcorner 0\ncellsize 30\nNODATA_value -9999\n")
    };
    place.write("voids.asc", head(4) + &"-9999 -9999 -9999 -9999\n".repeat(4));
    place.write("nan.asc", head(2) + "nan nan\nnan nan\n");
    place.write("one.asc", head(1) + "7\n");
    let mut nodes = String::new();
    for file in ["voids", "nan", "one"] {
        nodes += &format!(r#""{file}": (node: "io.read_dem", version: 1, params: (file: "{file}.asc")),"#);
        for (index, node) in [
            "adjust.clamp",
            "adjust.normalise",
            "filter.gaussian_blur",
            "filter.median",
            "mask.voids",
            "measure.statistics",
            "mask.from_slope",
            "look.hillshade",
            "look.colour_relief",
            "look.contours",
            "repair.harmonic_fill",
            "transform.resize",
            "io.write_geotiff",
            "io.write_ascii",
        ]
        .iter()
        .enumerate()
        {
            let params = match *node {
                "io.write_geotiff" => format!("file: \"{file}.tif\""),
                "io.write_ascii" => format!("file: \"{file}.asc\""),
                _ => String::new(),
            };
            nodes += &format!(
                r#""{file}{index}": (node: "{node}", version: 1, params: ({params}), inputs: {{"terrain": "{file}.terrain"}}),"#
            );
        }
    }
    let outputs: Vec<_> = ["voids", "nan", "one"]
        .iter()
        .flat_map(|file| (0..14).map(move |index| format!("{file}{index}")))
        .collect();
    place.write("g.ron", format!("(format: 1, nodes: {{{nodes}}})"));
    let ended = place.run(&format!("run g.ron --json {}", outputs.join(" ")));
    let manifest = ended.json();
    for node in manifest["nodes"].as_array().unwrap() {
        // What makes no sense of one cell may say so; writing and clamping it makes sense.
        let plain = node["node"] != "io.read_dem" && !node["node"].as_str().unwrap().starts_with("look.");
        if plain && node["name"].as_str().unwrap().starts_with("one") {
            assert_ne!(node["outcome"], "failed", "{node}");
        }
        if node["outcome"] == "failed" {
            let error = node["error"].as_str().unwrap();
            assert!(!error.contains("panicked") && node["hint"].is_string(), "{node}");
        }
    }
}

#[test]
fn a_damaged_cache_gives_the_right_bytes() {
    let place = Place::with(CHAIN);
    place.ok("run g.ron --cache none --out expected");
    let expected = place.files("expected");
    place.ok("run g.ron");
    let sound = place.files("cache");
    let names: Vec<_> = sound.keys().filter(|name| name.starts_with("v1")).cloned().collect();
    assert!(names.len() >= 10, "{names:?}");
    type Damage = fn(&[u8], &[u8]) -> Vec<u8>;
    let damages: [(&str, Damage); 6] = [
        ("emptied", |_, _| Vec::new()),
        ("truncated", |own, _| own[..own.len() / 2].to_vec()),
        ("flipped", |own, _| {
            let mut bytes = own.to_vec();
            let middle = bytes.len() / 2;
            bytes[middle] ^= 1;
            bytes
        }),
        ("lengthened", |own, _| [own, b"more"].concat()),
        ("swapped", |_, other| other.to_vec()),
        ("of another version", |own, _| [b"OROVAL99", &own[8..]].concat()),
    ];
    for (name, damage) in damages {
        for (index, file) in names.iter().enumerate() {
            let other = &sound[&names[(index + 1) % names.len()]];
            place.write(&format!("cache/{file}"), damage(&sound[file], other));
        }
        let _ = fs::remove_dir_all(place.path("out"));
        place.ok("run g.ron").gives(&["highest [m]     100"]);
        assert!(place.files("out") == expected, "{name}");
        // And it healed.
        assert_eq!(computed(&place.manifest("g.ron", 0)), 0, "{name}");
    }
}

#[test]
fn many_processes_share_a_cache() {
    let place = larger();
    place.ok("run g.ron --cache none --out expected");
    let expected = place.files("expected");
    thread::scope(|scope| {
        for worker in 0..8 {
            let (place, expected) = (&place, &expected);
            scope.spawn(move || {
                for _ in 0..3 {
                    let ended = place.ok(&format!("run g.ron --jobs 1 --out out{worker}"));
                    assert!(!ended.err.contains("warning"), "{ended:?}");
                    assert!(place.files(&format!("out{worker}")) == *expected, "worker {worker}");
                    if worker == 7 {
                        place.ok("cache gc --max 1KiB");
                    }
                }
            });
        }
    });
}

#[test]
fn a_hundred_deaths_leave_no_torn_file_and_no_poisoned_cache() {
    let place = larger();
    place.ok("run g.ron --cache none --out expected");
    let expected = place.files("expected");
    let mut state = 0x9e37_79b9_u64;
    for death in 1..=100 {
        // Numerical Recipes' generator: any spread of moments will do.
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let mut child = place.command("run g.ron --jobs 2").spawn().unwrap();
        thread::sleep(Duration::from_millis((state >> 33) % 45));
        child.kill().unwrap();
        child.wait().unwrap();
        for (name, bytes) in place.files("out") {
            let temporary = name.starts_with(".orograph-") && name.ends_with(".tmp");
            assert!(temporary || expected.get(&name) == Some(&bytes), "{name} is torn after {death} deaths");
        }
        if death % 10 == 0 {
            place.ok("run g.ron");
            // Nothing that the dead left under way is there either.
            assert!(place.files("out") == expected, "after {death} deaths");
            place.ok("cache gc --max 1GiB");
            fs::remove_dir_all(place.path("out")).unwrap();
        }
        if death % 4 == 0 {
            // Half of the deaths meet a cold cache.
            place.ok("cache clear");
        }
    }
    place.ok("run g.ron");
    assert!(place.files("out") == expected);
}
