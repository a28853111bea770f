/* What is written beside the pictures. */

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
  markContact();
  if (show.playing) return;
  const said = `t = ${time}, ${name}${moment.state ? `, normal force ${significant(moment.normal, 3)} N` : ""}`;
  speak(said);
  $("scene").setAttribute("aria-label", `The beam at ${said}; in colour: ${result.title}`);
}

const QUIET = 400; // ms without a change before it is spoken
let speech = 0;

/** Tell a screen reader where the run stands, once it stands there. */
function speak(text) {
  clearTimeout(speech);
  if ($("spoken").textContent !== text) speech = setTimeout(() => ($("spoken").textContent = text), QUIET);
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
  const count = facts.warnings.length, warned = embed.on && count > 0; // the whole page lists them
  const notes = [
    text, thick > 1 && `thickness ×${thick}`, zoom.by > 1 && `zoom ×${short(zoom.by)}`,
    warned && `${count} warning${count > 1 ? "s" : ""}: see the whole page`,
  ];
  $("deformation").textContent = notes.filter(Boolean).join(", ");
}
