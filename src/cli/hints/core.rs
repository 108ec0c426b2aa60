//! Remedies for the errors of scenes, UAVs and maps.

use skyshed_core::Error;
use skyshed_core::error::{CityError, MapError, UavAttempt, UavError};

use crate::quantity::{Height, tidy};

/// The remedy for an error, where one is known.
pub(in crate::cli) fn hint(error: &Error) -> Option<String> {
    match error.innermost() {
        Error::City(error) => of_city(error),
        Error::Uav { attempt: UavAttempt::Place { x, y, height, .. }, why } => of_uav((*x, *y), *height, why),
        Error::Map(error) => of_map(error),
        _ => None,
    }
}

fn of_city(error: &CityError) -> Option<String> {
    let hint = match error {
        CityError::Word { .. } => {
            "itu:suburban, itu:urban, itu:dense-urban, itu:high-rise, itu:ghent, or for example itu:0.3,500,15"
        }
        CityError::Cells { .. } => "choose a larger `--cell`",
        CityError::Buildings { .. } => "choose a smaller `--size`, or a smaller β",
        _ => return None,
    };
    Some(hint.to_string())
}

fn of_map(error: &MapError) -> Option<String> {
    let hint = match error {
        MapError::Method { instead, .. } => {
            return Some(format!("`--method auto` takes `{instead}` here; `ray` decides any scene"));
        }
        MapError::ApproximateLayers { .. } => "`--method auto`, or `--layers los` alone",
        MapError::CurvedSlopes => "`--roofs flat`, or a flat earth",
        MapError::TooCurved(_) => "a larger `--earth-k`, or a smaller `--radius`",
        MapError::StreamedMethod => "`--method auto` takes `sweep` here",
        MapError::StreamedLayers => "`--layers los,margin,ceiling`, and receivers in no zone",
        _ => return None,
    };
    Some(hint.to_string())
}

fn of_uav((x, y): (f64, f64), height: Height, error: &UavError) -> Option<String> {
    let asked = height.value();
    Some(match *error {
        UavError::InsideBuilding { roof_m, ground_m, .. } => {
            let lowest = format!("the lowest height in the clear is {}", in_words(roof_m, ground_m));
            if asked > 0.0 {
                lowest + &format!("; `{asked}roof` hovers at {} m, {asked} m above the roof", tidy(roof_m + asked))
            } else {
                lowest
            }
        }
        UavError::BelowGround { surface_m, ground_m, .. } => format!(
            "the lowest height in the clear is {}; heights are above ground unless written `150amsl` or `30roof`",
            in_words(surface_m, ground_m)
        ),
        UavError::TooFar { x_range, y_range, has_crs, .. } => {
            let is_in = |v: f64, range: (f64, f64)| (range.0..=range.1).contains(&v);
            if is_in(y, x_range) && is_in(x, y_range) {
                "x and y are swapped: exchanged, the position lies in the grid".to_string()
            } else if x.abs() <= 180.0 && y.abs() <= 90.0 && has_crs {
                "this looks like longitude and latitude: give it as a table with the columns `lon,lat,h` to `--uavs`"
                    .to_string()
            } else {
                "check the coordinate reference system of the site, or limit the range with `--radius M`".to_string()
            }
        }
        UavError::NoGround => format!("give the height above the datum: `{asked}amsl`"),
        UavError::NoRoofKnown => {
            "give `--terrain FILE` or `--ground Z`, or a height above the surface (`agl`)".to_string()
        }
        UavError::NoBuilding => format!("above the ground it is `{asked}agl`"),
        UavError::OverNodata => "`--nodata-as clear` lets nodata cells block nothing".to_string(),
        _ => return None,
    })
}

/// The remedy for a receiver that cannot be where it was asked to be.
pub(super) fn of_receiver(height: Height, error: &UavError) -> Option<String> {
    match error {
        UavError::InsideBuilding { .. } => Some(format!("on the roof it is `{}roof`", height.value().max(0.0))),
        UavError::NoGround => Some(format!("give the height above the datum: `{}amsl`", height.value())),
        _ => None,
    }
}

/// A height to ask for instead \[m above the datum\], above the ground where that is known: rounded up to a centimeter, so
/// that it is in the clear.
fn in_words(lowest_m: f64, ground_m: Option<f64>) -> String {
    let centimeters = |m: f64| (m * 100.0).ceil() / 100.0;
    match ground_m {
        None => format!("`{}amsl`", centimeters(lowest_m)),
        Some(ground_m) => format!("`{}agl`", centimeters(lowest_m - ground_m)),
    }
}
