//! Contact sheet: pictures side by side, brought to one size, with labels.

use orograph_core::prelude::*;

use super::{
    canvas::{Anchor, Canvas, Type},
    colour::{INK, PAPER, Tint, byte},
};
use crate::measure::append::split_list;

const HAIRLINE: Tint = [196, 200, 206, 255];
/// Widest sheet whose labels have the font's own size. Pages show sheets 700 pixels wide or wider, and there the letters of
/// any sheet are then at least 11 pixels high.
const PAGE: i64 = 820;

/// Arranges pictures in rows and columns with labels beneath.
///
/// Each picture is scaled by area to fit its place, with its proportions kept. Labels are the larger the wider the sheet is,
/// so that they can be read when it is shown small; long ones take several lines. The sheet has no place in the world.
#[derive(Params, Clone, Debug)]
pub struct ContactSheet {
    /// Labels of the pictures, in order, separated by `;` or line ends.
    #[param(default = "")]
    pub labels: String,
    /// Heading of the sheet; none when empty.
    #[param(default = "")]
    pub title: String,
    /// Pictures in a row; 0 chooses a nearly square sheet.
    #[param(default = 0u32, range = 0..=64, slider = 0..=8, unit = "1")]
    pub columns: u32,
    /// Longer side of the place of a picture.
    #[param(default = 384u32, range = 16..=4096, slider = 128..=1024, unit = "px")]
    pub size: u32,
    /// Space between pictures.
    #[param(default = 12u32, range = 0..=256, slider = 0..=48, unit = "px")]
    pub spacing: u32,
}

/// Inputs of [`ContactSheet`].
#[derive(Inputs)]
pub struct ContactSheetIn<'a> {
    /// Pictures, row by row.
    pub pictures: Vec<&'a Texture>,
}

/// Outputs of [`ContactSheet`].
#[derive(Outputs)]
pub struct ContactSheetOut {
    /// The sheet.
    pub picture: Texture,
}

impl Node for ContactSheet {
    const ID: &'static str = "look.contact_sheet";
    const VERSION: u32 = 2; // 2 sizes labels by the sheet, and breaks long ones
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = ContactSheetIn<'a>;
    type Outputs = ContactSheetOut;

    fn run(&self, inputs: ContactSheetIn<'_>, job: &Job) -> Result<ContactSheetOut> {
        let pictures: Vec<_> =
            inputs.pictures.into_iter().filter(|picture| !picture.grid().is_empty()).collect();
        if pictures.is_empty() {
            return Err(Error::EmptyInput { what: "pictures".into() });
        }
        let labels = split_list(&self.labels);
        let count = pictures.len() as i64;
        let columns = match i64::from(self.columns) {
            0 => (count as f64).sqrt().ceil() as i64,
            columns => columns.min(count),
        };
        let rows = (count + columns - 1) / columns;
        let sizes: Vec<_> = pictures.iter().map(|picture| self.scaled_size(picture)).collect();
        let place = sizes.iter().fold((1, 1), |most, size| (most.0.max(size.0), most.1.max(size.1)));

        let gap = i64::from(self.spacing);
        let wide = place.0 as i64 + gap;
        let width = gap + columns * wide;
        let s = (width + PAGE - 1) / PAGE;
        let (plain, bold) = (Type::plain(s as u32), Type::bold(s as u32));
        let labels: Vec<_> =
            labels.iter().take(pictures.len()).map(|label| lines_of(label, plain, place.0 as i64)).collect();
        let caption = match labels.iter().map(Vec::len).max() {
            Some(lines) => lines as i64 * plain.height() + 8 * s,
            None => 0,
        };
        let head = if self.title.is_empty() { 0 } else { bold.height() + 12 * s };
        let high = place.1 as i64 + caption + gap;
        let mut canvas = Canvas::new(width, gap + head + rows * high, PAPER, job)?;
        canvas.text(&self.title, gap, gap + bold.height() / 2, Anchor::Left, bold, INK);
        for (i, (picture, size)) in pictures.iter().zip(sizes).enumerate() {
            job.check()?;
            let (col, row) = (i as i64 % columns, i as i64 / columns);
            let (left, top) = (gap + col * wide, gap + head + row * high);
            let x = left + (place.0 as i64 - size.0 as i64) / 2;
            let y = top + (place.1 as i64 - size.1 as i64) / 2;
            canvas.paste(&scaled(picture, size, job)?, x, y);
            canvas.frame(x - 1, y - 1, size.0 as i64 + 2, size.1 as i64 + 2, HAIRLINE);
            let middle = left + place.0 as i64 / 2;
            let below = top + place.1 as i64 + 4 * s + plain.height() / 2;
            for (line, text) in labels.get(i).into_iter().flatten().enumerate() {
                canvas.text(text, middle, below + line as i64 * plain.height(), Anchor::Middle, plain, INK);
            }
        }
        Ok(ContactSheetOut { picture: canvas.into_picture() })
    }
}

impl ContactSheet {
    /// Width and height of a picture when its longer side is the place's.
    fn scaled_size(&self, picture: &Texture) -> (usize, usize) {
        let (rows, cols) = picture.grid().size();
        let scale = f64::from(self.size) / rows.max(cols) as f64;
        let side = |pixels: usize| ((pixels as f64 * scale).round() as usize).max(1);
        (side(cols), side(rows))
    }
}

/// A label in lines of at most `width` pixels, broken between words, and within a word that is longer than a line.
fn lines_of(label: &str, face: Type, width: i64) -> Vec<&str> {
    let mut lines = Vec::new();
    let mut rest = label;
    loop {
        let line = face.fit(rest, width);
        if line.len() == rest.len() || line.is_empty() {
            lines.push(line);
            return lines;
        }
        // A space just behind the line ends a word, too.
        let words = rest.get(..=line.len()).unwrap_or(line);
        let end = words.rfind(' ').filter(|&end| end > 0).unwrap_or(line.len());
        let (line, more) = rest.split_at(end);
        lines.push(line.trim_end());
        rest = more.trim_start();
    }
}

/// The picture in another size: each new pixel is the mean of the old ones that it covers, weighted by area
/// and alpha.
pub(crate) fn scaled(picture: &Texture, (width, height): (usize, usize), job: &Job) -> Result<Texture> {
    let (rows, cols) = picture.grid().size();
    if (height, width) == (rows, cols) {
        return picture.crop(0, 0, rows, cols, job);
    }
    let across: Vec<_> = (0..width).map(|col| spread(col, width, cols)).collect();
    Texture::build(Grid::new(height, width, CellSize::square(1.0))?, job, |row, out| {
        let down = spread(row, height, rows);
        for (pixel, across) in out.iter_mut().zip(&across) {
            let (mut sum, mut alpha, mut area) = ([0.0; 3], 0.0, 0.0);
            for &(r, tall) in &down {
                for &(c, wide) in across {
                    let [red, green, blue, opacity] = picture.at(r, c).map(f64::from);
                    let weight = tall * wide;
                    area += weight;
                    alpha += weight * opacity;
                    for (sum, part) in sum.iter_mut().zip([red, green, blue]) {
                        *sum += weight * opacity * part;
                    }
                }
            }
            let [red, green, blue] = sum.map(|sum| if alpha > 0.0 { byte(sum / alpha) } else { 0 });
            *pixel = [red, green, blue, byte(alpha / area)];
        }
        Ok(())
    })
}

/// The old cells that new cell `i` of `new` covers, with how much of each, when `old` cells become `new`.
fn spread(i: usize, new: usize, old: usize) -> Vec<(usize, f64)> {
    let ratio = old as f64 / new as f64;
    let (start, end) = (i as f64 * ratio, (i as f64 + 1.0) * ratio);
    let cells = (start as usize)..(end.ceil() as usize).min(old);
    let part = |cell: usize| (cell, (end.min(cell as f64 + 1.0) - start.max(cell as f64)).max(0.0));
    cells.map(part).filter(|(_, share)| *share > 1e-9).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(rows: usize, cols: usize, colour: Tint) -> Texture {
        Texture::filled(Grid::new(rows, cols, CellSize::square(1.0)).unwrap(), colour, &Job::detached())
            .unwrap()
    }

    #[test]
    fn scaling_keeps_means_and_shrinks_by_whole_blocks() {
        let job = Job::detached();
        let grid = Grid::new(4, 6, CellSize::square(1.0)).unwrap();
        let cells: Vec<Tint> = (0..24).map(|i| [i * 10, 255 - i * 10, 7, 255]).collect();
        let whole = Texture::new(grid, cells).unwrap();
        let half = scaled(&whole, (3, 2), &job).unwrap();
        let block = |r: usize, c: usize| {
            [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(dr, dc)| whole.at(2 * r + dr, 2 * c + dc))
        };
        for (r, c) in [(0, 0), (1, 2)] {
            let mean = block(r, c).iter().map(|pixel| f64::from(pixel[0])).sum::<f64>() / 4.0;
            assert_eq!(half.at(r, c)[0], byte(mean));
        }
        let large = scaled(&whole, (18, 12), &job).unwrap();
        assert_eq!(
            (large.at(0, 0), large.at(11, 17), large.at(4, 4)),
            (whole.at(0, 0), whole.at(3, 5), whole.at(1, 1))
        );
        let odd = scaled(&picture(7, 5, [10, 20, 30, 255]), (3, 4), &job).unwrap();
        assert!(odd.cells().iter().all(|&pixel| pixel == [10, 20, 30, 255]));
    }

    #[test]
    fn pictures_stand_in_rows_and_columns() {
        let (red, blue) = ([200, 0, 0, 255], [0, 0, 200, 255]);
        let (tall, square) = (picture(40, 20, red), picture(30, 30, blue));
        let node = ContactSheet { size: 40, spacing: 10, columns: 2, ..ContactSheet::default() };
        let sheet = node.run(ContactSheetIn { pictures: vec![&tall, &square, &tall] }, &Job::detached());
        let sheet = sheet.unwrap().picture;
        assert_eq!(sheet.grid().size(), (10 + 2 * 50, 10 + 2 * 50));
        assert_eq!((sheet.at(30, 30), sheet.at(30, 80), sheet.at(80, 30)), (red, blue, red));
        assert_eq!((sheet.at(80, 80), sheet.at(30, 15)), (PAPER, PAPER));
    }

    #[test]
    fn labels_grow_with_the_sheet() {
        let (job, white) = (Job::detached(), picture(30, 30, [255; 4]));
        for (size, columns) in [(100, 3), (400, 2), (400, 3), (512, 3), (512, 4), (1200, 1)] {
            let node = ContactSheet { size, columns, labels: "I".into(), ..ContactSheet::default() };
            let sheet = node.run(ContactSheetIn { pictures: vec![&white; columns as usize] }, &job);
            let sheet = sheet.unwrap().picture;
            let of_the_label = |row: &usize| sheet.row(*row).contains(&INK);
            let letter = (0..sheet.rows()).filter(of_the_label).count() as f64;
            // A capital has 9 of the font's 13 rows.
            let shown = letter * 13.0 / 9.0 * (700.0 / sheet.cols() as f64).min(1.0);
            assert!((11.0..=23.0).contains(&shown), "{shown} px for {columns} × {size}");
        }
    }

    #[test]
    fn long_labels_take_several_lines() {
        let face = Type::plain(1);
        let lines = |label, letters: i64| lines_of(label, face, 7 * letters);
        assert_eq!(lines("The seam removed", 16), ["The seam removed"]);
        assert_eq!(lines("The seam removed", 15), ["The seam", "removed"]);
        assert_eq!(lines("The seam removed", 8), ["The seam", "removed"]);
        assert_eq!(lines("The seam removed", 7), ["The", "seam", "removed"]);
        assert_eq!(lines("ridgelines", 4), ["ridg", "elin", "es"]);
        assert_eq!(lines("über Höhen", 5), ["über", "Höhen"]);
        assert_eq!((lines("", 4), lines("none", 0)), (vec![""], vec![""]));
    }

    #[test]
    fn no_picture_is_an_error() {
        let nothing = ContactSheet::default().run(ContactSheetIn { pictures: Vec::new() }, &Job::detached());
        assert!(matches!(nothing, Err(Error::EmptyInput { .. })));
    }
}
