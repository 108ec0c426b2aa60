//! Requests that make no sense, alone or for their scene.

use std::borrow::Cow;

/// What only generated cities have.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[expect(missing_docs, reason = "the texts say it")]
pub enum OfGenerated {
    #[error("a sweep of α, β or γ")]
    Sweep,
    #[error("an azimuth")]
    Azimuth,
    #[error("a placement over a middle")]
    Middle,
}

/// What is wrong with a request (E1xx). Options go by their names in this library.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the docs of a variant say what its fields are")]
pub enum RequestError {
    /// E101: a goal without the share that the least height is to reach.
    #[error("the goal is `{0}`, wanted a share to reach with `minimize height`")]
    ShareWanted(String),
    /// E101: a goal with a share, and nothing to make small.
    #[error("the goal `{0}` names a share, but not what to minimize")]
    MinimizeWanted(String),
    /// E102: a text that is no UAV, and what was found in it.
    #[error("cannot read `uav {text}`: {found}")]
    Uav { text: String, found: String },
    /// E105: an output that is not named after each UAV, beside others that are.
    #[error("cannot write {0}: other files of this run are named after each UAV")]
    NotNamedAfterUavs(String),
    /// E105: an output that is not named after each tile, beside others that are.
    #[error("cannot write {0}: it is not named after the row and the column of a tile, and nothing else")]
    NotNamedAfterTiles(String),
    /// E105: a file of a unit of work, which all are merged into.
    #[error("cannot write {path}: it is a file of {unit}")]
    FileOfUnit { path: String, unit: String },
    /// E105: no folder for a copy of the raster.
    #[error("cannot use {0} for a copy of the raster: it is no folder")]
    Scratch(String),
    /// E106: an output that is there, made by another run.
    #[error("cannot write {0}: it exists, made by another run")]
    OfAnotherRun(String),
    /// E106: an output that is there, in which nothing says that this program made it.
    #[error(
        "cannot write {0}: it exists, and nothing in it says which run made it: it is damaged, or of another program"
    )]
    OfNobody(String),
    /// E107: GDAL's values are those of one UAV's line of sight; which layers of how many UAVs were asked for.
    #[error("`gdal_values` writes line of sight of one UAV, found the layers `{layers}` of {uavs}")]
    GdalValues { layers: String, uavs: String },
    /// E107: a layer of one UAV in a tile; the file, the layer.
    #[error("cannot write {path}: a tile holds all UAVs together, found the layer `{layer}`")]
    LayerOfTile { path: String, layer: &'static str },
    /// E108: a goal without what it is about, an option.
    #[error("the goal `{goal}` needs `{option}`")]
    GoalNeeds { goal: String, option: &'static str },
    /// E108: no UAV.
    #[error("no UAV: wanted `uav X,Y,H` or `uavs FILE`")]
    NoUav,
    /// E108: so few placements to compare.
    #[error("cannot compare: found {0} placements, wanted at least 2")]
    TooFewToCompare(usize),
    /// E109: a raster has no footprints to write.
    #[error("cannot write {0}: a raster scene has no footprints")]
    NoFootprints(String),
    /// E109: a link without a side view.
    #[error("cannot draw the side view of a vertical link")]
    VerticalLink,
    /// E109: places without a grid.
    #[error("only candidates on a grid make a picture or a raster")]
    NoGrid,
    /// E109: a mosaic without tiles that are rasters.
    #[error("cannot write {0}: it joins tiles that are GeoTIFF files, and there are none")]
    NoTilesToJoin(String),
    /// E109: an overlay of a scene that is nowhere on the globe.
    #[error(
        "cannot write {0}: the scene has no coordinate reference system, wanted one that leads to longitude and latitude"
    )]
    NoCrs(String),
    /// E113: a number out of range: what it is, and what is wanted.
    #[error("{what} is `{found}`, wanted {wanted}")]
    Number { what: &'static str, found: f64, wanted: String },
    /// E113: an antenna that cannot be.
    #[error(transparent)]
    Antenna(crate::city::AntennaFault),
    /// E113: two UAVs of a live page with antennas that differ.
    #[error("UAVs `{a}` and `{b}` have antennas that differ, wanted one for all of a live page")]
    PageAntennas { a: String, b: String },
    /// E113: a tolerance out of range.
    #[error("the tolerance is `{0}`, wanted a P_LoS above 0 and below 1")]
    Tolerance(f64),
    /// E113: heights of a curve \[m\], from, to, step, and what is wanted.
    #[error("the heights of the curve are `{}:{}:{}`, wanted {wanted}", .heights[0], .heights[1], .heights[2])]
    CurveHeights { heights: [f64; 3], wanted: &'static str },
    /// E113: a kind of ground that stands twice in a list.
    #[error("{0} is named twice, wanted each zone once")]
    ZoneTwice(&'static str),
    /// E113: heights above different things cannot be compared.
    #[error("`minimize height` compares the heights of `height`: wanted all above the same")]
    MixedHeights,
    /// E115: a text that is no reference system, and the option that holds it.
    #[error("`{option}`: {error}")]
    NoSystem { option: &'static str, error: Box<skyshed_io::Error> },
    /// E116: an option that changes nothing, and why.
    #[error("`{option}` has no meaning {why}")]
    Idle { option: Cow<'static, str>, why: String },
    /// E116: `resume` without files.
    #[error("`resume` has no meaning without files to leave alone")]
    NothingToResume,
    /// E116: jobs of a run without units.
    #[error("jobs have no meaning for a run without units of work: no file is named after each UAV or tile")]
    NoUnits,
    /// E116: what some units come to.
    #[error("only all units of a run are merged, found a part of them")]
    PartOfUnits,
    /// E116: a file of polygons, and no polygons.
    #[error("cannot write {0}: it holds polygons")]
    NoPolygons(String),
    /// E116: what only generated cities have.
    #[error("{0} have no meaning for a city in a file: it is one, and its streets form no grid")]
    OneCity(&'static str),
    /// E116: a sweep, or another thing, that a real city does not take.
    #[error("{what} has no meaning over {word}, a real city")]
    RealCity { what: OfGenerated, word: String },
    /// E116: zones on coarser cells.
    #[error("receivers `{0}` have no meaning here: coarser cells have other zones")]
    CoarseZones(&'static str),
    /// E116: a tolerance beside a method that has none.
    #[error("a tolerance has no meaning beside an approximate method: it chooses itself")]
    ToleranceOfApproximate,
    /// E116: a tolerance beside methods whose error has no bound.
    #[error(
        "a tolerance has no meaning beside methods other than product and maps: the others have no bound on their error"
    )]
    ToleranceWithoutBound,
    /// E117: zones without buildings.
    #[error("zones of a surface model alone: no building is known, so no zone is")]
    NoZones,
    /// E117: tiles without buildings.
    #[error("tiles of a surface model alone: no building is known")]
    NoTiles,
    /// E117: receivers on what a surface model alone does not tell.
    #[error("receivers `{receivers}` with a surface model alone: no {what} is known")]
    NoReceivers { receivers: &'static str, what: &'static str },
    /// E118: an engine for other scenes; the scene, why, and a method that can.
    #[error("the method that was asked for cannot decide {word}: {why}")]
    Engine { word: String, why: &'static str, instead: String },
    /// E121: a method of P_LoS that maps a city in a file.
    #[error("method `{0}` has no meaning for a generated city: it maps a city in a file")]
    MapsOfGenerated(String),
    /// E121: no method of P_LoS.
    #[error("unknown method `{0}`, wanted product, city, geometry, maps or a model")]
    UnknownMethod(String),
    /// E122: a method of P_LoS for a city of which too little is known.
    #[error("cannot use method `{method}` over {word}: {why}")]
    UnknownCity { method: String, word: String, why: &'static str },
    /// E122: a model beyond what it was made for.
    #[error("cannot use model `{id}` over {word}: {reason}")]
    OutsideModel { id: String, word: String, reason: String },
    /// E123: a text that names no file of a curve.
    #[error("cannot read the curve `{0}`: wanted NAME=FILE.csv")]
    CurveWord(String),
    /// E123: a name that another method has.
    #[error("cannot name a curve `{0}`: another method has that name")]
    CurveNameTaken(String),
    /// E124: a heat map of other than two quantities.
    #[error("cannot draw a heat map: {0} quantities are swept, wanted two")]
    HeatAxes(usize),
    /// E124: more than a reader sees.
    #[error("cannot draw {n} {what}, wanted at most {most}")]
    TooManyDrawn { n: usize, what: &'static str, most: usize },
}

impl RequestError {
    pub(super) fn code(&self) -> u16 {
        use RequestError as R;
        match self {
            R::ShareWanted(_) | R::MinimizeWanted(_) => 101,
            R::Uav { .. } => 102,
            R::NotNamedAfterUavs(_) | R::NotNamedAfterTiles(_) | R::FileOfUnit { .. } | R::Scratch(_) => 105,
            R::OfAnotherRun(_) | R::OfNobody(_) => 106,
            R::GdalValues { .. } | R::LayerOfTile { .. } => 107,
            R::GoalNeeds { .. } | R::NoUav | R::TooFewToCompare(_) => 108,
            R::NoFootprints(_) | R::VerticalLink | R::NoGrid | R::NoTilesToJoin(_) | R::NoCrs(_) => 109,
            R::Number { .. }
            | R::Antenna(_)
            | R::PageAntennas { .. }
            | R::Tolerance(_)
            | R::CurveHeights { .. }
            | R::MixedHeights
            | R::ZoneTwice(_) => 113,
            R::Idle { .. }
            | R::NothingToResume
            | R::NoPolygons(_)
            | R::OneCity(_)
            | R::RealCity { .. }
            | R::CoarseZones(_)
            | R::ToleranceOfApproximate
            | R::NoUnits
            | R::PartOfUnits
            | R::ToleranceWithoutBound => 116,
            R::NoSystem { .. } => 115,
            R::NoZones | R::NoTiles | R::NoReceivers { .. } => 117,
            R::Engine { .. } => 118,
            R::MapsOfGenerated(_) | R::UnknownMethod(_) => 121,
            R::UnknownCity { .. } | R::OutsideModel { .. } => 122,
            R::CurveWord(_) | R::CurveNameTaken(_) => 123,
            R::HeatAxes(_) | R::TooManyDrawn { .. } => 124,
        }
    }
}
