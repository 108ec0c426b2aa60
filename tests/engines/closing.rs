//! The data area of footprints: at single points against all discs that could show them outside, in whole numbers; and it depends on no cell.

use skyshed_core::city::{DataArea, Footprint, FootprintFaults, Ground, Solids};
use skyshed_core::height_field::HeightField;
use skyshed_core::quantity::Frame;
use skyshed_core::raster::GeoRef;

use crate::support::{Random, is_long};

/// Lattice steps of a meter, and the radius of the discs in them.
const M: i64 = 1024;
const R: i64 = 100 * M;

type Ring = Vec<[i64; 2]>;

/// A footprint of one ring.
fn footprint(ring: &Ring) -> Footprint {
    let ring = ring.iter().map(|p| p.map(|v| i32::try_from(v).unwrap())).collect();
    Footprint::on_zero(String::new(), vec![vec![ring]], 10 * 1024)
}

/// Whether each center of a grid of cells is in the data area; rows from the north.
fn known(rings: &[Ring], corner: [i64; 2], side_m: f64, n: usize) -> Vec<bool> {
    let at = corner.map(|v| v as f64 / M as f64);
    let grid = GeoRef::new((at[0], at[1] + side_m * n as f64), (side_m, side_m), (n, n), None).unwrap();
    // Two walls far away, with so much ground between them that the data area is not taken for all there is.
    let wall = |x: i64| vec![[x, 3000 * M], [x + M, 3000 * M], [x + M, 3600 * M], [x, 3600 * M]];
    let solids = Solids::Vector {
        footprints: rings.iter().chain(&[wall(3000 * M), wall(3150 * M)]).map(footprint).collect(),
        frame: Frame { x_origin: 0.0, y_origin: 0.0, unit_x: 1.0, unit_y: 1.0 },
        ground: Ground::Flat(0),
        faults: FootprintFaults::default(),
        data_area: DataArea::NearFootprints,
    };
    let field = HeightField::build(&grid, solids).field;
    let cells = (0..n * n).map(|k| (k / n, k % n));
    cells.map(|(row, col)| field.outside_data().is_none_or(|cells| !cells.contains(row, col))).collect()
}

// The oracle: positions relative to a point, in 2^-40 steps.

const ONE: i128 = 1 << 40;
/// What counts as touching: a few of the last digits of a square root of something small.
const TIE: i128 = ONE >> 16;

type Fixed = [i128; 2];

fn root(square: i128) -> i128 {
    // Of a number in 2^-80, in 2^-40.
    i128::try_from(u128::try_from(square.max(0)).unwrap().isqrt()).unwrap()
}

fn dot(a: Fixed, b: Fixed) -> i128 {
    a[0] * b[0] + a[1] * b[1]
}

fn sub(a: Fixed, b: Fixed) -> Fixed {
    [a[0] - b[0], a[1] - b[1]]
}

/// a + u · t, of a direction of length 1.
fn ahead(a: Fixed, t: i128, u: Fixed) -> Fixed {
    [0, 1].map(|k| a[k] + (t * u[k]) / ONE)
}

fn unit(d: Fixed) -> Option<Fixed> {
    let length = root(dot(d, d));
    (length > 0).then(|| d.map(|v| v * ONE / length))
}

/// A corner, or an edge: its end, direction, length.
#[derive(Clone, Copy)]
enum Obstacle {
    Corner(Fixed),
    Edge(Fixed, Fixed, i128),
}

impl Obstacle {
    /// How far a place is; of an edge beside its ends nothing, since these are corners.
    fn apart(self, place: Fixed) -> Option<i128> {
        match self {
            Obstacle::Corner(corner) => {
                let d = sub(place, corner);
                Some(root(dot(d, d)))
            }
            Obstacle::Edge(from, along, length) => {
                let d = sub(place, from);
                let t = dot(d, along) / ONE;
                (0..=length).contains(&t).then(|| ((d[1] * along[0] - d[0] * along[1]) / ONE).abs())
            }
        }
    }

    /// Lines of centers that touch: circles around corners, a line beside an edge on either side.
    fn lines(self) -> Vec<Line> {
        match self {
            Obstacle::Corner(corner) => vec![Line::Circle(corner)],
            Obstacle::Edge(from, along, _) => {
                let normal = [-along[1], along[0]];
                [1, -1].map(|side| Line::Straight(ahead(from, i128::from(side * R) * ONE, normal), along)).to_vec()
            }
        }
    }
}

#[derive(Clone, Copy)]
enum Line {
    Circle(Fixed),
    Straight(Fixed, Fixed),
}

/// Roots of t² = a square in 2^-80; one of those that are nearly none.
fn roots(square: i128) -> Vec<i128> {
    let least = 4 * i128::from(R) * TIE * ONE;
    if square < -least {
        Vec::new()
    } else if square <= least {
        vec![0]
    } else {
        vec![-root(square), root(square)]
    }
}

fn meet(a: Line, b: Line) -> Vec<Fixed> {
    let r = i128::from(R) * ONE;
    match (a, b) {
        (Line::Circle(a), Line::Circle(b)) => {
            let d = sub(b, a);
            let Some(along) = unit(d) else { return Vec::new() };
            let half = root(dot(d, d)) / 2;
            let across = [-along[1], along[0]];
            roots(r * r - half * half).into_iter().map(|t| ahead(ahead(a, half, along), t, across)).collect()
        }
        (Line::Circle(center), Line::Straight(from, along)) | (Line::Straight(from, along), Line::Circle(center)) => {
            let d = sub(center, from);
            let (t, h) = (dot(d, along) / ONE, (d[1] * along[0] - d[0] * along[1]) / ONE);
            roots(r * r - h * h).into_iter().map(|root| ahead(from, t + root, along)).collect()
        }
        (Line::Straight(a, u), Line::Straight(b, v)) => {
            let slope = (u[0] * v[1] - u[1] * v[0]) / ONE;
            let d = sub(b, a);
            if slope == 0 { Vec::new() } else { vec![ahead(a, (d[0] * v[1] - d[1] * v[0]) / slope, u)] }
        }
    }
}

/// Whether a closed polygon holds a point, in whole numbers.
fn holds(ring: &Ring, [x, y]: [i64; 2]) -> bool {
    let mut is_inside = false;
    for (k, a) in ring.iter().enumerate() {
        let b = ring[(k + 1) % ring.len()];
        let side = (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]);
        let within = |v: i64, k: usize| (a[k].min(b[k])..=a[k].max(b[k])).contains(&v);
        if side == 0 && within(x, 0) && within(y, 1) {
            return true;
        }
        if (a[1] > y) != (b[1] > y) && (side > 0) == (b[1] > a[1]) {
            is_inside = !is_inside;
        }
    }
    is_inside
}

/// Whether no disc of the radius holds a point and avoids all footprints, by every disc that touches one or two things and whose center is as
/// near as such a center can be.
fn is_closed(rings: &[Ring], point: [i64; 2]) -> bool {
    if rings.iter().any(|ring| holds(ring, point)) {
        return true;
    }
    let of = |p: &[i64; 2]| [0, 1].map(|k| i128::from(p[k] - point[k]) * ONE);
    let mut obstacles = Vec::new();
    for ring in rings {
        for (k, a) in ring.iter().enumerate() {
            let (a, b) = (of(a), of(&ring[(k + 1) % ring.len()]));
            obstacles.push(Obstacle::Corner(a));
            let d = sub(b, a);
            obstacles.push(Obstacle::Edge(a, unit(d).unwrap(), root(dot(d, d))));
        }
    }
    let r = i128::from(R) * ONE;
    let shows = |center: Fixed| {
        let far = center[0].abs().max(center[1].abs());
        far < r
            && root(dot(center, center)) < r - TIE
            && obstacles.iter().all(|obstacle| obstacle.apart(center).is_none_or(|apart| apart >= r - TIE))
    };
    let lines: Vec<Line> = obstacles.iter().flat_map(|obstacle| obstacle.lines()).collect();
    let alone = lines.iter().filter_map(|line| match *line {
        Line::Circle(center) => Some(ahead(center, r, unit(sub([0, 0], center))?)),
        Line::Straight(from, along) => Some(ahead(from, dot(sub([0, 0], from), along) / ONE, along)),
    });
    let mut centers: Vec<Fixed> = std::iter::once([0, 0]).chain(alone).collect();
    for (k, a) in lines.iter().enumerate() {
        centers.extend(lines[k + 1..].iter().flat_map(|b| meet(*a, *b)));
    }
    !centers.into_iter().any(shows)
}

/// Two or three small footprints, or two of any size, so few that they cannot enclose ground; often with walls in line or just 200 m apart.
fn scene(random: &mut Random) -> Vec<Ring> {
    let longest = random.choose(&[70, 70, 400]) * M;
    let n = if longest > 70 * M { 2 } else { random.within(2, 3) };
    let grid = random.choose(&[1, 256, 1024, 10 * 1024]);
    let mut at = [0, 0];
    (0..n)
        .map(|_| {
            let [w, h] = [0, 1].map(|_| random.within(1, longest / grid) * grid);
            let [x, y] = at;
            let far = random.choose(&[30 * M, 120 * M, 199 * M, 200 * M, 201 * M]);
            at = match random.below(4) {
                0 => [x + w + far, y],
                1 => [x, y + h + far],
                2 => [x + w + far / 2 / grid * grid, y + h + far / 3 / grid * grid],
                _ => [x + random.within(-90, 90) * M, y + random.within(-90, 90) * M],
            };
            match random.below(3) {
                0 => vec![[x, y], [x + w, y], [x, y + h]],
                1 => vec![[x, y], [x + w, y + h / 3], [x + w / 2, y + h], [x - w / 4, y + h / 2]],
                _ => vec![[x, y], [x + w, y], [x + w, y + h], [x, y + h]],
            }
        })
        .filter(|ring: &Ring| ring.windows(2).all(|pair| pair[0] != pair[1]) && ring[0] != ring[ring.len() - 1])
        .collect()
}

#[test]
fn the_data_area_is_that_of_all_discs() {
    let (mut n_held, mut n_near, mut n) = (0, 0, 0);
    for seed in 0..if is_long() { 1000 } else { 60 } {
        let mut random = Random(seed);
        let rings = scene(&mut random);
        let points = || rings.iter().flatten();
        let bounds = [0, 1].map(|k| [points().map(|p| p[k]).min().unwrap(), points().map(|p| p[k]).max().unwrap()]);
        // Cells of half a meter around a place between the footprints, shifted by odd steps.
        let side = 40;
        let center = [0, 1].map(|k| random.within(bounds[k][0] - 5 * M, bounds[k][1] + 5 * M));
        let corner = center.map(|v| v - side * M / 4);
        let found = known(&rings, corner, 0.5, usize::try_from(side).unwrap());
        let at = |k: usize| {
            let k = i64::try_from(k).unwrap();
            let (row, col) = (k / side, k % side);
            [corner[0] + col * M / 2 + M / 4, corner[1] + (side - 1 - row) * M / 2 + M / 4]
        };
        // All that have a neighbor on the other side, and some others.
        let is_near =
            |k: usize| [k.wrapping_sub(1), k + 1].iter().any(|other| found.get(*other).is_some_and(|f| *f != found[k]));
        for k in (0..found.len()).filter(|k| k % 97 == 0 || is_near(*k)) {
            assert_eq!(found[k], is_closed(&rings, at(k)), "seed {seed}: {:?} of {rings:?}", at(k));
            (n, n_held, n_near) = (n + 1, n_held + u32::from(found[k]), n_near + u32::from(is_near(k)));
        }
    }
    assert!(n > 900 && n_held > 200 && n - n_held > 200 && n_near > 200, "{n_held} of {n}, {n_near} at the border");
}

#[test]
fn the_data_area_does_not_depend_on_the_cells_of_receivers() {
    for seed in 0..if is_long() { 300 } else { 20 } {
        let mut random = Random(seed);
        let rings = scene(&mut random);
        // Centers of the coarse cells are those of every third, ninth … of the finer ones.
        let [coarse, fine] = [(4.5, 81, 1), (0.5, 729, 9)].map(|(side, n, every)| {
            let known = known(&rings, [-60 * M, -60 * M], side, n);
            let middle = |k: usize| (k / n % every == every / 2) && (k % n % every == every / 2);
            (0..known.len()).filter(|k| middle(*k)).map(|k| known[k]).collect::<Vec<_>>()
        });
        assert!(coarse == fine && coarse.contains(&true), "seed {seed}");
    }
}

/// Two rings of walls with a gap: the discs inside and outside of the gap overlap if it is wide and the walls thin.
#[test]
fn a_park_behind_a_gap_is_filled_where_discs_on_both_sides_do_not_meet() {
    let park = |gap: i64, thick: i64| {
        let (size, t) = (500 * M, thick);
        let wall = |x: i64, y: i64, w: i64, h: i64| vec![[x, y], [x + w, y], [x + w, y + h], [x, y + h]];
        let half = (size - gap) / 2;
        let rings = [
            wall(0, 0, t, size),
            wall(size - t, 0, t, size),
            wall(0, size - t, size, t),
            wall(0, 0, half, t),
            wall(half + gap, 0, half, t),
        ];
        // One cell in the middle.
        known(&rings, [size / 2 - M, size / 2 - M], 2.0, 1)[0]
    };
    // A disc at the gap reaches R − √(R² − gap² / 4) into it from either side, and together they reach through walls of twice that.
    for gap in [120 * M, 160 * M, 190 * M] {
        let (r, g) = (R as f64, gap as f64);
        let through = 2.0 * (r - (r * r - g * g / 4.0).sqrt());
        #[expect(clippy::cast_possible_truncation, reason = "some meters")]
        let (thin, thick) = (through.floor() as i64 - 1, through.ceil() as i64 + 1);
        assert_eq!([park(gap, thin), park(gap, thick)], [false, true], "{gap}: {through}");
    }
}
