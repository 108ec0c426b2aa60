//! What limits a map: how coarse its cells may be, whether terrain matters, which footprints can hide anyone, how far P_LoS
//! is off if UAVs or heights are.

use std::ffi::OsStr;
use std::path::Path;
use std::time::Instant;

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use crate::accuracy::{
    BudgetLine, CellEffect, NO_CHANGE, RoofEffect, Setup, Simpler, TerrainEffect, Uncertain, cell_effects,
    coarsest_unchanged, error_budget, roof_effect, terrain_effect,
};
use crate::answer::{Answer, Head, Rows, RunFacts, Spent, WarningFacts, document_of, rows, warnings_of};
use crate::city::Solids;
use crate::coverage::{Control, HeightLayers, IdleFootprints, MapOptions, Mapper, Uav};
use crate::error::{Error, Result, Warning};
use crate::expected::Expected;
use crate::export::{Batch, Format};
use crate::height_field::HeightField;
use crate::map::IdleDocument;
use crate::picture::Look;
use crate::quantity::{counted, tidy};
use crate::read::MissingHeight;
use crate::render::{grouped, percent};
use crate::scene::{Scene, SceneOptions};
use crate::sight::{Sight, SightFacts};
use crate::uav::UavsAsked;
use crate::words::idle_in_words;
use crate::zones::ZoneMap;

/// Formats of what limits a map.
pub(crate) const FORMATS: [Format; 3] = [Format::Csv, Format::Json, Format::Stdout];

/// Whose map is looked at, and what is not known exactly.
#[derive(Debug)]
pub(crate) struct LimitsPlan {
    pub(crate) sight: Sight,
    /// How far UAVs may be from where they should be, sideways and in height \[m\].
    pub(crate) uav_error_m: f64,
    /// How far the heights of all buildings may be off \[m\].
    pub(crate) height_error_m: f64,
    /// Other cities of a generated kind that tell how much one city of many matters.
    pub(crate) n_cities: u16,
}

/// What limits a map.
#[derive(Debug)]
pub(crate) struct Limits {
    facts: RunFacts,
    sight: Sight,
    p_los: Option<f64>,
    receivers: u64,
    cell_m: f64,
    cells: Vec<CellEffect>,
    terrain: TerrainEffect,
    idle: IdleFootprints,
    rectangles: Option<Rectangles>,
    /// What flat roofs would change, where any is not; or why that is not known.
    roofs: Option<std::result::Result<RoofEffect, String>>,
    /// Why `auto` takes its engine, and how long that is expected to take \[s\].
    engine: (&'static str, f64),
    heights: HeightLimitsDocument,
    budget: Vec<BudgetLine>,
}

/// Buildings that are named for their heights, at most.
const MOST_NAMED: usize = 12;

/// Footprints that are rectangles.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
struct Rectangles {
    /// How many are.
    rectangles: usize,
    /// All of them.
    footprints: usize,
}

impl LimitsPlan {
    /// Reads a scene, and makes the map of some UAVs in several ways.
    ///
    /// # Errors
    /// As [`SceneOptions::open`]; E113 for numbers out of range; E2xx for UAVs that cannot be there.
    pub(crate) fn find(
        &self,
        (options, word): (&SceneOptions, &OsStr),
        asked: &UavsAsked,
        command: Vec<String>,
    ) -> Result<Limits> {
        for (what, value) in
            [("the error of the UAVs", self.uav_error_m), ("the error of the heights", self.height_error_m)]
        {
            if !(0.0..=1000.0).contains(&value) {
                return Err(Error::number(what, value, "0 to 1000 m"));
            }
        }
        let (start, mut warnings) = (Instant::now(), Vec::new());
        let city = options.read(word, &mut warnings)?;
        let rectangles = match &city.solids {
            Solids::Vector { footprints, .. } => {
                let rectangles = footprints.iter().filter(|f| f.is_rectangle()).count();
                Some(Rectangles { rectangles, footprints: footprints.len() })
            }
            Solids::Raster { .. } => None,
        };
        let mut scene = Scene::built(options, (word, city), warnings, start)?;
        let sight = &self.sight;
        let found = asked.read(scene.grid())?;
        let uavs = scene.place(&found, None, sight)?;
        let (field, built_up) = (std::sync::Arc::clone(&scene.field), scene.built_up);
        let options_over = |field: &HeightField| {
            let zones = sight.receivers().zone().and_then(|_| ZoneMap::if_known(field, built_up.as_ref()));
            sight.options(field.grid(), zones.as_ref())
        };
        let setup = Setup { field: &field, uavs: &uavs, options: &options_over };
        let own = options_over(&field);
        let mut mapper = Mapper::new(&field, &own)?;
        let (method, why) = mapper.method();
        let idle = mapper.drop_idle(&uavs);
        let (receivers, los) =
            uavs.iter().map(|uav| mapper.count(uav)).fold((0, 0), |sum, c| (sum.0 + c.0, sum.1 + c.1));
        drop(mapper);
        #[expect(clippy::cast_precision_loss, reason = "counts of cells")]
        let (in_range, p_los) = (receivers as f64, (receivers > 0).then(|| los as f64 / receivers as f64));
        let threads = (method, rayon::current_num_threads());
        let expected = Expected::of(
            threads,
            (field.grid().n_cells(), in_range / uavs.len() as f64),
            (uavs.len(), HeightLayers::default()),
            1,
        );
        let heights = self.heights(&scene, options, &own, &uavs)?;
        let meters_per_unit = field.grid().meters_per_unit();
        let uncertain = Uncertain { uav_m: self.uav_error_m, roofs_m: self.height_error_m, meters_per_unit };
        let budget = match p_los {
            Some(p_los) => error_budget(&setup, p_los, &uncertain, &self.other_cities(options, &scene)?)?,
            None => Vec::new(),
        };
        Ok(Limits {
            p_los,
            receivers,
            cell_m: field.grid().cell_width() * meters_per_unit,
            cells: cell_effects(&setup),
            terrain: terrain_effect(&setup)?,
            roofs: roof_effect(&setup).map_err(|e| e.to_string()).transpose(),
            idle,
            rectangles,
            engine: (why, expected.seconds()),
            heights,
            budget,
            sight: *sight,
            facts: RunFacts { command, ..scene.facts(Some(method)) },
        })
    }

    /// What hangs on heights of buildings.
    fn heights(
        &self,
        scene: &Scene,
        options: &SceneOptions,
        own: &MapOptions,
        uavs: &[Uav],
    ) -> Result<HeightLimitsDocument> {
        let field = &scene.field;
        let mapper = Mapper::new(field, own)?;
        let (mut receivers, mut possibly) = (0, 0);
        let mut by_building = vec![0_u64; field.n_buildings()];
        for uav in uavs {
            let of = mapper.deciding(uav, self.height_error_m, &Control::default())?;
            receivers += of.receivers;
            possibly += of.possibly;
            by_building.iter_mut().zip(&of.by_building).for_each(|(sum, n)| *sum += n);
        }
        let mut named: Vec<(u64, u32)> = by_building.into_iter().zip(0..).filter(|(n, _)| *n > 0).collect();
        named.sort_unstable_by_key(|(n, building)| (std::cmp::Reverse(*n), *building));
        let document = |(receivers, building): &(u64, u32)| DecidingBuilding {
            id: field.building_id(*building).to_string(),
            receivers: *receivers,
        };
        Ok(HeightLimitsDocument {
            error_m: self.height_error_m,
            receivers,
            possibly,
            buildings: named.iter().take(MOST_NAMED).map(document).collect(),
            typical: typical_errors(scene, options),
        })
    }

    /// Cities of the same kind by other seeds, for a generated scene.
    fn other_cities(&self, options: &SceneOptions, scene: &Scene) -> Result<Vec<HeightField>> {
        let Some(built_up) = scene.built_up else { return Ok(Vec::new()) };
        let of = |k: u64| {
            let other = SceneOptions { seed: Some(options.seed_of_all().wrapping_add(k)), ..options.clone() };
            let city = other.city(built_up).city()?;
            Ok(HeightField::build(&city.grid, city.solids).field)
        };
        (1..=u64::from(self.n_cities)).map(of).collect()
    }
}

impl Limits {
    fn coarsest(&self) -> Option<Simpler> {
        coarsest_unchanged(&self.cells, self.p_los?)
    }
}

impl Answer for Limits {
    fn is_in_words(&self) -> bool {
        true
    }

    fn document(&self, _: Option<Spent>) -> Value {
        let cell = |e: &CellEffect| CellDocument {
            #[expect(clippy::cast_precision_loss, reason = "a small factor")]
            cell_m: self.cell_m * e.form.factor as f64,
            pooling: e.form.pooling.map(|p| p.name()),
            p_los: e.p_los.as_ref().ok().copied(),
            change: e.p_los.as_ref().ok().zip(self.p_los).map(|(p, own)| p - own),
            reason: e.p_los.as_ref().err().cloned(),
        };
        document_of(&LimitsDocument {
            head: self.facts.head("skyshed/limits/1"),
            sight: self.sight.facts(),
            p_los: self.p_los,
            receivers: self.receivers,
            cells: self.cells.iter().map(cell).collect(),
            coarsest_unchanged: self.coarsest().map(|form| form.in_words(self.cell_m)),
            unchanged_below: NO_CHANGE,
            terrain: match self.terrain {
                TerrainEffect::None => None,
                TerrainEffect::Hides { hidden, receivers } => Some(TerrainDocument { hidden, receivers }),
            },
            footprints: (self.idle.footprints > 0).then(|| IdleDocument::of(&self.idle)),
            rectangles: self.rectangles,
            roofs: self.roofs.as_ref().map(RoofDocument::of),
            why: self.engine.0,
            expected_s: self.engine.1,
            heights: self.heights.clone(),
            budget: self.budget.iter().map(LineDocument::of).collect(),
            warnings: warnings_of(&self.facts.warnings),
        })
    }

    fn table(&self) -> Rows {
        let row = |line: &BudgetLine| {
            let LineDocument { part, changed, p_los_change, reason } = LineDocument::of(line);
            LimitRow { part, changed, p_los: self.p_los, p_los_change, reason }
        };
        rows(self.budget.iter().map(row))
    }

    fn warnings(&self) -> &[Warning] {
        &self.facts.warnings
    }

    fn text(&self, _: &Look) -> Result<String> {
        let Some(p_los) = self.p_los else { return Ok("map        no receiver in range\n".into()) };
        let ((why, seconds), method) = (&self.engine, self.facts.method_name());
        let mut text = format!("map        P_LoS {p_los:.4} of {} receivers\n", grouped(self.receivers));
        let time = if *seconds < 0.1 { "less than 0.1 s".into() } else { format!("about {seconds:.1} s") };
        text += &format!("method     auto takes {method} ({why}): {time} of line of sight\n");
        text += &match self.coarsest() {
            Some(form) => {
                format!("cells      {} would do: P_LoS changes by less than 0.1 %\n", form.in_words(self.cell_m))
            }
            None => {
                format!("cells      {} m are needed: any coarser, P_LoS changes by 0.1 % or more\n", tidy(self.cell_m))
            }
        };
        text += &match self.terrain {
            TerrainEffect::None => "terrain    flat, or not known apart from the surface\n".to_string(),
            TerrainEffect::Hides { hidden: 0, .. } => "terrain    hides no receiver: only buildings do\n".to_string(),
            TerrainEffect::Hides { hidden, receivers } => {
                format!("terrain    hides {} of {} receivers by itself\n", grouped(hidden), grouped(receivers))
            }
        };
        if let Some(r) = self.rectangles {
            text += &format!(
                "outlines   {} of {} footprints are rectangles\n",
                grouped(r.rectangles as u64),
                grouped(r.footprints as u64)
            );
        }
        text += &self.roofs.as_ref().map_or(String::new(), |roofs| roofs_in_words(roofs, p_los));
        if self.idle.footprints > 0 {
            text += &format!("footprints {}\n", idle_in_words(&self.idle));
        }
        text += &self.heights.text();
        text += "\nWhat limits P_LoS, the largest first:\n";
        let width = self.budget.iter().map(|line| line.part.name().len()).max().unwrap_or(0);
        for line in &self.budget {
            let change = match &line.change {
                Ok(change) => format!("{change:+.5}"),
                Err(_) => "unknown".into(),
            };
            let why = line.change.as_ref().err().map_or(String::new(), |why| format!(": {why}"));
            text += &format!("  {:<width$}  {change:<9} {}{why}\n", line.part.name(), line.changed);
        }
        Ok(text)
    }

    fn add(&self, _: &mut Batch, _: &Path, _: Format, _: &Look) -> Result<()> {
        Ok(())
    }
}

/// How far heights of a scene are off, typically, by where they come from; nothing of a generated one.
fn typical_errors(scene: &Scene, options: &SceneOptions) -> Option<&'static str> {
    match (scene.built_up, scene.field.prisms()) {
        (Some(_), _) => None,
        (None, None) => Some("0.3 to 1 m for a laser scan"),
        (None, Some(_)) if options.missing == Some(MissingHeight::Levels) => {
            Some("2 m where heights are 3 m to a level, 0.3 to 1 m where they were measured")
        }
        (None, Some(_)) => Some("0.3 to 1 m where they were measured, 4 m for a global product"),
    }
}

/// What hangs on heights of buildings.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub(crate) struct HeightLimitsDocument {
    /// How far the height of each building may be off [m].
    error_m: f64,
    /// Receivers in range of all UAVs, counted together.
    receivers: u64,
    /// Those that are in line of sight for some of these heights and not for others.
    possibly: u64,
    /// The buildings of footprints whose heights decide about the most receivers, each alone: those to measure first.
    buildings: Vec<DecidingBuilding>,
    /// How far such heights are off, typically; null for a generated city.
    typical: Option<&'static str>,
}

/// A building whose height decides about receivers.
#[derive(Debug, Clone, Serialize, JsonSchema)]
struct DecidingBuilding {
    /// Its id.
    id: String,
    /// Receivers whose answer its height alone turns.
    receivers: u64,
}

impl HeightLimitsDocument {
    /// Lines of the answer.
    fn text(&self) -> String {
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
    head: Head,
    #[serde(flatten)]
    sight: SightFacts,
    /// Share of receivers in line of sight; null without a receiver.
    p_los: Option<f64>,
    /// Receivers in range of all UAVs, counted together.
    receivers: u64,
    /// P_LoS on coarser cells.
    cells: Vec<CellDocument>,
    /// The coarsest cells on which P_LoS hardly changes, in words.
    coarsest_unchanged: Option<String>,
    /// Changes of P_LoS below this are none.
    unchanged_below: f64,
    /// What terrain hides by itself; null where it is flat or not known.
    terrain: Option<TerrainDocument>,
    /// Footprints that can hide no receiver.
    footprints: Option<IdleDocument>,
    /// Footprints that are rectangles.
    rectangles: Option<Rectangles>,
    /// What flat roofs, each as high as it is highest, would change; null where all are flat.
    roofs: Option<RoofDocument>,
    /// Why the engine is taken.
    why: &'static str,
    /// How long line of sight is expected to take [s].
    expected_s: f64,
    /// What hangs on heights of buildings.
    heights: HeightLimitsDocument,
    /// What limits P_LoS, the largest first.
    budget: Vec<LineDocument>,
    /// What was odd.
    warnings: Vec<WarningFacts>,
}

/// What flat roofs would change.
#[derive(Debug, Serialize, JsonSchema)]
struct RoofDocument {
    /// Buildings whose roofs are not flat.
    shaped: Option<usize>,
    /// Receivers whose answers they turn.
    turned: Option<u64>,
    /// Receivers of both forms.
    receivers: Option<u64>,
    /// P_LoS with them.
    p_los: Option<f64>,
    /// Why that is not known.
    reason: Option<String>,
}

impl RoofDocument {
    fn of(roofs: &std::result::Result<RoofEffect, String>) -> Self {
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
fn roofs_in_words(roofs: &std::result::Result<RoofEffect, String>, p_los: f64) -> String {
    match roofs {
        Err(why) => format!("roofs      what flat ones would change is not known: {why}\n"),
        Ok(RoofEffect { shaped, turned, receivers, p_los: of_flat }) => {
            let change = of_flat.map_or(String::new(), |flat| format!(", P_LoS by {:+.4}", flat - p_los));
            let (shaped, share) =
                (counted(*shaped as u64, "building is", "buildings are"), percent(*turned, *receivers));
            format!("roofs      of {shaped} not flat: flat ones would turn {share} of receivers{change}\n")
        }
    }
}

/// P_LoS on other cells.
#[derive(Debug, Serialize, JsonSchema)]
struct CellDocument {
    /// Width of a cell [m].
    cell_m: f64,
    /// Height of a larger cell among those of the cells in it.
    pooling: Option<&'static str>,
    /// P_LoS on them.
    p_los: Option<f64>,
    /// Its P_LoS less that of the scene itself.
    change: Option<f64>,
    /// Why there is none.
    reason: Option<String>,
}

/// What terrain hides by itself.
#[derive(Debug, Serialize, JsonSchema)]
struct TerrainDocument {
    /// Receivers that it hides.
    hidden: u64,
    /// All receivers.
    receivers: u64,
}

/// Something that limits P_LoS.
#[derive(Debug, Serialize, JsonSchema)]
struct LineDocument {
    /// What is not known exactly.
    part: &'static str,
    /// What was changed to find out.
    changed: String,
    /// How much P_LoS changes.
    p_los_change: Option<f64>,
    /// Why that is not known.
    reason: Option<String>,
}

impl LineDocument {
    fn of(line: &BudgetLine) -> Self {
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
    part: &'static str,
    /// What was changed to find out.
    changed: String,
    /// P_LoS of the scene itself.
    p_los: Option<f64>,
    /// How much it changes.
    p_los_change: Option<f64>,
    /// Why that is not known.
    reason: Option<String>,
}
