"""Checks against independent references, comparisons of runs, and studies of many runs.

`validate`   every check against something outside the program
`compare`    histories with the first of them, events aligned
`refine`     elements, modes, steps, stiffness, tolerances, a study file, and what converges
`predictability`  which macro-collisions depend on the initial angle beyond measurement
`periodic_response`  steady state on a shaken base
`fit`        keys of a scenario from measured data
`reproduce`  the paper's figures and claims
`sweep`      a scenario over axes of its keys (`SweepFile`)
`quantity_table`  what studies measure: names, units, meanings

Each but the last returns a `Result`: a frame with a verdict for each row, and pictures.
"""

from oblique_impact.validation.comparison import compare as compare
from oblique_impact.validation.paper.command import reproduce as reproduce
from oblique_impact.validation.result import Result as Result
from oblique_impact.validation.studies.design import AxisSection as AxisSection
from oblique_impact.validation.studies.design import HypercubeSection as HypercubeSection
from oblique_impact.validation.studies.design import SweepFile as SweepFile
from oblique_impact.validation.studies.design import TableSection as TableSection
from oblique_impact.validation.studies.fitting.fit import fit as fit
from oblique_impact.validation.studies.periodic import PeriodicSection as PeriodicSection
from oblique_impact.validation.studies.periodic import periodic_response as periodic_response
from oblique_impact.validation.studies.predictability import predictability as predictability
from oblique_impact.validation.studies.quantities import quantity_table as quantity_table
from oblique_impact.validation.studies.refinement import refine as refine
from oblique_impact.validation.studies.sweep import sweep as sweep
from oblique_impact.validation.suite import validate as validate
