//! Values of the cells of large grids, in large pages of memory if the system has them, or as runs
//! of equal values.

use std::fmt;
use std::ops::{Deref, DerefMut};
use std::sync::OnceLock;

use bytemuck::Pod;
#[cfg(target_os = "linux")]
use bytemuck::{cast_slice, cast_slice_mut};

use super::RowRuns;

/// Sizes that are allocated in large pages, which have 2 MiB.
///
/// The allocator serves smaller sizes as well. Larger sizes gain little beside the work done on
/// them, and may lose much. On a virtual machine whose host reclaims free memory, each large page
/// is requested from the host piece by piece. Small pages often come from a program that has just
/// freed them.
#[cfg(target_os = "linux")]
const LARGE_BYTES: std::ops::RangeInclusive<usize> = 4 << 20..=128 << 20;

/// A vector of fixed length.
///
/// PERF: the first touch of each page of new memory costs the kernel as much as line of sight of
/// hundreds of cells. Linux has pages of 2 MiB on request (`transparent_hugepage`, which is
/// `madvise` on most machines): one touch instead of 512. It uses small pages when no large ones
/// are free. The allocator does not request them, so large vectors come from the system itself.
///
/// Values known as runs ([`LargeVec::from_runs`]) get memory of their own once all of them are read
/// as a slice.
pub struct LargeVec<T>(Store<T>);

enum Store<T> {
    Heap(Vec<T>),
    #[cfg(target_os = "linux")]
    Pages(memmap2::MmapMut),
    Runs(Box<Runs<T>>),
}

/// Values as runs, and one by one after the first request for all of them.
struct Runs<T> {
    runs: RowRuns<T>,
    values: OnceLock<LargeVec<T>>,
}

impl<T: Pod> LargeVec<T> {
    /// Makes a vector of `n` zeros.
    pub fn zeroed(n: usize) -> Self {
        LargeVec(Store::zeroed(n))
    }

    /// Makes a vector from rows of cells as runs.
    pub fn from_runs(runs: RowRuns<T>) -> Self {
        LargeVec(Store::Runs(Box::new(Runs { runs, values: OnceLock::new() })))
    }

    /// Returns the values as runs, if they are known as such.
    pub fn runs(&self) -> Option<&RowRuns<T>> {
        match &self.0 {
            Store::Runs(runs) => Some(&runs.runs),
            _ => None,
        }
    }

    /// Returns the values as runs, for writing, if they are known as such and not one by one.
    pub fn runs_mut(&mut self) -> Option<&mut RowRuns<T>> {
        match &mut self.0 {
            Store::Runs(runs) if runs.values.get().is_none() => Some(&mut runs.runs),
            _ => None,
        }
    }

    /// Returns all values, if they are in memory one by one.
    pub fn in_memory(&self) -> Option<&[T]> {
        match &self.0 {
            Store::Runs(runs) => runs.values.get().map(LargeVec::as_slice),
            _ => Some(self),
        }
    }

    /// Returns the number of values.
    pub fn len(&self) -> usize {
        self.runs().map_or_else(|| self.as_slice().len(), |runs| runs.n_rows() * runs.n_cols())
    }

    /// Returns `true` if there are no values.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Copies values from index `first` on. If they are known as runs, they lie in one row of
    /// cells.
    #[inline]
    pub fn copy(&self, first: usize, out: &mut [T]) {
        match &self.0 {
            Store::Runs(runs) if runs.values.get().is_none() => {
                let n_cols = runs.runs.n_cols();
                runs.runs.copy_row(first / n_cols, first % n_cols, out);
            }
            _ => out.copy_from_slice(&self[first..first + out.len()]),
        }
    }

    /// Returns one value.
    #[inline]
    pub fn value(&self, i: usize) -> T {
        match &self.0 {
            Store::Runs(runs) if runs.values.get().is_none() => {
                let mut value = [T::zeroed()];
                self.copy(i, &mut value);
                value[0]
            }
            _ => self[i],
        }
    }

    /// Returns all values.
    pub fn as_slice(&self) -> &[T] {
        self
    }

    /// Returns the values as a vector, which may grow. They are copied only if they are in pages of
    /// their own.
    pub fn into_vec(self) -> Vec<T> {
        match self.0 {
            Store::Heap(values) => values,
            #[cfg(target_os = "linux")]
            Store::Pages(map) => cast_slice(&map[..]).to_vec(),
            Store::Runs(runs) => runs.into_values().into_vec(),
        }
    }
}

impl<T: Pod> Runs<T> {
    fn written(&self) -> LargeVec<T> {
        let mut values = LargeVec::zeroed(self.runs.n_rows() * self.runs.n_cols());
        self.runs.write(&mut values);
        values
    }

    fn into_values(mut self) -> LargeVec<T> {
        self.values.take().unwrap_or_else(|| self.written())
    }
}

impl<T: Pod> Store<T> {
    #[cfg(target_os = "linux")]
    fn zeroed(n: usize) -> Self {
        let n_bytes = n.saturating_mul(size_of::<T>());
        // If there is no memory, allocating the vector reports it.
        let map = LARGE_BYTES.contains(&n_bytes).then(|| memmap2::MmapMut::map_anon(n_bytes).ok()).flatten();
        map.map_or_else(
            || Store::Heap(vec![T::zeroed(); n]),
            |map| {
                // A system without large pages refuses, and keeps small ones.
                let _refused = map.advise(memmap2::Advice::HugePage);
                Store::Pages(map)
            },
        )
    }

    #[cfg(not(target_os = "linux"))]
    fn zeroed(n: usize) -> Self {
        Store::Heap(vec![T::zeroed(); n])
    }
}

impl<T: Pod> Deref for LargeVec<T> {
    type Target = [T];

    #[inline]
    fn deref(&self) -> &[T] {
        match &self.0 {
            Store::Heap(values) => values,
            #[cfg(target_os = "linux")]
            Store::Pages(map) => cast_slice(map),
            Store::Runs(runs) => runs.values.get_or_init(|| runs.written()),
        }
    }
}

impl<T: Pod> DerefMut for LargeVec<T> {
    #[inline]
    fn deref_mut(&mut self) -> &mut [T] {
        if matches!(self.0, Store::Runs(_))
            && let Store::Runs(runs) = std::mem::replace(&mut self.0, Store::Heap(Vec::new()))
        {
            // Writing makes the runs stale.
            *self = runs.into_values();
        }
        match &mut self.0 {
            Store::Heap(values) => values,
            #[cfg(target_os = "linux")]
            Store::Pages(map) => cast_slice_mut(map),
            Store::Runs(_) => &mut [],
        }
    }
}

impl<T> From<Vec<T>> for LargeVec<T> {
    fn from(values: Vec<T>) -> Self {
        LargeVec(Store::Heap(values))
    }
}

impl<'a, T: Pod> IntoIterator for &'a LargeVec<T> {
    type Item = &'a T;
    type IntoIter = std::slice::Iter<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl<T: Pod> Clone for LargeVec<T> {
    fn clone(&self) -> Self {
        self.runs().map_or_else(|| LargeVec::from(self.to_vec()), |runs| LargeVec::from_runs(runs.clone()))
    }
}

impl<T> Default for LargeVec<T> {
    fn default() -> Self {
        LargeVec::from(Vec::new())
    }
}

impl<T: Pod + PartialEq> PartialEq for LargeVec<T> {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl<T: Pod + Eq> Eq for LargeVec<T> {}

impl<T: Pod + fmt::Debug> fmt::Debug for LargeVec<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(&**self).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_the_values_they_stand_for() {
        let cells: Vec<i32> = (0..40 * 300).map(|i| i / 300 / 7 * 3 + i % 300 / 50).collect();
        let runs = || LargeVec::from_runs(RowRuns::of(&cells, 300, 0).expect("any number of runs"));
        let values = runs();
        assert_eq!((values.len(), values.value(11_999), values.value(350)), (12_000, cells[11_999], 1));
        let mut part = [0; 77];
        values.copy(900 + 33, &mut part);
        assert_eq!(part, cells[933..1010]);
        assert!(values.runs().is_some() && values.clone().runs().is_some());
        assert_eq!(*values, cells[..]);
        assert_eq!(values.into_vec(), cells);
        let mut changed = runs();
        changed[5] = 99;
        assert!(changed.runs().is_none());
        assert_eq!((changed[5], &changed[6..]), (99, &cells[6..]));
    }
}
