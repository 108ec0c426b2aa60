//! What does one link cost by `ray`, near and far, blocked and clear, in a raster and among footprints?
//!
//! `cargo bench --bench link`. Each case is 256 links from one UAV 100 m over a street in the middle of an urban city of
//! 2048 m, so that no branch predictor learns a single one by heart; the walk starts at the receiver. Before timing, every
//! answer is compared with that of the walk that finds the obstruction.

mod cities;

use std::fmt;
use std::sync::LazyLock;

use divan::Bencher;
use divan::counter::ItemsCount;
use skyshed_core::city::Ground;
use skyshed_core::height_field::{HeightField, Station};
use skyshed_core::los::{link_least_receiver_heights, link_los};
use skyshed_core::quantity::height_steps;

use self::cities::{footprints, raster, surface_of, uav_in_the_middle};

fn main() {
    divan::main();
}

const N: usize = 2048;
const LINKS: usize = 256;

/// Which links.
#[derive(Debug, Clone, Copy)]
enum Case {
    /// To receivers 1.5 m above the ground within 60 m.
    Near,
    /// Clear, to receivers 20 m above the ground, as on roofs, 900 to 1000 m away.
    Far,
    /// To receivers 1.5 m above the ground, 900 to 1000 m away, hidden within a sixteenth of the way.
    BlockedEarly,
    /// To receivers 900 to 1000 m away, as low as they are seen: a roof edge is touched, or missed by one lattice step.
    Grazing,
}

const CASES: [Case; 4] = [Case::Near, Case::Far, Case::BlockedEarly, Case::Grazing];

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Case::Near => "near",
            Case::Far => "far, clear",
            Case::BlockedEarly => "far, blocked early",
            Case::Grazing => "far, grazing",
        })
    }
}

static FOOTPRINTS: LazyLock<HeightField> = LazyLock::new(|| footprints("urban", N));
static RASTER: LazyLock<HeightField> =
    LazyLock::new(|| raster(FOOTPRINTS.grid(), surface_of(&FOOTPRINTS), Ground::Flat(0)));

#[divan::bench(args = CASES)]
fn among_footprints(bencher: Bencher<'_, '_>, case: Case) {
    measure(bencher, &FOOTPRINTS, case);
}

#[divan::bench(args = CASES)]
fn in_a_raster(bencher: Bencher<'_, '_>, case: Case) {
    measure(bencher, &RASTER, case);
}

fn measure(bencher: Bencher<'_, '_>, field: &HeightField, case: Case) {
    let uav = uav_in_the_middle(field, 100.0).station;
    let links = links(field, &uav, case);
    let los = || links.iter().filter(|(receiver, _)| link_los(field, &uav, receiver)).count();
    assert_eq!(links.len(), LINKS, "{case}: too few such links");
    assert!(links.iter().all(|(receiver, wanted)| link_los(field, &uav, receiver) == *wanted), "{case}: wrong");
    bencher.counter(ItemsCount::new(LINKS)).bench(los);
}

/// Receivers of a case, and whether the walk that finds the obstruction has them in line of sight.
fn links(field: &HeightField, uav: &Station, case: Case) -> Vec<(Station, bool)> {
    let (near, far) = match case {
        Case::Near => (0.0, 60.0),
        Case::Far | Case::BlockedEarly | Case::Grazing => (900.0, 1000.0),
    };
    let height_m = if matches!(case, Case::Far) { 20.0 } else { 1.5 };
    let height = i64::from(height_steps(height_m).expect("in range"));
    let positions = field.positions();
    // All cells in an order that jumps about: an odd factor, and N² is a power of two.
    let cells = (0..N * N).map(|k| k.wrapping_mul(0x9E37_79B1) % (N * N));
    cells
        .filter(|cell| field.cells().open.contains(cell / N, cell % N))
        .filter_map(|cell| {
            let place = positions.center(cell / N, cell % N);
            let (dx, dy) = (uav.place.x - place.x, uav.place.y - place.y);
            let distance = dx.hypot(dy);
            if !(near..far).contains(&distance) {
                return None;
            }
            let mut receiver = Station { place, z: height };
            let least = link_least_receiver_heights(field, uav, &receiver);
            let lowest = least.prisms.lowest_step()?.max(least.columns.lowest_step()?);
            let wanted = match case {
                Case::Near => true,
                Case::Far => lowest <= height,
                Case::BlockedEarly => {
                    // Already a sixteenth of the way is.
                    let place = field.place(place.x + dx / 16.0, place.y + dy / 16.0);
                    !link_los(field, &Station { place, z: height + (uav.z - height) / 16 }, &receiver)
                }
                Case::Grazing => {
                    // Every second one stands a step too low.
                    receiver.z = lowest.saturating_sub(i64::from(cell % 2 == 0));
                    lowest > height
                }
            };
            wanted.then_some((receiver, receiver.z >= lowest))
        })
        .take(LINKS)
        .collect()
}
