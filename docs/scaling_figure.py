"""Draws the first table of docs/performance.md, doubly logarithmic: scaling_figure.py PERFORMANCE.md FIGURE.svg"""

import sys

import matplotlib

matplotlib.use("svg")
matplotlib.rcParams.update({"svg.hashsalt": "graintruth", "svg.fonttype": "none"})  # same table, same bytes
from matplotlib import pyplot

HEAD = "| bed | spheres | contacts a sphere | ms a step |"


def beds(lines):
    """{bed: ([spheres], [ms a step], [bytes a sphere])} of the table under HEAD."""
    start = next(i for i, line in enumerate(lines) if line.startswith(HEAD)) + 2
    table = {}
    for line in lines[start:]:
        if not line.startswith("|"):
            return table
        bed, spheres, _, step, _, memory = (cell.strip() for cell in line.strip("|\n").split("|"))
        for column, cell in zip(table.setdefault(bed, ([], [], [])), (spheres, step, memory)):
            column.append(float(cell))
    return table


def main(document, figure_file):
    with open(document, encoding="utf-8") as file:
        table = beds(file.readlines())
    figure, (time, memory) = pyplot.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
    for (bed, (spheres, step, size)), marker in zip(table.items(), "os"):
        time.loglog(spheres, step, marker=marker, label=bed)
        memory.loglog(spheres, size, marker=marker, label=bed)
        # What a cost in proportion to the spheres would be, from the first bed on
        time.loglog(spheres, [step[0] * n / spheres[0] for n in spheres], color="0.6", lw=0.8, ls="--", zorder=0)
    time.set(xlabel="spheres", ylabel="CPU time of a step (ms)", title="dashed: in proportion")
    memory.axhline(600, color="0.6", lw=0.8, ls="--")
    memory.set(xlabel="spheres", ylabel="bytes a sphere", title="dashed: 600 asked for")
    sizes = [150, 300, 600, 1000, 2000, 5000]
    memory.set_yticks(sizes, [str(size) for size in sizes])
    memory.minorticks_off()
    time.legend(frameon=False)
    for axes in (time, memory):
        axes.grid(True, color="0.9", lw=0.5)
        axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(figure_file, metadata={"Date": None})


if __name__ == "__main__":
    main(*sys.argv[1:])
