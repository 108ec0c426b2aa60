//! Casters of shadows: the prisms joined across buildings of equal height, in blocks of neighbors.
//!
//! A shadow is the same whosever it is, so pieces of equal top that share a wall are joined even
//! across buildings. There are fewer shadows then, and fewer walls on whose lines a shadow ends and
//! the next begins. Sloped ones are joined within their plane. Neighbors stand next to each other
//! in the list, so that far blocks can be handled as one.

use std::cmp::Reverse;

use super::RoofPlane;
use super::merge::merged;
use crate::overlay::bounds_of;

/// Edge length of a block of casters \[lattice steps\]: 64 m.
const BLOCK: i32 = 64 * 1024;

/// A convex prism that casts a shadow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Caster {
    first: u32,
    len: u32,
    /// Begin of the heights of its corners, if it is sloped.
    heights: Option<u32>,
    /// Top \[1/1024 m above the datum\], of a sloped roof the highest.
    pub top: i32,
    /// Bounding box \[lattice steps\]: west, south, east, north.
    pub bounds: [i32; 4],
}

/// Casters whose bounding boxes begin in the same square of the plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CasterBlock {
    first: u32,
    len: u32,
    /// The highest top \[1/1024 m above the datum\].
    pub max_top: i32,
    /// Bounding box of all casters of the block \[lattice steps\]: west, south, east, north.
    pub bounds: [i32; 4],
}

impl CasterBlock {
    /// Returns numbers of its casters among all.
    pub fn numbers(&self) -> std::ops::Range<u32> {
        self.first..self.first + self.len
    }
}

/// All casters of a scene; their union, with tops, is that of its prisms.
#[derive(Debug, Clone, Default)]
pub struct Casters {
    vertices: Vec<[i32; 2]>,
    heights: Vec<i32>,
    casters: Vec<Caster>,
    blocks: Vec<CasterBlock>,
}

/// A convex roof as it is told: its highest top, its ring, and the heights of its corners if it is
/// sloped.
#[derive(Debug, Clone, Copy)]
pub(super) struct CasterRoof<'a> {
    top: i32,
    ring: &'a [[i32; 2]],
    heights: Option<&'a [i32]>,
}

impl<'a> From<(i32, &'a [[i32; 2]], Option<&'a [i32]>)> for CasterRoof<'a> {
    fn from((top, ring, heights): (i32, &'a [[i32; 2]], Option<&'a [i32]>)) -> Self {
        CasterRoof { top, ring, heights }
    }
}

impl CasterRoof<'_> {
    /// Returns a key that roofs share which can be one.
    fn key(&self) -> [i128; 4] {
        let plane = self.heights.map(|heights| RoofPlane::through(self.ring, heights));
        plane.map_or([0, 0, i128::from(self.top), 0], |plane| plane.key())
    }
}

impl Casters {
    /// Returns casters of convex counterclockwise rings with their tops.
    pub(super) fn new<'a>(roofs: impl Iterator<Item = CasterRoof<'a>>) -> Self {
        let roofs = roofs.filter(|roof| roof.ring.len() >= 3).enumerate();
        let mut roofs: Vec<([i128; 4], usize, CasterRoof<'_>)> = roofs.map(|(k, roof)| (roof.key(), k, roof)).collect();
        // The outcome follows from the order of the pieces.
        roofs.sort_unstable_by_key(|(key, k, _)| (*key, *k));
        let mut joined = Casters::default();
        joined.begin_block();
        for in_one_plane in roofs.chunk_by(|a, b| a.0 == b.0) {
            match in_one_plane {
                [(.., roof)] => joined.push(*roof),
                [] => {}
                [(.., CasterRoof { top, ring, heights }), ..] => {
                    let plane = heights.map(|heights| RoofPlane::through(ring, heights));
                    for ring in &merged(in_one_plane.iter().map(|(.., roof)| roof.ring.to_vec()).collect()) {
                        // Its corners are corners of the pieces, whose heights are of the lattice.
                        let at = |[x, y]: &[i32; 2]| plane.map(|p| p.lowest_above(i64::from(*x), i64::from(*y)));
                        let heights: Option<Vec<i32>> = ring.iter().map(at).collect();
                        let top = heights.iter().flatten().max().unwrap_or(top);
                        joined.push(CasterRoof { top: *top, ring, heights: heights.as_deref() });
                    }
                }
            }
        }
        let block_of = |c: &Caster| [c.bounds[1], c.bounds[0]].map(|v| v.div_euclid(BLOCK));
        let mut order: Vec<_> =
            joined.casters.iter().enumerate().map(|(k, c)| (block_of(c), Reverse(c.top), k)).collect();
        order.sort_unstable();
        let mut all = Casters::default();
        for of_block in order.chunk_by(|a, b| a.0 == b.0) {
            all.begin_block();
            for (.., k) in of_block {
                let caster = joined.casters[*k];
                all.push(joined.roof(&caster));
            }
        }
        all
    }

    /// Returns some of the casters, in the same blocks.
    pub fn kept(&self, keep: impl Fn(&Caster) -> bool) -> Casters {
        let mut kept = Casters::default();
        for block in &self.blocks {
            let mut of_block = self.of_block(block).iter().filter(|c| keep(c)).peekable();
            if of_block.peek().is_some() {
                kept.begin_block();
            }
            of_block.for_each(|caster| kept.push(self.roof(caster)));
        }
        kept
    }

    /// Begins a block without casters.
    fn begin_block(&mut self) {
        let first = u32::try_from(self.casters.len()).unwrap_or(u32::MAX);
        self.blocks.push(CasterBlock { first, len: 0, max_top: i32::MIN, bounds: bounds_of(&[]) });
    }

    /// Adds a caster to the last block.
    fn push(&mut self, CasterRoof { top, ring, heights }: CasterRoof<'_>) {
        let narrow = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
        let bounds = bounds_of(ring);
        let first_height = heights.map(|_| narrow(self.heights.len()));
        let (first, len) = (narrow(self.vertices.len()), narrow(ring.len()));
        let caster = Caster { first, len, heights: first_height, top, bounds };
        self.vertices.extend(ring);
        self.heights.extend(heights.unwrap_or_default());
        if let Some(b) = self.blocks.last_mut() {
            b.len += 1;
            b.max_top = b.max_top.max(caster.top);
            let c = caster.bounds;
            b.bounds = [b.bounds[0].min(c[0]), b.bounds[1].min(c[1]), b.bounds[2].max(c[2]), b.bounds[3].max(c[3])];
        }
        self.casters.push(caster);
    }

    /// Returns the blocks, row by row from the south-west.
    pub fn blocks(&self) -> &[CasterBlock] {
        &self.blocks
    }

    /// Returns the casters of a block, highest first.
    #[inline]
    pub fn of_block(&self, block: &CasterBlock) -> &[Caster] {
        &self.casters[block.first as usize..(block.first + block.len) as usize]
    }

    /// Returns all casters, block by block.
    pub fn all(&self) -> &[Caster] {
        &self.casters
    }

    /// Returns the convex counterclockwise ring of a caster, without vertices on straight edges.
    #[inline]
    pub fn ring(&self, caster: &Caster) -> &[[i32; 2]] {
        &self.vertices[caster.first as usize..(caster.first + caster.len) as usize]
    }

    /// Returns the heights of the corners of a caster \[1/1024 m above the datum\]; `None` of one
    /// with a flat top.
    #[inline]
    pub fn heights(&self, caster: &Caster) -> Option<&[i32]> {
        caster.heights.map(|first| &self.heights[first as usize..(first + caster.len) as usize])
    }

    /// Returns the lowest and the highest of a caster's top \[1/1024 m above the datum\].
    #[inline]
    pub fn range(&self, caster: &Caster) -> (i32, i32) {
        let lowest = self.heights(caster).and_then(|heights| heights.iter().min());
        (lowest.copied().unwrap_or(caster.top), caster.top)
    }

    fn roof(&self, caster: &Caster) -> CasterRoof<'_> {
        CasterRoof { top: caster.top, ring: self.ring(caster), heights: self.heights(caster) }
    }
}
