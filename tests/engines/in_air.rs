//! Places of a drone at a height above the ground: who they are, by the definition, and whom an observer sees, by rays.

use skyshed_core::city::Ground;
use skyshed_core::coverage::{MapOptions, Mapper, Receivers, class};
use skyshed_core::height_field::{CellKind, HeightField, Station};
use skyshed_core::los::{MethodChoice, link_los};
use skyshed_core::quantity::VOID;
use skyshed_core::raster::{GeoRef, Raster};

use crate::invariants::{map, uav_at, vector_town, vector_town_on};
use crate::program::Folder;
use crate::support::{Random, raster_field};

/// Holds a map against a ray for each place that no building reaches.
fn check(field: &HeightField, above: i32, what: &str) {
    let uav = uav_at(field, field.grid().x_min() + 6.5, field.grid().y_min() + 13.5, 13_500);
    let options = MapOptions { rx_height: above, receivers: Receivers::Air, ..MapOptions::default() };
    let found = map(field, &uav, &options);
    let by_rays = map(field, &uav, &MapOptions { method: MethodChoice::Ray, ..options.clone() });
    assert!(found.mask == by_rays.mask, "{what}");
    assert_eq!(
        Mapper::new(field, &options).unwrap().seen_from(&uav).unwrap().count(),
        (found.tally.receivers, found.tally.los)
    );
    let (positions, n_cols) = (field.positions(), field.grid().n_cols());
    let (mut n_over, mut n_high) = (0, 0);
    for cell in 0..field.grid().n_cells() {
        let place = positions.center(cell / n_cols, cell % n_cols);
        let ground = field.ground_at(&place);
        let is_free = match field.cell_kind(cell, &place) {
            CellKind::Open(_) => true,
            CellKind::Building(roof) if roof <= ground + above => {
                n_over += 1;
                true
            }
            CellKind::Building(_) => {
                n_high += 1;
                false
            }
            CellKind::Void => false,
        };
        let receiver = Station { place, z: i64::from(ground) + i64::from(above) };
        let wanted = match (is_free, is_free && link_los(field, &uav.station, &receiver)) {
            (false, _) if field.cell_kind(cell, &place) == CellKind::Void => class::NODATA,
            (false, _) => class::NOT_A_RECEIVER,
            (true, true) => class::LOS,
            (true, false) => class::NLOS,
        };
        assert_eq!(found.mask[cell], wanted, "{what}, cell {cell}");
    }
    assert!(n_over > 10 && n_high > 10, "{what}: {n_over} {n_high}");
}

#[test]
fn places_in_the_air_are_over_all_ground_and_over_buildings_that_reach_no_higher() {
    let mut random = Random(91);
    for above in [5 * 1024, 6 * 1024 + 1] {
        check(&vector_town(&mut random, 42), above, "footprints");
        let grid = GeoRef::new((0.0, 42.0), (1.0, 1.0), (42, 42), None).unwrap();
        let heights = |random: &mut Random, most: i64| -> Vec<i32> {
            (0..42 * 42).map(|_| i32::try_from(random.within(0, most)).unwrap()).collect()
        };
        let hills = Ground::Terrain(Raster::new(grid.clone(), heights(&mut random, 1500)));
        check(&vector_town_on(&mut random, hills, 42), above, "footprints on hills");
        let mut tops = heights(&mut random, 12_000);
        tops.iter_mut().step_by(37).for_each(|z| *z = VOID);
        check(&raster_field(Raster::new(grid, tops), Ground::Flat(0)), above, "a raster");
    }
}

#[test]
fn an_observer_is_told_from_a_uav_and_strips_give_the_map_of_memory() {
    let folder = Folder::new();
    let run =
        folder.type_in("map itu:urban --size 200 --uav 99,101,1.7 --receivers air --rx-height 40 -o m.png -o m.json");
    let run = run.done();
    assert!(run.err.contains("Observer 1: P_LoS") && run.err.contains("places in the air"), "{}", run.err);
    assert_eq!(folder.json("m.json")["receivers"], "air");
    folder.type_in("city itu:urban --size 1000 -o city.tif -q").done();
    let raster = |words: &str| {
        let of = format!("map city.tif --ground 0 --uav 499,501,1.7 --receivers air --rx-height 40 {words} --json");
        folder.type_in(&of).done()
    };
    let (whole, strips) = (raster(""), raster("--strips"));
    assert!(strips.err.contains("strip by strip"), "{}", strips.err);
    assert_eq!(whole.json()["digest"], strips.json()["digest"]);
}
