//! Perturbation test of a scene: answers that change when the UAV or all roofs move by one lattice
//! step, and receivers near grazing.

use std::path::Path;
use std::time::Instant;

use serde_json::Value;

use skyshed_request::Layer;

use super::report::{NEAR_M, StressSceneReport};
use crate::answer::{Answer, CommandFacts, Rows, Spent};
use crate::error::{Result, Warning};
use crate::export::{Batch, Format};
use crate::height_errors::HeightErrorsPlan;
use crate::map::{Coverages, Held, MapDrawing, MapPlan, MapReport, PartOf};
use crate::memory::Needs;
use crate::picture::{Look, picture_provenance};
use crate::progress::Progress;
use crate::quantity::counted;
use crate::scene::Scene;
use crate::sight::SightPlan;
use crate::uav::UavsFound;

/// Most receivers whose margins are computed: each costs a walk.
const MARGIN_SAMPLE: usize = 65_536;

/// Stability of the answers on a scene.
#[derive(Debug)]
pub(crate) struct StressScene {
    map: Coverages,
    report: StressSceneReport,
}

impl StressScene {
    /// Maps a UAV over a scene, and over the scene with each of eight moves.
    ///
    /// # Errors
    /// As for a map.
    pub(crate) fn run(
        scene: Scene,
        found: &UavsFound,
        sight: SightPlan,
        command: CommandFacts,
        progress: &Progress,
    ) -> Result<StressScene> {
        let plan = MapPlan {
            sight,
            heights: HeightErrorsPlan::default(),
            layers: vec![Layer::Stability],
            tolerance: None,
            tells_zones: false,
            over_time: false,
        };
        Needs::STABILITY.check(&scene)?;
        let prepared = plan.prepare(scene, found, PartOf::default())?;
        let before_los = Instant::now();
        let held = Held { keeps_masks: true, ..Held::default() };
        let mut map = prepared.run(held, progress, |_| {}, |_| {})?;
        let margins = map.margin_sample(MARGIN_SAMPLE)?;
        map.scene.timing.los = before_los.elapsed().as_secs_f64();
        map.report.facts.command = command;
        let report = StressSceneReport { map: MapReport { idle: None, ..map.report.clone() }, margins };
        Ok(StressScene { map, report })
    }
}

impl Answer for StressScene {
    fn document(&self, spent: Option<Spent>) -> Value {
        self.report.document(spent.map(|spent| self.map.scene.timing.with(spent)))
    }

    fn table(&self) -> Rows {
        self.report.table()
    }

    fn warnings(&self) -> &[Warning] {
        &self.report.map.facts.warnings
    }

    /// Returns the changed answers and the receivers near grazing, line by line.
    fn notes(&self, spent: Spent) -> Vec<String> {
        let mut notes = Vec::new();
        for site in &self.report.map.sites {
            let (los, receivers) = (site.tally.los, site.tally.receivers);
            notes.push(format!("{los} of {} in line of sight", counted(receivers, "receiver", "receivers")));
            for (which, turned) in site.stability.iter().flat_map(|s| &s.moves) {
                let name = which.name().replace('_', " ");
                notes.push(match turned {
                    Ok(turned) => format!("{name} by a lattice step: {} gained, {} lost", turned.gained, turned.lost),
                    Err(reason) => format!("{name} by a lattice step: impossible, {reason}"),
                });
            }
            let turned = |n: u64| counted(n, "receiver is turned", "receivers are turned");
            notes.extend(site.stability.iter().map(|s| format!("{} by any of the eight moves", turned(s.cells))));
        }
        let sampled = self.report.margins.margins.len() as u64;
        let every = match self.report.margins.every {
            1 => String::new(),
            n => format!(", every {n}th receiver"),
        };
        let near = NEAR_M.into_iter().zip(self.report.near());
        notes.extend(near.map(|(reach, n)| format!("within {reach} m of grazing: {n} of {sampled}{every}")));
        notes.push(format!(
            "method {}: nine maps and the margins in {:.3} s of {:.2} s",
            self.report.map.facts.method_in_words(),
            self.map.scene.timing.los,
            spent.total
        ));
        notes
    }

    fn add(&self, batch: &mut Batch, path: &Path, format: Format, look: &Look) -> Result<()> {
        let drawing = MapDrawing { of: &self.map, look, counts: None, note: None };
        Ok(batch.add(path, &drawing.draw(format, &picture_provenance(&self.provenance()))?)?)
    }
}
