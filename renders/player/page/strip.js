/* The strip under the slider: states over the time of the film. */

const strip = new Surface("strip");
const THUMB = 7; // half of the slider's thumb, px

function drawStrip() {
  if (!strip.begin()) return;
  const c = strip.context, wide = strip.width - 2 * THUMB;
  const x = (film) => THUMB + (FILM > 0 ? (wide * film) / FILM : 0);
  const { frame_state: states, frame_film: film } = arrays;
  for (let k = 0, start = 0; k < FRAMES; k++) {
    if (k < LAST && states[k + 1] === states[k]) continue;
    const a = x(film[start]), b = Math.max(x(film[k]), a + (states[k] ? 1.5 : 0));
    c.globalAlpha = states[k] ? 1 : 0.35;
    c.fillStyle = stateColour[states[k]];
    c.fillRect(a, 15, b - a, 14);
    start = k + 1;
  }
  c.globalAlpha = 1;
  c.textBaseline = "top";
  c.textAlign = "center";
  const marks = [START, END, ...facts.collisions.map(([start]) => start)], taken = [];
  for (const time of marks) {
    const at = x(filmAt(time)), text = `${fixed(time, time === START ? 0 : 3)} s`, half = c.measureText(text).width / 2;
    const middle = Math.min(Math.max(at, half), strip.width - half);
    if (taken.some(([a, b]) => middle + half + 8 > a && middle - half - 8 < b)) continue;
    taken.push([middle - half, middle + half]);
    c.fillStyle = colour.dim;
    c.fillText(text, middle, 37);
    c.fillRect(at - 0.5, 31, 1, 5);
  }
}
