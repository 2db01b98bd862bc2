#!/usr/bin/env python3
"""A simulator in ten lines: a ball rolls down a plane of 20 degrees against rolling friction.
s = 1/2 a t^2,  a = 5/7 g (sin(slope) - mu_r cos(slope));  called with spec.json and recording.json by graintruth."""
import json, math, random, sys

spec = json.load(open(sys.argv[1]))
rolling_friction = spec["parameters"]["rolling_friction_particle_wall"]
slope, gravity = math.radians(20), -spec["scene"]["gravity_m_per_s2"][2]
faster = random.Random(spec["seed"]).gauss(1.0, 0.001)  # no two rolls are the same
acceleration = 5 / 7 * gravity * (math.sin(slope) - rolling_friction * math.cos(slope)) * faster
time = [0.1 * i for i in range(11)]
way = {"time_s": time, "value": [0.5 * acceleration * t * t for t in time], "sigma": []}
json.dump({"version": "1", "recording": {"curves": {"way_m": way}}}, open(sys.argv[2], "w"))
