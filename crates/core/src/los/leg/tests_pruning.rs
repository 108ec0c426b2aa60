//! Scenes of many buckets and tiles: what is ruled out in doubles would have changed nothing, not
//! even an obstacle.

use super::hidden::{HiddenPart, HiddenParts, LegObstacle};
use super::links::{LegWindow, Links, Shape};
use super::tests_scenes::Dice;
use super::upright::CellAlong;
use super::{over_columns, over_prisms};
use crate::height_field::{Columns, Prisms, Top};
use crate::quantity::{LatticePoint, VOID};

/// Lattice steps of a coordinate: coarse, so that walls and legs often meet.
const COARSE: i64 = 256;

fn small(v: i64) -> i32 {
    i32::try_from(v).unwrap()
}

fn point(dice: &mut Dice, size: i64, highest: i64) -> LatticePoint {
    let mut plan = || COARSE * dice.roll(-size / 8, size + size / 8);
    let (x, y) = (plan(), plan());
    LatticePoint { x, y, z: 64 * dice.roll(0, highest) }
}

/// Links whose plan is a triangle, to a leg over a square of some size.
fn links(dice: &mut Dice, size: i64, highest: i64) -> Links {
    let ends = [point(dice, size, highest / 2), point(dice, size, highest / 2)];
    let links = Links::new(point(dice, size, highest), ends, LegWindow::WHOLE);
    if matches!(links.shape(), Shape::Spread) { links } else { self::links(dice, size, highest) }
}

fn assert_equal(got: &[HiddenPart], want: &[HiddenPart], seed: u64) {
    let of = |parts: &[HiddenPart]| parts.iter().map(|part| (part.part(), part.obstacle)).collect::<Vec<_>>();
    assert_eq!(of(got), of(want), "seed {seed}");
}

#[test]
fn all_pieces_hide_what_those_hide_that_are_not_ruled_out() {
    let size = 800;
    let mut parts = 0;
    for seed in 0..30 {
        let mut dice = Dice::new(9 << 32 | seed);
        let pieces = (0..300).map(|_| {
            let [x, y] = [0; 2].map(|_| small(COARSE * dice.roll(0, size)));
            let [w, h] = [0; 2].map(|_| small(COARSE * dice.roll(4, 60)));
            let ring = if dice.roll(0, 1) == 0 {
                vec![[x, y], [x + w, y], [x + w, y + h], [x, y + h]]
            } else {
                vec![[x, y], [x + w, y], [x, y + h]]
            };
            let heights = [0; 3].map(|_| small(1024 * dice.roll(2, 20)));
            (ring.clone(), if ring.len() == 3 { Top::Sloped(heights.to_vec()) } else { Top::Flat(heights[0]) }, 0)
        });
        let prisms = Prisms::with_tops(pieces.collect::<Vec<_>>());
        for _ in 0..20 {
            let links = links(&mut dice, size, 800);
            let mut got = HiddenParts::within(LegWindow::WHOLE.part());
            over_prisms::hide_by_prisms(&prisms, &links, &mut got);
            let (mut all, mut cut) = (HiddenParts::within(LegWindow::WHOLE.part()), over_prisms::Cut::of(&links));
            for piece in 0..prisms.pieces().len() {
                if let Some(part) = cut.hidden_by(&prisms, &[piece]) {
                    all.add(part, LegObstacle::Piece(piece));
                }
            }
            let (got, all) = (got.into_parts(), all.into_parts());
            assert_equal(&got, &all, seed);
            parts += all.len();
        }
    }
    assert!(parts > 600, "{parts} parts");
}

#[test]
fn all_cells_hide_what_those_hide_that_are_not_ruled_out() {
    let mut parts = 0;
    for seed in 0..12 {
        let mut dice = Dice::new(10 << 32 | seed);
        let (n_rows, n_cols) = ([70, 150][usize::from(seed % 2 == 0)], 133);
        let (rare, noise) = (dice.roll(2, 60), dice.roll(1, 64));
        let top = |dice: &mut Dice| match dice.roll(1, rare) {
            1 => VOID,
            2 => small(1024 * dice.roll(5, 40)),
            _ => small(64 * dice.roll(0, noise)),
        };
        let tops: Vec<i32> = (0..n_rows * n_cols).map(|_| top(&mut dice)).collect();
        let columns = Columns::new(n_rows, n_cols, tops);
        for _ in 0..8 {
            let links = links(&mut dice, 4 * 150, 400);
            let mut got = HiddenParts::within(LegWindow::WHOLE.part());
            over_columns::hide_by_columns(&columns, &links, &mut got);
            let (mut all, mut cut) =
                (HiddenParts::within(LegWindow::WHOLE.part()), over_columns::Cut::of(&columns, &links));
            for (index, top) in columns.tops().iter().enumerate().filter(|(_, top)| **top > VOID) {
                let at = [index % n_cols, n_rows - 1 - index / n_cols].map(|k| i64::try_from(k).unwrap());
                cut.hide_by(&CellAlong { at: (at[0], at[1]), index, top: *top }, true, &mut all);
            }
            let (got, all) = (got.into_parts(), all.into_parts());
            assert_equal(&got, &all, seed);
            parts += all.len();
        }
    }
    assert!(parts > 300, "{parts} parts");
}
