//! P_LoS request of the library, which becomes a plan.

use std::path::Path;

use serde_json::Value;

use skyshed_request::{
    FilePath, IntoValue, PlosEffort, PlosOptions, PlosRequest, Receiver, SaveOptions, SceneOptions, SetPlosOptions,
    SweepOptions,
};

use super::report::PlosRow;
use super::{FORMATS, PlosPlan, PlosStudy};
use crate::answer::{Answer, CommandFacts, saved};
use crate::error::{Result, Warning};

/// Probability of line of sight over a city, by some methods, at some heights and angles or
/// distances.
///
/// ```
/// use skyshed::PLos;
/// use skyshed::prelude::*;
///
/// let p_los = PLos::of("itu:urban").height([100.0]).theta([30.0, 60.0]).run()?;
/// let values: Vec<f64> = p_los.values().filter_map(|value| value.p_los).collect();
/// assert!(values.len() == 2 && values[0] < values[1]);
/// # Ok::<(), skyshed::Error>(())
/// ```
#[derive(Debug)]
pub struct PLos(PlosStudy);

/// Request of P_LoS: cities, methods, and the quantities that vary. Traits of [`crate::prelude`] set its
/// options: [methods and users](PlosOptions), [quantities that vary](SweepOptions), [receiver](Receiver),
/// [effort](PlosEffort), [cities in files](SceneOptions). Without a height the UAV is 100 m above ground.
#[derive(Debug, Clone)]
#[must_use = "nothing is computed before `run`"]
pub struct PLosRequest {
    request: PlosRequest,
}

/// One value of P_LoS. Heights are above ground.
#[derive(Debug, Clone, PartialEq)]
pub struct PLosValue {
    /// City as the caller wrote it.
    pub city: String,
    /// Word for the method, such as `product`.
    pub method: String,
    /// Height of the UAV \[m\].
    pub height_m: f64,
    /// Elevation angle of the UAV \[deg\]; `None` if the users have several.
    pub theta_deg: Option<f64>,
    /// Ground distance of the users \[m\]; `None` if the users have several.
    pub distance_m: Option<f64>,
    /// Radius that users are within \[m\].
    pub radius_m: Option<f64>,
    /// P_LoS; `None` for a missing value.
    pub p_los: Option<f64>,
    /// Interval at the confidence of the request, 95 % by default; models and curves have none.
    pub interval: Option<(f64, f64)>,
    /// Reason for a missing value or interval.
    pub reason: Option<String>,
}

impl PLos {
    /// Requests P_LoS of a city: a generated one, such as `itu:urban` or `itu:0.3,500,15`, or the
    /// path of a file.
    pub fn of(city: impl IntoValue<FilePath>) -> PLosRequest {
        PLosRequest { request: PlosRequest::default().scenes(vec![city.into_value()]) }
    }

    /// Returns the values, city by city and method by method. Angles or distances vary fastest.
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

    /// Returns the warnings.
    pub fn warnings(&self) -> &[Warning] {
        Answer::warnings(&self.0)
    }

    /// Returns the document `skyshed/plos/1`.
    pub fn document(&self) -> Value {
        Answer::document(&self.0, None)
    }

    /// Writes a file in the format of its extension: a plot (.png .svg .pdf), a table (.csv),
    /// arrays (.npz), or a document (.json).
    ///
    /// # Errors
    /// E104–E106 for a file that cannot be written so; E124 for a plot of too much; E401 if writing
    /// fails.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<()> {
        saved(&self.0, &FORMATS, path.as_ref(), &SaveOptions::default())
    }

    /// Writes a file as `save` does, with options of pictures and of writing.
    ///
    /// # Errors
    /// As `save`; E116 for options of maps, and for a look without a picture.
    pub fn save_with(&self, path: impl AsRef<Path>, options: &SaveOptions) -> Result<()> {
        saved(&self.0, &FORMATS, path.as_ref(), options)
    }
}

skyshed_request::holds! {
    PLosRequest: request.plos PlosOptions, request.sweep SweepOptions, request.receiver Receiver, request.effort PlosEffort,
    request.reading.options SceneOptions
}

impl PLosRequest {
    /// Computes P_LoS.
    ///
    /// # Errors
    /// E113, E116, E118, E12x for an impossible request; errors of reading a city; E2xx; E5xx for
    /// too large a request.
    pub fn run(self) -> Result<PLos> {
        PlosPlan::of(&self.request, true, CommandFacts::default())?.run().map(PLos)
    }
}
