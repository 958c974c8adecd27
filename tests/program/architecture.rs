//! One direction: the modules of `src/` import what the list of arrows in ARCHITECTURE.md allows, and nothing else.

use crate::rust_source::{blanked, imports, without_tests};
use crate::support::project;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// A module and the modules that it may import, in the order of the list.
type Arrows = Vec<(String, BTreeSet<String>)>;

/// The list of arrows: a line `module: import import ...` for each module, in the code block below the heading.
fn arrows(page: &str) -> Arrows {
    let list = page.split_once("\n## The arrows\n").expect("ARCHITECTURE.md has a heading 'The arrows'").1;
    let block = list.split("```").nth(1).expect("a code block stands below the heading 'The arrows'");
    let lines = block.lines().skip(1).filter(|line| !line.trim().is_empty());
    let arrow = |line: &str| {
        let (module, imports) = line.split_once(':').unwrap_or_else(|| panic!("no colon in the arrows: {line}"));
        (module.trim().to_owned(), imports.split_whitespace().map(str::to_owned).collect())
    };
    lines.map(arrow).collect()
}

/// One import of another module.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Import {
    from: String,
    to: String,
    file: String,
    line: usize,
}

/// Adds the Rust files under a folder, as paths below `src`, and what they hold; test modules with files of their own
/// (`#[cfg(test)] mod tests;`) are left out.
fn read_sources(folder: &Path, below: &str, sources: &mut BTreeMap<String, String>) {
    let mut entries: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        let name = format!("{below}{}", path.file_name().unwrap().to_str().unwrap());
        if path.is_dir() {
            read_sources(&path, &format!("{name}/"), sources);
        } else if name.ends_with(".rs") {
            sources.insert(name, std::fs::read_to_string(path).unwrap());
        }
    }
}

/// All imports from one module to another.
fn all_imports(sources: &BTreeMap<String, String>) -> Vec<Import> {
    let root = &sources["lib.rs"];
    let modules = declared_modules(root);
    let blank: BTreeMap<&String, _> =
        sources.iter().map(|(file, text)| (file, without_tests(&blanked(text)))).collect();
    let test_files: Vec<String> = blank
        .iter()
        .flat_map(|(file, (_, test_modules))| {
            let folder = file.rsplit_once('/').map_or(String::new(), |(folder, _)| format!("{folder}/"));
            test_modules.iter().map(move |module| format!("{folder}{module}.rs"))
        })
        .collect();
    let mut found = Vec::new();
    for (file, (text, _)) in blank.iter().filter(|(file, _)| !test_files.contains(file)) {
        // bvh/single.rs is bvh::single, bvh/mod.rs is bvh.
        let path = file.trim_end_matches(".rs").trim_end_matches("/mod");
        let (from, depth) = (path.split('/').next().unwrap().to_owned(), path.split('/').count());
        for (line, to) in imports(text, depth, matches!(file.as_str(), "lib.rs"), &modules) {
            if to != from {
                found.push(Import { from: from.clone(), to, file: format!("src/{file}"), line });
            }
        }
    }
    found
}

/// The modules that `lib.rs` declares.
fn declared_modules(root: &str) -> BTreeSet<String> {
    let declared = root.lines().filter_map(|line| {
        let line = line.trim_start_matches("pub ").trim_start_matches("pub(crate) ");
        Some(line.strip_prefix("mod ")?.strip_suffix(';')?.to_owned())
    });
    declared.collect()
}

/// Returns what is wrong with the imports, a line each: arrows that are not in the list, and unused arrows.
fn complaints(imports: &[Import], arrows: &Arrows) -> Vec<String> {
    let allowed: BTreeMap<&String, &BTreeSet<String>> = arrows.iter().map(|(module, to)| (module, to)).collect();
    let is_allowed = |import: &Import| allowed.get(&import.from).is_some_and(|to| to.contains(&import.to));
    let forbidden = imports.iter().filter(|import| !is_allowed(import)).map(|import| {
        let Import { from, to, file, line } = import;
        format!("{file}:{line}: {from} imports {to}, an arrow that ARCHITECTURE.md has not")
    });
    let used: BTreeSet<_> = imports.iter().map(|import| (&import.from, &import.to)).collect();
    let listed = arrows.iter().flat_map(|(module, to)| to.iter().map(move |to| (module, to)));
    let idle = listed.filter(|arrow| !used.contains(arrow));
    let idle = idle.map(|(from, to)| format!("ARCHITECTURE.md: {from} does not import {to}"));
    forbidden.chain(idle).collect()
}

/// Returns what is wrong with the order of the list: arrows to modules that are not above.
fn backward_arrows(arrows: &Arrows) -> Vec<String> {
    let mut above = BTreeSet::new();
    let mut found = Vec::new();
    for (module, imports) in arrows {
        let below = imports.iter().filter(|import| !above.contains(import));
        found.extend(below.map(|import| format!("{module} imports {import}, which does not stand above it")));
        if !above.insert(module) {
            found.push(format!("{module} stands in the list twice"));
        }
    }
    found
}

fn list() -> Arrows {
    arrows(&std::fs::read_to_string(project("ARCHITECTURE.md")).unwrap())
}

fn sources() -> BTreeMap<String, String> {
    let mut sources = BTreeMap::new();
    read_sources(&project("src"), "", &mut sources);
    sources
}

#[test]
fn modules_import_what_the_list_of_arrows_says() {
    let imports = all_imports(&sources());
    // A reader of imports that finds none would allow everything.
    assert!(imports.len() > 100, "{} imports", imports.len());
    let complaints = complaints(&imports, &list());
    assert!(complaints.is_empty(), "\n{}", complaints.join("\n"));
}

#[test]
fn the_list_of_arrows_has_every_module_and_no_circle() {
    let list = list();
    let backward = backward_arrows(&list);
    assert!(backward.is_empty(), "\n{}", backward.join("\n"));
    let listed: BTreeSet<String> = list.into_iter().map(|(module, _)| module).collect();
    let mut modules = declared_modules(&sources()["lib.rs"]);
    modules.extend(["lib".to_owned(), "main".to_owned()]);
    assert_eq!(listed, modules);
}

/// A small program with every kind of path.
fn small_program() -> BTreeMap<String, String> {
    let files = [
        ("main.rs", "fn main() { a2::run(); }"),
        ("lib.rs", "mod ground;\nmod middle;\nmod top;\nuse top::Top;\npub fn run() { middle::go() }"),
        ("ground.rs", "// use crate::top::Top;\nconst TEXT: &str = \"crate::top\";"),
        ("middle/mod.rs", "mod part;\n#[cfg(test)]\nmod tests;\n\nuse super::ground::Ground;"),
        (
            "middle/part.rs",
            "use super::Middle;\nuse super::super::ground;\n#[cfg(test)]\nmod tests { use crate::top::Top; }",
        ),
        ("middle/tests.rs", "use crate::top::Top;"),
        ("top.rs", "use crate::{\n    ground::{self, Ground},\n    middle::Middle,\n};"),
    ];
    files.map(|(file, text)| (file.to_owned(), text.to_owned())).into()
}

const SMALL_PAGE: &str = "\n## The arrows\n\nWords.\n\n```text\nground:\nmiddle: ground\ntop: ground middle\nlib: middle top\nmain: lib\n```\n";

#[test]
fn a_program_that_keeps_to_its_list_passes() {
    let list = arrows(SMALL_PAGE);
    assert_eq!(complaints(&all_imports(&small_program()), &list), [""; 0]);
    assert_eq!(backward_arrows(&list), [""; 0]);
}

#[test]
fn an_import_that_is_not_in_the_list_is_named_with_its_place() {
    let mut program = small_program();
    program.insert("ground.rs".into(), "\nfn f() { crate::top::go() }".into());
    let found = complaints(&all_imports(&program), &arrows(SMALL_PAGE));
    assert_eq!(found, ["src/ground.rs:2: ground imports top, an arrow that ARCHITECTURE.md has not"]);
}

#[test]
fn an_unused_arrow_is_named() {
    let page = SMALL_PAGE.replace("ground:\n", "ground: vecmath\n");
    let found = complaints(&all_imports(&small_program()), &arrows(&page));
    assert_eq!(found, ["ARCHITECTURE.md: ground does not import vecmath"]);
}

#[test]
fn a_circle_shows_as_an_arrow_to_a_module_below() {
    let page = SMALL_PAGE.replace("ground:\n", "ground: top\n");
    assert_eq!(backward_arrows(&arrows(&page)), ["ground imports top, which does not stand above it"]);
}
