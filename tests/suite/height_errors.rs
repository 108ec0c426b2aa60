//! Maps of scenes whose heights of buildings are known to within an error.

use skyshed_core::city::{Footprint, Ground};
use skyshed_core::coverage::{HeightBounds, MapOptions, Mapper, Receivers, Uav};
use skyshed_core::height_field::{Curvature, HeightField};
use skyshed_core::raster::{GeoRef, Raster};

use crate::invariants::{uav_at, vector_field};
use crate::referee::over_seeds;
use crate::support::{Random, raster_field, slow};

const N: usize = 36;

/// Houses, some of them wall to wall.
fn houses(random: &mut Random) -> Vec<Footprint> {
    let house = |k: i32| {
        let [x, y] = [k % 5 * 7, k / 5 * 7].map(|v| (v + 1) * 1024);
        let side = |random: &mut Random| i32::try_from(random.choose(&[3, 4, 7])).unwrap() * 1024;
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
        let (x, y) = (random.within(0, N as i64 - 1) as f64 + 0.5, random.within(0, N as i64 - 1) as f64 + 0.5);
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
