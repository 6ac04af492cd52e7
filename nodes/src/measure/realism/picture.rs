//! The report as a picture: both terrains shaded, their distributions, and the figures.

use glam::DVec2;
use orograph_core::prelude::*;

use super::{
    portrait::Portrait,
    verdict::{Verdict, word},
};
use crate::look::{
    canvas::{Anchor, Canvas, Type},
    chart::{Axis, Chart, SERIES, Series, Style},
    colour::{INK, PAPER, Tint},
    contact_sheet::scaled,
    hillshade::{Hillshade, HillshadeIn},
    ticks,
};
use crate::measure::geomorphons::Form;

const GOOD: Tint = [20, 130, 80, 255];
const BAD: Tint = [200, 45, 30, 255];
const RULE: Tint = [228, 230, 233, 255];

/// One side of the report.
#[derive(Clone, Copy, Debug)]
pub struct Side<'a> {
    /// What it is called.
    pub label: &'a str,
    /// The terrain.
    pub terrain: &'a Heightfield,
    /// Its figures.
    pub portrait: &'a Portrait,
}

/// Draws the report: two columns of `size` pixels.
///
/// # Errors
/// [`Error::TooLarge`] when `job` does not admit the memory, [`Error::Cancelled`].
pub fn draw(sides: [Side<'_>; 2], lines: &[Verdict], size: u32, job: &Job) -> Result<Texture> {
    // Text and margins grow with the picture, in whole steps.
    let s = i64::from((size / 480).max(1));
    let (face, bold) = (Type::plain(s as u32), Type::bold(s as u32));
    let (gap, wide) = (12 * s, i64::from(size));
    let shades = [shade(sides[0].terrain, size, job)?, shade(sides[1].terrain, size, job)?];
    let high = shades.iter().map(|shade| shade.rows() as i64).max().unwrap_or(0);
    // Flatter charts would cut off what their axes say.
    let chart = u32::try_from((wide * 5 / 8).max(300 * s)).unwrap_or(1);
    let (head, line) = (bold.height() + 8 * s, face.height() + 5 * s);
    let top_of_charts = gap + head + high + gap;
    let top_of_lines = top_of_charts + 2 * (i64::from(chart) + gap);
    let tall = top_of_lines + line * (lines.len() as i64 + 1) + gap;
    let mut canvas = Canvas::new(2 * wide + 3 * gap, tall, PAPER, job)?;
    for (i, (side, shade)) in sides.iter().zip(&shades).enumerate() {
        let left = gap + i as i64 * (wide + gap);
        let label = bold.fit(side.label, wide);
        canvas.text(label, left + wide / 2, gap + bold.height() / 2, Anchor::Middle, bold, SERIES[i]);
        canvas.paste(
            shade,
            left + (wide - shade.cols() as i64) / 2,
            gap + head + (high - shade.rows() as i64) / 2,
        );
    }
    let charts = [slopes(sides), hypsometry(sides), spectrum(sides)];
    for i in 0..4 {
        job.check()?;
        let left = gap + (i % 2) * (wide + gap);
        let top = top_of_charts + (i / 2) * (i64::from(chart) + gap);
        match charts.get(i as usize) {
            Some(of) => {
                let of = Chart { width: size, height: chart, ..of.clone() };
                canvas.paste(&of.draw(job)?, left, top);
            }
            None => forms(&mut canvas, sides, [left, top, wide, chart.into()], s),
        }
    }
    figures(&mut canvas, lines, [gap, top_of_lines, 2 * wide + gap, line], s);
    Ok(canvas.into_picture())
}

fn shade(terrain: &Heightfield, size: u32, job: &Job) -> Result<Texture> {
    let picture = Hillshade::default().run(HillshadeIn { terrain, onto: None }, job)?.picture;
    let grid = terrain.grid();
    // As long and wide as on the ground.
    let ground = [grid.cols as f64 * grid.cell.x, grid.rows as f64 * grid.cell.y];
    let scale = f64::from(size) / ground[0].max(ground[1]);
    let [width, height] = ground.map(|side| ((side * scale).round() as usize).max(1));
    scaled(&picture, (width, height), job)
}

fn plain_chart(title: &str, x: Axis, y: Axis, series: [Series; 2]) -> Chart {
    Chart { title: title.into(), x, y, series: series.into(), width: 1, height: 1 }
}

fn slopes(sides: [Side<'_>; 2]) -> Chart {
    let last = |side: &Side<'_>| side.portrait.slopes.degrees.shares.iter().rposition(|&share| share > 1e-4);
    let classes = sides.iter().filter_map(last).max().unwrap_or(0) + 2;
    let series = sides.map(|side| {
        let degrees = &side.portrait.slopes.degrees;
        let point = |(class, share): (usize, &f64)| DVec2::new(degrees.middle(class), 100.0 * share);
        let points = degrees.shares.iter().enumerate().take(classes).map(point).collect();
        Series { name: side.label.into(), style: Style::Area, points }
    });
    let x = Axis { label: "slope (deg)".into(), tight: true, ..Axis::default() };
    let y = Axis { label: "share of cells (%)".into(), from_zero: true, ..Axis::default() };
    plain_chart("Slopes", x, y, series)
}

fn hypsometry(sides: [Side<'_>; 2]) -> Chart {
    let series = sides.map(|side| {
        let above = side.portrait.heights.above();
        let last = (above.len() - 1) as f64;
        let point = |(level, share): (usize, f64)| DVec2::new(share, 100.0 * level as f64 / last);
        let points = above.into_iter().enumerate().map(point).collect();
        Series { name: side.label.into(), style: Style::Line, points }
    });
    let x = Axis { label: "share of cells above (%)".into(), tight: true, ..Axis::default() };
    let y =
        Axis { label: "height in the relief (%)".into(), from_zero: true, tight: true, ..Axis::default() };
    plain_chart("Hypsometry", x, y, series)
}

fn spectrum(sides: [Side<'_>; 2]) -> Chart {
    let series = sides.map(|side| {
        let rings = &side.portrait.rings;
        let of = |log: f64| libm::exp(log);
        let points = rings
            .rings
            .iter()
            .map(|ring| DVec2::new(of(-ring.log_wave_number), of(ring.log_density)))
            .collect();
        let name = if rings.beta.is_finite() {
            format!("{}: beta {:.2}", side.label, rings.beta)
        } else {
            side.label.into()
        };
        Series { name, style: Style::Marked, points }
    });
    let x = Axis { label: "wavelength (m)".into(), log: true, ..Axis::default() };
    let y = Axis { label: "power density (m^4)".into(), log: true, ..Axis::default() };
    plain_chart("Roughness spectrum", x, y, series)
}

/// Shares of the ten forms as pairs of bars.
fn forms(canvas: &mut Canvas, sides: [Side<'_>; 2], [left, top, width, height]: [i64; 4], s: i64) {
    let (face, bold) = (Type::plain(s as u32), Type::bold(s as u32));
    let (x0, y0) = (left + 56 * s, top + 42 * s);
    let (wide, high) = (width - 76 * s, height - 42 * s - 50 * s);
    canvas.text("Landforms (geomorphons)", x0, top + 18 * s, Anchor::Left, bold, INK);
    if wide < 20 || high < 20 {
        return;
    }
    let shares = sides.map(|side| side.portrait.forms.0.map(|share| 100.0 * share));
    let most = shares.iter().flatten().copied().fold(1.0, f64::max) * 1.05;
    let level = |share: f64| (high as f64 * share / most).round() as i64;
    for tick in ticks::linear(0.0, most, (high / (60 * s)) as f64) {
        let y = y0 + high - level(tick.value);
        canvas.fill(x0, y, wide, s, RULE);
        canvas.text(&tick.label, x0 - 9 * s, y, Anchor::Right, face, INK);
    }
    canvas.text_upwards("share of cells (%)", left + 14 * s, y0 + high / 2, face, INK);
    let place = wide / 10;
    let bar = place * 2 / 5;
    for (form, of) in Form::ALL.iter().enumerate() {
        let start = x0 + form as i64 * place + (place - 2 * bar) / 2;
        for (side, shares) in shares.iter().enumerate().filter(|(_, shares)| shares[form].is_finite()) {
            let tall = level(shares[form]);
            canvas.fill(start + side as i64 * bar, y0 + high - tall, bar - s, tall, SERIES[side]);
        }
        canvas.text(of.short_name(), start + bar, y0 + high + 14 * s, Anchor::Middle, face, INK);
    }
    canvas.frame(x0 - s, y0 - s, wide + 2 * s, high + 2 * s, INK);
}

/// The table of figures.
fn figures(canvas: &mut Canvas, lines: &[Verdict], [left, top, width, line]: [i64; 4], s: i64) {
    let (face, bold) = (Type::plain(s as u32), Type::bold(s as u32));
    let heads = ["metric", "unit", "terrain", "exemplar", "distance", "halves", "ratio", "bar", "met"];
    // Right ends of the columns as shares of the width; the first begins at the left.
    let ends = [0.0, 0.33, 0.44, 0.55, 0.66, 0.75, 0.84, 0.92, 1.0];
    let mut write = |row: i64, column: usize, text: &str, face: Type, colour: Tint| {
        let (x, anchor) = match column {
            0 => (left, Anchor::Left),
            _ => (left + (ends[column] * width as f64) as i64, Anchor::Right),
        };
        canvas.text(text, x, top + row * line + line / 2, anchor, face, colour);
    };
    for (column, head) in heads.into_iter().enumerate() {
        write(0, column, head, bold, INK);
    }
    for (i, verdict) in lines.iter().enumerate() {
        let row = i as i64 + 1;
        let colour = match verdict.met() {
            Some(true) => GOOD,
            Some(false) => BAD,
            None => INK,
        };
        write(row, 0, &verdict.name.replace('_', " "), face, INK);
        let unit = verdict.unit.symbol();
        write(row, 1, if unit == "1" { "" } else { unit }, face, INK);
        let numbers =
            [verdict.terrain, verdict.exemplar, verdict.value, verdict.halves, verdict.judged, verdict.bar];
        for (column, number) in numbers.into_iter().enumerate() {
            write(row, column + 2, &figure(number), face, if column == 4 { colour } else { INK });
        }
        write(row, 8, word(verdict.met()), bold, colour);
    }
}

/// A number in three or four figures; nothing for NaN.
fn figure(number: f64) -> String {
    match number.abs() {
        size if size.is_nan() => String::new(),
        size if size >= 100.0 => format!("{number:.0}"),
        size if size >= 10.0 => format!("{number:.1}"),
        size if size >= 1.0 => format!("{number:.2}"),
        size if size >= 0.001 || size == 0.0 => format!("{number:.4}"),
        _ => format!("{number:.1e}"),
    }
}
