//! UAVs that come and go: shares of time, gaps, and counts between moments, against maps of those that are up.

use serde_json::json;

use crate::masks::npy;
use crate::program::Folder;
use crate::refusals::check_refusals;

const SCENE: &str = "itu:urban --size 200 --seed 3";

/// UAVs with their times \[min\]: minus infinity and infinity where they are open.
const UAVS: [(&str, &str, f64, f64); 5] = [
    ("a", "30.5,40.5,60", 0.0, 30.0),
    ("b", "150.5,160.5,70", 20.0, 50.0),
    ("c", "90.5,20.5,45", 50.0, f64::INFINITY),
    ("d", "20.5,180.5,50", f64::NEG_INFINITY, 10.0),
    ("e", "100.5,100.5,40", 70.0, 75.0),
];

/// A folder with the table of UAVs; `moment` tells minutes.
fn folder(moment: impl Fn(f64) -> String) -> Folder {
    let folder = Folder::new();
    let text = |m: f64| if m.is_finite() { moment(m) } else { String::new() };
    let row = |(id, place, from, to): &(&str, &str, f64, f64)| format!("{id},{place},{},{}\n", text(*from), text(*to));
    folder.write("uavs.csv", &("id,x,y,h,from,to\n".to_string() + &UAVS.iter().map(row).collect::<String>()));
    folder
}

fn in_minutes() -> Folder {
    folder(|m| m.to_string())
}

fn f32s(folder: &Folder, file: &str, name: &str) -> Vec<f32> {
    let (header, bytes) = npy(folder, file, name);
    assert!(header.contains("<f4"), "{header}");
    bytes.chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect()
}

#[test]
fn shares_of_time_and_gaps_are_those_of_single_masks() {
    let folder = in_minutes();
    for (range, min_unseen) in [("", 500), ("--radius 60", 100)] {
        let line = format!(
            "map {SCENE} --uavs uavs.csv {range} --layers los,uptime,gap -o m.npz --over-time t.json --overwrite -q"
        );
        folder.type_in(&line).done();
        let (_, masks) = npy(&folder, "m.npz", "los");
        let n_cells = masks.len() / UAVS.len();
        let (uptime, gap) = (f32s(&folder, "m.npz", "uptime"), f32s(&folder, "m.npz", "gap"));
        let (mut n_never, mut n_some) = (0, 0);
        for cell in 0..n_cells {
            let classes: Vec<u8> = (0..UAVS.len()).map(|k| masks[k * n_cells + cell]).collect();
            if !classes.iter().any(|class| *class <= 1) {
                assert!(uptime[cell].is_nan() && gap[cell].is_nan(), "cell {cell}");
                continue;
            }
            // Minute by minute: all times are whole minutes from 0 to 75.
            let sees = |k: usize, minute: f64| classes[k] == 1 && UAVS[k].2 <= minute && minute < UAVS[k].3;
            let seen: Vec<bool> = (0..75_u8).map(|m| (0..UAVS.len()).any(|k| sees(k, f64::from(m)))).collect();
            let n_seen = seen.iter().filter(|is| **is).count();
            let longest = seen.split(|is| *is).map(<[bool]>::len).max().unwrap_or(0);
            assert!((f64::from(uptime[cell]) - n_seen as f64 / 75.0).abs() < 1e-6, "cell {cell}: {}", uptime[cell]);
            assert!((f64::from(gap[cell]) - longest as f64).abs() < 1e-4, "cell {cell}: {}", gap[cell]);
            assert!(uptime[cell].is_sign_positive(), "cell {cell}: {}", uptime[cell]);
            n_never += usize::from(n_seen == 0);
            n_some += usize::from(n_seen > 0 && n_seen < 75);
        }
        let known: Vec<f64> = uptime.iter().filter(|share| !share.is_nan()).map(|share| f64::from(*share)).collect();
        let mean = known.iter().sum::<f64>() / known.len() as f64;
        let told = folder.json("t.json")["mean_share"].as_f64().unwrap();
        assert!((told - mean).abs() < 1e-6, "{told} {mean}");
        assert!(n_never > min_unseen && n_some > 1000, "{n_never} {n_some}");
    }
}

#[test]
fn rows_between_moments_count_what_a_map_of_the_uavs_that_are_up_counts() {
    let folder = in_minutes();
    for range in ["", "--radius 60"] {
        let line =
            format!("map {SCENE} --uavs uavs.csv {range} --over-time t.csv --over-time t.json --overwrite --json -q");
        let map = folder.type_in(&line).done().json();
        let document = folder.json("t.json");
        assert_eq!(document["schema"], "skyshed/over-time/1");
        assert_eq!(
            (&document["from"], &document["to"], &document["minutes"]),
            (&json!("0"), &json!("75"), &json!(75.0))
        );
        assert_eq!(document["receivers"], map["union"]["receivers"]);
        let rows = document["rows"].as_array().unwrap();
        let moments = [0.0, 10.0, 20.0, 30.0, 50.0, 70.0, 75.0];
        assert_eq!(rows.len(), moments.len() - 1);
        let mut weighted = 0.0;
        for (row, ends) in rows.iter().zip(moments.windows(2)) {
            let [from, to] = [ends[0], ends[1]];
            assert_eq!((&row["from"], &row["to"]), (&json!(from.to_string()), &json!(to.to_string())));
            let up: Vec<_> = UAVS.iter().filter(|(_, _, begin, end)| *begin <= from && to <= *end).collect();
            let names: Vec<&str> = up.iter().map(|(id, ..)| *id).collect();
            assert_eq!((&row["n_up"], &row["up"]), (&json!(up.len()), &json!(names.join("; "))));
            let flags: String = up.iter().map(|(_, place, ..)| format!(" --uav {place}")).collect();
            let alone = folder.type_in(&format!("map {SCENE}{flags} {range} --json -q")).done().json();
            for name in ["receivers", "los", "p_los"] {
                assert_eq!(row[name], alone["union"][name], "{name} from {from}");
            }
            let share = row["los"].as_f64().unwrap() / map["union"]["receivers"].as_f64().unwrap();
            assert_eq!(row["share"], share);
            weighted += share * (to - from) / 75.0;
        }
        assert!((document["mean_share"].as_f64().unwrap() - weighted).abs() < 1e-12);
        let csv = folder.text("t.csv");
        assert_eq!(csv.lines().count(), rows.len() + 1);
        assert!(csv.starts_with("from,to,minutes,n_up,up,receivers,los,p_los,share\n"), "{csv}");
        assert_eq!(folder.json("t.csv.json")["mean_share"], document["mean_share"]);
    }
}

#[test]
fn dates_are_times_too_and_names_of_one_clock() {
    let at = |m: f64| {
        let minutes: u32 = m.to_string().parse().unwrap();
        format!("2026-05-01T{:02}:{:02}:00+02:00", 14 + minutes / 60, minutes % 60)
    };
    let (dated, counted) = (folder(at), in_minutes());
    let line = format!("map {SCENE} --uavs uavs.csv --layers uptime,gap -o m.npz --over-time t.json -q");
    let [dated_at, counted_at] = [&dated, &counted].map(|folder| {
        folder.type_in(&line).done();
        folder.json("t.json")
    });
    assert_eq!(dated_at["mean_share"], counted_at["mean_share"]);
    assert_eq!(dated_at["rows"][1]["from"], "2026-05-01T12:10:00Z");
    let bits = |folder: &Folder| f32s(folder, "m.npz", "gap").into_iter().map(f32::to_bits).collect::<Vec<_>>();
    assert_eq!(bits(&dated), bits(&counted));
    // One UAV alone, and pictures and rasters of every format.
    let one = "id,x,y,h,from,to\na,30.5,40.5,60,10,20\n";
    counted.write("one.csv", one);
    let line = format!(
        "map {SCENE} --uavs one.csv --layers uptime -o m.png -o m.tif -o m.asc -o m.exr --over-time o.csv --json -q"
    );
    let map = counted.type_in(&line).done().json();
    assert_eq!(map["span"], json!({"from": "10", "to": "20", "minutes": 10.0}));
    assert_eq!(counted.text("o.csv").lines().count(), 2);
    let style = counted.text("m.qml");
    assert!(style.contains("minimumValue=\"0\""), "{style}");
    for layer in ["uptime", "gap"] {
        counted.type_in(&format!("map {SCENE} --uavs uavs.csv --layers {layer} -o {layer}.png -q")).done();
    }
}

#[test]
fn what_has_no_time_is_refused_in_words() {
    let folder = in_minutes();
    folder.write("never.csv", "x,y,h\n30,40,60\n");
    folder.write("once.csv", "x,y,h,from\n30,40,60,5\n");
    folder.write("backward.csv", "x,y,h,from,to\n30,40,60,20,10\n");
    folder.write("odd.csv", "x,y,h,from,to\n30,40,60,noon,\n");
    folder.write("mixed.csv", "id,x,y,h,from,to\na,30,40,60,1,2\nb,90,40,60,2026-05-01T14:00,\n");
    check_refusals(
        &folder,
        "map itu:urban --size 200",
        &[
            ("--uavs never.csv --layers uptime -o a.tif", "E116", "`from` and `to`"),
            ("--uavs once.csv --over-time a.csv", "E116", "`from` and `to`"),
            ("--uav 30,40,60 --layers gap -o a.tif", "E116", "`from` and `to`"),
            ("--uavs backward.csv --over-time a.csv", "E302", "wanted a time after 20"),
            ("--uavs odd.csv --over-time a.csv", "E302", "found `noon`"),
            ("--uavs mixed.csv --over-time a.csv", "E210", "wanted one clock"),
            ("--uavs uavs.csv --over-time a.png", "E105", "a.png"),
            ("--uavs uavs.csv --over-time a.csv -o a.csv", "E105", "a.csv"),
            ("--uavs uavs.csv --layers los,uptime -o {site}.npz", "E116", "single UAVs"),
            ("--uavs uavs.csv --shard 1/2 --over-time a.csv", "E116", "with a shard"),
            ("--uavs uavs.csv --layers uptime --tile-size 96 -o {row}_{col}.tif", "E116", "with tiles"),
        ],
    );
}
