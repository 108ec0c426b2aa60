//! Coverage as polygons: the outlines of the connected parts of a class.

use super::{SiteCoverage, class};
use crate::outlines::{CellPart, cell_parts, doubled_cells, simpler_rings};
use crate::raster::{BitGrid, GeoRef};

/// Classes that are outlined, and how closely.
#[derive(Debug, Clone, PartialEq)]
pub struct PolygonOptions {
    /// The classes of the mask, in order.
    pub classes: Vec<u8>,
    /// Largest distance of an outline from the cell edges \[m\]; along them if `None`.
    pub simplify_m: Option<f64>,
    /// Length of a unit of the CRS \[m\].
    pub meters_per_unit: f64,
}

/// Cells of one class around one UAV that hang together by their sides.
#[derive(Debug, Clone, PartialEq)]
pub struct CoveragePolygon {
    /// The UAV.
    pub site: String,
    /// The class, as in [`class::NAMES`].
    pub class: u8,
    /// Number of its cells.
    pub n_cells: u64,
    /// Area of the polygon as it is drawn \[m²\].
    pub area_m2: f64,
    /// The shell counterclockwise, then holes clockwise; not closed \[CRS units\].
    pub rings: Vec<Vec<[f64; 2]>>,
}

/// Returns the polygons of some UAVs, by UAV, class and place, those that begin farther south
/// first.
///
/// Each part has a polygon of its own, as in what GIS make of a raster: a spatial index finds it,
/// and small ones can be selected by area.
pub fn coverage_polygons(sites: &[SiteCoverage], grid: &GeoRef, options: &PolygonOptions) -> Vec<CoveragePolygon> {
    let each = |site| options.classes.iter().map(move |class| (site, *class));
    sites.iter().flat_map(each).flat_map(|(site, class)| polygons_of(site, class, grid, options)).collect()
}

fn polygons_of(site: &SiteCoverage, class: u8, grid: &GeoRef, options: &PolygonOptions) -> Vec<CoveragePolygon> {
    let mut set = BitGrid::new(grid.n_rows(), grid.n_cols());
    let cells = site.mask.iter().enumerate().filter(|(_, found)| **found == class);
    cells.for_each(|(cell, _)| set.insert(cell / grid.n_cols(), cell % grid.n_cols()));
    let cell_m = (grid.cell_width() * options.meters_per_unit, grid.cell_height() * options.meters_per_unit);
    let polygon = |part: CellPart| {
        let rings = match options.simplify_m {
            Some(tolerance) => simpler_rings(&part.rings, cell_m, tolerance),
            None => part.rings,
        };
        let cells: i64 = rings.iter().map(|ring| doubled_cells(ring)).sum();
        #[expect(clippy::cast_precision_loss, reason = "counts of cells are far below 2^53")]
        let area_m2 = cells as f64 / 2.0 * cell_m.0 * cell_m.1;
        CoveragePolygon {
            site: site.uav.id.clone(),
            class,
            n_cells: part.n_cells,
            area_m2,
            rings: rings.iter().map(|ring| ring.iter().map(|c| grid.world_from_corner(*c)).collect()).collect(),
        }
    };
    cell_parts(&set).into_iter().map(polygon).collect()
}

impl CoveragePolygon {
    /// Returns the name of its class.
    pub fn class_name(&self) -> &'static str {
        class::NAMES.iter().find(|(value, _)| *value == self.class).map_or("", |(_, name)| name)
    }
}
