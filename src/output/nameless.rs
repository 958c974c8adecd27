//! Files without names. Nothing is left of them whatever ends the process, a crash and `SIGKILL` too.

use std::fs::File;
use std::io;
use std::path::Path;

/// Makes a file without a name in a folder, if the system has such files and can name them later.
#[cfg(target_os = "linux")]
pub fn file_in(folder: &Path) -> Option<File> {
    use rustix::fs::OFlags;
    use std::os::unix::fs::OpenOptionsExt;
    if !Path::new(OPEN_FILES).exists() {
        return None;
    }
    File::options().read(true).write(true).custom_flags(OFlags::TMPFILE.bits() as i32).open(folder).ok()
}

/// Gives a file a name that no other file has.
///
/// # Errors
/// The operating system's.
#[cfg(target_os = "linux")]
pub fn name(file: &File, path: &Path) -> io::Result<()> {
    use rustix::fs::{AtFlags, CWD, linkat};
    use std::os::fd::AsRawFd;
    let open = format!("{OPEN_FILES}/{}", file.as_raw_fd());
    Ok(linkat(CWD, open, CWD, path, AtFlags::SYMLINK_FOLLOW)?)
}

/// The folder of the files that this process has open.
#[cfg(target_os = "linux")]
const OPEN_FILES: &str = "/proc/self/fd";

#[cfg(not(target_os = "linux"))]
pub fn file_in(_: &Path) -> Option<File> {
    None
}

#[cfg(not(target_os = "linux"))]
pub fn name(_: &File, _: &Path) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}
