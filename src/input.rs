//! Reads files whole, as far as a limit.
//!
//! What is read counts, not the size that a directory says: a device or a pipe has none, and may never end.

use std::fs::File;
use std::io::{Error, ErrorKind, Read, Result};
use std::path::Path;

/// Largest number of bytes that are read from a device or a pipe.
const MAX_STREAM_BYTES: u64 = 1 << 30;

/// Reads a file of at most `limit` bytes.
///
/// # Errors
/// The operating system's, and [`ErrorKind::FileTooLarge`] for a file with more bytes.
pub fn read_whole(path: &Path, limit: u64) -> Result<Vec<u8>> {
    let file = File::open(path)?;
    let metadata = file.metadata()?;
    let limit = if metadata.is_file() { limit } else { limit.min(MAX_STREAM_BYTES) };
    let mut bytes = Vec::new();
    if metadata.len() <= limit {
        bytes.try_reserve_exact(metadata.len() as usize)?;
    }
    read_up_to(limit, file, bytes)
}

/// Reads standard input, at most `limit` bytes.
///
/// # Errors
/// As for [`read_whole`].
pub fn read_standard_input(limit: u64) -> Result<Vec<u8>> {
    read_up_to(limit.min(MAX_STREAM_BYTES), std::io::stdin().lock(), Vec::new())
}

/// Adds at most `limit` bytes to `bytes`.
fn read_up_to(limit: u64, from: impl Read, mut bytes: Vec<u8>) -> Result<Vec<u8>> {
    from.take(limit + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit {
        let message = format!("it holds more than {} GiB, which is the limit", limit >> 30);
        return Err(Error::new(ErrorKind::FileTooLarge, message));
    }
    Ok(bytes)
}

/// Returns whether a file's name is a dash, which stands for standard input or output.
pub fn is_standard(path: &Path) -> bool {
    path.as_os_str() == "-"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_read_up_to_the_limit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("f");
        std::fs::write(&path, [7; 1000]).unwrap();
        assert_eq!(read_whole(&path, 1000).unwrap(), [7; 1000]);
        assert_eq!(read_whole(&path, 999).unwrap_err().kind(), ErrorKind::FileTooLarge);
        assert_eq!(read_whole(&folder.path().join("g"), 999).unwrap_err().kind(), ErrorKind::NotFound);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn files_without_a_size_are_limited_too() {
        assert!(!read_whole(Path::new("/proc/self/status"), 1 << 20).unwrap().is_empty());
        assert_eq!(read_whole(Path::new("/dev/zero"), 1 << 20).unwrap_err().kind(), ErrorKind::FileTooLarge);
    }
}
