//! A band of rows on which shadows are cast: its hidden cells, and its cells in doubt.

use fearless_simd::Simd;

use super::super::prisms_ray::prisms_los;
use super::cast::Cast;
use super::ceiling::Ceiling;
use super::geometry::as_f64;
use super::outline::Outline;
use super::plane::Plane;
use super::reach::LANES;
use super::scene::{Receivers, ShadowScene};
use super::sloped::SlopedRoof;
use super::spans::{Lanes, below_ceiling, maybe_spans, spans};
use super::words::{bits_outside, clear, for_each_bit};
use crate::quantity::LatticePoint;

/// Rows, and columns, of a tile: one word of bits.
pub(super) const TILE: usize = 64;

/// Most words in a row that a narrow shadow may meet.
const NARROW: usize = 3;

/// One band of rows.
pub(super) struct BandJob<'a> {
    pub(super) scene: &'a ShadowScene<'a>,
    pub(super) plane: &'a Plane,
    pub(super) receivers: &'a Receivers,
    pub(super) rows: (usize, usize),
    /// The wanted cells right below or above the UAV.
    pub(super) at_uav: &'a [(usize, usize)],
}

/// A run of cells of a row on the boundary of some shadow, or so near that rounding matters.
struct Doubt {
    row: u32,
    cols: (u32, u32),
}

/// The state of a band during processing.
pub(super) struct Band<'a> {
    /// Wanted cells that are not yet hidden.
    words: &'a mut [u64],
    words_per_row: usize,
    /// For each tile, number of its first rows that hold no such cell any more.
    closed_rows: Vec<u8>,
    doubts: Vec<Doubt>,
    /// Words of the present row of tiles; the flag is `true` if all receivers of a word are surely
    /// below the present ceiling.
    tiles_to_do: Vec<(usize, bool)>,
}

impl BandJob<'_> {
    /// Clears the cells that the blocks of casters hide. Returns the number of remaining cells and
    /// the number decided by `ray`.
    #[inline(always)]
    pub(super) fn cast<S: Simd>(&self, simd: S, cast: &Cast<'_>, words: &mut [u64]) -> (u64, u64) {
        let mut band = Band::new(words, self.scene.wanted.words_per_row());
        let tiles = self.tile_heights();
        if let Some((lowest, highest)) = self.heights(&tiles) {
            // On a curved earth outlines hold for receivers below the UAV only.
            let is_level = lowest == highest && (self.plane.curve == 0.0 || lowest < self.plane.uav.z);
            let mut outline = Outline::default();
            let mut ceiling = Ceiling::default();
            for block in cast.blocks() {
                let Some(reach) = self.plane.reach(block.bounds, block.max_top, lowest) else { continue };
                let [w, s, e, n] = block.bounds;
                let box_ring = [[w, s], [e, s], [e, n], [w, n]];
                let is_in_view = outline.cast(self.plane, &box_ring, block.bounds, reach.from(block.begin));
                if !is_in_view || self.is_dark(&outline, &mut band) {
                    continue;
                }
                for (caster, begin) in cast.of_block(block) {
                    let Some(reach) = self.plane.reach(caster.bounds, caster.top, lowest) else { break };
                    let of_scene = (cast.all(), caster);
                    if outline.cast_roof(self.plane, of_scene, reach.from(begin), lowest) {
                        if is_level {
                            self.hide(simd, &outline, &mut band);
                        } else {
                            let ring = cast.all().ring(caster);
                            match SlopedRoof::of(cast.all(), caster) {
                                Some(roof) => ceiling.cast_sloped(self.plane, &roof, caster.top),
                                None if self.plane.curve == 0.0 => ceiling.cast(self.plane, ring, caster.top),
                                None => {
                                    ceiling.cast_curved(self.plane, ring, (caster.top, caster.bounds), reach.far);
                                }
                            }
                            self.hide_relief(simd, &outline, &ceiling, &tiles, &mut band);
                        }
                    }
                }
            }
        }
        let asked = self.settle(&mut band);
        (band.words.iter().map(|w| u64::from(w.count_ones())).sum(), asked)
    }

    /// Returns the lowest and the highest receiver of each tile; in a tile without receivers the
    /// first exceeds the second. Returns nothing for receivers at one level.
    fn tile_heights(&self) -> Vec<(f64, f64)> {
        let Receivers::Relief { heights, width } = self.receivers else { return Vec::new() };
        let wanted = self.scene.wanted;
        let words_per_row = wanted.words_per_row();
        let n_tiles = (self.rows.1 - self.rows.0).div_ceil(TILE) * words_per_row;
        let mut tiles = vec![(f64::INFINITY, f64::NEG_INFINITY); n_tiles];
        for row in self.rows.0..self.rows.1 {
            for_each_bit(wanted.row(row), 0, wanted.n_cols(), |col| {
                let z = heights[row * width + col];
                let tile = &mut tiles[(row - self.rows.0) / TILE * words_per_row + col / 64];
                *tile = (tile.0.min(z), tile.1.max(z));
            });
        }
        tiles
    }

    /// Returns the lowest and the highest receiver of the band, if there is one.
    fn heights(&self, tiles: &[(f64, f64)]) -> Option<(i64, i64)> {
        if let Receivers::Level(z) = self.receivers {
            return Some((*z, *z));
        }
        let (low, high) = tiles.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |a, b| (a.0.min(b.0), a.1.max(b.1)));
        #[expect(clippy::cast_possible_truncation, reason = "came from an i32")]
        let range = (low as i64, high as i64);
        (low <= high).then_some(range)
    }

    /// Splits an outline's rows, clipped to the band, into strips: rows `.0..=.1` of one row of
    /// tiles.
    #[inline(always)]
    fn strips(&self, rows: (usize, usize)) -> impl Iterator<Item = (usize, usize)> + use<> {
        let (first, end) = (rows.0.max(self.rows.0), rows.1.min(self.rows.1));
        let origin = self.rows.0;
        let mut row = first;
        std::iter::from_fn(move || {
            (row < end).then(|| {
                let from = row;
                row = (origin + ((from - origin) / TILE + 1) * TILE).min(end);
                (from, row - 1)
            })
        })
    }

    /// Returns `true` if no wanted cell that the outline may meet is left.
    #[inline(always)]
    fn is_dark(&self, outline: &Outline, band: &mut Band<'_>) -> bool {
        let rows = outline.rows(self.plane).maybe;
        self.strips(rows).all(|(first, last)| match outline.columns_between(self.plane, first, last) {
            None => true,
            Some(cols) => band.is_closed((first - self.rows.0) / TILE, cols),
        })
    }

    /// Clears the cells of one shadow on receivers at one height.
    ///
    /// PERF: most shadows are a few words wide. There each word of eight rows gets its mask without
    /// a branch (vectorized), which took a quarter off all times (AVX-512). A branch predictor
    /// fails there: whether a span begins, ends or is empty in a word is a coin toss.
    #[inline(always)]
    pub(super) fn hide<S: Simd>(&self, simd: S, outline: &Outline, band: &mut Band<'_>) {
        let rows = outline.rows(self.plane);
        let is_short = rows.maybe.1 - rows.maybe.0.min(rows.maybe.1) <= TILE;
        let words_per_row = band.words_per_row;
        for (first, last) in self.strips(rows.maybe) {
            let cols =
                if is_short { outline.columns(self.plane) } else { outline.columns_between(self.plane, first, last) };
            let Some(cols) = cols else { continue };
            if band.is_closed((first - self.rows.0) / TILE, cols) {
                continue;
            }
            let (first_word, last_word) = (cols.0 / 64, (cols.1 - 1) / 64);
            let is_narrow = last_word - first_word < NARROW;
            let mut row = first;
            while row <= last {
                let n = (last + 1 - row).min(LANES);
                let spans = spans(simd, self.plane, outline, row);
                let rows_of_band = &mut band.words[(row - self.rows.0) * words_per_row..];
                if !spans.is_all_sure || row < rows.sure.0 || row + n > rows.sure.1 {
                    let maybe = maybe_spans(simd, self.plane, outline, row);
                    self.hide_in_doubt(&spans.sure, &maybe, (row, n), rows.sure, band);
                } else if is_narrow {
                    for word in first_word..=last_word {
                        let base = word as u64 * 64;
                        let kept: [u64; LANES] =
                            std::array::from_fn(|k| bits_outside(spans.sure.0[k], spans.sure.1[k], base));
                        for (words, kept) in rows_of_band.chunks_exact_mut(words_per_row).zip(&kept[..n]) {
                            words[word] &= kept;
                        }
                    }
                } else {
                    for (k, words) in rows_of_band.chunks_exact_mut(words_per_row).take(n).enumerate() {
                        clear(words, spans.sure.0[k], spans.sure.1[k]);
                    }
                }
                row += LANES;
            }
        }
    }

    /// Hides receivers behind a part of a shadow in `n` rows from `row` on, some of which have
    /// cells in doubt.
    #[inline(never)]
    fn hide_in_doubt(
        &self,
        inner: &Lanes,
        outer: &Lanes,
        (row, n): (usize, usize),
        sure: (usize, usize),
        band: &mut Band<'_>,
    ) {
        for k in 0..n {
            let (maybe, mut inner) = ((outer.0[k], outer.1[k]), (inner.0[k], inner.1[k]));
            if row + k < sure.0 || row + k >= sure.1 || inner.0 >= inner.1 {
                inner = (maybe.1, maybe.1);
            }
            clear(band.row_mut(row + k - self.rows.0), inner.0, inner.1);
            band.doubt(row + k, maybe.0, inner.0);
            band.doubt(row + k, inner.1, maybe.1);
        }
    }

    /// Clears the cells of one shadow on receivers at differing heights. The outline is that on the
    /// lowest of all receivers.
    #[inline(always)]
    fn hide_relief<S: Simd>(
        &self,
        simd: S,
        outline: &Outline,
        ceiling: &Ceiling,
        tiles: &[(f64, f64)],
        band: &mut Band<'_>,
    ) {
        let Receivers::Relief { heights, width } = self.receivers else { return };
        let rows = outline.rows(self.plane);
        let words_per_row = band.words_per_row;
        for (first, last) in self.strips(rows.maybe) {
            let Some(cols) = outline.columns_between(self.plane, first, last) else { continue };
            let tile_row = (first - self.rows.0) / TILE;
            band.tiles_to_do.clear();
            for word in cols.0 / 64..=(cols.1 - 1) / 64 {
                if band.is_closed(tile_row, (word * 64, word * 64 + 1)) {
                    continue;
                }
                let (lowest, highest) = tiles[tile_row * words_per_row + word];
                let ends = (as_f64(word * 64), as_f64(word * 64 + 63));
                let (low, high) = ceiling.range(self.plane, (self.plane.q[first], self.plane.q[last]), ends);
                if lowest < ceiling.cap_maybe && lowest <= high {
                    band.tiles_to_do.push((word, highest < low && highest < ceiling.cap));
                }
            }
            if band.tiles_to_do.is_empty() {
                continue;
            }
            for row in (first..=last).step_by(LANES) {
                let n = (last + 1 - row).min(LANES);
                let spans = spans(simd, self.plane, outline, row);
                let is_all_sure = spans.is_all_sure && row >= rows.sure.0 && row + n <= rows.sure.1;
                let maybe = if is_all_sure { None } else { Some(maybe_spans(simd, self.plane, outline, row)) };
                for k in 0..n {
                    let is_sure_row = row + k >= rows.sure.0 && row + k < rows.sure.1;
                    for t in 0..band.tiles_to_do.len() {
                        let (word, is_below) = band.tiles_to_do[t];
                        let at = (row + k - self.rows.0) * words_per_row + word;
                        let (open, base) = (band.words[at], word as u64 * 64);
                        let inside = |lanes: &Lanes| open & !bits_outside(lanes.0[k], lanes.1[k], base);
                        let sure = if is_sure_row { inside(&spans.sure) } else { 0 };
                        let maybe = maybe.as_ref().map_or(0, inside) & !sure;
                        if sure | maybe == 0 {
                            continue;
                        }
                        let (below, near) = if is_below {
                            (u64::MAX, 0)
                        } else {
                            let heights = &heights[(row + k) * width + word * 64..][..64];
                            below_ceiling(simd, self.plane, ceiling, self.plane.q[row + k], as_f64(word * 64), heights)
                        };
                        band.words[at] &= !(sure & below);
                        let doubts = sure & near | maybe & (below | near);
                        if doubts != 0 {
                            band.doubt_bits(row + k, word, doubts);
                        }
                    }
                }
            }
        }
    }

    /// Decides by `ray` all doubts that are still open, and the cell right below or above the UAV.
    /// Returns their number.
    pub(super) fn settle(&self, band: &mut Band<'_>) -> u64 {
        let (uav, grid) = (self.plane.uav, self.scene.grid);
        let mut cells: Vec<(usize, usize)> =
            self.at_uav.iter().copied().filter(|(row, _)| (self.rows.0..self.rows.1).contains(row)).collect();
        for doubt in std::mem::take(&mut band.doubts) {
            let row = doubt.row as usize;
            let cols = (doubt.cols.0 as usize, doubt.cols.1 as usize);
            for_each_bit(band.row_mut(row - self.rows.0), cols.0, cols.1, |col| cells.push((row, col)));
        }
        cells.sort_unstable();
        cells.dedup();
        for &(row, col) in &cells {
            let receiver = LatticePoint { x: grid.xs[col], y: grid.ys[row], z: self.receivers.at(row, col) };
            let is_los = prisms_los(self.scene.prisms, uav, receiver);
            let word = &mut band.row_mut(row - self.rows.0)[col / 64];
            *word = *word & !(1 << (col % 64)) | u64::from(is_los) << (col % 64);
        }
        cells.len() as u64
    }
}

impl<'a> Band<'a> {
    /// Makes a band of rows of `words_per_row` words each, in which nothing is hidden yet.
    pub(super) fn new(words: &'a mut [u64], words_per_row: usize) -> Self {
        let n_tiles = (words.len() / words_per_row.max(1)).div_ceil(TILE) * words_per_row;
        Band { words, words_per_row, closed_rows: vec![0; n_tiles], doubts: Vec::new(), tiles_to_do: Vec::new() }
    }

    #[inline(always)]
    fn row_mut(&mut self, row: usize) -> &mut [u64] {
        &mut self.words[row * self.words_per_row..(row + 1) * self.words_per_row]
    }

    fn doubt(&mut self, row: usize, first: u64, end: u64) {
        if first < end {
            let narrow = |v: u64| u32::try_from(v).unwrap_or(u32::MAX);
            self.doubts.push(Doubt { row: narrow(row as u64), cols: (narrow(first), narrow(end)) });
        }
    }

    #[cold]
    fn doubt_bits(&mut self, row: usize, word: usize, mut bits: u64) {
        while bits != 0 {
            let col = word as u64 * 64 + u64::from(bits.trailing_zeros());
            self.doubt(row, col, col + 1);
            bits &= bits - 1;
        }
    }

    /// Returns `true` if no wanted cell is left in the tiles of a row of tiles that hold columns
    /// `cols.0..cols.1`.
    ///
    /// PERF: bits are only ever cleared, so rows found empty stay empty, and each tile remembers
    /// their number. All calls for a tile together look at each of its rows once, and once at its
    /// first row that is not empty.
    #[inline(always)]
    fn is_closed(&mut self, tile_row: usize, cols: (usize, usize)) -> bool {
        let n_rows = (self.words.len() / self.words_per_row - tile_row * TILE).min(TILE);
        let mut word = cols.0 / 64;
        while word * 64 < cols.1 {
            let closed_rows = &mut self.closed_rows[tile_row * self.words_per_row + word];
            let mut row = usize::from(*closed_rows);
            while row < n_rows && self.words[(tile_row * TILE + row) * self.words_per_row + word] == 0 {
                row += 1;
            }
            *closed_rows = u8::try_from(row).unwrap_or(u8::MAX);
            if row < n_rows {
                return false;
            }
            word += 1;
        }
        true
    }
}
