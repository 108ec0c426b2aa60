//! Placement: where to hover.

use skyshed_core::words;
use skyshed_core::zones::Zone;

use crate::part::{group, part};
use crate::{
    Antenna, Earth, Fault, FilePath, Goal, HeightErrors, Heights, OutputOptions, PictureOptions, Range, Reading,
    Receiver, SceneOptions, SceneWord, Shard, Sight, Source, Whom, have_one_reference,
};

part! {
    /// Candidates of placement.
    #[cfg_attr(feature = "words", command(next_help_heading = "Candidates"))]
    pub struct CandidateOptions, SetCandidateOptions {
        /// Heights to try, such as 60,100 or 60:120:20 [m]
        ///
        /// Each as 120, 120agl, 30roof, 150amsl or 400ft, separated by commas, or A:B:S with both ends included.
        #[arg(long, value_name = "H,…", allow_hyphen_values = true, required_unless_present = "candidates")]
        height: Option<Heights>,
        /// Distance between candidate places: the centers of square cells over the scene [m]
        #[arg(long, value_name = "M", value_parser = crate::words::number, allow_hyphen_values = true)]
        step: Option<f64>,
        /// Only candidates over these zones, separated by commas
        #[arg(long, value_name = "ZONE,…", value_parser = crate::words::one_of::<Zone>(), value_delimiter = ',', hide_short_help = true)]
        over: Vec<Zone>,
        /// Only candidates inside of these polygons (.geojson)
        #[arg(long, value_name = "FILE", hide_short_help = true)]
        within: Option<Source>,
        /// No candidates inside of these polygons (.geojson)
        #[arg(long, value_name = "FILE", hide_short_help = true)]
        keep_out: Option<Source>,
        /// Candidates from a table (.csv) or points (.geojson) instead of a grid
        ///
        /// Columns are x,y,h or lon,lat,h; `-` is standard input. They go by their names (a column id). Their own heights count if
        /// `--height` is not given.
        #[arg(long, value_name = "FILE", conflicts_with = "step")]
        candidates: Option<Source>,
        /// Leave out rows of the candidates that cannot be read, with a warning that names them
        #[arg(long, requires = "candidates", hide_short_help = true)]
        skip_bad: bool,
        /// Only the K-th of N nearly equal parts of the candidates, in their order; nothing is refined: for schedulers that hand out
        /// numbers
        #[arg(long, value_name = "K/N", hide_short_help = true)]
        shard: Option<Shard>,
        /// At least so high above the roof or ground directly below [m]
        #[arg(long, value_name = "M", value_parser = crate::words::number, allow_hyphen_values = true, hide_short_help = true)]
        clearance: Option<f64>,
    }
}

words! {
    /// Quantity to make small.
    #[non_exhaustive]
    pub enum Minimize {
        /// The UAV's height
        Height = "height",
    }
}

part! {
    /// Goal of placement.
    #[cfg_attr(feature = "words", command(next_help_heading = "Goal"))]
    pub struct GoalOptions, SetGoalOptions {
        /// Quantity to make large, such as p_los, p_los(street), margin, p_los>=0.8
        ///
        /// p_los is the share seen of all receivers of `--receivers`, in range or not; margin is that of the worst receiver in range.
        /// Both may be of receivers only in (street), (crossroad), (courtyard), (rooftop) or (area); p_los also (weights). With
        /// `--minimize height` it is a share to reach, such as p_los>=0.8.
        #[arg(long, value_name = "GOAL")]
        goal: Option<Goal>,
        /// Polygons (.geojson) whose receivers count for the goals p_los(area) and margin(area)
        #[arg(long, value_name = "FILE", hide_short_help = true)]
        area: Option<Source>,
        /// Raster of scores for the goal p_los(weights): each receiver counts the whole value of the cell that holds it
        ///
        /// It does not hold persons per cell, which many receivers would share.
        #[arg(long, value_name = "FILE", hide_short_help = true)]
        weights: Option<FilePath>,
        /// Instead of the largest share, the least height that reaches the share of the goal
        #[arg(long, value_name = "WHAT", value_parser = crate::words::one_of::<Minimize>(), hide_short_help = true)]
        minimize: Option<Minimize>,
        /// Number of UAVs that are to see most together, of all receivers of the goal whatever the radius
        #[arg(short = 'k', long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
        count: Option<u16>,
    }
}

part! {
    /// Table of an answer.
    #[cfg_attr(feature = "words", command(next_help_heading = "Output"))]
    pub struct Table, SetTable {
        /// Write the table to this file
        #[arg(long, value_name = "FILE", hide_short_help = true)]
        csv: Option<FilePath>,
    }
}

part! {
    /// Files and lists of placement.
    #[cfg_attr(feature = "words", command(next_help_heading = "Output"))]
    pub struct PlaceFiles, SetPlaceFiles {
        /// View of the winner, or of those chosen together: a coverage map (.png .svg .pdf .tif)
        #[arg(long, value_name = "FILE", hide_short_help = true)]
        map: Option<FilePath>,
        /// Ranks that documents and points list
        #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..), hide_short_help = true)]
        top: Option<u16>,
    }
}

group! {
    /// Question of placement.
    pub struct PlaceQuestion {
        /// Candidates.
        candidates: CandidateOptions,
        /// Goal.
        goal: GoalOptions,
        /// Receivers, range, antennas and earth.
        #[heading = "Goal"]
        sight: Sight,
        /// Errors of building heights.
        #[heading = "Goal"]
        heights: HeightErrors,
    }
}

crate::holds!(PlaceQuestion: candidates CandidateOptions, goal GoalOptions, sight.receiver Receiver, sight.range Range,
    sight.antenna Antenna, sight.earth Earth, heights HeightErrors);

impl PlaceQuestion {
    /// Returns the defaults of the fields.
    pub fn defaults() -> PlaceQuestion {
        PlaceQuestion {
            candidates: CandidateOptions { step: Some(20.0), clearance: Some(0.0), ..CandidateOptions::default() },
            goal: GoalOptions { goal: Some(Goal::p_los()), count: Some(1), ..GoalOptions::default() },
            ..PlaceQuestion::default()
        }
    }

    /// Returns the goal.
    pub fn goal(&self) -> Goal {
        self.goal.goal.clone().unwrap_or_else(Goal::p_los)
    }

    /// Refuses options that contradict each other, or change nothing.
    ///
    /// # Errors
    /// E101, E113, E116.
    pub fn check(&self) -> crate::Result<()> {
        let PlaceQuestion { candidates, goal: options, sight, .. } = self;
        let goal = self.goal();
        if candidates.shard.is_some() && (options.count.is_some_and(|n| n > 1) || options.minimize.is_some()) {
            return Err(Fault::idle("shard", "with `count` or `minimize`, which look at all candidates"));
        }
        match (options.minimize, goal.at_least) {
            (Some(_), None) => return Err(Fault::ShareWanted(goal.text)),
            (None, Some(_)) => return Err(Fault::MinimizeWanted(goal.text)),
            _ => {}
        }
        if options.minimize.is_some()
            && !candidates.height.as_ref().is_some_and(|heights| have_one_reference(&heights.0))
        {
            return Err(Fault::MixedHeights);
        }
        if matches!(goal.whom, Whom::Zone(_)) && sight.range.receivers.is_some() {
            return Err(Fault::idle("receivers", "with the goal of a zone"));
        }
        Ok(())
    }
}

group! {
    /// Request of placement: the question, and its run.
    #[command(
        mut_arg("output", |a| a.help("File to write: .png .svg .pdf .tif .csv .json .geojson; repeat for more").long_help(
            "File to write, by extension: .csv (those chosen, then all candidates, ranked), .json, .geojson (the best ones), .png \
             .svg .pdf (where to hover), .tif (the same as numbers), `-` for JSON on standard output; repeat for more. Without any the \
             best ranks of the table go to standard output")),
        after_help = "Example: skyshed place itu:urban --height 60,100 --step 50 -o hover.png"
    )]
    pub struct PlaceRequest {
        /// Scene.
        scene: SceneWord,
        /// Reading of the scene.
        reading: Reading,
        /// Question.
        question: PlaceQuestion,
        /// Files and effort.
        out: OutputOptions,
        /// Table.
        table: Table,
        /// Other files.
        files: PlaceFiles,
        /// Looks of pictures.
        picture: PictureOptions,
    }
}

crate::holds!(PlaceRequest: reading.options SceneOptions, question.candidates CandidateOptions, question.goal GoalOptions,
    question.sight.receiver Receiver, question.sight.range Range, question.sight.antenna Antenna, question.sight.earth Earth,
    question.heights HeightErrors, out.files crate::Files, out.writing crate::Writing, table Table, files PlaceFiles,
    picture PictureOptions);
