//! Mesh: triangles from above, so that one sees where they are large and where small.

use glam::{DVec2, DVec3};
use orograph_core::prelude::*;

/// Draws a mesh from above: each triangle lit by its own slope from the north-west, with dark edges where there is room.
#[derive(Params, Clone, Debug)]
pub struct Mesh {
    /// Pixels along the longer side.
    #[param(default = 1024u32, range = 1..=16_384, slider = 256..=4096, unit = "px")]
    pub size: u32,
    /// Draws the edges.
    #[param(default = true)]
    pub edges: bool,
}

/// Inputs of [`Mesh`].
#[derive(Inputs)]
pub struct MeshIn<'a> {
    /// Mesh to draw.
    pub mesh: &'a orograph_core::Mesh,
}

/// Outputs of [`Mesh`].
#[derive(Outputs)]
pub struct MeshOut {
    /// The picture, transparent where no triangle lies.
    pub picture: Texture,
}

impl Node for Mesh {
    const ID: &'static str = "look.mesh";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = MeshIn<'a>;
    type Outputs = MeshOut;

    fn cost(&self) -> f64 {
        10.0
    }

    fn run(&self, inputs: MeshIn<'_>, job: &Job) -> Result<MeshOut> {
        let mesh = inputs.mesh;
        job.check()?;
        let grid = picture_grid(mesh, self.size)?;
        let mut picture = Texture::filled(grid.clone(), [0; 4], job)?;
        job.admit(grid.len() as u64 * 8, || "the picture's depths".into())?;
        let mut depths = vec![f64::NEG_INFINITY; grid.len()];
        let mut patience = PATIENCE;
        for corners in &mesh.triangles {
            let place =
                |corner: u32| mesh.vertices.get(corner as usize).map(|at| DVec3::from(at.map(f64::from)));
            let &[a, b, c] = corners;
            // A corner that is not there belongs to a broken mesh; what is left of it is drawn.
            let (Some(a), Some(b), Some(c)) = (place(a), place(b), place(c)) else { continue };
            let pixels = draw([a, b, c], &grid, self.edges, |at, depth, grey| {
                if depth > depths[at] {
                    depths[at] = depth;
                    picture.cells_mut()[at] = [grey, grey, grey, 255];
                }
            });
            patience -= 16 + pixels;
            if patience < 0 {
                patience = PATIENCE;
                job.check()?;
            }
        }
        Ok(MeshOut { picture })
    }
}

/// Pixels looked at between two questions whether to stop.
const PATIENCE: i64 = 1 << 19;

/// Square pixels over the mesh, `size` along its longer side.
fn picture_grid(mesh: &orograph_core::Mesh, size: u32) -> Result<Grid> {
    let flat = mesh.vertices.iter().map(|&[x, y, _]| DVec2::new(f64::from(x), f64::from(y)));
    let (least, most) = flat
        .filter(|place| place.is_finite())
        .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(least, most), at| (least.min(at), most.max(at)));
    let extent = most - least;
    if mesh.triangles.is_empty() || extent.max_element() <= 0.0 || !extent.is_finite() {
        return Err(Error::EmptyInput { what: "mesh".into() });
    }
    let pixel = extent.max_element() / f64::from(size);
    let count = |along: f64| (libm::ceil(along / pixel - 1e-9) as usize).max(1);
    let mut grid = Grid::new(count(extent.y), count(extent.x), CellSize::square(pixel))?;
    grid.origin = DVec2::new(least.x + pixel / 2.0, most.y - pixel / 2.0);
    Ok(grid)
}

/// Gives `paint` the pixels of a triangle that is seen from above: their number, height and grey. Returns how many
/// pixels were looked at.
fn draw(corners: [DVec3; 3], grid: &Grid, with_edges: bool, mut paint: impl FnMut(usize, f64, u8)) -> i64 {
    let [a, b, c] = corners;
    let normal = (b - a).cross(c - a);
    if !normal.is_finite() || normal.z <= 0.0 {
        return 0;
    }
    let light = DVec3::new(-0.5, 0.5, core::f64::consts::FRAC_1_SQRT_2);
    let lit = normal.normalize().dot(light).max(0.0);
    // In pixels, x east and y north from the centre of the north-western one.
    let flat = corners.map(|corner| (corner.truncate() - grid.origin) / grid.cell.x);
    let (low, high) = (flat[0].min(flat[1]).min(flat[2]), flat[0].max(flat[1]).max(flat[2]));
    let sides = [0, 1, 2].map(|i| flat[(i + 2) % 3] - flat[(i + 1) % 3]);
    let lengths = sides.map(DVec2::length);
    let whole = sides[2].perp_dot(-sides[1]);
    if whole <= 0.0 {
        return 0;
    }
    // The radius of the circle inside: edges of small triangles would leave nothing but themselves.
    let room = whole / (lengths[0] + lengths[1] + lengths[2]);
    let strength = if with_edges { 0.6 * (room / 2.0).min(1.0) } else { 0.0 };
    let rows = pixels(-high.y, -low.y, grid.rows);
    let cols = pixels(low.x, high.x, grid.cols);
    for row in rows.clone() {
        for col in cols.clone() {
            let at = DVec2::new(col as f64, -(row as f64));
            // Twice the areas of the parts that lie across from each corner.
            let parts = [0, 1, 2].map(|i| sides[i].perp_dot(at - flat[(i + 1) % 3]));
            if parts.iter().any(|&part| part < 0.0) {
                continue;
            }
            let depth = (0..3).map(|i| parts[i] * corners[i].z).sum::<f64>() / whole;
            let nearest = (0..3).map(|i| parts[i] / lengths[i]).fold(f64::INFINITY, f64::min);
            let dark = strength * (1.0 - nearest).max(0.0);
            paint(row * grid.cols + col, depth, ((30.0 + 225.0 * lit) * (1.0 - dark)) as u8);
        }
    }
    rows.len() as i64 * cols.len() as i64
}

/// The whole numbers below `count` from one number to another.
fn pixels(from: f64, to: f64, count: usize) -> std::ops::Range<usize> {
    // A cast takes what is below 0 there.
    libm::ceil(from) as usize..((libm::floor(to) + 1.0) as usize).min(count)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(mesh: &orograph_core::Mesh, size: u32) -> Texture {
        Mesh { size, edges: false }.run(MeshIn { mesh }, &Job::detached()).unwrap().picture
    }

    #[test]
    fn triangles_cover_their_ground_and_the_highest_is_seen() {
        let vertices = vec![
            [0.0, 0.0, 0.0],
            [40.0, 0.0, 0.0],
            [40.0, 20.0, 0.0],
            [0.0, 20.0, 0.0],
            // A roof over the eastern half that falls away from the light.
            [20.0, 0.0, 90.0],
            [40.0, 0.0, 50.0],
            [40.0, 20.0, 50.0],
            [20.0, 20.0, 90.0],
        ];
        let square = |first: u32| [[first, first + 1, first + 2], [first, first + 2, first + 3]];
        let triangles = [square(0), square(4)].concat();
        let mesh = orograph_core::Mesh { vertices, triangles, ..Default::default() };
        let picture = drawn(&mesh, 40);
        assert_eq!(picture.grid().size(), (20, 40));
        assert_eq!(picture.grid().position(0, 0), DVec2::new(0.5, 19.5));
        let flat = (30.0 + 225.0 * core::f64::consts::FRAC_1_SQRT_2) as u8;
        for row in 0..20 {
            assert!(picture.row(row)[..20].iter().all(|pixel| *pixel == [flat, flat, flat, 255]), "{row}");
            assert!(picture.row(row)[20..].iter().all(|pixel| pixel[0] < 60 && pixel[3] == 255), "{row}");
        }
        // From below nothing is seen.
        let turned = mesh.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
        let below = drawn(&orograph_core::Mesh { triangles: turned, ..mesh }, 40);
        assert!(below.cells().iter().all(|pixel| *pixel == [0; 4]));
    }

    #[test]
    fn what_has_no_extent_is_refused() {
        let point = orograph_core::Mesh {
            vertices: vec![[1.0; 3]; 3],
            triangles: vec![[0, 1, 2]],
            ..Default::default()
        };
        for mesh in [orograph_core::Mesh::default(), point] {
            let run = Mesh::default().run(MeshIn { mesh: &mesh }, &Job::detached());
            assert!(matches!(run, Err(Error::EmptyInput { .. })));
        }
    }
}
