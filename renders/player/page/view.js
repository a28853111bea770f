/* What part of the picture is seen: zoom and pan, the same for a picture of any size. */

const MOST = 400; // times as large as the whole
const zoom = { by: 1, x: 0, y: 0 }; // how large; the middle of what is seen, in metres from that of the whole

/** The view of the whole as it is zoomed: `middle` is the pixel in its middle. */
function zoomedView(whole, middle) {
  const scale = whole.scale * zoom.by, [mx, my] = middle;
  const x = (mx - whole.x0) / whole.scale + zoom.x, y = (whole.y0 - my) / whole.scale + zoom.y; // metres in the middle
  return { scale, x0: mx - scale * x, y0: my + scale * y };
}

/** Enlarge so many times; what lies at an offset, pixels from the middle to the right and downward, stays there. */
function zoomBy(times, whole, [right, down] = [0, 0]) {
  const before = zoom.by;
  zoom.by = Math.min(MOST, Math.max(1, before * times));
  const moved = (1 / before - 1 / zoom.by) / whole;
  moveView(right * moved, -down * moved);
}

/** Move the middle of what is seen by metres, not beyond the picture of the whole. */
function moveView(x, y) {
  const { left, right, low, high } = scene.bounds, free = 0.5 * (1 - 1 / zoom.by);
  const within = (value, most) => Math.min(most, Math.max(-most, value));
  zoom.x = within(zoom.x + x, free * (right - left));
  zoom.y = within(zoom.y + y, free * (high - low));
}

function seeAll() {
  Object.assign(zoom, { by: 1, x: 0, y: 0 });
}
