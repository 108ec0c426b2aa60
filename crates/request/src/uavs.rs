//! UAVs of a question.

use std::fmt;
use std::str::FromStr;

use skyshed_core::quantity::{Height, parse_number};
use skyshed_core::words;

use crate::Source;
use crate::part::part;

/// Position and height of a UAV as they are typed: `500,500,100`, `691549.7,5334762.2,30roof`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Position {
    /// East \[CRS units\].
    pub x: f64,
    /// North \[CRS units\].
    pub y: f64,
    /// Height, and its reference.
    pub height: Height,
}

impl FromStr for Position {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts: Vec<&str> = text.split(',').collect();
        let [x, y, h] = parts[..] else { return Err(format!("found {} values, wanted X,Y,H", parts.len())) };
        let x = parse_number(x).map_err(|e| format!("x: {e}"))?;
        let y = parse_number(y).map_err(|e| format!("y: {e}"))?;
        Ok(Position { x, y, height: h.parse()? })
    }
}

impl fmt::Display for Position {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{},{},{}", self.x, self.y, self.height)
    }
}

words! {
    /// Treatment of UAVs that cannot be at their place: inside a building, below the ground.
    pub enum BadUavs {
        /// An error that names all of them
        Fail = "fail",
        /// Left out, with a warning
        Skip = "skip",
        /// Lifted to the top of what is there, with a warning; left out where no ground is known
        Lift = "lift",
    }
    default Fail
}

part! {
    /// UAVs, one by one and of a table.
    pub struct Uavs, SetUavs {
        /// A UAV: x, y and height, as 120, 150amsl or 30roof; repeat for more
        ///
        /// x and y are in the scene's CRS; heights are 120, 120agl, 30roof, 150amsl, 400ft.
        #[arg(long, value_name = "X,Y,H", allow_hyphen_values = true)]
        uav: Vec<String>,
        /// UAVs from a table (.csv), points (.geojson, .gpx, .kml) or a mission (.plan, .waypoints)
        ///
        /// Columns are x,y,h or lon,lat,h; `-` is standard input. Without points the places of a path are UAVs. Columns from,to are the
        /// time in which a UAV is up (ISO 8601, or minutes), of which the layers `uptime` and `gap` and --over-time tell.
        #[arg(long, value_name = "FILE")]
        uavs: Option<Source>,
        /// Leave out rows of the table that cannot be read, with a warning that names them
        #[arg(long, hide_short_help = true)]
        skip_bad: bool,
        /// UAVs inside a building or below the ground: refuse them, leave them out, or lift them to the top of what is there
        #[arg(long, value_name = "WHAT", value_parser = crate::words::one_of::<BadUavs>(), hide_short_help = true)]
        bad_uavs: Option<BadUavs>,
    }
}
