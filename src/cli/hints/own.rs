//! Remedies for the errors of `src/error/`: requests, places, inputs, limits.

use std::ffi::OsStr;

use crate::error::{CheckError, FitsPage, InputError, LimitError, OfGenerated, PlacesError, RequestError, Restart};
use crate::los_probability::models::Model;
use crate::scene::{built_up, is_raster_scene};

pub(super) fn of_request(error: &RequestError) -> Option<String> {
    use RequestError as R;
    let hint = match error {
        R::NoSystem { error, .. } => return super::io::hint(error),
        R::ShareWanted(_) => "for example `--goal p_los>=0.8 --minimize height`",
        R::MinimizeWanted(_) => "add `--minimize height`",
        R::Uav { .. } => "write X,Y,H, for example `500,500,100` or `691549.7,5334762.2,30roof`",
        R::NotNamedAfterTiles(_) => "write `{row}` and `{col}` into every name, and no `{site}`",
        R::LayerOfTile { .. } => "`--layers count|union|which|best-server`, or a map of each UAV: `-o NAME-{site}.tif`",
        R::NoUnits => "`-o NAME-{site}.tif` gives each UAV a file of its own, `-o NAME-{row}-{col}.tif` each tile",
        R::PartOfUnits => "leave out `--shard` and `--tile`",
        R::NotNamedAfterUavs(_) => "write `{site}` into every name, or into none",
        R::NotUnicode(_) => "rename it, or run the map itself: it writes files of any name",
        R::Scratch(_) => "name one with `--scratch FOLDER`, which holds 4 bytes a cell while the map is made",
        R::OfAnotherRun(_) | R::OfNobody(_) => "`--overwrite` replaces it",
        R::GdalValues { .. } => "choose one UAV and `--layers los`",
        R::TooFewToCompare(_) => "repeat `--uav X,Y,H`, or give `--uavs FILE` or `--mask FILE`",
        R::NoCrs(_) => "`--crs EPSG:N` names that of a file; a generated city has none",
        R::Tolerance(_) => "`--tolerance 0.005` is half a percentage point",
        R::MixedHeights => "for example `--height 20:200:10`",
        R::NothingToResume => "`-o FILE` names one",
        R::NoPolygons(_) => "`--polygons los` makes them",
        R::OneCity(_) => "generate cities: `itu:urban` or `itu:α,β,γ`",
        R::RealCity { what: OfGenerated::Sweep, .. } => "sweep a generated city: `itu:α,β,γ`",
        R::RealCity { what: OfGenerated::Azimuth, .. } => "its streets have no common direction",
        R::RealCity { what: OfGenerated::Middle, .. } => "wanted anywhere, street, crossroad or rooftop",
        R::CoarseZones(_) => "wanted ground, roof or all",
        R::ToleranceOfApproximate => "leave out `--method`",
        R::NoZones | R::NoTiles | R::NoReceivers { .. } => {
            "give the ground: `--terrain FILE`, or flat with `--ground Z`"
        }
        R::Engine { instead, .. } => return Some(format!("with `--method maps` it is `{instead}`")),
        R::MapsOfGenerated(_) => "`--method city` draws whole cities; `skyshed map` maps one",
        R::UnknownMethod(word) if word.starts_with("icc") || word.starts_with("mohammed2021") => {
            "the formula of that model is not public; give its curve as a table: `--curve NAME=FILE.csv`"
        }
        R::UnknownMethod(_) => {
            let ids: Vec<&str> = Model::ALL.iter().map(|model| model.id()).collect();
            return Some(format!("models are {}", ids.join(", ")));
        }
        R::UnknownCity { .. } => {
            "`--method maps` needs no α, β, γ; without `--method`, `itu:α,β,γ` beside it lays a city of yours over it"
        }
        R::OutsideModel { .. } => "`--method models` takes all that apply",
        R::HeatAxes(_) => "draw curves: `--plot curves`",
        R::TooManyDrawn { .. } => "sweep less in one run, or write the table alone: `-o table.csv`",
        _ => return None,
    };
    Some(hint.to_string())
}

pub(super) fn of_places(error: &PlacesError) -> Option<String> {
    use PlacesError as P;
    let hint = match error {
        P::Receiver { height, why, .. } => return super::core::of_receiver(*height, why),
        P::BadUavs { .. } => {
            "a run with `--bad-uavs skip` leaves them out; with `--bad-uavs lift` they hover at the top of what is there"
        }
        P::LongLink { .. } => "check the coordinate reference systems of both ends",
        P::NoWeights(_) => "check its extent and its CRS",
        P::NoCandidate { .. } => "ask for a higher `--height`, or fewer constraints",
        P::NoWinner(_) => "without `--map` the other results are written",
        P::NoSampledDisc { word, .. } if is_raster_scene(word.as_ref()) => "a smaller `--radius`",
        P::NoSampledDisc { .. } => {
            "a smaller `--radius`, a larger `--extent`, or, if the ground between is known, `--data-area all` or a polygon of it"
        }
        P::NoDisc(word) if is_raster_scene(word.as_ref()) => "a smaller `--radius`",
        P::NoDisc(_) => "a smaller `--radius`, or a larger `--extent`",
        _ => return None,
    };
    Some(hint.to_string())
}

pub(super) fn of_input(error: &InputError) -> Option<String> {
    let hint = match error {
        InputError::Changed(_) => "run it again: what was made of the scene as it was is of another run",
        InputError::Mask { .. } => "`skyshed map SCENE --uav X,Y,H -o FILE.tif` writes such a mask",
        InputError::OtherGrid { .. } => "make the map again with the scene flags of this comparison",
        InputError::Curve { some_are_good, .. } => {
            let hint = "a curve is a table with the columns `theta_deg,p_los` or `distance_m,p_los`, separated by commas, \
                        semicolons or tabs";
            return Some(super::io::with_skipping(hint, *some_are_good));
        }
        InputError::Weights { .. } => return None,
    };
    Some(hint.to_string())
}

pub(super) fn of_limit(error: &LimitError) -> Option<String> {
    use LimitError as L;
    let hint = match error {
        L::Program { .. } => "allow more, for example `--max-memory 500M`",
        L::Exceeded(_) => "allow more with `--max-memory SIZE`, or ask for fewer cells, UAVs or layers",
        L::Memory { name, is_typed, .. } => return Some(less_memory(name, *is_typed)),
        L::Strips { are_asked: true, .. } => "leave out `--strips`: in memory it can be made",
        L::Strips { word, .. } | L::LargeRaster { word, .. } => return Some(super::io::of_large_raster(word)),
        L::StripsOfMany { .. } => "a file for each: `-o NAME-{site}.tif`",
        L::Candidates { .. } => "choose a longer `--step`, or fewer heights",
        L::Placements { .. } => "`skyshed map` makes maps and tables of any number",
        L::Blocks { .. } => "choose larger blocks: `--block M`",
        L::Combinations { .. } => return None,
        L::Links { .. } => "link fewer at a time",
        L::Track { .. } => "choose longer steps: `--every M`",
        L::Tiles { .. } => "choose a larger `--tile`",
        L::Extent { word, .. } if is_raster_scene(word.as_ref()) => return Some(super::io::of_large_raster(word)),
        L::Extent { .. } => "choose a part of it with `--extent W,S,E,N`",
        L::PageCity { fits, .. } => return Some(what_fits(fits)),
        L::PageBytes { .. } => "choose larger cells or a smaller extent",
        L::PageUavs { .. } => "`skyshed map` takes any number",
        L::Threads { .. } => "fewer with `-j N`, or allow this user more processes (`ulimit -u`)",
    };
    Some(hint.to_string())
}

/// Ways to make do with memory, by what a scene is; and to have more, where the limit was typed.
pub(super) fn less_memory(word: &str, is_typed: bool) -> String {
    let scene: &OsStr = word.as_ref();
    let less = if built_up(scene).is_some() {
        "choose a larger `--cell` or a smaller `--size`".into()
    } else if is_raster_scene(scene) {
        super::io::of_large_raster(word)
    } else {
        "choose a larger `--cell` or a smaller `--extent W,S,E,N`".into()
    };
    if is_typed { format!("allow more with `--max-memory SIZE`, or {less}") } else { less }
}

/// Returns flags that read the part of a city that a page can hold.
fn what_fits(fits: &FitsPage) -> String {
    let with_cells = |part: String, cell_m: &Option<f64>| match cell_m {
        Some(cell_m) => format!("`--cell {cell_m}`, or a part: {part}"),
        None => format!("a part: {part}"),
    };
    match fits {
        FitsPage::Extent { extent: [west, south, east, north], cell_m } => {
            with_cells(format!("`--extent {west},{south},{east},{north}`"), cell_m)
        }
        FitsPage::Size { size_m, cell_m } => with_cells(format!("`--size {size_m}`"), cell_m),
        FitsPage::Range { radius_m } => {
            format!("the part in range of a UAV: `--uav X,Y,H --radius M`, M at most {radius_m}")
        }
        FitsPage::Cells { cell_m } => format!("choose larger cells: `--cell {cell_m}`"),
    }
}

/// The remedy for a check that does not hold.
pub(super) fn of_check(error: &CheckError) -> Option<String> {
    let hint = match error {
        CheckError::OpenUnits { by: Restart::Resumes, .. } => {
            "run the map again with `--resume`: what is done is left alone"
        }
        CheckError::OpenUnits { by: Restart::Blocked, .. } => return None,
        CheckError::OpenUnits { .. } => {
            "run the map again with `--resume --overwrite`: it replaces what another run made, and leaves alone what is done"
        }
        CheckError::NoDocument(_) => {
            "write a .json beside: `-o NAME-{site}.json`, or of tiles `-o NAME-{row}-{col}.json`"
        }
    };
    Some(hint.into())
}
