//! `--height-error`, `--height-bias`.

use clap::Args;

use super::words::number;
use crate::cli::failure::Result;
use crate::height_errors::AskedErrors;

/// How far heights of buildings may be off.
#[derive(Debug, Clone, Args)]
pub(crate) struct HeightErrorArgs {
    /// Standard deviation of the error of each building's height [m]; default 0
    ///
    /// Airborne laser scans: 0.3 to 1; three meters to a level: 2; heights of global products: 4. P_LoS has an interval then, of 200 maps with
    /// heights redrawn.
    #[arg(long, value_name = "M", value_parser = number, allow_hyphen_values = true, hide_short_help = true)]
    height_error: Option<f64>,
    /// Standard deviation of an error that all heights of buildings share [m]; default 0
    #[arg(long, value_name = "M", value_parser = number, allow_hyphen_values = true, hide_short_help = true)]
    height_bias: Option<f64>,
}

impl HeightErrorArgs {
    /// As the library takes it, with a number of standard deviations if one was given; numbers out of range are refused.
    pub(crate) fn checked(&self, sigma: Option<f64>) -> Result<AskedErrors> {
        let HeightErrorArgs { height_error, height_bias } = *self;
        let none = AskedErrors::default();
        let asked = AskedErrors {
            own_m: height_error.unwrap_or(none.own_m),
            shared_m: height_bias.unwrap_or(none.shared_m),
            sigma: sigma.unwrap_or(none.sigma),
            ..none
        };
        Ok(asked.checked()?)
    }
}
