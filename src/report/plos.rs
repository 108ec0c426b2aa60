//! P_LoS studies as reported: the document `skyshed/plos/1`, its table and its arrays.

use serde_json::{Map, Value, json};

use super::documents::digest_words;
use super::tolerance::form_json;
use crate::accuracy::{CONFIDENCE, Simpler};
use crate::city::{BuiltUp, Source};
use crate::digest::Sha256;
use crate::error::Warning;
use crate::los::Method;
use crate::los_probability::estimate::{Estimate, FEWEST_CLUSTERS, student_quantile};
use crate::los_probability::fit::BuiltUpFit;
use crate::los_probability::product::SHIFTS;
use crate::quantity::tidy;

/// What a method says of P_LoS.
#[derive(Debug, Clone, PartialEq)]
pub enum PlosValue {
    /// An estimate with its interval.
    Estimate(Estimate),
    /// The value of a model, which has no error of its own.
    Model(f64),
    /// None, and why.
    None(String),
}

/// One value of P_LoS and what it is of. Heights are above ground.
#[derive(Debug, Clone, PartialEq)]
pub struct PlosRow {
    /// The city as it was named.
    pub city: String,
    /// Its built-up parameters, estimated ones for a real city.
    pub built_up: Option<BuiltUp>,
    /// The method's word.
    pub method: String,
    /// Height of the UAV \[m\].
    pub height_m: f64,
    /// Height of the receivers \[m\].
    pub rx_height_m: f64,
    /// Elevation angle \[deg\]; `None` for users at many.
    pub theta_deg: Option<f64>,
    /// How far the angles of the users may be from that \[deg\]; `None` where all have just this one.
    pub theta_band_deg: Option<f64>,
    /// Azimuth \[deg\]; `None`: all.
    pub phi_deg: Option<f64>,
    /// Ground distance \[m\]; `None` for users at many.
    pub distance_m: Option<f64>,
    /// Radius around the UAV \[m\], for users within one.
    pub radius_m: Option<f64>,
    /// Where the UAV is; `None` for models.
    pub placement: Option<&'static str>,
    /// Which users are counted; `None` for models.
    pub users: Option<&'static str>,
    /// What becomes of UAVs inside buildings, `nlos` or `excluded`; `None` for models.
    pub uav_in_building: Option<&'static str>,
    /// P_LoS.
    pub value: PlosValue,
}

impl PlosRow {
    /// P_LoS, if there is one.
    pub fn p_los(&self) -> Option<f64> {
        match &self.value {
            PlosValue::Estimate(estimate) => estimate.p_los,
            PlosValue::Model(p_los) => Some(*p_los),
            PlosValue::None(_) => None,
        }
    }

    /// The estimate, if it is one.
    pub fn estimate(&self) -> Option<&Estimate> {
        match &self.value {
            PlosValue::Estimate(estimate) => Some(estimate),
            _ => None,
        }
    }

    /// Why there is no P_LoS, or no interval.
    pub fn reason(&self) -> Option<String> {
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

/// A method as reported.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MethodFacts {
    /// Its word.
    pub id: String,
    /// Its name.
    pub name: String,
    /// Where it comes from.
    pub source: String,
    /// Where it is valid, and what it is a function of.
    pub domain: String,
}

/// A real city as reported.
#[derive(Debug, Clone, PartialEq)]
pub struct RealCityFacts {
    /// The city as it was named.
    pub city: String,
    /// UAV positions that were mapped, and how many of them were inside a building.
    pub positions: (usize, usize),
    /// Positions that were left out because the disc around them is cut by the border of the data.
    pub cut: usize,
    /// P_LoS at an angle is of users within so many degrees of it \[deg\], if it is asked for at angles.
    pub theta_band_deg: Option<f64>,
    /// The engine of the maps.
    pub engine: Method,
    /// Blocks of ground, and their edge \[m\].
    pub blocks: (usize, f64),
    /// The statistical city that is most like it, if its buildings are known.
    pub fit: Option<BuiltUpFit>,
    /// What limits the truth of its pictures, in words.
    pub limits: Option<String>,
    /// What a tolerance led to, where one was given.
    pub tolerance: Option<PlosToleranceFacts>,
}

/// A form of a real city that was tried for a tolerance.
#[derive(Debug, Clone, PartialEq)]
pub struct PlosTried {
    /// Which one.
    pub form: Simpler,
    /// The largest bound of all values, or why there is none.
    pub bound: std::result::Result<f64, String>,
}

/// What a tolerance led to over a real city.
#[derive(Debug, Clone, PartialEq)]
pub struct PlosToleranceFacts {
    /// How far any P_LoS may be off.
    pub tolerance: f64,
    /// Width of a cell of the city itself \[m\].
    pub cell_m: f64,
    /// The form that was mapped; the city itself if no simpler one would do.
    pub taken: Simpler,
    /// Positions from which maps of both kinds were compared.
    pub positions: usize,
    /// All forms that were tried, the coarsest first.
    pub tried: Vec<PlosTried>,
}

impl PlosToleranceFacts {
    /// What was chosen and what was measured, in a sentence.
    pub fn in_words(&self) -> String {
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

    fn json(&self) -> Value {
        let tried = |t: &PlosTried| {
            let mut object = form_json(t.form, self.cell_m);
            object.insert("bound".into(), t.bound.as_ref().ok().copied().into());
            object.extend(t.bound.as_ref().err().map(|why| ("reason".to_string(), Value::from(why.clone()))));
            Value::Object(object)
        };
        json!({
            "tolerance": self.tolerance,
            "confidence": CONFIDENCE,
            "taken": form_json(self.taken, self.cell_m),
            "positions": self.positions,
            "tried": self.tried.iter().map(tried).collect::<Vec<_>>(),
        })
    }
}

/// A study as reported.
#[derive(Debug, Clone)]
pub struct PlosReport {
    /// The words of the command line.
    pub command: Vec<String>,
    /// Seed of everything random.
    pub seed: u64,
    /// Confidence of the intervals.
    pub confidence: f64,
    /// The methods.
    pub methods: Vec<MethodFacts>,
    /// The real cities.
    pub real_cities: Vec<RealCityFacts>,
    /// The input files.
    pub sources: Vec<Source>,
    /// The values.
    pub rows: Vec<PlosRow>,
    /// How far any P_LoS of the product or of maps may be off, if that was given.
    pub tolerance: Option<f64>,
    /// What was odd.
    pub warnings: Vec<Warning>,
}

const COLUMNS: &str = "city,alpha,beta_per_km2,gamma_m,method,height_m,rx_height_m,theta_deg,phi_deg,distance_m,\
                       placement,users,uav_in_building,p_los,ci_low,ci_high,std_error,samples,clusters,radius_m,\
                       theta_band_deg";

/// A number to 12 digits: more are noise, and differ between machines.
fn digits(v: f64) -> f64 {
    format!("{v:.11e}").parse().unwrap_or(v)
}

/// A number that may not exist.
fn cell(value: Option<f64>) -> String {
    value.map_or(String::new(), |v| digits(v).to_string())
}

impl PlosReport {
    /// The table: one row per value. Where too few clusters leave no interval its cells say `n/a`; models have none.
    pub fn table(&self) -> Vec<Vec<String>> {
        let header = COLUMNS.split(',').map(str::to_string).collect();
        let row = |row: &PlosRow| {
            let word = |word: Option<&str>| word.unwrap_or_default().to_string();
            let estimate = row.estimate();
            let of_estimate = |value: Option<f64>| match (estimate, value) {
                (Some(_), None) => "n/a".to_string(),
                (_, value) => cell(value),
            };
            vec![
                row.city.clone(),
                cell(row.built_up.map(|b| b.built_up_ratio)),
                cell(row.built_up.map(|b| b.buildings_per_km2)),
                cell(row.built_up.map(|b| b.height_scale)),
                row.method.clone(),
                cell(Some(row.height_m)),
                cell(Some(row.rx_height_m)),
                cell(row.theta_deg),
                cell(row.phi_deg),
                cell(row.distance_m),
                word(row.placement),
                word(row.users),
                word(row.uav_in_building),
                cell(row.p_los()),
                of_estimate(estimate.and_then(|e| e.interval).map(|i| i.0)),
                of_estimate(estimate.and_then(|e| e.interval).map(|i| i.1)),
                of_estimate(estimate.and_then(|e| e.std_error)),
                estimate.map_or(String::new(), |e| e.samples.to_string()),
                estimate.map_or(String::new(), |e| e.clusters.to_string()),
                cell(row.radius_m),
                cell(row.theta_band_deg),
            ]
        };
        std::iter::once(header).chain(self.rows.iter().map(row)).collect()
    }

    /// How far any value of the product may be off, with the confidence of a tolerance; `None` without such a value.
    pub fn product_bound(&self) -> Option<f64> {
        let reach = student_quantile(2.0 * CONFIDENCE - 1.0, (SHIFTS - 1) as f64);
        let errors = self.rows.iter().filter(|row| row.method == "product").filter_map(|row| row.estimate()?.std_error);
        errors.map(|error| reach * error).reduce(f64::max)
    }

    /// SHA-256 of the table, cells separated by commas and rows by line breaks.
    pub fn digest(&self) -> String {
        let mut hasher = Sha256::default();
        for row in self.table() {
            hasher.update(row.join(","));
            hasher.update("\n");
        }
        digest_words(hasher)
    }

    /// The document `skyshed/plos/1`; without `seconds` it is the same for equal runs.
    pub fn document(&self, seconds: Option<f64>) -> Value {
        let mut document = self.head();
        document.insert("rows".into(), self.rows.iter().map(row_json).collect::<Vec<_>>().into());
        document.extend(seconds.map(|s| ("timing_s".to_string(), json!({"total": s}))));
        self.close(document)
    }

    /// The document without the values, as stored in pictures and beside tables.
    pub fn provenance(&self) -> Value {
        self.close(self.head())
    }

    fn head(&self) -> Map<String, Value> {
        let mut document = Map::new();
        document.insert("schema".into(), "skyshed/plos/1".into());
        document.insert("version".into(), env!("CARGO_PKG_VERSION").into());
        document.insert("command".into(), self.command.clone().into());
        document.insert("seed".into(), self.seed.into());
        document.insert("confidence".into(), self.confidence.into());
        let method = |m: &MethodFacts| json!({"id": m.id, "name": m.name, "source": m.source, "domain": m.domain});
        document.insert("methods".into(), self.methods.iter().map(method).collect::<Vec<_>>().into());
        document.extend(self.tolerance.map(|tolerance| {
            let of_product = json!({"tolerance": tolerance, "confidence": CONFIDENCE, "bound": self.product_bound()});
            ("tolerance".to_string(), of_product)
        }));
        let real = self.real_cities.iter().map(real_city_json).collect::<Vec<_>>();
        if !real.is_empty() {
            document.insert("real_cities".into(), real.into());
        }
        let sources = self.sources.iter().map(|s| json!({"path": s.path, "sha256": s.sha256}));
        document.insert("sources".into(), sources.collect::<Vec<_>>().into());
        document
    }

    fn close(&self, mut document: Map<String, Value>) -> Value {
        let warnings = self.warnings.iter().map(|w| json!({"code": w.code(), "text": w.text()}));
        document.insert("warnings".into(), warnings.collect::<Vec<_>>().into());
        document.insert("digest".into(), self.digest().into());
        Value::Object(document)
    }
}

fn row_json(row: &PlosRow) -> Value {
    let mut object = Map::new();
    let of = |value: Option<f64>| Value::from(value.map(digits));
    object.insert("city".into(), row.city.clone().into());
    object.insert("alpha".into(), of(row.built_up.map(|b| b.built_up_ratio)));
    object.insert("beta_per_km2".into(), of(row.built_up.map(|b| b.buildings_per_km2)));
    object.insert("gamma_m".into(), of(row.built_up.map(|b| b.height_scale)));
    object.insert("method".into(), row.method.clone().into());
    object.insert("height_m".into(), row.height_m.into());
    object.insert("rx_height_m".into(), row.rx_height_m.into());
    object.insert("theta_deg".into(), of(row.theta_deg));
    object.insert("phi_deg".into(), row.phi_deg.into());
    object.insert("distance_m".into(), of(row.distance_m));
    object.insert("radius_m".into(), row.radius_m.into());
    object.insert("placement".into(), row.placement.into());
    object.insert("users".into(), row.users.into());
    object.insert("uav_in_building".into(), row.uav_in_building.into());
    object.insert("p_los".into(), of(row.p_los()));
    let interval = row.estimate().and_then(|e| e.interval);
    object.insert("ci_low".into(), of(interval.map(|i| i.0)));
    object.insert("ci_high".into(), of(interval.map(|i| i.1)));
    object.insert("std_error".into(), of(row.estimate().and_then(|e| e.std_error)));
    object.insert("samples".into(), row.estimate().map(|e| e.samples).into());
    object.insert("clusters".into(), row.estimate().map(|e| e.clusters).into());
    if let Some(reason) = row.reason() {
        object.insert("reason".into(), reason.into());
    }
    Value::Object(object)
}

fn real_city_json(city: &RealCityFacts) -> Value {
    json!({
        "city": city.city,
        "positions": city.positions.0,
        "positions_in_buildings": city.positions.1,
        "positions_with_cut_discs": city.cut,
        "theta_band_deg": city.theta_band_deg,
        "engine": city.engine.name(),
        "blocks": city.blocks.0,
        "block_m": city.blocks.1,
        "tolerance": city.tolerance.as_ref().map(PlosToleranceFacts::json),
        "fit": city.fit.as_ref().map(|fit| json!({
            "alpha": fit.built_up.built_up_ratio,
            "beta_per_km2": fit.built_up.buildings_per_km2,
            "gamma_m": fit.built_up.height_scale,
            "gamma_std_error_m": fit.height_scale_error,
            "buildings": fit.heights.len(),
            "kolmogorov_smirnov_distance": fit.distance,
            "farthest_at_m": fit.farthest_m,
        })),
    })
}
