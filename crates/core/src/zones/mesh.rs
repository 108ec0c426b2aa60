//! The open ground as triangles: a constrained Delaunay triangulation whose walls are split where a corner of another
//! wall stands opposite.
//!
//! A long wall has no vertex where a street ends against it, and the triangles there would reach to its far ends. So
//! the foot of every corner on the wall opposite becomes a vertex too, and the triangulation is made again until no foot
//! is missing. After that the shortest way across a street from a corner is a side of a triangle.
//!
//! Corners are integers, so that a corner which touches a wall lies exactly on it, and the triangulation splits the wall
//! there; scaled to meters first, it would fall to either side, and edges would cross.

use spade::Triangulation;

use super::outline::OpenGround;
use crate::overlay::{Cdt, corners_and_edges, inside_faces, triangulated};

/// A foot this close to an end of its wall \[m\], or this share of its distance, is left out.
const CLOSEST_FOOT_M: f64 = 0.25;
const CLOSEST_FOOT_SHARE: f64 = 0.1;

/// The most rounds of splitting walls. Each brings the feet of at least one corner per wall; a few suffice.
const MOST_ROUNDS: usize = 8;

/// The most further passes of the overlay where edges cross.
const MOST_REPAIRS: usize = 3;

/// Triangles of open ground.
#[derive(Debug, Default)]
pub(super) struct Mesh {
    /// Vertices \[m\].
    pub(super) points: Vec<[f64; 2]>,
    pub(super) triangles: Vec<Triangle>,
    /// West, south, east, north \[m\].
    frame: [f64; 4],
}

/// A triangle, counterclockwise.
#[derive(Debug, Clone, Copy)]
pub(super) struct Triangle {
    pub(super) corners: [usize; 3],
    /// Side k runs from corner k to the next.
    pub(super) sides: [Side; 3],
}

/// What lies beyond a side of a triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    /// A building.
    Wall,
    /// The end of the scene.
    Frame,
    /// More open ground: this triangle.
    Open(usize),
}

impl Mesh {
    pub(super) fn ends(&self, triangle: usize, side: usize) -> [[f64; 2]; 2] {
        let corners = self.triangles[triangle].corners;
        [self.points[corners[side]], self.points[corners[(side + 1) % 3]]]
    }

    /// Length of a side \[m\].
    pub(super) fn length(&self, triangle: usize, side: usize) -> f64 {
        let [a, b] = self.ends(triangle, side);
        (a[0] - b[0]).hypot(a[1] - b[1])
    }

    /// Area of a triangle \[m²\].
    pub(super) fn area(&self, triangle: usize) -> f64 {
        let [a, b, c] = self.triangles[triangle].corners.map(|corner| self.points[corner]);
        ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs() / 2.0
    }

    pub(super) fn meets_frame(&self, triangle: usize) -> bool {
        #[expect(clippy::float_cmp, reason = "points on the frame have its coordinates exactly")]
        let is_on_frame = |p: [f64; 2]| (0..4).any(|k| p[k % 2] == self.frame[k]);
        self.triangles[triangle].corners.iter().any(|corner| is_on_frame(self.points[*corner]))
    }

    pub(super) fn middle(&self, triangle: usize, side: usize) -> [f64; 2] {
        let [a, b] = self.ends(triangle, side);
        [f64::midpoint(a[0], b[0]), f64::midpoint(a[1], b[1])]
    }

    /// Triangulates open ground.
    pub(super) fn of(ground: &OpenGround) -> Mesh {
        let mut outline = Outline::of(ground);
        let mut triangulated = outline.triangulated();
        for _ in 0..MOST_REPAIRS {
            if !matches!(triangulated, Some((_, false))) {
                break;
            }
            outline = Outline::of(&ground.again());
            triangulated = outline.triangulated();
        }
        // Should edges still cross, one of each two is left out.
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
        mesh_of(&cdt, ground)
    }
}

/// Vertices and the edges of walls and frame between them.
struct Outline {
    points: Vec<[f64; 2]>,
    edges: Vec<[usize; 2]>,
}

impl Outline {
    fn of(ground: &OpenGround) -> Self {
        let (corners, edges) = corners_and_edges(&ground.rings);
        Outline { points: corners.into_iter().map(|p| p.map(f64::from)).collect(), edges }
    }

    /// The triangulation, and whether no edges cross; `None` if there are too few vertices.
    fn triangulated(&self) -> Option<(Cdt, bool)> {
        triangulated(&self.points, self.edges.clone())
    }

    /// Splits walls at the feet of the first `n_corners` vertices opposite; says whether there were any.
    fn split_at_feet(&mut self, cdt: &Cdt, n_corners: usize, step_m: f64) -> bool {
        let (is_open, _) = inside_faces(cdt);
        let closest = CLOSEST_FOOT_M / step_m;
        let mut edges = Vec::with_capacity(self.edges.len() * 2);
        let n_before = self.points.len();
        for edge in cdt.undirected_edges().filter(|e| e.is_constraint_edge()) {
            let [from, to] = edge.vertices().map(|v| v.fix().index());
            let (p, q) = (self.points[from], self.points[to]);
            let along = [q[0] - p[0], q[1] - p[1]];
            let length = along[0].hypot(along[1]);
            let mut feet: Vec<f64> = Vec::new();
            for side in [edge.as_directed(), edge.as_directed().rev()] {
                let Some(apex) = side.opposite_vertex().map(|v| v.fix().index()) else { continue };
                if apex >= n_corners || !is_open[side.face().fix().index()] {
                    continue;
                }
                let a = self.points[apex];
                let at = ((a[0] - p[0]) * along[0] + (a[1] - p[1]) * along[1]) / length;
                let distance = ((a[0] - p[0]) * along[1] - (a[1] - p[1]) * along[0]).abs() / length;
                let margin = closest.max(CLOSEST_FOOT_SHARE * distance);
                if at > margin && length - at > margin {
                    feet.push(at);
                }
            }
            feet.sort_unstable_by(f64::total_cmp);
            feet.dedup_by(|b, a| *b - *a < closest);
            let mut last = from;
            for at in feet {
                let t = at / length;
                self.points.push([p[0] + t * along[0], p[1] + t * along[1]]);
                edges.push([last, self.points.len() - 1]);
                last = self.points.len() - 1;
            }
            edges.push([last, to]);
        }
        self.edges = edges;
        self.points.len() > n_before
    }
}

/// The triangles of open ground.
fn mesh_of(cdt: &Cdt, ground: &OpenGround) -> Mesh {
    let (is_open, _) = inside_faces(cdt);
    let mut number = vec![usize::MAX; cdt.num_all_faces()];
    let faces = || cdt.inner_faces().filter(|f| is_open[f.fix().index()]);
    for (k, face) in faces().enumerate() {
        number[face.fix().index()] = k;
    }
    let mut points = vec![[0.0; 2]; cdt.num_vertices()];
    for vertex in cdt.vertices() {
        points[vertex.fix().index()] = [vertex.position().x, vertex.position().y].map(|v| v * ground.step_m);
    }
    let frame = ground.frame.map(|v| f64::from(v) * ground.step_m);
    #[expect(clippy::float_cmp, reason = "points on the frame have its coordinates exactly")]
    let on_frame = |a: [f64; 2], b: [f64; 2]| (0..4).any(|k| a[k % 2] == frame[k] && b[k % 2] == frame[k]);
    let triangles = faces()
        .map(|face| {
            let edges = face.adjacent_edges();
            let sides = edges.map(|edge| {
                let [a, b] = [edge.from(), edge.to()].map(|v| points[v.fix().index()]);
                match number[edge.rev().face().fix().index()] {
                    k if k != usize::MAX && !edge.is_constraint_edge() => Side::Open(k),
                    _ if on_frame(a, b) => Side::Frame,
                    _ => Side::Wall,
                }
            });
            Triangle { corners: edges.map(|edge| edge.from().fix().index()), sides }
        })
        .collect();
    Mesh { points, triangles, frame }
}
