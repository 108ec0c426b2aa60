//! A sheet: raster images at the back, vector furniture in front, written as PNG, SVG or PDF.
//!
//! All furniture is SVG text first, whatever the output, so that a test can read what a picture says.

use std::fmt::Write as _;

use image::RgbaImage;
use resvg::{tiny_skia, usvg};

use super::colors::{self, Rgb};
use super::lettering::{self, Anchor, Type, Weight};
use super::paint::narrow;
use super::pdf::{self, PdfPage};
use super::picture_form::{PictureForm, PictureFormat};
use super::png;
use super::resized::resized;

/// A drawn picture, which can be written in any format.
#[derive(Debug)]
pub struct Sheet {
    /// Width \[px\].
    pub(crate) width: f64,
    /// Height \[px\].
    pub(crate) height: f64,
    /// Images with the place of their top left corner \[px\].
    pub(crate) images: Vec<(u32, u32, RgbaImage)>,
    /// What is drawn over them.
    pub(crate) furniture: Drawing,
}

impl Sheet {
    /// Writes the picture as a file that says where it comes from, by keyword.
    ///
    /// # Errors
    /// A keyword that PNG does not allow (1 to 79 printable characters of Latin-1), or more pixels than memory holds.
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
        let page = PdfPage {
            size,
            inches: size.map(|length| form.inches(size[0], length)),
            images: &self.images,
            tree: &self.tree()?,
        };
        pdf::encode(&page, provenance)
    }

    /// Width and height of the layout in whole pixels.
    fn size(&self) -> [u32; 2] {
        [pixels(self.width), pixels(self.height)]
    }

    /// The furniture as paths.
    fn tree(&self) -> Result<usvg::Tree, String> {
        let options = usvg::Options { fontdb: lettering::fonts(), ..usvg::Options::default() };
        usvg::Tree::from_str(&self.svg_around(&PictureForm::PNG, ""), &options).map_err(|e| format!("cannot draw: {e}"))
    }

    /// One SVG document, its images embedded.
    fn to_svg(&self, form: &PictureForm, provenance: &[(String, String)]) -> Result<String, String> {
        let mut back = String::new();
        if !provenance.is_empty() {
            let lines: Vec<String> = provenance.iter().map(|(k, v)| lettering::escape(&format!("{k}: {v}"))).collect();
            let _ = writeln!(back, "<metadata>{}</metadata>", lines.join("\n"));
        }
        let _ = writeln!(back, "<rect width=\"100%\" height=\"100%\" fill=\"#FFFFFF\"/>");
        for (x, y, image) in &self.images {
            let data = base64(&png::encode_picture(image, form.dpi(), &[])?);
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
        let _ = writeln!(
            self.svg,
            "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" {attributes}/>",
            px(x),
            px(y),
            px(w),
            px(h)
        );
    }

    /// Draws a straight line.
    pub(crate) fn line(&mut self, from: [f64; 2], to: [f64; 2], attributes: &str) {
        let _ = writeln!(
            self.svg,
            "<line x1=\"{}\" y1=\"{}\" x2=\"{}\" y2=\"{}\" {attributes}/>",
            px(from[0]),
            px(from[1]),
            px(to[0]),
            px(to[1])
        );
    }

    /// Draws a circle.
    pub(crate) fn circle(&mut self, [x, y]: [f64; 2], radius: f64, attributes: &str) {
        let _ = writeln!(self.svg, "<circle cx=\"{}\" cy=\"{}\" r=\"{}\" {attributes}/>", px(x), px(y), px(radius));
    }

    /// Draws a closed polygon.
    pub(crate) fn polygon(&mut self, points: &[[f64; 2]], attributes: &str) {
        let points: Vec<String> = points.iter().map(|p| format!("{},{}", px(p[0]), px(p[1]))).collect();
        let _ = writeln!(self.svg, "<polygon points=\"{}\" {attributes}/>", points.join(" "));
    }

    /// Draws an open path through points.
    pub(crate) fn polyline(&mut self, points: &[[f64; 2]], attributes: &str) {
        let points: Vec<String> = points.iter().map(|p| format!("{},{}", px(p[0]), px(p[1]))).collect();
        let _ = writeln!(self.svg, "<polyline points=\"{}\" fill=\"none\" {attributes}/>", points.join(" "));
    }

    /// Appends another drawing, moved by (`dx`, `dy`).
    pub(crate) fn place(&mut self, drawing: &Self, dx: f64, dy: f64) {
        let _ = writeln!(self.svg, "<g transform=\"translate({} {})\">\n{}</g>", px(dx), px(dy), drawing.svg);
    }

    /// Fills a box with a gradient from left to right through `colors` at equal steps, as slices without seams.
    pub(crate) fn gradient(&mut self, [x, y, w, h]: [f64; 4], colors: &[Rgb]) {
        let step = w / colors.len() as f64;
        for (i, &color) in colors.iter().enumerate() {
            let left = x + step * i as f64;
            let overlap = if i + 1 < colors.len() { 1.0 } else { 0.0 };
            self.rect([left, y, step + overlap, h], &format!("fill=\"{}\"", colors::hex(color)));
        }
    }
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

/// Encodes bytes in base 64 (RFC 4648).
pub(crate) fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let word = (0..3).fold(0_usize, |word, k| word << 8 | usize::from(chunk.get(k).copied().unwrap_or(0)));
        for k in 0..4 {
            let digit = char::from(DIGITS[word >> (18 - 6 * k) & 63]);
            out.push(if k <= chunk.len() { digit } else { '=' });
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base_64_matches_the_published_examples() {
        for (plain, coded) in [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")] {
            assert_eq!(base64(plain.as_bytes()), coded);
        }
    }

    #[test]
    fn a_sheet_puts_its_images_under_its_furniture() {
        let mut furniture = Drawing::default();
        furniture.rect([4.0, 0.0, 4.0, 8.0], "fill=\"#0072B2\"");
        let red = RgbaImage::from_pixel(8, 8, image::Rgba([200, 0, 0, 255]));
        let sheet = Sheet { width: 10.0, height: 8.0, images: vec![(0, 0, red)], furniture };
        let file = sheet.write(&PictureForm::PNG, &[]).expect("the sheet is small");
        let image = crate::png::read_png(&file).to_rgb8();
        assert_eq!(image.dimensions(), (10, 8));
        assert_eq!(image.get_pixel(1, 3).0, [200, 0, 0]);
        assert_eq!(image.get_pixel(5, 3).0, [0x00, 0x72, 0xB2]);
        assert_eq!(image.get_pixel(9, 3).0, [255; 3]);
        let svg = sheet.to_svg(&PictureForm::PNG, &[]).expect("the sheet is small");
        assert!(svg.contains("data:image/png;base64,iVBOR"));
        // Twice as wide, everything is twice as large.
        let form = PictureForm { width_px: Some(20), dpi: Some(50), ..PictureForm::PNG };
        let image = crate::png::read_png(&sheet.write(&form, &[]).expect("the sheet is small"));
        assert_eq!((image.width(), image.height()), (20, 16));
        assert_eq!(image.to_rgb8().get_pixel(3, 9).0, [200, 0, 0]);
        assert_eq!(image.to_rgb8().get_pixel(13, 9).0, [0x00, 0x72, 0xB2]);
    }

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
