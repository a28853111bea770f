/* The beam, the slope, the force: as a whole with its deflection magnified, and the contact point true to scale.
   A view is {scale, x0, y0, thick}: the beam is drawn `thick` times as thick as it is. */

const scene = { surface: new Surface("scene"), factor: null, thick: 1 };
const inset = new Surface("inset");
const zoom = { by: 1, x: 0, y: 0 }; // how large; the middle of what is seen, in metres from that of the whole

const BAR = 52; // pixels at the bottom for the colour bar,
const LOW = 190; // for which a lower picture has no room
const THIN = 2.2; // pixels: a thinner radius is drawn thicker
const MARK = 3; // radius of the mark at the place of contact
const SHADE = 4; // pixels of length in which the colour of the beam may change
const GHOSTS = 4;
const MOST = 400; // times as large as the whole

/** Height of the picture above the colour bar. */
const above = (height) => (height < LOW ? height : height - BAR);

/** What is seen of the whole: metres to pixels; `whole` is the scale without zoom. */
function sceneView() {
  const { width, height } = scene.surface, [left, right, low, high] = scene.factor.bounds, pad = 6, tall = above(height);
  const whole = Math.min((width - 2 * pad) / (right - left), (tall - 2 * pad) / (high - low)), scale = whole * zoom.by;
  const x = (left + right) / 2 + zoom.x, y = (low + high) / 2 + zoom.y;
  scene.thick = Math.max(1, Math.ceil(THIN / (scale * Math.max(...facts.radius))));
  return { scale, whole, x0: width / 2 - scale * x, y0: tall / 2 + scale * y, thick: scene.thick };
}

/** Enlarge so many times; what lies at an offset, pixels from the middle to the right and downward, stays there. */
function zoomBy(times, [right, down]) {
  const before = zoom.by, { whole } = sceneView();
  zoom.by = Math.min(MOST, Math.max(1, before * times));
  const moved = (1 / before - 1 / zoom.by) / whole;
  moveView(right * moved, -down * moved);
}

/** Move the middle of what is seen by metres, not beyond the picture of the whole. */
function moveView(x, y) {
  const [left, right, low, high] = scene.factor.bounds, free = 0.5 * (1 - 1 / zoom.by);
  const within = (value, most) => Math.min(most, Math.max(-most, value));
  zoom.x = within(zoom.x + x, free * (right - left));
  zoom.y = within(zoom.y + y, free * (high - low));
}

function drawScene() {
  if (!scene.surface.begin()) return;
  const { context: c, width, height } = scene.surface, view = sceneView(), tall = above(height);
  c.save();
  c.beginPath();
  c.rect(0, 0, width, tall);
  c.clip();
  drawSlope(c, view);
  drawPin(c, view);
  const gone = facts.ghosts.filter(([, from]) => from <= show.place).slice(-GHOSTS);
  gone.forEach(([frame], n) => drawGhost(c, view, frame, 0.24 - 0.05 * (gone.length - 1 - n)));
  drawTrace(c, view);
  drawBeam(c, view, axisAt(show.place, scene.factor.factor));
  const bolt = Math.max(2.5, Math.min(0.6 * facts.radius[0], 0.4 * facts.pin) * view.scale);
  circle(c, toPixels(view, [0, 0]), bolt, facts.pinned ? colour.paper : colour.edge, colour.edge, 1.6);
  drawForce(c, view, facts.arrow * view.whole, [width, tall]);
  if (zoom.by > 1) drawScaleBar(c, view, width, tall);
  c.restore();
  if (tall < height) drawColourBar(c, width, height);
}

/** The view follows the contact point only where it would leave the middle of the picture. */
function drawInset() {
  if (!inset.begin()) return;
  const { context: c, width, height } = inset, { span, home } = facts.inset, scale = Math.min(width, height) / span;
  const place = pair(run.contact, show.place), slack = 0.22 * span;
  const [x, y] = place.map((v, n) => v + Math.min(slack, Math.max(-slack, (home || place)[n] - v)));
  const view = { scale, x0: width / 2 - scale * x, y0: height / 2 + scale * y, thick: 1 };
  drawSlope(c, view);
  drawTrace(c, view);
  drawBeam(c, view, axisAt(show.place, 1));
  circle(c, facts.on_axis ? toPixels(view, place) : touchPlace(view), 2.4, colour.edge);
  drawForce(c, view, 0.36 * Math.min(width, height));
  drawScaleBar(c, view, width, height);
}

// Beam -----------------------------------------------------------------------------------------------------------

/** Lower and upper edge of the beam in pixels, and the direction of its end. */
function edgesOf(view, axis) {
  const lower = [], upper = [], points = axis.map((point) => toPixels(view, point));
  let heading = 0;
  points.forEach(([x, y], j) => {
    const [a, b] = [points[Math.max(j - 1, 0)], points[Math.min(j + 1, STATIONS - 1)]];
    heading = Math.atan2(b[1] - a[1], b[0] - a[0]);
    const r = view.scale * view.thick * facts.radius[j], dx = r * Math.sin(heading), dy = r * Math.cos(heading);
    lower.push([x - dx, y + dy]);
    upper.push([x + dx, y - dy]);
  });
  return { lower, upper, heading, end: points[STATIONS - 1] };
}

/** Outline of the beam with its end: round, flat, or the sphere that a mass at the tip is drawn as. */
function outlineOf(view, { lower, upper, heading, end }) {
  const path = new Path2D(), last = facts.radius[STATIONS - 1];
  lower.forEach((point) => path.lineTo(...point));
  if (!facts.flat_end) {
    const radius = Math.max(last, facts.mass_radius), covered = Math.asin(last / radius);
    const half = facts.mass_radius ? Math.PI - covered : Math.PI / 2; // a sphere begins where it comes out of the beam
    path.arc(...end, view.scale * view.thick * radius, heading + half, heading - half, true);
  }
  upper.toReversed().forEach((point) => path.lineTo(...point));
  path.closePath();
  return path;
}

/** The beam in the colours of the result, from the lower fibre to the upper one. */
function drawBeam(c, view, axis) {
  const edges = edgesOf(view, axis), { lower, upper, heading, end } = edges, path = outlineOf(view, edges);
  const [low, top] = ["lower", "upper"].map((side) => coloursAt(show.place, side));
  const between = (a, b, part) => [a[0] + part * (b[0] - a[0]), a[1] + part * (b[1] - a[1])];
  c.save();
  c.clip(path);
  for (let j = 0; j + 1 < STATIONS; j++) {
    const [p, q, u, v] = [lower[j], lower[j + 1], upper[j], upper[j + 1]];
    if (outside(c, [p, q, u, v])) continue;
    const pieces = Math.max(1, Math.min(200, Math.ceil(Math.hypot(q[0] - p[0], q[1] - p[1]) / SHADE)));
    for (let n = 0; n < pieces; n++) {
      const from = n / pieces, to = (n + 1) / pieces, middle = (from + to) / 2;
      const corners = [between(p, q, from), between(p, q, to), between(u, v, to), between(u, v, from)];
      shade(c, corners, low[j] + middle * (low[j + 1] - low[j]), top[j] + middle * (top[j + 1] - top[j]), heading, 1);
    }
  }
  const [p, u] = [lower[STATIONS - 1], upper[STATIONS - 1]], cap = 1.1 * view.scale * view.thick * facts.radius[STATIONS - 1];
  shade(c, [p, p, u, u], low[STATIONS - 1], top[STATIONS - 1], heading, cap);
  c.restore();
  c.strokeStyle = colour.edge;
  c.lineWidth = 1.1;
  c.stroke(path);
  if (facts.mass_radius) circle(c, end, view.scale * view.thick * facts.mass_radius, colour.ground, colour.edge, 1.1);
}

/** Whether a piece lies outside of the picture to one side. */
function outside({ canvas }, points) {
  return [canvas.width, canvas.height].some((most, n) => points.every((p) => p[n] < 0) || points.every((p) => p[n] > most));
}

/** One piece across the beam; it reaches a little under the next one, the last one over the cap: no seams. */
function shade(c, [p, q, v, u], low, top, heading, reach) {
  const fill = c.createLinearGradient((p[0] + q[0]) / 2, (p[1] + q[1]) / 2, (u[0] + v[0]) / 2, (u[1] + v[1]) / 2);
  for (let n = 0; n <= 6; n++) fill.addColorStop(n / 6, facts.ramp[Math.round(low + (top - low) * (n / 6))]);
  const ex = reach * Math.cos(heading), ey = reach * Math.sin(heading);
  c.fillStyle = fill;
  polygon(c, [p, [q[0] + ex, q[1] + ey], [v[0] + ex, v[1] + ey], u]);
  c.fill();
}

/** An earlier position. */
function drawGhost(c, view, frame, strength) {
  c.globalAlpha = strength;
  c.fillStyle = colour.ghost;
  c.fill(outlineOf(view, edgesOf(view, axisAt(frame, scene.factor.factor))));
  c.globalAlpha = 1;
}

/** The last of the path of the contact point, in the colours of the states. */
function drawTrace(c, view) {
  const end = Math.floor(show.place), at = (place) => toPixels(view, pair(run.contact, place));
  c.lineWidth = 1.3;
  c.globalAlpha = 0.75;
  for (let k = run.trace[end]; k <= end; k++) {
    c.beginPath();
    c.strokeStyle = stateColour[run.state[k]];
    c.moveTo(...at(k));
    while (k < end && run.state[k + 1] === run.state[k]) c.lineTo(...at(++k));
    if (k === end) c.lineTo(...at(show.place));
    c.stroke();
  }
  c.globalAlpha = 1;
}

// What stands still ----------------------------------------------------------------------------------------------

/** The slope; where the beam is drawn thicker than it is, its surface lies that much lower. */
function drawSlope(c, view) {
  if (!facts.slope) return;
  const lower = (view.thick - 1) * facts.touch_radius;
  const corners = facts.slope.map((point) => toPixels(view, point.map((v, n) => v - lower * facts.normal[n])));
  polygon(c, corners);
  c.fillStyle = colour.ground;
  c.fill();
  polygon(c, corners.slice(0, 2));
  c.strokeStyle = colour.edge;
  c.lineWidth = 1.6;
  c.stroke();
}

/** Block under the pin, or the hub. */
function drawPin(c, view) {
  const [x, y] = toPixels(view, [0, 0]), p = facts.pin * view.scale;
  if (facts.hub_radius > 0) {
    circle(c, [x, y], Math.max(facts.hub_radius * view.scale, 3), colour.ground, colour.edge, 1.2);
    return;
  }
  c.fillStyle = colour.ground;
  c.strokeStyle = colour.edge;
  c.lineWidth = 1.2;
  c.beginPath();
  c.arc(x, y, 0.75 * p, Math.PI, 0);
  c.lineTo(x + 0.95 * p, y + 1.7 * p);
  c.lineTo(x - 0.95 * p, y + 1.7 * p);
  c.closePath();
  c.fill();
  c.stroke();
  c.fillRect(x - 1.8 * p, y + 1.7 * p, 3.6 * p, 0.6 * p);
  c.strokeRect(x - 1.8 * p, y + 1.7 * p, 3.6 * p, 0.6 * p);
}

function drawColourBar(c, width, height) {
  const wide = Math.min(360, width - 80), x = (width - wide) / 2, y = height - BAR + 22, high = 11;
  const ramp = c.createLinearGradient(x, 0, x + wide, 0), { title, ticks } = facts.results[show.result];
  for (let k = 0; k < 256; k += 5) ramp.addColorStop(k / 255, facts.ramp[k]);
  c.fillStyle = ramp;
  c.fillRect(x, y, wide, high);
  c.strokeStyle = colour.edge;
  c.lineWidth = 0.8;
  c.strokeRect(x, y, wide, high);
  c.fillStyle = colour.ink;
  c.textAlign = "center";
  c.textBaseline = "alphabetic";
  c.fillText(title, width / 2, y - 6);
  c.textBaseline = "top";
  for (const [part, text] of ticks) {
    const at = x + (wide * (part + 1)) / 2;
    c.fillRect(at - 0.5, y + high, 1, 3);
    c.fillText(text, at, y + high + 4);
  }
}

// Force ----------------------------------------------------------------------------------------------------------

/** Where the beam's face touches the slope, in pixels. */
function touchPlace(view) {
  const offset = pair(run.offset, show.place);
  return toPixels(view, pair(run.contact, show.place).map((v, n) => v + view.thick * offset[n]));
}

/** Mark at the place of contact and, ending just before it, the arrow of the force, `longest` pixels at the peak. */
function drawForce(c, view, longest, room) {
  const [fx, fy] = pair(run.arrow, show.place), part = Math.hypot(fx, fy);
  if (!part || stateAt(show.place) === 0) return;
  const tint = stateColour[stateAt(show.place)], [x, y] = touchPlace(view), ux = fx / part, uy = -fy / part;
  const length = longest * part, tip = [x - (MARK + 2.5) * ux, y - (MARK + 2.5) * uy];
  const tail = [tip[0] - length * ux, tip[1] - length * uy];
  if (length > 6) drawArrow(c, tip, [ux, uy], length, tint);
  circle(c, [x, y], MARK, colour.paper, colour.ink, 1.2);
  if (!room || tail.some((v, n) => v < 0 || v > room[n])) return;
  c.font = `600 ${FONT}`;
  c.textAlign = "center";
  c.textBaseline = "middle";
  const text = run.force_text[Math.floor(show.place)], half = c.measureText(text).width / 2;
  const at = [tail[0] - (half + 8) * ux, tail[1] - 14 * uy], inside = (v, least, most) => Math.min(most - least, Math.max(least, v));
  labelled(c, text, inside(at[0], half + 4, room[0]), inside(at[1], 10, room[1]), tint);
  c.font = FONT;
}

function drawArrow(c, [x, y], [ux, uy], length, tint) {
  const head = Math.min(13, 0.6 * length), shaft = Math.min(2.2, 0.18 * head), wide = 0.42 * head;
  const corners = [[length, shaft], [head, shaft], [head, wide], [0, 0], [head, -wide], [head, -shaft], [length, -shaft]];
  polygon(c, corners.map(([back, aside]) => [x - back * ux - aside * uy, y - back * uy + aside * ux]));
  c.strokeStyle = colour.paper;
  c.lineWidth = 2.5;
  c.stroke();
  c.fillStyle = tint;
  c.fill();
}
