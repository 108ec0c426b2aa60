//! What captions say of how a picture was made and of what limits it: refined curves, bands of angles, where data are missing.

use crate::data_area::town;
use crate::figures::{drawn, picture_of, words};
use crate::program::Folder;

/// The points of the only line of a figure, as written.
fn line_points(svg: &str) -> Vec<&str> {
    let lines: Vec<&str> = svg.split("<polyline points=\"").skip(1).collect();
    assert_eq!(lines.len(), 1, "{svg}");
    lines[0].split('"').next().unwrap().split_whitespace().collect()
}

/// The centers of the markers drawn as circles, written as points of lines are.
fn markers(svg: &str) -> Vec<String> {
    let number = |circle: &str, name: &str| {
        circle.split(&format!("{name}=\"")).nth(1).unwrap().split('"').next().unwrap().to_string()
    };
    let circles = svg.split("<circle ").skip(1);
    circles.map(|circle| format!("{},{}", number(circle, "cx"), number(circle, "cy"))).collect()
}

#[test]
fn the_line_of_the_product_goes_through_its_markers_and_more_values() {
    let folder = Folder::new();
    let line = "plos itu:urban --users street --theta 5:85:5 --height 100 --method product --csv z.csv";
    let svg = drawn(&folder, line);
    assert!(words(&svg).contains("Markers are what was asked for"), "{svg}");
    let n_asked = folder.text("z.csv").lines().skip(1).count();
    assert_eq!(n_asked, 17, "5° to 85° in steps of 5°");
    let (points, markers) = (line_points(&svg), markers(&svg));
    // The last marker is that of the legend.
    assert_eq!(markers.len(), n_asked + 1, "{markers:?}");
    let off: Vec<&String> = markers[..n_asked].iter().filter(|at| !points.contains(&at.as_str())).collect();
    assert!(points.len() > n_asked && off.is_empty(), "{off:?} of {points:?}");
    // A model has no markers to speak of.
    let said = words(&drawn(&folder, "plos itu:urban --theta 5:85:5 --method itu"));
    assert!(!said.contains("Markers"), "{said}");
}

#[test]
fn the_band_of_angles_stands_in_the_caption_over_a_real_city() {
    let folder = Folder::new();
    town(&folder);
    let city = "plos town.geojson --positions 5 --height 60 --theta 20:80:20 --method maps";
    for (line, band) in [
        (city.to_string(), Some("within θ ± 2.5°")),
        (format!("{city} --theta-band 4"), Some("within θ ± 4°")),
        // At an angle exactly.
        ("plos itu:urban --theta 20:80:20".to_string(), None),
    ] {
        let said = words(&drawn(&folder, &line));
        assert_eq!(said.contains("θ ±"), band.is_some(), "{line}: {said}");
        assert!(band.is_none_or(|band| said.contains(band)), "{line}: {said}");
    }
}

/// What a caption may say of the limits of a picture.
const NO_DATA: &str = "No data beyond the footprints";
const SURFACE_ALONE: &str = "surface model alone";
const FLAT_EARTH: &str = "earth is taken as flat";

/// Scenes with one limit each, or none: UAVs over them, a step between candidates [m].
const SCENES: [(&str, [&str; 2], u32, Option<&str>); 4] = [
    ("town.geojson", ["50,50,30", "50,10,20"], 20, Some(NO_DATA)),
    ("surface.asc", ["12,12,30", "52,52,30"], 20, Some(SURFACE_ALONE)),
    ("wide.asc --ground 0", ["1500,1500,100", "7500,7500,100"], 3000, Some(FLAT_EARTH)),
    ("itu:urban --size 100", ["10,10,50", "60,10,50"], 20, None),
];

/// A surface of some cells along each side, flat but for one of them.
fn surface(n_cells: usize, cell_m: u32) -> String {
    let rows = (0..n_cells).map(|row| vec![if row == 1 { "0 8 0 0" } else { "0 0 0 0" }; n_cells / 4].join(" "));
    let head = format!("ncols {n_cells}\nnrows {n_cells}\nxllcorner 0\nyllcorner 0\ncellsize {cell_m}\n");
    format!("{head}NODATA_value -9999\n{}\n", rows.collect::<Vec<_>>().join("\n"))
}

#[test]
fn captions_of_maps_and_searches_say_what_limits_them_and_nothing_else() {
    let folder = Folder::new();
    town(&folder);
    folder.write("surface.asc", &surface(16, 5));
    // The far corner of 12 × 12 km lies 15 km away, where the earth has dropped by 17 m.
    folder.write("wide.asc", &surface(4, 3000));
    for (scene, [first, second], step, limit) in SCENES {
        let place = format!("place {scene} --height 60 --step {step}");
        for line in [
            format!("map {scene} --uav {first} -o"),
            format!("map {scene} --uav {first} --uav {second} --layers which -o"),
            format!("map {scene} --uav {first} --height-curve"),
            format!("compare {scene} --uav {first} --uav {second} -o"),
            format!("{place} -o"),
            format!("{place} --map"),
            format!("chart {scene} --uav {first} --time 0 -o"),
        ] {
            let said = words(&picture_of(&folder, &line));
            says_only(&said, limit, &line);
        }
    }
}

/// Among the limits that a caption may tell, it tells this one and no other.
fn says_only(said: &str, limit: Option<&str>, line: &str) {
    for any in [NO_DATA, SURFACE_ALONE, FLAT_EARTH] {
        assert_eq!(said.contains(any), limit == Some(any), "{line}: {any}: {said}");
    }
}

#[test]
fn captions_of_links_tracks_and_means_say_where_the_earth_is_no_longer_flat() {
    let folder = Folder::new();
    folder.write("wide.asc", &surface(4, 3000));
    folder.write("walk.csv", "x,y\n2000,2000\n11000,11000\n");
    folder.write("stroll.csv", "x,y\n2000,2000\n4000,2000\n");
    let link = "link wide.asc --ground 0 --uav 1500,1500,100";
    let track = "track wide.asc --ground 0 --uav 1500,1500,100";
    let place = "sample wide.asc --ground 0 --height 60 --zones rooftop:9";
    let plos = "plos wide.asc --ground 0 --height 40 --positions 3 --method maps";
    // The earth drops by a meter in 3.57 km.
    for (line, limit) in [
        (format!("{link} --rx 5100,1500 -o"), Some(FLAT_EARTH)),
        (format!("{link} --rx 5000,1500 -o"), None),
        (format!("{track} --track walk.csv -o"), Some(FLAT_EARTH)),
        (format!("{track} --track stroll.csv -o"), None),
        (format!("{place} -o"), Some(FLAT_EARTH)),
        (format!("{place} --radius 3500 -o"), None),
        (format!("{plos} --radius 3600:4000:400 -o"), Some(FLAT_EARTH)),
        (format!("{plos} --radius 3000:3500:500 -o"), None),
        (format!("{plos} --theta 0.5:0.6:0.1 -o"), Some(FLAT_EARTH)),
        (format!("{plos} --theta 5:6:1 -o"), None),
    ] {
        says_only(&words(&picture_of(&folder, &line)), limit, &line);
    }
}

#[test]
fn captions_without_a_uav_of_ones_own_say_where_data_are_missing() {
    let folder = Folder::new();
    town(&folder);
    folder.write("surface.asc", &surface(16, 5));
    let plos = "--method maps --theta 45 --height 40 --positions 5 -o";
    for (line, limit) in [
        ("zones town.geojson -o".to_string(), Some(NO_DATA)),
        ("zones town.geojson --extent 0,0,100,100 -o".to_string(), None),
        ("sample town.geojson --zones street:5 --height 60 -o".to_string(), Some(NO_DATA)),
        ("sample town.geojson --zones street:5 --height 60 --data-area all -o".to_string(), None),
        (format!("plos town.geojson {plos}"), Some(NO_DATA)),
        (format!("plos surface.asc {plos}"), Some(SURFACE_ALONE)),
        (format!("plos surface.asc --ground 0 {plos}"), None),
        ("city town.geojson -o".to_string(), Some(NO_DATA)),
        ("city surface.asc -o".to_string(), Some(SURFACE_ALONE)),
        ("city surface.asc --ground 0 -o".to_string(), None),
    ] {
        says_only(&words(&picture_of(&folder, &line)), limit, &line);
    }
}
