//! Looks of methods of P_LoS, the same in every figure.

use crate::render::LineLook;

/// Methods in the order of their looks: color, marker and pattern of dashes. Lines of the same
/// color, eight places apart, differ in pattern.
const METHODS: [&str; 19] = [
    "product",
    "city",
    "geometry",
    "maps",
    "itu",
    "alhourani2014",
    "mohammed2023",
    "holis2008",
    "kang2019",
    "saboor2024",
    "tr36777_uma_av",
    "tr36777_umi_av",
    "tr36777_rma_av",
    "tr38901_uma",
    "tr38901_umi",
    "tr38901_rma",
    "tr38811",
    "tr38811-linear",
    "alhourani2014-table",
];

/// Returns the look of a method. Curves named in `own_curves`, which belong to the user, are
/// points.
pub(super) fn look_of(method: &str, own_curves: &[&str]) -> (LineLook, usize) {
    if let Some(k) = own_curves.iter().position(|name| *name == method) {
        return (LineLook::Points, METHODS.len() + k);
    }
    let look = match method {
        "product" | "maps" => LineLook::Solid,
        "city" | "geometry" => LineLook::Markers,
        _ => LineLook::Dashed,
    };
    (look, METHODS.iter().position(|name| *name == method).unwrap_or(METHODS.len()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::los_probability::models::Model;

    #[test]
    fn every_published_model_has_a_look_of_its_own() {
        let looks: Vec<(LineLook, usize)> = Model::ALL.iter().map(|model| look_of(model.id(), &[])).collect();
        for (k, look) in looks.iter().enumerate() {
            assert!(look.0 == LineLook::Dashed && look.1 < METHODS.len(), "{:?}", Model::ALL[k]);
            assert!(!looks[..k].contains(look), "{:?}", Model::ALL[k]);
        }
        assert_eq!(look_of("measured", &["other", "measured"]), (LineLook::Points, METHODS.len() + 1));
    }
}
