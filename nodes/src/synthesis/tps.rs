//! Thin-plate splines: the smoothest map of the plane that takes control points where they belong (Bookstein 1989).
//!
//! A spline maps the output's cells to the exemplar's, which is what resampling needs; the paper (Zhou 2007) describes
//! the opposite direction. The kernel is `U(r) = r² ln r²` in units of a given radius, so the bending energy is a pure
//! number that does not depend on the size of a patch. The system's matrix holds only the points that a spline maps
//! *from*: it is factored once and then fitted to every candidate.

use libm::log;

/// A (row, column) pair.
pub type Point = [f64; 2];

/// The factored system of a set of points to map from.
#[derive(Clone, Debug)]
pub struct Basis {
    from: Vec<Point>,
    origin: Point,
    radius: f64,
    /// LU factors, row-major, of a square matrix of `from.len() + 3`.
    factors: Vec<f64>,
    pivots: Vec<usize>,
    kernel: Vec<f64>,
}

/// A fitted spline: weights of the kernels, then constant, row and column terms, per component.
#[derive(Clone, Debug)]
pub struct Spline {
    weights: Vec<[f64; 2]>,
    energy: f64,
}

fn kernel(square: f64) -> f64 {
    if square > 0.0 { square * log(square) } else { 0.0 }
}

impl Basis {
    /// Factors the system of the points `from`, distances counted in `radius`.
    ///
    /// `None` when the points determine no spline: fewer than three, all on one line, two of them equal, or not finite.
    #[must_use]
    pub fn new(from: &[Point], radius: f64) -> Option<Self> {
        let n = from.len();
        let finite = from.iter().flatten().all(|x| x.is_finite());
        if n < 3 || !finite || radius.is_nan() || radius <= 0.0 {
            return None;
        }
        let origin = from[0];
        let from: Vec<Point> =
            from.iter().map(|p| [(p[0] - origin[0]) / radius, (p[1] - origin[1]) / radius]).collect();
        let side = n + 3;
        let mut matrix = vec![0.0; side * side];
        let mut bending = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..n {
                let (down, across) = (from[i][0] - from[j][0], from[i][1] - from[j][1]);
                let value = kernel(down * down + across * across);
                bending[i * n + j] = value;
                matrix[i * side + j] = value;
            }
            for (k, value) in [1.0, from[i][0], from[i][1]].into_iter().enumerate() {
                matrix[i * side + n + k] = value;
                matrix[(n + k) * side + i] = value;
            }
        }
        let pivots = factor(&mut matrix, side)?;
        Some(Self { from, origin, radius, factors: matrix, pivots, kernel: bending })
    }

    /// The spline that takes each point of the basis to the point of `to` at the same place; `None` unless there is
    /// one finite point for each.
    #[must_use]
    pub fn fit(&self, to: &[Point]) -> Option<Spline> {
        let n = self.from.len();
        if to.len() != n || !to.iter().flatten().all(|x| x.is_finite()) {
            return None;
        }
        let side = n + 3;
        let mut weights = vec![[0.0; 2]; side];
        weights[..n].copy_from_slice(to);
        for row in 0..side {
            weights.swap(row, self.pivots[row]);
        }
        for row in 1..side {
            for col in 0..row {
                let factor = self.factors[row * side + col];
                let [down, across] = weights[col];
                weights[row][0] -= factor * down;
                weights[row][1] -= factor * across;
            }
        }
        for row in (0..side).rev() {
            for col in row + 1..side {
                let factor = self.factors[row * side + col];
                let [down, across] = weights[col];
                weights[row][0] -= factor * down;
                weights[row][1] -= factor * across;
            }
            let pivot = self.factors[row * side + row];
            weights[row] = weights[row].map(|x| x / pivot);
        }
        let scale = self.radius * self.radius;
        let mut energy = 0.0;
        for i in 0..n {
            for j in 0..n {
                let dot = weights[i][0] * weights[j][0] + weights[i][1] * weights[j][1];
                energy += self.kernel[i * n + j] * dot / scale;
            }
        }
        // Rounding may leave a hair below zero.
        Some(Spline { weights, energy: energy.max(0.0) })
    }

    /// What a position contributes to any spline of this basis: the kernels, then 1, row and column.
    pub fn terms(&self, at: Point, out: &mut Vec<f64>) {
        let at = [(at[0] - self.origin[0]) / self.radius, (at[1] - self.origin[1]) / self.radius];
        out.extend(self.from.iter().map(|q| {
            let (down, across) = (at[0] - q[0], at[1] - q[1]);
            kernel(down * down + across * across)
        }));
        out.extend([1.0, at[0], at[1]]);
    }

    /// Number of terms of a position.
    #[must_use]
    pub fn n_terms(&self) -> usize {
        self.from.len() + 3
    }

    /// Where `spline`, a fit of this basis, takes a position.
    #[must_use]
    pub fn map(&self, spline: &Spline, at: Point) -> Point {
        let mut terms = Vec::with_capacity(self.n_terms());
        self.terms(at, &mut terms);
        spline.map_terms(&terms)
    }

    /// The derivative of `spline` at a position: rows of the result are components, columns are row and column.
    #[must_use]
    pub fn jacobian(&self, spline: &Spline, at: Point) -> [[f64; 2]; 2] {
        let n = self.from.len();
        let at = [(at[0] - self.origin[0]) / self.radius, (at[1] - self.origin[1]) / self.radius];
        let mut out = [[0.0; 2]; 2];
        for (component, row) in out.iter_mut().enumerate() {
            *row = [spline.weights[n + 1][component], spline.weights[n + 2][component]];
            for (q, weight) in self.from.iter().zip(&spline.weights) {
                let offset = [at[0] - q[0], at[1] - q[1]];
                let square = offset[0] * offset[0] + offset[1] * offset[1];
                if square > 0.0 {
                    let slope = 2.0 * (log(square) + 1.0) * weight[component];
                    row[0] += slope * offset[0];
                    row[1] += slope * offset[1];
                }
            }
            *row = row.map(|x| x / self.radius);
        }
        out
    }

    /// Whether `spline` turns some part of the square of `half` cells around `center` over: its determinant is not
    /// positive somewhere on a 9 × 9 grid. `mirrored` splines must be negative everywhere instead.
    #[must_use]
    pub fn folds(&self, spline: &Spline, center: Point, half: f64, mirrored: bool) -> bool {
        (0..81).any(|i| {
            let at = |k: i32, center: f64| center + (f64::from(k) - 4.0) / 4.0 * half;
            let [[a, b], [c, d]] = self.jacobian(spline, [at(i / 9, center[0]), at(i % 9, center[1])]);
            let determinant = if mirrored { b * c - a * d } else { a * d - b * c };
            determinant.is_nan() || determinant <= 0.0
        })
    }
}

impl Spline {
    /// Bending energy by the kernel `r² ln r²`: a pure number, zero for every affine map.
    #[must_use]
    pub fn energy(&self) -> f64 {
        self.energy
    }

    /// Where the position of these [`Basis::terms`] is taken.
    #[must_use]
    pub fn map_terms(&self, terms: &[f64]) -> Point {
        let mut out = [0.0; 2];
        for (term, weight) in terms.iter().zip(&self.weights) {
            out[0] += term * weight[0];
            out[1] += term * weight[1];
        }
        out
    }

    /// How the affine part stretches and squeezes: its singular values, larger first, and the sign of its determinant.
    #[must_use]
    pub fn stretch(&self, basis: &Basis) -> Stretch {
        let n = self.weights.len() - 3;
        let [[a, c], [b, d]] = [self.weights[n + 1], self.weights[n + 2]];
        let [a, b, c, d] = [a, b, c, d].map(|x| x / basis.radius);
        let (plus, minus) = (libm::hypot(a + d, c - b), libm::hypot(a - d, c + b));
        let determinant = a * d - b * c;
        Stretch { most: f64::midpoint(plus, minus), least: (plus - minus).abs() / 2.0, determinant }
    }
}

/// The affine part of a spline, as [`Spline::stretch`] tells it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// Largest factor by which a length grows.
    pub most: f64,
    /// Smallest factor.
    pub least: f64,
    /// Negative for a map that mirrors.
    pub determinant: f64,
}

impl Stretch {
    /// Affine distortion: squares of the logarithms of both factors; 0 for rotations.
    #[must_use]
    pub fn distortion(&self) -> f64 {
        let (most, least) = (log(self.most), log(self.least));
        most * most + least * least
    }

    /// Whether a patch may be stretched like this: not degenerate, at most 4 times as much one way as the other, and
    /// between 0.4 and 2.5 times.
    #[must_use]
    pub fn is_usable(&self) -> bool {
        self.least >= 0.4 && self.most <= 2.5 && self.most <= 4.0 * self.least && self.determinant != 0.0
    }
}

/// LU factors with partial pivoting in place; the row swapped with at each step, or `None` for a singular matrix.
fn factor(matrix: &mut [f64], side: usize) -> Option<Vec<usize>> {
    let mut pivots = Vec::with_capacity(side);
    let largest = matrix.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    for step in 0..side {
        let size = |row: usize| matrix[row * side + step].abs();
        let mut best = step;
        for row in step + 1..side {
            if size(row) > size(best) {
                best = row;
            }
        }
        if size(best).is_nan() || size(best) <= 1e-12 * largest {
            return None;
        }
        pivots.push(best);
        if best != step {
            for col in 0..side {
                matrix.swap(step * side + col, best * side + col);
            }
        }
        for row in step + 1..side {
            let factor = matrix[row * side + step] / matrix[step * side + step];
            matrix[row * side + step] = factor;
            for col in step + 1..side {
                matrix[row * side + col] -= factor * matrix[step * side + col];
            }
        }
    }
    Some(pivots)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turned(angle_deg: f64, radius: f64) -> Point {
        let angle = angle_deg.to_radians();
        [radius * libm::sin(angle), radius * libm::cos(angle)]
    }

    /// A branch of `degree` even arms, and the same with its first arm off by 20°.
    fn star(degree: usize, radius: f64) -> (Vec<Point>, Vec<Point>) {
        let arm = |i: usize, off: f64| turned(360.0 * i as f64 / degree as f64 + off, radius);
        let even = |first: f64| {
            let arms = (0..degree).map(|i| arm(i, if i == 0 { first } else { 0.0 }));
            std::iter::once([0.0, 0.0]).chain(arms).collect()
        };
        (even(0.0), even(20.0))
    }

    #[test]
    fn control_points_are_met_and_side_conditions_hold() {
        let from = [[0.0, 0.0], [3.0, 39.0], [-20.0, -31.0], [38.0, -9.0], [11.0, 13.0]]
            .map(|[r, c]| [r + 700.0, c - 90.0]);
        let to = [[1.0, 2.0], [7.0, 44.0], [-25.0, -28.0], [33.0, -2.0], [14.0, 10.0]];
        let basis = Basis::new(&from, 40.0).unwrap();
        let spline = basis.fit(&to).unwrap();
        for (at, want) in from.iter().zip(to) {
            let got = basis.map(&spline, *at);
            assert!(
                libm::hypot(got[0] - want[0], got[1] - want[1]) < 1e-12 * 40.0 * 10.0,
                "{got:?} {want:?}"
            );
        }
        for component in 0..2 {
            let moment = |f: &dyn Fn(&Point) -> f64| {
                basis.from.iter().zip(&spline.weights).map(|(q, w)| f(q) * w[component]).sum::<f64>()
            };
            assert!(
                moment(&|_| 1.0).abs() < 1e-10
                    && moment(&|q| q[0]).abs() < 1e-10
                    && moment(&|q| q[1]).abs() < 1e-10
            );
        }
    }

    #[test]
    fn an_affine_map_does_not_bend_and_tells_its_stretch() {
        let from = [[0.0, 0.0], [40.0, 3.0], [-7.0, 35.0], [-30.0, -22.0]];
        let (sin, cos) = (libm::sin(0.7), libm::cos(0.7));
        // Turned by 0.7 rad after a stretch by 2 in rows and 0.5 in columns.
        let to =
            from.map(|[r, c]| [9.0 + cos * 2.0 * r - sin * 0.5 * c, 4.0 + sin * 2.0 * r + cos * 0.5 * c]);
        let basis = Basis::new(&from, 40.0).unwrap();
        let spline = basis.fit(&to).unwrap();
        assert!(spline.energy() < 1e-20);
        assert!(spline.weights[..4].iter().flatten().all(|w| w.abs() < 1e-12));
        let stretch = spline.stretch(&basis);
        assert!((stretch.most - 2.0).abs() < 1e-12 && (stretch.least - 0.5).abs() < 1e-12);
        assert!((stretch.determinant - 1.0).abs() < 1e-12 && stretch.is_usable());
        assert!((stretch.distortion() - 2.0 * log(2.0) * log(2.0)).abs() < 1e-12);
        assert!(!basis.folds(&spline, [0.0, 0.0], 40.0, false));
        assert!(basis.folds(&spline, [0.0, 0.0], 40.0, true));
    }

    #[test]
    fn energies_are_those_of_the_prototype_at_any_scale() {
        // Measured with r² ln r, which gives twice the energy of this kernel.
        for (degree, energy) in [(3, 0.0122), (4, 0.0290), (5, 0.0496)] {
            for radius in [40.0, 7.5] {
                let (from, to) = star(degree, radius);
                let spline = Basis::new(&from, radius).unwrap().fit(&to).unwrap();
                assert!((2.0 * spline.energy() - energy).abs() < 2e-4, "{degree}: {}", spline.energy());
            }
        }
    }

    #[test]
    fn energy_is_the_bending_integral() {
        // ∫ f_xx² + 2 f_xy² + f_yy² = 16 π wᵗ K w over the whole plane, by central differences on a wide square.
        let (from, to) = star(4, 1.0);
        let basis = Basis::new(&from, 1.0).unwrap();
        let spline = basis.fit(&to).unwrap();
        let (step, reach) = (0.04, 8.0);
        let n = (2.0 * reach / step) as usize;
        let mut sum = 0.0;
        for i in 0..n {
            for j in 0..n {
                // Off the control points, where second derivatives are singular.
                let at = [(i as f64 + 0.5) * step - reach + 0.003, (j as f64 + 0.5) * step - reach + 0.007];
                let d = 1e-3;
                let along = |k: usize, s: f64| if k == 0 { [at[0] + s, at[1]] } else { [at[0], at[1] + s] };
                let gradient = |p: Point| basis.jacobian(&spline, p);
                for component in 0..2 {
                    let second = |k: usize, l: usize| {
                        (gradient(along(l, d))[component][k] - gradient(along(l, -d))[component][k])
                            / (2.0 * d)
                    };
                    let (rr, rc, cc) = (second(0, 0), second(0, 1), second(1, 1));
                    sum += (rr * rr + 2.0 * rc * rc + cc * cc) * step * step;
                }
            }
        }
        let truth = 16.0 * std::f64::consts::PI * spline.energy();
        assert!((sum / truth - 1.0).abs() < 0.03, "{sum} {truth}");
    }

    #[test]
    fn points_that_determine_nothing_are_refused() {
        assert!(Basis::new(&[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]], 1.0).is_none());
        assert!(Basis::new(&[[0.0, 0.0], [1.0, 1.0]], 1.0).is_none());
        assert!(Basis::new(&[[0.0, 0.0], [0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], 1.0).is_none());
        assert!(Basis::new(&[[0.0, 0.0], [f64::NAN, 0.0], [1.0, 0.0], [0.0, 1.0]], 1.0).is_none());
        let basis = Basis::new(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], 1.0).unwrap();
        assert!(basis.fit(&[[0.0, 0.0]]).is_none());
        assert!(basis.fit(&[[f64::INFINITY, 0.0], [1.0, 0.0], [0.0, 1.0]]).is_none());
    }

    #[test]
    fn crossed_control_points_fold() {
        let from = [[0.0, 0.0], [0.0, 40.0], [0.0, -40.0], [40.0, 0.0], [-40.0, 0.0], [20.0, 0.0]];
        let mut to = from;
        to[5] = [-30.0, 5.0];
        let basis = Basis::new(&from, 40.0).unwrap();
        assert!(basis.folds(&basis.fit(&to).unwrap(), [0.0, 0.0], 40.0, false));
    }
}
