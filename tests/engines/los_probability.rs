//! P_LoS against reference values that an independent program computed, against a brute force written here, and by the
//! properties that it must have.

use std::collections::HashMap;

use serde_json::Value;
use skyshed_core::city::BuiltUp;
use skyshed_request::{Placement, Users};
use skyshed_study::los_probability::points::Points;
use skyshed_study::los_probability::product::{across_street, link_p_los, rayleigh_cdf};
use skyshed_study::los_probability::setting::Setting;
use skyshed_study::los_probability::street_grid::{Crossing, GridLink, GridZone, StreetGrid};

use crate::needs::truth;
use crate::products::{at_height, built_up, product};
use crate::support::{Random, is_long};
use crate::texts::number;

/// The five cities of the reference tables.
pub(crate) const CITIES: [&str; 5] = ["suburban", "urban", "dense", "highrise", "ghent"];

/// Outdoor users of a UAV anywhere at 100 m, receivers on the ground, as the reference tables have it.
pub(crate) fn setting(city: &str, theta_deg: f64) -> Setting {
    at_height(city, theta_deg, 100.0)
}

/// Rows of a reference table as maps from column to text; `None` where the tables are not at hand.
pub(crate) fn reference(name: &str) -> Option<Vec<HashMap<String, String>>> {
    let path = truth()?.join("../reference").join(name);
    let mut reader = csv::Reader::from_path(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    Some(reader.deserialize().map(|row| row.unwrap()).collect())
}

#[test]
fn the_product_gives_the_reference_values_within_their_errors() {
    let Some(rows) = reference("plos_reference.csv") else { return };
    let points = if is_long() { 1 << 14 } else { 1 << 10 };
    let mut known: HashMap<String, (f64, f64)> = HashMap::new();
    let mut estimate = |setting: Setting| {
        *known.entry(format!("{setting:?}")).or_insert_with(|| {
            let exact =
                (setting.phi_deg == Some(0.0) && setting.users == Users::Street).then(|| across_street(&setting));
            match exact.flatten() {
                Some(p) => (p, 0.0),
                None => {
                    let e = product(&setting, points);
                    (e.p_los.unwrap(), e.std_error.unwrap())
                }
            }
        })
    };
    let (mut n_rows, mut n_far, mut worst) = (0, 0, 0.0_f64);
    for row in &rows {
        let mut asked = at_height(&row["env"], number(row, "theta_deg"), number(row, "h_uav_m"));
        asked.phi_deg = row["phi_deg"].parse().ok();
        let mut of = |users: Users| estimate(Setting { users, ..asked });
        let (p, error) = match row["user_class"].as_str() {
            "street" => of(Users::Street),
            "crossroad" => of(Users::Crossroad),
            "outdoor" => of(Users::Outdoor),
            "strip" => {
                // One street with one crossroad, as the paper's figure 5 has it: crossroads have s/(s + w) of it.
                let grid = StreetGrid::new(&asked.built_up);
                let share = grid.street() / grid.period();
                let (street, crossroad) = (of(Users::Street), of(Users::Crossroad));
                let mix = |a: f64, b: f64| (1.0 - share) * a + share * b;
                (mix(street.0, crossroad.0), mix(street.1.powi(2) * (1.0 - share), crossroad.1.powi(2) * share).sqrt())
            }
            other => panic!("unknown class {other}"),
        };
        let (wanted, wanted_error) = (number(row, "p_los"), number(row, "std_err"));
        let combined = error.hypot(wanted_error);
        let off = (p - wanted).abs();
        assert!(off <= 5.0 * combined + 1e-6, "{row:?}: {p} ± {error}");
        n_far += usize::from(off > 3.0 * combined + 1e-6);
        worst = worst.max((off - 1e-6).max(0.0) / combined.max(1e-300));
        n_rows += 1;
    }
    assert_eq!(n_rows, 1280);
    assert!(
        n_far * 100 <= n_rows,
        "{n_far} of {n_rows} rows are more than 3 standard errors off; the worst {worst:.2}"
    );
}

/// The buildings that a link crosses, each with the height of the ray at the obstructing point \[m\] and the probability
/// that the building is not higher.
fn factors(grid: &StreetGrid, height_scale: f64, link: &GridLink) -> Vec<(Crossing, f64, f64)> {
    let r = link.ground_distance();
    let mut factors = Vec::new();
    grid.for_each_crossed(link, |crossing| {
        let z = link.height_at(crossing.t_in, r).min(link.height_at(crossing.t_out, r));
        factors.push((crossing, z, rayleigh_cdf(z, height_scale)));
        true
    });
    factors
}

#[test]
fn single_links_have_the_reference_buildings_and_probabilities() {
    let Some(folder) = truth() else { return };
    let text = std::fs::read_to_string(folder.join("../reference/plos_links.json")).unwrap();
    let links: Vec<Value> = serde_json::from_str(&text).unwrap();
    assert_eq!(links.len(), 50);
    let mut n_buildings = 0;
    for link in &links {
        let f = |key: &str| link[key].as_f64().unwrap();
        let end = |key: &str| [0, 1, 2].map(|k| link[key][k].as_f64().unwrap());
        let city = BuiltUp::new(f("alpha"), f("beta"), f("gamma")).unwrap();
        let grid = StreetGrid::new(&city);
        let ends = GridLink { receiver: end("user"), uav: end("uav") };
        let mut found = factors(&grid, city.height_scale, &ends);
        found.sort_by(|a, b| a.0.t_in.total_cmp(&b.0.t_in));
        let wanted = link["buildings"].as_array().unwrap();
        assert_eq!(found.len(), wanted.len(), "{}: {}", link["env"], link["case"]);
        for ((ours, z, factor), theirs) in found.iter().zip(wanted) {
            let g = |key: &str| theirs[key].as_f64().unwrap();
            assert_eq!(i64::from(ours.building.0), theirs["i"].as_i64().unwrap(), "{}", link["case"]);
            assert_eq!(i64::from(ours.building.1), theirs["j"].as_i64().unwrap(), "{}", link["case"]);
            for (name, a, b) in [
                ("t_in", ours.t_in, g("t_in")),
                ("t_out", ours.t_out, g("t_out")),
                ("z_min", *z, g("z_min")),
                ("factor", *factor, g("factor")),
            ] {
                assert!((a - b).abs() <= 1e-12 * b.abs().max(1.0), "{} {name}: {a}, wanted {b}", link["case"]);
            }
            n_buildings += 1;
        }
        let p = link_p_los(&grid, city.height_scale, &ends);
        assert!((p - f("p_los")).abs() <= 1e-12, "{}: {p}, wanted {}", link["case"], f("p_los"));
    }
    assert!(n_buildings > 200, "{n_buildings}");
}

#[test]
fn the_quadrature_across_the_street_gives_the_reference_values_and_the_closed_form() {
    if let Some(rows) = reference("models_reference.csv") {
        for row in &rows {
            let mut asked = setting(&row["env"], number(row, "theta_deg"));
            (asked.users, asked.phi_deg) = (Users::Street, Some(0.0));
            let p = across_street(&asked).unwrap();
            // The reference is a midpoint rule of 200 001 nodes, printed to 6 digits.
            let wanted = number(row, "exact_phi0_street");
            assert!((p - wanted).abs() < 3e-6, "{row:?}: {p}");
        }
        assert_eq!(rows.len(), 90);
    }
    for city in CITIES {
        let grid = StreetGrid::new(&built_up(city));
        for theta in [60.0, 75.0, 85.0, 89.0] {
            let asked = Setting { users: Users::Street, phi_deg: Some(0.0), ..setting(city, theta) };
            let r = asked.reach.farthest();
            if r <= grid.period() {
                let (gamma, tan) = (asked.built_up.height_scale, 100.0 / r);
                let scale = gamma * (std::f64::consts::PI / 2.0).sqrt() / (grid.street() * tan);
                let closed = 1.0 - scale * libm::erf(r.min(grid.street()) * tan / (2.0_f64.sqrt() * gamma));
                let p = across_street(&asked).unwrap();
                assert!((p - closed).abs() < 1e-9, "{city} {theta}: {p}, closed {closed}");
            }
        }
    }
}

/// A link crosses a building: the slab test over every building near it, written without thought for speed.
fn crossed_by_brute_force(grid: &StreetGrid, link: &GridLink) -> Vec<(i32, i32)> {
    let (s, t) = (grid.street(), grid.period());
    let d = [link.uav[0] - link.receiver[0], link.uav[1] - link.receiver[1]];
    let range = |k: usize| {
        let (a, b) = (link.receiver[k].min(link.uav[k]), link.receiver[k].max(link.uav[k]));
        #[expect(clippy::cast_possible_truncation, reason = "a few hundred meters")]
        let cell = |v: f64| (v / t).floor() as i32;
        (cell(a) - 2, cell(b) + 2)
    };
    let mut found = Vec::new();
    for i in range(0).0..=range(0).1 {
        for j in range(1).0..=range(1).1 {
            let (mut t_in, mut t_out) = (0.0_f64, 1.0_f64);
            for (k, index) in [(0, i), (1, j)] {
                let (low, high) = (f64::from(index) * t + s, f64::from(index + 1) * t);
                let (a, b) = ((low - link.receiver[k]) / d[k], (high - link.receiver[k]) / d[k]);
                t_in = t_in.max(a.min(b));
                t_out = t_out.min(a.max(b));
            }
            if t_in < t_out {
                found.push((i, j));
            }
        }
    }
    found
}

#[test]
fn the_interval_walk_finds_what_a_slab_test_of_every_building_finds() {
    let mut random = Random(5);
    let mut n_crossed = 0;
    for round in 0..20_000 {
        let grid = StreetGrid::new(&built_up(CITIES[round % 5]));
        let mut place = |scale: f64| random.within(-1_000_000, 1_000_000) as f64 * 1e-6 * scale;
        let receiver = [place(100.0), place(100.0), 1.5];
        let uav = [receiver[0] + place(300.0), receiver[1] + place(300.0), 100.0];
        let link = GridLink { receiver, uav };
        let mut found = Vec::new();
        let mut last = 0.0;
        grid.for_each_crossed(&link, |c| {
            assert!(c.t_in >= last, "nearer buildings come first");
            last = c.t_in;
            found.push(c.building);
            true
        });
        found.sort_unstable();
        assert_eq!(found, crossed_by_brute_force(&grid, &link), "{link:?}");
        n_crossed += found.len();
    }
    assert!(n_crossed > 50_000, "{n_crossed}");
}

#[test]
fn a_straight_line_crosses_four_over_pi_times_the_root_of_alpha_beta_buildings_per_kilometer() {
    let mut random = Random(9);
    for city in CITIES {
        let built_up = built_up(city);
        let grid = StreetGrid::new(&built_up);
        let mut unit = || (random.next() >> 11) as f64 / 9_007_199_254_740_992.0;
        let (mut n, mut n_squared, rounds) = (0.0, 0.0, 4000);
        for _ in 0..rounds {
            let (x, y, (sin, cos)) =
                (unit() * grid.period(), unit() * grid.period(), (unit() * std::f64::consts::TAU).sin_cos());
            let link = GridLink { receiver: [x, y, 0.0], uav: [x + 1000.0 * cos, y + 1000.0 * sin, 0.0] };
            let crossed = crossed_by_brute_force(&grid, &link).len();
            let mut walked = 0_usize;
            grid.for_each_crossed(&link, |_| {
                walked += 1;
                true
            });
            assert_eq!(walked, crossed);
            n += walked as f64;
            n_squared += (walked * walked) as f64;
        }
        let mean = n / f64::from(rounds);
        let error = ((n_squared / f64::from(rounds) - mean * mean) / f64::from(rounds)).sqrt();
        // Both ends may be inside a building: one more crossing with probability α.
        let wanted = 4.0 / std::f64::consts::PI * (built_up.built_up_ratio * built_up.buildings_per_km2).sqrt()
            + built_up.built_up_ratio;
        assert!((mean - wanted).abs() < 4.0 * error, "{city}: {mean} ± {error}, wanted {wanted}");
    }
}

#[test]
fn raising_the_city_or_the_angle_of_a_link_moves_p_los_one_way() {
    let mut random = Random(3);
    for _ in 0..5_000 {
        let city = built_up(CITIES[random.below(5)]);
        let grid = StreetGrid::new(&city);
        let mut unit = || (random.next() >> 11) as f64 / 9_007_199_254_740_992.0;
        let (x, y, phi) = (unit() * grid.street(), unit() * grid.period(), unit() * 1.5);
        let (theta, h) = (0.1 + 1.3 * unit(), 20.0 + 300.0 * unit());
        let p = |theta: f64, h: f64, gamma: f64| {
            let r = h / theta.tan();
            let link = GridLink { receiver: [x, y, 0.0], uav: [x + r * phi.cos(), y + r * phi.sin(), h] };
            link_p_los(&grid, gamma, &link)
        };
        let base = p(theta, h, city.height_scale);
        let slack = 1e-12;
        assert!(p(theta, h, 1.1 * city.height_scale) <= base + slack, "higher buildings");
        assert!(p(theta, 1.2 * h, city.height_scale) <= base + slack, "a higher UAV at the same angle");
        assert!(p(theta + 0.05, h, city.height_scale) >= base - slack, "a steeper link from the same height");
    }
    // From 9γ up the height no longer matters at a given angle.
    for city in CITIES {
        let scale = built_up(city).height_scale;
        let [low, high] = [9.0, 20.0].map(|k| product(&at_height(city, 20.0, k * scale), 256).p_los.unwrap());
        assert!((low - high).abs() < 1e-12, "{city}: {low} and {high}");
    }
}

/// The mean over evenly spread outdoor users and azimuths of P_LoS past the first building alone, and past all; and the
/// share of UAVs over a building.
fn past_the_first_building_and_past_all(asked: &Setting, n: usize) -> (f64, f64, f64) {
    let city = asked.built_up;
    let grid = StreetGrid::new(&city);
    let r = asked.reach.farthest();
    let (mut first, mut all, mut over, mut n_users) = (0.0, 0.0, 0, 0);
    for [u, v, azimuth, _] in Points::new(2, 0).take(n) {
        let user = [u * grid.period(), v * grid.period()];
        if grid.zone(user[0], user[1]) == GridZone::Building {
            continue;
        }
        let (sin, cos) = (azimuth * std::f64::consts::FRAC_PI_2).sin_cos();
        let uav = [user[0] + r * cos, user[1] + r * sin];
        let link = GridLink { receiver: [user[0], user[1], 0.0], uav: [uav[0], uav[1], asked.uav_height_m] };
        let met = factors(&grid, city.height_scale, &link);
        let (nearest, product) = (met.first().map_or(1.0, |f| f.2), met.iter().map(|f| f.2).product::<f64>());
        assert!(nearest >= product, "{link:?}");
        first += nearest;
        all += product;
        over += usize::from(grid.zone(uav[0], uav[1]) == GridZone::Building);
        n_users += 1;
    }
    let mean = |sum: f64| sum / n_users as f64;
    (mean(first), mean(all), over as f64 / n_users as f64)
}

#[test]
fn the_first_building_alone_leaves_at_least_as_much_line_of_sight() {
    let Some(rows) = reference("plos_firstbuilding.csv") else { return };
    for row in &rows {
        let asked = setting(&row["env"], number(row, "theta_deg"));
        let (first, all, over) = past_the_first_building_and_past_all(&asked, 1 << 15);
        // 2^15 points of one shift, less those on buildings: errors of some thousandths.
        let close = |a: f64, column: &str| (a - number(row, column)).abs() < 6e-3;
        assert!(close(first, "p_first_building_exact"), "{row:?}: {first}");
        assert!(close(all, "p_los_exact") && first >= all, "{row:?}: {all}");
        assert!(close(over, "q_uav_over_building"), "{row:?}: {over}");
    }
    assert_eq!(rows.len(), 85);
}

#[test]
fn averages_building_by_building_are_too_low_across_the_street() {
    // All factors grow with the distance to the first wall, so the mean of their product is above the product of means.
    for city in CITIES {
        let grid = StreetGrid::new(&built_up(city));
        for theta in [5.0, 10.0, 20.0, 40.0, 60.0, 80.0] {
            let asked = Setting { users: Users::Street, phi_deg: Some(0.0), ..setting(city, theta) };
            let r = asked.reach.farthest();
            let mut of_means = 1.0;
            for k in 0.. {
                let wall = f64::from(k) * grid.period();
                if wall >= r {
                    break;
                }
                // The midpoint rule; beyond the UAV nothing is in the way.
                let n = 4000;
                let factor = |j: i32| {
                    let t = wall + (f64::from(j) + 0.5) / f64::from(n) * grid.street();
                    if t < r { rayleigh_cdf(t * 100.0 / r, asked.built_up.height_scale) } else { 1.0 }
                };
                of_means *= (0..n).map(factor).sum::<f64>() / f64::from(n);
            }
            let exact = across_street(&asked).unwrap();
            assert!(exact >= of_means - 1e-9, "{city} at {theta}: exact {exact}, product of means {of_means}");
        }
    }
}

#[test]
fn azimuths_have_the_symmetries_of_the_grid() {
    for city in CITIES {
        let at = |users: Users, phi: f64| {
            let e = product(&Setting { users, phi_deg: Some(phi), ..setting(city, 30.0) }, 1 << 10);
            (e.p_los.unwrap(), e.std_error.unwrap())
        };
        for users in [Users::Crossroad, Users::Outdoor] {
            let ((a, da), (b, db)) = (at(users, 20.0), at(users, 70.0));
            assert!((a - b).abs() <= 4.0 * da.hypot(db) + 1e-9, "{city} {users:?}: {a} ± {da} and {b} ± {db}");
        }
        // Along a street nothing is in the way.
        for (users, phi) in [(Users::Street, 90.0), (Users::Crossroad, 0.0), (Users::Crossroad, 90.0)] {
            assert!(at(users, phi).0 >= 1.0, "{city} {users:?} {phi}");
        }
        let overhead = product(&setting(city, 90.0), 64);
        assert_eq!(overhead.p_los, Some(1.0));
    }
}

#[test]
fn uavs_over_the_middle_of_a_crossroad_street_or_building_see_what_the_reference_says() {
    let Some(rows) = reference("plos_uav_location.csv") else { return };
    let mut worst = 0.0_f64;
    for row in &rows {
        let placement = match row["uav_location"].as_str() {
            "crossroad_centre" => Placement::CrossroadCenter,
            "street_centre" => Placement::StreetCenter,
            "building_centre" => Placement::RooftopCenter,
            other => panic!("unknown place {other}"),
        };
        let asked = Setting { placement, ..setting(&row["env"], number(row, "theta_deg")) };
        for (clear, column) in [(false, "p_los_outdoor_users"), (true, "p_los_given_roof_below_uav")] {
            let Ok(wanted) = row[column].parse::<f64>() else { continue };
            let e = product(&Setting { uav_clear_of_roof: clear, ..asked }, if is_long() { 1 << 11 } else { 1 << 8 });
            let Some(p) = e.p_los else { continue };
            // The reference has one point in each of many directions: its error is unknown, and taken as 1e-3.
            let off = (p - wanted).abs();
            worst = worst.max(off);
            assert!(off <= 5.0 * e.std_error.unwrap() + 1e-3, "{row:?}: {p} ± {:?}", e.std_error);
        }
    }
    assert_eq!(rows.len(), 255);
    assert!(worst < 0.01, "{worst}");
}

#[test]
fn the_area_around_a_uav_over_a_middle_is_seen_as_the_reference_says() {
    // Area means of outdoor users within R of a UAV at 100 m, over the middle of a crossroad, a street, a building;
    // computed by an independent program and printed to 4 digits.
    let middles = [Placement::CrossroadCenter, Placement::StreetCenter, Placement::RooftopCenter];
    let reference: [(&str, f64, [f64; 3]); 8] = [
        ("suburban", 100.0, [0.9240, 0.9202, 0.9104]),
        ("urban", 50.0, [0.7901, 0.8539, 0.8913]),
        ("urban", 300.0, [0.4109, 0.4081, 0.4067]),
        ("dense", 50.0, [1.0000, 0.7519, 0.6251]),
        ("dense", 100.0, [0.6069, 0.5344, 0.4999]),
        ("highrise", 100.0, [0.4743, 0.3088, 0.1423]),
        ("highrise", 300.0, [0.1533, 0.0966, 0.0356]),
        ("ghent", 200.0, [0.2476, 0.2455, 0.2453]),
    ];
    for (city, radius, wanted) in reference {
        for (placement, wanted) in middles.into_iter().zip(wanted) {
            let reach = Setting::reach_within(radius, 100.0, 0.0).unwrap();
            let e = product(&Setting { reach, placement, ..setting(city, 30.0) }, 1 << 11);
            let (p, error) = (e.p_los.unwrap(), e.std_error.unwrap());
            // Its own error is unknown; a thousandth is what its last digits are worth.
            assert!((p - wanted).abs() < 4.0 * error + 1e-3, "{city} {radius} {placement:?}: {p} ± {error}, {wanted}");
        }
    }
}
