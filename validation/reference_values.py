"""Reference values of closed forms, published benchmarks and independent computations, with their sources.

Items 2 are in units of sqrt(EI/(m L^4)): eta is the spin rate, d the hub radius over L, c clamped, h hinged.
All else is in SI units.
"""

from __future__ import annotations

from typing import Any, NamedTuple


class Reference(NamedTuple):
    """One reference: its number, its value(s), where they come from."""

    id: str
    value: Any
    source: str


TABLE = (
    Reference(
        "1.1",
        [
            1.8751040687119611,
            4.694091132974175,
            7.854757438237613,
            10.995540734875467,
            14.13716839104647,
            17.278759532088237,
            20.42035225104125,
            23.561944901806445,
            26.7035375555183,
            29.845130209102816,
        ],
        "roots of cos b cosh b = -1 (clamped-free), mpmath, 40 digits",
    ),
    Reference(
        "1.2",
        [
            3.926602312047919,
            7.068582745628732,
            10.21017612281303,
            13.351768777754094,
            16.49336143134641,
            19.634954084936208,
            22.776546738526,
            25.918139392115794,
            29.059732045705587,
            32.201324699295384,
        ],
        "roots of tan b = tanh b (hinged-free), mpmath, 40 digits",
    ),
    Reference(
        "1.3",
        0.0006944444444444445,
        "dispersion analysis of cubic Hermite elements with consistent mass: relative error of a "
        "frequency (beta h)^4/1440, here 1/1440; finite elements in 40-digit arithmetic",
    ),
    Reference(
        "1.3-n32",
        [0.00069418, 0.0006932, 0.00069193],
        "finite elements in 40-digit arithmetic: error/(beta h)^4 at n = 32, clamped-free modes 1-3",
    ),
    Reference(
        "1.4-c4",
        [3.27080754780676e-05, 0.001165206975265551, 0.0077422962585947976],
        "Hermite elements in 40-digit arithmetic: relative frequency errors of modes 1-3, uniform mesh",
    ),
    Reference(
        "1.4-c8",
        [2.083010516825709e-06, 7.995889790883635e-05, 0.0006082410486725216],
        "Hermite elements in 40-digit arithmetic: relative frequency errors of modes 1-3, uniform mesh",
    ),
    Reference(
        "1.4-c16",
        [1.307942206727679e-07, 5.10785777175727e-06, 3.9753777356335115e-05],
        "Hermite elements in 40-digit arithmetic: relative frequency errors of modes 1-3, uniform mesh",
    ),
    Reference(
        "1.4-c32",
        [
            8.184111770186864e-09,
            3.2096974571126545e-07,
            2.5118657478932305e-06,
        ],
        "Hermite elements in 40-digit arithmetic: relative frequency errors of modes 1-3, uniform mesh",
    ),
    Reference(
        "1.4-h8",
        [3.934409600344094e-05, 0.00040106445532034395, 0.001677879048922534],
        "Hermite elements in 40-digit arithmetic: relative frequency errors of modes 1-3, uniform mesh",
    ),
    Reference(
        "1.4-h16",
        [
            2.503969709164749e-06,
            2.6105266223778172e-05,
            0.00011256300479298151,
        ],
        "Hermite elements in 40-digit arithmetic: relative frequency errors of modes 1-3, uniform mesh",
    ),
    Reference(
        "2-c-d0-eta0",
        {
            "flap": [3.5160152685, 22.0344915647, 61.6972144135, 120.901916052],
            "chord": [3.5160152685, 22.0344915647, 61.6972144135, 120.901916052],
        },
        "Frobenius series, 50 digits; reproduces the 4 decimals of Wright et al. 1982; certain to 9 digits",
    ),
    Reference(
        "2-c-d0-eta1",
        {
            "flap": [3.68164681396, 22.1810111506, 61.8417625872, 121.050921884],
            "chord": [3.54323626967, 22.158457881, 61.8336769074, 121.04679132],
        },
        "Frobenius series, 50 digits; reproduces the 4 decimals of Wright et al. 1982; certain to 9 digits",
    ),
    Reference(
        "2-c-d0-eta2",
        {
            "flap": [4.13731957303, 22.6149219565, 62.2731841057, 121.496694714],
            "chord": [3.62179696412, 22.5263111738, 62.2410592668, 121.480232246],
        },
        "Frobenius series, 50 digits; reproduces the 4 decimals of Wright et al. 1982; certain to 9 digits",
    ),
    Reference(
        "2-c-d0-eta3",
        {
            "flap": [4.79727853236, 23.3202636743, 62.9849674807, 122.235547134],
            "chord": [3.74351189621, 23.1264934186, 62.9134812941, 122.19872742],
        },
        "Frobenius series, 50 digits; reproduces the 4 decimals of Wright et al. 1982; certain to 9 digits",
    ),
    Reference(
        "2-c-d0-eta4",
        {
            "flap": [5.58500142088, 24.2733493944, 63.9667604931, 123.261484898],
            "chord": [3.89772252364, 23.9415014321, 63.8415730381, 123.196565128],
        },
        "Frobenius series, 50 digits; reproduces the 4 decimals of Wright et al. 1982; certain to 9 digits",
    ),
    Reference(
        "2-c-d0-eta5",
        {
            "flap": [6.44954474857, 25.446080358, 65.2050405219, 124.566421181],
            "chord": [4.07389585824, 24.950010132, 65.0130549156, 124.466032659],
        },
        "Frobenius series, 50 digits; reproduces the 4 decimals of Wright et al. 1982; certain to 9 digits",
    ),
    Reference(
        "2-c-d0-eta6",
        {
            "flap": [7.36037301931, 26.8090816785, 66.6839143815, 126.140452589],
            "chord": [4.26322542019, 26.1290424709, 66.4134356681, 125.997673706],
        },
        "Frobenius series, 50 digits; reproduces the 4 decimals of Wright et al. 1982; certain to 9 digits",
    ),
    Reference(
        "2-c-d1-eta2",
        {
            "flap": [4.83368887153, 23.3660420457, 63.0675481233],
            "chord": [4.40051679996, 23.2802903951, 63.0358281161],
        },
        "Frobenius series, 50 digits; certain to 9 digits",
    ),
    Reference(
        "2-h-d0-eta1",
        {
            "flap": [1.0, 15.6242415255, 50.1436866523, 104.420200295],
            "chord": [0.0, 15.592207132, 50.1337143156, 104.415411839],
        },
        "Frobenius series, 50 digits; certain to 9 digits",
    ),
    Reference(
        "2-h-d0-eta2",
        {
            "flap": [2.0, 16.2261015324, 50.6760048335, 104.935826051],
            "chord": [0.0, 16.1023715937, 50.636523043, 104.916765052],
        },
        "Frobenius series, 50 digits; certain to 9 digits",
    ),
    Reference(
        "2-h-d0-eta5",
        {
            "flap": [5.0, 19.9196616457, 54.2419378644, 108.469076591],
            "chord": [0.0, 19.2819324778, 54.0109972439, 108.353775092],
        },
        "Frobenius series, 50 digits; certain to 9 digits",
    ),
    Reference(
        "2.free",
        [19.28193, 54.011, 108.354],
        "pinned beam spinning freely at eta = 5: frequencies in the plane are the hinged chordwise ones",
    ),
    Reference(
        "3-SVQ-min",
        {"w_min": -0.574372675084362, "t": 6.76202695615718},
        "spin-up of Simo and Vu-Quoc (J. Appl. Mech. 53, 1986), first-order equations, 12 clamped "
        "modes, DOP853 at 1e-11; 16 Hermite elements with the trapezoidal rule agree; certain to "
        "1e-6",
    ),
    Reference(
        "3-SVQ-min-modes",
        {
            1: -0.57826,
            2: -0.573549,
            3: -0.574443,
            4: -0.574336,
            6: -0.574367,
            8: -0.574372,
            12: -0.574373,
        },
        "as 3-SVQ-min: minimum (m) by number of modes, 6 decimals",
    ),
    Reference(
        "3-SVQ-amp",
        0.0036469007129986807,
        "as 3-SVQ-min: amplitude of the tip's vibration for t > 15 s; certain to 3 digits",
    ),
    Reference(
        "3-SVQ-amp-modes",
        {1: 0.0026962, 2: 0.0034226, 3: 0.0036106, 4: 0.0036336, 8: 0.0036464},
        "as 3-SVQ-amp: amplitude (m) by number of modes, 5 digits",
    ),
    Reference(
        "3-SVQ-freq",
        {
            "w1": 3.797730545606582,
            "rot": [4.512554992470401, 27.63466548503711, 71.03210269401063],
        },
        "as 3-SVQ-min: first frequency at rest, chordwise frequencies of the 12 modes at 6 rad/s (rad/s)",
    ),
    Reference(
        "3-SVQ-table",
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
        "as 3-SVQ-min: tip deflection (m) at given times (s); certain to 1e-6",
    ),
    Reference(
        "3-SVQ-GE",
        {"own": [-0.57383, 6.762], "exudyn": [-0.574316, 6.777]},
        "the same spin-up of a geometrically exact beam: minimum (m) and its time (s) with "
        "Reissner elements (n = 40, generalized-alpha) and with Exudyn 1.13 (n = 20); within 2e-4 "
        "m",
    ),
    Reference(
        "4",
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
        "rigid bar released at pi/4, slope pi/10 through (0.3, 0): t = [K(k) - "
        "F(asin(sin(phi_f/2)/k), k)]/sqrt(3 g/2 L), k = sin(phi_0/2), phi = pi/2 + theta; "
        "quadrature and DOP853 agree",
    ),
    Reference(
        "7a",
        {"tip": 0.00196612873427, "slope": 0.00262150497903, "M0": 4.256826},
        "horizontal cantilever under its own weight: q L^4/(8 EI), q L^3/(6 EI), q L^2/2; "
        "EI = 541.27, m = 0.86874, L = 1, g = 9.8",
    ),
    Reference(
        "7c",
        {"1": 1.14740331052, "4": 2.05120700613, "-4": 0.659730170976, "7": 9.43629097435},
        "heavy cantilever, transverse load q_t, axial load q_a (compression > 0): tip w 8 EI/(q_t L^4) by "
        "a = q_a L^3/EI; power series, finite elements",
    ),
    Reference(
        "7c-inclined",
        {"45": 1.00143201988, "-45": 0.998572044594},
        "as 7c, for the beam of 7a inclined by +45 and -45 degrees",
    ),
    Reference(
        "4b",
        {
            "Mmax": 0.22296522,
            "tip": 0.000139026296,
            "slope": 0.000231710493,
            "omega1": 15.4182,
        },
        "statics of the falling chimney: M = m g L cos(th)/27 at L/3, tip m g L^3 cos(th)/(80 EI), "
        "slope m g L^2 cos(th)/(48 EI); EI = 541.27, m = 0.86874, L = 1, th = pi/4",
    ),
    Reference(
        "6a",
        {
            "tan": 0.32491969623291,
            "a_mu02": 1.16429577294,
            "t_05m": 0.92676225932,
        },
        "closed form, incline of pi/10, g = 9.8: sticks iff mu_s >= tan; acceleration and time for "
        "0.5 m at mu = 0.2",
    ),
    Reference(
        "6b",
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
    Reference(
        "6c",
        {
            "t_slip": 0.408514767595,
            "t_stick": 0.392,
            "period": 0.800514767595,
            "x_min": 0.0183981819684,
            "x_max": 0.0404018180316,
            "v_min": -0.110018180316,
        },
        "closed form, mass on a belt: t_slip = (2/w)(pi - atan(D w/v)), t_stick = 2 D/v, D = (mu_s "
        "- mu_k) N/k; event-driven DOP853 at 1e-12 agrees",
    ),
    Reference(
        "6d",
        {
            "mu_crit": 1.3333333333333333,
            "theta_crit_deg": 63.4349488229,
            "interval_deg": [50.6415981605, 73.0484693655],
            "interval_rad": [0.883862626373, 1.27493630397],
            "mp_at_atan2": -0.2,
            "jam_mu": 10.7404406877,
        },
        "closed form (Lecornu 1905; Genot and Brogliato 1999): 1 + 3 cos(cos - mu sin) = 0, tan = "
        "(3 mu +- sqrt(9 mu^2 - 16))/2; jam of the pinned bar of item 4 at mu = cot|phi|",
    ),
    Reference(
        "6e",
        {
            "e05": 1.35526185436,
            "e08": 4.06578556307,
            "first": 0.451753951453,
            "dist_e05": 1.66666666667,
            "dist_e08": 4.55555555556,
        },
        "closed form, ball dropped from 1 m, g = 9.8: sqrt(2 h/g)(1 + e)/(1 - e), distance h (1 + e^2)/(1 - e^2)",
    ),
    Reference(
        "6f",
        {
            "45,.3,2,-1,.5 slip": [0.508474576271, -0.152542372881, 0.85593220339, 0.5],
            "45,.8,-.5,-1,.5 slip-stick": [1.15384615385, 0.892307692308, 0.0, 0.546153846154],
        },
        "Routh's method with Poisson's restitution for a rod of mass 1: P, P_t, v_t, v_n; impulse "
        "stepping agrees to 1e-5",
    ),
    Reference(
        "6g",
        [-0.00065, 0.00045, -0.00025, 5e-05],
        "VPCS SDND100 (V5.01.100, code_aster): analytic extrema at k pi/100 s",
    ),
    Reference(
        "6i",
        {
            "mu0": 1.10114156656,
            "mu03": 1.07122043576,
            "Pt_mu03": 0.321366130728,
            "KE": 2.07557864804,
            "e05_mu03": {"e_kinetic": 0.472827171624, "omega": 1.79020488968},
        },
        "closed form, plastic impact of the bar of item 4, m = 0.86874: P = J w/(cos phi + mu |sin "
        "phi|); Poisson's e acts as e (cos - mu |sin|)/(cos + mu |sin|)",
    ),
    Reference(
        "5b",
        {1e-3: 0.4152203, 2e-3: 0.5549575},
        "impulse (N s) of a hinged beam whose tip is held from t = 0 on, EI = 541.27, m = 0.86874, L = 1, v0 = "
        "3.77: J(t) = (2 m L v0/pi^2) sum (1 - cos n^2 w1 t)/n^2, w1 = pi^2 c/L^2, c = sqrt(EI/m)",
    ),
    Reference(
        "5c",
        {"tip": 0.0722100668103},
        "effective mass of the end of a Hermite mesh over m h: 1/(M^-1)_tt in extended precision",
    ),
    Reference(
        "5e",
        {"x_peak": 1.64522887065, "f_peak": 0.85803877759},
        "end of a semi-infinite beam on a spring: F = v0 Z t_k^(-1/2) f(t/t_k), f(x) = x E_{3/2,2}(-x^(3/2)), "
        "Z = EI^(1/4) m^(3/4)/sqrt 2, t_k = (Z/k)^(2/3) (Laplace transform, Mittag-Leffler function)",
    ),
    Reference(
        "5f",
        {"1e5": (317.107, 0.00599442, 1.034329, 0.19818), "1e6": (683.155, 0.00297991, 0.746103, 1.1935)},
        "hinged beam EI = 541.27, m = 0.86874, L = 1, v0 = 3.77 on a spring: peak (N), end (s), impulse (N s), "
        "rotation after (rad/s); 128 finite elements, exact in time, converged digits",
    ),
    Reference(
        "7a-elastic",
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
        "the paper's beam on a spring of 1e6 N/m, frictionless: geometrically exact extensible code (ANCF, "
        "explicit and implicit, 64 and 128 elements)",
    ),
    Reference(
        "8-SDNL32",
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
        "VPCS SDNL32 (code_aster V5.02.032, external source): tip displacement (m) at 1 to 12 ms",
    ),
    Reference(
        "two-modes-frictionless",
        [0.3171473192, 0.3194243426, 0.3215519110, 0.3271825776, 0.3294994229, 0.3303667026],
        "independent prototype of the paper's case (SciPy DOP853 with events, two clamped modes): event times (s)",
    ),
    Reference(
        "two-modes-hybrid",
        [
            0.3171473192,
            0.3194229069,
            0.3215523998,
            0.3235971200,
            0.3271806857,
            0.3295061743,
            0.3299378327,
            0.3303660603,
        ],
        "independent prototype of the paper's case (SciPy DOP853 with events, two clamped modes): event times (s)",
    ),
    Reference(
        "two-modes-impulse",
        0.356576404,
        "independent prototype of the paper's case: first impulse (N s)",
    ),
    Reference(
        "rigid-stop-modes",
        {4: (1.834, 2.355), 6: (1.861, 2.416), 8: (1.864, 2.444), 10: (1.854, 2.475), 16: (1.890, 2.509)},
        "independent prototype, rigid frictionless stop: impulse of the first macro-collision (N s) and energy "
        "left (J) by number of mean-axis modes; three decimals, cut",
    ),
)

VALUES: dict[str, Any] = {reference.id: reference.value for reference in TABLE}

_SOURCES = {reference.id: reference.source for reference in TABLE}


def source(item: str) -> str:
    """Return where a reference comes from."""
    return _SOURCES[item]
