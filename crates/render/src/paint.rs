//! Conversion of cells to pixels: classes become colors, large rasters shrink, small ones grow.
//!
//! A raster of up to 2000 cells a side, fewer on small maps, keeps one whole number of pixels per
//! cell, so that a cell is a crisp rectangle. A larger one is reduced. A pixel is then the average,
//! in linear light, of the colors of all its cells, none skipped, and of the heights of some 16 of
//! them. Memory beyond the input is that of the picture. Cells that are not square keep their
//! proportions.

use std::sync::atomic::{AtomicBool, Ordering};

use image::RgbaImage;
use rayon::prelude::*;
use skyshed_core::raster::Surface;

use super::check;
use super::colors::{self, FULL_LIGHT, Light, Ramp, Rgb};

/// Class of open ground that holds no receiver. Pictures distinguish it from buildings; masks in
/// files do not.
pub const OPEN_GROUND: u8 = 4;

/// Offset of nodata among the indices behind the colors.
const NODATA: usize = 2;

/// Size of a map with a picture of its own: its longer side \[px\], and the most cells along it
/// that are drawn one by one.
pub(crate) const LARGE: (f64, f64) = (1400.0, 2000.0);
/// Largest side of a cell \[px\].
const LARGEST_CELL_PX: f64 = 320.0;
/// Strength of the hillshade on buildings; `FAINT_RELIEF` is that on cells out of range.
const RELIEF: f64 = 0.45;
const FAINT_RELIEF: f64 = 0.22;
/// Factor on the brightness of colors over buildings.
pub(crate) const RAISED: f64 = 0.8;

/// Mapping of cells to pixels along one axis.
#[derive(Clone, Copy, Debug)]
struct Axis {
    n_cells: usize,
    n_px: usize,
}

impl Axis {
    /// Returns the number of colors to compute: one per cell, or one per pixel if several cells
    /// share it.
    fn n_work(self) -> usize {
        self.n_cells.min(self.n_px)
    }

    fn work_of_px(self, px: usize) -> usize {
        px * self.n_work() / self.n_px
    }

    fn cells_of_work(self, work: usize) -> std::ops::Range<usize> {
        work * self.n_cells / self.n_work()..(work + 1) * self.n_cells / self.n_work()
    }

    fn px_per_cell(self) -> f64 {
        self.n_px as f64 / self.n_cells as f64
    }
}

/// A map to paint: the mapping of its cells to pixels, and the surface below them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Canvas<'a> {
    /// Columns and rows.
    axes: [Axis; 2],
    /// Cell size \[m\] along columns and rows.
    pub(crate) cell_m: (f64, f64),
    /// Surface heights \[m\].
    pub(crate) surface_m: Option<&'a [f32]>,
}

/// A painted map.
#[derive(Debug)]
pub(crate) struct Painted {
    /// The map, without furniture.
    pub(crate) image: RgbaImage,
    /// Cells per color, then not receivers, out of range, nodata, open ground. If no pixel is
    /// hatched, nodata is 0: a few such cells are lost in the colors of their neighbors.
    pub(crate) histogram: Vec<u64>,
}

/// Returns the index of a class that is no receiver, behind `n_colors` colors; `None` for a
/// receiver.
pub(crate) fn special(class: u8, n_colors: usize) -> Option<usize> {
    match class {
        0 | 1 => None,
        2 => Some(n_colors),
        3 => Some(n_colors + 1),
        OPEN_GROUND => Some(n_colors + 3),
        _ => Some(n_colors + NODATA),
    }
}

impl<'a> Canvas<'a> {
    /// Makes a map whose longer side aims at `target` \[px\]; it is reduced if it has more than
    /// `whole` cells.
    ///
    /// # Errors
    /// Cells without a size, or a surface of another shape.
    pub(crate) fn new(
        n_cells: [usize; 2],
        cell_m: (f64, f64),
        surface_m: Option<&'a [f32]>,
        (target, whole): (f64, f64),
    ) -> Result<Self, String> {
        let (cell_x, cell_y) = cell_m;
        if ![cell_x, cell_y].iter().all(|c| c.is_finite() && *c > 0.0) {
            return Err(format!("cannot draw a map of cells of {cell_x} × {cell_y} m: both must be above 0 m"));
        }
        surface_m.map_or(Ok(()), |surface| check::shape("surface", surface.len(), n_cells))?;
        let finest = cell_x.min(cell_y);
        let sides_m = [n_cells[0] as f64 * cell_x, n_cells[1] as f64 * cell_y];
        let longest = sides_m[0].max(sides_m[1]) / finest;
        let px_per_finest = if longest > whole {
            1.0 / (longest / target).round().max(2.0)
        } else {
            (target / longest).round().clamp(1.0, LARGEST_CELL_PX)
        };
        let axes = [0, 1].map(|k| {
            let n_px = colors::index((sides_m[k] / finest * px_per_finest).round(), 4000).max(1);
            Axis { n_cells: n_cells[k], n_px }
        });
        Ok(Self { axes, cell_m, surface_m })
    }

    /// Makes a map of one pixel per cell.
    pub(crate) fn bare(n_cells: [usize; 2], cell_m: (f64, f64), surface_m: &'a [f32]) -> Self {
        Self { axes: n_cells.map(|n| Axis { n_cells: n, n_px: n }), cell_m, surface_m: Some(surface_m) }
    }

    /// Returns width and height \[px\].
    pub(crate) fn size(&self) -> [f64; 2] {
        self.axes.map(|axis| axis.n_px as f64)
    }

    /// Returns the pixels of a cell along columns and rows.
    pub(crate) fn px_per_cell(&self) -> [f64; 2] {
        self.axes.map(Axis::px_per_cell)
    }

    /// Paints receivers in the colors of their indices, and other cells by their class.
    pub(crate) fn paint_receivers(
        &self,
        colors: &[Rgb],
        mask: &[u8],
        index_of: impl Fn(usize) -> usize + Sync,
    ) -> Painted {
        self.paint(colors, |cell| special(mask[cell], colors.len()).unwrap_or_else(|| index_of(cell)))
    }

    /// Paints all cells; indices from [`special`] follow behind the colors.
    pub(crate) fn paint(&self, colors: &[Rgb], index_of: impl Fn(usize) -> usize + Sync) -> Painted {
        let [across, down] = self.axes;
        let ground = Ground::new(self, |cell| index_of(cell) == colors.len());
        let packed = packed(colors);
        let mut pixels = vec![0_u8; across.n_px * down.n_px * 4];
        let is_hatched = AtomicBool::new(false);
        let paint_row = |mut histogram: Vec<u64>, (y, pixels): (usize, &mut [u8])| {
            let work_row = down.work_of_px(y);
            let first = y == 0 || down.work_of_px(y - 1) != work_row;
            let sums = sum_row(self.axes, &packed, &index_of, work_row, first.then_some(&mut histogram));
            let color = |(col, sum)| ground.color(sum, work_row, col);
            let row_colors: Vec<_> = sums.iter().enumerate().map(color).collect();
            if row_colors.contains(&None) {
                is_hatched.store(true, Ordering::Relaxed);
            }
            for (x, pixel) in pixels.chunks_exact_mut(4).enumerate() {
                let [r, g, b] = row_colors[across.work_of_px(x)].unwrap_or_else(|| hatch(x, y));
                pixel.copy_from_slice(&[r, g, b, 255]);
            }
            histogram
        };
        let none = || vec![0_u64; packed.len()];
        let rows = pixels.par_chunks_exact_mut(across.n_px * 4).enumerate();
        let mut histogram = rows.fold(none, paint_row).reduce(none, |mut sums, numbers| {
            add(&mut sums, &numbers);
            sums
        });
        if !is_hatched.into_inner() {
            histogram[colors.len() + NODATA] = 0;
        }
        let [width, height] = self.axes.map(|axis| u32::try_from(axis.n_px).expect("an image is smaller than that"));
        let image = RgbaImage::from_raw(width, height, pixels).expect("the buffer has this size");
        Painted { image, histogram }
    }
}

impl Canvas<'_> {
    /// Darkens pixels of an image of this canvas where the surface is above the ground.
    pub(crate) fn darken_raised(&self, image: &mut RgbaImage) {
        let (Some(surface_m), [across, down]) = (self.surface_m, self.axes) else { return };
        for (x, y, pixel) in image.enumerate_pixels_mut() {
            let col = across.cells_of_work(across.work_of_px(x as usize)).start;
            let row = down.cells_of_work(down.work_of_px(y as usize)).start;
            if surface_m[row * across.n_cells + col] > 0.5 {
                let [r, g, b, a] = pixel.0;
                let [r, g, b] = colors::shade([r, g, b], RAISED);
                pixel.0 = [r, g, b, a];
            }
        }
    }
}

/// Adds numbers of cells to sums of them.
pub(crate) fn add(sums: &mut [u64], numbers: &[u64]) {
    sums.iter_mut().zip(numbers).for_each(|(sum, n)| *sum += n);
}

/// Returns the color of a hatched pixel.
fn hatch(x: usize, y: usize) -> Rgb {
    if (x + y) % 14 < 3 { colors::HATCH } else { colors::WHITE }
}

/// Sums over the cells of one work cell.
#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    /// Linear light of flat colors.
    light: [u64; 3],
    /// Numbers of cells that are buildings, out of range, void.
    special: [u64; 3],
    /// Number of cells.
    n: u64,
}

/// Most cells that can be added before a lane of 21 bits overflows: 2²¹ / 2¹².
const RUN: usize = 512;

/// Packs colors and special classes as three 21-bit lanes per word, so that one addition sums three
/// numbers.
fn packed(colors: &[Rgb]) -> Vec<[u64; 2]> {
    let flat = |color: &Rgb| {
        let [r, g, b] = Light::tables().linear(*color).map(u64::from);
        [r | g << 21 | b << 42, 0]
    };
    let special = [[0, 1], [0, 1 << 21], [0, 1 << 42], flat(&colors::WHITE)];
    colors.iter().map(flat).chain(special).collect()
}

fn lanes(word: u64) -> [u64; 3] {
    [word & 0x1F_FFFF, word >> 21 & 0x1F_FFFF, word >> 42 & 0x1F_FFFF]
}

/// Sums one row of work cells, and counts palette entries into `histogram`.
///
/// PERF: two counters take turns because runs of equal cells would otherwise wait for the same
/// memory word.
fn sum_row(
    [across, down]: [Axis; 2],
    packed: &[[u64; 2]],
    index_of: impl Fn(usize) -> usize,
    work_row: usize,
    histogram: Option<&mut Vec<u64>>,
) -> Vec<Sum> {
    let mut sums = vec![Sum::default(); across.n_work()];
    let mut counts = vec![[0_u32; 2]; packed.len()];
    for row in down.cells_of_work(work_row) {
        for (work_col, sum) in sums.iter_mut().enumerate() {
            let range = across.cells_of_work(work_col);
            sum.n += range.len() as u64;
            let end = row * across.n_cells + range.end;
            let mut cell = row * across.n_cells + range.start;
            while cell < end {
                let stop = end.min(cell + RUN);
                let mut words = [0_u64; 2];
                while cell < stop {
                    let entry = index_of(cell);
                    counts[entry][cell & 1] += 1;
                    words[0] += packed[entry][0];
                    words[1] += packed[entry][1];
                    cell += 1;
                }
                let [light, special] = words.map(lanes);
                for k in 0..3 {
                    sum.light[k] += light[k];
                    sum.special[k] += special[k];
                }
            }
        }
    }
    if let Some(histogram) = histogram {
        for (total, count) in histogram.iter_mut().zip(&counts) {
            *total += u64::from(count[0]) + u64::from(count[1]);
        }
    }
    sums
}

/// Surface below a map at the resolution of the picture, with the tones of buildings.
#[derive(Debug)]
struct Ground<'a> {
    surface: Surface<'a>,
    /// Heights of the lightest and the darkest building \[m\], where heights are known.
    tones: Option<(f64, f64)>,
    /// Strength of the relief, 0 where cells are large.
    relief: f64,
}

impl<'a> Ground<'a> {
    fn new(canvas: &Canvas<'a>, is_building: impl Fn(usize) -> bool + Sync) -> Self {
        let Canvas { axes, cell_m, surface_m } = *canvas;
        let [across, down] = axes;
        let (n_cols, n_rows) = (across.n_work(), down.n_work());
        let heights = match surface_m {
            Some(surface) if [n_cols, n_rows] == axes.map(|axis| axis.n_cells) => surface.into(),
            Some(surface) => reduce(axes, |cell| surface[cell]).into(),
            // Without heights, buildings are blocks four cells high, which draws their outlines.
            None => {
                let block = narrow(cell_m.0.max(cell_m.1)) * 4.0;
                reduce(axes, |cell| if is_building(cell) { block } else { 0.0 }).into()
            }
        };
        let tones = surface_m.and_then(|surface| tone_range(surface, is_building));
        let px_per_cell = across.px_per_cell().min(down.px_per_cell());
        let step_m = (cell_m.0 * across.n_cells as f64 / n_cols as f64, cell_m.1 * down.n_cells as f64 / n_rows as f64);
        let relief = if px_per_cell >= 8.0 { 0.0 } else { 1.0 };
        Self { surface: Surface { heights, n_cols, n_rows, step_m }, tones, relief }
    }

    /// Returns the color of a work cell; `None` if most of it is void.
    fn color(&self, sum: &Sum, row: usize, col: usize) -> Option<Rgb> {
        let light = Light::tables();
        let [n_building, n_out, n_void] = sum.special;
        if 2 * n_void > sum.n {
            return None;
        }
        let mut total = sum.light;
        let mut add = |color: Rgb, n: u64| {
            let linear = light.linear(color);
            (0..3).for_each(|k| total[k] += u64::from(linear[k]) * n);
        };
        if n_building + n_out > 0 {
            let relief = (self.surface.light(row, col) - 1.0) * self.relief;
            if n_building > 0 {
                let height = f64::from(self.surface.heights[row * self.surface.n_cols + col]);
                let tone = self.tones.map(|(low, high)| (height - low) / (high - low)).filter(|tone| tone.is_finite());
                let flat = tone.map_or(colors::BUILDING, |tone| Ramp::BuildingTone.at(tone));
                add(colors::shade(flat, (1.0 + RELIEF * relief).clamp(0.55, 1.3)), n_building);
            }
            add(colors::shade(colors::OUT_OF_RANGE, 1.0 + FAINT_RELIEF * relief), n_out);
        }
        let n = sum.n - n_void;
        Some(total.map(|t| light.srgb(u32::try_from((t + n / 2) / n).unwrap_or(FULL_LIGHT))))
    }
}

/// Averages a surface over work cells, from up to four by four samples each; unknown heights do not
/// count.
fn reduce(axes: [Axis; 2], height: impl Fn(usize) -> f32 + Sync) -> Vec<f32> {
    let [across, down] = axes;
    let samples = |range: std::ops::Range<usize>| {
        let n = range.len().min(4);
        (0..n).map(move |k| range.start + (2 * k + 1) * range.len() / (2 * n))
    };
    let mut heights = vec![0.0_f32; across.n_work() * down.n_work()];
    heights.par_chunks_exact_mut(across.n_work()).enumerate().for_each(|(work_row, out)| {
        for (work_col, out) in out.iter_mut().enumerate() {
            let (mut sum, mut n) = (0.0_f32, 0.0_f32);
            for row in samples(down.cells_of_work(work_row)) {
                for col in samples(across.cells_of_work(work_col)) {
                    let height = height(row * across.n_cells + col);
                    if height.is_finite() {
                        sum += height;
                        n += 1.0;
                    }
                }
            }
            *out = if n > 0.0 { sum / n } else { f32::NAN };
        }
    });
    heights
}

/// Returns the heights \[m\] between which most buildings lie, from a sample of at most about 200
/// 000.
fn tone_range(surface: &[f32], is_building: impl Fn(usize) -> bool) -> Option<(f64, f64)> {
    // An odd step does not fall into the rhythm of rows.
    let step = (surface.len() / 200_000).max(1) | 1;
    let heights: Vec<f32> =
        (0..surface.len()).step_by(step).filter(|&cell| is_building(cell)).map(|c| surface[c]).collect();
    let [low, high] = quantiles(heights, [0.02, 0.98])?;
    Some((low, high.max(low + 1.0)))
}

/// Returns quantiles of the finite values; `None` if there are none.
pub(crate) fn quantiles<const N: usize>(mut values: Vec<f32>, shares: [f64; N]) -> Option<[f64; N]> {
    values.retain(|v| v.is_finite());
    values.sort_unstable_by(f32::total_cmp);
    let last = values.len().checked_sub(1)?;
    Some(shares.map(|share| f64::from(values[colors::index(share * last as f64 + 0.5, last)])))
}

/// Rounds to single precision.
#[expect(clippy::cast_possible_truncation, reason = "rounding is what is wanted")]
pub(crate) fn narrow(value: f64) -> f32 {
    value as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn painted(n_cells: [usize; 2], mask: &[u8], surface_m: Option<&[f32]>) -> Painted {
        let canvas = Canvas::new(n_cells, (1.0, 1.0), surface_m, LARGE).expect("the map is valid");
        canvas.paint_receivers(&[colors::NLOS, colors::LOS], mask, |cell| usize::from(mask[cell]))
    }

    #[test]
    fn sizes_are_whole_multiples_and_stay_within_bounds() {
        let px = |n_cells, cell_m| Canvas::new(n_cells, cell_m, None, LARGE).expect("the map is valid").size();
        for (n_cells, cell_m, size) in [
            ([5, 4], (1.0, 1.0), [1400.0, 1120.0]),
            ([1, 1], (1.0, 1.0), [320.0, 320.0]),
            ([1474, 1205], (1.0, 1.0), [1474.0, 1205.0]),
            ([1, 500], (1.0, 1.0), [3.0, 1500.0]),
            ([40, 40], (2.5, 1.0), [1400.0, 560.0]),
            ([16384, 16384], (1.0, 1.0), [1365.0, 1365.0]),
        ] {
            assert_eq!(px(n_cells, cell_m).map(f64::to_bits), size.map(f64::to_bits), "{n_cells:?}");
        }
        assert!((4..9000).all(|n| (933.0..=2000.0).contains(&px([n, 1], (1.0, 1.0))[0])));
    }

    #[test]
    fn reduction_keeps_uniform_colors_and_averages_mixtures() {
        let mut mask = vec![1_u8; 3000 * 3000];
        mask[..3000 * 1500].fill(0);
        (1..3000 * 300).step_by(2).for_each(|cell| mask[cell] = 1);
        let map = painted([3000, 3000], &mask, None);
        assert_eq!(map.image.dimensions(), (1500, 1500));
        assert_eq!(map.image.get_pixel(700, 1400).0[..3], colors::LOS);
        assert_eq!(map.image.get_pixel(700, 700).0[..3], colors::NLOS);
        let half = map.image.get_pixel(700, 50).0;
        assert!(half[0] > 150 && half[0] < 180 && half[2] > 110 && half[2] < 145, "{half:?}");
        assert_eq!(map.histogram, [3000 * 1500 - 450_000, 3000 * 1500 + 450_000, 0, 0, 0, 0]);
    }

    #[test]
    fn quantiles_skip_what_is_not_finite() {
        assert_eq!(quantiles(vec![f32::NAN, 1.0, 2.0, 3.0], [0.0, 1.0]), Some([1.0, 3.0]));
        assert_eq!(quantiles(vec![f32::INFINITY], [0.5]), None);
    }
}
