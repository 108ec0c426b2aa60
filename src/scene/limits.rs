//! Limits of the accuracy of a map, in warnings and captions: the curve of the earth, unknown
//! ground, missing heights.

use crate::city::HeightSources;
use crate::error::{OddRun, Warning, WarningRepr};
use crate::height_field::HeightField;
use crate::quantity::{counted, fixed, tidy};
use crate::render::percent;
use skyshed_io::Warning as OddFiles;
use skyshed_io::error::{OddFile, OddRaster, Oddity};

/// Returns the limits of the accuracy of a picture, in words.
pub(crate) fn limits_in_words(
    heights: Option<&HeightSources>,
    field: &HeightField,
    warnings: &[Warning],
) -> Option<String> {
    let mut limits: Vec<String> = Vec::new();
    if let Some(heights) = heights.filter(|heights| heights.missing().n > 0) {
        let share = 100.0 * heights.missing().area_share;
        limits.push(format!("{} % of the footprint area has no height: {}", fixed(share, 1), heights.treated()));
    }
    let of_files = warnings.iter().filter_map(|warning| match warning.repr() {
        WarningRepr::Io(OddFiles::File(_, odd)) => Some(odd),
        _ => None,
    });
    limits.extend(of_files.filter_map(|odd| match odd {
        OddFile::GroundOfBases { ground_m, .. } => {
            Some(format!("flat ground at {} m, the median of where buildings begin", tidy(*ground_m)))
        }
        OddFile::LeftOut { fault, n, area_share } => {
            let [one, many] = fault.names();
            let share = fixed(100.0 * area_share, 1);
            Some(format!("{} left out, {share} % of the area with a height", counted(*n as u64, one, many)))
        }
        OddFile::OtherGround { ground_m, range_m, .. } => Some(format!(
            "flat ground at {} m, where buildings begin at {} to {} m",
            tidy(*ground_m),
            tidy(range_m.0),
            tidy(range_m.1)
        )),
        OddFile::Rests { n, .. } => Some(format!(
            "outlines beside parts of {} are as high as the lowest part",
            counted(*n as u64, "building", "buildings")
        )),
        _ => None,
    }));
    let stretched = warnings.iter().find_map(|warning| match warning.repr() {
        WarningRepr::Io(OddFiles::Raster(Oddity { odd: OddRaster::WebMercator { largest_error, .. }, .. })) => {
            Some(*largest_error)
        }
        _ => None,
    });
    limits.extend(stretched.map(|off| format!("web Mercator: lengths are off by up to {} %", fixed(100.0 * off, 2))));
    if let Some(outside) = field.outside_data() {
        let share = percent(outside.count(), field.grid().n_cells() as u64);
        limits.push(format!("no data beyond the footprints ({share} of the extent)"));
    }
    if field.is_surface_only() {
        limits.push("a surface model alone: receivers stand on roofs and trees too".into());
    }
    if warnings.iter().any(|warning| matches!(warning.repr(), WarningRepr::Run(OddRun::FlatEarth { .. }))) {
        limits.push("the earth is taken as flat".into());
    }
    (!limits.is_empty()).then(|| crate::words::title_of(&limits.join("; ")))
}
