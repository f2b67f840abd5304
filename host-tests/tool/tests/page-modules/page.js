// The page with a server and a clock that a test holds in its hands.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { runInNewContext } from "node:vm";
import { load } from "./dom.js";

const ASSETS = fileURLToPath(new URL("../../assets", import.meta.url));
const PATH = process.env.PLUMBLINE_ANSWERS;
if (!PATH) throw new Error("PLUMBLINE_ANSWERS is not set: `cargo test -p tool --test tool page_modules` starts these tests");

/** What the server has answered and told of its virtual sensors: products, ports, parameters, devices, values. */
export const answers = JSON.parse(readFileSync(PATH, "utf8"));

/** The real library, without a document. */
const UPLOT = runInNewContext(`${readFileSync(join(ASSETS, "uplot/uPlot.iife.min.js"), "utf8")}; uPlot`);

export const TOKEN = "0123456789abcdef".repeat(2);

/** The names that a module exports. */
const EXPORT = /^export (?:async )?(?:function|const|class) (\w+)/gm;
const IMPORT = /^import (.+) from "\.\/(.+)";$/gm;

/** The modules in the order of their imports, each as a function that returns what it exports. */
const MODULES = new Map();
function compile(name) {
  if (MODULES.has(name)) return;
  const source = readFileSync(join(ASSETS, name), "utf8");
  const exported = [...source.matchAll(EXPORT)].map(([, own]) => own);
  for (const [, , from] of source.matchAll(IMPORT)) compile(from);
  const body = source.replace(/^export /gm, "").replace(IMPORT, (_, names, from) => {
    if (names.startsWith("* as ")) return `const ${names.slice(5)} = modules[${JSON.stringify(from)}];`;
    const wanted = names.slice(1, -1).split(",").map((own) => own.trim().split(" ")[0]);
    for (const own of wanted) assert.ok(MODULES.get(from).exported.includes(own), `${name}: ${from} exports ${own}`);
    return `const ${names.replace(/ as /g, ": ")} = modules[${JSON.stringify(from)}];`;
  });
  const make = new Function("modules", `"use strict";\n${body}\nreturn { ${exported.join(", ")} };\n//# sourceURL=${name}`);
  MODULES.set(name, { make, exported });
}

/** Starts the modules anew: each page has modules of its own, with their own state. */
function started() {
  compile("app.js");
  const modules = {};
  for (const [name, { make }] of MODULES) modules[name] = make(modules);
  return modules;
}

const define = (name, value) => Object.defineProperty(globalThis, name, { value, configurable: true, writable: true });

/** Lets everything run that waits for no time. */
export const settle = () => new Promise((resolve) => setImmediate(resolve));

/** The status of a connection, as the server tells it. */
export const STATUS = {
  state: "active", port: "demo:is2", rate: 125, received: 0, sent: 0, perSecond: 100, errors: 0, samples: 50, lost: 0, silent: false, unsaved: [],
  busy: null, error: null, line: "plumbline --port demo:is2 --rate 125 --id 300",
};
export const CLOSED = { ...STATUS, state: "closed", port: null, rate: null, perSecond: 0, line: null };

class Page {
  constructor() {
    /** What the page has asked for, without the events: path, body, number of the sensor. */
    this.requests = [];
    this.replies = { "api/ports": answers.ports, "api/products": answers.products, "api/protocols": answers.protocols };
    this.now = 0;
    this.timers = [];
    this.events = [];
    this.refused = null;
    this.isGone = false;
  }

  element(id) {
    const element = document.getElementById(id);
    assert.ok(element, id);
    return element;
  }

  text(id) { return this.element(id).textContent; }

  /** The reply to a path: a value, a function of the body, or a failure. */
  reply(path, reply) { this.replies[path] = reply; }

  async fetch(path, { method = "GET", headers, body }) {
    assert.equal(headers["X-Plumbline-Token"], TOKEN);
    if (this.isGone) throw new TypeError("no connection");
    if (path === "api/events") return this.refused ?? this.stream();
    const sent = body === undefined ? null : JSON.parse(body);
    assert.equal(method, body === undefined ? "GET" : "POST");
    if (method === "POST") this.requests.push({ path, body: sent, sensor: headers["X-Plumbline-Sensor"] ?? null });
    const sheet = path.startsWith("api/parameters/") ? answers.parameters[decodeURIComponent(path.slice(15))] : undefined;
    const reply = path in this.replies ? this.replies[path] : sheet ?? {};
    const value = typeof reply === "function" ? await reply(sent) : reply;
    return value instanceof Refusal ? value.response() : { ok: true, status: 200, json: async () => value };
  }

  stream() {
    const waiting = this.events;
    const read = async () => {
      while (waiting.length === 0 && !this.isGone) await new Promise((resolve) => { this.wake = resolve; });
      return waiting.length > 0 ? { done: false, value: waiting.shift() } : { done: true };
    };
    return { ok: true, status: 200, body: { getReader: () => ({ read }) } };
  }

  /** These bytes come from the server. */
  async bytes(bytes) {
    this.events.push(bytes);
    this.wake?.();
    await settle();
  }

  /** An event of the server. */
  async event(kind, data) {
    await this.bytes(new TextEncoder().encode(`event: ${kind}\ndata: ${JSON.stringify(data)}\n\n`));
  }

  async status(change) { await this.event("status", { ...STATUS, ...change }); }

  /** The server ends. */
  async end() {
    this.isGone = true;
    this.wake?.();
    await settle();
  }

  /** Lets some milliseconds pass. */
  async pass(time) {
    const end = this.now + time;
    for (;;) {
      const [next] = this.timers.filter(({ at }) => at <= end).sort((one, other) => one.at - other.at);
      if (!next) break;
      this.now = next.at;
      if (next.every) next.at += next.every; else this.timers.splice(this.timers.indexOf(next), 1);
      next.run();
      await settle();
    }
    this.now = end;
    await settle();
  }

  /** A sensor as the server tells it. */
  async connected(name, change = {}) {
    const { device, values } = answers.devices[name];
    await this.event("device", { ...device, ...change });
    await this.event("values", values);
    await this.status({ port: `demo:${name}`, rate: device.rate });
  }

  /** Samples of this moment. */
  async samples(rows, first = 0) { await this.event("samples", { first, lost: 0, rows }); }

  async click(id) {
    const element = this.element(id);
    assert.equal(element.disabled, false, `${id} can be pressed`);
    element.click();
    await settle();
  }

  async dispatch(id, kind, value) {
    if (value !== undefined) this.element(id).value = value;
    this.element(id).dispatchEvent(new Event(kind, { cancelable: true }));
    await settle();
  }

  async change(id, value) { await this.dispatch(id, "change", value); }

  /** Presses a button that opens a question, and returns the texts of the question. */
  async question(id) {
    await this.click(id);
    return this.asked();
  }

  asked() {
    assert.ok(this.element("question").open, "a question is open");
    const text = this.element("question-text").children.map((line) => line.textContent).join("\n");
    return { title: this.text("question-title"), text, field: this.text("question-field"), yes: this.text("question-yes") };
  }

  get isAsking() { return this.element("question").open; }

  /** Answers the question: the value of its field, and its boxes. */
  async answer(word, { value, checks = {} } = {}) {
    if (value !== undefined) this.element("question-input").value = value;
    for (const [place, isChecked] of Object.entries(checks)) this.element(`question-check-${place}`).checked = isChecked;
    const submitted = Object.assign(new Event("submit", { cancelable: true }), { submitter: this.element(`question-${word}`) });
    this.element("question-form").dispatchEvent(submitted);
    if (!submitted.defaultPrevented) this.element("question").close(word);
    await settle();
  }

  async yes(answer) { await this.answer("yes", answer); }
  async no() { await this.answer("no"); }

  /** The button that sets a parameter. */
  setter(name) {
    const [button] = document.root.all().filter((element) => element.getAttribute("aria-label") === `Set ${name}`);
    assert.ok(button, name);
    return button;
  }

  /** The texts of the row of a parameter: name, sensor, action, file, factory value, range. */
  row(name) {
    const row = this.element("rows").children.find((line) => line.firstChild.title === name);
    assert.ok(row, name);
    return { line: row, cells: row.children.map((cell) => cell.textContent) };
  }

  saved() { return Promise.all(document.saved.map(async ({ name, blob }) => ({ name, text: await blob.text() }))); }

  /** What a module exports. */
  import(module) { return this.modules[module]; }
}

/** A text that the program sends. */
export const texts = (en, de = en) => ({ en, de });

/** A request that the server refuses. */
export class Refusal {
  constructor(code, message, status = 400, asks = undefined) {
    Object.assign(this, { code, message, status, asks });
  }

  /** The server asks the user first: questions with their texts. */
  static asks(...questions) {
    const asks = questions.map(([question, en, de]) => ({ question, texts: texts(en, de) }));
    return new Refusal("asks", "a text of the terminal", 400, asks);
  }

  response() {
    const error = { code: this.code, message: this.message };
    return { ok: false, status: this.status, json: async () => ({ error, texts: texts(this.message), asks: this.asks }) };
  }
}

const store = (values) => ({ getItem: (key) => values[key] ?? null, setItem: (key, value) => { values[key] = value; } });

/** Opens the page. */
export async function open({ language = "en-US", hash = `#${TOKEN}`, kept = {}, prepare = () => {} } = {}) {
  const page = new Page();
  load(readFileSync(join(ASSETS, "index.html"), "utf8"));
  const own = (run, time, every) => {
    const timer = { at: page.now + time, every, run };
    page.timers.push(timer);
    return timer;
  };
  page.window = new EventTarget();
  page.plots = [];
  page.reloads = 0;
  page.copied = [];
  define("window", globalThis);
  define("addEventListener", (kind, listener) => page.window.addEventListener(kind, listener));
  define("location", { hash, pathname: "/", reload: () => { page.reloads += 1; } });
  define("history", { replaceState: (_, __, path) => { location.hash = path.split("#")[1] ?? ""; } });
  define("sessionStorage", store({ ...kept }));
  define("localStorage", store({}));
  define("navigator", { language, clipboard: { writeText: async (text) => { page.copied.push(text); } } });
  define("performance", { now: () => page.now });
  define("setTimeout", (run, time) => own(run, time, 0));
  define("setInterval", (run, time) => own(run, time, time));
  define("fetch", (path, options) => page.fetch(path, options));
  define("devicePixelRatio", 1);
  URL.createObjectURL = (blob) => {
    const address = `blob:${document.blobs.size}`;
    document.blobs.set(address, blob);
    return address;
  };
  URL.revokeObjectURL = () => {};
  define("uPlot", class {
    static join = UPLOT.join;

    constructor(options, data, place) {
      Object.assign(this, { options, data, width: options.width, cursor: { left: -1, top: 0 }, bbox: { width: 600, height: 300 } });
      place.append(document.createElement("canvas"));
      page.plots.push(this);
    }

    destroy() {}
    setData(data) { this.data = data; }
    setCursor(cursor) { this.cursor = cursor; }
    /** The edges of the picture. */
    get edges() { return this.options.scales.x.range(); }
  });
  prepare(page);
  page.modules = started();
  await settle();
  return page;
}
