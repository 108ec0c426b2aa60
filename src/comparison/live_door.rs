//! The way from the page of a comparison to the live page of the same place.

use super::facts::{Origin, PlacementFacts};
use super::outcome::Comparison;
use crate::city::{Antenna, Site};
use crate::live::LivePage;
use crate::picture::Look;
use crate::quantity::Height;
use crate::render::gzip;

/// The live page of a comparison, packed, and what its address says.
pub(super) struct LivePacked {
    pub(super) page: Vec<u8>,
    pub(super) sight: String,
    pub(super) uavs: Vec<Option<String>>,
}

impl Comparison {
    /// The live page of the same place, where the UAVs are known and a page can hold the scene.
    pub(super) fn live(&self, look: &Look) -> Option<LivePacked> {
        let run = self.report.sight.antenna();
        let uav = |placement: &PlacementFacts| match &placement.origin {
            // A page has one antenna.
            Origin::Uav(uav) if uav.antenna.or(run) == run => {
                Some(Site::new(placement.id.clone(), (uav.x, uav.y), Height::amsl(uav.height_amsl_m)))
            }
            _ => None,
        };
        let sites: Vec<Option<Site>> = self.report.placements.iter().map(uav).collect();
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
                in_address(sight.antenna())
            ),
            uavs: sites.iter().map(|site| site.as_ref().map(|s| format!("{},{},{}", s.x, s.y, s.height))).collect(),
        })
    }
}

/// An antenna as the address of a live page says it: nothing, or six numbers that may be empty.
fn in_address(antenna: Antenna) -> String {
    if antenna == Antenna::default() {
        return String::new();
    }
    let number = |v: Option<f64>| v.map_or(String::new(), |v| v.to_string());
    let pair = |v: Option<[f64; 2]>| v.map_or(",".to_string(), |[a, b]| format!("{a},{b}"));
    let Antenna { min_radius_m, sector_deg, elevation_deg, beam_deg } = antenna;
    format!(",{},{},{},{}", number(min_radius_m), pair(sector_deg), pair(elevation_deg), number(beam_deg))
}
