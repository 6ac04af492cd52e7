//! What a frame of the window costs on a graph of 500 nodes: `cargo bench -p orograph-editor --bench frame`.
//!
//! Layout, text and tessellation, all that the processor does for a frame, without a window and its driver. Then the
//! longest frame while the graph is computed and edited, which is the longest that a user waits for the pointer.

use std::{
    fmt::Write as _,
    path::{Path, PathBuf},
    sync::Arc,
    time::{Duration, Instant},
};

use eframe::egui::{self, Event, Modifiers, PointerButton, Pos2, RawInput, Rect, pos2, vec2};
use orograph_core::Value;
use orograph_editor::{App, Command, Start};
use orograph_engine::{Cache, Evaluator};

const NODES: usize = 500;
const FRAMES: usize = 200;
const LARGE: usize = 8192;

fn main() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("many.ron");
    std::fs::write(&file, many()).expect("a graph");
    let mut window = Window::new(file);
    window.command(Command::Thumbnails);
    window.rest();
    window.command(Command::Fit);
    window.told("the whole graph, nothing happens", FRAMES, |_, _| {});
    let still = window.node(0);
    window.told("the whole graph, the pointer wanders", FRAMES, |window, n| {
        window.events.push(Event::PointerMoved(still + vec2((n % 60) as f32 * 5.0, (n % 40) as f32 * 5.0)));
    });
    window.events.push(Event::PointerMoved(still));
    window.frame();
    window.told("the whole graph, one node is dragged", FRAMES, |window, n| {
        window.drag(still, n, FRAMES);
    });
    // Larger, until names can just be read: more nodes with all that is in them are never seen at once.
    while window.app.to_window().scaling < 0.36 {
        window.events.push(Event::PointerMoved(pos2(500.0, 650.0)));
        window.wheel(0.5);
        window.frame();
    }
    let scale = window.app.to_window().scaling;
    window.told(
        &format!("a part of the graph at {scale:.2} of its size, nothing happens"),
        FRAMES,
        |_, _| {},
    );
    window.command(Command::Fit);
    window.command(Command::SelectAll);
    window.command(Command::Fit);
    window.told("the whole graph, all selected", FRAMES, |_, _| {});
    window.command(Command::Thumbnails);
    window.told(
        "under load: the graph is computed with a picture for every node",
        2 * FRAMES,
        |window, n| {
            if n % 20 == 0 {
                window.command(Command::Bypass);
            }
            window.drag(still, n % 50, 50);
        },
    );
    large(folder.path());
}

/// The frames in which a picture of `LARGE`² cells comes into a pane, is looked at closely and is walked around.
fn large(folder: &Path) {
    let file = folder.join("large.ron");
    let text = format!(
        "(format: 1, nodes: {{\"small\": (node: \"generate.fbm\", version: 1, params: (cells: 256)),
        \"large\": (node: \"transform.resize\", version: 1, params: (cells: {LARGE}),
        inputs: {{\"terrain\": \"small.terrain\"}})}}, layout: (nodes: {{\"small\": (0, 0), \"large\": (400, 0)}}))"
    );
    std::fs::write(&file, text).expect("a graph");
    let mut window = Window::new(file);
    window.command(Command::Thumbnails);
    // Opened, it is shown at once.
    window.told(&format!("a picture of {LARGE}² cells comes"), 10 * FRAMES, |_, _| {});
    window.rest();
    let cols = match window.app.shown() {
        Some(Value::Heightfield(terrain)) => terrain.cols(),
        _ => 0,
    };
    assert_eq!(cols, LARGE, "it is shown: {:?} {:?}", window.app.selection(), window.app.told());
    let middle = pos2(480.0, 250.0);
    window.told("it is enlarged", FRAMES, |window, n| {
        window.events.push(Event::PointerMoved(middle + vec2((n % 7) as f32, 0.0)));
        window.wheel(if n < FRAMES / 2 { 1.0 } else { -1.0 });
    });
}

/// Rows of nodes wired along, with blurs that take a while.
fn many() -> String {
    let mut text = String::from("(format: 1, nodes: {\n");
    const ROW: usize = 25;
    let mut layout = String::new();
    for n in 0..NODES {
        let (row, col) = (n / ROW, n % ROW);
        match col {
            0 => writeln!(text, "\"n{n}\": (node: \"generate.fbm\", version: 1, params: (cells: 256, seed: {row})),"),
            _ => writeln!(
                text,
                "\"n{n}\": (node: \"filter.gaussian_blur\", version: 1, inputs: {{\"terrain\": \"n{}.terrain\"}}),",
                n - 1
            ),
        }
        .expect("text");
        writeln!(layout, "\"n{n}\": ({}.0, {}.0),", col * 260, row * 260).expect("text");
    }
    write!(text, "}}, layout: (nodes: {{\n{layout}}}))").expect("text");
    text
}

struct Window {
    ctx: egui::Context,
    app: App,
    events: Vec<Event>,
    time: f64,
}

impl Window {
    fn new(file: PathBuf) -> Self {
        let ctx = egui::Context::default();
        let registry = Arc::new(orograph_session::built_in().expect("node types"));
        let evaluator = Arc::new(Evaluator::new(Cache::new(1 << 30, None), 0).expect("threads"));
        let start = Start { file: Some(file), ..Start::with(registry, evaluator) };
        let app = App::new(&ctx, start);
        Self { ctx, app, events: Vec::new(), time: 0.0 }
    }

    /// One frame: how long the processor worked for it, and how long it took.
    fn frame(&mut self) -> (Duration, Duration) {
        self.time += 1.0 / 60.0;
        let input = RawInput {
            screen_rect: Some(Rect::from_min_size(Pos2::ZERO, vec2(1440.0, 900.0))),
            time: Some(self.time),
            max_texture_side: Some(16384),
            events: std::mem::take(&mut self.events),
            ..RawInput::default()
        };
        let (ctx, app) = (self.ctx.clone(), &mut self.app);
        let (begun, worked) = (Instant::now(), worked());
        let mut output = ctx.run_ui(input, |ui| app.ui(ui));
        let meshes = ctx.tessellate(output.shapes, output.pixels_per_point);
        std::hint::black_box(meshes);
        // What a graphics card would take.
        output.textures_delta.clear();
        let took = begun.elapsed();
        (self::worked().zip(worked).map_or(took, |(now, before)| now - before), took)
    }

    fn command(&mut self, command: Command) {
        self.app.command(&self.ctx, command);
        self.frame();
    }

    fn rest(&mut self) {
        let mut quiet = 0;
        while quiet < 5 {
            self.frame();
            quiet = if self.app.is_idle() { quiet + 1 } else { 0 };
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    fn wheel(&mut self, lines: f32) {
        self.events.push(Event::MouseWheel {
            unit: egui::MouseWheelUnit::Line,
            delta: vec2(0.0, lines),
            phase: egui::TouchPhase::Move,
            modifiers: Modifiers::NONE,
        });
    }

    /// Where a node's title is in the window.
    fn node(&self, n: usize) -> Pos2 {
        let (x, y) = self.app.document().layout.nodes[&format!("n{n}")];
        self.app.to_window() * (pos2(x as f32, y as f32) + vec2(70.0, 22.0))
    }

    fn button(pos: Pos2, pressed: bool) -> Event {
        Event::PointerButton { pos, button: PointerButton::Primary, pressed, modifiers: Modifiers::NONE }
    }

    /// The `n`th of `of` frames of a drag that ends where it began.
    fn drag(&mut self, from: Pos2, n: usize, of: usize) {
        let away = (n.min(of - n)) as f32;
        self.events.push(Event::PointerMoved(from + vec2(away, away / 2.0)));
        if n == 0 {
            self.events.push(Self::button(from, true));
        }
        if n + 1 == of {
            self.events.push(Self::button(from, false));
        }
    }

    fn told(&mut self, what: &str, frames: usize, mut before: impl FnMut(&mut Self, usize)) {
        let mut times = Vec::new();
        for n in 0..frames {
            before(self, n);
            times.push(self.frame());
            // As a screen would wait; what computes goes on.
            std::thread::sleep(Duration::from_millis(4));
        }
        let (mut work, mut wall): (Vec<_>, Vec<_>) = times.into_iter().unzip();
        work.sort_unstable();
        wall.sort_unstable();
        let ms = |time: Duration| time.as_secs_f64() * 1e3;
        #[expect(clippy::print_stdout, reason = "a benchmark's whole purpose")]
        {
            println!(
                "{what}: {:.2} ms of work in the median, {:.2} ms in 95 of 100; the longest took {:.2} ms",
                ms(work[work.len() / 2]),
                ms(work[work.len() * 95 / 100]),
                ms(wall[wall.len() - 1]),
            );
        }
    }
}

/// For how long this thread has had a processor, where the system tells.
#[cfg(unix)]
fn worked() -> Option<Duration> {
    use rustix::time::{ClockId, clock_gettime};
    clock_gettime(ClockId::ThreadCPUTime).try_into().ok()
}

#[cfg(not(unix))]
fn worked() -> Option<Duration> {
    None
}
