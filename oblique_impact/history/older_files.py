"""Histories of earlier versions, brought into the form of this one."""

from __future__ import annotations

import json
from typing import Final

import numpy as np
import xarray as xr

from oblique_impact.history.events import EVENT_COLUMNS
from oblique_impact.history.samples import contact_variables
from oblique_impact.history.variables import dataset
from oblique_impact.scenario.scenario import Scenario

#: in which every file holds what later ones compute
FORMAT_OF_WHOLE_FILES: Final = "oblique-impact history 3"
#: in which a single contact has no dimension `contact`, and its events neither obstacle nor place
FORMAT_WITHOUT_CONTACTS: Final = "oblique-impact history 2"
#: variables over time alone that are those of a single contact
_OF_ONE = ("gap", "slip", "slip_rate", "lambda_n", "lambda_tau", "state")


def with_contacts(data: xr.Dataset) -> xr.Dataset:
    """Return a file's dataset of `FORMAT_WITHOUT_CONTACTS` with the variables of its contacts, and whole events.

    Raises errors of many kinds for parts missing or damaged.
    """
    written = data.attrs["scenario"]
    scenario = Scenario.from_toml(written) if written else None
    place = scenario.contact.point if scenario else 0.0
    if "contact_state" not in data:
        added = {f"contact_{name}": data[name].values[:, None] for name in _OF_ONE}
        if scenario:
            x, y, tangential, normal = (data[name].values for name in ("tip_x", "tip_y", "lambda_tau", "lambda_n"))
            force = np.exp(1j * scenario.slope.angle) * (tangential + 1j * normal)
            added |= contact_variables([0], np.full((x.size, 1), place), (x + 1j * y)[:, None], force[:, None])
            if "clearance" in data:
                added["clearance_obstacle"] = np.zeros(x.size, dtype=int)
        data = data.assign(dataset(added))
    rows = json.loads(data.attrs["events"])
    events = [row if len(row) == len(EVENT_COLUMNS) else [*row, 0, place] for row in rows]
    return data.assign_attrs(events=json.dumps(events))
