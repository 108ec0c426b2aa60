//! Faults of footprints as warnings, one for each kind.

use super::footprint_options::{FootprintOptions, MissingHeight};
use crate::city::{FootprintFault, FootprintFaults};
use crate::error::Warning;
use crate::input::Input;
use crate::quantity::counted;

/// How heights were looked for, in words.
pub(super) struct HeightWords {
    /// The property that holds them.
    pub(super) property: String,
    /// What is done without one.
    pub(super) treated: String,
    drops: bool,
}

impl HeightWords {
    pub(super) fn of(options: &FootprintOptions) -> HeightWords {
        let treated = match options.missing {
            MissingHeight::Fail => "refused".to_string(),
            MissingHeight::Few | MissingHeight::Drop => "left out".to_string(),
            MissingHeight::Levels => {
                format!("3 m for each of `{}` and `roof:levels`, left out without that", options.levels_field)
            }
            MissingHeight::Median => "given the median height".to_string(),
        };
        let drops = matches!(options.missing, MissingHeight::Few | MissingHeight::Drop);
        HeightWords { property: options.height_property().to_string(), treated, drops }
    }
}

/// Warns of each kind of fault, with how many there are and what was done.
pub(super) fn warn_of_faults(
    faults: &FootprintFaults,
    input: &Input,
    words: &HeightWords,
    missing_area_share: f64,
    warnings: &mut Vec<Warning>,
) {
    let share =
        format!("left out, {:.1} % of the footprint area (`--missing levels|median|fail`)", missing_area_share * 100.0);
    let treated = if words.drops { share.as_str() } else { words.treated.as_str() };
    for fault in FootprintFault::ALL.into_iter().filter(|fault| faults.of(*fault) > 0) {
        let done = if fault == FootprintFault::MissingHeight { treated } else { fault.done() };
        let [one, many] = fault.names();
        let what = counted(faults.of(fault) as u64, one, many);
        warnings.push(Warning::new(fault.code(), format!("{}: {what}: {done}", input)));
    }
}
