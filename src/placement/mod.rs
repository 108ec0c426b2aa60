//! Where to hover: candidates for UAVs, ranked, searched and bounded.
