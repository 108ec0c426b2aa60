//! Every published P_LoS model against tables of values computed independently, to the printed digit.

use skyshed_core::city::BuiltUp;
use skyshed_study::los_probability::models::{Model, ModelLink, itu};

use crate::los_probability::reference;
use crate::texts::number;

/// Half a unit of the last printed digit, and the rounding of the arithmetic.
const PRINTED: f64 = 0.5e-6 + 1e-12;

/// How many cells were compared, and how many were refused as they must be.
#[derive(Debug, Default, PartialEq)]
struct Counts {
    compared: usize,
    refused: usize,
}

/// Compares a cell with a model; where the cell is empty or NaN, the model must refuse.
fn compare(model: Model, link: &ModelLink, cell: &str, counts: &mut Counts) {
    let found = model.p_los(link);
    let wanted = cell.parse::<f64>().ok().filter(|p| !p.is_nan());
    let Some(wanted) = wanted else {
        assert!(found.is_err(), "{} gives {found:?} at {link:?}", model.id());
        counts.refused += 1;
        return;
    };
    let p = found.unwrap_or_else(|e| panic!("{} at {link:?}: {e}", model.id())).p_los;
    assert!((p - wanted).abs() <= PRINTED, "{} at {link:?}: found {p}, wanted {wanted}", model.id());
    counts.compared += 1;
}

#[test]
fn models_of_a_city_give_their_table() {
    let Some(rows) = reference("models_reference.csv") else { return };
    let columns = [
        ("itu_p1410", Model::Itu),
        ("alhourani_printed_ab", Model::AlHourani2014Table),
        ("alhourani_poly_ab", Model::AlHourani2014),
        ("holis_pechac", Model::Holis2008),
        ("kang2019", Model::Kang2019),
        ("mohammed2023", Model::Mohammed2023),
        ("saboor2024_phi0_product", Model::Saboor2024),
    ];
    let mut counts = Counts::default();
    for row in &rows {
        let (uav_height_m, theta_deg) = (number(row, "h_m"), number(row, "theta_deg"));
        let built_up = BuiltUp::named(&row["env"]).map_or_else(|| BuiltUp::new(0.435, 4679.0, 8.8), Ok).unwrap();
        // The table's own distance is rounded to a micrometer, which is too coarse for its sixth digit only at steps.
        let distance_m = if theta_deg < 90.0 { uav_height_m / theta_deg.to_radians().tan() } else { 0.0 };
        assert!((distance_m - number(row, "r_m")).abs() < 1e-6);
        let link = ModelLink { built_up, uav_height_m, rx_height_m: 0.0, theta_deg, distance_m, phi_deg: Some(0.0) };
        assert_eq!(itu::m(distance_m, &built_up).to_string(), row["itu_m"], "{link:?}");
        for (column, model) in columns {
            // The table keeps the polynomial for Ghent, where b < 0 makes it 1 at every angle: nonsense, to be refused.
            let nonsense = row["env"] == "ghent" && model == Model::AlHourani2014;
            compare(model, &link, if nonsense { "" } else { &row[column] }, &mut counts);
        }
    }
    // Five cities at 18 angles; the sigmoids and the elevation fit have four cities.
    assert_eq!((rows.len(), counts), (5 * 18, Counts { compared: (4 * 5 + 3 * 4) * 18, refused: 3 * 18 }));
}

#[test]
fn models_of_a_network_give_their_table() {
    let Some(rows) = reference("models_3gpp_reference.csv") else { return };
    let columns = [
        ("rma_av", Model::Tr36777RmaAv),
        ("uma_av", Model::Tr36777UmaAv),
        ("umi_av", Model::Tr36777UmiAv),
        ("rma_38901", Model::Tr38901Rma),
        ("uma_38901", Model::Tr38901Uma),
        ("umi_38901", Model::Tr38901Umi),
    ];
    let mut counts = Counts::default();
    for row in &rows {
        let (uav_height_m, distance_m) = (number(row, "h_ut_m"), number(row, "d2d_m"));
        let theta_deg = uav_height_m.atan2(distance_m).to_degrees();
        let built_up = BuiltUp::named("urban").unwrap();
        let link = ModelLink { built_up, uav_height_m, rx_height_m: 0.0, theta_deg, distance_m, phi_deg: None };
        for (column, model) in columns {
            compare(model, &link, &row[column], &mut counts);
        }
    }
    // 15 heights at 8 distances; 8 of the heights are above 23 m, where the terrestrial UMa has no value.
    assert_eq!(counts, Counts { compared: 6 * 15 * 8 - 8 * 8, refused: 8 * 8 });
}
