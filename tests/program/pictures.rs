//! One picture of each kind is what it was, but for one step of a channel.
//!
//! On a difference `out/pictures` holds what was expected, what was made, and where they differ, side by side.
//! `scripts/pictures` makes the pictures in `tests/pictures` anew.

use std::path::{Path, PathBuf};

use image::{Rgb, RgbImage};

use crate::program::{Folder, run_in};

/// A small scene for each kind of picture: the name of the picture, and the command without `--width` and `-o`.
const PICTURES: [(&str, &str); 14] = [
    ("map", "map itu:urban --size 200 --seed 1 --uav 100,100,60"),
    ("margin", "map itu:urban --size 200 --seed 1 --uav 100,100,60 --layers margin"),
    ("count", "map itu:urban --size 200 --seed 1 --uav 60,60,60 --uav 150,140,80 --layers count"),
    ("zones", "zones itu:urban --size 200 --seed 1"),
    ("city", "city itu:urban --size 200 --seed 1"),
    ("link", "link itu:urban --size 200 --seed 1 --uav 100,100,60 --rx 165,182"),
    ("track", "track itu:urban --size 200 --seed 1 --uav 100,100,60 --track track.csv"),
    ("height-curve", "map itu:urban --size 200 --seed 1 --uav 100,100,60 --height-curve"),
    ("plos", "plos itu:urban --method itu,alhourani2014,mohammed2023 --theta 10:80:10"),
    ("azimuth", "plos itu:urban --users street,crossroad --theta 15:75:30 --phi 0:90:30"),
    ("place", "place itu:urban --size 200 --seed 1 --step 20 --height 60"),
    ("sample", "sample itu:urban --size 200 --zones street:4,rooftop:4 --height 60:120:30 --cities 3"),
    ("compare", "compare itu:urban --size 200 --seed 1 --uav 60,60,60 --uav 150,140,80"),
    ("stress", "stress --scenes 1"),
];

fn golden(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/pictures").join(name).with_extension("png")
}

/// The picture that a command makes, in a folder of its own.
fn made(name: &str, command: &str) -> Vec<u8> {
    let folder = Folder::new();
    std::fs::write(folder.join("track.csv"), "x,y\n20,20\n20,180\n180,180\n").unwrap();
    let mut words: Vec<&str> = command.split(' ').collect();
    // A height curve names its own file.
    if words.last() != Some(&"--height-curve") {
        words.push("-o");
    }
    words.extend(["made.png", "--width", "500"]);
    run_in(folder.path(), &words).done();
    std::fs::read(folder.join("made.png")).unwrap_or_else(|e| panic!("{name}: {e}"))
}

fn pixels(png: &[u8]) -> RgbImage {
    let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().expect("a PNG");
    let mut bytes = vec![0; reader.output_buffer_size().expect("a size")];
    let info = reader.next_frame(&mut bytes).expect("pixels");
    assert_eq!((info.color_type, info.bit_depth), (png::ColorType::Rgb, png::BitDepth::Eight));
    bytes.truncate(info.buffer_size());
    RgbImage::from_raw(info.width, info.height, bytes).expect("pixels")
}

/// Pixels of which a channel differs by more than a step; all of them if the sizes differ.
fn n_different(a: &RgbImage, b: &RgbImage) -> usize {
    if a.dimensions() != b.dimensions() {
        return a.pixels().len().max(b.pixels().len());
    }
    a.pixels().zip(b.pixels()).filter(|(a, b)| differ(a, b)).count()
}

fn differ(a: &Rgb<u8>, b: &Rgb<u8>) -> bool {
    a.0.iter().zip(b.0).any(|(a, b)| a.abs_diff(b) > 1)
}

/// Both pictures and, in black, where they differ, side by side.
fn side_by_side(expected: &RgbImage, found: &RgbImage) -> RgbImage {
    let (width, height) = (expected.width().max(found.width()), expected.height().max(found.height()));
    let white = Rgb([255; 3]);
    RgbImage::from_fn(3 * width, height, |x, y| {
        let pixel = |image: &RgbImage| image.get_pixel_checked(x % width, y).copied().unwrap_or(white);
        match x / width {
            0 => pixel(expected),
            1 => pixel(found),
            _ if differ(&pixel(expected), &pixel(found)) => Rgb([0; 3]),
            _ => white,
        }
    })
}

fn write_png(path: &Path, image: &RgbImage) {
    std::fs::create_dir_all(path.parent().expect("a folder")).unwrap();
    let mut encoder = png::Encoder::new(std::fs::File::create(path).unwrap(), image.width(), image.height());
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(image.as_raw()).unwrap();
}

#[test]
fn every_kind_of_picture_is_what_it_was() {
    let mut changed = Vec::new();
    for (name, command) in PICTURES {
        let made = made(name, command);
        let is_renewed = std::env::var_os("SKYSHED_WRITE_PICTURES").is_some();
        let n = std::fs::read(golden(name)).map_or(1, |expected| n_different(&pixels(&expected), &pixels(&made)));
        match (n, is_renewed) {
            (0, _) => {}
            (_, true) => std::fs::write(golden(name), &made).unwrap(),
            (_, false) => {
                let told = Path::new(env!("CARGO_MANIFEST_DIR")).join("out/pictures").join(name).with_extension("png");
                let expected = pixels(&std::fs::read(golden(name)).unwrap_or_else(|e| panic!("{name}: {e}")));
                write_png(&told, &side_by_side(&expected, &pixels(&made)));
                changed.push(format!("{name}: {n} pixels, see {}", told.display()));
            }
        }
    }
    assert!(changed.is_empty(), "{}", changed.join("\n"));
}
