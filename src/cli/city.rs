//! `skyshed city`: makes or converts a city, and draws it.

use std::path::Path;

use super::args::CityArgs;
use super::plan::{input_paths, read_scene};
use super::{interrupt, messages};
use crate::city::{Footprint, Solids};
use crate::crs::wkt_of;
use crate::error::{Error, Result, Warning};
use crate::export::{
    Batch, CityMesh, Format, MitsubaScene, OutputRules, add_mitsuba, check_outputs, city_mesh, encode_table, ns3_boxes,
    with_suffix,
};
use crate::formats::{Bands, GeoTiffImage, TiffLayout, encode_geotiff, write_ascii_grid};
use crate::height_field::{ConvexPieces, HeightField, convex_pieces};
use crate::memory::{FIELD_BYTES_PER_CELL, check_memory};
use crate::quantity::{Frame, VOID, meters, tidy};
use crate::raster::Crs;
use crate::render::{self, CityHeights, CityModel, CityPicture, CityPrism, PictureForm, grouped};
use crate::report::{RunFacts, city_geojson};
use crate::scene::limits::limits_in_words;
use crate::words::{pretty, title_of};

const FORMATS: [Format; 10] = [
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

/// Nodata of height rasters.
const NODATA: f32 = -9999.0;

pub(super) fn run(args: &CityArgs, command: Vec<String>) -> Result<()> {
    let outputs = check_outputs(
        &args.output,
        OutputRules {
            allowed: &FORMATS,
            inputs: &input_paths(&args.scene),
            overwrite: args.out.overwrite,
            bare: false,
        },
    )?;
    args.words.refuse_without_picture(&outputs)?;
    let mut warnings: Vec<Warning> = Vec::new();
    let scene = read_scene(&args.scene, &mut warnings)?;
    let footprints = match &scene.solids {
        Solids::Vector { footprints, frame, .. } => Some((footprints.clone(), *frame)),
        Solids::Raster { .. } => None,
    };
    let crate::city::City { name, grid, solids, built_up, sources, attribution, height_gap } = scene;
    check_memory(&args.scene.scene, &grid, FIELD_BYTES_PER_CELL)?;
    let field = HeightField::build(&grid, solids, &mut warnings);
    let facts = RunFacts {
        command,
        method: None,
        scene_name: name,
        meters_per_unit: grid.meters_per_unit(),
        grid,
        sources,
        seed: built_up.map(|_| args.scene.seed),
        warnings,
        unit: None,
    };
    let limits = limits_in_words(height_gap.as_ref(), &field, &facts.warnings);
    let city = City { args, facts: &facts, field: &field, footprints: footprints.as_ref(), attribution, limits };

    interrupt::begin_writing();
    let mut batch = Batch::new(args.out.overwrite);
    let mut to_stdout = args.out.json;
    for (path, format) in &outputs {
        match format {
            Format::Stdout => to_stdout = true,
            Format::Mitsuba => city.add_mitsuba(&mut batch, path)?,
            _ => {
                for (file, bytes) in city.encode(path, *format)? {
                    interrupt::check()?;
                    batch.add(&file, &bytes)?;
                }
            }
        }
    }
    let files = batch.commit()?;
    if !args.out.quiet {
        messages::warnings(&facts.warnings);
        if !outputs.is_empty() {
            messages::note(&city.name());
        }
    }
    messages::wrote(&files, args.out.quiet);
    if to_stdout {
        return messages::answer(&pretty(&facts.provenance("skyshed/city/1", None)));
    }
    if outputs.is_empty() { messages::answer(&city.in_words()) } else { Ok(()) }
}

struct City<'a> {
    args: &'a CityArgs,
    facts: &'a RunFacts,
    field: &'a HeightField,
    footprints: Option<&'a (Vec<Footprint>, Frame)>,
    /// Whom the picture must credit, where the data say so.
    attribution: Option<String>,
    /// What limits the truth of the picture.
    limits: Option<String>,
}

impl City<'_> {
    /// What the city is called, and how many buildings it has.
    fn name(&self) -> String {
        match self.footprints {
            Some(_) => format!("{}, {} buildings", self.facts.scene_name, grouped(self.field.n_buildings() as u64)),
            None => self.facts.scene_name.clone(),
        }
    }

    /// The city in a few lines.
    fn in_words(&self) -> String {
        let surface = self.field.surface_m();
        let heights = surface.iter().copied().filter(|z| z.is_finite());
        let (low, high) = heights.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), z| (low.min(z), high.max(z)));
        let surface = match low <= high {
            true => format!("surface {} to {} m above the datum\n", tidy(f64::from(low)), tidy(f64::from(high))),
            false => String::new(),
        };
        format!("{}\n{}\n{}\n{surface}", self.facts.scene_name, self.size_line(), self.place_line())
    }

    /// How large the city is.
    fn size_line(&self) -> String {
        let grid = self.field.grid();
        let unit = grid.meters_per_unit();
        let (width, height) = ((grid.x_max() - grid.x_min()) * unit, (grid.y_max() - grid.y_min()) * unit);
        match self.footprints {
            Some(_) => format!("{} buildings on {} × {} m", self.field.n_buildings(), tidy(width), tidy(height)),
            None => format!("{} × {} cells, {} × {} m", grid.n_cols(), grid.n_rows(), tidy(width), tidy(height)),
        }
    }

    /// Where the city lies.
    fn place_line(&self) -> String {
        let grid = self.field.grid();
        let crs = grid.crs().map_or("local coordinates".to_string(), Crs::label);
        format!("South-west corner at ({}, {}), {crs}", tidy(grid.x_min()), tidy(grid.y_min()))
    }

    fn encode(&self, path: &Path, format: Format) -> Result<Vec<(std::path::PathBuf, Vec<u8>)>> {
        let provenance = self.facts.provenance("skyshed/city/1", None);
        let one = |bytes: Vec<u8>| Ok(vec![(path.to_path_buf(), bytes)]);
        let heights = || {
            let surface = self.field.surface_m();
            surface.iter().map(|z| if z.is_nan() { NODATA } else { *z }).collect::<Vec<f32>>()
        };
        match format {
            Format::GeoTiff => {
                let heights = heights();
                one(encode_geotiff(&GeoTiffImage {
                    georef: self.field.grid(),
                    bands: Bands::Float(vec![("height".into(), &heights)]),
                    nodata: Some(f64::from(NODATA)),
                    palette: None,
                    metadata: &[("SKYSHED".into(), provenance.to_string())],
                    layout: TiffLayout::Cog,
                })?)
            }
            Format::AsciiGrid => {
                let mut bytes = Vec::new();
                let values = heights();
                let mut values = values.iter().map(|z| f64::from(*z));
                write_ascii_grid(&mut bytes, self.field.grid(), f64::from(NODATA), &mut values, None)
                    .map_err(|e| Error::internal(402, format!("cannot encode {}: {e}", path.display())))?;
                let mut files = vec![(path.to_path_buf(), bytes)];
                if let Some(wkt) = self.field.grid().crs().and_then(wkt_of) {
                    files.push((path.with_extension("prj"), wkt.into_bytes()));
                }
                files.push((with_suffix(path, ".json"), pretty(&provenance).into_bytes()));
                Ok(files)
            }
            Format::GeoJson => {
                let (footprints, frame) = self.vectors(path)?;
                let document = city_geojson(footprints, *frame, self.field.grid(), &provenance);
                one(format!("{document}\n").into_bytes())
            }
            Format::Csv => {
                let (footprints, frame) = self.vectors(path)?;
                let boxes = encode_table(&ns3_boxes(footprints, *frame, path)?)?;
                Ok(vec![(path.to_path_buf(), boxes), (with_suffix(path, ".json"), pretty(&provenance).into_bytes())])
            }
            Format::Json => one(pretty(&provenance).into_bytes()),
            Format::Png | Format::Svg | Format::Pdf => {
                one(self.picture(&provenance, &self.args.words.size.form(format))?)
            }
            _ => Err(Error::internal(902, "a city format was asked for")),
        }
    }

    /// The footprints and their lattice, where there are some.
    fn vectors(&self, path: &Path) -> Result<&(Vec<Footprint>, Frame)> {
        self.footprints.ok_or_else(|| {
            Error::usage(109, format!("cannot write {}: a raster scene has no footprints", path.display()))
        })
    }

    /// Adds a scene of Mitsuba and its meshes to a batch.
    fn add_mitsuba(&self, batch: &mut Batch, path: &Path) -> Result<()> {
        let (footprints, frame) = self.vectors(path)?;
        let grid = self.field.grid();
        let mesh = CityMesh {
            footprints,
            frame: *frame,
            grid,
            ground_m: &self.ground_m(),
            meters_per_unit: grid.meters_per_unit(),
        };
        let (ground, buildings) = city_mesh(&mesh)?;
        let crs = grid.crs().map_or("local coordinates".to_string(), Crs::label);
        let origin = format!(
            "skyshed {}: meters, x east, y north, z above the datum; the origin is ({}, {}) in {crs}",
            env!("CARGO_PKG_VERSION"),
            grid.x_min(),
            grid.y_min()
        );
        let mut provenance = self.facts.provenance("skyshed/city/1", None);
        provenance["mesh"] = serde_json::json!({"origin": [grid.x_min(), grid.y_min()], "unit": "m"});
        let scene =
            MitsubaScene { ground: &ground, buildings: &buildings, origin: &origin, provenance: &pretty(&provenance) };
        Ok(add_mitsuba(batch, &scene, path)?)
    }

    fn picture(&self, provenance: &serde_json::Value, form: &PictureForm) -> Result<Vec<u8>> {
        let grid = self.field.grid();
        let unit = grid.meters_per_unit();
        let (width, height) = ((grid.x_max() - grid.x_min()) * unit, (grid.y_max() - grid.y_min()) * unit);
        // Axes count from the south-west corner: projected coordinates have too many digits to be read.
        let local = |[x, y]: [f64; 2]| [(x - grid.x_min()) * unit, (y - grid.y_min()) * unit];
        let (prisms, surface, ground);
        let model = match self.footprints {
            Some((footprints, frame)) => {
                prisms = footprints.iter().flat_map(|f| prisms_of(f, *frame, &local)).collect::<Vec<CityPrism>>();
                CityModel::Prisms(&prisms)
            }
            None => {
                surface = self.field.surface_m();
                ground = self.ground_m();
                CityModel::Heights(CityHeights {
                    n_cols: grid.n_cols(),
                    n_rows: grid.n_rows(),
                    surface_m: &surface,
                    ground_m: Some(&ground),
                })
            }
        };
        let place = format!("{}; skyshed {}", self.place_line(), env!("CARGO_PKG_VERSION"));
        let mut caption = vec![self.size_line(), place];
        caption.extend(self.limits.clone());
        caption.extend(self.args.words.credit(self.attribution.as_ref()));
        let title = self.args.words.title_or(|| title_of(&self.facts.scene_name));
        let picture =
            CityPicture { title: &title, caption: &caption, extent_m: [0.0, 0.0, width, height], model, uavs: &[] };
        let provenance = [("skyshed".to_string(), provenance.to_string())];
        let drawn = render::draw_city(&picture, form, &provenance);
        drawn.map_err(|e| Error::internal(403, format!("cannot draw the picture: {e}")))
    }

    fn ground_m(&self) -> Vec<f32> {
        let grid = self.field.grid();
        let positions = self.field.positions();
        let mut ground = Vec::with_capacity(grid.n_cells());
        for row in 0..grid.n_rows() {
            for col in 0..grid.n_cols() {
                let z = self.field.ground_at(&positions.center(row, col));
                #[expect(clippy::cast_possible_truncation, reason = "a picture needs no more")]
                ground.push(if z == VOID { f32::NAN } else { meters(z) as f32 });
            }
        }
        ground
    }
}

/// The polygons of a footprint for drawing, with their roofs cut into triangles.
fn prisms_of(footprint: &Footprint, frame: Frame, local: &impl Fn([f64; 2]) -> [f64; 2]) -> Vec<CityPrism> {
    let point = |p: &[i32; 2]| {
        let (x, y) = frame.world_from_lattice(f64::from(p[0]), f64::from(p[1]));
        local([x, y])
    };
    let fan = |ring: &Vec<[i32; 2]>| {
        let points: Vec<[f64; 2]> = ring.iter().map(point).collect();
        (2..points.len()).map(move |k| [points[0], points[k - 1], points[k]]).collect::<Vec<_>>()
    };
    let prism = |rings: &Vec<Vec<[i32; 2]>>| {
        let pieces = match convex_pieces(rings) {
            ConvexPieces::Exact(pieces) => pieces,
            ConvexPieces::Hull(hull) => vec![hull],
        };
        CityPrism {
            rings: rings.iter().map(|r| r.iter().map(point).collect()).collect(),
            roof_triangles: pieces.iter().flat_map(fan).collect(),
            base_m: meters(footprint.bottom()),
            top_m: meters(footprint.top),
        }
    };
    footprint.polygons.iter().map(prism).collect()
}
