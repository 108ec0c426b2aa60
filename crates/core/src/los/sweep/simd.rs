//! Vector operations of the steps, at any vector width: look-ups in small tables, and columns
//! turned into rows.
//!
//! Every lane does the same few IEEE operations in the same order at every width. Nothing is fused
//! and nothing is summed across lanes, so all instruction sets give the same bits.

#[cfg(target_arch = "x86_64")]
use std::arch::x86_64::{
    __m256, __m256i, _mm256_blendv_ps, _mm256_castsi256_ps, _mm256_cmpgt_epi32, _mm256_permutevar8x32_epi32,
    _mm256_permutevar8x32_ps, _mm256_set1_epi32,
};
use std::ops::Range;

use fearless_simd::i32x4;
use fearless_simd::prelude::*;
#[cfg(target_arch = "x86_64")]
use fearless_simd::{Level, f32x8, i32x8, u32x8};
use prefetch_index::prefetch_index;

/// Returns the numbers of the lanes.
#[inline(always)]
pub(super) fn lane_numbers<S: Simd>(simd: S) -> S::i32s {
    const NUMBERS: [i32; 16] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];
    S::i32s::from_slice(simd, &NUMBERS[..S::i32s::LEN])
}

#[cfg(target_arch = "x86_64")]
fearless_simd::kernel!(
    /// Permutes the lanes of two vectors, those of the first foremost, by `index`; does so for two
    /// such pairs.
    #[inline(always)]
    fn permute_pairs_avx2(avx2: Avx2, a: (__m256, __m256), b: (__m256, __m256), index: __m256i) -> (__m256, __m256) {
        let is_high = _mm256_castsi256_ps(_mm256_cmpgt_epi32(index, _mm256_set1_epi32(7)));
        let of = |(low, high)| {
            _mm256_blendv_ps(_mm256_permutevar8x32_ps(low, index), _mm256_permutevar8x32_ps(high, index), is_high)
        };
        (of(a), of(b))
    }
);

#[cfg(target_arch = "x86_64")]
fearless_simd::kernel!(
    /// Permutes the lanes of a vector by `index`.
    #[inline(always)]
    fn permute_one_avx2(avx2: Avx2, values: __m256i, index: __m256i) -> __m256i {
        _mm256_permutevar8x32_epi32(values, index)
    }
);

/// Returns `values[index]`, of as many values as there are lanes.
#[inline(always)]
pub(super) fn permuted<S: Simd>(simd: S, values: &[i32], index: S::u32s) -> S::i32s {
    // PERF: permutations of whole lanes take a third of the instructions of byte permutations.
    #[cfg(target_arch = "x86_64")]
    if let Level::Avx2(avx2) = simd.level() {
        let index = u32x8::from_slice(avx2, index.as_slice());
        let found: i32x8<_> =
            permute_one_avx2(avx2, i32x8::from_slice(avx2, values).into(), index.into()).simd_into(avx2);
        return S::i32s::from_slice(simd, found.as_slice());
    }
    S::i32s::from_slice(simd, values).swizzle_dyn(bytes_of::<S>(index))
}

/// Returns `table[base + index]` of two tables, for lanes of `index` below twice the width.
#[inline(always)]
pub(super) fn tables<S: Simd>(simd: S, tables: [&[f32]; 2], base: usize, index: S::u32s) -> [S::f32s; 2] {
    let n = S::f32s::LEN;
    let windows = tables.map(|table| &table[base..][..2 * n]);
    #[cfg(target_arch = "x86_64")]
    if let Level::Avx2(avx2) = simd.level() {
        let index = u32x8::from_slice(avx2, index.as_slice());
        let [a, b] = windows.map(|window| {
            let half = |values| f32x8::from_slice(avx2, values).into();
            (half(&window[..8]), half(&window[8..]))
        });
        let found = permute_pairs_avx2(avx2, a, b, index.into());
        return [found.0, found.1].map(|found| {
            let found: f32x8<_> = found.simd_into(avx2);
            S::f32s::from_slice(simd, found.as_slice())
        });
    }
    windows.map(|window| {
        let (low, high) = (S::f32s::from_slice(simd, &window[..n]), S::f32s::from_slice(simd, &window[n..]));
        low.concat_swizzle_dyn(high, bytes_of::<S>(index))
    })
}

/// Returns the indices of the four bytes of each named lane.
#[inline(always)]
fn bytes_of<S: Simd>(index: S::u32s) -> <S::u32s as Bytes>::Bytes {
    (index * 0x0404_0404 + 0x0302_0100).to_bytes()
}

/// Columns that are turned into rows together.
pub(super) const STRIP: usize = 64;

/// Heights in a cache line.
const CACHE_LINE: usize = 16;

/// Copies columns `cols` of rows `rows` into lines, one after another.
pub(super) fn turn<S: Simd>(
    simd: S,
    tops: &[i32],
    n_cols: usize,
    cols: &Range<usize>,
    rows: &Range<usize>,
    lines: &mut Vec<i32>,
) {
    let (width, n_lines) = (rows.len(), cols.len());
    // The buffer grows and never shrinks, so that memory which is overwritten anyway is not
    // cleared.
    if lines.len() < width * n_lines {
        lines.resize(width * n_lines, 0);
    }
    let row = |k: usize| &tops[(rows.start + k) * n_cols..][cols.clone()];
    simd.vectorize(
        #[inline(always)]
        || {
            let (whole_rows, whole_cols) = (width / BLOCK * BLOCK, n_lines / BLOCK * BLOCK);
            for start in (0..whole_rows).step_by(BLOCK) {
                for done in (0..whole_cols).step_by(BLOCK) {
                    for k in (start..start + BLOCK).step_by(SQUARE) {
                        for i in 0..SQUARE {
                            // Prefetching past the last row does no harm.
                            prefetch_index(tops, (rows.start + k + BLOCK + i) * n_cols + cols.start + done);
                        }
                        let sources: [&[i32]; SQUARE] = std::array::from_fn(|i| &row(k + i)[done..][..BLOCK]);
                        for at in (0..BLOCK).step_by(SQUARE) {
                            let square = std::array::from_fn(|i| i32x4::from_slice(simd, &sources[i][at..at + SQUARE]));
                            for (i, column) in transposed(square).into_iter().enumerate() {
                                let place = (done + at + i) * width + k;
                                column.store_slice(&mut lines[place..place + SQUARE]);
                            }
                        }
                    }
                }
            }
            for k in 0..width {
                let from = if k < whole_rows { whole_cols } else { 0 };
                for (i, top) in row(k)[from..].iter().enumerate() {
                    lines[(from + i) * width + k] = *top;
                }
            }
        },
    );
}

/// Rows and columns that are turned together: as many as a cache line has heights, so that few
/// lines are read twice. The rows after them are prefetched.
const BLOCK: usize = CACHE_LINE;

/// Rows and columns that are turned at once, in registers.
const SQUARE: usize = 4;

/// Transposes a square of rows into its columns.
#[inline(always)]
fn transposed<S: Simd>([a, b, c, d]: [i32x4<S>; 4]) -> [i32x4<S>; 4] {
    let (ac, bd) = (a.zip_low(c), b.zip_low(d));
    let (ac_high, bd_high) = (a.zip_high(c), b.zip_high(d));
    [ac.zip_low(bd), ac.zip_high(bd), ac_high.zip_low(bd_high), ac_high.zip_high(bd_high)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dispatch;
    use crate::simd::simd_levels;

    #[test]
    fn columns_become_lines_whatever_their_shape() {
        let (n_rows, n_cols) = (53, 90);
        let tops: Vec<i32> = (0..n_rows * n_cols).map(|cell| i32::try_from(cell).expect("few")).collect();
        for level in simd_levels() {
            for (cols, rows) in
                [(0..64, 0..53), (64..90, 3..50), (10..26, 5..21), (89..90, 0..17), (5..5, 0..9), (7..40, 8..8)]
            {
                let mut lines = Vec::new();
                dispatch!(level, simd => turn(simd, &tops, n_cols, &cols, &rows, &mut lines));
                let wanted: Vec<i32> = cols
                    .clone()
                    .flat_map(|col| rows.clone().map(move |row| row * n_cols + col))
                    .map(|cell| tops[cell])
                    .collect();
                assert_eq!(lines, wanted, "{cols:?} {rows:?} {level:?}");
            }
        }
    }
}
