// Sets up the micro films on the page of annotate as a person does, with real mouse and key events, from nothing but what
// the laboratory knows. Arguments: the page, how the scale is told (discs, points or stick), the file to write, and optionally
// a folder for screenshots. Prints as JSON what it saw on the way.
import {readFileSync, writeFileSync} from "node:fs";
import {join} from "node:path";
import {Browser} from "../../support/browser.mjs";

const [page, scale, file, pictures] = process.argv.slice(2);
// Where a person sees the discs of the first film, px, and the laboratory's list of their places, mm
const discs = [[46, 42, -290, 220], [667, 47, 290, 220], [45, 159, -290, 110], [667, 164, 290, 110], [44, 277, -290, 0], [666, 281, 290, 0],
               [44, 395, -290, -110], [665, 399, 290, -110], [44, 512, -290, -220], [663, 516, 290, -220],
               [183, 397, -160, -110], [527, 399, 160, -110], [183, 514, -160, -220], [526, 516, 160, -220]];
const browser = await Browser.open(page, {width: 1280, height: 900});
const seen = {};
try {
  await browser.until("document.body.dataset.shown");
  await browser.settle();
  const box = await browser.tell("(() => { const b = document.getElementById('view').getBoundingClientRect(); return [b.left, b.top, b.width, b.height]; })()");
  const size = await browser.tell("(() => { const f = JSON.parse(document.getElementById('data').textContent).films[0]; return [f.width, f.height]; })()");
  const zoom = Math.min(box[2] / size[0], box[3] / size[1]);
  const at = ([column, row]) => [box[0] + (box[2] - size[0] * zoom) / 2 + (column + 0.5) * zoom, box[1] + (box[3] - size[1] * zoom) / 2 + (row + 0.5) * zoom];
  const text = () => browser.tell("document.getElementById('file').value");
  let spent = 0;  // clicks on points and ends

  // 1. The scale
  if (scale === "discs" || scale === "points") {
    const clicked = scale === "discs" ? discs : [0, 1, 8, 9].map(i => discs[i]);
    const noise = [[0.5, -0.6], [-0.8, 0.3], [0.4, 0.9], [-0.2, -0.7]];  // of clicks, px
    for (const [i, [column, row, x, z]] of clicked.entries()) {
      if (scale === "discs") {
        await browser.click(...at([column + 1.5, row - 1]));
      } else {
        const exact = JSON.parse(readFileSync(`${file}.clicks`, "utf8"))[i];
        await browser.click(...at([exact[0] + noise[i][0], exact[1] + noise[i][1]]), {modifiers: 1});  // Alt: not the disc's middle
      }
      await browser.type(`${x}, ${z}`);
      await browser.key("Enter");
      spent++;
    }
    seen.residuals = await browser.tell("[...document.querySelectorAll('[data-residual]')].map(one => JSON.parse(one.dataset.residual))");
    if (scale === "discs") {
      await browser.clickOn("[data-id='disc diameter']");
      await browser.type("14");
      await browser.key("Enter");
    }
  } else {
    const [from, to, origin] = JSON.parse(readFileSync(`${file}.clicks`, "utf8"));
    await browser.key("s");
    await browser.click(...at(from));
    await browser.click(...at(to));
    await browser.type("135");
    await browser.key("Enter");
    await browser.tell("[...document.querySelectorAll('#panel button')].find(one => one.textContent === 'Click the origin').id = 'click-origin'");
    await browser.clickOn("#click-origin");
    await browser.click(...at(origin));
    spent += 3;
  }
  if (scale !== "discs") {
    await browser.clickOn("#click-error");
    await browser.type("0.7");
    await browser.key("Enter");
  }
  if (pictures) await browser.picture(join(pictures, "scale.png"));
  seen.scale = await browser.tell("document.getElementById('scale-words')?.textContent");

  // 2. The rig, by the laboratory's numbers; the last two of its fields are dragged in another test
  const fill = async entries => {
    for (const [id, value] of entries) {
      const isThere = await browser.tell(`document.activeElement.id === ${JSON.stringify(id)}`);
      if (!isThere) await browser.clickOn(`[id=${JSON.stringify(id)}]`);
      await browser.key("a", 2);
      await browser.type(value);
      await browser.key("Tab");
    }
  };
  const rig = await browser.tell("JSON.parse(document.getElementById('data').textContent).rig.keys.map(key => key.path.join('.'))");
  const numbers = {column_width_mm: "135", column_depth_mm: "280", slope_angle_deg: "60", slope_height_mm: "300", piston_start_z_mm: "0"};
  await fill([...rig.map((key, i) => [`rig ${i}`, numbers[key]]), ["field rig.piston_speed_mm_per_s", "46"], ["field rig.front_back_gap_mm", "46"]]);

  // 3. Grains and bench values
  await fill([["field camera.frame_rate_hz", "50"], ["field particle.count", "10"], ["field particle.mass_g", "142"],
              ["field particle.spheres", "[{offset_mm = -13.915, radius_mm = 22.225}, {offset_mm = 13.915, radius_mm = 22.225}]"],
              ["field material.elastic_modulus_gpa", "6.89"], ["field material.poisson_ratio", "0.35"], ["field material.friction_particle_particle", "0.36"],
              ["field material.friction_particle_particle_uncertainty", ""],
              ["field material.friction_particle_wall", "0.35"], ["field material.friction_particle_wall_uncertainty", ""], ["field material.restitution", "0.83"]]);

  // 4. Starts
  await browser.clickOn("#take-starts");
  if (pictures) await browser.picture(join(pictures, "whole.png"));

  // 5. The file, as it is downloaded
  await browser.tell("window.saved = null; const make = URL.createObjectURL; URL.createObjectURL = blob => { blob.text().then(text => { window.saved = text; }); return make(blob); };");
  await browser.clickOn("#download");
  await browser.until("window.saved !== null");
  writeFileSync(file, await browser.tell("window.saved"));
  seen.isText = (await text()) === (await browser.tell("window.saved"));
  seen.red = await browser.tell("[...document.querySelectorAll('#panel .red')].map(one => one.textContent).filter(Boolean)");
  seen.clicks = browser.clicks - spent;
  seen.messages = browser.messages;
  seen.requests = browser.requests;
  console.log(JSON.stringify(seen));
} finally {
  await browser.close();
}
