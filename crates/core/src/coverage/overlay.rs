//! Layers over several UAVs: how many see a cell, which ones, and whether any does.

use rayon::prelude::*;

use super::{TimeSpan, Times, Uav, class};

/// Layers of many masks beside the count of UAVs that see a cell and the union.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Together {
    /// Numbers of the UAVs that see a cell.
    pub which: bool,
    /// Nearest UAV that sees a cell.
    pub best_server: bool,
    /// Cells that every UAV sees.
    pub all: bool,
    /// Share of time in which a cell is seen.
    pub uptime: bool,
    /// Longest time in which a cell is not seen.
    pub gap: bool,
    /// Span of time, if one is told about.
    pub time: Option<TimeSpan>,
    /// `true` for layers over a single UAV, too.
    pub even_of_one: bool,
    /// Place of each UAV in a list of all of them, of which some are mapped here, and its length.
    /// Without one, UAVs are numbered as they come.
    pub of_list: Option<(Vec<usize>, usize)>,
}

/// The masks of many UAVs laid over each other one by one, so that none need be kept.
#[derive(Debug, Clone)]
pub struct Overlay {
    union: Vec<u8>,
    count: Vec<u32>,
    /// UAVs of the list.
    n_uavs: usize,
    /// See [`Overlay::which`].
    which: Vec<Vec<u32>>,
    best: Option<BestServer>,
    /// See [`Overlay::all`].
    all: Option<Vec<u8>>,
    /// See [`Overlay::times`].
    times: Option<Times>,
    /// See [`Overlay::uptime`].
    uptime: Option<Vec<f32>>,
    /// See [`Overlay::gap`].
    gap: Option<Vec<f32>>,
}

/// The nearest UAV of each cell so far.
#[derive(Debug, Clone)]
struct BestServer {
    /// Its number from 1; 0 for none.
    number: Vec<u32>,
    /// Its squared distance \[m²\].
    squared_m2: Vec<f64>,
}

impl Overlay {
    /// Returns an overlay without a cell that anyone sees.
    pub fn new(n_cells: usize) -> Self {
        Overlay {
            union: vec![class::NODATA; n_cells],
            count: vec![0; n_cells],
            n_uavs: 0,
            which: Vec::new(),
            best: None,
            all: None,
            times: None,
            uptime: None,
            gap: None,
        }
    }

    /// Returns known cells as out of range of anyone, for some UAVs of a list of `n_uavs`.
    pub(super) fn of_cells(known: impl Iterator<Item = bool>, together: &Together, uavs: &[Uav]) -> Self {
        let n_uavs = together.of_list.as_ref().map_or(uavs.len(), |(_, n)| *n);
        let union: Vec<u8> = known.map(|is| if is { class::OUT_OF_RANGE } else { class::NODATA }).collect();
        let n_cells = union.len();
        let n_words = if together.which { n_uavs.div_ceil(32) } else { 0 };
        let best = BestServer { number: vec![0; n_cells], squared_m2: vec![f64::INFINITY; n_cells] };
        Overlay {
            union,
            count: vec![0; n_cells],
            n_uavs,
            which: vec![vec![0; n_cells]; n_words],
            best: together.best_server.then_some(best),
            // Of no UAV: each mask only makes it worse.
            all: together.all.then(|| vec![class::LOS; n_cells]),
            times: together.time.map(|span| Times::of(span, uavs, n_cells)),
            ..Overlay::new(0)
        }
    }

    /// Adds the mask of one UAV.
    pub fn add(&mut self, mask: &[u8]) {
        // Parts that are long enough to be worth a thread.
        const PART: usize = 1 << 16;
        let parts = self.union.par_chunks_mut(PART).zip(self.count.par_chunks_mut(PART)).zip(mask.par_chunks(PART));
        parts.for_each(|((union, count), mask)| {
            for ((union, count), class) in union.iter_mut().zip(count).zip(mask) {
                *count += u32::from(*class == class::LOS);
                if rank(*class) < rank(*union) {
                    *union = *class;
                }
            }
        });
    }

    /// Adds the mask of a UAV, the `k`-th of a list, in rows of `n_cols`, with its squared distances
    /// \[m²\] by row and column.
    pub(super) fn add_one_of(
        &mut self,
        (k, uav): (usize, &Uav),
        (mask, n_cols): (&[u8], usize),
        squared_m2: impl Fn((usize, usize)) -> f64 + Sync,
    ) {
        self.add(mask);
        if let Some(all) = &mut self.all {
            all.par_iter_mut().zip(mask).for_each(|(all, class)| *all = worse(*all, *class));
        }
        if let Some(times) = &mut self.times {
            times.add(uav, mask);
        }
        if let Some(word) = self.which.get_mut(k / 32) {
            let seen = word.par_iter_mut().zip(mask).filter(|(_, class)| **class == class::LOS);
            seen.for_each(|(word, _)| *word |= 1 << (k % 32));
        }
        let Some(best) = &mut self.best else { return };
        let own = u32::try_from(k + 1).unwrap_or(u32::MAX);
        let rows = best.number.par_chunks_mut(n_cols).zip(best.squared_m2.par_chunks_mut(n_cols));
        rows.zip(mask.par_chunks(n_cols)).enumerate().for_each(|(row, ((numbers, squares), mask))| {
            for (col, _) in mask.iter().enumerate().filter(|(_, class)| **class == class::LOS) {
                let squared = squared_m2((row, col));
                // At equal distances the first of the list, whatever the order in which they come.
                if squared < squares[col] || (squared <= squares[col] && own < numbers[col]) {
                    (numbers[col], squares[col]) = (own, squared);
                }
            }
        });
    }

    /// Makes the layers of time, once all masks are added.
    pub(super) fn finish(&mut self, together: &Together) {
        let Some(times) = &self.times else { return };
        let of_receivers = |mut values: Vec<f32>| {
            let receives = |class: u8| matches!(class, class::LOS | class::NLOS);
            let others = values.par_iter_mut().zip(&self.union).filter(|(_, class)| !receives(**class));
            others.for_each(|(value, _)| *value = f32::NAN);
            values
        };
        let uptime = together.uptime.then(|| of_receivers(times.uptime()));
        let gap = together.gap.then(|| of_receivers(times.gap()));
        (self.uptime, self.gap) = (uptime, gap);
    }

    /// Returns the stretches of time in which cells are seen, if a span was given.
    pub fn times(&self) -> Option<&Times> {
        self.times.as_ref()
    }

    /// Returns the share of the span in which some UAV sees each cell, 0 to 1, NaN where there is no
    /// receiver of the union; `None` if not wanted.
    pub fn uptime(&self) -> Option<&[f32]> {
        self.uptime.as_deref()
    }

    /// Returns the longest time of the span in which no UAV sees each cell \[min\], NaN where there is no
    /// receiver of the union; `None` if not wanted.
    pub fn gap(&self) -> Option<&[f32]> {
        self.gap.as_deref()
    }

    /// Returns the number of UAVs in the list of all; 0 if it is not known.
    pub fn n_uavs(&self) -> usize {
        self.n_uavs
    }

    /// Returns the UAVs that see each cell, if wanted: one word per 32 UAVs, bit k of word w for
    /// UAV 32·w + k.
    pub fn which(&self) -> &[Vec<u32>] {
        &self.which
    }

    /// Returns the nearest UAV that sees each cell by its number in the list, from 1, at equal
    /// distances the first; 0 for none. `None` if not wanted.
    pub fn best_server(&self) -> Option<&[u32]> {
        self.best.as_ref().map(|best| best.number.as_slice())
    }

    /// Returns the mask of all UAVs together.
    ///
    /// LoS if any sees the cell, else NLoS if it is a receiver of one. Not a receiver if it is in
    /// range of one, out of range if it has a height, else nodata.
    pub fn union(&self) -> &[u8] {
        &self.union
    }

    /// Returns the mask of what every UAV sees, if wanted.
    ///
    /// Nodata where no height is known, out of range if it is so for one UAV, else not a receiver, else LoS
    /// if every UAV sees the cell.
    pub fn all(&self) -> Option<&[u8]> {
        self.all.as_deref()
    }

    /// Returns the number of UAVs that see each cell.
    pub fn count(&self) -> &[u32] {
        &self.count
    }

    /// Returns the number of receivers that exactly 0, 1, 2, … UAVs see, up to all `n_uavs` that
    /// were added.
    pub fn seen_by(&self, n_uavs: usize) -> Vec<u64> {
        let mut counts = vec![0; n_uavs + 1];
        for (class, count) in self.union.iter().zip(&self.count) {
            if matches!(*class, class::NLOS | class::LOS) {
                counts[*count as usize] += 1;
            }
        }
        counts
    }
}

/// Returns the worse of two classes of a cell.
fn worse(before: u8, next: u8) -> u8 {
    if rank(next) > rank(before) { next } else { before }
}

/// Returns the rank of a class: a cell of the union has the class of the lowest rank in any mask.
fn rank(class: u8) -> u8 {
    match class {
        class::LOS => 0,
        class::NLOS => 1,
        class::NOT_A_RECEIVER => 2,
        class::OUT_OF_RANGE => 3,
        _ => 4,
    }
}
