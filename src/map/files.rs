//! Content of each file of a map, format by format.

use std::path::{Path, PathBuf};

use skyshed_request::{Layer, TiffLayout};

use super::coverages::Coverages;
use super::drawing::MapDrawing;
use super::kml::{KmlOverlay, kml};
use super::raster_files::add_raster;
use super::report::{MapReport, MaskDigest};
use skyshed_request::PolygonClasses;

use super::save_checks::{mask_values, no_crs};
use crate::answer::{Answer, Output, Rows, Spent};
use crate::coverage::{CoveragePolygon, PolygonOptions, Tally, class, coverage_polygons};
use crate::crs::wkt_of;
use crate::error::{Error, Result, Warning};
use crate::export::{
    Batch, Format, MapResult, MaskStrips, MaskValues, PolygonFile, add_flatgeobuf, add_map, bare_name, encode_kmz,
    with_suffix,
};
use crate::formats::{LonLatGrid, world_file};
use crate::picture::{Look, drawn, picture_provenance, program};
use crate::progress::Progress;
use crate::quantity::tidy;
use crate::raster::GeoRef;
use crate::render::{self, PictureForm};
use crate::words::{p_los_words, pretty};
use skyshed_request::SaveOptions;

/// Inputs of all outputs of a map.
pub(crate) struct Writer<'a> {
    pub(crate) of: &'a Coverages,
    pub(crate) options: &'a SaveOptions,
}

impl Answer for Writer<'_> {
    fn document(&self, spent: Option<Spent>) -> serde_json::Value {
        let report = &self.of.report;
        report.document(spent.and_then(|spent| report.timing(self.of.scene.timing.with(spent))))
    }

    fn table(&self) -> Rows {
        self.of.report.table()
    }

    fn warnings(&self) -> &[Warning] {
        &self.of.report.facts.warnings
    }

    fn add(&self, batch: &mut Batch, path: &Path, format: Format, look: &Look) -> Result<()> {
        match format {
            Format::GeoTiff | Format::Exr | Format::AsciiGrid | Format::Bil | Format::Npz => {
                let provenance = self.of.report.document(None).to_string();
                let result = MapResult {
                    georef: self.of.scene.field.grid(),
                    sites: &self.of.sites,
                    n_uavs: self.of.n_uavs(),
                    overlay: self.of.overlay.as_ref(),
                    layers: &self.of.layers,
                    provenance: &provenance,
                    tif_layout: self.options.forms.tif_layout.unwrap_or_default(),
                    mask_values: mask_values(self.options),
                };
                // Tiles get no style of their own: it is written beside their mosaic.
                match self.of.report.tile {
                    Some(_) => add_map(batch, &result, path, format)?,
                    None => add_raster(batch, &result, path, format)?,
                }
            }
            Format::Kmz => batch.add(path, &self.kmz(path)?)?,
            Format::GeoJson if self.options.forms.polygons.is_some() => {
                batch.add(path, format!("{}\n", self.of.report.polygons(&self.polygons()?)).as_bytes())?;
            }
            Format::GeoJson => batch.add(path, pretty(&self.of.report.geojson()).as_bytes())?,
            Format::FlatGeobuf => {
                let file = PolygonFile {
                    georef: self.of.scene.field.grid(),
                    polygons: &self.polygons()?,
                    title: &format!("Coverage of {}", self.of.scene.name),
                    provenance: &self.of.report.document(None).to_string(),
                };
                add_flatgeobuf(batch, &file, path)?;
            }
            Format::Png if self.options.forms.bare => {
                self.bare(path)?.iter().try_for_each(|(file, bytes)| batch.add(file, bytes))?
            }
            _ => {
                let drawing = MapDrawing { of: self.of, look, counts: None, note: None };
                batch.add(path, &drawing.draw(format, &self.provenance_words())?)?;
            }
        }
        Ok(())
    }
}

impl Writer<'_> {
    /// Returns the picture as PNG.
    ///
    /// # Errors
    /// E403.
    pub(super) fn png(&self, look: &Look) -> Result<Vec<u8>> {
        if self.options.forms.bare {
            let first = self.bare(Path::new("map.png"))?.into_iter().next();
            return first.map(|(_, png)| png).ok_or(Error::fault("no picture was drawn"));
        }
        MapDrawing { of: self.of, look, counts: None, note: None }.draw(Format::Png, &self.provenance_words())
    }

    fn provenance_words(&self) -> [(String, String); 2] {
        picture_provenance(&self.of.report.document(None))
    }

    /// Returns pictures of one pixel per cell, with their georeferencing. Several sites get a file
    /// each, and one of all together.
    fn bare(&self, path: &Path) -> Result<Vec<(PathBuf, Vec<u8>)>> {
        let grid = self.of.scene.field.grid();
        let document = |report: &MapReport| report.document(None).to_string();
        let beside = |path: &Path, document: &str| {
            let mut files = vec![(path.with_extension("pgw"), world_file(grid).into_bytes())];
            files.extend(grid.crs().and_then(wkt_of).map(|wkt| (path.with_extension("prj"), wkt.into_bytes())));
            files.push((with_suffix(path, ".json"), format!("{document}\n").into_bytes()));
            files
        };
        let software = || ("Software".to_string(), program());
        let all = document(&self.of.report);
        let provenance = [software(), ("skyshed".to_string(), all.clone())];
        let mut files = Vec::new();
        let [only] = &self.of.sites[..] else {
            let n_sites = u32::try_from(self.of.sites.len()).unwrap_or(u32::MAX);
            let (count, union) = self.of.overlay.as_ref().map_or((&[][..], &[][..]), |o| (o.count(), o.union()));
            let png = render::draw_bare_count(grid.n_cols(), grid.n_rows(), count, union, n_sites, &provenance);
            files.push((path.to_path_buf(), drawn(png)?));
            files.extend(beside(path, &all));
            for (site, facts) in self.of.sites.iter().zip(&self.of.report.sites) {
                // Each file documents its own UAV: a thousand files need not each list a thousand
                // UAVs.
                let own = document(
                    &self.of.report.of_site(facts, MaskDigest::of(grid, std::iter::once(site.mask.as_slice()))),
                );
                let path = bare_name(path, &site.uav.id);
                let provenance = [software(), ("skyshed".to_string(), own.clone())];
                let png = render::draw_bare(grid.n_cols(), grid.n_rows(), &site.mask, &provenance);
                files.push((path.clone(), drawn(png)?));
                files.extend(beside(&path, &own));
            }
            return Ok(files);
        };
        let png = drawn(render::draw_bare(grid.n_cols(), grid.n_rows(), &only.mask, &provenance))?;
        files.push((path.to_path_buf(), png));
        files.extend(beside(path, &all));
        Ok(files)
    }

    /// Returns the requested polygons.
    fn polygons(&self) -> Result<Vec<CoveragePolygon>> {
        let grid = self.of.scene.field.grid();
        let Some(classes) = self.options.forms.polygons.map(PolygonClasses::classes) else {
            return Err(Error::fault("polygons were not asked for"));
        };
        let options = PolygonOptions {
            classes: classes.to_vec(),
            simplify_m: self.options.forms.simplify,
            meters_per_unit: grid.meters_per_unit(),
        };
        Ok(coverage_polygons(&self.of.sites, grid, &options))
    }

    /// Returns overlays for globes: the line of sight of each UAV and, for several, of any of them.
    /// Only the first overlay is visible at first.
    fn kmz(&self, path: &Path) -> Result<Vec<u8>> {
        let Some(degrees) = LonLatGrid::over(self.of.scene.field.grid())? else { return Err(no_crs(path)) };
        let who = self.of.report.sight.receivers().other_end();
        let mut shown: Vec<(String, &[u8], Tally)> = Vec::new();
        let overlay = self.of.overlay.as_ref().filter(|_| self.of.sites.len() > 1);
        shown.extend(overlay.map(|o| (format!("Seen by at least one {who}"), o.union(), self.of.report.union)));
        let sites = self.of.sites.iter().zip(&self.of.report.sites);
        shown.extend(sites.map(|(site, facts)| (format!("Seen by {who} {}", site.uav.id), &*site.mask, facts.tally)));
        let provenance = self.provenance_words();
        let mut overlays = Vec::new();
        let mut pictures = Vec::new();
        for (k, (name, mask, tally)) in shown.iter().enumerate() {
            let mask = degrees.resampled(mask, class::NODATA);
            // Cells without a receiver, such as buildings, are left to the globe.
            let mask: Vec<u8> = mask.iter().map(|c| if *c > class::LOS { class::NODATA } else { *c }).collect();
            let (n_cols, n_rows) = (degrees.georef().n_cols(), degrees.georef().n_rows());
            let png = drawn(render::draw_bare(n_cols, n_rows, &mask, &provenance))?;
            let share = p_los_words(tally.p_los());
            let file = format!("overlay-{}.png", k + 1);
            overlays.push(KmlOverlay {
                name: format!("{name}: P_LoS {share}"),
                file: file.clone(),
                is_visible: k == 0,
            });
            pictures.push((file, png));
        }
        const LEGEND: &str = "legend.png";
        let uavs = match &self.of.sites[..] {
            [only] => format!("of UAV {}", only.uav.id),
            _ => "of at least one UAV, or of the one whose overlay is shown".to_string(),
        };
        let sight = &self.of.report.sight;
        let (receivers, _) = sight.receivers().cell_names(&self.of.scene.field);
        let receivers = format!("Receivers: {receivers}, {} m high", tidy(sight.rx_height_m()));
        pictures.push((
            LEGEND.into(),
            drawn(render::draw_overlay_legend(&uavs, &receivers).write(&PictureForm::PNG, &provenance))?,
        ));
        Ok(encode_kmz(&kml(&self.of.report, &degrees, &overlays, LEGEND)?, &pictures)?)
    }
}

/// Returns the only output if it is a plain GeoTIFF of line of sight, which can be written while
/// the mask is made.
pub(crate) fn written_at_once<'a>(outputs: &'a [Output], layers: &[Layer], options: &SaveOptions) -> Option<&'a Path> {
    match (outputs, layers, options.forms.tif_layout) {
        ([(path, Format::GeoTiff)], [Layer::Los], Some(TiffLayout::Plain)) => Some(path),
        _ => None,
    }
}

/// File to which a mask is written part by part. It begins with the first part: until then, an
/// interrupt ends the program at once.
pub(crate) struct MaskFile<'a> {
    path: &'a Path,
    values: MaskValues,
    strips: Option<Result<MaskStrips>>,
}

impl<'a> MaskFile<'a> {
    pub(crate) fn new(path: &'a Path, values: MaskValues) -> Self {
        MaskFile { path, values, strips: None }
    }

    /// Writes some rows. Stops the map after a failure or an interrupt.
    pub(crate) fn push(&mut self, batch: &mut Batch, grid: &GeoRef, cells: &[u8], progress: &Progress) {
        let strips = self.strips.get_or_insert_with(|| {
            (progress.begin_writing)();
            Ok(MaskStrips::begin(batch, self.path, grid, self.values)?)
        });
        if let Ok(open) = strips
            && let Err(error) = (progress.check)().map_err(Error::from).and_then(|()| Ok(open.push(cells)?))
        {
            *strips = Err(error);
        }
        if strips.is_err() {
            progress.stop();
        }
    }

    /// Returns the file with all parts; `None` if there was no part.
    pub(crate) fn written(self) -> Result<Option<MaskStrips>> {
        self.strips.transpose()
    }
}
