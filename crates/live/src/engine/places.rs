//! Facts about a place: a cell, and the link to its receiver.

use skyshed_core::coverage::{ExplainedLink, ObstacleKind, ProfileStep, SceneView, StepKind, Uav, place_receiver};
use skyshed_core::error::Result;
use skyshed_core::height_field::{CellKind, Station};
use skyshed_core::quantity::{Height, VOID, meters};
use skyshed_core::zones::Zone;
use skyshed_request::Receivers;

use super::Engine;
use crate::answers::{CellFacts, End, False, LinkFacts, Obstruction, Step, True};

impl Engine {
    pub(super) fn cell(&self, x: f64, y: f64, which: usize) -> CellFacts {
        let grid = self.field.grid();
        let Some((row, col)) = grid.cell_at(x, y) else {
            let (ground_m, roof_m, zone, margin_m) = (None, None, None, None);
            let sees = Vec::new();
            return CellFacts { inside: false, row: 0, col: 0, ground_m, roof_m, kind: "void", zone, sees, margin_m };
        };
        let index = row * grid.n_cols() + col;
        let place = self.field.positions().center(row, col);
        let ground = self.field.ground_at(&place);
        let (kind, roof_m) = match self.field.cell_kind(index, &place) {
            CellKind::Open(_) => ("open", None),
            CellKind::Building(roof) => ("building", Some(meters(roof))),
            CellKind::Void => ("void", None),
        };
        let sees = self.maps.iter().map(|map| {
            let seen = &map.found.as_ref().ok()?.seen;
            seen.receivers.contains(row, col).then(|| seen.los.contains(row, col))
        });
        let sees: Vec<Option<bool>> = sees.collect();
        let is_asked = sees.get(which).is_some_and(Option::is_some);
        let margin = || {
            let receiver = self.receiver_at(row, col).ok()?;
            self.seen_link(&self.found(which).ok()?.uav, &receiver).ok()?.0.margin_m
        };
        CellFacts {
            inside: true,
            row,
            col,
            ground_m: (ground != VOID).then(|| meters(ground)),
            roof_m,
            kind,
            zone: self.zones.as_ref().and_then(|zones| zones.map.of_cell(row, col)).map(Zone::name),
            sees,
            margin_m: if is_asked { margin() } else { None },
        }
    }

    /// Returns the receiver of a cell; in a building, on its roof.
    fn receiver_at(&self, row: usize, col: usize) -> std::result::Result<Station, String> {
        let (x, y) = self.field.grid().world_from_cell(row, col);
        let height_m = self.sight.sight.receiver.rx_height_m();
        let is_building = self.field.cells().building.contains(row, col);
        let is_on_roof = is_building && self.sight.receivers() != Receivers::Air;
        let height = if is_on_roof { Height::roof(height_m) } else { Height::agl(height_m) };
        place_receiver(self.field, (x, y), height).map_err(|why| why.to_string())
    }

    /// Returns the kind of an obstacle in a word, and its name.
    pub(super) fn named(&self, kind: ObstacleKind) -> (&'static str, Option<String>) {
        let of_cell = |(row, col): (usize, usize)| Some(format!("{row}, {col}"));
        match kind {
            ObstacleKind::Building(k) => ("building", Some(self.field.building_id(k).to_string())),
            ObstacleKind::Terrain(cell) => ("terrain", of_cell(cell)),
            ObstacleKind::Cell(cell) => ("cell", of_cell(cell)),
            ObstacleKind::Nodata(cell) => ("nodata", of_cell(cell)),
            ObstacleKind::Horizon => ("horizon", None),
        }
    }

    /// Returns a link, its side view and its receiver, at the heights at which the UAV sees them.
    /// Over a curved earth these are lower than the true heights.
    fn seen_link(&self, uav: &Uav, receiver: &Station) -> Result<(ExplainedLink, Vec<ProfileStep>, Station)> {
        let view = SceneView::of(self.field, uav, self.sight.curvature())?;
        let mut found = view.link(receiver);
        if let Some(obstacle) = &mut found.obstruction {
            let fall_m = meters(view.drop_at(&self.field.place(obstacle.x, obstacle.y)));
            obstacle.ray_height_m -= fall_m;
            obstacle.top_m = obstacle.top_m.map(|top_m| top_m - fall_m);
        }
        let steps = view.profile(receiver, found.distance_m);
        Ok((found, steps, view.seen(receiver)))
    }

    pub(super) fn link(&self, which: usize, x: f64, y: f64) -> LinkFacts {
        let ends = || {
            let (row, col) = self.field.grid().cell_at(x, y).ok_or("outside of the scene")?;
            Ok((&self.found(which)?.uav, self.receiver_at(row, col)?))
        };
        let (uav, receiver) = match ends() {
            Ok(ends) => ends,
            Err(words) => return LinkFacts::Refused { ok: False, words },
        };
        let (found, steps, receiver) = match self.seen_link(uav, &receiver) {
            Ok(seen) => seen,
            Err(why) => return LinkFacts::Refused { ok: False, words: why.to_string() },
        };
        let end = |at: &Station| {
            let amsl_m = i32::try_from(at.z).map_or(f64::NAN, meters);
            End { x: at.place.x, y: at.place.y, amsl_m }
        };
        LinkFacts::Found {
            ok: True,
            los: found.los,
            margin_m: found.margin_m,
            distance_m: found.distance_m,
            elevation_deg: found.elevation_deg,
            uav: end(&uav.station),
            receiver: end(&receiver),
            obstruction: found.obstruction.map(|obstacle| {
                let (kind, name) = self.named(obstacle.kind);
                let (x, y, ray_height_m) = (obstacle.x, obstacle.y, obstacle.ray_height_m);
                Obstruction { kind, name, x, y, ray_height_m, roof_height_m: obstacle.top_m }
            }),
            steps: steps
                .into_iter()
                .map(|step| Step {
                    from_m: step.from_m,
                    to_m: step.to_m,
                    heights_m: step.heights_m,
                    kind: if step.kind == StepKind::Terrain { "terrain" } else { "building" },
                })
                .collect(),
        }
    }
}
