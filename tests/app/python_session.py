"""What python_test.cpp lets Python do, in a folder with a small experiment and its tracks."""

import json
import sys

import graintruth
import numpy
from graintruth import sim

PARAMETERS = {"friction_particle_particle": 0.2, "friction_particle_wall": 0.3}


def drop(restitution):
    """A ball dropped on a floor: the simulation, and the heights seen every 0.2 ms."""
    scene = sim.Scene()
    ball = scene.add_material(sim.Material(youngs_modulus=1e9, poisson_ratio=0.3))
    floor = scene.add_material(sim.rigid_material())
    scene.set_surfaces(ball, floor, sim.Surfaces(friction=0.3, restitution=restitution))
    shape = sim.make_clump(sim.chain_of_spheres(1, radius=0.01, spacing=0.01), density=1000)
    scene.add_body(scene.add_type(shape), position=[0, 0, 0.06])
    scene.add_wall(sim.plane_wall([0, 0, 0], [0, 0, 1], material=floor))
    simulation = sim.Simulation(scene, impact_speed=1.0)
    heights = []
    run = simulation.run_until(
        0.25, interval=2e-4, observer=lambda state: heights.append(state.position[0, 2])
    )
    assert run.status == "completed" and run.time == 0.25, run
    return simulation, numpy.array(heights)


def rebounds_as_asked():
    # Heights of fall and rebound above the ball's radius: h2/h1 = e^2
    simulation, heights = drop(restitution=0.6)
    fallen = numpy.argmax(heights < 0.011)
    assert abs((heights[fallen:].max() - 0.01) / 0.05 - 0.6**2) < 2e-3
    assert simulation.state.position.shape == (1, 3)
    assert simulation.state_hash() == drop(restitution=0.6)[0].state_hash()
    assert simulation.state_hash() != drop(restitution=0.7)[0].state_hash()


def tells_contacts_and_energy():
    scene = sim.Scene()
    grain = scene.add_material(sim.Material(1e8, 0.3))
    scene.add_type(sim.make_clump([sim.ElementSphere([0, 0, 0], 0.01)], mass=0.02))
    scene.add_body(0, [0, 0, 0.01])
    scene.add_wall(sim.plane_wall([0, 0, 0], [0, 0, 1], material=grain))
    scene.set_surfaces(grain, grain, sim.Surfaces(restitution=0.3))
    simulation = sim.Simulation(scene)
    simulation.run_until(0.1)
    contacts = simulation.contacts()
    assert contacts["with_wall"] == [True]
    assert abs(contacts["normal_force"][0] / (0.02 * 9.81) - 1) < 1e-6
    assert abs(simulation.wall_force(0)[2] / (-0.02 * 9.81) - 1) < 1e-6
    assert abs(simulation.energy().gravity / (0.02 * 9.81 * 0.01) - 1) < 1e-3


def refuses_what_the_simulator_refuses():
    for wrong in (
        lambda: sim.make_clump([], density=1000),
        lambda: sim.plane_wall([0, 0, 0], [0, 0, 0]),
        lambda: sim.Simulation(sim.Scene(), time_step_fraction=2),
    ):
        try:
            wrong()
        except ValueError as error:
            assert str(error)
        else:
            raise AssertionError("was accepted")


def ends_with_the_observers_own_error():
    def observer(state):
        raise KeyError("mine")

    scene = sim.Scene()
    scene.add_material(sim.Material(1e8, 0.3))
    scene.add_type(sim.make_clump([sim.ElementSphere([0, 0, 0], 0.01)], mass=0.02))
    scene.add_body(0, [0, 0, 1])
    try:
        sim.Simulation(scene).run_until(0.1, interval=0.01, observer=observer)
    except KeyError as error:
        assert error.args == ("mine",)
    else:
        raise AssertionError("went on")


def evaluates_and_reads_the_folder():
    score = graintruth.evaluate("experiment.toml", PARAMETERS, out="run", runs=2, jobs=2)
    assert score["parameters"]["friction_particle_wall"] == 0.3
    assert score["simulations"] == 2 and score["failed"] == 0
    again = graintruth.evaluate("experiment.toml", PARAMETERS, out="run", runs=2)
    assert again == score

    run = graintruth.Run("run")
    journal = run.journal()
    assert len(journal) == 2  # the second evaluation found both there
    assert set(journal["friction_particle_particle"]) == {0.2}
    assert journal["status"].tolist() == ["completed", "completed"]
    assert abs(journal["objective"].mean() / score["objective"] - 1) < 0.5

    # Tracks as they were given, row by row and as one array
    assert run.films == ["rep1", "rep2", "rep3", "rep4", "rep5"]
    given = graintruth.read_table("rep1.csv")
    times, poses = run.poses("rep1")
    assert given["particle"].dtype.kind == "i" and poses.shape == (times.size, 10, 3)
    row = given[given["particle"] == 4][7]
    assert (poses[times == row["time_s"], 3, :2] == [row["x_m"], row["z_m"]]).all()


def tells_what_the_program_says_of_bad_input():
    for wrong in (
        lambda: graintruth.evaluate("nowhere.toml", PARAMETERS),
        lambda: graintruth.evaluate("experiment.toml", {"friction": 0.2}),
        lambda: graintruth.Run("nowhere"),
        lambda: graintruth.simulate("nowhere.toml", out="simulated"),
    ):
        try:
            wrong()
        except graintruth.InputError as error:
            assert str(error) and not str(error).startswith("graintruth:"), error
        else:
            raise AssertionError("was accepted")


def runs_the_notebook(file):
    names = {}
    with open(file, encoding="utf-8") as stream:
        cells = json.load(stream)["cells"]
    for cell in cells:
        if cell["cell_type"] == "code":
            exec("".join(cell["source"]), names)
    # An impact of 20 steps is right to 1 %
    assert abs(names["restitution_seen"] / 0.5 - 1) < 0.01, names["restitution_seen"]
    assert len(names["journal"]) == 8


if __name__ == "__main__":
    rebounds_as_asked()
    tells_contacts_and_energy()
    refuses_what_the_simulator_refuses()
    ends_with_the_observers_own_error()
    evaluates_and_reads_the_folder()
    tells_what_the_program_says_of_bad_input()
    runs_the_notebook(sys.argv[1])
