/* The reader's hands: keys, buttons, choices, links; the theme and the printer. */

let themeBefore = null;

/** The reader's own pause lasts: an embedded page does not play again by itself. */
function toggleByHand() {
  toggle();
  embed.held = !show.playing;
}

const KEYS = {
  "+": () => zoomScene(STEP),
  "=": () => zoomScene(STEP),
  "-": () => zoomScene(1 / STEP),
  0: resetZoom,
  w: () => panKey(0, 1),
  s: () => panKey(0, -1),
  a: () => panKey(1, 0),
  d: () => panKey(-1, 0),
  " ": toggleByHand,
  ArrowRight: (shift) => (shift ? stepEvent(1) : step(1)),
  ArrowLeft: (shift) => (shift ? stepEvent(-1) : step(-1)),
  Home: () => goTo(0),
  End: () => goTo(LAST),
};

/** Move what is seen by a part of the picture. */
function panKey(right, down) {
  panScene(right * PART * scene.surface.width, down * PART * scene.surface.height);
}

function onKey(event) {
  const action = KEYS[event.key], { target } = event;
  if (!action || event.ctrlKey || event.altKey || event.metaKey || target.tagName === "SELECT") return;
  if (event.key === " " && (target.tagName === "BUTTON" || target.type === "checkbox")) return;
  event.preventDefault();
  action(event.shiftKey);
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

function offerResults() {
  const select = $("colour");
  for (const { name } of facts.results) {
    const option = made("option", name.replaceAll("_", " "));
    option.value = name;
    select.append(option);
  }
  select.value = result.name;
  select.addEventListener("change", () => colourBy(select.value));
}

function colourBy(name) {
  setResult(name);
  $("colour").value = result.name;
  refresh();
}

/** "#t=0.32" opens at a time, "#event=3" after an event; "&play" plays from there, "&embed" is for another page. */
function followFragment() {
  const wanted = new URLSearchParams(window.location.hash.slice(1));
  setEmbedded(wanted.has("embed"));
  if (THEMES.includes(wanted.get("theme"))) setTheme(wanted.get("theme"));
  if (wanted.has("colour")) colourBy(wanted.get("colour"));
  const time = parseFloat(wanted.get("t")), number = parseInt(wanted.get("event"), 10);
  if (Number.isFinite(time)) goTo(placeAtTime(time));
  else {
    const event = facts.events.find((one) => one.number >= number); // of very many some are listed
    if (event) goTo(event.frame);
  }
  if (wanted.has("play") && !calm.matches) play();
}

const ROOMY = window.matchMedia("(min-width: 900px) and (min-height: 800px)");

/** What the run warns of is open where there is room for it; its number is always seen, and opens it. */
function connectWarnings() {
  const button = $("warn");
  if (!button) return;
  const open = (now) => {
    $("warnings").hidden = !now;
    button.setAttribute("aria-expanded", String(now));
  };
  open(ROOMY.matches);
  button.addEventListener("click", () => open($("warnings").hidden));
  button.addEventListener("mousedown", (event) => event.preventDefault());
  document.addEventListener("keydown", (event) => { if (event.key === "Escape") open(false); });
}

function connect() {
  const actions = {
    play: toggleByHand, home: KEYS.Home, end: KEYS.End, back: () => step(-1), forward: () => step(1),
    "event-back": () => stepEvent(-1), "event-forward": () => stepEvent(1),
    "zoom-in": KEYS["+"], "zoom-out": KEYS["-"], "zoom-all": resetZoom,
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
  $("range").addEventListener("change", () => {
    show.follow = $("range").value === "follow";
    freeTime();
  });
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
  charts.forEach(connectChart);
  connectScene();
  connectTabs();
  connectWarnings();
}

readColours();
setScene(facts.factor);
offerFactors();
offerResults();
listEvents();
listContacts();
connect();
if (facts.touch === STATIONS - 1) $("tip-title").textContent = "Tip, true scale";
setTheme(document.documentElement.dataset.theme);
showZoom();
followFragment();

/* For a page that embeds this one, and for tests. */
window.player = {
  play, pause, step, stepEvent, goTo,
  seek: (time) => goTo(placeAtTime(time)),
  now: () => ({ ...momentAt(show.place, newMoment()), playing: show.playing, result: result.name, frames: FRAMES }),
  facts, arrays, envelope, zoom,
  place: (name) => touchPlace(name === "inset" ? insetView(moment, inset.surface.width, inset.surface.height) : sceneView(scene.surface.width, scene.surface.height), moment),
};
