//! Every DEM opens with the size, cell, range and voids that the folder's README states.

use std::path::Path;

use orograph_core::prelude::*;
use orograph_nodes::io::{read_dem::ReadDem, read_png::ReadPng};

use crate::Check;

/// What the README states of a file: columns and rows, metres per cell, lowest and highest height, voids.
struct Stated {
    file: &'static str,
    size: (usize, usize),
    cell: (f64, f64),
    range: (f32, f32),
    voids: usize,
}

const fn stated(
    file: &'static str,
    size: (usize, usize),
    cell: (f64, f64),
    range: (f32, f32),
    voids: usize,
) -> Stated {
    Stated { file, size, cell, range, voids }
}

const STATED: &[Stated] = &[
    stated("tatra_carpathians_3as_2401.tif", (2401, 2401), (60.9, 92.5), (95.0, 2636.0), 70),
    stated("betic_sierra_nevada_3as_3601x2401.tif", (3601, 2401), (74.1, 92.5), (-14.0, 3460.0), 0),
    stated("cascades_n47w122_n47w121_3as_2401x1201.tif", (2401, 1201), (62.7, 92.5), (6.0, 2835.0), 0),
    stated("puget_sound_n47w123_n48w123_3as_1201x2401.tif", (1201, 2401), (62.1, 92.5), (0.0, 1979.0), 0),
    stated("puget_cascades_n47_3as_3601x1201.tif", (3601, 1201), (62.7, 92.5), (0.0, 2835.0), 0),
    stated("mount_jackson_n39w107_3as_1201.tif", (1201, 1201), (71.6, 92.5), (1897.0, 4385.0), 0),
    stated("southern_alps_s45e169_3as_1201.tif", (1201, 1201), (66.2, 92.5), (49.0, 2459.0), 0),
    stated("N32E076.hgt.zip", (1201, 1201), (78.1, 92.5), (397.0, 6416.0), 0),
    stated("half_dome_yosemite_ned1as_1027x875.tif", (1027, 875), (24.5, 30.8), (1175.4, 3567.5), 0),
    stated("big_tujunga_30m_1197x643.tif", (1197, 643), (30.0, 30.0), (315.0, 2295.0), 0),
    stated("mackay_lost_river_30m_738x919.tif", (738, 919), (30.0, 30.0), (1732.6, 3645.3), 0),
    stated("missoula_valley_31m_714x975.tif", (714, 975), (30.92, 30.92), (930.0, 2465.0), 0),
    stated("big_butte_flat_30m_623x672.tif", (623, 672), (30.0, 30.0), (1512.0, 2297.9), 0),
    stated("mount_st_helens_30m_327x468.tif", (327, 468), (30.0, 30.0), (682.0, 2543.0), 4151),
    stated("N44W072.hgt", (1201, 1201), (66.0, 92.5), (115.0, 1908.0), 0),
    stated("mount_washington_3as_1025.tif", (1025, 1025), (66.2, 92.5), (115.0, 1908.0), 0),
    stated("presidential_range_ned1as_504x404.tif", (504, 404), (22.1, 30.8), (415.7, 1916.1), 0),
    stated("presidential_range_ned13as_503x499.tif", (503, 499), (7.4, 10.3), (1045.4, 1916.4), 0),
    stated("grand_canyon_n36w113_1000.tif", (1000, 1000), (89.5, 111.0), (507.7, 2824.2), 0),
    stated("grand_canyon_west_512.tif", (512, 512), (61.6, 61.6), (479.0, 2347.0), 0),
    stated("jacksboro_fault_tn_3as_403x344.tif", (403, 344), (74.5, 92.5), (236.0, 1076.0), 0),
    stated("beskids_n49e022_3as_1201.tif", (1201, 1201), (60.2, 92.5), (174.0, 1334.0), 0),
    stated("bohemian_highlands_n49e015_3as_1201.tif", (1201, 1201), (60.2, 92.5), (195.0, 851.0), 4),
    stated("N51W001.hgt.zip", (1201, 1201), (57.6, 92.5), (-30.0, 296.0), 28),
    stated("southern_uplands_aster_24m_1025.tif", (1025, 1025), (24.53, 24.53), (79.0, 886.0), 0),
    stated("N27E086.hgt.zip", (1201, 1201), (82.1, 92.5), (192.0, 8642.0), 130953),
    stated("N46E008.hgt.zip", (1201, 1201), (63.7, 92.5), (187.0, 4173.0), 103743),
    stated("N46W122.hgt", (1201, 1201), (63.7, 92.5), (263.0, 4371.0), 9033),
    stated("N49W123.hgt.zip", (1201, 1201), (60.1, 92.5), (-37.0, 2674.0), 34926),
    stated("N42E001.hgt.zip", (1201, 1201), (68.3, 92.5), (349.0, 3100.0), 7652),
    stated("N43E007.hgt.zip", (1201, 1201), (67.2, 92.5), (-11.0, 2064.0), 1595),
    stated("N43E007_reference.hgt.zip", (1201, 1201), (67.2, 92.5), (-16.0, 2060.0), 4),
    stated("N53E028.hgt.zip", (1201, 1201), (55.1, 92.5), (134.0, 260.0), 0),
];

pub(crate) fn checks() -> Vec<Check> {
    let mut checks: Vec<Check> = STATED
        .iter()
        .map(|stated| {
            Check::new(format!("io: {} opens as stated", stated.file), |folder| stated.check(folder))
        })
        .collect();
    checks.push(Check::new("io: the 16-bit PNG opens with its grey levels as metres", grey_levels));
    checks
}

impl Stated {
    fn check(&self, folder: &Path) -> Result<(), String> {
        let node = ReadDem { file: path_in(folder, self.file), ..ReadDem::default() };
        let terrain = node.run((), &Job::detached()).map_err(|error| error.to_string())?.terrain;
        let grid = terrain.grid();
        same("columns and rows", (grid.cols, grid.rows), self.size)?;
        same("voids", terrain.void_count(), self.voids)?;
        let (low, high) = terrain.range().ok_or("every cell is a void")?;
        // The table gives whole metres or tenths.
        if (low - self.range.0).abs() > 0.051 || (high - self.range.1).abs() > 0.051 {
            return Err(format!("range {low} to {high}, stated {:?}", self.range));
        }
        for (found, stated) in [(grid.cell.x, self.cell.0), (grid.cell.y, self.cell.1)] {
            if (found / stated - 1.0).abs() > 0.006 {
                return Err(format!("cell of {found} m, stated {stated} m"));
            }
        }
        let georef = grid.georef.as_ref().ok_or("no georeference")?;
        if georef.crs.starts_with("EPSG:") { Ok(()) } else { Err(format!("CRS `{}`", georef.crs)) }
    }
}

fn grey_levels(folder: &Path) -> Result<(), String> {
    let file = path_in(folder, "grand_canyon_n36w113_u16.png");
    let node = ReadPng { file, lowest: 0.0, highest: 65_535.0, ..ReadPng::default() };
    let terrain = node.run((), &Job::detached()).map_err(|error| error.to_string())?.terrain;
    same("columns and rows", (terrain.cols(), terrain.rows()), (1000, 1000))?;
    same("range", terrain.range(), Some((48.0, 65_421.0)))
}

fn path_in(folder: &Path, file: &str) -> InputPath {
    InputPath(folder.join(file).to_string_lossy().into_owned())
}

fn same<T: PartialEq + std::fmt::Debug>(what: &str, found: T, stated: T) -> Result<(), String> {
    if found == stated { Ok(()) } else { Err(format!("{what}: {found:?}, stated {stated:?}")) }
}
