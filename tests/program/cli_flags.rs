//! Where flags of the scene, the UAVs and the receivers change the document of a map. What else a flag changes is shown
//! where it belongs; that none is taken in silence is shown by `idle_flags`.

use crate::cli::{plan, scenes};

/// A scene and a UAV, where the documents differ, and flags with each of which they do.
const PLAN_FLAGS: [(&str, &str, &str); 14] = [
    ("city.geojson --uav 2,2,50", "/sites/0/height_amsl_m", "--ground 5"),
    (
        "city.geojson --uav 2,2,50",
        "/digest",
        "--height-field tall; --top-field z_top; --missing levels; --height-unit ft",
    ),
    (
        "city.geojson --uav 2,2,50",
        "/digest",
        "--terrain slope.asc; --data-area all; --rx-height 9; --receivers all; --radius 25",
    ),
    ("city.geojson --uav 2,2,50 --missing levels", "/digest", "--levels-field tall"),
    ("city.geojson --uav 2,2,50 --terrain slope.asc", "/digest", "--base highest"),
    ("city.geojson --uav 2,2,50", "/scene/cols", "--extent 0,0,50,50"),
    ("city.geojson --uav 2,2,50", "/scene/cell_m/0", "--cell 0.5"),
    ("city.geojson --uav 2,2,50", "/scene/crs", "--crs EPSG:25832"),
    ("city.geojson --uav 2,2,50", "/sites/1/id", "--uav 40,40,50; --uavs sites.csv"),
    ("dsm.asc --ground 0 --uav 2,2,50", "/sites/0/receivers", "--building-threshold 3"),
    ("dsm.asc --ground 0 --uav 15,2,5", "/digest", "--nodata-as block"),
    ("itu:urban --uav 2,2,50", "/scene/cols", "--size 200"),
    ("itu:urban --size 200 --uav 2,2,50", "/digest", "--seed 2"),
    ("itu:urban --size 200 --uav 2,2,50", "/method", "--method ray"),
];

#[test]
fn every_flag_changes_the_plan() {
    let folder = scenes();
    for (base, pointer, flags) in PLAN_FLAGS {
        let without = plan(&folder, base);
        for flag in flags.split("; ") {
            let with = plan(&folder, &format!("{base} {flag}"));
            assert_ne!(without.pointer(pointer), with.pointer(pointer), "{flag}: {with}");
        }
    }
}
