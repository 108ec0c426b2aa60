//! Properties of bands from GDAL's metadata tag and from the sidecar.

use super::sidecar::Sidecar;

/// Properties of bands in GDAL's metadata tag: a list of `<Item name=… sample=…
/// role=…>value</Item>`.
#[derive(Debug, Clone, Default)]
pub(super) struct Metadata {
    scales: Vec<(usize, f64)>,
    offsets: Vec<(usize, f64)>,
    /// Units of bands.
    units: Vec<(usize, String)>,
    /// Names of bands.
    names: Vec<(usize, String)>,
    /// Item of this program.
    pub(super) provenance: Option<String>,
}

impl Metadata {
    pub(super) fn parse(xml: &str) -> Metadata {
        let mut metadata = Metadata::default();
        for item in xml.split("<Item ").skip(1) {
            let Some((attributes, rest)) = item.split_once('>') else { continue };
            let value = rest.split('<').next().unwrap_or_default();
            let attribute = |name: &str| {
                let (_, rest) = attributes.split_once(&format!("{name}=\""))?;
                rest.split('"').next()
            };
            let band: usize = attribute("sample").and_then(|band| band.parse().ok()).unwrap_or(0);
            let number = value.trim().parse().ok().filter(|number: &f64| number.is_finite());
            match (attribute("role"), number) {
                (Some("scale"), Some(number)) if number != 0.0 => metadata.scales.push((band, number)),
                (Some("offset"), Some(number)) => metadata.offsets.push((band, number)),
                (Some("unittype"), _) => metadata.units.push((band, value.to_owned())),
                // Values are escaped twice, as GDAL does.
                (None, _) if attribute("name") == Some("SKYSHED") => {
                    metadata.provenance = Some(unescaped(&unescaped(value)));
                }
                (Some("description"), _) if !value.is_empty() => {
                    metadata.names.push((band, unescaped(&unescaped(value))))
                }
                _ => {}
            }
        }
        metadata
    }

    /// Adds properties from a sidecar where the tag has none. As in GDAL, a band with a factor or a
    /// summand in the tag takes neither from the sidecar.
    pub(super) fn complete(&mut self, sidecar: &Sidecar) {
        for of_band in &sidecar.bands {
            let band = of_band.band;
            if self.scaling(band) == (1.0, 0.0) && !self.has_scaling(band) {
                self.scales.extend(of_band.scale.map(|scale| (band, scale)));
                self.offsets.extend(of_band.offset.map(|offset| (band, offset)));
            }
            if self.unit(band).is_none() {
                self.units.extend(of_band.unit.clone().map(|unit| (band, unit)));
            }
            if self.name(band).is_none() {
                self.names.extend(of_band.name.clone().map(|name| (band, name)));
            }
        }
    }

    /// Returns factor and summand that turn the stored numbers of a band into heights.
    pub(super) fn scaling(&self, band: usize) -> (f64, f64) {
        (of_band(&self.scales, band).copied().unwrap_or(1.0), of_band(&self.offsets, band).copied().unwrap_or(0.0))
    }

    fn has_scaling(&self, band: usize) -> bool {
        of_band(&self.scales, band).is_some() || of_band(&self.offsets, band).is_some()
    }

    /// Returns the name of the unit of a band.
    pub(super) fn unit(&self, band: usize) -> Option<&str> {
        of_band(&self.units, band).map(String::as_str)
    }

    /// Returns the name of a band.
    pub(super) fn name(&self, band: usize) -> Option<&str> {
        of_band(&self.names, band).map(String::as_str)
    }
}

fn of_band<T>(list: &[(usize, T)], band: usize) -> Option<&T> {
    list.iter().find(|(other, _)| *other == band).map(|(_, value)| value)
}

/// Returns XML text without its escaping.
fn unescaped(text: &str) -> String {
    let entities = [("&lt;", "<"), ("&gt;", ">"), ("&quot;", "\""), ("&apos;", "'"), ("&amp;", "&")];
    entities.iter().fold(text.to_owned(), |text, (entity, letter)| text.replace(entity, letter))
}
