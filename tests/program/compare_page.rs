//! The page of `skyshed compare`: whole, self-contained, safe from the words of users, and alive in a browser.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use image::RgbaImage;
use serde_json::{Value, json};
use skyshed_core::coverage::class;

use crate::chart::classes;
use crate::needs::has;
use crate::program::Folder;
use crate::support::read_png;
use crate::texts::{grid, squares};

const BLUE: [u8; 3] = [0x00, 0x72, 0xB2];
const ORANGE: [u8; 3] = [0xE6, 0x9F, 0x00];

/// Bytes from base 64 (RFC 4648).
fn decoded(text: &str) -> Vec<u8> {
    let digit = |c: u8| match c {
        b'A'..=b'Z' => c - b'A',
        b'a'..=b'z' => c - b'a' + 26,
        b'0'..=b'9' => c - b'0' + 52,
        b'+' => 62,
        b'/' => 63,
        _ => panic!("{} is no digit of base 64", char::from(c)),
    };
    let digits: Vec<u8> = text.trim_end_matches('=').bytes().map(digit).collect();
    let (mut bits, mut n_bits, mut bytes) = (0_u32, 0, Vec::new());
    for digit in digits {
        bits = (bits << 6 | u32::from(digit)) & 0xFFFF;
        n_bits += 6;
        if n_bits >= 8 {
            n_bits -= 8;
            bytes.push(u8::try_from(bits >> n_bits & 0xFF).unwrap());
        }
    }
    bytes
}

/// The pictures in a page, in order.
fn pictures(page: &str) -> Vec<RgbaImage> {
    let after = page.split("src=\"data:image/png;base64,").skip(1);
    after.map(|rest| read_png(&decoded(rest.split('"').next().unwrap())).to_rgba8()).collect()
}

fn number_of(image: &RgbaImage, color: [u8; 3]) -> u64 {
    image.pixels().filter(|p| p.0[..3] == color && p.0[3] == 255).count() as u64
}

/// What stands between the first of some words and the next of others.
fn between<'a>(text: &'a str, from: &str, to: &str) -> &'a str {
    let (_, rest) = text.split_once(from).unwrap_or_else(|| panic!("no {from}"));
    rest.split(to).next().unwrap()
}

/// The text of a script of data.
fn data(page: &str, id: &str) -> Value {
    let text = between(page, &format!("<script type=\"application/json\" id=\"{id}\">"), "</script>");
    serde_json::from_str(text).unwrap()
}

#[test]
fn pictures_have_a_pixel_per_cell_in_the_color_of_its_class() {
    let folder = Folder::new();
    folder.type_in("compare itu:urban --size 300 --uav 50,50,60 --uav 150,150,90 -o c.html -o c.json -q").done();
    let (page, document) = (folder.text("c.html"), folder.json("c.json"));
    let pictures = pictures(&page);
    assert_eq!(pictures.len(), 3, "buildings and two masks");
    assert!(pictures.iter().all(|p| p.dimensions() == (300, 300)));
    for (picture, placement) in pictures[1..].iter().zip(document["placements"].as_array().unwrap()) {
        let (los, receivers) = (placement["los"].as_u64().unwrap(), placement["receivers"].as_u64().unwrap());
        assert_eq!((number_of(picture, BLUE), number_of(picture, ORANGE)), (los, receivers - los));
    }
    let mut kept = data(&page, "comparison");
    assert_eq!(kept["digest"], document["digest"]);
    assert_eq!(kept["pairs"], document["pairs"]);
    assert!(kept.as_object_mut().unwrap().get("timing_s").is_none(), "equal runs give equal pages");
    // What a reader of the page needs is there without a script.
    for words in
        ["P<sub>LoS</sub> by zone", "1 → 2", "within ±1 m of grazing", "lang=\"en\"", "<caption>", "scope=\"row\""]
    {
        assert!(page.contains(words), "{words}");
    }
}

#[test]
fn a_page_asks_the_network_for_nothing() {
    let folder = Folder::new();
    folder.type_in("compare itu:urban --size 200 --uav 50,50,60 --uav 150,150,90 -o c.html -q").done();
    let page = folder.text("c.html");
    for word in ["http://", "https://", "//cdn", "@import", "url(", "fetch(", "XMLHttpRequest", "<link", "import("] {
        assert!(!page.contains(word), "{word}");
    }
    assert!(page.contains("default-src 'none'"));
    assert!(page.matches(" src=\"").count() == page.matches(" src=\"data:image/png;base64,").count());
}

#[test]
fn words_of_the_user_are_words() {
    let folder = Folder::new();
    let id = "</script><script>alert('1')</script><b x=\"\">&";
    let points = [(id, 50), ("{{document}}", 150)].map(|(id, x)| {
        let geometry = json!({"type": "Point", "coordinates": [x, 50]});
        json!({"type": "Feature", "properties": {"id": id, "h": 60}, "geometry": geometry})
    });
    let crs = json!({"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::25832"}});
    let sites = json!({"type": "FeatureCollection", "crs": crs, "features": points});
    folder.write("sites.geojson", &sites.to_string());
    folder.write("city.geojson", &squares(&[[80.0, 20.0, 40.0, 20.0]]));
    let scene = ["city.geojson", "--crs", "EPSG:25832", "--extent", "0,0,200,100"];
    let rest = ["--uavs", "sites.geojson", "-o", "c.html", "--title", "<i>T</i>", "--attribution", "<u>\"A\"</u>"];
    folder.run(&[&["compare"], &scene[..], &rest[..]].concat()).done();
    let page = folder.text("c.html");
    assert_eq!(page.matches("<script").count(), 4, "three of data, one of the page");
    assert_eq!(page.matches("</script>").count(), 4);
    for markup in ["<i>T", "<u>", "<b x"] {
        assert!(!page.contains(markup), "{markup}");
    }
    assert!(page.contains("&lt;i&gt;T&lt;/i&gt;") && page.contains("&lt;script&gt;alert"));
    assert_eq!(data(&page, "view")["ids"][0], id);
    assert_eq!(data(&page, "comparison")["placements"][1]["id"], "{{document}}");
}

#[test]
fn a_large_grid_is_thinned_to_the_middles_of_squares() {
    let folder = Folder::new();
    // 2100 × 2100 cells are more than a picture may have: each pixel is the middle of 2 × 2 of them.
    let line = "compare itu:urban --size 2100 --uav 1000,1000,60 --uav 500,500,90 -o c.html -o c.tif -q";
    folder.type_in(line).done();
    let page = folder.text("c.html");
    assert!(page.len() < 10_000_000, "{} bytes", page.len());
    assert!(page.contains("one cell of each 2 × 2"), "the page says so");
    let pictures = pictures(&page);
    assert!(pictures.iter().all(|p| p.dimensions() == (1050, 1050)));
    let mask = classes(&folder, "c.tif");
    for (x, y, pixel) in pictures[1].enumerate_pixels() {
        let wanted = match mask[(2 * y as usize + 1) * 2100 + 2 * x as usize + 1] {
            class::LOS => Some(BLUE),
            class::NLOS => Some(ORANGE),
            _ => None,
        };
        let found = [BLUE, ORANGE].into_iter().find(|color| pixel.0[..3] == *color);
        assert_eq!(found, wanted, "{x} {y}");
    }
}

/// A browser on the path.
fn browser() -> Option<PathBuf> {
    let folders: Vec<PathBuf> = std::env::split_paths(&std::env::var_os("PATH")?).collect();
    let names = ["chromium", "chromium-browser", "google-chrome"];
    let mut paths = names.iter().flat_map(|name| folders.iter().map(move |folder| folder.join(name)));
    let found = paths.find(|path| path.is_file());
    has("chromium", found.is_some());
    found
}

/// Runs the browser on a page with a fragment and returns what it prints.
fn browse(browser: &Path, folder: &Folder, fragment: &str, task: &[&str]) -> String {
    let page = format!("file://{}#{fragment}", folder.word("c.html"));
    let profile = format!("--user-data-dir={}", folder.word("profile"));
    let common =
        ["--headless", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=5000", "--window-size=900,1200"];
    let mut command = Command::new(browser);
    command.args(common).arg(profile).args(task).arg(page).stderr(Stdio::null());
    String::from_utf8(command.output().unwrap().stdout).unwrap()
}

#[test]
fn a_browser_shows_the_state_of_the_fragment() {
    let Some(browser) = browser() else { return };
    let folder = Folder::new();
    // Forty columns and thirty rows, the first so many cells 0 and the others 1.
    for (name, n_zeros) in [("flat.asc", 1200), ("dark.asc", 1200), ("light.asc", 0), ("some.asc", 300)] {
        let cells: Vec<u8> = (0..1200).map(|k| u8::from(k >= n_zeros)).collect();
        folder.write(name, &grid(&cells, 40, 255));
    }
    let masks = "--mask light.asc --mask dark.asc --mask some.asc";
    folder.type_in(&format!("compare flat.asc --ground 0 {masks} -o c.html -q")).done();

    let dom = browse(&browser, &folder, "a=some&b=dark&at=0.3&layers=buildings,los", &["--dump-dom"]);
    assert!(dom.contains("data-ready=\"true\""), "the script ran to its end");
    let selected = |id: &str| {
        let options = between(&dom, &format!("<select id=\"{id}\">"), "</select>");
        options.split("<option ").find(|o| o.contains("selected")).map(str::to_string).unwrap()
    };
    assert!(selected("a").contains("value=\"some\"") && selected("b").contains("value=\"dark\""));
    assert!(dom.contains("aria-valuetext=\"some · saved map on the left 30 %, dark · saved map on the right 70 %\""));
    let range = between(&dom, "<input type=\"range\"", ">");
    assert!(range.contains("value=\"0.3\""), "{range}");
    // The script counts P_LoS from the pixels: that of the document.
    let document = data(&folder.text("c.html"), "comparison");
    let share = |id: &str| -> f64 {
        let output = between(&dom, &format!("<output id=\"{id}\""), ">");
        between(output, "data-p-los=\"", "\"").parse().unwrap()
    };
    assert_eq!(document["placements"][2]["p_los"], 0.75);
    assert!((share("share-a") - 0.75).abs() < 1e-12 && share("share-b").abs() < 1e-12);

    // At 0 all of the map is B, at 1 all of it is A.
    for (at, [more, less]) in [("0", [ORANGE, BLUE]), ("1", [BLUE, ORANGE])] {
        let shot = format!("--screenshot={}", folder.word("shot.png"));
        browse(&browser, &folder, &format!("a=light&b=dark&at={at}&layers=los"), &[&shot]);
        let image = read_png(&folder.read("shot.png")).to_rgba8();
        let [n_more, n_less] = [more, less].map(|color| number_of(&image, color));
        assert!(n_more > 200_000 && n_less < 20_000, "at {at}: {n_more} and {n_less}");
    }
    let dom = browse(&browser, &folder, "a=light&b=some&layers=difference", &["--dump-dom"]);
    assert!(dom.contains("data-theme=\"difference\""));
    let cells = |k: u8| {
        let output = between(&dom, &format!("<output data-pair=\"{k}\""), ">");
        between(output, "data-cells=\"", "\"").to_string()
    };
    assert_eq!([0, 1, 2, 3].map(cells), ["0", "300", "0", "900"]);
}

/// A script that notes on the body what is cut off at the side, and which words have less than the contrast of 4.5 that WCAG
/// 2.2 asks for.
const LOOK: &str = r#"<script>
addEventListener("load", () => {
  const parts = (color) => color.match(/[\d.]+/g).map(Number);
  const linear = (v) => (v / 255 <= 0.04045 ? v / 255 / 12.92 : ((v / 255 + 0.055) / 1.055) ** 2.4);
  const light = ([r, g, b]) => 0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b);
  const behind = (element) => {
    for (let at = element; at; at = at.parentElement) {
      const color = parts(getComputedStyle(at).backgroundColor);
      if (color.length === 3 || color[3] === 1) return color;
    }
    return [255, 255, 255];
  };
  const faint = [];
  let words = 0;
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walker.nextNode()) {
    const element = walker.currentNode.parentElement;
    if (!walker.currentNode.textContent.trim() || ["SCRIPT", "OPTION", "NOSCRIPT"].includes(element.tagName)) continue;
    if (!element.checkVisibility()) continue;
    words += 1;
    const style = getComputedStyle(element);
    const ink = parts(element.tagName === "text" ? style.fill : style.color);
    const [low, high] = [light(ink), light(behind(element))].sort((a, b) => a - b);
    if ((high + 0.05) / (low + 0.05) < 4.5) faint.push(walker.currentNode.textContent);
  }
  const wide = [...document.querySelectorAll("body, .table, .controls, .mark span")];
  document.body.dataset.cut = wide.filter((e) => e.scrollWidth > e.clientWidth + 1).map((e) => e.className || e.tagName);
  const frame = document.getElementById("stage").getBoundingClientRect();
  const marks = [...document.querySelectorAll(".mark.shown span")].map((e) => e.getBoundingClientRect());
  const isOutside = (m) => m.left < frame.left || m.right > frame.right || m.top < frame.top || m.bottom > frame.bottom;
  document.body.dataset.outside = marks.filter(isOutside).map((m) => [m.left - frame.left, frame.right - m.right]);
  const overlap = (a, b) => a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
  document.body.dataset.covered = marks.filter((a, k) => marks.some((b, j) => j < k && overlap(a, b))).length;
  document.body.dataset.marks = marks.length;
  document.body.dataset.faint = faint;
  document.body.dataset.words = words;
});
</script>"#;

#[test]
fn its_own_scripts_are_all_that_a_page_may_run() {
    let folder = Folder::new();
    folder.type_in("live itu:urban --size 100 --uav 50,50,60 -o live.html -q").done();
    folder.type_in("compare itu:urban --size 100 --uav 50,50,60 --uav 20,20,60 -o c.html -q").done();
    let scripts = |page: &str| between(&folder.text(page), "script-src ", ";").to_string();
    let of_live = scripts("live.html").replace(" 'wasm-unsafe-eval'", "");
    let of_page = scripts("c.html");
    // A live page that is opened from the page obeys its policy.
    assert!(of_page.contains(&of_live) && of_page.matches("'sha256-").count() == 2, "{of_page}");
    assert!(!of_page.contains("unsafe-inline"), "{of_page}");
}

#[test]
fn nothing_is_cut_off_or_faint_in_light_and_dark() {
    let Some(browser) = browser() else { return };
    let folder = Folder::new();
    // Names as long as tables of sites have them, two UAVs at one place, and some near each border.
    let places = [(150, 150, 60), (150, 150, 90), (5, 40, 60), (250, 292, 60), (290, 60, 60), (60, 240, 60)];
    let row =
        |(k, (x, y, h)): (usize, &(i32, i32, i32))| format!("Rooftop of the old market hall number {k},{x},{y},{h}\n");
    let sites: String = places.iter().enumerate().map(row).collect();
    folder.write("sites.csv", &format!("id,x,y,h\n{sites}"));
    folder.type_in("compare itu:urban --size 300 --uavs sites.csv -o c.html -q").done();
    let page = folder.text("c.html");
    let matrix = between(&page, "<section aria-label=\"Differences of any two\">", "</table>");
    assert_eq!(matrix.matches("<td>").count(), 36, "a matrix of six by six");
    // The policy of the page forbids other scripts.
    let page = page.replace("http-equiv=\"Content-Security-Policy\"", "name=\"policy\"");
    folder.write("c.html", &page.replace("</body>", &format!("{LOOK}</body>")));
    for (scheme, is_dark) in [("0", true), ("1", false)] {
        let settings = format!("--blink-settings=preferredColorScheme={scheme}");
        let shot = format!("--screenshot={}", folder.word("shot.png"));
        let task = [settings.as_str(), "--window-size=1400,1000", "--dump-dom"];
        let dom = browse(&browser, &folder, "layers=count", &task);
        let noted = |name: &str| between(&dom, &format!("data-{name}=\""), "\"");
        assert_eq!((noted("cut"), noted("faint")), ("", ""), "dark: {is_dark}");
        assert_eq!((noted("marks"), noted("outside"), noted("covered")), ("6", "", "0"), "dark: {is_dark}");
        assert!(noted("words").parse::<u32>().unwrap() > 150);
        browse(&browser, &folder, "", &[&settings, "--window-size=1400,1000", &shot]);
        let image = read_png(&folder.read("shot.png")).to_rgba8();
        assert_eq!(image.get_pixel(2, 2).0[0] < 64, is_dark, "the paper");
    }
}
