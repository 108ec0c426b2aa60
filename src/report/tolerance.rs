//! What a tolerance led to, as documents and captions tell it.

use serde_json::{Map, Value, json};

use crate::accuracy::{CONFIDENCE, Choice, Measured, Simpler, Tried};

/// What a tolerance led to.
#[derive(Debug, Clone)]
pub struct ToleranceFacts {
    /// How far P_LoS may be off.
    pub tolerance: f64,
    /// Width of a cell of the scene itself \[m\].
    pub cell_m: f64,
    /// The form that was taken; the scene itself if no simpler one would do.
    pub taken: Simpler,
    /// All that were tried, the coarsest first.
    pub tried: Vec<Tried>,
}

impl ToleranceFacts {
    /// What a choice comes to, over a scene whose cells are so wide \[m\].
    pub fn of(choice: &Choice, tolerance: f64, cell_m: f64) -> Self {
        let taken = choice.taken.as_ref().map_or(Simpler::SAME, |(form, ..)| *form);
        ToleranceFacts { tolerance, cell_m, taken, tried: choice.tried.clone() }
    }

    /// What was measured for the UAV of the form taken whose bound is the largest; `None` where no simpler form would do.
    pub fn worst(&self) -> Option<&Measured> {
        let taken = self.tried.last().filter(|tried| tried.form == self.taken)?;
        taken.measured.as_ref().ok()?.iter().max_by(|a, b| a.bound.total_cmp(&b.bound))
    }

    /// What documents hold of it.
    pub fn json(&self) -> Value {
        let measured = |m: &Measured| {
            json!({
                "p_los": m.p_los, "difference": m.difference, "bound": m.bound, "sample": m.sample,
                "receivers": m.receivers,
            })
        };
        let tried = |t: &Tried| {
            let mut object = form_json(t.form, self.cell_m);
            object.insert("bound".into(), t.bound().into());
            match &t.measured {
                Ok(all) => object.insert("sites".into(), all.iter().map(measured).collect::<Vec<_>>().into()),
                Err(why) => object.insert("reason".into(), why.clone().into()),
            };
            Value::Object(object)
        };
        json!({
            "tolerance": self.tolerance,
            "confidence": CONFIDENCE,
            "taken": form_json(self.taken, self.cell_m),
            "tried": self.tried.iter().map(tried).collect::<Vec<_>>(),
        })
    }
}

/// A form of a scene whose cells are so wide \[m\].
pub(super) fn form_json(form: Simpler, cell_m: f64) -> Map<String, Value> {
    #[expect(clippy::cast_precision_loss, reason = "a small factor")]
    let cell_m = cell_m * form.factor as f64;
    Map::from_iter([
        ("cell_m".to_string(), cell_m.into()),
        ("factor".to_string(), form.factor.into()),
        ("pooling".to_string(), form.pooling.map(|p| p.name()).into()),
    ])
}
