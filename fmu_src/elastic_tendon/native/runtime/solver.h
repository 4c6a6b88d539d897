/* Integration of the hybrid system between communication points or samples.
 *
 * Explicit Dormand-Prince 5(4), with a switch to Radau IIA (order 5) where stiffness limits the
 * step. Events are located by bracketing with frozen modes. Forward sensitivities are carried
 * along on request and jump at events. No allocation, no globals.
 */
#ifndef SOLVER_H
#define SOLVER_H

#include "model.h"
#include "shared.h"

/* Inputs as cubic polynomials of (t - origin). */
typedef struct {
  double origin;
  double coefficient[N_INPUTS][4];
} Signal;

/* Everything that changes while integrating: plain data, copied to save and to roll back. */
typedef struct {
  double time;
  double x[N_STATES];
  double mode[N_MODES];
  int fresh;     /* 1 until states have been made consistent with the modes after a restart */
  double step;   /* step size to try next, s; 0: not yet chosen */
  int implicit;  /* 1 while Radau integrates */
  int judged;    /* steps since the choice of method was last judged, */
  double span;   /* and their sum, s */
} Motion;

typedef struct {
  Motion motion;
  Signal signal;
  const double *p;      /* N_PREPARED numbers, see model.h */
  double tolerance;     /* relative, and absolute in units of the states' nominals */
  int n_directions;     /* sensitivities: number of columns, */
  const int *direction; /* for each the index in v, */
  double *vector;       /* and SOLVER_MEMORY(n_directions) doubles, of which the first
                           N_STATES * (1 + n_directions) are x, dx/dv_1, dx/dv_2, ... */
  double indicator[N_INDICATORS]; /* at the present vector */
  int warm;             /* 1 while the present vector's rates stand where the next step looks */
  int stop_at_events;   /* leave events to the caller */
  int single_step;      /* return after each step */
  /* optional: told of each change of modes, at its time in s */
  void (*tell)(void *who, double time, const double *before, const double *after);
  void *who;
  double *event_time;   /* optional record of the first event_capacity events, s */
  long long event_capacity;
  long long most_steps;      /* optional: in all, after which it is given up */
  Interrupted *interrupted;  /* optional: asked whether to stop, */
  long long *second;         /* and when that was last, s since 1970 */
  Statistics statistics;
} Solver;

/* Present and trial vector and seven stages. */
#define SOLVER_MEMORY(directions) (9 * N_STATES * (1 + (directions)))

/* Start afresh at a time, from the states in motion.x: modes and solver memory as at creation. A
 * state that is NaN gets its calculated start when the solver settles. */
static void solver_restart(Solver *s, double time);

/* Make modes and states consistent with inputs, parameters and states at the present time; call
 * it after a restart and after every change of these. */
static Outcome solver_settle(Solver *s);

/* Integrate to exactly t_end, or as far as stop_at_events and single_step let, from where the solver
 * has settled or was; the inputs may go on as another polynomial, but not jump. On failure the motion
 * stays at the last good time. */
static Outcome solver_advance(Solver *s, double t_end);

#endif
