//! Reference systems: what they are called, where PROJ puts places in them, and what their meters are.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use skyshed_io::crs;

use crate::needs::truth;
use crate::program::Folder;

/// A house of 20 m as GeoJSON; `crs` is the name of the reference system, none without one.
fn houses(crs: Option<&str>, rings: &[Vec<[f64; 2]>]) -> String {
    let feature = |ring: &Vec<[f64; 2]>| {
        json!({"type": "Feature", "properties": {"height": 20},
            "geometry": {"type": "Polygon", "coordinates": [ring]}})
    };
    let mut set = json!({"type": "FeatureCollection", "features": rings.iter().map(feature).collect::<Vec<_>>()});
    if let Some(name) = crs {
        set["crs"] = json!({"type": "name", "properties": {"name": name}});
    }
    set.to_string()
}

/// A rectangle as a ring.
fn rectangle([west, south, east, north]: [f64; 4]) -> Vec<[f64; 2]> {
    vec![[west, south], [east, south], [east, north], [west, north], [west, south]]
}

fn shared(case: &str) -> Option<PathBuf> {
    truth().map(|folder| folder.join("cases").join(case))
}

fn copy(from: &Path, folder: &Folder) {
    for entry in std::fs::read_dir(from).expect("a case").map(|entry| entry.expect("a file")) {
        std::fs::copy(entry.path(), folder.join(&entry.file_name().to_string_lossy())).expect("a copy");
    }
}

/// Positions are those of PROJ 9.5.1 without grids (`tests/tools/systems.py`).
#[test]
fn names_and_codes_mean_what_proj_makes_of_them() {
    let table = include_str!("../systems.csv");
    let wgs84 = crs::from_epsg(4326).expect("WGS 84");
    let (mut names, mut n_rows) = (std::collections::BTreeSet::new(), 0);
    for line in table.lines().skip(1) {
        // Names may hold commas.
        let (name, numbers) = line.rsplit_once("\",").expect("a quoted name");
        let name = name.trim_start_matches('"');
        let numbers: Vec<f64> = numbers.split(',').map(|number| number.parse().expect("a number")).collect();
        let [lon, lat, x, y, within_m] = numbers[..] else { panic!("{line}") };
        let crs = crs::parse(name).unwrap_or_else(|error| panic!("{name}: {error}"));
        let found = crs::transform(&wgs84, &crs, (lon, lat)).unwrap_or_else(|error| panic!("{line}: {error}"));
        let is_geographic = matches!(crs.kind(), skyshed_core::raster::CrsKind::Geographic);
        let unit = if is_geographic { 111_195.0 } else { crs.meters_per_unit() };
        let off_m = (found.0 - x).hypot(found.1 - y) * unit;
        assert!(off_m <= within_m, "{name} at {lon}, {lat}: {found:?}, wanted ({x}, {y}), {off_m} m apart");
        let back = crs::transform(&crs, &wgs84, found).unwrap_or_else(|error| panic!("{line}: {error}"));
        let turn = (back.0 - lon + 540.0).rem_euclid(360.0) - 180.0;
        assert!(turn.abs().max((back.1 - lat).abs()) < 1e-7, "{name}: {back:?}, wanted ({lon}, {lat})");
        names.insert(name.to_string());
        n_rows += 1;
    }
    assert!(names.len() >= 30 && n_rows == 5 * names.len(), "{} names, {n_rows} places", names.len());
}

#[test]
fn a_file_may_call_its_system_as_surveys_and_the_ogc_do() {
    let folder = Folder::new();
    let house = rectangle([691_600.0, 5_334_700.0, 691_620.0, 5_334_730.0]);
    for (name, code) in [
        ("urn:adv:crs:ETRS89_UTM32*DE_DHHN2016_NH", 25832),
        ("ETRS89_UTM32", 25832),
        ("urn:adv:crs:DE_DHDN_3GK4*DE_DHHN12_NOH", 31468),
        ("http://www.opengis.net/gml/srs/epsg.xml#25832", 25832),
        (
            "http://www.opengis.net/def/crs-compound?1=http://www.opengis.net/def/crs/EPSG/0/25832&2=http://www.opengis.net/def/crs/EPSG/0/7837",
            25832,
        ),
        ("urn:ogc:def:crs,crs:EPSG:6.12:25832,crs:EPSG:6.12:5783", 25832),
    ] {
        folder.write("named.geojson", &houses(Some(name), std::slice::from_ref(&house)));
        folder.write("plain.geojson", &houses(None, std::slice::from_ref(&house)));
        let wanted = Value::from(format!("EPSG:{code}"));
        assert_eq!(folder.type_in("info named.geojson --json").done().json()["crs"], wanted, "{name}");
        let typed = folder.run(&["info", "plain.geojson", "--crs", name, "--json"]).done().json();
        assert_eq!(typed["crs"], wanted, "--crs {name}");
    }
}

/// Two houses at Oslo, 100 m apart, in web Mercator: lengths there are 1.994 times as long.
fn houses_in_mercator() -> String {
    let (wgs84, utm) = (crs::from_epsg(4326).unwrap(), crs::from_epsg(32632).unwrap());
    let mercator = crs::from_epsg(3857).unwrap();
    let ring = |corners: [f64; 4]| {
        let place = |[x, y]: [f64; 2]| {
            let lonlat = crs::transform(&utm, &wgs84, (x, y)).unwrap();
            <[f64; 2]>::from(crs::transform(&wgs84, &mercator, lonlat).unwrap())
        };
        rectangle(corners).into_iter().map(place).collect::<Vec<_>>()
    };
    houses(Some("ESRI:102100"), &[HOUSE_EAST, HOUSE_WEST].map(ring))
}

const HOUSE_EAST: [f64; 4] = [597_908.0, 6_642_662.0, 597_928.0, 6_642_702.0];
const HOUSE_WEST: [f64; 4] = [597_808.0, 6_642_662.0, 597_828.0, 6_642_702.0];

#[test]
fn footprints_in_web_mercator_are_refused_and_brought_into_utm() {
    let folder = Folder::new();
    folder.write("merc.geojson", &houses_in_mercator());
    folder.write("utm.geojson", &houses(Some("EPSG:32632"), &[HOUSE_EAST, HOUSE_WEST].map(rectangle)));
    for line in [
        "info merc.geojson",
        "link merc.geojson --uav 1196683.79,8379728.58,50 --rx 1196862.84,8379723.83,1.5",
        "info utm.geojson --project EPSG:3857",
        "info utm.geojson --crs EPSG:900913",
    ] {
        folder.refuses(line, "E310", &["web Mercator (EPSG:3857)", "hint: `--project auto`"]);
    }
    let seen = |line: &str| {
        let at = "--uav 597868,6642682,50 --radius 100 --data-area all --extent 597720,6642540,598010,6642830 --json";
        let document = folder.type_in(&format!("map {line} {at}")).done().json();
        document["sites"][0]["p_los"].as_f64().expect("a share")
    };
    let wanted = seen("utm.geojson");
    assert!((wanted - 0.8294).abs() < 1e-4 && (seen("merc.geojson --project auto") - wanted).abs() < 1e-4);
    // Footprints that name no system are in that of the terrain below them.
    folder.write("flat.asc", "ncols 2\nnrows 2\nxllcorner 1196400\nyllcorner 8379400\ncellsize 400\n0 0\n0 0\n");
    folder.write("flat.prj", "EPSG:3857");
    let bare: Value = serde_json::from_str(&houses_in_mercator()).unwrap();
    let bare = json!({"type": "FeatureCollection", "features": bare["features"]});
    folder.write("bare.geojson", &bare.to_string());
    folder.refuses("info bare.geojson --terrain flat.asc", "E310", &["hint: `--crs EPSG:3857 --project auto`"]);
    let both = folder.type_in("info bare.geojson --terrain flat.asc --crs EPSG:3857 --project auto --json").done();
    assert_eq!(both.json()["crs"], "EPSG:32632");
    assert!(!both.warnings().contains(&"W331"), "{}", both.err);
}

/// A raster of 60 × 60 cells of 2 units at Oslo with a wall of 20 m from north to south, in several formats.
fn walls_in_mercator(folder: &Folder) -> Vec<&'static str> {
    let rows: String = (0..60).map(|_| "0 ".repeat(40) + &"20 ".repeat(2) + &"0 ".repeat(18) + "\n").collect();
    let head = "ncols 60\nnrows 60\nxllcorner 1196600\nyllcorner 8379700\ncellsize 2\n";
    folder.write("wall.asc", &format!("{head}{rows}"));
    folder.write("wall.prj", r#"PROJCS["WGS_1984_Web_Mercator_Auxiliary_Sphere",GEOGCS["GCS_WGS_1984",DATUM["D_WGS_1984",SPHEROID["WGS_1984",6378137.0,298.257223563]],PRIMEM["Greenwich",0.0],UNIT["Degree",0.0174532925199433]],PROJECTION["Mercator_Auxiliary_Sphere"],PARAMETER["False_Easting",0.0],PARAMETER["False_Northing",0.0],PARAMETER["Central_Meridian",0.0],PARAMETER["Standard_Parallel_1",0.0],PARAMETER["Auxiliary_Sphere_Type",0.0],UNIT["Meter",1.0]]"#);
    folder.write("wall.vrt", r#"<VRTDataset rasterXSize="60" rasterYSize="60"><SRS>EPSG:3857</SRS>
<GeoTransform>1196600, 2, 0, 8379820, 0, -2</GeoTransform><VRTRasterBand dataType="Float32" band="1"><SimpleSource>
<SourceFilename relativeToVRT="1">wall.asc</SourceFilename><SourceBand>1</SourceBand></SimpleSource></VRTRasterBand></VRTDataset>"#);
    std::fs::create_dir(folder.join("tiles")).unwrap();
    ["wall.asc", "wall.prj"].iter().for_each(|name| folder.write(&format!("tiles/{name}"), &folder.text(name)));
    folder.write("bare.asc", &format!("{head}{rows}"));
    vec!["wall.asc", "wall.vrt", "tiles", "bare.asc --crs EPSG:3857"]
}

#[test]
fn lengths_of_a_raster_in_web_mercator_are_those_on_the_ground() {
    let folder = Folder::new();
    let true_m = (8_379_760.0_f64 / 6_378_137.0).cosh().recip();
    for scene in walls_in_mercator(&folder) {
        let run = |line: &str| folder.type_in(&format!("{line} --json")).done();
        let info = run(&format!("info {scene} --ground 0"));
        assert!(info.warnings().contains(&"W331"), "{scene}: {}", info.err);
        for word in ["0.501", "at its edge", "`--project EPSG:32632`"] {
            assert!(info.err.contains(word), "{scene}: no `{word}` in {}", info.err);
        }
        assert!(!info.warnings().contains(&"W343"), "{scene}: {}", info.err);
        let close = |found: &Value, wanted: f64| {
            let found = found.as_f64().unwrap_or_else(|| panic!("{scene}: {found}"));
            assert!((found - wanted).abs() < 1e-3 * wanted, "{scene}: {found}, wanted {wanted}");
        };
        let document = info.json();
        close(&document["cell_m"][0], 2.0 * true_m);
        // From 1 m before the wall: 60 units to the west, 48.5 m down.
        let link = run(&format!("link {scene} --ground 0 --uav 1196670,8379761,50 --rx 1196610,8379761,1.5")).json();
        close(&link["distance_m"], 60.0 * true_m);
        close(&link["elevation_deg"], (48.5 / (60.0 * true_m)).atan().to_degrees());
        // A radius of 20 m holds as many cells as one of 20 m on the ground does.
        let map = run(&format!("map {scene} --ground 0 --uav 1196640,8379761,50 --radius 20"));
        let n = map.json()["sites"][0]["receivers"].as_f64().unwrap();
        let wanted = std::f64::consts::PI * (20.0 / (2.0 * true_m)).powi(2);
        assert!((n - wanted).abs() < 0.03 * wanted, "{scene}: {n} receivers in range, wanted {wanted}");
        // In another system all is as ever, and nothing is said.
        let moved = run(&format!("info {scene} --ground 0 --project auto"));
        assert_eq!(moved.json()["crs"], "EPSG:32632");
        assert!(!moved.warnings().contains(&"W331"), "{scene}: {}", moved.err);
    }
}

#[test]
fn a_raster_that_is_brought_into_web_mercator_has_true_lengths_too() {
    let folder = Folder::new();
    folder.write(
        "flat.asc",
        "ncols 20\nnrows 20\nxllcorner 597800\nyllcorner 6642600\ncellsize 5\n".to_string().as_str(),
    );
    let rows: String = (0..20).map(|_| "0 ".repeat(20) + "\n").collect();
    folder.write("flat.asc", &(folder.text("flat.asc") + &rows));
    folder.write("flat.prj", "EPSG:32632");
    let answer = folder.type_in("info flat.asc --ground 0 --project EPSG:3857 --cell 2 --json").done();
    assert!(answer.warnings().contains(&"W331"), "{}", answer.err);
    let cell = answer.json()["cell_m"][0].as_f64().unwrap();
    assert!((cell - 2.0).abs() < 1e-6, "{cell}");
}

/// 111 km to a degree, and cos 16.8° of that from west to east.
fn house_at(lon: f64) -> Vec<[f64; 2]> {
    let (half, lat) = (0.000_1, -16.8);
    let turned = |lon: f64| if lon > 180.0 { lon - 360.0 } else { lon };
    rectangle([lon - half, lat - half, lon + half, lat + half]).into_iter().map(|[x, y]| [turned(x), y]).collect()
}

#[test]
fn a_city_on_both_sides_of_180_degrees_lies_in_one_zone() {
    let folder = Folder::new();
    let shifted = |by: f64, rings: &[Vec<[f64; 2]>]| -> Vec<Vec<[f64; 2]>> {
        let beyond = |x: f64| if x * by < 0.0 { x + by } else { x };
        rings.iter().map(|ring| ring.iter().map(|[x, y]| [beyond(*x), *y]).collect()).collect()
    };
    let city = [179.9995, 180.0, 180.0005].map(house_at);
    // Halves of the house in the middle, cut at 180 degrees.
    let cut = [[179.9999, -16.8001, 180.0, -16.7999], [-180.0, -16.8001, -179.9999, -16.7999]].map(rectangle);
    let cases = [
        ("two_sides", city.to_vec()),
        ("cut", [&city[..1], &cut[..], &city[2..]].concat()),
        ("beyond_180", shifted(360.0, &city)),
        ("beyond_minus180", shifted(-360.0, &city)),
    ];
    let mut outlines = Vec::new();
    for (name, rings) in cases {
        for crs in [None, Some("urn:ogc:def:crs:OGC:1.3:CRS84")] {
            folder.write("city.geojson", &houses(crs, &rings));
            let info = folder.type_in("info city.geojson --project auto --json").done().json();
            let zone = info["crs"].as_str().expect("a system");
            assert!(["EPSG:32760", "EPSG:32701"].contains(&zone), "{name}: {zone}");
            let [west, south, east, north] =
                [0, 1, 2, 3].map(|k| info["extent"][k].as_f64().unwrap_or_else(|| panic!("{name}: {info}")));
            assert!(east - west < 150.0 && north - south < 50.0, "{name}: {info}");
            assert!((8_000_000.0..8_200_000.0).contains(&south), "{name}: {south}");
            outlines.push((zone.to_string(), [west, south, east, north].map(f64::round)));
        }
    }
    outlines.dedup();
    assert_eq!(outlines.len(), 1, "{outlines:?}");
}

#[test]
fn a_raster_across_180_degrees_lies_in_one_zone() {
    let folder = Folder::new();
    let rows = "0 0 0 0 0 0 0 0\n".repeat(8);
    for west in [179.996, -180.004] {
        folder
            .write("city.asc", &format!("ncols 8\nnrows 8\nxllcorner {west}\nyllcorner -16.8\ncellsize 0.001\n{rows}"));
        folder.write("city.prj", "EPSG:4326");
        let info = folder.type_in("info city.asc --ground 0 --project auto --json").done().json();
        let zone = info["crs"].as_str().expect("a system");
        assert!(["EPSG:32760", "EPSG:32701"].contains(&zone), "{zone}");
        assert_eq!(info["cells"]["nodata"].as_u64().unwrap_or_default(), 0, "{info}");
    }
    // Tiles on both sides are one city as well.
    std::fs::create_dir(folder.join("tiles")).unwrap();
    for (name, west) in [("a", 179.992), ("b", -180.0)] {
        let tile = format!("ncols 8\nnrows 8\nxllcorner {west}\nyllcorner -16.8\ncellsize 0.001\n{rows}");
        folder.write(&format!("tiles/{name}.asc"), &tile);
        folder.write(&format!("tiles/{name}.prj"), "EPSG:4326");
    }
    let info = folder.type_in("info tiles --ground 0 --project auto --json").done().json();
    assert_eq!(info["cells"]["nodata"].as_u64().unwrap_or_default(), 0, "{info}");
    // 16 cells of a thousandth of a degree at 16.8° south, by 8.
    let [width, height] =
        [(2, 0), (3, 1)].map(|(a, b)| info["extent"][a].as_f64().unwrap() - info["extent"][b].as_f64().unwrap());
    assert!((width - 1705.0).abs() < 60.0 && (height - 888.0).abs() < 60.0, "{width} by {height}");
}

#[test]
fn an_overlay_across_180_degrees_is_as_small_as_the_city() {
    let folder = Folder::new();
    folder.write("city.geojson", &houses(None, &[179.9995, 180.0, 180.0005].map(house_at)));
    folder.type_in("map city.geojson --project auto --uav 180210,8140148,60 --data-area all -o a.kmz -q").done();
    let mut archive = zip::ZipArchive::new(std::io::Cursor::new(folder.read("a.kmz"))).unwrap();
    let mut kml = String::new();
    std::io::Read::read_to_string(&mut archive.by_name("doc.kml").unwrap(), &mut kml).unwrap();
    let lon = |name: &str| -> f64 {
        let text = kml.split(&format!("<{name}>")).nth(1).unwrap().split('<').next().unwrap();
        text.split(',').next().unwrap().parse().unwrap()
    };
    let (west, east, uav) = (lon("west"), lon("east"), lon("coordinates"));
    assert!(east - west < 0.0015 && west < uav && uav < east, "{west} to {east}, UAV at {uav}");
}

#[test]
fn cgcs2000_and_gda2020_agree_with_wgs_84() {
    let folder = Folder::new();
    // (system, house, longitude and latitude, what PROJ makes of these)
    let cases = [
        ("EPSG:4547", [499_980.0, 3_705_980.0, 499_990.0, 3_706_020.0], (114.0, 33.48), (500_000.0, 3_705_984.237_233)),
        (
            "EPSG:7856",
            [333_453.0, 6_250_932.0, 333_463.0, 6_250_972.0],
            (151.2, -33.87),
            (333_510.650_080, 6_250_800.241_287),
        ),
        (
            "EPSG:28356",
            [333_453.0, 6_250_932.0, 333_463.0, 6_250_972.0],
            (151.2, -33.87),
            (333_510.650_080, 6_250_800.241_287),
        ),
    ];
    for (crs, house, (lon, lat), (x, y)) in cases {
        folder.write("city.geojson", &houses(Some(crs), &[rectangle(house)]));
        folder.write("sites.csv", &format!("lon,lat,h\n{lon},{lat},30\n"));
        let map = folder
            .type_in("map city.geojson --uavs sites.csv --data-area all --extent 333400,6250700,333600,6251000 --json");
        let map = if crs == "EPSG:4547" {
            folder.type_in(
                "map city.geojson --uavs sites.csv --data-area all --extent 499900,3705900,500100,3706100 --json",
            )
        } else {
            map
        };
        let site = map.done().json()["sites"][0].clone();
        let off = |name: &str, wanted: f64| (site[name].as_f64().expect("a number") - wanted).abs();
        assert!(off("x", x) < 1e-3 && off("y", y) < 1e-3, "{crs}: {site}, wanted {x}, {y}");
    }
    let degrees = rectangle([114.0, 33.48, 114.000_2, 33.480_2]);
    folder.write("degrees.geojson", &houses(Some("urn:ogc:def:crs:EPSG::4490"), &[degrees]));
    assert_eq!(folder.type_in("info degrees.geojson --project auto --json").done().json()["crs"], "EPSG:32650");
}

#[test]
fn cases_about_systems_have_their_right_answers() {
    let Some(mercator) = shared("05-web-mercator") else { return };
    let folder = Folder::new();
    copy(&mercator, &folder);
    folder.refuses("info merc.geojson", "E310", &["hint: `--project auto`"]);
    for raster in ["merc.tif", "m.asc"] {
        let answer = folder.type_in(&format!("info {raster} --ground 0")).done();
        assert!(answer.warnings().contains(&"W331"), "{raster}: {}", answer.err);
    }
    let Some(antimeridian) = shared("06-antimeridian") else { return };
    copy(&antimeridian, &folder);
    for name in ["across_uncut", "beyond_180", "beyond_minus180"] {
        let document = folder.type_in(&format!("info {name}.geojson --project auto --json")).done().json();
        assert!(["EPSG:32760", "EPSG:32701"].contains(&document["crs"].as_str().unwrap()), "{name}");
    }
    let (Some(china), Some(sydney)) = (shared("19-cgcs2000"), shared("20-gda2020")) else { return };
    copy(&china, &folder);
    copy(&sydney, &folder);
    folder.type_in("map cgcs.geojson --uavs cgcs.csv --data-area all --json").done();
    folder.type_in("info deg4490.geojson --project auto").done();
    folder.type_in("map cgcs.geojson --uav 500050,3706000,30 -o x.kmz").done();
    for city in ["syd7856", "syd28356"] {
        let line = format!("map {city}.geojson --uavs syd.csv --data-area all --json");
        let site = folder.type_in(&line).done().json()["sites"][0].clone();
        assert!((site["x"].as_f64().unwrap() - 333_510.650).abs() < 1e-3, "{city}: {site}");
        assert!((site["y"].as_f64().unwrap() - 6_250_800.241).abs() < 1e-3, "{city}: {site}");
    }
}
