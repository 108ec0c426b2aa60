//! The methods that decide maps: the user's choice, and the method that a scene calls for.

use std::borrow::Cow;

use super::StepLength;
use crate::height_field::HeightField;

/// The engine that the user chooses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum MethodChoice {
    /// The fastest exact engine for the scene.
    #[default]
    Auto,
    /// A ray per receiver.
    Ray,
    /// The bracketed sweep, for columns.
    Sweep,
    /// Projected shadows, for prisms.
    Shadow,
    /// Samples along a ray, for columns: approximate.
    Step(StepLength),
    /// Slopes interpolated from cell to cell, for columns: approximate.
    Xdraw,
    /// The nearest ray to the perimeter, for columns: approximate.
    R2,
}

/// The engine that decides. All but the last three are exact and give the same cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// A ray per receiver.
    Ray,
    /// The bracketed sweep.
    Sweep,
    /// Projected shadows: of prisms, or of the plateaus of a raster.
    Shadow,
    /// Projected shadows for the prisms, the sweep for the terrain below them.
    ShadowSweep,
    /// Projected shadows for the prisms; a ray per receiver for a terrain on a grid of its own.
    ShadowRay,
    /// Samples along a ray: approximate.
    Step(StepLength),
    /// Slopes interpolated from cell to cell: approximate.
    Xdraw,
    /// The nearest ray to the perimeter: approximate.
    R2,
}

impl MethodChoice {
    /// Returns the chosen engine; `None` for the fastest one.
    pub fn method(self) -> Option<Method> {
        Some(match self {
            MethodChoice::Auto => return None,
            MethodChoice::Ray => Method::Ray,
            MethodChoice::Sweep => Method::Sweep,
            MethodChoice::Shadow => Method::Shadow,
            MethodChoice::Step(length) => Method::Step(length),
            MethodChoice::Xdraw => Method::Xdraw,
            MethodChoice::R2 => Method::R2,
        })
    }
}

impl std::str::FromStr for MethodChoice {
    type Err = String;

    /// Parses `auto`, `ray`, `sweep`, `shadow`, `step:K` (K in cells), `xdraw` or `r2`.
    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "auto" => return Ok(MethodChoice::Auto),
            "ray" => return Ok(MethodChoice::Ray),
            "sweep" => return Ok(MethodChoice::Sweep),
            "shadow" => return Ok(MethodChoice::Shadow),
            "xdraw" => return Ok(MethodChoice::Xdraw),
            "r2" => return Ok(MethodChoice::R2),
            _ => {}
        }
        let Some(cells) = text.strip_prefix("step:") else {
            return Err(format!("found `{text}`, wanted auto, ray, sweep, shadow, step:K, xdraw or r2"));
        };
        let length = cells.parse().ok().and_then(StepLength::new);
        length
            .map(MethodChoice::Step)
            .ok_or_else(|| format!("found `{text}`, wanted step:K with K from 0.02 to 1000 cells"))
    }
}

impl std::fmt::Display for MethodChoice {
    /// Its word, from which it can be read.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.method() {
            Some(method) => method.fmt(f),
            None => f.write_str("auto"),
        }
    }
}

crate::text!(MethodChoice);

impl std::fmt::Display for Method {
    /// Writes the method's name in documents.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.name())
    }
}

/// The reason why a method cannot be used on a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WrongMethod {
    /// The property that the scene lacks.
    pub why: &'static str,
    /// A method that decides the scene.
    pub instead: Method,
}

impl Method {
    /// Returns the method for a choice on a scene, and the reason.
    pub fn choose(field: &HeightField, choice: MethodChoice) -> Result<(Method, &'static str), WrongMethod> {
        let auto = match (field.prisms().is_some(), field.columns().is_some()) {
            (true, false) => (Method::Shadow, "footprints on flat ground: shadows of roofs"),
            (true, true) if field.columns_can_be_swept() => {
                (Method::ShadowSweep, "footprints on terrain: shadows for the roofs, one sweep for the terrain")
            }
            (true, true) => (
                Method::ShadowRay,
                "terrain whose cells are not those of the receivers, or not of 1 m or an nth of it: shadows for the roofs, rays \
                 for the terrain",
            ),
            (false, _) if field.plateaus().is_some() => {
                (Method::Shadow, "a raster of few flat blocks: shadows of their roofs")
            }
            (false, _) => (Method::Sweep, "a raster: one sweep over its cells"),
        };
        let Some(method) = choice.method() else { return Ok(auto) };
        let is_cast = matches!(auto.0, Method::Shadow | Method::ShadowSweep | Method::ShadowRay);
        match method {
            Method::Shadow if is_cast => Ok((auto.0, "asked for")),
            Method::Shadow => Err(WrongMethod {
                why: "no raster of few flat blocks on flat ground (of 512 × 512 cells or more)",
                instead: auto.0,
            }),
            Method::Ray => Ok((method, "asked for")),
            _ if field.prisms().is_none() => Ok((method, "asked for")),
            _ => Err(WrongMethod { why: "footprints are no raster", instead: auto.0 }),
        }
    }

    /// Returns the method's name in documents.
    pub fn name(self) -> Cow<'static, str> {
        match self {
            Method::Ray => "ray".into(),
            Method::Sweep => "sweep".into(),
            Method::Shadow => "shadow".into(),
            Method::ShadowSweep => "shadow+sweep".into(),
            Method::ShadowRay => "shadow+ray".into(),
            Method::Step(length) => format!("step:{}", length.cells()).into(),
            Method::Xdraw => "xdraw".into(),
            Method::R2 => "r2".into(),
        }
    }

    /// Returns `true` if its answer is that of `ray` for every receiver.
    pub fn is_exact(self) -> bool {
        !matches!(self, Method::Step(_) | Method::Xdraw | Method::R2)
    }

    /// Returns `exact` or `approximate`, for captions.
    pub fn exactness(self) -> &'static str {
        if self.is_exact() { "exact" } else { "approximate" }
    }

    /// Returns the name and the exactness, for captions: `sweep (exact)`.
    pub fn in_words(self) -> String {
        format!("{self} ({})", self.exactness())
    }
}
