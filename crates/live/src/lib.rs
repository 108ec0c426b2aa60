//! The engines in a page: a city is handed over as bytes, a UAV as numbers, and the mask lies in memory.
//!
//! A call gives 0, or 1 after a failure, whose words are then the text of the module. The caller copies bytes to where
//! [`input`] says and reads the mask and the text from where [`mask`] and [`text`] say; any other call may move them.

#![allow(unsafe_code, reason = "functions are exported by name, which counts as unsafe; there is no unsafe block")]

use std::cell::RefCell;

use skyshed_core::city::Site;
use skyshed_core::coverage::{Control, MapOptions, Mapper, Uav};
use skyshed_core::height_field::HeightField;
use skyshed_core::quantity::Height;
use skyshed_io::Input;
use skyshed_io::read::{FootprintOptions, read_footprints};

/// What the module holds between two calls.
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

    /// Keeps the words of a failure.
    fn told(&mut self, done: Result<(), String>) -> u32 {
        match done {
            Ok(()) => 0,
            Err(words) => {
                self.text = words;
                1
            }
        }
    }
}

/// Makes room for so many bytes of a scene, and says where.
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
        held.told(done)
    })
}

/// Columns and rows of the grid, as the high and the low half of a number; 0 without a scene.
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
        held.told(done)
    })
}

/// Where the mask lies, a byte for each cell, north row first.
#[unsafe(no_mangle)]
pub extern "C" fn mask() -> *const u8 {
    HELD.with_borrow(|held| held.mask.as_ptr())
}

/// Where the words of the last failure lie.
#[unsafe(no_mangle)]
pub extern "C" fn text() -> *const u8 {
    HELD.with_borrow(|held| held.text.as_ptr())
}

/// How many bytes these are.
#[unsafe(no_mangle)]
pub extern "C" fn text_length() -> usize {
    HELD.with_borrow(|held| held.text.len())
}
