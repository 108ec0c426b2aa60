//! Maps of many UAVs over one scene: several at once, each shared by the threads that are free.

use rayon::prelude::*;

use super::view::Mapper;
use super::{Control, Overlay, SiteCoverage, Together, Uav};
use crate::error::Result;
use crate::quantity::STEPS_PER_UNIT;
use crate::raster::CellWindow;

/// Time for which the masks and layers of maps are kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum KeepMasks {
    /// With the maps.
    Always,
    /// Until `each` has returned, so that memory does not grow with the number of UAVs: at most
    /// [`maps_at_once`] masks are held.
    UntilTold,
    /// One UAV: its mask is handed over part by part and never held, and no layers of heights are
    /// made. Several UAVs: as `UntilTold`.
    Never,
}

/// The maps of some UAVs, in their order.
#[derive(Debug, Clone)]
pub struct ManyMaps {
    /// The maps; without masks and layers where they were not to be kept.
    pub sites: Vec<SiteCoverage>,
    /// Layers over all UAVs. `None` for a single UAV, unless [`Together::even_of_one`] asks for them.
    pub overlay: Option<Overlay>,
}

impl Mapper<'_> {
    /// Maps what each of some UAVs sees. Calls `each_part` with one part of the masks after
    /// another, in the order of the UAVs and from the north, and `each` with every map once its
    /// mask is complete.
    ///
    /// The outcome does not depend on the number of threads.
    pub fn map_many(
        &self,
        uavs: &[Uav],
        (keep, together): (KeepMasks, &Together),
        control: &Control,
        mut each_part: impl FnMut(&[u8]) + Send,
        mut each: impl FnMut(&SiteCoverage),
    ) -> Result<ManyMaps> {
        let is_windowed = self.options.window.is_some();
        let window = self.options.window.unwrap_or_else(|| self.field().grid().window());
        let mut sites: Vec<SiteCoverage> = Vec::with_capacity(uavs.len());
        let mut overlay = (uavs.len() != 1 || together.even_of_one)
            .then(|| Overlay::of_cells(self.known_cells(window), together, uavs));
        for chunk in uavs.chunks(maps_at_once()) {
            let maps: Vec<SiteCoverage> = match chunk {
                [one] if !is_windowed => {
                    let is_held = overlay.is_some() || keep != KeepMasks::Never;
                    vec![self.seen_from(one)?.map_in_parts(control, Some(&mut each_part), is_held)?]
                }
                _ => chunk.par_iter().map(|uav| self.seen_from(uav)?.map(control)).collect::<Result<_>>()?,
            };
            for mut site in maps {
                if chunk.len() > 1 || is_windowed {
                    each_part(&site.mask);
                }
                each(&site);
                if let Some(overlay) = &mut overlay {
                    let k = together.of_list.as_ref().map_or(sites.len(), |(places, _)| places[sites.len()]);
                    let squared_m2 = self.squared_distances_m2(&site.uav, window);
                    overlay.add_one_of((k, &site.uav), (&site.mask, window.n_cols), squared_m2);
                }
                if keep != KeepMasks::Always {
                    site = SiteCoverage::of_tally(&site.uav, site.tally);
                }
                sites.push(site);
            }
        }
        if let Some(overlay) = &mut overlay {
            overlay.finish(together);
        }
        Ok(ManyMaps { sites, overlay })
    }

    /// Tells for each cell of a window, row by row, whether a height is known there.
    fn known_cells(&self, window: CellWindow) -> impl Iterator<Item = bool> {
        let cells = self.field().cells();
        let rows = window.row..window.row + window.n_rows;
        rows.flat_map(move |row| (window.col..window.col + window.n_cols).map(move |col| (row, col)))
            .map(|(row, col)| cells.open.contains(row, col) || cells.building.contains(row, col))
    }

    /// Returns the squared distance from a UAV to the receiver of each cell of a window \[m²\],
    /// from whole lattice steps: equal distances are equal numbers.
    #[expect(clippy::cast_precision_loss, reason = "steps in reach are below 2^53")]
    fn squared_distances_m2(&self, uav: &Uav, window: CellWindow) -> impl Fn((usize, usize)) -> f64 + Sync {
        let (positions, unit) = (self.positions(), self.options.meters_per_unit);
        let (step_x, step_y) = positions.step_lengths();
        let at = positions.on_range(&uav.station.place);
        let z = uav.station.z;
        move |(row, col)| {
            let (row, col) = (window.row + row, window.col + col);
            let (dx, dy) = positions.steps(at, (row, col));
            let of_cell = self.receivers.iter().find(|of_kind| of_kind.cells.contains(row, col));
            let receiver = of_cell.map_or(z, |of_kind| of_kind.height(row * of_kind.cells.n_cols() + col));
            let (x, y) = (dx as f64 * step_x * unit, dy as f64 * step_y * unit);
            let height = (receiver - z) as f64 / f64::from(STEPS_PER_UNIT);
            x * x + y * y + height * height
        }
    }
}

/// Returns the number of maps made at once: enough to keep every thread busy where maps are small.
pub fn maps_at_once() -> usize {
    2 * rayon::current_num_threads()
}
