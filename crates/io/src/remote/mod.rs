//! Files behind `http://`, `https://` and `s3://`: their names and, with the feature `remote`,
//! their reading.
//!
//! Only requested ranges of bytes are fetched, small ones in blocks of 64 KiB. A file must not
//! change while it is read: every range is requested under the tag that the file had at first.

#[cfg(feature = "remote")]
mod file;

use std::borrow::Cow;
use std::collections::HashMap;
use std::ffi::OsStr;
use std::path::Path;
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

#[cfg(feature = "remote")]
pub(crate) use file::{RemoteReader, open};

/// Prefixes of the names of such files.
const SCHEMES: [&str; 3] = ["http://", "https://", "s3://"];

/// Prefixes of reference systems that have the form of addresses; no file of a city lies there.
const SYSTEMS: [&str; 2] = ["http://www.opengis.net/", "https://www.opengis.net/"];

/// Returns `true` when a path is the address of a file on a server.
pub fn is_remote(path: &Path) -> bool {
    path.to_str().is_some_and(|path| scheme_of(path).is_some())
}

/// Returns the scheme that a word begins with, in capitals or not.
fn scheme_of(word: &str) -> Option<&str> {
    let is_first = |scheme: &&str| word.get(..scheme.len()).is_some_and(|first| first.eq_ignore_ascii_case(scheme));
    SCHEMES.iter().find(|scheme| is_first(scheme)).map(|scheme| &word[..scheme.len()])
}

/// Returns the whole addresses, by their form in messages.
fn addresses() -> MutexGuard<'static, HashMap<String, String>> {
    static ADDRESSES: OnceLock<Mutex<HashMap<String, String>>> = OnceLock::new();
    ADDRESSES.get_or_init(Mutex::default).lock().unwrap_or_else(PoisonError::into_inner)
}

/// Returns a word as messages may show it. An address loses its user and anything after a `?`,
/// which often is a signature; this process remembers the whole address. So does an address after a
/// `=`, as in `--terrain=ADDRESS` and `NAME=ADDRESS`. Any other word stays as it is.
///
/// Names of reference systems have the form of addresses, and stay whole.
pub fn told(word: &OsStr) -> Cow<'_, OsStr> {
    let is_system = |word: &str| SYSTEMS.iter().any(|begin| word.starts_with(begin));
    let Some(text) = word.to_str() else { return Cow::Borrowed(word) };
    let starts = std::iter::once(0).chain(text.match_indices('=').map(|(at, _)| at + 1));
    let Some((before, address)) = starts.map(|at| text.split_at(at)).find(|(_, rest)| scheme_of(rest).is_some()) else {
        return Cow::Borrowed(word);
    };
    let told = without_secrets(address);
    if told == address || is_system(address) {
        return Cow::Borrowed(word);
    }
    let whole = format!("{before}{told}");
    addresses().insert(told, address.to_string());
    Cow::Owned(whole.into())
}

/// Returns the whole of an address that [`told`] shortened.
#[cfg(feature = "remote")]
fn address_of(told: &str) -> String {
    addresses().get(told).cloned().unwrap_or_else(|| told.to_string())
}

fn without_secrets(address: &str) -> String {
    let scheme = scheme_of(address).unwrap_or_default();
    let rest = address[scheme.len()..].split(['?', '#']).next().unwrap_or_default();
    let (host, path) = rest.split_at(rest.find('/').unwrap_or(rest.len()));
    let host = host.rsplit_once('@').map_or(host, |(_, host)| host);
    format!("{scheme}{host}{path}")
}

/// Returns the identity of a remote file: its length, and its tag or the time of its last change.
///
/// # Errors
/// E301 if the server does not send them.
#[cfg(feature = "remote")]
pub fn identity(path: &Path) -> crate::error::Result<String> {
    let file = open(&path.into())?;
    Ok(format!("{} {}", file.len(), file.tag()))
}

/// Returns the identity of a remote file.
///
/// # Errors
/// E301: this program was built without the feature `remote`.
#[cfg(not(feature = "remote"))]
pub fn identity(path: &Path) -> crate::error::Result<String> {
    Err(not_built(&path.into()))
}

/// Returns E301 for a build that reads no remote file.
#[cfg(not(feature = "remote"))]
pub(crate) fn not_built(input: &crate::Input) -> crate::Error {
    let why = "this program was built without the feature `remote`, which reads files on servers";
    crate::Error::read(input, crate::error::ReadFault::CannotOpen(why.into()))
}

/// Returns a text of another library without what may be a password in its addresses.
#[cfg(feature = "remote")]
fn without_addresses(text: &str) -> String {
    let of_word = |word: &str| {
        let at = (0..word.len()).find(|at| word.get(*at..).is_some_and(|rest| scheme_of(rest).is_some()));
        at.map_or_else(|| word.to_string(), |at| format!("{}{}", &word[..at], without_secrets(&word[at..])))
    };
    text.split(' ').map(of_word).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_told_without_what_may_be_a_password() {
        for (word, wanted) in [
            ("https://user:word@host.example/a/dsm.tif?sig=abc#d", "https://host.example/a/dsm.tif"),
            ("http://host:8080/dsm.tif", "http://host:8080/dsm.tif"),
            ("s3://bucket/a@b/dsm.tif", "s3://bucket/a@b/dsm.tif"),
            ("https://host", "https://host"),
            ("HTTPS://user:word@host.example/dsm.tif?sig=abc", "HTTPS://host.example/dsm.tif"),
            ("--terrain=https://user:word@host/a.tif?b=c&d", "--terrain=https://host/a.tif"),
            ("m=S3://key:word@bucket/m.tif", "m=S3://bucket/m.tif"),
            ("a?b@c", "a?b@c"),
            ("--title=see it", "--title=see it"),
            ("http://www.opengis.net/gml/srs/epsg.xml#25832", "http://www.opengis.net/gml/srs/epsg.xml#25832"),
            ("ftp://a:b@c/d", "ftp://a:b@c/d"),
        ] {
            assert_eq!(told(OsStr::new(word)), OsStr::new(wanted));
            let is_address = ["http", "HTTP", "s3"].iter().any(|scheme| word.starts_with(scheme));
            assert_eq!(is_remote(Path::new(word)), is_address, "{word}");
        }
    }
}
