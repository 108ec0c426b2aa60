//! Entries of the registry, and the search for one that a file describes without its code.

use std::mem::discriminant;

use proj_core::{AxisOrder, CrsDef};

use super::wkt::conversion_of;

/// Returns the horizontal part of a registry entry.
pub(super) fn registry_entry(code: u32) -> Option<CrsDef> {
    proj_core::lookup_epsg(code).and_then(east_north)
}

pub(super) fn east_north(crs: CrsDef) -> Option<CrsDef> {
    crs.horizontal_crs().map(|horizontal| horizontal.with_axis_order(AxisOrder::EastNorth))
}

/// Largest relative difference of two parameters that mean the same: a few millimeters in a false
/// origin or an angle, more than the rounding of any writer of `.prj` files.
const SAME_NUMBER: f64 = 1e-9;

/// Returns the code of the entry with the same projection, unit, ellipsoid and base as `crs`,
/// preferring one of the same name.
///
/// `base` is the name of the geographic base: entries of different datums can share all numbers.
pub(super) fn code_of(crs: &CrsDef, base: &str, name: Option<&str>) -> Option<u32> {
    let (base, name) = (folded(base), name.map(folded));
    let near = |a: f64, b: f64| (a - b).abs() <= SAME_NUMBER * a.abs().max(1.0);
    let same_ellipsoid = |a: &CrsDef, b: &CrsDef| {
        let (a, b) = (a.datum().ellipsoid(), b.datum().ellipsoid());
        near(a.semi_major_axis(), b.semi_major_axis()) && near(a.flattening(), b.flattening())
    };
    let wanted = crs.as_projected().map(|projected| (projected.method(), conversion_of(crs)));
    let same_conversion = |entry: &CrsDef| match (&wanted, entry.as_projected()) {
        (None, None) => crs.is_geographic() && entry.is_geographic(),
        (Some((method, Some(numbers))), Some(projected))
            if discriminant(method) == discriminant(&projected.method()) =>
        {
            conversion_of(entry).is_some_and(|other| {
                numbers.len() == other.len()
                    && numbers.iter().zip(&other).all(|((name, a), (other, b))| name == other && near(*a, *b))
            })
        }
        _ => false,
    };
    let same_numbers = |entry: &CrsDef| same_ellipsoid(crs, entry) && same_conversion(entry);
    let same_base = |entry: &CrsDef| {
        let entry_base = entry.base_geographic_crs_epsg().and_then(proj_core::lookup_epsg);
        entry_base.is_some_and(|entry_base| folded(entry_base.name()) == base)
    };
    let candidates = (2_000..33_000).filter_map(registry_entry).filter(|entry| same_numbers(entry) && same_base(entry));
    let rank = |entry: &CrsDef| {
        let entry_name = folded(entry.name());
        let same = name.as_ref().is_some_and(|name| entry_name == *name || entry_name.ends_with(name.as_str()));
        (!same, entry.name().contains("(N-E)"), entry.epsg())
    };
    candidates.min_by_key(rank).map(|best| best.epsg())
}

/// Returns a name without its writer's conventions: `GCS_ETRS_1989` and `ETRS89` fold to the same.
fn folded(name: &str) -> String {
    let name = name.trim_start_matches("GCS_").to_uppercase();
    let name: String = name.chars().filter(char::is_ascii_alphanumeric).collect();
    let name = name.replace("NORTHAMERICAN19", "NAD").replace("EUROPEAN19", "ED").replace("BELGE19", "BD");
    let name = name.replace("DEUTSCHESHAUPTDREIECKSNETZ", "DHDN").replace("GAUSSZONE", "GAUSSKRUGERZONE");
    // Four-digit years of the last century become two digits, as in EPSG names.
    let mut short = String::with_capacity(name.len());
    let mut rest = name.as_str();
    while let Some(at) = rest.find("19") {
        let (before, year) = rest.split_at(at);
        let digits = year.chars().take_while(char::is_ascii_digit).count();
        let free = !before.ends_with(|c: char| c.is_ascii_digit());
        short.push_str(before);
        short.push_str(if free && digits == 4 { "" } else { "19" });
        rest = &year[2..];
    }
    short.push_str(rest);
    short.strip_suffix("V1").map_or_else(|| short.replace("V1LAMBERT", "LAMBERT"), str::to_string)
}
