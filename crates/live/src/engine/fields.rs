//! Text of the page's fields, read as the program reads its command line.

use serde_json::{Value, json};
use skyshed_core::coverage::{self, check_height_error, check_radius};
use skyshed_core::quantity::{Height, read_angles, read_fraction, read_length, read_number};

use super::{Engine, mapper};
use crate::questions::{AskedHeight, Field, Uav};

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
    pub(super) fn read_number(&self, field: Field, text: &str) -> Value {
        self.number(field, text).map_or_else(|words| refusal(&words), |found| value(&found))
    }

    fn number(&self, field: Field, text: &str) -> Result<Value, String> {
        let mut asked = self.sight;
        let mut antenna = asked.antenna.unwrap_or_default();
        let is_empty = text.is_empty();
        let number = || if is_empty { Ok(None) } else { read_number(text).map(Some) };
        let pair = || if is_empty { Ok([None; 2]) } else { read_angles(text).map(|pair| pair.map(Some)) };
        let found = match field {
            Field::Height | Field::RxHeight => {
                asked.rx_height_m = read_length(text)?;
                json!(asked.rx_height_m)
            }
            Field::Radius => {
                asked.radius_m = number()?;
                json!(asked.radius_m)
            }
            Field::MinRadius => {
                antenna[0] = number()?;
                json!(antenna[0])
            }
            Field::Sector => {
                [antenna[1], antenna[2]] = pair()?;
                json!(antenna[1].zip(antenna[2]))
            }
            Field::Elevation => {
                [antenna[3], antenna[4]] = pair()?;
                json!(antenna[3].zip(antenna[4]))
            }
            Field::Beam => {
                antenna[5] = number()?;
                json!(antenna[5])
            }
            Field::EarthK => {
                let k = if is_empty { None } else { Some(read_fraction(text)?) };
                // An earth of infinite radius is flat.
                asked.earth_k = k.filter(|k| *k != f64::INFINITY);
                json!(asked.earth_k)
            }
            Field::HeightError => {
                let error_m = number()?.unwrap_or(0.0);
                check_height_error("the error of heights", error_m).map_err(|fault| fault.to_string())?;
                return Ok(if error_m > 0.0 { json!(error_m) } else { Value::Null });
            }
            Field::SearchRadius => {
                let radius_m = read_number(text)?;
                check_radius(radius_m).map_err(|fault| fault.to_string())?;
                return Ok(json!(radius_m));
            }
        };
        asked.antenna = Some(antenna);
        mapper(self.field, &asked, self.zones.as_ref())?;
        Ok(found)
    }
}

fn value(found: &Value) -> Value {
    json!({ "ok": true, "value": found })
}

fn refusal(words: &str) -> Value {
    json!({ "ok": false, "words": words })
}
