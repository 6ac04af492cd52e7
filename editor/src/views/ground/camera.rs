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

/// What is to be seen: how far it reaches from the middle, on the level, down and up.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    pub(super) level: f32,
    pub(super) low: f32,
    pub(super) high: f32,
}

impl Bounds {
    /// How far the furthest place is from the middle.
    fn radius(&self) -> f32 {
        libm::hypotf(self.level, self.high.max(-self.low))
    }
}

impl Camera {
    /// An eye far enough away to see all of what lies within the bounds, from whatever side.
    pub(super) fn new(stand: &Stand, rect: Rect, bounds: Bounds) -> Self {
        /// How far away, in radii: less bends the picture, more flattens it.
        const AWAY: f32 = 2.8;
        /// How much of the view it fills.
        const FILLED: f32 = 0.94;
        let from = direction(stand.azimuth, stand.tilt);
        let ahead = -from;
        // y runs south, so the axes are left-handed, and so is this product.
        let right = Vec3::Z.cross(ahead).normalize_or(Vec3::X);
        let up = ahead.cross(right);
        let distance = AWAY * bounds.radius().max(1.0);
        // The highest and the lowest place seen of a cylinder around the middle: the same from every side.
        let (sin, cos) = (libm::sinf(stand.tilt.to_radians()), libm::cosf(stand.tilt.to_radians()));
        let seen = |near: f32, z: f32| (z * cos - near * sin) / (distance - near * cos - z * sin);
        let edges =
            [-bounds.level, bounds.level].map(|near| [seen(near, bounds.low), seen(near, bounds.high)]);
        let edges = edges.as_flattened();
        let lowest = edges.iter().copied().fold(f32::INFINITY, f32::min);
        let highest = edges.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        // Its sides are seen widest where they are nearest.
        let (across, away) = (bounds.level, distance - bounds.high.max(0.0) * sin);
        let half = across / libm::sqrtf((away * away - across * across).max(1e-6));
        let scale = FILLED * (rect.width() / (2.0 * half)).min(rect.height() / (highest - lowest).max(1e-6));
        let scale = scale * stand.zoom;
        let lift = vec2(0.0, f32::midpoint(lowest, highest) * scale);
        let centre = rect.center() + stand.shift * rect.size() + lift;
        Self { eye: from * distance, right, up, ahead, centre, scale }
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

    const BOUNDS: Bounds = Bounds { level: 1.5, low: -0.2, high: 0.2 };

    fn window() -> Rect {
        Rect::from_min_size(pos2(0.0, 0.0), vec2(100.0, 100.0))
    }

    fn from(azimuth: f32, tilt: f32) -> Camera {
        Camera::new(&Stand { azimuth, tilt, ..Stand::default() }, window(), BOUNDS)
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
            assert!((camera.place(Vec3::ZERO) - north.place(Vec3::ZERO)).length() < 1e-3);
        }
    }

    #[test]
    fn places_are_seen_in_the_proportions_of_a_pinhole() {
        let camera = from(180.0, 89.999);
        let distance = 2.8 * libm::hypotf(1.5, 0.2);
        let off = |z: f32| camera.place(Vec3::new(0.5, 0.0, z)).x - 50.0;
        assert!((off(1.0) / off(0.0) - distance / (distance - 1.0)).abs() < 1e-4);
    }

    #[test]
    fn all_of_it_is_in_view_from_everywhere_and_fills_it() {
        for shape in [vec2(100.0, 100.0), vec2(900.0, 200.0), vec2(100.0, 700.0)] {
            let rect = Rect::from_min_size(pos2(30.0, 40.0), shape);
            for bounds in [BOUNDS, Bounds { level: 1.2, low: -9.0, high: 9.0 }] {
                for tilt in [5.0f32, 35.0, 60.0, 89.0] {
                    let mut seen = Rect::NOTHING;
                    for turn in 0..36u8 {
                        let stand = Stand { azimuth: f32::from(turn) * 10.0, tilt, ..Stand::default() };
                        let camera = Camera::new(&stand, rect, bounds);
                        for z in [bounds.low, bounds.high] {
                            let pos = camera.place(Vec3::new(bounds.level, 0.0, z));
                            assert!(rect.contains(pos), "{pos} at {tilt}° in {rect}");
                            seen.extend_with(pos);
                        }
                    }
                    let filled = (seen.width() / rect.width()).max(seen.height() / rect.height());
                    assert!(filled > 0.85, "{filled} at {tilt}° in {rect}");
                }
            }
        }
    }
}
