//! City as bytes: the page carries them, and its engine builds the city from them.
//!
//! A city is packed as it was read, on the lattice, before it is made ready for rays. So the page
//! and the program build the same height field.
//!
//! Numbers are laid out for a general compressor. A height is stored as its difference from the
//! value that its neighbors predict. The first bytes of all heights come first, then all second
//! bytes, and so on.

pub use crate::packed_bytes::NotPacked;
use crate::packed_bytes::{In, Out, unzigzag, zigzag};
pub use crate::packed_zones::PackedZones;

use skyshed_core::city::{Area, DataArea, Footprint, FootprintFaults, Ground, RoofTriangle, Solids};
use skyshed_core::height_field::MAX_ROOF_STEPS;
use skyshed_core::quantity::Frame;
use skyshed_core::raster::{BitGrid, Crs, CrsDefinition, CrsKind, GeoRef, Raster};

/// First bytes; the number grows whenever the format changes.
const MAGIC: &[u8] = b"skyshed scene 2\n";

/// Largest number of cells that a page holds: 16 million, or 4096 × 4096.
pub const MOST_CELLS: usize = 1 << 24;
/// Largest number of footprints that a page holds.
pub const MOST_FOOTPRINTS: usize = 300_000;

/// Returns `true` if a page can hold a city.
pub fn is_small_enough(grid: &GeoRef, solids: &Solids) -> bool {
    let n_footprints = match solids {
        Solids::Vector { footprints, .. } => footprints.len(),
        Solids::Raster { .. } => 0,
    };
    grid.n_cells() <= MOST_CELLS && n_footprints <= MOST_FOOTPRINTS
}

/// City of a page, with all that engines need of it.
#[derive(Debug, Clone)]
pub struct PackedCity {
    /// Grid of receivers.
    pub grid: GeoRef,
    /// Solids that block rays.
    pub solids: Solids,
    /// Zones of its open ground, if it has any. The program finds them, since that takes longer
    /// than building all else.
    pub zones: Option<PackedZones>,
}

/// Packs a city.
pub fn pack(grid: &GeoRef, solids: &Solids, zones: Option<&PackedZones>) -> Vec<u8> {
    let mut out = Out(MAGIC.to_vec());
    out.grid(grid);
    out.option(zones, |out, zones| {
        out.list(&zones.runs, |out, (n, code)| {
            out.count(*n);
            out.0.push(*code);
        });
    });
    match solids {
        Solids::Raster { surface, ground, building_threshold, voids } => {
            out.0.push(0);
            out.raster(surface);
            out.ground(ground);
            out.int(i64::from(*building_threshold));
            out.option(voids.as_ref(), |out, cells| cells.words().iter().for_each(|w| out.0.extend(w.to_le_bytes())));
        }
        Solids::Vector { footprints, frame, ground, data_area, .. } => {
            out.0.push(1);
            [frame.x_origin, frame.y_origin, frame.unit_x, frame.unit_y].into_iter().for_each(|v| out.real(v));
            out.ground(ground);
            match data_area {
                DataArea::All => out.0.push(0),
                DataArea::NearFootprints => out.0.push(1),
                DataArea::Within(area) => {
                    out.0.push(2);
                    out.list(area.polygons(), |out, rings| {
                        out.list(rings, |out, ring| {
                            out.list(ring, |out, point| point.iter().for_each(|v| out.real(*v)))
                        });
                    });
                }
            }
            out.footprints(footprints);
        }
    }
    out.0
}

/// Unpacks a city.
///
/// # Errors
/// [`NotPacked`] if the bytes are not those of a packed city.
pub fn unpack(bytes: &[u8]) -> Result<PackedCity, NotPacked> {
    let mut read = In(bytes.strip_prefix(MAGIC).ok_or(NotPacked)?);
    let grid = read.grid()?;
    let zones = read.option(|read| {
        let runs = read.list(|read| Ok((read.count()?, read.byte()?)))?;
        Ok(PackedZones { runs })
    })?;
    let solids = match read.byte()? {
        0 => Solids::Raster {
            surface: read.raster()?,
            ground: read.ground()?,
            building_threshold: read.narrow()?,
            voids: read.option(|read| {
                let words = read.array(grid.n_rows() * grid.n_cols().div_ceil(64), u64::from_le_bytes)?;
                Ok(BitGrid::from_words(grid.n_cols(), words))
            })?,
        },
        1 => {
            let [x_origin, y_origin, unit_x, unit_y] = [read.real()?, read.real()?, read.real()?, read.real()?];
            let ground = read.ground()?;
            let data_area = match read.byte()? {
                0 => DataArea::All,
                1 => DataArea::NearFootprints,
                2 => DataArea::Within(Area::new(
                    read.list(|read| read.list(|read| read.list(|read| Ok([read.real()?, read.real()?]))))?,
                )),
                _ => return Err(NotPacked),
            };
            Solids::Vector {
                footprints: read.footprints()?,
                frame: Frame { x_origin, y_origin, unit_x, unit_y },
                ground,
                faults: FootprintFaults::default(),
                data_area,
            }
        }
        _ => return Err(NotPacked),
    };
    Ok(PackedCity { grid, solids, zones })
}

/// Predicts the height of a cell from the cells west, north and north-west of it. The result is the
/// median of west, north, and the plane through all three.
///
/// # References
/// Martucci 1990; the predictor of JPEG-LS.
fn expected(west: i32, north: i32, north_west: i32) -> i32 {
    let (low, high) = (west.min(north), west.max(north));
    if north_west >= high {
        low
    } else if north_west <= low {
        high
    } else {
        west.wrapping_add(north).wrapping_sub(north_west)
    }
}

/// Visits cells row by row, each with the height predicted from the cells before it.
fn for_each_expected(cells: &mut [i32], n_cols: usize, mut each: impl FnMut(&mut i32, i32)) {
    for i in 0..cells.len() {
        let (has_west, has_north) = (i % n_cols > 0, i >= n_cols);
        let expected = match (has_west, has_north) {
            (true, true) => expected(cells[i - 1], cells[i - n_cols], cells[i - n_cols - 1]),
            (true, false) => cells[i - 1],
            (false, true) => cells[i - n_cols],
            (false, false) => 0,
        };
        each(&mut cells[i], expected);
    }
}

impl Out {
    fn grid(&mut self, grid: &GeoRef) {
        let unit = grid.meters_per_unit();
        [grid.x_min(), grid.y_max(), grid.cell_width(), grid.cell_height(), unit]
            .into_iter()
            .for_each(|v| self.real(v));
        self.count(grid.n_rows() as u64);
        self.count(grid.n_cols() as u64);
    }

    fn ground(&mut self, ground: &Ground) {
        match ground {
            Ground::Surface => self.0.push(0),
            Ground::Flat(z) => {
                self.0.push(1);
                self.int(i64::from(*z));
            }
            Ground::Terrain(terrain) => {
                self.0.push(2);
                self.raster(terrain);
            }
        }
    }

    fn raster(&mut self, raster: &Raster<i32>) {
        self.grid(raster.georef());
        let mut differences = Vec::with_capacity(raster.cells().len());
        let mut cells = raster.cells().to_vec();
        for_each_expected(&mut cells, raster.georef().n_cols(), |cell, expected| {
            differences.push(zigzag(cell.wrapping_sub(expected)));
        });
        self.bytes_apart(&differences);
    }

    /// Writes footprints kind by kind: ids, numbers of polygons, rings and points, corners, tops
    /// and bases, then triangles of roofs with their corners.
    fn footprints(&mut self, footprints: &[Footprint]) {
        self.list(footprints, |out, f| out.list(f.id.as_bytes(), |out, byte| out.0.push(*byte)));
        footprints.iter().for_each(|f| {
            self.list(&f.polygons, |out, rings| out.list(rings, |out, ring| out.count(ring.len() as u64)));
        });
        let rings = || footprints.iter().flat_map(|f| f.polygons.iter().flatten());
        for axis in 0..2 {
            let mut last = 0;
            rings().flatten().for_each(|point| {
                self.int(i64::from(point[axis]) - last);
                last = i64::from(point[axis]);
            });
        }
        footprints.iter().for_each(|f| self.int(i64::from(f.top)));
        footprints.iter().for_each(|f| self.option(f.base, |out, base| out.int(i64::from(base))));
        footprints.iter().for_each(|f| self.count(f.roof.len() as u64));
        for axis in 0..3 {
            let mut last = 0;
            footprints.iter().flat_map(|f| f.roof.as_flattened()).for_each(|corner| {
                self.int(i64::from(corner[axis]) - last);
                last = i64::from(corner[axis]);
            });
        }
    }
}

impl In<'_> {
    fn grid(&mut self) -> Result<GeoRef, NotPacked> {
        let [x_min, y_max, width, height, meters_per_unit] =
            [self.real()?, self.real()?, self.real()?, self.real()?, self.real()?];
        let of_usize = |n: u64| usize::try_from(n).map_err(|_| NotPacked);
        let shape = (of_usize(self.count()?)?, of_usize(self.count()?)?);
        // Engines need no more of a reference system than the length of its unit.
        let crs = Crs::new(None, "", CrsKind::Projected { meters_per_unit }, CrsDefinition::Described);
        GeoRef::new((x_min, y_max), (width, height), shape, Some(crs)).ok_or(NotPacked)
    }

    fn ground(&mut self) -> Result<Ground, NotPacked> {
        match self.byte()? {
            0 => Ok(Ground::Surface),
            1 => self.narrow().map(Ground::Flat),
            2 => self.raster().map(Ground::Terrain),
            _ => Err(NotPacked),
        }
    }

    fn raster(&mut self) -> Result<Raster<i32>, NotPacked> {
        let georef = self.grid()?;
        let n = georef.n_cells();
        if n.checked_mul(4).is_none_or(|n_bytes| n_bytes > self.0.len()) {
            return Err(NotPacked);
        }
        let (bytes, rest) = self.0.split_at(4 * n);
        self.0 = rest;
        let difference = |i: usize| unzigzag(u32::from_le_bytes([0, 1, 2, 3].map(|k| bytes[k * n + i])));
        let mut cells: Vec<i32> = (0..n).map(difference).collect();
        for_each_expected(&mut cells, georef.n_cols(), |cell, expected| *cell = cell.wrapping_add(expected));
        Ok(Raster::new(georef, cells))
    }

    fn footprints(&mut self) -> Result<Vec<Footprint>, NotPacked> {
        let ids = self.list(|read| {
            let n = read.length()?;
            String::from_utf8(read.array(n, |[byte]: [u8; 1]| byte)?).map_err(|_| NotPacked)
        })?;
        let mut polygons: Vec<Vec<Vec<Vec<[i32; 2]>>>> = Vec::with_capacity(ids.len());
        for _ in &ids {
            polygons.push(self.list(|read| read.list(|read| read.length().map(|n| vec![[0; 2]; n])))?);
        }
        for axis in 0..2 {
            let mut last = 0_i64;
            for point in polygons.iter_mut().flatten().flatten().flatten() {
                last = last.wrapping_add(self.int()?);
                point[axis] = i32::try_from(last).map_err(|_| NotPacked)?;
            }
        }
        let tops = ids.iter().map(|_| self.narrow()).collect::<Result<Vec<i32>, _>>()?;
        let bases = ids.iter().map(|_| self.option(Self::narrow)).collect::<Result<Vec<Option<i32>>, _>>()?;
        let mut roofs = Vec::with_capacity(ids.len());
        for _ in &ids {
            roofs.push(vec![[[0_i32; 3]; 3]; self.length()?]);
        }
        for axis in 0..3 {
            let mut last = 0_i64;
            for corner in roofs.iter_mut().flatten().flatten() {
                last = last.wrapping_add(self.int()?);
                corner[axis] = i32::try_from(last).map_err(|_| NotPacked)?;
            }
        }
        if roofs.iter().flatten().any(|corners| !is_roof(corners)) {
            return Err(NotPacked);
        }
        let parts = ids.into_iter().zip(polygons).zip(tops.into_iter().zip(bases)).zip(roofs);
        Ok(parts
            .map(|(((id, polygons), (top, base)), roof)| Footprint {
                id,
                polygons,
                top,
                roof,
                base,
                height_error: None,
                part_of: None,
            })
            .collect())
    }
}

/// Returns `true` if corners can belong to a triangle of a roof.
fn is_roof([a, b, c]: &RoofTriangle) -> bool {
    let side = |from: &[i32; 3], to: &[i32; 3], axis: usize| i64::from(to[axis]) - i64::from(from[axis]);
    let heights = [a[2], b[2], c[2]];
    let is_flat = heights == [a[2]; 3];
    let most = if is_flat { 1 << 26 } else { i64::from(MAX_ROOF_STEPS) };
    let is_near = |to: &[i32; 3]| (0..2).all(|axis| side(a, to, axis).abs() <= most);
    let is_in_range = heights.iter().all(|z| z.unsigned_abs() <= 1 << 25);
    let doubled = || side(a, b, 0) * side(a, c, 1) - side(a, b, 1) * side(a, c, 0);
    is_near(b) && is_near(c) && is_in_range && doubled() > 0
}

#[cfg(test)]
mod tests {
    use super::*;
    use skyshed_core::quantity::VOID;

    #[test]
    fn a_city_comes_out_as_it_went_in() {
        let grid = GeoRef::new((10.25, 20.5), (0.5, 0.25), (3, 70), None).expect("a grid");
        let heights: Vec<i32> = (0..210).map(|i| if i % 17 == 3 { VOID } else { (i * 7919) % 5000 - 100 }).collect();
        let voids = BitGrid::full(3, 70);
        let raster = |ground| Solids::Raster {
            surface: Raster::new(grid.clone(), heights.clone()),
            ground,
            building_threshold: 256,
            voids: Some(voids.clone()),
        };
        let ring = vec![[-5, 7], [2_000_000, 8], [3, i32::MAX]];
        let footprint = |base| Footprint {
            id: "ä<b>".into(),
            polygons: vec![vec![ring.clone()]; 2],
            top: -9,
            roof: vec![[[-5, 7, -9], [1_000_000, 8, -100], [3, 1_000_000, -9]]],
            base,
            height_error: None,
            part_of: None,
        };
        let vector = |data_area| Solids::Vector {
            footprints: vec![footprint(None), footprint(Some(3))],
            frame: Frame { x_origin: 0.1, y_origin: 2.0, unit_x: 1.0, unit_y: 1.0 },
            ground: Ground::Flat(17),
            faults: FootprintFaults::default(),
            data_area,
        };
        let area = Area::new(vec![vec![vec![[0.5, 1.0], [2.0, 3.0], [4.0, -5.0]]]]);
        let terrain = Ground::Terrain(Raster::new(grid.clone(), heights.clone()));
        let scenes = [
            raster(Ground::Surface),
            raster(terrain),
            vector(DataArea::NearFootprints),
            vector(DataArea::Within(area)),
        ];
        for solids in scenes {
            let open = BitGrid::from_words(70, vec![0x00FF_F0F0_FFFF_0F1F, 0x3F, u64::MAX, 0x1F, 0xF0F0, 0]);
            let codes: Vec<u8> =
                (0..210).map(|i| if open.contains(i / 70, i % 70) { [1, 0, 3, 2, 4][i / 13 % 5] } else { 0 }).collect();
            let zones = PackedZones::of(&codes, &open);
            assert_eq!(zones.codes(&open), codes);
            let bytes = pack(&grid, &solids, Some(&zones));
            let found = unpack(&bytes).expect("it is packed");
            assert!(found.grid.same_grid(&grid) && found.zones.as_ref() == Some(&zones));
            // Of a reference system, only the length of its unit is kept.
            assert_eq!(pack(&found.grid, &found.solids, found.zones.as_ref()), bytes);
            let words = |solids: &Solids| match solids {
                Solids::Raster { surface, ground, building_threshold, voids } => {
                    format!(
                        "{:?} {building_threshold} {voids:?} {}",
                        surface.cells(),
                        matches!(ground, Ground::Terrain(_))
                    )
                }
                Solids::Vector { footprints, frame, data_area, .. } => {
                    format!("{footprints:?} {frame:?} {data_area:?}")
                }
            };
            assert_eq!(words(&found.solids), words(&solids));
            // Bytes that are cut off anywhere are refused without a panic.
            (0..bytes.len()).for_each(|n| assert!(unpack(&bytes[..n]).is_err(), "{n}"));
        }
    }
}
