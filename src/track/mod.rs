//! Line of sight along tracks: walks below UAVs, and flights.

mod document;
mod figure;
mod stretch_files;
mod way;

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use serde_json::Value;

use crate::answer::{Answer, CommandFacts, Rows, RunFacts, Spent, add_rows, rows};
use crate::city::{GivenSite, Site, Source};
use crate::coverage::{StretchSums, TrackPoint, TrackState, TrackStretches, Uav, Way, WayRun, WayStretches};
use crate::earth::warn_of_drop;
use crate::error::{Error, LimitError, OddRun, Result, Warning, warned};
use crate::export::{Batch, Format};
use crate::height_field::Curvature;
use crate::link::check_extent;
use crate::los::Method;
use crate::picture::Look;
use crate::quantity::{counted, tidy};
use crate::raster::GeoRef;
use crate::read::{self, Paths, read_track, source_of};
use crate::scene::Scene;
use crate::scene::placing::{place_all, place_uav, warn_of_uavs_outside};
use crate::sight::SightPlan;
use crate::uav::UavsAsked;
use crate::words::p_los_words;
use skyshed_io::Input;
use skyshed_request::{Earth, Receiver, Sight, TrackOptions, filled};

pub(crate) use way::{home_ground, places, resolved, ways_of};

pub(crate) use document::{PointRow, StretchRow, TrackDocument};

/// Output formats of a track.
pub(crate) const FORMATS: [Format; 6] =
    [Format::Png, Format::Svg, Format::Pdf, Format::Csv, Format::Json, Format::Stdout];

/// Formats of the stretches of a track.
pub(crate) const STRETCH_FORMATS: [Format; 4] = [Format::Csv, Format::GeoJson, Format::Gpx, Format::Kml];

/// Most places along a track that are decided for one UAV.
const MOST_PLACES: f64 = 1e6;
/// Most UAVs that the text tells one by one.
const MOST_TOLD: usize = 20;
/// Most parts without a receiver that the text tells one by one.
const MOST_PLACES_TOLD: usize = 5;

/// A track that is asked for.
#[derive(Debug, Clone)]
pub(crate) struct TrackAsked {
    /// Places of the track: a table, a line or a mission.
    pub(crate) file: Input,
    /// `true` if rows of the track that cannot be read are left out.
    pub(crate) skips_bad: bool,
    /// `true` if the track is hashed, however large it is.
    pub(crate) hash: bool,
    /// Longest step between two decided places \[m\].
    pub(crate) every_m: f64,
    /// `true` if legs between heights above the ground follow it.
    pub(crate) follows_ground: bool,
}

impl TrackAsked {
    /// Fills in the defaults of a question about a track.
    ///
    /// # Errors
    /// E113.
    pub(crate) fn of((file, skips_bad, hash): (Input, bool, bool), options: &TrackOptions) -> Result<TrackAsked> {
        let every_m = filled(options.every, TrackOptions::defaults().every);
        if every_m <= 0.0 {
            return Err(Error::number("the step along a track", every_m, "above 0 m"));
        }
        Ok(TrackAsked { file, skips_bad, hash, every_m, follows_ground: options.follow_ground })
    }

    /// Reads the paths of the track.
    ///
    /// # Errors
    /// Errors of the file; E116 for a walk that is to follow the ground; E502 for too many steps.
    pub(crate) fn read(&self, grid: &GeoRef, warnings: &mut Vec<Warning>) -> Result<Paths> {
        let read = |odd: &mut _| read_track(&self.file, grid.crs(), (self.skips_bad, odd));
        let paths = warned(warnings, read)?;
        if self.follows_ground && !paths.have_heights() {
            return Err(Error::idle("follow_ground", "for a walk: it follows the ground"));
        }
        let length = |path: &read::Path| -> f64 {
            path.vertices.windows(2).map(|e| (e[1].x - e[0].x).hypot(e[1].y - e[0].y)).sum()
        };
        let length_m = paths.lines.iter().map(length).sum::<f64>() * grid.meters_per_unit();
        if length_m / self.every_m > MOST_PLACES {
            return Err(LimitError::Track { length: tidy(length_m), every_m: self.every_m }.into());
        }
        Ok(paths)
    }

    /// Returns the file among the sources of an answer.
    ///
    /// # Errors
    /// Errors of the file.
    pub(crate) fn source(&self) -> Result<Source> {
        Ok(source_of(&self.file, self.hash)?)
    }
}

/// Plan of a walk or a flight.
#[derive(Debug)]
pub(crate) struct TrackPlan {
    pub(crate) uavs: UavsAsked,
    pub(crate) track: TrackAsked,
    /// `true` if a height of the receivers was asked for.
    pub(crate) has_rx_height: bool,
    /// Height of the user, and the shape of the earth.
    pub(crate) sight: SightPlan,
    /// Files of stretches.
    pub(crate) stretch_files: Vec<PathBuf>,
}

impl TrackPlan {
    /// Fills in the defaults of a question about UAVs and a track.
    ///
    /// # Errors
    /// E113.
    pub(crate) fn of(uavs: UavsAsked, track: TrackAsked, (receiver, earth): (&Receiver, &Earth)) -> Result<TrackPlan> {
        let sight = Sight { receiver: *receiver, earth: *earth, ..Sight::default() };
        let sight = SightPlan::of(&sight)?;
        Ok(TrackPlan { uavs, track, has_rx_height: receiver.rx_height.is_some(), sight, stretch_files: Vec::new() })
    }

    /// Finds the stretches of the track over a scene.
    ///
    /// # Errors
    /// Errors of reading the files; E2xx for a UAV or a vertex that cannot be there; E116 for a height
    /// of receivers beside heights of the track; E502 for too many steps.
    pub(crate) fn walk(&self, mut scene: Scene, command: CommandFacts) -> Result<TrackWalk> {
        let found = self.uavs.read(scene.grid())?;
        let found = found.over(&scene.field)?;
        scene.warnings.extend(found.warnings.iter().cloned());
        scene.sources.extend(found.sources.iter().cloned());
        warn_of_uavs_outside(&found.sites, scene.field.grid(), &mut scene.warnings);
        let paths = self.read(&mut scene)?;
        let (reach, farthest_m) = TrackPlan::check_reach(&scene, (&found.sites, &paths))?;
        let place = |site: &Site| place_uav(site, &scene.field, scene.field.grid(), Some(reach));
        let uavs = place_all(&found, place, &mut scene.warnings)?;
        let has_heights = paths.have_heights();
        let ways = ways_of(paths, (&scene.field, &self.track), self.sight.rx_height(), &mut scene.warnings)?;
        let curvature = self.sight.curvature();
        if curvature.is_none() {
            warn_of_drop(farthest_m, &mut scene.warnings);
        }
        let step = self.track.every_m / scene.grid().meters_per_unit();
        let curved = curvature.map(|curvature| (curvature, step));
        let TrackStretches { each, all } = TrackStretches::find(&scene.field, (&ways, &uavs), curved)?;
        let none = all.runs().filter(|run| !run.first().state.has_receiver());
        let off_m: f64 = none.map(|run| run.length_m()).sum();
        if off_m > 0.0 {
            scene.warnings.push(OddRun::OffGround { length: tidy(off_m) }.into());
        }
        Ok(TrackWalk {
            facts: RunFacts { command, ..scene.facts(Some(Method::Ray)) },
            rx_height_m: (!has_heights).then(|| self.sight.rx_height_m()),
            curvature,
            every_m: self.track.every_m,
            uavs,
            ways,
            each: each.into_iter().map(Seen::of).collect(),
            all: Seen::of(all),
            points: OnceLock::new(),
            stretch_files: self.stretch_files.clone(),
            scene,
        })
    }

    /// Reads the track, and refuses a height of receivers beside heights of its own.
    fn read(&self, scene: &mut Scene) -> Result<Paths> {
        let paths = self.track.read(scene.field.grid(), &mut scene.warnings)?;
        scene.sources.push(self.track.source()?);
        if paths.have_heights() && self.has_rx_height {
            return Err(Error::idle("rx_height", "for a track with heights of its own"));
        }
        Ok(paths)
    }

    /// Checks the lengths of links. Returns how far places of the track are from the UAVs at most: along
    /// an axis \[CRS units\], and in the plane \[m\].
    fn check_reach(scene: &Scene, (sites, paths): (&[GivenSite], &Paths)) -> Result<(f64, f64)> {
        let (mut reach, mut farthest) = (1.0_f64, 0.0_f64);
        for site in sites {
            for [x, y] in places(&paths.lines) {
                check_extent(scene, &site.site, (x, y))?;
                reach = reach.max((x - site.x).abs()).max((y - site.y).abs());
                farthest = farthest.max((x - site.x).hypot(y - site.y));
            }
        }
        Ok((reach, farthest * scene.grid().meters_per_unit()))
    }
}

/// Stretches that one UAV sees, or all together, and their sums.
#[derive(Debug, Clone)]
struct Seen {
    stretches: WayStretches,
    sums: StretchSums,
}

impl Seen {
    fn of(stretches: WayStretches) -> Seen {
        Seen { sums: stretches.sums(), stretches }
    }

    /// Returns the share of the length in line of sight; `None` without receivers.
    fn share(&self) -> Option<f64> {
        StretchSums::share(self.sums.length_m)
    }
}

/// Line of sight between UAVs and a user along tracks.
#[derive(Debug)]
pub(crate) struct TrackWalk {
    scene: Scene,
    facts: RunFacts,
    /// Height of the user above ground \[m\]; `None` for a track with heights of its own.
    rx_height_m: Option<f64>,
    curvature: Option<Curvature>,
    every_m: f64,
    uavs: Vec<Uav>,
    ways: Vec<Way>,
    /// As each UAV sees it.
    each: Vec<Seen>,
    /// As the best of them at each place sees it.
    all: Seen,
    /// Decided places by UAV and way, found when they are asked for.
    points: OnceLock<Vec<Vec<Vec<TrackPoint>>>>,
    stretch_files: Vec<PathBuf>,
}

impl TrackWalk {
    /// Returns the decided places by UAV and way.
    ///
    /// # Errors
    /// E118 for an earth so curved that heights would leave the lattice.
    fn points(&self) -> Result<&[Vec<Vec<TrackPoint>>]> {
        if let Some(points) = self.points.get() {
            return Ok(points);
        }
        let step = self.every_m / self.scene.grid().meters_per_unit();
        let of = |uav: &Uav| TrackPoint::along(&self.scene.field, (&self.ways, uav), (self.curvature, step));
        let found = self.uavs.iter().map(of).collect::<skyshed_core::Result<_>>()?;
        Ok(self.points.get_or_init(|| found))
    }

    /// Returns words about the stretches of one UAV or of all.
    fn words(seen: &Seen, who: &str) -> String {
        let Seen { stretches, sums } = seen;
        let length = |state| tidy(sums.length(state));
        let n_without = stretches.runs_of(TrackState::Nlos).count();
        let share = match seen.share() {
            None => "undefined: no place holds a receiver".to_string(),
            share => p_los_words(share),
        };
        let by_time = match sums.time_s.map(StretchSums::share) {
            Some(share @ Some(_)) => format!(", {} by time", p_los_words(share)),
            _ => String::new(),
        };
        let longest_s = sums.longest_without_s.map_or(String::new(), |s| format!(", {} s", tidy(s)));
        format!(
            "P_LoS along the track{who} {share}{by_time}: {} m with line of sight, {} m without in {}, the longest {} m{longest_s}\n",
            length(TrackState::Los),
            length(TrackState::Nlos),
            counted(n_without as u64, "stretch", "stretches"),
            tidy(sums.longest_without_m)
        )
    }

    /// Returns words about what the best UAV at each place sees.
    fn words_of_all(&self) -> String {
        let who = if self.uavs.len() > 1 { " from one of them or more" } else { "" };
        let text = TrackWalk::words(&self.all, who);
        match self.places_of(TrackState::Nlos) {
            Some(places) => format!("{text}line of sight is lost at {places}\n"),
            None => text,
        }
    }

    /// Returns words about the parts without a receiver.
    fn words_of_none(&self) -> String {
        let parts =
            [(TrackState::Inside, "inside buildings or below the ground"), (TrackState::Nodata, "without a ground")];
        let told = parts.into_iter().filter_map(|(state, what)| {
            let places = self.places_of(state)?;
            Some(format!("{} m {what}: {places}\n", tidy(self.all.sums.length(state))))
        });
        told.collect()
    }

    /// Returns the ends of the first runs of a state along the track, and in time, in words; `None` without any.
    fn places_of(&self, state: TrackState) -> Option<String> {
        let rounded = |value: f64| tidy((value * 100.0).round() / 100.0);
        let of = |run: WayRun<'_>| {
            let [from, to] = run.along_m().map(rounded);
            let times = run.time_s().map(|times| times.map(rounded));
            let times = times.map_or(String::new(), |[from, to]| format!(" ({from} to {to} s)"));
            format!("{from} to {to} m{times}")
        };
        let runs: Vec<String> = self.all.stretches.runs_of(state).map(of).collect();
        let n_more = runs.len().saturating_sub(MOST_PLACES_TOLD);
        let more = if n_more > 0 { format!(" and {n_more} more") } else { String::new() };
        let told = runs.len().min(MOST_PLACES_TOLD);
        (!runs.is_empty()).then(|| runs[..told].join(", ") + &more)
    }
}

impl Answer for TrackWalk {
    fn is_in_words(&self) -> bool {
        true
    }

    fn document(&self, _: Option<Spent>) -> Value {
        self.as_document(true)
    }

    fn provenance(&self) -> Value {
        self.as_document(false)
    }

    fn table(&self) -> Rows {
        rows(self.point_rows())
    }

    fn add_table(&self, batch: &mut Batch, path: &Path, look: &Look) -> Result<()> {
        let table = match self.stretch_files.iter().any(|file| file == path) {
            true => rows(self.stretch_rows()),
            false => self.table(),
        };
        add_rows(batch, path, (&table, &self.provenance()), look)
    }

    fn warnings(&self) -> &[Warning] {
        &self.facts.warnings
    }

    fn text(&self, _: &Look) -> Result<String> {
        let mut text = self.words_of_none();
        if self.uavs.len() > 1 {
            for (uav, seen) in self.uavs.iter().zip(&self.each).take(MOST_TOLD) {
                text += &TrackWalk::words(seen, &format!(" from UAV `{}`", uav.id));
            }
            if self.uavs.len() > MOST_TOLD {
                text += &format!("and {} more UAVs\n", self.uavs.len() - MOST_TOLD);
            }
        }
        Ok(text + &self.words_of_all())
    }

    fn add(&self, batch: &mut Batch, path: &Path, format: Format, look: &Look) -> Result<()> {
        let bytes = match format {
            Format::GeoJson => stretch_files::geojson(self)?.into_bytes(),
            Format::Gpx => stretch_files::gpx(self, path)?.into_bytes(),
            Format::Kml => stretch_files::kml(self, path)?.into_bytes(),
            _ => figure::draw(self, format, look)?,
        };
        Ok(batch.add(path, &bytes)?)
    }
}
