//! `orograph run --watch`: the run again when something changes.

#![cfg(unix)]
// A helper that fails is a test that fails.
#![allow(clippy::unwrap_used)]

mod support;

use std::{process::Command, time::Duration};

use support::{Place, plugins::unsound};

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
