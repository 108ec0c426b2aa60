//! Files inside of gzip files and ZIP archives.
//!
//! Nothing is written to disk: a file is unpacked into memory when it is opened, and again when it
//! is opened again. Names inside of archives are names alone, wherever they point.

use std::fmt;
use std::io::{BufReader, Cursor, Read};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use zip::ZipArchive;
use zip::result::ZipError;

use crate::error::{Cause, Error, ReadFault, Result};
use crate::format::FileFormat;
use crate::input::{Input, Reader, cannot_read};

/// Most files in an archive.
const MOST_MEMBERS: usize = 20_000;
/// Most bytes that are unpacked of any file, and beside them for each packed byte. Text and XML of
/// cities take 10 to 40 times the bytes of their archive.
const MOST_UNPACKED: (u64, u64) = (64 << 20, 150);

/// Deepest nesting of archives.
const MOST_NESTED: usize = 2;
/// Most bytes of archives inside of others, and beside them for each byte of the outer one, which
/// hardly packs them again.
const MOST_INNER: (u64, u64) = (64 << 20, 4);

/// File inside of another one.
#[derive(Clone)]
pub(crate) struct Packed {
    archive: Arc<Input>,
    /// ZIP archive and the name of the file in it; `None` in a gzip file, which holds one file.
    member: Option<(Arc<Mutex<Zip>>, String)>,
}

/// Opened ZIP archive, which its files share.
type Zip = ZipArchive<BufReader<Reader>>;

/// Kind of an archive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Archive {
    Gzip,
    Zip,
}

/// Returns a file with its format or, of an archive, the files inside of it, also of archives inside
/// of that.
///
/// # Errors
/// E301 and E302 for an archive that cannot be read; E502 for one of too many files, or of archives
/// that unpack to much.
pub(crate) fn files_of(input: &Input) -> Result<Vec<(Input, FileFormat)>> {
    let (mut found, mut n_unpacked) = (Vec::new(), 0);
    collect(input, 0, (&mut found, &mut n_unpacked))?;
    Ok(found)
}

fn collect(input: &Input, depth: usize, (found, n_unpacked): (&mut Vec<(Input, FileFormat)>, &mut u64)) -> Result<()> {
    let format = FileFormat::of(input)?;
    let Some(archive) = format.archive().filter(|_| depth < MOST_NESTED) else {
        found.push((input.clone(), format));
        return Ok(());
    };
    let (members, n_more) = members(input, archive)?;
    *n_unpacked += n_more;
    let most = MOST_INNER.0.saturating_add(MOST_INNER.1.saturating_mul(input.len()));
    if *n_unpacked > most {
        let what = format!("archives inside of it that take over {} MiB, wanted files of a city", most >> 20);
        return Err(Error::read(input.on_disk(), ReadFault::TooMany(what)));
    }
    members.iter().try_for_each(|member| collect(member, depth + 1, (found, n_unpacked)))
}

/// Returns the files inside of an archive, without folders and hidden files, and the number of bytes
/// that were unpacked to find them.
///
/// # Errors
/// E301 and E302 for an archive that cannot be read; E502 for one of too many files.
fn members(archive: &Input, kind: Archive) -> Result<(Vec<Input>, u64)> {
    let shared = Arc::new(archive.clone());
    if kind == Archive::Gzip {
        let packed = Packed { archive: shared, member: None };
        return Ok((vec![Input::packed(archive.as_path().with_extension(""), packed)], 0));
    }
    let (file, length) = archive.open()?;
    let zip = ZipArchive::new(BufReader::new(file)).map_err(|e| damaged(archive, &e))?;
    if zip.len() > MOST_MEMBERS {
        let what = format!("{} files, wanted an archive of at most {MOST_MEMBERS}", zip.len());
        return Err(Error::read(archive, ReadFault::TooMany(what)));
    }
    let mut names = Vec::new();
    for name in zip.file_names() {
        let name = name.map_err(|e| damaged(archive, &e))?.into_owned();
        let is_hidden = |part: &str| part.starts_with('.') && part != ".." || part == "__MACOSX";
        if !name.ends_with('/') && !name.split('/').any(is_hidden) {
            names.push(name);
        }
    }
    names.sort();
    names.dedup();
    let zip = Arc::new(Mutex::new(zip));
    let inside = |name: String| {
        let path = archive.as_path().join(name.trim_start_matches('/'));
        Input::packed(path, Packed { archive: Arc::clone(&shared), member: Some((Arc::clone(&zip), name)) })
    };
    let n_unpacked = if archive.is_packed() { length } else { 0 };
    Ok((names.into_iter().map(inside).collect(), n_unpacked))
}

impl Packed {
    /// Returns the archive.
    pub(crate) fn archive(&self) -> &Input {
        &self.archive
    }

    /// Returns the gzip file that holds nothing else.
    pub(crate) fn gzip(&self) -> Option<&Input> {
        self.member.is_none().then_some(&*self.archive)
    }

    /// Returns the file beside it in the archive of another name, if there is one; of a gzip file,
    /// the file beside that.
    pub(crate) fn beside(&self, name: &Path) -> Option<Input> {
        let Some((zip, own)) = self.member.as_ref() else { return self.archive.other(name.to_owned()) };
        let (folder, wanted) = (own.rsplit_once('/').map(|(folder, _)| folder), name.file_name()?.to_string_lossy());
        let is_it = |other: &str| match (other.rsplit_once('/'), folder) {
            (Some((of, file)), Some(folder)) => of == folder && file.eq_ignore_ascii_case(&wanted),
            (None, None) => other.eq_ignore_ascii_case(&wanted),
            _ => false,
        };
        let found =
            locked(zip).file_names().filter_map(std::result::Result::ok).find(|other| is_it(other))?.into_owned();
        let packed = Packed { archive: Arc::clone(&self.archive), member: Some((Arc::clone(zip), found)) };
        Some(Input::packed(PathBuf::from(name), packed))
    }

    /// Returns the first bytes.
    pub(crate) fn head(&self, input: &Input, most: u64) -> Result<Vec<u8>> {
        self.unpack(input, |file, _| {
            let mut head = Vec::new();
            file.take(most).read_to_end(&mut head).map_err(|e| cut_off(input, &e))?;
            Ok(head)
        })
    }

    /// Returns all bytes.
    ///
    /// # Errors
    /// E302 for a damaged archive; E502 for a file that is much larger than its archive.
    pub(crate) fn read(&self, input: &Input) -> Result<Vec<u8>> {
        self.unpack(input, |file, packed_len| {
            let most = MOST_UNPACKED.0.saturating_add(MOST_UNPACKED.1.saturating_mul(packed_len));
            let mut bytes = Vec::new();
            file.take(most + 1).read_to_end(&mut bytes).map_err(|e| cut_off(input, &e))?;
            if bytes.len() as u64 > most {
                let what = format!("over {} MiB out of {packed_len} bytes, wanted a file of a city", most >> 20);
                return Err(Error::read(input, ReadFault::TooMany(what)));
            }
            Ok(bytes)
        })
    }

    /// Returns all bytes as a stream. Those of a gzip file are unpacked while they are read.
    ///
    /// # Errors
    /// Errors of [`Packed::read`] for other archives; the stream of a gzip file fails instead.
    pub(crate) fn stream(&self, input: &Input) -> Result<Box<dyn Read>> {
        if self.member.is_some() {
            return Ok(Box::new(Cursor::new(self.read(input)?)));
        }
        let packed_len = self.archive.len();
        let left = MOST_UNPACKED.0.saturating_add(MOST_UNPACKED.1.saturating_mul(packed_len));
        let packed = BufReader::new(self.archive.stream()?);
        Ok(Box::new(Unpacked { inner: flate2::read::MultiGzDecoder::new(packed), left }))
    }

    /// Calls `with` with the unpacked file and the length of the packed one.
    fn unpack<T>(&self, input: &Input, with: impl FnOnce(&mut dyn Read, u64) -> Result<T>) -> Result<T> {
        let Some((zip, member)) = &self.member else {
            let (file, length) = self.archive.open()?;
            return with(&mut flate2::read::MultiGzDecoder::new(BufReader::new(file)), length);
        };
        let mut zip = locked(zip);
        let mut file = zip.by_name(member).map_err(|e| damaged(input, &e))?;
        let length = file.compressed_size();
        with(&mut file, length)
    }
}

/// Compares archives and names of files in them.
impl PartialEq for Packed {
    fn eq(&self, other: &Packed) -> bool {
        let name = |packed: &Packed| packed.member.as_ref().map(|(_, name)| name.clone());
        self.archive == other.archive && name(self) == name(other)
    }
}

impl Eq for Packed {}

impl fmt::Debug for Packed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let member = self.member.as_ref().map(|(_, name)| name);
        f.debug_struct("Packed").field("archive", &self.archive).field("member", &member).finish()
    }
}

/// Waits for an archive that another thread reads. What a thread left after a panic is whole: an
/// archive is sought anew for each file.
fn locked(zip: &Mutex<Zip>) -> MutexGuard<'_, Zip> {
    zip.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Stream that ends in an error after a number of bytes.
struct Unpacked<R> {
    inner: R,
    left: u64,
}

impl<R: Read> Read for Unpacked<R> {
    fn read(&mut self, bytes: &mut [u8]) -> std::io::Result<usize> {
        let n = self.inner.read(bytes)?;
        let too_many = || std::io::Error::other("it unpacks to far more than a file of a city");
        self.left = self.left.checked_sub(n as u64).ok_or_else(too_many)?;
        Ok(n)
    }
}

/// Returns the error for a file whose packed bytes are damaged.
fn cut_off(input: &Input, error: &std::io::Error) -> Error {
    let what = format!("it cannot be unpacked ({error}), wanted a whole archive");
    Error::malformed(input, what).because(Cause::CutShort)
}

/// Returns the error for an archive that is damaged, locked, or packed in another way.
fn damaged(input: &Input, error: &ZipError) -> Error {
    match error {
        ZipError::Io(error) => cannot_read(input, error),
        ZipError::UnsupportedArchive(what) => Error::unsupported(input, format!("{what}, wanted a plain ZIP archive")),
        ZipError::InvalidPassword => Error::unsupported(input, "it needs a password, wanted a plain ZIP archive"),
        error => Error::malformed(input, format!("{error}, wanted a ZIP archive")).because(Cause::CutShort),
    }
}
