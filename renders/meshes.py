"""The beam at a time as a mesh of PyVista with its results, as `History.to_pyvista` returns it."""

from __future__ import annotations

import numpy as np
import pyvista as pv

from oblique_impact.history.history import History, require_history
from oblique_impact.renders.geometry import QUANTITIES, BeamGeometry
from oblique_impact.renders.metadata import made_by


def beam_mesh(history: History, time: float, deformation: float = 1.0) -> pv.PolyData:
    """Return the surface of the beam at a time (s), at a jump just after it, with its results as point arrays.

    Parameters
    ----------
    history : History
        Of a beam.
    time : float
        Physical time (s) within the run.
    deformation : float
        Factor by which the bending is magnified; 1 for the true shape.  The results are never magnified.

    Returns
    -------
    pyvista.PolyData
        Points in m; point arrays as in `renders.geometry.QUANTITIES`, in SI units; field data `time` (s),
        `units` and `made_by`.

    Raises
    ------
    InputError
        For a system that is no beam, a time outside of the run, or a factor that is not positive.
    """
    require_history(history, "to_pyvista")
    geometry = BeamGeometry(history, deformation)
    history.at(time)  # which refuses times outside of the run
    mesh = surface_mesh(geometry, geometry.index(time))
    mesh.set_active_scalars("bending_stress")
    mesh.field_data["time"] = np.array([time])
    mesh.field_data["units"] = ["points = m", *(f"{name} = {unit}" for name, unit in QUANTITIES.items())]
    mesh.field_data["made_by"] = [made_by([history])]
    return mesh


def surface_mesh(geometry: BeamGeometry, k: float) -> pv.PolyData:
    """Return the surface of the beam at sample k with the results `renders.geometry.QUANTITIES`."""
    mesh = pv.PolyData(geometry.tube(k)[0], geometry.solid.faces)
    for name in QUANTITIES:
        mesh.point_data[name] = geometry.result(name, k)
    return mesh
