//! Enclosed open ground.

use super::gates::Gates;
use super::mesh::Beyond;

/// Area \[m²\] below which a part of the open ground that opens to another part is a slit between
/// walls, no yard.
const SMALLEST_YARD_M2: f64 = 25.0;

/// Part of the open ground: cells connected by gates.
#[derive(Debug, Default)]
struct Part {
    /// Twice its area \[steps²\].
    doubled_area: i128,
    meets_frame: bool,
    /// Cells beyond openings that are no passage.
    beside: Vec<usize>,
}

/// Returns for each cell whether it is enclosed, so that no way leads from it to the frame.
///
/// A slit is enclosed by walls only in part and too small to stand in. It takes after the ground to
/// which it opens.
pub(super) fn courtyards(gates: &Gates) -> Vec<bool> {
    let mesh = gates.mesh;
    let mut part = vec![usize::MAX; mesh.n_cells()];
    let mut parts: Vec<Part> = Vec::new();
    for start in 0..mesh.n_cells() {
        if part[start] != usize::MAX {
            continue;
        }
        let number = parts.len();
        let mut found = Part::default();
        let mut open = vec![start];
        part[start] = number;
        while let Some(cell) = open.pop() {
            found.doubled_area += mesh.doubled_area(cell);
            for side in mesh.sides(cell) {
                match (gates.beyond(side), mesh.beyond(side)) {
                    (Some(other), _) => {
                        let next = mesh.cell(other);
                        if part[next] == usize::MAX {
                            part[next] = number;
                            open.push(next);
                        }
                    }
                    (None, Beyond::Open(other)) => found.beside.push(mesh.cell(other)),
                    (None, Beyond::Frame) => found.meets_frame = true,
                    (None, Beyond::Wall) => {}
                }
            }
        }
        parts.push(found);
    }
    let is_enclosed = enclosed(&parts, &part, |part| mesh.square_meters(part.doubled_area) < SMALLEST_YARD_M2);
    part.into_iter().map(|k| is_enclosed[k]).collect()
}

/// Returns for each part whether it is enclosed. Slits are decided outward from the parts beside
/// them. Each takes after the largest decided part beside it; of equally large ones, after one that
/// is not enclosed.
fn enclosed(parts: &[Part], part: &[usize], is_small: impl Fn(&Part) -> bool) -> Vec<bool> {
    let is_slit = |p: &Part| !p.meets_frame && !p.beside.is_empty() && is_small(p);
    let mut is_enclosed: Vec<Option<bool>> = parts.iter().map(|p| (!is_slit(p)).then_some(!p.meets_frame)).collect();
    let beside = |k: usize| parts[k].beside.iter().map(|cell| part[*cell]);
    let mut decided: Vec<usize> = (0..parts.len()).filter(|k| is_enclosed[*k].is_some()).collect();
    while !decided.is_empty() {
        let mut slits: Vec<usize> =
            decided.iter().flat_map(|k| beside(*k)).filter(|slit| is_enclosed[*slit].is_none()).collect();
        slits.sort_unstable();
        slits.dedup();
        let largest = |slit: &usize| {
            let known = beside(*slit).filter_map(|k| Some((parts[k].doubled_area, !is_enclosed[k]?)));
            known.max().map(|(_, is_open)| !is_open)
        };
        let found: Vec<Option<bool>> = slits.iter().map(largest).collect();
        for (slit, found) in slits.iter().zip(found) {
            is_enclosed[*slit] = found;
        }
        decided = slits;
    }
    is_enclosed.into_iter().map(|enclosed| enclosed.unwrap_or(false)).collect()
}
