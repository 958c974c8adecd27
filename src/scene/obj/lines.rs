//! The lines of an OBJ file that its triangles come from.

use crate::input::read_whole;
use std::path::Path;

/// Largest file that is read again for its lines.
const MAX_BYTES: u64 = 1 << 30;

/// Returns for each triangle of a mesh the line of its face, counted from 1. A face of n corners is n - 2 triangles.
/// Returns `None` if the faces that can be counted easily do not make `count` triangles, or if the file cannot be read
/// again.
pub fn triangle_lines(path: &Path, count: usize) -> Option<Vec<u32>> {
    // A pipe has nothing left.
    let bytes = path.is_file().then(|| read_whole(path, MAX_BYTES).ok()).flatten()?;
    let mut lines = Vec::with_capacity(count);
    for (index, line) in bytes.split(|&byte| byte == b'\n').enumerate() {
        let line = line.split(|&byte| byte == b'#').next().unwrap_or_default();
        let mut words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        if words.next() == Some(b"f") {
            lines.extend(std::iter::repeat_n(index as u32 + 1, words.count().saturating_sub(2)));
        }
    }
    (lines.len() == count).then_some(lines)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_triangle_has_the_line_of_its_face() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m.obj");
        std::fs::write(&path, "v 0 0 0\n# f 1 2 3\nf 1 2 3 # 4\n\n f 1/1 2/2 3/3 4/4\r\nf 1 2\nf 4 5 6").unwrap();
        assert_eq!(triangle_lines(&path, 4), Some(vec![3, 5, 5, 7]));
        assert_eq!(triangle_lines(&path, 5), None);
        assert_eq!(triangle_lines(&folder.path().join("n.obj"), 4), None);
    }
}
