//! What is right: the answer of every receiver of a scene, decided in integers from the definition of line of sight in
//! [`crate::los`] and from nothing else.
//!
//! It shares no code with the engines: there is no walk from cell to cell, no culling, no triangulation and no repair, only
//! all crossings, sorted, and a look at both sides of the link between them. That is slow, and scenes are small.

use super::scene::{Ready, StressScene, StressSolid};
use super::truth_columns::{self, columns_truth};
use super::truth_prisms::{self, prisms_truth};
use crate::error::{Result, StressError};
use crate::quantity::LatticePoint;

/// Whether each receiver of a scene is LoS, in the order of [`Ready::receivers`].
///
/// Cost: for each receiver the number of grid lines, or of edges squared.
///
/// # Errors
/// E601 if the answer differs from one that is known by construction; E902 for a scene too large for the integers.
pub fn truth(scene: &StressScene, ready: &Ready) -> Result<Vec<bool>> {
    let far = |p: &LatticePoint| (p.x - scene.uav.x).abs().max((p.y - scene.uav.y).abs());
    let most = match &scene.solid {
        StressSolid::Columns { .. } => truth_columns::MOST_STEPS,
        StressSolid::Prisms(_) => truth_prisms::MOST_STEPS,
    };
    if ready.receivers.iter().any(|(_, p)| far(p) > most) || scene.reach() > most {
        return Err(StressError::TooLarge { scene: scene.name.clone() }.into());
    }
    let answer = |receiver: &LatticePoint| match &scene.solid {
        StressSolid::Columns { board, .. } => columns_truth(board, scene.uav, *receiver),
        StressSolid::Prisms(prisms) => prisms_truth(prisms, scene.uav, *receiver),
    };
    let answers: Vec<bool> = ready.receivers.iter().map(|(_, receiver)| answer(receiver)).collect();
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
