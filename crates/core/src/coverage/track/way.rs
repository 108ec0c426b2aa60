//! Ways: the straight legs of a track, with distances and times along them.

use super::{TrackHeight, TrackVertex};
use crate::height_field::HeightField;
use crate::quantity::{STEPS_PER_UNIT, VOID, meters};

/// A path through a scene: vertices that are joined by straight legs.
#[derive(Debug, Clone, PartialEq)]
pub struct Way {
    /// Name in its file.
    pub name: Option<String>,
    /// Vertices in order.
    pub vertices: Vec<WayVertex>,
}

/// A vertex of a way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WayVertex {
    /// Position and height.
    pub vertex: TrackVertex,
    /// Time \[s\].
    pub time_s: Option<f64>,
    /// `false` for one that was put between those of the file, to follow the ground.
    pub is_given: bool,
}

/// Part of a way that a leg covers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LegSpan {
    /// Distances in space from the start of the way \[m\].
    pub along_m: [f64; 2],
    /// Times since the start of the way \[s\].
    pub time_s: Option<[f64; 2]>,
}

impl LegSpan {
    /// Returns distance \[m\] and time \[s\] at a fraction of the leg.
    pub fn at(&self, t: f64) -> (f64, Option<f64>) {
        let between = |[from, to]: [f64; 2]| part_way(from, to, t);
        (between(self.along_m), self.time_s.map(between))
    }
}

fn part_way(from: f64, to: f64, t: f64) -> f64 {
    if t >= 1.0 { to } else { from + t * (to - from) }
}

impl Way {
    /// Returns the legs of the way.
    pub fn legs(&self) -> impl Iterator<Item = [&TrackVertex; 2]> {
        self.vertices.windows(2).map(|ends| [&ends[0].vertex, &ends[1].vertex])
    }

    /// Returns the part of the way that each leg covers.
    pub fn spans(&self, meters_per_unit: f64) -> Vec<LegSpan> {
        let mut along = 0.0;
        let start = self.vertices.first().and_then(|first| first.time_s).unwrap_or(0.0);
        let span = |ends: &[WayVertex]| {
            let from = along;
            along += length_m([&ends[0].vertex, &ends[1].vertex], meters_per_unit);
            let times = ends[0].time_s.zip(ends[1].time_s);
            LegSpan { along_m: [from, along], time_s: times.map(|(a, b)| [a - start, b - start]) }
        };
        self.vertices.windows(2).map(span).collect()
    }

    /// Returns the place at a fraction of a leg: x, y \[CRS units\], and the height above the datum
    /// \[m\]; `None` for a walk, which follows the ground.
    pub fn place(&self, leg: usize, t: f64) -> ([f64; 2], Option<f64>) {
        let ends = [0, 1].map(|k| self.vertices[leg + k].vertex);
        let position = [0, 1].map(|k| part_way(ends[0].position[k], ends[1].position[k], t));
        let height_m = |height: TrackHeight| match height {
            TrackHeight::AboveDatum(z) => i32::try_from(z).ok().map(meters),
            TrackHeight::AboveGround(_) => None,
        };
        let heights = height_m(ends[0].height).zip(height_m(ends[1].height));
        (position, heights.map(|(from, to)| part_way(from, to, t)))
    }

    /// Returns the distances at which ways begin if they follow each other, and where the last ends \[m\].
    pub fn starts(ways: &[Way], meters_per_unit: f64) -> Vec<f64> {
        let mut starts = vec![0.0];
        for way in ways {
            let length = way.spans(meters_per_unit).last().map_or(0.0, |span| span.along_m[1]);
            starts.push(starts[starts.len() - 1] + length);
        }
        starts
    }
}

/// Returns the length of a leg in space \[m\].
fn length_m([from, to]: [&TrackVertex; 2], meters_per_unit: f64) -> f64 {
    let across = (to.position[0] - from.position[0]).hypot(to.position[1] - from.position[1]) * meters_per_unit;
    match (from.height, to.height) {
        #[expect(clippy::cast_precision_loss, reason = "heights are at most 2^28 steps")]
        (TrackHeight::AboveDatum(a), TrackHeight::AboveDatum(b)) => {
            across.hypot((b - a) as f64 / f64::from(STEPS_PER_UNIT))
        }
        _ => across,
    }
}

/// Heights at a place of a way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WayHeights {
    /// Distance along all ways, which follow each other \[m\].
    pub along_m: f64,
    /// Time since the start of its way \[s\].
    pub time_s: Option<f64>,
    /// Position \[CRS units\].
    pub position: [f64; 2],
    /// Height of the user above the datum \[m\].
    pub user_m: f64,
    /// Ground above the datum \[m\]; not a number where none is known.
    pub ground_m: f64,
    /// Roof above the datum \[m\]; not a number beside buildings.
    pub roof_m: f64,
}

impl WayHeights {
    /// Samples ways at about `n_places` places in even steps, and at all vertices. A walk is
    /// `walk_m` above the ground; it has no height where no ground is known, and is not sampled there.
    pub fn sample(field: &HeightField, ways: &[Way], (walk_m, n_places): (f64, f64)) -> Vec<WayHeights> {
        let unit = field.grid().meters_per_unit();
        let starts = Way::starts(ways, unit);
        let total = starts.last().copied().unwrap_or(0.0).max(f64::MIN_POSITIVE);
        let known = |z: Option<i32>| z.filter(|z| *z != VOID).map_or(f64::NAN, meters);
        let mut heights = Vec::new();
        for (way, start) in ways.iter().zip(starts) {
            for (leg, span) in way.spans(unit).iter().enumerate() {
                let n = (n_places * (span.along_m[1] - span.along_m[0]) / total).ceil().max(1.0);
                let mut k = 0.0;
                while k <= n {
                    let t = k / n;
                    k += 1.0;
                    let (position, user) = way.place(leg, t);
                    let place = field.place(position[0], position[1]);
                    let ground_m = known(Some(field.ground_at(&place)));
                    let user_m = user.unwrap_or(ground_m + walk_m);
                    if user_m.is_finite() {
                        let (along_m, time_s) = span.at(t);
                        let roof_m = known(field.roof_at(&place));
                        heights.push(WayHeights {
                            along_m: start + along_m,
                            time_s,
                            position,
                            user_m,
                            ground_m,
                            roof_m,
                        });
                    }
                }
            }
        }
        heights
    }
}
