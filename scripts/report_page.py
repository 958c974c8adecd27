"""Writes the HTML of scripts/report.py: one page with everything in it."""

import base64

from grade_page import PANEL_CHOICE, PANEL_STYLE, escaped, panel

# The policy forbids the page every request: pictures are data URLs, style and script stand in the page.
HEAD = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy"
 content="default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'">
<meta name="viewport" content="width=device-width">
<title>Ray tracer report</title>
<style>
body { font: 15px/1.5 system-ui, sans-serif; margin: 2em auto; max-width: 1560px; padding: 0 1em; color: #222; }
h2 { margin-top: 2.5em; border-top: 1px solid #ccc; padding-top: .8em; }
table { border-collapse: collapse; margin: 1em 0; display: block; overflow-x: auto; }
th, td { border: 1px solid #ccc; padding: .25em .6em; text-align: left; }
td.number { text-align: right; font-variant-numeric: tabular-nums; }
code { background: #f2f2f2; padding: .15em .35em; overflow-wrap: anywhere; }
figure { margin: 0; min-width: 0; } figcaption { font-size: 90%; margin: .3em 0 1em; }
.three { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 260px), 1fr)); gap: 16px; }
.four { display: grid; grid-template-columns: repeat(auto-fit, minmax(200px, 1fr)); gap: 16px; }
img { display: block; max-width: 100%; }
.slider { position: relative; --at: 50%; }
.slider img { width: 100%; }
.slider .program { position: absolute; inset: 0; clip-path: inset(0 calc(100% - var(--at)) 0 0); }
.slider .line { position: absolute; inset: 0 auto 0 var(--at); width: 2px; background: #fff; outline: 1px solid #000; }
.slider input { position: absolute; inset: 0; width: 100%; height: 100%; margin: 0; opacity: 0; cursor: ew-resize; }
.slider:focus-within { outline: 3px solid #36c; }
.slider.difference { filter: brightness(16); }
.slider.difference .program { clip-path: none; mix-blend-mode: difference; }
.slider.difference .line { display: none; }
PANEL_STYLE.whole { width: 200px; }
.edge { width: 200px; height: 200px; overflow: hidden; position: relative; margin-top: 8px; }
.edge img { position: absolute; max-width: none; image-rendering: pixelated; }
.curve { max-width: 900px; width: 100%; }
</style>
</head>
<body>
""".replace("PANEL_STYLE", PANEL_STYLE.strip("\n"))
SCRIPT = """<script>
for (const slider of document.querySelectorAll(".slider")) {
  const input = slider.querySelector("input");
  input.addEventListener("input", () => slider.style.setProperty("--at", input.value + "%"));
  const box = slider.parentElement.querySelector("input[type=checkbox]");
  box.addEventListener("change", () => slider.classList.toggle("difference", box.checked));
}
</script>
</body>
</html>
"""
# How often a pixel of an edge is magnified, and how wide the cut-out is on the page.
ZOOM = 10
CUT = 200


def data_url(path):
    kind = "image/svg+xml" if path.suffix == ".svg" else "image/png"
    return f"data:{kind};base64,{base64.b64encode(path.read_bytes()).decode()}"


def table(head, rows):
    return "<table>\n<tr>" + "".join(f"<th>{escaped(cell)}</th>" for cell in head) + "</tr>\n" + "".join(rows) + "</table>\n"


def summary(scenes):
    """Returns a table with a line for each scene: the worst of its pictures, time and memory."""
    rows = []
    for number, scene in enumerate(scenes):
        reports = [picture.report for picture in scene.pictures if picture.report]
        complete = len(reports) == len(scene.pictures)
        over = [max(each["pixels_over_levels"][levels] for each in reports) if complete else "?" for levels in "018"]
        run = scene.run
        cells = [run.status, *over, *run.costs()]
        link = f'<td><a href="#s{number}">{escaped(scene.title)}</a></td>'
        rows.append("<tr>" + link + "".join(f'<td class="number">{escaped(cell)}</td>' for cell in cells) + "</tr>\n")
    over = ["pixels that differ", "by more than 1 level", "by more than 8"]
    head = ["scene", "run", *over, "seconds", "processor seconds", "MB"]
    return table(head, rows)


def slider(picture):
    """Returns a picture over its reference, and a caption."""
    name = escaped(picture.name)
    if not picture.path.is_file():
        return f"<figure><figcaption>{name}: {escaped(picture.message)}</figcaption></figure>\n"
    shown = f'<img alt="{name}" src="{data_url(picture.path)}">'
    if not picture.report:
        return f"<figure>{shown}<figcaption>{name}: {escaped(picture.message)}</figcaption></figure>\n"
    over = picture.report["pixels_over_levels"]
    pixels = picture.report["width"] * picture.report["height"]
    caption = f"{name}: left of the line the program, right of it the reference. "
    if over["0"]:
        worst = picture.report["worst_levels"]
        caption += f"{over['0']} of {pixels} pixels differ, {over['8']} by more than 8 levels; the worst by {worst}."
    else:
        caption += "No pixel differs."
    return (
        f'<figure><div class="slider"><img alt="reference of {name}" src="{data_url(picture.reference)}">'
        f'<img class="program" alt="{name}" src="{data_url(picture.path)}"><div class="line"></div>'
        f'<input type="range" min="0" max="100" step="0.1" value="50" aria-label="{name}: program or reference"></div>'
        f'<figcaption>{caption} <label><input type="checkbox"> difference, 16 times as bright</label></figcaption>'
        "</figure>\n"
    )


def differences(picture):
    """Returns a picture, its reference and their differences side by side, if they differ."""
    if not picture.report or not picture.report["pixels_over_levels"]["0"]:
        return ""
    shown = panel(picture.panel, f"program, reference and difference of {picture.name}")
    caption = f"{escaped(picture.name)}: program (A), reference (B) and their difference in levels"
    return f"<figure>{shown}<figcaption>{caption}</figcaption></figure>\n"


def smooth_figure(smooth, edge, size):
    """Returns a picture and the cut-out around an edge of it, magnified."""
    label = escaped(smooth.label)
    if not smooth.path.is_file():
        why = escaped(smooth.run.messages or smooth.run.detail or "no picture")
        return f"<figure><figcaption>{label}: {escaped(smooth.run.status)}, {why}</figcaption></figure>\n"
    url = data_url(smooth.path)
    # The pixel of the edge lies in the middle of the cut-out, unless the picture ends before.
    left, top = (min(max(CUT // 2 - (place * ZOOM + ZOOM // 2), CUT - size * ZOOM), 0) for place in edge)
    return (
        f'<figure><img class="whole" alt="{label}" src="{url}"><div class="edge"><img alt="{label}, magnified" src="{url}" '
        f'style="width: {size * ZOOM}px; left: {left}px; top: {top}px"></div>'
        f"<figcaption>{label}: {smooth.run.seconds:.2f} s</figcaption></figure>\n"
    )


def section(number, scene, size):
    """Returns all about a scene."""
    run = scene.run
    seconds, cpu_seconds, megabytes = run.costs()
    ending = f"{run.status}{' ' + run.detail if run.detail else ''}" + (f": {run.messages}" if run.messages else "")
    parts = [
        f'<h2 id="s{number}">{escaped(scene.title)}</h2>\n<p><code>{escaped(scene.command)}</code></p>\n',
        f"<p>{escaped(ending)}, {seconds} s ({cpu_seconds or 'unknown'} s of all processors), {megabytes or 'unknown'} MB.</p>\n",
        '<div class="three">\n' + "".join(map(slider, scene.pictures)) + "</div>\n",
        *map(differences, scene.pictures),
        f"<h3>Anti-aliasing</h3>\n<p>At {size} x {size} pixels; below, the edge that it changes most, ",
        f"{ZOOM} times as large.</p>\n",
        '<div class="four">\n' + "".join(smooth_figure(each, scene.edge, size) for each in scene.smooth) + "</div>\n",
        "<h3>Error against time</h3>\n",
    ]
    if scene.curve:
        parts.append(f'<img class="curve" alt="error against time" src="{data_url(scene.curve)}">\n')
    else:
        parts.append(f"<p>{escaped(scene.curve_message)}</p>\n")
    return "".join(parts)


def page(scenes, versions, size):
    """Returns the page; size is that of the anti-aliasing pictures, in pixels."""
    parts = [
        HEAD,
        "<h1>Ray tracer report</h1>\n",
        "<table>\n" + "".join(f"<tr><th>{escaped(name)}</th><td>{escaped(text)}</td></tr>\n" for name, text in versions),
        "</table>\n",
        "<p>Figures of a scene are those of its worst picture. A level is a step of a colour from 0 to 255. Seconds are those "
        "of the clock for the whole program, which renders all three pictures in one run. Move the line in a picture to "
        "compare.</p>\n",
        PANEL_CHOICE,
        summary(scenes),
        *(section(number, scene, size) for number, scene in enumerate(scenes)),
        SCRIPT,
    ]
    return "".join(parts)
