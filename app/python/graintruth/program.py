"""The program's verbs, called as a shell would call them."""

import json
import os
import shutil
import subprocess
import tempfile
from pathlib import Path


class InputError(ValueError):
    """Unusable input; the sentence says where and what to do (exit status 2)."""


class ProgramFailed(RuntimeError):
    """The program ended with another status than 0 or 2."""


def _program():
    """$GRAINTRUTH_PROGRAM, else the program built or installed with this package, else of the PATH."""
    if "GRAINTRUTH_PROGRAM" in os.environ:
        return os.environ["GRAINTRUTH_PROGRAM"]
    folders = Path(__file__).resolve().parents
    for candidate in (folders[2] / "graintruth", folders[4] / "bin" / "graintruth"):
        if candidate.is_file():
            return str(candidate)
    found = shutil.which("graintruth")
    if not found:
        raise ProgramFailed("the program graintruth is not on the PATH; set GRAINTRUTH_PROGRAM.")
    return found


def call(*arguments):
    """Runs the program and returns what it prints."""
    done = subprocess.run(
        [_program(), *map(str, arguments)], capture_output=True, text=True, check=False
    )
    if done.returncode:
        sentence = done.stderr.strip().removeprefix("graintruth: ")
        raise (InputError if done.returncode == 2 else ProgramFailed)(sentence)
    return done.stdout


def _options(**options):
    return [word for name, value in options.items() if value is not None for word in (f"--{name}", value)]


def evaluate(experiment, parameters, *, out=None, runs=None, seed=None, jobs=None):
    """One evaluation of an experiment file: agreement, objective and rms as a dict.

    `parameters` is a dict such as {"friction_particle_particle": 0.2}, or a file as --parameters
    takes it. What it does not name stays at the bench value. Tracks are made once, and simulations
    that the folder `out` already holds are not repeated.
    """
    words = ["evaluate", experiment, "--json", "--quiet"]
    words += _options(out=out, runs=runs, seed=seed, jobs=jobs)
    if not isinstance(parameters, dict):
        return json.loads(call(*words, "--parameters", parameters))
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "parameters.toml"
        file.write_text("".join(f"{name} = {float(value)!r}\n" for name, value in parameters.items()))
        return json.loads(call(*words, "--parameters", file))


def simulate(scene, *, out=None, seed=None):
    """Runs a scene file or a deck and returns its run folder."""
    from .run_folder import Run

    out = Path("out") / Path(scene).stem if out is None else out
    call("simulate", scene, "--quiet", *_options(out=out, seed=seed))
    return Run(out)
