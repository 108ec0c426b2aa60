//! Random scenes on small lattices, so that coincidences are frequent, for the engine and the
//! referee alike.

use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

use super::tests_oracle::{Form, P3, Seen, Solid};
use crate::height_field::{Columns, Prisms, Top};
use crate::quantity::VOID;

/// Random numbers of one seed.
pub(super) struct Dice(ChaCha8Rng);

impl Dice {
    pub(super) fn new(seed: u64) -> Dice {
        Dice(ChaCha8Rng::seed_from_u64(seed))
    }

    /// An integer from `low` to `high`, both included.
    pub(super) fn roll(&mut self, low: i64, high: i64) -> i64 {
        low + (self.0.next_u64() % (high - low + 1).unsigned_abs()).cast_signed()
    }

    fn is_once_in(&mut self, n: i64) -> bool {
        self.roll(1, n) == 1
    }
}

/// A small scene for the engine, and its solids for the referee.
#[derive(Debug)]
pub(super) struct Scene {
    pub(super) prisms: Option<Prisms>,
    pub(super) columns: Option<Columns>,
    /// Solids of each kind.
    pub(super) kinds: Vec<Vec<Solid>>,
    roofs: Vec<Roof>,
    cells: Option<Cells>,
}

/// Tops of cells, row by row from the north, and the size of a cell.
#[derive(Debug, Clone)]
struct Cells {
    shape: (usize, usize),
    tops: Vec<i32>,
    steps: [i64; 2],
}

/// Largest coordinate of a scene.
const SIZE: i64 = 12;

/// A convex ring with the heights of its corners; equal ones are flat.
type Roof = (Vec<[i64; 2]>, Vec<i64>);

fn boxes(dice: &mut Dice, roofs: &mut Vec<Roof>) {
    let at = |dice: &mut Dice| 3 * dice.roll(0, 3);
    let (x, y) = (at(dice), at(dice));
    let (w, h, top) = (3 * dice.roll(1, 2), 3 * dice.roll(1, 2), dice.roll(0, 6));
    let ring = [[x, y], [x + w, y], [x + w, y + h], [x, y + h]];
    if dice.is_once_in(2) {
        roofs.push((ring.to_vec(), vec![top; 4]));
        return;
    }
    // Two triangles, alike, or with roofs of their own, flat or sloped.
    let alike = dice.is_once_in(3);
    let sloped = dice.is_once_in(2);
    for corners in [[0, 1, 2], [0, 2, 3]] {
        let own = if alike { top } else { dice.roll(0, 6) };
        let heights = [0; 3].map(|_| if sloped { dice.roll(0, 6) } else { own });
        roofs.push((corners.map(|k| ring[k]).to_vec(), heights.to_vec()));
    }
}

fn triangle(dice: &mut Dice, roofs: &mut Vec<Roof>) {
    let p = [0; 3].map(|_| [dice.roll(0, SIZE), dice.roll(0, SIZE)]);
    let area = (p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[1][1] - p[0][1]) * (p[2][0] - p[0][0]);
    let ring = if area > 0 { p.to_vec() } else { vec![p[0], p[2], p[1]] };
    if area != 0 {
        let sloped = dice.is_once_in(2);
        let top = dice.roll(0, 6);
        roofs.push((ring, [0; 3].map(|_| if sloped { dice.roll(0, 6) } else { top }).to_vec()));
    }
}

fn small(v: i64) -> i32 {
    i32::try_from(v).unwrap()
}

fn with_prisms(roofs: &[Roof]) -> (Prisms, Vec<Solid>) {
    let tops = roofs.iter().map(|(ring, heights)| {
        let ring: Vec<[i32; 2]> = ring.iter().map(|corner| corner.map(small)).collect();
        let heights: Vec<i32> = heights.iter().copied().map(small).collect();
        let is_flat = heights.iter().all(|z| *z == heights[0]);
        (ring, if is_flat { Top::Flat(heights[0]) } else { Top::Sloped(heights) }, 0)
    });
    let solids = roofs.iter().map(|(ring, heights)| {
        let corner = |k: usize| [ring[k][0], ring[k][1], heights[k]].map(i128::from);
        let ring = ring.iter().map(|corner| corner.map(i128::from)).collect();
        Solid { ring, roof: Form::roof([corner(0), corner(1), corner(2)]), is_column: false }
    });
    (Prisms::with_tops(tops), solids.collect())
}

impl Cells {
    fn random(dice: &mut Dice) -> Cells {
        let steps = [dice.roll(2, 4), dice.roll(2, 4)];
        let shape = [dice.roll(1, 4), dice.roll(1, 4)].map(|n| usize::try_from(n).unwrap());
        let top = |dice: &mut Dice| if dice.is_once_in(5) { VOID } else { small(dice.roll(0, 5)) };
        let tops = (0..shape[0] * shape[1]).map(|_| top(dice)).collect();
        Cells { shape: (shape[0], shape[1]), tops, steps }
    }

    fn columns(&self) -> Columns {
        Columns::new(self.shape.0, self.shape.1, self.tops.clone()).with_cells_of(self.steps)
    }

    fn solids(&self) -> Vec<Solid> {
        let known = self.tops.iter().enumerate().filter(|(_, top)| **top != VOID);
        let solid = |(cell, top): (usize, &i32)| {
            let (row, col) = (self.shape.0 - 1 - cell / self.shape.1, cell % self.shape.1);
            let [w, h] = self.steps.map(i128::from);
            let (x, y) = (i128::try_from(col).unwrap() * w, i128::try_from(row).unwrap() * h);
            let ring = vec![[x, y], [x + w, y], [x + w, y + h], [x, y + h]];
            Solid { ring, roof: Form::flat(i128::from(*top)), is_column: true }
        };
        known.map(solid).collect()
    }
}

impl Scene {
    pub(super) fn random(dice: &mut Dice) -> Scene {
        let kind = dice.roll(0, 4);
        let mut roofs = Vec::new();
        for _ in 0..if kind == 0 { 0 } else { dice.roll(1, 5) } {
            if dice.is_once_in(4) { triangle(dice, &mut roofs) } else { boxes(dice, &mut roofs) }
        }
        Scene::of(roofs, (kind < 2).then(|| Cells::random(dice)))
    }

    fn of(roofs: Vec<Roof>, cells: Option<Cells>) -> Scene {
        let (prisms, solids) = with_prisms(&roofs);
        let mut kinds = vec![solids];
        kinds.extend(cells.as_ref().map(Cells::solids));
        let columns = cells.as_ref().map(Cells::columns);
        Scene { prisms: (!roofs.is_empty()).then_some(prisms), columns, kinds, roofs, cells }
    }

    pub(super) fn without_columns(self) -> Scene {
        Scene::of(self.roofs, None)
    }

    /// The scene with a single prism.
    pub(super) fn alone(&self, piece: usize) -> Scene {
        Scene::of(vec![self.roofs[piece].clone()], None)
    }

    /// The scene magnified in the plane, with every coordinate moved by `shift` of it, and in height.
    pub(super) fn magnified(&self, plane: i64, height: i64, shift: impl Fn(i64) -> i64) -> Scene {
        let roof = |(ring, heights): &Roof| {
            let ring = ring.iter().map(|corner| corner.map(|v| plane * v + shift(v))).collect();
            (ring, heights.iter().map(|z| height * z).collect())
        };
        let cells = self.cells.as_ref().map(|cells| Cells {
            tops: cells.tops.iter().map(|z| if *z == VOID { VOID } else { small(height) * z }).collect(),
            steps: cells.steps.map(|size| plane * size),
            ..cells.clone()
        });
        Scene::of(self.roofs.iter().map(roof).collect(), cells)
    }

    /// Returns `true` for a sloped roof.
    pub(super) fn is_sloped(&self) -> bool {
        self.roofs.iter().any(|(_, heights)| heights.iter().any(|z| *z != heights[0]))
    }

    /// A point, often on a wall, on a roof or at a corner.
    fn point(&self, dice: &mut Dice) -> P3 {
        let mut p = [dice.roll(-2, SIZE + 2), dice.roll(-2, SIZE + 2), dice.roll(-1, 8)].map(i128::from);
        if dice.is_once_in(2) {
            return p;
        }
        let Some([v, w]) = self.edge(dice) else { return p };
        match dice.roll(0, 4) {
            0 => (p[0], p[1]) = (v[0], v[1]),
            1 => p[0] = v[0],
            2 => p[1] = v[1],
            // On the line of a wall.
            _ => {
                let k = i128::from(dice.roll(-1, 2));
                (p[0], p[1]) = (v[0] + k * (w[0] - v[0]), v[1] + k * (w[1] - v[1]));
            }
        }
        p
    }

    /// An edge of a solid.
    fn edge(&self, dice: &mut Dice) -> Option<[[i128; 2]; 2]> {
        let solids: Vec<&Solid> = self.kinds.iter().flatten().collect();
        let mut pick = |n: usize| usize::try_from(dice.roll(1, i64::try_from(n).unwrap())).unwrap() - 1;
        let ring = &solids.get(if solids.is_empty() { 0 } else { pick(solids.len()) })?.ring;
        let corner = pick(ring.len());
        Some([ring[corner], ring[(corner + 1) % ring.len()]])
    }

    /// A leg seen from somewhere, often degenerate.
    pub(super) fn leg(&self, dice: &mut Dice) -> Seen {
        let (mut o, mut a, mut b) = (self.point(dice), self.point(dice), self.point(dice));
        match dice.roll(0, 11) {
            // In the plane of a wall.
            10 | 11 => {
                if let Some([v, w]) = self.edge(dice) {
                    for p in [&mut o, &mut a, &mut b] {
                        let k = i128::from(dice.roll(-1, 2));
                        (p[0], p[1]) = (v[0] + k * (w[0] - v[0]), v[1] + k * (w[1] - v[1]));
                    }
                }
            }
            // Vertical, without length, level.
            0 => (b[0], b[1]) = (a[0], a[1]),
            1 => b = a,
            2 => b[2] = a[2],
            // On a line through the observer.
            3 => b = line(o, a, dice.roll(-2, 3)),
            // In a vertical plane with the observer.
            4 => {
                (b[0], b[1]) = {
                    let p = line(o, a, dice.roll(-2, 3));
                    (p[0], p[1])
                }
            }
            // Straight above the observer.
            5 if dice.is_once_in(3) => return Seen { o, a: [o[0], o[1], a[2]], b: [o[0], o[1], b[2]] },
            5 if dice.is_once_in(2) => return Seen { o, a: o, b },
            _ => {}
        }
        Seen { o, a, b }
    }
}

fn line(o: P3, a: P3, k: i64) -> P3 {
    [0, 1, 2].map(|i| o[i] + i128::from(k) * (a[i] - o[i]))
}
