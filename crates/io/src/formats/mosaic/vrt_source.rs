//! One source of a virtual raster's band: the file, the part of it, its place and its rule.

use std::path::{Path, PathBuf};

use roxmltree::Node;

use super::covered::covered_area;
use super::numbers::Rule;
use super::tiles::{Header, Tile};
use super::vrt_xml::Vrt;
use crate::error::{Cause, Error, ReadFault, Result};
use crate::formats::sample::Sample;
use crate::formats::xml::{attribute, child, text_of};
use crate::raster::CellWindow;

/// Largest distance of a rectangle from whole cells \[cells\].
const MAX_FRACTION: f64 = 1e-6;
/// Elements of a `ComplexSource` that compute new numbers, which is not supported.
const COMPUTING: [&str; 8] =
    ["LUT", "ColorTableComponent", "Exponent", "SrcMin", "SrcMax", "DstMin", "DstMax", "Clamp"];

/// A source as the XML describes it.
pub(super) struct Source {
    pub(super) path: PathBuf,
    /// Band, counted from 0.
    pub(super) band: usize,
    pub(super) rule: Rule,
    /// Declared rows and columns of the file.
    size: Option<(f64, f64)>,
    /// Rectangles in the file and in the virtual raster: first column and row, columns and rows.
    from: Option<[f64; 4]>,
    to: Option<[f64; 4]>,
}

/// A source in its place.
pub(super) struct Place {
    /// Row and column of the virtual raster at which the file would begin.
    pub(super) origin: (i64, i64),
    pub(super) area: CellWindow,
}

impl Source {
    /// Reads the sources of a band, the lowest first.
    pub(super) fn all_of(vrt: Vrt<'_>, band: Node<'_, '_>, numbers: Sample) -> Result<Vec<Source>> {
        let mut sources = Vec::new();
        for node in band.children().filter(Node::is_element) {
            let name = node.tag_name().name();
            if name.eq_ignore_ascii_case("SimpleSource") {
                sources.push(Source::read(vrt, node, Rule::Copied(numbers))?);
            } else if name.eq_ignore_ascii_case("ComplexSource") {
                sources.push(Source::read(vrt, node, scaled(vrt, node, numbers)?)?);
            } else if name.to_ascii_lowercase().ends_with("source") {
                return Err(vrt.unsupported(node, format!("`{name}`")));
            }
        }
        Ok(sources)
    }

    fn read(vrt: Vrt<'_>, node: Node<'_, '_>, rule: Rule) -> Result<Source> {
        let name = node.tag_name().name();
        let file = child(node, "SourceFilename").filter(|file| !text_of(*file).is_empty());
        let Some(file) = file else {
            return Err(vrt.malformed(node, format!("`{name}` has no `SourceFilename`, wanted a file")));
        };
        if let Some(options) = child(node, "OpenOptions") {
            return Err(vrt.unsupported(options, "`OpenOptions`"));
        }
        let is_relative = attribute(file, "relativeToVRT").is_some_and(|text| text.trim() == "1");
        let folder = vrt.path.parent().filter(|_| is_relative);
        let path = folder.map_or_else(|| PathBuf::from(text_of(file)), |folder| folder.join(text_of(file)));
        let band = match child(node, "SourceBand").map(|node| (node, text_of(node))) {
            None => 1,
            Some((node, text)) => text.parse::<usize>().ok().filter(|band| *band > 0).ok_or_else(|| {
                let what = format!("`SourceBand` is `{text}`, wanted the number of a band");
                vrt.error(node, ReadFault::Unsupported(what)).because(Cause::ForGdal)
            })?,
        };
        let rectangle = |name: &str| -> Result<_> {
            let Some(node) = child(node, name) else { return Ok(None) };
            let value = |name: &str| vrt.number(node, name, attribute(node, name).unwrap_or_default());
            Ok(Some([value("xOff")?, value("yOff")?, value("xSize")?, value("ySize")?]))
        };
        let size = match child(node, "SourceProperties") {
            None => None,
            Some(node) => {
                let side = |name: &str| attribute(node, name).map(|text| vrt.number(node, name, text)).transpose();
                side("RasterYSize")?.zip(side("RasterXSize")?)
            }
        };
        Ok(Source { path, band: band - 1, rule, size, from: rectangle("SrcRect")?, to: rectangle("DstRect")? })
    }

    /// Checks the declared properties of the file.
    pub(super) fn check(&self, vrt: &Path, header: &Header) -> Result<()> {
        let Tile { input, n_rows, n_cols, .. } = &header.tile;
        let refuse = |said: String, found: String| {
            let what = format!("it says that `{input}` {said}, found {found}");
            Err(Error::malformed(vrt.display(), what).because(Cause::StaleVrt))
        };
        let is = |said: f64, found: usize| (said - found as f64).abs() < 0.5;
        match self.size {
            Some((rows, cols)) if !is(rows, *n_rows) || !is(cols, *n_cols) => {
                return refuse(format!("has {cols} columns x {rows} rows"), format!("{n_cols} x {n_rows}"));
            }
            _ => {}
        }
        if self.band >= header.n_bands {
            return refuse(format!("has a band {}", self.band + 1), format!("{} of them", header.n_bands));
        }
        Ok(())
    }

    /// Returns the place of the tile in a raster of `n_rows` × `n_cols`; `None` if nothing of it
    /// lies there.
    pub(super) fn place(&self, vrt: &Path, tile: &Tile, (n_rows, n_cols): (usize, usize)) -> Result<Option<Place>> {
        let from = self.from.unwrap_or([0.0, 0.0, tile.n_cols as f64, tile.n_rows as f64]);
        let to = self.to.unwrap_or([0.0, 0.0, n_cols as f64, n_rows as f64]);
        let refuse = |found: String| {
            let what = format!("`{}` {found}", self.path.display());
            Err(Error::unsupported(vrt.display(), what).because(Cause::ForGdal))
        };
        let is_whole = |number: &f64| (number - number.round()).abs() <= MAX_FRACTION;
        // Numbers beyond this lie outside of any raster; below it, whole numbers are exact.
        let is_sane = |number: &f64| number.abs() <= 4_294_967_296.0;
        let [_, _, from_cols, from_rows] = from;
        let [_, _, to_cols, to_rows] = to;
        if (from_cols - to_cols).abs() > MAX_FRACTION || (from_rows - to_rows).abs() > MAX_FRACTION {
            let found = format!("of {from_cols} x {from_rows} cells is resampled to {to_cols} x {to_rows}");
            return refuse(format!("{found}, wanted as many"));
        }
        if !from.iter().chain(&to).all(|number| is_sane(number) && is_whole(number)) {
            return refuse(format!("goes from {from:?} to {to:?} (column, row, columns, rows), wanted whole cells"));
        }
        if to_cols < 0.5 || to_rows < 0.5 {
            return Ok(None);
        }
        #[expect(clippy::cast_possible_truncation, reason = "at most 2^32")]
        let [from, to] = [from, to].map(|rectangle| rectangle.map(|number| number.round() as i64));
        let origin = (to[1] - from[1], to[0] - from[0]);
        let bounds = [to[1], to[1] + to[3], to[0], to[0] + to[2]];
        let area = covered_area((n_rows, n_cols), (tile.n_rows, tile.n_cols), origin, Some(bounds));
        Ok(area.map(|area| Place { origin, area }))
    }
}

/// Reads the rule of a `ComplexSource`.
fn scaled(vrt: Vrt<'_>, node: Node<'_, '_>, to: Sample) -> Result<Rule> {
    let computes = |node: &Node<'_, '_>| COMPUTING.iter().any(|name| node.tag_name().name().eq_ignore_ascii_case(name));
    if let Some(node) = node.children().find(computes) {
        return Err(vrt.unsupported(node, format!("`{}`", node.tag_name().name())));
    }
    let nodata = match child(node, "NODATA") {
        Some(node) if text_of(node).eq_ignore_ascii_case("nan") => Some(f64::NAN),
        _ => vrt.child_number(node, "NODATA")?,
    };
    let uses_mask = child(node, "UseMaskBand").is_some_and(|node| matches!(text_of(node), "true" | "1"));
    let ratio = vrt.child_number(node, "ScaleRatio")?.unwrap_or(1.0);
    let offset = vrt.child_number(node, "ScaleOffset")?.unwrap_or(0.0);
    Ok(Rule::Scaled { to, ratio, offset, nodata, uses_mask })
}
