//! PDF files: one page with images at the back and vectors in front.
//!
//! The furniture of a sheet is SVG text, which `usvg` turns into paths. Letters become outlines, so
//! that no viewer needs the font. Only elements that sheets draw are supported: opaque groups with
//! a transform, paths in flat colors, lines with dashes. A file holds no time and nothing of the
//! machine.
//!
//! # References
//! ISO 32000-1:2008, sections 8.4 (state), 8.5 (paths), 8.9 (images).

use std::collections::BTreeMap;
use std::io::Write;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use image::RgbaImage;
use pdf_writer::types::{LineCapStyle, LineJoinStyle};
use pdf_writer::{Content, Filter, Finish, Name, Pdf, Rect, Ref, TextStr};
use resvg::tiny_skia::{PathSegment, Point, Transform};
use resvg::usvg;

use super::colors;
use super::paint::narrow;

/// Points of PDF per inch.
const POINTS: f64 = 72.0;

/// Encodes a page of images, each with the place of its top left corner \[px\], and a tree of paths
/// over them.
///
/// `size` is that of the layout \[px\], `inches` that on paper. `provenance` goes into the document
/// information.
///
/// # Errors
/// A paint that is no flat color.
pub(crate) fn encode(
    [size, inches]: [[f64; 2]; 2],
    images: &[(u32, u32, RgbaImage)],
    tree: &usvg::Tree,
    provenance: &[(String, String)],
) -> Result<Vec<u8>, String> {
    let mut ids = (1..).map(Ref::new);
    let mut next = || ids.next().unwrap_or(Ref::new(i32::MAX));
    let (catalog, pages, page_id, contents, info) = (next(), next(), next(), next(), next());
    let [width, height] = inches.map(|inches| narrow(POINTS * inches));
    let per_px = narrow(POINTS * inches[0] / size[0]);
    let mut pdf = Pdf::new();
    let mut content = Content::new();
    // Pixels count from the top, points from the bottom.
    content.transform([per_px, 0.0, 0.0, -per_px, 0.0, height]);
    let mut image_ids = Vec::new();
    for (k, (x, y, image)) in images.iter().enumerate() {
        let id = next();
        image_ids.push((format!("I{k}"), id));
        add_image(&mut pdf, id, image)?;
        let [w, h] = [image.width(), image.height()].map(|n| n as f32);
        content.save_state();
        content.transform([w, 0.0, 0.0, -h, *x as f32, *y as f32 + h]);
        content.x_object(Name(image_ids[k].0.as_bytes()));
        content.restore_state();
    }
    let mut painter = Painter { content, opacities: BTreeMap::new() };
    painter.group(tree.root())?;
    let Painter { content, opacities } = painter;

    pdf.catalog(catalog).pages(pages);
    pdf.pages(pages).kids([page_id]).count(1);
    let states: Vec<(String, Ref)> = opacities.keys().map(|percent| (state_name(*percent), next())).collect();
    let mut written = pdf.page(page_id);
    written.parent(pages).media_box(Rect::new(0.0, 0.0, width, height)).contents(contents);
    let mut resources = written.resources();
    resources.x_objects().pairs(image_ids.iter().map(|(name, id)| (Name(name.as_bytes()), id)));
    resources.ext_g_states().pairs(states.iter().map(|(name, id)| (Name(name.as_bytes()), id)));
    resources.finish();
    written.finish();
    for ((_, id), opacity) in states.iter().zip(opacities.values()) {
        pdf.ext_graphics(*id).stroking_alpha(*opacity).non_stroking_alpha(*opacity);
    }
    let bytes = deflated(&content.finish())?;
    pdf.stream(contents, &bytes).filter(Filter::FlateDecode);
    let mut facts = pdf.document_info(info);
    for (key, text) in provenance {
        match key.as_str() {
            "Software" => facts.producer(TextStr(text)),
            _ => facts.pair(Name(key.as_bytes()), TextStr(&ascii(text))),
        };
    }
    facts.finish();
    Ok(pdf.finish())
}

/// Escapes the characters of a JSON document beyond ASCII, as JSON allows. PDF then keeps it byte
/// by byte.
fn ascii(json: &str) -> String {
    let escaped = |c: char| c.encode_utf16(&mut [0; 2]).iter().map(|unit| format!("\\u{unit:04x}")).collect();
    json.chars().map(|c| if c.is_ascii() { c.to_string() } else { escaped(c) }).collect()
}

/// Returns the name of an opacity in percent.
fn state_name(percent: u8) -> String {
    format!("A{percent}")
}

fn add_image(pdf: &mut Pdf, id: Ref, image: &RgbaImage) -> Result<(), String> {
    let rgb: Vec<u8> = image.pixels().flat_map(|pixel| [pixel.0[0], pixel.0[1], pixel.0[2]]).collect();
    let bytes = deflated(&rgb)?;
    let side = |n: u32| i32::try_from(n).unwrap_or(i32::MAX);
    let mut object = pdf.image_xobject(id, &bytes);
    object.filter(Filter::FlateDecode);
    object.width(side(image.width())).height(side(image.height()));
    object.color_space().device_rgb();
    object.bits_per_component(8).interpolate(false);
    object.finish();
    Ok(())
}

fn deflated(bytes: &[u8]) -> Result<Vec<u8>, String> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes).and_then(|()| encoder.finish()).map_err(|e| format!("cannot encode PDF: {e}"))
}

/// Writer of paths, in drawing order.
struct Painter {
    content: Content,
    /// Opacities that occur, by percent.
    opacities: BTreeMap<u8, f32>,
}

impl Painter {
    fn group(&mut self, group: &usvg::Group) -> Result<(), String> {
        self.content.save_state();
        self.transform(group.transform());
        for node in group.children() {
            match node {
                usvg::Node::Group(group) => self.group(group)?,
                usvg::Node::Path(path) if path.is_visible() => self.path(path)?,
                // Letters as outlines.
                usvg::Node::Text(text) => self.group(text.flattened())?,
                usvg::Node::Path(_) | usvg::Node::Image(_) => {}
            }
        }
        self.content.restore_state();
        Ok(())
    }

    fn transform(&mut self, t: Transform) {
        if !t.is_identity() {
            self.content.transform([t.sx, t.ky, t.kx, t.sy, t.tx, t.ty]);
        }
    }

    fn path(&mut self, path: &usvg::Path) -> Result<(), String> {
        // A line has no inside, but some viewers would fill it.
        if let Some(fill) = path.fill().filter(|_| path.data().len() > 2) {
            let [r, g, b] = flat(fill.paint())?;
            self.content.save_state();
            self.opacity(fill.opacity());
            self.content.set_fill_rgb(r, g, b);
            self.segments(path);
            match fill.rule() {
                usvg::FillRule::NonZero => self.content.fill_nonzero(),
                usvg::FillRule::EvenOdd => self.content.fill_even_odd(),
            };
            self.content.restore_state();
        }
        if let Some(stroke) = path.stroke() {
            let [r, g, b] = flat(stroke.paint())?;
            let cap = match stroke.linecap() {
                usvg::LineCap::Butt => LineCapStyle::ButtCap,
                usvg::LineCap::Round => LineCapStyle::RoundCap,
                usvg::LineCap::Square => LineCapStyle::ProjectingSquareCap,
            };
            let join = match stroke.linejoin() {
                usvg::LineJoin::Round => LineJoinStyle::RoundJoin,
                usvg::LineJoin::Bevel => LineJoinStyle::BevelJoin,
                usvg::LineJoin::Miter | usvg::LineJoin::MiterClip => LineJoinStyle::MiterJoin,
            };
            self.content.save_state();
            self.opacity(stroke.opacity());
            self.content.set_stroke_rgb(r, g, b).set_line_width(stroke.width().get());
            self.content.set_line_cap(cap).set_line_join(join).set_miter_limit(stroke.miterlimit().get());
            if let Some(dashes) = stroke.dasharray() {
                self.content.set_dash_pattern(dashes.iter().copied(), stroke.dashoffset());
            }
            self.segments(path);
            self.content.stroke();
            self.content.restore_state();
        }
        Ok(())
    }

    fn opacity(&mut self, opacity: usvg::Opacity) {
        let opacity = opacity.get();
        if opacity < 1.0 {
            let percent = colors::byte(100.0 * f64::from(opacity));
            self.opacities.insert(percent, f32::from(percent) / 100.0);
            self.content.set_parameters(Name(state_name(percent).as_bytes()));
        }
    }

    fn segments(&mut self, path: &usvg::Path) {
        let mut at = Point::zero();
        for segment in path.data().segments() {
            match segment {
                PathSegment::MoveTo(p) => self.content.move_to(p.x, p.y),
                PathSegment::LineTo(p) => self.content.line_to(p.x, p.y),
                PathSegment::QuadTo(c, p) => {
                    // The cubic through the same points.
                    let toward = |end: f32, control: f32| end + 2.0 / 3.0 * (control - end);
                    let [x1, y1] = [toward(at.x, c.x), toward(at.y, c.y)];
                    self.content.cubic_to(x1, y1, toward(p.x, c.x), toward(p.y, c.y), p.x, p.y)
                }
                PathSegment::CubicTo(a, b, p) => self.content.cubic_to(a.x, a.y, b.x, b.y, p.x, p.y),
                PathSegment::Close => self.content.close_path(),
            };
            if let PathSegment::MoveTo(p)
            | PathSegment::LineTo(p)
            | PathSegment::QuadTo(_, p)
            | PathSegment::CubicTo(.., p) = segment
            {
                at = p;
            }
        }
    }
}

fn flat(paint: &usvg::Paint) -> Result<[f32; 3], String> {
    match paint {
        usvg::Paint::Color(color) => Ok([color.red, color.green, color.blue].map(|c| f32::from(c) / 255.0)),
        _ => Err("cannot encode PDF: a paint is no flat color".to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn opacities_are_kept_and_a_file_tells_where_it_comes_from_but_not_when() {
        let svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"100\" height=\"50\">\
                   <rect width=\"10\" height=\"10\" fill=\"#0072B2\" fill-opacity=\"0.2\"/></svg>";
        let tree = usvg::Tree::from_str(svg, &usvg::Options::default()).expect("the test text is valid SVG");
        let provenance = [("Software".into(), "skyshed 1".into()), ("skyshed".into(), "{\"θ\":1}".into())];
        let file = encode([[100.0, 50.0], [2.0, 1.0]], &[], &tree, &provenance).expect("flat colors");
        let text = String::from_utf8_lossy(&file);
        for words in ["/ca 0.2", "/Producer (skyshed 1)", "/skyshed", "u03b8\":1"] {
            assert!(text.contains(words), "{words}: {text}");
        }
        assert!(!text.contains("/CreationDate"));
    }
}
