/* Calculated starts: states without a start of their own stand as NaN until the solver settles. They
 * follow from the other states, and from each other. */
#include <math.h>
#include <string.h>

#include "solver.h"

#define MAX_START_ITERATIONS 100
#define V_LENGTH (N_STATES + N_INPUTS + N_PARAMETERS)

/* result = J direction for a sparse Jacobian by v. */
static void along(const Pattern *pattern, const double *nonzeros, const double *direction, int rows,
                  double *result) {
  for (int i = 0; i < rows; i++) result[i] = 0.0;
  for (int j = 0; j < V_LENGTH; j++)
    for (int k = pattern->columns[j]; k < pattern->columns[j + 1]; k++)
      result[pattern->rows[k]] += nonzeros[k] * direction[j];
}

static int find_calculated(const double *x, int *calculated) {
  int any = 0;
  for (int i = 0; i < N_STATES; i++) any |= calculated[i] = isnan(x[i]);
  return any;
}

/* Solve (1 - A) d = b for the calculated states, A the derivative of their starts by themselves. The
 * other rows of b stay. Returns 0 where there is no solution. */
static int solve_starts(const int *calculated, const double *nonzeros, double *b) {
  double matrix[N_STATES * N_STATES] = {0};
  int pivot[N_STATES];
  const Pattern *pattern = &starts_jacobian_pattern;
  for (int j = 0; j < N_STATES; j++) {
    matrix[j * N_STATES + j] = 1.0;
    for (int k = pattern->columns[V_STATES + j]; k < pattern->columns[V_STATES + j + 1]; k++)
      if (calculated[j] && calculated[pattern->rows[k]])
        matrix[pattern->rows[k] * N_STATES + j] -= nonzeros[k];
  }
  if (!factorise(matrix, pivot, N_STATES)) return 0;
  substitute(matrix, pivot, N_STATES, b);
  return 1;
}

/* Let the calculated states of a direction in v follow the others. Returns whether they can. */
static int follow_starts(const int *calculated, const double *nonzeros, double *direction) {
  double change[N_STATES];
  for (int i = 0; i < N_STATES; i++)
    if (calculated[i]) direction[V_STATES + i] = 0.0;
  along(&starts_jacobian_pattern, nonzeros, direction, N_STATES, change);
  if (!solve_starts(calculated, nonzeros, change)) return 0;
  for (int i = 0; i < N_STATES; i++)
    if (calculated[i]) direction[V_STATES + i] = change[i];
  return 1;
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

/* Fill in the calculated starts by Newton's method, with the modes that belong to them. */
static Outcome calculate_starts(Solver *s) {
  double u[N_INPUTS], step[N_STATES], next[N_MODES], nonzeros[N_STARTS_JACOBIAN + 1];
  double *x = s->vector;
  int calculated[N_STATES];
  if (!find_calculated(x, calculated)) return SOLVED;
  signal_at(&s->signal, s->motion.time, u);
  for (int i = 0; i < N_STATES; i++)
    if (calculated[i]) x[i] = 0.0;
  for (int n = 0; n < MAX_START_ITERATIONS; n++) {
    int moved = 0;
    model_starts(x, u, s->p, s->motion.mode, step);
    model_starts_jacobian(x, u, s->p, s->motion.mode, nonzeros);
    for (int i = 0; i < N_STATES; i++) step[i] = calculated[i] ? step[i] - x[i] : 0.0;
    if (!solve_starts(calculated, nonzeros, step)) return STARTS_DO_NOT_SETTLE;
    for (int i = 0; i < N_STATES; i++) {
      moved |= !(fabs(step[i]) <= 1e-14 * (state_nominal[i] + fabs(x[i])));
      x[i] += step[i];
    }
    model_next_modes(x, u, s->p, s->motion.mode, next);
    const int changed = memcmp(next, s->motion.mode, sizeof next) != 0;
    memcpy(s->motion.mode, next, sizeof next);
    if (!moved && !changed) return start_sensitivities(s, calculated);
  }
  return STARTS_DO_NOT_SETTLE;
}
