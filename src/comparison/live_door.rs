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
            sight: in_address(&sight.of_page()),
            uavs: sites.iter().map(|site| site.as_ref().map(|s| format!("{},{},{}", s.x, s.y, s.height))).collect(),
        })
    }
}

/// Returns a sight in the form of a live page's address: `name=JSON` for each option that is set.
fn in_address(sight: &Sight) -> String {
    let word = |(name, value): (String, Value)| {
        let json = value.to_string();
        format!("{name}={}", json.replace('"', "%22").replace(',', "%2C").replace('[', "%5B").replace(']', "%5D"))
    };
    json::set_members(sight).into_iter().map(word).collect::<Vec<_>>().join(",")
}
