/* The result that colours the beam: its values at the lower and the upper fibre, linear between them. */

let result = facts.results.find((one) => one.shown);

/** Choose the result by its name; another name changes nothing. */
function setResult(name) {
  result = facts.results.find((one) => one.name === name) || result;
}

function newSides() {
  return { lower: new Float64Array(STATIONS), upper: new Float64Array(STATIONS) };
}

/** Values at part `u` between frame k and the next. */
function along(name, k, u) {
  const values = arrays[name], a = k * STATIONS, b = a + STATIONS;
  const first = values.subarray(a, b);
  return u === 0 ? first : first.map((v, j) => (1 - u) * v + u * values[b + j]);
}

/** Bending stress of the lower fibre (Pa), which a positive moment stretches. */
function lowerFibre(k, u) {
  return along("frame_moment", k, u).map((moment, j) => (moment * arrays.radius[j]) / arrays.second_moment[j]);
}

/** Rotations of the sections against the floating frame: derivatives of the deflection along the beam. */
function rotations(k, u) {
  const deflection = along("frame_uy", k, u), rows = arrays.derivatives;
  return deflection.map((_, j) => deflection.reduce((sum, v, n) => sum + rows[j * STATIONS + n] * v, 0));
}

const BOTH_SIDES = {
  bending_moment: (k, u) => along("frame_moment", k, u),
  shear_force: (k, u) => along("frame_shear", k, u),
  axial_force: (k, u) => along("frame_axial", k, u),
  section_rotation: rotations,
};

/** Fill in the result at part `u` between frame k and the next. */
function setSides(k, u, { lower, upper }) {
  const both = BOTH_SIDES[result.name]?.(k, u);
  if (both) {
    lower.set(both);
    upper.set(both);
    return;
  }
  const bending = lowerFibre(k, u);
  const axial = result.name === "axial_stress" ? along("frame_axial", k, u) : null;
  for (let j = 0; j < STATIONS; j++) {
    const mean = axial ? axial[j] / arrays.area[j] : 0;
    lower[j] = mean + bending[j];
    upper[j] = mean - bending[j];
  }
}
