"""Shows the results of grading: as a table, JSON, CSV and one HTML page with the pictures that differ."""

import base64
import csv
import html
import io
import json
from dataclasses import dataclass
from pathlib import Path

# A panel of three pictures is shown pixel for pixel, so that its letters can be read, and scrolls in a box of its own.
PANEL_STYLE = """
.panel { overflow-x: auto; }
.panel img { display: block; max-width: none; image-rendering: pixelated; }
:has(#whole:checked) .panel img { max-width: 100%; }
"""
PANEL_CHOICE = (
    '<p><label><input type="checkbox" id="whole"> Shrink differences to the width of the page. (Otherwise every pixel is '
    "shown, and they scroll.)</label></p>\n"
)
STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; margin: 2em auto; max-width: 1500px; padding: 0 1em; color: #222; }
table { border-collapse: collapse; margin: 1em 0; display: block; overflow-x: auto; }
th, td { border: 1px solid #ccc; padding: .25em .6em; text-align: left; vertical-align: top; }
td.number { text-align: right; font-variant-numeric: tabular-nums; } td.notes { min-width: 14em; }
.ok { background: #dff3df; } .differs { background: #fdecc8; } .bad { background: #f8d4d4; }
figure { margin: 1em 0; } figcaption { font-size: 90%; }
summary { cursor: pointer; font-size: 120%; margin: .6em 0; }
"""


@dataclass
class Submission:
    name: str
    path: Path
    # One for each scene.
    rows: list

    @property
    def credit(self):
        return sum(row.credit for row in self.rows)

    @property
    def possible(self):
        return sum(row.possible for row in self.rows)

    def credit_text(self):
        return f"{self.credit:.1f} of {self.possible:.1f}"


def figures(row):
    """Returns the worst figures of a scene's pictures: pixels over 0, 1 and 8 levels, and the worst level."""
    reports = [picture.report for picture in row.pictures if picture.report]
    # Random samples differ in every pixel: a note says what counts.
    if not reports or row.scene == "aa":
        return ["", "", "", ""]
    over = [max(report["pixels_over_levels"][levels] for report in reports) for levels in ("0", "1", "8")]
    return [*over, max(report["worst_levels"] for report in reports)]


def cost(row):
    """Returns wall seconds, processor seconds and megabytes of a run, as texts."""
    return row.run.costs() if row.run else ["", "", ""]


def notes(row):
    return "; ".join(" ".join(note.split()) for note in row.notes)


def markdown(head, rows):
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(str(cell).replace("|", "\\|") for cell in line) + " |" for line in lines)


def table(submissions):
    """Returns a Markdown table with a line for each scene, and one with a line for each submission if there are several."""
    rows = []
    for submission in submissions:
        for row in submission.rows:
            over, _, far, _ = figures(row)
            cells = [submission.name, row.scene, row.status, over, far, cost(row)[0], f"{row.credit:.1f}", notes(row)]
            rows.append(cells)
        rows.append([submission.name, "all", "", "", "", "", submission.credit_text(), ""])
    head = ["submission", "scene", "status", "pixels that differ", "by more than 8 levels", "seconds", "credit", "notes"]
    text = markdown(head, rows)
    return text if len(submissions) == 1 else f"{text}\n\n{summary(submissions)}"


def summary(submissions):
    names = [row.scene for row in submissions[0].rows]
    rows = [[each.name, *(row.status for row in each.rows), each.credit_text()] for each in submissions]
    return markdown(["submission", *names, "credit"], rows)


def picture_table(submissions):
    """Returns a Markdown table with a line for each picture."""
    rows = []
    for submission in submissions:
        for row in submission.rows:
            for picture in row.pictures:
                report = picture.report
                cells = [picture.name, row.status if row.status not in ("ok", "differs") else picture.status]
                if report:
                    over, pixels = report["pixels_over_levels"], report["width"] * report["height"]
                    cells += [f"{100 * over['0'] / pixels:.4f}%", over["1"], over["8"], report["worst_levels"]]
                    cells.append(f"{report['rmse_levels']:.4f}")
                rows.append([submission.name] * (len(submissions) > 1) + cells + [""] * (7 - len(cells)))
    head = ["picture", "status", "pixels that differ", "by more than 1 level", "by more than 8", "worst", "RMSE"]
    return markdown(["submission"] * (len(submissions) > 1) + head, rows)


def json_text(submissions, grader):
    """Returns all results as JSON."""
    results = {
        "data": str(grader.data),
        "references": str(grader.samples),
        "references_rendered_by_a2": grader.rendered,
        "size": grader.size,
        "limits": vars(grader.limits),
        "time_limit_seconds": grader.seconds,
        "memory_limit_megabytes": grader.megabytes,
        "submissions": [
            {
                "name": submission.name,
                "path": str(submission.path),
                "credit": round(submission.credit, 3),
                "possible": round(submission.possible, 3),
                "scenes": [row_json(row) for row in submission.rows],
            }
            for submission in submissions
        ],
    }
    return json.dumps(results, indent=1) + "\n"


def row_json(row):
    pictures = [
        {"name": each.name, "status": each.status, "message": each.message, "comparison": each.report}
        for each in row.pictures
    ]
    return {
        "scene": row.scene,
        "status": row.status,
        "credit": row.credit,
        "possible": row.possible,
        "notes": row.notes,
        "run": vars(row.run) if row.run else None,
        "pictures": pictures,
    }


def csv_text(submissions):
    """Returns a line for each scene of each submission."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    head = "submission scene status credit possible seconds cpu_seconds megabytes"
    over = "pixels_over_0 pixels_over_1 pixels_over_8 worst_levels notes"
    writer.writerow([*head.split(), *over.split()])
    for submission in submissions:
        for row in submission.rows:
            start = [submission.name, row.scene, row.status, row.credit, row.possible]
            writer.writerow([*start, *cost(row), *figures(row), notes(row)])
    return text.getvalue()


def write_html(page, submissions, grader):
    """Writes one page that needs nothing else: a table, and for each submission the pictures that differ."""
    page.write('<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
               '<meta name="viewport" content="width=device-width">\n<title>Grading</title>\n')
    page.write(f"<style>{STYLE}{PANEL_STYLE}</style>\n</head>\n<body>\n<h1>Grading</h1>\n{explanation(grader)}")
    page.write(html_summary(submissions) + PANEL_CHOICE)
    for number, submission in enumerate(submissions):
        write_section(page, number, submission, is_open=len(submissions) == 1)
    page.write("</body>\n</html>\n")


def explanation(grader):
    rendered = f" Those of {', '.join(grader.rendered)} are rendered by a2." if grader.rendered else ""
    limits = grader.limits
    return (
        f"<p>Scenes of {escaped(grader.data)} at {grader.size} x {grader.size} pixels; references of "
        f"{escaped(grader.samples)}.{rendered} A picture is right (<em>ok</em>) if at most {limits.percent_over_0:g}% of "
        f"its pixels differ, at most {limits.percent_over_1:g}% by more than one level (of 255), and at most "
        f"{limits.pixels_over_8} pixels by more than eight. Each picture below shows the submission (A), the reference "
        "(B) and the difference; the numbers under the colours are levels.</p>\n"
    )


def escaped(text):
    return html.escape(str(text))


def panel(path, alt):
    """Returns a panel of pictures in a box that scrolls, also by keys."""
    data = base64.b64encode(path.read_bytes()).decode()
    image = f'<img loading="lazy" alt="{escaped(alt)}" src="data:image/png;base64,{data}">'
    return f'<div class="panel" tabindex="0">{image}</div>'


def cell(status):
    """Returns a table cell in the colour of a status."""
    kind = status if status in ("ok", "differs") else "bad"
    return f'<td class="{kind}">{escaped(status)}</td>'


def html_summary(submissions):
    names = "".join(f"<th>{escaped(row.scene)}</th>" for row in submissions[0].rows)
    lines = []
    for number, submission in enumerate(submissions):
        cells = "".join(cell(row.status) for row in submission.rows)
        link = f'<a href="#s{number}">{escaped(submission.name)}</a>'
        lines.append(f'<tr><td>{link}</td>{cells}<td class="number">{submission.credit_text()}</td></tr>\n')
    return f"<table>\n<tr><th>submission</th>{names}<th>credit</th></tr>\n{''.join(lines)}</table>\n"


def write_section(page, number, submission, is_open):
    """Writes the results of a submission, picture by picture as they are read: a page of hundreds is large."""
    # A link to what is inside opens the section.
    page.write(f"<details{' open' if is_open else ''}>\n<summary>{escaped(submission.name)}: ")
    page.write(f'{submission.credit_text()}</summary>\n<table id="s{number}">\n')
    heads = ["scene", "status", "pixels that differ", "by more than 8 levels", "seconds", "MB", "credit", "notes"]
    page.write("<tr>" + "".join(f"<th>{head}</th>" for head in heads) + "</tr>\n")
    for row in submission.rows:
        over, _, far, _ = figures(row)
        seconds, _, megabytes = cost(row)
        numbers = "".join(f'<td class="number">{value}</td>' for value in (over, far, seconds, megabytes, f"{row.credit:.1f}"))
        page.write(f"<tr><td>{escaped(row.scene)}</td>{cell(row.status)}{numbers}")
        page.write(f'<td class="notes">{escaped(notes(row))}</td></tr>\n')
    page.write("</table>\n")
    for row in submission.rows:
        for picture in row.pictures:
            if picture.panel and picture.panel.is_file():
                write_figure(page, picture)
    page.write("</details>\n")


def write_figure(page, picture):
    worst = picture.report["worst_pixel"]
    caption = (
        f"{picture.name}: {picture.report['pixels_over_levels']['0']} pixels differ; the worst, at x {worst['x']}, "
        f"y {worst['y']} (from the upper left), is {worst['a']} and should be {worst['b']}"
    )
    shown = panel(picture.panel, f"{picture.name}: submission, reference, difference")
    page.write(f"<figure>{shown}<figcaption>{escaped(caption)}</figcaption></figure>\n")
