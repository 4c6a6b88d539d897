/* What the façades of all versions of FMI share: guards, and calls that differ in type names only. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "instance.h"

enum {
  READABLE = INITIALISATION | EVENT | CONTINUOUS | STEP_COMPLETE | STEP_FAILED | TERMINATED,
  WRITABLE = INSTANTIATED | INITIALISATION | EVENT | CONTINUOUS | STEP_COMPLETE,
  DISCRETELY_WRITABLE = INSTANTIATED | INITIALISATION | EVENT | STEP_COMPLETE
};

/* ---- guards ---------------------------------------------------------------------------------- */

/* The instance, or NULL and a message where the call is not allowed. */
static Instance *enter(void *component, const char *call, int phases, int interfaces) {
  Instance *instance = component;
  if (!instance) return NULL;
  instance->call = call;
  if (!(instance->interface & interfaces)) {
    report(instance, STATUS_ERROR, "not a call for an instance for %s",
           instance->interface == MODEL_EXCHANGE ? "model exchange" : "co-simulation");
    return NULL;
  }
  if (!(instance->state.phase & phases)) {
    report(instance, STATUS_ERROR, "not allowed %s", phase_name(instance->state.phase));
    return NULL;
  }
  return instance;
}

static int given(Instance *instance, const void *argument, size_t n, const char *name) {
  if (argument || n == 0) return 1;
  report(instance, STATUS_ERROR, "the argument %s is NULL", name);
  return 0;
}

static int sized(Instance *instance, size_t n, size_t expected) {
  if (n == expected) return 1;
  report(instance, STATUS_ERROR, "%lu values where there are %lu", (unsigned long)n,
         (unsigned long)expected);
  return 0;
}

/* For types of which the model has no variables. */
static Status none_of(Instance *instance, const unsigned *reference, size_t n, const char *type) {
  if (!instance || !given(instance, reference, n, "valueReferences")) return STATUS_ERROR;
  if (n == 0) return STATUS_OK;
  return report(instance, STATUS_ERROR, "value reference %u is no %s", reference[0], type);
}

/* ---- messages -------------------------------------------------------------------------------- */

enum { LOG_SIZE = 2048 };

/* Copy with each of the characters `special` doubled, as the importer reads it. */
static void double_characters(const char *text, const char *special, char message[LOG_SIZE]) {
  size_t n = 0;
  for (; *text && n < LOG_SIZE - 2; text++) {
    if (strchr(special, *text)) message[n++] = *text;
    message[n++] = *text;
  }
  message[n] = '\0';
}

/* ---- life ------------------------------------------------------------------------------------ */

/* The instance, or NULL and a message where `token` is not that of this model. */
static Instance *create(const char *name, const char *token, int interface, const char *call,
                        int logged, LogSink *sink, void *environment, void (*callback)(void)) {
  Instance *instance = instance_create(name ? name : "", interface);
  if (!instance) return NULL;
  instance->call = call;
  instance->logged = logged;
  instance->sink = sink;
  instance->environment = environment;
  instance->callback = callback;
  const char *fault = !name || !name[strspn(name, " \t\r\n")] ? "the instance has no name"
                      : !token                      ? "the token (guid) is NULL"
                      : strcmp(token, MODEL_TOKEN)  ? "the token (guid) is not that of this model"
                                                    : NULL;
  if (!fault) return instance;
  report(instance, STATUS_ERROR, "%s", fault);
  free(instance);
  return NULL;
}

static Status reset(Instance *instance) {
  if (!instance) return STATUS_ERROR;
  instance_reset(instance);
  return STATUS_OK;
}

static Status terminate(Instance *instance) {
  if (!instance) return STATUS_ERROR;
  instance->state.phase = TERMINATED;
  return STATUS_OK;
}

/* ---- variables ------------------------------------------------------------------------------- */

/* All references are checked before the first is read or set, so that an error changes nothing. */
#define DEFINE_ACCESS(name, Value)                                                                 \
  static Status get_##name(Instance *instance, int types, const unsigned *reference, size_t n,     \
                           Value *value) {                                                         \
    if (!instance || !given(instance, reference, n, "valueReferences") ||                          \
        !given(instance, value, n, "values"))                                                      \
      return STATUS_ERROR;                                                                         \
    for (size_t i = 0; i < n; i++)                                                                 \
      if (check_reference(instance, reference[i], types) != STATUS_OK) return STATUS_ERROR;        \
    for (size_t i = 0; i < n; i++) {                                                               \
      double number;                                                                               \
      const Status status = get(instance, reference[i], &number);                                  \
      if (status != STATUS_OK) return status;                                                      \
      value[i] = (Value)number;                                                                    \
    }                                                                                              \
    return STATUS_OK;                                                                              \
  }                                                                                                \
                                                                                                   \
  static Status set_##name(Instance *instance, int types, const unsigned *reference, size_t n,     \
                           const Value *value) {                                                   \
    if (!instance || !given(instance, reference, n, "valueReferences") ||                          \
        !given(instance, value, n, "values"))                                                      \
      return STATUS_ERROR;                                                                         \
    for (size_t i = 0; i < n; i++)                                                                 \
      if (check_set(instance, reference[i], types, (double)value[i]) != STATUS_OK)                 \
        return STATUS_ERROR;                                                                       \
    for (size_t i = 0; i < n; i++) store(instance, reference[i], (double)value[i]);                \
    return STATUS_OK;                                                                              \
  }

/* ---- state of the instance ------------------------------------------------------------------- */

static Status state_get(Instance *instance, void **state) {
  if (!instance || !given(instance, state, 1, "FMUState")) return STATUS_ERROR;
  if (!*state) *state = malloc(sizeof(Snapshot));
  if (!*state) return report(instance, STATUS_ERROR, "memory is short");
  snapshot_take(instance, *state);
  return STATUS_OK;
}

static Status state_set(Instance *instance, const void *state) {
  if (!instance || !given(instance, state, 1, "FMUState") ||
      snapshot_check(instance, state) != STATUS_OK)
    return STATUS_ERROR;
  snapshot_restore(instance, state);
  return STATUS_OK;
}

static Status state_free(Instance *instance, void **state) {
  if (!instance || !given(instance, state, 1, "FMUState")) return STATUS_ERROR;
  free(*state);
  *state = NULL;
  return STATUS_OK;
}

static Status state_size(Instance *instance, const void *state, size_t *size) {
  if (!instance || !given(instance, state, 1, "FMUState") || !given(instance, size, 1, "size"))
    return STATUS_ERROR;
  *size = sizeof(Snapshot);
  return STATUS_OK;
}

static int fits(Instance *instance, size_t size) {
  if (size == sizeof(Snapshot)) return 1;
  report(instance, STATUS_ERROR, "a serialised state has %lu bytes, not %lu",
         (unsigned long)sizeof(Snapshot), (unsigned long)size);
  return 0;
}

static Status state_serialise(Instance *instance, const void *state, void *bytes, size_t size) {
  if (!instance || !given(instance, state, 1, "FMUState") ||
      !given(instance, bytes, 1, "serializedState") || !fits(instance, size))
    return STATUS_ERROR;
  memcpy(bytes, state, sizeof(Snapshot));
  return STATUS_OK;
}

static Status state_deserialise(Instance *instance, const void *bytes, size_t size, void **state) {
  Snapshot snapshot;
  if (!instance || !given(instance, bytes, 1, "serializedState") ||
      !given(instance, state, 1, "FMUState") || !fits(instance, size))
    return STATUS_ERROR;
  memcpy(&snapshot, bytes, sizeof snapshot); /* the bytes need not be aligned */
  if (snapshot_check(instance, &snapshot) != STATUS_OK) return STATUS_ERROR;
  if (!*state) *state = malloc(sizeof snapshot);
  if (!*state) return report(instance, STATUS_ERROR, "memory is short");
  memcpy(*state, &snapshot, sizeof snapshot);
  return STATUS_OK;
}

/* ---- derivatives ----------------------------------------------------------------------------- */

static Status output_derivatives(Instance *instance, const unsigned *reference, size_t n,
                                 const int *order, double *value) {
  if (!instance || !given(instance, reference, n, "valueReferences") ||
      !given(instance, order, n, "orders") || !given(instance, value, n, "values"))
    return STATUS_ERROR;
  for (size_t i = 0; i < n; i++)
    if (order[i] != 1) return report(instance, STATUS_ERROR, "order %d is not 1", order[i]);
  return output_rates(instance, reference, n, value);
}

/* ---- model exchange -------------------------------------------------------------------------- */

static Status get_continuous_states(Instance *instance, double *x, size_t n) {
  if (!instance || !given(instance, x, 1, "continuousStates") || !sized(instance, n, N_STATES))
    return STATUS_ERROR;
  for (int i = 0; i < N_STATES; i++)
    if (state_value(instance, i, &x[i]) != STATUS_OK) return STATUS_ERROR;
  return STATUS_OK;
}

static Status set_continuous_states(Instance *instance, const double *x, size_t n) {
  if (!instance || !given(instance, x, 1, "continuousStates") || !sized(instance, n, N_STATES))
    return STATUS_ERROR;
  return set_states(instance, x);
}

static Status get_derivatives(Instance *instance, double *derivatives, size_t n) {
  if (!instance || !given(instance, derivatives, 1, "derivatives") ||
      !sized(instance, n, N_STATES) || look(instance) != STATUS_OK)
    return STATUS_ERROR;
  for (int i = 0; i < N_STATES; i++)
    if (!isfinite(instance->view.rates[i])) /* an integrator may try a shorter step */
      return report(instance, STATUS_DISCARD, "the derivative of %s is not finite", state_name(i));
  memcpy(derivatives, instance->view.rates, sizeof instance->view.rates);
  return STATUS_OK;
}

static Status get_event_indicators(Instance *instance, double *indicators, size_t n) {
  if (!instance || !given(instance, indicators, 1, "eventIndicators") ||
      !sized(instance, n, N_INDICATORS) || look(instance) != STATUS_OK)
    return STATUS_ERROR;
  const View *view = &instance->view;
  double z[N_INDICATORS];
  model_indicators(view->x, view->u, instance->solver.p, view->mode, z);
  for (int i = 0; i < N_INDICATORS; i++)
    if (!isfinite(z[i])) return report(instance, STATUS_DISCARD, "an event indicator is not finite");
  memcpy(indicators, z, sizeof z);
  return STATUS_OK;
}

static Status get_nominals(Instance *instance, double *nominals, size_t n) {
  if (!instance || !given(instance, nominals, 1, "nominals") || !sized(instance, n, N_STATES))
    return STATUS_ERROR;
  memcpy(nominals, state_nominal, sizeof state_nominal);
  return STATUS_OK;
}

static Status enter_continuous_time(Instance *instance) {
  if (!instance) return STATUS_ERROR;
  instance->state.phase = CONTINUOUS;
  return STATUS_OK;
}
