//! P_LoS by the product over generated cities: settings of users and of the UAV, and their estimates.

use skyshed_core::city::BuiltUp;
use skyshed_request::{Placement, Users};
use skyshed_study::los_probability::estimate::Estimate;
use skyshed_study::los_probability::product::Product;
use skyshed_study::los_probability::setting::Setting;

/// Height of receivers of a map, above the ground \[m\].
const RX_HEIGHT_M: f64 = 1.5;

/// A built-up city by its name.
pub(crate) fn built_up(name: &str) -> BuiltUp {
    BuiltUp::named(name).unwrap()
}

/// Outdoor users on the ground at an elevation angle of a UAV that may be anywhere at its height.
pub(crate) fn at_height(city: &str, theta_deg: f64, uav_height_m: f64) -> Setting {
    Setting {
        built_up: built_up(city),
        uav_height_m,
        rx_height_m: 0.0,
        reach: Setting::reach_at_elevation(theta_deg, uav_height_m, 0.0).unwrap(),
        phi_deg: None,
        users: Users::Outdoor,
        placement: Placement::Anywhere,
        uav_clear_of_roof: false,
    }
}

/// Outdoor users at the height of maps within a radius of a UAV over a place, in the clear.
pub(crate) fn within(city: &str, radius_m: f64, uav_height_m: f64, placement: Placement) -> Setting {
    Setting {
        rx_height_m: RX_HEIGHT_M,
        reach: Setting::reach_within(radius_m, uav_height_m, RX_HEIGHT_M).unwrap(),
        placement,
        uav_clear_of_roof: true,
        ..at_height(city, 90.0, uav_height_m)
    }
}

/// The estimate of so many points, with its 95 % interval.
pub(crate) fn product(setting: &Setting, points: u64) -> Estimate {
    let mut product = Product::new(*setting, 7);
    product.add_points(points);
    product.estimate(0.95)
}
