//! Scenes on a server: the maps of files at hand, by ranges alone; and what is said when the server fails.

#![expect(clippy::unwrap_used, reason = "a panic is a failed test")]

use std::collections::HashMap;
use std::io::{BufRead, BufReader, Write};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use parquet::basic::Compression;
use serde_json::Value;

use vector_files::Building;

#[path = "shared/city_formats.rs"]
mod city_formats;
#[path = "shared/vector_files.rs"]
mod vector_files;

/// How a server answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Manner {
    Well,
    /// The first answers to ranges are errors.
    ErrorsFirst(usize),
    /// All answers to ranges are errors.
    Errors,
    /// The connection ends in the middle of a range.
    Cuts,
    /// Other bytes than those asked for.
    OtherRange,
    /// Whole files instead of ranges.
    Whole,
    /// Half a second for each answer.
    Slow,
    /// The file changes once it was asked for a few times.
    Changes,
    Forbidden,
    /// No answer at all.
    Silent,
    /// A byte of a range every two seconds.
    Trickles,
    /// A range that never ends.
    Endless,
    /// Another length in each answer than the file has.
    Lies,
    /// On to a file of this machine.
    ToFile,
    /// On to a host that is not there.
    Away,
}

#[derive(Debug)]
struct Server {
    address: String,
    manner: Arc<Mutex<Manner>>,
    /// Bytes that were sent, and ranges that were asked for.
    sent: Arc<Mutex<(u64, usize)>>,
}

impl Server {
    /// A server of files by their paths.
    fn of(files: HashMap<String, Vec<u8>>) -> Server {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = format!("http://{}", listener.local_addr().unwrap());
        let (manner, sent) = (Arc::new(Mutex::new(Manner::Well)), Arc::new(Mutex::new((0, 0))));
        let (files, shared) = (Arc::new(files), (Arc::clone(&manner), Arc::clone(&sent)));
        std::thread::spawn(move || {
            for stream in listener.incoming().flatten() {
                let (files, (manner, sent)) = (Arc::clone(&files), (Arc::clone(&shared.0), Arc::clone(&shared.1)));
                std::thread::spawn(move || {
                    let mut reader = BufReader::new(stream);
                    while answer(&mut reader, &files, &manner, &sent).is_some() {}
                });
            }
        });
        Server { address, manner, sent }
    }

    fn answers(&self, manner: Manner) {
        *self.manner.lock().unwrap() = manner;
        *self.sent.lock().unwrap() = (0, 0);
    }

    fn sent(&self) -> (u64, usize) {
        *self.sent.lock().unwrap()
    }
}

/// The answer of a server that sends nothing, or sends on; `None` of one that answers with a file.
fn without_a_file(manner: Manner, out: &mut TcpStream) -> Option<Option<()>> {
    let moved = |to: &str| format!("HTTP/1.1 302 Found\r\nLocation: {to}\r\nContent-Length: 0\r\n\r\n");
    match manner {
        Manner::Silent => {
            std::thread::sleep(Duration::from_secs(600));
            Some(None)
        }
        Manner::ToFile => Some(out.write_all(moved("file:///etc/hosts?signature=hidden").as_bytes()).ok()),
        Manner::Away => Some(out.write_all(moved("http://u:hidden@127.0.0.1:1/a.tif?s=hidden").as_bytes()).ok()),
        _ => None,
    }
}

/// Sends a range hardly or for ever, if that is the manner; `None` once nobody listens.
fn without_end(manner: Manner, out: &mut TcpStream, bytes: &[u8]) -> Option<()> {
    if manner == Manner::Trickles {
        for byte in bytes {
            out.write_all(&[*byte]).ok()?;
            std::thread::sleep(Duration::from_secs(2));
        }
    }
    if manner == Manner::Endless {
        loop {
            out.write_all(&[0; 1 << 16]).ok()?;
        }
    }
    Some(())
}

/// Answers one request; `None` at the end of a connection.
fn answer(
    reader: &mut BufReader<TcpStream>,
    files: &HashMap<String, Vec<u8>>,
    manner: &Mutex<Manner>,
    sent: &Mutex<(u64, usize)>,
) -> Option<()> {
    let mut line = String::new();
    reader.read_line(&mut line).ok().filter(|n| *n > 0)?;
    let mut words = line.split_whitespace();
    let (method, path) = (words.next()?.to_string(), words.next()?.to_string());
    let mut headers = HashMap::new();
    loop {
        let mut header = String::new();
        reader.read_line(&mut header).ok()?;
        let Some((name, value)) = header.trim_end().split_once(": ") else { break };
        headers.insert(name.to_lowercase(), value.to_string());
    }
    let path = path.split('?').next()?.trim_end_matches('/').to_string();
    let manner = *manner.lock().unwrap();
    let mut count = sent.lock().unwrap();
    if headers.contains_key("range") {
        count.1 += 1;
    }
    let n_ranges = count.1;
    drop(count);
    if manner == Manner::Slow {
        std::thread::sleep(Duration::from_millis(500));
    }
    let out = reader.get_mut();
    if let Some(sent_on) = without_a_file(manner, out) {
        return sent_on;
    }
    let Some(file) = files.get(&path) else {
        return out.write_all(b"HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n").ok();
    };
    if manner == Manner::Forbidden {
        return out.write_all(b"HTTP/1.1 403 Forbidden\r\nContent-Length: 0\r\n\r\n").ok();
    }
    let tag = if manner == Manner::Changes && n_ranges > 3 { "\"second\"" } else { "\"first\"" };
    let date = "Last-Modified: Tue, 24 Nov 2026 10:00:00 GMT";
    let Some(range) = headers.get("range").filter(|_| method == "GET" && manner != Manner::Whole) else {
        let head = format!("HTTP/1.1 200 OK\r\nETag: {tag}\r\n{date}\r\nContent-Length: {}\r\n\r\n", file.len());
        out.write_all(head.as_bytes()).ok()?;
        if method == "GET" {
            sent.lock().unwrap().0 += file.len() as u64;
            out.write_all(file).ok()?;
        }
        return Some(());
    };
    let fails = match manner {
        Manner::ErrorsFirst(n) => n_ranges <= n,
        Manner::Errors => true,
        _ => false,
    };
    if fails {
        return out.write_all(b"HTTP/1.1 503 Service Unavailable\r\nContent-Length: 0\r\n\r\n").ok();
    }
    if headers.get("if-match").is_some_and(|wanted| wanted != tag) {
        return out.write_all(b"HTTP/1.1 412 Precondition Failed\r\nContent-Length: 0\r\n\r\n").ok();
    }
    let (from, to) = range.strip_prefix("bytes=")?.split_once('-')?;
    let (mut from, mut to): (usize, usize) = (from.parse().ok()?, to.parse::<usize>().ok()?.min(file.len() - 1));
    if manner == Manner::OtherRange && from > 100 {
        (from, to) = (from - 1, to - 1);
    }
    let bytes = &file[from..=to];
    let head = format!(
        "HTTP/1.1 206 Partial Content\r\nETag: {tag}\r\n{date}\r\nContent-Range: bytes {from}-{to}/{}\r\nContent-Length: {}\r\n\r\n",
        if manner == Manner::Lies { 2 * file.len() } else { file.len() },
        if manner == Manner::Endless { u64::MAX / 4 } else { bytes.len() as u64 }
    );
    out.write_all(head.as_bytes()).ok()?;
    without_end(manner, out, bytes)?;
    if manner == Manner::Cuts {
        out.write_all(&bytes[..bytes.len() / 2]).ok()?;
        return None;
    }
    sent.lock().unwrap().0 += bytes.len() as u64;
    out.write_all(bytes).ok()
}

fn folder() -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("remote-{}", std::process::id()));
    std::fs::create_dir_all(&path).unwrap();
    path
}

fn skyshed(folder: &Path, line: &str) -> Output {
    let program = Command::new(env!("CARGO_BIN_EXE_skyshed"))
        .args(line.split_whitespace())
        .current_dir(folder)
        .env_remove("HTTP_PROXY")
        .env_remove("http_proxy")
        .env("NO_PROXY", "127.0.0.1")
        .output();
    program.unwrap()
}

fn done(output: &Output) -> Value {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap_or(Value::Null)
}

/// The words of an error and its exit code.
fn error(output: &Output) -> (String, Option<i32>) {
    assert!(output.stdout.is_empty(), "an error says nothing on standard output");
    (String::from_utf8_lossy(&output.stderr).into_owned(), output.status.code())
}

// One test: what it prepares takes longer than what it asks.
#[test]
fn scenes_on_a_server_are_read_by_ranges_and_its_faults_are_told() {
    let folder = folder();
    let run = |line: &str| skyshed(&folder, line);
    // A raster of 4000² cells of which a map needs a part, and footprints with an index.
    assert!(run("city itu:urban --size 4000 --seed 3 -o dsm.tif -q --overwrite").status.success());
    assert!(run("city itu:urban --size 12000 --seed 4 -o city.geojson -q --overwrite").status.success());
    let _ = std::fs::remove_file(folder.join("city.fgb"));
    let ogr = Command::new("ogr2ogr")
        .args(["-a_srs", "EPSG:25832", "city.fgb", "city.geojson"])
        .current_dir(&folder)
        .output();
    let has_ogr = ogr.is_ok_and(|output| output.status.success());
    if !has_ogr {
        eprintln!("skipped: footprints on a server, as `ogr2ogr` is not at hand to index them");
        std::fs::write(folder.join("city.fgb"), []).unwrap();
    }
    let read = |name: &str| std::fs::read(folder.join(name)).unwrap();
    let (dsm, city) = (read("dsm.tif"), read("city.fgb"));
    let files = [("/a/dsm.tif", dsm.clone()), ("/bucket/dsm.tif", dsm.clone()), ("/city.fgb", city.clone())];
    let server = Server::of(files.into_iter().map(|(path, bytes)| (path.to_string(), bytes)).collect());
    let at = &server.address;
    let asked = "--ground 0 --uav 2000,2000,150 --radius 300 --json -q";

    // The map of the file at hand, by a small part of it.
    let here = done(&run(&format!("map dsm.tif {asked}")));
    let there = done(&run(&format!("map {at}/a/dsm.tif {asked}")));
    assert_eq!((&here["digest"], &here["union"]), (&there["digest"], &there["union"]));
    assert_eq!(there["scene"]["sources"][0]["path"], format!("{at}/a/dsm.tif"));
    let (n_bytes, _) = server.sent();
    assert!(n_bytes < dsm.len() as u64 / 3, "{n_bytes} of {}", dsm.len());
    // Footprints around an extent, and as far as the longest building may reach.
    let part = "--extent 100,100,400,400 --uav 250,250,120 --radius 100 --json -q";
    if has_ogr {
        server.answers(Manner::Well);
        let [here, there] = [String::new(), format!("{at}/")].map(|at| done(&run(&format!("map {at}city.fgb {part}"))));
        assert_eq!(here["digest"], there["digest"]);
        let (n_bytes, _) = server.sent();
        assert!(n_bytes < city.len() as u64 / 2, "{n_bytes} of {}", city.len());
    }
    // A bucket.
    let bucket = Command::new(env!("CARGO_BIN_EXE_skyshed"))
        .args(format!("map s3://bucket/dsm.tif {asked}").split_whitespace())
        .current_dir(&folder)
        .envs([
            ("AWS_ENDPOINT", at.as_str()),
            ("AWS_SKIP_SIGNATURE", "true"),
            ("AWS_REGION", "eu"),
            ("NO_PROXY", "127.0.0.1"),
        ])
        .output()
        .unwrap();
    assert_eq!(done(&bucket)["digest"], done(&run(&format!("map dsm.tif {asked}")))["digest"]);

    // A signature is used and told nobody.
    let secret = at.replace("http://", "http://user:hidden@") + "/a/dsm.tif?signature=hidden";
    let output = run(&format!("map {secret} {asked} -o secret.tif -o secret.csv --overwrite"));
    assert!(done(&output).to_string().contains("/a/dsm.tif"));
    for name in ["secret.tif", "secret.csv", "secret.csv.json"] {
        assert!(!String::from_utf8_lossy(&read(name)).contains("hidden"), "{name}");
    }
    assert!(!String::from_utf8_lossy(&output.stdout).contains("hidden"));

    // Tiles of it in units; again nothing is done, and the server is hardly asked.
    std::fs::write(folder.join("sites.csv"), "id,x,y,h\na,2000,2000,150\nb,2300,1900,150\n").unwrap();
    let tiles = "--ground 0 --uavs sites.csv --radius 300 --layers count --tile-size 512 --resume -q";
    let _ = std::fs::remove_dir_all(folder.join("t"));
    let line = format!("map {at}/a/dsm.tif {tiles} -o t/{{row}}/{{col}}.tif");
    std::fs::create_dir(folder.join("t")).unwrap();
    assert!(run(&line).status.success());
    server.answers(Manner::Well);
    assert!(run(&line).status.success());
    assert!(server.sent().0 < 300_000, "{:?}", server.sent());

    // A server that fails for a while, or is slow, loses nothing.
    let digest = there_digest(&run, at, asked);
    for manner in [Manner::ErrorsFirst(2), Manner::Slow] {
        server.answers(manner);
        assert_eq!(there_digest(&run, at, asked), digest, "{manner:?}");
    }
    // One that fails for good is told, and nothing is written.
    for (manner, words) in [
        (Manner::Errors, "503"),
        (Manner::Cuts, "bytes"),
        (Manner::OtherRange, "bytes"),
        (Manner::Whole, "HTTP ranges"),
        (Manner::Changes, "has changed since it was opened"),
        (Manner::Forbidden, "permission denied"),
    ] {
        server.answers(manner);
        let (text, code) = error(&run(&format!("map {at}/a/dsm.tif {asked} -o fault.tif")));
        assert!(code == Some(3) && text.contains("/a/dsm.tif") && text.contains(words), "{manner:?}: {code:?} {text}");
        assert!(!folder.join("fault.tif").exists(), "{manner:?}");
    }
    server.answers(Manner::Well);
    let (text, code) = error(&run(&format!("map {at}/none.tif {asked}")));
    assert!(code == Some(3) && text.starts_with("error[E301]") && text.contains("no such file"), "{text}");
    let (text, code) = error(&run(&format!("map http://127.0.0.1:1/dsm.tif {asked}")));
    assert!(code == Some(3) && text.starts_with("error[E301]"), "{text}");
    std::fs::remove_dir_all(&folder).unwrap();
}

/// A district of a world file: groups of rows whose boxes do not meet it are never asked for.
#[test]
fn a_district_is_cut_out_of_a_large_table() {
    let folder = folder().with_extension("table");
    std::fs::create_dir_all(&folder).unwrap();
    // Rows of houses from the south over 100 km, 400 in a group. Read is what is within 5 km of the district.
    let house = |k: u32| {
        let (x, y) = (f64::from(k % 200).mul_add(20.0, 691_000.0), f64::from(k / 200).mul_add(500.0, 5_334_000.0));
        let ring = vec![[x, y], [x + 9.0, y], [x + 9.0, y + 12.0], [x, y + 12.0], [x, y]];
        Building { height: "11.5", polygons: vec![vec![ring]] }
    };
    let city: Vec<Building> = (0..40_000).map(house).collect();
    city_formats::write_geoparquet(&folder.join("city.parquet"), &city, Compression::SNAPPY, 400);
    let table = std::fs::read(folder.join("city.parquet")).unwrap();
    let server = Server::of(HashMap::from([("/city.parquet".to_string(), table.clone())]));
    let district = "--extent 692000,5384000,692395,5384700 --json -q";
    let info = done(&skyshed(&folder, &format!("info city.parquet {district}")));
    assert_eq!(info["buildings"], 40);
    let map = |scene: String| done(&skyshed(&folder, &format!("map {scene} {district} --uav 692200,5384200,60")));
    let here = map("city.parquet".into());
    let there = map(format!("{}/city.parquet", server.address));
    assert_eq!(here["digest"], there["digest"]);
    let (n_bytes, n_ranges) = server.sent();
    assert!(n_bytes < table.len() as u64 / 4 && n_ranges < 60, "{n_bytes} of {} in {n_ranges}", table.len());
    std::fs::remove_dir_all(&folder).unwrap();
}

/// Each ends with what failed, after a time and with a memory that do not depend on what the server sends.
#[test]
fn a_server_that_means_harm_is_given_up_soon() {
    let folder = folder().with_extension("harm");
    std::fs::create_dir_all(&folder).unwrap();
    let made = skyshed(&folder, "city itu:urban --size 800 --seed 3 -o dsm.tif -q --overwrite");
    assert!(made.status.success(), "{made:?}");
    let dsm = std::fs::read(folder.join("dsm.tif")).unwrap();
    let hostile = &|(manner, words): (Manner, &str)| {
        let server = Server::of(HashMap::from([("/dsm.tif".to_string(), dsm.clone())]));
        server.answers(manner);
        let at = server.address.replace("http://", "HTTP://user:hidden@");
        let limited = "ulimit -v 2000000; exec timeout 120 \"$0\" \"$@\"";
        let line = format!("map {at}/dsm.tif?signature=hidden --ground 0 --uav 400,400,150 -o {manner:?}.tif");
        let output = Command::new("sh")
            .args(["-c", limited, env!("CARGO_BIN_EXE_skyshed")])
            .args(line.split(' '))
            .current_dir(&folder)
            .env("NO_PROXY", "127.0.0.1")
            .output();
        let (text, code) = error(&output.unwrap());
        assert!(code == Some(3) && text.contains(words) && !text.contains("hidden"), "{manner:?}: {code:?} {text}");
        assert!(!folder.join(format!("{manner:?}.tif")).exists(), "{manner:?}");
    };
    std::thread::scope(|threads| {
        for of in [
            (Manner::Silent, "too slowly"),
            (Manner::Trickles, "too slowly"),
            (Manner::Endless, "other bytes than it was asked for"),
            (Manner::Lies, "has changed"),
            (Manner::ToFile, "error[E301]"),
            (Manner::Away, "error[E301]"),
        ] {
            threads.spawn(move || hostile(of));
        }
    });
    std::fs::remove_dir_all(&folder).unwrap();
}

fn there_digest(run: &dyn Fn(&str) -> Output, at: &str, asked: &str) -> Value {
    done(&run(&format!("map {at}/a/dsm.tif {asked}")))["digest"].clone()
}
