/* Canvases at the resolution of the screen, colours of the theme, and views: metres to pixels. */

/* One unit of length on a canvas in CSS pixels: everything grows with the type of the page. */
let unit = 1;
let colour = {};
let stateColour = [];

const FONT = '12.5px "Helvetica Neue", "Segoe UI", "DejaVu Sans", Arial, sans-serif';
const NAMES = ["paper", "ink", "dim", "line", "grid", "ground", "edge", "ghost", "total", "kinetic", "elastic", "gravity", "stop"];

class Surface {
  constructor(id) {
    this.canvas = $(id);
    this.context = this.canvas.getContext("2d");
  }

  /** Fit the bitmap to the element and clear it; false if it is not shown. */
  begin() {
    const box = this.canvas.getBoundingClientRect(), dots = Math.max(window.devicePixelRatio, 1);
    const wide = Math.round(box.width * dots), high = Math.round(box.height * dots);
    if (wide < 2 || high < 2) return false;
    if (this.canvas.width !== wide || this.canvas.height !== high) Object.assign(this.canvas, { width: wide, height: high });
    unit = parseFloat(getComputedStyle(document.documentElement).fontSize) / 14;
    this.width = box.width / unit;
    this.height = box.height / unit;
    this.context.setTransform(dots * unit, 0, 0, dots * unit, 0, 0);
    this.context.clearRect(0, 0, this.width, this.height);
    this.context.font = FONT;
    this.context.lineJoin = "round";
    return true;
  }

  /** Where a pointer is. */
  at({ clientX, clientY }) {
    const box = this.canvas.getBoundingClientRect();
    return [(clientX - box.left) / unit, (clientY - box.top) / unit];
  }
}

function readColours(theme) {
  const style = getComputedStyle(document.documentElement);
  colour = Object.fromEntries(NAMES.map((name) => [name, style.getPropertyValue(`--${name}`).trim()]));
  stateColour = facts.state_colours[theme];
}

const toX = (view, x) => view.x0 + view.scale * x;
const toY = (view, y) => view.y0 - view.scale * y;
const toPixels = (view, [x, y]) => [toX(view, x), toY(view, y)];

function polygon(c, points) {
  c.beginPath();
  points.forEach((point, n) => (n ? c.lineTo(...point) : c.moveTo(...point)));
  c.closePath();
}

function circle(c, [x, y], radius, fill, stroke, width) {
  c.beginPath();
  c.arc(x, y, radius, 0, 2 * Math.PI);
  c.fillStyle = fill;
  c.fill();
  if (!stroke) return;
  c.strokeStyle = stroke;
  c.lineWidth = width;
  c.stroke();
}

/** Text with a halo of the background, so that it can be read over anything. */
function labelled(c, text, x, y, fill) {
  c.strokeStyle = colour.paper;
  c.lineWidth = 4;
  c.strokeText(text, x, y);
  c.fillStyle = fill;
  c.fillText(text, x, y);
}

function drawScaleBar(c, view, width, height) {
  const [length, text] = facts.bars.findLast(([metres]) => metres * view.scale <= 0.3 * width) || facts.bars[0];
  const x = 10, y = height - 9, long = length * view.scale;
  c.strokeStyle = colour.paper;
  c.lineWidth = 6;
  c.strokeRect(x, y - 0.5, long, 1);
  c.fillStyle = colour.ink;
  for (const bar of [[x, y - 1, long, 2], [x, y - 4, 1.5, 8], [x + long - 1.5, y - 4, 1.5, 8]]) c.fillRect(...bar);
  c.textAlign = "left";
  c.textBaseline = "bottom";
  labelled(c, text, x, y - 6, colour.ink);
}
