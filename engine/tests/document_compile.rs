//! From document to graph: what compiles, and what each fault says of itself.

mod compiling;
mod document_nodes;

use std::path::Path;

use compiling::{CHAIN, DEM, build, graph, one, source, values};
use document_nodes::registry;
use orograph_core::ParamValue;
use orograph_engine::{
    CompileOptions, Document, compile,
    document::{Literal, Node},
    graph::Action,
};

#[test]
fn a_graph_compiles_with_typed_settings_and_wires() {
    let compiled = one(CHAIN).unwrap();
    let graph = &compiled.graph;
    let settings = values(graph, "smooth");
    assert_eq!(settings[0], ParamValue::Number(5.0));
    assert_eq!(settings[1], ParamValue::Integer(2));
    assert_eq!(settings[2], ParamValue::Text("straight_down".into()));
    assert_eq!(settings[5], ParamValue::Curve(vec![[0.0, 1.0], [0.5, 0.5]]));
    assert_eq!(settings[6], ParamValue::Lines(vec![vec![[0.0, 0.0, 1.0], [2.0, 2.0, 3.0]]]));
    assert_eq!(source(graph, "smooth", 0), ["dem.terrain"]);
    assert_eq!(source(graph, "sheet", 0), ["shade.texture", "shade.texture"]);
    assert_eq!(graph.output_name(compiled.outputs["picture"]), "shade.texture");
    assert_eq!(compiled.exposed["radius"].value, ParamValue::Number(5.0));
    let dem = graph.node(graph.find("dem").unwrap());
    assert_eq!(dem.base_dir("data/x.tif"), Path::new("graphs"));
}

/// Takes the `^` out of a text, and tells the line and column where it stood.
fn unmark(marked: &str) -> (String, (usize, usize)) {
    let (before, after) = marked.split_once('^').expect("a mark");
    let line = before.lines().count().max(1);
    let column = 1 + before.lines().last().map_or(0, |line| line.chars().count());
    let (line, column) = if before.ends_with('\n') { (line + 1, 1) } else { (line, column) };
    (format!("{before}{after}"), (line, column))
}

#[test]
fn faults_tell_place_and_mend() {
    let smooth = |params: &str| {
        graph(&[
            DEM,
            &format!(
                r#""s": (node: "filter.smooth", version: 3, params: ({params}), inputs: {{"terrain": "dem.terrain"}})"#
            ),
        ])
    };
    let cases: Vec<(String, &str, &str)> = vec![
        (smooth("radius: ^0.1"), "`radius` is 0.1 m, outside its range 0.5 to 1000", "from 0.5 to 1000"),
        (smooth("radius: ^1e400"), "`radius` is 1e400, which is more than a number can hold", ""),
        (smooth("radius: ^NaN"), "`radius` takes a number, not the bare word `NaN`", ""),
        (smooth("radius: ^-inf"), "more than a number can hold", ""),
        (smooth("radius: ^\"5\""), "`radius` takes a number, not a string", ""),
        (smooth("rounds: ^1000000000000000000000000000000"), "more than a number can hold", ""),
        (smooth("rounds: ^2.5"), "`rounds` takes a whole number, not a number", ""),
        (smooth("rounds: ^10"), "`rounds` is 10, outside its range 1 to 9", ""),
        (smooth("rims: ^1"), "`rims` takes `true` or `false`, not an integer", ""),
        (smooth("way: ^upp"), "`way` has no option `upp`", "did you mean `up`?"),
        (smooth("way: ^\"sideways\""), "`way` has no option `sideways`", "`up`, `straight_down`"),
        (smooth("note: ^up"), "`note` takes a string, not the bare word `up`", ""),
        (smooth("falloff: ^[(0, 1), (0.5, 2)]"), "`falloff` is 2", ""),
        (smooth("falloff: ^[(0, 1), (0, 1)]"), "needs points with x ascending", "sort"),
        (smooth("falloff: ^[1]"), "`falloff` takes a curve", ""),
        (smooth("barriers: ^[(0, 1)]"), "`barriers` takes lines", ""),
        (smooth("^radus: 5"), "`filter.smooth` has no parameter `radus`", "did you mean `radius`?"),
        (smooth("rounds: 9, radius: 900").replace("\"s\"", "^\"s\""), "so many rounds", "fewer rounds"),
        (
            graph(&[DEM, r#""s": (node: "filter.smooth", version: 3, ^input: {"terrain": "dem.terrain"})"#]),
            "no field `input`", "did you mean `inputs`?",
        ),
        ("(format: 1, ^nods: {}, nodes: {})".into(), "no field `nods`", "did you mean `nodes`?"),
        ("(format: 1, nodes: {}, ^materials: {})".into(), "no field `materials`", "its fields: `format`"),
        ("(format: 1, nodes: {}, inputs: {\"o\": (type: Mask, ^docs: 1)})".into(), "no field `docs`", "did you mean `doc`?"),
        (
            format!("(format: 1, expose: {{\"o\": (param: \"dem.file\", ^group: 1)}}, nodes: {{{DEM}}})"),
            "no field `group`",
            "`range`",
        ),
        ("(format: 1, nodes: {}, layout: (^zoom: 2))".into(), "no field `zoom`", "`bends`"),
        ("(format: 1, nodes: {}, layout: (frames: [(title: \"\", rect: (0, 0, 1, 1), ^colour: Red)]))".into(), "no field `colour`", "`rect`"),
        ("(format: 1, nodes: {}, layout: (comments: [(text: \"\", at: (0, 1), ^to: 1)]))".into(), "no field `to`", "`text`"),
        ("(format: 1, nodes: {}, layout: (bends: [(from: \"a.b\", to: \"c.d\", through: [], ^style: 1)]))".into(), "no field `style`", "`through`"),
        (
            graph(&[DEM, r#""s": (node: "filter.smooth", version: 3, inputs: {^"terain": "dem.terrain"})"#]),
            "`filter.smooth` has no input `terain`", "did you mean `terrain`?",
        ),
        (
            graph(&[DEM, r#""s": (node: "look.shade", version: 1, inputs: {"terrain": ^"dme.terrain"})"#]),
            "there is no node `dme`", "did you mean `dem`?",
        ),
        (
            graph(&[DEM, r#""s": (node: "look.shade", version: 1, inputs: {"terrain": ^"dem.terain"})"#]),
            "`io.read` has no output `terain`", "did you mean `terrain`?",
        ),
        (
            graph(&[DEM, r#""s": (node: "look.shade", version: 1, inputs: {"terrain": ["dem.terrain", ^"dem.terrain"]})"#]),
            "`s.terrain` takes one wire, but has 2", "keep one",
        ),
        (
            graph(&[DEM, r#""s": (node: "io.sheet", version: 1, inputs: {"pictures": ^"dem.terrain"})"#]),
            "`dem.terrain` gives a Heightfield, but `s.pictures` takes a Texture", "makes a Texture of a Heightfield, such as `look.shade`",
        ),
        (
            graph(&[r#"^"s": (node: "look.shade", version: 1)"#]),
            "`s.terrain` is not connected, but needs a Heightfield", "\"terrain\": \"node.output\"",
        ),
        (
            "(format: 1, nodes: {}, outputs: {\"o\": ^\"dem.terrain\"})".into(),
            "there is no node `dem`", "no nodes",
        ),
        (
            "(format: 1, nodes: {\"dem\": (node: \"io.read\")}, expose: {\"o\": (param: ^\"dem.flie\")})".into(),
            "`io.read` has no parameter `flie`", "did you mean `file`?",
        ),
        (
            "(format: 1, nodes: {\"dem\": (node: \"io.read\")}, expose: {\"o\": (param: ^\"den.file\")})".into(),
            "there is no node `den`", "did you mean `dem`?",
        ),
        (
            "(format: 1, nodes: {\"dem\": (node: \"io.read\")}, expose: {\"o\": (param: \"dem.file\", range: ^(0, 1))})".into(),
            "`dem.file` is no number", "remove",
        ),
        (
            CHAIN.replace("radius: 5", "radius: ^500"),
            "`radius` is 500 m, outside its range 1 to 50", "from 1 to 50",
        ),
        (
            graph(&[r#""g": (graph: ^"none.ron")"#]),
            "graphs/none.ron cannot be read", "relative to this file",
        ),
        (
            graph(&[r#""g": (graph: ^"/etc/x.ron")"#]),
            "`/etc/x.ron` is no relative path", "relative",
        ),
        (
            graph(&[r#""g": (graph: ^"main.ron")"#]),
            "a graph uses itself: graphs/main.ron → graphs/main.ron", "out",
        ),
    ];
    for (marked, message, help) in cases {
        let (text, place) = unmark(&marked);
        let Err(errors) = one(&text) else { panic!("compiles: {text}") };
        let error = &errors.errors()[0];
        assert!(error.message().contains(message), "{text}\n{errors}");
        assert_eq!((error.line().unwrap(), error.column().unwrap()), place, "{text}\n{error}");
        assert!(error.help_text().unwrap_or("").contains(help), "{text}\n{:?}", error.help_text());
        assert_eq!(errors.errors().len(), 1, "one fault, one message: {errors}");
    }
}

#[test]
fn every_fault_of_a_graph_is_told_at_once() {
    let text = graph(&[
        r#""a": (node: "look.shade", version: 1)"#,
        r#""b": (node: "filter.smooth", version: 3, params: (radius: 0, rounds: 0), inputs: {"terrain": "x.y"})"#,
        r#""c": (node: "look.shade", version: 1, inputs: {"terrain": "c.texture"})"#,
    ]);
    let errors = one(&text).err().unwrap();
    let lines: Vec<_> = errors.errors().iter().map(|error| error.line().unwrap()).collect();
    assert_eq!(lines, [2, 3, 3, 3, 4], "{errors}");
}

#[test]
fn cycles_are_refused_with_their_path() {
    let link = |name: &str, from: &str| {
        format!(r#""{name}": (node: "filter.smooth", version: 3, inputs: {{"terrain": "{from}.terrain"}})"#)
    };
    for (links, path) in [
        (vec![("a", "a")], "a cycle: a → a"),
        (vec![("a", "b"), ("b", "a")], "a cycle: a → b → a"),
        (vec![("x", "c"), ("a", "c"), ("b", "a"), ("c", "b")], "a cycle: a → b → c → a"),
    ] {
        let nodes: Vec<_> = links.iter().map(|(name, from)| link(name, from)).collect();
        let errors = one(&graph(&nodes.iter().map(String::as_str).collect::<Vec<_>>())).err().unwrap();
        let first = &errors.errors()[0];
        assert_eq!(first.message(), path);
        let line = 2 + links.iter().position(|(name, _)| *name == "a").unwrap();
        assert_eq!((first.line(), first.column()), (Some(line), Some(1)));
    }
    // Bypassing the nodes of a cycle leaves it a cycle, of wires alone.
    let bypassed =
        |name: &str, from: &str| link(name, from).replace("version: 3", "version: 3, bypass: true");
    let text = graph(&[&bypassed("a", "b"), &bypassed("b", "a"), &link("c", "a")]);
    assert!(one(&text).err().unwrap().to_string().contains("a cycle: a → b → a"));
    // A long one needs no deep stack.
    let n = 50_000;
    let nodes: Vec<_> = (0..n).map(|i| link(&format!("n{i}"), &format!("n{}", (i + 1) % n))).collect();
    let errors = one(&graph(&nodes.iter().map(String::as_str).collect::<Vec<_>>())).err().unwrap();
    assert!(errors.to_string().contains("→ (49985 more) →"), "{errors}");
}

#[test]
fn what_is_unknown_is_refused_only_when_needed() {
    let text = graph(&[
        DEM,
        r#""odd": (node: "filter.smoth", version: 1, inputs: {"any": ["dem.terrain"]}, colour: "red")"#,
        r#""new": (node: "look.shade", version: 9, params: (depth: 3), inputs: {"terrain": "dem.terrain"})"#,
        r#""shade": (node: "look.shade", version: 1, inputs: {"terrain": "odd.whatever"})"#,
    ]);
    let compiled = one(&text).unwrap();
    let told: Vec<_> = compiled.missing.values().map(|error| error.to_string()).collect();
    assert_eq!(
        told,
        [
            "graphs/main.ron:3:15: there is no node type `filter.smoth`",
            "graphs/main.ron:4:38: `look.shade` is known up to version 1, not 9",
        ]
    );
    let odd = compiled.graph.node(compiled.graph.find("odd").unwrap());
    match &odd.action {
        Action::Missing(missing) => {
            assert_eq!(missing.reason, "there is no node type `filter.smoth`; did you mean `filter.smooth`?");
        }
        Action::Run { .. } => panic!("runs"),
    }
    assert_eq!(source(&compiled.graph, "shade", 0), ["odd.0"]);
}

#[test]
fn older_versions_are_lifted() {
    let lifted = |version: u32, params: &str| {
        let node = format!(
            r#""s": (node: "filter.smooth", version: {version}, params: ({params}), inputs: {{"terrain": "dem.terrain"}})"#
        );
        one(&graph(&[DEM, &node])).map(|compiled| values(&compiled.graph, "s").to_vec())
    };
    for size in ["0.25", "2.5e-1"] {
        assert_eq!(
            lifted(1, &format!("size_km: {size}, rounds: 3, invert: false")).unwrap()[..2],
            [ParamValue::Number(250.0), ParamValue::Integer(3)]
        );
    }
    assert_eq!(lifted(1, "size_km: 1, way: straight_down").unwrap()[0], ParamValue::Number(1000.0));
    let errors = lifted(2, "invert: true").unwrap_err();
    assert_eq!(errors.to_string(), "graphs/main.ron:3:39: smoothing no longer inverts");
    assert_eq!(errors.errors()[0].help_text(), Some("subtract it from its input instead"));
    // What the lifted value is told of as itself, at the place of the node's settings.
    let errors = lifted(1, "size_km: 5").unwrap_err();
    assert!(errors.to_string().contains("`radius` is 5000 m"), "{errors}");
    assert_eq!(errors.errors()[0].line(), Some(3));
    assert!(lifted(3, "size_km: 5").unwrap_err().to_string().contains("no parameter `size_km`"));
    // An exposed parameter of the old name follows.
    let text = r#"(format: 1, expose: {"size": (param: "s.size_km", range: (10, 300))}, nodes: {
        "dem": (node: "io.read"),
        "s": (node: "filter.smooth", version: 1, params: (size_km: 0.2), inputs: {"terrain": "dem.terrain"}),
    })"#;
    let compiled = build(&[("main.ron", text)], &[("size", "0.3")]).unwrap();
    assert_eq!(compiled.exposed["size"].spec.name, "radius");
    assert_eq!(compiled.exposed["size"].value, ParamValue::Number(300.0));
    assert!(build(&[("main.ron", text)], &[("size", "0.4")]).is_err());
}

/// Each of these took a time quadratic in the number of nodes once; a slow one would not end here.
#[test]
fn large_graphs_and_many_faults_stay_cheap() {
    let many = |node: &dyn Fn(usize) -> String| {
        let nodes: Vec<_> = (0..50_000).map(node).collect();
        graph(&nodes.iter().map(String::as_str).collect::<Vec<_>>())
    };
    let links = many(&|i| format!(r#""n{i}": (node: "look.shade", inputs: {{"terrain": "m{i}.terrain"}})"#));
    assert!(one(&links).is_err());
    let unknown = many(&|i| format!(r#""n{i}": (node: "some.node{i}", inputs: {{"a": "n0.b"}})"#));
    // The first is linked to itself.
    assert!(one(&unknown).err().is_some_and(|errors| errors.to_string().contains("a cycle: n0 → n0")));
    let chain = many(&|i| match i {
        0 => r#""n0": (node: "io.read")"#.into(),
        _ => format!(r#""n{i}": (node: "filter.smooth", inputs: {{"terrain": "n{}.terrain"}})"#, i - 1),
    });
    assert_eq!(one(&chain).unwrap().graph.nodes().len(), 50_000);
    let bypassed = chain.replace("filter.smooth\"", "filter.smooth\", bypass: true");
    assert!(
        one(&bypassed).err().is_some_and(|errors| errors.to_string().contains("more than 1000 bypassed"))
    );
}

/// The nodes that the errors of `main.ron` and the files beside it are about.
fn nodes_of(files: &[(&str, &str)]) -> Vec<Option<String>> {
    let errors = match build(files, &[]) {
        Ok(compiled) => compiled.missing.into_values().collect(),
        Err(errors) => errors.errors().to_vec(),
    };
    errors.iter().map(|error| error.node().map(str::to_owned)).collect()
}

#[test]
fn errors_tell_the_node_of_the_outermost_graph() {
    let main = |nodes: &[&str]| graph(nodes);
    let node = |text: &str| nodes_of(&[("main.ron", &main(&[DEM, text]))]);
    let some = |name: &str| vec![Some(name.to_owned())];
    for text in [
        r#""s": (node: "filter.smooth", version: 3)"#,
        r#""s": (node: "filter.smoth", version: 3)"#,
        r#""s": (node: "filter.smooth", version: 9)"#,
        r#""s": (node: "filter.smooth", version: 3, colour: 1, inputs: {"terrain": "dem.terrain"})"#,
        r#""s": (node: "filter.smooth", version: 3, params: (radius: 0), inputs: {"terrain": "dem.terrain"})"#,
        r#""s": (node: "filter.smooth", version: 3, params: (size: 0), inputs: {"terrain": "dem.terrain"})"#,
        r#""s": (node: "filter.smooth", version: 3, inputs: {"terrain": "dme.terrain"})"#,
        r#""s": (node: "filter.smooth", version: 3, inputs: {"terrain": "dem.height"})"#,
        r#""s": (node: "filter.smooth", version: 3, inputs: {"terrain": "s.terrain"})"#,
        r#""s": (graph: "none.ron")"#,
    ] {
        assert_eq!(node(text), some("s"), "{text}");
    }
    let named = |rest: &str| nodes_of(&[("main.ron", &format!("(format: 1, nodes: {{{DEM}}}, {rest})"))]);
    assert_eq!(named(r#"outputs: {"x": "dem.height"}"#), some("dem"));
    assert_eq!(named(r#"expose: {"x": (param: "dem.size")}"#), some("dem"));
    assert_eq!(named(r#"outputs: {"x": "nobody.terrain"}"#), [None]);

    // Whatever is wrong inside a graph that is a node is that node's, however deep it is.
    let main = main(&[DEM, r#""mid": (graph: "middle.ron", inputs: {"terrain": "dem.terrain"})"#]);
    let middle = r#"(format: 1, inputs: {"terrain": (type: Heightfield)}, outputs: {"t": "in.t"},
        nodes: {"in": (graph: "inner.ron", inputs: {"terrain": "graph.terrain"})})"#;
    for inner in [
        r#""s": (node: "filter.smooth", version: 3, params: (radius: 0), inputs: {"terrain": "graph.terrain"})"#,
        r#""s": (node: "filter.smooth", version: 3)"#,
        r#""s": (node: "filter.smoth", version: 3, inputs: {"terrain": "graph.terrain"})"#,
        r#""s": (node: "filter.smooth", version: 3, inputs: {"terrain": "t.terrain"}),
           "t": (node: "filter.smooth", version: 3, inputs: {"terrain": "s.terrain"})"#,
        r#""s": (node: 1)"#,
        r#""s": ("#,
    ] {
        let inner = format!(
            r#"(format: 1, inputs: {{"terrain": (type: Heightfield)}}, outputs: {{"t": "s.terrain"}}, nodes: {{{inner}}})"#
        );
        let files = [("main.ron", main.as_str()), ("middle.ron", middle), ("inner.ron", &inner)];
        assert_eq!(nodes_of(&files), some("mid"), "{inner}");
    }
}

#[test]
fn a_graph_without_a_file_has_errors_of_its_nodes_too() {
    let mut document = Document::new();
    for name in ["first", "second"] {
        let mut node = Node::of_type("filter.smooth", 3);
        node.params.insert("size".into(), Literal::Integer(1));
        document.nodes.insert(name.into(), node);
    }
    let options = CompileOptions { base_dir: "".into(), overrides: Vec::new(), loader: &|_| unreachable!() };
    let errors = compile(&document, &registry(), &options).err().expect("they have no `size`");
    let nodes: Vec<_> = errors.errors().iter().filter_map(|error| error.node()).collect();
    for name in ["first", "second"] {
        assert!(nodes.contains(&name), "{errors}");
    }
    assert!(errors.errors().iter().all(|error| error.span().is_none() && error.path().is_none()));
}
