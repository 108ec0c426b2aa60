//! Faults of footprints as warnings, one for each kind.

use std::collections::HashMap;

use super::file_heights::FileHeights;
use super::footprint_options::FootprintOptions;
use crate::city::{FootprintFault, FootprintFaults, HeightSource};
use crate::error::{OddFile, Warning};
use crate::input::Input;

/// Content of warnings beside the numbers of faults.
pub(super) struct Said<'a> {
    pub(super) heights: &'a FileHeights,
    /// Area of outlines beside their parts that is as high as the lowest part \[m²\].
    pub(super) rest_area_m2: f64,
    /// Shares, by fault, of left-out footprints in the area of all that have a height.
    pub(super) left_out: &'a HashMap<FootprintFault, f64>,
}

/// Warns of each kind of fault, with its number and its treatment.
pub(super) fn warn_of_faults(
    faults: &FootprintFaults,
    input: &Input,
    options: &FootprintOptions,
    said: &Said<'_>,
    warnings: &mut Vec<Warning>,
) {
    /// Largest share of the area that a warning leaves out.
    const TOLD: f64 = 0.02;
    let sources = &said.heights.sources;
    let missing = sources.missing();
    for fault in FootprintFault::ALL {
        let n = if fault == FootprintFault::MissingHeight { missing.n } else { faults.of(fault) };
        let odd = match fault {
            _ if n == 0 => continue,
            FootprintFault::MissingHeight => {
                let asks_nothing = options.missing.rules().is_empty() && sources.from(HeightSource::Nowhere).n > 0;
                OddFile::MissingHeights { n, treated: sources.treated(), asks_nothing }
            }
            FootprintFault::Part if said.rest_area_m2 > 0.0 => OddFile::Rests { n, area_m2: said.rest_area_m2 },
            _ => match said.left_out.get(&fault) {
                Some(area_share) if *area_share > TOLD => OddFile::LeftOut { fault, n, area_share: *area_share },
                _ => OddFile::Fault(fault, n),
            },
        };
        warnings.push(Warning::of(input, odd));
    }
}
