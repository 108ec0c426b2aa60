//! Maps of scenes whose heights of buildings are known to within an error.

use skyshed_core::city::{Footprint, Ground};
use skyshed_core::coverage::{
    Control, HeightBounds, HeightErrors, MapOptions, Mapper, OwnErrors, Receivers, Uav, UncertainHeights,
};
use skyshed_core::height_field::{Curvature, HeightField, Station};
use skyshed_core::los::{link_height_limits, link_los};
use skyshed_core::raster::{GeoRef, Raster};

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
        Footprint { id: k.to_string(), polygons: vec![vec![ring]], top, base: Some(0) }
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
    let grid = GeoRef::new((0.0, N as f64), (1.0, 1.0), (N, N), None).unwrap();
    raster_field(Raster::new(grid, cells), Ground::Flat(0))
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
    let Ok(exactly) = mapper.sure(uav, &HeightBounds::of(field, 0.0).unwrap()) else { return (0, 0) };
    assert!(exactly.receivers == known.receivers && exactly.surely == known.los, "{what}");
    assert!(exactly.possibly == known.los, "{what}");
    assert!(HeightBounds::of(field, f64::NAN).is_none() && HeightBounds::of(field, -0.1).is_none());
    let bounds = HeightBounds::of(field, most as f64 / 1024.0).unwrap();
    let Ok(sure) = mapper.sure(uav, &bounds) else { return (0, 0) };
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
            let house = |(k, (low, high)): (usize, &([i32; 2], [i32; 2]))| Footprint {
                id: k.to_string(),
                polygons: vec![vec![vec![*low, [high[0], low[1]], *high, [low[0], high[1]]]]],
                top: of(k),
                base: Some(0),
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
        let share = |building: u32, limit: i64| {
            let of = &tops[usize::try_from(building).unwrap()];
            of.iter().filter(|top| i64::from(**top) <= limit).count() as f64 / of.len() as f64
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
            assert!(p.is_nan() || *p == f32::from(u8::from(is_los)), "seed {seed}, {at:?}: {p}, {asked:?}");
            count.add(is_los);
        }
    });
    count.assert_both(5000);
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
