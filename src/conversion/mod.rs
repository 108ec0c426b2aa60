//! Conversion of a city into another form, and pictures of it: `skyshed city`.

mod features;

use std::ffi::OsStr;
use std::path::Path;
use std::time::Instant;

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use skyshed_request::TiffLayout;

use crate::answer::{Answer, CommandFacts, Output, Provenance, RunFacts, Spent, document_of};
use crate::city::{Footprint, Solids};
use crate::crs::wkt_of;
use crate::error::{RequestError, Result, Warning};
use crate::export::{
    Batch, CityMesh, Format, MitsubaScene, add_mitsuba, city_mesh, encode_table, ns3_boxes, with_suffix,
};
use crate::formats::{Bands, GeoTiffImage, encode_geotiff, write_ascii_grid};
use crate::height_field::{roof_triangles, wall_edges};
use crate::memory::Needs;
use crate::picture::{Look, crs_words, picture_provenance, program, written};
use crate::quantity::{Frame, VOID, meters, tidy};
use crate::render::{self, CityHeights, CityModel, CityPicture, CityPrism, grouped};
use crate::scene::{Scene, SceneReader};
use crate::words::{pretty, title_of};

/// Output formats of a city.
pub(crate) const FORMATS: [Format; 10] = [
    Format::Png,
    Format::Svg,
    Format::Pdf,
    Format::GeoTiff,
    Format::AsciiGrid,
    Format::GeoJson,
    Format::Mitsuba,
    Format::Csv,
    Format::Json,
    Format::Stdout,
];

/// Nodata value of height rasters.
const NODATA: f32 = -9999.0;

/// A city, ready to be written.
#[derive(Debug)]
pub(crate) struct Conversion {
    scene: Scene,
    facts: RunFacts,
    /// Footprints and their lattice; `None` for a raster scene.
    footprints: Option<(Vec<Footprint>, Frame)>,
}

impl Conversion {
    /// Reads a city.
    ///
    /// # Errors
    /// As [`SceneReader::open`].
    pub(crate) fn open(options: &SceneReader, word: &OsStr, command: CommandFacts) -> Result<Conversion> {
        let (start, mut warnings) = (Instant::now(), Vec::new());
        let city = options.read(word, &mut warnings)?;
        let footprints = match &city.solids {
            Solids::Vector { footprints, frame, .. } => Some((footprints.clone(), *frame)),
            Solids::Raster { .. } => None,
        };
        let scene = Scene::built(options, (word, city), warnings, start)?;
        Ok(Conversion { facts: RunFacts { command, ..scene.facts(None) }, scene, footprints })
    }

    /// Wraps a scene that was read before, with its solids if these are footprints.
    pub(crate) fn of(scene: Scene, command: CommandFacts) -> Conversion {
        let footprints = match scene.solids.as_deref() {
            Some(Solids::Vector { footprints, frame, .. }) => Some((footprints.clone(), *frame)),
            _ => None,
        };
        Conversion { facts: RunFacts { command, ..scene.facts(None) }, scene, footprints }
    }

    /// Refuses files that take more memory than there is, before any of them is made.
    ///
    /// # Errors
    /// E501.
    pub(crate) fn check_memory(&self, outputs: &[Output]) -> Result<()> {
        let grid = self.scene.grid();
        outputs.iter().try_for_each(|(_, format)| Needs::of_city(*format, grid).check(&self.scene))
    }

    /// Returns the size of the city, as a line of text.
    fn size_line(&self) -> String {
        let grid = self.scene.field.grid();
        let unit = grid.meters_per_unit();
        let (width, height) = ((grid.x_max() - grid.x_min()) * unit, (grid.y_max() - grid.y_min()) * unit);
        match &self.footprints {
            Some((footprints, _)) => {
                let n = self.scene.field.n_buildings();
                format!("{n} buildings on {} × {} m{}", tidy(width), tidy(height), self.rows_in_words(footprints))
            }
            None => format!("{} × {} cells, {} × {} m", grid.n_cols(), grid.n_rows(), tidy(width), tidy(height)),
        }
    }

    /// Explains the number of buildings of a generated city. Rows begin at the south-west corner
    /// and end at the edge of the city.
    fn rows_in_words(&self, footprints: &[Footprint]) -> String {
        let (Some(built_up), [first, .., last]) = (self.scene.built_up, footprints) else { return String::new() };
        let width = |footprint: &Footprint| {
            let xs = || footprint.polygons.iter().flatten().flatten().map(|[x, _]| *x);
            xs().max().zip(xs().min()).map_or(0, |(east, west)| east - west)
        };
        let n_rows = footprints.len().isqrt();
        // Rounding to the lattice can move each end by half a unit.
        let cut = if width(last) + 1 < width(first) { "; the edge cuts the last" } else { "" };
        let (period, beta) = (tidy((10.0 * built_up.period()).round() / 10.0), tidy(built_up.buildings_per_km2));
        format!(": {n_rows} rows of {n_rows}, one each {period} m as {beta}/km² asks{cut}")
    }

    /// Returns the position of the city, as a line of text.
    fn place_line(&self) -> String {
        let grid = self.scene.field.grid();
        format!("South-west corner at ({}, {}), {}", tidy(grid.x_min()), tidy(grid.y_min()), crs_words(grid))
    }

    /// Returns the footprints and their lattice.
    fn vectors(&self, path: &Path) -> Result<&(Vec<Footprint>, Frame)> {
        self.footprints.as_ref().ok_or_else(|| RequestError::NoFootprints(path.display().to_string()).into())
    }

    /// Adds a scene of Mitsuba and its meshes to a batch.
    fn add_mitsuba(&self, batch: &mut Batch, path: &Path) -> Result<()> {
        let (footprints, frame) = self.vectors(path)?;
        let grid = self.scene.field.grid();
        let mesh = CityMesh {
            footprints,
            frame: *frame,
            grid,
            ground_m: &self.ground_m(),
            meters_per_unit: grid.meters_per_unit(),
        };
        let (ground, buildings) = city_mesh(&mesh)?;
        let origin = format!(
            "{}: meters, x east, y north, z above the datum; the origin is ({}, {}) in {}",
            program(),
            grid.x_min(),
            grid.y_min(),
            crs_words(grid)
        );
        let facts = self.facts.provenance(SCHEMA);
        let provenance = CityDocument {
            provenance: facts,
            mesh: Some(MeshFacts { origin: [grid.x_min(), grid.y_min()], unit: "m" }),
        };
        let scene = MitsubaScene {
            ground: &ground,
            buildings: &buildings,
            origin: &origin,
            provenance: &pretty(&document_of(&provenance)),
        };
        Ok(add_mitsuba(batch, &scene, path)?)
    }

    fn picture(&self, format: Format, look: &Look) -> Result<Vec<u8>> {
        let grid = self.scene.field.grid();
        let unit = grid.meters_per_unit();
        let (width, height) = ((grid.x_max() - grid.x_min()) * unit, (grid.y_max() - grid.y_min()) * unit);
        // Axes count from the south-west corner, because projected coordinates have too many
        // digits.
        let local = |[x, y]: [f64; 2]| [(x - grid.x_min()) * unit, (y - grid.y_min()) * unit];
        let (prisms, surface, ground);
        let model = match &self.footprints {
            Some((footprints, frame)) => {
                prisms = footprints.iter().map(|f| prism_of(f, *frame, &local)).collect::<Vec<CityPrism>>();
                CityModel::Prisms(&prisms)
            }
            None => {
                surface = self.scene.field.surface_m();
                ground = self.ground_m();
                CityModel::Heights(CityHeights {
                    n_cols: grid.n_cols(),
                    n_rows: grid.n_rows(),
                    surface_m: &surface,
                    ground_m: &ground,
                })
            }
        };
        let mut caption = vec![self.size_line(), format!("{}; {}", self.place_line(), program())];
        caption.extend(self.scene.last_lines(look));
        let title = look.title_or(|| title_of(&self.facts.scene_name));
        let picture = CityPicture { title: &title, caption: &caption, extent_m: [0.0, 0.0, width, height], model };
        written(render::draw_city(&picture), &look.form(format), &picture_provenance(&self.provenance()))
    }

    fn ground_m(&self) -> Vec<f32> {
        let grid = self.scene.field.grid();
        let positions = self.scene.field.positions();
        let mut ground = Vec::with_capacity(grid.n_cells());
        for row in 0..grid.n_rows() {
            for col in 0..grid.n_cols() {
                let z = self.scene.field.ground_at(&positions.center(row, col));
                #[expect(clippy::cast_possible_truncation, reason = "a picture needs no more")]
                ground.push(if z == VOID { f32::NAN } else { meters(z) as f32 });
            }
        }
        ground
    }

    /// Returns the highest surface of each cell \[m above the datum\].
    fn heights(&self) -> Vec<f32> {
        let surface = self.scene.field.surface_m();
        surface.iter().map(|z| if z.is_nan() { NODATA } else { *z }).collect()
    }

    fn geotiff(&self) -> Result<Vec<u8>> {
        Ok(encode_geotiff(&GeoTiffImage {
            georef: self.scene.grid(),
            bands: Bands::Float(vec![("height".into(), &self.heights())]),
            nodata: Some(f64::from(NODATA)),
            palette: None,
            metadata: &[("SKYSHED".into(), self.provenance().to_string())],
            layout: TiffLayout::Cog,
        })?)
    }

    fn add_ascii_grid(&self, batch: &mut Batch, path: &Path) -> Result<()> {
        let (mut bytes, heights) = (Vec::new(), self.heights());
        let mut values = heights.iter().map(|z| f64::from(*z));
        write_ascii_grid(&mut bytes, self.scene.grid(), f64::from(NODATA), &mut values, None).map_err(|e| {
            let fault = skyshed_io::error::WriteFault::Encode(e.to_string());
            skyshed_io::Error::Write(path.display().to_string(), fault)
        })?;
        batch.add(path, &bytes)?;
        if let Some(wkt) = self.scene.grid().crs().and_then(wkt_of) {
            batch.add(&path.with_extension("prj"), wkt.as_bytes())?;
        }
        Ok(batch.add(&with_suffix(path, ".json"), pretty(&self.provenance()).as_bytes())?)
    }
}

const SCHEMA: &str = "skyshed/city/1";

/// Provenance of a city.
#[derive(Serialize, JsonSchema)]
pub(crate) struct CityDocument {
    #[serde(flatten)]
    provenance: Provenance,
    /// Coordinate system of a mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    mesh: Option<MeshFacts>,
}

/// Coordinate system of a mesh.
#[derive(Serialize, JsonSchema)]
struct MeshFacts {
    /// Origin of the mesh coordinates, east and north [units of the scene's reference system].
    origin: [f64; 2],
    /// Unit of the coordinates.
    unit: &'static str,
}

impl Answer for Conversion {
    fn document(&self, _: Option<Spent>) -> Value {
        document_of(&CityDocument { provenance: self.facts.provenance(SCHEMA), mesh: None })
    }

    fn warnings(&self) -> &[Warning] {
        &self.facts.warnings
    }

    fn notes(&self, _: Spent) -> Vec<String> {
        vec![match self.footprints {
            Some(_) => {
                format!("{}, {} buildings", self.facts.scene_name, grouped(self.scene.field.n_buildings() as u64))
            }
            None => self.facts.scene_name.clone(),
        }]
    }

    fn text(&self, _: &Look) -> Result<String> {
        let surface = self.scene.field.surface_m();
        let heights = surface.iter().copied().filter(|z| z.is_finite());
        let (low, high) = heights.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), z| (low.min(z), high.max(z)));
        let surface = match low <= high {
            true => format!("surface {} to {} m above the datum\n", tidy(f64::from(low)), tidy(f64::from(high))),
            false => String::new(),
        };
        Ok(format!("{}\n{}\n{}\n{surface}", self.facts.scene_name, self.size_line(), self.place_line()))
    }

    /// Adds the buildings as boxes for ns-3.
    fn add_table(&self, batch: &mut Batch, path: &Path, _: &Look) -> Result<()> {
        let (footprints, frame) = self.vectors(path)?;
        batch.add(path, &encode_table(&ns3_boxes(footprints, *frame, path)?)?)?;
        Ok(batch.add(&with_suffix(path, ".json"), pretty(&self.provenance()).as_bytes())?)
    }

    fn add(&self, batch: &mut Batch, path: &Path, format: Format, look: &Look) -> Result<()> {
        match format {
            Format::GeoTiff => Ok(batch.add(path, &self.geotiff()?)?),
            Format::AsciiGrid => self.add_ascii_grid(batch, path),
            Format::GeoJson => {
                let (footprints, frame) = self.vectors(path)?;
                let document = features::of_footprints(footprints, *frame, self.scene.grid(), self.provenance());
                Ok(batch.add(path, format!("{document}\n").as_bytes())?)
            }
            Format::Mitsuba => self.add_mitsuba(batch, path),
            _ => Ok(batch.add(path, &self.picture(format, look)?)?),
        }
    }
}

/// Converts a footprint for drawing.
fn prism_of(footprint: &Footprint, frame: Frame, local: &impl Fn([f64; 2]) -> [f64; 2]) -> CityPrism {
    let point = |[x, y, z]: &[i32; 3]| {
        let (x, y) = frame.world_from_lattice(f64::from(*x), f64::from(*y));
        let [x, y] = local([x, y]);
        [x, y, meters(*z)]
    };
    CityPrism {
        roof_triangles: roof_triangles(footprint).iter().map(|corners| corners.each_ref().map(point)).collect(),
        wall_edges: wall_edges(footprint).iter().map(|ends| ends.each_ref().map(point)).collect(),
        base_m: meters(footprint.bottom()),
        top_m: meters(footprint.top),
    }
}
