//! The approximations against plain restatements of their rules, and their errors against what is known of them: `step`
//! errs towards LoS only, `xdraw` both ways and most in suburban cities, none of them is exact.

#![expect(clippy::cast_possible_truncation, clippy::cast_precision_loss, reason = "small test coordinates")]

use num_bigint::BigInt;
use num_rational::Ratio;
use skyshed_core::city::{BuiltUp, Ground, Site};
use skyshed_core::coverage::{MapOptions, Mapper, Seen, Uav};
use skyshed_core::height_field::{Columns, HeightField};
use skyshed_core::los::{MethodChoice, StepLength, columns_los, r2_los, step_los, xdraw_los};
use skyshed_core::quantity::{Height, LatticePoint, VOID};
use skyshed_core::raster::{BitGrid, CellWindow};

use crate::engines::as_raster;
use crate::support::{ENVIRONMENTS, Random, city, is_long};

/// A small raster with many ties, a UAV on a lattice where borders and corners are met often, and receivers' heights.
fn small(random: &mut Random) -> (Columns, LatticePoint, i64) {
    let (n_rows, n_cols) = (random.index(1, 9), random.index(1, 9));
    let spread = random.choose(&[1, 3, 2000]);
    let tops = (0..n_rows * n_cols).map(|_| match random.below(12) {
        0 => VOID,
        1..=6 => 0,
        _ => i32::try_from(random.within(0, spread) * 512).unwrap(),
    });
    let columns = Columns::new(n_rows, n_cols, tops.collect::<Vec<_>>());
    let along = |random: &mut Random, n: usize| random.within(-2, 2 * i64::try_from(n).unwrap() + 2) * 512;
    let (x, y) = (along(random, n_cols), along(random, n_rows));
    let nudge = |random: &mut Random| random.choose(&[0, 0, 1, -1, 100]);
    let uav = LatticePoint { x: x + nudge(random), y: y + nudge(random), z: random.within(-2, 9) * 700 };
    (columns, uav, random.within(0, 3) * 512)
}

/// All cells, and the window around them.
fn whole(columns: &Columns) -> (BitGrid, CellWindow) {
    let (n_rows, n_cols) = (columns.n_rows(), columns.n_cols());
    (BitGrid::full(n_rows, n_cols), CellWindow { row: 0, col: 0, n_rows, n_cols })
}

type Rational = Ratio<BigInt>;

fn ratio(n: i64, d: i64) -> Rational {
    Rational::new(BigInt::from(n), BigInt::from(d))
}

/// `step` in rational arithmetic, straight from its definition.
fn step_by_definition(columns: &Columns, uav: LatticePoint, rx: LatticePoint, cells: f64) -> bool {
    let (dx, dy) = (uav.x - rx.x, uav.y - rx.y);
    let parts = ((((dx * dx + dy * dy) as f64).sqrt() / 1024.0 / cells).ceil() as i64).max(1);
    (1..parts).all(|k| {
        let at = |from: i64, d: i64| (ratio(from, 1) + ratio(d * k, parts)) / ratio(1024, 1);
        let (x, y) = (at(rx.x, dx), at(rx.y, dy));
        let z = ratio(rx.z, 1) + ratio((uav.z - rx.z) * k, parts);
        let holds = |cell: i64, v: &Rational| ratio(cell, 1) <= *v && *v <= ratio(cell + 1, 1);
        let (own_x, own_y) = (ratio(rx.x, 1024), ratio(rx.y, 1024));
        let (n_cols, n_rows) = (i64::try_from(columns.n_cols()).unwrap(), i64::try_from(columns.n_rows()).unwrap());
        let cells = (-5..n_cols + 5).flat_map(|east| (-5..n_rows + 5).map(move |north| (east, north)));
        let beside = cells.filter(|(east, north)| holds(*east, &x) && holds(*north, &y));
        let lowest = beside.map(|(east, north)| {
            let is_own = holds(east, &own_x) && holds(north, &own_y);
            if is_own { VOID } else { columns.top(east, north) }
        });
        lowest.min().is_none_or(|top| top == VOID || ratio(i64::from(top), 1) <= z)
    })
}

#[test]
fn step_is_its_definition_and_never_calls_a_clear_link_blocked() {
    let mut random = Random(11);
    let (mut n, mut n_missed) = (0, 0);
    for _ in 0..if is_long() { 4000 } else { 400 } {
        let (columns, uav, z) = small(&mut random);
        let cells = random.choose(&[0.25, 0.5, 1.0, 2.0, 4.0]);
        for (row, col) in whole(&columns).0.cells() {
            let (x, y) = columns.center(row, col);
            let rx = LatticePoint { x, y, z };
            let found = step_los(&columns, uav, rx, StepLength::new(cells).unwrap());
            assert_eq!(found, step_by_definition(&columns, uav, rx, cells), "{uav:?} to {rx:?}, step {cells}");
            let exact = columns_los(&columns, uav, rx);
            assert!(found || !exact, "{uav:?} to {rx:?}, step {cells}");
            n_missed += u64::from(found && !exact);
            n += 1;
        }
    }
    assert!(n > 8000 && n_missed > 100, "{n_missed} of {n} missed");
}

/// Line of sight by `xdraw`, cell by cell from the definition: recursive, without lines, windows or quadrants.
struct XdrawByDefinition<'a> {
    columns: &'a Columns,
    /// Position of the UAV east and south of the north-west corner \[cells\], and its height \[steps\].
    uav: (f64, f64, f64),
}

impl XdrawByDefinition<'_> {
    /// The slope that hides what is at a cell, along the axis `by_rows`; −10^30 where nothing does.
    fn hidden_below(&self, (row, col): (i64, i64), by_rows: bool) -> f64 {
        let own = self.own_cell();
        // Across and along the lines.
        let (line, lateral, own_line, own_lateral) =
            if by_rows { (row, col, own.0, own.1) } else { (col, row, own.1, own.0) };
        let (n_lines, n_lateral) = (self.n(by_rows), self.n(!by_rows));
        let last = line - (line - own_line).signum();
        let ring = (last - own_line).abs();
        let (first, end) = ((own_lateral - ring).max(0), (own_lateral + ring + 1).min(n_lateral));
        if last == own_line || !(0..n_lines).contains(&last) || first >= end {
            return -1e30;
        }
        let distance = |line: i64| (center(line) - if by_rows { self.uav.1 } else { self.uav.0 }).abs();
        let offset = center(lateral) - if by_rows { self.uav.0 } else { self.uav.1 };
        let crossing = offset * (distance(last) / distance(line));
        let next = if offset > crossing { lateral - 1 } else { lateral + 1 };
        let weight = (offset - crossing).abs().min(1.0);
        let steepest = |lateral: i64| {
            let lateral = lateral.clamp(first, end - 1);
            let cell = if by_rows { (last, lateral) } else { (lateral, last) };
            let n_rows = self.n(true);
            let top = self.columns.top(cell.1, n_rows - 1 - cell.0);
            let own = if top == VOID { -1e30 } else { (f64::from(top) - self.uav.2) / distance(last) };
            self.hidden_below(cell, by_rows).max(own)
        };
        steepest(lateral) * (1.0 - weight) + steepest(next) * weight
    }

    /// Row and column of the UAV.
    fn own_cell(&self) -> (i64, i64) {
        (self.uav.1.floor() as i64, self.uav.0.floor() as i64)
    }

    fn n(&self, rows: bool) -> i64 {
        i64::try_from(if rows { self.columns.n_rows() } else { self.columns.n_cols() }).unwrap()
    }

    fn los(&self, row: i64, col: i64, z: i64) -> bool {
        let own = self.own_cell();
        if (row, col) == own {
            return true;
        }
        let by_rows = (row - own.0).abs() >= (col - own.1).abs();
        let across = if by_rows { center(row) - self.uav.1 } else { center(col) - self.uav.0 };
        let slope = (z as f64 - self.uav.2) / across.abs();
        slope >= self.hidden_below((row, col), by_rows)
    }
}

fn center(cell: i64) -> f64 {
    cell as f64 + 0.5
}

#[test]
fn xdraw_is_its_definition() {
    let mut random = Random(12);
    let (mut n, mut n_blocked) = (0, 0);
    for _ in 0..if is_long() { 3000 } else { 150 } {
        let (columns, uav, z) = small(&mut random);
        let (all, window) = whole(&columns);
        let found = xdraw_los(&columns, uav, &|_, _| z, &all, window);
        // On the border between two cells the UAV belongs to either.
        if uav.x.rem_euclid(1024) == 0 || uav.y.rem_euclid(1024) == 0 {
            continue;
        }
        let position = (uav.x as f64 / 1024.0, columns.n_rows() as f64 - uav.y as f64 / 1024.0, uav.z as f64);
        let twin = XdrawByDefinition { columns: &columns, uav: position };
        for (row, col) in all.cells() {
            let expected = twin.los(i64::try_from(row).unwrap(), i64::try_from(col).unwrap(), z);
            assert_eq!(found.contains(row, col), expected, "{uav:?}, row {row}, column {col}, {columns:?}");
            n += 1;
            n_blocked += u64::from(!expected);
        }
    }
    assert!(n > 2000 && n_blocked > 200, "{n_blocked} of {n} blocked");
}

#[test]
fn r2_takes_the_answer_of_the_nearest_ray() {
    // A UAV in the middle of a 9 × 9 raster, a wall one cell wide two rows to its north. The rays to the farthest row are one
    // cell apart there and half a cell apart at the wall, so the cells straight behind the wall are hidden, and of those
    // beside it the ones whose nearest ray passes nearest to the wall's center.
    let mut tops = vec![0; 81];
    tops[2 * 9 + 4] = 30 * 1024;
    let columns = Columns::new(9, 9, tops);
    let uav = LatticePoint { x: 4 * 1024 + 512, y: 4 * 1024 + 512, z: 20 * 1024 };
    let (all, window) = whole(&columns);
    let los = r2_los(&columns, uav, &|_, _| 0, &all, window);
    let hidden: Vec<(usize, usize)> =
        (0..81).map(|i| (i / 9, i % 9)).filter(|(row, col)| !los.contains(*row, *col)).collect();
    // In the last row the rays to offsets −1, 0 and 1 pass the wall's row at −1/2, 0 and 1/2: the first rounds into the
    // wall's cell (cells are half-open), the last does not. In the row before, offset −1 is nearest to the ray to −1.33.
    assert_eq!(hidden, [(0, 3), (0, 4), (1, 3), (1, 4)]);
}

fn seen(field: &HeightField, uav: &Uav, method: MethodChoice) -> Seen {
    let options = MapOptions { method, ..MapOptions::default() };
    Mapper::new(field, &options).unwrap().seen_from(uav).unwrap().seen()
}

/// False LoS and false NLoS \[% of receivers\] of a method against `ray`.
fn errors(field: &HeightField, uav: &Uav, method: MethodChoice) -> (f64, f64) {
    let (exact, found) = (seen(field, uav, MethodChoice::Ray), seen(field, uav, method));
    assert_eq!(exact.receivers, found.receivers);
    let both = exact.los.count_in(&found.los);
    let percent = |n: u64| 100.0 * n as f64 / exact.receivers.count() as f64;
    (percent(found.los.count() - both), percent(exact.los.count() - both))
}

#[test]
fn errors_have_the_sign_and_size_that_is_known_of_them() {
    let step = |cells: f64| MethodChoice::Step(StepLength::new(cells).unwrap());
    let mut of_xdraw = Vec::new();
    for name in ENVIRONMENTS {
        let field = as_raster(&city(name, 600.0, 1.0, 3), Ground::Flat(0), 0, &mut Random(1));
        // Over a crossroad near the middle.
        let built_up = BuiltUp::named(name).unwrap();
        let middle = (300.0 / built_up.period()).floor() * built_up.period() + built_up.street_width() / 2.0;
        let site = Site::new("1", (middle, middle), Height::AboveGround(100.0));
        let uav = Uav::place(&site, &field, None).unwrap();
        assert_eq!(errors(&field, &uav, MethodChoice::Sweep), (0.0, 0.0));
        let mut shorter = 0.0;
        for cells in [0.25, 0.5, 1.0, 2.0, 4.0] {
            let (false_los, false_nlos) = errors(&field, &uav, step(cells));
            assert!(false_los > shorter, "{name}, step {cells}: {false_los} after {shorter}");
            assert!(false_nlos == 0.0, "{name}, step {cells}");
            shorter = false_los;
        }
        let (false_los, false_nlos) = errors(&field, &uav, MethodChoice::Xdraw);
        assert!(false_los > 0.0 && false_nlos > 0.0);
        assert!((0.3..=6.0).contains(&(false_los + false_nlos)), "{name}: xdraw {false_los} + {false_nlos}");
        of_xdraw.push(false_los + false_nlos);
        let (false_los, false_nlos) = errors(&field, &uav, MethodChoice::R2);
        assert!(false_los > 0.0 && false_los + false_nlos < 6.0, "{name}: r2 {false_los} + {false_nlos}");
    }
    assert!(of_xdraw.iter().skip(1).all(|e| *e < of_xdraw[0]), "most in suburban: {of_xdraw:?}");
}
