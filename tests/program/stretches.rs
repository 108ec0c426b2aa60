//! Exact stretches of flights against single links at many places, and of a raster against its footprints.

use serde_json::json;

use crate::flights::stretches;
use crate::program::Folder;
use crate::support::{Random, is_long};

/// A flight of some legs between whole meters over a rectangle: x, y and height above the datum of its vertices.
fn flight(random: &mut Random, [west, south, east, north]: [i64; 4], n_legs: usize) -> Vec<[i64; 3]> {
    let vertex = |random: &mut Random| [random.within(west, east), random.within(south, north), random.within(2, 70)];
    (0..=n_legs).map(|_| vertex(random)).collect()
}

fn write_flight(folder: &Folder, name: &str, flight: &[[i64; 3]]) {
    let rows: String = flight.iter().map(|[x, y, h]| format!("{x},{y},{h}amsl\n")).collect();
    folder.write(name, &("x,y,h\n".to_string() + &rows));
}

/// Each leg is asked at its 1023 places of 1/1024, which lie on the lattice of footprints of 1/1024 m, one link by one.
#[test]
fn places_along_a_flight_are_in_sight_as_single_links_say() {
    let folder = Folder::new();
    let mut random = Random(60);
    let munich = concat!(env!("CARGO_MANIFEST_DIR"), "/maps/munich.geojson");
    let raster = concat!(env!("CARGO_MANIFEST_DIR"), "/maps/munich_dsm.tif");
    let n_legs = if is_long() { 340 } else { 4 };
    let (mut counts, mut n_asked) = ([0; 3], 0);
    for (scene, [x, y]) in
        [("itu:urban --size 600 --seed 2", [0, 0]), (munich, [691_200, 5_334_500]), (raster, [691_200, 5_334_500])]
    {
        let ground = if scene == raster { " --ground 0" } else { "" };
        let scene = format!("{scene}{ground}");
        let flight = flight(&mut random, [x + 20, y + 20, x + 580, y + 580], n_legs);
        write_flight(&folder, "flight.csv", &flight);
        let (east, north) = (x + random.within(50, 550), y + random.within(50, 550));
        let pilot = format!("{east}.5,{north}.5,71amsl");
        let found = folder.type_in(&format!("track {scene} --uav {pilot} --track flight.csv --json -q")).done().json();
        assert_eq!(found["exact_stretches"], true);
        let stretches = stretches(&found);
        let (mut places, mut at_m, mut before) = (String::from("x,y,h\n"), Vec::new(), 0.0);
        for ends in flight.windows(2) {
            let rise = [0, 1, 2].map(|k| ends[1][k] - ends[0][k]);
            let length = rise.iter().map(|d| (d * d) as f64).sum::<f64>().sqrt();
            for k in 1..1024_i64 {
                let [x, y, h] = [0, 1, 2].map(|c| (ends[0][c] * 1024 + rise[c] * k) as f64 / 1024.0);
                places += &format!("{x},{y},{h}amsl\n");
                at_m.push(before + length * k as f64 / 1024.0);
            }
            before += length;
        }
        folder.write("places.csv", &places);
        let line = format!("link {scene} --uav {pilot} --rxs places.csv --los-only -o links.csv --overwrite -q");
        folder.type_in(&line).done();
        let (los, reason) = (column(&folder, "links.csv", "los"), folder.text("links.csv").contains("reason"));
        assert_eq!(los.len(), at_m.len());
        for (k, (los, at)) in los.iter().zip(&at_m).enumerate() {
            // At an end of a stretch a place may have the state of either.
            let mut of_place = stretches.iter().filter(|(_, from, to)| from + 1e-9 < *at && *at < to - 1e-9);
            let Some((state, ..)) = of_place.next() else { continue };
            let wanted = match state.as_str() {
                "los" => "true",
                "nlos" => "false",
                _ => "",
            };
            assert_eq!(los, wanted, "{scene}: place {k} at {at} m, {state}");
            counts[usize::from(state == "los") + 2 * usize::from(state == "inside")] += 1;
        }
        assert!(reason, "some places of {scene} are inside");
        n_asked += at_m.len();
    }
    assert!(
        counts.iter().sum::<usize>() * 100 > n_asked * 99 && counts.iter().all(|n| *n > n_asked / 100),
        "{counts:?}"
    );
}

#[test]
fn a_raster_and_its_footprints_have_the_same_stretches() {
    let folder = Folder::new();
    let mut random = Random(61);
    let mut n_stretches = 0;
    for n in 0..if is_long() { 400 } else { 12 } {
        // Houses between whole meters, apart from each other, and a raster of cells of 1 m.
        let mut heights = vec![0_i64; 60 * 60];
        let mut features = Vec::new();
        for (row, col) in (0..3).flat_map(|row| (0..3).map(move |col| (row, col))) {
            let (x, y) = (20 * col + random.within(1, 8), 20 * row + random.within(1, 8));
            let (east, north) = (x + random.within(2, 10), y + random.within(2, 10));
            let height = random.within(3, 40);
            let ring = json!([[[x, y], [east, y], [east, north], [x, north], [x, y]]]);
            features.push(json!({"type": "Feature", "properties": {"height": height},
                "geometry": {"type": "Polygon", "coordinates": ring}}));
            for cell in (y..north).flat_map(|y| (x..east).map(move |x| (59 - y) * 60 + x)) {
                heights[usize::try_from(cell).unwrap()] = height;
            }
        }
        let crs = json!({"type": "name", "properties": {"name": "EPSG:25832"}});
        folder
            .write("town.geojson", &json!({"type": "FeatureCollection", "crs": crs, "features": features}).to_string());
        let rows: String =
            heights.chunks(60).map(|row| row.iter().map(i64::to_string).collect::<Vec<_>>().join(" ") + "\n").collect();
        folder.write("town.asc", &format!("ncols 60\nnrows 60\nxllcorner 0\nyllcorner 0\ncellsize 1\n{rows}"));
        // No leg runs along walls: places on a wall are in a cell of the raster, and in no building.
        let runs_along = |flight: &[[i64; 3]]| flight.windows(2).any(|ends| (0..2).any(|k| ends[0][k] == ends[1][k]));
        let mut flights = std::iter::repeat_with(|| flight(&mut random, [0, 0, 60, 60], 6));
        let flight = flights.find(|flight| !runs_along(flight)).unwrap();
        write_flight(&folder, "flight.csv", &flight);
        let (x, y, z) = (random.within(0, 59), random.within(0, 59), random.within(41, 60));
        let of = |scene: &str| {
            let line = format!("track {scene} --uav {x}.5,{y}.5,{z}amsl --track flight.csv --json -q");
            stretches(&folder.type_in(&line).done().json())
        };
        let (prisms, columns) = (of("town.geojson --extent 0,0,60,60"), of("town.asc --ground 0"));
        assert_eq!(prisms.len(), columns.len(), "{n}, {flight:?}: {prisms:?}\n{columns:?}");
        for (a, b) in prisms.iter().zip(&columns) {
            assert!(a.0 == b.0 && (a.1 - b.1).abs() < 1e-6 && (a.2 - b.2).abs() < 1e-6, "{n}: {a:?} {b:?}");
        }
        n_stretches += prisms.len();
    }
    assert!(n_stretches > 40, "{n_stretches}");
}

#[test]
fn places_along_a_flight_are_uavs_of_a_map() {
    let folder = Folder::new();
    write_flight(&folder, "flight.csv", &[[50, 50, 90], [150, 60, 95], [120, 150, 110]]);
    let scene = "itu:urban --size 200";
    folder.type_in(&format!("track {scene} --uav 20,20,80 --track flight.csv --every 10 -o places.csv -q")).done();
    let heights = column(&folder, "places.csv", "height_amsl_m");
    let map = folder.type_in(&format!("map {scene} --uavs places.csv --layers all -o m.png --json -q")).done().json();
    let sites = map["sites"].as_array().unwrap();
    let found: Vec<f64> = sites.iter().map(|site| site["height_amsl_m"].as_f64().unwrap()).collect();
    let wanted: Vec<f64> =
        heights.iter().map(|text| (text.parse::<f64>().unwrap() * 1024.0).round() / 1024.0).collect();
    assert!(found == wanted && found.len() > 20, "{found:?}\n{wanted:?}");
}

/// The texts of a column of a table without quoted cells.
fn column(folder: &Folder, file: &str, name: &str) -> Vec<String> {
    let text = folder.text(file);
    let mut lines = text.lines();
    let k = lines.next().unwrap().split(',').position(|of| of == name).unwrap();
    lines.map(|line| line.split(',').nth(k).unwrap_or_default().to_string()).collect()
}
