//! Contestants on a scene: each is prepared, timed and compared with the exact answer.

use super::measure::{measured, memory_floor};
use super::report::{ChartReport, ChartRow, Cost};
use super::{Chart, ChartPlan, Contest, in_turns, peers};
use crate::accuracy::chart::{Contestant, Family, MOST_RAYS, Truth};
use crate::accuracy::comparison::Comparison;
use crate::answer::{CommandFacts, RunFacts};
use crate::coverage::{MapOptions, Uav};
use crate::error::{OddRun, RequestError, Result};
use crate::los::Method;
use crate::memory::Needs;
use crate::progress::Progress;
use crate::quantity::{counted, signed};
use crate::render::grouped;
use crate::scene::Scene;
use crate::sight::warn_of_nodata;
use crate::uav::UavsFound;

impl ChartPlan {
    /// Runs all contestants for some UAVs over a scene.
    ///
    /// # Errors
    /// E116 for receivers in a zone; E2xx for UAVs that cannot be there; E501, E503; E603 if two
    /// exact engines differ.
    pub(crate) fn run(
        &self,
        mut scene: Scene,
        found: &UavsFound,
        command: CommandFacts,
        progress: &Progress,
    ) -> Result<Chart> {
        self.check()?;
        let receivers = self.sight.receivers();
        if receivers.zone().is_some() {
            return Err(RequestError::CoarseZones(receivers.name()).into());
        }
        let uavs = scene.place(found, None, &self.sight)?;
        Needs::of_chart(uavs.len()).check(&scene)?;
        let options = self.sight.options(scene.grid(), None);
        let contestants = Contestant::all(&scene.field, self.sight.method())?;
        let truth = Truth::of(&scene.field, &uavs, &options, MOST_RAYS)?;
        if truth.receivers() == 0 {
            scene.warnings.push(OddRun::NoReceivers.into());
        }
        let is_over_nodata = warn_of_nodata(&uavs, &mut scene.warnings);
        let planned = contestants.len() + usize::from(self.peers);
        let all = counted(truth.receivers(), "receiver", "receivers");
        let to_come = counted(planned as u64, "contestant", "contestants");
        (progress.note)(&format!("{all} decided exactly by {}; {to_come} to come", truth.method));
        (progress.begin_pieces)();
        let arena = Arena { plan: self, scene: &scene, uavs: &uavs, options: &options, truth: &truth, progress };
        let (floor, rows) = arena.run(&contestants)?;
        let report = ChartReport {
            facts: RunFacts { command, ..scene.facts(Some(truth.method)) },
            sight: self.sight,
            uavs: uavs.iter().map(|uav| (uav.clone(), found.lonlat_of(&uav.id))).collect(),
            truth,
            is_over_nodata,
            threads: self.threads,
            floor,
            rows,
            planned,
        };
        Ok(Chart { contest: Contest::Scene(Box::new((scene, report))) })
    }
}

/// Inputs that all contestants share.
struct Arena<'a> {
    plan: &'a ChartPlan,
    scene: &'a Scene,
    uavs: &'a [Uav],
    options: &'a MapOptions,
    truth: &'a Truth,
    progress: &'a Progress,
}

impl Arena<'_> {
    /// Returns the memory floor, and the results of all contestants until the user interrupts.
    fn run(&self, contestants: &[Contestant]) -> Result<(Cost, Vec<ChartRow>)> {
        let n_planned = contestants.len() + usize::from(self.plan.peers);
        in_turns(self.plan.threads, n_planned, self.progress, || {
            let floor = memory_floor(self.scene.grid().n_cells(), self.plan.time_s, self.progress);
            // A map of several UAVs reads and writes everything once for each.
            let n = self.uavs.len() as f64;
            let floor = Cost { cpu_s: floor.cpu_s.map(|cpu| cpu * n), wall_s: floor.wall_s * n, ..floor };
            let mut rows = Vec::new();
            let turns = contestants.iter().map(Some).chain(self.plan.peers.then_some(None));
            for turn in turns {
                if self.progress.is_stopped() {
                    break;
                }
                rows.push(match turn {
                    Some(contestant) => self.row(contestant),
                    None => self.peer(),
                });
                self.progress.advance();
            }
            (floor, rows)
        })
    }

    fn row(&self, contestant: &Contestant) -> ChartRow {
        let result = self.result(contestant);
        // Other cells may need another exact engine.
        let method = result.as_ref().map_or(contestant.method, |(method, ..)| *method);
        ChartRow {
            method: method.to_string(),
            parameters: contestant.parameters(),
            label: contestant.label(),
            family: contestant.family(),
            result: result.map(|(_, cost, counts)| (cost, counts)),
        }
    }

    /// Returns the engine in use, its cost and its counts, or the reason for having none.
    fn result(&self, contestant: &Contestant) -> std::result::Result<(Method, Cost, Comparison), String> {
        if let (Method::Ray, Some(checked)) = (contestant.method, self.truth.checked) {
            let n = self.truth.receivers();
            return Err(format!(
                "not run: {n} rays take too long; on a sample of {checked} it agrees with {}",
                self.truth.method
            ));
        }
        let prepared = contestant.prepare(&self.scene.field, self.uavs, self.options).map_err(|e| e.to_string())?;
        let mapper = prepared.mapper().map_err(|e| e.to_string())?;
        let (answer, cost) = measured(self.plan.time_s, self.progress, || prepared.answer(&mapper));
        let answer = answer.map_err(|e| e.to_string())?;
        Ok((mapper.method().0, cost, self.truth.compare(&answer, contestant.ground.factor())))
    }

    fn peer(&self) -> ChartRow {
        let rx_height_m = self.plan.sight.rx_height_m();
        let (parameters, result) =
            match peers::gdal_viewshed(&self.scene.field, self.uavs, rx_height_m, self.truth, self.progress) {
                Ok((version, answer, cost)) => (version, Ok((cost, self.truth.compare(&answer, 1)))),
                Err(reason) => (String::new(), Err(reason)),
            };
        let name = "gdal_viewshed".to_string();
        ChartRow { method: name.clone(), parameters, label: name, family: Family::Peer, result }
    }
}

/// Returns a row in words.
pub(super) fn in_words(row: &ChartRow, report: &ChartReport) -> String {
    let (cost, counts) = match &row.result {
        Ok(result) => result,
        Err(reason) => return format!("{}: {reason}", row.label),
    };
    let time = row.place().map_or_else(
        || format!("{:.3} ms wall time", 1e3 * cost.wall_s),
        |(cpu_ns, _)| format!("{cpu_ns:.2} ns of CPU time per receiver"),
    );
    let bias = report.truth.p_los_error(counts).map_or("undefined".to_string(), |error| signed(error, 5));
    let (wrong, all) = (grouped(counts.wrong()), grouped(counts.receivers));
    format!("{}: {time}, {wrong} of {all} receivers wrong, P_LoS error {bias}", row.label)
}
