//! Where a vector scene knows the ground: between its footprints, not beyond the last house.
//!
//! Footprints say nothing of the ground far from them: it may be fields, a lake, or a town whose houses the file leaves out.
//! So a scene of footprints holds data within their *closing* by a disc of 100 m: all ground that no disc of this radius
//! reaches without meeting a footprint. Enclosed holes (parks, squares) are filled.
//!
//! The closing is found on square cells: those that a footprint overlaps are grown by the disc, and what is left is grown
//! back. Its border is true to about a cell.

use crate::city::{Area, Footprint};
use crate::outlines::{labelled_parts, overlapped_cells};
use crate::quantity::{Frame, STEPS_PER_UNIT};
use crate::raster::{BitGrid, GeoRef};

/// Radius of the disc that closes the footprints \[m\].
const RADIUS_M: f64 = 100.0;

/// Cells of the closing along the longer side of the footprints, unless those of the receivers are larger.
const CELLS_PER_SIDE: f64 = 1024.0;

/// The ground that is known, for any grid of receivers.
#[derive(Debug, Clone)]
pub(super) enum KnownGround {
    /// Cells of a grid of its own, on the lattice of the footprints.
    Cells(KnownCells),
    /// An area that the user drew.
    Area(Area),
}

/// A set of square cells on a lattice.
#[derive(Debug, Clone)]
pub(super) struct KnownCells {
    frame: Frame,
    /// South-west corner and side of a cell \[lattice steps\].
    corner: [i64; 2],
    side: i64,
    cells: BitGrid,
}

impl KnownCells {
    /// The column that holds a world x, if there is one.
    fn col_at(&self, x: f64) -> Option<usize> {
        let (x, _) = self.frame.lattice_from_world(x, self.frame.y_origin);
        let col = usize::try_from((x - self.corner[0]).div_euclid(self.side)).ok()?;
        (col < self.cells.n_cols()).then_some(col)
    }

    /// The row, from the north, that holds a world y, if there is one.
    fn row_at(&self, y: f64) -> Option<usize> {
        let (_, y) = self.frame.lattice_from_world(self.frame.x_origin, y);
        let from_south = usize::try_from((y - self.corner[1]).div_euclid(self.side)).ok()?;
        self.cells.n_rows().checked_sub(from_south + 1)
    }
}

impl KnownGround {
    /// The closing of footprints on the lattice of `frame`, for a grid of receivers; `None` without footprints.
    pub(super) fn near(footprints: &[Footprint], frame: &Frame, receivers: &GeoRef) -> Option<Self> {
        let unit = f64::from(STEPS_PER_UNIT);
        let radius = RADIUS_M / receivers.meters_per_unit();
        // All of them, wherever the receivers are: houses far beyond may close the ring around a park.
        let points = || footprints.iter().flat_map(|f| f.polygons.iter().flatten().flatten());
        let range = |k: usize| {
            let values = || points().map(|p| i64::from(p[k]));
            Some((values().min()?, values().max()?))
        };
        let ((west, east), (south, north)) = (range(0)?, range(1)?);
        #[expect(clippy::cast_precision_loss, reason = "an extent on the lattice")]
        let longer = (east - west).max(north - south) as f64 / unit + 2.0 * radius;
        let cell = receivers.cell_width().min(receivers.cell_height()).max(longer / CELLS_PER_SIDE).min(radius / 4.0);
        // A whole number of lattice steps, so that footprints fall into cells exactly.
        #[expect(clippy::cast_possible_truncation, reason = "at most 25 m")]
        let steps = ((cell * unit).round() as i64).max(1);
        #[expect(clippy::cast_precision_loss, reason = "at most 25 m")]
        let cell = steps as f64 / unit;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "100 m in cells")]
        let reach = (radius / cell).round() as u16;
        let margin = (i64::from(reach) + 2) * steps;
        let (x0, y0) = (west - margin, south - margin);
        let count = |from: i64, to: i64| usize::try_from((to + margin - from) / steps + 1).ok();
        let (n_cols, n_rows) = (count(x0, east)?, count(y0, north)?);
        let mut built = BitGrid::new(n_rows, n_cols);
        let moved = |p: &[i32; 2]| [i64::from(p[0]) - x0, i64::from(p[1]) - y0];
        for footprint in footprints {
            let ring = |ring: &Vec<[i32; 2]>| ring.iter().map(moved).collect::<Vec<_>>();
            let polygons: Vec<Vec<Vec<[i64; 2]>>> =
                footprint.polygons.iter().map(|rings| rings.iter().map(ring).collect()).collect();
            overlapped_cells(&polygons, [steps; 2], (n_rows, n_cols), |row, cols| {
                cols.for_each(|col| built.insert(row, col));
            });
        }
        let closed = filled(&grown(&grown(&built, reach).complement(), reach).complement());
        Some(KnownGround::Cells(KnownCells { frame: *frame, corner: [x0, y0], side: steps, cells: closed }))
    }

    /// Whether it holds a position \[CRS units\].
    pub(super) fn contains(&self, x: f64, y: f64) -> bool {
        match self {
            KnownGround::Area(area) => area.contains(x, y),
            KnownGround::Cells(known) => match (known.row_at(y), known.col_at(x)) {
                (Some(row), Some(col)) => known.cells.contains(row, col),
                _ => false,
            },
        }
    }

    /// The cells of a grid of receivers whose centers it does not hold.
    pub(super) fn outside(&self, receivers: &GeoRef) -> BitGrid {
        match self {
            KnownGround::Area(area) => area.cells(receivers).complement(),
            KnownGround::Cells(known) => {
                let col = |col| known.col_at(receivers.world_from_cell(0, col).0);
                let cols: Vec<Option<usize>> = (0..receivers.n_cols()).map(col).collect();
                let mut outside = BitGrid::full(receivers.n_rows(), receivers.n_cols());
                for row in 0..receivers.n_rows() {
                    let Some(known_row) = known.row_at(receivers.world_from_cell(row, 0).1) else { continue };
                    for (col, known_col) in cols.iter().enumerate() {
                        if known_col.is_some_and(|known_col| known.cells.contains(known_row, known_col)) {
                            outside.set(row, col, false);
                        }
                    }
                }
                outside
            }
        }
    }
}

/// The cells whose centers are at most `radius` cells from the center of a cell of a set.
fn grown(set: &BitGrid, radius: u16) -> BitGrid {
    let (n_rows, n_cols) = (set.n_rows(), set.n_cols());
    // Rows to the nearest cell of the set in each column: from the north, then from the south as well.
    let far = radius.saturating_add(1);
    let mut rows_to_set = vec![far; n_rows * n_cols];
    let mut pass = |rows: &mut dyn Iterator<Item = usize>| {
        let mut last = vec![far; n_cols];
        for row in rows {
            let of_row = &mut rows_to_set[row * n_cols..(row + 1) * n_cols];
            for (col, (nearest, last)) in of_row.iter_mut().zip(&mut last).enumerate() {
                *last = if set.contains(row, col) { 0 } else { last.saturating_add(1).min(far) };
                *nearest = (*nearest).min(*last);
            }
        }
    };
    pass(&mut (0..n_rows));
    pass(&mut (0..n_rows).rev());
    // Columns that a disc covers so many rows from its middle, to each side.
    let half = |dy: u16| (u32::from(radius).pow(2) - u32::from(dy).pow(2)).isqrt() as usize;
    let halves: Vec<usize> = (0..=radius).map(half).collect();
    let mut grown = BitGrid::new(n_rows, n_cols);
    for row in 0..n_rows {
        // Where intervals of covered columns begin, less where they end.
        let mut ends = vec![0_i32; n_cols + 1];
        let of_row = rows_to_set[row * n_cols..(row + 1) * n_cols].iter().enumerate();
        for (col, dy) in of_row.filter(|(_, dy)| **dy <= radius) {
            let half = halves[usize::from(*dy)];
            ends[col.saturating_sub(half)] += 1;
            ends[(col + half + 1).min(n_cols)] -= 1;
        }
        let mut open = 0;
        for (col, change) in ends.iter().take(n_cols).enumerate() {
            open += change;
            if open > 0 {
                grown.insert(row, col);
            }
        }
    }
    grown
}

/// A set with what it encloses: the parts of its complement that do not reach the border of the grid.
fn filled(set: &BitGrid) -> BitGrid {
    let (n_rows, n_cols) = (set.n_rows(), set.n_cols());
    let (labels, sizes) = labelled_parts(&set.complement());
    let mut is_open = vec![false; sizes.len()];
    for cell in 0..labels.len() {
        let (row, col) = (cell / n_cols, cell % n_cols);
        let is_border = row == 0 || row + 1 == n_rows || col == 0 || col + 1 == n_cols;
        if is_border && labels[cell] != u32::MAX {
            is_open[labels[cell] as usize] = true;
        }
    }
    let mut filled = set.clone();
    for (cell, label) in labels.iter().enumerate().filter(|(_, label)| **label != u32::MAX) {
        if !is_open[*label as usize] {
            filled.insert(cell / n_cols, cell % n_cols);
        }
    }
    filled
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
        KnownGround::near(footprints, &frame, receivers).expect("footprints").outside(receivers).complement()
    }

    #[test]
    fn ground_is_known_where_no_disc_fits_between_the_houses() {
        let receivers = GeoRef::new((0.0, 500.0), (1.0, 1.0), (500, 500), None).expect("a valid grid");
        let at = |set: &BitGrid, x: usize, y: usize| set.contains(499 - y, x);
        // Between walls 60 m apart discs reach in by 100 − √(100² − 30²) = 4.6 m from either side: y = 204.6 to 215.4 is left.
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

    #[test]
    fn a_set_grows_by_a_disc() {
        let mut set = BitGrid::new(40, 50);
        let seeds = [(3, 4), (20, 30), (20, 33), (39, 49)];
        seeds.iter().for_each(|(row, col)| set.insert(*row, *col));
        let grown = grown(&set, 7);
        for row in 0..40_usize {
            for col in 0..50_usize {
                let is_near = seeds.iter().any(|(r, c)| row.abs_diff(*r).pow(2) + col.abs_diff(*c).pow(2) <= 49);
                assert_eq!(grown.contains(row, col), is_near, "{row} {col}");
            }
        }
    }

    /// Which side of a border between cells a point is on is decided in integers, wherever the lattice begins.
    #[test]
    fn known_ground_does_not_depend_on_where_the_lattice_begins() {
        let receivers = GeoRef::new((0.0, 500.0), (1.0, 1.0), (500, 500), None).expect("a valid grid");
        let houses = [(100, 200, 20), (180, 200, 20), (300, 40, 11)];
        let around = |[x_origin, y_origin]: [i32; 2]| {
            let frame = Frame { x_origin: x_origin.into(), y_origin: y_origin.into(), unit_x: 1.0, unit_y: 1.0 };
            let footprints = houses.map(|(west, south, side)| house(west - x_origin, south - y_origin, side));
            KnownGround::near(&footprints, &frame, &receivers).expect("footprints").outside(&receivers)
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
