// What viser's page does not do by itself: a splash until it is there, sliders with names, keys after a menu was used,
// telling which tabs are open, and clicks into pictures.
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

  // What the page tells the server are the values of text fields that people do not see. They are sent past viser, which
  // sends a message of a panel every 50 milliseconds and of those in between the last one alone: a click or a value that
  // a person gives would be lost to what the page tells, or the other way round.
  let connection = null;
  let kept = null; // the field whose values wait, and the newest of them
  window.Worker = class extends Worker {
    constructor(...how) {
      super(...how);
      this.addEventListener("message", ({ data }) => {
        if (data.type === "connected") connection = this;
        for (const message of data.messages ?? []) {
          if (message.type !== "GuiUpdateMessage" || message.uuid !== kept?.uuid) continue;
          kept.updates = { ...kept.updates, ...message.updates };
          message.updates = {};
        }
      });
    }
  };
  const give = (message) =>
    connection.dispatchEvent(new MessageEvent("message", { data: { type: "message_batch", messages: [message] } }));
  const told = new Map(); // the last value of each field, by viser's name for it: that of a new connection is another
  function tell(field, value) {
    const uuid = uuidOf(field);
    if (!connection || !uuid || told.get(uuid) === value) return;
    told.set(uuid, value);
    connection.postMessage({ type: "send", message: { type: "GuiUpdateMessage", uuid, updates: { value } } });
  }

  const uuidOf = (field) => [...document.querySelectorAll("label")].find((each) => each.textContent === field)?.htmlFor;

  function write(input, text) {
    Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value").set.call(input, text);
    input.dispatchEvent(new Event("input", { bubbles: true }));
  }

  // The splash stands before the page until the server has built it and everything has its place, or something else is
  // to be seen. Times are in milliseconds.
  const [LONGEST_SPLASH, AT_REST, FADING, LOOKING] = [15_000, 300, 400, 50];
  const PHONE = 600; // pixels; there, nothing stands beside the canvas
  function place() {
    const canvas = document.querySelector("canvas[data-engine]")?.getBoundingClientRect();
    const placed = canvas?.width && uuidOf("Open tabs") && (canvas.left > 0 || innerWidth <= PHONE);
    return placed ? [canvas.left, canvas.top, canvas.width, canvas.height].join() : "";
  }
  const began = performance.now();
  let [last, since] = ["", began];
  const looking = setInterval(() => {
    const [now, at] = [performance.now(), place()];
    if (at !== last) [last, since] = [at, now];
    const rests = at && now - since > AT_REST;
    if (!rests && now - began < LONGEST_SPLASH && !document.querySelector("[data-no-page], [data-banner]")) return;
    clearInterval(looking);
    document.getElementById("ido-splash")?.classList.add("gone");
    tellTabs();
    setTimeout(() => document.getElementById("ido-splash")?.remove(), FADING);
  }, LOOKING);

  // The server draws the charts of the tabs that are open, and no others. A page that connects anew has an empty field.
  let telling = null;
  function tellTabs() {
    telling = null;
    if (document.querySelector("#ido-splash:not(.gone)")) return; // it plays once somebody can see it
    const tabs = [...document.querySelectorAll("[role=tab][aria-selected=true]")];
    const open = tabs.map((tab) => tab.textContent.trim()).join();
    if (open) tell("Open tabs", open);
  }
  new MutationObserver(() => {
    telling ??= setTimeout(tellTabs, 30);
  }).observe(document, { subtree: true, childList: true, attributes: true, attributeFilter: ["aria-selected"] });

  // In a small window, what a tab of the control panel holds begins below the panel's end: opening it brings it into
  // view, as it comes.
  const COMING = 1500; // milliseconds
  addEventListener("click", (event) => {
    const tabs = event.target.closest?.("[role=tab]")?.closest(".mantine-ScrollArea-viewport [data-dock-group]");
    if (!tabs) return;
    const growing = new ResizeObserver(() => tabs.scrollIntoView({ block: "nearest", behavior: "smooth" }));
    growing.observe(tabs);
    setTimeout(() => growing.disconnect(), COMING);
  });

  // A number field that is left with nothing or with half a number in it keeps it, though the value is still the last
  // number; it gets that back.
  const isNumber = (field) => field.matches?.(".mantine-NumberInput-input");
  const holdsOne = (field) => field.value.trim() !== "" && Number.isFinite(Number(field.value));
  for (const kind of ["focusin", "input"])
    addEventListener(kind, ({ target }) => {
      if (isNumber(target) && holdsOne(target)) target.dataset.number = target.value;
    });
  const fill = ({ target, type, key }) => {
    if (!isNumber(target) || target.dataset.number === undefined || (type === "keydown" && key !== "Enter")) return;
    setTimeout(() => holdsOne(target) || write(target, target.dataset.number));
  };
  for (const kind of ["focusout", "keydown"]) addEventListener(kind, fill);

  // A decimal comma is a decimal point. In a field of whole numbers, which refuses the point, what follows it would be
  // taken for more digits, 12.7 for 127; it is refused, too.
  let point = null; // the field that a decimal point was typed into just now
  addEventListener(
    "beforeinput",
    (event) => {
      const { target, data } = event;
      if (!isNumber(target) || !data) return;
      if (/^\d+$/.test(data) && point === target && !target.value.includes(".")) return event.preventDefault();
      point = /[.,]$/.test(data) ? target : null;
      if (!/^-?\d*,\d*$/.test(data)) return;
      event.preventDefault();
      document.execCommand("insertText", false, data.replace(",", "."));
    },
    true,
  );
  addEventListener("keydown", ({ key }) => /^\d$/.test(key) || (point = null), true);
  addEventListener("focusout", () => (point = null), true);

  // What plays would write over a number that a person types there; so it pauses first. The button, which is another one
  // once the server has heard of it, is not pressed again before that.
  const HEARD = 1500; // milliseconds
  let paused = -HEARD;
  const pauses = ({ target, type, key, timeStamp }) => {
    if (!isNumber(target) || (type === "keydown" && !/^Arrow(Up|Down)$/.test(key)) || timeStamp - paused < HEARD) return;
    if (!document.getElementById(uuidOf("Iteration"))?.parentElement.contains(target)) return;
    const button = [...document.querySelectorAll("button")].find((each) => each.textContent.trim() === "Pause (P)");
    if (!button) return;
    paused = timeStamp;
    button.click();
    keep(target);
  };
  // Frames that are on their way would be written there until then. They wait; the newest comes if nothing was typed.
  // A number that was marked, to be typed over, stays marked.
  const [ON_THE_WAY, SHOWN] = [1000, 60]; // milliseconds
  function keep(field) {
    const mine = (kept = { uuid: uuidOf("Iteration") });
    const typed = (event) => event.isTrusted && (mine.typed = true);
    field.addEventListener("input", typed, true);
    setTimeout(() => {
      field.removeEventListener("input", typed, true);
      kept = null;
      if (!mine.updates || mine.typed) return;
      const marked = field.selectionStart === 0 && field.selectionEnd === field.value.length;
      give({ type: "GuiUpdateMessage", uuid: mine.uuid, updates: mine.updates });
      if (marked) setTimeout(() => field === document.activeElement && field.select(), SHOWN);
    }, ON_THE_WAY);
  }
  for (const kind of ["pointerdown", "keydown", "beforeinput"]) addEventListener(kind, pauses, true);

  // Escape closes a window that stands over the page, by its button.
  addEventListener("keydown", (event) => {
    if (event.key !== "Escape") return;
    const buttons = [...document.querySelectorAll("[role=dialog] button")];
    buttons.find((button) => button.textContent.trim() === "Close")?.click();
  });

  // Arrows move the slider that has the focus; viser would turn the camera by them, too.
  addEventListener("DOMContentLoaded", () =>
    document.body.addEventListener("keydown", (event) => {
      if (event.key.startsWith("Arrow") && event.target.closest?.("[role=slider]")) event.stopPropagation();
    }),
  );

  // A menu keeps the focus once something was chosen, and letter keys, which are the page's, would go on into it.
  addEventListener("click", (event) => {
    if (event.target.closest?.("[role=option]")) setTimeout(() => document.activeElement?.blur(), 50);
  });

  // A click into a heatmap, a histogram or a list of bins picks a bin, one into the map of a basin a start.
  let picks = 0;

  const pick = (text) => tell("Picked bin", `${text} ${++picks}`);

  // Where in a picture a click was, from 0 at its left edge to 1.
  const share = (event, element) => {
    const box = element.getBoundingClientRect();
    return Math.min(Math.max((event.clientX - box.left) / box.width, 0), 0.99999).toFixed(5);
  };

  // All that a hand does in one go, from a button or key that goes down to the next that does, is one change, however
  // long it takes; so these are counted. The count is not that of a page that this one goes on from. It is also told
  // whether a slider is held, for then its scene stays in the hand. It is told when the hand rests: what the hand did
  // before comes first.
  const RESTING = 120; // milliseconds
  let [gestures, holds, lastMove, counting] = [Date.now() % 1e7, false, -RESTING, null];
  function tellGesture() {
    const left = lastMove + RESTING - performance.now();
    counting = left > 0 ? setTimeout(tellGesture, left) : null;
    if (left <= 0) tell("Gesture", `${gestures}${holds ? " held" : ""}`);
  }
  const moves = (event) => {
    if (event.isTrusted && (event.type !== "pointermove" || event.buttons)) lastMove = performance.now();
  };
  for (const kind of ["pointerdown", "keydown"])
    addEventListener(
      kind,
      (event) => {
        if (event.repeat) return;
        gestures += 1;
        holds = kind === "pointerdown" && Boolean(event.target.closest?.(".mantine-Slider-root"));
        if (counting === null) tellGesture();
      },
      true,
    );
  for (const kind of ["pointerdown", "pointermove", "pointerup", "keydown", "input"]) addEventListener(kind, moves, true);
  for (const kind of ["pointerup", "pointercancel", "blur"])
    addEventListener(
      kind,
      (event) => {
        if (!holds || (kind === "blur" && event.target !== window)) return;
        holds = false;
        if (counting === null) tellGesture();
      },
      true,
    );

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
      if (listed) return pick(`bin ${listed.dataset.pane} ${listed.dataset.bin}`);
      const start = target.closest("[data-start]");
      if (start) return pick(`start 0 ${start.dataset.start}`);
      const heatmap = target.closest("[data-heatmap]");
      if (heatmap) return pick(`${heatmap.dataset.heatmap} ${heatmap.dataset.pane} ${share(event, heatmap)}`);
      const chart = target.closest(".uplot")?.querySelector(".u-over");
      if (!chart) return;
      const heads = [...document.querySelectorAll("[data-histogram]")].filter(
        (head) => head.compareDocumentPosition(chart) & Node.DOCUMENT_POSITION_FOLLOWING,
      );
      const head = heads.at(-1);
      const charts = head && [...document.querySelectorAll(".u-over")].filter(
        (each) => head.compareDocumentPosition(each) & Node.DOCUMENT_POSITION_FOLLOWING,
      );
      if (head && charts[0] === chart) pick(`shown ${head.dataset.histogram} ${share(event, chart)}`);
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
