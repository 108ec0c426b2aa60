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
