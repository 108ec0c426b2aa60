//! How footprints are read.

use super::missing_heights::MissingHeights;
use super::projection::Projection;
use crate::city::NodataAs;
use crate::input::Input;
use crate::raster::Crs;

/// What becomes of an outline whose building is drawn by parts as well.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Parts {
    /// Parts stand in its place; beside them stands what they leave of it, if that is more than a tenth.
    #[default]
    Replace,
    /// Both stand, and the highest of what overlaps counts.
    Join,
}

/// The ground of footprints, where no terrain is given.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum GroundChoice {
    /// A plane at 0 m. Tops above the datum take a plane in the median of the ground below buildings, which the file must tell.
    #[default]
    Auto,
    /// A plane at so many meters above the datum.
    Flat(f64),
    /// A terrain through the ground below buildings, as the file tells it.
    Buildings,
}

/// Which of the terrain columns that a footprint's area overlaps it stands on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum BaseRule {
    /// The lowest, as OpenStreetMap defines `height`.
    #[default]
    Lowest,
    /// Their mean, each weighted by the area that is overlapped.
    Mean,
    /// The highest.
    Highest,
}

/// Where the ground of a footprint scene is known, as it was asked for.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum DataAreaChoice {
    /// Near the footprints; everywhere if the extent was typed.
    #[default]
    Auto,
    /// Everywhere.
    All,
    /// Within the polygons of a file.
    Within(Input),
}

/// The shape of roofs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Roofs {
    /// Each building as high as it is highest.
    Flat,
    /// As the surfaces of the file have them (level of detail 2).
    Lod2,
}

/// How footprints are read.
#[derive(Debug, Clone, PartialEq)]
pub struct FootprintOptions {
    /// Property that holds the height above ground; `None` is `height`, or of solids their own top.
    pub height_field: Option<String>,
    /// Property that holds the absolute height of the top above the datum, instead.
    pub top_field: Option<String>,
    /// Unit of heights that name none.
    pub height_unit: HeightUnit,
    /// Property that holds the ground below the building \[m above the datum\]; `None` is the first of the known names that a file has, where one
    /// is needed.
    pub base_field: Option<String>,
    /// Property that holds the number of storeys; `None` is the first of the known names that a feature has.
    pub levels_field: Option<String>,
    /// Property that holds the standard deviation of the error of the height \[m\], if one does.
    pub height_error_field: Option<String>,
    /// The shape of roofs, of files that hold surfaces; flat, which is told, where nothing is said.
    pub roofs: Option<Roofs>,
    /// What becomes of missing heights.
    pub missing: MissingHeights,
    /// What becomes of outlines that have parts.
    pub parts: Parts,
    /// Table of a GeoPackage; needed where it has several.
    pub layer: Option<String>,
    /// Terrain model, in the same CRS unless `project` is given.
    pub terrain: Option<Input>,
    /// The ground without a terrain.
    pub ground: GroundChoice,
    /// Extent of the receivers' grid: west, south, east, north \[CRS units\].
    pub extent: Option<[f64; 4]>,
    /// How far from the extent a building can matter at most \[m\]; by default as far as engines can see.
    pub reach_m: Option<f64>,
    /// Cell size of the receivers' grid \[m\]; by default the terrain's, else 1.
    pub cell_m: Option<f64>,
    /// The CRS to assume.
    pub crs: Option<Crs>,
    /// Another CRS for the scene than that of the file.
    pub project: Option<Projection>,
    /// What nodata cells of the terrain, and ground beyond it, do.
    pub nodata_as: NodataAs,
    /// Which ground a footprint stands on.
    pub base: BaseRule,
    /// Where the ground is known.
    pub data_area: DataAreaChoice,
    /// Whether to hash inputs of any size.
    pub always_hash: bool,
}

impl Default for FootprintOptions {
    /// Heights in meters in the property `height`, on flat ground at 0 m, on a grid of 1 m over the footprints.
    fn default() -> Self {
        FootprintOptions {
            height_field: None,
            top_field: None,
            height_unit: HeightUnit::default(),
            base_field: None,
            levels_field: None,
            height_error_field: None,
            roofs: None,
            missing: MissingHeights::default(),
            parts: Parts::default(),
            layer: None,
            terrain: None,
            ground: GroundChoice::default(),
            extent: None,
            reach_m: None,
            cell_m: None,
            crs: None,
            project: None,
            nodata_as: NodataAs::default(),
            base: BaseRule::default(),
            data_area: DataAreaChoice::default(),
            always_hash: false,
        }
    }
}

/// The unit of heights that name none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum HeightUnit {
    /// Meters.
    #[default]
    Meters,
    /// International feet, 0.3048 m.
    Feet,
}

impl HeightUnit {
    /// Length of the unit \[m\].
    pub fn meters(self) -> f64 {
        match self {
            HeightUnit::Meters => 1.0,
            HeightUnit::Feet => METERS_PER_FOOT,
        }
    }
}

pub(super) const METERS_PER_FOOT: f64 = 0.3048;

/// The property of a height where none is named.
pub(super) const HEIGHT: &str = "height";

impl FootprintOptions {
    /// The property that heights are read from.
    pub(super) fn height_property(&self) -> &str {
        self.top_field.as_deref().or(self.height_field.as_deref()).unwrap_or(HEIGHT)
    }

    /// Whether the ground is that below buildings, as the file tells it.
    pub(super) fn needs_bases(&self) -> bool {
        self.terrain.is_none() && !matches!(self.ground, GroundChoice::Flat(_))
    }
}
