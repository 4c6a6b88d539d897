/* Life of an instance, its variables by value reference, and what follows from its state. */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "instance.h"

#define MESSAGE_SIZE 512

/* ---- log ------------------------------------------------------------------------------------- */

/* Bytes of a text, at most `most`, and no part of a character of UTF-8. */
static int whole_characters(const char *text, int most) {
  int n = 0;
  while (n < most && text[n]) n++;
  if (text[n])
    while (n > 0 && ((unsigned char)text[n] & 0xC0) == 0x80) n--;
  return n;
}

static void log_text(Instance *instance, double time, Status status, Category category,
                     const char *format, va_list arguments) {
  if (!(instance->logged & 1 << category)) return;
  char message[MESSAGE_SIZE], text[MESSAGE_SIZE + 256];
  vsnprintf(message, sizeof message, format, arguments);
  snprintf(text, sizeof text, "%.*s: %s at %.9g s: %s", whole_characters(instance->name, 100),
           instance->name, instance->call, time, message);
  instance->sink(instance, status, category, text);
}

static Status report(Instance *instance, Status status, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  log_text(instance, instance->state.motion.time, status,
           status == STATUS_ERROR     ? LOG_ERROR
           : status == STATUS_DISCARD ? LOG_DISCARD
                                      : LOG_WARNING,
           format, arguments);
  va_end(arguments);
  return status;
}

PRINTS(5, 6)
static void log_at(Instance *instance, double time, Status status, Category category,
                   const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  log_text(instance, time, status, category, format, arguments);
  va_end(arguments);
}

/* Log changes of modes; once a warning where one became 1 that the user must know of. */
static void tell_mode_changes(void *who, double time, const double *before, const double *after) {
  Instance *instance = who;
  for (int i = 0; i < N_MODES; i++) {
    if (before[i] == after[i]) continue;
    log_at(instance, time, STATUS_OK, LOG_EVENTS, "%s %g -> %g", mode_name[i], before[i], after[i]);
    if (!mode_warning[i][0] || after[i] != 1 || instance->state.warned[i]) continue;
    log_at(instance, time, STATUS_WARNING, LOG_WARNING, "%s", mode_warning[i]);
    instance->state.warned[i] = 1;
  }
}

static Status set_logging(Instance *instance, int on, size_t n, const char *const *categories) {
  int chosen = n == 0 ? ALL_CATEGORIES : 0;
  for (size_t i = 0; i < n; i++) {
    int k = 0;
    while (k < N_CATEGORIES && categories[i] && strcmp(categories[i], category_name[k])) k++;
    if (!categories[i] || k == N_CATEGORIES)
      return report(instance, STATUS_ERROR, "there is no log category %.*s",
                    categories[i] ? whole_characters(categories[i], 60) : 4,
                    categories[i] ? categories[i] : "NULL");
    chosen |= 1 << k;
  }
  instance->logged = on ? chosen : instance->logged & ~chosen;
  return STATUS_OK;
}

/* ---- life ------------------------------------------------------------------------------------ */

/* As just created, whatever came before. */
static void instance_reset(Instance *instance) {
  State *state = &instance->state;
  memset(state, 0, sizeof *state);
  instance->view.valid = 0;
  for (int i = 0; i < N_INPUTS; i++) state->connected[i] = 1;
  for (unsigned i = 0; i < N_VARIABLES; i++) store(instance, i, variables[i].start);
  memcpy(instance->solver.motion.x, state->motion.x, sizeof state->motion.x);
  solver_restart(&instance->solver, 0.0);
  memcpy(&state->motion, &instance->solver.motion, sizeof state->motion);
  state->stop_time = INFINITY;
  state->tolerance = MODEL_TOLERANCE;
  state->phase = INSTANTIATED;
}

static Instance *instance_create(const char *name, int interface) {
  const size_t length = strlen(name) + 1;
  Instance *instance = calloc(1, sizeof *instance + length);
  if (!instance) return NULL;
  memcpy(instance->name, name, length);
  instance->interface = interface;
  instance->call = "";
  instance_reset(instance);
  return instance;
}

static Status set_experiment(Instance *instance, const double *tolerance, double start,
                             const double *stop) {
  State *state = &instance->state;
  if (!isfinite(start))
    return report(instance, STATUS_ERROR, "startTime = %g is not finite", start);
  if (stop && !(isfinite(*stop) && *stop > start))
    return report(instance, STATUS_ERROR, "stopTime = %g is not after startTime = %g", *stop,
                  start);
  if (tolerance && !(*tolerance > 0 && isfinite(*tolerance)))
    return report(instance, STATUS_ERROR, "tolerance = %g is not positive", *tolerance);
  state->start_time = state->motion.time = start;
  state->stop_time = stop ? *stop : INFINITY;
  state->tolerance = tolerance ? fmin(fmax(*tolerance, SMALLEST_TOLERANCE), LARGEST_TOLERANCE)
                               : MODEL_TOLERANCE;
  state->experiment_defined = 1;
  instance->view.valid = 0;
  if (tolerance && *tolerance != state->tolerance)
    return report(instance, STATUS_WARNING, "tolerance = %g is outside %g to %g; %g is used",
                  *tolerance, SMALLEST_TOLERANCE, LARGEST_TOLERANCE, state->tolerance);
  return STATUS_OK;
}

static const char *state_name(int state) {
  for (unsigned i = 0; i < N_VARIABLES; i++)
    if (variables[i].role == ROLE_STATE && variables[i].index == state) return variables[i].name;
  return "";
}

/* ---- variables ------------------------------------------------------------------------------- */

static const char *phase_name(int phase) {
  switch (phase) {
    case INSTANTIATED: return "before initialisation";
    case INITIALISATION: return "in initialisation mode";
    case EVENT: return "in event mode";
    case CONTINUOUS: return "in continuous-time mode";
    case STEP_COMPLETE: return "between steps";
    case STEP_FAILED: return "after a failed step";
    case INTERMEDIATE: return "inside a step";
    default: return "after termination";
  }
}

/* Phases in which a variable may be set; a version of FMI may forbid its functions in some. */
static int settable(const Instance *instance, const VariableInfo *variable) {
  const int steps = STEP_COMPLETE | STEP_FAILED;
  const int between = instance->event_mode ? EVENT : EVENT | steps;
  switch (variable->role) {
    case ROLE_INPUT:
      return INSTANTIATED | INITIALISATION | EVENT | CONTINUOUS | steps | INTERMEDIATE;
    case ROLE_PARAMETER: return INSTANTIATED | INITIALISATION | (variable->tunable ? between : 0);
    case ROLE_STATE: /* also one by one, as some integrators do */
      return CONTINUOUS | (isnan(variable->start) ? 0 : INSTANTIATED | INITIALISATION);
    case ROLE_OPTION: return INSTANTIATED | INITIALISATION;
    default: return 0;
  }
}

/* For who set it at another time. */
static const char *when_set(const Instance *instance, const VariableInfo *variable) {
  const int by_steps = instance->interface == CO_SIMULATION && !instance->event_mode;
  switch (variable->role) {
    case ROLE_PARAMETER:
      return !variable->tunable ? "fixed when initialisation ends"
             : by_steps         ? "tuned between steps"
                                : "tuned in event mode";
    case ROLE_OPTION: return "fixed when initialisation ends";
    case ROLE_STATE: return isnan(variable->start) ? "calculated" : "set before initialisation ends";
    default: return "calculated";
  }
}

static const char *type_name(Type type) {
  switch (type) {
    case TYPE_REAL: return FMI_VERSION == 3 ? "Float64" : "Real";
    case TYPE_INTEGER: return FMI_VERSION == 3 ? "Int32" : "Integer";
    case TYPE_BOOLEAN: return "Boolean";
    default: return "Enumeration";
  }
}

static Status check_reference(Instance *instance, unsigned reference, int types) {
  if (reference >= N_VARIABLES)
    return report(instance, STATUS_ERROR, "there is no value reference %u", reference);
  const VariableInfo *variable = &variables[reference];
  if (!(variable->type & types))
    return report(instance, STATUS_ERROR, "%s is of type %s", variable->name,
                  type_name(variable->type));
  if (instance->state.phase == INTERMEDIATE && !instance->is_intermediate[reference])
    return report(instance, STATUS_ERROR, "%s is not one of the required intermediate variables",
                  variable->name);
  return STATUS_OK;
}

static Status check_set(Instance *instance, unsigned reference, int types, double value) {
  if (check_reference(instance, reference, types) != STATUS_OK) return STATUS_ERROR;
  const VariableInfo *variable = &variables[reference];
  if (!(settable(instance, variable) & instance->state.phase))
    return report(instance, STATUS_ERROR, "%s cannot be set %s (to %g); it is %s", variable->name,
                  phase_name(instance->state.phase), value, when_set(instance, variable));
  if (!isfinite(value))
    return report(instance, STATUS_ERROR, "%s = %g is not finite", variable->name, value);
  if (value < variable->lower || value > variable->upper)
    return report(instance, STATUS_ERROR, "%s = %g is outside %g to %g", variable->name, value,
                  variable->lower, variable->upper);
  return STATUS_OK;
}

static void store(Instance *instance, unsigned reference, double value) {
  State *state = &instance->state;
  const int i = variables[reference].index;
  switch (variables[reference].role) {
    case ROLE_INPUT: state->input[i] = value; break;
    case ROLE_STATE: state->motion.x[i] = value; break;
    case ROLE_PARAMETER:
      state->parameter[i] = value;
      state->judge_velocity = 1;
      break;
    case ROLE_OPTION: state->connected[i] = value != 0; break;
    default: return;
  }
  instance->view.valid = 0;
}

/* Make view hold what belongs to a variable that is calculated. */
static Status calculate(Instance *instance, const char *name) {
  if (instance->state.phase == INSTANTIATED)
    return report(instance, STATUS_ERROR, "%s is calculated in initialisation mode", name);
  return look(instance);
}

static Status not_finite(Instance *instance, const char *name, double value) {
  return report(instance, STATUS_DISCARD, "%s = %g is not finite", name, value);
}

static Status state_value(Instance *instance, int i, double *value) {
  *value = instance->state.motion.x[i];
  if (!isnan(*value)) return STATUS_OK;
  if (calculate(instance, state_name(i)) != STATUS_OK) return STATUS_ERROR;
  *value = instance->view.x[i];
  return STATUS_OK;
}

static double indicator(const Instance *instance, int i) {
  const View *view = &instance->view;
  double z[N_INDICATORS];
  model_indicators(view->x, view->u, instance->solver.p, view->mode, z);
  return z[i];
}

static Status judge_validity(Instance *instance, int *outside) {
  *outside = 0;
  for (unsigned i = 0; i < N_VARIABLES; i++) {
    const VariableInfo *variable = &variables[i];
    double value;
    if (variable->valid_low == -INFINITY && variable->valid_high == INFINITY) continue;
    const Status status = get(instance, i, &value);
    if (status == STATUS_ERROR) return STATUS_ERROR;
    /* what is not finite is outside too */
    *outside |= status != STATUS_OK || value < variable->valid_low || value > variable->valid_high;
  }
  return STATUS_OK;
}

static Status get(Instance *instance, unsigned reference, double *value) {
  const State *state = &instance->state;
  const VariableInfo *variable = &variables[reference];
  const int i = variable->index;
  switch (variable->role) {
    case ROLE_TIME: *value = state->motion.time; return STATUS_OK;
    case ROLE_INPUT: *value = state->input[i]; return STATUS_OK;
    case ROLE_STATE: return state_value(instance, i, value);
    case ROLE_PARAMETER: *value = state->parameter[i]; return STATUS_OK;
    case ROLE_OPTION: *value = state->connected[i]; return STATUS_OK;
    case ROLE_DERIVATIVE:
    case ROLE_INDICATOR:
    case ROLE_VALIDITY:
    case ROLE_OUTPUT: break;
  }
  if (calculate(instance, variable->name) != STATUS_OK) return STATUS_ERROR;
  if (variable->role == ROLE_VALIDITY) {
    int outside = state->outside_validity;
    if (state->phase != CONTINUOUS && judge_validity(instance, &outside) != STATUS_OK)
      return STATUS_ERROR;
    *value = outside;
    return STATUS_OK;
  }
  const View *view = &instance->view;
  *value = variable->role == ROLE_OUTPUT       ? view->outputs[i]
           : variable->role == ROLE_DERIVATIVE ? view->rates[i]
                                               : indicator(instance, i);
  if (!isfinite(*value)) return not_finite(instance, variable->name, *value);
  /* within the dead band around an event a taut spring may push */
  if (variable->role == ROLE_OUTPUT && *value < variable->lower) *value = variable->lower;
  return STATUS_OK;
}

/* ---- what follows from the state ------------------------------------------------------------- */

/* Hand the state to the solver. Inputs run on with their rates from `origin`. A velocity that is not
 * connected is the rate of its position, given or derived. */
static void load(Instance *instance, double origin) {
  const State *state = &instance->state;
  Solver *solver = &instance->solver;
  Signal *signal = &solver->signal;
  memcpy(&solver->motion, &state->motion, sizeof solver->motion);
  memcpy(instance->prepared, state->parameter, sizeof state->parameter);
  model_prepare(instance->prepared, instance->prepared + N_PARAMETERS);
  solver->p = instance->prepared;
  solver->tolerance = state->tolerance;
  solver->vector = instance->memory;
  solver->tell = NULL;
  memset(signal, 0, sizeof *signal);
  signal->origin = origin;
  for (int i = 0; i < N_INPUTS; i++) {
    signal->coefficient[i][0] = state->input[i];
    signal->coefficient[i][1] = state->input_rate[i];
  }
  for (int i = 0; i < N_INPUTS; i++) {
    const int position = rate_of[i];
    if (position < 0 || state->connected[i]) continue;
    signal->coefficient[i][0] = state->rate_given[position] ? state->input_rate[position]
                                                            : state->derived[position];
    signal->coefficient[i][1] = 0.0;
  }
}

/* Where the importer handles events, modes are frozen between them. Otherwise the view shows what
 * the modes will be with the inputs of now, without deciding it: looking has no consequences. */
static int decides_modes(const Instance *instance) {
  const int between = instance->event_mode ? 0 : STEP_COMPLETE | STEP_FAILED;
  return (instance->state.phase & (INITIALISATION | between)) != 0;
}

/* Never inlined, or each of its callers gets its own copy of the equations. */
NEVER_INLINE static Status look(Instance *instance) {
  View *view = &instance->view;
  Solver *solver = &instance->solver;
  if (view->valid) return STATUS_OK;
  const double time = instance->state.motion.time;
  load(instance, time);
  if (decides_modes(instance)) {
    const Outcome outcome = solver_settle(solver);
    if (outcome != SOLVED) return report(instance, STATUS_ERROR, "%s", outcome_text[outcome]);
  }
  memcpy(view->x, solver->motion.x, sizeof view->x);
  memcpy(view->mode, solver->motion.mode, sizeof view->mode);
  signal_at(&solver->signal, time, view->u);
  signal_rate(&solver->signal, time, view->u_rate);
  model_rates(view->x, view->u, solver->p, view->mode, view->rates);
  model_outputs(view->x, view->u, solver->p, view->mode, view->outputs);
  view->valid = 1;
  return STATUS_OK;
}
