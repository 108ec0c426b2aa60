//! What is reported: versioned JSON documents, tables, captions.

mod documents;

pub use documents::{LinkReport, MapReport, ObstructionReport, RunFacts, SiteFacts, Timing, digest};
