//! The sidecar of a GeoTIFF, `FILE.tif.aux.xml`: properties that GDAL and ArcGIS cannot store in
//! the file itself.
//!
//! As in GDAL, place, reference system and nodata of the sidecar take precedence over the tags.
//! Factor, summand, unit and name of a band count where the tags have none. Everything else in it
//! (statistics, histograms, colors) does not concern heights.
//!
//! # References
//! GDAL's persistent auxiliary metadata (`gdal_priv.h`, `GDALPamDataset`), as GDAL 3.6 reads it.

use std::io::Read;

use roxmltree::{Document, Node, ParsingOptions};

use crate::error::{OddRaster, Oddity};
use crate::formats::xml::{attribute, child, refuse_crowds, text_of};
use crate::input::Input;

/// Longest sidecar that is read \[bytes\]: histograms and tables of attributes can be long.
const MOST_BYTES: u64 = 64 << 20;

/// Place and bands of a file in its sidecar.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Sidecar {
    /// Reference system, as text.
    pub(super) crs: Option<String>,
    /// West, cell width, shear, north, shear, cell height (negative from north to south).
    pub(super) geo_transform: Option<[f64; 6]>,
    /// Number of ground control points.
    pub(super) n_control_points: usize,
    pub(super) bands: Vec<SidecarBand>,
}

/// Properties of a band in a sidecar.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct SidecarBand {
    /// Number of the band, counted from 0.
    pub(super) band: usize,
    /// Nodata value as text, since it is rounded as the samples are.
    pub(super) nodata: Option<String>,
    pub(super) scale: Option<f64>,
    pub(super) offset: Option<f64>,
    pub(super) unit: Option<String>,
    pub(super) name: Option<String>,
}

impl Sidecar {
    /// Reads the sidecar of a file. Returns an empty one where there is none, or, with a warning,
    /// where it cannot be read.
    pub(super) fn of(input: &Input, odd: &mut Vec<Oddity>) -> Sidecar {
        let Some(sidecar) = input.with_suffix(".aux.xml") else { return Sidecar::default() };
        text_in(&sidecar).and_then(|text| Sidecar::parse(&text)).unwrap_or_else(|why| {
            odd.push(Oddity::new(input, OddRaster::Sidecar(sidecar.to_string(), why)));
            Sidecar::default()
        })
    }

    /// Parses a sidecar; the error names the fault.
    fn parse(xml: &str) -> Result<Sidecar, String> {
        refuse_crowds("the sidecar", xml).map_err(|error| error.to_string())?;
        // Without document types there are no entities to expand.
        let options = ParsingOptions { allow_dtd: false, ..ParsingOptions::default() };
        let document = Document::parse_with_options(xml, options).map_err(|error| error.to_string())?;
        let root = document.root_element();
        if !root.tag_name().name().eq_ignore_ascii_case("PAMDataset") {
            return Err(format!("`{}` at its root, wanted `PAMDataset`", root.tag_name().name()));
        }
        let geo_transform = child(root, "GeoTransform").map(|node| {
            let numbers: Option<Vec<f64>> = text_of(node).split(',').map(|text| text.trim().parse().ok()).collect();
            let numbers = numbers.and_then(|numbers| <[f64; 6]>::try_from(numbers).ok());
            numbers.ok_or_else(|| format!("`GeoTransform` is `{}`, wanted 6 numbers", text_of(node)))
        });
        let points = child(root, "GCPList").into_iter().flat_map(|list| list.children().filter(Node::is_element));
        let is_band = |node: &Node<'_, '_>| is_named(*node, "PAMRasterBand");
        Ok(Sidecar {
            crs: child(root, "SRS").map(text_of).filter(|text| !text.is_empty()).map(str::to_string),
            geo_transform: geo_transform.transpose()?,
            n_control_points: points.count(),
            bands: root.children().filter(is_band).filter_map(SidecarBand::of).collect(),
        })
    }

    /// Returns the nodata value of a band, as text.
    pub(super) fn nodata(&self, band: usize) -> Option<&str> {
        self.bands.iter().find(|of_band| of_band.band == band)?.nodata.as_deref()
    }
}

impl SidecarBand {
    /// Reads a band; `None` without its number.
    fn of(node: Node<'_, '_>) -> Option<SidecarBand> {
        let band = attribute(node, "band")?.trim().parse::<usize>().ok()?.checked_sub(1)?;
        let text = |name: &str| child(node, name).map(text_of).filter(|text| !text.is_empty()).map(str::to_string);
        let number = |name: &str| text(name)?.parse().ok().filter(|number: &f64| number.is_finite());
        Some(SidecarBand {
            band,
            nodata: child(node, "NoDataValue").and_then(exact_number),
            scale: number("Scale").filter(|scale| *scale != 0.0),
            offset: number("Offset"),
            unit: text("UnitType"),
            name: text("Description"),
        })
    }
}

fn is_named(node: Node<'_, '_>, name: &str) -> bool {
    node.is_element() && node.tag_name().name().eq_ignore_ascii_case(name)
}

/// Returns the number in an element. Where decimal digits are not exact, its bytes are stored as
/// hexadecimal digits.
fn exact_number(node: Node<'_, '_>) -> Option<String> {
    let of_bytes = attribute(node, "le_hex_equiv").and_then(|digits| u64::from_str_radix(digits.trim(), 16).ok());
    let exact = of_bytes.map(|bits| f64::from_bits(bits.swap_bytes()).to_string());
    exact.or_else(|| Some(text_of(node).to_string()).filter(|text| !text.is_empty()))
}

fn text_in(sidecar: &Input) -> Result<String, String> {
    let (file, len) = sidecar.open().map_err(|error| error.to_string())?;
    if len > MOST_BYTES {
        return Err(format!("{len} bytes, wanted at most {} MiB", MOST_BYTES >> 20));
    }
    let mut bytes = Vec::new();
    file.take(MOST_BYTES).read_to_end(&mut bytes).map_err(|error| error.to_string())?;
    let text = String::from_utf8(bytes).map_err(|error| error.to_string())?;
    Ok(text.strip_prefix('\u{feff}').map_or(text.clone(), str::to_string))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sidecar_says_place_and_numbers() {
        let xml = r#"<PAMDataset><SRS dataAxisToSRSAxisMapping="1,2">EPSG:32632</SRS>
            <GeoTransform> 5.0e+05, 1, 0, 5000008, 0, -1</GeoTransform>
            <PAMRasterBand band="2"><Description>top</Description><NoDataValue le_hex_equiv="000000000000F03F">7</NoDataValue>
            <UnitType>ft</UnitType><Offset>100</Offset><Scale>0.1</Scale></PAMRasterBand>
            <PAMRasterBand><NoDataValue>1</NoDataValue></PAMRasterBand></PAMDataset>"#;
        let sidecar = Sidecar::parse(xml).unwrap();
        assert_eq!(sidecar.crs.as_deref(), Some("EPSG:32632"));
        assert_eq!(sidecar.geo_transform, Some([500_000.0, 1.0, 0.0, 5_000_008.0, 0.0, -1.0]));
        let band = SidecarBand {
            band: 1,
            nodata: Some("1".into()),
            scale: Some(0.1),
            offset: Some(100.0),
            unit: Some("ft".into()),
            name: Some("top".into()),
        };
        assert_eq!(sidecar.bands, [band]);
        assert_eq!((sidecar.nodata(0), sidecar.nodata(1)), (None, Some("1")));
    }

    #[test]
    fn a_damaged_sidecar_says_what_is_wrong() {
        for (xml, wanted) in [
            ("<PAMDataset>", "never closed"),
            ("<VRTDataset/>", "wanted `PAMDataset`"),
            ("<PAMDataset><GeoTransform>1,2,3</GeoTransform></PAMDataset>", "wanted 6 numbers"),
            ("<!DOCTYPE a [<!ENTITY b 'c'>]><PAMDataset/>", "DTD"),
        ] {
            let error = Sidecar::parse(xml).unwrap_err();
            assert!(error.contains(wanted), "{xml}: {error}");
        }
    }
}
