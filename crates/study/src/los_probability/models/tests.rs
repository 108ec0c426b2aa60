//! Tests of all models, and the links that the tests of each share.

use super::*;
use crate::city::BuiltUp;

/// Names of the four environments.
pub(super) const NAMED: [&str; 4] = ["suburban", "urban", "dense", "high-rise"];
/// Names of the environments, and the center of Ghent as in Saboor et al. 2023.
pub(super) const CITIES: [&str; 5] = ["suburban", "urban", "dense", "high-rise", "ghent"];

pub(super) fn city(name: &str) -> BuiltUp {
    BuiltUp::named(name).unwrap_or_else(|| BuiltUp::new(0.435, 4679.0, 8.8).unwrap())
}

/// Returns the link to a UAV at 100 m from the ground at an elevation angle.
pub(super) fn link(name: &str, theta_deg: f64) -> ModelLink {
    let distance_m = if theta_deg < 90.0 { 100.0 / theta_deg.to_radians().tan() } else { 0.0 };
    let distance_m = distance_m.clamp(0.0, 1e6);
    ModelLink { built_up: city(name), uav_height_m: 100.0, rx_height_m: 0.0, theta_deg, distance_m, phi_deg: None }
}

#[track_caller]
pub(super) fn assert_near(found: f64, wanted: f64, tolerance: f64) {
    assert!((found - wanted).abs() <= tolerance, "found {found}, wanted {wanted} within {tolerance}");
}

#[test]
fn ids_are_unique_and_lead_back_to_their_model() {
    for (k, model) in Model::ALL.into_iter().enumerate() {
        assert_eq!(Model::from_id(model.id()), Some(model));
        assert_eq!(Model::from_id(&model.id().to_uppercase().replace('_', "-")), Some(model));
        assert_eq!(Model::from_id(&model.id().replace('-', "_")), Some(model));
        for other in &Model::ALL[k + 1..] {
            assert!(model.id() != other.id() && model.name() != other.name() && *other != model);
        }
        assert!(model.source().len() > 20 && model.domain().ends_with('.') && model.about().ends_with('.'));
    }
    assert_eq!(Model::from_id("mohammed2021"), None);
    assert_eq!(Model::from_id("tr38901_UMa"), Some(Model::Tr38901Uma));
}

#[test]
fn a_value_is_a_probability_wherever_there_is_one() {
    let mut n_values = [0; Model::ALL.len()];
    for name in CITIES {
        for uav_height_m in [0.0, 1.0, 1.5, 10.0, 22.5, 23.0, 60.0, 300.0, 20_000.0] {
            for rx_height_m in [0.0, 1.5, 12.0, 80.0] {
                for theta_deg in [0.0, 0.1, 1.0, 9.0, 45.0, 89.9, 90.0] {
                    for distance_m in [0.0, 0.5, 10.0, 18.0, 81.65, 1e3, 1e5] {
                        let link = ModelLink { uav_height_m, rx_height_m, distance_m, ..link(name, theta_deg) };
                        for (model, n) in Model::ALL.into_iter().zip(&mut n_values) {
                            let Ok(value) = model.p_los(&link) else { continue };
                            assert!((0.0..=1.0).contains(&value.p_los), "{}: {value:?} at {link:?}", model.id());
                            *n += 1;
                        }
                    }
                }
            }
        }
    }
    assert!(n_values.iter().all(|n| *n > 2000), "{n_values:?}");
}

#[test]
fn numbers_that_make_no_link_are_refused_by_all() {
    let good = link("urban", 30.0);
    let bad = [
        ModelLink { uav_height_m: f64::NAN, ..good },
        ModelLink { uav_height_m: -1.0, ..good },
        ModelLink { rx_height_m: f64::INFINITY, ..good },
        ModelLink { theta_deg: 90.5, ..good },
        ModelLink { theta_deg: f64::NAN, ..good },
        ModelLink { distance_m: -1.0, ..good },
        ModelLink { distance_m: f64::NAN, ..good },
        ModelLink { phi_deg: Some(f64::NAN), ..good },
        ModelLink { built_up: BuiltUp { built_up_ratio: 1.0, ..good.built_up }, ..good },
        ModelLink { built_up: BuiltUp { buildings_per_km2: f64::NAN, ..good.built_up }, ..good },
        ModelLink { built_up: BuiltUp { height_scale: 0.0, ..good.built_up }, ..good },
    ];
    for model in Model::ALL {
        for link in bad {
            assert!(model.p_los(&link).unwrap_err().to_string().contains("wanted"), "{}: {link:?}", model.id());
        }
    }
}

#[test]
fn overhead_every_geometric_model_gives_one() {
    for name in CITIES {
        for model in [Model::Itu, Model::Mohammed2023, Model::Kang2019, Model::Saboor2024, Model::Tr36777UmaAv] {
            assert_near(model.p_los(&link(name, 90.0)).unwrap().p_los, 1.0, 0.0);
        }
    }
}

#[test]
fn models_of_the_elevation_angle_rise_with_it() {
    for name in NAMED {
        for model in [Model::AlHourani2014, Model::AlHourani2014Table, Model::Holis2008, Model::Tr38811Linear] {
            let values: Vec<f64> =
                (1..=90).filter_map(|t| Some(model.p_los(&link(name, f64::from(t))).ok()?.p_los)).collect();
            assert!(values.is_sorted(), "{} in {name}", model.id());
            assert_eq!(values.len(), if (name, model) == ("high-rise", Model::Tr38811Linear) { 0 } else { 90 });
        }
    }
}

/// Checks links that a model was not made for: a caution beside its value, or a refusal.
#[test]
fn what_a_model_was_not_made_for_is_told() {
    let at = |h: f64| ModelLink { uav_height_m: h, rx_height_m: 25.0, ..link("urban", 30.0) };
    let of = |alpha: f64, beta: f64, gamma: f64| ModelLink {
        built_up: BuiltUp::new(alpha, beta, gamma).unwrap(),
        phi_deg: Some(0.0),
        ..link("urban", 30.0)
    };
    let street = ModelLink { rx_height_m: 1.5, ..at(10.0) };
    let roof = ModelLink { rx_height_m: 12.0, ..link("urban", 5.0) };
    let along = |phi: f64| ModelLink { phi_deg: Some(phi), ..link("urban", 30.0) };
    let platform = ModelLink { uav_height_m: 20_000.0, ..link("urban", 30.0) };
    let (none, care, refused) = (None, true, false);
    let cases = [
        (Model::AlHourani2014, link("urban", 30.0), none),
        (Model::AlHourani2014, of(0.1, 400.0, 8.0), Some((care, "the city has αβ = 40"))),
        (Model::AlHourani2014, of(0.3, 500.0, 6.0), Some((care, "γ = 6 m"))),
        (Model::AlHourani2014, link("ghent", 30.0), Some((refused, "b = -112.49"))),
        (Model::AlHourani2014Table, link("ghent", 30.0), Some((refused, "none of the environments"))),
        (Model::AlHourani2014Table, roof, Some((care, "street level"))),
        (Model::Holis2008, link("urban", 0.99), Some((refused, "wanted 1° to 90°"))),
        (Model::Holis2008, link("urban", 1.0), Some((care, "the UAV is at 100 m"))),
        (Model::Holis2008, platform, none),
        (Model::Kang2019, ModelLink { rx_height_m: 100.0, ..roof }, Some((refused, "wanted above the receiver"))),
        (Model::Mohammed2023, of(0.3, 500.0, 15.0), none),
        (Model::Mohammed2023, of(0.7, 500.0, 15.0), Some((care, "here they are 0.2"))),
        (Model::Mohammed2023, of(0.07, 500.0, 15.0), Some((care, "here they are 2.78"))),
        (Model::Mohammed2023, of(0.02, 500.0, 15.0), Some((refused, "6.07 building widths"))),
        (Model::Saboor2024, along(-180.0), none),
        (Model::Saboor2024, link("urban", 30.0), Some((care, "not a mean over azimuths"))),
        (Model::Saboor2024, along(90.0), Some((refused, "the azimuth is 90°"))),
        (Model::Tr36777UmaAv, at(300.0), none),
        (Model::Tr36777UmaAv, at(300.1), Some((refused, "wanted 1.5 m to 300 m"))),
        (Model::Tr36777UmaAv, street, Some((care, "base station"))),
        (Model::Tr38901Uma, at(23.0), none),
        (Model::Tr38901Uma, at(23.001), Some((refused, "wanted at most 23 m"))),
        (Model::Tr38901Rma, at(10.5), Some((care, "users at 1 to 10 m"))),
        (Model::Tr38901Umi, at(22.5), none),
        (Model::Tr38901Umi, at(100.0), Some((care, "users at 1.5 to 22.5 m"))),
        (Model::Tr38901Umi, street, Some((care, "made for a base station at 10 m"))),
        (Model::Tr38811, link("high-rise", 30.0), Some((refused, "high-rise"))),
        (Model::Tr38811Linear, link("ghent", 30.0), Some((refused, "none of the environments"))),
        // All reasons for care are given.
        (
            Model::Tr38811,
            roof,
            Some((
                care,
                "tabulated from 10°, the elevation angle is 5°; made for platforms from 8 km up, the UAV is at 100 m; made \
                 for receivers at street level, the receiver is at 12 m",
            )),
        ),
    ];
    for (model, link, told) in cases {
        let found = match model.p_los(&link) {
            Ok(value) => value.caution.map(|caution| (care, caution)),
            Err(outside) => Some((refused, outside.reason)),
        };
        let is_told = match (&found, told) {
            (None, None) => true,
            (Some((kind, text)), Some((wanted, part))) => *kind == wanted && text.contains(part),
            _ => false,
        };
        assert!(is_told, "{}: {found:?}, wanted {told:?}", model.id());
    }
}
