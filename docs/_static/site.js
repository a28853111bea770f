/* An embedded player has the theme of this page: that of the switch, which may differ from the system's. */
document.addEventListener("DOMContentLoaded", () => {
  const follow = () => {
    for (const frame of document.querySelectorAll(".player iframe")) {
      const wanted = `${frame.src.split("#")[0]}#embed&theme=${document.body.dataset.theme || "auto"}`;
      if (frame.src !== wanted) frame.src = wanted; // one that is on its way already is not asked for again
    }
  };
  new MutationObserver(follow).observe(document.body, { attributes: true, attributeFilter: ["data-theme"] });
  follow();
});
