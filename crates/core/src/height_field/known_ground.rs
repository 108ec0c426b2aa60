//! Ground that a vector scene knows: between its footprints, not beyond the last house.
//!
//! Footprints say nothing of the ground far from them: it may be fields, a lake, or a town whose
//! houses the file leaves out. So a scene of footprints holds data within their *closing* by a disc
//! of 100 m: all ground that no disc of this radius reaches without meeting a footprint. Enclosed
//! holes (parks, squares) are filled.

use rayon::prelude::*;

use super::closing::Closing;
use crate::city::{Area, Footprint};
use crate::quantity::{Frame, STEPS_PER_UNIT};
use crate::raster::{BitGrid, GeoRef};

/// Radius of the disc that closes the footprints \[m\].
const RADIUS_M: f64 = 100.0;

/// Cells of the closing along the longer side of the footprints, at least.
const CELLS_PER_SIDE: f64 = 256.0;

/// The ground that is known, for any grid of receivers.
#[derive(Debug, Clone)]
pub(super) enum KnownGround {
    /// The closing of footprints on the lattice of a frame.
    Near(Frame, Box<Closing>),
    /// An area that the user drew.
    Area(Area),
}

impl KnownGround {
    /// Returns the closing of footprints on the lattice of `frame`, in a reference system with so
    /// many meters a unit; `None` without footprints.
    pub(super) fn near(footprints: &[Footprint], frame: &Frame, meters_per_unit: f64) -> Option<Self> {
        let unit = f64::from(STEPS_PER_UNIT);
        // All of them, wherever the receivers are: houses far beyond may close the ring around a
        // park.
        let range = |k: usize| {
            let values =
                || footprints.iter().flat_map(|f| f.polygons.iter().flatten().flatten()).map(|p| i64::from(p[k]));
            Some((values().min()?, values().max()?))
        };
        let ((west, east), (south, north)) = (range(0)?, range(1)?);
        #[expect(clippy::cast_possible_truncation, reason = "a unit has more than a millionth of a meter")]
        let radius = (RADIUS_M / meters_per_unit * unit).round() as i64;
        #[expect(clippy::cast_precision_loss, reason = "an extent on the lattice")]
        let longer = ((east - west).max(north - south) + 2 * radius) as f64;
        #[expect(clippy::cast_possible_truncation, reason = "at most 2^26")]
        let side = ((longer / CELLS_PER_SIDE) as i64).clamp((radius / 100).max(1), (radius / 4).max(1));
        Some(KnownGround::Near(*frame, Box::new(Closing::of(footprints, radius, side)?)))
    }

    /// Returns the share of its area that no footprint covers; 1 of an area that the user drew.
    pub(super) fn open_share(&self) -> f64 {
        match self {
            KnownGround::Area(_) => 1.0,
            KnownGround::Near(_, closing) => closing.open_share(),
        }
    }

    /// Returns whether it holds a position \[CRS units\].
    pub(super) fn contains(&self, x: f64, y: f64) -> bool {
        match self {
            KnownGround::Area(area) => area.contains(x, y),
            KnownGround::Near(frame, closing) => {
                let (x, y) = frame.lattice_from_world(x, y);
                closing.contains([x, y])
            }
        }
    }

    /// Returns the cells of a grid of receivers whose centers it does not hold.
    pub(super) fn outside(&self, receivers: &GeoRef) -> BitGrid {
        let (frame, closing) = match self {
            KnownGround::Area(area) => return area.cells(receivers).complement(),
            KnownGround::Near(frame, closing) => (frame, closing),
        };
        let (n_rows, n_cols) = (receivers.n_rows(), receivers.n_cols());
        let at = |row: usize, col: usize| {
            let (x, y) = receivers.world_from_cell(row, col);
            frame.lattice_from_world(x, y)
        };
        let xs: Vec<i64> = (0..n_cols).map(|col| at(0, col).0).collect();
        let mut outside = BitGrid::new(n_rows, n_cols);
        let per_row = outside.words_per_row();
        outside.words_mut().par_chunks_mut(per_row.max(1)).enumerate().for_each(|(row, words)| {
            let y = at(row, 0).1;
            for (col, x) in xs.iter().enumerate() {
                words[col / 64] |= u64::from(!closing.contains([*x, y])) << (col % 64);
            }
        });
        outside
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::{Crs, CrsDefinition, CrsKind};

    const M: i32 = STEPS_PER_UNIT;

    fn house(west: i32, south: i32, side: i32) -> Footprint {
        let ring = [[west, south], [west + side, south], [west + side, south + side], [west, south + side]];
        let ring = ring.map(|p| p.map(|v| v * M)).to_vec();
        Footprint::on_zero(String::new(), vec![vec![ring]], 10 * M)
    }

    fn known(footprints: &[Footprint], receivers: &GeoRef) -> BitGrid {
        let frame = Frame { x_origin: 0.0, y_origin: 0.0, unit_x: 1.0, unit_y: 1.0 };
        KnownGround::near(footprints, &frame, receivers.meters_per_unit())
            .expect("footprints")
            .outside(receivers)
            .complement()
    }

    #[test]
    fn ground_is_known_where_no_disc_fits_between_the_houses() {
        let receivers = GeoRef::new((0.0, 500.0), (1.0, 1.0), (500, 500), None).expect("a valid grid");
        let at = |set: &BitGrid, x: usize, y: usize| set.contains(499 - y, x);
        // Between walls 60 m apart discs reach in by 100 − √(100² − 30²) = 4.6 m from either side:
        // y = 204.6 to 215.4 is left.
        let near = known(&[house(100, 200, 20), house(180, 200, 20)], &receivers);
        assert!([110, 149, 190].iter().all(|x| at(&near, *x, 210)) && at(&near, 149, 206) && at(&near, 149, 213));
        assert!(!at(&near, 149, 202) && !at(&near, 149, 217) && !at(&near, 90, 210));
        // Between walls 160 m apart they reach in by 40 m, which leaves nothing of 20 m.
        let far = known(&[house(100, 200, 20), house(280, 200, 20)], &receivers);
        assert!(at(&far, 110, 210) && !at(&far, 200, 210));
    }

    #[test]
    fn an_enclosed_park_is_known_and_the_field_beside_it_is_not() {
        let receivers = GeoRef::new((0.0, 900.0), (2.0, 2.0), (450, 450), None).expect("a valid grid");
        let ring: Vec<Footprint> = (0..13)
            .flat_map(|k| [(100 + 50 * k, 100), (100 + 50 * k, 700), (100, 100 + 50 * k), (700, 100 + 50 * k)])
            .map(|(x, y)| house(x, y, 20))
            .collect();
        let known = known(&ring, &receivers);
        let at = |x: usize, y: usize| known.contains(449 - y / 2, x / 2);
        assert!(at(400, 400) && at(110, 410) && !at(50, 400) && !at(760, 400));
        // The mean of the border: the outer walls, 100 to 720 m.
        let area = 4.0 * known.count() as f64;
        assert!((area / (620.0 * 620.0) - 1.0).abs() < 0.02, "{area}");
    }

    /// The answer for a position depends on the footprints alone, wherever the lattice begins.
    #[test]
    fn known_ground_does_not_depend_on_where_the_lattice_begins() {
        let receivers = GeoRef::new((0.0, 500.0), (1.0, 1.0), (500, 500), None).expect("a valid grid");
        let houses = [(100, 200, 20), (180, 200, 20), (300, 40, 11)];
        let around = |[x_origin, y_origin]: [i32; 2]| {
            let frame = Frame { x_origin: x_origin.into(), y_origin: y_origin.into(), unit_x: 1.0, unit_y: 1.0 };
            let footprints = houses.map(|(west, south, side)| house(west - x_origin, south - y_origin, side));
            KnownGround::near(&footprints, &frame, 1.0).expect("footprints").outside(&receivers)
        };
        let from_zero = around([0, 0]);
        assert!(from_zero.count() > 0 && from_zero.count() < 250_000);
        assert!([[-7, 3], [70, 41]].iter().all(|origin| around(*origin) == from_zero));
    }

    /// 100 m are 328 feet: between walls 300 feet apart no such disc fits, one of 100 feet would.
    #[test]
    fn a_scene_in_feet_is_closed_by_a_hundred_meters() {
        let between = |meters_per_unit: f64| {
            let crs = Crs::new(None, "a plane", CrsKind::Projected { meters_per_unit }, CrsDefinition::Described);
            let receivers = GeoRef::new((0.0, 1000.0), (2.0, 2.0), (500, 500), Some(crs)).expect("a valid grid");
            known(&[house(0, 200, 300), house(600, 200, 300)], &receivers).contains(500 - 350 / 2, 450 / 2)
        };
        assert!(between(1200.0 / 3937.0) && !between(1.0));
    }
}
