//! Memory and work that the buildings of a file may take, by the size of the file.

use crate::error::{Error, ReadFault, Result};
use crate::input::Input;

/// Memory that any file may take \[bytes\], and for each of its bytes. A building of PBF takes some
/// twenty bytes in the file and 700 in memory.
const MEMORY: (u64, u64) = (64 << 20, 150);
/// Comparisons of corners with edges that any file may take, and for each of its bytes.
const WORK: (u64, u64) = (1 << 30, 1000);

/// Memory and work that are left.
#[derive(Debug)]
pub(super) struct Budget {
    input: Input,
    memory: u64,
    work: u64,
}

impl Budget {
    /// Returns the budget of a file of some length \[bytes\].
    pub(super) fn of(input: &Input, length: u64) -> Budget {
        let of = |(any, each): (u64, u64)| any.saturating_add(each.saturating_mul(length));
        Budget { input: input.clone(), memory: of(MEMORY), work: of(WORK) }
    }

    /// Takes memory for `n` things of some bytes.
    ///
    /// # Errors
    /// E502 for more than is left.
    pub(super) fn take(&mut self, n: usize, bytes: usize) -> Result<()> {
        let rest = self.memory.checked_sub((n as u64).saturating_mul(bytes as u64));
        self.memory = rest.ok_or_else(|| self.exceeded("more than its size stands for"))?;
        Ok(())
    }

    /// Takes the comparisons of some corners with some edges.
    ///
    /// # Errors
    /// E502 for more than are left.
    pub(super) fn compare(&mut self, corners: usize, edges: usize) -> Result<()> {
        let rest = self.work.checked_sub((corners as u64).saturating_mul(edges as u64));
        self.work = rest.ok_or_else(|| self.exceeded("rings with too many corners to be compared"))?;
        Ok(())
    }

    fn exceeded(&self, found: &str) -> Error {
        Error::read(&self.input, ReadFault::TooMany(format!("{found}, wanted buildings of OpenStreetMap")))
    }
}
