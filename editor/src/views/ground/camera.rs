//! An eye that circles around the middle of what it looks at.

use eframe::egui::{Pos2, Rect, Vec2, vec2};
use glam::Vec3;

/// Where the eye stands and what it makes of heights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::views) struct Stand {
    /// Compass direction that the eye stands in, in degrees.
    pub(super) azimuth: f32,
    /// How far above the horizon, in degrees.
    pub(super) tilt: f32,
    /// How often larger than where all of it is seen.
    pub(super) zoom: f32,
    /// How far the picture is moved, in shares of the view.
    pub(super) shift: Vec2,
    /// Factor on heights.
    pub(super) exaggeration: f32,
    /// Compass direction of the sun and its height, in degrees.
    pub(super) sun: (f32, f32),
}

impl Default for Stand {
    fn default() -> Self {
        Self {
            azimuth: 200.0,
            tilt: 35.0,
            zoom: 1.0,
            shift: Vec2::ZERO,
            exaggeration: 1.0,
            sun: (315.0, 45.0),
        }
    }
}

impl Stand {
    /// Circles to the right and upwards, in degrees.
    pub(super) fn orbit(&mut self, right: f32, up: f32) {
        self.azimuth = (self.azimuth + right).rem_euclid(360.0);
        self.tilt = (self.tilt + up).clamp(5.0, 89.0);
    }

    pub(super) fn enlarge(&mut self, factor: f32) {
        self.zoom = (self.zoom * factor).clamp(0.2, 20.0);
    }

    /// Looks at all of it again; light and heights stay.
    pub(super) fn reset(&mut self) {
        let Self { exaggeration, sun, .. } = *self;
        *self = Self { exaggeration, sun, ..Self::default() };
    }

    /// Where the eye stands, in words.
    pub(super) fn words(&self) -> String {
        format!("seen from {:.0}°, {:.0}° up", self.azimuth, self.tilt)
    }

    /// The direction towards the sun; y runs south.
    pub(super) fn sun_direction(&self) -> Vec3 {
        direction(self.sun.0, self.sun.1)
    }
}

fn direction(azimuth: f32, altitude: f32) -> Vec3 {
    let (azimuth, altitude) = (azimuth.to_radians(), altitude.to_radians());
    let level = libm::cosf(altitude);
    Vec3::new(libm::sinf(azimuth) * level, -libm::cosf(azimuth) * level, libm::sinf(altitude))
}

/// An eye that looks at the middle.
pub(super) struct Camera {
    pub(super) eye: Vec3,
    right: Vec3,
    up: Vec3,
    ahead: Vec3,
    centre: Pos2,
    scale: f32,
}

impl Camera {
    /// An eye far enough away to see all of what lies within `radius` of the middle.
    pub(super) fn new(stand: &Stand, rect: Rect, radius: f32) -> Self {
        /// How far away, in radii: less bends the picture, more flattens it.
        const AWAY: f32 = 2.8;
        let from = direction(stand.azimuth, stand.tilt);
        let ahead = -from;
        // y runs south, so the axes are left-handed, and so is this product.
        let right = Vec3::Z.cross(ahead).normalize_or(Vec3::X);
        let up = ahead.cross(right);
        let radius = radius.max(1.0);
        let Vec2 { x, y } = rect.size();
        Self {
            eye: from * AWAY * radius,
            right,
            up,
            ahead,
            centre: rect.center() + stand.shift * rect.size(),
            // As wide as the view allows; less high than wide ground needs less.
            scale: x.min(y * 1.4) * 1.2 * stand.zoom,
        }
    }

    /// Where a place in the world is seen.
    pub(super) fn place(&self, point: Vec3) -> Pos2 {
        let from_eye = point - self.eye;
        let depth = from_eye.dot(self.ahead).max(0.1);
        let at = vec2(from_eye.dot(self.right), -from_eye.dot(self.up)) / depth;
        self.centre + at * self.scale
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eframe::egui::pos2;

    fn from(azimuth: f32, tilt: f32) -> Camera {
        let rect = Rect::from_min_size(pos2(0.0, 0.0), vec2(100.0, 100.0));
        Camera::new(&Stand { azimuth, tilt, ..Stand::default() }, rect, 1.5)
    }

    #[test]
    fn seen_from_the_south_east_lies_to_the_right_and_north_above() {
        let camera = from(180.0, 40.0);
        let middle = camera.place(Vec3::ZERO);
        assert!(camera.place(Vec3::X).x > middle.x);
        assert!(camera.place(-Vec3::Y).y < middle.y);
        assert!(camera.place(Vec3::Z).y < middle.y);
        let (near, far) = (camera.place(Vec3::new(1.0, 1.0, 0.0)), camera.place(Vec3::new(1.0, -1.0, 0.0)));
        assert!(near.x > far.x, "what is nearer is larger");
    }

    #[test]
    fn from_each_side_the_other_three_lie_where_they_should() {
        // The eye in the north sees east to its left, the one in the east sees north to its right.
        let (north, east, west) = (from(0.0, 30.0), from(90.0, 30.0), from(270.0, 30.0));
        assert!(north.place(Vec3::X).x < north.place(Vec3::ZERO).x);
        assert!(east.place(-Vec3::Y).x > east.place(Vec3::ZERO).x);
        assert!(west.place(-Vec3::Y).x < west.place(Vec3::ZERO).x);
        for camera in [&north, &east, &west] {
            assert_eq!(camera.place(Vec3::ZERO), pos2(50.0, 50.0));
        }
    }

    #[test]
    fn a_place_is_seen_where_a_pinhole_would_show_it() {
        let camera = from(180.0, 89.999);
        // From straight above, at 2.8 × 1.5 from the middle, a length is seen in the proportion of distances.
        let at = camera.place(Vec3::new(0.5, 0.0, 0.0));
        assert!((at.x - (50.0 + 0.5 / 4.2 * 120.0)).abs() < 1e-2, "{at}");
        let higher = camera.place(Vec3::new(0.5, 0.0, 1.0));
        assert!((higher.x - (50.0 + 0.5 / 3.2 * 120.0)).abs() < 1e-2, "{higher}");
    }
}
