//! The curves as a page of HTML that needs no other file: the figure, the points, the picture and its error map.

use super::svg::escaped;
use super::words::{short, time, with_digits};
use super::{Convergence, Point, figure};
use crate::film::encode_png;
use crate::options::Options;
use crate::render::{Frame, SampleCounts};
use std::fmt::Write as _;
use std::io;

const STYLE: &str =
    "body { font-family: sans-serif; max-width: 1000px; margin: 2em auto; padding: 0 1em; color: #222 }
svg, img { max-width: 100%; height: auto }
figure { display: inline-block; margin: 0 1em 1em 0; vertical-align: top }
table { border-collapse: collapse }
th, td { padding: 0.2em 0.8em; text-align: right; border-bottom: 1px solid #ddd }
th:first-child, td:first-child { text-align: left }";

/// Returns the page.
///
/// # Errors
/// That of encoding a picture, which has no other cause than memory.
pub fn html(options: &Options, frame: &Frame, curves: &Convergence) -> io::Result<String> {
    let title = escaped(&format!("Error against cost: {}", figure::scene_name(options)));
    let film = &frame.film;
    let picture = |plane: &Option<Vec<u8>>, caption: &str| match plane {
        Some(bytes) => {
            let png = base64(&encode_png(film.width, film.height, bytes)?);
            Ok(format!(
                "<figure><img alt=\"{caption}\" src=\"data:image/png;base64,{png}\">\
                 <figcaption>{caption}</figcaption></figure>\n"
            ))
        }
        None => io::Result::Ok(String::new()),
    };
    let samples = &frame.samples;
    let unreached = 100.0 * samples.unreached as f64 / samples.pixels.max(1) as f64;
    let sampler = options.measure.sampler.name();
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<title>{title}</title>\n\
         <style>\n{STYLE}\n</style>\n</head>\n<body>\n<h1>{title}</h1>\n{}",
        figure::svg(options, curves),
    );
    let _ = write!(
        page,
        "<h2>The picture</h2>\n<p>With {} {sampler} samples a pixel{}. Pixels that no sample reached: {}%.</p>\n{}{}",
        samples.most,
        one_in_the_background(samples),
        short(unreached),
        picture(&film.color, "The picture")?,
        picture(&film.error_map(), "Estimated standard error of each pixel: black 0, white 16 levels or more")?,
    );
    page += &table(&curves.points);
    page += "</body>\n</html>\n";
    Ok(page)
}

/// Says why the mean number of samples is lower, if it is.
fn one_in_the_background(samples: &SampleCounts) -> String {
    if samples.least == Some(samples.most) {
        return String::new();
    }
    let mean = short(samples.mean());
    format!("; one ray does where nothing but a background of one colour is seen, which makes {mean} in the mean")
}

fn table(points: &[Point]) -> String {
    let mut text =
        "<h2>The points</h2>\n<table>\n<tr><th>method</th><th>samples a pixel</th><th>processor time</th>\
                    <th>time</th><th>estimated error</th><th>95% interval</th><th>true error</th></tr>\n"
            .to_owned();
    for point in points {
        let levels = point.estimate.map(|estimate| estimate.levels);
        let level = |value: f64| with_digits(value, 3);
        let known = |value: Option<f64>| value.map_or("–".to_owned(), level);
        let interval = levels.map(|levels| format!("{} to {}", level(levels.low), level(levels.high)));
        let method = match point.target {
            Some(target) => format!("{}, target {}", point.method.name(), short(target)),
            None => point.method.name().to_owned(),
        };
        let cells = [
            method,
            short(point.samples_a_pixel),
            time(point.cpu_seconds()),
            time(point.times.wall.as_secs_f64()),
            known(levels.map(|levels| levels.rmse)),
            interval.unwrap_or_else(|| "–".to_owned()),
            known(point.true_error.as_ref().map(|error| error.rmse_levels)),
        ];
        let _ = writeln!(text, "<tr><td>{}</td></tr>", cells.join("</td><td>"));
    }
    text += "</table>\n<p>Errors are root mean squares over all pixels and channels, in levels of 255. No time \
             contains reading the scene, building trees or reading cube map faces.</p>\n";
    text
}

/// Encodes bytes as base64 (RFC 4648).
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let bits = (0..3).fold(0, |bits, i| bits << 8 | u32::from(three.get(i).copied().unwrap_or(0)));
        for digit in 0..4 {
            let is_padding = digit > three.len();
            let index = bits >> (18 - 6 * digit) & 63;
            text.push(if is_padding { '=' } else { char::from(DIGITS[index as usize]) });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_is_that_of_the_standard() {
        for (bytes, text) in
            [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foob", "Zm9vYg=="), ("\0\u{7f}~", "AH9+")]
        {
            assert_eq!(base64(bytes.as_bytes()), text, "{bytes:?}");
        }
    }
}
