//! Estimates of the time and memory of a run, before it starts.

use std::path::PathBuf;

use crate::coverage::HeightLayers;
use crate::height_field::HeightField;
use crate::los::Method;
use crate::memory::{FIELD_BYTES_PER_CELL, memory_words, whole_bytes};
use crate::progress::Progress;
use crate::scene::format_of;
use skyshed_io::{FileFormat, FileKind};

/// Estimated time and memory of a run.
#[derive(Debug)]
pub(crate) struct Expected {
    bytes: u64,
    seconds: f64,
}

impl Expected {
    /// Estimates maps over a field from `asked.0` UAVs, with the layers `asked.1`. The radius is in
    /// units of its grid.
    pub(crate) fn over(
        field: &HeightField,
        method: Method,
        radius: Option<f64>,
        asked: (usize, HeightLayers),
        bytes_per_cell: f64,
    ) -> Self {
        let grid = field.grid();
        let disc = radius.map_or(f64::INFINITY, |r| std::f64::consts::PI * r * r);
        #[expect(clippy::cast_precision_loss, reason = "an estimate")]
        let n_in_range = (disc / (grid.cell_width() * grid.cell_height())).min(grid.n_cells() as f64);
        Self::of((method, rayon::current_num_threads()), (grid.n_cells(), n_in_range), asked, bytes_per_cell)
    }

    /// Estimates a method on some threads, from the numbers of cells of the grid and of cells in
    /// range of a UAV.
    pub(crate) fn of(
        (method, n_threads): (Method, usize),
        (n_cells, n_in_range): (usize, f64),
        (n_uavs, layers): (usize, HeightLayers),
        bytes_per_cell: f64,
    ) -> Self {
        // Nanoseconds per cell on one core of a server of 2023: of a map, of margins and least
        // receiver heights (computed together), and of least UAV heights.
        let (map, receiver, uav) = match method {
            Method::Ray | Method::ShadowRay => (150.0, 600.0, 600.0),
            // About 3 ns for each of the 50 samples until the ray is above the roofs.
            Method::Step(length) => (150.0 / length.cells(), 0.0, 0.0),
            Method::Sweep | Method::ShadowSweep => (6.0, 50.0, 500.0),
            Method::Xdraw | Method::R2 => (10.0, 0.0, 0.0),
            Method::Shadow => (5.0, 10.0, 60.0),
        };
        let of = |is_asked: bool, cost: f64| if is_asked { cost } else { 0.0 };
        let per_cell = map
            + of(layers.margin || layers.least_receiver_height, receiver)
            + of(layers.least_height, uav)
            + of(layers.stability, 8.0 * map)
            + of(layers.sure, 2.0 * map)
            + of(layers.p_los, 600.0);
        let seconds = n_in_range * n_uavs as f64 / n_threads as f64 * per_cell * 1e-9;
        let bytes = whole_bytes(n_cells as f64 * (FIELD_BYTES_PER_CELL + bytes_per_cell));
        Expected { bytes, seconds }
    }

    /// Sets the time of the line of sight from its CPU time over all threads \[s\]; unchanged if
    /// that is `None`.
    pub(crate) fn with_cpu_seconds(self, cpu_s: Option<f64>) -> Self {
        #[expect(clippy::cast_precision_loss, reason = "a few threads")]
        let n_threads = rayon::current_num_threads() as f64;
        Expected { seconds: cpu_s.map_or(self.seconds, |cpu_s| cpu_s / n_threads), ..self }
    }

    /// Returns the expected time of the line of sight \[s\].
    pub(crate) fn seconds(&self) -> f64 {
        self.seconds
    }

    /// Returns the message before a long or large run; `None` for other runs.
    pub(crate) fn words(&self) -> Option<String> {
        let is_large = self.seconds >= 5.0 || self.bytes >= 1 << 30;
        is_large.then(|| {
            let memory = memory_words(self.bytes);
            format!("expect about {memory} of memory and {:.0} s for the line of sight", self.seconds.max(1.0))
        })
    }

    /// Prints the message before a long or large run.
    pub(crate) fn tell(&self, progress: &Progress) {
        self.words().iter().for_each(|words| (progress.note)(words));
    }
}

/// Estimates the time to read some files and to build a city from them \[s\], by their sizes.
pub(crate) fn seconds_to_read(files: &[PathBuf]) -> f64 {
    let seconds = |file: &PathBuf| {
        // Nanoseconds per byte on one core of a server of 2023.
        let per_byte = match format_of(file) {
            Some(FileFormat::GeoJson | FileFormat::CityJson | FileFormat::CityGml | FileFormat::PointCloud) => 40.0,
            Some(format) if format.kind() == Some(FileKind::Vector) => 80.0,
            // Heights of a terrain or a surface, deflated or as text.
            _ => 15.0,
        };
        let n_bytes = std::fs::metadata(file).map_or(0, |metadata| metadata.len());
        #[expect(clippy::cast_precision_loss, reason = "an estimate")]
        let seconds = n_bytes as f64 * per_byte * 1e-9;
        seconds
    };
    #[expect(clippy::cast_precision_loss, reason = "a few threads")]
    let n_threads = rayon::current_num_threads() as f64;
    files.iter().map(seconds).sum::<f64>() / n_threads
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_large_runs_say_what_to_expect() {
        let cells = 1_000_000;
        let none = HeightLayers::default();
        let small = Expected::of((Method::Sweep, 2), (cells, 1e6), (1, none), 1.0);
        assert_eq!(small.words(), None);
        let long = Expected::of((Method::Ray, 2), (cells, 1e6), (100, HeightLayers { margin: true, ..none }), 5.0);
        assert_eq!(long.words().as_deref(), Some("expect about 12 MiB of memory and 38 s for the line of sight"));
        let wide = Expected::of((Method::Sweep, 2), (16_384 * 16_384, 1e5), (1, none), 1.0);
        assert_eq!(wide.words().as_deref(), Some("expect about 2.2 GiB of memory and 1 s for the line of sight"));
    }
}
