//! What the buildings of a city come to in numbers: α, β and γ of the whole ([`fit`]) and tile by tile ([`tiles`]), and
//! intervals from blocks of its ground, drawn anew ([`bootstrap`]).

pub mod bootstrap;
pub mod fit;
pub mod tiles;
