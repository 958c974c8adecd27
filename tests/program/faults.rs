//! Tests of interruptions and of machines with little: signals, threads, disks.
#![cfg(target_os = "linux")]

use crate::support::{Folder, Run, SCENE, TRIANGLE};
use rustix::process::{Pid, Signal, kill_process};
use std::io::{BufRead as _, BufReader, Read as _};
use std::os::unix::process::ExitStatusExt;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

/// A picture that takes a tenth of a second or so to render and to write.
const ARGUMENTS: &str = "-input s.txt -output o.pfm -normals n.png -size 700 700 -threads 2";

pub fn folder_with_scene() -> Folder {
    let folder = Folder::new();
    folder.write("s.txt", SCENE.replace(TRIANGLE, "Sphere { center 0 0 0 radius 1 }"));
    folder
}

/// Starts the program with every signal as it is by default: where tests run in the background of a script, SIGINT is
/// ignored from the start.
fn start(folder: &Folder, arguments: &str) -> Child {
    let mut command = Command::new("env");
    command.arg("--default-signal").arg(env!("CARGO_BIN_EXE_a2"));
    command.args(arguments.split_whitespace()).current_dir(folder.path("."));
    command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
}

/// Without `/proc`, files have temporary names until they are complete. `None` where the system does not allow that.
fn start_without_proc(folder: &Folder, arguments: &str) -> Option<Child> {
    let is_allowed = Command::new("unshare").args(["-rm", "mount", "-t", "tmpfs", "none", "/proc"]).status();
    let line = format!("mount -t tmpfs none /proc; exec '{}' {arguments}", env!("CARGO_BIN_EXE_a2"));
    let mut command = Command::new("env");
    command.args(["--default-signal", "unshare", "-rm", "sh", "-c", &line]).current_dir(folder.path("."));
    command.stdout(Stdio::null()).stderr(Stdio::piped());
    is_allowed.is_ok_and(|status| status.success()).then(|| command.spawn().unwrap())
}

fn send(child: &Child, signal: Signal) {
    // It may have ended already.
    let _ = kill_process(Pid::from_child(child), signal);
}

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

pub fn with_limit(folder: &Folder, limit: &str, arguments: &str) -> Run {
    let line = format!("ulimit {limit}; exec '{}' {arguments}", env!("CARGO_BIN_EXE_a2"));
    folder.run(Command::new("bash").args(["-c", &line]))
}

#[test]
fn signals_at_any_time_leave_nothing_and_lose_nothing() {
    let folder = folder_with_scene();
    assert_eq!(folder.a2(ARGUMENTS).exit_code, 0);
    let whole = [folder.path("o.pfm"), folder.path("n.png")].map(|path| std::fs::read(path).unwrap());
    let mut interrupted = 0;
    for round in 0..200 {
        folder.write("o.pfm", "old").write("n.png", "old");
        let signal = [Signal::INT, Signal::TERM, Signal::HUP, Signal::QUIT][round % 4];
        let child = start(&folder, ARGUMENTS);
        // From the first instruction to the end of most runs, in an order without pattern.
        std::thread::sleep(Duration::from_micros((round as u64 * 7919 % 200) * 400));
        let sent = Instant::now();
        send(&child, signal);
        let output = child.wait_with_output().unwrap();
        if let Some(number) = output.status.signal() {
            assert_eq!(number, signal.as_raw(), "{round}");
            interrupted += 1;
            // A tenth of a second, but the machine may be busy.
            assert!(sent.elapsed() < Duration::from_secs(2), "{round}: {:?}", sent.elapsed());
        } else {
            assert_eq!(output.status.code(), Some(0), "{round}: {}", text(&output));
        }
        assert_eq!(folder.files(), ["n.png", "o.pfm", "s.txt"], "{round}");
        for (name, whole) in ["o.pfm", "n.png"].iter().zip(&whole) {
            let found = std::fs::read(folder.path(name)).unwrap();
            assert!(found == b"old" || found == *whole, "{round}: {name} has {} bytes", found.len());
        }
    }
    assert!(interrupted > 20, "only {interrupted} runs were interrupted");
}

#[test]
fn temporary_names_are_removed_where_files_need_names() {
    let folder = folder_with_scene();
    let arguments = "-input s.txt -output o.png -size 9000 9000 -filter -jitter";
    for signal in [Signal::INT, Signal::TERM, Signal::QUIT] {
        let Some(child) = start_without_proc(&folder, arguments) else { return };
        let start = Instant::now();
        while folder.files().len() == 1 && start.elapsed() < Duration::from_secs(20) {
            std::thread::sleep(Duration::from_millis(5));
        }
        let files = folder.files();
        assert!(files.len() == 2 && files[0].starts_with(".a2-"), "{files:?}");
        send(&child, signal);
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.signal(), Some(signal.as_raw()), "{}", text(&output));
        assert!(text(&output).contains("unfinished files are removed"), "{}", text(&output));
        assert_eq!(folder.files(), ["s.txt"]);
    }
}

/// Nothing can be done at these, so nothing may be needed.
#[test]
fn nothing_is_left_by_what_cannot_be_handled() {
    let folder = folder_with_scene();
    for signal in [Signal::KILL, Signal::ALARM, Signal::USR1, Signal::ABORT] {
        let child = start(&folder, "-input s.txt -output o.png -normals n.png -size 9000 9000 -filter -jitter");
        std::thread::sleep(Duration::from_millis(200));
        send(&child, signal);
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.signal(), Some(signal.as_raw()), "{}", text(&output));
        assert_eq!(folder.files(), ["s.txt"], "{signal:?}");
    }
}

#[test]
fn a_limit_of_processor_time_ends_as_a_signal() {
    let folder = folder_with_scene();
    let arguments = "-input s.txt -output o.png -size 9000 9000 -filter -jitter";
    // The first one is the limit of SIGKILL, too.
    for limit in ["-t 2", "-St 1"] {
        let line = format!("ulimit {limit}; exec '{}' {arguments}", env!("CARGO_BIN_EXE_a2"));
        let mut command = Command::new("bash");
        let output = command.args(["-c", &line]).current_dir(folder.path(".")).output().unwrap();
        assert_eq!(output.status.signal(), Some(Signal::XCPU.as_raw()), "{limit}: {}", text(&output));
        assert!(
            text(&output).contains("interrupted by SIGXCPU: unfinished files are removed\n"),
            "{}",
            text(&output)
        );
        assert_eq!(folder.files(), ["s.txt"]);
    }
}

/// Stacks of a tebibyte let no thread be started.
#[test]
fn signals_end_rendering_where_no_thread_can_be_started() {
    let folder = folder_with_scene();
    for (arguments, signals, exit_code) in [
        ("-output o.png -size 9000 9000 -filter -jitter", 1, None),
        ("-output o.png -size 300 300 -time-limit 1000 -samples 65536", 1, Some(0)),
        // Two that come at once may be one.
        ("-output o.png -size 4000 4000 -time-limit 1000 -samples 65536", 20, None),
    ] {
        let limits = "ulimit -v 4000000; export RUST_MIN_STACK=1099511627776";
        let line = format!("{limits}; exec '{}' -input s.txt {arguments}", env!("CARGO_BIN_EXE_a2"));
        let mut command = Command::new("env");
        command.args(["--default-signal", "bash", "-c", &line]).current_dir(folder.path("."));
        let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        let mut stderr = BufReader::new(child.stderr.take().unwrap());
        let mut said = String::new();
        stderr.read_line(&mut said).unwrap();
        assert!(said.contains("the system allows 1 worker thread"), "{said}");
        std::thread::sleep(Duration::from_millis(400));
        for _ in 0..signals {
            send(&child, Signal::INT);
            std::thread::sleep(Duration::from_millis(4));
        }
        stderr.read_to_string(&mut said).unwrap();
        let status = child.wait().unwrap();
        assert_eq!(status.code(), exit_code, "{arguments}: {said}");
        assert_eq!(status.signal(), exit_code.is_none().then_some(Signal::INT.as_raw()));
        let files: &[&str] = if exit_code.is_some() { &["o.png", "s.txt"] } else { &["s.txt"] };
        assert_eq!(folder.files(), files, "{arguments}");
        let _ = std::fs::remove_file(folder.path("o.png"));
    }
}

#[test]
fn a_signal_is_named_and_a_second_interrupt_ends_at_once() {
    let folder = folder_with_scene();
    let endless = "-input s.txt -output o.png -size 400 400 -target-error 0.000001";
    for (arguments, signals, message) in [
        (
            "-input s.txt -output o.png -size 9000 9000 -filter -jitter",
            &[Signal::TERM][..],
            "interrupted by SIGTERM",
        ),
        (endless, &[Signal::INT, Signal::INT], "interrupted by SIGINT"),
    ] {
        let child = start(&folder, arguments);
        for &signal in signals {
            std::thread::sleep(Duration::from_millis(300));
            send(&child, signal);
            if signals.len() > 1 {
                // The second one must come before rendering has ended.
                send(&child, signal);
            }
        }
        let output = child.wait_with_output().unwrap();
        assert!(output.status.signal().is_some() || output.status.code() == Some(3), "{}", text(&output));
        if signals.len() == 1 {
            assert_eq!(output.status.signal(), Some(signals[0].as_raw()));
            assert!(text(&output).contains(message), "{}", text(&output));
        }
    }
}

#[test]
fn an_interrupted_measurement_ends_with_its_best_picture() {
    let folder = folder_with_scene();
    // The target was missed; samples were taken evenly.
    for (flags, exit_code) in [("-target-error 0.000001", 3), ("-time-limit 1000 -samples 65536", 0)] {
        let arguments = format!("-input s.txt -output o.png -size 300 300 -stats {flags}");
        let child = start(&folder, &arguments);
        std::thread::sleep(Duration::from_millis(700));
        send(&child, Signal::INT);
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(exit_code), "{}", text(&output));
        assert!(text(&output).contains("best picture so far"), "{}", text(&output));
        assert!(text(&output).contains("RMSE"), "{}", text(&output));
        let picture = folder.picture("o.png");
        assert!(picture.get_pixel(150, 150) != picture.get_pixel(0, 0));
    }
}

#[test]
fn interrupted_curves_keep_the_points_that_are_done() {
    let folder = folder_with_scene();
    for (name, rows) in [("c.svg", "\nsobol,"), ("c.csv", "\nsobol,"), ("c.html", "<tr><td>sobol<")] {
        let arguments = "-input s.txt -output o.png -size 300 300 -samples 65536 -sampler sobol -convergence";
        let child = start(&folder, &format!("{arguments} {name}"));
        std::thread::sleep(Duration::from_millis(1500));
        send(&child, Signal::INT);
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(3), "{}", text(&output));
        let file = std::fs::read_to_string(folder.path(name)).unwrap();
        for found in [&text(&output), &file] {
            assert!(found.contains("Interrupted: the curves end before what was asked for"), "{found}");
        }
        let done = file.matches(rows).count();
        assert!((3..17).contains(&done), "{done}");
        let picture = folder.picture("o.png");
        assert!(picture.get_pixel(150, 150) != picture.get_pixel(0, 0));
    }
}

#[test]
fn ignored_signals_stay_ignored() {
    let folder = folder_with_scene();
    let line = format!("trap '' HUP; echo; exec '{}' {ARGUMENTS}", env!("CARGO_BIN_EXE_a2"));
    let mut bash = Command::new("bash");
    let mut child = bash.args(["-c", &line]).current_dir(folder.path(".")).stdout(Stdio::piped()).spawn().unwrap();
    // Before that line, the shell would not survive.
    child.stdout.take().unwrap().read_exact(&mut [0]).unwrap();
    for _ in 0..20 {
        std::thread::sleep(Duration::from_millis(2));
        send(&child, Signal::HUP);
    }
    assert_eq!(child.wait_with_output().unwrap().status.code(), Some(0));
}

/// Reading and building go level by level.
#[test]
fn a_small_stack_holds_the_deepest_scene() {
    let folder = Folder::new();
    for (i, begin) in ["Transform { Scale 1 1 1 ", "Group { numObjects 1 "].into_iter().enumerate() {
        let nested = begin.repeat(250) + TRIANGLE + &"}".repeat(250);
        folder.write(&format!("{i}.txt"), SCENE.replace(TRIANGLE, &nested));
        let run = with_limit(&folder, "-s 128", &format!("-input {i}.txt -output {i}.png -size 9 9"));
        assert_eq!(run.exit_code, 0, "{}", run.stderr);
    }
    assert_eq!(folder.files(), ["0.png", "0.txt", "1.png", "1.txt"]);
}

#[test]
fn with_few_threads_the_picture_is_the_same() {
    let folder = folder_with_scene();
    assert_eq!(folder.a2("-input s.txt -output a.png").exit_code, 0);
    // Stacks of a gibibyte, of which the second limit leaves room for a few.
    for limit in ["-v 600000", "-v 5000000; export RUST_MIN_STACK=1073741824"] {
        let run = with_limit(&folder, limit, "-input s.txt -output b.png -threads 1000");
        assert_eq!(run.exit_code, 0, "{limit}: {}", run.stderr);
        assert!(
            run.stderr.contains("hint: the system allows ") && run.stderr.contains(", not 1000\n"),
            "{limit}: {}",
            run.stderr
        );
        assert!(folder.picture("a.png") == folder.picture("b.png"), "{limit}");
    }
}

/// Runs a command line of the shell in a folder `disk` that is a file system of its own. None where the system does not
/// allow that.
fn with_disk(folder: &Folder, mount_options: &str, line: &str) -> Option<Run> {
    const NOT_ALLOWED: i32 = 97;
    let mount = format!("mkdir -p disk && mount -t tmpfs -o {mount_options} tmpfs disk || exit {NOT_ALLOWED}");
    let line = format!("{mount}; '{}' {line}; code=$?; ls -A disk; exit $code", env!("CARGO_BIN_EXE_a2"));
    let run = folder.run(Command::new("unshare").args(["-rm", "sh", "-c", &line]));
    (run.exit_code != NOT_ALLOWED && !run.stderr.contains("unshare")).then_some(run)
}

#[test]
fn a_full_or_read_only_disk_is_an_error_and_keeps_nothing() {
    let folder = folder_with_scene();
    for (mount_options, message) in [("size=64k", "No space left"), ("ro", "disk/o.pfm: cannot write this file")] {
        let arguments = "-input s.txt -output disk/o.pfm -size 300 300";
        let Some(run) = with_disk(&folder, mount_options, arguments) else { return };
        assert_eq!(run.exit_code, 1, "{mount_options}: {}", run.stderr);
        assert!(run.stderr.contains(message), "{mount_options}: {}", run.stderr);
        assert_eq!(run.stdout, "", "{mount_options}");
    }
}
