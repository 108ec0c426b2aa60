//! The engine against the referee and against single links.

use std::cmp::Ordering;

use ethnum::I256;

use super::hidden::{HiddenPart, HiddenParts, LegObstacle};
use super::inside::inside_prisms;
use super::links::{LegWindow, Links, Shape};
use super::over_columns::hide_by_columns;
use super::over_prisms::hide_by_prisms;
use super::place::{LegPart, LegPlace, common_parts, merged_parts, total_length};
use super::tests_oracle::{P3, Q, Seen};
use super::tests_scenes::{Dice, Scene};
use crate::los::{columns_los, prisms_los};
use crate::quantity::LatticePoint;

fn lattice(p: P3) -> LatticePoint {
    let [x, y, z] = p.map(|v| i64::try_from(v).unwrap());
    LatticePoint { x, y, z }
}

fn links(seen: &Seen, window: LegWindow) -> Links {
    Links::new(lattice(seen.o), [lattice(seen.a), lattice(seen.b)], window)
}

fn hidden(scene: &Scene, seen: &Seen, window: LegWindow) -> Vec<HiddenPart> {
    let links = links(seen, window);
    let mut hidden = HiddenParts::within(window.part());
    if let Some(prisms) = &scene.prisms {
        hide_by_prisms(prisms, &links, &mut hidden);
    }
    if let Some(columns) = &scene.columns {
        hide_by_columns(columns, &links, &mut hidden);
    }
    hidden.into_parts()
}

fn rational(place: &LegPlace) -> Q {
    let (num, den) = place.terms();
    Q::new(num.as_i128(), den.as_i128())
}

fn rationals(parts: impl IntoIterator<Item = LegPart>) -> Vec<[Q; 2]> {
    parts.into_iter().map(|part| [rational(&part.from), rational(&part.to)]).collect()
}

/// A number of legs: all of them only where `SKYSHED_LONG` is set.
fn legs(all: u64) -> u64 {
    if std::env::var_os("SKYSHED_LONG").is_some() { all } else { all / 20 }
}

#[test]
fn hidden_parts_are_those_of_the_referee() {
    let (mut partly, mut wholly) = (0, 0);
    for seed in 0..legs(10_000) {
        let mut dice = Dice::new(seed);
        let scene = Scene::random(&mut dice);
        let seen = scene.leg(&mut dice);
        let want = seen.hidden(&scene.kinds);
        let got = rationals(hidden(&scene, &seen, LegWindow::WHOLE).iter().map(HiddenPart::part));
        assert_eq!(got, want, "seed {seed}: {seen:?} in {:?}", scene.kinds);
        wholly += u32::from(want == [[Q::from_integer(0), Q::from_integer(1)]]);
        partly += u32::from(!want.is_empty());
    }
    assert!(wholly > 100 && partly > wholly + 100, "{partly} legs are hidden, {wholly} of them wholly");
}

#[test]
fn parts_inside_prisms_are_those_of_the_referee() {
    let mut partly = 0;
    for seed in 0..legs(10_000) {
        let mut dice = Dice::new(1 << 32 | seed);
        let scene = Scene::random(&mut dice);
        let seen = scene.leg(&mut dice);
        let Some(prisms) = &scene.prisms else { continue };
        let want = seen.inside(&scene.kinds[0]);
        let mut parts = Vec::new();
        let leg = Seen { o: seen.a, ..seen };
        inside_prisms(prisms, &links(&leg, LegWindow::WHOLE), &mut parts);
        assert_eq!(rationals(merged_parts(parts)), want, "seed {seed}: {seen:?} in {:?}", scene.kinds);
        partly += u32::from(!want.is_empty());
    }
    assert!(partly > 50, "{partly} legs are partly inside");
}

/// A leg of `n` steps from its start, seen from somewhere.
fn stepped(scene: &Scene, dice: &mut Dice) -> (Seen, i128) {
    let seen = scene.leg(dice);
    let n = i128::from(dice.roll(2, 6));
    (Seen { b: [0, 1, 2].map(|k| seen.a[k] + n * (seen.b[k] - seen.a[k])), ..seen }, n)
}

/// The place after some of `n` steps of a leg.
fn at(seen: &Seen, step: i128, n: i128) -> P3 {
    [0, 1, 2].map(|k| seen.a[k] + step * (seen.b[k] - seen.a[k]) / n)
}

/// Compares a leg of `n` steps with the links to their ends, and counts those with and without line
/// of sight.
fn compare_with_links(scene: &Scene, seen: &Seen, n: i128, checked: &mut [u32; 2], seed: u64) {
    let parts: Vec<LegPart> = hidden(scene, seen, LegWindow::WHOLE).iter().map(HiddenPart::part).collect();
    let candidates: Vec<Q> = scene.kinds.iter().flat_map(|solids| seen.candidates(solids)).collect();
    // Links through a place where the state may change say nothing of what is beside it.
    for step in (0..=n).filter(|step| !candidates.contains(&Q::new(*step, n))) {
        let s = LegPlace::new(step, n);
        let is_hidden = parts.iter().any(|part| part.from < s && s < part.to);
        let (o, p) = (lattice(seen.o), lattice(at(seen, step, n)));
        let is_los = scene.prisms.as_ref().is_none_or(|prisms| prisms_los(prisms, o, p))
            && scene.columns.as_ref().is_none_or(|columns| columns_los(columns, o, p));
        assert_eq!(!is_hidden, is_los, "seed {seed}, step {step} of {n}: {seen:?} in {:?}", scene.kinds);
        checked[usize::from(is_los)] += 1;
    }
}

#[test]
fn hidden_parts_agree_with_single_links_at_places_of_the_lattice() {
    let mut checked = [0, 0];
    for seed in 0..legs(50_000) {
        let mut dice = Dice::new(2 << 32 | seed);
        let scene = Scene::random(&mut dice);
        let (seen, n) = stepped(&scene, &mut dice);
        compare_with_links(&scene, &seen, n, &mut checked, seed);
    }
    assert!(checked.iter().all(|n| *n > 500), "{checked:?} links");
}

#[test]
fn over_prisms_a_link_and_its_reverse_are_hidden_alike() {
    let mut checked = 0;
    for seed in 0..legs(50_000) {
        let mut dice = Dice::new(3 << 32 | seed);
        let scene = Scene::random(&mut dice).without_columns();
        let Some(_) = &scene.prisms else { continue };
        let (seen, n) = stepped(&scene, &mut dice);
        let parts = rationals(hidden(&scene, &seen, LegWindow::WHOLE).iter().map(HiddenPart::part));
        let candidates = seen.candidates(&scene.kinds[0]);
        for step in (0..=n).filter(|step| !candidates.contains(&Q::new(*step, n))) {
            let s = Q::new(step, n);
            let p = at(&seen, step, n);
            let back = hidden(&scene, &Seen { o: p, a: seen.o, b: seen.o }, LegWindow::WHOLE);
            let is_hidden = parts.iter().any(|part| part[0] < s && s < part[1]);
            assert_eq!(is_hidden, !back.is_empty(), "seed {seed}, s = {s}: {seen:?} in {:?}", scene.kinds);
            checked += 1;
        }
    }
    assert!(checked > 1000, "{checked} links");
}

#[test]
fn a_window_holds_its_share_of_what_the_whole_leg_hides() {
    for seed in 0..legs(50_000) {
        let mut dice = Dice::new(4 << 32 | seed);
        let scene = Scene::random(&mut dice);
        let seen = scene.leg(&mut dice);
        let whole = hidden(&scene, &seen, LegWindow::WHOLE);
        let n = dice.roll(2, 12);
        let from = dice.roll(0, n - 1);
        let window = LegWindow::new((from, n), (dice.roll(from + 1, n), n));
        let want = rationals(whole.iter().filter_map(|part| part.part().and(&window.part())));
        let got = rationals(hidden(&scene, &seen, window).iter().map(HiddenPart::part));
        assert_eq!(got, want, "seed {seed}: {window:?} of {seen:?} in {:?}", scene.kinds);
    }
}

#[test]
fn a_magnified_scene_hides_the_same_parts() {
    for seed in 0..legs(50_000) {
        let mut dice = Dice::new(5 << 32 | seed);
        let scene = Scene::random(&mut dice);
        let seen = scene.leg(&mut dice);
        // Sloped roofs span at most 2^20 steps, legs 2^27. Products of these odd factors are rounded
        // in doubles.
        let (plane, height) = (3_i64.pow(if scene.is_sloped() { 10 } else { 14 }), 3_i64.pow(13));
        let magnify = |p: P3| [p[0] * i128::from(plane), p[1] * i128::from(plane), p[2] * i128::from(height)];
        let want = hidden(&scene, &seen, LegWindow::WHOLE);
        let seen = Seen { o: magnify(seen.o), a: magnify(seen.a), b: magnify(seen.b) };
        let got = hidden(&scene.magnified(plane, height, |_| 0), &seen, LegWindow::WHOLE);
        let parts = |parts: &[HiddenPart]| parts.iter().map(HiddenPart::part).collect::<Vec<_>>();
        assert_eq!(parts(&got), parts(&want), "seed {seed}: {seen:?} in {:?}", scene.kinds);
    }
}

#[test]
fn coincidences_that_are_missed_by_a_step_agree_with_single_links() {
    let mut checked = [0, 0];
    for seed in 0..legs(50_000) {
        let mut dice = Dice::new(6 << 32 | seed);
        let scene = Scene::random(&mut dice);
        let (seen, n) = stepped(&scene, &mut dice);
        let (plane, height) = if scene.is_sloped() { (1 << 10, 1 << 4) } else { (1 << 20, 1 << 10) };
        let mut near = |p: P3| {
            let mut moved = |v: i128, factor: i64| v * i128::from(factor) + i128::from(dice.roll(-1, 1));
            [moved(p[0], plane), moved(p[1], plane), moved(p[2], height)]
        };
        let (o, a) = (near(seen.o), near(seen.a));
        let step = near([0, 1, 2].map(|k| (seen.b[k] - seen.a[k]) / n));
        let seen = Seen { o, a, b: [0, 1, 2].map(|k| a[k] + n * step[k]) };
        // Walls that are shared stay so.
        let shifts = [0; 16].map(|_| dice.roll(-1, 1));
        let scene = scene.magnified(plane, height, |v| shifts[usize::try_from(v).unwrap_or(15).min(15)]);
        compare_with_links(&scene, &seen, n, &mut checked, seed);
    }
    assert!(checked.iter().all(|n| *n > 500), "{checked:?} links");
}

#[test]
fn a_vertical_leg_over_a_sloped_roof_is_hidden_below_its_exact_height() {
    let mut partly = 0;
    for seed in 0..legs(20_000) {
        let mut dice = Dice::new(11 << 32 | seed);
        let scene = Scene::random(&mut dice).without_columns();
        let [x, y] = [0; 2].map(|_| i128::from(dice.roll(0, 12)));
        let [o, a, b] = [9, dice.roll(-1, 8), dice.roll(-1, 8)].map(|z| [x, y, i128::from(z)]);
        let seen = Seen { o, a, b };
        let want = seen.hidden(&scene.kinds);
        let got = rationals(hidden(&scene, &seen, LegWindow::WHOLE).iter().map(HiddenPart::part));
        assert_eq!(got, want, "seed {seed}: {seen:?} in {:?}", scene.kinds);
        partly += u32::from(want.iter().flatten().any(|s| !s.is_integer()));
    }
    assert!(partly > 20, "{partly} legs are partly hidden");
}

#[test]
fn the_obstacle_hides_most_of_a_part() {
    let mut checked = 0;
    for seed in 0..legs(50_000) {
        let mut dice = Dice::new(7 << 32 | seed);
        let scene = Scene::random(&mut dice).without_columns();
        let seen = scene.leg(&mut dice);
        let Some(prisms) = &scene.prisms else { continue };
        if !matches!(links(&seen, LegWindow::WHOLE).shape(), Shape::Spread) {
            continue;
        }
        for part in hidden(&scene, &seen, LegWindow::WHOLE) {
            let of = |piece: usize| hidden(&scene.alone(piece), &seen, LegWindow::WHOLE);
            let within = |piece: usize| {
                of(piece).iter().filter_map(|of| of.part().and(&part.part())).map(|of| of.length()).sum()
            };
            let hides: Vec<f64> = (0..prisms.pieces().len()).map(within).collect();
            let most = hides.iter().copied().fold(0.0, f64::max);
            assert!(part.obstacle == LegObstacle::Piece(hides.iter().position(|h| *h >= most).unwrap()), "seed {seed}");
            checked += 1;
        }
    }
    assert!(checked > 100, "{checked} parts");
}

#[test]
fn places_compare_exactly_where_products_overflow() {
    let place = |num: I256, den: I256| LegPlace::of_terms(num, den);
    let (third, big) = (I256::from(1) << 152, I256::from(1) << 153);
    let exact = place(third, third * 3);
    assert_eq!(exact.cmp(&place(big, big * 3)), Ordering::Equal);
    assert_eq!(exact.cmp(&place(big + 1, big * 3)), Ordering::Less);
    assert_eq!(exact.cmp(&place(big, big * 3 + 1)), Ordering::Greater);
    assert_eq!(LegPlace::new(-2, -3), LegPlace::new(2, 3));
    assert!(LegPlace::new(-1, 3) < LegPlace::START);
}

#[test]
fn lists_of_parts_are_merged_and_shared() {
    let part = |from: i128, to: i128| LegPart { from: LegPlace::new(from, 12), to: LegPlace::new(to, 12) };
    let merged = merged_parts(vec![part(6, 8), part(0, 2), part(2, 3), part(7, 9)]);
    assert_eq!(merged, [part(0, 3), part(6, 9)]);
    assert_eq!(common_parts([&merged[..], &[part(1, 7)], &[part(0, 2), part(3, 12)]]), [part(1, 2), part(6, 7)]);
    assert_eq!(common_parts([]), [LegPart::WHOLE]);
    assert!((total_length(merged) - 0.5).abs() < 1e-15);
}
