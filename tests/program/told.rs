//! What is told of sites, counts, heights and weights: the same in every file, and true.

use std::collections::BTreeMap;

use num_bigint::BigInt;
use serde_json::Value;
use skyshed_io::formats::RasterFile;

use crate::cli_map::{channels, items};
use crate::masks::{MAP, mask_of, npy, tif, town};
use crate::program::Folder;

/// Rows of a table by the names of its columns.
fn rows(folder: &Folder, name: &str) -> Vec<BTreeMap<String, String>> {
    csv::Reader::from_reader(folder.text(name).as_bytes()).deserialize().map(Result::unwrap).collect()
}

/// A block in Munich, and places beside it with names and degrees.
fn square() -> Folder {
    let folder = Folder::new();
    folder.write(
        "block.geojson",
        r#"{"type": "FeatureCollection",
          "crs": {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::25832"}}, "features": [
          {"type": "Feature", "properties": {"height": 12}, "geometry": {"type": "Polygon", "coordinates":
           [[[691420,5334980],[691430,5334980],[691430,5334992],[691420,5334992],[691420,5334980]]]}}]}"#,
    );
    folder.write("sites.csv", "id,lon,lat,h\nchurch,11.5731,48.1395,20\nold market,11.5734,48.1394,15\n");
    folder
}

const SQUARE: &str = "block.geojson --extent 691400,5334970,691460,5335030";

#[test]
fn names_and_degrees_go_into_every_file() {
    let folder = square();
    let sites = [("church", "11.5731", "48.1395"), ("old market", "11.5734", "48.1394")];
    let of_object = |object: &Value, (id, lon, lat): (&str, &str, &str)| {
        assert_eq!(
            (object["id"].as_str(), object["lon"].to_string(), object["lat"].to_string()),
            (Some(id), lon.into(), lat.into())
        );
        assert!(object["x"].as_f64().unwrap() > 691_400.0, "{object}");
    };
    let of_row = |row: &BTreeMap<String, String>, key: &str, (id, lon, lat): (&str, &str, &str)| {
        assert_eq!([&row[key], &row["lon"], &row["lat"]], [id, lon, lat]);
    };
    let files = "-o m.csv -o m.json -o m.geojson --height-curve c.json --zones";
    folder.type_in(&format!("map {SQUARE} --uavs sites.csv {files} -q")).done();
    folder.type_in(&format!("compare {SQUARE} --uavs sites.csv -o k.csv -o k.json -o k.html -o k.tif -q")).done();
    for (k, site) in sites.into_iter().enumerate() {
        of_object(&folder.json("m.json")["sites"][k], site);
        of_object(&folder.json("m.geojson")["features"][k]["properties"], site);
        of_object(&folder.json("c.json")["sites"][k], site);
        of_object(&folder.json("k.json")["placements"][k], site);
        for (file, key) in [("m.csv", "site"), ("k.csv", "first")] {
            let rows = rows(&folder, file);
            of_row(rows.iter().find(|row| row[key] == site.0 && row["zone"] == "all").unwrap(), key, site);
        }
        let cells = format!("<td>{}</td><td>{}</td>", site.1, site.2);
        assert!(folder.text("k.html").contains(&cells), "the page tells the degrees of {}", site.0);
    }
    // A curve names what the UAV hovers over as a map does, though it alone was asked for.
    folder.type_in(&format!("map {SQUARE} --uavs sites.csv --height-curve alone.json --zones -q")).done();
    for file in ["c.json", "alone.json"] {
        let placement = |name: &str, k: usize| folder.json(name)["sites"][k]["placement"].clone();
        assert!((0..2).all(|k| placement(file, k) == "street" && placement("m.json", k) == "street"), "{file}");
    }
    // Pictures tell degrees beside coordinates, and so do charts.
    folder.type_in(&format!("map {SQUARE} --uavs sites.csv -o degrees.svg --height-curve heights.svg -q")).done();
    for name in ["degrees.svg", "heights.svg"] {
        assert!(folder.text(name).contains("; 11.5731°, 48.1395°)"), "{name}");
    }
    let line = format!("chart {SQUARE} --cell 6 --uavs sites.csv --time 0 --json -q");
    let charted = folder.type_in(&line).done().json();
    assert_eq!((&charted["uavs"][0]["lon"], &charted["uavs"][0]["lat"]), (&11.5731.into(), &48.1395.into()));
    // Saved maps know where their UAVs were.
    folder.type_in(&format!("map {SQUARE} --uavs sites.csv -o both.tif -q")).done();
    let saved = folder.type_in(&format!("compare {SQUARE} --mask both.tif --json -q")).done().json();
    let second = &saved["placements"][1];
    assert_eq!((&second["id"], &second["lon"]), (&"both.old market".into(), &11.5734.into()));
    // What was given in the scene's own coordinates has no others.
    folder.write("plain.csv", "id,x,y,h\na,691405,5334975,20\nb,691450,5335020,20\n");
    folder.type_in(&format!("map {SQUARE} --uavs plain.csv -o p.csv -o p.json -q")).done();
    assert!(!folder.text("p.csv").contains("lon") && folder.json("p.json")["sites"][0].get("lon").is_none());
}

#[test]
fn candidates_keep_their_names() {
    let folder = square();
    let files = "-o p.csv -o p.json -o p.geojson --map w.tif";
    let said = folder.type_in(&format!("place {SQUARE} --candidates sites.csv -k 2 {files}")).done().err;
    assert!(said.contains("above ground at church (") && said.contains(", old market ("), "{said}");
    let table = rows(&folder, "p.csv");
    let told: Vec<[&str; 4]> =
        table.iter().map(|row| ["kind", "rank", "lon", "lat"].map(|key| row[key].as_str())).collect();
    let document = folder.json("p.json");
    let ids: Vec<&str> = table.iter().map(|row| row["id"].as_str()).collect();
    let chosen: Vec<&str> =
        document["several"]["chosen"].as_array().unwrap().iter().map(|c| c["id"].as_str().unwrap()).collect();
    let ranked: Vec<&str> = document["ranked"].as_array().unwrap().iter().map(|c| c["id"].as_str().unwrap()).collect();
    assert_eq!(ids, [chosen.clone(), ranked].concat());
    assert_eq!((told[0][0], told[1][0], told[2][0]), ("chosen", "chosen", "candidate"));
    let degrees = |id: &str| if id == "church" { ["11.5731", "48.1395"] } else { ["11.5734", "48.1394"] };
    assert!(table.iter().zip(&told).all(|(row, told)| told[2..] == degrees(&row["id"])), "{told:?}");
    assert_eq!(document["winner"]["lon"].to_string(), degrees(document["winner"]["id"].as_str().unwrap())[0]);
    // As points they may be UAVs of a map: no id occurs twice.
    folder.type_in(&format!("map {SQUARE} --uavs p.geojson -o all.json -q")).done();
    let of_points: Vec<Value> =
        folder.json("all.json")["sites"].as_array().unwrap().iter().map(|site| site["id"].clone()).collect();
    assert_eq!(of_points[..2], chosen.iter().map(|id| Value::from(*id)).collect::<Vec<_>>());
    let band = |k: usize, id: &str| format!("sample=\"{k}\" role=\"description\">{id}.los<");
    let items = items(&tif(&folder, "w.tif"));
    assert!(items.contains(&band(0, chosen[0])) && items.contains(&band(1, chosen[1])), "{items}");
    // Both shares are of all receivers of the goal, and both say so: 60 × 60 cells without the 10 × 12 of the block.
    let within = format!("place {SQUARE} --candidates sites.csv -k 2 --radius 30 --receivers street -o r.csv");
    let said = folder.type_in(&within).done().err;
    let of_all = ["of 3480 street receivers, in range or not\n", "of all street receivers, in range or not;"];
    assert!(of_all.iter().all(|words| said.contains(words)), "{said}");
    // On a grid they have none.
    folder.type_in(&format!("place {SQUARE} --height 20 --step 30 -o g.csv -q")).done();
    assert!(folder.text("g.csv").starts_with("kind,rank,x,y,height_amsl_m,"));
}

#[test]
fn a_count_is_null_where_nobody_receives() {
    let folder = town();
    let two = format!("{MAP} --uav 691650,5334780,60 --radius 30");
    folder.type_in(&format!("{two} --layers count -o c.tif -o c.exr -o c.asc -o c.bil -o c.npz -q")).done();
    folder.type_in(&format!("{two} --layers count,which -o sets.tif -q")).done();
    folder.type_in(&format!("{two} -o both.tif -q")).done();
    let both = tif(&folder, "both.tif");
    let masks: Vec<Vec<u8>> = (0..2).map(|k| both.read_band::<u8>(k).unwrap().into_iter().collect()).collect();
    let wanted: Vec<Option<u32>> = (0..masks[0].len())
        .map(|cell| {
            let classes = [masks[0][cell], masks[1][cell]];
            let is_received = classes.iter().any(|class| *class <= 1);
            is_received.then(|| classes.iter().filter(|class| **class == 1).count().try_into().unwrap())
        })
        .collect();
    assert!(wanted.contains(&None) && wanted.contains(&Some(0)) && wanted.contains(&Some(2)), "all kinds occur");

    for name in ["c.tif", "sets.tif"] {
        let file = tif(&folder, name);
        assert_eq!(file.nodata(), Some("4294967295"), "{name}");
        let values: Vec<u32> = file.read_band::<u32>(0).unwrap().into_iter().collect();
        assert!(values.iter().zip(&wanted).all(|(found, wanted)| *found == wanted.unwrap_or(u32::MAX)), "{name}");
    }
    let (header, of_npz) = npy(&folder, "c.npz", "count");
    assert!(header.contains("'<u4'") && folder.text("c.hdr").contains("4294967295"), "{header}");
    for bytes in [of_npz, folder.read("c.bil")] {
        let values = bytes.chunks_exact(4).map(|b| u32::from_le_bytes(b.try_into().unwrap()));
        assert!(values.zip(&wanted).all(|(found, wanted)| found == wanted.unwrap_or(u32::MAX)));
    }
    let exr::prelude::FlatSamples::F32(found) = &channels(&folder, "c.exr")[0].1 else { panic!("floats") };
    let is_it = |(found, wanted): (&f32, &Option<u32>)| match wanted {
        Some(n) => f64::from(*found).to_bits() == f64::from(*n).to_bits(),
        None => found.is_nan(),
    };
    assert!(found.iter().zip(&wanted).all(is_it));
    let file = RasterFile::open(folder.join("c.asc"), &mut Vec::new()).unwrap();
    let of_asc = file.read(file.georef().window(), &mut Vec::new(), |v| v).unwrap().into_cells();
    let is_it = |(v, wanted): (&f64, &Option<u32>)| wanted.map_or(v.is_nan(), |n| v.total_cmp(&n.into()).is_eq());
    assert!(of_asc.iter().zip(&wanted).all(is_it));
    // The set of 32 UAVs is the nodata of counts.
    let many: String = (0..32).map(|k| format!(" --uav {},5334755,40", 691_601 + k)).collect();
    let line = format!("map town.geojson --extent 691600,5334750,691660,5334790{many} --layers count,which -o n.tif");
    folder.refuses(&line, "E107", &["n.tif", "`count` beside `which`"]);
}

#[test]
fn a_least_height_is_minus_infinity_exactly_where_nothing_limits_it() {
    let folder = Folder::new();
    let cells = "0 0 0 0 0 0\n0 0 9 9 0 0\n0 0 0 0 0 0\n";
    folder.write("wall.asc", &format!("ncols 6\nnrows 3\nxllcorner 0\nyllcorner 0\ncellsize 10\n{cells}"));
    let least = |uav: &str, name: &str| -> Vec<f32> {
        let line =
            format!("map wall.asc --uav {uav} --layers least-height -o {name}.npz -o {name}.tif -o {name}.exr -q");
        folder.type_in(&line).done();
        let (_, bytes) = npy(&folder, &format!("{name}.npz"), "least_height");
        let of_npz: Vec<f32> = bytes.chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect();
        let exr::prelude::FlatSamples::F32(of_exr) = &channels(&folder, &format!("{name}.exr"))[0].1 else { panic!() };
        let of_tif: Vec<f32> = tif(&folder, &format!("{name}.tif")).read_band::<f32>(0).unwrap().into_iter().collect();
        for k in 0..of_npz.len() {
            assert_eq!(of_npz[k].to_bits(), of_exr[k].to_bits());
            assert_eq!(of_npz[k].clamp(-32768.0, 32768.0).to_bits(), of_tif[k].to_bits(), "cell {k}");
        }
        of_npz
    };
    // Beside the raster no surface is known, and nothing is between the UAV and the first cells of each row. To reach the
    // others a link has to pass over cells, if only over ground 1.5 m below it.
    let beside = least("-15,15,50amsl", "beside");
    for (cell, v) in beside.iter().enumerate() {
        assert_eq!(v.is_infinite() && *v < 0.0, cell % 6 == 0, "cell {cell}: {beside:?}");
    }
    assert!(beside[10] > 50.0 && beside.iter().all(|v| *v < f32::INFINITY), "{beside:?}");
    // Over the raster it is never below the surface there, whoever is seen.
    let over = least("5,15,50", "over");
    assert!(over[6] <= 0.0 && over[0] <= 0.0 && over.iter().all(|v| *v >= 0.0), "{over:?}");
}

const SHIFT: i32 = 200;

/// A number times 2^[`SHIFT`], which is whole.
fn shifted(number: f64) -> BigInt {
    let bits = number.to_bits();
    let exponent = i32::try_from(bits >> 52).unwrap() - 1075;
    assert!(bits == 0 || exponent > -SHIFT, "{number}");
    let mantissa = if bits == 0 { 0 } else { bits & ((1 << 52) - 1) | (1 << 52) };
    BigInt::from(mantissa) << (exponent + SHIFT).max(0)
}

#[test]
fn weighted_shares_are_those_of_exact_sums() {
    let folder = Folder::new();
    folder.write(
        "city.geojson",
        r#"{"type": "FeatureCollection", "features": [
          {"type": "Feature", "properties": {"height": 20}, "geometry": {"type": "Polygon",
           "coordinates": [[[20,20],[30,20],[30,30],[20,30],[20,20]]]}},
          {"type": "Feature", "properties": {"height": 9}, "geometry": {"type": "Polygon",
           "coordinates": [[[5,5],[15,5],[15,12],[5,12],[5,5]]]}}]}"#,
    );
    // Half the people live in one cell, the others are tenths.
    let weight = |cell: usize| match cell {
        77 => 1e9,
        _ => f64::from(u32::try_from(cell * 7 % 13).unwrap()) / 10.0,
    };
    let values = (0..2500).map(|cell| weight(cell).to_string()).collect::<Vec<_>>().join(" ");
    folder.write("people.asc", &format!("ncols 50\nnrows 50\nxllcorner 0\nyllcorner 0\ncellsize 1\n{values}\n"));
    let scene = "city.geojson --extent 0,0,50,50";
    for radius in ["", "--radius 20"] {
        let line =
            format!("place {scene} --step 10 --height 12 --goal p_los(weights) --weights people.asc {radius} --top 25");
        let found = folder.type_in(&format!("{line} --json -o p.csv --overwrite -q")).done().json();
        for threads in [1, 2] {
            let again = folder.type_in(&format!("{line} --json -q -j {threads}")).done().json();
            assert_eq!((&again["ranked"], &again["digest"]), (&found["ranked"], &found["digest"]));
        }
        let mut without_the_large_one = 0;
        // The table, as the parser of JSON may be off by a last digit.
        for place in rows(&folder, "p.csv").iter().filter(|row| row["kind"] == "candidate") {
            let at = ["x", "y", "height_agl_m"].map(|key| place[key].as_str()).join(",");
            folder.type_in(&format!("map {scene} --uav {at} {radius} -o m.tif --overwrite -q")).done();
            let mask = mask_of(&folder, "m.tif");
            // Receivers out of range are wanted too.
            folder.type_in(&format!("map {scene} --uav {at} -o all.tif --overwrite -q")).done();
            let all = mask_of(&folder, "all.tif");
            let sum = |mask: &[u8], most: u8, least: u8| -> BigInt {
                let cells = (0..2500).filter(|cell| (least..=most).contains(&mask[*cell]));
                cells.map(|cell| shifted(weight(cell))).sum()
            };
            let (seen, wanted) = (sum(&mask, 1, 1), sum(&all, 1, 0));
            // No other double is nearer.
            let told: f64 = place["p_los"].parse().unwrap();
            let distance = |share: f64| (shifted(share) * &wanted - (&seen << SHIFT)).magnitude().clone();
            let neighbors = [told.next_up(), told.next_down()];
            assert!(neighbors.iter().all(|other| distance(told) <= distance(*other)), "{place:?}");
            without_the_large_one += u32::from(mask[77] > 1);
        }
        assert!(radius.is_empty() || without_the_large_one > 3, "some places count tenths alone");
    }
}
