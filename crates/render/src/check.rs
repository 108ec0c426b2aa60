//! Checks of arguments that several pictures share.

/// Refuses an empty raster of `n_cols` × `n_rows` cells, and an array of another length.
pub(crate) fn shape(name: &str, length: usize, [n_cols, n_rows]: [usize; 2]) -> Result<(), String> {
    if n_cols == 0 || n_rows == 0 {
        return Err(format!("cannot draw a raster of {n_cols} × {n_rows} cells: it is empty"));
    }
    if n_cols.checked_mul(n_rows) != Some(length) {
        return Err(format!("cannot draw: {name} has {length} values, the raster has {n_cols} × {n_rows} cells"));
    }
    Ok(())
}

/// Refuses an axis whose ends are not finite or do not ascend.
pub(crate) fn ends(name: &str, [low, high]: [f64; 2]) -> Result<(), String> {
    match low < high && (high - low).is_finite() {
        true => Ok(()),
        false => Err(format!("cannot draw `{name}` from {low} to {high}: the ends must be finite and ascend")),
    }
}

/// Refuses the first item that fails `is_good`; the error names it and says what was `wanted`.
pub(crate) fn each<'a, T>(
    things: &'a [T],
    is_good: impl Fn(&T) -> bool,
    name: impl Fn(&'a T) -> &'a str,
    wanted: &str,
) -> Result<(), String> {
    match things.iter().find(|thing| !is_good(thing)) {
        Some(bad) => Err(format!("cannot draw `{}`: wanted {wanted}", name(bad))),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_drawn_is_refused() {
        assert!(shape("mask", 6, [3, 2]).is_ok());
        assert!(shape("mask", 5, [3, 2]).is_err_and(|e| e.contains("mask has 5")));
        assert!(shape("mask", 0, [0, 2]).is_err_and(|e| e.contains("it is empty")));
        assert!(ends("x", [0.0, 1e-9]).is_ok());
        for [low, high] in [[1.0, 1.0], [1.0, 0.0], [f64::NAN, 1.0], [0.0, f64::INFINITY], [-f64::MAX, f64::MAX]] {
            assert!(ends("x", [low, high]).is_err(), "{low} {high}");
        }
        assert!(
            each(&["a", "bc"], |word| word.len() == 1, |word| word, "one letter").is_err_and(|e| e.contains("`bc`"))
        );
    }
}
