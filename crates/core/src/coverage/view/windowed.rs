//! A scene that is read window by window, as one UAV sees it.

use std::ops::Range;
use std::sync::Arc;

use super::scene::{check_drop, in_meters};
use crate::coverage::Uav;
use crate::error::Result;
use crate::height_field::{Curvature, Drops, GridPositions, HeightField};
use crate::los::{ColumnsReader, StreamedHeights};
use crate::raster::CellWindow;

/// Raster as one UAV sees it, in parts.
#[derive(Debug)]
pub(in crate::coverage) struct WindowedView<'v> {
    uav: &'v Uav,
    /// `None` over a flat earth.
    curve: Option<(Curvature, Drops)>,
}

/// Columns and what receivers stand on, read as one UAV sees them.
#[derive(Clone, Copy)]
pub(in crate::coverage) struct SeenColumns<'a> {
    flat: &'a dyn ColumnsReader,
    drops: Option<&'a Drops>,
    /// The one height that all receivers stand on over a flat earth \[1/1024 m\]; `None` where they
    /// stand on what the reader hands out.
    base: Option<i32>,
}

impl<'v> WindowedView<'v> {
    /// Returns the view of a UAV over cells at some positions.
    ///
    /// # Errors
    /// E118 for an earth so curved that heights would leave the lattice.
    pub(in crate::coverage) fn of(
        uav: &'v Uav,
        positions: &GridPositions,
        earth: (Option<Curvature>, f64),
        lowest_known: Option<i32>,
    ) -> Result<Self> {
        let (curvature, meters_per_unit) = earth;
        let drops = |of| (of, Drops::new(positions, &uav.station.place, of, meters_per_unit));
        let view = WindowedView { uav, curve: curvature.map(drops) };
        if view.is_curved() {
            let (n_rows, n_cols) = positions.shape();
            let most = view.most_drop(CellWindow { row: 0, col: 0, n_rows, n_cols });
            check_drop(in_meters(most), lowest_known)?;
        }
        Ok(view)
    }

    /// Returns the UAV.
    pub(in crate::coverage) fn uav(&self) -> &'v Uav {
        self.uav
    }

    /// Returns whether the earth is curved.
    pub(in crate::coverage) fn is_curved(&self) -> bool {
        self.curve.is_some()
    }

    fn drops(&self) -> Option<&Drops> {
        self.curve.as_ref().map(|(_, drops)| drops)
    }

    /// Returns the largest drop of a window that is not empty \[1/1024 m\]; 0 over a flat earth.
    pub(in crate::coverage) fn most_drop(&self, window: CellWindow) -> i64 {
        self.drops().map_or(0, |drops| drops.most(window))
    }

    /// Returns some rows of the scene with their heights as they are seen.
    pub(in crate::coverage) fn rows(&self, field: HeightField, rows: Range<usize>) -> HeightField {
        let Some((curvature, drops)) = &self.curve else { return field };
        let drops = Arc::new(drops.of_rows(rows));
        field.bent(&self.uav.station.place, *curvature, &drops, field.grid().window())
    }

    /// Returns a layer's height over a cell \[m\] as a height above the datum.
    pub(in crate::coverage) fn raised(&self, lowered: f32, cell: (usize, usize)) -> f32 {
        self.drops().map_or(lowered, |drops| drops.raised(lowered, cell))
    }

    /// Returns columns within a window and heights of receivers over them, as they are seen.
    pub(in crate::coverage) fn seen<'s>(
        &'s self,
        flat: &'s dyn ColumnsReader,
        heights: StreamedHeights,
        window: CellWindow,
    ) -> (SeenColumns<'s>, StreamedHeights) {
        let drops = self.drops();
        let most = i32::try_from(self.most_drop(window)).unwrap_or(i32::MAX);
        let (heights, base) = match heights {
            heights if drops.is_none() => (heights, None),
            StreamedHeights::Flat(z) => {
                let range = (z.saturating_sub(most), z);
                (StreamedHeights::Over { is_top: false, above: 0, range }, Some(z))
            }
            StreamedHeights::Over { is_top, above, range: (low, high) } => {
                (StreamedHeights::Over { is_top, above, range: (low.saturating_sub(most), high) }, None)
            }
        };
        (SeenColumns { flat, drops, base }, heights)
    }
}

impl SeenColumns<'_> {
    fn lower(&self, cells: &mut [i32], window: CellWindow) {
        if let Some(drops) = self.drops {
            drops.lower(cells, window);
        }
    }
}

impl ColumnsReader for SeenColumns<'_> {
    fn shape(&self) -> (usize, usize) {
        self.flat.shape()
    }

    fn read_tops(&self, window: CellWindow, tops: &mut Vec<i32>) -> Result<()> {
        self.flat.read_tops(window, tops)?;
        self.lower(tops, window);
        Ok(())
    }

    fn read_bases(&self, window: CellWindow, bases: &mut Vec<i32>) -> Result<()> {
        match self.base {
            Some(base) => {
                bases.clear();
                bases.resize(window.n_rows * window.n_cols, base);
            }
            None => self.flat.read_bases(window, bases)?,
        }
        self.lower(bases, window);
        Ok(())
    }
}
