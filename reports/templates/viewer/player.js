// Time, controls and the camera that all panes share.

const PLACING = 0.3; // share of a step in which its item comes down
const TOGGLES = ["numbers", "masses", "lengths", "forces"];
const SECONDS = { step: 1.1, failing: 3.5, still: 0.6 };

class Player {
  constructor(data) {
    this.data = data;
    this.panes = [...document.querySelectorAll(".pane")].map((pane, n) => ({
      stage: new Stage(pane.querySelector("canvas"), data, data.loadings[n]),
      now: pane.querySelector(".now"),
      tip: pane.querySelector(".tip"),
    }));
    this.steps = Math.max(...data.loadings.map((loading) => loading.last + 1));
    this.playing = false;
    this.home();
    this.controls();
    this.panes.forEach((pane) => this.orbit(pane));
    this.seek(this.tellingMoment());
    this.frames = 0;
    requestAnimationFrame((now) => this.tick(now));
  }

  // Where the page opens: shortly after the first verdict, or with everything placed.
  tellingMoment() {
    const moments = this.data.loadings.filter((l) => l.failing !== null).map((l) => {
      const { times, judged } = l.steps[l.failing] || { times: [] };
      const seen = times.length ? times[judged] / times[times.length - 1] : 1;
      return l.failing + PLACING + (1 - PLACING) * Math.min(1, seen + 1e-6);
    });
    return moments.length ? Math.min(...moments) : this.steps;
  }

  home() {
    const [w, h, d] = this.data.pallet, tops = this.data.loadings[0].planned.map((at, n) => at[1] + this.data.items[n].size[1] / 2);
    const top = Math.max(...tops);
    this.view = { yaw: 0.65, pitch: 0.42, distance: 2.05 * Math.hypot(w, 0.8 * top + 0.2 * h, d), target: new THREE.Vector3(w / 2, 0.4 * top, d / 2) };
    this.dirty = true;
  }

  // The step that is under way and how much of it is over; a whole number is the end of a step.
  get step() { return Math.max(0, Math.ceil(this.position - 1e-9) - 1); }

  seek(position) {
    this.position = Math.min(Math.max(position, 0), this.steps);
    const share = this.position - this.step;
    const seen = this.panes.map(({ stage }) => stage.show(this.step, share));
    seen.forEach((what, n) => this.say(this.panes[n], what));
    find("step").textContent = `box ${this.step + 1} of ${this.data.items.length}`;
    find("scrub").value = this.step + 1;
    find("scrub").setAttribute("aria-valuetext", find("step").textContent);
    const told = seen.map((what, n) => `${this.data.loadings[n].method}: ${this.sentence(n, what)}`).join(". ");
    if (!this.playing && told !== find("live").textContent) find("live").textContent = told;
    this.dirty = true;
  }

  sentence(n, { at, ended, failed, moved, time, after, simulated }) {
    const loading = this.data.loadings[n], { decimals, length } = this.data.units;
    const seen = moved && (failed || Math.max(moved[1], moved[2]) > 0);
    const motion = seen ? `${this.box(moved[0])} moved ${moved[1].toFixed(decimals)} ${length}, ${moved[2].toFixed(1)}°` : "";
    const clock = `t = ${time.toFixed(2)} s`;
    if (failed && loading.crushed) return `${this.box(loading.moved)} bears more than it may`;
    if (failed && !simulated) return `${this.box(loading.moved ?? at)} would not stand`;
    if (failed) return `${motion}, ${clock}${ended ? (loading.ride ? "" : ", the loading ended here") : after ? ", after the verdict" : ", too far"}`;
    if (ended && !loading.ride) return "everything placed";
    if (!simulated) return `${this.box(at)} placed${loading.simulates ? ", at rest without simulation" : ""}`;
    return time ? `${clock}, ${motion ? `most: ${motion}` : "nothing moved"}` : `placing ${this.box(at)}`;
  }

  say(pane, what) {
    pane.now.textContent = this.sentence(this.panes.indexOf(pane), what);
    pane.now.classList.toggle("bad", what.failed);
  }

  play(on) {
    if (on && this.position >= this.steps) this.seek(0);
    this.playing = on;
    find("play").classList.toggle("playing", on);
    find("play").setAttribute("aria-label", on ? "Pause" : "Play");
    if (!on) this.seek(this.position);
  }

  seconds() {
    const ride = this.data.loadings.find((l) => l.ride && l.last === this.step);
    if (ride) return ride.steps[ride.last].times.at(-1);
    const fails = this.data.loadings.some((l) => l.failing === this.step && l.simulates);
    const moves = this.data.loadings.some((l) => (l.steps[this.step] || { times: [] }).times.length);
    return fails ? SECONDS.failing : moves ? SECONDS.step : SECONDS.still;
  }

  tick(now) {
    if (this.playing && this.before !== undefined) {
      const passed = Math.min((now - this.before) / 1000, 0.1) * Number(find("speed").value);
      this.seek(this.position + passed / this.seconds());
      if (this.position >= this.steps) this.play(false);
    }
    this.before = now;
    if (this.dirty) {
      this.dirty = false;
      this.frames += 1;
      const shown = Object.fromEntries(TOGGLES.map((id) => [id, find(id)?.checked]));
      for (const { stage } of this.panes) stage.draw(this.view, shown);
    }
    requestAnimationFrame((next) => this.tick(next));
  }

  jump(to) {
    this.play(false);
    this.seek(to);
  }

  controls() {
    const acts = {
      first: () => this.jump(0),
      back: () => this.jump(Math.ceil(this.position - 1e-9) - 1),
      play: () => this.play(!this.playing),
      forward: () => this.jump(Math.floor(this.position + 1e-9) + 1),
      last: () => this.jump(this.steps),
      view: () => this.home(),
    };
    const measure = () => find("lengths").click();
    for (const [id, act] of Object.entries(acts)) find(id).onclick = act;
    const redraw = () => { this.dirty = true; };
    for (const id of TOGGLES) find(id)?.addEventListener("change", redraw);
    find("scrub").max = this.data.items.length;
    find("scrub").oninput = () => this.jump(Number(find("scrub").value));
    for (const { failing } of this.data.loadings) {
      if (failing === null) continue;
      const mark = document.createElement("i");
      // The middle of a range's thumb stays half a thumb away from both ends.
      mark.style.left = `calc(8px + (100% - 16px) * ${failing / Math.max(this.data.items.length - 1, 1)})`;
      document.querySelector(".marks").append(mark);
    }
    new ResizeObserver(redraw).observe(document.querySelector("main"));
    DARK.addEventListener("change", () => { this.panes.forEach(({ stage }) => stage.paint()); redraw(); });
    addEventListener("keydown", (event) => this.key(event, { ...acts, measure }), true);
  }

  key(event, acts) {
    const tag = event.target.tagName;
    if (event.ctrlKey || event.metaKey || event.altKey || tag === "SELECT") return;
    const pressable = tag === "BUTTON" || tag === "SUMMARY" || event.target.type === "checkbox";
    const turn = (yaw, pitch) => () => this.turn(yaw, pitch), zoom = (by) => () => this.zoom(by);
    const act = {
      " ": pressable ? null : acts.play, Home: acts.first, End: acts.last,
      ArrowLeft: acts.back, ArrowRight: acts.forward, m: acts.measure,
      a: turn(-0.1, 0), d: turn(0.1, 0), w: turn(0, 0.08), s: turn(0, -0.08),
      "+": zoom(0.9), "=": zoom(0.9), "-": zoom(1.1),
    }[event.key];
    if (!act) return;
    event.preventDefault();
    act();
  }

  turn(yaw, pitch) {
    this.view.yaw += yaw;
    this.view.pitch = Math.min(Math.max(this.view.pitch + pitch, 0.02), 1.55);
    this.dirty = true;
  }

  zoom(by) {
    const reach = Math.hypot(...this.data.pallet);
    this.view.distance = Math.min(Math.max(this.view.distance * by, 0.2 * reach), 12 * reach);
    this.dirty = true;
  }

  pan(dx, dy, camera) {
    const scale = this.view.distance / 1400, move = new THREE.Vector3(-dx * scale, dy * scale, 0);
    this.view.target.add(move.applyQuaternion(camera.quaternion));
    this.dirty = true;
  }

  orbit({ stage, tip }) {
    const { canvas } = stage, held = new Map();
    canvas.onpointerdown = (event) => {
      canvas.setPointerCapture(event.pointerId);
      held.set(event.pointerId, event);
    };
    canvas.onpointerup = canvas.onpointercancel = (event) => held.delete(event.pointerId);
    canvas.onpointerleave = () => this.point(null, stage, tip);
    canvas.onpointermove = (event) => {
      const before = held.get(event.pointerId);
      if (!before) return this.point(event, stage, tip);
      tip.hidden = true;
      const dx = event.clientX - before.clientX, dy = event.clientY - before.clientY;
      const other = [...held.values()].find((one) => one.pointerId !== event.pointerId);
      if (other) {
        const gap = (one) => Math.hypot(one.clientX - other.clientX, one.clientY - other.clientY);
        this.zoom(Math.max(gap(before), 1) / Math.max(gap(event), 1));
      } else if (event.shiftKey || event.buttons === 2) this.pan(dx, dy, stage.camera);
      else this.turn(-dx * 0.007, dy * 0.006);
      held.set(event.pointerId, event);
    };
    canvas.oncontextmenu = (event) => event.preventDefault();
    canvas.ondblclick = () => this.home();
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.zoom(Math.exp(0.0012 * event.deltaY));
    }, { passive: false });
  }

  // A box as all messages name it: by its id, if it has one.
  box(n) {
    return this.data.items[n].label;
  }

  // Says which item is under the pointer.
  point(event, stage, tip) {
    const n = event && stage.itemAt(event.clientX, event.clientY);
    tip.hidden = n === null;
    this.dirty ||= stage.pointed !== n;
    stage.pointed = n;
    if (n === null) return;
    const { size, weight, offset } = this.data.items[n], area = stage.canvas.getBoundingClientRect();
    const { axes, units } = this.data, inOrder = [0, 1, 2].sort((a, b) => (axes[a] < axes[b] ? -1 : 1));
    const sides = inOrder.map((k) => inUnit(size[k], units)).join(" × ");
    const shifts = inOrder.map((k) => [inUnit(offset[k], units), axes[k]]).filter(([shift]) => shift);
    const shifted = shifts.map(([shift, axis]) => `${shift > 0 ? "+" : "−"}${Math.abs(shift)} ${units.length} in ${axis}`);
    tip.textContent = `${this.box(n)}: ${sides} ${units.length}, ${weight}, centre of mass ${shifted.join(", ") || "in the middle"}`;
    tip.style.left = `${Math.min(event.clientX - area.left + 14, area.width - 220)}px`;
    tip.style.top = `${event.clientY - area.top + 14}px`;
  }
}

(async () => {
  try {
    const script = document.createElement("script");
    script.textContent = await unpacked("library");
    document.head.append(script);
    window.player = new Player(JSON.parse(await unpacked("data")));
  } catch (error) {
    find("error").hidden = false;
    find("error").textContent = `This page needs WebGL and a browser of 2023 or later: ${error.message}`;
    throw error;
  }
})();
