//! Heights between known ones, by triangulation.

use spade::{DelaunayTriangulation, FloatTriangulation, HasPosition, HierarchyHintGenerator, Point2, Triangulation};

/// A place and its height \[m above the datum\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct KnownHeight {
    pub(super) at: Point2<f64>,
    pub(super) height_m: f64,
}

impl HasPosition for KnownHeight {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.at
    }
}

/// Heights that are linear between known ones, which are triangulated (Delaunay). Beyond their hull
/// they are those of the nearest one.
#[derive(Debug)]
pub(super) struct TriangulatedHeights {
    mesh: DelaunayTriangulation<KnownHeight, (), (), (), HierarchyHintGenerator<f64>>,
}

impl TriangulatedHeights {
    /// Triangulates known heights one after the other. At one place the last is kept.
    pub(super) fn through(known: impl Iterator<Item = KnownHeight>) -> TriangulatedHeights {
        let mut mesh = DelaunayTriangulation::new();
        for height in known {
            // Positions are finite, and no lattice has any that spade would refuse.
            let _ = mesh.insert(height);
        }
        TriangulatedHeights { mesh }
    }

    /// Returns the corners of all triangles.
    #[cfg(feature = "point-clouds")]
    pub(super) fn triangles(&self) -> impl Iterator<Item = [KnownHeight; 3]> {
        self.mesh.inner_faces().map(|face| face.vertices().map(|corner| *corner.data()))
    }

    /// Returns the function that gives the height at a place \[m above the datum\]; `None` if none
    /// is known anywhere. It keeps a buffer, and is made for many places of one thread.
    pub(super) fn lookup(&self) -> impl Fn(f64, f64) -> Option<f64> {
        let between = self.mesh.barycentric();
        move |x, y| {
            let at = Point2::new(x, y);
            let height = between.interpolate(|known| known.data().height_m, at);
            height.or_else(|| self.mesh.nearest_neighbor(at).map(|known| known.data().height_m))
        }
    }
}
