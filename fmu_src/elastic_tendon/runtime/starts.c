/* Calculated starts: states without a start of their own stand as NaN until the solver settles. They
 * follow from the other states; where they depend on each other they approach their values. */
#include <math.h>
#include <string.h>

#include "solver.h"

#define MAX_START_ITERATIONS 1000
#define V_LENGTH (N_STATES + N_INPUTS + N_PARAMETERS)

/* result = J direction for a sparse Jacobian by v. */
static void along(const Pattern *pattern, const double *nonzeros, const double *direction, int rows,
                  double *result) {
  for (int i = 0; i < rows; i++) result[i] = 0.0;
  for (int j = 0; j < V_LENGTH; j++)
    for (int k = pattern->columns[j]; k < pattern->columns[j + 1]; k++)
      result[pattern->rows[k]] += nonzeros[k] * direction[j];
}

/* Copy the calculated of the states `next` over `x`; returns whether one of them changed by more
 * than a share of its size and `scale`. */
static int take_calculated(const int *calculated, const double *next, const double *scale,
                           double share, double *x) {
  int changed = 0;
  for (int i = 0; i < N_STATES; i++) {
    if (!calculated[i]) continue;
    changed |= !(fabs(next[i] - x[i]) <= share * (scale[i] + fabs(x[i])));
    x[i] = next[i];
  }
  return changed;
}

static int find_calculated(const double *x, int *calculated) {
  int any = 0;
  for (int i = 0; i < N_STATES; i++) any |= calculated[i] = isnan(x[i]);
  return any;
}

/* Let the calculated states of a direction in v follow the others. Returns whether they settled. */
static int follow_starts(const int *calculated, const double *nonzeros, double *direction) {
  static const double no_scale[N_STATES];
  double next[N_STATES];
  for (int i = 0; i < N_STATES; i++)
    if (calculated[i]) direction[V_STATES + i] = 0.0;
  for (int n = 0; n < MAX_START_ITERATIONS; n++) {
    along(&starts_jacobian_pattern, nonzeros, direction, N_STATES, next);
    if (!take_calculated(calculated, next, no_scale, 1e-14, direction + V_STATES)) return 1;
  }
  return 0;
}

static Outcome start_sensitivities(Solver *s, const int *calculated) {
  double u[N_INPUTS], nonzeros[N_STARTS_JACOBIAN + 1];
  signal_at(&s->signal, s->motion.time, u);
  model_starts_jacobian(s->vector, u, s->p, s->motion.mode, nonzeros);
  for (int j = 0; j < s->n_directions; j++) {
    double direction[V_LENGTH] = {0}, *column = s->vector + LENGTH(j);
    if (s->direction[j] >= V_PARAMETERS) direction[s->direction[j]] = 1.0;
    memcpy(direction, column, sizeof(double) * N_STATES);
    if (!follow_starts(calculated, nonzeros, direction)) return STARTS_DO_NOT_SETTLE;
    memcpy(column, direction, sizeof(double) * N_STATES);
  }
  return SOLVED;
}

/* Fill in the calculated starts, with the modes that belong to them. */
static Outcome calculate_starts(Solver *s) {
  double u[N_INPUTS], start[N_STATES], next[N_MODES], *x = s->vector;
  int calculated[N_STATES];
  if (!find_calculated(x, calculated)) return SOLVED;
  signal_at(&s->signal, s->motion.time, u);
  for (int i = 0; i < N_STATES; i++)
    if (calculated[i]) x[i] = 0.0;
  for (int n = 0; n < MAX_START_ITERATIONS; n++) {
    model_starts(x, u, s->p, s->motion.mode, start);
    const int moved = take_calculated(calculated, start, state_nominal, 1e-15, x);
    model_next_modes(x, u, s->p, s->motion.mode, next);
    const int changed = memcmp(next, s->motion.mode, sizeof next) != 0;
    memcpy(s->motion.mode, next, sizeof next);
    if (!moved && !changed) return start_sensitivities(s, calculated);
  }
  return STARTS_DO_NOT_SETTLE;
}
