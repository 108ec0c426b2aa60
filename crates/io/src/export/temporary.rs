//! Files under temporary names, beside the final ones.
//!
//! A run writes `.NAME.RUN.part` beside `NAME`; RUN is 16 hexadecimal digits of its own. As long as
//! it has such files in a folder, it holds a lock on `.skyshed.RUN.part` there. A killed run cannot
//! remove its files, but the system releases its lock. The next run that writes into the folder
//! finds it free and removes the files.

use std::ffi::{OsStr, OsString};
use std::fs::{File, TryLockError};
use std::hash::{BuildHasher, Hasher};
use std::io::{Error, ErrorKind, Result};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Folders and temporary files of this process.
static HELD: Mutex<Held> = Mutex::new(Held { folders: Vec::new(), files: Vec::new() });

struct Held {
    folders: Vec<Folder>,
    /// Temporary files that exist.
    files: Vec<PathBuf>,
}

struct Folder {
    path: PathBuf,
    run: String,
    lock: PathBuf,
    /// Lock file, locked as long as it is open.
    _file: File,
    n_holds: usize,
}

fn held() -> MutexGuard<'static, Held> {
    HELD.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Permission to write temporary files into a folder.
#[derive(Debug)]
pub(super) struct Hold {
    folder: PathBuf,
    run: String,
}

impl Hold {
    /// Takes the lock in a folder, and removes files that killed runs left there.
    pub(super) fn of(folder: &Path) -> Result<Hold> {
        let mut held = held();
        if let Some(known) = held.folders.iter_mut().find(|known| known.path == folder) {
            known.n_holds += 1;
            return Ok(Hold { folder: folder.to_path_buf(), run: known.run.clone() });
        }
        let (run, lock, file) = lock_in(folder)?;
        remove_orphans(folder, &run);
        held.folders.push(Folder { path: folder.to_path_buf(), run: run.clone(), lock, _file: file, n_holds: 1 });
        Ok(Hold { folder: folder.to_path_buf(), run })
    }

    /// Creates the temporary file of a name in the folder.
    pub(super) fn create(&self, name: &OsStr) -> Result<(PathBuf, File)> {
        let path = self.folder.join(named(name, &self.run));
        let mut held = held();
        let file = File::create_new(&path)?;
        held.files.push(path.clone());
        Ok((path, file))
    }
}

impl Drop for Hold {
    fn drop(&mut self) {
        let mut held = held();
        let Some(at) = held.folders.iter().position(|known| known.path == self.folder) else { return };
        held.folders[at].n_holds -= 1;
        if held.folders[at].n_holds == 0 {
            let _ = std::fs::remove_file(&held.folders.swap_remove(at).lock);
        }
    }
}

/// Gives a temporary file its final name, which must be free unless `overwrite`.
pub(super) fn publish(temporary: &Path, path: &Path, overwrite: bool) -> Result<()> {
    let mut held = held();
    if overwrite {
        std::fs::rename(temporary, path)?;
    } else {
        let kept = tempfile::TempPath::try_from_path(temporary)?;
        kept.persist_noclobber(path).map_err(|failed| {
            let error = failed.error;
            // The caller that added the file removes it.
            let _ = failed.path.keep();
            error
        })?;
    }
    held.files.retain(|file| file != temporary);
    Ok(())
}

/// Removes a temporary file.
pub(super) fn discard(temporary: &Path) {
    let mut held = held();
    let _ = std::fs::remove_file(temporary);
    held.files.retain(|file| file != temporary);
}

/// Removes all temporary files of this process, which has to end then: no other file is begun or
/// gets its name.
pub fn abandon_files() {
    let held = held();
    for path in held.files.iter().chain(held.folders.iter().map(|folder| &folder.lock)) {
        let _ = std::fs::remove_file(path);
    }
    std::mem::forget(held);
}

/// Returns `.NAME.RUN.part`.
fn named(name: &OsStr, run: &str) -> OsString {
    let mut file = OsString::from(".");
    file.push(name);
    file.push(format!(".{run}.part"));
    file
}

/// Returns the run in the name of a temporary file.
fn run_of(file: &OsStr) -> Option<&str> {
    let run = file.to_str()?.strip_prefix('.')?.strip_suffix(".part")?.rsplit_once('.')?.1;
    (run.len() == 16 && run.bytes().all(|byte| matches!(byte, b'0'..=b'9' | b'a'..=b'f'))).then_some(run)
}

fn lock_name(run: &str) -> OsString {
    named(OsStr::new("skyshed"), run)
}

/// Creates the lock of a new run.
fn lock_in(folder: &Path) -> Result<(String, PathBuf, File)> {
    const TRIES: usize = 100;
    for _ in 0..TRIES {
        // Random digits differ from those of other programs that write the same file, also where
        // each is process 1 of its own machine.
        let run = format!("{:016x}", std::hash::RandomState::new().build_hasher().finish());
        let path = folder.join(lock_name(&run));
        let file = File::create_new(&path)?;
        // Before it is locked, another run may take it for an orphan.
        let is_mine = !matches!(file.try_lock(), Err(TryLockError::WouldBlock));
        if is_mine && path.exists() {
            return Ok((run, path, file));
        }
    }
    Err(Error::new(ErrorKind::ResourceBusy, "other programs remove what is made there"))
}

/// Removes the temporary files of runs that hold no lock.
fn remove_orphans(folder: &Path, own: &str) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    let names: Vec<OsString> = entries.filter_map(|entry| Some(entry.ok()?.file_name())).collect();
    let mut runs: Vec<&str> = names.iter().filter_map(|name| run_of(name)).filter(|run| *run != own).collect();
    runs.sort_unstable();
    runs.dedup();
    for run in runs {
        let lock = folder.join(lock_name(run));
        // A run without a lock file has ended. Where locks do not work, nothing is known of the
        // run.
        let file = match File::options().read(true).write(true).open(&lock) {
            Ok(file) if file.try_lock().is_ok() => Some(file),
            Err(cause) if cause.kind() == ErrorKind::NotFound => None,
            _ => continue,
        };
        for name in names.iter().filter(|name| run_of(name) == Some(run) && **name != lock_name(run)) {
            let _ = std::fs::remove_file(folder.join(name));
        }
        if file.is_some() {
            let _ = std::fs::remove_file(&lock);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_that_was_taken_meanwhile_is_left_to_whoever_took_it() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.txt");
        let hold = Hold::of(folder.path()).expect("a lock");
        let (temporary, _file) = hold.create(OsStr::new("a.txt")).expect("a file");
        std::fs::write(&path, "theirs").expect("a file");
        let refused = publish(&temporary, &path, false).expect_err("the name is taken");
        assert_eq!(refused.kind(), ErrorKind::AlreadyExists);
        assert_eq!(std::fs::read_to_string(&path).expect("a file"), "theirs");
        discard(&temporary);
        assert!(!temporary.exists());
    }
}
