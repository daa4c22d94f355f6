"use strict";
// Reads figures out, zooms them and saves them. Without it the page is the same, still.
// The numbers are the CSV beside each figure; a zoom moves every coordinate of the marks, as all of them are linear in px.
(() => {
  const NS = "http://www.w3.org/2000/svg";
  const make = (tag, attributes, parent) => {
    const e = document.createElementNS(NS, tag);
    for (const k in attributes) e.setAttribute(k, attributes[k]);
    if (parent) parent.append(e);
    return e;
  };
  const html = (tag, name, parent, text) => {
    const e = document.createElement(tag);
    if (name) e.className = name;
    if (text) e.textContent = text;
    parent.append(e);
    return e;
  };

  // Numbers as the page writes them: four digits, or as many as the sd knows.
  const show = (v, unit, sd) => {
    let text = "0";
    const power = v === 0 ? 0 : Math.floor(Math.log10(Math.max(Math.abs(v), sd > 0 ? sd : 0)));
    if (power < -4 || power > 5) {
      text = v.toExponential(3).replace("e", "\u00a0×\u00a010^").replace("+", "");
      if (sd > 0) text += " ± " + sd.toExponential(1).replace("e", "\u00a0×\u00a010^").replace("+", "");
    } else if (sd > 0) {
      const places = Math.min(12, Math.max(0, 1 - Math.floor(Math.log10(sd))));
      text = v.toFixed(places) + " ± " + sd.toFixed(places);
    } else if (v !== 0) text = String(+v.toFixed(Math.max(0, 3 - power)));
    return text.replace(/-/g, "\u2212") + (unit ? "\u00a0" + unit : "");
  };

  const parse = (text) => {
    const rows = [];
    let row = [], cell = "", inside = false;
    for (let i = 0; i < text.length; i++) {
      const c = text[i];
      if (inside) {
        if (c !== '"') cell += c;
        else if (text[i + 1] === '"') { cell += c; i++; }
        else inside = false;
      } else if (c === '"') inside = true;
      else if (c === ",") { row.push(cell); cell = ""; }
      else if (c === "\n") { row.push(cell); rows.push(row); row = []; cell = ""; }
      else cell += c;
    }
    return rows;
  };

  // The figure as a file of its own: light colours, and the legend that the page shows above it.
  const style = document.styleSheets[0].cssRules[0].style;
  const standalone = (svg) => {
    const frame = svg.match(/viewBox="0 0 ([\d.]+)/), export_ = svg.match(/data-export="([\d.]+)"/);
    const w = +frame[1] + 16, h = +export_[1] + 8;
    const body = svg.slice(svg.indexOf(">") + 1).replace('class="alone" display="none"', 'class="alone"')
      .replace(/var\((--[a-z0-9-]+)\)/g, (_, name) => style.getPropertyValue(name).trim());
    const text = `<svg xmlns="${NS}" width="${w}" height="${h}" viewBox="-8 -4 ${w} ${h}" font-family="sans-serif"><rect x="-8" y="-4" width="100%" height="100%" fill="#ffffff"/>${body}`;
    return { text, w, h };
  };
  const save = (blob, name) => {
    const a = document.createElement("a");
    a.href = URL.createObjectURL(blob);
    a.download = name;
    a.click();
    setTimeout(() => URL.revokeObjectURL(a.href), 1000);
  };
  const savePng = ({ text, w, h }, name) => {
    const image = new Image();
    image.onload = () => {
      const canvas = document.createElement("canvas");
      canvas.width = 3 * w;
      canvas.height = 3 * h;
      canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height);
      canvas.toBlob((blob) => save(blob, name), "image/png");
    };
    image.src = "data:image/svg+xml;charset=utf-8," + encodeURIComponent(text);
  };

  class Panel {
    constructor(box) {
      this.box = box;
      const svg = this.svg = box.querySelector("svg");
      // A copy of all that is drawn and its numbers, as they came.
      this.source = svg.outerHTML;
      this.csv = box.querySelector(".numbers").textContent;
      [this.left, this.right, this.top, this.bottom] = svg.dataset.frame.split(" ").map(Number);
      this.x = JSON.parse(svg.dataset.x);
      this.y = JSON.parse(svg.dataset.y);
      this.home = [...this.x.range, ...this.y.range];
      this.range = [...this.home];
      this.hidden = new Set();
      this.readNumbers();
      this.coordinates = [...svg.querySelectorAll(".marks polyline, .marks polygon, .marks circle, .marks rect")].map((e) => ({
        e,
        points: e.points ? [...e.points].map((p) => [p.x, p.y]) : null,
        at: ["cx", "cy", "x", "y", "width", "height"].map((k) => +e.getAttribute(k)),
      }));
      // Its title would cover the read-out; its name stays.
      svg.querySelector("title").remove();
      this.build();
    }

    readNumbers() {
      const [head, ...rows] = parse(this.csv);
      const column = (name) => head.indexOf(name);
      const at = { label: column("label"), x: column(this.x.name), y: column(this.y.name), xs: column(this.x.sd), ys: column(this.y.sd) };
      const number = (row, k) => (k < 0 || row[k] === "" ? undefined : +row[k]);
      const place = (axis, v) => (axis.log ? Math.log10(v * axis.factor) : v * axis.factor);
      const keys = {};
      for (const g of this.svg.querySelectorAll(".marks g")) keys[g.dataset.name] = g;
      this.data = rows.map((row) => {
        const d = { name: row[0], label: at.label < 0 ? "" : row[at.label], group: keys[row[0]],
          x: number(row, at.x), y: number(row, at.y), xs: number(row, at.xs), ys: number(row, at.ys) };
        d.px = place(this.x, d.x);
        d.py = place(this.y, d.y);
        d.line = /^(before|after|series)/.test(d.group.dataset.key);
        return d;
      });
      this.lines = new Map();
      for (const d of this.data) {
        if (!d.line) continue;
        if (!this.lines.has(d.name)) this.lines.set(d.name, []);
        this.lines.get(d.name).push(d);
      }
      for (const line of this.lines.values()) line.sort((a, b) => a.px - b.px);
      this.order = [...this.data].sort((a, b) => a.px - b.px);
    }

    build() {
      const view = this.view = document.createElement("div");
      view.className = "view";
      view.tabIndex = 0;
      view.setAttribute("role", "group");
      view.setAttribute("aria-label", this.svg.getAttribute("aria-label") + " Left and right read the values; plus, minus and shift with the arrows zoom and move, 0 shows all.");
      this.box.prepend(view);
      view.append(this.svg);
      this.cursor = make("g", { class: "cursor", "pointer-events": "none" }, this.svg);
      this.select = make("rect", { fill: "var(--after)", "fill-opacity": 0.12, visibility: "hidden" }, this.svg);
      this.tip = html("div", "tip", view);
      this.tip.hidden = true;
      this.live = html("div", "sr", view);
      this.live.setAttribute("role", "status");
      const tools = html("div", "tools", this.box);
      const tool = (text, title, act) => {
        const b = html("button", "", tools, text);
        b.type = "button";
        b.title = title;
        b.setAttribute("aria-label", title);
        b.addEventListener("click", act);
        return b;
      };
      const file = this.box.dataset.file;
      tool("CSV", "Save the numbers of this figure", () => save(new Blob([this.csv], { type: "text/csv" }), file + ".csv"));
      tool("SVG", "Save this figure as SVG", () => save(new Blob([standalone(this.source).text], { type: "image/svg+xml" }), file + ".svg"));
      tool("PNG", "Save this figure as PNG", () => savePng(standalone(this.source), file + ".png"));
      this.reset = tool("Show all", "Show all of this figure again", () => this.show(this.home));
      this.reset.className = "reset";
      this.reset.disabled = true;
      this.listen();
    }

    listen() {
      const { view } = this;
      let from = null, last = null, pinch = null;
      view.addEventListener("pointermove", (e) => {
        if (pinch) return;
        const at = this.point(e);
        if (from && e.shiftKey) {
          this.pan(last[0] - at[0], last[1] - at[1]);
        } else if (from) {
          const [x, y] = [Math.min(from[0], at[0]), Math.min(from[1], at[1])];
          const box = { x, y, width: Math.abs(at[0] - from[0]), height: Math.abs(at[1] - from[1]), visibility: "visible" };
          for (const k in box) this.select.setAttribute(k, box[k]);
          this.clear();
        } else this.hover(at);
        last = at;
      });
      view.addEventListener("pointerdown", (e) => {
        const at = this.point(e);
        if (e.pointerType === "touch") this.hover(at);
        if (e.button !== 0 || e.pointerType === "touch" || !this.inside(at)) return;
        from = last = at;
        view.setPointerCapture(e.pointerId);
      });
      const end = (e) => {
        if (!from) return;
        const at = this.point(e), start = from;
        from = null;
        this.select.setAttribute("visibility", "hidden");
        if (e.type !== "pointerup" || e.shiftKey || Math.hypot(at[0] - start[0], at[1] - start[1]) < 8) return;
        const a = this.value(start), b = this.value(at);
        const pair = (k) => (this.home[2 * k] < this.home[2 * k + 1] ? [Math.min(a[k], b[k]), Math.max(a[k], b[k])] : [Math.max(a[k], b[k]), Math.min(a[k], b[k])]);
        // A flat or narrow box zooms the one axis it names.
        const wide = Math.abs(at[0] - start[0]) > 8, tall = Math.abs(at[1] - start[1]) > 8;
        this.show([...(wide ? pair(0) : this.range.slice(0, 2)), ...(tall ? pair(1) : this.range.slice(2))]);
      };
      view.addEventListener("pointerup", end);
      view.addEventListener("pointercancel", end);
      // What a finger asked for stays when it is lifted.
      view.addEventListener("pointerleave", (e) => e.pointerType !== "touch" && this.clear());
      view.addEventListener("blur", () => this.clear());
      view.addEventListener("dblclick", () => this.show(this.home));
      // A page must scroll on past its figures: the wheel zooms one that was chosen by a click, or with Ctrl.
      view.addEventListener("wheel", (e) => {
        if (!e.ctrlKey && document.activeElement !== view) return;
        e.preventDefault();
        this.zoom(e.deltaY < 0 ? 0.8 : 1.25, this.value(this.point(e)));
      }, { passive: false });
      // Two fingers zoom and move the figure; one scrolls the page past it.
      const fingers = (e) => {
        if (e.touches.length !== 2) { pinch = null; return; }
        e.preventDefault();
        const [a, b] = [...e.touches].map((t) => this.point(t)), before = pinch;
        pinch = { at: [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2], apart: Math.max(Math.hypot(a[0] - b[0], a[1] - b[1]), 1) };
        if (!before) return;
        this.pan(before.at[0] - pinch.at[0], before.at[1] - pinch.at[1]);
        this.zoom(before.apart / pinch.apart, this.value(pinch.at));
      };
      for (const type of ["touchstart", "touchmove", "touchend", "touchcancel"]) view.addEventListener(type, fingers, { passive: false });
      view.addEventListener("keydown", (e) => this.key(e));
    }

    key(e) {
      if (e.target !== this.view || e.ctrlKey || e.altKey || e.metaKey) return;
      const r = this.range, middle = [(r[0] + r[1]) / 2, (r[2] + r[3]) / 2];
      const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[e.key];
      if (e.key === "+" || e.key === "=") this.zoom(0.8, middle);
      else if (e.key === "-") this.zoom(1.25, middle);
      else if (e.key === "0" || e.key === "Escape") { this.show(this.home); this.clear(); }
      else if (step && e.shiftKey) this.pan(step[0] * 20, step[1] * 20);
      else if (step && step[0]) this.walk(step[0]);
      else return;
      e.preventDefault();
    }

    // From data to px of the drawing and back.
    px(d) {
      const [a, b, c, e] = this.range;
      return [this.left + ((d.px - a) / (b - a)) * (this.right - this.left), this.bottom - ((d.py - c) / (e - c)) * (this.bottom - this.top)];
    }
    value([x, y]) {
      const [a, b, c, e] = this.range;
      return [a + ((x - this.left) / (this.right - this.left)) * (b - a), c + ((this.bottom - y) / (this.bottom - this.top)) * (e - c)];
    }
    point(e) {
      const m = this.svg.getScreenCTM();
      return [(e.clientX - m.e) / m.a, (e.clientY - m.f) / m.d];
    }
    inside([x, y]) {
      return x > this.left - 8 && x < this.right + 8 && y > this.top - 8 && y < this.bottom + 8;
    }
    seen(d) {
      return !this.hidden.has(d.group.dataset.key) && this.inside(this.px(d));
    }

    zoom(factor, [x, y]) {
      const [a, b, c, d] = this.range;
      this.show([x + (a - x) * factor, x + (b - x) * factor, y + (c - y) * factor, y + (d - y) * factor]);
    }
    pan(dx, dy) {
      const [a, b, c, d] = this.range;
      const x = (dx / (this.right - this.left)) * (b - a), y = (-dy / (this.bottom - this.top)) * (d - c);
      this.show([a + x, b + x, c + y, d + y]);
    }

    // Never beyond what was drawn first, nor nearer than a thousandth of it.
    show(range) {
      const next = [];
      for (const k of [0, 2]) {
        const [low, high] = [Math.min(this.home[k], this.home[k + 1]), Math.max(this.home[k], this.home[k + 1])];
        let size = Math.min(Math.max(Math.abs(range[k + 1] - range[k]), (high - low) / 1000), high - low);
        let from = (range[k] + range[k + 1]) / 2 - size / 2;
        from = Math.min(Math.max(from, low), high - size);
        next.push(...(this.home[k] < this.home[k + 1] ? [from, from + size] : [from + size, from]));
      }
      this.range = next;
      const away = next.some((v, k) => Math.abs(v - this.home[k]) > 1e-9 * Math.abs(this.home[k & 2 ? 3 : 1] - this.home[k & 2 ? 2 : 0]));
      this.reset.disabled = !away;
      this.move();
      this.ticks(away);
      for (const e of this.svg.querySelectorAll(".over > :not(.entry)")) e.setAttribute("visibility", away ? "hidden" : "visible");
      this.clear();
    }

    // The marks, each coordinate where the range now has it.
    move() {
      const [a, b, c, d] = this.range, [a0, b0, c0, d0] = this.home;
      const w = this.right - this.left, h = this.bottom - this.top;
      const sx = (b0 - a0) / (b - a), ox = this.left - this.left * sx + ((a0 - a) / (b - a)) * w;
      const sy = (d0 - c0) / (d - c), oy = this.bottom - this.bottom * sy - ((c0 - c) / (d - c)) * h;
      const x = (v) => ox + sx * v, y = (v) => oy + sy * v;
      for (const { e, points, at } of this.coordinates) {
        if (points) e.setAttribute("points", points.map((p) => x(p[0]).toFixed(2) + "," + y(p[1]).toFixed(2)).join(" "));
        else if (e.tagName === "circle") {
          e.setAttribute("cx", x(at[0]));
          e.setAttribute("cy", y(at[1]));
        } else {
          e.setAttribute("x", x(at[2]));
          e.setAttribute("width", at[4] * sx);
          e.setAttribute("y", y(at[3] + at[5] / 2) - at[5] / 2);
        }
      }
    }

    // Round ticks for what is shown; those that came with the figure when all of it is.
    ticks(away) {
      const axes = this.svg.querySelector(".axes");
      this.given ??= axes.innerHTML;
      if (!away) {
        axes.innerHTML = this.given;
        return;
      }
      axes.textContent = "";
      const round = (low, high, count) => {
        const raw = (high - low) / count, power = 10 ** Math.floor(Math.log10(raw));
        const lead = raw / power, step = power * (lead < 1.42 ? 1 : lead < 3.17 ? 2 : lead < 7.08 ? 5 : 10);
        const out = [];
        for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) out.push([k * step, (k * step).toFixed(Math.max(0, -Math.floor(Math.log10(step) + 1e-9)))]);
        return out;
      };
      const on = (axis, low, high, count) => {
        if (!axis.log) return round(low, high, count);
        const values = round(10 ** low, 10 ** high, count).filter((t) => t[0] > 0);
        return values.map(([v, text]) => [Math.log10(v), text]);
      };
      const label = (x, y, text, anchor) => {
        make("text", { x, y, dy: "0.35em", "text-anchor": anchor, "font-size": 13, fill: "var(--muted)" }, axes).textContent = text.replace("-", "\u2212");
      };
      const [a, b, c, d] = this.range;
      if (this.y.ticks) {
        for (const [v, text] of on(this.y, c, d, 5)) {
          const y = this.px({ px: a, py: v })[1];
          make("line", { x1: this.left, x2: this.right, y1: y, y2: y, stroke: "var(--hair)" }, axes);
          label(this.left - 7, y, text, "end");
        }
      }
      for (const [v, text] of on(this.x, a, b, Math.max(3, Math.round((this.right - this.left) / 80)))) {
        const x = this.px({ px: v, py: c })[0];
        make("line", { x1: x, x2: x, y1: this.bottom, y2: this.bottom + 4, stroke: "var(--rule)" }, axes);
        label(x, this.bottom + 15, text, "middle");
      }
    }

    // What stands at or near a place: a measured point within reach, and every curve at that x.
    hover(at) {
      if (!this.inside(at)) return this.clear();
      const far = (d) => { const p = this.px(d); return Math.hypot(p[0] - at[0], p[1] - at[1]); };
      const seen = this.data.filter((d) => this.seen(d));
      let point = null, best = 22;
      for (const d of seen) {
        if (!d.line && far(d) < best) [point, best] = [d, far(d)];
      }
      const x = point ? point.px : this.value(at)[0];
      this.read(point, x, at);
    }
    read(point, x, at) {
      const rows = [];
      if (point) rows.push(point);
      for (const line of this.lines.values()) {
        if (this.hidden.has(line[0].group.dataset.key)) continue;
        const nearest = line.reduce((a, b) => (Math.abs(b.px - x) < Math.abs(a.px - x) ? b : a));
        // Not beyond the ends of a curve.
        const reach = Math.abs(this.range[1] - this.range[0]) / 25;
        if (line[0].px - reach <= x && x <= line[line.length - 1].px + reach) rows.push(nearest);
      }
      if (!rows.length) {
        if (!this.data.some((d) => d.line)) this.clear();
        return;
      }
      this.tell(rows, at);
    }
    words(d) {
      const bar = this.y.ticks === 0;
      const axis = bar ? this.x : this.y, v = bar ? d.x : d.y, sd = bar ? d.xs : d.ys;
      return `${d.name}${d.label ? " (" + d.label + ")" : ""}: ${show(v * axis.factor, axis.unit, sd * axis.factor)}`;
    }
    heading(d) {
      if (this.y.ticks === 0) return "";
      const name = this.x.title.split(", ")[0];
      return name + " " + show(d.x * this.x.factor, this.x.unit, d.xs * this.x.factor);
    }
    tell(rows, at) {
      this.cursor.textContent = "";
      const [x] = this.px(rows[0]);
      if (this.y.ticks) make("line", { x1: x, x2: x, y1: this.top, y2: this.bottom, stroke: "var(--muted)", "stroke-width": 1 }, this.cursor);
      for (const d of rows) {
        const [cx, cy] = this.px(d);
        if (this.inside([cx, cy])) make("circle", { cx, cy, r: 5, fill: "none", stroke: "var(--ink)", "stroke-width": 1.5 }, this.cursor);
      }
      const heading = this.heading(rows[0]);
      this.tip.textContent = "";
      if (heading) html("b", "", this.tip, heading);
      for (const d of rows) html("div", "", this.tip, this.words(d));
      this.tip.hidden = false;
      const scale = this.view.clientWidth / this.svg.viewBox.baseVal.width;
      const place = (at ? at[0] : x) * scale, width = this.tip.offsetWidth;
      const free = Math.max(0, this.view.clientWidth - width);
      this.tip.style.left = Math.min(place + 14 + width > this.view.clientWidth ? Math.max(0, place - width - 14) : place + 14, free) + "px";
      this.tip.style.top = (at ? at[1] : this.px(rows[0])[1]) * scale + 14 + "px";
      return [heading, ...rows.map((d) => this.words(d))].filter(Boolean).join("; ");
    }
    walk(step) {
      const order = this.order.filter((d) => this.seen(d));
      if (!order.length) return;
      const now = order.indexOf(this.now);
      const k = now < 0 ? (step > 0 ? 0 : order.length - 1) : Math.min(Math.max(now + step, 0), order.length - 1);
      this.now = order[k];
      this.live.textContent = this.tell([this.now]);
    }
    clear() {
      this.cursor.textContent = "";
      this.tip.hidden = true;
    }
    toggle(key, hide) {
      if (hide) this.hidden.add(key);
      else this.hidden.delete(key);
      for (const g of this.svg.querySelectorAll(".marks g")) if (g.dataset.key === key) g.setAttribute("visibility", hide ? "hidden" : "visible");
      this.clear();
    }
  }

  for (const figure of document.querySelectorAll("figure")) {
    const panels = [...figure.querySelectorAll(".panel")].map((box) => new Panel(box));
    // A click on an entry of the legend, or on a line's own label, hides what it names.
    for (const entry of figure.querySelectorAll(".legend .key, .entry")) {
      entry.setAttribute("role", "button");
      entry.setAttribute("tabindex", "0");
      entry.setAttribute("aria-pressed", "true");
      const toggle = (e) => {
        const hide = entry.getAttribute("aria-pressed") === "true";
        entry.setAttribute("aria-pressed", String(!hide));
        for (const p of panels) p.toggle(entry.dataset.key, hide);
        e.preventDefault();
        e.stopPropagation();
      };
      entry.addEventListener("pointerdown", (e) => e.stopPropagation());
      entry.addEventListener("click", toggle);
      entry.addEventListener("keydown", (e) => (e.key === "Enter" || e.key === " ") && toggle(e));
    }
  }
})();
