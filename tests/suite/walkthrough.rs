//! Every command of the walk-through runs, in its order, and writes what it names.

use std::path::Path;
use std::process::Command;

use crate::program::{Folder, run_in};
use crate::support::has_program;

/// The commands between fences of shell.
fn commands() -> Vec<String> {
    let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/walkthrough.md")).unwrap();
    let parts = text.split("```sh\n").skip(1).filter_map(|part| part.split("```").next());
    parts.flat_map(|part| part.lines().map(str::to_string).collect::<Vec<_>>()).collect()
}

#[cfg(unix)]
#[test]
fn every_command_of_the_walk_through_runs() {
    let folder = Folder::new();
    let maps = Path::new(env!("CARGO_MANIFEST_DIR")).join("maps");
    std::os::unix::fs::symlink(maps, folder.join("maps")).unwrap();
    let (mut n_run, mut n_files, mut before) = (0, 0, None);
    for line in commands() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[0] {
            "skyshed" => {
                // A line that stands there twice finds its work done.
                let is_again = Some(&line) == before.as_ref();
                let answer = run_in(folder.path(), &words[1..]).done();
                assert_eq!(is_again, answer.err.contains("0 UAVs mapped, 3 there already"), "{line}: {answer:?}");
                n_run += 1;
                for pair in words.windows(2).filter(|pair| pair[0] == "-o") {
                    let name = pair[1].replace("{site}", "square");
                    assert!(std::fs::metadata(folder.join(&name)).unwrap().len() > 0, "{line}");
                    n_files += 1;
                }
            }
            other if has_program(other) => {
                let answer = Command::new(other).args(&words[1..]).current_dir(folder.path()).output().unwrap();
                assert!(answer.status.success(), "{line}: {answer:?}");
                let said = String::from_utf8_lossy(&answer.stdout).into_owned();
                assert!(said.contains("25832") && !said.contains("rror"), "{line}: {said}");
            }
            _ => {}
        }
        before = Some(line);
    }
    assert!(n_run >= 17 && n_files >= 24, "{n_run} commands, {n_files} files");
}
