//! P_LoS by zone of the placement and zone of the receivers, averaged over sampled placements.
//!
//! A UAV over a crossroad sees along both streets, but has no walls near that it could look over.
//! The best zone depends on the city, the height and the distance of receivers (Saboor et al. 2023
//! ask for it between crossroads and rooftops). So placements are drawn evenly over each zone, each
//! is mapped exactly, and the receivers are counted by zone.
//!
//! **Intervals.** Over one city placements and blocks of ground are resampled, as for P_LoS over a
//! real city ([`resampled`]). Over many cities of one kind the city is the unit ([`clustered`]).

use rayon::prelude::*;

use crate::city::BuiltUp;
use crate::coverage::{Mapper, Seen, Uav, any_in_range};
use crate::error::Result;
use crate::height_field::{GridPositions, HeightField};
use crate::los_probability::estimate::{Count, Estimate, clustered};
use crate::los_probability::points::Points;
use crate::los_probability::real_city::resampled;
use crate::raster::{BitGrid, CellBlocks};
use crate::zones::{Zone, ZoneMap};

/// Most random places tried per wanted place: enough for a zone of a thousandth of the scene.
const TRIES: usize = 10_000;

/// Places that were drawn over a zone.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DrawnPlaces {
    /// The places \[CRS units\].
    pub places: Vec<[f64; 2]>,
    /// Number of places of the zone with a disc cut by the border of the scene or of its data.
    pub n_cut: usize,
}

/// Sample of places to draw.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drawn {
    /// Zone that they are over.
    pub zone: Zone,
    /// Number of wanted places.
    pub n: usize,
    /// West, south, east, north of the part of the scene that holds them \[CRS units\].
    pub within: [f64; 4],
    /// Radius of the disc around each place that must lie in the data \[CRS units\], if any.
    pub radius: Option<f64>,
    /// Seed; equal seeds draw equal places.
    pub seed: u64,
}

impl Drawn {
    /// Draws up to `n` places evenly spread over the zone: points of a shifted lattice in the zone
    /// whose whole disc is in the data. Draws fewer if the zone is too small or most discs are cut.
    pub fn places(&self, field: &HeightField, zones: &ZoneMap) -> DrawnPlaces {
        let mut drawn = DrawnPlaces::default();
        if zones.count(self.zone) == 0 {
            return drawn;
        }
        let [west, south, east, north] = self.within;
        let whole = WholeDiscs::of(field, self.radius);
        let stream = u64::from(self.zone.code());
        for [u, v, ..] in Points::new(self.seed, stream).take(self.n.saturating_mul(TRIES)) {
            let (x, y) = (west + u * (east - west), south + v * (north - south));
            let is_building = field.roof_at(&field.place(x, y)).is_some();
            if zones.over(x, y, is_building) != Some(self.zone) {
                continue;
            }
            if !whole.contains(x, y) {
                drawn.n_cut += 1;
                // If nearly all discs are cut, going on would take long and find a few odd places.
                if drawn.n_cut > MOST_CUT * self.n {
                    break;
                }
                continue;
            }
            drawn.places.push([x, y]);
            if drawn.places.len() == self.n {
                break;
            }
        }
        drawn
    }
}

/// Most places with a cut disc that are tried per wanted place.
pub const MOST_CUT: usize = 1000;

/// Places of a scene whose disc lies in its data, within both the border and the data area.
#[derive(Debug)]
pub struct WholeDiscs<'a> {
    field: &'a HeightField,
    radius: Option<f64>,
    positions: GridPositions,
}

impl<'a> WholeDiscs<'a> {
    /// Makes discs of a radius \[CRS units\]; `None` allows any place of the data.
    pub fn of(field: &'a HeightField, radius: Option<f64>) -> Self {
        WholeDiscs { field, radius, positions: field.positions() }
    }

    /// Returns `true` if the disc around a place lies in the data.
    pub fn contains(&self, x: f64, y: f64) -> bool {
        let grid = self.field.grid();
        let reach = self.radius.unwrap_or(0.0);
        // Discs that touch the border are inside, however rounded.
        let slack = 1e-6 * grid.cell_width();
        let is_inside = x - reach >= grid.x_min() - slack
            && x + reach <= grid.x_max() + slack
            && y - reach >= grid.y_min() - slack
            && y + reach <= grid.y_max() + slack;
        is_inside
            && self.field.is_known_at(x, y)
            && self.field.outside_data().is_none_or(|outside| {
                !any_in_range(&self.positions, &self.field.place(x, y), self.radius.unwrap_or(0.0), outside)
            })
    }
}

/// Returns the middles of all crossroads, streets or buildings of a generated city of
/// `size_m` × `size_m` \[m\] from its origin, row by row from the south-west. Streets along x and
/// along y alternate. Courtyards have none: generated cities have no courtyards.
pub fn middles_of(built_up: &BuiltUp, size_m: f64, zone: Zone) -> Vec<[f64; 2]> {
    let (street, period) = (built_up.street_width(), built_up.period());
    let (on_street, on_building) = (0.5 * street, 0.5 * (street + period));
    let offsets: &[[f64; 2]] = match zone {
        Zone::Crossroad => &[[on_street, on_street]],
        Zone::Street => &[[on_street, on_building], [on_building, on_street]],
        Zone::Rooftop => &[[on_building, on_building]],
        Zone::Courtyard => &[],
    };
    let along = || (0_u32..).map(|k| f64::from(k) * period).take_while(|v| *v < size_m);
    along()
        .flat_map(|y| along().map(move |x| [x, y]))
        .flat_map(|[x, y]| offsets.iter().map(move |o| [x + o[0], y + o[1]]))
        .filter(|[x, y]| *x < size_m && *y < size_m)
        .collect()
}

/// Receivers that are counted together: all, and those of each zone that holds any.
#[derive(Debug, Clone)]
pub struct ReceiverParts {
    parts: Vec<(Option<Zone>, BitGrid)>,
}

impl ReceiverParts {
    /// Makes the parts of the receivers on some cells.
    pub fn new(receivers: &BitGrid, zones: &ZoneMap) -> Self {
        let zone = |zone: Zone| (Some(zone), zones.cells(zone).and(receivers));
        let mut parts = vec![(None, receivers.clone())];
        parts.extend(Zone::ALL.into_iter().map(zone).filter(|(_, cells)| cells.count() > 0));
        ReceiverParts { parts }
    }

    /// Returns the zones in order; `None` is the part of all receivers.
    pub fn zones(&self) -> Vec<Option<Zone>> {
        self.parts.iter().map(|part| part.0).collect()
    }
}

/// Counts what a UAV sees, `[block][part]`.
pub fn count_by_part(seen: &Seen, parts: &ReceiverParts, blocks: &CellBlocks) -> Vec<Count> {
    let n_parts = parts.parts.len();
    let mut counts = vec![Count::default(); blocks.count() * n_parts];
    for row in 0..seen.receivers.n_rows() {
        let (receivers, los) = (seen.receivers.row(row), seen.los.row(row));
        let first_block = blocks.first_of_row(row);
        for (word, (&receivers, &los)) in receivers.iter().zip(los).enumerate().filter(|(_, (r, _))| **r != 0) {
            for (part, (_, cells)) in parts.parts.iter().enumerate() {
                let (mut receivers, los) = (receivers & cells.row(row)[word], los & cells.row(row)[word]);
                // The cells of one block at a time; a word meets few.
                while receivers != 0 {
                    let col = 64 * word + receivers.trailing_zeros() as usize;
                    let block = col / blocks.n_cols();
                    let end = ((block + 1) * blocks.n_cols()).saturating_sub(64 * word);
                    let in_block = if end < 64 { (1_u64 << end) - 1 } else { u64::MAX };
                    let count = &mut counts[(first_block + block) * n_parts + part];
                    count.receivers += u64::from((receivers & in_block).count_ones());
                    count.los += u64::from((los & receivers & in_block).count_ones());
                    receivers &= !in_block;
                }
            }
        }
    }
    counts
}

/// Counts of sampled placements of one zone and height, `[placement][block][part]`, over one city.
#[derive(Debug, Clone)]
pub struct SampledCounts {
    placements: Vec<Vec<Count>>,
    n_parts: usize,
    /// Number of placements that were mapped.
    pub n_placements: usize,
}

impl SampledCounts {
    /// Maps each placement and counts by block and part; shared by all threads, on which the counts do not depend.
    ///
    /// # Errors
    /// As [`Mapper::seen_from`].
    pub fn of(mapper: &Mapper<'_>, uavs: &[Uav], parts: &ReceiverParts, blocks: &CellBlocks) -> Result<Self> {
        let count = |uav: &Uav| Ok(count_by_part(&mapper.seen_from(uav)?.seen(), parts, blocks));
        let placements = uavs.par_iter().map(count).collect::<Result<_>>()?;
        Ok(SampledCounts { placements, n_parts: parts.parts.len(), n_placements: uavs.len() })
    }

    /// Estimates P_LoS by part over one city.
    pub fn estimates(&self, confidence: f64, seed: u64) -> Vec<Estimate> {
        if self.n_placements == 0 {
            return vec![Estimate::none(); self.n_parts];
        }
        // Blocks that are in range of no placement are not in the sample.
        let n_blocks = self.placements.first().map_or(0, |c| c.len() / self.n_parts);
        let has_users = |block: &usize| {
            let parts = block * self.n_parts..(block + 1) * self.n_parts;
            self.placements.iter().any(|counts| counts[parts.clone()].iter().any(|c| c.receivers > 0))
        };
        let blocks: Vec<usize> = (0..n_blocks).filter(has_users).collect();
        resampled(&self.placements, &blocks, self.n_parts, confidence, seed)
    }

    /// Merges all placements and blocks into one, which loses their spread.
    #[must_use]
    pub fn summed(self) -> Self {
        SampledCounts { placements: vec![self.totals()], ..self }
    }

    /// Returns the counts by part, all placements and blocks together.
    pub fn totals(&self) -> Vec<Count> {
        let mut totals = vec![Count::default(); self.n_parts];
        for counts in self.placements.iter().flat_map(|placement| placement.chunks_exact(self.n_parts)) {
            totals.iter_mut().zip(counts).for_each(|(total, count)| *total = *total + *count);
        }
        totals
    }
}

/// Estimates P_LoS by part over many cities, from the totals of each, `[city][part]`.
pub fn over_cities(totals: &[Vec<Count>], n_parts: usize, confidence: f64) -> Vec<Estimate> {
    let of_part = |part: usize| totals.iter().map(|of_city| of_city[part]).collect::<Vec<Count>>();
    (0..n_parts).map(|part| clustered(&of_part(part), confidence)).collect()
}
