/* Charts over time: the past solid, the future faint, a cursor between them. */

const FAINT = 0.3;
const BAND = 0.3; // strength of a band over that of its line
const PAD = { left: 62, right: 12, top: 6, bottom: 24 };
const MARGIN = 0.12; // of a collision, shown on both sides of it

/** What a chart draws; a series without `colour` has those of the states. */
function chartSpecs() {
  const touch = facts.contact && facts.peak_force > 0;
  const force = [
    { name: "normal", label: "normal", unit: "N" },
    { name: "tangential", label: "tangential", unit: "N", dash: [5, 3] },
  ];
  const bending = [{ name: "deflection", label: "of the tip", unit: "mm", factor: 1e3, colour: "elastic" }];
  const energies = ENERGIES.filter((name) => arrays[`chart_${name}`].some((v) => v !== 0)).map((name) => ({ name, label: name, unit: "J", colour: name }));
  energies.push({ name: "total", label: "total", unit: "J", colour: "total", wide: 2 });
  return [
    newChart("force", touch ? "Contact force" : "Deflection", touch ? force : bending),
    newChart("energy", "Energy", energies),
  ];
}

function newChart(id, title, series) {
  const unit = series[0].unit;
  for (const one of series) one.values = scaled(one);
  const chart = { surface: new Surface(id), title, unit, series, paths: null, key: "", window: null };
  let low = 0, high = 0;
  for (const { values } of series) {
    for (const v of values) {
      if (!Number.isFinite(v)) continue;
      low = Math.min(low, v);
      high = Math.max(high, v);
    }
  }
  if (!(high > low)) high = low + 1;
  chart.range = [low - (low < 0 ? 0.05 * (high - low) : 0), high + 0.06 * (high - low)];
  return chart;
}

function scaled({ name, factor = 1 }) {
  if (name === "total") return arrays.chart_time.map((_, k) => ENERGIES.reduce((sum, e) => sum + arrays[`chart_${e}`][k], 0));
  return factor === 1 ? arrays[`chart_${name}`] : arrays[`chart_${name}`].map((v) => factor * v);
}

function valueNow(moment, { name, factor = 1 }) {
  return name === "total" ? ENERGIES.reduce((sum, e) => sum + moment[e], 0) : factor * moment[name];
}

/** Times shown: the whole run, and closer and closer the collision that the film slows down for. */
function timeWindow(moment, follow) {
  let window = [START, END];
  if (!follow) return window;
  for (const [start, end] of facts.collisions) {
    const margin = MARGIN * (end - start) + 0.002 * (END - START);
    const close = [Math.max(START, start - margin), Math.min(END, end + margin)];
    const from = filmAt(close[0]), to = filmAt(close[1]), fade = 1.2;
    const part = Math.min(smoothstep(from - fade, from, moment.film), 1 - smoothstep(to, to + fade, moment.film));
    if (part <= 0) continue;
    const whole = END - START, narrow = close[1] - close[0];
    if (narrow > 0.7 * whole) continue;
    const width = whole ** (1 - part) * narrow ** part, share = (whole - width) / (whole - narrow);
    window = [START + (close[0] - START) * share, END + (close[1] - END) * share];
  }
  return window;
}

function filmAt(time) {
  const place = placeAtTime(time), k = Math.floor(place), u = place - k;
  return u ? (1 - u) * arrays.frame_film[k] + u * arrays.frame_film[k + 1] : arrays.frame_film[k];
}

function drawChart(chart, moment, window) {
  if (!chart.surface.begin()) return;
  const c = chart.surface.context, { width, height } = chart.surface;
  const area = { x: PAD.left, y: PAD.top, w: width - PAD.left - PAD.right, h: height - PAD.top - PAD.bottom };
  if (area.w < 20 || area.h < 20) return;
  chart.window = window;
  chart.area = area;
  const x = (t) => area.x + (area.w * (t - window[0])) / (window[1] - window[0]);
  const y = (v) => area.y + (area.h * (chart.range[1] - v)) / (chart.range[1] - chart.range[0]);
  drawAxes(c, chart, area, x, y);
  const key = [width, height, ...window].join();
  if (chart.key !== key) {
    chart.paths = chart.series.map((one) => seriesPaths(one, x, y, window));
    chart.key = key;
  }
  const now = Math.min(Math.max(x(moment.time), area.x), area.x + area.w);
  drawEventMarks(c, area, x, window);
  drawPart(c, chart, area, area.x, now, 1);
  drawPart(c, chart, area, now, area.x + area.w, FAINT);
  drawCursor(c, chart, area, moment, now, y);
}

const PREFIXES = [[1e10, 1e9, "G"], [1e7, 1e6, "M"], [1e4, 1e3, "k"], [0, 1, ""]]; // from which value on, size, name

/** Size and name of the unit in which the labels of an axis stay short. */
function shortUnit({ range, unit }) {
  const largest = Math.max(...range.map(Math.abs));
  const [, size, prefix] = (unit !== "mm" && PREFIXES.find(([least]) => largest >= least)) || PREFIXES.at(-1);
  return [size, prefix + unit];
}

function drawAxes(c, chart, area, x, y) {
  const [size, unit] = shortUnit(chart);
  const across = ticks(...chart.window, area.w / 85), up = ticks(...chart.range.map((v) => v / size), area.h / 34);
  c.lineWidth = 1;
  c.textBaseline = "top";
  for (const t of across.values) {
    c.fillStyle = colour.grid;
    c.fillRect(Math.round(x(t)), area.y, 1, area.h);
    c.fillStyle = colour.dim;
    const text = fixed(t, across.decimals), half = c.measureText(text).width / 2;
    c.textAlign = "center";
    if (x(t) + half < area.x + area.w - 34) c.fillText(text, x(t), area.y + area.h + 6);
  }
  c.textAlign = "right";
  c.fillText("t (s)", area.x + area.w, area.y + area.h + 6);
  c.textBaseline = "middle";
  for (const v of up.values) {
    c.fillStyle = Math.abs(v) < 1e-12 ? colour.line : colour.grid;
    c.fillRect(area.x, Math.round(y(size * v)), area.w, 1);
    c.fillStyle = colour.dim;
    c.fillText(fixed(v, up.decimals), area.x - 6, y(size * v));
  }
  c.save();
  c.translate(11, area.y + area.h / 2);
  c.rotate(-Math.PI / 2);
  c.textAlign = "center";
  c.fillText(unit, 0, 0);
  c.restore();
}

/** What is drawn of a series inside the window: [{line, band, tint}], one for each colour. */
function seriesPaths(one, x, y, window) {
  const times = arrays.chart_time, states = arrays.chart_state, found = new Map();
  const from = Math.max(0, lastNotAbove(times, window[0]) - 1), to = lastNotAbove(times, window[1]) + 2;
  const at = [], value = [], tints = [];
  for (let k = from; k < Math.min(to, times.length); k++) {
    at.push(x(times[k]));
    value.push(y(one.values[k]));
    tints.push(one.colour ?? states[k]);
  }
  const paths = (tint) => {
    if (!found.has(tint)) found.set(tint, { line: new Path2D(), band: new Path2D(), tint });
    return found.get(tint);
  };
  const whole = { lines: [{ from: 0, to: at.length }], bands: [] };
  const { lines, bands } = value.every(Number.isFinite) ? envelope(at, value, 1) : whole;
  let last = null; // the point that the next line starts from
  lines.forEach((piece, n) => {
    last = addLine(paths, at, value, tints, piece, last);
    if (bands[n]) last = addBand(paths(bandTint(tints, piece.to, lines[n + 1].from)), bands[n], last);
  });
  return [...found.values()];
}

/** A stretch of the curve itself; a change of state belongs to the state after it. */
function addLine(paths, at, value, tints, { from, to }, last) {
  let point = last, open = null;
  for (let k = from; k < to; k++) {
    if (!Number.isFinite(value[k])) {
      point = open = null;
      continue;
    }
    const { line } = paths(tints[k]);
    if (point && open !== tints[k]) line.moveTo(...point);
    if (point) line.lineTo(at[k], value[k]);
    else line.moveTo(at[k], value[k]);
    point = [at[k], value[k]];
    open = tints[k];
  }
  return point;
}

/** A vibration: its band, and its mean as the line. */
function addBand({ line, band }, { x, low, high, at, mean }, last) {
  x.forEach((edge, n) => (n ? band.lineTo(edge, low[n]) : band.moveTo(edge, low[n])));
  for (let n = x.length - 1; n >= 0; n--) band.lineTo(x[n], high[n]);
  band.closePath();
  line.moveTo(...(last || [at[0], mean[0]]));
  mean.forEach((value, n) => line.lineTo(at[n], value));
  return [at.at(-1), mean.at(-1)];
}

/** Colour of a vibration: the one of the series, or of the state that most of its samples have. */
function bandTint(tints, from, to) {
  const counts = new Map();
  for (let k = from; k < to; k++) counts.set(tints[k], (counts.get(tints[k]) || 0) + 1);
  return [...counts].reduce((most, one) => (one[1] > most[1] ? one : most))[0];
}

function drawPart(c, chart, area, from, to, strength) {
  if (to <= from) return;
  c.save();
  c.beginPath();
  c.rect(from, area.y - 2, to - from, area.h + 4);
  c.clip();
  chart.series.forEach((one, n) => {
    c.setLineDash(one.dash || []);
    c.lineWidth = one.wide || 1.5;
    for (const { line, band, tint } of chart.paths[n]) {
      c.fillStyle = c.strokeStyle = typeof tint === "number" ? stateColour[tint] : colour[tint];
      c.globalAlpha = BAND * strength;
      c.fill(band);
      c.globalAlpha = strength;
      c.stroke(line);
    }
  });
  c.restore();
}

/** Events as small triangles on the axis, in the colour of the state after them. */
function drawEventMarks(c, area, x, window) {
  const bottom = area.y + area.h;
  for (const event of facts.events) {
    if (event.time < window[0] || event.time > window[1]) continue;
    const at = x(event.time);
    c.fillStyle = stateColour[event.state];
    c.beginPath();
    c.moveTo(at, bottom - 1);
    c.lineTo(at - 3, bottom + 5);
    c.lineTo(at + 3, bottom + 5);
    c.fill();
  }
}

function drawCursor(c, chart, area, moment, now, y) {
  c.fillStyle = colour.ink;
  c.globalAlpha = 0.75;
  c.fillRect(Math.round(now) - 0.5, area.y, 1, area.h);
  c.globalAlpha = 1;
  for (const one of chart.series) {
    const value = valueNow(moment, one);
    if (!Number.isFinite(value)) continue;
    c.beginPath();
    c.arc(now, y(value), 3.2, 0, 2 * Math.PI);
    c.fillStyle = one.colour ? colour[one.colour] : stateColour[moment.state];
    c.fill();
    c.strokeStyle = colour.halo;
    c.lineWidth = 1;
    c.stroke();
  }
}

/** Legend with the values at the cursor. */
function writeLegend(chart, moment) {
  const host = document.getElementById(`${chart.surface.canvas.id}-legend`);
  if (!host.childElementCount) {
    host.append(made("b", `${chart.title} (${chart.unit})`));
    chart.labels = chart.series.map((one) => {
      const item = made("span", ""), swatch = made("i", "");
      if (one.dash) swatch.className = "dashed";
      const number = made("span", "");
      item.append(swatch, `${one.label} `, number);
      host.append(item);
      return { swatch, number, one };
    });
  }
  for (const { swatch, number, one } of chart.labels) {
    swatch.style.borderColor = one.colour ? colour[one.colour] : stateColour[moment.state];
    number.textContent = one.unit === "J" ? fixed(valueNow(moment, one), energyDecimals) : significant(valueNow(moment, one), 4);
  }
}

const energyDecimals = (() => {
  let largest = 0;
  for (const name of ENERGIES) {
    for (const v of arrays[`chart_${name}`]) if (Number.isFinite(v)) largest = Math.max(largest, Math.abs(v));
  }
  return Math.min(6, Math.max(0, 3 - Math.floor(Math.log10(largest || 1))));
})();

function made(tag, text) {
  const element = document.createElement(tag);
  element.textContent = text;
  return element;
}
