//! What a graph or a data file from a stranger cannot do. `SECURITY.md` tells it to people.

// A helper that fails is a test that fails.
#![allow(clippy::unwrap_used)]

mod support;

use std::{fs, path::Path, time::Instant};

use support::{CHAIN, Place};

/// A graph of noise written as `file`.
fn writes(file: &str) -> Place {
    Place::nodes(&format!(
        r#""a": (node: "generate.fbm", version: 1, params: (cells: 8)),
        "w": (node: "io.write_geotiff", version: 1, params: (file: "{file}"), inputs: {{"terrain": "a.terrain"}}),"#
    ))
}

/// A graph that reads `file`.
fn reads(file: &str) -> Place {
    Place::nodes(&format!(r#""r": (node: "io.read_dem", version: 2, params: (file: "{file}")),"#))
}

/// The names in a folder.
fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn no_output_is_named_out_of_the_output_folder() {
    for file in [
        "/tmp/orograph-escaped.tif",
        "../escaped.tif",
        "a/../../escaped.tif",
        "./escaped.tif",
        "a//escaped.tif",
        "C:\\\\escaped.tif",
        "C:escaped.tif",
        "c:/escaped.tif",
        "..\\\\escaped.tif",
        "\\\\\\\\host\\\\share\\\\escaped.tif",
        "a\\u{0}.tif",
        "escaped.tif:stream.tif",
    ] {
        let place = writes(file);
        place.run("run g.ron").code(2).tells(&["`file` is", "hint: give a plain relative name"]);
        assert_eq!(names(&place.path("")), ["g.ron"], "{file}");
    }
    assert!(!Path::new("/tmp/orograph-escaped.tif").exists());
    // Nor by an override.
    let place = writes("fine.tif");
    place.run("run g.ron --set w.file=../escaped.tif").code(2).tells(&["could leave the output folder"]);
}

#[cfg(unix)]
#[test]
fn no_link_is_followed_out_of_the_output_folder() {
    use std::os::unix::fs::symlink;
    let place = writes("maps/deep/x.tif");
    fs::create_dir(place.path("out")).unwrap();
    fs::create_dir(place.path("theirs")).unwrap();
    symlink(place.path("theirs"), place.path("out/maps")).unwrap();
    place
        .run("run g.ron")
        .code(1)
        .tells(&["out/maps/deep/x.tif: a link leads out of the output folder", "hint: "]);
    assert!(names(&place.path("theirs")).is_empty(), "not even a folder is made there");
    // A link at the name of the output is replaced and not written through.
    let place = writes("x.tif");
    fs::create_dir(place.path("out")).unwrap();
    place.write("theirs.tif", "theirs");
    symlink(place.path("theirs.tif"), place.path("out/x.tif")).unwrap();
    place.ok("run g.ron");
    assert_eq!(fs::read(place.path("theirs.tif")).unwrap(), b"theirs");
    assert!(fs::symlink_metadata(place.path("out/x.tif")).unwrap().is_file());
    // Nor does a run that finds everything in the cache take a file behind a link for its own.
    let bytes = fs::read(place.path("out/x.tif")).unwrap();
    fs::remove_file(place.path("out/x.tif")).unwrap();
    place.write("theirs.tif", &bytes);
    symlink(place.path("theirs.tif"), place.path("out/x.tif")).unwrap();
    place.ok("run g.ron");
    assert!(fs::symlink_metadata(place.path("out/x.tif")).unwrap().is_file());
}

#[cfg(unix)]
#[test]
fn devices_and_pipes_are_no_files() {
    let begun = Instant::now();
    for file in ["/dev/zero", "/dev/stdin", "pipe.tif"] {
        let place = reads(file);
        assert!(std::process::Command::new("mkfifo").arg(place.path("pipe.tif")).status().unwrap().success());
        place.run("run g.ron r.terrain").code(1).tells(&["this is a device or a pipe, not a file", "hint: "]);
    }
    assert!(begun.elapsed().as_secs() < 30, "neither waits for what may never come");
}

#[test]
fn nesting_ends_in_an_error_and_not_off_the_stack() {
    let place = Place::with("");
    let deep = |open: &str, close: &str| open.repeat(200_000) + &close.repeat(200_000);
    let nodes = |params: &str| {
        format!(
            "(format: 1, nodes: {{\"a\": (node: \"generate.fbm\", version: 1, params: (seed: {params}))}})"
        )
    };
    for text in [
        deep("(", ")"),
        deep("[", "]"),
        deep("{1:", "}"),
        deep("a(", ")"),
        nodes(&deep("[", "]")),
        format!("{} (format: 1, nodes: {{}})", deep("/*", "*/")),
    ] {
        place.write("g.ron", &text);
        let ended = place.run("check g.ron");
        let head: String = text.chars().take(20).collect();
        assert!(ended.err.contains("levels") || text.starts_with("/*"), "{head}: {ended:?}");
        ended.code(if text.starts_with("/*") { 0 } else { 2 });
    }
    // Files of settings are RON, too.
    place.write("g.ron", CHAIN);
    for text in
        [deep("[", "]"), format!("{{\"a\": {}}}", deep("(", ")")), format!("(recent: {})", deep("[", "]"))]
    {
        place.write("v.ron", &text);
        place.run("run g.ron --vars v.ron").code(2).tells(&["v.ron:", "hint: "]);
        fs::create_dir_all(place.path("config/orograph")).unwrap();
        place.write("config/orograph/settings.ron", &text);
        place.run("run g.ron").code(2).tells(&["settings.ron:", "hint: "]);
        fs::remove_dir_all(place.path("config")).unwrap();
    }
}

#[test]
fn long_names_are_compared_with_nothing() {
    // Each was minutes of comparing, in a table of gigabytes.
    let long = "f".repeat(3_000_000);
    let begun = Instant::now();
    for text in [
        format!(r#"(format: 1, nodes: {{"a": (node: "generate.{long}", version: 1)}})"#),
        format!(r#"(format: 1, nodes: {{"a": (node: "generate.fbm", version: 1, params: ({long}: 1))}})"#),
        format!(r#"(format: 1, nodes: {{"a": (node: "generate.fbm", {long}: 1)}})"#),
        format!(r#"(format: 1, {long}: 1, nodes: {{}})"#),
        format!(r#"(format: 1, inputs: {{"a": (type: {long})}}, nodes: {{}})"#),
        format!(r#"(format: 1, outputs: {{"a": "{long}.terrain"}}, nodes: {{}})"#),
        format!(
            r#"(format: 1, nodes: {{"{long}": (node: "generate.fbm", inputs: {{"{long}": "b.{long}"}})}})"#
        ),
    ] {
        let place = Place::with(&text);
        place.run("run g.ron a.terrain").tells(&["error: "]);
    }
    assert!(begun.elapsed().as_secs() < 60, "{:?}", begun.elapsed());
}

#[test]
fn a_graph_of_graphs_ends() {
    // Each graph uses the next one ten times: a thousand million nodes, were it laid flat.
    let place = Place::with("");
    for level in 0..9 {
        let uses: String = (0..10).map(|n| format!("\"n{n}\": (graph: \"g{}.ron\"),", level + 1)).collect();
        let name = if level == 0 { "g.ron".into() } else { format!("g{level}.ron") };
        place.write(&name, format!("(format: 1, nodes: {{{uses}}})"));
    }
    place.write("g9.ron", "(format: 1, nodes: {\"a\": (node: \"generate.fbm\", version: 1)})");
    place.run("run g.ron").code(2).tells(&["more than 100000 nodes"]);
    place.write("g9.ron", "(format: 1, nodes: {\"a\": (graph: \"g.ron\")})");
    place.run("run g.ron").code(2).tells(&["hint: "]);
}

/// A zip whose one entry has these sizes in its headers and this content, stored.
fn zip_of(name: &str, content: &[u8], said: u32) -> Vec<u8> {
    let number = |value: u32| value.to_le_bytes();
    let short = |value: usize| u16::try_from(value).unwrap().to_le_bytes();
    let len = u32::try_from(content.len()).unwrap();
    // Version, flags, method 0, time, date, checksum, sizes, length of the name, of the extra field.
    let common = [
        &[20, 0, 0, 0, 0, 0, 0, 0, 0, 0][..],
        &number(0),
        &number(len),
        &number(said),
        &short(name.len()),
        &[0, 0],
    ]
    .concat();
    let local = [&b"PK\x03\x04"[..], &common, name.as_bytes(), content].concat();
    let central = [&b"PK\x01\x02"[..], &[20, 0], &common, &[0; 10], &number(0), name.as_bytes()].concat();
    let end = [
        &b"PK\x05\x06\0\0\0\0\x01\0\x01\0"[..],
        &number(u32::try_from(central.len()).unwrap()),
        &number(u32::try_from(local.len()).unwrap()),
        &[0, 0],
    ]
    .concat();
    [local, central, end].concat()
}

/// A TIFF of 32-bit floats with these tags, each a number of 32 bits.
fn tiff_of(tags: &[(u16, u32)]) -> Vec<u8> {
    let mut bytes = b"II*\0\x08\0\0\0".to_vec();
    bytes.extend(u16::try_from(tags.len()).unwrap().to_le_bytes());
    for (tag, value) in tags {
        bytes.extend([&tag.to_le_bytes()[..], &[4, 0, 1, 0, 0, 0], &value.to_le_bytes()].concat());
    }
    bytes.extend([0; 64]);
    bytes
}

#[test]
fn sizes_that_files_declare_are_not_believed() {
    let ascii = |head: &str| format!("{head}xllcorner 0\nyllcorner 0\ncellsize 1\n1 2 3\n").into_bytes();
    // A tile of 65520 × 65520 floats, in a file of an image of one cell.
    let tile =
        [(256, 1), (257, 1), (258, 32), (339, 3), (322, 65520), (323, 65520), (324, 8), (325, 16), (259, 5)];
    let image = [(256, 1 << 17), (257, 1 << 17), (258, 32), (339, 3), (278, 1), (273, 8), (279, 16)];
    // An image of which nothing is stored, which is allowed, and larger than the run may hold.
    let sparse =
        [(256, 40_000), (257, 40_000), (258, 32), (339, 3), (322, 40_000), (323, 40_000), (324, 0), (325, 0)];
    for (name, bytes) in [
        ("rows.asc", ascii("ncols 3\nnrows 4000000000\n")),
        ("both.asc", ascii("ncols 9000000000000000\nnrows 9000000000000000\n")),
        ("negative.asc", ascii("ncols -3\nnrows -1\n")),
        ("fraction.asc", ascii("ncols 1.5\nnrows 2\n")),
        ("nan.asc", ascii("ncols nan\nnrows 2\n")),
        ("tile.tif", tiff_of(&tile)),
        ("image.tif", tiff_of(&image)),
        ("sparse.tif", tiff_of(&sparse)),
        ("count.tif", b"II*\0\x08\0\0\0\xff\xff".to_vec()),
        ("large.zip", zip_of("x.hgt", b"few", u32::MAX - 1)),
        ("larger.zip", zip_of("x.hgt", &[0; 64], 3)),
        ("promise.zip", zip_of("x.hgt", &[0; 64], 1 << 16)),
    ] {
        let place = reads(name);
        place.write(name, bytes);
        let ended = place.run("run g.ron r.terrain --memory 64MiB --cache none").code(1);
        let err = ended.err.clone();
        ended.tells(&["node `r`", "hint: "]);
        assert!(!err.contains("the node panicked"), "{err}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_hostile_file_takes_no_more_memory_than_it_may() {
    use std::process::Command;
    // The system itself keeps the process to 4 GiB; a reader that believed these would be ended.
    let tile = [
        (256, 1),
        (257, 1),
        (258, 32),
        (339, 3),
        (322, 60_000),
        (323, 60_000),
        (324, 8),
        (325, 16),
        (259, 5),
    ];
    let mut png = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR".to_vec();
    png.extend([0x40, 0, 0, 0, 0x40, 0, 0, 0, 16, 0, 0, 0, 0, 0, 0, 0, 0]);
    for (node, name, bytes) in
        [("io.read_dem\", version: 2", "t.tif", tiff_of(&tile)), ("io.read_png\", version: 1", "p.png", png)]
    {
        let place = Place::nodes(&format!(r#""r": (node: "{node}, params: (file: "{name}")),"#));
        place.write(name, bytes);
        let script =
            "ulimit -v 4194304; exec \"$0\" run g.ron r.terrain --memory 256MiB --jobs 2 --cache none";
        let mut command = Command::new("sh");
        command.args(["-c", script, env!("CARGO_BIN_EXE_orograph")]);
        place.settle(&mut command);
        support::Ended::new(name, command.output().unwrap()).code(1).tells(&["node `r`", "hint: "]);
    }
}
