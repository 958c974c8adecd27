//! Reads files whole, as far as a limit.
//!
//! What is read counts, not the size that a directory says: a device or a pipe has none, and may never end.

use std::fs::File;
use std::io::{Error, ErrorKind, Read, Result, Seek, SeekFrom};
use std::path::Path;

/// Largest number of bytes that are read from a device or a pipe.
const MAX_STREAM_BYTES: u64 = 1 << 30;

/// Files of so many bytes and more are read by all threads.
const SHARED_BYTES: u64 = 4 << 20;
/// Bytes that a thread reads at once.
const PART: usize = 1 << 20;

/// Reads a file of at most `limit` bytes.
///
/// # Errors
/// The operating system's, and [`ErrorKind::FileTooLarge`] for a file with more bytes.
pub fn read_whole(path: &Path, limit: u64) -> Result<Vec<u8>> {
    let mut file = File::open(path)?;
    let metadata = file.metadata()?;
    let limit = if metadata.is_file() { limit } else { limit.min(MAX_STREAM_BYTES) };
    let mut bytes = Vec::new();
    if metadata.len() <= limit {
        bytes.try_reserve_exact(metadata.len() as usize)?;
    }
    if metadata.is_file() && (SHARED_BYTES..=limit).contains(&metadata.len()) {
        // There is memory for it; it is asked for again, because then the operating system clears it, when it is used.
        drop(bytes);
        bytes = read_by_all_threads(&file, vec![0; metadata.len() as usize])?;
        file.seek(SeekFrom::Start(bytes.len() as u64))?;
    }
    read_up_to(limit, file, bytes)
}

/// Fills `bytes` from the start of a file, a part by each thread. Returns none if the file has become shorter.
#[cfg(unix)]
fn read_by_all_threads(file: &File, mut bytes: Vec<u8>) -> Result<Vec<u8>> {
    use rayon::prelude::*;
    use std::os::unix::fs::FileExt;
    let parts = bytes.par_chunks_mut(PART).enumerate();
    match parts.try_for_each(|(number, part)| file.read_exact_at(part, (number * PART) as u64)) {
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => Ok(Vec::new()),
        read => read.map(|()| bytes),
    }
}

/// Returns none, so that one thread reads them.
#[cfg(not(unix))]
fn read_by_all_threads(_: &File, _: Vec<u8>) -> Result<Vec<u8>> {
    Ok(Vec::new())
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

    #[test]
    fn long_files_are_read_whole_by_all_threads() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("f");
        let written: Vec<u8> = (0..SHARED_BYTES as u32 + 12_345).map(|i| (i / 1000) as u8 ^ i as u8).collect();
        std::fs::write(&path, &written).unwrap();
        let length = written.len() as u64;
        assert!(read_whole(&path, length).unwrap() == written);
        assert_eq!(read_whole(&path, length - 1).unwrap_err().kind(), ErrorKind::FileTooLarge);
        // As if the file had become shorter, or longer, after its length was asked for.
        let file = File::open(&path).unwrap();
        assert!(read_by_all_threads(&file, vec![0; written.len() + 1]).unwrap().is_empty());
        let start = read_by_all_threads(&file, vec![0; written.len() - 1]).unwrap();
        assert!(cfg!(not(unix)) || start == written[..written.len() - 1]);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn files_without_a_size_are_limited_too() {
        assert!(!read_whole(Path::new("/proc/self/status"), 1 << 20).unwrap().is_empty());
        assert_eq!(read_whole(Path::new("/dev/zero"), 1 << 20).unwrap_err().kind(), ErrorKind::FileTooLarge);
    }
}
