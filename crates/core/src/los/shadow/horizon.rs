//! The horizon of a UAV: the prisms and receivers behind nearer and higher prisms, as seen from it.
//!
//! **Method.** The line from the UAV to a point at distance d and height z drops by (h_U − z)/d per
//! unit of distance. A receiver behind a prism is hidden if the line to it drops by more than the
//! line to the far edge of the roof. So a prism hides no other receiver if its far edge drops by
//! more than that of a prism before it. In a city seen from above these are all but the higher
//! roofs of the distance. They are 71 % of 134 000 blocks over 16 km, seen from 100 m. The shadow of
//! any other prism adds only receivers farther away than the horizon before it reaches.
//!
//! Azimuths are cut into bins. While prisms come by, nearest first, each bin keeps two bounds on
//! the least drop so far:
//!
//! * *sure*, by the prisms that fill the bin, from their farthest point on and as if their roofs
//!   ended at the nearest;
//! * *possible*, by the prisms that touch the bin, from their nearest point on and as if their
//!   roofs ended at the farthest.
//!
//! A point that drops by more than the sure bounds of all its bins is hidden. Receivers that drop
//! by less than the possible bounds of all their bins are in line of sight.
//!
//! **Exactness.** Bounds are widened by far more than they can err ([`SLACK`], [`SEAM`]), so all
//! comparisons are strict. A convex prism that fills a bin is crossed by each of its rays, the two
//! on its sides included, and not along an edge. So everything it is assumed to hide is inside of
//! its open shadow. If a prism, or the near part of its shadow, is left out, no receiver leaves all
//! shadows or their boundaries. Nor do several omissions together matter, since the prism that
//! hides another is nearer than it. For receivers among the remaining prisms `ray` gives the same
//! answer.
//!
//! On a curved earth lines to points at distance d drop by (h_U − z)/d + c d ([`super::curve`]).
//! Their bounds take both terms where they are least, or largest.
//!
//! All this holds for receivers below the UAV. A receiver that is not below it sees past all prisms
//! below the UAV. Prisms that are not below the UAV hide each other from it in other ways, and none
//! of them is left out.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::ops::Range;

use super::geometry::{FULL_TURN, as_f64, bearing, cross, distance_squared};
use crate::quantity::LatticePoint;

/// Relative slack of drops; [`f32`] drops err by less than a tenth of it.
const SLACK: f64 = 1.0 / (1 << 20) as f64;

/// Slack of positions among bins, of which there are at most 2^20; doubles err by less than a
/// thousandth of it.
const SEAM: f64 = 1.0 / (1 << 16) as f64;

/// Bins per square root of the number of prisms: some five for each block along the rim of a city.
const BINS_PER_SIDE: f64 = 16.0;

/// Sight of a group of receivers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sight {
    /// All receivers are in line of sight.
    All,
    /// Some receivers may be in line of sight.
    Some,
    /// No receiver is in line of sight.
    None,
}

/// The results of the horizon.
#[derive(Debug)]
pub(super) struct Sorted {
    /// For each prism, the begin of its shadow as a factor of the distance of its near edges, 1 or
    /// more. Nearer prisms hide nearer receivers anyway. `None` if it hides no other receiver.
    pub(super) prisms: Vec<Option<f64>>,
    /// For each group, the sight of its receivers.
    pub(super) groups: Vec<Sight>,
}

/// Sorts prisms, and groups of receivers at one height each, by the horizon of a UAV.
///
/// Shadows are cast on receivers at or below `highest` \[1/1024 m above the datum\]. A prism that
/// is left out sets no least height of a receiver either: a prism that hides all its receivers
/// needs a higher one.
///
/// Each item is a convex counterclockwise ring. With it come the lowest and the highest point of
/// the roof over it, or the height of the receivers within \[1/1024 m above the datum\].
pub(super) fn sort_by_horizon<R: AsRef<[[i32; 2]]>, G: AsRef<[[i32; 2]]>>(
    (uav, curve): (LatticePoint, f64),
    highest: i64,
    prisms: impl ExactSizeIterator<Item = (R, (i32, i32))>,
    groups: impl Iterator<Item = (G, i64)>,
) -> Sorted {
    let mut horizon = Horizon::new(prisms.len());
    let n_bins = horizon.n_bins();
    let n_prisms = prisms.len();
    let mut sorted = Sorted { prisms: vec![None; n_prisms], groups: Vec::new() };
    // Lines to receivers below the UAV drop by more than the least positive number.
    let least_drop = if highest < uav.z { f32::MIN_POSITIVE } else { 0.0 };
    let of_prism = |(ring, (low, high)): (R, (i32, i32))| {
        Seen::from((uav, curve), (ring.as_ref(), (low.into(), high.into())), (least_drop, 0.0), n_bins)
    };
    let of_group =
        |(ring, z): (G, i64)| Seen::from((uav, curve), (ring.as_ref(), (z, z)), (0.0, f32::INFINITY), n_bins);
    let mut seen: Vec<Seen> = prisms.map(of_prism).collect();
    seen.extend(groups.map(of_group));
    sorted.groups.resize(seen.len() - n_prisms, Sight::Some);
    let mut outward: Vec<u64> =
        seen.iter().zip(0_u64..).map(|(seen, k)| u64::from(seen.distances.0) << 32 | k).collect();
    outward.sort_unstable();

    let below = as_f64(uav.z - highest.min(uav.z)) * (1.0 - SLACK);
    // Items that have begun and not yet ended, by their end.
    let mut open: BinaryHeap<Reverse<(u32, usize)>> = BinaryHeap::new();
    let end = |k: usize, horizon: &mut Horizon, groups: &mut [Sight]| match k.checked_sub(n_prisms) {
        None => horizon.rise_to(&seen[k]),
        Some(group) if groups[group] == Sight::Some && horizon.is_below(&seen[k]) => groups[group] = Sight::All,
        Some(_) => {}
    };
    for key in outward {
        let k = usize::try_from(key & u64::from(u32::MAX)).unwrap_or(usize::MAX);
        let present = &seen[k];
        while let Some(&Reverse((far, ended))) = open.peek()
            && far <= present.distances.0
        {
            open.pop();
            end(ended, &mut horizon, &mut sorted.groups);
        }
        open.push(Reverse((present.distances.1, k)));
        let before = horizon.before(present);
        match k.checked_sub(n_prisms) {
            None => {
                let begin = |drop: f32| (below / (f64::from(drop) * f64::from(present.distances.1))).max(1.0);
                sorted.prisms[k] = before.map(begin);
                horizon.rise_perhaps_to(present);
            }
            Some(group) if before.is_none() => sorted.groups[group] = Sight::None,
            Some(_) => {}
        }
    }
    for Reverse((_, ended)) in open {
        end(ended, &mut horizon, &mut sorted.groups);
    }
    sorted
}

/// A prism or a group as seen from the UAV.
#[derive(Debug, Clone, Copy)]
struct Seen {
    /// The bins that it touches, from the first to after the last. The number of bins is added
    /// beyond the seam.
    touched: (u32, u32),
    /// The bins that it fills.
    filled: (u32, u32),
    /// Integer distances between which it lies \[lattice steps\].
    distances: (u32, u32),
    /// The least drop, at its farthest point, and the largest, at its nearest. A prism that is not
    /// below the UAV hides everything behind it that is below the UAV, so its largest drop is 0.
    /// Its least drop decides whether a drop of 0 hides it.
    drops: (f32, f32),
}

/// Bounds on the least drop of all prisms within a distance, by azimuth bin; the number of bins is
/// a power of two.
struct Horizon {
    sure: Vec<f32>,
    possible: Vec<f32>,
}

impl Horizon {
    fn new(n_prisms: usize) -> Self {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most 2^20")]
        let n = (BINS_PER_SIDE * as_f64(n_prisms).sqrt()).clamp(64.0, f64::from(1 << 20)) as usize;
        let sure = vec![f32::INFINITY; n.next_power_of_two()];
        Horizon { possible: sure.clone(), sure }
    }

    fn n_bins(&self) -> u32 {
        u32::try_from(self.sure.len()).unwrap_or(u32::MAX)
    }

    /// Returns the drop beyond which nearer prisms hide everything behind `seen`; infinite if there
    /// are none. Returns `None` if they hide `seen` as well.
    fn before(&self, seen: &Seen) -> Option<f32> {
        let (first, beyond) = self.ranges(seen.touched);
        let most = |of: &[f32]| of.iter().fold(0.0, |most, sure| if *sure > most { *sure } else { most });
        let sure = most(&self.sure[first]).max(most(&self.sure[beyond]));
        (sure >= seen.drops.0).then_some(sure)
    }

    /// Returns `true` if nothing hides any receiver of a group.
    fn is_below(&self, seen: &Seen) -> bool {
        let is_above = |possible: &[f32]| possible.iter().all(|possible| *possible > seen.drops.1);
        let (first, beyond) = self.ranges(seen.touched);
        is_above(&self.possible[first]) && is_above(&self.possible[beyond])
    }

    fn rise_to(&mut self, seen: &Seen) {
        let (first, beyond) = self.ranges(seen.filled);
        lower(&mut self.sure[first], seen.drops.1);
        lower(&mut self.sure[beyond], seen.drops.1);
    }

    fn rise_perhaps_to(&mut self, seen: &Seen) {
        let (first, beyond) = self.ranges(seen.touched);
        lower(&mut self.possible[first], seen.drops.0);
        lower(&mut self.possible[beyond], seen.drops.0);
    }

    /// Returns the bins up to the seam, and the bins beyond it.
    fn ranges(&self, (first, end): (u32, u32)) -> (Range<usize>, Range<usize>) {
        let n = self.sure.len();
        let (first, end) = (first as usize, end as usize);
        (first.min(n)..end.min(n), first.max(n) - n..end.max(n) - n)
    }
}

fn lower(bins: &mut [f32], to: f32) {
    bins.iter_mut().for_each(|bin| *bin = if to < *bin { to } else { *bin });
}

impl Seen {
    /// Makes the view of a ring; `if_not_below` are the drops of an item that is not below the UAV.
    fn from(
        (uav, curve): (LatticePoint, f64),
        (ring, (low, high)): (&[[i32; 2]], (i64, i64)),
        if_not_below: (f32, f32),
        n_bins: u32,
    ) -> Seen {
        let mut bounds = [i32::MAX, i32::MAX, i32::MIN, i32::MIN];
        // A ring that does not surround the UAV is seen within half a turn.
        let from_uav = |v: [i32; 2]| [i64::from(v[0]) - uav.x, i64::from(v[1]) - uav.y];
        let mut sides = ring.first().map_or(([1, 0], [1, 0]), |v| (from_uav(*v), from_uav(*v)));
        let mut far_squared = 0;
        for vertex in ring {
            let [west, south, east, north] = bounds;
            let [x, y] = *vertex;
            bounds = [west.min(x), south.min(y), east.max(x), north.max(y)];
            let v = from_uav(*vertex);
            far_squared = far_squared.max(v[0] * v[0] + v[1] * v[1]);
            sides.0 = if cross(sides.0, v) < 0 { v } else { sides.0 };
            sides.1 = if cross(sides.1, v) > 0 { v } else { sides.1 };
        }
        let near_squared = distance_squared(bounds, (uav.x, uav.y));
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "roots of at most 2^56, bins")]
        let whole = |v: f64| v as u32;
        // EXACT: roots err by far less than the step by which they are widened.
        let near = whole(as_f64(near_squared).sqrt()).saturating_sub(1);
        let far = whole(as_f64(far_squared).sqrt()) + 2;
        let (touched, filled) = if near == 0 {
            ((0, n_bins), (0, 0))
        } else {
            let per_turn = f64::from(n_bins);
            let at = |side: [i64; 2]| bearing(side[0], side[1]) * (per_turn / FULL_TURN);
            let (low, high) = (at(sides.0), at(sides.1));
            let high = if high < low { high + per_turn } else { high };
            let turn = if low < SEAM { per_turn } else { 0.0 };
            let touched = (whole(low + turn - SEAM), whole(high + turn + SEAM) + 1);
            let filled = (whole(low + SEAM) + 1, whole(high - SEAM));
            (touched, if filled.0 < filled.1 { filled } else { (0, 0) })
        };
        #[expect(clippy::cast_possible_truncation, reason = "rounded within the slack")]
        let drop = |z: i64, distance: u32, curved: u32, slack: f64| {
            ((as_f64(uav.z - z) / f64::from(distance) + curve * f64::from(curved)) * (1.0 + slack)) as f32
        };
        let least = if high < uav.z { drop(high, far, near, -SLACK) } else { if_not_below.0 };
        let largest = if low < uav.z {
            drop(low, near, far, SLACK)
        } else {
            #[expect(clippy::cast_possible_truncation, reason = "rounded within the slack")]
            let most = ((curve * f64::from(far) - as_f64(low - uav.z) / f64::from(far)) * (1.0 + SLACK)) as f32;
            if_not_below.1.max(most)
        };
        Seen { touched, filled, distances: (near, far), drops: (least, largest) }
    }
}

#[cfg(test)]
mod tests {
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{Rng, SeedableRng};

    use super::*;
    use crate::height_field::Prisms;
    use crate::los::prisms_los;

    const M: i32 = 1024;

    fn rectangle([west, south, east, north]: [i32; 4]) -> [[i32; 2]; 4] {
        [[west, south], [east, south], [east, north], [west, north]].map(|v| v.map(|v| v * M))
    }

    const UAV: LatticePoint = LatticePoint { x: 0, y: 0, z: 100 * M as i64 };

    /// Returns the factors of distance at which shadows begin, on the ground.
    fn begins(prisms: &[([i32; 4], i32)]) -> Vec<Option<f64>> {
        let rings: Vec<_> = prisms.iter().map(|(bounds, _)| rectangle(*bounds)).collect();
        let prisms = rings.iter().zip(prisms).map(|(ring, (_, top))| (ring, (top * M, top * M)));
        sort_by_horizon((UAV, 0.0), 0, prisms, std::iter::empty::<([[i32; 2]; 0], i64)>()).prisms
    }

    #[test]
    fn behind_a_wide_block_low_ones_do_not_matter_and_higher_ones_do_where_its_shadow_ends() {
        // All around: also where azimuths begin and end.
        for turn in [[0, 1, 2, 3], [1, 2, 3, 0], [2, 3, 0, 1], [3, 0, 1, 2]] {
            let turned = |from: i32, to: i32, half: i32| {
                let south = [-half, -to, half, -from];
                let all = [south, [from, -half, to, half], [-half, from, half, to], [-to, -half, -from, half]];
                all[turn[0]]
            };
            let blocks = [
                (turned(100, 110, 60), 50),
                (turned(130, 140, 10), 20),
                (turned(150, 170, 10), 80),
                (turned(150, 170, 90), 30),
                // Higher than the UAV.
                (turned(300, 310, 200), 120),
                (turned(380, 390, 20), 110),
                (turned(380, 390, 20), 40),
            ];
            let begins = begins(&blocks);
            // The wide block hides nearly all within 2 · 100 m.
            assert_eq!((begins[0], begins[1]), (Some(1.0), None), "{turn:?}");
            let begin = begins[2].expect("higher");
            assert!(begin > 190.0 / 172.0 && begin < 1.3, "{begin}");
            assert_eq!(begins[3], Some(1.0), "beside it there is nothing");
            assert!(begins[4].is_some());
            assert_eq!((begins[5], begins[6]), (None, None));
        }
    }

    #[test]
    fn under_and_around_the_uav_nothing_is_left_out() {
        let around = [-50, -50, 50, 50];
        assert_eq!(begins(&[(around, 60), ([60, -5, 70, 5], 10), (around, 10)]), [Some(1.0); 3]);
        assert_eq!(begins(&[]), []);
    }

    /// Returns a random integer below `n`.
    fn below(random: &mut ChaCha8Rng, n: u32) -> i32 {
        i32::try_from(random.next_u32() % n).unwrap_or(0)
    }

    #[test]
    fn in_random_towns_what_is_said_of_groups_holds_and_what_is_left_hides_the_same() {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let (mut n_all, mut n_none, mut n_behind, mut n_seen, mut n_farther) = (0, 0, 0, 0, 0);
        for _ in 0..300 {
            // On a jittered grid: no two overlap, some share walls.
            let pitch = 12 + below(&mut random, 20);
            let mut blocks = Vec::new();
            for k in 0..400 {
                let (west, south) = ((k % 20 - 10) * pitch, (k / 20 - 10) * pitch);
                let mut size = || 1 + below(&mut random, 2) * (pitch - 2) + below(&mut random, 2);
                let (east, north) = (west + size(), south + size());
                blocks.push(([west, south, east, north], 5 + below(&mut random, 60)));
            }
            let height = 20 + below(&mut random, 100);
            let uav = LatticePoint {
                x: i64::from(below(&mut random, 400) - 200) * 512,
                y: i64::from(below(&mut random, 400) - 200) * 512,
                z: i64::from(height * M),
            };
            let rings: Vec<_> = blocks.iter().map(|(bounds, _)| rectangle(*bounds)).collect();
            let tops: Vec<i32> = blocks.iter().map(|(_, top)| top * M).collect();
            let prisms = || rings.iter().zip(&tops).map(|(ring, top)| (ring, (*top, *top)));
            let groups = || rings.iter().zip(&tops).map(|(ring, top)| (ring, i64::from(top + 3 * M / 2)));
            let sorted = sort_by_horizon((uav, 0.0), 0, prisms(), groups());
            let solids = |keep: &dyn Fn(usize) -> bool| {
                let kept = (0..rings.len()).filter(|k| keep(*k)).zip(0..);
                Prisms::new(kept.map(|(k, number)| (rings[k], tops[k], number)))
            };
            let (all, left) = (solids(&|_| true), solids(&|k| sorted.prisms[k].is_some()));
            for ((ring, z), sight) in groups().zip(&sorted.groups) {
                let [[west, south], _, [east, north], _] = *ring;
                let ends = |low: i32, high: i32| [low + 1, low + (high - low) / 2, high - 1].map(i64::from);
                for (x, y) in ends(west, east).into_iter().flat_map(|x| ends(south, north).map(|y| (x, y))) {
                    let is_los = prisms_los(&all, uav, LatticePoint { x, y, z });
                    assert!(*sight != Sight::All || is_los, "{uav:?} {ring:?} {z}");
                    assert!(*sight != Sight::None || !is_los, "{uav:?} {ring:?} {z}");
                }
                n_all += u32::from(*sight == Sight::All);
                n_none += u32::from(*sight == Sight::None);
            }
            n_behind += 400 - left.pieces().len();
            // The ground all over the place, on the lattice of the walls as well.
            let begins = &sorted.prisms;
            for _ in 0..400 {
                let mut at = || i64::from(below(&mut random, 1600) - 800) * 256;
                let ground = LatticePoint { x: at(), y: at(), z: 0 };
                let is_los = prisms_los(&all, uav, ground);
                assert_eq!(is_los, prisms_los(&left, uav, ground), "{uav:?} {ground:?}");
                n_seen += u32::from(is_los);
            }
            // Up to where a shadow begins, others hide what it does.
            let farther = (0..rings.len()).filter_map(|k| Some((k, begins[k]?))).filter(|(_, begin)| *begin > 1.1);
            for (k, begin) in farther.take(3) {
                let others = solids(&|other| other != k);
                let [[west, south], _, [east, north], _] = rings[k];
                for part in 1..10 {
                    let scale = 1.0 + (begin - 1.0) * f64::from(part) / 10.0;
                    #[expect(clippy::cast_possible_truncation, reason = "a place there")]
                    let at = |a: i32, b: i32, uav: i64| uav + (as_f64(i64::from(a.midpoint(b)) - uav) * scale) as i64;
                    let ground = LatticePoint { x: at(west, east, uav.x), y: at(south, north, uav.y), z: 0 };
                    assert!(!prisms_los(&others, uav, ground), "{uav:?} {ground:?} {:?}", rings[k]);
                }
                n_farther += 1;
            }
        }
        let found = (n_all, n_none, n_behind, n_seen, n_farther);
        assert!(n_all > 1000 && n_none > 1000 && n_behind > 1000 && n_seen > 1000 && n_farther > 100, "{found:?}");
    }
}
