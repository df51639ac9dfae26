// What viser's page does not do by itself: sliders with names, keys after a menu was used, telling which tabs are open,
// and clicks into pictures.
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

  // What the page tells the server goes through text fields, the one thing that a page of viser can write into; people
  // do not see them.
  function field(name) {
    const label = [...document.querySelectorAll("label")].find((each) => each.textContent === name);
    return label?.closest(".mantine-Flex-root")?.querySelector("input");
  }

  function write(input, text) {
    Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value").set.call(input, text);
    input.dispatchEvent(new Event("input", { bubbles: true }));
  }

  // The server draws the charts of the tabs that are open, and no others. A page that connects anew has an empty field.
  let telling = null;
  let told = null;
  function tellTabs() {
    telling = null;
    const tabs = [...document.querySelectorAll("[role=tab][aria-selected=true]")];
    const open = tabs.map((tab) => tab.textContent.trim()).join();
    if (!told?.isConnected) told = field("Open tabs");
    if (told && open && told.value !== open) write(told, open);
  }
  new MutationObserver(() => {
    telling ??= setTimeout(tellTabs, 30);
  }).observe(document, { subtree: true, childList: true, attributes: true, attributeFilter: ["aria-selected"] });

  // In a small window, what a tab of the control panel holds begins below the panel's end: opening it brings it into view.
  addEventListener("click", (event) => {
    const tabs = event.target.closest?.("[role=tab]")?.closest(".mantine-ScrollArea-viewport [data-dock-group]");
    if (tabs) setTimeout(() => tabs.scrollIntoView({ block: "nearest", behavior: "smooth" }), 100);
  });

  // A menu keeps the focus once something was chosen, and letter keys, which are the page's, would go on into it.
  addEventListener("click", (event) => {
    if (event.target.closest?.("[role=option]")) setTimeout(() => document.activeElement?.blur(), 50);
  });

  // A click into a heatmap, a histogram or a list of bins picks a bin, one into the map of a basin a start.
  let picks = 0;

  function tell(text) {
    const input = field("Picked bin");
    if (input) write(input, `${text} ${++picks}`);
  }

  // Where in a picture a click was, from 0 at its left edge to 1.
  const share = (event, element) => {
    const box = element.getBoundingClientRect();
    return Math.min(Math.max((event.clientX - box.left) / box.width, 0), 0.99999).toFixed(5);
  };

  // The browser makes no click of a button that goes down and up on a picture which was replaced meanwhile, as pictures
  // are while the page plays. So a click is here what goes up where it went down.
  const STILL = 5; // pixels
  let down = null;
  addEventListener("pointerdown", (event) => (down = event), true);
  addEventListener(
    "pointerup",
    (event) => {
      const moved = down && Math.hypot(event.clientX - down.clientX, event.clientY - down.clientY);
      const target = event.target;
      if (event.button !== 0 || moved === null || moved > STILL || !(target instanceof Element)) return;
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

  // What is larger than the server takes is refused before it is sent. A file that is dropped on an upload button is
  // as if it were chosen there.
  const MOST_UPLOAD = 64 << 20;
  addEventListener(
    "change",
    (event) => {
      const file = event.target.type === "file" && event.target.files?.[0];
      if (!file || (file.size > 0 && file.size <= MOST_UPLOAD)) return;
      event.stopImmediatePropagation();
      alert(
        file.size
          ? `${file.name} has ${Math.ceil(file.size / 2 ** 20)} MB, and at most 64 MB can be uploaded. Thin it first, ` +
              "or start the explorer with ido-viz --cloud FILE."
          : `${file.name} is empty.`,
      );
    },
    true,
  );
  // One that is dropped on the canvas goes to the first button for uploads that can be seen.
  const inputAt = (target) => {
    const button = target.closest?.(".mantine-Button-root");
    if (button) return button.parentElement?.querySelector("input[type=file]");
    if (!target.closest?.("canvas")) return null;
    const seen = (input) => input.parentElement?.querySelector(".mantine-Button-root")?.offsetParent;
    return [...document.querySelectorAll("input[type=file]")].find(seen);
  };
  const dropped = (event) => {
    const input = event.dataTransfer?.types.includes("Files") && inputAt(event.target);
    if (!input) return null;
    event.preventDefault();
    return input;
  };
  addEventListener("dragover", dropped, true);
  addEventListener(
    "drop",
    (event) => {
      const input = dropped(event);
      if (!input) return;
      input.files = event.dataTransfer.files;
      input.dispatchEvent(new Event("change", { bubbles: true }));
    },
    true,
  );
})();
