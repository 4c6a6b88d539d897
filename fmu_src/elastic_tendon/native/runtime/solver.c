#include <math.h>
#include <string.h>
#include <time.h>

#include "solver.h"

#include "methods.c"

#include "events.c"

#include "starts.c"

#ifndef MAX_STEPS /* tests with random numbers wait for less */
#define MAX_STEPS 10000000
#endif
#define SMALLEST_STEP 1e-18 /* s; near time zero, rounding alone would let steps shrink forever */
#define MAX_EVENTS 100000 /* in one call; no machine changes its modes so often, but a chatter does */
#define MAX_EVENTS_AT_ONE_TIME 64
#define LONG_STEP 0.005 /* squared error of a step two thirds of what accuracy allows */
#define NO_ERROR 1e-20   /* squared error of a motion that the method integrates exactly */
#define STEPS_TO_ASK 64 /* before the caller is asked again whether to stop */
#define STEPS_TO_JUDGE 20 /* before the choice of method is judged */

static void solver_restart(Solver *s, double time) {
  s->motion.time = time;
  s->motion.fresh = 1;
  s->motion.step = 0.0;
  s->motion.implicit = 0;
  s->motion.judged = 0;
  s->motion.span = 0.0;
  memcpy(s->motion.mode, mode_start, sizeof s->motion.mode);
}

/* First step: a hundredth of the time in which the states change by their own size. */
static double initial_step(const double *x, const double *x_rate) {
  double fastest = 0.0;
  for (int i = 0; i < N_STATES; i++)
    fastest = fmax(fastest, fabs(x_rate[i]) / (state_nominal[i] + fabs(x[i])));
  return 0.01 / (fastest + 1.0);
}

/* Factor for the next step from the squared error norm, between 0.2 and 5. */
static double step_factor(double squared_error, int implicit) {
  if (!isfinite(squared_error)) return 0.2;
  const double factor = 0.9 * pow(squared_error, implicit ? -1.0 / 8 : -1.0 / 10);
  return factor > 5.0 ? 5.0 : factor < 0.2 ? 0.2 : factor;
}

/* Largest modulus of the eigenvalues, from repeated squaring (Gelfand's formula); 0 where it shows
 * early that it is less than `enough`. */
static double spectral_radius(const double *matrix, double enough) {
  double a[N_STATES * N_STATES], b[N_STATES * N_STATES], log_radius = 0.0, power = 1.0;
  const double log_enough = log(enough);
  memcpy(a, matrix, sizeof a);
  for (int squarings = 0; squarings < 6; squarings++) {
    double size = 0.0;
    for (int i = 0; i < N_STATES * N_STATES; i++) size = fmax(size, fabs(a[i]));
    if (!(size > 0)) return 0.0;
    log_radius += log(size) * power;
    /* no eigenvalue of a matrix is larger than its largest entry times its rows */
    if (log_radius + log(N_STATES) * power < log_enough) return 0.0;
    power /= 2;
    for (int i = 0; i < N_STATES * N_STATES; i++) a[i] /= size;
    for (int j = 0; j < N_STATES; j++)
      for (int i = 0; i < N_STATES; i++) {
        b[j * N_STATES + i] = 0.0;
        for (int l = 0; l < N_STATES; l++)
          b[j * N_STATES + i] += a[l * N_STATES + i] * a[j * N_STATES + l];
      }
    memcpy(a, b, sizeof a);
  }
  return exp(log_radius);
}

static double stiffness(Solver *s, double enough) {
  double jacobian[N_STATES * N_STATES];
  jacobian_at(s, s->motion.time, s->vector, jacobian);
  return spectral_radius(jacobian, enough);
}

/* Choose the method for the next steps by step size times spectral radius: Dormand-Prince is
 * stable up to about 3, so a mean near it says that stability, not accuracy, limits the step;
 * a step of Radau costs as much as several explicit ones. */
ALWAYS_INLINE void judge_stiffness(Solver *s, double h) {
  Motion *motion = &s->motion;
  motion->span += h;
  if (++motion->judged < STEPS_TO_JUDGE) return;
  const double pace = stiffness(s, 0.0) * motion->span / motion->judged;
  motion->implicit = motion->implicit ? pace > 5.0 : pace > 2.5;
  motion->judged = 0;
  motion->span = 0.0;
}

/* A state that rests where it is attracted strongly, as saturated hysteresis, has no error in an
 * unstable step, but its sensitivities, which do not choose the step, grow without bound. */
ALWAYS_INLINE void keep_sensitivities_stable(Solver *s, double h) {
  Motion *motion = &s->motion;
  if (motion->implicit || h * stiffness(s, 3.0 / h) <= 3.0) return;
  motion->implicit = 1;
  motion->judged = 0;
  motion->span = 0.0;
}

/* Whether the caller wants to stop. Asked once a second: it may have to wait for Python's lock. */
static int interrupted(const Solver *s) {
  if (!s->interrupted) return 0;
  const long long now = (long long)time(NULL);
  if (now == *s->second) return 0;
  *s->second = now;
  return s->interrupted();
}

/* The present vector's rates, into k[0], anew. */
ALWAYS_INLINE Outcome refresh(Solver *s, int m, double *k) {
  const Frozen frozen = freeze(s);
  rates_at(&frozen, s->direction, s->motion.time, s->vector, m, k);
  s->statistics.rates++;
  for (int i = 0; i < N_STATES; i++)
    if (!isfinite(k[i])) return NOT_FINITE;
  return SOLVED;
}

/* Shorten a step in which an indicator changes, move there and settle. */
static Outcome handle_event(Solver *s, double h, const double *start, double *k, double *trial) {
  int fired = -1; /* stays so where no whole step confirms what the dense output saw */
  s->motion.time += locate(s, h, start, k, trial, &fired);
  memcpy(s->vector, trial, sizeof(double) * LENGTH(s->n_directions));
  if (fired >= 0) {
    if (s->statistics.events < s->event_capacity)
      s->event_time[s->statistics.events] = s->motion.time;
    s->statistics.events++;
    if (s->stop_at_events) return AT_EVENT;
  }
  return settle(s, fired, k);
}

ALWAYS_INLINE Outcome advance(Solver *s, double t_end, int m) {
  const int n = LENGTH(m);
  double *y = s->vector, *trial = y + n, *k = trial + n;
  double start[N_INDICATORS], z[N_INDICATORS];
  int at_one_time = 0, events = 0;
  Motion *motion = &s->motion;
  memcpy(start, s->indicator, sizeof start);
  Outcome outcome = s->warm ? SOLVED : refresh(s, m, k);
  s->warm = 0;
  if (motion->step <= 0.0) motion->step = initial_step(y, k);

  for (long long count = 0; outcome == SOLVED && motion->time < t_end; count++) {
    const double remaining = t_end - motion->time;
    const int to_end = motion->step >= remaining;
    const double h = to_end ? remaining : motion->step;
    if (count > MAX_STEPS || (s->most_steps && s->statistics.steps > s->most_steps))
      return TOO_MANY_STEPS;
    if (count % STEPS_TO_ASK == 0 && interrupted(s)) return INTERRUPTED;
    if (motion->time + h == motion->time || (!to_end && h < SMALLEST_STEP)) return STEP_TOO_SMALL;

    if (m > 0) keep_sensitivities_stable(s, h);
    const int implicit = motion->implicit;
    const double error =
        m > 0 ? take_any_step(s, y, m, h, k, trial) : take_step(s, y, 0, h, k, trial);
    if (!(error <= 1.0)) {
      motion->step = h * step_factor(error, implicit);
      s->statistics.rejected++;
      continue;
    }
    s->statistics.steps++;
    if (!to_end) motion->step = h * step_factor(error, implicit);

    /* in a step as long as accuracy allows, and in one without error, as while the joint sticks,
     * an indicator may change and change back, also where another one stays changed */
    indicators_at(s, motion->time + h, trial, z);
    double part = any_change(start, z);
    if (error > LONG_STEP || error < NO_ERROR) {
      const double inside = change_inside(s, h, k, start);
      if (inside > 0.0) part = inside;
    }
    if (part > 0.0) {
      if (++events > MAX_EVENTS) return TOO_MANY_EVENTS;
      const double before = motion->time;
      outcome = handle_event(s, part * h, start, k, trial);
      if (motion->time > t_end) motion->time = t_end;
      at_one_time = motion->time - before > 1e-13 * (1.0 + fabs(before)) ? 0 : at_one_time + 1;
      if (at_one_time > MAX_EVENTS_AT_ONE_TIME) outcome = EVENTS_DO_NOT_SETTLE;
      memcpy(start, s->indicator, sizeof start);
      if (outcome == SOLVED) outcome = refresh(s, m, k);
      if (s->single_step) return outcome;
      continue;
    }
    motion->time = to_end ? t_end : motion->time + h;
    memcpy(y, trial, sizeof(double) * (size_t)n);
    memcpy(start, z, sizeof z);
    if (implicit)
      outcome = refresh(s, m, k);
    else
      memcpy(k, k + 6 * n, sizeof(double) * (size_t)n);
    if (implicit || !to_end) judge_stiffness(s, h);
    if (s->single_step) return outcome;
  }
  memcpy(s->indicator, start, sizeof start);
  s->warm = outcome == SOLVED;
  return outcome;
}

static Outcome solver_settle(Solver *s) {
  s->warm = 0;
  double *work = s->vector + LENGTH(s->n_directions);
  memcpy(s->vector, s->motion.x, sizeof s->motion.x);
  Outcome outcome = s->motion.fresh ? calculate_starts(s) : SOLVED;
  if (outcome == SOLVED) outcome = settle(s, -1, work);
  memcpy(s->motion.x, s->vector, sizeof s->motion.x);
  return outcome;
}

static Outcome solver_advance(Solver *s, double t_end) {
  memcpy(s->vector, s->motion.x, sizeof s->motion.x);
  const Outcome outcome = s->n_directions == 0 ? advance(s, t_end, 0)
                                               : advance(s, t_end, s->n_directions);
  memcpy(s->motion.x, s->vector, sizeof s->motion.x);
  return outcome;
}
