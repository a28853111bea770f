/* The run: embedded arrays, and what lies between its frames. All in SI units. */

const facts = JSON.parse(document.getElementById("facts").textContent);
const arrays = unpack(JSON.parse(document.getElementById("arrays").textContent));
const FRAMES = arrays.frame_time.length;
const STATIONS = arrays.place.length;
const LAST = FRAMES - 1;
[arrays.frame_x, arrays.frame_y] = positions();
const START = arrays.frame_time[0], END = arrays.frame_time[LAST], FILM = arrays.frame_film[LAST];
const SCALARS = ["normal", "tangential", "kinetic", "elastic", "gravity", "stop", "deflection", "gap", "slip_rate"]
  .filter((name) => arrays[`chart_${name}`]);
const ENERGIES = ["kinetic", "elastic", "gravity", "stop"].filter((name) => SCALARS.includes(name));

function unpack(packed) {
  const kinds = { f4: Float32Array, f8: Float64Array, u1: Uint8Array, i2: Int16Array, i4: Int32Array };
  const found = {};
  for (const [name, { type, data, scale }] of Object.entries(packed)) {
    const raw = atob(data);
    const bytes = new Uint8Array(raw.length);
    for (let k = 0; k < raw.length; k++) bytes[k] = raw.charCodeAt(k);
    const values = new kinds[type](bytes.buffer);
    found[name] = scale ? Float32Array.from(values, (code) => decoded(code, scale)) : values;
  }
  return found;
}

/** What a 16-bit multiple of `scale` stands for: beyond the ends everything is infinite. */
function decoded(code, scale) {
  if (Math.abs(code) <= 32766) return code * scale;
  return code === -32768 ? NaN : Math.sign(code) * Infinity;
}

/** Inertial positions of the axis at all frames and stations. */
function positions() {
  const { frame_theta: theta, frame_ux: ux, frame_uy: uy, place } = arrays;
  const x = new Float32Array(ux.length), y = new Float32Array(ux.length);
  for (let k = 0, n = 0; k < FRAMES; k++) {
    const c = Math.cos(theta[k]), s = Math.sin(theta[k]);
    for (let j = 0; j < STATIONS; j++, n++) {
      const along = facts.hub_radius + place[j] + ux[n];
      x[n] = along * c - uy[n] * s;
      y[n] = along * s + uy[n] * c;
    }
  }
  return [x, y];
}

/** Last index (from `low` to `high`) of an ascending array whose value is not above `wanted`; `low` if none is. */
function lastNotAbove(values, wanted, low = 0, high = values.length - 1) {
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (values[middle] <= wanted) low = middle;
    else high = middle - 1;
  }
  return low;
}

/** Place among the frames, a real number: whole at a frame; at an event that of the frame after it. */
function placeOf(values, wanted) {
  const k = lastNotAbove(values, wanted);
  if (k >= LAST) return LAST;
  const span = values[k + 1] - values[k];
  return k + (span > 0 ? Math.min(1, Math.max(0, (wanted - values[k]) / span)) : 0);
}

const placeAtTime = (time) => placeOf(arrays.frame_time, time);
const placeAtFilm = (film) => placeOf(arrays.frame_film, film);

/** Real time that passes in a second of film at normal speed. */
function rateAt(place) {
  const k = Math.floor(place), u = place - k, rates = arrays.frame_rate;
  return u ? (1 - u) * rates[k] + u * rates[k + 1] : rates[k];
}

function newMoment() {
  return {
    x: new Float64Array(STATIONS), y: new Float64Array(STATIONS), sides: newSides(),
    place: 0, time: 0, film: 0, state: 0,
  };
}

/** Angle that the contact point turns about the origin from frame k to the next. */
function turnAfter(k) {
  const a = k * STATIONS + facts.touch, b = a + STATIONS, { frame_x: x, frame_y: y } = arrays;
  return Math.atan2(x[a] * y[b] - y[a] * x[b], x[a] * x[b] + y[a] * y[b]);
}

/** The axis at part `u` between frames k and k + 1: linear in a frame that turns with the contact point. */
function axisBetween(k, u, moment) {
  const turn = turnAfter(k), { frame_x: x, frame_y: y } = arrays;
  const c = Math.cos(turn), s = Math.sin(turn), cu = Math.cos(u * turn), su = Math.sin(u * turn);
  for (let j = 0, a = k * STATIONS, b = a + STATIONS; j < STATIONS; j++, a++, b++) {
    const p = (1 - u) * x[a] + u * (c * x[b] + s * y[b]), q = (1 - u) * y[a] + u * (c * y[b] - s * x[b]);
    moment.x[j] = cu * p - su * q;
    moment.y[j] = su * p + cu * q;
  }
}

/** Forces, energies and distances: between frames from the points of the charts, which are closer. */
function scalarsAt(k, u, moment) {
  const { chart_time: times, frame_point: points } = arrays;
  let a = points[k], v = 0;
  if (u !== 0) {
    a = lastNotAbove(times, moment.time, a, points[k + 1] - 1);
    v = (moment.time - times[a]) / (times[a + 1] - times[a]);
  }
  for (const name of SCALARS) {
    const values = arrays[`chart_${name}`];
    moment[name] = v === 0 ? values[a] : (1 - v) * values[a] + v * values[a + 1];
  }
}

/** Fill `moment` with the run at a place: exactly at a frame, linear between two; no event lies there. */
function momentAt(place, moment) {
  const k = Math.min(Math.floor(place), LAST), u = place - k;
  const mix = (values, a, b) => (u === 0 ? values[a] : (1 - u) * values[a] + u * values[b]);
  moment.place = place;
  moment.time = mix(arrays.frame_time, k, k + 1);
  moment.film = mix(arrays.frame_film, k, k + 1);
  moment.state = arrays.frame_state[k];
  scalarsAt(k, u, moment);
  setSides(k, u, moment.sides);
  const a = k * STATIONS;
  if (u !== 0) {
    axisBetween(k, u, moment);
  } else {
    moment.x.set(arrays.frame_x.subarray(a, a + STATIONS));
    moment.y.set(arrays.frame_y.subarray(a, a + STATIONS));
  }
  return moment;
}

/** Axis with its deviation from the straight line through root and contact point magnified. */
function magnified(moment, factor) {
  const { x, y } = moment, t = facts.touch;
  const dx = (x[t] - x[0]) / arrays.place[t], dy = (y[t] - y[0]) / arrays.place[t];
  const axis = { x: new Float64Array(STATIONS), y: new Float64Array(STATIONS) };
  for (let j = 0; j < STATIONS; j++) {
    const cx = x[0] + arrays.place[j] * dx, cy = y[0] + arrays.place[j] * dy;
    axis.x[j] = cx + factor * (x[j] - cx);
    axis.y[j] = cy + factor * (y[j] - cy);
  }
  return axis;
}
