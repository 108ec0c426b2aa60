//! Footprints: whatever polygon comes in, its pieces cover it exactly; whatever ring comes in, nothing panics.

#![expect(
    clippy::cast_possible_truncation,
    clippy::unwrap_used,
    reason = "small numbers, and a panic is a failed test"
)]

use std::fmt::Write as _;

use rayon::prelude::*;
use skyshed_core::city::{City, Solids};
use skyshed_core::height_field::{Built, ConvexPieces, HeightField, Ring, convex_pieces};
use skyshed_core::overlay::even_odd;
use skyshed_io::read::{FootprintOptions, read_footprints};
use skyshed_request::{MissingHeights, WithoutHeight};

use crate::program::Folder;
use crate::shapes::{doubled_area, rectangle, star, turn};
use crate::support::{Random, is_long};

fn narrow(ring: &[[i64; 2]]) -> Ring {
    ring.iter().map(|p| p.map(|c| i32::try_from(c).unwrap())).collect()
}

fn wide(ring: &[[i32; 2]]) -> Vec<[i64; 2]> {
    ring.iter().map(|p| p.map(i64::from)).collect()
}

/// Cuts a polygon and checks that its pieces are convex, counterclockwise, disjoint and add up to `area` (doubled).
fn check_pieces(rings: &[Vec<[i64; 2]>], area: i64) -> usize {
    let contours: Vec<Ring> = rings.iter().map(|r| narrow(r)).collect();
    // Rings in any order become polygons with the shell first, as they do when a file is read.
    let polygons = even_odd(&contours);
    let cut = polygons.iter().flat_map(|polygon| match convex_pieces(polygon) {
        ConvexPieces::Exact(pieces) => pieces,
        ConvexPieces::Hull(_) => panic!("{rings:?} fell back to its hull"),
    });
    let pieces: Vec<Vec<[i64; 2]>> = cut.map(|p| wide(&p)).collect();
    for piece in &pieces {
        let n = piece.len();
        assert!((0..n).all(|i| turn(piece[i], piece[(i + 1) % n], piece[(i + 2) % n]) > 0), "{piece:?} of {rings:?}");
    }
    assert_eq!(pieces.iter().map(|p| doubled_area(p)).sum::<i64>(), area, "{rings:?}");
    // Two convex pieces are disjoint iff an edge of one of them has the other on its right.
    let parts = |a: &[[i64; 2]], b: &[[i64; 2]]| {
        (0..a.len()).any(|i| b.iter().all(|&p| turn(a[i], a[(i + 1) % a.len()], p) <= 0))
    };
    for (i, a) in pieces.iter().enumerate() {
        assert!(pieces[..i].iter().all(|b| parts(a, b) || parts(b, a)), "overlap in {rings:?}");
    }
    pieces.len()
}

fn scaled(ring: &[[i64; 2]], by: i64, shift: [i64; 2]) -> Vec<[i64; 2]> {
    ring.iter().map(|p| [p[0] * by + shift[0], p[1] * by + shift[1]]).collect()
}

#[test]
fn random_stars_are_cut_into_disjoint_convex_pieces_of_the_same_area() {
    let n = if is_long() { 400_000 } else { 20_000 };
    let n_pieces: usize = (0..n)
        .into_par_iter()
        .map(|seed| {
            let mut random = Random(seed);
            let size = random.choose(&[4, 6, 20, 1000]);
            let by = random.choose(&[1, 512, (1 << 25) / size]);
            let shift = [random.choose(&[0, -(1 << 26), 1 << 25]), random.choose(&[0, -(1 << 25), 12_345])];
            let mut ring = scaled(&star(&mut random, size), by, shift);
            let area = doubled_area(&ring);
            if random.chance(50) {
                ring.reverse();
            }
            check_pieces(&[ring], area)
        })
        .sum();
    assert!(n_pieces > 3 * n as usize);
}

#[test]
fn combs_and_spirals_are_cut_into_disjoint_convex_pieces_of_the_same_area() {
    let mut random = Random(3);
    for _ in 0..if is_long() { 2000 } else { 200 } {
        // Teeth of random length; equal ones leave collinear vertices.
        let mut comb = vec![[0, 0]];
        let n_teeth = random.within(1, 12);
        comb.push([2 * n_teeth, 0]);
        for k in (0..n_teeth).rev() {
            let length = random.within(2, 4);
            comb.extend([[2 * k + 2, 1], [2 * k + 2, length], [2 * k + 1, length], [2 * k + 1, 1]]);
        }
        comb.push([0, 1]);
        comb.dedup();
        let scale = random.choose(&[1, 1024, 1 << 20]);
        let comb = scaled(&comb, scale, [0, -(1 << 25)]);
        check_pieces(std::slice::from_ref(&comb), doubled_area(&comb));
    }
    for n_legs in 3..14 {
        let spiral = spiral(n_legs);
        assert!(is_simple(&spiral), "{spiral:?}");
        for by in [1, 1024, 1 << 20] {
            let spiral = scaled(&spiral, by, [-(1 << 25), 5]);
            check_pieces(std::slice::from_ref(&spiral), doubled_area(&spiral));
        }
    }
}

/// A wall one wide that winds inwards to the left, with gaps of one: along its right side and back along its left.
fn spiral(n_legs: usize) -> Vec<[i64; 2]> {
    let size = 2 * i64::try_from(n_legs).unwrap();
    let (mut right, mut left) = (vec![[0, 0]], vec![[0, 1]]);
    let (mut at, mut ahead) = ([0, 0], [1, 0]);
    for leg in 0..n_legs {
        // Three whole legs, then two by two shorter by two.
        let length = size - i64::try_from((leg.max(1) - 1) / 2 * 2).unwrap();
        at = [at[0] + length * ahead[0], at[1] + length * ahead[1]];
        right.push(at);
        let turned = [-ahead[1], ahead[0]];
        let back = if leg + 1 < n_legs { ahead } else { [0, 0] };
        left.push([at[0] + turned[0] - back[0], at[1] + turned[1] - back[1]]);
        ahead = turned;
    }
    right.extend(left.into_iter().rev());
    right
}

/// Whether no two edges of a ring cross or touch but at the vertex that neighbors share.
fn is_simple(ring: &[[i64; 2]]) -> bool {
    let n = ring.len();
    let side = |a, b, c| turn(a, b, c).signum();
    let boxes_meet = |a: [i64; 2], b: [i64; 2], c: [i64; 2], d: [i64; 2]| {
        (0..2).all(|k| a[k].min(b[k]) <= c[k].max(d[k]) && c[k].min(d[k]) <= a[k].max(b[k]))
    };
    (0..n).all(|i| {
        (0..i).all(|j| {
            let (a, b, c, d) = (ring[i], ring[(i + 1) % n], ring[j], ring[(j + 1) % n]);
            let meet =
                boxes_meet(a, b, c, d) && side(a, b, c) * side(a, b, d) <= 0 && side(c, d, a) * side(c, d, b) <= 0;
            !meet || j + 1 == i || (j == 0 && i == n - 1)
        })
    })
}

#[test]
fn nested_and_touching_holes_are_kept_apart() {
    let mut random = Random(8);
    for _ in 0..if is_long() { 20_000 } else { 2000 } {
        let by = random.choose(&[1, 512, 1 << 18]);
        // Rings inside rings, down to a random depth; neighbors touch where a ring begins at the one around it.
        let mut rings = vec![rectangle(0, 0, 60, 60)];
        let (mut area, mut sign) = (2 * 3600, -1);
        let (mut low, mut high) = (0, 60);
        for _ in 0..random.within(1, 4) {
            // A star inscribed in a square that may touch the ring around it at single vertices.
            let (l, h) = (low + random.within(1, 4), high - random.within(1, 4));
            let middle = (l + h) / 2;
            let touch = if rings.len() == 1 && random.chance(50) { 0 } else { l };
            rings.push(vec![[touch, middle], [l, l], [h, l], [h, h], [l, h]]);
            let hole = rings.last().unwrap();
            area += sign * doubled_area(hole).abs();
            sign = -sign;
            (low, high) = (l, h);
        }
        for ring in &mut rings {
            *ring = scaled(ring, by, [-(1 << 25), 77]);
            if random.chance(50) {
                ring.reverse();
            }
        }
        check_pieces(&rings, area * by * by);
    }
}

// ---------------------------------------------------------------------------------------------------------------------
// Invalid rings, through a file.

fn edges_of(ring: &[[f64; 2]]) -> impl Iterator<Item = [[f64; 2]; 2]> {
    (0..ring.len()).map(|i| [ring[i], ring[(i + 1) % ring.len()]])
}

/// Twice the area of what the first ring encloses less what the others do, all by the even-odd rule: by trapezoids between the
/// heights where anything happens.
fn area_less_holes(rings: &[Vec<[f64; 2]>]) -> f64 {
    let edges: Vec<[[f64; 2]; 2]> = rings.iter().flat_map(|ring| edges_of(ring)).collect();
    let mut levels: Vec<f64> = rings.iter().flatten().map(|p| p[1]).collect();
    for (i, [a, b]) in edges.iter().enumerate() {
        for [c, d] in &edges[..i] {
            let (u, v) = ([b[0] - a[0], b[1] - a[1]], [d[0] - c[0], d[1] - c[1]]);
            let den = u[0] * v[1] - u[1] * v[0];
            let t = ((c[0] - a[0]) * v[1] - (c[1] - a[1]) * v[0]) / den;
            let s = ((c[0] - a[0]) * u[1] - (c[1] - a[1]) * u[0]) / den;
            if den != 0.0 && (0.0..=1.0).contains(&t) && (0.0..=1.0).contains(&s) {
                levels.push(a[1] + t * u[1]);
            }
        }
    }
    levels.sort_by(f64::total_cmp);
    let mut area = 0.0;
    for pair in levels.windows(2).filter(|p| p[1] > p[0]) {
        let middle = (pair[0] + pair[1]) / 2.0;
        // Where each ring is crossed, and how often a place to the right is inside of it.
        let mut crossings: Vec<(f64, usize)> = Vec::new();
        for (k, ring) in rings.iter().enumerate() {
            let crossed = edges_of(ring).filter(|[a, b]| (a[1] <= middle) != (b[1] <= middle));
            crossings.extend(crossed.map(|[a, b]| (a[0] + (middle - a[1]) / (b[1] - a[1]) * (b[0] - a[0]), k)));
        }
        crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut inside = vec![false; rings.len()];
        for pair_x in crossings.windows(2) {
            inside[pair_x[0].1] ^= true;
            if inside[0] && !inside[1..].contains(&true) {
                area += (pair_x[1].0 - pair_x[0].0) * (pair[1] - pair[0]);
            }
        }
    }
    2.0 * area
}

/// Rings that may cross and touch themselves and each other, on a lattice in meters; often spikes and repeated points.
fn any_rings(random: &mut Random) -> Vec<Vec<[f64; 2]>> {
    let grain = random.choose(&[1.0, 0.5, 1.0 / 1024.0, 0.37, 3.0]);
    let largest = random.choose(&[3, 6, 40]);
    (0..random.within(1, 3))
        .map(|_| {
            let mut ring: Vec<[f64; 2]> = Vec::new();
            for _ in 0..random.within(0, 12) {
                let point = match (random.within(0, 9), ring.len()) {
                    (0, n) if n > 0 => ring[n - 1],
                    (1, n) if n > 1 => ring[n - 2],
                    _ => [random.within(0, largest) as f64 * grain, random.within(0, largest) as f64 * grain],
                };
                ring.push(point);
            }
            ring
        })
        .collect()
}

fn feature(rings: &[Vec<[f64; 2]>], is_closed: bool) -> String {
    let mut text =
        String::from(r#"{"type":"Feature","properties":{"height":9},"geometry":{"type":"Polygon","coordinates":["#);
    for (k, ring) in rings.iter().enumerate() {
        let first = ring.first().filter(|_| is_closed);
        let points: Vec<String> = ring.iter().chain(first).map(|[x, y]| format!("[{x},{y}]")).collect();
        write!(text, "{}[{}]", if k > 0 { "," } else { "" }, points.join(",")).unwrap();
    }
    text + "]}}"
}

fn read(features: &[String], name: &str) -> City {
    let folder = Folder::new();
    folder.write(name, &format!(r#"{{"type":"FeatureCollection","features":[{}]}}"#, features.join(",")));
    let options = FootprintOptions {
        missing: MissingHeights::only(WithoutHeight::Fail),
        extent: Some([0.0, 0.0, 130.0, 130.0]),
        cell_m: Some(10.0),
        ..FootprintOptions::default()
    };
    read_footprints(folder.join(name), &options, &mut Vec::new()).unwrap()
}

#[test]
fn ten_thousand_invalid_polygons_keep_the_area_of_their_shells_less_holes_and_are_triangulated() {
    let n = if is_long() { 30_000 } else { 10_000 };
    let mut random = Random(99);
    // One feature of 130 m first, so that no file looks like degrees.
    let frame = vec![[0.0, 0.0], [130.0, 0.0], [130.0, 130.0], [0.0, 130.0]];
    let all: Vec<Vec<Vec<[f64; 2]>>> = (0..n).map(|_| any_rings(&mut random)).collect();
    let mut features = vec![feature(&[frame], true)];
    features.extend(all.iter().enumerate().map(|(k, rings)| feature(rings, k % 3 > 0)));
    let scene = read(&features, "invalid.geojson");
    let Solids::Vector { footprints, .. } = &scene.solids else { panic!("footprints make a vector scene") };
    let mut found = vec![0.0; n + 1];
    for footprint in footprints {
        let index = footprint.id.parse::<usize>().unwrap() - 1;
        let area = |ring: &Vec<[i32; 2]>| doubled_area(&wide(ring)).abs() as f64;
        for polygon in &footprint.polygons {
            found[index] += area(&polygon[0]) - polygon[1..].iter().map(area).sum::<f64>();
        }
    }
    assert!((found[0] - 2.0 * (130.0_f64 * 1024.0).powi(2)).abs() < 0.5, "the frame is the first");
    let mut n_empty = 0;
    for (k, rings) in all.iter().enumerate() {
        let rounded: Vec<Vec<[f64; 2]>> =
            rings.iter().map(|r| r.iter().map(|p| p.map(|c| (c * 1024.0 + 0.5).floor())).collect::<Vec<_>>()).collect();
        let wanted = area_less_holes(&rounded);
        // Rounding a crossing to the lattice moves an edge by at most one step; a moved edge may meet another and be
        // rounded again, here at most a few times. An edge of length l that moves by d sweeps at most l·d; doubled, 2·l·d.
        let edges = rounded.iter().flat_map(|ring| edges_of(ring));
        let length: f64 = edges.map(|[a, b]| (a[0] - b[0]).hypot(a[1] - b[1])).sum();
        let tolerance = 2.0 * length * 2.0 + 1e-6 * wanted;
        assert!((found[k + 1] - wanted).abs() <= tolerance, "{rings:?}: {} for {wanted} ± {tolerance}", found[k + 1]);
        n_empty += usize::from(wanted == 0.0);
    }
    assert!(n_empty > n / 20 && n_empty < n / 2, "{n_empty} of {n} are empty");
    let Built { field, warnings } = HeightField::build(&scene.grid, scene.solids.clone());
    assert_eq!(warnings.len(), 0, "{warnings:?}");
    let pieces = field.prisms().unwrap();
    let covered: f64 = pieces.pieces().iter().map(|p| doubled_area(&wide(pieces.ring(p))) as f64).sum();
    assert!((covered - found.iter().sum::<f64>()).abs() < 0.5);
}
