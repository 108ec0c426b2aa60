//! Files that a scene is made of: one file, or several in a folder, in an archive, or named as
//! `A+B`.

use std::path::{Path, PathBuf};

use super::source::source_of;
use crate::city::Source;
use crate::error::{Error, ReadFault, Result, Wanted};
use crate::format::{FileFormat, FileKind};
use crate::input::{Input, cannot_read};
use crate::packed::files_of;
use crate::remote::is_remote;

/// Files of one scene, all of one format.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SceneFiles {
    /// Files, at least one.
    pub files: Vec<Input>,
    /// Format of all of them.
    pub format: FileFormat,
    /// Number of files beside them that are no scene.
    pub n_others: usize,
}

impl SceneFiles {
    /// Finds the files of a scene. A folder of rasters is one file.
    ///
    /// # Errors
    /// E301 and E302 for what cannot be read; E302 for files of two formats, or of one that is not
    /// read.
    pub fn of(input: &Input) -> Result<SceneFiles> {
        let mut found = Vec::new();
        expand(input, &mut found)?;
        let (scenes, others): (Vec<_>, Vec<_>) = found.into_iter().partition(|(_, format)| format.kind().is_some());
        let is_alone = scenes.is_empty() && others.len() == 1;
        let Some((_, format)) = scenes.first().or(others.first().filter(|_| is_alone)) else {
            return Err(Error::read(input, ReadFault::Nothing(Wanted::Building)));
        };
        let format = *format;
        if let Some((other, of)) = scenes.iter().find(|(_, of)| *of != format) {
            let what = format!("{other} is {}, beside {}; wanted files of one format", of.name(), format.name());
            return Err(Error::malformed(input, what));
        }
        let n_others = others.len();
        let files = if scenes.is_empty() { others } else { scenes };
        let files = files.into_iter().map(|(file, _)| file).collect();
        Ok(SceneFiles { files, format, n_others })
    }

    /// Returns the files, or the archives that they lie in, with their hashes.
    ///
    /// # Errors
    /// E301 if one cannot be read.
    pub(super) fn sources(&self, always_hash: bool) -> Result<Vec<Source>> {
        let mut on_disk: Vec<&Input> = self.files.iter().map(Input::on_disk).collect();
        on_disk.dedup();
        on_disk.into_iter().map(|input| source_of(input, always_hash)).collect()
    }

    /// Returns what the files hold; `None` for a format that is not read.
    pub fn kind(&self) -> Option<FileKind> {
        self.format.kind()
    }
}

/// Appends the files that an input names, with their formats.
fn expand(input: &Input, found: &mut Vec<(Input, FileFormat)>) -> Result<()> {
    if let Some(parts) = parts_of(input) {
        return parts.iter().try_for_each(|part| expand(part, found));
    }
    let files = files_of(input)?;
    if !matches!(files.as_slice(), [(_, FileFormat::RasterFolder)]) {
        let is_alone = files.len() == 1;
        found.extend(files.into_iter().filter(|(file, _)| is_alone || !is_sidecar(file)));
        return Ok(());
    }
    let mut inside = Vec::new();
    files_in(input.as_path())?.iter().try_for_each(|file| expand(file, &mut inside))?;
    let is_raster = |(_, format): &(_, FileFormat)| matches!(format.kind(), Some(FileKind::Raster) | None);
    // A folder of rasters is read as one.
    if inside.iter().all(is_raster) {
        found.extend(files);
    } else {
        found.extend(inside);
    }
    Ok(())
}

/// Returns the files and folders that a word names: itself, or those of `A+B`.
pub fn named_files(word: &Path) -> Vec<PathBuf> {
    match parts_of(&word.into()) {
        Some(parts) => parts.iter().map(|part| part.as_path().to_path_buf()).collect(),
        None => vec![word.to_path_buf()],
    }
}

/// Returns the parts of a word such as `a.geojson+b.geojson`; `None` if it names one file.
fn parts_of(input: &Input) -> Option<Vec<Input>> {
    if input.is_held() || input.as_path().exists() {
        return None;
    }
    let text = input.as_path().to_str()?;
    let is_address =
        |part: &str| is_remote(Path::new(part)) && !part.split('+').skip(1).any(|p| is_remote(Path::new(p)));
    let is_there = |part: &str| Path::new(part).exists() || is_address(part);
    let (mut parts, mut rest, mut n_there) = (Vec::new(), text, 0);
    loop {
        // A name may hold a plus itself: the longest one of a file that exists counts.
        let ends = rest.match_indices('+').map(|(at, _)| at).chain([rest.len()]);
        let found = ends.clone().rfind(|end| is_there(&rest[..*end]));
        n_there += usize::from(found.is_some());
        let end = found.or_else(|| ends.clone().next())?;
        parts.push(Input::path(&rest[..end]));
        match rest.get(end + 1..) {
            Some(more) => rest = more,
            None => break,
        }
    }
    (parts.len() > 1 && n_there > 0).then_some(parts)
}

/// Returns the files in a folder, sorted by name, without hidden ones.
fn files_in(folder: &Path) -> Result<Vec<Input>> {
    let failed = |e: std::io::Error| cannot_read(&folder.into(), &e);
    let mut paths: Vec<PathBuf> = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let is_hidden = path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
        if !is_hidden && path.is_file() && !is_sidecar(&Input::path(&path)) {
            paths.push(path);
        }
    }
    paths.sort();
    Ok(paths.into_iter().map(Input::path).collect())
}

/// Returns `true` for files that describe others and are none of a scene.
fn is_sidecar(input: &Input) -> bool {
    const OF_SHAPEFILE: [&str; 10] = ["shx", "dbf", "prj", "cpg", "qix", "sbn", "sbx", "qmd", "qml", "qpj"];
    const OF_OTHERS: [&str; 6] = ["pdf", "html", "md", "jpg", "png", "tfw"];
    let extension = input.extension();
    match extension.as_str() {
        // Text beside a scene mostly describes it.
        "txt" => !matches!(FileFormat::of(input), Ok(FileFormat::Xyz)),
        extension => OF_SHAPEFILE.contains(&extension) || OF_OTHERS.contains(&extension),
    }
}
