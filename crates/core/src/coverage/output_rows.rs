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

    /// Returns margins, least receiver heights and least heights of the UAV, as far as they are
    /// wanted.
    pub(super) fn into_layers(self) -> [Option<Vec<f32>>; 3] {
        [self.margin, self.least_receiver_height, self.least_height]
            .map(|layer| Some(layer).filter(|of| !of.is_empty()))
    }
}

/// Taker of one part of a mask after another.
pub(super) type EachPart<'a> = &'a mut (dyn FnMut(&[u8]) + Send);

/// Cells of a band of rows that is handed over at once.
pub(super) const BAND_CELLS: usize = 1 << 20;

/// Fills bands one after another, and hands each over while the next one is filled; returns the sum
/// of what `fill` counts.
pub(super) fn in_turns<B: Send + Sync>(
    mut bands: impl Iterator<Item = B>,
    fill: impl Fn(&mut B) -> Tally + Sync,
    mut hand_over: impl FnMut(&B) + Send,
) -> Tally {
    let mut tally = Tally::default();
    let mut filled: Option<B> = None;
    loop {
        let mut band = bands.next();
        let (of_band, ()) =
            rayon::join(|| band.as_mut().map_or_else(Tally::default, &fill), || filled.iter().for_each(&mut hand_over));
        tally = tally.plus(&of_band);
        filled = band;
        if filled.is_none() {
            return tally;
        }
    }
}

/// Sums the tallies of rows that are counted side by side.
pub(super) fn summed(rows: impl IndexedParallelIterator<Item = Tally>) -> Tally {
    rows.reduce(Tally::default, |a, b| a.plus(&b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_are_filled_and_handed_over_in_order() {
        for n in [0_u8, 1, 2, 7, 64] {
            let fill = |band: &mut u8| {
                *band += 1;
                Tally::of_mask(&[0])
            };
            let mut found = Vec::new();
            let tally = in_turns(0..n, fill, |band| found.push(*band));
            assert_eq!((found, tally.receivers), ((1..=n).collect(), u64::from(n)), "{n} bands");
        }
    }
}
