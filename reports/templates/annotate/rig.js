// The rig's drawing, as data that the program made of the rig: every coordinate of every corner is a sum of products of
// at most two dimensions, exact within a nanometre. So a corner that is dragged tells dimensions, whatever the kind of rig.
// `model`: keys [{path, unit, as}], values (those of the template), corners [{terms: {x: [...], z: [...]}}], lines [{name,
// corners: [from, to]}], circles [{name, centre, rim}]. A term is [factor, key, key], -1 where there is none.
const RigDrawing = (() => {
  const forms = {
    plain: [value => value, value => value], tan: [Math.tan, Math.atan], cot: [value => 1 / Math.tan(value), value => Math.atan2(1, value)],
    sin: [Math.sin, Math.asin], cos: [Math.cos, Math.acos],
  };
  const coordinateOf = (key, value) => forms[key.as][0](value);
  const valueOf = (key, coordinate) => forms[key.as][1](coordinate);

  const sum = (terms, c) =>
    terms.reduce((total, [factor, i, j]) => total + factor * (i < 0 ? 1 : c[i]) * (j < 0 ? 1 : c[j]), 0);

  // Places of all corners, m, of dimensions in SI
  function corners(model, values) {
    const c = model.keys.map((key, i) => coordinateOf(key, values[i]));
    return model.corners.map(corner => [sum(corner.x, c), sum(corner.z, c)]);
  }

  // The dimensions that bring a weighted mean of corners ({corner, weight}) to a place; `along`, where it is given, is the
  // only direction that counts (a line is dragged across itself). They change as little as they can, and only those that are
  // free.
  function drag(model, values, free, grip, place, along = null) {
    const c = model.keys.map((key, i) => coordinateOf(key, values[i]));
    const unit = c.map(value => Math.max(Math.abs(value), 1e-3));
    const at = coordinates => grip.reduce(([x, z], {corner, weight}) =>
      [x + weight * sum(model.corners[corner].x, coordinates), z + weight * sum(model.corners[corner].z, coordinates)], [0, 0]);
    const offOf = coordinates => {
      const p = at(coordinates), off = [place[0] - p[0], place[1] - p[1]];
      return along ? [off[0] * along[0] + off[1] * along[1]] : off;
    };
    for (let step = 0; step < 20; ++step) {
      const off = offOf(c), delta = 1e-6;
      const slope = c.map((value, k) => {
        if (!free[k]) return off.map(() => 0);
        const moved = offOf(c.map((one, i) => (i === k ? one + delta * unit[k] : one)));
        return off.map((one, i) => (one - moved[i]) / delta);
      });
      // Least change: c += S^T (S S^T + e)^-1 off
      const size = off.map((_, i) => off.map((__, j) => slope.reduce((total, s) => total + s[i] * s[j], 0)));
      const largest = Math.max(...size.map((row, i) => row[i]));
      if (!(largest > 0)) return values;
      size.forEach((row, i) => { row[i] += 1e-9 * largest; });
      const solved = CameraModel.factorise(size)(off);
      slope.forEach((s, k) => { c[k] += unit[k] * s.reduce((total, one, i) => total + one * solved[i], 0); });
      if (Math.hypot(...off) < 1e-9) break;
    }
    return model.keys.map((key, i) => valueOf(key, c[i]));
  }

  return {corners, drag};
})();
