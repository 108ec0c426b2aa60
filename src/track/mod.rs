//! Line of sight along a user's track.

mod figure;

use std::path::Path;

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use crate::answer::{Answer, CommandFacts, Head, Rows, RunFacts, Spent, WarningFacts, document_of, rows, warnings_of};
use crate::city::Site;
use crate::coverage::{SceneView, Stretch, Track, TrackPoint, TrackState};
use crate::earth::warn_of_drop;
use crate::error::{Error, LimitError, OddRun, Result, Warning, warned};
use crate::export::{Batch, Format};
use crate::height_field::Curvature;
use crate::link::{EndFacts, check_extent};
use crate::los::Method;
use crate::picture::Look;
use crate::quantity::{counted, meters, tidy};
use crate::read::{read_track, source_of};
use crate::scene::Scene;
use crate::scene::placing::{place_uav, warn_of_uavs_outside};
use crate::sight::SightPlan;
use crate::uav::bad_rows;
use crate::words::p_los_words;
use skyshed_io::Input;
use skyshed_request::{Earth, Receiver, Sight, TrackOptions, filled};

/// Output formats of a track.
pub(crate) const FORMATS: [Format; 6] =
    [Format::Png, Format::Svg, Format::Pdf, Format::Csv, Format::Json, Format::Stdout];

/// Most steps along a track.
const MOST_PLACES: f64 = 1e6;

/// Plan of a walk along a track.
#[derive(Debug)]
pub(crate) struct TrackPlan {
    pub(crate) uav: Site,
    /// Places of the track: a table or a line.
    pub(crate) track: Input,
    pub(crate) skips_bad: bool,
    /// `true` if the track is hashed, however large it is.
    pub(crate) hash: bool,
    /// Longest step between two decided places \[m\].
    pub(crate) every_m: f64,
    /// Height of the user, and the shape of the earth.
    pub(crate) sight: SightPlan,
}

impl TrackPlan {
    /// Fills in the defaults of a question about a UAV and the places of a track.
    ///
    /// # Errors
    /// E113.
    pub(crate) fn of(
        uav: Site,
        (track, hash): (Input, bool),
        options: &TrackOptions,
        (receiver, earth): (&Receiver, &Earth),
    ) -> Result<TrackPlan> {
        let sight = Sight { receiver: *receiver, earth: *earth, ..Sight::default() };
        let plan = TrackPlan {
            uav,
            track,
            skips_bad: options.skip_bad,
            hash,
            every_m: filled(options.every, TrackOptions::defaults().every),
            sight: SightPlan::of(&sight)?,
        };
        plan.check()?;
        Ok(plan)
    }

    /// Checks the numbers, before any work.
    ///
    /// # Errors
    /// E113.
    pub(crate) fn check(&self) -> Result<()> {
        if self.every_m <= 0.0 {
            return Err(Error::number("the step along a track", self.every_m, "above 0 m"));
        }
        Ok(())
    }

    /// Walks the track over a scene.
    ///
    /// # Errors
    /// Errors of reading the file; E2xx for a UAV that cannot be there; E502 for too many steps.
    pub(crate) fn walk(&self, mut scene: Scene, command: CommandFacts) -> Result<TrackWalk> {
        self.check()?;
        let site = &self.uav;
        warn_of_uavs_outside(std::slice::from_ref(site), scene.field.grid(), &mut scene.warnings);
        let crs = scene.field.grid().crs();
        let read = |odd: &mut _| read_track(&self.track, crs, bad_rows(self.skips_bad, odd));
        let places = warned(&mut scene.warnings, read)?;
        scene.sources.push(source_of(&self.track, self.hash)?);
        let length: f64 = places.windows(2).map(|e| (e[1][0] - e[0][0]).hypot(e[1][1] - e[0][1])).sum();
        let unit = scene.grid().meters_per_unit();
        if length * unit / self.every_m > MOST_PLACES {
            return Err(LimitError::Track { length: tidy(length * unit), every_m: self.every_m }.into());
        }
        let mut reach = 1.0_f64;
        for place in &places {
            check_extent(&scene, site, (place[0], place[1]))?;
            reach = reach.max((place[0] - site.x).abs()).max((place[1] - site.y).abs());
        }
        let uav = place_uav(site, &scene.field, scene.grid(), Some(reach))?;
        let farthest = places.iter().map(|[x, y]| (x - site.x).hypot(y - site.y)).fold(0.0, f64::max);
        let curvature = self.sight.curvature();
        if curvature.is_none() {
            warn_of_drop(farthest * unit, &mut scene.warnings);
        }
        let view = SceneView::of(&scene.field, &uav, curvature)?;
        let track = view.along_track(&places, self.sight.rx_height(), self.every_m / unit);
        let n_outside = track.points.iter().filter(|p| p.state == TrackState::NoReceiver).count();
        if n_outside > 0 {
            let odd = OddRun::OffGround { n: n_outside as u64, of: track.points.len() };
            scene.warnings.push(odd.into());
        }
        let place = &uav.station.place;
        Ok(TrackWalk {
            facts: RunFacts { command, ..scene.facts(Some(Method::Ray)) },
            rx_height_m: self.sight.rx_height_m(),
            earth_k: curvature.map(Curvature::earth_k),
            every_m: self.every_m,
            uav: EndFacts { x: place.x, y: place.y, height_amsl_m: uav.height_amsl_m() },
            track,
            scene,
        })
    }
}

/// Line of sight between a UAV and a user who walks a track.
#[derive(Debug)]
pub(crate) struct TrackWalk {
    scene: Scene,
    facts: RunFacts,
    rx_height_m: f64,
    earth_k: Option<f64>,
    every_m: f64,
    uav: EndFacts,
    track: Track,
}

/// Line of sight along a track.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct TrackDocument {
    #[serde(flatten)]
    head: Head,
    /// The UAV.
    uav: EndFacts,
    /// Height of the user above ground [m].
    rx_height_m: f64,
    /// Effective earth radius factor k; null over a flat earth.
    earth_k: Option<f64>,
    /// Longest step between two decided places [m].
    every_m: f64,
    /// Lengths of the track [m].
    length_m: Lengths,
    /// Share of the track in line of sight, of the part with receivers; null without any.
    p_los: Option<f64>,
    /// Reason for having no share.
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<&'static str>,
    /// Longest stretch without line of sight [m].
    longest_without_m: f64,
    /// Stretches of one state, in order; absent in the copies that pictures and tables store.
    #[serde(skip_serializing_if = "Option::is_none")]
    stretches: Option<Vec<StretchDocument>>,
    /// Decided places, in order; absent in the copies that pictures and tables store.
    #[serde(skip_serializing_if = "Option::is_none")]
    points: Option<Vec<PointRow>>,
    /// Warnings.
    warnings: Vec<WarningFacts>,
}

/// Lengths of a track [m].
#[derive(Debug, Serialize, JsonSchema)]
struct Lengths {
    /// Whole track.
    total: f64,
    /// Part in line of sight.
    los: f64,
    /// Part not in line of sight.
    nlos: f64,
    /// Part inside buildings or without a ground.
    no_receiver: f64,
}

/// A stretch of a track.
#[derive(Debug, Serialize, JsonSchema)]
struct StretchDocument {
    /// los, nlos or no_receiver.
    state: &'static str,
    /// Beginning along the track [m].
    from_m: f64,
    /// End along the track [m].
    to_m: f64,
    /// Length [m].
    length_m: f64,
}

/// A decided place of a track.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct PointRow {
    /// Distance from the beginning along the track [m].
    along_m: f64,
    /// East [units of the scene's reference system].
    x: f64,
    /// North [units of the scene's reference system].
    y: f64,
    /// true for a place of the file, false for one between two of them.
    vertex: bool,
    /// Height of the user above the datum [m].
    height_amsl_m: Option<f64>,
    /// los, nlos or no_receiver.
    state: &'static str,
    /// User's height less the least height in line of sight [m].
    margin_m: Option<f64>,
    /// Horizontal distance from the UAV [m].
    distance_m: Option<f64>,
    /// Elevation angle of the UAV [deg].
    elevation_deg: Option<f64>,
}

/// Returns the word of a state in documents and tables.
fn word(state: TrackState) -> &'static str {
    match state {
        TrackState::Los => "los",
        TrackState::Nlos => "nlos",
        TrackState::NoReceiver => "no_receiver",
    }
}

impl TrackWalk {
    /// Returns the length of the track in a state \[m\].
    fn length_m(&self, state: TrackState) -> f64 {
        self.track.length(state) * self.facts.unit_m()
    }

    /// Returns the length of the longest stretch without line of sight \[m\].
    fn longest_without_m(&self) -> f64 {
        let without = self.track.stretches.iter().filter(|s| s.state == TrackState::Nlos);
        without.map(|s| (s.along[1] - s.along[0]) * self.facts.unit_m()).fold(0.0, f64::max)
    }

    /// Returns the share of the track in line of sight, of the part with receivers; `None` without
    /// any.
    fn share(&self) -> Option<f64> {
        let (los, nlos) = (self.length_m(TrackState::Los), self.length_m(TrackState::Nlos));
        (los + nlos > 0.0).then(|| los / (los + nlos))
    }

    fn stretches(&self) -> Vec<StretchDocument> {
        let unit = self.facts.unit_m();
        let of = |s: &Stretch| {
            let [from_m, to_m] = s.along.map(|along| along * unit);
            StretchDocument { state: word(s.state), from_m, to_m, length_m: (s.along[1] - s.along[0]) * unit }
        };
        self.track.stretches.iter().map(of).collect()
    }

    fn point(&self, p: &TrackPoint) -> PointRow {
        let ([x, y], unit) = (p.position, self.facts.unit_m());
        let height_amsl_m = p.z.and_then(|z| i32::try_from(z).ok()).map(meters);
        let distance_m = height_amsl_m.map(|_| (x - self.uav.x).hypot(y - self.uav.y) * unit);
        let rise = height_amsl_m.map(|z| self.uav.height_amsl_m - z);
        PointRow {
            along_m: p.along * unit,
            x,
            y,
            vertex: p.is_vertex,
            height_amsl_m,
            state: word(p.state),
            margin_m: p.margin_m,
            distance_m,
            elevation_deg: rise.zip(distance_m).map(|(rise, distance)| rise.atan2(distance).to_degrees()),
        }
    }

    fn as_document(&self, with_places: bool) -> Value {
        let [los, nlos, no_receiver] =
            [TrackState::Los, TrackState::Nlos, TrackState::NoReceiver].map(|s| self.length_m(s));
        let p_los = self.share();
        document_of(&TrackDocument {
            head: self.facts.head("skyshed/track/1"),
            uav: self.uav,
            rx_height_m: self.rx_height_m,
            earth_k: self.earth_k,
            every_m: self.every_m,
            length_m: Lengths { total: los + nlos + no_receiver, los, nlos, no_receiver },
            p_los,
            reason: p_los.is_none().then_some("no place of the track holds a receiver"),
            longest_without_m: self.longest_without_m(),
            stretches: with_places.then(|| self.stretches()),
            points: with_places.then(|| self.track.points.iter().map(|p| self.point(p)).collect()),
            warnings: warnings_of(&self.facts.warnings),
        })
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
        rows(self.track.points.iter().map(|p| self.point(p)))
    }

    fn warnings(&self) -> &[Warning] {
        &self.facts.warnings
    }

    fn text(&self, _: &Look) -> Result<String> {
        let length = |state| tidy(self.length_m(state));
        let n_without = self.track.stretches.iter().filter(|s| s.state == TrackState::Nlos).count();
        let share = match self.share() {
            None => "undefined: no place holds a receiver".to_string(),
            share => p_los_words(share),
        };
        let mut text = format!(
            "P_LoS along the track {share}: {} m with line of sight, {} m without in {}, the longest {} m\n",
            length(TrackState::Los),
            length(TrackState::Nlos),
            counted(n_without as u64, "stretch", "stretches"),
            tidy(self.longest_without_m())
        );
        if self.length_m(TrackState::NoReceiver) > 0.0 {
            text += &format!("{} m without a receiver\n", length(TrackState::NoReceiver));
        }
        Ok(text)
    }

    fn add(&self, batch: &mut Batch, path: &Path, format: Format, look: &Look) -> Result<()> {
        Ok(batch.add(path, &figure::draw(self, format, look)?)?)
    }
}
