//! Requests that make no sense, alone or for their scene.

use std::borrow::Cow;

/// Options that exist only for generated cities.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub(crate) enum OfGenerated {
    #[error("a sweep of α, β or γ")]
    Sweep,
    #[error("an azimuth")]
    Azimuth,
    #[error("a placement over a middle")]
    Middle,
}

/// Fault of a request (E1xx). Options have their names in this library.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub(crate) enum RequestError {
    /// E101: a goal without the share that the least height is to reach.
    #[error("the goal is `{0}`, wanted a share to reach with `minimize height`")]
    ShareWanted(String),
    /// E101: a goal with a share, and nothing to make small.
    #[error("the goal `{0}` names a share, but not what to minimize")]
    MinimizeWanted(String),
    /// E102: a text that is no UAV; its fault.
    #[error("cannot read `uav {text}`: {found}")]
    Uav { text: String, found: String },
    /// E105: an output that is not named after each UAV, beside others that are.
    #[error("cannot write {0}: other files of this run are named after each UAV")]
    NotNamedAfterUavs(String),
    /// E105: an output that is not named after each tile.
    #[error("cannot write {0}: it is not named after the row and the column of a tile, and nothing else")]
    NotNamedAfterTiles(String),
    /// E105: an output of a merge that is a file of a unit of work.
    #[error("cannot write {path}: it is a file of {unit}")]
    FileOfUnit { path: String, unit: String },
    /// E105: a file of a unit whose name JSON cannot hold.
    #[error("cannot plan {0}: its name is not UTF-8, as the JSON of a plan is")]
    NotUnicode(String),
    /// E105: a path for the copy of a raster that is no folder.
    #[error("cannot use {0} for a copy of the raster: it is no folder")]
    Scratch(String),
    /// E106: an existing output, made by another run.
    #[error("cannot write {0}: it exists, made by another run")]
    OfAnotherRun(String),
    /// E106: an existing output without a mark of this program.
    #[error(
        "cannot write {0}: it exists, and nothing in it says which run made it: it is damaged, or of another program"
    )]
    OfNobody(String),
    /// E107: GDAL's values with other layers than line of sight, or for several UAVs; the layers,
    /// and the number of UAVs.
    #[error("`gdal_values` writes line of sight of one UAV, found the layers `{layers}` of {uavs}")]
    GdalValues { layers: String, uavs: String },
    /// E107: a layer of one UAV in a tile; the file and the layer.
    #[error("cannot write {path}: a tile holds all UAVs together, found the layer `{layer}`")]
    LayerOfTile { path: String, layer: &'static str },
    /// E108: a goal without an option that it needs.
    #[error("the goal `{goal}` needs `{option}`")]
    GoalNeeds { goal: String, option: &'static str },
    /// E108: no UAV.
    #[error("no UAV: wanted `uav X,Y,H` or `uavs FILE`")]
    NoUav,
    /// E108: too few placements to compare.
    #[error("cannot compare: found {0} placements, wanted at least 2")]
    TooFewToCompare(usize),
    /// E109: footprints of a raster scene, which has none.
    #[error("cannot write {0}: a raster scene has no footprints")]
    NoFootprints(String),
    /// E109: the side view of a vertical link.
    #[error("cannot draw the side view of a vertical link")]
    VerticalLink,
    /// E109: a picture or raster of places that are not on a grid.
    #[error("only candidates on a grid make a picture or a raster")]
    NoGrid,
    /// E109: a mosaic without tiles that are rasters.
    #[error("cannot write {0}: it joins tiles that are GeoTIFF files, and there are none")]
    NoTilesToJoin(String),
    /// E109: an overlay of a scene without a reference system.
    #[error(
        "cannot write {0}: the scene has no coordinate reference system, wanted one that leads to longitude and latitude"
    )]
    NoCrs(String),
    /// E113: a number out of range; its name, its value and the accepted range.
    #[error("{what} is `{found}`, wanted {wanted}")]
    Number { what: &'static str, found: f64, wanted: String },
    /// E113: an antenna with impossible values.
    #[error(transparent)]
    Antenna(crate::city::AntennaFault),
    /// E113: two UAVs of a live page with different antennas.
    #[error("UAVs `{a}` and `{b}` have antennas that differ, wanted one for all of a live page")]
    PageAntennas { a: String, b: String },
    /// E113: a tolerance out of range.
    #[error("the tolerance is `{0}`, wanted a P_LoS above 0 and below 1")]
    Tolerance(f64),
    /// E113: heights of a curve \[m\], from, to, step; and the accepted range.
    #[error("the heights of the curve are `{}:{}:{}`, wanted {wanted}", .heights[0], .heights[1], .heights[2])]
    CurveHeights { heights: [f64; 3], wanted: &'static str },
    /// E113: a zone that occurs twice in a list.
    #[error("{0} is named twice, wanted each zone once")]
    ZoneTwice(&'static str),
    /// E113: heights above different references, which cannot be compared.
    #[error("`minimize height` compares the heights of `height`: wanted all above the same")]
    MixedHeights,
    /// E113: heights of a sample that are not above the ground.
    #[error("`height` is `{0}`, wanted heights above ground: places of a sample differ")]
    HeightOfSample(String),
    /// E115: a text that is no reference system, and the option that holds it.
    #[error("`{option}`: {error}")]
    NoSystem { option: &'static str, error: Box<skyshed_io::Error> },
    /// E116: an option that changes nothing; the reason.
    #[error("`{option}` has no meaning {why}")]
    Idle { option: Cow<'static, str>, why: String },
    /// E116: `resume` without files.
    #[error("`resume` has no meaning without files to leave alone")]
    NothingToResume,
    /// E116: jobs of a run without units.
    #[error("jobs have no meaning for a run without units of work: no file is named after each UAV or tile")]
    NoUnits,
    /// E116: a merge of only some units of a run.
    #[error("only all units of a run are merged, found a part of them")]
    PartOfUnits,
    /// E116: a file of polygons without polygons.
    #[error("cannot write {0}: it holds polygons")]
    NoPolygons(String),
    /// E116: an option of generated cities for a city in a file.
    #[error("{0} have no meaning for a city in a file: it is one, and its streets form no grid")]
    OneCity(&'static str),
    /// E116: a sweep, or another option of generated cities, over a real city.
    #[error("{what} has no meaning over {word}, a real city")]
    RealCity { what: OfGenerated, word: String },
    /// E116: zones of receivers on coarser cells.
    #[error("receivers `{0}` have no meaning here: coarser cells have other zones")]
    CoarseZones(&'static str),
    /// E116: a tolerance together with an approximate method.
    #[error("a tolerance has no meaning beside an approximate method: it chooses itself")]
    ToleranceOfApproximate,
    /// E116: a tolerance together with methods whose error has no bound.
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
    /// E117: receivers for which a surface model alone holds too little.
    #[error("receivers `{receivers}` with a surface model alone: no {what} is known")]
    NoReceivers { receivers: &'static str, what: &'static str },
    /// E118: an engine for other scenes; the scene, the reason, and a method that works.
    #[error("the method that was asked for cannot decide {word}: {why}")]
    Engine { word: String, why: &'static str, instead: String },
    /// E121: a method of P_LoS for cities in files, over a generated city.
    #[error("method `{0}` has no meaning for a generated city: it maps a city in a file")]
    MapsOfGenerated(String),
    /// E121: an unknown method of P_LoS.
    #[error("unknown method `{0}`, wanted product, city, geometry, maps or a model")]
    UnknownMethod(String),
    /// E122: a method of P_LoS that needs more than is known of the city.
    #[error("cannot use method `{method}` over {word}: {why}")]
    UnknownCity { method: String, word: String, why: &'static str },
    /// E122: a model outside its range of validity.
    #[error("cannot use model `{id}` over {word}: {reason}")]
    OutsideModel { id: String, word: String, reason: String },
    /// E123: a text that does not name the file of a curve.
    #[error("cannot read the curve `{0}`: wanted NAME=FILE.csv")]
    CurveWord(String),
    /// E123: a name that another method has.
    #[error("cannot name a curve `{0}`: another method has that name")]
    CurveNameTaken(String),
    /// E124: a heat map of more or fewer than two quantities.
    #[error("cannot draw a heat map: {0} quantities are swept, wanted two")]
    HeatAxes(usize),
    /// E124: more elements than a reader can tell apart.
    #[error("cannot draw {n} {what}, wanted at most {most}")]
    TooManyDrawn { n: usize, what: &'static str, most: usize },
}

impl RequestError {
    pub(super) fn code(&self) -> u16 {
        use RequestError as R;
        match self {
            R::ShareWanted(_) | R::MinimizeWanted(_) => 101,
            R::Uav { .. } => 102,
            R::NotNamedAfterUavs(_)
            | R::NotNamedAfterTiles(_)
            | R::FileOfUnit { .. }
            | R::NotUnicode(_)
            | R::Scratch(_) => 105,
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
            | R::HeightOfSample(_)
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
