//! Speed against accuracy on one scene: the contestants, the cells that they decide on, and the
//! exact answer.
//!
//! A contestant is an engine on the scene itself, on coarser cells, or on the raster of a scene of
//! footprints. Its answer is compared with that of `ray` on the scene. Exact engines compete under
//! the same rules, so that their zero is counted, not assumed.

use std::borrow::Cow;

use rayon::prelude::*;

use super::comparison::Comparison;
use super::{Simpler, moved_to};
use crate::coverage::{MapOptions, Mapper, MovedRoofs, Seen, Uav};
use crate::error::{ChartError, Result};
use crate::height_field::{HeightField, Pooling};
use crate::los::{Method, MethodChoice, StepLength};
use crate::quantity::{STEPS_PER_UNIT, share};
use crate::raster::BitGrid;

/// Kinds of contestants, as legends distinguish them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Family {
    /// Exact engines on the scene itself.
    Exact,
    /// Samples along a ray.
    Step,
    /// Slopes passed from neighbor to neighbor, or rays to the perimeter only.
    Neighbors,
    /// An exact engine on coarser cells.
    Coarser,
    /// An exact engine on the raster of a scene of footprints.
    Raster,
    /// An exact engine on buildings with other roofs.
    Roofs,
    /// Another program.
    Peer,
}

impl Family {
    /// All families in the order of legends.
    pub const ALL: [Family; 7] =
        [Family::Exact, Family::Step, Family::Neighbors, Family::Coarser, Family::Raster, Family::Roofs, Family::Peer];

    fn told(self) -> (&'static str, &'static str) {
        match self {
            Family::Exact => ("exact", "Exact engines"),
            Family::Step => ("step", "Samples along the ray"),
            Family::Neighbors => ("neighbors", "Interpolated, nearest ray"),
            Family::Coarser => ("coarser", "Exact, coarser cells"),
            Family::Raster => ("raster", "Exact, raster of the scene"),
            Family::Roofs => ("roofs", "Exact, other roofs"),
            Family::Peer => ("peer", "Other programs"),
        }
    }

    /// Returns the word for it in tables.
    pub fn name(self) -> &'static str {
        self.told().0
    }

    /// Returns a description in a few words.
    pub fn in_words(self) -> &'static str {
        self.told().1
    }
}

/// Cells that a contestant decides on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ground {
    /// The scene itself.
    Scene,
    /// Larger cells of a raster, or fewer receivers over unchanged footprints.
    Simpler(Simpler),
    /// The raster of the footprints, on the receivers' own cells.
    Raster,
    /// The scene with flat roofs, each at the height of its highest point.
    FlatRoofs,
    /// The scene with all roofs this many meters higher: the effect of an error of heights.
    HigherRoofs(u16),
}

impl Ground {
    /// Returns the factor by which its cells are wider and higher.
    pub fn factor(self) -> usize {
        match self {
            Ground::Simpler(form) => form.factor,
            _ => 1,
        }
    }
}

/// An engine and the cells that it decides on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Contestant {
    /// Engine; on other cells another exact engine may take its place.
    pub method: Method,
    /// Cells that it decides on.
    pub ground: Ground,
}

/// Step lengths of the sampled rays \[cells\].
const STEPS: [f64; 5] = [0.25, 0.5, 1.0, 2.0, 4.0];
/// Errors of heights: of good data, and of many footprints \[m\].
const HIGHER_M: [u16; 2] = [1, 3];
/// Factors by which cells are enlarged.
const FACTORS: [usize; 3] = [2, 4, 8];

impl Contestant {
    /// Returns the contestants on a scene, exact engines on it first, then `more` if it is new.
    pub fn all(field: &HeightField, more: MethodChoice) -> Result<Vec<Contestant>> {
        let on = |ground: Ground| move |method: Method| Contestant { method, ground };
        let own = Method::choose(field, MethodChoice::Auto).map_or(Method::Ray, |(method, _)| method);
        let is_vector = field.prisms().is_some();
        let approximate = STEPS.into_iter().filter_map(StepLength::new).map(Method::Step);
        let approximate = approximate.chain([Method::Xdraw, Method::R2]);
        let mut all: Vec<Contestant> = [Method::Ray, own].map(on(Ground::Scene)).to_vec();
        // A raster of plateaus loses them on larger cells; the sweep decides these.
        let of_forms = if is_vector { own } else { Method::Sweep };
        if !is_vector && own != Method::Sweep {
            all.push(on(Ground::Scene)(Method::Sweep));
        }
        if is_vector {
            all.push(on(Ground::Raster)(Method::Sweep));
            all.extend(approximate.map(on(Ground::Raster)));
        } else {
            all.extend(approximate.map(on(Ground::Scene)));
        }
        let mut forms = Simpler::forms(field, &FACTORS);
        forms.sort_by_key(|form| form.pooling.map(Pooling::name));
        all.extend(forms.into_iter().map(|form| on(Ground::Simpler(form))(of_forms)));
        if is_vector {
            let is_flat = field.n_buildings_with_shaped_roofs() == 0;
            let roofs = (!is_flat).then_some(Ground::FlatRoofs).into_iter();
            all.extend(roofs.chain(HIGHER_M.map(Ground::HigherRoofs)).map(|ground| on(ground)(own)));
        }
        let more = match more.method() {
            // Approximations of a vector scene use its raster.
            Some(method) if is_vector && !matches!(method, Method::Ray | Method::Shadow) => on(Ground::Raster)(method),
            _ => {
                let method = Method::choose(field, more)
                    .map_err(|wrong| ChartError::Method { why: wrong.why, instead: wrong.instead.name() })?;
                on(Ground::Scene)(method.0)
            }
        };
        if !all.contains(&more) {
            all.push(more);
        }
        Ok(all)
    }

    /// Returns the kind of contestant.
    pub fn family(&self) -> Family {
        match (self.method, self.ground) {
            (Method::Step(_), _) => Family::Step,
            (Method::Xdraw | Method::R2, _) => Family::Neighbors,
            (_, Ground::Scene) => Family::Exact,
            (_, Ground::Raster) => Family::Raster,
            (_, Ground::Simpler(_)) => Family::Coarser,
            (_, Ground::FlatRoofs | Ground::HigherRoofs(_)) => Family::Roofs,
        }
    }

    /// Returns the text of its cells for tables; empty for the scene itself.
    pub fn parameters(&self) -> String {
        match self.ground {
            Ground::Scene => String::new(),
            Ground::Simpler(Simpler { factor, pooling: Some(pooling) }) => {
                format!("cells {factor}x {}", pooling.name())
            }
            Ground::Simpler(Simpler { factor, pooling: None }) => format!("receivers {factor}x"),
            Ground::Raster => "raster".to_string(),
            Ground::FlatRoofs => "flat roofs".to_string(),
            Ground::HigherRoofs(m) => format!("roofs {m} m higher"),
        }
    }

    /// Returns a short name for pictures.
    pub fn label(&self) -> String {
        match self.ground {
            Ground::Scene => self.method.to_string(),
            Ground::Simpler(Simpler { factor, pooling: Some(pooling) }) => {
                format!("{factor}× cells, {}", pooling.name())
            }
            Ground::Simpler(Simpler { factor, pooling: None }) => format!("{factor}× receivers"),
            Ground::Raster => format!("{} on raster", self.method),
            Ground::FlatRoofs => "flat roofs".to_string(),
            Ground::HigherRoofs(m) => format!("roofs {m} m higher"),
        }
    }

    /// Makes its cells and puts the UAVs over them, at their own places and heights above the
    /// datum.
    ///
    /// # Errors
    /// The reason why it cannot compete: there are no such cells, or a UAV is inside a larger
    /// building.
    pub fn prepare<'a>(
        &self,
        field: &'a HeightField,
        uavs: &[Uav],
        options: &MapOptions,
    ) -> std::result::Result<Prepared<'a>, String> {
        let field = match self.ground {
            Ground::Scene => Cow::Borrowed(field),
            Ground::Simpler(form) => Cow::Owned(form.of(field).ok_or("the scene has no larger cells")?),
            Ground::Raster => Cow::Owned(field.rasterized().ok_or("the scene has no raster")?),
            Ground::FlatRoofs => Cow::Owned(field.with_flat_roofs().ok_or("all roofs are flat")?),
            Ground::HigherRoofs(m) => {
                let steps = i32::from(m) * STEPS_PER_UNIT;
                let moved = MovedRoofs::by_building(field, |_| steps).ok_or("a roof would be too high")?;
                Cow::Owned(moved.field)
            }
        };
        let uavs = match self.ground {
            Ground::Scene => uavs.to_vec(),
            _ => uavs.iter().map(|uav| moved_to(uav, &field)).collect::<Result<_>>().map_err(|e| e.to_string())?,
        };
        let options = MapOptions { method: self.choice(), ..options.clone() };
        Ok(Prepared { field, uavs, options })
    }

    /// Returns the choice that selects the engine.
    fn choice(&self) -> MethodChoice {
        match self.method {
            Method::Ray => MethodChoice::Ray,
            Method::Sweep => MethodChoice::Sweep,
            Method::Shadow | Method::ShadowSweep | Method::ShadowRay => MethodChoice::Auto,
            Method::Step(length) => MethodChoice::Step(length),
            Method::Xdraw => MethodChoice::Xdraw,
            Method::R2 => MethodChoice::R2,
        }
    }
}

/// A contestant's cells, UAVs and options.
#[derive(Debug)]
pub struct Prepared<'a> {
    field: Cow<'a, HeightField>,
    uavs: Vec<Uav>,
    options: MapOptions,
}

impl Prepared<'_> {
    /// Prepares the work that does not depend on the UAV.
    pub fn mapper(&self) -> Result<Mapper<'_>> {
        Ok(Mapper::new(&self.field, &self.options)?)
    }

    /// Maps one UAV after the other, which is what is timed. A shadow is cast by one thread.
    ///
    /// # Errors
    /// As [`Mapper::seen_from`].
    pub fn answer(&self, mapper: &Mapper<'_>) -> Result<Vec<Seen>> {
        self.uavs.iter().map(|uav| Ok(mapper.seen_from(uav)?.seen())).collect()
    }
}

/// Most links for which `ray` computes the whole exact answer: some ten seconds of one core.
pub const MOST_RAYS: u64 = 1 << 26;

/// Exact answer.
#[derive(Debug, Clone)]
pub struct Truth {
    /// Map of each UAV.
    pub seen: Vec<Seen>,
    /// Engine that computed it.
    pub method: Method,
    /// Number of sampled links that `ray` decided alike; `None` if `ray` decided all links.
    pub checked: Option<u64>,
}

impl Truth {
    /// Computes the answer by `ray`. For more than `most_rays` links the engine for the scene
    /// answers instead, and is compared with `ray` on evenly spread cells.
    ///
    /// # Errors
    /// As [`Mapper::new`]; E603 if the two engines differ.
    pub fn of(field: &HeightField, uavs: &[Uav], options: &MapOptions, most_rays: u64) -> Result<Truth> {
        let exact = |method: MethodChoice| MapOptions { method, ..options.clone() };
        let see = |options: &MapOptions| -> Result<(Vec<Seen>, Method)> {
            let mapper = Mapper::new(field, options)?;
            let see = |uav| Ok(mapper.seen_from(uav)?.seen());
            Ok((uavs.par_iter().map(see).collect::<Result<_>>()?, mapper.method().0))
        };
        let cells = Mapper::new(field, &exact(MethodChoice::Ray))?.receiver_cells();
        let n_links = cells.count().saturating_mul(uavs.len() as u64);
        if n_links <= most_rays {
            let (seen, method) = see(&exact(MethodChoice::Ray))?;
            return Ok(Truth { seen, method, checked: None });
        }
        let (seen, method) = see(&exact(MethodChoice::Auto))?;
        let sample = every_nth(&cells, usize::try_from(n_links / most_rays.max(1) + 1).unwrap_or(usize::MAX));
        let (by_ray, _) = see(&MapOptions { within: Some(sample.clone()), ..exact(MethodChoice::Ray) })?;
        for (uav, (all, by_ray)) in uavs.iter().zip(seen.iter().zip(&by_ray)) {
            if all.los.clone().and(&sample) != by_ray.los {
                return Err(ChartError::EnginesDiffer { method: method.name(), uav: uav.id.clone() }.into());
            }
        }
        let checked = by_ray.iter().map(|seen| seen.receivers.count()).sum();
        Ok(Truth { seen, method, checked: Some(checked) })
    }

    /// Returns the number of receivers, summed over the UAVs.
    pub fn receivers(&self) -> u64 {
        self.seen.iter().map(|seen| seen.receivers.count()).sum()
    }

    /// Returns the number of receivers in line of sight, summed over the UAVs.
    pub fn los(&self) -> u64 {
        self.seen.iter().map(|seen| seen.los.count()).sum()
    }

    /// Returns the exact P_LoS of all UAVs together; `None` without a receiver.
    pub fn p_los(&self) -> Option<f64> {
        share(self.los(), self.receivers())
    }

    /// Compares an answer for the same UAVs, on cells `factor` times as wide and high.
    pub fn compare(&self, answer: &[Seen], factor: usize) -> Comparison {
        let pairs = answer.iter().zip(&self.seen).map(|(answer, exact)| Comparison::of(answer, exact, factor));
        pairs.fold(Comparison::default(), Comparison::plus)
    }

    /// Returns P_LoS of an answer, over its own receivers, minus the exact one.
    pub fn p_los_error(&self, counts: &Comparison) -> Option<f64> {
        Some(counts.p_los()? - self.p_los()?)
    }
}

/// Returns every `n`th cell of a set in row order.
fn every_nth(cells: &BitGrid, n: usize) -> BitGrid {
    let mut some = BitGrid::new(cells.n_rows(), cells.n_cols());
    cells.cells().step_by(n.max(1)).for_each(|(row, col)| some.insert(row, col));
    some
}
