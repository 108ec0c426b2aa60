//! Writes uncompressed GeoTIFFs in strips byte by byte (TIFF 6.0, section 2), without a line of the crate.

#![allow(dead_code, reason = "each binary uses a part")]

/// The type of the cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Cells {
    Int16,
    Float32,
}

/// A raster of one band; cells are given row by row from the north.
#[derive(Clone, Debug)]
pub(crate) struct PlainTiff {
    pub(crate) corner: (f64, f64),
    pub(crate) cell: f64,
    pub(crate) n_cols: usize,
    pub(crate) n_rows: usize,
    pub(crate) cells: Cells,
    pub(crate) values: Vec<f64>,
    pub(crate) nodata: Option<i32>,
    pub(crate) rows_per_strip: usize,
    /// EPSG code of a projected system.
    pub(crate) epsg: u16,
}

impl PlainTiff {
    /// Numbers of 32 bits in EPSG:25832, three rows a strip, without nodata.
    pub(crate) fn floats(corner: (f64, f64), cell: f64, n_cols: usize, values: Vec<f64>) -> PlainTiff {
        let n_rows = values.len() / n_cols;
        let cells = Cells::Float32;
        PlainTiff { corner, cell, n_cols, n_rows, cells, values, nodata: None, rows_per_strip: 3, epsg: 25832 }
    }

    pub(crate) fn bytes(&self) -> Vec<u8> {
        let width = if self.cells == Cells::Int16 { 2 } else { 4 };
        let mut file = b"II*\0\0\0\0\0".to_vec();
        let (mut offsets, mut lengths) = (Vec::new(), Vec::new());
        for strip in self.values.chunks(self.rows_per_strip * self.n_cols) {
            offsets.push(u32::try_from(file.len()).unwrap());
            lengths.push(u32::try_from(strip.len() * width).unwrap());
            for value in strip {
                #[expect(clippy::cast_possible_truncation, reason = "values are made for their type")]
                match self.cells {
                    Cells::Int16 => file.extend((*value as i16).to_le_bytes()),
                    Cells::Float32 => file.extend((*value as f32).to_le_bytes()),
                }
            }
        }
        let short = |v: usize| u16::try_from(v).unwrap().to_le_bytes().to_vec();
        let longs = |v: &[u32]| v.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
        let doubles = |v: &[f64]| v.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
        let keys = [1, 1, 0, 3, 1024, 0, 1, 1, 1025, 0, 1, 1, 3072, 0, 1, self.epsg];
        // Tag, type, count, bytes.
        let mut tags: Vec<(u16, u16, usize, Vec<u8>)> = vec![
            (256, 3, 1, short(self.n_cols)),
            (257, 3, 1, short(self.n_rows)),
            (258, 3, 1, short(8 * width)),
            (259, 3, 1, short(1)),
            (262, 3, 1, short(1)),
            (273, 4, offsets.len(), longs(&offsets)),
            (277, 3, 1, short(1)),
            (278, 3, 1, short(self.rows_per_strip)),
            (279, 4, lengths.len(), longs(&lengths)),
            (339, 3, 1, short(if self.cells == Cells::Int16 { 2 } else { 3 })),
            (33550, 12, 3, doubles(&[self.cell, self.cell, 0.0])),
            (33922, 12, 6, doubles(&[0.0, 0.0, 0.0, self.corner.0, self.corner.1, 0.0])),
            (34735, 3, keys.len(), keys.iter().flat_map(|v| v.to_le_bytes()).collect()),
        ];
        if let Some(nodata) = self.nodata {
            let text = format!("{nodata}\0").into_bytes();
            tags.push((42113, 2, text.len(), text));
        }
        let mut directory = short(tags.len());
        for (tag, kind, count, bytes) in tags {
            directory.extend(tag.to_le_bytes());
            directory.extend(kind.to_le_bytes());
            directory.extend(u32::try_from(count).unwrap().to_le_bytes());
            let mut field = bytes.clone();
            if bytes.len() > 4 {
                field = u32::try_from(file.len()).unwrap().to_le_bytes().to_vec();
                file.extend(bytes);
            }
            field.resize(4, 0);
            directory.extend(field);
        }
        directory.extend([0; 4]);
        let at = u32::try_from(file.len()).unwrap();
        file[4..8].copy_from_slice(&at.to_le_bytes());
        file.extend(directory);
        file
    }

    /// Writes the raster as an Esri ASCII grid.
    pub(crate) fn text(&self) -> String {
        let (x, y) = (self.corner.0, self.corner.1 - self.cell * self.n_rows as f64);
        let mut text = format!(
            "ncols {}\nnrows {}\nxllcorner {x}\nyllcorner {y}\ncellsize {}\n",
            self.n_cols, self.n_rows, self.cell
        );
        if let Some(nodata) = self.nodata {
            text += &format!("NODATA_value {nodata}\n");
        }
        for row in self.values.chunks(self.n_cols) {
            text += &row.iter().map(f64::to_string).collect::<Vec<_>>().join(" ");
            text += "\n";
        }
        text
    }
}
