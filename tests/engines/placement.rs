//! Where to hover: the best candidate is that of a brute force by rays, the bound is never below an optimum found by
//! trying every choice, the least height is that of a linear search.

use skyshed_core::city::BuiltUpCity;
use skyshed_core::coverage::{Control, HeightLayers, MapOptions, Mapper, Receivers, class};
use skyshed_core::height_field::HeightField;
use skyshed_core::los::MethodChoice;
use skyshed_core::quantity::Height;
use skyshed_core::raster::BitGrid;
use skyshed_study::placement::{
    Candidate, CandidateRules, Candidates, PlaceGrid, Scorer, SeenSets, Weights, cover, greedy_cover, least_heights,
    ranked, ranked_margins, scores, worst_margins,
};

use crate::cities::{built, generated};
use crate::invariants::{raster_town, vector_town};
use crate::support::Random;

const HEIGHTS: [Height; 3] = [Height::AboveGround(3.0), Height::AboveGround(8.0), Height::AboveGround(20.0)];

fn candidates(field: &HeightField, step: f64) -> Vec<Candidate> {
    let places = PlaceGrid::over(field.grid(), step).unwrap();
    Candidates::of(&places.spots(&HEIGHTS), field, &CandidateRules::default()).unwrap().kept
}

/// Seen in range and wanted anywhere, by rays, cell by cell, each cell counting what `weight` says.
fn by_rays(field: &HeightField, candidate: &Candidate, options: &MapOptions, weight: &[f64]) -> (f64, f64) {
    let options = MapOptions { method: MethodChoice::Ray, ..options.clone() };
    let sum = |radius: Option<f64>, wanted: &[u8]| {
        let options = MapOptions { radius, ..options.clone() };
        let map =
            Mapper::new(field, &options).unwrap().seen_from(&candidate.uav).unwrap().map(&Control::default()).unwrap();
        map.mask.iter().zip(weight).filter(|(c, _)| wanted.contains(c)).map(|(_, w)| w).sum()
    };
    (sum(options.radius, &[class::LOS]), sum(None, &[class::LOS, class::NLOS]))
}

#[test]
fn the_best_candidate_is_that_of_a_brute_force_by_rays() {
    let mut random = Random(51);
    let city = built(&BuiltUpCity { cell_m: 4.0, ..generated("urban", 3, 120.0) });
    for field in [raster_town(&mut random, 24), vector_town(&mut random, 28), city] {
        let candidates = candidates(&field, (field.grid().x_max() - field.grid().x_min()) / 5.0);
        assert!(candidates.len() > 20);
        let n = field.grid().n_cells();
        let mut within = BitGrid::new(field.grid().n_rows(), field.grid().n_cols());
        (0..n).filter(|_| random.chance(30)).for_each(|k| within.insert(k / within.n_cols(), k % within.n_cols()));
        // Whole numbers up to a power of two are weights without rounding.
        let mut some: Vec<f64> = (0..n).map(|_| f64::from(u32::try_from(random.below(9)).unwrap())).collect();
        some[0] = 8.0;
        for (receivers, within, radius, weight) in [
            (Receivers::Ground, None, None, None),
            (Receivers::Roof, None, None, None),
            (Receivers::All, Some(within), None, None),
            (Receivers::Ground, None, Some(40.0), None),
            (Receivers::All, None, None, Some(some)),
        ] {
            let options = MapOptions { receivers, within, radius, ..MapOptions::default() };
            let mapper = Mapper::new(&field, &options).unwrap();
            let weights = weight.as_ref().map(|w| Weights::new(w, field.grid().n_cols()).unwrap());
            let uavs: Vec<_> = candidates.iter().map(|c| &c.uav).collect();
            let scorer = Scorer::new(&mapper, weights.as_ref());
            let found = scores(&scorer, &uavs, &Control::default()).unwrap();
            let weight = weight.unwrap_or(vec![1.0; n]);
            let wanted: Vec<(f64, f64)> = candidates.iter().map(|c| by_rays(&field, c, &options, &weight)).collect();
            let mut best = 0;
            for (k, (seen, all)) in wanted.iter().enumerate() {
                assert_eq!(found[k].share(), (*all > 0.0).then(|| seen / all), "candidate {k}");
                // Strictly better only, by products: the first of equal ones is kept.
                if *all > 0.0 && (wanted[best].1 <= 0.0 || seen * wanted[best].1 > wanted[best].0 * all) {
                    best = k;
                }
            }
            assert_eq!(ranked(&found)[0], best);
        }
    }
}

#[test]
fn the_least_height_is_that_of_a_linear_search() {
    let mut random = Random(52);
    let mut n_reached = 0;
    for field in [raster_town(&mut random, 24), vector_town(&mut random, 28)] {
        let places = PlaceGrid::over(field.grid(), 6.0).unwrap();
        let heights: Vec<Height> = (1..=14).map(|h| Height::AboveGround(3.0 * f64::from(h))).collect();
        let kept = Candidates::of(&places.spots(&heights), &field, &CandidateRules::default()).unwrap().kept;
        let options = MapOptions::default();
        let mapper = Mapper::new(&field, &options).unwrap();
        let scorer = Scorer::new(&mapper, None);
        for share in [0.3, 0.6, 0.9, 1.0] {
            let found = least_heights(&scorer, &kept, share, &Control::default()).unwrap();
            for found in &found {
                let place = kept[found.candidate].spot.place;
                let mut linear = (0..kept.len()).filter(|k| kept[*k].spot.place == place);
                let reaches = |k: &usize| scorer.score(&kept[*k].uav).unwrap().share().unwrap() >= share;
                assert_eq!(linear.find(reaches), found.reaches.then_some(found.candidate));
                n_reached += usize::from(found.reaches);
            }
        }
    }
    assert!(n_reached > 20, "{n_reached}");
}

#[test]
fn the_worst_margin_is_the_least_of_the_layer() {
    let mut random = Random(53);
    for field in [raster_town(&mut random, 20), vector_town(&mut random, 21)] {
        let kept = candidates(&field, 4.0);
        for radius in [None, Some(9.0)] {
            let layers = HeightLayers { margin: true, ..HeightLayers::default() };
            let options = MapOptions { layers, radius, receivers: Receivers::All, ..MapOptions::default() };
            let mapper = Mapper::new(&field, &options).unwrap();
            let least = |c: &Candidate| {
                let map = mapper.seen_from(&c.uav).unwrap().map(&Control::default()).unwrap();
                map.margin.unwrap().into_iter().filter(|m| !m.is_nan()).min_by(f32::total_cmp)
            };
            let wanted: Vec<Option<f32>> = kept.iter().map(least).collect();
            let found = worst_margins(&mapper, &kept, 5, &Control::default()).unwrap();
            for (found, wanted) in found.iter().zip(&wanted) {
                match (found, wanted) {
                    (Some(f), Some(w)) if f.exact => assert!(f.margin_m.total_cmp(w).is_eq(), "{f:?} {w}"),
                    (Some(f), Some(w)) => assert!(f.margin_m >= *w, "{f:?} {w}"),
                    (found, wanted) => assert!(found.is_none() && wanted.is_none()),
                }
            }
            let mut order: Vec<usize> = (0..kept.len()).filter(|k| wanted[*k].is_some()).collect();
            order.sort_by(|a, b| wanted[*b].unwrap().total_cmp(&wanted[*a].unwrap()));
            let ranks = ranked_margins(&found);
            assert_eq!(ranks[..5], order[..5]);
            assert!(ranks[..5].iter().all(|k| found[*k].unwrap().exact));
        }
    }
}

/// The largest value of any union of `k` of the sets.
fn optimum(sets: &[u64], weights: &[u64], k: usize, covered: u64) -> u128 {
    let value = |set: u64| (0..weights.len()).filter(|i| set >> i & 1 == 1).map(|i| u128::from(weights[i])).sum();
    match (k, sets) {
        (0, _) | (_, []) => value(covered),
        (_, [first, rest @ ..]) => {
            optimum(rest, weights, k, covered).max(optimum(rest, weights, k - 1, covered | first))
        }
    }
}

#[test]
fn greedy_is_within_its_guarantee_and_the_bound_is_never_below_the_optimum() {
    let mut random = Random(54);
    let (mut n_tight, mut n_short) = (0, 0);
    for round in 0..400 {
        let (n_items, n_sets) = (random.index(1, 40), random.index(1, 11));
        let k = random.index(1, 4);
        let density = 5 + 10 * (round % 7);
        let draw = |random: &mut Random| (0..n_items).filter(|_| random.chance(density)).fold(0_u64, |s, i| s | 1 << i);
        let sets: Vec<u64> = (0..n_sets).map(|_| draw(&mut random)).collect();
        let is_weighted = random.chance(50);
        // The largest is what weights are scaled to, so that integers stay as they are.
        let scale = 1 << 24;
        let mut weights: Vec<u64> = (0..n_items)
            .map(|_| if is_weighted { u64::try_from(random.within(0, scale)).unwrap() } else { 1 })
            .collect();
        if is_weighted {
            weights[0] = u64::try_from(scale).unwrap();
        }
        let grid = |bits: u64| {
            let mut grid = BitGrid::new(1, n_items);
            grid.words_mut()[0] = bits;
            grid
        };
        let as_floats: Vec<f64> = weights.iter().map(|w| *w as f64).collect();
        let weights_of_cells = is_weighted.then(|| Weights::new(&as_floats, n_items).unwrap());
        let mut seen = SeenSets::over(&BitGrid::full(1, n_items), weights_of_cells.as_ref());
        seen.extend(&sets.iter().map(|set| grid(*set)).collect::<Vec<_>>());
        let found = greedy_cover(&seen, k, &Control::default()).unwrap();
        let best = optimum(&sets, &weights, k, 0);
        let union = found.chosen.iter().fold(0, |union, chosen| union | sets[chosen.set]);
        assert_eq!(found.covered(), optimum(&[union], &weights, 1, 0), "what is said to be covered is");
        assert!(found.covered() <= best && best <= found.bound, "{found:?} optimum {best}");
        assert!(found.covered() as f64 >= (1.0 - (-1.0_f64).exp()) * best as f64, "{found:?} optimum {best}");
        let exact = cover(&seen, k, &Control::default()).unwrap();
        assert_eq!((exact.covered(), exact.bound), (best, best), "all choices of so few are tried");
        let union = exact.chosen.iter().fold(0, |union, chosen| union | sets[chosen.set]);
        assert_eq!(best, optimum(&[union], &weights, 1, 0));
        n_tight += usize::from(found.bound == best);
        n_short += usize::from(found.covered() < best);
    }
    // Neither is trivial: greedy falls short at times, and the bound often is the optimum.
    assert!(n_tight > 100 && n_short > 5, "{n_tight} {n_short}");
}

/// More sets than a table of all choices holds: choices are tried one after another.
#[test]
fn the_best_of_more_sets_is_that_of_a_brute_force() {
    let mut random = Random(56);
    let mut n_short = 0;
    for round in 0..60 {
        let (n_sets, k) = (random.index(23, 40), random.index(2, 4));
        let density = 4 + 3 * (round % 8);
        let draw = |random: &mut Random| (0..64).filter(|_| random.chance(density)).fold(0_u64, |s, i| s | 1 << i);
        let sets: Vec<u64> = (0..n_sets).map(|_| draw(&mut random)).collect();
        let scale = 1 << 24;
        let mut weights: Vec<u64> = (0..64).map(|_| u64::try_from(random.within(0, scale)).unwrap()).collect();
        weights[0] = u64::try_from(scale).unwrap();
        let of_cells = Weights::new(&weights.iter().map(|w| *w as f64).collect::<Vec<_>>(), 64).unwrap();
        for weights_of_cells in [None, Some(&of_cells)] {
            let mut seen = SeenSets::over(&BitGrid::full(1, 64), weights_of_cells);
            seen.extend(&sets.iter().map(|set| BitGrid::from_words(64, vec![*set])).collect::<Vec<_>>());
            let ones = vec![1; 64];
            let best = optimum(&sets, if weights_of_cells.is_some() { &weights } else { &ones }, k, 0);
            let found = cover(&seen, k, &Control::default()).unwrap();
            assert_eq!((found.covered(), found.bound), (best, best), "{n_sets} sets, {k} of them");
            n_short += usize::from(greedy_cover(&seen, k, &Control::default()).unwrap().covered() < best);
        }
    }
    assert!(n_short > 10, "greedy falls short at times: {n_short}");
}

#[test]
fn several_uavs_of_a_small_scene_are_within_the_guarantee() {
    let mut random = Random(55);
    for field in [raster_town(&mut random, 20), vector_town(&mut random, 21)] {
        let kept = candidates(&field, 7.0);
        let options = MapOptions { radius: Some(8.0), ..MapOptions::default() };
        let mapper = Mapper::new(&field, &options).unwrap();
        let seen: Vec<BitGrid> = kept.iter().map(|c| mapper.seen_from(&c.uav).unwrap().seen().los).collect();
        let mut sets = SeenSets::over(&mapper.receiver_cells(), None);
        sets.extend(&seen);
        let found = cover(&sets, 2, &Control::default()).unwrap();
        let scorer = Scorer::new(&mapper, None);
        let (of_each, all) = SeenSets::of(&scorer, &kept, &Control::default()).unwrap();
        let uavs: Vec<_> = kept.iter().map(|c| &c.uav).collect();
        assert_eq!(of_each, scores(&scorer, &uavs, &Control::default()).unwrap());
        assert_eq!(cover(&all, 2, &Control::default()).unwrap().chosen, found.chosen);
        let pairs = seen.iter().enumerate().flat_map(|(i, a)| seen[i..].iter().map(move |b| a.clone().or(b).count()));
        let best = u128::from(pairs.max().unwrap());
        assert!(found.covered() == best && best == found.bound && found.bound <= found.wanted);
        let greedy = greedy_cover(&sets, 2, &Control::default()).unwrap();
        assert!(greedy.covered() as f64 >= 0.75 * best as f64, "1 − (1 − 1/2)² of {best}: {greedy:?}");
    }
}
