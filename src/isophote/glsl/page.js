"use strict";
(() => {
  const model = JSON.parse(document.getElementById("model").textContent);
  const canvas = document.getElementById("view");
  const message = document.getElementById("message");
  const text = (id) => document.getElementById(id).textContent.trim();

  const say = (words) => { message.textContent = words; message.hidden = false; };

  const gl = canvas.getContext("webgl2", { alpha: false, antialias: false, preserveDrawingBuffer: true });
  if (!gl) {
    say("This page draws with WebGL 2, which this browser does not offer.\n" +
        "Try a current Firefox, Chrome, Edge or Safari, or turn on hardware acceleration in the browser's settings.");
    return;
  }

  // ---- tables of samples ----
  const load = (grid, unit) => {
    const bytes = Uint8Array.from(atob(grid.levels), (c) => c.charCodeAt(0));
    const levels = new Uint16Array(bytes.buffer);
    const samples = Float32Array.from(levels, (level) => grid.low + grid.step * level);
    const [width, height, depth] = grid.size;
    const target = depth ? gl.TEXTURE_3D : gl.TEXTURE_2D;
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(target, gl.createTexture());
    for (const name of ["TEXTURE_MIN_FILTER", "TEXTURE_MAG_FILTER"]) gl.texParameteri(target, gl[name], gl.NEAREST);
    if (depth) gl.texImage3D(target, 0, gl.R32F, width, height, depth, 0, gl.RED, gl.FLOAT, samples);
    else gl.texImage2D(target, 0, gl.R32F, width, height, 0, gl.RED, gl.FLOAT, samples);
    gl.uniform1i(places[grid.name], unit);
  };

  // ---- the program ----
  let program, places;
  const compile = () => {
    program = gl.createProgram();
    for (const [kind, id] of [[gl.VERTEX_SHADER, "vertex"], [gl.FRAGMENT_SHADER, "fragment"]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text(id));
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) {
      const logs = gl.getAttachedShaders(program).map((shader) => gl.getShaderInfoLog(shader));
      say("The shader of this model could not be compiled here.\n" + [gl.getProgramInfoLog(program), ...logs].join("\n"));
      return false;
    }
    gl.useProgram(program);
    places = new Proxy({}, { get: (known, name) => known[name] ??= gl.getUniformLocation(program, name) });
    model.grids.forEach(load);
    return true;
  };
  if (!compile()) return;

  // ---- the view: an orbit about a target ----
  const start = () => ({ ...model.view, target: [...model.view.target] });
  let view = start();
  const values = Object.fromEntries(model.parameters.map((p) => [p.uniform, p.value]));

  const basis = () => {
    const [cp, sp, cy, sy] = [Math.cos(view.pitch), Math.sin(view.pitch), Math.cos(view.yaw), Math.sin(view.yaw)];
    const back = [cp * sy, sp, cp * cy], right = [cy, 0, -sy];
    const up = [-sp * sy, cp, -sp * cy];
    return { back, right, up };
  };

  const paint = (width, height, samples) => {
    const { back, right, up } = basis();
    const eye = view.target.map((c, i) => c + view.distance * back[i]);
    gl.viewport(0, 0, width, height);
    gl.uniform2f(places.size, width, height);
    gl.uniform1i(places.samples, samples);
    gl.uniform3fv(places.eye, eye);
    gl.uniform3fv(places.cameraRight, right);
    gl.uniform3fv(places.cameraUp, up);
    gl.uniform3fv(places.cameraBack, back);
    gl.uniform1f(places.halfHeight, Math.tan(model.view.fov / 2));
    for (const name in values) gl.uniform1f(places[name], values[name]);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  };

  // ---- drawing when something changes; the resolution follows the frame rate ----
  const SLOW = 1000 / 24, FAST = 1000 / 50, LEAST = 0.2;
  let scale = 1, wanted = false, busy = false, settle = 0, last = 0;

  const resize = (factor) => {
    const dots = window.devicePixelRatio || 1;
    const width = Math.max(1, Math.round(canvas.clientWidth * dots * factor));
    const height = Math.max(1, Math.round(canvas.clientHeight * dots * factor));
    if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; }
  };

  // The graphics processor works on its own; a fence tells when it is done, and so how long a frame takes.
  const finished = (then) => {
    const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    const look = () => {
      if (!gl.isContextLost() && gl.clientWaitSync(fence, 0, 0) === gl.TIMEOUT_EXPIRED) { setTimeout(look, 2); return; }
      gl.deleteSync(fence);
      then();
    };
    look();
  };

  const frame = () => {
    wanted = false;
    busy = true;
    const began = performance.now();
    clearTimeout(settle);
    resize(scale);
    paint(canvas.width, canvas.height, 1);
    finished(() => {
      busy = false;
      const now = performance.now(), took = now - began;
      if (took > SLOW) scale = Math.max(LEAST, scale * Math.sqrt(SLOW / took));
      else if (took < FAST && began - last < 200) scale = Math.min(1, scale * 1.1);
      last = now;
      if (wanted) requestAnimationFrame(frame); else settle = setTimeout(still, 200);
    });
  };
  const still = () => { resize(1); paint(canvas.width, canvas.height, 2); };
  const redraw = () => {
    if (!wanted && !busy) requestAnimationFrame(frame);
    wanted = true;
  };

  // ---- mouse, touch and keys ----
  const pointers = new Map();
  const turn = (dx, dy) => {
    view.yaw -= dx * 0.008;
    view.pitch = Math.max(-1.55, Math.min(1.55, view.pitch + dy * 0.008));
  };
  const move = (dx, dy) => {
    const { right, up } = basis();
    const unit = 2 * view.distance * Math.tan(model.view.fov / 2) / canvas.clientHeight;
    view.target = view.target.map((c, i) => c - (dx * right[i] - dy * up[i]) * unit);
  };
  const zoom = (factor) => {
    view.distance = Math.max(model.view.distance * 0.05, Math.min(model.view.distance * 8, view.distance * factor));
  };
  const used = () => { document.getElementById("help").classList.add("used"); redraw(); };
  const spread = () => {
    const [a, b] = [...pointers.values()];
    return { x: (a.x + b.x) / 2, y: (a.y + b.y) / 2, size: Math.hypot(a.x - b.x, a.y - b.y) || 1 };
  };

  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  });
  for (const name of ["pointerup", "pointercancel"])
    canvas.addEventListener(name, (event) => pointers.delete(event.pointerId));
  canvas.addEventListener("pointermove", (event) => {
    const before = pointers.get(event.pointerId);
    if (!before) return;
    const now = { x: event.clientX, y: event.clientY };
    if (pointers.size === 2) {
      const old = spread();
      pointers.set(event.pointerId, now);
      const fresh = spread();
      zoom(old.size / fresh.size);
      move(fresh.x - old.x, fresh.y - old.y);
    } else {
      pointers.set(event.pointerId, now);
      const shift = event.shiftKey || event.buttons & 6;
      (shift ? move : turn)(now.x - before.x, now.y - before.y);
    }
    used();
  });
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoom(Math.exp(event.deltaY * (event.deltaMode === 1 ? 0.03 : 0.001)));
    used();
  }, { passive: false });
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("dblclick", () => { view = start(); redraw(); });
  const keys = {
    ArrowLeft: () => turn(-20, 0), ArrowRight: () => turn(20, 0), ArrowUp: () => turn(0, -20), ArrowDown: () => turn(0, 20),
    "+": () => zoom(0.9), "=": () => zoom(0.9), "-": () => zoom(1.1), Home: () => { view = start(); },
  };
  canvas.addEventListener("keydown", (event) => {
    if (!keys[event.key]) return;
    event.preventDefault();
    keys[event.key]();
    used();
  });

  // ---- a slider for each parameter ----
  const sliders = document.getElementById("sliders");
  for (const p of model.parameters) {
    const id = "slider-" + p.uniform;
    const label = Object.assign(document.createElement("label"), { textContent: p.name, htmlFor: id });
    const range = Object.assign(document.createElement("input"), {
      type: "range", id, min: p.low, max: p.high, step: "any", value: p.value,
    });
    const output = Object.assign(document.createElement("output"), { textContent: +p.value.toPrecision(4) });
    range.addEventListener("input", () => {
      values[p.uniform] = +range.value;
      output.textContent = +(+range.value).toPrecision(4);
      redraw();
    });
    sliders.append(label, range, output);
  }
  sliders.addEventListener("submit", (event) => event.preventDefault());

  canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
  canvas.addEventListener("webglcontextrestored", () => { if (compile()) redraw(); });
  new ResizeObserver(redraw).observe(canvas);
  redraw();

  // For scripts: the picture of a view at a size, as rows of RGBA from the top.
  window.isophote = {
    model,
    picture(width, height, samples = 1) {
      canvas.width = width; canvas.height = height;
      paint(width, height, samples);
      const pixels = new Uint8Array(width * height * 4);
      gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
      const rows = Array.from({ length: height }, (_, y) => pixels.subarray((height - 1 - y) * width * 4, (height - y) * width * 4));
      return rows.flatMap((row) => Array.from(row));
    },
    get view() { return view; },
    set view(other) { view = { ...view, ...other }; redraw(); },
    get resolution() { return scale; },
  };
})();
