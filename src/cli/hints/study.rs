//! Remedies for the errors of P_LoS and of comparisons.

use skyshed_study::Error;
use skyshed_study::error::{ChartError, LosProbabilityError, StressError};

/// The remedy for an error, where one is known.
pub(in crate::cli) fn hint(error: &Error) -> Option<String> {
    let hint = match error {
        Error::Core(error) => return super::core::hint(error),
        Error::LosProbability(LosProbabilityError::CityTooLarge { .. }) => {
            "`--method geometry` or `--method product` draw no whole city; or choose larger angles"
        }
        Error::Chart(ChartError::Method { instead, .. }) => return Some(format!("`--method {instead}` can")),
        Error::Stress(StressError::ExactIsWrong { .. }) => "this is a fault of skyshed: please report it",
        _ => return None,
    };
    Some(hint.to_string())
}
