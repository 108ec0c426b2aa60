//! Faults of footprints as warnings, one for each kind.

use super::footprint_options::{FootprintOptions, MissingHeight};
use crate::city::{FootprintFault, FootprintFaults};
use crate::error::{OddFile, Warning};
use crate::input::Input;

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
    for fault in FootprintFault::ALL.into_iter().filter(|fault| faults.of(*fault) > 0) {
        let (n, left_out) = (faults.of(fault), words.drops.then_some(missing_area_share));
        let odd = match fault {
            FootprintFault::MissingHeight => OddFile::MissingHeights { n, treated: words.treated.clone(), left_out },
            _ => OddFile::Fault(fault, n),
        };
        warnings.push(Warning::of(input, odd));
    }
}
