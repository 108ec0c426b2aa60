//! UAVs from the command line and from tables, and rows that are left out of these.

use std::path::Path;

use super::plan::parse_uav;
use crate::error::{Error, Result, Warning};
use crate::raster::GeoRef;
use crate::read::source_of;
use crate::read::{BadRows, read_sites};
use crate::scene::{GivenSite, Site, Source};

/// Where the UAVs of a run are told.
#[derive(Debug, Clone, Copy)]
pub(super) struct UavsAsked<'a> {
    /// As typed: `X,Y,H`.
    pub(super) typed: &'a [String],
    pub(super) table: Option<&'a Path>,
    /// Whether rows of the table that cannot be read are left out.
    pub(super) skip_bad: bool,
    /// Whether the table is hashed whatever its size.
    pub(super) hash: bool,
}

/// The UAVs of a run, with the table that they are from and what was said of it.
#[derive(Debug, Clone, Default)]
pub(super) struct UavsFound {
    pub(super) sites: Vec<GivenSite>,
    pub(super) sources: Vec<Source>,
    pub(super) warnings: Vec<Warning>,
}

impl UavsAsked<'_> {
    /// Those of the command line.
    pub(super) fn typed_sites(&self) -> Result<Vec<Site>> {
        self.typed.iter().enumerate().map(|(k, text)| parse_uav(text, (k + 1).to_string())).collect()
    }

    /// Typed sites, then those of the table; ids must differ.
    pub(super) fn read(&self, grid: &GeoRef) -> Result<UavsFound> {
        let typed = self.typed_sites()?.into_iter().map(GivenSite::from);
        let mut found = UavsFound { sites: typed.collect(), ..UavsFound::default() };
        if let Some(path) = self.table {
            let first = found.sites.len() + 1;
            found.sites.extend(read_sites(path, grid, first, bad_rows(self.skip_bad, &mut found.warnings))?);
            found.sources.push(source_of(path, self.hash)?);
        }
        let mut seen = std::collections::HashSet::new();
        match found.sites.iter().find(|site| !seen.insert(site.id.as_str())) {
            Some(twice) => Err(Error::site(207, format!("two sites are named `{}`, wanted different ids", twice.id))),
            None => Ok(found),
        }
    }
}

/// What becomes of bad rows: `--skip-bad` leaves them out.
pub(super) fn bad_rows(skip_bad: bool, warnings: &mut Vec<Warning>) -> BadRows<'_> {
    if skip_bad { BadRows::LeaveOut(warnings) } else { BadRows::Refuse }
}
