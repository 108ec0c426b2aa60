//! The commands: for each what can be typed, and the plan of the library that it becomes.

mod chart;
pub(super) mod city;
pub(super) mod compare;
mod completions;
pub(super) mod info;
mod jobs;
pub(super) mod limits;
pub(super) mod link;
pub(super) mod live;
pub(super) mod map;
pub(super) mod place;
mod plos;
mod plos_args;
pub(super) mod sample;
mod stress;
pub(super) mod track;
pub(super) mod zones;

pub(super) use chart::ChartArgs;
pub(super) use completions::CompletionsArgs;
pub(super) use jobs::JobsArgs;
pub(super) use plos_args::PlosArgs;
pub(super) use stress::StressArgs;
