/* Actuators that another simulator steps: it has what they move, and gives their inputs anew after
 * each of its steps. Those of several libraries stand in one list, which one call goes through. */
#include <string.h>

#include "compilers.h"
#include "solver.h"

#define MOST_STEPS 100000 /* of the solver in one step; what needs more would keep the caller */

/* All that changes: plain data, copied to save and to roll back. */
typedef struct {
  Motion motion;
  double input[N_INPUTS]; /* at motion.time */
} Actuated;

/* What an actuator is: prepared parameters, and the states from which it starts, NaN where these are
 * calculated. */
#define N_CONSTANTS (N_PREPARED + N_STATES)

EXPORT void elastic_tendon_actuator_sizes(long long *actuated, long long *constants) {
  *actuated = (sizeof(Actuated) + sizeof(double) - 1) / sizeof(double);
  *constants = N_CONSTANTS;
}

/* What follows from parameters, which stand first, is put behind them. */
EXPORT void elastic_tendon_actuator_prepare(double *constants) {
  model_prepare(constants, constants + N_PARAMETERS);
}

/* ---- what is done with one actuator: an Act each ---------------------------------------------- */

/* An input with a rate runs as the cubic through both values and rates; its rate runs along. */
static void signal_between(const double *before, const double *after, double duration,
                           Signal *signal) {
  for (int j = 0; j < N_INPUTS; j++) {
    const int of = rate_of[j];
    if (of < 0) continue;
    const double value[] = {before[of], after[of]}, slope[] = {before[j], after[j]};
    polynomial(value, slope, 0, duration, CUBIC, signal->coefficient[of]);
    differentiate(signal->coefficient[of], signal->coefficient[j]);
  }
}

static void signal_stays(const double *input, Signal *signal) {
  memset(signal->coefficient, 0, sizeof signal->coefficient);
  for (int j = 0; j < N_INPUTS; j++) signal->coefficient[j][0] = input[j];
}

static void write_outputs(const Solver *s, const double *input, long long n, double *result) {
  double outputs[N_OUTPUTS];
  model_outputs(s->motion.x, input, s->p, s->motion.mode, outputs);
  memcpy(result, outputs, sizeof(double) * (size_t)n);
}

/* From its first state, with inputs at rest. */
EXPORT int elastic_tendon_actuator_start(void *memory, const double *constants,
                                         const EachStep *each, const double *input,
                                         double *result) {
  Actuated *actuated = memory;
  double work[SOLVER_MEMORY(0) + 1] = {0};
  Solver s = {.p = constants, .tolerance = each->tolerance, .vector = work};
  memcpy(s.motion.x, constants + N_PREPARED, sizeof s.motion.x);
  solver_restart(&s, 0.0);
  signal_stays(input, &s.signal);
  const Outcome outcome = solver_settle(&s);
  memset(actuated, 0, sizeof *actuated);
  actuated->motion = s.motion;
  memcpy(actuated->input, input, sizeof actuated->input);
  write_outputs(&s, input, each->n_results, result);
  return (int)outcome;
}

/* To where the inputs are now. Without states there is nothing to integrate: only modes follow. */
EXPORT int elastic_tendon_actuator_step(void *memory, const double *constants,
                                        const EachStep *each, const double *input,
                                        double *result) {
  Actuated *actuated = memory;
  double work[SOLVER_MEMORY(0) + 1];
  Solver s = {.motion = actuated->motion,
              .p = constants,
              .tolerance = each->tolerance,
              .vector = work,
              .most_steps = MOST_STEPS};
  const double end = s.motion.time + each->duration;
  Outcome outcome;
  if (N_STATES > 0) {
    s.signal.origin = s.motion.time;
    signal_between(actuated->input, input, each->duration, &s.signal);
    outcome = solver_settle(&s);
    if (outcome == SOLVED) outcome = solver_advance(&s, end);
  } else {
    signal_stays(input, &s.signal);
    outcome = solver_settle(&s);
  }
  if (outcome != SOLVED) return (int)outcome;
  s.motion.time = end;
  actuated->motion = s.motion;
  memcpy(actuated->input, input, sizeof actuated->input);
  write_outputs(&s, input, each->n_results, result);
  return SOLVED;
}

/* Derivatives of the first outputs by the inputs, n_results rows of N_INPUTS, with states and modes as
 * they are. */
EXPORT int elastic_tendon_actuator_derive(void *memory, const double *constants,
                                          const EachStep *each, const double *input,
                                          double *result) {
  const Actuated *actuated = memory;
  const Pattern *pattern = &outputs_jacobian_pattern;
  double nonzeros[N_OUTPUTS_JACOBIAN + 1];
  (void)input;
  model_outputs_jacobian(actuated->motion.x, actuated->input, constants, actuated->motion.mode,
                         nonzeros);
  memset(result, 0, sizeof(double) * (size_t)each->n_results * N_INPUTS);
  for (int j = 0; j < N_INPUTS; j++)
    for (int k = pattern->columns[V_INPUTS + j]; k < pattern->columns[V_INPUTS + j + 1]; k++)
      if (pattern->rows[k] < each->n_results)
        result[pattern->rows[k] * N_INPUTS + j] = nonzeros[k];
  return SOLVED;
}

/* ---- all of them ------------------------------------------------------------------------------ */

/* Let each actuator act; it may be of another library than this function. Returns the index of the
 * first that failed, whose outcome is then written, or -1. */
EXPORT long long elastic_tendon_each(const EachStep *each, const ListedActuator *listed,
                                     long long n, int *outcome) {
  for (long long i = 0; i < n; i++) {
    const ListedActuator *a = &listed[i];
    *outcome = a->act(a->memory, a->constants, each, a->input, a->result);
    if (*outcome != SOLVED) return i;
  }
  return -1;
}
