/* The entry that Python calls: arrays in, arrays out, one call. */
#include <stdlib.h>

#include "export.h"
#include "solver.h"

enum { HOLD, LINEAR, CUBIC };

/* Mirrored by compiled.py; sizes in elements, arrays row by row. */
typedef struct {
  long long n_samples;
  const double *time;            /* s, increasing */
  const double *motor_position;  /* rad at the samples */
  const double *load_torque;     /* N.m at the samples */
  const double *position_slope;  /* rad/s and N.m/s at the samples, for CUBIC */
  const double *load_slope;
  long long interpolation;
  const double *parameters;
  const double *initial_state;
  double tolerance;
  long long n_directions;
  const int *direction;          /* index in v = [x; u; p]: of an initial state or a parameter */
  double *states;                /* out: n_samples x N_STATES */
  double *outputs;               /* out: n_samples x N_OUTPUTS */
  double *output_derivatives;    /* out: n_samples x N_OUTPUTS x n_directions */
  double *event_time;            /* out: times of the first event_capacity located events */
  long long event_capacity;
  Statistics statistics;         /* out */
  double failure_time;           /* out, where the outcome is not SOLVED */
} Simulation;

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

static void signal_from_samples(const Simulation *sim, long long i, Signal *signal) {
  const double h = sim->time[i + 1] - sim->time[i];
  double *position = signal->coefficient[MOTOR_POSITION];
  double *velocity = signal->coefficient[MOTOR_VELOCITY];
  signal->origin = sim->time[i];
  polynomial(sim->motor_position, sim->position_slope, i, h, sim->interpolation, position);
  polynomial(sim->load_torque, sim->load_slope, i, h, sim->interpolation,
             signal->coefficient[LOAD_TORQUE]);
  velocity[0] = position[1];
  velocity[1] = 2 * position[2];
  velocity[2] = 3 * position[3];
  velocity[3] = 0.0;
}

/* After the last sample inputs stay: only HOLD sees another value there than the segment's end. */
static void signal_at_last_sample(const Simulation *sim, Signal *signal) {
  if (sim->interpolation != HOLD) return;
  signal->origin = sim->time[sim->n_samples - 1];
  signal->coefficient[MOTOR_POSITION][0] = sim->motor_position[sim->n_samples - 1];
  signal->coefficient[LOAD_TORQUE][0] = sim->load_torque[sim->n_samples - 1];
}

static void write_derivatives(const Solver *s, const double *u, double *derivatives) {
  const int m = s->n_directions;
  double nonzeros[N_OUTPUTS_JACOBIAN], column[N_OUTPUTS];
  model_outputs_jacobian(s->motion.x, u, s->p, s->motion.mode, nonzeros);
  for (int j = 0; j < m; j++) {
    multiply(&outputs_jacobian_pattern, nonzeros, s->vector + LENGTH(j), s->direction[j], N_OUTPUTS,
             column);
    for (int i = 0; i < N_OUTPUTS; i++) derivatives[i * m + j] = column[i];
  }
}

static void write_sample(const Solver *s, long long i, Simulation *sim) {
  double u[N_INPUTS];
  signal_at(&s->signal, s->motion.time, u);
  memcpy(sim->states + i * N_STATES, s->motion.x, sizeof s->motion.x);
  model_outputs(s->motion.x, u, s->p, s->motion.mode, sim->outputs + i * N_OUTPUTS);
  if (s->n_directions > 0)
    write_derivatives(s, u, sim->output_derivatives + i * N_OUTPUTS * s->n_directions);
}

static Outcome run(Solver *s, Simulation *sim) {
  for (long long i = 0; i < sim->n_samples; i++) {
    Outcome outcome = SOLVED;
    if (i > 0) outcome = solver_advance(s, sim->time[i]);
    if (outcome != SOLVED) return outcome;
    if (i + 1 < sim->n_samples)
      signal_from_samples(sim, i, &s->signal);
    else
      signal_at_last_sample(sim, &s->signal);
    outcome = solver_settle(s);
    if (outcome != SOLVED) return outcome;
    write_sample(s, i, sim);
  }
  return SOLVED;
}

/* Returns an Outcome, or -1 where memory is short. */
EXPORT int elastic_tendon_simulate(Simulation *sim) {
  const int m = (int)sim->n_directions;
  Solver s = {.p = sim->parameters,
              .tolerance = sim->tolerance,
              .n_directions = m,
              .direction = sim->direction,
              .event_time = sim->event_time,
              .event_capacity = sim->event_capacity};
  s.vector = calloc(SOLVER_MEMORY((size_t)m), sizeof(double));
  if (!s.vector) return -1;
  memcpy(s.motion.x, sim->initial_state, sizeof s.motion.x);
  for (int j = 0; j < m; j++)
    if (s.direction[j] < N_STATES) s.vector[LENGTH(j) + s.direction[j]] = 1.0;
  solver_restart(&s, sim->time[0]);
  const Outcome outcome = run(&s, sim);
  sim->statistics = s.statistics;
  sim->failure_time = s.motion.time;
  free(s.vector);
  return (int)outcome;
}

EXPORT const char *elastic_tendon_outcome(int outcome) {
  return outcome < 0 ? "memory is short" : outcome_text((Outcome)outcome);
}
