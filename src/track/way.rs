//! Ways through a scene: paths of a file with heights on its lattice.

use super::TrackAsked;
use crate::coverage::{TrackHeight, TrackVertex, Way, WayVertex, height_over};
use crate::error::{OddRun, PlacesError, Result, Warning};
use crate::height_field::HeightField;
use crate::quantity::{Height, VOID, meters, tidy};
use crate::read::{Path, Paths, Vertex, VertexHeight};

/// Largest difference between a straight leg and one at the same height above the ground that is
/// told of nobody \[m\].
const MOST_OFF_M: f64 = 5.0;

/// A place where a straight leg is farthest from its height above the ground.
struct Off {
    by_m: f64,
    at: [f64; 2],
}

/// Returns the ways of paths. Heights are resolved at the vertices; a walk, which has none of its own, is `rx_height`
/// above the ground \[1/1024 m\].
///
/// # Errors
/// E2xx for a vertex whose height cannot be resolved.
pub(crate) fn ways_of(
    paths: Paths,
    (field, asked): (&HeightField, &TrackAsked),
    rx_height: i32,
    warnings: &mut Vec<Warning>,
) -> Result<Vec<Way>> {
    let home = home_ground(field, paths.home)?;
    let step = asked.every_m / field.grid().meters_per_unit();
    let resolver = Resolver { field, home, rx_height };
    let mut farthest: Option<Off> = None;
    let mut ways = Vec::new();
    for path in paths.lines {
        let mut vertices: Vec<WayVertex> = Vec::with_capacity(path.vertices.len());
        for (k, vertex) in path.vertices.iter().enumerate() {
            let to = resolver.vertex(vertex)?;
            if let Some(before) = k.checked_sub(1).map(|k| &path.vertices[k])
                && let Some(heights) = above_ground([before, vertex])
            {
                if asked.follows_ground {
                    resolver.follow([before, vertex], heights, step, &mut vertices)?;
                } else if let Some(off) = resolver.farthest_off([before, vertex], heights, step)? {
                    farthest = Some(off).into_iter().chain(farthest).max_by(|a, b| a.by_m.total_cmp(&b.by_m));
                }
            }
            vertices.push(to);
        }
        ways.push(Way { name: path.name, vertices });
    }
    if let Some(Off { by_m, at }) = farthest.filter(|off| off.by_m > MOST_OFF_M) {
        warnings.push(OddRun::StraightLegs { by_m: tidy(by_m), at: at.map(tidy) }.into());
    }
    Ok(ways)
}

/// Returns the ground where a mission begins \[1/1024 m above the datum\], if its place is known.
///
/// # Errors
/// E204 if no ground is known there.
pub(crate) fn home_ground(field: &HeightField, home: Option<[f64; 2]>) -> Result<Option<i32>> {
    let Some([x, y]) = home else { return Ok(None) };
    let height = Height::AboveGround(0.0);
    let ground = height_over(field, &field.place(x, y), height);
    Ok(Some(ground.map_err(|why| PlacesError::Receiver { at: (x, y), height, why })?))
}

/// Returns the height of a vertex with its reference in the scene.
pub(crate) fn resolved(height: VertexHeight, home: Option<i32>) -> Height {
    match (height, home) {
        (VertexHeight::Own(height), _) => height,
        (VertexHeight::AboveHome(m), Some(home)) => Height::AboveDatum(meters(home) + m),
        // No file has heights above a home that it does not name.
        (VertexHeight::AboveHome(m), None) => Height::AboveGround(m),
    }
}

/// Returns the heights of both ends of a leg, if both are above the ground \[m\].
fn above_ground(ends: [&Vertex; 2]) -> Option<[f64; 2]> {
    match ends.map(|end| end.height) {
        [Some(VertexHeight::Own(Height::AboveGround(a))), Some(VertexHeight::Own(Height::AboveGround(b)))] => {
            Some([a, b])
        }
        _ => None,
    }
}

struct Resolver<'a> {
    field: &'a HeightField,
    /// Ground at home \[1/1024 m above the datum\].
    home: Option<i32>,
    rx_height: i32,
}

impl Resolver<'_> {
    fn vertex(&self, vertex: &Vertex) -> Result<WayVertex> {
        let position = [vertex.x, vertex.y];
        let height = match vertex.height {
            None => TrackHeight::AboveGround(self.rx_height),
            Some(height) => self.above_datum(position, resolved(height, self.home))?,
        };
        Ok(WayVertex { vertex: TrackVertex { position, height }, time_s: vertex.time_s, is_given: true })
    }

    fn above_datum(&self, [x, y]: [f64; 2], height: Height) -> Result<TrackHeight> {
        let z = height_over(self.field, &self.field.place(x, y), height);
        let z = z.map_err(|why| PlacesError::Receiver { at: (x, y), height, why })?;
        Ok(TrackHeight::AboveDatum(i64::from(z)))
    }

    /// Returns fractions of a leg that cut it into steps, without its ends.
    fn cuts(ends: [&Vertex; 2], step: f64) -> impl Iterator<Item = f64> {
        let length = (ends[1].x - ends[0].x).hypot(ends[1].y - ends[0].y);
        let n = (length / step).ceil().max(1.0);
        std::iter::successors(Some(1.0), |k| Some(k + 1.0)).take_while(move |k| *k < n).map(move |k| k / n)
    }

    /// Adds vertices every step of a leg, each at its own height above the ground.
    fn follow(&self, ends: [&Vertex; 2], heights: [f64; 2], step: f64, vertices: &mut Vec<WayVertex>) -> Result<()> {
        for t in Self::cuts(ends, step) {
            let between = |from: f64, to: f64| from + t * (to - from);
            let position = [between(ends[0].x, ends[1].x), between(ends[0].y, ends[1].y)];
            let height = self.above_datum(position, Height::AboveGround(between(heights[0], heights[1])))?;
            let time_s = ends[0].time_s.zip(ends[1].time_s).map(|(a, b)| between(a, b));
            vertices.push(WayVertex { vertex: TrackVertex { position, height }, time_s, is_given: false });
        }
        Ok(())
    }

    /// Returns where a straight leg is farthest from its height above the ground.
    fn farthest_off(&self, ends: [&Vertex; 2], heights: [f64; 2], step: f64) -> Result<Option<Off>> {
        if self.field.flat_ground().is_some() {
            return Ok(None);
        }
        let ground_m = |[x, y]: [f64; 2]| {
            let ground = self.field.ground_at(&self.field.place(x, y));
            (ground != VOID).then(|| meters(ground))
        };
        let place = |t: f64| [ends[0].x + t * (ends[1].x - ends[0].x), ends[0].y + t * (ends[1].y - ends[0].y)];
        let Some((from, to)) = ground_m(place(0.0)).zip(ground_m(place(1.0))) else { return Ok(None) };
        let between = |a: f64, b: f64, t: f64| a + t * (b - a);
        let off = |t: f64| {
            let straight = between(from + heights[0], to + heights[1], t);
            let above = ground_m(place(t))? + between(heights[0], heights[1], t);
            Some(Off { by_m: (straight - above).abs(), at: place(t) })
        };
        Ok(Self::cuts(ends, step).filter_map(off).max_by(|a, b| a.by_m.total_cmp(&b.by_m)))
    }
}

/// Returns the places of all paths, for bounds.
pub(crate) fn places(paths: &[Path]) -> impl Iterator<Item = [f64; 2]> {
    paths.iter().flat_map(|path| &path.vertices).map(|vertex| [vertex.x, vertex.y])
}
