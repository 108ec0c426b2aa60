//! Units of work, and numbers of placements.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

use skyshed_core::zones::Zone;

/// One of several nearly equal parts of a list, in its order: `3/16`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    /// Number of the part, from 1.
    pub k: usize,
    /// Number of parts.
    pub of: usize,
}

impl Shard {
    /// Returns the part of a list.
    pub fn part<T>(self, mut all: Vec<T>) -> Vec<T> {
        let range = self.range(all.len());
        all.drain(range).collect()
    }

    /// Returns the places of the part in a list of `n`.
    pub fn range(self, n: usize) -> Range<usize> {
        let until = |k: usize| k * n / self.of;
        until(self.k - 1)..until(self.k)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("found `{text}`, wanted K/N with K from 1 to N");
        let (k, of) = text.split_once('/').ok_or_else(wrong)?;
        let (k, of): (usize, usize) = k.trim().parse().ok().zip(of.trim().parse().ok()).ok_or_else(wrong)?;
        if (1..=of).contains(&k) { Ok(Shard { k, of }) } else { Err(wrong()) }
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.k, self.of)
    }
}

skyshed_core::text!(Shard);

/// A tile of the ground: `3,12`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct TileIndex {
    /// Row from the north, from 0.
    pub row: usize,
    /// Column from the west, from 0.
    pub col: usize,
}

impl FromStr for TileIndex {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("found `{text}`, wanted ROW,COL counted from 0");
        let (row, col) = text.split_once(',').ok_or_else(wrong)?;
        let (row, col) = row.trim().parse().ok().zip(col.trim().parse().ok()).ok_or_else(wrong)?;
        Ok(TileIndex { row, col })
    }
}

impl fmt::Display for TileIndex {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{},{}", self.row, self.col)
    }
}

skyshed_core::text!(TileIndex);

/// A zone, and the number of placements over it: `crossroad:200`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ZoneCount {
    /// Zone.
    pub zone: Zone,
    /// Number of placements, 1 to 100 000.
    pub count: usize,
}

impl FromStr for ZoneCount {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wanted = "wanted ZONE:N, such as crossroad:200";
        let (zone, count) = text.split_once(':').ok_or_else(|| format!("found `{text}`, {wanted}"))?;
        let zone = zone.trim().parse()?;
        match count.trim().parse::<usize>() {
            Ok(count @ 1..=100_000) => Ok(ZoneCount { zone, count }),
            _ => Err(format!("found `{count}` placements, wanted 1 to 100000")),
        }
    }
}

impl fmt::Display for ZoneCount {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.zone, self.count)
    }
}

skyshed_core::text!(ZoneCount);
