//! `skyshed info --zones`: the zones of a scene as files.

use std::path::PathBuf;

use super::interrupt;
use crate::coverage::class;
use crate::error::{Error, Result};
use crate::export::{Batch, Format, add_zones};
use crate::height_field::HeightField;
use crate::picture::PictureSize;
use crate::quantity::{counted, tidy};
use crate::raster::Crs;
use crate::render::{self, MapClass, MapPicture, PictureForm, grouped};
use crate::report::{RunFacts, zones_geojson};
use crate::words::title_of;
use crate::zones::{NONE, Zone, ZoneBasis, ZoneMap};

/// What the files are made from.
pub(super) struct ZoneFiles<'a> {
    pub(super) zones: &'a ZoneMap,
    pub(super) field: &'a HeightField,
    pub(super) facts: &'a RunFacts,
    pub(super) title: Option<&'a str>,
    pub(super) attribution: Option<String>,
    /// What limits the truth of a picture of the scene.
    pub(super) limits: Option<String>,
    pub(super) size: PictureSize,
}

impl ZoneFiles<'_> {
    /// Adds the pictures, rasters and polygons among the outputs.
    pub(super) fn add(&self, batch: &mut Batch, outputs: &[(PathBuf, Format)]) -> Result<()> {
        let provenance = self.facts.provenance("skyshed/zones/1", None);
        for (path, format) in outputs {
            interrupt::check()?;
            match format {
                Format::Png | Format::Svg | Format::Pdf => {
                    batch.add(path, &self.picture(&provenance.to_string(), &self.size.form(*format))?)?;
                }
                Format::GeoTiff => add_zones(batch, self.zones, &provenance.to_string(), path)?,
                Format::GeoJson => {
                    let polygons = zones_geojson(self.zones, self.facts.meters_per_unit, &provenance);
                    batch.add(path, format!("{polygons}\n").as_bytes())?;
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn picture(&self, provenance: &str, form: &PictureForm) -> Result<Vec<u8>> {
        let grid = &self.facts.grid;
        let unit = self.facts.meters_per_unit;
        let open = [Zone::Street, Zone::Crossroad, Zone::Courtyard];
        #[expect(clippy::cast_precision_loss, reason = "a percentage for reading")]
        let share =
            |zone| 100.0 * self.zones.count(zone) as f64 / open.map(|z| self.zones.count(z)).iter().sum::<u64>() as f64;
        let detail = |zone: Zone| {
            let parts = self.zones.n_parts(zone) as u64;
            format!("{:.1} % of open ground · {}", share(zone), counted(parts, "part", "parts"))
        };
        let details = open.map(detail);
        let names = ["Street", "Crossroad", "Courtyard"];
        let palette: Vec<MapClass<'_>> =
            (0..open.len()).map(|k| MapClass { name: names[k], detail: &details[k], color: open[k].color() }).collect();
        let codes = self.zones.codes();
        let index: Vec<u8> = codes.iter().map(|code| code.saturating_sub(1)).collect();
        let mask: Vec<u8> = codes
            .iter()
            .map(|code| match *code {
                NONE => class::NODATA,
                code if code == Zone::Rooftop.code() => class::NOT_A_RECEIVER,
                _ => class::LOS,
            })
            .collect();
        let surface = self.field.above_ground_m();
        let how = match self.zones.basis() {
            ZoneBasis::StreetGrid => "Zones by construction: the streets of the generated city",
            _ => "Zones from the triangulation of the open ground between the buildings",
        };
        let crs = grid.crs().map_or("local coordinates".to_string(), Crs::label);
        let mut caption = vec![
            format!(
                "{how}; {} cells of {} × {} m",
                grouped(grid.n_cells() as u64),
                tidy(grid.cell_width() * unit),
                tidy(grid.cell_height() * unit)
            ),
            format!(
                "South-west corner at ({}, {}), {crs}; skyshed {}",
                tidy(grid.x_min()),
                tidy(grid.y_min()),
                env!("CARGO_PKG_VERSION")
            ),
        ];
        caption.extend(self.limits.clone());
        caption.extend(self.attribution.clone());
        let title = self.title.map_or_else(|| title_of(&format!("Zones of {}", self.facts.scene_name)), str::to_string);
        let picture = MapPicture {
            title: &title,
            caption: &caption,
            n_cols: grid.n_cols(),
            n_rows: grid.n_rows(),
            cell_m: (grid.cell_width() * unit, grid.cell_height() * unit),
            layer: render::Layer::Classes { index: &index, palette: &palette, mask: &mask },
            surface_m: Some(&surface),
            uavs: &[],
            receivers_name: "open-ground cells",
            others_name: "Rooftop",
            counts: None,
        };
        let provenance = [("skyshed".to_string(), provenance.to_string())];
        let drawn = render::draw_map(&picture, form, &provenance);
        drawn.map_err(|cause| Error::internal(403, format!("cannot draw the picture: {cause}")))
    }
}
