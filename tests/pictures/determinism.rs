//! Every run gives the same bytes, with any number of threads.

use crate::support::{Folder, project};

fn scene(name: &str) -> String {
    project("data").join(name).display().to_string()
}

fn bytes(folder: &Folder, arguments: &str) -> [Vec<u8>; 3] {
    let run = folder.a2(&format!("{arguments} -output c.png -normals n.png -depth 8 18 d.png"));
    assert_eq!(run.exit_code, 0, "{arguments}: {}", run.stderr);
    ["c.png", "n.png", "d.png"].map(|name| std::fs::read(folder.path(name)).unwrap())
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let folder = Folder::new();
    for (name, flags) in [
        ("scene01_plane.txt", "-shadows -jitter"),
        ("scene04_axes.txt", "-filter"),
        ("scene06_bunny_1k.txt", "-bounces 4 -shadows"),
        ("scene07_arch.txt", "-bounces 2 -shadows -jitter -filter"),
    ] {
        let arguments = |threads: u32| format!("-input {} -size 67 45 {flags} -threads {threads}", scene(name));
        let one = bytes(&folder, &arguments(1));
        for threads in [2, 7] {
            assert!(bytes(&folder, &arguments(threads)) == one, "{name} with {threads} threads");
        }
        assert!(bytes(&folder, &arguments(2)) == one, "{name} again");
    }
}

#[test]
fn a_seed_repeats_and_another_seed_differs() {
    let folder = Folder::new();
    let with_seed = |seed: &str| {
        let arguments = format!("-input {} -size 50 50 -jitter {seed}", scene("scene01_plane.txt"));
        bytes(&folder, &arguments)[0].clone()
    };
    assert!(with_seed("-seed 1") == with_seed("-seed 1"));
    assert!(with_seed("-seed 1") != with_seed("-seed 2"));
    assert!(with_seed("") == with_seed("-seed 0"));
}
