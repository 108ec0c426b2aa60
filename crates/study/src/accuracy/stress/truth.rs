//! Truth of a scene: the answer of every receiver, decided in integers from the definition of line
//! of sight in [`crate::los`] alone.
//!
//! It shares no code with the engines. There is no walk from cell to cell, no culling, no
//! triangulation and no repair. It sorts all crossings and checks both sides of the link between
//! them. That is slow, and scenes are small.

use super::scene::{Board, CELL, Ready, StressPrism, StressScene, StressSolid, narrow};
use super::truth_columns::{self, columns_truth};
use super::truth_prisms::{self, prisms_truth};
use super::truth_roofs::roofs_truth;
use crate::city::RoofTriangle;
use crate::error::{Result, StressError};
use crate::quantity::{LatticePoint, VOID};

/// Decides for each receiver of a scene whether it is served and LoS, in the order of
/// [`Ready::receivers`].
///
/// Cost: for each receiver the number of grid lines, or of edges squared.
///
/// # Errors
/// E601 if an answer differs from one known by construction. E902 for a scene beyond the integers.
pub fn truth(scene: &StressScene, ready: &Ready) -> Result<Vec<bool>> {
    let far = |p: &LatticePoint| (p.x - scene.uav.x).abs().max((p.y - scene.uav.y).abs());
    let most = match &scene.solid {
        StressSolid::Columns { .. } => truth_columns::MOST_STEPS,
        StressSolid::Prisms(_) | StressSolid::Roofs(_) => truth_prisms::MOST_STEPS,
    };
    if ready.receivers.iter().any(|(_, p)| far(p) > most) || scene.reach() > most {
        return Err(StressError::TooLarge { scene: scene.name.clone() }.into());
    }
    let board = match &scene.solid {
        StressSolid::Columns { board, .. } => Some(board_as_seen(board, scene)),
        StressSolid::Prisms(_) | StressSolid::Roofs(_) => None,
    };
    let solid = as_moved(scene);
    let answer = |receiver: &LatticePoint| match (&solid, &board) {
        (StressSolid::Prisms(prisms), _) => Some(prisms_truth(prisms, scene.earth, scene.uav, *receiver)),
        (StressSolid::Roofs(roofs), _) => roofs_truth(&roofs.concat(), scene.uav, *receiver),
        (StressSolid::Columns { board, .. }, seen) => {
            let z = receiver.z - fall(scene, (receiver.x, receiver.y));
            Some(columns_truth(seen.as_ref().unwrap_or(board), scene.uav, LatticePoint { z, ..*receiver }))
        }
    };
    let served = |receiver: &LatticePoint| if scene.serves(*receiver) { answer(receiver) } else { Some(false) };
    let answers: Option<Vec<bool>> = ready.receivers.iter().map(|(_, receiver)| served(receiver)).collect();
    let answers = answers.ok_or_else(|| StressError::TooLarge { scene: scene.name.clone() })?;
    for known in &scene.known {
        let cell = known.row * scene.n_cols + known.col;
        let found = ready.receivers.iter().position(|(c, _)| *c == cell).map(|k| answers[k]);
        if found != Some(known.is_los) {
            let (scene, row, col) = (scene.name.clone(), known.row, known.col);
            return Err(StressError::Truth { scene, row, col, found, known: known.is_los }.into());
        }
    }
    Ok(answers)
}

/// Returns the solid after the changes of heights.
fn as_moved(scene: &StressScene) -> StressSolid {
    match &scene.solid {
        StressSolid::Prisms(prisms) => {
            let prism =
                |(k, prism): (usize, &StressPrism)| StressPrism { top: prism.top + scene.moved_by(k), ..prism.clone() };
            StressSolid::Prisms(prisms.iter().enumerate().map(prism).collect())
        }
        StressSolid::Roofs(roofs) => {
            let roof = |(k, roof): (usize, &Vec<RoofTriangle>)| {
                let by = scene.moved_by(k);
                roof.iter().map(|corners| corners.map(|[x, y, z]| [x, y, z + by])).collect()
            };
            StressSolid::Roofs(roofs.iter().enumerate().map(roof).collect())
        }
        columns => columns.clone(),
    }
}

/// Returns the drop of a place as the UAV sees it, to the nearest step.
fn fall(scene: &StressScene, (x, y): (i64, i64)) -> i64 {
    let Some(p) = scene.earth else { return 0 };
    let (dx, dy) = (x - scene.uav.x, y - scene.uav.y);
    (2 * (dx * dx + dy * dy) + p).div_euclid(2 * p)
}

/// Returns a board with each column lowered by the drop of the earth at its middle.
fn board_as_seen(board: &Board, scene: &StressScene) -> Board {
    let mut seen = board.clone();
    for (cell, top) in seen.tops.iter_mut().enumerate().filter(|(_, top)| **top != VOID) {
        let steps = |n: usize| i64::try_from(n).unwrap_or(0) * CELL + CELL / 2;
        let at = (steps(cell % board.n_cols), steps(board.n_rows - 1 - cell / board.n_cols));
        *top = narrow(i64::from(*top) - fall(scene, at));
    }
    seen
}
