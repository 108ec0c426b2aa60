//! What help says: its length, its examples, its defaults.

use crate::cli::scenes;
use crate::program::Folder;

/// All commands.
const COMMANDS: &str =
    "map link track city info zones limits plos place sample compare chart stress live jobs completions";

#[test]
fn help_and_version_are_answers() {
    let folder = Folder::new();
    let of_commands = COMMANDS.split(' ').map(|command| format!("{command} --help"));
    for line in ["--help", "-h", "help", "help map"].map(str::to_string).into_iter().chain(of_commands) {
        let answer = folder.type_in(&line).done();
        assert!(answer.out.contains("Usage: skyshed") && answer.err.is_empty(), "{line}: {answer:?}");
    }
    let help = folder.type_in("--help").out;
    assert!(COMMANDS.split(' ').all(|command| help.contains(&format!("\n  {command} "))), "{help}");
    for words in ["Exit codes: 0 done", "130 interrupted", "Examples:"] {
        assert!(help.contains(words), "{words}: {help}");
    }
    let version = format!("skyshed {}\n", env!("CARGO_PKG_VERSION"));
    for line in ["--version", "-V"] {
        let answer = folder.type_in(line).done();
        assert_eq!((answer.out.as_str(), answer.err.as_str()), (version.as_str(), ""));
    }
}

#[test]
fn the_examples_of_the_help_text_run() {
    let folder = scenes();
    std::fs::rename(folder.join("city.geojson"), folder.join("buildings.geojson")).expect("renamed");
    let help = folder.type_in("--help").out;
    let mut n_run = 0;
    for line in help.lines().filter_map(|line| line.trim().strip_prefix("skyshed ")) {
        // The third example names files of the reader's.
        if !line.contains("dsm.tif") {
            folder.type_in(line).done();
            n_run += 1;
        }
    }
    assert_eq!(n_run, 3, "{help}");
}

#[test]
fn help_names_defaults_with_their_units() {
    let folder = Folder::new();
    let help = folder.type_in("map --help").out;
    for (flag, unit, default) in [
        ("--rx-height <M>", "[m]", "1.5"),
        ("--building-threshold <M>", "[m]", "0.25"),
        ("--size <M>", "[m]", "1000"),
        ("--base <RULE>", "Terrain cell", "lowest"),
        ("--receivers <WHERE>", "receivers", "ground"),
        ("--nodata-as <WHAT>", "nodata", "clear"),
        ("--band <N|NAME>", "number from 1", "1"),
        ("--method <METHOD>", "", "auto"),
        ("--layers <LAYER,…>", "", "los"),
        ("--tif-layout <HOW>", ".tif", "cog"),
    ] {
        let text = &help[help.find(flag).unwrap_or_else(|| panic!("{flag}: {help}"))..];
        let text = &text[..text[2..].find("\n      --").map_or(text.len(), |end| end + 2)];
        assert!(text.contains(unit) && text.replace(':', "").contains(&format!("default {default}")), "{flag}: {text}");
    }
}

#[test]
fn short_help_fits_a_screen_and_its_example_runs() {
    let folder = Folder::new();
    let maps = format!("{}/maps", env!("CARGO_MANIFEST_DIR"));
    folder.write("walk.csv", "x,y\n450,450\n550,560\n");
    for command in COMMANDS.split(' ') {
        let help = folder.type_in(&format!("{command} -h")).done().out;
        assert!(help.lines().count() <= 40, "{command}: {} lines", help.lines().count());
        let example = help.split_once("Example: skyshed ").unwrap_or_else(|| panic!("{help}")).1;
        // A shell would write the answer to a file.
        let line = example.split(" > ").next().unwrap().replace("maps/", &format!("{maps}/"));
        folder.type_in(&line).done();
    }
    let listed = folder.type_in("-h").done().out;
    assert!(COMMANDS.split(' ').all(|command| listed.contains(&format!("\n  {command} "))), "{listed}");
}
