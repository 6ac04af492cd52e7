//! A Delaunay triangulation of cells of a grid that grows by one cell at a time.
//!
//! Lawson, C. L. (1977), "Software for C¹ surface interpolation", in Mathematical Software III: a new corner splits
//! the triangle that it lies in, then edges are flipped until no triangle's circle holds a corner of its neighbour.
//! Rows and columns are whole numbers, so on which side of an edge a cell lies is decided exactly; circles are those
//! of true metres, exact where cells are square.

use orograph_core::CellSize;

/// No half-edge: beyond the rim.
const NONE: u32 = u32::MAX;

/// Row and column of a cell.
pub(super) type Place = [i32; 2];

/// The triangles, three half-edges each, counter-clockwise seen from above.
pub(super) struct Delaunay {
    /// Where the corners lie.
    pub(super) places: Vec<Place>,
    /// The corner that a half-edge leaves.
    from: Vec<u32>,
    /// The half-edge along the same edge the other way.
    twin: Vec<u32>,
    /// A row's metres over a column's, squared.
    stretch: f64,
    /// Half-edges that may have to be flipped.
    doubtful: Vec<u32>,
}

/// Twice the area of a triangle in cells; positive when it runs counter-clockwise seen from above.
pub(super) fn area(a: Place, b: Place, c: Place) -> i64 {
    cross(less(b, a), less(c, a))
}

fn less(a: Place, b: Place) -> [i64; 2] {
    [0, 1].map(|axis| i64::from(a[axis]) - i64::from(b[axis]))
}

/// Rows run south, so this has the sign that x east and y north would give.
fn cross([a_row, a_col]: [i64; 2], [b_row, b_col]: [i64; 2]) -> i64 {
    b_col * a_row - a_col * b_row
}

fn next(edge: u32) -> u32 {
    if edge % 3 == 2 { edge - 2 } else { edge + 1 }
}

fn previous(edge: u32) -> u32 {
    if edge.is_multiple_of(3) { edge + 2 } else { edge - 1 }
}

impl Delaunay {
    /// The two triangles between the corner cells of a grid, which has two rows and columns at least.
    pub(super) fn new(rows: i32, cols: i32, cell: CellSize) -> Self {
        let (south, east) = (rows - 1, cols - 1);
        let ratio = cell.y / cell.x;
        Self {
            places: vec![[0, 0], [south, 0], [south, east], [0, east]],
            from: vec![0, 1, 2, 0, 2, 3],
            twin: vec![NONE, NONE, 3, 2, NONE, NONE],
            stretch: ratio * ratio,
            doubtful: Vec::new(),
        }
    }

    /// Number of triangles.
    pub(super) fn len(&self) -> usize {
        self.from.len() / 3
    }

    /// The corners of a triangle, by number.
    pub(super) fn corners(&self, triangle: u32) -> [u32; 3] {
        let first = triangle as usize * 3;
        [self.from[first], self.from[first + 1], self.from[first + 2]]
    }

    /// Where a triangle's corners lie.
    pub(super) fn triangle(&self, triangle: u32) -> [Place; 3] {
        self.corners(triangle).map(|corner| self.places[corner as usize])
    }

    /// The triangle, rim included, that holds a cell; the walk begins at another triangle.
    pub(super) fn locate(&self, start: u32, place: Place) -> u32 {
        let mut triangle = start;
        // In a Delaunay triangulation such a walk always arrives; the bound is for rounding on oblong cells.
        for _ in 0..4 * self.len() {
            let edges = [0, 1, 2].map(|side| triangle * 3 + side);
            let across = edges.into_iter().find(|&edge| {
                let (from, to) = (self.start(edge), self.start(next(edge)));
                area(from, to, place) < 0
            });
            match across.map(|edge| self.twin[edge as usize]) {
                None | Some(NONE) => return triangle,
                Some(twin) => triangle = twin / 3,
            }
        }
        let holds = |&triangle: &u32| {
            let [a, b, c] = self.triangle(triangle);
            area(a, b, place) >= 0 && area(b, c, place) >= 0 && area(c, a, place) >= 0
        };
        (0..self.len() as u32).find(holds).unwrap_or(start)
    }

    /// Makes a cell a corner; `triangle` holds it. False where it is a corner already.
    /// Afterwards `triangle` is one of those around the new corner, the last of [`places`](Self::places).
    pub(super) fn insert(&mut self, triangle: u32, place: Place) -> bool {
        let corners = self.triangle(triangle);
        if corners.contains(&place) {
            return false;
        }
        let corner = self.places.len() as u32;
        self.places.push(place);
        let on = (0..3).find(|&side| area(corners[side], corners[(side + 1) % 3], place) == 0);
        match on {
            Some(side) => self.split_edge(triangle * 3 + side as u32, corner),
            None => self.split_triangle(triangle, corner),
        }
        self.flip_doubtful();
        true
    }

    /// The triangles around the newest corner, of which `triangle` is one.
    pub(super) fn around_newest(&self, triangle: u32, out: &mut Vec<u32>) {
        out.clear();
        let newest = (self.places.len() - 1) as u32;
        let first = (triangle * 3..triangle * 3 + 3).find(|&edge| self.from[edge as usize] == newest);
        let Some(first) = first else { return };
        let mut edge = first;
        loop {
            out.push(edge / 3);
            edge = self.twin[previous(edge) as usize];
            if edge == first {
                return;
            }
            if edge == NONE {
                break;
            }
        }
        // A corner at the rim: the other way round, too.
        let mut edge = self.twin[first as usize];
        while edge != NONE {
            out.push(edge / 3);
            edge = self.twin[next(edge) as usize];
        }
    }

    fn start(&self, edge: u32) -> Place {
        self.places[self.from[edge as usize] as usize]
    }

    fn join(&mut self, edge: u32, twin: u32) {
        self.twin[edge as usize] = twin;
        if twin != NONE {
            self.twin[twin as usize] = edge;
        }
    }

    fn add(&mut self, corners: [u32; 3]) -> u32 {
        let edge = self.from.len() as u32;
        self.from.extend(corners);
        self.twin.extend([NONE; 3]);
        edge
    }

    /// Three triangles for one.
    fn split_triangle(&mut self, triangle: u32, corner: u32) {
        let [a, b, c] = self.corners(triangle);
        let first = triangle * 3;
        let (beyond_bc, beyond_ca) = (self.twin[first as usize + 1], self.twin[first as usize + 2]);
        self.from[first as usize + 2] = corner;
        let second = self.add([b, c, corner]);
        let third = self.add([c, a, corner]);
        self.join(second, beyond_bc);
        self.join(third, beyond_ca);
        self.join(first + 1, second + 2);
        self.join(second + 1, third + 2);
        self.join(third + 1, first + 2);
        self.doubtful.extend([first, second, third]);
    }

    /// Two triangles for each of those beside the edge.
    fn split_edge(&mut self, edge: u32, corner: u32) {
        let twin = self.twin[edge as usize];
        let (after, before) = (next(edge), previous(edge));
        let (end, top) = (self.from[after as usize], self.from[before as usize]);
        let beyond = self.twin[after as usize];
        self.from[after as usize] = corner;
        let half = self.add([corner, end, top]);
        self.join(half + 1, beyond);
        self.join(half + 2, after);
        self.doubtful.extend([before, half + 1]);
        if twin == NONE {
            self.join(edge, NONE);
            return;
        }
        let (after, before) = (next(twin), previous(twin));
        let bottom = self.from[before as usize];
        let beyond = self.twin[before as usize];
        self.from[twin as usize] = corner;
        let other = self.add([end, corner, bottom]);
        self.join(other + 2, beyond);
        self.join(other + 1, before);
        self.join(edge, twin);
        self.join(half, other);
        self.doubtful.extend([after, other + 2]);
    }

    /// Each doubtful half-edge lies opposite the newest corner; flips bring that one more edges, so they come to an end.
    fn flip_doubtful(&mut self) {
        while let Some(edge) = self.doubtful.pop() {
            let twin = self.twin[edge as usize];
            if twin == NONE {
                continue;
            }
            let (after, before) = (next(edge), previous(edge));
            let (twin_after, twin_before) = (next(twin), previous(twin));
            let [a, b, top, bottom] = [edge, after, before, twin_before].map(|edge| self.start(edge));
            if !self.in_circle([a, b, top], bottom) || area(bottom, b, top) <= 0 || area(top, a, bottom) <= 0
            {
                continue;
            }
            let (beyond_a, beyond_b) = (self.twin[before as usize], self.twin[twin_before as usize]);
            self.from[edge as usize] = self.from[twin_before as usize];
            self.from[twin as usize] = self.from[before as usize];
            self.join(edge, beyond_b);
            self.join(twin, beyond_a);
            self.join(before, twin_before);
            self.doubtful.extend([edge, twin_after]);
        }
    }

    /// Whether `place` lies inside the circle through three corners that run counter-clockwise.
    fn in_circle(&self, corners: [Place; 3], place: Place) -> bool {
        let [a, b, c] = corners.map(|corner| less(corner, place));
        let terms = [(a, cross(b, c)), (b, cross(c, a)), (c, cross(a, b))];
        // Shares of the determinant that come from distances along columns and along rows.
        let sum = |axis: usize| -> i128 {
            terms.iter().map(|(from, cross)| i128::from(from[axis] * from[axis]) * i128::from(*cross)).sum()
        };
        let (rows, cols) = (sum(0), sum(1));
        if self.stretch == 1.0 { rows + cols > 0 } else { cols as f64 + self.stretch * rows as f64 > 0.0 }
    }
}
