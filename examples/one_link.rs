//! The shortest use: one generated city, two points, one answer with its reason.
//!
//! `cargo run --release --example one_link`

#![expect(clippy::print_stdout, reason = "an example shows its result")]

use skyshed::Result;
use skyshed::prelude::*;
use skyshed_core::city::BuiltUp;

fn main() -> Result<()> {
    let city = Scene::options().size(500.0).open("itu:urban")?;
    // A UAV over a crossroad, and a receiver 1.5 m above the street, farther and farther to the east.
    let built_up = BuiltUp::named("urban").expect("a named environment");
    let crossroad = 5.0 * built_up.period() + built_up.street_width() / 2.0;
    for east in [0.0, 60.0, 120.0, 180.0] {
        let receiver = (crossroad + east, crossroad + 30.0 + built_up.street_width() / 2.0);
        let link = city.link(Uav::new(crossroad, crossroad, Height::agl(60.0)), receiver, Height::agl(1.5))?;
        let verdict = if link.los() { "LoS" } else { "NLoS" };
        let margin = link.margin_m().map_or("none".to_string(), |margin| format!("{margin:.1} m"));
        let reason = link.obstruction().map_or("nothing in the way".to_string(), |o| {
            let roof = o.roof_height_m.map_or(String::new(), |roof| format!(", its roof at {roof:.1} m"));
            format!("{} {}{roof}", o.kind, o.id.as_deref().unwrap_or_default())
        });
        println!("{east:>4} m east: {verdict:<4} with a margin of {margin} ({reason})");
    }
    Ok(())
}
