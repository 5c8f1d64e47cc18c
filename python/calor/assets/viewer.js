// Fields at the points: WebGL draws every point as a disc, a ball in 3D, of the size of its spacing.
(() => {
  const given = data.cloud;
  if (!given) return;
  const stage = document.getElementById("stage"), canvas = stage.querySelector("canvas");
  const gl = canvas.getContext("webgl", { antialias: true, preserveDrawingBuffer: true });
  const element = id => document.getElementById(id);
  if (!gl) { element("probe").textContent = "This browser has no WebGL: the fields cannot be shown."; return; }

  const bytes = text => Uint8Array.from(atob(text), letter => letter.charCodeAt(0)).buffer;
  const x = new Float32Array(bytes(given.x)), size = new Float32Array(bytes(given.size)), count = size.length;
  const flat = given.dimension < 3, low = given.low, high = given.high;
  const centre = low.map((value, axis) => (value + high[axis]) / 2);
  const radius = Math.hypot(...high.map((value, axis) => value - low[axis])) / 2 || 1;
  const fields = given.fields.map(field => ({ ...field, steps: field.values.map(text => new Uint16Array(bytes(text))) }));

  // Colours ---------------------------------------------------------------------------------------------------------------
  const knots = given.colours.match(/../g).map(pair => parseInt(pair, 16));
  const map = new Uint8Array(256 * 4);
  for (let n = 0; n < 256; ++n) {
    const at = n / 255 * (knots.length / 3 - 1), k = Math.min(Math.floor(at), knots.length / 3 - 2);
    for (let c = 0; c < 3; ++c) map[4 * n + c] = Math.round(knots[3 * k + c] * (1 - at + k) + knots[3 * k + 3 + c] * (at - k));
    map[4 * n + 3] = 255;
  }
  const bar = element("scale").querySelector("canvas");
  bar.width = 1; bar.height = 256;
  const drawn = new ImageData(1, 256);
  for (let n = 0; n < 256; ++n) drawn.data.set(map.subarray(4 * n, 4 * n + 4), 4 * (255 - n));
  bar.getContext("2d").putImageData(drawn, 0, 0);

  // The program -----------------------------------------------------------------------------------------------------------
  const vertex = `
    attribute vec3 place; attribute float value, size;
    uniform mat4 view; uniform float pixels; uniform vec4 cut; uniform vec2 range;
    varying float shade;
    void main() {
      gl_Position = view * vec4(place, 1.0);
      gl_PointSize = max(1.5, pixels * size / gl_Position.w);
      shade = clamp((value - range.x) / (range.y - range.x), 0.0, 1.0);
      if (dot(cut.xyz, place) > cut.w) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    }`;
  const fragment = `
    precision mediump float;
    uniform sampler2D map; uniform bool flat_body; varying float shade;
    void main() {
      vec2 r = 2.0 * gl_PointCoord - 1.0;
      float light = 1.0;
      if (!flat_body) {
        float square = dot(r, r);
        if (square > 1.0) discard;
        light = 0.68 + 0.32 * dot(vec3(r.x, -r.y, sqrt(1.0 - square)), vec3(-0.3, 0.5, 0.81));
      }
      gl_FragColor = vec4(light * texture2D(map, vec2(shade, 0.5)).rgb, 1.0);
    }`;
  const program = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  gl.useProgram(program);
  const uniform = name => gl.getUniformLocation(program, name);
  const buffer = (name, values, components, type, normalised) => {
    const handle = gl.createBuffer(), attribute = gl.getAttribLocation(program, name);
    gl.bindBuffer(gl.ARRAY_BUFFER, handle);
    gl.bufferData(gl.ARRAY_BUFFER, values, gl.DYNAMIC_DRAW);
    gl.enableVertexAttribArray(attribute);
    gl.vertexAttribPointer(attribute, components, type, normalised, 0, 0);
    return handle;
  };
  buffer("place", x, 3, gl.FLOAT, false);
  buffer("size", size, 1, gl.FLOAT, false);
  const shown = buffer("value", new Uint16Array(count), 1, gl.UNSIGNED_SHORT, true);
  gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, 256, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, map);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
  gl.enable(gl.DEPTH_TEST);

  // What is shown ---------------------------------------------------------------------------------------------------------
  const from = { azimuth: -0.9, elevation: 0.5 }, camera = { ...from };
  let field = fields[0], step = 0, range = [0, 1], view = null;
  const valueOf = raw => field.low + (field.high - field.low) * raw / 65535;

  function directions() {
    if (flat) return [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
    const { azimuth: a, elevation: e } = camera;
    const right = [-Math.sin(a), Math.cos(a), 0], back = [Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e)];
    const up = [back[1] * right[2] - back[2] * right[1], back[2] * right[0] - back[0] * right[2], back[0] * right[1] - back[1] * right[0]];
    return [right, up, back];
  }

  // Part of the width that the colour scale takes.
  const room = () => Math.min(0.3, 105 / canvas.clientWidth);

  // How large the body may be drawn at the present turn.
  function fitBody() {
    camera.fit = 1;
    camera.zoom = 1;
    camera.shift = [-room(), 0];
    const m = viewMatrix().columns;
    const half = size.reduce((most, value) => Math.max(most, value), 0) / 2;
    let most = 1e-9;
    for (let corner = 0; corner < 8; ++corner) {
      const [a, b, c] = [0, 1, 2].map(axis => corner >> axis & 1 ? high[axis] + half : low[axis] - half);
      const w = m[3] * a + m[7] * b + m[11] * c + m[15];
      most = Math.max(most, Math.abs((m[0] * a + m[4] * b + m[8] * c + m[12]) / w - camera.shift[0]) / (1 - room()),
        Math.abs((m[1] * a + m[5] * b + m[9] * c + m[13]) / w));
    }
    camera.fit = 0.92 / most;
  }

  // Column by column. Flat bodies are seen from straight above, without perspective; others from 3.4 radii away.
  function viewMatrix() {
    const [right, up, back] = directions(), aspect = canvas.clientWidth / canvas.clientHeight;
    const away = 3.4 * radius, scale = camera.fit * camera.zoom / (flat ? radius : 1);
    const dot = v => v[0] * centre[0] + v[1] * centre[1] + v[2] * centre[2];
    const near = away - 1.2 * radius, far = away + 1.2 * radius;
    const rows = [
      [...right.map(c => c * scale / aspect), -dot(right) * scale / aspect],
      [...up.map(c => c * scale), -dot(up) * scale],
      flat ? [0, 0, 0, 0] : [...back.map(c => -c * (far + near) / (far - near)), (dot(back) + away) * (far + near) / (far - near) - 2 * far * near / (far - near)],
      flat ? [0, 0, 0, 1] : [...back.map(c => -c), dot(back) + away],
    ];
    for (const axis of [0, 1]) rows[axis] = rows[axis].map((c, n) => c + camera.shift[axis] * rows[3][n]);
    return { scale, columns: Float32Array.from({ length: 16 }, (_, n) => rows[n % 4][Math.floor(n / 4)]) };
  }

  function cutPlane() {
    const choice = element("cut").value;
    if (choice === "none") return [0, 0, 0, 1];
    const axis = "xyz".indexOf(choice[1]), side = choice[0] === "-" ? -1 : 1, part = element("cutat").value / 1000;
    const at = low[axis] + part * (high[axis] - low[axis]), slack = 1e-6 * radius;
    return [0, 1, 2].map(n => n === axis ? side : 0).concat(side * at + slack);
  }

  function draw() {
    const ratio = devicePixelRatio || 1;
    canvas.width = canvas.clientWidth * ratio;
    canvas.height = canvas.clientHeight * ratio;
    gl.viewport(0, 0, canvas.width, canvas.height);
    const ground = colour("--paper").match(/[0-9a-f]{2}/gi).map(pair => parseInt(pair, 16) / 255);
    gl.clearColor(...ground, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    view = viewMatrix();
    gl.uniformMatrix4fv(uniform("view"), false, view.columns);
    gl.uniform1f(uniform("pixels"), view.scale * canvas.height / 2 * (flat ? 1.04 : 1.25));
    gl.uniform4fv(uniform("cut"), cutPlane());
    gl.uniform2fv(uniform("range"), range);
    gl.uniform1i(uniform("flat_body"), flat);
    gl.drawArrays(gl.POINTS, 0, count);
  }

  // Three to six round numbers of a range.
  function niceValues(bottom, top) {
    const rough = (top - bottom) / 5, power = 10 ** Math.floor(Math.log10(rough));
    const every = power * [1, 2, 5, 10].find(factor => factor * power >= rough * 0.999);
    const values = [];
    for (let n = Math.ceil(bottom / every - 1e-6); n * every <= top + 1e-6 * every; ++n) values.push(n * every);
    return values;
  }

  function show() {
    step = Math.min(step, field.steps.length - 1);
    const values = field.steps[step];
    range = [0, 1];
    if (element("range").value === "now" || field.steps.length === 1) {
      let least = 65535, most = 0;
      for (const value of values) { least = Math.min(least, value); most = Math.max(most, value); }
      range = [least / 65535, Math.max(most, least + 1) / 65535];
    }
    gl.bindBuffer(gl.ARRAY_BUFFER, shown);
    gl.bufferSubData(gl.ARRAY_BUFFER, 0, values);
    const time = element("time"), many = field.steps.length > 1;
    time.max = field.steps.length - 1;
    time.value = step;
    element("times").style.display = many ? "" : "none";
    element("ranges").style.display = many ? "" : "none";
    element("now").textContent = many ? `t = ${digits(given.times[step], 4)} s` : "";
    const bottom = valueOf(65535 * range[0]), top = valueOf(65535 * range[1]);
    element("ticks").replaceChildren(...niceValues(bottom, top).map(value => {
      const tick = document.createElement("span");
      tick.style.bottom = `${100 * (value - bottom) / (top - bottom)}%`;
      tick.textContent = digits(value, 8);
      return tick;
    }));
    draw();
  }

  // Controls --------------------------------------------------------------------------------------------------------------
  for (const [n, one] of fields.entries()) element("field").add(new Option(one.label, n));
  element("field").addEventListener("change", event => { field = fields[event.target.value]; show(); });
  element("time").addEventListener("input", event => { step = +event.target.value; show(); });
  element("range").addEventListener("change", show);
  element("cut").addEventListener("change", draw);
  element("cutat").addEventListener("input", draw);
  if (flat) element("cuts").style.display = "none";
  element("reset").addEventListener("click", () => { Object.assign(camera, from); fitBody(); draw(); });
  let playing = null;
  element("play").addEventListener("click", () => {
    playing = playing ? clearInterval(playing) : setInterval(() => { step = (step + 1) % field.steps.length; show(); }, Math.max(60, 5000 / field.steps.length));
    element("play").textContent = playing ? "stop" : "play";
  });

  const held = new Map();
  let spread = 0;
  canvas.addEventListener("pointerdown", event => { held.set(event.pointerId, event); canvas.setPointerCapture(event.pointerId); });
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, event => { held.delete(event.pointerId); spread = 0; });
  canvas.addEventListener("pointermove", event => {
    const before = held.get(event.pointerId);
    if (!before) return look(event);
    const dx = event.clientX - before.clientX, dy = event.clientY - before.clientY;
    held.set(event.pointerId, event);
    if (held.size === 2) {
      const [a, b] = [...held.values()], now = Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY);
      if (spread) camera.zoom *= now / spread;
      spread = now;
    } else if (flat || event.shiftKey || event.buttons === 2) {
      camera.shift[0] += 2 * dx / canvas.clientWidth;
      camera.shift[1] -= 2 * dy / canvas.clientHeight;
    } else {
      camera.azimuth -= 0.008 * dx;
      camera.elevation = Math.max(-1.57, Math.min(1.57, camera.elevation + 0.008 * dy));
    }
    draw();
  });
  canvas.addEventListener("contextmenu", event => event.preventDefault());
  canvas.addEventListener("wheel", event => {
    event.preventDefault();
    const factor = Math.exp(-0.0012 * event.deltaY), box = canvas.getBoundingClientRect();
    const at = [2 * (event.clientX - box.left) / box.width - 1, 1 - 2 * (event.clientY - box.top) / box.height];
    camera.zoom *= factor;
    for (const axis of [0, 1]) camera.shift[axis] = at[axis] + factor * (camera.shift[axis] - at[axis]);  // what is under the pointer stays
    draw();
  }, { passive: false });
  canvas.addEventListener("keydown", event => {
    const turn = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (turn && !flat) { camera.azimuth += 0.1 * turn[0]; camera.elevation = Math.max(-1.57, Math.min(1.57, camera.elevation + 0.1 * turn[1])); }
    else if (event.key === "+" || event.key === "-") camera.zoom *= event.key === "+" ? 1.2 : 1 / 1.2;
    else return;
    event.preventDefault();
    draw();
  });

  // The point under the pointer: of those near it the one in front.
  function look(event) {
    const box = canvas.getBoundingClientRect(), m = view.columns, cut = cutPlane();
    const px = 2 * (event.clientX - box.left) / box.width - 1, py = 1 - 2 * (event.clientY - box.top) / box.height;
    let best = -1, front = Infinity;
    for (let n = 0; n < count; ++n) {
      const [a, b, c] = [x[3 * n], x[3 * n + 1], x[3 * n + 2]];
      if (cut[0] * a + cut[1] * b + cut[2] * c > cut[3]) continue;
      const w = m[3] * a + m[7] * b + m[11] * c + m[15];
      const sx = (m[0] * a + m[4] * b + m[8] * c + m[12]) / w - px, sy = (m[1] * a + m[5] * b + m[9] * c + m[13]) / w - py;
      const reach = 0.62 * view.scale * size[n] / w;
      const off = Math.hypot(sx * box.width / box.height, sy);
      if (off < reach && w + 0.001 * off < front) { front = w + 0.001 * off; best = n; }
    }
    const at = best < 0 ? "" : "xyz".slice(0, given.dimension).split("").map((name, axis) => `${name} = ${digits(Math.abs(x[3 * best + axis]) < 1e-6 * radius ? 0 : x[3 * best + axis] * given.factor, 4)}`).join(", ");
    element("probe").textContent = best < 0 ? "" : `${at} ${given.unit}: ${digits(valueOf(field.steps[step][best]))} ${field.unit}`;
  }

  // It opens at the time of the largest differences, of a weld with the melt: at the end there may be none left.
  const spreads = field.steps.map(values => values.reduce((most, value) => Math.max(most, value), 0) - values.reduce((least, value) => Math.min(least, value), 65535));
  step = spreads.lastIndexOf(Math.max(...spreads));
  onTheme.push(draw);
  addEventListener("resize", () => { fitBody(); draw(); });
  fitBody();
  show();
})();
