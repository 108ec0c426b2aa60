//! UAV sites, at which UAVs hover, from CSV or GeoJSON.

use serde_json::Value;

use super::moment::up_time;
use super::source::is_geojson;
use super::table::{BadRows, BadRowsTold, NUMBER, Position, Row, RowFault, Table, height, readable};
use super::vector::geojson::{features, named_crs, read_document};
use crate::city::{Antenna, GivenSite, Site};
use crate::crs;
use crate::crs::transform;
use crate::error::{Error, PlacesIn, ReadFault, Result, Wanted};
use crate::input::Input;
use crate::quantity::{Height, parse_number};
use crate::raster::{Crs, CrsKind, GeoRef};

/// Reads sites from a CSV table or GeoJSON points. `-` is standard input, which is GeoJSON if it
/// begins with a brace.
///
/// | CSV column | content |
/// |---|---|
/// | `x,y` or `lon,lat` | position in the scene's CRS, or in degrees |
/// | `h`, `height`, `h_m` or `height_m` | height such as `120`, `30roof`, `400ft` |
/// | `height_amsl_m`, without these | height above the datum \[m\], as this program writes it |
/// | `h_above`, optional | `ground`, `roof` or `amsl` |
/// | `id`, `site` or `name`, optional | name of the site |
/// | `min_radius`, optional | least range of the antenna \[m\] |
/// | `sector`, `elevation`, optional | two angles of the antenna, as `90,180` \[deg\] |
/// | `beam`, optional | beam of the antenna \[deg\] |
/// | `slant_range`, optional | largest distance in space \[m\] |
/// | `from`, `to`, optional | time in which it is up: ISO 8601, or minutes |
///
/// GeoJSON points are longitude and latitude (RFC 7946) unless a `crs` member names another system.
/// Their properties have the names of the columns; two angles may also be `[90, 180]`. The height
/// may also be a third coordinate other than 0, which is above the datum. Sites without an id are numbered from `first_number` by their row.
///
/// # Errors
/// File errors naming the lines or features; site errors if positions cannot be brought into the
/// scene's CRS.
pub fn read_sites(
    input: impl Into<Input>,
    grid: &GeoRef,
    first_number: usize,
    bad: BadRows<'_>,
) -> Result<Vec<GivenSite>> {
    let input = &input.into();
    let sites = match is_geojson(input)? {
        true => read_geojson(input, grid, first_number, bad)?,
        false => read_csv(input, grid, first_number, bad)?,
    };
    if sites.is_empty() {
        return Err(Error::read(input, ReadFault::Nothing(Wanted::Sites)));
    }
    Ok(sites)
}

fn read_csv(input: &Input, grid: &GeoRef, first_number: usize, bad: BadRows<'_>) -> Result<Vec<GivenSite>> {
    let refuse = |found: String| bad_rows(input, PlacesIn::SiteTable, found, false);
    let table = Table::parse(&input.text("a table as UTF-8 text")?).map_err(refuse)?;
    let position = table.position().map_err(refuse)?;
    let (h_column, amsl_column) = (table.column(&HEIGHT_COLUMNS), table.column(&[AMSL_COLUMN]));
    if h_column.or(amsl_column).is_none() {
        return Err(refuse(format!("line 1: found columns `{}`, wanted a height", table.found())));
    }
    let (above_column, id_column) = (table.column(&["h_above"]), table.column(&["id", "site", "name"]));
    let antenna_columns = OF_ANTENNA.map(|name| table.column(&[name]));
    let time_columns = OF_TIME.map(|name| table.column(&[name]));
    let places = RowPlaces::of(input, (&table, position), grid.crs())?;
    let is_degrees = places.position.is_degrees;

    let rows = table.rows(|k, row| {
        table.check_complete(row)?;
        let height = match (h_column, amsl_column) {
            (None, Some(column)) => height(row.field(column), Some("amsl")).map_err(RowFault::Text)?,
            (column, _) => table.height(row, column.unwrap_or_default(), above_column)?,
        };
        let RowPlace { given: xy, place: (x, y) } = places.of_row(row)?;
        refuse_swapped((xy, (x, y)), (places.from(), grid))?;
        let id = id_column.map(|column| row.field(column)).filter(|id| !id.is_empty());
        let id = id.map_or_else(|| (first_number + k).to_string(), str::to_string);
        let field = |k: usize| Some(row.field(antenna_columns[k]?)).filter(|text| !text.is_empty()).map(str::to_string);
        let [from, to] = time_columns.map(|column| column.map(|column| row.field(column)));
        let up = up_time(from, to).map_err(RowFault::Text)?;
        let site = Site { antenna: antenna(field)?, up, ..Site::new(id, (x, y), height) };
        Ok(GivenSite { site, lonlat: is_degrees.then_some([xy.0, xy.1]) })
    });
    readable(input, rows, bad, |told| refused(input, told, PlacesIn::SiteTable, is_degrees))
}

fn read_geojson(input: &Input, grid: &GeoRef, first_number: usize, bad: BadRows<'_>) -> Result<Vec<GivenSite>> {
    let document = read_document(input)?;
    let crs = named_crs(input, &document).map_err(Error::beside_scene)?.map_or_else(|| crs::from_epsg(4326), Ok)?;
    let mut rows = Vec::new();
    for (number, feature) in features(input, document)?.iter().enumerate() {
        let from = position_of(&feature["geometry"]).ok().and_then(|xy| degrees_or_named(&crs, xy));
        check_placeable(input, from, grid.crs())?;
        let site = site_of(feature, (&crs, grid), first_number + number);
        rows.push((format!("feature {}", number + 1), site));
    }
    readable(input, rows, bad, |told| refused(input, told, PlacesIn::SiteFeatures, true))
}

/// Returns the coordinates of a point.
fn position_of(geometry: &Value) -> std::result::Result<(f64, f64), RowFault> {
    let coordinate = |k: usize| geometry["coordinates"].get(k).and_then(Value::as_f64);
    let xy = coordinate(0).zip(coordinate(1)).filter(|_| geometry["type"] == "Point");
    xy.ok_or_else(|| RowFault::Text("found no Point with two numbers".into()))
}

/// Returns the system of a position; `None` if it is said to be in degrees, but lies far outside of
/// their range.
pub(super) fn degrees_or_named(crs: &Crs, (x, y): (f64, f64)) -> Option<&Crs> {
    let is_named_projected = !matches!(crs.kind(), CrsKind::Geographic);
    (is_named_projected || (x.abs() <= 360.0 && y.abs() <= 90.0)).then_some(crs)
}

/// Reads the site of a feature.
fn site_of(feature: &Value, (crs, grid): (&Crs, &GeoRef), number: usize) -> std::result::Result<GivenSite, RowFault> {
    let given = position_of(&feature["geometry"])?;
    let text = |v: &Value| v.as_str().map_or_else(|| v.to_string(), str::to_string);
    let property = |names: &[&str]| {
        names.iter().find_map(|n| feature.get("properties")?.get(n)).filter(|v| !v.is_null()).map(text)
    };
    let above = property(&["h_above"]);
    let height = match (property(&HEIGHT_COLUMNS), property(&[AMSL_COLUMN])) {
        (Some(h), _) => height(&h, above.as_deref()),
        (None, Some(h)) => height(&h, Some("amsl")),
        (None, None) => match feature["geometry"]["coordinates"].get(2).and_then(Value::as_f64) {
            // Programs write a third coordinate of 0 where there is no height.
            Some(z) if z != 0.0 => Ok(Height::AboveDatum(z)),
            _ => Err("found no height `h`".into()),
        },
    };
    let height = height.map_err(RowFault::Text)?;
    let id = property(&["id", "site", "name"]).or_else(|| feature.get("id").map(text));
    let from = degrees_or_named(crs, given);
    let (x, y) = in_scene(given, from, grid.crs())?;
    refuse_swapped((given, (x, y)), (from, grid))?;
    let id = id.unwrap_or_else(|| number.to_string());
    let is_degrees = from.is_some_and(|crs| matches!(crs.kind(), CrsKind::Geographic));
    let of_antenna = |k: usize| property(&[OF_ANTENNA[k]]).map(|text| text.replace(['[', ']'], ""));
    let [from, to] = OF_TIME.map(|name| property(&[name]));
    let up = up_time(from.as_deref(), to.as_deref()).map_err(RowFault::Text)?;
    let site = Site { antenna: antenna(of_antenna)?, up, ..Site::new(id, (x, y), height) };
    Ok(GivenSite { site, lonlat: is_degrees.then_some([given.0, given.1]) })
}

/// Names of the column or property with the height of a place.
pub(super) const HEIGHT_COLUMNS: [&str; 4] = ["h", "h_m", "height", "height_m"];

/// Name of the column or property with a height above the datum \[m\], as this program writes it.
const AMSL_COLUMN: &str = "height_amsl_m";

/// Columns of an antenna.
const OF_ANTENNA: [&str; 5] = ["min_radius", "sector", "elevation", "beam", "slant_range"];

/// Columns of the time in which a UAV is up.
const OF_TIME: [&str; 2] = ["from", "to"];

/// Reads an antenna from the texts of [`OF_ANTENNA`], as far as there are any.
fn antenna(text: impl Fn(usize) -> Option<String>) -> std::result::Result<Antenna, RowFault> {
    let wrong = |k: usize, found: String| RowFault::Text(format!("`{}`: {found}", OF_ANTENNA[k]));
    let number = |k: usize| {
        text(k)
            .map(|text| parse_number(&text).map_err(|found| wrong(k, format!("{found}, wanted a number"))))
            .transpose()
    };
    let pair = |k: usize| {
        let read = |text: String| {
            let parts = text.split([',', ';', ' ']).filter(|part| !part.is_empty());
            let numbers = parts.map(parse_number).collect::<std::result::Result<Vec<f64>, String>>();
            let pair = numbers.map(<[f64; 2]>::try_from);
            match pair {
                Ok(Ok(pair)) => Ok(pair),
                Ok(Err(_)) => Err(wrong(k, format!("found `{text}`, wanted two angles such as 90,180"))),
                Err(found) => Err(wrong(k, format!("{found}, wanted two angles such as 90,180"))),
            }
        };
        text(k).map(read).transpose()
    };
    let antenna = Antenna {
        min_radius_m: number(0)?,
        sector_deg: pair(1)?,
        elevation_deg: pair(2)?,
        beam_deg: number(3)?,
        slant_range_m: number(4)?,
    };
    antenna.checked().map_err(|fault| RowFault::Text(fault.to_string()))
}

/// Position of a row: as given, and in the scene's system.
pub(super) struct RowPlace {
    given: (f64, f64),
    pub(super) place: (f64, f64),
}

/// Places of the rows of a table.
pub(super) struct RowPlaces<'a> {
    table: &'a Table,
    pub(super) position: Position,
    /// System of the degrees, if there are any.
    wgs84: Option<Crs>,
    scene_crs: Option<&'a Crs>,
}

/// Largest distance between two positions of one row that count as one place \[m\]: degrees with four
/// decimals are rounded by less.
const MOST_APART_M: f64 = 10.0;

impl<'a> RowPlaces<'a> {
    /// Checks that positions in these columns can be placed in a scene.
    ///
    /// # Errors
    /// E310 for degrees where the scene names no reference system.
    pub(super) fn of(
        input: &Input,
        (table, position): (&'a Table, Position),
        scene_crs: Option<&'a Crs>,
    ) -> Result<RowPlaces<'a>> {
        let has_degrees = position.is_degrees || position.degrees_too.is_some();
        let wgs84 = if has_degrees { Some(crs::from_epsg(4326)?) } else { None };
        let places = RowPlaces { table, position, wgs84, scene_crs };
        check_placeable(input, places.from(), scene_crs)?;
        Ok(places)
    }

    /// Returns the system of the positions; `None` for that of the scene.
    fn from(&self) -> Option<&Crs> {
        self.wgs84.as_ref().filter(|_| self.position.is_degrees)
    }

    /// Returns the position of a row as given, and in the scene's system.
    ///
    /// # Errors
    /// A position that is none, or two of them that are not one place.
    pub(super) fn of_row(&self, row: &Row) -> std::result::Result<RowPlace, RowFault> {
        let numbers = |(a, b): (usize, usize)| {
            Ok::<_, RowFault>((self.table.number(row, a, NUMBER)?, self.table.number(row, b, NUMBER)?))
        };
        let given = numbers(self.position.columns)?;
        let place = in_scene(given, self.from(), self.scene_crs)?;
        let is_filled = |(lon, lat): &(usize, usize)| !row.field(*lon).is_empty() && !row.field(*lat).is_empty();
        let Some(CrsKind::Projected { meters_per_unit }) = self.scene_crs.map(Crs::kind) else {
            return Ok(RowPlace { given, place });
        };
        if let Some(degrees) = self.position.degrees_too.filter(is_filled) {
            let other = in_scene(numbers(degrees)?, self.wgs84.as_ref(), self.scene_crs)?;
            let apart_m = (other.0 - place.0).hypot(other.1 - place.1) * meters_per_unit;
            if apart_m > MOST_APART_M {
                let text =
                    format!("its position in the scene and its degrees are {apart_m:.0} m apart, wanted one place");
                return Err(RowFault::Text(text));
            }
        }
        Ok(RowPlace { given, place })
    }
}

/// Refuses longitude and latitude that lie outside the scene, but inside when they are exchanged.
fn refuse_swapped(
    (given, found): ((f64, f64), (f64, f64)),
    (from, grid): (Option<&Crs>, &GeoRef),
) -> std::result::Result<(), RowFault> {
    let is_inside =
        |(x, y): (f64, f64)| x >= grid.x_min() && x <= grid.x_max() && y >= grid.y_min() && y <= grid.y_max();
    let (Some(from), Some(to)) = (from.filter(|f| matches!(f.kind(), CrsKind::Geographic)), grid.crs()) else {
        return Ok(());
    };
    if is_inside(found) || !transform(from, to, (given.1, given.0)).is_ok_and(is_inside) {
        return Ok(());
    }
    let (lon, lat) = given;
    Err(RowFault::Place(format!(
        "longitude {lon} and latitude {lat} are far from the scene; exchanged, they lie in it"
    )))
}

/// Refuses positions in another system where the scene names none.
pub(super) fn check_placeable(input: &Input, from: Option<&Crs>, scene_crs: Option<&Crs>) -> Result<()> {
    match (from, scene_crs) {
        (Some(from), None) => Err(Error::read(input, ReadFault::NoSceneCrs(from.label()))),
        _ => Ok(()),
    }
}

/// Returns the error of rows or features that cannot be read.
pub(super) fn bad_rows(input: &Input, of: PlacesIn, what: String, some_are_good: bool) -> Error {
    Error::read(input, ReadFault::Rows { what, of, some_are_good })
}

/// Returns the error of rows or features that cannot be read, or cannot be placed.
pub(super) fn refused(input: &Input, told: BadRowsTold, of: PlacesIn, is_degrees: bool) -> Error {
    let BadRowsTold { first, text: what, some_are_good } = told;
    match first {
        RowFault::Text(_) => bad_rows(input, of, what, some_are_good),
        RowFault::Place(_) => Error::read(input, ReadFault::Misplaced { what, is_degrees, some_are_good }),
        RowFault::NoWay(_) => Error::read(input, ReadFault::Misplaced { what, is_degrees: false, some_are_good }),
    }
}

/// Returns a position in the scene's CRS; `from` is `None` where it already is in that.
pub(super) fn in_scene(
    xy: (f64, f64),
    from: Option<&Crs>,
    scene_crs: Option<&Crs>,
) -> std::result::Result<(f64, f64), RowFault> {
    let (Some(from), Some(to)) = (from, scene_crs) else { return Ok(xy) };
    if from.epsg().is_some() && from.epsg() == to.epsg() {
        return Ok(xy);
    }
    transform(from, to, xy).map_err(|e| {
        let fault = if crs::is_projection_known(to) { RowFault::Place } else { RowFault::NoWay };
        fault(format!("{e} ({} to {})", from.label(), to.label()))
    })
}
