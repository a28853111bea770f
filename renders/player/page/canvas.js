/* Canvases at the resolution of the screen, and the colours of the theme. */

/* One unit of length on a canvas in CSS pixels: everything grows with the type of the page. */
let unit = 1;

class Surface {
  constructor(id) {
    this.canvas = document.getElementById(id);
    this.context = this.canvas.getContext("2d");
    this.width = this.height = 0;
  }

  /** Fit the bitmap to the element and clear it; false if it is not shown. */
  begin() {
    const box = this.canvas.getBoundingClientRect();
    const dots = Math.max(window.devicePixelRatio || 1, printing ? 3 : 1);
    const wide = Math.round(box.width * dots), high = Math.round(box.height * dots);
    if (wide < 2 || high < 2) return false;
    if (this.canvas.width !== wide || this.canvas.height !== high) {
      this.canvas.width = wide;
      this.canvas.height = high;
    }
    unit = parseFloat(getComputedStyle(document.documentElement).fontSize) / 14;
    this.width = box.width / unit;
    this.height = box.height / unit;
    this.context.setTransform(dots * unit, 0, 0, dots * unit, 0, 0);
    this.context.clearRect(0, 0, this.width, this.height);
    this.context.font = FONT;
    this.context.lineJoin = "round";
    return true;
  }
}

const FONT = '12.5px "Helvetica Neue", "Segoe UI", "DejaVu Sans", Arial, sans-serif';
const NAMES = ["paper", "ink", "dim", "line", "grid", "ground", "edge", "ghost", "halo", "total", "kinetic", "elastic", "gravity", "stop"];
let printing = false;
let colour = {};
let stateColour = [];

/** Read the colours of the theme that is shown; lines in state colours are lighter on a dark ground. */
function readColours() {
  const style = getComputedStyle(document.documentElement);
  colour = Object.fromEntries(NAMES.map((name) => [name, style.getPropertyValue(`--${name}`).trim()]));
  const lighten = Number(style.getPropertyValue("--lighten"));
  stateColour = facts.state_colours.map((hex) => {
    const parts = channels(hex).map((c) => Math.round(c + lighten * (255 - c)));
    return `rgb(${parts.join(",")})`;
  });
}

function channels(hex) {
  return [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16));
}

const RAMP = (() => {
  const stops = facts.colours.map(channels), out = [];
  for (let k = 0; k <= 255; k++) {
    const at = (k / 255) * (stops.length - 1), i = Math.min(Math.floor(at), stops.length - 2), u = at - i;
    out.push(`rgb(${stops[i].map((c, n) => Math.round((1 - u) * c + u * stops[i + 1][n])).join(",")})`);
  }
  return out;
})();

/** Colour of a value of the result that is shown; the ends of the map are those of the run. */
function resultColour(value) {
  const part = Number.isNaN(value) ? 0 : value / result.limit;
  return RAMP[Math.round(127.5 * (1 + Math.min(1, Math.max(-1, part))))];
}

/** Text with a halo of the background, so that it can be read over anything. */
function labelled(c, text, x, y, fill) {
  c.strokeStyle = colour.halo;
  c.lineWidth = 4;
  c.strokeText(text, x, y);
  c.fillStyle = fill;
  c.fillText(text, x, y);
}
