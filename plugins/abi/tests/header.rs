//! `plugins/orograph_plugin.h` is what the structs of this crate say, and C and C++ take it.
//!
//! `UPDATE_HEADER=1 cargo test -p orograph-abi --test header` writes it anew.

// A helper that fails is a test that fails.
#![allow(clippy::unwrap_used)]

use std::{
    ffi::CStr,
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use cbindgen::{Builder, Config, DocumentationStyle, Language, Style};
use orograph_abi::{FILES, PluginSpec, SCRATCH, SETTINGS, THREADS};

const SOURCES: [&str; 2] = ["src/types.rs", "src/calls.rs"];

fn here(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

fn header() -> PathBuf {
    here("../orograph_plugin.h")
}

/// The structs and unions in the order in which they are declared; the generator leaves out what no function takes.
fn names() -> Vec<String> {
    let sources = SOURCES.map(|source| fs::read_to_string(here(source)).unwrap()).concat();
    let declared = sources.lines().filter_map(|line| {
        let rest = line.strip_prefix("pub struct ").or_else(|| line.strip_prefix("pub union "))?;
        rest.split([' ', '<']).next().map(str::to_owned)
    });
    declared.collect()
}

fn generated() -> String {
    let mut config = Config {
        language: Language::C,
        cpp_compat: true,
        header: Some(fs::read_to_string(here("tests/preface.h")).unwrap().trim_end().into()),
        after_includes: Some(fs::read_to_string(here("tests/after_includes.h")).unwrap().trim_end().into()),
        no_includes: true,
        sys_includes: vec!["stddef.h".into(), "stdint.h".into()],
        style: Style::Both,
        documentation_style: DocumentationStyle::C99,
        usize_is_size_t: true,
        line_length: 110,
        tab_width: 4,
        ..Config::default()
    };
    config.export.include = names();
    config.trailer = Some(trailer());
    let builder = SOURCES.iter().fold(Builder::new(), |builder, source| builder.with_src(here(source)));
    let mut text = Vec::new();
    builder.with_config(config).generate().unwrap().write(&mut text);
    String::from_utf8(text).unwrap()
}

/// What the generator does not carry over: the names of extensions, and the constant that a plugin exports.
fn trailer() -> String {
    let names: [(&str, &CStr, &str); 4] = [
        ("OROGRAPH_THREADS", THREADS, "the host's, an OrographThreads"),
        ("OROGRAPH_SCRATCH", SCRATCH, "the host's, an OrographScratch"),
        ("OROGRAPH_FILES", FILES, "the host's, an OrographFiles"),
        ("OROGRAPH_SETTINGS", SETTINGS, "the plugin's, an OrographSettings"),
    ];
    let names = names.map(|(name, value, whose)| {
        format!("// Name of an extension: {whose}.\n#define {name} \"{}\"\n\n", value.to_str().unwrap())
    });
    let exported = "// What a plugin defines.\n\
         #ifdef __cplusplus\nextern \"C\" {\n#endif\n\
         extern OROGRAPH_EXPORT const OrographPlugin orograph_plugin;\n\
         #ifdef __cplusplus\n}\n#endif\n\n#endif // OROGRAPH_PLUGIN_H";
    names.concat() + exported
}

#[test]
fn the_header_is_what_the_structs_say() {
    let fresh = generated();
    if std::env::var_os("UPDATE_HEADER").is_some() {
        fs::write(header(), &fresh).unwrap();
    }
    let committed = fs::read_to_string(header()).unwrap();
    assert!(committed == fresh, "the header is stale: run this test with UPDATE_HEADER=1");
    for name in names() {
        assert!(fresh.contains(&format!("}} {name};")), "{name} is not in the header");
    }
}

#[test]
fn c_and_c_plus_plus_take_it_without_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    for (compiler, standard, name) in [
        ("cc", "-std=c11", "plugin.c"),
        ("c++", "-std=c++11", "plugin.cpp"),
        ("c++", "-std=c++20", "plugin.cpp"),
    ] {
        // Twice: the guard holds.
        let include = format!("#include \"{}\"\n", header().display());
        let source = folder.path().join(name);
        let text = include.repeat(2)
            + "static OrographText describe(void) { OrographText none = {0, 0}; return none; }\n\
               const OrographPlugin orograph_plugin = {sizeof(OrographPlugin), OROGRAPH_ABI_MAJOR, \
               OROGRAPH_ABI_MINOR, 0, describe, 0, 0};\n";
        fs::write(&source, text).unwrap();
        let said = Command::new(compiler)
            .args([standard, "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-fsyntax-only"])
            .arg(&source)
            .output()
            .unwrap_or_else(|error| panic!("{compiler}: {error}"));
        assert!(said.status.success(), "{standard}: {}", String::from_utf8_lossy(&said.stderr));
    }
}

#[test]
fn the_example_of_a_spec_is_one() {
    let preface = fs::read_to_string(here("tests/preface.h")).unwrap();
    let text = preface.lines().map(|line| line.strip_prefix(" *     ").unwrap_or(""));
    let text: Vec<_> =
        text.skip_while(|line| !line.starts_with("(name:")).take_while(|line| !line.is_empty()).collect();
    let spec: PluginSpec = ron::from_str(&text.join("\n")).unwrap();
    assert_eq!(spec.nodes[0].params.len(), 8);
    for param in &spec.nodes[0].params {
        param.check(&param.default).unwrap();
    }
}

/// What a plugin that was built with ABI 1.0 knows; nothing of it ever changes.
#[test]
fn the_frozen_header_declares_nothing_that_the_header_has_no_more() {
    let frozen = fs::read_to_string(here("frozen/orograph_plugin_1_0.h")).unwrap();
    let now = fs::read_to_string(header()).unwrap();
    let declarations = |text: &str| -> Vec<String> {
        let code = text.lines().filter(|line| !line.trim_start().starts_with("//"));
        code.map(|line| line.trim().to_owned())
            .filter(|line| line.ends_with(';') || line.contains("#define"))
            .collect()
    };
    let now = declarations(&now);
    for line in declarations(&frozen) {
        assert!(line.contains("ABI_MINOR") || now.contains(&line), "the header has lost: {line}");
    }
}
