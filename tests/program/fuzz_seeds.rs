//! The seeds of the fuzz targets, given to the same functions that cargo-fuzz gives its inputs to.

#[path = "../../fuzz/src/targets/mod.rs"]
mod targets;

use crate::support::{Folder, project};
use std::collections::BTreeSet;
use std::path::PathBuf;
use targets::{TARGETS, lay_out};

fn seeds(target: &str) -> Vec<PathBuf> {
    let folder = project("fuzz/seeds").join(target);
    let entries = std::fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut seeds: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
    seeds.sort();
    seeds
}

#[test]
fn every_seed_passes() {
    for (name, target) in TARGETS {
        let folder = Folder::new();
        lay_out(&folder.path("."));
        let seeds = seeds(name);
        assert!(seeds.len() >= 5, "{name}: {} seeds", seeds.len());
        let mut accepted = 0;
        for seed in &seeds {
            // Shown with a failed test.
            println!("{}", seed.display());
            accepted += usize::from(target(&std::fs::read(seed).unwrap(), &folder.path(".")));
        }
        let is_known = cfg!(feature = "exr") || name != "exr";
        assert!(!is_known || accepted >= 4, "{name}: {accepted} of {} seeds are accepted", seeds.len());
    }
}

#[test]
fn every_target_has_a_program_and_seeds() {
    let names = |folder: &str| -> BTreeSet<String> {
        let entries = std::fs::read_dir(project(folder)).unwrap();
        let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
        names.map(|name| name.trim_end_matches(".rs").to_owned()).collect()
    };
    let targets: BTreeSet<String> = TARGETS.iter().map(|target| target.0.to_owned()).collect();
    assert_eq!(names("fuzz/fuzz_targets"), targets);
    assert_eq!(names("fuzz/seeds"), targets);
}
