"""Compares what two programs wrote of the same runs (bench/no_drift.sh), number by number as text.

  no_drift.py BEFORE AFTER

A table tells how much was compared and what differs. The exit status is 1 where anything differs that no exemption
below names."""
import collections
import csv
import json
import pathlib
import re
import sys

# What may differ, by name: the runs, the file, and the part of it. A part is a path in a JSON file, TABLE/COLUMN of a
# table, or a stage of the journal of which only one program has simulations.
EXEMPT = {
    "times of the clock": [
        (".*", r"result\.json", r"/wall_time_s|/time_step/study/\d+/cpu_seconds"),
        (".*", "tables", "evaluations/seconds"),
    ],
    "words of warnings": [(".*", r"result\.json", r"/warnings/\d+")],
    # Simulated by `reproduce` alone
    "the frictions of the thesis's figure 4.4": [
        (".*", r"journal\.csv", "before: friction"),
        (".*", "tables", "rms_friction"),
    ],
    # They are proposed from, so that the parameters found and what is simulated with these are others
    "intervals of bins by t S - D, and what follows from them": [
        (
            "bin|together",
            r"journal\.csv",
            "(before|after): (proposals|polish|profile|choice|confirmation|half_step|prediction)",
        ),
        (
            "bin|together.*",
            r"result\.json",
            r"/(parameters|objective|surrogate|emulator|posterior|self_test|trade_offs|time_step/at_half|comparison"
            r"|discharge|kinematic|beverloo|agreement|experiments|warnings)/.*",
        ),
        (
            "bin|together.*",
            r"result\.json",
            "/(evaluations|simulations|out_of_reach_share|mean_signed_error|rms_position_m)",
        ),
        ("bin|together.*", "tables", "(evaluations|profile|influence|agreement|bands|ranks|velocity_comparison)(/.*)?"),
        ("bin|together.*", "tables", "(discharge_curves|rate_comparison|stagnant_boundary)/simulated.*"),
        ("bin|together.*", "tables", "rate_comparison/(error|validation|curve).*"),
    ],
}
# Words of result.json that were chosen anew.
RENAMED = {
    "/objective/shares/flow_rate": "/objective/shares/discharge_rate",
    "/objective/shares/remaining": "/objective/shares/what_stays",
    "bin_calibration": "calibration",
    "bin_validation": "validation",
}
PARAMETERS = ("friction_particle_particle", "friction_particle_wall", "restitution")
KEY = (*PARAMETERS, "time_step_fraction", "seed")
COMPARED = ("objective", "agreement_percent", "status", "time_step_s")


def exemption_of(run, file, part):
    for name, parts in EXEMPT.items():
        if any(re.fullmatch(r, run) and re.fullmatch(f, file) and re.fullmatch(p, part) for r, f, p in parts):
            return name
    return None


class Comparison:
    """One file of one run."""

    def __init__(self, run, file):
        self.run, self.file = run, file
        self.equal, self.exempt, self.differing = 0, collections.Counter(), collections.Counter()

    def value(self, part, before, after, shown=None):
        if before == after:
            self.equal += 1
        else:
            self.other(part, f"{shown or part}: {before} before, {after} after")

    def other(self, part, sentence, count=1):
        name = exemption_of(self.run, self.file, part)
        if name:
            self.exempt[name] += count
        else:
            self.differing[sentence] += count


def journal_rows(folder):
    """Rows of a journal by parameters, time step and seed; several where several scenes are simulated."""
    with open(folder / "result.json") as file:
        found = json.load(file)["parameters"]
    rows = collections.defaultdict(list)
    with open(folder / "journal.csv", newline="") as file:
        for row in csv.DictReader(file):
            # Half the step of what was found had the name of the search for a step
            if row["stage"] == "time_step" and all(float(row[name]) == found[name]["value"] for name in PARAMETERS):
                row["stage"] = "half_step"
            rows[tuple(row[name] for name in KEY)].append(row)
    return rows


def compare_journals(run, before, after):
    comparison = Comparison(run, "journal.csv")
    old, new = journal_rows(before), journal_rows(after)
    for key in old.keys() & new.keys():
        values = [sorted(tuple(row[name] for name in COMPARED) for row in rows[key]) for rows in (old, new)]
        shown = " ".join(key)
        if len(values[0]) != len(values[1]):
            comparison.other("rows", f"{shown}: {len(values[0])} rows before, {len(values[1])} after")
        for one, other in zip(*values):
            comparison.value("rows", one, other, shown)
    for who, some, others in (("before", old, new), ("after", new, old)):
        stages = collections.Counter(row["stage"] for key in some.keys() - others.keys() for row in some[key])
        for stage, count in sorted(stages.items()):
            print(f"{run}: only {who} has {count} simulations of stage {stage}")
            comparison.other(f"{who}: {stage}", f"{count} simulations of stage {stage} only {who}", count)
    return comparison, sum(row["stage"] == "friction" for rows in old.values() for row in rows)


def leaves(value, path=""):
    if isinstance(value, dict):
        for key, item in value.items():
            yield from leaves(item, f"{path}/{key}")
    elif isinstance(value, list):
        for place, item in enumerate(value):
            yield from leaves(item, f"{path}/{place}")
    else:
        yield path, value


def compare_json(run, file, before, after, left_out):
    """Everything that the earlier program wrote must be there still; what is new is no drift. Of the simulations that
    it counted, so many are left out."""
    comparison = Comparison(run, file)
    # Numbers as they stand in the file
    old, new = (
        dict(leaves(json.loads((folder / file).read_text(), parse_float=str, parse_int=str)))
        for folder in (before, after)
    )
    if left_out > 0 and "/simulations" in old:
        old["/simulations"] = str(int(old["/simulations"]) - left_out)
    for path, value in old.items():
        comparison.value(path, RENAMED.get(value, value), new.get(RENAMED.get(path, path), "nothing"))
    return comparison


def compare_tables(run, before, after):
    comparison = Comparison(run, "tables")
    for file in sorted((before / "tables").glob("*.csv")):
        other = after / "tables" / file.name
        if not other.exists():
            comparison.other(file.stem, f"{file.stem}: is missing")
            continue
        with open(file, newline="") as one, open(other, newline="") as two:
            rows = list(csv.DictReader(one)), list(csv.DictReader(two))
        if len(rows[0]) != len(rows[1]):
            comparison.other(file.stem, f"{file.stem}: {len(rows[0])} rows before, {len(rows[1])} after")
        for number, (old, new) in enumerate(zip(*rows)):
            for column, value in old.items():
                shown = f"{file.stem}/{column} of row {number + 1}"
                comparison.value(f"{file.stem}/{column}", value, new.get(column, "nothing"), shown)
    return comparison


def main(before, after, shown_at_most=20):
    comparisons = []
    for old in sorted(path for path in before.iterdir() if path.is_dir()):
        new = after / old.name
        journals, frictions = compare_journals(old.name, old, new)
        comparisons.append(journals)
        folders = [old, *sorted(path.parent for path in old.glob("*/result.json"))]
        for folder in folders:
            run = str(folder.relative_to(before))
            for file in ("measured.json", "result.json"):
                if (folder / file).exists():
                    comparisons.append(compare_json(run, file, folder, after / run, frictions))
            comparisons.append(compare_tables(run, folder, after / run))
    print(f"{'run':20} {'file':14} {'equal':>8} {'exempt':>8} {'differing':>10}")
    for one in comparisons:
        print(f"{one.run:20} {one.file:14} {one.equal:8} {one.exempt.total():8} {one.differing.total():10}")
    for one in comparisons:
        for name, count in one.exempt.items():
            print(f"exempt: {one.run} {one.file}: {count} of {name}")
    for one in comparisons:
        for sentence in list(one.differing)[:shown_at_most]:
            print(f"DIFFERS: {one.run} {one.file} {sentence}")
        if len(one.differing) > shown_at_most:
            print(f"DIFFERS: {one.run} {one.file} and {len(one.differing) - shown_at_most} more")
    return 1 if any(one.differing for one in comparisons) else 0


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])))
