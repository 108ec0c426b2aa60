//! Table of a map: a row per UAV and zone.

use schemars::JsonSchema;
use serde::Serialize;

use super::report::{MapReport, SiteFacts};
use crate::answer::{PositionFields, Rows, rows};
use crate::city::Antenna;
use crate::coverage::Tally;
use crate::height_errors::IntervalFacts;
use crate::raster::Crs;
use crate::sight::antenna_words;
use crate::zones::Zone;

/// Row of a map's table.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct MapRow {
    #[serde(flatten)]
    site: SiteDocumentHead,
    /// Zone of the receivers, or all.
    zone: &'static str,
    /// Receivers in range.
    receivers: u64,
    /// Receivers in line of sight.
    los: u64,
    /// Share of the receivers in line of sight; empty without a receiver.
    p_los: Option<f64>,
    /// Lower end of the interval of that share with heights redrawn, if heights may be off.
    #[serde(skip_serializing_if = "Option::is_none")]
    p_los_low: Option<f64>,
    /// Upper end of that interval.
    #[serde(skip_serializing_if = "Option::is_none")]
    p_los_high: Option<f64>,
    /// Cells in range that hold no receiver, such as buildings.
    not_receivers: u64,
    /// Cells out of range.
    out_of_range: u64,
    /// Cells without data.
    nodata: u64,
    /// Height of the receivers above the ground or roof below them [m].
    rx_height_m: f64,
    /// Largest horizontal distance from the UAV [m]; empty without a limit.
    radius_m: Option<f64>,
    /// Limits of the antenna, in words; empty without any.
    antenna: Option<String>,
    /// Engine that decided line of sight.
    method: String,
    /// Reference system; empty for local coordinates.
    crs: Option<String>,
    /// Width of a cell [units of the reference system].
    cell_width: f64,
    /// Height of a cell [units of the reference system].
    cell_height: f64,
}

/// UAV of a row.
#[derive(Debug, Clone, Serialize, JsonSchema)]
struct SiteDocumentHead {
    /// Name of the UAV; `union` for all of them together.
    site: String,
    #[serde(flatten)]
    position: PositionFields,
    /// Height of the UAV above the datum [m].
    height_amsl_m: Option<f64>,
    /// Height of the UAV above the ground [m]; empty where no ground is known.
    height_agl_m: Option<f64>,
    /// Place below the UAV: a zone, or ground, rooftop or nodata where zones are not known.
    placement: &'static str,
}

impl SiteDocumentHead {
    fn of(site: &SiteFacts) -> Self {
        SiteDocumentHead {
            site: site.id.clone(),
            position: site.position().into(),
            height_amsl_m: Some(site.height_amsl_m),
            height_agl_m: site.height_agl_m,
            placement: site.placement,
        }
    }

    fn union() -> Self {
        let position = PositionFields::default();
        SiteDocumentHead { site: "union".into(), position, height_amsl_m: None, height_agl_m: None, placement: "" }
    }
}

impl MapReport {
    /// Returns the table: one row per site and zone, and the same for the union of several sites.
    pub(crate) fn table(&self) -> Rows {
        let grid = &self.facts.grid;
        let row = |site: &SiteDocumentHead,
                   antenna: &Option<String>,
                   (zone, tally, interval): (&'static str, &Tally, Option<IntervalFacts>)| MapRow {
            site: site.clone(),
            zone,
            receivers: tally.receivers,
            los: tally.los,
            p_los: tally.p_los(),
            p_los_low: interval.map(|interval| interval.low()),
            p_los_high: interval.map(|interval| interval.high()),
            not_receivers: tally.not_receivers,
            out_of_range: tally.out_of_range,
            nodata: tally.nodata,
            rx_height_m: self.sight.rx_height_m(),
            radius_m: self.sight.radius_m(),
            antenna: antenna.clone(),
            method: self.facts.method_name(),
            crs: grid.crs().map(Crs::label),
            cell_width: grid.cell_width(),
            cell_height: grid.cell_height(),
        };
        let of =
            |site: SiteDocumentHead, antenna: Antenna, (all, interval): (&Tally, _), zones: Option<&[Tally; 4]>| {
                let antenna = antenna_words(antenna);
                let by_zone = Zone::ALL.into_iter().zip(zones.into_iter().flatten());
                let by_zone = by_zone.map(|(zone, tally)| row(&site, &antenna, (zone.name(), tally, None)));
                std::iter::once(row(&site, &antenna, ("all", all, interval))).chain(by_zone).collect::<Vec<_>>()
            };
        let run = self.sight.antenna();
        let of_site = |s: &SiteFacts| {
            let interval = s.uncertain.and_then(|uncertain| uncertain.interval);
            of(SiteDocumentHead::of(s), s.antenna.or(run), (&s.tally, interval), s.zones.as_ref())
        };
        let sites = self.sites.iter().flat_map(of_site);
        let union = (self.sites.len() > 1)
            .then(|| of(SiteDocumentHead::union(), run, (&self.union, None), self.union_zones.as_ref()));
        rows(sites.chain(union.into_iter().flatten()))
    }
}
