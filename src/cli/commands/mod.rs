//! Commands: the words of each, and the plan of the library that they become.

pub(super) mod chart;
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
pub(super) mod plos;
pub(super) mod sample;
pub(super) mod stress;
pub(super) mod track;
pub(super) mod zones;

pub(super) use completions::CompletionsArgs;
pub(super) use jobs::JobsArgs;
