//! What becomes of a stored number on its way from a tile into a mosaic.

use super::tile::Tile;
use crate::raster::voids::{Stored, is_nodata};

/// The type of the numbers of a virtual raster's band.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum NumberType {
    U8,
    U16,
    U32,
    U64,
    I8,
    I16,
    I32,
    I64,
    F32,
    F64,
}

impl NumberType {
    /// The type with GDAL's name; `None` for complex and unknown ones.
    pub(super) fn of_gdal(name: &str) -> Option<NumberType> {
        Some(match name {
            "Byte" | "UInt8" => NumberType::U8,
            "UInt16" => NumberType::U16,
            "UInt32" => NumberType::U32,
            "UInt64" => NumberType::U64,
            "Int8" => NumberType::I8,
            "Int16" => NumberType::I16,
            "Int32" => NumberType::I32,
            "Int64" => NumberType::I64,
            "Float32" => NumberType::F32,
            "Float64" => NumberType::F64,
            _ => return None,
        })
    }

    /// The name that numpy uses.
    pub(super) fn name(self) -> &'static str {
        match self {
            NumberType::U8 => "uint8",
            NumberType::U16 => "uint16",
            NumberType::U32 => "uint32",
            NumberType::U64 => "uint64",
            NumberType::I8 => "int8",
            NumberType::I16 => "int16",
            NumberType::I32 => "int32",
            NumberType::I64 => "int64",
            NumberType::F32 => "float32",
            NumberType::F64 => "float64",
        }
    }

    /// A number as the type can hold it: integers are rounded, halves away from zero, and clamped; NaN becomes 0.
    #[expect(clippy::cast_possible_truncation, reason = "rounding to 32 bits is the purpose")]
    pub(super) fn rounded(self, number: f64) -> f64 {
        let (low, high) = match self {
            NumberType::F64 => return number,
            NumberType::F32 => return f64::from(number as f32),
            NumberType::U8 => (0.0, f64::from(u8::MAX)),
            NumberType::U16 => (0.0, f64::from(u16::MAX)),
            NumberType::U32 => (0.0, f64::from(u32::MAX)),
            NumberType::U64 => (0.0, u64::MAX as f64),
            NumberType::I8 => (f64::from(i8::MIN), f64::from(i8::MAX)),
            NumberType::I16 => (f64::from(i16::MIN), f64::from(i16::MAX)),
            NumberType::I32 => (f64::from(i32::MIN), f64::from(i32::MAX)),
            NumberType::I64 => (i64::MIN as f64, i64::MAX as f64),
        };
        if number.is_nan() { 0.0 } else { number.round().clamp(low, high) }
    }

    /// The type that GDAL scales such numbers in: 32-bit floats where these hold them all.
    fn scaled_in(self) -> NumberType {
        match self {
            NumberType::U32 | NumberType::U64 | NumberType::I32 | NumberType::I64 | NumberType::F64 => NumberType::F64,
            _ => NumberType::F32,
        }
    }
}

/// Which cells of a tile count, and as what.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Rule {
    /// All, as the tile stores them: a `SimpleSource`.
    Copied(NumberType),
    /// A `ComplexSource`: those that are not `nodata` (nor hidden by the tile's mask, if that is used), multiplied by
    /// `ratio`, then `offset` added.
    Scaled { to: NumberType, ratio: f64, offset: f64, nodata: Option<f64>, uses_mask: bool },
    /// Those that hold a height, as that height in the tile's unit: a tile of a folder.
    Heights,
}

impl Rule {
    /// The mosaic's number for a cell of a tile; `None` leaves what earlier tiles put there.
    #[inline]
    pub(super) fn number(&self, tile: &Tile, stored: Stored) -> Option<f64> {
        // What GDAL reads where a file stores nothing.
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
            let found = NumberType::of_gdal(name).map(|to| to.rounded(number));
            assert_eq!(found.map(f64::to_bits), Some(f64::to_bits(wanted)), "{name} {number}");
        }
        assert!(NumberType::F32.rounded(f64::NAN).is_nan());
        assert_eq!(NumberType::of_gdal("CFloat32"), None);
    }
}
