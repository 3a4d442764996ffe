// The page's half of lumivox.widget.View: a picture that is turned by dragging (or arrow keys), zoomed by the wheel (or + and -)
// and put back by a double click (or Home), the presets, and the opacity curve over the histogram, whose knots are dragged; a
// double click there adds one or takes one away. Where the browser has a graphics card, the page renders the picture itself, by the
// program and the scan that the kernel sends; else it shows what the kernel renders.

const CURVE_HEIGHT = 90;
const EDGE = 6;

function srgb(c) {
  const x = Math.min(Math.max(c, 0), 1);
  return Math.round(255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055));
}

// As the renderer eases between knots.
function eased(ease, t) {
  return ease === "in-out" ? (t * t) / (t * t + (1 - t) * (1 - t)) : t;
}

// The program for pages, once for all views of it: what binds WebAssembly, what people call, and the WebAssembly.
let program;
function load([binding, calls, wasm]) {
  program ??= (async () => {
    const script = (text) => URL.createObjectURL(new Blob([text], { type: "text/javascript" }));
    const text = (bytes) => new TextDecoder().decode(bytes);
    const lumivox = await import(script(text(calls).replace("./lumivox_wasm.js", script(text(binding)))));
    await lumivox.load(wasm);
    return lumivox;
  })();
  return program;
}

const ARRAYS = { uint8: Uint8Array, uint16: Uint16Array, float32: Float32Array };

function scansOf(lumivox, told, buffers) {
  // Typed arrays want their bytes at even places.
  const next = (kind) => {
    const bytes = buffers.shift();
    return new kind(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength));
  };
  return told.map(({ kind, description, labels }) => {
    const scan = new lumivox.Scan(next(ARRAYS[kind]), description);
    return labels ? scan.setLabels(next(Uint8Array), labels) : scan;
  });
}

// Whether this page is to render itself.
async function rendersHere(when) {
  if (when === "never" || !globalThis.isSecureContext) return false;
  let adapter;
  // A browser that has just begun finds no graphics card for a moment.
  for (let tries = 3; !adapter && navigator.gpu && tries > 0; tries -= 1) {
    adapter = await navigator.gpu.requestAdapter({ powerPreference: "high-performance" });
    if (!adapter) await new Promise((done) => setTimeout(done, 400));
  }
  if (!adapter) return false;
  const { vendor = "", architecture = "", description = "", isFallbackAdapter } = adapter.info ?? {};
  const isSoftware = isFallbackAdapter || /swiftshader|llvmpipe|basic render/i.test(`${vendor} ${architecture} ${description}`);
  return when === "always" || !isSoftware;
}

// Renders on a canvas where this page can. `count` hears how many samples there are. Returns what ends it.
function renderHere(model, canvas, count) {
  let view, scans = [], isNew = false, isSent = false, isOver = false, last = Promise.resolve();
  const turn = () => {
    isSent = false;
    const [azimuth, elevation, zoom] = ["azimuth", "elevation", "zoom"].map((name) => model.get(name));
    view?.look({ azimuth, elevation: Math.min(90, Math.max(-90, elevation)), zoom: Math.min(20, Math.max(0.1, zoom)) });
  };
  const progress = ({ detail }) => {
    if (detail.isShown) canvas.style.visibility = "visible";
    count(detail.samples);
    if (!detail.rests || isSent) return;
    // What is kept of a notebook without a kernel.
    isSent = true;
    view.picture()
      .then((picture) => picture.arrayBuffer())
      .then((bytes) => isSent && !isOver && model.send({ kind: "picture", samples: detail.samples }, undefined, [bytes]));
  };
  const take = async ({ kind, scans: told, document }, buffers) => {
    if (isOver) return;
    if (kind === "program") load(buffers);
    const lumivox = await program;
    if (kind === "scans") {
      scans.forEach((scan) => scan.free());
      scans = scansOf(lumivox, told, [...buffers]);
      isNew = true;
    }
    if (kind !== "scene" || isOver) return;
    if (!view) {
      view = await lumivox.View.create(canvas, { samples: model.get("target"), controls: false });
      if (isOver) return view.destroy();
      view.addEventListener("progress", progress);
      view.addEventListener("error", ({ error }) => fail(error));
    }
    if (isNew) view.show(scans, document);
    else view.scene = document;
    isNew = false;
    // It may have been turned since.
    turn();
  };
  const hear = (message, buffers) => {
    last = last.then(() => take(message, buffers)).catch(fail);
  };
  const names = ["azimuth", "elevation", "zoom"];
  const end = () => {
    if (isOver) return;
    isOver = true;
    model.off("msg:custom", hear);
    for (const name of names) model.off(`change:${name}`, turn);
    scans.forEach((scan) => scan.free());
    view?.destroy();
    canvas.remove();
  };
  const fail = (error) => {
    if (isOver) return;
    console.error(error);
    end();
    model.send({ kind: "pictures" });
    count(undefined);
  };
  model.on("msg:custom", hear);
  for (const name of names) model.on(`change:${name}`, turn);
  rendersHere(model.get("page_renders")).catch(() => false).then((does) => {
    if (isOver) return;
    if (does) return model.send({ kind: "begin" });
    end();
    model.send({ kind: "pictures" });
  });
  return end;
}

function render({ model, el }) {
  const width = model.get("width"), height = model.get("height");
  const make = (tag, style) => {
    const made = document.createElement(tag);
    made.style.cssText = style;
    return made;
  };
  const root = make(
    "div",
    `width:${width}px;max-width:100%;font:12px system-ui,sans-serif;color:#c8ced6;background:#14171c;` +
      "user-select:none;border-radius:4px;overflow:hidden",
  );
  const picture = make("img", `width:100%;aspect-ratio:${width}/${height};display:block;cursor:grab;touch-action:none;outline:none`);
  picture.draggable = false;
  picture.tabIndex = 0;
  picture.alt = "The scan. Drag or press arrow keys to turn it, + and - to zoom, Home to put it back.";
  // What the page renders lies over what the kernel does, which hears the pointer.
  const canvas = make("canvas", "position:absolute;inset:0;width:100%;height:100%;pointer-events:none;visibility:hidden");
  canvas.setAttribute("aria-hidden", "true");
  const frame = make("div", "position:relative");
  frame.append(picture, canvas);
  const bar = make("div", "display:flex;gap:8px;align-items:center;padding:6px 8px");
  const select = make(
    "select",
    "font:inherit;color:inherit;background:#232830;border:1px solid #3a414b;border-radius:3px;padding:2px 4px;color-scheme:dark",
  );
  select.setAttribute("aria-label", "Preset");
  for (const name of model.get("presets")) select.add(new Option(name, name));
  select.style.minWidth = "0";
  // On one line whatever it says: the curve must not move below the pointer.
  const said = make("span", "margin-left:auto;white-space:nowrap;color:#8b95a1;font-variant-numeric:tabular-nums");
  bar.append(select, said);
  const wrong = make("div", "display:none;padding:0 8px 6px;color:#f0a08c");
  wrong.setAttribute("role", "alert");
  const curve = make("canvas", `width:100%;height:${CURVE_HEIGHT}px;display:block;touch-action:none;cursor:crosshair`);
  curve.setAttribute("aria-label", "Opacity by value. Drag knots; double click to add or remove one.");
  const ratio = window.devicePixelRatio || 1;
  curve.width = width * ratio;
  curve.height = CURVE_HEIGHT * ratio;
  root.append(frame, bar, wrong, curve);
  el.append(root);

  let url = null, pointed = "", own;
  const count = () => {
    said.textContent = pointed || `${own ?? model.get("samples")} of ${model.get("target")} samples`;
  };
  const show = () => {
    const png = model.get("png");
    if (!png || !png.byteLength) return;
    const next = URL.createObjectURL(new Blob([png], { type: "image/png" }));
    picture.src = next;
    if (url) URL.revokeObjectURL(url);
    url = next;
    count();
  };
  const tell = () => {
    wrong.textContent = model.get("message");
    wrong.style.display = wrong.textContent ? "block" : "none";
  };

  const turn = (azimuth, elevation) => {
    model.set("azimuth", azimuth);
    model.set("elevation", Math.min(90, Math.max(-90, elevation)));
    model.save_changes();
  };
  const zoomBy = (factor) => {
    model.set("zoom", Math.min(20, Math.max(0.1, model.get("zoom") * factor)));
    model.save_changes();
  };
  const first = [model.get("azimuth"), model.get("elevation"), model.get("zoom")];
  const putBack = () => {
    model.set("zoom", first[2]);
    turn(first[0], first[1]);
  };
  let grabbed = null;
  picture.addEventListener("pointerdown", (e) => {
    picture.setPointerCapture(e.pointerId);
    picture.style.cursor = "grabbing";
    grabbed = [e.clientX, e.clientY, model.get("azimuth"), model.get("elevation")];
  });
  picture.addEventListener("pointermove", (e) => {
    if (!grabbed) return;
    const [x, y, azimuth, elevation] = grabbed;
    const degrees = 180 / picture.clientWidth;
    turn(azimuth - (e.clientX - x) * degrees, elevation + (e.clientY - y) * degrees);
  });
  const letGo = () => {
    grabbed = null;
    picture.style.cursor = "grab";
  };
  picture.addEventListener("pointerup", letGo);
  picture.addEventListener("pointercancel", letGo);
  picture.addEventListener("dblclick", putBack);
  picture.addEventListener("wheel", (e) => {
    e.preventDefault();
    zoomBy(Math.exp(-e.deltaY / 600));
  }, { passive: false });
  picture.addEventListener("keydown", (e) => {
    const steps = { ArrowLeft: [5, 0], ArrowRight: [-5, 0], ArrowUp: [0, -5], ArrowDown: [0, 5] };
    if (steps[e.key]) turn(model.get("azimuth") + steps[e.key][0], model.get("elevation") + steps[e.key][1]);
    else if (e.key === "+" || e.key === "=") zoomBy(1.1);
    else if (e.key === "-") zoomBy(1 / 1.1);
    else if (e.key === "Home") putBack();
    else return;
    // The notebook has its own use for these.
    e.preventDefault();
    e.stopPropagation();
  });
  select.addEventListener("change", () => {
    model.set("preset", select.value);
    model.save_changes();
  });

  // Knots beyond the scan's values are shown, and can be grabbed, at its ends.
  const at = (value) => {
    const [low, high] = model.get("value_range");
    return Math.min(Math.max(((value - low) / (high - low)) * width, 0), width);
  };
  const valueAt = (x) => {
    const [low, high] = model.get("value_range");
    return low + (Math.min(Math.max(x, 0), width) / width) * (high - low);
  };
  const down = (opacity) => EDGE + (1 - opacity) * (CURVE_HEIGHT - 2 * EDGE);
  const opacityAt = (y) => Math.min(1, Math.max(0, 1 - (y - EDGE) / (CURVE_HEIGHT - 2 * EDGE)));
  const number = (value) => (Math.abs(value) >= 10 ? value.toFixed(0) : value.toPrecision(2));
  const words = (value, opacity) => `${number(value)}${model.get("unit") ? ` ${model.get("unit")}` : ""}: ${opacity.toFixed(2)}`;
  let dragged = -1, pointedAt = -1;
  const draw = () => {
    select.value = model.get("preset");
    const g = curve.getContext("2d");
    g.setTransform(ratio, 0, 0, ratio, 0, 0);
    g.clearRect(0, 0, width, CURVE_HEIGHT);
    const bars = model.get("histogram");
    g.fillStyle = "#2a3038";
    bars.forEach((bar, i) => {
      const tall = bar * (CURVE_HEIGHT - EDGE);
      g.fillRect((i * width) / bars.length, CURVE_HEIGHT - tall, width / bars.length - 1, tall);
    });
    const knots = model.get("knots");
    const [low, high] = model.get("value_range");
    g.strokeStyle = "#9fb4c8";
    g.lineWidth = 1.5;
    g.beginPath();
    knots.forEach(([value, opacity, ease], i) => {
      if (i === 0) g.moveTo(0, down(opacity));
      g.lineTo(at(value), down(opacity));
      const next = knots[i + 1];
      if (!next) return g.lineTo(width, down(opacity));
      for (let step = 1; step < 24; step += 1) {
        const t = step / 24, reached = value + (next[0] - value) * t;
        if (reached >= low && reached <= high) g.lineTo(at(reached), down(opacity + (next[1] - opacity) * eased(ease, t)));
      }
    });
    g.stroke();
    const stops = model.get("stops");
    knots.forEach(([value, opacity], i) => {
      const stop = stops.reduce((a, b) => (Math.abs(b[0] - value) < Math.abs(a[0] - value) ? b : a), stops[0]);
      g.fillStyle = stop ? `rgb(${stop[1].map(srgb).join(",")})` : "#fff";
      g.strokeStyle = i === pointedAt || i === dragged ? "#ffffff" : "#9fb4c8";
      g.beginPath();
      g.arc(at(value), down(opacity), i === pointedAt || i === dragged ? 6 : 5, 0, 7);
      g.fill();
      g.stroke();
    });
  };

  const place = (e) => {
    const box = curve.getBoundingClientRect();
    return [((e.clientX - box.left) / box.width) * width, ((e.clientY - box.top) / box.height) * CURVE_HEIGHT];
  };
  const nearest = (x, y) => {
    let found = -1, least = 10;
    model.get("knots").forEach(([value, opacity], i) => {
      const distance = Math.hypot(at(value) - x, down(opacity) - y);
      if (distance < least) [found, least] = [i, distance];
    });
    return found;
  };
  const put = (knots) => {
    model.set("knots", knots.slice().sort((a, b) => a[0] - b[0]));
    model.save_changes();
    draw();
  };
  curve.addEventListener("pointerdown", (e) => {
    curve.setPointerCapture(e.pointerId);
    dragged = nearest(...place(e));
    draw();
  });
  curve.addEventListener("pointermove", (e) => {
    const [x, y] = place(e);
    pointed = words(valueAt(x), opacityAt(y));
    count();
    if (dragged < 0) {
      pointedAt = nearest(x, y);
      curve.style.cursor = pointedAt < 0 ? "crosshair" : "grab";
      draw();
      return;
    }
    const knots = model.get("knots").map((knot) => knot.slice());
    // A knot stays between its neighbours: it is still the same one while it is dragged.
    const low = dragged > 0 ? knots[dragged - 1][0] : -Infinity;
    const high = dragged + 1 < knots.length ? knots[dragged + 1][0] : Infinity;
    knots[dragged][0] = Math.min(Math.max(valueAt(x), low), high);
    knots[dragged][1] = opacityAt(y);
    put(knots);
  });
  const drop = () => {
    dragged = -1;
    draw();
  };
  curve.addEventListener("pointerup", drop);
  curve.addEventListener("pointercancel", drop);
  curve.addEventListener("pointerleave", () => {
    pointed = "";
    count();
    pointedAt = -1;
    draw();
  });
  curve.addEventListener("dblclick", (e) => {
    const [x, y] = place(e);
    const knots = model.get("knots").map((knot) => knot.slice());
    const there = nearest(x, y);
    if (there >= 0) {
      if (knots.length > 1) knots.splice(there, 1);
    } else {
      knots.push([valueAt(x), opacityAt(y), "linear"]);
    }
    put(knots);
  });

  model.on("change:png", show);
  model.on("change:message", tell);
  for (const name of ["knots", "stops", "preset"]) model.on(`change:${name}`, draw);
  show();
  tell();
  draw();
  const end = renderHere(model, canvas, (samples) => {
    own = samples;
    count();
  });
  return () => {
    end();
    if (url) URL.revokeObjectURL(url);
    model.off("change:png", show);
    model.off("change:message", tell);
    for (const name of ["knots", "stops", "preset"]) model.off(`change:${name}`, draw);
  };
}

export default { render };
