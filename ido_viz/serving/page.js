// What viser's page does not do by itself: sliders with names, keys after a menu was used, and clicks into pictures.
(() => {
  // A slider's thumb has no accessible name; it gets that of its row.
  function nameSliders() {
    for (const thumb of document.querySelectorAll('[role=slider]:not([data-named])')) {
      const root = thumb.closest(".mantine-Slider-root");
      const label = root && document.querySelector(`label[for="${CSS.escape(root.id)}"]`);
      if (!label) continue;
      thumb.setAttribute("aria-label", label.textContent.trim());
      thumb.dataset.named = "yes";
    }
  }
  let naming = null;
  new MutationObserver(() => {
    naming ??= setTimeout(() => {
      naming = null;
      nameSliders();
    }, 300);
  }).observe(document, { subtree: true, childList: true });

  // A menu keeps the focus once something was chosen, and letter keys, which are the page's, would go on into it.
  addEventListener("click", (event) => {
    if (event.target.closest?.("[role=option]")) setTimeout(() => document.activeElement?.blur(), 50);
  });

  // A click into a heatmap, a histogram or a list of bins picks a bin, one into the map of a basin a start. It is told to the server through a text field,
  // the one thing that a page of viser can write into; people do not see it.
  const FIELD = "Picked bin";
  let picks = 0;

  function field() {
    const label = [...document.querySelectorAll("label")].find((each) => each.textContent === FIELD);
    return label?.closest(".mantine-Flex-root")?.querySelector("input");
  }

  function tell(text) {
    const input = field();
    if (!input) return;
    Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value").set.call(input, `${text} ${++picks}`);
    input.dispatchEvent(new Event("input", { bubbles: true }));
  }

  // Where in a picture a click was, from 0 at its left edge to 1.
  const share = (event, element) => {
    const box = element.getBoundingClientRect();
    return Math.min(Math.max((event.clientX - box.left) / box.width, 0), 0.99999).toFixed(5);
  };

  addEventListener(
    "click",
    (event) => {
      const target = event.target;
      if (!(target instanceof Element)) return;
      const listed = target.closest("[data-bin]");
      if (listed) return tell(`bin ${listed.dataset.pane} ${listed.dataset.bin}`);
      const start = target.closest("[data-start]");
      if (start) return tell(`start 0 ${start.dataset.start}`);
      const heatmap = target.closest("[data-heatmap]");
      if (heatmap) return tell(`${heatmap.dataset.heatmap} ${heatmap.dataset.pane} ${share(event, heatmap)}`);
      const chart = target.closest(".uplot")?.querySelector(".u-over");
      if (!chart) return;
      const heads = [...document.querySelectorAll("[data-histogram]")].filter(
        (head) => head.compareDocumentPosition(chart) & Node.DOCUMENT_POSITION_FOLLOWING,
      );
      const head = heads.at(-1);
      const charts = head && [...document.querySelectorAll(".u-over")].filter(
        (each) => head.compareDocumentPosition(each) & Node.DOCUMENT_POSITION_FOLLOWING,
      );
      if (head && charts[0] === chart) tell(`shown ${head.dataset.histogram} ${share(event, chart)}`);
    },
    true,
  );
})();
