/* Numbers as text. */

/** Fixed decimals, with a proper minus sign and no minus before zero. */
function fixed(value, decimals) {
  if (!Number.isFinite(value)) return "–";
  const text = value.toFixed(decimals);
  return Number(text) === 0 ? text.replace("-", "") : text.replace("-", "−");
}

/** Significant digits without exponents between 1e-4 and 1e6. */
function significant(value, digits) {
  if (!Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const power = Math.floor(Math.log10(Math.abs(value)));
  if (power < -4 || power > 5) return value.toExponential(digits - 1).replaceAll("-", "−").replace("e+", "e");
  return fixed(value, Math.max(0, digits - 1 - power));
}

/** A number without trailing zeros. */
function short(value) {
  return String(Number(value.toPrecision(3)));
}

/** Real time over film time in words. */
function rateText(rate) {
  if (!(rate > 0)) return "";
  if (Math.abs(rate - 1) < 0.005) return "real time";
  if (rate > 1) return `${Number(rate.toPrecision(2))}× real time`;
  return `1/${Number((1 / rate).toPrecision(2))} of real time`;
}

/** About `count` round numbers in [low, high]; {values, decimals}. */
function ticks(low, high, count) {
  const raw = (high - low) / Math.max(count, 1);
  if (!(raw > 0)) return { values: [low], decimals: 0 };
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= raw * 0.75);
  const first = Math.ceil(low / step - 1e-9), last = Math.floor(high / step + 1e-9);
  const values = [];
  for (let k = first; k <= last; k++) values.push(k * step);
  return { values, decimals: Math.max(0, -Math.floor(Math.log10(step) + 1e-9)) };
}

/** 0 below `from`, 1 above `to`, smooth between. */
function smoothstep(from, to, value) {
  const u = Math.min(1, Math.max(0, (value - from) / (to - from)));
  return u * u * (3 - 2 * u);
}
