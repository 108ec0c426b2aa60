//! Units of work: their requests, their file names, their hashes, and the state of their files.
//!
//! Schedulers start units, and start them again. Whatever happens to a run, a file of a unit is
//! complete or absent, and it records which unit made it.

use std::ffi::OsStr;
use std::io::Read;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use skyshed_request::{ANSWERS_VERSION, Layer, MapUnits, Position, SceneWord, TileIndex, Uavs, json};

use super::job::{MapJob, PartWords};
use super::tiles::{ROW_AND_COL, Tile};
use crate::answer::digest_words;
use crate::city::{GivenSite, Site};
use crate::digest::Sha256;
use crate::error::{Error, PlacesError, RequestError, Result};
use crate::export::{Format, Left, is_unchanged, left_of, sidecars, site_in_names, with_suffix};
use crate::formats::{RasterFile, origin_of};
use crate::los::MethodChoice;
use crate::os_words::split;
use crate::read::source_of;
use crate::scene::built_up;
use crate::uav::UavsAsked;
use skyshed_io::Input;
use skyshed_io::error::WriteFault;
use skyshed_io::{identity, is_remote};

/// State of the files of a unit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Found {
    Nothing,
    /// Some of its files exist, or files beside them; all belong to this unit.
    Some,
    /// This file is cut short or damaged, and names no other run as its maker.
    Damaged(PathBuf),
    All,
}

/// Placeholder for the name of a UAV in the name of a file.
pub(crate) const SITE: &str = "{site}";

/// UAV or tile of a unit.
#[derive(Debug, Clone)]
pub(crate) enum Part {
    Site(GivenSite),
    Tile(Tile),
}

impl Part {
    /// Returns the name of the UAV, or `tile ROW,COL`.
    pub(crate) fn name(&self) -> String {
        match self {
            Part::Site(site) => site.id.clone(),
            Part::Tile(tile) => format!("tile {},{}", tile.row, tile.col),
        }
    }

    /// Returns the names of its files, from those with `{site}`, or `{row}` and `{col}`.
    pub(super) fn names(&self, paths: &[PathBuf]) -> Vec<PathBuf> {
        let words: Vec<(&str, String)> = match self {
            Part::Site(site) => vec![(SITE, site_in_names(&site.id))],
            Part::Tile(tile) => ROW_AND_COL.into_iter().zip([tile.row.to_string(), tile.col.to_string()]).collect(),
        };
        let named = |path: &PathBuf| {
            let name = path.as_os_str().to_os_string();
            words.iter().fold(name, |name, (word, with)| split(&name, word).join(OsStr::new(with)))
        };
        paths.iter().map(|path| named(path).into()).collect()
    }
}

/// Unit of work.
pub(crate) struct Unit {
    pub(crate) part: Part,
    /// Hash of all that its files depend on.
    pub(crate) hash: String,
    /// Job of this part alone, with files of its own.
    pub(crate) job: MapJob,
}

impl Unit {
    /// Returns the unit of a part of a job; `all` are the UAVs of the whole list.
    pub(super) fn of(whole: &MapJob, (part, all): (&Part, &[GivenSite]), inputs: &str) -> Unit {
        let hash = match part {
            Part::Site(site) => unit_of_site(whole, site, inputs),
            Part::Tile(tile) => unit_of_tile(whole, (tile, all), inputs),
        };
        let run = whole.plan.sight.antenna();
        let (antenna, words) = match part {
            Part::Site(site) => {
                let uav = Some(Position { x: site.x, y: site.y, height: site.height });
                (site.antenna.or(run), PartWords { uav, tile: None })
            }
            Part::Tile(tile) => (run, PartWords { uav: None, tile: Some(TileIndex { row: tile.row, col: tile.col }) }),
        };
        let job = whole.of_part(|paths| part.names(paths), antenna, &words);
        Unit { part: part.clone(), hash, job }
    }

    /// Returns the state of its files.
    ///
    /// # Errors
    /// E106 if a file exists that another run made.
    pub(crate) fn found(&self) -> Result<Found> {
        found(&self.job, &self.hash)
    }

    /// Returns the document of the map that its files hold, or that lies beside them.
    pub(crate) fn document(&self) -> Option<Value> {
        let text_of = |path: &PathBuf| {
            let beside = [path.clone(), with_suffix(path, ".json")];
            let mut documents = beside.iter().filter(|file| file.extension().is_some_and(|e| e == "json"));
            origin_of(path.as_path()).or_else(|| documents.find_map(|file| std::fs::read_to_string(file).ok()))
        };
        let documents = self.job.outputs.iter().filter_map(text_of);
        documents
            .filter_map(|text| serde_json::from_str(&text).ok())
            .find(|document: &Value| document.get("sites").is_some())
    }

    /// Returns the time of its latest file, in seconds since 1970; 0 without files.
    pub(crate) fn written_at(&self) -> u64 {
        let at = |path: &PathBuf| std::fs::metadata(path).and_then(|metadata| metadata.modified()).ok();
        let last = self.job.outputs.iter().filter_map(at).max();
        let since = last.and_then(|at| at.duration_since(std::time::UNIX_EPOCH).ok());
        since.map_or(0, |since| since.as_secs())
    }
}

/// Refuses two UAVs whose names are the same in file names.
pub(super) fn check_names(sites: &[GivenSite]) -> Result<()> {
    let mut names = std::collections::HashMap::new();
    for site in sites {
        let name = site_in_names(&site.id);
        let file = format!("the files of `{name}`");
        if let Some(other) = names.insert(name, &site.id) {
            return Err(PlacesError::SharedFile { a: (*other).clone(), b: site.id.clone(), file }.into());
        }
    }
    Ok(())
}

/// Refuses what files of tiles cannot hold: values of one UAV, and values that only the whole scene
/// gives.
pub(super) fn check_tiles(job: &MapJob) -> Result<()> {
    let formats = job.outputs.iter().map(|path| Ok((path, Format::of(path)?))).collect::<Result<Vec<_>>>()?;
    let tells = |format: &Format| matches!(format, Format::Csv | Format::Json | Format::GeoJson | Format::Stdout);
    let of_one = job.plan.layers.iter().find(|layer| !layer.is_of_all());
    if let Some((path, _)) = formats.iter().find(|(_, format)| of_one.is_some() && !tells(format)) {
        let layer = of_one.copied().unwrap_or(Layer::Los).name();
        return Err(RequestError::LayerOfTile { path: path.display().to_string(), layer }.into());
    }
    let why = "with tiles, which hold all UAVs together";
    let asked = [
        ("tolerance", job.plan.tolerance.is_some()),
        ("height_error", job.plan.heights.own_m > 0.0),
        ("height_bias", job.plan.heights.shared_m > 0.0),
        ("height_error_field", job.scene.options.height_error_field.is_some()),
        ("zones", job.plan.tells_zones),
        ("height_curve", job.curve.is_wanted()),
        ("polygons", job.save.forms.polygons.is_some()),
        ("bare", job.save.forms.bare),
        ("gdal_values", job.save.forms.gdal_values),
    ];
    let option = asked.iter().find(|(_, is_asked)| *is_asked).map(|(option, _)| *option);
    if let Some(option) = option.or(job.plan.option_of_time()) {
        return Err(Error::idle(option, why));
    }
    if matches!(job.plan.sight.method(), MethodChoice::Step(_) | MethodChoice::Xdraw | MethodChoice::R2) {
        return Err(Error::idle(
            "method",
            "with tiles, if it is approximate: it errs otherwise on a part than on the whole",
        ));
    }
    match job.plan.sight.receivers().zone() {
        Some(_) => Err(Error::idle("receivers", "of one zone with tiles: zones are found in the whole")),
        None => Ok(()),
    }
}

/// Returns the hash of one UAV's unit, over all that its files depend on.
pub(super) fn unit_of_site(job: &MapJob, site: &GivenSite, inputs: &str) -> String {
    unit(job, &json!({ "uav": identity_of(site), "bad_uavs": job.uavs.bad }), inputs)
}

/// Returns the hash of a tile's unit; `all` are the UAVs of the whole list.
pub(super) fn unit_of_tile(job: &MapJob, (tile, all): (&Tile, &[GivenSite]), inputs: &str) -> String {
    let own: Vec<Value> = tile.uavs.iter().map(|k| identity_of(&all[*k])).collect();
    let tells_numbers = job.plan.layers.iter().any(|layer| layer.tells_numbers());
    let numbers = tells_numbers.then_some((&tile.uavs, all.len()));
    let Tile { row, col, cells_per_side, .. } = tile;
    let tile = [*row, *col, *cells_per_side];
    unit(job, &json!({ "tile": tile, "uavs": own, "numbers": numbers, "bad_uavs": job.uavs.bad }), inputs)
}

/// Returns the hash of all UAVs together as one unit.
pub(super) fn unit_of_all(job: &MapJob, inputs: &str) -> String {
    let UavsAsked { typed, skips_bad, bad, shard, .. } = &job.uavs;
    let uavs: Vec<Value> = typed.iter().map(|site| identity_of(&site.clone().into())).collect();
    unit(job, &json!({ "uavs": uavs, "skip_bad": skips_bad, "bad_uavs": bad, "shard": shard }), inputs)
}

/// Returns all properties of a UAV that its files depend on.
fn identity_of(given: &GivenSite) -> Value {
    let GivenSite { site: Site { id, x, y, height, antenna, up: _ }, lonlat } = given;
    let antenna = skyshed_request::Antenna::from(*antenna);
    json!({ "id": id, "x": x, "y": y, "height": height.to_string(), "antenna": antenna, "lonlat": lonlat })
}

/// Returns the hash of a job's planned question, of its part `part`, and of its inputs.
///
/// The hashed text is canonical JSON. Equal questions have equal hashes, whatever was typed and
/// whatever this program calls its types.
fn unit(job: &MapJob, part: &Value, inputs: &str) -> String {
    let mut question = job.request.clone();
    question.uavs = Uavs::default();
    question.units = MapUnits::default();
    // A file has many names; the inputs identify it by one.
    if built_up(&job.word).is_none() {
        question.scene = SceneWord::default();
    }
    question.reading.options.terrain = None;
    question.reading.options.hash = false;
    let question = json::question(json::filled_members(&question));
    let identity = json!({ "answers": ANSWERS_VERSION, "question": question, "of": part, "inputs": inputs });
    let mut hasher = Sha256::default();
    hasher.update(json::canonical(&identity));
    digest_words(hasher)
}

/// Returns the identity of the files that all runs read: path, length and time of change.
/// `with_sites` adds the table of UAVs, for units that do not name each UAV.
pub(super) fn inputs(job: &MapJob, with_sites: bool) -> Result<String> {
    let mut files = job.inputs.clone();
    let table = job.uavs.table.as_ref().filter(|_| with_sites);
    let table_file = table.and_then(Input::file).filter(|file| file.exists());
    // What comes from standard input or from memory is told by its digest.
    let mut text = match table {
        Some(table) if table_file.is_none() => format!("{:?};", source_of(table, false)?),
        _ => String::new(),
    };
    files.extend(table_file.map(PathBuf::from));
    for file in files.iter().filter(|file| is_remote(file)) {
        text += &format!("{} {};", file.display(), identity(file)?);
    }
    for file in files.iter().filter(|file| file.exists()).flat_map(|file| parts_of(file)) {
        let metadata = std::fs::metadata(&file).map_err(|e| skyshed_io::cannot_read(&file.as_path().into(), &e))?;
        let name = std::fs::canonicalize(&file).unwrap_or(file);
        text += &format!("{} {} {:?};", name.display(), metadata.len(), metadata.modified().ok());
    }
    Ok(text)
}

/// Returns the state of the files of a run, as made by the unit `unit`.
///
/// A file appears after the files beside it. So a file that exists is complete, unless a disk or a
/// copy lost its end. A file beside it that exists alone is left from a killed run.
///
/// # Errors
/// E106 if a file exists that is not of this unit, unless it may be replaced.
pub(super) fn found(job: &MapJob, unit: &str) -> Result<Found> {
    let files: Vec<&PathBuf> = job.files().collect();
    // An empty file belongs to nobody.
    let is_there =
        |file: &Path| std::fs::metadata(file).is_ok_and(|metadata| metadata.len() > 0 || !metadata.is_file());
    let there: Vec<&PathBuf> = files.iter().copied().filter(|file| is_there(file)).collect();
    let mut damaged = None;
    for file in &there {
        if file.is_dir() {
            let fault = WriteFault::Folder;
            return Err(Error::from(skyshed_io::Error::Write(file.display().to_string(), fault)));
        }
        match maker_of(file, unit, job.save.forms.bare) {
            Maker::Unit => {}
            Maker::Damaged(part) => damaged = damaged.or(Some(part)),
            Maker::AnotherRun | Maker::Nobody if job.save.writing.overwrite => return Ok(Found::Nothing),
            Maker::AnotherRun => return Err(RequestError::OfAnotherRun(file.display().to_string()).into()),
            Maker::Nobody => return Err(RequestError::OfNobody(file.display().to_string()).into()),
        }
    }
    if let Some(part) = damaged {
        return Ok(Found::Damaged(part));
    }
    let is_left_alone = |file: &PathBuf| {
        let beside = Format::of(file).map_or_else(|_| Vec::new(), |format| sidecars(file, format, job.save.forms.bare));
        let is_own = |sidecar: &PathBuf| match sidecar.extension() {
            Some(extension) if extension == "json" => holds_in(sidecar, unit),
            // Files of one stem share the files that georeference them.
            _ => !["tif", "tiff", "asc", "bil", "png", "shp"].iter().any(|other| {
                let other = file.with_extension(other);
                other.exists() && !files.contains(&&other)
            }),
        };
        !file.exists() && beside.iter().any(|sidecar| sidecar.exists() && is_own(sidecar))
    };
    if there.len() == files.len() {
        return Ok(Found::All);
    }
    let is_begun = files.iter().any(|file| file.exists() || is_left_alone(file));
    Ok(if is_begun { Found::Some } else { Found::Nothing })
}

/// Maker of a file that exists.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Maker {
    /// The unit; the file is whole.
    Unit,
    /// The unit, as far as can be known. This file, the output or the document beside it, is cut
    /// short or damaged.
    Damaged(PathBuf),
    /// Another run of this program.
    AnotherRun,
    /// Nobody known: the file holds nothing of this program.
    Nobody,
}

fn maker_of(file: &Path, unit: &str, is_bare: bool) -> Maker {
    let Ok(format) = Format::of(file) else { return Maker::Nobody };
    let document = with_suffix(file, ".json");
    let document = Some(document).filter(|path| sidecars(file, format, is_bare).contains(path) && path.exists());
    let parts = [Some((file.to_path_buf(), format)), document.map(|path| (path, Format::Json))];
    let left = parts.into_iter().flatten().map(|(part, format)| (left_of(&part, format), part));
    let is_own = says(file, unit);
    match left.into_iter().find(|(left, _)| *left != Left::Whole) {
        None if is_own && is_unchanged(file, format) => Maker::Unit,
        None if is_own => Maker::Damaged(file.to_path_buf()),
        None if says(file, "\"skyshed/") => Maker::AnotherRun,
        None => Maker::Nobody,
        Some((_, part)) if is_own => Maker::Damaged(part),
        Some(_) if names_a_unit(file, unit) => Maker::AnotherRun,
        Some((Left::Damaged, part)) => Maker::Damaged(part),
        Some(_) => Maker::Nobody,
    }
}

/// Returns `true` if a cut file, or the document beside it, names a unit other than `unit`. The
/// file does not name `unit` in full.
fn names_a_unit(file: &Path, unit: &str) -> bool {
    /// Key in JSON, and in JSON within XML.
    const KEYS: [&str; 2] = ["\"unit\":", "&quot;unit&quot;:"];
    const QUOTES: [&str; 2] = ["\"", "&quot;"];
    // A name that the end of the file cuts off may be that of `unit`.
    let is_cut_within = |path: &Path, key: &str| {
        let tail = std::fs::read(path).map(|bytes| bytes[bytes.len().saturating_sub(key.len() + 100)..].to_vec());
        let tail = tail.map(|tail| String::from_utf8_lossy(&tail).into_owned()).unwrap_or_default();
        let name = tail.rsplit_once(key).map(|(_, name)| name.trim_start());
        name.is_some_and(|name| {
            let within = QUOTES.iter().find_map(|quote| name.strip_prefix(quote)).unwrap_or(name);
            unit.starts_with(within) || QUOTES.iter().any(|quote| quote.starts_with(within))
        })
    };
    let names_one = |path: &Path| KEYS.iter().any(|key| holds_in(path, key) && !is_cut_within(path, key));
    [file.to_path_buf(), with_suffix(file, ".json")].iter().any(|path| names_one(path))
}

/// Returns the files that an input consists of, and files that may belong to them.
fn parts_of(input: &Path) -> Vec<PathBuf> {
    let tiles = RasterFile::open(input, &mut Vec::new())
        .map(|file| file.tile_paths().iter().map(|path| path.to_path_buf()).collect::<Vec<_>>());
    let files = std::iter::once(input.to_path_buf()).chain(tiles.unwrap_or_default());
    let with_others = files.flat_map(|file| {
        let others = ["prj", "tfw", "shx", "dbf", "cpg"].map(|extension| file.with_extension(extension));
        let suffixed = [".aux.xml", ".msk", ".ovr"].map(|suffix| with_suffix(&file, suffix));
        others.into_iter().chain(suffixed).filter(|other| other.exists()).chain([file.clone()]).collect::<Vec<_>>()
    });
    with_others.collect()
}

/// Returns `true` if a text occurs in the origin of a file, in the document beside it, in its
/// bytes, or in a member of an archive.
fn says(file: &Path, text: &str) -> bool {
    let in_archive = |path: &Path| {
        let archive = std::fs::File::open(path).map_err(zip::result::ZipError::from).and_then(zip::ZipArchive::new);
        archive.is_ok_and(|mut archive| {
            (0..archive.len()).any(|k| archive.by_index(k).is_ok_and(|member| holds(member, text.as_bytes())))
        })
    };
    origin_of(file).is_some_and(|origin| origin.contains(text))
        || holds_in(&with_suffix(file, ".json"), text)
        || holds_in(file, text)
        || in_archive(file)
}

/// Returns `true` if a file holds a text.
fn holds_in(path: &Path, text: &str) -> bool {
    std::fs::File::open(path).is_ok_and(|file| holds(file, text.as_bytes()))
}

/// Returns `true` if a file holds some bytes.
fn holds(mut file: impl Read, wanted: &[u8]) -> bool {
    const BLOCK: usize = 1 << 20;
    // The end of each block is searched again with the next one.
    let mut window = Vec::with_capacity(BLOCK + wanted.len());
    loop {
        let kept = window.len().min(wanted.len() - 1);
        window.drain(..window.len() - kept);
        let n = file.by_ref().take(BLOCK as u64).read_to_end(&mut window);
        if window.windows(wanted.len()).any(|bytes| bytes == wanted) {
            return true;
        }
        if !matches!(n, Ok(n) if n > 0) {
            return false;
        }
    }
}
