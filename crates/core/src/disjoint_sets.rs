//! Disjoint sets of numbers (union–find).

/// Disjoint sets of the numbers from 0. One member of each set represents it.
///
/// # References
/// Path halving: Tarjan & van Leeuwen 1984.
#[derive(Debug, Clone, Default)]
pub struct DisjointSets {
    /// For each number, another member of its set that is nearer to the representative.
    toward: Vec<u32>,
}

impl DisjointSets {
    /// Makes `n` sets of one number each; `n` is below 2^32.
    pub fn new(n: usize) -> Self {
        DisjointSets { toward: (0..number(n)).collect() }
    }

    /// Adds a set with the next number, and returns that number.
    pub fn add(&mut self) -> usize {
        let next = self.toward.len();
        self.toward.push(number(next));
        next
    }

    /// Returns the representative of a number's set.
    pub fn root(&mut self, of: usize) -> usize {
        let mut at = of;
        while self.toward[at] as usize != at {
            let next = self.toward[self.toward[at] as usize];
            self.toward[at] = next;
            at = next as usize;
        }
        at
    }

    /// Joins the sets of two numbers. Returns the common representative: the lower one of both
    /// sets.
    pub fn join(&mut self, a: usize, b: usize) -> usize {
        let (a, b) = (self.root(a), self.root(b));
        self.toward[a.max(b)] = number(a.min(b));
        a.min(b)
    }

    /// Joins the set of `one` into the set of `other`, whose representative then represents both.
    pub fn join_into(&mut self, one: usize, other: usize) {
        let (one, other) = (self.root(one), self.root(other));
        self.toward[one] = number(other);
    }
}

fn number(k: usize) -> u32 {
    u32::try_from(k).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_were_joined_have_one_root() {
        let mut sets = DisjointSets::new(6);
        assert_eq!((sets.join(4, 2), sets.join(5, 4), sets.join(0, 1)), (2, 2, 0));
        assert_eq!([0, 1, 2, 3, 4, 5].map(|k| sets.root(k)), [0, 0, 2, 3, 2, 2]);
        sets.join_into(1, 5);
        assert_eq!((sets.add(), sets.root(0)), (6, 2));
        assert_eq!(sets.join(6, 3), 3);
    }
}
