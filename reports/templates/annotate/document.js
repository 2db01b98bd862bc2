// annotation.toml as a tree of plain values, and the experiment file that includes it. `TOML` is smol-toml.
const AnnotationDocument = (() => {
  const units = {m: 1, cm: 1e-2, mm: 1e-3, rad: 1, deg: Math.PI / 180, s: 1, ms: 1e-3};
  const unitOf = key => Object.keys(units).find(unit => key.endsWith("_" + unit) || key === unit);
  const isTable = value => value !== null && typeof value === "object" && !Array.isArray(value);
  const isListOfTables = value => Array.isArray(value) && value.length > 0 && value.every(isTable);

  // The name of a replicate that states none: the stem of its file, as the program has it.
  function usualName(file) {
    const parts = String(file).split("/"), last = parts.pop();
    if (/[*%]/.test(last) || last === "") return parts.pop() ?? "";
    return last.replace(/(.)\.[^.]*$/, "$1");
  }
  const nameOf = replicate =>
    replicate.name ?? usualName(replicate.video ?? replicate.tracks ?? replicate.discharge ?? replicate.curves ?? "");

  function get(tree, path) {
    return path.reduce((node, key) => node?.[key], tree);
  }
  // Undefined takes the key out, and tables that are empty then.
  function set(tree, path, value) {
    const [key, ...rest] = path;
    if (rest.length === 0) {
      if (value === undefined) delete tree[key]; else tree[key] = value;
      return;
    }
    if (tree[key] === undefined && value === undefined) return;
    tree[key] ??= typeof rest[0] === "number" ? [] : {};
    set(tree[key], rest, value);
    if (Object.keys(tree[key]).length === 0 && value === undefined) delete tree[key];
  }

  // As the program reads both: what both state must be one value. `contradictions` get a sentence of each that is not.
  function merged(base, added, contradictions = [], path = "") {
    const both = {...base};
    for (const [key, value] of Object.entries(added)) {
      const place = path ? `${path}.${key}` : key, there = both[key];
      if (there === undefined) both[key] = value;
      else if (isTable(there) && isTable(value)) both[key] = merged(there, value, contradictions, place);
      else if (JSON.stringify(there) === JSON.stringify(value)) continue;
      else if (place === "replicate" && isListOfTables(there) && isListOfTables(value)) {
        both[key] = there.map(replicate => {
          const own = value.find(one => nameOf(one) === nameOf(replicate));
          return own ? merged(replicate, own, contradictions, place) : replicate;
        });
      } else {
        both[key] = value;
        contradictions.push(`${place} is stated otherwise in the experiment file; take it out there, or here.`);
      }
    }
    return both;
  }

  // The number under a stem with any unit, in SI, or undefined.
  function quantity(table, stem) {
    for (const [unit, factor] of Object.entries(units)) {
      const value = table?.[`${stem}_${unit}`];
      if (typeof value === "number") return value * factor;
    }
    return undefined;
  }
  // [x, z] of a point in m
  function placeOf(point) {
    for (const unit of ["mm", "cm", "m"])
      if (Array.isArray(point[unit])) return point[unit].map(value => value * units[unit]);
    return undefined;
  }
  // Rows of lengths, in m
  function rows(table, stem) {
    for (const unit of ["mm", "cm", "m"]) {
      const list = table?.[`${stem}_${unit}`];
      if (Array.isArray(list)) return list.map(row => row.map(value => value * units[unit]));
    }
    return [];
  }

  // All numbers of a tree with their paths: [path, value].
  function leaves(tree, path = []) {
    return Object.entries(tree ?? {}).flatMap(([key, value]) => {
      const place = [...path, Array.isArray(tree) ? Number(key) : key];
      return value !== null && typeof value === "object" ? leaves(value, place) : [[place, value]];
    });
  }

  const read = text => TOML.parse(text);
  const write = tree => (Object.keys(tree).length === 0 ? "" : TOML.stringify(tree).replace(/\s*$/, "\n"));
  const copy = tree => JSON.parse(JSON.stringify(tree));

  return {units, unitOf, nameOf, usualName, get, set, merged, quantity, placeOf, rows, leaves, read, write, copy, isTable, isListOfTables};
})();
