//! Rings into polygons, for formats that hold shells and holes side by side.

use super::super::polygon::{Polygon, doubled_area};

/// Assembles polygons from shells and holes in any order. Each hole goes to the smallest shell
/// around it. A hole without a shell around it is a shell itself, written in the wrong sense.
pub(super) fn assembled(shells: Vec<Vec<[f64; 2]>>, holes: Vec<Vec<[f64; 2]>>) -> Vec<Polygon> {
    let mut polygons: Vec<Polygon> = shells.into_iter().map(|shell| vec![shell]).collect();
    let measured: Vec<(f64, [f64; 4])> = polygons.iter().map(|p| (doubled_area(&p[0]).abs(), bounds(&p[0]))).collect();
    let mut alone = Vec::new();
    for hole in holes {
        let box_of_hole = bounds(&hole);
        let is_around = |k: &usize| holds_box(measured[*k].1, box_of_hole) && mostly_inside(&hole, &polygons[*k][0]);
        let smallest = (0..measured.len()).filter(is_around).min_by(|a, b| measured[*a].0.total_cmp(&measured[*b].0));
        match smallest {
            Some(k) => polygons[k].push(hole),
            None => alone.push(vec![hole]),
        }
    }
    polygons.extend(alone);
    polygons
}

/// Returns `true` when a shell lies around a hole.
pub(super) fn surrounds(shell: &[[f64; 2]], hole: &[[f64; 2]]) -> bool {
    holds_box(bounds(shell), bounds(hole)) && mostly_inside(hole, shell)
}

/// Returns `true` when a box holds another.
fn holds_box(outer: [f64; 4], inner: [f64; 4]) -> bool {
    (0..2).all(|i| outer[i] <= inner[i] && outer[i + 2] >= inner[i + 2])
}

/// Returns west, south, east, north of a ring.
fn bounds(ring: &[[f64; 2]]) -> [f64; 4] {
    const NOWHERE: [f64; 4] = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
    ring.iter().fold(NOWHERE, |b, p| [b[0].min(p[0]), b[1].min(p[1]), b[2].max(p[0]), b[3].max(p[1])])
}

/// Returns `true` when more points of a ring are inside another than outside: holes may touch their
/// shell.
fn mostly_inside(ring: &[[f64; 2]], shell: &[[f64; 2]]) -> bool {
    let n_inside = ring.iter().filter(|point| contains(shell, **point)).count();
    2 * n_inside > ring.len()
}

fn contains(ring: &[[f64; 2]], [x, y]: [f64; 2]) -> bool {
    let edges = ring.iter().zip(ring.iter().cycle().skip(1));
    let crossed = edges.filter(|(a, b)| (a[1] <= y) != (b[1] <= y));
    crossed.filter(|(a, b)| a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) <= x).count() % 2 == 1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(from: f64, to: f64) -> Vec<[f64; 2]> {
        vec![[from, from], [to, from], [to, to], [from, to]]
    }

    #[test]
    fn a_hole_goes_to_the_smallest_shell_around_it() {
        let polygons =
            assembled(vec![square(0.0, 90.0), square(20.0, 60.0)], vec![square(30.0, 40.0), square(10.0, 70.0)]);
        assert_eq!(polygons[0], [square(0.0, 90.0), square(10.0, 70.0)]);
        assert_eq!(polygons[1], [square(20.0, 60.0), square(30.0, 40.0)]);
    }

    #[test]
    fn a_hole_without_a_shell_is_one() {
        assert_eq!(assembled(vec![square(0.0, 1.0)], vec![square(5.0, 6.0)]).len(), 2);
        assert!(doubled_area(&square(1e7, 1e7 + 2.0)) > 7.9);
    }
}
