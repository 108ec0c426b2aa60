//! What can be typed after `skyshed plos`.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::Args;

use skyshed_request::{OutputOptions, PictureOptions, Placement, PlotKind, Reading, Users};

use crate::cli::args::words::{Numbers, length, lengths, number, numbers, one_of, plus_minus};

#[derive(Debug, Args)]
#[command(mut_arg("output", |a| a.help("File to write: .png .svg .pdf .csv .json .npz; repeat for more").long_help("File to write, by extension: .png .svg .pdf (plot), .csv, .json, .npz, `-` for JSON on \
standard output; repeat for more. Without any the table goes to standard output")))]
#[command(after_help = "Example: skyshed plos itu:urban --theta 5:90:5 --method product,itu,alhourani2014 -o plos.png")]
pub(in crate::cli) struct PlosArgs {
    /// Generated cities (itu:…), whose α, β, γ count, and cities in files: rasters, footprints, meshes
    #[arg(value_name = "SCENE", required = true, num_args = 1..)]
    pub(in crate::cli) scenes: Vec<OsString>,
    /// Methods, separated by commas: product, city, geometry, maps, ids of models such as itu, models, all
    ///
    /// auto: product, and maps over real cities. `models` are all that apply (itu, alhourani2014, holis2008, mohammed2023,
    /// kang2019, saboor2024, tr36777_uma_av, tr38811 …). An engine (ray, sweep, shadow) is that of the maps.
    #[arg(long, visible_alias = "methods", value_name = "LIST", value_delimiter = ',', default_value = "auto")]
    pub(super) method: Vec<String>,
    /// A curve of your own: a table with the columns theta_deg (or distance_m) and p_los, `NAME=-` from standard input;
    /// repeat for more
    #[arg(long, value_name = "NAME=FILE", hide_short_help = true)]
    pub(super) curve: Vec<OsString>,
    /// Leave out rows of the curves that cannot be read, with a warning that names them
    #[arg(long, requires = "curve", hide_short_help = true)]
    pub(super) skip_bad: bool,
    /// Elevation angles of the UAV [deg]: A:B:S with both ends, or a list; default 5:90:5
    #[arg(long, value_name = "LIST", value_parser = numbers, allow_hyphen_values = true, help_heading = "Sweep")]
    pub(super) theta: Option<Numbers>,
    /// Ground distances of the users [m], instead of elevation angles
    #[arg(long, value_name = "LIST", value_parser = numbers, allow_hyphen_values = true, help_heading = "Sweep",
          conflicts_with = "theta")]
    pub(super) distance: Option<Numbers>,
    /// Users over the whole area within this radius of the UAV [m], instead of on a circle
    #[arg(long, value_name = "LIST", value_parser = numbers, allow_hyphen_values = true, help_heading = "Sweep",
          conflicts_with_all = ["theta", "distance", "phi"])]
    pub(super) radius: Option<Numbers>,
    /// Azimuths [deg]: 0 across the user's street, 90 along it; default: the mean over all
    #[arg(long, value_name = "LIST", value_parser = numbers, allow_hyphen_values = true, help_heading = "Sweep",
          hide_short_help = true)]
    pub(super) phi: Option<Numbers>,
    /// Heights of the UAV above ground [m]; feet as 400ft
    #[arg(long, value_name = "LIST", value_parser = lengths, allow_hyphen_values = true, help_heading = "Sweep",
          default_value = "100")]
    pub(super) height: Numbers,
    /// Values of α instead of the city's
    #[arg(long, value_name = "LIST", value_parser = numbers, allow_hyphen_values = true, help_heading = "Sweep",
          hide_short_help = true)]
    pub(super) alpha: Option<Numbers>,
    /// Values of β instead of the city's [1/km²]
    #[arg(long, value_name = "LIST", value_parser = numbers, allow_hyphen_values = true, help_heading = "Sweep",
          hide_short_help = true)]
    pub(super) beta: Option<Numbers>,
    /// Values of γ instead of the city's [m]
    #[arg(long, value_name = "LIST", value_parser = numbers, allow_hyphen_values = true, help_heading = "Sweep",
          hide_short_help = true)]
    pub(super) gamma: Option<Numbers>,
    /// Which users are counted: outdoor, street, crossroad
    ///
    /// Several are separated by commas.
    #[arg(long, value_name = "WHO,…", value_parser = one_of::<Users>(), value_delimiter = ',', default_value = "outdoor",
          help_heading = "Sweep", hide_possible_values = true)]
    pub(super) users: Vec<Users>,
    /// Where the UAV hovers; several separated by commas
    #[arg(long, value_name = "WHERE,…", value_parser = one_of::<Placement>(), value_delimiter = ',',
          default_value = "anywhere", help_heading = "Sweep", hide_short_help = true)]
    pub(super) placement: Vec<Placement>,
    /// Height of the receivers above ground [m]; the paper's figures have 0
    #[arg(long, value_name = "M", value_parser = length, default_value = "1.5", allow_hyphen_values = true,
          help_heading = "Sweep")]
    pub(super) rx_height: f64,
    /// Count only UAVs that are clear of the roof below them; otherwise one inside a building is NLoS to all
    #[arg(long, help_heading = "Sweep", hide_short_help = true)]
    pub(super) uav_clear_of_roof: bool,
    /// Stop when all intervals are ±P or narrower
    #[arg(long, value_name = "±P", value_parser = plus_minus, help_heading = "Effort", hide_short_help = true)]
    pub(super) until: Option<f64>,
    /// How far any P_LoS may be off, such as 0.005, at the least effort: over a generated city the product with the fewest
    /// points, over a real one maps of the coarsest cells, for which that is so with 99 % confidence, as measured; says what
    /// was taken
    #[arg(long, value_name = "P", value_parser = number, allow_hyphen_values = true, help_heading = "Effort",
          conflicts_with = "until", hide_short_help = true)]
    pub(super) tolerance: Option<f64>,
    /// Confidence of the intervals
    #[arg(long, value_name = "C", value_parser = number, default_value = "0.95", help_heading = "Effort",
          hide_short_help = true)]
    pub(super) ci: f64,
    /// Cities that `city` draws
    #[arg(long, value_name = "N", default_value_t = 500, value_parser = clap::value_parser!(u64).range(1..=1_000_000),
          help_heading = "Effort", hide_short_help = true)]
    pub(super) cities: u64,
    /// Users on the circle, or in the area, of each city that `city` draws; with `--phi` 8, one in each octant
    #[arg(long, value_name = "N", default_value_t = 360, value_parser = clap::value_parser!(u32).range(1..=1_000_000),
          help_heading = "Effort", hide_short_help = true)]
    pub(super) users_per_city: u32,
    /// Links that `geometry` draws for each value
    #[arg(long, value_name = "N", default_value_t = 20_000, value_parser = clap::value_parser!(u64).range(1..),
          help_heading = "Effort", hide_short_help = true)]
    pub(super) links: u64,
    /// UAV positions over a real city
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u64).range(1..=1_000_000),
          help_heading = "Effort", hide_short_help = true)]
    pub(super) positions: u64,
    /// Over a real city P_LoS at an angle is that of users who see the UAV within so many degrees of it
    #[arg(long, value_name = "DEG", value_parser = number, default_value = "2.5", allow_hyphen_values = true,
          help_heading = "Effort", hide_short_help = true)]
    pub(super) theta_band: f64,
    /// Edge of the blocks of a real city that are resampled for its intervals [m]; default: an eighth of the city, at
    /// least 100 m
    #[arg(long, value_name = "M", value_parser = number, allow_hyphen_values = true, help_heading = "Effort",
          hide_short_help = true)]
    pub(super) block: Option<f64>,
    #[command(flatten)]
    pub(in crate::cli) reading: Reading,
    #[command(flatten)]
    pub(in crate::cli) out: OutputOptions,
    /// Write the table to this file
    #[arg(long, value_name = "FILE", help_heading = "Output", hide_short_help = true)]
    pub(super) csv: Option<PathBuf>,
    /// Kind of plot
    #[arg(long, value_name = "KIND", value_parser = one_of::<PlotKind>(), default_value = "auto", help_heading = "Picture",
          hide_short_help = true)]
    pub(super) plot: PlotKind,
    #[command(flatten)]
    pub(super) picture: PictureOptions,
}
