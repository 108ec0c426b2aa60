//! What was mended or left out while reading footprints, counted and told.

use std::path::Path;

use super::footprints::{FootprintOptions, MissingHeight};
use crate::error::Warning;
use crate::quantity::counted;

/// What was mended or left out while reading footprints.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FootprintFaults {
    /// Features that are not areas (points, lines, no geometry): left out.
    pub not_areas: usize,
    /// Polygons whose rings crossed or touched themselves: repaired by the even-odd rule.
    pub repaired: usize,
    /// Rings whose last point was not the first: closed.
    pub unclosed: usize,
    /// Polygons without area: left out.
    pub degenerate: usize,
    /// Footprints without a usable height: treated by the [`MissingHeight`] policy.
    pub missing_height: usize,
    /// Of these, the footprints whose height is that of their storeys.
    pub from_levels: usize,
    /// Footprints with a negative height: left out.
    pub negative_height: usize,
    /// Heights written with a decimal comma: read as such.
    pub decimal_comma: usize,
    /// Footprints over terrain cells that are all nodata: left out.
    pub no_ground: usize,
    /// Footprints farther than 65 536 m from the grid's corner: left out.
    pub too_far: usize,
    /// Areas that are `building=no` or `building=demolished`: left out.
    pub not_buildings: usize,
    /// Footprints that begin above the ground (`min_height`, `building:min_level`): taken as solid from the ground up.
    pub floating: usize,
    /// Parts of buildings (`building:part`): joined with their outlines, the highest counts.
    pub parts: usize,
}

/// How heights were looked for, in words.
pub(super) struct HeightWords {
    /// The property that holds them.
    pub(super) property: String,
    /// What is done without one.
    treated: String,
    drops: bool,
    /// Names of other properties, where no feature has the one.
    other_names: Vec<String>,
}

impl HeightWords {
    pub(super) fn of(options: &FootprintOptions, other_names: Vec<String>) -> HeightWords {
        let treated = match options.missing {
            MissingHeight::Fail => "refused".to_string(),
            MissingHeight::Drop => "left out".to_string(),
            MissingHeight::Levels => {
                format!("3 m for each of `{}` and `roof:levels`, left out without that", options.levels_field)
            }
            MissingHeight::Median => "given the median height".to_string(),
        };
        let named = options.top_field.as_ref().or(options.height_field.as_ref());
        HeightWords {
            property: named.cloned().unwrap_or_else(|| "height".into()),
            treated,
            drops: options.missing == MissingHeight::Drop,
            other_names,
        }
    }
}

/// A kind of fault: the code of its warning, how many there are, what one and many are called, what was done.
type Kind<'a> = (u16, usize, [&'a str; 2], &'a str);

impl FootprintFaults {
    pub(super) fn warn(&self, path: &Path, words: &HeightWords, missing_area_share: f64, warnings: &mut Vec<Warning>) {
        let share = format!(
            "left out, {:.1} % of the footprint area (`--missing levels|median|fail`)",
            missing_area_share * 100.0
        );
        let treated = if words.drops { share.as_str() } else { words.treated.as_str() };
        for (code, count, [one, many], done) in self.of_shapes().into_iter().chain(self.of_heights(treated)) {
            if count > 0 {
                let what = counted(count as u64, one, many);
                warnings.push(Warning::new(code, format!("{}: {what}: {done}", path.display())));
            }
        }
        if self.missing_height > 0 && !words.other_names.is_empty() {
            let names: Vec<String> = words.other_names.iter().map(|name| format!("`{name}`")).collect();
            let text = format!(
                "{}: no feature has the property `{}`; there are {} (`--height-field NAME`)",
                path.display(),
                words.property,
                names.join(", ")
            );
            warnings.push(Warning::new(365, text));
        }
    }

    fn of_shapes(&self) -> [Kind<'static>; 7] {
        [
            (350, self.not_areas, ["feature that is no polygon", "features that are no polygons"], "left out"),
            (
                351,
                self.repaired,
                ["polygon with crossing or touching rings", "polygons with crossing or touching rings"],
                "repaired by the even-odd rule",
            ),
            (
                352,
                self.unclosed,
                ["ring that does not end where it begins", "rings that do not end where they begin"],
                "closed",
            ),
            (353, self.degenerate, ["polygon without area", "polygons without area"], "left out"),
            (357, self.no_ground, ["footprint over nodata terrain", "footprints over nodata terrain"], "left out"),
            (
                358,
                self.too_far,
                ["footprint farther than 65536 m from the grid", "footprints farther than 65536 m from the grid"],
                "left out",
            ),
            (
                361,
                self.not_buildings,
                ["area that is `building=no` or `demolished`", "areas that are `building=no` or `demolished`"],
                "left out",
            ),
        ]
    }

    fn of_heights<'a>(&self, treated: &'a str) -> [Kind<'a>; 6] {
        [
            (
                354,
                self.missing_height,
                ["footprint without a usable height", "footprints without a usable height"],
                treated,
            ),
            (
                355,
                self.negative_height,
                ["footprint with a negative height", "footprints with a negative height"],
                "left out",
            ),
            (
                356,
                self.decimal_comma,
                ["height with a decimal comma", "heights with a decimal comma"],
                "the comma is read as a point",
            ),
            (
                362,
                self.floating,
                ["footprint that begins above the ground", "footprints that begin above the ground"],
                "taken as solid from the ground up",
            ),
            (
                363,
                self.parts,
                ["part of a building", "parts of buildings"],
                "joined with their outlines, the highest of what overlaps counts",
            ),
            (
                364,
                self.from_levels,
                ["height from a number of storeys", "heights from numbers of storeys"],
                "3 m for each",
            ),
        ]
    }
}
