//! Document, table rows and text lines of `limits`.

use schemars::JsonSchema;
use serde::Serialize;

use crate::accuracy::{BudgetLine, RoofEffect};
use crate::answer::{Head, WarningFacts};
use crate::city::Solids;
use crate::map::IdleDocument;
use crate::quantity::{counted, signed, tidy};
use crate::render::{grouped, percent};
use crate::sight::SightFacts;

/// Effect of errors of building heights.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub(crate) struct HeightLimitsDocument {
    /// Largest error of each building's height [m].
    pub(super) error_m: f64,
    /// Receivers in range, summed over all UAVs.
    pub(super) receivers: u64,
    /// Receivers that such errors can bring into or out of line of sight.
    pub(super) possibly: u64,
    /// Footprints whose heights, each alone, decide about the most receivers: measure these first.
    pub(super) buildings: Vec<DecidingBuilding>,
    /// Typical errors of such heights; null for a generated city.
    pub(super) typical: Option<&'static str>,
}

/// A building whose height decides about receivers.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub(super) struct DecidingBuilding {
    /// Id of the building.
    pub(super) id: String,
    /// Receivers whose answer depends on its height alone.
    pub(super) receivers: u64,
}

impl HeightLimitsDocument {
    /// Returns the lines of the answer.
    pub(super) fn text(&self) -> String {
        let share = percent(self.possibly, self.receivers);
        let (error, n) = (tidy(self.error_m), grouped(self.possibly));
        let mut text =
            format!("heights    {share} of receivers ({n}) hang on heights of buildings, each off by up to {error} m");
        text += &self.typical.map_or("\n".to_string(), |typical| format!(";\n           typically off by {typical}\n"));
        if !self.buildings.is_empty() {
            let of = |building: &DecidingBuilding| format!("{} ({})", building.id, grouped(building.receivers));
            let named: Vec<String> = self.buildings.iter().map(of).collect();
            text += &format!("           roofs to measure first: {}\n", named.join(", "));
        }
        text
    }
}

/// Limits of a map.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct LimitsDocument {
    #[serde(flatten)]
    pub(super) head: Head,
    #[serde(flatten)]
    pub(super) sight: SightFacts,
    /// Share of receivers in line of sight; null without a receiver.
    pub(super) p_los: Option<f64>,
    /// Receivers in range, summed over all UAVs.
    pub(super) receivers: u64,
    /// P_LoS on coarser cells.
    pub(super) cells: Vec<CellDocument>,
    /// Coarsest cells on which P_LoS hardly changes, in words.
    pub(super) coarsest_unchanged: Option<String>,
    /// Changes of P_LoS below this count as none.
    pub(super) unchanged_below: f64,
    /// Receivers that terrain hides by itself; null if terrain is flat or not known.
    pub(super) terrain: Option<TerrainDocument>,
    /// Footprints that can hide no receiver.
    pub(super) footprints: Option<IdleDocument>,
    /// Footprints that are rectangles.
    pub(super) rectangles: Option<Rectangles>,
    /// Change if each roof were flat at its highest point; null if all roofs are flat.
    pub(super) roofs: Option<RoofDocument>,
    /// Reason for the choice of the engine.
    pub(super) why: &'static str,
    /// Expected time of the line of sight [s].
    pub(super) expected_s: f64,
    /// Effect of errors of building heights.
    pub(super) heights: HeightLimitsDocument,
    /// Causes of uncertainty of P_LoS, the largest first.
    pub(super) budget: Vec<LineDocument>,
    /// Warnings.
    pub(super) warnings: Vec<WarningFacts>,
}

/// Change that flat roofs would make.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct RoofDocument {
    /// Buildings whose roofs are not flat.
    pub(super) shaped: Option<usize>,
    /// Receivers whose answers would change.
    pub(super) turned: Option<u64>,
    /// Receivers of both forms.
    pub(super) receivers: Option<u64>,
    /// P_LoS with flat roofs.
    pub(super) p_los: Option<f64>,
    /// Reason for an unknown change.
    pub(super) reason: Option<String>,
}

impl RoofDocument {
    pub(super) fn of(roofs: &std::result::Result<RoofEffect, String>) -> Self {
        let known = roofs.as_ref().ok();
        RoofDocument {
            shaped: known.map(|roofs| roofs.shaped),
            turned: known.map(|roofs| roofs.turned),
            receivers: known.map(|roofs| roofs.receivers),
            p_los: known.and_then(|roofs| roofs.p_los),
            reason: roofs.as_ref().err().cloned(),
        }
    }
}

/// Returns the line of the answer about roofs.
pub(super) fn roofs_in_words(roofs: &std::result::Result<RoofEffect, String>, p_los: f64) -> String {
    match roofs {
        Err(why) => format!("roofs      what flat ones would change is not known: {why}\n"),
        Ok(RoofEffect { shaped, turned, receivers, p_los: of_flat }) => {
            let change = of_flat.map_or(String::new(), |flat| format!(", P_LoS by {}", signed(flat - p_los, 4)));
            let (shaped, share) =
                (counted(*shaped as u64, "building is", "buildings are"), percent(*turned, *receivers));
            format!("roofs      of {shaped} not flat: flat ones would turn {share} of receivers{change}\n")
        }
    }
}

/// P_LoS on other cells.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct CellDocument {
    /// Width of a cell [m].
    pub(super) cell_m: f64,
    /// Rule by which a coarse cell gets its height from the cells in it.
    pub(super) pooling: Option<&'static str>,
    /// P_LoS on these cells.
    pub(super) p_los: Option<f64>,
    /// P_LoS on these cells less that of the scene itself.
    pub(super) change: Option<f64>,
    /// Reason for a missing P_LoS.
    pub(super) reason: Option<String>,
}

/// Receivers that terrain hides by itself.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct TerrainDocument {
    /// Receivers that terrain hides.
    pub(super) hidden: u64,
    /// All receivers.
    pub(super) receivers: u64,
}

/// A cause of uncertainty of P_LoS.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct LineDocument {
    /// Quantity that is not known exactly.
    pub(super) part: &'static str,
    /// Change that was tried.
    pub(super) changed: String,
    /// Change of P_LoS.
    pub(super) p_los_change: Option<f64>,
    /// Reason for an unknown change.
    pub(super) reason: Option<String>,
}

impl LineDocument {
    pub(super) fn of(line: &BudgetLine) -> Self {
        LineDocument {
            part: line.part.name(),
            changed: line.changed.clone(),
            p_los_change: line.change.as_ref().ok().copied(),
            reason: line.change.as_ref().err().cloned(),
        }
    }
}

/// A row of the table of causes of uncertainty.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct LimitRow {
    /// Quantity that is not known exactly.
    pub(super) part: &'static str,
    /// Change that was tried.
    pub(super) changed: String,
    /// P_LoS of the scene itself.
    pub(super) p_los: Option<f64>,
    /// Change of P_LoS.
    pub(super) p_los_change: Option<f64>,
    /// Reason for an unknown change.
    pub(super) reason: Option<String>,
}

/// Footprints that are rectangles.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
pub(crate) struct Rectangles {
    /// Number of rectangles.
    pub(super) rectangles: usize,
    /// Number of all footprints.
    pub(super) footprints: usize,
}

impl Rectangles {
    /// Counts them among footprints; `None` for a raster.
    pub(super) fn of(solids: &Solids) -> Option<Rectangles> {
        let Solids::Vector { footprints, .. } = solids else { return None };
        let rectangles = footprints.iter().filter(|footprint| footprint.is_rectangle()).count();
        Some(Rectangles { rectangles, footprints: footprints.len() })
    }
}
