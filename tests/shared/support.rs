//! Random numbers and scenes for the suites: small lattices, so that ties and shared walls are frequent.

#![allow(dead_code, reason = "each binary uses a part")]

use skyshed_core::city::{BuiltUp, BuiltUpCity, Ground, Solids};
use skyshed_core::height_field::HeightField;
use skyshed_core::quantity::LatticePoint;
use skyshed_core::raster::{BitGrid, GeoRef, Raster};

/// SplitMix64 (Steele, Lea & Flood 2014): five lines, the same everywhere.
#[derive(Clone, Debug)]
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A number in `low..=high`.
    pub(crate) fn within(&mut self, low: i64, high: i64) -> i64 {
        let span = u64::try_from(high - low + 1).unwrap();
        low + i64::try_from(self.next() % span).unwrap()
    }

    /// A number below `n`.
    pub(crate) fn below(&mut self, n: usize) -> usize {
        usize::try_from(self.next() % u64::try_from(n).unwrap()).unwrap()
    }

    /// An index in `low..=high`.
    pub(crate) fn index(&mut self, low: usize, high: usize) -> usize {
        low + self.below(high - low + 1)
    }

    pub(crate) fn chance(&mut self, percent: u64) -> bool {
        self.next() % 100 < percent
    }

    pub(crate) fn choose<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.below(from.len())]
    }
}

/// Whether tests run whole, which takes hours, and not in their short versions: set `SKYSHED_LONG=1`.
pub(crate) fn is_long() -> bool {
    std::env::var_os("SKYSHED_LONG").is_some_and(|v| v != "0")
}

/// A point over cell centers, corners, edges and anywhere, in a raster and around it: by half its size, and at least by
/// `beyond` cells.
pub(crate) fn random_place(random: &mut Random, (n_rows, n_cols): (usize, usize), z: i64, beyond: i64) -> LatticePoint {
    let mut along = |n: usize| {
        let span = i64::try_from(n).unwrap();
        let beyond = beyond.max(span / 2);
        random.within(-beyond, span + beyond) * 1024 + random.choose(&[0, 512, 512, 1, 1023, 256, 700])
    };
    LatticePoint { x: along(n_cols), y: along(n_rows), z }
}

/// The cells of a grid that `is_in` names, asked row by row from the north-west.
pub(crate) fn cells_where((n_rows, n_cols): (usize, usize), mut is_in: impl FnMut(usize, usize) -> bool) -> BitGrid {
    let mut cells = BitGrid::new(n_rows, n_cols);
    for (row, col) in (0..n_rows).flat_map(|row| (0..n_cols).map(move |col| (row, col))) {
        cells.set(row, col, is_in(row, col));
    }
    cells
}

/// The environments that generated cities are like.
pub(crate) const ENVIRONMENTS: [&str; 4] = ["suburban", "urban", "dense-urban", "high-rise"];

/// A generated city of footprints without a margin, on ground of 0 m.
pub(crate) fn city(name: &str, size_m: f64, cell_m: f64, seed: u64) -> HeightField {
    let built_up = BuiltUp::named(name).unwrap();
    let scene = BuiltUpCity { built_up, size_m, margin_m: 0.0, cell_m, seed, ground_m: 0.0 }.city().unwrap();
    HeightField::build(&scene.grid, scene.solids).field
}

/// The scene of a surface; what stands 0.25 m above the ground is a building.
pub(crate) fn raster_field(surface: Raster<i32>, ground: Ground) -> HeightField {
    let grid = surface.georef().clone();
    HeightField::build(&grid, Solids::Raster { surface, ground, building_threshold: 256, voids: None }).field
}

/// The scene of heights on a grid.
pub(crate) fn surface_field(grid: &GeoRef, tops: Vec<i32>, ground: Ground) -> HeightField {
    raster_field(Raster::new(grid.clone(), tops), ground)
}

/// The class of a mask's cell as a raster reader hands it out.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "classes are 0 to 255")]
pub(crate) fn class_of(value: f64) -> u8 {
    if value.is_nan() { 255 } else { value as u8 }
}

/// The pixels of a PNG.
pub(crate) fn read_png(file: &[u8]) -> image::DynamicImage {
    let mut decoder = png::Decoder::new(std::io::Cursor::new(file));
    decoder.set_transformations(
        png::Transformations::EXPAND | png::Transformations::STRIP_16 | png::Transformations::ALPHA,
    );
    let mut reader = decoder.read_info().expect("it is a PNG");
    let mut pixels = vec![0; reader.output_buffer_size().expect("it fits in memory")];
    let frame = reader.next_frame(&mut pixels).expect("it is a whole PNG");
    // Gray becomes gray with opacity.
    let rgba = match frame.color_type {
        png::ColorType::Rgba => pixels,
        _ => pixels.chunks_exact(2).flat_map(|p| [p[0], p[0], p[0], p[1]]).collect(),
    };
    image::DynamicImage::ImageRgba8(image::RgbaImage::from_raw(frame.width, frame.height, rgba).expect("all pixels"))
}
