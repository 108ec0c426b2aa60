//! GDAL's metadata tag.

/// What GDAL's metadata tag says of the bands: a list of `<Item name=… sample=… role=…>value</Item>`.
#[derive(Debug, Clone, Default)]
pub(super) struct Metadata {
    scales: Vec<(usize, f64)>,
    offsets: Vec<(usize, f64)>,
    /// Unit of the first band.
    pub(super) unit: Option<String>,
    /// Names of bands.
    pub(super) names: Vec<(usize, String)>,
    /// The item of this program.
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
                (Some("unittype"), _) if band == 0 => metadata.unit = Some(value.to_owned()),
                // Values are escaped twice, as GDAL does.
                (None, _) if attribute("name") == Some("SKYSHED") => {
                    metadata.provenance = Some(unescaped(&unescaped(value)));
                }
                (Some("description"), _) => metadata.names.push((band, unescaped(&unescaped(value)))),
                _ => {}
            }
        }
        metadata
    }

    /// Factor and summand that turn the stored numbers of a band into heights.
    pub(super) fn scaling(&self, band: usize) -> (f64, f64) {
        let of = |list: &[(usize, f64)]| list.iter().find(|(b, _)| *b == band).map(|(_, value)| *value);
        (of(&self.scales).unwrap_or(1.0), of(&self.offsets).unwrap_or(0.0))
    }
}

/// XML text as it was before its escaping.
fn unescaped(text: &str) -> String {
    let entities = [("&lt;", "<"), ("&gt;", ">"), ("&quot;", "\""), ("&apos;", "'"), ("&amp;", "&")];
    entities.iter().fold(text.to_owned(), |text, (entity, letter)| text.replace(entity, letter))
}
