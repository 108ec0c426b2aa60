//! Report of a P_LoS study: values, methods, tolerances; and the document and table made of them.

use serde_json::Value;

use super::document::{
    FitDocument, MethodFacts, NumberOr, PlosDocument, PlosRowDocument, PlosTableRow, ProductToleranceDocument,
    RealCityDocument, SettingDocument, ToleranceDocument, TotalTiming, TriedDocument, ValuesDocument,
};
use crate::accuracy::{CONFIDENCE, Simpler};
use crate::answer::{CommandFacts, Rows, SourceFacts, Spent, digest_words, document_of, rows, warnings_of};
use crate::city::{BuiltUp, Source};
use crate::city_statistics::fit::BuiltUpFit;
use crate::digest::Sha256;
use crate::error::Warning;
use crate::los::Method;
use crate::los_probability::estimate::{Estimate, FEWEST_CLUSTERS, student_quantile};
use crate::los_probability::product::SHIFTS;
use crate::map::FormDocument;
use crate::quantity::tidy;
use crate::words::version;

/// Result of a method.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum PlosValue {
    /// An estimate with its interval.
    Estimate(Estimate),
    /// Value of a model, which has no error of its own.
    Model(f64),
    /// No value, and the reason.
    None(String),
}

/// One value of P_LoS and its setting. Heights are above ground.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PlosRow {
    /// City as the user wrote it.
    pub(crate) city: String,
    /// Built-up parameters; estimated ones for a real city.
    pub(crate) built_up: Option<BuiltUp>,
    /// Word for the method.
    pub(crate) method: String,
    /// Height of the UAV \[m\].
    pub(crate) height_m: f64,
    /// Height of the receivers \[m\].
    pub(crate) rx_height_m: f64,
    /// Elevation angle \[deg\]; `None` if the users have several.
    pub(crate) theta_deg: Option<f64>,
    /// Half-width of the band of elevation angles whose users count \[deg\]; `None` if all have the
    /// same angle.
    pub(crate) theta_band_deg: Option<f64>,
    /// Azimuth \[deg\]; `None` for the mean over all.
    pub(crate) phi_deg: Option<f64>,
    /// Ground distance \[m\]; `None` if the users have several.
    pub(crate) distance_m: Option<f64>,
    /// Radius around the UAV that users are within \[m\].
    pub(crate) radius_m: Option<f64>,
    /// Place of the UAV; `None` for models.
    pub(crate) placement: Option<&'static str>,
    /// Users that count; `None` for models.
    pub(crate) users: Option<&'static str>,
    /// Treatment of UAVs inside buildings, `nlos` or `excluded`; `None` for models.
    pub(crate) uav_in_building: Option<&'static str>,
    /// P_LoS.
    pub(crate) value: PlosValue,
}

impl PlosRow {
    /// Returns P_LoS, if there is a value.
    pub(crate) fn p_los(&self) -> Option<f64> {
        match &self.value {
            PlosValue::Estimate(estimate) => estimate.p_los,
            PlosValue::Model(p_los) => Some(*p_los),
            PlosValue::None(_) => None,
        }
    }

    /// Returns the estimate, if the value is one.
    pub(crate) fn estimate(&self) -> Option<&Estimate> {
        match &self.value {
            PlosValue::Estimate(estimate) => Some(estimate),
            _ => None,
        }
    }

    /// Returns the reason for a missing P_LoS or interval.
    pub(crate) fn reason(&self) -> Option<String> {
        match &self.value {
            PlosValue::None(reason) => Some(reason.clone()),
            PlosValue::Estimate(Estimate { p_los: None, .. }) => Some("no user is there".into()),
            PlosValue::Estimate(Estimate { interval: None, clusters, .. }) => {
                Some(format!("no interval: it needs at least {FEWEST_CLUSTERS} clusters, there are {clusters}"))
            }
            _ => None,
        }
    }
}

/// A real city in a report.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct RealCityFacts {
    /// City as the user wrote it.
    pub(crate) city: String,
    /// Numbers of UAV positions: mapped, and inside a building.
    pub(crate) positions: (usize, usize),
    /// Positions left out because the border of the data cuts their disc.
    pub(crate) cut: usize,
    /// Half-width of the band of elevation angles whose users count \[deg\]; `None` for distances
    /// and radii.
    pub(crate) theta_band_deg: Option<f64>,
    /// Engine of the maps.
    pub(crate) engine: Method,
    /// Number of blocks of ground, and their edge \[m\].
    pub(crate) blocks: (usize, f64),
    /// Statistical city most like this one; `None` where single buildings are not known.
    pub(crate) fit: Option<BuiltUpFit>,
    /// Limits of the accuracy of its pictures, in words.
    pub(crate) limits: Option<String>,
    /// Result of a tolerance, where one was given.
    pub(crate) tolerance: Option<PlosToleranceFacts>,
}

/// A form of a real city that was tried for a tolerance.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PlosTried {
    /// The form.
    pub(crate) form: Simpler,
    /// Largest bound over all values, or the reason for having none.
    pub(crate) bound: std::result::Result<f64, String>,
}

/// Result of a tolerance over a real city.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PlosToleranceFacts {
    /// Largest allowed error of any P_LoS.
    pub(crate) tolerance: f64,
    /// Width of a cell of the city itself \[m\].
    pub(crate) cell_m: f64,
    /// Form that was mapped; the city itself if no simpler form is accurate enough.
    pub(crate) taken: Simpler,
    /// Positions from which maps of both forms were compared.
    pub(crate) positions: usize,
    /// Forms that were tried, the coarsest first.
    pub(crate) tried: Vec<PlosTried>,
}

impl PlosToleranceFacts {
    /// Returns the chosen form and its measured bound, in a sentence.
    pub(crate) fn in_words(&self) -> String {
        let bound = self.tried.last().filter(|t| t.form == self.taken).and_then(|t| t.bound.as_ref().ok());
        let scene = format!("{} m", tidy(self.cell_m));
        match bound {
            Some(bound) => format!(
                "tolerance {}: {} instead of {scene}; P_LoS is off by at most {bound:.4} with {} % confidence, {} \
                 positions compared",
                self.tolerance,
                self.taken.in_words(self.cell_m),
                tidy(100.0 * CONFIDENCE),
                self.positions
            ),
            None => format!("tolerance {}: no simpler form will do; cells of {scene}", self.tolerance),
        }
    }

    fn document(&self) -> ToleranceDocument {
        let tried = |t: &PlosTried| TriedDocument {
            form: FormDocument::of(t.form, self.cell_m),
            bound: t.bound.as_ref().ok().copied(),
            reason: t.bound.as_ref().err().cloned(),
        };
        ToleranceDocument {
            tolerance: self.tolerance,
            confidence: CONFIDENCE,
            taken: FormDocument::of(self.taken, self.cell_m),
            positions: self.positions,
            tried: self.tried.iter().map(tried).collect(),
        }
    }
}

/// Report of a study.
#[derive(Debug, Clone)]
pub(crate) struct PlosReport {
    /// Command line and question.
    pub(crate) command: CommandFacts,
    /// Seed of everything random.
    pub(crate) seed: u64,
    /// Confidence of the intervals.
    pub(crate) confidence: f64,
    /// Methods of the study.
    pub(crate) methods: Vec<MethodFacts>,
    /// Cities in files.
    pub(crate) real_cities: Vec<RealCityFacts>,
    /// Input files.
    pub(crate) sources: Vec<Source>,
    /// The values.
    pub(crate) rows: Vec<PlosRow>,
    /// Largest allowed error of any P_LoS of the product or of maps, where a tolerance was given.
    pub(crate) tolerance: Option<f64>,
    /// Warnings.
    pub(crate) warnings: Vec<Warning>,
}

/// Rounds a number to 12 digits. Further digits are noise, and differ between machines.
fn digits(v: f64) -> f64 {
    format!("{v:.11e}").parse().unwrap_or(v)
}

impl PlosReport {
    /// Returns the table, one row for each value. Estimates without an interval have cells `n/a`,
    /// models have empty cells.
    pub(crate) fn table(&self) -> Rows {
        let row = |row: &PlosRow| {
            let of = |value: Option<f64>| match (row.estimate(), value) {
                (Some(_), None) => Some(NumberOr::Word("n/a")),
                (_, value) => value.map(|v| NumberOr::Number(digits(v))),
            };
            let values = row.values();
            PlosTableRow {
                setting: row.setting(),
                p_los: values.p_los,
                ci_low: of(values.ci_low),
                ci_high: of(values.ci_high),
                std_error: of(values.std_error),
                samples: values.samples,
                clusters: values.clusters,
                radius_m: row.radius_m.map(digits),
                theta_band_deg: row.theta_band_deg.map(digits),
            }
        };
        rows(self.rows.iter().map(row))
    }

    /// Returns the largest error of any value of the product, at the confidence of tolerances;
    /// `None` without such a value.
    pub(crate) fn product_bound(&self) -> Option<f64> {
        let reach = student_quantile(2.0 * CONFIDENCE - 1.0, (SHIFTS - 1) as f64);
        let errors = self.rows.iter().filter(|row| row.method == "product").filter_map(|row| row.estimate()?.std_error);
        errors.map(|error| reach * error).reduce(f64::max)
    }

    /// Returns the SHA-256 of the table, its cells separated by commas and its rows ended by line
    /// breaks.
    fn digest(&self) -> String {
        let mut hasher = Sha256::default();
        for row in self.table() {
            hasher.update(row.join(","));
            hasher.update("\n");
        }
        digest_words(hasher)
    }

    /// Returns the document. Without `spent` it is the same for equal runs.
    pub(crate) fn document(&self, spent: Option<Spent>) -> Value {
        self.as_document(Some(self.rows.iter().map(PlosRow::document).collect()), spent)
    }

    /// Returns the document without the values, which pictures store and which stands beside
    /// tables.
    pub(crate) fn provenance(&self) -> Value {
        self.as_document(None, None)
    }

    fn as_document(&self, rows: Option<Vec<PlosRowDocument>>, spent: Option<Spent>) -> Value {
        document_of(&PlosDocument {
            schema: "skyshed/plos/1",
            version: version(),
            command: &self.command,
            seed: self.seed,
            confidence: self.confidence,
            methods: &self.methods,
            tolerance: self.tolerance.map(|tolerance| ProductToleranceDocument {
                tolerance,
                confidence: CONFIDENCE,
                bound: self.product_bound(),
            }),
            real_cities: self.real_cities.iter().map(RealCityFacts::document).collect(),
            sources: SourceFacts::of(&self.sources),
            rows,
            timing_s: spent.map(|spent| TotalTiming { total: spent.total }),
            warnings: warnings_of(&self.warnings),
            digest: self.digest(),
        })
    }
}

impl PlosRow {
    fn setting(&self) -> SettingDocument {
        SettingDocument {
            city: self.city.clone(),
            alpha: self.built_up.map(|b| digits(b.built_up_ratio)),
            beta_per_km2: self.built_up.map(|b| digits(b.buildings_per_km2)),
            gamma_m: self.built_up.map(|b| digits(b.height_scale)),
            method: self.method.clone(),
            height_m: digits(self.height_m),
            rx_height_m: digits(self.rx_height_m),
            theta_deg: self.theta_deg.map(digits),
            phi_deg: self.phi_deg.map(digits),
            distance_m: self.distance_m.map(digits),
            placement: self.placement,
            users: self.users,
            uav_in_building: self.uav_in_building,
        }
    }

    fn values(&self) -> ValuesDocument {
        let interval = self.estimate().and_then(|e| e.interval);
        ValuesDocument {
            p_los: self.p_los().map(digits),
            ci_low: interval.map(|i| digits(i.0)),
            ci_high: interval.map(|i| digits(i.1)),
            std_error: self.estimate().and_then(|e| e.std_error).map(digits),
            samples: self.estimate().map(|e| e.samples),
            clusters: self.estimate().map(|e| e.clusters),
        }
    }

    fn document(&self) -> PlosRowDocument {
        PlosRowDocument {
            setting: self.setting(),
            radius_m: self.radius_m,
            values: self.values(),
            reason: self.reason(),
        }
    }
}

impl RealCityFacts {
    fn document(&self) -> RealCityDocument {
        RealCityDocument {
            city: self.city.clone(),
            positions: self.positions.0,
            positions_in_buildings: self.positions.1,
            positions_with_cut_discs: self.cut,
            theta_band_deg: self.theta_band_deg,
            engine: self.engine.name().into_owned(),
            blocks: self.blocks.0,
            block_m: self.blocks.1,
            tolerance: self.tolerance.as_ref().map(PlosToleranceFacts::document),
            fit: self.fit.as_ref().map(|fit| FitDocument {
                alpha: fit.built_up.built_up_ratio,
                beta_per_km2: fit.built_up.buildings_per_km2,
                gamma_m: fit.built_up.height_scale,
                gamma_std_error_m: fit.height_scale_error,
                buildings: fit.heights.len(),
                kolmogorov_smirnov_distance: fit.distance,
                farthest_at_m: fit.farthest_m,
            }),
        }
    }
}
