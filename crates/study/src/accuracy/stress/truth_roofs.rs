//! Truth among roofs that are planes, from the definition and their corners alone.
//!
//! The link runs from the UAV at t = 0 to the receiver at t = 1. Three events can change the roofs
//! to its left and right, the highest of them, or whether the ray is below that:
//!
//! * the link meets the line of an edge, or a corner of one;
//! * the ray meets the plane of a roof;
//! * two planes are level.
//!
//! So each stretch between two such t is decided in its middle. It blocks if on both sides some
//! roof that holds that side is above the ray.
//!
//! Numbers: positions are divided by their common divisor and are then below 2^10; heights are
//! below 2^17. A height over a plane, times twice the area of its triangle, is below 2^40. Each t
//! is a fraction of terms below 2^62, and all products are below 2^126, inside i128.

use crate::city::RoofTriangle;
use crate::quantity::LatticePoint;

/// Bounds of positions, in units of their common divisor, and of heights \[1/1024 m\].
const MOST: (i128, i128) = (1 << 10, 1 << 17);

/// Vector or position in the plane.
type Plane = [i128; 2];

/// Roof triangle, and the height of the ray above its plane at both ends, times `area`.
struct Roof {
    ring: [Plane; 3],
    ends: [i128; 2],
    area: i128,
}

/// Returns `true` if a link to a receiver on open ground is LoS; `None` for numbers out of range.
pub(super) fn roofs_truth(roofs: &[RoofTriangle], uav: LatticePoint, receiver: LatticePoint) -> Option<bool> {
    let corners = roofs.iter().flatten().map(|[x, y, _]| [i64::from(*x), i64::from(*y)]);
    let positions = || corners.clone().chain([[uav.x, uav.y], [receiver.x, receiver.y]]);
    let unit = positions().flatten().fold(0, |a, b| common_divisor(a, b.abs())).max(1);
    let plan = |x: i64, y: i64| [i128::from(x / unit), i128::from(y / unit)];
    let (u, way) = (plan(uav.x, uav.y), sub(plan(receiver.x, receiver.y), plan(uav.x, uav.y)));
    let heights = roofs.iter().flatten().map(|corner| i64::from(corner[2])).chain([uav.z, receiver.z]);
    let are_small = positions().flatten().all(|v| i128::from(v / unit).abs() < MOST.0);
    if !are_small || !heights.clone().all(|z| i128::from(z).abs() < MOST.1) {
        return None;
    }
    if way == [0, 0] {
        // Nothing is above open ground.
        return Some(true);
    }
    let roofs: Vec<Roof> = roofs
        .iter()
        .map(|corners| {
            let ring = corners.map(|[x, y, _]| plan(x.into(), y.into()));
            let [a, b, c] = ring;
            let [za, zb, zc] = corners.map(|[.., z]| i128::from(z));
            let area = cross(sub(b, a), sub(c, a));
            let above = |p: Plane, z: i128| {
                // Shares of the corners, times the area.
                let (of_b, of_c) = (cross(sub(p, a), sub(c, a)), cross(sub(b, a), sub(p, a)));
                z * area - (za * (area - of_b - of_c) + zb * of_b + zc * of_c)
            };
            let ends = [above(u, uav.z.into()), above([u[0] + way[0], u[1] + way[1]], receiver.z.into())];
            Roof { ring, ends, area }
        })
        .collect();
    let mut meets: Vec<(i128, i128)> = vec![(0, 1), (1, 1)];
    // Adds the t at which a linear function of these values at both ends is 0.
    let mut zero = |from: i128, to: i128| {
        let (n, d) = if from > to { (from, from - to) } else { (-from, to - from) };
        if n > 0 && n < d {
            meets.push((n, d));
        }
    };
    for (k, roof) in roofs.iter().enumerate() {
        for (a, b) in edges(&roof.ring) {
            let side = |p: Plane| cross(sub(b, a), sub(p, a));
            zero(side(u), side([u[0] + way[0], u[1] + way[1]]));
            let along = |p: Plane| (p[0] - a[0]) * way[0] + (p[1] - a[1]) * way[1];
            zero(along(u), along([u[0] + way[0], u[1] + way[1]]));
        }
        zero(roof.ends[0], roof.ends[1]);
        for other in &roofs[..k] {
            let [from, to] = [0, 1].map(|end| roof.ends[end] * other.area - other.ends[end] * roof.area);
            zero(from, to);
        }
    }
    meets.sort_unstable_by(|a, b| (a.0 * b.1).cmp(&(b.0 * a.1)));
    let middle = |pair: &[(i128, i128)]| (pair[0].0 + pair[1].0, pair[0].1 + pair[1].1);
    let is_empty = |pair: &[(i128, i128)]| pair[0].0 * pair[1].1 == pair[1].0 * pair[0].1;
    Some(meets.windows(2).filter(|pair| !is_empty(pair)).map(middle).all(|(n, d)| {
        let p = [0, 1].map(|k| u[k] * d + way[k] * n);
        // Roofs above the ray that hold the points just beside the link.
        let blocks = |beside: i128| {
            roofs.iter().any(|roof| {
                let holds = edges(&roof.ring).into_iter().all(|(a, b)| {
                    let side = cross(sub(b, a), sub(p, a.map(|v| v * d)));
                    let along = (b[0] - a[0]) * way[0] + (b[1] - a[1]) * way[1];
                    side > 0 || (side == 0 && along * beside > 0)
                });
                holds && roof.ends[0] * (d - n) + roof.ends[1] * n < 0
            })
        };
        !(blocks(1) && blocks(-1))
    }))
}

fn edges([a, b, c]: &[Plane; 3]) -> [(Plane, Plane); 3] {
    [(*a, *b), (*b, *c), (*c, *a)]
}

fn sub(a: Plane, b: Plane) -> Plane {
    [a[0] - b[0], a[1] - b[1]]
}

fn cross(a: Plane, b: Plane) -> i128 {
    a[0] * b[1] - a[1] * b[0]
}

fn common_divisor(a: i64, b: i64) -> i64 {
    if b == 0 { a } else { common_divisor(b, a % b) }
}
