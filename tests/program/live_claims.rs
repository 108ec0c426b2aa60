//! What the live page and the page of a comparison say and draw, against the program and against numbers found by hand: commands, links to
//! other pages, marks, shares, places over no data.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use serde_json::{Value, json};

use crate::live::{ask, driver, map, tool};
use crate::needs::has_program;
use crate::program::Folder;
use crate::support::Random;

/// The size of a page on a desk.
pub(crate) const DESK: &str = "1280,800";

fn munich() -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("maps/munich.geojson").display().to_string()
}

/// Does steps on a page in a browser, and returns the answers to those that ask.
pub(crate) fn steps(driver: &str, page: &str, size: &str, steps: &[Value]) -> Vec<Value> {
    let mut node = Command::new("node");
    node.args([&tool("live_steps.mjs"), page, size]).env("NODE_PATH", format!("{driver}/node_modules"));
    let mut node = node.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let lines: String = steps.iter().map(|step| format!("{step}\n")).collect();
    node.stdin.take().unwrap().write_all(lines.as_bytes()).unwrap();
    let answer = node.wait_with_output().unwrap();
    assert!(answer.status.success(), "{}", String::from_utf8_lossy(&answer.stderr));
    let said = String::from_utf8(answer.stdout).unwrap();
    said.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// The texts of a picture.
fn texts(svg: &str) -> Vec<String> {
    let inside = svg.split("</text>").filter_map(|part| part.rsplit_once('>').map(|(_, text)| text.to_string()));
    inside.filter(|text| !text.is_empty()).collect()
}

/// The numbers of cells of a legend's classes of receivers, in its order.
fn cells_of_legend(svg: &str) -> Vec<u64> {
    let count = |text: &String| {
        let (_, rest) = text.split_once("\u{202F}% · ")?;
        rest.split(' ').next()?.replace('\u{202F}', "").parse().ok()
    };
    texts(svg).iter().filter_map(count).collect()
}

/// The command that the page shows gives the classes of the map on screen, whatever that is of, and its digest is the page's.
#[test]
fn the_command_of_the_page_makes_the_map_on_screen() {
    let Some(driver) = driver() else { return };
    let folder = Folder::new();
    folder.type_in("live itu:urban --size 300 -o page.html -q").done();
    let [a, b, inside] = ["150,150,100agl,1", "40,220,60agl,2", "30,30,1agl,3"];
    // What is on screen, its fragment, and what the page says besides.
    let cases = [
        ("one UAV", format!("uavs={a}&layer=one"), ""),
        ("one of two", format!("uavs={a};{b}&layer=one&selected=2"), ""),
        ("any", format!("uavs={a};{b}&layer=union"), ""),
        ("how many", format!("uavs={a};{b}&layer=count"), ""),
        ("who", format!("uavs={a};{b}&layer=who"), ""),
        ("one with heights that may be off", format!("uavs={a};{b}&layer=one&sight=1.5,ground,,,,,,,,,2.5"), ""),
        ("any, in range", format!("uavs={a};{b}&layer=union&sight=2,street,90"), ""),
        ("an antenna", format!("uavs={a}&sight=1.5,all,,7,20,200,-80,-20,130"), ""),
        ("a curved earth", format!("uavs={a};{b}&layer=count&sight=60,air,,,,,,,,0.0005"), ""),
        ("two of three", format!("uavs={inside};{a};{b}&layer=who&selected=2"), "UAV 3"),
        ("any of three", format!("uavs={inside};{a};{b}&layer=union&selected=2"), "UAV 3"),
        ("one of three", format!("uavs={inside};{a};{b}&layer=one&selected=2"), ""),
    ];
    // The digest comes a while after the map.
    let facts = json!({"ask": "new Promise((done) => { \
            const look = () => (document.getElementById('digest').textContent.startsWith('comes') ? setTimeout(look, 20) : done()); \
            look(); }).then(() => ({ \
        command: document.getElementById('command').textContent, says: document.getElementById('command-says').textContent, \
        digest: document.getElementById('digest').textContent, \
        cells: receiverRows(coverage.answer).map((row) => row.cells) }))"});
    let script: Vec<Value> = cases
        .iter()
        .flat_map(|(_, fragment, _)| {
            [json!({"open": format!("#{fragment}")}), json!({"click": "#save"}), facts.clone()]
        })
        .collect();
    let answers = steps(&driver, &folder.word("page.html"), DESK, &script);
    for ((what, _, left_out), page) in cases.iter().zip(&answers) {
        let command = page["command"].as_str().unwrap();
        let mut words: Vec<&str> = command.split_whitespace().collect();
        assert_eq!((words[0], words[1]), ("skyshed", "map"), "{command}");
        assert!(words.pop().is_some_and(|name| name.ends_with(".png")), "{command}");
        words.extend(["map.svg", "--json", "--overwrite", "-q"]);
        let document = folder.run(&words[1..]).done().json();
        // The page has a class that no cell may be of, as seen by one of three where one cannot hover.
        let some = |cells: &[u64]| cells.iter().copied().filter(|n| *n > 0).collect::<Vec<u64>>();
        let shown: Vec<u64> = serde_json::from_value(page["cells"].clone()).unwrap();
        let (mut shown, mut made) = (some(&shown), some(&cells_of_legend(&folder.text("map.svg"))));
        // Legends have their own orders.
        shown.sort_unstable();
        made.sort_unstable();
        assert!(!made.is_empty() && shown == made, "{what}: {command}: {shown:?} and {made:?}");
        let says = page["says"].as_str().unwrap();
        assert!(says.starts_with("It gives the same map.") && says.contains(left_out), "{what}: {says}");
        if left_out.is_empty() {
            assert_eq!(page["digest"], document["digest"], "{what}: {command}");
            assert_eq!(says, "It gives the same map.", "{what}");
        } else {
            assert_eq!(page["digest"], "none while a UAV cannot hover", "{what}");
        }
    }
}

/// From the page of a comparison to the live page and into its address, a height stays above what it was given above, and the map
/// the same.
#[test]
fn a_comparison_hands_its_uavs_to_the_live_page_as_they_were_given() {
    let Some(driver) = driver() else { return };
    let folder = Folder::new();
    folder.write("uavs.csv", "id,x,y,h\nstreet,150,150,100\nroof,30,30,25roof\nsea,40,220,60.25amsl\n");
    let sight = "--receivers air --rx-height 60 --radius 120 --earth-k 0.0005 --sector 10,300";
    folder.type_in(&format!("compare itu:urban --size 300 --uavs uavs.csv {sight} -o c.html -q")).done();
    let kinds = |uavs: &str| format!("{uavs}.map((uav) => [uav.id, uav.height.kind, uav.height.m])");
    let state = json!({"ask": format!(
        "new Promise((done) => {{ const look = () => (coverage.digest ? done() : setTimeout(look, 20)); look(); }}).then(() => ({{ now: {}, kept: {}, digest: coverage.digest, \
         again: uavsOf(uavsWord(skyshed.state.kept.map((kept) => kept.uavs[0]))).map((uav) => uav.height), \
         csv: keptCsv(), sight: skyshed.state.sight }}))",
        kinds("skyshed.state.uavs"),
        kinds("skyshed.state.kept.map((kept) => kept.uavs[0])")
    )});
    for (a, b) in [("street", "roof"), ("roof", "sea")] {
        let script = [json!({"open": format!("#a={a}&b={b}")}), json!({"follow": "#live"}), state.clone()];
        let page = &steps(&driver, &folder.word("c.html"), DESK, &script)[0];
        let given = |id: &str| match id {
            "street" => (json!([id, "agl", 100]), json!({"kind": "agl", "m": 100}), "100agl", "150,150,100"),
            "roof" => (json!([id, "roof", 25]), json!({"kind": "roof", "m": 25}), "25roof", "30,30,25roof"),
            _ => (json!([id, "amsl", 60.25]), json!({"kind": "amsl", "m": 60.25}), "60.25amsl", "40,220,60.25amsl"),
        };
        let (first, second) = (given(a), given(b));
        assert_eq!(page["kept"], json!([first.0, second.0]));
        assert_eq!(page["now"], json!([second.0]));
        assert_eq!(page["again"], json!([first.1, second.1]));
        let csv = page["csv"].as_str().unwrap();
        assert!(csv.contains(first.2) && csv.contains(second.2), "{csv}");
        assert_eq!(page["sight"]["earth_k"], json!(0.0005));
        let map =
            folder.type_in(&format!("map itu:urban --size 300 --uav {} {sight} --json -q", second.3)).done().json();
        assert_eq!(page["digest"], map["digest"], "{b}");
    }
}

/// Who looks at places of a drone from the ground or a roof is drawn and called an observer; who does from the air, a UAV.
#[test]
fn marks_and_words_are_of_what_is_there() {
    let Some(driver) = driver() else { return };
    let folder = Folder::new();
    folder.type_in("live itu:urban --size 300 --uav 150,150,100 -o page.html -q").done();
    let look = json!({"ask": "({ observers: document.querySelectorAll('.mark.observer').length, \
        rotors: [...document.querySelectorAll('.mark > svg')].map((svg) => svg.querySelectorAll('circle').length > 8), \
        names: skyshed.state.uavs.map(uavName), hint: document.querySelector('#hint span').textContent, \
        title: document.title, add: document.getElementById('add').textContent, \
        words: document.getElementById('panel').innerText, label: document.querySelector('.mark').getAttribute('aria-label') })"});
    let air = "sight=60,air,";
    let fragments = [
        "#uavs=150,150,100agl,1".to_string(),
        format!("#uavs=150,150,1.7agl,1&{air}"),
        format!("#uavs=150,150,120agl,1&{air}"),
        format!("#uavs=30,30,1.7roof,1;150,150,1.7amsl,2&layer=count&{air}"),
        format!("#uavs=30,30,1.7roof,1;150,150,90amsl,2&layer=count&{air}"),
    ];
    let script: Vec<Value> = fragments.iter().flat_map(|f| [json!({"open": f}), look.clone()]).collect();
    let answers = steps(&driver, &folder.word("page.html"), DESK, &script);
    let wanted: [(u64, &[bool], &[&str], &str); 5] = [
        (0, &[true], &["UAV 1"], "Drag the drone"),
        (1, &[false], &["Observer 1"], "Drag the observer"),
        (0, &[true], &["UAV 1"], "Drag the drone"),
        (2, &[false, false], &["Observer 1", "Observer 2"], "Drag the observer"),
        (1, &[false, true], &["Observer 1", "UAV 2"], "Drag the drone"),
    ];
    for ((fragment, page), (observers, rotors, names, hint)) in fragments.iter().zip(&answers).zip(wanted) {
        assert_eq!(page["observers"], json!(observers), "{fragment}");
        assert_eq!(
            (&page["rotors"], &page["names"], &page["hint"]),
            (&json!(rotors), &json!(names), &json!(hint)),
            "{fragment}"
        );
        assert!(page["label"].as_str().unwrap().starts_with(names[0]), "{fragment}: {page}");
    }
    // Where all are observers nothing on the page speaks of a UAV.
    for page in [&answers[1], &answers[3]] {
        let words = format!("{} {} {}", page["title"], page["add"], page["words"]);
        assert!(!words.contains("UAV") && words.contains("bserver"), "{words}");
    }
    // Pictures and pages of the program do alike; the symbol of an observer has one circle with its halo, that of a UAV many.
    let air = "--receivers air --rx-height 60";
    let places = ["150,150,1.7", "150,150,120", "30,30,1.7roof"];
    for (uav, who) in places.into_iter().zip(["Observer 1", "UAV 1", "Observer 1"]) {
        folder.type_in(&format!("map itu:urban --size 300 --uav {uav} {air} -o map.svg --overwrite -q")).done();
        let texts = texts(&folder.text("map.svg"));
        assert!(texts.iter().any(|text| text == who), "{uav}: {texts:?}");
    }
    folder
        .type_in(&format!(
            "compare itu:urban --size 300 --uav 150,150,1.7 --uav 150,150,120 {air} -o c.html -o c.svg -q"
        ))
        .done();
    let page = folder.text("c.html");
    let legend = page.split("<ul class=\"legend\">").nth(1).unwrap().split("</ul>").next().unwrap();
    assert!(legend.contains("</svg>UAV</li>") && legend.contains("</svg>observer</li>"), "{legend}");
    let circles: Vec<usize> = page
        .split("<div class=\"mark")
        .skip(1)
        .map(|mark| mark.split("</svg>").next().unwrap().matches("<circle").count())
        .collect();
    assert_eq!(circles, [2, 14]);
    let sheet = texts(&folder.text("c.svg"));
    assert!(["UAV", "observer"].iter().all(|word| sheet.iter().any(|text| text == word)), "{sheet:?}");
}

/// Over no data a UAV has a mask and no share, and the page says why.
#[test]
fn a_uav_over_no_data_has_no_share_in_the_page() {
    if !has_program("node") {
        return;
    }
    let folder = Folder::new();
    // Two villages of four houses, 340 m apart: of the field between them what is over 100 m from all houses is no data.
    let houses = [0.0, 500.0].map(|x| [[x, 0.0], [x + 120.0, 0.0], [x, 120.0], [x + 120.0, 120.0]]).concat();
    let houses: Vec<[f64; 4]> = houses.into_iter().map(|[x, y]| [x, y, 40.0, 12.0]).collect();
    folder.write("city.geojson", &crate::texts::squares(&houses));
    folder.type_in("live city.geojson --uav 80,80,60 -o page.html -q").done();
    let [known, unknown] = [(80.0, 80.0, 60.0), (330.0, 80.0, 60.0)];
    let mut questions: Vec<Value> = [known, unknown].iter().map(|place| map(&[*place])).collect();
    let kept = |(x, y, m): (f64, f64, f64)| {
        let sight = json!({"rx_height": 1.5, "receivers": "ground", "radius": null});
        json!({"uavs": [{"id": "1", "x": x, "y": y, "height": {"kind": "agl", "m": m}}], "sight": sight})
    };
    questions.push(json!({"do": "compare", "kept": [kept(known), kept(unknown)], "base": 0}));
    questions.push(json!({"do": "best", "which": 0, "radius_m": 60.0}));
    questions.push(map(&[known, unknown]));
    let answers = ask(&folder.word("page.html"), None, &questions);
    let [over_data, over_none] = [&answers[1]["uavs"][0], &answers[2]["uavs"][0]];
    assert!(over_data["p_los"].is_f64() && over_data["reason"].is_null(), "{over_data}");
    assert_eq!((&over_none["p_los"], &over_none["reason"]), (&Value::Null, &json!("the UAV is over no data")));
    assert!(over_none["receivers"].as_u64() > Some(100) && over_none["los"].as_u64() > Some(0), "{over_none}");
    assert_eq!(answers[3]["rows"][1]["reason"], "the UAV is over no data");
    assert_eq!(
        (&answers[5]["all"]["reason"], &answers[5]["uavs"][0]["reason"]),
        (&json!("the UAV is over no data"), &Value::Null)
    );
    // No place over no data is tried, or found.
    assert!(answers[4]["best"].is_null() && answers[4]["tried"] == 0, "{}", answers[4]);

    let Some(driver) = driver() else { return };
    let page = |(x, y, m): (f64, f64, f64)| json!({"open": format!("#uavs={x},{y},{m}agl,1")});
    let look = json!({"ask": "['share', 'share-of', 'p-los'].map((id) => document.getElementById(id).textContent) \
        .concat(document.querySelector('#uav-1 .share').textContent, document.getElementById('legend').textContent)"});
    let script = [page(known), look.clone(), page(unknown), look];
    let seen = steps(&driver, &folder.word("page.html"), DESK, &script);
    assert!(seen[0][0].as_str().unwrap().ends_with('%') && seen[0][2] != "= –", "{}", seen[0]);
    let [share, of, p_los, listed, legend] = [0, 1, 2, 3, 4].map(|k| seen[1][k].as_str().unwrap());
    assert_eq!((share, p_los, listed), ("–", "= –", "–"));
    assert!(of.contains("over no data") && !legend.contains('%'), "{of} {legend}");
}

/// A legend names no class that is not drawn.
#[test]
fn a_legend_names_what_is_drawn() {
    let Some(driver) = driver() else { return };
    let folder = Folder::new();
    folder.type_in("live itu:urban --size 300 --uav 150,150,100 -o itu.html -q").done();
    folder.type_in(&format!("live {} --uav 691549.7,5334762.2,120 -o munich.html -q", munich())).done();
    let names =
        json!({"ask": "[...document.querySelectorAll('#legend li:not([hidden]) .name')].map((e) => e.textContent)"});
    let open = |fragment: &str| [json!({"open": fragment}), names.clone()];
    let sights = ["", "#sight=1.5,ground,100", "#sight=1.5,ground,100000"];
    let script: Vec<Value> = sights.into_iter().flat_map(open).collect();
    // What is drawn, by the colors of the picture of the whole map: hatched paper, and what is out of range.
    for (page, has_no_data) in [("itu.html", false), ("munich.html", true)] {
        let answers = steps(&driver, &folder.word(page), DESK, &script);
        for (answer, is_cut) in answers.iter().zip([false, true, false]) {
            let has = |name: &str| answer.as_array().unwrap().iter().any(|found| found == name);
            assert_eq!((has("No data"), has("Out of range")), (has_no_data, is_cut), "{page}: {answer}");
        }
    }
}

/// Shares in words of pages are those of whole numbers, halves rounded up, and of the program's pictures; decimals are as those of
/// the program.
#[test]
fn one_count_has_one_share() {
    if !has_program("node") {
        return;
    }
    let shares = Path::new(env!("CARGO_MANIFEST_DIR")).join("crates/render/src/web_page/shares.js");
    let script = "const shares = require('fs').readFileSync(process.argv[1], 'utf8'); \
        const [words, number] = (0, eval)(`${shares}; [shareWords, rounded]`); \
        const lines = require('fs').readFileSync(0, 'utf8').split('\\n').filter(Boolean).map(JSON.parse); \
        for (const [a, b, isShare] of lines) console.log(isShare ? words(a, b) : number(a, b));";
    let mut random = Random(5);
    let mut pairs: Vec<(u64, u64)> =
        vec![(637, 1000), (1, 400), (3, 400), (3, 2000), (1, 2000), (1999, 2000), (1, 16), (7, 8)];
    pairs.extend((0..400).map(|_| {
        let whole = 1 + random.below(5000);
        (random.below(whole + 1) as u64, whole as u64)
    }));
    let numbers = [
        (1.0 / 32.0, 4),
        (3.0 / 32.0, 4),
        (-0.00001, 4),
        (0.19627558824228689, 4),
        (-1.0 / 32.0, 4),
        (2.5, 0),
        (0.25, 1),
    ];
    let lines: String = pairs.iter().map(|(part, whole)| format!("[{part},{whole},true]\n")).collect();
    let lines = lines + &numbers.iter().map(|(v, digits)| format!("[{v},{digits},false]\n")).collect::<String>();
    let mut node = Command::new("node");
    let mut node = node.args(["-e", script]).arg(shares).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    node.stdin.take().unwrap().write_all(lines.as_bytes()).unwrap();
    let said = String::from_utf8(node.wait_with_output().unwrap().stdout).unwrap();
    let said: Vec<&str> = said.lines().collect();
    for ((part, whole), words) in pairs.iter().zip(&said) {
        // By long division: the number of tenths of a percent, and whether half of one or more remains.
        let (tenths, rest) = (1000 * part / whole, 1000 * part % whole);
        let tenths = tenths + u64::from(2 * rest >= *whole);
        let wanted = match (*part, tenths) {
            (0, _) => "0 %".to_string(),
            (part, _) if part == *whole => "100 %".into(),
            (_, 0) => "< 0.1 %".into(),
            (_, 1000) => "> 99.9 %".into(),
            _ => format!("{}.{} %", tenths / 10, tenths % 10),
        };
        assert_eq!(*words, wanted.replace(' ', "\u{202F}"), "{part} of {whole}");
        assert_eq!(*words, skyshed_render::percent(*part, *whole), "{part} of {whole}");
    }
    let wanted = ["0.0312", "0.0938", "0.0000", "0.1963", "-0.0312", "2", "0.2"];
    assert_eq!(said[pairs.len()..], wanted);

    // On the page of a comparison too: 1 of 400 cells is 0.3 %, and 1 of 32 is 0.0312.
    let Some(driver) = driver() else { return };
    let folder = Folder::new();
    for (name, n_seen) in [("none.asc", 0), ("some.asc", 13)] {
        let cells: Vec<u8> = (0..416).map(|k| u8::from(k < n_seen)).collect();
        folder.write(name, &crate::texts::grid(&cells, 26, 255));
    }
    folder.type_in("compare none.asc --ground 0 --mask none.asc --mask some.asc -o c.html -q").done();
    let look = json!({"ask": "[document.getElementById('share-b').textContent, \
        document.querySelector('[data-pair=\"2\"]').textContent]"});
    let script = [json!({"open": "#a=none&b=some&layers=difference"}), look];
    let page = &steps(&driver, &folder.word("c.html"), DESK, &script)[0];
    // 13 of 416 are 1 of 32: 3.125 %.
    assert!(page[0].as_str().unwrap().ends_with("0.0312"), "{page}");
    assert_eq!(page[1], "3.1\u{202F}%");
}

#[test]
fn a_browser_without_vectors_is_told_to_be_too_old() {
    let Some(driver) = driver() else { return };
    let folder = Folder::new();
    folder.type_in("live itu:urban --size 100 -o page.html -q").done();
    let script = [
        json!({"before": "WebAssembly.validate = () => false"}),
        json!({"open": ""}),
        json!({"ask": "document.getElementById('progress-words').textContent"}),
    ];
    let words = steps(&driver, &folder.word("page.html"), DESK, &script);
    assert!(words[0].as_str().is_some_and(|words| words.contains("2023")), "{words:?}");
}
