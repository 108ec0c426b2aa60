//! How stable the answers of a UAV are, as documents tell it.

use serde_json::{Map, Value, json};

use crate::coverage::{Move, Stability, Turned};
use crate::quantity::counted;

/// What the moves of one UAV turn.
#[derive(Debug, Clone, PartialEq)]
pub struct StabilityFacts {
    /// Each move with what it turns, or why it cannot be made.
    pub moves: Vec<(Move, Result<Turned, String>)>,
    /// Receivers that at least one move turns.
    pub cells: u64,
}

impl StabilityFacts {
    /// The facts without the layer.
    pub fn of(stability: &Stability) -> Self {
        StabilityFacts { moves: stability.moves.clone(), cells: stability.unstable }
    }

    /// One line: what each move turns, gained and lost.
    pub fn in_words(&self) -> String {
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

    /// Gained and lost by move, null with a reason where a move cannot be made; and the receivers that any turns.
    pub fn json(&self) -> Value {
        let of = |turned: &Result<Turned, String>| match turned {
            Ok(turned) => json!({"gained": turned.gained, "lost": turned.lost}),
            Err(reason) => json!({"gained": null, "lost": null, "reason": reason}),
        };
        let moves: Map<String, Value> =
            self.moves.iter().map(|(which, turned)| (which.name().to_string(), of(turned))).collect();
        json!({"moves": moves, "cells": self.cells})
    }
}
