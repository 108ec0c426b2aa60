//! Values of the cells of large grids, in few and large pages of memory where the system has them.

use std::fmt;
use std::ops::{Deref, DerefMut};

use bytemuck::Pod;
#[cfg(target_os = "linux")]
use bytemuck::{cast_slice, cast_slice_mut};

/// How many bytes are asked for in large pages, which have 2 MiB. Less is held by the allocator as well. Of more, little is
/// gained beside the work that is done on it, and much may be lost: on a virtual machine whose host takes back what is
/// free, the host is asked for each large page piece by piece, while small pages are often those that another program has just left.
#[cfg(target_os = "linux")]
const LARGE_BYTES: std::ops::RangeInclusive<usize> = 4 << 20..=128 << 20;

/// As many values as were there at first: a vector that does not grow.
///
/// PERF: the first touch of each page of new memory costs the kernel as much as line of sight costs us for hundreds of cells.
/// Linux has pages of 2 MiB for those who ask (`transparent_hugepage`, which is `madvise` on most machines), one touch
/// instead of 512, and does without where it has none left. The allocator does not ask, so what is large comes from the system itself.
pub struct LargeVec<T>(Store<T>);

enum Store<T> {
    Heap(Vec<T>),
    #[cfg(target_os = "linux")]
    Pages(memmap2::MmapMut),
}

impl<T: Pod> LargeVec<T> {
    /// `n` zeros.
    pub fn zeroed(n: usize) -> Self {
        LargeVec(Store::zeroed(n))
    }

    /// All values.
    pub fn as_slice(&self) -> &[T] {
        self
    }

    /// The values as a vector, which may grow: without a copy unless they are in pages of their own.
    pub fn into_vec(self) -> Vec<T> {
        match self.0 {
            Store::Heap(values) => values,
            #[cfg(target_os = "linux")]
            Store::Pages(map) => cast_slice(&map[..]).to_vec(),
        }
    }
}

impl<T: Pod> Store<T> {
    #[cfg(target_os = "linux")]
    fn zeroed(n: usize) -> Self {
        let n_bytes = n.saturating_mul(size_of::<T>());
        // Without memory the vector says what is to be said.
        let map = LARGE_BYTES.contains(&n_bytes).then(|| memmap2::MmapMut::map_anon(n_bytes).ok()).flatten();
        map.map_or_else(
            || Store::Heap(vec![T::zeroed(); n]),
            |map| {
                // A system without large pages refuses, and has given small ones.
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
        }
    }
}

impl<T: Pod> DerefMut for LargeVec<T> {
    #[inline]
    fn deref_mut(&mut self) -> &mut [T] {
        match &mut self.0 {
            Store::Heap(values) => values,
            #[cfg(target_os = "linux")]
            Store::Pages(map) => cast_slice_mut(map),
        }
    }
}

impl<T> From<Vec<T>> for LargeVec<T> {
    fn from(values: Vec<T>) -> Self {
        LargeVec(Store::Heap(values))
    }
}

impl<T> FromIterator<T> for LargeVec<T> {
    fn from_iter<I: IntoIterator<Item = T>>(values: I) -> Self {
        LargeVec::from(values.into_iter().collect::<Vec<T>>())
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
        LargeVec::from(self.to_vec())
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
    fn large_and_small_ones_behave_alike() {
        for n in [0, 5, (4 << 20) / 4 - 1, (4 << 20) / 4, (6 << 20) / 4 + 3] {
            let mut values = LargeVec::<i32>::zeroed(n);
            assert_eq!(values.len(), n);
            assert!(values.iter().all(|value| *value == 0));
            values.iter_mut().zip(0..).for_each(|(value, i)| *value = i);
            let copy = values.clone();
            assert!(copy == values, "{n}");
            assert!(values.into_vec().into_iter().eq(0..i32::try_from(n).expect("small")), "{n}");
        }
    }
}
