/* Events: modes that change, states and sensitivities that jump, and where in a step they do. */
#include <math.h>
#include <string.h>

#include "solver.h"

#define MAX_EVENT_ITERATIONS 32

/* ---- what happens at an event ---------------------------------------------------------------- */

/* Row `row` of a sparse Jacobian by v, dense. */
static void jacobian_row(const Pattern *pattern, const double *nonzeros, int row, double *dense) {
  for (int j = 0; j < N_STATES + N_INPUTS + N_PARAMETERS; j++) {
    dense[j] = 0.0;
    for (int k = pattern->columns[j]; k < pattern->columns[j + 1]; k++)
      if (pattern->rows[k] == row) dense[j] = nonzeros[k];
  }
}

/* Derivative of the event's time by each direction: -(z_x s + z_v) / (dz/dt), from the indicator
 * that fired. Zero at a fixed time (fired < 0), and where the indicator only grazes zero, which is
 * counted: there the derivative does not exist. */
static void event_time_derivatives(Solver *s, int fired, double *dt) {
  const int m = s->n_directions;
  memset(dt, 0, sizeof(double) * (size_t)m);
  if (fired < 0) return;
  const double *x = s->vector;
  double u[N_INPUTS], u_rate[N_INPUTS], x_rate[N_STATES], nonzeros[N_INDICATORS_JACOBIAN];
  double by_v[N_STATES + N_INPUTS + N_PARAMETERS];
  signal_at(&s->signal, s->motion.time, u);
  signal_rate(&s->signal, s->motion.time, u_rate);
  model_rates(x, u, s->p, s->motion.mode, x_rate);
  model_indicators_jacobian(x, u, s->p, s->motion.mode, nonzeros);
  jacobian_row(&indicators_jacobian_pattern, nonzeros, fired, by_v);
  double slope = 0.0, size = 0.0;
  for (int i = 0; i < N_STATES; i++) slope += by_v[V_STATES + i] * x_rate[i];
  for (int i = 0; i < N_INPUTS; i++) slope += by_v[V_INPUTS + i] * u_rate[i];
  for (int i = 0; i < N_STATES; i++) size += fabs(by_v[V_STATES + i]) * state_nominal[i];
  if (fabs(slope) <= 1e-9 * size) {
    s->statistics.grazing++;
    return;
  }
  for (int j = 0; j < m; j++) {
    const double *column = x + LENGTH(j);
    double change = s->direction[j] >= V_PARAMETERS ? by_v[s->direction[j]] : 0.0;
    for (int i = 0; i < N_STATES; i++) change += by_v[V_STATES + i] * column[i];
    dt[j] = -change / slope;
  }
}

/* s+ = h_x s- + h_v + (h_x f- - f+) dt for one change r -> r_next, x -> x_next. */
static void jump_sensitivities(Solver *s, const double *x_next, const double *r_next,
                               const double *dt) {
  const double *x = s->vector;
  double u[N_INPUTS], before[N_STATES], after[N_STATES], nonzeros[N_RESET_JACOBIAN + 1];
  signal_at(&s->signal, s->motion.time, u);
  model_rates(x, u, s->p, s->motion.mode, before);
  model_rates(x_next, u, s->p, r_next, after);
  model_reset_jacobian(x, u, s->p, s->motion.mode, r_next, nonzeros);
  for (int j = 0; j < s->n_directions; j++) {
    double *column = s->vector + LENGTH(j), moved[N_STATES];
    for (int i = 0; i < N_STATES; i++) moved[i] = column[i] + before[i] * dt[j];
    multiply(&reset_jacobian_pattern, nonzeros, moved, s->direction[j], N_STATES, column);
    for (int i = 0; i < N_STATES; i++) column[i] -= after[i] * dt[j];
  }
}

/* Indicators anew; returns whether the modes can be judged: a number that is none would pass for a
 * sign. */
static int look_at_indicators(Solver *s, const double *u) {
  int finite = 1;
  model_indicators(s->vector, u, s->p, s->motion.mode, s->indicator);
  for (int i = 0; i < N_INDICATORS; i++) finite &= isfinite(s->indicator[i]) != 0;
  return finite;
}

/* Change modes and states until they are consistent. `fired` is the indicator that was located,
 * or -1 at a fixed time; `dt` is work of n_directions. */
static Outcome settle(Solver *s, int fired, double *dt) {
  double u[N_INPUTS], next[N_MODES], x_next[N_STATES];
  signal_at(&s->signal, s->motion.time, u);
  for (int i = 0; i < MAX_EVENT_ITERATIONS; i++) {
    if (!look_at_indicators(s, u)) return NOT_FINITE;
    model_next_modes(s->vector, u, s->p, s->motion.mode, next);
    int same = 1;
    for (int r = 0; r < N_MODES; r++) same &= next[r] == s->motion.mode[r];
    if (same && !s->motion.fresh) return SOLVED;
    if (s->tell) s->tell(s->who, s->motion.time, s->motion.mode, next);
    s->motion.fresh = 0;
    model_reset(s->vector, u, s->p, s->motion.mode, next, x_next);
    if (s->n_directions > 0) {
      if (i == 0) event_time_derivatives(s, fired, dt);
      jump_sensitivities(s, x_next, next, dt);
    }
    memcpy(s->vector, x_next, sizeof x_next);
    memcpy(s->motion.mode, next, sizeof next);
  }
  return EVENTS_DO_NOT_SETTLE;
}

/* ---- where an event is ----------------------------------------------------------------------- */

ALWAYS_INLINE void indicators_at(const Solver *s, double t, const double *x, double *z) {
  double u[N_INPUTS];
  signal_at(&s->signal, t, u);
  model_indicators(x, u, s->p, s->motion.mode, z);
}

ALWAYS_INLINE int any_change(const double *start, const double *z) {
  int changed = 0;
  for (int i = 0; i < N_INDICATORS; i++) changed |= (start[i] > 0) != (z[i] > 0);
  return changed;
}

/* Least distance of the candidates to their change of sign: positive before all, negative after
 * the first. `which` gets its index. */
static double distance(const double *start, const double *z, const int *candidate, int *which) {
  double least = INFINITY;
  for (int i = 0; i < N_INDICATORS; i++) {
    const double d = start[i] > 0 ? z[i] : -z[i];
    if (candidate[i] && d < least) {
      least = d;
      *which = i;
    }
  }
  return least;
}

/* First part of the step (0..1] after which an indicator has another sign than at the start, as
 * far as the dense output at a few points shows; 0 if none has. */
static double change_inside(const Solver *s, double h, const double *k, const double *start) {
  double x[N_STATES], z[N_INDICATORS];
  Dense dense;
  dense_fill(&dense, s->motion.implicit, h, k, LENGTH(s->n_directions));
  for (int i = 1; i < 4; i++) {
    dense_at(&dense, s->vector, 0.25 * i, x);
    indicators_at(s, s->motion.time + 0.25 * i * h, x, z);
    if (any_change(start, z)) return 0.25 * i;
  }
  return 0.0;
}

/* Shorten the step to where the first indicator has just changed its sign, by the Illinois rule on
 * whole steps, so that the event has the order of the method. `trial` gets the vector there.
 * Returns the step size, and the indicator in `fired`; h if the step h changes no sign after all. */
static double locate(Solver *s, double h, const double *start, double *k, double *trial,
                     int *fired) {
  const int m = s->n_directions;
  const double resolution = 4 * 2.3e-16 * fmax(fabs(s->motion.time), h);
  double z[N_INDICATORS], low = 0.0, high = h;
  int candidate[N_INDICATORS], which = 0;
  take_any_step(s, s->vector, m, h, k, trial);
  indicators_at(s, s->motion.time + h, trial, z);
  if (!any_change(start, z)) return h;
  for (int i = 0; i < N_INDICATORS; i++) candidate[i] = (start[i] > 0) != (z[i] > 0);
  double at_low = distance(start, start, candidate, &which);
  double at_high = distance(start, z, candidate, fired);
  double weight = 1.0; /* of the end that stays, by the Illinois rule */
  int moved = 0;       /* the end that moved last: -1 low, 1 high */
  for (int i = 0; i < 100; i++) {
    const double past = at_high * (high - low) / (at_high - at_low); /* the root, as a chord says */
    if (past <= resolution || high - low <= resolution) break;
    const double by_low = moved > 0 ? weight * at_low : at_low;
    const double by_high = moved < 0 ? weight * at_high : at_high;
    double step = high - by_high * (high - low) / (by_high - by_low);
    if (!(step > low && step < high)) step = 0.5 * (low + high);
    take_any_step(s, s->vector, m, step, k, trial);
    indicators_at(s, s->motion.time + step, trial, z);
    const double value = distance(start, z, candidate, &which);
    const int beyond = any_change(start, z) ? 1 : -1;
    weight = beyond == moved ? 0.5 * weight : 1.0;
    moved = beyond;
    if (beyond > 0) {
      high = step;
      at_high = value;
      *fired = which;
    } else {
      low = step;
      at_low = value;
    }
  }
  take_any_step(s, s->vector, m, high, k, trial);
  return high;
}
