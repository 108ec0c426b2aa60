//! What `limits` tells in its document, its table and its lines.

use schemars::JsonSchema;
use serde::Serialize;

use crate::accuracy::{BudgetLine, RoofEffect};
use crate::answer::{Head, WarningFacts};
use crate::map::IdleDocument;
use crate::quantity::{counted, signed, tidy};
use crate::render::{grouped, percent};
use crate::sight::SightFacts;

/// What hangs on heights of buildings.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub(crate) struct HeightLimitsDocument {
    /// How far the height of each building may be off [m].
    pub(super) error_m: f64,
    /// Receivers in range of all UAVs, counted together.
    pub(super) receivers: u64,
    /// Those that are in line of sight for some of these heights and not for others.
    pub(super) possibly: u64,
    /// The buildings of footprints whose heights decide about the most receivers, each alone: those to measure first.
    pub(super) buildings: Vec<DecidingBuilding>,
    /// How far such heights are off, typically; null for a generated city.
    pub(super) typical: Option<&'static str>,
}

/// A building whose height decides about receivers.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub(super) struct DecidingBuilding {
    /// Its id.
    pub(super) id: String,
    /// Receivers whose answer its height alone turns.
    pub(super) receivers: u64,
}

impl HeightLimitsDocument {
    /// Lines of the answer.
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

/// What limits a map.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct LimitsDocument {
    #[serde(flatten)]
    pub(super) head: Head,
    #[serde(flatten)]
    pub(super) sight: SightFacts,
    /// Share of receivers in line of sight; null without a receiver.
    pub(super) p_los: Option<f64>,
    /// Receivers in range of all UAVs, counted together.
    pub(super) receivers: u64,
    /// P_LoS on coarser cells.
    pub(super) cells: Vec<CellDocument>,
    /// The coarsest cells on which P_LoS hardly changes, in words.
    pub(super) coarsest_unchanged: Option<String>,
    /// Changes of P_LoS below this are none.
    pub(super) unchanged_below: f64,
    /// What terrain hides by itself; null where it is flat or not known.
    pub(super) terrain: Option<TerrainDocument>,
    /// Footprints that can hide no receiver.
    pub(super) footprints: Option<IdleDocument>,
    /// Footprints that are rectangles.
    pub(super) rectangles: Option<Rectangles>,
    /// What flat roofs, each as high as it is highest, would change; null where all are flat.
    pub(super) roofs: Option<RoofDocument>,
    /// Why the engine is taken.
    pub(super) why: &'static str,
    /// How long line of sight is expected to take [s].
    pub(super) expected_s: f64,
    /// What hangs on heights of buildings.
    pub(super) heights: HeightLimitsDocument,
    /// What limits P_LoS, the largest first.
    pub(super) budget: Vec<LineDocument>,
    /// What was odd.
    pub(super) warnings: Vec<WarningFacts>,
}

/// What flat roofs would change.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct RoofDocument {
    /// Buildings whose roofs are not flat.
    pub(super) shaped: Option<usize>,
    /// Receivers whose answers they turn.
    pub(super) turned: Option<u64>,
    /// Receivers of both forms.
    pub(super) receivers: Option<u64>,
    /// P_LoS with them.
    pub(super) p_los: Option<f64>,
    /// Why that is not known.
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

/// The line of the answer.
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
    /// Height of a larger cell among those of the cells in it.
    pub(super) pooling: Option<&'static str>,
    /// P_LoS on them.
    pub(super) p_los: Option<f64>,
    /// Its P_LoS less that of the scene itself.
    pub(super) change: Option<f64>,
    /// Why there is none.
    pub(super) reason: Option<String>,
}

/// What terrain hides by itself.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct TerrainDocument {
    /// Receivers that it hides.
    pub(super) hidden: u64,
    /// All receivers.
    pub(super) receivers: u64,
}

/// Something that limits P_LoS.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct LineDocument {
    /// What is not known exactly.
    pub(super) part: &'static str,
    /// What was changed to find out.
    pub(super) changed: String,
    /// How much P_LoS changes.
    pub(super) p_los_change: Option<f64>,
    /// Why that is not known.
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

/// A row of the table of what limits P_LoS.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct LimitRow {
    /// What is not known exactly.
    pub(super) part: &'static str,
    /// What was changed to find out.
    pub(super) changed: String,
    /// P_LoS of the scene itself.
    pub(super) p_los: Option<f64>,
    /// How much it changes.
    pub(super) p_los_change: Option<f64>,
    /// Why that is not known.
    pub(super) reason: Option<String>,
}

/// Footprints that are rectangles.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
pub(super) struct Rectangles {
    /// How many are.
    pub(super) rectangles: usize,
    /// All of them.
    pub(super) footprints: usize,
}
