//! Files behind `http://`, `https://` and `s3://`: how they are named, and, with the feature `remote`, how they are read.
//!
//! No more is read of a file than is asked for, by ranges of its bytes. It must not change while it is read: every range is asked
//! for under the tag that the file had at first.

#[cfg(feature = "remote")]
mod file;

use std::borrow::Cow;
use std::collections::HashMap;
use std::ffi::OsStr;
use std::path::Path;
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

#[cfg(feature = "remote")]
pub(crate) use file::{RemoteReader, open};

/// How names of such files begin.
const SCHEMES: [&str; 3] = ["http://", "https://", "s3://"];

/// How names of reference systems begin that have the form of addresses; no file of a city lies there.
const SYSTEMS: [&str; 2] = ["http://www.opengis.net/", "https://www.opengis.net/"];

/// Whether a path is the address of a file on a server.
pub fn is_remote(path: &Path) -> bool {
    path.to_str().is_some_and(|path| SCHEMES.iter().any(|scheme| path.starts_with(scheme)))
}

/// Addresses with all that belongs to them, by how they are told.
fn addresses() -> MutexGuard<'static, HashMap<String, String>> {
    static ADDRESSES: OnceLock<Mutex<HashMap<String, String>>> = OnceLock::new();
    ADDRESSES.get_or_init(Mutex::default).lock().unwrap_or_else(PoisonError::into_inner)
}

/// A word as it may be told: an address without a user and without what follows a `?`, which often is a signature; anything else
/// as it is. This process goes on to know the whole address.
///
/// Names of reference systems have the form of addresses, and stay whole.
pub fn told(word: &OsStr) -> Cow<'_, OsStr> {
    let is_system = |word: &str| SYSTEMS.iter().any(|begin| word.starts_with(begin));
    let is_address = |word: &&str| is_remote(Path::new(word)) && !is_system(word);
    let Some(address) = word.to_str().filter(is_address) else { return Cow::Borrowed(word) };
    let told = without_secrets(address);
    if told == address {
        return Cow::Borrowed(word);
    }
    addresses().insert(told.clone(), address.to_string());
    Cow::Owned(told.into())
}

/// The whole of an address that was told.
#[cfg(feature = "remote")]
fn address_of(told: &str) -> String {
    addresses().get(told).cloned().unwrap_or_else(|| told.to_string())
}

fn without_secrets(address: &str) -> String {
    let scheme = SCHEMES.iter().find(|scheme| address.starts_with(**scheme)).copied().unwrap_or_default();
    let rest = address[scheme.len()..].split(['?', '#']).next().unwrap_or_default();
    let (host, path) = rest.split_at(rest.find('/').unwrap_or(rest.len()));
    let host = host.rsplit_once('@').map_or(host, |(_, host)| host);
    format!("{scheme}{host}{path}")
}

/// What tells whether a remote file is the same as before: its length, and its tag or the time of its last change.
///
/// # Errors
/// E301 if the server does not tell.
#[cfg(feature = "remote")]
pub fn identity(path: &Path) -> crate::error::Result<String> {
    let file = open(&path.into())?;
    Ok(format!("{} {}", file.len(), file.tag()))
}

/// What tells whether a remote file is the same as before.
///
/// # Errors
/// E301: this program was built without the feature `remote`.
#[cfg(not(feature = "remote"))]
pub fn identity(path: &Path) -> crate::error::Result<String> {
    Err(not_built(&path.into()))
}

/// E301: that no remote file can be read.
#[cfg(not(feature = "remote"))]
pub(crate) fn not_built(input: &crate::Input) -> crate::Error {
    let why = "this program was built without the feature `remote`, which reads files on servers";
    crate::Error::read(input, crate::error::ReadFault::CannotOpen(why.into()))
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
            ("a?b@c", "a?b@c"),
            ("http://www.opengis.net/gml/srs/epsg.xml#25832", "http://www.opengis.net/gml/srs/epsg.xml#25832"),
            ("ftp://a:b@c/d", "ftp://a:b@c/d"),
        ] {
            assert_eq!(told(OsStr::new(word)), OsStr::new(wanted));
            assert_eq!(is_remote(Path::new(word)), word.starts_with("http") || word.starts_with("s3"), "{word}");
        }
    }
}
