// The camera of the films: the same model and the same fit as tracking/view/camera.cpp, which a test compares with this
// file. Lab points are (x, z) in metres in the plane of the particles' centres, pixels (column, row) with integers at
// pixel centres. Angles in rad.
const CameraModel = (() => {
  const count = 10;  // log f, log a, rotation vector (3), foot of the optical axis (2, m), log distance, k1, k2
  const fewest = 4;  // points that fix a camera

  // Rodrigues' rotation about a vector by its length; rows.
  function rotationMatrix([x, y, z]) {
    const angle = Math.hypot(x, y, z);
    if (angle < 1e-14) return [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
    const [a, b, c] = [x / angle, y / angle, z / angle], s = Math.sin(angle), k = Math.cos(angle), v = 1 - k;
    return [[a * a * v + k, a * b * v - c * s, a * c * v + b * s],
            [a * b * v + c * s, b * b * v + k, b * c * v - a * s],
            [a * c * v - b * s, b * c * v + a * s, c * c * v + k]];
  }

  function make(width, height, parameters, principalPoint = [(width - 1) / 2, (height - 1) / 2]) {
    const p = parameters, focal = Math.exp(p[0]), aspect = Math.exp(p[1]);
    // Right, down, forward from right, up, towards the camera
    const R = rotationMatrix(p.slice(2, 5)).map(row => [row[0], -row[1], -row[2]]);
    const T = R.map((row, i) => (i === 2 ? Math.exp(p[7]) : 0) - row[0] * p[5] - row[1] * p[6]);
    const position = [0, 1, 2].map(j => -(R[0][j] * T[0] + R[1][j] * T[1] + R[2][j] * T[2]));
    const [cx, cy] = principalPoint, k1 = p[8], k2 = p[9];

    function project(x, z) {
      const s = R.map((row, i) => row[0] * x + row[1] * z + T[i]);
      const u = s[0] / s[2], v = s[1] / s[2], square = u * u + v * v;
      const stretch = 1 + square * (k1 + k2 * square);
      return [cx + focal / aspect * u * stretch, cy + focal * v * stretch];
    }
    // The point of the plane that is seen at a pixel
    function unproject([column, row]) {
      const du = (column - cx) * aspect / focal, dv = (row - cy) / focal;
      let u = du, v = dv;
      for (let i = 0; i < 12; ++i) {
        const square = u * u + v * v, stretch = 1 + square * (k1 + k2 * square);
        u = du / stretch;
        v = dv / stretch;
      }
      const d = [0, 1, 2].map(j => R[0][j] * u + R[1][j] * v + R[2][j]);
      const reach = -position[2] / d[2];
      return [position[0] + reach * d[0], position[1] + reach * d[1]];
    }
    // d(column, row) / d(x, z), px/m; rows
    function jacobian(x, z) {
      const delta = 1e-5;
      const a = project(x + delta, z), b = project(x - delta, z), c = project(x, z + delta), d = project(x, z - delta);
      return [[(a[0] - b[0]) / (2 * delta), (c[0] - d[0]) / (2 * delta)],
              [(a[1] - b[1]) / (2 * delta), (c[1] - d[1]) / (2 * delta)]];
    }
    // px/m
    function scale(x, z) {
      const J = jacobian(x, z);
      return Math.sqrt(Math.abs(J[0][0] * J[1][1] - J[0][1] * J[1][0]));
    }
    // Between the optical axis and the normal of the plane
    const tilt = Math.acos(Math.min(1, Math.abs(R[2][2])));
    return {width, height, parameters: p, principalPoint, project, unproject, jacobian, scale, tilt};
  }

  // Where a disc in the plane has its centre of area in the picture.
  function discCentroid(camera, x, z, diameter) {
    const origin = camera.project(x, z);
    if (!diameter) return origin;
    const corners = 24;
    const corner = k => {
      const angle = 2 * Math.PI * k / corners;
      const at = camera.project(x + 0.5 * diameter * Math.cos(angle), z + 0.5 * diameter * Math.sin(angle));
      return [at[0] - origin[0], at[1] - origin[1]];
    };
    let area = 0, moment = [0, 0], previous = corner(0);
    for (let k = 1; k <= corners; ++k) {
      const next = corner(k % corners), cross = previous[0] * next[1] - previous[1] * next[0];
      area += cross / 2;
      moment = [0, 1].map(i => moment[i] + cross * (previous[i] + next[i]) / 6);
      previous = next;
    }
    return [origin[0] + moment[0] / area, origin[1] + moment[1] / area];
  }

  // What is known of any laboratory camera before a point is seen
  function prior(options) {
    const size = Math.max(options.width, options.height), focal = 3 * size;
    const corner = 0.5 * Math.hypot(options.width, options.height) / focal, unknown = 1e3;
    return {mean: [Math.log(focal), Math.log(options.pixelAspect), 0, 0, 0, 0, 0, 0, 0, 0],
            sigma: [0.5, 0.1, 0.15, 0.15, unknown, unknown, unknown, unknown, 0.1 / corner ** 2, 0.01 / corner ** 4]};
  }

  // A x = b with a symmetric positive A: L D L^T
  function factorise(A) {
    const n = A.length, L = A.map(row => row.map(() => 0)), D = [];
    for (let j = 0; j < n; ++j) {
      let d = A[j][j];
      for (let k = 0; k < j; ++k) d -= L[j][k] * L[j][k] * D[k];
      D.push(d);
      L[j][j] = 1;
      for (let i = j + 1; i < n; ++i) {
        let sum = A[i][j];
        for (let k = 0; k < j; ++k) sum -= L[i][k] * L[j][k] * D[k];
        L[i][j] = sum / d;
      }
    }
    return b => {
      const y = b.slice();
      for (let i = 0; i < n; ++i) for (let k = 0; k < i; ++k) y[i] -= L[i][k] * y[k];
      for (let i = 0; i < n; ++i) y[i] /= D[i];
      for (let i = n - 1; i >= 0; --i) for (let k = i + 1; k < n; ++k) y[i] -= L[k][i] * y[k];
      return y;
    };
  }

  function inverse(A) {
    const solve = factorise(A), n = A.length;
    const columns = A.map((_, j) => solve(A.map((__, i) => (i === j ? 1 : 0))));
    return A.map((_, i) => A.map((__, j) => 0.5 * (columns[j][i] + columns[i][j])));
  }

  function miss(camera, r) {
    const at = discCentroid(camera, r.x, r.z, r.diameter);
    return [at[0] - r.pixel[0], at[1] - r.pixel[1]];
  }

  const sumOfSquares = values => values.reduce((sum, value) => sum + value * value, 0);

  // Levenberg-Marquardt
  function fit(references, options, before, start) {
    const residualsOf = p => {
      const camera = make(options.width, options.height, p);
      return references.flatMap(r => miss(camera, r));
    };
    const weight = before.sigma.map(sigma => options.expectedSigma / sigma);
    const costOf = (p, residuals) =>
      sumOfSquares(residuals) + sumOfSquares(p.map((value, k) => weight[k] * (value - before.mean[k])));
    let parameters = start, residuals = residualsOf(parameters), cost = costOf(parameters, residuals), damping = 1e-3;
    let information;
    for (let step = 0; step < 60; ++step) {
      const columns = [], delta = 1e-3;
      for (let k = 0; k < count; ++k) {
        const moved = change => residualsOf(parameters.map((value, i) => (i === k ? value + change : value)));
        const [a, b, c, d] = [delta, -delta, 2 * delta, -2 * delta].map(moved);
        columns.push(a.map((_, i) => (8 * (a[i] - b[i]) - (c[i] - d[i])) / (12 * delta)));
      }
      const dot = (a, b) => a.reduce((sum, value, i) => sum + value * b[i], 0);
      information = columns.map((a, i) => columns.map((b, j) => dot(a, b) + (i === j ? weight[i] ** 2 : 0)));
      const gradient = columns.map((a, k) => dot(a, residuals) + weight[k] ** 2 * (parameters[k] - before.mean[k]));
      let improved = false;
      for (let attempt = 0; attempt < 12 && !improved; ++attempt) {
        const damped = information.map((row, i) => row.map((value, j) => (i === j ? value * (1 + damping) : value)));
        const change = factorise(damped)(gradient.map(value => -value));
        const tried = parameters.map((value, k) => value + change[k]);
        const triedResiduals = residualsOf(tried), triedCost = costOf(tried, triedResiduals);
        if (Number.isFinite(triedCost) && triedCost < cost) {
          improved = cost - triedCost > 1e-16 * cost;
          parameters = tried;
          residuals = triedResiduals;
          cost = triedCost;
          damping = Math.max(1e-9, damping * 0.2);
          if (!improved) break;
        } else {
          damping *= 8;
        }
      }
      if (!improved) break;
    }
    return {parameters, information, dataSquare: sumOfSquares(residuals)};
  }

  // A similarity, to start the fit from
  function startingParameters(references, options, before) {
    const aspect = Math.exp(before.mean[1]), centre = [(options.width - 1) / 2, (options.height - 1) / 2];
    const n = references.length;
    const lab = references.map(r => [r.x, r.z]);
    const seen = references.map(r => [aspect * (r.pixel[0] - centre[0]), -(r.pixel[1] - centre[1])]);
    const mean = points => [0, 1].map(i => points.reduce((sum, point) => sum + point[i] / n, 0));
    const meanLab = mean(lab), meanSeen = mean(seen);
    let real = 0, imaginary = 0, square = 0;
    for (let i = 0; i < n; ++i) {
      const p = [lab[i][0] - meanLab[0], lab[i][1] - meanLab[1]], q = [seen[i][0] - meanSeen[0], seen[i][1] - meanSeen[1]];
      real += p[0] * q[0] + p[1] * q[1];
      imaginary += p[0] * q[1] - p[1] * q[0];
      square += p[0] * p[0] + p[1] * p[1];
    }
    const scale = Math.hypot(real, imaginary) / square, turn = Math.atan2(imaginary, real);
    const c = Math.cos(turn), s = Math.sin(turn), start = before.mean.slice();
    start[4] = -turn;
    start[5] = meanLab[0] - (c * meanSeen[0] + s * meanSeen[1]) / scale;
    start[6] = meanLab[1] - (-s * meanSeen[0] + c * meanSeen[1]) / scale;
    start[7] = Math.log(Math.exp(start[0]) / scale);
    return start;
  }

  // Of a miss in px what it is in the plane, m
  function inPlane(camera, x, z, [column, row]) {
    const [[a, b], [c, d]] = camera.jacobian(x, z), determinant = a * d - b * c;
    return [(d * column - b * row) / determinant, (a * row - c * column) / determinant];
  }

  // `references`: {x, z, diameter (0: a point), pixel}. `options`: width, height, pixelAspect, expectedSigma and leastSigma
  // (px). Null where fewer than four are given. Those far off the rest are left out: `used` has the places of the others.
  // `residuals`, one a reference: {px: [column, row], mm, used}.
  function calibrate(references, options) {
    if (references.length < fewest) return null;
    const before = prior(options);
    let kept = references.map((_, i) => i), found;
    const of = places => places.map(i => references[i]);
    while (true) {
      found = fit(of(kept), options, before, startingParameters(of(kept), options, before));
      const rms = Math.sqrt(found.dataSquare / (2 * kept.length));
      if (!(kept.length > fewest) || rms < 2 * options.expectedSigma) break;
      let least = found.dataSquare, culprit = -1;
      kept.forEach((_, i) => {
        const square = fit(of(kept.filter((__, j) => j !== i)), options, before, found.parameters).dataSquare;
        if (square < least) {
          least = square;
          culprit = i;
        }
      });
      if (culprit < 0 || 4 * least > found.dataSquare) break;
      kept = kept.filter((_, i) => i !== culprit);
    }
    const camera = make(options.width, options.height, found.parameters);
    const freedom = Math.max(2, 2 * kept.length - 8);
    const pixelSigma = Math.max(Math.sqrt(found.dataSquare / freedom), options.leastSigma);
    const covariance = inverse(found.information).map(row => row.map(value => value * pixelSigma ** 2));
    const residuals = references.map((r, i) => {
      const px = miss(camera, r);
      return {px, mm: 1e3 * Math.hypot(...inPlane(camera, r.x, r.z, px)), used: kept.includes(i)};
    });
    return {camera, covariance, used: kept, residuals, pixelSigma};
  }

  // A stick of known length (m), seen from `from` to `to`, and the pixel that shows (0, 0): the camera is taken as level
  // and square to the plane. `relativeSigma` of the length that is seen.
  function levelCamera(stick, options) {
    const parameters = prior(options).mean;
    const near = make(options.width, options.height, parameters);
    const a = near.unproject(stick.from), b = near.unproject(stick.to), o = near.unproject(stick.origin);
    const distance = stick.length / Math.hypot(a[0] - b[0], a[1] - b[1]);
    parameters[7] = Math.log(distance);
    parameters[5] = -distance * o[0];
    parameters[6] = -distance * o[1];
    const slope = parameters.map((_, k) => (k === 5 || k === 6 ? parameters[k] : k === 7 ? 1 : 0));
    const covariance = slope.map(one => slope.map(other => one * other * stick.relativeSigma ** 2));
    return {camera: make(options.width, options.height, parameters), covariance, used: [], residuals: [], pixelSigma: NaN};
  }

  // Value and standard deviation of anything that a camera tells, by the covariance of its parameters
  function withError(calibration, tell) {
    const {camera, covariance} = calibration, delta = 1e-6;
    const of = parameters => tell(make(camera.width, camera.height, parameters, camera.principalPoint));
    const slope = camera.parameters.map((_, k) => {
      const moved = change => of(camera.parameters.map((value, i) => (i === k ? value + change : value)));
      return (moved(delta) - moved(-delta)) / (2 * delta);
    });
    let variance = 0;
    slope.forEach((a, i) => slope.forEach((b, j) => { variance += a * covariance[i][j] * b; }));
    return {value: tell(camera), sigma: Math.sqrt(Math.max(0, variance))};
  }

  // The distance in the plane of two clicked points, m; `clickError` in px per axis.
  function measureLength(calibration, from, to, clickError) {
    const length = (camera, a, b) => {
      const p = camera.unproject(a), q = camera.unproject(b);
      return Math.hypot(p[0] - q[0], p[1] - q[1]);
    };
    const byCamera = withError(calibration, camera => length(camera, from, to));
    let variance = byCamera.sigma ** 2;
    const at = ([column, row], axis, step) => (axis === 0 ? [column + step, row] : [column, row + step]);
    for (const axis of [0, 1]) {
      const {camera} = calibration;
      const byFrom = length(camera, at(from, axis, 0.5), to) - length(camera, at(from, axis, -0.5), to);
      const byTo = length(camera, from, at(to, axis, 0.5)) - length(camera, from, at(to, axis, -0.5));
      variance += (byFrom * byFrom + byTo * byTo) * clickError * clickError;
    }
    return {value: byCamera.value, sigma: Math.sqrt(variance)};
  }

  return {make, discCentroid, calibrate, levelCamera, withError, measureLength, factorise, fewest};
})();
