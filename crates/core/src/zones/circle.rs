//! Points on one circle, in exact integers.

use ethnum::I256;

/// Bound on the rounding errors of the determinant in f64, as a share of the sum of its terms'
/// magnitudes (Shewchuk 1997, `iccerrboundA`). Differences of coordinates are exact.
const ERROR_SHARE: f64 = (10.0 + 96.0 * UNIT) * UNIT;
/// Half the distance from 1 to the next f64.
const UNIT: f64 = f64::EPSILON / 2.0;

/// Returns `true` if four points lie on one circle, or on one line.
///
/// Coordinates are within ±2^48. EXACT: the determinant is below 2^204.
pub(super) fn are_on_one_circle(points: [[i64; 2]; 4]) -> bool {
    let [a, b, c, d] = points;
    let from_d = [a, b, c].map(|p| [p[0] - d[0], p[1] - d[1]]);
    let rotated = [[0, 1, 2], [1, 2, 0], [2, 0, 1]];
    #[expect(clippy::cast_precision_loss, reason = "below 2^50")]
    let near = from_d.map(|p| p.map(|v| v as f64));
    let (mut determinant, mut size) = (0.0, 0.0);
    for [p, q, r] in rotated.map(|order| order.map(|k| near[k])) {
        let lift = p[0] * p[0] + p[1] * p[1];
        let (left, right) = (q[0] * r[1], q[1] * r[0]);
        determinant += lift * (left - right);
        size += lift * (left.abs() + right.abs());
    }
    if determinant.abs() > ERROR_SHARE * size {
        return false;
    }
    let wide = from_d.map(|p| p.map(i128::from));
    let exact = rotated.map(|order| {
        let [p, q, r] = order.map(|k| wide[k]);
        I256::from(p[0] * p[0] + p[1] * p[1]) * I256::from(q[0] * r[1] - q[1] * r[0])
    });
    exact[0] + exact[1] + exact[2] == I256::ZERO
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_off_the_circle_is_off_it_however_large_it_is() {
        // 65² = 16² + 63² = 25² + 60² = 33² + 56² = 39² + 52².
        let on_circle = [[16, 63], [-25, 60], [-33, -56], [39, -52], [63, 16], [-60, 25], [65, 0], [0, -65]];
        for scale in [1, 1024, 1 << 20, 1 << 40] {
            for shift in [0, 1 << 47] {
                let place = |p: [i64; 2]| [p[0] * scale + shift, p[1] * scale - shift];
                for k in 0..on_circle.len() {
                    let four = [0, 1, 3, 6].map(|n| place(on_circle[(k + n) % on_circle.len()]));
                    assert!(are_on_one_circle(four), "{four:?}");
                    let [x, y] = four[3];
                    assert!(!are_on_one_circle([four[0], four[1], four[2], [x + 1, y]]));
                    assert!(!are_on_one_circle([[four[0][0], four[0][1] - 1], four[1], four[2], four[3]]));
                }
            }
        }
    }
}
