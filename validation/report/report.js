"use strict";
(() => {
  const root = document.documentElement;
  const all = (selector, inside = document) => [...inside.querySelectorAll(selector)];
  const remembered = {
    get: () => { try { return localStorage.getItem("report-theme"); } catch { return null; } },
    set: (theme) => { try { localStorage.setItem("report-theme", theme); } catch { /* a page that may not remember */ } },
  };

  // theme: the reader's system decides until the button is pressed
  const button = document.getElementById("theme");
  const dark = () => root.dataset.theme ? root.dataset.theme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
  const name = () => { button.textContent = dark() ? "Light theme" : "Dark theme"; };
  if (["light", "dark"].includes(remembered.get())) root.dataset.theme = remembered.get();
  button.addEventListener("click", () => {
    root.dataset.theme = dark() ? "light" : "dark";
    remembered.set(root.dataset.theme);
    name();
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", name);
  name();

  // folding: a link opens what it leads to, one button opens or folds everything
  const parts = all("section > details");
  const fold = document.getElementById("fold");
  const rename = () => { fold.textContent = parts.every((part) => part.open) ? "Fold all" : "Open all"; };
  const reveal = () => {
    const target = location.hash && document.getElementById(decodeURIComponent(location.hash.slice(1)));
    const part = target && target.querySelector("details");
    if (part) { part.open = true; target.scrollIntoView(); }
  };
  fold.hidden = parts.length === 0;
  fold.addEventListener("click", () => {
    const open = !parts.every((part) => part.open);
    parts.forEach((part) => { part.open = open; });
  });
  parts.forEach((part) => part.addEventListener("toggle", rename));
  addEventListener("hashchange", reveal);
  rename();
  reveal();

  // paper shows everything
  const folded = new Set();
  addEventListener("beforeprint", () => all("details:not([open])").forEach((part) => { folded.add(part); part.open = true; }));
  addEventListener("afterprint", () => { folded.forEach((part) => { part.open = false; }); folded.clear(); });

  // filter: words of a row, of its item and of its section, all of which have to occur; and a verdict
  const text = document.getElementById("filter");
  if (text) {
    const verdict = document.getElementById("verdict");
    const shown = document.getElementById("shown");
    const words = (element) => (element ? element.textContent : "").toLowerCase();
    const rows = all("tr[data-verdict]").map((row) => {
      const item = row.closest(".item");
      const section = row.closest("section");
      const own = [row, item && item.querySelector("p"), item && item.querySelector("p.note"), section.querySelector("h2")];
      return { row, item, section, words: own.map(words).join(" ") };
    });
    let before = null; // what was open before the filter
    const apply = () => {
      const wanted = text.value.toLowerCase().split(/\s+/).filter(Boolean);
      const active = wanted.length > 0 || verdict.value !== "";
      const kept = rows.filter((r) => wanted.every((w) => r.words.includes(w)) && (!verdict.value || r.row.dataset.verdict === verdict.value));
      const keep = new Set(kept.flatMap((r) => [r.row, r.item, r.section]));
      rows.forEach((r) => [r.row, r.item, r.section].forEach((e) => e && e.classList.toggle("left-out", !keep.has(e))));
      if (active && !before) before = parts.map((part) => part.open);
      if (active) parts.forEach((part) => { part.open = keep.has(part.parentElement); });
      if (!active && before) { parts.forEach((part, k) => { part.open = before[k]; }); before = null; }
      document.getElementById("overview").classList.toggle("left-out", active);
      shown.textContent = active ? `${kept.length} of ${rows.length} measurements` : "";
    };
    text.addEventListener("input", apply);
    verdict.addEventListener("change", apply);
    apply();
  }

  // what scrolls inside of itself can be reached by keyboard
  const reachable = () => all(".scroll").forEach((box) => {
    if (box.scrollWidth > box.clientWidth) box.tabIndex = 0; else box.removeAttribute("tabindex");
  });
  new ResizeObserver(reachable).observe(document.querySelector("main"));
  document.querySelector(".controls").hidden = false;
})();
