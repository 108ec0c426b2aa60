//! Line of sight among prisms with plane tops, by the definition.
//!
//! A prism stands over a triangle, solid from far below up to the plane through its three corners. The ray is blocked if and only if somewhere on
//! it both sides are solid above it. What can change that along the ray happens at single points: where it meets an edge, where it meets a
//! plane, and where two planes are level with each other. Between two such points nothing changes, so one point of each stretch
//! tells of all of it.

use std::cmp::Ordering;

use super::P3;

/// A prism over a triangle with a height at each corner, in either winding.
pub(crate) type Sloped = [P3; 3];

/// A fraction with a positive denominator.
#[derive(Clone, Copy, Debug)]
struct Fraction(i128, i128);

impl Fraction {
    fn new(n: i128, d: i128) -> Self {
        if d < 0 { Fraction(-n, -d) } else { Fraction(n, d) }
    }

    fn order(self, other: Fraction) -> Ordering {
        let times = |a: i128, b: i128| a.checked_mul(b).expect("small numbers");
        times(self.0, other.1).cmp(&times(other.0, self.1))
    }
}

fn cross(a: [i128; 2], b: [i128; 2]) -> i128 {
    a[0] * b[1] - a[1] * b[0]
}

fn sub(a: [i128; 2], b: [i128; 2]) -> [i128; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

fn plan(p: P3) -> [i128; 2] {
    [i128::from(p[0]), i128::from(p[1])]
}

/// Counterclockwise; `None` without an area.
fn turned_left(triangle: Sloped) -> Option<Sloped> {
    let [a, b, c] = triangle;
    match cross(sub(plan(b), plan(a)), sub(plan(c), plan(a))).cmp(&0) {
        Ordering::Greater => Some([a, b, c]),
        Ordering::Less => Some([a, c, b]),
        Ordering::Equal => None,
    }
}

/// How far a point is above the plane of a triangle, times twice its area.
fn above(triangle: &Sloped, p: P3) -> i128 {
    let [a, b, c] = triangle.map(|v| [0, 1, 2].map(|k| i128::from(v[k]) - i128::from(triangle[0][k])));
    let p = [0, 1, 2].map(|k| i128::from(p[k]) - i128::from(triangle[0][k]));
    debug_assert_eq!(a, [0, 0, 0]);
    // The determinant of b, c and p.
    b[0] * (c[1] * p[2] - c[2] * p[1]) - b[1] * (c[0] * p[2] - c[2] * p[0]) + b[2] * (c[0] * p[1] - c[1] * p[0])
}

/// Whether the link is LoS among the prisms.
pub(crate) fn sloped_los(prisms: &[Sloped], uav: P3, receiver: P3) -> bool {
    if uav == receiver {
        return true;
    }
    let prisms: Vec<Sloped> = prisms.iter().copied().filter_map(turned_left).collect();
    let (u, way) = (plan(uav), sub(plan(receiver), plan(uav)));
    if way == [0, 0] {
        let lower = [uav[0], uav[1], uav[2].min(receiver[2])];
        return !is_solid_all_around(&prisms, lower);
    }
    let mut breaks = vec![Fraction(0, 1), Fraction(1, 1)];
    let mut add = |n: i128, d: i128| {
        if d != 0 {
            let t = Fraction::new(n, d);
            if t.0 > 0 && t.0 < t.1 {
                breaks.push(t);
            }
        }
    };
    for prism in &prisms {
        for k in 0..3 {
            let (a, b) = (plan(prism[k]), plan(prism[(k + 1) % 3]));
            // The line of the edge, and its ends for rays along it.
            add(cross(sub(a, u), sub(b, a)), cross(way, sub(b, a)));
            let from_u = sub(a, u);
            if cross(way, from_u) == 0 {
                add(from_u[0] * way[0] + from_u[1] * way[1], way[0] * way[0] + way[1] * way[1]);
            }
        }
    }
    // The ray is c + t (d − c) above a plane, times its area.
    let lines: Vec<(i128, i128, i128)> = prisms
        .iter()
        .map(|p| {
            let area = cross(sub(plan(p[1]), plan(p[0])), sub(plan(p[2]), plan(p[0])));
            let (c, d) = (above(p, uav), above(p, receiver));
            (c, d - c, area)
        })
        .collect();
    for (k, (c, by, area)) in lines.iter().enumerate() {
        add(-c, *by);
        for (other_c, other_by, other_area) in &lines[..k] {
            add(other_c * area - c * other_area, by * other_area - other_by * area);
        }
    }
    breaks.sort_unstable_by(|a, b| a.order(*b));
    breaks.dedup_by(|a, b| a.order(*b) == Ordering::Equal);
    breaks.windows(2).all(|ends| {
        let t = Fraction(ends[0].0 + ends[1].0, ends[0].1 + ends[1].1);
        // The place times the denominator of t.
        let p = [0, 1].map(|k| u[k] * t.1 + way[k] * t.0);
        let blocks = |is_left: bool| {
            prisms.iter().zip(&lines).any(|(prism, (c, by, _))| {
                let covers = (0..3).all(|k| {
                    let (a, b) = (plan(prism[k]), plan(prism[(k + 1) % 3]));
                    let edge = sub(b, a);
                    match cross(edge, sub(p, a.map(|v| v * t.1))).cmp(&0) {
                        Ordering::Greater => true,
                        Ordering::Less => false,
                        // Along the edge, whose prism lies left of it.
                        Ordering::Equal => (edge[0] * way[0] + edge[1] * way[1] > 0) == is_left,
                    }
                });
                covers && c * t.1 + by * t.0 < 0
            })
        };
        !(blocks(true) && blocks(false))
    })
}

/// Whether prisms are solid above a point on all sides of it.
fn is_solid_all_around(prisms: &[Sloped], p: P3) -> bool {
    let here = plan(p);
    let solid: Vec<&Sloped> = prisms.iter().filter(|prism| above(prism, p) < 0).collect();
    let edges = |prism: &Sloped| [0, 1, 2].map(|k| (plan(prism[k]), plan(prism[(k + 1) % 3])));
    let mut ways: Vec<[i128; 2]> = Vec::new();
    for (a, b) in solid.iter().flat_map(|prism| edges(prism)) {
        if cross(sub(b, a), sub(here, a)) == 0 {
            ways.extend([sub(a, here), sub(b, here)].into_iter().filter(|way| *way != [0, 0]));
        }
    }
    ways.extend([[1, 0], [0, 1], [-1, 0], [0, -1]]);
    let half = |v: &[i128; 2]| (v[1], v[0]) < (0, 0);
    ways.sort_unstable_by(|a, b| half(a).cmp(&half(b)).then(cross(*b, *a).cmp(&0)));
    ways.dedup_by(|a, b| cross(*a, *b) == 0 && half(a) == half(b));
    // Between neighbors, which are a quarter turn apart at most.
    (0..ways.len()).all(|k| {
        let (a, b) = (ways[k], ways[(k + 1) % ways.len()]);
        let way = [a[0] + b[0], a[1] + b[1]];
        solid.iter().any(|prism| {
            edges(prism).iter().all(|(a, b)| {
                let edge = sub(*b, *a);
                match cross(edge, sub(here, *a)).cmp(&0) {
                    Ordering::Equal => cross(edge, way) > 0,
                    order => order == Ordering::Greater,
                }
            })
        })
    })
}
