//! Receivers as they are typed.

use crate::cli::failure::{Result, refusal_with};
use crate::quantity::{Height, parse_number};

/// Reads a receiver as typed: `X,Y[,H]`.
///
/// # Errors
/// E103: a text that is no receiver.
pub(crate) fn parse_receiver(text: &str, rx_height_m: f64) -> Result<((f64, f64), Height)> {
    let wrong = |found: String| {
        refusal_with(
            103,
            format!("cannot read `--rx {text}`: {found}"),
            "write X,Y or X,Y,H, for example `630,480` or `620,480,1.5roof`",
        )
    };
    let parts: Vec<&str> = text.split(',').collect();
    let (x, y, h) = match parts[..] {
        [x, y] => (x, y, None),
        [x, y, h] => (x, y, Some(h)),
        _ => return Err(wrong(format!("found {} values, wanted X,Y or X,Y,H", parts.len()))),
    };
    let x = parse_number(x).map_err(|e| wrong(format!("x: {e}")))?;
    let y = parse_number(y).map_err(|e| wrong(format!("y: {e}")))?;
    let height = h.map_or(Ok(Height::AboveGround(rx_height_m)), str::parse).map_err(wrong)?;
    Ok(((x, y), height))
}
