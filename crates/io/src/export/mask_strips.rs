//! The mask of one UAV as a plain GeoTIFF that is written while the mask is made.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::JoinHandle;

use super::Batch;
use super::batch::complete;
use super::files::cannot_write;
use super::map::add_described;
use super::map_result::MaskValues;
use crate::error::Result;
use crate::formats::ClassStrips;
use crate::raster::GeoRef;

/// Least number of bytes that are sent to the disk at once.
const BYTES_TO_DISK: usize = 4 << 20;

/// Inverse of the least part of a file that is sent at once. Where each transfer costs as much as
/// the whole file, there are thus few transfers.
const PART_TO_DISK: usize = 8;

/// File of a batch to which the rows of a mask are written one after another. Its content equals
/// that of [`super::add_map`] for the same mask in memory.
#[derive(Debug)]
pub struct MaskStrips {
    path: PathBuf,
    values: MaskValues,
    strips: ClassStrips<BufWriter<File>>,
    /// Second handle of the file. `None` where the file can be opened only once: then all of it
    /// goes to the disk at the end.
    to_disk: Option<ToDisk>,
}

/// Second handle of a file, which sends written bytes to the disk while more are made.
///
/// PERF: otherwise the end would wait for all of them.
#[derive(Debug)]
struct ToDisk {
    file: Arc<File>,
    n_written: usize,
    /// Number of written bytes that are not yet sent.
    n_waiting: usize,
    running: Option<JoinHandle<std::io::Result<()>>>,
}

impl ToDisk {
    fn new(file: File) -> Self {
        ToDisk { file: Arc::new(file), n_written: 0, n_waiting: 0, running: None }
    }

    /// Counts written bytes, and sends them once they are enough.
    fn add(&mut self, n_bytes: usize) -> std::io::Result<()> {
        self.n_written += n_bytes;
        self.n_waiting += n_bytes;
        let least = BYTES_TO_DISK.max(self.n_written / PART_TO_DISK);
        if self.n_waiting < least || self.running.as_ref().is_some_and(|thread| !thread.is_finished()) {
            return Ok(());
        }
        self.finish()?;
        self.n_waiting = 0;
        let file = Arc::clone(&self.file);
        // Without a new thread, the bytes go to the disk at the end.
        self.running = std::thread::Builder::new().spawn(move || file.sync_data()).ok();
        Ok(())
    }

    /// Waits for the running transfer. An error of a disk is returned once, to the first caller
    /// that waits for it.
    fn finish(&mut self) -> std::io::Result<()> {
        match self.running.take().map(JoinHandle::join) {
            Some(Ok(done)) => done,
            Some(Err(panic)) => std::panic::resume_unwind(panic),
            None => Ok(()),
        }
    }
}

impl MaskStrips {
    /// Begins the file under its temporary name.
    ///
    /// # Errors
    /// Errors of [`Batch::add`].
    pub fn begin(batch: &mut Batch, path: &Path, georef: &GeoRef, values: MaskValues) -> Result<Self> {
        let out = batch.begin(path)?;
        let to_disk = out.get_ref().try_clone().ok().map(ToDisk::new);
        let strips = ClassStrips::new(out, (georef.n_rows(), georef.n_cols()))?;
        Ok(MaskStrips { path: path.to_path_buf(), values, strips, to_disk })
    }

    /// Writes whole rows of the mask, from the north.
    ///
    /// # Errors
    /// E401 if writing fails.
    pub fn push(&mut self, mask: &[u8]) -> Result<()> {
        self.strips.push(&self.values.of(mask))?;
        let sent = self.to_disk.as_mut().map_or(Ok(()), |to_disk| to_disk.add(mask.len()));
        sent.map_err(|e| cannot_write(&self.path, &e))
    }

    /// Completes the file, once all rows are written, and adds the sidecar with the names of its
    /// classes.
    ///
    /// # Errors
    /// Errors of [`Batch::add`]; internal errors from the encoder.
    pub fn finish(self, batch: &mut Batch, described: (&GeoRef, &str, &str)) -> Result<()> {
        let MaskStrips { path, values, strips, mut to_disk } = self;
        to_disk.as_mut().map_or(Ok(()), ToDisk::finish).map_err(|e| cannot_write(&path, &e))?;
        add_described(batch, &path, described, values, |_, image, metadata| {
            complete(&path, strips.finish(image, metadata)?)
        })
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn what_a_disk_refuses_is_not_lost_though_nobody_waited_for_it() {
        // No disk is behind this file: the kernel refuses to send it there.
        let mut to_disk = ToDisk::new(File::create("/dev/null").expect("a device of every system"));
        to_disk.add(BYTES_TO_DISK - 1).expect("nothing is sent yet");
        to_disk.finish().expect("nothing was sent");
        to_disk.add(1).expect("it is sent, not waited for");
        to_disk.finish().expect_err("it was refused");
        to_disk.finish().expect("it was told");
    }
}
