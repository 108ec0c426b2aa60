//! Footprints that cross themselves or lie on one another: mended at the cost of their corners and crossings, or refused by
//! name. Every run may take 1 GB of memory and some seconds, which the system enforces; each of these took minutes or more.

use std::f64::consts::TAU;

use serde_json::json;

use crate::program::Folder;
use crate::support::Random;
use crate::vector_files::{EAST, NORTH};

type Ring = Vec<[f64; 2]>;

/// Writes buildings of rings around the middle of a square kilometer; the one at place k is the feature `house-k`.
fn write(folder: &Folder, name: &str, buildings: &[Vec<Ring>]) {
    let closed = |ring: &Ring| {
        let at = |[x, y]: [f64; 2]| [EAST + 500.0 + x, NORTH + 500.0 + y];
        ring.iter().chain(ring.first()).map(|p| at(*p)).collect::<Vec<_>>()
    };
    let feature = |(k, rings): (usize, &Vec<Ring>)| {
        let rings: Vec<_> = rings.iter().map(closed).collect();
        json!({"type": "Feature", "id": format!("house-{k}"), "properties": {"height": 5 + k % 20},
            "geometry": {"type": "Polygon", "coordinates": rings}})
    };
    let features: Vec<_> = buildings.iter().enumerate().map(feature).collect();
    let crs = json!({"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::25832"}});
    folder.write(name, &json!({"type": "FeatureCollection", "crs": crs, "features": features}).to_string());
}

/// n corners at these radii \[m\], each a part of the circle after the last.
fn around(n: usize, radii: [f64; 2], part: f64) -> Ring {
    let corner = |k: usize| {
        #[expect(clippy::cast_precision_loss, reason = "small")]
        let (angle, radius) = (TAU * part * k as f64, radii[k % 2]);
        [radius * angle.cos(), radius * angle.sin()]
    };
    (0..n).map(corner).collect()
}

fn square([x, y]: [f64; 2], side: f64) -> Ring {
    vec![[x, y], [x + side, y], [x + side, y + side], [x, y + side]]
}

/// A map with its zones, and tiles of 10 m, of a file.
fn mapped(folder: &Folder, name: &str) -> serde_json::Value {
    let (x, y) = (EAST + 500.0, NORTH + 500.0);
    let map = folder.type_in(&format!("map {name} --uav {x},{y},100 --data-area all --json -q")).done().json();
    folder.type_in(&format!("info {name} --tile 10 --data-area all --json")).done();
    map
}

#[test]
fn a_footprint_whose_edges_cross_too_often_is_refused_by_name() {
    let folder = Folder::new();
    let mut random = Random(7);
    let crossing: Ring = (0..10_000).map(|_| [(); 2].map(|()| between(&mut random, -400.0, 400.0))).collect();
    for (ring, limit) in [
        (around(1401, [400.0; 2], 700.0 / 1401.0), "cross one another more than 35604 times"),
        (crossing, "cross one another more than 70000 times"),
        (around(100_000, [200.0, 400.0], 1e-5), "more than 45600000 pairs"),
    ] {
        write(&folder, "bad.geojson", &[vec![square([0.0; 2], 9.0)], vec![ring]]);
        for line in ["info bad.geojson", "city bad.geojson -o c.geojson"] {
            folder.refuses(line, "E504", &["`house-1`", limit]);
        }
    }
}

#[test]
fn stars_and_spikes_within_the_limit_are_mapped() {
    let folder = Folder::new();
    write(&folder, "star.geojson", &[vec![around(241, [400.0; 2], 120.0 / 241.0)]]);
    write(&folder, "spikes.geojson", &[vec![around(10_000, [200.0, 400.0], 1e-4)]]);
    mapped(&folder, "star.geojson");
    // Of 800 × 800 cells the spikes leave all but n/2 · R · r · sin(2π/n).
    let receivers = mapped(&folder, "spikes.geojson")["sites"][0]["receivers"].as_f64().unwrap();
    let left = 640_000.0 - 5000.0 * 400.0 * 200.0 * (TAU / 10_000.0).sin();
    assert!((receivers - left).abs() < 0.01 * left, "{receivers} of {left}");
}

/// How deep a point is in a building of convex counterclockwise rings, a shell and perhaps a court \[m\].
fn depth(building: &[Ring], [x, y]: [f64; 2]) -> f64 {
    let in_ring = |ring: &Ring| {
        let edges = ring.iter().zip(ring.iter().cycle().skip(1));
        let depths = edges.map(|(a, b)| {
            let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
            (dx * (y - a[1]) - dy * (x - a[0])) / dx.hypot(dy)
        });
        depths.fold(f64::INFINITY, f64::min)
    };
    building[1..].iter().fold(in_ring(&building[0]), |depth, court| depth.min(-in_ring(court)))
}

/// The fewest and the most cell centers that any building holds: those at a wall may be in it or not.
fn cells_held(buildings: &[Vec<Ring>]) -> [usize; 2] {
    const SIDE: i32 = 600;
    let mut deepest = vec![f64::NEG_INFINITY; 600 * 600];
    for building in buildings {
        let range = |axis: usize| {
            let values = || building[0].iter().map(move |p| p[axis]);
            let ends = [values().fold(f64::INFINITY, f64::min).floor(), values().fold(0.0, f64::max).ceil()];
            #[expect(clippy::cast_possible_truncation, reason = "within the square")]
            let [low, high] = ends.map(|end| end as i32);
            low..high
        };
        for (row, col) in range(1).flat_map(|row| range(0).map(move |col| (row, col))) {
            let cell = &mut deepest[usize::try_from((row + 100) * SIDE + col + 100).unwrap()];
            *cell = cell.max(depth(building, [f64::from(col) + 0.5, f64::from(row) + 0.5]));
        }
    }
    [0.002, -0.002].map(|least| deepest.iter().filter(|depth| **depth > least).count())
}

#[test]
fn thousands_of_footprints_on_one_another_are_one_block() {
    let folder = Folder::new();
    let mut random = Random(3);
    let n = 2000;
    let same = (0..n).map(|_| vec![square([100.5; 2], 50.0), square([110.5; 2], 20.0)]).collect();
    let near = (0..n).map(|_| vec![square([(); 2].map(|()| between(&mut random, 0.0, 100.0)), 100.0)]).collect();
    // Skewed ones, whose edges cross off the lattice.
    let skewed = |random: &mut Random| {
        let ([x, y], turn) = ([(); 2].map(|()| between(random, 0.0, 100.0)), between(random, 0.0, TAU));
        let corner = |k: u32| (turn + TAU / 4.0 * f64::from(k)).sin_cos();
        vec![(0..4).map(corner).map(|(sin, cos)| [x + 40.0 * cos, y + 40.0 * sin]).collect()]
    };
    let skewed = (0..n).map(|_| skewed(&mut random)).collect();
    // Houses along one wall that runs through the centers of cells.
    let wall = (0..n).map(|_| vec![square([0.5; 2], between(&mut random, 10.0, 300.0))]).collect();
    let cases: [(&str, Vec<Vec<Ring>>); 4] = [("same", same), ("near", near), ("skewed", skewed), ("wall", wall)];
    for (name, buildings) in cases {
        let file = format!("{name}.geojson");
        write(&folder, &file, &buildings);
        mapped(&folder, &file);
        let facts = folder.type_in(&format!("info {file} --data-area all --json")).done().json();
        let built = usize::try_from(facts["cells"]["building"].as_u64().unwrap()).unwrap();
        let [fewest, most] = cells_held(&buildings);
        assert!((fewest..=most).contains(&built), "{name}: {built} of {fewest} to {most}");
        assert!(most - fewest < 2000 && fewest > 1000, "{name}");
    }
}

/// A comb of so many teeth, which point to the north; `turned` they point to the east.
fn comb(teeth: u32, turned: bool) -> Ring {
    let step = 600.0 / f64::from(2 * teeth);
    let tooth = |k: u32| [-300.0 + step * f64::from(k), if k.is_multiple_of(2) { -300.0 } else { 300.0 }];
    let back = [[300.0, -301.0], [-300.0, -301.0]];
    let point = |[x, y]: [f64; 2]| if turned { [y, x] } else { [x, y] };
    (0..=2 * teeth).map(tooth).chain(back).map(point).collect()
}

#[test]
fn footprints_that_cross_one_another_too_often_have_a_map_and_no_zones() {
    let folder = Folder::new();
    let (x, y) = (EAST + 500.0, NORTH + 500.0);
    for (teeth, is_refused) in [(30, false), (600, true), (2400, true)] {
        let name = format!("combs{teeth}.geojson");
        write(&folder, &name, &[vec![comb(teeth, false)], vec![comb(teeth, true)]]);
        folder.type_in(&format!("map {name} --cell 5 --uav {x},{y},100 --data-area all --json -q")).done();
        for line in [
            format!("zones {name} --cell 5 --data-area all --json"),
            format!("place {name} --cell 5 --data-area all --height 100 --step 200 --json"),
            format!("sample {name} --cell 5 --data-area all --zones street:2 --height 100 --json"),
            format!("compare {name} --cell 5 --data-area all --uav {x},{y},100 --uav {x},{y},200 -o c{teeth}.csv"),
            format!("info {name} --cell 5 --data-area all --tile 200 --json"),
            format!("live {name} --cell 5 --data-area all --uav {x},{y},100 -o c{teeth}.html"),
        ] {
            if is_refused {
                folder.refuses(&line, "E504", &["edges that cross one another more than"]);
            } else {
                folder.type_in(&line).done();
            }
        }
    }
}

/// Parts of buildings, each in as many outlines as there are.
#[test]
fn parts_in_thousands_of_outlines_are_refused_or_soon_found() {
    let folder = Folder::new();
    for (n, is_refused) in [(100, false), (2000, true)] {
        let ring = |k: usize, side: f64| {
            #[expect(clippy::cast_precision_loss, reason = "small")]
            let shift = k as f64 * 1e-3;
            let at = |[x, y]: [f64; 2]| [EAST + 500.0 + x, NORTH + 500.0 + y];
            let ring = square([shift; 2], side);
            ring.iter().chain(ring.first()).map(|p| at(*p)).collect::<Vec<_>>()
        };
        let feature = |k: usize, key: &str, side: f64| {
            json!({"type": "Feature", "id": format!("{key}-{k}"), "properties": {"height": 9, key: "yes"},
                "geometry": {"type": "Polygon", "coordinates": [ring(k, side)]}})
        };
        let features: Vec<_> =
            (0..n).flat_map(|k| [feature(k, "building", 20.0), feature(k, "building:part", 60.0)]).collect();
        let crs = json!({"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::25832"}});
        let text = json!({"type": "FeatureCollection", "crs": crs, "features": features}).to_string();
        folder.write("parts.geojson", &text);
        let line = "info parts.geojson --data-area all --json";
        if is_refused {
            folder.refuses(line, "E504", &["pairs of outlines on one another"]);
        } else {
            folder.type_in(line).done();
        }
    }
}

/// A length between two \[m\].
fn between(random: &mut Random, low: f64, high: f64) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "below 2^31")]
    let share = random.within(0, 1 << 30) as f64 / f64::from(1 << 30);
    low + share * (high - low)
}
