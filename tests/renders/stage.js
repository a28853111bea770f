/* What stands for the page in Node: a canvas whose context notes its texts, and its shapes with their colours. */

const noted = { texts: [], fills: [], strokes: [] };
let path = [], arcs = [], within = null;

class Path2D {
  constructor() { this.points = []; }
  moveTo(x, y) { this.points.push([x, y]); }
  lineTo(x, y) { this.points.push([x, y]); }
  arc() {}
  closePath() {}
}

const shapes = {
  canvas: { width: 800, height: 500 },
  beginPath() { path = []; arcs = []; },
  moveTo(x, y) { path.push([x, y]); },
  lineTo(x, y) { path.push([x, y]); },
  arc(...circle) { arcs.push(circle); },
  rect(...box) { within = box; },
  fillText(text, x, y) { noted.texts.push({ text, x, y }); },
  fillRect(...rect) { noted.fills.push({ rect, tint: this.fillStyle }); },
  fill(shape) { noted.fills.push({ points: shape ? shape.points : path, arcs, tint: this.fillStyle, alpha: this.globalAlpha }); },
  stroke(shape) { noted.strokes.push({ points: shape ? shape.points : path, tint: this.strokeStyle, alpha: this.globalAlpha, within }); },
  measureText: (text) => ({ width: 7 * text.length }),
  createLinearGradient(...ends) {
    if (!ends.every(Number.isFinite)) throw new TypeError("createLinearGradient: a value is not finite"); // as browsers do
    return { ends, stops: [], addColorStop(...stop) { this.stops.push(stop); } };
  },
};
const context = new Proxy(shapes, {
  get: (own, name) => (name in own ? own[name] : () => {}),
  set: (own, name, value) => Boolean((own[name] = value)) || true,
});
const CONTENT = JSON.parse(given);
const window = {};
const getComputedStyle = () => ({ fontSize: "14px", getPropertyValue: (name) => (name === "--lighten" ? "0" : name) });
const document = {
  documentElement: {},
  getElementById: (id) => ({
    textContent: CONTENT[id],
    getContext: () => context,
    getBoundingClientRect: () => ({ width: 800, height: 500 }),
  }),
};

/** What a call draws. */
function note(draw) {
  for (const list of Object.values(noted)) list.length = 0;
  draw();
  return JSON.parse(JSON.stringify(noted));
}
