//! The command as its users meet it: exit codes, streams, messages and files.

// A helper that fails is a test that fails.
#![allow(clippy::unwrap_used)]

mod support;

use std::{fs, time::Duration};

use support::{CHAIN, Ended, Place, computed, outcome};

/// A generator and a writer whose `file` is given.
fn writing(file: &str) -> Place {
    Place::nodes(&format!(
        r#""a": (node: "generate.fbm", version: 1, params: (cells: 16)),
        "w": (node: "io.write_geotiff", version: 1, params: (file: "{file}"), inputs: {{"terrain": "a.terrain"}}),"#
    ))
}

#[test]
fn a_run_writes_files_and_prints_results_alone_on_standard_output() {
    let place = Place::with(CHAIN);
    let ended = place.ok("run g.ron").gives(&["stats:", "highest [m]", "100", "flat.tif", "flat.asc"]);
    let ended = ended.tells(&["computed hills", "5 computed, 0 found in the cache"]);
    assert!(!ended.out.contains("computed"), "{ended:?}");
    assert_eq!(place.files("out").keys().collect::<Vec<_>>(), ["flat.asc", "flat.tif"]);
    assert_eq!(place.ok("run g.ron --quiet").err, "");
}

#[test]
fn what_succeeded_is_kept_when_a_node_fails() {
    let place = Place::nodes(
        r#""a": (node: "io.read_dem", version: 1, params: (file: "no.tif")),
        "w": (node: "io.write_geotiff", version: 1, inputs: {"terrain": "a.terrain"}),
        "c": (node: "generate.constant", version: 1, params: (cells: 8)),
        "v": (node: "io.write_ascii", version: 1, params: (file: "y.asc"), inputs: {"terrain": "c.terrain"}),"#,
    );
    place.run("run g.ron --explain").code(1).gives(&["y.asc"]).tells(&[
        "node `a` (io.read_dem)",
        "no.tif",
        "No such file",
        "hint: ",
        "skipped",
        "`a` failed",
    ]);
    assert_eq!(place.files("out").keys().collect::<Vec<_>>(), ["y.asc"]);
    let manifest = place.manifest("g.ron", 1);
    assert_eq!(manifest["status"], "failed");
    assert_eq!(outcome(&manifest, "w"), "skipped");
    let failed = manifest["nodes"].as_array().unwrap().iter().find(|node| node["name"] == "a").unwrap();
    assert!(failed["error"].as_str().unwrap().contains("no.tif") && failed["hint"].is_string());
    place.ok("check g.ron").gives(&["ok"]).tells(&["warning: g.ron: a.file", "no.tif"]);
}

#[test]
fn a_wrong_command_line_ends_with_2() {
    let place = Place::with(CHAIN);
    for (line, parts) in [
        ("frob", &["unrecognized subcommand 'frob'"] as &[_]),
        ("run g.ron --frob", &["unexpected argument '--frob'"]),
        ("run", &["<GRAPH>"]),
        ("run none.ron", &["none.ron", "No such file", "hint: "]),
        ("run .", &["directory"]),
        ("run g.ron --memory lots", &["`lots` is no size"]),
        ("run g.ron --jobs 100000000", &["not in 0..=1024"]),
        ("run g.ron --jobs -1", &["not in 0..=1024"]),
        ("run g.ron --seed -1", &["invalid value '-1'"]),
        ("run g.ron --resolution 0", &["not in 1..=131072"]),
        ("run g.ron --set flat.highest", &["has no `=`", "node.param=value"]),
        ("run g.ron --set flat.hihest=1", &["no parameter `hihest`", "did you mean `highest`?"]),
        ("run g.ron --set falt.highest=1", &["no node `falt`", "did you mean `flat`?"]),
        ("run g.ron --set flat.highest=1e9", &["outside its range -20000 to 20000", "hint: "]),
        ("run g.ron --set flat.highest=high", &["takes a number"]),
        ("run g.ron --set grund=1", &["exposes no parameter `grund`"]),
        ("run g.ron grund", &["no output `grund`", "`ground`"]),
        ("run g.ron hills.terain", &["no output `hills.terain`", "did you mean `hills.terrain`?"]),
        ("run g.ron --vars none.json", &["none.json", "No such file"]),
        ("nodes generate.fmb", &["no node type `generate.fmb`", "did you mean `generate.fbm`?"]),
        ("nodes hilshade", &["did you mean `look.hillshade`?"]),
        ("nodes zzzzzzzzzz", &["`orograph nodes` lists them all"]),
        ("cache stat --cache none", &["no cache folder"]),
        ("completions fish-and-chips", &["possible values"]),
        ("check g.ron none.ron", &["none.ron"]),
    ] {
        let ended = place.run(line).code(2).tells(parts);
        assert!(!line.starts_with("run") || ended.out.is_empty(), "{ended:?}");
    }
    assert!(!place.path("out").exists());
}

#[test]
fn a_wrong_graph_ends_with_2_and_tells_the_place() {
    let generator = r#""a": (node: "generate.fbm", version: 1, params: (cells: 16)),"#;
    let writer = r#""w": (node: "io.write_geotiff", version: 1, inputs: {"terrain": "a.terrain"}),"#;
    for (nodes, parts) in [
        (
            r#""a": (node: "generate.fbm" version: 1),"#.to_owned(),
            &["g.ron:4:28: expected `,` or `)`"] as &[_],
        ),
        (
            r#""a": (node: "generate.fbm", version: 1, params: (octavs: 3)),"#.into(),
            &[
                "g.ron:4:50: `generate.fbm` has no parameter `octavs`",
                "^^^^^^",
                "hint: did you mean `octaves`?",
            ],
        ),
        (
            r#""a": (node: "generate.fbm", version: 1, params: (cells: 99999999)),"#.into(),
            &["range 1 to 65537"],
        ),
        (r#""a": (node: "generate.fbm", version: 1, params: (gain: 1e999)),"#.into(), &["g.ron:4:", "1e999"]),
        (
            format!(
                r#"{generator} "b": (node: "adjust.clamp", version: 1, inputs: {{"terrain": "a.terain"}}),"#
            ),
            &["no output `terain`", "`terrain`"],
        ),
        (
            format!(
                r#"{generator} "b": (node: "adjust.clamp", version: 1, inputs: {{"terain": "a.terrain"}}),"#
            ),
            &["no input `terain`", "did you mean `terrain`?"],
        ),
        (
            r#""a": (node: "adjust.clamp", version: 1, inputs: {"terrain": "b.terrain"}),
        "b": (node: "adjust.clamp", version: 1, inputs: {"terrain": "a.terrain"}),"#
                .into(),
            &["a cycle: a → b → a"],
        ),
        (
            format!(
                r#"{generator} "h": (node: "look.hillshade", version: 1,
            inputs: {{"terrain": "a.terrain", "onto": "a.terrain"}}),"#
            ),
            &["`a.terrain` gives a Heightfield, but `h.onto` takes a Texture"],
        ),
        (
            format!("{generator} {writer} {}", writer.replace("\"w\"", "\"v\"")),
            &["`w` and `v` would both write terrain.tif"],
        ),
        (
            format!("{} {writer}", generator.replace("fbm", "fbn")),
            &["g.ron:4:13: there is no node type `generate.fbn`", "did you mean `generate.fbm`?"],
        ),
        (r#""a": (node: "adjust.clamp", version: 1),"#.into(), &["not connected", "Heightfield"]),
        (
            format!(
                r#""a": (node: "x", version: 1, params: (p: {}1{})),"#,
                "[".repeat(90_000),
                "]".repeat(90_000)
            ),
            &["nest deeper than"],
        ),
        ("}".into(), &["g.ron:"]),
    ] {
        let place = Place::nodes(&nodes);
        let ended = place.run("run g.ron").code(2).tells(parts);
        assert_eq!(ended.out, "");
        // One headline an error, and a long line in part.
        let first = ended.err.lines().next().unwrap();
        assert_eq!(ended.err.matches(first).count(), 1, "{}", ended.err);
        assert!(ended.err.len() < 4000, "{}", ended.err.len());
        assert!(!place.path("out").exists());
    }
}

#[test]
fn no_bytes_for_a_graph_make_it_stumble() {
    let place = Place::with("");
    place.run("run g.ron").code(2).tells(&["expected a graph", "the file is empty"]);
    for bytes in [
        &b"\xff\xfe\x00("[..],
        b"(format: 2, nodes: {})",
        b"(((((",
        b"\"",
        b"(format: 1, nodes: {\"\": ()})",
        b"\0\0\0",
    ] {
        place.write("g.ron", bytes);
        for line in ["run g.ron", "check g.ron", "graph g.ron", "graph --ron g.ron"] {
            place.run(line).code(2).tells(&["error: g.ron"]);
        }
    }
}

#[test]
fn output_names_stay_in_the_output_folder() {
    for file in ["/abs.tif", "../x.tif", "a/../../x.tif", "", ".", "C:/x.tif", "//host/x.tif"] {
        let place = writing(file);
        place.run("run g.ron").code(2).tells(&["g.ron:5:", "`file` is", "hint: "]);
        assert_eq!(place.files("").len(), 1, "{file}");
    }
    let place = writing("deep/er/x.tif");
    place.ok("run g.ron --out some/where");
    assert!(place.path("some/where/deep/er/x.tif").is_file());
}

#[test]
fn settings_come_from_the_graph_then_the_file_then_the_line() {
    let place = Place::with(CHAIN);
    place.write("v.json", r#"{"flat.highest": 40, "hills.cells": 32}"#);
    place.write("v.ron", r#"{"flat.highest": 30.5, /* few */ "hills.cells": 8}"#);
    let value = |line: &str, column: &str| {
        place.manifest(&format!("g.ron stats {line}"), 0)["results"]["stats"][column]["values"][0]
            .as_f64()
            .unwrap()
    };
    assert_eq!(value("", "rows"), 64.0);
    assert_eq!((value("--vars v.json", "rows"), value("--vars v.json", "highest")), (32.0, 40.0));
    assert_eq!((value("--vars v.ron", "rows"), value("--vars v.ron", "highest")), (8.0, 30.5));
    assert_eq!(value("--vars v.json --set hills.cells=16", "rows"), 16.0);
    assert_eq!(value("--set hills.cells=16 --set hills.cells=17", "rows"), 17.0);
    assert_eq!(value("--resolution 24", "rows"), 24.0);
    assert_ne!(value("--seed 1", "mean"), value("--seed 2", "mean"));
    place.write("v.json", "{bad");
    place.run("run g.ron --vars v.json").code(2).tells(&["v.json:1:2", "hint: write a map"]);
}

#[test]
fn a_preview_at_half_the_resolution_looks_like_the_build() {
    let place = Place::with(CHAIN);
    let heights = |resolution: usize| -> Vec<Vec<f64>> {
        place.ok(&format!(
            "run g.ron asc --resolution {resolution} --set flat.lowest=-5000 --set flat.highest=5000"
        ));
        let text = fs::read_to_string(place.path("out/flat.asc")).unwrap();
        let rows = text.lines().filter(|line| !line.starts_with(|c: char| c.is_ascii_alphabetic()));
        rows.map(|row| row.split_whitespace().map(|x| x.parse().unwrap()).collect()).collect()
    };
    let (build, preview) = (heights(128), heights(64));
    assert_eq!((build.len(), preview.len(), preview[0].len()), (128, 64, 64));
    let (mut error, mut power) = (0.0, 0.0);
    for (row, line) in preview.iter().enumerate() {
        for (col, height) in line.iter().enumerate() {
            let (r, c) = (2 * row, 2 * col);
            let mean = (build[r][c] + build[r + 1][c] + build[r][c + 1] + build[r + 1][c + 1]) / 4.0;
            error += (height - mean) * (height - mean);
            power += height * height;
        }
    }
    assert!(error < 0.02 * power, "the share of the difference is {}", error / power);
}

#[test]
fn threads_and_caches_change_no_byte() {
    let place = Place::with(CHAIN);
    place.ok("run g.ron --cache none --jobs 1 --out one");
    let expected = place.files("one");
    assert!(!place.path("cache").exists());
    for (index, options) in ["--jobs 2 --cache none", "--jobs 8", "", "--memory 64KiB"].iter().enumerate() {
        place.ok(&format!("run g.ron {options} --out out{index}"));
        assert!(place.files(&format!("out{index}")) == expected, "{options}");
    }
}

#[test]
fn too_little_memory_is_told_with_what_to_do() {
    let place = Place::with(CHAIN);
    let ended = place.run("run g.ron --memory 1KiB").code(1);
    ended.tells(&["node `flat`", "64 × 64", "16384 bytes", "1024 allowed", "hint: ", "--memory"]);
    place.run("run g.ron --set hills.cells=65536 --memory 64MiB").code(1).tells(&["65536 × 65536"]);
    assert!(place.files("out").is_empty());
}

#[test]
fn the_manifest_tells_everything_about_a_run() {
    let place = Place::with(CHAIN);
    let manifest = place.manifest("g.ron", 0);
    assert_eq!(
        (&manifest["status"], &manifest["orograph"]),
        (&"ok".into(), &env!("CARGO_PKG_VERSION").into())
    );
    let is_digest = |json: &serde_json::Value| json.as_str().is_some_and(|text| text.len() == 64);
    let nodes = manifest["nodes"].as_array().unwrap();
    assert_eq!(nodes.len(), 5);
    for node in nodes {
        assert!(is_digest(&node["key"]) && node["version"] == 1 && node["seconds"].is_f64(), "{node}");
        assert!(node["reason"].is_string() && node["outputs"].as_object().unwrap().values().all(is_digest));
    }
    let files = manifest["files"].as_array().unwrap();
    assert_eq!(files.len(), 2);
    for file in files {
        let bytes = fs::metadata(place.path("out").join(file["name"].as_str().unwrap())).unwrap().len();
        assert!(file["bytes"] == bytes && is_digest(&file["digest"]) && is_digest(&file["key"]), "{file}");
    }
    assert_eq!(manifest["results"]["stats"]["highest"]["unit"], "m");
    assert_eq!(manifest["results"]["stats"]["highest"]["values"][0], 100.0);
}

#[test]
fn another_process_computes_only_what_changed() {
    let place = Place::with(CHAIN);
    place.ok("run g.ron");
    assert_eq!(computed(&place.manifest("g.ron", 0)), 0);
    let only_last = place.manifest("g.ron --set tif.sample=int16", 0);
    assert_eq!((computed(&only_last), outcome(&only_last, "tif")), (1, "computed"));
    let half = "run g.ron --explain --set flat.highest=50";
    place.ok(half).tells(&[
        "`highest` changed from 100 to 50",
        "its input `terrain` changed (flat.terrain)",
        "4 computed",
    ]);
    // Layout and comments never count.
    place.write("g.ron", format!("// A remark.\n{}", CHAIN.replace("\n ", "\n    ")));
    place.ok(half).tells(&["0 computed", "its files are in place", "its recipe is known"]);
    // An output that was tampered with is written again.
    place.write("out/flat.asc", "oops");
    let again = place.manifest("g.ron --set flat.highest=50", 0);
    assert_eq!((computed(&again), outcome(&again, "asc")), (1, "computed"));
    place.ok("run g.ron --timings --set flat.highest=60").tells(&[" ms", "adjust.clamp"]);
}

#[test]
fn a_dry_run_computes_and_writes_nothing() {
    let place = Place::with(CHAIN);
    place.ok("run g.ron --dry-run").gives(&["hills", "generate.fbm", "to compute"]);
    assert!(!place.path("out").exists());
    assert_eq!(place.ok("cache stat --json").json()["stat"]["values"], 0);
    place.ok("run g.ron");
    place.ok("run g.ron --dry-run --set flat.highest=7").gives(&["in the cache", "to compute"]);
    let plan = place.ok("run g.ron --dry-run --json").json();
    assert_eq!(plan["status"], "planned");
    assert_eq!(plan["nodes"][0]["plan"], "in the cache");
}

#[test]
fn outputs_are_chosen_by_writer_port_or_name() {
    let place = Place::with(CHAIN);
    place.ok("run g.ron ground hills.terrain tif stats ground").gives(&["stats:", "ground.tif"]);
    assert_eq!(
        place.files("out").keys().collect::<Vec<_>>(),
        ["flat.tif", "ground.tif", "hills.terrain.tif"]
    );
    let files = place.files("out");
    assert_eq!(files["ground.tif"], files["hills.terrain.tif"]);
    assert!(place.ok("run g.ron stats --out other").out.starts_with("stats:"));
    assert!(!place.path("other").exists());
    let place = Place::nodes(r#""a": (node: "generate.constant", version: 1),"#);
    place.run("run g.ron").code(2).tells(&["writes nothing", "hint: ask for an output"]);
}

#[test]
fn a_node_of_unknown_type_is_refused_only_where_it_is_needed() {
    let place = Place::with(
        r#"(format: 1, nodes: {
        "new": (node: "future.thing", version: 9, params: (x: [1, (a: 2)], y: "z"), inputs: {"q": "a.terrain"}),
        "a": (node: "generate.constant", version: 1, params: (cells: 8)),
        "w": (node: "io.write_ascii", version: 1, inputs: {"terrain": "a.terrain"}),
        "v": (node: "adjust.clamp", version: 1, inputs: {"terrain": "new.terrain"}),
        })"#,
    );
    place.ok("check g.ron").gives(&["4 nodes, ok"]);
    place.ok("run g.ron");
    place.run("run g.ron v.terrain").code(2).tells(&["g.ron:2:", "no node type `future.thing`"]);
    place.ok("graph g.ron").gives(&["style=dashed"]);
    let canonical = place.ok("graph --ron g.ron").gives(&["future.thing", "version: 9", "[1, (a: 2)]"]).out;
    place.write("c.ron", &canonical);
    assert_eq!(place.ok("graph --ron c.ron").out, canonical);
    place.write("c.ron", format!("// Mine.\n{canonical}"));
    assert_eq!(place.ok("graph --ron c.ron").out, format!("// Mine.\n{canonical}"), "the header stays");
    assert_eq!(
        place.ok("graph --dot c.ron").out.lines().count(),
        place.ok("graph g.ron").out.lines().count()
    );
}

#[test]
fn check_looks_at_every_graph() {
    let place = Place::with(CHAIN);
    place.write("bad.ron", "(format: 1, nodes: {");
    place.write("worse.ron", "(");
    let ended = place.run("check bad.ron g.ron worse.ron").code(2);
    ended.gives(&["g.ron: 5 nodes, ok"]).tells(&["bad.ron:1:", "worse.ron:1:"]);
}

#[test]
fn every_node_type_is_listed_and_described() {
    let place = Place::with(CHAIN);
    let specs = place.ok("nodes --json").json();
    let listed = place.ok("nodes").out;
    assert_eq!(listed.lines().count(), specs.as_array().unwrap().len());
    for id in listed.lines().map(|line| line.split_whitespace().next().unwrap()) {
        assert!(specs.as_array().unwrap().iter().any(|spec| spec["id"] == id), "{id}");
    }
    place.ok("nodes adjust.clamp").gives(&["Inputs", "Outputs", "Parameters", "highest", "number in m"]);
    assert_eq!(place.ok("nodes adjust.clamp --json").json()["id"], "adjust.clamp");
}

#[test]
fn the_cache_is_counted_shrunk_and_emptied() {
    let place = Place::with(CHAIN);
    place.ok("run g.ron");
    let stat = place.ok("cache stat --json").json();
    assert!(
        stat["stat"]["values"].as_u64().unwrap() >= 2 && stat["bytes"].as_u64().unwrap() > 16_384,
        "{stat}"
    );
    place.ok("cache stat").gives(&["folder", "values", "records", "in all"]);
    place.ok("cache gc --max 20KiB").tells(&["removed"]);
    assert!(place.ok("cache stat --json").json()["bytes"].as_u64().unwrap() <= 20 << 10);
    place.ok("cache clear");
    assert_eq!(place.ok("cache stat --json").json()["bytes"], 0);
    assert!(computed(&place.manifest("g.ron --set flat.highest=9", 0)) >= 4);
}

#[test]
fn the_manual_is_written_and_compared() {
    let place = Place::with(CHAIN);
    place.run("manual --out pages --check").code(1).tells(&["stale", "orograph manual --out pages"]);
    place.ok("manual --out pages").gives(&["pages and 0 pictures in pages"]);
    place.ok("manual --out pages --check").gives(&["up to date"]);
    place.write("pages/io.md", "old");
    place.write("pages/io/read_dem.md", "old");
    place.run("manual --out pages --check").code(1).tells(&["(io/read_dem.md, io.md)"]);
    std::fs::create_dir(place.path("few")).unwrap();
    place.run("manual --out pages --graphs few").code(2).tells(&["no graph in few shows adjust.clamp, "]);
    place.run("manual --out g.ron").code(1).tells(&["error: writing g.ron"]);
}

#[test]
fn every_shell_gets_its_completions() {
    let place = Place::with(CHAIN);
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        place.ok(&format!("completions {shell}")).gives(&["orograph", "dry-run", "check"]);
    }
    place.ok("--help").gives(&["Usage: orograph", "completions"]);
    place.ok("--version").gives(&["orograph 0."]);
}

#[cfg(unix)]
#[test]
fn an_interrupt_ends_a_long_run_and_leaves_nothing_half_written() {
    let place = Place::with(&CHAIN.replace("cells: 64", "cells: 16384, octaves: 16"));
    let child = place.command("run g.ron --cache none --memory 4GiB").spawn().unwrap();
    std::thread::sleep(Duration::from_millis(500));
    let told = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(told.success(), "the run was over too soon");
    let ended = Ended::new("interrupted", child.wait_with_output().unwrap()).code(3);
    ended.tells(&["cancelled"]);
    assert!(place.files("out").is_empty());
}

#[test]
fn settings_hold_where_neither_options_nor_the_environment_say_otherwise() {
    let place = Place::with(CHAIN);
    fs::create_dir_all(place.path("config/orograph")).unwrap();
    place.write("config/orograph/settings.ron", "(cache: \"../../settled\", memory: \"1KiB\")");
    let run = |line: &str, cache: Option<&str>| {
        let mut command = place.command(line);
        command.env_remove("OROGRAPH_CACHE");
        cache.inspect(|cache| {
            command.env("OROGRAPH_CACHE", place.path(cache));
        });
        Ended::new(line, command.output().unwrap())
    };
    let there = |folder: &str| place.path(folder).join("v1").exists();
    run("run g.ron stats", None).code(1).tells(&["more than the 1024 allowed"]);
    assert!(there("settled") && !there("cache") && !there("said"));
    run("run g.ron stats --memory 1GiB", Some("cache")).code(0);
    run("run g.ron stats --memory 1GiB --cache said", Some("cache")).code(0);
    assert!(there("cache") && there("said"));
    run("cache stat", None).code(0).gives(&["settled"]);
    place.write("config/orograph/settings.ron", "(memory: \"much\")");
    run("run g.ron stats", None).code(2).tells(&[
        "settings.ron:1:",
        "`much` is no size",
        "hint: write settings",
    ]);
}

#[test]
fn a_part_of_an_id_or_a_word_lists_the_nodes_that_it_fits() {
    let place = Place::with(CHAIN);
    place.ok("nodes mcmd").gives(&["mcmd.mcmd", "mcmd.sketch"]);
    let ended = place.ok("nodes hillshade").gives(&["look.hillshade"]);
    assert!(!ended.out.contains("mcmd."), "{ended:?}");
    place.ok("nodes exemplar").gives(&["synthesis.synthesise"]);
}

#[test]
fn check_warns_of_a_slip_in_a_node_that_nothing_needs() {
    let place = Place::nodes(
        r#""a": (node: "generate.fbm", version: 1),
        "b": (node: "look.hilshade", version: 1, inputs: {"terrain": "a.terrain"}),"#,
    );
    let told = ["warning: g.ron:", "no node type `look.hilshade`", "nothing needs it", "`look.hillshade`?"];
    place.ok("check g.ron").gives(&["2 nodes, ok"]).tells(&told);
}

#[test]
fn where_a_missing_file_is_looked_for_is_told() {
    let reading = |file: &str| {
        Place::nodes(&format!(
            r#""a": (node: "io.read_dem", version: 1, params: (file: "{file}")),
            "w": (node: "io.write_geotiff", version: 1, inputs: {{"terrain": "a.terrain"}}),"#
        ))
    };
    reading("no.tif").run("run g.ron").code(1).tells(&["No such file", "counts from the graph's folder"]);
    let hint = "set OROGRAPH_NOWHERE to the folder that holds it";
    reading("${OROGRAPH_NOWHERE:-..}/no.tif").run("run g.ron").code(1).tells(&["No such file", hint]);
}

#[test]
fn data_are_no_graph() {
    let place = Place::with(CHAIN);
    std::fs::write(place.path("terrain.tif"), b"II*\0\x08\0\0\0\xff\xfe").unwrap();
    let ended =
        place.run("run terrain.tif").code(2).tells(&["terrain.tif", "no text, so no graph", "hint: "]);
    assert!(!ended.err.contains('\0'), "{ended:?}");
}
