//! Features with nothing above the ground: no buildings, buildings that are demolished or planned,
//! or below the street.
//!
//! Names and values are those of OpenStreetMap and Overture, which many files borrow. A column
//! `building` may also hold names of houses, as in a cadastre. Features without it are therefore
//! left out only where its values are those of OpenStreetMap.

use super::height_value::FoundHeight;
use super::vector::{Feature, Property};

/// Values of `building` that mappers use most.
const BUILDINGS: [&str; 40] = [
    "yes",
    "house",
    "residential",
    "detached",
    "apartments",
    "garage",
    "garages",
    "shed",
    "hut",
    "industrial",
    "commercial",
    "retail",
    "office",
    "school",
    "church",
    "farm",
    "farm_auxiliary",
    "barn",
    "roof",
    "terrace",
    "semidetached_house",
    "bungalow",
    "cabin",
    "greenhouse",
    "warehouse",
    "service",
    "public",
    "hospital",
    "hotel",
    "university",
    "civic",
    "kindergarten",
    "static_caravan",
    "carport",
    "outbuilding",
    "allotment_house",
    "construction",
    "ruins",
    "no",
    "tower",
];

/// Keys of other features, which are no building unless tagged as one.
const OTHERS: [&str; 5] = ["leisure", "landuse", "natural", "barrier", "highway"];

/// Prefixes, before the colon, of the keys of removed or planned features.
const LIFECYCLES: [&str; 5] = ["demolished", "razed", "removed", "proposed", "construction"];

/// Tagging of buildings in a file.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tagging {
    /// `true` if values of `building` are those of OpenStreetMap.
    has_building_tags: bool,
}

impl Tagging {
    /// Determines the tagging of some areas of a file.
    pub(super) fn of(areas: &[&Feature], name_limit: Option<usize>) -> Tagging {
        let words = || areas.iter().filter_map(|feature| word(feature, "building", name_limit));
        let n_known = words().filter(|value| BUILDINGS.contains(&value.as_str())).count();
        let has_parts = areas.iter().any(|feature| word(feature, "building:part", name_limit).is_some());
        Tagging { has_building_tags: n_known > 0 && 2 * n_known >= words().count() || n_known == 0 && has_parts }
    }

    /// Returns `true` when a feature has nothing above the ground. `height` is the content of its
    /// height property.
    pub(super) fn is_not_there(self, feature: &Feature, name_limit: Option<usize>, height: FoundHeight) -> bool {
        let word = |name: &str| word(feature, name, name_limit);
        let is = |name: &str, values: &[&str]| word(name).is_some_and(|value| values.contains(&value.as_str()));
        let is_underground = is("location", &["underground"])
            || is("is_underground", &["yes", "true", "1", "t"])
            || is("relativeToTerrain", &["entirelybelowterrain"]);
        if is_underground || is("building", &["no", "demolished", "razed", "removed", "proposed"]) {
            return true;
        }
        if word("building").is_some() || word("building:part").is_some_and(|part| part != "no") {
            return false;
        }
        let is_past = |name: &str| {
            let of_building = |life: &str, key: &str| LIFECYCLES.contains(&life) && key.starts_with("building");
            // A format may cut `construction:building` to ten characters.
            let is_cut = |limit: usize| {
                let cut = |life: &&str| format!("{life}:building").chars().take(limit).collect::<String>();
                name.len() == limit
                    && LIFECYCLES.iter().map(cut).any(|key| key == name || key.replace(':', "_") == name)
            };
            name.split_once([':', '_']).is_some_and(|(life, key)| of_building(life, key))
                || name_limit.is_some_and(is_cut)
        };
        let was = |(name, value): &(std::sync::Arc<str>, Property)| *value != Property::Null && is_past(name);
        let is_other = || {
            OTHERS.iter().any(|key| word(key).is_some())
                || (word("amenity").is_some() && height == FoundHeight::Missing)
        };
        feature.properties.iter().any(was) || (self.has_building_tags && is_other())
    }
}

/// Returns the text of a property in lower case; `None` where it is missing or empty.
fn word(feature: &Feature, name: &str, name_limit: Option<usize>) -> Option<String> {
    let text = feature.property(name, name_limit)?.text()?;
    Some(text.trim().to_lowercase()).filter(|text| !text.is_empty())
}
