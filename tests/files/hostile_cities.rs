//! Archives, CityGML and GeoParquet that are made to take time or memory: each is refused, or read, within a few seconds of one
//! processor and 300 MB.

use std::fmt::Write as _;
use std::fs;
use std::io::Write;

use flate2::Compression as Level;
use flate2::write::GzEncoder;
use parquet::basic::Compression;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

use crate::city_formats::{citygml, write_geoparquet};
use crate::program::Folder;
use crate::vector_files::{city, write_geojson};

/// Refuses a file, within 300 MB.
fn refused(folder: &Folder, name: &str, code: &str, words: &str) {
    let line = format!("info {name}");
    folder.refuses(&line, code, &[words]);
    let (_, peak) = folder.measured(&line);
    assert!(peak < 300_000_000, "{name}: {peak}");
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut packed = GzEncoder::new(Vec::new(), Level::best());
    packed.write_all(bytes).unwrap();
    packed.finish().unwrap()
}

fn zip(files: &[(&str, &[u8])]) -> Vec<u8> {
    let mut zip = ZipWriter::new(std::io::Cursor::new(Vec::new()));
    for (name, bytes) in files {
        zip.start_file(*name, SimpleFileOptions::default()).unwrap();
        zip.write_all(bytes).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

#[test]
fn archives_unpack_to_no_more_than_a_city() {
    let folder = Folder::new();
    let blanks = vec![b' '; 200 << 20];
    let bomb = gzip(&[b"{".as_slice(), &blanks].concat());
    fs::write(folder.join("a.geojson.gz"), &bomb).unwrap();
    fs::write(folder.join("b.zip"), zip(&[("a.geojson", &[b"{".as_slice(), &blanks].concat())])).unwrap();
    refused(&folder, "a.geojson.gz", "E502", "out of");
    refused(&folder, "b.zip", "E502", "out of");
    // Packed again and again.
    fs::write(folder.join("c.geojson.gz.gz"), gzip(&bomb)).unwrap();
    refused(&folder, "c.geojson.gz.gz", "E502", "out of");
    let mut deep = zip(&[("a.geojson", b"{}")]);
    for _ in 0..5 {
        deep = zip(&[("deeper.zip", &deep)]);
    }
    fs::write(folder.join("d.zip"), deep).unwrap();
    refused(&folder, "d.zip", "E302", "a ZIP archive");
    // Each of many archives in one holds much that packs well, as it is.
    let mut inner = ZipWriter::new(std::io::Cursor::new(Vec::new()));
    inner
        .start_file("a.geojson", SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored))
        .unwrap();
    inner.write_all(&blanks[..32 << 20]).unwrap();
    let inner = inner.finish().unwrap().into_inner();
    let names: Vec<String> = (0..20).map(|k| format!("{k}.zip")).collect();
    let inner: Vec<(&str, &[u8])> = names.iter().map(|name| (&**name, &*inner)).collect();
    fs::write(folder.join("e.zip"), zip(&inner)).unwrap();
    refused(&folder, "e.zip", "E502", "archives inside of it");
    // More files than any delivery.
    let names: Vec<String> = (0..20_001).map(|k| format!("{k}.txt")).collect();
    let many: Vec<(&str, &[u8])> = names.iter().map(|name| (&**name, &b""[..])).collect();
    fs::write(folder.join("f.zip"), zip(&many)).unwrap();
    refused(&folder, "f.zip", "E502", "20001 files");
    fs::write(folder.join("g.zip"), zip(&many[..5000])).unwrap();
    refused(&folder, "g.zip", "E308", "g.zip");
}

#[test]
fn names_in_archives_lead_nowhere_and_cut_archives_are_refused() {
    let (folder, city) = (Folder::new(), city());
    write_geojson(&folder.join("a.geojson"), &city);
    let bytes = folder.read("a.geojson");
    fs::create_dir(folder.join("in")).unwrap();
    fs::write(folder.join("in/a.zip"), zip(&[("../../b.geojson", &bytes), ("/c/d.geojson", &bytes)])).unwrap();
    let before = folder.files();
    let document = folder.type_in("info in/a.zip --json").done().json();
    // Two files of the same buildings.
    assert_eq!((&document["buildings"], &document["files"]), (&3.into(), &2.into()), "{document}");
    assert_eq!(folder.files(), before);
    for (name, whole) in [("a.geojson.gz", gzip(&bytes)), ("a.zip", zip(&[("a.geojson", &bytes)]))] {
        fs::write(folder.join(name), &whole[..whole.len() - 30]).unwrap();
        folder.refuses(&format!("info {name}"), "E302", &[name]);
    }
}

#[test]
fn xml_cannot_exhaust_what_reads_it() {
    let folder = Folder::new();
    let good = citygml(&city(), 2);
    // Entities are not expanded.
    let entities: String = (1..10).fold("<!ENTITY l0 \"lol\">".into(), |mut text, k| {
        let tenfold = format!("&l{};", k - 1).repeat(10);
        write!(text, "<!ENTITY l{k} \"{tenfold}\">").unwrap();
        text
    });
    let laughs = good.replacen('\n', &format!("\n<!DOCTYPE a [{entities}]>"), 1);
    folder.write("laughs.gml", &laughs.replace("gml:id=\"b0\">", "gml:id=\"b0\"><gml:name>&l9;</gml:name>"));
    let (answer, peak) = folder.measured("info laughs.gml");
    answer.done();
    assert!(peak < 300_000_000, "{peak}");
    let inside = |more: &str| good.replacen("<core:cityObjectMember>", &format!("{more}<core:cityObjectMember>"), 1);
    folder.write("deep.gml", &inside(&"<a>".repeat(100_000)));
    refused(&folder, "deep.gml", "E502", "nested");
    let attributes: String = (0..500_000).fold(String::new(), |mut text, k| {
        write!(text, " a{k}=\"\"").unwrap();
        text
    });
    folder.write("wide.gml", &inside(&format!("<a{attributes}/>")));
    let (answer, peak) = folder.measured("info wide.gml");
    answer.done();
    assert!(peak < 300_000_000, "{peak}");
    fs::write(folder.join("long.gml.gz"), gzip(inside(&format!("<a b=\"{}\"/>", " ".repeat(70 << 20))).as_bytes()))
        .unwrap();
    refused(&folder, "long.gml.gz", "E302", "64 MiB");
    // Every part has what its building has.
    let names: String = (0..5000).map(|k| format!("<a{k}>1</a{k}>")).collect();
    let part = "<bldg:BuildingPart><bldg:lod0FootPrint><gml:Polygon><gml:LinearRing><gml:posList>691000 5334000 0 691001 5334000 0 \
                691000 5334001 0</gml:posList></gml:LinearRing></gml:Polygon></bldg:lod0FootPrint></bldg:BuildingPart>";
    let parts = format!("<bldg:Building>{names}{}</bldg:Building>", part.repeat(20_000));
    folder.write("parts.gml", &inside(&parts));
    refused(&folder, "parts.gml", "E502", "attributes");
}

#[test]
fn counts_and_sizes_of_parquet_are_not_believed() {
    let (folder, city) = (Folder::new(), city());
    write_geoparquet(&folder.join("a.parquet"), &city, Compression::SNAPPY, 2);
    let good = folder.read("a.parquet");
    // Any byte of its description or of its pages may say that there is much more.
    let options = skyshed_io::read::FootprintOptions::default();
    let mut n_refused = 0;
    for at in 0..good.len() {
        for byte in [0xFF, 0x7F, good[at].wrapping_add(1), good[at] ^ 0x10] {
            let mut bytes = good.clone();
            bytes[at] = byte;
            let input = skyshed_io::Input::bytes("a.parquet", bytes);
            n_refused += usize::from(skyshed_io::read::read_footprints(input, &options, &mut Vec::new()).is_err());
        }
    }
    assert!(n_refused > good.len(), "{n_refused} of {}", 4 * good.len());
    // The first page announces 2 GB.
    assert_eq!((good[4], good[6]), (0x15, 0x15));
    let at = 7;
    let n = good[at..].iter().position(|byte| byte & 0x80 == 0).unwrap() + 1;
    let bytes = [&good[..at], &[0xFE, 0xFF, 0xFF, 0xFF, 0x0F], &good[at + n..]].concat();
    fs::write(folder.join("b.parquet"), bytes).unwrap();
    refused(&folder, "b.parquet", "E302", "b.parquet");
    for n in (0..good.len()).step_by(7) {
        fs::write(folder.join("c.parquet"), &good[..n]).unwrap();
        assert_eq!(folder.type_in("info c.parquet").code(), 3, "{n}");
    }
}
