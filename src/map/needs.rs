//! Memory of maps beside the scene \[bytes per cell\], as it was measured over generated and noisy
//! rasters of 1000² to 4000² cells.

use skyshed_request::Layer;

use super::plan::MapFiles;
use crate::answer::Output;
use crate::coverage::maps_at_once;
use crate::export::Format;
use crate::memory::picture_bytes_per_cell;

/// Parts of a map that take memory.
#[derive(Debug, Clone, Copy)]
pub(super) struct MapNeeds<'a> {
    /// Cells of the grid.
    pub(super) n_cells: usize,
    pub(super) layers: &'a [Layer],
    pub(super) files: MapFiles<'a>,
    /// UAVs of the map.
    pub(super) n_uavs: usize,
    /// UAVs of the whole list.
    pub(super) n_list: usize,
    /// Masks that are held at once.
    pub(super) n_held: usize,
}

impl<'a> MapNeeds<'a> {
    /// Returns the needs of one UAV with its mask.
    pub(super) fn of_one(n_cells: usize, layers: &'a [Layer], outputs: &'a [Output]) -> Self {
        let files = MapFiles { outputs, ..MapFiles::default() };
        MapNeeds { n_cells, layers, files, n_uavs: 1, n_list: 1, n_held: 1 }
    }

    /// Returns the bytes per cell while the map is made and written.
    pub(super) fn bytes_per_cell(&self) -> f64 {
        /// Bits of cells in sight.
        const OF_BITS: f64 = 0.25;
        /// Number of each cell's part, and the edges around parts.
        const OF_POLYGONS: f64 = 5.0;
        /// Least heights by row, and all of them sorted.
        const OF_CURVES: f64 = 6.0;
        let of = |is_made: bool, bytes: f64| if is_made { bytes } else { 0.0 };
        OF_BITS
            + self.of_maps()
            + overlay_bytes_per_cell(self.layers, self.n_list)
            + self.of_outputs()
            + of(self.files.polygons, OF_POLYGONS)
            + of(self.files.curves, OF_CURVES)
            + of(self.files.over_time, 2.0 * of_stretches(self.n_list))
    }

    /// Returns the bytes per cell of masks and of layers for each UAV.
    fn of_maps(&self) -> f64 {
        /// Heights behind a layer while it is made.
        const HEIGHTS: f64 = 8.0;
        /// Probabilities, and two maps that bound them.
        const P_LOS: f64 = 6.0;
        let n_measures = n_measures(self.layers);
        let n_at_once = self.n_held.clamp(1, maps_at_once());
        let of_p_los = if self.layers.contains(&Layer::PLos) { P_LOS } else { 0.0 };
        of_p_los + count(self.n_held) * (1.0 + 4.0 * n_measures) + count(n_at_once) * HEIGHTS * n_measures
    }

    /// Returns the bytes per cell that the largest output takes while it is made.
    fn of_outputs(&self) -> f64 {
        let n_of_all = count(self.layers.iter().filter(|layer| layer.is_of_all()).count());
        let n_masks = if self.layers.iter().all(|layer| layer.is_of_all()) { 0.0 } else { count(self.n_uavs) };
        let is_los = self.layers.contains(&Layer::Los);
        let of_format = |format: Format| match format {
            Format::Png | Format::Svg | Format::Pdf => picture_bytes_per_cell(self.n_cells),
            Format::Kmz => 6.0,
            // Masks become numbers of 4 bytes; measures are numbers already.
            Format::Exr => 4.0 * n_masks + 8.0 * n_of_all,
            // One array for each layer holds all UAVs.
            Format::Npz => n_masks * (1.0 + 4.0 * n_measures(self.layers)) + 8.0 * n_of_all,
            Format::AsciiGrid => 2.0,
            Format::Bil => 4.0,
            // Coarser levels and compressed tiles; a mask that is handed over has none.
            Format::GeoTiff if self.n_held == 0 => 0.0,
            Format::GeoTiff if self.layers == [Layer::Los] => 0.4 * n_masks,
            Format::GeoTiff if is_los => 1.8 * n_masks,
            Format::GeoTiff if self.layers.contains(&Layer::Which) => 5.5,
            Format::GeoTiff => 2.0 * n_of_all,
            _ => 0.0,
        };
        self.files.outputs.iter().map(|(_, format)| of_format(*format)).fold(0.0, f64::max)
    }
}

/// Returns the bytes per cell of the overlay of all masks, for layers over a list of `n_uavs` UAVs.
pub(super) fn overlay_bytes_per_cell(layers: &[Layer], n_uavs: usize) -> f64 {
    const UNION_AND_COUNT: f64 = 6.75;
    const BEST_SERVER: f64 = 12.0;
    let of_layer = |layer: &Layer| match layer {
        Layer::Which => count(4 * n_uavs.div_ceil(32)),
        Layer::BestServer => BEST_SERVER,
        Layer::All => 1.0,
        // The layer, and stretches of time, of both layers once.
        Layer::Uptime => 4.0 + of_stretches(n_uavs),
        Layer::Gap if layers.contains(&Layer::Uptime) => 4.0,
        Layer::Gap => 4.0 + of_stretches(n_uavs),
        _ => 0.0,
    };
    let of_layers = layers.iter().map(of_layer).sum::<f64>();
    if n_uavs > 1 || of_layers > 0.0 { UNION_AND_COUNT + of_layers } else { 0.0 }
}

/// Returns the bytes per cell of the stretches of time in which UAVs see it.
fn of_stretches(n_uavs: usize) -> f64 {
    count(4 * (2 * n_uavs + 1).div_ceil(32))
}

/// Returns the number of layers of numbers.
fn n_measures(layers: &[Layer]) -> f64 {
    count(layers.iter().filter(|layer| layer.is_measure()).count())
}

#[expect(clippy::cast_precision_loss, reason = "an estimate")]
fn count(n: usize) -> f64 {
    n as f64
}
