//! What a feature says of a building: whether it is one, how high it is and in which unit.
//!
//! Names and meanings are those of OpenStreetMap, which most tables of buildings borrow: `height` above the ground,
//! `building:levels` without the storeys under the roof, which `roof:levels` counts; `min_height` where a part begins
//! above the ground; `building:part` for parts of different heights inside an outline. A prism here is solid from the
//! ground up, and what overlaps is as high as the highest of it: a part that floats is taken as solid, and an outline
//! counts beside its parts. Both are counted.

use super::footprint_options::Roofs;
use super::footprint_options::{FootprintOptions, HEIGHT, HeightUnit, METERS_PER_FOOT, MissingHeight};
use super::repairs::{Culprit, FaultLog};
use super::solid::{Face, plan};
use super::vector::{Feature, FeatureSet, Polygon, Property, bounds, opened};
use crate::city::FootprintFault;
use crate::error::{Error, Place, ReadFault, Result, Wanted};
use crate::input::Input;

/// Meters that stand for one storey where only their number is known (the default of OpenStreetMap renderers).
pub const METERS_PER_LEVEL: f64 = 3.0;

/// The areas of a file with what is known of their heights.
#[derive(Debug, Default)]
pub(super) struct Buildings {
    pub(super) footprints: Vec<RawFootprint>,
}

/// One feature with areas.
#[derive(Debug, Clone)]
pub(super) struct RawFootprint {
    /// Number of the feature in the file, from 1.
    pub(super) number: usize,
    pub(super) id: String,
    /// Polygons of rings of positions, last point dropped if it repeats the first.
    pub(super) polygons: Vec<Polygon>,
    pub(super) unclosed: usize,
    pub(super) height: FoundHeight,
    /// Whether the height is that of the top above the datum.
    pub(super) above_datum: bool,
    /// Storeys, those under the roof included.
    pub(super) levels: Option<f64>,
    /// Standard deviation of the error of the height \[m\].
    pub(super) height_error_m: Option<f64>,
    /// Whether it begins above the ground.
    pub(super) floats: bool,
    /// Lowest point of a solid \[m above the datum\].
    pub(super) lowest: Option<f64>,
    /// The surfaces of its roof, if that is taken as it is.
    pub(super) roof: Vec<Face>,
    /// What it covers of the ground then, where that is known.
    pub(super) ground: Vec<Polygon>,
    /// Whether it was to be taken so, but has no surface of a roof.
    pub(super) lacks_roof: bool,
}

impl RawFootprint {
    /// What a fault of it is of.
    pub(super) fn culprit(&self) -> Culprit<'_> {
        self.culprit_at(0)
    }

    /// What a fault of one of its polygons is of, with the first point of that.
    pub(super) fn culprit_at(&self, k: usize) -> Culprit<'_> {
        let first = self.polygons.get(k).and_then(|rings| rings.iter().flatten().next());
        Culprit { feature: self.number, id: &self.id, place: first.copied() }
    }
}

/// What a height property held.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum FoundHeight {
    Meters(f64),
    DecimalComma(f64),
    Missing,
}

impl Buildings {
    /// The buildings among the features of a file; what is none, and what is a part of one, is noted.
    pub(super) fn of(
        input: &Input,
        set: FeatureSet,
        options: &FootprintOptions,
        log: &mut FaultLog,
    ) -> Result<Buildings> {
        if options.roofs == Some(Roofs::Lod2) && set.features.iter().all(|feature| feature.roof.is_empty()) {
            return Err(Error::read(input, ReadFault::Nothing(Wanted::Roofs)));
        }
        refuse_unknown_property(input, &set, options)?;
        let mut buildings = Buildings::default();
        for (index, feature) in set.features.into_iter().enumerate() {
            let number = index + 1;
            let says = Says { feature: &feature, name_limit: set.name_limit, options };
            if feature.polygons.is_empty() {
                log.note(FootprintFault::NotAnArea, Culprit { feature: number, id: &says.id(number), place: None });
                continue;
            }
            let bad = feature.polygons.iter().flatten().flatten().flatten().find(|v| !v.is_finite());
            if let Some(bad) = bad {
                let what = format!("found coordinate `{bad}`, wanted a number");
                return Err(Error::malformed(input, what).at(Place::Feature(number as u64)));
            }
            let footprint = says.footprint(number);
            if feature.has_other_parts {
                log.note(FootprintFault::NotAnArea, footprint.culprit());
            }
            if says.is_no_building() {
                log.note(FootprintFault::NotABuilding, footprint.culprit());
                continue;
            }
            if says.is_part() {
                log.note(FootprintFault::Part, footprint.culprit());
            }
            buildings.footprints.push(footprint);
        }
        Ok(buildings)
    }

    /// Forgets those that do not meet a box: west, south, east, north \[CRS units\].
    pub(super) fn keep_within(&mut self, [west, south, east, north]: [f64; 4]) {
        self.footprints.retain(|footprint| {
            bounds(footprint.polygons.iter())
                .is_some_and(|[w, s, e, n]| w <= east && e >= west && s <= north && n >= south)
        });
    }

    /// West, south, east, north of all positions; `None` if there is none.
    pub(super) fn bounds(&self) -> Option<[f64; 4]> {
        bounds(self.footprints.iter().flat_map(|f| &f.polygons))
    }
}

/// Refuses a file of areas of which none has the property that heights are read from, unless storeys stand in for a
/// property that nobody named.
fn refuse_unknown_property(input: &Input, set: &FeatureSet, options: &FootprintOptions) -> Result<()> {
    let name = options.height_property();
    let areas = || set.features.iter().filter(|feature| !feature.polygons.is_empty());
    let has = |name: &str| areas().any(|feature| feature.property(name, set.name_limit).is_some());
    let is_named = options.top_field.is_some() || options.height_field.is_some();
    let by_storeys = options.missing == MissingHeight::Levels && !is_named && has(&options.levels_field);
    let by_itself = !is_named && areas().any(|feature| feature.heights.is_some());
    if let Some(name) = options.height_error_field.as_deref().filter(|name| areas().next().is_some() && !has(name)) {
        return Err(Error::read(input, ReadFault::NoErrorProperty(name.to_string())));
    }
    if areas().next().is_none() || has(name) || by_storeys || by_itself {
        return Ok(());
    }
    const MOST: usize = 12;
    let mut like_heights: Vec<&str> = Vec::new();
    let mut like_storeys: Vec<&str> = Vec::new();
    let mut others: Vec<&str> = Vec::new();
    for (name, value) in areas().take(100).flat_map(|feature| &feature.properties) {
        let list = match likeness(name, value) {
            Some(Likeness::Height) => &mut like_heights,
            Some(Likeness::Storeys) => &mut like_storeys,
            None => &mut others,
        };
        if list.len() < MOST && !list.contains(&&**name) {
            list.push(name);
        }
    }
    let [like_heights, like_storeys, others] =
        [like_heights, like_storeys, others].map(|names| names.into_iter().map(str::to_string).collect());
    let wanted = name.to_string();
    Err(Error::read(input, ReadFault::NoHeightProperty { wanted, like_heights, like_storeys, others }))
}

/// What a property may hold by its name.
enum Likeness {
    Height,
    Storeys,
}

/// Whether a property may hold the height of a building, or the number of its storeys.
fn likeness(name: &str, value: &Property) -> Option<Likeness> {
    const HEIGHTS: [&str; 10] =
        ["height", "heigth", "hgt", "hoehe", "höhe", "haut", "altura", "altezza", "hoogte", "z_"];
    const WHOLE: [&str; 5] = ["h", "z", "top", "roof", "elev"];
    const STOREYS: [&str; 4] = ["level", "storey", "stories", "floors"];
    let name = name.to_lowercase();
    let has = |words: &[&str]| words.iter().any(|word| name.contains(word));
    let likeness = if has(&STOREYS) {
        Likeness::Storeys
    } else if has(&HEIGHTS) || WHOLE.contains(&name.as_str()) {
        Likeness::Height
    } else {
        return None;
    };
    (!matches!(found_height(value, HeightUnit::Meters), FoundHeight::Missing)).then_some(likeness)
}

/// A feature and how it is read.
struct Says<'a> {
    feature: &'a Feature,
    name_limit: Option<usize>,
    options: &'a FootprintOptions,
}

impl Says<'_> {
    fn property(&self, name: &str) -> Option<&Property> {
        self.feature.property(name, self.name_limit)
    }

    fn word(&self, name: &str) -> Option<String> {
        self.property(name).and_then(Property::text).map(|text| text.trim().to_lowercase())
    }

    fn is_no_building(&self) -> bool {
        self.word("building").is_some_and(|word| word == "no" || word == "demolished")
    }

    fn is_part(&self) -> bool {
        self.word("building:part").is_some_and(|word| word != "no" && !word.is_empty())
    }

    /// Whether a number other than zero is given.
    fn is_above_zero(&self, name: &str) -> bool {
        let found = self.property(name).map(|value| found_height(value, HeightUnit::Meters));
        matches!(found, Some(FoundHeight::Meters(v) | FoundHeight::DecimalComma(v)) if v > 0.0)
    }

    fn levels(&self) -> Option<f64> {
        let number = |name: &str| match found_height(self.property(name)?, HeightUnit::Meters) {
            FoundHeight::Meters(n) | FoundHeight::DecimalComma(n) => Some(n),
            FoundHeight::Missing => None,
        };
        let levels = number(&self.options.levels_field).filter(|n| *n > 0.0)?;
        Some(levels + number("roof:levels").filter(|n| *n > 0.0).unwrap_or(0.0))
    }

    /// The standard deviation of the error of the height \[m\], if it is told.
    fn height_error_m(&self) -> Option<f64> {
        let value = self.property(self.options.height_error_field.as_deref()?)?;
        match found_height(value, self.options.height_unit) {
            FoundHeight::Meters(m) | FoundHeight::DecimalComma(m) => Some(m),
            FoundHeight::Missing => None,
        }
    }

    /// The height, and whether it is above the datum: from the property that is named, else from the solid itself, else
    /// from `height`.
    fn height(&self) -> (FoundHeight, bool) {
        let options = self.options;
        let of = |name: &str| {
            self.property(name).map_or(FoundHeight::Missing, |value| found_height(value, options.height_unit))
        };
        match (&options.top_field, &options.height_field, self.feature.heights) {
            (Some(name), _, _) => (of(name), true),
            (None, Some(name), _) => (of(name), false),
            (None, None, Some([_, highest])) => (FoundHeight::Meters(highest), true),
            (None, None, None) => (of(HEIGHT), false),
        }
    }

    /// What the feature is called; its number where it has no name.
    fn id(&self, number: usize) -> String {
        let id = self.feature.id.clone().or_else(|| self.property("id").and_then(Property::text));
        id.unwrap_or_else(|| number.to_string())
    }

    fn footprint(&self, number: usize) -> RawFootprint {
        let is_as_it_is = self.options.roofs == Some(Roofs::Lod2);
        let (roof, ground) = match is_as_it_is {
            true => (self.feature.roof.clone(), opened(self.feature.ground.clone()).0),
            false => (Vec::new(), Vec::new()),
        };
        let (polygons, unclosed) = match roof.is_empty() {
            true => opened(self.feature.polygons.clone()),
            false => opened(roof.iter().map(plan).collect()),
        };
        // Rings of surfaces need not be closed.
        let unclosed = if self.feature.heights.is_some() { 0 } else { unclosed };
        let (height, above_datum) = self.height();
        RawFootprint {
            number,
            id: self.id(number),
            polygons,
            unclosed,
            height,
            above_datum,
            levels: self.levels(),
            height_error_m: self.height_error_m(),
            floats: self.is_above_zero("min_height") || self.is_above_zero("building:min_level"),
            lowest: self.feature.heights.map(|[lowest, _]| lowest),
            lacks_roof: is_as_it_is && roof.is_empty(),
            roof,
            ground,
        }
    }
}

/// A height from a property: a number, or text such as `12`, `12.5 m`, `40 ft`, `39'4"`, `12,5`; `unit` is that of
/// numbers without one.
pub(super) fn found_height(value: &Property, unit: HeightUnit) -> FoundHeight {
    let text = match value {
        Property::Number(n) if n.is_finite() => return FoundHeight::Meters(n * unit.meters()),
        Property::Number(_) | Property::Null => return FoundHeight::Missing,
        Property::Text(text) => text.trim(),
    };
    if let Some((feet, inches)) = text.split_once('\'') {
        return feet_and_inches(feet, inches).map_or(FoundHeight::Missing, FoundHeight::Meters);
    }
    const UNITS: [(&str, f64); 8] = [
        ("ft", METERS_PER_FOOT),
        ("feet", METERS_PER_FOOT),
        ("foot", METERS_PER_FOOT),
        ("meters", 1.0),
        ("metres", 1.0),
        ("meter", 1.0),
        ("metre", 1.0),
        ("m", 1.0),
    ];
    let named = UNITS.iter().find_map(|(name, meters)| text.strip_suffix(name).map(|n| (n.trim_end(), *meters)));
    let (number, meters) = named.unwrap_or((text, unit.meters()));
    if let Ok(v) = number.parse::<f64>() {
        return if v.is_finite() { FoundHeight::Meters(v * meters) } else { FoundHeight::Missing };
    }
    // One comma and no point: a decimal comma, not a thousands separator followed by three digits.
    match number.split_once(',') {
        Some((whole, decimals)) if decimals.len() != 3 && !number.contains('.') => format!("{whole}.{decimals}")
            .parse::<f64>()
            .map_or(FoundHeight::Missing, |v| FoundHeight::DecimalComma(v * meters)),
        _ => FoundHeight::Missing,
    }
}

/// `39` and `4"` as meters, the inches left out or below 12.
fn feet_and_inches(feet: &str, inches: &str) -> Option<f64> {
    let feet: f64 = feet.trim().parse().ok().filter(|v: &f64| v.is_finite())?;
    let inches = inches.trim().trim_end_matches(['"', '\'']).trim();
    let inches: f64 = if inches.is_empty() { 0.0 } else { inches.parse().ok()? };
    (0.0..12.0).contains(&inches).then_some((feet + inches / 12.0) * METERS_PER_FOOT)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_are_read_with_their_units_and_nonsense_is_missing() {
        let read = |text: &str| found_height(&Property::Text(text.into()), HeightUnit::Meters);
        for (text, meters) in [("12 m", 12.0), ("12.5m", 12.5), ("12.5", 12.5), ("100 ft", 30.48), ("100'", 30.48)] {
            assert_eq!(read(text), FoundHeight::Meters(meters), "{text}");
        }
        // 39 feet and 4 inches are 472 inches of 25.4 mm.
        let FoundHeight::Meters(mixed) = read("39'4\"") else { panic!("no height") };
        assert!((mixed - 472.0 * 0.0254).abs() < 1e-12, "{mixed}");
        assert_eq!(read("12,5"), FoundHeight::DecimalComma(12.5));
        for nonsense in ["1,200", "tall", "inf", "", "m", "39'14\"", "39'x", "nan ft"] {
            assert_eq!(read(nonsense), FoundHeight::Missing, "{nonsense}");
        }
        assert_eq!(found_height(&Property::Number(100.0), HeightUnit::Feet), FoundHeight::Meters(30.48));
        assert_eq!(found_height(&Property::Text("100 m".into()), HeightUnit::Feet), FoundHeight::Meters(100.0));
        assert_eq!(found_height(&Property::Number(f64::NAN), HeightUnit::Meters), FoundHeight::Missing);
    }
}
