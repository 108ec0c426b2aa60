//! Zones: drawn cases, the triangulation against the construction of generated cities, symmetry, real and random scenes.

use std::path::Path;

use skyshed_core::city::{BuiltUp, BuiltUpCity, City, DataArea, Footprint, FootprintFaults, Ground, Solids};
use skyshed_core::height_field::HeightField;
use skyshed_core::overlay::even_odd;
use skyshed_core::quantity::Frame;
use skyshed_core::raster::GeoRef;
use skyshed_core::zones::{NONE, Zone, ZoneBasis, ZoneMap};
use skyshed_io::read::{FootprintOptions, SurfaceOptions, read_footprints, read_surface};

use crate::cities::{built, generated};
use crate::needs::truth;
use crate::support::{Random, surface_field};

/// Lattice steps per meter.
const STEPS: i32 = 1024;

/// Footprints of 10 m on a grid of 1 m cells, `width` × `height` cells from the origin.
fn vector_scene(rings: Vec<Vec<[i32; 2]>>, width: usize, height: usize) -> HeightField {
    footprints(rings.into_iter().map(|ring| (ring, 10 * STEPS)).collect(), width, height)
}

/// Footprints of these rings and heights, in lattice steps, on such a grid.
pub(crate) fn footprints(buildings: Vec<(Vec<[i32; 2]>, i32)>, width: usize, height: usize) -> HeightField {
    let grid = GeoRef::new((0.0, height as f64), (1.0, 1.0), (height, width), None).unwrap();
    let footprints = buildings
        .into_iter()
        .enumerate()
        .map(|(k, (ring, top))| Footprint::on_zero(k.to_string(), even_odd(&[ring]), top))
        .collect();
    let frame = Frame { x_origin: 0.0, y_origin: 0.0, unit_x: 1.0, unit_y: 1.0 };
    let solids = Solids::Vector {
        footprints,
        frame,
        ground: Ground::Flat(0),
        faults: FootprintFaults::default(),
        data_area: DataArea::All,
    };
    HeightField::build(&grid, solids).field
}

pub(crate) fn rectangle([west, south, east, north]: [i32; 4]) -> Vec<[i32; 2]> {
    vec![[west, south], [east, south], [east, north], [west, north]]
}

/// A drawing whose letters are squares of 5 m: `#` is built; all else is open.
fn drawn(rows: &[&str]) -> HeightField {
    let (n_rows, n_cols) = (rows.len(), rows[0].len());
    let at = |k: usize| i32::try_from(5 * k).unwrap() * STEPS;
    let mut rings = Vec::new();
    for (row, letters) in rows.iter().enumerate() {
        for (col, _) in letters.bytes().enumerate().filter(|(_, letter)| *letter == b'#') {
            rings.push(rectangle([at(col), at(n_rows - 1 - row), at(col + 1), at(n_rows - row)]));
        }
    }
    vector_scene(rings, 5 * n_cols, 5 * n_rows)
}

/// Checks each square of a drawing: `#` rooftop, `.` street, `x` crossroad, `o` courtyard, ` ` is not looked at.
fn check(rows: &[&str]) {
    let footprints = drawn(rows);
    let raster = as_raster(&footprints, (1.0, 1.0));
    for (field, how) in [(footprints, "footprints"), (raster, "raster")] {
        let map = ZoneMap::of(&field, None).unwrap();
        let seen: Vec<String> = (0..rows.len())
            .map(|row| {
                let letter = |col: usize| match map.of_cell(5 * row + 2, 5 * col + 2) {
                    Some(Zone::Rooftop) => '#',
                    Some(Zone::Street) => '.',
                    Some(Zone::Crossroad) => 'x',
                    Some(Zone::Courtyard) => 'o',
                    None => '?',
                };
                (0..rows[0].len()).map(letter).collect()
            })
            .collect();
        let agrees = |(a, b): (&&str, &String)| a.chars().zip(b.chars()).all(|(a, b)| a == ' ' || a == b);
        assert!(rows.iter().zip(&seen).all(agrees), "{how}: found\n{}\nwanted\n{}", seen.join("\n"), rows.join("\n"));
    }
}

#[test]
fn streets_that_cross_make_a_crossroad_of_their_width() {
    check(&[
        "######..######",
        "######..######",
        "######..######",
        "######..######",
        "......xx......",
        "......xx......",
        "######..######",
        "######..######",
        "######..######",
        "######..######",
    ]);
}

#[test]
fn a_street_that_ends_at_another_makes_a_crossroad_too() {
    check(&[
        "######################",
        "######################",
        "######################",
        "..........xx..........",
        "..........xx..........",
        "##########..##########",
        "##########..##########",
        "##########..##########",
        "##########..##########",
        "##########..##########",
    ]);
}

#[test]
fn an_alley_is_a_street_and_a_recess_is_a_part_of_one() {
    check(&[
        "########################",
        "########################",
        "##########..############",
        "##########..############",
        "##########..############",
        "##########..############",
        "..........xx............",
        "..........xx............",
        "########################",
        "########################",
    ]);
    check(&[
        "########################",
        "########################",
        "##########....##########",
        "........................",
        "........................",
        "########################",
        "########################",
    ]);
}

#[test]
fn a_bend_is_no_crossroad() {
    check(&[
        "##################",
        "##################",
        "########..........",
        "########..........",
        "########..########",
        "########..########",
        "########..########",
        "########..########",
        "########..########",
    ]);
}

#[test]
fn a_yard_is_a_courtyard_only_if_nothing_leads_to_it() {
    check(&[
        "                ",
        "                ",
        "  ############  ",
        "  ############  ",
        "  ###oooooo###  ",
        "  ###oooooo###  ",
        "  ###oo##oo###  ",
        "  ###oooooo###  ",
        "  ############  ",
        "  ############  ",
        "                ",
        "                ",
    ]);
    check(&[
        "                ",
        "                ",
        "  ######.#####  ",
        "  ######.#####  ",
        "  ###......###  ",
        "  ###......###  ",
        "  ###......###  ",
        "  ###......###  ",
        "  ############  ",
        "  ############  ",
        "                ",
        "                ",
    ]);
}

#[test]
fn a_square_where_streets_meet_is_one_crossroad_but_a_park_is_not() {
    check(&[
        "########..########",
        "########..########",
        "########..########",
        "########..########",
        "######xxxxxx######",
        "######xxxxxx######",
        "......xxxxxx......",
        "......xxxxxx......",
        "######xxxxxx######",
        "######xxxxxx######",
        "########..########",
        "########..########",
        "########..########",
        "########..########",
    ]);
    let side = 60;
    let wall: String = (0..side).map(|k| if (28..30).contains(&k) { '.' } else { '#' }).collect();
    let inside: String = (0..side).map(|k| if (4..side - 4).contains(&k) { '.' } else { '#' }).collect();
    let across: String = ".".repeat(side);
    let rows: Vec<&str> = (0..side)
        .map(|row| match row {
            28..30 => across.as_str(),
            row if (4..side - 4).contains(&row) => inside.as_str(),
            _ => wall.as_str(),
        })
        .collect();
    let map = ZoneMap::of(&drawn(&rows), None).unwrap();
    assert_eq!(map.at(150.0, 150.0), Some(Zone::Street));
    assert_eq!(map.at(10.0, 155.0), Some(Zone::Street));
}

#[test]
fn a_kiosk_in_a_street_does_not_divide_it() {
    let houses = [[0, 0, 100, 30], [0, 50, 100, 80], [48, 38, 52, 42]];
    let field = vector_scene(houses.map(|sides| rectangle(sides.map(|v| v * STEPS))).to_vec(), 100, 80);
    let map = ZoneMap::of(&field, None).unwrap();
    assert_eq!((map.count(Zone::Crossroad), map.count(Zone::Courtyard)), (0, 0));
    assert_eq!(map.at(50.0, 40.0), Some(Zone::Rooftop));
}

fn city(built_up: BuiltUp, size_m: f64) -> HeightField {
    built(&BuiltUpCity { built_up, ..generated("urban", 1, size_m) })
}

/// Shares of open cells with the same zone: of all, and of those a period or more from the frame.
fn agreement(a: &ZoneMap, b: &ZoneMap, margin: f64) -> (f64, f64) {
    let (n_rows, n_cols) = (a.grid().n_rows(), a.grid().n_cols());
    let mut counts = [[0_u64; 2]; 2];
    for row in 0..n_rows {
        for col in 0..n_cols {
            let (ours, theirs) = (a.of_cell(row, col), b.of_cell(row, col));
            assert_eq!(ours == Some(Zone::Rooftop), theirs == Some(Zone::Rooftop));
            if ours == Some(Zone::Rooftop) {
                continue;
            }
            let to_frame = row.min(col).min(n_rows - 1 - row).min(n_cols - 1 - col);
            let same = usize::from(ours == theirs);
            counts[0][same] += 1;
            counts[1][same] += u64::from(to_frame as f64 >= margin);
        }
    }
    let [all, inner] = counts.map(|[not, same]| same as f64 / (same + not).max(1) as f64);
    (all, inner)
}

#[test]
fn the_open_ground_of_generated_cities_has_the_zones_of_their_construction() {
    let named = ["suburban", "urban", "dense", "highrise", "ghent"].map(|name| BuiltUp::named(name).unwrap());
    let others = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]
        .into_iter()
        .flat_map(|alpha| [100.0, 300.0, 750.0, 2000.0].map(|beta| BuiltUp::new(alpha, beta, 15.0).unwrap()));
    for built_up in named.into_iter().chain(others) {
        let field = city(built_up, 400.0);
        let truth = ZoneMap::of(&field, Some(&built_up)).unwrap();
        let ours = ZoneMap::of_open_ground(&field).unwrap();
        assert_eq!((truth.basis(), ours.basis()), (ZoneBasis::StreetGrid, ZoneBasis::OpenGround));
        let (all, inner) = agreement(&truth, &ours, built_up.period());
        assert!(all >= 0.999, "{built_up}: {all}, {inner} a period from the frame");
        assert!(inner >= 0.995, "{built_up}: {inner}");
    }
}

#[test]
fn crossroads_of_a_generated_city_have_their_share_of_the_open_ground() {
    let built_up = BuiltUp::named("urban").unwrap();
    // Eleven whole periods, so that the shares are those of the unbounded grid.
    let map = ZoneMap::of(&city(built_up, 11.0 * built_up.period()), Some(&built_up)).unwrap();
    let (street, crossroad) = (map.count(Zone::Street) as f64, map.count(Zone::Crossroad) as f64);
    let (s, t) = (built_up.street_width(), built_up.period());
    assert!((crossroad / (street + crossroad) - s / (2.0 * t - s)).abs() < 0.01);
    assert_eq!(map.at(1.0, 1.0), Some(Zone::Crossroad));
    assert_eq!(map.at(1.0, t - 1.0), Some(Zone::Street));
    assert_eq!(map.at(-1.0, 1.0), None);
}

/// The building cells of a scene as a raster of its own, with cells of another size.
fn as_raster(field: &HeightField, cell: (f64, f64)) -> HeightField {
    let (n_rows, n_cols) = (field.grid().n_rows(), field.grid().n_cols());
    let grid = GeoRef::new((0.0, cell.1 * n_rows as f64), cell, (n_rows, n_cols), None).unwrap();
    let is_building = |k: usize| field.cells().building.contains(k / n_cols, k % n_cols);
    let tops = (0..n_rows * n_cols).map(|k| i32::from(is_building(k)) * 10 * STEPS).collect::<Vec<_>>();
    surface_field(&grid, tops, Ground::Flat(0))
}

#[test]
fn a_turned_generated_city_keeps_its_zones_as_footprints_and_as_a_raster() {
    for name in ["suburban", "urban", "dense"] {
        let built_up = BuiltUp::named(name).unwrap();
        let (sin, cos) = 0.4_f64.sin_cos();
        let (s, t, size) = (built_up.street_width(), built_up.period(), 360);
        // Turned about the center of the grid; buildings reach beyond its edges.
        let center = f64::from(size) / 2.0;
        let turned = |x: f64, y: f64| [center + cos * x - sin * y, center + sin * x + cos * y];
        #[expect(clippy::cast_possible_truncation, reason = "within the grid and a little more")]
        let lattice = |p: [f64; 2]| p.map(|v| (v * f64::from(STEPS)).round() as i32);
        let mut rings = Vec::new();
        for (i, j) in (-24..24).flat_map(|i| (-24..24).map(move |j| (f64::from(i), f64::from(j)))) {
            let ([x0, x1], [y0, y1]) = ([i * t + s, i * t + t], [j * t + s, j * t + t]);
            rings.push([[x0, y0], [x1, y0], [x1, y1], [x0, y1]].map(|[x, y]| lattice(turned(x, y))).to_vec());
        }
        let field = vector_scene(rings, 360, 360);
        for (ours, how, wanted) in [
            (ZoneMap::of(&field, None).unwrap(), "footprints", 0.999),
            (ZoneMap::of(&as_raster(&field, (1.0, 1.0)), None).unwrap(), "raster", 0.9),
        ] {
            let (mut n, mut n_same) = (0, 0);
            for (row, col) in (40..320).flat_map(|r| (40..320).map(move |c| (r, c))) {
                if !field.cells().open.contains(row, col) {
                    continue;
                }
                let (dx, dy) = (col as f64 + 0.5 - center, 360.0 - row as f64 - 0.5 - center);
                let is_street = |v: f64| v.rem_euclid(t) <= s;
                let is_crossroad = is_street(cos * dx + sin * dy) && is_street(cos * dy - sin * dx);
                n += 1;
                n_same += u32::from((ours.of_cell(row, col) == Some(Zone::Crossroad)) == is_crossroad);
            }
            let share = f64::from(n_same) / f64::from(n);
            assert!(share >= wanted, "{name}, {how}: {share}");
        }
    }
}

#[test]
fn zones_do_not_depend_on_odd_sizes_of_cells() {
    let field = build(&munich());
    let map = |cell| ZoneMap::of(&as_raster(&field, cell), None).unwrap();
    let square = map((2.0, 2.0));
    assert!(square.count(Zone::Crossroad) > 0);
    for cell in [(2.000_6, 2.000_1), (1.999_9, 2.0)] {
        let odd = map(cell);
        let n_same = square.codes().iter().zip(odd.codes()).filter(|(a, b)| a == b).count();
        let share = n_same as f64 / square.codes().len() as f64;
        assert!(share > 0.99, "{cell:?}: {share}");
    }
}

/// Bilbao's cells are not square; its outlines touch themselves in many places.
#[test]
fn a_laser_scan_of_a_city_has_crossroads_and_courtyards() {
    let Some(folder) = truth() else { return };
    let path = |name: &str| folder.join("lidar/bilbao").join(name);
    let terrain = Some(path("terrain_2.5m.tif").into());
    let options = SurfaceOptions { terrain, building_threshold_m: 2.0, ..SurfaceOptions::default() };
    let scene = read_surface(path("dsm_2.5m.tif"), &options, &mut Vec::new()).unwrap();
    let field = build(&scene);
    let map = ZoneMap::of(&field, None).unwrap();
    check_cells(&field, &map);
    assert!(map.count(Zone::Crossroad) > 5000, "{}", map.count(Zone::Crossroad));
    assert!(map.count(Zone::Courtyard) > 1000, "{}", map.count(Zone::Courtyard));
}

/// Every cell is in the one zone that its kind allows.
fn check_cells(field: &HeightField, map: &ZoneMap) {
    let cells = field.cells();
    let mut n_void = 0;
    for row in 0..map.grid().n_rows() {
        for col in 0..map.grid().n_cols() {
            let zone = map.of_cell(row, col);
            let (is_open, is_building) = (cells.open.contains(row, col), cells.building.contains(row, col));
            assert_eq!(zone == Some(Zone::Rooftop), is_building);
            assert_eq!(zone.is_some(), is_open || is_building);
            n_void += u64::from(zone.is_none());
        }
    }
    assert_eq!(map.count(Zone::Rooftop), cells.building.count());
    assert_eq!(map.codes().iter().filter(|code| **code == NONE).count() as u64, n_void);
}

fn munich() -> City {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("maps/munich.geojson");
    let options = FootprintOptions { cell_m: Some(2.0), ..FootprintOptions::default() };
    read_footprints(&path, &options, &mut Vec::new()).unwrap()
}

fn build(scene: &City) -> HeightField {
    HeightField::build(&scene.grid, scene.solids.clone()).field
}

#[test]
fn munich_has_all_zones_in_plausible_shares_on_any_number_of_threads() {
    let field = build(&munich());
    let map = ZoneMap::of(&field, None).unwrap();
    check_cells(&field, &map);
    let open = field.cells().open.count() as f64;
    let share = |zone: Zone| map.count(zone) as f64 / open;
    assert!((0.05..0.3).contains(&share(Zone::Crossroad)), "{}", share(Zone::Crossroad));
    assert!((0.1..0.35).contains(&share(Zone::Courtyard)), "{}", share(Zone::Courtyard));
    for n_threads in [1, 2, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
        assert_eq!(pool.install(|| ZoneMap::of(&build(&munich()), None).unwrap()), map);
    }
}

#[test]
fn no_footprints_make_it_stumble() {
    let mut random = Random(11);
    for round in 0..300 {
        // Coarse positions make shared walls and touching corners; fine ones make slits and crossings.
        let unit = random.choose(&[1, 37, 512, 1024, 4096]);
        let n = random.within(0, 12);
        let rings = (0..n)
            .map(|_| {
                let corners = random.within(3, 7);
                (0..corners)
                    .map(|_| [0, 1].map(|_| i32::try_from(random.within(-8, 48 * 1024 / unit) * unit).unwrap()))
                    .collect()
            })
            .collect();
        let field = vector_scene(rings, 40, random.index(1, 44));
        let map = ZoneMap::of(&field, None).unwrap();
        check_cells(&field, &map);
        assert_eq!(map, ZoneMap::of(&field, None).unwrap(), "round {round}");
    }
}

#[test]
fn no_surface_model_makes_it_stumble_and_one_alone_has_no_zones() {
    let mut random = Random(12);
    for _ in 0..200 {
        let (n_rows, n_cols) = (random.index(1, 20), random.index(1, 20));
        let cell = random.choose(&[(1.0, 1.0), (0.25, 0.5), (30.0, 20.0)]);
        let grid = GeoRef::new((-7.5, 100.0), cell, (n_rows, n_cols), None).unwrap();
        let percent = random.choose(&[0, 20, 50, 80, 100]);
        let heights: Vec<i32> = (0..n_rows * n_cols)
            .map(|_| match random.chance(5) {
                true => skyshed_core::quantity::VOID,
                false => i32::from(random.chance(percent)) * 10 * STEPS,
            })
            .collect();
        for ground in [Ground::Flat(0), Ground::Surface] {
            let is_known = matches!(ground, Ground::Flat(_));
            let field = surface_field(&grid, heights.clone(), ground);
            let map = ZoneMap::of(&field, None).unwrap();
            assert_eq!(ZoneMap::if_known(&field, None).unwrap(), is_known.then(|| map.clone()));
            if is_known {
                check_cells(&field, &map);
            } else {
                assert!(map.basis() == ZoneBasis::Unknown && map.codes().iter().all(|code| *code == NONE));
            }
        }
    }
}
