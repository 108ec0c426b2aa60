//! The live page: a city that follows the pointer, in one file that asks nobody.
//!
//! The program packs a city ([`pack`]) and writes it, the engine and the page into one file ([`page`]). In the page a worker
//! hands the city to the engine, which is this very crate as WebAssembly (`exports`): it unpacks and builds it, and
//! answers questions ([`answers`]) in JSON and in bytes of cells. So the page and the program share all code that decides.

pub mod answers;
mod backdrop;
mod best_place;
mod cell_picture;
mod engine;
#[cfg(target_family = "wasm")]
pub mod exports;
pub mod pack;
#[cfg(not(target_family = "wasm"))]
pub mod page;
pub mod questions;

pub use engine::Engine;
