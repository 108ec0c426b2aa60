//! Peaks of memory: what one run takes, measured in a process that has no other child.

use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};

use nix::sys::resource::{UsageWho, getrusage};

use crate::program::{Answer, Folder, wait};

/// What [`Folder::measured`] hands to a process of its own: the folder, the line, and where that writes what it found.
const MEASURED: [&str; 3] = ["SKYSHED_TEST_FOLDER", "SKYSHED_TEST_LINE", "SKYSHED_TEST_REPORT"];

impl Folder {
    /// Runs a line without a limit of memory; also its peak \[bytes\], as the system counts it.
    ///
    /// A system tells a peak of all children together. So this runs the test below in a process of its own, which has one child. A
    /// peak that is looked for from outside while the program runs misses what comes after the last look.
    pub(crate) fn measured(&self, line: &str) -> (Answer, u64) {
        let report = Folder::new();
        let values = [self.path().as_os_str(), line.as_ref(), report.path().as_os_str()];
        let own = std::env::current_exe().expect("the path of the tests");
        let mut command = Command::new(own);
        command.args(["--exact", "peaks::a_process_of_one_child_measures_its_peak"]);
        command.envs(MEASURED.into_iter().zip(values)).stdout(Stdio::null()).stderr(Stdio::null());
        assert!(command.status().expect("the tests start").success(), "{line}");
        let number = |name: &str| report.text(name).parse::<i64>().expect("a number");
        let status = ExitStatus::from_raw(i32::try_from(number("status")).expect("a status"));
        let answer = Answer::of(status, [report.text("out"), report.text("err")], 0.0);
        (answer, number("peak").try_into().expect("a number of bytes"))
    }
}

/// Measures the run that [`Folder::measured`] asks for; by itself, one that is known to fill 64 MB.
#[test]
fn a_process_of_one_child_measures_its_peak() {
    let [Some(folder), Some(line), Some(report)] = MEASURED.map(std::env::var_os) else {
        let (answer, peak) = Folder::new().measured("city itu:urban --size 4000 --cell 1 -o a.tif -q");
        answer.done();
        assert!((64_000_000..250_000_000).contains(&peak), "{peak}");
        return;
    };
    let mut command = Command::new(env!("CARGO_BIN_EXE_skyshed"));
    command.args(line.to_str().expect("a line").split_whitespace()).current_dir(folder);
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let answer = wait(command.spawn().expect("the program starts"));
    let peak = getrusage(UsageWho::RUSAGE_CHILDREN).expect("what children took").max_rss() * 1024;
    let write = |name: &str, text: String| std::fs::write(Path::new(&report).join(name), text).expect("a report");
    write("status", answer.status.into_raw().to_string());
    write("peak", peak.to_string());
    write("out", answer.out);
    write("err", answer.err);
}
