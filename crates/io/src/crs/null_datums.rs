//! Datums that agree with WGS 84 within its accuracy, where the registry has no such operation or
//! prefers a worse one.
//!
//! PROJ treats coordinates of CGCS2000 and GDA2020 as WGS 84; so does this module. The current
//! realization of WGS 84 agrees with that of GDA2020. A way through GDA94 would be off by 1.5 m,
//! the distance that Australia has moved.

use proj_core::{CrsDef, GeographicCrsDef, ProjectedCrsDef};

/// Geographic systems whose datum agrees with WGS 84: CGCS2000 and GDA2020.
const BASES: [u32; 2] = [4490, 7844];
const WGS84: u32 = 4326;

/// Returns `true` when one of two systems has such a datum and the other is of WGS 84.
pub(super) fn are_tied(from: &CrsDef, to: &CrsDef) -> bool {
    let is_wgs84 = |crs: &CrsDef| crs.base_geographic_crs_epsg() == Some(WGS84);
    has_null_datum(from) && is_wgs84(to) || is_wgs84(from) && has_null_datum(to)
}

/// Returns a system with such a datum as one of WGS 84, on its own ellipsoid; other systems stay.
pub(super) fn tied(crs: &CrsDef) -> CrsDef {
    let datum = crs.datum().clone();
    match crs {
        CrsDef::Geographic(geographic) if has_null_datum(crs) => {
            CrsDef::Geographic(GeographicCrsDef::new(WGS84, datum, geographic.name()))
        }
        CrsDef::Projected(projected) if has_null_datum(crs) => {
            let (method, unit, name) = (projected.method(), projected.linear_unit(), projected.name());
            CrsDef::Projected(ProjectedCrsDef::new_with_base_geographic_crs(0, WGS84, datum, method, unit, name))
        }
        _ => crs.clone(),
    }
}

fn has_null_datum(crs: &CrsDef) -> bool {
    crs.base_geographic_crs_epsg().is_some_and(|base| BASES.contains(&base))
}
