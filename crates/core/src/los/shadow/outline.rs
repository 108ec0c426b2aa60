//! The shadow of one caster: the half-planes whose intersection it is. The derivation is in the
//! essay of [`super`].

use super::geometry::{as_f64, cross, sub};
use super::plane::Plane;
use super::reach::{Bend, FAR, Reach};

/// Relative error of a computed bound, measured on the sum of the magnitudes of its terms.
///
/// With u = 2^-53: the reciprocal of the step and the division by the edge's dy err by 2u. The
/// offset K errs by 3u (one conversion, the factor f, one product), and their product by u more.
/// The slope errs by u more than the reciprocal, and each of the sums by u. Together that is less
/// than 8u of all magnitudes. The rest, as much again, covers adding the margin itself.
pub(super) const ROUNDING: f64 = 1.0 / (1_u64 << 49) as f64;

/// Least extent of a bent edge to the north or south \[lattice steps\].
const FLATTEST: f64 = 1e-100;

/// Cells `first.0..first.1` and so on of a row: those that are surely hidden, and those that may be.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rows {
    pub(super) maybe: (usize, usize),
    pub(super) sure: (usize, usize),
}

/// A bound on the columns of a shadow: `at + per_q · q`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line {
    pub(super) at: f64,
    pub(super) per_q: f64,
}

/// A bound on a curved earth. Its offsets \[columns\] are inward for cells surely inside, and
/// outward for cells that may be inside.
#[derive(Debug, Clone, Copy)]
pub(super) struct BentLine {
    pub(super) at: f64,
    pub(super) per_q: f64,
    pub(super) inward: f64,
    pub(super) outward: f64,
}

/// The half-planes of one shadow.
#[derive(Debug, Default)]
pub(super) struct Outline {
    /// Lines that bound it in the west.
    pub(super) west: Vec<Line>,
    /// Lines that bound it in the east.
    pub(super) east: Vec<Line>,
    /// Bounds in the west and in the east on a curved earth.
    pub(super) bent_west: Vec<BentLine>,
    pub(super) bent_east: Vec<BentLine>,
    /// Cells nearer to a line than this are in doubt \[columns\].
    pub(super) margin: f64,
    south: f64,
    north: f64,
    /// Western and eastern end of the hidden cells, east of the UAV \[lattice steps\].
    extent: (f64, f64),
}

/// Upper bound on the sum of the magnitudes of a bound's terms.
#[derive(Debug, Default)]
pub(super) struct Magnitude(f64);

impl Outline {
    /// Makes this the outline of the shadow of a convex counterclockwise ring within `bounds`
    /// (west, south, east, north). Returns `false` if it has no wanted cell.
    #[inline(always)]
    pub(super) fn cast(&mut self, plane: &Plane, ring: &[[i32; 2]], bounds: [i32; 4], reach: Reach) -> bool {
        let (ux, uy) = (plane.uav.x, plane.uav.y);
        let (near, far) = (reach.near, reach.far);
        if !self.begin(plane, reach.extent(bounds, (ux, uy))) {
            return false;
        }
        let mut magnitude = Magnitude::default();
        let from_uav = |v: [i32; 2]| [i64::from(v[0]) - ux, i64::from(v[1]) - uy];
        let n = ring.len();
        let mut a = from_uav(ring[n - 1]);
        let mut edge = sub(a, from_uav(ring[n - 2]));
        let mut was_facing = cross(edge, a) > 0;
        for &vertex in ring {
            let b = from_uav(vertex);
            edge = sub(b, a);
            let k = cross(edge, a);
            #[expect(clippy::cast_precision_loss, reason = "rounded once, within the margin")]
            let offset = k as f64;
            let is_facing = k > 0;
            if is_facing {
                self.add(plane, edge, near * offset, &mut magnitude);
            } else if k == 0 {
                self.add(plane, edge, 0.0, &mut magnitude);
            } else if let Some(bend) = &reach.bend {
                self.add_bent(plane, bend, edge, offset);
            } else if far < f64::INFINITY {
                self.add(plane, edge, far * offset, &mut magnitude);
            }
            if was_facing != is_facing {
                // The tangent from the UAV, which keeps the footprint on its left.
                let along = if was_facing { a } else { [-a[0], -a[1]] };
                self.add(plane, along, 0.0, &mut magnitude);
            }
            was_facing = is_facing;
            a = b;
        }
        self.finish(plane, &magnitude)
    }

    /// Makes this an outline around everything that a convex counterclockwise ring may hide from
    /// any receiver of a tile. The plane is that of the tile's south-western corner; `size` is its
    /// extent to the east and the north. Returns `false` if no wanted position is in it.
    ///
    /// The half-plane of an edge, E × (p − r) > s·K with K = E × (a − r), is linear in the receiver
    /// r. So the least of the corners' bounds holds for the whole tile, if the edge faces all
    /// corners.
    ///
    /// The sides are the tangents of a corner that have the footprint on one side and the whole
    /// tile on the other. A ray that begins in the tile and passes the footprint is beyond such a
    /// line from there on. Where tile and footprint overlap there is none. The end of the shadow is
    /// ignored.
    #[inline(always)]
    pub(super) fn cast_around(
        &mut self,
        plane: &Plane,
        size: [i64; 2],
        ring: &[[i32; 2]],
        bounds: [i32; 4],
        reach: Reach,
    ) -> bool {
        let (ux, uy) = (plane.uav.x, plane.uav.y);
        // From one side of the tile to the other each bound is monotone (its slopes are 1 − near
        // and 1 − far, both at most 0), so it is extreme at one of them.
        let [w, s, e, n] = reach.extent(bounds, (ux, uy));
        let [other_w, other_s, other_e, other_n] = reach.extent(bounds, (ux + size[0], uy + size[1]));
        let (dx, dy) = (as_f64(size[0]), as_f64(size[1]));
        let extent = [w.min(other_w + dx), s.min(other_s + dy), e.max(other_e + dx), n.max(other_n + dy)];
        if !self.begin(plane, extent) {
            return false;
        }
        let mut magnitude = Magnitude::default();
        let from_tile = |v: [i32; 2]| [i64::from(v[0]) - ux, i64::from(v[1]) - uy];
        let corners = [[0, 0], [size[0], 0], size, [0, size[1]]];
        // E × (a − r) at the corners differs from that at the first by E × r.
        let shifts = |edge: [i64; 2]| {
            let (to_east, to_north) = (-edge[1] * size[0], edge[0] * size[1]);
            [0, to_east, to_east + to_north, to_north]
        };
        // One bit for each corner that an edge from `a` faces.
        let facing =
            |k: i64, shifts: [i64; 4]| (0..4).fold(0_u8, |bits, corner| bits | u8::from(k > shifts[corner]) << corner);
        let n = ring.len();
        let mut a = from_tile(ring[n - 1]);
        let last = sub(a, from_tile(ring[n - 2]));
        let mut was_facing = facing(cross(last, a), shifts(last));
        for &vertex in ring {
            let b = from_tile(vertex);
            let edge = sub(b, a);
            let (k, shifts) = (cross(edge, a), shifts(edge));
            let is_facing = facing(k, shifts);
            if is_facing == 0b1111 {
                let most = shifts[1].max(0) + shifts[3].max(0);
                let (at, shift) = (reach.near * as_f64(k), (1.0 - reach.near) * as_f64(most));
                // EXACT: 1 − near errs by a rounding of near, not of itself. But the edge faces all
                // corners, so k > most and near·most is below `at`. With u = 2^-53 the sum errs by
                // less than 5u of both sizes, the slack is 16u.
                let slack = ROUNDING * (at.abs() + shift.abs());
                self.add(plane, edge, at + shift - slack, &mut magnitude);
            }
            let turned = was_facing ^ is_facing;
            if turned != 0 {
                for (k, corner) in corners.iter().enumerate() {
                    let toward = sub(a, *corner);
                    let along = if was_facing >> k & 1 != 0 { toward } else { [-toward[0], -toward[1]] };
                    let is_side = corners.iter().fold(turned >> k & 1 != 0, |is_side, other| {
                        is_side & (cross(along, sub(*other, *corner)) <= 0)
                    });
                    if is_side {
                        self.add(plane, along, as_f64(cross(along, *corner)), &mut magnitude);
                    }
                }
            }
            was_facing = is_facing;
            a = b;
        }
        self.finish(plane, &magnitude)
    }

    /// Begins an outline within `extent` (west, south, east, north of the UAV). Returns `false` if
    /// no wanted cell is near.
    #[inline(always)]
    pub(super) fn begin(&mut self, plane: &Plane, [west, south, east, north]: [f64; 4]) -> bool {
        (self.south, self.north) = (south, north);
        self.extent = (west, east);
        if !plane.overlaps([west, south, east, north]) {
            return false;
        }
        self.west.clear();
        self.east.clear();
        self.bent_west.clear();
        self.bent_east.clear();
        true
    }

    /// Ends an outline; returns `false` if it is empty.
    #[inline(always)]
    pub(super) fn finish(&mut self, plane: &Plane, magnitude: &Magnitude) -> bool {
        self.margin = ROUNDING * (magnitude.0 + plane.origin.abs() + 1.0) + plane.unevenness;
        self.south <= self.north
    }

    /// Empties the outline.
    pub(super) fn close(&mut self) {
        self.south = f64::INFINITY;
    }

    /// Adds the half-plane `cross(edge, p − u) > k`.
    #[inline(always)]
    pub(super) fn add(&mut self, plane: &Plane, edge: [i64; 2], k: f64, magnitude: &mut Magnitude) {
        #[expect(clippy::cast_precision_loss, reason = "rounded once if at all, within the margin")]
        let (ex, ey) = (edge[0] as f64, edge[1] as f64);
        if edge[1] == 0 {
            let bound = k / ex;
            if edge[0] > 0 {
                self.south = self.south.max(bound);
            } else {
                self.north = self.north.min(bound);
            }
            return;
        }
        let reciprocal = plane.per_step / ey;
        let (at, per_q) = (-k * reciprocal, ex * reciprocal);
        magnitude.0 = magnitude.0.max(at.abs() + per_q.abs() * plane.q_max);
        let line = Line { at: at + plane.origin, per_q };
        if edge[1] > 0 {
            self.east.push(line);
        } else {
            self.west.push(line);
        }
    }

    /// Adds the end of a shadow on a curved earth behind an edge with its `K`.
    #[inline(never)]
    fn add_bent(&mut self, plane: &Plane, bend: &Bend, edge: [i64; 2], k: f64) {
        #[expect(clippy::cast_precision_loss, reason = "differences of at most 2^33")]
        let far = bend.far_edge(edge.map(|v| v as f64), k);
        let [ex, mut ey] = far.edge;
        // Replaces a line along the rows by one that equals it within all margins.
        if ey.abs() < FLATTEST {
            ey = FLATTEST;
        }
        let reciprocal = plane.per_step / ey;
        let middle = if far.maybe.is_finite() { 0.5 * (far.sure + far.maybe) } else { far.sure };
        let (at, per_q) = (-middle * reciprocal, ex * reciprocal);
        let columns = plane.origin.abs() + plane.last_column;
        let terms = at.abs() + (far.terms[0] * plane.q_max + far.terms[1] * columns * plane.step) * reciprocal.abs();
        let rounding = 4.0 * ROUNDING * (terms + columns + 1.0) + plane.unevenness;
        let margin = |to: f64| (to - middle).abs() * reciprocal.abs() + rounding;
        let is_known = far.sure.is_finite();
        let line = BentLine {
            at: if is_known { at + plane.origin } else { 0.0 },
            per_q: if is_known { per_q } else { 0.0 },
            inward: if is_known { margin(far.sure) } else { f64::INFINITY },
            outward: margin(far.maybe),
        };
        if ey > 0.0 {
            self.bent_east.push(line);
        } else {
            self.bent_west.push(line);
        }
    }

    /// Returns the rows that the shadow may meet, and the rows that surely lie between its
    /// horizontal lines.
    #[inline(always)]
    pub(super) fn rows(&self, plane: &Plane) -> Rows {
        // A horizontal bound is one division of a product, so it errs by well less than the same
        // margin.
        let (north_margin, south_margin) = (ROUNDING * self.north.abs(), ROUNDING * self.south.abs());
        let first = plane.first_row_at_or_below(self.north + north_margin);
        let mut first_sure = first;
        while first_sure < plane.rows.1 && plane.q[first_sure] >= self.north - north_margin {
            first_sure += 1;
        }
        let end_sure = plane.first_row_at_or_below(self.south + south_margin);
        let mut end = end_sure;
        while end < plane.rows.1 && plane.q[end] >= self.south - south_margin {
            end += 1;
        }
        Rows { maybe: (first, end), sure: (first_sure, end_sure) }
    }

    /// Returns the columns that enclose all cells that the shadow may meet in rows `first` to
    /// `last`.
    #[inline(always)]
    pub(super) fn columns_between(&self, plane: &Plane, first: usize, last: usize) -> Option<(usize, usize)> {
        let (a, b) = (plane.q[first], plane.q[last]);
        let ends = |l: &Line| (l.at + l.per_q * a, l.at + l.per_q * b);
        let bent_ends = |l: &BentLine| (l.at + l.per_q * a, l.at + l.per_q * b);
        let mut west = self.west.iter().map(ends).fold(-FAR, |w, (a, b)| w.max(a.min(b))) - self.margin;
        let mut east = self.east.iter().map(ends).fold(FAR, |e, (a, b)| e.min(a.max(b))) + self.margin;
        for line in &self.bent_west {
            let (a, b) = bent_ends(line);
            west = west.max(a.min(b) - line.outward);
        }
        for line in &self.bent_east {
            let (a, b) = bent_ends(line);
            east = east.min(a.max(b) + line.outward);
        }
        let (west, east) = (west - 1.0, east + 1.0);
        plane.wanted_columns(west, east)
    }

    /// Returns the columns that enclose all cells that the shadow may meet.
    #[inline(always)]
    pub(super) fn columns(&self, plane: &Plane) -> Option<(usize, usize)> {
        let column = |east: f64| east * plane.per_step + plane.origin;
        let slack = self.margin + 1.0;
        plane.wanted_columns(column(self.extent.0) - slack, column(self.extent.1) + slack)
    }
}
