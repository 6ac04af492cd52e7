//! Plugins: found, refused with the reason, run here and apart, and never the end of the program.

#![cfg(unix)]

mod support;

use std::{
    path::{Path, PathBuf},
    process::Command,
    time::{Duration, Instant},
};

use support::{Ended, Place};

/// Builds a C plugin into the folder `plugins` of a place.
fn build(place: &Place, source: &str, name: &str, flags: &[&str]) -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = place.path("plugins");
    std::fs::create_dir_all(&folder).unwrap();
    let library = folder.join(name).with_extension(std::env::consts::DLL_EXTENSION);
    // What links Rust programs compiles C.
    let mut compiler = Command::new(std::env::var_os("CC").unwrap_or_else(|| "cc".into()));
    compiler.args(["-std=gnu11", "-shared", "-fPIC", "-O1", "-pthread", "-o"]).arg(&library);
    // Folders that `flags` name are looked through first.
    compiler.args(flags).arg("-I").arg(root.join("plugins")).arg(root.join("tests/plugins").join(source));
    let built = compiler.output().unwrap();
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    library
}

fn unsound(place: &Place, case: &str, flags: &[&str]) -> PathBuf {
    let case_flag = format!("-DCASE={case}");
    let mut all = vec![case_flag.as_str()];
    if !flags.iter().any(|flag| flag.starts_with("-DANSWER")) {
        all.push("-DANSWER=42");
    }
    all.extend_from_slice(flags);
    build(place, "unsound.c", &case.to_lowercase(), &all)
}

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
    std::fs::create_dir_all(place.path("data/orograph")).unwrap();
    std::fs::rename(place.path("plugins"), place.path("data/orograph/plugins")).unwrap();
    place.ok(line).gives(&["42"]);
    let mut command = place.command("plugin list");
    std::fs::create_dir_all(place.path("config/orograph")).unwrap();
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

/// A run that watches, and what it has printed.
struct Watching {
    child: std::process::Child,
    lines: std::sync::mpsc::Receiver<String>,
}

impl Watching {
    fn start(place: &Place, line: &str) -> Self {
        use std::io::BufRead;
        let mut child = place.command(line).spawn().unwrap();
        let (sender, lines) = std::sync::mpsc::channel();
        let (out, err) = (child.stdout.take().unwrap(), child.stderr.take().unwrap());
        let readers: [Box<dyn std::io::Read + Send>; 2] = [Box::new(out), Box::new(err)];
        for reader in readers {
            let sender = sender.clone();
            std::thread::spawn(move || {
                for line in std::io::BufReader::new(reader).lines().map_while(Result::ok) {
                    let _ = sender.send(line);
                }
            });
        }
        Self { child, lines }
    }

    /// Waits for each of `wanted` to be printed, in any order.
    fn expect(&self, wanted: &[&str]) {
        let mut wanted = wanted.to_vec();
        let mut seen = Vec::new();
        while !wanted.is_empty() {
            let line = self.lines.recv_timeout(Duration::from_secs(60));
            let line = line.unwrap_or_else(|_| panic!("{wanted:?} did not come after {seen:?}"));
            wanted.retain(|part| !line.contains(part));
            seen.push(line);
        }
    }

    fn end(mut self) {
        Command::new("kill").args(["-INT", &self.child.id().to_string()]).status().unwrap();
        assert_eq!(self.child.wait().unwrap().code(), Some(0));
    }
}

#[test]
fn a_watching_run_takes_up_rebuilt_plugins_and_changed_graphs() {
    let graph = |cells: u32| {
        format!(
            r#"(format: 1, nodes: {{
            "n": (node: "sound.node", version: 1),
            "hills": (node: "generate.fbm", version: 1, params: (cells: {cells})),
            "stats": (node: "measure.statistics", version: 1, inputs: {{"terrain": "hills.terrain"}}),
            }})"#
        )
    };
    let place = Place::with(&graph(16));
    unsound(&place, "SOUND", &["-DANSWER=1"]);
    let watching = Watching::start(&place, "run g.ron n.number stats.metrics --plugins plugins --watch");
    watching.expect(&["  1", "3 computed", "watching"]);
    unsound(&place, "SOUND", &["-DANSWER=2"]);
    watching.expect(&["  2", "1 computed", "watching"]);
    place.write("g.ron", graph(17));
    watching.expect(&["2 computed, 1 found", "watching"]);
    place.write("g.ron", "(format: 1, nodes: {");
    watching.expect(&["error: ", "watching"]);
    place.write("g.ron", graph(16));
    watching.expect(&["0 computed", "watching"]);
    watching.end();
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
