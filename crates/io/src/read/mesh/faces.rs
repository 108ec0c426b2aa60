//! Vertices and faces, as both formats hold them.

/// Vertices and the faces over them.
#[derive(Debug, Default)]
pub(super) struct Mesh {
    /// x, y \[CRS units\], z \[m above the datum\].
    pub(super) vertices: Vec<[f64; 3]>,
    /// Numbers of vertices, face after face.
    pub(super) corners: Vec<u32>,
    /// End of each face in `corners`.
    pub(super) ends: Vec<usize>,
}

impl Mesh {
    /// Adds a face; the error names a missing vertex.
    pub(super) fn add_face(&mut self, corners: &[u32]) -> std::result::Result<(), String> {
        if let Some(k) = corners.iter().find(|k| **k as usize >= self.vertices.len()) {
            return Err(format!("a face names vertex number {k}, of {} counted from 0", self.vertices.len()));
        }
        self.corners.extend(corners);
        self.ends.push(self.corners.len());
        Ok(())
    }

    /// Returns the corners of each face.
    pub(super) fn faces(&self) -> impl Iterator<Item = impl Iterator<Item = [f64; 3]> + '_> + '_ {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        let ranges = starts.zip(&self.ends).map(|(from, to)| from..*to);
        ranges.map(|range| self.corners[range].iter().map(|k| self.vertices[*k as usize]))
    }

    /// Returns west, south, east, north of all faces; `None` without one.
    pub(super) fn bounds(&self) -> Option<[f64; 4]> {
        self.faces().flatten().fold(None, |bounds, [x, y, _]| {
            let [w, s, e, n] = bounds.unwrap_or([x, y, x, y]);
            Some([w.min(x), s.min(y), e.max(x), n.max(y)])
        })
    }
}
