//! P_LoS over one real city: exact maps from many UAV positions, counted by elevation angle or by
//! distance.
//!
//! One city gives no independent draws, and its users share both their buildings and the UAVs. So
//! the interval comes from resampling blocks of ground, whose users share their surroundings, and
//! UAV positions. Both are drawn with replacement, independently of each other, a thousand times,
//! and the ratio of sums is formed anew.
//!
//! The interval measures how far another sample of blocks and positions *of a city like this one*
//! would move P_LoS. It is somewhat too wide, never too narrow, because a cell of
//! blocks × positions varies in both drawings.
//!
//! # References
//! Owen 2007, "The pigeonhole bootstrap", Ann. Appl. Stat. 1, 386–411.

use rayon::prelude::*;

use super::estimate::{Count, Estimate, FEWEST_CLUSTERS};
use crate::city_statistics::bootstrap::{Drawing, RESAMPLINGS, spread};
use crate::height_field::{HeightField, Station};
use crate::los::{GridLos, GridReceivers, Method, MethodChoice, WrongMethod};
use crate::quantity::STEPS_PER_UNIT;
use crate::raster::{BitGrid, CellBlocks, CellWindow, set_bits};

/// Band of users who are counted together. Comparisons are of squares, so no user needs a root.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Band {
    by: By,
    from: f64,
    to: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum By {
    SquaredTangent,
    SquaredDistance,
}

impl Band {
    /// Makes the band of users who see the UAV at an elevation angle from `from` up to `to`
    /// \[deg\], 0 ≤ from < to. `to` is excluded unless it is 90.
    pub fn elevation(from: f64, to: f64) -> Self {
        let squared = |theta: f64| if theta >= 90.0 { f64::INFINITY } else { theta.to_radians().tan().powi(2) };
        Band { by: By::SquaredTangent, from: squared(from), to: squared(to) }
    }

    /// Makes the band of users at a ground distance from `from` up to, but without, `to` \[m\].
    pub fn distance(from: f64, to: f64) -> Self {
        Band { by: By::SquaredDistance, from: from * from, to: to * to }
    }

    /// Returns `true` if a user is in it who is `squared_distance` \[m²\] away on the ground and
    /// `rise` \[m\] below.
    #[inline]
    fn holds(&self, squared_distance: f64, rise: f64) -> bool {
        match self.by {
            By::SquaredDistance => squared_distance >= self.from && squared_distance < self.to,
            By::SquaredTangent => {
                let squared_rise = rise * rise;
                rise >= 0.0
                    && squared_rise >= self.from * squared_distance
                    && (self.to == f64::INFINITY || squared_rise < self.to * squared_distance)
            }
        }
    }
}

/// Bands that may overlap, cut at the ends of all of them. A user is in at most one part, and a
/// band is the sum of its parts.
struct BandParts {
    parts: Vec<Band>,
    of_bands: Vec<std::ops::Range<usize>>,
}

impl BandParts {
    /// Cuts bands, all by one quantity.
    fn of(bands: &[Band]) -> Self {
        let mut ends: Vec<f64> = bands.iter().flat_map(|band| [band.from, band.to]).collect();
        ends.sort_by(f64::total_cmp);
        ends.dedup();
        let index = |end: f64| ends.partition_point(|e| *e < end);
        let of_bands = bands.iter().map(|band| index(band.from)..index(band.to)).collect();
        let by = bands.first().map_or(By::SquaredDistance, |band| band.by);
        let parts = ends.windows(2).map(|ends| Band { by, from: ends[0], to: ends[1] }).collect();
        BandParts { parts, of_bands }
    }
}

/// Real city prepared for counting.
#[derive(Debug)]
pub struct RealCity<'a> {
    field: &'a HeightField,
    engine: GridLos<'a>,
    receivers: GridReceivers<'a>,
    meters_per_unit: f64,
    blocks: CellBlocks,
}

impl<'a> RealCity<'a> {
    /// Makes a city with users on all open ground, `rx_height` \[1/1024 m\] above it, in blocks of
    /// a side of `block_m` \[m\].
    pub fn new(
        field: &'a HeightField,
        choice: MethodChoice,
        rx_height: i32,
        meters_per_unit: f64,
        block_m: f64,
    ) -> Result<Self, WrongMethod> {
        let (method, _) = Method::choose(field, choice)?;
        Ok(RealCity {
            field,
            engine: GridLos::new(field, method)?,
            receivers: GridReceivers::new(&field.cells().open, field.ground_of_cells(), rx_height),
            meters_per_unit,
            blocks: CellBlocks::new(field.grid(), meters_per_unit, block_m),
        })
    }

    /// Returns the engine in use.
    pub fn method(&self) -> Method {
        self.engine.method()
    }

    /// Restricts users to some of the cells, such as those of a zone.
    #[must_use]
    pub fn with_users(mut self, cells: &BitGrid) -> Self {
        self.receivers.cells = self.field.cells().open.clone().and(cells).into();
        self
    }

    /// Returns the number of blocks.
    pub fn n_blocks(&self) -> usize {
        self.blocks.count()
    }

    /// Returns the blocks that hold any user, in whichever band.
    pub fn blocks_with_users(&self) -> Vec<usize> {
        let mut holds = vec![false; self.n_blocks()];
        for row in 0..self.receivers.cells.n_rows() {
            let first = self.blocks.first_of_row(row);
            set_bits(self.receivers.cells.row(row)).for_each(|col| holds[first + col / self.blocks.n_cols()] = true);
        }
        (0..holds.len()).filter(|block| holds[*block]).collect()
    }

    /// Returns `true` if a UAV is inside a building.
    pub fn is_inside(&self, uav: &Station) -> bool {
        let inside = self.field.inside_prisms_below(&uav.place).max(self.field.inside_columns_below(&uav.place));
        uav.z < i64::from(inside)
    }

    /// Counts the users of a UAV and those that it sees, `[block][band]`; bands may overlap. A UAV
    /// inside a building sees nothing.
    pub fn count(&self, uav: &Station, bands: &[Band]) -> Vec<Count> {
        let grid = self.field.grid();
        let (n_rows, n_cols) = (grid.n_rows(), grid.n_cols());
        let los = if self.is_inside(uav) {
            BitGrid::new(n_rows, n_cols)
        } else {
            let window = CellWindow { row: 0, col: 0, n_rows, n_cols };
            self.engine.los(uav, &self.receivers, &self.receivers.cells, window)
        };
        let BandParts { parts, of_bands } = BandParts::of(bands);
        if parts.is_empty() {
            return vec![Count::default(); self.n_blocks() * bands.len()];
        }
        let mut counts = vec![Count::default(); self.n_blocks() * parts.len()];
        // Whole lattice steps make a city and its mirror image agree at the end of a band.
        let positions = self.field.positions();
        let (at, step_lengths) = (positions.on_range(&uav.place), positions.step_lengths());
        let steps_to = |row: usize, col: usize| positions.steps(at, (row, col));
        for row in 0..n_rows {
            let wanted = self.receivers.cells.row(row);
            let seen = los.row(row);
            let first_block = self.blocks.first_of_row(row);
            let mut part = 0;
            for col in (0..n_cols).filter(|col| wanted[col / 64] >> (col % 64) & 1 == 1) {
                let (east, north) = steps_to(row, col);
                #[expect(clippy::cast_precision_loss, reason = "lattice positions in reach are below 2^53")]
                let (dx, dy) = (east as f64 * step_lengths.0, north as f64 * step_lengths.1);
                let squared = (dx * dx + dy * dy) * self.meters_per_unit * self.meters_per_unit;
                #[expect(clippy::cast_precision_loss, reason = "heights are at most 2^27 steps")]
                let rise = (uav.z - self.receivers.height(row * n_cols + col)) as f64 / f64::from(STEPS_PER_UNIT);
                // Most neighbors are in one part.
                if !parts[part].holds(squared, rise) {
                    let Some(found) = parts.iter().position(|b| b.holds(squared, rise)) else { continue };
                    part = found;
                }
                let count = &mut counts[(first_block + col / self.blocks.n_cols()) * parts.len() + part];
                count.receivers += 1;
                count.los += seen[col / 64] >> (col % 64) & 1;
            }
        }
        let of_block =
            |counts: &[Count]| of_bands.iter().map(|of| counts[of.clone()].iter().copied().sum()).collect::<Vec<_>>();
        counts.chunks(parts.len()).flat_map(of_block).collect()
    }
}

/// Estimates P_LoS by band from counts `[position][block][band]`, with intervals from resampled
/// positions and blocks.
///
/// `blocks` are the blocks to resample: those that hold any user. Nothing else affects the drawing,
/// so the interval of a band does not depend on the bands counted with it.
pub fn resampled(counts: &[Vec<Count>], blocks: &[usize], n_bands: usize, confidence: f64, seed: u64) -> Vec<Estimate> {
    let n_positions = counts.len();
    let sum = |weight: &(dyn Fn(usize, usize) -> f64 + Sync)| {
        let mut sums = vec![(0.0, 0.0); n_bands];
        for (p, of_position) in counts.iter().enumerate() {
            for (k, block) in blocks.iter().enumerate() {
                let weight = weight(p, k);
                if weight > 0.0 {
                    for (sum, count) in sums.iter_mut().zip(&of_position[block * n_bands..]) {
                        sum.0 += weight * count.los as f64;
                        sum.1 += weight * count.receivers as f64;
                    }
                }
            }
        }
        sums
    };
    let all = sum(&|_, _| 1.0);
    let is_enough = n_positions as u64 >= FEWEST_CLUSTERS && blocks.len() as u64 >= FEWEST_CLUSTERS;
    let resamplings: Vec<Vec<(f64, f64)>> = (0..if is_enough { RESAMPLINGS } else { 0 })
        .into_par_iter()
        .map(|k| {
            let mut drawing = Drawing::nth(seed, k);
            let (positions, of_blocks) = (drawing.times(n_positions), drawing.times(blocks.len()));
            sum(&|p, b| positions[p] * of_blocks[b])
        })
        .collect();
    (0..n_bands)
        .map(|band| {
            let (los, receivers) = all[band];
            if receivers == 0.0 {
                return Estimate::none();
            }
            let p_los = los / receivers;
            let resampled = resamplings.iter().map(|r| r[band]);
            // A band that is missed by many resamplings has too few blocks and positions for an
            // interval.
            let spread = spread(p_los, resampled, confidence).filter(|_| is_enough);
            let with_users = |b: &&usize| counts.iter().any(|c| c[**b * n_bands + band].receivers > 0);
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a sum of counts")]
            let samples = receivers as u64;
            Estimate {
                p_los: Some(p_los),
                interval: spread.map(|s| s.interval),
                std_error: spread.map(|s| s.std_error),
                samples,
                clusters: blocks.iter().filter(with_users).count() as u64,
            }
        })
        .collect()
}
