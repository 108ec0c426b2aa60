//! A z-buffer of triangles: for each sample the nearest face and its depth.
//!
//! A view maps the city to the buffer either in perspective (the picture) or in parallel (the plan,
//! and the sun's view, which finds shadows). In both, `depth` is linear on the screen and larger is
//! nearer: the reciprocal of the distance, or the negative distance. No angle is evaluated, so that
//! the samples are the same on every machine.

use glam::{DVec2, DVec3};

use super::colors;
use super::paint::narrow;

/// Projection of a view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Projection {
    /// Lines of sight meet in the eye.
    Perspective,
    /// Lines of sight are parallel.
    Parallel,
}

/// A view of the city onto a buffer.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View {
    projection: Projection,
    eye: DVec3,
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    scale: f64,
    offset: DVec2,
}

impl View {
    /// Makes a view along `forward` from `eye` with `up` roughly upward.
    pub(crate) fn new(projection: Projection, eye: DVec3, forward: DVec3, up: DVec3) -> Self {
        let forward = forward.normalize();
        let right = forward.cross(up).normalize();
        Self { projection, eye, right, up: right.cross(forward), forward, scale: 1.0, offset: DVec2::ZERO }
    }

    /// Scales and moves the view so that the given points fill `size` \[px\] up to a margin;
    /// returns the size used.
    pub(crate) fn fit(&mut self, points: impl Iterator<Item = DVec3>, size: DVec2, margin: f64) -> DVec2 {
        (self.scale, self.offset) = (1.0, DVec2::ZERO);
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for point in points {
            let at = self.project(point).truncate();
            (low, high) = (low.min(at), high.max(at));
        }
        let span = (high - low).max(DVec2::splat(1e-9));
        let room = size - 2.0 * margin;
        self.scale = (room.x / span.x).min(room.y / span.y);
        let used = span * self.scale + 2.0 * margin;
        self.offset = DVec2::splat(margin) - low * self.scale;
        used
    }

    /// Returns screen position \[px\], y down, and depth.
    pub(crate) fn project(&self, point: DVec3) -> DVec3 {
        let from_eye = point - self.eye;
        let distance = from_eye.dot(self.forward);
        let (nearness, depth) = match self.projection {
            Projection::Perspective => (1.0 / distance, 1.0 / distance),
            Projection::Parallel => (1.0, -distance),
        };
        let x = from_eye.dot(self.right) * nearness * self.scale + self.offset.x;
        let y = -from_eye.dot(self.up) * nearness * self.scale + self.offset.y;
        DVec3::new(x, y, depth)
    }

    /// Returns the point at a screen position and depth.
    pub(crate) fn unproject(&self, at: DVec3) -> DVec3 {
        let x = (at.x - self.offset.x) / self.scale;
        let y = (self.offset.y - at.y) / self.scale;
        let (distance, spread) = match self.projection {
            Projection::Perspective => (1.0 / at.z, 1.0 / at.z),
            Projection::Parallel => (-at.z, 1.0),
        };
        self.eye + self.forward * distance + (self.right * x + self.up * y) * spread
    }

    /// Returns `true` when a face at `point` with this normal is turned to the viewer.
    pub(crate) fn sees(&self, point: DVec3, normal: DVec3) -> bool {
        match self.projection {
            Projection::Perspective => normal.dot(self.eye - point) > 0.0,
            Projection::Parallel => normal.dot(self.forward) < 0.0,
        }
    }

    /// Returns the screen direction \[px\] of a world direction, ignoring perspective.
    pub(crate) fn direction(&self, direction: DVec3) -> DVec2 {
        DVec2::new(direction.dot(self.right), -direction.dot(self.up))
    }

    /// Returns the same view on a screen with `factor` times as many pixels a side.
    pub(crate) fn magnified(self, factor: f64) -> Self {
        Self { scale: self.scale * factor, offset: self.offset * factor, ..self }
    }
}

/// Returns the whole samples of a buffer of this size, from 1 to 4000 a side.
pub(crate) fn samples(size: DVec2) -> [usize; 2] {
    [size.x, size.y].map(|side| colors::index(side.ceil(), 4000).max(1))
}

/// Nearest face and its depth per sample.
#[derive(Debug)]
pub(crate) struct ZBuffer {
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// Depth; larger is nearer, negative infinity in an empty sample.
    pub(crate) depth: Vec<f32>,
    /// Tag of the face; 0 in an empty sample.
    pub(crate) tag: Vec<u64>,
}

impl ZBuffer {
    pub(crate) fn new(width: usize, height: usize) -> Self {
        Self { width, height, depth: vec![f32::NEG_INFINITY; width * height], tag: vec![0; width * height] }
    }

    /// Draws a triangle given in screen coordinates; a sample counts if its center is inside.
    pub(crate) fn triangle(&mut self, corners: [DVec3; 3], tag: u64) {
        let [a, b, c] = corners;
        let area = (b - a).truncate().perp_dot((c - a).truncate());
        let low = a.min(b).min(c);
        let high = a.max(b).max(c);
        if area.abs() < 1e-12 || !area.is_finite() {
            return;
        }
        let (Some(columns), Some(rows)) = (span(low.x, high.x, self.width), span(low.y, high.y, self.height)) else {
            return;
        };
        // Depth is a plane over the screen, and each edge a half-plane; all three step by constants along a row.
        let depth_step = DVec2::new(
            ((b.z - a.z) * (c.y - a.y) - (c.z - a.z) * (b.y - a.y)) / area,
            ((c.z - a.z) * (b.x - a.x) - (b.z - a.z) * (c.x - a.x)) / area,
        );
        let sign = area.signum();
        let edges = [(a, b), (b, c), (c, a)].map(|(from, to)| (from.truncate(), (to - from).truncate() * sign));
        for row in rows {
            let y = center(row);
            // The samples of a row inside the triangle form one interval.
            let (mut left, mut right) = (columns.start as f64, columns.end as f64 - 1.0);
            for (from, along) in edges {
                let at_left = along.x * (y - from.y) - along.y * (center(columns.start) - from.x);
                // Inside: at_left - along.y * steps >= 0.
                if along.y > 0.0 {
                    right = right.min(columns.start as f64 + (at_left / along.y).floor());
                } else if along.y < 0.0 {
                    left = left.max(columns.start as f64 + (at_left / along.y).ceil());
                } else if at_left < 0.0 {
                    right = -1.0;
                }
            }
            if left > right {
                continue;
            }
            let (first, last) = (colors::index(left, self.width), colors::index(right, self.width));
            let depth_at_first = a.z + depth_step.x * (center(first) - a.x) + depth_step.y * (y - a.y);
            let samples = row * self.width + first..=row * self.width + last;
            let (depths, tags) = (&mut self.depth[samples.clone()], &mut self.tag[samples]);
            for (k, (old_depth, old_tag)) in depths.iter_mut().zip(tags).enumerate() {
                let depth = narrow(depth_at_first + depth_step.x * k as f64);
                if depth > *old_depth {
                    (*old_depth, *old_tag) = (depth, tag);
                }
            }
        }
    }
}

/// Returns the place of the center of a sample along a row or a column.
fn center(sample: usize) -> f64 {
    sample as f64 + 0.5
}

/// Returns the samples whose centers lie between two positions; `None` if there are none.
fn span(low: f64, high: f64, n: usize) -> Option<std::ops::Range<usize>> {
    let first = (low - 0.5).ceil().max(0.0);
    let last = (high - 0.5).floor().min(n as f64 - 1.0);
    (first <= last).then(|| colors::index(first, n)..colors::index(last, n) + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depth_is_interpolated_in_the_plane() {
        let mut buffer = ZBuffer::new(4, 4);
        buffer.triangle([[0.0, 0.0, 0.0], [8.0, 0.0, 8.0], [0.0, 8.0, 16.0]].map(DVec3::from), 7);
        assert!((buffer.depth[0] - 1.5).abs() < 1e-6);
        assert!((buffer.depth[4 * 2 + 1] - 6.5).abs() < 1e-6);
    }

    #[test]
    fn unprojecting_undoes_projecting() {
        for projection in [Projection::Perspective, Projection::Parallel] {
            let eye = DVec3::new(-300.0, -500.0, 400.0);
            let mut view = View::new(projection, eye, -eye, DVec3::Z);
            let corners = [[-100.0, -100.0, 0.0], [100.0, 100.0, 50.0], [100.0, -100.0, 0.0]].map(DVec3::from);
            let used = view.fit(corners.into_iter(), DVec2::new(640.0, 480.0), 10.0);
            assert!(used.x <= 640.0 + 1e-9 && used.y <= 480.0 + 1e-9);
            for corner in corners {
                let at = view.project(corner);
                assert!(at.x > 9.9 && at.x < 630.1 && at.y > 9.9 && at.y < 470.1);
                assert!(view.unproject(at).distance(corner) < 1e-6);
            }
        }
    }
}
