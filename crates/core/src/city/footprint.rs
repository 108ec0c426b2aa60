//! A building of a vector scene.

use std::collections::HashMap;

use crate::quantity::{Frame, meters};

/// A triangle of a roof, counterclockwise as seen from above: corners on the lattice, each with its
/// height \[1/1024 m above the datum\].
pub type RoofTriangle = [[i32; 3]; 3];

/// A building: polygons on the lattice and a roof. It is solid from below the ground up.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Footprint {
    /// The feature's id, or its number in the file.
    pub id: String,
    /// Polygons of rings (not closed) of lattice points. Insides follow the even-odd rule; edges do
    /// not cross.
    pub polygons: Vec<Vec<Vec<[i32; 2]>>>,
    /// Top \[1/1024 m above the datum\]; the highest point of a roof that is not flat.
    pub top: i32,
    /// The triangles of the roof, which cover the polygons; empty if it is flat. Corners of a
    /// sloping triangle are within [`MAX_ROOF_STEPS`](crate::height_field::MAX_ROOF_STEPS) of each
    /// other.
    pub roof: Vec<RoofTriangle>,
    /// Height of the ground below it \[1/1024 m above the datum\]. `None` if unknown, which only an
    /// absolute top allows.
    pub base: Option<i32>,
    /// Standard deviation of the error of its height \[1/1024 m\], if known.
    pub height_error: Option<i32>,
    /// The number of the building that this is a part of, if it is a part.
    pub part_of: Option<u32>,
}

impl Footprint {
    /// Makes a footprint of known height on ground at 0 m.
    pub fn on_zero(id: String, polygons: Vec<Vec<Vec<[i32; 2]>>>, top: i32) -> Self {
        Footprint { id, polygons, top, roof: Vec::new(), base: Some(0), height_error: None, part_of: None }
    }
}

/// Height and position of a building.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BuildingHeight {
    /// East \[CRS units\], of the centroid.
    pub x: f64,
    /// North \[CRS units\], of the centroid.
    pub y: f64,
    /// Above the ground below the building \[m\].
    pub height_m: f64,
}

impl Footprint {
    /// Returns the height above the ground below it \[m\], if that ground is known.
    pub fn height_m(&self) -> Option<f64> {
        self.base.map(|base| meters(self.top) - meters(base))
    }

    /// Returns the height of its bottom in models: the ground below it. If that is unknown, it is
    /// the datum, or the top if lower.
    pub fn bottom(&self) -> i32 {
        self.base.unwrap_or(self.top.min(0))
    }

    /// Returns `true` if the outline is one rectangle: four corners, each within a degree of a
    /// right angle. Vertices on its sides are ignored.
    pub fn is_rectangle(&self) -> bool {
        let [polygon] = self.polygons.as_slice() else { return false };
        let [ring] = polygon.as_slice() else { return false };
        let edge = |a: [i32; 2], b: [i32; 2]| [0, 1].map(|k| f64::from(b[k]) - f64::from(a[k]));
        let n = ring.len();
        // The turn at each vertex: its sine and cosine.
        let turns = (0..n).map(|k| {
            let (a, b) = (edge(ring[(k + n - 1) % n], ring[k]), edge(ring[k], ring[(k + 1) % n]));
            let lengths = a[0].hypot(a[1]) * b[0].hypot(b[1]);
            ((a[0] * b[1] - a[1] * b[0]) / lengths, (a[0] * b[0] + a[1] * b[1]) / lengths)
        });
        const DEGREE: f64 = 0.017_452_406;
        let corners: Vec<(f64, f64)> = turns.filter(|(sin, cos)| sin.abs() > DEGREE || *cos < 0.0).collect();
        let turns_alike = corners.iter().all(|c| c.0 > 0.0) || corners.iter().all(|c| c.0 < 0.0);
        corners.len() == 4 && turns_alike && corners.iter().all(|c| c.1.abs() <= DEGREE)
    }

    /// Returns heights and positions of the buildings that have an area and a known ground;
    /// positions are converted by `frame`. A building of several parts has the mean of their
    /// heights, weighted by area.
    pub(super) fn building_heights(footprints: &[Footprint], frame: Frame) -> Vec<BuildingHeight> {
        // Each building with its area in square steps.
        let mut found: Vec<(BuildingHeight, f64)> = Vec::with_capacity(footprints.len());
        let mut place_of: HashMap<u32, usize> = HashMap::new();
        for footprint in footprints {
            let (Some(([x, y], denominator)), Some(height_m)) = (footprint.centroid(), footprint.height_m()) else {
                continue;
            };
            #[expect(clippy::cast_precision_loss, reason = "to some hundredths of a step")]
            let (area, x, y) = (denominator as f64 / 6.0, x as f64 / denominator as f64, y as f64 / denominator as f64);
            let (x, y) = frame.world_from_lattice(x, y);
            match footprint.part_of.map(|group| *place_of.entry(group).or_insert(found.len())) {
                Some(place) if place < found.len() => {
                    let (whole, of_all) = &mut found[place];
                    *of_all += area;
                    let mean = |all: f64, part: f64| all + (part - all) * area / *of_all;
                    *whole = BuildingHeight {
                        x: mean(whole.x, x),
                        y: mean(whole.y, y),
                        height_m: mean(whole.height_m, height_m),
                    };
                }
                _ => found.push((BuildingHeight { x, y, height_m }, area)),
            }
        }
        found.into_iter().map(|(height, _)| height).collect()
    }

    /// Returns the centroid in lattice steps, as numerators and one denominator above 0; `None`
    /// without area.
    pub fn centroid(&self) -> Option<([i128; 2], i128)> {
        let mut sums = [0_i128; 3];
        for rings in &self.polygons {
            for (k, ring) in rings.iter().enumerate() {
                let of_ring = moments(ring);
                // For any winding, shells add and holes subtract.
                let adds = (of_ring[2] > 0) == (k == 0);
                for (sum, moment) in sums.iter_mut().zip(of_ring) {
                    *sum += if adds { moment } else { -moment };
                }
            }
        }
        let [x, y, doubled_area] = sums;
        (doubled_area > 0).then_some(([x, y], 3 * doubled_area))
    }
}

/// Returns sums over the edges of a ring: six times its first moments along x and y, and twice its
/// area. All have the sign of its winding.
fn moments(ring: &[[i32; 2]]) -> [i128; 3] {
    let mut sums = [0_i128; 3];
    for (a, b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
        let [[ax, ay], [bx, by]] = [a, b].map(|p| p.map(i128::from));
        let cross = ax * by - bx * ay;
        sums[0] += (ax + bx) * cross;
        sums[1] += (ay + by) * cross;
        sums[2] += cross;
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_centroid_of_a_footprint_is_that_of_its_area() {
        let square = |x: i32, s: i32| vec![[x, 0], [x + s, 0], [x + s, s], [x, s]];
        let of = |polygons: Vec<Vec<Vec<[i32; 2]>>>| {
            Footprint::on_zero(String::new(), polygons, 1).centroid().map(|([x, y], d)| (x * 12 / d, y * 12 / d))
        };
        // In twelfths. A square of 6; the same wound the other way; with a hole of 2 × 2 in its
        // west: (36·3 − 4·1)/32 = 13/4.
        assert_eq!(of(vec![vec![square(0, 6)]]), Some((36, 36)));
        let turned: Vec<[i32; 2]> = square(0, 6).into_iter().rev().collect();
        assert_eq!(of(vec![vec![turned]]), Some((36, 36)));
        let hole: Vec<[i32; 2]> = vec![[0, 2], [2, 2], [2, 4], [0, 4]];
        assert_eq!(of(vec![vec![square(0, 6), hole]]), Some((39, 36)));
        // Two squares of 2 and 4 at 0 and 10: x = (4·1 + 16·12)/20, y = (4·1 + 16·2)/20.
        assert_eq!(of(vec![vec![square(0, 2)], vec![square(10, 4)]]), Some((12 * 196 / 20, 12 * 36 / 20)));
        assert_eq!(of(vec![]), None);
    }
}
