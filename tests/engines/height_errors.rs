//! Maps of scenes whose heights of buildings are known to within an error.

use skyshed_core::city::{Footprint, Ground};
use skyshed_core::coverage::{
    Control, HeightBounds, HeightErrors, MapOptions, Mapper, OwnErrors, Receivers, Uav, UncertainHeights, surface_under,
};
use skyshed_core::height_field::{Curvature, HeightField, Station};
use skyshed_core::los::{PlanCrossings, link_los};
use skyshed_core::raster::{GeoRef, Raster};

use crate::invariants::{uav_at, vector_field};
use crate::referee::over_seeds;
use crate::support::{Random, is_long, raster_field};

pub(crate) const N: usize = 36;

/// Houses, some of them wall to wall.
pub(crate) fn houses(random: &mut Random) -> Vec<Footprint> {
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

pub(crate) fn raster_of(cells: Vec<i32>) -> HeightField {
    raster_over(cells, Ground::Flat(0))
}

fn raster_over(cells: Vec<i32>, ground: Ground) -> HeightField {
    let grid = GeoRef::new((0.0, N as f64), (1.0, 1.0), (N, N), None).unwrap();
    raster_field(Raster::new(grid, cells), ground)
}

pub(crate) fn options(random: &mut Random, uav: &Uav) -> MapOptions {
    let receivers = random.choose(&[Receivers::Ground, Receivers::Roof, Receivers::All]);
    let curvature = Curvature::of_earth_k(random.choose(&[1e-4, 1.0])).filter(|_| random.chance(40));
    let radius = random.choose(&[None, Some(17.5)]).filter(|_| uav.station.z > 0);
    MapOptions { receivers, curvature, radius, ..MapOptions::default() }
}

pub(crate) fn seen(field: &HeightField, uav: &Uav, options: &MapOptions) -> skyshed_core::coverage::Seen {
    Mapper::new(field, options).unwrap().seen_from(uav).unwrap().seen()
}

/// Holds redrawn scenes against what is sure of one. Counts the receivers that are surely seen, and those that never are.
fn check(
    (field, uav, options): (&HeightField, &Uav, &MapOptions),
    most: i64,
    mut redrawn: impl FnMut() -> HeightField,
    what: &str,
) -> (u64, u64) {
    let mapper = Mapper::new(field, options).unwrap();
    let known = mapper.seen_from(uav).unwrap().seen();
    // Inside a building nothing hovers.
    if i64::from(surface_under(field, &uav.station.place)) > uav.station.z {
        return (0, 0);
    }
    let exactly = mapper.seen_from(uav).unwrap().sure(&HeightBounds::of(field, 0.0).unwrap()).unwrap();
    assert!(exactly.receivers == known.receivers && exactly.surely == known.los, "{what}");
    assert!(exactly.possibly == known.los, "{what}");
    assert!(HeightBounds::of(field, f64::NAN).is_none() && HeightBounds::of(field, -0.1).is_none());
    let bounds = HeightBounds::of(field, most as f64 / 1024.0).unwrap();
    let sure = mapper.seen_from(uav).unwrap().sure(&bounds).unwrap();
    assert!(sure.receivers == known.receivers && sure.surely.clone().and(&known.los) == sure.surely, "{what}");
    for _ in 0..if is_long() { 40 } else { 6 } {
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
    let count = over_seeds(if is_long() { 600 } else { 60 }, 351, |seed, random, count| {
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
    let count = over_seeds(if is_long() { 300 } else { 24 }, 352, |seed, random, count| {
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
            let limits =
                PlanCrossings::new(&field, &uav.station, &receiver, 0, 8 * 1024).limits(0).expect("flat ground");
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

pub(crate) fn p_los(field: &HeightField, uav: &Uav, options: &MapOptions, errors: &HeightErrors) -> Vec<f32> {
    let heights = UncertainHeights::of(field, errors).unwrap();
    Mapper::new(field, options).unwrap().seen_from(uav).unwrap().p_los(&heights, &Control::default()).unwrap()
}

#[test]
fn without_errors_probabilities_are_the_mask() {
    let count = over_seeds(if is_long() { 600 } else { 60 }, 353, |seed, random, count| {
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
    let count = over_seeds(if is_long() { 1500 } else { 120 }, 356, |seed, random, count| {
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
            let limits = PlanCrossings::new(&field, &uav.station, &receiver, 0, 16 * 1024).limits(0).unwrap();
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
pub(crate) fn normal(random: &mut Random) -> f64 {
    // By Box and Muller, of two uniform ones.
    let uniform = |random: &mut Random| (random.below(1 << 30) as f64 + 0.5) / f64::from(1 << 30);
    let (a, b) = (uniform(random), uniform(random));
    (-2.0 * a.ln()).sqrt() * (std::f64::consts::TAU * b).cos()
}

/// Redrawn towns agree with the probabilities of their receivers, for errors of each building, of all, and both.
#[test]
fn probabilities_are_the_shares_of_redrawn_towns() {
    let n_draws = if is_long() { 10_000 } else { 2000 };
    let count = over_seeds(if is_long() { 96 } else { 24 }, 354, |seed, random, count| {
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

/// The buildings that turn the answer of a receiver, tried one by one.
#[test]
fn buildings_that_decide_are_those_whose_heights_turn_answers() {
    let count = over_seeds(if is_long() { 600 } else { 60 }, 359, |seed, random, count| {
        let higher = |of: Footprint| Footprint { top: of.top + 3 * 1024, ..of };
        let houses: Vec<Footprint> = houses(random).into_iter().map(higher).collect();
        let field = vector_field(houses.clone(), Ground::Flat(0), N);
        let [x, y] = [(); 2].map(|()| random.below(N) as f64 + 0.5);
        let uav = uav_at(&field, x, y, random.choose(&[22, 26, 40]) * 1024);
        let asked = options(random, &uav);
        let most = random.choose(&[300, 1024, 2500]);
        let found = Mapper::new(&field, &asked)
            .unwrap()
            .seen_from(&uav)
            .unwrap()
            .deciding(f64::from(most) / 1024.0, &Control::default());
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
