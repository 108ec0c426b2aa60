//! Requests of commands whose options are few: `link`, `city`, `info`, `zones`, `limits`, `compare`, `sample`,
//! `live`, `chart`, `stress`.

use crate::part::{group, part};
use crate::{
    Earth, FilePath, HeightErrors, Heights, Meters, OutputOptions, PictureOptions, Reading, Receiver, SceneWord, Sight,
    Source, Table, TrackOptions, Uavs, ZoneCount,
};

part! {
    /// Receivers of links.
    pub struct LinkOptions, SetLinkOptions {
        /// A receiver: x, y and height (1.5, 1.5roof, 30amsl), `--rx-height` above ground without one; repeat for more
        #[arg(long, value_name = "X,Y[,H]", allow_hyphen_values = true, required_unless_present = "rxs")]
        rx: Vec<String>,
        /// Receivers from a table (.csv) or points (.geojson .gpx .kml), with or without heights
        #[arg(long, value_name = "FILE")]
        rxs: Option<Source>,
        /// Link the first UAV with the first receiver, the second with the second, and so on, instead of all with all
        #[arg(long)]
        pairs: bool,
        /// Decide line of sight alone, without margins and obstacles
        #[arg(long)]
        los_only: bool,
        /// Refuse a receiver that is farther away [m]; of many, leave its link without an answer
        #[arg(long, value_name = "M", value_parser = crate::words::number, allow_hyphen_values = true)]
        radius: Option<f64>,
    }
}

group! {
    /// Request of one link, or of links between lists.
    #[command(
        mut_arg("output", |a| a.help("File to write: .png .svg .pdf .json; of many links .csv .json .geojson .npz").long_help(
            "Side view of a link (.png, .svg, .pdf) or its document (.json); of many links a table (.csv), the document (.json), lines \
             (.geojson), arrays (.npz); `-` for JSON on standard output; repeat for more. Without any the answer goes to standard \
             output")),
        after_help = "Example: skyshed link itu:urban --uav 500,500,100 --rx 630,480"
    )]
    pub struct LinkRequest {
        /// Scene.
        scene: SceneWord,
        /// Reading of the scene.
        reading: Reading,
        /// UAVs.
        #[heading = "Link"]
        uavs: Uavs,
        /// Receivers.
        #[heading = "Link"]
        link: LinkOptions,
        /// Height of the receiver.
        #[heading = "Link"]
        receiver: Receiver,
        /// Curve of the earth.
        #[heading = "Link"]
        earth: Earth,
        /// Files and effort.
        out: OutputOptions,
        /// Looks of pictures.
        picture: PictureOptions,
    }
}

group! {
    /// Request of a city, made or converted.
    #[command(
        mut_arg("output", |a| a.help("File to write: .png .svg .pdf .tif .asc .geojson .xml .csv .json; repeat for more").long_help(
            "File to write, by extension: .png .svg .pdf (plan and 3-D view), .tif .asc (surface heights), .geojson (footprints), \
             .xml (scene of Mitsuba and Sionna RT, with meshes), .csv (boxes of ns-3), .json (parameters); repeat for more. Without \
             any what the city is goes to standard output")),
        after_help = "Example: skyshed city itu:urban --size 400 -o city.png -o city.geojson"
    )]
    pub struct CityRequest {
        /// Scene.
        scene: SceneWord,
        /// Reading of the scene.
        reading: Reading,
        /// Files and effort.
        out: OutputOptions,
        /// Looks of pictures.
        picture: PictureOptions,
    }
}

part! {
    /// Statistics of a city by squares.
    #[cfg_attr(feature = "words", command(next_help_heading = "Scene"))]
    pub struct InfoOptions, SetInfoOptions {
        /// Also α, β and γ of squares of this size, from the north-west corner [m]
        ///
        /// A raster (.tif) or a table (.csv); squares that the extent cuts have the values of what is left of them.
        #[arg(long, value_name = "M", value_parser = crate::words::number, allow_hyphen_values = true)]
        tile: Option<f64>,
    }
}

group! {
    /// Request of the facts of a file.
    #[command(
        mut_arg("scene", |a| a.help("A scene, as of any command; a file of UAVs or of a track (.csv, .geojson); or a file that this \
                                     program wrote")),
        mut_arg("output", |a| a.help("File to write: .json, with `--tile` also .tif .csv; repeat for more").long_help(
            "File to write, by extension: .json; with `--tile` also a raster of α, β, γ (.tif) or their table (.csv); `-` for JSON \
             on standard output; repeat for more")),
        after_help = "Example: skyshed info maps/munich.geojson"
    )]
    pub struct InfoRequest {
        /// Scene.
        scene: SceneWord,
        /// Reading of the scene.
        reading: Reading,
        /// Statistics by squares.
        info: InfoOptions,
        /// Files and effort.
        out: OutputOptions,
    }
}

group! {
    /// Request of streets, crossroads, courtyards and rooftops.
    #[command(
        mut_arg("output", |a| a.help("File to write: .png .svg .pdf .tif .geojson .json; repeat for more").long_help(
            "File to write, by extension: a map of the zones (.png .svg .pdf), a raster (.tif), polygons (.geojson), their counts \
             (.json), `-` for JSON on standard output; repeat for more")),
        after_help = "Example: skyshed zones maps/munich.geojson -o zones.png"
    )]
    pub struct ZonesRequest {
        /// Scene.
        scene: SceneWord,
        /// Reading of the scene.
        reading: Reading,
        /// Files and effort.
        out: OutputOptions,
        /// Looks of pictures.
        picture: PictureOptions,
    }
}

part! {
    /// Uncertainties of a map.
    #[cfg_attr(feature = "words", command(next_help_heading = "Uncertainty"))]
    pub struct LimitsOptions, SetLimitsOptions {
        /// Distance of the UAV from where it should be, sideways and in height [m]
        #[arg(long, value_name = "M", value_parser = crate::words::number, allow_hyphen_values = true)]
        uav_error: Option<f64>,
        /// Error of the heights of all buildings [m]
        #[arg(long, value_name = "M", value_parser = crate::words::number, allow_hyphen_values = true)]
        height_error: Option<f64>,
        /// Other cities of a generated kind that tell how much one city of many matters
        #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(2..=1000))]
        cities: Option<u16>,
    }
}

group! {
    /// Request of the limits of a map.
    #[command(
        mut_arg("output", |a| a.help("File to write: .csv .json; repeat for more").long_help(
            "File to write, by extension: .csv (what limits P_LoS), .json, `-` for JSON on standard output; repeat for more. \
             Without any the answer goes to standard output")),
        after_help = "Example: skyshed limits itu:urban --uav 500,500,100 --radius 300"
    )]
    pub struct LimitsRequest {
        /// Scene.
        scene: SceneWord,
        /// Reading of the scene.
        reading: Reading,
        /// UAVs.
        #[heading = "Map"]
        uavs: Uavs,
        /// Receivers, range, antennas and earth.
        #[heading = "Map"]
        sight: Sight,
        /// Uncertainties.
        limits: LimitsOptions,
        /// Files and effort.
        out: OutputOptions,
    }
}

part! {
    /// Placements to compare, beside UAVs.
    #[cfg_attr(feature = "words", command(next_help_heading = "Placements"))]
    pub struct CompareOptions, SetCompareOptions {
        /// A saved map on the scene's grid (.tif or .asc with the classes of `skyshed map`), named after its file; repeat for
        /// more
        #[arg(long, value_name = "FILE")]
        mask: Vec<FilePath>,
        /// Edge of the blocks of ground that are resampled for intervals [m]
        #[arg(long, value_name = "M", value_parser = crate::words::number, allow_hyphen_values = true)]
        block: Option<f64>,
    }
}

group! {
    /// Request of placements side by side.
    #[command(
        mut_arg("output", |a| a.help("File to write: .html .png .svg .pdf .tif .csv .json; repeat for more").long_help(
            "File to write, by extension: .html (a page to swipe over, in one file), .png .svg .pdf (all maps on one sheet), .tif \
             (masks, differences, count), .csv, .json, `-` for JSON on standard output; repeat for more. Without any the table goes \
             to standard output")),
        after_help = "Example: skyshed compare itu:urban --uav 500,500,100 --uav 560,440,100 -o compare.html"
    )]
    pub struct CompareRequest {
        /// Scene.
        scene: SceneWord,
        /// Reading of the scene.
        reading: Reading,
        /// UAVs.
        #[heading = "Placements"]
        uavs: Uavs,
        /// Other placements.
        compare: CompareOptions,
        /// Receivers, range, antennas and earth.
        #[heading = "Placements"]
        sight: Sight,
        /// Errors of building heights.
        #[heading = "Placements"]
        heights: HeightErrors,
        /// Files and effort.
        out: OutputOptions,
        /// Table.
        table: Table,
        /// Looks of pictures.
        picture: PictureOptions,
    }
}

part! {
    /// Samples of placements over each zone.
    #[cfg_attr(feature = "words", command(next_help_heading = "Sample"))]
    pub struct SampleOptions, SetSampleOptions {
        /// Zones, and the number of placements over each: street:200,crossroad:200,rooftop:200
        #[arg(long, value_name = "ZONE:N,…", value_delimiter = ',', required = true)]
        zones: Vec<ZoneCount>,
        /// Heights of the UAVs above ground [m]: a list such as 60,400ft, or A:B:S with both ends
        #[arg(long, value_name = "H,…", allow_hyphen_values = true, required = true)]
        height: Option<Heights>,
        /// Placements stand over the middles of a generated city's crossroads, streets and buildings
        #[arg(long)]
        centers: bool,
        /// Generated cities to sample, from `--seed` on; intervals are over cities
        #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=100_000))]
        cities: Option<u64>,
        /// Confidence of the intervals
        #[arg(long, value_name = "C", value_parser = crate::words::number, hide_short_help = true)]
        ci: Option<f64>,
        /// Edge of the blocks of ground that are resampled for the intervals over one city [m]; default: an eighth of the
        /// city, at least 100 m
        #[arg(long, value_name = "M", value_parser = crate::words::number, allow_hyphen_values = true, hide_short_help = true)]
        block: Option<f64>,
    }
}

group! {
    /// Request of P_LoS averaged over placements of each zone.
    #[command(
        mut_arg("size", |a| a.help("Edge length of a generated city, or with a radius of the ground below placements [m]")),
        mut_arg("output", |a| a.help("File to write: .png .svg .pdf .csv .json; repeat for more").long_help(
            "File to write, by extension: .png .svg .pdf (bars with intervals), .csv, .json, `-` for JSON on standard output; \
             repeat for more. Without any the table goes to standard output")),
        after_help = "Example: skyshed sample itu:urban --zones street:50,crossroad:50,rooftop:50 --height 60,100 --radius 300"
    )]
    pub struct SampleRequest {
        /// Scene.
        scene: SceneWord,
        /// Reading of the scene.
        reading: Reading,
        /// Samples.
        sample: SampleOptions,
        /// Receivers, range, antennas and earth.
        #[heading = "Sample"]
        sight: Sight,
        /// Files and effort.
        out: OutputOptions,
        /// Table.
        table: Table,
        /// Looks of pictures.
        picture: PictureOptions,
    }
}

group! {
    /// Request of a live page.
    #[command(
        mut_arg("output", |a| a.help("File to write: .html .json; without any the page is opened").long_help(
            "Page to write (.html), what it holds (.json), `-` for JSON on standard output; repeat for more. Without any the page is \
             written to the folder for temporary files, and opened")),
        after_help = "Example: skyshed live maps/munich.geojson -o munich.html"
    )]
    pub struct LiveRequest {
        /// Scene.
        scene: SceneWord,
        /// Reading of the scene.
        reading: Reading,
        /// UAVs.
        #[heading = "Start"]
        uavs: Uavs,
        /// Receivers, range, antennas and earth.
        #[heading = "Start"]
        sight: Sight,
        /// Walk or flight that the page shows.
        #[heading = "Track"]
        track: TrackOptions,
        /// Files and effort.
        out: OutputOptions,
        /// Looks of pictures.
        picture: PictureOptions,
    }
}

part! {
    /// Contest of methods.
    #[cfg_attr(feature = "words", command(next_help_heading = "Contest"))]
    pub struct ChartOptions, SetChartOptions {
        /// Other programs, too: `gdal_viewshed` if it is found on the PATH, with its own files read and written
        #[arg(long)]
        peers: bool,
        /// Time each contestant for at least so long, and at least three times; those above half a second once [s]
        #[arg(long, value_name = "S", value_parser = crate::words::number, allow_hyphen_values = true)]
        time: Option<f64>,
        /// The P_LoS methods of a generated city instead: standard error, or the bias of a model, against CPU time
        #[arg(long)]
        plos: bool,
        /// With `--plos`: elevation angle of the UAV [deg]; at 45 no model is at an end of its range
        #[arg(long, value_name = "DEG", value_parser = crate::words::number, allow_hyphen_values = true, requires = "plos", hide_short_help = true)]
        theta: Option<f64>,
        /// With `--plos`: height of the UAV above ground [m]
        #[arg(long, value_name = "M", allow_hyphen_values = true, requires = "plos", hide_short_help = true)]
        height: Option<Meters>,
    }
}

group! {
    /// Request of speed against accuracy.
    #[command(
        mut_arg("output", |a| a.help("File to write: .png .svg .pdf .csv .json; repeat for more").long_help(
            "File to write, by extension: .png .svg .pdf (picture), .csv, .json, `-` for JSON on standard output; repeat for more. \
             Without any the table goes to standard output")),
        after_help = "Example: skyshed chart itu:urban --size 300 --uav 150,150,100 --time 0.05 -o chart.png"
    )]
    pub struct ChartRequest {
        /// Scene.
        scene: SceneWord,
        /// Reading of the scene.
        reading: Reading,
        /// UAVs.
        #[heading = "Contest"]
        uavs: Uavs,
        /// Receivers, range, antennas and earth.
        #[heading = "Contest"]
        sight: Sight,
        /// Contest.
        chart: ChartOptions,
        /// Files and effort.
        out: OutputOptions,
        /// Table.
        table: Table,
        /// Looks of pictures.
        picture: PictureOptions,
    }
}

impl ChartOptions {
    /// Returns the defaults of the fields.
    pub fn defaults() -> ChartOptions {
        ChartOptions { time: Some(0.2), theta: Some(45.0), height: Some(Meters(100.0)), ..ChartOptions::default() }
    }
}

part! {
    /// Families of small scenes, or a scene.
    pub struct StressOptions, SetStressOptions {
        /// A scene whose stability is asked for, with `--uav`: generated city, raster, footprints or mesh. Without one, all methods
        /// are tried on families of small scenes where methods fail
        #[arg(value_name = "SCENE", requires = "uav")]
        scene: Option<FilePath>,
        /// Only these families of scenes, separated by commas, such as cell-slits,prism-walls; default all
        #[arg(long, value_name = "NAME,…", value_delimiter = ',', help_heading = "Families", conflicts_with = "scene")]
        families: Vec<String>,
        /// Scenes of each family
        #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000), help_heading = "Families",
              conflicts_with = "scene")]
        scenes: Option<u32>,
        /// The UAV over SCENE: x, y in its CRS and height (120, 120agl, 30roof, 150amsl, 400ft)
        #[arg(long, value_name = "X,Y,H", allow_hyphen_values = true, help_heading = "Map", requires = "scene")]
        uav: Option<String>,
    }
}

impl StressOptions {
    /// Returns the defaults of the fields.
    pub fn defaults() -> StressOptions {
        StressOptions { scenes: Some(128), ..StressOptions::default() }
    }
}

group! {
    /// Request of failures of methods.
    #[command(
        mut_arg("output", |a| a.help("File to write: .png .svg .pdf .csv .json; repeat for more").long_help(
            "File to write, by extension: .png .svg .pdf (failure rates by family and method; of SCENE a map of what turns), .csv, \
             .json, `-` for JSON on standard output; repeat for more. Without any the table goes to standard output")),
        after_help = "Example: skyshed stress --scenes 4 -o failures.png"
    )]
    pub struct StressRequest {
        /// Families, or a scene.
        stress: StressOptions,
        /// Receivers, range, antennas and earth.
        #[heading = "Map"]
        sight: Sight,
        /// Reading of the scene.
        reading: Reading,
        /// Files and effort.
        out: OutputOptions,
        /// Looks of pictures.
        picture: PictureOptions,
    }
}

impl LimitsOptions {
    /// Returns the defaults of the fields.
    pub fn defaults() -> LimitsOptions {
        LimitsOptions { uav_error: Some(1.0), height_error: Some(1.0), cities: Some(10) }
    }
}

impl CompareOptions {
    /// Returns the defaults of the fields.
    pub fn defaults() -> CompareOptions {
        CompareOptions { block: Some(50.0), ..CompareOptions::default() }
    }
}

impl SampleOptions {
    /// Returns the defaults of the fields.
    pub fn defaults() -> SampleOptions {
        SampleOptions { cities: Some(1), ci: Some(0.95), ..SampleOptions::default() }
    }
}
