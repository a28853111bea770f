/* What is shown now, how that goes on, and the reader's hands. */

const ZOOM = 1.5; // of a button or a key
const PART = 0.15; // of what is seen: a move by a key
const NEAR = 22; // pixels: half of what a finger needs
const show = {
  place: 0, playing: false, last: 0, asked: false, speed: "1", loop: false, result: facts.shown,
  follow: true, window: null, // times (s) that the charts show as the reader has zoomed, or null
};
const root = document.documentElement;
const calm = window.matchMedia("(prefers-reduced-motion: reduce)");

// Time -----------------------------------------------------------------------------------------------------------

/** Ask for one new picture at the next refresh of the screen. */
function refresh() {
  if (show.asked) return;
  show.asked = true;
  requestAnimationFrame((stamp) => {
    show.asked = false;
    if (show.playing) advance(stamp);
    drawScene();
    drawInset();
    charts.forEach(drawChart);
    drawStrip();
    write();
  });
}

function advance(stamp) {
  const passed = show.last ? Math.min(0.1, (stamp - show.last) / 1000) : 0;
  show.last = stamp;
  const film = mix(run.film, show.place) + passed * Number(show.speed);
  if (film < FILM) show.place = placeAtFilm(film);
  else if (show.loop) show.place = 0;
  else {
    show.place = LAST;
    pause();
  }
  if (show.playing) refresh();
}

function goTo(frame) {
  show.place = Math.min(LAST, Math.max(0, frame));
  refresh();
}

function setPlaying(playing) {
  if (playing && show.place >= LAST) show.place = 0;
  Object.assign(show, { playing, last: 0, place: playing ? show.place : Math.floor(show.place) });
  $("play").setAttribute("aria-label", playing ? "Pause" : "Play");
  $("play-icon").setAttribute("d", playing ? "M5 4h5v16H5zM14 4h5v16h-5z" : "M6 4v16l14-8z");
  refresh();
}

const play = () => setPlaying(true);
const pause = () => setPlaying(false);

/** The reader's own pause lasts: an embedded page does not play again by itself. */
function toggle() {
  setPlaying(!show.playing);
  show.held = !show.playing;
}

function step(direction) {
  pause();
  goTo(show.place + direction);
}

/** The event after or before the present frame. */
function stepEvent(direction) {
  pause();
  const frames = facts.events.map((event) => event.frame), here = show.place;
  goTo(direction > 0 ? frames.find((frame) => frame > here) ?? LAST : frames.findLast((frame) => frame < here) ?? 0);
}

const seek = (time) => goTo(frameNear(run.time, time));

// What is written ------------------------------------------------------------------------------------------------

const written = [...document.querySelectorAll("[data-text]")];
const lists = [...document.querySelectorAll("[data-list]")].map((host) => ({ host, buttons: [...host.querySelectorAll("button")], now: -1 }));

function write() {
  const k = Math.floor(show.place), state = run.state[k], name = facts.states[state];
  for (const element of written) element.textContent = run[element.dataset.text][k];
  root.style.setProperty("--state", stateColour[state]);
  $("state").textContent = name;
  $("state").style.background = facts.state_colours.light[state];
  $("rate").textContent = `shown at ${facts.rates[show.speed][run.rate[k]]}`;
  const notes = [scene.factor.note, scene.thick > 1 && `thickness ×${scene.thick}`, zoom.by > 1 && `zoom ×${Number(zoom.by.toPrecision(3))}`];
  $("deformation").textContent = [...notes, root.classList.contains("embed") && $("deformation").dataset.warnings].filter(Boolean).join(", ");
  $("slider").value = String(mix(run.film, show.place));
  $("slider").setAttribute("aria-valuetext", `${run.time_text[k]}, ${name}`);
  if (!show.playing) $("scene").setAttribute("aria-label", `The beam at ${run.time_text[k]}, ${name}; in colour: ${facts.results[show.result].title}`);
  lists.forEach(markCurrent);
}

/** Mark the last event or contact that has begun, and keep it in sight. */
function markCurrent(list) {
  const { host, buttons } = list, now = buttons.findLastIndex((button) => Number(button.dataset.frame) <= show.place);
  if (now === list.now) return;
  buttons[list.now]?.removeAttribute("aria-current");
  buttons[now]?.setAttribute("aria-current", "true");
  list.now = now;
  if (!buttons.includes(document.activeElement)) takeStop(buttons, buttons[Math.max(now, 0)]);
  const top = now < 0 ? 0 : buttons[now].offsetTop - host.offsetTop, bottom = top + (buttons[now]?.offsetHeight ?? 0);
  if (top < host.scrollTop || bottom > host.scrollTop + host.clientHeight) host.scrollTop = top - host.clientHeight / 2;
}

/** Of some buttons one is a stop of the Tab key; arrows up and down go on from there. */
function takeStop(buttons, chosen) {
  for (const button of buttons) button.tabIndex = button === chosen ? 0 : -1;
}

function connectList({ buttons }) {
  buttons.forEach((button, k) => {
    button.addEventListener("click", () => goTo(Number(button.dataset.frame)));
    button.addEventListener("focus", () => takeStop(buttons, button));
    button.addEventListener("keydown", (event) => {
      const next = buttons[k + { ArrowDown: 1, ArrowUp: -1 }[event.key]];
      if (!next) return;
      event.preventDefault();
      next.focus();
    });
  });
}

// Zoom -----------------------------------------------------------------------------------------------------------

/** Zoom the scene about a place; without one about the contact point where it is seen, or the middle. */
function zoomScene(times, place) {
  const middle = [scene.surface.width / 2, above(scene.surface.height) / 2];
  const offset = (place || touchPlace(sceneView())).map((v, n) => v - middle[n]);
  zoomBy(times, place || offset.every((v, n) => Math.abs(v) < middle[n]) ? offset : [0, 0]);
  showZoom();
}

/** Move what is seen, in pixels. */
function panScene(right, down) {
  const { scale } = sceneView();
  moveView(-right / scale, down / scale);
  showZoom();
}

function resetZoom() {
  Object.assign(zoom, { by: 1, x: 0, y: 0 });
  showZoom();
}

function showZoom() {
  scene.surface.canvas.style.touchAction = zoom.by > 1 ? "none" : "pan-y";
  $("zoom-in").disabled = zoom.by >= MOST;
  $("zoom-out").disabled = $("zoom-all").disabled = zoom.by === 1;
  refresh();
}

/** The wheel zooms where it does not scroll the page, or one around it; a pinch on a pad comes with Ctrl. */
function onWheel(canvas, zoomAt) {
  canvas.addEventListener("wheel", (event) => {
    if (!event.ctrlKey && (window.parent !== window || root.scrollHeight > root.clientHeight + 1)) return;
    event.preventDefault();
    zoomAt(Math.exp(-event.deltaY * (event.deltaMode === 1 ? 0.05 : 0.0015) * (event.ctrlKey ? 5 : 1)), event);
  }, { passive: false });
}

/** Fingers and mouse on the scene: one drags, two pinch. */
function connectScene({ surface }) {
  const { canvas } = surface, held = new Map();
  const pinch = () => {
    const [a, b = a] = held.values();
    return { middle: [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2], apart: Math.hypot(a[0] - b[0], a[1] - b[1]) || 1 };
  };
  onWheel(canvas, (times, event) => zoomScene(times, surface.at(event)));
  canvas.addEventListener("dblclick", resetZoom);
  canvas.addEventListener("pointerdown", (event) => {
    held.set(event.pointerId, surface.at(event));
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!held.has(event.pointerId)) return;
    const before = pinch();
    held.set(event.pointerId, surface.at(event));
    const now = pinch();
    if (held.size > 1) zoomScene(now.apart / before.apart, now.middle);
    panScene(now.middle[0] - before.middle[0], now.middle[1] - before.middle[1]);
  });
  for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, (event) => held.delete(event.pointerId));
}

/** Times that the charts show; null: they choose again. */
function setWindow(times) {
  show.window = times;
  $("range").value = times ? "zoomed" : show.follow ? "follow" : "whole";
  $("zoomed").hidden = !times;
  refresh();
}

/** Press or drag on a chart: the time there, or the event whose mark is near; the range holds still meanwhile. */
function connectChart(chart) {
  const { canvas } = chart.surface;
  const timeAt = (event) => {
    const { x, w } = chart.area, [from, to] = chart.span;
    return from + (to - from) * Math.min(1, Math.max(0, (chart.surface.at(event)[0] - x) / w));
  };
  const eventNear = (event) => {
    const { y, h, w } = chart.area, away = ({ time }) => (Math.abs(time - timeAt(event)) * w * unit) / (chart.span[1] - chart.span[0]);
    if (chart.surface.at(event)[1] < y + h - NEAR / unit) return null;
    return facts.events.filter((one) => away(one) <= NEAR).sort((a, b) => away(a) - away(b))[0];
  };
  let held = false; // the range, until the button is released
  canvas.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    pause();
    const marked = eventNear(event);
    if (marked) return goTo(marked.frame);
    held = !show.window;
    show.window ||= chart.span;
    canvas.setPointerCapture(event.pointerId);
    seek(timeAt(event));
  });
  canvas.addEventListener("pointermove", (event) => canvas.hasPointerCapture(event.pointerId) && seek(timeAt(event)));
  for (const name of ["pointerup", "pointercancel"]) {
    canvas.addEventListener(name, () => {
      if (held) show.window = null;
      held = false;
      refresh();
    });
  }
  canvas.addEventListener("dblclick", () => setWindow(null));
  onWheel(canvas, (times, event) => {
    const [from, to] = chart.span, move = (event.deltaX * (to - from)) / (chart.area.w * unit), at = timeAt(event);
    const width = Math.max(1e-6 * (END - START), (to - from) / times);
    if (width >= END - START) return setWindow(null);
    const first = Math.min(END - width, Math.max(START, at + move - ((at - from) * width) / (to - from)));
    setWindow([first, first + width]);
  });
}

// Choices --------------------------------------------------------------------------------------------------------

const dark = window.matchMedia("(prefers-color-scheme: dark)");

/** Show a theme; "auto" is that of the system. */
function setTheme(name) {
  const shown = name === "auto" ? (dark.matches ? "dark" : "light") : name;
  Object.assign(root.dataset, { theme: shown, chosen: name });
  readColours(shown);
  $("theme").textContent = shown === "dark" ? "light theme" : "dark theme";
  refresh();
}

function setFactor(value) {
  scene.factor = facts.factors.find(({ factor }) => factor === Number(value));
  refresh();
}

function setResult(name) {
  if (name in facts.results) show.result = $("colour").value = name;
  refresh();
}

/** Charts or the table of contacts. */
function openTab(chosen) {
  for (const tab of document.querySelectorAll('[role="tab"]')) {
    tab.setAttribute("aria-selected", String(tab === chosen));
    tab.tabIndex = tab === chosen ? 0 : -1;
    $(tab.getAttribute("aria-controls")).hidden = tab !== chosen;
  }
  refresh();
}

/** In another page, at "#embed": the beam and the transport, playing while half of it is seen. */
function setEmbedded(on) {
  root.classList.toggle("embed", on);
  (on ? document.querySelector(".status") : document.querySelector(".stage")).append($("deformation"));
  if (!on) return document.querySelector(".stage").append(document.querySelector(".choices"));
  $("whole").href = window.location.href.split("#")[0];
  $("loop").checked = show.loop = true;
  new IntersectionObserver(([{ intersectionRatio: seen }]) => {
    if (seen === 0 && show.playing) pause();
    else if (seen >= 0.5 && !show.held && !calm.matches && !show.playing) play();
  }, { threshold: [0, 0.5] }).observe(document.body);
}

/** "#t=0.32" opens at a time, "#event=3" after an event; "&play" plays from there, "&embed" is for another page. */
function followFragment() {
  const wanted = new URLSearchParams(window.location.hash.slice(1)), theme = wanted.get("theme");
  if (wanted.has("embed") !== root.classList.contains("embed")) setEmbedded(wanted.has("embed"));
  if (["light", "dark", "auto"].includes(theme)) setTheme(theme);
  if (wanted.has("colour")) setResult(wanted.get("colour"));
  const event = facts.events.find(({ number }) => number >= parseInt(wanted.get("event"), 10)); // of very many some are listed
  if (wanted.has("t")) seek(parseFloat(wanted.get("t")) || 0);
  else if (event) goTo(event.frame);
  if (wanted.has("play") && !calm.matches) play();
}

const pan = (right, down) => () => panScene(right * PART * scene.surface.width, down * PART * scene.surface.height);
const KEYS = {
  "+": () => zoomScene(ZOOM), "=": () => zoomScene(ZOOM), "-": () => zoomScene(1 / ZOOM), 0: resetZoom,
  w: pan(0, 1), s: pan(0, -1), a: pan(1, 0), d: pan(-1, 0), " ": toggle, Home: () => goTo(0), End: () => goTo(LAST),
  ArrowRight: (shift) => (shift ? stepEvent(1) : step(1)), ArrowLeft: (shift) => (shift ? stepEvent(-1) : step(-1)),
};
const BUTTONS = {
  play: toggle, home: KEYS.Home, end: KEYS.End, back: () => step(-1), forward: () => step(1),
  "event-back": () => stepEvent(-1), "event-forward": () => stepEvent(1),
  "zoom-in": KEYS["+"], "zoom-out": KEYS["-"], "zoom-all": resetZoom,
  theme: () => setTheme(root.dataset.theme === "dark" ? "light" : "dark"),
};
const CHOICES = {
  slider: ({ value }) => { if (show.playing) pause(); goTo(frameNear(run.film, Number(value))); },
  speed: ({ value }) => { show.speed = value; refresh(); },
  loop: ({ checked }) => { show.loop = checked; },
  range: ({ value }) => { show.follow = value === "follow"; setWindow(null); },
  factor: ({ value }) => setFactor(value),
  colour: ({ value }) => setResult(value),
};

function onKey(event) {
  const action = KEYS[event.key], { target } = event;
  if (!action || event.ctrlKey || event.altKey || event.metaKey || target.tagName === "SELECT") return;
  if (event.key === " " && (target.tagName === "BUTTON" || target.type === "checkbox" || target.tagName === "SUMMARY")) return;
  if (target.role === "tab" && event.key.startsWith("Arrow")) return openTab([...document.querySelectorAll('[role="tab"]')].find((tab) => tab !== target));
  event.preventDefault();
  action(event.shiftKey);
}

for (const [id, action] of Object.entries(BUTTONS)) {
  $(id).addEventListener("click", () => action());
  $(id).addEventListener("mousedown", (event) => event.preventDefault()); // the keyboard stays with the page
}
for (const [id, action] of Object.entries(CHOICES)) $(id).addEventListener("input", ({ target }) => action(target));
document.querySelectorAll('[role="tab"]').forEach((tab) => tab.addEventListener("click", () => openTab(tab)));
document.addEventListener("keydown", onKey);
window.addEventListener("hashchange", followFragment);
dark.addEventListener("change", () => setTheme(root.dataset.chosen));
const sizes = new ResizeObserver(refresh);
document.querySelectorAll("canvas").forEach((canvas) => sizes.observe(canvas));
charts.forEach(connectChart);
lists.forEach(connectList);
connectScene(scene);
if ($("warnings")) $("warnings").open = window.matchMedia("(min-width: 900px) and (min-height: 800px)").matches;
$("slider").max = String(FILM);
setFactor($("factor").value);
setTheme(root.dataset.chosen);
showZoom();
followFragment();

/* For a page that embeds this one, and for tests. */
window.player = {
  play, pause, seek, goTo, facts, run,
  now: () => ({ frame: show.place, time: mix(run.time, show.place), state: stateAt(show.place), playing: show.playing, zoom: zoom.by, axis: axisAt(show.place, 1) }),
};
