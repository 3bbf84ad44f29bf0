(() => {
  "use strict";
  const map = document.querySelector("svg.map");
  const card = document.querySelector(".card");
  const [bar, length, cursor] = [".bar", ".length", ".cursor"].map((name) => document.querySelector(`.status ${name}`));
  const hint = card.firstElementChild;
  const index = (elements, key) => new Map([...elements].map((each) => [key(each), each]));
  const features = index(map.querySelectorAll(".feature"), (each) => each.id);
  const rows = index(document.querySelectorAll("tr[data-feature]"), (row) => row.dataset.feature);
  const facts = new Map();
  let pinned = null;

  /* The card takes the place of the browser's own tooltips. */
  for (const [key, feature] of features) {
    const title = feature.querySelector("title");
    facts.set(key, title.textContent.split("\n"));
    feature.setAttribute("aria-label", title.textContent.replaceAll("\n", ", "));
    title.remove();
  }

  const made = (tag, text) => Object.assign(document.createElement(tag), { textContent: text });

  const show = (key) => {
    for (const group of [features, rows]) group.forEach((each, own) => each.classList.toggle("lit", own === key));
    for (const beam of map.querySelectorAll(".beam")) beam.classList.toggle("lit", `station-${beam.dataset.sweep}` === key);
    if (!facts.has(key)) return card.replaceChildren(hint);
    const [title, ...lines] = facts.get(key);
    const list = document.createElement("dl");
    for (const line of lines) {
      const colon = line.indexOf(": ");
      list.append(made("dt", line.slice(0, colon)), made("dd", line.slice(colon + 2)));
    }
    return card.replaceChildren(made("h3", title), list);
  };

  for (const [key, each] of [...features, ...rows]) {
    each.addEventListener("pointerenter", () => show(key));
    each.addEventListener("pointerleave", () => show(pinned));
    each.addEventListener("focusin", () => show(key));
    each.addEventListener("click", () => show((pinned = pinned === key ? null : key)));
  }

  /* Zoom and pan: what is seen is the view box. */
  const scale = Number(map.dataset.scale) / 1000;
  const [originX, originY] = map.dataset.origin.split(" ").map(Number);
  const [, , fullWidth, fullHeight] = map.getAttribute("viewBox").split(" ").map(Number);
  const view = { x: 0, y: 0, width: fullWidth };
  const place = (client) => new DOMPoint(client.x, client.y).matrixTransform(map.getScreenCTM().inverse());
  const clamp = (value, most) => Math.min(Math.max(value, 0), most);

  const draw = () => {
    const height = (view.width * fullHeight) / fullWidth;
    view.x = clamp(view.x, fullWidth - view.width);
    view.y = clamp(view.y, fullHeight - height);
    map.setAttribute("viewBox", `${view.x} ${view.y} ${view.width} ${height}`);
    map.classList.toggle("zoomed", view.width < fullWidth);
    const pixel = 1 / map.getScreenCTM().a;
    map.style.setProperty("--px", pixel);
    const metres = 120 * pixel * scale;
    const decade = 10 ** Math.floor(Math.log10(metres));
    const round = [5, 2, 1].find((digit) => digit * decade <= metres) * decade;
    bar.style.width = `${round / (pixel * scale)}px`;
    length.textContent = round >= 1 ? `${round} m` : round >= 0.01 ? `${Math.round(round * 100)} cm` : `${+(round * 1000).toPrecision(1)} mm`;
  };

  const zoom = (factor, at) => {
    const width = Math.min(Math.max(view.width / factor, fullWidth / 1000), fullWidth);
    const share = width / view.width;
    view.x = at.x - (at.x - view.x) * share;
    view.y = at.y - (at.y - view.y) * share;
    view.width = width;
    draw();
  };
  const middle = () => ({ x: view.x + view.width / 2, y: view.y + (view.width * fullHeight) / fullWidth / 2 });
  const shift = (x, y) => { view.x += x * view.width; view.y += y * view.width; draw(); };
  const actions = { in: () => zoom(1.5, middle()), out: () => zoom(1 / 1.5, middle()), all: () => zoom(0, middle()) };
  const keys = {
    "+": actions.in, "=": actions.in, "-": actions.out, 0: actions.all,
    ArrowLeft: () => shift(-0.1, 0), ArrowRight: () => shift(0.1, 0), ArrowUp: () => shift(0, -0.1), ArrowDown: () => shift(0, 0.1),
  };

  for (const button of document.querySelectorAll("[data-zoom]")) button.addEventListener("click", actions[button.dataset.zoom]);
  map.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || !keys[event.key]) return;
    event.preventDefault();
    keys[event.key]();
  });
  map.addEventListener("wheel", (event) => {
    /* At full extent, zooming out is scrolling on. */
    if (event.deltaY > 0 && view.width >= fullWidth) return;
    event.preventDefault();
    zoom(Math.exp(-event.deltaY / 400), place(event));
  }, { passive: false });

  const fingers = new Map();
  const grip = () => {
    const [first, last] = [[...fingers.values()][0], [...fingers.values()].at(-1)];
    return { x: (first.x + last.x) / 2, y: (first.y + last.y) / 2, span: Math.hypot(first.x - last.x, first.y - last.y) };
  };
  map.addEventListener("pointerdown", (event) => fingers.set(event.pointerId, { x: event.clientX, y: event.clientY }));
  map.addEventListener("pointermove", (event) => {
    const at = place(event);
    cursor.textContent = `x ${((at.x - originX) * scale).toFixed(3)} m, y ${((originY - at.y) * scale).toFixed(3)} m`;
    const finger = fingers.get(event.pointerId);
    if (!finger) return;
    /* A click that trembles is still a click. */
    if (!map.classList.contains("moving") && Math.hypot(event.clientX - finger.x, event.clientY - finger.y) < 4) return;
    map.classList.add("moving");
    map.setPointerCapture(event.pointerId);
    const before = grip();
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    const after = grip();
    const [from, to] = [place(before), place(after)];
    view.x += from.x - to.x;
    view.y += from.y - to.y;
    if (before.span && after.span) zoom(after.span / before.span, from);
    else draw();
  });
  for (const name of ["pointerup", "pointercancel", "pointerleave"]) {
    map.addEventListener(name, (event) => {
      fingers.delete(event.pointerId);
      if (!fingers.size) map.classList.remove("moving");
    });
  }

  for (const each of document.querySelectorAll(".tools, .status, .card")) each.hidden = false;
  new ResizeObserver(draw).observe(map);
  draw();
})();
