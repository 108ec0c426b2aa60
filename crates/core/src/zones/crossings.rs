//! Zones of the cells of open ground: crossings, courtyards and streets.
//!
//! The cells and the gates between them are a graph. Short branches are cut off it. Cells with
//! three remaining gates or more are junctions; chains of cells with two gates run between them.
//! See [`super`] for the definition.

use std::collections::BTreeMap;

use super::branches::cut_short;
use super::courtyards::courtyards;
use super::gates::Gates;
use super::mesh::Mesh;
use super::zone::Zone;
use crate::disjoint_sets::DisjointSets;

/// Crossings whose mouths are closer than this share of their width are one crossing.
const SHORTEST_STREET_WIDTHS: f64 = 0.25;

/// A mouth counts as a street only if it is this share of the second widest at the crossing.
const NARROWEST_STREET_SHARE: f64 = 0.3;

/// A mouth wider than this many typical streets opens to a park, a river or the outskirts.
const WIDEST_STREET_TYPICAL: f64 = 4.0;

/// A crossing larger than this many squares of its widest street is open ground.
const LARGEST_CROSSING_WIDTHS2: f64 = 30.0;

/// The part of a crossing at the frame is open ground above this many squares: the ground beyond
/// the frame is unknown.
const LARGEST_CROSSING_AT_FRAME_WIDTHS2: f64 = 2.0;

/// Returns the zone of each cell.
pub(super) fn zones_of(mesh: &Mesh) -> Vec<Zone> {
    let mut gates = Gates::of(mesh);
    let courtyards = courtyards(&gates);
    let cut = cut_short(&mut gates);
    let is_crossing = crossings(&gates);
    let mut zones: Vec<Zone> = (0..mesh.n_cells())
        .map(|cell| match (courtyards[cell], is_crossing[cell]) {
            (true, _) => Zone::Courtyard,
            (_, true) => Zone::Crossroad,
            _ => Zone::Street,
        })
        .collect();
    spread_into_branches(&mut zones, &gates, &cut);
    zones
}

/// Gives branches that were cut off the zone of their junction. Courtyards stay courtyards.
fn spread_into_branches(zones: &mut [Zone], gates: &Gates, cut: &[usize]) {
    let mesh = gates.mesh;
    // From a gate into the branch beyond it, and on through all its gates, including those of its
    // own branches.
    let onward = |side: usize| {
        let back = gates.beyond(side);
        let sides = back.map_or(0..0, |back| mesh.sides(mesh.cell(back)));
        sides.filter(move |next| Some(*next) != back && gates.beyond(*next).is_some())
    };
    let mut is_cut_off = vec![false; mesh.n_cells()];
    let mut is_met = vec![false; mesh.n_sides()];
    let mut open = cut.to_vec();
    while let Some(side) = open.pop() {
        if !std::mem::replace(&mut is_met[side], true)
            && let Some(back) = gates.beyond(side)
        {
            is_cut_off[mesh.cell(back)] = true;
            open.extend(onward(side));
        }
    }
    let trunks = cut.iter().filter(|side| !is_cut_off[mesh.cell(**side)]);
    let mut open: Vec<(usize, Zone)> = trunks.map(|side| (*side, zones[mesh.cell(*side)])).collect();
    while let Some((side, zone)) = open.pop() {
        if let Some(back) = gates.beyond(side) {
            let of_cell = &mut zones[mesh.cell(back)];
            if *of_cell != Zone::Courtyard {
                *of_cell = zone;
            }
            open.extend(onward(side).map(|next| (next, zone)));
        }
    }
}

/// Returns for each cell whether it is part of a crossing.
///
/// Junctions are joined if the street between them is shorter than a share of its width. A crossing
/// extends to the mouths of its streets, of which there are three or more.
fn crossings(gates: &Gates) -> Vec<bool> {
    let mesh = gates.mesh;
    let junctions: Vec<usize> = (0..mesh.n_cells()).filter(|cell| gates.is_junction(*cell)).collect();
    let mut groups = DisjointSets::new(mesh.n_cells());
    // Junctions, and the cells between a junction and a mouth, each with its junction.
    let mut parts: Vec<(usize, usize)> = junctions.iter().map(|cell| (*cell, *cell)).collect();
    // The mouths of junctions, as sides of the last cells before the streets.
    let mut mouths: Vec<(usize, usize)> = Vec::new();
    for (junction, side) in
        junctions.iter().flat_map(|junction| gates.live(*junction).map(|(side, _)| (*junction, side)))
    {
        let chain = gates.chain(side);
        // Each chain between junctions is found from both ends, and processed once.
        if chain.end.is_some_and(|end| end < side) {
            continue;
        }
        let last = chain.gates.len() - 1;
        let near = gates.mouth(chain.gates.iter().copied());
        let width = |k: usize| mesh.length(chain.gates[k]) as f64;
        let Some(end) = chain.end.map(|end| mesh.cell(end)) else {
            parts.extend(chain.cells.iter().take(near).map(|cell| (*cell, junction)));
            mouths.push((junction, chain.gates[near]));
            continue;
        };
        let far = last - gates.mouth(chain.gates.iter().rev().copied());
        let between: i64 = (near..far).map(|k| mesh.distance(chain.gates[k], chain.gates[k + 1])).sum();
        if near >= far || (between as f64) < SHORTEST_STREET_WIDTHS * width(near).min(width(far)) {
            groups.join(junction, end);
            parts.extend(chain.cells.iter().map(|cell| (*cell, junction)));
        } else {
            parts.extend(chain.cells.iter().take(near).map(|cell| (*cell, junction)));
            parts.extend(chain.cells.iter().skip(far).map(|cell| (*cell, end)));
            mouths.push((junction, chain.gates[near]));
            mouths.extend(gates.beyond(chain.gates[far]).map(|mouth| (end, mouth)));
        }
    }
    let mut regions: BTreeMap<usize, Region> = BTreeMap::new();
    for (cell, junction) in &mut parts {
        *junction = groups.root(*junction);
        let region = regions.entry(*junction).or_default();
        let area = if mesh.meets_frame(*cell) { &mut region.area_at_frame } else { &mut region.area };
        *area += mesh.doubled_area(*cell);
    }
    let mut widths = Vec::new();
    for (junction, side) in mouths {
        let width = mesh.length(side);
        regions.entry(groups.root(junction)).or_default().mouths.push(width);
        if !mesh.meets_frame(mesh.cell(side)) {
            widths.push(width);
        }
    }
    for junction in junctions {
        let region = regions.entry(groups.root(junction)).or_default();
        region.mouths.extend(mesh.frame_corners(junction));
    }
    let widest_street = WIDEST_STREET_TYPICAL * upper_quartile(widths) as f64;
    let mut is_crossing = vec![false; mesh.n_cells()];
    for (cell, root) in parts {
        let at_frame = mesh.meets_frame(cell);
        is_crossing[cell] |= regions.get(&root).is_some_and(|region| region.is_crossing(widest_street, at_frame));
    }
    is_crossing
}

/// A candidate for a crossing: the joined ground at which streets meet, or open ground too wide for
/// a crossing.
#[derive(Debug, Default)]
struct Region {
    /// Twice the area of its cells without a corner on the frame \[steps²\].
    area: i128,
    /// Twice the area of its other cells \[steps²\].
    area_at_frame: i128,
    /// Widths of its mouths \[steps\].
    mouths: Vec<i64>,
}

impl Region {
    /// Returns `true` if the region, or the part of it at the frame, is a crossing.
    fn is_crossing(&self, widest_street: f64, at_frame: bool) -> bool {
        let mut streets: Vec<f64> =
            self.mouths.iter().map(|width| *width as f64).filter(|width| *width <= widest_street).collect();
        streets.sort_unstable_by(|a, b| b.total_cmp(a));
        let [widest, second, third, ..] = streets[..] else { return false };
        let square = widest * widest;
        let [area, area_at_frame] = [self.area, self.area_at_frame].map(|doubled| doubled as f64 / 2.0);
        let is_cut_large = area_at_frame > LARGEST_CROSSING_AT_FRAME_WIDTHS2 * square;
        let is_outskirts = is_cut_large && (at_frame || area_at_frame > area);
        third >= NARROWEST_STREET_SHARE * second && area <= LARGEST_CROSSING_WIDTHS2 * square && !is_outskirts
    }
}

/// Returns the value that a quarter of the values exceed; 0 if there are none.
fn upper_quartile(mut values: Vec<i64>) -> i64 {
    let at = values.len() * 3 / 4;
    if at >= values.len() {
        return 0;
    }
    *values.select_nth_unstable(at).1
}
