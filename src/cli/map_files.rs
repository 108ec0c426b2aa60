//! The files of `skyshed map`.

use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

use super::args::{MapArgs, PolygonsArg, TifLayoutArg};
use super::interrupt;
use super::map::undrawable;
use super::map_drawing::MapDrawing;
use super::plan::Ready;
use super::receivers::cell_names;
use super::words::{picture_provenance, pretty};
use crate::coverage::{
    Control, CoveragePolygon, Overlay, PolygonOptions, SiteCoverage, Tally, class, coverage_polygons,
};
use crate::crs::wkt_of;
use crate::error::{Error, Result};
use crate::export::{
    Batch, Format, Layer, MapResult, MaskStrips, MaskValues, PolygonFile, add_flatgeobuf, add_map, bare_name,
    encode_kmz,
};
use crate::formats::{LonLatGrid, TiffLayout, world_file};
use crate::quantity::tidy;
use crate::raster::GeoRef;
use crate::render;
use crate::report::{KmlOverlay, MapReport, Timing, digest, kml};

/// Everything that outputs are made from.
pub(super) struct Writer<'a> {
    pub(super) args: &'a MapArgs,
    pub(super) scene: &'a Ready,
    pub(super) coverages: &'a [SiteCoverage],
    /// All masks together, for more than one UAV.
    pub(super) overlay: Option<&'a Overlay>,
    pub(super) layers: &'a [Layer],
    pub(super) report: &'a MapReport,
    pub(super) timing: Timing,
}

impl Writer<'_> {
    /// Adds the files of one output to a batch.
    pub(super) fn add(&self, batch: &mut Batch, path: &Path, format: Format) -> Result<()> {
        interrupt::check()?;
        match format {
            Format::GeoTiff | Format::Exr | Format::AsciiGrid | Format::Bil | Format::Npz => {
                let provenance = self.report.document(None).to_string();
                let result = MapResult {
                    georef: self.scene.field.grid(),
                    sites: self.coverages,
                    layers: self.layers,
                    provenance: &provenance,
                    tif_layout: match self.args.tif_layout {
                        TifLayoutArg::Cog => TiffLayout::Cog,
                        TifLayoutArg::Plain => TiffLayout::Plain,
                    },
                    mask_values: mask_values(self.args),
                };
                add_map(batch, &result, path, format)
            }
            Format::Kmz => batch.add(path, &self.kmz(path)?),
            Format::GeoJson if self.args.polygons.is_some() => {
                batch.add(path, format!("{}\n", self.report.polygons(&self.polygons()?)).as_bytes())
            }
            Format::FlatGeobuf => {
                let file = PolygonFile {
                    georef: self.scene.field.grid(),
                    polygons: &self.polygons()?,
                    title: &format!("Coverage of {}", self.scene.name),
                    provenance: &self.report.document(None).to_string(),
                };
                add_flatgeobuf(batch, &file, path)
            }
            _ => self.encode(path, format)?.iter().try_for_each(|(file, bytes)| {
                interrupt::check()?;
                batch.add(file, bytes)
            }),
        }
    }

    /// The files of an output that is no raster of values.
    fn encode(&self, path: &Path, format: Format) -> Result<Vec<(PathBuf, Vec<u8>)>> {
        let one = |bytes: Vec<u8>| Ok(vec![(path.to_path_buf(), bytes)]);
        match format {
            Format::Png if self.args.bare => self.bare(path),
            Format::Png | Format::Svg | Format::Pdf => one(self.picture(format)?),
            // The time of writing is not known before the file is written.
            Format::Json => one(pretty(&self.report.document(Some(self.timing))).into_bytes()),
            Format::GeoJson => one(pretty(&self.report.geojson()).into_bytes()),
            Format::Csv => {
                let bytes = self.args.out.table(&self.report.table())?;
                let sidecar = crate::export::with_suffix(path, ".json");
                Ok(vec![(path.to_path_buf(), bytes), (sidecar, pretty(&self.report.document(None)).into_bytes())])
            }
            _ => Ok(Vec::new()),
        }
    }

    fn provenance(&self) -> [(String, String); 2] {
        picture_provenance(&self.report.document(None))
    }

    /// Pixels that are cells, with what places them on a map; several sites get a file each and one of the union.
    fn bare(&self, path: &Path) -> Result<Vec<(PathBuf, Vec<u8>)>> {
        let grid = self.scene.field.grid();
        let document = |report: &MapReport| report.document(None).to_string();
        let beside = |path: &Path, document: &str| {
            let mut files = vec![(path.with_extension("pgw"), world_file(grid).into_bytes())];
            files.extend(grid.crs().and_then(wkt_of).map(|wkt| (path.with_extension("prj"), wkt.into_bytes())));
            files.push((crate::export::with_suffix(path, ".json"), format!("{document}\n").into_bytes()));
            files
        };
        let software = || ("Software".to_string(), format!("skyshed {}", env!("CARGO_PKG_VERSION")));
        let all = document(self.report);
        let provenance = [software(), ("skyshed".to_string(), all.clone())];
        let mut files = Vec::new();
        let (None, [only]) = (self.overlay, self.coverages) else {
            let n_sites = u32::try_from(self.coverages.len()).unwrap_or(u32::MAX);
            let (count, union) = self.overlay.map_or((&[][..], &[][..]), |o| (o.count(), o.union()));
            let png = render::draw_bare_count(grid.n_cols(), grid.n_rows(), count, union, n_sites, &provenance);
            files.push((path.to_path_buf(), png.map_err(undrawable)?));
            files.extend(beside(path, &all));
            for (site, facts) in self.coverages.iter().zip(&self.report.sites) {
                // Each file speaks of its own UAV, or a thousand files would each speak of a thousand.
                let own = document(&self.report.of_site(facts, digest(grid, std::iter::once(site.mask.as_slice()))));
                let path = bare_name(path, &site.uav.id);
                let provenance = [software(), ("skyshed".to_string(), own.clone())];
                let png = render::draw_bare(grid.n_cols(), grid.n_rows(), &site.mask, &provenance);
                files.push((path.clone(), png.map_err(undrawable)?));
                files.extend(beside(&path, &own));
            }
            return Ok(files);
        };
        let png = render::draw_bare(grid.n_cols(), grid.n_rows(), &only.mask, &provenance).map_err(undrawable)?;
        files.push((path.to_path_buf(), png));
        files.extend(beside(path, &all));
        Ok(files)
    }

    fn picture(&self, format: Format) -> Result<Vec<u8>> {
        let drawing = MapDrawing {
            scene: self.scene,
            coverages: self.coverages,
            overlay: self.overlay,
            layers: self.layers,
            report: self.report,
            receivers: self.args.receivers,
            words: &self.args.words,
            counts: None,
            note: None,
        };
        drawing.draw(format, &self.provenance())
    }

    /// The polygons that were asked for.
    fn polygons(&self) -> Result<Vec<CoveragePolygon>> {
        let grid = self.scene.field.grid();
        let classes = match self.args.polygons {
            Some(PolygonsArg::Los) => vec![class::LOS],
            Some(PolygonsArg::Nlos) => vec![class::NLOS],
            Some(PolygonsArg::All) => vec![class::LOS, class::NLOS],
            None => return Err(Error::internal(902, "polygons were not asked for")),
        };
        let options =
            PolygonOptions { classes, simplify_m: self.args.simplify, meters_per_unit: grid.meters_per_unit() };
        Ok(coverage_polygons(self.coverages, grid, &options))
    }

    /// Overlays for globes: line of sight of each UAV, and for several also of any, which alone is visible at first.
    fn kmz(&self, path: &Path) -> Result<Vec<u8>> {
        let Some(degrees) = LonLatGrid::over(self.scene.field.grid())? else { return Err(no_crs(path)) };
        let mut shown: Vec<(String, &[u8], Tally)> = Vec::new();
        shown.extend(self.overlay.map(|o| ("Seen by at least one UAV".to_string(), o.union(), self.report.union)));
        let sites = self.coverages.iter().zip(&self.report.sites);
        shown.extend(sites.map(|(site, facts)| (format!("Seen by UAV {}", site.uav.id), &*site.mask, facts.tally)));
        let provenance = self.provenance();
        let mut overlays = Vec::new();
        let mut pictures = Vec::new();
        for (k, (name, mask, tally)) in shown.iter().enumerate() {
            interrupt::check()?;
            let mask = degrees.resampled(mask, class::NODATA);
            // Buildings are left to the globe.
            let mask: Vec<u8> = mask.iter().map(|c| if *c > class::LOS { class::NODATA } else { *c }).collect();
            let (n_cols, n_rows) = (degrees.georef().n_cols(), degrees.georef().n_rows());
            let png = render::draw_bare(n_cols, n_rows, &mask, &provenance).map_err(undrawable)?;
            let share = tally.p_los().map_or_else(|| "undefined".to_string(), |p| format!("{p:.4}"));
            let file = format!("overlay-{}.png", k + 1);
            overlays.push(KmlOverlay {
                name: format!("{name}: P_LoS {share}"),
                file: file.clone(),
                is_visible: k == 0,
            });
            pictures.push((file, png));
        }
        const LEGEND: &str = "legend.png";
        let uavs = match self.coverages {
            [only] => format!("of UAV {}", only.uav.id),
            _ => "of at least one UAV, or of the one whose overlay is shown".to_string(),
        };
        let (receivers, _) = cell_names(self.args.receivers, &self.scene.field);
        let receivers = format!("Receivers: {receivers}, {} m high", tidy(self.args.rx_height));
        pictures
            .push((LEGEND.into(), render::draw_overlay_legend(&uavs, &receivers, &provenance).map_err(undrawable)?));
        encode_kmz(&kml(self.report, &degrees, &overlays, LEGEND)?, &pictures)
    }
}

/// The values of masks that were asked for.
pub(super) fn mask_values(args: &MapArgs) -> MaskValues {
    if args.gdal_values { MaskValues::Gdal } else { MaskValues::Classes }
}

/// The only output, if that is a plain GeoTIFF of line of sight: one that can be written while the mask is made.
pub(super) fn written_at_once<'a>(
    outputs: &'a [(PathBuf, Format)],
    layers: &[Layer],
    args: &MapArgs,
) -> Option<&'a Path> {
    match (outputs, layers, args.tif_layout) {
        ([(path, Format::GeoTiff)], [Layer::Los], TifLayoutArg::Plain) => Some(path),
        _ => None,
    }
}

/// A file that a mask is written to part by part. It is begun with the first part, so that until then an interrupt ends
/// the program at once.
pub(super) struct MaskFile<'a> {
    path: &'a Path,
    values: MaskValues,
    strips: Option<Result<MaskStrips>>,
}

impl<'a> MaskFile<'a> {
    pub(super) fn new(path: &'a Path, values: MaskValues) -> Self {
        MaskFile { path, values, strips: None }
    }

    /// Writes some rows; stops the map after a failure or an interrupt.
    pub(super) fn push(&mut self, batch: &mut Batch, grid: &GeoRef, cells: &[u8], control: &Control) {
        let strips = self.strips.get_or_insert_with(|| {
            interrupt::begin_writing();
            MaskStrips::begin(batch, self.path, grid, self.values)
        });
        if let Ok(open) = strips
            && let Err(error) = interrupt::check().and_then(|()| open.push(cells))
        {
            *strips = Err(error);
        }
        if strips.is_err() {
            control.stop.store(true, Ordering::Relaxed);
        }
    }

    /// The file with all parts.
    pub(super) fn written(self) -> Result<Option<MaskStrips>> {
        self.strips.transpose()
    }
}

/// Refuses what the outputs and their flags cannot be, once the scene is known and before any map is made.
pub(super) fn check_flags(args: &MapArgs, scene: &Ready, outputs: &[(PathBuf, Format)]) -> Result<()> {
    let has = |wanted: &[Format]| outputs.iter().any(|(_, format)| wanted.contains(format));
    let has_no_meaning =
        |flag: &str, wanted: &str| Err(Error::usage(116, format!("`{flag}` has no meaning without a {wanted} output")));
    if args.gdal_values && !has(&[Format::GeoTiff, Format::Bil]) {
        return has_no_meaning("--gdal-values", ".tif or .bil");
    }
    if args.polygons.is_some() && !has(&[Format::GeoJson, Format::FlatGeobuf]) {
        return has_no_meaning("--polygons", ".geojson or .fgb");
    }
    if let Some(tolerance) = args.simplify.filter(|m| *m <= 0.0) {
        return Err(Error::usage(113, format!("`--simplify` is `{tolerance}`, wanted above 0 m")));
    }
    for (path, format) in outputs {
        match format {
            Format::FlatGeobuf if args.polygons.is_none() => {
                let text = format!("cannot write {}: it holds polygons", path.display());
                return Err(Error::usage(116, text).with_hint("`--polygons los` makes them"));
            }
            Format::Kmz if scene.field.grid().crs().is_none() => return Err(no_crs(path)),
            _ => {}
        }
    }
    Ok(())
}

fn no_crs(path: &Path) -> Error {
    let text = format!(
        "cannot write {}: the scene has no coordinate reference system, wanted one that leads to longitude and latitude",
        path.display()
    );
    Error::usage(109, text).with_hint("`--crs EPSG:N` names that of a file; a generated city has none")
}
