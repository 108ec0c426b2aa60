//! Plan of a P_LoS study: the request with all defaults filled in.

use std::ffi::OsString;
use std::path::PathBuf;

use skyshed_study::Error as StudyError;
use skyshed_study::error::LosProbabilityError;

use skyshed_request::{PlosRequest, PlotKind};

use super::read_curves;
use crate::answer::CommandFacts;

use super::sweep::Sweeps;
use crate::error::{RequestError, Result, Warning};
use crate::los::MethodChoice;
use crate::los_probability::models::UserCurve;
use crate::los_probability::setting::Setting;
use crate::map::check_tolerance;
use crate::scene::{SceneReader, built_up};

/// Plan of a P_LoS study.
#[derive(Debug, Clone)]
pub(crate) struct PlosPlan {
    /// Cities, as the user wrote them.
    pub(crate) scenes: Vec<OsString>,
    pub(crate) options: SceneReader,
    /// Quantities that vary.
    pub(crate) sweeps: Sweeps,
    /// Words for the methods.
    pub(crate) methods: Vec<String>,
    /// Curves of the user, and their files.
    pub(crate) curves: Vec<(UserCurve, PathBuf)>,
    /// Warnings about these files.
    pub(crate) warnings: Vec<Warning>,
    /// Height of the receivers above ground \[m\].
    pub(crate) rx_height_m: f64,
    /// `true` if UAVs inside buildings are left out. Otherwise they count as NLoS.
    pub(crate) uav_clear_of_roof: bool,
    /// Half-width at which intervals are narrow enough.
    pub(crate) until: Option<f64>,
    /// Largest allowed error of any P_LoS.
    pub(crate) tolerance: Option<f64>,
    /// Confidence of the intervals.
    pub(crate) confidence: f64,
    /// Numbers of cities that `city` draws, and of users in each.
    pub(crate) n_cities: u64,
    pub(crate) n_users: u32,
    /// Number of links that `geometry` draws for each value.
    pub(crate) n_links: u64,
    /// Number of UAV positions over a real city.
    pub(crate) n_positions: u64,
    /// Half-width of the band of elevation angles whose users count over a real city \[deg\].
    pub(crate) theta_band_deg: f64,
    /// Edge of the blocks of a real city that are resampled \[m\].
    pub(crate) block_m: Option<f64>,
    pub(crate) seed: u64,
    pub(crate) plot: PlotKind,
    /// `true` if a picture will be drawn, which needs more values.
    pub(crate) is_drawn: bool,
    /// `true` if input files of any size are hashed.
    pub(crate) hash: bool,
    /// Words of the command line, for documents.
    pub(crate) command: CommandFacts,
}

impl PlosPlan {
    /// Checks a request, reads its curves and fills in its defaults.
    ///
    /// # Errors
    /// E113, E116, E12x; errors of the curves.
    pub(crate) fn of(request: &PlosRequest, is_drawn: bool, command: CommandFacts) -> Result<PlosPlan> {
        let PlosRequest { plos, sweep, receiver, effort, reading, plot, .. } = request;
        let scenes: Vec<OsString> = plos.scenes.iter().map(|word| word.as_os_str().to_os_string()).collect();
        request.check(scenes.iter().any(|word| built_up(word).is_none()), is_drawn)?;
        let mut warnings = Vec::new();
        let words: Vec<OsString> = plos.curve.iter().map(|word| word.as_os_str().to_os_string()).collect();
        let curves = read_curves(&words, plos.skip_bad, &mut warnings)?;
        let defaults = PlosRequest::defaults();
        let plan = PlosPlan {
            scenes,
            options: reading.options.clone().into(),
            sweeps: Sweeps::of(sweep, &defaults.sweep)?,
            methods: request.methods(),
            curves,
            warnings,
            rx_height_m: receiver.rx_height_m(),
            uav_clear_of_roof: sweep.uav_clear_of_roof,
            until: effort.until,
            tolerance: effort.tolerance,
            confidence: request.number(|effort| effort.ci),
            n_cities: request.number(|effort| effort.cities),
            n_users: request.number(|effort| effort.users_per_city),
            n_links: request.number(|effort| effort.links),
            n_positions: request.number(|effort| effort.positions),
            theta_band_deg: request.number(|effort| effort.theta_band),
            block_m: effort.block,
            seed: reading.options.seed_or_default(),
            plot: plot.plot.unwrap_or_default(),
            is_drawn,
            hash: reading.options.hash,
            command,
        };
        plan.check()?;
        Ok(plan)
    }

    /// Checks everything that does not depend on a city, before any work.
    ///
    /// # Errors
    /// E113, E116, E120.
    pub(crate) fn check(&self) -> Result<()> {
        if !(self.confidence > 0.0 && self.confidence < 1.0) {
            let (what, found, wanted) = ("the confidence", self.confidence, "above 0 and below 1");
            return Err(StudyError::from(LosProbabilityError::OutOfRange { what, found, wanted }).into());
        }
        // Every height must be above the receivers.
        for height in &self.sweeps.heights {
            Setting::reach_at_distance(0.0, *height, self.rx_height_m)?;
        }
        check_tolerance(self.tolerance, MethodChoice::Auto)?;
        let has_bound = |m: &String| ["auto", "product", "maps", "sweep", "shadow", "ray"].contains(&m.trim());
        if self.tolerance.is_some() && !self.methods.iter().all(has_bound) {
            return Err(RequestError::ToleranceWithoutBound.into());
        }
        Ok(())
    }
}
