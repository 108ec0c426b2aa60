//! The document, the table and the files of links between lists.

use std::path::Path;

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Value, json};

use super::super::EndFacts;
use super::{Decided, End, LinkTable, NoLink, ObstacleFacts, end_of};
use crate::answer::{
    Answer, Head, Rows, Spent, WarningFacts, document_of, feature, feature_collection, rows, warnings_of,
};
use crate::coverage::{self, ExplainedLink};
use crate::error::{Result, Warning};
use crate::export::{Batch, Format};
use crate::formats::{NpyArray, write_npz};
use crate::height_field::{Curvature, Station};
use crate::picture::Look;
use crate::quantity::counted;
use crate::words::{p_los_words, pretty};

/// A link of a table.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct LinkRow {
    /// Id of the UAV.
    uav: String,
    /// Id of the receiver.
    rx: String,
    /// true in line of sight, false without; null where there is no answer.
    los: Option<bool>,
    /// Receiver height less the least height in line of sight [m]; null if no height is enough, and with
    /// --los-only.
    #[serde(skip_serializing_if = "Option::is_none")]
    margin_m: Option<f64>,
    /// Distance in the plane [m].
    distance_m: f64,
    /// Distance in space [m]; null where an end cannot be there.
    slant_m: Option<f64>,
    /// Azimuth of the UAV from the receiver, clockwise from grid north [deg].
    azimuth_deg: f64,
    /// Elevation angle of the UAV from the receiver [deg].
    elevation_deg: Option<f64>,
    /// Obstacle that requires the highest receiver: building, terrain, cell, nodata or horizon.
    #[serde(skip_serializing_if = "Option::is_none")]
    obstacle: Option<&'static str>,
    /// Id of that building, or row and column of that cell.
    #[serde(skip_serializing_if = "Option::is_none")]
    obstacle_id: Option<String>,
    /// Obstructing point, east [units of the scene's reference system].
    #[serde(skip_serializing_if = "Option::is_none")]
    obstacle_x: Option<f64>,
    /// Obstructing point, north [units of the scene's reference system].
    #[serde(skip_serializing_if = "Option::is_none")]
    obstacle_y: Option<f64>,
    /// Height of the ray there [m above the datum].
    #[serde(skip_serializing_if = "Option::is_none")]
    ray_height_m: Option<f64>,
    /// Height of the obstacle there [m above the datum].
    #[serde(skip_serializing_if = "Option::is_none")]
    roof_height_m: Option<f64>,
    /// Reason for having no answer.
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<String>,
}

/// An end of links in a document.
#[derive(Debug, Serialize, JsonSchema)]
struct EndRow {
    /// Id.
    id: String,
    /// East [units of the scene's reference system].
    x: f64,
    /// North [units of the scene's reference system].
    y: f64,
    /// Height above the datum [m]; null where it cannot be there.
    height_amsl_m: Option<f64>,
}

/// Links between lists of UAVs and receivers.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct LinksDocument {
    #[serde(flatten)]
    head: Head,
    /// UAVs.
    uavs: Vec<EndRow>,
    /// Receivers.
    receivers: Vec<EndRow>,
    /// Effective earth radius factor k; null over a flat earth.
    earth_k: Option<f64>,
    /// Number of links that have an answer.
    n_links: usize,
    /// Number of links in line of sight.
    n_los: usize,
    /// Share of these; null without any.
    p_los: Option<f64>,
    /// Links, UAV by UAV; absent in the copies that tables store.
    #[serde(skip_serializing_if = "Option::is_none")]
    links: Option<Vec<LinkRow>>,
    /// Warnings.
    warnings: Vec<WarningFacts>,
}

/// Geometry of a link.
struct Geometry {
    distance_m: f64,
    slant_m: Option<f64>,
    azimuth_deg: f64,
    elevation_deg: Option<f64>,
}

impl LinkTable {
    /// Returns the UAV and the receiver of each link, with what was decided.
    fn ends(&self) -> impl Iterator<Item = (usize, usize, &Decided)> {
        let n = self.receivers.len().max(1);
        let is_pair = self.are_pairs;
        self.links.iter().enumerate().map(move |(k, link)| if is_pair { (k, k, link) } else { (k / n, k % n, link) })
    }

    fn geometry(&self, (uav, receiver): (usize, usize), link: &Decided) -> Geometry {
        let (uav, receiver, unit) = (&self.uavs[uav], &self.receivers[receiver], self.facts.unit_m());
        let (dx, dy) = (uav.at.0 - receiver.at.0, uav.at.1 - receiver.at.1);
        let distance_m = dx.hypot(dy) * unit;
        let heights = uav.placed.as_ref().ok().zip(receiver.placed.as_ref().ok());
        let rise_m = heights.map(|(uav, receiver)| uav.height_amsl_m() - end_of(receiver).height_amsl_m);
        let straight = rise_m.map(|rise| rise.atan2(distance_m).to_degrees());
        Geometry {
            distance_m,
            slant_m: rise_m.map(|rise| rise.hypot(distance_m)),
            azimuth_deg: dx.atan2(dy).to_degrees().rem_euclid(360.0),
            elevation_deg: link.explained().map(|link| link.elevation_deg).or(straight),
        }
    }

    fn row(&self, (uav, receiver, link): (usize, usize, &Decided)) -> LinkRow {
        let Geometry { distance_m, slant_m, azimuth_deg, elevation_deg } = self.geometry((uav, receiver), link);
        let obstruction = link.explained().and_then(|link| link.obstruction);
        let facts = obstruction.map(|of| ObstacleFacts::of(&self.scene.field, of.kind));
        let cell = |facts: &ObstacleFacts| facts.cell.map(|(row, col)| format!("{row},{col}"));
        let (of_uav, of_receiver) = (&self.uavs[uav], &self.receivers[receiver]);
        LinkRow {
            uav: of_uav.id.clone(),
            rx: of_receiver.id.clone(),
            los: link.los(),
            margin_m: link.explained().and_then(|link| link.margin_m),
            distance_m,
            slant_m,
            azimuth_deg,
            elevation_deg,
            obstacle: facts.as_ref().map(|facts| facts.kind),
            obstacle_id: facts.as_ref().and_then(|facts| facts.id.clone().or_else(|| cell(facts))),
            obstacle_x: obstruction.map(|of| of.x),
            obstacle_y: obstruction.map(|of| of.y),
            ray_height_m: obstruction.map(|of| of.ray_height_m),
            roof_height_m: obstruction.and_then(|of| of.top_m),
            reason: match link {
                Decided::None(NoLink::Uav) => of_uav.placed.as_ref().err().cloned(),
                Decided::None(NoLink::Receiver) => {
                    of_receiver.placed.as_ref().err().map(|why| format!("no receiver can be there: {why}"))
                }
                Decided::None(NoLink::OutOfRange) => Some("out of range".into()),
                _ => None,
            },
        }
    }

    fn rows(&self) -> impl Iterator<Item = LinkRow> {
        self.ends().map(|link| self.row(link))
    }

    fn counts(&self) -> (usize, usize) {
        let decided = || self.links.iter().filter_map(Decided::los);
        (decided().count(), decided().filter(|los| *los).count())
    }

    fn share(&self) -> Option<f64> {
        let (n_links, n_los) = self.counts();
        #[expect(clippy::cast_precision_loss, reason = "far below 2^53")]
        (n_links > 0).then(|| n_los as f64 / n_links as f64)
    }

    fn as_document(&self, with_links: bool) -> Value {
        let of_uav = |uav: &End<coverage::Uav>| EndRow {
            id: uav.id.clone(),
            x: uav.at.0,
            y: uav.at.1,
            height_amsl_m: uav.placed.as_ref().ok().map(coverage::Uav::height_amsl_m),
        };
        let of_receiver = |receiver: &End<Station>| EndRow {
            id: receiver.id.clone(),
            x: receiver.at.0,
            y: receiver.at.1,
            height_amsl_m: receiver.placed.as_ref().ok().map(|station| end_of(station).height_amsl_m),
        };
        let (n_links, n_los) = self.counts();
        document_of(&LinksDocument {
            head: self.facts.head("skyshed/links/1"),
            uavs: self.uavs.iter().map(of_uav).collect(),
            receivers: self.receivers.iter().map(of_receiver).collect(),
            earth_k: self.curvature.map(Curvature::earth_k),
            n_links,
            n_los,
            p_los: self.share(),
            links: with_links.then(|| self.rows().collect()),
            warnings: warnings_of(&self.facts.warnings),
        })
    }

    /// Returns lines from the UAVs to the receivers, with the facts of the links.
    fn lines(&self) -> String {
        let end = |at: (f64, f64), facts: Option<EndFacts>| match facts {
            Some(EndFacts { x, y, height_amsl_m }) => json!([x, y, height_amsl_m]),
            None => json!([at.0, at.1]),
        };
        let line = |(uav, receiver, link): (usize, usize, &Decided)| {
            let (of_uav, of_receiver) = (&self.uavs[uav], &self.receivers[receiver]);
            let ends = [
                end(of_uav.at, of_uav.placed.as_ref().ok().map(|uav| end_of(&uav.station))),
                end(of_receiver.at, of_receiver.placed.as_ref().ok().map(end_of)),
            ];
            feature(json!(self.row((uav, receiver, link))), Some(("LineString", json!(ends))))
        };
        let lines = self.ends().map(line).collect();
        pretty(&feature_collection(self.scene.grid(), self.provenance(), lines))
    }

    /// Returns arrays by UAV and receiver, of pairs by pair, and the places of both. Those of `los` are 1 or 0,
    /// 255 without an answer. Others are NaN there, and left out with line of sight alone.
    pub(crate) fn arrays(&self) -> Vec<(&'static str, LinkArray)> {
        let shape = if self.are_pairs { vec![self.links.len()] } else { vec![self.uavs.len(), self.receivers.len()] };
        let geometry: Vec<Geometry> =
            self.ends().map(|(uav, receiver, link)| self.geometry((uav, receiver), link)).collect();
        let array = |values: Vec<f64>| LinkArray::F64(values, shape.clone());
        let of = |value: &dyn Fn(&Geometry) -> Option<f64>| {
            array(geometry.iter().map(|of| value(of).unwrap_or(f64::NAN)).collect())
        };
        let explained = |value: &dyn Fn(&ExplainedLink) -> Option<f64>| {
            array(self.links.iter().map(|link| link.explained().and_then(value).unwrap_or(f64::NAN)).collect())
        };
        let los = self.links.iter().map(|link| link.los().map_or(255, u8::from)).collect();
        let mut arrays = vec![("los", LinkArray::U8(los, shape.clone()))];
        if self.links.iter().any(|link| link.explained().is_some()) {
            arrays.extend([
                ("distance_m", of(&|g| Some(g.distance_m))),
                ("slant_m", of(&|g| g.slant_m)),
                ("azimuth_deg", of(&|g| Some(g.azimuth_deg))),
                ("elevation_deg", of(&|g| g.elevation_deg)),
                ("margin_m", explained(&|link| link.margin_m)),
                ("obstacle_x", explained(&|link| link.obstruction.map(|o| o.x))),
                ("obstacle_y", explained(&|link| link.obstruction.map(|o| o.y))),
            ]);
        }
        let places = |ends: &mut dyn Iterator<Item = ((f64, f64), f64)>| {
            let values: Vec<f64> = ends.flat_map(|((x, y), z)| [x, y, z]).collect();
            let n_ends = values.len() / 3;
            LinkArray::F64(values, vec![n_ends, 3])
        };
        let uav_z = |uav: &End<coverage::Uav>| uav.placed.as_ref().map_or(f64::NAN, coverage::Uav::height_amsl_m);
        let rx_z = |rx: &End<Station>| rx.placed.as_ref().map_or(f64::NAN, |at| end_of(at).height_amsl_m);
        arrays.push(("uavs", places(&mut self.uavs.iter().map(|uav| (uav.at, uav_z(uav))))));
        arrays.push(("receivers", places(&mut self.receivers.iter().map(|rx| (rx.at, rx_z(rx))))));
        arrays
    }

    /// Returns the reasons why UAVs, and why receivers, cannot be at their place, by their places in the lists.
    pub(crate) fn faults(&self) -> [Vec<(usize, String)>; 2] {
        fn of<T>(ends: &[End<T>]) -> Vec<(usize, String)> {
            let fault = |(k, end): (usize, &End<T>)| Some((k, end.placed.as_ref().err()?.clone()));
            ends.iter().enumerate().filter_map(fault).collect()
        }
        [of(&self.uavs), of(&self.receivers)]
    }

    /// Encodes the arrays as a file.
    fn npz(&self) -> Result<Vec<u8>> {
        let (arrays, meta) = (self.arrays(), self.provenance().to_string());
        let named = arrays.iter().map(|(name, array)| {
            let array = match array {
                LinkArray::U8(values, shape) => NpyArray::U8(values, shape.clone()),
                LinkArray::F64(values, shape) => NpyArray::F64(values, shape.clone()),
            };
            ((*name).to_string(), array)
        });
        let named: Vec<(String, NpyArray<'_>)> = named.chain([("meta".into(), NpyArray::Text(&meta))]).collect();
        let mut out = std::io::Cursor::new(Vec::new());
        write_npz(&mut out, &named)?;
        Ok(out.into_inner())
    }
}

/// Values of links or of their ends, in rows, with their shape.
#[derive(Debug, Clone, PartialEq)]
pub enum LinkArray {
    /// Small whole numbers.
    U8(Vec<u8>, Vec<usize>),
    /// Numbers; NaN where there is none.
    F64(Vec<f64>, Vec<usize>),
}

impl Answer for LinkTable {
    fn document(&self, _: Option<Spent>) -> Value {
        self.as_document(true)
    }

    fn provenance(&self) -> Value {
        self.as_document(false)
    }

    fn table(&self) -> Rows {
        rows(self.rows())
    }

    fn warnings(&self) -> &[Warning] {
        &self.facts.warnings
    }

    fn notes(&self, _: Spent) -> Vec<String> {
        let (n_links, n_los) = self.counts();
        let share = p_los_words(self.share());
        let n_none = self.links.len() - n_links;
        let none = if n_none > 0 {
            format!("; {} without an answer", counted(n_none as u64, "link", "links"))
        } else {
            String::new()
        };
        vec![format!("{} of {} in line of sight: {share}{none}", n_los, counted(n_links as u64, "link", "links"))]
    }

    fn add(&self, batch: &mut Batch, path: &Path, format: Format, _: &Look) -> Result<()> {
        let bytes = match format {
            Format::Npz => self.npz()?,
            _ => self.lines().into_bytes(),
        };
        Ok(batch.add(path, &bytes)?)
    }
}
