//! Which vector instructions the engines use: the best that the machine has, or a lower level to compare with.

pub use fearless_simd::Level as SimdLevel;
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
use fearless_simd::Simd;

/// Every level that this machine can run, the scalar one first, the best one last. All give the same bits.
pub fn simd_levels() -> Vec<SimdLevel> {
    let best = SimdLevel::new();
    let mut levels = vec![SimdLevel::fallback()];
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    {
        levels.extend(best.as_sse2().map(|token| token.level()));
        levels.extend(best.as_sse4_2().map(|token| token.level()));
        levels.extend(best.as_avx2().map(|token| token.level()));
        levels.extend(best.as_avx512().map(|token| token.level()));
    }
    #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
    levels.push(best);
    levels
}
