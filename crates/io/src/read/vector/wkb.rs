//! Polygons of well-known binary (OGC 06-103r4, section 8; the ISO and the extended codes of Z and
//! M).
//!
//! Counts are never trusted: a geometry must have the bytes that its count requires, so that
//! nothing is reserved for missing data. Collections may nest only to a limit.

use super::super::polygon::Polygon;

/// Deepest nesting of collections; a multipolygon in a collection is two.
const MOST_NESTED: usize = 16;

/// Adds the polygons of a geometry to `polygons`; returns `true` if it has points or lines too.
///
/// The error names the fault.
pub(in crate::read) fn polygons_of(bytes: &[u8], polygons: &mut Vec<Polygon>) -> Result<bool, String> {
    let mut reader = Reader { bytes, little_endian: true, has_other_parts: false };
    reader.geometry(polygons, 0)?;
    Ok(reader.has_other_parts)
}

struct Reader<'a> {
    bytes: &'a [u8],
    little_endian: bool,
    has_other_parts: bool,
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

    fn geometry(&mut self, polygons: &mut Vec<Polygon>, depth: usize) -> Result<(), String> {
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
        let has = |flag: u32, thousands: &[u32]| {
            usize::from(code & flag != 0 || thousands.contains(&((code & 0x0fff_ffff) / 1000)))
        };
        let dimensions = 2 + has(0x8000_0000, &[1, 3]) + has(0x4000_0000, &[2, 3]);
        if code & 0x2000_0000 != 0 {
            self.integer()?; // The reference system, which the table names too.
        }
        match kind {
            3 | 17 => {
                let n_rings = self.count(4)?;
                let rings: Result<Polygon, String> = (0..n_rings).map(|_| self.ring(dimensions)).collect();
                polygons.push(rings?);
                Ok(())
            }
            6 | 7 | 15 | 16 => {
                let n = self.count(5)?;
                (0..n).try_for_each(|_| self.geometry(polygons, depth + 1))
            }
            1 => {
                self.has_other_parts = true;
                self.skip(8 * dimensions)
            }
            2 => {
                self.has_other_parts = true;
                let n = self.count(8 * dimensions)?;
                self.skip(n * 8 * dimensions)
            }
            4 | 5 => {
                let n = self.count(5)?;
                (0..n).try_for_each(|_| self.geometry(polygons, depth + 1))
            }
            8..=14 => Err("it is a curve; straighten it first: `ogr2ogr -nlt CONVERT_TO_LINEAR`".into()),
            _ => Err(format!("its geometry has the unknown type {code}")),
        }
    }

    fn skip(&mut self, n_bytes: usize) -> Result<(), String> {
        self.bytes = self.bytes.get(n_bytes..).ok_or("its geometry ends too early")?;
        Ok(())
    }

    fn ring(&mut self, dimensions: usize) -> Result<Vec<[f64; 2]>, String> {
        let n = self.count(8 * dimensions)?;
        let mut points = Vec::with_capacity(n);
        for _ in 0..n {
            points.push([self.number()?, self.number()?]);
            self.skip(8 * (dimensions - 2))?;
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
            let mut polygons = Vec::new();
            polygons_of(&bytes, &mut polygons).expect("a polygon");
            assert_eq!(polygons, [vec![ring.clone()]]);
            for n in 0..bytes.len() {
                assert!(polygons_of(&bytes[..n], &mut Vec::new()).is_err(), "{n} bytes");
            }
        }
    }

    #[test]
    fn counts_that_lie_and_deep_nests_are_refused() {
        let mut bytes = triangle(true, 3, None);
        bytes[5..9].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(polygons_of(&bytes, &mut Vec::new()).is_err_and(|e| e.contains("announces 4294967295 parts")));
        let nest: Vec<u8> = (0..100_000).flat_map(|_| [1, 7, 0, 0, 0, 1, 0, 0, 0]).collect();
        assert!(polygons_of(&nest, &mut Vec::new()).is_err_and(|e| e.contains("nests more than 16")));
    }
}
