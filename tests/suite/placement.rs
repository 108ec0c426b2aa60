//! Where to hover: the best candidate is that of a brute force by rays, the bound is never below an optimum found by
//! trying every choice, the least height is that of a linear search; and the command says so.

use serde_json::Value;
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
use crate::cli_map::mask_of;
use crate::compare::{check_flags_are_known, check_refusals};
use crate::invariants::{raster_town, vector_town};
use crate::program::Folder;
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
        let map = Mapper::new(field, &options).unwrap().map(&candidate.uav, &Control::default()).unwrap();
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
                let reaches = |k: &usize| scorer.score(&kept[*k].uav).share().unwrap() >= share;
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
                let map = mapper.map(&c.uav, &Control::default()).unwrap();
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
        let seen: Vec<BitGrid> = kept.iter().map(|c| mapper.seen(&c.uav).los).collect();
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

// ---------------------------------------------------------------------------------------------------------------------
// On the command line.

/// A block of 20 m over x 20…30, y 20…30 among 50 × 50 cells, and a lower one.
const CITY: &str = r#"{"type": "FeatureCollection", "features": [
  {"type": "Feature", "properties": {"height": 20},
   "geometry": {"type": "Polygon", "coordinates": [[[20,20],[30,20],[30,30],[20,30],[20,20]]]}},
  {"type": "Feature", "properties": {"height": 5},
   "geometry": {"type": "Polygon", "coordinates": [[[5,5],[15,5],[15,12],[5,12],[5,5]]]}}]}"#;
const PLACE: &str = "place city.geojson --extent 0,0,50,50 --step 10";

fn polygon(ring: &str) -> String {
    format!(r#"{{"type": "Polygon", "coordinates": [[{ring}]]}}"#)
}

fn city() -> Folder {
    let folder = Folder::new();
    folder.write("city.geojson", CITY);
    folder.write("west.geojson", &polygon("[0,0],[20,0],[20,50],[0,50],[0,0]"));
    folder.write("far.geojson", &polygon("[900,900],[920,900],[920,950],[900,900]"));
    folder.write("own.csv", "x,y,h\n2,2,30\n25,25,5\n40,40,10\n");
    folder.write("people.asc", "ncols 2\nnrows 1\nxllcorner 0\nyllcorner 0\ncellsize 25\nNODATA_value -9999\n0 3\n");
    folder.write("debt.asc", "ncols 2\nnrows 1\nxllcorner 0\nyllcorner 0\ncellsize 25\n-1 3\n");
    folder
}

fn document(folder: &Folder, line: &str) -> Value {
    let mut document = folder.type_in(&format!("{PLACE} {line} --json -q")).done().json();
    let object = document.as_object_mut().unwrap();
    object.remove("timing_s");
    object.remove("command");
    document
}

#[test]
fn candidates_left_out_are_counted_by_hand() {
    let folder = city();
    // Places are at 5, 15, … 45 along both axes. (25, 25) is in the middle of the block of 20 m; (5, 5) is on the corner of
    // the low one, over its roof as what is north-east of it, but not inside: touching is not blocked.
    for (line, key, skipped, tried) in [
        ("--height 10", "inside", 1, 24),
        ("--height 3,30", "inside", 1, 49),
        ("--height 22 --clearance 5", "clearance", 1, 24),
        ("--height 30 --clearance 10", "clearance", 0, 25),
        ("--height 30 --keep-out west.geojson", "keep_out", 10, 15),
        ("--height 30 --within west.geojson", "outside", 15, 10),
        ("--height 30 --over rooftop", "other_zone", 23, 2),
        ("--height 5roof", "no_base", 23, 2),
    ] {
        let found = document(&folder, line);
        let candidates = &found["candidates"];
        assert_eq!(
            (&candidates["skipped"][key], &candidates["tried"]),
            (&skipped.into(), &tried.into()),
            "{line}: {candidates}"
        );
    }
}

#[test]
fn the_winner_is_what_a_map_from_there_counts() {
    let folder = city();
    for (line, map) in [
        ("--height 10,15", ""),
        ("--height 10,15 --radius 20", "--radius 20"),
        ("--height 15 --goal p_los(street)", "--receivers street"),
        ("--height 15 --goal p_los(rooftop)", "--receivers roof"),
    ] {
        let found = document(&folder, line);
        for place in [&found["winner"], &found["refined"]] {
            let at = ["x", "y", "height_agl_m"].map(|key| place[key].to_string()).join(",");
            let line = format!("map city.geojson --extent 0,0,50,50 --uav {at} {map} --json -q");
            let site = folder.type_in(&line).done().json()["sites"][0].clone();
            assert_eq!(site["los"], place["los"], "{line}");
            // Within a radius, too, the share is of all receivers, which the map without one counts.
            let all = folder.type_in(&line.replace("--radius 20", "")).done().json()["sites"][0].clone();
            assert_eq!(all["receivers"], place["receivers"], "{line}");
        }
        let ranked: Vec<f64> =
            found["ranked"].as_array().unwrap().iter().map(|p| p["p_los"].as_f64().unwrap()).collect();
        assert!(ranked.len() == 10 && ranked.windows(2).all(|w| w[0] >= w[1]), "{ranked:?}");
    }
}

#[test]
fn every_output_of_a_search_holds_the_same_winner_and_threads_change_nothing() {
    let folder = city();
    let files = "-o p.csv -o p.json -o p.geojson -o p.png -o p.svg -o p.tif";
    let line = "--height 10,15 -k 3";
    let said = folder.type_in(&format!("{PLACE} {line} {files}")).done().err;
    assert!(said.contains("best of 48 candidates") && said.contains("3 UAVs see together"), "{said}");
    assert!(said.contains("of all ground receivers; no 3 of these"), "{said}");
    let found = document(&folder, line);
    let text = folder.text("p.csv");
    let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    let winner = &found["winner"];
    // The choice of three comes first, then the ranks.
    let kinds: Vec<[&str; 2]> = rows[1..5].iter().map(|row| [row[0], row[1]]).collect();
    assert_eq!(kinds, [["chosen", "1"], ["chosen", "2"], ["chosen", "3"], ["candidate", "1"]]);
    assert_eq!(rows[4][9], winner["p_los"].as_f64().unwrap().to_string());
    assert_eq!(text.lines().count(), 1 + 48 + 1 + found["several"]["chosen"].as_array().unwrap().len());
    assert_eq!(folder.json("p.json")["winner"], *winner);
    assert_eq!(folder.json("p.geojson")["features"][0]["properties"]["p_los"], winner["p_los"]);
    let svg = folder.text("p.svg");
    assert!(svg.contains("at the best height") && svg.contains("UAV 1") && svg.contains("No candidate"), "{svg}");
    let (covered, bound) = (&found["several"]["p_los"], &found["several"]["bound"]);
    assert!(covered.as_f64().unwrap() <= bound.as_f64().unwrap() && bound.as_f64().unwrap() <= 1.0);
    for line in [line, "--height 10 --goal margin", "--height 5:30:5 --goal p_los>=0.9 --minimize height"] {
        let one = document(&folder, &format!("{line} -j 1"));
        for threads in [2, 5] {
            assert_eq!(document(&folder, &format!("{line} -j {threads}")), one, "{line}");
        }
    }
}

#[test]
fn goals_without_an_answer_say_why() {
    let folder = city();
    let none = document(&folder, "--height 15 --goal p_los(courtyard)");
    assert_eq!((&none["winner"], &none["reason"]), (&Value::Null, &"no wanted receiver".into()));
    let never = document(&folder, "--height 1,2 --goal p_los>=1 --minimize height");
    assert!(never["winner"].is_null() && never["reason"].as_str().unwrap().starts_with("no candidate reaches 1"));
    let least = document(&folder, "--height 5:60:5 --goal p_los>=0.9 --minimize height");
    assert!(least["winner"]["p_los"].as_f64().unwrap() >= 0.9);
    // All the weight is in the south-east.
    let people = document(&folder, "--height 10 --goal p_los(weights) --weights people.asc");
    assert!(people["winner"]["x"].as_f64().unwrap() >= 25.0 && people["winner"]["y"].as_f64().unwrap() <= 25.0);
    let line = "place city.geojson --extent 0,0,50,50 --candidates own.csv --json -q";
    let own = folder.type_in(line).done().json();
    assert_eq!((&own["candidates"]["skipped"]["inside"], &own["candidates"]["tried"]), (&1.into(), &2.into()));
}

#[test]
fn what_makes_no_sense_of_a_search_is_refused() {
    let folder = city();
    check_refusals(
        &folder,
        PLACE,
        &[
            ("", "E101", "--height"),
            ("--height x", "E113", "`x`"),
            ("--height 9:1:1", "E113", "`9:1:1`"),
            ("--height nan", "E113", "`nan`"),
            ("--height 9 --clearance -1", "E113", "`-1`"),
            ("--height 9 --goal sight", "E101", "found `sight`"),
            ("--height 9 --goal p_los(park)", "E101", "found `(park)`"),
            ("--height 9 --goal p_los(area)", "E108", "`--area`"),
            ("--height 9 --goal p_los(weights)", "E108", "`--weights`"),
            ("--height 9 --area west.geojson", "E116", "`--area`"),
            ("--height 9 --goal p_los(street) --receivers all", "E116", "`--receivers`"),
            ("--height 9 --goal p_los>=0.5", "E101", "`p_los>=0.5`"),
            ("--height 9 --minimize height", "E101", "`p_los`"),
            ("--height 9 --goal margin -k 2", "E116", "`--count`"),
            ("--height 9 -k 0", "E101", "'--count <N>'"),
            ("--height 9 --title T", "E116", "`--title`"),
            ("--height 9 -o a.exr", "E105", "a.exr"),
            ("--height 9 -o city.geojson --overwrite", "E105", "city.geojson: it is an input"),
            ("--height 9 --map best.csv", "E105", "best.csv: `--map`"),
            ("--height 9 --csv table.txt", "E105", "table.txt: `--csv`"),
            ("--height 9 --goal p_los(courtyard) --map none.png", "E209", "none.png"),
            ("--height 9 --goal p_los(weights) --weights debt.asc", "E302", "debt.asc"),
            ("--height 9 --within own.csv", "E302", "own.csv"),
            ("--height 9 --within far.geojson", "E208", "far.geojson"),
            ("--height 9 --keep-out far.geojson", "E208", "far.geojson"),
            ("--height 9 --goal p_los(area) --area far.geojson", "E208", "far.geojson"),
            ("--height 9 --clearance 99", "E209", "25: 1 inside a building"),
            ("--height 9 -k 2 --max-memory 20K", "E501", ""),
        ],
    );
    check_refusals(
        &folder,
        "place city.geojson",
        &[
            ("--height 9 --step 0", "E113", "`0`"),
            ("--height 9 --extent 0,0,50,50 --step 0.001", "E502", "2500000000 candidates"),
            ("--candidates own.csv -o a.png", "E109", ""),
        ],
    );
}

/// Flags that change what is found: a line without, and the flag.
const FLAGS: [(&str, &str); 26] = [
    ("--candidates own.csv", "--height 40"),
    ("--height 10", "--step 10"),
    ("--height 10", "--over street"),
    ("--height 10", "--within west.geojson"),
    ("--height 10", "--keep-out west.geojson"),
    ("--height 10", "--candidates own.csv"),
    ("--height 10,15", "--clearance 7"),
    ("--height 15", "--goal p_los(rooftop)"),
    ("--height 15 --goal p_los(area) --area west.geojson", "--rx-height 9"),
    ("--height 10", "--goal p_los(area) --area west.geojson"),
    ("--height 10", "--goal p_los(weights) --weights people.asc"),
    ("--height 10", "--weights people.asc --goal p_los(weights)"),
    ("--height 10", "--area west.geojson --goal p_los(area)"),
    ("--height 10", "--goal p_los>=0.9 --minimize height"),
    ("--height 10", "--minimize height --goal p_los>=0.9"),
    ("--height 10", "--count 2"),
    ("--height 10", "--top 3"),
    ("--height 10", "--rx-height 5"),
    ("--height 10", "--receivers roof"),
    ("--height 10", "--radius 15"),
    ("--height 10", "--missing levels"),
    ("--height 30", "--height-unit ft"),
    ("--height 10", "--height-field tall"),
    ("--height 10", "--top-field z_top"),
    ("--height 10 --top-field z_top", "--ground 3"),
    ("--height 10", "--cell 5"),
];

/// Flags that change where things are written or how they are decided, or that other tests show at work; those of the scene.
const OTHER: &str = "--width --dpi --project --skip-bad --repairs --levels-field --layer --output --csv --map --title \
    --attribution --json --overwrite --threads --quiet --max-memory --csv-text --method --hash --crs --help --version \
    --terrain --base --data-area --building-threshold --extent --size --seed --nodata-as";

#[test]
fn every_flag_changes_what_is_found() {
    let folder = city();
    folder.write(
        "tall.geojson",
        r#"{"type": "FeatureCollection", "features": [
          {"type": "Feature", "properties": {"height": 8, "tall": 12, "z_top": 9}, "geometry": {"type": "Polygon",
           "coordinates": [[[10,10],[20,10],[20,40],[10,40],[10,10]]]}},
          {"type": "Feature", "properties": {"building:levels": "3", "tall": 5, "z_top": 6}, "geometry": {"type": "Polygon",
           "coordinates": [[[38,28],[40,28],[40,30],[38,30],[38,28]]]}}]}"#,
    );
    let west = [[0, 0], [22, 0], [22, 50], [0, 50], [0, 0]];
    let west = serde_json::json!({"type": "Feature", "properties": {},
                                  "geometry": {"type": "Polygon", "coordinates": [west]}});
    folder.write("west.geojson", &west.to_string());
    let found = |line: &str| {
        let line = format!("place tall.geojson --extent 0,0,50,50 {line} --json -q");
        let document = folder.type_in(&line).done().json();
        ["digest", "winner", "ranked", "several"].map(|key| document[key].clone())
    };
    for (line, flag) in FLAGS {
        assert_ne!(found(line), found(&format!("{line} {flag}")), "{line} {flag}");
    }
    check_flags_are_known(&folder, "place", &[&FLAGS.map(|(_, flag)| flag)[..], &[OTHER]].concat());
}

#[test]
fn the_map_of_the_winner_and_a_table_by_name_are_written() {
    let folder = city();
    folder.type_in(&format!("{PLACE} --height 15 --csv t.csv --map best.tif --radius 20")).done();
    let found = document(&folder, "--height 15 --radius 20");
    let mask = mask_of(&folder, "best.tif");
    let count = |class: u8| mask.iter().filter(|c| **c == class).count() as u64;
    // Those out of range are among the receivers that the share is of.
    assert!(found["winner"]["receivers"].as_u64() > Some(count(0) + count(1)));
    assert_eq!(found["winner"]["los"].as_u64(), Some(count(1)));
    assert!(folder.text("t.csv").starts_with("kind,rank,x,y,"));
    folder.type_in(&format!("{PLACE} --height 15 -k 2 --map both.svg")).done();
    let svg = folder.text("both.svg");
    assert!(
        svg.contains("What the chosen UAVs see of") && svg.contains("UAV 2") && svg.contains("Seen by at least one")
    );
}

#[test]
fn the_worst_margin_is_refined_and_is_that_of_a_map() {
    let folder = city();
    let found = document(&folder, "--height 15 --goal margin");
    let margin = |key: &str| found[key]["margin_m"].as_f64().unwrap();
    assert!(margin("refined") >= margin("winner"), "{found}");
    for key in ["winner", "refined"] {
        let at = ["x", "y", "height_agl_m"].map(|part| found[key][part].to_string()).join(",");
        let line = format!("map city.geojson --extent 0,0,50,50 --uav {at} --layers margin -o m.asc --overwrite -q");
        folder.type_in(&line).done();
        let values = folder.text("m.asc");
        let least = values.lines().skip(6).flat_map(str::split_whitespace).map(|v| v.parse::<f64>().unwrap());
        let least = least.filter(|v| *v > -9999.0).fold(f64::INFINITY, f64::min);
        assert!((least - margin(key)).abs() < 1e-3, "{key}: {least}, {found}");
    }
}
