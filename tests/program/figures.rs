//! What pictures show and say, against the numbers of files, and how large they are written.

use std::io::Cursor;

use crate::masks::{MAP, tif, town};
use crate::program::Folder;
use crate::refusals::check_refusals;

/// A second UAV.
const SECOND: &str = "--uav 691650,5334780,60";

/// A vector picture without what it says of where it comes from.
pub(crate) fn drawn(folder: &Folder, line: &str) -> String {
    picture_of(folder, &format!("{line} -o"))
}

/// The vector picture that a line writes when the name of a file follows.
pub(crate) fn picture_of(folder: &Folder, line: &str) -> String {
    folder.type_in(&format!("{line} drawn.svg --overwrite -q")).done();
    let svg = folder.text("drawn.svg").replace(['\u{a0}', '\u{202f}'], " ");
    svg[svg.find("</metadata>").unwrap_or(0)..].to_string()
}

/// All words in the order in which they are drawn.
pub(crate) fn words(svg: &str) -> String {
    let plain = svg.split('<').filter_map(|part| part.split_once('>')).map(|(_, text)| text);
    plain.flat_map(str::split_whitespace).collect::<Vec<_>>().join(" ")
}

#[test]
fn a_cell_is_drawn_by_its_only_uav_in_numbers_that_the_layer_counts() {
    let folder = town();
    folder.type_in(&format!("{MAP} {SECOND} --layers which,los -o w.tif -q")).done();
    let file = tif(&folder, "w.tif");
    let bands = [0, 1, 2].map(|k| file.read_band::<u32>(k).unwrap().into_iter().collect::<Vec<_>>());
    let receivers = |cell: &usize| bands[1][*cell] <= 1 || bands[2][*cell] <= 1;
    let number = |set: u32| (0..bands[0].len()).filter(receivers).filter(|cell| bands[0][*cell] == set).count();
    let said = words(&drawn(&folder, &format!("{MAP} {SECOND} --layers which,los")));
    for (name, set) in [("Seen by none", 0), ("Only by UAV 1", 1), ("Only by UAV 2", 2), ("By both UAVs", 3)] {
        let counted = |text: &str| text.split(" · ").nth(1)?.split(' ').next()?.parse::<usize>().ok();
        let found = said.split(name).nth(1).and_then(counted).unwrap_or(0);
        assert_eq!(found, number(set), "{name}: {said}");
    }
    assert!(said.contains("Which UAV sees what of") && number(1) > 0 && number(2) > 0 && number(3) > 0);
    // The other layers of sets are drawn as before.
    assert!(drawn(&folder, &format!("{MAP} {SECOND} --layers count,which")).contains(">By both UAVs<"));
}

#[test]
fn more_uavs_and_layers_of_heights_have_a_small_map_each() {
    let folder = town();
    let uavs = |n: usize| (1..n).map(|k| format!(" --uav {},5334780,60", 691_604 + 5 * k)).collect::<String>();
    for (n, layer, words) in [
        (5, "which", "Only by this UAV"),
        (2, "margin", "Margin: receiver height less least visible height [m]"),
        (3, "ceiling", "Least receiver height, above the datum [m]"),
        (2, "least-height", "Up to 30 m above ground"),
    ] {
        let svg = drawn(&folder, &format!("{MAP}{} --layers {layer}", uavs(n)));
        assert_eq!(svg.matches("<image ").count(), n, "{layer}");
        assert_eq!(svg.matches(&format!(">{words}<")).count(), 1, "{layer}: one legend for all");
    }
    let svg = drawn(&folder, &format!("{MAP}{} --layers which", uavs(9)));
    assert_eq!(svg.matches("<image ").count(), 8);
    assert!(words(&svg).contains("Of 9 UAVs the first 8 are drawn; the rest are among the others"), "{svg}");
}

#[test]
fn least_heights_are_told_above_the_ground_and_written_above_the_datum() {
    let folder = town();
    // The same town lower and higher: the picture is the same, the layer is not.
    let at = |ground: &str, name: &str| {
        let line = format!("{MAP} --ground {ground} --layers least-height");
        folder.type_in(&format!("{line} -o {name} -q")).done();
        words(&drawn(&folder, &line))
    };
    let (low, high) = (at("0", "low.tif"), at("500", "high.tif"));
    let layer = tif(&folder, "high.tif").read_band::<f32>(0).unwrap();
    let values: Vec<f64> = layer.into_iter().map(f64::from).filter(|v| *v > -9999.0).collect();
    assert!(values.iter().all(|v| *v >= 500.0));
    let classes = [
        ("Up to 30 m above ground", f64::NEG_INFINITY, 530.0),
        ("30 to 60 m", 530.0, 560.0),
        ("60 to 120 m", 560.0, 620.0),
        ("120 to 240 m", 620.0, 740.0),
    ];
    for (name, from, to) in classes {
        let n = values.iter().filter(|v| **v > from && **v <= to).count();
        let said = format!(
            "{name} {} · {n} ",
            high.split(name).nth(1).and_then(|t| t.split(" · ").next()).unwrap_or("").trim()
        );
        assert_eq!(n > 0, high.contains(name), "{name}");
        assert!(n == 0 || (high.contains(&said) && low.contains(&said)), "{said}: {high}");
    }
    assert!(
        high.contains("ground below the UAV, which is 500 m above the datum")
            && low.contains("ground below the UAV, which is 0 m above")
    );
}

#[test]
fn titles_name_the_place_that_a_file_names_or_the_file_as_it_is_called() {
    let folder = town();
    let town = folder.text("town.geojson");
    for (name, title) in [("old town", "Old town"), ("town_2024", "the footprints in old_town.geojson")] {
        folder.write("old_town.geojson", &town.replacen('{', &format!("{{\"name\": \"{name}\", "), 1));
        let said = words(&drawn(&folder, &MAP.replace("town.geojson", "old_town.geojson")));
        assert!(said.contains(&format!("What a UAV sees of {title} ")), "{said}");
    }
    folder.write("dsm_1m.asc", "ncols 3\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n0 0 5\n0 0 0\n");
    let said = words(&drawn(&folder, "map dsm_1m.asc --ground 0 --uav 1,1,9"));
    assert!(said.contains("What a UAV sees of the surface in dsm_1m.asc"), "{said}");
}

#[test]
fn open_ground_without_receivers_is_no_building() {
    let folder = Folder::new();
    let number = |said: &str, name: &str| {
        let after = said.split(&format!("{name} ")).nth(1).unwrap_or_default().replace(' ', "");
        after.split("cells").next().and_then(|n| n.parse::<u64>().ok())
    };
    let said = |receivers: &str| {
        let line = format!("map itu:urban --size 100 --uav 50,50,60 --receivers {receivers}");
        words(&drawn(&folder, &line))
    };
    let [ground, street] = ["ground", "street"].map(said);
    assert!(number(&ground, "Buildings").is_some_and(|n| n > 0), "{ground}");
    assert_eq!(number(&ground, "Buildings"), number(&street, "Buildings"), "{street}");
    let open = "Open ground without receivers";
    assert!(number(&street, open).is_some_and(|n| n > 0) && !ground.contains(open), "{street}");
}

#[test]
fn the_uavs_of_a_caption_are_told_alike_and_nothing_is_quoted() {
    let folder = town();
    for line in [format!("{MAP} {SECOND} -o"), format!("{MAP} {SECOND} --height-curve")] {
        let svg = picture_of(&folder, &line);
        let before = |id: &str| &svg[..svg.rfind(&format!(">UAV {id}")).unwrap_or(0)];
        let color = |id: &str| before(id).rsplit("fill=\"").next().map(|c| c[..7].to_string());
        assert_eq!(color("1"), color("2"), "{line}: {svg}");
    }
    let link = "link town.geojson --extent 691600,5334750,691660,5334790 --uav 691605,5334755,25 --rx 691626,5334772";
    let svg = drawn(&folder, link);
    assert!(svg.contains("obstructed by building ") && !svg.contains('`'), "{svg}");
}

/// The attributes of the sample of a line in the legend.
fn sample<'a>(svg: &'a str, label: &str) -> &'a str {
    let end = svg.find(&format!(">{label}<")).unwrap_or_else(|| panic!("{label}: {svg}"));
    let line = svg[..end].rfind("<line").unwrap();
    let stroke = svg[line..end].find("stroke=").unwrap();
    svg[line + stroke..end].split("/>").next().unwrap()
}

#[test]
fn a_model_looks_the_same_in_every_figure() {
    let folder = Folder::new();
    let line = "plos itu:urban --theta 20:80:20 --method";
    let first = drawn(&folder, &format!("{line} product,itu,alhourani2014"));
    let second = drawn(&folder, &format!("{line} mohammed2023,alhourani2014,itu,product"));
    let third = drawn(&folder, "plos itu:dense-urban itu:urban --theta 20:80:20 --method models");
    for label in ["ITU-R P.1410", "Al-Hourani 2014", "Product over buildings"] {
        assert_eq!(sample(&first, label), sample(&second, label), "{label}");
    }
    assert_eq!(sample(&first, "ITU-R P.1410"), sample(&third, "ITU-R P.1410"));
    assert_eq!(sample(&second, "Mohammed 2023"), sample(&third, "Mohammed 2023"));
    let looks = ["ITU-R P.1410", "Al-Hourani 2014", "Mohammed 2023"].map(|label| sample(&third, label));
    assert!(looks[0] != looks[1] && looks[1] != looks[2] && looks[0].contains("dasharray"), "{looks:?}");
}

/// The fill of what is drawn right before a label.
fn fill_before<'a>(svg: &'a str, label: &str) -> &'a str {
    let end = svg.find(&format!(">{label}<")).unwrap_or_else(|| panic!("{label}: {svg}"));
    let marker = &svg[..svg[..end].rfind("<text").unwrap()];
    marker.rsplit("fill=\"").next().unwrap().split('"').next().unwrap()
}

#[test]
fn a_model_has_one_color_in_charts_and_curves() {
    let folder = Folder::new();
    let chart = drawn(&folder, "chart itu:urban --plos --time 0");
    let (_, biases) = chart.split_once(">Published models<").unwrap();
    let curves = drawn(&folder, "plos itu:urban --theta 20:80:20 --method models");
    let mut colors = Vec::new();
    for (id, label) in [
        ("itu", "ITU-R P.1410"),
        ("alhourani2014", "Al-Hourani 2014"),
        ("mohammed2023", "Mohammed 2023"),
        ("tr36777_uma_av", "3GPP 36.777 UMa-AV"),
    ] {
        let color = fill_before(biases, id);
        assert!(color.starts_with('#') && !colors.contains(&color), "{id}: {color}, after {colors:?}");
        assert!(sample(&curves, label).starts_with(&format!("stroke=\"{color}\"")), "{id}: {color}");
        colors.push(color);
    }
}

#[test]
fn a_curve_of_the_user_is_points_at_its_rows() {
    let folder = Folder::new();
    folder.write("mine.csv", "theta_deg,p_los\n5,0.1\n33,0.4\n60,0.8\n90,1\n");
    let svg = drawn(&folder, "plos itu:urban --theta 10:80:10 --method itu --curve measured=mine.csv");
    let color = svg[..svg.find(">measured<").unwrap()].rfind("<polygon").unwrap();
    let color = svg[color..].split("fill=\"").nth(1).unwrap()[..7].to_string();
    // Four rows and the legend, at none of the angles that were asked for, and no line.
    assert_eq!(svg.matches(&format!("fill=\"{color}\" stroke=\"#FFFFFF\"")).count(), 4 + 1, "{svg}");
    assert!(!svg.contains(&format!("stroke=\"{color}\"")), "{color}: {svg}");
}

#[test]
fn captions_speak_of_intervals_only_where_some_are_drawn() {
    let folder = Folder::new();
    for (line, wanted) in [
        ("plos itu:urban --theta 20:80:20 --method product", Some("Bands: 95 % intervals")),
        ("plos itu:urban --theta 20:80:20 --method geometry --links 500", Some("Bars: 95 % intervals")),
        ("plos itu:urban --theta 20:80:20 --method product,geometry --links 500", Some("Bands and bars: 95 %")),
        ("plos itu:urban --theta 45 --method product", Some("Bars: 95 % intervals")),
        ("plos itu:urban --theta 20:80:20 --method itu", None),
        ("plos itu:urban --theta 20:80:20 --phi 0:90:30", None),
        ("plos itu:urban --theta 20:80:20 --method city --cities 5", None),
        ("sample itu:urban --size 300 --cell 2 --zones street:2 --height 60,80 --cities 2", None),
        ("sample itu:urban --size 300 --cell 2 --zones street:2 --height 60,80 --cities 12", Some("Bands: 95 %")),
        ("compare itu:urban --size 200 --uav 50,50,60 --uav 150,150,60 --block 1000", None),
        ("compare itu:urban --size 300 --uav 50,50,60 --uav 150,150,60 --block 20", Some("95 % interval")),
    ] {
        let said = words(&drawn(&folder, line));
        assert_eq!(said.contains("interval"), wanted.is_some(), "{line}: {said}");
        assert!(wanted.is_none_or(|words| said.contains(words)), "{line}: {said}");
    }
}

#[test]
fn captions_of_curves_hold_what_was_fixed() {
    let folder = Folder::new();
    for (line, wanted) in [
        ("plos itu:urban --theta 45 --height 50:150:50 --method itu", "elevation angle 45°"),
        ("plos itu:urban --theta 45 --phi 0:90:30", "ground distance 98.5 m"),
        ("plos itu:urban --distance 80 --height 50:150:50 --method itu", "ground distance 80 m"),
        ("plos itu:urban --radius 100 --height 50:150:50", "users within 100 m"),
        ("plos itu:urban --theta 20:80:20 --phi 30", "azimuth 30°"),
        ("sample itu:urban --size 300 --cell 2 --zones street:2 --height 60 --radius 90", "within 90 m of the UAV"),
        (
            "place itu:urban --size 200 --height 60 --over crossroad --goal p_los(street) --radius 90",
            "Goal p_los(street) over street cells, range 90 m; candidates every 20 m over zones crossroad at 60 m",
        ),
    ] {
        let said = words(&drawn(&folder, line));
        assert!(said.to_lowercase().contains(&wanted.to_lowercase()), "{line}: {said}");
    }
}

/// Width of a PNG file and its pixels per meter.
fn png_size(bytes: Vec<u8>) -> (u32, u32) {
    let reader = png::Decoder::new(Cursor::new(bytes)).read_info().unwrap();
    (reader.info().width, reader.info().pixel_dims.unwrap().xppu)
}

#[test]
fn every_picture_has_the_width_and_resolution_that_were_asked_for() {
    let folder = town();
    folder.write("track.csv", "x,y\n691601,5334751\n691659,5334789\n");
    let size = "--width 640 --dpi 300 --overwrite -q";
    let scene = "town.geojson --extent 691600,5334750,691660,5334790";
    for line in [
        format!("{MAP} -o"),
        format!("{MAP} {SECOND} --layers margin -o"),
        format!("{MAP} --height-curve"),
        format!("link {scene} --uav 691605,5334755,40 --rx 691650,5334780 -o"),
        format!("track {scene} --uav 691605,5334755,40 --track track.csv -o"),
        format!("city {scene} -o"),
        format!("zones {scene} -o"),
        "plos itu:urban --theta 20:80:20 --method itu -o".to_string(),
        "plos itu:urban --theta 20:80:20 --phi 0:90:30 -o".to_string(),
        format!("compare {scene} --uav 691605,5334755,40 {SECOND} -o"),
        format!("place {scene} --height 30 --step 20 -o"),
        format!("place {scene} --height 30 --step 20 --map"),
        format!("chart {scene} --uav 691605,5334755,40 --time 0 -o"),
        "stress --scenes 1 --families cell-slits --method ray -o".to_string(),
    ] {
        for file in ["a.png", "a.svg", "a.pdf"] {
            folder.type_in(&format!("{line} {file} {size}")).done();
        }
        // An inch is 25.4 mm: 300 pixels per inch are 11811 per meter, and 640 pixels are 54.187 mm or 153.6 points.
        assert_eq!(png_size(folder.read("a.png")), (640, 11_811), "{line}");
        assert!(folder.text("a.svg").contains("width=\"54.187mm\""), "{line}");
        let pdf = folder.read("a.pdf");
        let text = String::from_utf8_lossy(&pdf);
        assert!(text.starts_with("%PDF-") && text.contains("/MediaBox [0 0 153.6 "), "{line}");
        assert!(text.contains("/FlateDecode") && text.trim_end().ends_with("%%EOF"), "{line}");
    }
    // As laid out, pictures have the width and resolution that they had.
    folder.type_in(&format!("{MAP} -o a.png --overwrite -q")).done();
    assert_eq!(png_size(folder.read("a.png")).1, 7874);
}

#[test]
fn a_pdf_knows_the_run_that_made_it() {
    let folder = Folder::new();
    let line = "map itu:urban --size 200 --uav 50,50,60 -o u-{site}.pdf --resume -q";
    folder.type_in(line).done();
    let first = folder.read("u-1.pdf");
    folder.type_in(line).done();
    assert!(folder.read("u-1.pdf") == first);
    // Of another run it is not replaced.
    let other = folder.type_in(&line.replace("50,50,60", "50,50,70"));
    assert_eq!(other.error(), "E106");
}

#[test]
fn sizes_that_are_wrong_or_without_a_picture_are_refused() {
    let folder = town();
    let maps = [
        ("-o a.png --width 0", "E101", "'--width <PX>'"),
        ("-o a.png --width 1000000000", "E101", "'--width <PX>'"),
        ("-o a.pdf --dpi 0", "E101", "'--dpi <N>'"),
        ("-o a.tif --width 500", "E116", "`--width`"),
        ("-o a.png --bare --width 500", "E116", "`--width`"),
        ("-o a.html", "E105", "a.html"),
    ];
    check_refusals(&folder, MAP, &maps);
    let others = [
        ("plos itu:urban --dpi 300", "E116", "`--dpi`"),
        ("link itu:urban --uav 9,9,50 --rx 99,99 --dpi 300", "E116", "`--dpi`"),
    ];
    check_refusals(&folder, "", &others);
}
