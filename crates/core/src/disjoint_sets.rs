//! Disjoint sets of numbers, which are joined until only what hangs together is left.

/// Disjoint sets of the numbers from 0, each represented by one of its own.
///
/// # References
/// Path halving: Tarjan & van Leeuwen 1984.
#[derive(Debug, Clone, Default)]
pub struct DisjointSets {
    /// For each number another one of its set, nearer to the one that represents it.
    toward: Vec<u32>,
}

impl DisjointSets {
    /// Sets of one number each, for so many below 2^32.
    pub fn new(n: usize) -> Self {
        DisjointSets { toward: (0..number(n)).collect() }
    }

    /// Adds a set of the next number, which is returned.
    pub fn add(&mut self) -> usize {
        let next = self.toward.len();
        self.toward.push(number(next));
        next
    }

    /// The number that represents the set of another.
    pub fn root(&mut self, of: usize) -> usize {
        let mut at = of;
        while self.toward[at] as usize != at {
            let next = self.toward[self.toward[at] as usize];
            self.toward[at] = next;
            at = next as usize;
        }
        at
    }

    /// Joins the sets of two numbers and returns what represents both: the lower of what represented each.
    pub fn join(&mut self, a: usize, b: usize) -> usize {
        let (a, b) = (self.root(a), self.root(b));
        self.toward[a.max(b)] = number(a.min(b));
        a.min(b)
    }

    /// Joins the set of one number with that of another, so that what represented the other represents both.
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
