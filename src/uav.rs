//! The library's `Uav`, and the UAVs of a command line or a table before a scene is known.

use std::borrow::Cow;
use std::collections::HashSet;
use std::path::PathBuf;

use skyshed_io::Input;
use skyshed_request::{BadUavs, Position, Shard, Uavs};

use crate::city::{Antenna, Clock, GivenSite, Site, Source, UpTime};
use crate::error::{Error, PlacesError, RequestError, Result, Warning, warned};
use crate::height_field::HeightField;
use crate::quantity::Height;
use crate::raster::GeoRef;
use crate::read::{BadRows, VertexHeight, is_path_file, read_paths, read_sites, source_of};
use crate::track::{home_ground, resolved};

/// A UAV: a position in the scene's reference system and a height.
///
/// ```
/// use skyshed::{Height, Uav};
///
/// let uav = Uav::new(691_549.7, 5_334_762.2, Height::agl(120.0)).named("north tower");
/// assert_eq!(uav.id(), Some("north tower"));
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Uav {
    id: Option<String>,
    x: f64,
    y: f64,
    height: Height,
    antenna: Antenna,
    up: Option<UpTime>,
    lonlat: Option<[f64; 2]>,
}

impl Uav {
    /// Returns a UAV at x (east) and y (north) in the scene's reference system. UAVs without a name
    /// are numbered from 1.
    ///
    /// The place is checked when a question is run: E2xx if the UAV cannot be there.
    pub fn new(x: f64, y: f64, height: Height) -> Uav {
        Uav { id: None, x, y, height, antenna: Antenna::default(), up: None, lonlat: None }
    }

    /// Sets the name in tables and pictures.
    #[must_use]
    pub fn named(self, id: impl Into<String>) -> Uav {
        Uav { id: Some(id.into()), ..self }
    }

    /// Sets an antenna of the UAV's own. The request may limit what this antenna does not.
    #[must_use]
    pub fn with_antenna(self, antenna: Antenna) -> Uav {
        Uav { antenna, ..self }
    }

    /// Sets the time in which the UAV is up. Without one it always is.
    #[must_use]
    pub fn up(self, up: Option<UpTime>) -> Uav {
        Uav { up, ..self }
    }

    /// Returns the name; `None` without one.
    pub fn id(&self) -> Option<&str> {
        self.id.as_deref()
    }

    /// Returns east and north \[CRS units\].
    pub fn position(&self) -> (f64, f64) {
        (self.x, self.y)
    }

    /// Returns the height and its reference.
    pub fn height(&self) -> Height {
        self.height
    }

    /// Returns the UAV's own antenna.
    pub fn antenna(&self) -> Antenna {
        self.antenna
    }

    /// Returns the site of the `k`-th of several UAVs, counted from 0.
    pub(crate) fn site(&self, k: usize) -> GivenSite {
        let id = self.id.clone().unwrap_or_else(|| (k + 1).to_string());
        let site = Site { antenna: self.antenna, up: self.up, ..Site::new(id, (self.x, self.y), self.height) };
        GivenSite { site, lonlat: self.lonlat }
    }
}

impl From<GivenSite> for Uav {
    fn from(given: GivenSite) -> Uav {
        let GivenSite { site: Site { id, x, y, height, antenna, up }, lonlat } = given;
        Uav { id: Some(id), x, y, height, antenna, up, lonlat }
    }
}

/// UAVs of a run, with their table and its warnings.
#[derive(Debug, Clone, Default)]
pub(crate) struct UavsFound {
    pub(crate) sites: Vec<GivenSite>,
    pub(crate) sources: Vec<Source>,
    pub(crate) warnings: Vec<Warning>,
    /// Treatment of those that cannot be at their place.
    pub(crate) bad: BadUavs,
    /// Place where the mission begins that the heights of some are above.
    pub(crate) home: Option<Home>,
}

/// Place where a mission begins.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Home {
    /// East and north \[CRS units\].
    at: [f64; 2],
    /// UAVs whose heights are above the ground there, not above their own.
    ids: HashSet<String>,
}

impl UavsFound {
    /// Returns the UAVs with heights that do not hang on the place where a mission begins.
    ///
    /// # Errors
    /// E204 if no ground is known there.
    pub(crate) fn over(&self, field: &HeightField) -> Result<Cow<'_, UavsFound>> {
        let Some(Home { at, ids }) = &self.home else { return Ok(Cow::Borrowed(self)) };
        let ground = home_ground(field, Some(*at))?;
        let site = |given: &GivenSite| match ids.contains(&given.id) {
            false => given.clone(),
            true => {
                let height = resolved(VertexHeight::AboveHome(given.height.value()), ground);
                GivenSite { site: Site { height, ..given.site.clone() }, ..given.clone() }
            }
        };
        let sites = self.sites.iter().map(site).collect();
        Ok(Cow::Owned(UavsFound { sites, home: None, ..self.clone() }))
    }

    /// Returns the UAVs of a list.
    ///
    /// # Errors
    /// E113 for an antenna with impossible values; E207 for two UAVs of one name.
    pub(crate) fn of(uavs: &[Uav]) -> Result<UavsFound> {
        for uav in uavs {
            uav.antenna.checked().map_err(RequestError::Antenna)?;
        }
        let sites = uavs.iter().enumerate().map(|(k, uav)| uav.site(k)).collect();
        UavsFound { sites, ..UavsFound::default() }.checked()
    }

    /// Returns longitude and latitude of the UAV of an id, if it was given by these.
    pub(crate) fn lonlat_of(&self, id: &str) -> Option<[f64; 2]> {
        self.sites.iter().find(|site| site.id == id)?.lonlat
    }

    /// Refuses two UAVs of one name, and times of different clocks.
    ///
    /// # Errors
    /// E207, E210.
    pub(crate) fn checked(self) -> Result<UavsFound> {
        let mut seen = HashSet::new();
        if let Some(twice) = self.sites.iter().find(|site| !seen.insert(site.id.as_str())) {
            return Err(PlacesError::Twice { what: "sites", id: twice.id.clone() }.into());
        }
        let mut timed = self.sites.iter().filter_map(|site| Some((&site.id, site.up?.clock)));
        let first = timed.next();
        match first.and_then(|(id, clock)| timed.find(|(_, other)| *other != clock).map(|b| [(id, clock), b])) {
            Some(two) => Err(PlacesError::Clocks(two.map(|(id, clock)| (id.clone(), clock.name()))).into()),
            None => Ok(self),
        }
    }

    /// Returns the span of the times in which UAVs are up \[s\], and its clock; `None` without two moments.
    pub(crate) fn span(&self) -> Option<([f64; 2], Clock)> {
        let all = || self.sites.iter().filter_map(|site| site.up);
        UpTime::span(all()).zip(all().next().map(|up| up.clock))
    }
}

/// Sources of the UAVs of a run.
#[derive(Debug, Clone)]
pub(crate) struct UavsAsked {
    /// UAVs that were typed one by one.
    pub(crate) typed: Vec<Site>,
    pub(crate) table: Option<Input>,
    /// `true` if rows of the table that cannot be read are left out.
    pub(crate) skips_bad: bool,
    /// Treatment of UAVs that cannot be at their place.
    pub(crate) bad: BadUavs,
    /// `true` if the table is hashed, however large it is.
    pub(crate) hash: bool,
    /// Part of the UAVs; `None` for all of them.
    pub(crate) shard: Option<Shard>,
}

impl UavsAsked {
    /// Returns the sources of the UAVs of a question, and checks the typed UAVs.
    ///
    /// # Errors
    /// E102; E116 for bad rows without a table.
    pub(crate) fn of(uavs: &Uavs, hash: bool) -> Result<UavsAsked> {
        if uavs.skip_bad && uavs.uavs.is_none() {
            return Err(Error::idle("skip_bad", "without a table of UAVs"));
        }
        let typed = uavs.uav.iter().enumerate().map(|(k, text)| site_of(text, (k + 1).to_string()));
        let table = uavs.uavs.as_ref().map(Input::of);
        Ok(UavsAsked {
            typed: typed.collect::<Result<_>>()?,
            table,
            skips_bad: uavs.skip_bad,
            bad: uavs.bad_uavs.unwrap_or_default(),
            hash,
            shard: None,
        })
    }

    /// Returns the sources of the UAVs of a question, and refuses a question without any.
    ///
    /// # Errors
    /// E102, E108.
    pub(crate) fn some_of(uavs: &Uavs, hash: bool) -> Result<UavsAsked> {
        match uavs.uav.is_empty() && uavs.uavs.is_none() {
            true => Err(RequestError::NoUav.into()),
            false => UavsAsked::of(uavs, hash),
        }
    }

    /// Returns UAVs that the caller holds.
    ///
    /// # Errors
    /// E108 for none; E113 for an antenna with impossible values; E207 for two UAVs of one name.
    pub(crate) fn held(uavs: &[Uav]) -> Result<UavsAsked> {
        if uavs.is_empty() {
            return Err(RequestError::NoUav.into());
        }
        let typed = UavsFound::of(uavs)?.sites.into_iter().map(|given| given.site).collect();
        Ok(UavsAsked { typed, table: None, skips_bad: false, bad: BadUavs::default(), hash: false, shard: None })
    }

    /// Returns the table, if it is a file.
    pub(crate) fn file(&self) -> Option<PathBuf> {
        self.table.as_ref().and_then(Input::file).map(PathBuf::from)
    }

    /// Reads the UAVs: typed ones first, then those of the table. Ids must differ.
    ///
    /// # Errors
    /// E207; errors of the table.
    pub(crate) fn read(&self, grid: &GeoRef) -> Result<UavsFound> {
        let typed = self.typed.iter().cloned().map(GivenSite::from);
        let mut found = UavsFound { sites: typed.collect(), bad: self.bad, ..UavsFound::default() };
        if let Some(table) = &self.table {
            let first = found.sites.len() + 1;
            if is_path_file(table)? {
                let (sites, home) = self.read_vertices(table, (grid, first), &mut found.warnings)?;
                found.sites.extend(sites);
                found.home = home;
            } else {
                let read = |odd: &mut _| read_sites(table, grid, first, bad_rows(self.skips_bad, odd));
                found.sites.extend(warned(&mut found.warnings, read)?);
            }
            found.sources.push(source_of(table, self.hash)?);
        }
        let found = found.checked()?;
        Ok(match self.shard {
            Some(shard) => UavsFound { sites: shard.part(found.sites), ..found },
            None => found,
        })
    }

    /// Reads the points of a path or a mission as UAVs, and without any the vertices of its lines.
    fn read_vertices(
        &self,
        table: &Input,
        (grid, first): (&GeoRef, usize),
        warnings: &mut Vec<Warning>,
    ) -> Result<(Vec<GivenSite>, Option<Home>)> {
        let paths = warned(warnings, |odd| read_paths(table, grid.crs(), (self.skips_bad, odd)))?;
        let home = paths.home;
        let vertices = paths.into_places();
        let (mut sites, mut ids) = (Vec::new(), HashSet::new());
        for (k, vertex) in vertices.into_iter().enumerate() {
            let id = vertex.name.unwrap_or_else(|| (first + k).to_string());
            let height = match vertex.height {
                Some(VertexHeight::Own(height)) => height,
                Some(VertexHeight::AboveHome(m)) => {
                    ids.insert(id.clone());
                    Height::AboveGround(m)
                }
                None => return Err(PlacesError::NoHeight { file: table.to_string(), id }.into()),
            };
            sites.push(GivenSite { site: Site::new(id, (vertex.x, vertex.y), height), lonlat: vertex.lonlat });
        }
        let home = home.filter(|_| !ids.is_empty()).map(|at| Home { at, ids });
        Ok((sites, home))
    }
}

/// Reads a UAV from its words `X,Y,H`.
///
/// # Errors
/// E102.
pub(crate) fn site_of(text: &str, id: String) -> Result<Site> {
    let Position { x, y, height } = text.parse().map_err(|found| RequestError::Uav { text: text.into(), found })?;
    Ok(Site::new(id, (x, y), height))
}

/// Returns the treatment of bad rows of a table.
pub(crate) fn bad_rows(skips: bool, warnings: &mut Vec<skyshed_io::Warning>) -> BadRows<'_> {
    if skips { BadRows::LeaveOut(warnings) } else { BadRows::Refuse }
}
