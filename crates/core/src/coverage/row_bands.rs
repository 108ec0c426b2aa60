//! Rows of a map's outputs, filled in bands of which each is handed over while the next is filled.

use std::ops::Range;

use rayon::prelude::*;

use super::{HeightLayers, Tally};

/// Row of every output; rows of layers that are not wanted are empty.
pub(super) struct Row<'a> {
    pub(super) mask: &'a mut [u8],
    pub(super) margin: &'a mut [f32],
    pub(super) least_receiver_height: &'a mut [f32],
    pub(super) least_height: &'a mut [f32],
}

impl<'a> Row<'a> {
    /// Returns the row of a mask without layers.
    pub(super) fn of_mask(mask: &'a mut [u8]) -> Self {
        Row { mask, margin: &mut [], least_receiver_height: &mut [], least_height: &mut [] }
    }

    /// Sets the least receiver height and the margin of a cell \[m\], as far as these are wanted.
    #[inline]
    pub(super) fn set_heights(&mut self, col: usize, (least, margin): (f32, f32)) {
        if let Some(v) = self.least_receiver_height.get_mut(col) {
            *v = least;
        }
        if let Some(v) = self.margin.get_mut(col) {
            *v = margin;
        }
    }
}

/// Layers of heights of some rows; those that are not wanted are empty.
#[derive(Debug)]
pub(super) struct HeightRows {
    n_cols: usize,
    margin: Vec<f32>,
    least_receiver_height: Vec<f32>,
    least_height: Vec<f32>,
}

impl HeightRows {
    /// Returns layers without a height.
    pub(super) fn new(layers: HeightLayers, n_rows: usize, n_cols: usize) -> Self {
        let layer = |is_wanted: bool| if is_wanted { vec![f32::NAN; n_rows * n_cols] } else { Vec::new() };
        HeightRows {
            n_cols,
            margin: layer(layers.margin),
            least_receiver_height: layer(layers.least_receiver_height),
            least_height: layer(layers.least_height),
        }
    }

    /// Splits some rows, and the mask of these.
    pub(super) fn rows<'r>(&'r mut self, rows: Range<usize>, mask: &'r mut [u8]) -> impl Iterator<Item = Row<'r>> {
        let n_cols = self.n_cols;
        let split = |layer: &'r mut [f32]| {
            let n = if layer.is_empty() { 0 } else { n_cols };
            let rows = layer[rows.start * n..rows.end * n].chunks_mut(n_cols);
            rows.chain(std::iter::repeat_with(Default::default))
        };
        let heights = split(&mut self.margin).zip(split(&mut self.least_receiver_height));
        let rows = mask.chunks_mut(n_cols).zip(heights).zip(split(&mut self.least_height));
        rows.map(|((mask, (margin, least_receiver_height)), least_height)| Row {
            mask,
            margin,
            least_receiver_height,
            least_height,
        })
    }

    /// Returns margins, least receiver heights and least heights of the UAV, as far as they are wanted.
    pub(super) fn into_layers(self) -> [Option<Vec<f32>>; 3] {
        [self.margin, self.least_receiver_height, self.least_height]
            .map(|layer| Some(layer).filter(|of| !of.is_empty()))
    }
}

/// What takes one part of a mask after another.
pub(super) type EachPart<'a> = &'a mut (dyn FnMut(&[u8]) + Send);

/// Cells of a band of rows that is handed over at once.
pub(super) const BAND_CELLS: usize = 1 << 20;

/// Fills rows band by band, and hands each band over while the next one is filled; the sum of what `fill` counts.
pub(super) fn in_bands<'a>(
    mut rows: impl Iterator<Item = (usize, Row<'a>)>,
    n_at_once: usize,
    fill: impl Fn(usize, &mut Row<'a>) -> Tally + Sync,
    each_part: EachPart<'_>,
) -> Tally {
    let mut tally = Tally::default();
    let mut filled: Vec<(usize, Row<'a>)> = Vec::new();
    loop {
        let mut band: Vec<(usize, Row<'a>)> = rows.by_ref().take(n_at_once).collect();
        let (of_band, ()) = rayon::join(
            || {
                let rows = band.par_iter_mut().map(|(row, out)| fill(*row, out));
                rows.reduce(Tally::default, |a, b| a.plus(&b))
            },
            || filled.iter().for_each(|(_, row)| each_part(row.mask)),
        );
        tally = tally.plus(&of_band);
        filled = band;
        if filled.is_empty() {
            return tally;
        }
    }
}

/// Fills masks of some rows band by band as [`in_bands`] does, each band over one that was handed over before.
pub(super) fn in_buffers(
    rows: Range<usize>,
    n_cols: usize,
    n_at_once: usize,
    fill: impl Fn(usize, &mut [u8]) -> Tally + Sync,
    each_part: EachPart<'_>,
) -> Tally {
    let mut tally = Tally::default();
    let buffer = || vec![0; n_at_once.min(rows.len()) * n_cols];
    let (mut next, mut filled) = (buffer(), buffer());
    let mut n_filled = 0;
    for first in rows.clone().step_by(n_at_once) {
        let n_here = n_at_once.min(rows.end - first) * n_cols;
        let (of_band, ()) = rayon::join(
            || {
                let rows = next[..n_here].par_chunks_mut(n_cols).enumerate();
                rows.map(|(k, mask)| fill(first + k, mask)).reduce(Tally::default, |a, b| a.plus(&b))
            },
            || {
                if n_filled > 0 {
                    each_part(&filled[..n_filled]);
                }
            },
        );
        tally = tally.plus(&of_band);
        std::mem::swap(&mut next, &mut filled);
        n_filled = n_here;
    }
    if n_filled > 0 {
        each_part(&filled[..n_filled]);
    }
    tally
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn masks_are_filled_and_handed_over_in_order_whatever_the_bands() {
        for n_rows in [0, 1, 2, 7, 64] {
            for n_at_once in [1, 2, 5, 63, 64, 65] {
                let mut mask = vec![0_u8; 3 * n_rows];
                let rows = mask.chunks_mut(3).map(Row::of_mask);
                let fill = |row: usize, out: &mut Row<'_>| {
                    out.mask.fill(u8::try_from(row).expect("few rows") + 1);
                    Tally::of_mask(&[0])
                };
                let mut found = Vec::new();
                let tally = in_bands(rows.enumerate(), n_at_once, fill, &mut |part| found.extend_from_slice(part));
                let expected: Vec<u8> = (1..).flat_map(|row| [row; 3]).take(3 * n_rows).collect();
                assert_eq!((&found, tally.receivers), (&expected, n_rows as u64), "{n_rows} rows, {n_at_once} at once");

                found.clear();
                let fill = |row: usize, mask: &mut [u8]| {
                    mask.fill(u8::try_from(row).expect("few rows") + 1);
                    Tally::of_mask(&[0])
                };
                let tally = in_buffers(0..n_rows, 3, n_at_once, fill, &mut |part| found.extend_from_slice(part));
                assert_eq!((found, tally.receivers), (expected, n_rows as u64), "{n_rows} rows, {n_at_once} buffered");
            }
        }
    }
}
