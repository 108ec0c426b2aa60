//! Points and scenes of the oracle as those of the crate, and back.

use skyshed_core::height_field::{Columns, ConvexPieces, Prisms, convex_pieces};
use skyshed_core::overlay::even_odd;
use skyshed_core::quantity::{LatticePoint, VOID};

use crate::oracle;

/// The crate's point of the oracle's.
pub(crate) fn point(p: oracle::P3) -> LatticePoint {
    LatticePoint { x: p[0], y: p[1], z: p[2] }
}

/// The crate's columns of the oracle's.
pub(crate) fn columns_of(columns: &oracle::Columns) -> Columns {
    let top = |h: &Option<i64>| h.map_or(VOID, |h| i32::try_from(h).unwrap());
    Columns::new(columns.n_rows, columns.n_cols, columns.heights.iter().map(top).collect::<Vec<_>>())
}

/// The oracle's columns of the crate's.
pub(crate) fn oracle_of(columns: &Columns) -> oracle::Columns {
    let heights = columns.tops().iter().map(|top| (*top != VOID).then_some(i64::from(*top))).collect();
    oracle::Columns { n_cols: columns.n_cols(), n_rows: columns.n_rows(), heights }
}

/// The crate's prisms of the oracle's: repaired and cut into convex pieces, as files are.
pub(crate) fn prisms_of(prisms: &[oracle::Prism]) -> Prisms {
    let narrow = |v: i64| i32::try_from(v).unwrap();
    Prisms::new(prisms.iter().enumerate().flat_map(|(building, prism)| {
        let rings: Vec<Vec<[i32; 2]>> =
            prism.rings.iter().map(|r| r.iter().map(|p| [narrow(p[0]), narrow(p[1])]).collect()).collect();
        let polygons = even_odd(&rings);
        let pieces = polygons.into_iter().flat_map(|polygon| match convex_pieces(&polygon) {
            ConvexPieces::Exact(pieces) => pieces,
            ConvexPieces::Hull(_) => panic!("{polygon:?} was not triangulated"),
        });
        let (top, building) = (narrow(prism.top), u32::try_from(building).unwrap());
        pieces.map(move |ring| (ring, top, building)).collect::<Vec<_>>()
    }))
}
