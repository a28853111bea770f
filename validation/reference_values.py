"""Reference values of closed forms, published benchmarks and other programs, with their sources.

A source is a citation, a closed form, or the command in this repository that computes the value again without the
suite: `tests/validation/test_reference_programs.py` holds the table against those programs.

The tables of frequencies (items 1 and 2) stand in `reference_frequencies`; all else is in SI units.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from oblique_impact.validation.reference_frequencies import CLAMPED_ROOTS, ELEMENT_ERRORS, HINGED_ROOTS, SPINNING


class Reference(NamedTuple):
    """One reference: its value(s) and where they come from."""

    value: Any
    source: str


_BEAMS = "python benchmarks/reference_beams.py"
_IMPACT = "python benchmarks/reference_impact.py"
_PEGS = "python benchmarks/reference_pegs.py"
_WRIGHT = "Wright, Smith, Thresher and Wang, J. Appl. Mech. 49 (1982), pp. 197-202, to its 4 decimals"
_AGREES = f", agrees with {_WRIGHT}"
_SIMO = "Simo and Vu-Quoc, J. Appl. Mech. 53 (1986), pp. 849-863"

#: elastic stops by stiffness (N/m): impulse of the first collision and of its first contact (N s), largest force
#: (N), starts and ends of contacts (s), an instant after the collision (s); how far the meshes agree
_EXUDYN_STOPS: dict[str, tuple[dict[str, Any], str]] = {
    "1e5": (
        {
            "impulse": 2.109943,
            "first": 1.058927,
            "peak": 434.28,
            "switches": (0.317147, 0.323183, 0.324969, 0.329239),
            "end": 0.331,
        },
        "24 to 48 elements agree to 3e-6 of the impulse and 1e-6 s",
    ),
    "1e6": (
        {
            "impulse": 2.140254,
            "first": 0.757646,
            "peak": 924.45,
            "switches": (
                *(0.317147, 0.320131, 0.320816, 0.321611, 0.324809),
                *(0.325811, 0.326045, 0.326719, 0.328510, 0.329274),
            ),
            "end": 0.331,
        },
        "24 to 64 elements agree to 1e-5 of the impulse, 4e-4 of the peak and 2e-6 s",
    ),
    "1e7": (
        {
            "impulse": 1.9123,
            "first": 0.4784,
            "peak": 2010.0,
            "switches": (0.317147, 0.318404, 0.318517, 0.318650, 0.318883, 0.319031),
            "end": 0.331,
        },
        "48 elements; 32 give an impulse of 1.9158 N s and a peak of 2013 N",
    ),
}

REFERENCES = {
    "1.1": Reference(CLAMPED_ROOTS, f"roots of cos b cosh b = -1 (clamped-free), 40 digits; {_BEAMS} 1.1"),
    "1.2": Reference(HINGED_ROOTS, f"roots of tan b = tanh b (hinged-free), 40 digits; {_BEAMS} 1.2"),
    "1.3": Reference(
        0.0006944444444444445,
        "dispersion analysis of cubic Hermite elements with consistent mass: relative error of a "
        "frequency (b h)^4/1440, here 1/1440 (Strang and Fix, An Analysis of the Finite Element Method, 1973, "
        "Ch. 6)",
    ),
    **{
        f"1.4-{mesh}": Reference(
            errors,
            "Hermite elements in 40-digit arithmetic: relative frequency errors of modes 1-3; "
            f"{_BEAMS} 1.4-{mesh}",
        )
        for mesh, errors in ELEMENT_ERRORS.items()
    },
    **{
        f"2-{row}": Reference(
            {"flap": flap, "chord": chord},
            f"power series in 50 digits{_AGREES if row.startswith('c-d0') else ''}; {_BEAMS} 2-{row}",
        )
        for row, (flap, chord) in SPINNING.items()
    },
    "3-SVQ-min": Reference(
        {"w_min": -0.574372675084362, "t": 6.76202695615718},
        f"spin-up of {_SIMO}, in first-order equations of 12 clamped modes, by SciPy's DOP853 at 1e-11; "
        f"{_BEAMS} 3-SVQ-min",
    ),
    "3-SVQ-min-modes": Reference(
        {1: -0.57826, 2: -0.573549, 3: -0.574443, 4: -0.574336, 6: -0.574367, 8: -0.574372, 12: -0.574373},
        f"spin-up of {_SIMO}: minimum (m) by number of clamped modes, 6 decimals; {_BEAMS} 3-SVQ-min-modes",
    ),
    "3-SVQ-amp": Reference(
        0.0036469007129986807,
        f"spin-up of {_SIMO}: amplitude (m) of the tip's vibration for t > 15 s; certain to 3 digits; "
        f"{_BEAMS} 3-SVQ-amp",
    ),
    "3-SVQ-w1": Reference(
        3.797730545606582,
        "closed form: b^2 sqrt(EI/(m L^4)) with the first root of cos b cosh b = -1, EI = 1.4e4, m = 1.2, L = 10",
    ),
    "3-SVQ-table": Reference(
        {
            1.0: -0.020543126703274135,
            2.0: -0.10237562361624541,
            3.0: -0.2172858951735303,
            4.0: -0.34238903496965395,
            5.0: -0.4687817033993271,
            6.0: -0.5440649379018232,
            7.0: -0.571837745720846,
            7.5: -0.5595219038956369,
            8.0: -0.543202110693067,
            9.0: -0.4604239817327903,
            10.0: -0.36284780135876116,
            11.0: -0.2572956307899267,
            12.0: -0.1508392724794877,
            13.0: -0.06918829062286304,
            14.0: -0.020283683216541438,
            15.0: 0.0012982000928806593,
            16.0: 0.0030820647618456944,
            17.0: -0.002522379140298346,
            18.0: -0.0020804295937545928,
            20.0: 0.000750456298469059,
        },
        f"spin-up of {_SIMO}: tip deflection (m) at given times (s); certain to 1e-6; {_BEAMS} 3-SVQ-table",
    ),
    "3-SVQ-GE": Reference(
        {"w_min": -0.574316, "t": 6.777},
        "the same spin-up of a geometrically exact beam in Exudyn 1.13 (20 ANCF elements); within 2e-4 m; "
        "python benchmarks/exudyn_spin_up.py (extra bench)",
    ),
    "4": Reference(
        {
            "theta_f": 0.221320862620576,
            "t": 0.31712812975612,
            "omega": -3.78617177082837,
            "v_tip": 3.78617177083,
            "v_n": 3.7698670381,
            "v_t": -0.350997426243,
            "point": [0.975608346749281, 0.219518458798193],
            "dist_along_slope": 0.710376654987,
        },
        "closed form, rigid bar released at pi/4, slope pi/10 through (0.3, 0): t = [K(k) - "
        "F(asin(sin(phi_f/2)/k), k)]/sqrt(3 g/2 L), k = sin(phi_0/2), phi = pi/2 + theta (elliptic integrals)",
    ),
    "7a": Reference(
        {"tip": 0.00196612873427, "slope": 0.00262150497903, "M0": 4.256826},
        "closed form, horizontal cantilever under its own weight: q L^4/(8 EI), q L^3/(6 EI), q L^2/2; "
        "EI = 541.27, m = 0.86874, L = 1, g = 9.8",
    ),
    "7c": Reference(
        {"1": 1.14740331052, "4": 2.05120700613, "-4": 0.659730170976, "7": 9.43629097435},
        "heavy cantilever, transverse load q_t, axial load q_a (compression > 0): tip w 8 EI/(q_t L^4) by "
        f"a = q_a L^3/EI; power series in 40 digits; {_BEAMS} 7c",
    ),
    "7c-inclined": Reference(
        {"45": 1.00143201988, "-45": 0.998572044594},
        f"heavy cantilever EI = 541.27, m = 0.86874, L = 1, g = 9.8 at +45 and -45 degrees: tip w 8 EI/(q_t L^4); "
        f"power series in 40 digits; {_BEAMS} 7c-inclined",
    ),
    "4b": Reference(
        {"Mmax": 0.22296522, "tip": 0.000139026296, "slope": 0.000231710493, "omega1": 15.4182},
        "closed form, statics of the falling chimney: M = m g L cos(th)/27 at L/3, tip m g L^3 cos(th)/(80 EI), "
        "slope m g L^2 cos(th)/(48 EI); EI = 541.27, m = 0.86874, L = 1, th = pi/4",
    ),
    "6a": Reference(
        {"tan": 0.32491969623291, "a_mu02": 1.16429577294, "t_05m": 0.92676225932},
        "closed form, incline of pi/10, g = 9.8: sticks iff mu_s >= tan; acceleration and time for "
        "0.5 m at mu = 0.2",
    ),
    "6b": Reference(
        {
            "mu02": {
                "t_stop": 0.408794200209,
                "d": 0.408794200209,
                "slides_back": True,
                "v_return": 0.975661169981,
                "t_total": 1.24677814953,
            },
            "mu04": {"t_stop": 0.296010894049, "d": 0.296010894049, "slides_back": False},
        },
        "closed form, thrown up the incline of pi/10 at 2 m/s: v_return = v0 sqrt((tan - mu)/(tan + mu))",
    ),
    "6c": Reference(
        {
            "t_slip": 0.408514767595,
            "t_stick": 0.392,
            "period": 0.800514767595,
            "x_min": 0.0183981819684,
            "x_max": 0.0404018180316,
            "v_min": -0.110018180316,
        },
        "closed form, mass on a belt: t_slip = (2/w)(pi - atan(D w/v)), t_stick = 2 D/v, D = (mu_s - mu_k) N/k",
    ),
    "6d": Reference(
        {
            "mu_crit": 1.3333333333333333,
            "theta_crit_deg": 63.4349488229,
            "interval_deg": [50.6415981605, 73.0484693655],
            "interval_rad": [0.883862626373, 1.27493630397],
            "mp_at_atan2": -0.2,
            "jam_mu": 10.7404406877,
        },
        "closed form (Lecornu 1905; Genot and Brogliato 1999): 1 + 3 cos(cos - mu sin) = 0, tan = "
        "(3 mu +- sqrt(9 mu^2 - 16))/2; jam of a pinned bar at mu = cot|phi|",
    ),
    "6e": Reference(
        {
            "e05": 1.35526185436,
            "e08": 4.06578556307,
            "first": 0.451753951453,
            "dist_e05": 1.66666666667,
            "dist_e08": 4.55555555556,
        },
        "closed form, ball dropped from 1 m, g = 9.8: sqrt(2 h/g)(1 + e)/(1 - e), distance h (1 + e^2)/(1 - e^2)",
    ),
    "6f": Reference(
        {
            "45,.3,2,-1,.5 slip": [0.508474576271, -0.152542372881, 0.85593220339, 0.5],
            "45,.8,-.5,-1,.5 slip-stick": [1.15384615385, 0.892307692308, 0.0, 0.546153846154],
        },
        "closed form: Routh's method with Poisson's restitution for a rod of mass 1 (Wang and Mason, J. Appl. "
        "Mech. 59, 1992, pp. 635-642): P, P_t, v_t, v_n",
    ),
    "6g": Reference(
        [-0.00065, 0.00045, -0.00025, 5e-05],
        "code_aster documentation V5.01.100, test SDND100 of the guide VPCS: closed-form extrema at k pi/100 s",
    ),
    "6i": Reference(
        {
            "mu0": 1.10114156656,
            "mu03": 1.07122043576,
            "Pt_mu03": 0.321366130728,
            "KE": 2.07557864804,
            "e05_mu03": {"e_kinetic": 0.472827171624, "omega": 1.79020488968},
        },
        "closed form, plastic impact of the rigid bar released at pi/4 (slope pi/10), m = 0.86874: P = J w/(cos "
        "phi + mu |sin phi|); Poisson's e acts as e (cos - mu |sin|)/(cos + mu |sin|)",
    ),
    "5b": Reference(
        {1e-3: 0.4152203, 2e-3: 0.5549575},
        "closed form, impulse (N s) of a hinged beam whose tip is held from t = 0 on, EI = 541.27, m = 0.86874, "
        "L = 1, v0 = 3.77: J(t) = (2 m L v0/pi^2) sum (1 - cos n^2 w1 t)/n^2, w1 = pi^2 c/L^2, c = sqrt(EI/m)",
    ),
    "5c": Reference(
        {"tip": 0.0722100668103},
        f"effective mass of the end of a long Hermite mesh over m h: 1/(M^-1)_tt in 30 digits; {_BEAMS} 5c",
    ),
    "5e": Reference(
        {"x_peak": 1.64522887065, "f_peak": 0.85803877759},
        "end of a semi-infinite beam on a spring: F = v0 Z t_k^(-1/2) f(t/t_k), f(x) = x E_{3/2,2}(-x^(3/2)), "
        "Z = EI^(1/4) m^(3/4)/sqrt 2, t_k = (Z/k)^(2/3) (Laplace transform, Mittag-Leffler function E); "
        f"{_BEAMS} 5e",
    ),
    "5f": Reference(
        {
            "1e5": (317.1069605653, 0.005994419290120, 1.034329002013, 0.1981752813976),
            "1e6": (683.1552202162, 0.002979907273262, 0.7461026120054, 1.1935008909269),
        },
        "hinged beam EI = 541.27, m = 0.86874, L = 1, v0 = 3.77 on a spring: peak (N), end (s), impulse (N s), "
        f"rotation after (rad/s); 400 hinged modes with the spring, exact in time by eigenvectors; {_BEAMS} 5f",
    ),
    "7a-elastic": Reference(
        {
            "impulse": 2.140259,
            "peak": 924.45,
            "next": 0.86535,
            "contacts": [
                (0.317147, 0.320131),
                (0.320816, 0.321611),
                (0.324809, 0.325811),
                (0.326045, 0.326719),
                (0.328510, 0.329274),
            ],
        },
        "the paper's beam on a spring of 1e6 N/m, frictionless, extensible and geometrically exact: ANCF "
        "elements; Exudyn's give the same (24 to 64: impulse within 1e-5, peak within 4e-4, times within 2e-6 s); "
        "python benchmarks/exudyn_beam.py --limit (extra bench)",
    ),
    **{
        f"exudyn-{stiffness}": Reference(
            values,
            f"the paper's beam on a spring of {stiffness} N/m, frictionless: Exudyn 1.13's ANCF cable elements, "
            f"extensible, without shear and rotary inertia, {accuracy}; python benchmarks/exudyn_beam.py --limit "
            f"{stiffness} (extra bench)",
        )
        for stiffness, (values, accuracy) in _EXUDYN_STOPS.items()
    },
    "damped-stop": Reference(
        {
            "starts": (0.3171448, 0.6594738, 0.8528885, 0.9769561),
            "end": 0.3285095,
            "impulse": 1.819369,
            "after": 0.335,
            "energy": 2.32548,
        },
        "the paper's beam with 1e-5 s of Kelvin-Voigt damping on a rigid stop without friction, by 32 mean-axis "
        "modes and a tip without inertia: starts of the macro-collisions (s), end of the first (s), its impulse "
        "(N s) and energy after it (J); python benchmarks/reference_rigid_stop.py --modes 32",
    ),
    "rod-bouncing-bar": Reference(
        {"tau": 2 / 3, "impulse": 800 / 3, "middle": 400.0, "peak": 500.0, "second": 11 / 3, "period": 16 / 3},
        "closed form: L = 10, E A = 900, rho A = 1, g = 10, dropped from 5: touch at 1, F = 300 (1 + t') for 2 "
        "L/c = 2/3, second touch at 11/3, undeformed at its first height at 16/3; Doyen, Ern and Piperno, SIAM J. "
        "Sci. Comput. 33 (2011), pp. 223-249",
    ),
    "rod-truss": Reference(
        {"speed": 1.5, "duration": 7.8994e-4, "force": 1.18491e7, "impulse": 9360.0},
        "closed form: L = 2, A = 0.2, E = 200e9, rho = 7800: F = A sqrt(E rho) v for 2 L/c, impulse 2 m v; Abaqus "
        "Benchmarks Guide, dynamic response of a truss impacting a rigid wall",
    ),
    "8-SDNL32": Reference(
        [
            -0.00266,
            -0.00433,
            -0.00492,
            -0.00478,
            -0.00382,
            -0.00287,
            -0.00271,
            -0.00309,
            -0.00341,
            -0.00336,
            -0.00264,
            -0.000742,
        ],
        "code_aster documentation V5.02.032, test SDNL32 of the guide VPCS: tip displacement (m) at 1 to 12 ms",
    ),
    "two-modes-frictionless": Reference(
        [0.317147319201, 0.319424342616, 0.321551910973, 0.327182577646, 0.329499422902, 0.330366702612],
        f"the paper's case with two clamped modes in SciPy alone (DOP853 with events): event times (s); {_IMPACT}",
    ),
    "two-modes-hybrid": Reference(
        [
            0.317147319201,
            0.319422906893,
            0.321552399752,
            0.323597119959,
            0.327180685723,
            0.329506174328,
            0.329937832683,
            0.330366060307,
        ],
        f"the paper's case with two clamped modes in SciPy alone (DOP853 with events): event times (s); {_IMPACT}",
    ),
    "two-modes-impulse": Reference(
        0.3565764038, f"the paper's case with two clamped modes in SciPy alone: first impulse (N s); {_IMPACT}"
    ),
    "peg-frictionless": Reference(
        {
            "times": (0.370169033, 0.372070404, 0.374197167, 0.383769400),
            "impacts": ((0.448930144, 0.510044488), (0.292215950, 0.216102593)),
            "energy": 2.283896616,
        },
        "the paper's beam in four mean-axis modes falls onto a point at (0.5 m, 0), in SciPy alone: times of "
        f"events (s), impulses and losses of impacts (N s, J), energy at 0.45 s (J); {_PEGS}",
    ),
    "peg-friction": Reference(
        {
            "times": (
                *(0.370169033, 0.371134315, 0.371800533, 0.372069531, 0.374195317, 0.374592521, 0.376498014),
                *(0.376788001, 0.377353724, 0.379621966, 0.382067785, 0.382666320, 0.383626124, 0.383769686),
            ),
            "impacts": ((0.448930144, 0.510044488), (0.292554849, 0.216603957)),
            "energy": 2.268730423,
        },
        f"the same with a friction coefficient of 0.3; {_PEGS}",
    ),
    "peg-elastic": Reference(
        {
            "contacts": (
                (0.370169033, 0.372895474, 1.744069695),
                (0.376420642, 0.379787560, 2.483503972),
                (0.384086536, 0.386423753, 0.665043071),
            ),
            "peak": 1402.52754,
        },
        "the same on a spring of 1e6 N/m, without friction: starts, ends (s) and impulses (N s) of contacts, "
        f"largest force (N); {_PEGS} --stiffness 1e6 --friction 0",
    ),
    "two-pegs": Reference(
        {
            "times": (
                *(0.380931742, 0.380951866, 0.380951866, 0.380978046, 0.380978046),
                *(0.381642423, 0.384804817),
            ),
            "impulses": (0.32622507, 0.76403925, 0.11106195, 1.00212495e-4, 1.45670299e-5),
            "loss": 1.678514615,
            "finite": 1.636038453,
            "energy": 1.331529083,
        },
        "the same without friction onto points at (0.4, -0.02) and (0.7, -0.035) m, until 0.385 s: times of "
        "impacts and releases (s), impulses of impacts (N s), their loss (J), impulse of finite "
        f"forces (N s), energy (J); {_PEGS} --pegs 0.4,-0.02,0.7,-0.035 --friction 0 --end 0.385",
    ),
    "three-supports": Reference(
        {"middle": 1.25, "end": 0.375},
        "equation of three moments (Clapeyron 1857): a beam of two equal spans l under its weight w per length "
        "has the moment w l^2/8 over its middle support, so that its supports carry 3/8, 10/8 and 3/8 of w l",
    ),
    "rigid-stop-modes": Reference(
        {4: (1.834605247, 2.354622649), 6: (1.861339488, 2.415705314), 8: (1.864408707, 2.443622294)},
        "the paper's case without friction in SciPy alone: impulse of the first macro-collision (N s) and energy "
        f"left (J) by number of mean-axis modes; {_IMPACT} --modes 4,6,8",
    ),
}

VALUES: dict[str, Any] = {id: reference.value for id, reference in REFERENCES.items()}


def source(item: str) -> str:
    """Return where a reference comes from."""
    return REFERENCES[item].source
