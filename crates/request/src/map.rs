//! Maps: the coverage of UAVs, and its files.

use crate::part::{group, part};
use crate::{
    Antenna, Earth, FilePath, HeightErrors, Layer, OutputOptions, PictureOptions, PolygonClasses, Range, Reading,
    Receiver, SceneOptions, SceneWord, Sight, TiffLayout, Uavs, Writing,
};

part! {
    /// Layers and counts of a map.
    pub struct MapOptions, SetMapOptions {
        /// Standard deviations that heights are within for the layer `sure`
        #[arg(long, value_name = "K", value_parser = crate::words::number, allow_hyphen_values = true, hide_short_help = true)]
        sigma: Option<f64>,
        /// Largest error of the P_LoS of any UAV, such as 0.005: makes the map on the coarsest cells that keep it
        ///
        /// It holds with 99 % confidence, measured on a sample of receivers that are decided exactly. The run says what was taken and
        /// measured.
        #[arg(long, value_name = "P", value_parser = crate::words::number, allow_hyphen_values = true, hide_short_help = true)]
        tolerance: Option<f64>,
        /// Layers to make, separated by commas; pictures show the first
        ///
        /// Of several UAVs they show the number that see a cell for `los`, colors or a map each for the others.
        #[arg(long, value_name = "LAYER,…", value_parser = crate::words::one_of::<Layer>(), value_delimiter = ',', hide_possible_values = true)]
        layers: Vec<Layer>,
        /// Count receivers by zone too (street, crossroad, courtyard, rooftop) in the table and the document: finding zones costs
        /// as much as a map or more
        #[arg(long, hide_short_help = true)]
        zones: bool,
    }
}

impl MapOptions {
    /// Returns the defaults of the fields.
    pub fn defaults() -> MapOptions {
        MapOptions { sigma: Some(2.0), layers: vec![Layer::Los], ..MapOptions::default() }
    }

    /// Returns the layers to make, each once.
    pub fn wanted_layers(&self) -> Vec<Layer> {
        let mut layers = Vec::new();
        let given = if self.layers.is_empty() { MapOptions::defaults().layers } else { self.layers.clone() };
        given.into_iter().for_each(|layer| {
            if !layers.contains(&layer) {
                layers.push(layer);
            }
        });
        layers
    }

    /// Refuses options that change nothing.
    ///
    /// # Errors
    /// E116.
    pub fn check(&self) -> crate::Result<()> {
        match self.sigma {
            Some(_) if !self.layers.contains(&Layer::Sure) => {
                Err(crate::Fault::idle("sigma", "without the layer `sure`"))
            }
            _ => Ok(()),
        }
    }
}

group! {
    /// Question of what UAVs see.
    pub struct CoverageQuestion {
        /// Receivers, range, antennas and earth.
        sight: Sight,
        /// Errors of building heights.
        heights: HeightErrors,
        /// Layers and counts.
        map: MapOptions,
    }
}

crate::holds!(CoverageQuestion: sight.receiver Receiver, sight.range Range, sight.antenna Antenna, sight.earth Earth,
    heights HeightErrors, map MapOptions);

part! {
    /// Forms of the files of a map, where their extensions leave that open.
    #[cfg_attr(feature = "words", command(next_help_heading = "Output"))]
    pub struct MapForms, SetMapForms {
        /// PNG with one pixel per cell, a world file and a .prj, instead of a picture
        #[arg(long, hide_short_help = true)]
        bare: bool,
        /// Arrangement of the cells in .tif files
        #[arg(long, value_name = "HOW", value_parser = crate::words::one_of::<TiffLayout>(), hide_short_help = true)]
        tif_layout: Option<TiffLayout>,
        /// Mask of one UAV in .tif and .bil files as `gdal_viewshed` writes it: 255 in line of sight, 0 everywhere else, also out
        /// of range, and no nodata
        #[arg(long, hide_short_help = true)]
        gdal_values: bool,
        /// Coverage as polygons in .geojson and .fgb files, one per connected part of a class and site, holes kept
        #[arg(long, value_name = "CLASS", value_parser = crate::words::one_of::<PolygonClasses>(), hide_short_help = true)]
        polygons: Option<PolygonClasses>,
        /// Largest distance of an outline of the polygons from the cell edges [m]; each stays valid, neighbors may overlap by as
        /// much
        #[arg(long, value_name = "M", value_parser = crate::words::number, allow_hyphen_values = true, requires = "polygons", hide_short_help = true)]
        simplify: Option<f64>,
    }
}

group! {
    /// Files of a map: their forms, their looks, and rules of writing.
    ///
    /// ```
    /// use skyshed_request::{SaveOptions, SetMapForms, SetPictureOptions, SetWriting};
    ///
    /// // A pixel for each cell, where a file of that name may stand already.
    /// let options = SaveOptions::default().bare(true).overwrite(true);
    /// assert_eq!(options.title("Coverage").picture.title.as_deref(), Some("Coverage"));
    /// ```
    pub struct SaveOptions {
        /// Forms of files.
        forms: MapForms,
        /// Looks of pictures.
        picture: PictureOptions,
        /// Rules of writing.
        writing: Writing,
    }
}

crate::holds!(SaveOptions: forms MapForms, picture PictureOptions, writing Writing);

part! {
    /// Units of work of a map.
    #[cfg_attr(feature = "words", command(next_help_heading = "Units of work"))]
    pub struct MapUnits, SetMapUnits {
        /// Only the K-th of N nearly equal parts of the UAVs in their order, or of the tiles: for schedulers that hand out
        /// numbers
        #[arg(long, value_name = "K/N", hide_short_help = true)]
        shard: Option<crate::Shard>,
        /// Only this tile of the ground, row from the north and column from the west, from 0; repeat for more
        #[arg(long, value_name = "ROW,COL", hide_short_help = true)]
        tile: Vec<crate::TileIndex>,
        /// Cells along a side of a tile, a multiple of 16
        #[arg(long, value_name = "N", value_parser = crate::words::cells_per_side, hide_short_help = true)]
        tile_size: Option<usize>,
        /// Skip a UAV or a tile whose files exist and were made by the same run: an interrupted one goes on where it stopped
        #[arg(long, hide_short_help = true)]
        resume: bool,
    }
}

part! {
    /// Memory of a map of a raster.
    #[cfg_attr(feature = "words", command(next_help_heading = "Output"))]
    pub struct MapMemory, SetMapMemory {
        /// Sweep a raster strip by strip from a copy in tiles on disk, also where it fits in memory: the same cells, less memory
        #[arg(long, hide_short_help = true)]
        strips: bool,
        /// Folder for that copy (4 bytes a cell, in a file without a name); default: the system's folder for temporary files
        #[arg(long, value_name = "FOLDER", hide_short_help = true)]
        scratch: Option<FilePath>,
    }
}

part! {
    /// Height curve of a map.
    #[cfg_attr(feature = "words", command(next_help_heading = "Height curve"))]
    pub struct HeightCurve, SetHeightCurve {
        /// P_LoS as a function of the UAV's height over each place, exact: a plot (.png, .svg, .pdf), a table (.csv) or a document
        /// (.json); repeat for more.
        #[arg(long, value_name = "FILE", hide_short_help = true)]
        height_curve: Vec<FilePath>,
        /// Heights of the curve's table and plot above the ground below the UAV [m]: from, to, step, both ends included
        ///
        /// Above the datum where no ground is known. By default some 150 round ones from the lowest that the UAV may have. They end
        /// at three times the highest UAV or building, or where 99 % of the receivers are seen.
        #[arg(long, value_name = "A:B:S", allow_hyphen_values = true, requires = "height_curve", hide_short_help = true)]
        curve_heights: Option<crate::HeightRange>,
    }
}

part! {
    /// Counts of a map over time.
    #[cfg_attr(feature = "words", command(next_help_heading = "Time"))]
    pub struct OverTime, SetOverTime {
        /// Counts between the moments at which UAVs come and go (columns `from` and `to` of --uavs), and their mean over time
        ///
        /// A table (.csv) or a document (.json); repeat for more.
        #[arg(long, value_name = "FILE", hide_short_help = true)]
        over_time: Vec<FilePath>,
    }
}

group! {
    /// Request of a map: the question, and its run.
    #[command(
        mut_arg("output", |a| a.help("File to write: .png .svg .pdf .tif .exr .asc .bil .npz .kmz .csv .json .geojson .fgb").long_help(
            "File to write, by extension: .png .svg .pdf .tif .exr .asc .bil .npz .kmz .csv .json .geojson .fgb, `-` for JSON on \
             standard output; repeat for more. Without any the table goes to standard output. With `{site}` in every name each UAV \
             gets files of its own, which appear as soon as they are complete; with `{row}` and `{col}` each tile of the ground does, \
             with the layers of all UAVs together. With `--radius`, a map of a raster is of the part in range, and no more is read")),
        mut_arg("sector", |a| a.hide_short_help(false)),
        after_help = "Example: skyshed map maps/munich.geojson --uav 691549.7,5334762.2,120 --radius 300 -o munich.png"
    )]
    pub struct MapRequest {
        /// Scene.
        scene: SceneWord,
        /// Reading of the scene.
        reading: Reading,
        /// UAVs.
        #[heading = "Map"]
        uavs: Uavs,
        /// Question of what they see.
        #[heading = "Map"]
        coverage: CoverageQuestion,
        /// Height curve.
        curve: HeightCurve,
        /// Counts over time.
        time: OverTime,
        /// Files and effort.
        out: OutputOptions,
        /// Forms of files.
        forms: MapForms,
        /// Units of work.
        units: MapUnits,
        /// Memory.
        memory: MapMemory,
        /// Looks of pictures.
        picture: PictureOptions,
    }
}

crate::holds!(MapRequest: scene SceneWord, reading.options SceneOptions, reading.list crate::Repairs, uavs Uavs, coverage.sight.receiver Receiver,
    coverage.sight.range Range, coverage.sight.antenna Antenna, coverage.sight.earth Earth, coverage.heights HeightErrors,
    coverage.map MapOptions, curve HeightCurve, time OverTime, out.files crate::Files, out.writing Writing, out.effort crate::Effort,
    forms MapForms, units MapUnits, memory MapMemory, picture PictureOptions);

impl MapRequest {
    /// Returns the options of files.
    pub fn save_options(&self) -> SaveOptions {
        let MapRequest { forms, picture, out, .. } = self;
        SaveOptions { forms: forms.clone(), picture: picture.clone(), writing: out.writing.clone() }
    }
}
