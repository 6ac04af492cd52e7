//! Graph files: what reads, what is refused where, and that writing loses nothing.

mod document_nodes;

use document_nodes::registry;
use indexmap::IndexMap;
use orograph_core::ValueType;
use orograph_engine::document::{
    Bend, Body, Comment, Document, Exposed, Frame, GraphInput, Link, Literal, MAX_BYTES, Node,
};
use proptest::prelude::*;

const FULL: &str = r#"// A graph that uses every field.
(
    format: 1,
    doc: "Every \"field\".\nTwo lines; ä → 山.",
    expose: {
        "radius": (param: "smooth.radius", doc: "How far.", range: (1, 50.5)),
        "file": (param: "dem.file"),
    },
    inputs: {"terrain": (type: Heightfield, doc: "Rough."), "mask": (type: "Mask")},
    outputs: {"terrain": "smooth.terrain"},
    nodes: {
        "smooth": (node: "filter.smooth", version: 3, params: (radius: 1e-7, rounds: 0x2, way: straight_down,
            falloff: [(0, 1), (1.0, 0.25)], rims: true), inputs: {"terrain": "graph.terrain",}),
        "dem": (node: "io.read", params: {"file": r"a\b.tif"}, comment: "Why.", bypass: true),
        "sheet": (node: "io.sheet", version: 1, inputs: {"pictures": ["a.x", "b.y"]}),
        "lib": (graph: "lib/repair.ron", params: (keep: 0.1), inputs: {"terrain": "dem.terrain"}),
        /* later */
        "odd": (node: "later.thing",   version: 7, params: (deep: {1: 'c', "k": Some((b"x", 1e400))}),
            colour : "red" /* kept */, inputs: {}),
    },
    layout: (
        nodes: {"dem": (0, -1.5)},
        frames: [(title: "Input", rect: (0, 0, 300, 200))],
        comments: [(text: "Two\nlines", at: (5, -7))],
        bends: [(from: "dem.terrain", to: "lib.terrain", through: [(1, 2), (3.5, 4)])],
    ),
)
"#;

#[test]
fn every_field_is_read() {
    let document = Document::parse(FULL, "x.ron").unwrap();
    assert_eq!(document.doc, "Every \"field\".\nTwo lines; ä → 山.");
    assert_eq!(document.expose["radius"].range, Some((1.0, 50.5)));
    assert_eq!(document.expose["file"].param, Link::new("dem", "file"));
    assert_eq!(document.nodes.keys().collect::<Vec<_>>(), ["smooth", "dem", "sheet", "lib", "odd"]);
    let smooth = &document.nodes["smooth"];
    assert_eq!(smooth.body, Body::Type { id: "filter.smooth".into(), version: Some(3) });
    assert_eq!(smooth.params["radius"], Literal::Number(1e-7));
    assert_eq!(smooth.params["rounds"], Literal::Integer(2));
    assert_eq!(smooth.params["way"], Literal::Word("straight_down".into()));
    assert_eq!(document.nodes["dem"].params["file"], Literal::Text("a\\b.tif".into()));
    assert!(document.nodes["dem"].bypass);
    assert_eq!(document.nodes["sheet"].inputs["pictures"], [Link::new("a", "x"), Link::new("b", "y")]);
    assert_eq!(document.nodes["lib"].body, Body::Graph { path: "lib/repair.ron".into() });
    assert_eq!(document.nodes["odd"].extra["colour"], Literal::Text("red".into()));
    let frame = Frame { title: "Input".into(), rect: (0.0, 0.0, 300.0, 200.0), ..Frame::default() };
    assert_eq!(document.layout.frames, [frame]);
    assert_eq!(
        document.layout.comments,
        [Comment { text: "Two\nlines".into(), at: (5.0, -7.0), ..Comment::default() }]
    );
    let [bend] = &document.layout.bends[..] else { panic!("{:?}", document.layout.bends) };
    assert_eq!((bend.from.to_string(), bend.to.to_string()), ("dem.terrain".into(), "lib.terrain".into()));
    assert_eq!(bend.through, [(1.0, 2.0), (3.5, 4.0)]);
}

#[test]
fn writing_is_canonical_and_loses_nothing() {
    let document = Document::parse(FULL, "x.ron").unwrap();
    let text = document.to_ron(&registry());
    let again = Document::parse(&text, "x.ron").unwrap();
    assert_eq!(again, document);
    assert_eq!(again.to_ron(&registry()), text);
    let names: Vec<_> = again.nodes.keys().map(String::as_str).collect();
    assert_eq!(names, ["dem", "lib", "odd", "sheet", "smooth"], "sorted");
    assert!(
        text.contains("\n            params: (\n                falloff: [(0, 1), (1.0, 0.25)],\n"),
        "{text}"
    );
    assert!(text.contains("\n            params: (keep: 0.1),\n"), "{text}");
}

#[test]
fn comments_before_the_graph_stay_and_others_are_told() {
    let document = Document::parse(FULL, "x.ron").unwrap();
    assert_eq!(document.header, "// A graph that uses every field.");
    let text = document.to_ron(&registry());
    assert!(text.starts_with("// A graph that uses every field.\n(\n"), "{text}");
    let parse = |text: &str| Document::parse(text, "x.ron").unwrap();
    for (before, kept) in [
        ("", ""),
        ("\u{feff} \n\n", ""),
        ("// a \r\n\r\n  // b\r\n\n", "// a\n\n  // b"),
        ("/* a /* b */ \n c */ // d\n", "/* a /* b */\n c */ // d"),
    ] {
        let document = parse(&format!("{before}(format: 1, nodes: {{}})\n"));
        assert_eq!(document.header, kept, "{before:?}");
        assert!(!document.has_inner_comments());
        let text = document.to_ron(&registry());
        assert_eq!(parse(&text), document);
        assert_eq!(parse(&text).to_ron(&registry()), text);
    }
    for text in [
        FULL,
        "(format: 1, nodes: {} /* inside */)",
        "(format: 1, // inside\n nodes: {})",
        "(format: 1, nodes: {})\n// after",
        "(format: 1, nodes: {\"a\": (node: \"io.read\", params: (file: /* x */ \"a\"))})",
    ] {
        assert!(parse(text).has_inner_comments(), "{text}");
    }
    assert!(!parse("(format: 1, doc: \"// no /* comment */\", nodes: {})").has_inner_comments());
    assert!(!Document::new().has_inner_comments());
    let mut edited = parse("// a\n(format: 1, nodes: {})");
    edited.header = String::new();
    assert_ne!(parse("// a\n(format: 1, nodes: {})"), edited, "a header is part of what a graph says");
    assert!(edited.to_ron(&registry()).starts_with('('));
}

#[test]
fn some_nodes_with_their_places_are_a_graph_by_themselves() {
    let whole = Document::parse(FULL, "x.ron").unwrap();
    let mut cut = Document::new();
    for name in ["smooth", "odd", "dem"] {
        cut.nodes.insert(name.into(), whole.nodes[name].clone());
    }
    cut.layout.nodes.insert("dem".into(), (0.0, -1.5));
    let pasted = Document::parse(&cut.to_ron(&registry()), "clipboard").unwrap();
    assert_eq!(pasted, cut);
    assert!(!pasted.has_inner_comments());
}

#[test]
fn unknown_nodes_are_written_back_verbatim() {
    let odd = &FULL[FULL.find("(node: \"later.thing\"").unwrap()..];
    let odd = &odd[..odd.find("}),\n    },").unwrap() + 2];
    let mut document = Document::parse(FULL, "x.ron").unwrap();
    let text = document.to_ron(&registry());
    assert!(text.contains(&format!("\"odd\": {odd},")), "{text}");
    // A newer version of a known type is as unknown.
    let newer = FULL.replace("\"io.sheet\", version: 1", "\"io.sheet\",  version: 2");
    let text = Document::parse(&newer, "x.ron").unwrap().to_ron(&registry());
    assert!(text.contains("(node: \"io.sheet\",  version: 2, inputs"), "{text}");
    // Once edited, it says what it was edited to, and still loses nothing.
    document.nodes["odd"].comment = "edited".into();
    let text = document.to_ron(&registry());
    let again = Document::parse(&text, "x.ron").unwrap();
    assert_eq!(again, document);
    assert!(text.contains("1e400") && text.contains("comment: \"edited\""), "{text}");
}

#[test]
fn byte_order_marks_and_windows_line_ends_are_read() {
    let expected = Document::parse(FULL, "x.ron").unwrap();
    let windows = format!("\u{feff}{}", FULL.replace('\n', "\r\n"));
    let document = Document::from_bytes(windows.as_bytes(), "x.ron").unwrap();
    assert_eq!(document, expected);
    // Places count as editors count them.
    let broken = windows.replace("bypass: true", "bypass: 1");
    let errors = Document::from_bytes(broken.as_bytes(), "x.ron").unwrap_err();
    assert_eq!((errors.errors()[0].line(), errors.errors()[0].column()), (Some(14), Some(89)), "{errors}");
}

/// Text, then line and column, then what message and help say.
#[test]
fn faults_tell_place_and_mend() {
    let nodes = |nodes: &str| format!("(\n    format: 1,\n    nodes: {{\n        {nodes}\n    }},\n)");
    let cases: Vec<(String, (usize, usize), &str, &str)> = vec![
        ("".into(), (1, 1), "expected a graph", "the file is empty"),
        ("  // only a comment".into(), (1, 20), "expected a graph", "the file is empty"),
        ("(format: 1, nodes: {}) x".into(), (1, 24), "expected the end of the file", ""),
        ("(format: 1, nodes: {}".into(), (1, 22), "expected `,` or `)`, found the end of the file", ""),
        ("(format: 1 nodes: {})".into(), (1, 12), "expected `,` or `)`, found `n`", ""),
        ("(format 1, nodes: {})".into(), (1, 9), "expected `,` or `)`, found `1`", ""),
        ("(format: 1, nodes: {\"a\" (node: \"b\")})".into(), (1, 25), "expected `:` after the key", ""),
        ("(format: 1, doc: \"no end, nodes: {})".into(), (1, 18), "this string has no end", "close it"),
        ("(format: 1, doc: \"\\q\", nodes: {})".into(), (1, 18), "not valid", "backslash"),
        ("(format: 1, /* doc, nodes: {})".into(), (1, 13), "this comment has no end", "*/"),
        (
            "#![enable(implicit_some)] (format: 1, nodes: {})".into(),
            (1, 1),
            "expected `(`",
            "no RON extensions",
        ),
        ("[1, 2]".into(), (1, 1), "expected a graph in parentheses", ""),
        ("(nodes: {})".into(), (1, 1), "does not say its `format`", "write `format: 1,`"),
        ("(format: 2, nodes: {})".into(), (1, 10), "graph format 2 is unknown", "newer"),
        ("(format: \"1\", nodes: {})".into(), (1, 10), "expected the format version, 1, found a string", ""),
        ("(format: 1)".into(), (1, 1), "the graph has no `nodes`", "nodes: {}"),
        ("(format: 1, nods: {}, nodes: 3)".into(), (1, 13), "no field `nods`", "did you mean `nodes`?"),
        ("(format: 1, format: 1, nodes: {})".into(), (1, 13), "`format` stands here twice", "remove one"),
        ("(format: 1, doc: 5, nodes: {})".into(), (1, 18), "expected a string, found a number", ""),
        ("(format: 1, nodes: [])".into(), (1, 20), "expected a map of nodes, found a list", ""),
        (
            "(format: 1, nodes: {}, outputs: {\"o\": \"a\"})".into(),
            (1, 39),
            "expected \"node.output\", found \"a\"",
            "dot",
        ),
        ("(format: 1, nodes: {}, outputs: {\"o.p\": \"a.b\"})".into(), (1, 34), "`o.p` is no name", "letter"),
        (
            "(format: 1, nodes: {}, inputs: {\"o\": (type: Heightfild)})".into(),
            (1, 45),
            "no type `Heightfild`",
            "did you mean `Heightfield`?",
        ),
        (
            "(format: 1, nodes: {}, inputs: {\"o\": (type: Sound)})".into(),
            (1, 45),
            "no type `Sound`",
            "Heightfield, Mask",
        ),
        ("(format: 1, nodes: {}, inputs: {\"o\": ()})".into(), (1, 38), "`type` is missing", "Heightfield"),
        ("(format: 1, nodes: {}, expose: {\"o\": (doc: \"\")})".into(), (1, 38), "`param` is missing", ""),
        (
            "(format: 1, nodes: {}, expose: {\"o\": (param: \"a.b\", range: (2, 1))})".into(),
            (1, 60),
            "below its start",
            "",
        ),
        (
            "(format: 1, nodes: {}, expose: {\"o\": (param: \"a.b\", range: 2)})".into(),
            (1, 60),
            "expected 2 numbers",
            "",
        ),
        ("(format: 1, nodes: {}, layout: (nodes: {\"a\": (0, 1e400)}))".into(), (1, 50), "too large", ""),
        (
            "(format: 1, nodes: {}, layout: (frames: [(title: \"x\")]))".into(),
            (1, 42),
            "`rect` is missing",
            "",
        ),
        (nodes("\"a\": 5"), (4, 14), "expected a node", ""),
        (nodes("\"a\": ()"), (4, 14), "does not say its type", "node: \"family.algorithm\""),
        (nodes("\"a\": (nod: \"b.c\")"), (4, 15), "no field `nod`", "did you mean `node`?"),
        (
            nodes("\"a\": (node: \"b.c\", graph: \"d\")"),
            (4, 28),
            "either of a `node` type or a `graph`",
            "one",
        ),
        (nodes("\"a\": (graph: \"d\", version: 1)"), (4, 27), "no `version`", "remove"),
        (nodes("\"a\": (node: \"b.c\", version: 0)"), (4, 37), "a whole number from 1", ""),
        (nodes("\"a\": (node: \"b.c\", version: 1.5)"), (4, 37), "a whole number from 1", ""),
        (nodes("\"a\": (node: \"b.c\", bypass: 1)"), (4, 36), "expected `true` or `false`", ""),
        (nodes("\"a\": (node: \"b.c\", params: [1])"), (4, 36), "expected parameters", ""),
        (nodes("\"a\": (node: \"b.c\", params: (k: 1, k: 2))"), (4, 43), "`k` stands here twice", ""),
        (nodes("\"a\": (node: \"b.c\", inputs: {\"x\": \"y\"})"), (4, 42), "expected \"node.output\"", ""),
        (nodes("\"a\": (node: \"b.c\", inputs: {\"x\": [1]})"), (4, 43), "expected a string", ""),
        (
            nodes("\"a\": (node: \"b.c\", inputs: {\"x\": 1})"),
            (4, 42),
            "expected \"node.output\" or a list",
            "",
        ),
        (nodes("\"ä ö\": (node: \"b.c\"), \"a\": ()"), (4, 9), "`ä ö` is no name", "letter"),
        (nodes("\"a\": (node: \"b.c\"), \"a\": (node: \"b.c\")"), (4, 29), "`a` stands here twice", "remove"),
        (nodes("\"graph\": (node: \"b.c\")"), (4, 18), "stands for the graph itself", "another name"),
    ];
    for (text, place, message, help) in cases {
        let errors = Document::parse(&text, "x.ron").expect_err(&text);
        let error = &errors.errors()[0];
        assert_eq!((error.line().unwrap(), error.column().unwrap()), place, "{text}\n{error}");
        assert!(error.message().contains(message), "{text}\n{error}");
        assert!(error.help_text().unwrap_or("").contains(help), "{text}\n{:?}", error.help_text());
        assert!(error.to_string().starts_with(&format!("x.ron:{}:{}: ", place.0, place.1)), "{error}");
    }
}

#[test]
fn many_faults_are_told_at_once() {
    let text = "(format: 1, doc: 1, nodes: {\"a\": 1, \"b\": (node: 2), \"c c\": (node: \"x\")}, colour: 3)";
    let errors = Document::parse(text, "x.ron").unwrap_err();
    let columns: Vec<_> = errors.errors().iter().filter_map(|error| error.column()).collect();
    assert_eq!(columns, [18, 34, 49, 53, 74]);
    let many: String = (0..100).map(|index| format!("\"n{index}\": 1, ")).collect();
    let errors = Document::parse(&format!("(format: 1, nodes: {{{many}}})"), "x.ron").unwrap_err();
    assert_eq!(errors.errors().len(), orograph_engine::DocumentErrors::MOST);
}

#[test]
fn hostile_files_are_refused() {
    for (open, close) in [("(", ")"), ("[", "]"), ("{", "}"), ("a(", ")"), ("{1:", "}"), ("/*", "*/")] {
        for depth in [65, 10_000, 1_000_000] {
            let text = format!("(format: 1, nodes: {}{})", open.repeat(depth), close.repeat(depth));
            assert!(Document::parse(&text, "x.ron").is_err(), "{open} × {depth}");
            assert!(Document::parse(&text[..text.len() / 2], "x.ron").is_err(), "{open} × {depth}, cut");
        }
    }
    let errors = Document::from_bytes(b"(format: 1,\n \xff", "x.ron").unwrap_err();
    let error = &errors.errors()[0];
    assert_eq!((error.line(), error.column()), (Some(2), Some(2)));
    assert!(error.message().contains("not valid UTF-8"), "{error}");
    let errors = Document::from_bytes(&vec![b' '; MAX_BYTES + 1], "x.ron").unwrap_err();
    assert!(errors.to_string().contains("at most 67108864"), "{errors}");
    let values = format!("(format: 1, nodes: [{}])", "0,".repeat(2_000_001));
    assert!(Document::parse(&values, "x.ron").unwrap_err().to_string().contains("more than 2000000 values"));
}

#[test]
fn errors_show_a_snippet() {
    let errors = Document::parse("(\n    format: 1,\n    nods: {},\n    nodes: 3,\n)", "x.ron").unwrap_err();
    let shown = format!("{:?}", miette::Report::new(errors.errors()[0].clone()));
    assert!(
        shown.contains("x.ron:3:5") && shown.contains("nods: {}") && shown.contains("did you mean"),
        "{shown}"
    );
}

fn literal() -> impl Strategy<Value = Literal> {
    let leaf = prop_oneof![
        any::<bool>().prop_map(Literal::Boolean),
        any::<i64>().prop_map(Literal::Integer),
        any::<f64>().prop_filter("finite", |x| x.is_finite()).prop_map(Literal::Number),
        ".*".prop_map(Literal::Text),
        "[a-qs-z_][a-z0-9_]{0,8}"
            .prop_filter("no keyword", |word| word != "true" && word != "false")
            .prop_map(Literal::Word),
    ];
    leaf.prop_recursive(3, 16, 4, |inner| {
        prop_oneof![
            prop::collection::vec(inner.clone(), 0..4).prop_map(Literal::List),
            prop::collection::vec(inner.clone(), 0..4).prop_map(Literal::Tuple),
            prop::collection::vec(("[a-z]{1,5}", inner.clone()), 1..4).prop_map(Literal::Fields),
            prop::collection::vec((inner.clone(), inner), 0..4).prop_map(Literal::Map),
        ]
    })
}

const NAME: &str = "[a-z][a-z0-9_-]{0,6}";

fn link() -> impl Strategy<Value = Link> {
    (NAME, "[a-z]{1,5}").prop_map(|(node, port)| Link::new(node, port))
}

/// Fields that no format knows yet.
fn extra() -> impl Strategy<Value = IndexMap<String, Literal>> {
    prop::collection::vec(("new_[a-z]{1,5}", literal()), 0..2).prop_map(|fields| fields.into_iter().collect())
}

fn node() -> impl Strategy<Value = Node> {
    let body = prop_oneof![
        (prop::sample::select(vec!["io.read", "filter.smooth", "later.thing"]), prop::option::of(1..5_u32))
            .prop_map(|(id, version)| Body::Type { id: id.into(), version }),
        ".{1,9}".prop_map(|path| Body::Graph { path }),
    ];
    let params = prop::collection::vec((prop_oneof!["[a-z_]{1,6}", ".{0,4}"], literal()), 0..5);
    let inputs = prop::collection::vec(("[a-z]{1,5}", prop::collection::vec(link(), 0..3)), 0..3);
    (body, params, inputs, any::<bool>(), ".*").prop_map(|(body, params, inputs, bypass, comment)| {
        let mut node = Node::of_graph("");
        node.body = body;
        node.params = params.into_iter().collect();
        node.inputs = inputs.into_iter().collect();
        node.bypass = bypass;
        node.comment = comment;
        node
    })
}

fn document() -> impl Strategy<Value = Document> {
    let nodes = prop::collection::vec((NAME.prop_filter("reserved", |name| name != "graph"), node()), 0..6);
    let place = || (-1e6..1e6, -1e6..1e6);
    let comment = (".*", place(), extra()).prop_map(|(text, at, extra)| Comment { text, at, extra });
    let frame = (".*", place(), place(), extra()).prop_map(|(title, (x, y), (width, height), extra)| Frame {
        title,
        rect: (x, y, width, height),
        extra,
    });
    let bend = (link(), link(), prop::collection::vec(place(), 0..3), extra())
        .prop_map(|(from, to, through, extra)| Bend { from, to, through, extra });
    let layout = (
        prop::collection::vec((NAME, place()), 0..3),
        prop::collection::vec(comment, 0..2),
        prop::collection::vec(frame, 0..2),
        prop::collection::vec(bend, 0..2),
        extra(),
    );
    let exposed = (link(), ".*", prop::option::of(-1e6..0.0), extra())
        .prop_map(|(param, doc, low, extra)| Exposed { param, doc, range: low.map(|low| (low, 1.0)), extra });
    let input =
        (".*", extra()).prop_map(|(doc, extra)| GraphInput { value_type: ValueType::Mask, doc, extra });
    let interface = (
        prop::collection::vec((NAME, exposed), 0..2),
        prop::collection::vec((NAME, input), 0..2),
        prop::collection::vec((NAME, link()), 0..3),
        extra(),
    );
    // Either a comment as it would stand, or none.
    let header = "(// [a-z/*()]{0,12}[a-z)](\n|\n\n)){0,2}// [a-z]|/\\*( [a-z]{1,6})?(\n[a-z(]{1,6})? \\*/|";
    (header, ".*", nodes, interface, layout).prop_map(
        |(header, doc, nodes, (expose, inputs, outputs, extra), layout)| {
            let mut document = Document::new();
            document.header = header;
            document.doc = doc;
            document.nodes = nodes.into_iter().collect();
            document.outputs = outputs.into_iter().collect();
            document.layout.nodes = layout.0.into_iter().collect();
            (document.layout.comments, document.layout.frames) = (layout.1, layout.2);
            (document.layout.bends, document.layout.extra) = (layout.3, layout.4);
            document.expose = expose.into_iter().collect();
            document.inputs = inputs.into_iter().collect();
            document.extra = extra;
            document
        },
    )
}

proptest! {
    #[test]
    fn any_document_round_trips(document in document()) {
        let text = document.to_ron(&registry());
        let again = Document::parse(&text, "x.ron").map_err(|errors| {
            TestCaseError::fail(format!("{errors}\n{text}"))
        })?;
        prop_assert_eq!(&again, &document, "{}", text);
        prop_assert_eq!(again.to_ron(&registry()), text);
    }

    #[test]
    fn no_bytes_panic(mutations in prop::collection::vec((0..FULL.len(), any::<u8>(), 0..3_u8), 1..12)) {
        let mut bytes = FULL.as_bytes().to_vec();
        for (at, byte, how) in mutations {
            let at = at % bytes.len();
            match how {
                0 => bytes[at] = byte,
                1 => bytes.insert(at, b"()[]{}\",:'\\r#b/*"[usize::from(byte) % 16]),
                _ => {
                    bytes.remove(at);
                }
            }
        }
        if let Ok(document) = Document::from_bytes(&bytes, "x.ron") {
            let text = document.to_ron(&registry());
            prop_assert_eq!(Document::parse(&text, "x.ron").unwrap(), document);
        }
    }

    #[test]
    fn any_header_is_written_as_comments(header in "[a-z/*()#! \\n\\r]{0,40}") {
        let mut document = Document::new();
        document.header = header;
        let text = document.to_ron(&registry());
        let again = Document::parse(&text, "x.ron").map_err(|errors| {
            TestCaseError::fail(format!("{errors}\n{text}"))
        })?;
        prop_assert_eq!(again.to_ron(&registry()), text);
    }

    #[test]
    fn no_text_panics(text in "[()\\[\\]{}:,\"'a-z0-9.#/*\\\\ \\n-]{0,60}") {
        let _ = Document::parse(&text, "x.ron");
        let _ = Document::parse(&format!("(format: 1, nodes: {{\"a\": (node: {text})}})"), "x.ron");
        let _ = Literal::parse(&text);
    }
}
