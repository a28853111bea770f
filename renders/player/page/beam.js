/* What both views draw: the beam, the slope, the arrow. A view maps metres to pixels: {scale, x0, y0, thick}; the beam is
   drawn `thick` times as thick as it is, and the slope's surface lies that much lower. */

const toX = (view, x) => view.x0 + view.scale * x;
const toY = (view, y) => view.y0 - view.scale * y;

const NORMAL = [-Math.sin(facts.slope.angle), Math.cos(facts.slope.angle)];
const TANGENT = [Math.cos(facts.slope.angle), Math.sin(facts.slope.angle)];
const TOUCH_RADIUS = facts.touch_radius;

/** Lower and upper edge of the beam in pixels at heights (m) beside its axis, and the direction of its end. */
function edges(view, axis, heights = arrays.radius) {
  const lower = [], upper = [];
  let last = [1, 0];
  for (let j = 0; j < STATIONS; j++) {
    const a = Math.max(j - 1, 0), b = Math.min(j + 1, STATIONS - 1);
    const dx = axis.x[b] - axis.x[a], dy = axis.y[b] - axis.y[a], size = Math.hypot(dx, dy) || 1;
    last = [dx / size, dy / size];
    const r = view.thick * heights[j], nx = (-dy / size) * r, ny = (dx / size) * r;
    lower.push([toX(view, axis.x[j] - nx), toY(view, axis.y[j] - ny)]);
    upper.push([toX(view, axis.x[j] + nx), toY(view, axis.y[j] + ny)]);
  }
  return { lower, upper, heading: Math.atan2(-last[1], last[0]) };
}

/** Outline of the beam with its end: round, flat, or the sphere that a mass at the tip is drawn as. */
function outline(view, axis, { lower, upper, heading }) {
  const path = new Path2D(), end = STATIONS - 1, size = view.scale * view.thick;
  path.moveTo(...lower[0]);
  for (const point of lower) path.lineTo(...point);
  if (!facts.flat_end) {
    const radius = Math.max(arrays.radius[end], facts.mass_radius), covered = Math.asin(arrays.radius[end] / radius);
    const half = facts.mass_radius ? Math.PI - covered : Math.PI / 2; // a sphere begins where it comes out of the beam
    path.arc(toX(view, axis.x[end]), toY(view, axis.y[end]), size * radius, heading + half, heading - half, true);
  }
  for (let j = end; j >= 0; j--) path.lineTo(...upper[j]);
  path.closePath();
  return path;
}

/** Pixels of length in which the colour of the beam may change. */
const SHADE = 4;

/** The beam in the colours of the result, from the lower fibre to the upper one. */
function drawTube(c, view, axis, sides) {
  const side = edges(view, axis), path = outline(view, axis, side), end = STATIONS - 1;
  c.save();
  c.clip(path);
  const wide = c.canvas.width, high = c.canvas.height; // not less than the picture in units of length
  for (let j = 0; j < end; j++) {
    const [p, q, u, v] = [side.lower[j], side.lower[j + 1], side.upper[j], side.upper[j + 1]];
    if (!drawable(p, q, u, v)) continue;
    if (Math.max(p[0], q[0], u[0], v[0]) < 0 || Math.min(p[0], q[0], u[0], v[0]) > wide) continue;
    if (Math.max(p[1], q[1], u[1], v[1]) < 0 || Math.min(p[1], q[1], u[1], v[1]) > high) continue;
    const pieces = Math.max(1, Math.min(200, Math.ceil(Math.hypot(q[0] - p[0], q[1] - p[1]) / SHADE)));
    for (let n = 0; n < pieces; n++) {
      const from = n / pieces, to = (n + 1) / pieces, middle = (from + to) / 2;
      const [low, top] = [sides.lower, sides.upper].map((values) => (1 - middle) * values[j] + middle * values[j + 1]);
      shadePiece(c, between(p, q, from), between(p, q, to), between(u, v, from), between(u, v, to), [low, top], side.heading, 1);
    }
  }
  const cap = view.scale * view.thick * arrays.radius[end] * 1.1, ends = [sides.lower[end], sides.upper[end]];
  if (drawable(side.lower[end], side.upper[end])) {
    shadePiece(c, side.lower[end], side.lower[end], side.upper[end], side.upper[end], ends, side.heading, cap);
  }
  c.restore();
  if (arrays.web) drawFlanges(c, view, axis);
  c.strokeStyle = colour.edge;
  c.lineWidth = 1.1;
  c.stroke(path);
  if (facts.mass_radius) drawMass(c, view, axis);
}

/** A mass at the tip carries no result. */
function drawMass(c, view, axis) {
  c.beginPath();
  c.arc(toX(view, axis.x[STATIONS - 1]), toY(view, axis.y[STATIONS - 1]), view.scale * view.thick * facts.mass_radius, 0, 2 * Math.PI);
  c.fillStyle = colour.ground;
  c.fill();
  c.stroke();
}

/** Edges of an i-beam's flanges, where its web begins. */
function drawFlanges(c, view, axis) {
  const { lower, upper } = edges(view, axis, arrays.web);
  c.strokeStyle = colour.edge;
  c.lineWidth = 0.8;
  for (const line of [lower, upper]) {
    c.beginPath();
    line.forEach((point, j) => (j ? c.lineTo(...point) : c.moveTo(...point)));
    c.stroke();
  }
}

/** Whether points can be drawn: deflections out of any picture are infinite here. */
function drawable(...points) {
  return points.every(([x, y]) => Number.isFinite(x) && Number.isFinite(y));
}

function between(a, b, part) {
  return [(1 - part) * a[0] + part * b[0], (1 - part) * a[1] + part * b[1]];
}

/** One piece across the beam; it reaches a little under the next one, the last one over the cap: no seams. */
function shadePiece(c, p, q, u, v, [low, top], heading, reach) {
  const fill = c.createLinearGradient((p[0] + q[0]) / 2, (p[1] + q[1]) / 2, (u[0] + v[0]) / 2, (u[1] + v[1]) / 2);
  for (let n = 0; n <= 6; n++) fill.addColorStop(n / 6, resultColour(low + (top - low) * (n / 6)));
  const ex = reach * Math.cos(heading), ey = reach * Math.sin(heading);
  c.fillStyle = fill;
  c.beginPath();
  c.moveTo(...p);
  c.lineTo(q[0] + ex, q[1] + ey);
  c.lineTo(v[0] + ex, v[1] + ey);
  c.lineTo(...u);
  c.fill();
}

function drawGhost(c, view, axis, strength) {
  c.globalAlpha = strength;
  c.fillStyle = colour.ghost;
  c.fill(outline(view, axis, edges(view, axis)));
  c.globalAlpha = 1;
}

/** Coordinates of a point in the frame of the slope: along it, and the height of the axis over its line. */
function onSlope(x, y) {
  const dx = x - facts.slope.origin[0], dy = y - facts.slope.origin[1];
  return [dx * TANGENT[0] + dy * TANGENT[1], dx * NORMAL[0] + dy * NORMAL[1]];
}

/** Range of the contact point along the slope while it touches; where it comes closest if it never does. */
function contactRange() {
  const lift = Math.abs(facts.fibre); // of the axis
  let low = Infinity, high = -Infinity, closest = Infinity, there = 0;
  for (let k = 0; k < FRAMES; k++) {
    const at = k * STATIONS + facts.touch, [along, above] = onSlope(arrays.frame_x[at], arrays.frame_y[at]);
    const height = above - lift;
    if (Math.abs(height) < closest) [closest, there] = [Math.abs(height), along];
    if (height > 1e-3 * facts.length) continue;
    low = Math.min(low, along);
    high = Math.max(high, along);
  }
  return low <= high ? [low, high] : [there, there];
}

/** Pixels that the surface lies lower than its true place, because the beam is drawn thicker. */
function lower(view) {
  return (view.thick - 1) * TOUCH_RADIUS * view.scale;
}

/** The drawn slope, the same at every factor. */
function drawWedge(c, view) {
  if (!facts.slope.outline) return;
  const [a, b, ...rest] = facts.slope.outline.map(([x, y]) => [toX(view, x) - lower(view) * NORMAL[0], toY(view, y) + lower(view) * NORMAL[1]]);
  c.beginPath();
  for (const point of [a, b, ...rest]) c.lineTo(...point);
  c.closePath();
  c.fillStyle = colour.ground;
  c.fill();
  c.beginPath();
  c.moveTo(...a);
  c.lineTo(...b);
  c.strokeStyle = colour.edge;
  c.lineWidth = 1.6;
  c.stroke();
}

/** Resultant of the contact force on the beam (N) in the inertial frame. */
function resultant(moment) {
  return [0, 1].map((k) => moment.normal * NORMAL[k] + moment.tangential * TANGENT[k]);
}

const MARK = 3; // radius of the mark at the place of contact

/** Place of contact on the slope's surface, in pixels: below the axis, or at the beam's face. */
function touchPlace(view, moment) {
  const t = facts.touch;
  if (facts.fibre) return facePlace(view, moment, t);
  const below = view.thick * TOUCH_RADIUS;
  return [toX(view, moment.x[t] - below * NORMAL[0]), toY(view, moment.y[t] - below * NORMAL[1])];
}

/** The fibre of a section that touches the slope, in pixels. */
function facePlace(view, axis, j) {
  const a = Math.max(j - 1, 0), b = Math.min(j + 1, STATIONS - 1);
  const dx = axis.x[b] - axis.x[a], dy = axis.y[b] - axis.y[a], across = (view.thick * facts.fibre) / (Math.hypot(dx, dy) || 1);
  return [toX(view, axis.x[j] - across * dy), toY(view, axis.y[j] + across * dx)];
}

/**
 * Mark at the place of contact and, ending just before it outside of the beam, the arrow of the force on the beam;
 * `longest` pixels at the largest force of the run, its length by the root of its size. Returns where it begins.
 */
function drawForce(c, view, moment, longest) {
  const [fx, fy] = resultant(moment), size = Math.hypot(fx, fy);
  if (!(size > 0) || moment.state === 0) return;
  const length = longest * Math.sqrt(size / facts.peak_force), ux = fx / size, uy = -fy / size;
  const [x, y] = touchPlace(view, moment), away = MARK + 2.5;
  const tipX = x - away * ux, tipY = y - away * uy;
  if (length > 6) fillArrow(c, tipX, tipY, ux, uy, length, stateColour[moment.state]);
  c.beginPath();
  c.arc(x, y, MARK, 0, 2 * Math.PI);
  c.fillStyle = colour.paper;
  c.fill();
  c.strokeStyle = colour.ink;
  c.lineWidth = 1.2;
  c.stroke();
  return { x: tipX - length * ux, y: tipY - length * uy, ux: -ux, uy: -uy, size };
}

function fillArrow(c, tipX, tipY, ux, uy, length, tint) {
  const head = Math.min(13, 0.6 * length), shaft = Math.min(2.2, 0.18 * head), wide = 0.42 * head;
  const path = new Path2D();
  for (const [back, aside] of [[length, shaft], [head, shaft], [head, wide], [0, 0], [head, -wide], [head, -shaft], [length, -shaft]]) {
    path.lineTo(tipX - back * ux - aside * uy, tipY - back * uy + aside * ux);
  }
  path.closePath();
  c.strokeStyle = colour.halo;
  c.lineWidth = 2.5;
  c.stroke(path);
  c.fillStyle = tint;
  c.fill(path);
}
