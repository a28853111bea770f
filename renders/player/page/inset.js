/* The contact point at true scale: nothing is magnified but the view itself. */

const inset = { surface: new Surface("inset"), home: null };

/** Place of the slope where contacts happen, which the view keeps to while the beam is near. */
inset.home = (() => {
  const [low, high] = contactRange(), at = 0.5 * (low + high);
  return [0, 1].map((k) => facts.slope.origin[k] + at * TANGENT[k] + Math.abs(facts.fibre) * NORMAL[k]);
})();

function insetView(moment, width, height) {
  const span = Math.max(11 * TOUCH_RADIUS, 0.05 * facts.length);
  const scale = Math.min(width, height) / span, t = facts.touch;
  const slack = 0.22 * span, tip = [moment.x[t], moment.y[t]];
  // the view follows the contact point only where it would leave the middle of the picture
  const home = facts.contact ? inset.home : tip;
  const [x, y] = tip.map((value, k) => value + Math.min(slack, Math.max(-slack, home[k] - value)));
  return { scale, x0: width / 2 - scale * x, y0: height / 2 + scale * y, thick: 1 };
}

function drawInset(moment) {
  if (!inset.surface.begin()) return;
  const c = inset.surface.context, { width, height } = inset.surface, view = insetView(moment, width, height);
  drawWedge(c, view);
  drawTrace(c, view, moment, facts.length);
  const axis = magnified(moment, 1);
  drawTube(c, view, axis, moment.sides);
  drawContactPoint(c, view, axis);
  drawForce(c, view, moment, 0.36 * Math.min(width, height));
  drawScaleBar(c, view, width, height);
}

/** The contact point of the model, on the axis or on the beam's face. */
function drawContactPoint(c, view, axis) {
  const t = facts.touch, place = facts.fibre ? facePlace(view, axis, t) : [toX(view, axis.x[t]), toY(view, axis.y[t])];
  c.beginPath();
  c.arc(...place, 2.4, 0, 2 * Math.PI);
  c.fillStyle = colour.edge;
  c.fill();
}

function drawScaleBar(c, view, width, height) {
  const wanted = (0.3 * width) / view.scale, power = 10 ** Math.floor(Math.log10(wanted));
  const size = [5, 2, 1].map((m) => m * power).find((s) => s <= wanted) || power;
  const x = 10, y = height - 9, long = size * view.scale;
  c.strokeStyle = colour.halo;
  c.lineWidth = 6;
  c.strokeRect(x, y - 0.5, long, 1);
  c.fillStyle = colour.ink;
  c.fillRect(x, y - 1, long, 2);
  c.fillRect(x, y - 4, 1.5, 8);
  c.fillRect(x + long - 1.5, y - 4, 1.5, 8);
  c.textAlign = "left";
  c.textBaseline = "bottom";
  labelled(c, size < 1 ? `${significant(size * 1e3, 1)} mm` : `${significant(size, 1)} m`, x, y - 6, colour.ink);
}
