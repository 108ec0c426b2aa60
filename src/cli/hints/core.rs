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
            "`itu:suburban`, `itu:urban`, `itu:dense-urban`, `itu:high-rise`, `itu:ghent`, or for example `itu:0.3,500,15`"
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
            return Some(format!("`--method auto` takes `{instead}` here; `--method ray` decides any scene"));
        }
        MapError::ApproximateLayers { .. } => "`--method auto`, or `--layers los` alone",
        MapError::CurvedSlopes => "`--roofs flat`, or a flat earth",
        MapError::Tangled { .. } => "mend or leave out the buildings that cross one another",
        MapError::TooCurved(_) => "a larger `--earth-k`, or a smaller `--radius`",
        MapError::StreamedMethod => "`--method auto` takes `sweep` here",
        MapError::StreamedLayers => "`--layers los,margin,ceiling`, and receivers in no zone",
        _ => return None,
    };
    Some(hint.to_string())
}

fn of_uav((x, y): (f64, f64), height: Height, error: &UavError) -> Option<String> {
    let asked = short(height.value());
    Some(match *error {
        UavError::InsideBuilding { roof_m, ground_m, .. } => {
            let lowest = format!("the lowest height in the clear is {}", in_words(roof_m, ground_m));
            // What was asked above the ground may have been meant above the roof.
            match height {
                Height::AboveGround(_) if asked > 0.0 => {
                    let amsl = tidy(roof_m + asked);
                    lowest + &format!("; `{asked}roof` hovers at {amsl} m above the datum, {asked} m above the roof")
                }
                _ => lowest,
            }
        }
        UavError::BelowGround { surface_m, ground_m, .. } => format!(
            "the lowest height in the clear is {}; heights are above ground unless written `150amsl` or `30roof`",
            in_words(surface_m, ground_m)
        ),
        UavError::TooFar { x_range, y_range, has_crs, .. } => {
            let is_in = |v: f64, range: (f64, f64)| (range.0..=range.1).contains(&v);
            if is_in(y, x_range) && is_in(x, y_range) {
                format!("x and y are swapped: `{y},{x}` lies in the grid")
            } else if x.abs() <= 180.0 && y.abs() <= 90.0 && has_crs {
                "this looks like longitude and latitude: give it as a table with the columns `lon,lat,h` to `--uavs FILE`"
                    .to_string()
            } else {
                "check the coordinate reference system of the site, or limit the range with `--radius M`".to_string()
            }
        }
        UavError::NoGround => format!("give the height above the datum: `{asked}amsl`"),
        UavError::NoRoofKnown => {
            let asked = asked.max(0.0);
            format!("give `--terrain FILE` or `--ground Z`, or a height above the surface: `{asked}agl`")
        }
        UavError::NoBuilding => format!("above the ground it is `{}agl`", asked.max(0.0)),
        UavError::OverNodata => "`--nodata-as clear` lets nodata cells block nothing".to_string(),
        _ => return None,
    })
}

/// The remedy for a receiver that cannot be where it was asked to be.
pub(super) fn of_receiver(height: Height, error: &UavError) -> Option<String> {
    let asked = short(height.value());
    match error {
        UavError::InsideBuilding { .. } => Some(format!("on the roof it is `{}roof`", asked.max(0.0))),
        UavError::BelowGround { surface_m, ground_m, .. } => {
            Some(format!("the lowest height above the ground is {}", in_words(*surface_m, *ground_m)))
        }
        UavError::NoGround => Some(format!("give the height above the datum: `{asked}amsl`")),
        UavError::NoBuilding => Some(format!("above the ground it is `{}agl`", asked.max(0.0))),
        _ => None,
    }
}

/// A height to ask for instead \[m above the datum\], above the ground where that is known; it is in the clear.
fn in_words(lowest_m: f64, ground_m: Option<f64>) -> String {
    match ground_m {
        None => format!("`{}amsl`", short(lowest_m)),
        Some(ground_m) => format!("`{}agl`", short(lowest_m - ground_m)),
    }
}

/// A height as a reader types it \[m\]: rounded up to a decimeter, never −0.
fn short(height_m: f64) -> f64 {
    (height_m * 10.0).ceil() / 10.0 + 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_are_short_and_never_lower() {
        for (height_m, wanted) in [
            (80.588_235_294_117_65, "80.6"),
            (10.0, "10"),
            (0.0, "0"),
            (-0.04, "0"),
            (-3.27, "-3.2"),
            (60.96, "61"),
            (0.300_781_25, "0.4"),
        ] {
            assert_eq!(short(height_m).to_string(), wanted);
            assert!(short(height_m) >= height_m);
        }
        assert_eq!(in_words(533.412, Some(520.0)), "`13.5agl`");
        assert_eq!(in_words(533.412, None), "`533.5amsl`");
    }
}
