use std::sync::atomic::{AtomicU32, Ordering};

use orograph_plugin::{Context, Host, OutputStream, rayon};

use super::*;

fn field(rows: usize, cols: usize, cell: CellSize, height: impl Fn(usize, usize) -> f64) -> Heightfield {
    let cells = (0..rows * cols).map(|i| height(i / cols, i % cols) as f32).collect();
    Heightfield::new(Grid::new(rows, cols, cell).unwrap(), cells).unwrap()
}

/// Hills with many hollows: sums of waves of no common period.
fn hills(rows: usize, cols: usize, cell: CellSize) -> Heightfield {
    field(rows, cols, cell, |row, col| {
        let (x, y) = (col as f64, row as f64);
        let wave =
            |fx: f64, fy: f64, high: f64| high * libm::sin(fx * x + fy * y) * libm::cos(fy * x - fx * y);
        500.0 + wave(0.05, 0.02, 300.0) + wave(0.17, 0.23, 60.0) + wave(0.71, 0.43, 15.0)
    })
}

fn run(settings: &Hydraulic, terrain: &Heightfield) -> (Erosion, Routes) {
    let inputs = HydraulicIn { terrain, rain: None, hardness: None };
    erode(settings, &inputs, &Job::detached()).unwrap()
}

const OBLONG: CellSize = CellSize { x: 60.0, y: 90.0 };

#[test]
fn what_is_carved_is_laid_down_or_leaves() {
    for settling in [0.0, 0.7, 4.0] {
        let terrain = hills(90, 130, OBLONG);
        let settings = Hydraulic { settling, ..Hydraulic::default() };
        let (erosion, _) = run(&settings, &terrain);
        let (mut change, mut carved) = (0.0, 0.0);
        for (new, old) in erosion.heights.iter().zip(terrain.cells()) {
            let moved = f64::from(*new - *old) * 60.0 * 90.0;
            change += moved;
            carved += (-moved).max(0.0);
        }
        assert!(carved > 1e8, "{carved}");
        let unaccounted = (change + erosion.lost).abs();
        assert!(unaccounted < 1e-4 * carved, "{unaccounted} of {carved} m³ at settling {settling}");
    }
}

#[test]
fn all_rain_leaves_at_the_edges_whatever_the_lakes() {
    let terrain = hills(70, 90, OBLONG);
    let settings = Hydraulic { years: 0.0, steps: 1, ..Hydraulic::default() };
    let lattice = Lattice::new(&terrain, &Job::detached()).unwrap();
    let (_, routes) = run(&settings, &terrain);
    assert_eq!(routes.order.len(), terrain.cells().len(), "every cell drains");
    let mut out = 0.0;
    for cell in 0..lattice.len() {
        routes.each_way(&lattice, cell, |_, to, share| {
            if to == lattice::OUT {
                out += routes.discharge[cell] * share;
            }
        });
    }
    let rain = lattice.area * lattice.len() as f64;
    assert!((out - rain).abs() < 1e-9 * rain, "{out} of {rain} m³ a year");
}

#[test]
fn lakes_stand_at_their_lowest_spill() {
    // Brute force: lowering the water until no cell can lower any more gives the same surface.
    let terrain = hills(40, 50, OBLONG);
    let lattice = Lattice::new(&terrain, &Job::detached()).unwrap();
    let (_, routes) = run(&Hydraulic { years: 0.0, steps: 1, ..Hydraulic::default() }, &terrain);
    let ground = terrain.cells();
    let mut water = vec![f32::INFINITY; lattice.len()];
    let mut changed = true;
    while changed {
        changed = false;
        for cell in 0..lattice.len() {
            let mut lowest = lattice.beyond(cell).map_or(f32::INFINITY, |beyond| beyond.height);
            lattice.each(cell, |_, neighbour| lowest = lowest.min(water[neighbour]));
            let level = ground[cell].max(lowest);
            if level < water[cell] {
                (water[cell], changed) = (level, true);
            }
        }
    }
    assert!(
        water.iter().zip(ground).filter(|(water, ground)| water > ground).count() > 20,
        "no lakes to test"
    );
    assert_eq!(routes.water, water);
}

#[test]
fn a_plane_under_even_rain_is_cut_as_the_law_says() {
    let (slope, side, cols) = (0.1, 50.0, 21);
    let terrain = field(121, cols, CellSize::square(side), |_, col| 1000.0 - slope * side * col as f64);
    let years = 10.0;
    let settings = Hydraulic { years, settling: 0.0, steps: 1, ..Hydraulic::default() };
    let (erosion, _) = run(&settings, &terrain);
    // On a plane flow goes down the slope and to both sides of it; the mean slope of those ways:
    let diagonal = 0.5_f64.sqrt();
    let mean = slope * (1.0 + 2.0 * diagonal * diagonal) / (1.0 + 2.0 * diagonal);
    for col in 0..cols - 1 {
        let discharge = side * side * (col + 1) as f64;
        let rate = 0.001 / 0.1 * (discharge / 1e6).sqrt() * mean;
        let cell = 60 * cols + col;
        let cut = f64::from(terrain.cells()[cell] - erosion.heights[cell]);
        assert!(
            (cut - rate * years).abs() < 0.02 * rate * years + 1e-4,
            "{cut} at {col}, not {}",
            rate * years
        );
    }
}

#[test]
fn no_ground_stands_steeper_than_told() {
    let tower = |row: usize, col: usize| (20..40).contains(&row) && (30..50).contains(&col);
    let terrain = field(60, 80, OBLONG, |row, col| if tower(row, col) { 3000.0 } else { 100.0 - col as f64 });
    let settings = Hydraulic { cutting_mm: 0.0, steepest: 40.0, ..Hydraulic::default() };
    let (erosion, _) = run(&settings, &terrain);
    let steepest = libm::tan(40_f64.to_radians());
    let mut most: f64 = 0.0;
    for row in 1..60 {
        for col in 1..80 {
            let height = |row: usize, col: usize| f64::from(erosion.heights[row * 80 + col]);
            let (x, y) = (
                (height(row, col) - height(row, col - 1)) / 60.0,
                (height(row, col) - height(row - 1, col)) / 90.0,
            );
            most = most.max(x.abs()).max(y.abs());
        }
    }
    assert!(most <= steepest * 1.2501 && most > steepest * 0.7, "{most}, not {steepest}");
    assert!(erosion.heights.iter().all(|&height| height < 1500.0), "the tower falls to both its sides");
}

#[test]
fn no_wall_stands_at_the_border() {
    // A slope that leaves the raster stays a slope: no cell of the border stands above its inner neighbour.
    let terrain = field(60, 80, OBLONG, |row, col| 900.0 - 6.0 * col as f64 + 0.3 * (row % 7) as f64);
    let (erosion, _) = run(&Hydraulic::default(), &terrain);
    for row in 1..59 {
        let edge = &erosion.heights[row * 80 + 78..row * 80 + 80];
        assert!(edge[1] <= edge[0], "{edge:?} in row {row}");
    }
}

#[test]
fn voids_stay_voids_and_nothing_else_becomes_one() {
    let mut terrain = hills(50, 60, OBLONG);
    for cell in [0, 61, 700, 701, 702, 760, 1999, 2000] {
        terrain.cells_mut()[cell] = f32::NAN;
    }
    let inputs = HydraulicIn { terrain: &terrain, rain: None, hardness: None };
    let out = Hydraulic::default().run(inputs, &Job::detached()).unwrap();
    for (cell, before) in terrain.cells().iter().enumerate() {
        assert_eq!(out.terrain.cells()[cell].is_nan(), before.is_nan());
        assert_eq!(out.deposit.cells()[cell].is_nan(), before.is_nan());
        assert!((0.0..=1.0).contains(&out.flow.cells()[cell]));
    }
}

#[test]
fn hard_rock_and_dry_ground_stay_as_they_are() {
    let terrain = field(30, 40, OBLONG, |row, col| 400.0 - 3.0 * col as f64 + (row * col % 3) as f64);
    let grid = terrain.grid().clone();
    let none = Mask::new(grid.clone(), vec![0.0; grid.len()]).unwrap();
    let all = Mask::new(grid.clone(), vec![1.0; grid.len()]).unwrap();
    for (rain, hardness) in [(None, Some(&all)), (Some(&none), None)] {
        let inputs = HydraulicIn { terrain: &terrain, rain, hardness };
        let out = Hydraulic::default().run(inputs, &Job::detached()).unwrap();
        let highest =
            out.terrain.cells().iter().zip(terrain.cells()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(highest <= 1e-4, "{highest}");
    }
}

#[test]
fn odd_terrain_is_taken() {
    let nan = f64::NAN;
    for (rows, cols) in [(0, 0), (0, 5), (5, 0), (1, 1), (1, 7), (7, 1), (2, 2)] {
        for height in [0.0, nan, 1e30, -1e30] {
            let terrain = field(rows, cols, OBLONG, |_, _| height);
            let inputs = HydraulicIn { terrain: &terrain, rain: None, hardness: None };
            Hydraulic::default().run(inputs, &Job::detached()).unwrap();
        }
    }
    let flat = field(64, 64, OBLONG, |_, _| 12.0);
    let (erosion, _) = run(&Hydraulic::default(), &flat);
    assert_eq!(erosion.heights, flat.cells());
    let infinite = field(3, 3, OBLONG, |_, _| f64::INFINITY);
    let inputs = HydraulicIn { terrain: &infinite, rain: None, hardness: None };
    assert!(Hydraulic::default().run(inputs, &Job::detached()).is_err());
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let terrain = hills(150, 170, OBLONG);
    let of = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let inputs = HydraulicIn { terrain: &terrain, rain: None, hardness: None };
        let out = pool.install(|| Hydraulic::default().run(inputs, &Job::detached())).unwrap();
        let bits = |cells: &[f32]| cells.iter().map(|cell| cell.to_bits()).collect::<Vec<_>>();
        (bits(out.terrain.cells()), bits(out.deposit.cells()), bits(out.flow.cells()))
    };
    let one = of(1);
    assert!(one == of(2) && one == of(7));
}

/// Cancels after so many questions.
struct Impatient(AtomicU32);

impl Host for Impatient {
    fn cancelled(&self) -> bool {
        self.0.fetch_sub(1, Ordering::Relaxed) == 0
    }
    fn progress(&self, _: f64) {}
    fn warn(&self, _: &str) {}
    fn memory_limit(&self) -> u64 {
        1 << 30
    }
    fn input_path(&self, path: &str) -> Result<std::path::PathBuf> {
        Ok(path.into())
    }
    fn create(&self, path: &str) -> Result<Box<dyn OutputStream>> {
        Err(Error::writing(path, "nowhere"))
    }
}

#[test]
fn it_stops_when_cancelled() {
    let terrain = hills(200, 200, OBLONG);
    for asked in [0, 10, 1000, 5000] {
        let host = Impatient(AtomicU32::new(asked));
        let inputs = HydraulicIn { terrain: &terrain, rain: None, hardness: None };
        let out = Hydraulic::default().run(inputs, &Job::new(&host, Context::default()));
        assert!(matches!(out, Err(Error::Cancelled)), "after {asked} questions");
    }
}
