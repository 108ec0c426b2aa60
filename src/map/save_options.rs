//! Options of files: tiles or strips, classes or GDAL's values, bare pictures, polygons; which of them a format takes.

use std::path::Path;

use crate::answer::Output;
use crate::coverage::class;
use crate::error::{Error, RequestError, Result};
use crate::export::{Format, Layer, MaskValues};
use crate::formats::TiffLayout;
use crate::picture::Look;
use crate::quantity::counted;
use crate::scene::Scene;

/// Which cells become polygons.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PolygonClasses {
    /// Cells in line of sight.
    Los,
    /// Receivers that are not.
    Nlos,
    /// Both.
    All,
}

impl PolygonClasses {
    /// The classes of a mask.
    pub(crate) fn classes(self) -> Vec<u8> {
        match self {
            PolygonClasses::Los => vec![class::LOS],
            PolygonClasses::Nlos => vec![class::NLOS],
            PolygonClasses::All => vec![class::LOS, class::NLOS],
        }
    }
}

/// In which form a map is written, where the extension of a file leaves that open.
///
/// ```
/// use skyshed::{Height, SaveOptions, Scene, Uav};
///
/// let city = Scene::options().size_m(100.0).open("itu:urban")?;
/// let seen = city.coverage(Uav::new(50.0, 50.0, Height::agl(100.0))).run()?;
/// let folder = std::env::temp_dir();
/// // A pixel for each cell, where a file of that name may stand already.
/// seen.save_with(folder.join("skyshed-doc.png"), &SaveOptions::default().bare().overwrite())?;
/// # Ok::<(), skyshed::Error>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct SaveOptions {
    pub(crate) overwrite: bool,
    pub(crate) bare: bool,
    pub(crate) tif_layout: Option<TiffLayout>,
    pub(crate) mask_values: MaskValues,
    pub(crate) polygons: Option<PolygonClasses>,
    pub(crate) simplify_m: Option<f64>,
    pub(crate) look: Look,
}

impl SaveOptions {
    /// Replaces files that exist.
    #[must_use]
    pub fn overwrite(self) -> Self {
        SaveOptions { overwrite: true, ..self }
    }

    /// PNG with one pixel for each cell, a world file and a `.prj`, instead of a picture.
    #[must_use]
    pub fn bare(self) -> Self {
        SaveOptions { bare: true, ..self }
    }

    /// Coverage as polygons in `.geojson` and `.fgb` files, one for each connected part of a class and UAV, holes kept.
    #[must_use]
    pub fn polygons(self, classes: PolygonClasses) -> Self {
        SaveOptions { polygons: Some(classes), ..self }
    }

    /// The title of pictures.
    #[must_use]
    pub fn title(mut self, title: impl Into<String>) -> Self {
        self.look.title = Some(title.into());
        self
    }

    /// The width of pictures, 100 to 10000 \[px\].
    #[must_use]
    pub fn width_px(mut self, width: u32) -> Self {
        self.look.width_px = Some(width);
        self
    }

    /// Refuses forms of what is not written, before any work.
    ///
    /// # Errors
    /// E116.
    pub(crate) fn check_formats(&self, outputs: &[Output]) -> Result<()> {
        let has = |wanted: Format| outputs.iter().any(|(_, format)| *format == wanted);
        if self.bare && !has(Format::Png) {
            return Err(Error::idle("bare", "without a .png output"));
        }
        if self.tif_layout.is_some() && !has(Format::GeoTiff) {
            return Err(Error::idle("tif_layout", "without a .tif output"));
        }
        Ok(())
    }

    /// Refuses what the outputs and their forms cannot be, once the scene is known and before any map is made.
    ///
    /// # Errors
    /// E109, E113, E116.
    pub(crate) fn check(&self, scene: &Scene, outputs: &[Output]) -> Result<()> {
        let has = |wanted: &[Format]| outputs.iter().any(|(_, format)| wanted.contains(format));
        let has_no_meaning = |option, wanted| Err(Error::idle(option, format!("without a {wanted} output")));
        if self.mask_values == MaskValues::Gdal && !has(&[Format::GeoTiff, Format::Bil]) {
            return has_no_meaning("gdal_values", ".tif or .bil");
        }
        if self.polygons.is_some() && !has(&[Format::GeoJson, Format::FlatGeobuf]) {
            return has_no_meaning("polygons", ".geojson or .fgb");
        }
        if let Some(tolerance) = self.simplify_m.filter(|m| *m <= 0.0) {
            return Err(Error::number("`simplify_m`", tolerance, "above 0 m"));
        }
        for (path, format) in outputs {
            match format {
                Format::FlatGeobuf if self.polygons.is_none() => {
                    return Err(RequestError::NoPolygons(path.display().to_string()).into());
                }
                Format::Kmz if scene.grid().crs().is_none() => return Err(no_crs(path)),
                _ => {}
            }
        }
        Ok(())
    }

    /// Refuses values of another program for what it does not make.
    ///
    /// # Errors
    /// E107.
    pub(crate) fn check_values(&self, layers: &[Layer], n_sites: usize) -> Result<()> {
        if self.mask_values == MaskValues::Classes || layers == [Layer::Los] && n_sites == 1 {
            return Ok(());
        }
        let names: Vec<&str> = layers.iter().map(|layer| layer.name()).collect();
        let (layers, uavs) = (names.join(","), counted(n_sites as u64, "UAV", "UAVs"));
        Err(RequestError::GdalValues { layers, uavs }.into())
    }
}

/// The error of an overlay of a scene that is nowhere on the globe.
pub(crate) fn no_crs(path: &Path) -> Error {
    RequestError::NoCrs(path.display().to_string()).into()
}
