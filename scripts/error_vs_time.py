#!/usr/bin/env python3
"""Measures error against run time: see error_vs_time.sh.

Raw numbers go to docs/error-vs-time/*.csv; the page and the curves are made from these files alone.
"""

import csv
import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

sys.dont_write_bytecode = True
import batch  # noqa: E402
import error_vs_time_page  # noqa: E402

ROOT = batch.PROJECT
OUT = ROOT / "docs" / "error-vs-time"
A2 = ROOT / "target" / "release" / "a2"
SIZE = int(os.environ.get("SIZE", "100"))
# scene01: the words of its command line.
SCENES = {scene.short_name: [f"{scene.name}.txt", *scene.flags] for scene in batch.read()}
SAMPLERS = ("independent", "stratified", "sobol")
# Of a2 beside POV-Ray.
TARGETS = (4, 2, 1, 0.5, 0.25)
# Samples of the last point of a curve. The reference has sixteen times as many.
MOST = {"": 64, "-filter": 16}


def a2(scene, flags, binary=A2, size=SIZE):
    """Runs a2 on a scene and returns its standard error output."""
    name, *scene_flags = SCENES[scene]
    # Relative to the project, because the figures show the scene's name as it is given.
    command = [binary, "-input", f"data/{name}", "-size", size, size, *scene_flags, *map(str, flags)]
    done = subprocess.run([str(word) for word in command], cwd=ROOT, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, command))}: {done.stderr}")
    return done.stderr


def report(scene, flags, folder, **where):
    path = folder / "report.json"
    a2(scene, [*flags, "-quiet", "-report", path], **where)
    return json.loads(path.read_text())


def write_csv(name, rows):
    OUT.mkdir(parents=True, exist_ok=True)
    with open(OUT / f"{name}.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    print(f"{name}.csv: {len(rows)} rows", flush=True)


def reference(scene, filtered, folder):
    """Renders the picture that counts as true; returns its path and its own estimated error in levels."""
    path = folder / f"{scene}{filtered}.pfm"
    if path.exists():
        return path, json.loads(path.with_suffix(".json").read_text())
    flags = ["-sampler", "sobol", "-samples", 16 * MOST[filtered], "-seed", 987654321, "-output", path, *filtered.split()]
    own_error = report(scene, flags, folder)["estimated_error"]["levels"]["rmse"]
    path.with_suffix(".json").write_text(json.dumps(own_error))
    return path, own_error


def curves(folder):
    """Measures error and cost of every sampler and of adaptive sampling, in every scene, with and without -filter.

    a2 draws the figures, and keeps their numbers in them as metadata.
    """
    rows = []
    OUT.mkdir(parents=True, exist_ok=True)
    for filtered, most in MOST.items():
        for scene in SCENES:
            truth, own_error = reference(scene, filtered, folder)
            common = {"scene": scene, "filter": "yes" if filtered else "no", "reference_error": own_error}
            figure = OUT / f"{scene}{filtered}.svg"
            a2(scene, ["-output", folder / "o.png", "-reference", truth, *filtered.split(), "-samples", most,
                       "-convergence", figure, "-quiet"])
            table = figure.read_text().split("<metadata>")[1].split("</metadata>")[0].strip()
            for point in csv.DictReader(table.splitlines()):
                rows.append({
                    **common,
                    "method": point["sampler"],
                    # Of adaptive sampling all rays count, also those that only look where samples are needed.
                    "samples": point["camera_rays_a_pixel"] if point["target_levels"]
                    else int(point["samples"]) * (9 if filtered else 1),
                    "target": point["target_levels"],
                    "rays": point["rays"],
                    "cpu_seconds": point["cpu_seconds"],
                    "wall_seconds": point["seconds"],
                    "estimated": point["estimated_rmse_levels"],
                    "low_95": point["estimated_low_95"],
                    "high_95": point["estimated_high_95"],
                    "true": point["true_rmse_levels"],
                })
            print(scene, filtered or "plain", flush=True)
    write_csv("curves", rows)


def true_error(text):
    """Returns the RMSE in levels that a2 prints for a picture with a reference."""
    line = next(line for line in text.splitlines() if line.startswith("true error"))
    return float(line.split("RMSE")[1].split()[0])


def samples(folder):
    """Measures pictures in one set, not in two halves: equal numbers of samples, mean square over seeds."""
    rows = []
    for scene in SCENES:
        truth, _ = reference(scene, "", folder)
        for sampler in SAMPLERS:
            for count in (4, 8, 16):
                squares = [
                    true_error(a2(scene, ["-output", folder / "o.png", "-reference", truth, "-sampler", sampler,
                                          "-samples", count, "-seed", seed])) ** 2
                    for seed in range(8)
                ]
                rows.append({"scene": scene, "sampler": sampler, "samples": count,
                             "true": (sum(squares) / len(squares)) ** 0.5})
        truth, _ = reference(scene, "-filter", folder)
        fixed = true_error(a2(scene, ["-output", folder / "o.png", "-reference", truth, "-jitter", "-filter"]))
        rows.append({"scene": scene, "sampler": "stratified, -filter", "samples": 144, "true": fixed})
    write_csv("samples", rows)


def bounces(folder):
    """Measures the error of fewer bounces. There is no sampling error, because the camera rays are the same."""
    rows = []
    for scene in ("scene06", "scene07"):
        truth = folder / "deep.pfm"
        a2(scene, ["-output", truth, "-bounces", 32, "-quiet"], size=2 * SIZE)
        for depth in range(9):
            flags = ["-output", folder / "o.png", "-bounces", depth, "-reference", truth]
            found = report(scene, flags, folder, size=2 * SIZE)
            rows.append({
                "scene": scene,
                "bounces": depth,
                "rays": found["rays"]["total"],
                "cpu_seconds": found["phases"]["render"]["cpu_seconds"],
                "true": found["true_error"]["rmse_levels"],
            })
    write_csv("bounces", rows)


def f32(folder):
    """Compares the f32 build with the f64 build. There is no sampling error, because the camera rays are the same."""
    target = ROOT / "target" / "f32"
    subprocess.run(["cargo", "build", "--release", "--quiet", "--features", "f32", "--target-dir", target], cwd=ROOT,
                   check=True)
    rows = []
    for scene in SCENES:
        truth = folder / "f64.pfm"
        times = {"f64": [], "f32": []}
        flags = ["-filter", "-threads", 1]
        error = None
        for _ in range(5):
            for kind, binary in (("f64", A2), ("f32", target / "release" / "a2")):
                output = truth if kind == "f64" else folder / "o.png"
                against = [] if kind == "f64" else ["-reference", truth]
                found = report(scene, [*flags, "-output", output, *against], folder, binary=binary, size=2 * SIZE)
                times[kind].append(found["phases"]["render"]["cpu_seconds"])
                error = found["true_error"] or error
        rows.append({
            "scene": scene,
            "f64_cpu_seconds": sorted(times["f64"])[2],
            "f32_cpu_seconds": sorted(times["f32"])[2],
            "true": error["rmse_levels"],
            "worst": error["worst_levels"],
            "share_over_1_level": error["share_over_1_level"],
        })
    write_csv("f32", rows)


def povray(folder):
    """Measures POV-Ray's antialiasing against a very fine picture of its own, in files of 16 bits a channel.

    Their values are linear, as a2's are: without File_Gamma they would be coded as sRGB, and the errors of dark pixels
    larger.
    """
    if not shutil.which("povray"):
        print("povray is not installed: its part is left out")
        return
    scene, size = "scene02", 3 * SIZE
    translate = [sys.executable, ROOT / "benches" / "peers" / "translate.py", ROOT / "data" / SCENES[scene][0], folder]
    subprocess.run([*map(str, translate), "--size", str(size), str(size), "--to", "povray"], check=True)
    source = next(folder.glob("*.pov"))

    def rendered(flags):
        picture = folder / "pov.ppm"
        command = ["povray", f"+I{source.name}", f"+O{picture}", "+FP16", "File_Gamma=1.0", f"+W{size}", f"+H{size}", "-D", "+WT1", *flags]
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(command, cwd=folder, check=True, capture_output=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return ppm_levels(picture.read_bytes()), after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    truth, _ = rendered(["+A0.0", "+AM1", "+R24", "-J"])
    rows = []
    for flags in ["-A", *(f"+A{threshold} +AM{method} +R{depth} +J1.0" for method, threshold, depths in
                          ((1, 0.0, (2, 3, 4, 6, 8)), (2, 0.1, (1, 2, 3, 4)), (2, 0.01, (2, 3, 4, 5)))
                          for depth in depths)]:
        picture, seconds = rendered(flags.split())
        error = (sum((a - b) ** 2 for a, b in zip(picture, truth)) / len(truth)) ** 0.5
        rows.append({"scene": scene, "program": "povray", "flags": flags, "cpu_seconds": seconds, "true": error})
    truth = folder / "large.pfm"
    a2(scene, ["-output", truth, "-sampler", "sobol", "-samples", 512, "-seed", 987654321, "-quiet"], size=size)
    against = ["-output", folder / "o.png", "-reference", truth]
    for flags in [*(f"-samples {n}" for n in (1, 2, 4, 8, 16, 32)), *(f"-target-error {e}" for e in TARGETS)]:
        found = report(scene, [*against, *flags.split()], folder, size=size)
        rows.append({"scene": scene, "program": "a2", "flags": flags, "cpu_seconds": sum(times["cpu_seconds"] for times in found["phases"].values()),
                     "true": found["true_error"]["rmse_levels"]})
    write_csv("povray", rows)


def ppm_levels(data):
    """Returns the values of a binary PPM, scaled to 0 .. 255."""
    words, rest = [], data
    while len(words) < 4:
        word, rest = rest.split(None, 1) if len(words) < 3 else (rest.split(None, 1)[0], rest)
        if word.startswith(b"#"):
            rest = rest.split(b"\n", 1)[1]
            continue
        words.append(word)
    most = int(words[3])
    rest = rest[len(words[3]) + 1:]
    if most > 255:
        return [255.0 * (rest[i] * 256 + rest[i + 1]) / most for i in range(0, len(rest) - 1, 2)]
    return [255.0 * value / most for value in rest]


def main():
    parts = os.environ.get("PARTS", "curves samples bounces f32 povray page").split()
    with tempfile.TemporaryDirectory() as folder:
        for name, part in (("curves", curves), ("samples", samples), ("bounces", bounces), ("f32", f32),
                           ("povray", povray)):
            if name in parts:
                part(Path(folder))
    if "page" in parts:
        error_vs_time_page.write(ROOT, SIZE)


if __name__ == "__main__":
    main()
