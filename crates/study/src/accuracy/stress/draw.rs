//! Random numbers of stress scenes: a counter-based stream for each scene.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::served::Served;

/// Stream of one scene, a function of the seed and the numbers of family and scene alone.
#[derive(Debug, Clone)]
pub(super) struct Draw(ChaCha8Rng);

impl Draw {
    pub(super) fn new(seed: u64, family: u32, scene: u32) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream((u64::from(family) << 32) | u64::from(scene));
        Draw(random)
    }

    /// Draws a number in `low..=high`. Spans are so small that no remainder is noticeably favored.
    pub(super) fn within(&mut self, low: i64, high: i64) -> i64 {
        let span = high.abs_diff(low) + 1;
        low.saturating_add_unsigned(self.0.next_u64() % span)
    }

    /// Returns `true` with a probability of `percent` %.
    pub(super) fn chance(&mut self, percent: i64) -> bool {
        self.within(0, 99) < percent
    }

    /// Draws the receivers that an antenna serves.
    pub(super) fn served(&mut self) -> Served {
        let from = self.within(0, 7);
        let to = (from + self.within(1, 7)) % 8;
        Served { eighths: [from, to], least: self.choose(&[0, 1, 5]), is_flat: self.chance(50) }
    }

    /// Draws one of some values, of which there is at least one.
    pub(super) fn choose<T: Copy>(&mut self, from: &[T]) -> T {
        let last = i64::try_from(from.len()).unwrap_or(i64::MAX) - 1;
        from[usize::try_from(self.within(0, last)).unwrap_or(0)]
    }
}
