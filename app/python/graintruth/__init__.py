"""Graintruth from Python: run folders as numpy arrays, the program's verbs, the simulator.

    import graintruth
    run = graintruth.Run("out/micro")
    run.result["parameters"], run.tracks("rep1")["x_m"], run.journal()["objective"]

`graintruth.sim` is the simulator as a library. Everything is in SI units; x right, z up.
"""

from . import sim
from .program import InputError, ProgramFailed, evaluate, simulate
from .run_folder import Run, read_table

__all__ = ["InputError", "ProgramFailed", "Run", "evaluate", "read_table", "sim", "simulate"]
