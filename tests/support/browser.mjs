// Debian's Chromium, driven as a person does: mouse, keys and fingers, through its own debugging pipe. Node has what it
// takes; nothing is installed for it.
import {spawn} from "node:child_process";
import {mkdtempSync, rmSync, writeFileSync} from "node:fs";
import {tmpdir} from "node:os";
import {join} from "node:path";
import {pathToFileURL} from "node:url";

const program = "/usr/bin/chromium";
const named = {Enter: [13, "\r"], Tab: [9, ""], Escape: [27, ""], Backspace: [8, ""], Delete: [46, ""], ArrowLeft: [37, ""], ArrowRight: [39, ""],
               ArrowUp: [38, ""], ArrowDown: [40, ""]};

export class Browser {
  static async open(file, {width = 1280, height = 900, touch = false, dark = false} = {}) {
    const browser = new Browser();
    browser.home = mkdtempSync(join(tmpdir(), "graintruth-browser-"));
    browser.process = spawn(program, ["--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking",
      "--disable-component-update", "--disable-sync", "--remote-debugging-pipe", `--user-data-dir=${browser.home}/profile`, "about:blank"],
      {stdio: ["ignore", "ignore", "ignore", "pipe", "pipe"], env: {...process.env, HOME: browser.home}});
    browser.#listen();
    const {targetInfos} = await browser.send("Target.getTargets");
    const {targetId} = targetInfos.find(one => one.type === "page") ?? await browser.send("Target.createTarget", {url: "about:blank"});
    browser.session = (await browser.send("Target.attachToTarget", {targetId, flatten: true})).sessionId;
    for (const domain of ["Page", "Runtime", "Log", "Network"]) await browser.send(`${domain}.enable`);
    await browser.send("Emulation.setDeviceMetricsOverride", {width, height, deviceScaleFactor: 1, mobile: touch});
    if (touch) await browser.send("Emulation.setTouchEmulationEnabled", {enabled: true});
    await browser.send("Emulation.setEmulatedMedia", {features: [{name: "prefers-color-scheme", value: dark ? "dark" : "light"}]});
    await browser.send("Page.setDownloadBehavior", {behavior: "allow", downloadPath: browser.home}).catch(() => {});
    browser.messages = [];
    browser.requests = [];
    browser.clicks = 0;
    const loaded = browser.once("Page.loadEventFired");
    await browser.send("Page.navigate", {url: pathToFileURL(file).href});
    await loaded;
    return browser;
  }

  #waiting = new Map();
  #events = [];
  #next = 1;
  #listen() {
    let rest = Buffer.alloc(0);
    this.process.stdio[4].on("data", data => {
      rest = Buffer.concat([rest, data]);
      for (let end = rest.indexOf(0); end >= 0; end = rest.indexOf(0)) {
        this.#take(JSON.parse(rest.subarray(0, end).toString()));
        rest = rest.subarray(end + 1);
      }
    });
  }
  #take(message) {
    if (message.id) {
      const {resolve, reject} = this.#waiting.get(message.id);
      this.#waiting.delete(message.id);
      if (message.error) reject(new Error(message.error.message)); else resolve(message.result);
      return;
    }
    const {method, params} = message;
    if (this.messages) {
      if (method === "Runtime.consoleAPICalled") this.messages.push(params.args.map(one => one.value ?? one.description).join(" "));
      if (method === "Runtime.exceptionThrown") this.messages.push(params.exceptionDetails.exception?.description ?? params.exceptionDetails.text);
      if (method === "Log.entryAdded") this.messages.push(params.entry.text);
      if (method === "Network.requestWillBeSent" && !/^(file|data|blob):/.test(params.request.url)) this.requests.push(params.request.url);
    }
    this.#events = this.#events.filter(one => one.method !== method || one.resolve(params));
  }
  send(method, params = {}) {
    const id = this.#next++;
    this.process.stdio[3].write(`${JSON.stringify({id, method, params, sessionId: this.session})}\0`);
    return new Promise((resolve, reject) => this.#waiting.set(id, {resolve, reject}));
  }
  once(method) {
    return new Promise(done => this.#events.push({method, resolve: params => { done(params); return false; }}));
  }

  // The value of an expression on the page.
  async tell(expression) {
    const {result, exceptionDetails} = await this.send("Runtime.evaluate", {expression, returnByValue: true, awaitPromise: true});
    if (exceptionDetails) throw new Error(exceptionDetails.exception?.description ?? exceptionDetails.text);
    return result.value;
  }
  async until(expression, seconds = 20) {
    for (const end = Date.now() + 1e3 * seconds; Date.now() < end; await new Promise(done => setTimeout(done, 30)))
      if (await this.tell(expression)) return;
    throw new Error(`never true: ${expression}`);
  }
  // Until the page has drawn what was changed
  settle() {
    return this.tell("new Promise(done => setTimeout(() => requestAnimationFrame(() => requestAnimationFrame(() => done(true))), 20))");
  }
  mouse(type, x, y, more = {}) {
    return this.send("Input.dispatchMouseEvent", {type, x, y, button: "left", buttons: type === "mouseReleased" ? 0 : 1, clickCount: 1, ...more});
  }
  async click(x, y, more = {}) {
    this.clicks++;
    await this.mouse("mouseMoved", x, y, {buttons: 0, ...more});
    await this.mouse("mousePressed", x, y, more);
    await this.mouse("mouseReleased", x, y, more);
    await this.settle();
  }
  async drag(from, to) {
    this.clicks++;
    await this.mouse("mouseMoved", ...from, {buttons: 0});
    await this.mouse("mousePressed", ...from);
    for (let k = 1; k <= 8; ++k) await this.mouse("mouseMoved", from[0] + (to[0] - from[0]) * k / 8, from[1] + (to[1] - from[1]) * k / 8);
    await this.mouse("mouseReleased", ...to);
    await this.settle();
  }
  wheel(x, y, deltaY) { return this.send("Input.dispatchMouseEvent", {type: "mouseWheel", x, y, deltaX: 0, deltaY}).then(() => this.settle()); }
  // The middle of the first element that fits, brought into view.
  place(selector) {
    return this.tell(`(() => { const found = document.querySelector(${JSON.stringify(selector)}); if (!found) return null;
      found.scrollIntoView({block: "nearest"}); const box = found.getBoundingClientRect(); return [box.left + box.width / 2, box.top + box.height / 2]; })()`);
  }
  async clickOn(selector) {
    const at = await this.place(selector);
    if (!at) throw new Error(`there is no ${selector}`);
    await this.click(...at);
  }
  async key(key, modifiers = 0) {
    const [code, text] = named[key] ?? [key.toUpperCase().charCodeAt(0), modifiers & 2 ? "" : key];
    const event = {key, code: named[key] ? key : `Key${key.toUpperCase()}`, windowsVirtualKeyCode: code, modifiers, ...(text ? {text} : {})};
    await this.send("Input.dispatchKeyEvent", {type: text ? "keyDown" : "rawKeyDown", ...event});
    await this.send("Input.dispatchKeyEvent", {type: "keyUp", ...event, text: undefined});
    if (named[key] || modifiers) await this.settle();
  }
  async type(text) {
    for (const letter of text) {
      await this.send("Input.dispatchKeyEvent", {type: "keyDown", key: letter, text: letter});
      await this.send("Input.dispatchKeyEvent", {type: "keyUp", key: letter});
    }
  }
  touch(type, points) {
    return this.send("Input.dispatchTouchEvent", {type, touchPoints: points.map(([x, y], id) => ({x, y, id}))});
  }
  async picture(file) {
    const {data} = await this.send("Page.captureScreenshot", {format: "png"});
    writeFileSync(file, Buffer.from(data, "base64"));
  }
  async close() {
    const ended = new Promise(done => this.process.once("exit", done));
    await Promise.race([this.send("Browser.close").catch(() => {}), new Promise(done => setTimeout(done, 3000))]);
    const timer = setTimeout(() => this.process.kill(), 5000);
    await ended;
    clearTimeout(timer);
    rmSync(this.home, {recursive: true, force: true, maxRetries: 5});
  }
}
