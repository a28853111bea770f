/* Events and contacts in lists: one stop of the Tab key each, arrows inside; a press jumps there. */

let eventButtons = [];
let current = -1;

function listEvents() {
  const host = $("events");
  eventButtons = facts.events.map((event) => {
    const button = made("button", ""), dot = made("i", ""), item = made("li", "");
    button.type = "button";
    dot.style.background = facts.state_colours[event.state];
    const impulse = event.impulse ? `${significant(event.impulse, 3)} N s` : "";
    const kind = made("span", `${event.number} ${event.kind}`);
    kind.append(" ", made("small", impulse));
    button.append(dot, made("span", `${fixed(event.time, 6)}`), kind);
    button.title = `t = ${event.time} s, then ${facts.states[event.state]}`;
    button.addEventListener("click", () => goTo(event.frame));
    item.append(button);
    host.append(item);
    return button;
  });
  rove(eventButtons);
  const shown = facts.events.length, all = facts.all_events;
  $("events-note").textContent = shown === 0 ? "none in this run" : shown < all ? `${shown} of ${all}; time (s)` : "time (s), number, kind, impulse";
}

/** Last of some events or contacts that has begun at the present place; -1 before the first. */
function lastBegun(list) {
  let low = -1, high = list.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (list[middle].frame <= show.place) low = middle;
    else high = middle - 1;
  }
  return low;
}

const eventHere = () => lastBegun(facts.events);

function markEvent() {
  const k = eventHere();
  if (k === current) return;
  setCurrent(eventButtons, current, k);
  current = k;
  const button = eventButtons[k], host = $("events");
  if (!button) {
    host.scrollTop = 0;
    return;
  }
  const top = button.offsetTop - host.offsetTop;
  if (top < host.scrollTop || top + button.offsetHeight > host.scrollTop + host.clientHeight) {
    host.scrollTop = top - host.clientHeight / 2;
  }
}

// Contacts -------------------------------------------------------------------------------------------------------

const COLUMNS = ["start (s)", "end (s)", "state", "normal impulse (N\u00a0s)", "peak force (N)", "loss (J)"];
let contactButtons = [];
let contact = -1;

function listContacts() {
  const table = $("contacts"), head = made("tr", "");
  for (const name of COLUMNS) {
    const cell = made("th", name);
    cell.scope = "col";
    head.append(cell);
  }
  table.tHead.append(head);
  contactButtons = facts.contacts.map((one) => {
    const row = made("tr", ""), first = made("td", ""), button = made("button", fixed(one.start, 6));
    button.type = "button";
    button.title = "Jump to its start";
    button.addEventListener("click", () => goTo(one.frame));
    first.append(button);
    row.append(first, ...contactCells(one).map((text) => made("td", text)));
    table.tBodies[0].append(row);
    return button;
  });
  rove(contactButtons);
  $("contacts-note").textContent = facts.contacts.length ? "" : "There is no contact in this run.";
  table.hidden = !facts.contacts.length;
}

/** What the columns after the first one say of a contact. */
function contactCells({ end, states, impulse, peak_force: force, loss }) {
  const passed = states.map((state) => facts.states[state].toLowerCase()).join(", ");
  const number = (value) => (value === null ? "–" : significant(value, 4));
  const largest = passed ? number(force) : "–"; // a rebound is an impulse alone
  return [end === null ? "open" : fixed(end, 6), passed || "rebound", number(impulse), largest, number(loss)];
}

/** The contact that lasts, or the last one that there was. */
function markContact() {
  const k = lastBegun(facts.contacts);
  if (k === contact) return;
  setCurrent(contactButtons, contact, k);
  contact = k;
}

// Both -----------------------------------------------------------------------------------------------------------

/** Of some buttons one is a stop of the Tab key; arrows up and down go on from there. */
function rove(buttons) {
  buttons.forEach((button, k) => {
    button.tabIndex = k ? -1 : 0;
    button.addEventListener("keydown", (event) => {
      const next = buttons[k + { ArrowDown: 1, ArrowUp: -1 }[event.key]];
      if (!next) return;
      event.preventDefault();
      takeStop(buttons, next);
      next.focus();
    });
    button.addEventListener("focus", () => takeStop(buttons, button));
  });
}

function takeStop(buttons, chosen) {
  for (const button of buttons) button.tabIndex = button === chosen ? 0 : -1;
}

function setCurrent(buttons, before, now) {
  buttons[before]?.removeAttribute("aria-current");
  buttons[now]?.setAttribute("aria-current", "true");
  if (!buttons.includes(document.activeElement)) takeStop(buttons, buttons[Math.max(now, 0)]);
}

/** Charts or the table of contacts. */
function openTab(name) {
  for (const tab of document.querySelectorAll('[role="tab"]')) {
    const open = tab.id === name;
    tab.setAttribute("aria-selected", String(open));
    tab.tabIndex = open ? 0 : -1;
    $(tab.getAttribute("aria-controls")).hidden = !open;
  }
  refresh();
}

function connectTabs() {
  const tabs = [...document.querySelectorAll('[role="tab"]')];
  tabs.forEach((tab, k) => {
    tab.addEventListener("click", () => openTab(tab.id));
    tab.addEventListener("keydown", (event) => {
      if (event.key !== "ArrowRight" && event.key !== "ArrowLeft") return;
      event.preventDefault();
      event.stopPropagation(); // the page would step a frame
      const other = tabs[(k + 1) % tabs.length];
      openTab(other.id);
      other.focus();
    });
  });
}
