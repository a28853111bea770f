"""Checks against independent references, comparisons of runs, and studies of many runs.

`validate`   every check against something outside the program: `Results`, a list of `Result`
`compare`    two histories, events aligned: a `Comparison`; `compare_all` compares several with the first
`refine`     elements, modes, steps, stiffness, tolerances, a study file, and what converges: a `StudyResult`
`predictability`  which macro-collisions depend on the initial angle beyond measurement: a `Predictability`
`periodic_response`  steady state on a shaken base: a history of one period
`fit`        keys of a scenario from measured data: a `FitResult`
`reproduce`  the paper's figures and claims: a `Reproduction`
`quantity_table`  what studies measure: names, units, meanings
`sweep`      a scenario over axes of its keys (`SweepFile`): a `SweepResult`
"""

from oblique_impact.validation.comparison import Comparison as Comparison
from oblique_impact.validation.comparison import compare as compare
from oblique_impact.validation.comparison import compare_all as compare_all
from oblique_impact.validation.comparison import save_comparison as save_comparison
from oblique_impact.validation.paper.command import Reproduction as Reproduction
from oblique_impact.validation.paper.command import reproduce as reproduce
from oblique_impact.validation.studies.design import AxisSection as AxisSection
from oblique_impact.validation.studies.design import HypercubeSection as HypercubeSection
from oblique_impact.validation.studies.design import SweepFile as SweepFile
from oblique_impact.validation.studies.design import TableSection as TableSection
from oblique_impact.validation.studies.fitting.fit import FitResult as FitResult
from oblique_impact.validation.studies.fitting.fit import fit as fit
from oblique_impact.validation.studies.periodic import PeriodicSection as PeriodicSection
from oblique_impact.validation.studies.periodic import periodic_response as periodic_response
from oblique_impact.validation.studies.predictability import Predictability as Predictability
from oblique_impact.validation.studies.predictability import predictability as predictability
from oblique_impact.validation.studies.quantities import quantity_table as quantity_table
from oblique_impact.validation.studies.refinement import StudyResult as StudyResult
from oblique_impact.validation.studies.refinement import refine as refine
from oblique_impact.validation.studies.sweep import SweepResult as SweepResult
from oblique_impact.validation.studies.sweep import sweep as sweep
from oblique_impact.validation.suite import Result as Result
from oblique_impact.validation.suite import Results as Results
from oblique_impact.validation.suite import validate as validate
