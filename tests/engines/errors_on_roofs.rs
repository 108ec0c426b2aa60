//! Receivers on roofs whose heights may be off: they rise and fall with their building, the UAV stays.

use skyshed_core::city::{Footprint, Ground};
use skyshed_core::coverage::{HeightBounds, HeightErrors, MapOptions, Mapper, OwnErrors, Receivers, Uav};
use skyshed_core::height_field::{Curvature, HeightField, Station};
use skyshed_core::los::{PlanCrossings, link_los};

use crate::height_errors::{normal, p_los, seen};
use crate::invariants::{uav_at, vector_field};
use crate::referee::over_seeds;
use crate::support::{Random, is_long};

const N: usize = 18;

fn house(id: usize, [west, south, east, north]: [i32; 4], top: i32) -> Footprint {
    let ring = vec![[west, south], [east, south], [east, north], [west, north]];
    Footprint::on_zero(id.to_string(), vec![vec![ring]], top)
}

/// Houses in rows, many of them wall to wall, with walls on and beside the centers of cells. Tops are some `unit` apart.
fn rows_of_houses(random: &mut Random, unit: i32) -> Vec<Footprint> {
    let mut houses = Vec::new();
    for row in 0..3 {
        let south = (row * 6 + 1) * 1024 + random.choose(&[0, 512]);
        let mut west = random.choose(&[0, 512, 1024]);
        while west < 15 * 1024 {
            let east = west + random.choose(&[2, 3, 5]) * 1024;
            let north = south + random.choose(&[2, 3, 4]) * 1024;
            let top = 10 * 1024 + i32::try_from(random.within(0, 6)).unwrap() * unit;
            houses.push(house(houses.len(), [west, south, east, north], top));
            west = if random.chance(60) { east } else { east + random.choose(&[512, 1024, 2048]) };
        }
    }
    houses
}

fn raised(houses: &[Footprint], by: impl Fn(usize) -> i32) -> HeightField {
    let raised = houses.iter().enumerate().map(|(k, of)| Footprint { top: of.top + by(k), ..of.clone() });
    vector_field(raised.collect(), Ground::Flat(0), N)
}

fn on_roofs(random: &mut Random) -> MapOptions {
    MapOptions {
        receivers: random.choose(&[Receivers::Roof, Receivers::All]),
        rx_height: random.choose(&[0, 1, 5, 512, 1536]),
        curvature: Curvature::of_earth_k(random.choose(&[1e-4, 1e-3])).filter(|_| random.chance(30)),
        ..MapOptions::default()
    }
}

fn uav_over(field: &HeightField, random: &mut Random, unit: i32) -> Uav {
    let [x, y] = [(); 2].map(|()| random.below(N) as f64 + random.choose(&[0.5, 0.25]));
    let z = 10 * 1024 + i64::from(unit) * random.within(1, 8) + random.choose(&[0, 1, 7]);
    uav_at(field, x, y, z)
}

/// All errors of the roof below a receiver are tried, with all other buildings as high and as low as they may be: a higher one never clears a link.
#[test]
fn what_is_sure_on_roofs_is_so_for_every_height() {
    let count = over_seeds(if is_long() { 2000 } else { 100 }, 361, |seed, random, count| {
        let unit = random.choose(&[4, 12, 40]);
        let houses = rows_of_houses(random, unit);
        let field = raised(&houses, |_| 0);
        let uav = uav_over(&field, random, unit);
        let asked = on_roofs(random);
        let most = i32::try_from(random.within(1, 20)).unwrap();
        let bounds = HeightBounds::of(&field, f64::from(most) / 1024.0).unwrap();
        let sure = Mapper::new(&field, &asked).unwrap().seen_from(&uav).unwrap().sure(&bounds).unwrap();
        let n_receivers = sure.receivers.count();
        let own_of: Vec<Option<usize>> = (0..N * N).map(|cell| house_at(&houses, cell)).collect();
        let (mut surely, mut possibly) = (vec![true; N * N], vec![false; N * N]);
        for own in 0..houses.len() {
            let cells: Vec<usize> = (0..N * N).filter(|cell| own_of[*cell] == Some(own)).collect();
            if cells.is_empty() {
                continue;
            }
            for by in -most..=most {
                for sign in [-1, 1] {
                    let field = raised(&houses, |k| if k == own { by } else { sign * most });
                    let los = seen(&field, &uav, &asked).los;
                    for &cell in &cells {
                        let is_los = los.contains(cell / N, cell % N);
                        let of = if sign > 0 { &mut surely[cell] } else { &mut possibly[cell] };
                        *of = if sign > 0 { *of && is_los } else { *of || is_los };
                    }
                }
            }
        }
        for (cell, _) in own_of.iter().enumerate().filter(|(_, own)| own.is_some()) {
            let at = (cell / N, cell % N);
            if !sure.receivers.contains(at.0, at.1) {
                continue;
            }
            let found = (sure.surely.contains(at.0, at.1), sure.possibly.contains(at.0, at.1));
            assert_eq!(found, (surely[cell], possibly[cell]), "seed {seed}, {at:?}, ±{most}, {asked:?}, {uav:?}");
            count.add(found.0);
            count.ties += u64::from(found == (false, true));
        }
        assert!(n_receivers > 0);
    });
    count.assert_both(1000);
    assert!(count.ties > 1000, "{count:?}");
}

/// The house on whose roof the center of a cell is, by the rule for points on an edge.
fn house_at(houses: &[Footprint], cell: usize) -> Option<usize> {
    let [x, y] = [cell % N, N - 1 - cell / N].map(|v| i32::try_from(v).unwrap() * 1024 + 512);
    houses.iter().position(|of| {
        let ring = &of.polygons[0][0];
        (ring[0][0]..ring[2][0]).contains(&x) && (ring[0][1]..ring[2][1]).contains(&y)
    })
}

/// What buildings may rise by is where rays turn, also on roofs that are off.
#[test]
fn rooms_past_a_roof_that_is_off_are_where_rays_turn() {
    let count = over_seeds(if is_long() { 400 } else { 40 }, 362, |seed, random, count| {
        let houses = rows_of_houses(random, 300);
        let field = raised(&houses, |_| 0);
        let uav = uav_over(&field, random, 300);
        for (cell, own) in (0..N * N).filter_map(|cell| Some((cell, house_at(&houses, cell)?))) {
            let place = field.positions().center(cell / N, cell % N);
            let receiver = Station { place, z: i64::from(houses[own].top) + random.choose(&[0, 300]) };
            let by = random.within(-900, 900);
            let link = PlanCrossings::new(&field, &uav.station, &receiver, 1000, 4000);
            let limits = link.limits(by).unwrap();
            for (of, room) in &limits.crossed {
                let of = *of as usize;
                let is_clear = |room: i64| {
                    // This one alone.
                    let room = i32::try_from(room).unwrap();
                    let alone = raised(&houses, |k| if k == of { room } else { -10_000 });
                    link_los(&alone, &uav.station, &Station { place, z: receiver.z + by })
                };
                if (-9000..4000).contains(room) && random.chance(10) {
                    let what = || format!("seed {seed}, cell {cell}, +{by}, building {of}: {limits:?}");
                    assert!(is_clear(*room) && !is_clear(room + 1), "{}", what());
                    count.links += 1;
                }
            }
        }
    });
    assert!(count.links > 500, "{count:?}");
}

/// One house alone, 10 m high, and a UAV beside it or above it. Along the link the roof is left at a fraction t of the way from the UAV. A
/// house that is e higher blocks it if h_U + t·(10 + e + h_rx − h_U) < 10 + e.
#[test]
fn the_probability_on_the_roof_of_one_house_is_its_closed_form() {
    let mut n_between = 0;
    for (uav_x, uav_y, above) in
        [(1.5, 9.25, 2.0), (1.5, 9.25, 0.5), (17.0, 3.0, 1.0), (8.25, 8.0, 2.0), (8.5, 8.5, 1.0)]
    {
        let (west, south, east, north) = (4.0, 4.0, 13.0, 14.0);
        let field = raised(&[house(0, [4, 4, 13, 14].map(|v| v * 1024), 10 * 1024)], |_| 0);
        #[expect(clippy::cast_possible_truncation, reason = "some meters")]
        let uav = uav_at(&field, uav_x, uav_y, ((10.0 + above) * 1024.0) as i64);
        for (rx_height_m, own_m, shared_m) in
            [(0.0, 2.0, 0.0), (0.5, 2.0, 0.0), (0.5, 0.0, 1.0), (1.5, 1.2, 1.6), (0.5, 0.3, 0.4)]
        {
            #[expect(clippy::cast_possible_truncation, reason = "some meters")]
            let rx_height = (rx_height_m * 1024.0) as i32;
            let asked = MapOptions { receivers: Receivers::Roof, rx_height, ..MapOptions::default() };
            let found = p_los(&field, &uav, &asked, &HeightErrors::same(own_m, shared_m));
            for (cell, p) in found.iter().enumerate() {
                let (x, y) = ((cell % N) as f64 + 0.5, (N - cell / N) as f64 - 0.5);
                if !(west < x && x < east && south < y && y < north) {
                    assert!(p.is_nan(), "{cell}");
                    continue;
                }
                // The last place outside of the house on the way from the UAV, 0 if it begins over it.
                let entry = |from: f64, to: f64, low: f64, high: f64| {
                    if from < low {
                        (low - from) / (to - from)
                    } else if from > high {
                        (from - high) / (from - to)
                    } else {
                        0.0
                    }
                };
                let t = entry(uav_x, x, west, east).max(entry(uav_y, y, south, north));
                let highest = (above + t * (rx_height_m - above)) / (1.0 - t);
                let wanted = 0.5 * libm::erfc(-highest / f64::hypot(own_m, shared_m) * std::f64::consts::FRAC_1_SQRT_2);
                assert!(
                    (f64::from(*p) - wanted).abs() < 1e-6,
                    "UAV ({uav_x}, {uav_y}, {above}), cell {cell}: {p}, not {wanted}"
                );
                n_between += usize::from(wanted > 0.01 && wanted < 0.99);
            }
        }
    }
    assert!(n_between > 1000, "{n_between}");
}

/// A receiver at the height of a roof sees a UAV 2 m above unless the roof is 2 m higher.
#[test]
fn a_uav_a_deviation_above_a_roof_is_seen_with_the_probability_of_one_deviation() {
    let field = raised(&[house(0, [4, 4, 13, 14].map(|v| v * 1024), 10 * 1024)], |_| 0);
    let asked = MapOptions { receivers: Receivers::Roof, rx_height: 0, ..MapOptions::default() };
    let found = p_los(&field, &uav_at(&field, 1.5, 9.5, 12 * 1024), &asked, &HeightErrors::same(2.0, 0.0));
    // By tables of the normal distribution.
    let is_right = |p: &f32| (f64::from(*p) - 0.841_344_746).abs() < 1e-6;
    assert!(found.iter().filter(|p| !p.is_nan()).all(is_right) && found.iter().any(is_right));
    let bounds = |m: f64| HeightBounds::of(&field, m).unwrap();
    let mapper = Mapper::new(&field, &asked).unwrap();
    let sure = |uav: &Uav| mapper.seen_from(uav).unwrap().sure(&bounds(4.0)).unwrap();
    let high = sure(&uav_at(&field, 8.5, 9.5, 60 * 1024));
    assert!(high.surely.count() == 90 && high.surely == high.receivers);
    let near = sure(&uav_at(&field, 8.5, 9.5, 13 * 1024));
    assert!(near.surely.count() == 0 && near.possibly.count() == 90);
}

/// Redrawn towns with a UAV as low as roofs may reach, houses wall to wall.
#[test]
fn probabilities_on_roofs_are_the_shares_of_redrawn_towns() {
    let (n_scenes, n_draws) = if is_long() { (2000, 3000) } else { (40, 600) };
    let count = over_seeds(n_scenes, 363, |seed, random, count| {
        let houses = rows_of_houses(random, 700);
        let field = raised(&houses, |_| 0);
        let uav = uav_over(&field, random, 700);
        let asked = on_roofs(random);
        let own: Vec<f64> = houses.iter().map(|_| random.choose(&[0.3, 1.0, 1.5])).collect();
        let errors = match seed % 5 {
            0 => HeightErrors::same(1.0, 0.0),
            1 => HeightErrors::same(0.0, 1.2),
            2 => HeightErrors::same(0.7, 0.9),
            3 => HeightErrors::same(0.005, 0.8),
            _ => HeightErrors { own: OwnErrors::ByBuilding(own.into()), shared_m: random.choose(&[0.0, 0.6]) },
        };
        let found = p_los(&field, &uav, &asked, &errors);
        let mut seen_in = vec![0_u32; N * N];
        for _ in 0..n_draws {
            let shared = normal(random) * errors.shared_m;
            #[expect(clippy::cast_possible_truncation, reason = "some meters")]
            let drawn: Vec<i32> = (0..houses.len())
                .map(|k| ((shared + normal(random) * errors.own_m(u32::try_from(k).unwrap())) * 1024.0).round() as i32)
                .collect();
            let los = seen(&raised(&houses, |k| drawn[k]), &uav, &asked).los;
            los.cells().for_each(|(row, col)| seen_in[row * N + col] += 1);
        }
        for (cell, (p, n)) in found.iter().zip(&seen_in).enumerate().filter(|(_, (p, _))| !p.is_nan()) {
            let (p, share) = (f64::from(*p), f64::from(*n) / f64::from(n_draws));
            let standard_error = (p * (1.0 - p) / f64::from(n_draws)).sqrt();
            let off = (share - p).abs();
            let what = || format!("seed {seed}, cell {cell}: {p} {share}, {errors:?}, {asked:?}, {:?}", uav.station);
            // Where hardly any draw differs shares are no bell curve; drawn heights are whole steps.
            assert!(off <= 5.0 * standard_error + 4.0 / f64::from(n_draws) + 3e-4, "{}", what());
            count.ties += u64::from(off > 4.0 * standard_error + 3.0 / f64::from(n_draws) + 3e-4);
            count.links += u64::from(p > 0.001 && p < 0.999);
        }
    });
    let (n_between, n_beyond) = (count.links, count.ties);
    assert!(n_between > 1000 && n_beyond * 1000 <= n_between, "{n_beyond} of {n_between}");
}
