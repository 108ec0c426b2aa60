//! The commands: for each what can be typed, and the plan of the library that it becomes.

mod chart;
mod city;
mod compare;
mod completions;
mod info;
mod jobs;
mod limits;
mod link;
mod live;
mod map;
mod map_args;
mod place;
mod plos;
mod plos_args;
mod sample;
mod stress;
mod track;
mod zones;

pub(super) use chart::ChartArgs;
pub(super) use city::CityArgs;
pub(super) use compare::CompareArgs;
pub(super) use completions::CompletionsArgs;
pub(super) use info::InfoArgs;
pub(super) use jobs::JobsArgs;
pub(super) use limits::LimitsArgs;
pub(super) use link::LinkArgs;
pub(super) use live::LiveArgs;
pub(super) use map_args::MapArgs;
pub(super) use place::PlaceArgs;
pub(super) use plos_args::PlosArgs;
pub(super) use sample::SampleArgs;
pub(super) use stress::StressArgs;
pub(super) use track::TrackArgs;
pub(super) use zones::ZonesArgs;
