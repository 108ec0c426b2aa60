//! Maps of scenes whose heights of buildings are known to within an error.

use skyshed_core::city::{Footprint, Ground};
use skyshed_core::coverage::{
    Control, HeightBounds, HeightErrors, MapOptions, Mapper, OwnErrors, Receivers, RedrawnHeights, Uav,
    UncertainHeights, surface_under,
};
use skyshed_core::height_field::{Curvature, HeightField, Station};
use skyshed_core::los::{link_height_limits, link_los};
use skyshed_core::raster::{GeoRef, Raster};

use crate::curvature::block_model;
use crate::invariants::{uav_at, vector_field};
use crate::referee::over_seeds;
use crate::support::{Random, raster_field, slow};

const N: usize = 36;

/// Houses, some of them wall to wall.
fn houses(random: &mut Random) -> Vec<Footprint> {
    let house = |k: i32| {
        let [x, y] = [k % 5 * 7, k / 5 * 7].map(|v| (v + 1) * 1024);
        let side = |random: &mut Random| random.choose(&[3, 4, 7]) * 1024;
        let (w, d) = (side(random), side(random));
        let ring = vec![[x, y], [x + w, y], [x + w, y + d], [x, y + d]];
        let top = i32::try_from(random.within(3, 14)).unwrap() * 1024;
        Footprint::on_zero(k.to_string(), vec![vec![ring]], top)
    };
    (0..25).map(house).collect()
}

/// What is drawn of a scene: the same with heights of buildings off by at most `most`.
fn redrawn_houses(random: &mut Random, houses: &[Footprint], most: i64) -> HeightField {
    let off = |of: &Footprint| {
        let by = if random.chance(30) { random.choose(&[-most, most]) } else { random.within(-most, most) };
        Footprint { top: of.top + i32::try_from(by).unwrap(), ..of.clone() }
    };
    vector_field(houses.iter().map(off).collect(), Ground::Flat(0), N)
}

fn raster_of(cells: Vec<i32>) -> HeightField {
    raster_over(cells, Ground::Flat(0))
}

fn raster_over(cells: Vec<i32>, ground: Ground) -> HeightField {
    let grid = GeoRef::new((0.0, N as f64), (1.0, 1.0), (N, N), None).unwrap();
    raster_field(Raster::new(grid, cells), ground)
}

fn options(random: &mut Random, uav: &Uav) -> MapOptions {
    let receivers = random.choose(&[Receivers::Ground, Receivers::Roof, Receivers::All]);
    let curvature = Curvature::of_earth_k(random.choose(&[1e-4, 1.0])).filter(|_| random.chance(40));
    let radius = random.choose(&[None, Some(17.5)]).filter(|_| uav.station.z > 0);
    MapOptions { receivers, curvature, radius, ..MapOptions::default() }
}

fn seen(field: &HeightField, uav: &Uav, options: &MapOptions) -> skyshed_core::coverage::Seen {
    Mapper::new(field, options).unwrap().seen(uav)
}

/// Holds redrawn scenes against what is sure of one. Counts the receivers that are surely seen, and those that never are.
fn check(
    (field, uav, options): (&HeightField, &Uav, &MapOptions),
    most: i64,
    mut redrawn: impl FnMut() -> HeightField,
    what: &str,
) -> (u64, u64) {
    let mapper = Mapper::new(field, options).unwrap();
    let known = mapper.seen(uav);
    // Inside a building nothing hovers.
    if i64::from(surface_under(field, &uav.station.place)) > uav.station.z {
        return (0, 0);
    }
    let exactly = mapper.sure(uav, &HeightBounds::of(field, 0.0).unwrap()).unwrap();
    assert!(exactly.receivers == known.receivers && exactly.surely == known.los, "{what}");
    assert!(exactly.possibly == known.los, "{what}");
    assert!(HeightBounds::of(field, f64::NAN).is_none() && HeightBounds::of(field, -0.1).is_none());
    let bounds = HeightBounds::of(field, most as f64 / 1024.0).unwrap();
    let sure = mapper.sure(uav, &bounds).unwrap();
    assert!(sure.receivers == known.receivers && sure.surely.clone().and(&known.los) == sure.surely, "{what}");
    for _ in 0..if slow() { 40 } else { 6 } {
        let found = seen(&redrawn(), uav, options);
        // All that are sure are seen, and none but those that may be.
        for (row, col) in sure.surely.cells() {
            assert!(found.los.contains(row, col), "({row}, {col}), {what}");
        }
        assert_eq!(found.los.count_in(&sure.possibly), found.los.count(), "{what}");
    }
    (sure.surely.count(), sure.receivers.count() - sure.possibly.count())
}

#[test]
fn no_heights_within_their_bounds_leave_what_is_sure() {
    let count = over_seeds(if slow() { 600 } else { 60 }, 351, |seed, random, count| {
        let most = random.choose(&[1, 300, 1024, 3000]);
        let z = random.choose(&[9, 16, 40]) * 1024 + 700;
        let [x, y] = [(); 2].map(|()| random.below(N) as f64 + 0.5);
        let houses = houses(random);
        let field = vector_field(houses.clone(), Ground::Flat(0), N);
        let uav = uav_at(&field, x, y, z);
        let asked = options(random, &uav);
        let what = format!("seed {seed}, ±{most}, UAV ({x}, {y}, {z}), {asked:?}");
        let mut draws = Random(seed ^ 0x5eed);
        let a = check((&field, &uav, &asked), most, || redrawn_houses(&mut draws, &houses, most), &what);
        let tops: Vec<i32> = (0..N * N)
            .map(|_| if random.chance(25) { i32::try_from(random.within(4000, 14_000)).unwrap() } else { 0 })
            .collect();
        let field = raster_of(tops.clone());
        let mut off = |z: &i32| if *z == 0 { 0 } else { *z + i32::try_from(draws.within(-most, most)).unwrap() };
        let what = format!("a raster, {what}");
        let b = check((&field, &uav, &asked), most, || raster_of(tops.iter().map(&mut off).collect()), &what);
        // A surface model alone, on which receivers move with their cells.
        let field = raster_over(tops.clone(), Ground::Surface);
        let asked = MapOptions { receivers: Receivers::Ground, ..asked.clone() };
        let mut off = |z: &i32| *z + i32::try_from(draws.within(-most, most)).unwrap();
        let redrawn = || raster_over(tops.iter().map(&mut off).collect(), Ground::Surface);
        check((&field, &uav, &asked), most, redrawn, &format!("a surface, {what}"));
        // Of those that are sure, how many are seen.
        count.los += a.0 + b.0;
        count.links += a.0 + b.0 + a.1 + b.1;
    });
    assert!(count.los > 5000 && count.links - count.los > 5000, "{count:?}");
}

/// The probability of line of sight is the share of all combinations of heights in which a ray is clear, also where it runs along the wall
/// between two houses.
#[test]
fn the_probability_of_a_link_is_that_of_all_combinations_of_heights() {
    let count = over_seeds(if slow() { 300 } else { 24 }, 352, |seed, random, count| {
        // Houses wall to wall, walls in the middle of cells, where rays from the middle of cells run along them.
        let n = random.index(2, 6);
        let mut west = 3 * 1024 + 512;
        let blocks: Vec<([i32; 2], [i32; 2])> = (0..n)
            .map(|_| {
                let east = west + random.choose(&[1, 2, 3]) * 1024;
                let south = random.choose(&[2, 3, 3]) * 1024 + 512;
                let corners = ([west, south], [east, south + random.choose(&[3, 5]) * 1024]);
                west = if random.chance(70) { east } else { east + 1024 };
                corners
            })
            .collect();
        // Powers of two, so that shares are exact.
        let tops: Vec<Vec<i32>> = (0..n)
            .map(|_| {
                (0..random.choose(&[1, 2, 2, 4])).map(|_| i32::try_from(random.within(1, 9)).unwrap() * 1024).collect()
            })
            .collect();
        let with = |of: &dyn Fn(usize) -> i32| {
            let house = |(k, (low, high)): (usize, &([i32; 2], [i32; 2]))| {
                Footprint::on_zero(
                    k.to_string(),
                    vec![vec![vec![*low, [high[0], low[1]], *high, [low[0], high[1]]]]],
                    of(k),
                )
            };
            vector_field(blocks.iter().enumerate().map(house).collect(), Ground::Flat(0), 16)
        };
        let field = with(&|k| tops[k][0]);
        let y = random.below(16) as f64 + random.choose(&[0.5, 0.25]);
        // In line with a wall, or anywhere.
        let walls: Vec<i32> = blocks.iter().map(|(low, _)| low[0]).collect();
        let x =
            if random.chance(60) { f64::from(random.choose(&walls)) / 1024.0 } else { random.below(16) as f64 + 0.5 };
        let uav = uav_at(&field, x, y, random.choose(&[10, 13, 20]) * 1024);
        let n_fields: usize = tops.iter().map(Vec::len).product();
        let drawn: Vec<HeightField> = (0..n_fields)
            .map(|all| {
                let top = |k: usize| {
                    let before: usize = tops[..k].iter().map(Vec::len).product();
                    tops[k][all / before % tops[k].len()]
                };
                with(&top)
            })
            .collect();
        let share = |building: u32, room: i64| {
            let of = &tops[usize::try_from(building).unwrap()];
            of.iter().filter(|top| i64::from(*top - of[0]) <= room).count() as f64 / of.len() as f64
        };
        let positions = field.positions();
        for (row, col) in field.cells().open.cells() {
            let receiver = Station { place: positions.center(row, col), z: random.choose(&[0, 1536, 3000]) };
            let limits = link_height_limits(&field, &uav.station, &receiver, 8 * 1024).expect("flat ground");
            let clear = drawn.iter().filter(|field| link_los(field, &uav.station, &receiver)).count();
            let what = || format!("seed {seed}: {blocks:?} {tops:?}, UAV {:?}, {receiver:?}: {limits:?}", uav.station);
            let wanted = clear as f64 / n_fields as f64;
            assert_eq!(limits.probability(&share).to_bits(), wanted.to_bits(), "{}", what());
            count.links += u64::from(clear > 0 && clear < n_fields);
            count.ties += u64::from(!limits.walls.is_empty());
        }
    });
    assert!(count.links > 300 && count.ties > 30, "{count:?}");
}

fn p_los(field: &HeightField, uav: &Uav, options: &MapOptions, errors: &HeightErrors) -> Vec<f32> {
    let heights = UncertainHeights::of(field, errors).unwrap();
    Mapper::new(field, options).unwrap().p_los(uav, &heights, &Control::default()).unwrap()
}

#[test]
fn without_errors_probabilities_are_the_mask() {
    let count = over_seeds(if slow() { 600 } else { 60 }, 353, |seed, random, count| {
        let field = vector_field(houses(random), Ground::Flat(0), N);
        let [x, y] = [(); 2].map(|()| random.below(N) as f64 + 0.5);
        let uav = uav_at(&field, x, y, random.choose(&[15, 20, 40]) * 1024);
        let asked = options(random, &uav);
        let known = seen(&field, &uav, &asked);
        let found = p_los(&field, &uav, &asked, &HeightErrors::same(0.0, 0.0));
        for (cell, p) in found.iter().enumerate() {
            let at = (cell / N, cell % N);
            let is_los = known.los.contains(at.0, at.1);
            assert_eq!(p.is_nan(), !known.receivers.contains(at.0, at.1), "seed {seed}, {at:?}");
            assert!(
                p.is_nan() || p.to_bits() == f32::from(u8::from(is_los)).to_bits(),
                "seed {seed}, {at:?}: {p}, {asked:?}"
            );
            count.add(is_los);
        }
    });
    count.assert_both(5000);
}

/// What shadows tell of receivers on the ground lies between what walks tell, whose rooms are whole steps.
#[test]
fn probabilities_by_shadows_are_those_of_walks() {
    let count = over_seeds(if slow() { 1500 } else { 120 }, 356, |seed, random, count| {
        let mut houses = houses(random);
        // Houses of two wings, so that the lesser of two rooms counts, and of many corners.
        for house in houses.iter_mut().filter(|_| random.chance(30)) {
            let [x, y] = house.polygons[0][0][0];
            let wing = |dx: i32, dy: i32| [x + dx * 1024, y + dy * 1024];
            house.polygons = vec![vec![vec![wing(0, 0), wing(4, 0), wing(4, 2), wing(2, 2), wing(2, 5), wing(0, 5)]]];
        }
        let field = vector_field(houses.clone(), Ground::Flat(0), N);
        let at = |random: &mut Random| random.below(N) as f64 + random.choose(&[0.5, 0.3]);
        let uav = uav_at(&field, at(random), at(random), random.choose(&[16, 20, 40, 90]) * 1024);
        let own: Vec<f64> = houses.iter().map(|_| random.choose(&[0.0, 0.2, 1.0, 2.5])).collect();
        // A shared error beside one of their own, or houses some of which have none.
        let shared_m = random.choose(&[0.0, 0.0, 0.3, 1.5]);
        let own: Vec<f64> = own.into_iter().map(|m| if shared_m > 0.0 { m.max(0.5) } else { m }).collect();
        let errors = HeightErrors { own: OwnErrors::ByBuilding(own.clone().into()), shared_m };
        let asked = MapOptions { receivers: Receivers::Ground, ..MapOptions::default() };
        let found = p_los(&field, &uav, &asked, &errors);
        let below = |building: u32, room: f64| {
            let own_m = own[usize::try_from(building).unwrap()];
            let deviations = if own_m > 0.0 { room / 1024.0 / own_m } else { 1e9 * (room + 0.5) };
            0.5 * libm::erfc(-deviations * std::f64::consts::FRAC_1_SQRT_2)
        };
        let positions = field.positions();
        for (row, col) in field.cells().open.cells() {
            let receiver = Station { place: positions.center(row, col), z: i64::from(asked.rx_height) };
            let limits = link_height_limits(&field, &uav.station, &receiver, 16 * 1024).unwrap();
            let p = f64::from(found[row * N + col]);
            // Over the shared error in fine steps.
            let values: Vec<f64> =
                if shared_m > 0.0 { (-140..=140).map(|k| f64::from(k) / 20.0).collect() } else { vec![0.0] };
            let weights: Vec<f64> = values.iter().map(|t| (-0.5 * t * t).exp()).collect();
            let all: f64 = weights.iter().sum();
            let [low, high] = [0.0, 1.0].map(|step| {
                let given = |t: f64| {
                    let t = t * shared_m * 1024.0;
                    limits.probability(&|of, room| below(of, room as f64 + step - t))
                };
                values.iter().zip(&weights).map(|(t, weight)| weight * given(*t)).sum::<f64>() / all
            });
            let is_within = p >= low - 1e-5 && p <= high + 1e-5;
            assert!(is_within, "seed {seed}, ({row}, {col}): {p} is not in {low}..{high}, {limits:?}");
            count.links += 1;
            count.ties += u64::from(p > 0.01 && p < 0.99);
        }
    });
    assert!(count.ties > 5000, "{count:?}");
}

/// A number that is normally distributed.
fn normal(random: &mut Random) -> f64 {
    // By Box and Muller, of two uniform ones.
    let uniform = |random: &mut Random| (random.below(1 << 30) as f64 + 0.5) / f64::from(1 << 30);
    let (a, b) = (uniform(random), uniform(random));
    (-2.0 * a.ln()).sqrt() * (std::f64::consts::TAU * b).cos()
}

/// Redrawn towns agree with the probabilities of their receivers, for errors of each building, of all, and both.
#[test]
fn probabilities_are_the_shares_of_redrawn_towns() {
    let n_draws = if slow() { 10_000 } else { 2000 };
    let count = over_seeds(if slow() { 96 } else { 24 }, 354, |seed, random, count| {
        // So high that no error takes a house away.
        let higher = |of: Footprint| Footprint { top: of.top + 8 * 1024, ..of };
        let houses: Vec<Footprint> = houses(random).into_iter().map(higher).collect();
        let field = vector_field(houses.clone(), Ground::Flat(0), N);
        let [x, y] = [(); 2].map(|()| random.below(N) as f64 + 0.5);
        let uav = uav_at(&field, x, y, random.choose(&[30, 38, 48]) * 1024);
        let asked = options(random, &uav);
        let own: Vec<f64> = (0..houses.len()).map(|_| random.choose(&[0.2, 1.0, 1.5])).collect();
        let by_building = HeightErrors { own: OwnErrors::ByBuilding(own.into()), shared_m: 0.6 };
        let errors = match seed % 4 {
            0 => HeightErrors::same(1.0, 0.0),
            1 => HeightErrors::same(0.0, 1.2),
            2 => HeightErrors::same(0.7, 0.9),
            _ => by_building,
        };
        let found = p_los(&field, &uav, &asked, &errors);
        let mut seen_in = vec![0_u32; N * N];
        for _ in 0..n_draws {
            let shared = normal(random) * errors.shared_m;
            let redrawn = |(of, k): (&Footprint, u32)| {
                let error = (shared + normal(random) * errors.own_m(k)) * 1024.0;
                #[expect(clippy::cast_possible_truncation, reason = "some meters")]
                Footprint { top: of.top + error.round() as i32, ..of.clone() }
            };
            let drawn = houses.iter().zip(0..).map(redrawn).collect();
            let los = seen(&vector_field(drawn, Ground::Flat(0), N), &uav, &asked).los;
            los.cells().for_each(|(row, col)| seen_in[row * N + col] += 1);
        }
        for (cell, (p, n)) in found.iter().zip(&seen_in).enumerate().filter(|(_, (p, _))| !p.is_nan()) {
            let (p, share) = (f64::from(*p), f64::from(*n) / f64::from(n_draws));
            let standard_error = (p * (1.0 - p) / f64::from(n_draws)).sqrt();
            let off = (share - p).abs();
            let what = || format!("seed {seed}, cell {cell}: {p} {share}, {errors:?}, {asked:?}, {:?}", uav.station);
            // Where hardly any draw differs shares are no bell curve.
            assert!(off <= 5.5 * standard_error + 3.0 / f64::from(n_draws), "{}", what());
            count.ties += u64::from(off > 4.0 * standard_error + 2.0 / f64::from(n_draws));
            count.links += u64::from(p > 0.001 && p < 0.999);
        }
    });
    let (n_between, n_beyond) = (count.links, count.ties);
    // One in 16 000 is farther off than four standard errors by chance; neighbors are off together.
    assert!(n_between > 1000 && n_beyond * 1000 <= n_between, "{n_beyond} of {n_between}");
}

/// What a redrawn scene counts is what the scene built anew counts, receivers on roofs as well.
#[test]
fn redrawn_maps_are_those_of_towns_built_anew() {
    let count = over_seeds(if slow() { 400 } else { 60 }, 355, |seed, random, count| {
        let houses = houses(random);
        let field = vector_field(houses.clone(), Ground::Flat(0), N);
        let [x, y] = [(); 2].map(|()| random.below(N) as f64 + 0.5);
        let uavs = [(); 2].map(|()| uav_at(&field, x, y, random.choose(&[20, 30, 48]) * 1024));
        let asked = options(random, &uavs[0]);
        let errors = HeightErrors::same(random.choose(&[0.0, 0.3]), random.choose(&[0.0, 0.4]));
        let heights = RedrawnHeights::of(&field, &errors, None, seed).unwrap();
        let mapper = Mapper::new(&field, &asked).unwrap();
        let found = mapper.redrawn(&uavs, &heights, 4, &Control::default()).unwrap();
        for draw in 0..4_u32 {
            let errors = heights.errors(draw);
            let redrawn = |(of, error): (&Footprint, &i32)| Footprint { top: of.top + error, ..of.clone() };
            let drawn = vector_field(houses.iter().zip(&errors).map(redrawn).collect(), Ground::Flat(0), N);
            for (k, uav) in uavs.iter().enumerate() {
                let wanted = seen(&drawn, uav, &asked);
                let counted = (found.receivers[k], found.los[draw as usize][k]);
                assert_eq!(counted, (wanted.receivers.count(), wanted.los.count()), "seed {seed}, {errors:?}");
                count.los += wanted.los.count();
                count.links += wanted.receivers.count();
            }
        }
    });
    count.assert_both(10_000);
}

/// Of towns drawn from the errors, P_LoS of as many as the interval says is within it; and their mean is that of the probabilities.
#[test]
fn intervals_cover_what_they_say() {
    let n_trials = if slow() { 1000 } else { 200 };
    let (mut covered, mut n) = (0_u32, 0_u32);
    for (of, errors) in [HeightErrors::same(1.0, 0.0), HeightErrors::same(0.5, 0.8)].iter().enumerate() {
        let mut random = Random(356 + of as u64);
        let higher = |of: Footprint| Footprint { top: of.top + 8 * 1024, ..of };
        let field = vector_field(houses(&mut random).into_iter().map(higher).collect(), Ground::Flat(0), N);
        let uav = uav_at(&field, 17.5, 19.5, 60 * 1024);
        let mapper = Mapper::new(&field, &MapOptions::default()).unwrap();
        let redrawn = |seed: u64, n: u32| {
            let heights = RedrawnHeights::of(&field, errors, None, seed).unwrap();
            mapper.redrawn(std::slice::from_ref(&uav), &heights, n, &Control::default()).unwrap()
        };
        let mut sum = 0.0;
        for trial in 0..n_trials {
            let interval = redrawn(1000 + trial, 200).interval(0, 0.95);
            let truth = redrawn(9_000_000 + trial, 1);
            let p = truth.los[0][0] as f64 / truth.receivers[0] as f64;
            sum += p;
            covered += u32::from(interval.0 <= p && p <= interval.1);
            n += 1;
        }
        let p_los: Vec<f32> = p_los(&field, &uav, &MapOptions::default(), errors);
        let known = p_los.iter().filter(|p| !p.is_nan());
        let (total, n_receivers) = known.fold((0.0, 0_u32), |(sum, n), p| (sum + f64::from(*p), n + 1));
        let all = redrawn(5, 4000);
        let shares = all.los.iter().map(|of| of[0] as f64 / all.receivers[0] as f64);
        let (mean, squares) = shares.fold((0.0, 0.0), |(m, s), p| (m + p / 4000.0, s + p * p / 4000.0));
        let standard_error = ((squares - mean * mean) / 4000.0).sqrt();
        let expected = total / f64::from(n_receivers);
        assert!((mean - expected).abs() < 4.0 * standard_error, "{mean} {expected} {standard_error}");
        assert!(standard_error > 1e-5 && sum > 0.0);
    }
    let share = f64::from(covered) / f64::from(n);
    assert!(if slow() { (0.93..=0.97).contains(&share) } else { (0.91..=0.98).contains(&share) }, "{covered} of {n}");
}

#[test]
fn redrawn_rasters_are_those_built_anew_with_errors_of_one_size_everywhere() {
    let mut random = Random(357);
    let tops: Vec<i32> = (0..N * N)
        .map(|_| if random.chance(30) { i32::try_from(random.within(20_000, 30_000)).unwrap() } else { 0 })
        .collect();
    let field = raster_of(tops.clone());
    let uav = uav_at(&field, 12.5, 20.5, 60 * 1024);
    let n_draws = 2000_u32;
    for receivers in [Receivers::Ground, Receivers::All] {
        let asked = MapOptions { receivers, ..MapOptions::default() };
        let mapper = Mapper::new(&field, &asked).unwrap();
        let heights = RedrawnHeights::of(&field, &HeightErrors::same(1.5, 0.5), Some(5.0), 7).unwrap();
        let found = mapper.redrawn(std::slice::from_ref(&uav), &heights, 5, &Control::default()).unwrap();
        for draw in 0..5_u32 {
            let errors = heights.errors(draw);
            let drawn = raster_of(tops.iter().zip(&errors).map(|(top, error)| top + error).collect());
            let wanted = seen(&drawn, &uav, &asked);
            let counted = (found.receivers[0], found.los[draw as usize][0]);
            assert_eq!(counted, (wanted.receivers.count(), wanted.los.count()), "{receivers:?}, draw {draw}");
        }
    }
    // Of each cell, and of pairs of them some cells apart.
    let heights = RedrawnHeights::of(&field, &HeightErrors::same(2.0, 0.0), Some(5.0), 8).unwrap();
    let buildings: Vec<usize> = (0..N * N).filter(|cell| tops[*cell] > 0).collect();
    let mut squares = vec![0.0; N * N];
    let mut products = [(0.0, 0_u32); 2];
    for draw in 0..n_draws {
        let errors = heights.errors(draw);
        assert!((0..N * N).all(|cell| tops[cell] > 0 || errors[cell] == 0));
        let m = |cell: usize| f64::from(errors[cell]) / 1024.0;
        buildings.iter().for_each(|cell| squares[*cell] += m(*cell).powi(2) / f64::from(n_draws));
        for pair in buildings.windows(2) {
            let [a, b] = [pair[0], pair[1]].map(|cell| (cell / N, cell % N));
            if a.0 == b.0 && b.1 - a.1 == 1 {
                products[0] = (products[0].0 + m(pair[0]) * m(pair[1]), products[0].1 + 1);
            }
        }
        let (first, last) = (buildings[0], buildings[buildings.len() - 1]);
        products[1] = (products[1].0 + m(first) * m(last), products[1].1 + 1);
    }
    for cell in &buildings {
        // The standard error of a variance of 4 over so many draws is 0.13.
        assert!((squares[*cell] - 4.0).abs() < 0.65, "{cell}: {}", squares[*cell]);
    }
    let correlation = |k: usize| products[k].0 / f64::from(products[k].1) / 4.0;
    assert!(correlation(0) > 0.85 && correlation(1).abs() < 0.12, "{} {}", correlation(0), correlation(1));
}

#[test]
fn blocks_of_one_height_share_an_error() {
    let field = block_model(&mut Random(358));
    let heights = RedrawnHeights::of(&field, &HeightErrors::same(3.0, 0.0), None, 9).unwrap();
    let errors = heights.errors(3);
    let (tops, n_cols) = (field.columns().unwrap().tops().to_vec(), field.grid().n_cols());
    let is_building = |cell: usize| field.cells().building.contains(cell / n_cols, cell % n_cols);
    let mut shared = 0;
    let mut seen = std::collections::HashSet::new();
    for cell in 0..tops.len() {
        if !is_building(cell) {
            assert_eq!(errors[cell], 0);
            continue;
        }
        seen.insert(errors[cell]);
        for near in [cell.wrapping_sub(1), cell.wrapping_sub(n_cols)] {
            if near < tops.len() && is_building(near) && tops[near] == tops[cell] && cell % n_cols > 0 {
                assert_eq!(errors[near], errors[cell]);
                shared += 1;
            }
        }
    }
    assert!(shared > 10_000 && seen.len() > 50, "{shared} {}", seen.len());
}

/// The buildings that turn the answer of a receiver, tried one by one.
#[test]
fn buildings_that_decide_are_those_whose_heights_turn_answers() {
    let count = over_seeds(if slow() { 600 } else { 60 }, 359, |seed, random, count| {
        let higher = |of: Footprint| Footprint { top: of.top + 3 * 1024, ..of };
        let houses: Vec<Footprint> = houses(random).into_iter().map(higher).collect();
        let field = vector_field(houses.clone(), Ground::Flat(0), N);
        let [x, y] = [(); 2].map(|()| random.below(N) as f64 + 0.5);
        let uav = uav_at(&field, x, y, random.choose(&[22, 26, 40]) * 1024);
        let asked = options(random, &uav);
        let most = random.choose(&[300, 1024, 2500]);
        let found = Mapper::new(&field, &asked).unwrap().deciding(&uav, f64::from(most) / 1024.0, &Control::default());
        let found = found.unwrap();
        let known = seen(&field, &uav, &asked);
        assert_eq!(found.receivers, known.receivers.count());
        for (k, by_building) in found.by_building.iter().enumerate() {
            let mut turned = std::collections::HashSet::new();
            for by in [-most, most] {
                let mut moved = houses.clone();
                moved[k].top += by;
                let los = seen(&vector_field(moved, Ground::Flat(0), N), &uav, &asked).los;
                let (gained, lost) = (los.cells(), known.los.cells());
                turned.extend(gained.filter(|(row, col)| !known.los.contains(*row, *col)));
                turned.extend(lost.filter(|(row, col)| !los.contains(*row, *col)));
            }
            assert_eq!(*by_building, turned.len() as u64, "seed {seed}, building {k}, ±{most}, {asked:?}");
            count.los += *by_building;
        }
        count.links += found.possibly;
        assert!(found.by_building.iter().max() <= Some(&found.possibly));
    });
    assert!(count.los > 2000 && count.links > 2000, "{count:?}");
}

#[test]
fn parts_of_a_raster_have_the_errors_of_the_whole() {
    let mut random = Random(360);
    let (n_rows, n_cols) = (60, 80);
    for is_block_model in [true, false] {
        // Blocks of 6 × 6 cells, of which a part cuts none.
        let tops: Vec<i32> = (0..n_rows * n_cols)
            .map(|cell| {
                let (row, col) = (cell / n_cols, cell % n_cols);
                let is_house = row % 10 < 6 && col % 10 < 6;
                let top = if is_block_model { 9000 + 1024 * (row / 10 + col / 10) } else { random.index(9000, 30_000) };
                if is_house { i32::try_from(top).unwrap() } else { 0 }
            })
            .collect();
        let grid = GeoRef::new((0.0, n_rows as f64), (1.0, 1.0), (n_rows, n_cols), None).unwrap();
        let window = skyshed_core::raster::CellWindow { row: 20, col: 30, n_rows: 26, n_cols: 36 };
        let part: Vec<i32> = (0..window.n_rows)
            .flat_map(|row| &tops[(window.row + row) * n_cols + window.col..][..window.n_cols])
            .copied()
            .collect();
        let whole = raster_field(Raster::new(grid.clone(), tops), Ground::Flat(0));
        let part = raster_field(Raster::new(grid.part(window), part), Ground::Flat(0));
        let errors = HeightErrors::same(2.0, 0.5);
        let [of_whole, of_part] = [&whole, &part].map(|f| RedrawnHeights::of(f, &errors, None, 3).unwrap().errors(7));
        let mut seen = std::collections::HashSet::new();
        for (cell, error) in of_part.iter().enumerate() {
            let (row, col) = (window.row + cell / window.n_cols, window.col + cell % window.n_cols);
            assert_eq!(*error, of_whole[row * n_cols + col], "{row} {col}, block model: {is_block_model}");
            seen.insert(*error);
        }
        assert!(if is_block_model { (8..=17).contains(&seen.len()) } else { seen.len() > 100 }, "{}", seen.len());
    }
}
