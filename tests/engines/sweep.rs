//! The bracketed sweep equals `ray`, cell for cell, on every scene, at every width of vectors, with any threads; and
//! so it does strip by strip, whatever the strips.

use skyshed_core::error::Result;
use skyshed_core::height_field::{Columns, HeightsOf, SeenHeights, TileMaxima};
use skyshed_core::los::{
    ColumnsReader, ReceiverHeights, StreamLimits, StreamedHeights, StreamedScene, Swept, columns_least_receiver_height,
    columns_los, streamed_sweep_los, sweep_los,
};
use skyshed_core::quantity::{BLOCKS_ALL, LatticePoint, VOID};
use skyshed_core::raster::{BitGrid, CellWindow};
use skyshed_core::simd::{SimdLevel, simd_levels};

use crate::referee::{Count, check_cells, over_seeds};
use crate::support::{Random, cells_where, is_long, random_place};

fn whole(columns: &Columns) -> CellWindow {
    CellWindow { row: 0, col: 0, n_rows: columns.n_rows(), n_cols: columns.n_cols() }
}

fn is_in(window: CellWindow, row: usize, col: usize) -> bool {
    (window.row..window.row + window.n_rows).contains(&row) && (window.col..window.col + window.n_cols).contains(&col)
}

/// The cells of a window that somebody can stand on.
fn standable(columns: &Columns, window: CellWindow) -> BitGrid {
    let (n_rows, n_cols) = (columns.n_rows(), columns.n_cols());
    let has_top = |row: usize, col: usize| ![VOID, BLOCKS_ALL].contains(&columns.tops()[row * n_cols + col]);
    cells_where((n_rows, n_cols), |row, col| is_in(window, row, col) && has_top(row, col))
}

/// Receivers over each cell of a base.
fn over<'a>((base, n_cols): (&'a [i32], usize), above: i32, tiles: Option<&'a TileMaxima>) -> ReceiverHeights<'a> {
    let lowest = base.iter().copied().filter(|z| *z != VOID).min().unwrap_or(0);
    let highest = *base.iter().max().unwrap();
    ReceiverHeights::Over { base: SeenHeights::over_flat_earth(base, n_cols), above, lowest, highest, tiles }
}

/// Compares one scene at one level with `ray`, in memory and strip by strip.
fn compare(
    columns: &Columns,
    uav: LatticePoint,
    receivers: ReceiverHeights<'_>,
    wanted: &BitGrid,
    window: CellWindow,
    level: SimdLevel,
) -> Count {
    let height = |cell: usize| match receivers {
        ReceiverHeights::Flat(z) => i64::from(z),
        ReceiverHeights::Over { base, above, .. } => i64::from(base.at(cell)) + i64::from(above),
    };
    let found = sweep_los(columns, uav, receivers, wanted, window, None, level);
    let ray = |row: usize, col: usize| {
        let ((x, y), z) = (columns.center(row, col), height(row * columns.n_cols() + col));
        columns_los(columns, uav, LatticePoint { x, y, z })
    };
    let what = || format!("{}×{}, UAV {uav:?}, {level:?}, window {window:?}", columns.n_rows(), columns.n_cols());
    let count = check_cells(&found.los, wanted, ray, what);
    // Strips of every thickness.
    let kind = usize::try_from(uav.x.rem_euclid(5)).expect("below 5");
    let limits = StreamLimits { lines: [1, 3, 7, 64, 256][kind] };
    let streamed = |heights_from| streamed(columns, (uav, receivers), wanted, (window, limits, level), heights_from);
    assert!(streamed(None).los == found.los, "by {limits:?}: {}", what());

    // Least heights from some height on, those of the walk to the last bit.
    let from = [-(1 << 25), -20 * 1024, uav.z - 2000, uav.z][usize::try_from(uav.y.rem_euclid(4)).expect("below 4")];
    let with_heights = sweep_los(columns, uav, receivers, wanted, window, Some(from), level);
    assert!(with_heights.los == found.los, "with heights: {}", what());
    let heights = [with_heights, streamed(Some(from))].map(|swept| swept.least_heights.expect("asked for"));
    for (row, col) in wanted.cells() {
        let ((x, y), cell) = (columns.center(row, col), row * columns.n_cols() + col);
        let receiver = LatticePoint { x, y, z: height(cell) };
        let wanted = columns_least_receiver_height(columns, uav, receiver).height_steps();
        #[expect(clippy::cast_precision_loss, reason = "below 2^53")]
        let from = from as f64;
        for (heights, how) in heights.iter().zip(["in memory", "by strips"]) {
            let is_it = heights[cell].to_bits() == wanted.to_bits() || heights[cell].max(wanted) <= from;
            let found = heights[cell];
            assert!(is_it, "({row}, {col}): {found} for {wanted} from {from}, {how} of {limits:?}: {}", what());
        }
    }
    Count { asked: found.undecided, ..count }
}

/// Columns in memory that are handed out window by window, and what receivers stand on.
struct Windows<'a> {
    columns: &'a Columns,
    base: &'a [i32],
}

impl Windows<'_> {
    fn cut(&self, cells: &[i32], window: CellWindow, out: &mut Vec<i32>) {
        assert!(window.n_rows > 0 && window.n_cols > 0);
        out.clear();
        for row in window.row..window.row + window.n_rows {
            let first = row * self.columns.n_cols() + window.col;
            out.extend_from_slice(&cells[first..first + window.n_cols]);
        }
    }
}

impl ColumnsReader for Windows<'_> {
    fn shape(&self) -> (usize, usize) {
        (self.columns.n_rows(), self.columns.n_cols())
    }

    fn read_tops(&self, window: CellWindow, tops: &mut Vec<i32>) -> Result<()> {
        self.cut(self.columns.tops(), window, tops);
        Ok(())
    }

    fn read_bases(&self, window: CellWindow, bases: &mut Vec<i32>) -> Result<()> {
        self.cut(self.base, window, bases);
        Ok(())
    }
}

/// What the streamed sweep says of the wanted cells in a window.
fn streamed(
    columns: &Columns,
    (uav, receivers): (LatticePoint, ReceiverHeights<'_>),
    wanted: &BitGrid,
    (window, limits, level): (CellWindow, StreamLimits, SimdLevel),
    heights_from: Option<i64>,
) -> Swept {
    let (heights, base) = match receivers {
        ReceiverHeights::Flat(z) => (StreamedHeights::Flat(z), &[][..]),
        ReceiverHeights::Over { base, above, lowest, highest, .. } => {
            let HeightsOf::Cells(cells) = base.heights else { panic!("each cell has its own") };
            let is_top = std::ptr::eq(cells, columns.tops());
            (StreamedHeights::Over { is_top, above, range: (lowest, highest) }, cells)
        }
    };
    let scene = StreamedScene {
        columns: &Windows { columns, base },
        max_top: columns.max_top(),
        uav,
        receivers: heights,
        wanted,
        window,
        heights_from,
        limits,
        level,
    };
    streamed_sweep_los(&scene, &|_| true).expect("memory can be read")
}

/// A small raster with heights around the UAV's, few distinct values so that ties are frequent.
fn small_raster(random: &mut Random, n_rows: usize, n_cols: usize) -> (Columns, i64) {
    let spread = random.choose(&[1, 3, 20, 3000, 1 << 20]);
    let uav_z = random.choose(&[0, 512, 1024, 40 * 1024, -7 * 1024]);
    let block = random.choose(&[1, 1, 2, 3, 5]);
    let open = u64::try_from(random.within(0, 95)).unwrap();
    let seed = random.next();
    let tops = (0..n_rows * n_cols)
        .map(|cell| {
            let at = u64::try_from((cell / n_cols / block) << 20 | (cell % n_cols / block)).unwrap();
            let mut own = Random(seed ^ at.wrapping_mul(0x2545_F491_4F6C_DD1D));
            if own.chance(open) {
                return -20 * 1024;
            }
            match own.within(0, 99) {
                0..=1 => VOID,
                2 => BLOCKS_ALL,
                _ => i32::try_from(uav_z + own.within(-spread, spread)).unwrap(),
            }
        })
        .collect::<Vec<_>>();
    (Columns::new(n_rows, n_cols, tops), uav_z)
}

#[test]
fn small_random_rasters_with_heights_around_the_uav_agree_with_ray() {
    let n = if is_long() { 200_000 } else { 3_000 };
    let levels = simd_levels();
    let count = over_seeds(n, 0, |_, random, count| {
        let shape = (random.index(1, 48), random.index(1, 48));
        let (columns, uav_z) = small_raster(random, shape.0, shape.1);
        let uav = random_place(random, shape, uav_z, 40);
        let share = if random.chance(20) { 70 } else { 100 };
        let mut wanted = cells_where(shape, |_, _| random.chance(share));
        let window = window_towards(random, uav, shape);
        let level = random.choose(&levels);
        let base: Vec<i32>;
        let receivers = match random.within(0, 3) {
            0 => ReceiverHeights::Flat(i32::try_from(uav_z + random.within(-30_000, 3000)).unwrap()),
            1 => ReceiverHeights::Flat(-18 * 1024),
            2 => over((columns.tops(), columns.n_cols()), random.choose(&[0, 1, 1536]), None),
            _ => {
                base = columns.tops().iter().map(|t| if *t == VOID { VOID } else { *t / 2 - 5000 }).collect();
                over((&base, columns.n_cols()), 1536, None)
            }
        };
        wanted = match receivers {
            ReceiverHeights::Flat(_) => wanted.and(&cells_where(shape, |row, col| is_in(window, row, col))),
            ReceiverHeights::Over { .. } => wanted.and(&standable(&columns, window)),
        };
        *count = compare(&columns, uav, receivers, &wanted, window, level);
    });
    assert!(count.links > n * 100, "{count:?}");
    assert!(count.asked * 4 < count.links, "{count:?} left to ray: the sweep decides nothing");
}

/// All cells, or one time in five a window of them, which must hold what lies between its cells and the UAV.
fn window_towards(random: &mut Random, uav: LatticePoint, (n_rows, n_cols): (usize, usize)) -> CellWindow {
    if !random.chance(20) {
        return CellWindow { row: 0, col: 0, n_rows, n_cols };
    }
    let clip = |v: i64, n: usize| usize::try_from(v.div_euclid(1024).max(0)).unwrap().min(n - 1);
    let (col, row) = (clip(uav.x, n_cols), n_rows - 1 - clip(uav.y, n_rows));
    let (row0, col0) = (random.index(0, row), random.index(0, col));
    let (row1, col1) = (random.index(row, n_rows - 1), random.index(col, n_cols - 1));
    CellWindow { row: row0, col: col0, n_rows: row1 - row0 + 1, n_cols: col1 - col0 + 1 }
}

/// Low houses and yards with some towers, so that much lies in the dark of something; what receivers stand on may be
/// far above or below the tops.
#[test]
fn towns_in_which_most_bins_sleep_agree_with_ray() {
    let n = if is_long() { 4000 } else { 60 };
    let levels = simd_levels();
    let count = over_seeds(n, 0x70_17, |_, random, count| {
        let (n_rows, n_cols) = (random.index(20, 260), random.index(20, 260));
        let block = random.choose(&[3, 8, 11, 16]);
        let towers = u64::try_from(random.choose(&[0, 1, 4, 20])).unwrap();
        let town = random.next();
        let height = |row: usize, col: usize, kind: u64| {
            let at = u64::try_from((row / block) << 20 | (col / block)).unwrap() ^ kind << 50;
            let mut own = Random(town ^ at.wrapping_mul(0x2545_F491_4F6C_DD1D));
            if kind == 0 && own.within(0, 299) == 0 {
                return own.choose(&[VOID, VOID, BLOCKS_ALL]);
            }
            match own.chance(towers) {
                true => i32::try_from(own.within(0, 90 * 1024)).unwrap(),
                false => own.choose(&[0, 0, 0, 3000, 9000, 9000, 15_000]),
            }
        };
        let cells = |kind: u64| (0..n_rows * n_cols).map(move |i| height(i / n_cols, i % n_cols, kind));
        let columns = Columns::new(n_rows, n_cols, cells(0).collect::<Vec<_>>());
        let place = |random: &mut Random, n: usize| {
            let span = i64::try_from(n).unwrap();
            random.within(-span, 2 * span) * 1024 + random.choose(&[0, 512, 512, 300])
        };
        let z = random.choose(&[2000, 20 * 1024, 60 * 1024, 100 * 1024, 300 * 1024]);
        let uav = LatticePoint { x: place(random, n_cols), y: place(random, n_rows), z };
        let (other, tiles): (Vec<i32>, TileMaxima);
        let receivers = match random.within(0, 2) {
            0 => ReceiverHeights::Flat(random.choose(&[0, 1536, 30 * 1024])),
            1 => over((columns.tops(), columns.n_cols()), 1536, None),
            _ => {
                other = cells(1).collect();
                tiles = TileMaxima::of(&other, n_cols);
                over((&other, columns.n_cols()), 1536, random.choose(&[None, Some(&tiles)]))
            }
        };
        let window = window_towards(random, uav, (n_rows, n_cols));
        let share = random.choose(&[100, 100, 60]);
        let wanted = standable(&columns, window).and(&cells_where((n_rows, n_cols), |_, _| random.chance(share)));
        *count = compare(&columns, uav, receivers, &wanted, window, random.choose(&levels));
    });
    assert!(count.links > n * 10_000 && count.asked * 10 < count.links, "{count:?}");
}

#[test]
fn uavs_at_the_ends_of_the_lattice_agree_with_ray() {
    let levels = simd_levels();
    let mut random = Random(99);
    let mut count = Count::default();
    for (n_rows, n_cols) in [(60, 60), (1, 300), (300, 1), (7, 130)] {
        for _ in 0..if is_long() { 200 } else { 12 } {
            let (columns, _) = small_raster(&mut random, n_rows, n_cols);
            // The box of the UAV and the raster is at most 2^16 cells a side.
            let far = |random: &mut Random, n: usize| {
                let reach = 65_536 - i64::try_from(n).unwrap();
                let cell = random.choose(&[-reach, reach + i64::try_from(n).unwrap(), 5, -40_000, 32_768, 1000]);
                (cell * 1024 + random.choose(&[0, 512, 333])).clamp(-reach * 1024, 65_536 * 1024)
            };
            let (x, y) = (far(&mut random, n_cols), far(&mut random, n_rows));
            let uav = LatticePoint { x, y, z: random.choose(&[1 << 25, 30_000_000, 5 << 20, 60 << 10]) };
            let (window, receivers) = (whole(&columns), over((columns.tops(), columns.n_cols()), 1536, None));
            let wanted = standable(&columns, window);
            count += compare(&columns, uav, receivers, &wanted, window, random.choose(&levels));
        }
    }
    assert!(count.links > 20_000 && count.asked < count.links, "{count:?}");
}

#[test]
fn ranges_at_the_end_of_rasters_far_longer_than_any_map_agree_with_ray() {
    let levels = simd_levels();
    let mut random = Random(7);
    let mut count = Count::default();
    let far = if is_long() { 300_000 } else { 100_000 };
    for (n_rows, n_cols) in [(70, far), (far, 70), (40, 70_000)] {
        let all = [0, 900, 30];
        for n_before in all.into_iter().take(if is_long() { 3 } else { 2 }) {
            let (columns, z) = small_raster(&mut random, n_rows, n_cols);
            // The last thousand rows or columns.
            let from = |n: usize| n - n.min(1000);
            let window =
                CellWindow { row: from(n_rows), col: from(n_cols), n_rows: n_rows.min(1000), n_cols: n_cols.min(1000) };
            let at = |n: usize| i64::try_from(n.saturating_sub(1 + n_before)).unwrap() * 1024 + 512;
            let x = if n_cols > n_rows { at(n_cols) } else { 20 * 1024 };
            // The last rows are to the south, where y is 0.
            let y = if n_rows > n_cols { i64::try_from(n_before).unwrap() * 1024 } else { 30 * 1024 + 5 };
            let (uav, receivers) = (LatticePoint { x, y, z }, over((columns.tops(), columns.n_cols()), 1536, None));
            let wanted = standable(&columns, window);
            count += compare(&columns, uav, receivers, &wanted, window, random.choose(&levels));
        }
    }
    assert!(count.links > 100_000 && count.asked > 100 && count.asked * 2 < count.links, "{count:?}");
}
