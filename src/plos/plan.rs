//! What the program asks of a P_LoS study with all defaults filled in.

use std::ffi::OsString;
use std::path::PathBuf;

use skyshed_study::Error as StudyError;
use skyshed_study::error::LosProbabilityError;

use skyshed_request::PlotKind;

use super::sweep::Sweeps;
use crate::error::{RequestError, Result, Warning};
use crate::los::MethodChoice;
use crate::los_probability::models::UserCurve;
use crate::los_probability::setting::Setting;
use crate::map::check_tolerance;
use crate::scene::SceneReader;

/// What is asked of P_LoS.
#[derive(Debug, Clone)]
pub(crate) struct PlosPlan {
    /// The cities, as they were asked for, and how those in files are read.
    pub(crate) scenes: Vec<OsString>,
    pub(crate) options: SceneReader,
    /// What varies.
    pub(crate) sweeps: Sweeps,
    /// Words for the methods.
    pub(crate) methods: Vec<String>,
    /// Curves of the user's own, and the files that they are from.
    pub(crate) curves: Vec<(UserCurve, PathBuf)>,
    /// What was said of these files.
    pub(crate) warnings: Vec<Warning>,
    /// Height of the receivers above ground \[m\].
    pub(crate) rx_height_m: f64,
    /// Whether UAVs inside of buildings are left out; else they are NLoS to all.
    pub(crate) uav_clear_of_roof: bool,
    /// Half-width of intervals that is enough.
    pub(crate) until: Option<f64>,
    /// How far any P_LoS may be off.
    pub(crate) tolerance: Option<f64>,
    /// Confidence of the intervals.
    pub(crate) confidence: f64,
    /// Cities that `city` draws, and users in each.
    pub(crate) n_cities: u64,
    pub(crate) n_users: u32,
    /// Links that `geometry` draws for each value.
    pub(crate) n_links: u64,
    /// UAV positions over a real city.
    pub(crate) n_positions: u64,
    /// Over a real city P_LoS at an angle is of users within so many degrees of it.
    pub(crate) theta_band_deg: f64,
    /// Edge of the blocks of a real city that are resampled \[m\].
    pub(crate) block_m: Option<f64>,
    pub(crate) seed: u64,
    pub(crate) plot: PlotKind,
    /// Whether a picture will be drawn, which takes more values.
    pub(crate) is_drawn: bool,
    /// Whether files are hashed whatever their size.
    pub(crate) hash: bool,
    /// The words of the command line, for documents.
    pub(crate) command: Vec<String>,
}

impl PlosPlan {
    /// Checks what does not depend on a city, before any work.
    ///
    /// # Errors
    /// E113, E116, E120.
    pub(crate) fn check(&self) -> Result<()> {
        if !(self.confidence > 0.0 && self.confidence < 1.0) {
            let (what, found, wanted) = ("the confidence", self.confidence, "above 0 and below 1");
            return Err(StudyError::from(LosProbabilityError::OutOfRange { what, found, wanted }).into());
        }
        // Each height must be possible with the receivers', whatever the sweep.
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
