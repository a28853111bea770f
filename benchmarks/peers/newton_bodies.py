"""One body over the ground in Newton, on the processor."""

from __future__ import annotations

import logging
import warnings
from collections.abc import Iterator
from itertools import count
from typing import Any

import numpy as np


def _load() -> Any:
    import warp

    warp.config.quiet = True
    warnings.filterwarnings("ignore", module="newton|peers")
    logging.getLogger("newton").setLevel(logging.ERROR)
    import newton

    return newton


class Body:
    """A box of 0.4 x 0.4 x 0.2 m, or a sphere of 0.1 m, with its middle at a height (m)."""

    def __init__(
        self,
        *,
        friction: tuple[float, float] = (0.0, 0.0),
        restitution: tuple[float, float] = (0.0, 0.0),
        gravity: tuple[float, float, float] = (0.0, 0.0, 0.0),
        height: float,
        sphere: bool = False,
        mass: float = 0.0,
    ) -> None:
        self.newton = _load()
        builder = self.newton.ModelBuilder(gravity=gravity)
        block, ground = (
            self.newton.ModelBuilder.ShapeConfig(mu=mu, restitution=e)
            for mu, e in zip(friction, restitution, strict=True)
        )
        builder.add_ground_plane(cfg=ground)
        body = builder.add_body(xform=((0.0, 0.0, height), (0.0, 0.0, 0.0, 1.0)), mass=mass)
        if sphere:
            builder.add_shape_sphere(body, radius=0.1, cfg=block)
        else:
            builder.add_shape_box(body, hx=0.2, hy=0.2, hz=0.1, cfg=block)
        self.model = builder.finalize(device="cpu")

    def velocities(
        self, solver: str, step: float, settling: int, velocity: list[float], **options: Any
    ) -> Iterator[np.ndarray]:
        """Yield the velocity (m/s) step (s) by step: after some for settling it is set once."""
        model = self.model
        marching = getattr(self.newton.solvers, solver)(model, **options)
        now, then, control, contacts = model.state(), model.state(), model.control(), model.contacts()
        for k in count(-settling):
            if k == 0:
                motion = np.array([*velocity, 0.0, 0.0, 0.0], dtype=np.float32)
                now.body_qd.assign(motion[np.newaxis])
                now.joint_qd.assign(motion)
            now.clear_forces()
            model.collide(now, contacts)
            marching.step(now, then, control, contacts, step)
            now, then = then, now
            if k >= 0:
                yield now.body_qd.numpy()[0, :3].copy()
