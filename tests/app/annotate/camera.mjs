// Reads lines of JSON from stdin, each {kind, ...}, and answers each by what the page's camera says of it.
import {readFileSync} from "node:fs";
import {dirname, join} from "node:path";
import {fileURLToPath} from "node:url";

const source = join(dirname(fileURLToPath(import.meta.url)), "../../../reports/templates/annotate/camera.js");
const CameraModel = new Function(`${readFileSync(source, "utf8")}; return CameraModel;`)();

for (const line of readFileSync(0, "utf8").split("\n").filter(Boolean)) {
  const {kind, ...given} = JSON.parse(line);
  let answer;
  if (kind === "project") {
    const camera = CameraModel.make(given.width, given.height, given.parameters);
    answer = {pixel: camera.project(given.x, given.z), back: camera.unproject(given.pixel), disc: CameraModel.discCentroid(camera, given.x, given.z, given.diameter)};
  } else if (kind === "points") {
    const {residuals, used, covariance, camera} = CameraModel.calibrate(given.references, given.options);
    answer = {residuals, used, sigmas: covariance.map((row, i) => Math.sqrt(row[i])), parameters: camera.parameters};
  } else {
    const calibration = CameraModel.levelCamera(given.stick, given.options);
    answer = {parameters: calibration.camera.parameters, length: CameraModel.measureLength(calibration, given.from, given.to, given.click)};
  }
  console.log(JSON.stringify(answer));
}
