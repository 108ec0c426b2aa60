//! A leg of a track in exact stretches.

use super::super::explained_link::ObstacleKind;
use super::{TrackHeight, TrackState, TrackVertex};
use crate::height_field::{HeightField, Station};
use crate::los::{
    Leg, LegObstacle, LegPart, LegPlace, LegWindow, common_parts, ground_parts, hidden_parts, inside_parts,
    merged_parts,
};
use crate::quantity::{BLOCKS_ALL, VOID};

/// A leg of a track over a flat earth, and where there is no receiver on it.
#[derive(Debug, Clone)]
pub struct TrackLeg {
    /// Parts that are straight in space: all of it, or one for each height of the ground below.
    straight: Vec<Leg>,
    inside: Vec<LegPart>,
    nodata: Vec<LegPart>,
}

/// A stretch of a leg in one state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LegStretch {
    /// Fractions of the way along the leg at which it begins and ends.
    pub at: [f64; 2],
    /// The state.
    pub state: TrackState,
    /// Obstacle that hides most of it, if it is hidden from one UAV.
    pub obstacle: Option<LegObstacle>,
}

/// A part of a leg without line of sight of a UAV, or of all of several.
type Hidden = (LegPart, Option<LegObstacle>);

impl TrackLeg {
    /// Returns the leg between two vertices.
    pub fn between(field: &HeightField, ends: [&TrackVertex; 2]) -> TrackLeg {
        let places = ends.map(|end| field.place(end.position[0], end.position[1]));
        let grounds = ground_parts(field, &places[0], &places[1]);
        let of_nodata = grounds.iter().filter(|part| part.ground == VOID);
        let nodata = merged_parts(of_nodata.map(|part| part.window.part()).collect());
        let leg = |z: [i64; 2], window: LegWindow| Leg {
            from: Station { place: places[0], z: z[0] },
            to: Station { place: places[1], z: z[1] },
            window,
        };
        let straight = match ends.map(|end| end.height) {
            [TrackHeight::AboveDatum(a), TrackHeight::AboveDatum(b)] => vec![leg([a, b], LegWindow::WHOLE)],
            [TrackHeight::AboveGround(height), _] | [_, TrackHeight::AboveGround(height)] => {
                let known = grounds.iter().filter(|part| part.ground != VOID);
                known.map(|part| leg([i64::from(part.ground) + i64::from(height); 2], part.window)).collect()
            }
        };
        let inside = merged_parts(straight.iter().flat_map(|leg| inside_parts(field, leg)).collect());
        TrackLeg { straight, inside, nodata }
    }

    /// Returns the parts that are hidden from an observer, sorted; some may abut.
    pub fn hidden_from(&self, field: &HeightField, observer: &Station) -> Vec<(LegPart, Option<LegObstacle>)> {
        let hidden = self.straight.iter().flat_map(|leg| hidden_parts(field, observer, leg));
        hidden.map(|hidden| (hidden.part(), Some(hidden.obstacle))).collect()
    }

    /// Returns the parts that are hidden from all of several observers.
    pub fn hidden_from_all<'a>(of_each: impl IntoIterator<Item = &'a [Hidden]>) -> Vec<(LegPart, Option<LegObstacle>)> {
        let parts = |hidden: &'a [Hidden]| merged_parts(hidden.iter().map(|(part, _)| *part).collect());
        let of_each: Vec<Vec<LegPart>> = of_each.into_iter().map(parts).collect();
        common_parts(of_each.iter().map(Vec::as_slice)).into_iter().map(|part| (part, None)).collect()
    }

    /// Returns the stretches of the leg, which cover it, with its hidden parts.
    pub fn stretches(&self, hidden: &[(LegPart, Option<LegObstacle>)]) -> Vec<LegStretch> {
        let parts = || hidden.iter().map(|(part, _)| part).chain(&self.inside).chain(&self.nodata);
        let mut ends: Vec<LegPlace> = parts().flat_map(|part| [part.from, part.to]).collect();
        ends.extend([LegPlace::START, LegPlace::END]);
        ends.sort_unstable();
        ends.dedup();
        let mut stretches: Vec<LegStretch> = Vec::new();
        // Longest part that the obstacle of the last stretch hides.
        let mut longest = 0.0;
        for pair in ends.windows(2) {
            let part = LegPart { from: pair[0], to: pair[1] };
            let (state, obstacle) = self.state_in(&part, hidden);
            let at = [part.from.fraction(), part.to.fraction()];
            match stretches.last_mut().filter(|last| last.state == state) {
                Some(last) => {
                    last.at[1] = at[1];
                    if part.length() > longest {
                        (last.obstacle, longest) = (obstacle, part.length());
                    }
                }
                // A part so short that its ends are told as one place has no state.
                None if at[0] < at[1] => {
                    longest = part.length();
                    stretches.push(LegStretch { at, state, obstacle });
                }
                None => {}
            }
        }
        stretches
    }

    /// Returns the state in a part between two ends of parts, and what hides it.
    fn state_in(&self, part: &LegPart, hidden: &[Hidden]) -> (TrackState, Option<LegObstacle>) {
        let is_in = |parts: &[LegPart]| within(parts, part, |of| *of).is_some();
        match within(hidden, part, |(of, _)| *of) {
            _ if is_in(&self.nodata) => (TrackState::Nodata, None),
            _ if is_in(&self.inside) => (TrackState::Inside, None),
            Some((_, obstacle)) => (TrackState::Nlos, *obstacle),
            None => (TrackState::Los, None),
        }
    }
}

/// Returns the one of several sorted, disjoint parts that holds another part.
fn within<'a, T>(parts: &'a [T], part: &LegPart, of: impl Fn(&T) -> LegPart) -> Option<&'a T> {
    let next = parts.partition_point(|other| of(other).from <= part.from);
    parts[..next].last().filter(|other| of(other).to >= part.to)
}

impl HeightField {
    /// Returns the kind of an obstacle of a leg over this scene, and the middle of its piece or cell \[CRS units\].
    pub fn leg_obstacle(&self, obstacle: LegObstacle) -> Option<(ObstacleKind, [f64; 2])> {
        match (obstacle, self.prisms(), self.columns()) {
            (LegObstacle::Piece(index), Some(prisms), _) => {
                let piece = &prisms.pieces()[index];
                let ring = prisms.ring(piece);
                #[expect(clippy::cast_precision_loss, reason = "a ring has few corners")]
                let n = ring.len() as f64;
                let middle = |k: usize| ring.iter().map(|corner| f64::from(corner[k])).sum::<f64>() / n;
                let frame = self.prisms_frame()?;
                let (x, y) = frame.world_from_lattice(middle(0), middle(1));
                Some((ObstacleKind::Building(piece.building), [x, y]))
            }
            (LegObstacle::Cell(index), prisms, Some(columns)) => {
                let cell = (index / columns.n_cols(), index % columns.n_cols());
                let (x, y) = columns.center(cell.0, cell.1);
                let frame = self.columns_frame()?;
                #[expect(clippy::cast_precision_loss, reason = "lattice positions are below 2^53")]
                let (x, y) = frame.world_from_lattice(x as f64, y as f64);
                let kind = match prisms {
                    _ if columns.top_at(index) == BLOCKS_ALL => ObstacleKind::Nodata(cell),
                    Some(_) => ObstacleKind::Terrain(cell),
                    None => ObstacleKind::Cell(cell),
                };
                Some((kind, [x, y]))
            }
            _ => None,
        }
    }
}
