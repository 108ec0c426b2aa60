//! Files for reading, opened.

use std::fs::File;
use std::path::{Path, PathBuf};

use crate::error::{Error, Result, io_words};

/// Opens a file for reading and returns it with its length \[bytes\]; the error names the path.
pub(crate) fn open_file(path: &Path) -> Result<(File, u64)> {
    let fail = |cause: std::io::Error| cannot_read(path, &cause);
    // Opening a pipe waits for who writes into it.
    let metadata = std::fs::metadata(path).map_err(fail)?;
    if metadata.is_dir() {
        return Err(fail(std::io::ErrorKind::IsADirectory.into()));
    }
    if !metadata.is_file() {
        let text =
            format!("cannot read {}: it is a pipe or a device, wanted a file: it is read in any order", path.display());
        return Err(Error::file(301, text).with_hint("save it as a file first"));
    }
    let file = File::open(path).map_err(fail)?;
    Ok((file, metadata.len()))
}

/// E301: what the system says of a file that cannot be read; where there is none, the name beside it that was meant.
pub fn cannot_read(path: &Path, cause: &std::io::Error) -> Error {
    let error = Error::file(301, format!("cannot read {}: {}", path.display(), io_words(cause)));
    match near_name(path).filter(|_| cause.kind() == std::io::ErrorKind::NotFound) {
        Some(near) => error.with_hint(format!("did you mean {}?", near.display())),
        None => error,
    }
}

/// The file whose name is most like that of a missing one in the same folder: few letters differ, or only the extension.
fn near_name(path: &Path) -> Option<PathBuf> {
    const MOST_FILES: usize = 10_000;
    const MOST_EDITS: usize = 2;
    let lower = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let wanted = lower(path);
    let edits = |other: &Path| match other.file_stem() == path.file_stem() {
        true => 1,
        false => edits_between(&wanted, &lower(other)),
    };
    let files =
        std::fs::read_dir(folder).ok()?.take(MOST_FILES).flatten().map(|entry| path.with_file_name(entry.file_name()));
    let near =
        files.map(|file| (edits(&file), file)).filter(|(n, _)| *n <= MOST_EDITS && 2 * n < wanted.chars().count());
    near.min().map(|(_, file)| file)
}

/// How many letters must be put in, left out or changed to make one word of another (Levenshtein).
fn edits_between(from: &str, to: &str) -> usize {
    let to: Vec<char> = to.chars().collect();
    let mut row: Vec<usize> = (0..=to.len()).collect();
    for (k, letter) in from.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = k + 1;
        for (j, other) in to.iter().enumerate() {
            let changed = diagonal + usize::from(letter != *other);
            diagonal = row[j + 1];
            row[j + 1] = changed.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[to.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edits_are_counted() {
        for (from, to, n) in
            [("", "", 0), ("dsm.tif", "dsm.tif", 0), ("dem.tif", "dsm.tif", 1), ("ab", "ba", 2), ("abc", "", 3)]
        {
            assert_eq!((edits_between(from, to), edits_between(to, from)), (n, n), "{from} {to}");
        }
    }
}
