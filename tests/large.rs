//! Terrain larger than the memory: the same files, made band by band, and what tells so.

#![allow(clippy::unwrap_used)]

mod support;

use std::fs;

use support::Place;

/// A shipped graph, and a terrain for it of 700 × 700 cells.
fn place() -> Place {
    let shipped = concat!(env!("CARGO_MANIFEST_DIR"), "/graphs/large.ron");
    let place = Place::with(&fs::read_to_string(shipped).unwrap());
    place.write("ground.ron", include_str!("../benches/scale/ground.ron"));
    place
}

const MAKE: &str = "run ground.ron --set hills.cells=700 --set hills.width=7000 --set hills.height=7000";

fn outcomes(manifest: &serde_json::Value) -> Vec<&str> {
    manifest["nodes"].as_array().unwrap().iter().map(|node| node["outcome"].as_str().unwrap()).collect()
}

#[test]
fn a_terrain_larger_than_the_memory_gives_the_same_files() {
    let place = place();
    place.ok(&format!("{MAKE} --out whole"));
    place.ok(&format!("{MAKE} --out bands --memory 1MiB --cache none"));
    assert_eq!(place.files("whole"), place.files("bands"));
    let run = "g.ron --set file=whole/ground.tif";
    let whole = place.manifest(&format!("{run} --out whole"), 0);
    assert_eq!(outcomes(&whole), ["computed"; 7]);
    for jobs in [1, 3] {
        // A value of the chain takes 1.9 MiB: not even one would be admitted.
        let bands =
            place.manifest(&format!("{run} --out bands --memory 1MiB --jobs {jobs} --cache other-{jobs}"), 0);
        assert_eq!(outcomes(&bands), ["streamed"; 7]);
        assert_eq!(place.files("whole"), place.files("bands"));
        let again = place.manifest(&format!("{run} --out bands --memory 1MiB --cache other-{jobs}"), 0);
        assert!(outcomes(&again).iter().all(|outcome| *outcome == "disk"), "{again}");
    }
}

#[test]
fn a_trace_shows_each_node_once_and_none_over_another() {
    let place = place();
    place.ok(&format!("{MAKE} --out whole"));
    for (memory, outcome) in [("1GiB", "computed"), ("1MiB", "streamed")] {
        place.ok(&format!(
            "run g.ron --set file=whole/ground.tif --memory {memory} --cache none --out {outcome} --trace {outcome}.json"
        ));
        let trace = fs::read_to_string(place.path(&format!("{outcome}.json"))).unwrap();
        let trace: serde_json::Value = serde_json::from_str(&trace).unwrap();
        let events = trace["traceEvents"].as_array().unwrap();
        let mut names: Vec<_> = events.iter().map(|event| event["name"].as_str().unwrap()).collect();
        names.sort_unstable();
        assert_eq!(names, ["blend", "dem", "ground", "map", "shade", "smooth", "steep"]);
        let number = |event: &serde_json::Value, key: &str| event[key].as_f64().unwrap();
        for (i, a) in events.iter().enumerate() {
            assert_eq!((a["ph"].as_str(), a["args"]["outcome"].as_str()), (Some("X"), Some(outcome)));
            for b in events[..i].iter().filter(|b| b["tid"] == a["tid"]) {
                let ends = number(b, "ts") + number(b, "dur");
                assert!(ends <= number(a, "ts") + 1e-3, "{} and {} overlap", a["name"], b["name"]);
            }
        }
    }
    place.write("file", "in the way");
    place
        .run("run g.ron --set file=whole/ground.tif --trace file/trace.json")
        .code(1)
        .tells(&["writing the trace"]);
}
