/* Curves that swing faster than pixels can show: a band from least to largest value, and the mean in it.
   The same as renders/envelope.py; the tests hold the two against each other. */

const PERIOD = 6; // pixels: what swings faster is drawn as a band
const TURNS = 5; // half periods in a row make a vibration

/** What stands for a curve (x: pixels, ascending): pieces of its line, and bands. */
function envelope(x, y, swing) {
  const lines = [], bands = [];
  let done = 0;
  for (const [a, b] of fastSpans(x, y, swing)) {
    const first = firstNotBelow(x, a), last = lastNotAbove(x, b) + 1;
    lines.push({ from: done, to: first });
    bands.push(bandOf(x, y, first, last));
    done = last;
  }
  lines.push({ from: done, to: x.length });
  return { lines, bands };
}

function firstNotBelow(values, wanted) {
  let low = 0, high = values.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (values[middle] < wanted) low = middle + 1;
    else high = middle;
  }
  return low;
}

/** Intervals, apart from each other, of swings with periods shorter than PERIOD. */
function fastSpans(x, y, swing) {
  const turns = turningPoints(y, swing), found = [];
  for (let n = 0; n + TURNS < turns.length; n++) {
    const start = x[turns[n]], stop = x[turns[n + TURNS]], last = found.at(-1);
    if (stop - start > 0.5 * PERIOD * TURNS) continue;
    if (last && start <= last[1] + 1) last[1] = stop;
    else found.push([start, stop]);
  }
  return found.filter(([a, b]) => b > a);
}

/** Samples where the curve turns round, each at least `swing` away from the one before. */
function turningPoints(y, swing) {
  const turns = [];
  let newest = 0, up = 0, before = 0;
  const see = (k) => {
    const change = y[k] - y[newest];
    if (up * change >= 0 && (up || Math.abs(change) >= swing)) {
      up = up || Math.sign(change);
      newest = k;
    } else if (Math.abs(change) >= swing) {
      turns.push(newest);
      newest = k;
      up = Math.sign(change);
    }
  };
  let moved = -1;
  for (let k = 0; k + 1 < y.length; k++) {
    const way = Math.sign(y[k + 1] - y[k]);
    if (!way) continue;
    if (before && way !== before) see(moved + 1);
    before = way;
    moved = k;
  }
  if (y.length) see(y.length - 1);
  return turns;
}

/** Band of the samples from `first` up to `last`: low and high at pixels x; the mean at `at`. */
function bandOf(x, y, first, last) {
  const left = Math.floor(x[first]), count = Math.floor(x[last - 1]) + 1 - left;
  const low = new Array(count).fill(Infinity), high = new Array(count).fill(-Infinity), area = new Array(count).fill(0);
  const see = (n, v) => {
    low[n] = Math.min(low[n], v);
    high[n] = Math.max(high[n], v);
  };
  const piece = (xa, ya, xb, yb) => {
    const n = Math.min(count - 1, Math.max(0, Math.floor((xa + xb) / 2) - left));
    see(n, ya);
    see(n, yb);
    area[n] += 0.5 * (xb - xa) * (ya + yb);
  };
  piece(left, y[first], x[first], y[first]);
  for (let k = first; k + 1 < last; k++) {
    let xa = x[k], ya = y[k];
    for (let edge = Math.floor(xa) + 1; edge < x[k + 1]; edge++) {
      const value = y[k] + ((y[k + 1] - y[k]) * (edge - x[k])) / (x[k + 1] - x[k]);
      piece(xa, ya, edge, value);
      [xa, ya] = [edge, value];
    }
    piece(xa, ya, x[k + 1], y[k + 1]);
  }
  piece(x[last - 1], y[last - 1], left + count, y[last - 1]);
  const band = smoothed(left, low, high, area);
  band.at = band.mean.map((_, n) => Math.min(x[last - 1], Math.max(x[first], band.x[n] + 0.5)));
  return band;
}

/** Extremes and means over a period around each pixel; at an edge between two pixels the wider of both. */
function smoothed(left, low, high, area) {
  const near = PERIOD / 2, count = low.length, lows = [], highs = [];
  for (let n = 0; n < count; n++) {
    const a = Math.max(n - near, 0), b = Math.min(n + near + 1, count);
    lows.push(Math.min(...low.slice(a, b)));
    highs.push(Math.max(...high.slice(a, b)));
  }
  const averaged = (values) => values.map((_, n) => {
    const part = values.slice(Math.max(n - near, 0), n + near + 1);
    return part.reduce((sum, v) => sum + v, 0) / part.length;
  });
  const mean = averaged(averaged(area)); // once would leave ripples of periods that do not fit
  const x = [], under = [], over = [];
  for (let n = 0; n <= count; n++) {
    const a = Math.max(n - 1, 0), b = Math.min(n, count - 1);
    x.push(left + n);
    under.push(Math.min(lows[a], lows[b]));
    over.push(Math.max(highs[a], highs[b]));
  }
  return { x, low: under, high: over, mean };
}
