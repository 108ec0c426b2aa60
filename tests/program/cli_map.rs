//! `skyshed map`: the document, the rasters, tables and pictures, which all hold the same numbers; sites from files.

#![expect(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use std::io::Cursor;

use exr::prelude::{FlatSamples, ReadChannels, ReadLayers};
use geotiff_reader::GeoTiffFile;
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use skyshed_io::formats::RasterFile;

use crate::masks::{MAP, TOWN, mask_of, npy, tif, town};
use crate::program::Folder;
use crate::support::read_png;

const N_COLS: usize = 60;
const N_ROWS: usize = 40;

/// Digest of masks by its definition.
fn digest(masks: &[&[u8]]) -> String {
    let mut hasher = Sha256::new();
    hasher.update(60_u64.to_le_bytes());
    hasher.update(40_u64.to_le_bytes());
    masks.iter().for_each(|mask| hasher.update(mask));
    let hex: Vec<String> = hasher.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
    format!("sha256:{}", hex.concat())
}

/// What GDAL reads beside the pixels: names of bands, and where the file comes from.
pub(crate) fn items(file: &GeoTiffFile) -> String {
    file.tiff().ifd(0).unwrap().tag(42112).unwrap().value.as_str().unwrap().to_string()
}

fn count(mask: &[u8], class: u8) -> u64 {
    mask.iter().filter(|c| **c == class).count() as u64
}

/// The channels of an `.exr` file by name.
pub(crate) fn channels(folder: &Folder, file: &str) -> Vec<(String, FlatSamples)> {
    let read = exr::prelude::read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer();
    let image = read.all_attributes().from_buffered(Cursor::new(folder.read(file))).unwrap();
    let list = image.layer_data.channel_data.list;
    list.into_iter().map(|channel| (channel.name.to_string(), channel.sample_data)).collect()
}

#[test]
fn the_document_has_the_keys_that_tools_rely_on() {
    let folder = town();
    let document = folder.type_in(&format!("{MAP} --uav 691650,5334780,60 --zones --json")).done().json();
    assert_eq!(document["schema"], "skyshed/map/1");
    assert_eq!(document["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(document["command"][0], "map");
    assert!(document["method"].is_string());
    let scene = &document["scene"];
    assert_eq!((&scene["cols"], &scene["rows"]), (&json!(60), &json!(40)));
    assert_eq!((&scene["cell_m"], &scene["crs"]), (&json!([1.0, 1.0]), &json!("EPSG:25832")));
    let source = &scene["sources"][0];
    let hash: String = Sha256::digest(TOWN.as_bytes()).iter().map(|byte| format!("{byte:02x}")).collect();
    assert_eq!(source, &json!({"path": "town.geojson", "sha256": hash}));
    assert_eq!(document["sites"].as_array().map(Vec::len), Some(2));
    let uavs = [("1", 691_605.0, 5_334_755.0, 40.0), ("2", 691_650.0, 5_334_780.0, 60.0)];
    for (site, (id, x, y, z)) in document["sites"].as_array().unwrap().iter().zip(uavs) {
        assert_eq!((&site["id"], &site["x"], &site["y"]), (&json!(id), &json!(x), &json!(y)));
        assert_eq!((&site["height_amsl_m"], &site["height_agl_m"]), (&json!(z), &json!(z)));
        // One street runs between the two buildings and around them.
        assert_eq!(site["placement"], "street");
        assert_eq!(site["zones"]["street"]["receivers"], site["receivers"]);
        assert!(site["zones"]["rooftop"]["p_los"].is_null() && site["zones"]["rooftop"]["reason"].is_string());
        let (receivers, los) = (site["receivers"].as_u64().unwrap(), site["los"].as_u64().unwrap());
        assert!(0 < los && los < receivers && receivers < 2400);
        let p_los = site["p_los"].as_f64().unwrap();
        assert!((p_los - los as f64 / receivers as f64).abs() < 1e-15);
        let bands = site["elevation_bands"].as_array().unwrap();
        let sum = |key: &str| bands.iter().map(|band| band[key].as_u64().unwrap()).sum::<u64>();
        assert_eq!((sum("receivers"), sum("los")), (receivers, los));
        assert_eq!((&bands[0]["from_deg"], &bands[0]["to_deg"]), (&json!(0), &json!(10)));
    }
    for key in ["receivers", "los", "p_los"] {
        assert!(document["union"][key].is_number(), "{key}");
    }
    assert!(document["union"]["los"].as_u64() >= document["sites"][0]["los"].as_u64());
    for key in ["read", "build", "los", "write", "total"] {
        assert!(document["timing_s"][key].as_f64().unwrap() >= 0.0, "{key}");
    }
    // All of the extent that was typed counts as known ground, and that is said.
    let codes: Vec<&str> = document["warnings"].as_array().unwrap().iter().filter_map(|w| w["code"].as_str()).collect();
    assert_eq!(codes, ["W378"]);
    assert_eq!(document["digest"].as_str().map(|d| (d.len(), d.starts_with("sha256:"))), Some((71, true)));
    // A local scene has no CRS, and says so.
    let local = folder.type_in("map itu:urban --size 100 --uav 5,5,50 --json").done().json();
    assert_eq!(local["scene"]["crs"], Value::Null);
    // A UAV over a roof.
    let over = folder.type_in("map town.geojson --uav 691615,5334765,5roof --json").done().json();
    assert_eq!((&over["sites"][0]["placement"], &over["sites"][0]["height_agl_m"]), (&json!("rooftop"), &json!(25.0)));
}

#[test]
fn every_format_holds_the_same_numbers() {
    let folder = town();
    let outputs = "-o m.tif -o m.exr -o m.asc -o m.npz -o m.csv -o m.json -o m.geojson -o m.png -o m.svg";
    let printed = folder.type_in(&format!("{MAP} {outputs} --zones --json -q")).done().json();
    let wanted = "m.asc m.asc.json m.csv m.csv.json m.exr m.geojson m.json m.npz m.png m.prj m.svg m.tif m.tif.aux.xml \
                  town.geojson";
    assert_eq!(folder.files().join(" "), wanted);

    let mask = mask_of(&folder, "m.tif");
    let file = tif(&folder, "m.tif");
    assert_eq!((file.width(), file.height(), file.band_count(), file.epsg()), (60, 40, 1, Some(25832)));
    assert_eq!(file.geo_bounds(), Some([691_600.0, 5_334_750.0, 691_660.0, 5_334_790.0]));
    assert_eq!(printed["digest"].as_str(), Some(digest(&[&mask]).as_str()));
    let site = &printed["sites"][0];
    let (receivers, los) = (count(&mask, 0) + count(&mask, 1), count(&mask, 1));
    assert_eq!((site["receivers"].as_u64(), site["los"].as_u64()), (Some(receivers), Some(los)));
    // 10 × 15 cells of the box, and as many of the triangle as have their center in it.
    let in_triangle = (0..N_ROWS * N_COLS).filter(|cell| {
        let (x, y) = (30.0 - (cell % N_COLS) as f64 - 0.5, 5.0 - (N_ROWS - cell / N_COLS) as f64 + 0.5);
        let (x, y) = (-x, -y);
        // Left of each edge of (0, 0), (15, 7), (10, 15).
        15.0 * y - 7.0 * x > 0.0
            && -5.0 * (y - 7.0) - 8.0 * (x - 15.0) > 0.0
            && -10.0 * (y - 15.0) + 15.0 * (x - 10.0) > 0.0
    });
    assert_eq!(count(&mask, 2), 150 + in_triangle.count() as u64);

    let wide: Vec<u32> = mask.iter().map(|class| u32::from(*class)).collect();
    assert_eq!(channels(&folder, "m.exr"), [("1.los".to_string(), FlatSamples::U32(wide))]);
    let asc = RasterFile::open(folder.join("m.asc"), &mut Vec::new()).unwrap();
    assert_eq!(asc.georef().crs().and_then(skyshed_core::raster::Crs::epsg), Some(25832), "from m.prj");
    let cells = asc.read(asc.georef().window(), &mut Vec::new(), |v| v).unwrap().into_cells();
    assert!(cells.iter().zip(&mask).all(|(a, b)| (a - f64::from(*b)).abs() < 1e-9));
    let (header, bytes) = npy(&folder, "m.npz", "los");
    assert!(header.contains("'|u1'") && header.contains("(1, 40, 60)"), "{header}");
    assert_eq!(bytes, mask);

    let text = folder.text("m.csv");
    let mut table = csv::Reader::from_reader(text.as_bytes());
    let headers = table.headers().unwrap().clone();
    let rows: Vec<csv::StringRecord> = table.records().map(|r| r.unwrap()).collect();
    let cell = |name: &str| rows[0].get(headers.iter().position(|h| h == name).unwrap()).unwrap().to_string();
    assert_eq!((rows.len(), cell("site").as_str(), cell("zone").as_str()), (5, "1", "all"));
    let zones: Vec<&str> = rows.iter().map(|row| row.get(6).unwrap()).collect();
    assert_eq!(zones, ["all", "street", "crossroad", "courtyard", "rooftop"]);
    assert_eq!((cell("receivers"), cell("los")), (receivers.to_string(), los.to_string()));
    assert_eq!(cell("p_los").parse::<f64>().ok(), site["p_los"].as_f64());
    assert_eq!((cell("not_receivers"), cell("crs")), (count(&mask, 2).to_string(), "EPSG:25832".to_string()));
    let point = &folder.json("m.geojson")["features"][0];
    assert_eq!(point["geometry"], json!({"type": "Point", "coordinates": [691_605.0, 5_334_755.0]}));
    assert_eq!(&point["properties"], site);
    for name in ["m.json", "m.asc.json", "m.csv.json"] {
        let document = folder.json(name);
        assert_eq!((&document["digest"], &document["sites"]), (&printed["digest"], &printed["sites"]), "{name}");
    }
    // Pictures carry their provenance too.
    let png = png::Decoder::new(Cursor::new(folder.read("m.png"))).read_info().unwrap();
    let text: Vec<String> = png.info().utf8_text.iter().map(|t| t.get_text().unwrap()).collect();
    assert!(text.iter().any(|t| t.contains(printed["digest"].as_str().unwrap())), "{text:?}");
    let (svg, p_los) = (folder.text("m.svg"), site["p_los"].as_f64().unwrap());
    assert!(svg.contains("UAV 1") && svg.contains(&format!("{p_los:.4}")), "{svg}");
}

#[test]
fn layers_become_bands_named_after_their_site() {
    let folder = town();
    let layers = "los,margin,least-receiver-height,least-height,count,which";
    let two = format!("{MAP} --uav 691650,5334780,60 --receivers all");
    folder.type_in(&format!("{two} --layers {layers} -o all.tif -o all.exr -o all.npz")).done();
    folder.type_in(&format!("{two} -o los.tif")).done();
    folder.type_in(&format!("{two} --layers count,which -o sets.tif")).done();
    // The old word is understood, and written as the new one.
    for (name, layer) in [("least.asc", "ceiling"), ("margin.tif", "margin"), ("old.tif", "ceiling")] {
        folder.type_in(&format!("{MAP} --receivers all --layers {layer} -o {name}")).done();
    }
    assert!(items(&tif(&folder, "old.tif")).contains(">1.least-receiver-height<"));
    let names = "1.los 2.los 1.margin 2.margin 1.least-receiver-height 2.least-receiver-height 1.least-height \
                 2.least-height count which.0";
    let file = tif(&folder, "all.tif");
    for (k, name) in names.split(' ').enumerate() {
        let item = format!(r#"<Item name="DESCRIPTION" sample="{k}" role="description">{name}</Item>"#);
        assert!(items(&file).contains(&item), "{name}: {}", items(&file));
    }
    assert_eq!((file.band_count(), file.nodata()), (10, Some("-9999")));
    let band = |k: usize| -> Vec<f32> { file.read_band::<f32>(k).unwrap().into_iter().collect() };
    let (los, margin, ceiling, least) = (band(0), band(2), band(4), band(6));
    let mut sorted: Vec<&str> = names.split(' ').collect();
    sorted.sort_unstable();
    let exr = channels(&folder, "all.exr");
    assert_eq!(exr.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(), sorted);

    let los_file = tif(&folder, "los.tif");
    assert_eq!(los_file.band_count(), 2);
    let masks: Vec<Vec<u8>> = (0..2).map(|k| los_file.read_band::<u8>(k).unwrap().into_iter().collect()).collect();
    let printed = folder.type_in(&format!("{two} --json")).done().json();
    assert_eq!(printed["digest"].as_str(), Some(digest(&[&masks[0], &masks[1]]).as_str()));
    let sets = tif(&folder, "sets.tif");
    let word = |k: usize| -> Vec<u32> { sets.read_band::<u32>(k).unwrap().into_iter().collect() };
    let (counts, which) = (word(0), word(1));
    for cell in 0..N_COLS * N_ROWS {
        let (a, b) = (u32::from(masks[0][cell]), u32::from(masks[1][cell]));
        assert!(a <= 1 && b <= 1, "with --receivers all every cell is a receiver");
        assert_eq!((counts[cell], which[cell]), (a + b, a + 2 * b), "cell {cell}");
        assert_eq!(u32::from(los[cell] > 0.5), a);
        assert_eq!(margin[cell] >= 0.0, a == 1, "margin {} where LoS is {a}", margin[cell]);
        assert!(ceiling[cell] >= 0.0 && (a == 1 || least[cell] > 40.0), "cell {cell}");
        assert!(a == 0 || least[cell] <= 40.0, "cell {cell}: LoS at 40 m, least height {}", least[cell]);
    }
    let union = which.iter().filter(|set| **set > 0).count() as u64;
    assert_eq!(printed["union"]["los"].as_u64(), Some(union));

    let FlatSamples::F32(found) = &exr[sorted.iter().position(|n| *n == "1.margin").unwrap()].1 else { panic!() };
    assert!(found.iter().zip(&margin).all(|(a, b)| a.to_bits() == b.to_bits()));
    let (header, bytes) = npy(&folder, "all.npz", "margin");
    assert!(header.contains("'<f4'") && header.contains("(2, 40, 60)"), "{header}");
    let first: Vec<u8> = margin.iter().flat_map(|v| v.to_le_bytes()).collect();
    assert_eq!(bytes[..first.len()], first);
    let asc = RasterFile::open(folder.join("least.asc"), &mut Vec::new()).unwrap();
    let cells = asc.read(asc.georef().window(), &mut Vec::new(), |v| v).unwrap().into_cells();
    assert!(cells.iter().zip(&ceiling).all(|(a, b)| (a - f64::from(*b)).abs() < 1e-4));
    let alone: Vec<f32> = tif(&folder, "margin.tif").read_raster::<f32>().unwrap().into_iter().collect();
    assert!(alone.iter().map(|v| v.to_bits()).eq(margin.iter().map(|v| v.to_bits())));
}

#[test]
fn a_plain_geotiff_of_a_map_differs_in_its_layout_alone() {
    let folder = town();
    folder.type_in(&format!("{MAP} -o cog.tif")).done();
    folder.type_in(&format!("{MAP} -o typed.tif --tif-layout cog")).done();
    folder.type_in(&format!("{MAP} -o plain.tif --tif-layout plain")).done();
    assert_eq!(mask_of(&folder, "cog.tif"), mask_of(&folder, "typed.tif"));
    assert_eq!(mask_of(&folder, "cog.tif"), mask_of(&folder, "plain.tif"));
    let layout = |name: &str| {
        let file = tif(&folder, name);
        let ifd = file.tiff().ifd(0).unwrap();
        (ifd.is_tiled(), ifd.compression())
    };
    assert_eq!((layout("cog.tif"), layout("typed.tif"), layout("plain.tif")), ((true, 8), (true, 8), (false, 1)));
    assert_eq!(folder.text("cog.tif.aux.xml"), folder.text("plain.tif.aux.xml"));
    // Alone it is written while it is made, beside others afterwards: but for the words that were typed it says the same.
    let told = |folder: &Folder| {
        let items = items(&tif(folder, "plain.tif"));
        let (head, rest) = items.split_once("command").unwrap();
        (mask_of(folder, "plain.tif"), format!("{head}{}", rest.split_once("method").unwrap().1))
    };
    let alone = told(&folder);
    folder.type_in(&format!("{MAP} -o plain.tif -o beside.npz --tif-layout plain --overwrite")).done();
    assert_eq!(alone, told(&folder));
    // Layers of heights and of sets are plain too.
    folder.type_in(&format!("{MAP} --layers margin,count -o heights.tif --tif-layout plain")).done();
    assert_eq!((layout("heights.tif"), tif(&folder, "heights.tif").band_count()), ((false, 1), 2));
}

#[test]
fn the_classes_of_a_mask_are_those_of_the_contract() {
    let folder = Folder::new();
    // One row of 10 m cells: UAV over the first; a hole, a building, what it hides, and what is out of range.
    folder.write(
        "row.asc",
        "ncols 7\nnrows 1\nxllcorner 0\nyllcorner 0\ncellsize 10\nNODATA_value -1\n0 0 -1 30 0 0 0\n",
    );
    let base = "map row.asc --ground 0 --uav 5,5,40 --radius 55";
    let site = folder.type_in(&format!("{base} -o m.tif --json")).done().json()["sites"][0].clone();
    // Over the roof's far edge at x = 40 m the ray falls by 10 m in 35 m, to 25 m at the next receiver.
    assert_eq!(mask_of(&folder, "m.tif"), [1, 1, 255, 2, 0, 0, 3]);
    assert_eq!((&site["receivers"], &site["los"], &site["p_los"]), (&json!(4), &json!(2), &json!(0.5)));
    folder.type_in(&format!("{base} --receivers roof -o roof.tif")).done();
    assert_eq!(mask_of(&folder, "roof.tif"), [2, 2, 255, 1, 2, 2, 3]);
    // Nodata that blocks hides what is behind it.
    folder.type_in(&format!("{base} --nodata-as block --receivers all -o block.tif")).done();
    assert_eq!(mask_of(&folder, "block.tif"), [1, 1, 255, 0, 0, 0, 3]);
    // Nothing in range: null with a reason, and a warning.
    // Over nodata or outside the raster no ground is known, unless it was typed.
    folder.refuses("map row.asc --uav 25,500,40 --uav 5,5,9 --radius 55 --json", "E204", &["`40amsl`"]);
    let answer = folder.type_in("map row.asc --ground 0 --uav 25,500,40 --radius 55 --json").done();
    let site = answer.json()["sites"][0].clone();
    assert_eq!((&site["p_los"], &site["height_agl_m"]), (&Value::Null, &json!(40.0)));
    assert!(site["reason"].is_string() && answer.warnings().contains(&"W202"), "{answer:?}");
}

#[test]
fn a_bare_picture_has_a_pixel_per_cell_and_knows_its_place() {
    let folder = town();
    folder.type_in(&format!("{MAP} --uav 691650,5334780,60 --bare -o b.png -o b.tif -o c.exr")).done();
    let wanted = "b.1.pgw b.1.png b.1.png.json b.1.prj b.2.pgw b.2.png b.2.png.json b.2.prj b.pgw b.png b.png.json \
                  b.prj b.qml b.tif b.tif.aux.xml c.exr town.geojson";
    assert_eq!(folder.files().join(" "), wanted);
    assert_eq!(folder.text("b.pgw"), "1\n0\n0\n-1\n691600.5\n5334789.5\n");
    assert!(folder.text("b.prj").contains("UTM"));
    let file = tif(&folder, "b.tif");
    let masks: Vec<Vec<u8>> = (0..2).map(|k| file.read_band::<u8>(k).unwrap().into_iter().collect()).collect();
    for (name, mask) in ["b.1.png", "b.2.png"].into_iter().zip(&masks) {
        let image = read_png(&folder.read(name)).to_rgb8();
        assert_eq!(image.dimensions(), (60, 40), "{name}");
        for (cell, pixel) in image.pixels().enumerate() {
            let found = match pixel.0 {
                [0xE6, 0x9F, 0x00] => 0,
                [0x00, 0x72, 0xB2] => 1,
                _ => 2,
            };
            assert_eq!(found, mask[cell], "{name}, cell {cell}");
        }
    }
    // The picture of both shows how many see a cell: one color for each count.
    let image = read_png(&folder.read("b.png")).to_rgba8();
    let mut colors: std::collections::BTreeMap<u8, std::collections::BTreeSet<[u8; 4]>> = Default::default();
    for (cell, pixel) in image.pixels().enumerate() {
        let seen = if masks[0][cell] == 2 { 9 } else { masks[0][cell] + masks[1][cell] };
        colors.entry(seen).or_default().insert(pixel.0);
    }
    assert!(colors.values().all(|c| c.len() == 1) && colors.len() == 4, "{colors:?}");
    assert_eq!(colors.values().collect::<std::collections::BTreeSet<_>>().len(), 4, "{colors:?}");
    assert!(colors[&0].contains(&[0xE6, 0x9F, 0x00, 0xFF]));
    // A `.prj` that two outputs share is written once.
    folder.type_in(&format!("{MAP} --bare -o d.png -o d.asc")).done();
    assert_eq!(folder.text("d.prj"), folder.text("b.prj"));
    // Outputs that need one name for different things are refused together.
    let clash = format!("{MAP} --uav 691650,5334780,60 -o e.png -o e.1.png -o e.2.tif --bare");
    folder.refuses(&clash, "E105", &["e.1.png"]);
    assert!(!folder.files().iter().any(|f| f.contains("e.")));
}

#[test]
fn the_same_run_twice_writes_the_same_bytes() {
    let folder = town();
    let line = format!(
        "{MAP} -o m.tif -o m.exr -o m.asc -o m.npz -o m.csv -o m.json -o m.geojson -o m.png -o m.kmz -o m.fgb \
             --polygons all --overwrite"
    );
    folder.type_in(&line).done();
    let first: Vec<(String, Vec<u8>)> = folder.files().into_iter().map(|f| (f.clone(), folder.read(&f))).collect();
    folder.type_in(&line).done();
    let untimed = |bytes: &[u8]| {
        let mut document: Value = serde_json::from_slice(bytes).unwrap();
        document.as_object_mut().unwrap().remove("timing_s").expect("a document says how long it took");
        document
    };
    for (name, bytes) in first {
        let again = folder.read(&name);
        // The document alone says how long it took.
        let same = if name == "m.json" { untimed(&again) == untimed(&bytes) } else { again == bytes };
        assert!(same, "{name} differs");
    }
}

/// What pyproj 3 (PROJ 9, no grids) makes of longitude and latitude in EPSG:25832:
/// `Transformer.from_crs(4326, 25832, always_xy=True).transform(lon, lat)`.
const PLACES: [((f64, f64), (f64, f64)); 2] = [
    ((11.5755, 48.1372), (691_603.776_600, 5_334_757.803_514)),
    ((11.576, 48.1375), (691_639.854_144, 5_334_792.390_543)),
];

fn assert_at(site: &Value, (x, y): (f64, f64)) {
    let (found_x, found_y) = (site["x"].as_f64().unwrap(), site["y"].as_f64().unwrap());
    assert!((found_x - x).abs() < 1e-3 && (found_y - y).abs() < 1e-3, "{site}, wanted {x}, {y}");
}

#[test]
fn sites_in_degrees_are_brought_into_the_scene() {
    let folder = town();
    folder.write(
        "sites.csv",
        "# two sites\nid, lon, lat, h, h_above\nwest, 11.5755, 48.1372, 30, ground\neast,11.576,48.1375,70,amsl\n",
    );
    folder.write("sites.geojson", &points(None, [11.5755, 48.1372], [11.576, 48.1375]));
    for name in ["sites.csv", "sites.geojson"] {
        let document = folder.type_in(&format!("map town.geojson --uavs {name} --json")).done().json();
        let sites = document["sites"].as_array().unwrap();
        assert_eq!(sites.len(), 2);
        for ((site, (_, place)), (id, z)) in sites.iter().zip(PLACES).zip([("west", 30.0), ("east", 70.0)]) {
            assert_eq!((&site["id"], &site["height_amsl_m"]), (&json!(id), &json!(z)), "{name}");
            assert_at(site, place);
        }
    }
    // In a named projected system, and in the scene's own coordinates, nothing moves.
    folder.write("own.geojson", &points(Some("EPSG:25832"), [691_605.0, 5_334_755.0], [691_650.0, 5_334_780.0]));
    folder.write("own.csv", "name,x,y,height\nwest,691605,5334755,30\neast,691650,5334780,70amsl\n");
    let digests: Vec<Value> = ["own.geojson", "own.csv"]
        .iter()
        .map(|name| folder.type_in(&format!("map town.geojson --uavs {name} --json")).done().json()["digest"].clone())
        .collect();
    let typed = "--uav 691605,5334755,30 --uav 691650,5334780,70amsl";
    let typed = folder.type_in(&format!("map town.geojson {typed} --json")).done().json();
    assert_eq!(digests, [typed["digest"].clone(), typed["digest"].clone()]);
    // UTM 32N on WGS 84 is another system, though the numbers nearly agree.
    folder.write("wgs.geojson", &points(Some("EPSG:32632"), [691_605.0, 5_334_755.0], [691_650.0, 5_334_780.0]));
    let moved = folder.type_in("map town.geojson --uavs wgs.geojson --json").done().json();
    assert_at(&moved["sites"][0], (691_605.0, 5_334_755.0));
}

/// Two sites, `west` 30 m above ground and `east` 70 m above the datum.
fn points(crs: Option<&str>, west: [f64; 2], east: [f64; 2]) -> String {
    let feature = |id: &str, at: [f64; 2], h: Value| {
        let point = json!({"type": "Point", "coordinates": at});
        json!({"type": "Feature", "properties": {"id": id, "h": h}, "geometry": point})
    };
    let features = [feature("west", west, json!(30)), feature("east", east, json!("70amsl"))];
    let mut document = json!({"type": "FeatureCollection", "features": features});
    if let Some(name) = crs {
        document["crs"] = json!({"type": "name", "properties": {"name": name}});
    }
    document.to_string()
}

#[test]
fn bad_site_files_are_refused_with_their_line() {
    let folder = town();
    for (text, code, found) in [
        ("x,y\n1,2\n", "E302", "line 1: found columns `x,y`, wanted a height"),
        ("a,b,h\n1,2,3\n", "E302", "line 1: found columns `a,b,h`, wanted a position"),
        ("x,y,h\n691605,5334755,30\n691605,five,30\n", "E302", "line 3: `y`: found `five`"),
        ("x,y,h\n691605,5334755,nan\n", "E302", "line 2: height `nan`: found `NaN`"),
        ("x,y,h,h_above\n691605,5334755,9,sea\n", "E302", "line 2: `h_above` is `sea`"),
        ("x,y,h\n", "E308", "s.csv"),
        ("id,x,y,h\na,691605,5334755,30\na,691606,5334755,30\n", "E207", "`a`"),
        ("lon,lat,h\n11.5755,148.1,30\n", "E206", "s.csv: line 2"),
    ] {
        folder.write("s.csv", text);
        // What a table looks like is told where it is none.
        let hint = if code == "E302" { "`x,y,h` or `lon,lat,h`" } else { "" };
        folder.refuses("map town.geojson --uavs s.csv -o out.tif", code, &[found, hint]);
    }
    // Degrees need a scene that says where it is.
    folder.write("s.csv", "lon,lat,h\n11.5755,48.1372,30\n");
    folder.refuses("map itu:urban --uavs s.csv -o out.tif", "E206", &["EPSG:4326", "`--crs EPSG:n`"]);
    // An id that is typed may not be taken again by the file.
    folder.write("s.csv", "id,x,y,h\n1,691605,5334755,30\n");
    folder.refuses("map town.geojson --uav 691605,5334755,30 --uavs s.csv -o out.tif", "E207", &["`1`"]);
    assert_eq!(folder.files(), ["s.csv", "town.geojson"]);
}
