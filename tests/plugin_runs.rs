//! Nodes of plugins at work: every type crosses, and what goes wrong is the node's error, here and apart.

#![cfg(unix)]
// A helper that fails is a test that fails.
#![allow(clippy::unwrap_used)]

mod support;

use std::{
    process::Command,
    sync::Arc,
    time::{Duration, Instant},
};

use orograph_core::{CellSize, Grid, Heightfield, Job, Slot, Value};
use orograph_engine::{
    Registry,
    plugin::{Plugins, Program},
};
use support::{Ended, Place, plugins::build};

/// A graph that sends noise through the hostile node, and beside it through a node that is not.
const HOSTILE: &str = r#"
    "hills": (node: "generate.fbm", version: 1, params: (cells: 32)),
    "bad": (node: "hostile.node", version: 1, params: (how: "well"), inputs: {"terrain": "hills.terrain"}),
    "good": (node: "measure.statistics", version: 1, inputs: {"terrain": "hills.terrain"}),
    "after": (node: "measure.statistics", version: 1, inputs: {"terrain": "bad.terrain"}),
"#;

fn hostile() -> Place {
    let place = Place::nodes(HOSTILE);
    build(&place, "hostile.c", "hostile", &[]);
    place
}

fn behave(place: &Place, how: &str, more: &str) -> Ended {
    let mut command = place.command("run g.ron good.metrics after.metrics bad.mask --plugins plugins");
    command.args(more.split_whitespace()).arg("--set").arg(format!("bad.how=\"{how}\""));
    Ended::new(how, command.output().unwrap())
}

#[test]
fn what_a_plugin_does_wrong_is_its_node_s_error() {
    let place = hostile();
    for isolate in ["", "--isolate"] {
        for how in ["well", "late", "other thread", "prints", "leak"] {
            if how != "other thread" {
                let ended = behave(&place, how, isolate).code(0);
                assert!(!ended.out.contains("the plugin prints") || isolate.is_empty(), "{ended:?}");
            }
        }
        for (how, said) in [
            ("fail", "the mountain is closed"),
            ("fail silently", "did not say why"),
            ("cancelled", "it was not"),
            ("status", "returned 77"),
            ("never", "gave no output `terrain`"),
            ("twice", "its output `terrain` twice"),
            ("null host calls", "null pointer"),
            ("null raster", "null pointer"),
            ("null cells", "null pointer"),
            ("null grid", "null pointer"),
            ("small struct", "4 bytes"),
            ("huge grid", "a grid of"),
            ("nan cell", "has no area"),
            ("nan mask", "outside 0 to 1"),
            ("infinite", "infinite"),
            ("wrong port", "gave output 9"),
            ("wrong type", "output `terrain` is a Mask, but the spec says Heightfield"),
            ("unknown type", "1234"),
            ("other thread", "output `mask`"),
        ] {
            let ended = behave(&place, how, isolate).code(1).tells(&["node `bad` (hostile.node)", said]);
            ended.gives(&["good.metrics:"]);
        }
        let mut panics = place.command("run g.ron bad.mask --plugins plugins --set bad.how=\"panic\"");
        let panics = panics.args(isolate.split_whitespace()).output().unwrap();
        assert_eq!(panics.status.code(), Some(1));
        assert!(String::from_utf8_lossy(&panics.stderr).contains("the node panicked"));
        behave(&place, "fail", isolate).tells(&["hint: come back in summer"]);
    }
}

#[test]
fn a_process_of_its_own_takes_the_worst() {
    let place = hostile();
    for (how, more, said) in [
        ("abort", "", "SIGABRT"),
        ("segfault", "", "SIGSEGV"),
        ("exit", "", "exit code 0"),
        ("hog", "--isolate-memory 256MiB", "the plugin's process ended"),
        ("polite loop", "--isolate-timeout 1", "it ran for more than 1 s and was stopped"),
        ("loop", "--isolate-silence 1", "it was not heard of for 1 s"),
    ] {
        let ended = behave(&place, how, &format!("--isolate {more}")).code(1);
        ended.tells(&["node `bad` (hostile.node)", said]).gives(&["good.metrics:"]);
    }
    // The library was never loaded into the program itself: it would have ended with it.
    behave(&place, "well", "--isolate").code(0);
}

/// Interrupts a run that will not end, and tells how long that took.
fn interrupted(place: &Place, how: &str) -> Duration {
    let mut command = place.command("run g.ron after.metrics --plugins plugins --isolate --cache none");
    command.arg("--set").arg(format!("bad.how=\"{how}\""));
    let mut child = command.spawn().unwrap();
    std::thread::sleep(Duration::from_millis(700));
    let asked = Instant::now();
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(killed.success());
    assert_eq!(child.wait().unwrap().code(), Some(3));
    asked.elapsed()
}

#[test]
fn a_run_apart_is_cancelled_whether_the_plugin_listens_or_not() {
    let place = hostile();
    for how in ["polite loop", "stubborn loop", "loop"] {
        let took = interrupted(&place, how);
        // The bar is 100 ms; a busy machine is given more, and a run that waits for the plugin never ends.
        assert!(took < Duration::from_secs(5), "{how}: {took:?}");
    }
}

#[test]
fn here_and_apart_give_the_same_bytes() {
    let place = hostile();
    let line = "run g.ron bad.terrain bad.mask --plugins plugins --cache none";
    place.ok(&format!("{line} --out here"));
    place.ok(&format!("{line} --out apart --isolate"));
    assert_eq!(place.files("here"), place.files("apart"));
    assert_eq!(place.files("here").len(), 2);
}

#[test]
fn every_type_crosses_to_the_bit_here_and_apart() {
    let place = Place::nodes("");
    let library = build(&place, "types.c", "types", &[]);
    let program =
        Program { executable: env!("CARGO_BIN_EXE_orograph").into(), arguments: vec!["plugin-host".into()] };
    for apart in [false, true] {
        let plugins = Plugins::new(None, program.clone()).unwrap();
        let mut registry = Registry::default();
        let found = plugins.register(std::slice::from_ref(&library), &mut registry, &|_| apart);
        assert!(found[0].outcome.is_ok(), "{found:?}");
        let empty = Grid::new(0, 3, CellSize::square(30.0)).unwrap();
        let empty = Value::Heightfield(Arc::new(Heightfield::new(empty, Vec::new()).unwrap()));
        for value in orograph_contract::samples().into_iter().chain([empty]) {
            let id = format!("echo.{}", value.value_type().to_string().to_lowercase());
            let node = registry.get(&id).unwrap().instantiate(&[]).unwrap();
            let one = Slot::One(value.clone());
            for (slots, count) in [
                ([one.clone(), Slot::Empty, Slot::Many(Vec::new())], 1),
                ([one.clone(), one.clone(), Slot::Many(vec![value.clone(); 3])], 5),
            ] {
                let outputs = node.run(&slots, &Job::detached()).unwrap();
                assert_eq!(outputs[0].digest(), value.digest(), "{id}, apart: {apart}");
                assert_eq!(outputs[1].digest(), Value::Integer(count).digest(), "{id}, apart: {apart}");
            }
        }
    }
}

#[test]
fn the_content_of_a_file_that_a_plugin_reads_counts() {
    let place = Place::nodes(r#""n": (node: "file.size", version: 1, params: (file: "data.bin")),"#);
    build(&place, "types.c", "types", &[]);
    for isolate in ["", "--isolate"] {
        let line = format!("run g.ron n.bytes --plugins plugins {isolate}");
        place.write("data.bin", [isolate.len() as u8; 7]);
        place.ok(&line).gives(&["  7"]).tells(&["1 computed"]);
        place.ok(&line).tells(&["0 computed"]);
        place.write("data.bin", [isolate.len() as u8; 9]);
        place.ok(&line).gives(&["  9"]).tells(&["1 computed"]);
        let missing = place.run(&format!("{line} --set n.file=nothing.bin")).code(1);
        missing.tells(&["reading", "nothing.bin"]);
    }
}
