//! Stability of the answers of a UAV, as documents hold it.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;

use crate::coverage::{Move, Stability, Turned};
use crate::quantity::counted;

/// Receivers that moves by one lattice step turn.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct StabilityFacts {
    /// Each move with the receivers that it turns, or the reason why it cannot be made.
    pub(crate) moves: Vec<(Move, Result<Turned, String>)>,
    /// Receivers that at least one move turns.
    pub(crate) cells: u64,
}

/// Receivers that moves by one lattice step turn.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct StabilityDocument {
    /// By move: of the UAV east, west, north, south, up, down; of all roofs up, down.
    moves: BTreeMap<&'static str, MoveDocument>,
    /// Receivers that any move turns.
    cells: u64,
}

/// Receivers that a move turns.
#[derive(Debug, Serialize, JsonSchema)]
struct MoveDocument {
    /// Receivers that come into line of sight; null where the move cannot be made.
    gained: Option<u64>,
    /// Receivers that lose line of sight; null where the move cannot be made.
    lost: Option<u64>,
    /// Reason why the move cannot be made.
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<String>,
}

impl StabilityFacts {
    /// Returns the facts without the layer.
    pub(crate) fn of(stability: &Stability) -> Self {
        StabilityFacts { moves: stability.moves.clone(), cells: stability.unstable }
    }

    /// Returns the receivers that each move gains and loses, in one line.
    pub(crate) fn in_words(&self) -> String {
        let of = |(which, turned): &(Move, Result<Turned, String>)| {
            let name = which.name().replace("uav", "UAV").replace('_', " ");
            match turned {
                Ok(turned) => format!("{name} +{} −{}", turned.gained, turned.lost),
                Err(_) => format!("{name} impossible"),
            }
        };
        let moves: Vec<String> = self.moves.iter().map(of).collect();
        let turn = counted(self.cells, "receiver turns", "receivers turn");
        format!("Gained and lost by one lattice step: {}; in all {turn}", moves.join(", "))
    }

    pub(crate) fn document(&self) -> StabilityDocument {
        let of = |(which, turned): &(Move, Result<Turned, String>)| {
            let (gained, lost) = (turned.as_ref().ok().map(|t| t.gained), turned.as_ref().ok().map(|t| t.lost));
            (which.name(), MoveDocument { gained, lost, reason: turned.as_ref().err().cloned() })
        };
        StabilityDocument { moves: self.moves.iter().map(of).collect(), cells: self.cells }
    }
}
