//! Overviews: smaller pictures of a raster, in which a cell represents a square of cells.

use rayon::prelude::*;

/// Function that makes a number of overviews of a raster, which are 2, 4, 8, … times smaller.
pub(super) type Overviews<T> = fn(&[T], (usize, usize), usize) -> Vec<Vec<T>>;

/// Returns the north-west cell of each square.
pub(super) fn first_of<T: Copy + Send + Sync>(
    cells: &[T],
    (n_rows, n_cols): (usize, usize),
    n_levels: usize,
) -> Vec<Vec<T>> {
    let of_level = |level: usize| {
        let reduction = 2 << level;
        let row_of = |row: usize| cells[row * n_cols..(row + 1) * n_cols].iter().step_by(reduction).copied();
        (0..n_rows).into_par_iter().step_by(reduction).flat_map_iter(row_of).collect()
    };
    (0..n_levels).map(of_level).collect()
}

/// Returns the most frequent class of each square, the smallest one on a tie.
///
/// Each class is counted in squares of two cells, and these counts are added to those of the larger
/// squares.
pub(super) fn most_frequent(cells: &[u8], (n_rows, n_cols): (usize, usize), n_levels: usize) -> Vec<Vec<u8>> {
    let mut levels: Vec<Vec<u8>> =
        (0..n_levels).map(|level| vec![0; n_rows.div_ceil(2 << level) * n_cols.div_ceil(2 << level)]).collect();
    // Rows of the largest squares, and their rows in each overview.
    let mut bands: Vec<Vec<&mut [u8]>> = cells.chunks(n_cols << n_levels).map(|_| Vec::new()).collect();
    for (level, cells) in levels.iter_mut().enumerate() {
        let rows = cells.chunks_mut(n_cols.div_ceil(2 << level) << (n_levels - 1 - level));
        bands.iter_mut().zip(rows).for_each(|(band, rows)| band.push(rows));
    }
    let bands = bands.into_par_iter().zip(cells.par_chunks(n_cols << n_levels));
    bands.for_each(|(levels, cells)| {
        for (level, found) in levels.into_iter().zip(most_frequent_of(cells, n_cols, n_levels)) {
            level.copy_from_slice(&found);
        }
    });
    levels
}

/// Returns the overviews of the rows of one row of the largest squares, or of fewer rows.
fn most_frequent_of(cells: &[u8], n_cols: usize, n_levels: usize) -> Vec<Vec<u8>> {
    let mut occurs = [false; 256];
    cells.iter().for_each(|class| occurs[usize::from(*class)] = true);
    let classes = (0..=u8::MAX).filter(|class| occurs[usize::from(*class)]);
    let mut levels: Vec<Most> = (0..n_levels).map(|_| Most::default()).collect();
    let mut sums = vec![0; n_cols.next_multiple_of(2)];
    for class in classes {
        let mut counts = counts_of(class, cells, n_cols);
        let mut width = n_cols.div_ceil(2);
        for level in &mut levels {
            level.add(class, &counts);
            counts = halved(&counts, width, &mut sums);
            width = width.div_ceil(2);
        }
    }
    levels.into_iter().map(|level| level.classes).collect()
}

/// Most frequent class of each square so far, and its count.
#[derive(Default)]
struct Most {
    classes: Vec<u8>,
    counts: Vec<u16>,
}

impl Most {
    /// Adds a class that is larger than all before.
    fn add(&mut self, class: u8, counts: &[u16]) {
        if self.classes.is_empty() {
            self.classes = vec![class; counts.len()];
            self.counts = counts.to_vec();
            return;
        }
        for ((most, known), count) in self.classes.iter_mut().zip(&mut self.counts).zip(counts) {
            *most = if count > known { class } else { *most };
            *known = (*known).max(*count);
        }
    }
}

/// Counts the cells of a class in each square of 2 × 2.
fn counts_of(class: u8, cells: &[u8], n_cols: usize) -> Vec<u16> {
    let width = n_cols.div_ceil(2);
    let mut counts = vec![0; width * cells.len().div_ceil(2 * n_cols)];
    let mut sums = vec![0_u8; 2 * width];
    for (rows, counts) in cells.chunks(2 * n_cols).zip(counts.chunks_exact_mut(width)) {
        let (upper, lower) = rows.split_at(n_cols);
        for (sum, cell) in sums.iter_mut().zip(upper) {
            *sum = u8::from(*cell == class);
        }
        for (sum, cell) in sums.iter_mut().zip(lower) {
            *sum += u8::from(*cell == class);
        }
        for (count, [west, east]) in counts.iter_mut().zip(sums.as_chunks().0) {
            *count = u16::from(west + east);
        }
    }
    counts
}

/// Returns counts in squares of twice the side: at most 256, in squares of 16 × 16. `sums` is
/// scratch space for a row of them.
fn halved(counts: &[u16], n_cols: usize, sums: &mut [u16]) -> Vec<u16> {
    let width = n_cols.div_ceil(2);
    let mut larger = vec![0; width * counts.len().div_ceil(2 * n_cols)];
    let sums = &mut sums[..2 * width];
    for (rows, larger) in counts.chunks(2 * n_cols).zip(larger.chunks_exact_mut(width)) {
        let (upper, lower) = rows.split_at(n_cols);
        sums.fill(0);
        sums[..n_cols].copy_from_slice(upper);
        for (sum, count) in sums.iter_mut().zip(lower) {
            *sum += count;
        }
        for (count, [west, east]) in larger.iter_mut().zip(sums.as_chunks().0) {
            *count = west + east;
        }
    }
    larger
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Counts all cells of each square.
    fn naive(cells: &[u8], (n_rows, n_cols): (usize, usize), reduction: usize) -> Vec<u8> {
        let mut all = Vec::new();
        for top in (0..n_rows).step_by(reduction) {
            for left in (0..n_cols).step_by(reduction) {
                let mut counts = [0; 256];
                for row in top..(top + reduction).min(n_rows) {
                    for col in left..(left + reduction).min(n_cols) {
                        counts[usize::from(cells[row * n_cols + col])] += 1;
                    }
                }
                let most = counts.iter().max().unwrap();
                all.push(u8::try_from(counts.iter().position(|count| count == most).unwrap()).unwrap());
            }
        }
        all
    }

    #[test]
    fn overviews_are_the_most_frequent_classes_of_squares() {
        let mut random = 7_u64;
        for (n_rows, n_cols) in [(1, 1), (1, 40), (40, 1), (16, 16), (17, 33), (50, 31), (64, 128), (100, 7)] {
            for classes in [&[5_u8][..], &[0, 1], &[0, 1, 2, 3, 255], &[9, 8, 7, 6, 5, 4, 3, 2, 1, 0, 200, 255]] {
                let mut class = 0;
                let cells: Vec<u8> = (0..n_rows * n_cols)
                    .map(|_| {
                        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                        if random >> 62 == 0 {
                            class = usize::try_from(random >> 40).unwrap() % classes.len();
                        }
                        classes[class]
                    })
                    .collect();
                let found = most_frequent(&cells, (n_rows, n_cols), 4);
                for (level, found) in found.iter().enumerate() {
                    assert_eq!(*found, naive(&cells, (n_rows, n_cols), 2 << level), "{n_rows}×{n_cols} {level}");
                }
            }
        }
    }

    #[test]
    fn overviews_of_measures_are_their_north_west_cells() {
        let cells: Vec<u32> = (0..35).collect();
        assert_eq!(first_of(&cells, (5, 7), 2), [vec![0, 2, 4, 6, 14, 16, 18, 20, 28, 30, 32, 34], vec![0, 4, 28, 32]]);
    }
}
