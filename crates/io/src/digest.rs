//! SHA-256 (FIPS 180-4), by which files record their inputs and their content.

use std::fmt;

/// SHA-256 digest in progress.
///
/// PERF: `ring` is faster than other libraries on processors without instructions for SHA-256,
/// where the digest of a mask is a quarter of a whole run. Without this feature the library is `sha2`,
/// which has no C.
#[cfg(feature = "ring")]
#[derive(Clone)]
pub struct Sha256(ring::digest::Context);

/// SHA-256 digest in progress.
#[cfg(not(feature = "ring"))]
#[derive(Clone)]
pub struct Sha256(sha2::Sha256);

impl Default for Sha256 {
    /// Begins a digest of no bytes yet.
    fn default() -> Self {
        #[cfg(feature = "ring")]
        let empty = ring::digest::Context::new(&ring::digest::SHA256);
        #[cfg(not(feature = "ring"))]
        let empty = sha2::Digest::new();
        Sha256(empty)
    }
}

impl Sha256 {
    /// Returns the digest of some bytes.
    pub fn digest(bytes: &[u8]) -> [u8; 32] {
        let mut hasher = Sha256::default();
        hasher.update(bytes);
        hasher.finalize()
    }

    /// Adds bytes.
    pub fn update(&mut self, bytes: impl AsRef<[u8]>) {
        #[cfg(feature = "ring")]
        self.0.update(bytes.as_ref());
        #[cfg(not(feature = "ring"))]
        sha2::Digest::update(&mut self.0, bytes);
    }

    /// Returns the digest of all bytes.
    pub fn finalize(self) -> [u8; 32] {
        #[cfg(feature = "ring")]
        let digest = self.0.finish();
        #[cfg(not(feature = "ring"))]
        let digest: [u8; 32] = sha2::Digest::finalize(self.0).into();
        let mut bytes = [0; 32];
        bytes.copy_from_slice(digest.as_ref());
        bytes
    }

    /// Returns the digest in hexadecimal digits.
    pub fn hex_digits(self) -> String {
        self.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }
}

impl fmt::Debug for Sha256 {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Sha256")
    }
}
