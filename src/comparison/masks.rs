//! Masks of earlier runs, read from their files.

use std::path::Path;

use serde_json::{Value, json};

use crate::answer::Position;
use crate::coverage::class;
use crate::error::{InputError, OddRun, Result, Warning, warned};
use crate::formats::RasterFile;
use crate::raster::{GeoRef, LargeVec};
use crate::read::refuse_two_crs;
use crate::sight::{AntennaFacts, SightPlan};
use skyshed_io::error::Pair;

/// A mask of an earlier run.
#[derive(Debug)]
pub(super) struct SavedMask {
    /// Stem of the file's name, with the site's name if the file holds several.
    pub(super) id: String,
    /// Path of the file.
    pub(super) path: String,
    /// Classes of [`crate::coverage::class`].
    pub(super) mask: LargeVec<u8>,
    /// Position of the UAV, if the file holds it.
    pub(super) place: Option<Position>,
}

/// Scene and receivers of this run.
#[derive(Debug, Clone, Copy)]
pub(super) struct Setting<'a> {
    /// File of the scene.
    pub(super) scene: &'a Path,
    /// Grid of the scene.
    pub(super) grid: &'a GeoRef,
    pub(super) sight: &'a SightPlan,
}

/// Reads the masks of a file: its only band, or all bands named `SITE.los`.
///
/// # Errors
/// E312 for another grid than the scene's; E311 for another CRS; E302 for a file without a mask;
/// errors of reading the file.
pub(super) fn read_masks(path: &Path, setting: &Setting<'_>, warnings: &mut Vec<Warning>) -> Result<Vec<SavedMask>> {
    let Setting { scene, grid, .. } = *setting;
    let file = warned(warnings, |odd| RasterFile::open(path, odd))?;
    refuse_two_crs((scene.display(), grid.crs()), (path.display(), file.georef().crs()), Pair::SceneMap)?;
    if !file.georef().same_grid(grid) {
        let mask = format!("{} ({})", path.display(), file.georef().description());
        return Err(
            InputError::OtherGrid { mask, scene: format!("{} ({})", scene.display(), grid.description()) }.into()
        );
    }
    let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let shown = path.display().to_string();
    let RasterFile::GeoTiff(tiff) = &file else {
        let mut classes = Classes::default();
        let mask = warned(warnings, |odd| file.read(grid.window(), odd, |value| classes.of(value)))?.into_cells();
        classes.check(path, grid, "")?;
        return Ok(vec![SavedMask { id: stem, path: shown, mask, place: None }]);
    };
    let sites: Vec<(usize, String)> = match tiff.band_names().as_slice() {
        [_] => vec![(0, stem)],
        names => {
            let sites = names.iter().enumerate().filter_map(|(band, name)| {
                let site = name.as_ref()?.strip_suffix(".los")?;
                Some((band, format!("{stem}.{site}")))
            });
            sites.collect()
        }
    };
    if sites.is_empty() {
        let why = format!("none of its {} bands is called `SITE.los`, as `skyshed map` does", tiff.n_bands());
        return Err(InputError::Mask { name: shown, why }.into());
    }
    let document: Value = tiff.provenance().and_then(|text| serde_json::from_str(text).ok()).unwrap_or_default();
    warn_of_other_receivers(path, &document, setting, warnings);
    let places = document["sites"].as_array().cloned().unwrap_or_default();
    let place = |nth: usize| {
        let number = |name: &str| places.get(nth)?[name].as_f64();
        let lonlat = number("lon").zip(number("lat")).map(|(lon, lat)| [lon, lat]);
        Some(Position { x: number("x")?, y: number("y")?, lonlat })
    };
    let mut nth = 0;
    let mut read = |(band, id): (usize, String)| {
        let mut classes = Classes::default();
        let read = |odd: &mut _| tiff.read_band(band, grid.window(), odd, |value| classes.of(value));
        let mask = warned(warnings, read)?.into_cells();
        classes.check(path, grid, &format!("band {}, ", band + 1))?;
        nth += 1;
        // Bands of one layer follow each other in the order of the sites.
        Ok(SavedMask { id, path: shown.clone(), mask, place: place(nth - 1) })
    };
    sites.into_iter().map(&mut read).collect()
}

/// Warns of a map that was made for other receivers than those of this run, as far as its file
/// holds them.
fn warn_of_other_receivers(path: &Path, document: &Value, setting: &Setting<'_>, warnings: &mut Vec<Warning>) {
    let own: [(&'static str, Value); 4] = [
        ("rx_height_m", setting.sight.rx_height_m().into()),
        ("receivers", setting.sight.receivers().name().into()),
        ("radius_m", setting.sight.radius_m().into()),
        ("antenna", json!(AntennaFacts::of(setting.sight.antenna()))),
    ];
    for (setting, own) in own {
        if let Some(found) = document.get(setting).filter(|found| **found != own) {
            let (path, found, own) = (path.display().to_string(), found.to_string(), own.to_string());
            warnings.push(OddRun::OtherSetting { path, setting, found, own }.into());
        }
    }
}

/// Conversion of values to classes, and the first value that is no class.
#[derive(Debug, Default)]
struct Classes {
    n_seen: usize,
    wrong: Option<(usize, f64)>,
}

impl Classes {
    /// Returns the class of a value; NaN is nodata.
    fn of(&mut self, value: f64) -> u8 {
        self.n_seen += 1;
        let is = |class: &u8| value.total_cmp(&f64::from(*class)).is_eq();
        let known = [class::NLOS, class::LOS, class::NOT_A_RECEIVER, class::OUT_OF_RANGE, class::NODATA];
        match known.into_iter().find(is) {
            Some(class) => class,
            None if value.is_nan() => class::NODATA,
            None => {
                self.wrong.get_or_insert((self.n_seen - 1, value));
                class::NODATA
            }
        }
    }

    fn check(&self, path: &Path, grid: &GeoRef, band: &str) -> Result<()> {
        let Some((cell, value)) = self.wrong else { return Ok(()) };
        let (row, col) = (cell / grid.n_cols(), cell % grid.n_cols());
        let why = format!(
            "{band}row {row}, column {col} holds {value}, wanted 0 (NLoS), 1 (LoS), 2 (not a receiver), 3 (out of range) or \
             255 (nodata)"
        );
        Err(InputError::Mask { name: path.display().to_string(), why }.into())
    }
}
