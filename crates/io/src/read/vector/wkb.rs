//! Polygons of well-known binary (OGC 06-103r4, section 8; the ISO and the extended codes of Z and
//! M).
//!
//! Counts are never trusted: a geometry must have the bytes that its count requires, so that
//! nothing is reserved for missing data. Collections may nest only to a limit.

use super::super::polygon::Polygon;
use super::super::solid::Face;
use super::surfaces::Areas;

/// Deepest nesting of collections; a multipolygon in a collection is two.
const MOST_NESTED: usize = 16;

/// Returns the areas of a geometry; the error names the fault.
pub(in crate::read) fn areas_of(bytes: &[u8]) -> Result<Areas, String> {
    let mut areas = Areas::default();
    Reader { bytes, little_endian: true }.geometry(&mut areas, 0)?;
    Ok(areas)
}

/// Numbers of each position.
#[derive(Debug, Clone, Copy)]
struct Dimensions {
    n: usize,
    has_z: bool,
}

struct Reader<'a> {
    bytes: &'a [u8],
    little_endian: bool,
}

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let (head, rest) = self.bytes.split_first_chunk::<N>().ok_or("its geometry ends too early")?;
        self.bytes = rest;
        Ok(*head)
    }

    fn number(&mut self) -> Result<f64, String> {
        let bytes = self.take()?;
        Ok(if self.little_endian { f64::from_le_bytes(bytes) } else { f64::from_be_bytes(bytes) })
    }

    fn integer(&mut self) -> Result<u32, String> {
        let bytes = self.take()?;
        Ok(if self.little_endian { u32::from_le_bytes(bytes) } else { u32::from_be_bytes(bytes) })
    }

    /// Reads the number of parts that follow, each of at least `bytes_each`.
    fn count(&mut self, bytes_each: usize) -> Result<usize, String> {
        let n = self.integer()? as usize;
        if n > self.bytes.len() / bytes_each {
            return Err(format!("its geometry announces {n} parts, more than its {} bytes hold", self.bytes.len()));
        }
        Ok(n)
    }

    fn geometry(&mut self, areas: &mut Areas, depth: usize) -> Result<(), String> {
        if depth > MOST_NESTED {
            return Err(format!("its geometry nests more than {MOST_NESTED} collections"));
        }
        self.little_endian = match self.take::<1>()? {
            [0] => false,
            [1] => true,
            [other] => return Err(format!("its geometry begins with byte {other}, which names no byte order")),
        };
        let code = self.integer()?;
        let kind = (code & 0x0fff_ffff) % 1000;
        let has = |flag: u32, thousands: &[u32]| code & flag != 0 || thousands.contains(&((code & 0x0fff_ffff) / 1000));
        let (has_z, has_m) = (has(0x8000_0000, &[1, 3]), has(0x4000_0000, &[2, 3]));
        let dimensions = Dimensions { n: 2 + usize::from(has_z) + usize::from(has_m), has_z };
        if code & 0x2000_0000 != 0 {
            self.integer()?; // The reference system, which the table names too.
        }
        match kind {
            3 | 17 => {
                let n_rings = self.count(4)?;
                if dimensions.has_z {
                    let rings: Result<Face, String> = (0..n_rings).map(|_| self.ring_in_space(dimensions)).collect();
                    areas.push_face(rings?);
                } else {
                    let rings: Result<Polygon, String> = (0..n_rings).map(|_| self.ring(dimensions)).collect();
                    areas.push(rings?);
                }
                Ok(())
            }
            6 | 7 | 15 | 16 => {
                let n = self.count(5)?;
                (0..n).try_for_each(|_| self.geometry(areas, depth + 1))
            }
            1 => {
                areas.has_other_parts = true;
                self.skip(8 * dimensions.n)
            }
            2 => {
                areas.has_other_parts = true;
                let n = self.count(8 * dimensions.n)?;
                self.skip(n * 8 * dimensions.n)
            }
            4 | 5 => {
                let n = self.count(5)?;
                (0..n).try_for_each(|_| self.geometry(areas, depth + 1))
            }
            8..=14 => Err("it is a curve; straighten it first: `ogr2ogr -nlt CONVERT_TO_LINEAR`".into()),
            _ => Err(format!("its geometry has the unknown type {code}")),
        }
    }

    fn skip(&mut self, n_bytes: usize) -> Result<(), String> {
        self.bytes = self.bytes.get(n_bytes..).ok_or("its geometry ends too early")?;
        Ok(())
    }

    fn ring(&mut self, dimensions: Dimensions) -> Result<Vec<[f64; 2]>, String> {
        let n = self.count(8 * dimensions.n)?;
        let mut points = Vec::with_capacity(n);
        for _ in 0..n {
            points.push([self.number()?, self.number()?]);
            self.skip(8 * (dimensions.n - 2))?;
        }
        Ok(points)
    }

    /// Reads a ring whose positions have heights.
    fn ring_in_space(&mut self, dimensions: Dimensions) -> Result<Vec<[f64; 3]>, String> {
        let n = self.count(8 * dimensions.n)?;
        let mut points = Vec::with_capacity(n);
        for _ in 0..n {
            points.push([self.number()?, self.number()?, self.number()?]);
            self.skip(8 * (dimensions.n - 3))?;
        }
        Ok(points)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a triangle as a polygon of one ring, in one of both byte orders and with or without
    /// Z.
    fn triangle(little_endian: bool, code: u32, height: Option<f64>) -> Vec<u8> {
        let int = |n: u32| if little_endian { n.to_le_bytes() } else { n.to_be_bytes() };
        let float = |v: f64| if little_endian { v.to_le_bytes() } else { v.to_be_bytes() };
        let mut bytes = vec![u8::from(little_endian)];
        [code, 1, 4].iter().for_each(|n| bytes.extend(int(*n)));
        for [x, y] in [[0.0, 0.0], [4.0, 0.0], [0.0, 3.0], [0.0, 0.0]] {
            bytes.extend([float(x), float(y)].concat());
            bytes.extend(height.map(float).iter().flatten());
        }
        bytes
    }

    #[test]
    fn both_byte_orders_and_all_dimensions_are_read() {
        let ring = vec![[0.0, 0.0], [4.0, 0.0], [0.0, 3.0], [0.0, 0.0]];
        for bytes in [
            triangle(true, 3, None),
            triangle(false, 3, None),
            triangle(true, 1003, Some(7.0)),
            triangle(false, 0x8000_0003, Some(7.0)),
        ] {
            assert_eq!(areas_of(&bytes).expect("a polygon").into_feature().polygons, [vec![ring.clone()]]);
            for n in 0..bytes.len() {
                assert!(areas_of(&bytes[..n]).is_err(), "{n} bytes");
            }
        }
    }

    #[test]
    fn counts_that_lie_and_deep_nests_are_refused() {
        let mut bytes = triangle(true, 3, None);
        bytes[5..9].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(areas_of(&bytes).is_err_and(|e| e.contains("announces 4294967295 parts")));
        let nest: Vec<u8> = (0..100_000).flat_map(|_| [1, 7, 0, 0, 0, 1, 0, 0, 0]).collect();
        assert!(areas_of(&nest).is_err_and(|e| e.contains("nests more than 16")));
    }
}
