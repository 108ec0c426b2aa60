//! Conversion of rows of 32-bit floats to the lattice of heights, many at a time.

use fearless_simd::prelude::*;
use skyshed_core::dispatch;
use skyshed_core::simd::SimdLevel;

use super::voids::{HIGHEST_LIKELY, LOWEST_LIKELY};
use crate::quantity::{STEPS_PER_UNIT, VOID};

/// Rounds heights \[m\] to the lattice as [`crate::quantity::height_steps`] does; `nodata` becomes
/// [`VOID`].
///
/// `cells` holds the bits of 32-bit floats, and then lattice heights. Returns the number of nodata
/// cells, or `None` if any cell is neither nodata nor a likely height. The caller then reads cells
/// one by one for a warning; `cells` holds nothing of use.
pub(super) fn put_on_lattice(cells: &mut [i32], nodata: Option<f32>) -> Option<u64> {
    dispatch!(SimdLevel::new(), simd => convert(simd, cells, nodata))
}

#[inline(always)]
fn convert<S: Simd>(simd: S, cells: &mut [i32], nodata: Option<f32>) -> Option<u64> {
    let n = S::f32s::LEN;
    let mut n_nodata = 0;
    let mut chunks = cells.chunks_exact_mut(n);
    for chunk in &mut chunks {
        n_nodata += convert_lanes(simd, nodata, u64::MAX, chunk)?;
    }
    let rest = chunks.into_remainder();
    if !rest.is_empty() {
        let mut lanes = [0; 64];
        lanes[..rest.len()].copy_from_slice(rest);
        n_nodata += convert_lanes(simd, nodata, (1 << rest.len()) - 1, &mut lanes[..n])?;
        rest.copy_from_slice(&lanes[..rest.len()]);
    }
    Some(n_nodata)
}

/// Converts one vector, of which the lanes of `counted` are cells.
#[inline(always)]
fn convert_lanes<S: Simd>(simd: S, nodata: Option<f32>, counted: u64, cells: &mut [i32]) -> Option<u64> {
    let heights: S::f32s = S::i32s::from_slice(simd, cells).bitcast();
    // EXACT: the product with a power of two, the floor, and the fraction above it are all 32-bit
    // floats.
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
    void.select(S::i32s::splat(simd, VOID), rounded).store_slice(cells);
    Some(u64::from((void.to_bitmask() & counted).count_ones()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::height_steps;

    fn bits(heights: &[f32]) -> Vec<i32> {
        bytemuck::cast_slice(heights).to_vec()
    }

    #[test]
    fn heights_are_rounded_as_one_by_one() {
        let mut heights: Vec<f32> =
            vec![0.0, -0.0, 1.0 / 2048.0, -1.0 / 2048.0, 0.49999997 / 1024.0, 8191.9995, -8999.9];
        let mut state = 1_u32;
        for _ in 0..10_007 {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            heights.push((state >> 8) as f32 / 511.9 - 1000.0);
        }
        let mut found = bits(&heights);
        assert_eq!(put_on_lattice(&mut found, None), Some(0));
        for (height, found) in heights.iter().zip(&found) {
            assert_eq!(height_steps(f64::from(*height)), Some(*found), "{height}");
        }
    }

    #[test]
    fn nodata_is_counted_and_what_is_odd_is_left_to_others() {
        let mut heights = vec![5.0_f32; 37];
        for nodata in [-9999.0, f32::NAN, f32::MIN] {
            heights[3] = nodata;
            heights[36] = nodata;
            let mut out = bits(&heights);
            assert_eq!(put_on_lattice(&mut out, Some(nodata)), Some(2), "{nodata}");
            assert_eq!((out[3], out[36], out[4]), (VOID, VOID, 5 * 1024));
            assert_eq!(put_on_lattice(&mut bits(&heights), None), None, "{nodata}");
        }
        heights[3] = 5.0;
        heights[36] = 40_000.0;
        assert_eq!(put_on_lattice(&mut bits(&heights), Some(-9999.0)), None);
    }
}
