//! Graphs in graphs: laid flat, set from outside, bypassed, and kept from growing without end.

mod compiling;
mod document_nodes;

use std::path::Path;

use compiling::{CHAIN, INNER, MIDDLE, NESTED, OUTER, build, graph, one, source, values};
use orograph_core::ParamValue;
use orograph_engine::graph::OutputRef;

#[test]
fn subgraphs_are_laid_flat() {
    let compiled = build(&NESTED, &[]).unwrap();
    let graph = &compiled.graph;
    let mut names: Vec<_> = graph.names().collect();
    names.sort_unstable();
    assert_eq!(names, ["dem", "in/dem", "in/s", "mid/in/dem", "mid/in/s", "shade"]);
    assert_eq!(source(graph, "mid/in/s", 0), ["dem.terrain"]);
    assert_eq!(source(graph, "in/s", 0), ["mid/in/s.terrain"]);
    assert_eq!(source(graph, "shade", 0), ["in/s.terrain"]);
    let name = |output: OutputRef| graph.output_name(output);
    assert_eq!(name(compiled.outputs["all"]), "mid/in/s.terrain");
    assert_eq!(name(compiled.outputs["raw"]), "dem.terrain");
    for (asked, found) in [
        ("all", "mid/in/s.terrain"),
        ("mid.terrain", "mid/in/s.terrain"),
        ("mid/in.raw", "dem.terrain"),
        ("mid/in/s", "mid/in/s.terrain"),
        ("shade.texture", "shade.texture"),
        ("shade", "shade.texture"),
    ] {
        assert_eq!(name(compiled.output(asked).unwrap()), found, "{asked}");
    }
    let error = compiled.output("shde").unwrap_err();
    assert_eq!(error.message(), "the graph has no output `shde`");
    assert!(compiled.output("mid").unwrap_err().help_text().unwrap().contains("mid.terrain, mid.raw"));
    // The outermost setting counts, and each file's paths start at that file.
    assert_eq!(values(graph, "mid/in/s")[0], ParamValue::Number(4.0));
    assert_eq!(values(graph, "in/s")[0], ParamValue::Number(2.0));
    let base = |name: &str, text: &str| graph.node(graph.find(name).unwrap()).base_dir(text).to_path_buf();
    assert_eq!(base("mid/in/dem", "inner.tif"), Path::new("graphs/lib/deep"));
    assert_eq!(base("in/dem", "outer.tif"), Path::new("graphs"));
}

#[test]
fn overrides_reach_every_node() {
    let radius = |overrides: &[(&str, &str)]| {
        build(&NESTED, overrides).map(|compiled| values(&compiled.graph, "mid/in/s")[0].clone())
    };
    for name in ["reach", "mid.reach", "mid/in.reach", "mid/in/s.radius"] {
        assert_eq!(radius(&[(name, "7")]).unwrap(), ParamValue::Number(7.0), "{name}");
    }
    assert_eq!(radius(&[("reach", "7"), ("mid/in/s.radius", "8")]).unwrap(), ParamValue::Number(8.0));
    let compiled =
        build(&NESTED, &[("mid/in/s.way", "straight_down"), ("dem.file", "a b.tif"), ("in/s.note", "\"q\"")]);
    let graph = compiled.unwrap().graph;
    assert_eq!(values(&graph, "mid/in/s")[2], ParamValue::Text("straight_down".into()));
    assert_eq!(values(&graph, "dem")[0], ParamValue::Text("a b.tif".into()));
    assert_eq!(values(&graph, "in/s")[4], ParamValue::Text("q".into()));
    for (name, value, message, help) in [
        ("raech", "7", "the graph exposes no parameter `raech`", "did you mean `reach`?"),
        ("mdi.reach", "7", "there is no node `mdi`", "did you mean `mid`?"),
        ("mid.raech", "7", "the graph `mid` exposes no parameter `raech`", "did you mean `reach`?"),
        ("mid/on/s.radius", "7", "there is no subgraph `on`", "did you mean `in`?"),
        (
            "mid/in/s.radus",
            "7",
            "in `mid/in/s.radus=7`: `filter.smooth` has no parameter",
            "did you mean `radius`?",
        ),
        (
            "mid/in/s.radius",
            "x",
            "in `mid/in/s.radius=x`: `radius` takes a number, not the bare word `x`",
            "",
        ),
        ("mid/in/s.radius", "(", "expected a value", "takes a number"),
        ("mid/in/s.radius", "1e999", "more than a number can hold", ""),
        ("mid.reach", "80", "`reach` is 80 m, outside its range 1 to 60", "from 1 to 60"),
        ("mid/in/s.radius", "80", "`reach` is 80 m, outside its range 1 to 60", ""),
    ] {
        let errors = radius(&[(name, value)]).unwrap_err();
        let error = &errors.errors()[0];
        assert!(error.message().contains(message), "{name}: {errors}");
        assert!(error.help_text().unwrap_or("").contains(help), "{name}: {:?}", error.help_text());
    }
}

#[test]
fn faults_of_subgraphs_tell_their_file() {
    let with = |main: &str, middle: &str, inner: &str| {
        let files = [("main.ron", main), ("lib/middle.ron", middle), ("lib/deep/inner.ron", inner)];
        build(&files, &[]).err().unwrap().errors()[0].to_string()
    };
    for (error, expected) in [
        (with(OUTER, MIDDLE, "("), "graphs/lib/deep/inner.ron:1:2: expected a value"),
        (
            with(OUTER, MIDDLE, &INNER.replace("radius: 2", "radius: 0")),
            "graphs/lib/deep/inner.ron:8:67: `radius` is 0 m",
        ),
        (
            with(&OUTER.replace("mid.raw", "mid.row"), MIDDLE, INNER),
            "graphs/main.ron:4:44: the graph `mid` has no output `row`",
        ),
        (
            with(&OUTER.replace("reach: 4", "rech: 4"), MIDDLE, INNER),
            "graphs/main.ron:7:51: the graph `mid` exposes no parameter `rech`",
        ),
        (
            with(&OUTER.replace("inputs: {\"terrain\": \"mid", "inputs: {\"terain\": \"mid"), MIDDLE, INNER),
            "graphs/main.ron:8:83: the graph `in` has no input `terain`",
        ),
        (
            with(&OUTER.replace("\"mid.terrain\"})", "\"shade.texture\"})"), MIDDLE, INNER),
            "graphs/main.ron:8:94: `shade.texture` gives a Texture, but `in.terrain` takes a Heightfield",
        ),
        (
            with(OUTER, &MIDDLE.replace("deep/inner.ron", "../lib/middle.ron"), INNER),
            "graphs/lib/middle.ron:6:27: a graph uses itself: graphs/lib/middle.ron → graphs/lib/middle.ron",
        ),
        (
            with(
                OUTER,
                MIDDLE,
                &INNER.replace(
                    "nodes: {",
                    "nodes: {\"z\": (node: \"look.shade\", inputs: {\"terrain\": \"graph.spare\"}),",
                ),
            ),
            "graphs/lib/deep/inner.ron:6:13: `mid/in/z.terrain` is not connected",
        ),
    ] {
        assert!(error.starts_with(expected), "{error}\nexpected {expected}");
    }
}

#[test]
fn a_graph_with_inputs_compiles_alone_and_says_what_it_lacks() {
    let compiled = one(INNER).unwrap();
    let missing: Vec<_> = compiled.missing.values().map(ToString::to_string).collect();
    assert_eq!(
        missing,
        ["graphs/main.ron:8:91: the input `terrain` is given by the graph that uses this one"]
    );
    assert_eq!(source(&compiled.graph, "s", 0), ["graph.terrain.0"]);
}

#[test]
fn bypassed_nodes_hand_on_their_first_input_of_the_type() {
    let bypass = CHAIN.replace("node: \"filter.smooth\"", "bypass: true, node: \"filter.smooth\"");
    let compiled = one(&bypass).unwrap();
    assert_eq!(source(&compiled.graph, "shade", 0), ["dem.terrain"]);
    assert_eq!(compiled.graph.find("smooth"), None);
    assert_eq!(compiled.graph.output_name(compiled.output("smooth.terrain").unwrap()), "dem.terrain");
    // Nothing to hand on: an error for what needs it alone.
    let bypass = CHAIN.replace("node: \"look.shade\"", "bypass: true, node: \"look.shade\"");
    let compiled = one(&bypass).unwrap();
    let told = compiled.missing.values().next().unwrap().to_string();
    assert!(
        told.contains(
            "the bypassed `shade` has nothing to hand on as `shade.texture`: no input takes a Texture"
        ),
        "{told}"
    );
    // A whole subgraph.
    let outer = OUTER.replace("graph: \"lib/middle.ron\"", "bypass: true, graph: \"lib/middle.ron\"");
    let compiled = build(&[("main.ron", &outer), NESTED[1], NESTED[2]], &[]).unwrap();
    assert_eq!(source(&compiled.graph, "in/s", 0), ["dem.terrain"]);
    assert_eq!(compiled.graph.find("mid/in/s"), None);
}

#[test]
fn subgraphs_do_not_multiply_without_end() {
    let uses = |file: &str| {
        let nodes: String = (0..20).map(|i| format!(r#""n{i}": (graph: "{file}"),"#)).collect();
        format!("(format: 1, nodes: {{{nodes}}})")
    };
    let texts: Vec<_> = (1..8).map(|depth| uses(&format!("d{depth}.ron"))).collect();
    let names: Vec<_> = (0..8).map(|depth| format!("d{depth}.ron")).collect();
    let mut files: Vec<_> = names.iter().map(String::as_str).zip(texts.iter().map(String::as_str)).collect();
    files[0].0 = "main.ron";
    let errors = build(&files, &[]).err().unwrap();
    assert!(errors.to_string().contains("more than 100000 nodes"), "{errors}");
    // Depth.
    let names: Vec<_> = (0..40).map(|depth| format!("d{depth}.ron")).collect();
    let texts: Vec<_> = (1..41).map(|depth| graph(&[&format!(r#""n": (graph: "d{depth}.ron")"#)])).collect();
    let mut files: Vec<_> = names.iter().map(String::as_str).zip(texts.iter().map(String::as_str)).collect();
    files[0].0 = "main.ron";
    let errors = build(&files, &[]).err().unwrap();
    assert!(errors.to_string().contains("deeper than 32 levels"), "{errors}");
}

proptest::proptest! {
    #[test]
    fn no_document_panics(
        mutations in proptest::collection::vec((0..2000_usize, 0..2000_usize, 1..12_usize), 1..6),
    ) {
        // Pieces of graphs in the wrong places: much of that still reads.
        let mut texts = [CHAIN.to_owned(), OUTER.to_owned(), MIDDLE.to_owned(), INNER.to_owned()];
        for (from, to, len) in mutations {
            let piece: String = texts[from % 4].chars().skip(from / 4).take(len).collect();
            let target = &mut texts[to % 4];
            let at = (to / 4).min(target.len());
            let end = (at + if from % 2 == 0 { len } else { 0 }).min(target.len());
            if target.is_char_boundary(at) && target.is_char_boundary(end) {
                target.replace_range(at..end, &piece);
            }
        }
        let [chain, outer, middle, inner] = &texts;
        for main in [chain, outer, inner] {
            let files = [("main.ron", main.as_str()), ("lib/middle.ron", middle), ("lib/deep/inner.ron", inner)];
            let _ = build(&files, &[("reach", "5"), ("smooth.radius", "7")]);
        }
    }
}
