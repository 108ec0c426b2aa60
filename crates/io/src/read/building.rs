//! Properties of a feature as a building: whether it is one or a part of one, its height, and the
//! unit of that.
//!
//! Names and meanings are those of OpenStreetMap, which most tables of buildings borrow.
//!
//! * `height` is above the ground.
//! * `building:levels` counts storeys without those under the roof, which `roof:levels` counts.
//! * `min_height` is the base of a part that begins above the ground.
//! * `building:part` marks parts of different heights inside an outline ([`super::parts`]);
//!   Overture uses `building_id`.
//!
//! A prism here is solid from the ground up: a floating part is taken as solid, and counted.

use std::collections::HashMap;

use skyshed_request::{GroundChoice, HeightUnit, Roofs};

use super::footprint_options::{FootprintOptions, HEIGHT};
use super::height_value::{FoundHeight, found_height, is_no_top};
use super::not_there::Tagging;
use super::polygon::{Polygon, doubled_area};
use super::repairs::{Culprit, FaultLog};
use super::solid::{Face, FaceKind, Solid, plan};
use super::vector::{CornerHeights, Feature, FeatureSet, Property, SolidHeight, bounds, opened};
use crate::city::FootprintFault;
use crate::error::{Error, Place, ReadFault, Result, Wanted};
use crate::input::Input;

/// Properties that count storeys, unless one is named; the first that a feature has counts.
const STOREYS: [&str; 4] = ["building:levels", "num_floors", "storeysAboveGround", "numberOfFloorsAboveGround"];

/// Properties of the ground below buildings, unless one is named. The first that any feature of the
/// file has counts for all of them. `city` writes the last.
const BASES: [&str; 5] = ["b3_h_maaiveld", "ground_height", "z_ground", "h_ground", "ground"];

/// Areas of a file with their known heights.
#[derive(Debug, Default)]
pub(super) struct Buildings {
    pub(super) footprints: Vec<RawFootprint>,
    /// Share of features with nothing above the ground in the area of all features with a height.
    pub(super) not_there_share: f64,
}

/// Building that a part belongs to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum PartOf {
    /// Building with this id.
    Named(String),
    /// Outline that holds most of the part.
    Outline,
}

/// Feature with areas.
#[derive(Debug, Clone)]
pub(super) struct RawFootprint {
    /// Number of the feature in the file, from 1.
    pub(super) number: usize,
    pub(super) id: String,
    /// `true` if it meets the typed extent.
    pub(super) is_asked: bool,
    /// Polygons of rings of positions, without a last point that repeats the first.
    pub(super) polygons: Vec<Polygon>,
    pub(super) unclosed: usize,
    pub(super) height: FoundHeight,
    /// `true` if the height is that of the top above the datum.
    pub(super) above_datum: bool,
    /// Ground below it \[m above the datum\], if the file holds it.
    pub(super) base_m: Option<f64>,
    /// Building that it is a part of, if any.
    pub(super) part_of: Option<PartOf>,
    /// Storeys, those under the roof included.
    pub(super) levels: Option<f64>,
    /// Standard deviation of the error of the height \[m\].
    pub(super) height_error_m: Option<f64>,
    /// `true` if it begins above the ground.
    pub(super) floats: bool,
    /// Surfaces of its roof, if that is taken as it is.
    pub(super) roof: Vec<Face>,
    /// Area of its ground surfaces then, where known.
    pub(super) ground: Vec<Polygon>,
    /// `true` if its roof should be taken as it is, but has no surface.
    pub(super) lacks_roof: bool,
}

impl RawFootprint {
    /// Returns the area of its polygons as they are drawn \[square CRS units\].
    pub(super) fn area(&self) -> f64 {
        let of_ring = |ring: &Vec<[f64; 2]>| 0.5 * doubled_area(ring).abs();
        let of_polygon =
            |rings: &Polygon| rings.first().map_or(0.0, of_ring) - rings.iter().skip(1).map(of_ring).sum::<f64>();
        self.polygons.iter().map(of_polygon).sum()
    }

    /// Returns `true` when it meets a box: west, south, east, north \[CRS units\].
    pub(super) fn meets(&self, of: [f64; 4]) -> bool {
        meets(&self.polygons, of)
    }

    /// Returns its height above its own ground \[m\]. `None` where the height is missing, or is
    /// above the datum and the file lacks the ground.
    pub(super) fn height_above_ground(&self) -> Option<f64> {
        let height = self.height.meters()?;
        if self.above_datum { self.base_m.map(|base| height - base) } else { Some(height) }
    }

    /// Returns the culprit of a fault of the whole feature.
    pub(super) fn culprit(&self) -> Culprit<'_> {
        self.culprit_at(0)
    }

    /// Returns the culprit of a fault of one of its polygons, with the first point of that.
    pub(super) fn culprit_at(&self, k: usize) -> Culprit<'_> {
        let first = self.polygons.get(k).and_then(|rings| rings.iter().flatten().next());
        Culprit { feature: self.number, id: &self.id, place: first.copied(), is_asked: self.is_asked }
    }
}

/// Makes buildings of the surfaces of geometries with heights.
///
/// With roofs as they are, all of these are. Else a property with a height counts first, and only
/// surfaces are a building that walls or a ground surface lead to the ground.
pub(super) fn take_surfaces(set: &mut FeatureSet, options: &FootprintOptions) {
    if options.top_field.is_some() || options.height_field.is_some() {
        return;
    }
    let reading = Reading { name_limit: set.name_limit, options, base_field: None };
    for feature in &mut set.features {
        let CornerHeights::Surfaces(faces) = &feature.z else { continue };
        let is_as_it_is = options.roofs == Some(Roofs::Lod2);
        if !is_as_it_is && reading.about(feature).height().0 != FoundHeight::Missing {
            continue;
        }
        let solid = Solid::of(faces.iter().map(|face| (face.clone(), FaceKind::Unknown)).collect());
        let is_lofty = !solid.has_walls && solid.ground.is_empty();
        // Walls alone cover nothing.
        if solid.roof.is_empty() || is_lofty && !is_as_it_is {
            continue;
        }
        let Feature { polygons, heights, roof, ground, .. } = Feature::of_solid(solid);
        let of_file = std::mem::take(feature);
        *feature = Feature { polygons, heights, roof, ground, is_lofty, z: CornerHeights::None, ..of_file };
    }
}

impl Buildings {
    /// Returns the buildings among the features of a file, and logs features that are none.
    pub(super) fn of(
        input: &Input,
        set: FeatureSet,
        options: &FootprintOptions,
        log: &mut FaultLog,
    ) -> Result<Buildings> {
        if options.roofs == Some(Roofs::Lod2) && set.features.iter().all(|feature| feature.roof.is_empty()) {
            return Err(Error::read(input, ReadFault::Nothing(Wanted::Roofs)));
        }
        // The meaning of a file must not depend on features that are read beyond the extent. The
        // extent of a projected scene is in a system that is not known yet.
        let extent = options.extent.filter(|_| options.project.is_none());
        let is_asked = |feature: &Feature| {
            !feature.polygons.is_empty() && extent.is_none_or(|extent| meets(&feature.polygons, extent))
        };
        let asked: Vec<&Feature> = set.features.iter().filter(|feature| is_asked(feature)).collect();
        let tagging = Tagging::of(&asked, set.name_limit);
        let mut reading = Reading { name_limit: set.name_limit, options, base_field: options.base_field.as_deref() };
        let has_storeys = |feature: &Feature| {
            let is_none = || tagging.is_not_there(feature, set.name_limit, FoundHeight::Missing);
            let says = reading.about(feature);
            // A part may use those of its outline.
            says.levels().is_some() || says.part_of().is_some() || is_none()
        };
        let all_have_storeys = options.missing.counts_storeys() && asked.iter().all(|feature| has_storeys(feature));
        refuse_unknown_property(input, &asked, reading, all_have_storeys)?;
        let has_base = |name: &&str| asked.iter().any(|feature| reading.about(feature).base_in(name).is_some());
        let base_field = reading.base_field.or_else(|| BASES.into_iter().find(has_base));
        reading = Reading { base_field, ..reading };
        refuse_unknown_bases(input, &asked, reading)?;
        let mut buildings = Buildings::default();
        let (mut area, mut area_not_there) = (0.0, 0.0);
        for (index, feature) in set.features.into_iter().enumerate() {
            let number = index + 1;
            let says = reading.about(&feature);
            if feature.polygons.is_empty() {
                log.note(
                    FootprintFault::NotAnArea,
                    Culprit { feature: number, id: &says.id(number), place: None, is_asked: true },
                );
                continue;
            }
            let bad = feature.polygons.iter().flatten().flatten().flatten().find(|v| !v.is_finite());
            if let Some(bad) = bad {
                let what = format!("found coordinate `{bad}`, wanted a number");
                return Err(Error::malformed(input, what).at(Place::Feature(number as u64)));
            }
            let mut footprint = says.footprint(number);
            footprint.is_asked = extent.is_none_or(|extent| footprint.meets(extent));
            if feature.has_other_parts {
                log.note(FootprintFault::NotAnArea, footprint.culprit());
            }
            // Only features with a height count in the share.
            let has_height = footprint.height != FoundHeight::Missing;
            let of_it = if has_height && footprint.is_asked { footprint.area() } else { 0.0 };
            area += of_it;
            let is_flat = footprint.height.meters() == Some(0.0) && !footprint.above_datum;
            if is_flat || tagging.is_not_there(&feature, set.name_limit, footprint.height) {
                area_not_there += of_it;
                log.note(FootprintFault::NotABuilding, footprint.culprit());
                continue;
            }
            buildings.footprints.push(footprint);
        }
        if area > 0.0 {
            buildings.not_there_share = area_not_there / area;
        }
        share_bases(&mut buildings.footprints);
        Ok(buildings)
    }

    /// Returns west, south, east, north of all positions; `None` if there is none.
    pub(super) fn bounds(&self) -> Option<[f64; 4]> {
        bounds(self.footprints.iter().flat_map(|f| &f.polygons))
    }
}

/// Sets the base of all parts of a named building to the lowest of theirs. A tower that is drawn
/// from a roof on stands on the ground of its building.
fn share_bases(footprints: &mut [RawFootprint]) {
    let mut lowest: HashMap<String, f64> = HashMap::new();
    for footprint in footprints.iter() {
        if let (Some(PartOf::Named(name)), Some(base)) = (&footprint.part_of, footprint.base_m) {
            lowest.entry(name.clone()).and_modify(|m| *m = m.min(base)).or_insert(base);
        }
    }
    for footprint in footprints {
        if let Some(PartOf::Named(name)) = &footprint.part_of {
            footprint.base_m = lowest.get(name).copied();
        }
    }
}

/// Returns `true` when the box around polygons meets another: west, south, east, north.
fn meets(polygons: &[Polygon], [west, south, east, north]: [f64; 4]) -> bool {
    bounds(polygons.iter()).is_some_and(|[w, s, e, n]| w <= east && e >= west && s <= north && n >= south)
}

/// Refuses areas of which none has the property that heights are read from, unless the list for
/// missing heights gives each one.
fn refuse_unknown_property(
    input: &Input,
    areas: &[&Feature],
    reading: Reading<'_>,
    all_have_storeys: bool,
) -> Result<()> {
    let Reading { name_limit, options, .. } = reading;
    let name = options.height_property();
    let areas = || areas.iter();
    let has = |name: &str| areas().any(|feature| feature.column(name, name_limit).is_some());
    let is_named = options.top_field.is_some() || options.height_field.is_some();
    let by_itself = !is_named && areas().any(|feature| feature.heights.is_some());
    if let Some(name) = options.height_error_field.as_deref().filter(|name| areas().next().is_some() && !has(name)) {
        return Err(Error::read(input, ReadFault::NoErrorProperty(name.to_string())));
    }
    if areas().next().is_none() || has(name) || all_have_storeys || by_itself || options.missing.gives_all() {
        return Ok(());
    }
    const MOST: usize = 12;
    // A longer name is none that can be typed.
    const LONGEST: usize = 64;
    let mut like_heights: Vec<&str> = Vec::new();
    let mut like_storeys: Vec<&str> = Vec::new();
    let mut others: Vec<&str> = Vec::new();
    let properties = areas().take(100).flat_map(|feature| feature.all_properties());
    for (name, value) in properties.filter(|(name, _)| name.len() <= LONGEST) {
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
    let (wanted, has_bases) = (name.to_string(), BASES.iter().any(|name| has(name)));
    let has_z = areas().any(|feature| feature.z != CornerHeights::None);
    let fault = ReadFault::NoHeightProperty { wanted, like_heights, like_storeys, others, has_bases, has_z };
    Err(Error::read(input, fault))
}

/// Returns the properties that count storeys.
fn storeys_of(options: &FootprintOptions) -> Vec<&str> {
    options.levels_field.as_deref().map_or(STOREYS.to_vec(), |name| vec![name])
}

/// Refuses areas without a property of the ground below them, where that is needed.
///
/// # Errors
/// E365 without the property that was named, or without any of the known ones.
fn refuse_unknown_bases(input: &Input, areas: &[&Feature], reading: Reading<'_>) -> Result<()> {
    let Reading { name_limit, options, .. } = reading;
    if areas.is_empty() {
        return Ok(());
    }
    let has = |name: &str| areas.iter().any(|feature| feature.column(name, name_limit).is_some());
    if let Some(name) = options.base_field.as_deref().filter(|name| !has(name)) {
        return Err(Error::read(input, ReadFault::NoBaseProperty(name.into())));
    }
    let of_property = match (options.top_field.as_deref(), options.ground) {
        (None, _) if options.needs_bases() && areas.iter().any(|feature| feature.is_lofty) => Some("z"),
        (Some(top), _) if options.needs_bases() => Some(top),
        (None, Some(GroundChoice::Buildings)) if areas.iter().all(|feature| feature.heights.is_none()) => {
            Some(options.height_property())
        }
        _ => None,
    };
    match of_property {
        Some(name) if areas.iter().all(|feature| reading.about(feature).base_m().is_none()) => {
            Err(Error::read(input, ReadFault::NoBases(name.into())))
        }
        _ => Ok(()),
    }
}

/// Likely content of a property.
enum Likeness {
    Height,
    Storeys,
}

/// Guesses whether a property holds the height of a building, or the number of its storeys.
fn likeness(name: &str, value: &Property) -> Option<Likeness> {
    const HEIGHTS: [&str; 11] =
        ["height", "heigth", "hgt", "hoehe", "höhe", "haut", "altura", "altezza", "hoogte", "z_", "b3_h_"];
    const WHOLE: [&str; 5] = ["h", "z", "top", "roof", "elev"];
    const STOREYS: [&str; 4] = ["level", "storey", "stories", "floors"];
    if BASES.contains(&name) {
        return None;
    }
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

/// Rules by which the features of a file are read.
#[derive(Clone, Copy)]
struct Reading<'a> {
    name_limit: Option<usize>,
    options: &'a FootprintOptions,
    /// Property of the ground below buildings, if the file has one.
    base_field: Option<&'a str>,
}

impl Reading<'_> {
    fn about<'f>(&'f self, feature: &'f Feature) -> Says<'f> {
        Says { feature, reading: *self }
    }
}

/// A feature, and the rules by which it is read.
struct Says<'a> {
    feature: &'a Feature,
    reading: Reading<'a>,
}

impl Says<'_> {
    fn property(&self, name: &str) -> Option<&Property> {
        self.feature.property(name, self.reading.name_limit)
    }

    fn word(&self, name: &str) -> Option<String> {
        self.property(name).and_then(Property::text).map(|text| text.trim().to_lowercase())
    }

    /// Returns the building that it is a part of.
    fn part_of(&self) -> Option<PartOf> {
        let named = self.feature.part_of.clone().or_else(|| self.property("building_id").and_then(Property::text));
        let is_part = || self.word("building:part").is_some_and(|word| word != "no" && !word.is_empty());
        named.map(PartOf::Named).or_else(|| is_part().then_some(PartOf::Outline))
    }

    /// Returns `true` when a property holds a number above zero.
    fn is_above_zero(&self, name: &str) -> bool {
        let found = self.property(name).map(|value| found_height(value, HeightUnit::Meters));
        found.and_then(FoundHeight::meters).is_some_and(|v| v > 0.0)
    }

    /// Returns the number that a property holds.
    fn number(&self, name: &str) -> Option<f64> {
        found_height(self.property(name)?, HeightUnit::Meters).meters()
    }

    fn levels(&self) -> Option<f64> {
        let levels =
            storeys_of(self.reading.options).into_iter().find_map(|name| self.number(name).filter(|n| *n > 0.0))?;
        Some(levels + self.number("roof:levels").filter(|n| *n > 0.0).unwrap_or(0.0))
    }

    /// Returns the ground below it \[m above the datum\] from a property.
    fn base_in(&self, name: &str) -> Option<f64> {
        found_height(self.property(name)?, self.reading.options.height_unit).unless(is_no_top).meters()
    }

    /// Returns the ground below it \[m above the datum\]. A solid's own lowest point counts first,
    /// unless the property of another height is named.
    fn base_m(&self) -> Option<f64> {
        let of_solid = self.feature.heights.filter(|_| !self.feature.is_lofty).map(|[lowest, _]| lowest);
        let of_field = || self.base_in(self.reading.base_field?);
        match self.reading.options.top_field.is_some() || self.reading.options.height_field.is_some() {
            true => of_field().or(of_solid),
            false => of_solid.or_else(of_field),
        }
    }

    /// Returns the standard deviation of the error of the height \[m\], if a property holds it.
    fn height_error_m(&self) -> Option<f64> {
        let value = self.property(self.reading.options.height_error_field.as_deref()?)?;
        match found_height(value, self.reading.options.height_unit) {
            FoundHeight::Meters(m) | FoundHeight::DecimalComma(m) => Some(m),
            FoundHeight::Missing => None,
        }
    }

    /// Returns the height, and `true` if it is above the datum. The height comes from the named
    /// property, else from the solid itself, else from `height`.
    fn height(&self) -> (FoundHeight, bool) {
        let options = self.reading.options;
        let of = |name: &str| {
            self.property(name).map_or(FoundHeight::Missing, |value| found_height(value, options.height_unit))
        };
        // A number below 0 means no height, unless the feature has a `min_height`.
        let begins_somewhere = self.property("min_height").is_some();
        let above_ground = |name: &str| of(name).unless(|m| m < 0.0 && !begins_somewhere);
        match (&options.top_field, &options.height_field, self.feature.heights, self.feature.height) {
            (Some(name), ..) => (of(name).unless(is_no_top), true),
            (None, Some(name), ..) => (above_ground(name), false),
            (None, None, Some(_), Some(SolidHeight::Measured(m))) => (FoundHeight::Meters(m), false),
            (None, None, Some(_), Some(SolidHeight::Unknown)) => (FoundHeight::Missing, false),
            (None, None, Some([_, highest]), None) => (FoundHeight::Meters(highest), true),
            (None, None, None, _) => (above_ground(HEIGHT), false),
        }
    }

    /// Returns the id of the feature; its number where it has none.
    fn id(&self, number: usize) -> String {
        self.feature.known_id().unwrap_or_else(|| number.to_string())
    }

    fn footprint(&self, number: usize) -> RawFootprint {
        // Surfaces that do not define the height are no roof.
        let is_as_it_is = self.reading.options.roofs == Some(Roofs::Lod2) && self.feature.height.is_none();
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
            is_asked: true,
            polygons,
            unclosed,
            height,
            above_datum,
            base_m: self.base_m(),
            part_of: self.part_of(),
            levels: self.levels(),
            height_error_m: self.height_error_m(),
            floats: self.is_above_zero("min_height") || self.is_above_zero("building:min_level"),
            lacks_roof: is_as_it_is && roof.is_empty(),
            roof,
            ground,
        }
    }
}
