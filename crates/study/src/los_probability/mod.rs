//! Probability that a link is LoS, P_LoS: over cities known only by α, β, γ, and over real ones.
//!
//! Three methods compute the same P_LoS in a generated city:
//! * [`product`] integrates the heights out. They are independent, so the probability of one link
//!   is a product over the buildings that it crosses. A randomized lattice of points averages over
//!   position and azimuth.
//! * [`city`] and [`geometry`] are the two simulators of Saboor et al. 2023. The first draws whole
//!   cities and looks around in them; the second draws only the buildings that a link meets. Both
//!   decide links in integers on the lattice of [`crate::quantity`], in the very cities that
//!   [`crate::city::BuiltUpCity`] builds.
//!
//! [`models`] holds published models.

pub mod city;
pub mod estimate;
pub mod geometry;
pub mod lattice_city;
pub mod models;
pub mod points;
pub mod product;
pub mod real_city;
pub mod setting;
pub mod street_grid;
pub mod study;
