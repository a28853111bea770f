/* Charts over time: the past solid, the future faint, a cursor between them; and the strip under the slider. */

const FAINT = 0.3;
const BAND = 0.3; // strength of a band over that of its line
const PAD = { left: 62, right: 12, top: 6, bottom: 24 };
const THUMB = 7; // half of the slider's thumb, pixels

const charts = facts.charts.map((chart) => ({ ...chart, surface: new Surface(chart.name), key: "" }));
const strip = new Surface("strip");

/** Times that the charts show: as the reader has zoomed, the whole run, or as they follow the film. */
function timeWindow() {
  return show.window || (show.follow ? pair(run.window, show.place) : [START, END]);
}

function drawChart(chart) {
  if (!chart.surface.begin()) return;
  const { context: c, width, height } = chart.surface, [from, to] = timeWindow(), [low, high] = chart.range;
  const area = { x: PAD.left, y: PAD.top, w: width - PAD.left - PAD.right, h: height - PAD.top - PAD.bottom };
  const x = (t) => area.x + (area.w * (t - from)) / (to - from), y = (v) => area.y + (area.h * (high - v)) / (high - low);
  Object.assign(chart, { area, span: [from, to] });
  drawAxes(c, chart, x, y);
  const key = [width, height, from, to].join();
  if (chart.key !== key) Object.assign(chart, { key, paths: chart.series.map((one) => pathsOf(one, x, y, from, to)) });
  for (const { time, state } of facts.events) {
    if (time < from || time > to) continue;
    const bottom = area.y + area.h, at = x(time);
    polygon(c, [[at, bottom - 1], [at - 3, bottom + 5], [at + 3, bottom + 5]]);
    c.fillStyle = stateColour[state];
    c.fill();
  }
  const now = Math.min(Math.max(x(mix(run.time, show.place)), area.x), area.x + area.w);
  drawPart(c, chart, area.x, now, 1);
  drawPart(c, chart, now, area.x + area.w, FAINT);
  c.fillStyle = colour.ink;
  c.globalAlpha = 0.75;
  c.fillRect(Math.round(now) - 0.5, area.y, 1, area.h);
  c.globalAlpha = 1;
  for (const one of chart.series) {
    const value = mix(run[`${one.name}_now`], show.place);
    if (Number.isFinite(value)) circle(c, [now, y(value)], 3.2, tintOf(one, stateAt(show.place)), colour.paper, 1);
  }
}

const tintOf = (series, state) => (series.colour ? colour[series.colour] : stateColour[state]);

function drawAxes(c, { area, ticks, unit: name, span }, x, y) {
  const line = (...box) => {
    c.fillStyle = colour.grid;
    c.fillRect(...box);
    c.fillStyle = colour.dim;
  };
  c.textBaseline = "top";
  c.textAlign = "center";
  for (const [t, text] of timeTicks(...span, area.w / 85)) {
    line(Math.round(x(t)), area.y, 1, area.h);
    if (x(t) + c.measureText(text).width / 2 < area.x + area.w - 34) c.fillText(text, x(t), area.y + area.h + 6);
  }
  c.textAlign = "right";
  c.fillText("t (s)", area.x + area.w, area.y + area.h + 6);
  c.textBaseline = "middle";
  for (const [v, text] of ticks) {
    line(area.x, Math.round(y(v)), area.w, 1);
    c.fillText(text, area.x - 6, y(v));
  }
  c.save();
  c.translate(11, area.y + area.h / 2);
  c.rotate(-Math.PI / 2);
  c.textAlign = "center";
  c.fillText(name, 0, 0);
  c.restore();
}

/** About `count` round times, and their labels: the reader may zoom to any stretch. */
function timeTicks(from, to, count) {
  const raw = (to - from) / Math.max(count, 1), power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= 0.75 * raw);
  const first = Math.ceil(from / step - 1e-9), last = Math.floor(to / step + 1e-9);
  const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  return Array.from({ length: last - first + 1 }, (_, n) => [(first + n) * step, ((first + n) * step).toFixed(decimals)]);
}

/** What is drawn of a series, [{line, band, tint}], one for each colour; with bands where the chart shows much time. */
function pathsOf(series, x, y, from, to) {
  const { name } = series, seen = (to - from) / (END - START), close = seen < 0.25 * facts.level_widths.at(-1);
  const level = facts.level_widths.findLastIndex((part) => part >= 0.99 * seen);
  const bands = close ? null : facts.levels[name][level], prefix = bands ? `${name}_${level}` : "";
  const [times, values, states] = prefix
    ? [run[`${prefix}_time`], run[`${prefix}_value`], run[`${prefix}_state`]]
    : [run.chart_time, run[`${name}_value`], run.chart_state];
  const paths = new Map();
  const pathFor = (state) => {
    const tint = series.colour ? 0 : state;
    if (!paths.has(tint)) paths.set(tint, { line: new Path2D(), band: new Path2D(), state });
    return paths.get(tint);
  };
  const first = Math.max(0, lastNotAbove(times, from) - 1), last = Math.min(times.length - 1, lastNotAbove(times, to) + 1);
  let before = null; // the point that the line goes on from: a change of state belongs to the state after it
  for (let k = first; k <= last; k++) {
    const point = [x(times[k]), y(values[k])];
    if (!Number.isFinite(point[1])) {
      before = null;
      continue;
    }
    const path = pathFor(states[k]);
    if (!before || before.path !== path) path.line.moveTo(...(before?.point ?? point));
    path.line.lineTo(...point);
    before = { path, point };
  }
  bands?.states.forEach((state, n) => {
    const { band } = pathFor(state), [a, b] = [bands.starts[n], bands.starts[n + 1]];
    const [edge, low, high] = ["edge", "low", "high"].map((side) => run[`${prefix}_${side}`]);
    for (let k = a; k < b; k++) band[k === a ? "moveTo" : "lineTo"](x(edge[k]), y(low[k]));
    for (let k = b - 1; k >= a; k--) band.lineTo(x(edge[k]), y(high[k]));
    band.closePath();
  });
  return [...paths.values()];
}

function drawPart(c, chart, from, to, strength) {
  c.save();
  c.beginPath();
  c.rect(from, chart.area.y - 2, to - from, chart.area.h + 4);
  c.clip();
  chart.series.forEach((one, n) => {
    c.setLineDash(one.dashed ? [5, 3] : []);
    c.lineWidth = one.name === "total" ? 2 : 1.5;
    for (const { line, band, state } of chart.paths[n]) {
      c.fillStyle = c.strokeStyle = tintOf(one, state);
      c.globalAlpha = BAND * strength;
      c.fill(band);
      c.globalAlpha = strength;
      c.stroke(line);
    }
  });
  c.restore();
}

/** States over the time of the film; times of the start, the end and the beginnings of collisions. */
function drawStrip() {
  if (!strip.begin()) return;
  const { context: c, width } = strip, x = (frame) => THUMB + ((width - 2 * THUMB) * run.film[frame]) / (FILM || 1);
  for (let k = 0, start = 0; k <= LAST; k++) {
    const state = run.state[k];
    if (k < LAST && run.state[k + 1] === state) continue;
    c.globalAlpha = state ? 1 : 0.35;
    c.fillStyle = stateColour[state];
    c.fillRect(x(start), 15, Math.max(x(k) - x(start), state ? 1.5 : 0), 14);
    start = k + 1;
  }
  c.globalAlpha = 1;
  c.textBaseline = "top";
  c.textAlign = "center";
  c.fillStyle = colour.dim;
  const taken = [];
  for (const time of [START, END, ...facts.collisions]) {
    const at = x(frameNear(run.time, time)), text = `${time.toFixed(time === START ? 0 : 3)} s`, half = c.measureText(text).width / 2;
    const middle = Math.min(Math.max(at, half), width - half);
    if (taken.some(([a, b]) => middle + half + 8 > a && middle - half - 8 < b)) continue;
    taken.push([middle - half, middle + half]);
    c.fillText(text, middle, 37);
    c.fillRect(at - 0.5, 31, 1, 5);
  }
}
