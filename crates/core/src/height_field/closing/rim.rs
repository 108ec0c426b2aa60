//! The border of the centers of discs: arcs, sides and corners, and the nearest of them to a place.

use rayon::prelude::*;

use super::TIE;
use super::cells::Cells;
use super::finder::{Arc, Finder, Side};
use super::grid::whole;
use super::shell::{Shell, index_of};
use super::vectors::{Place, dot, length, minus, plus};
use crate::raster::BitGrid;

/// Squares along the radius, by which pieces of the border are found.
const SQUARES_PER_RADIUS: f64 = 4.0;

/// The border of E, as far as it is near that of the closing.
#[derive(Debug, Clone)]
pub(super) struct Rim {
    pub(super) radius: f64,
    arcs: Vec<Arc>,
    sides: Vec<Side>,
    /// Places where two of them meet.
    pub(super) corners: Vec<Place>,
    /// Columns and rows of squares, and their side.
    squares: [usize; 2],
    side: f64,
    /// Pieces whose discs may hold places of each square.
    in_square: Vec<Vec<Piece>>,
}

#[derive(Debug, Clone, Copy)]
pub(super) enum Piece {
    Arc(u32),
    Side(u32),
    Corner(u32),
}

impl Rim {
    pub(super) fn of(shell: &Shell, cells: &Cells, may_be_center: &BitGrid) -> Rim {
        let finder = Finder { shell, cells, may_be_center };
        let around: Vec<(Vec<Arc>, Vec<Place>)> = shell.points.par_iter().map(|point| finder.around(*point)).collect();
        let beside: Vec<(Vec<Side>, Vec<Place>)> = shell.edges.par_iter().map(|edge| finder.beside(edge)).collect();
        let mut corners: Vec<Place> = around.iter().flat_map(|found| &found.1).copied().collect();
        corners.extend(beside.iter().flat_map(|found| &found.1));
        corners.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
        corners.dedup();
        let side = shell.radius / SQUARES_PER_RADIUS;
        #[expect(clippy::cast_precision_loss, reason = "below 2^27")]
        let squares = [cells.n_cols, cells.n_rows].map(|n| whole(n as f64 * cells.side as f64 / side) + 1);
        let mut rim = Rim {
            radius: shell.radius,
            arcs: around.into_iter().flat_map(|found| found.0).collect(),
            sides: beside.into_iter().flat_map(|found| found.0).collect(),
            corners,
            squares,
            side,
            in_square: vec![Vec::new(); squares[0] * squares[1]],
        };
        let r = rim.radius;
        for k in 0..rim.arcs.len() {
            let arc = rim.arcs[k];
            // Sectors of twice the radius: the box around their ends, and around what they have due
            // east, north, west and south.
            let ends = arc.between.into_iter().flatten();
            let due = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]].into_iter().filter(|u| arc.has(*u));
            let far = ends.chain(due).map(|u| plus(arc.around, 2.0 * r, u));
            rim.add(Piece::Arc(index_of(k)), far.chain([arc.around]), 0.0);
        }
        for k in 0..rim.sides.len() {
            let Side { edge: [from, along, normal], from: start, to: end } = rim.sides[k];
            let at = |t: f64, h: f64| plus(plus(from, t, along), h, normal);
            let far = [at(start, 2.0 * r), at(end, 2.0 * r)];
            rim.add(Piece::Side(index_of(k)), [at(start, 0.0), at(end, 0.0)].into_iter().chain(far), 0.0);
        }
        for k in 0..rim.corners.len() {
            rim.add(Piece::Corner(index_of(k)), [rim.corners[k]].into_iter(), r);
        }
        rim
    }

    /// Adds a piece to the squares that the box around places meets, grown by a margin.
    fn add(&mut self, piece: Piece, places: impl Iterator<Item = Place>, margin: f64) {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for place in places {
            low = [0, 1].map(|k| low[k].min(place[k] - margin - TIE));
            high = [0, 1].map(|k| high[k].max(place[k] + margin + TIE));
        }
        let (first, last) = (self.square_at(low), self.square_at(high));
        for row in first[1]..=last[1] {
            for col in first[0]..=last[0] {
                self.in_square[row * self.squares[0] + col].push(piece);
            }
        }
    }

    /// Returns the column and row of the square that is nearest to a place.
    fn square_at(&self, place: Place) -> [usize; 2] {
        [0, 1].map(|k| whole(place[k] / self.side).min(self.squares[k] - 1))
    }

    /// Returns the center of a disc that holds a place, on the border of E; `None` if no disc does.
    ///
    /// A place outside of E that a disc holds is also held by the disc around the nearest place of
    /// E, which is one of these.
    pub(super) fn disc_over(&self, place: Place) -> Option<Place> {
        let [col, row] = self.square_at(place);
        let most = self.radius - TIE;
        self.in_square[row * self.squares[0] + col].iter().find_map(|piece| match piece {
            Piece::Arc(k) => {
                let arc = &self.arcs[*k as usize];
                let toward = minus(place, arc.around);
                let far = length(toward);
                let is_held = far > 0.0 && (self.radius - far).abs() < most && arc.has(toward);
                is_held.then(|| plus(arc.around, self.radius / far, toward))
            }
            Piece::Side(k) => {
                let Side { edge: [from, along, normal], from: start, to: end } = self.sides[*k as usize];
                let d = minus(place, from);
                let (t, h) = (dot(d, along), dot(d, normal));
                let is_held = (self.radius - h).abs() < most && (start..=end).contains(&t);
                is_held.then(|| plus(plus(from, t, along), self.radius, normal))
            }
            Piece::Corner(k) => {
                let corner = self.corners[*k as usize];
                (length(minus(place, corner)) < most).then_some(corner)
            }
        })
    }
}
