//! Where to hover: candidates for UAVs, ranked, searched and bounded; and what each kind of place sees on average.

mod sampled;

pub use sampled::{ReceiverParts, SampledCounts, count_by_part, middles_of, over_cities, places_in};
