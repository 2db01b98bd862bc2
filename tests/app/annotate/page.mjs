// What a person does on the page of annotate, with real mouse, keys and fingers. Arguments: the page, a JSON file that says
// what is where, a file for what the page downloads. Throws where the page does not answer as it should.
import assert from "node:assert/strict";
import {readFileSync, writeFileSync} from "node:fs";
import {Browser} from "../../support/browser.mjs";

const [page, knowledge, file] = process.argv.slice(2);
const known = JSON.parse(readFileSync(knowledge, "utf8"));

// Screen places of pixels, as the page shows the whole picture at first
async function mapping(browser) {
  const [left, top, width, height] = await browser.tell("(() => { const b = document.getElementById('view').getBoundingClientRect(); return [b.left, b.top, b.width, b.height]; })()");
  const [columns, rows] = known.size, zoom = Math.min(width / columns, height / rows);
  return ([column, row]) => [left + (width - columns * zoom) / 2 + (column + 0.5) * zoom, top + (height - rows * zoom) / 2 + (row + 0.5) * zoom];
}
const text = browser => browser.tell("document.getElementById('file').value");
const red = browser => browser.tell("[...document.querySelectorAll('#panel .red')].map(one => one.textContent).filter(Boolean).join(' | ')");
const near = (found, wanted, tolerance, what) => assert.ok(Math.abs(found - wanted) <= tolerance, `${what}: ${found}, not ${wanted} +- ${tolerance}`);
const value = async (browser, key) => Number((await text(browser)).match(new RegExp(`^${key} = (\\S+)$`, "m"))?.[1]);
const typeInto = async (browser, selector, letters) => {
  await browser.clickOn(selector);
  await browser.key("a", 2);
  if (letters) await browser.type(letters); else await browser.key("Delete");
  await browser.key("Enter");
  await browser.settle();
};

const browser = await Browser.open(page, {width: 1280, height: 900});
try {
  await browser.until("document.body.dataset.shown");
  await browser.settle();
  const at = await mapping(browser);

  // Names are text
  assert.equal(await browser.tell("document.querySelector('h1').textContent"), known.title);
  assert.equal(await browser.tell("document.getElementById('film').options[0].textContent"), known.name);
  assert.equal(await browser.tell("document.querySelectorAll('#panel b, #panel img, h1 *').length"), 0);

  // Points: near a disc its middle is taken; places are typed
  for (const [i, {pixel, place}] of known.discs.entries()) {
    await browser.click(...at([pixel[0] + 1.5, pixel[1] - 1]));
    await browser.type(`${place[0]} ${place[1]}`);
    await browser.key("Enter");
    assert.match(await browser.tell("document.getElementById('panel').textContent"), i < 3 ? /needed/ : /Scale [\d.]+ ± [\d.]+ px\/mm/);
  }
  const residuals = await browser.tell("[...document.querySelectorAll('[data-residual]')].map(one => JSON.parse(one.dataset.residual))");
  assert.equal(residuals.length, known.discs.length);
  assert.ok(!(await red(browser)).includes("Contradiction"), await red(browser));

  // Undo and redo
  const before = await text(browser);
  await browser.key("z", 2);
  assert.notEqual(await text(browser), before);
  await browser.key("z", 2 | 8);
  assert.equal(await text(browser), before);

  // A corner of the rig is dragged onto its edge
  await browser.key("r");
  await browser.drag(at(known.rig.from), at(known.rig.to));
  near(await value(browser, known.rig.key), known.rig.value, known.rig.tolerance, known.rig.key);

  // A length that is known as well: red where it contradicts
  await browser.key("c");
  await browser.click(...at(known.check.from));
  await browser.click(...at(known.check.to));
  await browser.type(String(known.check.wrong));
  await browser.key("Enter");
  assert.match(await red(browser), /Contradiction: by the scale it is/);
  await typeInto(browser, "[data-id='check 0']", String(known.check.right));
  assert.doesNotMatch(await red(browser), /Contradiction/);

  // A mask; a grain with its angle
  await browser.key("m");
  for (const corner of known.mask) await browser.click(...at(corner));
  await browser.key("Enter");
  assert.match(await text(browser), /\[\[camera\.mask\]\]/);
  await browser.key("g");
  await browser.click(...at(known.grain.at));
  await browser.drag(at(known.grain.handle), at(known.grain.to));
  near(await value(browser, "angle_deg"), known.grain.angle, 1.5, "angle");

  // The start, by the picture that is shown; a film that is held out is grey
  await browser.key("]");
  await browser.key("]");
  await browser.clickOn("#start-here");
  near(await value(browser, "noted_event_s"), await browser.tell("Number(document.getElementById('moment').textContent.match(/([\\d.]+) s/)[1])"), 5e-4, "start");
  await browser.clickOn("input[type=checkbox][aria-label$='is held out']");
  assert.match(await text(browser), /held_out = true/);
  assert.equal(await browser.tell("document.querySelectorAll('tr.out').length"), 2);  // both films are one condition
  assert.match(await browser.tell("document.getElementById('film').options[0].textContent"), /held out/);
  await browser.key("[");
  await browser.key("[");

  // Zoomed in, a click tells a tenth of a pixel; arrows move by as much
  await browser.key("p");
  const [x, y] = at(known.fine);
  for (let k = 0; k < 6; ++k) await browser.wheel(x, y, -300);
  // What lies under the pointer stands below the picture; the rest of the way, at 60 screen pixels a pixel
  await browser.mouse("mouseMoved", x, y, {buttons: 0});
  await browser.settle();
  const under = (await browser.tell("document.getElementById('place').textContent")).match(/-?[\d.]+/g).slice(0, 2).map(Number);
  await browser.click(x + 60 * (known.fine[0] - under[0]), y + 60 * (known.fine[1] - under[1]), {modifiers: 1});
  await browser.type(known.fine_place.join(" "));
  await browser.key("Enter");
  const last = async () => (await text(browser)).match(/px = \[ ([\d.]+), ([\d.]+) \]\nmm = \[[^\]]*\]\n(?!\n*\[\[camera\.point)/).slice(1).map(Number);
  const clicked = await last();
  near(clicked[0], known.fine[0], 0.1, "column");
  near(clicked[1], known.fine[1], 0.1, "row");
  await browser.key("ArrowRight");
  near((await last())[0], clicked[0] + 0.1, 0.011, "column moved");
  await browser.key("ArrowLeft");
  await browser.key("0");

  // The text is read back; what is no TOML is said
  const whole = await text(browser);
  const write = async content => {
    await browser.tell(`(() => { const area = document.getElementById('file'); area.focus(); area.select(); })()`);
    await browser.send("Input.insertText", {text: content});
    await browser.tell("document.getElementById('file').blur()");
    await browser.settle();
  };
  await write("[camera\n");
  assert.match(await browser.tell("document.getElementById('text-error').textContent"), /not valid TOML, line 1/);
  await write(whole.replace("held_out = true\n", ""));
  assert.equal(await browser.tell("document.getElementById('text-error')"), null);
  assert.equal(await browser.tell("document.querySelectorAll('tr.out').length"), 0);

  await browser.tell("window.saved = null; const make = URL.createObjectURL; URL.createObjectURL = blob => { blob.text().then(text => { window.saved = text; }); return make(blob); };");
  await browser.clickOn("#download");
  await browser.until("window.saved !== null");
  writeFileSync(file, await browser.tell("window.saved"));
  writeFileSync(`${file}.residuals`, JSON.stringify(residuals));
  assert.deepEqual(browser.messages, []);
  assert.deepEqual(browser.requests, []);
} finally {
  await browser.close();
}

// By fingers, on a telephone, in the dark
const narrow = await Browser.open(page, {width: 400, height: 800, touch: true, dark: true});
try {
  await narrow.until("document.body.dataset.shown");
  await narrow.settle();
  assert.ok(await narrow.tell("document.documentElement.scrollWidth <= window.innerWidth"), "wider than the screen");
  const at = await mapping(narrow), tap = at(known.discs[0].pixel);
  await narrow.touch("touchStart", [tap]);
  await narrow.touch("touchEnd", []);
  await narrow.settle();
  const taken = (await text(narrow)).match(/px = \[ ([\d.]+), ([\d.]+) \]/).slice(1).map(Number);
  near(taken[0], known.discs[0].pixel[0], 0.2, "tapped column");
  // Two fingers zoom and make no point
  const middle = at(known.size.map(length => length / 2));
  await narrow.touch("touchStart", [[middle[0] - 20, middle[1]], [middle[0] + 20, middle[1]]]);
  for (let k = 1; k <= 5; ++k) await narrow.touch("touchMove", [[middle[0] - 20 - 12 * k, middle[1]], [middle[0] + 20 + 12 * k, middle[1]]]);
  await narrow.touch("touchEnd", []);
  await narrow.settle();
  assert.equal((await text(narrow)).match(/\[\[camera\.point\]\]/g).length, 1);
  const tapped = at(known.discs[1].pixel);
  await narrow.touch("touchStart", [tapped]);
  await narrow.touch("touchEnd", []);
  await narrow.settle();
  const second = [...(await text(narrow)).matchAll(/px = \[ (-?[\d.]+), (-?[\d.]+) \]/g)][1].slice(1).map(Number);
  assert.ok(Math.hypot(second[0] - known.discs[1].pixel[0], second[1] - known.discs[1].pixel[1]) > 10, "two fingers did not zoom");
  assert.deepEqual(narrow.messages, []);
} finally {
  await narrow.close();
}
