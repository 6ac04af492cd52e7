//! Charts: lines, dots and areas over two axes with ticks, units and a legend.

use glam::DVec2;
use orograph_core::prelude::*;

use super::{
    canvas::{Anchor, Canvas, Type},
    colour::{INK, PAPER, Tint},
    ticks::{self, Tick},
};

/// Colours of series: apart from each other for the colour-blind too.
pub const SERIES: [Tint; 7] = [
    [0, 100, 170, 255],
    [205, 90, 20, 255],
    [20, 140, 100, 255],
    [190, 105, 160, 255],
    [220, 155, 20, 255],
    [70, 70, 75, 255],
    [80, 170, 215, 255],
];
const GRID: Tint = [228, 230, 233, 255];
const FINE_GRID: Tint = [242, 243, 245, 255];

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// A line through the points.
    Line,
    /// A line through the points, which are marked.
    Marked,
    /// Marks alone.
    Dots,
    /// A line, and a tint between it and the lower end of the axis.
    Area,
}

/// Points to draw under one name.
#[derive(Clone, Debug)]
pub struct Series {
    /// Its name in the legend; none when empty.
    pub name: String,
    /// How it is drawn.
    pub style: Style,
    /// Its points in drawing order; one that is not finite interrupts the line.
    pub points: Vec<DVec2>,
}

/// What one axis shows.
#[derive(Clone, Debug, Default)]
pub struct Axis {
    /// Quantity and unit.
    pub label: String,
    /// Logarithmic: values that are not positive are left out.
    pub log: bool,
    /// The axis reaches down to zero.
    pub from_zero: bool,
    /// No margin beyond the least and greatest value.
    pub tight: bool,
}

/// A chart to be drawn.
#[derive(Clone, Debug)]
pub struct Chart {
    /// Above everything; none when empty.
    pub title: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// What is shown.
    pub series: Vec<Series>,
    /// Width of the picture in pixels.
    pub width: u32,
    /// Height of the picture in pixels.
    pub height: u32,
}

/// An axis with its range: values to shares of its length.
struct Scale {
    low: f64,
    high: f64,
    log: bool,
}

impl Scale {
    fn new(axis: &Axis, values: impl Iterator<Item = f64>) -> Self {
        let usable = values.filter(|value| value.is_finite() && (!axis.log || *value > 0.0));
        let on_axis = |value: f64| if axis.log { libm::log10(value) } else { value };
        let (mut low, mut high) = usable
            .map(on_axis)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
        if low > high {
            (low, high) = (0.0, 1.0);
        }
        if axis.from_zero && !axis.log {
            (low, high) = (low.min(0.0), high.max(0.0));
        }
        // A single value gets room around it; beyond the precision of the numbers, relative to them.
        let least = (low.abs().max(high.abs()) * 1e-6).max(1e-9);
        if high - low < least {
            let room = least.max(0.5);
            (low, high) = (low - room, high + room);
        }
        let margin = if axis.tight { 0.0 } else { 0.04 * (high - low) };
        let at_zero = axis.from_zero && !axis.log;
        low -= if at_zero && low == 0.0 { 0.0 } else { margin };
        high += if at_zero && high == 0.0 { 0.0 } else { margin };
        Self { low, high, log: axis.log }
    }

    fn share(&self, value: f64) -> f64 {
        let value = match self.log {
            true if value > 0.0 => libm::log10(value),
            true => f64::NAN,
            false => value,
        };
        // Halving first keeps the whole range of numbers apart.
        (value / 2.0 - self.low / 2.0) / (self.high / 2.0 - self.low / 2.0)
    }

    fn ticks(&self, count: f64) -> Vec<Tick> {
        if !self.log {
            return ticks::linear(self.low, self.high, count);
        }
        ticks::logarithmic(libm::pow(10.0, self.low), libm::pow(10.0, self.high))
    }
}

impl Chart {
    /// Draws the chart.
    ///
    /// # Errors
    /// [`Error::TooLarge`] when `job` does not admit the memory, [`Error::Cancelled`].
    pub fn draw(&self, job: &Job) -> Result<Texture> {
        let (width, height) = (i64::from(self.width), i64::from(self.height));
        let mut canvas = Canvas::new(width, height, PAPER, job)?;
        let points = || self.series.iter().flat_map(|series| &series.points);
        let x = Scale::new(&self.x, points().map(|point| point.x));
        let y = Scale::new(&self.y, points().map(|point| point.y));
        let s = self.scale();
        let (across, up) = (x.ticks((width / (100 * s)) as f64), y.ticks((height / (60 * s)) as f64));

        let widest = up.iter().map(|tick| self.plain().width(&tick.label)).max().unwrap_or(0);
        let left = 16 * s + widest + if self.y.label.is_empty() { 0 } else { 22 * s };
        let bottom = 30 * s + if self.x.label.is_empty() { 0 } else { 20 * s };
        let top = self.heading(&mut canvas, left, width - 20 * s);
        let frame = Frame { left, top, width: width - left - 20 * s, height: height - top - bottom };
        if frame.width < 8 || frame.height < 8 {
            return Ok(canvas.into_picture());
        }

        for tick in &across {
            let at = frame.x(x.share(tick.value));
            canvas.fill(
                at - s / 2,
                top,
                s,
                frame.height,
                if tick.label.is_empty() { FINE_GRID } else { GRID },
            );
        }
        for tick in &up {
            let at = frame.y(y.share(tick.value));
            canvas.fill(
                left,
                at - s / 2,
                frame.width,
                s,
                if tick.label.is_empty() { FINE_GRID } else { GRID },
            );
        }
        for (i, series) in self.series.iter().enumerate() {
            job.check()?;
            let places: Vec<_> =
                series.points.iter().map(|point| frame.place(x.share(point.x), y.share(point.y))).collect();
            let pen = Pen { style: series.style, colour: SERIES[i % SERIES.len()], scale: s as f64 };
            draw_series(&mut canvas, pen, &places, &frame, job)?;
        }
        self.axes(&mut canvas, &frame, (&x, &across), (&y, &up));
        Ok(canvas.into_picture())
    }

    /// Whole enlargement of text, lines and margins: large pictures are looked at from further away.
    fn scale(&self) -> i64 {
        i64::from((self.width / 700).min(self.height / 400)).clamp(1, 8)
    }

    fn plain(&self) -> Type {
        Type::plain(self.scale() as u32)
    }

    /// Title and legend; returns where the frame may begin.
    fn heading(&self, canvas: &mut Canvas, left: i64, right: i64) -> i64 {
        let (s, plain) = (self.scale(), self.plain());
        let bold = Type::bold(plain.scale);
        let mut top = 14 * s;
        if !self.title.is_empty() {
            let title = bold.fit(&self.title, right - left);
            canvas.text(title, left, top + 4 * s, Anchor::Left, bold, INK);
            top += 24 * s;
        }
        let named: Vec<_> =
            self.series.iter().enumerate().filter(|(_, series)| !series.name.is_empty()).collect();
        let mut x = left;
        for (i, series) in &named {
            let name = plain.fit(&series.name, right - left - 30 * s);
            let wide = 30 * s + plain.width(name);
            if x > left && x + wide > right {
                (x, top) = (left, top + 17 * s);
            }
            let pen = Pen { style: series.style, colour: SERIES[i % SERIES.len()], scale: s as f64 };
            let start = DVec2::new((x + s) as f64, top as f64);
            let end = start + DVec2::X * 20.0 * pen.scale;
            pen.stroke(canvas, start, end);
            pen.mark(canvas, start.midpoint(end));
            canvas.text(name, x + 28 * s, top, Anchor::Left, plain, INK);
            x += wide + 18 * s;
        }
        if named.is_empty() { top } else { top + 17 * s }
    }

    fn axes(&self, canvas: &mut Canvas, frame: &Frame, across: (&Scale, &[Tick]), up: (&Scale, &[Tick])) {
        let (s, plain) = (self.scale(), self.plain());
        let (left, top) = (frame.left, frame.top);
        let (right, bottom) = (left + frame.width, top + frame.height);
        for i in 1..=s {
            canvas.frame(left - i, top - i, frame.width + 2 * i, frame.height + 2 * i, INK);
        }
        let long = |tick: &Tick| if tick.label.is_empty() { 3 * s } else { 5 * s };
        // Neighbouring labels never touch.
        let mut free = i64::MIN;
        for tick in across.1 {
            let at = frame.x(across.0.share(tick.value));
            let half = plain.width(&tick.label) / 2;
            canvas.fill(at - s / 2, bottom + s, s, long(tick), INK);
            if at - half > free && !tick.label.is_empty() {
                canvas.text(&tick.label, at, bottom + 15 * s, Anchor::Middle, plain, INK);
                free = at + half + 6 * s;
            }
        }
        let mut free = i64::MAX;
        for tick in up.1 {
            let at = frame.y(up.0.share(tick.value));
            canvas.fill(left - s - long(tick), at - s / 2, long(tick), s, INK);
            if at + plain.height() / 2 <= free {
                canvas.text(&tick.label, left - 9 * s, at, Anchor::Right, plain, INK);
                free = if tick.label.is_empty() { free } else { at - plain.height() / 2 };
            }
        }
        let label = plain.fit(&self.x.label, frame.width);
        canvas.text(label, (left + right) / 2, bottom + 35 * s, Anchor::Middle, plain, INK);
        let label = plain.fit(&self.y.label, frame.height);
        canvas.text_upwards(label, 14 * s, (top + bottom) / 2, plain, INK);
    }
}

/// The rectangle that the axes enclose.
struct Frame {
    left: i64,
    top: i64,
    width: i64,
    height: i64,
}

impl Frame {
    fn place(&self, x: f64, y: f64) -> DVec2 {
        DVec2::new(
            self.left as f64 + x * (self.width - 1) as f64,
            self.top as f64 + (1.0 - y) * (self.height - 1) as f64,
        )
    }

    fn x(&self, share: f64) -> i64 {
        self.place(share, 0.0).x.round() as i64
    }

    fn y(&self, share: f64) -> i64 {
        self.place(0.0, share).y.round() as i64
    }
}

/// How one series is drawn.
#[derive(Clone, Copy)]
struct Pen {
    style: Style,
    colour: Tint,
    scale: f64,
}

impl Pen {
    fn stroke(self, canvas: &mut Canvas, from: DVec2, to: DVec2) {
        if self.style != Style::Dots {
            canvas.line(from, to, 1.6 * self.scale, self.colour);
        }
    }

    fn mark(self, canvas: &mut Canvas, at: DVec2) {
        if matches!(self.style, Style::Dots | Style::Marked) && at.is_finite() {
            canvas.disc(at, 3.2 * self.scale, self.colour);
        }
    }
}

fn draw_series(canvas: &mut Canvas, pen: Pen, places: &[DVec2], frame: &Frame, job: &Job) -> Result<()> {
    if pen.style == Style::Area {
        let [r, g, b, _] = pen.colour;
        let floor = frame.top + frame.height;
        for pair in places.windows(2).filter(|pair| pair[0].is_finite() && pair[1].is_finite()) {
            job.check()?;
            for x in pair[0].x.ceil() as i64..pair[1].x.ceil() as i64 {
                let t = (x as f64 - pair[0].x) / (pair[1].x - pair[0].x);
                let y = (pair[0].y + (pair[1].y - pair[0].y) * t).round() as i64;
                canvas.fill(x, y, 1, floor - y, [r, g, b, 46]);
            }
        }
    }
    for pair in places.windows(2) {
        job.check()?;
        pen.stroke(canvas, pair[0], pair[1]);
    }
    for &place in places {
        job.check()?;
        pen.mark(canvas, place);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(points: Vec<DVec2>, log: bool) -> Chart {
        let axis = Axis { label: "x".into(), log, ..Axis::default() };
        Chart {
            title: "title".into(),
            x: axis.clone(),
            y: axis,
            series: vec![Series { name: "a".into(), style: Style::Dots, points }],
            width: 300,
            height: 200,
        }
    }

    #[test]
    fn any_numbers_can_be_drawn() {
        let extremes = [f64::NAN, f64::INFINITY, -0.0, 1e300, -1e300, f64::MIN_POSITIVE];
        for a in extremes {
            for b in extremes {
                for log in [false, true] {
                    let mut chart = chart(vec![DVec2::new(a, b), DVec2::new(b, 1.0), DVec2::ONE], log);
                    for style in [Style::Area, Style::Marked] {
                        chart.series[0].style = style;
                        chart.draw(&Job::detached()).unwrap();
                    }
                }
            }
        }
        assert!(chart(Vec::new(), false).draw(&Job::detached()).is_ok());
        assert!(Chart { width: 1, height: 1, ..chart(Vec::new(), true) }.draw(&Job::detached()).is_ok());
    }

    #[test]
    fn places_follow_the_axis() {
        let axis = Axis { log: true, tight: true, ..Axis::default() };
        let scale = Scale::new(&axis, [1.0, 100.0, -5.0, f64::NAN].into_iter());
        assert!((scale.share(10.0) - 0.5).abs() < 1e-12);
        assert!(scale.share(-1.0).is_nan());
        let zero = Axis { from_zero: true, ..Axis::default() };
        assert_eq!(Scale::new(&zero, [5.0, 10.0].into_iter()).low, 0.0);
    }
}
