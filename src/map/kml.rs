//! The KML document of a map, for Google Earth and other globes.
//!
//! # References
//! OGC 12-007r2, KML 2.3; everything used here is in 2.2 too.

use super::report::MapReport;
use crate::error::Result;
use crate::formats::{LonLatGrid, xml_text};
use crate::quantity::tidy;
use crate::raster::GeoRef;
use crate::words::{capitalized, p_los_words};

/// Picture laid over the ground.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct KmlOverlay {
    /// Name, which says what the picture shows.
    pub(super) name: String,
    /// File of the picture within the archive.
    pub(super) file: String,
    /// `true` if the overlay is visible when the file is opened.
    pub(super) is_visible: bool,
}

/// Opacity of an overlay in hexadecimal: 80 %, so that the streets below stay readable.
const OPACITY: &str = "cc";

/// Returns the document: overlays over the extent of `degrees`, the UAVs of the map, the picture
/// `legend` in the corner, and the provenance. UAVs hover at their heights above the ground. If
/// that is unknown, the height is above the datum, which globes take for sea level.
///
/// # Errors
/// E310 if a UAV is outside the domain of the projection.
pub(super) fn kml(report: &MapReport, degrees: &LonLatGrid, overlays: &[KmlOverlay], legend: &str) -> Result<String> {
    let name = xml_text(&format!("What UAVs see of {}", report.facts.scene_name));
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<kml xmlns=\"http://www.opengis.net/kml/2.2\">\n<Document>\n\
         <name>{name}</name>\n"
    );
    for overlay in overlays {
        text += &ground_overlay(overlay, degrees.georef());
    }
    text += &format!(
        "<ScreenOverlay>\n<name>Legend</name>\n<Icon><href>{legend}</href></Icon>\n\
         <overlayXY x=\"0\" y=\"1\" xunits=\"fraction\" yunits=\"fraction\"/>\n\
         <screenXY x=\"0.01\" y=\"0.99\" xunits=\"fraction\" yunits=\"fraction\"/>\n\
         <size x=\"-1\" y=\"-1\" xunits=\"pixels\" yunits=\"pixels\"/>\n</ScreenOverlay>\n"
    );
    for site in &report.sites {
        let (lon, lat) = degrees.degrees((site.x, site.y))?;
        let share = p_los_words(site.tally.p_los());
        // A globe has terrain of its own, unlike a scene over flat ground at 0 m.
        let (height, mode, above) = match site.height_agl_m {
            Some(agl) => (agl, "relativeToGround", "ground"),
            None => (site.height_amsl_m, "absolute", "the datum"),
        };
        let words = format!("{} m above {above}; P_LoS {share}", tidy(height));
        text += &format!(
            "<Placemark>\n<name>{}</name>\n<description>{}</description>\n<Point>\n<extrude>1</extrude>\n\
             <altitudeMode>{mode}</altitudeMode>\n<coordinates>{lon},{lat},{height}</coordinates>\n</Point>\n</Placemark>\n",
            xml_text(&capitalized(&format!("{} {}", report.sight.receivers().other_end(), site.id))),
            xml_text(&words)
        );
    }
    let provenance = xml_text(&report.document(None).to_string());
    text += &format!("<ExtendedData>\n<Data name=\"skyshed\"><value>{provenance}</value></Data>\n</ExtendedData>\n");
    Ok(text + "</Document>\n</kml>\n")
}

fn ground_overlay(overlay: &KmlOverlay, extent: &GeoRef) -> String {
    format!(
        "<GroundOverlay>\n<name>{}</name>\n<visibility>{}</visibility>\n<color>{OPACITY}ffffff</color>\n<Icon><href>{}</href></Icon>\n<LatLonBox>\n\
         <north>{}</north>\n<south>{}</south>\n<east>{}</east>\n<west>{}</west>\n</LatLonBox>\n</GroundOverlay>\n",
        xml_text(&overlay.name),
        u8::from(overlay.is_visible),
        xml_text(&overlay.file),
        extent.y_max(),
        extent.y_min(),
        extent.x_max(),
        extent.x_min()
    )
}
