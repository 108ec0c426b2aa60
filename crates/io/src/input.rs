//! Input of readers: a file by its path, or bytes that the caller holds.

use std::borrow::Cow;
use std::ffi::OsStr;
use std::fmt;
use std::fs::File;
use std::io::{Cursor, ErrorKind, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use skyshed_request::Source;

use crate::error::{Error, ReadFault, Result, io_words};
use crate::packed::Packed;
use crate::remote::is_remote;

/// A file by its path, or bytes that the caller holds under a name, with the files beside it.
///
/// The name sets the format where a reader knows several (`city.shp`), and appears in messages. The
/// path `-` is standard input, from which tables and GeoJSON are read.
///
/// ```
/// use skyshed_io::Input;
///
/// let on_disk = Input::path("maps/city.shp");
/// let held = Input::bytes("city.shp", vec![0; 100]).with_beside("city.dbf", vec![0; 32]);
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Input {
    path: PathBuf,
    held: Option<Held>,
    /// Place inside of an archive.
    packed: Option<Packed>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
struct Held {
    bytes: Arc<[u8]>,
    /// Sidecars: file names and bytes.
    beside: Vec<(PathBuf, Arc<[u8]>)>,
}

impl Input {
    /// Returns a file, which is opened when it is read; its sidecars are found beside it.
    pub fn path(path: impl Into<PathBuf>) -> Input {
        Input { path: path.into(), held: None, packed: None }
    }

    /// Returns bytes under a name, such as `city.geojson`.
    pub fn bytes(name: impl Into<PathBuf>, bytes: impl Into<Arc<[u8]>>) -> Input {
        Input { path: name.into(), held: Some(Held { bytes: bytes.into(), beside: Vec::new() }), packed: None }
    }

    /// Returns a file inside of an archive, which is unpacked when it is read.
    pub(crate) fn packed(path: PathBuf, packed: Packed) -> Input {
        Input { path, held: None, packed: Some(packed) }
    }

    /// Adds the bytes of a sidecar, such as `city.prj`. A file on disk has its sidecars beside it.
    #[must_use]
    pub fn with_beside(mut self, name: impl Into<PathBuf>, bytes: impl Into<Arc<[u8]>>) -> Input {
        if let Some(held) = &mut self.held {
            held.beside.push((name.into(), bytes.into()));
        }
        self
    }

    /// Returns the path, or the name.
    pub fn as_path(&self) -> &Path {
        &self.path
    }

    /// Returns the archive that it lies in, or itself.
    pub(crate) fn on_disk(&self) -> &Input {
        self.packed.as_ref().map_or(self, |packed| packed.archive().on_disk())
    }

    /// Returns `true` for a file inside of an archive.
    pub(crate) fn is_packed(&self) -> bool {
        self.packed.is_some()
    }

    /// Returns `true` for what has no path of a file: held bytes, and files inside of archives.
    pub fn is_held(&self) -> bool {
        self.held.is_some() || self.packed.is_some()
    }

    /// Returns the path of a file; `None` for held bytes.
    pub fn file(&self) -> Option<&Path> {
        (!self.is_held()).then_some(&*self.path)
    }

    /// Returns `true` for a file on a server.
    pub(crate) fn is_remote(&self) -> bool {
        !self.is_held() && is_remote(&self.path)
    }

    /// Returns `true` for a folder.
    pub(crate) fn is_folder(&self) -> bool {
        !self.is_held() && self.path.is_dir()
    }

    /// Returns `true` for standard input.
    pub(crate) fn is_standard_input(&self) -> bool {
        !self.is_held() && self.path.as_os_str() == "-"
    }

    /// Returns `true` for a pipe or a device, which is read once, from its beginning.
    pub(crate) fn is_stream(&self) -> bool {
        let on_disk = !self.is_held() && !self.is_remote();
        let is_no_file = |path| std::fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir());
        self.is_standard_input() || (on_disk && is_no_file(&self.path))
    }

    /// Returns the extension in lower case, without the point.
    pub(crate) fn extension(&self) -> String {
        self.path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default()
    }

    /// Returns the length \[bytes\], 0 where it is not known.
    pub(crate) fn len(&self) -> u64 {
        match &self.held {
            Some(held) => held.bytes.len() as u64,
            None if self.packed.is_some() => self.packed.as_ref().map_or(0, |packed| packed.archive().len()),
            #[cfg(feature = "remote")]
            None if self.is_remote() => crate::remote::open(self).map_or(0, |file| file.len()),
            None => std::fs::metadata(&self.path).map_or(0, |metadata| metadata.len()),
        }
    }

    /// Returns the file of the same name with another extension, in lower or upper case, if there
    /// is one.
    pub(crate) fn beside(&self, extension: &str) -> Option<Input> {
        [extension.to_string(), extension.to_uppercase()].iter().find_map(|e| self.other(self.path.with_extension(e)))
    }

    /// Returns the file whose name is longer by a suffix, such as `.msk`, if there is one.
    pub(crate) fn with_suffix(&self, suffix: &str) -> Option<Input> {
        let mut name = self.path.clone().into_os_string();
        name.push(suffix);
        self.other(name.into())
    }

    /// Returns the file at another path, in the same archive, or of the same held bytes.
    pub(crate) fn other(&self, path: PathBuf) -> Option<Input> {
        if let Some(packed) = &self.packed {
            return packed.beside(&path);
        }
        let Some(held) = &self.held else { return path.is_file().then(|| Input::path(path)) };
        let of = |path: &Path| path.file_name().map(OsStr::to_ascii_lowercase);
        let (_, bytes) = held.beside.iter().find(|(name, _)| of(name) == of(&path))?;
        Some(Input::bytes(path, Arc::clone(bytes)))
    }

    /// Reads the first bytes.
    pub(crate) fn head(&self, most: u64) -> Result<Vec<u8>> {
        if let Some(packed) = &self.packed {
            return packed.head(self, most);
        }
        let mut head = Vec::new();
        if self.is_standard_input() {
            self.read()?.as_ref().take(most).read_to_end(&mut head).map_err(|e| cannot_read(self, &e))?;
        } else {
            self.open()?.0.take(most).read_to_end(&mut head).map_err(|e| cannot_read(self, &e))?;
        }
        Ok(head)
    }

    /// Opens the input for reading in any order, and returns its length \[bytes\].
    pub(crate) fn open(&self) -> Result<(Reader, u64)> {
        if let Some(packed) = &self.packed {
            let bytes: Arc<[u8]> = packed.read(self)?.into();
            let length = bytes.len() as u64;
            return Ok((Reader::Held(Cursor::new(bytes)), length));
        }
        if let Some(held) = &self.held {
            return Ok((Reader::Held(Cursor::new(Arc::clone(&held.bytes))), held.bytes.len() as u64));
        }
        if self.is_remote() {
            return self.open_remote();
        }
        let fail = |cause: std::io::Error| cannot_read(self, &cause);
        // Opening a pipe would wait for its writer.
        let metadata = std::fs::metadata(&self.path).map_err(fail)?;
        if metadata.is_dir() {
            return Err(fail(ErrorKind::IsADirectory.into()));
        }
        if !metadata.is_file() {
            return Err(Error::read(self, ReadFault::NoFile));
        }
        Ok((Reader::File(File::open(&self.path).map_err(fail)?), metadata.len()))
    }

    /// Opens the input for reading from its beginning. A gzip file is unpacked while it is read.
    pub(crate) fn stream(&self) -> Result<Box<dyn Read>> {
        match &self.packed {
            Some(packed) => packed.stream(self),
            None => Ok(Box::new(self.open()?.0)),
        }
    }

    #[cfg(feature = "remote")]
    fn open_remote(&self) -> Result<(Reader, u64)> {
        let file = crate::remote::open(self)?;
        let length = file.len();
        Ok((Reader::Remote(crate::remote::RemoteReader::new(file)), length))
    }

    #[cfg(not(feature = "remote"))]
    fn open_remote(&self) -> Result<(Reader, u64)> {
        Err(crate::remote::not_built(self))
    }

    /// Reads all bytes. Those of standard input are kept, since they can be read only once.
    ///
    /// # Errors
    /// E301 for a file that cannot be read; E502 for a pipe or a device without an end.
    pub(crate) fn read(&self) -> Result<Cow<'_, [u8]>> {
        static STANDARD_INPUT: OnceLock<Vec<u8>> = OnceLock::new();
        if let Some(packed) = &self.packed {
            return packed.read(self).map(Cow::Owned);
        }
        if let Some(held) = &self.held {
            return Ok(Cow::Borrowed(&held.bytes));
        }
        if self.is_remote() {
            let mut bytes = Vec::new();
            self.open()?.0.read_to_end(&mut bytes).map_err(|e| cannot_read(self, &e))?;
            return Ok(Cow::Owned(bytes));
        }
        if !self.is_standard_input() {
            if std::fs::metadata(&self.path).is_ok_and(|metadata| metadata.is_file()) {
                return std::fs::read(&self.path).map(Cow::Owned).map_err(|e| cannot_read(self, &e));
            }
            let stream = File::open(&self.path).map_err(|e| cannot_read(self, &e))?;
            return self.read_stream(stream).map(Cow::Owned);
        }
        if STANDARD_INPUT.get().is_none() {
            let _ = STANDARD_INPUT.set(self.read_stream(std::io::stdin().lock())?);
        }
        Ok(Cow::Borrowed(STANDARD_INPUT.get().map_or(&[], Vec::as_slice)))
    }

    fn read_stream(&self, stream: impl Read) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        stream.take(MOST_STREAMED + 1).read_to_end(&mut bytes).map_err(|e| cannot_read(self, &e))?;
        if bytes.len() as u64 > MOST_STREAMED {
            let what = format!("it has more than {} MiB, wanted a file", MOST_STREAMED >> 20);
            return Err(Error::read(self, ReadFault::TooMany(what)));
        }
        Ok(bytes)
    }

    /// Reads all text; `wanted` names the expected content in an error.
    pub(crate) fn text(&self, wanted: &str) -> Result<String> {
        String::from_utf8(self.read()?.into_owned()).map_err(|e| {
            let place = e.utf8_error().valid_up_to();
            Error::malformed(self, format!("byte {place} is not UTF-8, wanted {wanted}"))
        })
    }
}

/// Most bytes of a pipe or a device, which need not end.
const MOST_STREAMED: u64 = 128 << 20;

/// Path, or name.
impl fmt::Display for Input {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.packed.as_ref().and_then(Packed::gzip) {
            Some(gzip) => gzip.fmt(f),
            None if self.is_standard_input() => f.write_str("standard input"),
            None => self.path.display().fmt(f),
        }
    }
}

impl<P: Into<PathBuf>> From<P> for Input {
    fn from(path: P) -> Input {
        Input::path(path)
    }
}

impl Input {
    /// Returns the input that a source of a request names.
    pub fn of(source: &Source) -> Input {
        match source.bytes() {
            Some(bytes) => Input::bytes(source.path(), Arc::clone(bytes)),
            None => Input::path(source.path()),
        }
    }
}

impl From<&Input> for Input {
    fn from(input: &Input) -> Input {
        input.clone()
    }
}

/// Reader in any order: a file here or on a server, or bytes in memory.
#[derive(Debug)]
pub(crate) enum Reader {
    File(File),
    Held(Cursor<Arc<[u8]>>),
    #[cfg(feature = "remote")]
    Remote(crate::remote::RemoteReader),
}

impl Read for Reader {
    fn read(&mut self, bytes: &mut [u8]) -> std::io::Result<usize> {
        match self {
            Reader::File(file) => file.read(bytes),
            Reader::Held(held) => held.read(bytes),
            #[cfg(feature = "remote")]
            Reader::Remote(remote) => remote.read(bytes),
        }
    }
}

impl Seek for Reader {
    fn seek(&mut self, to: SeekFrom) -> std::io::Result<u64> {
        match self {
            Reader::File(file) => file.seek(to),
            Reader::Held(held) => held.seek(to),
            #[cfg(feature = "remote")]
            Reader::Remote(remote) => remote.seek(to),
        }
    }
}

/// Returns E301 for a file that the system refuses to open or does not have.
pub fn cannot_read(input: &Input, cause: &std::io::Error) -> Error {
    Error::read(
        input,
        if cause.kind() == ErrorKind::NotFound { ReadFault::Missing } else { ReadFault::CannotOpen(io_words(cause)) },
    )
}
