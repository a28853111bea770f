/* Time in the reader's hands: play, pause, scrub, step, jump; the keyboard; the theme. */

const $ = (id) => document.getElementById(id);
const show = { place: 0, playing: false, speed: 1, loop: false, follow: true, last: 0, window: null, asked: false };
const moment = newMoment();
const charts = chartSpecs();
const strip = new Surface("strip");
const DECIMALS = Math.min(12, Math.max(5, 6 - Math.ceil(Math.log10(END - START || 1) - 1e-9)));
let themeBefore = null;

/** Ask for one new picture at the next refresh of the screen. */
function refresh() {
  if (show.asked) return;
  show.asked = true;
  requestAnimationFrame((stamp) => {
    show.asked = false;
    advance(stamp);
    draw();
  });
}

/** While playing: move on by the time since the last picture. */
function advance(stamp) {
  if (!show.playing) return;
  const passed = show.last ? Math.min(0.1, (stamp - show.last) / 1000) : 0;
  show.last = stamp;
  const film = filmHere() + passed * show.speed;
  if (film >= FILM) {
    show.place = show.loop ? 0 : LAST;
    if (!show.loop) pause();
  } else {
    show.place = placeAtFilm(film);
  }
  if (show.playing) refresh();
}

function filmHere() {
  const k = Math.min(Math.floor(show.place), LAST), u = show.place - k;
  return u ? (1 - u) * arrays.frame_film[k] + u * arrays.frame_film[k + 1] : arrays.frame_film[k];
}

function draw() {
  momentAt(show.place, moment);
  drawScene(moment);
  drawInset(moment);
  const window = show.window || timeWindow(moment, show.follow);
  for (const chart of charts) {
    drawChart(chart, moment, window);
    writeLegend(chart, moment);
  }
  drawStrip();
  writeStatus();
}

// What is written ------------------------------------------------------------------------------------------------

function writeStatus() {
  const name = facts.states[moment.state], time = `${fixed(moment.time, DECIMALS)} s`;
  $("time").textContent = `t = ${time}`;
  const pill = $("state");
  pill.textContent = name;
  pill.style.background = facts.state_colours[moment.state];
  const rate = rateText(rateAt(show.place) * show.speed);
  $("rate").textContent = rate && `shown at ${rate}`;
  const slider = $("slider");
  slider.value = String(moment.film);
  slider.setAttribute("aria-valuetext", `${time}, ${name}`);
  writeDeformation();
  writeNumbers();
  markEvent();
  if (show.playing) return;
  const said = `t = ${time}, ${name}${moment.state ? `, normal force ${significant(moment.normal, 3)} N` : ""}`;
  if ($("spoken").textContent !== said) $("spoken").textContent = said;
  $("scene").setAttribute("aria-label", `The beam at ${said}`);
}

function writeNumbers() {
  const rows = facts.contact
    ? [
        ["gap", millimetres(moment.gap)],
        ["tangential velocity", `${fixed(moment.slip_rate, 4)} m/s`],
        ["normal force", `${significant(moment.normal, 4)} N`],
        ["tangential force", `${significant(moment.tangential, 4)} N`],
      ]
    : [["deflection", millimetres(moment.deflection)]];
  const host = $("numbers");
  if (!host.childElementCount) for (const [name] of rows) host.append(made("dt", name), made("dd", ""));
  const values = host.querySelectorAll("dd");
  rows.forEach(([, text], k) => (values[k].textContent = text));
}

/** Millimetres to the micrometre, which float32 positions of a metre still resolve. */
function millimetres(metres) {
  return `${fixed(metres * 1e3, Math.abs(metres) < 0.1 ? 3 : 1)} mm`;
}

function writeDeformation() {
  const { factor, thick } = scene;
  const chord = facts.touch === STATIONS - 1 ? "pin–tip chord" : "chord from the pin to the contact point";
  const text = factor === 1 ? "deflection drawn true to scale" : `deflection drawn ×${short(factor)} about the ${chord}`;
  $("deformation").textContent = thick === 1 ? text : `${text}, thickness ×${thick}`;
}

// The strip above the buttons ------------------------------------------------------------------------------------

const THUMB = 7; // half of the slider's thumb, px

function drawStrip() {
  if (!strip.begin()) return;
  const c = strip.context, wide = strip.width - 2 * THUMB;
  const x = (film) => THUMB + (FILM > 0 ? (wide * film) / FILM : 0);
  const { frame_state: states, frame_film: film } = arrays;
  for (let k = 0, start = 0; k < FRAMES; k++) {
    if (k < LAST && states[k + 1] === states[k]) continue;
    const a = x(film[start]), b = Math.max(x(film[k]), a + (states[k] ? 1.5 : 0));
    c.globalAlpha = states[k] ? 1 : 0.35;
    c.fillStyle = stateColour[states[k]];
    c.fillRect(a, 15, b - a, 14);
    start = k + 1;
  }
  c.globalAlpha = 1;
  c.textBaseline = "top";
  c.textAlign = "center";
  const marks = [START, END, ...facts.collisions.map(([start]) => start)], taken = [];
  for (const time of marks) {
    const at = x(filmAt(time)), text = `${fixed(time, time === START ? 0 : 3)} s`, half = c.measureText(text).width / 2;
    const middle = Math.min(Math.max(at, half), strip.width - half);
    if (taken.some(([a, b]) => middle + half + 8 > a && middle - half - 8 < b)) continue;
    taken.push([middle - half, middle + half]);
    c.fillStyle = colour.dim;
    c.fillText(text, middle, 37);
    c.fillRect(at - 0.5, 31, 1, 5);
  }
}

// Events ---------------------------------------------------------------------------------------------------------

let eventButtons = [];
let current = -1;

function listEvents() {
  const host = $("events");
  eventButtons = facts.events.map((event, k) => {
    const button = made("button", ""), dot = made("i", ""), item = made("li", "");
    button.type = "button";
    dot.style.background = facts.state_colours[event.state];
    const impulse = event.impulse ? `${significant(event.impulse, 3)} N s` : "";
    const kind = made("span", event.kind);
    kind.append(" ", made("small", impulse));
    button.append(dot, made("span", `${fixed(event.time, 6)}`), kind);
    button.title = `t = ${event.time} s, then ${facts.states[event.state]}`;
    button.addEventListener("click", () => goTo(facts.events[k].frame));
    item.append(button);
    host.append(item);
    return button;
  });
  const shown = facts.events.length, all = facts.all_events;
  $("events-note").textContent = shown === 0 ? "none in this run" : shown < all ? `${shown} of ${all}; time (s)` : "time (s), kind, impulse";
}

/** Last event that has happened at the present place; -1 before the first. */
function eventHere() {
  let low = -1, high = facts.events.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (facts.events[middle].frame <= show.place) low = middle;
    else high = middle - 1;
  }
  return low;
}

function markEvent() {
  const k = eventHere();
  if (k === current) return;
  eventButtons[current]?.removeAttribute("aria-current");
  current = k;
  const button = eventButtons[k], host = $("events");
  if (!button) {
    host.scrollTop = 0;
    return;
  }
  button.setAttribute("aria-current", "true");
  const top = button.offsetTop - host.offsetTop;
  if (top < host.scrollTop || top + button.offsetHeight > host.scrollTop + host.clientHeight) {
    host.scrollTop = top - host.clientHeight / 2;
  }
}

// Moving ---------------------------------------------------------------------------------------------------------

function goTo(place) {
  show.place = Math.min(LAST, Math.max(0, place));
  refresh();
}

function play() {
  if (show.place >= LAST) show.place = 0;
  show.playing = true;
  show.last = 0;
  showPlaying();
  refresh();
}

function pause() {
  show.playing = false;
  showPlaying();
  refresh();
}

function showPlaying() {
  const button = $("play");
  button.setAttribute("aria-pressed", String(show.playing));
  button.setAttribute("aria-label", show.playing ? "Pause" : "Play");
  $("play-icon").setAttribute("d", show.playing ? "M5 4h5v16H5zM14 4h5v16h-5z" : "M6 4v16l14-8z");
}

function toggle() {
  if (show.playing) pause();
  else play();
}

/** The reader's own pause lasts: an embedded page does not play again by itself. */
function toggleByHand() {
  toggle();
  embed.held = !show.playing;
}

/** One frame on or back; from between two frames to the nearer end of that way. */
function step(direction) {
  pause();
  goTo(direction > 0 ? Math.floor(show.place) + 1 : Math.ceil(show.place) - 1);
}

/** The event after or before the present place. */
function stepEvent(direction) {
  pause();
  const here = eventHere(), events = facts.events;
  let k = direction > 0 ? here + 1 : here;
  if (direction < 0) while (k >= 0 && events[k].frame >= show.place) k--;
  goTo(k < 0 ? 0 : k >= events.length ? LAST : events[k].frame);
}

const KEYS = {
  " ": toggleByHand,
  ArrowRight: (shift) => (shift ? stepEvent(1) : step(1)),
  ArrowLeft: (shift) => (shift ? stepEvent(-1) : step(-1)),
  Home: () => goTo(0),
  End: () => goTo(LAST),
};

function onKey(event) {
  const action = KEYS[event.key], { target } = event;
  if (!action || event.ctrlKey || event.altKey || event.metaKey || target.tagName === "SELECT") return;
  if (event.key === " " && (target.tagName === "BUTTON" || target.type === "checkbox")) return;
  event.preventDefault();
  action(event.shiftKey);
}

/** Press or drag on a chart: the time under the pointer; its range holds still meanwhile. */
function scrubChart(chart) {
  const { canvas } = chart.surface;
  const seek = (event) => {
    const { x, w } = chart.area, [a, b] = chart.window;
    const part = ((event.clientX - canvas.getBoundingClientRect().left) / unit - x) / w;
    goTo(placeAtTime(a + (b - a) * Math.min(1, Math.max(0, part))));
  };
  canvas.addEventListener("pointerdown", (event) => {
    if (event.button !== 0 || !chart.window) return;
    pause();
    show.window = chart.window;
    canvas.setPointerCapture(event.pointerId);
    seek(event);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (canvas.hasPointerCapture(event.pointerId)) seek(event);
  });
  const release = () => {
    show.window = null;
    refresh();
  };
  canvas.addEventListener("pointerup", release);
  canvas.addEventListener("pointercancel", release);
}

// Theme and print ------------------------------------------------------------------------------------------------

const dark = window.matchMedia("(prefers-color-scheme: dark)");

function themeShown() {
  const { theme } = document.documentElement.dataset;
  return theme === "auto" ? (dark.matches ? "dark" : "light") : theme;
}

function setTheme(name) {
  document.documentElement.dataset.theme = name;
  readColours();
  $("theme").textContent = themeShown() === "dark" ? "light theme" : "dark theme";
  refresh();
}

/** On paper everything is light, finer and in one column; the pictures have to be ready before this returns. */
function setPrinting(now) {
  if (now === printing) return;
  printing = now;
  if (now) themeBefore = document.documentElement.dataset.theme;
  document.documentElement.classList.toggle("paper", now);
  setTheme(now ? "light" : themeBefore);
  draw();
}

// Start ----------------------------------------------------------------------------------------------------------

function offerFactors() {
  const select = $("factor");
  for (const value of [...new Set([1, 2, 5, 10, 20, 50, 100, facts.factor])].sort((a, b) => a - b)) {
    const option = made("option", value === 1 ? "true" : `×${short(value)}`);
    option.value = String(value);
    option.selected = value === facts.factor;
    select.append(option);
  }
  select.addEventListener("change", () => {
    setScene(Number(select.value));
    refresh();
  });
}

const THEMES = ["light", "dark", "auto"];

/** "#t=0.32" opens at a time, "#event=3" after an event; "&play" plays from there, "&embed" is for another page. */
function followFragment() {
  const wanted = new URLSearchParams(window.location.hash.slice(1));
  setEmbedded(wanted.has("embed"));
  if (THEMES.includes(wanted.get("theme"))) setTheme(wanted.get("theme"));
  const time = parseFloat(wanted.get("t")), number = parseInt(wanted.get("event"), 10);
  if (Number.isFinite(time)) goTo(placeAtTime(time));
  else if (facts.events[number - 1]) goTo(facts.events[number - 1].frame);
  if (wanted.has("play") && !calm.matches) play();
}

function connect() {
  const actions = {
    play: toggleByHand, home: KEYS.Home, end: KEYS.End, back: () => step(-1), forward: () => step(1),
    "event-back": () => stepEvent(-1), "event-forward": () => stepEvent(1),
    theme: () => setTheme(themeShown() === "dark" ? "light" : "dark"),
  };
  for (const [id, action] of Object.entries(actions)) {
    $(id).addEventListener("click", () => action());
    $(id).addEventListener("mousedown", (event) => event.preventDefault()); // the keyboard stays with the page
  }
  $("slider").max = String(FILM);
  $("slider").addEventListener("input", () => {
    if (show.playing) pause();
    goTo(placeAtFilm(Number($("slider").value)));
  });
  $("speed").addEventListener("change", () => { show.speed = Number($("speed").value); refresh(); });
  $("loop").addEventListener("change", () => { show.loop = $("loop").checked; });
  $("range").addEventListener("change", () => { show.follow = $("range").value === "follow"; refresh(); });
  document.addEventListener("keydown", onKey);
  window.addEventListener("hashchange", followFragment);
  window.addEventListener("resize", refresh);
  dark.addEventListener("change", () => setTheme(document.documentElement.dataset.theme));
  const paper = window.matchMedia("print");
  paper.addEventListener("change", () => setPrinting(paper.matches));
  window.addEventListener("beforeprint", () => setPrinting(true));
  window.addEventListener("afterprint", () => setPrinting(false));
  const sizes = new ResizeObserver(refresh);
  document.querySelectorAll("canvas").forEach((canvas) => sizes.observe(canvas));
  charts.forEach(scrubChart);
}

readColours();
setScene(facts.factor);
offerFactors();
listEvents();
connect();
if (facts.touch === STATIONS - 1) $("tip-title").textContent = "Tip, true scale";
setTheme(document.documentElement.dataset.theme);
followFragment();

/* For a page that embeds this one, and for tests. */
window.player = {
  play, pause, step, stepEvent, goTo,
  seek: (time) => goTo(placeAtTime(time)),
  now: () => ({ ...momentAt(show.place, newMoment()), playing: show.playing, frames: FRAMES }),
  facts, arrays, envelope,
  place: (name) => touchPlace(name === "inset" ? insetView(moment, inset.surface.width, inset.surface.height) : sceneView(scene.surface.width, scene.surface.height), moment),
};
