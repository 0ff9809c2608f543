// The page: what was chosen, what is drawn for it, and what happens when the user moves.

const facts = JSON.parse(document.getElementById("facts").textContent);
// What the first picture needs stands before this script, the other columns after it: they may still be on their way.
const whole = new Promise((resume) => addEventListener("DOMContentLoaded", resume));
const embedded = async (name) => {
  const place = () => document.getElementById(`column-${name}`);
  if (!place() || !place().nextSibling) await whole;
  return place().textContent;
};
let table = new Table(facts, embedded);
let state, cells = null, axes = null, window_ = null;
let cursor = null; // where the user points: name and value on both axes, as cells are others after the next choice
let line = null; // along which the arrow keys go
const place = document.getElementById("plot"), status_ = document.getElementById("status");
const server = facts.live ? new Server(facts.live) : null;
const plot = new Plot(document.getElementById("figure"), (event, at) => seen(event, at));
const readout = new Readout(table, (row) => scene(row));

function beginning() {
  const inputs = [...table.about.values()].filter((about) => about.input).sort((a, b) => varied(b) - varied(a));
  const names = inputs.map((about) => about.name);
  const [x, y] = table.has("N") && varied(table.about.get("N")) > 1 && varied(table.about.get("zeta_T")) > 1
    ? ["N", "zeta_T"] : [names[0], names[1]];
  const ratio = table.has("ke_ratio") ? "ke_ratio" : [...table.about.keys()].find((name) => name.endsWith("_ratio"));
  return {
    x, y, of: ratio || "rows", xScale: "auto", yScale: "auto", ofScale: "auto",
    take: "lowest", chaos: CALM_FIRST, error: 0.1, slices: [],
  };
}

function varied(about) {
  return about.values ? about.values.length : table.rows;
}

function words(name) {
  const about = table.about.get(name);
  return about && about.unit.length > 1 ? `${name} (${about.unit})` : name;
}

let drawing = Promise.resolve();
function redraw() {
  drawing = drawing.then(draw).catch((error) => { console.error(error); });
  return drawing;
}

async function draw() {
  const start = performance.now();
  const inputs = [...table.about.values()].filter((about) => about.input).map((about) => about.name);
  await table.need([state.x, state.y, state.of, "chaotic", table.errorOf(state.of), ...inputs]);
  axes = [new Axis(table, state.x, state.xScale), new Axis(table, state.y, state.yScale)];
  cells = null; // those of the picture before: no key and no pointer may ask them any more
  await plot.show(...axes, words);
  render();
  const marks = document.documentElement.dataset;
  marks.drawn = Math.round(performance.now() - start);
  marks.pictures = Number(marks.pictures || 0) + 1;
}

// The cells, unless only what is in view has moved and no axis has bins; then the pixels.
function render(moved = false) {
  const [width, height] = plot.size(), view = plot.window(), dot = table.rows > 5000 ? 4 : 8;
  if (!moved || axes.some((axis) => !axis.edges)) {
    const across = gridOf(axes[0], view[0], view[1], width, dot), up = gridOf(axes[1], view[2], view[3], height, dot);
    cells = cellsOf(table, state, across, up);
  }
  const colours = coloursOf(table, state.of, state.ofScale, facts.colours, cells);
  const said = title();
  plot.colours(colours, said);
  document.getElementById("title").textContent = said;
  plot.draw(paint(table, cells, colours, state, view, width, height), width, height, view);
  window_ = view;
  caption();
  const at = pointed();
  if (at) return point(...at);
  plot.outline(null);
  return readout.clear();
}

// Of the picture, which must tell by itself what it shows.
function title() {
  const alike = [...table.about.values()].filter(({ name, input, values }) =>
    input && values?.length === 1 && values[0] === values[0] && name !== state.x && name !== state.y);
  const fixed = [...state.slices.filter(([, value]) => value !== null), ...alike.map(({ name, values }) => [name, values[0]])]
    .map(([name, value]) => `${name} = ${table.text(name, value)}`);
  const all = state.slices.filter(([, value]) => value === null).map(([name]) => name);
  const taken = all.length && state.of !== "rows" ? `, ${state.take} over ${all.join(", ")}` : "";
  return `colour: ${state.of === "rows" ? "number of rows" : words(state.of)}${taken}${fixed.length ? ` at ${fixed.join(", ")}` : ""}`;
}

function caption() {
  const held = table.facts, others = Object.entries(held.left).map(([label, n]) => `${n} ${label}`).join(", ");
  const parts = [`${held.rows} of ${held.all_rows} rows done${others ? ` (${others})` : ""}`];
  if (held.unchecked) parts.push(`${held.unchecked === held.rows ? "no row" : `${counted(held.unchecked)} not`} checked for chaos`);
  if (!server && (held.left.pending || held.left.torn)) parts.push("unfinished when this page was made");
  status_.textContent = parts.join("; ") + ".";
}

function seen(event, at) {
  if (event === "moved") return cells && render(true);
  if (!cells || !at) return undefined;
  const i = indexAt(cells.across.edges, at.x), j = indexAt(cells.up.edges, at.y);
  if (i < 0 || j < 0) return undefined;
  if (!cells.rows[j * cells.across.count + i]) return undefined;
  line = null;
  point(i, j);
  if (event === "pick") readout.pick(cells.row[j * cells.across.count + i]);
  return undefined;
}

function indexAt(edges, s) {
  return s < edges[edges.length - 1] ? indexBelow(edges, s) : -1;
}

function point(i, j) {
  const { across, up } = cells, cell = j * across.count + i;
  cursor = [valueAt(across, i, cells.row[cell]), valueAt(up, j, cells.row[cell])];
  plot.outline([across.edges[i], across.edges[i + 1], up.edges[j], up.edges[j + 1]]);
  readout.show(state, cells, cell);
}

// What a place on an axis stands for: its value; between the edges of a bin that of the row it shows, or the middle.
function valueAt({ axis, edges }, k, row) {
  const middle = () => axis.toBokeh((edges[k] + edges[k + 1]) / 2);
  return { name: axis.name, value: axis.cells ? axis.cells[k] : row >= 0 ? table.numbers(axis.name)[row] : middle() };
}

// The cell to which the user points; null where these cells have no such one.
function pointed() {
  if (!cursor || !cells) return null;
  const [i, j] = [cells.across, cells.up].map(({ axis, at }, k) => (axis.name === cursor[k].name ? at(cursor[k].value) : -1));
  return i < 0 || j < 0 ? null : [i, j];
}

// The next column, or line, of cells that holds a row, and in it the cell nearest to the line from which the keys came:
// so they reach every row, and return to their line behind a gap.
function step(di, dj) {
  if (!cells) return;
  const at = pointed(), { across, up } = cells;
  if (!at) {
    const first = cells.rows.findIndex((n) => n > 0);
    return void (first >= 0 && point(first % across.count, Math.floor(first / across.count)));
  }
  const k = di ? 0 : 1, counts = [across.count, up.count], place = (a, b) => (k ? [b, a] : [a, b]);
  if (line?.cells !== cells || line.k !== k) line = { cells, k, from: at[1 - k] };
  for (let a = at[k] + di + dj; a >= 0 && a < counts[k]; a += di + dj) {
    for (let off = 0; off < counts[1 - k]; off++) {
      for (const [i, j] of [place(a, line.from - off), place(a, line.from + off)]) {
        if (i < 0 || j < 0 || i >= across.count || j >= up.count) continue;
        if (cells.rows[j * across.count + i]) return void point(i, j);
      }
    }
  }
}

const KEYS = {
  ArrowLeft: () => step(-1, 0), ArrowRight: () => step(1, 0), ArrowUp: () => step(0, 1), ArrowDown: () => step(0, -1),
  Enter: () => keep(),
  "+": () => plot.zoom(1.5, centre()), "-": () => plot.zoom(1 / 1.5, centre()), 0: () => plot.whole(),
};

function keep() {
  const at = pointed();
  if (at) readout.pick(cells.row[at[1] * cells.across.count + at[0]]);
}

function centre() {
  const at = pointed();
  if (!at) return null;
  const { across, up } = cells, [i, j] = at;
  return [(across.edges[i] + across.edges[i + 1]) / 2, (up.edges[j] + up.edges[j + 1]) / 2];
}

place.addEventListener("keydown", (event) => {
  if (event.target !== place || !KEYS[event.key] || event.ctrlKey || event.altKey || event.metaKey) return;
  event.preventDefault();
  KEYS[event.key]();
});

let scenes = 0;
async function scene(row) {
  if (!server) return;
  const number = ++scenes, wanted = () => number === scenes; // of several picks the last one is shown
  const part = document.getElementById("scene"), said = document.getElementById("scene-said");
  const task = table.value("task", row); // now: the table may have grown when the answer comes
  part.hidden = false;
  said.textContent = `computing task ${task} ..`;
  try {
    const found = await server.ask(`/scene?task=${task}&table=${server.table}`);
    if (!wanted()) return;
    said.textContent = found.words;
    await drawScene(found, facts.colours.plain, wanted);
    if (wanted()) part.dataset.task = task;
  } catch (error) {
    if (wanted()) said.textContent = error.message;
  }
}

// The table has more rows: all is drawn anew, with the same choices and the same rows kept.
async function grown(rows) {
  const packed_ = new Map(rows.columns.map((column) => [column.name, column.data]));
  const kept = table.rows ? readout.rows.map((row) => table.value("task", row)) : [];
  const next = new Table(rows, async (name) => packed_.get(name));
  await next.need([...next.about.keys()]);
  const tasks = next.numbers("task");
  table = next;
  cells = null; // until they are drawn anew: these are rows of the table before
  Object.assign(readout, { table, last: null, rows: kept.map((task) => tasks.indexOf(task)).filter((row) => row >= 0) });
  readout.list();
  document.getElementById("part").textContent = rows.part;
  return start(false);
}

function start(first) {
  const none = !table.rows;
  document.getElementById("nothing").hidden = !none;
  document.getElementById("work").hidden = none;
  if (none) return caption_of_nothing();
  if (first || !state) state = beginning();
  return table.need([state.x, state.y, "task"]).then(() => {
    controls(table, state, redraw);
    meanings(table);
    return redraw();
  });
}

function caption_of_nothing() {
  const others = Object.entries(table.facts.left).map(([label, n]) => `${n} ${label}`).join(", ");
  // Rows of a search that nobody asks for now may be asked for once others are known.
  const { pending, torn, unasked } = table.facts.left, open = pending || torn || (server && unasked);
  status_.textContent = `No row is done${open ? " yet" : ""}${others ? `: ${others}` : ""}.`;
  document.getElementById("nothing").textContent = !open ? "No row has a number to show."
    : server ? "This page shows rows as soon as there are some." : "A page that is made later shows the rows that there are then.";
}

// Which table the page shows, and what is said of it.
function source() {
  const said = ["part", "made"].map((id) => document.getElementById(id)?.textContent).filter(Boolean);
  return [facts.name, ...said];
}

// The legend in words: the second class of a swatch says how it looks.
function marks() {
  const keys = [...document.querySelectorAll(".legend .key")];
  return keys.map((key) => `${key.querySelector(".swatch").classList[1]}: ${key.textContent.trim()}`).join("; ");
}

const stem = facts.name.replace(/\.[^.]*$/, "");
document.getElementById("save-picture").addEventListener("click", () =>
  plot.picture(source(), [marks()]).toBlob((blob) => save(blob, `${stem}.png`)));
document.getElementById("save-view").addEventListener("click", async () => {
  await table.need([...table.about.keys()]);
  save(new Blob([csv(table, inView(table, state, ...axes, window_))], { type: "text/csv" }), `${stem}.view.csv`);
});
document.getElementById("save-picked").addEventListener("click", () =>
  save(new Blob([csv(table, readout.rows)], { type: "text/csv" }), `${stem}.picked.csv`));
let resized = null;
new ResizeObserver(() => {
  clearTimeout(resized);
  resized = setTimeout(() => cells && render(), 60);
}).observe(place);
start(true)?.then(() => { document.documentElement.dataset.ready = Math.round(performance.now()); });
if (server) server.follow(grown, (text) => { document.getElementById("lost").textContent = text; });
