//! Names of reference systems that contain an EPSG code or imply one.

/// Returns the EPSG code in a name: a bare code, a code after its authority, a URN, an address on
/// the web, or a name of the German surveys. Compound names give the code of their first part, the
/// horizontal one.
///
/// Any other text gives `None`.
pub(super) fn code_in(text: &str) -> Option<u32> {
    let text = text
        .trim()
        .replace("&amp;", "&")
        .replace("%3A", ":")
        .replace("%3a", ":")
        .replace("%2F", "/")
        .replace("%2f", "/");
    let horizontal = horizontal_part(&text);
    let code = of_survey(horizontal).or_else(|| of_authority(horizontal))?;
    // Codes of web Mercator before it had one of its own.
    Some(if matches!(code, 3785 | 102_100 | 102_113 | 900_913) { 3857 } else { code })
}

/// Returns the name of the horizontal part of a compound name: `…crs-compound?1=NAME&2=NAME`,
/// `urn:ogc:def:crs,NAME,NAME`, `HORIZONTAL*VERTICAL` or `EPSG:n+n`.
fn horizontal_part(text: &str) -> &str {
    let after = |text, key: &str| find_ignoring_case(text, key).map(|at| &text[at + key.len()..]);
    if let Some(parts) = after(text, "crs-compound?") {
        let first = parts.split('&').find_map(|part| part.strip_prefix("1="));
        return first.unwrap_or(parts).trim();
    }
    let parts = ["urn:ogc:def:crs,", "urn:x-ogc:def:crs,", "urn:adv:crs,"].iter().find_map(|key| after(text, key));
    let first = parts.unwrap_or(text).split(['*', '+', ',']).next().unwrap_or_default();
    first.trim()
}

/// Returns the code of a name such as `25832`, `EPSG:25832`, `urn:ogc:def:crs:EPSG:6.12:25832`,
/// `http://www.opengis.net/def/crs/EPSG/0/25832` or
/// `http://www.opengis.net/gml/srs/epsg.xml#25832`.
fn of_authority(name: &str) -> Option<u32> {
    if let Ok(code) = name.parse() {
        return Some(code);
    }
    let begins = |with: &&str| find_ignoring_case(name, with) == Some(0);
    let is_web = ["http://", "https://", "epsg.xml#"].iter().any(begins);
    let mut words = name.trim_end_matches('/').rsplit([':', '/', '#']).map(str::trim);
    let code = words.next()?.parse().ok()?;
    let authority = words.find(|word| !is_version(word))?;
    let is_known = |known: &&str| authority.eq_ignore_ascii_case(known);
    // Addresses that hold nothing but the code.
    let of_site = is_web && ["epsg.xml", "epsg.io", "ref"].iter().any(is_known);
    (of_site || ["EPSG", "ESRI"].iter().any(is_known)).then_some(code)
}

/// Returns `true` when a word is the version of a registry, which may be left out: an empty word,
/// `0`, `6.12`, `v9.8`.
fn is_version(word: &str) -> bool {
    word.trim_start_matches('v').chars().all(|c| c.is_ascii_digit() || c == '.')
}

/// Returns the code of a name of the German surveys, with or without `urn:adv:crs:`.
///
/// Names of some states end with the name of their realization, such as `DE_DHDN_3GK4_BY110`.
///
/// # References
/// AdV, GeoInfoDok 7.1, names of coordinate reference systems.
fn of_survey(name: &str) -> Option<u32> {
    const PREFIX: &str = "urn:adv:crs:";
    let bare = if find_ignoring_case(name, PREFIX) == Some(0) { &name[PREFIX.len()..] } else { name };
    let bare = bare.to_ascii_uppercase();
    let zone = |prefix: &str| -> Option<u32> {
        let rest = bare.strip_prefix(prefix)?;
        let n_digits = rest.chars().take_while(char::is_ascii_digit).count();
        let (zone, rest) = rest.split_at(n_digits);
        (rest.is_empty() || rest.starts_with('_')).then(|| zone.parse().ok()).flatten()
    };
    // Prefix of a name, its first and last zone, and the code of the first.
    const ZONED: [(&str, u32, u32, u32); 8] = [
        ("ETRS89_UTM", 28, 38, 25828),
        ("DE_ETRS89_UTM", 28, 38, 25828),
        ("WGS84_UTM", 1, 60, 32601),
        ("DE_DHDN_3GK", 2, 5, 31466),
        ("DE_42-83_3GK", 3, 5, 2397),
        ("DE_42/83_3GK", 3, 5, 2397),
        ("DE_RD-83_3GK", 4, 5, 3398),
        ("DE_PD-83_3GK", 3, 4, 3396),
    ];
    let of_zone = ZONED.iter().find_map(|(prefix, first, last, code)| {
        let zone = zone(prefix).filter(|zone| (first..=last).contains(&zone))?;
        Some(code + zone - first)
    });
    const NAMES: [(&str, u32); 9] = [
        ("ETRS89_LAT-LON", 4258),
        ("ETRS89_LAT-LON-H", 4258),
        ("ETRS89_LON-LAT", 4258),
        ("ETRS89_LAEA", 3035),
        ("ETRS89_LCC", 3034),
        ("WGS84_LAT-LON", 4326),
        ("WGS84_LAT-LON-H", 4326),
        ("DE_DHDN_LAT-LON", 4314),
        ("DE_DHDN_LAT-LON-H", 4314),
    ];
    of_zone.or_else(|| NAMES.iter().find(|(name, _)| *name == bare).map(|(_, code)| *code))
}

/// Finds ASCII text in any case; returns its byte offset.
fn find_ignoring_case(text: &str, wanted: &str) -> Option<usize> {
    text.as_bytes().windows(wanted.len()).position(|part| part.eq_ignore_ascii_case(wanted.as_bytes()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_hold_a_code_give_it() {
        for (name, code) in [
            ("25832", 25832),
            (" epsg:25832 ", 25832),
            ("EPSG::25832", 25832),
            ("EPSG:25832+5783", 25832),
            ("EPSG:25832*5783", 25832),
            ("urn:ogc:def:crs:EPSG::25832", 25832),
            ("urn:ogc:def:crs:EPSG:6.12:25832", 25832),
            ("urn:x-ogc:def:crs:EPSG:25832", 25832),
            ("urn:ogc:def:crs,crs:EPSG:6.12:25832,crs:EPSG:6.12:5783", 25832),
            ("urn:ogc:def:crs,crs:EPSG::25832,crs:EPSG::7837", 25832),
            ("http://www.opengis.net/def/crs/EPSG/0/25832", 25832),
            ("https://www.opengis.net/def/crs/EPSG/9.9.1/25832", 25832),
            ("http://www.opengis.net/gml/srs/epsg.xml#25832", 25832),
            (
                "http://www.opengis.net/def/crs-compound?1=http://www.opengis.net/def/crs/EPSG/0/25832&2=http://www.opengis.net/def/crs/EPSG/0/7837",
                25832,
            ),
            (
                "https://www.opengis.net/def/crs-compound?1=https://www.opengis.net/def/crs/EPSG/0/28992&amp;2=https://www.opengis.net/def/crs/EPSG/0/5709",
                28992,
            ),
            (
                "http://www.opengis.net/def/crs-compound?2=http://www.opengis.net/def/crs/EPSG/0/7837&1=http://www.opengis.net/def/crs/EPSG/0/25833",
                25833,
            ),
            ("epsg.xml#25832", 25832),
            (
                "http%3A%2F%2Fwww.opengis.net%2Fdef%2Fcrs-compound?1=http%3A%2F%2Fwww.opengis.net%2Fdef%2Fcrs%2FEPSG%2F0%2F25832&2=http%3A%2F%2Fwww.opengis.net%2Fdef%2Fcrs%2FEPSG%2F0%2F7837",
                25832,
            ),
            ("https://epsg.io/25832", 25832),
            ("http://spatialreference.org/ref/epsg/25832/", 25832),
            ("urn:adv:crs:ETRS89_UTM32*DE_DHHN2016_NH", 25832),
            ("urn:adv:crs:ETRS89_UTM31", 25831),
            ("ETRS89_UTM33*DE_DHHN92_NH", 25833),
            ("etrs89_utm32", 25832),
            ("DE_DHDN_3GK2", 31466),
            ("urn:adv:crs:DE_DHDN_3GK4_BY110*DE_DHHN12_NOH", 31468),
            ("DE_DHDN_3GK5", 31469),
            ("DE_42-83_3GK4", 2398),
            ("urn:adv:crs:ETRS89_Lat-Lon-h", 4258),
            ("EPSG:900913", 3857),
            ("ESRI:102100", 3857),
        ] {
            assert_eq!(code_in(name), Some(code), "{name}");
        }
    }

    #[test]
    fn other_texts_hold_none() {
        for name in [
            "",
            "EPSG:",
            "OGC:CRS84",
            "urn:ogc:def:crs:OGC:1.3:CRS84",
            "ETRS89_UTM99",
            "ETRS89_UTM325",
            "DE_DHDN_3GK6",
            "http://example.org/25832",
            "IAU:49900",
            "+proj=utm +zone=32",
            "12.5",
        ] {
            assert_eq!(code_in(name), None, "{name}");
        }
    }
}
