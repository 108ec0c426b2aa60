//! What casts shadows: the prisms joined across buildings of equal height, in blocks of neighbors.
//!
//! A shadow does not ask whose it is, so pieces of equal top that share a wall are joined even across buildings: there
//! are fewer shadows then, and fewer walls on whose lines a shadow ends and the next begins. Neighbors stand next to each
//! other in the list, so that far blocks can be handled as one.

use std::cmp::Reverse;

use super::merge::merged;
use crate::overlay::bounds_of;

/// Edge length of a block of casters \[lattice steps\]: 64 m.
const BLOCK: i32 = 64 * 1024;

/// A convex prism that casts a shadow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Caster {
    first: u32,
    len: u32,
    /// Top \[1/1024 m above the datum\].
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
    /// Numbers of its casters among all.
    pub fn numbers(&self) -> std::ops::Range<u32> {
        self.first..self.first + self.len
    }
}

/// All casters of a scene; their union, with tops, is that of its prisms.
#[derive(Debug, Clone, Default)]
pub struct Casters {
    vertices: Vec<[i32; 2]>,
    casters: Vec<Caster>,
    blocks: Vec<CasterBlock>,
}

impl Casters {
    /// Casters of convex counterclockwise rings with their tops.
    pub(super) fn new<'a>(rings: impl Iterator<Item = (i32, &'a [[i32; 2]])>) -> Self {
        let mut rings: Vec<(i32, usize, &[[i32; 2]])> =
            rings.enumerate().filter(|(_, (_, ring))| ring.len() >= 3).map(|(k, (top, ring))| (top, k, ring)).collect();
        // The outcome follows from the order of the pieces.
        rings.sort_unstable_by_key(|(top, k, _)| (*top, *k));
        let mut joined = Casters::default();
        joined.begin_block();
        for same_top in rings.chunk_by(|a, b| a.0 == b.0) {
            match same_top {
                [(top, _, ring)] => joined.push(*top, ring),
                [] => {}
                [(top, ..), ..] => {
                    let rings = merged(same_top.iter().map(|(.., ring)| ring.to_vec()).collect());
                    rings.iter().for_each(|ring| joined.push(*top, ring));
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
                all.push(caster.top, joined.ring(&caster));
            }
        }
        all
    }

    /// Some of the casters, in the same blocks.
    pub fn kept(&self, keep: impl Fn(&Caster) -> bool) -> Casters {
        let mut kept = Casters::default();
        for block in &self.blocks {
            let mut of_block = self.of_block(block).iter().filter(|c| keep(c)).peekable();
            if of_block.peek().is_some() {
                kept.begin_block();
            }
            of_block.for_each(|caster| kept.push(caster.top, self.ring(caster)));
        }
        kept
    }

    /// Begins a block without casters.
    fn begin_block(&mut self) {
        let first = u32::try_from(self.casters.len()).unwrap_or(u32::MAX);
        self.blocks.push(CasterBlock { first, len: 0, max_top: i32::MIN, bounds: bounds_of(&[]) });
    }

    /// Adds a caster to the last block.
    fn push(&mut self, top: i32, ring: &[[i32; 2]]) {
        let narrow = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
        let bounds = bounds_of(ring);
        let caster = Caster { first: narrow(self.vertices.len()), len: narrow(ring.len()), top, bounds };
        self.vertices.extend(ring);
        if let Some(b) = self.blocks.last_mut() {
            b.len += 1;
            b.max_top = b.max_top.max(caster.top);
            let c = caster.bounds;
            b.bounds = [b.bounds[0].min(c[0]), b.bounds[1].min(c[1]), b.bounds[2].max(c[2]), b.bounds[3].max(c[3])];
        }
        self.casters.push(caster);
    }

    /// The blocks, row by row from the south-west.
    pub fn blocks(&self) -> &[CasterBlock] {
        &self.blocks
    }

    /// The casters of a block, highest first.
    #[inline]
    pub fn of_block(&self, block: &CasterBlock) -> &[Caster] {
        &self.casters[block.first as usize..(block.first + block.len) as usize]
    }

    /// All casters, block by block.
    pub fn all(&self) -> &[Caster] {
        &self.casters
    }

    /// The convex counterclockwise ring of a caster, without vertices on straight edges.
    #[inline]
    pub fn ring(&self, caster: &Caster) -> &[[i32; 2]] {
        &self.vertices[caster.first as usize..(caster.first + caster.len) as usize]
    }
}
