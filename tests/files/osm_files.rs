//! Data of OpenStreetMap: each encoding gives the city of the same areas in GeoJSON, and that of another program.
//! Damaged and hostile files are refused.

use std::collections::BTreeMap;
use std::fs;
use std::process::Command;

use serde_json::{Value, json};

use crate::needs::{has_program, truth};
use crate::osm_files_written::{
    Form, Osm, Place, Relation, Tags, Way, block, block_of_size, bytes, data_block, framed, header_block, number,
    packed,
};
use crate::program::Folder;

/// Digests of three maps of a scene, at shares of its extent and heights.
fn digests(folder: &Folder, scene: &str, extent: [f64; 4]) -> Vec<String> {
    let digest = |(east, north, up): (f64, f64, f64)| {
        let [x, y] = [(0, east), (1, north)].map(|(k, share)| extent[k] + share * (extent[k + 2] - extent[k]));
        let document = folder.type_in(&format!("map {scene} --uav {x:.2},{y:.2},{up} --json")).done().json();
        document["digest"].as_str().unwrap_or_else(|| panic!("{document}")).to_string()
    };
    [(0.41, 0.52, 30.0), (0.12, 0.83, 60.0), (0.77, 0.31, 150.0)].map(digest).to_vec()
}

fn extent(folder: &Folder, scene: &str) -> [f64; 4] {
    let document = folder.type_in(&format!("info {scene} --json")).done().json();
    serde_json::from_value(document["extent"].clone()).unwrap()
}

/// Asserts that scenes are the city of the first.
fn same(folder: &Folder, scenes: &[&str], options: &str) {
    let scene = |name: &str| format!("{name} {options}");
    let extent = extent(folder, &scene(scenes[0]));
    let wanted = digests(folder, &scene(scenes[0]), extent);
    assert!(wanted[0] != wanted[1] && wanted[1] != wanted[2]);
    for name in &scenes[1..] {
        assert_eq!(digests(folder, &scene(name), extent), wanted, "{name}");
    }
}

/// Place of meters in the east and north of a corner, about.
fn place(x: i64, y: i64) -> Place {
    [115_000_000 + 134 * x, 481_000_000 + 90 * y]
}

/// City that is being made, and its areas.
#[derive(Default)]
pub(crate) struct Town {
    pub(crate) osm: Osm,
    features: Vec<Value>,
}

impl Town {
    /// Adds the nodes of a line; a place that is there already is the same node.
    fn nodes(&mut self, line: &[[i64; 2]]) -> Vec<i64> {
        let mut number = |[x, y]: [i64; 2]| {
            let at = place(x, y);
            let known = self.osm.nodes.iter().find(|(_, other)| *other == at).map(|(id, _)| *id);
            known.unwrap_or_else(|| {
                let id = 1000 + i64::try_from(self.osm.nodes.len()).unwrap();
                self.osm.nodes.push((id, at));
                id
            })
        };
        line.iter().map(|at| number(*at)).collect()
    }

    fn way(&mut self, id: i64, line: &[[i64; 2]], tags: &[(&'static str, &'static str)]) {
        let nodes = self.nodes(line);
        self.osm.ways.push(Way { id, nodes, tags: tags.to_vec() });
    }

    fn relation(
        &mut self,
        id: i64,
        members: &[(&'static str, i64, &'static str)],
        tags: &[(&'static str, &'static str)],
    ) {
        self.osm.relations.push(Relation { id, members: members.to_vec(), tags: tags.to_vec() });
    }

    /// Adds an area that is wanted.
    fn area(&mut self, id: &str, polygons: &[&[&[[i64; 2]]]], tags: &[(&'static str, &'static str)]) {
        let degrees = |v: i64| v as f64 / 1e7;
        let ring = |ring: &&[[i64; 2]]| ring.iter().map(|[x, y]| place(*x, *y).map(degrees)).collect::<Vec<_>>();
        let polygons: Vec<Vec<_>> = polygons.iter().map(|rings| rings.iter().map(ring).collect()).collect();
        let tags: BTreeMap<_, _> = tags.iter().copied().collect();
        let geometry = json!({"type": "MultiPolygon", "coordinates": polygons});
        self.features.push(json!({"type": "Feature", "id": id, "properties": tags, "geometry": geometry}));
    }

    fn geojson(&self) -> String {
        json!({"type": "FeatureCollection", "features": self.features}).to_string()
    }

    /// Writes the areas as GeoJSON and the city in all encodings; returns the names.
    fn write(&self, folder: &Folder) -> Vec<&'static str> {
        folder.write("areas.geojson", &self.geojson());
        folder.write("a.osm", &self.osm.xml());
        fs::write(folder.join("dense.osm.pbf"), self.osm.pbf(true).0).unwrap();
        fs::write(folder.join("plain.pbf"), self.osm.pbf(false).0).unwrap();
        folder.write("nodes.json", &self.osm.overpass(Form::Nodes));
        folder.write("places.json", &self.osm.overpass(Form::Places));
        folder.write("members.json", &self.osm.overpass(Form::PlacesOfMembers));
        vec!["areas.geojson", "a.osm", "dense.osm.pbf", "plain.pbf", "nodes.json", "places.json", "members.json"]
    }
}

/// A closed square from its south-west corner.
fn square(x: i64, y: i64, side: i64) -> [[i64; 2]; 5] {
    [[x, y], [x + side, y], [x + side, y + side], [x, y + side], [x, y]]
}

const TYPE: (&str, &str) = ("type", "multipolygon");

/// Whatever an area can be made of.
pub(crate) fn town() -> Town {
    let mut town = Town::default();
    // By itself, with a unit; and one that is no building.
    town.way(1, &square(0, 0, 10), &[("building", "yes"), ("height", "40 ft")]);
    town.area("way/1", &[&[&square(0, 0, 10)]], &[("building", "yes"), ("height", "40 ft")]);
    town.way(2, &square(200, 0, 30), &[("landuse", "grass"), ("height", "99")]);
    // One ring of three ways in odd directions.
    town.way(3, &[[20, 0], [30, 0], [40, 0]], &[]);
    town.way(4, &[[20, 0], [20, 15]], &[]);
    town.way(5, &[[40, 0], [40, 15], [20, 15]], &[]);
    let tags = [("building", "house"), ("building:levels", "4"), ("roof:levels", "1")];
    town.relation(
        1,
        &[("way", 5, "outer"), ("way", 3, "outer"), ("way", 4, "outer"), ("node", 1000, "")],
        &[&tags[..], &[TYPE]].concat(),
    );
    town.area("relation/1", &[&[&[[20, 0], [40, 0], [40, 15], [20, 15], [20, 0]]]], &tags);
    // Two outer rings without roles, one with a courtyard, in which a house stands.
    let tags = [("building", "yes"), ("height", "12")];
    town.way(6, &square(0, 30, 30), &[]);
    town.way(7, &square(5, 35, 20), &[]);
    town.way(8, &square(10, 40, 5), &[]);
    town.way(9, &square(40, 30, 8), &[]);
    let members = [("way", 7, ""), ("way", 9, ""), ("way", 8, ""), ("way", 6, "")];
    town.relation(2, &members, &[&tags[..], &[TYPE]].concat());
    town.area(
        "relation/2",
        &[&[&square(0, 30, 30), &square(5, 35, 20)], &[&square(10, 40, 5)], &[&square(40, 30, 8)]],
        &tags,
    );
    // Old style: the outer way is the building, of which the relation tells more.
    let tags = [("building", "yes"), ("height", "15")];
    town.way(10, &square(60, 0, 20), &tags[..1]);
    town.way(11, &square(65, 5, 6), &[]);
    town.relation(3, &[("way", 11, "inner"), ("way", 10, "outer")], &[TYPE, ("name", "Palace"), tags[1]]);
    town.area("way/10", &[&[&square(60, 0, 20), &square(65, 5, 6)]], &tags);
    // A tower on a podium, of which one part has no tag of its own.
    town.way(12, &square(60, 30, 40), &[("building", "commercial"), ("height", "70")]);
    town.way(13, &square(60, 30, 40), &[("building:part", "yes"), ("height", "10")]);
    town.way(14, &square(70, 40, 10), &[("height", "70")]);
    let members = [("way", 12, "outline"), ("way", 13, "part"), ("way", 14, "part"), ("relation", 4, "part")];
    town.relation(4, &members, &[("type", "building"), ("name", "Town hall")]);
    town.area("way/12", &[&[&square(60, 30, 40)]], &[("building", "commercial"), ("height", "70")]);
    town.area("way/13", &[&[&square(60, 30, 40)]], &[("building:part", "yes"), ("height", "10")]);
    town.area("way/14", &[&[&square(70, 40, 10)]], &[("building:part", "yes"), ("height", "70")]);
    // A house in a courtyard of a relation without roles, whose outer way is none.
    let tags = [("building", "yes"), ("height", "8")];
    town.way(16, &square(110, 30, 20), &[]);
    town.way(17, &square(115, 35, 6), &tags);
    town.relation(5, &[("way", 16, ""), ("way", 17, "")], &[TYPE]);
    town.area("way/17", &[&[&square(115, 35, 6)]], &tags);
    // Below the street.
    let tags = [("building", "garage"), ("height", "5"), ("location", "underground")];
    town.way(15, &square(110, 0, 20), &tags);
    town.area("way/15", &[&[&square(110, 0, 20)]], &tags);
    town
}

#[test]
fn each_encoding_is_the_city_of_its_areas() {
    let (folder, town) = (Folder::new(), town());
    let names = town.write(&folder);
    let options = "--project auto --missing levels";
    same(&folder, &names, options);
    let info = |name: &str| folder.type_in(&format!("info {name} {options} --json")).done().json();
    let wanted = info("areas.geojson");
    for name in &names[1..] {
        let of = info(name);
        for key in ["buildings", "faults", "extent"] {
            assert_eq!(of[key], wanted[key], "{name} {key}");
        }
    }
    let [west, south, ..] = extent(&folder, &format!("a.osm {options}"));
    folder.type_in(&format!("map a.osm {options} --uav {west},{south},80 -o a.svg -q")).done();
    assert!(folder.text("a.svg").contains("© OpenStreetMap contributors"));
    // What no name tells, the first bytes do.
    for (from, to) in [("a.osm", "city"), ("dense.osm.pbf", "city.bin"), ("nodes.json", "city.dat")] {
        fs::copy(folder.join(from), folder.join(to)).unwrap();
        assert_eq!(info(to)["buildings"], wanted["buildings"], "{to}");
    }
}

#[test]
fn incomplete_areas_are_told() {
    let folder = Folder::new();
    let mut town = town();
    let tags = [("building", "yes"), ("height", "20")];
    // One ring is whole, another lacks a way.
    town.way(20, &square(0, 70, 10), &[]);
    town.way(21, &[[20, 70], [30, 70], [30, 80]], &[]);
    town.relation(
        20,
        &[("way", 20, "outer"), ("way", 21, "outer"), ("way", 99, "outer")],
        &[&tags[..], &[TYPE]].concat(),
    );
    town.area("relation/20", &[&[&square(0, 70, 10)]], &tags);
    // None is whole.
    town.relation(21, &[("way", 21, "outer")], &[&tags[..], &[TYPE]].concat());
    // A way that is open, and one that lacks a node.
    town.way(22, &[[40, 70], [50, 70], [50, 80]], &tags);
    town.way(23, &square(60, 75, 10), &tags);
    town.osm.ways.last_mut().unwrap().nodes[2] = 99_999;
    // A hole whose outer ring is missing.
    town.way(24, &square(80, 75, 10), &[]);
    town.relation(22, &[("way", 24, "inner"), ("way", 98, "outer")], &[&tags[..], &[TYPE]].concat());
    let names = town.write(&folder);
    same(&folder, &names, "--project auto --missing levels");
    for name in &names[1..] {
        let answer = folder.type_in(&format!("info {name} --project auto --missing levels --json")).done();
        assert_eq!(answer.json()["faults"]["not_areas"], 5, "{name}: {answer:?}");
        assert!(answer.warnings().contains(&"W350"), "{name}: {answer:?}");
    }
}

/// Tags of a feature of GDAL, those beside its columns too.
fn tags_of(properties: &Value) -> BTreeMap<String, String> {
    let text = |name: &str| properties[name].as_str().map(str::to_string);
    let others = text("other_tags").unwrap_or_default();
    let others = others.trim_matches('"').split("\",\"").filter_map(|pair| pair.split_once("\"=>\""));
    let columns = ["building", "landuse", "leisure", "natural", "amenity"].into_iter();
    let columns = columns.filter_map(|name| Some((name.to_string(), text(name)?)));
    others.map(|(key, value)| (key.to_string(), value.to_string())).chain(columns).collect()
}

#[test]
fn an_extract_is_the_city_that_gdal_finds() {
    let Some(data) = truth() else { return };
    if !has_program("ogr2ogr") {
        return;
    }
    let folder = Folder::new();
    for (name, options, untagged) in [
        // GDAL drops the tags of outer ways where a relation has a name: the palace and a school.
        ("monaco.osm.pbf", "--project auto --missing 9", ["393226", "1484190"].as_slice()),
        ("osm2world_simpleTest01.osm", "--project auto --missing levels", &[]),
        ("osm2world_mp_two_outer_roof.osm", "--project auto --cell 20", &[]),
    ] {
        fs::copy(data.join("formats/osm").join(name), folder.join(name)).unwrap();
        let mut ogr2ogr = Command::new("ogr2ogr");
        ogr2ogr.args(["-f", "GeoJSON", "raw.geojson", name, "multipolygons"]).current_dir(folder.path());
        // Numbers of an editor are negative.
        ogr2ogr.env("OSM_USE_CUSTOM_INDEXING", "NO");
        assert!(ogr2ogr.output().unwrap().status.success(), "{name}");
        let raw: Value = serde_json::from_slice(&folder.read("raw.geojson")).unwrap();
        let mut features = Vec::new();
        for feature in raw["features"].as_array().unwrap() {
            let mut tags = tags_of(&feature["properties"]);
            if feature["properties"]["osm_id"].as_str().is_some_and(|id| untagged.contains(&id)) {
                tags.insert("building".to_string(), "yes".to_string());
            }
            if tags.contains_key("building") || tags.contains_key("building:part") {
                let number = |name: &str| feature["properties"][name].as_str();
                let id = match (number("osm_way_id"), number("osm_id")) {
                    (Some(way), _) => format!("way/{way}"),
                    (None, relation) => format!("relation/{}", relation.unwrap()),
                };
                features
                    .push(json!({"type": "Feature", "id": id, "properties": tags, "geometry": feature["geometry"]}));
            }
        }
        fs::remove_file(folder.join("raw.geojson")).unwrap();
        let of_gdal = format!("{name}.geojson");
        folder.write(&of_gdal, &json!({"type": "FeatureCollection", "features": features}).to_string());
        let n =
            |name: &str| folder.type_in(&format!("info {name} {options} --json")).done().json()["buildings"].as_u64();
        assert_eq!(n(name), n(&of_gdal), "{name}");
        same(&folder, &[&of_gdal, name], options);
    }
}

#[test]
fn answers_of_overpass_are_the_city_of_their_places() {
    let Some(data) = truth() else { return };
    let folder = Folder::new();
    fs::copy(data.join("formats/osm/overpass_geom.json"), folder.join("geom.json")).unwrap();
    let answer = folder.json("geom.json");
    let feature = |way: &Value| {
        let ring: Vec<Value> =
            way["geometry"].as_array().unwrap().iter().map(|p| json!([p["lon"], p["lat"]])).collect();
        let geometry = json!({"type": "Polygon", "coordinates": [ring]});
        json!({"type": "Feature", "id": format!("way/{}", way["id"]), "properties": way["tags"], "geometry": geometry})
    };
    let features: Vec<Value> = answer["elements"].as_array().unwrap().iter().map(feature).collect();
    folder.write("areas.geojson", &json!({"type": "FeatureCollection", "features": features}).to_string());
    same(&folder, &["areas.geojson", "geom.json"], "--project auto");
    // As the page of Overpass exports it, and as it is.
    fs::copy(data.join("formats/osm/overpass_turbo.geojson"), folder.join("turbo.geojson")).unwrap();
    let mut osm = Osm::default();
    for (k, (lon, id)) in [(115_000_000, 1), (115_010_000, 2)].into_iter().enumerate() {
        let corners = [[0, 0], [3000, 0], [3000, 2000], [0, 2000]];
        let first = 10 * i64::try_from(k).unwrap();
        osm.nodes.extend(corners.iter().zip(first..).map(|([x, y], k)| (k, [lon + x, 481_000_000 + y])));
        osm.ways.push(Way { id, nodes: vec![first, first + 1, first + 2, first + 3, first], tags: Tags::new() });
    }
    osm.ways[0].tags =
        vec![("building", "apartments"), ("building:levels", "5"), ("roof:levels", "1"), ("height", "18 m")];
    let tags = vec![TYPE, ("building", "yes"), ("location", "underground"), ("height", "4")];
    osm.relations.push(Relation { id: 2, members: vec![("way", 2, "outer")], tags });
    folder.write("turbo.osm", &osm.xml());
    same(&folder, &["turbo.geojson", "turbo.osm"], "--project auto --missing levels");
}

/// Runs `info` on a damaged file.
fn code(folder: &Folder, name: &str, bytes: &[u8]) -> String {
    fs::write(folder.join(name), bytes).unwrap();
    let answer = folder.type_in(&format!("info {name} --project auto --missing 9"));
    if answer.code() == 0 { "none".to_string() } else { answer.error().to_string() }
}

#[test]
fn files_that_are_cut_are_refused() {
    let (folder, town) = (Folder::new(), town());
    let (pbf, starts) = town.osm.pbf(true);
    let cuts = |length: usize| (1..24).map(move |k| 120 + k * (length - 130) / 24);
    for at in cuts(pbf.len()).filter(|at| !starts.contains(at)) {
        assert!(["E302", "E303"].contains(&code(&folder, "a.pbf", &pbf[..at]).as_str()), "pbf at {at}");
    }
    for (name, text) in [("a.osm", town.osm.xml()), ("a.json", town.osm.overpass(Form::Places))] {
        for at in cuts(text.trim_end().len()) {
            let code = code(&folder, name, &text.as_bytes()[..at]);
            assert!(["E302", "E303"].contains(&code.as_str()), "{name} at {at}: {code}");
        }
    }
    let mut answer: Value = serde_json::from_str(&town.osm.overpass(Form::Places)).unwrap();
    answer["remark"] = "runtime error: Query timed out in \"query\" at line 1 after 25 seconds.".into();
    folder.write("late.json", &answer.to_string());
    folder.refuses("info late.json --project auto --missing 9", "E303", &["Query timed out"]);
    let text = town.osm.xml().replace("</osm>", "<remark> runtime error: Query ran out of memory </remark></osm>");
    folder.write("late.osm", &text);
    folder.refuses("info late.osm --project auto --missing 9", "E303", &["ran out of memory"]);
}

#[test]
fn sizes_and_lists_of_pbf_that_lie_are_refused() {
    let folder = Folder::new();
    let header = header_block();
    let with = |block: &[u8]| [header.as_slice(), block].concat();
    let named = |size: u64| [bytes(1, b"OSMData"), number(3, size)].concat();
    let framed_as = |size: u64| {
        let header = named(size);
        [&u32::try_from(header.len()).unwrap().to_be_bytes(), header.as_slice(), &[0; 100]].concat()
    };
    // 4 million nodes without a number, and groups without an element: 32 MiB of a few thousand bytes.
    let nodes = data_block(&[""], &bytes(1, &[]).repeat(4 << 20));
    let groups = block("OSMData", &bytes(2, &[]).repeat((16 << 20) - 1));
    let texts = block("OSMData", &bytes(1, &bytes(1, &[]).repeat(8 << 20)));
    let way = [number(1, 7), bytes(8, &packed(&vec![0; 1_000_000]))].concat();
    let odd_nodes =
        bytes(2, &[bytes(1, &packed(&[2, 2])), bytes(8, &packed(&[2])), bytes(9, &packed(&[2, 2]))].concat());
    let tag = [number(1, 7), bytes(2, &packed(&[5])), bytes(3, &packed(&[1]))].concat();
    let feature = block("OSMHeader", &bytes(4, b"HistoricalInformation"));
    for (what, file, wanted) in [
        ("a header of 2^31 bytes", with(&[0x80, 0, 0, 0, 10, 7]), "E302"),
        ("a block of 2^31 bytes", with(&framed_as(1 << 31)), "E502"),
        ("a block of −1 bytes", with(&framed_as(u64::MAX)), "E502"),
        ("a block longer than the file", with(&framed_as(1 << 20)), "E303"),
        ("a size that is too small", with(&block_of_size("OSMData", &[0; 100], 10)), "E302"),
        ("a size that is too large", with(&block_of_size("OSMData", &[0; 100], 1000)), "E302"),
        ("2^31 bytes unpacked", with(&block_of_size("OSMData", &[0; 100], 1 << 31)), "E502"),
        ("empty nodes", with(&nodes), "E302"),
        ("texts", with(&texts), "E502"),
        ("a way of a million nodes", with(&data_block(&[""], &bytes(3, &way))), "E502"),
        ("lists of different lengths", with(&data_block(&[""], &odd_nodes)), "E302"),
        ("a text that is not there", with(&data_block(&["", "a"], &bytes(3, &tag))), "E302"),
        (
            "a block that is not packed as it says",
            with(&framed("OSMData", &[number(2, 9), bytes(3, b"123456789")].concat())),
            "E302",
        ),
        ("Zstandard", with(&framed("OSMData", &bytes(7, b"123456789"))), "E304"),
        ("a history", feature, "E304"),
        ("a block of another name", with(&block("OSMOther", &[])), "E302"),
        ("three bytes more", with(&[0, 0, 0]), "E303"),
    ] {
        assert_eq!(code(&folder, "a.pbf", &file), wanted, "{what}");
    }
    // They hold nothing, at the cost of their size.
    let empty = code(&folder, "b.osm", b"<osm version='0.6'/>");
    assert_eq!(code(&folder, "a.pbf", &with(&groups)), empty);
}

#[test]
fn texts_that_would_take_long_are_refused() {
    let (folder, town) = (Folder::new(), town());
    let xml = town.osm.xml();
    let inside = |text: &str| xml.replace("</osm>", &format!("{text}</osm>"));
    let nodes = "<nd ref='1000'/>".repeat(1_000_000);
    for (what, text, wanted) in [
        ("nested", inside(&format!("{}{}", "<a>".repeat(100_000), "</a>".repeat(100_000))), "E502"),
        ("an endless tag", inside(&format!("<way id='{}'/>", " ".repeat(3 << 20))), "E302"),
        ("an entity", inside("<way id='90'><tag k='building' v='&a;'/></way>"), "E302"),
        (
            "entities",
            xml.replace("<osm ", "<!DOCTYPE osm [<!ENTITY a 'yes'><!ENTITY b '&a;&a;'>]><osm ")
                .replace("\"house\"", "\"&b;\""),
            "E302",
        ),
        ("a way of a million nodes", inside(&format!("<way id='90'>{nodes}<tag k='building' v='yes'/></way>")), "E302"),
        ("an odd end", xml.replace("</osm>", "</oms>"), "E302"),
        ("no number", inside("<node id='x' lat='1' lon='1'/>"), "E302"),
        ("beyond the pole", xml.replace("lat='48.1000000'", "lat='98.1'"), "E302"),
    ] {
        assert_eq!(code(&folder, "a.osm", text.as_bytes()), wanted, "{what}");
    }
    folder.write("a.osc", &xml.replace("<osm ", "<osmChange ").replace("</osm>", "</osmChange>"));
    folder.refuses("info a.osc", "E302", &["it is a change of OpenStreetMap data"]);
    let way = json!({"type": "way", "id": 90, "nodes": vec![1000; 1_000_000], "tags": {"building": "yes"}});
    let answer = json!({"version": 0.6, "generator": "Overpass API", "elements": [way]}).to_string();
    assert_eq!(code(&folder, "a.json", answer.as_bytes()), "E502");
    let twice = r#"{"type": "way", "id": 1, "tags": {"building": "yes", "building": "no"}}"#;
    let twice = format!(r#"{{"generator": "Overpass API", "elements": [{twice}]}}"#);
    assert_eq!(code(&folder, "a.json", twice.as_bytes()), "E302");
}

#[test]
fn a_relation_that_contains_itself_is_the_city_without_it() {
    let (folder, mut town) = (Folder::new(), town());
    folder.write("without.osm", &town.osm.xml());
    town.relation(80, &[("relation", 80, "outer"), ("relation", 81, "outer")], &[TYPE]);
    town.relation(81, &[("relation", 81, "outline"), ("relation", 80, "part")], &[("type", "building")]);
    town.relation(82, &[("relation", 82, "part"), ("way", 1, "part"), ("way", 1, "outline")], &[("type", "building")]);
    folder.write("with.osm", &town.osm.xml());
    fs::write(folder.join("with.pbf"), town.osm.pbf(false).0).unwrap();
    same(&folder, &["without.osm", "with.osm", "with.pbf"], "--project auto --missing levels");
}
