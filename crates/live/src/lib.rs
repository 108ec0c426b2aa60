//! The engines in a page: a city is handed over as bytes, a UAV as numbers, and the mask lies in memory.
//!
//! [`load`] and [`map`] return 0, or 1 after a failure; [`text`] then says what went wrong. Bytes pass through the memory of the
//! module: the caller writes a scene where [`input`] points, and reads masks where [`mask`] points. The next call may move them.

#![allow(unsafe_code, reason = "functions are exported by name, which counts as unsafe; there is no unsafe block")]

use std::cell::RefCell;

use skyshed_core::city::Site;
use skyshed_core::coverage::{Control, MapOptions, Mapper, Uav};
use skyshed_core::height_field::HeightField;
use skyshed_core::quantity::Height;
use skyshed_io::Input;
use skyshed_io::read::{FootprintOptions, read_footprints};

/// What is kept from one call to the next.
#[derive(Default)]
struct Held {
    input: Vec<u8>,
    field: Option<HeightField>,
    mask: Vec<u8>,
    text: String,
}

thread_local! {
    static HELD: RefCell<Held> = RefCell::default();
}

impl Held {
    fn load(&mut self) -> Result<(), String> {
        let input = Input::bytes("scene.geojson", std::mem::take(&mut self.input));
        let city = read_footprints(input, &FootprintOptions::default(), &mut Vec::new()).map_err(|e| e.to_string())?;
        self.field = Some(HeightField::build(&city.grid, city.solids).field);
        Ok(())
    }

    fn map(&mut self, x: f64, y: f64, above_ground_m: f64) -> Result<(), String> {
        let field = self.field.as_ref().ok_or("no scene is loaded")?;
        let site = Site { id: "1".into(), x, y, height: Height::AboveGround(above_ground_m) };
        let uav = Uav::place(&site, field, None).map_err(|e| e.to_string())?;
        let options = MapOptions { meters_per_unit: field.grid().meters_per_unit(), ..MapOptions::default() };
        let mapper = Mapper::new(field, &options).map_err(|e| e.to_string())?;
        self.mask = mapper.map(&uav, &Control::default()).map_err(|e| e.to_string())?.mask.to_vec();
        Ok(())
    }

    /// The number that a call returns; the words of a failure are kept for [`text`].
    fn code_of(&mut self, done: Result<(), String>) -> u32 {
        match done {
            Ok(()) => 0,
            Err(words) => {
                self.text = words;
                1
            }
        }
    }
}

/// Points at room for the bytes of a scene.
#[unsafe(no_mangle)]
pub extern "C" fn input(n_bytes: usize) -> *mut u8 {
    HELD.with_borrow_mut(|held| {
        held.input = vec![0; n_bytes];
        held.input.as_mut_ptr()
    })
}

/// Reads footprints in GeoJSON from the bytes that were handed over.
#[unsafe(no_mangle)]
pub extern "C" fn load() -> u32 {
    HELD.with_borrow_mut(|held| {
        let done = held.load();
        held.code_of(done)
    })
}

/// The grid of the scene: columns in the high 32 bits, rows in the low ones; 0 without a scene.
#[unsafe(no_mangle)]
pub extern "C" fn shape() -> u64 {
    HELD.with_borrow(|held| {
        held.field.as_ref().map_or(0, |field| (field.grid().n_cols() as u64) << 32 | field.grid().n_rows() as u64)
    })
}

/// Maps a UAV at a position \[CRS units\] and a height above the ground \[m\].
#[unsafe(no_mangle)]
pub extern "C" fn map(x: f64, y: f64, above_ground_m: f64) -> u32 {
    HELD.with_borrow_mut(|held| {
        let done = held.map(x, y, above_ground_m);
        held.code_of(done)
    })
}

/// Points at the mask: a class for each cell, north row first.
#[unsafe(no_mangle)]
pub extern "C" fn mask() -> *const u8 {
    HELD.with_borrow(|held| held.mask.as_ptr())
}

/// Points at the words of the last failure (UTF-8).
#[unsafe(no_mangle)]
pub extern "C" fn text() -> *const u8 {
    HELD.with_borrow(|held| held.text.as_ptr())
}

/// Length of these words \[bytes\].
#[unsafe(no_mangle)]
pub extern "C" fn text_length() -> usize {
    HELD.with_borrow(|held| held.text.len())
}
