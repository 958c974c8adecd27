//! `man/a2.1` and `completions/`: made of the table of flags by `clap_mangen` and `clap_complete`, and committed.

use crate::snapshots::holds_at;
use crate::support::{Folder, project};
use a2::args::help::{ABOUT, EXAMPLES, EXIT_CODES, ROBUST, TYPING, USAGE, WITH_ROBUST};
use a2::args::{Flag, GROUPS};
use a2::options::SamplerKind;
use clap::{Arg, ArgAction, Command, ValueHint};
use clap_complete::Shell;
use clap_mangen::roff::{Roff, bold, roman};

/// The command line as clap describes it. Flags have two dashes here, which [`with_one_dash`] changes.
fn command() -> Command {
    let scene = Arg::new("SCENE").help("Scene to read, .txt; - is standard input").value_hint(ValueHint::FilePath);
    let mut command = Command::new("a2")
        .version(env!("CARGO_PKG_VERSION"))
        .about(ABOUT.trim_end_matches('.'))
        .long_about(format!("{ABOUT} {TYPING}"))
        .override_usage(USAGE.join("\n"))
        .disable_help_flag(true)
        .disable_version_flag(true)
        .arg(scene);
    for (group, flags) in GROUPS {
        command = command.args(flags.iter().map(|flag| arg(flag).help_heading(*group)));
    }
    command
}

fn arg(flag: &Flag) -> Arg {
    let arg = Arg::new(flag.name).long(flag.name).help(flag.summary);
    let arg = arg.long_help(format!("{}. {}", flag.summary, flag.more).trim_end().to_owned());
    if flag.values.is_empty() {
        return arg.action(ArgAction::SetTrue);
    }
    let is_file = flag.values.iter().any(|value| ["FILE", "A", "B"].contains(value));
    let hint = if is_file { ValueHint::FilePath } else { ValueHint::Other };
    let arg = arg.num_args(flag.values.len()).value_names(flag.values).value_hint(hint);
    match flag.name {
        "sampler" => arg.value_parser(SamplerKind::ALL.map(SamplerKind::name)),
        // The pages are the same on every machine.
        "simd" => arg.value_parser(["sse2", "avx2", "avx512"]),
        _ => arg,
    }
}

/// Takes one of the two dashes from all flags.
fn with_one_dash(text: &str, dash: &str) -> String {
    let two = dash.repeat(2);
    let mut parts = text.split(&two);
    let mut page = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let is_flag = part.starts_with(|c: char| c.is_ascii_lowercase());
        page += &dash.repeat(if is_flag { 1 } else { 2 });
        page += part;
    }
    page
}

fn completions(shell: Shell) -> String {
    let mut text = Vec::new();
    clap_complete::generate(shell, &mut command(), "a2", &mut text);
    let text = with_one_dash(&String::from_utf8(text).unwrap(), "-");
    match shell {
        // Flags of one dash and several letters.
        Shell::Fish => text.replace(" -l ", " -o "),
        // -s would take -jitter for six flags.
        Shell::Zsh => text.replace("(-s -S -C)", "(-S -C)").replace("(-s -C)", "(-C)"),
        _ => text,
    }
}

/// Returns what stands behind the flags of the manual page.
fn last_sections() -> String {
    let mut page = Roff::new();
    page.control("SH", ["ROBUST"]);
    page.text([roman(WITH_ROBUST)]);
    for difference in ROBUST {
        page.control("IP", ["\\(bu", "2"]).text([roman(difference)]);
    }
    page.control("SH", ["EXIT STATUS"]);
    for (code, meaning) in EXIT_CODES {
        page.control("TP", ["4"]).text([bold(code.to_string())]).text([roman(meaning)]);
    }
    page.control("SH", ["EXAMPLES"]);
    for (what, line) in EXAMPLES {
        page.control("TP", ["4"]).text([roman(what)]);
        page.control("nf", []).text([bold(line)]).control("fi", []);
    }
    page.render()
}

#[test]
fn the_manual_page_is_that_of_the_flags() {
    let man = clap_mangen::Man::new(command());
    let mut page = Vec::new();
    man.render_title(&mut page).unwrap();
    man.render_name_section(&mut page).unwrap();
    man.render_synopsis_section(&mut page).unwrap();
    man.render_description_section(&mut page).unwrap();
    man.render_options_section(&mut page).unwrap();
    let page = String::from_utf8(page).unwrap() + &last_sections();
    // Each section brings the lines before the title.
    let (first_lines, _) = page.split_once(".TH").unwrap();
    let page = with_one_dash(&format!("{first_lines}{}", page.replace(first_lines, "")), "\\-");
    for flag in GROUPS.iter().flat_map(|group| group.1) {
        assert!(page.contains(&format!("\\fB\\-{}\\fR", flag.name.replace('-', "\\-"))), "{}", flag.name);
    }
    holds_at(&project("man/a2.1"), &page);
}

#[test]
fn the_completions_of_bash_are_those_of_the_flags() {
    holds_at(&project("completions/a2.bash"), &completions(Shell::Bash));
}

#[test]
fn the_completions_of_zsh_are_those_of_the_flags() {
    holds_at(&project("completions/_a2"), &completions(Shell::Zsh));
}

#[test]
fn the_completions_of_fish_are_those_of_the_flags() {
    holds_at(&project("completions/a2.fish"), &completions(Shell::Fish));
}

#[cfg(target_os = "linux")]
#[test]
fn bash_completes_flags_and_names() {
    let folder = Folder::new();
    folder.write("scene.txt", "");
    let completed = |words: &str| {
        let script = format!(
            "compopt() {{ :; }}; source '{}'; COMP_WORDS=(a2 {words}); COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1)); \
             _a2 a2 \"${{COMP_WORDS[COMP_CWORD]}}\" \"${{COMP_WORDS[COMP_CWORD - 1]}}\"; echo \"${{COMPREPLY[*]}}\"",
            project("completions/a2.bash").display()
        );
        folder.run(std::process::Command::new("bash").args(["-c", &script]))
    };
    for (words, expected) in [
        ("-sh", "-shadows\n"),
        ("-tar", "-target-error\n"),
        ("-sampler so", "sobol\n"),
        ("-input sc", "scene.txt\n"),
    ] {
        let run = completed(words);
        assert_eq!((run.stdout.as_str(), run.stderr.as_str()), (expected, ""), "{words}");
    }
}
