//! Which vector instructions the engines use: on x86-64 AVX2 where the machine has it, else those that every machine of
//! the target has.
//!
//! PERF: in cities of 2048² AVX-512 gave 4 to 10 % over AVX2, and each set of instructions is all engines compiled again.

pub use fearless_simd::Level as SimdLevel;

/// Every level that this machine can run and the engines tell apart, the best one last. All give the same bits.
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

/// Runs an operation with the vector instructions of a level: `dispatch!(level, simd => operation(simd))`.
///
/// The operation is compiled once for each set of instructions.
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
