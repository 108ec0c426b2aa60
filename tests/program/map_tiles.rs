//! Maps in tiles: cell for cell those of the whole, whatever a tile reads and whoever hands tiles out; and what `jobs` tells of units.

use std::collections::BTreeMap;

use serde_json::Value;
use skyshed_core::raster::GeoRef;
use skyshed_io::formats::{GeoTiff, RasterFile};
use skyshed_io::read::surface_grid;

use crate::program::{Answer, Folder};
use crate::support::{Random, is_long};

/// UAVs in and around a square of `side` meters; some stand on borders of tiles of 64 cells, two at places of equal distances.
fn write_uavs(folder: &Folder, n: usize, side: i64, seed: u64) {
    let mut random = Random(seed);
    let mut table = String::from("id,x,y,h\n");
    for k in 0..n {
        let mut at = || match random.within(0, 4) {
            0 => format!("{}", 64 * random.within(0, side / 64)),
            1 => format!("{}.5", 64 * random.within(0, side / 64)),
            _ => format!("{}.{}", random.within(-40, side + 40), random.within(0, 999)),
        };
        let (x, y) = (at(), at());
        table += &format!("s{k},{x},{y},{}amsl\n", random.within(190, 230));
    }
    table += "twin a,96.5,96.5,220amsl\ntwin b,128.5,96.5,220amsl\n";
    folder.write("sites.csv", &table);
}

/// The bands of a raster by name.
type Bands = BTreeMap<String, Vec<u32>>;

/// The bands of a raster of one file.
fn bands(folder: &Folder, name: &str) -> (GeoRef, Bands) {
    let file = GeoTiff::open(folder.join(name), &mut Vec::new()).unwrap_or_else(|e| panic!("{name}: {e}"));
    let window = file.georef().window();
    let found = (0..file.n_bands()).map(|band| {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "numbers of the file")]
        let number = |v: f64| if v.is_nan() { u32::MAX } else { v as u32 };
        let cells = match file.read_band(band, window, &mut Vec::new(), number) {
            Ok(cells) => cells.into_cells().into_vec(),
            // Our reader wants heights.
            Err(e) if e.to_string().contains("none of the") => vec![u32::MAX; file.georef().n_cells()],
            Err(e) => panic!("{name}, band {band}: {e}"),
        };
        (format!("{band}"), cells)
    });
    (file.georef().clone(), found.collect())
}

/// Compares every cell of every tile with the whole, and returns the documents of the tiles.
fn same_cells(folder: &Folder, whole: &str, tile_of: impl Fn(usize, usize) -> String, side: usize) -> usize {
    let (grid, of_whole) = bands(folder, whole);
    let mut n_tiles = 0;
    for row in 0..grid.n_rows().div_ceil(side) {
        for col in 0..grid.n_cols().div_ceil(side) {
            let name = tile_of(row, col);
            let (part, of_tile) = bands(folder, &name);
            let window = grid.window_of(&part).unwrap_or_else(|| panic!("{name}: {}", part.description()));
            assert_eq!((window.row, window.col), (row * side, col * side), "{name}");
            assert_eq!(of_tile.len(), of_whole.len(), "{name}");
            for (band, cells) in &of_tile {
                let rows = of_whole[band].chunks(grid.n_cols()).skip(window.row).take(window.n_rows);
                let wanted: Vec<u32> =
                    rows.flat_map(|row| &row[window.col..window.col + window.n_cols]).copied().collect();
                assert!(*cells == wanted, "{name}, band {band}");
            }
            n_tiles += 1;
        }
    }
    n_tiles
}

/// Receivers and those in line of sight of each UAV.
fn counts(documents: &[Value]) -> BTreeMap<String, (u64, u64)> {
    let mut sums = BTreeMap::new();
    for site in documents.iter().flat_map(|document| document["sites"].as_array().expect("sites")) {
        let sum: &mut (u64, u64) = sums.entry(site["id"].as_str().expect("an id").to_string()).or_default();
        sum.0 += site["receivers"].as_u64().expect("a count");
        sum.1 += site["los"].as_u64().expect("a count");
    }
    sums.retain(|_, (receivers, _)| *receivers > 0);
    sums
}

#[test]
fn tiles_are_cut_from_the_map_of_the_whole() {
    let scenes = [
        "city itu:urban --size 300 --seed 3 -o dsm.tif -q",
        "city itu:high-rise --size 300 --seed 4 -o dsm.asc -q",
        "city itu:dense-urban --size 300 --seed 5 --cell 0.75 -o dsm.geojson -q",
    ];
    let radii: &[u32] = if is_long() { &[7, 33, 64, 100, 150, 400] } else { &[33, 150] };
    for (k, scene) in scenes.iter().enumerate() {
        let folder = Folder::new();
        folder.type_in(scene).done();
        let file = scene.split_whitespace().find(|word| word.starts_with("dsm")).expect("a file");
        let ground = if file.ends_with("geojson") { "--cell 0.75" } else { "--ground 0" };
        for radius in radii {
            write_uavs(&folder, if is_long() { 60 } else { 20 }, 300, 7 * k as u64 + u64::from(*radius));
            let layers = "--layers union,count,best-server,which";
            let asked =
                format!("map {file} {ground} --uavs sites.csv --radius {radius} --receivers all -q --overwrite");
            // Sets of more than 31 UAVs and counts are no bands of one file.
            let layers = if is_long() { "--layers union,count,best-server" } else { layers };
            let sets = "--layers which --tile-size 128 -o w{row}-{col}.tif";
            folder.type_in(&format!("{asked} {layers} -o all.tif -o all.json")).done();
            let tiles = "--tile-size 64 -o {row}-{col}.tif -o {row}-{col}.json";
            folder.type_in(&format!("{asked} {layers} {tiles}")).done();
            let n_tiles = same_cells(&folder, "all.tif", |row, col| format!("{row}-{col}.tif"), 64);
            assert!(n_tiles >= 25, "{n_tiles}");
            folder.type_in(&format!("{asked} --layers which -o all-w.tif")).done();
            folder.type_in(&format!("{asked} {sets}")).done();
            same_cells(&folder, "all-w.tif", |row, col| format!("w{row}-{col}.tif"), 128);
            // A cell counts once, also of UAVs on a border.
            let documents: Vec<Value> = folder
                .files()
                .iter()
                .filter(|name| name.ends_with(".json") && name.contains('-'))
                .map(|name| folder.json(name))
                .collect();
            assert_eq!(documents.len(), n_tiles);
            let all = folder.json("all.json");
            assert_eq!(counts(&documents), counts(std::slice::from_ref(&all)), "{file}, {radius}");
            let union = |name: &str| documents.iter().map(|d| d["union"][name].as_u64().expect("a count")).sum::<u64>();
            assert_eq!(
                [union("receivers"), union("los")].map(Value::from),
                [&all["union"]["receivers"], &all["union"]["los"]].map(Value::clone)
            );
        }
    }
}

#[test]
fn a_tile_does_not_depend_on_who_hands_it_out() {
    let folder = Folder::new();
    folder.type_in("city itu:urban --size 200 --seed 3 -o dsm.tif -q").done();
    write_uavs(&folder, 9, 200, 1);
    let line =
        "map dsm.tif --ground 0 --uavs sites.csv --radius 70 --layers count,best-server --tile-size 64 --resume -q";
    let names = |to: &str| format!("-o {to}{{row}}/{{col}}.tif -o {to}{{row}}/{{col}}.csv");
    folder.type_in(&format!("{line} {}", names("a/"))).done();
    // In shards out of order, one twice, after a tile of its own.
    folder.type_in(&format!("{line} {} --tile 1,2", names("b/"))).done();
    for shard in ["3/3", "1/3", "1/3", "2/3"] {
        // Numbers in other spellings are the same numbers.
        let other = line.replace("--radius 70", "--radius 7e1").replace("64", "064");
        folder.type_in(&format!("{other} {} --shard {shard} -j 1", names("b/"))).done();
    }
    for row in 0..4 {
        for col in 0..4 {
            for end in ["tif", "csv", "csv.json"] {
                let read = |to: &str| std::fs::read(folder.join(&format!("{to}/{row}/{col}.{end}"))).expect("a file");
                assert!(read("a") == read("b"), "{row}/{col}.{end}");
            }
        }
    }
    // One tile alone is a map like any other.
    let counts = folder.type_in("map dsm.tif --ground 0 --uavs sites.csv --radius 70 --tile-size 64 --tile 1,2 --json");
    let document = counts.done().json();
    assert_eq!((&document["tile"]["row"], &document["tile"]["col"]), (&1.into(), &2.into()));
    assert_eq!(document["scene"]["cols"], 64);
    // A tile without UAVs says that all is out of range.
    folder.write("far.csv", "id,x,y,h\na,20,20,100\n");
    let far = "map dsm.tif --ground 0 --uavs far.csv --radius 30 --tile-size 64 --tile 0,3 --layers union,count";
    folder.type_in(&format!("{far} -o far.tif -o far.json -q")).done();
    let (_, far) = bands(&folder, "far.tif");
    assert!(far["0"].iter().all(|class| *class == 3) && far["1"].iter().all(|count| *count == u32::MAX));
    assert_eq!(folder.json("far.json")["sites"], Value::Array(Vec::new()));
}

#[test]
fn what_a_tile_cannot_be_is_refused() {
    let folder = Folder::new();
    folder.type_in("city itu:urban --size 100 --seed 3 -o dsm.tif -q").done();
    folder.write("sites.csv", "id,x,y,h\na,20,20,100\n");
    let line = "map dsm.tif --ground 0 --uavs sites.csv --radius 30 --layers count -o {row}-{col}.tif";
    for (more, code) in [
        ("-o {row}.json", "E105"),
        ("-o {site}-{row}-{col}.json", "E105"),
        ("-o all.json", "E105"),
        ("--zones -o {row}-{col}.json", "E116"),
        ("--tolerance 0.01", "E116"),
        ("--strips", "E116"),
        ("--receivers street", "E116"),
        ("--json", "E116"),
        ("--tile 9,0", "E113"),
        ("--tile 9", "E101"),
        ("-o x{row}{col}.tif", "E105"),
        ("--method r2", "E116"),
        ("--tile-size 100", "E101"),
        ("--tile-size 0", "E101"),
    ] {
        let answer = folder.type_in(&format!("{line} {more}"));
        assert_eq!(answer.error(), code, "{more}: {answer:?}");
    }
    for (line, code) in [
        ("map dsm.tif --ground 0 --uavs sites.csv -o {row}-{col}.tif", "E107"),
        ("map dsm.tif --ground 0 --uavs sites.csv --layers count,margin -o {row}-{col}.tif", "E107"),
        ("map dsm.tif --ground 0 --uavs sites.csv --tile-size 64 -o a.tif", "E116"),
        ("jobs plan map dsm.tif --ground 0 --uavs sites.csv -o a.tif", "E116"),
        ("jobs plan map dsm.tif --ground 0 --uavs sites.csv --layers count -o {row}-{col}.kmz", "E107"),
        ("jobs merge --overwrite -o sites.csv map dsm.tif --ground 0 --uavs sites.csv -o {site}.tif", "E105"),
        ("jobs merge --overwrite -o a.json map dsm.tif --ground 0 --uavs sites.csv -o {site}.json", "E105"),
        ("jobs plan link dsm.tif --uav 1,1,50 --rx 2,2", "E101"),
        ("jobs status -o a.csv map dsm.tif --ground 0 --uavs sites.csv -o {site}.tif", "E116"),
        ("jobs merge -o a.vrt map dsm.tif --ground 0 --uavs sites.csv -o {site}.tif", "E603"),
    ] {
        let answer = folder.type_in(line);
        assert_eq!(answer.error(), code, "{line}: {answer:?}");
    }
    assert_eq!(folder.files(), ["dsm.tif", "sites.csv"].map(String::from)[..]);
}

fn lines(answer: Answer) -> Vec<Value> {
    answer.done().out.lines().map(|line| serde_json::from_str(line).expect("a line of JSON")).collect()
}

#[test]
fn jobs_tell_what_there_is_to_do_what_is_done_and_what_all_come_to() {
    let folder = Folder::new();
    let munich = concat!(env!("CARGO_MANIFEST_DIR"), "/maps/munich.geojson");
    let mut random = Random(2);
    let row = |k| {
        let (x, y) = (random.within(690_800, 692_300), random.within(5_334_100, 5_335_400));
        format!("s{k},{x},{y},150amsl\n")
    };
    folder.write("sites.csv", &format!("id,x,y,h\n{}", (0..14).map(row).collect::<String>()));
    let scene = format!("map {munich} --uavs sites.csv --radius 250 --layers count,union");
    let asked = format!("{scene} --tile-size 512 -o t/{{row}}-{{col}}.tif");
    std::fs::create_dir(folder.join("t")).expect("a folder");
    let plan = lines(folder.type_in(&format!("jobs plan {asked}")));
    assert_eq!(plan.len(), 9);
    let status = |folder: &Folder| folder.type_in(&format!("jobs status --json {asked}"));
    let none = status(&folder);
    assert_eq!((none.code(), none.json()["missing"].as_array().map(Vec::len)), (6, Some(9)), "{none:?}");
    // A scheduler runs every unit by its word.
    for unit in plan.iter().rev() {
        let shard = unit["shard"].as_str().expect("a word");
        folder.type_in(&format!("{asked} --shard {shard} --resume -q")).done();
        let files = unit["files"].as_array().expect("files");
        assert!(files.iter().all(|file| folder.join(file.as_str().expect("a name")).exists()), "{unit}");
        assert!(unit["seconds"].as_f64() > Some(0.0) && unit["memory_bytes"].as_u64() > Some(1 << 20), "{unit}");
    }
    let all = status(&folder).done().json();
    assert_eq!(
        (&all["done"], &all["missing"], &all["broken"]),
        (&9.into(), &Value::Array(vec![]), &Value::Array(vec![]))
    );
    let merged = "-o all.vrt -o all.geojson -o all.csv -o all.parquet -o all.json";
    folder.type_in(&format!("jobs merge {merged} {asked}")).done();
    folder.type_in(&format!("{scene} -o whole.tif -o whole.json -q")).done();
    // The mosaic is the map of the whole.
    let whole = RasterFile::open(folder.join("whole.tif"), &mut Vec::new()).expect("a raster");
    let mosaic = RasterFile::open(folder.join("all.vrt"), &mut Vec::new()).expect("a mosaic");
    assert!(mosaic.georef() == whole.georef());
    let cells =
        |file: &RasterFile| file.read(file.georef().window(), &mut Vec::new(), |v| v).expect("cells").into_cells();
    let equal = |(a, b): (&f64, &f64)| a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan());
    assert!(cells(&mosaic).iter().zip(&cells(&whole)).all(equal));
    // The counts are those of the whole.
    let (document, of_whole) = (folder.json("all.json"), folder.json("whole.json"));
    for name in ["receivers", "los", "p_los"] {
        assert_eq!(document["union"][name], of_whole["union"][name], "{name}");
    }
    let table = folder.text("all.csv");
    assert_eq!(table.lines().count(), 15);
    let header: Vec<&str> = table.lines().next().expect("a header").split(',').collect();
    for (row, site) in table.lines().skip(1).zip(of_whole["sites"].as_array().expect("sites")) {
        let row: BTreeMap<&str, &str> = header.iter().copied().zip(row.split(',')).collect();
        for name in ["receivers", "los"] {
            assert_eq!(row[name], site[name].to_string(), "{row:?}");
        }
        assert_eq!(row["site"], site["id"].as_str().expect("an id"));
    }
    let item = folder.json("all.geojson");
    assert_eq!((&item["type"], &item["stac_version"]), (&"Feature".into(), &"1.1.0".into()));
    assert_eq!(item["assets"].as_object().map(|assets| assets.len()), Some(9));
    assert!(item["properties"]["datetime"].as_str().is_some_and(|at| at.len() == 20 && at.ends_with('Z')), "{item}");
    assert_eq!(item["properties"]["proj:code"], "EPSG:25832");
    // What is cut short or of another run is broken, what is gone is missing, and nothing is merged.
    let tile = folder.join("t/1-1.tif");
    let bytes = std::fs::read(&tile).expect("a tile");
    std::fs::write(&tile, &bytes[..bytes.len() / 2]).expect("it is cut");
    std::fs::copy(folder.join("t/0-0.tif"), folder.join("t/2-2.tif")).expect("it is copied");
    std::fs::remove_file(folder.join("t/2-1.tif")).expect("it is removed");
    let answer = folder.type_in(&format!("jobs status {asked}"));
    assert_eq!(answer.code(), 6);
    assert!(
        answer.out.starts_with("9 units: 6 done, 1 missing, 2 broken\nmissing tile 2,1\nbroken tile 1,1: "),
        "{answer:?}"
    );
    assert!(answer.err.contains("error[E603]"), "{answer:?}");
    assert_eq!(folder.type_in(&format!("jobs merge -o new.csv {asked}")).error(), "E603");
    assert!(!folder.join("new.csv").exists());
}

#[test]
fn what_went_wrong_is_made_again_and_told_by_name() {
    let folder = Folder::new();
    folder.type_in("city itu:urban --size 200 --seed 3 -o dsm.tif -q").done();
    write_uavs(&folder, 6, 200, 4);
    let asked =
        "map dsm.tif --ground 0 --uavs sites.csv --radius 60 --layers count --tile-size 64 -o t/{row}-{col}.tif";
    // Telling of units needs no folder, and makes none.
    assert_eq!(lines(folder.type_in(&format!("jobs plan {asked}"))).len(), 16);
    assert!(folder.type_in(&format!("jobs status {asked}")).out.starts_with("16 units: 0 done, 16 missing, 0 broken"));
    assert!(!folder.join("t").exists());
    std::fs::create_dir(folder.join("t")).expect("a folder");
    // A tile that is named twice is one, and one UAV that is typed has units, too.
    let twice = folder.type_in(&format!("{asked} --tile 1,1 --tile 2,2 --tile 1,1"));
    assert!(twice.done().err.contains("2 tiles mapped"));
    folder.type_in("map dsm.tif --ground 0 --uav 100,100,200amsl --layers count --tile-size 64 --shard 2/4 -o u{row}-{col}.tif").done();
    folder.type_in(&format!("{asked} --resume -q")).done();
    let whole = std::fs::read(folder.join("t/1-1.tif")).expect("a tile");
    // Cut short it is broken, and made again.
    std::fs::write(folder.join("t/1-1.tif"), &whole[..whole.len() - 200]).expect("it is cut");
    std::fs::write(folder.join("t/0-0.tif"), []).expect("it is emptied");
    let broken = folder.type_in(&format!("jobs status {asked}")).out;
    assert!(broken.contains("14 done, 1 missing, 1 broken"), "{broken}");
    assert!(folder.type_in(&format!("{asked} --resume")).done().err.contains("2 tiles mapped, 14 there already"));
    assert!(std::fs::read(folder.join("t/1-1.tif")).expect("a tile") == whole);
    // By any name of the scene and from any folder the units are the same.
    let other = asked.replace("dsm.tif", "./t/../dsm.tif");
    assert!(folder.type_in(&format!("jobs status {other}")).done().out.starts_with("16 units: 16 done"));
    std::fs::create_dir(folder.join("m")).expect("a folder");
    folder.type_in(&format!("jobs merge -o m/all.vrt -o ./b.vrt {asked}")).done();
    for (vrt, name) in [("m/all.vrt", ">../t/0-0.tif<"), ("b.vrt", ">t/0-0.tif<")] {
        assert!(folder.text(vrt).contains(&format!("relativeToVRT=\"1\"{name}")), "{vrt}");
        RasterFile::open(folder.join(vrt), &mut Vec::new()).unwrap_or_else(|e| panic!("{vrt}: {e}"));
    }
    // What stands beside a file of another run is no rest of ours.
    folder
        .type_in(
            "map dsm.tif --crs EPSG:25832 --ground 3 --uavs sites.csv --radius 60 --layers count --tile-size 128 -o p{row}-{col}.bil -q",
        )
        .done();
    let foreign = "map dsm.tif --crs EPSG:25832 --ground 0 --uavs sites.csv --radius 60 --layers count --tile-size 128 --resume -q -o p{row}-{col}";
    assert_eq!(folder.type_in(&format!("{foreign}.asc")).error(), "E106");
    folder.write("p0-0.csv.json", "{}");
    assert_eq!(folder.type_in(&format!("{foreign}.csv").replace(" --layers count", "")).error(), "E106");
    // Two UAVs whose files would be one are told apart among all of them.
    folder.write("two.csv", "id,x,y,h\na b,20,20,200amsl\na_b,60,20,200amsl\n");
    let two = "map dsm.tif --ground 0 --uavs two.csv -o {site}.tif --shard 2/2";
    assert_eq!(folder.type_in(two).error(), "E207");
    // What fails is named, and the rest is done.
    std::fs::remove_file(folder.join("t/3-3.tif")).expect("a tile");
    std::fs::create_dir(folder.join("t/3-3.tif")).expect("a folder of its name");
    std::fs::remove_file(folder.join("t/0-1.tif")).expect("a tile");
    let answer = folder.type_in(&format!("{asked} --resume"));
    assert!(answer.code() != 0 && answer.err.contains("3-3"), "{answer:?}");
    assert!(answer.err.contains("1 tile mapped, 14 there already, 1 not"), "{answer:?}");
    // No flag makes a file of a folder.
    let blocked = folder.type_in(&format!("jobs status {asked}"));
    assert!(blocked.out.contains("broken tile 3,3: cannot write t/3-3.tif: it is a folder"), "{blocked:?}");
    assert!(!blocked.err.contains("hint: "), "{blocked:?}");
}

#[test]
fn several_processes_share_the_units_of_a_folder() {
    let folder = Folder::new();
    folder.type_in("city itu:urban --size 200 --seed 3 -o dsm.tif -q").done();
    write_uavs(&folder, 6, 200, 4);
    let files = "-o {row}-{col}.tif -o {row}-{col}.asc -o {row}-{col}.csv";
    let line = format!(
        "map dsm.tif --ground 0 --uavs sites.csv --radius 60 --layers union --tile-size 32 --resume -q -j 1 {files}"
    );
    let run = || folder.type_in(&line).done();
    std::thread::scope(|scope| (0..4).for_each(|_| drop(scope.spawn(run))));
    assert!(
        folder
            .type_in(&format!("jobs status {}", line.replace(" -q -j 1", "")))
            .done()
            .out
            .starts_with("49 units: 49 done")
    );
}

#[test]
fn merged_sites_are_those_of_one_run() {
    let folder = Folder::new();
    folder.type_in("city itu:urban --size 250 --seed 3 -o dsm.tif -q").done();
    write_uavs(&folder, 12, 250, 2);
    let grid = surface_grid(folder.join("dsm.tif"), &Default::default()).expect("a grid");
    assert_eq!(grid.n_cols(), 250);
    let asked = "map dsm.tif --ground 0 --uavs sites.csv --radius 90 -o {site}.tif";
    assert_eq!(lines(folder.type_in(&format!("jobs plan {asked}"))).len(), 14);
    folder.type_in(&format!("{asked} -q")).done();
    folder.type_in(&format!("jobs merge -o merged.csv {asked}")).done();
    folder.type_in("map dsm.tif --ground 0 --uavs sites.csv --radius 90 -o whole.json -q").done();
    let (whole, table) = (folder.json("whole.json"), folder.text("merged.csv"));
    assert_eq!(table.lines().count(), 15);
    for (row, site) in table.lines().skip(1).zip(whole["sites"].as_array().expect("sites")) {
        let wanted = format!("{},{},", site["receivers"], site["los"]);
        assert!(row.starts_with(site["id"].as_str().expect("an id")) && row.contains(&wanted), "{row}: {wanted}");
    }
    // A mosaic is of tiles.
    assert_eq!(folder.type_in(&format!("jobs merge -o all.vrt {asked}")).error(), "E109");
}
