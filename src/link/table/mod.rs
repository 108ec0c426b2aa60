//! Links between lists of UAVs and receivers.

mod files;

use rayon::prelude::*;

use super::{ObstacleFacts, check_extent, end_of};
use crate::answer::{CommandFacts, RunFacts};
use crate::coverage::{self, ExplainedLink, SceneView, place_receiver};
use crate::earth::warn_of_drop;
use crate::error::{Error, LimitError, Result, warned};
use crate::export::Format;
use crate::height_field::{Curvature, Station};
use crate::los::Method;
use crate::quantity::Height;
use crate::read::{Vertex, read_paths, source_of};
use crate::scene::Scene;
use crate::scene::placing::{place_uav, warn_of_uavs_outside};
use crate::sight::SightPlan;
use crate::track::{home_ground, resolved};
use crate::uav::UavsFound;
use skyshed_io::Input;
use skyshed_request::{LinkRequest, Range, Sight};

pub use files::LinkArray;
pub(crate) use files::{LinkRow, LinksDocument};

/// Output formats of many links.
pub(crate) const TABLE_FORMATS: [Format; 5] = [Format::Csv, Format::Json, Format::GeoJson, Format::Npz, Format::Stdout];

/// Most links of one table.
const MOST_LINKS: usize = 20_000_000;

/// A receiver that is asked for.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct AskedReceiver {
    pub(crate) id: String,
    pub(crate) at: (f64, f64),
    pub(crate) height: Height,
}

/// Plan of links between lists.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LinksPlan {
    /// `true` if the k-th UAV is linked with the k-th receiver alone.
    pub(crate) are_pairs: bool,
    /// `true` if margins and obstacles are not asked for.
    pub(crate) los_only: bool,
    pub(crate) sight: SightPlan,
}

/// An end of links, or the reason why it cannot be there.
#[derive(Debug, Clone)]
struct End<T> {
    id: String,
    at: (f64, f64),
    placed: std::result::Result<T, String>,
}

/// Links between lists of UAVs and receivers, UAV by UAV.
#[derive(Debug)]
pub(crate) struct LinkTable {
    scene: Scene,
    facts: RunFacts,
    curvature: Option<Curvature>,
    are_pairs: bool,
    uavs: Vec<End<coverage::Uav>>,
    receivers: Vec<End<Station>>,
    links: Vec<Decided>,
}

/// One link of a table.
#[derive(Debug, Clone)]
enum Decided {
    /// Line of sight alone was asked for.
    Plain(bool),
    Explained(ExplainedLink),
    /// An end cannot be there, or is out of range.
    None(NoLink),
}

/// Reason for having no answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum NoLink {
    Uav,
    Receiver,
    OutOfRange,
}

impl Decided {
    fn los(&self) -> Option<bool> {
        match self {
            Decided::Plain(los) => Some(*los),
            Decided::Explained(link) => Some(link.los),
            Decided::None(_) => None,
        }
    }

    fn explained(&self) -> Option<&ExplainedLink> {
        match self {
            Decided::Explained(link) => Some(link),
            _ => None,
        }
    }
}

impl LinksPlan {
    /// Checks the question of a request.
    ///
    /// # Errors
    /// E113 for numbers out of range; E116 for two options that set the curve of the earth.
    pub(crate) fn of(request: &LinkRequest) -> Result<LinksPlan> {
        let LinkRequest { link, receiver, earth, .. } = request;
        let range = Range { radius: link.radius, ..Range::default() };
        let sight = SightPlan::of(&Sight { receiver: *receiver, range, earth: *earth, ..Sight::default() })?;
        Ok(LinksPlan { are_pairs: link.pairs, los_only: link.los_only, sight })
    }

    /// Reads the receivers of a file, of which nameless ones are numbered from `first`. Those without a
    /// height are at that of the run.
    ///
    /// # Errors
    /// Errors of the file; E204 for heights above a home without a known ground.
    pub(crate) fn read_receivers(
        &self,
        (table, skips_bad, hash): (&Input, bool, bool),
        first: usize,
        scene: &mut Scene,
    ) -> Result<Vec<AskedReceiver>> {
        let crs = scene.grid().crs().cloned();
        let paths = warned(&mut scene.warnings, |odd| read_paths(table, crs.as_ref(), (skips_bad, odd)))?;
        scene.sources.push(source_of(table, hash)?);
        let home = home_ground(&scene.field, paths.home)?;
        let receiver = |(k, vertex): (usize, Vertex)| {
            let own = vertex.height.map(|height| resolved(height, home));
            let height = own.unwrap_or(Height::AboveGround(self.sight.rx_height_m()));
            let id = vertex.name.unwrap_or_else(|| (first + k).to_string());
            AskedReceiver { id, at: (vertex.x, vertex.y), height }
        };
        Ok(paths.into_places().into_iter().enumerate().map(receiver).collect())
    }

    /// Decides the links over a scene. An end that cannot be there has rows without an answer.
    ///
    /// # Errors
    /// E116 for pairs of lists of unequal lengths; E203 for links longer than the lattice; E502 for too many
    /// links.
    pub(crate) fn decide(
        &self,
        mut scene: Scene,
        (found, receivers): (&UavsFound, &[AskedReceiver]),
        command: CommandFacts,
    ) -> Result<LinkTable> {
        let (n_uavs, n_receivers) = (found.sites.len(), receivers.len());
        if self.are_pairs && n_uavs != n_receivers {
            let why = format!("for {n_uavs} UAVs and {n_receivers} receivers: wanted as many of both");
            return Err(Error::idle("pairs", why));
        }
        let n_links = if self.are_pairs { n_uavs } else { n_uavs.saturating_mul(n_receivers) };
        if n_links > MOST_LINKS {
            return Err(LimitError::Links { n_uavs, n_receivers, most: MOST_LINKS }.into());
        }
        let found = &*found.over(&scene.field)?;
        scene.warnings.extend(found.warnings.iter().cloned());
        scene.sources.extend(found.sources.iter().cloned());
        warn_of_uavs_outside(&found.sites, scene.field.grid(), &mut scene.warnings);
        let span = Span::of(found, receivers);
        check_extent(&scene, &found.sites[span.longest.0].site, receivers[span.longest.1].at)?;
        let unit = scene.grid().meters_per_unit();
        let curvature = self.sight.curvature();
        if curvature.is_none() {
            warn_of_drop(span.reach * unit, &mut scene.warnings);
        }
        let place = |given: &crate::city::GivenSite| End {
            id: given.id.clone(),
            at: (given.x, given.y),
            placed: place_uav(&given.site, &scene.field, scene.grid(), Some(span.reach)).map_err(|e| e.to_string()),
        };
        let uavs: Vec<End<coverage::Uav>> = found.sites.iter().map(place).collect();
        let placed = |asked: &AskedReceiver| End {
            id: asked.id.clone(),
            at: asked.at,
            placed: place_receiver(&scene.field, asked.at, asked.height).map_err(|why| why.to_string()),
        };
        let receivers: Vec<End<Station>> = receivers.iter().map(placed).collect();
        let links = self.links(&scene, &uavs, &receivers)?;
        Ok(LinkTable {
            facts: RunFacts { command, ..scene.facts(Some(Method::Ray)) },
            curvature,
            are_pairs: self.are_pairs,
            uavs,
            receivers,
            links,
            scene,
        })
    }

    fn links(&self, scene: &Scene, uavs: &[End<coverage::Uav>], receivers: &[End<Station>]) -> Result<Vec<Decided>> {
        let (unit, radius_m) = (scene.grid().meters_per_unit(), self.sight.radius_m());
        let decide = |view: &SceneView<'_>, receiver: &End<Station>| {
            let Ok(station) = &receiver.placed else { return Decided::None(NoLink::Receiver) };
            let from = &view.uav().station.place;
            let distance_m = (station.place.x - from.x).hypot(station.place.y - from.y) * unit;
            match radius_m {
                Some(radius_m) if distance_m > radius_m => Decided::None(NoLink::OutOfRange),
                _ if self.los_only => Decided::Plain(view.sees(station)),
                _ => Decided::Explained(view.link(station)),
            }
        };
        let of_uav = |(k, uav): (usize, &End<coverage::Uav>)| -> Result<Vec<Decided>> {
            let wanted = if self.are_pairs { &receivers[k..=k] } else { receivers };
            let Ok(uav) = &uav.placed else { return Ok(vec![Decided::None(NoLink::Uav); wanted.len()]) };
            let view = SceneView::of(&scene.field, uav, self.sight.curvature())?;
            Ok(wanted.par_iter().map(|receiver| decide(&view, receiver)).collect())
        };
        let of_uavs: Vec<Vec<Decided>> = uavs.par_iter().enumerate().map(of_uav).collect::<Result<_>>()?;
        Ok(of_uavs.into_iter().flatten().collect())
    }
}

/// Longest distance between the ends of links.
struct Span {
    /// Longest distance along an axis \[CRS units\].
    reach: f64,
    /// A UAV and a receiver that are so far apart.
    longest: (usize, usize),
}

impl Span {
    fn of(found: &UavsFound, receivers: &[AskedReceiver]) -> Span {
        let mut span = Span { reach: 1.0, longest: (0, 0) };
        for axis in [|x: f64, _: f64| x, |_: f64, y: f64| y] {
            let uavs = found.sites.iter().map(|site| axis(site.x, site.y));
            let ends = receivers.iter().map(|receiver| axis(receiver.at.0, receiver.at.1));
            let extremes = |values: &mut dyn Iterator<Item = f64>| {
                let mut all: Vec<(usize, f64)> = values.enumerate().collect();
                all.sort_by(|a, b| a.1.total_cmp(&b.1));
                all.first().copied().zip(all.last().copied())
            };
            let (Some(a), Some(b)) = (extremes(&mut { uavs }), extremes(&mut { ends })) else { continue };
            for (uav, receiver) in [(a.0, b.1), (a.1, b.0)] {
                let reach = (uav.1 - receiver.1).abs();
                if reach > span.reach {
                    span = Span { reach, longest: (uav.0, receiver.0) };
                }
            }
        }
        span
    }
}
