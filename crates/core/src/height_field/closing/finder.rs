//! How the border of the centers of discs is found, corner by corner and edge by edge.

use super::TIE;
use super::cells::Cells;
use super::rim::{Arc, Side};
use super::shell::{Edge, Shell, holds_near, steps};
use super::vectors::{Place, between, dot, length, minus, plus, turn};
use crate::raster::BitGrid;

/// What finds pieces of the border of E.
pub(super) struct Finder<'a> {
    pub(super) shell: &'a Shell,
    pub(super) cells: &'a Cells,
    /// Cells that may hold points of E.
    pub(super) may_be_center: &'a BitGrid,
}

impl Finder<'_> {
    /// Whether a place may be in E, by its cell; what is not is within the radius of a footprint.
    pub(super) fn may_be_center(&self, place: Place) -> bool {
        holds_near(self.cells, self.may_be_center, place)
    }

    pub(super) fn is_center(&self, place: Place) -> bool {
        self.may_be_center(place) && !self.shell.covers(place)
    }

    /// Roots of t² = a square, one where they are less than can be told apart.
    pub(super) fn roots(&self, square: f64) -> impl Iterator<Item = f64> + use<> {
        let least = 4.0 * self.shell.radius * TIE;
        let root = (square > least).then(|| square.sqrt());
        let one = (square.abs() <= least).then_some(0.0);
        root.into_iter().flat_map(|root| [-root, root]).chain(one)
    }

    /// The arcs of E around a point, and where they meet others.
    pub(super) fn around(&self, point: Place) -> (Vec<Arc>, Vec<Place>) {
        let Shell { radius: r, points, edges, .. } = self.shell;
        let r = *r;
        let circle = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]].map(|u| plus(point, r, u));
        let is_near = (0..4).any(|k| {
            // Quarter by quarter, by chords of places on the circle.
            let (a, b) = (minus(circle[k], point), minus(circle[(k + 1) % 4], point));
            steps(self.cells, 2.0 * r).any(|t| {
                let u = plus([a[0] * (1.0 - t), a[1] * (1.0 - t)], t, b);
                self.may_be_center(plus(point, r / length(u), u))
            })
        });
        if !is_near {
            return (Vec::new(), Vec::new());
        }
        let (near_points, near_edges) = self.shell.near([point; 2], 2.0 * r);
        let mut centers: Vec<Place> = Vec::new();
        for other in near_points.iter().map(|k| points[*k as usize]) {
            let d = minus(other, point);
            let square = dot(d, d);
            if square > 0.0 {
                let middle = plus(point, 0.5, d);
                let across = [-d[1], d[0]];
                let far = square.sqrt();
                centers.extend(self.roots(r * r - square / 4.0).map(|h| plus(middle, h / far, across)));
            }
        }
        for edge in near_edges.iter().map(|k| &edges[*k as usize]) {
            let (t, h) = edge.seen(point);
            for side in [r, -r] {
                let along = self.roots(r * r - (side - h) * (side - h)).map(|root| t + root);
                let along = along.filter(|t| (-TIE..=edge.length + TIE).contains(t));
                centers.extend(along.map(|t| edge.place(t, side)));
            }
        }
        centers.retain(|center| self.may_be_center(*center));
        let mut directions: Vec<Place> = centers.iter().map(|center| minus(*center, point)).collect();
        directions.sort_by(|a, b| turn(*a).total_cmp(&turn(*b)));
        let at = |toward: Place| plus(point, r / length(toward), toward);
        if directions.is_empty() {
            let arcs = if self.is_center(circle[0]) { vec![Arc { around: point, between: None }] } else { Vec::new() };
            return (arcs, Vec::new());
        }
        let mut arcs = Vec::new();
        for (k, first) in directions.iter().enumerate() {
            let last = directions[(k + 1) % directions.len()];
            if self.is_center(at(between(*first, last))) {
                arcs.push(Arc { around: point, between: Some([*first, last]) });
            }
        }
        (arcs, directions.into_iter().map(at).filter(|center| self.is_center(*center)).collect())
    }

    /// The sides of E along an edge, and where they meet others.
    pub(super) fn beside(&self, edge: &Edge) -> (Vec<Side>, Vec<Place>) {
        let Shell { radius: r, points, edges, .. } = self.shell;
        let (mut sides, mut corners) = (Vec::new(), Vec::new());
        let ends = [edge.from, edge.place(edge.length, 0.0)];
        // The left of the edge there and back.
        for edge in [*edge, Edge::between(ends[1], ends[0])] {
            let at = |t: f64| edge.place(t, *r);
            if !steps(self.cells, edge.length).any(|t| self.may_be_center(at(t * edge.length))) {
                continue;
            }
            let (near_points, near_edges) = self.shell.near(ends, 2.0 * r);
            let mut along = vec![0.0, edge.length];
            for point in near_points.iter().map(|k| points[*k as usize]) {
                let (t, h) = edge.seen(point);
                along.extend(self.roots(h * (2.0 * r - h)).map(|root| t + root));
            }
            for other in near_edges.iter().map(|k| &edges[*k as usize]) {
                let slope = dot(edge.along, other.normal);
                let start = other.seen(at(0.0)).1;
                if slope != 0.0 {
                    along.extend([*r, -*r].map(|side| (side - start) / slope));
                }
            }
            along.retain(|t| (0.0..=edge.length).contains(t) && self.may_be_center(at(*t)));
            along.extend([0.0, edge.length]);
            along.sort_by(f64::total_cmp);
            along.dedup();
            for part in along.windows(2) {
                if self.is_center(at(0.5 * (part[0] + part[1]))) {
                    sides.push(Side { edge: [edge.from, edge.along, edge.normal], from: part[0], to: part[1] });
                }
            }
            corners.extend(along.into_iter().map(at).filter(|center| self.is_center(*center)));
        }
        (sides, corners)
    }
}
