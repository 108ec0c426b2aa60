//! Settings of P_LoS: a city, a UAV, and the users that it is to see.

use skyshed_request::{Placement, Users};

use super::street_grid::{GridZone, StreetGrid};
use crate::city::BuiltUp;
use crate::error::{Error, LosProbabilityError, Result};
use crate::quantity::{MAX_EXTENT_UNITS, MAX_HEIGHT_M};

/// Returns the position in the period \[0, T\]² that two numbers in \[0, 1) stand for, uniform over the zone of a placement.
pub fn position_of(placement: Placement, grid: &StreetGrid, [u, v]: [f64; 2]) -> [f64; 2] {
    let (s, t) = (grid.street(), grid.period());
    let roof = |u: f64| s + (t - s) * u;
    match placement {
        Placement::Anywhere => [t * u, t * v],
        Placement::Street => [s * u, roof(v)],
        Placement::Crossroad => [s * u, s * v],
        Placement::Rooftop => [roof(u), roof(v)],
        Placement::StreetCenter => [0.5 * s, roof(0.5)],
        Placement::CrossroadCenter => [0.5 * s, 0.5 * s],
        Placement::RooftopCenter => [roof(0.5), roof(0.5)],
    }
}

/// Ground distance of the users from the UAV.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reach {
    /// All at one distance \[m\], seeing the UAV at one elevation angle \[deg\]: the circle of Saboor et al. 2023.
    Ring {
        /// Ground distance \[m\].
        distance_m: f64,
        /// Elevation angle \[deg\].
        theta_deg: f64,
    },
    /// Uniform over the area within a radius \[m\].
    Disc {
        /// Radius \[m\].
        radius_m: f64,
    },
}

impl Reach {
    /// The largest ground distance \[m\].
    pub fn farthest(self) -> f64 {
        match self {
            Reach::Ring { distance_m, .. } => distance_m,
            Reach::Disc { radius_m } => radius_m,
        }
    }
}

/// Setting of one P_LoS. Heights are above ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setting {
    /// The city.
    pub built_up: BuiltUp,
    /// Height of the UAV \[m\].
    pub uav_height_m: f64,
    /// Height of the users \[m\].
    pub rx_height_m: f64,
    /// Ground distance of the users.
    pub reach: Reach,
    /// Azimuth from user to UAV \[deg\], 0 across the user's street and 90 along it; `None`: averaged over all.
    ///
    /// For users on crossroads, and for all outdoor users together, it is the angle with one of the two axes.
    pub phi_deg: Option<f64>,
    /// Users that count.
    pub users: Users,
    /// Placement of the UAV.
    pub placement: Placement,
    /// Counts only UAVs outside buildings; otherwise one inside a building is NLoS for all.
    pub uav_clear_of_roof: bool,
}

impl Setting {
    /// Users who see the UAV at an elevation angle, 0 < θ ≤ 90°.
    ///
    /// # Errors
    /// Usage error (E120) for an angle, height or distance out of range.
    pub fn reach_at_elevation(theta_deg: f64, uav_height_m: f64, rx_height_m: f64) -> Result<Reach> {
        let rise = checked_rise(uav_height_m, rx_height_m)?;
        if !(theta_deg > 0.0 && theta_deg <= 90.0) {
            return Err(out_of_range("θ (elevation angle)", theta_deg, "0 < θ ≤ 90 [deg]"));
        }
        // tan 90° is not infinite in floating point, and users right below are at distance 0.
        let distance_m = if theta_deg >= 90.0 { 0.0 } else { rise / theta_deg.to_radians().tan() };
        checked_distance(distance_m, &format!("θ = {theta_deg} at a height of {uav_height_m} m"))?;
        Ok(Reach::Ring { distance_m, theta_deg })
    }

    /// Users at a ground distance \[m\] ≥ 0.
    pub fn reach_at_distance(distance_m: f64, uav_height_m: f64, rx_height_m: f64) -> Result<Reach> {
        let rise = checked_rise(uav_height_m, rx_height_m)?;
        if !(distance_m >= 0.0 && distance_m.is_finite()) {
            return Err(out_of_range("the distance", distance_m, "at least 0 m"));
        }
        checked_distance(distance_m, "the distance")?;
        Ok(Reach::Ring { distance_m, theta_deg: rise.atan2(distance_m).to_degrees() })
    }

    /// Users within a radius \[m\] > 0 on the ground.
    pub fn reach_within(radius_m: f64, uav_height_m: f64, rx_height_m: f64) -> Result<Reach> {
        checked_rise(uav_height_m, rx_height_m)?;
        if !(radius_m > 0.0 && radius_m.is_finite()) {
            return Err(out_of_range("the radius", radius_m, "above 0 m"));
        }
        checked_distance(radius_m, "the radius")?;
        Ok(Reach::Disc { radius_m })
    }

    /// The azimuth \[deg\], if it is one: 0 ≤ φ ≤ 90; the rest follows by symmetry.
    pub fn checked_phi(phi_deg: f64) -> Result<f64> {
        if (0.0..=90.0).contains(&phi_deg) {
            Ok(phi_deg)
        } else {
            Err(out_of_range("φ (azimuth)", phi_deg, "0 ≤ φ ≤ 90 [deg]; the grid repeats in the other quadrants"))
        }
    }

    /// Elevation angle \[deg\], if all users have the same.
    pub fn theta_deg(&self) -> Option<f64> {
        match self.reach {
            Reach::Ring { theta_deg, .. } => Some(theta_deg),
            Reach::Disc { .. } => None,
        }
    }

    /// Rise from a user to the UAV \[m\], > 0.
    pub fn rise(&self) -> f64 {
        self.uav_height_m - self.rx_height_m
    }

    /// A user at an offset from the UAV, chosen by numbers in \[0, 1): `azimuth` for the direction, `radius` for the distance.
    ///
    /// Returns the offset of the user \[m\], and which street a street user must be in for the azimuth to be φ.
    pub fn offset(&self, azimuth: f64, radius: f64) -> ([f64; 2], Option<GridZone>) {
        let r = match self.reach {
            Reach::Ring { distance_m, .. } => distance_m,
            Reach::Disc { radius_m } => radius_m * radius.sqrt(),
        };
        let Some(phi) = self.phi_deg else {
            let (sin, cos) = (azimuth * std::f64::consts::TAU).sin_cos();
            return ([r * cos, r * sin], None);
        };
        // φ is measured from across the street; its mirror images look the same, and a street along x turns it by 90°.
        let (along, across) = if phi >= 90.0 { (1.0, 0.0) } else { phi.to_radians().sin_cos() };
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "an octant, 0..8")]
        let octant = (azimuth * 8.0) as u8;
        let across = if octant & 1 == 0 { across } else { -across };
        let along = if octant & 2 == 0 { along } else { -along };
        if octant & 4 == 0 {
            ([r * across, r * along], Some(GridZone::StreetAlongY))
        } else {
            ([r * along, r * across], Some(GridZone::StreetAlongX))
        }
    }

    /// Returns `true` if a user in `zone` counts, given the street that [`Setting::offset`] chose.
    pub fn counts(&self, zone: GridZone, street: Option<GridZone>) -> bool {
        let is_street = matches!(zone, GridZone::StreetAlongX | GridZone::StreetAlongY);
        match self.users {
            Users::Outdoor => zone != GridZone::Building,
            Users::Street => is_street && street.is_none_or(|s| s == zone),
            Users::Crossroad => zone == GridZone::Crossroad,
        }
    }
}

fn out_of_range(what: &'static str, found: f64, wanted: &'static str) -> Error {
    LosProbabilityError::OutOfRange { what, found, wanted }.into()
}

fn checked_rise(uav_height_m: f64, rx_height_m: f64) -> Result<f64> {
    if !(rx_height_m >= 0.0 && rx_height_m.is_finite()) {
        return Err(out_of_range("the receivers' height", rx_height_m, "at least 0 m"));
    }
    if !(uav_height_m > rx_height_m && uav_height_m.is_finite()) {
        return Err(LosProbabilityError::BelowReceivers { uav_height_m, rx_height_m }.into());
    }
    if uav_height_m > MAX_HEIGHT_M {
        return Err(out_of_range("the UAV's height", uav_height_m, "at most 32768 m"));
    }
    Ok(uav_height_m - rx_height_m)
}

/// Links are at most half of the lattice's extent, so that a city around the UAV is on it.
fn checked_distance(distance_m: f64, cause: &str) -> Result<()> {
    const MOST_M: f64 = MAX_EXTENT_UNITS / 2.0;
    if distance_m > MOST_M {
        return Err(LosProbabilityError::TooFar { cause: cause.to_string(), distance_m, most_m: MOST_M }.into());
    }
    Ok(())
}
