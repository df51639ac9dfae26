// A chart's new data come as what differs from those that it was made with (`changed` in `ido_viz/panels/plot.py`), and are
// put together here before viser sees them. What differs from the data before would be shorter still, but viser's server
// leaves out what a slow page has not taken yet.
(() => {
  const made = new Map(); // the columns of each chart

  function whole(columns, [head, ...parts]) {
    return columns.map((column, i) => {
      const all = Float64Array.from(column);
      all.set(parts[i], head[1 + i]);
      return all;
    });
  }

  function read({ data }) {
    if (data.type === "connected") made.clear();
    for (const message of data.messages ?? []) {
      if (message.type === "GuiUplotMessage") made.set(message.uuid, message.props.data);
      if (message.type === "GuiRemoveMessage") made.delete(message.uuid);
      const columns = message.type === "GuiUpdateMessage" && made.get(message.uuid);
      const sent = columns && message.updates.data;
      if (sent && Number.isNaN(sent[0][0])) message.updates.data = whole(columns, sent);
    }
  }

  window.Worker = class extends Worker {
    constructor(...how) {
      super(...how);
      this.addEventListener("message", read); // the first of all that listen
    }
  };
})();

// A chart gets its width and new data at once. uPlot's `setSize` asks for new axes, and its `redraw`, which the data cause,
// forgets that again: the axes stay those of no width, without names and dividers. Such a chart is drawn once more. viser
// keeps its charts for tests of its own; that is where they can be reached.
setInterval(() => {
  for (const { chart } of Object.values(window.__viserTestpoints?.uplots ?? {}))
    if (chart.bbox.width > 0 && chart.axes.some((axis) => axis._found?.[1] === 0)) chart.redraw(false, true);
}, 200);

// A menu whose options change is closed by that. While one is open its new options wait; the newest come when it closes.
(() => {
  const waiting = new Map(); // the newest options of each open menu

  const isOpen = (uuid) => document.getElementById(uuid)?.getAttribute("aria-expanded") === "true";

  window.Worker = class extends Worker {
    constructor(...how) {
      super(...how);
      this.addEventListener("message", ({ data }) => {
        if (data.type === "connected") waiting.clear();
        for (const message of data.messages ?? []) {
          if (message.type !== "GuiUpdateMessage" || !message.updates.options) continue;
          waiting.delete(message.uuid);
          if (!isOpen(message.uuid)) continue;
          waiting.set(message.uuid, message.updates.options);
          delete message.updates.options;
        }
      });
      const deliver = () => {
        const uuids = [...waiting.keys()].filter((uuid) => !isOpen(uuid));
        if (!uuids.length) return;
        const messages = uuids.map((uuid) => ({
          type: "GuiUpdateMessage",
          uuid,
          updates: { options: waiting.get(uuid) },
        }));
        uuids.forEach((uuid) => waiting.delete(uuid));
        this.dispatchEvent(new MessageEvent("message", { data: { type: "message_batch", messages } }));
      };
      setInterval(deliver, 300);
    }
  };
})();
