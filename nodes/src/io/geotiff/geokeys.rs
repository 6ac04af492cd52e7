//! Georeference tags: the transform, the coordinate system's keys, and what both mean in metres.
//!
//! A system with an EPSG number travels as `EPSG:n`. One without travels as the text of its keys, from which
//! the keys are written again to the bit: `geokeys|1024:s1|2057:d6378137|1026:tname`, with `%7C` for a bar in a name.

use std::{collections::BTreeMap, fmt::Write};

use orograph_core::prelude::*;

use super::{
    feet::{self, FOOT, SURVEY_FOOT},
    ifd::Ifd,
    tag,
};
use crate::io::ground::{MapUnit, cell_size, lies_on_globe, looks_like_degrees};

const MODEL_TYPE: u16 = 1024;
const RASTER_TYPE: u16 = 1025;
const CITATION: u16 = 1026;
const GEOGRAPHIC_TYPE: u16 = 2048;
const ANGULAR_UNITS: u16 = 2054;
const ANGULAR_UNIT_SIZE: u16 = 2055;
const PROJECTED_TYPE: u16 = 3072;
const LINEAR_UNITS: u16 = 3076;
const LINEAR_UNIT_SIZE: u16 = 3077;
const VERTICAL_TYPE: u16 = 4096;
const VERTICAL_UNITS: u16 = 4099;

const PIXEL_IS_AREA: u16 = 1;
const PIXEL_IS_POINT: u16 = 2;
const USER_DEFINED: u16 = 32767;
const METRE: u16 = 9001;
const DEGREE: u16 = 9102;
/// Begins the text of a coordinate system that has no EPSG number.
const KEYS: &str = "geokeys";

/// The value of a key.
#[derive(Clone, Debug, PartialEq)]
enum KeyValue {
    Shorts(Vec<u16>),
    Doubles(Vec<f64>),
    Text(String),
}

/// The keys of a coordinate system.
#[derive(Clone, Debug, Default, PartialEq)]
struct Keys(BTreeMap<u16, KeyValue>);

/// Where a file's cells lie, and the length of its unit of height in metres.
pub(super) struct Placed {
    pub(super) grid: Grid,
    pub(super) height_unit: f64,
}

/// The grid of `size` (rows, columns) that the tags describe.
pub(super) fn place(ifd: &Ifd<'_>, name: &str, size: (usize, usize), job: &Job) -> Result<Placed> {
    let keys = Keys::of(ifd)?;
    let point = keys.short(RASTER_TYPE) == Some(PIXEL_IS_POINT);
    let height_unit = match keys.short(VERTICAL_UNITS) {
        None => 1.0,
        Some(unit) => metres_of(unit).unwrap_or_else(|| {
            job.warn(format!("{name}: unit of height {unit} is unknown and taken as metres"));
            1.0
        }),
    };
    let Some(transform) = transform(ifd, point)? else {
        job.warn(format!("{name} has no georeference: its cells are taken as 1 m wide"));
        return Ok(Placed { grid: Grid::new(size.0, size.1, CellSize::square(1.0))?, height_unit });
    };
    let unit = keys.map_unit().unwrap_or_else(|| {
        if looks_like_degrees(&transform, size) && keys.short(LINEAR_UNITS).is_none() {
            job.warn(format!("{name} names no coordinate system: its coordinates are taken as degrees"));
            MapUnit::Degrees(1.0)
        } else {
            MapUnit::Metres(1.0)
        }
    });
    let mut grid = Grid::new(size.0, size.1, cell_size(&transform, size, unit, name)?)?;
    grid.georef = Some(Georef { transform, crs: keys.crs(height_unit != 1.0) }.into());
    Ok(Placed { grid, height_unit })
}

/// The transform from cell corners, whichever way the file puts it.
fn transform(ifd: &Ifd<'_>, point: bool) -> Result<Option<[f64; 6]>> {
    let mut transform = if let Some(m) = ifd.doubles(tag::MODEL_TRANSFORMATION)?.filter(|m| m.len() >= 8) {
        [m[3], m[0], m[1], m[7], m[4], m[5]]
    } else {
        let scale = ifd.doubles(tag::MODEL_PIXEL_SCALE)?.filter(|scale| scale.len() >= 2);
        let tie = ifd.doubles(tag::MODEL_TIEPOINT)?.filter(|tie| tie.len() >= 6);
        let (Some(scale), Some(tie)) = (scale, tie) else { return Ok(None) };
        [tie[3] - tie[0] * scale[0], scale[0], 0.0, tie[4] + tie[1] * scale[1], 0.0, -scale[1]]
    };
    if point {
        // The tie is the centre of a cell, half a cell inwards of its corner.
        let [x0, xc, xr, y0, yc, yr] = transform;
        transform = [x0 - (xc + xr) / 2.0, xc, xr, y0 - (yc + yr) / 2.0, yc, yr];
    }
    Ok(Some(transform))
}

impl Keys {
    fn of(ifd: &Ifd<'_>) -> Result<Self> {
        let Some(directory) = ifd.integers(tag::GEO_KEY_DIRECTORY)? else { return Ok(Self::default()) };
        let doubles = ifd.doubles(tag::GEO_DOUBLE_PARAMS)?.unwrap_or_default();
        let texts = ifd.text(tag::GEO_ASCII_PARAMS)?.unwrap_or_default();
        let mut keys = BTreeMap::new();
        for entry in directory.get(4..).unwrap_or_default().chunks_exact(4) {
            let (key, place, count, start) =
                (entry[0] as u16, entry[1] as u16, entry[2] as usize, entry[3] as usize);
            let range = start..start.saturating_add(count);
            // A key that points outside is left out: georeference is no reason to refuse the heights.
            let value = match place {
                0 => Some(KeyValue::Shorts(vec![entry[3] as u16])),
                tag::GEO_KEY_DIRECTORY => directory
                    .get(range)
                    .map(|values| KeyValue::Shorts(values.iter().map(|&value| value as u16).collect())),
                tag::GEO_DOUBLE_PARAMS => doubles.get(range).map(|values| KeyValue::Doubles(values.to_vec())),
                tag::GEO_ASCII_PARAMS => {
                    // The last bar ends the text; GDAL parts what it says within one by bars too.
                    texts.get(range).map(|text| KeyValue::Text(text.strip_suffix('|').unwrap_or(text).into()))
                }
                _ => None,
            };
            keys.extend(value.map(|value| (key, value)));
        }
        Ok(Self(keys))
    }

    fn short(&self, key: u16) -> Option<u16> {
        match self.0.get(&key)? {
            KeyValue::Shorts(values) => values.first().copied(),
            _ => None,
        }
    }

    fn double(&self, key: u16) -> Option<f64> {
        match self.0.get(&key)? {
            KeyValue::Doubles(values) => values.first().copied(),
            _ => None,
        }
    }

    /// The system's EPSG number.
    fn epsg(&self) -> Option<u16> {
        let numbered = |key| self.short(key).filter(|&code| (1024..USER_DEFINED).contains(&code));
        match self.short(MODEL_TYPE) {
            Some(2 | 3) => numbered(GEOGRAPHIC_TYPE),
            // A projection of its own on a numbered datum has no number.
            _ if self.short(PROJECTED_TYPE).is_some() => numbered(PROJECTED_TYPE),
            None => numbered(GEOGRAPHIC_TYPE),
            Some(_) => None,
        }
    }

    fn map_unit(&self) -> Option<MapUnit> {
        let projected = self.short(PROJECTED_TYPE);
        // 3785 and 900913 are older numbers of 3857; Esri's 102100 does not fit a key.
        if matches!(projected, Some(3857 | 3785)) {
            return Some(MapUnit::WebMercator);
        }
        let geographic = self.short(MODEL_TYPE) == Some(2)
            || (self.short(MODEL_TYPE).is_none()
                && projected.is_none()
                && self.short(GEOGRAPHIC_TYPE).is_some());
        if geographic {
            let degrees = match self.short(ANGULAR_UNITS) {
                Some(9101) => 1_f64.to_degrees(),
                Some(9103) => 1.0 / 60.0,
                Some(9104) => 1.0 / 3600.0,
                Some(9105 | 9106) => 0.9,
                Some(USER_DEFINED) => self.double(ANGULAR_UNIT_SIZE).map_or(1.0, f64::to_degrees),
                _ => 1.0,
            };
            return Some(MapUnit::Degrees(degrees));
        }
        let metres = match self.short(LINEAR_UNITS) {
            Some(unit) => metres_of(unit).or(self.double(LINEAR_UNIT_SIZE)),
            None => projected.and_then(feet::of_system),
        };
        (self.short(MODEL_TYPE).is_some() || projected.is_some() || metres.is_some()).then(|| {
            MapUnit::Metres(metres.filter(|metres| metres.is_finite() && *metres > 0.0).unwrap_or(1.0))
        })
    }

    /// The system as text. Heights were turned into metres when `converted`, so its vertical part is dropped.
    fn crs(&self, converted: bool) -> String {
        let vertical = (!converted).then(|| self.short(VERTICAL_TYPE)).flatten();
        let vertical = vertical.filter(|&code| (1024..USER_DEFINED).contains(&code));
        match (self.epsg(), vertical) {
            (Some(code), None) => return format!("EPSG:{code}"),
            (Some(code), Some(vertical)) => return format!("EPSG:{code}+{vertical}"),
            _ => {}
        }
        if !self.0.contains_key(&MODEL_TYPE) && !self.0.contains_key(&PROJECTED_TYPE) {
            return String::new();
        }
        let mut text = KEYS.to_owned();
        for (key, value) in &self.0 {
            if *key == RASTER_TYPE || (converted && (VERTICAL_TYPE..=VERTICAL_UNITS).contains(key)) {
                continue;
            }
            // Writing to a string cannot fail.
            let _ = match value {
                KeyValue::Shorts(values) => write!(text, "|{key}:s{}", joined(values)),
                KeyValue::Doubles(values) => write!(text, "|{key}:d{}", joined(values)),
                KeyValue::Text(value) => {
                    write!(text, "|{key}:t{}", value.replace('%', "%25").replace('|', "%7C"))
                }
            };
        }
        text
    }

    /// The keys that [`crs`](Self::crs) made the text of; `None` for a text of other making.
    fn parse(crs: &str) -> Option<Self> {
        let mut parts = crs.split('|');
        if parts.next()? != KEYS {
            return None;
        }
        let mut keys = BTreeMap::new();
        for part in parts {
            let (key, value) = part.split_once(':')?;
            let (kind, value) = value.split_at_checked(1)?;
            let value = match kind {
                "s" => KeyValue::Shorts(value.split(',').map(|x| x.parse().ok()).collect::<Option<_>>()?),
                "d" => KeyValue::Doubles(value.split(',').map(|x| x.parse().ok()).collect::<Option<_>>()?),
                "t" => KeyValue::Text(value.replace("%7C", "|").replace("%25", "%")),
                _ => return None,
            };
            keys.insert(key.parse().ok()?, value);
        }
        Some(Self(keys))
    }

    /// The keys that say where the cells of `grid` lie; a remark when its system cannot be said in keys.
    fn for_grid(grid: &Grid, georef: &Georef) -> (Self, Option<String>) {
        let mut keys = BTreeMap::new();
        let short = |value| KeyValue::Shorts(vec![value]);
        let mut remark = None;
        let epsg = georef.crs.strip_prefix("EPSG:").map(|code| code.split_once('+').unwrap_or((code, "")));
        if let Some((Ok(code), vertical)) = epsg.map(|(code, vertical)| (code.parse::<u16>(), vertical)) {
            let geographic = is_geographic(code, &georef.transform, grid.size());
            keys.insert(MODEL_TYPE, short(if geographic { 2 } else { 1 }));
            if geographic {
                keys.insert(GEOGRAPHIC_TYPE, short(code));
                keys.insert(ANGULAR_UNITS, short(DEGREE));
            } else {
                keys.insert(PROJECTED_TYPE, short(code));
                keys.insert(LINEAR_UNITS, short(linear_unit(grid, georef)));
            }
            if let Ok(code) = vertical.parse() {
                keys.insert(VERTICAL_TYPE, short(code));
                keys.insert(VERTICAL_UNITS, short(METRE));
            }
        } else if let Some(Self(given)) = Self::parse(&georef.crs) {
            keys = given;
        } else {
            keys.insert(LINEAR_UNITS, short(METRE));
            if !georef.crs.is_empty() {
                keys.insert(CITATION, KeyValue::Text(georef.crs.replace('|', "/")));
                remark = Some(format!("the coordinate system `{}` is kept as a note only", georef.crs));
            }
        }
        keys.insert(RASTER_TYPE, short(PIXEL_IS_AREA));
        (Self(keys), remark)
    }
}

fn joined<T: ToString>(values: &[T]) -> String {
    values.iter().map(ToString::to_string).collect::<Vec<_>>().join(",")
}

/// Metres of a unit of length by its EPSG number.
fn metres_of(unit: u16) -> Option<f64> {
    Some(match unit {
        METRE => 1.0,
        9002 => FOOT,
        9003 => SURVEY_FOOT,
        9005 => 0.304_797_265_4,
        9014 => 1.8288,
        9030 => 1852.0,
        9036 => 1000.0,
        9093 => 1609.344,
        9096 => 0.9144,
        _ => return None,
    })
}

/// Whether an EPSG number stands for longitude and latitude. The registry mixes both kinds in places, so
/// outside the blocks of one kind the coordinates themselves decide.
fn is_geographic(code: u16, transform: &[f64; 6], size: (usize, usize)) -> bool {
    let projected = matches!(code, 2000..=3818 | 3832..=3888 | 20000..=32760);
    !projected && lies_on_globe(transform, size)
}

/// The unit of length of a projected system, which the true size of a cell gives away.
fn linear_unit(grid: &Grid, georef: &Georef) -> u16 {
    let metres = grid.cell.x / libm::hypot(georef.transform[1], georef.transform[4]);
    let near = |unit: f64| (metres / unit - 1.0).abs() < 2e-7;
    if near(FOOT) {
        9002
    } else if near(SURVEY_FOOT) {
        9003
    } else {
        METRE
    }
}

/// The tags that place a grid, in ascending order, as (tag, values).
pub(super) struct GeoTags {
    pub(super) scale: Option<[f64; 3]>,
    pub(super) tie: Option<[f64; 6]>,
    pub(super) matrix: Option<[f64; 16]>,
    pub(super) directory: Vec<u16>,
    pub(super) doubles: Vec<f64>,
    pub(super) texts: String,
    pub(super) remark: Option<String>,
}

impl GeoTags {
    /// The tags for `grid`; without georeference its own position in metres.
    pub(super) fn of(grid: &Grid) -> Self {
        let georef = grid.georef_here().unwrap_or_else(|| {
            let first = grid.position(0, 0);
            let (x, y) = (grid.cell.x, grid.cell.y);
            Georef { transform: [first.x - x / 2.0, x, 0.0, first.y + y / 2.0, 0.0, -y], crs: String::new() }
        });
        let [x0, xc, xr, y0, yc, yr] = georef.transform;
        let upright = xr == 0.0 && yc == 0.0 && xc > 0.0 && yr < 0.0;
        let matrix = [xc, xr, 0.0, x0, yc, yr, 0.0, y0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
        let (keys, remark) = Keys::for_grid(grid, &georef);
        let mut tags = Self {
            scale: upright.then_some([xc, -yr, 0.0]),
            tie: upright.then_some([0.0, 0.0, 0.0, x0, y0, 0.0]),
            matrix: (!upright).then_some(matrix),
            directory: vec![1, 1, 0, keys.0.len() as u16],
            doubles: Vec::new(),
            texts: String::new(),
            remark,
        };
        let mut shorts = Vec::new();
        let after = 4 + 4 * keys.0.len();
        for (key, value) in keys.0 {
            let entry = match value {
                KeyValue::Shorts(values) if values.len() == 1 => [key, 0, 1, values[0]],
                KeyValue::Shorts(values) => {
                    let start = (after + shorts.len()) as u16;
                    shorts.extend_from_slice(&values);
                    [key, tag::GEO_KEY_DIRECTORY, values.len() as u16, start]
                }
                KeyValue::Doubles(values) => {
                    let start = tags.doubles.len() as u16;
                    tags.doubles.extend_from_slice(&values);
                    [key, tag::GEO_DOUBLE_PARAMS, values.len() as u16, start]
                }
                KeyValue::Text(text) => {
                    let start = tags.texts.len() as u16;
                    tags.texts.push_str(&text);
                    tags.texts.push('|');
                    [key, tag::GEO_ASCII_PARAMS, text.len() as u16 + 1, start]
                }
            };
            tags.directory.extend_from_slice(&entry);
        }
        tags.directory.extend_from_slice(&shorts);
        tags
    }
}
