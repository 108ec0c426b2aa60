//! Every command of the manual runs, page by page, and writes what it names.

use std::path::Path;
use std::process::Command;

use crate::needs::has_program;
use crate::program::{Folder, run_in};
use crate::support::is_long;

fn page(name: &str) -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(name)).expect(name)
}

/// The commands of a page: the lines between fences of shell.
fn commands(page: &str) -> Vec<&str> {
    let parts = page.split("```sh\n").skip(1).filter_map(|part| part.split("```").next());
    parts.flat_map(str::lines).filter(|line| !line.is_empty() && !line.starts_with('#')).collect()
}

/// The words of a command, as a shell splits them: what stands between apostrophes is of one word.
fn words(command: &str) -> Vec<String> {
    let (mut words, mut is_quoted) = (vec![String::new()], false);
    for c in command.chars() {
        match c {
            '\'' => is_quoted = !is_quoted,
            ' ' if !is_quoted => words.push(String::new()),
            c => words.last_mut().expect("one at least").push(c),
        }
    }
    words.retain(|word| !word.is_empty());
    words
}

/// Parts of commands that take seconds and run in the long tests alone: they time all there is, or study many cities.
const HEAVY: [&str; 6] = [
    "--peers",
    "-o stress.png",
    "chart itu:urban --plos",
    "sample itu:high-rise",
    "-o azimuth.png",
    "-o three.geojson",
];

/// Runs the commands of a page in their order, in a folder that holds `maps/` and the buildings of `tests/lod2/`.
#[cfg(unix)]
fn run_page(name: &str, least: usize) {
    let folder = Folder::new();
    let maps = Path::new(env!("CARGO_MANIFEST_DIR")).join("maps");
    std::os::unix::fs::symlink(maps, folder.join("maps")).unwrap();
    std::fs::create_dir(folder.join("tests")).unwrap();
    let lod2 = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/lod2");
    std::os::unix::fs::symlink(lod2, folder.join("tests/lod2")).unwrap();
    let (page, mut n_run, mut n_left_out, mut before) = (page(name), 0, 0, None);
    for line in commands(&page) {
        let words = words(line);
        let (program, rest) = words.split_first().expect("a command");
        let rest: Vec<&str> = rest.iter().map(String::as_str).collect();
        if HEAVY.iter().any(|words| line.contains(words)) && !is_long() {
            n_left_out += 1;
            continue;
        }
        if program == "skyshed" {
            let answer = run_in(folder.path(), &rest).done();
            // A line that stands there twice finds its work done.
            assert_eq!(before == Some(line), answer.err.contains("0 UAVs mapped"), "{line}: {answer:?}");
            n_run += 1;
            for pair in rest.windows(2).filter(|pair| ["-o", "--map", "--height-curve", "--repairs"].contains(&pair[0]))
            {
                let name = pair[1].replace("{site}", "square").replace("{row}", "0").replace("{col}", "0");
                assert!(std::fs::metadata(folder.join(&name)).is_ok_and(|m| m.len() > 0), "{line}: {name}");
            }
        } else if has_program(program) {
            let answer = Command::new(program).args(&rest).current_dir(folder.path()).output().unwrap();
            let said = String::from_utf8_lossy(&answer.stdout);
            assert!(answer.status.success() && !said.contains("rror"), "{line}: {answer:?}");
            assert!(!program.starts_with("gdal") || said.contains("25832"), "{line}: {said}");
        }
        before = Some(line);
    }
    assert!(n_run + n_left_out >= least, "{name}: {n_run} commands, {n_left_out} left out");
}

#[cfg(unix)]
macro_rules! pages {
    ($($test:ident: $page:literal, $least:literal;)*) => {
        $(#[test]
        fn $test() {
            run_page(concat!("docs/", $page), $least);
        })*

        #[test]
        fn every_page_with_commands_is_run() {
            let run = [$($page),*];
            for entry in std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs")).unwrap().flatten() {
                let name = entry.file_name().to_string_lossy().into_owned();
                if name.ends_with(".md") && !run.contains(&name.as_str()) {
                    let page = page(&format!("docs/{name}"));
                    assert!(!commands(&page).iter().any(|line| line.starts_with("skyshed ")), "docs/{name} is not run");
                }
            }
        }
    };
}

#[cfg(unix)]
pages! {
    commands_page: "commands.md", 29;
    cities_page: "cities.md", 1;
    cluster_page: "cluster.md", 3;
    exactness_page: "exactness.md", 1;
    models_page: "models.md", 1;
    research_page: "research.md", 1;
    walkthrough_page: "walkthrough.md", 5;
}

/// Pictures hold the command that made them, and the files that it read.
#[test]
fn no_picture_of_the_pages_tells_of_a_folder_of_a_machine() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs");
    let mut n = 0;
    for entry in std::fs::read_dir(docs).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|ending| ending != "png") {
            continue;
        }
        let file = std::fs::read(&path).unwrap();
        let Some(begin) = file.windows(COMMAND.len()).position(|of| of == COMMAND) else { continue };
        let text: Vec<u8> = file[begin..].iter().copied().take_while(|b| *b >= b' ').collect();
        assert!(!text.windows(2).any(|pair| pair == b"\"/"), "{}", path.display());
        n += 1;
    }
    assert!(n > 10, "{n}");
}

/// Where a picture begins to tell of its command.
const COMMAND: &[u8] = b"\"command\":[";

#[test]
fn commands_of_the_readme_stand_in_the_manual() {
    let (readme, manual) = (page("README.md"), page("docs/commands.md"));
    let manual = commands(&manual);
    let in_gallery = readme.lines().filter_map(|line| line.strip_prefix('`')?.strip_suffix('`'));
    let in_gallery: Vec<&str> = in_gallery.filter(|command| command.starts_with("skyshed ")).collect();
    assert!(in_gallery.len() >= 10);
    for command in in_gallery {
        assert!(manual.contains(&command), "{command}");
    }
}
