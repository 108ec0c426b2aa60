//! Tracks: walks and flights, and the request of line of sight along them.

use crate::part::{group, part};
use crate::{Earth, FilePath, OutputOptions, PictureOptions, Reading, Receiver, SceneWord, Source, Uavs};

part! {
    /// Walk or flight of a user.
    pub struct TrackOptions, SetTrackOptions {
        /// Places in order: .csv .geojson .gpx .kml .plan .waypoints; heights and times where the file has them
        ///
        /// A table has columns x,y or lon,lat, and for a flight h, for times t (seconds or ISO 8601); `-` is standard input. A
        /// track without heights is a walk at --rx-height.
        #[arg(long, value_name = "FILE")]
        track: Option<Source>,
        /// Cut legs between heights above the ground at --every, to follow it
        #[arg(long)]
        follow_ground: bool,
        /// Longest step between two places in tables and pictures [m]; over a curved earth what begins and ends within one is missed
        #[arg(long, value_name = "M", value_parser = crate::words::number, allow_hyphen_values = true)]
        every: Option<f64>,
    }
}

part! {
    /// Files of stretches.
    pub struct StretchOptions, SetStretchOptions {
        /// File of stretches, leg by leg: .csv .geojson .gpx .kml; repeat for more
        #[arg(long, value_name = "FILE")]
        stretches: Vec<FilePath>,
    }
}

group! {
    /// Request of line of sight along a walk or a flight.
    #[command(
        mut_arg("output", |a| a.help("File to write: .png .svg .pdf .csv .json; repeat for more").long_help(
            "A strip of line of sight below the height that would be enough (.png, .svg, .pdf), the document (.json), a table \
             (.csv), `-` for JSON on standard output; repeat for more")),
        mut_arg("track", |a| a.required(true)),
        after_help = "Example: skyshed track itu:urban --uav 500,500,100 --track walk.csv -o walk.png"
    )]
    pub struct TrackRequest {
        /// Scene.
        scene: SceneWord,
        /// Reading of the scene.
        reading: Reading,
        /// UAVs.
        #[heading = "Track"]
        uavs: Uavs,
        /// Track.
        #[heading = "Track"]
        track: TrackOptions,
        /// Files of stretches.
        #[heading = "Track"]
        stretches: StretchOptions,
        /// Height of the receiver.
        #[heading = "Track"]
        receiver: Receiver,
        /// Curve of the earth.
        #[heading = "Track"]
        earth: Earth,
        /// Files and effort.
        out: OutputOptions,
        /// Looks of pictures.
        picture: PictureOptions,
    }
}

impl TrackOptions {
    /// Returns the defaults of the fields.
    pub fn defaults() -> TrackOptions {
        TrackOptions { every: Some(1.0), ..TrackOptions::default() }
    }
}
