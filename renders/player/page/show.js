/* What is shown of the run now, and how that goes on. */

const $ = (id) => document.getElementById(id);
const show = { place: 0, playing: false, speed: 1, loop: false, follow: true, last: 0, asked: false };
const moment = newMoment();
const charts = chartSpecs();
const DECIMALS = Math.min(12, Math.max(5, 6 - Math.ceil(Math.log10(END - START || 1) - 1e-9)));

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
  const window = zoomedWindow(moment);
  for (const chart of charts) {
    drawChart(chart, moment, window);
    writeLegend(chart, moment);
  }
  drawStrip();
  writeStatus();
}

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
  button.setAttribute("aria-label", show.playing ? "Pause" : "Play");
  $("play-icon").setAttribute("d", show.playing ? "M5 4h5v16H5zM14 4h5v16h-5z" : "M6 4v16l14-8z");
}

function toggle() {
  if (show.playing) pause();
  else play();
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
