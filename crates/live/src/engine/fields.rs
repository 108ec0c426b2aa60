//! Text of the page's fields, read as the program reads its command line.

use serde_json::{Value, json};
use skyshed_core::coverage::{self, check_height_error, check_radius};
use skyshed_core::quantity::{Height, read_angles, read_number};
use skyshed_request::json::set_members;

use super::{Engine, mapper};
use crate::questions::{AskedHeight, PageSight, Uav};

impl Engine {
    /// Returns the height in a text, if a UAV can hover there. Otherwise the refusal holds the
    /// height, too.
    pub(super) fn read_height(&self, text: &str, (x, y): (f64, f64)) -> Value {
        let height = match text.parse::<Height>() {
            Ok(height) => AskedHeight::from(height),
            Err(words) => return refusal(&words),
        };
        let asked = Uav { id: String::new(), x, y, height };
        match coverage::Uav::place(&asked.site(), self.field, self.mapper_radius()) {
            Ok(_) => value(&json!(height)),
            Err(error) => {
                let mut refused = json!(self.refused(&asked, &error));
                refused["height"] = json!(height);
                refused
            }
        }
    }

    /// Returns the value of a text in another field: a number, two angles, or null for one that
    /// limits nothing. A value that does not fit the other numbers of the last map is refused.
    pub(super) fn read_number(&self, field: &str, text: &str) -> Value {
        self.number(field, text).map_or_else(|words| refusal(&words), |found| value(&found))
    }

    fn number(&self, field: &str, text: &str) -> Result<Value, String> {
        let found = match field {
            // Texts with a unit, and fractions.
            "rx_height" => json!(text),
            "earth_k" if !text.is_empty() => json!(text),
            "search_radius" => {
                let radius_m = read_number(text)?;
                check_radius(radius_m).map_err(|fault| fault.to_string())?;
                return Ok(json!(radius_m));
            }
            _ if text.is_empty() => Value::Null,
            "sector" | "elevation" => json!(read_angles(text)?),
            _ => json!(read_number(text)?),
        };
        let mut members = set_members(&self.sight);
        members.insert(field.into(), found);
        let mut asked = PageSight::from_members(members)?;
        // An earth of infinite radius is flat, and heights that are off by nothing are exact.
        asked.sight.earth.earth_k = asked.sight.earth.earth_k.filter(|k| k.0 != f64::INFINITY);
        if let Some(error_m) = asked.heights.height_error {
            check_height_error("the error of heights", error_m).map_err(|fault| fault.to_string())?;
            asked.heights.height_error = Some(error_m).filter(|m| *m > 0.0);
        }
        mapper(self.field, &asked, self.zones.as_ref())?;
        Ok(set_members(&asked).remove(field).unwrap_or_default())
    }
}

fn value(found: &Value) -> Value {
    json!({ "ok": true, "value": found })
}

fn refusal(words: &str) -> Value {
    json!({ "ok": false, "words": words })
}
