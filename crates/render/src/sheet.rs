//! A sheet: raster images at the back, vector furniture in front, written as PNG, SVG or PDF.
//!
//! All furniture is SVG text first, whatever the output, so that a test can read the words of a
//! picture.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use std::fmt::Write as _;

use image::RgbaImage;
use resvg::{tiny_skia, usvg};

use super::colors::{self, Rgb};
use super::lettering::{self, Anchor, Type, Weight};
use super::paint::narrow;
use super::pdf;
use super::png;
use super::resized::resized;

/// A format of pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureFormat {
    /// Pixels.
    Png,
    /// Words and marks as vectors, maps as embedded pixels.
    Svg,
    /// SVG's content on one page; letters are outlines, so that no viewer needs the font.
    Pdf,
}

/// Form in which a picture is written. It is laid out once, and scaled as a whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PictureForm {
    /// The format.
    pub format: PictureFormat,
    /// Width \[px\], above 0; the height follows. `None`: the width of the layout.
    pub width_px: Option<u32>,
    /// Pixels per inch, above 0; with the width it gives the size on paper. `None`: 200.
    pub dpi: Option<u32>,
}

/// At 200 dpi a large map is printed about 20 cm wide.
const DPI: u32 = 200;
const MM_PER_INCH: f64 = 25.4;

impl PictureForm {
    /// PNG at the width of the layout.
    pub const PNG: PictureForm = PictureForm { format: PictureFormat::Png, width_px: None, dpi: None };

    /// Returns the factor from a layout `width` \[px\] wide to the requested width.
    pub(crate) fn scale(&self, width: u32) -> f64 {
        f64::from(self.width_px.unwrap_or(width)) / f64::from(width)
    }

    /// Returns the pixels per inch.
    pub(crate) fn dpi(&self) -> u32 {
        self.dpi.unwrap_or(DPI)
    }

    /// Returns the inches on paper of `length` \[px\] in a layout `width` \[px\] wide.
    pub(crate) fn inches(&self, width: u32, length: u32) -> f64 {
        f64::from(length) * self.scale(width) / f64::from(self.dpi())
    }

    /// Returns width and height for an SVG document: those of the layout, or the size on paper if
    /// the form sets one.
    pub(crate) fn svg_size(&self, width: u32, height: u32) -> [String; 2] {
        let on_paper = self.width_px.is_some() || self.dpi.is_some();
        [width, height].map(|length| match on_paper {
            true => format!("{:.3}mm", MM_PER_INCH * self.inches(width, length)),
            false => length.to_string(),
        })
    }
}

/// A drawn picture, which can be written in any format.
#[derive(Debug)]
pub struct Sheet {
    /// Width \[px\].
    pub(crate) width: f64,
    /// Height \[px\].
    pub(crate) height: f64,
    /// Images with the places of their top left corners \[px\].
    pub(crate) images: Vec<(u32, u32, RgbaImage)>,
    /// Furniture drawn over the images.
    pub(crate) furniture: Drawing,
}

impl Sheet {
    /// Writes the picture as a file that holds its provenance, by keyword.
    ///
    /// # Errors
    /// A keyword that PNG does not allow (1 to 79 printable characters of Latin-1), or more pixels
    /// than memory holds.
    pub fn write(&self, form: &PictureForm, provenance: &[(String, String)]) -> Result<Vec<u8>, String> {
        match form.format {
            PictureFormat::Png => self.to_png(form, provenance),
            PictureFormat::Svg => self.to_svg(form, provenance).map(String::into_bytes),
            PictureFormat::Pdf => self.to_pdf(form, provenance),
        }
    }

    fn to_png(&self, form: &PictureForm, provenance: &[(String, String)]) -> Result<Vec<u8>, String> {
        let [width, height] = self.size();
        let scale = form.scale(width);
        let [width, height] = [width, height].map(|length| pixels((f64::from(length) * scale).round()));
        let mut canvas = RgbaImage::from_pixel(width, height, image::Rgba([255; 4]));
        for (x, y, image) in &self.images {
            // Both ends are rounded, so that frames stay on the borders of maps.
            let ends = |from: u32, length: u32| {
                [from, from + length].map(|at| pixels((f64::from(at) * scale).round().max(1.0)))
            };
            let ([left, right], [top, bottom]) = (ends(*x, image.width()), ends(*y, image.height()));
            let image = resized(image, (right - left).max(1), (bottom - top).max(1));
            let [left, top] = [(x, left), (y, top)].map(|(from, at)| if *from == 0 { 0 } else { i64::from(at) });
            image::imageops::replace(&mut canvas, &image, left, top);
        }
        let mut pixmap = tiny_skia::PixmapMut::from_bytes(canvas.as_mut(), width, height)
            .ok_or_else(|| format!("cannot draw a picture of {width} × {height} pixels"))?;
        let scale = narrow(scale);
        resvg::render(&self.tree()?, tiny_skia::Transform::from_scale(scale, scale), &mut pixmap);
        png::encode_picture(&canvas, form.dpi(), provenance)
    }

    fn to_pdf(&self, form: &PictureForm, provenance: &[(String, String)]) -> Result<Vec<u8>, String> {
        let size = self.size();
        let inches = size.map(|length| form.inches(size[0], length));
        pdf::encode([size.map(f64::from), inches], &self.images, &self.tree()?, provenance)
    }

    /// Returns width and height of the layout in whole pixels.
    fn size(&self) -> [u32; 2] {
        [pixels(self.width), pixels(self.height)]
    }

    /// Returns the furniture as paths.
    fn tree(&self) -> Result<usvg::Tree, String> {
        let options = usvg::Options { fontdb: lettering::fonts(), ..usvg::Options::default() };
        usvg::Tree::from_str(&self.svg_around(&PictureForm::PNG, ""), &options).map_err(|e| format!("cannot draw: {e}"))
    }

    /// Writes one SVG document with its images embedded.
    fn to_svg(&self, form: &PictureForm, provenance: &[(String, String)]) -> Result<String, String> {
        let mut back = String::new();
        if !provenance.is_empty() {
            let lines: Vec<String> = provenance.iter().map(|(k, v)| lettering::escape(&format!("{k}: {v}"))).collect();
            let _ = writeln!(back, "<metadata>{}</metadata>", lines.join("\n"));
        }
        let _ = writeln!(back, "<rect width=\"100%\" height=\"100%\" fill=\"#FFFFFF\"/>");
        for (x, y, image) in &self.images {
            let data = STANDARD.encode(png::encode_picture(image, form.dpi(), &[])?);
            let (w, h) = image.dimensions();
            let _ = writeln!(
                back,
                "<image x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" style=\"image-rendering:pixelated\" \
                 href=\"data:image/png;base64,{data}\"/>"
            );
        }
        Ok(self.svg_around(form, &back))
    }

    fn svg_around(&self, form: &PictureForm, back: &str) -> String {
        let [w, h] = self.size();
        let [width, height] = form.svg_size(w, h);
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {w} {h}\" \
             font-family=\"{}\">\n{back}{}</svg>\n",
            lettering::FAMILY,
            self.furniture.svg
        )
    }
}

/// Rounds a length up to whole pixels, at least one.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the range of u32 first")]
pub(crate) fn pixels(length: f64) -> u32 {
    length.ceil().clamp(1.0, f64::from(u32::MAX)) as u32
}

/// SVG elements in drawing order.
#[derive(Clone, Debug, Default)]
pub(crate) struct Drawing {
    pub(crate) svg: String,
}

impl Drawing {
    /// Sets a text with its baseline at `y`.
    pub(crate) fn text(&mut self, x: f64, y: f64, style: Type, text: &str) {
        self.set(&format!("x=\"{}\" y=\"{}\"", px(x), px(y)), style, text);
    }

    /// Sets a text that reads upward, its baseline at `x`.
    pub(crate) fn text_upward(&mut self, x: f64, y: f64, style: Type, text: &str) {
        self.set(&format!("transform=\"matrix(0 -1 1 0 {} {})\"", px(x), px(y)), style, text);
    }

    fn set(&mut self, place: &str, style: Type, text: &str) {
        if text.is_empty() {
            return;
        }
        let anchor = match style.anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let weight = if style.weight == Weight::SemiBold { 600 } else { 400 };
        let _ = writeln!(
            self.svg,
            "<text {place} font-size=\"{}\" font-weight=\"{weight}\" fill=\"{}\" text-anchor=\"{anchor}\" \
             xml:space=\"preserve\">{}</text>",
            px(style.size),
            style.color,
            subscripted(text, style.size)
        );
    }

    /// Draws a box; `attributes` are SVG's, such as `fill="none" stroke="#000000"`.
    pub(crate) fn rect(&mut self, [x, y, w, h]: [f64; 4], attributes: &str) {
        let [x, y, w, h] = [x, y, w, h].map(px);
        let _ = writeln!(self.svg, "<rect x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" {attributes}/>");
    }

    /// Draws a straight line.
    pub(crate) fn line(&mut self, from: [f64; 2], to: [f64; 2], attributes: &str) {
        let [[x1, y1], [x2, y2]] = [from, to].map(|end| end.map(px));
        let _ = writeln!(self.svg, "<line x1=\"{x1}\" y1=\"{y1}\" x2=\"{x2}\" y2=\"{y2}\" {attributes}/>");
    }

    /// Draws a circle.
    pub(crate) fn circle(&mut self, [x, y]: [f64; 2], radius: f64, attributes: &str) {
        let _ = writeln!(self.svg, "<circle cx=\"{}\" cy=\"{}\" r=\"{}\" {attributes}/>", px(x), px(y), px(radius));
    }

    /// Draws a closed polygon.
    pub(crate) fn polygon(&mut self, points: &[[f64; 2]], attributes: &str) {
        let _ = writeln!(self.svg, "<polygon points=\"{}\" {attributes}/>", path(points));
    }

    /// Draws an open path through points.
    pub(crate) fn polyline(&mut self, points: &[[f64; 2]], attributes: &str) {
        let _ = writeln!(self.svg, "<polyline points=\"{}\" fill=\"none\" {attributes}/>", path(points));
    }

    /// Appends another drawing at its place.
    pub(crate) fn add(&mut self, drawing: &Self) {
        self.svg.push_str(&drawing.svg);
    }

    /// Appends another drawing, moved by (`dx`, `dy`).
    pub(crate) fn place(&mut self, drawing: &Self, dx: f64, dy: f64) {
        let _ = writeln!(self.svg, "<g transform=\"translate({} {})\">\n{}</g>", px(dx), px(dy), drawing.svg);
    }

    /// Fills a box with a gradient from left to right through `colors` at equal steps, as slices
    /// without seams.
    pub(crate) fn gradient(&mut self, [x, y, w, h]: [f64; 4], colors: &[Rgb]) {
        let step = w / colors.len() as f64;
        for (i, &color) in colors.iter().enumerate() {
            let left = x + step * i as f64;
            let overlap = if i + 1 < colors.len() { 1.0 } else { 0.0 };
            self.rect([left, y, step + overlap, h], &colors::fill(color));
        }
    }
}

/// Writes the points of a path.
fn path(points: &[[f64; 2]]) -> String {
    points.iter().map(|[x, y]| format!("{},{}", px(*x), px(*y))).collect::<Vec<_>>().join(" ")
}

/// Escapes a text and sets the index of each `P_LoS` below the line.
fn subscripted(text: &str, size: f64) -> String {
    let (lower, small) = (px(0.2 * size), px(0.72 * size));
    let mut parts = text.split("P_LoS");
    let mut out = lettering::escape(parts.next().unwrap_or_default());
    for rest in parts {
        let rest = lettering::escape(rest);
        let _ = write!(
            out,
            "P<tspan dy=\"{lower}\" font-size=\"{small}\">LoS</tspan><tspan dy=\"-{lower}\">{rest}</tspan>"
        );
    }
    out
}

/// Writes a coordinate with at most two decimals.
pub(crate) fn px(value: f64) -> String {
    let text = format!("{value:.2}");
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_index_of_p_los_is_a_subscript() {
        let text = subscripted("a < b: P_LoS = 0.1", 20.0);
        assert_eq!(text, "a &lt; b: P<tspan dy=\"4\" font-size=\"14.4\">LoS</tspan><tspan dy=\"-4\"> = 0.1</tspan>");
    }

    #[test]
    fn coordinates_are_short() {
        assert_eq!((px(1.0).as_str(), px(0.126).as_str(), px(-3.5).as_str()), ("1", "0.13", "-3.5"));
    }
}
