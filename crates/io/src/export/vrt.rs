//! A virtual raster over tiles that were written one by one, for GDAL and other readers of its
//! format.

use std::fmt::Write as _;
use std::path::{Component, Path, PathBuf};

use skyshed_request::Layer;

use super::map::named_classes;
use super::map_result::NO_COUNT;
use crate::coverage::class;
use crate::crs::wkt_of;
use crate::error::{Error, Result, WriteFault};
use crate::formats::{class_table, xml_text};
use crate::raster::{CellWindow, GeoRef};

/// File of a mosaic, and the cells of the whole that it holds.
pub type MosaicTile = (PathBuf, CellWindow);

/// Bands of files that hold layers of all UAVs together: their names, and their common type and
/// nodata.
struct Bands {
    names: Vec<String>,
    data_type: &'static str,
    nodata: Option<u32>,
}

impl Bands {
    /// Returns the bands that GeoTIFF files have for a list of so many UAVs.
    fn of(layers: &[Layer], n_uavs: usize) -> Bands {
        let names = layers.iter().flat_map(|layer| match layer {
            Layer::Which => (0..n_uavs.div_ceil(32)).map(|word| format!("which.{word}")).collect(),
            layer => vec![layer.name().to_string()],
        });
        let is_any_number_a_set = layers.contains(&Layer::Which) && n_uavs >= 32;
        let (data_type, nodata) = match layers {
            [Layer::Union | Layer::All] => ("Byte", Some(u32::from(class::NODATA))),
            _ => ("UInt32", (!is_any_number_a_set).then_some(NO_COUNT)),
        };
        Bands { names: names.collect(), data_type, nodata }
    }
}

/// Returns the text of a virtual raster at `path` over tiles of a grid: GeoTIFF files with some
/// layers over a list of so many UAVs.
///
/// Names are relative to the folder of the mosaic, if the paths of that folder and of the tile have
/// a common root.
///
/// # Errors
/// E401 for a tile whose name is no text.
pub fn vrt(path: &Path, grid: &GeoRef, tiles: &[MosaicTile], (layers, n_uavs): (&[Layer], usize)) -> Result<String> {
    let bands = Bands::of(layers, n_uavs);
    let near = Near::of(path);
    let mut text = format!("<VRTDataset rasterXSize=\"{}\" rasterYSize=\"{}\">\n", grid.n_cols(), grid.n_rows());
    if let Some(wkt) = grid.crs().and_then(wkt_of) {
        let _ = writeln!(text, "  <SRS dataAxisToSRSAxisMapping=\"1,2\">{}</SRS>", xml_text(&wkt));
    }
    let (x, y, width, height) = (grid.x_min(), grid.y_max(), grid.cell_width(), grid.cell_height());
    let _ = writeln!(text, "  <GeoTransform>{x:?}, {width:?}, 0, {y:?}, 0, {:?}</GeoTransform>", -height);
    for (band, name) in (1..).zip(&bands.names) {
        let _ = writeln!(text, "  <VRTRasterBand dataType=\"{}\" band=\"{band}\">", bands.data_type);
        let _ = writeln!(text, "    <Description>{name}</Description>");
        if bands.data_type == "Byte" {
            text += "    <ColorInterp>Palette</ColorInterp>\n";
            text += &class_table(&named_classes());
        }
        if let Some(nodata) = bands.nodata {
            let _ = writeln!(text, "    <NoDataValue>{nodata}</NoDataValue>");
        }
        for (tile, window) in tiles {
            let (name, is_relative) = near.name_of(tile);
            let no_text = || WriteFault::Refused(format!("the name of {} is no text", tile.display()));
            let name = name.to_str().filter(|name| !name.contains(char::is_control));
            let name = xml_text(name.ok_or_else(|| Error::write(path.display(), no_text()))?);
            let is_relative = u8::from(is_relative);
            let CellWindow { row, col, n_rows, n_cols } = *window;
            let size = format!("xSize=\"{n_cols}\" ySize=\"{n_rows}\"");
            let _ = write!(
                text,
                "    <SimpleSource>\n      <SourceFilename relativeToVRT=\"{is_relative}\">{name}</SourceFilename>\n      \
                 <SourceBand>{band}</SourceBand>\n      <SourceProperties RasterXSize=\"{n_cols}\" RasterYSize=\"{n_rows}\" \
                 DataType=\"{}\" BlockXSize=\"512\" BlockYSize=\"512\"/>\n      <SrcRect xOff=\"0\" yOff=\"0\" {size}/>\n      \
                 <DstRect xOff=\"{col}\" yOff=\"{row}\" {size}/>\n    </SimpleSource>\n",
                bands.data_type
            );
        }
        text += "  </VRTRasterBand>\n";
    }
    text += "</VRTDataset>\n";
    Ok(text)
}

/// Folder that files are named from.
#[derive(Debug)]
pub struct Near(PathBuf);

impl Near {
    /// Returns the folder of a file that is still to be made.
    pub fn of(path: &Path) -> Near {
        Near(folder_of(path))
    }

    /// Returns the name of an existing file as seen from the folder, and `true` if that name is
    /// relative.
    pub fn name_of(&self, file: &Path) -> (PathBuf, bool) {
        let (folder, name) = (folder_of(file), file.file_name().unwrap_or_default());
        let (from, to): (Vec<_>, Vec<_>) = (self.0.components().collect(), folder.components().collect());
        let n_common = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
        if n_common == 0 {
            return (folder.join(name), false);
        }
        let up = std::iter::repeat_n(Component::ParentDir, from.len() - n_common);
        (up.chain(to[n_common..].iter().copied()).collect::<PathBuf>().join(name), true)
    }
}

/// Returns the canonical folder of a file.
fn folder_of(path: &Path) -> PathBuf {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    std::fs::canonicalize(folder).unwrap_or_else(|_| folder.to_path_buf())
}
