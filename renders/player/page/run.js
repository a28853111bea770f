/* The run as Python computed it, and what lies between two frames. All in SI units. */

const $ = (id) => document.getElementById(id);
const facts = JSON.parse($("facts").textContent);
const KINDS = { u1: Uint8Array, i2: Int16Array, i4: Int32Array, f4: Float32Array, f8: Float64Array };
const run = await unpack();
const LAST = run.time.length - 1, STATIONS = facts.stations.length;
const START = run.time[0], END = run.time[LAST], FILM = run.film[LAST];

async function unpack() {
  const packed = Uint8Array.from(atob($("arrays").textContent), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  const bytes = await new Response(stream).arrayBuffer();
  const read = ([kind, from, count]) => kind === "text"
    ? new TextDecoder().decode(new Uint8Array(bytes, from, count)).split("\n")
    : new KINDS[kind](bytes, from, count);
  return Object.fromEntries(Object.entries(facts.arrays).map(([name, place]) => [name, read(place)]));
}

/** Last index of an ascending array whose value is not above `wanted`; 0 if none is. */
function lastNotAbove(values, wanted) {
  let low = 0, high = values.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (values[middle] <= wanted) low = middle;
    else high = middle - 1;
  }
  return low;
}

/** Place among the frames: whole at a frame, between two while the film plays. */
function placeAtFilm(film) {
  const k = lastNotAbove(run.film, film), span = k < LAST ? run.film[k + 1] - run.film[k] : 0;
  return k + (span > 0 ? Math.min(1, Math.max(0, (film - run.film[k]) / span)) : 0);
}

/** The frame nearest to a time or film time. */
function frameNear(values, wanted) {
  const k = lastNotAbove(values, wanted);
  return k < LAST && values[k + 1] - wanted < wanted - values[k] ? k + 1 : k;
}

/** Column `n` of values with so many columns, linear between frames. */
function mix(values, place, columns = 1, n = 0) {
  const k = Math.floor(place), u = place - k, a = values[k * columns + n];
  return u ? a + u * (values[(k + 1) * columns + n] - a) : a;
}

const pair = (values, place) => [mix(values, place, 2, 0), mix(values, place, 2, 1)];
const stateAt = (place) => run.state[Math.floor(place)];

/** The axis: its deviation from the straight line through root and contact point times `factor`. */
function axisAt(place, factor) {
  const angle = mix(run.theta_time, place), c = Math.cos(angle), s = Math.sin(angle), { stations, touch } = facts;
  const local = stations.map((at, j) => [
    at + facts.displacement_scale * mix(run.ux, place, STATIONS, j), facts.displacement_scale * mix(run.uy, place, STATIONS, j),
  ]);
  const [root, contact] = [local[0], local[touch]];
  return local.map((point, j) => {
    const part = stations[j] / stations[touch];
    const [a, b] = point.map((v, n) => {
      const chord = root[n] + part * (contact[n] - root[n]);
      return chord + factor * (v - chord);
    });
    return [c * (facts.hub_radius + a) - s * b, s * (facts.hub_radius + a) + c * b];
  });
}

/** Places on the scale of colours, 0 to 255, at one side of the beam. */
function coloursAt(place, side) {
  const codes = run[`${show.result}_${side}`];
  return facts.stations.map((_, j) => mix(codes, place, STATIONS, j));
}
