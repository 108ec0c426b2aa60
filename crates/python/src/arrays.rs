//! Heights in arrays of Python, of any layout and byte order, as rows of numbers.

use std::sync::atomic::{AtomicBool, Ordering};

use numpy::ndarray::ArrayView2;
use numpy::{PyArray2, PyArrayMethods, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

use crate::errors::Failure;

/// Heights of cells, lent.
pub(crate) struct Heights<'py> {
    /// Rows and columns.
    pub(crate) shape: (usize, usize),
    array: Array<'py>,
}

/// An array of one of the kinds of numbers.
enum Array<'py> {
    F64(PyReadonlyArray2<'py, f64>),
    F32(PyReadonlyArray2<'py, f32>),
    I8(PyReadonlyArray2<'py, i8>),
    I16(PyReadonlyArray2<'py, i16>),
    I32(PyReadonlyArray2<'py, i32>),
    I64(PyReadonlyArray2<'py, i64>),
    U8(PyReadonlyArray2<'py, u8>),
    U16(PyReadonlyArray2<'py, u16>),
    U32(PyReadonlyArray2<'py, u32>),
    U64(PyReadonlyArray2<'py, u64>),
}

/// A number of an array.
trait Number: Copy + Sync {
    /// Read as the machine does, or with its bytes turned around.
    fn read(self, is_swapped: bool) -> f64;
}

macro_rules! integers {
    ($($kind:ty),*) => {$(
        impl Number for $kind {
            #[inline]
            #[expect(clippy::allow_attributes, reason = "of some kinds the conversion is exact")]
            #[allow(clippy::cast_precision_loss, clippy::cast_lossless, reason = "heights beyond the lattice are refused")]
            fn read(self, is_swapped: bool) -> f64 {
                (if is_swapped { self.swap_bytes() } else { self }) as f64
            }
        }
    )*};
}
integers!(i8, i16, i32, i64, u8, u16, u32, u64);

impl Number for f64 {
    #[inline]
    fn read(self, is_swapped: bool) -> f64 {
        if is_swapped { f64::from_bits(self.to_bits().swap_bytes()) } else { self }
    }
}

impl Number for f32 {
    #[inline]
    fn read(self, is_swapped: bool) -> f64 {
        f64::from(if is_swapped { f32::from_bits(self.to_bits().swap_bytes()) } else { self })
    }
}

impl<'py> FromPyObject<'_, 'py> for Heights<'py> {
    type Error = PyErr;

    fn extract(array: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        macro_rules! of_kinds {
            ($($kind:ty => $name:ident),*) => {$(
                if let Ok(array) = array.cast::<PyArray2<$kind>>() {
                    let shape = (array.shape()[0], array.shape()[1]);
                    return Ok(Heights { shape, array: Array::$name(array.try_readonly()?) });
                }
            )*};
        }
        of_kinds!(f64 => F64, f32 => F32, i8 => I8, i16 => I16, i32 => I32, i64 => I64, u8 => U8, u16 => U16, u32 => U32,
            u64 => U64);
        Err(PyTypeError::new_err("wanted an array of two dimensions of real numbers"))
    }
}

/// Puts a row of an array into another, as meters, NaN where there is no height, and says whether to go on.
pub(crate) type Rows<'a> = Box<dyn Fn(usize, &mut [f64]) -> bool + Send + Sync + 'a>;

impl Heights<'_> {
    /// Its rows; `nodata` stands for no height.
    pub(crate) fn rows<'a>(&'a self, is_swapped: bool, nodata: Option<f64>, stop: &'a AtomicBool) -> Rows<'a> {
        match &self.array {
            Array::F64(array) => rows(array.as_array(), is_swapped, nodata, stop),
            Array::F32(array) => rows(array.as_array(), is_swapped, nodata, stop),
            Array::I8(array) => rows(array.as_array(), is_swapped, nodata, stop),
            Array::I16(array) => rows(array.as_array(), is_swapped, nodata, stop),
            Array::I32(array) => rows(array.as_array(), is_swapped, nodata, stop),
            Array::I64(array) => rows(array.as_array(), is_swapped, nodata, stop),
            Array::U8(array) => rows(array.as_array(), is_swapped, nodata, stop),
            Array::U16(array) => rows(array.as_array(), is_swapped, nodata, stop),
            Array::U32(array) => rows(array.as_array(), is_swapped, nodata, stop),
            Array::U64(array) => rows(array.as_array(), is_swapped, nodata, stop),
        }
    }
}

fn rows<'a, T: Number>(
    array: ArrayView2<'a, T>,
    is_swapped: bool,
    nodata: Option<f64>,
    stop: &'a AtomicBool,
) -> Rows<'a> {
    Box::new(move |row, heights| {
        for (height, number) in heights.iter_mut().zip(array.row(row)) {
            *height = number.read(is_swapped);
        }
        if let Some(nodata) = nodata {
            #[expect(clippy::float_cmp, reason = "the very number stands for no height")]
            heights.iter_mut().filter(|height| **height == nodata).for_each(|height| *height = f64::NAN);
        }
        !stop.load(Ordering::Relaxed)
    })
}

/// Heights of cells as scenes hold them.
pub(crate) fn held(
    name: &str,
    georef: skyshed_core::raster::GeoRef,
    rows: &Rows<'_>,
) -> Result<skyshed_io::read::HeldHeights, Failure> {
    Ok(skyshed_io::read::HeldHeights::new(name, georef, rows)?)
}
