//! Open ground that is enclosed.

use super::gates::Gates;
use super::mesh::Beyond;

/// Area \[m²\] below which a part of the open ground that opens to another is a slit between walls, no yard.
const SMALLEST_YARD_M2: f64 = 25.0;

/// Part of the open ground: cells that gates connect.
#[derive(Debug, Default)]
struct Part {
    /// Twice its area \[steps²\].
    doubled_area: i128,
    meets_frame: bool,
    /// Cells beyond openings that are no way through.
    beside: Vec<usize>,
}

/// Returns by cell whether it is enclosed: no way leads from it to the frame. A slit, enclosed by walls only in part and
/// too small to stand in, is what it opens to.
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

/// Returns by part whether it is enclosed. Beginning with the slits beside other parts, each takes after the largest part
/// beside it that is decided; of equal ones after one that is not enclosed.
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
