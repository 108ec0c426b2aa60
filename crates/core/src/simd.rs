//! Vector instructions of the engines: AVX2 on x86-64 machines that have it, else the baseline of
//! the target.
//!
//! PERF: AVX-512 gained 4 to 10 % over AVX2 in cities of 2048². Each instruction set compiles all
//! engines once more.

pub use fearless_simd::Level as SimdLevel;

/// Returns every level that this machine can run and the engines distinguish, the best one last.
/// All give the same bits.
pub fn simd_levels() -> Vec<SimdLevel> {
    let best = SimdLevel::new();
    #[cfg(target_arch = "x86_64")]
    {
        use fearless_simd::Simd;
        let levels = [best.as_sse2().map(|token| token.level()), best.as_avx2().map(|token| token.level())];
        levels.into_iter().flatten().collect()
    }
    #[cfg(not(target_arch = "x86_64"))]
    vec![best]
}

/// Runs an operation with the vector instructions of a level:
/// `dispatch!(level, simd => operation(simd))`.
///
/// The operation is compiled once for each instruction set.
#[macro_export]
macro_rules! dispatch {
    ($level:expr, $simd:ident => $operation:expr) => {{
        let level: $crate::simd::SimdLevel = $level;
        #[cfg(target_arch = "x86_64")]
        {
            use ::fearless_simd::Simd as _;
            match level.as_avx2() {
                Some($simd) => $simd.vectorize(
                    #[inline(always)]
                    || $operation,
                ),
                None => {
                    let $simd = level.as_sse2().expect("all x86-64 has it");
                    $simd.vectorize(
                        #[inline(always)]
                        || $operation,
                    )
                }
            }
        }
        #[cfg(not(target_arch = "x86_64"))]
        {
            ::fearless_simd::dispatch!(level, $simd => $operation)
        }
    }};
}
