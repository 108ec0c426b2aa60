//! P_LoS against the UAV's height: the curve counts what maps made at each height count, to the last receiver.

use serde_json::{Value, json};
use skyshed_core::city::Ground;
use skyshed_core::coverage::{
    Control, HeightCurve, HeightLayers, MapOptions, Mapper, Receivers, SiteCoverage, Uav, map_site,
};
use skyshed_core::height_field::{HeightField, Station};
use skyshed_core::los::{columns_least_height, columns_least_step, prisms_least_height, prisms_least_step};
use skyshed_core::quantity::{BLOCKS_ALL, VOID};
use skyshed_core::raster::GeoRef;

use crate::invariants::{raster_town, uav_at, uavs, vector_town};
use crate::oracle::Columns;
use crate::program::Folder;
use crate::refusals::check_refusals;
use crate::shapes::{M, moved, random_columns, random_end, random_prism_end, random_prisms};
use crate::support::{Random, surface_field};
use crate::translation::{columns_of, point, prisms_of};

fn options(receivers: Receivers, radius: Option<f64>) -> MapOptions {
    MapOptions { receivers, radius, ..MapOptions::default() }
}

fn map_at(field: &HeightField, uav: &Uav, options: &MapOptions, z: i32) -> SiteCoverage {
    let raised = Uav { station: Station { z: i64::from(z), ..uav.station }, ..uav.clone() };
    map_site(field, &raised, options, &Control::default()).unwrap()
}

fn curve_of(field: &HeightField, map: &SiteCoverage, options: &MapOptions) -> HeightCurve {
    let mapper = Mapper::new(field, options).unwrap();
    mapper.seen_from(&map.uav).unwrap().height_curve(&Control::default()).unwrap()
}

/// Compares a curve with maps at its lowest height, at heights among its steps, and at one step below each of those.
fn check(field: &HeightField, uav: &Uav, options: &MapOptions, random: &mut Random, n_heights: usize) -> HeightCurve {
    let curve = curve_of(field, &map_site(field, uav, options, &Control::default()).unwrap(), options);
    let lowest = curve.lowest_height().max(-20 * 1024);
    let mut heights = vec![lowest, lowest + 1, 1 << 25];
    for _ in 0..n_heights {
        let (step, before) = match random.below(curve.steps().len()) {
            0 => (curve.steps()[0].0, 0),
            k => (curve.steps()[k].0, curve.steps()[k - 1].1),
        };
        assert!(curve.los_at(step) > before && curve.los_at(step - 1) == before);
        heights.extend([step, step - 1]);
    }
    for z in heights.into_iter().filter(|z| *z >= lowest) {
        let found = map_at(field, uav, options, z).tally;
        assert_eq!((curve.los_at(z), curve.receivers()), (found.los, found.receivers), "{uav:?} at {z}");
        assert_eq!(curve.p_los_at(z), found.p_los());
    }
    curve
}

#[test]
fn the_curve_counts_what_a_map_at_each_height_counts() {
    let mut random = Random(31);
    let mut n_steps = 0;
    for field in [raster_town(&mut random, 40), vector_town(&mut random, 42)] {
        for uav in uavs(&field, &mut random) {
            for (receivers, radius) in
                [(Receivers::Ground, None), (Receivers::Roof, None), (Receivers::All, Some(30.0))]
            {
                n_steps += check(&field, &uav, &options(receivers, radius), &mut random, 12).steps().len();
            }
        }
    }
    assert!(n_steps > 5000, "{n_steps}");
}

#[test]
fn the_curve_does_not_depend_on_the_height_asked_for_or_on_threads() {
    let mut random = Random(32);
    for field in [raster_town(&mut random, 40), vector_town(&mut random, 42)] {
        let options = options(Receivers::All, None);
        let uav = uav_at(&field, field.grid().x_min() + 20.5, field.grid().y_min() + 20.5, 30 * M);
        let curves = [(1, 30 * 1024), (2, 13 * 1024), (7, 900 * 1024)].map(|(n_threads, z)| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
            pool.install(|| curve_of(&field, &map_at(&field, &uav, &options, z), &options))
        });
        for other in &curves[1..] {
            assert_eq!(curves[0].steps(), other.steps());
            assert_eq!(curves[0].lowest_height(), other.lowest_height());
        }
    }
}

/// Random towers on a plateau 20 km above the datum, where neighboring f32 are two lattice steps apart.
fn plateau(random: &mut Random) -> HeightField {
    let ground = 20_000 * 1024 + 1;
    let grid = GeoRef::new((0.0, 24.0), (1.0, 1.0), (24, 24), None).unwrap();
    let height = |random: &mut Random| match random.within(0, 5) {
        0 => ground + i32::try_from(random.within(300, 30_000)).unwrap(),
        _ => ground,
    };
    let cells = (0..24 * 24).map(|_| height(random)).collect::<Vec<_>>();
    surface_field(&grid, cells, Ground::Flat(ground))
}

#[test]
fn the_curve_is_exact_where_single_precision_is_not() {
    let mut random = Random(33);
    let field = plateau(&mut random);
    let uav = uav_at(&field, 12.5, 12.5, 20_100 * M);
    let layers = HeightLayers { least_height: true, ..HeightLayers::default() };
    let options = MapOptions { layers, ..options(Receivers::Ground, None) };
    let curve = check(&field, &uav, &options, &mut random, 60);
    // The layer of least heights, an f32, puts receivers into sight one step too early or too late.
    let layer = map_site(&field, &uav, &options, &Control::default()).unwrap().least_height.unwrap();
    let rounded = |z: i32| layer.iter().filter(|h| f64::from(**h) * 1024.0 <= f64::from(z)).count() as u64;
    let n_wrong = curve.steps().iter().filter(|s| rounded(s.0) != s.1 || rounded(s.0 - 1) != curve.los_at(s.0 - 1));
    assert!(n_wrong.count() > 50, "single precision would do");
}

#[test]
fn the_least_step_is_the_lowest_lattice_height_that_meets_the_least_height() {
    let mut random = Random(34);
    let mut n_bound = 0;
    for _ in 0..10_000 {
        let columns = columns_of(&random_columns(&mut random));
        let shape = Columns { n_cols: columns.n_cols(), n_rows: columns.n_rows(), heights: Vec::new() };
        let (uav, receiver) = (point(random_end(&mut random, &shape)), point(random_end(&mut random, &shape)));
        let floor = random.within(-2000, 9000);
        let least = columns_least_height(&columns, uav, receiver);
        let step = columns_least_step(&columns, uav, receiver, floor);
        assert_eq!(step, least.lowest_step().map(|z| z.max(floor)), "{columns:?} {uav:?} {receiver:?}");
        let prisms = prisms_of(&moved(&random_prisms(&mut random), |p| p, |top| top * M));
        let raised = |[x, y, z]: [i64; 3]| point([x, y, z * M]);
        let (uav, receiver) = (raised(random_prism_end(&mut random)), raised(random_prism_end(&mut random)));
        let of_prisms = prisms_least_height(&prisms, uav, receiver);
        let step = prisms_least_step(&prisms, uav, receiver, floor);
        assert_eq!(step, of_prisms.lowest_step().map(|z| z.max(floor)), "{prisms:?} {uav:?} {receiver:?}");
        for least in [least, of_prisms] {
            match least.lowest_step() {
                None => assert!(!least.is_met_by(1 << 26)),
                Some(i64::MIN) => assert!(least.is_met_by(-(1 << 26))),
                Some(z) => assert!(least.is_met_by(z) && !least.is_met_by(z - 1), "{z} {least:?}"),
            }
            n_bound += u32::from(least.lowest_step().is_some_and(|z| z > floor));
        }
    }
    assert!(n_bound > 3000, "{n_bound}");
}

#[test]
fn quantiles_are_the_least_heights_that_reach_their_share() {
    let mut random = Random(35);
    let field = vector_town(&mut random, 42);
    let uav = uav_at(&field, 20.5, 20.5, 30 * M);
    let options = options(Receivers::Ground, None);
    let curve = check(&field, &uav, &options, &mut random, 0);
    assert_eq!(curve.least_height_reaching(0), Some(curve.lowest_height()));
    for percent in [1, 10, 50, 90, 99, 100] {
        let Some(height) = curve.least_height_reaching(percent) else {
            assert!(curve.never_los() > 0 && (curve.receivers() - curve.never_los()) * 100 < curve.receivers() * 100);
            continue;
        };
        let reaches = |z: i32| curve.los_at(z) * 100 >= curve.receivers() * u64::from(percent);
        assert!(reaches(height) && (height == curve.lowest_height() || !reaches(height - 1)));
    }
    // Without a receiver nothing is reached.
    let nobody = MapOptions { radius: Some(0.1), receivers: Receivers::Roof, ..options };
    let uav = uav_at(&field, 0.0, 0.0, 30 * M);
    let curve = curve_of(&field, &map_site(&field, &uav, &nobody, &Control::default()).unwrap(), &nobody);
    assert_eq!((curve.receivers(), curve.p_los_at(30 * 1024), curve.least_height_reaching(50)), (0, None, None));
}

#[test]
fn a_wall_that_blocks_everything_is_never_overcome() {
    // Three cells: the receiver in the west is behind nodata that blocks everything.
    let grid = GeoRef::new((0.0, 1.0), (1.0, 1.0), (1, 3), None).unwrap();
    let field = surface_field(&grid, vec![0, BLOCKS_ALL, 0], Ground::Flat(0));
    assert_ne!(field.ground_at(&field.place(2.5, 0.5)), VOID);
    let uav = uav_at(&field, 2.5, 0.5, 10 * M);
    let options = options(Receivers::Ground, None);
    let curve = curve_of(&field, &map_at(&field, &uav, &options, 10 * 1024), &options);
    assert_eq!((curve.receivers(), curve.never_los(), curve.los_at(1 << 25)), (2, 1, 1));
    assert_eq!((curve.least_height_reaching(50), curve.least_height_reaching(51)), (Some(0), None));
}

// ---------------------------------------------------------------------------------------------------------------------
// On the command line.

/// A wall of 20 m over x 20…22 among 50 × 20 cells.
const WALL: &str = r#"{"type": "FeatureCollection", "features": [
  {"type": "Feature", "properties": {"height": 20},
   "geometry": {"type": "Polygon", "coordinates": [[[20,0],[22,0],[22,20],[20,20],[20,0]]]}}]}"#;
const MAP: &str = "map wall.geojson --extent 0,0,50,20 --uav 5,10,30";

fn wall() -> Folder {
    let folder = Folder::new();
    folder.write("wall.geojson", WALL);
    folder
}

fn rows(folder: &Folder, name: &str) -> Vec<Vec<String>> {
    let text = folder.text(name);
    let mut table = csv::ReaderBuilder::new().has_headers(false).from_reader(text.as_bytes());
    table.records().map(|r| r.unwrap().iter().map(str::to_string).collect()).collect()
}

#[test]
fn table_document_and_plot_of_a_curve_agree_with_maps() {
    let folder = wall();
    let curve = "--height-curve c.csv --height-curve c.json --height-curve c.png --height-curve c.svg";
    let answer = folder.type_in(&format!("{MAP} --uav 21,10,3roof {curve} --curve-heights 0:50:12.5")).done();
    assert!(answer.err.contains("UAV 1: half of the receivers from"), "{answer:?}");
    assert!(answer.warnings().contains(&"W203"), "{answer:?}");
    let files = ["c.csv", "c.csv.json", "c.json", "c.png", "c.svg", "wall.geojson"];
    assert_eq!(folder.files(), files);

    let table = rows(&folder, "c.csv");
    assert_eq!(table[0], ["site", "height_agl_m", "height_amsl_m", "receivers", "los", "p_los"]);
    let of_site = |id: &str| -> Vec<&Vec<String>> { table.iter().filter(|row| row[0] == id).collect() };
    assert_eq!((table.len(), of_site("1").len(), of_site("2").len()), (11, 5, 5));
    let document = folder.json("c.json");
    assert_eq!((&document["schema"], &document["method"]), (&json!("skyshed/height-curve/1"), &json!("shadow")));
    assert_eq!(document["command"][0], "map");
    assert_eq!(folder.json("c.csv.json")["digest"], document["digest"]);
    for (k, site) in document["sites"].as_array().unwrap().iter().enumerate() {
        let points = site["curve"].as_array().unwrap();
        for (point, row) in points.iter().zip(of_site(&(k + 1).to_string())) {
            let text = |v: &Value| if v.is_null() { String::new() } else { v.to_string() };
            let number = |v: &Value| v.as_f64().map_or(String::new(), |v| v.to_string());
            assert_eq!(row[1..3], [number(&point["height_agl_m"]), number(&point["height_amsl_m"])]);
            assert_eq!(row[3..5], [text(&point["receivers"]), text(&point["los"])]);
            assert_eq!(row[5], number(&point["p_los"]));
        }
    }
    // Every row is what a map at that height says; below the roof the second UAV cannot be.
    for (x, id) in [("5", "1"), ("21", "2")] {
        for row in of_site(id) {
            let line = format!("map wall.geojson --extent 0,0,50,20 --uav {x},10,{} --json -q", row[1]);
            if id == "2" && row[1].parse::<f64>().unwrap() < 20.0 {
                assert_eq!(row[4..6], ["", ""]);
                folder.type_in(&line).refused(4);
                continue;
            }
            let site = folder.type_in(&line).done().json()["sites"][0].clone();
            let wanted = [&site["receivers"], &site["los"], &site["p_los"]].map(|v| v.as_f64().unwrap().to_string());
            assert_eq!(row[3..6], wanted);
        }
    }
    // At the least height of a share a map reaches it; 1/1024 m lower it does not.
    let half = &document["sites"][0]["least_heights"].as_array().unwrap()[3];
    assert_eq!(half["p_los"], 0.5);
    let p_los = |height: f64| {
        let line = format!("map wall.geojson --extent 0,0,50,20 --uav 5,10,{height} --json -q");
        folder.type_in(&line).done().json()["sites"][0]["p_los"].as_f64().unwrap()
    };
    let least = half["height_agl_m"].as_f64().unwrap();
    assert!(p_los(least) >= 0.5 && p_los(least - 1.0 / 1024.0) < 0.5);

    let site = &document["sites"][1];
    assert_eq!((&site["placement"], &site["lowest_height_agl_m"]), (&json!("rooftop"), &json!(20.0)));
    assert_eq!(site["curve"][0]["reason"], "below the surface under the UAV");
    let svg = folder.text("c.svg");
    for words in ["UAV height above ground [m]", ">UAV 1<", ">UAV 2<", "at 30 m", "at 23 m", "<polyline"] {
        assert!(svg.contains(words), "{words}");
    }
    let png = png::Decoder::new(std::io::Cursor::new(folder.read("c.png"))).read_info().unwrap();
    let text: Vec<String> = png.info().utf8_text.iter().map(|t| t.get_text().unwrap()).collect();
    assert!(text.iter().any(|t| t.contains(document["digest"].as_str().unwrap())), "{text:?}");
}

#[test]
fn the_heights_of_a_curve_are_chosen_or_asked_for() {
    let folder = wall();
    folder.type_in(&format!("{MAP} --height-curve a.csv -q")).done();
    let table = rows(&folder, "a.csv");
    let heights: Vec<f64> = table[1..].iter().map(|row| row[1].parse().unwrap()).collect();
    assert!((75..=160).contains(&heights.len()), "{}", heights.len());
    assert!(heights[0] >= 0.0 && heights[0] < 1.0 && heights[heights.len() - 1] >= 30.0, "{heights:?}");
    assert!(heights.windows(2).all(|w| w[0] < w[1]));
    // Both ends are included, and one height alone is a table too.
    for (range, wanted) in
        [("10:40:20", vec![10.0, 30.0, 40.0]), ("7.5:7.5:1", vec![7.5]), ("-5:1:3", vec![-5.0, -2.0, 1.0])]
    {
        folder.type_in(&format!("{MAP} --height-curve a.csv --curve-heights {range} --overwrite -q")).done();
        let found: Vec<f64> = rows(&folder, "a.csv")[1..].iter().map(|row| row[1].parse().unwrap()).collect();
        assert!(
            found.iter().zip(&wanted).all(|(a, b)| (a - b).abs() < 1e-9) && found.len() == wanted.len(),
            "{found:?}"
        );
    }
    // Where no ground is known heights are above the datum.
    folder.write("row.asc", "ncols 3\nnrows 1\nxllcorner 0\nyllcorner 0\ncellsize 10\n0 5 0\n");
    folder.write("low.asc", "ncols 3\nnrows 1\nxllcorner 0\nyllcorner 0\ncellsize 10\n0 0 0\n");
    let line = "map row.asc --terrain low.asc --uav -5,5,40amsl --height-curve b.csv --height-curve b.svg -q";
    folder.type_in(&format!("{line} --curve-heights 0:40:40")).done();
    assert_eq!(rows(&folder, "b.csv")[2][..3], ["1", "", "40"]);
    assert!(folder.text("b.svg").contains("UAV height above the datum [m]"));
}

#[test]
fn what_makes_no_sense_of_a_curve_is_refused() {
    let folder = wall();
    folder.write("there.svg", "mine");
    let cases = [
        ("--height-curve a.tif", "E105", "a.tif"),
        ("--height-curve -", "E105", "write -"),
        ("--height-curve a.csv -o a.csv", "E105", "a.csv: it is named twice"),
        ("--height-curve a.csv --height-curve a.csv", "E105", "a.csv: it is named twice"),
        ("--height-curve there.svg", "E106", "there.svg"),
        ("--height-curve a.csv --title T", "E116", "`--title`"),
        ("--json --curve-heights 0:10:1", "E101", "--height-curve"),
        ("--height-curve a.csv --curve-heights 0:10", "E101", "'0:10'"),
        ("--height-curve a.csv --curve-heights 0:nan:1", "E101", "'0:nan:1'"),
        ("--height-curve a.csv --curve-heights 9:1:1", "E113", "`9:1:1`"),
        ("--height-curve a.csv --curve-heights 0:9:0", "E113", "`0:9:0`"),
        // Three heights are no range.
        ("--height-curve a.csv --curve-heights 30:60:100", "E113", "`30:60:100`"),
        ("--height-curve a.csv --curve-heights 0:9e9:1", "E113", "`0:9000000000:1`"),
        ("--height-curve a.csv --curve-heights 0:9:1e-9", "E113", "`0:9:0.000000001`"),
    ];
    check_refusals(&folder, MAP, &cases);
    // A title is drawn where there is a plot.
    folder.type_in(&format!("{MAP} --height-curve t.svg --title Over-the-wall -q")).done();
    assert!(folder.text("t.svg").contains(">Over-the-wall<"));
}
