//! Pictures of maps, cities, links and curves.
//!
//! A picture is a pure function of plain slices: no file, no clock, no font of the machine. So
//! equal input gives equal bytes. Maps and cities are painted pixel by pixel. Title, legend, scale
//! bar, marks and caption are SVG over the pixels, rasterized with the embedded font or kept as
//! vectors.
//!
//! * [`draw_map`]: a coverage map with title, legend, scale bar, marks and caption.
//! * [`draw_map_panels`]: a layer of several UAVs side by side.
//! * [`draw_bare`]: one pixel per cell and nothing else, for overlays.
//! * [`draw_city`]: a plan and a view of a city.
//! * [`draw_link_profile`]: one link from the side.
//! * [`draw_height_curve`]: P_LoS against the UAV's height.
//! * [`draw_curve_sheet`]: estimates, bands and models against an angle or another varied quantity.
//! * [`draw_compare_sheet`]: placements side by side, and the changes between them;
//!   [`compare_page`] as a web page.
//! * [`live_page`]: a city in which a UAV is dragged, as a web page.
//! * [`draw_heat_sheet`]: P_LoS against two quantities.
//! * [`draw_rate_sheet`]: failure rates of methods on families of scenes.
//! * [`qgis_style`]: the style of a raster for QGIS.
//! * [`draw_tradeoff`]: cost and error of methods, and the bias of each.
//!
//! A drawn [`Sheet`] is written as PNG, SVG or PDF, at the width that a [`PictureForm`] sets.
//!
//! Blue is line of sight and orange is none, in every picture of places; curves use other colors to
//! tell lines apart.

mod check;
mod city_light;
mod city_picture;
mod city_solids;
mod city_view;
mod colors;
mod compare_page;
mod compare_sheet;
mod contours;
mod curve_lines;
mod curve_sheet;
mod furniture;
mod heat_sheet;
mod height_curve;
mod legend;
mod lettering;
mod line_look;
mod link_profile;
mod live_page;
mod map_layers;
mod map_legend;
mod map_panels;
mod map_picture;
mod marks;
mod paint;
mod page;
mod panel_grid;
mod pdf;
mod plot;
mod png;
mod point_labels;
mod qgis_style;
mod rate_sheet;
mod resized;
mod sheet;
mod side_labels;
mod small_maps;
mod track_profile;
mod tradeoff;
mod tradeoff_rows;
mod value_range;
mod web_page;
mod z_buffer;

pub use city_picture::{CityPicture, draw_city};
pub use city_solids::{CityHeights, CityModel, CityPrism};
pub use colors::{ALONE_COLORS, LEAST_HEIGHT_COLORS, ONLY_COLORS, SURE_COLORS};
pub use compare_page::{ComparePage, LiveDoor, PagePlacement, PageTable, compare_page};
pub use compare_sheet::{CompareMap, ComparePair, CompareSheet, draw_compare_sheet};
pub use curve_lines::{CurveLine, CurvePoint};
pub use curve_sheet::{CurvePanel, CurveSheet, draw_curve_sheet};
pub use heat_sheet::{HeatAxis, HeatPanel, HeatSheet, draw_heat_sheet};
pub use height_curve::{HeightCurveLine, HeightCurvePlot, draw_height_curve};
pub use lettering::{capitalized, grouped, percent};
pub use line_look::LineLook;
pub use link_profile::{LinkProfile, Obstruction, draw_link_profile};
pub use live_page::{LivePage, live_page};
pub use map_layers::{Layer, MapClass};
pub use map_legend::draw_overlay_legend;
pub use map_panels::{MOST_MAP_PANELS, MapPanel, MapPanels, draw_map_panels};
pub use map_picture::{MapPicture, draw_map};
pub use marks::{MOST_WITH_HEIGHTS, Mark};
pub use paint::OPEN_GROUND;
pub use png::{draw_bare, draw_bare_count};
pub use qgis_style::{FirstBand, qgis_style};
pub use rate_sheet::{RateColumn, RateSheet, draw_rate_sheet};
pub use sheet::{PictureForm, PictureFormat, Sheet};
pub use track_profile::{FlightHeights, TrackHeights, TrackPlan, TrackProfile, TrackStretch, draw_track_profile};
pub use tradeoff::{Tradeoff, draw_tradeoff};
pub use tradeoff_rows::TradeoffPoint;
pub use web_page::gzip;
