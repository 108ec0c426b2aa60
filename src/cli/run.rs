//! Run of a command: the work that all commands share, from the typed words to the last line
//! printed.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};
use std::time::Instant;

use serde_json::{Map, Value};

use skyshed_request::{OutputOptions, Reading, json};

use super::found::Found;
use super::{interrupt, say};
use crate::answer::{Answer, CommandFacts, Output, Spent, add_outputs};
use crate::cli::args::output::{is_told, plain_look};
use crate::cli::args::scene::{layer_of, scene_files};
use crate::cli::failure::{Result, refusal, refusal_with};
use crate::error::{Error, Warning};
use crate::export::{Batch, Format, OutputRules, check_outputs};
use crate::map::GivenScene;
use crate::picture::Look;
use crate::progress::Progress;
use crate::repairs::{FORMATS as REPAIRS_FORMATS, Repairs};
use crate::scene::{FoundRepairs, Scene, SceneReader, built_up, format_of};
use crate::words::pretty;
use skyshed_io::{FileFormat, FileKind};

/// Run of a command.
pub(super) struct Run {
    /// Command line and question, for documents.
    pub(super) command: CommandFacts,
    pub(super) start: Instant,
    pub(super) progress: Arc<Progress>,
    pub(super) is_quiet: bool,
    /// Scene, if another program holds it.
    pub(super) given: Option<Scene>,
    /// `true` if the answer is kept for another program instead of printed.
    pub(super) keeps: bool,
    pub(super) found: OnceLock<Found>,
    /// All repairs of footprints and all footprints left out, if they are read for a list of these.
    pub(super) found_repairs: Arc<OnceLock<FoundRepairs>>,
}

impl Run {
    /// Returns a run whose answer is kept for another program.
    pub(super) fn asked(command: CommandFacts, start: Instant, progress: &Arc<Progress>) -> Run {
        let progress = Arc::clone(progress);
        Run {
            command,
            start,
            progress,
            is_quiet: true,
            given: None,
            keeps: true,
            found: OnceLock::new(),
            found_repairs: Arc::default(),
        }
    }

    /// Returns the scene of a word, made ready.
    ///
    /// # Errors
    /// Errors of reading it.
    pub(super) fn open_word(&self, word: &OsStr, reading: &Reading) -> Result<Scene> {
        let read = || Ok(self.reader(reading).open(word)?);
        self.given.as_ref().map_or_else(read, |given| Ok(given.clone()))
    }

    /// Refuses a data area, unless the scene was read before.
    ///
    /// # Errors
    /// E116.
    pub(super) fn refuse_data_area(&self, members: &Map<String, Value>) -> Result<()> {
        match self.given {
            Some(_) => Ok(()),
            None => Ok(json::refuse(members, &["data_area"], "for a link: its ends are where they are put")
                .map_err(Error::from)?),
        }
    }

    /// Returns a reader of scenes, which lists repairs if that was requested.
    pub(super) fn reader(&self, reading: &Reading) -> SceneReader {
        SceneReader { repairs: self.list_for(reading), ..reading.options.clone().into() }
    }

    /// Returns the list of repairs, if it was requested.
    pub(super) fn list_for(&self, reading: &Reading) -> Option<Arc<OnceLock<FoundRepairs>>> {
        reading.list.repairs.is_some().then(|| Arc::clone(&self.found_repairs))
    }

    /// Returns the command line and the question, for a document.
    pub(super) fn command(&self) -> CommandFacts {
        self.command.clone()
    }

    /// Returns the scene of a map: the scene of another program, or one to be read.
    pub(super) fn given_scene(&self) -> GivenScene<'static> {
        self.given.clone().map_or(GivenScene::Asked, |scene| GivenScene::InMemory(Box::new(scene)))
    }

    /// Keeps an answer, whose files are written already, for another program.
    pub(super) fn keep(&self, answer: &dyn Answer, spent: Spent, files: Vec<PathBuf>) {
        let _ = self.found.set(Found::of(answer, spent, files));
    }

    /// Keeps counts for another program.
    pub(super) fn keep_counts(&self, document: Value, warnings: &[Warning]) {
        let _ = self.found.set(Found { document, table: Vec::new(), warnings: warnings.to_vec(), files: Vec::new() });
    }

    /// Writes the files of an answer, which appear together, and reports on standard error. Then
    /// prints the answer on standard output.
    ///
    /// # Errors
    /// Failures of making or writing a file, and an interrupt by the user.
    pub(super) fn emit(
        &self,
        answer: &dyn Answer,
        outputs: &[Output],
        (out, look): (&OutputOptions, &Look),
    ) -> Result<()> {
        let batch = match answer.interrupted() {
            // Work that was done before an interrupt is written.
            Some(_) => Batch::new(out.writing.overwrite),
            None => Batch::new(out.writing.overwrite).asking(interrupt::check),
        };
        let (written, spent) = self.write(answer, batch, outputs, look)?;
        if self.keeps {
            self.keep(answer, spent, written);
            return Ok(());
        }
        self.tell(answer, spent);
        say::wrote(&written, self.is_quiet);
        if is_told(out) {
            say::answer(&pretty(&answer.document(Some(spent))))?;
        } else if outputs.is_empty() || answer.is_in_words() {
            say::answer(&answer.text(look)?)?;
        }
        match answer.interrupted() {
            Some(what) => Err(refusal(130, format!("interrupted; {what} were written"))),
            None => Ok(()),
        }
    }

    fn write(
        &self,
        answer: &dyn Answer,
        mut batch: Batch,
        outputs: &[Output],
        look: &Look,
    ) -> Result<(Vec<PathBuf>, Spent)> {
        let before = Instant::now();
        let seconds = |since: Instant| since.elapsed().as_secs_f64();
        interrupt::begin_writing();
        // The time of writing is not known before the files are written.
        add_outputs(answer, &mut batch, outputs, (look, Spent { write: 0.0, total: seconds(self.start) }))?;
        let written = batch.commit()?;
        Ok((written, Spent { write: seconds(before), total: seconds(self.start) }))
    }

    /// Prints the warnings and notes of an answer.
    pub(super) fn tell(&self, answer: &dyn Answer, spent: Spent) {
        if !self.is_quiet {
            say::warnings(answer.warnings());
            answer.notes(spent).iter().for_each(|note| say::note(note));
        }
    }
}

/// Refuses options that scenes cannot use: a seed if nothing is drawn at random, and hashes if no
/// file is read.
///
/// # Errors
/// E116.
pub(super) fn check_use(shared: &Shared<'_>, draws: bool) -> Result<()> {
    let is_generated = |scene: &&OsStr| built_up(scene).is_some();
    let options = &shared.reading.options;
    if !draws && options.seed.is_some() && !shared.scenes.iter().any(is_generated) {
        return Err(Error::idle("seed", "for a city in a file: nothing is drawn").into());
    }
    if options.hash && shared.scenes.iter().all(is_generated) && json::files_read(&shared.members()).is_empty() {
        return Err(Error::idle("hash", "without a file that is read").into());
    }
    Ok(())
}

/// Parts that requests of all commands share.
pub(super) struct Shared<'a> {
    /// Scenes, as words.
    pub(super) scenes: Vec<&'a OsStr>,
    pub(super) reading: &'a Reading,
    pub(super) out: &'a OutputOptions,
    pub(super) read_members: Box<dyn Fn() -> Map<String, Value> + 'a>,
}

impl Shared<'_> {
    /// Returns all options that were set.
    pub(super) fn members(&self) -> Map<String, Value> {
        (self.read_members)()
    }
}

/// Refuses a scene that is no file but the name of a built-up environment, which needs the prefix
/// `itu:`.
///
/// # Errors
/// E301.
pub(super) fn check_scenes(scenes: &[&OsStr]) -> Result<()> {
    for scene in scenes {
        let word = format!("itu:{}", scene.display());
        if matches!(built_up(word.as_ref()), Some(Ok(_))) && !Path::new(scene).exists() {
            let text = format!("cannot read {}: no such file", scene.display());
            return Err(refusal_with(301, text, format!("`{word}` is a generated city")));
        }
    }
    Ok(())
}

/// File of the repairs made and the footprints left out while reading. Any command that reads
/// footprints can write it. The list is kept while the command runs and written once it has
/// succeeded, so that a failed run leaves nothing behind.
pub(super) struct RepairsFile<'a> {
    scene: &'a OsStr,
    reading: &'a Reading,
    out: &'a OutputOptions,
    output: Output,
}

impl<'a> RepairsFile<'a> {
    /// Returns the file, if one was requested. Before any work, it refuses scenes that are no files
    /// of footprints, and files that cannot be written.
    ///
    /// # Errors
    /// E116; E104–E106, as for every output.
    pub(super) fn of(shared: &Shared<'a>) -> Result<Option<Self>> {
        let Shared { scenes, reading, out, .. } = shared;
        let Some(path) = &reading.list.repairs else { return Ok(None) };
        let is_footprints =
            |scene: &&&'a OsStr| format_of(Path::new(scene)).and_then(FileFormat::kind) == Some(FileKind::Vector);
        let Some(scene) = scenes.first().filter(is_footprints) else {
            return Err(refusal(116, "`--repairs` has no meaning for a scene that is no file of footprints"));
        };
        let rules = OutputRules {
            allowed: &REPAIRS_FORMATS,
            inputs: &scene_files(scene, reading),
            overwrite: out.writing.overwrite,
            bare: false,
        };
        let output = check_outputs(std::slice::from_ref(&path.0), rules)?.pop();
        if let Some(other) =
            json::files(&shared.members()).into_iter().find(|other| is_same_file(path, Path::new(other)))
        {
            let text = format!("cannot write {}: it is {other}, which this run needs too", path.display());
            return Err(refusal_with(105, text, "give the repairs a name of their own"));
        }
        Ok(output.map(|output| RepairsFile { scene, reading, out, output }))
    }

    /// Writes the list of repairs.
    ///
    /// # Errors
    /// E116 if no footprints were read; E106, E401 if the file cannot be written.
    pub(super) fn write(&self, run: &Run) -> Result<()> {
        let Some(found) = run.found_repairs.get() else {
            return Err(refusal(116, "`--repairs` has no meaning here: no footprints were read"));
        };
        let repairs = Repairs::of(found, layer_of(self.scene, self.reading), run.command());
        let outputs = [self.output.clone()];
        let (written, spent) =
            run.write(&repairs, Batch::new(self.out.writing.overwrite), &outputs, &plain_look(self.out))?;
        run.tell(&repairs, spent);
        say::wrote(&written, run.is_quiet);
        Ok(())
    }
}

/// Returns `true` if two paths are one file, which need not exist yet.
fn is_same_file(a: &Path, b: &Path) -> bool {
    let place = |path: &Path| {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        (std::fs::canonicalize(folder).ok(), path.file_name().map(std::ffi::OsStr::to_os_string))
    };
    place(a) == place(b)
}

/// Refuses tables as text where no table is written.
///
/// # Errors
/// E116.
pub(super) fn check_text(out: &OutputOptions, repairs: Option<&RepairsFile<'_>>) -> Result<()> {
    let is_table = |path: &Path| Format::of(path).is_ok_and(|format| format == Format::Csv);
    let has_table = out
        .files
        .output
        .iter()
        .map(|path| &path.0)
        .chain(repairs.map(|file| &file.output.0))
        .any(|path| is_table(path));
    // Without files, the answer may be a table.
    if out.writing.csv_text && !has_table && (out.files.json || !out.files.output.is_empty()) {
        return Err(refusal(116, "`--csv-text` has no meaning without a table"));
    }
    Ok(())
}
