// How long pages of annotate take to open: from the navigation until the first picture is drawn, five times each, in
// seconds. Arguments: pages.
//   node bench/annotate/time_to_open.mjs out/micro/annotate.html
import {statSync} from "node:fs";
import {Browser} from "../../tests/support/browser.mjs";

for (const page of process.argv.slice(2)) {
  const seconds = [];
  for (let k = 0; k < 5; ++k) {
    const browser = await Browser.open(page);
    await browser.until("document.body.dataset.shown");
    seconds.push(await browser.tell("Number(document.body.dataset.shown) / 1e3"));
    await browser.close();
  }
  seconds.sort((a, b) => a - b);
  console.log(`${page}: ${(statSync(page).size / 1e6).toFixed(2)} MB, median ${seconds[2].toFixed(2)} s, ${seconds.map(one => one.toFixed(2)).join(" ")}`);
}
