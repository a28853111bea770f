/* The runs as Python computed them, and what lies between two frames. All in SI units. */

const $ = (id) => document.getElementById(id);
const KINDS = { u1: Uint8Array, i4: Int32Array, f4: Float32Array, f8: Float64Array };
const runs = await Promise.all([...document.querySelectorAll("[data-facts]")].map(unpack));
let facts, run, LAST, STATIONS; // of the run that is drawn now, otherwise of the first one
use(0);
const FILM = run.film[LAST];

function use(number) {
  ({ facts, run } = runs[number]);
  [LAST, STATIONS] = [run.time.length - 1, facts.stations.length];
}

async function unpack(element) {
  const facts = JSON.parse(element.textContent);
  const packed = Uint8Array.from(atob(element.nextElementSibling.textContent), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  const bytes = await new Response(stream).arrayBuffer();
  const read = ([kind, from, count]) => kind === "text"
    ? new TextDecoder().decode(new Uint8Array(bytes, from, count)).split("\n")
    : new KINDS[kind](bytes, from, count);
  return { facts, run: Object.fromEntries(Object.entries(facts.arrays).map(([name, place]) => [name, read(place)])) };
}

const clamp = (value, least, most) => Math.min(most, Math.max(least, value));

/** Place of a value among the frames of an ascending array: whole at a frame, else between two. */
function placeOf(values, wanted) {
  let low = 0, high = LAST;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (values[middle] <= wanted) low = middle;
    else high = middle - 1;
  }
  const span = low < LAST ? values[low + 1] - values[low] : 0;
  return low + (span > 0 ? clamp((wanted - values[low]) / span, 0, 1) : 0);
}

/** Column `n` of values with so many columns, linear between frames. */
function mix(values, place, columns = 1, n = 0) {
  const k = Math.floor(place), u = place - k, a = values[k * columns + n];
  return u ? a + u * (values[(k + 1) * columns + n] - a) : a;
}

/** (x, y) of the axis at station `j`. */
const onAxis = (place, j) => [0, 1].map((n) => mix(run.axis, place, 2 * STATIONS, 2 * j + n));
/** (x, y) of one contact. */
const ofContact = (values, place, i) => [0, 1].map((n) => mix(values, place, 2 * facts.contacts, 2 * i + n));
const stateAt = (place) => run.state[Math.floor(place)];

/** The axis, (x, y) at the stations: its deviation from the straight line through root and contact point times `factor`. */
function axisAt(place, factor) {
  const root = onAxis(place, 0), contact = onAxis(place, facts.touch);
  return facts.stations.map((station, j) => onAxis(place, j).map((v, n) => {
    const chord = root[n] + (station / facts.stations[facts.touch]) * (contact[n] - root[n]);
    return chord + factor * (v - chord);
  }));
}
