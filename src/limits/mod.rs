//! Limits of a map: the coarsest sufficient cells, the effect of terrain, footprints that hide no
//! receiver, and the error of P_LoS if UAVs or heights are off.

mod document;

use std::ffi::OsStr;
use std::path::Path;

use serde_json::Value;

use crate::accuracy::{
    BudgetLine, CellEffect, NO_CHANGE, RoofEffect, Setup, Simpler, TerrainEffect, Uncertain, cell_effects,
    coarsest_unchanged, error_budget, roof_effect, terrain_effect,
};
use crate::answer::{Answer, CommandFacts, Rows, RunFacts, Spent, document_of, rows, warnings_of};
use crate::coverage::{Control, HeightLayers, IdleFootprints, MapOptions, Mapper, Uav};
use crate::error::{Error, Result, Warning};
use crate::expected::Expected;
use crate::export::{Batch, Format};
use crate::height_field::HeightField;
use crate::map::IdleDocument;
use crate::memory::Needs;
use crate::picture::Look;
use crate::quantity::{signed, tidy};
use crate::render::grouped;
use crate::scene::{Scene, SceneReader};
use crate::sight::{SightPlan, warn_of_nodata};
use crate::uav::{UavsAsked, UavsFound};
use crate::words::idle_in_words;
use document::{
    CellDocument, DecidingBuilding, HeightLimitsDocument, LineDocument, Rectangles, RoofDocument, TerrainDocument,
    roofs_in_words,
};
pub(crate) use document::{LimitRow, LimitsDocument};
use skyshed_request::{LimitsOptions, MissingHeights, SetSceneOptions, Sight, filled};

/// Output formats of `limits`.
pub(crate) const FORMATS: [Format; 3] = [Format::Csv, Format::Json, Format::Stdout];

/// Receivers of the map, and errors of the inputs.
#[derive(Debug)]
pub(crate) struct LimitsPlan {
    pub(crate) sight: SightPlan,
    /// Largest error of the position of UAVs, sideways and in height \[m\].
    pub(crate) uav_error_m: f64,
    /// Largest error of the heights of all buildings \[m\].
    pub(crate) height_error_m: f64,
    /// Number of further generated cities, which show how much the choice of one city matters.
    pub(crate) n_cities: u16,
    /// `true` if that number was requested.
    are_cities_set: bool,
}

/// Limits of a map.
#[derive(Debug)]
pub(crate) struct Limits {
    facts: RunFacts,
    sight: SightPlan,
    p_los: Option<f64>,
    receivers: u64,
    cell_m: f64,
    cells: Vec<CellEffect>,
    terrain: TerrainEffect,
    idle: IdleFootprints,
    rectangles: Option<Rectangles>,
    /// Effect of flat roofs, or the reason why it is unknown; `None` if all roofs are flat.
    roofs: Option<std::result::Result<RoofEffect, String>>,
    /// Reason for the choice of the engine by `auto`, and its expected time \[s\].
    engine: (&'static str, f64),
    heights: HeightLimitsDocument,
    budget: Vec<BudgetLine>,
}

/// Most buildings that are listed for their heights.
const MOST_NAMED: usize = 12;

impl LimitsPlan {
    /// Fills in the defaults of a question.
    ///
    /// # Errors
    /// E113.
    pub(crate) fn of(sight: &Sight, limits: &LimitsOptions) -> Result<LimitsPlan> {
        let defaults = LimitsOptions::defaults();
        Ok(LimitsPlan {
            sight: SightPlan::of(sight)?,
            uav_error_m: filled(limits.uav_error, defaults.uav_error),
            height_error_m: filled(limits.height_error, defaults.height_error),
            n_cities: filled(limits.cities, defaults.cities),
            are_cities_set: limits.cities.is_some(),
        })
    }

    /// Reads a scene and maps some UAVs in several ways.
    ///
    /// # Errors
    /// As [`SceneReader::open`]; E113 for numbers out of range; E2xx for UAVs that cannot be there.
    pub(crate) fn find(
        &self,
        (options, word): (&SceneReader, &OsStr),
        asked: &UavsAsked,
        command: CommandFacts,
    ) -> Result<Limits> {
        self.check()?;
        let scene = options.clone().keeps_footprints().open(word)?;
        let found = asked.read(scene.grid())?;
        self.find_over(scene, &found, command)
    }

    /// Checks the numbers, before any work.
    ///
    /// # Errors
    /// E113.
    fn check(&self) -> Result<()> {
        for (what, value) in
            [("the error of the UAVs", self.uav_error_m), ("the error of the heights", self.height_error_m)]
        {
            if !(0.0..=1000.0).contains(&value) {
                return Err(Error::number(what, value, "0 to 1000 m"));
            }
        }
        Ok(())
    }

    /// Maps some UAVs over a scene in several ways. Rectangles are counted where the scene keeps its
    /// footprints.
    ///
    /// # Errors
    /// E113 for numbers out of range; E2xx for UAVs that cannot be there.
    pub(crate) fn find_over(&self, mut scene: Scene, found: &UavsFound, command: CommandFacts) -> Result<Limits> {
        self.check()?;
        if self.are_cities_set && scene.built_up.is_none() {
            return Err(Error::idle("cities", "for a city in a file: it is one"));
        }
        let sight = &self.sight;
        let uavs = scene.place(found, None, sight)?;
        Needs::LIMITS.check(&scene)?;
        let (field, built_up) = (std::sync::Arc::clone(&scene.field), scene.built_up);
        let options_over = |field: &HeightField| Ok(sight.options_over(field, built_up.as_ref())?);
        let setup = Setup { field: &field, uavs: &uavs, options: &options_over };
        let own = options_over(&field)?;
        let mut mapper = Mapper::new(&field, &own)?;
        let (method, why) = mapper.method();
        let idle = mapper.drop_idle(&uavs);
        let (mut receivers, mut los) = (0, 0);
        for uav in &uavs {
            let of = mapper.seen_from(uav)?.count();
            (receivers, los) = (receivers + of.0, los + of.1);
        }
        drop(mapper);
        #[expect(clippy::cast_precision_loss, reason = "counts of cells")]
        let (in_range, share) = (receivers as f64, (receivers > 0).then(|| los as f64 / receivers as f64));
        let is_over_nodata = warn_of_nodata(&uavs, &mut scene.warnings);
        let p_los = share.filter(|_| !is_over_nodata);
        let threads = (method, rayon::current_num_threads());
        let expected = Expected::of(
            threads,
            (field.grid().n_cells(), in_range / uavs.len() as f64),
            (uavs.len(), HeightLayers::default()),
            1.0,
        );
        let heights = self.heights(&scene, &own, &uavs)?;
        let meters_per_unit = field.grid().meters_per_unit();
        let uncertain = Uncertain { uav_m: self.uav_error_m, roofs_m: self.height_error_m, meters_per_unit };
        let budget = match p_los {
            Some(p_los) => error_budget(&setup, p_los, &uncertain, &self.other_cities(&scene)?)?,
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
            rectangles: scene.solids.as_deref().and_then(Rectangles::of),
            engine: (why, expected.seconds()),
            heights,
            budget,
            sight: *sight,
            facts: RunFacts { command, ..scene.facts(Some(method)) },
        })
    }

    /// Returns the effect of errors of building heights.
    fn heights(&self, scene: &Scene, own: &MapOptions, uavs: &[Uav]) -> Result<HeightLimitsDocument> {
        let field = &scene.field;
        let mapper = Mapper::new(field, own)?;
        let (mut receivers, mut possibly) = (0, 0);
        let mut by_building = vec![0_u64; field.n_buildings()];
        for uav in uavs {
            let of = mapper.seen_from(uav)?.deciding(self.height_error_m, &Control::default())?;
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
            typical: typical_errors(scene),
        })
    }

    /// Builds cities of the same kind with other seeds; none unless the scene is generated.
    fn other_cities(&self, scene: &Scene) -> Result<Vec<HeightField>> {
        let Some(built_up) = scene.built_up else { return Ok(Vec::new()) };
        let options = &scene.options;
        let of = |k: u64| {
            let other = SceneReader::clone(options).seed(options.options.seed_or_default().wrapping_add(k));
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
                Ok(change) => signed(*change, 5),
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

/// Returns the typical error of a scene's heights by their source; `None` for a generated scene.
fn typical_errors(scene: &Scene) -> Option<&'static str> {
    match (scene.built_up, scene.field.prisms()) {
        (Some(_), _) => None,
        (None, None) => Some("0.3 to 1 m for a laser scan"),
        (None, Some(_)) if scene.options.options.missing.as_ref().is_some_and(MissingHeights::counts_storeys) => {
            Some("2 m where heights are 3 m to a level, 0.3 to 1 m where they were measured")
        }
        (None, Some(_)) => Some("0.3 to 1 m where they were measured, 4 m for a global product"),
    }
}
