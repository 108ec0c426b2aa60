//! `shadow` seen from the ground: which UAV positions of a lattice a receiver sees, through nested tiles of receivers, is
//! what `ray` says of every link; and the counts of many UAVs taken together are those of each alone.

#![expect(clippy::unwrap_used, clippy::cast_possible_wrap, reason = "a test stops at the first surprise")]

use rayon::prelude::*;
use skyshed::coverage::{Control, MapOptions, Mapper, Receivers, Uav};
use skyshed::height_field::HeightField;
use skyshed::los::{InView, MethodChoice, Positions, ReceiverTile, ShadowGrid, prisms_los};
use skyshed::placement::{CandidateRules, Candidates, PlaceGrid};
use skyshed::quantity::{Height, LatticePoint};
use skyshed::raster::BitGrid;

use crate::invariants::{raster_town, vector_town};
use crate::shadow::{city, levels, tiny_field, tiny_scene, tiny_uav};
use crate::shapes::moved;
use crate::support::{Random, prisms_of, slow};

/// What comparisons have seen, so that a test can tell that it tested something.
#[derive(Debug, Clone, Copy, Default)]
struct Compared {
    links: u64,
    hidden: u64,
    /// Of the hidden ones, those that a tile left out.
    in_umbra: u64,
}

impl Compared {
    fn plus(self, other: Compared) -> Compared {
        Compared {
            links: self.links + other.links,
            hidden: self.hidden + other.hidden,
            in_umbra: self.in_umbra + other.in_umbra,
        }
    }
}

/// The box around some receivers, sometimes a little larger.
fn tile_of(random: &mut Random, receivers: &[LatticePoint]) -> ReceiverTile {
    let spare = random.choose(&[0, 0, 1, 700]);
    let range = |of: fn(&LatticePoint) -> i64| {
        let all = || receivers.iter().map(of);
        (all().min().unwrap() - spare, all().max().unwrap() + spare)
    };
    let ((west, east), (south, north)) = (range(|r| r.x), range(|r| r.y));
    ReceiverTile { bounds: [west, south, east, north], heights: range(|r| r.z) }
}

/// Asserts that every receiver sees the positions that `ray` says it sees.
fn compare(
    positions: &Positions<'_>,
    (xs, ys): (&[i64], &[i64]),
    asked: &BitGrid,
    (in_view, receivers): (&InView, &[LatticePoint]),
    context: &dyn Fn() -> String,
) -> Compared {
    let mut compared = Compared::default();
    for receiver in receivers {
        let mut found = in_view.positions.clone();
        positions.los(in_view, *receiver, &mut found);
        for (row, y) in ys.iter().enumerate() {
            for (col, x) in xs.iter().enumerate() {
                let uav = LatticePoint { x: *x, y: *y, z: positions.z };
                // A link of no length is never blocked; of one inside of a building nobody asks.
                let above = LatticePoint { z: uav.z + 1, ..uav };
                if uav == *receiver && !prisms_los(positions.prisms, uav, above) {
                    continue;
                }
                let is_los = asked.contains(row, col) && prisms_los(positions.prisms, uav, *receiver);
                assert_eq!(found.contains(row, col), is_los, "{uav:?} from {receiver:?}: {}", context());
                compared.links += u64::from(asked.contains(row, col));
                compared.hidden += u64::from(asked.contains(row, col) && !is_los);
            }
        }
        compared.in_umbra += asked.count() - in_view.positions.count();
    }
    compared
}

#[test]
fn what_a_receiver_sees_is_what_ray_says_where_everything_coincides() {
    let n_scenes = if slow() { 300_000_u64 } else { 24_000 };
    let levels = levels();
    let compared = (0..n_scenes)
        .into_par_iter()
        .map(|seed| {
            let mut random = Random(seed ^ 0xA11);
            let scale = random.choose(&[1024, 1024, 1024, 1000, 512]);
            let scene = moved(&tiny_scene(&mut random), |[x, y]| [x * scale, y * scale], |top| top * 1024);
            let prisms = prisms_of(&scene);
            if prisms.pieces().is_empty() {
                return Compared::default();
            }
            let field = tiny_field(&mut random, &scene);
            let grid = ShadowGrid::new(field.xs.clone(), field.ys.clone());
            let level = random.choose(&levels);
            // Mostly above the roofs and the receivers, but anything goes.
            let top = scene.iter().map(|prism| prism.top).max().unwrap();
            let anywhere = random.within(0, 40) * 512;
            let z = random.choose(&[top + 3000, top + 1, top, 6 * 1024, 20 * 1024, anywhere]);
            let positions = Positions { prisms: &prisms, casters: prisms.casters(), grid: &grid, z, level };
            let mut receivers: Vec<LatticePoint> = (0..6).map(|_| tiny_uav(&mut random, &scene, &field)).collect();
            if random.chance(60) {
                // Neighbors, as the cells of a tile are.
                let LatticePoint { x, y, z } = receivers[0];
                let steps = random.choose(&[1, 256, 512, 1024]);
                for (k, receiver) in receivers.iter_mut().enumerate() {
                    let k = k as i64;
                    *receiver = LatticePoint { x: x + k % 3 * steps, y: y + k / 3 * steps, z };
                }
            }
            let context = || format!("seed {seed}, {scene:?}");
            let whole = positions.anywhere(&field.wanted);
            let large = positions.from_tile(&tile_of(&mut random, &receivers), &whole);
            let small = positions.from_tile(&tile_of(&mut random, &receivers[..2]), &large);
            let at = (field.xs.as_slice(), field.ys.as_slice());
            let compare = |in_view: &InView, receivers: &[LatticePoint]| {
                compare(&positions, at, &field.wanted, (in_view, receivers), &context)
            };
            compare(&whole, &receivers[..1]).plus(compare(&large, &receivers)).plus(compare(&small, &receivers[..2]))
        })
        .reduce(Compared::default, Compared::plus);
    assert!(compared.links > 10_000_000, "{compared:?}");
    assert!(compared.hidden > compared.links / 10 && compared.hidden < compared.links * 9 / 10, "{compared:?}");
    assert!(compared.in_umbra > compared.hidden / 20, "tiles leave nothing out: {compared:?}");
}

/// The UAVs of a grid of places, with the numbers of their places.
fn uavs_of(field: &HeightField, places: &PlaceGrid, height: Height) -> Vec<(usize, Uav)> {
    let kept = Candidates::of(&places.spots(&[height]), field, &CandidateRules::default()).unwrap().kept;
    kept.into_iter().map(|candidate| (candidate.spot.place, candidate.uav)).collect()
}

/// Asserts that UAVs counted together see what each sees by rays.
fn compare_counts(field: &HeightField, places: &PlaceGrid, height: Height, options: &MapOptions) -> u64 {
    let uavs = uavs_of(field, places, height);
    let mapper = Mapper::new(field, options).unwrap();
    let by_rays = MapOptions { method: MethodChoice::Ray, ..options.clone() };
    let by_rays = Mapper::new(field, &by_rays).unwrap();
    let lattice = mapper.lattice(&places.grid, uavs.iter().map(|(place, uav)| (*place, uav))).unwrap();
    let n_cols = field.grid().n_cols();
    let weight = |cell: usize| u32::try_from(cell / n_cols * 3 + cell % 2).unwrap();
    let alone = mapper.count_lattice(&lattice, &|_| 1, &Control::default()).unwrap().unwrap();
    let weighed = mapper.count_lattice(&lattice, &weight, &Control::default()).unwrap().unwrap();
    let sum = |cells: &BitGrid| -> u64 {
        let is_in = |cell: &usize| cells.contains(cell / n_cols, cell % n_cols);
        (0..field.grid().n_cells()).filter(is_in).map(|cell| u64::from(weight(cell))).sum()
    };
    let mut all = vec![(0, 0, 0, 0); places.grid.n_cells()];
    for (place, uav) in &uavs {
        let seen = by_rays.seen(uav);
        all[*place] = (seen.receivers.count(), seen.los.count(), sum(&seen.receivers), sum(&seen.los));
        assert_eq!(mapper.count(uav), (all[*place].0, all[*place].1));
    }
    for (place, wanted) in all.iter().enumerate() {
        let found = (alone.wanted[place], alone.seen[place], weighed.wanted[place], weighed.seen[place]);
        assert_eq!(found, *wanted, "place {place}, {height:?}, {options:?}");
    }
    alone.seen.iter().sum()
}

#[test]
fn uavs_counted_together_see_what_each_sees_alone() {
    let mut random = Random(71);
    let mut fields: Vec<HeightField> = [21, 28, 70].map(|n| vector_town(&mut random, n)).into_iter().collect();
    fields.extend(["suburban", "urban", "dense-urban", "high-rise"].map(|name| city(name, 150.0, 2.0, 5)));
    let mut seen = 0;
    for field in &fields {
        let side = field.grid().x_max() - field.grid().x_min();
        let mut within = BitGrid::new(field.grid().n_rows(), field.grid().n_cols());
        (0..field.grid().n_cells())
            .filter(|_| random.chance(40))
            .for_each(|k| within.insert(k / within.n_cols(), k % within.n_cols()));
        for (receivers, within, radius) in [
            (Receivers::Ground, None, None),
            (Receivers::All, None, Some(side / 4.0)),
            (Receivers::Roof, Some(within), None),
        ] {
            let options = MapOptions { receivers, within, radius, ..MapOptions::default() };
            for height in [Height::AboveGround(3.0), Height::AboveGround(9.5), Height::AboveDatum(60.0)] {
                let places = PlaceGrid::over(field.grid(), side / random.within(7, 12) as f64).unwrap();
                seen += compare_counts(field, &places, height, &options);
            }
        }
    }
    assert!(seen > 1_000_000, "{seen}");
}

#[test]
fn a_lattice_has_one_height_and_prisms_alone_below() {
    let mut random = Random(72);
    let (vector, raster) = (vector_town(&mut random, 21), raster_town(&mut random, 21));
    let options = MapOptions::default();
    let places = PlaceGrid::over(vector.grid(), 3.0).unwrap();
    let mapper = Mapper::new(&vector, &options).unwrap();
    let mut uavs = uavs_of(&vector, &places, Height::AboveGround(20.0));
    let lattice = |uavs: &[(usize, Uav)]| mapper.lattice(&places.grid, uavs.iter().map(|(k, uav)| (*k, uav)));
    assert!(lattice(&uavs).is_some() && lattice(&[]).is_none());
    uavs[1].1.station.z += 1;
    assert!(lattice(&uavs).is_none(), "two heights");
    uavs[1].1.station.z -= 1;
    uavs[1].0 += 1;
    assert!(lattice(&uavs).is_none(), "a UAV over another place");

    let on_raster = Mapper::new(&raster, &options).unwrap();
    let uavs = uavs_of(&raster, &places, Height::AboveDatum(40.0));
    let lattice = on_raster.lattice(&places.grid, uavs.iter().map(|(k, uav)| (*k, uav))).unwrap();
    assert!(!on_raster.is_counted_sooner(&lattice));
    assert_eq!(on_raster.count_lattice(&lattice, &|_| 1, &Control::default()).unwrap(), None);
}

#[test]
fn whoever_wants_to_stop_is_heard() {
    let field = vector_town(&mut Random(73), 21);
    let places = PlaceGrid::over(field.grid(), 3.0).unwrap();
    let options = MapOptions::default();
    let mapper = Mapper::new(&field, &options).unwrap();
    let uavs = uavs_of(&field, &places, Height::AboveGround(20.0));
    let lattice = mapper.lattice(&places.grid, uavs.iter().map(|(k, uav)| (*k, uav))).unwrap();
    let control = Control::default();
    control.stop.store(true, std::sync::atomic::Ordering::Relaxed);
    let error = mapper.count_lattice(&lattice, &|_| 1, &control).unwrap_err();
    assert_eq!(error.class(), skyshed::error::ErrorClass::Interrupted);
}
