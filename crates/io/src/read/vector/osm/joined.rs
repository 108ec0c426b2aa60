//! Rings out of lines that meet at their ends, in any order and direction.
//!
//! A walk goes from line to line until it comes to a point that it has passed. The lines since then
//! are a ring, and the walk goes on from there. At a dead end it steps back by one line, which is
//! part of no ring. Each line is passed at most twice.

use std::collections::HashMap;

/// Rings out of lines.
#[derive(Debug, Default)]
pub(super) struct Joined {
    pub(super) rings: Vec<Ring>,
    /// `true` if any line is part of no ring.
    pub(super) has_loose: bool,
}

/// A ring, whose last point repeats the first.
#[derive(Debug)]
pub(super) struct Ring {
    pub(super) points: Vec<[f64; 2]>,
    /// Lines that it is made of.
    pub(super) lines: Vec<usize>,
}

/// A point, compared bit by bit.
type Point = [u64; 2];

/// Line on the way of a walk.
#[derive(Debug, Clone, Copy)]
struct Step {
    line: usize,
    is_backward: bool,
    from: Point,
}

/// Joins lines, each of at least two points, to rings.
pub(super) fn joined(lines: &[&[[f64; 2]]]) -> Joined {
    let mut found = Joined::default();
    let ends: Vec<Option<[Point; 2]>> =
        lines.iter().map(|line| Some([key(line.first()?), key(line.last()?)])).collect();
    let mut at: HashMap<Point, Vec<usize>> = HashMap::new();
    for (k, of) in ends.iter().enumerate() {
        match of {
            Some([first, last]) if first == last => {
                found.rings.push(Ring { points: lines[k].to_vec(), lines: vec![k] });
            }
            Some(of) => of.iter().for_each(|end| at.entry(*end).or_default().push(k)),
            None => {}
        }
    }
    let mut is_used = vec![false; lines.len()];
    for start in ends.iter().flatten().filter(|[first, last]| first != last).map(|[first, _]| *first) {
        let mut path: Vec<Step> = Vec::new();
        let mut passed = HashMap::from([(start, 0)]);
        let mut here = start;
        loop {
            let Some(line) = at.get_mut(&here).and_then(|lines| next_unused(lines, &is_used)) else {
                let Some(back) = path.pop() else { break };
                found.has_loose = true;
                passed.remove(&here);
                here = back.from;
                continue;
            };
            is_used[line] = true;
            let Some([first, last]) = ends[line] else { continue };
            let is_backward = first != here;
            path.push(Step { line, is_backward, from: here });
            here = if is_backward { first } else { last };
            if let Some(k) = passed.get(&here).copied() {
                let around = path.split_off(k);
                for step in around.iter().skip(1) {
                    passed.remove(&step.from);
                }
                found.rings.push(ring_of(&around, lines));
            } else {
                passed.insert(here, path.len());
            }
        }
    }
    found
}

/// Takes the next line of a list that no walk has passed.
fn next_unused(lines: &mut Vec<usize>, is_used: &[bool]) -> Option<usize> {
    std::iter::from_fn(|| lines.pop()).find(|line| !is_used[*line])
}

/// Returns the ring along some steps.
fn ring_of(steps: &[Step], lines: &[&[[f64; 2]]]) -> Ring {
    let mut points: Vec<[f64; 2]> = Vec::new();
    for step in steps {
        let line = lines[step.line];
        points.pop();
        match step.is_backward {
            false => points.extend(line),
            true => points.extend(line.iter().rev()),
        }
    }
    Ring { points, lines: steps.iter().map(|step| step.line).collect() }
}

fn key(place: &[f64; 2]) -> Point {
    // Both zeros are one place.
    place.map(|v| (v + 0.0).to_bits())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_in_any_direction_are_one_ring() {
        let [a, b, c] = [
            [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]].as_slice(),
            [[0.0, 0.0], [0.0, 2.0]].as_slice(),
            [[2.0, 0.0], [2.0, 2.0], [0.0, 2.0]].as_slice(),
        ];
        let found = joined(&[a, b, c]);
        let [ring] = found.rings.as_slice() else { panic!("{found:?}") };
        assert!(!found.has_loose && ring.points.len() == 6 && ring.points.first() == ring.points.last(), "{ring:?}");
    }

    #[test]
    fn a_line_that_leads_nowhere_is_left_over() {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]];
        let found = joined(&[&square, &[[1.0, 1.0], [5.0, 5.0]], &[[1.0, 1.0], [0.0, 0.0]], &[[5.0, 5.0], [6.0, 5.0]]]);
        assert!(found.has_loose);
        assert_eq!(found.rings.len(), 1, "{found:?}");
        assert_eq!(found.rings[0].points.len(), 4);
    }

    #[test]
    fn rings_that_touch_are_two() {
        let [left, right] = [[[0.0, 0.0], [-1.0, 1.0], [-1.0, -1.0]], [[0.0, 0.0], [1.0, 1.0], [1.0, -1.0]]];
        let back = |of: &[[f64; 2]]| [of[2], [0.0, 0.0]];
        let found = joined(&[&left, &right, &back(&left), &back(&right)]);
        assert_eq!((found.rings.len(), found.has_loose), (2, false), "{found:?}");
    }
}
