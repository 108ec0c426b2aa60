//! Hints lead somewhere: the command or flag that each names is typed, and works. `tests/hints.txt` says how each comes about
//! and what is typed then; the sources say which hints there are.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use skyshed::prelude::*;

use crate::hint_inputs::inputs;
use crate::needs::has_program;
use crate::program::{Answer, Folder};
use crate::support::Random;

/// Hints, or commands in them, that no line of `tests/hints.txt` follows, and why.
const NOT_RUN: [(&str, &str); 14] = [
    ("`ogr2ogr {converted} {}`", "only a build without GeoPackage says so"),
    ("`fcb deser -i {file} -o {}`", "fcb is in no package of a distribution"),
    ("`cjseq collect < {} > {}`", "cjseq is in no package of a distribution"),
    ("gdal_translate -co TILED=YES -co COMPRESS=DEFLATE -co BIGTIFF=IF_SAFER", "a block of more than 4 GiB"),
    (
        "`pdal translate {file} {made} -f reprojection --filters.reprojection.out_srs=EPSG:{epsg}`",
        "PDAL is no part that the tests need",
    ),
    ("`gdalwarp -t_srs EPSG:HORIZONTAL+VERTICAL IN OUT`", "needs a grid of the geoid, which GDAL does not bring"),
    ("`--layers los,margin,ceiling`", "for callers of the library: the program refuses such layers before"),
    ("choose larger cells: `--cell {cell_m}`", "seconds for 17 million cells in another system; tried by hand"),
    ("`-j N`", "needs a machine that gives no threads"),
    ("`ulimit -u`", "the same"),
    ("`--radius` and `--cell` too", "says in which unit flags are, not what to type"),
    ("`{name}`", "no hint but names in one"),
    ("`--missing drop`, or `--missing median`", "of buildings in memory: python/tests/test_hints.py"),
    ("`--missing median`", "the same"),
];

/// What `{WARP}` stands for in the sources of hints.
const WARP: &str = "gdalwarp -ot Float32 -dstnodata -9999";

/// Lines, and what is typed after the hint that the last of them brings about.
struct Case {
    /// Where it begins in the file, counted from 1.
    line: usize,
    typed: Vec<String>,
    hints: Vec<Followed>,
}

struct Followed {
    line: usize,
    /// A part of a hint as its source has it.
    part: String,
    then: Vec<(Then, String)>,
}

/// What a line does about a hint.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Then {
    /// It does what the hint says.
    Follows,
    /// And there is no warning any more.
    Silences,
    /// It leaves out what the hint names.
    LeavesOut,
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn cases() -> Vec<Case> {
    let text = std::fs::read_to_string(root().join("tests/hints.txt")).expect("the hints");
    let mut cases: Vec<Case> = Vec::new();
    for (k, text) in text.lines().enumerate().filter(|(_, text)| !text.is_empty() && !text.starts_with('#')) {
        let line = k + 1;
        let (sign, rest) = text.split_once(' ').unwrap_or_else(|| panic!("line {line}: `{text}`"));
        let last = cases.last_mut();
        match (sign, last) {
            ("$", Some(case)) if case.hints.is_empty() => case.typed.push(rest.into()),
            ("$", _) => cases.push(Case { line, typed: vec![rest.into()], hints: Vec::new() }),
            ("?", Some(case)) => {
                case.hints.push(Followed { line, part: rest.replace("{WARP}", WARP), then: Vec::new() })
            }
            (_, Some(case)) => {
                let then = match sign {
                    ">" => Then::Follows,
                    ">!" => Then::Silences,
                    ">-" => Then::LeavesOut,
                    _ => panic!("line {line}: `{text}`"),
                };
                let hint = case.hints.last_mut().unwrap_or_else(|| panic!("line {line}: no hint before it"));
                hint.then.push((then, rest.into()));
            }
            _ => panic!("line {line}: `{text}`"),
        }
    }
    cases
}

/// A text as the source of a hint has it: words, and braces for what is filled in.
struct Pattern<'a> {
    /// What stands between the braces.
    words: Vec<&'a str>,
}

impl<'a> Pattern<'a> {
    /// Names of files may hold braces that stay.
    const KEPT: [&'static str; 3] = ["{site}", "{row}", "{col}"];

    fn of(text: &'a str) -> Pattern<'a> {
        let (mut words, mut begin, mut at) = (Vec::new(), 0, 0);
        while let Some(open) = text[at..].find('{').map(|k| at + k) {
            let close = text[open..].find('}').map_or(text.len(), |k| open + k + 1);
            if !Pattern::KEPT.contains(&&text[open..close]) {
                words.push(&text[begin..open]);
                begin = close;
            }
            at = close;
        }
        words.push(&text[begin..]);
        Pattern { words }
    }

    /// Where it stands in a text; what is filled in between backticks holds none.
    fn range_in(&self, text: &str) -> Option<std::ops::Range<usize>> {
        let words = if self.words[0].is_empty() { &self.words[1..] } else { &self.words[..] };
        let first = words.first()?;
        text.match_indices(first).find_map(|(begin, _)| {
            let mut end = begin + first.len();
            let mut is_quoted = first.matches('`').count() % 2 == 1;
            for word in &words[1..] {
                let gap = text[end..].find(word).filter(|gap| !is_quoted || !text[end..end + gap].contains('`'))?;
                end += gap + word.len();
                is_quoted ^= word.matches('`').count() % 2 == 1;
            }
            Some(begin..end)
        })
    }
}

/// The first piece in backticks.
fn piece_in(text: &str) -> Option<&str> {
    text.split('`').nth(1).filter(|_| text.matches('`').count() > 1)
}

/// Whether a word is one of the alternatives of another, in which capital letters, α, β and γ stand for anything.
fn is_word_of(wanted: &str, word: &str) -> bool {
    let one_of = |wanted: &str| {
        let stands_for = |c: char| c.is_ascii_uppercase() || ('α'..='γ').contains(&c);
        let wanted = wanted.replace("EPSG:n", "EPSG:N").replace(stands_for, "*");
        let mut rest = word;
        wanted.split('*').filter(|part| !part.is_empty() && *part != ",").all(|part| match rest.find(part) {
            Some(at) => {
                rest = &rest[at + part.len()..];
                true
            }
            None => false,
        }) && (wanted.ends_with('*') || rest.is_empty())
    };
    wanted.split('|').any(one_of)
}

/// Whether a line holds a piece literally; what its capital letters stand for is spelled out, and `…` stands for any words.
fn holds(line: &str, piece: &str) -> bool {
    let words: Vec<&str> = line.split_whitespace().collect();
    let wanted: Vec<&str> = piece.split_whitespace().collect();
    fn begins(words: &[&str], wanted: &[&str]) -> bool {
        match (words, wanted) {
            (_, []) => true,
            (_, ["…", wanted @ ..]) => (0..=words.len()).any(|n| begins(&words[n..], wanted)),
            ([], _) => false,
            ([word, words @ ..], [first, wanted @ ..]) => is_word_of(first, word) && begins(words, wanted),
        }
    }
    line.contains(piece) || (0..words.len()).any(|k| begins(&words[k..], &wanted))
}

/// Whether a line runs another program than this one.
fn is_of_others(line: &str) -> bool {
    ["gdal", "ogr", "bunzip2 ", "bzip2 ", "cp ", "rm ", "mkdir ", "mkfifo "].iter().any(|name| line.starts_with(name))
}

/// Whether a file is among the words of lines, or of what they read.
fn is_named(name: &str, text: &str) -> bool {
    let folder = name.split_once('/').map(|(folder, _)| folder);
    let ends = |c: char| c.is_whitespace() || ['=', '<', '>', '/'].contains(&c);
    text.split(ends).any(|word| Some(word) == folder || folder.is_none() && word == name)
}

/// The files that lines read, in a folder of their own.
fn folder_for(lines: &[&str]) -> Folder {
    let folder = Folder::new();
    let mut text = lines.join("\n");
    if ["computed.vrt", "turned.vrt", "gaps.vrt"].iter().any(|vrt| text.contains(vrt)) {
        text += " wall.asc";
    }
    for (name, bytes) in inputs().iter().filter(|(name, _)| is_named(name, &text)) {
        let path = folder.join(name);
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        std::fs::write(path, bytes).expect("a file");
    }
    folder
}

/// What a line leaves: whether it succeeded, and what it said.
fn run(folder: &Folder, line: &str) -> (bool, String) {
    if is_of_others(line) {
        let done = Command::new("sh").args(["-c", line]).current_dir(folder.path()).output().expect("a shell");
        return (done.status.success(), String::from_utf8_lossy(&done.stderr).into_owned());
    }
    let Answer { status, err, .. } = folder.type_in(line.strip_prefix("skyshed").unwrap_or(line));
    (status.success(), err)
}

/// The lines that say what to do.
fn hints_in(err: &str) -> String {
    let hints = err
        .lines()
        .filter_map(|line| line.strip_prefix("hint: ").or_else(|| line.starts_with("warning[").then_some(line)));
    hints.collect::<Vec<_>>().join("\n")
}

/// All paths below a folder.
fn paths(folder: &Path) -> BTreeSet<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("a folder").flatten();
    entries
        .flat_map(|entry| {
            let below = if entry.path().is_dir() { paths(&entry.path()) } else { BTreeSet::new() };
            below.into_iter().chain([entry.path()])
        })
        .collect()
}

/// Follows a hint that was printed.
fn follow(folder: &Folder, hint: &Followed, said: &str) -> Result<(), String> {
    let hints = hints_in(said);
    let found = Pattern::of(&hint.part).range_in(&hints).ok_or_else(|| format!("no such hint: {said}"))?;
    let piece = piece_in(&hints[found.clone()]).unwrap_or_default();
    let of_warning = hints[..found.start].lines().last().unwrap_or_default().get(..13).unwrap_or_default();
    for (then, line) in &hint.then {
        let line = line.replace("{}", piece);
        let of_inputs = || inputs().iter().filter(|(name, _)| is_named(name, &line));
        let follows = hint.then.iter().any(|(_, line)| line.contains("{}") || holds(line, piece))
            || of_inputs().any(|(_, bytes)| String::from_utf8_lossy(bytes).contains(piece));
        let is_left_out = !line.split_whitespace().any(|word| piece.split_whitespace().next() == Some(word));
        if !(if *then == Then::LeavesOut { is_left_out } else { follows }) {
            return Err(format!("`{line}` does not follow `{piece}`"));
        }
        let (is_done, said) = run(folder, &line);
        if !is_done {
            return Err(format!("`{line}` does not work: {said}"));
        }
        if *then == Then::Silences && said.contains(of_warning) {
            return Err(format!("`{line}` is warned of as before: {said}"));
        }
    }
    Ok(())
}

/// Runs a case; what is wrong with it, line by line.
fn faults(case: &Case) -> Vec<String> {
    let then = case.hints.iter().flat_map(|hint| hint.then.iter().map(|(_, line)| line.as_str()));
    let lines: Vec<&str> = case.typed.iter().map(String::as_str).chain(then).collect();
    let folder = folder_for(&lines);
    let (last, before) = case.typed.split_last().expect("a line");
    for line in before {
        let (is_done, said) = run(&folder, line);
        if !is_done {
            return vec![format!("line {}: `{line}` does not work: {said}", case.line)];
        }
    }
    let (_, said) = run(&folder, last);
    let mut faults = Vec::new();
    for hint in &case.hints {
        let there = paths(folder.path());
        faults.extend(follow(&folder, hint, &said).err().map(|fault| format!("line {}: {fault}", hint.line)));
        // The next hint is followed where this one was not.
        paths(folder.path()).difference(&there).for_each(|path| drop(std::fs::remove_file(path)));
    }
    faults
}

#[test]
fn the_command_of_every_hint_works() {
    let cases = cases();
    let has_gdal = has_program("gdalwarp");
    let needs_gdal = |case: &Case| {
        let then = case.hints.iter().flat_map(|hint| hint.then.iter().map(|(_, line)| line));
        case.typed.iter().chain(then).any(|line| line.starts_with("gdal") || line.starts_with("ogr"))
            || case.hints.iter().any(|hint| hint.part.contains("`{command}`"))
    };
    let has_bzip2 = Command::new("bzip2").arg("--help").output().is_ok();
    let needs_bzip2 = |case: &Case| case.typed.iter().any(|line| line.starts_with("bzip2"));
    let can_run = |case: &&Case| (has_gdal || !needs_gdal(case)) && (has_bzip2 || !needs_bzip2(case));
    let wanted: Vec<&Case> = cases.iter().filter(can_run).collect();
    assert!(wanted.len() > 100, "{}", wanted.len());
    let (next, found) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    std::thread::scope(|scope| {
        for _ in 0..3 {
            scope.spawn(|| {
                while let Some(case) = wanted.get(next.fetch_add(1, Ordering::Relaxed)) {
                    found.lock().unwrap().extend(faults(case));
                }
            });
        }
    });
    let found = found.into_inner().unwrap();
    assert!(found.is_empty(), "{}", found.join("\n"));
}

/// The string literals of a source, before its tests, without escapes.
fn literals(source: &str) -> Vec<String> {
    let source = source.split("#[cfg(test)]").next().unwrap_or_default();
    let mut literals = Vec::new();
    let mut chars = source.char_indices().peekable();
    while let Some((at, c)) = chars.next() {
        match c {
            '/' if source[at..].starts_with("//") => while chars.next_if(|(_, c)| *c != '\n').is_some() {},
            // A character in quotes is no beginning of a text.
            '\'' if source[at..].starts_with("'\"'") || source[at..].starts_with("'\\''") => drop(chars.nth(1)),
            '"' => {
                let mut literal = String::new();
                while let Some((_, c)) = chars.next().filter(|(_, c)| *c != '"') {
                    match (c, c == '\\') {
                        (_, true) => match chars.next() {
                            // The text goes on with the next line.
                            Some((_, '\n')) => while chars.next_if(|(_, c)| c.is_whitespace()).is_some() {},
                            Some((_, escaped)) => literal.push(escaped),
                            None => {}
                        },
                        (c, _) => literal.push(c),
                    }
                }
                literals.push(literal);
            }
            _ => {}
        }
    }
    literals
}

/// The sources below a folder.
fn sources(folder: &str) -> Vec<(String, String)> {
    let all = paths(&root().join(folder));
    let rust = all.iter().filter(|path| path.extension().is_some_and(|e| e == "rs"));
    rust.map(|path| (path.display().to_string(), std::fs::read_to_string(path).expect("a source"))).collect()
}

/// The texts of all hints of the command line.
fn hints_of_sources() -> Vec<String> {
    let mut hints = Vec::new();
    for (path, source) in sources("src/cli/hints").iter().filter(|(path, _)| !path.ends_with("caller.rs")) {
        assert!(source.len() > 100, "{path}");
        hints.extend(literals(source).into_iter().map(|literal| literal.replace("{WARP}", WARP)));
    }
    for (_, source) in sources("src/cli") {
        for (at, call) in source.match_indices("refusal_with(") {
            let rest = &source[at + call.len()..];
            let end = rest.find(");").or_else(|| rest.find(")\n")).unwrap_or(rest.len());
            hints.extend(literals(&rest[..end]).pop());
        }
    }
    hints.sort();
    hints.dedup();
    hints
}

#[test]
fn every_hint_that_names_a_command_is_followed() {
    let cases = cases();
    let parts: Vec<&str> = cases.iter().flat_map(|case| &case.hints).map(|hint| hint.part.as_str()).collect();
    let hints = hints_of_sources();
    // A part of several hints says of none that it is followed, unless it is all of one.
    let is_of = |part: &str, hint: &str| {
        part == hint || hint.contains(part) && hints.iter().filter(|hint| hint.contains(part)).count() == 1
    };
    let is_not_run =
        |hint: &str, piece: &str| NOT_RUN.iter().any(|(part, _)| hint.contains(part) && part.contains(piece));
    let mut n_pieces = 0;
    let mut open = Vec::new();
    for hint in &hints {
        let ticks: Vec<usize> = hint.match_indices('`').map(|(at, _)| at).collect();
        assert!(ticks.len().is_multiple_of(2), "one backtick of a pair: {hint}");
        for pair in ticks.chunks_exact(2) {
            n_pieces += 1;
            let piece = &hint[pair[0]..=pair[1]];
            let begins_here = |part: &&str| {
                let first = part.find('`').unwrap_or_default();
                is_of(part, hint) && hint.match_indices(*part).any(|(at, _)| at + first == pair[0])
            };
            if !parts.iter().any(begins_here) && !is_not_run(hint, piece) {
                open.push(format!("{piece} of {hint:?}"));
            }
        }
        // Commands stand in backticks, here or around this text, so that a reader sees where they end.
        let is_command = ["gdal", "ogr"].iter().any(|name| hint.starts_with(name));
        if is_command && !parts.iter().any(|part| part.contains(hint.as_str())) && !is_not_run(hint, "") {
            open.push(format!("the command {hint:?}"));
        }
        let outside: String = hint.split('`').step_by(2).collect();
        let is_bare = |word: &str| word.starts_with("--") || word.starts_with("gdal") || word.starts_with("ogr2");
        if !is_command && outside.split_whitespace().any(is_bare) {
            open.push(format!("a command without backticks in {hint:?}"));
        }
    }
    assert!(
        open.is_empty(),
        "{} of {n_pieces} are followed by no line of tests/hints.txt:\n{}",
        open.len(),
        open.join("\n")
    );
    assert!(n_pieces > 150, "{n_pieces}");
    // What is not run is there at all.
    for (part, why) in NOT_RUN {
        assert!(hints.iter().any(|hint| hint.contains(part)), "{part}: {why}");
    }
}

/// The heights that a hint offers.
fn offered(hint: &str) -> Vec<Height> {
    let heights = hint
        .split('`')
        .skip(1)
        .step_by(2)
        .filter(|piece| piece.starts_with(|c: char| c.is_ascii_digit() || c == '-') && !piece.starts_with("--"));
    heights.map(|piece| piece.parse().unwrap_or_else(|e| panic!("{hint}: {e}"))).collect()
}

#[test]
fn heights_that_hints_offer_are_short_and_work() {
    let folder = folder_for(&["town.geojson wall.asc hill.asc house.city.json"]);
    let scene = |name: &str, ground_m: Option<f64>| {
        let options = match ground_m {
            Some(ground_m) => Scene::options().ground(ground_m),
            None => Scene::options(),
        };
        options.open(folder.join(name)).expect("a scene")
    };
    let scenes = [
        (scene("town.geojson", Some(519.287)), 100.0),
        (scene("wall.asc", Some(-3.7)), 20.0),
        (scene("hill.asc", None), 20.0),
        (scene("house.city.json", None), 20.0),
    ];
    let mut random = Random(7);
    let mut n_offered = 0;
    for (scene, edge) in &scenes {
        for _ in 0..200 {
            let mut unit = || f64::from(u32::try_from(random.below(1 << 20)).unwrap()) / f64::from(1 << 20);
            let (x, y, number) = (unit() * edge, unit() * edge, unit() * 40.0 - 20.0);
            let height = match random.below(3) {
                0 => Height::agl(number),
                1 => Height::roof(number),
                _ => Height::amsl(number),
            };
            let place = |height| scene.coverage(Uav::new(x, y, height)).radius(1.0).run();
            let Err(error) = place(height) else { continue };
            let refusal = skyshed::cli::Refusal::from(error);
            let hint = refusal.hint.unwrap_or_else(|| panic!("no hint: {}", refusal.text));
            let examples = ["`150amsl`", "`30roof`"];
            let hint = examples.iter().fold(hint, |hint, example| hint.replace(example, "an example"));
            for offer in offered(&hint) {
                n_offered += 1;
                let text = offer.value().to_string();
                assert!(text.split_once('.').is_none_or(|(_, decimals)| decimals.len() == 1), "{hint}");
                if let Err(error) = place(offer) {
                    panic!("{height} at ({x}, {y}): {hint}: {error}");
                }
            }
        }
    }
    assert!(n_offered > 200, "{n_offered}");
}
