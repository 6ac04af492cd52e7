//! From map units to metres on the ground.
//!
//! Degrees become metres on the WGS 84 ellipsoid at the grid's centre, and Web Mercator is scaled by the
//! cosine of the latitude there; everything else is a length. One cell size holds for the whole grid, as
//! `CellSize` means it.

use orograph_core::prelude::*;

/// Half the long axis of WGS 84, in metres.
const RADIUS: f64 = 6_378_137.0;
/// Its first eccentricity squared.
const ECCENTRICITY2: f64 = 0.006_694_379_990_141_316;

/// What one unit of a transform measures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum MapUnit {
    /// So many metres.
    Metres(f64),
    /// So many degrees of longitude and latitude.
    Degrees(f64),
    /// A metre on the equator of the spherical Mercator projection.
    WebMercator,
}

/// Metres of one degree of longitude and of latitude at a latitude in degrees, on WGS 84.
#[must_use]
pub fn metres_per_degree(latitude: f64) -> (f64, f64) {
    let radians = latitude.clamp(-89.999, 89.999).to_radians();
    let (sin, cos) = libm::sincos(radians);
    let bend = 1.0 - ECCENTRICITY2 * sin * sin;
    let normal = RADIUS / bend.sqrt();
    let meridian = normal * (1.0 - ECCENTRICITY2) / bend;
    ((normal * cos).to_radians(), meridian.to_radians())
}

/// The size in metres of the cells that `transform` places on `rows` × `cols`.
///
/// # Errors
/// [`Error::Format`] when the transform gives cells no area.
pub(crate) fn cell_size(
    transform: &[f64; 6],
    (rows, cols): (usize, usize),
    unit: MapUnit,
    name: &str,
) -> Result<CellSize> {
    let [_, xc, xr, y0, yc, yr] = *transform;
    let middle = y0 + yc * cols as f64 / 2.0 + yr * rows as f64 / 2.0;
    let (metres_x, metres_y) = match unit {
        MapUnit::Metres(metres) => (metres, metres),
        MapUnit::Degrees(degrees) => {
            let (x, y) = metres_per_degree(middle * degrees);
            (x * degrees, y * degrees)
        }
        MapUnit::WebMercator => {
            let scale = 1.0 / libm::cosh(middle / RADIUS);
            (scale, scale)
        }
    };
    let length = |x: f64, y: f64| libm::hypot(x * metres_x, y * metres_y);
    let (x, mut y) = (length(xc, yc), length(xr, yr));
    if !(x.is_finite() && y.is_finite() && x > 0.0 && y > 0.0) {
        return Err(Error::format(name, "its georeference gives cells no area"));
    }
    // Many a writer gets the last digits of one side wrong; such cells are square.
    if (x / y - 1.0).abs() < 1e-9 {
        y = x;
    }
    Ok(CellSize { x, y })
}

/// Whether a georeference is in degrees of longitude and latitude by its coordinate system's number: WGS 84 or NAD 83.
pub(crate) fn is_in_degrees(georef: &Georef) -> bool {
    matches!(georef.crs.as_str(), "EPSG:4326" | "EPSG:4269")
}

/// The size in metres of the cells of a grid, by where it lies alone: the same bits for the same ground, whatever larger grid
/// it was cut from.
pub(crate) fn own_cell_size(grid: &Grid) -> CellSize {
    /// Of a degree: a tenth of a metre, far above the rounding of transforms.
    const FINEST: f64 = 1e6;
    let Some(georef) = grid.georef_here().filter(is_in_degrees) else { return grid.cell };
    let [_, xc, _, y0, _, yr] = georef.transform;
    let middle = ((y0 + yr * grid.rows as f64 / 2.0) * FINEST).round() / FINEST;
    let transform = [0.0, xc, 0.0, middle - yr * grid.rows as f64 / 2.0, 0.0, yr];
    cell_size(&transform, grid.size(), MapUnit::Degrees(1.0), "").unwrap_or(grid.cell)
}

/// Whether a transform without coordinate system can only mean degrees: it stays on the globe, and its cells
/// would be smaller than 2 cm otherwise.
pub(crate) fn looks_like_degrees(transform: &[f64; 6], (rows, cols): (usize, usize)) -> bool {
    let [_, xc, _, _, _, yr] = *transform;
    xc.abs() < 0.02 && yr.abs() < 0.02 && lies_on_globe(transform, (rows, cols))
}

/// Whether every corner lies within ±360° and ±90°, but for half a cell.
pub(crate) fn lies_on_globe(transform: &[f64; 6], (rows, cols): (usize, usize)) -> bool {
    let [x0, xc, xr, y0, yc, yr] = *transform;
    let (rows, cols) = (rows as f64, cols as f64);
    [(0.0, 0.0), (rows, 0.0), (0.0, cols), (rows, cols)].iter().all(|&(row, col)| {
        let (x, y) = (x0 + xc * col + xr * row, y0 + yc * col + yr * row);
        x.abs() <= 360.0 + xc.abs() && y.abs() <= 90.0 + yr.abs()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_degree_measures_what_geodesy_says() {
        // Snyder, Map Projections, table 1 and the WGS 84 defining report: lengths of one degree.
        for (latitude, x, y) in
            [(0.0, 111_319.49, 110_574.28), (45.0, 78_846.8, 111_131.8), (60.0, 55_800.0, 111_412.3)]
        {
            let (found_x, found_y) = metres_per_degree(latitude);
            assert!(
                (found_x - x).abs() < 1.0 && (found_y - y).abs() < 1.0,
                "{latitude}: {found_x} {found_y}"
            );
        }
    }

    #[test]
    fn web_mercator_shrinks_with_the_cosine_of_the_latitude() {
        // Latitude 60° lies at y = R·asinh(tan 60°), where a map metre is half a metre.
        let y = RADIUS * libm::asinh(libm::tan(60_f64.to_radians()));
        let cell = cell_size(&[0.0, 10.0, 0.0, y, 0.0, -10.0], (0, 0), MapUnit::WebMercator, "x").unwrap();
        assert!((cell.x - 5.0).abs() < 1e-9 && cell.x == cell.y);
    }

    #[test]
    fn a_transform_without_area_is_refused() {
        for transform in
            [[0.0; 6], [0.0, f64::NAN, 0.0, 0.0, 0.0, -1.0], [0.0, f64::INFINITY, 0.0, 0.0, 0.0, 1.0]]
        {
            assert!(cell_size(&transform, (2, 2), MapUnit::Metres(1.0), "x").is_err());
        }
    }
}
