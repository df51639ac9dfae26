// The page's address carries what it shows, as its fragment: #state=ido1-… and the lesson, if there is one.
//
// It stands before viser's own script, which knows nothing of it. Every connection that viser makes tells the server the
// fragment, in its own address; so a page that is opened, loaded again, or found by a server that was started anew is
// what its address says. Each page has a name, by which a server that still runs gives back what it had computed. The
// server writes what the page came to show into an invisible element, and from there it goes back into the address.
// Another fragment, typed or pasted, is a new connection. While there is none, a banner says so.
(() => {
  const LONGEST = 2000; // characters; the server says that it is too long when there is one more
  const CALM = 400; // milliseconds; browsers refuse to change an address many times a second

  // A link may have them after ? as well, where mail programs and course pages leave them alone.
  const query = new URLSearchParams(location.search);
  const asked = ["lesson", "state"].filter((key) => query.has(key));
  let fragment = location.hash.slice(1) || asked.map((key) => `${key}=${encodeURIComponent(query.get(key))}`).join("&");
  let connection = null; // viser's worker, which holds the socket
  let published = null; // the element that was read last
  let copied = null;
  let writing = null;

  // viser would take a fragment for a part of its server's name, and another server from an address that says so.
  const token = query.get("token");
  const page = location.pathname + (token === null ? "" : `?token=${encodeURIComponent(token)}`);
  history.replaceState(null, "", page);

  const show = () => history.replaceState(null, "", fragment ? `${page}#${fragment}` : page);

  // By this name the server knows a page that comes back, and what it could undo; another tab has another.
  function name() {
    try {
      return (sessionStorage.ido ??= drawn());
    } catch {
      return ""; // a frame that may store nothing
    }
  }

  const drawn = () => Array.from(crypto.getRandomValues(new Uint8Array(16)), (byte) => byte.toString(16)).join("-");

  function server() {
    const url = new URL(page, location.origin.replace(/^http/, "ws"));
    url.searchParams.set("page", name());
    url.searchParams.set("path", location.pathname);
    url.searchParams.set("fragment", fragment.slice(0, LONGEST + 1));
    if (matchMedia("(prefers-color-scheme: dark)").matches) url.searchParams.set("dark", "yes");
    return url.href;
  }

  // viser pales the panels while its server is away, or has no room, but does not say so.
  const AWAY = "The explorer is not running. This page goes on by itself when it runs again.";
  const FULL = "The explorer is full. This page goes on by itself when somebody closes theirs.";
  const banner = document.createElement("div");
  banner.setAttribute("role", "status");
  banner.dataset.banner = "";
  banner.textContent = AWAY;
  banner.style.cssText =
    "position:fixed;top:12px;left:50%;transform:translateX(-50%);z-index:1000;padding:8px 16px;border-radius:4px;" +
    "background:#c92a2a;color:#fff;font:0.875rem sans-serif";

  function tell(what) {
    if (what === "closed") {
      document.body.append(banner);
      const asked = fetch(page, { cache: "no-store" });
      asked.then(({ status }) => (banner.textContent = status === 503 ? FULL : AWAY)).catch(() => {});
    }
    if (what === "connected") banner.remove();
  }

  const post = Worker.prototype.postMessage;
  Worker.prototype.postMessage = function (message, ...rest) {
    if (message?.type !== "set_server" && message?.type !== "retry") return post.call(this, message, ...rest);
    if (connection !== this) this.addEventListener("message", ({ data }) => tell(data.type));
    connection = this;
    show();
    return post.call(this, { type: "set_server", server: server() });
  };

  addEventListener("hashchange", () => {
    const wanted = location.hash.slice(1);
    if (wanted === fragment) return;
    clearTimeout(writing);
    fragment = wanted;
    connection?.postMessage({ type: "retry" });
  });

  new MutationObserver(() => {
    const element = document.querySelector("[data-fragment]");
    if (element === null || element === published) return;
    published = element;
    if (element.dataset.fragment !== fragment) {
      fragment = element.dataset.fragment;
      clearTimeout(writing);
      writing = setTimeout(show, CALM);
    }
    if (element.dataset.copy !== copied) {
      copied = element.dataset.copy;
      if (element.dataset.link) copy(element.dataset.link);
    }
  }).observe(document, { subtree: true, childList: true });

  async function copy(text) {
    try {
      await navigator.clipboard.writeText(text);
    } catch {
      // Without encryption, browsers have a clipboard on the machine itself alone; this older way is left to them.
      const field = document.body.appendChild(document.createElement("textarea"));
      field.value = text;
      field.select();
      document.execCommand("copy");
      field.remove();
    }
  }
})();
