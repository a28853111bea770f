/* What is shown now, how that goes on, and the reader's hands. */

const ZOOM = 1.5; // of a button or a key
const PART = 0.15; // of what is seen: a move by a key
const NEAR = 22; // pixels: half of what a finger needs
const show = { place: 0, playing: false, last: 0, asked: false, held: false, speed: "1", loop: false, result: "" };
const root = document.documentElement;
const calm = window.matchMedia("(prefers-reduced-motion: reduce)");
const all = (selector) => [...document.querySelectorAll(selector)];
const events = all("#events button").map(({ dataset }) => [Number(dataset.number), Number(dataset.frame)]);

// Time -----------------------------------------------------------------------------------------------------------

/** Ask for one new picture at the next refresh of the screen. */
function refresh() {
  if (show.asked) return;
  show.asked = true;
  requestAnimationFrame((stamp) => {
    show.asked = false;
    if (show.playing) advance(stamp);
    drawScenes();
    drawInset();
    write();
  });
}

function advance(stamp) {
  const passed = show.last ? Math.min(0.1, (stamp - show.last) / 1000) : 0;
  show.last = stamp;
  show.place = placeOf(run.film, mix(run.film, show.place) + passed * Number(show.speed));
  if (show.place >= LAST && show.loop) show.place = 0;
  else if (show.place >= LAST) setPlaying(false);
  if (show.playing) refresh();
}

function setPlaying(playing) {
  if (playing && show.place >= LAST) show.place = 0;
  Object.assign(show, { playing, last: 0, place: playing ? show.place : Math.floor(show.place) });
  $("play").setAttribute("aria-label", playing ? "Pause" : "Play");
  $("play-icon").setAttribute("d", playing ? "M5 4h5v16H5zM14 4h5v16h-5z" : "M6 4v16l14-8z");
  refresh();
}

/** The reader's own pause lasts: an embedded page does not play again by itself. */
function toggle() {
  setPlaying(!show.playing);
  show.held = !show.playing;
}

function goTo(frame) {
  show.place = clamp(frame, 0, LAST);
  refresh();
}

const seek = (time) => goTo(Math.round(placeOf(run.time, time)));

/** Pause, and show the frame nearest to a film time. */
function seekFilm(film) {
  setPlaying(false);
  goTo(Math.round(placeOf(run.film, film)));
}

function step(frames) {
  setPlaying(false);
  goTo(show.place + frames);
}

/** The event after or before the present frame. */
function stepEvent(direction) {
  setPlaying(false);
  const frames = events.map(([, frame]) => frame), here = show.place;
  goTo(direction > 0 ? frames.find((frame) => frame > here) ?? LAST : frames.findLast((frame) => frame < here) ?? 0);
}

/** Press or drag on a chart: the time there, or the event whose mark at the bottom is near. */
function connectChart(chart) {
  const go = ({ clientX, clientY }, pressed) => {
    const { left, bottom, width } = chart.getBoundingClientRect(), film = (FILM * (clientX - left)) / width;
    const away = ([, frame]) => (Math.abs(run.film[frame] - film) * width) / FILM;
    const near = pressed && clientY > bottom - NEAR && events.filter((event) => away(event) <= NEAR);
    if (near?.length) step(near.toSorted((a, b) => away(a) - away(b))[0][1] - show.place);
    else seekFilm(film);
  };
  chart.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    chart.setPointerCapture(event.pointerId);
    go(event, true);
  });
  chart.addEventListener("pointermove", (event) => chart.hasPointerCapture(event.pointerId) && go(event));
}

// What is written ------------------------------------------------------------------------------------------------

const written = all("[data-text]");
const lists = all("[data-list]").map((host) => ({ host, buttons: [...host.querySelectorAll("button")], now: -1 }));

function write() {
  const k = Math.floor(show.place), name = facts.states[run.state[k]], film = mix(run.film, show.place);
  for (const element of written) element.textContent = run[element.dataset.text][k];
  $("charts").style.setProperty("--now", film / (FILM || 1));
  $("state").textContent = facts.told[run.state[k]];
  $("state").className = `state ${name}`;
  const side = !show.playing && k === show.place && run.side_text[k];
  $("rate").textContent = [side, `shown at ${facts.rates[show.speed][run.rate[k]]}`].filter(Boolean).join(", ");
  const { thick } = sceneView();
  const notes = [factor.note, thick > 1 && `thickness ×${thick}`, zoom.by > 1 && `zoom ×${Number(zoom.by.toPrecision(3))}`];
  $("deformation").textContent = [...notes, root.classList.contains("embed") && $("deformation").dataset.warnings].filter(Boolean).join(", ");
  $("slider").value = String(film);
  $("slider").setAttribute("aria-valuetext", `${run.time_text[k]}, ${name}`);
  if (!show.playing) scene.setAttribute("aria-label", `The beam at ${run.time_text[k]}, ${name}; in colour: ${$("colour").selectedOptions[0].text}`);
  lists.forEach(markCurrent);
}

/** Mark the last event or contact that has begun, and keep it in sight; it is the stop of the Tab key in its list. */
function markCurrent(list) {
  const { host, buttons } = list, now = buttons.findLastIndex((button) => Number(button.dataset.frame) <= show.place);
  if (now === list.now) return;
  list.now = now;
  buttons.forEach((button, k) => {
    button.setAttribute("aria-current", k === now);
    button.tabIndex = k === Math.max(now, 0) ? 0 : -1;
  });
  const top = now < 0 ? 0 : buttons[now].offsetTop - host.offsetTop, bottom = top + (buttons[now]?.offsetHeight ?? 0);
  if (top < host.scrollTop || bottom > host.scrollTop + host.clientHeight) host.scrollTop = top - host.clientHeight / 2;
}

// Zoom -----------------------------------------------------------------------------------------------------------

/** Zoom the scene about a place; without one about the contact point where it is seen, or the middle. */
function zoomScene(times, place) {
  const size = sizeOf(scene), view = sceneView(), touch = touchPlace(view, closeContact());
  const [x, y] = place ?? (touch.every((v, n) => v > 0 && v < size[n]) ? touch : size.map((v) => v / 2));
  zoom.by = clamp(zoom.by * times, 1, MOST);
  const now = toPixels(sceneView(), [(x - view.x0) / view.scale, (view.y0 - y) / view.scale]);
  panScene(x - now[0], y - now[1]); // it stays where it is
}

/** Move what is seen, in pixels, not beyond the picture of the whole. */
function panScene(right, down) {
  const { scale } = sceneView(), [left, end, low, high] = factor.bounds, free = 0.5 * (1 - 1 / zoom.by);
  zoom.x = clamp(zoom.x - right / scale, -free * (end - left), free * (end - left));
  zoom.y = clamp(zoom.y + down / scale, -free * (high - low), free * (high - low));
  scene.style.touchAction = zoom.by > 1 ? "none" : "pan-y";
  $("zoom-in").disabled = zoom.by >= MOST;
  $("zoom-out").disabled = $("zoom-all").disabled = zoom.by === 1;
  refresh();
}

const showAll = () => zoomScene(0);

/** Fingers and mouse on the scene: one drags, two pinch; the wheel zooms where it does not scroll a page. */
function connectScene(scene) {
  const held = new Map();
  const at = ({ offsetX, offsetY }) => [offsetX / unit(), offsetY / unit()];
  const pinch = () => {
    const [a, b = a] = held.values();
    return { middle: [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2], apart: Math.hypot(a[0] - b[0], a[1] - b[1]) || 1 };
  };
  scene.addEventListener("wheel", (event) => {
    if (!event.ctrlKey && (window.parent !== window || root.scrollHeight > root.clientHeight + 1)) return;
    event.preventDefault(); // a pinch on a pad comes with Ctrl
    zoomScene(Math.exp(-event.deltaY * (event.deltaMode === 1 ? 0.05 : 0.0015) * (event.ctrlKey ? 5 : 1)), at(event));
  }, { passive: false });
  scene.addEventListener("dblclick", showAll);
  scene.addEventListener("pointerdown", (event) => {
    held.set(event.pointerId, at(event));
    scene.setPointerCapture(event.pointerId);
  });
  scene.addEventListener("pointermove", (event) => {
    if (!held.has(event.pointerId)) return;
    const before = pinch();
    held.set(event.pointerId, at(event));
    const now = pinch();
    zoomScene(now.apart / before.apart, now.middle);
    panScene(now.middle[0] - before.middle[0], now.middle[1] - before.middle[1]);
  });
  for (const name of ["pointerup", "pointercancel"]) scene.addEventListener(name, (event) => held.delete(event.pointerId));
}

// Choices --------------------------------------------------------------------------------------------------------

const dark = window.matchMedia("(prefers-color-scheme: dark)");

/** Show a theme; "auto" is that of the system. */
function setTheme(name) {
  const shown = name === "auto" ? (dark.matches ? "dark" : "light") : name;
  Object.assign(root.dataset, { theme: shown, chosen: name });
  const style = getComputedStyle(root), of = (variable) => style.getPropertyValue(`--${variable}`).trim();
  colour = Object.fromEntries(["background", "ink", "ghost", "edge", "ground"].map((variable) => [variable, of(variable)]));
  colour.states = ["free", "slip", "stick"].map(of);
  $("theme").textContent = shown === "dark" ? "light theme" : "dark theme";
  refresh();
}

function setFactor(name) {
  factor = facts.factors[name];
  refresh();
}

function setResult(name) {
  $("colour").value = show.result = name;
  all("[data-result]").forEach((scale) => { scale.hidden = scale.dataset.result !== name; });
  refresh();
}

/** In another page, at "#embed": the beam and the transport, playing while half of it is seen. */
function setEmbedded() {
  root.classList.add("embed");
  document.querySelector(".status").append($("deformation"));
  $("whole").href = window.location.href.split("#")[0];
  $("loop").checked = show.loop = true;
  new IntersectionObserver(([{ intersectionRatio: seen }]) => {
    if (seen === 0 && show.playing) setPlaying(false);
    else if (seen >= 0.5 && !show.held && !calm.matches && !show.playing) setPlaying(true);
  }, { threshold: [0, 0.5] }).observe(document.body);
}

/** "#t=0.32" opens at a time, "#event=3" after an event; "&play" plays from there, "&embed" is for another page. */
function followFragment() {
  const wanted = new URLSearchParams(window.location.hash.slice(1)), theme = wanted.get("theme");
  if (wanted.has("embed") && !root.classList.contains("embed")) setEmbedded();
  if (["light", "dark", "auto"].includes(theme)) setTheme(theme);
  if (`${wanted.get("colour")}_lower` in run) setResult(wanted.get("colour"));
  const event = events.find(([number]) => number >= parseInt(wanted.get("event"), 10)); // of very many some are listed
  if (wanted.has("t")) seek(parseFloat(wanted.get("t")) || 0);
  else if (event) goTo(event[1]);
  if (wanted.has("play") && !calm.matches) setPlaying(true);
}

/** The address of this instant, in the line of the browser and, where it may be, ready to be pasted. */
function linkHere() {
  setPlaying(false);
  const look = root.dataset.chosen === "auto" ? "" : `&theme=${root.dataset.chosen}`;
  history.replaceState(null, "", `#t=${run.time[show.place]}&colour=${show.result}${look}`);
  navigator.clipboard?.writeText(window.location.href).catch(() => {});
  $("link").textContent = "link is ready";
  setTimeout(() => { $("link").textContent = "link"; }, 2000);
}

const pan = (right, down) => () => panScene(right * PART * sizeOf(scene)[0], down * PART * sizeOf(scene)[1]);
const KEYS = {
  "+": () => zoomScene(ZOOM), "=": () => zoomScene(ZOOM), "-": () => zoomScene(1 / ZOOM), 0: showAll,
  w: pan(0, 1), s: pan(0, -1), a: pan(1, 0), d: pan(-1, 0), " ": toggle, Home: () => goTo(0), End: () => goTo(LAST),
  ArrowRight: (shift) => (shift ? stepEvent(1) : step(1)), ArrowLeft: (shift) => (shift ? stepEvent(-1) : step(-1)),
};
const BUTTONS = {
  play: toggle, home: KEYS.Home, end: KEYS.End, back: () => step(-1), forward: () => step(1),
  "event-back": () => stepEvent(-1), "event-forward": () => stepEvent(1),
  "zoom-in": KEYS["+"], "zoom-out": KEYS["-"], "zoom-all": showAll,
  link: linkHere,
  theme: () => setTheme(root.dataset.theme === "dark" ? "light" : "dark"),
};
const CHOICES = {
  slider: ({ value }) => seekFilm(Number(value)),
  speed: ({ value }) => { show.speed = value; refresh(); },
  loop: ({ checked }) => { show.loop = checked; },
  factor: ({ value }) => setFactor(value),
  colour: ({ value }) => setResult(value),
};

function onKey(event) {
  const { key, target } = event, action = KEYS[key];
  if (target.dataset.frame && ["ArrowUp", "ArrowDown"].includes(key)) {
    const { buttons } = lists.find((list) => list.buttons.includes(target));
    event.preventDefault();
    return buttons[buttons.indexOf(target) + (key === "ArrowUp" ? -1 : 1)]?.focus();
  }
  if (!action || event.ctrlKey || event.altKey || event.metaKey || target.tagName === "SELECT" || target.type === "radio") return;
  if (key === " " && (["BUTTON", "SUMMARY"].includes(target.tagName) || target.type === "checkbox")) return;
  event.preventDefault();
  action(event.shiftKey);
}

for (const [id, action] of Object.entries(BUTTONS)) {
  $(id).addEventListener("click", () => action());
  $(id).addEventListener("mousedown", (event) => event.preventDefault()); // the keyboard stays with the page
}
for (const [id, action] of Object.entries(CHOICES)) $(id).addEventListener("input", ({ target }) => action(target));
document.addEventListener("keydown", onKey);
document.addEventListener("click", ({ target }) => {
  const row = target.closest("[data-frame]");
  if (row) goTo(Number(row.dataset.frame));
});
window.addEventListener("hashchange", followFragment);
dark.addEventListener("change", () => setTheme(root.dataset.chosen));
const sizes = new ResizeObserver(refresh);
[...scenes, inset].forEach((canvas) => sizes.observe(canvas));
all(".plot").forEach(connectChart);
scenes.forEach(connectScene);
if ($("warnings")) $("warnings").open = window.matchMedia("(min-width: 900px) and (min-height: 800px)").matches;
$("slider").max = String(FILM);
setFactor($("factor").value);
setResult($("colour").value);
setTheme(root.dataset.chosen);
showAll();
followFragment();

/* For a page that embeds this one, and for tests. */
window.player = {
  play: () => setPlaying(true), pause: () => setPlaying(false), seek, goTo, run, runs,
  now: () => ({ frame: show.place, time: mix(run.time, show.place), state: stateAt(show.place), playing: show.playing, zoom: zoom.by, axis: axisAt(show.place, 1) }),
};
