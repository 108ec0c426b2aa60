//! Zones of a city as runs, as a page carries them.

use skyshed_core::raster::BitGrid;

/// Zones of a scene whose open cells are known.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PackedZones {
    /// Lengths of runs of cells whose zone is as expected, each with the code of the cell after the
    /// run.
    pub(crate) runs: Vec<(u64, u8)>,
}

impl PackedZones {
    /// Packs the codes of all cells of a scene.
    pub fn of(codes: &[u8], open: &BitGrid) -> Self {
        let mut packed = PackedZones { runs: Vec::new() };
        let mut as_expected = 0;
        for_each_open(&mut codes.to_vec(), open, |code, expected| {
            if *code == expected {
                as_expected += 1;
            } else {
                packed.runs.push((std::mem::take(&mut as_expected), *code));
            }
        });
        packed
    }

    /// Returns the codes of the open cells; other cells have 0.
    pub fn codes(&self, open: &BitGrid) -> Vec<u8> {
        let mut codes = vec![0; open.n_rows() * open.n_cols()];
        let mut runs = self.runs.iter().copied();
        let mut next = runs.next();
        for_each_open(&mut codes, open, |code, expected| {
            *code = match &mut next {
                Some((0, other)) => {
                    let other = *other;
                    next = runs.next();
                    other
                }
                Some((left, _)) => {
                    *left -= 1;
                    expected
                }
                None => expected,
            };
        });
        codes
    }
}

/// Visits open cells row by row, each with its expected zone: the zone of the cell to the north,
/// else of the cell to the west.
fn for_each_open(codes: &mut [u8], open: &BitGrid, mut each: impl FnMut(&mut u8, u8)) {
    let n_cols = open.n_cols();
    for (row, col) in open.cells() {
        let cell = row * n_cols + col;
        let is_open = |row: usize, col: usize| open.contains(row, col);
        let expected = match (row, col) {
            (1.., _) if is_open(row - 1, col) => codes[cell - n_cols],
            (_, 1..) if is_open(row, col - 1) => codes[cell - 1],
            _ => 0,
        };
        each(&mut codes[cell], expected);
    }
}
