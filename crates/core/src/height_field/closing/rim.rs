//! The border of the centers of discs: arcs, sides and corners, and the nearest of them to a place.

use rayon::prelude::*;

use super::TIE;
use super::cells::Cells;
use super::finder::Finder;
use super::shell::{Shell, buckets_of, index_of};
use super::vectors::{Place, cross, dot, length, minus, plus};
use crate::raster::BitGrid;

/// The border of E, as far as it is near that of the closing.
#[derive(Debug, Clone)]
pub(super) struct Rim {
    pub(super) radius: f64,
    arcs: Vec<Arc>,
    sides: Vec<Side>,
    /// Places where two of them meet.
    pub(super) corners: Vec<Place>,
    buckets: [usize; 2],
    /// What may be the nearest of E to places of each square of the radius.
    in_bucket: Vec<Vec<Piece>>,
}

#[derive(Debug, Clone, Copy)]
pub(super) enum Piece {
    Arc(u32),
    Side(u32),
    Corner(u32),
}

/// Centers of discs that touch a corner of a footprint: counter-clockwise between two directions; all where they are none.
#[derive(Debug, Clone, Copy)]
pub(super) struct Arc {
    pub(super) around: Place,
    pub(super) between: Option<[Place; 2]>,
}

/// Centers of discs that touch an edge on its left.
#[derive(Debug, Clone, Copy)]
pub(super) struct Side {
    pub(super) edge: [Place; 3],
    pub(super) from: f64,
    pub(super) to: f64,
}

impl Arc {
    pub(super) fn has(&self, toward: Place) -> bool {
        let Some([first, last]) = self.between else { return true };
        let is_less_than_half = cross(first, last) > 0.0 || (cross(first, last) == 0.0 && dot(first, last) > 0.0);
        match is_less_than_half {
            true => cross(first, toward) >= 0.0 && cross(toward, last) >= 0.0,
            false => !(cross(last, toward) > 0.0 && cross(toward, first) > 0.0),
        }
    }
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
        let mut rim = Rim {
            radius: shell.radius,
            arcs: around.into_iter().flat_map(|found| found.0).collect(),
            sides: beside.into_iter().flat_map(|found| found.0).collect(),
            corners,
            buckets: shell.squares,
            in_bucket: vec![Vec::new(); shell.squares[0] * shell.squares[1]],
        };
        let r = rim.radius;
        for k in 0..rim.arcs.len() {
            rim.add(Piece::Arc(index_of(k)), [rim.arcs[k].around; 2], 2.0 * r);
        }
        for k in 0..rim.sides.len() {
            let Side { edge: [from, along, normal], from: start, to: end } = rim.sides[k];
            let at = |t: f64| plus(plus(from, t, along), r, normal);
            rim.add(Piece::Side(index_of(k)), [at(start), at(end)], r);
        }
        for k in 0..rim.corners.len() {
            rim.add(Piece::Corner(index_of(k)), [rim.corners[k]; 2], r);
        }
        rim
    }

    pub(super) fn add(&mut self, piece: Piece, ends: [Place; 2], margin: f64) {
        buckets_of(self.buckets, self.radius, ends, margin).for_each(|bucket| self.in_bucket[bucket].push(piece));
    }

    /// The center of a disc that holds a place, on the border of E; `None` if no disc does.
    ///
    /// A place outside of E that a disc holds is also held by the disc around the nearest place of E, which is one of these.
    pub(super) fn disc_over(&self, place: Place) -> Option<Place> {
        let bucket = buckets_of(self.buckets, self.radius, [place; 2], 0.0).next()?;
        let most = self.radius - TIE;
        self.in_bucket[bucket].iter().find_map(|piece| match piece {
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
