//! P_LoS curves in tables.

use crate::error::{Error, InputError, Result};
use crate::los_probability::models::{CurveAxis, UserCurve};
use crate::quantity::counted;
use crate::read::{BadRows, RowFault, Table, readable};

/// Reads a curve from a table separated by commas, semicolons or tabs.
///
/// The table has the columns `p_los` (0 to 1) and `theta_deg` (0 to 90) or `distance_m` (≥ 0).
/// Columns and rows come in any order. Other columns are ignored, and so is `distance_m` beside
/// `theta_deg`. Lines that begin with `#` are comments. `name` is the name in messages.
///
/// # Errors
/// E313, with the lines, what was found there and what was wanted.
pub(super) fn read_curve(name: &str, text: &str, bad: BadRows<'_>) -> Result<UserCurve> {
    let refuse_rows =
        |found, some_are_good| Error::from(InputError::Curve { name: name.to_string(), found, some_are_good });
    let refuse = |found: String| refuse_rows(found, false);
    let table = Table::parse(text).map_err(refuse)?;
    let column = |name: &str| table.column(&[name]);
    let axis = [CurveAxis::Theta, CurveAxis::Distance].into_iter().find_map(|a| Some(a).zip(column(a.column())));
    let (Some((axis, axis_column)), Some(p_column)) = (axis, column("p_los")) else {
        let found = table.found();
        return Err(refuse(format!("found columns `{found}`, wanted `p_los` and `theta_deg` or `distance_m`")));
    };
    let axis_wanted = match axis {
        CurveAxis::Theta => "0 to 90",
        CurveAxis::Distance => "at least 0",
    };

    let rows = table.rows(|_, row| {
        let number = |column: usize, name: &str, range: std::ops::RangeInclusive<f64>, wanted: &str| match table
            .number(row, column, wanted)?
        {
            v if range.contains(&v) => Ok(v),
            v => Err(RowFault::Text(format!("`{name}` is `{v}`, wanted {wanted}"))),
        };
        let at = number(axis_column, axis.column(), axis.range(), axis_wanted)?;
        Ok((at, number(p_column, "p_los", 0.0..=1.0, "0 to 1")?, row.line()))
    });
    let mut rows: Vec<(f64, f64, u64)> = readable(name, rows, bad, |told| refuse_rows(told.text, told.some_are_good))?;
    if rows.len() < 2 {
        let rows = counted(rows.len() as u64, "row", "rows");
        return Err(refuse(format!("found {rows} of values, wanted at least 2")));
    }
    rows.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.2.cmp(&b.2)));
    if let Some([first, second]) = rows.windows(2).find(|pair| pair[0].0 >= pair[1].0) {
        let (column, at) = (axis.column(), first.0);
        let lines = format!("line {}: `{column}` is `{at}`, as on line {}", second.2, first.2);
        return Err(refuse(format!("{lines}, wanted each value once")));
    }
    let points = rows.into_iter().map(|(at, p, _)| (at, p)).collect();
    UserCurve::new(name, axis, points).ok_or_else(|| refuse("found no curve".into()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_and_columns_come_in_any_order() {
        let text = "\u{feff}source, P_LoS ,theta_deg,distance_m\n# measured\nx,1,90,0\ny,0.2,10,567\nz,0.4,30,173\n";
        let curve = read_curve("c.csv", text, BadRows::Refuse).unwrap();
        assert_eq!((curve.name(), curve.axis()), ("c.csv", CurveAxis::Theta));
        assert_eq!(curve.points(), [(10.0, 0.2), (30.0, 0.4), (90.0, 1.0)]);
        let curve = read_curve("c", "distance_m;p_los\n0;1\n100;0,5\n", BadRows::Refuse).unwrap();
        assert_eq!((curve.axis(), curve.points()), (CurveAxis::Distance, &[(0.0, 1.0), (100.0, 0.5)][..]));
    }

    #[test]
    fn each_fault_names_its_line() {
        for (text, wanted) in [
            ("", "found columns ``"),
            ("theta,p_los\n1,0\n2,1\n", "found columns `theta,p_los`"),
            ("theta_deg,p_los\n1,0\n", "found 1 row"),
            ("theta_deg,p_los\n", "found 0 rows"),
            ("theta_deg,p_los\n1,0\n2,45\n", "line 3: `p_los` is `45`"),
            ("theta_deg,p_los\n1,0\n91,1\n", "line 3: `theta_deg` is `91`"),
            ("distance_m,p_los\n-1,0\n91,1\n", "line 2: `distance_m` is `-1`"),
            ("theta_deg,p_los\n1,0\n2\n", "line 3: `p_los`: found ``"),
            ("theta_deg,p_los\n# measured\n\n1,2\n", "line 4: `p_los` is `2`"),
            ("theta_deg,p_los\r\n# measured\r\n\r\n1,0\r\n2,3\r\n", "line 5: `p_los` is `3`"),
            ("theta_deg,p_los\n1,nan\n", "line 2: `p_los`: found `NaN`"),
            ("theta_deg,p_los\n1,0\n2,1\n1,0.5\n", "line 4: `theta_deg` is `1`, as on line 2"),
        ] {
            let error = read_curve("c.csv", text, BadRows::Refuse).unwrap_err();
            let said = error.to_string();
            assert_eq!(error.code(), "E313", "{said}");
            assert!(said.contains("c.csv: ") && said.contains(wanted), "{said}");
        }
    }
}
