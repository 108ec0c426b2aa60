//! Real cities against the masks of an independent engine (float32 ray tracing), and every disagreement against the
//! oracle.
//!
//! The masks are right to the precision of 32-bit floats, so a few cells differ. For each of them the exact oracle is
//! asked and must side with us, and the difference must be of one of two kinds. A *tie*: our own answer turns into
//! theirs when one end of the link moves by one or two lattice steps. A *corner*: the ray meets lattice corners exactly
//! (UAV and receiver both at cell centers, on a diagonal), where a ray tracer slips between the faces that meet there.

use std::path::{Path, PathBuf};

use serde_json::Value;
use skyshed_core::city::{City, Footprint, NodataAs, Site, Solids};
use skyshed_core::coverage::{MapOptions, SiteCoverage, Uav, class};
use skyshed_core::height_field::{HeightField, Station};
use skyshed_core::los::{MethodChoice, link_los};
use skyshed_core::quantity::{Height, LatticePoint, height_steps};
use skyshed_io::formats::GeoTiff;
use skyshed_io::read::{FootprintOptions, SurfaceOptions, read_footprints, read_surface};
use skyshed_request::{DataAreaChoice, MissingHeights, WithoutHeight};

use crate::invariants::map;
use crate::needs::truth;
use crate::oracle;
use crate::support::{Random, class_of, is_long};
use crate::translation::oracle_of;

fn maps() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("maps")
}

fn surface_scene(dsm: &Path, terrain: &Path, building_threshold_m: f64) -> City {
    let options = SurfaceOptions {
        terrain: Some(terrain.into()),
        building_threshold_m,
        nodata_as: NodataAs::Clear,
        ..SurfaceOptions::default()
    };
    read_surface(dsm, &options, &mut Vec::new()).unwrap()
}

fn footprint_scene(buildings: &Path, terrain: &Path) -> City {
    let options = FootprintOptions {
        top_field: Some("z_top".into()),
        missing: MissingHeights::only(WithoutHeight::Fail),
        data_area: DataAreaChoice::All,
        terrain: Some(terrain.into()),
        ..FootprintOptions::default()
    };
    read_footprints(buildings, &options, &mut Vec::new()).unwrap()
}

fn read_mask(path: &Path, band: usize) -> Vec<u8> {
    let mut warnings = Vec::new();
    let file = GeoTiff::open(path, &mut warnings).unwrap();
    file.read_band(band, file.georef().window(), &mut warnings, class_of).unwrap().into_cells().into_vec()
}

/// The oracle on the solids of a scene.
struct Referee {
    columns: Option<oracle::Columns>,
    footprints: Vec<Footprint>,
}

impl Referee {
    /// The height field of a scene, and the oracle on the same solids.
    fn of(scene: City) -> (HeightField, Self) {
        let footprints = match &scene.solids {
            Solids::Vector { footprints, .. } => footprints.clone(),
            Solids::Raster { .. } => Vec::new(),
        };
        let field = HeightField::build(&scene.grid, scene.solids).field;
        let columns = field.columns().map(oracle_of);
        (field, Referee { columns, footprints })
    }

    fn los(&self, uav: &Station, receiver: &Station) -> bool {
        let p3 = |p: LatticePoint| [p.x, p.y, p.z];
        let (u, r) = (p3(uav.on_prisms()), p3(receiver.on_prisms()));
        // Only footprints whose bounding box meets that of the link can matter.
        let near = |f: &&Footprint| {
            (0..2).all(|k| {
                let values = || f.polygons.iter().flatten().flatten().map(|p| i64::from(p[k]));
                let (low, high) = (values().min().unwrap(), values().max().unwrap());
                low <= u[k].max(r[k]) && high >= u[k].min(r[k])
            })
        };
        let wide = |p: &[i32; 2]| [i64::from(p[0]), i64::from(p[1])];
        let prism = |polygon: &Vec<Vec<[i32; 2]>>, top: i32| oracle::Prism {
            rings: polygon.iter().map(|ring| ring.iter().map(wide).collect()).collect(),
            top: i64::from(top),
        };
        let near = self.footprints.iter().filter(near);
        let prisms: Vec<_> = near.flat_map(|f| f.polygons.iter().map(|polygon| prism(polygon, f.top))).collect();
        let columns_los = |c: &_| oracle::columns_los(c, p3(uav.on_columns()), p3(receiver.on_columns()));
        oracle::prisms_los(&prisms, u, r) && self.columns.as_ref().is_none_or(columns_los)
    }
}

fn options() -> MapOptions {
    MapOptions { rx_height: height_steps(1.5).unwrap(), ..MapOptions::default() }
}

/// The receiver of a cell that a map has decided.
fn receiver_at(field: &HeightField, index: usize) -> Station {
    let n_cols = field.grid().n_cols();
    let place = field.positions().center(index / n_cols, index % n_cols);
    let z = i64::from(field.ground_at(&place)) + i64::from(height_steps(1.5).unwrap());
    Station { place, z }
}

/// Whether our own answer turns when an end of the link moves by up to two lattice steps.
fn is_tie(field: &HeightField, uav: &Station, receiver: &Station, ours: bool) -> bool {
    let grid = field.grid();
    let (step_x, step_y) = (grid.cell_width() / 1024.0, grid.cell_height() / 1024.0);
    let moved = |s: &Station, dx: f64, dy: f64, dz: i64| Station {
        place: field.place(s.place.x + dx * step_x, s.place.y + dy * step_y),
        z: s.z + dz,
    };
    (0..125).any(|k: i32| {
        let (dx, dy, dz) = (f64::from(k % 5 - 2), f64::from(k / 5 % 5 - 2), i64::from(k / 25 - 2));
        link_los(field, &moved(uav, dx, dy, dz), receiver) != ours
            || link_los(field, uav, &moved(receiver, dx, dy, dz)) != ours
    })
}

/// Whether the ray passes exactly through a corner of four cells.
fn meets_a_corner(uav: &Station, receiver: &Station) -> bool {
    let (u, r) = (uav.on_columns(), receiver.on_columns());
    let (dx, dy) = (u.x - r.x, u.y - r.y);
    if dx == 0 || dy == 0 {
        return false;
    }
    let (west, east) = (u.x.min(r.x), u.x.max(r.x));
    (west.div_euclid(1024) + 1..=east.div_euclid(1024)).any(|line| {
        let along = (line * 1024 - r.x) * dy;
        along % dx == 0 && (r.y + along / dx) % 1024 == 0
    })
}

/// Compares all UAVs of a city with the masks of an independent engine, of which at least these shares of cells must agree
/// for UAVs placed on a street and for all others; returns the number of evaluated cells.
fn compare(scene: City, truth: &Path, mask: &str, [street, others]: [f64; 2]) -> usize {
    let (field, referee) = Referee::of(scene);
    let facts: Value = serde_json::from_str(&std::fs::read_to_string(truth.join("truth.json")).unwrap()).unwrap();
    let mut n_evaluated = 0;
    for (band, uav) in facts["uavs"].as_array().unwrap().iter().enumerate() {
        let number = |v: &Value| v.as_f64().unwrap();
        let (id, height) = (uav["id"].as_str().unwrap(), Height::AboveDatum(number(&uav["z"])));
        let site = Site::new(id, (number(&uav["xy"][0]), number(&uav["xy"][1])), height);
        let placed = Uav::place(&site, &field, None).unwrap();
        let SiteCoverage { mask: ours, tally, .. } = map(&field, &placed, &options());
        // The engine for this kind of scene gives what a ray for each receiver gives.
        if n_evaluated == 0 || is_long() {
            let by_rays = map(&field, &placed, &MapOptions { method: MethodChoice::Ray, ..options() });
            assert!(ours == by_rays.mask && tally == by_rays.tally, "the engines differ");
        }
        let theirs = read_mask(&truth.join(mask), band);
        let both: Vec<usize> = (0..ours.len()).filter(|&i| ours[i] <= class::LOS && theirs[i] != 255).collect();
        let differing: Vec<usize> = both.iter().copied().filter(|&i| ours[i] != theirs[i]).collect();
        let agreement = 1.0 - differing.len() as f64 / both.len() as f64;
        let wanted = if uav["place"] == "street" { street } else { others };
        let (city, n) = (truth.display(), both.len());
        assert!(agreement >= wanted, "{city} {mask} {id}: {agreement:.6} of {n} cells agree, wanted {wanted}");
        for &i in &differing {
            let receiver = receiver_at(&field, i);
            let is_los = ours[i] == class::LOS;
            assert_eq!(referee.los(&placed.station, &receiver), is_los, "{city} {mask} {id}: cell {i}, the oracle");
            let corner = field.columns().is_some() && meets_a_corner(&placed.station, &receiver);
            let explained = corner || is_tie(&field, &placed.station, &receiver, is_los);
            assert!(explained, "{city} {mask} {id}: cell {i} is neither a tie nor a corner");
        }
        n_evaluated += n;
    }
    n_evaluated
}

/// A city of footprints, surface and terrain, as one of the two; with the name of its masks.
fn city([buildings, dsm, terrain]: &[PathBuf; 3], footprints: bool) -> (City, &'static str) {
    if footprints {
        (footprint_scene(buildings, terrain), "lod1_los.tif")
    } else {
        (surface_scene(dsm, terrain, 0.25), "block_los.tif")
    }
}

fn munich(footprints: bool) -> (City, &'static str) {
    let files = ["munich.geojson", "munich_dsm.tif", "munich_terrain.tif"];
    city(&files.map(|file| maps().join(file)), footprints)
}

#[test]
fn the_raster_and_the_footprints_of_munich_agree_with_an_independent_engine() {
    for (footprints, n_cells) in [(false, 1_232_980), (true, 1_232_974)] {
        let (scene, mask) = munich(footprints);
        // The README's figure.
        assert_eq!(compare(scene, &maps().join("munich_truth"), mask, [0.99997; 2]), 6 * n_cells);
    }
}

#[test]
fn rasters_and_footprints_of_the_other_cities_agree_with_an_independent_engine() {
    let Some(shared) = truth() else { return };
    for name in ["etoile", "simple_street_canyon"] {
        let files = ["buildings.geojson", "dsm_1m.tif", "terrain_1m.tif"];
        let files = files.map(|file| shared.join("cities").join(name).join(file));
        for footprints in [false, true] {
            let (scene, mask) = city(&files, footprints);
            assert!(compare(scene, &shared.join("truth").join(name), mask, [0.9999, 0.999]) > 200_000, "{name}");
        }
    }
}

#[test]
fn lidar_rasters_agree_with_an_independent_engine() {
    let Some(shared) = truth() else { return };
    for (city, dsm, terrain, n_cells) in [
        ("bilbao", "dsm_2.5m.tif", "terrain_2.5m.tif", 6 * 521_908),
        ("delft", "dsm_1m.tif", "terrain_1m.tif", 6 * 34_868),
    ] {
        let folder = shared.join("lidar").join(city);
        let scene = surface_scene(&folder.join(dsm), &folder.join(terrain), 0.5);
        let truth = shared.join("truth").join(city);
        assert_eq!(compare(scene, &truth, "block_los.tif", [0.999; 2]), n_cells, "{city}");
    }
}

#[test]
fn uavs_over_roofs_of_munich_agree_with_the_oracle() {
    for footprints in [false, true] {
        let (field, referee) = Referee::of(munich(footprints).0);
        let n_links = if is_long() { 6_000 } else { 60 };
        let mut random = Random(11);
        let (mut n, mut n_los) = (0, 0);
        while n < n_links {
            let (n_cells, n_cols) = (field.grid().n_cells(), field.grid().n_cols());
            let (above, below) = (random.below(n_cells), random.below(n_cells));
            let over = field.positions().center(above / n_cols, above % n_cols);
            let Some(roof) = field.roof_at(&over) else { continue };
            // Exactly on the roof, a step above it, and hovering.
            let z = i64::from(roof) + [0, 1, 3 * 1024, 30 * 1024, 120 * 1024][n % 5];
            let (uav, receiver) = (Station { place: over, z }, receiver_at(&field, below));
            let is_los = link_los(&field, &uav, &receiver);
            assert_eq!(is_los, referee.los(&uav, &receiver), "UAV over cell {above} at {z}, receiver in cell {below}");
            n += 1;
            n_los += usize::from(is_los);
        }
        assert!(n_los > n / 50, "{n_los} of {n} links are LoS");
    }
}
