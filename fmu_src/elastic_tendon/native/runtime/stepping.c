/* Initialisation, events of model exchange, steps of co-simulation. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "instance.h"

/* Importers add up their communication points: equal times may differ in rounding. */
static double time_slack(double time) { return 1e-9 * (1.0 + fabs(time)); }

/* ---- initialisation -------------------------------------------------------------------------- */

static int any_in_column(const Pattern *pattern, const double *nonzeros, int column) {
  for (int k = pattern->columns[column]; k < pattern->columns[column + 1]; k++)
    if (nonzeros[k] != 0) return 1;
  return 0;
}

/* Whether the model uses an input that is not connected. */
static int uses_unconnected(const Instance *instance, const double *mode) {
  const View *view = &instance->view;
  const double *p = instance->solver.p;
  double rates[N_RATES_JACOBIAN], outputs[N_OUTPUTS_JACOBIAN];
  model_rates_jacobian(view->x, view->u, p, mode, rates);
  model_outputs_jacobian(view->x, view->u, p, mode, outputs);
  for (int i = 0; i < N_INPUTS; i++)
    if (!instance->state.connected[i] &&
        (any_in_column(&rates_jacobian_pattern, rates, V_INPUTS + i) ||
         any_in_column(&outputs_jacobian_pattern, outputs, V_INPUTS + i)))
      return 1;
  return 0;
}

static Status enter_initialisation(Instance *instance) {
  if (!instance->state.experiment_defined)
    return report(instance, STATUS_ERROR, "the experiment has not been set up");
  instance->state.phase = INITIALISATION;
  instance->view.valid = 0;
  return STATUS_OK;
}

/* A tendon that is slack may need the velocity once it is taut. Judged again when a parameter has been
 * tuned; told once. Needs a valid view. */
static void judge_velocity(Instance *instance) {
  State *state = &instance->state;
  state->judge_velocity = 0;
  if (state->velocity_warned || !(uses_unconnected(instance, instance->view.mode) ||
                                  uses_unconnected(instance, mode_start)))
    return;
  state->velocity_warned = 1;
  report(instance, STATUS_WARNING,
         "the model needs motor_velocity: connect it and set motor_velocity_connected to true; until "
         "then the velocity is %s",
         instance->interface == MODEL_EXCHANGE ? "0"
         : FMI_VERSION == 2
             ? "the derivative of motor_position where that is set, else its difference between steps"
             : "the difference of motor_position between steps");
}

static Status exit_initialisation(Instance *instance) {
  State *state = &instance->state;
  if (look(instance) != STATUS_OK) return STATUS_ERROR;
  const View *view = &instance->view;
  for (int i = 0; i < N_STATES; i++)
    if (!isfinite(view->rates[i]))
      return report(instance, STATUS_ERROR, "the derivative of %s is not finite", state_name(i));
  if (state->judge_velocity) judge_velocity(instance);
  tell_mode_changes(instance, state->motion.time, state->motion.mode, view->mode);
  state->earlier_time = state->motion.time;
  state->jumped = memcmp(state->motion.x, view->x, sizeof view->x) != 0;
  memcpy(state->motion.x, view->x, sizeof view->x);
  memcpy(state->motion.mode, view->mode, sizeof view->mode);
  state->phase =
      instance->interface == MODEL_EXCHANGE || instance->event_mode ? EVENT : STEP_COMPLETE;
  instance->view.valid = 0;
  return STATUS_OK;
}

/* ---- events ---------------------------------------------------------------------------------- */

static void enter_event_mode(Instance *instance) {
  State *state = &instance->state;
  if (state->phase != EVENT) state->jumped = 0;
  state->phase = EVENT;
  instance->view.valid = 0;
}

/* No look at stop_time: integrators try times beyond the end of their step. */
static Status set_time(Instance *instance, double time) {
  State *state = &instance->state;
  if (!isfinite(time) || time < state->start_time - time_slack(state->start_time))
    return report(instance, STATUS_ERROR, "time = %g is not finite or before the start", time);
  state->motion.time = time;
  instance->view.valid = 0;
  return STATUS_OK;
}

static Status set_states(Instance *instance, const double *x) {
  for (int i = 0; i < N_STATES; i++)
    if (!isfinite(x[i]))
      return report(instance, STATUS_ERROR, "%s = %g is not finite", state_name(i), x[i]);
  memcpy(instance->state.motion.x, x, sizeof instance->state.motion.x);
  instance->view.valid = 0;
  return STATUS_OK;
}

static int past_stop(const Instance *instance, double time) {
  const double stop = instance->state.stop_time;
  return time > stop + time_slack(stop);
}

/* Hand the state to the solver, with inputs that hold with their rates from `origin` on, and make it
 * consistent. Changes of modes are told. */
static Outcome start_from(Instance *instance, double origin) {
  load(instance, origin);
  instance->solver.tell = tell_mode_changes;
  instance->solver.who = instance;
  return solver_settle(&instance->solver);
}

/* `jumped` stays until event mode is entered anew: importers look at it after the last call. */
static Status iterate_events(Instance *instance, EventOutcome *result) {
  State *state = &instance->state;
  Motion *motion = &instance->solver.motion;
  if (past_stop(instance, state->motion.time))
    return report(instance, STATUS_ERROR, "the time is past stopTime = %g s", state->stop_time);
  int warned[N_MODES];
  memcpy(warned, state->warned, sizeof warned);
  const Outcome outcome = start_from(instance, state->motion.time);
  if (outcome != SOLVED) {
    memcpy(state->warned, warned, sizeof warned); /* an error changes nothing */
    return report(instance, STATUS_ERROR, "%s", outcome_text[outcome]);
  }
  const int jumped = memcmp(motion->x, state->motion.x, sizeof motion->x) != 0;
  const int changed = memcmp(motion->mode, state->motion.mode, sizeof motion->mode) != 0;
  memcpy(&state->motion, motion, sizeof *motion);
  state->jumped |= jumped;
  instance->view.valid = 0;
  result->again = changed || jumped;
  result->jumped = state->jumped;
  if (state->judge_velocity && look(instance) == STATUS_OK) judge_velocity(instance);
  return judge_validity(instance, &state->outside_validity);
}

/* ---- co-simulation --------------------------------------------------------------------------- */

static Status check_step(Instance *instance, double from, double h) {
  const State *state = &instance->state;
  const double time = state->motion.time;
  /* a small share of the step, but never less than rounding */
  const double slack = fmin(time_slack(time), fmax(0.01 * h, 4 * DBL_EPSILON * fabs(time)));
  if (!(h > 0 && isfinite(h)))
    return report(instance, STATUS_ERROR, "the step size %g s is not positive", h);
  if (!(fabs(from - time) <= slack))
    return report(instance, STATUS_ERROR, "the step starts at %.15g s, not at %.15g s: %.3g s off",
                  from, time, from - time);
  if (past_stop(instance, from + h))
    return report(instance, STATUS_ERROR, "the step to %.15g s is past stopTime = %g s", from + h,
                  state->stop_time);
  return STATUS_OK;
}

/* What is left of a communication step: inputs hold with their rates from `origin` on. */
typedef struct {
  double origin, end;
} Span;

/* The solver's motion becomes the state; the inputs are where their rates have brought them. */
static void take_over(Instance *instance, Span *span) {
  State *state = &instance->state;
  const Motion *motion = &instance->solver.motion;
  memcpy(&state->motion, motion, sizeof *motion);
  for (int i = 0; i < N_INPUTS; i++)
    state->input[i] += state->input_rate[i] * (motion->time - span->origin);
  span->origin = motion->time;
  instance->view.valid = 0;
}

/* Rates of the inputs that an unconnected one is the rate of, from their values now and at the last
 * point at which these were known. Points that rounding alone sets apart are one. */
static void derive_velocity(State *state) {
  const double passed = state->motion.time - state->earlier_time;
  const int apart = passed > time_slack(state->motion.time);
  if (!apart && passed > 0) return;
  for (int i = 0; i < N_INPUTS; i++) {
    if (apart) state->derived[i] = (state->input[i] - state->earlier[i]) / passed;
    state->earlier[i] = state->input[i];
  }
  state->earlier_time = state->motion.time;
}

/* Inside a communication step, after an event too, a position that has not changed was not set. */
static void derive_velocity_inside(State *state) {
  for (int i = 0; i < N_INPUTS; i++)
    if (rate_of[i] >= 0 && state->input[rate_of[i]] != state->earlier[rate_of[i]]) {
      derive_velocity(state);
      return;
    }
}

/* Integrate to the end of the span, with a look for the importer after each step of the solver: it
 * may set inputs and bring the end nearer. */
static Outcome advance_watched(Instance *instance, Span *span) {
  State *state = &instance->state;
  const char *call = instance->call; /* the importer's look makes calls of its own */
  Outcome outcome = SOLVED;
  instance->solver.single_step = 1;
  while (outcome == SOLVED && state->motion.time < span->end) {
    outcome = solver_advance(&instance->solver, span->end);
    if (outcome != SOLVED && outcome != AT_EVENT) break;
    take_over(instance, span);
    double stop = span->end;
    state->phase = INTERMEDIATE;
    if (instance->intermediate(instance, instance->early_return, &stop))
      span->end = fmin(fmax(stop, state->motion.time), span->end);
    state->phase = STEP_COMPLETE;
    derive_velocity_inside(state);
    instance->call = call;
    if (outcome == SOLVED) outcome = start_from(instance, span->origin);
  }
  instance->solver.single_step = 0;
  return outcome;
}

static Status step(Instance *instance, double from, double h, int *at_event) {
  State *state = &instance->state;
  Solver *solver = &instance->solver;
  Span span = {from, from + h};
  if (check_step(instance, from, h) != STATUS_OK) return STATUS_ERROR;
  if (state->at_event)
    derive_velocity_inside(state);
  else
    derive_velocity(state);
  Outcome outcome = start_from(instance, from);
  if (outcome == SOLVED) {
    solver->stop_at_events = instance->event_mode && instance->early_return;
    outcome = instance->intermediate ? advance_watched(instance, &span)
                                     : solver_advance(solver, span.end);
    if (outcome == SOLVED) solver->motion.time = span.end; /* also where h is below resolution */
    take_over(instance, &span);
  }
  *at_event = state->at_event = outcome == AT_EVENT;
  const int done = outcome == SOLVED || *at_event;
  state->phase = done ? STEP_COMPLETE : STEP_FAILED;
  if (done && state->judge_velocity && look(instance) == STATUS_OK) judge_velocity(instance);
  state->last_step = done ? STATUS_OK : STATUS_DISCARD;
  if (done) return STATUS_OK;
  return report(instance, STATUS_DISCARD, "no step to %.9g s: %s", from + h, outcome_text[outcome]);
}
