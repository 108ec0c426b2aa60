//! Sweeps of a study: the settings, in the order of the table.

use skyshed_request::{NumberList, Placement, SweepOptions, Users, filled};

use super::report::PlosRow;
use crate::city::BuiltUp;
use crate::error::{LimitError, Result};
use crate::los_probability::setting::{Reach, Setting};

/// Most values of a study.
const MOST_VALUES: usize = 1_000_000;

/// Distance of the users, as an angle, a distance or a radius.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Far {
    Theta(f64),
    Distance(f64),
    Radius(f64),
}

/// Quantities that vary, beside city and method.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Sweeps {
    pub(crate) placements: Vec<Placement>,
    pub(crate) users: Vec<Users>,
    pub(crate) alphas: Option<Vec<f64>>,
    pub(crate) betas: Option<Vec<f64>>,
    pub(crate) gammas: Option<Vec<f64>>,
    pub(crate) heights: Vec<f64>,
    /// Azimuths; `None` for the mean over all.
    pub(crate) phis: Vec<Option<f64>>,
    pub(crate) far: Vec<Far>,
}

/// A quantity on an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Quantity {
    Theta,
    Distance,
    Radius,
    Phi,
    Height,
    Gamma,
    Alpha,
    Beta,
}

impl Quantity {
    pub(super) const ALL: [Quantity; 8] = [
        Quantity::Theta,
        Quantity::Distance,
        Quantity::Radius,
        Quantity::Phi,
        Quantity::Height,
        Quantity::Gamma,
        Quantity::Alpha,
        Quantity::Beta,
    ];
}

impl Sweeps {
    /// Returns the sweeps of a request, with its defaults.
    ///
    /// # Errors
    /// E120 for an azimuth out of range; E502 for too many combinations.
    pub(crate) fn of(sweep: &SweepOptions, defaults: &SweepOptions) -> Result<Sweeps> {
        let list = |numbers: &Option<NumberList>| numbers.as_ref().map(|n| n.0.clone());
        let far = match (&sweep.distance, &sweep.radius, &sweep.theta) {
            (Some(d), _, _) => d.0.iter().copied().map(Far::Distance).collect(),
            (_, Some(r), _) => r.0.iter().copied().map(Far::Radius).collect(),
            (_, _, Some(t)) => t.0.iter().copied().map(Far::Theta).collect(),
            _ => Far::every_five_degrees(),
        };
        let users = if sweep.users.is_empty() { &defaults.users } else { &sweep.users };
        let over = if sweep.placement.is_empty() { &defaults.placement } else { &sweep.placement };
        let sweeps = Sweeps {
            placements: over.clone(),
            users: users.clone(),
            alphas: list(&sweep.alpha),
            betas: list(&sweep.beta),
            gammas: list(&sweep.gamma),
            heights: filled(sweep.height.clone(), defaults.height.clone()).0,
            phis: list(&sweep.phi).map_or_else(|| vec![None], |phis| phis.into_iter().map(Some).collect()),
            far,
        };
        sweeps.checked()
    }

    /// Returns the largest distance of users \[m\]. At an angle it is the distance at which the
    /// highest UAV has the lowest angle.
    pub(super) fn farthest_m(&self) -> f64 {
        let highest = self.heights.iter().copied().fold(0.0, f64::max);
        let distance = |far: &Far| match far {
            Far::Theta(theta) => highest / theta.to_radians().tan(),
            Far::Distance(m) | Far::Radius(m) => *m,
        };
        self.far.iter().map(distance).fold(0.0, f64::max)
    }

    /// Returns `true` if streets and crossroads must be distinguished.
    pub(super) fn need_zones(&self) -> bool {
        let is_zone = |placement: &Placement| matches!(placement, Placement::Street | Placement::Crossroad);
        self.users.iter().any(|users| *users != Users::Outdoor) || self.placements.iter().any(is_zone)
    }

    /// Sorts the values in ascending order and removes repetitions.
    ///
    /// # Errors
    /// E120 for an azimuth out of range; E502 for too many combinations.
    pub(crate) fn checked(self) -> Result<Sweeps> {
        let list = |numbers: Option<Vec<f64>>| numbers.map(|n| sorted(&n));
        let phi = |phi: Option<f64>| phi.map(Setting::checked_phi).transpose();
        let phis: Vec<Option<f64>> = self.phis.into_iter().map(phi).collect::<std::result::Result<_, _>>()?;
        let mut far = self.far;
        far.sort_by(|a, b| a.value().total_cmp(&b.value()));
        far.dedup();
        let sweeps = Sweeps {
            placements: once_each(self.placements),
            users: once_each(self.users),
            alphas: list(self.alphas),
            betas: list(self.betas),
            gammas: list(self.gammas),
            heights: sorted(&self.heights),
            phis: match phis.iter().copied().collect::<Option<Vec<f64>>>() {
                Some(phis) => sorted(&phis).into_iter().map(Some).collect(),
                None => vec![None],
            },
            far,
        };
        let count = |values: &Option<Vec<f64>>| values.as_ref().map_or(1, Vec::len);
        let n = [
            sweeps.placements.len(),
            sweeps.users.len(),
            count(&sweeps.alphas),
            count(&sweeps.betas),
            count(&sweeps.gammas),
            sweeps.heights.len(),
            sweeps.phis.len(),
            sweeps.far.len(),
        ];
        let n = n.into_iter().fold(1_usize, usize::saturating_mul);
        if n > MOST_VALUES {
            return Err(LimitError::Combinations { n, most: MOST_VALUES }.into());
        }
        Ok(sweeps)
    }

    /// Returns `true` if α, β or γ are set, which a real city does not allow.
    pub(super) fn vary_the_city(&self) -> bool {
        self.alphas.is_some() || self.betas.is_some() || self.gammas.is_some()
    }

    /// Returns the settings over a city. Angles or distances vary fastest.
    pub(super) fn settings(
        &self,
        built_up: BuiltUp,
        (rx_height_m, uav_clear_of_roof): (f64, bool),
    ) -> Result<Vec<Setting>> {
        let mut settings = Vec::new();
        for &placement in &self.placements {
            for &users in &self.users {
                for built_up in self.cities(built_up)? {
                    for &height in &self.heights {
                        for &phi_deg in &self.phis {
                            for far in &self.far {
                                settings.push(Setting {
                                    built_up,
                                    uav_height_m: height,
                                    rx_height_m,
                                    reach: far.reach(height, rx_height_m)?,
                                    phi_deg,
                                    users,
                                    placement,
                                    uav_clear_of_roof,
                                });
                            }
                        }
                    }
                }
            }
        }
        Ok(settings)
    }

    /// Returns the city with every requested combination of α, β, γ.
    fn cities(&self, own: BuiltUp) -> Result<Vec<BuiltUp>> {
        let or = |values: &Option<Vec<f64>>, own: f64| values.clone().unwrap_or_else(|| vec![own]);
        let mut cities = Vec::new();
        for gamma in or(&self.gammas, own.height_scale) {
            for alpha in or(&self.alphas, own.built_up_ratio) {
                for beta in or(&self.betas, own.buildings_per_km2) {
                    cities.push(BuiltUp::new(alpha, beta, gamma)?);
                }
            }
        }
        Ok(cities)
    }

    /// Returns these sweeps with many more angles or distances, from the first to the last. `None`
    /// for radii and for a single value.
    pub(super) fn refined(&self) -> Option<Sweeps> {
        const STEPS: u32 = 400;
        let between = |a: f64, b: f64| (0..=STEPS).map(move |k| a + (b - a) * f64::from(k) / f64::from(STEPS));
        let far = match (self.far.first()?, self.far.last()?) {
            (Far::Theta(a), Far::Theta(b)) if a < b => between(*a, *b).map(Far::Theta).collect(),
            (Far::Distance(a), Far::Distance(b)) if a < b => between(*a, *b).map(Far::Distance).collect(),
            _ => return None,
        };
        Some(Sweeps { far, ..self.clone() })
    }

    /// Returns the midpoints beside the angles or distances where the curve through some rows bends
    /// too much.
    pub(super) fn turns(&self, rows: &[PlosRow]) -> Vec<Far> {
        /// Largest allowed distance of P_LoS from the line between its neighbors.
        const STRAIGHT: f64 = 0.01;
        let is_theta = matches!(self.far.first(), Some(Far::Theta(_)));
        if !is_theta && !matches!(self.far.first(), Some(Far::Distance(_))) {
            return Vec::new();
        }
        let x = |row: &PlosRow| if is_theta { row.theta_deg } else { row.distance_m };
        let mut curves: Vec<Vec<&PlosRow>> = Vec::new();
        for row in rows {
            let is_same = |curve: &&mut Vec<&PlosRow>| {
                let key = |r: &PlosRow| (r.placement, r.users, r.height_m.to_bits(), r.phi_deg.map(f64::to_bits));
                key(curve[0]) == key(row) && curve[0].built_up == row.built_up
            };
            match curves.iter_mut().find(is_same) {
                Some(curve) => curve.push(row),
                None => curves.push(vec![row]),
            }
        }
        let mut found: Vec<f64> = Vec::new();
        for curve in &curves {
            let mut points: Vec<(f64, f64)> = curve.iter().filter_map(|row| x(row).zip(row.p_los())).collect();
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            for three in points.windows(3) {
                let [(a, p), (b, q), (c, r)] = [three[0], three[1], three[2]];
                let straight = p + (r - p) * (b - a) / (c - a);
                if (q - straight).abs() > STRAIGHT {
                    found.extend([0.5 * (a + b), 0.5 * (b + c)]);
                }
            }
        }
        let of = |v: f64| if is_theta { Far::Theta(v) } else { Far::Distance(v) };
        sorted(&found).into_iter().map(of).collect()
    }

    /// Returns the quantities with more than one value, and their values.
    pub(super) fn varying(&self) -> Vec<(Quantity, Vec<f64>)> {
        let values = |quantity: Quantity| -> Vec<f64> {
            let far = |pick: &dyn Fn(&Far) -> Option<f64>| self.far.iter().filter_map(pick).collect();
            let list = |values: &Option<Vec<f64>>| values.clone().unwrap_or_default();
            match quantity {
                Quantity::Theta => far(&|f| if let Far::Theta(v) = f { Some(*v) } else { None }),
                Quantity::Distance => far(&|f| if let Far::Distance(v) = f { Some(*v) } else { None }),
                Quantity::Radius => far(&|f| if let Far::Radius(v) = f { Some(*v) } else { None }),
                Quantity::Phi => self.phis.iter().flatten().copied().collect(),
                Quantity::Height => self.heights.clone(),
                Quantity::Gamma => list(&self.gammas),
                Quantity::Alpha => list(&self.alphas),
                Quantity::Beta => list(&self.betas),
            }
        };
        Quantity::ALL.into_iter().map(|q| (q, values(q))).filter(|(_, v)| v.len() > 1).collect()
    }
}

impl Far {
    /// Returns elevation angles of 5, 10 … 90°.
    pub(crate) fn every_five_degrees() -> Vec<Far> {
        (1..=18).map(|k| Far::Theta(5.0 * f64::from(k))).collect()
    }

    fn value(self) -> f64 {
        match self {
            Far::Theta(v) | Far::Distance(v) | Far::Radius(v) => v,
        }
    }

    /// Returns the reach of users, for heights above ground \[m\].
    pub(super) fn reach(self, uav_height_m: f64, rx_height_m: f64) -> Result<Reach> {
        match self {
            Far::Theta(theta) => Ok(Setting::reach_at_elevation(theta, uav_height_m, rx_height_m)?),
            Far::Distance(distance) => Ok(Setting::reach_at_distance(distance, uav_height_m, rx_height_m)?),
            Far::Radius(radius) => Ok(Setting::reach_within(radius, uav_height_m, rx_height_m)?),
        }
    }
}

/// Returns the distinct values in ascending order.
fn sorted(values: &[f64]) -> Vec<f64> {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}

fn once_each<T: PartialEq>(values: Vec<T>) -> Vec<T> {
    let mut kept = Vec::new();
    for value in values {
        if !kept.contains(&value) {
            kept.push(value);
        }
    }
    kept
}
