//! Rows of 32-bit floats straight onto the lattice of heights, many at a time.

use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch};

use super::voids::{HIGHEST_LIKELY, LOWEST_LIKELY};
use crate::quantity::{STEPS_PER_UNIT, VOID};

/// Rounds heights \[m\] to the lattice as [`crate::quantity::height_steps`] does; `nodata` becomes [`VOID`].
///
/// Returns the number of nodata cells, or `None` if any cell is neither nodata nor a likely height: what to say of such a
/// cell is for who reads them one by one. `out` holds nothing of use then.
///
/// # Panics
/// If the lengths differ.
pub(super) fn lattice_row(heights: &[f32], nodata: Option<f32>, out: &mut [i32]) -> Option<u64> {
    assert_eq!(heights.len(), out.len(), "a height for each cell");
    dispatch!(Level::new(), simd => convert(simd, heights, nodata, out))
}

#[inline(always)]
fn convert<S: Simd>(simd: S, heights: &[f32], nodata: Option<f32>, out: &mut [i32]) -> Option<u64> {
    let n = S::f32s::LEN;
    let mut n_nodata = 0;
    let mut chunks = heights.chunks_exact(n);
    let mut outs = out.chunks_exact_mut(n);
    for (heights, out) in (&mut chunks).zip(&mut outs) {
        n_nodata += convert_lanes(simd, S::f32s::from_slice(simd, heights), nodata, u64::MAX, out)?;
    }
    let rest = chunks.remainder();
    if !rest.is_empty() {
        let lanes = S::f32s::from_fn(simd, |i| rest.get(i).copied().unwrap_or(0.0));
        let mut steps = [0; 64];
        n_nodata += convert_lanes(simd, lanes, nodata, (1 << rest.len()) - 1, &mut steps[..n])?;
        outs.into_remainder().copy_from_slice(&steps[..rest.len()]);
    }
    Some(n_nodata)
}

/// One vector, of which the lanes of `counted` are cells.
#[inline(always)]
fn convert_lanes<S: Simd>(
    simd: S,
    heights: S::f32s,
    nodata: Option<f32>,
    counted: u64,
    out: &mut [i32],
) -> Option<u64> {
    // EXACT: the product with a power of two, the floor, and the fraction above it are all 32-bit floats.
    let steps = heights * STEPS_PER_UNIT as f32;
    let floor = steps.floor();
    let up = (steps - floor).simd_ge(0.5).select(S::f32s::splat(simd, 1.0), S::f32s::splat(simd, 0.0));
    let rounded: S::i32s = (floor + up).to_int();
    #[expect(clippy::cast_possible_truncation, reason = "whole numbers of thousands")]
    let likely = heights.simd_gt(LOWEST_LIKELY as f32) & heights.simd_lt(HIGHEST_LIKELY as f32);
    let void = match nodata {
        None => S::mask32s::splat(simd, false),
        Some(nodata) if nodata.is_nan() => heights.simd_ne(heights),
        Some(nodata) => heights.simd_eq(nodata),
    };
    let all = S::mask32s::splat(simd, true).to_bitmask();
    if (likely | void).to_bitmask() != all {
        return None;
    }
    void.select(S::i32s::splat(simd, VOID), rounded).store_slice(out);
    Some(u64::from((void.to_bitmask() & counted).count_ones()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::height_steps;

    #[test]
    fn heights_are_rounded_as_one_by_one() {
        let mut heights: Vec<f32> =
            vec![0.0, -0.0, 1.0 / 2048.0, -1.0 / 2048.0, 0.49999997 / 1024.0, 8191.9995, -8999.9];
        let mut state = 1_u32;
        for _ in 0..10_007 {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            heights.push((state >> 8) as f32 / 511.9 - 1000.0);
        }
        let mut found = vec![0; heights.len()];
        assert_eq!(lattice_row(&heights, None, &mut found), Some(0));
        for (height, found) in heights.iter().zip(&found) {
            assert_eq!(height_steps(f64::from(*height)), Some(*found), "{height}");
        }
    }

    #[test]
    fn nodata_is_counted_and_what_is_odd_is_left_to_others() {
        let mut heights = vec![5.0_f32; 37];
        let mut out = vec![0; 37];
        for nodata in [-9999.0, f32::NAN, f32::MIN] {
            heights[3] = nodata;
            heights[36] = nodata;
            assert_eq!(lattice_row(&heights, Some(nodata), &mut out), Some(2), "{nodata}");
            assert_eq!((out[3], out[36], out[4]), (VOID, VOID, 5 * 1024));
            assert_eq!(lattice_row(&heights, None, &mut out), None, "{nodata}");
        }
        heights[3] = 5.0;
        heights[36] = 40_000.0;
        assert_eq!(lattice_row(&heights, Some(-9999.0), &mut out), None);
    }
}
