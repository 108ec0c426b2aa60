//! Reference system of a point cloud, and the unit of its heights.

use super::file::Record;
use crate::crs::{self, VerticalCrs};
use crate::error::{OddFile, OddRaster, Oddity, Warning};
use crate::formats::{GeoKeySystems, systems_of_geo_keys};
use crate::input::Input;
use crate::raster::{Crs, CrsKind};

/// Ids of the records of a reference system: its text, and the three tables of GeoKeys.
const TEXT: u16 = 2112;
const GEO_KEYS: [u16; 3] = [34735, 34736, 34737];

/// Reference systems of a point cloud.
#[derive(Debug, Clone, Default)]
pub(super) struct Systems {
    /// Horizontal system.
    pub(super) crs: Option<Crs>,
    /// Vertical system.
    pub(super) vertical: Option<VerticalCrs>,
    /// Length of the unit of heights, where the file names it \[m\].
    meters_per_height_unit: Option<f64>,
    /// Oddities of the horizontal system.
    odd: Vec<Oddity>,
}

/// Returns the systems that the records of a file name. A text counts before GeoKeys.
pub(super) fn systems_of(input: &Input, records: &[Record]) -> Systems {
    let data = |id: u16| {
        let is_it = |record: &&Record| record.id == id && record.user.eq_ignore_ascii_case("LASF_Projection");
        records.iter().find(is_it).map(|record| record.data.as_slice())
    };
    let mut odd = Vec::new();
    let mut tell = |of_crs: OddRaster| odd.push(Oddity::new(input, of_crs));
    let text = data(TEXT).map(|bytes| String::from_utf8_lossy(bytes).trim_end_matches('\0').trim().to_string());
    if let Some(text) = text.filter(|text| !text.is_empty()) {
        let crs = crs::parse(&text).map_err(|error| tell(OddRaster::CrsIgnored(error.to_string()))).ok();
        let vertical = VerticalCrs::in_text(&text);
        let meters_per_height_unit = vertical.as_ref().and_then(VerticalCrs::meters_per_unit);
        return Systems { crs, vertical, meters_per_height_unit, odd };
    }
    let [keys, doubles, texts] = GEO_KEYS.map(|id| data(id).unwrap_or_default());
    if keys.is_empty() {
        return Systems::default();
    }
    let keys: Vec<u16> = keys.chunks_exact(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect();
    let number = |bytes: &[u8]| f64::from_le_bytes(std::array::from_fn(|k| bytes[k]));
    let doubles: Vec<f64> = doubles.chunks_exact(8).map(number).collect();
    let GeoKeySystems { crs, vertical, meters_per_height_unit } =
        systems_of_geo_keys((&keys, &doubles, texts), &mut tell);
    Systems { crs, vertical, meters_per_height_unit, odd }
}

impl Systems {
    /// Returns the system to use, `crs` if that is set, with warnings where the file names none or
    /// one that is odd.
    pub(super) fn used(&self, input: &Input, crs: Option<&Crs>, warnings: &mut Vec<Warning>) -> Option<Crs> {
        if let Some(crs) = crs {
            return Some(crs.clone());
        }
        warnings.extend(self.odd.iter().cloned().map(Warning::from));
        if self.crs.is_none() && self.odd.is_empty() {
            warnings.push(Warning::of(input, OddFile::NoCrs));
        }
        self.crs.clone()
    }

    /// Returns the length of the unit of heights \[m\], with a warning if that is not 1 m. Where
    /// the file names none, heights are in the unit of the coordinates.
    pub(super) fn height_unit(&self, input: &Input, crs: Option<&Crs>, warnings: &mut Vec<Warning>) -> f64 {
        let of_crs = match crs.map(Crs::kind) {
            Some(CrsKind::Projected { meters_per_unit }) => meters_per_unit,
            _ => 1.0,
        };
        let unit = self.meters_per_height_unit.filter(|unit| unit.is_finite() && *unit > 0.0);
        let odd = match unit {
            Some(meters) if (meters - 1.0).abs() > 1e-9 => Some(Oddity::new(input, OddRaster::Unit(meters)).into()),
            None if (of_crs - 1.0).abs() > 1e-9 => Some(Warning::of(input, OddFile::HeightUnit(of_crs))),
            _ => None,
        };
        warnings.extend(odd);
        unit.unwrap_or(of_crs)
    }
}
