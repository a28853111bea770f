/* An embedded player has the theme of this page: that of the switch, which may differ from the system's. */
document.addEventListener("DOMContentLoaded", () => {
  const follow = () => {
    for (const frame of document.querySelectorAll(".player iframe")) {
      const page = frame.src.split("#")[0];
      frame.src = `${page}#embed&theme=${document.body.dataset.theme || "auto"}`;
    }
  };
  new MutationObserver(follow).observe(document.body, { attributes: true, attributeFilter: ["data-theme"] });
  follow();
});
