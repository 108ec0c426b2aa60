//! Files that a scene is made of: one file, or several in a folder, in an archive, or named as
//! `A+B`.

use std::path::{Path, PathBuf};

use super::source::source_of;
use crate::city::Source;
use crate::error::{Error, ReadFault, Result, Wanted};
use crate::format::{FileFormat, FileKind};
use crate::input::{Input, cannot_read};
use crate::packed::members;

/// Deepest nesting of archives.
const MOST_NESTED: usize = 2;

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
        expand(input, 0, &mut found)?;
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
fn expand(input: &Input, depth: usize, found: &mut Vec<(Input, FileFormat)>) -> Result<()> {
    if let Some(parts) = parts_of(input) {
        return parts.iter().try_for_each(|part| expand(part, depth, found));
    }
    let format = FileFormat::of(input)?;
    match (format, format.archive()) {
        (FileFormat::RasterFolder, _) => {
            let files = files_in(input.as_path())?;
            let mut inside = Vec::new();
            files.iter().try_for_each(|file| expand(file, depth + 1, &mut inside))?;
            let is_of_rasters =
                inside.iter().all(|(_, format)| !matches!(format.kind(), Some(FileKind::Vector | FileKind::Mesh)));
            // A folder of rasters is read as one.
            if is_of_rasters { found.push((input.clone(), format)) } else { found.extend(inside) }
        }
        (_, Some(archive)) if depth < MOST_NESTED => {
            for member in members(input, archive)? {
                if !is_sidecar(&member) {
                    expand(&member, depth + 1, found)?;
                }
            }
        }
        _ => found.push((input.clone(), format)),
    }
    Ok(())
}

/// Returns the parts of a word such as `a.geojson+b.geojson`; `None` if it names one file.
fn parts_of(input: &Input) -> Option<Vec<Input>> {
    if input.is_held() || input.as_path().exists() {
        return None;
    }
    let text = input.as_path().to_str()?;
    let parts: Vec<&str> = text.split('+').collect();
    let is_there = |part: &&str| Path::new(part).exists() || crate::remote::is_remote(Path::new(part));
    (parts.len() > 1 && parts.iter().any(is_there)).then(|| parts.into_iter().map(Input::path).collect())
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
    const OF_OTHERS: [&str; 7] = ["txt", "pdf", "html", "md", "jpg", "png", "tfw"];
    let extension = input.extension();
    OF_SHAPEFILE.contains(&extension.as_str()) || OF_OTHERS.contains(&extension.as_str())
}
