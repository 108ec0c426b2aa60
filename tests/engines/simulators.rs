//! Both simulators of generated cities: against the product, against each other link by link, and against rays.

use skyshed_core::city::BuiltUpCity;
use skyshed_core::height_field::HeightField;
use skyshed_core::los::prisms_los;
use skyshed_request::{Placement, Users};
use skyshed_study::los_probability::city::{CityDraw, CityLink, CitySimulator};
use skyshed_study::los_probability::estimate::{clustered, wilson};
use skyshed_study::los_probability::geometry::GeometrySimulator;
use skyshed_study::los_probability::setting::Setting;

use crate::cities::{built, generated};
use crate::los_probability::{CITIES, setting};
use crate::products::{at_height, built_up, product};
use crate::support::is_long;

/// Combinations of placement and users.
fn kinds() -> Vec<(Placement, Users)> {
    let placements = [Placement::Anywhere, Placement::Street, Placement::Crossroad, Placement::Rooftop];
    let users = [Users::Outdoor, Users::Street, Users::Crossroad];
    placements.into_iter().flat_map(|p| users.into_iter().map(move |u| (p, u))).collect()
}

/// Compares both simulators with the product, each value within 4 standard errors of both, and returns how many values were
/// compared and how many of them are beyond 2.
fn compare_with_the_product(settings: &[Setting], n_cities: u64, points: u64) -> (usize, usize) {
    let (mut n_compared, mut n_far) = (0, 0);
    let counts = CitySimulator::new(settings, 360).unwrap().count_many(11, 0, n_cities);
    for (k, asked) in settings.iter().enumerate() {
        let reference = product(asked, points);
        let column: Vec<_> = counts.iter().map(|draw| draw[k]).collect();
        let whole = clustered(&column, 0.95);
        let Some(wanted) = reference.p_los else {
            // Right below a roof there is no user; both simulators find none either.
            assert_eq!(whole.samples, 0, "{asked:?}");
            assert_eq!(GeometrySimulator::new(asked).draw(13, 0), None, "{asked:?}");
            continue;
        };
        let count = GeometrySimulator::new(asked).count(13, 0, 4 * n_cities);
        let drawn = wilson(count.los, count.receivers, 0.95);
        for (name, found) in [("city", whole), ("geometry", drawn)] {
            let Some(p) = found.p_los.filter(|_| found.clusters >= 30) else {
                // Users of the kind are rare at such places: too few draws have one.
                assert!(name == "city" && found.clusters * 5 < n_cities, "{name}, {asked:?}: {found:?}");
                continue;
            };
            // Where P_LoS is nearly 0 or 1 few cities hold all exceptions, and what these show of the spread is too little.
            let expected = (wanted * (1.0 - wanted) / found.samples as f64).sqrt();
            let error = match found.std_error.unwrap() {
                error if (0.01..=0.99).contains(&wanted) => error,
                error => error.max(expected).max(1.0 / found.samples as f64),
            };
            let off = (p - wanted).abs() / error.hypot(reference.std_error.unwrap());
            assert!(off < 4.0, "{name}, {asked:?}: {p} ± {error}, product {wanted} ± {:?}", reference.std_error);
            n_far += usize::from(off > 2.0);
            n_compared += 1;
        }
    }
    (n_compared, n_far)
}

/// Compares the settings of every city, `least` values or more.
fn agree_with_the_product(settings: impl Fn(&str) -> Vec<Setting>, n_cities: u64, points: u64, least: usize) {
    let found = CITIES.map(|city| compare_with_the_product(&settings(city), n_cities, points));
    let (n_compared, n_far) = found.iter().fold((0, 0), |sum, (compared, far)| (sum.0 + compared, sum.1 + far));
    assert!(n_compared >= least, "{n_compared}");
    // One in twenty is expected beyond 2 standard errors; the rows of one city share their draws.
    assert!(n_far * 8 < n_compared, "{n_far} of {n_compared} are more than 2 standard errors off");
}

#[test]
fn the_city_and_the_geometry_simulator_agree_with_the_product() {
    let (n_cities, points) = if is_long() { (4000, 1 << 13) } else { (250, 1 << 10) };
    let angles: Vec<f64> =
        if is_long() { (1..=17).map(|k| 5.0 * f64::from(k)).collect() } else { vec![5.0, 20.0, 45.0, 70.0, 85.0] };
    let settings = |city: &str| -> Vec<Setting> {
        let of = |(placement, users), theta: &f64| Setting { placement, users, ..setting(city, *theta) };
        kinds().into_iter().flat_map(|kind| angles.iter().map(move |theta| of(kind, theta))).collect()
    };
    agree_with_the_product(settings, n_cities, points, 550);
}

#[test]
fn azimuths_areas_clear_uavs_and_raised_receivers_agree_with_the_product() {
    let (n_cities, points) = if is_long() { (4000, 1 << 13) } else { (400, 1 << 10) };
    let settings = |city: &str| -> Vec<Setting> {
        let base = setting(city, 30.0);
        let mut settings = Vec::new();
        for (placement, users) in kinds() {
            // φ near 0 and 90 tells a mistaken street, 45 a mistaken mirror image.
            settings.extend([15.0, 45.0, 75.0].map(|phi| Setting { phi_deg: Some(phi), placement, users, ..base }));
            settings.push(Setting { uav_clear_of_roof: true, placement, users, ..base });
        }
        for placement in Placement::ALL {
            let reach = |radius: f64| Setting::reach_within(radius, 100.0, 0.0).unwrap();
            settings.extend([60.0, 200.0].map(|radius| Setting { reach: reach(radius), placement, ..base }));
        }
        let raised = Setting::reach_at_elevation(20.0, 80.0, 10.0).unwrap();
        settings.push(Setting { uav_height_m: 80.0, rx_height_m: 10.0, reach: raised, ..base });
        settings
    };
    agree_with_the_product(settings, n_cities, points, 600);
}

/// Draws cities until at least `wanted` links were decided, and compares what the city simulator counts with what
/// `decide` says of the links in the city with that seed.
fn compare_link_by_link(
    settings: impl Fn(&str) -> Vec<Setting>,
    mut decide: impl FnMut(&CitySimulator, &CityDraw, &Setting, &[CityLink]) -> u64,
) {
    let wanted = if is_long() { 1_000_000 } else { 50_000 };
    let (mut n_links, mut n_los) = (0, 0);
    'cities: for round in 0.. {
        for city in CITIES {
            let asked = settings(city);
            let simulator = CitySimulator::new(&asked, 360).unwrap();
            let draw = CityDraw::new(17, round);
            let mut heights = built_up(city).heights(draw.seed);
            for (asked, count) in asked.iter().zip(simulator.count(&draw)) {
                let links = simulator.links(asked, &draw, &mut |i, j| heights.steps(i, j)).unwrap();
                let los = decide(&simulator, &draw, asked, &links);
                assert_eq!((count.receivers, count.los), (links.len() as u64, los), "{asked:?}");
                n_links += count.receivers;
                n_los += los;
            }
            if n_links >= wanted {
                break 'cities;
            }
        }
    }
    assert!(n_los * 10 > n_links && n_los * 10 < n_links * 9, "{n_los} of {n_links}");
}

#[test]
fn the_simulators_agree_link_by_link_in_the_same_city() {
    let settings = |city: &str| -> Vec<Setting> {
        let of = |theta: f64, (rx_height_m, uav_height_m): (f64, f64)| Setting {
            rx_height_m,
            uav_height_m,
            reach: Setting::reach_at_elevation(theta, uav_height_m, rx_height_m).unwrap(),
            ..setting(city, theta)
        };
        let angles = [5.0, 15.0, 30.0, 50.0, 75.0];
        angles.into_iter().flat_map(|theta| [(1.5, 60.0), (0.0, 100.0)].map(|heights| of(theta, heights))).collect()
    };
    compare_link_by_link(settings, |_, draw, asked, links| {
        let geometry = GeometrySimulator::new(asked);
        let mut heights = asked.built_up.heights(draw.seed);
        links.iter().filter(|link| geometry.los(link, &mut heights)).count() as u64
    });
}

#[test]
fn the_simulators_agree_with_rays_through_the_city_as_built() {
    let settings = |city: &str| -> Vec<Setting> {
        let angles = [8.0, 15.0, 30.0, 60.0];
        angles.into_iter().flat_map(|theta| [20.0, 100.0].map(|height| at_height(city, theta, height))).collect()
    };
    // One city serves all its settings.
    let mut known: Option<(u64, HeightField)> = None;
    compare_link_by_link(settings, |simulator, draw, asked, links| {
        let key = draw.seed ^ asked.built_up.buildings_per_km2.to_bits() ^ asked.built_up.height_scale.to_bits();
        if known.as_ref().is_none_or(|(of, _)| *of != key) {
            let (built_up, cell_m) = (asked.built_up, 50.0);
            let size_m = (simulator.n_buildings() as f64).sqrt() * built_up.period();
            let city = BuiltUpCity { built_up, cell_m, ..generated("urban", draw.seed, size_m) };
            known = Some((key, built(&city)));
        }
        let prisms = known.as_ref().and_then(|(_, field)| field.prisms()).unwrap();
        links.iter().filter(|link| prisms_los(prisms, link.uav, link.receiver)).count() as u64
    });
}
