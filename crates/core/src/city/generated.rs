//! Generated cities: buildings on a Manhattan grid, as scenes.

use super::{BuiltUp, City, DataArea, Footprint, FootprintFaults, Ground, Solids};
use crate::error::{CityError, Error, Fault, Result};
use crate::quantity::{Frame, MAX_EXTENT_UNITS, STEPS_PER_UNIT, height_steps, whole};
use crate::raster::GeoRef;

/// The largest number of buildings of one generated city.
const MOST_BUILDINGS: f64 = 1e7;

/// Memory that one building takes in a scene and its height field.
const BYTES_PER_BUILDING: f64 = 300.0;

/// A generated city: its parameters, extent, seed and grid.
#[derive(Debug, Clone, PartialEq)]
pub struct BuiltUpCity {
    /// Built-up parameters.
    pub built_up: BuiltUp,
    /// Edge length of the square city \[m\].
    pub size_m: f64,
    /// Width of the margin on all sides of the city, in which ground and buildings continue \[m\]:
    /// 0, or room for discs around places at the city's edge.
    pub margin_m: f64,
    /// Edge length of a cell of the receivers' grid \[m\].
    pub cell_m: f64,
    /// Seed of the building heights.
    pub seed: u64,
    /// Height of the ground above the datum \[m\].
    pub ground_m: f64,
}

impl BuiltUpCity {
    /// Parses the parameters of a scene word such as `itu:urban` or `itu:0.3,500,15`; `None` if it
    /// does not begin with `itu:`.
    ///
    /// # Errors
    /// Usage error if the rest is neither a known environment nor three valid numbers.
    pub fn parse_built_up(word: &str) -> Option<Result<BuiltUp>> {
        let rest = word.strip_prefix("itu:")?;
        if let Some(known) = BuiltUp::named(&rest.to_lowercase()) {
            return Some(Ok(known));
        }
        let numbers: Vec<std::result::Result<f64, _>> = rest.split(',').map(|n| n.trim().parse::<f64>()).collect();
        Some(match numbers[..] {
            [Ok(alpha), Ok(beta), Ok(gamma)] => BuiltUp::new(alpha, beta, gamma),
            _ => Err(CityError::Word { word: word.to_string(), found: rest.to_string() }.into()),
        })
    }

    /// Estimates the memory that the scene takes \[bytes\]: its buildings, and 8 for each cell of a
    /// map.
    ///
    /// Returns `None` if the city is refused anyway for its size, its buildings or its cells.
    pub fn memory(&self) -> Option<u64> {
        let size_m = self.size_m + 2.0 * self.margin_m;
        let (n_buildings, n_cells) = ((size_m / self.built_up.period()).powi(2), size_m / self.cell_m);
        let is_possible = size_m.max(n_cells) <= MAX_EXTENT_UNITS && n_buildings <= MOST_BUILDINGS;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "an estimate; saturating")]
        is_possible.then(|| (BYTES_PER_BUILDING * n_buildings + 8.0 * n_cells.powi(2)) as u64)
    }

    /// Builds the whole city. Its origin is the south-west corner of a crossroad. Buildings are cut
    /// at the edge of the city, or of its margin if it has one. A margin changes no building within
    /// the city.
    ///
    /// # Errors
    /// Usage errors for lengths not above 0 m and for a ground beyond the lattice. Limit errors for
    /// too large a size and for too many cells or buildings.
    pub fn city(&self) -> Result<City> {
        self.city_on_cells_from([0.0; 2])
    }

    /// Builds the whole city on cells shifted west and south of its origin by `shift`, in cells
    /// from 0 to 1.
    ///
    /// Without a shift, walls lie at the same places of the cells in every city. Shares of cells
    /// over many cities are unbiased if each city draws its own shift.
    ///
    /// # Errors
    /// As [`BuiltUpCity::city`].
    pub fn city_on_cells_from(&self, shift: [f64; 2]) -> Result<City> {
        for (length, found) in [("size", self.size_m), ("cell size", self.cell_m)] {
            if !(found > 0.0 && found.is_finite()) {
                return Err(CityError::Length { length, found }.into());
            }
        }
        let n_margin = whole(self.margin_m / self.cell_m).ceil();
        let margin_m = n_margin * self.cell_m;
        let size_m = self.size_m + 2.0 * margin_m;
        if size_m > MAX_EXTENT_UNITS {
            return Err(CityError::Size { size_m: self.size_m, whole_m: size_m }.into());
        }
        let one_more = if shift.iter().any(|share| *share > 0.0) { 1.0 } else { 0.0 };
        let n_cells = whole(self.size_m / self.cell_m).ceil().max(1.0) + 2.0 * n_margin + one_more;
        if n_cells > MAX_EXTENT_UNITS {
            return Err(CityError::Cells { found: n_cells }.into());
        }
        let n_buildings = (size_m / self.built_up.period()).powi(2);
        if n_buildings > MOST_BUILDINGS {
            return Err(CityError::Buildings { found: n_buildings, most: MOST_BUILDINGS }.into());
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "1 ≤ n ≤ 65536 by the checks above"
        )]
        let n = n_cells as usize;
        let extent = self.cell_m * n_cells;
        // `-margin_m` would write −0 into files.
        let [west, south] = shift.map(|share| 0.0 - margin_m - share * self.cell_m);
        let grid = GeoRef::new((west, extent + south), (self.cell_m, self.cell_m), (n, n), None)
            .ok_or(Error::Fault(Fault::CityGrid))?;
        let ground = height_steps(self.ground_m).ok_or(CityError::Ground { found: self.ground_m })?;
        Ok(City {
            name: format!("a generated city ({}; seed {})", self.built_up, self.seed),
            grid,
            solids: Solids::Vector {
                footprints: self.footprints(ground, margin_m),
                frame: Frame { x_origin: 0.0, y_origin: 0.0, unit_x: 1.0, unit_y: 1.0 },
                ground: Ground::Flat(ground),
                faults: FootprintFaults::default(),
                data_area: DataArea::All,
            },
            built_up: Some(self.built_up),
            sources: Vec::new(),
            attribution: None,
            heights: None,
        })
    }

    /// Returns the buildings row by row from the south-west, cut at the edge.
    fn footprints(&self, ground: i32, margin_m: f64) -> Vec<Footprint> {
        let (street, period) = (self.built_up.street_width(), self.built_up.period());
        #[expect(clippy::cast_possible_truncation, reason = "at most 65536 m in steps of 1/1024 m")]
        let edge = |v: f64| (v * f64::from(STEPS_PER_UNIT)).round() as i64;
        let (low, high) = (edge(-margin_m), edge(self.size_m + margin_m));
        #[expect(clippy::cast_possible_truncation, reason = "between the edges, which are within ±2^26")]
        let cut = |v: i64| v.clamp(low, high) as i32;
        #[expect(clippy::cast_possible_truncation, reason = "a city has far fewer than 2^31 columns")]
        let first = -((margin_m / period).ceil() as i32);
        let spans: Vec<(i32, [i32; 2])> = (first..)
            .take_while(|k| f64::from(*k) * period + street < self.size_m + margin_m)
            .map(|k| (k, self.built_up.building_span(k).map(cut)))
            .filter(|(_, [a, b])| a < b)
            .collect();
        let mut heights = self.built_up.heights(self.seed);
        let mut footprints = Vec::with_capacity(spans.len() * spans.len());
        for &(j, [y0, y1]) in &spans {
            for &(i, [x0, x1]) in &spans {
                let height = heights.steps(i, j);
                footprints.push(Footprint {
                    id: format!("{i},{j}"),
                    polygons: vec![vec![vec![[x0, y0], [x1, y0], [x1, y1], [x0, y1]]]],
                    top: ground + height,
                    roof: Vec::new(),
                    base: Some(ground),
                    height_error: None,
                    part_of: None,
                });
            }
        }
        footprints
    }
}
