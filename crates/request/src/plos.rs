//! Probability of line of sight over whole cities.

use skyshed_core::words;

use crate::part::{group, part};
use crate::{
    Fault, FilePath, LengthList, Meters, NumberList, OutputOptions, PictureOptions, Reading, Receiver, Table, filled,
    json,
};

words! {
    /// Users that count.
    pub enum Users {
        /// All ground that is not building, uniformly
        Outdoor = "outdoor",
        /// Streets between crossroads
        Street = "street",
        /// Crossroads
        Crossroad = "crossroad",
    }
}

words! {
    /// Places where the UAV hovers, uniformly.
    pub enum Placement {
        /// Anywhere over the city
        Anywhere = "anywhere",
        /// Over a street
        Street = "street",
        /// Over a crossroad
        Crossroad = "crossroad",
        /// Over a building
        Rooftop = "rooftop",
        /// Over the middle of a street
        StreetCenter = "street-center",
        /// Over the middle of a crossroad
        CrossroadCenter = "crossroad-center",
        /// Over the middle of a building
        RooftopCenter = "rooftop-center",
    }
}

words! {
    /// Kind of plot.
    pub enum PlotKind {
        /// A heat map for two-way sweeps of one city and method, else curves
        Auto = "auto",
        /// Curves
        Curves = "curves",
        /// Heat maps of two-way sweeps
        Heat = "heat",
    }
    default Auto
}

part! {
    /// Cities and methods of P_LoS.
    pub struct PlosOptions, SetPlosOptions {
        /// Generated cities (itu:…), whose α, β, γ count, and cities in files: rasters, footprints, meshes
        #[arg(value_name = "SCENE", required = true, num_args = 1..)]
        scenes: Vec<FilePath>,
        /// Methods, separated by commas: product, city, geometry, maps, ids of models such as itu, models, all
        ///
        /// auto: product, and maps over real cities. `models` are all that apply (itu, alhourani2014, holis2008, mohammed2023,
        /// kang2019, saboor2024, tr36777_uma_av, tr38811 …). An engine (ray, sweep, shadow) is that of the maps.
        #[arg(long, visible_alias = "methods", value_name = "LIST", value_delimiter = ',')]
        method: Vec<String>,
        /// A curve of your own: a table with the columns theta_deg (or distance_m) and p_los, `NAME=-` from standard input;
        /// repeat for more
        #[arg(long, value_name = "NAME=FILE", hide_short_help = true)]
        curve: Vec<FilePath>,
        /// Leave out rows of the curves that cannot be read, with a warning that names them
        #[arg(long, requires = "curve", hide_short_help = true)]
        skip_bad: bool,
    }
}

part! {
    /// Quantities that vary.
    #[cfg_attr(feature = "words", command(next_help_heading = "Sweep"))]
    pub struct SweepOptions, SetSweepOptions {
        /// Elevation angles of the UAV [deg]: A:B:S with both ends, or a list; default 5:90:5
        #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
        theta: Option<NumberList>,
        /// Ground distances of the users [m], instead of elevation angles
        #[arg(long, value_name = "LIST", allow_hyphen_values = true, conflicts_with = "theta")]
        distance: Option<NumberList>,
        /// Users over the whole area within this radius of the UAV [m], instead of on a circle
        #[arg(long, value_name = "LIST", allow_hyphen_values = true, conflicts_with_all = ["theta", "distance", "phi"])]
        radius: Option<NumberList>,
        /// Azimuths [deg]: 0 across the user's street, 90 along it; default: the mean over all
        #[arg(long, value_name = "LIST", allow_hyphen_values = true, hide_short_help = true)]
        phi: Option<NumberList>,
        /// Heights of the UAV above ground [m]; feet as 400ft
        #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
        height: Option<LengthList>,
        /// Values of α instead of the city's
        #[arg(long, value_name = "LIST", allow_hyphen_values = true, hide_short_help = true)]
        alpha: Option<NumberList>,
        /// Values of β instead of the city's [1/km²]
        #[arg(long, value_name = "LIST", allow_hyphen_values = true, hide_short_help = true)]
        beta: Option<NumberList>,
        /// Values of γ instead of the city's [m]
        #[arg(long, value_name = "LIST", allow_hyphen_values = true, hide_short_help = true)]
        gamma: Option<NumberList>,
        /// Users that count: outdoor, street, crossroad
        ///
        /// Several are separated by commas.
        #[arg(long, value_name = "WHO,…", value_parser = crate::words::one_of::<Users>(), value_delimiter = ',', hide_possible_values = true)]
        users: Vec<Users>,
        /// Place of the UAV; several separated by commas
        #[arg(long, value_name = "WHERE,…", value_parser = crate::words::one_of::<Placement>(), value_delimiter = ',', hide_short_help = true)]
        placement: Vec<Placement>,
        /// Count only UAVs that are clear of the roof below them; otherwise one inside a building is NLoS to all
        #[arg(long, hide_short_help = true)]
        uav_clear_of_roof: bool,
    }
}

part! {
    /// Effort of P_LoS.
    #[cfg_attr(feature = "words", command(next_help_heading = "Effort"))]
    pub struct PlosEffort, SetPlosEffort {
        /// Stop when all intervals are ±P or narrower
        #[arg(long, value_name = "±P", value_parser = crate::words::plus_minus, hide_short_help = true)]
        until: Option<f64>,
        /// Largest error of any P_LoS, such as 0.005, at the least effort
        ///
        /// Over a generated city it takes the product with the fewest points, over a real one maps of the coarsest cells that keep it
        /// with 99 % confidence, as measured. The run says what was taken.
        #[arg(long, value_name = "P", value_parser = crate::words::number, allow_hyphen_values = true, conflicts_with = "until", hide_short_help = true)]
        tolerance: Option<f64>,
        /// Confidence of the intervals
        #[arg(long, value_name = "C", value_parser = crate::words::number, hide_short_help = true)]
        ci: Option<f64>,
        /// Cities that `city` draws
        #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000), hide_short_help = true)]
        cities: Option<u64>,
        /// Users on the circle, or in the area, of each city that `city` draws; with `--phi` 8, one in each octant
        #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000), hide_short_help = true)]
        users_per_city: Option<u32>,
        /// Links that `geometry` draws for each value
        #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..), hide_short_help = true)]
        links: Option<u64>,
        /// UAV positions over a real city
        #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000), hide_short_help = true)]
        positions: Option<u64>,
        /// Over a real city P_LoS at an angle is that of users who see the UAV within so many degrees of it
        #[arg(long, value_name = "DEG", value_parser = crate::words::number, allow_hyphen_values = true, hide_short_help = true)]
        theta_band: Option<f64>,
        /// Edge of the blocks of a real city that are resampled for its intervals [m]; default: an eighth of the city, at
        /// least 100 m
        #[arg(long, value_name = "M", value_parser = crate::words::number, allow_hyphen_values = true, hide_short_help = true)]
        block: Option<f64>,
    }
}

part! {
    /// Form of a plot.
    #[cfg_attr(feature = "words", command(next_help_heading = "Picture"))]
    pub struct PlotOptions, SetPlotOptions {
        /// Kind of plot
        #[arg(long, value_name = "KIND", value_parser = crate::words::one_of::<PlotKind>(), hide_short_help = true)]
        plot: Option<PlotKind>,
    }
}

group! {
    /// Request of P_LoS.
    #[command(
        mut_arg("rx_height", |a| a.help("Height of the receivers above ground [m]; the paper's figures have 0")),
        mut_arg("output", |a| a.help("File to write: .png .svg .pdf .csv .json .npz; repeat for more").long_help(
            "File to write, by extension: .png .svg .pdf (plot), .csv, .json, .npz, `-` for JSON on standard output; repeat for \
             more. Without any the table goes to standard output")),
        after_help = "Example: skyshed plos itu:urban --theta 5:90:5 --method product,itu,alhourani2014 -o plos.png"
    )]
    pub struct PlosRequest {
        /// Cities and methods.
        plos: PlosOptions,
        /// Quantities that vary.
        sweep: SweepOptions,
        /// Height of the receivers.
        #[heading = "Sweep"]
        receiver: Receiver,
        /// Effort.
        effort: PlosEffort,
        /// Reading of cities in files.
        reading: Reading,
        /// Files and effort.
        out: OutputOptions,
        /// Table.
        table: Table,
        /// Form of a plot.
        plot: PlotOptions,
        /// Looks of pictures.
        picture: PictureOptions,
    }
}

crate::holds!(PlosRequest: plos PlosOptions, sweep SweepOptions, receiver Receiver, effort PlosEffort,
    reading.options crate::SceneOptions, plot PlotOptions);

/// Options of cities in files alone.
const OF_FILES: [&str; 26] = [
    "roofs",
    "terrain",
    "extent",
    "cell",
    "crs",
    "project",
    "building_threshold",
    "height_field",
    "top_field",
    "height_error_field",
    "missing",
    "nodata_as",
    "band",
    "ground",
    "hash",
    "positions",
    "block",
    "base",
    "data_area",
    "height_unit",
    "base_field",
    "levels_field",
    "parts",
    "layer",
    "theta_band",
    "attribution",
];

impl PlosRequest {
    /// Returns the defaults of the fields.
    pub fn defaults() -> PlosRequest {
        PlosRequest {
            plos: PlosOptions { method: vec!["auto".into()], ..PlosOptions::default() },
            sweep: SweepOptions {
                height: Some(LengthList(vec![100.0])),
                users: vec![Users::Outdoor],
                placement: vec![Placement::Anywhere],
                ..SweepOptions::default()
            },
            receiver: Receiver { rx_height: Some(Meters(1.5)) },
            effort: PlosEffort {
                ci: Some(0.95),
                cities: Some(500),
                users_per_city: Some(360),
                links: Some(20_000),
                positions: Some(200),
                theta_band: Some(2.5),
                ..PlosEffort::default()
            },
            plot: PlotOptions { plot: Some(PlotKind::Auto) },
            ..PlosRequest::default()
        }
    }

    /// Returns the methods.
    pub fn methods(&self) -> Vec<String> {
        if self.plos.method.is_empty() { PlosRequest::defaults().plos.method } else { self.plos.method.clone() }
    }

    /// Refuses options that change nothing for these cities and methods.
    ///
    /// # Errors
    /// E116.
    pub fn check(&self, has_file: bool, is_drawn: bool) -> crate::Result<()> {
        let members = json::set_members(self);
        let methods = self.methods();
        let uses = |names: &[&str]| methods.iter().any(|m| names.contains(&m.trim().to_lowercase().as_str()));
        if !has_file {
            json::refuse(&members, &OF_FILES, "without a city in a file")?;
        }
        if self.sweep.distance.is_some() || self.sweep.radius.is_some() {
            json::refuse(&members, &["theta_band"], "without `theta`")?;
        }
        json::refuse(&members, &["size"], "here: a city is as large as the links over it")?;
        json::refuse(&members, &["height_error_field"], "but for `map`, `place` and `compare`")?;
        if !uses(&["city", "all"]) {
            json::refuse(&members, &["cities", "users_per_city"], "without `method city`")?;
        }
        if !uses(&["geometry", "all"]) {
            json::refuse(&members, &["links"], "without `method geometry`")?;
        }
        if self.effort.until.is_some() && (self.effort.cities.is_some() || self.effort.links.is_some()) {
            return Err(Fault::idle("until", "together with `cities` or `links`, which fix the effort"));
        }
        if !is_drawn {
            json::refuse(&members, &["plot"], "without a .png, .svg or .pdf output")?;
        }
        Ok(())
    }

    /// Returns a number of the effort, with its default.
    pub fn number<T: Default>(&self, of: impl Fn(&PlosEffort) -> Option<T>) -> T {
        filled(of(&self.effort), of(&PlosRequest::defaults().effort))
    }
}
