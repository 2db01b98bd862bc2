"""What a run leaves in its folder, as numpy arrays with named columns (pandas.DataFrame takes them)."""

import csv
import io
import json
from pathlib import Path

import numpy

from . import program


def _column(cells):
    """Whole numbers, else numbers (an empty cell is NaN), else text."""
    for convert in (
        lambda: numpy.array([int(cell) for cell in cells]),
        lambda: numpy.array([float(cell) if cell else numpy.nan for cell in cells]),
    ):
        try:
            return convert()
        except (ValueError, OverflowError):
            pass
    return numpy.array(cells, dtype=str)


def _table_of(text):
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    rows = list(csv.reader(lines))
    header, rows = rows[0], rows[1:]
    columns = [_column([row[n] for row in rows]) for n in range(len(header))]
    table = numpy.empty(len(rows), [(name, c.dtype) for name, c in zip(header, columns)])
    for name, column in zip(header, columns):
        table[name] = column
    return table


def read_table(file):
    """A CSV file as an array with named columns."""
    return _table_of(Path(file).read_text(encoding="utf-8"))


class Run:
    """A run folder, read when asked: a file that is not there is missed only then."""

    def __init__(self, folder):
        self.folder = Path(folder)
        if not self.folder.is_dir():
            raise program.InputError(f"{self.folder}: there is no such run folder.")

    def __repr__(self):
        return f"graintruth.Run({str(self.folder)!r})"

    def _json(self, name):
        return json.loads((self.folder / name).read_text(encoding="utf-8"))

    @property
    def result(self):
        return self._json("result.json")

    @property
    def record(self):
        """run.json: version, command, configuration, seeds, stage times."""
        return self._json("run.json")

    @property
    def films(self):
        """Names of the replicates that have tracks."""
        files = sorted((self.folder / "tracks").glob("*.csv"))
        return [file.stem for file in files if not file.stem.endswith(".stagnant")]

    @property
    def tables(self):
        return sorted(file.stem for file in (self.folder / "tables").glob("*.csv"))

    def table(self, name):
        return read_table(self.folder / "tables" / f"{name}.csv")

    def tracks(self, film):
        """A row for each particle seen in each frame."""
        return read_table(self.folder / "tracks" / f"{film}.csv")

    def poses(self, film):
        """Times (s), and an array of frames x particles x (x, z, angle), NaN where not seen."""
        tracks = self.tracks(film)
        times, frame = numpy.unique(tracks["time_s"], return_inverse=True)
        poses = numpy.full((times.size, tracks["particle"].max(), 3), numpy.nan)
        for n, column in enumerate(("x_m", "z_m", "angle_rad")):
            poses[frame, tracks["particle"] - 1, n] = tracks[column]
        return times, poses

    def journal(self):
        """A row for each simulation, of a run that is under way too."""
        return _table_of(program.call("journal", "export", self.folder, "--out", "-"))
