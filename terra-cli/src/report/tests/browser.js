// Drives the first figure of a page as a reader would, and leaves what it saw for the test that put it there.
const seen = { errors: [], saved: {} };
addEventListener("error", (e) => seen.errors.push(e.message));
URL.createObjectURL = (blob) => { URL.last = blob; return "blob:none"; };
URL.revokeObjectURL = () => {};
HTMLAnchorElement.prototype.click = function () {
  const blob = URL.last, name = this.download;
  (blob.type === "image/png" ? Promise.resolve("PNG of " + (blob.size > 1000)) : blob.text()).then((text) => { seen.saved[name] = text; });
};
const figure = document.querySelector("figure"), panel = figure.querySelector(".panel"), view = panel.querySelector(".view");
const key = (key, shiftKey = false) => view.dispatchEvent(new KeyboardEvent("keydown", { key, shiftKey, bubbles: true, cancelable: true }));
const ticks = () => [...panel.querySelectorAll(".axes text")].map((t) => t.textContent);
const points = () => [...panel.querySelectorAll(".marks polyline, .marks polygon")].flatMap((e) => [...e.points].flatMap((p) => [p.x, p.y]));
const at = (type, x, y, more) => {
  const box = view.querySelector("svg").getBoundingClientRect();
  view.dispatchEvent(new PointerEvent(type, { clientX: box.x + x * box.width, clientY: box.y + y * box.height, pointerId: 1, bubbles: true, ...more }));
};
view.setPointerCapture = () => {};
const home = { ticks: ticks(), points: points() };
const far = () => Math.max(...points().map((v, k) => Math.abs(v - home.points[k])));
view.focus();
seen.name = view.getAttribute("aria-label");
key("ArrowRight");
seen.first = view.querySelector("[role=status]").textContent;
key("ArrowRight");
seen.second = view.querySelector("[role=status]").textContent;
at("pointermove", 0.5, 0.5);
seen.hover = view.querySelector(".tip").hidden ? "" : view.querySelector(".tip").textContent;
key("+");
seen.zoomed = far();
seen.zoomedTicks = ticks().join() !== home.ticks.join();
key("ArrowRight", true);
seen.panned = far();
key("0");
seen.back = far() < 0.011 && ticks().join() === home.ticks.join();
at("pointerdown", 0.3, 0.3, { button: 0 });
at("pointermove", 0.6, 0.6);
at("pointerup", 0.6, 0.6);
seen.boxed = far();
view.dispatchEvent(new MouseEvent("dblclick", { bubbles: true }));
seen.backAgain = far() < 0.011;
// Two fingers a fifth of the figure apart, then two fifths; then both to the left; then one alone, which scrolls the page.
const touch = (type, ...xs) => {
  const box = view.querySelector("svg").getBoundingClientRect();
  const touches = xs.map((x, identifier) => new Touch({ identifier, target: view, clientX: box.x + x * box.width, clientY: box.y + box.height / 2 }));
  return !view.dispatchEvent(new TouchEvent(type, { touches, bubbles: true, cancelable: true }));
};
touch("touchstart", 0.4, 0.6);
seen.pinchKept = touch("touchmove", 0.3, 0.7);
seen.pinched = far();
touch("touchmove", 0.2, 0.6);
seen.pinchMoved = far();
seen.pinchTicks = ticks().join() !== home.ticks.join();
seen.oneScrolls = !touch("touchmove", 0.5) && far() === seen.pinchMoved;
touch("touchend");
key("0");
const entry = figure.querySelector(".legend .key, .entry");
entry.dispatchEvent(new MouseEvent("click", { bubbles: true }));
seen.hidden = [...panel.querySelectorAll(".marks g")].filter((g) => g.getAttribute("visibility") === "hidden").map((g) => g.dataset.name);
const buttons = [...panel.querySelectorAll(".tools button:not(.reset)")];
for (const button of buttons) button.click();
// Files are made beside the page, in real time. The browser writes the page down at its load event, which waits for
// images: one follows the other until all files are there, or half a minute has passed.
const until = performance.now() + 30000;
const wait = () => {
  if (Object.keys(seen.saved).length < buttons.length && performance.now() < until) {
    const image = new Image();
    image.onload = image.onerror = () => { image.remove(); wait(); };
    document.body.append(image);
    image.src = "data:image/svg+xml," + encodeURIComponent(`<svg xmlns="http://www.w3.org/2000/svg" id="n${performance.now()}"/>`);
    return;
  }
  const result = document.createElement("pre");
  result.id = "seen";
  result.textContent = JSON.stringify(seen);
  document.body.append(result);
};
wait();
