//! Plugins: found, refused with the reason, told apart by content, checked.

#![cfg(unix)]
// A helper that fails is a test that fails.
#![allow(clippy::unwrap_used)]

mod support;

use std::{
    path::Path,
    time::{Duration, Instant},
};

use support::{
    Ended, Place,
    plugins::{build, unsound},
};

#[test]
fn unsound_plugins_are_refused_with_the_reason_and_nothing_else_suffers() {
    let place = Place::nodes(r#""n": (node: "sound.node", version: 1),"#);
    unsound(&place, "SOUND", &[]);
    for case in [
        "CRASHES",
        "EXITS",
        "NO_RON",
        "HUGE",
        "TWINS",
        "BAD_NAME",
        "BAD_DEFAULT",
        "WRITES",
        "EMPTY",
        "NO_TEXT",
        "CLASH",
    ] {
        unsound(&place, case, &[]);
    }
    let variants: [(&str, &[&str]); 5] = [
        ("major", &["-DMAJOR=2"]),
        ("small", &["-DSIZE=8"]),
        ("null", &["-DDESCRIBE=0"]),
        ("nameless", &["-DNAME=something_else"]),
        ("copy", &[]),
    ];
    for (name, flags) in variants {
        let library = build(&place, "unsound.c", name, &[&["-DCASE=0", "-DANSWER=1"], flags].concat());
        if name == "copy" {
            std::fs::copy(
                place.path("plugins").join("sound").with_extension(std::env::consts::DLL_EXTENSION),
                library,
            )
            .unwrap();
        }
    }
    #[cfg(target_os = "linux")]
    {
        // Bytes 18 and 19 of an ELF file name its machine; 243 is RISC-V.
        let mut foreign = std::fs::read(place.path("plugins/empty.so")).unwrap();
        foreign[18..20].copy_from_slice(&[243, 0]);
        place.write("plugins/foreign.so", foreign);
        let ended = place.ok("plugin list --plugins plugins");
        let line = ended.out.lines().find(|line| line.contains("foreign.so"));
        assert!(
            line.is_some_and(|line| line.contains("it is built for another machine: Riscv64")),
            "{line:?}"
        );
    }
    place.write(&format!("plugins/text.{}", std::env::consts::DLL_EXTENSION), "no library");
    place.write("plugins/readme.txt", "no plugin either");
    let ended = place.ok("plugin list --plugins plugins");
    for (name, said) in [
        ("crashes", "it ended the process that looked at it: SIGABRT"),
        ("exits", "it ended the process that looked at it: exit code 7"),
        ("no_ron", "its spec is no RON of a plugin: 1:1"),
        ("huge", "its spec is 104857600 bytes long"),
        ("twins", "two of its nodes are named `twin.node`"),
        ("bad_name", "the id `NoFamily` has no dot"),
        ("bad_default", "the default of `size`: `size` is 2"),
        ("writes", "writes files"),
        ("empty", "it has no nodes"),
        ("no_text", "5 items at a null pointer"),
        ("clash", "its node `adjust.clamp` is there already, supplied by Orograph itself"),
        ("major", "it was built for ABI 2.9, and this is ABI 1"),
        ("small", "says that it has 8 bytes"),
        ("null", "its `describe` is a null pointer"),
        ("nameless", "it exports no `orograph_plugin`"),
        ("text", "it is no dynamic library"),
    ] {
        let start = format!(
            "refused: {}",
            place
                .path("plugins")
                .join(name)
                .with_extension(std::env::consts::DLL_EXTENSION)
                .strip_prefix(place.path(""))
                .unwrap()
                .display()
        );
        let line = ended.out.lines().find(|line| line.starts_with(&start));
        assert!(
            line.is_some_and(|line| line.contains(said)),
            "{name}: {line:?} should say: {said}\n{}",
            ended.out
        );
    }
    assert!(
        ended.out.contains("refused: plugins/sound") && ended.out.contains("the same as plugins/copy"),
        "{}",
        ended.out
    );
    assert!(ended.out.contains("  sound.node"), "{}", ended.out);
    assert!(!ended.out.contains("readme.txt"), "{}", ended.out);
    place.ok("run g.ron n.number --plugins plugins").gives(&["42"]);
}

#[test]
fn a_plugin_that_hangs_while_it_is_scanned_is_stopped_and_remembered() {
    let place = Place::nodes(r#""n": (node: "sound.node", version: 1),"#);
    unsound(&place, "HANGS", &[]);
    unsound(&place, "SOUND", &[]);
    let ended = place.ok("run g.ron n.number --plugins plugins").gives(&["42"]);
    ended.tells(&["hangs", "did not say within 10 s what it is"]);
    let started = Instant::now();
    place.ok("plugin list --plugins plugins").gives(&["did not say within 10 s", "sound.node"]);
    assert!(started.elapsed() < Duration::from_secs(5), "it was scanned again");
}

#[test]
fn a_plugin_that_describes_itself_in_two_ways_runs_nothing() {
    let place = Place::nodes(r#""n": (node: "liar.node", version: 1),"#);
    unsound(&place, "LIES", &[]);
    let ended = place.run("run g.ron n.number --plugins plugins").code(1);
    ended.tells(&["it describes itself otherwise than when it was scanned"]);
}

#[test]
fn folders_come_from_the_command_line_the_environment_and_the_user() {
    let place = Place::nodes(r#""n": (node: "sound.node", version: 1),"#);
    unsound(&place, "SOUND", &[]);
    let line = "run g.ron n.number --cache none";
    place.run(line).code(2).tells(&["sound.node"]);
    place.run(&format!("{line} --plugins nowhere")).code(2).tells(&["nowhere"]);
    let mut command = place.command(line);
    command.env("OROGRAPH_PLUGINS", place.path("plugins"));
    Ended::new(line, command.output().unwrap()).code(0).gives(&["42"]);
    std::fs::create_dir_all(place.path("config/orograph")).unwrap();
    place.write("config/orograph/settings.ron", "(plugins: [\"../../plugins\", \"gone\"])");
    place.ok(line).gives(&["42"]).tells(&["warning: no plugins of ", "config/orograph/gone"]);
    place.write("config/orograph/settings.ron", "()");
    std::fs::create_dir_all(place.path("data/orograph")).unwrap();
    std::fs::rename(place.path("plugins"), place.path("data/orograph/plugins")).unwrap();
    place.ok(line).gives(&["42"]);
    let mut command = place.command("plugin list");
    place.write("config/orograph/settings.ron", "(isolate: [\"Sound\"])");
    Ended::new("plugin list", command.output().unwrap())
        .code(0)
        .gives(&["Sound 1.0, in processes of its own"]);
    place.write("config/orograph/settings.ron", "(insulate: [])");
    place.run(line).code(2).tells(&["settings.ron:1:", "insulate"]);
}

#[test]
fn a_rebuilt_plugin_is_another_and_only_what_needs_it_runs_again() {
    let place = Place::nodes(
        r#"
        "n": (node: "sound.node", version: 1),
        "hills": (node: "generate.fbm", version: 1, params: (cells: 16)),
        "stats": (node: "measure.statistics", version: 1, inputs: {"terrain": "hills.terrain"}),
        "#,
    );
    let line = "run g.ron n.number stats.metrics --plugins plugins";
    unsound(&place, "SOUND", &["-DANSWER=1"]);
    place.ok(line).tells(&["3 computed"]);
    place.ok(line).tells(&["0 computed"]);
    unsound(&place, "SOUND", &["-DANSWER=2"]);
    place.ok(line).tells(&["1 computed"]).gives(&["  2"]);
    unsound(&place, "SOUND", &["-DANSWER=1"]);
    place.ok(line).tells(&["0 computed"]).gives(&["  1"]);
}

#[test]
fn a_graph_without_its_plugin_says_which() {
    let place = Place::nodes(r#""n": (node: "sound.node", version: 1, plugin: "Sound"),"#);
    for line in ["run g.ron n.number", "run g.ron n"] {
        let said = ["there is no node type `sound.node`", "the plugin `Sound` supplies it"];
        place.run(line).code(2).tells(&said);
    }
    place.ok("graph g.ron --ron").gives(&["plugin: \"Sound\""]);
    unsound(&place, "SOUND", &[]);
    place.ok("run g.ron n.number --plugins plugins").gives(&["42"]);
}

#[test]
fn a_check_tells_what_to_mend() {
    let place = Place::nodes("");
    unsound(&place, "SOUND", &[]);
    let sound = place.ok("plugin check plugins/sound.so");
    assert!(
        sound.out.contains("ok   the same bits on 1, 2 and 8 threads") && !sound.out.contains("MEND"),
        "{sound:?}"
    );
    build(&place, "hostile.c", "hostile", &[]);
    let said = "MEND cancelling: cancelled, it completes: ask the host whether to stop";
    place.run("plugin check plugins/hostile.so").code(1).gives(&[said]).tells(&["1 things to mend"]);
    build(&place, "hostile.c", "crashing", &["-DHOW=\"segfault\""]);
    let said = "MEND tiny and void terrain: (0, 0) cells, Whole: the plugin's process ended: SIGSEGV";
    place.run("plugin check plugins/crashing.so").code(1).gives(&[said]);
    unsound(&place, "TWINS", &[]);
    place.run("plugin check plugins/twins.so").code(2).tells(&["two of its nodes are named `twin.node`"]);
    place.run("plugin check plugins/absent.so").code(2).tells(&["absent.so"]);
}

#[test]
fn a_plugin_built_against_the_header_of_1_0_loads() {
    let place = Place::nodes(r#""n": (node: "sound.node", version: 1),"#);
    let frozen = Path::new(env!("CARGO_MANIFEST_DIR")).join("plugins/abi/frozen/orograph_plugin_1_0.h");
    std::fs::create_dir(place.path("include")).unwrap();
    std::fs::copy(frozen, place.path("include/orograph_plugin.h")).unwrap();
    // Found before the header of today, which is looked for in the folders named after it.
    let include = format!("-I{}", place.path("include").display());
    build(&place, "unsound.c", "frozen", &[&include, "-DCASE=0", "-DANSWER=42"]);
    place.ok("run g.ron n.number --plugins plugins").gives(&["42"]);
}
