// The page's half of lumivox.widget.View: a picture that is turned by dragging and zoomed by the wheel, the presets, and the
// opacity curve over the histogram, whose knots are dragged; a double click adds one or takes one away.

const CURVE_HEIGHT = 90;

function srgb(c) {
  const x = Math.min(Math.max(c, 0), 1);
  return Math.round(255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055));
}

function render({ model, el }) {
  const width = model.get("width"), height = model.get("height");
  const root = document.createElement("div");
  root.style.cssText = `width:${width}px;font:12px system-ui,sans-serif;color:#ccc;background:#14171c;user-select:none`;
  const picture = document.createElement("img");
  picture.style.cssText = `width:${width}px;height:${height}px;display:block;cursor:grab;touch-action:none`;
  picture.draggable = false;
  picture.alt = "";
  const bar = document.createElement("div");
  bar.style.cssText = "display:flex;gap:8px;align-items:center;padding:4px 6px";
  const select = document.createElement("select");
  select.setAttribute("aria-label", "Preset");
  for (const name of model.get("presets")) select.add(new Option(name, name));
  const said = document.createElement("span");
  bar.append(select, said);
  const curve = document.createElement("canvas");
  const ratio = window.devicePixelRatio || 1;
  curve.width = width * ratio;
  curve.height = CURVE_HEIGHT * ratio;
  curve.style.cssText = `width:${width}px;height:${CURVE_HEIGHT}px;display:block;touch-action:none`;
  root.append(picture, bar, curve);
  el.append(root);

  let url = null;
  const show = () => {
    const png = model.get("png");
    if (!png || !png.byteLength) return;
    const next = URL.createObjectURL(new Blob([png], { type: "image/png" }));
    picture.src = next;
    if (url) URL.revokeObjectURL(url);
    url = next;
    said.textContent = `${model.get("samples")} samples`;
  };

  let grabbed = null;
  picture.addEventListener("pointerdown", (e) => {
    picture.setPointerCapture(e.pointerId);
    grabbed = [e.clientX, e.clientY, model.get("azimuth"), model.get("elevation")];
  });
  picture.addEventListener("pointermove", (e) => {
    if (!grabbed) return;
    const [x, y, azimuth, elevation] = grabbed;
    model.set("azimuth", azimuth - ((e.clientX - x) * 180) / width);
    model.set("elevation", Math.min(90, Math.max(-90, elevation + ((e.clientY - y) * 180) / height)));
    model.save_changes();
  });
  const letGo = () => { grabbed = null; };
  picture.addEventListener("pointerup", letGo);
  picture.addEventListener("pointercancel", letGo);
  picture.addEventListener("wheel", (e) => {
    e.preventDefault();
    model.set("zoom", Math.min(20, Math.max(0.1, model.get("zoom") * Math.exp(-e.deltaY / 600))));
    model.save_changes();
  }, { passive: false });
  select.addEventListener("change", () => {
    model.set("preset", select.value);
    model.save_changes();
  });

  const at = (value) => {
    const [low, high] = model.get("value_range");
    return ((value - low) / (high - low)) * width;
  };
  const valueAt = (x) => {
    const [low, high] = model.get("value_range");
    return low + (Math.min(Math.max(x, 0), width) / width) * (high - low);
  };
  const down = (opacity) => 6 + (1 - opacity) * (CURVE_HEIGHT - 12);
  const opacityAt = (y) => Math.min(1, Math.max(0, 1 - (y - 6) / (CURVE_HEIGHT - 12)));
  const draw = () => {
    select.value = model.get("preset");
    const g = curve.getContext("2d");
    g.setTransform(ratio, 0, 0, ratio, 0, 0);
    g.clearRect(0, 0, width, CURVE_HEIGHT);
    const bars = model.get("histogram");
    g.fillStyle = "#2a3038";
    bars.forEach((bar, i) => {
      const tall = bar * (CURVE_HEIGHT - 6);
      g.fillRect((i * width) / bars.length, CURVE_HEIGHT - tall, width / bars.length - 1, tall);
    });
    const knots = model.get("knots");
    g.strokeStyle = "#9fb4c8";
    g.lineWidth = 1.5;
    g.beginPath();
    knots.forEach(([value, opacity], i) => {
      if (i === 0) g.moveTo(0, down(opacity));
      g.lineTo(at(value), down(opacity));
      if (i === knots.length - 1) g.lineTo(width, down(opacity));
    });
    g.stroke();
    const stops = model.get("stops");
    for (const [value, opacity] of knots) {
      const stop = stops.reduce((a, b) => (Math.abs(b[0] - value) < Math.abs(a[0] - value) ? b : a), stops[0]);
      g.fillStyle = stop ? `rgb(${stop[1].map(srgb).join(",")})` : "#fff";
      g.beginPath();
      g.arc(at(value), down(opacity), 5, 0, 7);
      g.fill();
      g.stroke();
    }
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
  let dragged = -1;
  curve.addEventListener("pointerdown", (e) => {
    curve.setPointerCapture(e.pointerId);
    dragged = nearest(...place(e));
  });
  curve.addEventListener("pointermove", (e) => {
    if (dragged < 0) return;
    const [x, y] = place(e);
    const knots = model.get("knots").map((knot) => knot.slice());
    // A knot stays between its neighbours: it is still the same one while it is dragged.
    const low = dragged > 0 ? knots[dragged - 1][0] : -Infinity;
    const high = dragged + 1 < knots.length ? knots[dragged + 1][0] : Infinity;
    knots[dragged][0] = Math.min(Math.max(valueAt(x), low), high);
    knots[dragged][1] = opacityAt(y);
    put(knots);
  });
  const drop = () => { dragged = -1; };
  curve.addEventListener("pointerup", drop);
  curve.addEventListener("pointercancel", drop);
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
  for (const name of ["knots", "stops", "preset"]) model.on(`change:${name}`, draw);
  show();
  draw();
  return () => { if (url) URL.revokeObjectURL(url); };
}

export default { render };
