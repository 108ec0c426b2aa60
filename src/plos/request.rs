//! What a caller of the library asks of P_LoS, setting by setting: it becomes a plan.

use std::ffi::OsString;
use std::path::Path;

use serde_json::Value;

use skyshed_request::{Placement, Users};

use super::report::PlosRow;
use skyshed_request::PlotKind;

use super::{FORMATS, Far, PlosPlan, PlosStudy, Sweeps};
use crate::answer::{Answer, Spent, add_outputs};
use crate::error::{Result, Warning};
use crate::export::{Batch, OutputRules, check_outputs};
use crate::picture::Look;
use crate::scene::SceneReader;

/// The probability of line of sight over a city, by some methods, at some heights and angles or distances.
///
/// ```
/// use skyshed::PLos;
///
/// let p_los = PLos::of("itu:urban").heights_m([100.0]).theta_deg([30.0, 60.0]).run()?;
/// let values: Vec<f64> = p_los.values().filter_map(|value| value.p_los).collect();
/// assert!(values.len() == 2 && values[0] < values[1]);
/// # Ok::<(), skyshed::Error>(())
/// ```
#[derive(Debug)]
pub struct PLos(PlosStudy);

/// What is asked of P_LoS: cities, methods, and what varies.
#[derive(Debug, Clone)]
#[must_use = "nothing is computed before `run`"]
pub struct PLosRequest(PlosPlan);

/// One value of P_LoS. Heights are above ground.
#[derive(Debug, Clone, PartialEq)]
pub struct PLosValue {
    /// The city as it was named.
    pub city: String,
    /// The method's word, such as `product`.
    pub method: String,
    /// Height of the UAV \[m\].
    pub height_m: f64,
    /// Elevation angle of the UAV \[deg\]; `None` for users at many.
    pub theta_deg: Option<f64>,
    /// Ground distance of the users \[m\]; `None` for users at many.
    pub distance_m: Option<f64>,
    /// Radius that users are within \[m\].
    pub radius_m: Option<f64>,
    /// P_LoS, if there is one.
    pub p_los: Option<f64>,
    /// Its 95 % interval; models and curves have none.
    pub interval: Option<(f64, f64)>,
    /// Why a value or its interval is missing.
    pub reason: Option<String>,
}

impl PLos {
    /// Asks for P_LoS of a city: a generated one, such as `itu:urban` or `itu:0.3,500,15`, or one of a file.
    pub fn of(city: impl Into<OsString>) -> PLosRequest {
        PLosRequest(PlosPlan {
            scenes: vec![city.into()],
            options: SceneReader::default(),
            sweeps: Sweeps {
                placements: vec![Placement::Anywhere],
                users: vec![Users::Outdoor],
                alphas: None,
                betas: None,
                gammas: None,
                heights: vec![100.0],
                phis: vec![None],
                far: Far::every_five_degrees(),
            },
            methods: vec!["auto".into()],
            curves: Vec::new(),
            warnings: Vec::new(),
            rx_height_m: 1.5,
            uav_clear_of_roof: false,
            until: None,
            tolerance: None,
            confidence: 0.95,
            n_cities: 500,
            n_users: 360,
            n_links: 20_000,
            n_positions: 200,
            theta_band_deg: 2.5,
            block_m: None,
            seed: 1,
            plot: PlotKind::Auto,
            is_drawn: true,
            hash: false,
            command: Vec::new(),
        })
    }

    /// The values, city by city and method by method; angles or distances run fastest.
    pub fn values(&self) -> impl ExactSizeIterator<Item = PLosValue> {
        self.0.report.rows.iter().map(|row: &PlosRow| PLosValue {
            city: row.city.clone(),
            method: row.method.clone(),
            height_m: row.height_m,
            theta_deg: row.theta_deg,
            distance_m: row.distance_m,
            radius_m: row.radius_m,
            p_los: row.p_los(),
            interval: row.estimate().and_then(|e| e.interval),
            reason: row.reason(),
        })
    }

    /// What was odd.
    pub fn warnings(&self) -> &[Warning] {
        Answer::warnings(&self.0)
    }

    /// The document `skyshed/plos/1`.
    pub fn document(&self) -> Value {
        Answer::document(&self.0, None)
    }

    /// Writes a file, whose extension says what: a plot (.png .svg .pdf), a table (.csv), arrays (.npz), a document
    /// (.json).
    ///
    /// # Errors
    /// E104–E106 for a file that cannot be written so; E124 for a plot of too much; E401 if writing fails.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<()> {
        let rules = OutputRules { allowed: &FORMATS, inputs: &[], overwrite: false, bare: false };
        let outputs = check_outputs(&[path.as_ref().into()], rules)?;
        let mut batch = Batch::new(false);
        add_outputs(&self.0, &mut batch, &outputs, (&Look::default(), Spent::default()))?;
        Ok(batch.commit().map(|_| ())?)
    }
}

impl PLosRequest {
    /// Methods: `product`, `city`, `geometry`, `maps` of a city in a file, published models by their ids, `models` for all
    /// that apply; the product, and maps over a city in a file.
    pub fn methods(mut self, methods: impl IntoIterator<Item = impl Into<String>>) -> Self {
        self.0.methods = methods.into_iter().map(Into::into).collect();
        self
    }

    /// Heights of the UAV above ground \[m\]. Default: 100.
    pub fn heights_m(mut self, heights: impl IntoIterator<Item = f64>) -> Self {
        self.0.sweeps.heights = heights.into_iter().collect();
        self
    }

    /// Elevation angles \[deg\]. Default: every five from 5 to 90.
    pub fn theta_deg(mut self, angles: impl IntoIterator<Item = f64>) -> Self {
        self.0.sweeps.far = angles.into_iter().map(Far::Theta).collect();
        self
    }

    /// Ground distances \[m\], instead of angles.
    pub fn distances_m(mut self, distances: impl IntoIterator<Item = f64>) -> Self {
        self.0.sweeps.far = distances.into_iter().map(Far::Distance).collect();
        self
    }

    /// Radii \[m\]: users over the whole area within, instead of at an angle.
    pub fn radii_m(mut self, radii: impl IntoIterator<Item = f64>) -> Self {
        self.0.sweeps.far = radii.into_iter().map(Far::Radius).collect();
        self
    }

    /// The height of the receivers above ground \[m\]. Default: 1.5.
    pub fn receiver_height_m(mut self, height_m: f64) -> Self {
        self.0.rx_height_m = height_m;
        self
    }

    /// How a city in a file is read.
    pub fn scene_options(mut self, options: SceneReader) -> Self {
        self.0.options = options;
        self
    }

    /// The seed of everything random. Default: 1.
    pub fn seed(mut self, seed: u64) -> Self {
        self.0.seed = seed;
        self
    }

    /// Computes.
    ///
    /// # Errors
    /// E113, E116, E118, E12x for what cannot be asked; those of reading a city; E2xx; E5xx for what takes too much.
    pub fn run(mut self) -> Result<PLos> {
        self.0.sweeps = self.0.sweeps.checked()?;
        self.0.run().map(PLos)
    }
}
