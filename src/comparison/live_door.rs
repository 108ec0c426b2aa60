//! Link from the page of a comparison to the live page of the same place.

use super::outcome::Comparison;
use crate::city::{Antenna, Site};
use crate::height_field::Curvature;
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
        let range = sight.radius_m().map(|r| r.to_string()).unwrap_or_default();
        Some(LivePacked {
            page: gzip(page.as_bytes()),
            sight: format!(
                "{},{},{range}{}",
                sight.rx_height_m(),
                sight.receivers().name(),
                in_address(sight.antenna(), sight.curvature().map(Curvature::earth_k))
            ),
            uavs: sites.iter().map(|site| site.as_ref().map(|s| format!("{},{},{}", s.x, s.y, s.height))).collect(),
        })
    }
}

/// Returns an antenna and k of the earth in the form of a live page's address. This is empty, or
/// six numbers that may be empty, followed by k.
fn in_address(antenna: Antenna, earth_k: Option<f64>) -> String {
    if antenna == Antenna::default() && earth_k.is_none() {
        return String::new();
    }
    let number = |v: Option<f64>| v.map_or(String::new(), |v| v.to_string());
    let pair = |v: Option<[f64; 2]>| v.map_or(",".to_string(), |[a, b]| format!("{a},{b}"));
    let Antenna { min_radius_m, sector_deg, elevation_deg, beam_deg } = antenna;
    let k = earth_k.map_or(String::new(), |k| format!(",{k}"));
    format!(",{},{},{},{}{k}", number(min_radius_m), pair(sector_deg), pair(elevation_deg), number(beam_deg))
}
