//! Answers that depend on heights of buildings, where these may be off.
//!
//! * [`link_probability`]: how likely a link is clear.
//! * [`sure`]: receivers in line of sight whatever heights are within bounds.
//! * [`p_los`]: the probability of each receiver.
//! * [`deciding`]: the buildings that decide the most.
//! * [`redrawn`]: how much P_LoS varies.

mod deciding;
mod drawn_links;
mod link_probability;
mod on_roofs;
mod p_los;
mod redrawn;
mod sure;

pub use deciding::Deciding;
pub use redrawn::{CORRELATION_M, RedrawnCounts, RedrawnHeights};
pub use sure::Sure;
