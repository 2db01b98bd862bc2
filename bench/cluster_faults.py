#!/usr/bin/env python3
"""What must hold of --executor slurm when something goes wrong, on a real Slurm of this one machine.

    bench/cluster_faults.py PROGRAM SLURM_TOOL [FOLDER] [CASE...]

PROGRAM is the built graintruth, SLURM_TOOL a script that starts Slurm on one host (start, stop, kill-node, start-node,
kill-controller; see docs/cluster.md), FOLDER a place for both (default: a new one in /tmp). Prints a line for every case; exit 1 where one fails.
Runs as root, which the tool needs. The whole takes some ten minutes of waiting and a minute of computing."""
import json, os, pathlib, shutil, signal, sqlite3, subprocess, sys, tempfile, time

program, tool = map(os.path.abspath, sys.argv[1:3])
folder = pathlib.Path(sys.argv[3] if len(sys.argv) > 3 else tempfile.mkdtemp(prefix="graintruth-slurm-"))
wanted = sys.argv[4:]
slurm = folder / "slurm"
environment = dict(os.environ, NODES="4", CPUS="2", SLURM_CONF=str(slurm / "slurm.conf"))
runs = 16

scene = """title = "Clumps fall into a box"
dimensions = 3
[[material]]
name = "grain"
elastic_modulus_mpa = 20
poisson_ratio = 0.3
[[material]]
name = "wall"
rigid = true
[[surfaces]]
first = "grain"
second = "wall"
friction = 0.3
restitution = 0.6
[[surfaces]]
first = "grain"
second = "grain"
friction = 0.2
restitution = 0.7
[[particle]]
name = "clump"
material = "grain"
count = 12
density_g_per_cm3 = 1.2
spheres = [{x_mm = -4, radius_mm = 5}, {x_mm = 4, radius_mm = 6}]
[[wall]]
name = "floor"
material = "wall"
shape = "plane"
point_mm = [0, 0, 0]
normal = [0, 0, 1]
[fill]
method = "lattice"
low_mm = [-40, -30, 10]
high_mm = [40, 30, 150]
clearance_mm = 1
[run]
duration_s = 0.3
output_interval_s = 0.05
"""
experiment = """title = "How high the clumps stand"
[rig]
kind = "scene"
scene = "scene.toml"
[measure]
frame_interval_s = 0.1
frames = 3
observables = ["top"]
[measure.top]
column = "top_m"
engine_curve = "highest_grain_m"
unit = "m"
[tune]
friction_particle_particle = {lower = 0.0, upper = 0.6}
[execution]
folder = "%s"
grace_seconds = %g
time_limit_min = %g
task_seconds = 1
set_up = %s
options = %s
"""


def write(name, grace=15, set_up=(), limit=10, tasks=None, options=()):
    place = folder / name
    shutil.rmtree(place, ignore_errors=True)
    place.mkdir(parents=True)
    (place / "scene.toml").write_text(scene)
    text = experiment % (tasks or place / "tasks", grace, limit, json.dumps(list(set_up)), json.dumps(list(options)))
    for i, height in enumerate((0.101, 0.099, 0.1)):
        (place / f"r{i}.csv").write_text("time_s,top_m\n" + "".join(f"{t},{height - 0.1 * t}\n" for t in (0, 0.1, 0.2, 0.3)))
        text += f'[[replicate]]\ncurves = "r{i}.csv"\n'
    (place / "experiment.toml").write_text(text)
    (place / "p.toml").write_text("friction_particle_particle = 0.2\n")
    return place


def start(place, executor="slurm", out="run"):
    words = [program, "evaluate", place / "experiment.toml", "--parameters", place / "p.toml", "--runs", str(runs), "--json",
             "--out", place / out, "--executor", executor]
    return subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment)


def end(process, limit=400):
    out, err = process.communicate(timeout=limit)
    return process.returncode, out, err


def rows(place, out="run"):
    with sqlite3.connect(f"file:{place / out / 'journal.db'}?mode=ro", uri=True) as journal:
        return sorted(journal.execute("SELECT fingerprint, status, message, time_step_s, hex(channels) FROM simulation"))


def command(*words):
    return subprocess.run(["bash", tool, *words, str(slurm)], env=environment, check=True, capture_output=True, text=True).stdout


def slurm_command(*words):
    return subprocess.run(words, env=environment, capture_output=True, text=True).stdout


def wait_for_tasks():
    for _ in range(600):
        if " R " in slurm_command("squeue", "-h", "-r", "-o", "x %t x"):
            return
        time.sleep(0.1)
    raise RuntimeError("no task began")


def is_as_local(place, code, err):
    if code != 0:
        return f"exit {code}: {err[-300:]}"
    if rows(place) != local:
        return "other rows than locally"
    if (place / "tasks").exists() and any((place / "tasks").rglob("*")):
        return f"left in the task folder: {[p.name for p in (place / 'tasks').rglob('*')][:5]}"
    return ""


def equal():
    place = write("equal")
    code, out, err = end(start(place))
    return is_as_local(place, code, err) or ("" if out == local_out else "another result than locally")


def node_killed():
    place = write("node_killed", set_up=["sleep 6"], grace=60)
    process = start(place)
    wait_for_tasks()
    command("kill-node", "n1")
    code, _, err = end(process)
    command("start-node", "n1")
    return is_as_local(place, code, err)


def driver_killed():
    place = write("driver_killed", set_up=["sleep 5"])
    process = start(place)
    wait_for_tasks()
    process.send_signal(signal.SIGKILL)
    process.wait()
    code, _, err = end(start(place))
    if " in job" in err:
        return "submitted again: " + err
    return is_as_local(place, code, err)


def hang():
    place = write("hang", limit=1, set_up=[f"mkdir {folder}/hang/once 2>/dev/null && sleep 1000"])
    code, _, err = end(start(place))
    return is_as_local(place, code, err) or ("" if "beside it" in err or "submitted" in err or "left" in err else "not repeated: " + err)


def small_disk(name, free_again):
    disk = folder / "disk"
    disk.mkdir(exist_ok=True)
    subprocess.run(["mount", "-t", "tmpfs", "-o", "size=1m", "none", disk], check=True)
    try:
        place = write(name, grace=5, tasks=disk, set_up=["sleep 2"])
        process = start(place)
        wait_for_tasks()
        ballast = os.open(disk / "ballast", os.O_WRONLY | os.O_CREAT)
        try:
            while True:
                os.write(ballast, b"x" * 4096)
        except OSError:
            os.close(ballast)
        if free_again:
            time.sleep(10)
            (disk / "ballast").unlink()
        return place, *end(process)
    finally:
        subprocess.run(["umount", "-l", disk], check=True)


def full_for_a_while():
    place, code, _, err = small_disk("full_for_a_while", True)
    return f"exit {code}: {err}" if code else "" if rows(place) == local else "other rows than locally"


def full_for_good():
    _, code, _, err = small_disk("full_for_good", False)
    return "" if code == 3 and "lost 3 times each" in err else f"exit {code}: {err}"


def submitted_twice():
    place = write("submitted_twice", set_up=["sleep 4"])
    process = start(place)
    wait_for_tasks()
    script = next((place / "tasks").rglob("job.sh"))
    slurm_command("sbatch", "--job-name=" + script.parent.name, "--array=0-" + str(runs - 1), "--output=/dev/null", script)
    code, _, err = end(process)
    return is_as_local(place, code, err)


def controller_killed():
    place = write("controller_killed", set_up=["sleep 8"])
    process = start(place)
    wait_for_tasks()
    command("kill-controller")
    time.sleep(8)
    command("start")
    code, _, err = end(process)
    return is_as_local(place, code, err)


def held():
    place = write("held", grace=8, options=["--hold"])
    code, _, err = end(start(place))
    # sbatch holds every try here, so that all three end without a start
    return "" if code == 3 and "JobHeldUser" in err else f"exit {code}: {err}"


def other_bits():
    place = write("other_bits", set_up=["sleep 6"])
    process = start(place)
    wait_for_tasks()
    tasks = place / "tasks"
    for key in (tasks if (tasks / "specs").exists() else next(tasks.glob("*"))).joinpath("specs").iterdir():
        (key.parent.parent / "conflict" / (key.name + ".n9.1")).write_text("other bits")
        break
    code, _, err = end(process)
    return "" if code == 3 and "gave other bits" in err else f"exit {code}: {err}"


def truncated():
    place = write("truncated", set_up=["sleep 4"])
    process = start(place)
    wait_for_tasks()
    spec = next(p for p in (place / "tasks").rglob("specs/*"))
    (spec.parent.parent / "done" / spec.name).write_text("graintruth result 0123\n{")
    code, _, err = end(process)
    return is_as_local(place, code, err) or ("" if "thrown away" in err else "taken as it was")


def without_fma():
    place = write("without_fma", set_up=['[ "$SLURMD_NODENAME" = n1 ] && export GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX2,-FMA'])
    code, _, err = end(start(place))
    return is_as_local(place, code, err) or ("refused, and right without it" if "left out" in err else "")


def two_and_eight_slots():
    results = []
    for nodes in ("n[2-4]", ""):
        place = write("slots", options=["--exclude=" + nodes] if nodes else [])
        code, out, err = end(start(place))
        if code:
            return f"exit {code}: {err}"
        results.append((out, rows(place)))
    return "" if results[0] == results[1] == (local_out, local) else "other results"


cases = [equal, node_killed, driver_killed, hang, full_for_a_while, full_for_good, submitted_twice, controller_killed, held,
         other_bits, truncated, without_fma, two_and_eight_slots]
failed = 0
command("start")
try:
    place = write("local")
    code, local_out, err = end(start(place, "threads"))
    assert code == 0, err
    local = rows(place)
    for case in cases:
        if wanted and case.__name__ not in wanted:
            continue
        began = time.time()
        try:
            trouble = case()
        except Exception as error:  # the other cases may still tell something
            trouble = f"{type(error).__name__}: {error}"
        failed += bool(trouble)
        print(f"{case.__name__:22} {'failed: ' + trouble if trouble else 'holds'}  ({time.time() - began:.0f} s)", flush=True)
finally:
    command("stop")
sys.exit(1 if failed else 0)
