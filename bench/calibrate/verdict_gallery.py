#!/usr/bin/env python3
"""Calibrates small experiments of different quality, to look at what their reports say.

    bench/calibrate/verdict_gallery.py build/release/graintruth OUT [NAME...]

All use tracks of the bundled micro experiment (datasets/micro/truth) and soft particles, so that a
calibration takes seconds to a minute. Each report is drawn at 1280 and at 400 px where chromium is
installed: OUT/<name>/1280.png shows the first screen, OUT/<name>/1280-all.png the whole page. The
first line of every verdict is printed.
"""
import csv
import json
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
EVENT_TIME = 0.2  # s of film, datasets/micro/experiment.toml
BROWSER = "/usr/bin/chromium"


def tracks(number):
    """Rows of one replicate: time from the start event (s), particle, x and z (m), angle (rad)."""
    with open(ROOT / f"datasets/micro/truth/rep{number}_tracks.csv", newline="") as file:
        return [{"time_s": float(row["time_s"]) - EVENT_TIME, "particle": int(row["particle"]),
                 "x_m": float(row["x_m"]), "z_m": float(row["z_m"]), "angle_rad": float(row["angle_rad"])}
                for row in csv.DictReader(file)]


def slower(rows):
    """As if everything in this replicate had gone at 85 % of its speed: at each time what was 85 % as late."""
    paths = {}
    for row in rows:
        paths.setdefault(row["particle"], []).append(row)
    made = []
    for path in paths.values():
        for row in path:
            time = 0.85 * row["time_s"] if row["time_s"] > 0 else row["time_s"]
            after = next(i for i, other in enumerate(path) if other["time_s"] >= time)
            before = path[max(0, after - 1)]
            span = path[after]["time_s"] - before["time_s"]
            share = (time - before["time_s"]) / span if span > 0 else 0.0
            made.append({**row, **{name: before[name] + share * (path[after][name] - before[name])
                                   for name in ("x_m", "z_m", "angle_rad")}})
    return sorted(made, key=lambda row: (row["time_s"], row["particle"]))


class Case:
    def __init__(self, meaning, budget=80, replicates=5, frames=25, changes=(), odd=None):
        self.meaning, self.budget, self.replicates = meaning, budget, replicates
        self.frames, self.changes, self.odd = frames, changes, odd


CASES = {
    "good": Case("five replicates, the rig as it was, enough budget", budget=120),
    "wrong-slope": Case("the file states a slope of 50 instead of 60 degrees",
                        changes=[("slope_angle_deg = 60", "slope_angle_deg = 50")]),
    "small-budget": Case("the budget ends before intervals are found", budget=20),
    "not-identified": Case("restitution alone is sought, on which nothing depends here", budget=40, changes=[
        ("friction_particle_particle = 0.36", "friction_particle_particle = 0.12"),
        ("friction_particle_wall = 0.35", "friction_particle_wall = 0.17"),
        ("friction_particle_particle = {lower = 0.0, upper = 0.6}\n", ""),
        ("friction_particle_wall = {lower = 0.0, upper = 0.7}\n", "")]),
    "outlier": Case("the third replicate ran at 85 % of the speed of the others", odd=3),
    "pair": Case("two replicates only", replicates=2),
}


def write_experiment(case, folder):
    text = (ROOT / "datasets/micro/experiment.toml").read_text()
    text = text.replace("elastic_modulus_gpa = 6.89", "elastic_modulus_mpa = 50")
    text = text.replace("frames = 25", f"frames = {case.frames}")
    text = re.sub(r'note = ".*"', f'note = "A made-up case: {case.meaning}."', text)
    for number in range(1, 6):
        block = f'[[replicate]]\nvideo = "rep{number}.mp4"\n'
        if number > case.replicates:
            text = text.replace(block, "")
            continue
        text = text.replace(block, f'[[replicate]]\ntracks = "rep{number}.csv"\n')
        rows = tracks(number)
        with open(folder / f"rep{number}.csv", "w", newline="") as file:
            writer = csv.DictWriter(file, ["time_s", "particle", "x_m", "z_m", "angle_rad"])
            writer.writeheader()
            writer.writerows(slower(rows) if number == case.odd else rows)
    for old, new in case.changes:
        assert old in text, old
        text = text.replace(old, new)
    (folder / "experiment.toml").write_text(text)


def screenshot(report, picture, width, height):
    subprocess.run([BROWSER, "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars",
                    "--force-prefers-reduced-motion", "--virtual-time-budget=20000",
                    f"--user-data-dir={picture.parent / 'browser'}", f"--window-size={width},{height}",
                    f"--screenshot={picture}", report.as_uri()],
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=True)


def main():
    program, out = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
    for name in sys.argv[3:] or CASES:
        case, folder = CASES[name], out / name
        folder.mkdir(parents=True, exist_ok=True)
        if not (folder / "run/result.json").exists():
            write_experiment(case, folder)
            with open(folder / "terminal.txt", "w") as terminal:
                subprocess.run([program, "calibrate", folder / "experiment.toml", "--out", folder / "run",
                                "--budget", str(case.budget), "--quiet"], stdout=terminal, check=True)
        else:
            subprocess.run([program, "report", folder / "run"], stdout=subprocess.DEVNULL, check=True)
        result = json.loads((folder / "run/result.json").read_text())
        print(f"{name}: {json.dumps(result.get('verdict'), indent=1, ensure_ascii=False)}", flush=True)
        if pathlib.Path(BROWSER).exists():
            for width, height in [(1280, 800), (400, 800)]:
                screenshot(folder / "run/report.html", folder / f"{width}.png", width, height)


if __name__ == "__main__":
    main()
