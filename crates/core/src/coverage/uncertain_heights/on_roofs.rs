//! A receiver on a roof whose height may be off: it rises and falls with its building, and the UAV
//! does not.
//!
//! Let b be the error of the building below the receiver. A higher receiver is no more hidden by
//! other buildings and by the ground, and no less by its own roof ([`crate::los::PlanCrossings`]).
//!
//! * It is surely in line of sight if it is past the others, as high as they may be, with the
//!   lowest b. It must be past its own roof with the highest b, too.
//! * It may be in line of sight if, with the highest b that its own roof allows, it is past the
//!   others as low as they may be.
//!
//! Walls that its building shares with another are looked at by themselves, because both are in the
//! way only together.

use crate::height_field::{HeightField, Station};
use crate::los::{HeightLimits, PlanCrossings};

/// Answers that are sure of a receiver.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct SureOfReceiver {
    pub(super) is_surely_los: bool,
    pub(super) is_possibly_los: bool,
}

/// The link of a receiver on a roof, with the most that each building may be off.
pub(super) struct RoofLink<'a> {
    link: PlanCrossings<'a>,
    /// The building below the receiver.
    own: u32,
    /// By building \[1/1024 m\].
    most: &'a [i32],
}

impl<'a> RoofLink<'a> {
    pub(super) fn new(field: &'a HeightField, uav: &Station, receiver: &Station, own: u32, most: &'a [i32]) -> Self {
        let highest = most.iter().copied().max().unwrap_or(0);
        let link = PlanCrossings::new(field, uav, receiver, most[own as usize], highest);
        RoofLink { link, own, most }
    }

    pub(super) fn sure(&self) -> SureOfReceiver {
        // A receiver that may be just where the UAV is is in line of sight there, whatever is
        // around.
        let coincides = self.link.coincides_at().is_some_and(|by| by.abs() <= self.own_most());
        if coincides && self.own_most() == 0 {
            return SureOfReceiver { is_surely_los: true, is_possibly_los: true };
        }
        SureOfReceiver { is_surely_los: self.is_surely_los(), is_possibly_los: coincides || self.is_possibly_los() }
    }

    fn is_surely_los(&self) -> bool {
        let most = self.own_most();
        let (Some(low), Some(high)) = (self.link.limits_around(-most), self.link.limits_around(most)) else {
            return false;
        };
        let walls_are_clear = || {
            (0..low.walls.len()).all(|wall| {
                let Some(k) = self.own_side(&low, wall) else { return true };
                let other = low.walls[wall].buildings[1 - k];
                let has_room = |limits: &HeightLimits, side: usize, by: i64| by <= limits.walls[wall].rooms[side];
                let is_low = |limits: &HeightLimits| has_room(limits, 1 - k, self.most_of(other));
                // Where the own side is in the way, the other one is least so with the highest
                // receiver.
                has_room(&high, k, most) || is_low(&low) || {
                    let highest = self.highest(|limits, by| has_room(limits, k, by));
                    let from = highest.map_or(-most, |by| by + 1);
                    self.link.limits_around(from).is_some_and(|limits| is_low(&limits))
                }
            })
        };
        self.is_past_own_roof(&high, most) && self.is_past_others(&low, 1) && walls_are_clear()
    }

    fn is_possibly_los(&self) -> bool {
        let Some(mut by) = self.highest(|limits, by| self.is_past_own_roof(limits, by)) else { return false };
        loop {
            let Some(limits) = self.link.limits_around(by).filter(|limits| self.is_past_others(limits, -1)) else {
                return false;
            };
            let blocking = (0..limits.walls.len()).filter_map(|wall| {
                let k = self.own_side(&limits, wall)?;
                let of = &limits.walls[wall];
                (by > of.rooms[k] && -self.most_of(of.buildings[1 - k]) > of.rooms[1 - k]).then_some((wall, k))
            });
            let lower: Vec<Option<i64>> =
                blocking.map(|(wall, k)| self.highest(|limits, by| by <= limits.walls[wall].rooms[k])).collect();
            let Some(lowest) = lower.into_iter().min() else { return true };
            let Some(lowest) = lowest else { return false };
            by = lowest;
        }
    }

    /// Returns the highest error of the own building, within its bounds, for which something holds
    /// that holds for all lower ones. Where ground blocks the link it is taken to hold.
    fn highest(&self, holds: impl Fn(&HeightLimits, i64) -> bool) -> Option<i64> {
        let most = self.own_most();
        let holds = |by: i64| self.link.limits_around(by).is_none_or(|limits| holds(&limits, by));
        if holds(most) {
            return Some(most);
        }
        if !holds(-most) {
            return None;
        }
        let (mut is, mut is_not) = (-most, most);
        while is_not - is > 1 {
            let middle = i64::midpoint(is, is_not);
            if holds(middle) { is = middle } else { is_not = middle }
        }
        Some(is)
    }

    fn is_past_own_roof(&self, limits: &HeightLimits, by: i64) -> bool {
        limits.crossed.iter().all(|(of, room)| *of != self.own || by <= *room)
    }

    /// Returns whether a link is past all other buildings that are as much higher as they may be,
    /// times `sign`.
    fn is_past_others(&self, limits: &HeightLimits, sign: i64) -> bool {
        let has_room = |of: u32, room: i64| sign * self.most_of(of) <= room;
        limits.crossed.iter().all(|(of, room)| *of == self.own || has_room(*of, *room))
            && (0..limits.walls.len()).all(|wall| {
                let of = &limits.walls[wall];
                self.own_side(limits, wall).is_some() || (0..2).any(|k| has_room(of.buildings[k], of.rooms[k]))
            })
    }

    fn own_side(&self, limits: &HeightLimits, wall: usize) -> Option<usize> {
        limits.walls[wall].buildings.iter().position(|of| *of == self.own)
    }

    fn own_most(&self) -> i64 {
        self.most_of(self.own)
    }

    fn most_of(&self, building: u32) -> i64 {
        self.most[building as usize].into()
    }
}
