//! OBJ files: all readers agree with each other, and with the simplest one.

use super::must_be_clear;
use a2::objects::Mesh;
use a2::scene::parse_mesh;
use std::path::Path;
use vecmath::{Real, Vector3};

/// Positions of the corners of all triangles.
type Corners = Vec<[Vector3; 3]>;

/// Reads a mesh in every way.
pub fn mesh(data: &[u8], _: &Path) -> bool {
    let path = Path::new("m.obj");
    let read = parse_mesh(path, data);
    let is_read = match &read {
        Ok(file) => must_be_whole(&file.mesh),
        Err(error) => must_be_clear(error, path),
    };
    // What is added to a text of two bytes a character would not be a line of it.
    let Some(text) = std::str::from_utf8(data).ok().filter(|text| !text.contains('\0')) else { return is_read };
    // The reader of plain files gives up at a keyword that it does not know.
    let other = parse_mesh(path, format!("{text}\n\nfa\n").as_bytes());
    match (&read, &other) {
        (Ok(read), Ok(other)) => {
            assert_eq!((read.counts, &read.warnings), (other.counts, &other.warnings));
            assert_eq!(corners(&read.mesh), corners(&other.mesh));
        }
        (Err(_), Err(_)) => {}
        // Only a file that is not plain is asked whether it is of another kind, by its beginning and its length.
        (Ok(_), Err(error)) | (Err(error), Ok(_)) => {
            assert!(error.to_string().contains("this is no OBJ mesh: "), "{error}");
        }
    }
    match (naive(text), read) {
        (Naive::Mesh(expected), Ok(file)) => {
            assert_eq!(file.counts.triangles, expected.len());
            // Other polygons are not cut into fans.
            if file.counts.concave == 0 {
                assert_eq!(corners(&file.mesh), expected);
            }
        }
        (Naive::Mistake, Ok(_)) => panic!("a mistake was not found"),
        (Naive::Mesh(_), Err(error)) => panic!("there is no mistake: {error}"),
        (Naive::Mistake, Err(_)) | (Naive::NotSimple, _) => {}
    }
    is_read
}

fn corners(mesh: &Mesh) -> Corners {
    (0..mesh.triangle_count() as u32).map(|triangle| mesh.corners(triangle)).collect()
}

/// Checks that corners and normals are numbers.
fn must_be_whole(mesh: &Mesh) -> bool {
    for (triangle, corners) in corners(mesh).into_iter().enumerate() {
        let normal = mesh.normal(triangle as u32, [0.5, 0.25, 0.25]);
        let numbers = corners.into_iter().chain([normal]).flat_map(|vector| vector.to_array());
        assert!(numbers.into_iter().all(Real::is_finite), "triangle {triangle}");
    }
    true
}

/// What the naive reader says of a file.
enum Naive {
    /// Something that it does not know stands there.
    NotSimple,
    Mistake,
    Mesh(Corners),
}

/// Reads `v x y z`, `f i j k ...` and comments line by line: vertices, then fans.
fn naive(text: &str) -> Naive {
    let is_simple = |c: char| c == '\n' || c == ' ' || (c.is_ascii_graphic() && c != '\\');
    if !text.starts_with("v ") || !text.chars().all(is_simple) {
        return Naive::NotSimple;
    }
    let lines = || text.lines().filter(|line| !line.trim().is_empty() && !line.trim_start().starts_with('#'));
    if !lines().all(|line| matches!(line.split_whitespace().next(), Some("v" | "f")) && !line.contains('#')) {
        return Naive::NotSimple;
    }
    let statements = || lines().map(|line| line.split_whitespace().collect::<Vec<_>>());
    let mut positions = Vec::new();
    for vertex in statements().filter(|words| words[0] == "v") {
        let Some(position) = vertex.get(1..4).and_then(position) else { return Naive::Mistake };
        positions.push(position);
    }
    let (mut vertices, mut all) = (0, Corners::new());
    for words in statements() {
        if words[0] == "v" {
            vertices += 1;
            continue;
        }
        let corner = |word: &&str| {
            let number: i64 = word.split('/').next()?.parse().ok()?;
            let index = if number < 0 { vertices + number } else { number - 1 };
            positions.get(usize::try_from(index).ok()?).copied()
        };
        let Some(face) = words[1..].iter().map(corner).collect::<Option<Vec<_>>>() else { return Naive::Mistake };
        all.extend((2..face.len()).map(|third| [face[0], face[third - 1], face[third]]));
    }
    let is_finite = |corner: &Vector3| corner.to_array().into_iter().all(Real::is_finite);
    if all.as_flattened().iter().all(is_finite) { Naive::Mesh(all) } else { Naive::Mistake }
}

fn position(words: &[&str]) -> Option<Vector3> {
    let numbers: Vec<Real> =
        words.iter().map(|word| word.parse::<f32>().map(Real::from)).collect::<Result<_, _>>().ok()?;
    Some(Vector3::new(numbers[0], numbers[1], numbers[2]))
}
