//! A colour bar with numbers beside a picture.

use orograph_core::prelude::*;

use super::{
    canvas::{Anchor, Canvas, Type},
    colour::{INK, PAPER, tint},
    ticks,
};

/// What a colour bar says.
#[derive(Clone, Debug)]
pub struct Legend<'a> {
    /// Colours from the bottom up.
    pub colours: Gradient,
    /// The value at the bottom.
    pub low: f64,
    /// The value at the top.
    pub high: f64,
    /// The unit, above the bar.
    pub unit: &'a str,
}

/// The picture with a legend to its right. The picture's own pixels keep their place in the world.
///
/// # Errors
/// [`Error::TooLarge`] when `job` does not admit the memory.
pub fn with_legend(picture: &Texture, legend: &Legend<'_>, job: &Job) -> Result<Texture> {
    let grid = picture.grid();
    let scale = (grid.rows / 500).clamp(1, 8) as u32;
    let face = Type::plain(scale);
    let s = i64::from(scale);
    let height = grid.rows.max(120) as i64;
    let (margin, head) = (12 * s, 30 * s);
    let long = (height - head - margin).min(360 * s).max(1);
    let ticks = ticks::linear(legend.low, legend.high, (long / (40 * s)).max(2) as f64);
    let signed = legend.low < 0.0 && legend.high > 0.0;
    let text = |tick: &ticks::Tick| {
        if signed && tick.value > 0.0 { format!("+{}", tick.label) } else { tick.label.clone() }
    };
    let widest = ticks.iter().map(|tick| face.width(&text(tick))).max().unwrap_or(0);
    let bar = 18 * s;
    let wide = margin + bar + 10 * s + widest.max(face.width(legend.unit) - bar) + margin;

    let whole = Grid {
        rows: grid.rows.max(120),
        cols: grid.cols + usize::try_from(wide).unwrap_or(0),
        ..grid.clone()
    };
    let mut canvas = Canvas::on(whole, PAPER, job)?;
    canvas.paste(picture, 0, 0);
    let left = grid.cols as i64 + margin;
    canvas.text(legend.unit, left, head / 2, Anchor::Left, face, INK);
    for i in 0..long {
        let share = 1.0 - (i as f64 + 0.5) / long as f64;
        canvas.fill(left, head + i, bar, 1, tint(&legend.colours, share));
    }
    canvas.frame(left - 1, head - 1, bar + 2, long + 2, INK);
    for tick in &ticks {
        let share = (tick.value - legend.low) / (legend.high - legend.low);
        let y = head + ((1.0 - share) * (long - 1) as f64).round() as i64;
        canvas.fill(left + bar + 1, y, 4 * s, s, INK);
        canvas.text(&text(tick), left + bar + 8 * s, y, Anchor::Left, face, INK);
    }
    Ok(canvas.into_picture())
}

#[cfg(test)]
mod tests {
    use super::{super::colour::Palette, *};

    #[test]
    fn the_picture_stays_where_it_was() {
        let job = Job::detached();
        for (rows, cols) in [(0, 0), (3, 4), (200, 150)] {
            let mut grid = Grid::new(rows, cols, CellSize { x: 3.0, y: 2.0 }).unwrap();
            grid.row0 = 7;
            let picture = Texture::filled(grid, [1, 2, 3, 255], &job).unwrap();
            let legend = Legend { colours: Palette::Grey.gradient(), low: -2.0, high: 5.0, unit: "m" };
            let out = with_legend(&picture, &legend, &job).unwrap();
            assert_eq!(out.crop(0, 0, rows, cols, &job).unwrap().cells(), picture.cells());
            assert_eq!(out.grid().position(0, 0), picture.grid().position(0, 0));
            assert!(out.cols() > cols + 40);
        }
    }
}
