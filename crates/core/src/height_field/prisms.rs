//! Prisms: the solid of a vector scene, cut into convex pieces and found through a grid of buckets.

use std::sync::Arc;

use super::casters::{CasterRoof, Casters};
use super::{Bulge, RoofHeight, RoofPlane};
use crate::overlay::bounds_of;
use crate::quantity::VOID;

/// The top of a convex prism.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Top {
    /// At one height \[1/1024 m above the datum\].
    Flat(i32),
    /// In the plane through these heights of its corners, which lie within
    /// [`MAX_ROOF_STEPS`](super::MAX_ROOF_STEPS) of each other.
    Sloped(Vec<i32>),
}

/// A convex prism: a counterclockwise convex ring, solid from below everything up to a flat or a
/// sloped top.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Piece {
    first: u32,
    len: u32,
    /// Begin of the heights of its corners, [`FLAT`] if it has one top.
    heights: u32,
    /// Top \[1/1024 m above the datum\], of a sloped roof the highest.
    pub top: i32,
    /// The building (footprint) that this piece belongs to.
    pub building: u32,
}

/// In place of where heights of corners begin.
const FLAT: u32 = u32::MAX;

/// The closed union B of the prisms of a vector scene. Copies share what they are.
#[derive(Debug, Clone)]
pub struct Prisms {
    parts: Arc<Parts>,
    earth: Option<CurvedGround>,
}

/// Prisms over a flat earth.
#[derive(Debug)]
struct Parts {
    vertices: Vec<[i32; 2]>,
    /// Heights of the corners of the pieces that are sloped \[1/1024 m above the datum\].
    heights: Vec<i32>,
    pieces: Vec<Piece>,
    buckets: Buckets,
    casters: Casters,
    max_top: i32,
}

/// A curved earth below prisms.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CurvedGround {
    /// By how much it falls away.
    pub bulge: Bulge,
    /// The height of flat ground, which stands in the way beyond the horizon \[1/1024 m above the
    /// datum\]; `None` where columns do.
    pub ground: Option<i32>,
}

/// A grid of square buckets, each listing the pieces whose bounding box meets its closed square.
#[derive(Debug, Clone, Default)]
pub struct Buckets {
    /// Lattice position of the south-west corner of bucket (0, 0), a multiple of the bucket size.
    pub origin: (i64, i64),
    /// Edge length of a bucket \[lattice steps\].
    pub size: i64,
    /// Number of buckets along x and y.
    pub shape: (i64, i64),
    start: Vec<u32>,
    items: Vec<u32>,
    max_tops: Vec<i32>,
}

impl Buckets {
    /// Returns the bucket at `(east, north)`: its highest top and its pieces; `None` outside the
    /// grid.
    #[inline]
    pub fn at(&self, east: i64, north: i64) -> Option<(i32, &[u32])> {
        if east < 0 || north < 0 || east >= self.shape.0 || north >= self.shape.1 {
            return None;
        }
        let i = usize::try_from(north * self.shape.0 + east).ok()?;
        Some((self.max_tops[i], &self.items[self.start[i] as usize..self.start[i + 1] as usize]))
    }

    /// Returns the bucket that holds a lattice position, half-open towards the north-east.
    pub fn index_of(&self, x: i64, y: i64) -> (i64, i64) {
        ((x - self.origin.0).div_euclid(self.size), (y - self.origin.1).div_euclid(self.size))
    }
}

impl Prisms {
    /// Returns prisms with flat tops from convex counterclockwise rings, each with its top and the
    /// index of its building.
    pub fn new<R: AsRef<[[i32; 2]]>>(pieces: impl IntoIterator<Item = (R, i32, u32)>) -> Self {
        Prisms::with_tops(pieces.into_iter().map(|(ring, top, building)| (ring, Top::Flat(top), building)))
    }

    /// Returns prisms from convex counterclockwise rings, each with its top and the index of its
    /// building. A ring below a sloped top turns left at its second corner.
    pub fn with_tops<R: AsRef<[[i32; 2]]>>(pieces: impl IntoIterator<Item = (R, Top, u32)>) -> Self {
        let mut vertices: Vec<[i32; 2]> = Vec::new();
        let mut heights: Vec<i32> = Vec::new();
        let pieces: Vec<Piece> = pieces
            .into_iter()
            .map(|(ring, top, building)| {
                let ring = ring.as_ref();
                let count = |n: usize| u32::try_from(n).expect("fewer than 2^32 vertices fit in memory");
                let (first, len) = (count(vertices.len()), count(ring.len()));
                vertices.extend(ring);
                match top {
                    Top::Flat(top) => Piece { first, len, heights: FLAT, top, building },
                    Top::Sloped(of) => {
                        let (low, top) = of.iter().fold((i32::MAX, VOID), |r, z| (r.0.min(*z), r.1.max(*z)));
                        if low == top {
                            return Piece { first, len, heights: FLAT, top, building };
                        }
                        let from = count(heights.len());
                        heights.extend(&of);
                        Piece { first, len, heights: from, top, building }
                    }
                }
            })
            .collect();
        let max_top = pieces.iter().map(|p| p.top).max().unwrap_or(VOID);
        let parts =
            Parts { buckets: Buckets::default(), casters: Casters::default(), vertices, heights, pieces, max_top };
        let roofs = || parts.pieces.iter().map(|p| (p.top, parts.ring(p), parts.heights(p)));
        let (buckets, casters) = rayon::join(
            || build_buckets(&parts.vertices, &parts.pieces),
            || Casters::new(roofs().map(CasterRoof::from)),
        );
        Prisms { parts: Arc::new(Parts { buckets, casters, ..parts }), earth: None }
    }

    /// Returns these prisms on an earth that is curved, or flat again.
    pub fn on_earth(&self, earth: Option<CurvedGround>) -> Prisms {
        Prisms { parts: Arc::clone(&self.parts), earth }
    }

    /// Returns the curve of the earth below them; `None` if it is flat.
    #[inline]
    pub fn earth(&self) -> Option<CurvedGround> {
        self.earth
    }

    /// Returns all convex pieces.
    pub fn pieces(&self) -> &[Piece] {
        &self.parts.pieces
    }

    /// Returns the ring of a piece.
    #[inline]
    pub fn ring(&self, piece: &Piece) -> &[[i32; 2]] {
        self.parts.ring(piece)
    }

    /// Returns the heights of the corners of a piece \[1/1024 m above the datum\]; `None` of one
    /// with a flat top.
    #[inline]
    pub fn heights(&self, piece: &Piece) -> Option<&[i32]> {
        self.parts.heights(piece)
    }

    /// Returns the plane of a sloped piece; `None` of one with a flat top.
    #[inline]
    pub fn plane(&self, piece: &Piece) -> Option<RoofPlane> {
        self.heights(piece).map(|heights| RoofPlane::through(self.ring(piece), heights))
    }

    /// Returns whether any roof is sloped.
    pub fn are_sloped(&self) -> bool {
        !self.parts.heights.is_empty()
    }

    /// Returns the lowest lattice height that is not below the roof of a piece at a position in its
    /// closed ring \[1/1024 m above the datum\].
    #[inline]
    fn top_at(&self, piece: &Piece, x: i64, y: i64) -> i32 {
        self.plane(piece).map_or(piece.top, |plane| plane.lowest_above(x, y))
    }

    /// Returns the grid that finds pieces by place.
    pub(crate) fn buckets(&self) -> &Buckets {
        &self.parts.buckets
    }

    /// Returns the prisms as casters of shadows.
    pub fn casters(&self) -> &Casters {
        &self.parts.casters
    }

    /// Returns the highest top, [`VOID`] if there is no prism.
    pub fn max_top(&self) -> i32 {
        self.parts.max_top
    }

    /// Returns the pieces whose closed ring contains the lattice position.
    fn touching(&self, x: i64, y: i64) -> impl Iterator<Item = (usize, &[[i32; 2]])> {
        let (east, north) = self.parts.buckets.index_of(x, y);
        let items = self.parts.buckets.at(east, north).map_or(&[][..], |(_, items)| items);
        items.iter().map(|&i| (i as usize, self.ring(&self.parts.pieces[i as usize]))).filter(move |(_, ring)| {
            let n = ring.len();
            (0..n).all(|k| side(ring[k], ring[(k + 1) % n], x, y) >= 0)
        })
    }

    /// Returns the height below which the vertical line at `(x, y)` is in the interior of B, and
    /// the piece that sets it.
    ///
    /// `None` if the position is not interior to the union of the footprints. On an edge or a
    /// vertex of pieces this is the lowest, over all directions around the point, of what lies that
    /// way.
    pub(crate) fn solid_at(&self, x: i64, y: i64) -> Option<(i32, usize)> {
        self.around(x, y, |piece| self.top_at(piece, x, y)).lowest()
    }

    /// Returns the same height as [`solid_at`](Prisms::solid_at), of a slope exactly, and the piece
    /// that sets it.
    pub(crate) fn exact_solid_at(&self, x: i64, y: i64) -> Option<(RoofHeight, usize)> {
        let height = |piece: &Piece| match self.plane(piece) {
            Some(plane) => plane.exact_height(x, y),
            None => RoofHeight::level(piece.top),
        };
        self.around(x, y, height).lowest()
    }

    /// Returns the pieces in whose interior `(x, y)` lies, and the walls that meet there.
    ///
    /// If the walls leave no side open, the highest piece of each side that the others do not
    /// cover.
    pub(crate) fn pieces_around(&self, x: i64, y: i64) -> (Vec<usize>, Vec<usize>) {
        let inside = self.touching(x, y).filter(|(_, ring)| sector_at(ring, x, y).is_none());
        let around = self.around(x, y, |piece| self.top_at(piece, x, y));
        let sides: Option<Vec<(i32, usize)>> = around.sides.into_iter().collect();
        let mut sides = sides.unwrap_or_default();
        sides.sort_unstable();
        sides.dedup();
        (inside.map(|(piece, _)| piece).collect(), sides.into_iter().map(|(_, piece)| piece).collect())
    }

    /// Returns the highest roof in whose interior a point is, and the highest roof just
    /// counterclockwise of each direction in which that changes. `height` is that of a piece there.
    fn around<T: Copy + Ord>(&self, x: i64, y: i64, height: impl Fn(&Piece) -> T) -> Around<T> {
        /// Directions that a piece covers around the point: from `from` counterclockwise to `to`.
        struct Sector<T> {
            from: [i64; 2],
            to: [i64; 2],
            roof: (T, usize),
        }
        let mut whole: Option<(T, usize)> = None;
        let mut sectors: Vec<Sector<T>> = Vec::new();
        for (i, ring) in self.touching(x, y) {
            let roof = (height(&self.parts.pieces[i]), i);
            match sector_at(ring, x, y) {
                None => whole = whole.max(Some(roof)),
                // Of walls on one another the highest counts.
                Some((from, to)) => match sectors.iter_mut().find(|s| (s.from, s.to) == (from, to)) {
                    Some(known) => known.roof = known.roof.max(roof),
                    None => sectors.push(Sector { from, to, roof }),
                },
            }
        }
        let cross =
            |a: [i64; 2], b: [i64; 2]| i128::from(a[0]) * i128::from(b[1]) - i128::from(a[1]) * i128::from(b[0]);
        let dot = |a: [i64; 2], b: [i64; 2]| i128::from(a[0]) * i128::from(b[0]) + i128::from(a[1]) * i128::from(b[1]);
        // Whether a sector covers the directions just counterclockwise of `d`.
        let covers = |Sector { from, to, .. }: &Sector<T>, d: [i64; 2]| {
            (cross(*from, d) == 0 && dot(*from, d) > 0) || (cross(*from, d) > 0 && cross(d, *to) > 0)
        };
        let highest = |d: [i64; 2]| sectors.iter().filter(|s| covers(s, d)).map(|s| s.roof).max();
        // What lies around the point changes only where a sector begins or ends.
        let sides = sectors.iter().flat_map(|s| [s.from, s.to]).map(highest).collect();
        Around { whole, sides }
    }

    /// Returns the height of the solid there, of a slope rounded up; [`VOID`] where there is none.
    pub fn solid_below(&self, x: i64, y: i64) -> i32 {
        self.solid_at(x, y).map_or(VOID, |(top, _)| top)
    }

    /// Returns the top of the roof at `(x, y)`, of a slope rounded up, and its building; `None` off
    /// all footprints.
    ///
    /// It is the highest of the pieces that hold the position. A point on an edge counts to what
    /// lies east, then north of it.
    pub fn roof_at(&self, x: i64, y: i64) -> Option<(i32, u32)> {
        let holding = self.touching(x, y).filter(|(_, ring)| holds_half_open(ring, x, y));
        holding.map(|(i, _)| &self.parts.pieces[i]).map(|p| (self.top_at(p, x, y), p.building)).max()
    }
}

impl Parts {
    #[inline]
    fn ring(&self, piece: &Piece) -> &[[i32; 2]] {
        &self.vertices[piece.first as usize..(piece.first + piece.len) as usize]
    }

    #[inline]
    fn heights(&self, piece: &Piece) -> Option<&[i32]> {
        (piece.heights != FLAT).then(|| &self.heights[piece.heights as usize..(piece.heights + piece.len) as usize])
    }
}

/// The roofs around a point, each with its piece.
struct Around<T> {
    whole: Option<(T, usize)>,
    sides: Vec<Option<(T, usize)>>,
}

impl<T: Copy + Ord> Around<T> {
    /// Returns the lowest over all directions of the highest roof that lies that way.
    fn lowest(&self) -> Option<(T, usize)> {
        self.sides.iter().map(|side| (*side).max(self.whole)).min().unwrap_or(self.whole)
    }
}

/// Returns whether a convex counterclockwise ring holds a position under the half-open rule: a
/// position on an edge belongs to what lies just east, then just north of it. Rings with disjoint
/// interiors never share a position.
#[inline]
pub(super) fn holds_half_open(ring: &[[i32; 2]], x: i64, y: i64) -> bool {
    let n = ring.len();
    (0..n).all(|k| {
        let (a, b) = (ring[k], ring[(k + 1) % n]);
        let side = side(a, b, x, y);
        side > 0 || (side == 0 && (b[1] < a[1] || (b[1] == a[1] && b[0] > a[0])))
    })
}

/// Returns twice the signed area of `a`, `b`, `(x, y)`: positive if the position is left of the
/// edge.
#[inline]
pub(super) fn side(a: [i32; 2], b: [i32; 2], x: i64, y: i64) -> i64 {
    let (ax, ay, bx, by) = (i64::from(a[0]), i64::from(a[1]), i64::from(b[0]), i64::from(b[1]));
    (bx - ax) * (y - ay) - (by - ay) * (x - ax)
}

/// Returns the directions that a convex ring covers around a position which its closed region
/// contains: `None` for all of them.
fn sector_at(ring: &[[i32; 2]], x: i64, y: i64) -> Option<([i64; 2], [i64; 2])> {
    let n = ring.len();
    let to = |k: usize| [i64::from(ring[k % n][0]) - x, i64::from(ring[k % n][1]) - y];
    let at = |k: usize| shortest(to(k));
    if let Some(k) = (0..n).find(|&k| to(k) == [0, 0]) {
        return Some((at(k + 1), at(k + n - 1)));
    }
    let k = (0..n).find(|&k| side(ring[k], ring[(k + 1) % n], x, y) == 0)?;
    Some((at(k + 1), at(k)))
}

/// Returns the shortest vector of integers in a direction, so that equal directions are equal.
fn shortest(direction: [i64; 2]) -> [i64; 2] {
    let [mut a, mut divisor] = direction;
    while a != 0 {
        (a, divisor) = (divisor % a, a);
    }
    direction.map(|v| v / divisor.abs().max(1))
}

/// Buckets sized so that there is about one for every piece, between 8 m and 256 m.
fn build_buckets(vertices: &[[i32; 2]], pieces: &[Piece]) -> Buckets {
    let ring = |p: &Piece| &vertices[p.first as usize..(p.first + p.len) as usize];
    let bounds = |ring: &[[i32; 2]]| bounds_of(ring).map(i64::from);
    if pieces.is_empty() {
        return Buckets {
            origin: (0, 0),
            size: 1024,
            shape: (0, 0),
            start: vec![0],
            items: Vec::new(),
            max_tops: Vec::new(),
        };
    }
    let [x0, y0, x1, y1] = bounds(vertices);
    let (smallest, largest) = (8 * 1024_i64, 256 * 1024_i64);
    let mut size = smallest;
    let n_pieces = i64::try_from(pieces.len()).unwrap_or(i64::MAX);
    while size < largest && ((x1 - x0) / size + 1) * ((y1 - y0) / size + 1) > n_pieces.saturating_mul(4).max(1 << 14) {
        size *= 2;
    }
    let origin = (x0.div_euclid(size) * size, y0.div_euclid(size) * size);
    let shape = ((x1 - origin.0) / size + 1, (y1 - origin.1) / size + 1);
    let spans = |p: &Piece| {
        let [px0, py0, px1, py1] = bounds(ring(p));
        let cell = |v: i64, o: i64| (v - o).div_euclid(size);
        // A closed square also meets what only touches its east or north edge; visits are
        // half-open, so the bucket of each of the piece's points is enough.
        (cell(px0, origin.0)..=cell(px1, origin.0), cell(py0, origin.1)..=cell(py1, origin.1))
    };
    let index = |n: i64| usize::try_from(n).unwrap_or(0);
    let n_buckets = index(shape.0 * shape.1);
    let each = |f: &mut dyn FnMut(usize, usize)| {
        for (k, piece) in pieces.iter().enumerate() {
            let (cols, rows) = spans(piece);
            for row in rows {
                for col in cols.clone() {
                    f(index(row * shape.0 + col), k);
                }
            }
        }
    };
    let mut start = vec![0_u32; n_buckets + 1];
    let mut max_tops = vec![VOID; n_buckets];
    each(&mut |bucket, k| {
        start[bucket + 1] += 1;
        max_tops[bucket] = max_tops[bucket].max(pieces[k].top);
    });
    for i in 0..n_buckets {
        start[i + 1] += start[i];
    }
    let mut next = start.clone();
    let mut items = vec![0_u32; start[n_buckets] as usize];
    each(&mut |bucket, k| {
        items[next[bucket] as usize] = u32::try_from(k).unwrap_or(u32::MAX);
        next[bucket] += 1;
    });
    Buckets { origin, size, shape, start, items, max_tops }
}
