//! Draws the sketches in `graphs/data/sketches`: `cargo run -p orograph-nodes --example draw_sketches [FOLDER]`.
//!
//! Strokes are given in shares of the picture, x right and y down, and drawn with smooth edges.

use std::{env, error::Error, fs, fs::File, io::BufWriter, path::Path};

/// Pixels along each side.
const SIDE: usize = 512;

/// A smooth line through places (x, y) with a width, all in shares of the picture.
struct Stroke {
    width: f64,
    path: Vec<[f64; 2]>,
}

/// Ink on paper.
struct Sketch {
    name: &'static str,
    strokes: Vec<Stroke>,
    paper: f64,
    ink: f64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = env::args().nth(1).unwrap_or_else(|| "graphs/data/sketches".into());
    fs::create_dir_all(&folder)?;
    for sketch in sketches() {
        write(&Path::new(&folder).join(sketch.name), &draw(&sketch))?;
    }
    Ok(())
}

fn sketches() -> [Sketch; 5] {
    let bright = |name, strokes| Sketch { name, strokes, paper: 0.0, ink: 1.0 };
    // The half-life: a λ in a circle.
    let mut half_life =
        vec![straight(0.03, &[[0.35, 0.23], [0.66, 0.78]]), straight(0.03, &[[0.5, 0.5], [0.35, 0.78]])];
    half_life.push(circle(0.03, [0.5, 0.5], 0.39));
    let y = vec![
        straight(0.035, &[[0.5, 0.52], [0.2, 0.14]]),
        straight(0.035, &[[0.5, 0.52], [0.8, 0.14]]),
        straight(0.035, &[[0.5, 0.52], [0.5, 0.88]]),
    ];
    let s = [
        [0.76, 0.22],
        [0.66, 0.13],
        [0.5, 0.1],
        [0.33, 0.15],
        [0.26, 0.28],
        [0.34, 0.41],
        [0.5, 0.49],
        [0.67, 0.58],
        [0.75, 0.71],
        [0.67, 0.85],
        [0.5, 0.9],
        [0.33, 0.87],
        [0.23, 0.77],
    ];
    let river = vec![
        curve(
            0.03,
            &[
                [0.0, 0.3],
                [0.12, 0.36],
                [0.22, 0.3],
                [0.33, 0.38],
                [0.42, 0.52],
                [0.54, 0.53],
                [0.64, 0.62],
                [0.76, 0.6],
                [0.86, 0.7],
                [1.0, 0.74],
            ],
        ),
        curve(0.02, &[[0.33, 0.0], [0.38, 0.12], [0.33, 0.22], [0.33, 0.38]]),
        curve(0.02, &[[0.78, 0.08], [0.7, 0.2], [0.72, 0.32], [0.62, 0.42], [0.54, 0.53]]),
        curve(0.016, &[[0.95, 0.26], [0.86, 0.3], [0.72, 0.32]]),
        curve(0.02, &[[0.2, 0.95], [0.3, 0.84], [0.32, 0.7], [0.42, 0.62], [0.42, 0.52]]),
        curve(0.02, &[[0.6, 1.0], [0.66, 0.88], [0.64, 0.76], [0.7, 0.68], [0.76, 0.6]]),
    ];
    // The character for water.
    let water = vec![
        curve(0.045, &[[0.5, 0.08], [0.5, 0.3], [0.5, 0.6], [0.5, 0.84]]),
        curve(0.04, &[[0.5, 0.84], [0.46, 0.87], [0.4, 0.83]]),
        straight(0.04, &[[0.13, 0.34], [0.37, 0.33]]),
        curve(0.04, &[[0.37, 0.33], [0.33, 0.5], [0.24, 0.66], [0.1, 0.79]]),
        curve(0.04, &[[0.83, 0.2], [0.75, 0.29], [0.64, 0.38], [0.5, 0.45]]),
        curve(0.045, &[[0.5, 0.37], [0.6, 0.53], [0.73, 0.68], [0.92, 0.81]]),
    ];
    [
        bright("half-life.png", half_life),
        bright("y.png", y),
        bright("s.png", vec![curve(0.035, &s)]),
        Sketch { name: "river.png", strokes: river, paper: 1.0, ink: 0.0 },
        bright("water.png", water),
    ]
}

fn straight(width: f64, path: &[[f64; 2]]) -> Stroke {
    Stroke { width, path: path.to_vec() }
}

/// A Catmull-Rom curve through the places.
fn curve(width: f64, through: &[[f64; 2]]) -> Stroke {
    let at = |i: isize| through[i.clamp(0, through.len() as isize - 1) as usize];
    let mut path = Vec::new();
    for i in 0..through.len() as isize - 1 {
        let [a, b, c, d] = [at(i - 1), at(i), at(i + 1), at(i + 2)];
        path.extend((0..24).map(|n| {
            let t = f64::from(n) / 24.0;
            [0, 1].map(|k| {
                let (p, q) = ((c[k] - a[k]) / 2.0, (d[k] - b[k]) / 2.0);
                let (e, f) = (3.0 * (c[k] - b[k]) - 2.0 * p - q, 2.0 * (b[k] - c[k]) + p + q);
                b[k] + t * (p + t * (e + t * f))
            })
        }));
    }
    path.push(at(through.len() as isize - 1));
    Stroke { width, path }
}

fn circle(width: f64, middle: [f64; 2], radius: f64) -> Stroke {
    let at = |i: u32| {
        let angle = f64::from(i) * std::f64::consts::TAU / 180.0;
        [middle[0] + radius * libm::cos(angle), middle[1] + radius * libm::sin(angle)]
    };
    Stroke { width, path: (0..=180).map(at).collect() }
}

/// The picture, 8 bits of grey.
fn draw(sketch: &Sketch) -> Vec<u8> {
    let side = SIDE as f64;
    let pixel = |i: usize| {
        let at = [(i % SIDE) as f64 + 0.5, (i / SIDE) as f64 + 0.5].map(|share| share / side);
        let covered = sketch.strokes.iter().map(|stroke| {
            let far = stroke.path.windows(2).map(|pair| distance(at, pair[0], pair[1]));
            let far = far.fold(f64::INFINITY, f64::min);
            ((stroke.width / 2.0 - far) * side + 0.5).clamp(0.0, 1.0)
        });
        let ink = covered.fold(0.0, f64::max);
        ((sketch.paper + (sketch.ink - sketch.paper) * ink) * 255.0).round() as u8
    };
    (0..SIDE * SIDE).map(pixel).collect()
}

/// Distance from a place to a segment.
fn distance(at: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let along = [b[0] - a[0], b[1] - a[1]];
    let square = along[0] * along[0] + along[1] * along[1];
    let t = ((at[0] - a[0]) * along[0] + (at[1] - a[1]) * along[1]) / square.max(f64::MIN_POSITIVE);
    let t = t.clamp(0.0, 1.0);
    libm::hypot(at[0] - a[0] - t * along[0], at[1] - a[1] - t * along[1])
}

fn write(path: &Path, greys: &[u8]) -> Result<(), Box<dyn Error>> {
    let mut encoder = png::Encoder::new(BufWriter::new(File::create(path)?), SIDE as u32, SIDE as u32);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::High);
    encoder.write_header()?.write_image_data(greys)?;
    Ok(())
}
