//! Who is in range of an antenna: by the definition, restated in whole numbers, where cells lie on a boundary as often as can be.

use std::cmp::Ordering;

use skyshed_core::city::{Antenna, Ground};
use skyshed_core::coverage::{HeightLayers, MapOptions, Mapper, Receivers, Tally, Uav, class};
use skyshed_core::height_field::{CellKind, HeightField};
use skyshed_core::quantity::{Height, VOID};
use skyshed_core::raster::{GeoRef, Raster};
use skyshed_study::placement::PlaceGrid;

use crate::invariants::{map, uav_at, vector_town};
use crate::program::Folder;
use crate::shadow_positions::compare_counts;
use crate::support::{Random, city, is_long, raster_field};

/// A direction in whole numbers. Angles are chosen with it, so that what lies on a boundary does so exactly.
#[derive(Debug, Clone, Copy)]
struct Direction {
    degrees: f64,
    steps: (i64, i64),
}

/// Azimuths \[deg clockwise from north\] along axes, along diagonals, and in no direction that a cell has.
fn azimuth(random: &mut Random) -> Direction {
    const EIGHTHS: [(i64, i64); 8] = [(0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1), (-1, 0), (-1, 1)];
    if random.chance(70) {
        let k = random.below(8);
        return Direction { degrees: 45.0 * k as f64, steps: EIGHTHS[k] };
    }
    let degrees = random.within(0, 3599) as f64 / 10.0 + 0.0317;
    let (sin, cos) = degrees.to_radians().sin_cos();
    let long = (1_i64 << 30) as f64;
    #[expect(clippy::cast_possible_truncation, reason = "2^30 at most")]
    let steps = ((sin * long) as i64, (cos * long) as i64);
    Direction { degrees, steps }
}

/// Where the direction of steps is in the circle clockwise from another: its quarter, and how it compares within.
fn clockwise(from: (i64, i64), a: (i64, i64), b: (i64, i64)) -> Ordering {
    let turned = |(x, y): (i64, i64)| {
        let (x, y, fx, fy) = (i128::from(x), i128::from(y), i128::from(from.0), i128::from(from.1));
        (x * fy - y * fx, x * fx + y * fy) // to the right of `from`, and along it
    };
    let quarter = |(right, along): (i128, i128)| match (right, along) {
        (r, a) if r >= 0 && a > 0 => 0,
        (r, a) if r > 0 && a <= 0 => 1,
        (r, a) if r <= 0 && a < 0 => 2,
        _ => 3,
    };
    let (a, b) = (turned(a), turned(b));
    // Within a quarter the one that is more to the right of the other comes later.
    quarter(a).cmp(&quarter(b)).then_with(|| (a.0 * b.1).cmp(&(b.0 * a.1)))
}

/// Elevations \[deg\] whose tangents are 0, ±1 and ±3/4, no end, or in no direction that a receiver has.
fn elevation(random: &mut Random) -> Direction {
    let (along, up) = match random.within(0, 7) {
        0 => (1, 0),
        1 => (1, 1),
        2 | 3 => (1, -1),
        4 => (0, -1),
        5 => (0, 1),
        _ => (10_007, random.within(-30_011, 30_011)),
    };
    Direction { degrees: (up as f64).atan2(along as f64).to_degrees(), steps: (along, up) }
}

/// How the elevation of what is `rise` above at a squared distance compares to a direction.
fn compare_elevation(rise: i64, squared: i64, to: Direction) -> Ordering {
    if squared == 0 && rise != 0 {
        // Straight above or below.
        let up = to.steps.1.signum();
        return if to.steps.0 == 0 && up == rise.signum() { Ordering::Equal } else { rise.cmp(&0) };
    }
    let square = |n: i64| i128::from(n) * i128::from(n.abs());
    // rise / distance against up / along.
    (square(rise) * square(to.steps.0)).cmp(&(square(to.steps.1) * i128::from(squared)))
}

/// An antenna, and its limits in whole numbers: the least distance in lattice steps, the sector, the elevations, the slant
/// range in lattice steps.
struct Case {
    antenna: Antenna,
    min_radius: i64,
    sector: Option<[Direction; 2]>,
    elevations: [Option<Direction>; 2],
    slant_range: Option<i64>,
}

impl Case {
    fn new(random: &mut Random) -> Case {
        let (antenna, elevations) = (Antenna::default(), [None; 2]);
        let mut case = Case { antenna, min_radius: 0, sector: None, elevations, slant_range: None };
        if random.chance(40) {
            let half_meters = random.within(0, 12);
            case.min_radius = half_meters * 512;
            case.antenna.min_radius_m = Some(half_meters as f64 / 2.0);
        }
        let ends = [azimuth(random), azimuth(random)];
        if random.chance(75) && (ends[0].degrees - ends[1].degrees).abs() > 1e-9 {
            let turn = random.choose(&[0.0, 0.0, -360.0]);
            case.antenna.sector_deg = Some(ends.map(|end| end.degrees + turn));
            case.sector = Some(ends);
        }
        if random.chance(45) {
            let mut ends = [elevation(random), elevation(random)];
            ends.sort_by(|a, b| a.degrees.total_cmp(&b.degrees));
            case.antenna.elevation_deg = Some(ends.map(|end| end.degrees));
            case.elevations = ends.map(Some);
        } else if random.chance(40) {
            // The side of a cone of 90° is 45° below the horizon.
            case.antenna.beam_deg = Some(90.0);
            case.elevations[1] = Some(Direction { degrees: -45.0, steps: (1, -1) });
        }
        if random.chance(30) {
            // Many sums of two squares among whole meters.
            let half_meters = random.choose(&[5, 10, 13, 20, 25, 26, 34]);
            case.slant_range = Some(half_meters * 512);
            case.antenna.slant_range_m = Some(half_meters as f64 / 2.0);
        }
        case
    }

    /// Whether a place so many lattice steps away is in range, but for its height; and whether it is on a boundary.
    fn holds(&self, steps: (i64, i64)) -> (bool, bool) {
        let squared = steps.0 * steps.0 + steps.1 * steps.1;
        let least = squared.cmp(&(self.min_radius * self.min_radius));
        let in_sector = self.sector.map(|[from, to]| {
            let steps = if steps == (0, 0) { (0, 1) } else { steps };
            let ends = clockwise(from.steps, steps, to.steps);
            (ends == Ordering::Less, ends == Ordering::Equal || clockwise(from.steps, steps, from.steps).is_eq())
        });
        let (is_in, is_on) = in_sector.unwrap_or((true, false));
        (least.is_ge() && is_in, least.is_eq() || is_on)
    }

    /// Whether a receiver so high above the UAV is in range there; and whether it is on a boundary.
    fn holds_height(&self, steps: (i64, i64), rise: i64) -> (bool, bool) {
        let squared = steps.0 * steps.0 + steps.1 * steps.1;
        let [low, high] = self.elevations.map(|end| end.map(|end| compare_elevation(rise, squared, end)));
        let holds = |of: Option<Ordering>, beyond: Ordering| of.is_none_or(|of| of != beyond);
        let far = self.slant_range.map(|range| (squared + rise * rise).cmp(&(range * range)));
        let is_in = holds(low, Ordering::Less) && holds(high, Ordering::Greater) && holds(far, Ordering::Greater);
        (is_in, low.into_iter().chain(high).chain(far).any(Ordering::is_eq))
    }
}

/// A small town on cells of 1 m with steps of relief, holes and houses; and whether its ground is flat.
fn town(random: &mut Random) -> (HeightField, bool) {
    let (n_rows, n_cols) = (random.index(6, 19), random.index(6, 19));
    let grid = GeoRef::new((40.0, 90.0), (1.0, 1.0), (n_rows, n_cols), None).unwrap();
    let cells = (0..n_rows * n_cols).map(|_| match random.within(0, 9) {
        0 => VOID,
        1..=3 => i32::try_from(random.within(1, 6)).unwrap() * 1024,
        _ => 0,
    });
    let surface = Raster::new(grid.clone(), cells.collect::<Vec<_>>());
    let ground = match random.within(0, 2) {
        0 => Ground::Surface,
        1 => Ground::Flat(0),
        _ => {
            let steps = surface.cells().iter().enumerate().map(|(k, top)| match (*top, k % 7) {
                (VOID, _) => VOID,
                (top, 0) => top,
                (top, _) => top.min(0),
            });
            Ground::Terrain(Raster::new(grid, steps.collect::<Vec<_>>()))
        }
    };
    let is_flat = matches!(ground, Ground::Flat(_));
    (raster_field(surface, ground), is_flat)
}

#[test]
fn masks_and_tallies_are_those_of_the_definition() {
    let (mut n_in, mut n_out, mut n_on) = (0_u64, 0_u64, 0_u64);
    let mut random = Random(19);
    for n in 0..if is_long() { 100_000 } else { 10_000 } {
        let (field, is_flat) = if n % 4 == 3 { (vector_town(&mut random, 14), true) } else { town(&mut random) };
        let grid = field.grid();
        let (n_rows, n_cols) = (grid.n_rows(), grid.n_cols());
        // At a center, at a corner, or anywhere; sometimes outside.
        let at = |random: &mut Random, low: f64, n: usize| {
            let n = i64::try_from(n).unwrap();
            low + match random.within(0, 5) {
                0..=2 => random.within(0, n - 1) as f64 + 0.5,
                3 => random.within(-2, n + 2) as f64,
                _ => random.within(-2048, (n + 2) * 1024) as f64 / 1024.0,
            }
        };
        let (x, y) = (at(&mut random, grid.x_min(), n_cols), at(&mut random, grid.y_min(), n_rows));
        let z = 1024 * random.within(0, 14) + 1536;
        let case = Case::new(&mut random);
        let uav = Uav { antenna: case.antenna, ..uav_at(&field, x, y, z) };
        let receivers = random.choose(&[Receivers::Ground, Receivers::Roof, Receivers::All]);
        let layers = HeightLayers { margin: n % 5 == 0, ..HeightLayers::default() };
        let options = MapOptions { receivers, layers, ..MapOptions::default() };
        let all = map(&field, &uav_at(&field, x, y, z), &options);
        let found = map(&field, &uav, &options);
        let positions = field.positions();
        let lattice = |place| {
            let station = skyshed_core::height_field::Station { place, z: 0 };
            if field.prisms().is_some() { station.on_prisms() } else { station.on_columns() }
        };
        let here = lattice(uav.station.place);
        for cell in 0..n_rows * n_cols {
            let center = positions.center(cell / n_cols, cell % n_cols);
            let (there, of_all) = (lattice(center), all.mask[cell]);
            let steps = (there.x - here.x, there.y - here.y);
            let (mut is_in, mut is_on) = case.holds(steps);
            if matches!(of_all, class::LOS | class::NLOS)
                && let CellKind::Open(base) | CellKind::Building(base) = field.cell_kind(cell, &center)
            {
                let of_height = case.holds_height(steps, i64::from(base) + 1536 - z);
                (is_in, is_on) = (is_in && of_height.0, is_on || of_height.1);
            } else if is_flat && receivers == Receivers::Ground {
                // As if a receiver stood there.
                is_in = is_in && case.holds_height(steps, 1536 - z).0;
            }
            let wanted = if is_in || of_all == class::NODATA { of_all } else { class::OUT_OF_RANGE };
            assert_eq!(found.mask[cell], wanted, "case {n}, cell {cell}, {steps:?} from {here:?}, {:?}", case.antenna);
            match wanted {
                class::OUT_OF_RANGE => n_out += 1,
                class::NODATA => {}
                _ => n_in += 1,
            }
            n_on += u64::from(is_on);
        }
        let counted = Tally::of_mask(&found.mask);
        let of = |t: &Tally| [t.receivers, t.los, t.not_receivers, t.out_of_range, t.nodata];
        assert_eq!(of(&found.tally), of(&counted), "case {n}");
        let mapper = Mapper::new(&field, &options).unwrap();
        assert_eq!(mapper.seen_from(&uav).unwrap().count(), (counted.receivers, counted.los), "case {n}");
        assert_eq!(mapper.seen_from(&uav).unwrap().receivers_in_range().count(), counted.receivers, "case {n}");
        // That of the run serves where a UAV has none.
        let of_run = MapOptions { antenna: case.antenna, ..options };
        assert_eq!(map(&field, &uav_at(&field, x, y, z), &of_run).mask, found.mask, "case {n}");
    }
    assert!(n_in > 100_000 && n_out > 100_000 && n_on > 20_000, "{n_in} in, {n_out} out, {n_on} on a boundary");
}

#[test]
fn a_sector_and_its_complement_part_the_receivers() {
    let mut random = Random(23);
    let field = city("urban", 200.0, 1.0, 4);
    let whole = |uav: &Uav| map(&field, uav, &MapOptions::default());
    for _ in 0..if is_long() { 300 } else { 15 } {
        let (from, to) = (random.within(-360, 360) as f64, random.within(-360, 360) as f64);
        if (from - to) % 360.0 == 0.0 {
            continue;
        }
        let (x, y) = (random.within(0, 199) as f64 + 0.5, random.within(0, 199) as f64 + 0.5);
        let uav = uav_at(&field, x, y, 90 * 1024);
        let part = |sector: [f64; 2]| {
            let antenna = Antenna { sector_deg: Some(sector), ..Antenna::default() };
            map(&field, &Uav { antenna, ..uav.clone() }, &MapOptions::default())
        };
        // Clockwise from the one to the other, and on to the first.
        let (a, b, all) = (part([from, to]), part([to, from]), whole(&uav));
        for (cell, class) in all.mask.iter().enumerate() {
            let parts = [a.mask[cell], b.mask[cell]];
            let is_parted = parts == [*class, class::OUT_OF_RANGE] || parts == [class::OUT_OF_RANGE, *class];
            assert!(is_parted, "{from} {to}: cell {cell} is {parts:?}, {class} in all");
        }
        assert_eq!(
            (a.tally.receivers + b.tally.receivers, a.tally.los + b.tally.los),
            (all.tally.receivers, all.tally.los)
        );
    }
}

#[test]
fn uavs_with_antennas_that_are_counted_together_see_what_each_sees() {
    let mut random = Random(29);
    let fields = [vector_town(&mut random, 28), city("urban", 150.0, 2.0, 5), city("high-rise", 120.0, 2.0, 6)];
    let mut n_los = 0;
    for field in &fields {
        for _ in 0..if is_long() { 30 } else { 4 } {
            let Case { antenna, .. } = Case::new(&mut random);
            let options = MapOptions { antenna, radius: Some(random.choose(&[20.0, 60.0])), ..MapOptions::default() };
            let places = PlaceGrid::over(field.grid(), 9.0).unwrap();
            n_los += compare_counts(field, &places, Height::AboveGround(random.choose(&[20.0, 45.0])), &options);
        }
    }
    assert!(n_los > 10_000, "{n_los}");
}

#[test]
fn tables_give_each_uav_its_own_antenna() {
    let folder = Folder::new();
    let csv = "id,x,y,h,sector,elevation,beam,min_radius,slant_range\n\
               a,100.5,100.5,80,\"0,90\",,,,\n\
               b,100.5,100.5,80,90;360,,,,\n\
               c,100.5,100.5,80,,-60 -30,,,\n\
               d,100.5,100.5,80,,,90,20,\n\
               e,100.5,100.5,80,,,,,\n\
               f,100.5,100.5,80,,,,,100\n";
    folder.write("uavs.csv", csv);
    let document = |words: &str| folder.type_in(&format!("map itu:urban --size 200 {words} --json -q")).done().json();
    let receivers = |document: &serde_json::Value, k: usize| document["sites"][k]["receivers"].as_u64().unwrap();
    let all = document("--uavs uavs.csv");
    assert_eq!(receivers(&all, 0) + receivers(&all, 1), receivers(&all, 4));
    for (k, words) in [
        (0, "--sector 0,90"),
        (1, "--sector -270,0"),
        (2, "--elevation -60,-30"),
        (3, "--beam 90 --min-radius 20"),
        (4, "--sector 0,360 --elevation -90,90 --beam 360 --min-radius 0 --slant-range 400"),
        // Over flat ground receivers are 78.5 m below the UAV.
        (5, "--radius 61.95"),
    ] {
        let one = document(&format!("--uav 100.5,100.5,80 {words}"));
        assert_eq!(one["sites"][0]["los"], all["sites"][k]["los"], "{words}");
        assert_eq!(receivers(&one, 0), receivers(&all, k), "{words}");
    }
    assert_eq!(all["sites"][0]["antenna"]["sector_deg"], serde_json::json!([0.0, 90.0]));
    assert_eq!((&all["antenna"], &all["sites"][4]["antenna"]), (&serde_json::Value::Null, &serde_json::Value::Null));
    // What a row does not say, the flag does.
    let limited = document("--uavs uavs.csv --sector 0,90");
    assert_eq!(receivers(&limited, 4), receivers(&all, 0));
    assert_eq!(receivers(&limited, 1), receivers(&all, 1));
    // Points say it in their properties.
    let point = |properties: &str| {
        format!(
            r#"{{"type":"Feature","properties":{{"h":120{properties}}},
                 "geometry":{{"type":"Point","coordinates":[691549.7,5334762.2]}}}}"#
        )
    };
    let points = [point(r#","sector":[-90,90],"beam":100"#), point(r#","sector":"90,270","elevation":[-90, -40]"#)];
    let crs = r#"{"type":"name","properties":{"name":"EPSG:25832"}}"#;
    let collection = format!(r#"{{"type":"FeatureCollection","crs":{crs},"features":[{}]}}"#, points.join(","));
    folder.write("uavs.geojson", &collection);
    let munich = folder.word(concat!(env!("CARGO_MANIFEST_DIR"), "/maps/munich.geojson"));
    let of = |words: &str| folder.type_in(&format!("map {munich} --radius 150 {words} --json -q")).done().json();
    let points = of("--uavs uavs.geojson");
    for (k, words) in [(0, "--sector 270,90 --beam 100"), (1, "--sector 90,270 --beam 100")] {
        let one = of(&format!("--uav 691549.7,5334762.2,120 {words}"));
        assert_eq!(one["sites"][0]["los"], points["sites"][k]["los"], "{words}");
    }
    folder.write("bad.csv", "x,y,h,sector,beam\n1,1,80,\"10,10\",\n1,1,80,\"10,20,30\",\n1,1,80,,400\n");
    let words = [
        "line 2",
        "line 3",
        "line 4",
        "`sector`",
        "wanted two angles such as 90,180",
        "the beam: found 400, wanted above 0°",
    ];
    folder.refuses("map itu:urban --size 200 --uavs bad.csv --json", "E302", &words);
}

/// Candidates of a table have their own antennas, alone, in a choice of several, and by another method.
#[test]
fn candidates_with_antennas_are_counted_as_maps_count_them() {
    let folder = Folder::new();
    let table = "x,y,h,min_radius,sector,elevation,beam,slant_range\n\
                 60,60,50,,\"0,90\",,,\n240,60,50,20,,,,\n150,150,60,,,\"-60,-20\",,120\n60,240,50,,,,80,\n240,240,50,,,,,\n";
    folder.write("sites.csv", table);
    let scene = "itu:urban --size 300 --seed 4";
    let map = folder.type_in(&format!("map {scene} --uavs sites.csv --json -q")).done().json();
    for method in ["auto", "ray"] {
        let line = format!("place {scene} --candidates sites.csv --top 5 --method {method} --json -q");
        let found = folder.type_in(&line).done().json();
        let ranked = found["ranked"].as_array().expect("ranks");
        assert_eq!(ranked.len(), 5, "{found}");
        for rank in ranked {
            let at = |site: &&serde_json::Value| (&site["x"], &site["y"]) == (&rank["x"], &rank["y"]);
            let site = map["sites"].as_array().and_then(|sites| sites.iter().find(at)).expect("the same UAV");
            assert_eq!(rank["los"], site["los"], "{rank}");
        }
    }
    // All five see what the map's union is: the last one has all receivers in range.
    let several = folder.type_in(&format!("place {scene} --candidates sites.csv --count 5 --json -q")).done().json();
    assert_eq!(several["several"]["p_los"], map["union"]["p_los"], "{several}");
}
