//! Description of a file that this program wrote: its origin, its inputs and its contents.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Map, Value};

use super::INFO_SCHEMA;
use crate::answer::{Answer, CommandFacts, Spent, document_of};
use crate::coverage::class;
use crate::error::Result;
use crate::export::{Batch, Format, with_suffix};
use crate::formats::{RasterFile, origin_of};
use crate::map::MaskDigest;
use crate::picture::Look;
use crate::render::grouped;
use crate::scene::results::is_city;
use crate::words::version;

/// An output of this program.
#[derive(Debug)]
pub(crate) struct Output {
    command: CommandFacts,
    path: PathBuf,
    /// Origin of the file: the document in it or beside it.
    origin: Value,
    bands: Vec<Band>,
    /// For the mask of one UAV: cells by class, and `true` if they match the digest of the origin.
    mask: Option<(Map<String, Value>, bool)>,
}

/// A band of a raster.
#[derive(Debug, Clone, Serialize, JsonSchema)]
struct Band {
    /// Name of the band.
    name: String,
    /// Lowest and highest value.
    range: Option<[f64; 2]>,
    /// Cells without a value.
    nodata: u64,
    /// Reason for having no range.
    reason: Option<&'static str>,
}

/// An output of this program.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct OutputInfo<'a> {
    /// Kind of document and its version.
    schema: &'static str,
    /// Version of the program.
    version: &'static str,
    #[serde(flatten)]
    command: &'a CommandFacts,
    /// output.
    kind: &'static str,
    /// Path of the file.
    path: String,
    /// Origin of the file: a document of the run that made it.
    made_by: &'a Value,
    /// Bands of a raster.
    bands: &'a [Band],
    /// Cells of a mask by class.
    classes: Option<&'a Map<String, Value>>,
    /// true if the cells of a mask match the digest of the origin.
    digest_agrees: Option<bool>,
    /// Suggested use of the file.
    #[serde(rename = "use")]
    advice: &'static str,
}

/// Length of the beginning of a text that must name one of our schemas \[bytes\].
const HEAD: u64 = 4096;

impl Output {
    /// Returns `true` for an output of this program that is no city.
    pub(crate) fn is_one(path: &Path) -> bool {
        origin(path).is_some_and(|origin| !is_city(&origin))
    }

    /// Returns the output that a file is. `None` for other files, and for cities, which are scenes.
    pub(crate) fn of(path: &Path, command: &CommandFacts) -> Option<Output> {
        let origin = origin(path)?;
        if is_city(&origin) {
            return None;
        }
        let command = command.clone();
        let mut output = Output { command, path: path.to_path_buf(), origin, bands: Vec::new(), mask: None };
        output.read_bands();
        Some(output)
    }

    /// Reads the bands of a GeoTIFF. Other files and damaged ones get no bands.
    fn read_bands(&mut self) {
        let Ok(RasterFile::GeoTiff(tiff)) = RasterFile::open(&self.path, &mut Vec::new()) else { return };
        let names: Vec<String> = tiff.band_names().iter().map(|name| name.unwrap_or("unnamed").to_string()).collect();
        for (k, name) in names.into_iter().enumerate() {
            let (mut range, mut nodata): (Option<[f64; 2]>, u64) = (None, 0);
            let mut cells = Vec::new();
            let read = tiff.read_band(k, tiff.georef().window(), &mut Vec::new(), |value| {
                if value.is_nan() {
                    nodata += 1;
                } else {
                    let [low, high] = range.unwrap_or([value, value]);
                    range = Some([low.min(value), high.max(value)]);
                }
                cells.push(value);
            });
            if read.is_err() && range.is_some() {
                return;
            }
            if tiff.n_bands() == 1 && self.origin["schema"] == "skyshed/map/1" {
                let mut digest = MaskDigest::new(tiff.georef());
                self.mask = classes(&cells).map(|(mask, counts)| {
                    digest.add(&mask);
                    (counts, self.origin["digest"] == digest.finish().as_str())
                });
            }
            let reason = range.is_none().then_some("all cells are nodata");
            self.bands.push(Band { name, range, nodata, reason });
        }
    }

    /// Returns the suggested use of the file.
    fn advice(&self) -> &'static str {
        let schema = self.origin["schema"].as_str().unwrap_or_default();
        let extension = self.path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        match (schema, extension.as_str()) {
            ("skyshed/map/1", "tif") if self.mask.is_some() => {
                "a mask, not a scene: `skyshed compare SCENE --mask FILE`, or open it in QGIS"
            }
            (_, "tif" | "tiff" | "exr" | "asc" | "bil") => "a raster of results, not a scene: open it in QGIS",
            (_, "geojson" | "fgb" | "kmz") => "results as features, not a scene: open them in QGIS or a globe",
            (_, "png" | "svg" | "pdf" | "html") => "a picture: look at it",
            _ => "results: read them with any program",
        }
    }
}

impl Answer for Output {
    fn is_in_words(&self) -> bool {
        true
    }

    fn document(&self, _: Option<Spent>) -> Value {
        document_of(&OutputInfo {
            schema: INFO_SCHEMA,
            version: version(),
            command: &self.command,
            kind: "output",
            path: self.path.display().to_string(),
            made_by: &self.origin,
            bands: &self.bands,
            classes: self.mask.as_ref().map(|(counts, _)| counts),
            digest_agrees: self.mask.as_ref().map(|(_, agrees)| *agrees),
            advice: self.advice(),
        })
    }

    fn text(&self, _: &Look) -> Result<String> {
        let word = |name: &str| self.origin[name].as_str().unwrap_or("unknown").to_string();
        let command: Vec<&str> =
            self.origin["command"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
        let mut text = format!("{} (output of skyshed {})\n", self.path.display(), word("version"));
        text += &format!("made by    skyshed {}\n", command.join(" "));
        text += &format!("document   {}, method {}\n", word("schema"), word("method"));
        let scene = &self.origin["scene"];
        if let Some(name) = scene["name"].as_str() {
            text += &format!("scene      {name}, {} × {} cells, {}\n", scene["cols"], scene["rows"], crs_of(scene));
        }
        for source in scene["sources"].as_array().into_iter().flatten() {
            let sha = source["sha256"].as_str().map_or("not hashed".to_string(), |sha| format!("sha256 {sha}"));
            text += &format!("input      {}, {sha}\n", source["path"].as_str().unwrap_or("unknown"));
        }
        for site in self.origin["sites"].as_array().into_iter().flatten() {
            let p_los = site["p_los"].as_f64().map_or("unknown".to_string(), |p| format!("{p:.4}"));
            text += &format!("UAV        {}: P_LoS {p_los}\n", site["id"].as_str().unwrap_or("unknown"));
        }
        for band in &self.bands {
            let range = band.range.map_or("nothing but nodata".to_string(), |[low, high]| format!("{low} to {high}"));
            text += &format!("band       {}: {range}, {} nodata\n", band.name, grouped(band.nodata));
        }
        if let Some((counts, agrees)) = &self.mask {
            let counts: Vec<String> = counts
                .iter()
                .map(|(name, n)| format!("{} {}", grouped(n.as_u64().unwrap_or(0)), name.replace('_', " ")))
                .collect();
            text += &format!("cells      {}\n", counts.join(", "));
            let verdict = if *agrees { "agrees with the cells" } else { "is not that of the cells: they were changed" };
            text += &format!("digest     {verdict}\n");
        }
        for warning in self.origin["warnings"].as_array().into_iter().flatten() {
            text += &format!(
                "said       {}: {}\n",
                warning["code"].as_str().unwrap_or("W"),
                warning["text"].as_str().unwrap_or("")
            );
        }
        Ok(text + &format!("use        {}\n", self.advice()))
    }

    fn add(&self, _: &mut Batch, _: &Path, _: Format, _: &Look) -> Result<()> {
        Ok(())
    }
}

fn crs_of(scene: &Value) -> &str {
    scene["crs"].as_str().unwrap_or("local coordinates")
}

/// Returns the origin of a file, from the file itself or from the document beside it.
fn origin(path: &Path) -> Option<Value> {
    if let Some(text) = origin_of(path) {
        return serde_json::from_str(&text).ok();
    }
    let extension = path.extension()?.to_string_lossy().to_lowercase();
    match extension.as_str() {
        "json" | "geojson" => {
            let document = document_of_ours(path)?;
            let origin = if document["schema"].is_string() { document } else { document["skyshed"].clone() };
            is_ours(&origin).then_some(origin)
        }
        "csv" | "asc" | "bil" | "png" => document_of_ours(&with_suffix(path, ".json")).filter(is_ours),
        _ => None,
    }
}

fn is_ours(origin: &Value) -> bool {
    origin["schema"].as_str().is_some_and(|schema| schema.starts_with("skyshed/"))
}

/// Reads a JSON document whose beginning names one of our schemas.
fn document_of_ours(path: &Path) -> Option<Value> {
    let mut head = Vec::new();
    File::open(path).ok()?.take(HEAD).read_to_end(&mut head).ok()?;
    String::from_utf8_lossy(&head).contains("\"skyshed/").then_some(())?;
    let mut text = String::new();
    File::open(path).ok()?.read_to_string(&mut text).ok()?;
    serde_json::from_str(&text).ok()
}

/// Returns the bytes of a mask and its cells by class. `None` for a raster with other values.
fn classes(cells: &[f64]) -> Option<(Vec<u8>, Map<String, Value>)> {
    let byte = |value: &f64| {
        let found = class::NAMES.iter().find(|(code, _)| value.total_cmp(&f64::from(*code)).is_eq());
        if value.is_nan() { Some(class::NODATA) } else { found.map(|(code, _)| *code) }
    };
    let mask: Vec<u8> = cells.iter().map(byte).collect::<Option<_>>()?;
    let count = |code: u8| mask.iter().filter(|cell| **cell == code).count();
    let key = |name: &str| name.to_lowercase().replace(' ', "_");
    let counts = class::NAMES.iter().map(|(code, name)| (key(name), Value::from(count(*code)))).collect();
    Some((mask, counts))
}
