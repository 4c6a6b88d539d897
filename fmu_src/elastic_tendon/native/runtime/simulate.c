/* The entry that Python calls: arrays in, arrays out, one call. */
#include <stdlib.h>

#include "compilers.h"
#include "solver.h"

/* Polynomial through two samples, in powers of the time since the first. */
static void polynomial(const double *value, const double *slope, long long i, double h,
                       long long interpolation, double c[4]) {
  c[0] = value[i];
  c[1] = c[2] = c[3] = 0.0;
  if (interpolation == HOLD) return;
  const double mean = (value[i + 1] - value[i]) / h;
  c[1] = mean;
  if (interpolation == LINEAR) return;
  c[1] = slope[i];
  c[2] = (3 * mean - 2 * slope[i] - slope[i + 1]) / h;
  c[3] = (slope[i] + slope[i + 1] - 2 * mean) / (h * h);
}

static void differentiate(const double polynomial[4], double rate[4]) {
  rate[0] = polynomial[1];
  rate[1] = 2 * polynomial[2];
  rate[2] = 3 * polynomial[3];
  rate[3] = 0.0;
}

/* Inputs after sample i until the next, on a clock that is late by `delay`. After the last sample
 * they stay: only HOLD sees another value there than the segment's end. */
static void signal_after(const Simulation *sim, long long i, double delay, Signal *signal) {
  const int last = i + 1 == sim->n_samples;
  if (last && sim->interpolation != HOLD) return;
  const long long interpolation = last ? HOLD : sim->interpolation;
  const double h = last ? 0.0 : sim->time[i + 1] - sim->time[i];
  long long place = i;
  signal->origin = sim->time[i] + delay;
  for (int j = 0; j < N_INPUTS; j++) {
    if (rate_of[j] >= 0) continue;
    polynomial(sim->input, sim->input_slope, place, h, interpolation, signal->coefficient[j]);
    place += sim->n_samples;
  }
  for (int j = 0; j < N_INPUTS; j++)
    if (rate_of[j] >= 0) differentiate(signal->coefficient[rate_of[j]], signal->coefficient[j]);
}

/* ---- delayed signals ---------------------------------------------------------------------------
 *
 * Signals of the joint that are recorded late are those of a model whose inputs come late: the
 * model's clock is that of the recording, and what is measured at the motor is seen `delay` later.
 */

#define DELAYED (N_DELAY_JACOBIAN > 0)

/* Before the first sample inputs are as there. */
static void signal_before_samples(const Simulation *sim, Signal *signal) {
  memset(signal, 0, sizeof *signal);
  signal->origin = sim->time[0];
  long long place = 0;
  for (int j = 0; j < N_INPUTS; j++) {
    if (rate_of[j] >= 0) continue;
    signal->coefficient[j][0] = sim->input[place];
    place += sim->n_samples;
  }
}

/* Derivative of the delay by each direction. */
static void delay_slopes(const Solver *s, double *slope) {
  double u[N_INPUTS], nonzeros[N_DELAY_JACOBIAN + 1], none[N_STATES] = {0};
  signal_at(&s->signal, s->motion.time, u);
  model_delay_jacobian(s->motion.x, u, s->p, s->motion.mode, nonzeros);
  for (int j = 0; j < s->n_directions; j++)
    multiply(&delay_jacobian_pattern, nonzeros, none, s->direction[j], 1, &slope[j]);
}

/* A longer delay: the model has waited longer at its start, and is seen earlier (`write_...`). */
static void shift_sensitivities(Solver *s, const double *slope) {
  double u[N_INPUTS], rate[N_STATES];
  signal_at(&s->signal, s->motion.time, u);
  model_rates(s->motion.x, u, s->p, s->motion.mode, rate);
  for (int j = 0; j < s->n_directions; j++)
    for (int i = 0; i < N_STATES; i++) s->vector[LENGTH(j) + i] += slope[j] * rate[i];
}

/* Start as without delay, then wait with the inputs of the first sample. */
static Outcome begin_delayed(Solver *s, const Simulation *sim, const double *slope) {
  signal_after(sim, 0, 0.0, &s->signal);
  Outcome outcome = solver_settle(s);
  if (outcome != SOLVED) return outcome;
  signal_before_samples(sim, &s->signal);
  outcome = solver_settle(s);
  if (outcome == SOLVED) shift_sensitivities(s, slope);
  return outcome;
}

/* Far more than any actuator has: what has more chatters, and would keep the caller for hours. */
#define MOST_EVENTS 20000
#define EVENTS_PER_SAMPLE 10

/* ---- samples --------------------------------------------------------------------------------- */

/* Rates of the outputs in time. */
static void output_rates_at(const Solver *s, const double *u, const double *nonzeros,
                            double *rate) {
  double x_rate[N_STATES], u_rate[N_INPUTS];
  model_rates(s->motion.x, u, s->p, s->motion.mode, x_rate);
  signal_rate(&s->signal, s->motion.time, u_rate);
  multiply(&outputs_jacobian_pattern, nonzeros, x_rate, -1, N_OUTPUTS, rate);
  for (int j = 0; j < N_INPUTS; j++)
    for (int k = outputs_jacobian_pattern.columns[V_INPUTS + j];
         k < outputs_jacobian_pattern.columns[V_INPUTS + j + 1]; k++)
      rate[outputs_jacobian_pattern.rows[k]] += nonzeros[k] * u_rate[j];
}

/* Which outputs of a sample are written: those measured at the joint, at the motor, or both. */
enum { AT_JOINT = 1, AT_MOTOR = 2 };

static int seen(int output, int where) {
  return where & (output_at_motor[output] ? AT_MOTOR : AT_JOINT);
}

static void write_derivatives(const Solver *s, const double *u, const double *slope, int where,
                              double *derivatives) {
  const int m = s->n_directions;
  double nonzeros[N_OUTPUTS_JACOBIAN], column[N_OUTPUTS], rate[N_OUTPUTS] = {0};
  model_outputs_jacobian(s->motion.x, u, s->p, s->motion.mode, nonzeros);
  if (DELAYED && where & AT_JOINT) output_rates_at(s, u, nonzeros, rate);
  for (int j = 0; j < m; j++) {
    multiply(&outputs_jacobian_pattern, nonzeros, s->vector + LENGTH(j), s->direction[j], N_OUTPUTS,
             column);
    for (int i = 0; i < N_OUTPUTS; i++)
      if (seen(i, where))
        derivatives[i * m + j] = column[i] - (output_at_motor[i] ? 0.0 : slope[j] * rate[i]);
  }
}

static void write_sample(const Solver *s, long long i, const double *slope, int where,
                         Simulation *sim) {
  double u[N_INPUTS], outputs[N_OUTPUTS];
  signal_at(&s->signal, s->motion.time, u);
  model_outputs(s->motion.x, u, s->p, s->motion.mode, outputs);
  for (int k = 0; k < N_OUTPUTS; k++)
    if (seen(k, where)) sim->outputs[i * N_OUTPUTS + k] = outputs[k];
  if (where & AT_JOINT) memcpy(sim->states + i * N_STATES, s->motion.x, sizeof s->motion.x);
  if (s->n_directions > 0)
    write_derivatives(s, u, slope, where,
                      sim->output_derivatives + i * N_OUTPUTS * s->n_directions);
}

/* `slope` is work of n_directions. */
static Outcome run(Solver *s, Simulation *sim, double *slope) {
  long long joint = 0, motor = 0; /* samples written */
  double u[N_INPUTS] = {0}, delay = 0.0;
  if (DELAYED) {
    model_delay(s->motion.x, u, s->p, s->motion.mode, &delay);
    delay_slopes(s, slope);
    const Outcome outcome = begin_delayed(s, sim, slope);
    if (outcome != SOLVED) return outcome;
  }
  while (motor < sim->n_samples) {
    const double knot = sim->time[motor] + delay;
    const int at_sample = joint < sim->n_samples && sim->time[joint] <= knot;
    const double stop = at_sample ? sim->time[joint] : knot;
    const int at_knot = knot <= stop;
    Outcome outcome = SOLVED;
    if (stop > s->motion.time) outcome = solver_advance(s, stop);
    if (outcome != SOLVED) return outcome;
    if (s->statistics.events > MOST_EVENTS + EVENTS_PER_SAMPLE * sim->n_samples)
      return TOO_MANY_EVENTS;
    if (at_knot) signal_after(sim, motor, delay, &s->signal);
    /* a spline goes through its knots smoothly, and between knots nothing changes */
    if (at_knot && (motor == 0 || sim->interpolation != CUBIC)) outcome = solver_settle(s);
    if (outcome != SOLVED) return outcome;
    if (at_sample && at_knot && joint == motor) {
      write_sample(s, joint++, slope, AT_JOINT | AT_MOTOR, sim);
      motor++;
      continue;
    }
    if (at_sample) write_sample(s, joint++, slope, AT_JOINT, sim);
    if (at_knot) write_sample(s, motor++, slope, AT_MOTOR, sim);
  }
  return SOLVED;
}

/* Doubles that a simulation works with; one at least, as no memory would look like a failure. */
static size_t memory_of(const Simulation *sim) {
  const size_t m = (size_t)sim->n_directions;
  return SOLVER_MEMORY(m) + m + 1;
}

static Outcome simulate(Simulation *sim, double *memory) {
  const int m = (int)sim->n_directions;
  double p[N_PREPARED];
  memcpy(p, sim->parameters, sizeof(double) * N_PARAMETERS);
  model_prepare(p, p + N_PARAMETERS);
  Solver s = {.p = p,
              .tolerance = sim->tolerance,
              .n_directions = m,
              .direction = sim->direction,
              .vector = memory,
              .event_time = sim->event_time,
              .event_capacity = sim->event_capacity,
              .most_steps = sim->most_steps,
              .interrupted = sim->interrupted,
              .second = &sim->second};
  memset(memory, 0, sizeof(double) * memory_of(sim));
  memcpy(s.motion.x, sim->initial_state, sizeof s.motion.x);
  for (int j = 0; j < m; j++)
    if (s.direction[j] < N_STATES) s.vector[LENGTH(j) + s.direction[j]] = 1.0;
  solver_restart(&s, sim->time[0]);
  const Outcome outcome = run(&s, sim, memory + SOLVER_MEMORY((size_t)m));
  sim->statistics = s.statistics;
  sim->failure_time = s.motion.time;
  return outcome;
}

/* Returns an Outcome. */
EXPORT int elastic_tendon_simulate(Simulation *sim) {
  double *memory = malloc(sizeof(double) * memory_of(sim));
  if (!memory) return SHORT_OF_MEMORY;
  const Outcome outcome = simulate(sim, memory);
  free(memory);
  return (int)outcome;
}

/* ---- many runs -------------------------------------------------------------------------------- */

/* Kept outputs, each in one row, from all outputs sample by sample. */
static void keep(const Simulation *sim, const Runs *runs, Outcome outcome, double *kept) {
  for (long long k = 0; k < runs->n_kept; k++)
    for (long long i = 0; i < sim->n_samples; i++)
      *kept++ = outcome == SOLVED ? sim->outputs[i * N_OUTPUTS + runs->kept[k]] : NAN;
}

/* `sim` says all but the parameters; its states and outputs are work, written anew by each run.
 * Returns SOLVED, whatever the outcomes, SHORT_OF_MEMORY or INTERRUPTED. */
EXPORT int elastic_tendon_simulate_many(Simulation *sim, const Runs *runs) {
  double *memory = malloc(sizeof(double) * memory_of(sim));
  if (!memory) return SHORT_OF_MEMORY;
  Outcome outcome = SOLVED;
  for (long long i = 0; i < runs->n_runs && outcome != INTERRUPTED; i++) {
    sim->parameters = runs->parameters + i * N_PARAMETERS;
    outcome = simulate(sim, memory);
    runs->outcome[i] = (int)outcome;
    runs->failure_time[i] = sim->failure_time;
    keep(sim, runs, outcome, runs->outputs + i * runs->n_kept * sim->n_samples);
  }
  free(memory);
  return outcome == INTERRUPTED ? INTERRUPTED : SOLVED;
}
