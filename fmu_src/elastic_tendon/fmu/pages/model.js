// The model itself, as WebAssembly: arrays in, arrays out.
"use strict";

// Unpacks and compiles; what is described is what `fmu/live.py` writes.
async function compiledModel(described) {
  const packed = Uint8Array.from(atob(described.module), (letter) => letter.charCodeAt(0));
  const plain = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return WebAssembly.compile(await new Response(plain).arrayBuffer());
}

// Memory for a motion: `run` simulates it with an array of parameters, `setInputs` changes it. The
// motion has time (n), inputs (each n), slopes of them where it is cubic, interpolation, and start
// of the states (null: calculated).
async function simulator(module, described, motion) {
  const instance = await WebAssembly.instantiate(module, { Math });
  const { memory, malloc, elastic_tendon_simulate: simulate } = instance.exports;
  const { places, states, outputs, tolerance, eventCapacity } = described;
  const n = motion.time.length;
  const room = (count) => malloc(8 * Math.max(count, 1));
  const view = (address, count) => new Float64Array(memory.buffer, address, count);
  const put = (values) => {
    const address = room(values.length);
    view(address, values.length).set(values);
    return address;
  };
  const joined = (rows) => rows.flatMap((values) => [...values]);
  const parameters = room(described.parameterCount + described.settings.length);
  const call = malloc(places[""][0]);
  const fields = {
    n_samples: n,
    time: put(motion.time),
    input: put(joined(motion.inputs)),
    input_slope: put(joined(motion.slopes ?? [])),
    interpolation: described.interpolations.indexOf(motion.interpolation),
    parameters,
    initial_state: put(motion.start.map((value) => value ?? NaN)),
    tolerance,
    most_steps: described.mostSteps,
    states: room(n * states.length),
    outputs: room(n * outputs.length),
    event_time: room(eventCapacity),
    event_capacity: eventCapacity,
  };
  const field = (name) => [new DataView(memory.buffer), call + places[name][0]];
  const write = (name, value) => {
    const [data, place] = field(name);
    const type = places[name][1];
    if (type.endsWith("*")) data.setUint32(place, value, true);
    else if (type === "double") data.setFloat64(place, value, true);
    else data.setBigInt64(place, BigInt(value), true);
  };
  new Uint8Array(memory.buffer, call, places[""][0]).fill(0);
  Object.entries(fields).forEach(([name, value]) => write(name, value));

  const run = (values) => {
    view(parameters, values.length).set(values);
    const outcome = simulate(call);
    const [data, failed] = field("failure_time");
    const events = data.getBigInt64(call + places["statistics.events"][0], true);
    return {
      outcome: described.outcomes[outcome],
      solved: outcome === 0,
      failureTime: data.getFloat64(failed, true),
      states: view(fields.states, n * states.length),
      outputs: view(fields.outputs, n * outputs.length), // sample by sample
      eventTimes: view(fields.event_time, Math.min(Number(events), eventCapacity)),
    };
  };
  const setInputs = (inputs) =>
    inputs.forEach((values, i) => view(fields.input + 8 * i * n, n).set(values));
  return { run, setInputs };
}
