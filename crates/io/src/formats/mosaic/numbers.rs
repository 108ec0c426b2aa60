//! Conversion of stored numbers of tiles to numbers of a mosaic.

use crate::formats::sample::Sample;
use crate::formats::voids::{Stored, is_nodata};

impl Sample {
    /// Returns the type of a virtual raster's band by GDAL's name; `None` for complex and unknown
    /// ones.
    pub(super) fn of_gdal(name: &str) -> Option<Sample> {
        Some(match name {
            "Byte" | "UInt8" => Sample::U8,
            "UInt16" => Sample::U16,
            "UInt32" => Sample::U32,
            "UInt64" => Sample::U64,
            "Int8" => Sample::I8,
            "Int16" => Sample::I16,
            "Int32" => Sample::I32,
            "Int64" => Sample::I64,
            "Float32" => Sample::F32,
            "Float64" => Sample::F64,
            _ => return None,
        })
    }

    /// Returns a number as the type can hold it: integers are rounded, halves away from zero, and
    /// clamped; NaN becomes 0.
    #[expect(clippy::cast_possible_truncation, reason = "rounding to 32 bits is the purpose")]
    pub(super) fn rounded(self, number: f64) -> f64 {
        let (low, high) = match self {
            Sample::F64 => return number,
            // No band of a virtual raster holds bits or 16-bit floats, see [`Sample::of_gdal`].
            Sample::F16 | Sample::F32 => return f64::from(number as f32),
            Sample::Bit => (0.0, 1.0),
            Sample::U8 => (0.0, f64::from(u8::MAX)),
            Sample::U16 => (0.0, f64::from(u16::MAX)),
            Sample::U32 => (0.0, f64::from(u32::MAX)),
            Sample::U64 => (0.0, u64::MAX as f64),
            Sample::I8 => (f64::from(i8::MIN), f64::from(i8::MAX)),
            Sample::I16 => (f64::from(i16::MIN), f64::from(i16::MAX)),
            Sample::I32 => (f64::from(i32::MIN), f64::from(i32::MAX)),
            Sample::I64 => (i64::MIN as f64, i64::MAX as f64),
        };
        if number.is_nan() { 0.0 } else { number.round().clamp(low, high) }
    }

    /// Returns the type that GDAL scales such numbers in: 32-bit floats where these hold them all.
    fn scaled_in(self) -> Sample {
        match self {
            Sample::U32 | Sample::U64 | Sample::I32 | Sample::I64 | Sample::F64 => Sample::F64,
            _ => Sample::F32,
        }
    }
}

/// Meaning of the stored numbers of a tile.
#[derive(Debug, Clone, Copy)]
pub(in crate::formats) struct TileNumbers {
    /// Band of the numbers, counted from 0.
    pub(in crate::formats) band: usize,
    /// Declared nodata value.
    pub(in crate::formats) nodata: Option<f64>,
    /// Factor and summand that turn the numbers of the band into heights.
    pub(in crate::formats) scaling: (f64, f64),
}

/// Cells of a tile that count, and their values in the mosaic.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Rule {
    /// All cells, as the tile stores them: a `SimpleSource`.
    Copied(Sample),
    /// A `ComplexSource`: cells that are not `nodata`, nor hidden by the tile's mask if that is
    /// used. Numbers are multiplied by `ratio`, then `offset` is added.
    Scaled { to: Sample, ratio: f64, offset: f64, nodata: Option<f64>, uses_mask: bool },
    /// Cells that hold a height, as that height in the tile's unit: a tile of a folder.
    Heights,
}

impl Rule {
    /// Returns the mosaic's number for a cell of a tile; `None` keeps the number of earlier tiles.
    #[inline]
    pub(super) fn number(&self, tile: TileNumbers, stored: Stored) -> Option<f64> {
        // GDAL reads nodata, or 0, where a file stores nothing.
        let as_read = || match stored {
            Stored::Number(number) | Stored::Hidden(number) => number,
            Stored::Nothing => tile.nodata.unwrap_or(0.0),
        };
        match *self {
            Rule::Copied(to) => Some(to.rounded(as_read())),
            Rule::Scaled { uses_mask: true, .. } if matches!(stored, Stored::Hidden(_)) => None,
            Rule::Scaled { to, ratio, offset, nodata, .. } => {
                let working = to.scaled_in();
                let number = working.rounded(as_read());
                let nodata = nodata.map(|nodata| working.rounded(nodata));
                (!is_nodata(nodata, number)).then(|| to.rounded(working.rounded(number * ratio + offset)))
            }
            Rule::Heights => match stored {
                Stored::Number(number) if number.is_finite() && !is_nodata(tile.nodata, number) => {
                    Some(number * tile.scaling.0 + tile.scaling.1)
                }
                _ => None,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_rounded_and_clamped_as_their_type_holds_them() {
        for (name, number, wanted) in [
            ("Byte", 254.5, 255.0),
            ("Byte", -3.0, 0.0),
            ("Byte", 300.0, 255.0),
            ("Int16", -2.5, -3.0),
            ("Int16", 40_000.0, 32_767.0),
            ("UInt16", f64::NAN, 0.0),
            ("Int32", 2.4, 2.0),
            ("Float32", 0.1, f64::from(0.1_f32)),
            ("Float64", 0.1, 0.1),
        ] {
            let found = Sample::of_gdal(name).map(|to| to.rounded(number));
            assert_eq!(found.map(f64::to_bits), Some(f64::to_bits(wanted)), "{name} {number}");
        }
        assert!(Sample::F32.rounded(f64::NAN).is_nan());
        // No band of a virtual raster has these types.
        for name in ["CFloat32", "Float16", "Bit", ""] {
            assert_eq!(Sample::of_gdal(name), None);
        }
    }
}
