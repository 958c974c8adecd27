//! Every library that a `Cargo.toml` asks for has a reason in ARCHITECTURE.md, and no other one is named there.

use crate::support::project;
use std::collections::BTreeSet;

/// The names in the tables of dependencies of a `Cargo.toml`, without our own crates.
fn dependencies(manifest: &str) -> BTreeSet<String> {
    let text = std::fs::read_to_string(project(manifest)).unwrap();
    let mut is_inside = false;
    let mut names = BTreeSet::new();
    for line in text.lines() {
        if line.starts_with('[') {
            is_inside = line.ends_with("dependencies]");
        } else if let (true, Some((name, value))) = (is_inside, line.split_once(" = "))
            && !value.contains("path = ")
        {
            names.insert(name.to_owned());
        }
    }
    names
}

/// The names in backquotes in the first column of the table of libraries.
fn reasons() -> BTreeSet<String> {
    let text = std::fs::read_to_string(project("ARCHITECTURE.md")).unwrap();
    let (_, section) = text.split_once("\n## Libraries\n").unwrap();
    let rows = section.lines().take_while(|line| !line.starts_with("## ")).filter(|line| line.starts_with("| `"));
    let columns = rows.map(|row| row.split('|').collect::<Vec<_>>());
    columns
        .flat_map(|columns| {
            assert!(!columns[2].trim().is_empty(), "no reason: {columns:?}");
            columns[1].split('`').skip(1).step_by(2).map(str::to_owned).collect::<Vec<_>>()
        })
        .collect()
}

#[test]
fn every_library_has_a_reason() {
    let manifests = ["Cargo.toml", "vecmath/Cargo.toml", "fuzz/Cargo.toml"];
    let used: BTreeSet<String> = manifests.into_iter().flat_map(dependencies).collect();
    assert!(used.len() > 15, "{used:?}");
    assert_eq!(reasons(), used);
}
