//! Points that fill the unit cube evenly: a randomly shifted lattice sequence.
//!
//! Point i of a shift Δ is `(Δ + φ(i)·z) mod 1`. Here φ(i) is the number with the bits of i mirrored
//! at the binary point, and z a vector of integers. For any m, the first 2^m points, up to
//! [`MOST_POINTS`], are a shifted lattice of rank 1. So points can be added until the error is
//! small enough. The mean of a function over them is unbiased, because each single point is
//! uniform. The means over independent shifts give its standard error. For integrands of bounded
//! variation the error falls almost as 1/n, not as 1/√n.
//!
//! z is the best of 4000 random vectors by the mean square error P₂ of the lattices of 2^8 to 2^15
//! points in the first three dimensions. It is extended by the best of 600 fourth numbers.
//! Alternatives that were tried:
//! * A published vector for up to 2^20 points (Hickernell, Kritzer, Kuo & Nuyens 2012) needs four
//!   times as many points for a standard error of 10^−3 in the suburban city.
//! * Powers of the generalized golden ratio (a Kronecker sequence) stop improving at some thousand
//!   points: 35 times the first step is 6·10^−6 from the second.
//! * Folding the cube helps integrands that are smooth but not periodic. It does not help here,
//!   because they jump.
//!
//! # References
//! Lattice sequences in base 2: Cools, Kuo & Nuyens 2006, SIAM J. Sci. Comput. 28, 2162–2188. P₂:
//! Sloan & Joe 1994, *Lattice Methods for Multiple Integration*.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Dimensions of the points: a position, an azimuth, a distance.
pub const DIMENSIONS: usize = 4;

/// Most points of one shift.
pub const MOST_POINTS: u64 = 1 << 20;

const GENERATOR: [u32; DIMENSIONS] = [1, 188_911, 267_407, 775_643];

/// Shifted sequence of up to 2^20 points in \[0, 1)^4.
#[derive(Debug, Clone)]
pub struct Points {
    shift: [f64; DIMENSIONS],
    next: u64,
}

impl Points {
    /// Makes the sequence with the shift number `shift` of a seed.
    pub fn new(seed: u64, shift: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(shift);
        Points { shift: std::array::from_fn(|_| unit_interval(random.next_u64())), next: 0 }
    }
}

impl Iterator for Points {
    type Item = [f64; DIMENSIONS];

    #[inline]
    fn next(&mut self) -> Option<[f64; DIMENSIONS]> {
        if self.next >= MOST_POINTS {
            return None;
        }
        #[expect(clippy::cast_possible_truncation, reason = "below 2^20")]
        let mirrored = (self.next as u32).reverse_bits() >> 12;
        self.next += 1;
        Some(std::array::from_fn(|k| {
            // Modulo 2^32 is modulo 2^20 in the lower 20 bits.
            let multiple = mirrored.wrapping_mul(GENERATOR[k]) & 0xF_FFFF;
            let v = self.shift[k] + f64::from(multiple) * (1.0 / 1_048_576.0);
            if v < 1.0 { v } else { v - 1.0 }
        }))
    }
}

/// Returns a number in \[0, 1) from 53 of 64 random bits.
#[inline]
pub(super) fn unit_interval(bits: u64) -> f64 {
    (bits >> 11) as f64 * (1.0 / 9_007_199_254_740_992.0)
}
