//! The solids of a city: prisms or columns as faces, ready to be drawn from any side.
//!
//! Each face has a tag that holds its owner and its normal, so shading needs nothing but the
//! z-buffer.

use glam::{DVec2, DVec3};

use super::colors;
use super::paint::{narrow, quantiles};
use super::z_buffer::{Projection, View, ZBuffer};

/// Columns higher than this above their ground are buildings \[m\].
const BUILDING_THRESHOLD_M: f64 = 0.25;
/// Most columns a side; a larger height raster is thinned.
const MOST_COLUMNS: usize = 1600;

/// Form in which a city is given.
#[derive(Clone, Copy, Debug)]
pub enum CityModel<'a> {
    /// Footprints with roofs.
    Prisms(&'a [CityPrism]),
    /// A raster over the whole extent, each cell a column.
    Heights(CityHeights<'a>),
}

/// A building: ground, roof and walls.
#[derive(Clone, Debug)]
pub struct CityPrism {
    /// The roof as triangles, each corner with its height \[m\].
    pub roof_triangles: Vec<[[f64; 3]; 3]>,
    /// Upper edges of the walls, from which these lead down to the ground \[m\].
    pub wall_edges: Vec<[[f64; 3]; 2]>,
    /// Height of the ground \[m\].
    pub base_m: f64,
    /// Greatest height of the roof \[m\].
    pub top_m: f64,
}

/// A city as a raster, `[n_rows, n_cols]`, columns running fastest, north row first. A cell is a
/// building if its surface is more than 0.25 m above its ground. Rasters of more than 1600 cells a
/// side are thinned for the picture.
#[derive(Clone, Copy, Debug)]
pub struct CityHeights<'a> {
    /// Columns.
    pub n_cols: usize,
    /// Rows.
    pub n_rows: usize,
    /// Surface heights \[m\]; not finite where unknown.
    pub surface_m: &'a [f32],
    /// Ground heights \[m\].
    pub ground_m: &'a [f32],
}

/// Bits of a tag that hold the owner of the face, the lowest 24. The next 8 hold the normal of a
/// wall (0: none), the upper 32 that of a slope (0: up).
const OWNER_BITS: u32 = 24;
const SLOPE_BITS: u32 = 32;
pub(crate) const OWNER: u64 = (1 << OWNER_BITS) - 1;
pub(crate) const GROUND: u64 = OWNER;
pub(crate) const PLATE: u64 = OWNER - 1;

/// The solids of a city around a local origin, ready to be drawn from any side.
#[derive(Debug)]
pub(crate) struct Solids<'a> {
    model: Columns<'a>,
    /// South-west corner, in the caller's coordinates \[m\].
    pub(crate) origin: DVec3,
    /// Size of the extent and greatest height above the lowest ground \[m\].
    pub(crate) size: DVec3,
}

#[derive(Debug)]
enum Columns<'a> {
    Prisms(&'a [CityPrism]),
    /// Thinned surface heights and building heights \[m\], with their columns and rows.
    Raster {
        tops: Vec<[f32; 2]>,
        n_cols: usize,
        n_rows: usize,
    },
}

impl<'a> Solids<'a> {
    /// Makes the solids of a city within `extent`: west, south, east, north \[m\].
    pub(crate) fn new(model: &CityModel<'a>, extent: [f64; 4]) -> Self {
        let [west, south, east, north] = extent;
        let (model, low, high) = match *model {
            CityModel::Prisms(prisms) => {
                let low = prisms.iter().map(|p| p.base_m).fold(f64::INFINITY, f64::min);
                let high = prisms.iter().map(|p| p.top_m).fold(f64::NEG_INFINITY, f64::max);
                (Columns::Prisms(prisms), low, high)
            }
            CityModel::Heights(heights) => thin(&heights),
        };
        let (low, high) = if low.is_finite() && high.is_finite() { (low, high) } else { (0.0, 0.0) };
        Self {
            model,
            origin: DVec3::new(west, south, low),
            size: DVec3::new(east - west, north - south, (high - low).max(0.0)),
        }
    }

    /// Returns the upper end of the color scale \[m\], and `true` if some buildings are taller.
    pub(crate) fn height_scale(&self) -> (f64, bool) {
        let heights: Vec<f32> = match &self.model {
            Columns::Prisms(prisms) => prisms.iter().map(|p| narrow(p.top_m - p.base_m)).collect(),
            Columns::Raster { tops, .. } => {
                let heights = tops.iter().map(|[_, height]| *height);
                heights.filter(|&h| f64::from(h) > BUILDING_THRESHOLD_M).collect()
            }
        };
        let [usual, most] = quantiles(heights, [0.985, 1.0]).unwrap_or([1.0; 2]);
        if most <= 1.35 * usual { (most.max(1.0), false) } else { (usual.max(1.0), true) }
    }

    pub(crate) fn is_raster(&self) -> bool {
        matches!(self.model, Columns::Raster { .. })
    }

    /// Returns the height of a face's owner above its ground \[m\]; `None` for open ground.
    pub(crate) fn height_of(&self, owner: u64) -> Option<f64> {
        let owner = usize::try_from(owner).ok()?.checked_sub(1)?;
        match &self.model {
            Columns::Prisms(prisms) => prisms.get(owner).map(|p| p.top_m - p.base_m),
            Columns::Raster { tops, .. } => {
                tops.get(owner).map(|top| f64::from(top[1])).filter(|&h| h > BUILDING_THRESHOLD_M)
            }
        }
    }

    /// Returns the corners of the plate below the city, counterclockwise from the south-west, and
    /// the height of its foot.
    fn plate(&self) -> ([DVec2; 4], f64) {
        let DVec3 { x: w, y: d, .. } = self.size;
        ([[0.0, 0.0], [w, 0.0], [w, d], [0.0, d]].map(DVec2::from), -0.012 * w.max(d))
    }

    /// Makes a view straight down, north up, in which the extent fills `size` \[px\].
    pub(crate) fn view_from_above(&self, size: [usize; 2]) -> View {
        let above = DVec3::new(0.0, 0.0, self.size.z + 1.0);
        let mut view = View::new(Projection::Parallel, above, DVec3::NEG_Z, DVec3::Y);
        let corners = [DVec3::ZERO, DVec3::new(self.size.x, self.size.y, 0.0)];
        view.fit(corners.into_iter(), DVec2::new(size[0] as f64, size[1] as f64), 0.0);
        view
    }

    /// Calls `draw` with the corners and the tag of each face that `view` may see, in local
    /// coordinates.
    fn faces(&self, view: &View, mut draw: impl FnMut(&[DVec3], u64)) {
        let (corners, floor) = self.plate();
        for (k, outward) in SIDES.into_iter().enumerate() {
            draw(&wall(corners[k], corners[(k + 1) % 4], [0.0, floor]), wall_tag(outward, PLATE));
        }
        match &self.model {
            Columns::Prisms(prisms) => {
                draw(&corners.map(|c| c.extend(0.0)), GROUND);
                for (i, prism) in prisms.iter().enumerate() {
                    let owner = (i as u64 + 1).min(PLATE - 1);
                    self.prism_faces(prism, owner, &mut draw);
                }
            }
            Columns::Raster { tops, n_cols, n_rows } => self.column_faces(tops, *n_cols, *n_rows, view, &mut draw),
        }
    }

    fn prism_faces(&self, prism: &CityPrism, owner: u64, draw: &mut impl FnMut(&[DVec3], u64)) {
        let base = prism.base_m - self.origin.z;
        for triangle in &prism.roof_triangles {
            let corners = triangle.map(|p| DVec3::from(p) - self.origin);
            draw(&corners, slope_tag(corners, owner));
        }
        for edge in &prism.wall_edges {
            let [from, to] = edge.map(|p| DVec3::from(p) - self.origin);
            let outward = (to - from).truncate().perp();
            if outward != DVec2::ZERO {
                let (foot_from, foot_to) = (from.truncate().extend(base), to.truncate().extend(base));
                draw(&[from, to, foot_to, foot_from], wall_tag(outward, owner));
            }
        }
    }

    fn column_faces(
        &self,
        tops: &[[f32; 2]],
        n_cols: usize,
        n_rows: usize,
        view: &View,
        draw: &mut impl FnMut(&[DVec3], u64),
    ) {
        let step = DVec2::new(self.size.x / n_cols as f64, self.size.y / n_rows as f64);
        let top_of = |row: usize, col: usize| f64::from(tops[row * n_cols + col][0]) - self.origin.z;
        let box_of = |row: usize, from_col: usize, to_col: usize| {
            let low = DVec2::new(from_col as f64 * step.x, self.size.y - (row as f64 + 1.0) * step.y);
            let high = low + DVec2::new((to_col - from_col) as f64 * step.x, step.y);
            [low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)]
        };
        for row in 0..n_rows {
            // Neighbors of equal height share one roof.
            let bits = |col: usize| tops[row * n_cols + col].map(f32::to_bits);
            let mut run = 0;
            for col in 0..n_cols {
                if bits(col) != bits(run) {
                    run = col;
                }
                let top = top_of(row, col);
                if !top.is_finite() {
                    continue;
                }
                let owner = (row as u64 * n_cols as u64 + col as u64 + 1).min(PLATE - 1);
                if col + 1 == n_cols || bits(col + 1) != bits(col) {
                    draw(&box_of(row, run, col + 1).map(|c| c.extend(top)), owner);
                }
                let corners = box_of(row, col, col + 1);
                let neighbors = [
                    (row + 1 < n_rows).then(|| top_of(row + 1, col)),
                    (col + 1 < n_cols).then(|| top_of(row, col + 1)),
                    (row > 0).then(|| top_of(row - 1, col)),
                    (col > 0).then(|| top_of(row, col - 1)),
                ];
                for (k, (outward, neighbor)) in SIDES.into_iter().zip(neighbors).enumerate() {
                    let foot = neighbor.filter(|z| z.is_finite()).unwrap_or(0.0);
                    if foot < top && view.sees(corners[0].extend(top), outward.extend(0.0)) {
                        draw(&wall(corners[k], corners[(k + 1) % 4], [top, foot]), wall_tag(outward, owner));
                    }
                }
            }
        }
    }

    /// Draws all faces into a buffer of `size` \[px\].
    pub(crate) fn buffer(&self, view: &View, size: [usize; 2]) -> ZBuffer {
        let mut buffer = ZBuffer::new(size[0], size[1]);
        self.faces(view, |corners, tag| {
            let first = view.project(corners[0]);
            for pair in corners[1..].windows(2) {
                buffer.triangle([first, view.project(pair[0]), view.project(pair[1])], tag);
            }
        });
        buffer
    }

    /// Fits a view to the plate and the roofs; in a raster, to every fourth row and column.
    pub(crate) fn fit(&self, view: &mut View, size: DVec2, margin: f64) -> DVec2 {
        let DVec3 { x: w, y: d, .. } = self.size;
        let (plate, floor) = self.plate();
        let mut points: Vec<DVec3> = plate.iter().flat_map(|c| [c.extend(0.0), c.extend(floor)]).collect();
        match &self.model {
            Columns::Prisms(prisms) => {
                for prism in *prisms {
                    points.extend(prism.wall_edges.iter().flatten().map(|&c| DVec3::from(c) - self.origin));
                }
            }
            Columns::Raster { tops, n_cols, n_rows } => {
                for row in (0..*n_rows).step_by(4) {
                    for col in (0..*n_cols).step_by(4) {
                        let top = f64::from(tops[row * n_cols + col][0]) - self.origin.z;
                        let place =
                            DVec2::new(w * col as f64 / *n_cols as f64, d * (1.0 - row as f64 / *n_rows as f64));
                        points.extend(top.is_finite().then(|| place.extend(top)));
                    }
                }
            }
        }
        view.fit(points.into_iter(), size, margin)
    }
}

/// Samples a height raster down to [`MOST_COLUMNS`] a side; returns it with its lowest ground and
/// highest top.
fn thin<'a>(heights: &CityHeights<'_>) -> (Columns<'a>, f64, f64) {
    let thinned = |n: usize| n.div_ceil(n.div_ceil(MOST_COLUMNS));
    let (n_cols, n_rows) = (thinned(heights.n_cols), thinned(heights.n_rows));
    let mut tops = Vec::with_capacity(n_cols * n_rows);
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for row in 0..n_rows {
        let from_row = (2 * row + 1) * heights.n_rows / (2 * n_rows);
        for col in 0..n_cols {
            let cell = from_row * heights.n_cols + (2 * col + 1) * heights.n_cols / (2 * n_cols);
            let top = heights.surface_m[cell];
            let ground = heights.ground_m[cell];
            if top.is_finite() && ground.is_finite() {
                low = low.min(f64::from(ground.min(top)));
                high = high.max(f64::from(top));
            }
            tops.push([top, if ground.is_finite() { top - ground } else { 0.0 }]);
        }
    }
    (Columns::Raster { tops, n_cols, n_rows }, low, high)
}

/// Outward directions of the walls of a box, the first one to the south.
const SIDES: [DVec2; 4] = [DVec2::NEG_Y, DVec2::X, DVec2::Y, DVec2::NEG_X];

/// Returns the corners of a wall between two heights.
fn wall(from: DVec2, to: DVec2, [top, foot]: [f64; 2]) -> [DVec3; 4] {
    [from.extend(top), to.extend(top), to.extend(foot), from.extend(foot)]
}

/// Tags a wall: the direction of its normal in 254 steps around a square, which needs no angle.
fn wall_tag(outward: DVec2, owner: u64) -> u64 {
    let t = outward.y / (outward.x.abs() + outward.y.abs());
    let around = if outward.x >= 0.0 { 1.0 + t } else { 3.0 - t };
    let step = colors::index(around / 4.0 * 254.0, 253) as u64;
    (step + 1) << OWNER_BITS | owner
}

/// Tags a roof: the eastern and the northern component of its normal, in 16 bits each.
fn slope_tag([a, b, c]: [DVec3; 3], owner: u64) -> u64 {
    let normal = (b - a).cross(c - a).normalize_or_zero() * (b - a).cross(c - a).z.signum();
    #[expect(clippy::cast_possible_truncation, reason = "within ±32767")]
    let part = |v: f64| u64::from(((v * 32_767.0) as i16).cast_unsigned());
    (part(normal.x) | part(normal.y) << 16) << SLOPE_BITS | owner
}

/// Returns `true` when a face is a roof, or ground.
pub(crate) fn is_roof(tag: u64) -> bool {
    (tag >> OWNER_BITS).trailing_zeros() >= SLOPE_BITS - OWNER_BITS
}

/// Returns the normal of a tagged face.
pub(crate) fn normal_of(tag: u64) -> DVec3 {
    if is_roof(tag) {
        let part = |from: u32| {
            let bits = (tag >> (SLOPE_BITS + from) & 0xFFFF) as u16;
            f64::from(bits.cast_signed()) / 32_767.0
        };
        let (x, y) = (part(0), part(16));
        return DVec3::new(x, y, (1.0 - x * x - y * y).max(0.0).sqrt());
    }
    let code = (tag >> OWNER_BITS & 0xFF) as u8;
    let around = (f64::from(code) - 0.5) / 254.0 * 4.0;
    let (x, y) = if around < 2.0 {
        (1.0 - (around - 1.0).abs(), around - 1.0)
    } else {
        ((3.0 - around).abs() - 1.0, 3.0 - around)
    };
    DVec3::new(x, y, 0.0).normalize()
}

/// Returns a square building for tests.
#[cfg(test)]
pub(crate) fn block(west: f64, south: f64, side: f64, top_m: f64) -> CityPrism {
    let (e, n) = (west + side, south + side);
    let ring = [[west, south], [e, south], [e, n], [west, n]].map(|[x, y]| [x, y, top_m]);
    let roof_triangles = vec![[ring[0], ring[1], ring[2]], [ring[0], ring[2], ring[3]]];
    let wall_edges = (0..4).map(|k| [ring[k], ring[(k + 1) % 4]]).collect();
    CityPrism { roof_triangles, wall_edges, base_m: 0.0, top_m }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wall_normals_survive_their_tag() {
        for (x, y) in [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0), (0.6, -0.8), (-0.6, 0.8), (-0.1, -3.0)] {
            let normal = normal_of(wall_tag(DVec2::new(x, y), 5));
            assert!(normal.truncate().dot(DVec2::new(x, y).normalize()) > 0.999, "{x}, {y}: {normal}");
        }
        assert_eq!(normal_of(5), DVec3::Z);
    }

    #[test]
    fn normals_of_slopes_survive_their_tag_and_look_up() {
        // Rises by 3 in 4 to the east, whichever way its corners run.
        let (a, b, c) = (DVec3::ZERO, DVec3::new(4.0, 0.0, 3.0), DVec3::new(4.0, 4.0, 3.0));
        for corners in [[a, b, c], [c, b, a]] {
            let tag = slope_tag(corners, 7);
            assert!(is_roof(tag) && tag & OWNER == 7);
            assert!((normal_of(tag) - DVec3::new(-0.6, 0.0, 0.8)).length() < 1e-3, "{}", normal_of(tag));
        }
        assert!(!is_roof(wall_tag(DVec2::X, 7)) && is_roof(slope_tag([DVec3::ZERO; 3], 7)));
    }
}
