//! Questions that skyshed answers, one type for each.
//!
//! A question is a plain struct whose fields are options of the program, keywords of the Python
//! package, settings of the library and members of a JSON document at once. Fields that nobody set are
//! `None`, empty or `false`: so a default that was typed differs from one that was not.
//!
//! * [`part!`] defines a struct of fields. Every option is defined there once, with its documentation.
//! * `check` refuses values that are wrong by themselves; `plan` fills in the defaults.
//! * [`json`] reads and writes requests as JSON and as words of a command line.
//!
//! Nothing here reads a file, a clock or the environment. With the feature `words` the structs are
//! flags of a command line, too.

#![allow(rustdoc::broken_intra_doc_links, reason = "help texts name units in brackets")]

mod antenna;
mod error;
mod goal;
mod height_errors;
mod heights;
pub mod json;
mod layers;
mod map;
mod numbers;
mod output;
mod part;
mod place;
mod plos;
mod questions;
mod scene;
mod sight;
mod source;
mod track;
mod uavs;
mod units;
mod values;
#[cfg(all(test, feature = "words"))]
mod round_trips;
#[cfg(feature = "words")]
pub mod words;

pub use antenna::{Antenna, SetAntenna};
pub use error::{Fault, Result};
pub use goal::{Goal, Measure, Whom};
pub use height_errors::{HeightErrors, SetHeightErrors};
pub use heights::{Heights, have_one_reference, one_unit};
pub use layers::{Layer, PolygonClasses, TiffLayout};
pub use map::{
    CoverageQuestion, HeightCurve, MapForms, MapMemory, MapOptions, MapRequest, MapUnits, OverTime, SaveOptions,
    SetHeightCurve, SetMapForms, SetMapMemory, SetMapOptions, SetMapUnits, SetOverTime,
};
pub use numbers::{LengthList, NumberList};
pub use output::{
    Effort, Files, OutputOptions, PictureOptions, SetEffort, SetFiles, SetPictureOptions, SetWriting, Writing,
};
pub use part::{Field, IntoValue, filled};
pub use place::{
    CandidateOptions, GoalOptions, Minimize, PlaceFiles, PlaceQuestion, PlaceRequest, SetCandidateOptions,
    SetGoalOptions, SetPlaceFiles, SetTable, Table,
};
pub use plos::{
    Placement, PlosEffort, PlosOptions, PlosRequest, PlotKind, PlotOptions, SetPlosEffort, SetPlosOptions,
    SetPlotOptions, SetSweepOptions, SweepOptions, Users,
};
pub use questions::{
    ChartOptions, ChartRequest, CityRequest, CompareOptions, CompareRequest, InfoOptions, InfoRequest, LimitsOptions,
    LimitsRequest, LinkOptions, LinkRequest, LiveRequest, SampleOptions, SampleRequest, SetChartOptions,
    SetCompareOptions, SetInfoOptions, SetLimitsOptions, SetLinkOptions, SetSampleOptions, SetStressOptions,
    StressOptions, StressRequest, ZonesRequest,
};
pub use scene::band::Band;
pub use scene::missing_heights::{HeightRule, MissingHeights, WithoutHeight};
pub use scene::{
    BaseRule, DataAreaChoice, GroundChoice, HeightUnit, METERS_PER_FOOT, Parts, Reading, Repairs, Roofs, SceneOptions,
    SceneWord, SetRepairs, SetSceneOptions, SetSceneWord,
};
pub use sight::{Earth, Range, Receiver, Receivers, SetEarth, SetRange, SetReceiver, Sight};
pub use source::Source;
pub use track::{SetStretchOptions, SetTrackOptions, StretchOptions, TrackOptions, TrackRequest};
pub use uavs::{BadUavs, Position, SetUavs, Uavs};
pub use units::{Shard, TileIndex, ZoneCount};
pub use values::{EarthFactor, FilePath, HeightRange, Meters};

/// Version of the answers: a number that every change of any answer raises. It is part of the identity of
/// a unit of work, so that files of another version are not taken for its own.
pub const ANSWERS_VERSION: u32 = 1;

/// Options of a run of the program. A caller of the library has the answer, the threads and the memory.
pub const PROGRAM_OPTIONS: [&str; 5] = ["json", "max_memory", "quiet", "repairs", "threads"];

/// Returns the defaults of all parts by the names of their fields: the table that help texts and plans
/// have in common.
pub fn defaults() -> serde_json::Map<String, serde_json::Value> {
    let parts = [
        json::set_members(&Receiver::DEFAULTS),
        json::set_members(&Range::DEFAULTS),
        json::set_members(&SceneOptions::defaults()),
        json::set_members(&MapOptions::defaults()),
        json::set_members(&MapForms { tif_layout: Some(TiffLayout::Cog), ..MapForms::default() }),
        json::set_members(&MapUnits { tile_size: Some(2048), ..MapUnits::default() }),
        json::set_members(&PlaceQuestion::defaults()),
        json::set_members(&PlaceFiles { top: Some(10), ..PlaceFiles::default() }),
    ];
    parts.into_iter().flatten().collect()
}

/// Returns the defaults of a command: those of all parts, and its own.
pub fn defaults_of(command: &str) -> serde_json::Map<String, serde_json::Value> {
    let own = match command {
        "compare" => json::set_members(&CompareOptions::defaults()),
        "limits" => json::set_members(&LimitsOptions::defaults()),
        "chart" => json::set_members(&ChartOptions::defaults()),
        "plos" => json::set_members(&PlosRequest::defaults()),
        "sample" => json::set_members(&SampleOptions::defaults()),
        "stress" => json::set_members(&StressOptions::defaults()),
        "track" => json::set_members(&TrackOptions::defaults()),
        _ => serde_json::Map::new(),
    };
    defaults().into_iter().chain(own).collect()
}

/// Returns `true` if any request has an option of this name.
pub fn is_option(name: &str) -> bool {
    fn has<T: serde::Serialize + Default>(name: &str) -> bool {
        serde_json::to_value(T::default()).is_ok_and(|members| members.get(name).is_some())
    }
    has::<MapRequest>(name)
        || has::<PlaceRequest>(name)
        || has::<PlosRequest>(name)
        || has::<SampleRequest>(name)
        || has::<CompareRequest>(name)
        || has::<LimitsRequest>(name)
        || has::<ChartRequest>(name)
        || has::<TrackRequest>(name)
        || has::<LinkRequest>(name)
        || has::<InfoRequest>(name)
        || has::<StressRequest>(name)
}
