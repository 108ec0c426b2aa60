//! What a scene is made of: the ground under footprints, voids, holes, lattices, extents and ranges, by hand and against plain
//! geometry in rationals.

use std::fmt::Write as _;

use serde_json::{Value, json};
use skyshed_core::city::Solids;
use skyshed_core::quantity::meters;
use skyshed_io::read::{FootprintOptions, read_footprints};
use skyshed_request::DataAreaChoice;

use crate::program::Folder;
use crate::refusals::check_refusals;
use crate::support::{Random, is_long};

fn feature(properties: &Value, rings: &[Vec<[f64; 2]>]) -> Value {
    let closed = |ring: &Vec<[f64; 2]>| ring.iter().chain(ring.first()).copied().collect::<Vec<_>>();
    let rings: Vec<_> = rings.iter().map(closed).collect();
    json!({"type": "Feature", "properties": properties, "geometry": {"type": "Polygon", "coordinates": rings}})
}

fn city(features: &[Value]) -> String {
    json!({"type": "FeatureCollection", "crs": {"type": "name", "properties": {"name": "EPSG:25832"}}, "features": features})
        .to_string()
}

fn square(west: f64, south: f64, side: f64) -> Vec<[f64; 2]> {
    let (east, north) = (west + side, south + side);
    vec![[west, south], [east, south], [east, north], [west, north]]
}

/// Whether a document has a warning of this code with this number.
fn warns(document: &Value, code: &str, number: &str) -> bool {
    let warnings = document["warnings"].as_array().unwrap();
    warnings.iter().any(|w| w["code"] == code && w["text"].as_str().unwrap().contains(number))
}

/// An ASCII grid from the north-west cell.
fn grid((west, south): (f64, f64), cell: f64, n_cols: usize, heights: &[f64]) -> String {
    let mut text = format!(
        "ncols {n_cols}\nnrows {}\nxllcorner {west}\nyllcorner {south}\ncellsize {cell}\nNODATA_value -9999\n",
        heights.len() / n_cols
    );
    for row in heights.chunks(n_cols) {
        writeln!(text, "{}", row.iter().map(f64::to_string).collect::<Vec<_>>().join(" ")).unwrap();
    }
    text
}

// ---------------------------------------------------------------------------------------------------------------------
// Bases.

/// A fraction, denominator above 0.
#[derive(Clone, Copy)]
struct Ratio(i128, i128);

impl Ratio {
    fn less(self, other: Ratio) -> bool {
        self.0 * other.1 < other.0 * self.1
    }
}

/// Whether a polygon without crossing edges covers a part of an open rectangle, by slices between all heights where anything
/// happens: in the middle of each, where the polygon's sides are, in rationals.
fn overlaps(rings: &[Vec<[i128; 2]>], [x0, y0, x1, y1]: [i128; 4]) -> bool {
    let edges: Vec<([i128; 2], [i128; 2])> =
        rings.iter().flat_map(|r| (0..r.len()).map(move |i| (r[i], r[(i + 1) % r.len()]))).collect();
    let mut levels = vec![Ratio(y0, 1), Ratio(y1, 1)];
    levels.extend(rings.iter().flatten().map(|p| Ratio(p[1], 1)));
    for (a, b) in &edges {
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        if dx != 0 {
            // Where the edge's line meets the sides of the rectangle.
            let at = |x: i128| {
                if dx > 0 { Ratio(a[1] * dx + (x - a[0]) * dy, dx) } else { Ratio(-(a[1] * dx + (x - a[0]) * dy), -dx) }
            };
            levels.extend([at(x0), at(x1)]);
        }
    }
    levels.sort_by(|a, b| (a.0 * b.1).cmp(&(b.0 * a.1)));
    levels.windows(2).any(|pair| {
        let (low, high) = (pair[0], pair[1]);
        let middle = Ratio(low.0 * high.1 + high.0 * low.1, 2 * low.1 * high.1);
        if !low.less(high) || !Ratio(y0, 1).less(middle) || !middle.less(Ratio(y1, 1)) {
            return false;
        }
        let mut crossings: Vec<Ratio> = edges
            .iter()
            .filter(|(a, b)| Ratio(a[1], 1).less(middle) != Ratio(b[1], 1).less(middle))
            .map(|(a, b)| {
                let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
                let (n, d) = (a[0] * dy * middle.1 + (middle.0 - a[1] * middle.1) * dx, dy * middle.1);
                if d > 0 { Ratio(n, d) } else { Ratio(-n, -d) }
            })
            .collect();
        crossings.sort_by(|a, b| (a.0 * b.1).cmp(&(b.0 * a.1)));
        crossings.chunks_exact(2).any(|sides| {
            let west = if sides[0].less(Ratio(x0, 1)) { Ratio(x0, 1) } else { sides[0] };
            let east = if Ratio(x1, 1).less(sides[1]) { Ratio(x1, 1) } else { sides[1] };
            west.less(east)
        })
    })
}

/// A polygon in quarters of a meter, its corners mostly on borders of cells: a star around a middle, sometimes with a court.
fn outline(random: &mut Random, cell: i128, n_cells: i128) -> Vec<Vec<[i128; 2]>> {
    let size = cell * n_cells;
    let near = |random: &mut Random| {
        let v = random.within(-2, i64::try_from(size).unwrap() + 2).into();
        if random.within(0, 2) > 0 { v / cell * cell } else { v }
    };
    let has_court = random.within(0, 3) == 0;
    let (x, y): (i128, i128) = (near(random), near(random));
    if has_court {
        let (w, h): (i128, i128) = (random.within(3, 30).into(), random.within(3, 30).into());
        let ring = |x0, y0, x1, y1| vec![[x0, y0], [x1, y0], [x1, y1], [x0, y1]];
        return vec![ring(x, y, x + w, y + h), ring(x + 1, y + 1, x + w - 1, y + h - 1)];
    }
    // Corners by octants, so that sides do not cross.
    const WAYS: [[i128; 2]; 8] = [[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1]];
    let corner = |way: &[i128; 2], random: &mut Random| {
        let reach: i128 = random.within(1, 12).into();
        [x + way[0] * reach, y + way[1] * reach]
    };
    vec![WAYS.iter().filter_map(|way| if random.within(0, 3) > 0 { Some(corner(way, random)) } else { None }).collect()]
}

#[test]
fn a_footprint_stands_on_the_lowest_column_that_its_area_overlaps() {
    let n_scenes = if is_long() { 100 } else { 8 };
    let n_each = 500;
    let folder = Folder::new();
    let mut random = Random(25);
    let (mut n, mut n_other) = (0, 0);
    for scene in 0..n_scenes {
        // Quarters of a meter.
        let cell: i128 = [4, 8, 2, 10][scene % 4];
        let n_cells: i128 = 12;
        let heights: Vec<f64> = (0..n_cells * n_cells)
            .map(|_| if random.within(0, 12) == 0 { -9999.0 } else { random.within(0, 40) as f64 })
            .collect();
        let (east, north) = (691_000.0, 5_334_000.0);
        let outlines: Vec<Vec<Vec<[i128; 2]>>> = (0..n_each).map(|_| outline(&mut random, cell, n_cells)).collect();
        let n_cols = usize::try_from(n_cells).unwrap();
        // As it is, and its mirror image.
        for mirrored in [false, true] {
            let side = cell * n_cells;
            let turn = |p: &[i128; 2]| if mirrored { [side - p[0], p[1]] } else { *p };
            let turned: Vec<Vec<Vec<[i128; 2]>>> =
                outlines.iter().map(|rings| rings.iter().map(|r| r.iter().map(turn).collect()).collect()).collect();
            let tops: Vec<f64> = heights
                .chunks(n_cols)
                .flat_map(|row| if mirrored { row.iter().rev().copied().collect() } else { row.to_vec() })
                .collect();
            folder.write("terrain.asc", &grid((east, north), cell as f64 / 4.0, n_cols, &tops));
            let world = |p: &[i128; 2]| [east + p[0] as f64 / 4.0, north + p[1] as f64 / 4.0];
            let features: Vec<Value> = turned
                .iter()
                .enumerate()
                .map(|(k, rings)| {
                    let rings: Vec<Vec<[f64; 2]>> = rings.iter().map(|r| r.iter().map(world).collect()).collect();
                    feature(&json!({"height": 3, "id": k.to_string()}), &rings)
                })
                .collect();
            folder.write("city.geojson", &city(&features));
            let terrain = Some(folder.join("terrain.asc").into());
            let options = FootprintOptions { terrain, data_area: DataAreaChoice::All, ..FootprintOptions::default() };
            let read = read_footprints(folder.join("city.geojson"), &options, &mut Vec::new()).unwrap();
            let Solids::Vector { footprints, .. } = read.solids else { panic!("footprints") };
            let found = |k: usize| footprints.iter().find(|f| f.id == k.to_string()).map(|f| meters(f.base.unwrap()));
            for (k, rings) in turned.iter().enumerate().filter(|(_, rings)| rings[0].len() >= 3) {
                let height = |col: i128, from_south: i128| {
                    let row = usize::try_from(n_cells - 1 - from_south).unwrap();
                    tops[row * n_cols + usize::try_from(col).unwrap()]
                };
                let cells = (0..n_cells).flat_map(|col| (0..n_cells).map(move |row| (col, row)));
                let under = cells
                    .filter(|(col, row)| overlaps(rings, [col * cell, row * cell, (col + 1) * cell, (row + 1) * cell]))
                    .map(|(col, row)| height(col, row))
                    .filter(|z| *z > -9999.0);
                let lowest = under.reduce(f64::min);
                assert_eq!(found(k), lowest, "scene {scene}, mirrored {mirrored}: {rings:?}, cells of {cell}/4 m");
                n += 1;
                n_other += usize::from(lowest.is_none());
            }
        }
    }
    assert!(n > n_scenes * n_each && n_other > 0 && 10 * n_other < n, "{n} {n_other}");
}

/// A house of 3 m with a wall on a cliff of 10 m: on the upper side it reaches up to 13 m.
#[test]
fn a_house_at_the_edge_of_a_cliff_stands_on_its_own_side() {
    let folder = Folder::new();
    // West of the cliff, and mirrored.
    for (west, high_cols) in [(6.0, 0..10), (10.0, 10..20)] {
        folder.write("c.geojson", &city(&[feature(&json!({"height": 3}), &[square(west, 2.0, 4.0)])]));
        let heights: Vec<f64> = (0..200).map(|k| if high_cols.contains(&(k % 20)) { 10.0 } else { 0.0 }).collect();
        folder.write("t.asc", &grid((0.0, 0.0), 1.0, 20, &heights));
        folder.type_in("city c.geojson --terrain t.asc -o out.geojson -q --overwrite").done();
        let properties = folder.json("out.geojson")["features"][0]["properties"].clone();
        assert_eq!((&properties["ground"], &properties["z_top"]), (&json!(10.0), &json!(13.0)), "{west}");
    }
}

#[test]
fn other_bases_are_the_mean_by_area_and_the_highest() {
    let folder = Folder::new();
    // Columns 0, 4, 8, … m; the house covers a quarter of column 1, columns 2 and 3, and half of column 4.
    let heights: Vec<f64> = (0..80).map(|k| f64::from(4 * (k % 8))).collect();
    folder.write("t.asc", &grid((0.0, 0.0), 1.0, 8, &heights));
    folder.write(
        "c.geojson",
        &city(&[feature(&json!({"height": 5}), &[vec![[1.75, 2.0], [4.5, 2.0], [4.5, 5.0], [1.75, 5.0]]])]),
    );
    let ground = |base: &str| {
        folder.type_in(&format!("city c.geojson --terrain t.asc {base} -o out.geojson -q --overwrite")).done();
        folder.json("out.geojson")["features"][0]["properties"]["ground"].as_f64().unwrap()
    };
    assert_eq!((ground(""), ground("--base lowest"), ground("--base highest")), (4.0, 4.0, 16.0));
    let mean: f64 = (0.25 * 4.0 + 8.0 + 12.0 + 0.5 * 16.0) / 2.75;
    assert!((ground("--base mean") - mean).abs() <= 0.5 / 1024.0, "{}", ground("--base mean"));
    check_refusals(&folder, "map c.geojson --uav 1,1,50", &[("--base mean", "E116", "`--base`")]);
}

// ---------------------------------------------------------------------------------------------------------------------
// Ground that is not known, and ground that was typed.

#[test]
fn an_absolute_top_needs_no_ground() {
    let folder = Folder::new();
    // Terrain to x = 20; a void in its middle. Buildings over the void, beyond the terrain, and on it.
    let heights: Vec<f64> = (0..400).map(|k| if (8..12).contains(&(k % 20)) { -9999.0 } else { 2.0 }).collect();
    folder.write("t.asc", &grid((0.0, 0.0), 1.0, 20, &heights));
    let top = |z: f64, ring| feature(&json!({"z_top": z, "height": z - 2.0}), &[ring]);
    let features =
        [top(12.0, square(8.0, 4.0, 3.0)), top(14.0, square(24.0, 4.0, 3.0)), top(9.0, square(2.0, 4.0, 3.0))];
    folder.write("c.geojson", &city(&features));
    let map = |rest: &str| {
        let line =
            format!("map c.geojson --terrain t.asc --extent 0,0,30,20 {rest} --receivers all --uav 2,15,40 --json");
        folder.type_in(&line).done()
    };
    let answer = map("--top-field z_top");
    let document = answer.json();
    // 20 columns of terrain but 4 of void, and 3 × 3 roofs over nothing, twice.
    assert_eq!(document["sites"][0]["receivers"], 16 * 20 + 2 * 9, "{document}");
    assert!(warns(&document, "W340", &format!("{} cells", 30 * 20 - 16 * 20 - 2 * 9)), "{document}");
    // Heights above ground have none there to stand on.
    let above = map("").json();
    assert_eq!(above["sites"][0]["receivers"], 16 * 20, "{above}");
    assert!(warns(&above, "W357", "2 footprints"), "{above}");
    // Ground that is not known can block everything instead, in the terrain and beyond it.
    let link = |rest: &str, rx: &str| {
        let line = format!(
            "link c.geojson --terrain t.asc --extent 0,0,30,20 --top-field z_top {rest} --uav 2,15,9 --rx {rx} --json"
        );
        folder.type_in(&line).done().json()["los"].clone()
    };
    assert_eq!(
        (link("", "18,15"), link("--nodata-as block", "18,15"), link("--nodata-as block", "6,15")),
        (true.into(), false.into(), true.into())
    );
    assert_eq!((link("", "28,15,20amsl"), link("--nodata-as block", "19,18")), (true.into(), false.into()));
}

#[test]
fn where_the_surface_has_a_void_the_terrain_blocks() {
    let folder = Folder::new();
    // A ridge of 30 m of which the surface knows nothing.
    let surface: Vec<f64> = (0..60).map(|k| if (8..12).contains(&(k % 20)) { -9999.0 } else { 0.0 }).collect();
    let terrain: Vec<f64> = (0..60).map(|k| if (8..12).contains(&(k % 20)) { 30.0 } else { 0.0 }).collect();
    folder.write("s.asc", &grid((0.0, 0.0), 1.0, 20, &surface));
    folder.write("t.asc", &grid((0.0, 0.0), 1.0, 20, &terrain));
    for method in ["sweep", "ray"] {
        let line = format!("map s.asc --terrain t.asc --uav 2.5,1.5,20 --rx-height 1 --method {method} --json");
        let site = folder.type_in(&line).done().json()["sites"][0].clone();
        assert_eq!((&site["receivers"], &site["los"]), (&json!(48), &json!(24)), "{line}: {site}");
    }
    // Over the void the height is above the terrain; below it is refused.
    let over = folder.type_in("map s.asc --terrain t.asc --uav 9.5,1.5,5 --json").done().json();
    assert_eq!(over["sites"][0]["height_amsl_m"], 35.0);
    let below = folder.type_in("map s.asc --terrain t.asc --uav 9.5,1.5,20amsl --json");
    assert!(below.error() == "E202" && below.refused(4)[1].contains("`0agl`"), "{below:?}");
}

#[test]
fn ground_that_was_typed_holds_everywhere() {
    let folder = Folder::new();
    folder.write("s.asc", &grid((0.0, 0.0), 1.0, 4, &[7.0, 7.0, 7.0, 7.0, 7.0, -9999.0, 9.0, 7.0]));
    // Over the void, on the north and the east edge, at the corner, and far outside.
    for place in ["1.5,0.5", "2,2", "4,1", "4,2", "-30,1", "1,99"] {
        let map = |height: &str| folder.type_in(&format!("map s.asc --ground 7 --uav {place},{height} --json"));
        let site = map("3").done().json()["sites"][0].clone();
        assert_eq!((&site["height_amsl_m"], &site["height_agl_m"]), (&json!(10.0), &json!(3.0)), "{place}");
        let below = map("6amsl");
        assert_eq!(below.error(), "E202", "{place}: {below:?}");
        // The height of the hint works.
        let hint = below.refused(4)[1].split('`').nth(1).unwrap();
        map(hint).done();
    }
}

// ---------------------------------------------------------------------------------------------------------------------
// Shapes, lattices, grids.

#[test]
fn a_hole_outside_of_its_shell_is_no_building() {
    let folder = Folder::new();
    let cells = |holes: &[Vec<[f64; 2]>]| {
        let rings: Vec<Vec<[f64; 2]>> = std::iter::once(square(0.0, 0.0, 10.0)).chain(holes.iter().cloned()).collect();
        folder.write("c.geojson", &city(&[feature(&json!({"height": 9}), &rings)]));
        let document = folder.type_in("info c.geojson --extent -10,-10,30,30 --cell 1 --json -q").done().json();
        (document["cells"]["building"].as_u64().unwrap(), document["faults"]["stray_holes"].as_u64().unwrap())
    };
    assert_eq!(cells(&[square(2.0, 2.0, 3.0)]), (91, 0));
    assert_eq!(cells(&[square(20.0, 20.0, 5.0)]), (100, 1));
    assert_eq!(cells(&[square(8.0, 8.0, 4.0)]), (96, 1));
    assert_eq!(cells(&[square(-5.0, -5.0, 30.0)]), (0, 1));
    assert_eq!(cells(&[square(1.0, 1.0, 4.0), square(3.0, 3.0, 4.0)]), (100 - 28, 0));
}

#[test]
fn a_hole_outside_of_its_shell_is_in_no_area() {
    let folder = Folder::new();
    folder.write("flat.asc", &grid((0.0, 0.0), 1.0, 20, &[0.0; 400]));
    let place = |hole: Vec<[f64; 2]>, flags: &str| {
        let area =
            json!({"type": "FeatureCollection", "features": [feature(&json!({}), &[square(0.0, 0.0, 10.0), hole])]});
        folder.write("a.geojson", &area.to_string());
        folder.type_in(&format!("place flat.asc --ground 0 --step 1 --height 9 {flags} --json -q")).done().json()
    };
    // 10 × 10 cells of 20 × 20 are inside, less what the hole covers of them.
    for (hole, inside) in [
        (square(2.0, 2.0, 5.0), 75),
        (square(12.0, 12.0, 5.0), 100),
        (vec![[5.0, 5.0], [15.0, 5.0], [15.0, 8.0], [5.0, 8.0]], 85),
        (square(10.0, 10.0, 5.0), 100),
    ] {
        let tried = |flags: &str| place(hole.clone(), flags)["candidates"]["tried"].clone();
        assert_eq!((tried("--within a.geojson"), tried("--keep-out a.geojson")), (json!(inside), json!(400 - inside)));
        let goal = place(hole.clone(), "--area a.geojson --goal p_los(area)");
        assert_eq!(goal["winner"]["receivers"], inside, "{hole:?}");
    }
}

#[test]
fn ends_of_links_are_on_the_lattice_of_meters_whatever_the_terrains_cells() {
    let folder = Folder::new();
    let mut random = Random(7);
    let mut n_methods = [0, 0];
    for (cell, parts, side) in [(2.0, 2_usize, 32), (2.5, 5, 40), (5.0, 5, 80)] {
        let n = 16;
        // Rough ground: what hides a receiver is often a corner.
        let heights: Vec<f64> = (0..n * n).map(|_| random.within(0, 3000) as f64 / 256.0).collect();
        let fine: Vec<f64> = (0..n * parts * n * parts)
            .map(|k| heights[k / (n * parts) / parts * n + k % (n * parts) / parts])
            .collect();
        folder.write("coarse.asc", &grid((0.0, 0.0), cell, n, &heights));
        folder.write("fine.asc", &grid((0.0, 0.0), cell / parts as f64, n * parts, &fine));
        let house = feature(&json!({"height": 6}), &[vec![[4.3, 4.1], [9.2, 5.0], [8.8, 9.6], [3.9, 8.8]]]);
        folder.write("c.geojson", &city(&[house]));
        for _ in 0..if is_long() { 60 } else { 12 } {
            let at = |random: &mut Random| random.within(1, side * 1024 - 1) as f64 / 1024.0;
            let (x, y) = (at(&mut random), at(&mut random));
            let of = |terrain: &str| {
                let line = format!(
                    "map c.geojson --terrain {terrain} --extent 0,0,{side},{side} --cell 0.5 --uav {x},{y},30amsl --json -q"
                );
                let document = folder.type_in(&line).done().json();
                (document["digest"].clone(), document["method"].as_str().unwrap() == "shadow+sweep")
            };
            let (coarse, fine) = (of("coarse.asc"), of("fine.asc"));
            assert_eq!(coarse.0, fine.0, "cells of {cell} m in {parts} parts, UAV at {x}, {y}");
            n_methods[usize::from(fine.1)] += 1;
        }
    }
    // Split into cells of half a meter the terrain is swept, into those of a meter it is walked over.
    assert!(n_methods.iter().all(|n| *n > 0), "{n_methods:?}");
}

#[test]
fn an_extent_has_as_many_rows_and_columns_anywhere_on_earth() {
    let folder = Folder::new();
    for (x, y) in [(0.0, 0.0), (691_549.7, 5_334_762.2), (-2_000_037.3, 9_999_990.1), (166_021.44, 0.05)] {
        let (east, north): (f64, f64) = (x + 27.9, y + 27.9);
        folder.write("c.geojson", &city(&[feature(&json!({"height": 3}), &[square(x + 3.0, y + 3.0, 4.0)])]));
        let line = format!("info c.geojson --extent {x},{y},{east},{north} --cell 0.1 --json -q");
        let document = folder.type_in(&line).done().json();
        assert_eq!((&document["cols"], &document["rows"]), (&json!(279), &json!(279)), "{x}, {y}");
        // Footprints that end on whole cells need no more.
        folder.write("c.geojson", &city(&[feature(&json!({"height": 3}), &[square(x, y, 27.9)])]));
        let document = folder.type_in("info c.geojson --cell 0.1 --json -q").done().json();
        let n = document["cols"].as_u64().unwrap();
        assert!(n == 279 || (n == 280 && (x * 10.0 - (x * 10.0).round()).abs() > 1e-3), "{x}: {n}");
    }
}

#[test]
fn voids_of_a_terrain_on_the_grid_of_the_surface_are_told() {
    let folder = Folder::new();
    folder.write("s.asc", &grid((0.0, 0.0), 1.0, 4, &[5.0; 16]));
    let mut terrain = [1.0; 16];
    (terrain[3], terrain[6]) = (-9999.0, -9999.0);
    folder.write("t.asc", &grid((0.0, 0.0), 1.0, 4, &terrain));
    let document = folder.type_in("info s.asc --terrain t.asc --json -q").done().json();
    assert_eq!(document["cells"]["nodata"], 2);
    assert!(warns(&document, "W340", "2 of 16 cells"), "{document}");
    folder.write("t.asc", &grid((0.0, 0.0), 1.0, 4, &[1.0; 16]));
    let document = folder.type_in("info s.asc --terrain t.asc --json -q").done().json();
    assert!(!document["warnings"].to_string().contains("W340"), "{document}");
}

#[test]
fn ties_of_range_are_in_on_all_sides() {
    let folder = Folder::new();
    for (x, y, cell, reach) in
        [(691_549.3, 5_334_762.7, 0.1, 25_i32), (4_000_000.2, 7_000_000.9, 0.3, 5), (0.0, 0.0, 1.0, 25)]
    {
        folder.write("s.asc", &grid((x, y), cell, 61, &[0.0; 61 * 61]));
        // Over the center of the middle cell: cells whose offsets a, b satisfy a² + b² ≤ (r/c)² are in range.
        let (uav_x, uav_y) = (x + 30.5 * cell, y + 30.5 * cell);
        let wanted = (-30..=30)
            .flat_map(|a: i32| (-30..=30).map(move |b: i32| a * a + b * b))
            .filter(|d| *d <= reach * reach)
            .count();
        let radius = f64::from(reach) * cell;
        let line = format!("map s.asc --ground 0 --uav {uav_x},{uav_y},50 --radius {radius} --json -q");
        let document = folder.type_in(&line).done().json();
        assert_eq!(document["sites"][0]["receivers"], wanted, "cells of {cell} m, {radius} m");
        // Over footprints cells have any size too. A house stands in the corner, out of range.
        folder.write("c.geojson", &city(&[feature(&json!({"height": 3}), &[square(x, y, 10.0 * cell)])]));
        let (east, north) = (x + 61.0 * cell, y + 61.0 * cell);
        let scene = format!("c.geojson --extent {x},{y},{east},{north} --cell {cell}");
        let line = format!("map {scene} --uav {uav_x},{uav_y},50 --radius {radius} --json -q");
        let document = folder.type_in(&line).done().json();
        assert_eq!(document["sites"][0]["receivers"], wanted, "footprints, cells of {cell} m, {radius} m");
    }
}

#[test]
fn heights_between_lattice_steps_round_up_at_one_half_in_every_format() {
    let folder = Folder::new();
    // 10 m and half a step; a little less rounds down.
    let (half, less) = (10.0 + 0.5 / 1024.0, 10.0 + 0.49 / 1024.0);
    let (up, down) = (10.0 + 1.0 / 1024.0, 10.0);
    folder.write("s.asc", &grid((0.0, 0.0), 1.0, 2, &[half, less]));
    assert_eq!(folder.type_in("info s.asc --json -q").done().json()["surface_m"], json!([down, up]));
    let triangle = |z: f64| format!("v 0 0 {z}\nv 4 0 {z}\nv 0 4 {z}\nf 1 2 3\n");
    for (z, wanted) in [(half, up), (less, down)] {
        folder.write("m.obj", &triangle(z));
        assert_eq!(
            folder.type_in("info m.obj --json -q").done().json()["surface_m"],
            json!([wanted, wanted]),
            "mesh {z}"
        );
        let corners = [[0, 0], [8, 0], [8, 8], [0, 8]];
        let vertices: Vec<[i32; 3]> = [-10, 0].iter().flat_map(|z| corners.map(|[x, y]| [x, y, *z])).collect();
        let faces = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];
        let solid = json!({"type": "Solid", "lod": "1", "boundaries": [faces.map(|face| [face])]});
        // The transform carries the fraction: vertices are integers.
        let object = json!({"type": "CityJSON", "version": "1.1",
            "transform": {"scale": [1.0, 1.0, 1.0], "translate": [0.0, 0.0, z]},
            "metadata": {"referenceSystem": "https://www.opengis.net/def/crs/EPSG/0/25832"},
            "vertices": vertices,
            "CityObjects": {"a": {"type": "Building", "geometry": [solid]}}});
        folder.write("c.city.json", &object.to_string());
        folder.type_in("city c.city.json -o out.geojson -q --overwrite").done();
        assert_eq!(folder.json("out.geojson")["features"][0]["properties"]["z_top"], wanted, "CityJSON {z}");
        folder.write("c.geojson", &city(&[feature(&json!({"height": z}), &[square(0.0, 0.0, 8.0)])]));
        folder.type_in("city c.geojson -o out.geojson -q --overwrite").done();
        assert_eq!(folder.json("out.geojson")["features"][0]["properties"]["z_top"], wanted, "footprint {z}");
    }
    // A receiver's height is rounded likewise, above what it stands on: 1.7 m are 1740.8 steps, so 1741.
    let margin = |height: &str| {
        let line = format!("link s.asc --ground 10 --uav 0.5,0.5,50 --rx 1.5,0.5,{height} --json -q");
        folder.type_in(&line).done().json()["margin_m"].as_f64().unwrap()
    };
    let step = 1.0 / 1024.0;
    assert!((margin("1.7") - 1741.0 * step).abs() < step && (margin("1.7") - margin("1.7001953125")).abs() < 1e-12);
}

#[test]
fn a_roof_at_or_below_the_ground_hides_nothing_and_is_open_ground() {
    let folder = Folder::new();
    let digest = |tops: &[f64]| {
        let features: Vec<Value> = std::iter::once(feature(&json!({"z_top": 20.0}), &[square(30.0, 30.0, 6.0)]))
            .chain(tops.iter().map(|z| feature(&json!({"z_top": z}), &[square(10.0, 10.0, 8.0)])))
            .collect();
        folder.write("c.geojson", &city(&features));
        let line = "map c.geojson --top-field z_top --ground 5 --extent 0,0,50,50 --uav 2,2,20 --json -q";
        let document = folder.type_in(line).done().json();
        (document["digest"].clone(), document["sites"][0]["receivers"].as_u64().unwrap())
    };
    let without = digest(&[]);
    assert_eq!((digest(&[5.0]), digest(&[3.0]), digest(&[-40.0])), (without.clone(), without.clone(), without.clone()));
    assert_eq!(digest(&[5.01]).1, without.1 - 64);
}
