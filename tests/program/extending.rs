//! The changes in docs/extending.md fit the source: each hunk's old lines stand in the file that it names.

use crate::support::project;

/// Returns the blocks of the page that change files, as the name of the file and its hunks.
fn changes(page: &str) -> Vec<(&str, Vec<&str>)> {
    let blocks = page.split("\n```diff\n--- ").skip(1);
    blocks
        .map(|block| {
            let (block, _) = block.split_once("\n```\n").expect("the block ends");
            let mut hunks = block.split("\n@@\n");
            (hunks.next().unwrap(), hunks.collect())
        })
        .collect()
}

/// Returns the lines that begin with a space, or with the given sign, without it.
fn side(hunk: &str, sign: char) -> String {
    let lines = hunk.lines().filter_map(|line| line.strip_prefix([' ', sign]));
    lines.fold("\n".to_owned(), |text, line| text + line + "\n")
}

#[test]
fn the_worked_changes_fit_the_source() {
    let page = std::fs::read_to_string(project("docs/extending.md")).unwrap();
    let changes = changes(&page);
    assert!(changes.len() >= 10, "{changes:?}");
    for (file, hunks) in changes {
        let source = std::fs::read_to_string(project(file)).unwrap();
        let mut place = 0;
        assert!(!hunks.is_empty(), "{file}");
        for hunk in hunks {
            let (old, new) = (side(hunk, '-'), side(hunk, '+'));
            assert!(old != new && old.len() > 1, "nothing changes in {file}:\n{hunk}");
            let found = source[place..].find(&old);
            let found =
                found.unwrap_or_else(|| panic!("docs/extending.md: not in {file}, or not in this order:{old}"));
            assert!(!source.contains(&new), "{file} has this already:{new}");
            // The last line of a hunk may be the first of the next one.
            place += found + old.trim_end().rfind('\n').unwrap_or(0);
        }
    }
}
