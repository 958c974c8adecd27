//! Command lines.

use a2::args::{Request, parse};
use a2::error::Error;
use a2::options::{MAX_BOUNCES, MAX_SAMPLES, MAX_SIDE, Options};
use std::ffi::OsString;
use std::path::Path;

/// Parses a command line, a word in each line.
pub fn words(data: &[u8], _: &Path) -> bool {
    let words: Vec<OsString> = data.split(|&byte| byte == b'\n').map(os_string).collect();
    let mut is_list = false;
    match parse(words.clone()) {
        Ok(Request::Render(options)) => {
            must_be_within_limits(&options);
            is_list = !options.pixels.is_empty();
        }
        Ok(Request::Compare(options)) => assert!((0.0..=100.0).contains(&options.percent)),
        Ok(Request::Merge(options)) => assert!(!options.parts.is_empty()),
        Ok(Request::Print(text) | Request::PrintUsage(text)) => assert!(text.ends_with('\n')),
        Err(Error::Usage(message)) => {
            assert!(!message.is_empty(), "{message}");
            return false;
        }
        Err(error) => panic!("not about the command line: {error}"),
    }
    // The last one of a repeated flag counts, so a line repeated means the same, unless it asks for pixels, all of which are
    // shown; behind `--` there are no flags.
    if !is_list && words.iter().all(|word| word != "--") {
        let (once, twice) = (parse(words.clone()), parse([words.clone(), words].concat()));
        assert_eq!(format!("{once:?}"), format!("{twice:?}"));
    }
    true
}

fn must_be_within_limits(options: &Options) {
    assert!([options.width, options.height].iter().all(|side| (1..=MAX_SIDE).contains(side)));
    assert!(options.bounces <= MAX_BOUNCES && (1..=MAX_SAMPLES).contains(&options.samples()));
    let shows_something = options.check || options.cost.is_some() || !options.pixels.is_empty();
    assert!(shows_something || options.pictures().next().is_some());
}

#[cfg(unix)]
fn os_string(bytes: &[u8]) -> OsString {
    std::os::unix::ffi::OsStringExt::from_vec(bytes.to_vec())
}

#[cfg(not(unix))]
fn os_string(bytes: &[u8]) -> OsString {
    String::from_utf8_lossy(bytes).into_owned().into()
}
