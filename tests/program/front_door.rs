//! The library's front door answers what the program does.

use skyshed::prelude::*;

use crate::program::Folder;

const MAPS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/maps");
const PLACE: (f64, f64) = (691_549.7, 5_334_762.2);

/// The digest of the program's map.
fn digest(folder: &Folder, line: &str) -> String {
    let document = folder.type_in(&format!("map {line} --json -q")).done().json();
    document["digest"].as_str().unwrap().to_string()
}

#[test]
fn the_first_program_of_a_stranger_runs() -> Result<(), skyshed::Error> {
    let folder = Folder::new();
    let city = Scene::open(format!("{MAPS}/munich.geojson"))?;
    let seen = city.coverage(Uav::new(PLACE.0, PLACE.1, Height::agl(120.0))).radius(300.0).run()?;
    assert!(seen.p_los().is_some_and(|p_los| p_los > 0.0) && seen.receivers() > 0);
    seen.save(folder.join("munich.png"))?;
    assert!(folder.read("munich.png").starts_with(b"\x89PNG"));
    let line = format!("{MAPS}/munich.geojson --uav {},{},120 --radius 300", PLACE.0, PLACE.1);
    assert_eq!(seen.digest(), digest(&folder, &line));
    Ok(())
}

#[test]
fn rasters_generated_cities_and_many_uavs_are_those_of_the_program() -> Result<(), skyshed::Error> {
    let folder = Folder::new();
    let terrain = format!("{MAPS}/munich_terrain.tif");
    let raster = Scene::options().terrain(&terrain).open(format!("{MAPS}/munich_dsm.tif"))?;
    let seen = raster.coverage(Uav::new(PLACE.0, PLACE.1, Height::agl(60.0))).radius(200.0).run()?;
    let uav = format!("--uav {},{},60 --radius 200", PLACE.0, PLACE.1);
    assert_eq!(seen.digest(), digest(&folder, &format!("{MAPS}/munich_dsm.tif --terrain {terrain} {uav}")));

    let city = Scene::options().size(200.0).seed(7).open("itu:urban")?;
    let uavs = [30.0, 170.0].map(|x| Uav::new(x, 100.0, Height::agl(90.0)));
    let seen = city.coverages(uavs).layers([Layer::Los, Layer::Count]).run()?;
    let both = "--uav 30,100,90 --uav 170,100,90";
    assert_eq!(seen.digest(), digest(&folder, &format!("itu:urban --size 200 --seed 7 {both}")));
    let by_any = seen.count().iter().filter(|n| **n > 0).count() as u64;
    assert_eq!(seen.union().los, by_any);
    Ok(())
}

#[test]
fn a_link_is_that_of_the_program() -> Result<(), skyshed::Error> {
    let city = Scene::open("itu:urban")?;
    let link = city.link(Uav::new(500.0, 500.0, Height::agl(100.0)), (590.0, 480.0), Height::agl(1.5))?;
    let told = Folder::new().type_in("link itu:urban --uav 500,500,100 --rx 590,480 --json -q").done().json();
    assert_eq!((told["los"].as_bool(), told["margin_m"].as_f64()), (Some(link.los()), link.margin_m()));
    assert!(!link.los() && link.obstruction().is_some());
    Ok(())
}

#[test]
fn answers_tell_what_their_documents_tell() -> Result<(), skyshed::Error> {
    let folder = Folder::new();
    let city = Scene::options().size(200.0).seed(3).open("itu:urban")?;
    let uavs = [40.0, 150.0].map(|x| Uav::new(x, 60.0, Height::agl(90.0)));
    let seen = city.coverages(uavs.clone()).run()?;
    let compared = city.compare(uavs).run()?.document();
    assert_eq!(serde_json::json!(seen.seen_by()), compared["seen_by"]);

    let found = city.placements([Height::agl(90.0)]).step(50.0).run()?;
    let (refined, share) = found.refined().unwrap();
    let best = found.share(found.best().unwrap());
    assert!(share >= best && share.is_some(), "{refined:?}: {share:?}, {best:?}");
    assert_eq!(found.document()["refined"]["p_los"].as_f64(), share);

    let link = city.link(Uav::new(40.0, 60.0, Height::agl(60.0)), (190.0, 190.0), Height::agl(1.5))?;
    let told = link.document();
    let above = |name: &str| told["obstruction"][name].as_f64().unwrap();
    let depth = link.obstruction().and_then(skyshed::LinkObstruction::depth_m);
    assert_eq!(depth, Some(above("roof_height_m") - above("ray_height_m")));

    let (path, look) = (folder.join("link.png"), || SaveOptions::default().title("A link").overwrite(true));
    link.save_with(&path, &look())?;
    link.save_with(&path, &look())?;
    let refused = link.save_with(&path, &look().bare(true)).expect_err("a link has no bare picture");
    assert_eq!(refused.code(), "E116");
    Ok(())
}

/// A document without what differs between any two doors: words, times, names of tables.
fn answer(mut document: serde_json::Value) -> serde_json::Value {
    fn forget(value: &mut serde_json::Value) {
        match value {
            serde_json::Value::Object(members) => {
                ["command", "request", "timing", "timing_s", "sources", "memory"]
                    .iter()
                    .for_each(|name| drop(members.remove(*name)));
                members.values_mut().for_each(forget);
            }
            serde_json::Value::Array(values) => values.iter_mut().for_each(forget),
            _ => {}
        }
    }
    forget(&mut document);
    document
}

#[test]
fn a_document_holds_its_question() {
    let folder = Folder::new();
    folder.write("walk.csv", "x,y\n20,10\n180,10\n");
    let city = "itu:urban --size 200 --seed 3 --overwrite --threads 1 -o d.json -q";
    let lines = [
        "chart CITY --uav 40,60,90 --method sweep",
        "city CITY",
        "compare CITY --uav 40,60,90 --uav 150,110,90 --block 30",
        "info CITY",
        "limits CITY --uav 40,60,90 --uav-error 2 --radius 120",
        "link CITY --uav 40,60,90 --rx 180,20",
        "live CITY --uav 40,60,90",
        "map CITY --uav 40,60,90 --sector 10,200 --zones",
        "place CITY --step 50 --height 60,90 --top 2",
        "plos itu:urban --method product --theta 30,60 -o d.json --overwrite -q",
        "sample CITY --zones street:3,rooftop:2 --height 60 --radius 50",
        "stress --scenes 2 --method ray --seed 5 -o d.json -q",
        "track CITY --uav 40,60,90 --track walk.csv --every 2",
        "zones CITY",
    ];
    for line in lines {
        let command = line.split(' ').next().unwrap();
        let asked = |line: &str| {
            folder.type_in(line).done();
            let document = folder.json("d.json");
            folder.remove(&["d.json".to_string()]);
            document
        };
        let first = asked(&line.replace("CITY", city));
        let request = first["request"].as_object().unwrap_or_else(|| panic!("{line}: no request"));
        let words = skyshed::request::json::command_line(command, request.clone());
        let again = asked(&format!("{} --threads 1 -o d.json -q", words.join(" ")));
        assert_eq!(request, again["request"].as_object().unwrap(), "{line}");
        // Times of a chart are those of its runs.
        if command != "chart" {
            assert_eq!(answer(first), answer(again), "{line}");
        }
    }
}

#[test]
fn reports_are_those_of_the_program() -> Result<(), skyshed::Error> {
    let folder = Folder::new();
    folder.write("walk.csv", "x,y\n20,10\n180,10\n180,150\n");
    let city = Scene::options().size(200.0).seed(3).keeps_footprints().open("itu:urban")?;
    let uavs = [(40.0, 60.0), (150.0, 110.0)].map(|(x, y)| Uav::new(x, y, Height::agl(90.0)));
    let [first, second] = uavs.clone();
    let zones = ["street:3", "rooftop:2"].map(|zone| zone.parse::<skyshed::ZoneCount>().unwrap());
    let reports = [
        ("zones SCENE", city.zone_report()?),
        (
            "limits SCENE --uav 40,60,90 --uav-error 2 --radius 120",
            city.limits([first.clone()]).uav_error(2.0).radius(120.0).run()?,
        ),
        (
            "compare SCENE --uav 40,60,90 --uav 150,110,90 --height-error 2 --block 30",
            city.compare([first.clone(), second]).height_error(2.0).block(30.0).run()?,
        ),
        (
            "track SCENE --uav 40,60,90 --track walk.csv --every 2 --rx-height 3",
            city.track(first, [(20.0, 10.0), (180.0, 10.0), (180.0, 150.0)]).every(2.0).rx_height(3.0).run()?,
        ),
        (
            "sample SCENE --zones street:3,rooftop:2 --height 60 --radius 50",
            city.sample().zones(zones).height([Height::agl(60.0)]).radius(50.0).run()?,
        ),
        ("info SCENE", Scene::options().size(200.0).seed(3).info("itu:urban")?),
    ];
    for (line, report) in reports {
        let line = format!("{} --json -q", line.replace("SCENE", "itu:urban --size 200 --seed 3"));
        assert_eq!(answer(report.document()), answer(folder.type_in(&line).done().json()), "{line}");
    }
    Ok(())
}

#[test]
fn options_that_change_no_answer_of_the_library_are_refused() -> Result<(), skyshed::Error> {
    use skyshed::request::SetEffort;
    use skyshed::{Job, MapRequest};

    let folder = Folder::new();
    folder.write("wall.asc", "ncols 3\nnrows 1\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2 1\n");
    let wall = Scene::options().ground(0.0).open(folder.join("wall.asc"))?;
    let uav = || Uav::new(0.5, 0.5, Height::agl(9.0));
    let mask = folder.join("mask.tif");
    wall.coverage(uav()).run()?.save(&mask)?;
    let map = || MapRequest::default().scene("itu:urban").uav(["9,9,90"]);
    let refused = [
        wall.limits([uav()]).cities(3_u16).run().expect_err("one city"),
        wall.compare([uav()]).mask([mask]).height_error(2.0).run().expect_err("one UAV"),
        Job::of(map().threads(2_u16)).expect_err("threads"),
        Job::of(map().json(true)).expect_err("a document"),
    ];
    for error in refused {
        assert_eq!(error.code(), "E116", "{error}");
    }
    Ok(())
}
