//! The referee of legs, in rational numbers: slow, plain, and without code of the engine.
//!
//! The state of the link to p(s) can change only where something that is linear in s is 0. These
//! *candidates* are collected, far more than needed. Between two neighbors the state is constant, so
//! it is decided at their middle, by a link test that follows the definition word for word:
//!
//! * The solid is the union of convex prisms; a column is one, and is left out if its closed square
//!   holds the receiver.
//! * Along the open link, its crossings with walls and roof planes are collected. Between two
//!   neighbors it is blocked if and only if its middle is below a roof on the left and one on the
//!   right.

use num_rational::Ratio;

/// A rational number; small scenes do not overflow it, and tests would panic if they did.
pub(super) type Q = Ratio<i128>;
pub(super) type P3 = [i128; 3];
type Q3 = [Q; 3];

/// A convex prism with corners counterclockwise and a roof through `corner` that rises by `rise`.
#[derive(Debug, Clone)]
pub(super) struct Solid {
    pub(super) ring: Vec<[i128; 2]>,
    pub(super) roof: Form,
    /// `true` for a column, which is exempt for receivers over it.
    pub(super) is_column: bool,
}

/// A linear form `n·p + c` of points.
#[derive(Debug, Clone, Copy)]
pub(super) struct Form {
    pub(super) n: P3,
    pub(super) c: i128,
}

fn q(v: i128) -> Q {
    Q::from_integer(v)
}

impl Form {
    fn at(&self, p: &Q3) -> Q {
        p[0] * self.n[0] + p[1] * self.n[1] + p[2] * self.n[2] + q(self.c)
    }

    /// A form that is 0 on the plane through `o` and the line on which both forms are 0.
    fn through(&self, other: &Form, o: P3) -> Form {
        let (a, b) = (self.at(&o.map(q)).to_integer(), other.at(&o.map(q)).to_integer());
        Form { n: [0, 1, 2].map(|k| a * other.n[k] - b * self.n[k]), c: a * other.c - b * self.c }
    }

    /// Above 0 left of the edge.
    fn edge(from: [i128; 2], to: [i128; 2]) -> Form {
        let n = [from[1] - to[1], to[0] - from[0], 0];
        Form { n, c: -n[0] * from[0] - n[1] * from[1] }
    }

    /// Above 0 below a flat roof.
    pub(super) fn flat(top: i128) -> Form {
        Form { n: [0, 0, -1], c: top }
    }

    /// Above 0 below the roof through three corners.
    pub(super) fn roof([a, b, c]: [P3; 3]) -> Form {
        let (e, f) = ([0, 1, 2].map(|k| b[k] - a[k]), [0, 1, 2].map(|k| c[k] - a[k]));
        let n = [e[2] * f[1] - e[1] * f[2], e[0] * f[2] - e[2] * f[0], e[1] * f[0] - e[0] * f[1]];
        Form { n, c: -(n[0] * a[0] + n[1] * a[1] + n[2] * a[2]) }
    }
}

impl Solid {
    fn edges(&self) -> impl Iterator<Item = Form> + '_ {
        (0..self.ring.len()).map(|k| Form::edge(self.ring[k], self.ring[(k + 1) % self.ring.len()]))
    }

    /// Returns `true` if it covers the plane just beside a point in a direction that runs along no edge there.
    fn covers(&self, p: &Q3, toward: [i128; 2]) -> bool {
        self.edges().all(|edge| {
            let side = edge.at(p);
            side > q(0) || (side == q(0) && edge.n[0] * toward[0] + edge.n[1] * toward[1] > 0)
        })
    }

    fn holds(&self, p: &Q3) -> bool {
        self.edges().all(|edge| edge.at(p) >= q(0))
    }

    fn is_above(&self, p: &Q3) -> bool {
        self.roof.at(p) > q(0)
    }
}

fn along(o: &Q3, p: &Q3, t: Q) -> Q3 {
    [0, 1, 2].map(|k| o[k] + (p[k] - o[k]) * t)
}

/// Sorted numbers from 0 to 1 among some, both included.
fn sorted(mut numbers: Vec<Q>) -> Vec<Q> {
    numbers.extend([q(0), q(1)]);
    numbers.retain(|t| *t >= q(0) && *t <= q(1));
    numbers.sort_unstable();
    numbers.dedup();
    numbers
}

/// The s at which a form is 0 between two points.
fn zero(form: &Form, from: &Q3, to: &Q3) -> Option<Q> {
    let (a, b) = (form.at(from), form.at(to));
    (a != b).then(|| a / (a - b))
}

/// An integer vector in the direction of a rational one.
fn whole([x, y]: [Q; 2]) -> [i128; 2] {
    [x, y].map(|v| (v * *x.denom() * *y.denom()).to_integer())
}

/// Returns `true` if the solids around a point are above it in every direction.
fn is_interior(solids: &[Solid], p: &Q3) -> bool {
    let mut directions: Vec<[i128; 2]> = Vec::new();
    for solid in solids.iter().filter(|solid| solid.holds(p)) {
        for edge in solid.edges().filter(|edge| edge.at(p) == q(0)) {
            directions.extend([[edge.n[1], -edge.n[0]], [-edge.n[1], edge.n[0]]]);
        }
    }
    if directions.is_empty() {
        return solids.iter().any(|solid| solid.holds(p) && solid.is_above(p));
    }
    // Between any two neighboring directions: their sum, or a quarter turn.
    let mut between: Vec<[i128; 2]> = Vec::new();
    for d in &directions {
        between.extend([[d[1], -d[0]], [-d[1], d[0]]]);
        between.extend(directions.iter().map(|e| [d[0] + e[0], d[1] + e[1]]));
        // Long and short directions may have another one between their sum.
        between.extend(directions.iter().map(|e| [d[0] * 97 + e[0], d[1] * 97 + e[1]]));
    }
    between.retain(|b| *b != [0, 0] && directions.iter().all(|d| d[0] * b[1] != d[1] * b[0]));
    between.into_iter().all(|d| solids.iter().any(|solid| solid.covers(p, d) && solid.is_above(p)))
}

/// Returns `true` if the open link meets the interior of the union of solids.
fn is_blocked(solids: &[Solid], o: &Q3, p: &Q3) -> bool {
    if (o[0], o[1]) == (p[0], p[1]) {
        let is_column = solids.first().is_some_and(|solid| solid.is_column);
        let lower = [o[0], o[1], o[2].min(p[2])];
        return o != p && !is_column && is_interior(solids, &lower);
    }
    let near: Vec<Solid> = solids.iter().filter(|solid| !(solid.is_column && solid.holds(p))).cloned().collect();
    let forms = near.iter().flat_map(|solid| solid.edges().chain([solid.roof]));
    let stops = sorted(forms.filter_map(|form| zero(&form, o, p)).collect());
    let [dx, dy] = whole([p[0] - o[0], p[1] - o[1]]);
    stops.windows(2).any(|ends| {
        let middle = along(o, p, (ends[0] + ends[1]) / 2);
        let below =
            |toward: [i128; 2]| near.iter().any(|solid| solid.covers(&middle, toward) && solid.is_above(&middle));
        below([-dy, dx]) && below([dy, -dx])
    })
}

/// A leg from a to b, seen from o.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seen {
    pub(super) o: P3,
    pub(super) a: P3,
    pub(super) b: P3,
}

impl Seen {
    fn at(&self, s: Q) -> Q3 {
        along(&self.a.map(q), &self.b.map(q), s)
    }

    /// All s at which the state may change.
    pub(super) fn candidates(&self, solids: &[Solid]) -> Vec<Q> {
        let Seen { o, a, b } = *self;
        let (mut walls, roofs): (Vec<Form>, Vec<Form>) =
            (solids.iter().flat_map(Solid::edges).collect(), solids.iter().map(|solid| solid.roof).collect());
        for direction in [[a[0] - o[0], a[1] - o[1]], [b[0] - a[0], b[1] - a[1]]] {
            for v in solids.iter().flat_map(|solid| &solid.ring) {
                walls.push(Form { n: [direction[0], direction[1], 0], c: -direction[0] * v[0] - direction[1] * v[1] });
            }
            walls.push(Form { n: [direction[0], direction[1], 0], c: -direction[0] * o[0] - direction[1] * o[1] });
        }
        walls.sort_unstable_by_key(|form| (form.n, form.c));
        walls.dedup_by_key(|form| (form.n, form.c));
        let mut roofs = roofs;
        roofs.sort_unstable_by_key(|form| (form.n, form.c));
        roofs.dedup_by_key(|form| (form.n, form.c));
        let mut forms: Vec<Form> = vec![Form::flat(o[2])];
        for solid in solids {
            forms.extend(solid.ring.iter().map(|v| Form::edge([o[0], o[1]], *v)));
        }
        for roof in &roofs {
            forms.extend(walls.iter().chain(&roofs).map(|other| roof.through(other, o)));
        }
        forms.extend(walls.into_iter().chain(roofs));
        sorted(forms.iter().filter_map(|form| zero(form, &a.map(q), &b.map(q))).collect())
    }

    /// The hidden parts, given the solids of each kind.
    pub(super) fn hidden(&self, kinds: &[Vec<Solid>]) -> Vec<[Q; 2]> {
        self.parts(kinds, |solids, p| is_blocked(solids, &self.o.map(q), p))
    }

    /// The parts inside the solids of a kind.
    pub(super) fn inside(&self, solids: &[Solid]) -> Vec<[Q; 2]> {
        self.parts(&[solids.to_vec()], is_interior)
    }

    fn parts(&self, kinds: &[Vec<Solid>], is_in: impl Fn(&[Solid], &Q3) -> bool) -> Vec<[Q; 2]> {
        let candidates = sorted(kinds.iter().flat_map(|solids| self.candidates(solids)).collect());
        let mut parts: Vec<[Q; 2]> = Vec::new();
        for ends in candidates.windows(2) {
            let middle = self.at((ends[0] + ends[1]) / 2);
            if kinds.iter().any(|solids| is_in(solids, &middle)) {
                match parts.last_mut() {
                    Some(last) if last[1] == ends[0] => last[1] = ends[1],
                    _ => parts.push([ends[0], ends[1]]),
                }
            }
        }
        parts
    }
}
