//! Meshes against what they are made from: heights cell by cell, topology by counting, circles by brute force.

use std::collections::{BTreeMap, BTreeSet};

use glam::{DVec2, DVec3};
use orograph_core::{Mesh, prelude::*};

use super::{
    delaunay::{Delaunay, area},
    rim::Rim,
    shape::Origin,
    triangulate::{Method, Triangulate, TriangulateIn},
};
use crate::test_fields::field;

/// Hills with a ridge and some noise, on oblong cells, the given cells void.
fn hills(rows: usize, cols: usize, void: impl Fn(usize, usize) -> bool) -> Heightfield {
    let terrain = field(rows, cols, |row, col| {
        let (x, y) = (col as f64 / 9.0, row as f64 / 13.0);
        let noise = orograph_core::gaussian(5, 1, row as i64, col as i64);
        if void(row, col) {
            return f64::NAN;
        }
        800.0 + 60.0 * libm::sin(x) * libm::cos(y) - 30.0 * (x - y).abs() + noise
    });
    let mut grid = terrain.grid().clone();
    grid.cell = CellSize { x: 20.0, y: 31.0 };
    grid.origin = DVec2::new(4000.0, -700.0);
    terrain.with_grid(grid).unwrap()
}

fn run(node: &Triangulate, terrain: &Heightfield) -> (Mesh, Table) {
    let out = node.run(TriangulateIn { terrain }, &Job::detached()).unwrap();
    (out.mesh, out.metrics)
}

fn mesh_of(node: &Triangulate, terrain: &Heightfield) -> Mesh {
    run(node, terrain).0
}

fn metric(table: &Table, name: &str) -> f64 {
    match &table.column(name).unwrap().cells {
        Cells::Numbers(numbers) => numbers[0],
        Cells::Texts(_) => f64::NAN,
    }
}

fn adaptive(max_error: f64) -> Triangulate {
    Triangulate { max_error, origin: Origin::World, ..Triangulate::default() }
}

/// Row and column of each vertex of a mesh that lies where its terrain does.
fn places(mesh: &Mesh, grid: &Grid) -> Vec<[i32; 2]> {
    let place = |vertex: &[f32; 3]| {
        let (row, col) = grid.locate(DVec2::new(f64::from(vertex[0]), f64::from(vertex[1])));
        assert!((row - row.round()).abs() < 1e-3 && (col - col.round()).abs() < 1e-3);
        [row.round() as i32, col.round() as i32]
    };
    mesh.vertices.iter().map(place).collect()
}

/// For each cell how far it is from the mesh, by looking at each triangle and each cell in its box; NaN where no
/// triangle lies. A cell on an edge takes the worse.
fn distances(mesh: &Mesh, terrain: &Heightfield) -> Vec<f64> {
    let (places, cols) = (places(mesh, terrain.grid()), terrain.cols());
    let mut found = vec![f64::NAN; terrain.cells().len()];
    for corners in &mesh.triangles {
        let at = corners.map(|corner| places[corner as usize]);
        let z = corners.map(|corner| f64::from(mesh.vertices[corner as usize][2]));
        let whole = area(at[0], at[1], at[2]);
        assert!(whole > 0, "a triangle that does not run counter-clockwise: {at:?}");
        let range = |axis: usize| {
            let along = at.map(|place| place[axis]);
            *along.iter().min().unwrap()..=*along.iter().max().unwrap()
        };
        for row in range(0) {
            for col in range(1) {
                let share =
                    |i: usize| area([row, col], at[(i + 1) % 3], at[(i + 2) % 3]) as f64 / whole as f64;
                let shares = [share(0), share(1), share(2)];
                if shares.iter().any(|&share| share < 0.0) {
                    continue;
                }
                let level: f64 = shares.iter().zip(z).map(|(share, z)| share * z).sum();
                let i = row as usize * cols + col as usize;
                let distance = (level - f64::from(terrain.cells()[i])).abs();
                assert!(!distance.is_nan(), "a triangle over the void at {row}, {col}");
                found[i] = found[i].max(distance);
            }
        }
    }
    found
}

/// How many triangles have each edge, directed.
fn edges(mesh: &Mesh) -> BTreeMap<[u32; 2], usize> {
    let mut edges = BTreeMap::new();
    for &[a, b, c] in &mesh.triangles {
        for edge in [[a, b], [b, c], [c, a]] {
            *edges.entry(edge).or_insert(0) += 1;
        }
    }
    edges
}

/// Vertices less edges plus triangles; no edge may have two triangles on one side.
fn euler(mesh: &Mesh) -> i64 {
    let directed = edges(mesh);
    assert!(directed.values().all(|&count| count == 1));
    let edges: BTreeSet<[u32; 2]> = directed.keys().map(|&[a, b]| [a.min(b), a.max(b)]).collect();
    let used: BTreeSet<u32> = mesh.triangles.as_flattened().iter().copied().collect();
    assert_eq!(used.len(), mesh.vertices.len(), "every vertex is in a triangle");
    mesh.vertices.len() as i64 - edges.len() as i64 + mesh.triangles.len() as i64
}

#[test]
fn no_cell_is_further_off_than_allowed() {
    let terrain = hills(90, 71, |_, _| false);
    let mut before = usize::MAX;
    for max_error in [0.001, 0.3, 1.0, 5.0, 1000.0] {
        let (mesh, metrics) = run(&adaptive(max_error), &terrain);
        let worst = distances(&mesh, &terrain).into_iter().fold(0.0, |worst: f64, distance| {
            assert!(!distance.is_nan(), "a cell without triangle");
            worst.max(distance)
        });
        assert!(worst <= max_error, "{worst} > {max_error}");
        assert!((worst - metric(&metrics, "greatest_error")).abs() < 1e-9);
        assert_eq!(euler(&mesh), 1, "a whole terrain is a disc");
        assert!(mesh.triangles.len() < before, "a larger error takes fewer triangles");
        before = mesh.triangles.len();
    }
    assert_eq!(before, 2);
}

#[test]
fn few_triangles_are_not_far_from_the_fewest() {
    // A roof along a diagonal needs its ridge and nothing else; greedy insertion must find the ridge soon.
    let terrain = field(65, 65, |row, col| 100.0 - (row as f64 - col as f64).abs());
    let mesh = mesh_of(&adaptive(0.01), &terrain);
    assert!(mesh.triangles.len() <= 4, "{}", mesh.triangles.len());
    // A cone with an error of a hundredth of its height: some dozens of facets, not thousands.
    let cone = field(129, 129, |row, col| 100.0 - libm::hypot(row as f64 - 64.0, col as f64 - 64.0));
    let (mesh, metrics) = run(&adaptive(1.0), &cone);
    assert!(mesh.triangles.len() < 150, "{}", mesh.triangles.len());
    assert!(metric(&metrics, "vertices_per_cell") < 0.01);
}

type Voids<'a> = &'a dyn Fn(usize, usize) -> bool;

#[test]
fn voids_become_holes_and_nothing_else_does() {
    let blocks = |row: usize, col: usize| {
        (10..20).contains(&row) && (5..9).contains(&col)
            || (row, col) == (40, 30)
            || (25..30).contains(&row) && (row + col).is_multiple_of(2) && (40..50).contains(&col)
    };
    let disc = |row: usize, col: usize| {
        libm::hypot(row as f64 - 30.0, col as f64 - 30.0) < 12.0 || (row == 0 && col == 0) || row > 55
    };
    let most = |row: usize, col: usize| !(row * 7 + col * 3).is_multiple_of(5);
    let block = |row: usize, col: usize| blocks(row, col) && row < 21;
    let tests: [(Voids<'_>, bool); 3] = [(&block, true), (&disc, true), (&blocks, false)];
    for (void, alone) in tests {
        let terrain = hills(60, 61, void);
        for max_error in [0.2, 4.0, 500.0] {
            let mesh = mesh_of(&adaptive(max_error), &terrain);
            let distances = distances(&mesh, &terrain);
            let regular = Triangulate { method: Method::Regular, ..adaptive(1.0) };
            let covered = self::distances(&mesh_of(&regular, &terrain), &terrain);
            for (i, (distance, cover)) in distances.iter().zip(&covered).enumerate() {
                assert_eq!(distance.is_nan(), cover.is_nan(), "cell {i}");
                assert!(distance.is_nan() || *distance <= max_error, "cell {i}: {distance}");
            }
            if alone {
                assert_eq!(euler(&mesh), 0, "one hole");
            }
        }
    }
    // Nearly everything void: nothing but single cells is left.
    let terrain = hills(30, 30, most);
    assert!(matches!(
        adaptive(1.0).run(TriangulateIn { terrain: &terrain }, &Job::detached()),
        Err(Error::Invalid { .. })
    ));
}

#[test]
fn a_plane_is_two_triangles_with_its_own_normal() {
    let tilt = DVec2::new(0.25, -0.125);
    let plane = field(33, 47, |row, col| 500.0 + tilt.x * 10.0 * col as f64 - tilt.y * 10.0 * row as f64);
    let normal = DVec3::new(-tilt.x, -tilt.y, 1.0).normalize();
    for method in [Method::Adaptive, Method::Regular] {
        let mesh = mesh_of(&Triangulate { method, ..Triangulate::default() }, &plane);
        let expected = if method == Method::Adaptive { (4, 2) } else { (33 * 47, 2 * 32 * 46) };
        assert_eq!((mesh.vertices.len(), mesh.triangles.len()), expected);
        for found in &mesh.normals {
            assert!((DVec3::from(found.map(f64::from)) - normal).length() < 1e-6, "{found:?}");
        }
        for corners in &mesh.triangles {
            let [a, b, c] = corners.map(|corner| DVec3::from(mesh.vertices[corner as usize].map(f64::from)));
            assert!(((b - a).cross(c - a).normalize() - normal).length() < 1e-6);
        }
    }
}

#[test]
fn origins_and_texture_coordinates_are_where_they_are_said_to_be() {
    let terrain = hills(4, 5, |_, _| false);
    let corner = |origin: Origin| {
        let mesh = mesh_of(&Triangulate { origin, method: Method::Regular, ..adaptive(1.0) }, &terrain);
        (mesh.vertices[0], mesh.vertices[19], mesh.uvs[0], mesh.uvs[19])
    };
    let (first, last, uv_first, uv_last) = corner(Origin::Middle);
    assert_eq!((&first[..2], &last[..2]), (&[-40.0, 46.5][..], &[40.0, -46.5][..]));
    assert_eq!(first[2], terrain.at(0, 0));
    // Half a cell inside the outer edges, over which the texture lies.
    assert_eq!((uv_first, uv_last), ([0.1, 0.875], [0.9, 0.125]));
    assert_eq!(corner(Origin::SouthWest).1[..2], [90.0, 15.5]);
    assert_eq!(corner(Origin::World).0[..2], [4000.0, -700.0]);
    let mut grid = terrain.grid().clone();
    let transform = [500_000.0, 20.0, 0.0, 4_000_000.0, 0.0, -31.0];
    grid.georef = Some(Georef { transform, crs: "EPSG:32632".into() }.into());
    let told = |origin: Origin| origin.told(&grid).unwrap();
    assert!(told(Origin::Middle).contains("x 500050, y 3999938 in EPSG:32632"), "{}", told(Origin::Middle));
    assert!(told(Origin::SouthWest).contains("x 500000, y 3999876"), "{}", told(Origin::SouthWest));
    assert!(Origin::Middle.told(terrain.grid()).is_none());
}

#[test]
fn triangles_end_where_they_are_told_to() {
    let terrain = hills(90, 71, |_, _| false);
    for most in [2_u32, 3, 100, 1001] {
        let (mesh, metrics) = run(&Triangulate { max_triangles: most, ..adaptive(0.01) }, &terrain);
        assert!((most as usize - 1..=most as usize).contains(&mesh.triangles.len()), "{most}");
        let worst = distances(&mesh, &terrain).into_iter().fold(0.0, f64::max);
        assert!((worst - metric(&metrics, "greatest_error")).abs() < 1e-9);
        assert!(worst > 0.01);
    }
}

#[test]
fn a_body_is_closed_and_a_skirt_hangs_from_the_rim() {
    let terrain = hills(40, 30, |row, col| (10..14).contains(&row) && (10..20).contains(&col));
    let open = mesh_of(&adaptive(2.0), &terrain);
    let body = mesh_of(&Triangulate { rim: Rim::Body, depth: 25.0, ..adaptive(2.0) }, &terrain);
    let directed = edges(&body);
    for (&[a, b], &count) in &directed {
        assert_eq!((count, directed.get(&[b, a])), (1, Some(&1)), "edge {a}, {b}");
    }
    // A ring has the Euler characteristic of a torus' surface.
    assert_eq!(euler(&body), 0);
    let floor = open.vertices.iter().map(|vertex| vertex[2]).fold(f32::INFINITY, f32::min) - 25.0;
    let volume: f64 = body
        .triangles
        .iter()
        .map(|corners| {
            let [a, b, c] = corners.map(|corner| DVec3::from(body.vertices[corner as usize].map(f64::from)));
            a.dot(b.cross(c)) / 6.0
        })
        .sum();
    let above: f64 = open
        .triangles
        .iter()
        .map(|corners| {
            let [a, b, c] = corners.map(|corner| DVec3::from(open.vertices[corner as usize].map(f64::from)));
            let flat = (b - a).cross(c - a).z / 2.0;
            flat * ((a.z + b.z + c.z) / 3.0 - f64::from(floor))
        })
        .sum();
    assert!(volume > 0.0 && (volume / above - 1.0).abs() < 1e-3, "{volume} is not {above}");
    let skirt = mesh_of(&Triangulate { rim: Rim::Skirt, depth: 25.0, ..adaptive(2.0) }, &terrain);
    let directed = edges(&open);
    let rim = directed.keys().filter(|&&[a, b]| !directed.contains_key(&[b, a])).count();
    assert_eq!(skirt.triangles.len(), open.triangles.len() + 2 * rim);
    assert_eq!(skirt.vertices.len(), open.vertices.len() + rim);
    assert_eq!(euler(&skirt), 0);
    assert!(skirt.triangles.starts_with(&open.triangles) && skirt.uvs.len() == skirt.vertices.len());
}

#[test]
fn a_body_is_closed_wherever_its_voids_lie() {
    for share in [40, 9, 3] {
        let terrain = hills(30, 33, |row, col| {
            orograph_core::key(8, share, row as i64, col as i64).is_multiple_of(share)
        });
        for method in [Method::Adaptive, Method::Regular] {
            let body = mesh_of(&Triangulate { method, rim: Rim::Body, ..adaptive(3.0) }, &terrain);
            let directed = edges(&body);
            for (&[a, b], &count) in &directed {
                assert_eq!((count, directed.get(&[b, a])), (1, Some(&1)), "edge {a}, {b}");
            }
        }
    }
}

#[test]
fn circles_of_triangles_are_empty() {
    for cell in [CellSize::square(1.0), CellSize { x: 1.0, y: 2.75 }] {
        let (rows, cols) = (40, 33);
        let mut triangles = Delaunay::new(rows, cols, cell);
        let mut triangle = 0;
        for which in 0..400 {
            let draw = |k: u64, n: i32| (orograph_core::key(7, k, which, 0) % n as u64) as i32;
            let place = [draw(0, rows), draw(1, cols)];
            triangle = triangles.locate(triangle, place);
            triangles.insert(triangle, place);
        }
        let metres = |[row, col]: [i32; 2]| DVec2::new(f64::from(col) * cell.x, -f64::from(row) * cell.y);
        let mut whole = 0;
        for triangle in 0..triangles.len() as u32 {
            let corners = triangles.triangle(triangle);
            whole += area(corners[0], corners[1], corners[2]);
            let [a, b, c] = corners.map(metres);
            // The circle's centre, by the perpendiculars on two sides.
            let (ab, ac) = (b - a, c - a);
            let twice = 2.0 * ab.perp_dot(ac);
            let (x, y) = (ab.length_squared(), ac.length_squared());
            let centre = DVec2::new(ac.y * x - ab.y * y, ab.x * y - ac.x * x) / twice;
            for &place in &triangles.places {
                let inside = centre.length() - (metres(place) - a - centre).length();
                assert!(inside < 1e-9 * centre.length().max(1.0), "{place:?} in the circle of {corners:?}");
            }
        }
        assert_eq!(whole, i64::from(2 * (rows - 1) * (cols - 1)), "triangles cover the grid once");
        let distinct: BTreeSet<[i32; 2]> = triangles.places.iter().copied().collect();
        assert_eq!(distinct.len(), triangles.places.len());
    }
}

#[test]
fn what_has_no_triangle_is_refused() {
    let run = |terrain: &Heightfield| Triangulate::default().run(TriangulateIn { terrain }, &Job::detached());
    assert!(matches!(run(&field(1, 9, |_, _| 1.0)), Err(Error::BadSize { .. })));
    assert!(matches!(run(&field(3, 3, |_, _| f64::NAN)), Err(Error::AllVoid { .. })));
    assert!(matches!(run(&field(3, 3, |row, _| 1.0 / row as f64)), Err(Error::NonFinite { row: 0, .. })));
    // Heights where rounding is larger than the error asked for still come to an end.
    let steep = field(20, 20, |row, col| ((row * 7 + col * 5) % 11) as f64 * 1e30);
    assert!(run(&steep).is_ok());
}
