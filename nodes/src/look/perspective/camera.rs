//! The pinhole: where points of the world come to lie in the picture.

use glam::DVec3;

use super::{super::colour::Tint, paint::Corner};

/// Share of the picture that the block may fill.
const FILL: f64 = 0.94;

/// A pinhole camera.
pub(super) struct Camera {
    eye: DVec3,
    forward: DVec3,
    right: DVec3,
    up: DVec3,
    /// Distance from the pinhole to the picture, in pixels.
    focal: f64,
    middle: [f64; 2],
}

impl Camera {
    /// A camera that sees the whole box, looking in a direction given by azimuth and tilt, all angles in radians.
    pub(super) fn around(
        [low, high]: [DVec3; 2],
        [azimuth, tilt, field_of_view]: [f64; 3],
        (width, height): (usize, usize),
    ) -> Self {
        let (sine, cosine) = libm::sincos(azimuth);
        let (down, along) = libm::sincos(tilt);
        let forward = DVec3::new(sine * along, cosine * along, -down);
        let right = DVec3::new(cosine, -sine, 0.0);
        let up = DVec3::new(sine * down, cosine * down, along);
        let middle = [width, height].map(|side| side as f64 / 2.0);
        let focal = middle[0].min(middle[1]) / libm::tan(field_of_view / 2.0);
        let centre = (low + high) / 2.0;
        let corners: [DVec3; 8] = std::array::from_fn(|i| {
            let pick = |bit: usize, low: f64, high: f64| if i >> bit & 1 == 0 { low } else { high };
            DVec3::new(pick(0, low.x, high.x), pick(1, low.y, high.y), pick(2, low.z, high.z))
        });
        // How far back the eye must be for each corner to fall within the field of view.
        let back = corners.into_iter().map(|corner| {
            let from = corner - centre;
            let beside = from.dot(right).abs() / middle[0];
            let above = from.dot(up).abs() / middle[1];
            focal * beside.max(above) - from.dot(forward)
        });
        // A block without any extent is looked at from a little way off.
        let least = 1.0 + (high - low).length() / 2.0;
        let eye = centre - forward * back.fold(least, f64::max);
        // What is nearer looks larger, so the block does not fill the picture yet: enlarge and shift.
        let plain = Self { eye, forward, right, up, focal: 1.0, middle: [0.0; 2] };
        let none = [f64::INFINITY, f64::NEG_INFINITY];
        let mut extents = [none; 2];
        for corner in corners.into_iter().filter_map(|corner| plain.see(corner, [0; 4])) {
            for ([first, last], at) in extents.iter_mut().zip([corner.x, corner.y]) {
                (*first, *last) = (first.min(at), last.max(at));
            }
        }
        let fits = |i: usize| 2.0 * FILL * middle[i] / (extents[i][1] - extents[i][0]).max(1e-9);
        let focal = fits(0).min(fits(1));
        let shifted = |i: usize| middle[i] - focal * (extents[i][0] + extents[i][1]) / 2.0;
        Self { focal, middle: [shifted(0), shifted(1)], ..plain }
    }

    /// The place of a point in the picture; `None` behind the eye.
    pub(super) fn see(&self, at: DVec3, colour: Tint) -> Option<Corner> {
        let from = at - self.eye;
        let depth = from.dot(self.forward);
        (depth > 0.0).then(|| Corner {
            x: self.middle[0] + self.focal * from.dot(self.right) / depth,
            y: self.middle[1] - self.focal * from.dot(self.up) / depth,
            near: 1.0 / depth,
            colour,
        })
    }
}
