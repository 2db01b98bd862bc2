// The page of `graintruth annotate`. What is said stands in `state.doc`, the tree of annotation.toml, and nowhere else:
// every click and every field changes it, and everything that is shown is made of it anew.
(() => {
  const D = AnnotationDocument;
  const data = JSON.parse(document.getElementById("data").textContent);
  const element = id => document.getElementById(id);
  const base = D.read(data.experiment_text), template = data.template ? D.read(data.template) : {};
  const state = {doc: D.read(data.annotation_text), film: 0, frame: 0, tool: "point", chosen: null, hover: null, done: [], undone: [], savedText: null,
                 textError: "", awaitsOrigin: false, showsRig: true, cursor: null};
  const films = data.films;
  const mm = metres => 1e3 * metres;
  const rounded = (value, digits) => Number(value.toFixed(digits));
  const pixel = at => at.map(value => rounded(value, 2));

  // Elements with text, never with markup.
  function h(tag, properties = {}, ...children) {
    const made = document.createElement(tag);
    for (const [key, value] of Object.entries(properties)) {
      if (value === undefined || value === false) continue;
      if (key.startsWith("on")) made.addEventListener(key.slice(2), value);
      else if (key in made && key !== "list") made[key] = value;
      else made.setAttribute(key, value);
    }
    made.append(...children.flat().filter(child => child !== null && child !== undefined && child !== ""));
    return made;
  }
  const breakable = name => name.split(/(?<=_)/).flatMap(part => [document.createElement("wbr"), part]);
  const number = (value, digits = 3) => (Number.isFinite(value) ? String(Number(value.toPrecision(digits))) : "–");
  const plusMinus = ({value, sigma}, factor, unit) => {
    const error = Number((factor * sigma).toPrecision(2));
    const digits = error > 0 ? Math.max(0, 1 - Math.floor(Math.log10(error))) : 3;
    return `${(factor * value).toFixed(Math.min(digits, 6))} ± ${error} ${unit}`;
  };

  // ---- What is said ----

  const film = () => films[state.film];
  const picture = () => film().pictures[state.frame];
  let contradictions = [];
  function merged() {
    contradictions = [];
    return D.merged(base, state.doc, contradictions);
  }
  function change(edit) {
    const before = JSON.stringify(state.doc);
    const changed = D.copy(state.doc);
    edit(changed);
    const after = JSON.stringify(changed);
    if (after === before) return render();
    state.done.push(before);
    if (state.done.length > 500) state.done.shift();
    state.undone = [];
    state.doc = changed;
    render();
  }
  function step(from, to) {
    if (from.length === 0) return;
    to.push(JSON.stringify(state.doc));
    state.doc = JSON.parse(from.pop());
    state.chosen = null;
    render();
  }
  const undo = () => step(state.done, state.undone), redo = () => step(state.undone, state.done);

  // The table of a film in [[replicate]] of the annotation, made where there is none.
  function replicateIn(doc, one) {
    doc.replicate ??= [];
    let own = doc.replicate.find(each => D.nameOf(each) === one.name);
    if (!own) doc.replicate.push(own = {name: one.name});
    return own;
  }
  const statedOf = (tree, one) => (tree.replicate ?? []).find(each => D.nameOf(each) === one.name) ?? {};
  function dropBare(doc) {
    if (!doc.replicate || !base.replicate) return;
    doc.replicate = doc.replicate.filter(each => Object.keys(each).some(key => key !== "name" && key !== "video"));
    if (doc.replicate.length === 0) delete doc.replicate;
  }

  // ---- The camera, as far as it is known ----

  const discPixels = new Map();  // of discs that were made of clicked points: "film x z" -> px
  const discKey = (index, x, z) => `${index} ${x.toFixed(7)} ${z.toFixed(7)}`;
  films.forEach((one, index) => one.references.forEach(r => discPixels.set(discKey(index, r.x, r.z), r.pixel)));

  function scaleOf(all, index = state.film) {
    const camera = all.camera ?? {}, one = films[index];
    const given = [];
    if (D.rows(camera, "fiducials").length) given.push("discs");
    if (camera.point?.length) given.push("points");
    if (camera.chessboard) given.push("a chessboard");
    if (camera.stick) given.push("a stick");
    const clickError = camera.click_error_px ?? 0.5;
    const options = {width: one.width, height: one.height, pixelAspect: camera.pixel_aspect ?? 1};
    const result = {given, clickError, references: [], calibration: null, kind: given[0]};
    try {
      if (camera.stick && given.length === 1) {
        const {from_px: from, to_px: to, origin_px: origin = from} = camera.stick, length = D.quantity(camera.stick, "length");
        if (from && to && length > 0) {
          const uncertainty = D.quantity(camera.stick, "length_uncertainty") ?? 0;
          const relativeSigma = Math.hypot(Math.SQRT2 * clickError / Math.hypot(to[0] - from[0], to[1] - from[1]), uncertainty / length);
          result.calibration = CameraModel.levelCamera({from, to, origin, length, relativeSigma}, options);
        }
      } else if (camera.point?.length) {
        camera.point.forEach((point, place) => {
          const at = D.placeOf(point);
          if (at && at.every(Number.isFinite) && point.px) result.references.push({x: at[0], z: at[1], diameter: 0, pixel: point.px, place});
        });
        result.calibration = CameraModel.calibrate(result.references, {...options, expectedSigma: clickError, leastSigma: clickError});
      } else {
        const diameter = D.quantity(camera, "fiducial_diameter") ?? 0;
        for (const [x, z] of D.rows(camera, "fiducials")) {
          const seen = discPixels.get(discKey(index, x, z));
          if (seen) result.references.push({x, z, diameter, pixel: seen});
        }
        if (camera.chessboard) result.references = one.references.map(r => ({...r, diameter: 0}));
        result.calibration = CameraModel.calibrate(result.references, {...options, expectedSigma: 0.05, leastSigma: 0.01});
      }
    } catch {
      result.calibration = null;
    }
    if (result.calibration && !result.calibration.camera.parameters.every(Number.isFinite)) result.calibration = null;
    return result;
  }
  let all = merged(), scale = scaleOf(all);
  const camera = () => scale.calibration?.camera ?? null;

  // ---- The rig ----

  const rig = data.rig;
  // Of a dimension: where it is stated (of a replicate first), and its value in SI
  function dimension(key) {
    const own = key.is_setting ? D.quantity(statedOf(all, film()), key.stem) : undefined;
    const stated = own ?? (key.path.length === 1 ? D.quantity(all.rig, key.stem) : undefined) ?? (() => {
      const value = D.get(all.rig, key.path);
      return typeof value === "number" ? value * key.unit : undefined;
    })();
    return stated;
  }
  // What stands in the experiment file does not follow the pointer
  const isFree = key => D.quantity(base.rig, key.stem) === undefined && D.get(base.rig, key.path) === undefined &&
    (!key.is_setting || D.quantity(statedOf(base, film()), key.stem) === undefined);
  const dimensions = () => rig.keys.map((key, i) => dimension(key) ?? rig.values[i]);
  function setDimensions(doc, values, before) {
    rig.keys.forEach((key, i) => {
      if (Math.abs(values[i] - before[i]) <= 1e-9 * Math.max(1e-3, Math.abs(before[i]))) return;
      const written = rounded(values[i] / key.unit, key.unit === 1 ? 5 : 2);
      if (key.is_setting && D.quantity(all.rig, key.stem) === undefined) {
        replicateIn(doc, film())[key.path.at(-1)] = written;
      } else {
        setRig(doc, key.path, written);
      }
    });
  }
  // A list of walls is stated whole
  function setRig(doc, path, value) {
    doc.rig ??= {};
    if (typeof path[1] === "number" && !doc.rig[path[0]]) doc.rig[path[0]] = D.copy(all.rig?.[path[0]] ?? template.rig[path[0]]);
    D.set(doc.rig, path, value);
  }

  // ---- Things in the picture that can be taken hold of ----

  const tools = [
    ["move", "Look", "v", "Drag to move the picture, wheel or two fingers to zoom. Points can be dragged."],
    ["point", "Point", "p", "Click a point of known place, then type x and z in mm. Near a disc that was found (ring) its middle is taken; with Alt it is not."],
    ["stick", "Stick", "s", "Click both ends of something of known length, then type the length."],
    ["check", "Check", "c", "Click both ends of a length that you know as well, such as a grain's diameter: it only checks the scale."],
    ["rig", "Rig", "r", "Drag corners and lines of the rig onto its edges: its dimensions follow, but for those that stand in the experiment file."],
    ["grain", "Grain", "g", "Click the grains in the order of their numbers; drag the small handle along the long axis."],
    ["mask", "Mask", "m", "Click the corners of what nobody should look at; Enter, or a click on the first corner, ends it."],
  ];
  let draft = null;  // of a stick, a check or a mask that is being clicked: {kind, points}

  // Every handle: where it is, what it belongs to, and how it moves in a document.
  function handles() {
    const found = [], add = (id, at, move, kind) => found.push({id, at, move, kind});
    const own = state.doc.camera ?? {};
    (own.point ?? []).forEach((point, i) => add(`point ${i}`, point.px, (doc, at) => { doc.camera.point[i].px = pixel(at); }, "point"));
    if (own.stick) {
      for (const end of ["from_px", "to_px", "origin_px"])
        if (own.stick[end]) add(`stick ${end}`, own.stick[end], (doc, at) => { doc.camera.stick[end] = pixel(at); }, "stick");
    }
    (own.check ?? []).forEach((check, i) => {
      for (const end of ["from_px", "to_px"]) add(`check ${i} ${end}`, check[end], (doc, at) => { doc.camera.check[i][end] = pixel(at); }, "check");
    });
    (own.mask ?? []).forEach((mask, i) => mask.corners_px.forEach((corner, k) =>
      add(`mask ${i} ${k}`, corner, (doc, at) => { doc.camera.mask[i].corners_px[k] = pixel(at); }, "mask")));
    if (camera()) {
      (state.doc.start ?? []).forEach((start, i) => {
        const x = D.quantity(start, "x"), z = D.quantity(start, "z"), angle = D.quantity(start, "angle") ?? 0;
        add(`start ${i}`, camera().project(x, z), (doc, at) => {
          const [newX, newZ] = camera().unproject(at);
          doc.start[i] = {x_mm: rounded(mm(newX), 2), z_mm: rounded(mm(newZ), 2), ...("angle_deg" in doc.start[i] ? {angle_deg: doc.start[i].angle_deg} : {})};
        }, "grain");
        const reach = grainSize();
        add(`turn ${i}`, camera().project(x + reach * Math.cos(angle), z + reach * Math.sin(angle)), (doc, at) => {
          const [toX, toZ] = camera().unproject(at), turned = Math.atan2(toZ - z, toX - x) * 180 / Math.PI;
          delete doc.start[i].angle_rad;
          doc.start[i].angle_deg = rounded(((turned % 180) + 180) % 180, 1);
        }, "grain");
      });
    }
    return found;
  }
  // Half the length of a grain as far as the file tells it, m; else a fiftieth of the picture
  function grainSize() {
    const particle = all.particle ?? {};
    const sizes = [D.quantity(particle, "radius"), D.quantity(particle.plate ?? {}, "semi_major"), 0.5 * D.quantity(particle, "length"),
                   0.5 * D.quantity(particle, "diameter"),
                   ...(Array.isArray(particle.spheres) ? particle.spheres.map(s => Math.abs(D.quantity(s, "offset") ?? 0) + D.quantity(s, "radius")) : [])];
    const known = sizes.filter(size => size > 0);
    return known.length ? Math.max(...known) : film().width / 50 / camera().scale(0, 0);
  }
  function rigGrips() {
    if (!camera() || !rig.keys.length) return [];
    const corners = RigDrawing.corners(rig, dimensions());
    const grips = [];
    corners.forEach((at, corner) => grips.push({screen: camera().project(...at), grip: [{corner, weight: 1}], along: null}));
    rig.lines.forEach(({corners: [from, to]}) => {
      const a = corners[from], b = corners[to], length = Math.hypot(b[0] - a[0], b[1] - a[1]);
      if (length > 0) grips.push({line: [camera().project(...a), camera().project(...b)], ends: [from, to], along: [-(b[1] - a[1]) / length, (b[0] - a[0]) / length]});
    });
    return grips;
  }

  const view = new PictureView(element("view"), element("picture"), element("drawing"), draw, {
    down(at, event) {
      const reach = (event.pointerType === "touch" ? 22 : 10) / view.zoom;
      const near = (one, other) => Math.hypot(one[0] - other[0], one[1] - other[1]);
      const candidates = handles().filter(one => state.tool === "move" || state.tool === one.kind);
      const nearest = candidates.sort((one, other) => near(one.at, at) - near(other.at, at))[0];
      if (nearest && near(nearest.at, at) < reach) {
        if (draft?.kind === "mask" && draft.points.length) return false;
        state.chosen = nearest.id;
        this.held = {move: nearest.move, off: [nearest.at[0] - at[0], nearest.at[1] - at[1]], before: JSON.stringify(state.doc)};
        render();
        return true;
      }
      if (state.tool === "rig") {
        let best = null, least = 1.5 * reach;
        for (const one of rigGrips()) {
          let distance, grip = one.grip, from = at;
          if (one.line) {
            const [a, b] = one.line, length = near(a, b), t = ((at[0] - a[0]) * (b[0] - a[0]) + (at[1] - a[1]) * (b[1] - a[1])) / length ** 2;
            if (t < 0 || t > 1) continue;
            from = [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])];
            distance = near(at, from) + 0.6 * reach;  // corners first
            grip = [{corner: one.ends[0], weight: 1 - t}, {corner: one.ends[1], weight: t}];
          } else {
            distance = near(at, from = one.screen);
          }
          if (distance < least) {
            least = distance;
            best = {grip, along: one.along, off: [from[0] - at[0], from[1] - at[1]]};
          }
        }
        if (best) {
          const before = dimensions(), free = rig.keys.map(isFree);
          this.held = {...best, before: JSON.stringify(state.doc), move: (doc, to) =>
            setDimensions(doc, RigDrawing.drag(rig, before, free, best.grip, camera().unproject(to), best.along), before)};
          return true;
        }
      }
      return false;
    },
    move(at) {
      const doc = JSON.parse(this.held.before);
      this.held.move(doc, [at[0] + this.held.off[0], at[1] + this.held.off[1]]);
      state.doc = doc;
      state.hover = at;
      render();
    },
    up() {
      const {before} = this.held;
      if (JSON.stringify(state.doc) !== before) {
        state.done.push(before);
        state.undone = [];
      }
      render();
    },
    cancel() {
      state.doc = JSON.parse(this.held.before);
      render();
    },
    click(at, event) { clickAt(at, event.altKey); },
    hover(at) {
      state.hover = at;
      showPlace();
      if (draft) view.refresh();
    },
  });

  function snapped(at, isFree) {
    if (isFree || state.frame !== 0) return at;
    const disc = film().discs.find(one => Math.hypot(one.pixel[0] - at[0], one.pixel[1] - at[1]) < Math.max(0.6 * one.diameter, 8 / view.zoom));
    return disc ? disc.pixel : at;
  }

  function clickAt(at, isFree = false) {
    const tool = state.tool;
    if (state.awaitsOrigin) {
      state.awaitsOrigin = false;
      return change(doc => { if (doc.camera?.stick) doc.camera.stick.origin_px = pixel(at); });
    }
    if (tool === "point") {
      const px = pixel(snapped(at, isFree));
      let place = 0;
      change(doc => {
        doc.camera ??= {};
        doc.camera.point ??= [];
        doc.camera.point.push({px});
        place = doc.camera.point.length - 1;
        state.chosen = `point ${place}`;
      });
      focusOn(`point ${place}`);
    } else if (tool === "stick" || tool === "check") {
      draft ??= {kind: tool, points: []};
      draft.points.push(pixel(at));
      if (draft.points.length < 2) return render();
      const [from_px, to_px] = draft.points;
      draft = null;
      let id = "stick";
      change(doc => {
        doc.camera ??= {};
        if (tool === "stick") {
          doc.camera.stick = {from_px, to_px};
        } else {
          doc.camera.check ??= [];
          doc.camera.check.push({from_px, to_px});
          id = `check ${doc.camera.check.length - 1}`;
        }
      });
      focusOn(id);
    } else if (tool === "mask") {
      draft ??= {kind: tool, points: []};
      const first = draft.points[0];
      if (first && draft.points.length > 2 && Math.hypot(first[0] - at[0], first[1] - at[1]) < 12 / view.zoom) return endMask();
      draft.points.push(pixel(at));
      render();
    } else if (tool === "grain") {
      if (!camera()) return hint("The scale must be known first: click points, or a stick.", true);
      const [x, z] = camera().unproject(at);
      change(doc => {
        doc.start ??= [];
        doc.start.push({x_mm: rounded(mm(x), 2), z_mm: rounded(mm(z), 2)});
        state.chosen = `start ${doc.start.length - 1}`;
      });
    } else {
      state.chosen = null;
      render();
    }
  }
  function endMask() {
    if (draft?.kind !== "mask" || draft.points.length < 3) return;
    const corners_px = draft.points;
    draft = null;
    change(doc => {
      doc.camera ??= {};
      doc.camera.mask ??= [];
      doc.camera.mask.push({corners_px});
    });
  }
  function remove(id) {
    const [kind, index] = id.split(" "), i = Number(index);
    change(doc => {
      const list = {point: doc.camera?.point, check: doc.camera?.check, mask: doc.camera?.mask, start: doc.start, turn: doc.start}[kind];
      if (list) {
        list.splice(i, 1);
        if (list.length === 0) {
          if (kind === "start" || kind === "turn") delete doc.start; else delete doc.camera[kind];
        }
      }
      if (kind === "stick") delete doc.camera?.stick;
      if (doc.camera && Object.keys(doc.camera).length === 0) delete doc.camera;
      state.chosen = null;
    });
  }

  // ---- Drawing ----

  function draw(context) {
    const at = point => view.toScreen(point);
    const line = (points, colour, width = 1.5, dash = []) => {
      for (const [style, wide] of [["rgba(0,0,0,0.55)", width + 2], [colour, width]]) {
        context.strokeStyle = style;
        context.lineWidth = wide;
        context.setLineDash(dash);
        context.beginPath();
        points.forEach((point, i) => { const [x, y] = at(point); if (i) context.lineTo(x, y); else context.moveTo(x, y); });
        context.stroke();
      }
      context.setLineDash([]);
    };
    const ring = (point, radius, colour, width = 1.5) => {
      const [x, y] = at(point);
      for (const [style, wide] of [["rgba(0,0,0,0.55)", width + 2], [colour, width]]) {
        context.strokeStyle = style;
        context.lineWidth = wide;
        context.beginPath();
        context.arc(x, y, radius, 0, 2 * Math.PI);
        context.stroke();
      }
    };
    const cross = (point, colour, isChosen) => {
      const [x, y] = at(point), size = isChosen ? 12 : 8;
      for (const [style, wide] of [["rgba(0,0,0,0.6)", 3.5], [colour, 1.5]]) {
        context.strokeStyle = style;
        context.lineWidth = wide;
        context.beginPath();
        context.moveTo(x - size, y); context.lineTo(x - 2, y); context.moveTo(x + 2, y); context.lineTo(x + size, y);
        context.moveTo(x, y - size); context.lineTo(x, y - 2); context.moveTo(x, y + 2); context.lineTo(x, y + size);
        context.stroke();
      }
      if (isChosen) ring(point, 14, colour);
    };
    const label = (point, text, colour) => {
      const [x, y] = at(point);
      context.font = "600 13px system-ui, sans-serif";
      context.lineWidth = 3;
      context.strokeStyle = "rgba(0,0,0,0.75)";
      context.strokeText(text, x + 10, y - 8);
      context.fillStyle = colour;
      context.fillText(text, x + 10, y - 8);
    };
    const stated = all.camera ?? {}, blue = "#6cc3ff", orange = "#ffb454", pink = "#ff7ad9", green = "#7dff9a", red = "#ff6b60";
    // 1. Masks
    for (const mask of stated.mask ?? []) {
      context.fillStyle = "rgba(90, 90, 110, 0.65)";
      context.beginPath();
      mask.corners_px.forEach((corner, i) => { const [x, y] = at(corner); if (i) context.lineTo(x, y); else context.moveTo(x, y); });
      context.fill();
      line([...mask.corners_px, mask.corners_px[0]], "#c8c8d8", 1, [5, 4]);
    }
    // 2. The rig
    if (camera() && state.showsRig && rig.keys.length) {
      const corners = RigDrawing.corners(rig, dimensions());
      const between = (a, b) => Array.from({length: 17}, (_, k) => camera().project(a[0] + (b[0] - a[0]) * k / 16, a[1] + (b[1] - a[1]) * k / 16));
      for (const one of rig.lines) line(between(corners[one.corners[0]], corners[one.corners[1]]), green, 1.5);
      for (const one of rig.circles) {
        const [c, r] = [corners[one.centre], corners[one.rim]], radius = Math.hypot(r[0] - c[0], r[1] - c[1]);
        line(Array.from({length: 97}, (_, k) => camera().project(c[0] + radius * Math.cos(k * Math.PI / 48), c[1] + radius * Math.sin(k * Math.PI / 48))), green);
      }
      if (state.tool === "rig") corners.forEach(corner => ring(camera().project(...corner), 5, green));
    }
    // 3. Discs that were found
    if (state.frame === 0 && (state.tool === "point" || scale.kind === "discs"))
      film().discs.forEach(one => ring(one.pixel, Math.max(5, 0.5 * one.diameter * view.zoom + 3), orange, 1));
    // 4. Points and where the camera sees them
    (stated.point ?? []).forEach((point, i) => {
      if (!Array.isArray(point.px)) return;
      const place = scale.references.findIndex(r => r.place === i), residual = scale.calibration?.residuals[place];
      const colour = residual && !residual.used ? red : blue;
      if (residual) line([point.px, [point.px[0] + 20 * residual.px[0], point.px[1] + 20 * residual.px[1]]], colour, 1);
      cross(point.px, colour, state.chosen === `point ${i}`);
      label(point.px, String(i + 1), colour);
    });
    if (scale.kind === "discs" || scale.kind === "a chessboard") scale.references.forEach(r => cross(r.pixel, blue));
    // 5. Lengths
    const length = (one, colour, name, id) => {
      if (!one.from_px || !one.to_px) return;
      line([one.from_px, one.to_px], colour);
      for (const end of ["from_px", "to_px"]) cross(one[end], colour, state.chosen === `${id} ${end}`);
      label(one.to_px, name, colour);
    };
    if (stated.stick) {
      length(stated.stick, blue, "stick", "stick");
      if (stated.stick.origin_px) {
        cross(stated.stick.origin_px, green, state.chosen === "stick origin_px");
        label(stated.stick.origin_px, "0, 0", green);
      }
    }
    (stated.check ?? []).forEach((one, i) => length(one, pink, `check ${i + 1}`, `check ${i}`));
    // 6. Grains
    if (camera()) {
      const size = grainSize();
      (all.start ?? []).forEach((start, i) => {
        const x = D.quantity(start, "x"), z = D.quantity(start, "z"), angle = D.quantity(start, "angle");
        const middle = camera().project(x, z);
        ring(middle, 0.5 * size * camera().scale(x, z) * view.zoom, orange, state.chosen === `start ${i}` ? 3 : 1.5);
        if (angle !== undefined || state.tool === "grain") {
          const end = camera().project(x + size * Math.cos(angle ?? 0), z + size * Math.sin(angle ?? 0));
          if (angle !== undefined) line([middle, end], orange, 1);
          if (state.tool === "grain") ring(end, 4, orange);
        }
        label(middle, String(i + 1), orange);
      });
    }
    // 7. What is being clicked
    if (draft) {
      line([...draft.points, ...(state.hover ? [state.hover] : [])], "#ffffff", 1, [4, 3]);
      draft.points.forEach(point => cross(point, "#ffffff"));
    }
    if (state.cursor) cross(state.cursor, "#ffffff", true);
  }

  function hint(text, isRed = false) {
    const line = element("hint");
    line.textContent = text;
    line.className = isRed ? "red" : "";
  }
  function showPlace() {
    const at = state.cursor ?? state.hover;
    if (!at) return;
    const place = camera() ? camera().unproject(at) : null;
    element("place").textContent = `${at[0].toFixed(1)}, ${at[1].toFixed(1)} px` + (place ? `   x ${mm(place[0]).toFixed(2)}, z ${mm(place[1]).toFixed(2)} mm` : "");
  }

  // ---- The panel ----

  // A field of one value in a document. It keeps its place in the panel by `id`. What is typed counts once the field is left
  // or Enter is pressed; only after that the panel is made anew, so that Tab finds the next field.
  function field(id, value, set, {stays, ...properties} = {}) {
    const commit = ({target}) => {
      const text = target.value.trim();
      if (isRendering || text === target.dataset.initial) return;
      target.dataset.initial = text;
      setTimeout(() => set(text));
    };
    return h("input", {type: "text", value: value ?? "", "data-id": id, "data-initial": String(value ?? ""), autocomplete: "off", ...properties,
                       onchange: commit, onblur: commit,
                       onkeydown: event => {
                         if (event.key !== "Enter" || stays) return;
                         event.preventDefault();
                         element("view").focus({preventScroll: true});
                       }});
  }
  function focusOn(id) {
    const found = element("panel").querySelector(`[data-id="${CSS.escape(id)}"]`);
    if (!found) return;
    found.focus({preventScroll: window.innerWidth <= 800});
    found.select?.();
  }
  // Two numbers, in any usual writing: "-290, 220" or "-290 220"
  function numbersOf(text) {
    const found = text.replace(/[−–]/g, "-").match(/[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?/gi);
    return found ? found.map(Number) : [];
  }
  const numberOf = text => (numbersOf(text).length === 1 ? numbersOf(text)[0] : undefined);

  function scaleSection() {
    const own = state.doc.camera ?? {}, stated = all.camera ?? {};
    const parts = [h("h2", {}, "Scale")];
    if (scale.given.length === 0) parts.push(h("p", {}, "None yet. Click at least four points whose places you know, or both ends of a stick."));
    if (scale.given.length > 1) parts.push(h("p", {className: "red"}, `Contradiction: the scale comes from ${scale.given.join(" and from ")}. Keep one of them.`));
    const {calibration} = scale;
    if (calibration) {
      const {camera: found} = calibration;
      const middle = found.unproject([(found.width - 1) / 2, (found.height - 1) / 2]);
      const size = CameraModel.withError(calibration, one => one.scale(...middle));
      parts.push(h("p", {id: "scale-words"}, `Scale ${plusMinus(size, 1e-3, "px/mm")} in the middle`));
      if (scale.kind === "a stick") {
        parts.push(h("p", {className: "muted"}, "The camera is taken as level and square to the plane; a stick cannot tell."));
      } else {
        const tilt = CameraModel.withError(calibration, one => one.tilt);
        const bend = CameraModel.withError(calibration, one => {
          const r = 0.5 * Math.hypot(one.width, one.height) / Math.exp(one.parameters[0]);
          return one.parameters[8] * r * r + one.parameters[9] * r ** 4;
        });
        parts.push(h("p", {}, `Tilt ${plusMinus(tilt, 180 / Math.PI, "°")}, lens ${plusMinus(bend, 100, "%")} at the corner`));
        if (calibration.used.length === CameraModel.fewest) parts.push(h("p", {className: "muted"}, "Only four: their errors and the lens cannot be checked. More are better."));
        const left = calibration.residuals.length - calibration.used.length;
        if (left > 0) parts.push(h("p", {className: "red"}, `${left} lie off and are left out: places or clicks are wrong.`));
        const limit = Math.max(0.5, 3 * Math.SQRT2 * (scale.kind === "points" ? scale.clickError : 0.05));
        const rms = Math.sqrt(calibration.used.reduce((sum, i) => sum + calibration.residuals[i].px[0] ** 2 + calibration.residuals[i].px[1] ** 2, 0) / calibration.used.length);
        if (rms > limit) parts.push(h("p", {className: "red"}, `Contradiction: the points fit no camera (${number(rms)} px rms). Some places are wrong.`));
      }
      if (stated.lens) parts.push(h("p", {className: "muted"}, "The lens from pictures of a chessboard counts in the program, not on this page."));
    } else if (own.point?.length) {
      const missing = CameraModel.fewest - scale.references.length;
      if (missing > 0) parts.push(h("p", {}, `${missing} more point${missing > 1 ? "s" : ""} with a place needed.`));
    }
    if (scale.kind === "discs") parts.push(h("p", {className: scale.references.length < CameraModel.fewest ? "red" : ""}, `${scale.references.length} of ${D.rows(stated, "fiducials").length} discs were found in this film.`));
    if (own.point?.length) {
      parts.push(h("table", {"aria-label": "Points"}, h("thead", {}, h("tr", {}, ...["", "x, z in mm", "off, px", "mm", ""].map(text => h("th", {scope: "col"}, text)))),
        h("tbody", {}, own.point.map((point, i) => {
          const place = scale.references.findIndex(r => r.place === i), residual = calibration?.residuals[place];
          const at = D.placeOf(point), isOut = residual && !residual.used;
          return h("tr", {className: state.chosen === `point ${i}` ? "chosen" : ""},
            h("td", {}, h("button", {type: "button", className: "small", title: "Choose it", onclick: () => { state.chosen = `point ${i}`; state.tool = "point"; render(); }}, String(i + 1))),
            h("td", {}, field(`point ${i}`, at ? at.map(value => rounded(mm(value), 4)).join(", ") : "", text => {
              const numbers = numbersOf(text);
              change(doc => {
                const one = doc.camera.point[i];
                for (const unit of ["mm", "cm", "m"]) delete one[unit];
                if (numbers.length === 2) one.mm = numbers;
              });
              if (text && numbers.length !== 2) hint("Type two numbers: x, then z, in mm.", true);
            }, {placeholder: "x, z", "aria-label": `Place of point ${i + 1}, x and z in mm`, inputMode: "text"})),
            h("td", {className: `number${isOut ? " red" : ""}`, "data-residual": residual ? JSON.stringify(residual.px) : undefined}, residual ? Math.hypot(...residual.px).toFixed(2) : ""),
            h("td", {className: `number${isOut ? " red" : ""}`}, residual ? residual.mm.toFixed(2) : ""),
            h("td", {}, h("button", {type: "button", className: "small", "aria-label": `Remove point ${i + 1}`, onclick: () => remove(`point ${i}`)}, "×")));
        }))));
      const onDiscs = own.point.filter(point => D.placeOf(point) && film().discs.some(one => Math.hypot(one.pixel[0] - point.px[0], one.pixel[1] - point.px[1]) < 0.02));
      if (onDiscs.length >= CameraModel.fewest && onDiscs.length === own.point.length) {
        parts.push(h("div", {className: "row"}, h("label", {}, "All are discs. Their diameter, mm: ",
          field("disc diameter", "", text => {
            const diameter = numberOf(text);
            if (!(diameter > 0)) return;
            own.point.forEach(point => films.forEach((one, index) => {
              const [x, z] = D.placeOf(point);
              const seen = one.discs.find(disc => Math.hypot(disc.pixel[0] - point.px[0], disc.pixel[1] - point.px[1]) < 0.5 * disc.diameter);
              if (seen) discPixels.set(discKey(index, x, z), seen.pixel);
            }));
            change(doc => {
              doc.camera.fiducial_diameter_mm = diameter;
              doc.camera.fiducials_mm = doc.camera.point.map(point => D.placeOf(point).map(value => rounded(mm(value), 4)));
              delete doc.camera.point;
            });
          }, {size: 5, "aria-label": "Diameter of the discs, mm"}), " makes them discs, which the program finds in every film.")));
      }
    }
    if (own.stick) {
      const length = D.quantity(own.stick, "length");
      parts.push(h("div", {className: "fields"},
        h("label", {htmlFor: "stick-length"}, "Length of the stick, mm"),
        field("stick", length === undefined ? "" : rounded(mm(length), 4), text => change(doc => {
          for (const unit of ["m", "cm", "mm"]) delete doc.camera.stick[`length_${unit}`];
          const value = numberOf(text);
          if (value > 0) doc.camera.stick.length_mm = value;
        }), {id: "stick-length"}),
        h("label", {htmlFor: "stick-error"}, "± mm"),
        field("stick error", own.stick.length_uncertainty_mm, text => change(doc => D.set(doc.camera.stick, ["length_uncertainty_mm"], numberOf(text))), {id: "stick-error"})),
        h("div", {className: "row"},
          h("button", {type: "button", onclick: () => { state.awaitsOrigin = true; hint("Click the point (0, 0) of your lengths."); }}, own.stick.origin_px ? "Click the origin again" : "Click the origin"),
          h("button", {type: "button", onclick: () => remove("stick 0")}, "Remove the stick")));
    }
    if (own.point?.length || own.stick || own.check?.length) {
      parts.push(h("div", {className: "fields"}, h("label", {htmlFor: "click-error"}, "How well you click, px"),
        field("click error", own.click_error_px, text => change(doc => D.set(doc.camera, ["click_error_px"], numberOf(text))), {id: "click-error", placeholder: "0.5"})));
    }
    (own.check ?? []).forEach((check, i) => {
      const length = D.quantity(check, "length");
      let words = "", isRed = false;
      if (calibration && length > 0) {
        const seen = CameraModel.measureLength(calibration, check.from_px, check.to_px, scale.clickError);
        const sigma = Math.hypot(seen.sigma, D.quantity(check, "length_uncertainty") ?? 0);
        isRed = Math.abs(seen.value - length) > 3 * sigma;
        words = `${isRed ? "Contradiction: by the scale it is " : "by the scale "}${plusMinus({value: seen.value, sigma}, 1e3, "mm")}`;
      }
      parts.push(h("div", {className: "fields"}, h("label", {}, `Check ${i + 1}, mm`),
        h("span", {}, field(`check ${i}`, length === undefined ? "" : rounded(mm(length), 4), text => change(doc => {
          for (const unit of ["m", "cm", "mm"]) delete doc.camera.check[i][`length_${unit}`];
          const value = numberOf(text);
          if (value > 0) doc.camera.check[i].length_mm = value;
        }), {size: 6, style: "width: 6em", "aria-label": `Length of check ${i + 1}, mm`}), h("button", {type: "button", className: "small", "aria-label": `Remove check ${i + 1}`, onclick: () => remove(`check ${i}`)}, "×"))),
        h("p", {className: isRed ? "red" : "good"}, words));
    });
    if (own.mask?.length) {
      parts.push(h("p", {}, `${own.mask.length} mask${own.mask.length > 1 ? "s" : ""}: what is in them is not looked at. `,
        ...own.mask.map((_, i) => h("button", {type: "button", className: "small", onclick: () => remove(`mask ${i}`)}, `Remove ${i + 1}`))));
    }
    return h("section", {}, parts);
  }

  // Any value as TOML writes it
  const inToml = value => (value === undefined ? "" : TOML.stringify({v: {w: value}}).replace(/^\[v\]\s*w = /, "").trim());
  const asInline = value => {
    if (Array.isArray(value)) return `[${value.map(asInline).join(", ")}]`;
    if (D.isTable(value)) return `{${Object.entries(value).map(([key, one]) => `${key} = ${asInline(one)}`).join(", ")}}`;
    return inToml(value);
  };
  function fromToml(text) {
    if (text === "") return undefined;
    try {
      return D.read(`v = ${text}`).v;
    } catch {
      return text === "" ? undefined : D.read(`v = ${JSON.stringify(text)}`).v;
    }
  }

  // One row of a field that the template of the rig's kind has
  function fieldRow(path, example, isNeeded) {
    const value = D.get(state.doc, path), fixed = D.get(base, path), id = path.join(".");
    const text = value !== undefined ? asInline(value) : fixed !== undefined ? asInline(fixed) : "";
    const isWide = typeof example === "object";
    return [h("label", {htmlFor: `field ${id}`, className: isNeeded && text === "" ? "red" : ""}, breakable(path.slice(1).join("."))),
      field(id, text, entered => change(doc => D.set(doc, path, fromToml(entered))),
        {id: `field ${id}`, placeholder: asInline(example), className: isWide ? "wide" : "", disabled: fixed !== undefined && value === undefined,
         title: fixed !== undefined && value === undefined ? "stands in the experiment file" : "", stays: true})];
  }
  function rigSection() {
    const parts = [h("h2", {}, "Rig")];
    if (!rig.keys.length && !template.rig) return null;
    parts.push(h("p", {}, rig.words));
    if (rig.keys.length && !camera()) parts.push(h("p", {className: "muted"}, "It is drawn once the scale is known."));
    const shown = new Set();
    const rows = rig.keys.map((key, i) => {
      const path = key.is_setting ? null : ["rig", ...key.path];
      shown.add(`rig.${key.path.join(".")}`);
      const value = dimension(key);
      const written = value === undefined ? "" : rounded(value / key.unit, key.unit === 1 ? 5 : 3);
      return [h("label", {htmlFor: `rig ${i}`, className: value === undefined && !data.optional.includes(`rig.${key.path.join(".")}`) ? "red" : ""}, breakable(key.path.join("."))),
        field(`rig ${i}`, written, text => change(doc => {
          const entered = numberOf(text);
          if (path) setRig(doc, key.path, entered);
          else if (entered !== undefined) replicateIn(doc, film())[key.path.at(-1)] = entered;
        }), {id: `rig ${i}`, placeholder: String(rounded(rig.values[i] / key.unit, 3)), stays: true})];
    });
    for (const [path, example] of Object.entries(template.rig ?? {}).map(([key, value]) => [["rig", key], value])) {
      if (shown.has(path.join(".")) || typeof example === "object" || path[1] === "kind") continue;
      rows.push(fieldRow(path, example, !data.optional.includes(path.join("."))));
    }
    parts.push(h("div", {className: "fields"}, rows.flat()));
    if (rig.keys.length) {
      parts.push(h("div", {className: "row"}, h("label", {}, h("input", {type: "checkbox", checked: state.showsRig, onchange: event => { state.showsRig = event.target.checked; render(); }}), " draw it")));
    }
    return h("section", {}, parts);
  }

  // Keys of replicates that are settings of the rig, such as the width of an orifice
  const usual = /^(name|video|tracks|discharge|curves|corrections|held_out|y_axis|outline|(frame_rate|noted_event|event|scale|origin)_\w+)$/;
  let settings = [];
  const conditionOf = one => settings.map(key => statedOf(all, one)[key]).join();
  function filmsSection() {
    settings = [...new Set([template, all].flatMap(tree => (tree.replicate ?? []).flatMap(Object.keys)))].filter(key => !usual.test(key));
    const conditions = [...new Set(films.map(conditionOf))];
    const heldOut = new Set(films.filter(one => statedOf(all, one).held_out === true).map(conditionOf));
    const head = ["film", ...settings.map(key => key.replace(/_/g, " ")), "starts at, s", "held out"];
    const rows = films.map((one, index) => {
      const own = statedOf(state.doc, one), both = statedOf(all, one), isOut = both.held_out === true || (heldOut.size && heldOut.has(conditionOf(one)));
      const start = both.noted_event_s ?? all.camera?.noted_event_s;
      return h("tr", {className: isOut ? "out" : index === state.film ? "chosen" : ""},
        h("td", {}, base.replicate ? h("button", {type: "button", className: "small", onclick: () => showFilm(index)}, one.name)
          : field(`name ${index}`, one.name, text => {
              if (!text || text.includes("/") || films.some(other => other !== one && other.name === text)) return render();
              const before = one.name;
              change(doc => {
                const table = doc.replicate.find(each => D.nameOf(each) === before);
                table.name = text;
                one.name = text;
              });
            }, {"aria-label": `Name of film ${index + 1}`})),
        ...settings.map(key => h("td", {}, field(`${key} ${index}`, own[key] ?? both[key], text => change(doc => {
          const table = replicateIn(doc, one);
          D.set(table, [key], numberOf(text));
          dropBare(doc);
        }), {"aria-label": `${key} of ${one.name}`, stays: true}))),
        h("td", {}, field(`starts ${index}`, start, text => change(doc => {
          D.set(replicateIn(doc, one), ["noted_event_s"], numberOf(text));
          dropBare(doc);
        }), {"aria-label": `Start of ${one.name}, s`, stays: true, placeholder: one.suggestion ? `${one.suggestion.time.toFixed(3)}?` : ""})),
        h("td", {}, h("input", {type: "checkbox", checked: both.held_out === true, "aria-label": `${one.name} is held out`, onchange: event => change(doc => {
          const table = replicateIn(doc, one);
          if (event.target.checked) table.held_out = true; else delete table.held_out;
          dropBare(doc);
        })})));
    });
    const parts = [h("h2", {}, "Films and conditions"),
      h("table", {}, h("thead", {}, h("tr", {}, head.map(text => h("th", {scope: "col"}, text)))), h("tbody", {}, rows))];
    if (conditions.length > 1) parts.push(h("p", {className: "muted"}, `${conditions.length} conditions. Films with the same settings are repeats of each other.`));
    if (heldOut.size) parts.push(h("p", {className: "muted"}, "Grey: held out. They are predicted in the end and not calibrated on."));
    const open = films.filter(one => one.suggestion && statedOf(all, one).noted_event_s === undefined && all.camera?.noted_event_s === undefined);
    if (open.length) {
      parts.push(h("div", {className: "row"}, h("button", {type: "button", id: "take-starts", onclick: () => change(doc => {
        for (const one of open) replicateIn(doc, one).noted_event_s = rounded(one.suggestion.time, 4);
      })}, "Take the suggested starts")));
    }
    const suggestion = film().suggestion;
    parts.push(h("p", {className: "muted"}, suggestion ? `${film().name}: the picture begins to change at ${suggestion.time.toFixed(3)} ± ${suggestion.uncertainty.toFixed(3)} s (${suggestion.words}).`
      : `${film().name}: no start is seen; all rests or all moves from the first picture on.`));
    return h("section", {}, parts);
  }

  function grainsSection() {
    const own = state.doc.start ?? [], found = film().grains;
    const parts = [h("h2", {}, "Grains")];
    if (base.start) parts.push(h("p", {}, `${base.start.length} starting places stand in the experiment file.`));
    else if (!own.length) parts.push(h("p", {className: "muted"}, "Not needed: without starting places the first film numbers the grains by rows from below."));
    if (found.length && !base.start) {
      parts.push(h("div", {className: "row"}, h("button", {type: "button", id: "take-grains", onclick: () => change(doc => {
        doc.start = found.map(({x, z, angle}) => ({x_mm: rounded(mm(x), 2), z_mm: rounded(mm(z), 2), ...(angle === null ? {} : {angle_deg: rounded(angle * 180 / Math.PI, 1)})}));
      })}, `Take the ${found.length} that the tracks of ${film().name} show`)));
    }
    if (own.length) {
      const count = all.particle?.count;
      if (count && count !== own.length) parts.push(h("p", {className: "red"}, `${own.length} of ${count} grains are marked.`));
      parts.push(h("details", {open: own.length <= 12}, h("summary", {}, `${own.length} starting places`), h("table", {}, h("tbody", {}, own.map((start, i) =>
        h("tr", {className: state.chosen === `start ${i}` ? "chosen" : ""},
          h("td", {}, field(`grain ${i}`, i + 1, text => {
            const to = Math.min(own.length, Math.max(1, Math.round(numberOf(text) ?? i + 1))) - 1;
            change(doc => doc.start.splice(to, 0, ...doc.start.splice(i, 1)));
          }, {"aria-label": `Number of grain ${i + 1}`, stays: true, style: "width: 3.5em"})),
          h("td", {className: "number"}, `${number(mm(D.quantity(start, "x")), 5)}, ${number(mm(D.quantity(start, "z")), 5)} mm`),
          h("td", {}, h("button", {type: "button", className: "small", "aria-label": `Remove grain ${i + 1}`, onclick: () => remove(`start ${i}`)}, "×"))))))));
      parts.push(h("div", {className: "row"}, h("button", {type: "button", onclick: () => change(doc => { delete doc.start; })}, "Remove all")));
    }
    return h("section", {}, parts);
  }

  function numbersSection() {
    const paths = [["camera", "frame_rate_hz"]];
    for (const section of ["particle", "material"]) for (const key of Object.keys(template[section] ?? base[section] ?? {})) paths.push([section, key]);
    const examples = path => D.get(template, path) ?? D.get(base, path) ?? 50;
    const isOptional = path => path.at(-1).includes("uncertainty") || data.optional.includes(path.join("."));
    const missing = paths.filter(path => D.get(all, path) === undefined && !isOptional(path) && data.from_nothing);
    const rows = paths.flatMap(path => fieldRow(path, examples(path), data.from_nothing && !isOptional(path)));
    const parts = [h("h2", {}, "The laboratory's numbers")];
    if (data.from_nothing) parts.push(h("p", {className: "muted"}, "Grey values are those of the template. Type your own; the unit is in the name. Another shape or unit goes into the text below."));
    parts.push(h("details", {open: data.from_nothing}, h("summary", {}, missing.length ? `${missing.length} are missing` : "all are there"), h("div", {className: "fields"}, rows)));
    return h("section", {}, parts);
  }

  let fileText = null;  // the text area, which stays
  function fileSection() {
    const parts = [h("h2", {}, data.annotation_name)];
    if (contradictions.length || data.complaint)
      parts.push(h("ul", {className: "problems"}, contradictions.map(text => h("li", {className: "red"}, `Contradiction: ${text}`)),
        data.complaint && !state.done.length ? [h("li", {}, `When this page was made: ${data.complaint}`)] : []));
    fileText ??= h("textarea", {id: "file", spellcheck: false, "aria-label": "The text of the annotation", "data-id": "file", onchange: event => readText(event.target.value)});
    if (document.activeElement !== fileText && !state.textError) fileText.value = D.write(state.doc);
    parts.push(fileText);
    if (state.textError) parts.push(h("p", {className: "red", id: "text-error"}, state.textError));
    parts.push(h("div", {className: "row"},
      h("button", {type: "button", id: "download", onclick: download}, "Download"),
      h("button", {type: "button", id: "open", onclick: () => opener.click()}, "Open a file"),
      h("button", {type: "button", onclick: copyText}, "Copy")),
      h("p", {className: "muted"}, "Then: ", h("code", {}, data.apply)));
    return h("section", {}, parts);
  }
  const opener = h("input", {type: "file", accept: ".toml", id: "opener", hidden: true, onchange: async event => {
    const [file] = event.target.files;
    if (file) readText(await file.text());
    event.target.value = "";
  }});
  document.body.append(opener);

  function readText(text) {
    try {
      const doc = D.read(text);
      state.textError = "";
      change(changed => {
        for (const key of Object.keys(changed)) delete changed[key];
        Object.assign(changed, doc);
      });
    } catch (error) {
      state.textError = `This is not valid TOML${error.line ? `, line ${error.line}` : ""}: ${String(error.message).split("\n")[0]}`;
      if (fileText) fileText.value = text;
      render();
    }
  }
  // Where the browser lends no clipboard to pages from disk, the text is marked instead
  async function copyText() {
    try {
      await navigator.clipboard.writeText(D.write(state.doc));
      hint("Copied.");
    } catch {
      fileText.focus();
      fileText.select();
      hint("Press Ctrl+C: the text is marked.");
    }
  }
  function download() {
    const text = D.write(state.doc);
    const link = h("a", {href: URL.createObjectURL(new Blob([text], {type: "application/toml"})), download: data.annotation_name});
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10000);
    state.savedText = text;
    hint(`Downloaded. Then: ${data.apply}`);
  }
  window.addEventListener("beforeunload", event => {
    if (state.done.length && D.write(state.doc) !== state.savedText) event.preventDefault();
  });

  // ---- All of it ----

  let isRendering = false;
  function render() {
    if (isRendering) return;
    isRendering = true;
    all = merged();
    scale = scaleOf(all);
    const panel = element("panel"), active = document.activeElement;
    const id = panel.contains(active) ? active.dataset.id : null, where = active?.selectionStart, until = active?.selectionEnd;
    const typed = id && id !== "file" && active.value !== active.dataset.initial ? active.value : null;
    const scrolled = panel.scrollTop;
    panel.replaceChildren(...[scaleSection(), rigSection(), filmsSection(), grainsSection(), numbersSection(), fileSection()].filter(Boolean));
    panel.scrollTop = scrolled;
    if (id) {
      const again = panel.querySelector(`[data-id="${CSS.escape(id)}"]`);
      again?.focus({preventScroll: true});
      if (again && typed !== null) again.value = typed;
      if (again?.type === "text") again.setSelectionRange(where, until);
    }
    element("undo").disabled = !state.done.length;
    element("redo").disabled = !state.undone.length;
    for (const button of element("tools").children) {
      button.setAttribute("aria-checked", String(button.dataset.tool === state.tool));
      button.tabIndex = button.dataset.tool === state.tool ? 0 : -1;
    }
    [...element("film").options].forEach((option, i) => { option.textContent = films[i].name + (statedOf(all, films[i]).held_out ? " (held out)" : ""); });
    const {frame, time} = picture();
    element("moment").textContent = `picture ${frame} of ${film().frames}, ${time.toFixed(3)} s`;
    showPlace();
    view.refresh();
    document.body.dataset.rendered = String(Number(document.body.dataset.rendered ?? 0) + 1);
    isRendering = false;
  }

  const images = new Map();
  function showPicture() {
    const source = picture().source;
    let image = images.get(source);
    if (!image) {
      images.set(source, image = new Image());
      image.src = source;
    }
    const show = () => {
      if (picture().source !== source) return;
      view.show(image);
      document.body.dataset.shown ??= String(Math.round(performance.now()));  // ms since the page was opened
    };
    if (image.complete && image.naturalWidth) show(); else image.onload = show;
    render();
  }
  function showFrame(place) {
    state.frame = Math.min(film().pictures.length - 1, Math.max(0, place));
    element("frame").value = state.frame;
    showPicture();
  }
  function showFilm(index) {
    state.film = index;
    element("film").value = String(index);
    element("frame").max = String(film().pictures.length - 1);
    draft = null;
    showFrame(0);
  }
  function choose(tool) {
    state.tool = tool;
    draft = null;
    state.awaitsOrigin = false;
    state.cursor = null;
    hint(tools.find(one => one[0] === tool)[3]);
    render();
  }

  element("tools").append(...tools.map(([tool, name, key]) =>
    h("button", {type: "button", role: "radio", "data-tool": tool, title: `Key ${key.toUpperCase()}`, onclick: () => choose(tool)}, name)));
  element("tools").addEventListener("keydown", event => {
    const step = {ArrowLeft: -1, ArrowUp: -1, ArrowRight: 1, ArrowDown: 1}[event.key];
    if (!step) return;
    event.preventDefault();
    const next = (tools.findIndex(one => one[0] === state.tool) + step + tools.length) % tools.length;
    choose(tools[next][0]);
    element("tools").children[next].focus();
  });
  element("film").append(...films.map((one, i) => h("option", {value: String(i)}, one.name)));
  element("film").addEventListener("change", event => showFilm(Number(event.target.value)));
  element("frame").addEventListener("input", event => showFrame(Number(event.target.value)));
  element("earlier").addEventListener("click", () => showFrame(state.frame - 1));
  element("later").addEventListener("click", () => showFrame(state.frame + 1));
  element("undo").addEventListener("click", undo);
  element("redo").addEventListener("click", redo);
  element("fit").addEventListener("click", () => view.fit());
  element("contrast").addEventListener("input", event => { view.contrast = Number(event.target.value); view.refresh(); });
  element("start-here").addEventListener("click", () => change(doc => { replicateIn(doc, film()).noted_event_s = rounded(picture().time, 4); }));

  // With the keyboard alone: a cross is moved and clicked, or what is chosen is moved.
  element("view").addEventListener("keydown", event => {
    const arrow = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1]}[event.key];
    if (arrow) {
      event.preventDefault();
      const size = event.ctrlKey ? 20 : event.shiftKey ? 1 : 0.1;
      const held = state.chosen && handles().find(one => one.id === state.chosen);
      if (held && !state.cursor) return change(doc => held.move(doc, [held.at[0] + size * arrow[0], held.at[1] + size * arrow[1]]));
      state.cursor ??= view.toPixel(view.size.map(length => length / 2));
      state.cursor = [state.cursor[0] + size * arrow[0], state.cursor[1] + size * arrow[1]];
      showPlace();
      view.refresh();
    } else if (event.key === "Enter") {
      event.preventDefault();
      if (draft?.kind === "mask" && !state.cursor) return endMask();
      if (state.cursor) clickAt(state.cursor, event.altKey);
      state.cursor = null;
    } else if (event.key === "x") {  // begins a cross in the middle
      state.chosen = null;
      state.cursor = view.toPixel(view.size.map(length => length / 2));
      showPlace();
      view.refresh();
    }
  });
  document.addEventListener("keydown", event => {
    const isTyping = /^(INPUT|TEXTAREA|SELECT)$/.test(document.activeElement?.tagName ?? "") && document.activeElement.type !== "range" && document.activeElement.type !== "checkbox";
    if ((event.ctrlKey || event.metaKey) && event.key.toLowerCase() === "z" && document.activeElement !== fileText) {
      event.preventDefault();
      if (event.shiftKey) redo(); else undo();
    }
    if (isTyping || event.ctrlKey || event.metaKey || event.altKey) return;
    const tool = tools.find(one => one[2] === event.key);
    if (tool) choose(tool[0]);
    else if (event.key === "[" ) showFrame(state.frame - 1);
    else if (event.key === "]") showFrame(state.frame + 1);
    else if (event.key === "0") view.fit();
    else if (event.key === "+" || event.key === "=") view.zoomBy(1.3);
    else if (event.key === "-") view.zoomBy(1 / 1.3);
    else if ((event.key === "Delete" || event.key === "Backspace") && state.chosen) remove(state.chosen);
    else if (event.key === "Escape") { draft = null; state.cursor = null; state.chosen = null; state.awaitsOrigin = false; render(); }
  });

  showFilm(0);
  choose(scale.given.length === 0 || state.doc.camera?.point ? "point" : "move");
})();
