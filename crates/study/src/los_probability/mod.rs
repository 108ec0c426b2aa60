//! The probability that a link is LoS, P_LoS: over cities that are known by α, β, γ alone, and over real ones.
//!
//! Three ways lead to P_LoS in a generated city, and all count the same thing. [`product`] integrates the heights out: they
//! are independent, so the probability of one link is a product over the buildings that it crosses, and only position
//! and azimuth are left to average, which a randomized lattice of points does. [`city`] and [`geometry`] are the two
//! simulators of Saboor et al. 2023: the one draws whole cities and looks around in them, the other draws only the
//! buildings that a link meets. Both decide links in integers on the lattice of [`crate::quantity`], in the very cities
//! that [`crate::city::BuiltUpCity`] builds.
//!
//! [`models`] holds what has been published instead.

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
