//! Families of scenes where methods fail: the truth about them is that of the oracle, exact engines are right on all of
//! them, approximate ones are not; and the command says so.

use num_bigint::BigInt;
use num_rational::Ratio;
use rayon::prelude::*;
use serde_json::Value;
use skyshed_core::quantity::{LatticePoint, VOID};
use skyshed_study::accuracy::stress::{
    AtRisk, Contender, Effort, FAMILIES, Family, FamilyScore, Outcome, Ready, StressScene, StressSolid, Symmetry,
    check_exact, stress, truth,
};

use crate::oracle;
use crate::program::Folder;
use crate::refusals::{check_flags_are_known, check_refusals};
use crate::support::{Random, is_long};

fn contenders(names: &[&str]) -> Vec<Contender> {
    names.iter().map(|name| Contender::of(name.parse().unwrap())).collect()
}

/// Whether the antenna of a scene serves a receiver: wedges of 45° by which side of their edges it is on.
fn is_served(scene: &StressScene, receiver: LatticePoint) -> bool {
    const EDGES: [(i64, i64); 9] = [(0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1), (-1, 0), (-1, 1), (0, 1)];
    let Some(served) = scene.served else { return true };
    let (x, y) = (receiver.x - scene.uav.x, receiver.y - scene.uav.y);
    let squared = x * x + y * y;
    // Straight below is to the north.
    let (x, y) = if squared == 0 { (0, 1) } else { (x, y) };
    let to_the_right = |(along_x, along_y): (i64, i64)| x * along_y - y * along_x;
    let wedge = (0..8).find(|k| to_the_right(EDGES[*k]) >= 0 && to_the_right(EDGES[k + 1]) < 0).unwrap();
    let [from, to] = served.eighths.map(|eighth| usize::try_from(eighth).unwrap());
    let is_in_sector = if from < to { (from..to).contains(&wedge) } else { wedge >= from || wedge < to };
    let fall = scene.uav.z - receiver.z;
    is_in_sector && squared >= (1024 * served.least).pow(2) && !(served.is_flat && fall > 0 && fall.pow(2) > squared)
}

/// The answer of the tests' own oracle.
fn by_oracle(scene: &StressScene, receiver: LatticePoint) -> bool {
    if !is_served(scene, receiver) {
        return false;
    }
    let (uav, receiver) = ([scene.uav.x, scene.uav.y, scene.uav.z], [receiver.x, receiver.y, receiver.z]);
    match &scene.solid {
        StressSolid::Columns { board, .. } => {
            // Lower by d²/p, to the nearest step.
            let fall = |x: i64, y: i64| {
                let squared = (x - uav[0]).pow(2) + (y - uav[1]).pow(2);
                scene.earth.map_or(0, |p| (Ratio::new(squared, p) + Ratio::new(1, 2)).floor().to_integer())
            };
            let middle = |k: usize| 1024 * i64::try_from(k).unwrap() + 512;
            let fall_of =
                |cell: usize| fall(middle(cell % board.n_cols), middle(board.n_rows - 1 - cell / board.n_cols));
            let lowered = |(cell, top): (usize, &i32)| (*top != VOID).then(|| i64::from(*top) - fall_of(cell));
            let heights = board.tops.iter().enumerate().map(lowered).collect();
            let columns = oracle::Columns { n_cols: board.n_cols, n_rows: board.n_rows, heights };
            let [x, y, z] = receiver;
            oracle::columns_los(&columns, uav, [x, y, z - fall(x, y)])
        }
        StressSolid::Prisms(prisms) => {
            let ring = |r: &Vec<[i32; 2]>| r.iter().map(|v| v.map(i64::from)).collect();
            let prism = |p: &skyshed_study::accuracy::stress::StressPrism| oracle::Prism {
                rings: p.rings.iter().map(ring).collect(),
                top: i64::from(p.top),
            };
            let moved = |(k, p): (usize, &skyshed_study::accuracy::stress::StressPrism)| {
                let prism = prism(p);
                oracle::Prism { top: prism.top + i64::from(scene.moved_by(k)), ..prism }
            };
            let prisms: Vec<_> = prisms.iter().enumerate().map(moved).collect();
            match scene.earth {
                None => oracle::prisms_los(&prisms, uav, receiver),
                Some(p) => {
                    let earth = oracle::Earth { drop: Ratio::new(BigInt::from(1), BigInt::from(p)), ground: Some(0) };
                    oracle::prisms_los_on_earth(&prisms, &earth, uav, receiver)
                }
            }
        }
        StressSolid::Roofs(roofs) => {
            // All positions are multiples of half a cell.
            let small = |[x, y, z]: [i64; 3]| {
                assert!(x % 512 == 0 && y % 512 == 0, "{}", scene.name);
                [x / 512, y / 512, z]
            };
            let roofs: Vec<_> =
                roofs.iter().flatten().map(|corners| corners.map(|v| small(v.map(i64::from)))).collect();
            oracle::sloped_los(&roofs, small(uav), small(receiver))
        }
    }
}

#[test]
fn the_truth_of_every_family_is_that_of_the_oracle() {
    let n_scenes = if is_long() { 40 } else { 4 };
    FAMILIES.par_iter().for_each(|family| {
        let (mut n, mut n_los) = (0, 0);
        for number in 0..n_scenes {
            let scene = family.scene(7, number).unwrap();
            let ready = scene.ready().unwrap();
            let answers = truth(&scene, &ready).unwrap();
            let mut random = Random(u64::from(number));
            for (k, (cell, receiver)) in ready.receivers.iter().enumerate().filter(|_| random.chance(15)) {
                assert_eq!(answers[k], by_oracle(&scene, *receiver), "{}, cell {cell}: {scene:?}", scene.name);
                n += 1;
                n_los += u32::from(answers[k]);
            }
        }
        assert!(n > 100 && n_los > 0 && n_los < n, "{}: {n_los} of {n}", family.name);
    });
}

fn decided(score: &FamilyScore, k: usize) -> Option<u64> {
    match &score.outcomes[k] {
        Outcome::Decided(wrong) => Some(wrong.total()),
        Outcome::Cannot(_) => None,
    }
}

#[test]
fn exact_engines_are_right_on_every_family_and_approximate_ones_fail_where_they_should() {
    let all = Contender::all();
    let families: Vec<&Family> = FAMILIES.iter().collect();
    let efforts: Vec<Effort> = if is_long() {
        (1..=3).map(|seed| Effort { scenes: 160, seed }).collect()
    } else {
        vec![Effort { scenes: 16, seed: 5 }]
    };
    for effort in efforts {
        for (family, score) in families.iter().zip(stress(&families, &all, effort).unwrap()) {
            let mut n_decided = 0;
            let mut n_failing = 0;
            for (k, method) in all.iter().enumerate() {
                let Some(wrong) = decided(&score, k) else { continue };
                n_decided += 1;
                if method.is_exact() {
                    assert_eq!(wrong, 0, "{} on {}: {:?}", method.name, family.name, score.outcomes[k]);
                } else {
                    n_failing += u32::from(wrong > 0);
                }
            }
            // Boards: all but `shadow`; footprints: `ray` and `shadow`.
            let (expected, fails) = match family.at_risk {
                AtRisk::Approximate => (9, true),
                AtRisk::ExactOnly => (2, false),
            };
            assert_eq!((n_decided, n_failing > 0), (expected, fails), "{}: {score:?}", family.name);
            assert!(score.los > 0 && score.los < score.receivers, "{score:?}");
        }
    }
}

#[test]
fn samples_of_a_ray_err_towards_line_of_sight_alone() {
    let steps = contenders(&["step:0.25", "step:1", "step:4"]);
    let families: Vec<&Family> = FAMILIES.iter().filter(|f| f.at_risk == AtRisk::Approximate).collect();
    let mut totals = [0; 3];
    for score in stress(&families, &steps, Effort { scenes: 6, seed: 2 }).unwrap() {
        for (total, outcome) in totals.iter_mut().zip(&score.outcomes) {
            let Outcome::Decided(wrong) = outcome else { panic!("{score:?}") };
            assert_eq!(wrong.false_nlos, 0, "{score:?}");
            *total += wrong.false_los;
        }
    }
    assert!(0 < totals[0] && totals[0] < totals[1] && totals[1] < totals[2], "{totals:?}");
}

#[test]
fn a_scene_is_a_function_of_its_seed_and_number() {
    for family in &FAMILIES {
        let scene = |seed: u64, number: u32| family.scene(seed, number).unwrap();
        assert_eq!(scene(1, 9), scene(1, 9));
        assert_ne!(scene(1, 9), StressScene { name: scene(1, 9).name, ..scene(2, 9) }, "{}", family.name);
        assert_ne!(scene(1, 9), StressScene { name: scene(1, 9).name, ..scene(1, 17) }, "{}", family.name);
    }
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let all = contenders(&["ray", "step:1", "r2"]);
        let families = [Family::named("cell-slots").unwrap(), Family::named("prism-mirrors").unwrap()];
        pool.install(|| stress(&families, &all, Effort { scenes: 9, seed: 3 }).unwrap())
    };
    assert_eq!(run(1), run(7));
}

/// The answers of a scene by the engine that its kind calls for, cell by cell, with the heights of the receivers.
fn seen(scene: &StressScene, ready: &Ready) -> Vec<Option<(i64, bool)>> {
    let options = scene.options();
    let seen =
        skyshed_core::coverage::Mapper::new(&ready.field, &options).unwrap().seen_from(&ready.uav).unwrap().seen();
    let mut answers = vec![None; scene.n_rows * scene.n_cols];
    for (cell, receiver) in &ready.receivers {
        answers[*cell] = Some((receiver.z, seen.los.contains(cell / scene.n_cols, cell % scene.n_cols)));
    }
    answers
}

#[test]
fn the_eight_images_of_a_scene_have_the_eight_images_of_its_answer() {
    for name in ["cell-mirrors", "prism-mirrors", "cell-slots", "cell-diagonals", "prism-walls", "prism-slivers"] {
        let family = Family::named(name).unwrap();
        for number in [0, 8, 16] {
            let original = family.scene(11, number).unwrap();
            let answers = seen(&original, &original.ready().unwrap());
            for k in 0..8 {
                let symmetry = Symmetry::number(k);
                let image = symmetry.of(&original);
                let mirrored = seen(&image, &image.ready().unwrap());
                let mut n_same = 0;
                for (cell, answer) in answers.iter().enumerate() {
                    let place = (cell / original.n_cols, cell % original.n_cols);
                    let (row, col) = symmetry.cell(place, (original.n_rows, original.n_cols));
                    // A receiver over the wall of two houses stands on the one to its north-east, in every image.
                    let found = mirrored[row * image.n_cols + col];
                    assert_eq!(found.is_some(), answer.is_some(), "{name} {number}, image {k}, {place:?}");
                    if found.map(|f| f.0) == answer.map(|a| a.0) {
                        assert_eq!(found, *answer, "{name} {number}, image {k}, {place:?}");
                        n_same += 1;
                    }
                }
                assert!(n_same * 10 > answers.len() * 9, "{n_same} of {}", answers.len());
            }
        }
    }
}

#[test]
fn a_wrong_known_answer_is_told() {
    let mut scene = Family::named("cell-cliffs").unwrap().scene(1, 0).unwrap();
    scene.known[0].is_los = !scene.known[0].is_los;
    let error = truth(&scene, &scene.ready().unwrap()).unwrap_err();
    assert_eq!((error.code().as_str(), error.kind().exit_code()), ("E601", 6), "{error}");
}

#[test]
fn an_exact_method_that_is_wrong_fails_the_check() {
    let methods = contenders(&["ray", "r2"]);
    let family = [Family::named("cell-slits").unwrap()];
    let mut scores = stress(&family, &methods, Effort { scenes: 2, seed: 1 }).unwrap();
    // An approximate one may be.
    assert!(decided(&scores[0], 1) > Some(0));
    check_exact(&methods, &scores).unwrap();
    scores[0].outcomes.swap(0, 1);
    let error = check_exact(&methods, &scores).unwrap_err();
    assert_eq!((error.code().as_str(), error.kind().exit_code()), ("E602", 6));
    assert!(error.to_string().contains("`ray`, which is exact, decides") && error.to_string().contains("cell-slits"));
}

/// Rows of a table as fields.
fn fields(table: &str) -> Vec<Vec<String>> {
    table.lines().skip(1).map(|line| line.split(',').map(str::to_string).collect()).collect()
}

#[test]
fn table_document_and_picture_hold_the_same_numbers() {
    let folder = Folder::new();
    let line = "stress --scenes 3 --seed 4 -o s.csv -o s.json -o s.png -o s.svg --json";
    let answer = folder.type_in(line).done();
    let document = answer.json();
    assert_eq!(document["schema"], "skyshed/stress/1");
    assert_eq!((&document["seed"], &document["scenes_per_family"]), (&Value::from(4), &Value::from(3)));
    let families = document["families"].as_array().unwrap();
    assert_eq!((families.len(), document["methods"].as_array().unwrap().len()), (FAMILIES.len(), 10));
    let rows = fields(&folder.text("s.csv"));
    assert_eq!(rows.len(), FAMILIES.len() * 10);
    let svg = folder.text("s.svg");
    for (k, row) in rows.iter().enumerate() {
        let family = &families[k / 10];
        let method = &family["methods"][k % 10];
        assert_eq!(
            (&family["family"], &method["method"]),
            (&Value::from(row[0].as_str()), &Value::from(row[1].as_str()))
        );
        assert_eq!(family["receivers"].to_string(), row[5]);
        if row[7].is_empty() {
            // Prose of a document, and no number anywhere.
            assert!(method["wrong"].is_null() && method["failure_rate"].is_null(), "{method}");
            assert_eq!(method["reason"], row[11].as_str());
            continue;
        }
        let [wrong, los, nlos] = ["wrong", "false_los", "false_nlos"].map(|key| method[key].as_u64().unwrap());
        assert_eq!(
            (wrong, [wrong, los, nlos].map(|n| n.to_string())),
            (los + nlos, [row[7].clone(), row[9].clone(), row[10].clone()])
        );
        let rate = 100.0 * wrong as f64 / row[5].parse::<f64>().unwrap();
        let shown = if wrong == 0 {
            "0".to_string()
        } else if rate >= 10.0 {
            format!("{rate:.0}")
        } else {
            String::new()
        };
        assert!(svg.contains(&format!(">{shown}")), "{row:?}");
    }
    assert_eq!(
        svg.matches(">0</text>").count(),
        rows.iter().filter(|row| row[7] == "0").count(),
        "zeros of the picture"
    );
    assert!(svg.contains(">Where methods fail<") && svg.contains("seed 4"), "{svg}");
    let is_told = |f: &Family| [f.name, f.happens].iter().all(|words| svg.contains(&format!(">{words}<")));
    assert!(FAMILIES.iter().all(is_told) && svg.contains(">Blank: the method does not take such scenes<"), "{svg}");
    // The same run gives the same bytes; the table goes to standard output where no file does.
    let again = folder.type_in("stress --scenes 3 --seed 4").done();
    assert_eq!(again.out, folder.text("s.csv"));
    assert!(
        again.err.contains("ray: 0 of ") && again.err.contains("step:1: ") && again.err.contains(", worst on cell-")
    );
    let quiet = folder.type_in("stress --scenes 3 --seed 4 -q -j 1").done();
    assert_eq!((quiet.out.as_str(), quiet.err.as_str()), (folder.text("s.csv").as_str(), ""));
    assert_eq!(folder.json("s.csv.json")["digest"], document["digest"]);
}

/// Flags that change the answer: a line without, and the flag.
const FLAGS: [(&str, &str); 29] = [
    ("--scenes 2", "--families cell-slits,prism-walls"),
    ("--families cell-slits", "--scenes 3"),
    ("--families cell-slits --scenes 2", "--seed 9"),
    ("--families cell-slits --scenes 2", "--method r2"),
    ("dsm.asc --ground 0 --uav 2.5,2.5,9", "--rx-height 0"),
    ("dsm.asc --ground 0 --uav 2.5,2.5,9", "--receivers all"),
    ("dsm.asc --ground 0 --uav 2.5,2.5,9", "--radius 2"),
    ("dsm.asc --ground 0 --uav 2.5,2.5,9", "--min-radius 2"),
    ("dsm.asc --ground 0 --uav 2.5,2.5,9", "--sector 0,90"),
    ("dsm.asc --ground 0 --uav 2.5,2.5,9", "--elevation -80,-70"),
    ("dsm.asc --ground 0 --uav 2.5,2.5,9", "--beam 20"),
    ("dsm.asc --ground 0 --uav 2.5,2.5,9", "--slant-range 9"),
    ("dsm.asc --ground 0 --uav 2.5,2.5,9", "--earth-k 4/3"),
    ("dsm.asc --ground 0 --uav 2.5,2.5,9", "--curvature-coefficient 0.75"),
    ("dsm.asc --uav 2.5,2.5,9", "--ground 0"),
    ("dsm.asc --uav 2.5,2.5,9", "--terrain low.asc"),
    ("dsm.asc --ground 0 --uav 2.5,2.5,9", "--building-threshold 5"),
    ("dsm.asc --ground 0 --uav 2.5,2.5,9", "--nodata-as block"),
    ("dsm.asc --ground 0 --uav 2.5,2.5,9", "--crs EPSG:25832"),
    ("a.geojson --uav 2,2,9 --missing drop", "--height-field tall"),
    ("a.geojson --uav 2,2,9 --missing drop --ground 0", "--top-field top"),
    ("a.geojson --uav 2,2,9", "--missing levels"),
    ("a.geojson --uav 2,2,9 --missing drop", "--height-unit ft"),
    ("a.geojson --uav 2,2,9 --missing drop", "--extent 0,0,5,5"),
    ("a.geojson --uav 2,2,9 --missing drop", "--cell 0.5"),
    ("a.geojson --uav 2,2,9 --missing drop", "--swap-axes"),
    ("itu:urban --uav 9,9,50", "--size 100"),
    ("a.geojson --missing drop", "--uav 2,2,9"),
    ("a.geojson --uav 2,2,9 --missing drop", "--method ray"),
];

/// Flags that change no answer; other tests show what they do.
const OTHER: &str = "--roofs --band --height-error-field --base --data-area --width --dpi --repairs --project --levels-field --base-field --parts --layer --quiet --hash \
    --overwrite --json --output --threads --title --attribution --max-memory --csv-text --help --version";

fn scenes() -> Folder {
    let folder = Folder::new();
    let grid =
        |cells: &str| format!("ncols 5\nnrows 5\nxllcorner 0\nyllcorner 0\ncellsize 1\nNODATA_value -9999\n{cells}");
    folder.write("dsm.asc", &grid("0 0 0 0 0\n0 3 0 8 0\n0 3 0 -9999 0\n0 0 9 0 0\n0 0 0 0 0\n"));
    folder.write("low.asc", &grid("0 0 0 0 0\n0 0 0 1 0\n0 0 0 0 0\n0 0 0 0 0\n0 0 0 0 -3\n"));
    folder.write(
        "a.geojson",
        r#"{"type":"FeatureCollection","features":[
        {"type":"Feature","properties":{"height":5,"tall":8,"top":6},"geometry":{"type":"Polygon",
        "coordinates":[[[4,4],[6,4],[6,7],[4,7],[4,4]]]}},
        {"type":"Feature","properties":{"building:levels":2,"tall":3,"top":4},"geometry":{"type":"Polygon",
        "coordinates":[[[0,8],[9,8],[9,9],[0,9],[0,8]]]}}]}"#,
    );
    folder
}

#[test]
fn every_flag_of_stress_changes_what_is_answered() {
    let folder = scenes();
    // Nothing where the line alone is refused.
    let found = |line: &str| {
        let answer = folder.type_in(&format!("stress {line} --json -q"));
        let mut document = serde_json::from_str::<Value>(&answer.out).ok()?;
        ["command", "timing_s"].iter().for_each(|key| drop(document.as_object_mut().unwrap().remove(*key)));
        Some(document)
    };
    for (line, flag) in FLAGS {
        let with = found(&format!("{line} {flag}"));
        assert!(with.is_some() && with != found(line), "{line} {flag}");
    }
    let help = folder.type_in("stress --help").done().out;
    assert!(help.contains("[SCENE]") && help.contains("[default: 128]"), "{help}");
    check_flags_are_known(&folder, "stress", &[&FLAGS.map(|(_, flag)| flag)[..], &[OTHER]].concat());
}

#[test]
fn what_makes_no_sense_is_refused() {
    let folder = scenes();
    folder.write("old.csv", "mine");
    check_refusals(
        &folder,
        "stress",
        &[
            ("--uav 1,1,9", "E101", "<SCENE>"),
            ("--cell 2", "E116", "`--cell`"),
            ("--radius 5", "E116", "`--radius`"),
            ("--attribution me -o a.png", "E116", "`--attribution`"),
            ("--title Failures -o a.csv", "E116", "`--title`"),
            ("dsm.asc --uav 1,1,9 --scenes 3", "E101", "'--scenes"),
            ("dsm.asc --uav 1,1,9 --families cell-slits", "E101", "'--families"),
            ("dsm.asc", "E101", "--uav"),
            ("--families cell-slit", "E101", "`--families cell-slit`: wanted one of"),
            ("--scenes 0", "E101", "'--scenes <N>'"),
            ("--threads 0", "E101", "'--threads <N>'"),
            ("-o a.tif", "E105", "a.tif"),
            ("--scenes 1 -o old.csv", "E106", "old.csv"),
            ("dsm.asc --ground 0 --uav 1.5,2.5,1", "E201", "`1`"),
            ("dsm.asc --uav 1,1,9 --max-memory 100", "E501", ""),
            ("missing.asc --uav 1,1,9", "E301", "missing.asc"),
        ],
    );
    folder.type_in("stress --scenes 1 -o old.csv --overwrite -q").done();
    assert!(folder.text("old.csv").starts_with("family,method,exact,"));
    folder.type_in("stress --scenes 1 -o t.svg --title Ties -q").done();
    assert!(folder.text("t.svg").contains(">Ties<"));
    folder.type_in("stress a.geojson --missing drop --uav 2,2,9 -o c.svg --attribution Surveyors -q").done();
    assert!(folder.text("c.svg").contains(">Surveyors<"));
}
