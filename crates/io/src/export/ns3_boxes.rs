//! Buildings as boxes of ns-3.

use std::path::Path;

use crate::city::Footprint;
use crate::error::{Error, Result, WriteFault};
use crate::quantity::{Frame, meters};

/// Returns a table `xMin,xMax,yMin,yMax,zMin,zMax`, one row per footprint, in the order of the
/// class `Box` of ns-3. Coordinates x and y are the scene's \[CRS units\]; z is above the datum
/// \[m\].
///
/// # Errors
/// Usage error (E109) if a footprint is not a rectangle parallel to the axes, or its roof is not
/// flat. A `Building` of ns-3 holds nothing else, and the box around any other shape would hide
/// receivers that are in sight.
pub fn ns3_boxes(footprints: &[Footprint], frame: Frame, path: &Path) -> Result<Vec<Vec<String>>> {
    let bounds: Vec<Option<[i32; 4]>> = footprints.iter().map(box_of).collect();
    let others = bounds.iter().filter(|b| b.is_none()).count();
    if others > 0 {
        return Err(Error::write(path.display(), WriteFault::NoBoxes(others, footprints.len())));
    }
    let header = ["xMin", "xMax", "yMin", "yMax", "zMin", "zMax"].map(str::to_string).to_vec();
    let row = |(footprint, [west, south, east, north]): (&Footprint, [i32; 4])| {
        let place = |x: i32, y: i32| frame.world_from_lattice(f64::from(x), f64::from(y));
        let ((x_min, y_min), (x_max, y_max)) = (place(west, south), place(east, north));
        [x_min, x_max, y_min, y_max, meters(footprint.bottom()), meters(footprint.top)].map(|v| v.to_string()).to_vec()
    };
    let rows = footprints.iter().zip(bounds.into_iter().flatten()).map(row);
    Ok(std::iter::once(header).chain(rows).collect())
}

/// Returns west, south, east and north of a footprint that is exactly the box within them \[1/1024
/// unit\].
fn box_of(footprint: &Footprint) -> Option<[i32; 4]> {
    let is_flat = footprint.roof.as_flattened().iter().all(|[.., z]| *z == footprint.top);
    let [polygon] = footprint.polygons.as_slice() else { return None };
    let [ring] = polygon.as_slice() else { return None };
    let low = |k: usize| ring.iter().map(|p| p[k]).min();
    let high = |k: usize| ring.iter().map(|p| p[k]).max();
    let [west, south, east, north] = [low(0)?, low(1)?, high(0)?, high(1)?];
    let edges = ring.iter().zip(ring.iter().cycle().skip(1));
    let doubled: i64 = edges.map(|(a, b)| i64::from(a[0]) * i64::from(b[1]) - i64::from(a[1]) * i64::from(b[0])).sum();
    let side = |a: i32, b: i32| i64::from(b) - i64::from(a);
    (is_flat && doubled.abs() == 2 * side(west, east) * side(south, north)).then_some([west, south, east, north])
}
