//! Which triangles of open ground are crossings, which are courtyards, and which are streets.
//!
//! The triangles and the gates between them are a graph. Short branches are cut off it; triangles where three gates
//! remain are junctions, and between junctions run chains of triangles with two. See [`super`] for the definition.

use std::collections::{BTreeMap, VecDeque};

use super::mesh::{Mesh, Side};
use super::zone::Zone;

/// A gate narrower than this \[m\] is no way through.
const NARROWEST_PASSAGE_M: f64 = 1.0;

/// A part of the open ground smaller than this \[m²\] that opens to another is a slit between walls, no yard.
const SMALLEST_YARD_M2: f64 = 25.0;

/// A branch shorter than this share of the width of its gate is cut off.
const SHORTEST_BRANCH_WIDTHS: f64 = 1.0;

/// Share of another gate's width below which a gate counts as narrower. Without it the mouths of streets whose walls are
/// parallel would depend on rounding.
const NARROWER_SHARE: f64 = 0.97;

/// Where gates no longer narrow, a narrower one is looked for this far on \[widths of the narrowest found\]. The streets
/// of a generated city are 0.46 times as long as wide, or longer, for α ≥ 0.1.
const MOUTH_SEARCH_WIDTHS: f64 = 0.35;

/// Crossings whose mouths are closer than this share of their width are one.
const SHORTEST_STREET_WIDTHS: f64 = 0.25;

/// A mouth counts as a street only if it is this share of the second widest at the crossing.
const NARROWEST_STREET_SHARE: f64 = 0.3;

/// A mouth wider than this many typical streets opens to a park, a river or the outskirts.
const WIDEST_STREET_TYPICAL: f64 = 4.0;

/// A crossing larger than this many squares of its widest street is open ground.
const LARGEST_CROSSING_WIDTHS2: f64 = 30.0;

/// The part of a crossing at the frame is open ground above this many squares: what lies beyond the frame is not known.
const LARGEST_CROSSING_AT_FRAME_WIDTHS2: f64 = 2.0;

pub(super) fn zones_of(mesh: &Mesh) -> Vec<Zone> {
    let n = mesh.triangles.len();
    let mut gates = Gates::of(mesh);
    let courtyards = courtyards(&gates);
    let pruned = gates.prune();
    let is_crossing = crossings(&gates, n);
    let mut zones: Vec<Zone> = (0..n)
        .map(|t| match (courtyards[t], is_crossing[t]) {
            (true, _) => Zone::Courtyard,
            (_, true) => Zone::Crossroad,
            _ => Zone::Street,
        })
        .collect();
    // What was cut off belongs to what it hangs on; the last to be cut off is nearest to that.
    let mut queue: Vec<(usize, usize)> = pruned;
    queue.reverse();
    while let Some((root, trunk)) = queue.pop() {
        if zones[root] != Zone::Courtyard {
            zones[root] = zones[trunk];
        }
        for side in 0..3 {
            if let Some((next, _)) = gates.beyond(root, side)
                && next != trunk
                && gates.is_live[root][side]
            {
                queue.push((next, root));
            }
        }
    }
    zones
}

/// Ways through between triangles.
struct Gates<'a> {
    mesh: &'a Mesh,
    /// Whether a side is a way through that is not cut off.
    is_live: Vec<[bool; 3]>,
}

impl<'a> Gates<'a> {
    fn of(mesh: &'a Mesh) -> Self {
        let is_gate = |t: usize, side: usize| {
            matches!(mesh.triangles[t].sides[side], Side::Open(_)) && mesh.length(t, side) >= NARROWEST_PASSAGE_M
        };
        let is_live = (0..mesh.triangles.len()).map(|t| [0, 1, 2].map(|side| is_gate(t, side))).collect();
        Gates { mesh, is_live }
    }

    /// The triangle beyond a side, and the number that the side has there.
    fn beyond(&self, triangle: usize, side: usize) -> Option<(usize, usize)> {
        let Side::Open(next) = self.mesh.triangles[triangle].sides[side] else { return None };
        let back = self.mesh.triangles[next].sides.iter().position(|s| *s == Side::Open(triangle))?;
        Some((next, back))
    }

    fn degree(&self, triangle: usize) -> usize {
        self.is_live[triangle].iter().filter(|live| **live).count()
    }

    fn distance(&self, (t, side): (usize, usize), (u, other): (usize, usize)) -> f64 {
        let (a, b) = (self.mesh.middle(t, side), self.mesh.middle(u, other));
        (a[0] - b[0]).hypot(a[1] - b[1])
    }

    /// Cuts off branches that are shorter than their width; returns their first triangles and what those hung on, in the
    /// order of cutting.
    ///
    /// A branch is a part of the graph that one gate separates and that has no cycle. A branch that ends at the frame is
    /// not cut off: the street is taken to go on beyond it.
    fn prune(&mut self) -> Vec<(usize, usize)> {
        let n = self.mesh.triangles.len();
        let mut pruned = Vec::new();
        let mut open = self.is_live.clone();
        let mut n_open: Vec<usize> = (0..n).map(|t| self.degree(t)).collect();
        // How far a branch reaches from the gate in question.
        let mut reach = vec![0.0_f64; n];
        let mut queue: VecDeque<usize> = (0..n).filter(|t| n_open[*t] == 1).collect();
        while let Some(t) = queue.pop_front() {
            let Some(gate) = (0..3).find(|side| open[t][*side]) else { continue };
            let Some((trunk, back)) = self.beyond(t, gate) else { continue };
            let corner = self.mesh.points[self.mesh.triangles[t].corners[(gate + 2) % 3]];
            let middle = self.mesh.middle(t, gate);
            let mut far = (corner[0] - middle[0]).hypot(corner[1] - middle[1]);
            if self.degree(t) == 1 && self.mesh.triangles[t].sides.contains(&Side::Frame) {
                far = f64::INFINITY;
            }
            for side in (0..3).filter(|side| *side != gate && self.is_live[t][*side]) {
                if let Some((child, _)) = self.beyond(t, side) {
                    far = far.max(reach[child] + self.distance((t, side), (t, gate)));
                }
            }
            reach[t] = far;
            (open[t][gate], open[trunk][back]) = (false, false);
            n_open[t] -= 1;
            n_open[trunk] -= 1;
            if self.degree(trunk) == 3 && far < SHORTEST_BRANCH_WIDTHS * self.mesh.length(t, gate) {
                (self.is_live[t][gate], self.is_live[trunk][back]) = (false, false);
                pruned.push((t, trunk));
            }
            if n_open[trunk] == 1 {
                queue.push_back(trunk);
            }
        }
        pruned
    }

    /// The chain of triangles that leaves a junction through a side.
    fn chain(&self, junction: usize, side: usize) -> Chain {
        let mut chain = Chain { gates: vec![(junction, side)], triangles: Vec::new(), end: None };
        let (mut t, mut out) = (junction, side);
        while let Some((next, back)) = self.beyond(t, out) {
            if self.degree(next) == 3 {
                chain.end = Some((next, back));
                return chain;
            }
            chain.triangles.push(next);
            let Some(onward) = (0..3).find(|s| *s != back && self.is_live[next][*s]) else { return chain };
            (t, out) = (next, onward);
            if chain.triangles.len() > self.mesh.triangles.len() {
                return chain;
            }
            chain.gates.push((t, out));
        }
        chain
    }

    /// The gate where a chain's street begins: down to where gates no longer narrow, and on to a narrower one nearby.
    fn mouth(&self, gates: impl Iterator<Item = (usize, usize)>) -> usize {
        let (mut best, mut width, mut walked) = (0, f64::INFINITY, 0.0);
        let mut last = None;
        let mut is_narrowing = true;
        for (k, gate) in gates.enumerate() {
            let length = self.mesh.length(gate.0, gate.1);
            let is_narrower = length < NARROWER_SHARE * width;
            is_narrowing &= is_narrower;
            walked += last.map_or(0.0, |l| self.distance(l, gate));
            last = Some(gate);
            if !is_narrowing && walked > MOUTH_SEARCH_WIDTHS * width {
                break;
            }
            if is_narrower {
                (best, width, walked) = (k, length, 0.0);
            }
        }
        best
    }
}

/// A street between two junctions, or from a junction to a dead end.
struct Chain {
    /// Gates along it as (triangle, side), each seen from the triangle before it; one more than triangles, unless it ends
    /// dead.
    gates: Vec<(usize, usize)>,
    triangles: Vec<usize>,
    /// The junction at its end and the side by which it arrives there.
    end: Option<(usize, usize)>,
}

/// Which triangles are enclosed: no way leads from them to the frame. A slit, enclosed only in part by walls and too
/// small to stand in, is what it opens to.
fn courtyards(gates: &Gates) -> Vec<bool> {
    let mesh = gates.mesh;
    let n = mesh.triangles.len();
    // Parts of the open ground that gates connect.
    let mut part = vec![usize::MAX; n];
    let mut parts: Vec<Part> = Vec::new();
    for start in 0..n {
        if part[start] != usize::MAX {
            continue;
        }
        let number = parts.len();
        let mut found = Part { area: 0.0, meets_frame: false, slits: Vec::new() };
        let mut queue = vec![start];
        part[start] = number;
        while let Some(t) = queue.pop() {
            found.area += mesh.area(t);
            for side in 0..3 {
                found.meets_frame |= mesh.triangles[t].sides[side] == Side::Frame;
                match gates.beyond(t, side) {
                    Some((next, _)) if !gates.is_live[t][side] => found.slits.push(next),
                    Some((next, _)) if part[next] == usize::MAX => {
                        part[next] = number;
                        queue.push(next);
                    }
                    _ => {}
                }
            }
        }
        parts.push(found);
    }
    let is_slit = |p: &Part| !p.meets_frame && !p.slits.is_empty() && p.area < SMALLEST_YARD_M2;
    let mut is_enclosed: Vec<Option<bool>> = parts.iter().map(|p| (!is_slit(p)).then_some(!p.meets_frame)).collect();
    // From the parts that are decided into the slits beside them, the widest parts first.
    let mut queue: Vec<usize> = (0..parts.len()).filter(|k| is_enclosed[*k].is_some()).collect();
    queue.sort_by(|a, b| parts[*b].area.total_cmp(&parts[*a].area));
    let mut queue: VecDeque<usize> = queue.into();
    while let Some(k) = queue.pop_front() {
        for beside in parts[k].slits.iter().map(|t| part[*t]) {
            if is_enclosed[beside].is_none() {
                is_enclosed[beside] = is_enclosed[k];
                queue.push_back(beside);
            }
        }
    }
    part.into_iter().map(|k| is_enclosed[k].unwrap_or(false)).collect()
}

/// A part of the open ground.
struct Part {
    area: f64,
    meets_frame: bool,
    /// Triangles beyond openings that are no way through.
    slits: Vec<usize>,
}

/// Which triangles are crossings: junctions joined where the street between them is shorter than a share of its width,
/// out to the mouths of the streets that meet, where three or more do.
fn crossings(gates: &Gates, n: usize) -> Vec<bool> {
    let mut groups = Groups::new(n);
    // Triangles between a junction and a mouth, and the mouths of each junction.
    let mut parts: Vec<(usize, usize)> = Vec::new();
    let mut mouths: Vec<(usize, (usize, usize))> = Vec::new();
    for junction in (0..n).filter(|t| gates.degree(*t) == 3) {
        for side in 0..3 {
            let chain = gates.chain(junction, side);
            // Each chain between junctions is found from both ends, and treated once.
            if chain.end.is_some_and(|end| end < (junction, side)) {
                continue;
            }
            let last = chain.gates.len() - 1;
            let near = gates.mouth(chain.gates.iter().copied());
            let width = |k: usize| gates.mesh.length(chain.gates[k].0, chain.gates[k].1);
            let Some((end, _)) = chain.end else {
                parts.extend(chain.triangles.iter().take(near).map(|t| (*t, junction)));
                mouths.push((junction, chain.gates[near]));
                continue;
            };
            let far = last - gates.mouth(chain.gates.iter().rev().copied());
            let between: f64 = (near..far).map(|k| gates.distance(chain.gates[k], chain.gates[k + 1])).sum();
            if near >= far || between < SHORTEST_STREET_WIDTHS * width(near).min(width(far)) {
                groups.join(junction, end);
                parts.extend(chain.triangles.iter().map(|t| (*t, junction)));
            } else {
                parts.extend(chain.triangles.iter().take(near).map(|t| (*t, junction)));
                parts.extend(chain.triangles.iter().skip(far).map(|t| (*t, end)));
                mouths.extend([(junction, chain.gates[near]), (end, chain.gates[far])]);
            }
        }
    }
    let mut members = parts;
    members.extend((0..n).filter(|t| gates.degree(*t) == 3).map(|t| (t, t)));
    let mut regions: BTreeMap<usize, Region> = BTreeMap::new();
    let mut regions_of: Vec<(usize, usize)> = Vec::with_capacity(members.len());
    for (t, junction) in members {
        let root = groups.root(junction);
        let region = regions.entry(root).or_default();
        let area = if gates.mesh.meets_frame(t) { &mut region.area_at_frame } else { &mut region.area };
        *area += gates.mesh.area(t);
        regions_of.push((t, root));
    }
    let mut widths = Vec::new();
    for (junction, (t, side)) in mouths {
        let width = gates.mesh.length(t, side);
        regions.entry(groups.root(junction)).or_default().mouths.push(width);
        if !gates.mesh.meets_frame(t) {
            widths.push(width);
        }
    }
    let widest_street = WIDEST_STREET_TYPICAL * upper_quartile(widths);
    let mut is_crossing = vec![false; n];
    for (t, root) in regions_of {
        let at_frame = gates.mesh.meets_frame(t);
        is_crossing[t] |= regions.get(&root).is_some_and(|region| region.is_crossing(widest_street, at_frame));
    }
    is_crossing
}

/// Where streets meet, or a part of open ground that is too wide for that.
#[derive(Debug, Default)]
struct Region {
    /// Of the triangles without a corner on the frame \[m²\].
    area: f64,
    /// Of the others \[m²\].
    area_at_frame: f64,
    /// Widths of its mouths \[m\].
    mouths: Vec<f64>,
}

impl Region {
    /// Whether the region, or the part of it at the frame, is a crossing.
    fn is_crossing(&self, widest_street: f64, at_frame: bool) -> bool {
        let mut streets: Vec<f64> = self.mouths.iter().copied().filter(|width| *width <= widest_street).collect();
        streets.sort_unstable_by(|a, b| b.total_cmp(a));
        let [widest, second, third, ..] = streets[..] else { return false };
        let square = widest * widest;
        let is_cut_large = self.area_at_frame > LARGEST_CROSSING_AT_FRAME_WIDTHS2 * square;
        let is_outskirts = is_cut_large && (at_frame || self.area_at_frame > self.area);
        third >= NARROWEST_STREET_SHARE * second && self.area <= LARGEST_CROSSING_WIDTHS2 * square && !is_outskirts
    }
}

/// The value that a quarter of the values exceed; 0 if there are none.
fn upper_quartile(mut values: Vec<f64>) -> f64 {
    let at = values.len() * 3 / 4;
    if at >= values.len() {
        return 0.0;
    }
    *values.select_nth_unstable_by(at, f64::total_cmp).1
}

/// Disjoint sets with path halving.
struct Groups(Vec<usize>);

impl Groups {
    fn new(n: usize) -> Self {
        Groups((0..n).collect())
    }

    fn root(&mut self, mut t: usize) -> usize {
        while self.0[t] != t {
            self.0[t] = self.0[self.0[t]];
            t = self.0[t];
        }
        t
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b)] = a.min(b);
    }
}
