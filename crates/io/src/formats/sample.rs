//! Type of the numbers that a raster file stores, one for each cell.

/// Type of one sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sample {
    /// One bit, only in masks.
    Bit,
    U8,
    U16,
    U32,
    U64,
    I8,
    I16,
    I32,
    I64,
    F16,
    F32,
    F64,
}

impl Sample {
    /// Returns the bits per sample.
    pub(super) fn bits(self) -> u16 {
        match self {
            Sample::Bit => 1,
            Sample::U8 | Sample::I8 => 8,
            Sample::U16 | Sample::I16 | Sample::F16 => 16,
            Sample::U32 | Sample::I32 | Sample::F32 => 32,
            Sample::U64 | Sample::I64 | Sample::F64 => 64,
        }
    }

    /// Returns the name that GDAL and numpy use.
    pub(super) fn name(self) -> &'static str {
        match self {
            Sample::Bit => "bit",
            Sample::U8 => "uint8",
            Sample::U16 => "uint16",
            Sample::U32 => "uint32",
            Sample::U64 => "uint64",
            Sample::I8 => "int8",
            Sample::I16 => "int16",
            Sample::I32 => "int32",
            Sample::I64 => "int64",
            Sample::F16 => "float16",
            Sample::F32 => "float32",
            Sample::F64 => "float64",
        }
    }

    /// Returns `true` for samples that may have fractions.
    pub(super) fn is_float(self) -> bool {
        matches!(self, Sample::F16 | Sample::F32 | Sample::F64)
    }
}
