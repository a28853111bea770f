/* Zoom and pan by wheel, fingers, mouse, buttons and keys: the scene in the plane, the charts in time. */

const STEP = 1.5; // of a button or a key
const PART = 0.15; // of what is seen: a move by a key
const NEAR = 22; // pixels: half of what a finger needs
const timeZoom = { window: null, kept: false }; // times (s) that the charts show, as zoomed or while one is pressed

/** Times that the charts show: as the reader has zoomed, the whole run, or as they follow the film. */
function zoomedWindow(moment) {
  return timeZoom.window || timeWindow(moment, show.follow);
}

function sceneNow() {
  return sceneView(scene.surface.width, scene.surface.height);
}

/** Zoom the scene about a pointer; without one about the contact point where it is seen, or the middle. */
function zoomScene(times, pointer) {
  const view = sceneNow();
  zoomBy(times, view.whole, pointer ? offsetOf(pointer) : offsetOfContact(view));
  showZoom();
}

/** Pixels from the middle of the scene, to the right and downward. */
function offsetOf({ clientX, clientY }) {
  const box = scene.surface.canvas.getBoundingClientRect(), { width, height } = scene.surface;
  return [(clientX - box.left) / unit - width / 2, (clientY - box.top) / unit - sceneHeight(height) / 2];
}

function offsetOfContact(view) {
  const { width, height } = scene.surface, [x, y] = touchPlace(view, moment);
  const offset = [x - width / 2, y - sceneHeight(height) / 2];
  return Math.abs(offset[0]) < width / 2 && Math.abs(offset[1]) < sceneHeight(height) / 2 ? offset : [0, 0];
}

/** Move what is seen, in pixels. */
function panScene(right, down) {
  const { scale } = sceneNow();
  moveView(-right / scale, down / scale);
  showZoom();
}

function resetZoom() {
  seeAll();
  showZoom();
}

function showZoom() {
  scene.surface.canvas.style.touchAction = zoom.by > 1 ? "none" : "pan-y";
  $("zoom-in").disabled = zoom.by >= MOST;
  $("zoom-out").disabled = $("zoom-all").disabled = zoom.by === 1;
  refresh();
}

/** Whether the wheel is for the page: it scrolls, or is inside another one. A pinch on a pad comes with Ctrl. */
function wheelScrolls(event) {
  const page = document.documentElement;
  return !event.ctrlKey && (window.parent !== window || page.scrollHeight > page.clientHeight + 1);
}

const wheelTimes = (event) => Math.exp(-event.deltaY * (event.deltaMode === 1 ? 0.05 : 0.0015) * (event.ctrlKey ? 5 : 1));

/** Fingers and mouse on the scene: one drags, two pinch. */
function connectScene() {
  const { canvas } = scene.surface, held = new Map();
  canvas.addEventListener("wheel", (event) => {
    if (wheelScrolls(event)) return;
    event.preventDefault();
    zoomScene(wheelTimes(event), event);
  }, { passive: false });
  canvas.addEventListener("dblclick", resetZoom);
  canvas.addEventListener("pointerdown", (event) => {
    held.set(event.pointerId, event);
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!held.has(event.pointerId)) return;
    const before = pairOf(held);
    held.set(event.pointerId, event);
    const now = pairOf(held);
    if (held.size > 1) zoomScene(now.apart / before.apart, now);
    panScene((now.clientX - before.clientX) / unit, (now.clientY - before.clientY) / unit);
  });
  for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, (event) => held.delete(event.pointerId));
}

/** Middle of one or two pointers, and how far apart they are. */
function pairOf(held) {
  const [a, b = a] = held.values();
  return {
    clientX: (a.clientX + b.clientX) / 2, clientY: (a.clientY + b.clientY) / 2,
    apart: Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY) || 1,
  };
}

// Charts ---------------------------------------------------------------------------------------------------------

/** Shorten the time that the charts show so many times; `at` stays where it is. */
function zoomTime(times, at, [from, to]) {
  const least = 1e-6 * (END - START), width = Math.max(least, (to - from) / times);
  if (width >= END - START) return freeTime();
  const first = Math.min(END - width, Math.max(START, at - ((at - from) * width) / (to - from)));
  setTime([first, first + width]);
}

function setTime(window) {
  timeZoom.window = window;
  $("range").value = "zoomed";
  $("zoomed").hidden = false;
  refresh();
}

/** The charts choose again what they show. */
function freeTime() {
  timeZoom.window = null;
  $("range").value = show.follow ? "follow" : "whole";
  $("zoomed").hidden = true;
  refresh();
}

/** Time under a pointer. */
function timeAt(chart, event) {
  const { x, w } = chart.area, [a, b] = chart.window;
  const part = ((event.clientX - chart.surface.canvas.getBoundingClientRect().left) / unit - x) / w;
  return a + (b - a) * Math.min(1, Math.max(0, part));
}

/** The event whose mark is under a pointer, nearest first: marks stand on the axis. */
function eventUnder(chart, event) {
  const { y, h, w } = chart.area, [a, b] = chart.window;
  const down = (event.clientY - chart.surface.canvas.getBoundingClientRect().top) / unit;
  if (down < y + h - NEAR) return undefined;
  const away = ({ time }) => (Math.abs(time - timeAt(chart, event)) * w * unit) / (b - a);
  const nearest = facts.events.reduce((best, one) => (!best || away(one) < away(best) ? one : best), undefined);
  return nearest && away(nearest) <= NEAR ? nearest : undefined;
}

/** Press or drag on a chart: the time under the pointer, or the event whose mark is there; the range holds still. */
function connectChart(chart) {
  const { canvas } = chart.surface;
  const seek = (event) => goTo(placeAtTime(timeAt(chart, event)));
  canvas.addEventListener("pointerdown", (event) => {
    if (event.button !== 0 || !chart.window) return;
    pause();
    const marked = eventUnder(chart, event);
    if (marked) return goTo(marked.frame);
    timeZoom.kept = !timeZoom.window;
    timeZoom.window ||= chart.window;
    canvas.setPointerCapture(event.pointerId);
    seek(event);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (canvas.hasPointerCapture(event.pointerId)) seek(event);
  });
  const release = () => {
    if (timeZoom.kept) timeZoom.window = null;
    timeZoom.kept = false;
    refresh();
  };
  canvas.addEventListener("pointerup", release);
  canvas.addEventListener("pointercancel", release);
  canvas.addEventListener("dblclick", freeTime);
  canvas.addEventListener("wheel", (event) => {
    if (wheelScrolls(event) || !chart.window) return;
    event.preventDefault();
    const [a, b] = chart.window, move = (event.deltaX * (b - a)) / (chart.area.w * unit);
    zoomTime(event.deltaY ? wheelTimes(event) : 1, timeAt(chart, event), [a + move, b + move]);
  }, { passive: false });
}
