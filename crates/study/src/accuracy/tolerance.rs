//! Coarsest form of a scene whose P_LoS is within a tolerance of the exact one, as measured.
//!
//! Forms are tried from the coarsest to the finest. A form is mapped as it is, which is cheap, and
//! gives P_LoS = A. The difference between A and the exact P is *measured*: receivers of the scene
//! itself are drawn at random and decided by `ray`. Each is paired with the answer of the larger
//! cell that holds it, so that only disagreements are uncertain. With e the exact answer of a
//! receiver of the scene (1 for LoS) and c that of the larger cell (0 if it has none),
//!
//! ```text
//!   A − P = A − mean(c) − mean(e − c)
//! ```
//!
//! Here mean(c) is counted over all receivers. The term mean(e − c) is estimated from three counts
//! of the sample: e = 1 in NLoS cells, e = 0 in LoS cells, and e = 1 in cells without a receiver.
//! Each count has an exact binomial bound (Clopper & Pearson 1934), so |A − P| has one, too.
//!
//! The bound fails with a probability of at most 1 %. That is divided evenly between both signs,
//! the three counts, all forms that may be tried, and all UAVs. So with 99 % confidence *no* form
//! is taken wrongly, however many were tried. If a sample would need more receivers than there are,
//! all are decided and nothing is uncertain.
//!
//! Approximate engines are no candidates: on every scene measured, the exact ones are faster
//! (`skyshed chart` shows it).

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rayon::prelude::*;

use super::simpler::{CoarseAnswer, FACTORS, Simpler, coarse_answer, moved_to};
use crate::coverage::{MapOptions, Mapper, Seen, Uav};
use crate::error::Result;
use crate::height_field::HeightField;
use crate::los_probability::estimate::clopper_pearson;
use crate::raster::{BitGrid, set_bits};

/// Probability that no form is taken whose P_LoS is off by more than the tolerance.
pub const CONFIDENCE: f64 = 0.99;

/// Fewest cells along the shorter side of a form that is tried.
const FEWEST_CELLS: usize = 8;

/// Number of receivers drawn, times the square of the tolerance. It suffices for the bounds if one
/// in twenty disagrees.
const SAMPLE: f64 = 6.0;

/// Fewest receivers that are drawn.
const SMALLEST_SAMPLE: f64 = 2000.0;

/// Search for the coarsest form of a scene.
#[derive(Debug)]
pub struct Question<'a> {
    /// The scene itself.
    pub field: &'a HeightField,
    /// UAVs over it.
    pub uavs: &'a [Uav],
    /// Largest error of P_LoS of any of them, above 0 and below 1.
    pub tolerance: f64,
    /// Seed of the sample.
    pub seed: u64,
}

/// Measurement of one form and one UAV.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// P_LoS of the simpler form.
    pub p_los: f64,
    /// Estimate of this P_LoS minus the exact one.
    pub difference: f64,
    /// Bound on the absolute difference, at the confidence.
    pub bound: f64,
    /// Receivers of the scene that were decided exactly.
    pub sample: u64,
    /// Receivers of the scene in range.
    pub receivers: u64,
}

/// Form that was tried.
#[derive(Debug, Clone)]
pub struct Tried {
    /// The form.
    pub form: Simpler,
    /// Measurement for each UAV, or the reason why there is none.
    pub measured: std::result::Result<Vec<Measured>, String>,
}

impl Tried {
    /// Returns the largest bound of all UAVs; `None` if nothing could be measured.
    pub fn bound(&self) -> Option<f64> {
        self.measured.as_ref().ok().map(|all| all.iter().fold(0.0, |most, m| m.bound.max(most)))
    }
}

/// Result of a search.
#[derive(Debug)]
pub struct Choice {
    /// Forms that were tried; the last one was taken if its bound is within the tolerance.
    pub tried: Vec<Tried>,
    /// Form to use, with the UAVs over it; `None` if no simpler one is within the tolerance.
    pub taken: Option<(Simpler, HeightField, Vec<Uav>)>,
}

/// Finds the coarsest form whose P_LoS is within the tolerance for every UAV.
///
/// `options` gives the options of a map of a form: cells of zones are those of its own grid.
///
/// Cost: a map of each form tried by the engine for it, for each UAV; and a ray for each of
/// 6/tolerance² receivers (at least 2000), for each UAV.
pub fn coarsest_within(
    question: &Question<'_>,
    options: &(dyn Fn(&HeightField) -> Result<MapOptions> + Sync),
) -> Result<Choice> {
    let grid = question.field.grid();
    let factors: Vec<usize> =
        FACTORS.into_iter().rev().filter(|f| grid.n_rows().min(grid.n_cols()) / f >= FEWEST_CELLS).collect();
    let forms = Simpler::forms(question.field, &factors);
    let exact_options = options(question.field)?;
    let exact = Mapper::new(question.field, &exact_options)?;
    let n_bounds = (6 * forms.len() * question.uavs.len().max(1)) as f64;
    let draw = |(k, uav)| Sample::draw(&exact, uav, question, k as u64);
    let samples: Vec<Sample> = question.uavs.par_iter().enumerate().map(draw).collect::<Result<_>>()?;
    let mut tried = Vec::new();
    for form in forms {
        let Some(field) = form.of(question.field) else { continue };
        let options = options(&field)?;
        let mapper = Mapper::new(&field, &options)?;
        let uavs: Result<Vec<Uav>> = question.uavs.iter().map(|uav| moved_to(uav, &field)).collect();
        let measured = uavs.map_err(|e| e.to_string()).and_then(|uavs| {
            let of_uav = |(uav, sample): (&Uav, &Sample)| {
                let seen = mapper.seen_from(uav).map_err(|e| e.to_string())?.seen();
                sample.measure(&seen, form.factor, (1.0 - CONFIDENCE) / n_bounds)
            };
            let all: std::result::Result<Vec<Measured>, String> = uavs.par_iter().zip(&samples).map(of_uav).collect();
            Ok((all?, uavs))
        });
        let (measured, uavs) = match measured {
            Ok((measured, uavs)) => (Ok(measured), Some(uavs)),
            Err(why) => (Err(why), None),
        };
        tried.push(Tried { form, measured });
        let is_within = tried.last().and_then(Tried::bound).is_some_and(|bound| bound <= question.tolerance);
        if let Some(uavs) = uavs.filter(|_| is_within) {
            drop(mapper);
            return Ok(Choice { tried, taken: Some((form, field, uavs)) });
        }
    }
    Ok(Choice { tried, taken: None })
}

/// Receivers of one UAV with their exact answers.
struct Sample {
    receivers: BitGrid,
    n_receivers: u64,
    /// Row, column and answer of each receiver drawn; all receivers, once each, if `is_all`.
    drawn: Vec<((usize, usize), bool)>,
    is_all: bool,
}

impl Sample {
    fn draw(mapper: &Mapper<'_>, uav: &Uav, question: &Question<'_>, stream: u64) -> Result<Self> {
        let view = mapper.seen_from(uav)?;
        let receivers = view.receivers_in_range();
        let n_receivers = receivers.count();
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates where all are taken")]
        let n = (SAMPLE / (question.tolerance * question.tolerance)).max(SMALLEST_SAMPLE).ceil() as u64;
        let is_all = n >= n_receivers;
        let drawn = if is_all {
            let los = view.seen().los;
            receivers.cells().map(|cell| (cell, los.contains(cell.0, cell.1))).collect()
        } else {
            let cells = random_cells(&receivers, n, (question.seed, stream)).into_par_iter();
            cells.map(|cell| (cell, view.is_los(cell).unwrap_or(false))).collect()
        };
        Ok(Sample { receivers, n_receivers, drawn, is_all })
    }

    /// Measures a simpler map; each of six bounds fails with probability `risk`.
    fn measure(&self, coarse: &Seen, factor: usize, risk: f64) -> std::result::Result<Measured, String> {
        let (of, los) = (coarse.receivers.count(), coarse.los.count());
        if of == 0 || self.n_receivers == 0 {
            return Err("no receiver in range".into());
        }
        let p_los = los as f64 / of as f64;
        let answer = |cell| coarse_answer(&coarse.receivers, &coarse.los, factor, cell);
        let (n_los, n_none) = (0..self.receivers.n_rows())
            .into_par_iter()
            .map(|row| {
                set_bits(self.receivers.row(row)).fold((0_u64, 0_u64), |(los, none), col| match answer((row, col)) {
                    CoarseAnswer::Los => (los + 1, none),
                    CoarseAnswer::Nlos => (los, none),
                    CoarseAnswer::None => (los, none + 1),
                })
            })
            .reduce(|| (0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
        let (mut gained, mut lost, mut unanswered) = (0_u64, 0_u64, 0_u64);
        for (cell, is_los) in &self.drawn {
            match (answer(*cell), is_los) {
                (CoarseAnswer::Nlos, true) => gained += 1,
                (CoarseAnswer::Los, false) => lost += 1,
                (CoarseAnswer::None, true) => unanswered += 1,
                _ => {}
            }
        }
        let (all, n) = (self.n_receivers as f64, self.drawn.len() as u64);
        let share_none = n_none as f64 / all;
        // A − mean(c).
        let known = p_los - n_los as f64 / all;
        let share = |k: u64| k as f64 / n as f64;
        let difference = known - (share(gained) - share(lost) + share(unanswered));
        let bound = if self.is_all {
            difference.abs()
        } else {
            let of = |k: u64| clopper_pearson(k, n, 1.0 - 2.0 * risk);
            let (gained, lost, unanswered) = (of(gained), of(lost), of(unanswered));
            let lowest = known - (gained.1 - lost.0 + unanswered.1.min(share_none));
            let highest = known - (gained.0 - lost.1 + unanswered.0);
            lowest.abs().max(highest.abs())
        };
        Ok(Measured { p_los, difference, bound, sample: n, receivers: self.n_receivers })
    }
}

/// Draws `n` cells of a set with replacement.
fn random_cells(cells: &BitGrid, n: u64, (seed, stream): (u64, u64)) -> Vec<(usize, usize)> {
    let mut before = Vec::with_capacity(cells.n_rows() + 1);
    let mut total = 0_u64;
    for row in 0..cells.n_rows() {
        before.push(total);
        total += cells.row(row).iter().map(|w| u64::from(w.count_ones())).sum::<u64>();
    }
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(stream);
    let draw = |_| {
        let rank = ((u128::from(random.next_u64()) * u128::from(total)) >> 64) as u64;
        let row = before.partition_point(|b| *b <= rank) - 1;
        #[expect(clippy::cast_possible_truncation, reason = "below the number of columns")]
        let in_row = (rank - before[row]) as usize;
        (row, nth_cell(cells.row(row), in_row))
    };
    (0..n).map(draw).collect()
}

/// Returns the column of cell number `n` of a row.
fn nth_cell(words: &[u64], n: usize) -> usize {
    let mut left = n;
    for (k, word) in words.iter().enumerate() {
        let here = word.count_ones() as usize;
        if left < here {
            return 64 * k + set_bits(&[*word]).nth(left).unwrap_or(0);
        }
        left -= here;
    }
    0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_drawn_evenly_from_a_set() {
        let mut cells = BitGrid::new(3, 130);
        for cell in [(0, 5), (0, 129), (2, 0), (2, 64)] {
            cells.insert(cell.0, cell.1);
        }
        assert!(cells.cells().eq([(0, 5), (0, 129), (2, 0), (2, 64)]));
        let drawn = random_cells(&cells, 40_000, (3, 1));
        for cell in cells.cells() {
            let n = drawn.iter().filter(|c| **c == cell).count();
            // 10 000 ± 4 standard deviations of 87.
            assert!((9650..10_350).contains(&n), "{cell:?} {n} times");
        }
        assert_ne!(drawn, random_cells(&cells, 40_000, (3, 2)));
    }
}
