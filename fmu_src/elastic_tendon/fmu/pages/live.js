// The panel in which the model of `model.js` runs: sliders, and curves that follow them.
(() => {
  const STEPS = 200; // places of a slider
  const RISE = 0.01; // s, in which a step is made

  const PAPER = {
    "--text": "#000",
    "--faint": "#444",
    "--line": "#bbb",
    "--accent": "#b93c0a",
    "--live-slack": "#d5e3f0",
    "--live-measured": "#8093a6",
  };

  const panel = document.querySelector(".live");
  const instead = document.querySelector(".live-instead");
  const find = (name) => panel.querySelector(name);
  const content = JSON.parse(document.getElementById("live-model").textContent);
  const canvas = find("canvas");
  const texts = { shown: find(".live-numbers"), spoken: find(".live-spoken") };
  const simulators = {}; // by the motion's name
  const sliders = []; // in the library's order
  let motion = content.recording ? "recording" : "step";
  let stepSliders = [];
  let named = 0; // sliders
  let waiting = false;
  let printing = false;

  const digits = (value, count = 3) => String(Number(value.toPrecision(count)));
  const withUnit = (value, unit) => (unit ? `${digits(value)} ${unit}` : digits(value));
  const withAxis = ({ words, unit }) => `${words} (${unit})`;

  // ---- sliders --------------------------------------------------------------------------------

  function element(tag, attributes, ...children) {
    const made = document.createElement(tag);
    Object.entries(attributes).forEach(([name, value]) => made.setAttribute(name, value));
    made.append(...children);
    return made;
  }

  // A slider has whole places, so that the value it begins with is exactly one of them.
  function slider(number) {
    const { low, high, value, unit, whole } = number;
    const places = whole ? high - low : STEPS;
    const home = Math.round(((value - low) / (high - low)) * places);
    const id = `live-${(named += 1)}`;
    const input = element("input", { type: "range", id, min: 0, max: places, value: home });
    const output = element("output", { for: id });
    const made = {
      path: number.path,
      element: element("div", {}, element("label", { for: id }, number.label), output, input),
      input,
      get value() {
        const place = Number(input.value);
        return place === home ? value : low + ((high - low) * place) / places;
      },
      move(wanted) {
        input.value = Math.round(((wanted - low) / (high - low)) * places);
        made.tell();
      },
      reset() {
        input.value = home;
        made.tell();
      },
      tell() {
        output.textContent = withUnit(made.value, unit);
        input.setAttribute("aria-valuetext", output.textContent);
      },
    };
    const interval = number.interval?.map((bound) => digits(bound, 5)).join(" to ");
    const note = interval ? `${number.note}; 95 % interval ${interval}` : number.note;
    made.element.className = "live-number";
    if (note) {
      made.element.append(element("small", { id: `${id}-note` }, note));
      input.setAttribute("aria-describedby", `${id}-note`);
    }
    input.addEventListener("input", () => {
      made.tell();
      redraw();
    });
    made.tell();
    return made;
  }

  function addSliders() {
    content.groups.forEach(({ title, open, numbers }) => {
      const listed = numbers.map((number) => {
        sliders[number.place] = slider(number);
        return sliders[number.place].element;
      });
      const group = element("fieldset", {}, element("legend", {}, title), ...listed);
      const folded = element("details", {}, element("summary", {}, title), group);
      if (!open) group.firstChild.remove();
      find("form").append(open ? group : folded);
    });
    stepSliders = content.step.numbers.map(slider);
  }

  function addMotions() {
    const holder = element("div", {}, ...stepSliders.map((one) => one.element));
    if (content.recording) {
      const named = { recording: content.recording.title, step: content.step.title };
      Object.entries(named).forEach(([name, title]) => {
        const input = element("input", { type: "radio", name: "motion", value: name });
        input.checked = name === motion;
        input.addEventListener("change", () => choose(name));
        const label = element("label", { class: "live-choice" }, input, title);
        find(".live-motion").append(label);
      });
    }
    find(".live-motion").append(holder);
  }

  function choose(name) {
    motion = name;
    stepSliders[0].element.parentElement.hidden = name !== "step";
    canvas.style.touchAction = name === "step" ? "none" : "auto";
    canvas.style.cursor = name === "step" ? "crosshair" : "auto";
    redraw();
  }

  // ---- motions --------------------------------------------------------------------------------

  function stepMotion() {
    const { samples, duration } = content.step;
    const time = Float64Array.from({ length: samples }, (_, i) => (i * duration) / (samples - 1));
    const inputs = content.inputs.map(() => new Float64Array(samples));
    return { time, inputs, interpolation: "linear", start: content.start };
  }

  function recordedMotion() {
    const numbers = (packed) =>
      new Float64Array(Uint8Array.from(atob(packed), (one) => one.charCodeAt(0)).buffer);
    const { recording } = content;
    const measured = Object.entries(recording.measured);
    recording.measured = Object.fromEntries(measured.map(([name, one]) => [name, numbers(one)]));
    return {
      ...recording,
      time: numbers(recording.time),
      inputs: recording.inputs.map(numbers),
      slopes: recording.slopes.map(numbers),
    };
  }

  async function prepare() {
    const module = await compiledModel(content);
    const motions = { step: stepMotion() };
    if (content.recording) motions.recording = recordedMotion();
    for (const [name, one] of Object.entries(motions)) {
      simulators[name] = { motion: one, ...(await simulator(module, content, one)) };
    }
  }

  function setStep({ motion: { time, inputs }, setInputs }) {
    const [size, at] = stepSliders.map((one) => one.value);
    const stepped = inputs[content.inputs.indexOf(content.step.signal)];
    time.forEach((t, i) => {
      stepped[i] = size * Math.min(Math.max((t - at) / RISE, 0), 1);
    });
    setInputs(inputs);
  }

  // What the sliders make of the motion that is chosen: columns by name, and how it went.
  function simulated() {
    const chosen = simulators[motion];
    if (motion === "step") setStep(chosen);
    const settings = content.settings.map((one) => Number(one && motion === "recording"));
    const began = performance.now();
    const run = chosen.run([...sliders.map((one) => one.value), ...settings]);
    const took = performance.now() - began;
    const { time, inputs } = chosen.motion;
    let count = time.length;
    if (!run.solved) count = Math.max(time.findIndex((t) => t >= run.failureTime), 0);
    const width = content.outputs.length;
    const column = (name) => {
      const place = content.outputs.indexOf(name);
      if (place < 0) return inputs[content.inputs.indexOf(name)].subarray(0, count);
      return Float64Array.from({ length: count }, (_, i) => run.outputs[i * width + place]);
    };
    const { measured = {}, readings = {} } = chosen.motion;
    return { ...run, time: time.subarray(0, count), end: time, column, measured, readings, took };
  }

  // ---- diagrams -------------------------------------------------------------------------------

  function motorShare() {
    const radius = (side) =>
      sliders.find(({ path }) => path === `transmission.${side}_pulley_radius`).value;
    return radius("motor") / radius("joint");
  }

  function errorOf(shown, name) {
    const values = shown.column(shown.readings[name]);
    const { small } = content.recording;
    return values.map((value, i) => small * (value - shown.measured[name][i]));
  }

  function diagrams(shown) {
    const share = motorShare();
    const motor = shown.column("motor_position").map((value) => value * share);
    const lines = (name) => {
      const drawn = [{ values: shown.column(shown.readings[name] ?? name), colour: "--accent" }];
      if (shown.measured[name]) {
        drawn.unshift({ values: shown.measured[name], colour: "--live-measured", label: "measured" });
      }
      return drawn;
    };
    const rows = [
      {
        title: withAxis(content.shown.joint_position),
        lines: [{ values: motor, colour: "--faint", dash: [4, 3], label: "motor" }],
      },
      {
        title: withAxis(content.shown.joint_torque),
        lines: [],
        states: shown.column("slack_state"),
      },
    ];
    rows[0].lines.push(...lines("joint_position"));
    rows[1].lines.push(...lines("joint_torque"));
    const [first] = Object.keys(shown.measured);
    if (first) {
      const values = errorOf(shown, first);
      const title = `error of the ${content.recording.erring} (${content.recording.smallUnit})`;
      rows.splice(1, 0, { title, lines: [{ values, colour: "--accent" }] });
    }
    return rows;
  }

  function draw(shown) {
    const style = getComputedStyle(panel);
    const colours = (name) => (printing && PAPER[name]) || style.getPropertyValue(name);
    return curves.draw(canvas, { colours, font: style.fontFamily }, diagrams(shown), shown);
  }

  // ---- in words -------------------------------------------------------------------------------

  const most = (values) => values.reduce((far, value) => Math.max(far, Math.abs(value)), 0);

  function sentences(shown) {
    if (!shown.solved) {
      return `The simulation stopped at ${digits(shown.failureTime)} s: ${shown.outcome}.`;
    }
    const states = shown.column("slack_state");
    const slack = states.filter((state) => state !== 3).length / states.length;
    const [first] = Object.keys(shown.measured);
    const said = [];
    if (first) {
      const error = errorOf(shown, first);
      const rms = Math.sqrt(error.reduce((sum, one) => sum + one * one, 0) / error.length);
      const { erring, smallUnit } = content.recording;
      said.push(`RMS error of the ${erring} ${withUnit(rms, smallUnit)}.`);
    }
    const share = Math.round(100 * slack);
    said.push(`A tendon is slack ${share} % of the time (shaded: I the lower one, II the upper).`);
    const { words, unit } = content.shown.joint_torque;
    said.push(`Largest ${words} ${withUnit(most(shown.column("joint_torque")), unit)}.`);
    if (most(shown.column("overstretched")) > 0) said.push("A spring is overstretched.");
    return said.join(" ");
  }

  // ---- all together ---------------------------------------------------------------------------

  let drawn = null;

  function show() {
    waiting = false;
    const began = performance.now();
    const shown = simulated();
    drawn = draw(shown);
    const said = sentences(shown);
    const times = [shown.took, performance.now() - began - shown.took].map((one) => digits(one));
    texts.shown.textContent = `${said} Computed in ${times[0]} ms, drawn in ${times[1]} ms.`;
    return said;
  }

  function redraw() {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(show);
  }

  // The end of a step follows the pointer in the first diagram: when, and how far.
  function drag(event) {
    if (motion !== "step" || event.buttons === 0 || !drawn) return;
    const box = canvas.getBoundingClientRect();
    const [first] = drawn.rows;
    const x = curves.scale(drawn.across, ...drawn.horizontal);
    const y = curves.scale([first.bottom, first.top], ...first.range);
    const [size, at] = stepSliders;
    if (content.step.signal === "motor_position") {
      size.move(y(event.clientY - box.top) / motorShare()); // a torque is not in this diagram
    }
    at.move(x(event.clientX - box.left));
    redraw();
  }

  async function begin() {
    await prepare();
    addSliders();
    addMotions();
    panel.hidden = false;
    instead.hidden = true;
    choose(motion);
    find(".live-reset").addEventListener("click", () => {
      [...sliders, ...stepSliders].forEach((one) => one.reset());
      redraw();
    });
    find("form").addEventListener("submit", (event) => event.preventDefault());
    find("form").addEventListener("change", () => {
      requestAnimationFrame(() => {
        texts.spoken.textContent = show();
      });
    });
    ["pointerdown", "pointermove"].forEach((name) => canvas.addEventListener(name, drag));
    new ResizeObserver(redraw).observe(canvas);
    const print = (begins) => () => {
      printing = begins;
      show();
    };
    window.addEventListener("beforeprint", print(true));
    window.addEventListener("afterprint", print(false));
    window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
  }

  begin().catch((error) => {
    panel.hidden = true;
    instead.hidden = false;
    instead.dataset.reason = String(error);
  });
})();
