"""The exact beam as a solver of cosseratbench, a public benchmark of rod solvers, found by its entry point.

    pip install cosseratbench
    cosseratbench run cantilever catenary pendulum --solver oblique-impact

It takes plane cases: one rod, held at its first end, free or held at its last, under gravity and dead loads at its
ends, without obstacles.  Others it refuses, which the benchmark reports as unsupported.
"""

from __future__ import annotations

from importlib.metadata import version
from math import ceil
from typing import Any

import numpy as np
from cosseratbench import Capability, Scenario, Trajectory
from cosseratbench.scenario import End, EndCondition, Rod
from cosseratbench.solver import Diverged
from scipy.interpolate import CubicSpline
from scipy.linalg import LinAlgError

from oblique_impact.fem_beam.exact.beam import NODE, ExactBeam, Stage, solve
from oblique_impact.fem_beam.exact.sections import Array, ElasticSections, shear_correction
from oblique_impact.fem_beam.exact.step import CONVERGED, NotConvergedError, advance

#: unknowns that an end holds: x, y, phi
_HELD = {EndCondition.FREE: 0, EndCondition.PINNED: 2, EndCondition.CLAMPED: 3}
#: of a step times the slowest frequency: its error of a period is a twelfth of the square
_STEP = 0.004
#: a third direction, over the other two, in which a case is not plane
_PLANE = 1e-9
#: times the slowest frequency: how stiffly inertia holds the first iteration of an equilibrium; iterations at most
_STIFFEST, _MOST_ITERATIONS = 100.0, 100


class ExactBeamSolver:
    """The interface of the benchmark: see `cosseratbench.solver.Solver`.

    `time_step_scale` multiplies the step; equilibria have none.
    """

    name = "oblique-impact"
    backend_version = version("oblique-impact")
    capabilities = frozenset({Capability.STRETCH, Capability.SHEAR})

    def __init__(self, time_step_scale: float = 1.0) -> None:
        self.time_step_scale = time_step_scale

    def settings(self, scenario: Scenario, *, n_elements: int, n_frames: int) -> dict[str, Any]:
        """Return the choices of a run."""
        elements = "quadratic elements of a geometrically exact plane beam"
        if scenario.quasi_static:
            return {"elements": elements, "method": "equilibrium by Newton's method, in all frames but the first"}
        between, count = self._steps(scenario, n_frames)
        return {"elements": elements, "method": "energy-consistent mid-point rule", "time_step": between / count}

    def run(self, scenario: Scenario, *, n_elements: int, n_frames: int) -> Trajectory:
        """March a case, or find its equilibrium where that is what it asks for.

        Raises NotImplementedError, by which the benchmark knows an unsupported case, for one that is not of this
        kind, and Diverged where iterations do not converge.
        """
        if len(scenario.rods) > 1 or scenario.obstacles:
            raise NotImplementedError("several rods, or obstacles")
        rod = scenario.rods[0]
        first, last = (_HELD[rod.condition(end)] for end in (End.START, End.END))
        if first == 0 or rod.start_motion or rod.end_motion or (last and not scenario.quasi_static):
            raise NotImplementedError("a free first end, an end that is moved, or motion with both ends held")
        basis, beam = _plane_of(scenario), _beam_of(rod, n_elements)
        load = beam.M @ np.tile([*(basis[:2] @ scenario.gravity), 0.0], beam.x.size)
        for force in rod.loads:
            if force.at is End.END:  # the first end is held
                load[-NODE:-1] += basis[:2] @ force.force
        place = rod.nodes(2 * n_elements) @ basis.T
        axis = place[:, 0] + 1j * place[:, 1]
        rotation = np.unwrap(np.angle(CubicSpline(beam.x, axis)(beam.x, 1)))
        q = np.stack([axis.real, axis.imag, rotation], axis=1).ravel()
        frames = [q]
        if scenario.quasi_static:
            frames += (n_frames - 1) * [_equilibrium(beam, q, load, first, last, scenario.slowest_frequency())]
        else:
            between, count = self._steps(scenario, n_frames)
            stage = Stage(q, np.zeros_like(q))
            for frame in range(1, n_frames):
                try:
                    for _ in range(count):
                        stage = advance(beam, stage, between / count, load, held=q[:first]).stage
                except NotConvergedError as error:
                    raise Diverged(str(error), frame * between) from error
                frames.append(stage.q)
        return _trajectory(np.array(frames), rod, basis, place[0, 2], scenario.duration)

    def _steps(self, scenario: Scenario, n_frames: int) -> tuple[float, int]:
        """Return the time (s) between frames, and into how many steps it is divided."""
        between = scenario.duration / (n_frames - 1)
        return between, ceil(between * scenario.slowest_frequency() / (_STEP * self.time_step_scale))


def _plane_of(scenario: Scenario) -> Array:
    """Return unit vectors (3, 3): two in the plane of rod, gravity and loads, and its normal."""
    rod = scenario.rods[0]
    line = np.asarray(rod.centerline) - rod.centerline[0]
    forces = [np.asarray(one) for one in (scenario.gravity, *(load.force for load in rod.loads)) if any(one)]
    directions = [*line / np.abs(line).max(), *(force / np.linalg.norm(force) for force in forces)]
    _, sizes, basis = np.linalg.svd(np.array(directions))
    if sizes.size > 2 and sizes[2] > _PLANE * sizes[0]:
        raise NotImplementedError("motion in space")
    basis[2] = np.cross(*basis[:2])
    return np.asarray(basis)


def _beam_of(rod: Rod, elements: int) -> ExactBeam:
    """Return the beam of a rod, without stress where it is straight."""
    material, A, radius_of_gyration = rod.material, rod.area, 0.5 * rod.radius
    E, G, rho = material.youngs_modulus, material.shear_modulus, material.density
    shear, square = shear_correction(0.5 * E / G - 1.0) * G, radius_of_gyration**2
    sections = ElasticSections.uniform(E * A, shear * A, E * A * square, rho * A, rho * A * square)
    return ExactBeam(np.linspace(0.0, rod.length, elements + 1), sections)


def _equilibrium(beam: ExactBeam, q: Array, load: Array, first: int, last: int, frequency: float) -> Array:
    """Return nodal values at rest: Newton's method, with forces that hold `last` unknowns of the last node.

    A rod that nothing has tightened yet hangs loose: inertia, halved each time, keeps the first iterations near
    the start (pseudo-transient continuation, Kelley and Keyes 1998).
    """
    holds = np.zeros((beam.size, last))
    holds[range(beam.size - NODE, beam.size - NODE + last), range(last)] = 1.0
    reaction, inertia = np.zeros(last), (_STIFFEST * frequency) ** 2
    for _ in range(_MOST_ITERATIONS):
        internal = beam.static_forces(q)
        residual = load + holds @ reaction - internal.forces
        try:
            columns = np.column_stack([residual, holds])
            change, *responses = solve(internal.tangent + inertia * beam.mass_band, columns, first).T
        except LinAlgError:
            break
        if last:
            response = np.array(responses)
            more = np.linalg.solve(response @ holds, -change @ holds)
            reaction, change = reaction + more, change + more @ response
        q, inertia = q + change, 0.5 * inertia
        if np.abs(change / beam.scale).max() < CONVERGED:
            return q
    raise Diverged("no equilibrium found")


def _trajectory(frames: Array, rod: Rod, basis: Array, offset: float, duration: float) -> Trajectory:
    """Return what the benchmark measures, from nodal values (frames, 3 n)."""
    place = frames.reshape(len(frames), -1, NODE)[:, ::2]
    place = np.concatenate([place[:, :, :2], np.full((*place.shape[:2], 1), offset)], axis=2)
    along = np.diff(place, axis=1)
    along /= np.linalg.norm(along, axis=2, keepdims=True)
    across = np.stack([-along[:, :, 1], along[:, :, 0], np.zeros(along.shape[:2])], axis=2)
    # a plane motion does not twist: the director keeps its parts along the normals of the line and of the plane
    start = rod.directors(along.shape[1]) @ basis.T
    in_plane = np.sum(start * across[0], axis=1)
    directors = in_plane[:, None] * across + start * (0.0, 0.0, 1.0)
    times = np.linspace(0.0, duration, len(frames))
    return Trajectory(times, (place @ basis,), (directors @ basis,))
