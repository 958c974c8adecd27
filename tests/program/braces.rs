//! What the program says to a missing brace: it names the block that has none.

use crate::mistakes::{broken, says};
use crate::parse_errors::refusal;
use crate::support::project;

#[test]
fn a_missing_brace_is_named_with_the_block_that_it_ends() {
    let closed = "radius 1\n  }";
    for next in ["Sphere { center 0 0 0 radius 1 }", "MaterialIndex 0 Sphere { center 0 0 0 radius 1 }"] {
        let first = next.split(' ').next().unwrap();
        let message = format!("s.txt:9:3: expected '}}' to end the 'Sphere' of line 6, found '{first}'");
        says(&broken(closed, &format!("radius 1\n  {next}")), &message, "");
    }
    says(
        &broken("Material { } }", "Material { }"),
        "s.txt:3:1: expected '}' to end the 'Materials' of line 2, found 'Group'",
        "",
    );
    says(
        &broken("Material { } }", "Material { diffuseColor 1 1 1 Material { } }"),
        "s.txt:2:58: expected '}' to end the 'Material' of line 2, found 'Material'",
        "",
    );
    says(
        &broken("angle 90 }", "angle 90"),
        "s.txt:2:1: expected '}' to end the 'PerspectiveCamera' of line 1, found 'Materials'",
        "",
    );
    says(
        &broken("radius 1\n  }", "radius 1"),
        "s.txt:9:2: expected '}' to end the 'Sphere' of line 6, found the end of the file",
        "",
    );
    let nested = "Transform { Translate 1 0 0 Group { numObjects 0";
    says(
        &broken("Sphere {\n    center 0 0 0\n    radius 1\n  }\n}", nested),
        "s.txt:6:51: expected '}' to end the 'Group' of line 6, found the end of the file",
        "these blocks have no '}': the 'Group' of line 3, the 'Transform' of line 6, the 'Group' of line 6",
    );
    // A brace too many, and a word in the wrong block.
    says(
        &broken("radius 1\n  }", "radius 1\n  } }\n  Sphere { }"),
        "s.txt:10:3: 'Sphere' stands outside of every block",
        "'}' too many",
    );
    says(
        &broken("center 0 0 0", "MaterialIndex 0 center 0 0 0"),
        "s.txt:7:5: 'MaterialIndex' does not belong into 'Sphere'",
        "",
    );
    says(&broken("Sphere {", "Sphere"), "s.txt:7:5: expected '{' after 'Sphere', found 'center'", "");
}

#[test]
fn the_indentation_tells_which_block_has_no_brace() {
    for (name, braces) in [("scene04_axes.txt", 19), ("scene06_bunny_1k.txt", 10)] {
        let scene = std::fs::read_to_string(project("data").join(name)).unwrap();
        let lines: Vec<&str> = scene.lines().collect();
        let closing: Vec<usize> = (0..lines.len()).filter(|&line| lines[line].trim() == "}").collect();
        assert_eq!(closing.len(), braces);
        for line in closing {
            let blanks = lines[line].trim_end_matches('}');
            let word = |line: &usize| {
                lines[*line].strip_prefix(blanks)?.strip_suffix(" {").filter(|word| !word.starts_with(' '))
            };
            let opening = (0..line).rev().find(|line| word(line).is_some()).unwrap();
            let message =
                format!("expected '}}' to end the '{}' of line {}", word(&opening).unwrap(), opening + 1);
            let said = refusal(&[&lines[..line], &lines[line + 1..]].concat().join("\n"));
            assert!(said.contains(&message), "{name}, line {}: {message}\n{said}", line + 1);
        }
    }
    // In one line nothing tells, nor without indentation.
    for (scene, place) in [
        ("Transform { Sphere { center 0 0 0 radius 1 } Sphere {", "6:48"),
        ("Transform {\n  Sphere {\n  center 0 0 0\n  radius 1\n  }\n  Sphere {", "11:3"),
    ] {
        let message = format!("s.txt:{place}: expected '}}' after the object of the 'Transform' of line 6");
        says(&broken("Sphere {", scene), &message, "put several objects into a 'Group'");
    }
    // An untidy brace is not a missing one.
    let sphere = "Sphere {\n    center 0 0 0\n    radius 1\n  }\n}";
    let untidy = "Group {\n    numObjects 1\n    Sphere {\n      radius 1 center 0 0 0\n  }\n  }";
    says(
        &broken(sphere, untidy),
        "s.txt:11:4: expected '}' to end the 'Group' of line 3, found the end of the file",
        "",
    );
}
