//! Runs the program as a user does: in a folder of its own, with its exit code and both streams kept.

#![allow(dead_code, reason = "each binary uses a part")]

use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant, SystemTime};

use serde_json::Value;

use crate::documents;
use crate::recorder::record;
use crate::support::is_long;

/// Address space that every run may take [KiB]: what cannot be mapped cannot be used, so no run peaks above 1 GB.
const MOST_KIB: u32 = 976_562;

/// Processor time that any run may take \[s\]: the longest compute for some seconds. Time that a busy machine lets it wait does not count.
fn most_cpu_seconds() -> f64 {
    // The long tests compute on purpose.
    if is_long() { 180.0 } else { 30.0 }
}

/// A run that has not ended after this never will.
const NEVER: Duration = Duration::from_secs(1200);

/// What a run of the program left.
#[derive(Debug)]
pub(crate) struct Answer {
    pub(crate) status: ExitStatus,
    pub(crate) out: String,
    /// Standard error but for [`Answer::progress`].
    pub(crate) err: String,
    /// How far it was, told every some seconds: of how many of them says how busy the machine is.
    pub(crate) progress: Vec<String>,
    /// Processor time that it took \[s\]; 0 where the system does not say.
    pub(crate) cpu_s: f64,
}

impl Answer {
    /// What a run said on standard output and standard error until it ended.
    pub(crate) fn of(status: ExitStatus, [out, err]: [String; 2], cpu_s: f64) -> Answer {
        let is_progress = |line: &&str| line.ends_with(" s left\n") || line.ends_with(" s so far\n");
        let (progress, err): (Vec<&str>, Vec<&str>) = err.split_inclusive('\n').partition(is_progress);
        let progress = progress.into_iter().map(str::to_string).collect();
        Answer { status, out, err: err.concat(), progress, cpu_s }
    }

    /// The exit code; a signal or the code of a panic is a failure of whatever ran.
    pub(crate) fn code(&self) -> i32 {
        let code = self.status.code().unwrap_or_else(|| panic!("ended by a signal: {self:?}"));
        assert_ne!(code, 101, "panicked: {self:?}");
        code
    }

    /// The answer of a run that must succeed.
    pub(crate) fn done(self) -> Answer {
        assert_eq!(self.code(), 0, "{self:?}");
        self
    }

    /// The lines on standard error of a run that must fail with this exit code, saying nothing on standard output.
    pub(crate) fn refused(&self, code: i32) -> Vec<&str> {
        assert_eq!(self.code(), code, "{self:?}");
        assert_eq!(self.out, "", "an error says nothing on standard output: {self:?}");
        assert!(self.err.starts_with("error[E"), "{self:?}");
        self.err.lines().collect()
    }

    /// The code of the error, such as `E302`, of a run that must fail, saying nothing on standard output.
    pub(crate) fn error(&self) -> &str {
        assert_ne!(self.code(), 0, "{self:?}");
        assert_eq!(self.out, "", "an error says nothing on standard output: {self:?}");
        let code = self.err.lines().find_map(|line| line.strip_prefix("error[")?.split_once(']'));
        code.unwrap_or_else(|| panic!("no error: {self:?}")).0
    }

    /// Standard output as one JSON document; a parser that takes neither NaN nor a second document reads all of it.
    pub(crate) fn json(&self) -> Value {
        serde_json::from_str(&self.out).unwrap_or_else(|e| panic!("{e}: {self:?}"))
    }

    /// The codes of the warnings on standard error.
    pub(crate) fn warnings(&self) -> Vec<&str> {
        let code =
            |line: &'_ str| line.strip_prefix("warning[").and_then(|l| l.split_once(']')).map(|(code, _)| code.len());
        self.err.lines().filter_map(|line| code(line).map(|n| &line[8..8 + n])).collect()
    }
}

/// A new empty folder, removed when dropped.
#[derive(Debug)]
pub(crate) struct Folder(PathBuf);

impl Folder {
    pub(crate) fn new() -> Folder {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let name = format!("run-{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
        let _ = std::fs::remove_dir_all(&path);
        std::fs::create_dir_all(&path).expect("a folder for tests");
        Folder(path)
    }

    pub(crate) fn path(&self) -> &Path {
        &self.0
    }

    pub(crate) fn join(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// The path of a file in the folder, as a word of a command line.
    pub(crate) fn word(&self, name: &str) -> String {
        self.0.join(name).to_str().expect("a path in UTF-8").to_string()
    }

    pub(crate) fn write(&self, name: &str, text: &str) {
        std::fs::write(self.join(name), text).expect("a file in a folder for tests");
    }

    pub(crate) fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.join(name)).unwrap_or_else(|e| panic!("{name}: {e}; there are {:?}", self.files()))
    }

    pub(crate) fn text(&self, name: &str) -> String {
        String::from_utf8(self.read(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    pub(crate) fn json(&self, name: &str) -> Value {
        serde_json::from_str(&self.text(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// The names of all files in it, hidden ones too, sorted.
    pub(crate) fn files(&self) -> Vec<String> {
        let entries = std::fs::read_dir(&self.0).expect("a folder for tests");
        let mut names: Vec<String> =
            entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    /// Runs the program with this folder as its working folder.
    pub(crate) fn run(&self, words: &[&str]) -> Answer {
        run_in(&self.0, words)
    }

    /// The flags of a command's help, each with the words of its line: a short name may stand before the long one.
    pub(crate) fn flags(&self, command: &str) -> Vec<String> {
        let help = self.type_in(&format!("{command} --help")).done().out;
        let lines = help.lines().map(str::trim_start).filter(|line| line.starts_with('-'));
        let flag = |line: &str| line.split([' ', ',']).find(|word| word.starts_with("--")).map(str::to_string);
        let flags: Vec<String> = lines.filter_map(flag).collect();
        assert!(flags.len() > 8, "{command}: {flags:?}");
        flags
    }

    /// Runs a command line without quotes, as typed.
    pub(crate) fn type_in(&self, line: &str) -> Answer {
        self.run(&line.split_whitespace().collect::<Vec<_>>())
    }

    /// Runs a line that must fail with this code, the exit code of its class, and these words in its error or hint.
    pub(crate) fn refuses(&self, line: &str, code: &str, words: &[&str]) -> Answer {
        let answer = self.type_in(line);
        assert_eq!(answer.error(), code, "{line}: {answer:?}");
        let exit = match &code[..2] {
            "E1" => 2,
            "E2" => 4,
            "E3" | "E4" => 3,
            "E5" => 5,
            class => panic!("{class} is the class of no refusal"),
        };
        let hints = &answer.refused(exit)[1..];
        assert!(hints.iter().all(|hint| hint.starts_with("hint: ")), "{line}: {answer:?}");
        words.iter().for_each(|word| assert!(answer.err.contains(word), "{line}: no `{word}` in {answer:?}"));
        answer
    }

    /// Removes files; one that is gone already does no harm.
    pub(crate) fn remove(&self, names: &[String]) {
        names.iter().for_each(|name| drop(std::fs::remove_file(self.join(name))));
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// The program, ready to be given words: two threads, and no more than 1 GB of memory.
///
/// The shell sets the limit and then becomes the program, so that signals and the exit code are the program's own.
pub(crate) fn program(folder: &Path, words: &[&str]) -> Command {
    let mut command = if cfg!(target_os = "linux") {
        let mut shell = Command::new("sh");
        shell.args(["-c", &format!("ulimit -v {MOST_KIB}; exec \"$0\" \"$@\""), env!("CARGO_BIN_EXE_skyshed")]);
        shell
    } else {
        Command::new(env!("CARGO_BIN_EXE_skyshed"))
    };
    command.args(words).current_dir(folder).env("RAYON_NUM_THREADS", "2").env("MALLOC_ARENA_MAX", "2");
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// Runs the program in `folder` and waits for it, but not for long.
pub(crate) fn run_in(folder: &Path, words: &[&str]) -> Answer {
    let began = SystemTime::now();
    let child = program(folder, words).spawn().expect("the program starts");
    let answer = wait(child);
    assert!(answer.cpu_s < most_cpu_seconds(), "{words:?}: {answer:?}");
    record(folder, words, &answer.out);
    documents::check(&answer.out, &words.join(" "));
    documents::check_files(folder, began);
    answer
}

/// Sends a signal, such as `-INT`, to a running program.
pub(crate) fn send(signal: &str, child: &Child) {
    Command::new("kill").args([signal, &child.id().to_string()]).output().expect("`kill` runs");
}

/// Interrupts a running program: what it says until it ends, and the processor time that it takes after the signal \[s\].
pub(crate) fn interrupt(signal: &str, child: Child) -> (Answer, f64) {
    send(signal, &child);
    let before = cpu_seconds(child.id());
    let answer = wait(child);
    let after = (answer.cpu_s - before).max(0.0);
    (answer, after)
}

/// Processor time of a process so far \[s\], also of one that has ended and was not waited for; 0 where the system does not say.
fn cpu_seconds(process: u32) -> f64 {
    /// Unit of the file, on every Linux.
    const TICKS_PER_SECOND: f64 = 100.0;
    let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).unwrap_or_default();
    // The name of the program, in brackets, may hold anything.
    let fields = stat.rsplit(')').next().unwrap_or_default().split_whitespace();
    fields.skip(11).take(2).filter_map(|ticks| ticks.parse::<f64>().ok()).sum::<f64>() / TICKS_PER_SECOND
}

/// What a running program says until it ends; it is stopped, and the test fails, where it never does.
pub(crate) fn wait(mut child: Child) -> Answer {
    let (out, err) = (child.stdout.take(), child.stderr.take());
    std::thread::scope(|scope| {
        let out = scope.spawn(move || out.map_or(String::new(), read_all));
        let err = scope.spawn(move || err.map_or(String::new(), read_all));
        let start = Instant::now();
        let mut cpu_s = 0.0;
        let status = loop {
            // Before it is waited for: then nothing is known of it any more.
            cpu_s = cpu_seconds(child.id()).max(cpu_s);
            match child.try_wait().expect("the program can be waited for") {
                Some(status) => break status,
                None if start.elapsed() > NEVER => {
                    let _ = child.kill();
                    break child.wait().expect("a killed program ends");
                }
                None => std::thread::sleep(Duration::from_millis(1)),
            }
        };
        Answer::of(status, [out.join().expect("standard output"), err.join().expect("standard error")], cpu_s)
    })
}

fn read_all(mut stream: impl Read) -> String {
    let mut text = String::new();
    stream.read_to_string(&mut text).expect("the program speaks UTF-8");
    text
}
