//! What objects of CityJSON mean: buildings with parts, outlines with a measured height, fillers, what lies below the terrain.

use serde_json::{Value, json};

use crate::building_meaning::{cells, n_of};
use crate::needs::truth;
use crate::program::Folder;

/// A city of CityJSON in whole meters.
#[derive(Default)]
struct City {
    vertices: Vec<[i32; 3]>,
    objects: serde_json::Map<String, Value>,
}

impl City {
    /// A closed block: west, south, east, north; from a height to another. Flat it is one surface.
    fn block(&mut self, lod: &str, [west, south, east, north]: [i32; 4], [low, high]: [i32; 2]) -> Value {
        let first = self.vertices.len();
        let ring = [[west, south], [east, south], [east, north], [west, north]];
        for z in [low, high] {
            self.vertices.extend(ring.iter().map(|[x, y]| [*x, *y, z]));
        }
        let at = |k: usize| first + k;
        let roof = json!([[at(4), at(5), at(6), at(7)]]);
        let floor = json!([[at(3), at(2), at(1), at(0)]]);
        let wall = |k: usize| json!([[at(k), at((k + 1) % 4), at((k + 1) % 4 + 4), at(k + 4)]]);
        let all = if low == high { json!([floor]) } else { json!([floor, roof, wall(0), wall(1), wall(2), wall(3)]) };
        json!({"type": "MultiSurface", "lod": lod, "boundaries": all})
    }

    fn add(&mut self, id: &str, kind: &str, geometry: &[Value], attributes: &Value, (list, names): (&str, &[&str])) {
        let object = json!({"type": kind, "geometry": geometry, "attributes": attributes, list: names});
        self.objects.insert(id.into(), object);
    }

    fn house(&mut self, id: &str, lod: &str, at: [i32; 4], heights: [i32; 2], attributes: &Value) {
        let geometry = self.block(lod, at, heights);
        self.add(id, "Building", &[geometry], attributes, ("children", &[]));
    }

    fn write(&self, folder: &Folder) {
        let document = json!({"type": "CityJSON", "version": "2.0", "CityObjects": self.objects, "vertices": self.vertices,
            "transform": {"scale": [1.0, 1.0, 1.0], "translate": [0.0, 0.0, 0.0]},
            "metadata": {"referenceSystem": "https://www.opengis.net/def/crs/EPSG/0/25832"}});
        folder.write("a.city.json", &document.to_string());
    }
}

const EXTENT: &str = "a.city.json --roofs flat --extent 0,0,100,60 --data-area all";

#[test]
fn a_building_is_what_its_parts_are() {
    let folder = Folder::new();
    // A podium of 20 m with a tower that is drawn from its roof on; the building itself as a block as high as the tower.
    for (lod, of_parts) in [("0", "2.2"), ("1", "2"), ("1.2", "1.2"), ("2", "2")] {
        let mut city = City::default();
        let whole = [0, 0, 60, 60];
        let outline = city.block(lod, whole, if lod == "0" { [100, 100] } else { [100, 190] });
        let podium = city.block(of_parts, whole, [100, 120]);
        let tower = city.block(of_parts, [20, 20, 40, 40], [120, 190]);
        city.add("b", "Building", &[outline], &json!({"measuredHeight": 90.0}), ("children", &["p", "t"]));
        city.add("p", "BuildingPart", &[podium], &json!({}), ("parents", &["b"]));
        city.add("t", "BuildingPart", &[tower], &json!({}), ("parents", &["b"]));
        city.house("c", of_parts, [80, 0, 100, 20], [102, 109], &json!({}));
        city.write(&folder);
        // The podium, the tower and the outline stand at 100 m, the other house at 102: the lower middle is 100.
        let found = cells(&folder, EXTENT);
        assert_eq!(
            (n_of(&found, 120.0), n_of(&found, 190.0), n_of(&found, 109.0)),
            (3200, 400, 400),
            "{lod} {of_parts}"
        );
        let ground =
            |line: &str| folder.type_in(&format!("info {EXTENT} {line} --json -q")).done().json()["ground_m"].clone();
        assert_eq!(ground(""), json!([100.0, 100.0]), "{lod} {of_parts}");
        assert_eq!(ground("--ground buildings"), json!([100.0, 102.0]), "{lod} {of_parts}");
    }
}

#[test]
fn measured_heights_serve_where_no_surface_tells_them() {
    let folder = Folder::new();
    let mut city = City::default();
    let measured = |m: f64| json!({"measuredHeight": m});
    city.house("outline", "0", [0, 0, 20, 20], [7, 7], &measured(12.0));
    city.house("filler", "1", [30, 0, 50, 20], [7, 10], &json!({}));
    city.house("low", "1", [60, 0, 80, 20], [7, 10], &measured(3.0));
    // Blocks of level 1.2 are cut from measured roofs.
    city.house("shed", "1.2", [60, 30, 80, 50], [7, 10], &json!({}));
    // Surfaces count before what was measured.
    city.house("solid", "1", [0, 30, 20, 50], [7, 22], &measured(12.0));
    city.house("cellar", "1", [30, 30, 50, 50], [-3, 6], &json!({"relativeToTerrain": "entirelyBelowTerrain"}));
    city.write(&folder);
    folder.refuses(&format!("map {EXTENT} --uav 90,50,60 --json"), "E309", &["1 of 5"]);
    let found = cells(&folder, &format!("{EXTENT} --missing 5"));
    for (height, n) in [(7.0 + 12.0, 400), (7.0 + 5.0, 400), (7.0 + 3.0, 800), (7.0 + 15.0, 400), (7.0, 6000 - 2000)] {
        assert_eq!(n_of(&found, height), n, "{height}");
    }
    // A roof of which the height is not known is none.
    let shaped = EXTENT.replace("flat", "lod2");
    assert_eq!(cells(&folder, &format!("{shaped} --missing 5")), found);
    let info = folder.type_in(&format!("info {EXTENT} --missing 5 --json -q")).done().json();
    assert_eq!((&info["ground_m"], &info["faults"]["not_buildings"]), (&json!([7.0, 7.0]), &json!(1)));
}

/// Each building of 3DBAG has an outline at the datum beside its part, which is drawn in more detail.
#[test]
fn buildings_of_3dbag_are_read_once() {
    let Some(data) = truth() else { return };
    let folder = Folder::new();
    for (name, n, wanted) in [("3dbag_polder", 1, "3dbag_polder_nolod0"), ("3dbag_as_delivered", 2, "3dbag_b2")] {
        let read = |name: &str| {
            let file = data.join(format!("formats/cityjson/{name}.city.json")).display().to_string();
            let map = folder.type_in(&format!("info {file} --roofs flat --data-area all --json -q")).done().json();
            ["buildings", "ground_m", "surface_m", "cells", "estimated_built_up"].map(|key| map[key].clone())
        };
        let found = read(name);
        assert_eq!(found, read(wanted), "{name}");
        assert_eq!(found[0], n, "{name}");
    }
}

#[test]
fn a_part_beside_its_building_is_an_annex() {
    let folder = Folder::new();
    let mut city = City::default();
    let (house, annex) = (city.block("2", [0, 0, 20, 20], [0, 30]), city.block("2", [20, 0, 30, 20], [0, 12]));
    city.add("b", "Building", &[house], &json!({}), ("children", &["p"]));
    city.add("p", "BuildingPart", &[annex], &json!({}), ("parents", &["b"]));
    city.write(&folder);
    for roofs in ["flat", "lod2"] {
        let found = cells(&folder, &EXTENT.replace("flat", roofs));
        assert_eq!((n_of(&found, 30.0), n_of(&found, 12.0)), (400, 200), "{roofs}");
    }
    // It is one building all the same, as high as both in the mean.
    assert_eq!(folder.type_in(&format!("info {EXTENT} --json -q")).done().json()["buildings"], 1);
}

#[test]
fn parts_have_the_attributes_of_their_building() {
    let folder = Folder::new();
    // A cellar, a block of 3 m that was measured, an outline with a measured height, and one with storeys.
    let mut city = City::default();
    for (id, lod, at, heights, attributes) in [
        ("cellar", "2", [0, 0, 20, 20], [-12, -3], json!({"relativeToTerrain": "entirelyBelowTerrain"})),
        ("low", "1", [30, 0, 50, 20], [5, 8], json!({"measuredHeight": 3.0})),
        ("outline", "0", [60, 0, 80, 20], [5, 5], json!({"measuredHeight": 11.0})),
        ("storeys", "0", [0, 30, 20, 50], [5, 5], json!({"storeysAboveGround": 4})),
    ] {
        let part = format!("{id} part");
        let geometry = city.block(lod, at, heights);
        city.add(id, "Building", &[], &attributes, ("children", &[&part]));
        city.add(&part, "BuildingPart", &[geometry], &json!({}), ("parents", &[id]));
    }
    city.write(&folder);
    let found = cells(&folder, &format!("{EXTENT} --missing levels,7"));
    for (above, n) in [(3.0, 400), (11.0, 400), (12.0, 400), (0.0, 6000 - 1200)] {
        assert_eq!(n_of(&found, 5.0 + above), n, "{above}");
    }
}

#[test]
fn the_ground_of_surfaces_serves_heights_of_another_property_too() {
    let folder = Folder::new();
    let mut city = City::default();
    city.house("a", "1", [0, 0, 20, 20], [100, 120], &json!({"measuredHeight": 15.0}));
    city.house("b", "1", [60, 0, 80, 20], [150, 170], &json!({"measuredHeight": 15.0}));
    city.write(&folder);
    let extent = EXTENT.replace("--roofs flat ", "");
    let line = format!("info {extent} --ground buildings --height-field measuredHeight --json -q");
    assert_eq!(folder.type_in(&line).done().json()["ground_m"], json!([100.0, 150.0]));
}
