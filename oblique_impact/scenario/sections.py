"""The keys of a scenario: sections in SI units, each key with its unit, range, default and meaning, as data."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from oblique_impact.scenario.section import Section, key
from oblique_impact.scenario.shapes import fibre_distance
from oblique_impact.scenario.tables import LARGEST, Parameters, Size, Tabulated
from oblique_impact.scenario.units import Unit
from oblique_impact.scenario.user_defined import Choice, build

MAX_MODES = 100
MAX_ELEMENTS = 4096
MAX_GRADING = 1e4
#: keys that may name a user-defined part, and their sections
PARTS = {"friction": "contact", "normal": "contact", "impact": "contact", "profile": "root", "scheme": "solver"}
#: built-in schemes; the last is that of absolute coordinates, and of nothing else
SCHEMES = ("event", "fixed-step", "generalized-alpha", "energy-consistent")

Positive = Annotated[float, Field(gt=0.0, le=LARGEST)]
NonNegative = Annotated[float, Field(ge=0.0, le=LARGEST)]
Finite = Annotated[float, Field(ge=-LARGEST, le=LARGEST)]
Angle = Annotated[float, Field(ge=-2.0 * math.pi, le=2.0 * math.pi), Unit("rad")]
Pair = Annotated[tuple[Finite, Finite], Field(strict=False)]


class CrossSection(Section):
    """The cross-section by its shape; sizes are numbers, or tables [[x, value], ...] from x = 0 to the length."""

    shape: Literal["", "rectangle", "circle", "tube", "i-beam"] = key(
        "", "shape of the cross-section, of which area, second moment and outer fibre follow; none: they are given"
    )
    width: Annotated[Size, Unit("m")] = key(0.0, "size across the plane of motion (rectangle, i-beam)")
    height: Annotated[Size, Unit("m")] = key(0.0, "size in the plane of motion (rectangle, i-beam)")
    diameter: Annotated[Size, Unit("m")] = key(0.0, "outer diameter (circle, tube)")
    thickness: Annotated[Size, Unit("m")] = key(0.0, "thickness of the wall (tube)")
    flange_thickness: Annotated[Size, Unit("m")] = key(0.0, "thickness of each of the two flanges (i-beam)")
    web_thickness: Annotated[Size, Unit("m")] = key(0.0, "thickness of the web (i-beam)")


class BeamSection(Section):
    """The beam; `area` and `second_moment` are numbers, or tables [[x, value], ...] from x = 0 to the length."""

    length: Annotated[Positive, Unit("m")] = key(1.0, "length of the undeformed axis")
    area: Annotated[Tabulated, Unit("m^2")] = key(3.14e-4, "area of the cross-section")
    second_moment: Annotated[Tabulated, Unit("m^4")] = key(7.85e-9, "second moment of area of the cross-section")
    density: Annotated[Positive, Unit("kg/m^3")] = key(2766.7, "mass per volume")
    youngs_modulus: Annotated[Positive, Unit("Pa")] = key(68.952e9, "Young's modulus")
    material: Literal["", "steel", "stainless-steel", "aluminium", "titanium", "brass", "copper"] = key(
        "", "a material by its name, which gives density and Young's modulus; none: they are given"
    )
    kelvin_voigt: Annotated[NonNegative, Unit("s")] = key(
        0.0, "Kelvin-Voigt damping: the damping matrix is kelvin_voigt K"
    )
    mass_proportional: Annotated[NonNegative, Unit("1/s")] = key(
        0.0, "mass-proportional damping: the damping matrix is mass_proportional M1"
    )
    modal_damping_ratio: Annotated[float, Field(ge=0.0, lt=1.0)] = key(0.0, "damping ratio of each elastic mode")
    tip_mass: Annotated[NonNegative, Unit("kg")] = key(0.0, "point mass at x = length")
    outer_fibre: Annotated[Size, Unit("m")] = key(
        0.0, "distance of the outer fibre from the axis, for the bending stress; 0: circular sections"
    )
    section: CrossSection = CrossSection()


class RootSection(Section):
    """How the beam is held at x = 0."""

    kind: Literal["pin", "hub", "driven"] = key(
        "pin", "a frictionless pin, a hub with inertia and torque, or a root whose angle is prescribed"
    )
    hub_radius: Annotated[NonNegative, Unit("m")] = key(0.0, "distance of the root from the axis of rotation")
    inertia: Annotated[NonNegative, Unit("kg m^2")] = key(0.0, "moment of inertia of the hub")
    torque: Annotated[Finite, Unit("N m")] = key(0.0, "torque on the hub")
    profile: Annotated[str, Choice("base_motions", ("hold", "constant-speed", "spin-up"))] = key(
        "hold", "how a driven root turns; or a user-defined base motion"
    )
    spin_rate: Annotated[Finite, Unit("rad/s")] = key(
        0.0, "angular velocity of a driven root, the final one of a spin-up"
    )
    spin_up_time: Annotated[NonNegative, Unit("s")] = key(0.0, "duration of a spin-up")


class InitialSection(Section):
    """The undeformed beam at t = 0."""

    angle: Angle = key(math.pi / 4, "angle of the beam from the horizontal")
    angular_velocity: Annotated[Finite, Unit("rad/s")] = key(0.0, "angular velocity of the beam")


class SlopeSection(Section):
    """The rigid slope: a line through `origin` inclined by `angle`; the free side is on its left."""

    origin: Annotated[Pair, Unit("m")] = key((0.3, 0.0), "a point of the slope, [x, y] from the axis of the root")
    angle: Angle = key(math.pi / 10, "inclination of the slope from the horizontal")
    extent: Annotated[tuple[Finite, ...], Unit("m"), Field(strict=False)] = key(
        (),
        "where the slope begins and ends, [first, last] along it from `origin`; [] is unbounded. Contact ends "
        "where the contact point slides beyond an end, and beyond it the point falls past the slope",
    )

    @property
    def offsets(self) -> tuple[float, float]:
        """Height c_n of `origin` above the root's axis across the slope, and its place c_t along it (m)."""
        (x, y), c, s = self.origin, math.cos(self.angle), math.sin(self.angle)
        return y * c - x * s, x * c + y * s


class ContactSection(Section):
    """The contact between the beam's point `point` and the slope."""

    enabled: bool = key(True, "whether the slope is there at all")
    point: Annotated[Positive, Unit("m")] = key(
        math.nan, "place of the contact point along the beam; not given: the beam's length"
    )
    surface: Literal["axis", "section"] = key(
        "axis",
        "where in the section at `point` the beam touches: at its axis, so that a slope is drawn half the beam's "
        "depth below its place, or at its outer fibre on the side of the slope",
    )
    normal: Annotated[str, Choice("contact_laws", ("rigid", "spring"))] = key(
        "rigid", "a rigid stop, an elastic one, or a user-defined contact law"
    )
    stiffness: Annotated[Positive, Unit("N/m")] = key(1e6, "stiffness of an elastic stop")
    damping: Annotated[NonNegative, Unit("s/m")] = key(
        0.0, "Hunt-Crossley damping of an elastic stop: its force is stiffness d (1 + damping d') at the depth d"
    )
    impact: Annotated[str, Choice("impact_laws", ("newton", "routh"))] = key(
        "newton",
        "impact on a rigid stop: without friction (Newton), with friction mu_kinetic (Routh), or a "
        "user-defined law",
    )
    restitution: Annotated[float, Field(ge=0.0, le=1.0)] = key(
        0.0, "coefficient of restitution of an impact on a rigid stop, Newton's or (Routh) Poisson's"
    )
    point_inertia: Literal["kept", "none"] = key(
        "kept",
        "whether the contact point has the inertia that the discretization gives it, and meets a rigid stop by "
        "an impact, or `none`: it rests on the stop through the flexibility of what the discretization leaves out",
    )
    residual_flexibility: bool = key(
        True, "whether an elastic stop knows the static flexibility of the modes that are left out"
    )
    shortening: bool = key(
        True, "whether gap and slip know the foreshortening of the beam up to the contact point"
    )
    friction: Annotated[str, Choice("friction_laws", ("frictionless", "hybrid", "modified-coulomb"))] = key(
        "hybrid", "the tangential law, or a user-defined friction law"
    )
    mu_static: NonNegative = key(0.3, "static coefficient of friction")
    mu_kinetic: NonNegative = key(0.3, "kinetic coefficient of friction")
    regularization: Annotated[tuple[NonNegative, NonNegative], Field(strict=False), Unit("m/s")] = key(
        (1e-3, 1e-2),
        "slip velocities v0 < v1 between which the modified Coulomb law grows from nothing to its full force",
    )


class DiscretizationSection(Section):
    """How the beam becomes a finite number of coordinates."""

    method: Annotated[str, Choice("discretizations")] = key(
        "modal",
        "assumed modes (`modal`), Hermite finite elements (`fem`), a geometrically exact beam in absolute "
        "coordinates (`absolute`, which has neither `kinetics` nor `modes`), or a user-defined discretization",
    )
    frame: Literal["tangent", "mean-axis"] = key(
        "tangent",
        "the floating frame: tangent to the root (clamped shapes), or the mean axis (shapes that turn at the "
        "root), which is the default of the full nodal model",
    )
    kinetics: Literal["zeroth-order", "first-order", "full"] = key(
        "first-order", "order of the kinetic energy in the elastic coordinates"
    )
    modes: Annotated[int, Field(ge=0, le=MAX_MODES)] = key(
        2, "number of modes; of finite elements: reduced to so many of their own modes, 0: the full nodal model"
    )
    elements: Annotated[int, Field(ge=1, le=MAX_ELEMENTS)] = key(32, "number of finite elements")
    mesh: str = key(
        "",
        "a file with line elements on an axis, in any format that meshio reads (`beam.msh`), whose nodes "
        "take the place of those that follow from `elements` and `grading`",
    )
    nodes: Annotated[tuple[NonNegative, ...], Field(strict=False, max_length=MAX_ELEMENTS + 1), Unit("m")] = key(
        (), "places of the nodes, ascending from 0 to the length of the beam; none: from `elements` and `grading`"
    )
    grading: Annotated[float, Field(ge=1.0, le=MAX_GRADING)] = key(
        1.0, "largest over smallest element of a mesh that is graded towards the contact point"
    )

    @model_validator(mode="before")
    @classmethod
    def _count_elements(cls, data: Any) -> Any:
        """Without a number of elements it is that of the nodes."""
        nodes = data.get("nodes") if isinstance(data, dict) else None
        return {"elements": len(nodes) - 1} | data if isinstance(nodes, list | tuple) and len(nodes) > 1 else data


class SolverSection(Section):
    """How time is marched."""

    scheme: Annotated[str, Choice("integrators", SCHEMES)] = key(
        "event",
        "adaptive with located events, the paper's fixed steps, implicit generalized-alpha (the default of "
        "the full nodal model), energy-consistent (that of absolute coordinates), or a user-defined one",
    )
    tolerance: Annotated[float, Field(ge=1e-13, le=1e-2)] = key(
        1e-10, "relative tolerance of a step (event), of the iterations (generalized-alpha, energy-consistent)"
    )
    free_step: Annotated[Positive, Unit("s")] = key(1e-4, "step in flight (all but event)")
    contact_step: Annotated[Positive, Unit("s")] = key(1e-6, "step in contact (all but event)")
    rho_infinity: Annotated[float, Field(ge=0.0, le=1.0)] = key(
        0.8, "spectral radius of generalized-alpha at infinite frequency"
    )
    baumgarte: Annotated[tuple[NonNegative, NonNegative], Field(strict=False), Unit("1/s")] = key(
        (10.0, 1000.0), "Baumgarte's parameters [chi, beta] of the contact constraints"
    )
    baumgarte_form: Literal["squared", "plain"] = key(
        "squared",
        "how Baumgarte's parameters are read, `squared`: Z'' + 2 chi Z' + beta^2 Z = 0; "
        "`plain`: Z'' + chi Z' + beta Z = 0",
    )
    stick: Literal["arrest", "force"] = key(
        "arrest",
        "fixed-step: contact sticks where the force that holds it lies in the friction cone and can stop "
        "the slip within a step (`arrest`), or where it lies in the cone whatever the slip velocity is "
        "(`force`, as the paper)",
    )
    output_interval: Annotated[Positive, Unit("s")] = key(
        1e-4, "interval of the samples; events are always kept exactly"
    )


class ParametersSection(Section):
    """Numbers of user-defined parts, installed or registered; the built-in ones have keys."""

    friction: Parameters = key((), "numbers of the friction law that contact.friction names")
    normal: Parameters = key((), "numbers of the contact law that contact.normal names")
    impact: Parameters = key((), "numbers of the impact law that contact.impact names")
    profile: Parameters = key((), "numbers of the base motion that root.profile names")
    scheme: Parameters = key((), "numbers of the integrator that solver.scheme names")


class ScenarioKeys(Section):
    """All keys of a scenario, and what follows from them alone."""

    title: Annotated[str, Field(max_length=200)] = key("", "what pictures, films and pages call the run")
    end_time: Annotated[Positive, Unit("s")] = key(1.0, "duration of the run")
    gravity: Annotated[float, Field(ge=0.0, le=1e6), Unit("m/s^2")] = key(
        9.8, "acceleration of gravity, downwards"
    )
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
    def is_absolute(self) -> bool:
        """Whether the beam is in absolute coordinates, with mechanics of its own."""
        return self.discretization.method == "absolute"

    @property
    def contact_fibre(self) -> float:
        """Place (m) of the contact point in its section, across the beam: 0 on the axis, negative below it."""
        if self.contact.surface == "axis":
            return 0.0
        facing = math.cos(self.initial.angle - self.slope.angle)  # the side that looks at the slope
        return -math.copysign(fibre_distance(self.beam, self.contact.point), facing)

    @property
    def initial_gap(self) -> float:
        """Gap of the undeformed beam at t = 0 (m)."""
        reach, angle = self.root.hub_radius + self.contact.point, self.initial.angle - self.slope.angle
        return reach * math.sin(angle) + self.contact_fibre * math.cos(angle) - self.slope.offsets[0]

    @property
    def initial_slip(self) -> float:
        """Place of the contact point along the slope at t = 0 (m from its origin)."""
        reach, angle = self.root.hub_radius + self.contact.point, self.initial.angle - self.slope.angle
        return reach * math.cos(angle) - self.contact_fibre * math.sin(angle) - self.slope.offsets[1]

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
