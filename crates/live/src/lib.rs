//! Engine of the live page: a city in one file of bytes, and answers about it while a UAV is
//! dragged.
//!
//! The program packs a city ([`pack`]). `skyshed-render` puts it into a page, with this crate as
//! WebAssembly beside it, made by `scripts/engine`.
//!
//! In the page, a worker hands the bytes to the engine (`exports`), which unpacks and builds the
//! city. The engine answers [`questions`] with [`answers`] in JSON, and with a byte for each cell.
//! So the page and the program share all code that decides line of sight.

pub mod answers;
mod backdrop;
mod best_place;
mod cell_picture;
mod engine;
#[cfg(target_family = "wasm")]
pub mod exports;
pub mod pack;
mod packed_bytes;
mod packed_zones;
pub mod questions;

pub use engine::{Engine, MOST_UAVS};
