//! Read points: scattered heights from a table as text.

use orograph_core::prelude::*;

use super::file;

/// What the coordinates in the table mean.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum PointCoordinates {
    /// Metres in the world of the graph: x east, y north.
    World,
    /// Coordinates of the reference system of `like`, such as UTM metres or degrees.
    Map,
}

/// Reads points with heights from a CSV file, such as spot heights or a GPS track.
///
/// Columns are separated by commas, semicolons or tabs. With a line of names, columns are found by them (x, easting,
/// lon or longitude; y, northing, lat or latitude; z, height, h, elevation, elev or alt), else they are x, y and height.
/// Lines that begin with # are passed over.
#[derive(Params, Clone, Debug)]
pub struct ReadPoints {
    /// The file to read.
    #[param(default = "")]
    pub file: InputPath,
    /// What the coordinates mean.
    #[param(default = PointCoordinates::World)]
    pub coordinates: PointCoordinates,
}

/// Inputs of [`ReadPoints`].
#[derive(Inputs)]
pub struct ReadPointsIn<'a> {
    /// Terrain whose reference system the coordinates are of.
    pub like: Option<&'a Heightfield>,
}

/// Outputs of [`ReadPoints`].
#[derive(Outputs)]
pub struct ReadPointsOut {
    /// The points, in the order of the file.
    pub points: Points,
}

impl Node for ReadPoints {
    const ID: &'static str = "io.read_points";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = ReadPointsIn<'a>;
    type Outputs = ReadPointsOut;

    fn run(&self, inputs: ReadPointsIn<'_>, job: &Job) -> Result<ReadPointsOut> {
        let (bytes, name) = file::load(&self.file, job)?;
        let points = read(&bytes, &name, job)?;
        match self.coordinates {
            PointCoordinates::World => Ok(ReadPointsOut { points }),
            PointCoordinates::Map => Ok(ReadPointsOut { points: placed(&points, inputs.like)? }),
        }
    }
}

/// Names by which each column goes.
const NAMES: [&[&str]; 3] = [
    &["x", "easting", "east", "lon", "longitude"],
    &["y", "northing", "north", "lat", "latitude"],
    &["z", "height", "h", "elevation", "elev", "alt", "altitude"],
];

/// The points in a table as text, coordinates as they are.
///
/// # Errors
/// [`Error::Format`] for columns that are missing and text that is no finite number; [`Error::TooLarge`];
/// [`Error::Cancelled`].
pub fn read(bytes: &[u8], name: &str, job: &Job) -> Result<Points> {
    let fail = |reason: String| Error::format(name, reason);
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let told = |line: &&[u8]| !line.trim_ascii().is_empty() && !line.starts_with(b"#");
    let first = bytes.split(|&byte| byte == b'\n').find(told).unwrap_or_default();
    let separator = [b';', b'\t', b','].into_iter().find(|byte| first.contains(byte)).unwrap_or(b',');
    let mut table = csv::ReaderBuilder::new()
        .delimiter(separator)
        .comment(Some(b'#'))
        .has_headers(false)
        .flexible(true)
        .trim(csv::Trim::All)
        .from_reader(bytes);
    let mut columns = [0, 1, 2];
    let mut points = [Vec::new(), Vec::new(), Vec::new()];
    for (i, record) in table.byte_records().enumerate() {
        if i.is_multiple_of(1 << 12) {
            job.check()?;
            job.admit(i as u64 * 3 * 8, || format!("the points in {name}"))?;
        }
        let record = record.map_err(|error| fail(error.to_string()))?;
        let text =
            |column: usize| String::from_utf8_lossy(record.get(column).unwrap_or_default()).into_owned();
        let is_names =
            i == 0 && (0..record.len()).any(|k| text(k).parse::<f64>().is_err() && !text(k).is_empty());
        if is_names {
            for (column, names) in columns.iter_mut().zip(NAMES) {
                let named = |k: &usize| names.contains(&text(*k).to_ascii_lowercase().as_str());
                let found = (0..record.len()).find(named);
                *column = found.ok_or_else(|| fail(format!("no column is named {}", names.join(" or "))))?;
            }
            continue;
        }
        for (column, values) in columns.into_iter().zip(&mut points) {
            let value = text(column).parse::<f64>().ok().filter(|value| value.is_finite());
            values.push(value.ok_or_else(|| {
                let line = record.position().map_or(0, csv::Position::line);
                fail(format!("line {line}, column {}: `{}` is no number", column + 1, text(column)))
            })?);
        }
    }
    let [x, y, heights] = points;
    Points::new(x, y, heights)
}

/// Points in the world of a graph from points in the reference system of a terrain.
fn placed(points: &Points, like: Option<&Heightfield>) -> Result<Points> {
    let refuse = |what: &str| {
        Err(Error::invalid(
            format!("the points' coordinates are of a map, but {what}"),
            "connect the terrain that lies in it, or set `coordinates` to `world`",
        ))
    };
    let Some(like) = like else { return refuse("`like` is not connected") };
    let Some(georef) = like.grid().georef_here() else { return refuse("`like` has no reference system") };
    let [x0, xc, xr, y0, yc, yr] = georef.transform;
    let area = xc * yr - xr * yc;
    if area == 0.0 || !area.is_finite() {
        return refuse("the cells of `like` have no area in its reference system");
    }
    let (mut x, mut y, mut heights) = (Vec::new(), Vec::new(), Vec::new());
    for (east, north, height) in points.iter() {
        let (east, north) = (east - x0, north - y0);
        // The transform is of cells' corners, and centres lie half a cell further.
        let col = (east * yr - north * xr) / area - 0.5;
        let row = (north * xc - east * yc) / area - 0.5;
        let first = like.grid().position(0, 0);
        x.push(first.x + col * like.grid().cell.x);
        y.push(first.y - row * like.grid().cell.y);
        heights.push(height);
    }
    Points::new(x, y, heights)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::test_fields::field;

    fn points(text: &str) -> Result<Vec<(f64, f64, f64)>> {
        Ok(read(text.as_bytes(), "points.csv", &Job::detached())?.iter().collect())
    }

    #[test]
    fn columns_are_found_by_name_or_in_their_order() {
        let expected = vec![(1.0, -2.5, 300.0), (4e3, 5.0, -6.0)];
        for text in [
            "1,-2.5,300\n4e3,5,-6\n",
            "# spot heights\r\nname;Z;Y;X\r\n\"a; b\";300;-2.5;1\r\nb;-6;5;4000\r\n",
            "\u{feff}lon\tlat\televation\n 1\t-2.5\t300\n4000\t5\t-6",
        ] {
            assert_eq!(points(text).unwrap(), expected, "{text}");
        }
        assert!(points("").unwrap().is_empty());
    }

    #[test]
    fn what_is_no_table_of_points_is_refused_by_line() {
        for (text, said) in [
            ("x,y\n1,2", "no column is named z"),
            ("x,y,z\n1,2,3\n1,2,up", "line 3, column 3"),
            ("1,2,3\n1,2", "line 2, column 3"),
            ("1,2,inf", "line 1, column 3"),
        ] {
            let error = points(text).unwrap_err().to_string();
            assert!(error.contains(said), "{error}");
        }
    }

    #[test]
    fn map_coordinates_are_placed_by_the_terrain() {
        let terrain = field(10, 20, |_, _| 0.0);
        let mut grid = terrain.grid().clone();
        let transform = [600_000.0, 10.0, 1.0, 5_000_000.0, 2.0, -10.0];
        grid.georef = Some(Arc::new(Georef { transform, crs: "EPSG:32632".into() }));
        let part = terrain.with_grid(grid).unwrap().crop(3, 2, 5, 9, &Job::detached()).unwrap();
        // The centre of the part's cell (1, 4).
        let (col, row) = (6.5, 4.5);
        let (x, y) = (600_000.0 + 10.0 * col + row, 5_000_000.0 + 2.0 * col - 10.0 * row);
        let points = Points::new(vec![x], vec![y], vec![7.0]).unwrap();
        let placed = placed(&points, Some(&part)).unwrap();
        let (x, y, _) = placed.iter().next().unwrap();
        let expected = part.grid().position(1, 4);
        assert!((x - expected.x).abs() < 1e-6 && (y - expected.y).abs() < 1e-6);
        assert!(super::placed(&points, None).is_err());
        assert!(super::placed(&points, Some(&field(2, 2, |_, _| 0.0))).is_err());
    }
}
