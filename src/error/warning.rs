//! Warnings about runs, and the type that also wraps the warnings about scenes and files.

use skyshed_core::error::one_line;

use super::told_faults;

use crate::quantity::counted;

/// A warning: a finding that did not stop the work, and what was done instead, on one line.
///
/// It has a stable code such as `W325`, which `docs/codes.md` in the repository explains.
#[derive(Clone, PartialEq, thiserror::Error)]
#[error(transparent)]
pub struct Warning(Box<WarningRepr>);

impl std::fmt::Debug for Warning {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {self}", self.code())
    }
}

impl<T: Into<WarningRepr>> From<T> for Warning {
    fn from(odd: T) -> Self {
        Warning(Box::new(odd.into()))
    }
}

/// Finding of a warning, by the crate that it comes from.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub(crate) enum WarningRepr {
    /// A warning about scenes.
    #[error(transparent)]
    Core(#[from] skyshed_core::Warning),
    /// A warning about files.
    #[error(transparent)]
    Io(#[from] skyshed_io::Warning),
    /// A warning about the run.
    #[error("{}", one_line(&.0.to_string()))]
    Run(#[from] OddRun),
}

/// A finding about a run, and what is done instead.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub(crate) enum OddRun {
    /// W201: an earth taken as flat although it drops by more than 1 m within range; farthest
    /// distance \[m\], drop \[m\], and `true` if it could be curved.
    #[error("the earth is taken as flat; at {farthest_m:.0} m, the farthest receiver, it drops by {drop_m:.1} m")]
    FlatEarth { farthest_m: f64, drop_m: f64, is_choice: bool },
    /// W202: a UAV or a placement without a receiver; its id.
    #[error("{what} `{id}` has no receiver: {why}; P_LoS is undefined")]
    NoReceiver { what: &'static str, id: String, why: &'static str },
    /// W202: UAVs without any receiver.
    #[error("no UAV has a receiver in range; shares and P_LoS are undefined")]
    NoReceivers,
    /// W202: values without P_LoS; their number.
    #[error("{} no P_LoS: {why}", counted(*n, "value has", "values have"))]
    NoValues { n: u64, why: String },
    /// W202: parts of a track without a receiver; their length \[m\].
    #[error("{length} m of the track hold no receiver: inside a building, below the ground, or without a ground")]
    OffGround { length: String },
    /// W218: UAVs that cannot be at their place: ids and faults of those left out, ids and heights of those
    /// lifted \[m above the datum\].
    #[error("{}", bad_uavs(left_out, lifted))]
    BadUavs { left_out: Vec<(String, String)>, lifted: Vec<(String, String)> },
    /// W217: straight legs of a flight that leave their heights above the ground; the largest
    /// difference \[m\] and its place \[CRS units\].
    #[error(
        "legs are straight between their vertices: at ({}, {}) the flight is {by_m} m off its height above the ground",
        at[0], at[1]
    )]
    StraightLegs { by_m: String, at: [String; 2] },
    /// W203: a UAV that cannot be at the lower heights of its curve; its id, and the lowest
    /// possible height.
    #[error("UAV `{id}` cannot be below {lowest}: lower heights of its curve, {n} of {of}, have no P_LoS")]
    LowHeights { id: String, lowest: String, n: usize, of: usize },
    /// W204: UAVs outside the grid; their ids, and the distances and directions.
    #[error("{}", outside(.0))]
    OutsideGrid(Vec<(String, String)>),
    /// W205: UAVs over cells without data; their ids.
    #[error("{}", over_nodata(.0))]
    OverNodata(Vec<String>),
    /// W210: a method that does not apply to a city.
    #[error("method `{method}` is left out over {city}: {why}")]
    MethodLeftOut { method: String, city: String, why: &'static str },
    /// W210: a contestant without an answer.
    #[error("`{0}` is left out: {1}")]
    LeftOut(String, String),
    /// W210–W212: a model that is left out, lacks values, or needs caution over some cities.
    #[error("model `{id}`{caution}; over {}", cities.join(", "))]
    Model { id: String, caution: Caution, cities: Vec<String> },
    /// W213: values without an interval; their number.
    #[error("{} no interval: it needs at least 10 clusters (cities, positions, blocks)", counted(*.0, "value has", "values have"))]
    NoIntervals(u64),
    /// W214: intervals that are wider than requested; their number.
    #[error("{} wider than ±{until}: the effort was spent before", counted(*n, "interval is", "intervals are"))]
    WideIntervals { n: u64, until: f64 },
    /// W215: a map that was made with another setting.
    #[error("{path} was made with {setting} {found}, this run has {own}: compared as it is")]
    OtherSetting { path: String, setting: &'static str, found: String, own: String },
    /// W373: a raster that holds results of this program instead of a surface; their schema.
    #[error("{path}: it holds results of this program ({schema}), not heights; its values are read as heights")]
    Results { path: String, schema: String },
}

/// Caution about a model.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub(crate) enum Caution {
    /// W210: a model that is left out; the reason.
    #[error(" is left out: {0}")]
    LeftOut(String),
    /// W211: a model without a value for some settings.
    #[error(" has no value for {n} of {of}: {why}")]
    NoValue { n: usize, of: usize, why: String },
    /// W212: a model that needs caution; one caution, and the number of further ones.
    #[error(": {care}{}", if *n_more > 0 { format!(" (and {} more)", counted(*n_more as u64, "caution", "cautions")) } else { String::new() })]
    Care { care: String, n_more: usize },
}

/// Most UAVs that a warning lists.
const MOST_TOLD: usize = 5;

fn over_nodata(ids: &[String]) -> String {
    let told: Vec<String> = ids.iter().take(MOST_TOLD).map(|id| format!("`{id}`")).collect();
    let n_more = ids.len().saturating_sub(MOST_TOLD);
    let more = if n_more > 0 { format!(", and {n_more} more") } else { String::new() };
    let (uavs, is, its) = if ids.len() == 1 { ("UAV", "is", "its") } else { ("UAVs", "are", "their") };
    format!(
        "{uavs} {}{more} {is} over no data: what stands around is not known, so {its} P_LoS is undefined",
        told.join(", ")
    )
}

fn outside(uavs: &[(String, String)]) -> String {
    if let [(id, way)] = uavs {
        return format!("UAV `{id}` is {way} of the grid");
    }
    let told: Vec<String> = uavs.iter().take(MOST_TOLD).map(|(id, way)| format!("`{id}` {way}")).collect();
    let n_more = uavs.len().saturating_sub(MOST_TOLD);
    let more = if n_more > 0 { format!(", and {n_more} more") } else { String::new() };
    format!("{} UAVs are outside the grid: {}{more}", uavs.len(), told.join(", "))
}

/// Returns words about UAVs that were left out or lifted; of many by their ids alone.
fn bad_uavs(left_out: &[(String, String)], lifted: &[(String, String)]) -> String {
    let of = |all: &[(String, String)], what: &str| {
        let n = all.len() as u64;
        (n > 0).then(|| format!("{} {what}: {}", counted(n, "UAV is", "UAVs are"), told_faults(all)))
    };
    let up: Vec<(String, String)> =
        lifted.iter().map(|(id, m)| (id.clone(), format!("`{id}` to {m} m above the datum"))).collect();
    let both = [of(left_out, "left out"), of(&up, "lifted to the top of what is there")];
    both.into_iter().flatten().collect::<Vec<_>>().join("; ")
}

impl Warning {
    /// Returns the stable code, for example `W320`.
    pub fn code(&self) -> String {
        let number = match self.repr() {
            WarningRepr::Core(warning) => return warning.code(),
            WarningRepr::Io(warning) => return warning.code(),
            WarningRepr::Run(odd) => odd.number(),
        };
        format!("W{number}")
    }

    /// Returns the finding.
    pub(crate) fn repr(&self) -> &WarningRepr {
        &self.0
    }
}

impl OddRun {
    fn number(&self) -> u16 {
        match self {
            OddRun::FlatEarth { .. } => 201,
            OddRun::NoReceiver { .. } | OddRun::NoReceivers | OddRun::NoValues { .. } | OddRun::OffGround { .. } => 202,
            OddRun::LowHeights { .. } => 203,
            OddRun::OutsideGrid(_) => 204,
            OddRun::OverNodata(_) => 205,
            OddRun::MethodLeftOut { .. } | OddRun::LeftOut(..) => 210,
            OddRun::Model { caution: Caution::LeftOut(_), .. } => 210,
            OddRun::Model { caution: Caution::NoValue { .. }, .. } => 211,
            OddRun::Model { caution: Caution::Care { .. }, .. } => 212,
            OddRun::NoIntervals(_) => 213,
            OddRun::WideIntervals { .. } => 214,
            OddRun::OtherSetting { .. } => 215,
            OddRun::StraightLegs { .. } => 217,
            OddRun::BadUavs { .. } => 218,
            OddRun::Results { .. } => 373,
        }
    }
}

/// Runs a reader, and appends its warnings about files to the warnings of the run.
pub(crate) fn warned<T>(warnings: &mut Vec<Warning>, read: impl FnOnce(&mut Vec<skyshed_io::Warning>) -> T) -> T {
    let mut odd = Vec::new();
    let found = read(&mut odd);
    warnings.extend(odd.into_iter().map(Warning::from));
    found
}
