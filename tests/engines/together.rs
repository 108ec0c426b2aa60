//! What is told of many UAVs together, against the masks of each and distances in integers.

use skyshed_core::coverage::{Control, HeightLayers, KeepMasks, MapOptions, Mapper, Receivers, Together, Uav, class};
use skyshed_core::height_field::{CellKind, Station};
use skyshed_core::quantity::VOID;
use skyshed_core::raster::LargeVec;

use crate::invariants::{map, options, uav_at, vector_town};
use crate::shapes::M;
use crate::support::Random;

#[test]
fn what_is_told_of_many_agrees_with_the_masks() {
    let mut random = Random(15);
    let field = vector_town(&mut random, 42);
    // More than 32 UAVs, so that `which` needs two words; some at equal distances from places between them.
    let uavs: Vec<Uav> = (0..35)
        .map(|k| uav_at(&field, f64::from(k) + 0.5, f64::from((k * 17) % 42) + 0.25, 15 * M))
        .chain([uav_at(&field, 10.5, 20.5, 15 * M), uav_at(&field, 20.5, 20.5, 15 * M)])
        .collect();
    let asked = MapOptions { radius: Some(18.0), ..options(Receivers::Ground, HeightLayers::default()) };
    let masks: Vec<LargeVec<u8>> = uavs.iter().map(|uav| map(&field, uav, &asked).mask).collect();
    let masks: Vec<&[u8]> = masks.iter().map(LargeVec::as_slice).collect();
    let mapper = Mapper::new(&field, &asked).unwrap();
    let together = Together { which: true, best_server: true, ..Together::default() };
    let maps = mapper.map_many(&uavs, (KeepMasks::UntilTold, &together), &Control::default(), |_| {}, |_| {}).unwrap();
    let overlay = maps.overlay.unwrap();
    let best = overlay.best_server().unwrap();
    let n_cols = field.grid().n_cols();
    let ground_of = |cell: usize| match field.cell_kind(cell, &field.positions().center(cell / n_cols, cell % n_cols)) {
        CellKind::Open(z) | CellKind::Building(z) => z,
        CellKind::Void => VOID,
    };
    let mut n_ties = 0;
    for (cell, number) in best.iter().enumerate() {
        let center = field.positions().center(cell / n_cols, cell % n_cols);
        let receiver =
            Station { place: center, z: i64::from(ground_of(cell)) + i64::from(asked.rx_height) }.on_prisms();
        let squared = |uav: &Uav| {
            let at = uav.station.on_prisms();
            [at.x - receiver.x, at.y - receiver.y, at.z - receiver.z]
                .map(|d| i128::from(d) * i128::from(d))
                .iter()
                .sum::<i128>()
        };
        let seeing = (0..uavs.len()).filter(|k| masks[*k][cell] == class::LOS);
        let nearest = seeing.clone().min_by_key(|k| (squared(&uavs[*k]), *k));
        assert_eq!(nearest.map_or(0, |k| k + 1), *number as usize, "cell {cell}");
        n_ties += usize::from(
            nearest.is_some_and(|n| seeing.filter(|k| squared(&uavs[*k]) == squared(&uavs[n])).count() > 1),
        );
    }
    assert!(n_ties > 0);
    let (union, count, which) = (overlay.union(), overlay.count(), overlay.which());
    assert_eq!(which.len(), 2);
    let mut n_los = 0;
    for i in 0..union.len() {
        assert_eq!(count[i], which.iter().map(|word| word[i].count_ones()).sum::<u32>());
        for (k, mask) in masks.iter().enumerate() {
            assert_eq!(mask[i] == class::LOS, which[k / 32][i] >> (k % 32) & 1 == 1);
        }
        assert_eq!(count[i] > 0, union[i] == class::LOS);
        assert_eq!(union[i] == class::NLOS, count[i] == 0 && masks.iter().any(|m| m[i] == class::NLOS));
        n_los += usize::from(union[i] == class::LOS);
    }
    assert!(n_los > 200);
}
