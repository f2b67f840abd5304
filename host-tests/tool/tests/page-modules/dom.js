// A document without a browser, as far as the modules of the page use it. Layout, colours and the order of the focus belong to the tests
// in the browser.

const VOID = new Set(["meta", "link", "input", "img"]);

/** The attributes that are properties too. */
const REFLECTED = { id: "id", class: "className", type: "type", placeholder: "placeholder", title: "title" };
const FLAGS = ["hidden", "disabled", "required", "open", "checked"];

class Text {
  constructor(text) {
    this.textContent = text;
    this.parent = null;
  }
}

export class Element extends EventTarget {
  constructor(tag) {
    super();
    this.tag = tag;
    this.nodes = [];
    this.parent = null;
    this.attributes = new Map();
    this.dataset = {};
    this.style = {};
    this.clientWidth = 800;
    this.returnValue = "";
    this.files = [];
    this.own = "";
    for (const flag of FLAGS) this[flag] = false;
    for (const name of Object.values(REFLECTED)) this[name] = "";
    const classes = () => new Set(this.className.split(" ").filter(Boolean));
    this.classList = {
      contains: (name) => classes().has(name),
      toggle: (name, isOn) => {
        const all = classes();
        if (isOn) all.add(name); else all.delete(name);
        this.className = [...all].join(" ");
      },
    };
  }

  get children() { return this.nodes.filter((node) => node instanceof Element); }
  get options() { return this.children; }
  get firstChild() { return this.nodes[0] ?? null; }
  get isConnected() { return this === document.root || (this.parent?.isConnected ?? false); }

  get textContent() { return this.nodes.map((node) => node.textContent).join(""); }
  set textContent(text) { this.replaceChildren(...(text === "" ? [] : [String(text)])); }

  /** A select has the value of one of its options; the first one until another one is chosen. */
  get value() {
    if (this.tag !== "select") return this.own;
    const values = this.options.map((option) => option.own);
    return values.includes(this.own) ? this.own : this.chosen === "" ? "" : values[0] ?? "";
  }

  set value(value) {
    this.own = String(value);
    this.chosen = this.options.some((option) => option.own === this.own) ? this.own : "";
  }

  setAttribute(name, value) {
    this.attributes.set(name, String(value));
    if (FLAGS.includes(name)) this[name] = true;
    else if (name in REFLECTED) this[REFLECTED[name]] = String(value);
    else if (name === "value") this.own = String(value);
    else if (name.startsWith("data-")) this.dataset[name.slice(5).replace(/-(.)/g, (_, letter) => letter.toUpperCase())] = String(value);
  }

  getAttribute(name) { return this.attributes.get(name) ?? null; }
  hasAttribute(name) { return this.attributes.has(name); }
  removeAttribute(name) { this.attributes.delete(name); }

  insertBefore(node, next) {
    const own = typeof node === "string" ? new Text(node) : node;
    own.remove?.();
    own.parent = this;
    const place = next ? this.nodes.indexOf(next) : this.nodes.length;
    this.nodes.splice(place, 0, own);
  }

  append(...nodes) { for (const node of nodes) this.insertBefore(node, null); }

  replaceChildren(...nodes) {
    for (const node of [...this.nodes]) node.parent = null;
    this.nodes = [];
    this.append(...nodes);
  }

  remove() {
    if (!this.parent) return;
    if (document.activeElement !== document.body && this.contains(document.activeElement)) document.activeElement = document.body;
    this.parent.nodes = this.parent.nodes.filter((node) => node !== this);
    this.parent = null;
  }

  replaceWith(other) {
    const { parent } = this;
    const next = parent.nodes[parent.nodes.indexOf(this) + 1] ?? null;
    this.remove();
    parent.insertBefore(other, next);
  }

  contains(other) {
    for (let node = other; node; node = node.parent) if (node === this) return true;
    return false;
  }

  /** The first element inside of this one that a test takes. */
  find(test) {
    for (const node of this.nodes) {
      if (!(node instanceof Element)) continue;
      const found = test(node) ? node : node.find(test);
      if (found) return found;
    }
    return null;
  }

  all() {
    const found = [];
    this.find((element) => { found.push(element); return false; });
    return found;
  }

  /** A tag, `[attribute]` or `:disabled`. */
  matches(selector) {
    if (selector === ":disabled") return this.disabled;
    if (selector.startsWith("[")) return this.hasAttribute(selector.slice(1, -1));
    return this.tag === selector;
  }

  querySelectorAll(selector) { return this.all().filter((element) => element.matches(selector)); }
  querySelector(selector) { return this.querySelectorAll(selector)[0] ?? null; }

  focus() {
    document.activeElement = this;
    document.dispatch("focusin", this);
  }

  click() {
    if (this.tag === "a" && this.download) document.saved.push({ name: this.download, blob: document.blobs.get(this.href) });
    this.dispatchEvent(new Event("click"));
  }

  reportValidity() {
    const isValid = !this.required || this.value !== "";
    if (!isValid) this.focus();
    return isValid;
  }

  show() { this.open = true; }
  showModal() { this.open = true; }

  close(value) {
    this.open = false;
    this.returnValue = value;
    this.dispatchEvent(new Event("close"));
  }
}

/** Builds the elements of a text in HTML. */
function parse(html, root) {
  let place = root;
  for (const [, end, tag, rest, text] of html.matchAll(/<(\/?)([a-z][a-z0-9]*)([^>]*)>|([^<]+)|<![^>]*>/g)) {
    if (text?.trim()) place.append(text.trim());
    if (!tag) continue;
    if (end) {
      place = place.parent;
      continue;
    }
    const made = new Element(tag);
    const chosen = [];
    for (const [, name, value] of rest.matchAll(/([a-z-]+)(?:="([^"]*)")?/g)) {
      if (name === "selected") chosen.push(made);
      else made.setAttribute(name, value ?? "");
    }
    place.append(made);
    for (const option of chosen) place.value = option.own;
    if (!VOID.has(tag)) place = made;
  }
}

/** A new document of a page, as the global one. */
export function load(html) {
  const root = new Element("root");
  const events = new EventTarget();
  globalThis.document = {
    root,
    hidden: false,
    activeElement: null,
    /** The files that were handed to the user, and their bytes by address. */
    saved: [],
    blobs: new Map(),
    createElement: (tag) => new Element(tag),
    createElementNS: (_, tag) => new Element(tag),
    getElementById: (id) => root.find((element) => element.id === id),
    querySelectorAll: (selector) => root.querySelectorAll(selector),
    addEventListener: (kind, listener) => events.addEventListener(kind, listener),
    dispatch: (kind, target) => events.dispatchEvent(Object.defineProperty(new Event(kind), "target", { value: target })),
  };
  parse(html, root);
  document.documentElement = root.find(({ tag }) => tag === "html");
  document.body = root.find(({ tag }) => tag === "body");
  document.activeElement = document.body;
  Object.assign(globalThis, {
    HTMLElement: Element,
    HTMLSelectElement: { [Symbol.hasInstance]: ({ tag }) => tag === "select" },
    Option: function (text, value) {
      const option = new Element("option");
      option.textContent = text;
      option.own = String(value);
      return option;
    },
    getComputedStyle: () => ({ getPropertyValue: () => "black", color: "black" }),
    matchMedia: () => new EventTarget(),
    ResizeObserver: class { observe() {} },
  });
}
