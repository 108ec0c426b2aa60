//! Missions as plain text, `QGC WPL 110`: <https://mavlink.io/en/file_formats/>.

use super::super::sites::bad_rows;
use super::RawPaths;
use super::mission::{Frame, Item, height_of, of_items};
use crate::error::{MOST_FOUND, PlacesIn, Result, shortened};
use crate::input::Input;
use crate::quantity::parse_number;

/// Fields of a line: index, current, frame, command, four parameters, latitude, longitude, altitude
/// and whether the mission goes on.
const N_FIELDS: usize = 12;

/// Reads a mission as one path. The line of index 0 is its home.
pub(super) fn read(input: &Input, text: &str) -> Result<RawPaths> {
    let refuse = |found: String| bad_rows(input, PlacesIn::Path, found, false);
    let (mut home, mut items) = (None, Vec::new());
    for (number, line) in text.lines().enumerate().skip(1).filter(|(_, line)| !line.trim().is_empty()) {
        let told = format!("line {}", number + 1);
        let fields: Vec<&str> = line.split_whitespace().collect();
        if fields.len() != N_FIELDS {
            return Err(refuse(format!("{told}: found {} fields, wanted {N_FIELDS}", fields.len())));
        }
        let field =
            |k: usize| parse_number(fields[k]).map_err(|found| refuse(format!("{told}: {found}, wanted a number")));
        let code = |k: usize| {
            let found = || format!("{told}: found `{}`, wanted a whole number", shortened(fields[k], MOST_FOUND));
            fields[k].parse::<u64>().map_err(|_| refuse(found()))
        };
        let (lat, lon, altitude) = (field(8)?, field(9)?, field(10)?);
        if code(0)? == 0 {
            home = Some((lon, lat)).filter(|home| *home != (0.0, 0.0));
            continue;
        }
        let frame = code(2)?;
        items.push(Item {
            told: told.clone(),
            command: code(3)?,
            place: Some((lat, lon)),
            height: height_of(Frame::of(frame), Some(frame), Some(altitude)),
        });
    }
    of_items(input, items, home)
}
