//! P_LoS studies as found: values, methods, tolerances; and how the document and the table are filled with them.

use serde_json::Value;

use super::document::{
    FitDocument, MethodFacts, NumberOr, PlosDocument, PlosRowDocument, PlosTableRow, ProductToleranceDocument,
    RealCityDocument, SettingDocument, ToleranceDocument, TotalTiming, TriedDocument, ValuesDocument,
};
use crate::accuracy::{CONFIDENCE, Simpler};
use crate::answer::{Rows, SourceFacts, Spent, digest_words, document_of, rows, warnings_of};
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

/// What a method says of P_LoS.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum PlosValue {
    /// An estimate with its interval.
    Estimate(Estimate),
    /// The value of a model, which has no error of its own.
    Model(f64),
    /// None, and why.
    None(String),
}

/// One value of P_LoS and what it is of. Heights are above ground.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PlosRow {
    /// The city as it was named.
    pub(crate) city: String,
    /// Its built-up parameters, estimated ones for a real city.
    pub(crate) built_up: Option<BuiltUp>,
    /// The method's word.
    pub(crate) method: String,
    /// Height of the UAV \[m\].
    pub(crate) height_m: f64,
    /// Height of the receivers \[m\].
    pub(crate) rx_height_m: f64,
    /// Elevation angle \[deg\]; `None` for users at many.
    pub(crate) theta_deg: Option<f64>,
    /// How far the angles of the users may be from that \[deg\]; `None` where all have just this one.
    pub(crate) theta_band_deg: Option<f64>,
    /// Azimuth \[deg\]; `None`: all.
    pub(crate) phi_deg: Option<f64>,
    /// Ground distance \[m\]; `None` for users at many.
    pub(crate) distance_m: Option<f64>,
    /// Radius around the UAV \[m\], for users within one.
    pub(crate) radius_m: Option<f64>,
    /// Where the UAV is; `None` for models.
    pub(crate) placement: Option<&'static str>,
    /// Which users are counted; `None` for models.
    pub(crate) users: Option<&'static str>,
    /// What becomes of UAVs inside buildings, `nlos` or `excluded`; `None` for models.
    pub(crate) uav_in_building: Option<&'static str>,
    /// P_LoS.
    pub(crate) value: PlosValue,
}

impl PlosRow {
    /// P_LoS, if there is one.
    pub(crate) fn p_los(&self) -> Option<f64> {
        match &self.value {
            PlosValue::Estimate(estimate) => estimate.p_los,
            PlosValue::Model(p_los) => Some(*p_los),
            PlosValue::None(_) => None,
        }
    }

    /// The estimate, if it is one.
    pub(crate) fn estimate(&self) -> Option<&Estimate> {
        match &self.value {
            PlosValue::Estimate(estimate) => Some(estimate),
            _ => None,
        }
    }

    /// Why there is no P_LoS, or no interval.
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

/// A real city as reported.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct RealCityFacts {
    /// The city as it was named.
    pub(crate) city: String,
    /// UAV positions that were mapped, and how many of them were inside a building.
    pub(crate) positions: (usize, usize),
    /// Positions that were left out because the disc around them is cut by the border of the data.
    pub(crate) cut: usize,
    /// P_LoS at an angle is of users within so many degrees of it \[deg\], if it is asked for at angles.
    pub(crate) theta_band_deg: Option<f64>,
    /// The engine of the maps.
    pub(crate) engine: Method,
    /// Blocks of ground, and their edge \[m\].
    pub(crate) blocks: (usize, f64),
    /// The statistical city that is most like it, if its buildings are known.
    pub(crate) fit: Option<BuiltUpFit>,
    /// What limits the truth of its pictures, in words.
    pub(crate) limits: Option<String>,
    /// What a tolerance led to, where one was given.
    pub(crate) tolerance: Option<PlosToleranceFacts>,
}

/// A form of a real city that was tried for a tolerance.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PlosTried {
    /// Which one.
    pub(crate) form: Simpler,
    /// The largest bound of all values, or why there is none.
    pub(crate) bound: std::result::Result<f64, String>,
}

/// What a tolerance led to over a real city.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PlosToleranceFacts {
    /// How far any P_LoS may be off.
    pub(crate) tolerance: f64,
    /// Width of a cell of the city itself \[m\].
    pub(crate) cell_m: f64,
    /// The form that was mapped; the city itself if no simpler one would do.
    pub(crate) taken: Simpler,
    /// Positions from which maps of both kinds were compared.
    pub(crate) positions: usize,
    /// All forms that were tried, the coarsest first.
    pub(crate) tried: Vec<PlosTried>,
}

impl PlosToleranceFacts {
    /// What was chosen and what was measured, in a sentence.
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

/// A study as reported.
#[derive(Debug, Clone)]
pub(crate) struct PlosReport {
    /// The words of the command line.
    pub(crate) command: Vec<String>,
    /// Seed of everything random.
    pub(crate) seed: u64,
    /// Confidence of the intervals.
    pub(crate) confidence: f64,
    /// The methods.
    pub(crate) methods: Vec<MethodFacts>,
    /// The real cities.
    pub(crate) real_cities: Vec<RealCityFacts>,
    /// The input files.
    pub(crate) sources: Vec<Source>,
    /// The values.
    pub(crate) rows: Vec<PlosRow>,
    /// How far any P_LoS of the product or of maps may be off, if that was given.
    pub(crate) tolerance: Option<f64>,
    /// What was odd.
    pub(crate) warnings: Vec<Warning>,
}

/// A number to 12 digits: more are noise, and differ between machines.
fn digits(v: f64) -> f64 {
    format!("{v:.11e}").parse().unwrap_or(v)
}

impl PlosReport {
    /// The table: one row per value. Where too few clusters leave no interval its cells say `n/a`; models have none.
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

    /// How far any value of the product may be off, with the confidence of a tolerance; `None` without such a value.
    pub(crate) fn product_bound(&self) -> Option<f64> {
        let reach = student_quantile(2.0 * CONFIDENCE - 1.0, (SHIFTS - 1) as f64);
        let errors = self.rows.iter().filter(|row| row.method == "product").filter_map(|row| row.estimate()?.std_error);
        errors.map(|error| reach * error).reduce(f64::max)
    }

    /// SHA-256 of the table, cells separated by commas and rows by line breaks.
    fn digest(&self) -> String {
        let mut hasher = Sha256::default();
        for row in self.table() {
            hasher.update(row.join(","));
            hasher.update("\n");
        }
        digest_words(hasher)
    }

    /// The document; without `spent` it is the same for equal runs.
    pub(crate) fn document(&self, spent: Option<Spent>) -> Value {
        self.as_document(Some(self.rows.iter().map(PlosRow::document).collect()), spent)
    }

    /// The document without the values, as stored in pictures and beside tables.
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
