//! What is typed into fields of the live page, or stands in its address, against what the program takes for it.

use serde_json::{Value, json};

use crate::live::{ask, driver, map};
use crate::live_claims::{DESK, steps};
use crate::needs::has_program;
use crate::program::Folder;

/// A phone in the dark.
const PHONE: &str = "390,844,dark";

/// A question for what a text in a field means.
fn read(field: &str, text: &str, (x, y): (f64, f64)) -> Value {
    json!({"do": "read", "field": field, "text": text, "x": x, "y": y})
}

/// What a height is above, and how high \[m\]; `None` where the program has to say why it cannot be.
type Meaning = Option<(&'static str, f64)>;

/// Heights as people type them. A foot is 0.3048 m.
const HEIGHTS: [(&str, Meaning); 22] = [
    ("120", Some(("agl", 120.0))),
    ("120agl", Some(("agl", 120.0))),
    ("400ft", Some(("agl", 121.92))),
    ("400 ft amsl", Some(("amsl", 121.92))),
    ("200ftagl", Some(("agl", 60.96))),
    ("150amsl", Some(("amsl", 150.0))),
    ("150 m amsl", Some(("amsl", 150.0))),
    ("1e2", Some(("agl", 100.0))),
    ("120.00049", Some(("agl", 120.00049))),
    (" 90 ", Some(("agl", 90.0))),
    ("10roof", None),
    ("-5", None),
    ("-5amsl", None),
    ("", None),
    ("junk", None),
    ("nan", None),
    ("inf", None),
    ("10 feet", None),
    ("1,5", None),
    ("−5", None),
    ("99999", None),
    ("120AGL", None),
];

#[test]
fn heights_mean_in_a_page_what_they_mean_to_the_program() {
    if !has_program("node") {
        return;
    }
    let folder = Folder::new();
    folder.type_in("live itu:urban --size 300 -o page.html -q").done();
    // A street, and a building on which some heights are inside.
    let street = HEIGHTS.iter().map(|(text, wanted)| ((150.0, 150.0), *text, *wanted));
    let roof = [("10roof", Some(("roof", 10.0))), ("-1roof", None), ("1", None), ("200", Some(("agl", 200.0)))];
    let cases: Vec<((f64, f64), &str, Meaning)> =
        street.chain(roof.map(|(text, wanted)| ((30.0, 30.0), text, wanted))).collect();
    let questions: Vec<Value> = cases.iter().map(|(place, text, _)| read("height", text, *place)).collect();
    let answers = ask(&folder.word("page.html"), None, &questions);
    for (((x, y), text, wanted), answer) in cases.iter().zip(&answers[1..]) {
        let uav = format!("{x},{y},{text}");
        let program = folder.run(&["map", "itu:urban", "--size", "300", "--uav", &uav, "--json", "-q"]);
        match wanted {
            Some((kind, m)) => {
                let value = &answer["value"];
                assert_eq!((&value["kind"], value["m"].as_f64()), (&json!(kind), Some(*m)), "{text}: {answer}");
                // The ground of a generated city is at 0.
                let site = &program.done().json()["sites"][0];
                let above = if *kind == "amsl" { "height_amsl_m" } else { "height_agl_m" };
                let found = site[above].as_f64().unwrap();
                assert!(*kind == "roof" || (found - m).abs() <= 0.5 / 1024.0, "{text}: {site}");
            }
            None => {
                let words = answer["words"].as_str().unwrap_or_else(|| panic!("{text}: {answer}"));
                assert_eq!(answer["ok"], false, "{text}");
                // On a command line a comma ends a number.
                let is_told = program.err.contains(words) || text.contains(',');
                assert!(program.code() != 0 && is_told, "{text}: {words}: {}", program.err);
            }
        }
    }
}

#[test]
fn numbers_mean_in_a_page_what_they_mean_to_the_program() {
    if !has_program("node") {
        return;
    }
    let folder = Folder::new();
    folder.type_in("live itu:urban --size 300 -o page.html -q").done();
    const NO: Option<Value> = None;
    let yes = Some::<Value>;
    // JavaScript writes 2 for 2.0.
    let numbers = |value: &Value| -> Vec<Option<f64>> {
        value.as_array().map_or_else(|| vec![value.as_f64()], |list| list.iter().map(Value::as_f64).collect())
    };
    let cases = [
        ("rx_height", "2", yes(json!(2.0))),
        ("rx_height", "5ft", yes(json!(1.524))),
        ("rx_height", "0", yes(json!(0.0))),
        ("rx_height", "-1", NO),
        ("rx_height", "40000", NO),
        ("rx_height", "tall", NO),
        ("rx_height", "", NO),
        ("radius", "250.5", yes(json!(250.5))),
        ("radius", "0", NO),
        ("radius", "-3", NO),
        ("radius", "400ft", NO),
        ("radius", "inf", NO),
        // The radius of the map is 200 m.
        ("radius", "20", NO),
        ("min_radius", "0", yes(json!(0.0))),
        ("min_radius", "200", yes(json!(200.0))),
        ("min_radius", "201", NO),
        ("min_radius", "-1", NO),
        ("slant_range", "90.5", yes(json!(90.5))),
        ("slant_range", "0", NO),
        ("sector", "20,200", yes(json!([20.0, 200.0]))),
        ("sector", "-20,30", yes(json!([-20.0, 30.0]))),
        ("sector", "20,20", NO),
        ("sector", "0,400", NO),
        ("sector", "20", NO),
        ("sector", "20,x", NO),
        ("elevation", "-80,-20", yes(json!([-80.0, -20.0]))),
        ("elevation", "5,-5", NO),
        ("elevation", "5,95", NO),
        ("beam", "360", yes(json!(360.0))),
        ("beam", "0", NO),
        ("beam", "361", NO),
        ("earth_k", "4/3", yes(json!(4.0 / 3.0))),
        ("earth_k", "1.5", yes(json!(1.5))),
        ("earth_k", "inf", yes(Value::Null)),
        ("earth_k", "0", NO),
        ("earth_k", "-1", NO),
        ("earth_k", "1/x", NO),
        ("earth_k", "1e-9", NO),
        ("height_error", "2.5", yes(json!(2.5))),
        ("height_error", "0", yes(Value::Null)),
        ("height_error", "-3", NO),
        ("height_error", "5000", NO),
    ];
    let mut base = map(&[(150.0, 150.0, 100.0)]);
    base["sight"]["radius"] = json!(200.0);
    base["sight"]["min_radius"] = json!(30.0);
    let mut questions = vec![base];
    questions.extend(cases.iter().map(|(field, text, _)| read(field, text, (150.0, 150.0))));
    // What limits nothing is empty.
    questions.extend(["radius", "sector", "beam", "earth_k"].map(|field| read(field, "", (150.0, 150.0))));
    questions.extend(["0", "-1", "x"].map(|text| read("search_radius", text, (150.0, 150.0))));
    let answers = ask(&folder.word("page.html"), None, &questions);
    let answers = &answers[2..];
    for ((field, text, wanted), answer) in cases.iter().zip(answers) {
        let flag = format!("--{}={text}", field.replace('_', "-"));
        let mut words = vec!["map", "itu:urban", "--size", "300", "--uav", "150,150,100", &flag, "--json", "-q"];
        if *field != "radius" {
            words.push("--radius=200");
        }
        if *field != "min_radius" {
            words.push("--min-radius=30");
        }
        let program = folder.run(&words);
        match wanted {
            Some(value) => {
                program.done();
                assert_eq!(answer["ok"], true, "{field} {text}: {answer}");
                assert_eq!(numbers(&answer["value"]), numbers(value), "{field} {text}: {answer}");
            }
            None => {
                let said = answer["words"].as_str().unwrap_or_else(|| panic!("{field} {text}: {answer}"));
                // The page reckons with any place of the UAV over the map.
                let said = said.split_once(" by ").filter(|_| *text == "1e-9").map_or(said, |(words, _)| words);
                assert!(program.code() != 0 && program.err.contains(said), "{flag}: {said}: {}", program.err);
            }
        }
    }
    let rest = &answers[cases.len()..];
    assert!(rest[..4].iter().all(|answer| answer["ok"] == true && answer["value"].is_null()), "{rest:?}");
    assert!(rest[4..].iter().all(|answer| answer["ok"] == false && answer["words"].is_string()), "{rest:?}");
}

#[test]
fn options_that_change_nothing_on_a_page_are_refused() {
    if !has_program("node") {
        return;
    }
    let folder = Folder::new();
    folder.type_in("live itu:urban --size 300 -o page.html -q").done();
    let asked = |sight: Value| {
        let mut map = map(&[(150.0, 150.0, 100.0)]);
        map["sight"] = sight;
        map
    };
    let wrong = [
        json!({"radiuss": 5}),
        json!({"method": "step:2"}),
        json!({"height_bias": 2}),
        json!({"earth_k": 1.2, "curvature_coefficient": 0.8}),
        json!({"radius": "far"}),
    ];
    let right = [json!({"radius": 90.0}), json!({"radius": 90.0, "method": null, "earth_k": null})];
    let questions: Vec<Value> = wrong.iter().chain(&right).cloned().map(asked).collect();
    let answers = ask(&folder.word("page.html"), None, &questions);
    for (asked, answer) in wrong.iter().zip(&answers[1..]) {
        let (name, said) = (asked.as_object().unwrap().keys().next_back().unwrap(), answer.to_string());
        assert!(answer.get("uavs").is_none() && (said.contains(name) || said.contains("far")), "{asked}: {said}");
    }
    let [one, other] = &answers[1 + wrong.len()..] else { panic!("{answers:?}") };
    assert!(one["uavs"][0]["receivers"].as_u64() > Some(0) && one["uavs"] == other["uavs"], "{one} {other}");
}

/// What is typed into a field either holds, or changes nothing and is told beside the field.
#[test]
fn what_is_typed_holds_or_is_told_beside_its_field() {
    let Some(driver) = driver() else { return };
    let folder = Folder::new();
    folder.type_in("live itu:urban --size 300 --uav 150,150,120 -o page.html -q").done();
    // Words beside a field are visible, right below it, and named as its description.
    let told = |id: &str| {
        json!({"ask": format!(
            "(() => {{ const input = document.getElementById('{id}'); \
             const words = document.getElementById(input.getAttribute('aria-describedby') ?? ''); \
             const [a, b] = [input, words].map((e) => e?.getBoundingClientRect()); \
             return {{ text: words?.textContent ?? '', invalid: input.getAttribute('aria-invalid'), value: input.value, \
               height: skyshed.state.uavs[0].height, sight: skyshed.state.sight, share: document.getElementById('share').textContent, \
               isBelow: !words || (b.top >= a.bottom - 1 && b.top < a.bottom + 12 && words.checkVisibility()), \
               fits: !words || (b.left >= 0 && b.right <= innerWidth) }}; }})()"
        )})
    };
    // On the phone the longest words alone.
    for (size, heights) in [(DESK, &HEIGHTS[..]), (PHONE, &HEIGHTS[10..13])] {
        let mut script = vec![json!({"open": ""})];
        for (text, _) in heights {
            script.extend([json!({"fill": ["#height", text]}), json!({"leave": "#height"}), told("height")]);
            script.extend([json!({"fill": ["#height", "120"]}), told("height")]);
        }
        let answers = steps(&driver, &folder.word("page.html"), size, &script);
        for ((text, wanted), pair) in heights.iter().zip(answers.chunks(2)) {
            let (typed, restored) = (&pair[0], &pair[1]);
            let agl = json!({"kind": "agl", "m": 120});
            let number = |height: &Value| (height["kind"].clone(), height["m"].as_f64());
            assert_eq!(
                (number(&restored["height"]), &restored["text"]),
                (number(&agl), &json!("")),
                "{text}: {restored}"
            );
            match wanted {
                Some((kind, m)) => {
                    assert_eq!(number(&typed["height"]), (json!(kind), Some(*m)), "{text}");
                    assert_eq!((&typed["text"], &typed["invalid"]), (&json!(""), &Value::Null), "{text}");
                }
                None => {
                    assert_eq!(
                        (number(&typed["height"]), &typed["share"]),
                        (number(&agl), &restored["share"]),
                        "{text}"
                    );
                    assert_eq!((&typed["invalid"], &typed["value"]), (&json!("true"), &json!(text)), "{text}");
                    assert!(typed["text"].as_str().unwrap().len() > 10, "{text}: {typed}");
                    assert_eq!(
                        (&typed["isBelow"], &typed["fits"]),
                        (&json!(true), &json!(true)),
                        "{size}: {text}: {typed}"
                    );
                }
            }
        }
    }
    // What was refused for the sake of another number is read again when that changes; Escape takes back what was typed.
    let fill = |id: &str, text: &str| {
        [json!({"fill": [format!("#{id}"), text]}), json!({"leave": format!("#{id}")}), told(id)]
    };
    let mut script = vec![json!({"open": ""}), json!({"click": "#sight summary"})];
    script.extend(
        ["radius", "min-radius", "radius"].into_iter().zip(["300", "500", "600"]).flat_map(|(id, text)| fill(id, text)),
    );
    script.extend([
        told("min-radius"),
        json!({"fill": ["#beam", "wide"]}),
        json!({"press": ["#beam", "Enter"]}),
        told("beam"),
    ]);
    script.extend([json!({"press": ["#beam", "Escape"]}), told("beam")]);
    let answers = steps(&driver, &folder.word("page.html"), DESK, &script);
    assert!(answers[1]["text"].as_str().unwrap().contains("at most the radius, 300 m"), "{}", answers[1]);
    assert_eq!(answers[1]["sight"]["min_radius"], Value::Null);
    assert_eq!((&answers[3]["text"], &answers[3]["sight"]["min_radius"]), (&json!(""), &json!(500)));
    assert!(answers[4]["text"].as_str().unwrap().contains("`wide`, which is not a number"), "{}", answers[4]);
    assert_eq!((&answers[5]["text"], &answers[5]["value"]), (&json!(""), &json!("")));
}

#[test]
fn another_reference_of_a_height_moves_no_uav() {
    let Some(driver) = driver() else { return };
    let folder = Folder::new();
    // A slope at heights that are no round numbers, with a house of 12.3 m in the middle.
    let ground = |row: u32, col: u32| 519.3467 + 0.731 * f64::from(row) + 0.113 * f64::from(col);
    let is_house = |row: u32, col: u32| (15..25).contains(&row) && (15..25).contains(&col);
    let raster = |top: &dyn Fn(u32, u32) -> f64| {
        let line = |row: u32| (0..40).map(|col| top(row, col).to_string()).collect::<Vec<_>>().join(" ");
        let rows: Vec<String> = (0..40).map(line).collect();
        format!("ncols 40\nnrows 40\nxllcorner 0\nyllcorner 0\ncellsize 1\n{}\n", rows.join("\n"))
    };
    folder.write("terrain.asc", &raster(&ground));
    folder.write("dsm.asc", &raster(&|row, col| ground(row, col) + if is_house(row, col) { 12.3 } else { 0.0 }));
    folder.type_in("live dsm.asc --terrain terrain.asc --uav 5.5,5.5,20 -o page.html -q").done();
    let digest = "new Promise((done) => { const look = () => (coverage.digest ? done(coverage.digest) : setTimeout(look, 50)); look(); })";
    let now = json!({"ask": format!("{digest}.then((digest) => [digest, skyshed.state.uavs[0].height])")});
    let choose = |kind: &str| json!({"choose": ["#height-kind", kind]});
    let reason = json!({"ask": "document.getElementById('height-reason')?.textContent"});
    let script = [
        json!({"open": ""}),
        now.clone(),
        choose("amsl"),
        now.clone(),
        choose("agl"),
        now.clone(),
        choose("roof"),
        reason,
        now,
    ];
    let answers = steps(&driver, &folder.word("page.html"), DESK, &script);
    // Above the datum it is higher by the ground, and just where it was.
    assert_eq!(answers[1][1]["kind"], "amsl");
    assert!(answers[1][1]["m"].as_f64() > Some(500.0), "{}", answers[1]);
    assert_eq!((&answers[0][0], &answers[2][1]["kind"]), (&answers[1][0], &json!("agl")));
    assert_eq!(answers[2][0], answers[0][0]);
    assert!((answers[2][1]["m"].as_f64().unwrap() - 20.0).abs() < 1.0 / 1024.0, "{}", answers[2]);
    // A street has no roof: that is told, and nothing changes.
    assert_eq!((&answers[3], &answers[4]), (&json!("No building is here to measure from."), &answers[2]));
}

#[test]
fn what_an_address_says_wrongly_is_told() {
    let Some(driver) = driver() else { return };
    let folder = Folder::new();
    folder.type_in("live itu:urban --size 300 --uav 150,150,100 -o page.html -q").done();
    let ask = json!({"ask": "[document.getElementById('toast-words').textContent, skyshed.state.uavs, skyshed.state.sight.radius]"});
    let open = |fragment: &str| [json!({"open": fragment}), ask.clone()];
    let wrong =
        ["#uavs=150,150,400ft,1", "#uavs=9150,150,80agl,1", "#sight=x,ground,", "#layer=all", "#sight=1.5,ground,-5"];
    let right = "#uavs=40,220,30roof,a;150,150,150amsl,b;150,160,90.5agl,c&sight=1.5,ground,100";
    let script: Vec<Value> = wrong.iter().copied().chain([right]).flat_map(open).collect();
    let answers = steps(&driver, &folder.word("page.html"), DESK, &script);
    for (fragment, answer) in wrong[..4].iter().zip(&answers) {
        assert!(answer[0].as_str().unwrap().contains(&fragment[1..]), "{fragment}: {answer}");
    }
    // The engine refuses what is read and cannot be, in the words of the program.
    assert_eq!((&answers[4][0], &answers[4][2]), (&json!("the radius is `-5`, wanted above 0 m"), &Value::Null));
    let heights: Vec<&Value> = answers[5][1].as_array().unwrap().iter().map(|uav| &uav["height"]).collect();
    let wanted =
        [json!({"kind": "roof", "m": 30}), json!({"kind": "amsl", "m": 150}), json!({"kind": "agl", "m": 90.5})];
    assert_eq!((heights, &answers[5][0]), (wanted.iter().collect(), &json!("")));
}
