//! Turns of rings on the lattice, exactly.

use crate::overlay::Ring;

/// Returns twice the signed area of the triangle `a`, `b`, `c`. Coordinates differ by at most 2^28,
/// so this is exact.
pub(super) fn turn(a: [i32; 2], b: [i32; 2], c: [i32; 2]) -> i64 {
    let d = |p: [i32; 2], q: [i32; 2]| (i64::from(q[0]) - i64::from(p[0]), i64::from(q[1]) - i64::from(p[1]));
    let ((ux, uy), (vx, vy)) = (d(a, b), d(a, c));
    ux * vy - uy * vx
}

pub(super) fn without_collinear(ring: &[[i32; 2]]) -> Ring {
    let mut kept: Ring = Vec::with_capacity(ring.len());
    for &p in ring {
        while kept.last() == Some(&p) || (kept.len() >= 2 && turn(kept[kept.len() - 2], kept[kept.len() - 1], p) == 0) {
            kept.pop();
        }
        kept.push(p);
    }
    // The seam between the last and the first point.
    loop {
        let n = kept.len();
        if n >= 3 && turn(kept[n - 2], kept[n - 1], kept[0]) == 0 {
            kept.pop();
        } else if n >= 3 && turn(kept[n - 1], kept[0], kept[1]) == 0 {
            kept.remove(0);
        } else {
            return kept;
        }
    }
}
