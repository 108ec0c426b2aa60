//! Checks of outputs before any work: each is a file that can be made, of a format that the run
//! writes, and no input.

use std::path::{Path, PathBuf};

use super::format::Format;
use super::temporary::Hold;
use crate::error::{Error, Result, WriteFault, io_words};

impl Format {
    /// Returns the format of a path.
    ///
    /// # Errors
    /// Usage error (E104) for an unknown extension.
    pub fn of(path: &Path) -> Result<Format> {
        Format::among(path, &[])
    }

    /// Returns the format of a path; an error lists the `allowed` formats.
    fn among(path: &Path, allowed: &[Format]) -> Result<Format> {
        if path.as_os_str() == "-" {
            return Ok(Format::Stdout);
        }
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        let fault = match Format::of_extension(&extension) {
            Some(format) => return Ok(format),
            None if extension.is_empty() => WriteFault::NoExtension(allowed.to_vec()),
            None => WriteFault::Extension(extension, allowed.to_vec()),
        };
        Err(Error::write(path.display(), fault))
    }
}

/// Rules for the outputs of a run.
#[derive(Debug, Clone, Copy)]
pub struct OutputRules<'a> {
    /// Formats that the command writes.
    pub allowed: &'a [Format],
    /// Files that the run reads.
    pub inputs: &'a [PathBuf],
    /// `true` if existing files may be replaced.
    pub overwrite: bool,
    /// `true` for a bare PNG, with a world file and a sidecar.
    pub bare: bool,
}

/// Checks the outputs of a run before any work, and returns them with their formats. The command
/// must write these formats, and the folders must accept files. No file or sidecar is replaced
/// without leave, no file is given twice, no input is overwritten.
///
/// # Errors
/// Usage errors E104–E106; E401 for a folder that is not there or refuses files.
pub fn check_outputs(outputs: &[PathBuf], rules: OutputRules<'_>) -> Result<Vec<(PathBuf, Format)>> {
    let mut checked: Vec<(PathBuf, Format)> = Vec::new();
    let mut places: Vec<PathBuf> = Vec::new();
    let mut folders: Vec<PathBuf> = Vec::new();
    for path in outputs {
        let format = Format::among(path, rules.allowed)?;
        let refuse = |fault| Error::write(path.display(), fault);
        if !rules.allowed.contains(&format) {
            return Err(refuse(WriteFault::NotThisFormat(rules.allowed.to_vec())));
        }
        if !format.is_built() {
            return Err(refuse(WriteFault::NotBuilt));
        }
        if format == Format::Stdout {
            if checked.iter().any(|(_, f)| *f == Format::Stdout) {
                return Err(refuse(WriteFault::Twice));
            }
            checked.push((path.clone(), format));
            continue;
        }
        let folder = folder_of(path);
        if !folders.contains(&folder) {
            check_folder(path)?;
            folders.push(folder.clone());
        }
        if path.is_dir() {
            return Err(refuse(WriteFault::Folder));
        }
        let place = place_of(path);
        if places.contains(&place) {
            return Err(refuse(WriteFault::Twice));
        }
        let is_input = |file: &Path| {
            let same = |input: &PathBuf| match (std::fs::canonicalize(input), std::fs::canonicalize(file)) {
                (Ok(a), Ok(b)) => a == b,
                _ => false,
            };
            rules.inputs.iter().any(same)
        };
        if is_input(path) {
            return Err(refuse(WriteFault::Input));
        }
        let is_tile = |input: &PathBuf| {
            let folder = std::fs::canonicalize(input).ok().filter(|folder| folder.is_dir());
            folder.is_some_and(|folder| place.parent() == Some(&folder))
        };
        if matches!(format, Format::GeoTiff | Format::AsciiGrid) && rules.inputs.iter().any(is_tile) {
            return Err(refuse(WriteFault::Tile));
        }
        refuse_to_replace(path, rules.overwrite)?;
        for sidecar in sidecars(path, format, rules.bare) {
            if is_input(&sidecar) {
                return Err(refuse(WriteFault::SidecarIsInput(sidecar.display().to_string())));
            }
            refuse_to_replace(&sidecar, rules.overwrite)?;
        }
        places.push(place);
        checked.push((path.clone(), format));
    }
    Ok(checked)
}

/// Refuses a file whose folder does not exist, is a file, or cannot be written.
///
/// # Errors
/// E401.
pub fn check_folder(path: &Path) -> Result<()> {
    let folder = folder_of(&followed(path));
    let refuse =
        |why: &str| Error::write(path.display(), WriteFault::Refused(format!("folder {} {why}", folder.display())));
    match std::fs::metadata(&folder) {
        Ok(found) if !found.is_dir() => return Err(refuse("is a file")),
        Err(cause) if cause.kind() == std::io::ErrorKind::NotFound => return Err(refuse("does not exist")),
        _ => {}
    }
    // Only the system knows who may write where: a file is made there and removed at once.
    let probe = Hold::of(&folder);
    probe.map(|_| ()).map_err(|cause| refuse(&format!("cannot be written: {}", io_words(&cause))))
}

/// Returns the files that may be written beside an output.
pub fn sidecars(path: &Path, format: Format, bare: bool) -> Vec<PathBuf> {
    let beside = |suffix: &str| with_suffix(path, suffix);
    match format {
        Format::GeoTiff => vec![beside(".aux.xml"), path.with_extension("qml")],
        Format::Vrt => vec![path.with_extension("qml")],
        Format::AsciiGrid => vec![path.with_extension("prj"), beside(".json")],
        Format::Bil => vec![path.with_extension("hdr"), path.with_extension("prj"), beside(".json")],
        Format::Csv => vec![beside(".json")],
        Format::Mitsuba => MESHES.iter().map(|mesh| mesh_name(path, mesh)).chain([beside(".json")]).collect(),
        Format::Png if bare => vec![path.with_extension("pgw"), path.with_extension("prj"), beside(".json")],
        _ => Vec::new(),
    }
}

/// Appends to a file name: `a/b.tif` with `.aux.xml` becomes `a/b.tif.aux.xml`.
pub fn with_suffix(path: &Path, suffix: &str) -> PathBuf {
    let mut name = path.as_os_str().to_os_string();
    name.push(suffix);
    PathBuf::from(name)
}

/// The meshes of a Mitsuba scene.
pub(super) const MESHES: [&str; 2] = ["ground", "buildings"];

/// Returns the file of a mesh beside its scene: `NAME_MESH.ply`.
pub(super) fn mesh_name(path: &Path, mesh: &str) -> PathBuf {
    // The name is written into XML, which holds Unicode alone.
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}_{mesh}.ply"))
}

/// Refuses anything that is no file, and an existing file unless it may be replaced.
pub(super) fn refuse_to_replace(path: &Path, overwrite: bool) -> Result<()> {
    let found = std::fs::metadata(path);
    if found.as_ref().is_ok_and(|found| !found.is_file()) {
        return Err(Error::write(path.display(), WriteFault::NoFile));
    }
    if !overwrite && found.is_ok() {
        return Err(Error::write(path.display(), WriteFault::Exists));
    }
    Ok(())
}

pub(super) fn cannot_write(path: &Path, cause: &std::io::Error) -> Error {
    Error::refused(path.display(), cause)
}

pub(super) fn folder_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p.to_path_buf(),
        _ => PathBuf::from("."),
    }
}

/// Returns the one path of a file that is written, behind all symbolic links: of the file, which
/// need not exist, and of its folder.
pub fn place_of(path: &Path) -> PathBuf {
    let place = followed(path);
    let folder = folder_of(&place);
    std::fs::canonicalize(&folder).unwrap_or(folder).join(place.file_name().unwrap_or_default())
}

/// Returns the path that a file is written to: the target of a symbolic link, which need not exist.
pub(super) fn followed(path: &Path) -> PathBuf {
    const MOST_LINKS: usize = 40;
    let mut place = path.to_path_buf();
    for _ in 0..MOST_LINKS {
        let Ok(target) = std::fs::read_link(&place) else { break };
        place = folder_of(&place).join(target);
    }
    place
}
