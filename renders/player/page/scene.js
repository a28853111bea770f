/* The beam, the slope, the force: as a whole with its deflection magnified, and the contact point true to scale.
   A view is {scale, x0, y0, thick}, from metres to pixels: the beam is drawn `thick` times as thick as it is. */

const FONT = '12.5px "Helvetica Neue", "Segoe UI", "DejaVu Sans", Arial, sans-serif';
const PAD = 6; // pixels around the whole
const THIN = 2.2; // pixels: a thinner radius is drawn thicker
const MARK = 3; // radius of the mark at the place of contact
const PIECES = 5; // of one colour along the beam between two stations
const GHOSTS = 4;
const MOST = 400; // times as large as the whole

const scenes = [...document.querySelectorAll("[data-scene]")], inset = $("inset");
let [scene] = scenes; // of the run that is drawn now
const zoom = { by: 1, x: 0, y: 0 }; // how large; the middle of what is seen, in metres from that of the whole
let factor = null; // one of `facts.factors`
let colour = {}; // of the theme

// Canvases -------------------------------------------------------------------------------------------------------

/** One unit of length on a canvas in CSS pixels: everything grows with the type of the page. */
const unit = () => parseFloat(getComputedStyle(document.documentElement).fontSize) / 14;
const sizeOf = (canvas) => [canvas.clientWidth / unit(), canvas.clientHeight / unit()];

/** Context of a canvas, empty, at the resolution of the screen. */
function begin(canvas) {
  const dots = Math.max(window.devicePixelRatio, 1), c = canvas.getContext("2d");
  Object.assign(canvas, { width: canvas.clientWidth * dots, height: canvas.clientHeight * dots });
  c.scale(dots * unit(), dots * unit());
  Object.assign(c, { font: FONT, lineJoin: "round", textAlign: "center", textBaseline: "middle" });
  return c;
}

const toPixels = (view, [x, y]) => [view.x0 + view.scale * x, view.y0 - view.scale * y];

function polygon(c, points, fill) {
  c.beginPath();
  points.forEach((point) => c.lineTo(...point));
  c.closePath();
  c.fillStyle = fill;
  c.fill();
}

function circle(c, at, radius, fill, width = 0) {
  c.beginPath();
  c.arc(...at, radius, 0, 2 * Math.PI);
  c.fillStyle = fill;
  c.fill();
  if (width) outline(c, width);
}

function outline(c, width, path) {
  c.strokeStyle = colour.edge;
  c.lineWidth = width;
  if (path) c.stroke(path);
  else c.stroke();
}

/** Text with a halo of the background, so that it can be read over anything. */
function label(c, text, x, y, fill) {
  c.strokeStyle = colour.background;
  c.lineWidth = 4;
  c.strokeText(text, x, y);
  c.fillStyle = fill;
  c.fillText(text, x, y);
}

// Views ----------------------------------------------------------------------------------------------------------

/** What is seen of the whole; `whole` is the scale without zoom. */
function sceneView() {
  const [width, height] = sizeOf(scene), [left, right, low, high] = factor.bounds;
  const room = [width, height].map((size) => Math.max(1, size - 2 * PAD)); // a low window may leave none
  const whole = Math.min(room[0] / (right - left), room[1] / (high - low)), scale = whole * zoom.by;
  const x = (left + right) / 2 + zoom.x, y = (low + high) / 2 + zoom.y;
  const thick = Math.max(1, Math.ceil(THIN / (scale * Math.max(...facts.radius))));
  return { scale, whole, x0: width / 2 - scale * x, y0: height / 2 + scale * y, thick };
}

const closeContact = () => run.close[Math.floor(show.place)];

/** The place of the contact that is shown; the view follows it only where it would leave the middle of the picture. */
function insetView() {
  const [width, height] = sizeOf(inset), { span, home } = facts.inset, scale = Math.min(width, height) / span;
  const [x, y] = ofContact(run.place, show.place, closeContact()).map((v, n) => v + clamp((home?.[n] ?? v) - v, -0.22 * span, 0.22 * span));
  return { scale, x0: width / 2 - scale * x, y0: height / 2 + scale * y, thick: 1 };
}

/** Draw each run in its own picture, all at the film time of the first one. */
function drawScenes() {
  const { place } = show, film = mix(run.film, place);
  scenes.forEach((canvas, number) => {
    use(number);
    scene = canvas;
    if (number) show.place = placeOf(run.film, film);
    drawScene();
    const state = scenes.length > 1 && canvas.parentElement.previousElementSibling.querySelector(".state");
    if (!state) return;
    state.className = `state ${facts.states[stateAt(show.place)]}`;
    state.textContent = facts.told[stateAt(show.place)];
  });
  use(0);
  [scene] = scenes;
  show.place = place;
}

function drawScene() {
  const c = begin(scene), view = sceneView(), beam = edgesOf(view, axisAt(show.place, factor.factor));
  drawObstacles(c, view);
  drawRoot(c, view);
  const gone = facts.ghosts.filter(([, from]) => from <= show.place).slice(-GHOSTS);
  gone.forEach(([frame], n) => {
    c.globalAlpha = 0.24 - 0.05 * (gone.length - 1 - n);
    c.fillStyle = colour.ghost;
    c.fill(beamPath(view, edgesOf(view, axisAt(frame, factor.factor))));
  });
  drawTrace(c, view);
  drawBeam(c, view, beam);
  const bolt = Math.max(2.5, Math.min(0.6 * facts.radius[0], 0.4 * facts.pin) * view.scale);
  if (facts.clamped === null && !facts.free) circle(c, toPixels(view, [0, 0]), bolt, facts.pinned ? colour.background : colour.edge, 1.6);
  drawZones(c, beam);
  drawApplied(c, view, beam, facts.longest_arrow * view.whole);
  drawForces(c, view, facts.longest_arrow * view.whole, `contact force ${run.force_text[Math.floor(show.place)]}`);
  if (zoom.by > 1) drawScaleBar(c, view, scene);
}

function drawInset() {
  const c = begin(inset), view = insetView(), beam = edgesOf(view, axisAt(show.place, 1));
  drawObstacles(c, view);
  drawTrace(c, view);
  drawBeam(c, view, beam);
  drawZones(c, beam);
  const close = closeContact(), axis = ofContact(run.place, show.place, close);
  circle(c, facts.on_axis ? toPixels(view, axis) : touchPlace(view, close), 2.4, colour.edge);
  drawForces(c, view, 0.36 * Math.min(...sizeOf(inset)));
  drawScaleBar(c, view, inset);
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
  return { lower, upper, heading, points };
}

const toward = (a, b, part) => a.map((v, n) => v + part * (b[n] - v));

/** Where a place along the beam (m) is on a line with a point for each station. */
function between(line, place) {
  const j = clamp(facts.stations.findIndex((s) => s >= place), 1, STATIONS - 1), [a, b] = [facts.stations[j - 1], facts.stations[j]];
  return toward(line[j - 1], line[j], (place - a) / (b - a));
}

/** Outline of the beam with its end: round, flat, or the sphere that a mass at the tip is drawn as. */
function beamPath(view, { lower, upper, heading, points }) {
  const path = new Path2D(), last = facts.radius[STATIONS - 1], end = points[STATIONS - 1];
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
function drawBeam(c, view, edges) {
  const { lower, upper, heading, points } = edges, path = beamPath(view, edges);
  const codes = ["lower", "upper"].map((side) => run[`${show.result}_${side}`]);
  const codesAt = (j) => codes.map((code) => mix(code, show.place, STATIONS, j));
  c.globalAlpha = 1;
  c.save();
  c.clip(path);
  for (let j = 0; j + 1 < STATIONS; j++) {
    const [now, next] = [codesAt(j), codesAt(j + 1)];
    for (let n = 0; n < PIECES; n++) {
      const corner = (edge, part) => toward(edge[j], edge[j + 1], part), [from, to] = [n / PIECES, (n + 1) / PIECES];
      const corners = [corner(lower, from), corner(lower, to), corner(upper, to), corner(upper, from)];
      shade(c, corners, toward(now, next, (from + to) / 2), heading, 1);
    }
  }
  const [p, u] = [lower[STATIONS - 1], upper[STATIONS - 1]], cap = 1.1 * view.scale * view.thick * facts.radius[STATIONS - 1];
  shade(c, [p, p, u, u], codesAt(STATIONS - 1), heading, cap);
  c.restore();
  outline(c, 1.1, path);
  if (facts.mass_radius) circle(c, points[STATIONS - 1], view.scale * view.thick * facts.mass_radius, colour.ground, 1.1);
  facts.masses.forEach(({ place, radius }) => circle(c, between(points, place), view.scale * view.thick * radius, colour.ground, 1.1));
}

/** One piece across the beam; it reaches a little under the next one, the last one over the cap: no seams. */
function shade(c, [p, q, v, u], [low, top], heading, reach) {
  const fill = c.createLinearGradient((p[0] + q[0]) / 2, (p[1] + q[1]) / 2, (u[0] + v[0]) / 2, (u[1] + v[1]) / 2);
  for (let n = 0; n <= 6; n++) fill.addColorStop(n / 6, facts.ramp[Math.round(low + (top - low) * (n / 6))]);
  const [ex, ey] = [reach * Math.cos(heading), reach * Math.sin(heading)];
  polygon(c, [p, [q[0] + ex, q[1] + ey], [v[0] + ex, v[1] + ey], u], fill);
}

/** The last of the path of the contact point, in the colours of the states. */
function drawTrace(c, view) {
  const end = Math.floor(show.place), at = (place) => toPixels(view, onAxis(place, facts.touch));
  c.lineWidth = 1.3;
  c.globalAlpha = 0.75;
  for (let k = run.trace[end]; k <= end; k++) {
    c.beginPath();
    c.strokeStyle = colour.states[run.state[k]];
    c.moveTo(...at(k));
    while (k < end && run.state[k + 1] === run.state[k]) c.lineTo(...at(++k));
    if (k === end) c.lineTo(...at(show.place));
    c.stroke();
  }
  c.globalAlpha = 1;
}

// What stands still ----------------------------------------------------------------------------------------------

/** Slope and obstacles; where the beam is drawn thicker than it is, their surfaces lie that much deeper. */
function drawObstacles(c, view) {
  const deeper = (view.thick - 1) * facts.touch_radius;
  for (const { outline: corners, surface, normal } of facts.obstacles) {
    const at = (point) => toPixels(view, point.map((v, n) => v - deeper * normal[n]));
    polygon(c, corners.map(at), colour.ground);
    c.beginPath();
    surface.forEach((point) => c.lineTo(...at(point)));
    outline(c, 1.6);
  }
}

/** The hub, the wall that holds a clamped beam, or the block under the pin; nothing of a beam that nothing holds. */
function drawRoot(c, view) {
  if (facts.free) return;
  const [x, y] = toPixels(view, [0, 0]), p = facts.pin * view.scale;
  if (facts.hub_radius > 0) return circle(c, [x, y], Math.max(facts.hub_radius * view.scale, 3), colour.ground, 1.2);
  if (facts.clamped !== null) {
    const [s, n] = [Math.sin(facts.clamped), Math.cos(facts.clamped)];  // along the beam in pixels: (n, -s)
    const corner = (along, across) => [x + along * n + across * s, y - along * s + across * n];
    polygon(c, [corner(0, -2 * p), corner(0, 2 * p), corner(-p, 2 * p), corner(-p, -2 * p)], colour.ground);
    return outline(c, 1.2);
  }
  const block = new Path2D();
  block.arc(x, y, 0.75 * p, Math.PI, 0);
  block.lineTo(x + 0.95 * p, y + 1.7 * p);
  block.lineTo(x - 0.95 * p, y + 1.7 * p);
  block.closePath();
  block.rect(x - 1.8 * p, y + 1.7 * p, 3.6 * p, 0.6 * p);
  c.fillStyle = colour.ground;
  c.fill(block);
  outline(c, 1.2, block);
}

function drawScaleBar(c, view, canvas) {
  const [width, height] = sizeOf(canvas);
  const [length, text] = facts.bars.findLast(([metres]) => metres * view.scale <= 0.3 * width) || facts.bars[0];
  const x = 10, y = height - 9, long = length * view.scale;
  c.fillStyle = colour.background;
  c.fillRect(x - 2, y - 3, long + 4, 6);
  c.fillStyle = colour.ink;
  for (const bar of [[x, y - 1, long, 2], [x, y - 4, 1.5, 8], [x + long - 1.5, y - 4, 1.5, 8]]) c.fillRect(...bar);
  c.textAlign = "left";
  label(c, text, x, y - 13, colour.ink);
}

// Force ----------------------------------------------------------------------------------------------------------

/** Where the beam's face touches in a contact, in pixels. */
function touchPlace(view, i) {
  const offset = ofContact(run.offset, show.place, i);
  return toPixels(view, ofContact(run.place, show.place, i).map((v, n) => v + view.thick * offset[n]));
}

/** The face of the beam from the first to the last place that touches an obstacle, as of the frame before. */
function drawZones(c, { lower, upper }) {
  const frame = Math.floor(show.place), count = facts.zone_sides.length;
  facts.zone_sides.forEach((side, i) => {
    const [first, last] = [0, 1].map((n) => run.zone[2 * (frame * count + i) + n]);
    if (!(last > first)) return; // one place alone has its force
    const edge = side > 0 ? upper : lower, inside = facts.stations.filter((s) => s > first && s < last);
    const points = [first, ...inside, last].map((place) => between(edge, place));
    for (const [ink, width] of [[colour.background, 6.5], [colour.states[stateAt(show.place)], 4]]) {
      c.beginPath();
      points.forEach((point) => c.lineTo(...point));
      c.strokeStyle = ink;
      c.lineWidth = width;
      c.stroke();
    }
  });
}

/** The force of each contact; the text stands beside the largest. */
function drawForces(c, view, longest, text) {
  if (stateAt(show.place) === 0) return;
  const sizes = Array.from({ length: facts.contacts }, (_, i) => Math.hypot(...ofContact(run.arrow, show.place, i)));
  const largest = sizes.indexOf(Math.max(...sizes));
  sizes.forEach((size, i) => size && drawForce(c, view, i, longest, i === largest ? text : ""));
}

/** Forces on the beam where they act, in the colour of the ink. */
function drawApplied(c, view, { points }, longest) {
  facts.loaded.forEach((place, i) => {
    const count = facts.loaded.length, [fx, fy] = [0, 1].map((n) => mix(run.applied, show.place, 2 * count, 2 * i + n));
    if (Math.hypot(fx, fy) > 0.03) drawArrow(c, between(points, place), [fx, fy], longest, colour.ink);
  });
}

/** Mark at a place and, ending just before it, the arrow of a force, `longest` pixels at the peak; where it begins. */
function drawArrow(c, [x, y], [fx, fy], longest, tint) {
  const part = Math.hypot(fx, fy), ux = fx / part, uy = -fy / part;
  const from = MARK + 2.5, length = longest * part, head = Math.min(13, 0.6 * length), shaft = Math.min(2.2, 0.18 * head);
  const corners = [[length, shaft], [head, shaft], [head, 0.42 * head], [0, 0], [head, -0.42 * head], [head, -shaft], [length, -shaft]];
  if (length > 6) {
    polygon(c, corners.map(([back, aside]) => [x - (from + back) * ux - aside * uy, y - (from + back) * uy + aside * ux]), tint);
    c.strokeStyle = colour.background;
    c.lineWidth = 1.2;
    c.stroke();
  }
  circle(c, [x, y], MARK, colour.background, 1.2);
  return { ux, uy, tail: from + length };
}

/** The force of a contact, with its text. */
function drawForce(c, view, i, longest, text) {
  const tint = colour.states[stateAt(show.place)], [x, y] = touchPlace(view, i);
  const { ux, uy, tail } = drawArrow(c, [x, y], ofContact(run.arrow, show.place, i), longest, tint);
  if (!text) return;
  c.font = `600 ${FONT}`;
  const [width, height] = sizeOf(scene), half = c.measureText(text).width / 2;
  const at = [x - (tail + half + 8) * ux, y - (tail + 14) * uy];
  if (x < 0 || x > width || y < 0 || y > height) return;
  label(c, text, clamp(at[0], half + 4, width - half - 4), clamp(at[1], 10, height - 10), tint);
  c.font = FONT;
}
