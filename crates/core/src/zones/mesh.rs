//! The open ground as cells: a constrained Delaunay triangulation whose walls are split opposite
//! the corners of other walls. Triangles on one circle are one cell.
//!
//! A long wall has no vertex where a street ends against it, so the triangles there would reach to
//! its far ends. Hence the foot of every corner on the wall opposite becomes a vertex too. The
//! triangulation is repeated until no foot is missing. After that the shortest way across a street
//! from a corner is a side of a cell.
//!
//! The corners of a rectangle lie on one circle, and either diagonal makes a Delaunay triangulation
//! of it. So a side shared by two triangles on one circle is no side of the mesh. All other sides
//! are sides of every Delaunay triangulation. Hence the cells depend neither on how the scene is
//! turned or mirrored, nor on the order of its corners. The rest of this file keeps that property:
//! lengths are rounded from exact differences, and a choice among equals takes all of them.
//!
//! Corners are integers, so that a corner which touches a wall lies exactly on it, and the
//! triangulation splits the wall there. Scaled to meters first, it would fall to either side, and
//! edges would cross.

use spade::Triangulation;
use spade::handles::DirectedEdgeHandle;

use super::circle::are_on_one_circle;
use super::outline::OpenGround;
use crate::overlay::{Cdt, FineRing, corners_and_edges, inside_faces, triangulated};

/// A foot this close to an end of its wall \[m\], or this share of its distance, is left out.
const CLOSEST_FOOT_M: f64 = 0.25;
const CLOSEST_FOOT_SHARE: f64 = 0.1;

/// The most rounds of splitting walls. Each brings the feet of at least one corner per wall; a few
/// suffice.
const MOST_ROUNDS: usize = 8;

/// The most further passes of the overlay while edges cross.
const MOST_REPAIRS: usize = 3;

/// Cells of open ground: convex polygons, each with its corners on one circle.
#[derive(Debug, Default)]
pub(super) struct Mesh {
    /// Vertices on the lattice of the open ground.
    points: Vec<[i64; 2]>,
    /// The sides of all cells, cell by cell, counterclockwise.
    sides: Vec<Side>,
    /// The first side of each cell, followed by the number of all sides.
    first_sides: Vec<usize>,
    /// West, south, east, north.
    frame: [i64; 4],
    /// Length of a step of the lattice \[m\].
    step_m: f64,
}

/// Side of a cell.
#[derive(Debug, Clone, Copy)]
struct Side {
    /// The vertex at which it begins.
    from: usize,
    cell: usize,
    beyond: Beyond,
}

/// Ground or obstacle beyond a side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Beyond {
    /// A building.
    Wall,
    /// The edge of the scene.
    Frame,
    /// More open ground: the number of the same side in the cell beyond.
    Open(usize),
}

impl Mesh {
    pub(super) fn n_cells(&self) -> usize {
        self.first_sides.len().saturating_sub(1)
    }

    pub(super) fn n_sides(&self) -> usize {
        self.sides.len()
    }

    pub(super) fn sides(&self, cell: usize) -> std::ops::Range<usize> {
        self.first_sides[cell]..self.first_sides[cell + 1]
    }

    pub(super) fn cell(&self, side: usize) -> usize {
        self.sides[side].cell
    }

    pub(super) fn beyond(&self, side: usize) -> Beyond {
        self.sides[side].beyond
    }

    pub(super) fn corners(&self, cell: usize) -> impl Iterator<Item = [i64; 2]> + Clone {
        self.sides(cell).map(|side| self.points[self.sides[side].from])
    }

    /// Returns the ends of a side, counterclockwise around its cell.
    pub(super) fn ends(&self, side: usize) -> [[i64; 2]; 2] {
        let sides = self.sides(self.cell(side));
        let next = if side + 1 < sides.end { side + 1 } else { sides.start };
        [side, next].map(|side| self.points[self.sides[side].from])
    }

    /// Returns the length of a side \[steps\].
    pub(super) fn length(&self, side: usize) -> i64 {
        let [a, b] = self.ends(side);
        distance(a, b)
    }

    /// Returns the distance between the midpoints of two sides \[steps\].
    pub(super) fn distance(&self, side: usize, other: usize) -> i64 {
        halved_distance(self.doubled_middle(side), self.doubled_middle(other))
    }

    /// Returns the distance from the midpoint of a side to the farthest corner of its cell that is
    /// no end of the side \[steps\].
    pub(super) fn depth(&self, side: usize) -> i64 {
        let ends = self.ends(side);
        let middle = self.doubled_middle(side);
        let others = self.corners(self.cell(side)).filter(|corner| !ends.contains(corner));
        others.map(|corner| halved_distance(corner.map(|v| 2 * v), middle)).max().unwrap_or(0)
    }

    fn doubled_middle(&self, side: usize) -> [i64; 2] {
        let [a, b] = self.ends(side);
        [a[0] + b[0], a[1] + b[1]]
    }

    /// Returns twice the area of a cell \[steps²\].
    pub(super) fn doubled_area(&self, cell: usize) -> i128 {
        self.sides(cell)
            .map(|side| {
                let [a, b] = self.ends(side).map(|p| p.map(i128::from));
                a[0] * b[1] - a[1] * b[0]
            })
            .sum()
    }

    /// Converts twice an area \[steps²\] to the area \[m²\].
    pub(super) fn square_meters(&self, doubled: i128) -> f64 {
        doubled as f64 / 2.0 * self.step_m * self.step_m
    }

    pub(super) fn meters(&self, steps: i64) -> f64 {
        steps as f64 * self.step_m
    }

    pub(super) fn meets_frame(&self, cell: usize) -> bool {
        let is_on_frame = |p: [i64; 2]| (0..4).any(|k| p[k % 2] == self.frame[k]);
        self.corners(cell).any(is_on_frame)
    }

    /// Returns the width of a cell across each corner of the frame that it holds \[steps\]: the
    /// distance between the far ends of the two sides there.
    pub(super) fn frame_corners(&self, cell: usize) -> impl Iterator<Item = i64> {
        let sides = self.sides(cell);
        let n = sides.len();
        let after = move |side: usize| sides.start + (side + 1 - sides.start) % n;
        let is_frame = |side: usize| self.sides[side].beyond == Beyond::Frame;
        let corners = self.sides(cell).map(move |side| (side, after(side)));
        corners
            .filter(move |(side, next)| is_frame(*side) && is_frame(*next))
            .map(|(side, next)| distance(self.ends(side)[0], self.ends(next)[1]))
    }

    /// Cuts open ground into cells.
    pub(super) fn of(mut ground: OpenGround) -> Mesh {
        let mut outline = Outline::of(&ground.rings);
        let mut triangulated = outline.triangulated();
        for _ in 0..MOST_REPAIRS {
            if !matches!(triangulated, Some((_, false))) {
                break;
            }
            ground = ground.again();
            outline = Outline::of(&ground.rings);
            triangulated = outline.triangulated();
        }
        // If edges still cross, one of each two is left out.
        let Some((mut cdt, are_apart)) = triangulated else { return Mesh::default() };
        let n_corners = outline.points.len();
        for _ in 0..MOST_ROUNDS {
            if !are_apart || !outline.split_at_feet(&cdt, n_corners, ground.step_m) {
                break;
            }
            match outline.triangulated() {
                Some((finer, true)) => cdt = finer,
                _ => break,
            }
        }
        outline.points.truncate(cdt.num_vertices());
        mesh_of(&cdt, outline.points, &ground)
    }
}

/// Returns the distance between two points, rounded to a step.
fn distance(a: [i64; 2], b: [i64; 2]) -> i64 {
    halved_distance(a.map(|v| 2 * v), b.map(|v| 2 * v))
}

/// Returns half the distance between two points, rounded to a step. It does not depend on turning
/// or mirroring them.
fn halved_distance(a: [i64; 2], b: [i64; 2]) -> i64 {
    #[expect(clippy::cast_precision_loss, reason = "below 2^51")]
    let [dx, dy] = [0, 1].map(|k| (a[k] - b[k]) as f64);
    #[expect(clippy::cast_possible_truncation, reason = "below 2^51")]
    let rounded = ((dx * dx + dy * dy).sqrt() / 2.0).round() as i64;
    rounded
}

/// Vertices and the edges of walls and frame between them.
struct Outline {
    points: Vec<[i64; 2]>,
    edges: Vec<[usize; 2]>,
}

/// Foot of a corner on a wall.
struct Foot {
    /// Distance from the wall's first end, times the wall's length.
    along: i128,
    /// Distance of the corner from the wall.
    distance: f64,
    corner: [i64; 2],
}

impl Outline {
    fn of(rings: &[FineRing]) -> Self {
        let (points, edges) = corners_and_edges(rings);
        Outline { points, edges }
    }

    /// Returns the triangulation, and `true` if no edges cross; `None` if there are too few
    /// vertices.
    fn triangulated(&self) -> Option<(Cdt, bool)> {
        #[expect(clippy::cast_precision_loss, reason = "below 2^53")]
        let points: Vec<[f64; 2]> = self.points.iter().map(|p| p.map(|v| v as f64)).collect();
        triangulated(&points, self.edges.clone())
    }

    /// Splits walls at the feet of the first `n_corners` vertices opposite. Returns `true` if there
    /// were any.
    fn split_at_feet(&mut self, cdt: &Cdt, n_corners: usize, step_m: f64) -> bool {
        let (is_open, _) = inside_faces(cdt);
        let closest = CLOSEST_FOOT_M / step_m;
        let mut edges = Vec::with_capacity(self.edges.len() * 2);
        let n_before = self.points.len();
        let (mut opposite, mut feet) = (Vec::new(), Vec::new());
        for edge in cdt.undirected_edges().filter(|e| e.is_constraint_edge()) {
            let [from, to] = edge.vertices().map(|v| v.fix().index());
            let (p, q) = (self.points[from], self.points[to]);
            let along = difference(q, p);
            let squared = dot(along, along);
            let length = (squared as f64).sqrt();
            opposite.clear();
            for side in [edge.as_directed(), edge.as_directed().rev()] {
                if is_open[side.face().fix().index()] {
                    self.add_opposite(side, &mut opposite);
                }
            }
            feet.clear();
            for corner in opposite.iter().filter(|corner| **corner < n_corners).map(|corner| self.points[*corner]) {
                let to_corner = difference(corner, p);
                let foot = Foot {
                    along: dot(to_corner, along),
                    distance: (to_corner[0] * along[1] - to_corner[1] * along[0]).abs() as f64 / length,
                    corner,
                };
                let margin = closest.max(CLOSEST_FOOT_SHARE * foot.distance);
                let [from_p, from_q] = [foot.along, squared - foot.along].map(|along| along as f64 / length);
                if from_p > margin && from_q > margin {
                    feet.push(foot);
                }
            }
            // Of feet close to one another, keep that of the nearest corner, or of all corners
            // equally near.
            let is_beside = |a: &Foot, b: &Foot| ((a.along - b.along).abs() as f64) < closest * length;
            let is_taken = |a: &&Foot| !feet.iter().any(|b| b.distance < a.distance && is_beside(a, b));
            let mut taken: Vec<&Foot> = feet.iter().filter(is_taken).collect();
            taken.sort_unstable_by_key(|foot| foot.along);
            let mut last = from;
            for foot in taken {
                self.points.push(position(foot, [p, q], squared));
                edges.push([last, self.points.len() - 1]);
                last = self.points.len() - 1;
            }
            edges.push([last, to]);
        }
        self.edges = edges;
        self.points.len() > n_before
    }

    /// Adds the vertices of the cell to the left of an edge, without the ends of the edge.
    fn add_opposite(&self, edge: Edge, opposite: &mut Vec<usize>) {
        opposite.extend(edge.opposite_vertex().map(|v| v.fix().index()));
        for other in [edge.next(), edge.prev()] {
            if is_within_cell(other, &self.points) {
                self.add_opposite(other.rev(), opposite);
            }
        }
    }
}

type Edge<'a> = DirectedEdgeHandle<'a, spade::Point2<f64>, (), spade::CdtEdge<()>, ()>;

/// Returns `true` if an edge lies between two triangles of one cell.
fn is_within_cell(edge: Edge, points: &[[i64; 2]]) -> bool {
    let (Some(left), Some(right)) = (edge.opposite_vertex(), edge.rev().opposite_vertex()) else { return false };
    let corners = [edge.from(), edge.to(), left, right];
    !edge.is_constraint_edge() && are_on_one_circle(corners.map(|v| points[v.fix().index()]))
}

fn difference(a: [i64; 2], b: [i64; 2]) -> [i128; 2] {
    [0, 1].map(|k| i128::from(a[k] - b[k]))
}

fn dot(a: [i128; 2], b: [i128; 2]) -> i128 {
    a[0] * b[0] + a[1] * b[1]
}

/// Returns the lattice point nearest to a foot, computed from the nearer end of the wall. Halfway
/// between the ends it is rounded to the corner's side.
fn position(foot: &Foot, [p, q]: [[i64; 2]; 2], squared: i128) -> [i64; 2] {
    let (near, far, along) = if 2 * foot.along <= squared { (p, q, foot.along) } else { (q, p, squared - foot.along) };
    if 2 * along == squared {
        return [0, 1].map(|k| {
            let sum = p[k] + q[k];
            sum.div_euclid(2) + i64::from(sum.rem_euclid(2) == 1 && 2 * foot.corner[k] > sum)
        });
    }
    let share = along as f64 / squared as f64;
    #[expect(clippy::cast_possible_truncation, clippy::cast_precision_loss, reason = "below 2^50")]
    let step = |k: usize| (share * (far[k] - near[k]) as f64).round() as i64;
    [0, 1].map(|k| near[k] + step(k))
}

/// Makes cells from the triangles of open ground.
fn mesh_of(cdt: &Cdt, points: Vec<[i64; 2]>, ground: &OpenGround) -> Mesh {
    let (is_open, _) = inside_faces(cdt);
    let is_open = |edge: Edge| is_open[edge.face().fix().index()];
    let within: Vec<bool> = cdt
        .undirected_edges()
        .map(|edge| is_open(edge.as_directed()) && is_within_cell(edge.as_directed(), &points))
        .collect();
    let is_within = |edge: Edge| within[edge.as_undirected().fix().index()];
    // The side of each directed edge.
    let mut side_of = vec![usize::MAX; cdt.num_directed_edges()];
    let (mut sides, mut first_sides) = (Vec::new(), Vec::new());
    for first in cdt.directed_edges() {
        if side_of[first.fix().index()] != usize::MAX || !is_open(first) || is_within(first) {
            continue;
        }
        let cell = first_sides.len();
        first_sides.push(sides.len());
        let mut edge = first;
        loop {
            side_of[edge.fix().index()] = sides.len();
            sides.push((edge, cell));
            edge = edge.next();
            while is_within(edge) {
                edge = edge.rev().next();
            }
            if edge == first {
                break;
            }
        }
    }
    first_sides.push(sides.len());
    let frame = ground.frame;
    let on_frame = |a: [i64; 2], b: [i64; 2]| (0..4).any(|k| a[k % 2] == frame[k] && b[k % 2] == frame[k]);
    let side = |(edge, cell): (Edge, usize)| {
        let [from, to] = [edge.from(), edge.to()].map(|v| v.fix().index());
        let beyond = match side_of[edge.rev().fix().index()] {
            other if other != usize::MAX && !edge.is_constraint_edge() => Beyond::Open(other),
            _ if on_frame(points[from], points[to]) => Beyond::Frame,
            _ => Beyond::Wall,
        };
        Side { from, cell, beyond }
    };
    let sides = sides.into_iter().map(side).collect();
    Mesh { points, sides, first_sides, frame, step_m: ground.step_m }
}
