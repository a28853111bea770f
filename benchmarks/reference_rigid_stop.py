"""The paper's beam with Kelvin-Voigt damping on a rigid stop in SciPy alone: the limit, by a tip without inertia.

    python benchmarks/reference_rigid_stop.py                  24 modes, 1e-5 s of damping, to 1 s
    python benchmarks/reference_rigid_stop.py --modes 16,32    that many mean-axis modes

The beam is that of `reference_impact.py`, without friction.  The modes that are left out are a spring and a
dashpot behind the tip, which itself has no inertia: the stop pushes with (d + eta d')/kappa while that is
positive, d the depth of the tip as the modes have it.  Nothing of the suite is used.  It takes minutes.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass

import numpy as np
from reference_impact import BENDING, SLOPE, START, TOUCH, Beam
from scipy.integrate import solve_ivp

COLLISION = 0.033  # s; contacts further apart belong to different macro-collisions
AFTER_FIRST = 0.335  # s


@dataclass
class DampedBeam(Beam):
    """The beam on mean-axis modes with a tip without inertia; states y = (theta, B, theta', B', impulse)."""

    mean_axis: bool = True
    viscosity: float = 1e-5  # s
    compliance: float = 0.0  # m/N along the normal, from the touch to the end of a contact

    @property
    def left_out(self) -> float:
        """Static compliance (m/N) of the tip beyond the modes: 2 L^3/(105 EI) is that of all of them."""
        o = self.integrals
        return float(2.0 / (105.0 * BENDING) - o["tip"] @ np.linalg.solve(o["K"], o["tip"]))

    def mass_and_force(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return M and Q with the damping."""
        M, Q = super().mass_and_force(y)
        Q[1:] -= self.viscosity * self.integrals["K"] @ y[self.modes + 2 : 2 * self.modes + 2]
        return M, Q

    def push(self, y: np.ndarray) -> float:
        """Return the force (N) of the stop; negative where it does not push."""
        r = self.contact(y)
        return -(r.gap + self.viscosity * float(r.rates[0])) / self.compliance

    def march(self, end: float) -> np.ndarray:
        """March from rest to `end` (s); fills `events`; returns the state at the end of the first collision."""
        n = self.modes
        y, t, kind, first = np.zeros(2 * n + 3), 0.0, "free", np.zeros(0)
        y[0] = START
        fastest = np.sqrt(np.linalg.eigvals(np.linalg.solve(self.integrals["M1"], self.integrals["K"])).real.max())

        def rate(_: float, y: np.ndarray) -> np.ndarray:
            M, Q = self.mass_and_force(y)
            force = self.push(y) if kind == "pushing" else 0.0
            if force:
                Q = Q + self.contact(y).rows[0] * force
            return np.concatenate([y[n + 1 : 2 * n + 2], np.linalg.solve(M, Q), [force]])

        def gap(_: float, y: np.ndarray) -> float:
            return self.contact(y).gap

        def push(_: float, y: np.ndarray) -> float:
            return self.push(y)

        while t < end:
            # free: until the gap closes; pushing: until the force is gone; open: below the stop without a force
            functions = {"free": [(gap, -1.0)], "pushing": [(push, -1.0)], "open": [(gap, 1.0), (push, 1.0)]}[kind]
            for function, direction in functions:
                function.terminal, function.direction = True, direction  # type: ignore[attr-defined]
            stop = min([e for e in (TOUCH, AFTER_FIRST, end) if e > t])
            step = np.inf if t < TOUCH else 0.25 / fastest
            watched = [function for function, _ in functions]
            found = solve_ivp(rate, (t, stop), y, "DOP853", events=watched, rtol=1e-11, atol=1e-13, max_step=step)
            t, y, fallen = float(found.t[-1]), found.y[:, -1], [times.size > 0 for times in found.t_events]
            if t == AFTER_FIRST:
                first = y.copy()
            if not any(fallen):
                continue
            if kind == "free":
                self.compliance = self.left_out * float(np.cos(y[0] - SLOPE)) ** 2
                self.events.append(("touch", t))
                kind = "pushing"
            elif kind == "pushing":
                kind = "open"
            elif fallen[0]:
                self.events.append(("release", t))
                kind = "free"
            else:
                kind = "pushing"
        return first


def collisions(events: list[tuple[str, float]]) -> list[list[float]]:
    """Group the touches and releases into macro-collisions."""
    groups: list[list[float]] = []
    for _, time in events:
        if groups and time - groups[-1][-1] < COLLISION:
            groups[-1].append(time)
        else:
            groups.append([time])
    return groups


def main() -> None:
    """Print the numbers."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--modes", default="24", help="numbers of mean-axis modes, separated by commas")
    parser.add_argument("--end", type=float, default=1.0, help="s")
    given = parser.parse_args()
    for modes in map(int, given.modes.split(",")):
        beam = DampedBeam(modes)
        first = beam.march(given.end)
        print(f"{modes} modes: impulse {first[-1]:.7f} N s, energy at {AFTER_FIRST} s {beam.energy(first):.6f} J")
        for times in collisions(beam.events):
            print("  " + " ".join(f"{time:.7f}" for time in times), flush=True)


if __name__ == "__main__":
    main()
