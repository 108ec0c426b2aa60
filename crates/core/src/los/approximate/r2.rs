//! `r2`: one ray to each cell of the perimeter; every cell takes the answer of the nearest ray.

use super::quadrants::{Line, NOTHING, Quadrant, by_quadrants};
use crate::height_field::Columns;
use crate::quantity::LatticePoint;
use crate::raster::{BitGrid, CellWindow};

/// Returns the receivers of `wanted` that `r2` takes for LoS: *approximate*.
///
/// Rays go to the centers of the farthest line of each quadrant. In each line a ray takes the
/// height of the cell nearest to it. A cell takes the answer of the ray that passes nearest to its
/// center. Arguments are those of [`super::xdraw_los`].
///
/// Cost: one look-up per ray and line, twice the number of cells at most.
pub fn r2_los(
    columns: &Columns,
    uav: LatticePoint,
    height: &(dyn Fn(usize, usize) -> i64 + Sync),
    wanted: &BitGrid,
    window: CellWindow,
) -> BitGrid {
    by_quadrants(columns, uav, (wanted, window), |quadrant| seen(quadrant, height, wanted))
}

fn seen(quadrant: &Quadrant<'_>, height: &(dyn Fn(usize, usize) -> i64 + Sync), wanted: &BitGrid) -> BitGrid {
    let mut los = BitGrid::new(wanted.n_rows(), wanted.n_cols());
    let Some(far) = quadrant.lines().last() else { return los };
    let mut rays = Rays {
        far: far.distance,
        first: quadrant.offset_of_own_cell() - rings(&far),
        steepest: vec![NOTHING; usize::try_from(2 * far.ring + 1).unwrap_or(1)],
    };
    for line in quadrant.lines() {
        for lateral in (line.first..line.end).filter(|lateral| quadrant.decides(&line, *lateral)) {
            let cell = quadrant.cell(&line, lateral);
            if wanted.contains(cell.0, cell.1) {
                let ray = rays.nearest(quadrant.offset(lateral), &line);
                if quadrant.slope_of(&line, height(cell.0, cell.1)) >= rays.steepest[ray] {
                    los.insert(cell.0, cell.1);
                }
            }
        }
        rays.pass(quadrant, &line);
    }
    los
}

#[expect(clippy::cast_precision_loss, reason = "rings are below 2^17")]
fn rings(far: &Line) -> f64 {
    far.ring as f64
}

/// The rays of a quadrant: number k goes to offset `first` + k on the farthest line.
struct Rays {
    far: f64,
    first: f64,
    /// The steepest slope that each ray has passed.
    steepest: Vec<f64>,
}

impl Rays {
    /// Returns the ray that passes nearest to an offset along a line.
    #[inline]
    fn nearest(&self, offset: f64, line: &Line) -> usize {
        let k = (offset * (self.far / line.distance) - self.first).round();
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the rays")]
        let k = k.max(0.0) as usize;
        k.min(self.steepest.len() - 1)
    }

    /// Takes all rays past a line, as far as they are inside the window there.
    fn pass(&mut self, quadrant: &Quadrant<'_>, line: &Line) {
        if line.first >= line.end {
            return;
        }
        let inside = self.nearest(quadrant.offset(line.first) - 0.5, line)
            ..=self.nearest(quadrant.offset(line.end - 1) + 0.5, line);
        let scale = line.distance / self.far;
        for k in inside {
            #[expect(clippy::cast_precision_loss, reason = "rays are fewer than 2^18")]
            let offset = (self.first + k as f64) * scale;
            if let Some(lateral) = quadrant.nearest(line, offset) {
                self.steepest[k] = self.steepest[k].max(quadrant.slope(line, lateral));
            }
        }
    }
}
