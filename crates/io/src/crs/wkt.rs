//! Well-known text: its nodes, and the differences between its dialects.

use std::collections::BTreeMap;

use proj_core::{CrsDef, ProjectionMethod};

use crate::raster::CrsKind;

/// Returns the part of a WKT that defines the horizontal system: the inner node of a compound or
/// bound system.
pub(super) fn horizontal_node(text: &str) -> Option<&str> {
    const KEYWORDS: [&str; 9] =
        ["PROJCS", "PROJCRS", "PROJECTEDCRS", "GEOGCS", "GEOGCRS", "GEOGRAPHICCRS", "GEODCRS", "GEODETICCRS", "GEOCCS"];
    nodes(text, usize::MAX).into_iter().find(|node| KEYWORDS.iter().any(|k| keyword(node).eq_ignore_ascii_case(k)))
}

/// Returns the part of a WKT that defines the vertical system.
pub(super) fn vertical_node(text: &str) -> Option<&str> {
    const KEYWORDS: [&str; 4] = ["VERT_CS", "VERTCS", "VERTCRS", "VERTICALCRS"];
    nodes(text, usize::MAX).into_iter().find(|node| KEYWORDS.iter().any(|k| keyword(node).eq_ignore_ascii_case(k)))
}

/// Returns `true` when a WKT has a third axis, which goes up from its ellipsoid.
pub(super) fn is_three_dimensional(text: &str) -> bool {
    let is_system = |node: &&str| keyword(node).eq_ignore_ascii_case("CS");
    let mut systems = nodes(text, usize::MAX).into_iter().filter(is_system);
    systems.any(|node| node.trim_end_matches(']').rsplit(',').next().is_some_and(|n| n.trim() == "3"))
}

/// Returns the length of the unit of a vertical node's heights \[m\].
pub(super) fn unit_of(node: &str) -> Option<f64> {
    let units = nodes(node, usize::MAX);
    let unit = units.into_iter().find(|c| ["UNIT", "LENGTHUNIT"].contains(&keyword(c).to_uppercase().as_str()))?;
    unit.split(',').nth(1)?.trim_end_matches(']').trim().parse().ok().filter(|meters: &f64| *meters > 0.0)
}

/// Returns `true` when all brackets and quotes of a text are closed.
pub(super) fn is_whole(text: &str) -> bool {
    let (mut depth, mut is_quoted) = (0_usize, false);
    for c in text.chars() {
        match c {
            '"' => is_quoted = !is_quoted,
            '[' | '(' if !is_quoted => depth += 1,
            ']' | ')' if !is_quoted => match depth.checked_sub(1) {
                Some(less) => depth = less,
                None => return false,
            },
            _ => {}
        }
    }
    depth == 0 && !is_quoted
}

/// Returns the EPSG code in the node's own `AUTHORITY` or `ID`.
pub(super) fn epsg_of(node: &str) -> Option<u32> {
    let own = children(node).into_iter().find(|c| ["AUTHORITY", "ID"].contains(&keyword(c).to_uppercase().as_str()))?;
    let (authority, code) = own.split_once('[')?.1.strip_suffix(']')?.split_once(',')?;
    let bare = |s: &str| s.trim().trim_matches('"').to_string();
    let code = code.split(',').next()?;
    if bare(authority).eq_ignore_ascii_case("EPSG") { bare(code).parse().ok() } else { None }
}

/// Returns the first string of a node.
pub(super) fn name_of(node: &str) -> Option<&str> {
    node.split('"').nth(1).map(str::trim).filter(|name| !name.is_empty())
}

/// Returns the name of the geographic base of a projected node.
pub(super) fn base_name_of(node: &str) -> Option<&str> {
    const KEYWORDS: [&str; 4] = ["GEOGCS", "BASEGEOGCRS", "BASEGEODCRS", "GEODCRS"];
    let base = children(node).into_iter().find(|c| KEYWORDS.contains(&keyword(c).to_uppercase().as_str()))?;
    name_of(base)
}

/// Returns the kind of a node's coordinates, by its keyword and its own unit.
pub(super) fn kind_of(node: &str) -> CrsKind {
    let keyword_here = keyword(node).to_uppercase();
    if keyword_here.starts_with("GEOG") {
        return CrsKind::Geographic;
    }
    let unit = |node: &str| {
        let unit = nodes(node, usize::MAX)
            .into_iter()
            .filter(|c| ["UNIT", "LENGTHUNIT"].contains(&keyword(c).to_uppercase().as_str()))
            .find(|c| !name_of(c).is_some_and(|name| name.to_lowercase().starts_with("deg")))?;
        unit.split(',').nth(1)?.trim_end_matches(']').trim().parse::<f64>().ok()
    };
    // WKT 1 has the unit as a child of the node, WKT 2 also within its axes.
    let own = children(node)
        .into_iter()
        .rfind(|c| ["UNIT", "LENGTHUNIT", "AXIS"].contains(&keyword(c).to_uppercase().as_str()));
    let wkt1 = children(node).into_iter().find(|c| keyword(c).eq_ignore_ascii_case("UNIT"));
    match wkt1.or(own).and_then(unit) {
        // Callers check the unit: they hold the text for the error.
        Some(meters_per_unit) if keyword_here.starts_with("PROJ") => CrsKind::Projected { meters_per_unit },
        _ => CrsKind::Other,
    }
}

/// Returns the node with the names that `proj-wkt` knows.
pub(super) fn for_proj_wkt(node: &str) -> String {
    // EPSG's own method names in WKT 2, and Esri's for the transverse Mercator projection.
    const NAMES: [(&str, &str); 5] = [
        ("\"Lambert Conic Conformal (2SP)\"", "\"Lambert_Conformal_Conic_2SP\""),
        ("\"Lambert Conic Conformal (1SP)\"", "\"Lambert_Conformal_Conic_1SP\""),
        ("\"Gauss_Kruger\"", "\"Transverse_Mercator\""),
        ("\"Hotine_Oblique_Mercator_Azimuth_Center\"", "\"Hotine_Oblique_Mercator_Variant_B\""),
        ("\"Hotine_Oblique_Mercator_Azimuth_Natural_Origin\"", "\"Hotine_Oblique_Mercator\""),
    ];
    NAMES.iter().fold(node.to_string(), |text, (from, to)| text.replace(from, to))
}

/// Returns unit and parameters of a projected system by name, the larger standard parallel first.
pub(super) fn conversion_of(crs: &CrsDef) -> Option<BTreeMap<String, f64>> {
    let text = proj_wkt::to_wkt(crs).ok()?;
    let node = horizontal_node(&text)?;
    let numbers = children(node).into_iter().filter(|child| ["PARAMETER", "UNIT"].contains(&keyword(child)));
    let mut numbers: BTreeMap<String, f64> = numbers
        .map(|child| {
            let name = if keyword(child) == "UNIT" { "unit" } else { name_of(child)? };
            Some((name.to_string(), child.split(',').nth(1)?.trim_end_matches(']').parse().ok()?))
        })
        .collect::<Option<_>>()?;
    if let (Some(&first), Some(&second)) = (numbers.get("standard_parallel_1"), numbers.get("standard_parallel_2")) {
        numbers.insert("standard_parallel_1".to_string(), first.max(second));
        numbers.insert("standard_parallel_2".to_string(), first.min(second));
    }
    Some(numbers)
}

/// Returns WKT 1 with the names and parameters that GDAL expects; `None` if `proj-wkt` cannot write
/// it.
///
/// Checked against PROJ by `check_gdal.py`.
pub(super) fn for_gdal(crs: &CrsDef) -> Option<String> {
    if crs.base_geographic_crs_epsg().is_some_and(has_other_prime_meridian) || lacks_wkt1(crs) {
        return None;
    }
    let text = proj_wkt::to_wkt(crs).ok()?;
    // Datums that `proj-wkt` writes by number only; names after the EPSG registry.
    const DATUMS: [(u32, &str); 24] = [
        (1116, "NAD83_National_Spatial_Reference_System_2011"),
        (1128, "Japanese_Geodetic_Datum_2011"),
        (1168, "Geocentric_Datum_of_Australia_2020"),
        (6120, "Old_Hellenic_1936"),
        (6121, "Greek_Geodetic_Reference_System_1987"),
        (6124, "Rikets_koordinatsystem_1990"),
        (6149, "CH1903"),
        (6150, "CH1903+"),
        (6156, "System_of_the_Unified_Trigonometrical_Cadastral_Network"),
        (6167, "New_Zealand_Geodetic_Datum_2000"),
        (6171, "Reseau_Geodesique_Francais_1993_v1"),
        (6230, "European_Datum_1950"),
        (6258, "European_Terrestrial_Reference_System_1989"),
        (6265, "Monte_Mario"),
        (6283, "Geocentric_Datum_of_Australia_1994"),
        (6284, "Pulkovo_1942"),
        (6289, "Amersfoort"),
        (6299, "TM65"),
        (6300, "Geodetic_Datum_of_1965"),
        (6312, "Militar-Geographische_Institut"),
        (6313, "Reseau_National_Belge_1972"),
        (6314, "Deutsches_Hauptdreiecksnetz"),
        (6612, "Japanese_Geodetic_Datum_2000"),
        (6619, "SWEREF99"),
    ];
    let mut text = DATUMS
        .iter()
        .fold(text, |text, (code, name)| text.replace(&format!("\"EPSG datum {code}\""), &format!("\"{name}\"")));
    let mut rename = |pairs: &[(&str, &str)]| {
        for (from, to) in pairs {
            text = text.replace(&format!("\"{from}\""), &format!("\"{to}\""));
        }
    };
    const CENTER: [(&str, &str); 2] =
        [("latitude_of_origin", "latitude_of_center"), ("central_meridian", "longitude_of_center")];
    match crs.as_projected().map(|projected| projected.method()) {
        Some(ProjectionMethod::HotineObliqueMercator { variant_b: true, .. }) => rename(&[
            ("Hotine_Oblique_Mercator_Variant_B", "Hotine_Oblique_Mercator_Azimuth_Center"),
            ("latitude_of_projection_center", "latitude_of_center"),
            ("longitude_of_projection_center", "longitude_of_center"),
            ("easting_at_projection_center", "false_easting"),
            ("northing_at_projection_center", "false_northing"),
        ]),
        Some(ProjectionMethod::AlbersEqualArea { .. }) => {
            rename(&CENTER);
            rename(&[("Albers_Equal_Area", "Albers_Conic_Equal_Area")]);
        }
        Some(ProjectionMethod::LambertAzimuthalEqualArea { .. }) => rename(&CENTER),
        Some(ProjectionMethod::PolarStereographic { .. }) => {
            // GDAL has a single latitude, the one of true scale.
            let start = text.find("PARAMETER[\"latitude_of_origin\"")?;
            let end = start + text[start..].find(']')? + 2;
            text.replace_range(start..end, "");
            text = text.replace("\"standard_parallel\"", "\"latitude_of_origin\"");
        }
        _ => {}
    }
    Some(text)
}

/// Returns `true` for geographic systems that count longitude from Paris, Ferro, Oslo and so on:
/// `proj-wkt` writes Greenwich for them.
fn has_other_prime_meridian(geographic_epsg: u32) -> bool {
    matches!(geographic_epsg, 4801..=4821 | 4901..=4904 | 5229 | 8042 | 8043)
}

/// Returns `true` for methods that WKT 1 has no name for.
fn lacks_wkt1(crs: &CrsDef) -> bool {
    crs.as_projected().is_some_and(|projected| {
        matches!(
            projected.method(),
            ProjectionMethod::PolarStereographicVariantC { .. }
                | ProjectionMethod::LambertConformalConicMichigan { .. }
                | ProjectionMethod::LambertConformalConic1SPVariantB { .. }
                | ProjectionMethod::KrovakModifiedNorthOrientated { .. }
                | ProjectionMethod::LabordeObliqueMercator { .. }
        )
    })
}

fn keyword(node: &str) -> &str {
    node.split('[').next().unwrap_or_default().trim()
}

/// Returns the direct children of a node that are nodes themselves.
fn children(node: &str) -> Vec<&str> {
    nodes(node, 2).into_iter().skip(1).collect()
}

/// Returns all `KEYWORD[…]` nodes down to a depth, in the order in which they begin.
fn nodes(text: &str, max_depth: usize) -> Vec<&str> {
    let (mut found, mut open) = (Vec::new(), Vec::new());
    let (mut quoted, mut word_start) = (false, None);
    for (at, c) in text.char_indices() {
        match c {
            '"' => quoted = !quoted,
            _ if quoted => {}
            '[' => {
                let start = word_start.take().unwrap_or(at);
                if open.len() < max_depth {
                    open.push(Some(found.len()));
                    found.push((start, text.len()));
                } else {
                    open.push(None);
                }
            }
            ']' => {
                if let Some(Some(index)) = open.pop() {
                    let (start, _) = found[index];
                    found[index] = (start, at + 1);
                }
                word_start = None;
            }
            _ if c.is_ascii_alphanumeric() || c == '_' => word_start = word_start.or(Some(at)),
            _ => word_start = None,
        }
    }
    found.into_iter().map(|(start, end)| &text[start..end]).collect()
}
