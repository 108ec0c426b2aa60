//! A single link, decided and explained.

mod profile;
mod table;

use std::path::Path;

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;
use skyshed_request::SaveOptions;

use crate::answer::{Answer, Head, RunFacts, Spent, WarningFacts, document_of, saved, warnings_of};
use crate::city::Site;
use crate::coverage::{self, ExplainedLink, LinkObstacle, ObstacleKind, SceneView};
use crate::earth::warn_of_drop;
use crate::error::{PlacesError, Result, Warning};
use crate::export::{Batch, Format};
use crate::height_field::{Curvature, HeightField, Station};
use crate::los::Method;
use crate::picture::Look;
use crate::quantity::{Height, MAX_EXTENT_UNITS, fixed, meters, tidy};
use crate::scene::Scene;
use crate::scene::placing::{place_uav, warn_of_uavs_outside};
use crate::sight::earth_words;
use crate::uav::Uav;

pub use table::LinkArray;
pub(crate) use table::{AskedReceiver, LinkRow, LinksDocument, LinksPlan, TABLE_FORMATS};

/// Output formats of a link.
pub(crate) const FORMATS: [Format; 5] = [Format::Png, Format::Svg, Format::Pdf, Format::Json, Format::Stdout];

impl Scene {
    /// Decides one link, and finds what obstructs it. The receiver is at x (east) and y (north) in
    /// the scene's reference system, at a height.
    ///
    /// ```
    /// use skyshed::prelude::*;
    ///
    /// let city = Scene::options().size(200.0).open("itu:urban")?;
    /// let uav = Uav::new(100.0, 100.0, Height::agl(60.0));
    /// let link = city.link(uav, (10.0, 150.0), Height::agl(1.5))?;
    /// assert_eq!(link.los(), link.obstruction().is_none());
    /// # Ok::<(), skyshed::Error>(())
    /// ```
    ///
    /// # Errors
    /// E2xx if one of the ends cannot be there: inside a building, below the ground, too far from
    /// the other.
    pub fn link(&self, uav: Uav, receiver: (f64, f64), height: Height) -> Result<Link> {
        self.curved_link(uav, (receiver, height), None)
    }

    /// Decides one link over a curved or a flat earth, as [`Scene::link`].
    ///
    /// # Errors
    /// As [`Scene::link`]; E118 for an earth so curved that heights would leave the lattice.
    pub(crate) fn curved_link(
        &self,
        uav: Uav,
        (receiver, height): ((f64, f64), Height),
        curvature: Option<Curvature>,
    ) -> Result<Link> {
        let mut scene = self.clone();
        let site = uav.site(0).site;
        warn_of_uavs_outside(std::slice::from_ref(&site), self.grid(), &mut scene.warnings);
        let (x, y) = receiver;
        check_extent(&scene, &site, (x, y))?;
        let reach = (x - site.x).abs().max((y - site.y).abs()).max(1.0);
        let uav = place_uav(&site, &scene.field, scene.grid(), Some(reach))?;
        let receiver = place_receiver(&scene, (x, y), height)?;
        let distance = (receiver.place.x - site.x).hypot(receiver.place.y - site.y);
        if curvature.is_none() {
            warn_of_drop(distance * scene.grid().meters_per_unit(), &mut scene.warnings);
        }
        explain(scene, uav, receiver, curvature)
    }
}

/// A link: its line of sight, its margin, and its obstruction.
#[derive(Debug, Clone)]
pub struct Link {
    scene: Scene,
    uav: coverage::Uav,
    receiver: Station,
    curvature: Option<Curvature>,
    pub(crate) facts: RunFacts,
    found: LinkFacts,
}

/// Facts of a link.
#[derive(Debug, Clone, Serialize, JsonSchema)]
struct LinkFacts {
    /// The UAV.
    uav: EndFacts,
    /// The receiver.
    receiver: EndFacts,
    /// true if the link is in line of sight.
    los: bool,
    /// Receiver height less the least height in line of sight [m]; null if no height is enough.
    margin_m: Option<f64>,
    /// Horizontal distance [m].
    distance_m: f64,
    /// Elevation angle of the UAV from the receiver [deg].
    elevation_deg: f64,
    /// Obstruction of the link; null in line of sight.
    obstruction: Option<LinkObstruction>,
    /// Effective earth radius factor k; null over a flat earth.
    earth_k: Option<f64>,
}

/// An end of a link.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
pub(crate) struct EndFacts {
    /// East [units of the scene's reference system].
    pub(crate) x: f64,
    /// North [units of the scene's reference system].
    pub(crate) y: f64,
    /// Height above the datum [m].
    pub(crate) height_amsl_m: f64,
}

/// Obstruction of a link: the obstacle that requires the highest receiver.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct LinkObstruction {
    /// `building`, `terrain`, `cell` of a surface model, blocking `nodata`, or flat `horizon`.
    pub kind: &'static str,
    /// Id of the building.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub id: Option<String>,
    /// Row of the cell, counted from the north.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub row: Option<usize>,
    /// Column of the cell.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub col: Option<usize>,
    /// Obstructing point, east [units of the scene's reference system].
    pub x: f64,
    /// Obstructing point, north [units of the scene's reference system].
    pub y: f64,
    /// Height of the ray there [m above the datum].
    pub ray_height_m: f64,
    /// Height of the obstacle there [m above the datum]; null for nodata that blocks everything.
    pub roof_height_m: Option<f64>,
}

impl LinkObstruction {
    /// Returns the height of the obstacle above the ray at the obstructing point \[m\]; `None` for
    /// nodata that blocks everything.
    pub fn depth_m(&self) -> Option<f64> {
        self.roof_height_m.map(|roof_m| roof_m - self.ray_height_m)
    }
}

/// One link.
#[derive(Serialize, JsonSchema)]
pub(crate) struct LinkDocument<'a> {
    #[serde(flatten)]
    head: Head,
    #[serde(flatten)]
    found: &'a LinkFacts,
    /// Warnings.
    warnings: Vec<WarningFacts>,
}

impl Link {
    /// Returns `true` if the link is in line of sight.
    pub fn los(&self) -> bool {
        self.found.los
    }

    /// Returns the height by which the receiver could sink and stay in line of sight \[m\]: never more
    /// than its own height. Negative: the height by which it would have to rise over its place. `None`
    /// if no receiver height is enough. [`LinkObstruction::depth_m`] is how deep the ray runs below the
    /// obstacle.
    pub fn margin_m(&self) -> Option<f64> {
        self.found.margin_m
    }

    /// Returns the horizontal distance \[m\].
    pub fn distance_m(&self) -> f64 {
        self.found.distance_m
    }

    /// Returns the elevation angle of the UAV from the receiver \[deg\].
    pub fn elevation_deg(&self) -> f64 {
        self.found.elevation_deg
    }

    /// Returns the obstruction; `None` in line of sight.
    pub fn obstruction(&self) -> Option<&LinkObstruction> {
        self.found.obstruction.as_ref()
    }

    /// Returns the warnings.
    pub fn warnings(&self) -> &[Warning] {
        &self.facts.warnings
    }

    /// Returns the document `skyshed/link/1`.
    pub fn document(&self) -> Value {
        Answer::document(self, None)
    }

    /// Writes the side view of the link (.png .svg .pdf) or its document (.json).
    ///
    /// # Errors
    /// E104–E106 for a file that cannot be written so; E109 for a picture of a vertical link; E401
    /// if writing fails.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<()> {
        saved(self, &FORMATS, path.as_ref(), &SaveOptions::default())
    }

    /// Writes a file as `save` does, with options of pictures and of writing.
    ///
    /// # Errors
    /// As `save`; E116 for options of maps, and for a look without a picture.
    pub fn save_with(&self, path: impl AsRef<Path>, options: &SaveOptions) -> Result<()> {
        saved(self, &FORMATS, path.as_ref(), options)
    }
}

impl Answer for Link {
    fn is_in_words(&self) -> bool {
        true
    }

    fn document(&self, _: Option<Spent>) -> Value {
        let warnings = warnings_of(&self.facts.warnings);
        document_of(&LinkDocument { head: self.facts.head("skyshed/link/1"), found: &self.found, warnings })
    }

    fn warnings(&self) -> &[Warning] {
        &self.facts.warnings
    }

    fn text(&self, _: &Look) -> Result<String> {
        let LinkFacts { uav, receiver, los, margin_m, distance_m, elevation_deg, obstruction, earth_k } = &self.found;
        let place = |e: &EndFacts| format!("({}, {}), {} m", tidy(e.x), tidy(e.y), tidy(e.height_amsl_m));
        let verdict = if *los { "LoS" } else { "NLoS" };
        let margin =
            margin_m.map_or("none: no receiver height is enough".to_string(), |m| format!("{} m", fixed(m, 3)));
        let mut text = format!("{verdict}: UAV at {} to receiver at {} above the datum\n", place(uav), place(receiver));
        let (distance, angle) = (tidy(*distance_m), tidy(*elevation_deg));
        let earth =
            earth_k.and_then(Curvature::of_earth_k).map_or(String::new(), |of| format!(", {}", earth_words(of)));
        text += &format!("distance {distance} m, elevation angle {angle}°, margin {margin}{earth}\n");
        if let Some(o) = obstruction {
            let name = match (&o.id, o.row.zip(o.col)) {
                (Some(id), _) => format!("building `{id}`"),
                (None, Some((row, col))) => format!("{} at row {row}, column {col}", o.kind),
                (None, None) => o.kind.to_string(),
            };
            let roof = o
                .roof_height_m
                .map_or("which blocks everything".to_string(), |r| format!("roof height {} m", fixed(r, 3)));
            let (x, y, ray) = (tidy(o.x), tidy(o.y), o.ray_height_m);
            text += &format!("obstructed by {name}: obstructing point ({x}, {y}), ray height {ray:.3} m, {roof}\n");
        }
        Ok(text)
    }

    fn add(&self, batch: &mut Batch, path: &Path, format: Format, look: &Look) -> Result<()> {
        Ok(batch.add(path, &profile::draw(self, format, look)?)?)
    }
}

/// Checks that the link fits the lattice.
pub(crate) fn check_extent(scene: &Scene, site: &Site, (x, y): (f64, f64)) -> Result<()> {
    let span = scene.field.span_units((site.x, site.y), (x, y));
    if span > MAX_EXTENT_UNITS {
        return Err(PlacesError::LongLink { from: (site.x, site.y), to: (x, y), span }.into());
    }
    Ok(())
}

/// Places the receiver's end: on ground or roof that exists, not inside a building.
fn place_receiver(scene: &Scene, at: (f64, f64), height: Height) -> Result<Station> {
    Ok(coverage::place_receiver(&scene.field, at, height).map_err(|why| PlacesError::Receiver { at, height, why })?)
}

/// Returns the facts of an end.
fn end_of(at: &Station) -> EndFacts {
    let height_amsl_m = i32::try_from(at.z).map_or(f64::NAN, meters);
    EndFacts { x: at.place.x, y: at.place.y, height_amsl_m }
}

/// Decides a link, and finds its obstruction.
fn explain(scene: Scene, uav: coverage::Uav, receiver: Station, curvature: Option<Curvature>) -> Result<Link> {
    let view = SceneView::of(&scene.field, &uav, curvature)?;
    let ExplainedLink { los, margin_m, distance_m, elevation_deg, obstruction } = view.link(&receiver);
    let found = LinkFacts {
        uav: end_of(&uav.station),
        receiver: end_of(&receiver),
        los,
        margin_m,
        distance_m,
        elevation_deg,
        obstruction: obstruction.map(|obstacle| LinkObstruction::of(&scene, obstacle)),
        earth_k: curvature.map(Curvature::earth_k),
    };
    Ok(Link { facts: scene.facts(Some(Method::Ray)), scene, uav, receiver, curvature, found })
}

/// Name of an obstacle in documents and tables.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct ObstacleFacts {
    pub(crate) kind: &'static str,
    /// Id of a building.
    pub(crate) id: Option<String>,
    /// Row from the north and column of a cell.
    pub(crate) cell: Option<(usize, usize)>,
}

impl ObstacleFacts {
    pub(crate) fn of(field: &HeightField, kind: ObstacleKind) -> Self {
        let (kind, building, cell) = match kind {
            ObstacleKind::Building(building) => ("building", Some(building), None),
            ObstacleKind::Terrain(cell) => ("terrain", None, Some(cell)),
            ObstacleKind::Cell(cell) => ("cell", None, Some(cell)),
            ObstacleKind::Nodata(cell) => ("nodata", None, Some(cell)),
            ObstacleKind::Horizon => ("horizon", None, None),
        };
        ObstacleFacts { kind, id: building.map(|building| field.building_id(building).to_string()), cell }
    }
}

impl LinkObstruction {
    fn of(scene: &Scene, obstacle: LinkObstacle) -> Self {
        let ObstacleFacts { kind, id, cell } = ObstacleFacts::of(&scene.field, obstacle.kind);
        LinkObstruction {
            kind,
            id,
            row: cell.map(|cell| cell.0),
            col: cell.map(|cell| cell.1),
            x: obstacle.x,
            y: obstacle.y,
            ray_height_m: obstacle.ray_height_m,
            roof_height_m: obstacle.top_m,
        }
    }
}
