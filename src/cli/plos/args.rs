//! What can be typed after `skyshed plos`.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::cli::args::{OutputArgs, SceneArgs, memory_size, number};
use crate::cli::typed::{SceneWord, length, one_unit, scene_word};
use crate::picture::PictureSize;

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum UsersArg {
    /// All ground that is not building, uniformly
    Outdoor,
    /// Streets between crossroads
    Street,
    /// Crossroads
    Crossroad,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum PlacementArg {
    /// Anywhere over the city
    Anywhere,
    /// Over a street
    Street,
    /// Over a crossroad
    Crossroad,
    /// Over a building
    Rooftop,
    /// Over the middle of a street
    StreetCenter,
    /// Over the middle of a crossroad
    CrossroadCenter,
    /// Over the middle of a building
    RooftopCenter,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum PlotArg {
    /// A heat map for two-way sweeps of one city and method, else curves
    Auto,
    /// Curves
    Curves,
    /// Heat maps of two-way sweeps
    Heat,
}

/// Numbers as typed: `A:B:S`, `a,b,c`, or one.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::cli) struct Numbers(pub(in crate::cli) Vec<f64>);

#[derive(Debug, Args)]
pub(in crate::cli) struct PlosArgs {
    /// More cities
    #[arg(value_name = "SCENE", value_parser = scene_word(), index = 2)]
    pub(in crate::cli) more_cities: Vec<SceneWord>,
    /// Methods, separated by commas: product, city, geometry, maps (real cities), models by their ids (itu, alhourani2014,
    /// holis2008, mohammed2023, kang2019, saboor2024, tr36777_uma_av, tr38811 …), `models` for all that apply, `all`;
    /// auto: product, and maps over real cities. An engine (ray, sweep, shadow) is that of the maps
    #[arg(long, visible_alias = "methods", value_name = "LIST", value_delimiter = ',', default_value = "auto")]
    pub(in crate::cli) method: Vec<String>,
    /// Elevation angles of the UAV [deg]: A:B:S with both ends, or a list; default 5:90:5
    #[arg(long, value_name = "LIST", value_parser = numbers, allow_hyphen_values = true, help_heading = "Sweep")]
    pub(in crate::cli) theta: Option<Numbers>,
    /// Ground distances of the users [m], instead of elevation angles
    #[arg(long, value_name = "LIST", value_parser = numbers, allow_hyphen_values = true, help_heading = "Sweep",
          conflicts_with = "theta")]
    pub(in crate::cli) distance: Option<Numbers>,
    /// Users over the whole area within this radius of the UAV [m], instead of on a circle
    #[arg(long, value_name = "LIST", value_parser = numbers, allow_hyphen_values = true, help_heading = "Sweep",
          conflicts_with_all = ["theta", "distance", "phi"])]
    pub(in crate::cli) radius: Option<Numbers>,
    /// Azimuths [deg]: 0 across the user's street, 90 along it; default: the mean over all
    #[arg(long, value_name = "LIST", value_parser = numbers, allow_hyphen_values = true, help_heading = "Sweep")]
    pub(in crate::cli) phi: Option<Numbers>,
    /// Heights of the UAV above ground [m]; feet as 400ft
    #[arg(long, value_name = "LIST", value_parser = lengths, allow_hyphen_values = true, help_heading = "Sweep",
          default_value = "100")]
    pub(in crate::cli) height: Numbers,
    /// Values of α instead of the city's
    #[arg(long, value_name = "LIST", value_parser = numbers, allow_hyphen_values = true, help_heading = "Sweep")]
    pub(in crate::cli) alpha: Option<Numbers>,
    /// Values of β instead of the city's [1/km²]
    #[arg(long, value_name = "LIST", value_parser = numbers, allow_hyphen_values = true, help_heading = "Sweep")]
    pub(in crate::cli) beta: Option<Numbers>,
    /// Values of γ instead of the city's [m]
    #[arg(long, value_name = "LIST", value_parser = numbers, allow_hyphen_values = true, help_heading = "Sweep")]
    pub(in crate::cli) gamma: Option<Numbers>,
    /// Which users are counted; several separated by commas
    #[arg(long, value_enum, value_delimiter = ',', default_value = "outdoor", help_heading = "Sweep")]
    pub(in crate::cli) users: Vec<UsersArg>,
    /// Where the UAV hovers; several separated by commas
    #[arg(long, value_enum, value_delimiter = ',', default_value = "anywhere", help_heading = "Sweep")]
    pub(in crate::cli) placement: Vec<PlacementArg>,
    /// Height of the receivers above ground [m]; the paper's figures have 0
    #[arg(long, value_name = "M", value_parser = length, default_value = "1.5", allow_hyphen_values = true)]
    pub(in crate::cli) rx_height: f64,
    /// Count only UAVs that are clear of the roof below them; otherwise one inside a building is NLoS to all
    #[arg(long)]
    pub(in crate::cli) uav_clear_of_roof: bool,
    /// A curve of your own: a table with the columns theta_deg (or distance_m) and p_los, `NAME=-` from standard input;
    /// repeat for more
    #[arg(long, value_name = "NAME=FILE")]
    pub(in crate::cli) curve: Vec<OsString>,
    /// Leave out rows of the curves that cannot be read, with a warning that names them
    #[arg(long, requires = "curve")]
    pub(in crate::cli) skip_bad: bool,
    /// Stop when all intervals are ±P or narrower
    #[arg(long, value_name = "±P", value_parser = plus_minus, help_heading = "Effort")]
    pub(in crate::cli) until: Option<f64>,
    /// How far any P_LoS may be off, such as 0.005, at the least effort: over a generated city the product with the fewest
    /// points, over a real one maps of the coarsest cells, for which that is so with 99 % confidence, as measured; says what
    /// was taken
    #[arg(long, value_name = "P", value_parser = number, allow_hyphen_values = true, help_heading = "Effort",
          conflicts_with = "until")]
    pub(in crate::cli) tolerance: Option<f64>,
    /// Confidence of the intervals
    #[arg(long, value_name = "C", value_parser = number, default_value = "0.95", help_heading = "Effort")]
    pub(in crate::cli) ci: f64,
    /// Cities that `city` draws
    #[arg(long, value_name = "N", default_value_t = 500, value_parser = clap::value_parser!(u64).range(1..=1_000_000),
          help_heading = "Effort")]
    pub(in crate::cli) cities: u64,
    /// Users on the circle, or in the area, of each city that `city` draws; with `--phi` 8, one in each octant
    #[arg(long, value_name = "N", default_value_t = 360, value_parser = clap::value_parser!(u32).range(1..=1_000_000),
          help_heading = "Effort")]
    pub(in crate::cli) users_per_city: u32,
    /// Links that `geometry` draws for each value
    #[arg(long, value_name = "N", default_value_t = 20_000, value_parser = clap::value_parser!(u64).range(1..),
          help_heading = "Effort")]
    pub(in crate::cli) links: u64,
    /// UAV positions over a real city
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u64).range(1..=1_000_000),
          help_heading = "Effort")]
    pub(in crate::cli) positions: u64,
    /// Over a real city P_LoS at an angle is that of users who see the UAV within so many degrees of it
    #[arg(long, value_name = "DEG", value_parser = number, default_value = "2.5", allow_hyphen_values = true,
          help_heading = "Effort")]
    pub(in crate::cli) theta_band: f64,
    /// Edge of the blocks of a real city that are resampled for its intervals [m]; default: an eighth of the city, at
    /// least 100 m
    #[arg(long, value_name = "M", value_parser = number, allow_hyphen_values = true, help_heading = "Effort")]
    pub(in crate::cli) block: Option<f64>,
    /// File to write, by extension: .png .svg .pdf (plot), .csv, .json, .npz, `-` for JSON on standard output; repeat for more.
    /// Without any the table goes to standard output
    #[arg(short, long = "output", value_name = "FILE", help_heading = "Output")]
    pub(in crate::cli) output: Vec<PathBuf>,
    /// Write the table to this file, whatever its name
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub(in crate::cli) csv: Option<PathBuf>,
    /// Kind of plot
    #[arg(long, value_enum, default_value = "auto", help_heading = "Output")]
    pub(in crate::cli) plot: PlotArg,
    /// Title of the plot
    #[arg(long, value_name = "TEXT", help_heading = "Output")]
    pub(in crate::cli) title: Option<String>,
    #[command(flatten)]
    pub(in crate::cli) size: PictureSize,
    /// Most memory that the run may take, such as 800M or 4G
    #[arg(long, value_name = "SIZE", value_parser = memory_size, allow_hyphen_values = true, help_heading = "Effort")]
    pub(in crate::cli) max_memory: Option<u64>,
    #[command(flatten)]
    pub(in crate::cli) out: OutputArgs,
    #[command(flatten)]
    pub(in crate::cli) scene: SceneArgs,
}

/// More numbers than this are refused.
const MOST_NUMBERS: f64 = 100_000.0;

fn numbers(text: &str) -> Result<Numbers, String> {
    numbers_of(text, number)
}

fn lengths(text: &str) -> Result<Numbers, String> {
    one_unit(text)?;
    numbers_of(text, length)
}

fn numbers_of(text: &str, number: fn(&str) -> Result<f64, String>) -> Result<Numbers, String> {
    if !text.contains(':') {
        return Ok(Numbers(text.split(',').map(number).collect::<Result<_, _>>()?));
    }
    let parts: Vec<f64> = text.split(':').map(number).collect::<Result<_, _>>()?;
    let [from, to, step] = parts[..] else {
        return Err(format!("found {} numbers, wanted A:B:S, a list, or one number", parts.len()));
    };
    if step <= 0.0 || from > to {
        return Err(format!("found {from}:{to}:{step}, wanted A not above B and S above 0"));
    }
    let n = ((to - from) / step + 1e-9).floor();
    if n >= MOST_NUMBERS {
        return Err(format!("{from}:{to}:{step} are {n} numbers, wanted at most {MOST_NUMBERS}"));
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "small and positive by the check above"
    )]
    let n = n as u32;
    // Each number from its index, so that errors do not add up; to 12 digits, so that 0.1:0.7:0.1 holds 0.3.
    let tidy = |v: f64| format!("{v:.12}").parse::<f64>().unwrap_or(v);
    let mut values: Vec<f64> = (0..=n).map(|k| tidy(from + f64::from(k) * step)).collect();
    if values.last().is_some_and(|last| to - last > 1e-9 * step) {
        values.push(to);
    }
    Ok(Numbers(values))
}

fn plus_minus(text: &str) -> Result<f64, String> {
    let digits = text.trim().trim_start_matches('±').trim_start_matches("+-").trim_start_matches("+/-");
    match number(digits) {
        Ok(p) if p > 0.0 && p < 0.5 => Ok(p),
        Ok(p) => Err(format!("found `{p}`, wanted above 0 and below 0.5")),
        Err(found) => Err(found),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_hold_both_ends_and_lists_what_they_say() {
        let of = |text: &str| numbers(text).map(|n| n.0);
        assert_eq!(of("5:90:5").map(|n| (n.len(), n[0], n[17])), Ok((18, 5.0, 90.0)));
        assert_eq!(of("0.1:0.7:0.1"), Ok(vec![0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7]));
        assert_eq!(of("0:10:4"), Ok(vec![0.0, 4.0, 8.0, 10.0]));
        assert_eq!(of("45"), Ok(vec![45.0]));
        assert_eq!(of("30, 60"), Ok(vec![30.0, 60.0]));
        assert!(of("5:90").is_err() && of("90:5:5").is_err() && of("5:90:0").is_err() && of("5:nan:1").is_err());
        assert!(of("0:1e9:1").is_err());
        assert_eq!((plus_minus("±0.005"), plus_minus("+-0.01")), (Ok(0.005), Ok(0.01)));
        assert!(plus_minus("0").is_err() && plus_minus("nan").is_err());
    }
}
