/* The page inside another one, at "#embed": the beam and the transport, playing while it is in view. */

const calm = window.matchMedia("(prefers-reduced-motion: reduce)");
const embed = { on: false, held: false, watch: null };

/** Show the whole page, or what another page embeds. */
function setEmbedded(on) {
  if (on === embed.on) return;
  embed.on = on;
  document.documentElement.classList.toggle("embed", on);
  // over the picture, which keeps its size
  if (on) document.querySelector(".status").append($("deformation"));
  else document.querySelector(".choices").before($("deformation"));
  embed.watch?.disconnect();
  if (on) {
    $("whole").href = window.location.href.split("#")[0];
    $("loop").checked = show.loop = true;
    embed.watch = new IntersectionObserver(([entry]) => followView(entry), { threshold: [0, 0.5] });
    embed.watch.observe(document.body);
  }
  refresh();
}

/** Play where at least half of it is seen, pause where nothing is; not against the reader, who may have paused. */
function followView({ intersectionRatio: seen }) {
  if (seen === 0) {
    if (show.playing) pause();
  } else if (seen >= 0.5 && !embed.held && !calm.matches && !show.playing) {
    play();
  }
}
