#!/usr/bin/env bash
# MuJoCo's noslip solver stops the creep of a body at rest on pyramidal friction cones, the default, up to exactly
# half of the friction coefficient; beyond it does nothing at all, however many iterations it is given.
#
# Guess before: friction is regularized, so that a body creeps (the documentation says so, and recommends elliptic
# cones, a larger impratio, or noslip_iterations against it); the noslip solver drops the regularization, so that any
# load inside of the cone or pyramid is held.
#
# Seen (MuJoCo 4.0.0): a load along an axis of the pyramid of 0.49 times friction is held to rounding, of 0.51 times
# friction creeps as fast, to six digits, as without noslip: with friction of 0.2, 0.5 and 2, with 10 and with 1000
# iterations.  On elliptic cones noslip holds 0.95.  What fits: each of the two pairs of opposite edges keeps its sum of
# forces, half of the normal force while the body creeps, and only the difference within a pair is solved for.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check mujoco==4.0.0 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PY'
from math import atan, cos, sin

import mujoco

SLIDES = "".join(f"<joint type='slide' axis='{axis}'/>" for axis in ("1 0 0", "0 1 0", "0 0 1"))


def creep(friction, load, iterations, cone="pyramidal"):
    """Metres in the second second on a slope whose tangent is load times friction."""
    angle = atan(load * friction)
    model = mujoco.MjModel.from_xml_string(f"""<mujoco>
        <option gravity='{9.81 * sin(angle)} 0 {-9.81 * cos(angle)}' cone='{cone}' noslip_iterations='{iterations}'
            noslip_tolerance='0'/>
        <worldbody><geom type='plane' size='1 1 1' friction='{friction}'/>
        <body pos='0 0 0.1'>{SLIDES}<geom size='0.1' mass='1' friction='{friction}'/></body></worldbody></mujoco>""")
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 500)
    start = data.qpos[0]
    mujoco.mj_step(model, data, 500)
    return data.qpos[0] - start


for friction in (0.2, 0.5, 2.0):
    for load in (0.49, 0.51):
        free, few, many = (creep(friction, load, iterations) for iterations in (0, 10, 1000))
        print(f"MuJoCo {mujoco.__version__}, friction {friction}, load {load} of it: creeps {1e3 * free:.4f} mm/s, "
              f"with 10 noslip iterations {1e3 * few:.4f}, with 1000 {1e3 * many:.4f}")
        assert free > 5e-4, "no creep without noslip"
        if load < 0.5:
            assert max(abs(few), abs(many)) < 1e-12, "below a half creep was stopped"
        else:
            assert max(abs(few - free), abs(many - free)) < 1e-6 * free, "above a half noslip changed nothing"
held = creep(0.5, 0.95, 10, "elliptic")
print(f"elliptic cones, friction 0.5, load 0.95 of it, 10 noslip iterations: {1e3 * held:.4f} mm/s")
assert abs(held) < 1e-12, "elliptic cones held 0.95"
PY
