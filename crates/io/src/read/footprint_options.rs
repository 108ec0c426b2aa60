//! Options for reading footprints.

use skyshed_request::{BaseRule, DataAreaChoice, GroundChoice, HeightUnit, MissingHeights, Parts, Roofs};

use super::projection::Projection;
use crate::city::NodataAs;
use crate::input::Input;
use crate::raster::Crs;

/// Reading of footprints.
#[derive(Debug, Clone, PartialEq)]
pub struct FootprintOptions {
    /// Property that holds the height above ground; `None` is `height`, or the own top of solids.
    pub height_field: Option<String>,
    /// Property that holds the height of the top above the datum, instead.
    pub top_field: Option<String>,
    /// Unit of heights without one.
    pub height_unit: HeightUnit,
    /// Property that holds the ground below the building \[m above the datum\]. `None` is the first
    /// of the known names that a file has, where one is needed.
    pub base_field: Option<String>,
    /// Property that holds the number of storeys; `None` is the first of the known names that a
    /// feature has.
    pub levels_field: Option<String>,
    /// Property that holds the standard deviation of the error of the height \[m\], if any.
    pub height_error_field: Option<String>,
    /// Shape of roofs in files that hold surfaces; `None` is flat, with a warning.
    pub roofs: Option<Roofs>,
    /// Treatment of missing heights.
    pub missing: MissingHeights,
    /// Treatment of outlines that have parts.
    pub parts: Parts,
    /// Table of a GeoPackage; needed where it has several.
    pub layer: Option<String>,
    /// Terrain model, in the same CRS unless `project` is given.
    pub terrain: Option<Input>,
    /// Ground without a terrain. `None` is a plane at 0 m. For tops above the datum it is a plane in
    /// the median of the ground below buildings, which the file must hold.
    pub ground: Option<GroundChoice>,
    /// Extent of the receivers' grid: west, south, east, north \[CRS units\].
    pub extent: Option<[f64; 4]>,
    /// Box outside of which no building matters, where there is an extent: west, south, east, north
    /// \[CRS units\]. By default as far from the extent as engines can see.
    pub within: Option<[f64; 4]>,
    /// Cell size of the receivers' grid \[m\]; by default the terrain's, else 1.
    pub cell_m: Option<f64>,
    /// CRS to assume.
    pub crs: Option<Crs>,
    /// `true` to exchange x and y of all positions.
    pub swap_axes: bool,
    /// CRS of the scene, if it is not that of the file.
    pub project: Option<Projection>,
    /// Effect of nodata cells of the terrain, and of ground beyond it.
    pub nodata_as: NodataAs,
    /// Choice of the ground that a footprint stands on.
    pub base: BaseRule,
    /// Area in which the ground is known.
    pub data_area: DataAreaChoice,
    /// `true` to hash inputs of any size.
    pub always_hash: bool,
}

impl Default for FootprintOptions {
    /// Returns the default: heights in meters in the property `height`, on flat ground at 0 m, on a
    /// grid of 1 m over the footprints.
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
            ground: None,
            extent: None,
            within: None,
            cell_m: None,
            crs: None,
            swap_axes: false,
            project: None,
            nodata_as: NodataAs::default(),
            base: BaseRule::default(),
            data_area: DataAreaChoice::Auto,
            always_hash: false,
        }
    }
}

/// The property of a height where none is named.
pub(super) const HEIGHT: &str = "height";

impl FootprintOptions {
    /// Returns the property that heights are read from.
    pub(super) fn height_property(&self) -> &str {
        self.top_field.as_deref().or(self.height_field.as_deref()).unwrap_or(HEIGHT)
    }

    /// Returns `true` when the scene may need the ground below buildings from the file.
    pub(super) fn needs_bases(&self) -> bool {
        self.terrain.is_none() && !matches!(self.ground, Some(GroundChoice::Flat(_)))
    }
}
