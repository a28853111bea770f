"""The keys of a scenario: sections in SI units, each key with its unit, range and default."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from oblique_impact.scenario.section import Section
from oblique_impact.scenario.tables import Parameters, Tabulated
from oblique_impact.scenario.units import Unit
from oblique_impact.scenario.user_defined import Choice, build

MAX_MODES = 100
MAX_ELEMENTS = 4096
MAX_GRADING = 1e4
#: keys that may name a user-defined part, and their sections
PARTS = {"friction": "contact", "normal": "contact", "impact": "contact", "profile": "root", "scheme": "solver"}

Positive = Annotated[float, Field(gt=0.0, le=1e30)]
NonNegative = Annotated[float, Field(ge=0.0, le=1e30)]
Finite = Annotated[float, Field(ge=-1e30, le=1e30)]
Angle = Annotated[float, Field(ge=-2.0 * math.pi, le=2.0 * math.pi), Unit("rad")]
Pair = Annotated[tuple[Finite, Finite], Field(strict=False)]


class BeamSection(Section):
    """The beam; `area` and `second_moment` are numbers, or tables [[x, value], ...] from x = 0 to the length."""

    length: Annotated[Positive, Unit("m")] = 1.0  # length of the undeformed axis
    area: Annotated[Tabulated, Unit("m^2")] = 3.14e-4  # area of the cross-section
    second_moment: Annotated[Tabulated, Unit("m^4")] = 7.85e-9  # second moment of area of the cross-section
    density: Annotated[Positive, Unit("kg/m^3")] = 2766.7  # mass per volume
    youngs_modulus: Annotated[Positive, Unit("Pa")] = 68.952e9  # Young's modulus
    #: Kelvin-Voigt damping: the damping matrix is kelvin_voigt K
    kelvin_voigt: Annotated[NonNegative, Unit("s")] = 0.0
    #: mass-proportional damping: the damping matrix is mass_proportional M1
    mass_proportional: Annotated[NonNegative, Unit("1/s")] = 0.0
    modal_damping_ratio: Annotated[float, Field(ge=0.0, lt=1.0)] = 0.0  # damping ratio of each elastic mode
    tip_mass: Annotated[NonNegative, Unit("kg")] = 0.0  # point mass at x = length
    #: distance of the outer fibre from the axis, for the bending stress; 0: circular sections
    outer_fibre: Annotated[NonNegative, Unit("m")] = 0.0


class RootSection(Section):
    """How the beam is held at x = 0."""

    #: a frictionless pin, a hub with inertia and torque, or a root whose angle is prescribed
    kind: Literal["pin", "hub", "driven"] = "pin"
    hub_radius: Annotated[NonNegative, Unit("m")] = 0.0  # distance of the root from the axis of rotation
    inertia: Annotated[NonNegative, Unit("kg m^2")] = 0.0  # moment of inertia of the hub
    torque: Annotated[Finite, Unit("N m")] = 0.0  # torque on the hub
    #: how a driven root turns; or a user-defined base motion
    profile: Annotated[str, Choice("base_motions", ("hold", "constant-speed", "spin-up"))] = "hold"
    #: angular velocity of a driven root, the final one of a spin-up
    spin_rate: Annotated[Finite, Unit("rad/s")] = 0.0
    spin_up_time: Annotated[NonNegative, Unit("s")] = 0.0  # duration of a spin-up


class InitialSection(Section):
    """The undeformed beam at t = 0."""

    angle: Angle = math.pi / 4  # angle of the beam from the horizontal
    angular_velocity: Annotated[Finite, Unit("rad/s")] = 0.0  # angular velocity of the beam


class SlopeSection(Section):
    """The rigid slope: a line through `origin` inclined by `angle`; the free side is on its left."""

    origin: Annotated[Pair, Unit("m")] = (0.3, 0.0)  # a point of the slope, [x, y] from the axis of the root
    angle: Angle = math.pi / 10  # inclination of the slope from the horizontal
    #: where the obstacle begins and ends, [first, last] along the slope from `origin`; [] is unbounded. It is for
    #: the distance of the whole beam and for pictures: the contact of the contact point does not know of it
    extent: Annotated[tuple[Finite, ...], Unit("m"), Field(strict=False)] = ()

    @property
    def offsets(self) -> tuple[float, float]:
        """Height c_n of `origin` above the root's axis across the slope, and its place c_t along it (m)."""
        (x, y), c, s = self.origin, math.cos(self.angle), math.sin(self.angle)
        return y * c - x * s, x * c + y * s


class ContactSection(Section):
    """The contact between the beam's point `point` and the slope."""

    enabled: bool = True  # whether the slope is there at all
    #: place of the contact point along the beam; not given: the beam's length
    point: Annotated[Positive, Unit("m")] = math.nan
    #: a rigid stop, an elastic one, or a user-defined contact law
    normal: Annotated[str, Choice("contact_laws", ("rigid", "spring"))] = "rigid"
    stiffness: Annotated[Positive, Unit("N/m")] = 1e6  # stiffness of an elastic stop
    #: Hunt-Crossley damping of an elastic stop: its force is stiffness d (1 + damping d') at the depth d
    damping: Annotated[NonNegative, Unit("s/m")] = 0.0
    #: impact on a rigid stop: without friction (Newton), with friction mu_kinetic (Routh), or a user-defined law
    impact: Annotated[str, Choice("impact_laws", ("newton", "routh"))] = "newton"
    #: coefficient of restitution of an impact on a rigid stop, Newton's or (Routh) Poisson's
    restitution: Annotated[float, Field(ge=0.0, le=1.0)] = 0.0
    #: whether the contact point has the inertia that the discretization gives it, and meets a rigid stop by an
    #: impact, or `none`: it rests on the stop through the flexibility of what the discretization leaves out
    point_inertia: Literal["kept", "none"] = "kept"
    #: whether an elastic stop knows the static flexibility of the modes that are left out
    residual_flexibility: bool = True
    shortening: bool = True  # whether gap and slip know the foreshortening of the beam up to the contact point
    #: the tangential law, or a user-defined friction law
    friction: Annotated[str, Choice("friction_laws", ("frictionless", "hybrid", "modified-coulomb"))] = "hybrid"
    mu_static: NonNegative = 0.3  # static coefficient of friction
    mu_kinetic: NonNegative = 0.3  # kinetic coefficient of friction
    #: slip velocities v0 < v1 between which the modified Coulomb law grows from nothing to its full force
    regularization: Annotated[tuple[NonNegative, NonNegative], Field(strict=False), Unit("m/s")] = (1e-3, 1e-2)


class DiscretizationSection(Section):
    """How the beam becomes a finite number of coordinates."""

    #: assumed modes (`modal`), Hermite finite elements (`fem`), or a user-defined discretization
    method: Annotated[str, Choice("discretizations")] = "modal"
    #: the floating frame: tangent to the root (clamped shapes), or the mean axis (hinged shapes), which is the
    #: default of the full nodal model
    frame: Literal["tangent", "mean-axis"] = "tangent"
    #: order of the kinetic energy in the elastic coordinates
    kinetics: Literal["zeroth-order", "first-order", "full"] = "first-order"
    #: number of modes; of finite elements: reduced to so many of their own modes, 0: the full nodal model
    modes: Annotated[int, Field(ge=0, le=MAX_MODES)] = 2
    elements: Annotated[int, Field(ge=1, le=MAX_ELEMENTS)] = 32  # number of finite elements
    #: a file with line elements on an axis, in any format that meshio reads (`beam.msh`), whose nodes take the
    #: place of those that follow from `elements` and `grading`
    mesh: str = ""
    #: places of the nodes, ascending from 0 to the length of the beam; none: from `elements` and `grading`
    nodes: Annotated[tuple[NonNegative, ...], Field(strict=False, max_length=MAX_ELEMENTS + 1), Unit("m")] = ()
    #: largest over smallest element of a mesh that is graded towards the contact point
    grading: Annotated[float, Field(ge=1.0, le=MAX_GRADING)] = 1.0

    @model_validator(mode="before")
    @classmethod
    def _count_elements(cls, data: Any) -> Any:
        """Without a number of elements it is that of the nodes."""
        nodes = data.get("nodes") if isinstance(data, dict) else None
        return {"elements": len(nodes) - 1} | data if isinstance(nodes, list | tuple) and len(nodes) > 1 else data


class SolverSection(Section):
    """How time is marched."""

    #: adaptive with located events, the paper's fixed steps, implicit generalized-alpha (the default of the full
    #: nodal model), or a user-defined one
    scheme: Annotated[str, Choice("integrators", ("event", "fixed-step", "generalized-alpha"))] = "event"
    #: relative tolerance of a step (event), of the iterations (generalized-alpha)
    tolerance: Annotated[float, Field(ge=1e-13, le=1e-3)] = 1e-10
    free_step: Annotated[Positive, Unit("s")] = 1e-4  # step in flight (fixed-step, generalized-alpha)
    contact_step: Annotated[Positive, Unit("s")] = 1e-6  # step in contact (fixed-step, generalized-alpha)
    #: spectral radius of generalized-alpha at infinite frequency
    rho_infinity: Annotated[float, Field(ge=0.0, le=1.0)] = 0.8
    #: Baumgarte's parameters [chi, beta] of the contact constraints
    baumgarte: Annotated[tuple[NonNegative, NonNegative], Field(strict=False), Unit("1/s")] = (10.0, 1000.0)
    #: how they are read, "squared": Z'' + 2 chi Z' + beta^2 Z = 0; "plain": Z'' + chi Z' + beta Z = 0
    baumgarte_form: Literal["squared", "plain"] = "squared"
    #: fixed-step: contact sticks where the force that holds it lies in the friction cone and can stop the slip
    #: within a step (`arrest`), or where it lies in the cone whatever the slip velocity is (`force`, as the paper)
    stick: Literal["arrest", "force"] = "arrest"
    #: interval of the samples; events are always kept exactly
    output_interval: Annotated[Positive, Unit("s")] = 1e-4


class ParametersSection(Section):
    """Numbers of user-defined parts, installed or registered; the built-in ones have keys."""

    friction: Parameters = ()  # of the friction law that contact.friction names
    normal: Parameters = ()  # of the contact law that contact.normal names
    impact: Parameters = ()  # of the impact law that contact.impact names
    profile: Parameters = ()  # of the base motion that root.profile names
    scheme: Parameters = ()  # of the integrator that solver.scheme names


class ScenarioKeys(Section):
    """All keys of a scenario, and what follows from them alone."""

    end_time: Annotated[Positive, Unit("s")] = 1.0  # duration of the run
    gravity: Annotated[float, Field(ge=0.0, le=1e6), Unit("m/s^2")] = 9.8  # acceleration of gravity, downwards
    beam: BeamSection = BeamSection()
    root: RootSection = RootSection()
    initial: InitialSection = InitialSection()
    slope: SlopeSection = SlopeSection()
    contact: ContactSection = ContactSection()
    discretization: DiscretizationSection = DiscretizationSection()
    solver: SolverSection = SolverSection()
    parameters: ParametersSection = ParametersSection()

    @property
    def is_nodal(self) -> bool:
        """Whether the full nodal model is marched: finite elements, nothing reduced."""
        return self.discretization.method == "fem" and self.discretization.modes == 0

    @property
    def initial_gap(self) -> float:
        """Gap of the undeformed beam at t = 0 (m)."""
        reach = self.root.hub_radius + self.contact.point
        return reach * math.sin(self.initial.angle - self.slope.angle) - self.slope.offsets[0]

    @property
    def initial_angular_velocity(self) -> float:
        """Angular velocity of the root at t = 0 (rad/s)."""
        if self.root.kind == "driven":
            motion = self.part("profile")
            if motion is not None:
                return float(motion.at(0.0).speed)
            return self.root.spin_rate if self.root.profile == "constant-speed" else 0.0
        return self.initial.angular_velocity

    def part(self, key: str) -> Any:
        """Build the user-defined part that `friction`, `normal`, `impact`, `profile` or `scheme` names.

        Returns None for a built-in one.  Raises InputError if it does not take its numbers.
        """
        section = getattr(self, PARTS[key])
        field = type(section).model_fields[key]
        choice = next(entry for entry in field.metadata if isinstance(entry, Choice))
        name = getattr(section, key)
        if name in choice.built_in:
            return None
        before = (self.solver,) if key == "scheme" else ()
        return build(choice.kind, name, dict(getattr(self.parameters, key)), *before)
