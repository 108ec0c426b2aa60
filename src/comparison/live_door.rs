//! Link from the page of a comparison to the live page of the same place.

use serde_json::Value;
use skyshed_request::{Sight, json};

use super::outcome::Comparison;
use crate::city::{Antenna, Site};
use crate::live::LivePage;
use crate::picture::Look;
use crate::render::gzip;

/// Live page of a comparison, compressed, and the parts of its address.
pub(super) struct LivePacked {
    pub(super) page: Vec<u8>,
    pub(super) sight: String,
    pub(super) uavs: Vec<Option<String>>,
}

impl Comparison {
    /// Returns the live page of the same place. `None` without a known UAV, or if a page cannot
    /// hold the scene.
    pub(super) fn live(&self, look: &Look) -> Option<LivePacked> {
        let run = self.report.sight.antenna();
        // A page has one antenna.
        let site = |uav: &Site| {
            let as_asked = Site { antenna: Antenna::default(), ..uav.clone() };
            (uav.antenna.or(run) == run).then_some(as_asked)
        };
        let n_masks = self.report.placements.len() - self.uavs.len();
        let sites: Vec<Option<Site>> = self.uavs.iter().map(site).chain(std::iter::repeat_n(None, n_masks)).collect();
        let first = sites.iter().flatten().next()?.clone();
        let (scene, sight) = (&self.scene, self.report.sight);
        let page =
            LivePage::of(scene, &[first], sight, self.scene_words.clone()).and_then(|page| page.html(look)).ok()?;
        Some(LivePacked {
            page: gzip(page.as_bytes()),
            sight: in_address(&sight.asked()),
            uavs: sites.iter().map(|site| site.as_ref().map(|s| format!("{},{},{}", s.x, s.y, s.height))).collect(),
        })
    }
}

/// Returns a sight in the form of a live page's address: options in order, an empty word for one that
/// is not set, then others as `name=JSON`.
fn in_address(sight: &Sight) -> String {
    const IN_ORDER: [&str; 8] =
        ["rx_height", "receivers", "radius", "min_radius", "sector", "elevation", "beam", "earth_k"];
    let mut members = json::set_members(sight);
    let mut words: Vec<String> = Vec::new();
    for name in IN_ORDER {
        match (members.remove(name), name) {
            (Some(Value::Array(pair)), _) => words.extend(pair.iter().map(Value::to_string)),
            (Some(Value::String(text)), _) => words.push(text),
            (Some(value), _) => words.push(value.to_string()),
            (None, "sector" | "elevation") => words.extend([String::new(), String::new()]),
            (None, _) => words.push(String::new()),
        }
    }
    while words.len() > 3 && words.last().is_some_and(String::is_empty) {
        words.pop();
    }
    words.extend(members.iter().map(|(name, value)| format!("{name}={value}")));
    words.join(",")
}
