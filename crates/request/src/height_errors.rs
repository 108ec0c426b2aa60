//! Errors of building heights.

use crate::part::part;

part! {
    /// Standard deviations of the errors of building heights.
    pub struct HeightErrors, SetHeightErrors {
        /// Standard deviation of the error of each building's height [m]; default 0
        ///
        /// Airborne laser scans: 0.3 to 1; three meters to a level: 2; heights of global products: 4. P_LoS has an interval then, of 200 maps with
        /// heights redrawn.
        #[arg(long, value_name = "M", value_parser = crate::words::number, allow_hyphen_values = true, hide_short_help = true)]
        height_error: Option<f64>,
        /// Standard deviation of an error that all heights of buildings share [m]; default 0
        #[arg(long, value_name = "M", value_parser = crate::words::number, allow_hyphen_values = true, hide_short_help = true)]
        height_bias: Option<f64>,
    }
}
