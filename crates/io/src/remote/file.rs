//! Remote file as an input of readers: bytes in any order, fetched by ranges (object_store).
//!
//! All requests of a file together may take 40 s, and more for each byte that is fetched.

use std::collections::HashMap;
use std::io::{Error as IoError, ErrorKind, Read, Seek, SeekFrom};
use std::ops::Range;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use futures_util::StreamExt;
use object_store::aws::AmazonS3Builder;
use object_store::http::HttpBuilder;
use object_store::path::Path as ObjectPath;
use object_store::{ClientOptions, GetOptions, ObjectMeta, ObjectStore, ObjectStoreExt, RetryConfig};
use tokio::runtime::{Builder, Runtime};
use tokio::time::timeout;
use url::Url;

use crate::error::{Error, ReadFault, Result};
use crate::input::Input;
use crate::remote::{address_of, without_addresses};

/// Number of bytes that are fetched if less is requested: headers and indices are read in small
/// pieces.
const BLOCK: u64 = 64 << 10;
/// Largest number of blocks that are kept of a file.
const MOST_BLOCKS: usize = 256;
/// Time that a server may take to connect, and between two parts of an answer.
const PATIENCE: Duration = Duration::from_secs(20);
/// Number of times that a failed request is sent again, and their total time.
const MOST_TRIES: usize = 4;
const MOST_TRYING: Duration = Duration::from_secs(30);
/// Time that a server may take for all requests of a file beside that of the bytes, and the least
/// rate at which it must send these \[bytes/s\].
const GRACE: Duration = Duration::from_secs(40);
const SLOWEST: u64 = 16 << 10;

/// A file on a server.
#[derive(Debug)]
pub(crate) struct RemoteFile {
    /// Address as it appears in messages.
    name: String,
    store: Box<dyn ObjectStore>,
    path: ObjectPath,
    len: u64,
    /// Tag that differs in a later file of the same name.
    tag: Tag,
    /// Blocks by their numbers, with the time of their last request.
    blocks: Mutex<Blocks>,
    /// Time that requests may still take.
    left: Mutex<Duration>,
}

#[derive(Debug)]
enum Tag {
    /// A tag that the server compares.
    Etag(String),
    /// The time of the last change, in words; a fixed time if the server sends neither.
    Time(String),
}

#[derive(Debug, Default)]
struct Blocks {
    held: HashMap<u64, (Arc<[u8]>, u64)>,
    clock: u64,
}

/// Returns the files that this process reads, by their addresses.
fn files() -> &'static Mutex<HashMap<String, Arc<RemoteFile>>> {
    static FILES: OnceLock<Mutex<HashMap<String, Arc<RemoteFile>>>> = OnceLock::new();
    FILES.get_or_init(Mutex::default)
}

/// Time for which a file is not asked for again, after a server took long to fail.
const UNTIL_RETRIED: Duration = Duration::from_secs(60);

/// Returns the last slow failures, by the addresses of their files.
fn failures() -> &'static Mutex<HashMap<String, (Instant, Error)>> {
    static FAILURES: OnceLock<Mutex<HashMap<String, (Instant, Error)>>> = OnceLock::new();
    FAILURES.get_or_init(Mutex::default)
}

/// Returns the runtime in which requests wait for answers.
fn runtime() -> std::io::Result<&'static Runtime> {
    static RUNTIME: OnceLock<Runtime> = OnceLock::new();
    if RUNTIME.get().is_none() {
        // Another library of the process may have installed a provider before.
        let _ = rustls::crypto::ring::default_provider().install_default();
        let made = Builder::new_multi_thread().worker_threads(1).enable_all().thread_name("remote").build()?;
        let _ = RUNTIME.set(made);
    }
    RUNTIME.get().ok_or_else(|| IoError::other("no thread for requests"))
}

/// Opens a file by its address. A process requests it once, unless it changes.
///
/// # Errors
/// E301 if the server refuses it, or sends no parts of files.
pub(crate) fn open(input: &Input) -> Result<Arc<RemoteFile>> {
    let address = input.as_path().to_string_lossy().into_owned();
    let lock = || files().lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(file) = lock().get(&address) {
        return Ok(Arc::clone(file));
    }
    let failed = || failures().lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((at, error)) = failed().get(&address)
        && at.elapsed() < UNTIL_RETRIED
    {
        return Err(error.clone());
    }
    let began = Instant::now();
    let file = RemoteFile::new(&address, &address_of(&address)).map_err(|why| {
        let fault =
            if why.kind() == ErrorKind::NotFound { ReadFault::Missing } else { ReadFault::CannotOpen(why.to_string()) };
        Error::read(input, fault)
    });
    if let Some(error) = file.as_ref().err().filter(|_| began.elapsed() > Duration::from_secs(5)) {
        failed().insert(address.clone(), (Instant::now(), error.clone()));
    }
    let file = Arc::new(file?);
    lock().insert(address, Arc::clone(&file));
    Ok(file)
}

impl RemoteFile {
    /// Requests a file by its whole address; `name` appears in messages.
    fn new(name: &str, address: &str) -> std::io::Result<RemoteFile> {
        let runtime = runtime()?;
        let url = Url::parse(address).map_err(|e| IoError::new(ErrorKind::InvalidInput, format!("no address: {e}")))?;
        let retry = RetryConfig { max_retries: MOST_TRIES, retry_timeout: MOST_TRYING, ..RetryConfig::default() };
        let options = ClientOptions::new()
            .with_allow_http(true)
            .with_connect_timeout(PATIENCE)
            .with_read_timeout(PATIENCE)
            .with_timeout_disabled();
        let (store, path): (Box<dyn ObjectStore>, ObjectPath) = if url.scheme() == "s3" {
            let bucket = url.host_str().unwrap_or_default();
            let store = AmazonS3Builder::from_env().with_bucket_name(bucket).with_client_options(options);
            let path = ObjectPath::from_url_path(url.path()).map_err(|e| in_words(&e.into()))?;
            (Box::new(store.with_retry(retry).build().map_err(|e| in_words(&e))?), path)
        } else {
            // The address itself is the root, so that anything after a `?` stays with it.
            let store = HttpBuilder::new().with_url(url.as_str()).with_client_options(options).with_retry(retry);
            (Box::new(store.build().map_err(|e| in_words(&e))?), ObjectPath::default())
        };
        let began = Instant::now();
        let head = runtime.block_on(async { timeout(GRACE, store.head(&path)).await });
        let ObjectMeta { size, e_tag, last_modified, .. } = head.map_err(|_| too_slow())?.map_err(|e| in_words(&e))?;
        let left = Mutex::new(GRACE.saturating_sub(began.elapsed()));
        let tag = e_tag.map_or_else(|| Tag::Time(last_modified.to_rfc3339()), Tag::Etag);
        Ok(RemoteFile { name: name.to_string(), store, path, len: size, tag, blocks: Mutex::default(), left })
    }

    /// Returns the length \[bytes\].
    pub(crate) fn len(&self) -> u64 {
        self.len
    }

    /// Returns the tag that differs in a later file of the same name.
    pub(crate) fn tag(&self) -> &str {
        match &self.tag {
            Tag::Etag(tag) | Tag::Time(tag) => tag,
        }
    }

    /// Fetches a range of bytes completely.
    fn fetch(&self, range: Range<u64>) -> std::io::Result<Vec<u8>> {
        let wanted = range.end - range.start;
        // A tag that begins with W/ marks equal contents, not equal bytes: servers compare only
        // strong tags.
        let if_match = match &self.tag {
            Tag::Etag(tag) if !tag.starts_with("W/") => Some(tag.clone()),
            _ => None,
        };
        let options = GetOptions { if_match, range: Some(range.clone().into()), ..GetOptions::default() };
        let get = async {
            let found = self.store.get_opts(&self.path, options).await?;
            let is_same = found.meta.size == self.len && self.is_same(&found.meta);
            let is_range = found.range == range;
            let (mut bytes, mut parts) = (Vec::new(), found.into_stream());
            // A server may send more than it was asked for, without an end.
            while bytes.len() as u64 <= wanted && is_same && is_range {
                let Some(part) = parts.next().await else { break };
                bytes.extend_from_slice(&part?);
            }
            Ok::<_, object_store::Error>((is_same, is_range, bytes))
        };
        let failed =
            |why: &str| IoError::other(format!("{}: bytes {} to {}: {why}", self.name, range.start, range.end));
        let began = Instant::now();
        let left = || self.left.lock().unwrap_or_else(PoisonError::into_inner);
        let most = *left() + Duration::from_secs(wanted / SLOWEST);
        let got = runtime()?.block_on(async { timeout(most, get).await });
        *left() = most.saturating_sub(began.elapsed());
        let (is_same, is_range, bytes) = match got.map_err(|_| failed(&too_slow().to_string()))? {
            Ok(found) => found,
            Err(object_store::Error::Precondition { .. }) => {
                self.forget();
                return Err(failed("the file has changed since it was opened"));
            }
            Err(error) => return Err(failed(&in_words(&error).to_string())),
        };
        if !is_same {
            self.forget();
            return Err(failed("the file has changed since it was opened"));
        }
        if !is_range || bytes.len() as u64 != wanted {
            return Err(failed("the server sent other bytes than it was asked for"));
        }
        Ok(bytes)
    }

    fn is_same(&self, found: &ObjectMeta) -> bool {
        match &self.tag {
            Tag::Etag(tag) => found.e_tag.as_ref() == Some(tag),
            Tag::Time(time) => found.last_modified.to_rfc3339() == *time,
        }
    }

    /// Forgets the file, so that it is requested anew when it is opened next.
    fn forget(&self) {
        let mut files = files().lock().unwrap_or_else(PoisonError::into_inner);
        files.retain(|_, file| !std::ptr::eq(file.as_ref(), self));
    }

    /// Returns a block of bytes, which is kept for a while.
    fn block(&self, number: u64) -> std::io::Result<Arc<[u8]>> {
        let lock = || self.blocks.lock().unwrap_or_else(PoisonError::into_inner);
        {
            let mut blocks = lock();
            blocks.clock += 1;
            let now = blocks.clock;
            if let Some((bytes, used)) = blocks.held.get_mut(&number) {
                *used = now;
                return Ok(Arc::clone(bytes));
            }
        }
        let start = number * BLOCK;
        let bytes: Arc<[u8]> = self.fetch(start..(start + BLOCK).min(self.len))?.into();
        let mut blocks = lock();
        if blocks.held.len() >= MOST_BLOCKS
            && let Some(oldest) = blocks.held.iter().min_by_key(|(_, (_, used))| *used).map(|(number, _)| *number)
        {
            blocks.held.remove(&oldest);
        }
        let now = blocks.clock;
        blocks.held.insert(number, (Arc::clone(&bytes), now));
        Ok(bytes)
    }
}

/// Returns the failure of a server that never ends its answers, or hardly begins them.
fn too_slow() -> IoError {
    IoError::new(ErrorKind::TimedOut, "the server answers too slowly")
}

/// Returns a failed request on one line, with its cause.
fn in_words(error: &object_store::Error) -> IoError {
    let kind = match error {
        object_store::Error::NotFound { .. } => ErrorKind::NotFound,
        object_store::Error::PermissionDenied { .. } | object_store::Error::Unauthenticated { .. } => {
            return IoError::new(ErrorKind::PermissionDenied, "the server refuses it: permission denied");
        }
        object_store::Error::NotSupported { .. } => {
            return IoError::new(ErrorKind::Unsupported, "the server sends no parts of files (HTTP ranges)");
        }
        _ => ErrorKind::Other,
    };
    let mut cause: &dyn std::error::Error = error;
    while let Some(deeper) = cause.source() {
        cause = deeper;
    }
    let text = without_addresses(&cause.to_string());
    if text.contains("timed out") {
        return too_slow();
    }
    IoError::new(kind, text.lines().next().unwrap_or("the request failed").to_string())
}

/// Remote file that is read from a position on.
#[derive(Debug)]
pub(crate) struct RemoteReader {
    file: Arc<RemoteFile>,
    at: u64,
}

impl RemoteReader {
    pub(crate) fn new(file: Arc<RemoteFile>) -> Self {
        RemoteReader { file, at: 0 }
    }
}

impl Read for RemoteReader {
    fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
        let left = self.file.len.saturating_sub(self.at);
        let n = (out.len() as u64).min(left);
        if n == 0 {
            return Ok(0);
        }
        #[expect(clippy::cast_possible_truncation, reason = "no more than the length of a slice")]
        let n = if n >= BLOCK {
            // Large ranges are read once, so they are not kept.
            let bytes = self.file.fetch(self.at..self.at + n)?;
            out[..bytes.len()].copy_from_slice(&bytes);
            bytes.len()
        } else {
            let block = self.file.block(self.at / BLOCK)?;
            let from = &block[(self.at % BLOCK) as usize..];
            let n = from.len().min(n as usize);
            out[..n].copy_from_slice(&from[..n]);
            n
        };
        self.at += n as u64;
        Ok(n)
    }
}

impl Seek for RemoteReader {
    fn seek(&mut self, to: SeekFrom) -> std::io::Result<u64> {
        let at = match to {
            SeekFrom::Start(at) => Some(at),
            SeekFrom::End(by) => self.file.len.checked_add_signed(by),
            SeekFrom::Current(by) => self.at.checked_add_signed(by),
        };
        self.at = at.ok_or_else(|| IoError::new(ErrorKind::InvalidInput, "a place before the file"))?;
        Ok(self.at)
    }
}
