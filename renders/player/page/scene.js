/* The whole beam: ghosts, trace of the contact point, slope, pin, beam, force, colour bar. */

const scene = {
  surface: new Surface("scene"),
  factor: facts.factor,
  bounds: null,
  thick: 1,
};

const BAR = 52; // pixels at the bottom for the colour bar
const LOW = 190; // pixels: a lower picture has no room for it
const ARROW = 0.16; // of the length, at the largest force
const THIN = 2.2; // pixels: a thinner radius is drawn thicker
const STROBE = 0.11 * facts.length; // path of the contact point between two ghosts
const GHOSTS = 4;
const PIN = 0.035 * facts.length;

/** Path length of the contact point up to each frame. */
const travelled = (() => {
  const out = new Float64Array(FRAMES);
  for (let k = 1; k < FRAMES; k++) {
    const a = (k - 1) * STATIONS + facts.touch, b = a + STATIONS;
    const step = Math.hypot(arrays.frame_x[b] - arrays.frame_x[a], arrays.frame_y[b] - arrays.frame_y[a]);
    out[k] = out[k - 1] + (Number.isFinite(step) ? step : 0);
  }
  return out;
})();

/** Take over a deformation factor: what is drawn, and what of the plane has to be seen. */
function setScene(factor) {
  scene.factor = factor;
  const reach = 1.2 * (facts.length + facts.hub_radius);
  const box = { left: -2 * PIN, right: 2 * PIN, low: -2.6 * PIN, high: PIN };
  const include = (x, y, margin) => {
    if (!(Math.abs(x) < reach && Math.abs(y) < reach)) return;
    box.left = Math.min(box.left, x - margin);
    box.right = Math.max(box.right, x + margin);
    box.low = Math.min(box.low, y - margin);
    box.high = Math.max(box.high, y + margin);
  };
  const moment = newMoment(), t = facts.touch;
  for (let k = 0; k < FRAMES; k++) {
    const axis = magnified(momentAt(k, moment), factor);
    for (let j = 0; j < STATIONS; j++) include(axis.x[j], axis.y[j], 2 * Math.max(arrays.radius[j], facts.mass_radius));
    const [fx, fy] = resultant(moment), size = Math.hypot(fx, fy); // the arrow begins outside of the beam
    const arrow = size > 0 ? (1.2 * ARROW * facts.length * Math.sqrt(size / facts.peak_force)) / size : 0;
    if (Number.isFinite(arrow)) include(moment.x[t] - arrow * fx, moment.y[t] - arrow * fy, 0);
  }
  for (const [x, y] of facts.slope.outline || []) include(x, y, 0);
  if (facts.hub_radius) [-1, 1].forEach((s) => include(s * facts.hub_radius, s * facts.hub_radius, 0));
  scene.bounds = box;
}

/** Height of the picture above the colour bar. */
function sceneHeight(height) {
  return height < LOW ? height : height - BAR;
}

/** What is seen: metres to pixels, `whole` the scale without zoom. */
function sceneView(width, height) {
  const { left, right, low, high } = scene.bounds, pad = 6, tall = sceneHeight(height);
  const whole = Math.min((width - 2 * pad) / (right - left), (tall - 2 * pad) / (high - low));
  const all = { scale: whole, x0: width / 2 - (whole * (left + right)) / 2, y0: tall / 2 + (whole * (low + high)) / 2 };
  const view = zoomedView(all, [width / 2, tall / 2]);
  scene.thick = Math.max(1, Math.ceil(THIN / (view.scale * Math.max(...arrays.radius))));
  return { ...view, whole, thick: scene.thick };
}

function drawScene(moment) {
  if (!scene.surface.begin()) return;
  const c = scene.surface.context, { width, height } = scene.surface, view = sceneView(width, height);
  const tall = sceneHeight(height);
  c.save();
  c.beginPath();
  c.rect(0, 0, width, tall);
  c.clip();
  drawWedge(c, view);
  drawPin(c, view);
  drawGhosts(c, view, moment);
  drawTrace(c, view, moment, 3 * facts.length);
  drawTube(c, view, magnified(moment, scene.factor), moment.sides);
  drawHinge(c, view);
  const tail = drawForce(c, view, moment, ARROW * facts.length * view.whole);
  const seen = tail && tail.x > 0 && tail.x < width && tail.y > 0 && tail.y < tall;
  if (seen) labelForce(c, tail, width, tall, stateColour[moment.state]);
  if (zoom.by > 1) drawScaleBar(c, view, width, tall);
  c.restore();
  if (tall < height) drawColourBar(c, width, height);
}

/** The size of the force where its arrow begins. */
function labelForce(c, { x, y, ux, uy, size }, width, height, tint) {
  c.font = `600 ${FONT}`;
  c.textAlign = "center";
  c.textBaseline = "middle";
  const text = `${significant(size, 3)} N`, half = c.measureText(text).width / 2;
  const at = x + (half + 8) * ux;
  labelled(c, text, Math.min(width - half - 4, Math.max(half + 4, at)), Math.min(height - 8, Math.max(10, y + 14 * uy)), tint);
  c.font = FONT;
}

/** Earlier positions at equal distances along the path of the contact point, the older the fainter. */
function drawGhosts(c, view, moment) {
  const k = Math.min(Math.floor(moment.place), LAST), u = moment.place - k;
  const gone = u ? (1 - u) * travelled[k] + u * travelled[k + 1] : travelled[k];
  const past = newMoment(), newest = Math.ceil(gone / STROBE - 0.25) - 1;
  for (let n = Math.max(0, newest - GHOSTS + 1); n <= newest; n++) {
    momentAt(placeOf(travelled, n * STROBE), past);
    drawGhost(c, view, magnified(past, scene.factor), 0.24 - 0.05 * (newest - n));
  }
}

/** Path of the contact point, in the colours of the states; its last `longest` metres. */
function drawTrace(c, view, moment, longest) {
  const end = Math.floor(moment.place), t = facts.touch;
  const at = (k) => [toX(view, arrays.frame_x[k * STATIONS + t]), toY(view, arrays.frame_y[k * STATIONS + t])];
  const onTo = (k, x, y, part) => {
    const turn = part * turnAfter(k), pieces = Math.ceil(Math.abs(turn) / 0.02);
    if (pieces > 1) arcTo(c, view, arrays.frame_x[k * STATIONS + t], arrays.frame_y[k * STATIONS + t], x, y, turn, pieces);
    c.lineTo(toX(view, x), toY(view, y));
  };
  let first = lastNotAbove(travelled, travelled[end] - longest);
  c.lineWidth = 1.3;
  c.globalAlpha = 0.75;
  while (first <= end) {
    const state = arrays.frame_state[first];
    let k = first;
    c.beginPath();
    c.moveTo(...at(k));
    for (; k < end && arrays.frame_state[k + 1] === state; k++) {
      onTo(k, arrays.frame_x[(k + 1) * STATIONS + t], arrays.frame_y[(k + 1) * STATIONS + t], 1);
    }
    if (k === end && moment.place > end) onTo(k, moment.x[t], moment.y[t], moment.place - end);
    c.strokeStyle = stateColour[state];
    c.stroke();
    first = k + 1; // on the other side of an event, at the same place
  }
  c.globalAlpha = 1;
}

/** Points between two of the trace that are far apart: angle and distance from the origin are linear. */
function arcTo(c, view, x0, y0, x1, y1, turn, pieces) {
  const from = Math.atan2(y0, x0), near = Math.hypot(x0, y0), far = Math.hypot(x1, y1);
  for (let n = 1; n < pieces; n++) {
    const r = near + ((far - near) * n) / pieces, angle = from + (turn * n) / pieces;
    c.lineTo(toX(view, r * Math.cos(angle)), toY(view, r * Math.sin(angle)));
  }
}

/** Block under the pin, or the hub. */
function drawPin(c, view) {
  const x = toX(view, 0), y = toY(view, 0), p = PIN * view.scale;
  c.fillStyle = colour.ground;
  c.strokeStyle = colour.edge;
  c.lineWidth = 1.2;
  if (facts.hub_radius > 0) {
    c.beginPath();
    c.arc(x, y, Math.max(facts.hub_radius * view.scale, 3), 0, 2 * Math.PI);
    c.fill();
    c.stroke();
    return;
  }
  c.beginPath();
  c.moveTo(x - 0.75 * p, y);
  c.arc(x, y, 0.75 * p, Math.PI, 0);
  c.lineTo(x + 0.95 * p, y + 1.7 * p);
  c.lineTo(x - 0.95 * p, y + 1.7 * p);
  c.closePath();
  c.fill();
  c.stroke();
  c.fillRect(x - 1.8 * p, y + 1.7 * p, 3.6 * p, 0.6 * p);
  c.strokeRect(x - 1.8 * p, y + 1.7 * p, 3.6 * p, 0.6 * p);
}

/** The bolt, over the beam; a driven root and a hub show a filled one. */
function drawHinge(c, view) {
  const radius = Math.max(2.5, Math.min(0.6 * arrays.radius[0], 0.4 * PIN) * view.scale);
  c.beginPath();
  c.arc(toX(view, 0), toY(view, 0), radius, 0, 2 * Math.PI);
  c.fillStyle = facts.root === "pin" ? colour.paper : colour.edge;
  c.fill();
  c.strokeStyle = colour.edge;
  c.lineWidth = 1.6;
  c.stroke();
}

function drawColourBar(c, width, height) {
  const wide = Math.min(360, width - 80), x = (width - wide) / 2, y = height - BAR + 22, high = 11;
  const ramp = c.createLinearGradient(x, 0, x + wide, 0);
  facts.colours.forEach((tint, k, all) => ramp.addColorStop(k / (all.length - 1), tint));
  c.fillStyle = ramp;
  c.fillRect(x, y, wide, high);
  c.strokeStyle = colour.edge;
  c.lineWidth = 0.8;
  c.strokeRect(x, y, wide, high);
  c.fillStyle = colour.ink;
  c.textAlign = "center";
  c.textBaseline = "alphabetic";
  c.fillText(result.title, width / 2, y - 6);
  c.textBaseline = "top";
  for (const [part, text] of result.ticks) {
    const at = x + (wide * (part + 1)) / 2;
    c.fillRect(at - 0.5, y + high, 1, 3);
    c.fillText(text, at, y + high + 4);
  }
}
