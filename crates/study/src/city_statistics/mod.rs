//! Statistics of the buildings of a city: α, β and γ of the whole ([`fit`]) and tile by tile
//! ([`tiles`]), and intervals from resampled blocks of its ground ([`bootstrap`]).

pub mod bootstrap;
pub mod fit;
pub mod tiles;
