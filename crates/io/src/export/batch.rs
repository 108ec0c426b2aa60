//! Files that appear together or not at all.

use std::collections::HashMap;
use std::fs::File;
use std::io::{BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};

use super::Format;
use super::files::{cannot_write, folder_of, followed, refuse_to_replace};
use super::seal::{can_seal, seal};
use super::temporary::{Hold, discard, publish};
use crate::digest::Sha256;
use crate::error::{Error, Result, WriteFault};

/// Largest size of a sidecar \[bytes\].
const LARGEST_SIDECAR: usize = 1 << 20;

/// Files that appear together: each is written under a temporary name, and [`Batch::commit`]
/// renames them all. A batch dropped before that removes its temporary files.
#[derive(Debug, Default)]
pub struct Batch {
    files: Vec<Pending>,
    /// Digests of files small enough to be a sidecar that two outputs share.
    digests: HashMap<PathBuf, Option<[u8; 32]>>,
    overwrite: bool,
    holds: HashMap<PathBuf, Hold>,
    /// Check before each file whether to go on.
    asks: Option<fn() -> skyshed_core::Result<()>>,
    /// `true` if rasters end with a digest of their bytes.
    seals: bool,
}

/// A file under its temporary name.
#[derive(Debug)]
struct Pending {
    temporary: PathBuf,
    /// Path as it was requested.
    path: PathBuf,
    /// Path behind symbolic links.
    place: PathBuf,
}

impl Batch {
    /// Creates an empty batch that replaces existing files only if `overwrite`.
    pub fn new(overwrite: bool) -> Self {
        Batch { files: Vec::new(), digests: HashMap::new(), overwrite, holds: HashMap::new(), asks: None, seals: false }
    }

    /// Makes the batch call `asks` before each file; an error stops it.
    #[must_use]
    pub fn asking(mut self, asks: fn() -> skyshed_core::Result<()>) -> Self {
        self.asks = Some(asks);
        self
    }

    /// Makes the batch end rasters that hold no checksum of their own with a digest of their bytes,
    /// if `seals`. [`is_unchanged`](super::is_unchanged) checks it.
    #[must_use]
    pub fn sealing(mut self, seals: bool) -> Self {
        self.seals = seals;
        self
    }

    /// Adds a file: writes its bytes under a temporary name in the same folder. A file that two
    /// outputs share, such as the `.prj` beside `a.asc` and `a.png`, is written once.
    ///
    /// # Errors
    /// Usage error if the file exists and may not be replaced (E106), is no file or two outputs
    /// want it differently (E105); E401 if writing fails.
    pub fn add(&mut self, path: &Path, bytes: &[u8]) -> Result<()> {
        // Only sidecars are ever common to two outputs, and they are small.
        let digest = (bytes.len() <= LARGEST_SIDECAR).then(|| Sha256::digest(bytes));
        match self.digests.get(path) {
            Some(Some(before)) if Some(*before) == digest => Ok(()),
            _ => self.add_written(path, digest, |file| file.write_all(bytes).map_err(|e| cannot_write(path, &e))),
        }
    }

    /// Adds a file that `write` writes, without holding it in memory.
    ///
    /// # Errors
    /// Errors of [`Batch::add`] and of `write`.
    pub fn add_streamed(&mut self, path: &Path, write: impl FnOnce(&mut BufWriter<File>) -> Result<()>) -> Result<()> {
        self.add_written(path, None, write)
    }

    fn add_written(
        &mut self,
        path: &Path,
        digest: Option<[u8; 32]>,
        write: impl FnOnce(&mut BufWriter<File>) -> Result<()>,
    ) -> Result<()> {
        let mut file = self.begin_with(path, digest)?;
        write(&mut file)?;
        complete(path, file)
    }

    /// Begins a file under a temporary name. Once it is written, [`complete`] has to follow, before
    /// [`Batch::commit`].
    pub(super) fn begin(&mut self, path: &Path) -> Result<BufWriter<File>> {
        self.begin_with(path, None)
    }

    fn begin_with(&mut self, path: &Path, digest: Option<[u8; 32]>) -> Result<BufWriter<File>> {
        self.asks.map_or(Ok(()), |ask| ask())?;
        refuse_to_replace(path, self.overwrite)?;
        if self.digests.insert(path.to_path_buf(), digest).is_some() {
            return Err(Error::write(path.display(), WriteFault::Needed));
        }
        let place = followed(path);
        let folder = folder_of(&place);
        if !self.holds.contains_key(&folder) {
            let hold = Hold::of(&folder).map_err(|e| cannot_write(path, &e))?;
            self.holds.insert(folder.clone(), hold);
        }
        let created = self.holds[&folder].create(place.file_name().unwrap_or_default());
        let (temporary, file) = created.map_err(|e| cannot_write(path, &e))?;
        self.files.push(Pending { temporary, path: path.to_path_buf(), place });
        Ok(BufWriter::with_capacity(1 << 16, file))
    }

    /// Gives every file its final name, and returns these in the order in which the files were
    /// added.
    ///
    /// A new sidecar gets its name before its file, so that an existing file is complete. A
    /// replaced sidecar gets it after its file, so that no old file is described as new.
    ///
    /// # Errors
    /// E106 if another run wrote a file meanwhile that may not be replaced, E401 if a file cannot be
    /// sealed or renamed.
    pub fn commit(mut self) -> Result<Vec<PathBuf>> {
        let written = self.files.iter().map(|file| file.path.clone()).collect();
        for Pending { temporary, path, .. } in self.files.iter().filter(|_| self.seals) {
            if Format::of(path).is_ok_and(can_seal) {
                seal(temporary).map_err(|e| cannot_write(path, &e))?;
            }
        }
        // The last of the list is renamed first. Renamed files leave it, so that dropping the batch
        // after a failure removes the rest.
        let (replaced, new): (Vec<_>, Vec<_>) = self.files.drain(..).partition(|file| file.place.exists());
        // A sidecar is added after its file: new ones are renamed from the end, replaced ones from
        // the beginning.
        self.files = replaced.into_iter().rev().chain(new).collect();
        while let Some(Pending { temporary, path, place }) = self.files.last() {
            publish(temporary, place, self.overwrite).map_err(|e| match e.kind() {
                ErrorKind::AlreadyExists => Error::write(path.display(), WriteFault::ExistsMeanwhile),
                _ => cannot_write(path, &e),
            })?;
            self.files.pop();
        }
        Ok(written)
    }
}

impl Drop for Batch {
    fn drop(&mut self) {
        self.files.iter().for_each(|file| discard(&file.temporary));
    }
}

/// Flushes a file that was begun to the disk.
pub(super) fn complete(path: &Path, file: BufWriter<File>) -> Result<()> {
    let file = file.into_inner().map_err(|e| cannot_write(path, e.error()))?;
    file.sync_all().map_err(|e| cannot_write(path, &e))
}
