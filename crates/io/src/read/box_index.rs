//! Search for boxes that meet another one, by their west sides.

/// Index of boxes (west, south, east, north) by their west sides.
#[derive(Debug)]
pub(super) struct BoxIndex<T> {
    /// Boxes with their numbers, from west to east.
    boxes: Vec<([T; 4], usize)>,
    widest: T,
}

impl<T: Copy + PartialOrd + Default + std::ops::Sub<Output = T>> BoxIndex<T> {
    /// Creates an index of numbered boxes.
    pub(super) fn new(boxes: impl Iterator<Item = (usize, [T; 4])>) -> Self {
        let mut boxes: Vec<([T; 4], usize)> = boxes.map(|(number, of)| (of, number)).collect();
        boxes.sort_by(|(a, _), (b, _)| a[0].partial_cmp(&b[0]).unwrap_or(std::cmp::Ordering::Equal));
        let widest = boxes.iter().map(|(of, _)| of[2] - of[0]).fold(T::default(), |a, b| if b > a { b } else { a });
        BoxIndex { boxes, widest }
    }

    /// Returns the numbers of the boxes that meet a box, in no particular order.
    ///
    /// Cost: the boxes that begin within a strip as wide as the box and the widest box of the
    /// index.
    pub(super) fn meeting(&self, [west, south, east, north]: [T; 4]) -> impl Iterator<Item = usize> + '_ {
        let widest = self.widest;
        let from = self.boxes.partition_point(|(of, _)| west - of[0] > widest);
        let strip = self.boxes[from..].iter().take_while(move |(of, _)| of[0] <= east);
        strip.filter(move |(of, _)| of[2] >= west && of[1] <= north && of[3] >= south).map(|(_, number)| *number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_that_meet_are_those_of_a_plain_search() {
        let at = |k: i64| [k * 7 % 50, k * 11 % 50, k * 7 % 50 + k % 9, k * 11 % 50 + k % 5];
        let boxes: Vec<[i64; 4]> = (0..200).map(at).collect();
        let index = BoxIndex::new(boxes.iter().copied().enumerate());
        for asked in (0..60).map(|k| at(3 * k + 1)) {
            let mut found: Vec<usize> = index.meeting(asked).collect();
            found.sort_unstable();
            let meets = |of: &[i64; 4]| (0..2).all(|k| of[k] <= asked[k + 2] && of[k + 2] >= asked[k]);
            let wanted: Vec<usize> = (0..200).filter(|k| meets(&boxes[*k])).collect();
            assert_eq!(found, wanted, "{asked:?}");
        }
    }
}
