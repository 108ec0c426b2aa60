//! Numbers and heights as they are typed and as properties of buildings spell them.

#![no_main]

use std::str::FromStr;

use libfuzzer_sys::fuzz_target;
use serde_json::json;
use skyshed_core::los::MethodChoice;
use skyshed_core::quantity::{Height, parse_number};
use skyshed_io::read::Projection;
use skyshed_core::city::BuiltUpCity;
use skyshed_fuzz::{answered, footprints};

fuzz_target!(|text: &str| {
    if let Ok(number) = parse_number(text) {
        assert!(number.is_finite());
    }
    if let Ok(height) = Height::from_str(text) {
        assert!(height.value().is_finite());
        assert_eq!(Height::from_str(&height.to_string()), Ok(height));
    }
    let _ = MethodChoice::from_str(text);
    answered(Projection::parse(text));
    BuiltUpCity::parse_built_up(text).and_then(answered);
    let ring = [[0, 0], [9, 0], [9, 9], [0, 0]];
    let document = json!({
        "type": "Feature", "properties": {"height": text, "building:levels": text, "min_height": text},
        "geometry": {"type": "Polygon", "coordinates": [ring]},
    });
    footprints("heights.geojson", document.to_string().as_bytes());
});
