//! Legs over whole scenes, against single links and against the rule that places receivers.

use super::tests_scenes::Dice;
use super::{Leg, LegPart, LegPlace, LegWindow, hidden_parts, inside_parts};
use crate::city::{DataArea, Footprint, FootprintFaults, Ground, Solids};
use crate::coverage::place_receiver;
use crate::height_field::{HeightField, Station};
use crate::los::link_los;
use crate::quantity::{Frame, Height, VOID, meters};
use crate::raster::{GeoRef, Raster};

/// Rows and columns of cells of 2 m.
const N: usize = 8;

fn heights(dice: &mut Dice, highest: i64) -> Vec<i32> {
    (0..N * N)
        .map(|_| if dice.roll(1, 9) == 1 { VOID } else { i32::try_from(1024 * dice.roll(0, highest)).unwrap() })
        .collect()
}

fn raster(dice: &mut Dice, grid: &GeoRef) -> Solids {
    let terrain = Ground::Terrain(Raster::new(grid.clone(), heights(dice, 2)));
    let ground = [Ground::Surface, Ground::Flat(1024), terrain][usize::try_from(dice.roll(0, 2)).unwrap()].clone();
    Solids::Raster {
        surface: Raster::new(grid.clone(), heights(dice, 6)),
        ground,
        building_threshold: 2048,
        voids: None,
    }
}

fn vector(dice: &mut Dice, grid: &GeoRef) -> Solids {
    let terrain = Ground::Terrain(Raster::new(grid.clone(), heights(dice, 2)));
    let ground = if dice.roll(0, 1) == 0 { Ground::Flat(0) } else { terrain };
    let footprint = |k: i64| {
        let [x, y, w, h] = [0, 0, 1, 1].map(|least| i32::try_from(2048 * dice.roll(least, 4)).unwrap());
        let ring = vec![[x, y], [x + w, y], [x + w, y + h], [x, y + h]];
        Footprint::on_zero(k.to_string(), vec![vec![ring]], i32::try_from(1024 * dice.roll(1, 6)).unwrap())
    };
    let footprints = (0..4).map(footprint).collect();
    let frame = Frame { x_origin: 0.0, y_origin: 0.0, unit_x: 1.0, unit_y: 1.0 };
    Solids::Vector { footprints, frame, ground, faults: FootprintFaults::default(), data_area: DataArea::All }
}

/// A place of a scene, in steps of half a meter \[m\].
fn place(dice: &mut Dice) -> [f64; 3] {
    [0, 0, 1].map(|k| meters(512 * i32::try_from(dice.roll(-4, if k == 0 { 36 } else { 18 })).unwrap()))
}

fn station(field: &HeightField, [x, y, z]: [f64; 3]) -> Station {
    #[expect(clippy::cast_possible_truncation, reason = "a multiple of a step")]
    let z = (z * 1024.0) as i64;
    Station { place: field.place(x, y), z }
}

fn holds(parts: &[LegPart], s: LegPlace) -> bool {
    parts.iter().any(|part| part.from < s && s < part.to)
}

#[test]
fn legs_over_scenes_agree_with_links_and_with_places_of_receivers() {
    let grid = GeoRef::new((0.0, 16.0), (2.0, 2.0), (N, N), None).unwrap();
    let (mut checked, mut inside) = ([0, 0], [0, 0]);
    for seed in 0..600 {
        let mut dice = Dice::new(8 << 32 | seed);
        let solids = if seed % 2 == 0 { raster(&mut dice, &grid) } else { vector(&mut dice, &grid) };
        let field = HeightField::build(&grid, solids).field;
        let (observer, from, mut to) = (place(&mut dice), place(&mut dice), place(&mut dice));
        let along = usize::try_from(dice.roll(0, 5)).unwrap();
        if along < 3 {
            to[along] = from[along];
        }
        let uav = station(&field, observer);
        let leg = Leg { from: station(&field, from), to: station(&field, to), window: LegWindow::WHOLE };
        let hidden: Vec<LegPart> = hidden_parts(&field, &uav, &leg).iter().map(super::HiddenPart::part).collect();
        let indoors = inside_parts(&field, &leg);
        // 32 steps of a lattice that is 16 times finer than the places. The odd ones are on no grid
        // line unless all of the leg is.
        for step in (1..32).step_by(2) {
            let s = LegPlace::new(step, 32);
            let at: [f64; 3] = std::array::from_fn(|k| from[k] + s.fraction() * (to[k] - from[k]));
            let receiver = station(&field, at);
            let is_border = [&hidden, &indoors].iter().any(|parts| parts.iter().any(|p| p.from == s || p.to == s));
            if is_border {
                continue;
            }
            let is_los = link_los(&field, &uav, &receiver);
            let can_stand = place_receiver(&field, (at[0], at[1]), Height::amsl(at[2])).is_ok();
            // A merged part may hold single places with another state.
            let crosses_line = (0..2).any(|k| (at[k] / 2.0).fract().abs() <= 0.0 && (from[k] - to[k]).abs() > 0.0);
            if crosses_line {
                continue;
            }
            assert_eq!(holds(&hidden, s), !is_los, "seed {seed}, {step}/32: {observer:?} {from:?} {to:?}");
            assert_eq!(holds(&indoors, s), !can_stand, "seed {seed}, {step}/32: {from:?} {to:?}");
            checked[usize::from(is_los)] += 1;
            inside[usize::from(can_stand)] += 1;
        }
    }
    assert!(checked.iter().chain(&inside).all(|n| *n > 500), "{checked:?} links, {inside:?} places");
}
