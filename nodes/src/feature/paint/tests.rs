use super::*;
use crate::test_fields::field;

fn run(node: &Paint, inputs: PaintIn<'_>) -> PaintOut {
    node.run(inputs, &Job::detached()).unwrap()
}

const NOTHING: PaintIn<'static> = PaintIn { like: None, picture: None, stamp: None };

fn on(cells: u32) -> Paint {
    Paint { ground: Ground { width: 1000.0, height: 1000.0, cells }, ..Paint::default() }
}

/// Brute force: a ray from the cell's middle to the left crosses the outline an odd number of times.
fn inside(outline: &[[f64; 3]], row: f64, col: f64) -> bool {
    let mut odd = false;
    for i in 0..outline.len() {
        let (a, b) = (outline[i], outline[(i + 1) % outline.len()]);
        if (a[0] <= row) != (b[0] <= row) {
            odd ^= a[1] + (b[1] - a[1]) * ((row - a[0]) / (b[0] - a[0])) <= col;
        }
    }
    odd
}

#[test]
fn regions_hold_what_a_ray_says_and_later_ones_lie_above() {
    let star = [[0.1, 0.1, 3.0], [0.9, 0.2, 0.0], [0.2, 0.8, 0.0], [0.5, -0.2, 0.0], [0.8, 0.9, 0.0]];
    let square = [[0.5, 0.5, 7.0], [0.5, 1.5, 7.0], [1.5, 1.5, 7.0], [1.5, 0.5, 7.0]];
    let node = Paint { regions: vec![star.to_vec(), square.to_vec()].into(), style: 1, ..on(33) };
    let styles = run(&node, NOTHING).styles;
    let cells =
        |outline: &[[f64; 3]]| outline.iter().map(|p| [p[1] * 32.0, p[0] * 32.0, p[2]]).collect::<Vec<_>>();
    let (star, square) = (cells(&star), cells(&square));
    let mut found = [0; 3];
    for row in 0..33 {
        for col in 0..33 {
            let (r, c) = (row as f64, col as f64);
            let (number, which) = match (inside(&square, r, c), inside(&star, r, c)) {
                (true, _) => (7.0, 2),
                (false, true) => (3.0, 1),
                (false, false) => (1.0, 0),
            };
            assert_eq!(styles.at(row, col), number, "row {row}, col {col}");
            found[which] += 1;
        }
    }
    assert!(found.iter().all(|n| *n > 50), "{found:?}");
}

#[test]
fn neighbours_share_a_border_without_a_gap() {
    let left = vec![[0.0, -0.1, 1.0], [0.37, -0.1, 1.0], [0.61, 1.1, 1.0], [0.0, 1.1, 1.0]];
    let right = vec![[0.37, -0.1, 2.0], [1.1, -0.1, 2.0], [1.1, 1.1, 2.0], [0.61, 1.1, 2.0]];
    let styles = run(&Paint { regions: vec![left, right].into(), ..on(64) }, NOTHING).styles;
    let outside = styles.cells().iter().filter(|style| **style == 0.0).count();
    assert_eq!(outside, 0, "every cell has a style");
}

#[test]
fn each_layer_comes_out_where_it_belongs() {
    let node = Paint {
        ridges: vec![vec![[0.1, 0.2, 0.0], [0.9, 0.2, 0.0]]].into(),
        valleys: vec![vec![[0.1, 0.8, 0.0], [0.9, 0.8, 0.0]]].into(),
        heights: vec![vec![[0.5, 0.5, 432.0]]].into(),
        ..on(101)
    };
    let out = run(&node, NOTHING);
    assert_eq!((out.ridges.kind, out.valleys.kind), (FeatureKind::Ridge, FeatureKind::Valley));
    let rows = |features: &Features| {
        features.lines[0].vertices.iter().map(|v| v[0].round() as i64).collect::<Vec<_>>()
    };
    assert!(rows(&out.ridges).iter().all(|row| *row == 20), "{:?}", rows(&out.ridges));
    assert!(rows(&out.valleys).iter().all(|row| *row == 80));
    assert_eq!(out.constraints.at(50, 50), 432.0);
    assert_eq!(out.constraints.cells().iter().filter(|height| !height.is_nan()).count(), 1);
    assert!(out.given.cells().iter().all(|height| height.is_nan()));
    assert!(out.styles.cells().iter().all(|style| *style == 0.0));
}

#[test]
fn a_stamp_stands_where_it_is_painted_turned() {
    let stamp = field(3, 5, |row, col| (10 * row + col) as f64);
    let node = Paint { stamps: vec![vec![[0.5, 0.5, 90.0]], vec![[0.1, 0.1, 0.0]]].into(), ..on(21) };
    let given = run(&node, PaintIn { stamp: Some(&stamp), ..NOTHING }).given;
    assert_eq!(given.at(10, 10), 12.0, "its middle");
    assert_eq!((given.at(2, 2), given.at(1, 0)), (12.0, 0.0), "unturned");
    // A quarter turn clockwise brings the first row to the right side.
    assert!((given.at(8, 11) - 0.0).abs() < 1e-4 && (given.at(12, 9) - 24.0).abs() < 1e-4);
    assert_eq!(given.cells().iter().filter(|height| !height.is_nan()).count(), 30);
}

#[test]
fn a_picture_lies_under_the_painting_at_any_size_and_the_painting_is_the_same_in_metres() {
    let grid = Grid::new(2, 2, CellSize::square(1.0)).unwrap();
    let colours = [[10, 0, 0, 255], [20, 0, 0, 255], [30, 0, 0, 255], [40, 0, 0, 255]];
    let under = Texture::build(grid, &Job::detached(), |row, out| {
        out.copy_from_slice(&colours[2 * row..2 * row + 2]);
        Ok(())
    })
    .unwrap();
    let bare = run(&on(8), PaintIn { picture: Some(&under), ..NOTHING }).picture;
    assert_eq!([bare.at(0, 0), bare.at(0, 7), bare.at(7, 0), bare.at(4, 4)], colours);
    let like = field(9, 9, |_, _| 0.0);
    let shares = Paint { ridges: vec![vec![[0.25, 0.5, 0.0], [0.75, 0.5, 0.0]]].into(), ..on(9) };
    let metres = |row: usize, col: usize| {
        let place = like.grid().position(row, col);
        [place.x, place.y, 0.0]
    };
    let world = Paint {
        ridges: vec![vec![metres(4, 2), metres(4, 6)]].into(),
        coordinates: Coordinates::World,
        ..on(9)
    };
    let given = || PaintIn { like: Some(&like), ..NOTHING };
    assert_eq!(run(&shares, given()).picture.cells(), run(&world, given()).picture.cells());
}
