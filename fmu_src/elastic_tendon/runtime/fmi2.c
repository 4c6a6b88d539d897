/* FMI 2.0: the functions common to model exchange and co-simulation, which one binary serves; the
 * others are in fmi2_model_exchange.c and fmi2_co_simulation.c.
 *
 * A thin façade. Each function checks that it is allowed now (the tables of sections 3.2.3 and
 * 4.2.4 of the specification) and that its arguments are there, then lets the instance do it. */
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"
#include "instance.h"

_Static_assert((int)fmi2OK == STATUS_OK && (int)fmi2Warning == STATUS_WARNING &&
                   (int)fmi2Discard == STATUS_DISCARD && (int)fmi2Error == STATUS_ERROR,
               "a Status is cast to fmi2Status");

enum {
  READABLE = INITIALISATION | EVENT | CONTINUOUS | STEP_COMPLETE | STEP_FAILED | TERMINATED,
  WRITABLE = INSTANTIATED | INITIALISATION | EVENT | CONTINUOUS | STEP_COMPLETE,
  DISCRETELY_WRITABLE = INSTANTIATED | INITIALISATION | EVENT | STEP_COMPLETE
};

/* ---- guards ---------------------------------------------------------------------------------- */

/* FMI 2 takes the message for a printf format: percent signs are doubled, no arguments follow. */
static void fmi2_log(const Instance *instance, Status status, Category category, const char *text) {
  const fmi2CallbackLogger logger = (fmi2CallbackLogger)instance->callback;
  char message[2048];
  size_t n = 0;
  if (!logger) return;
  for (; *text && n < sizeof message - 2; text++) {
    if (*text == '%') message[n++] = '%';
    message[n++] = *text;
  }
  message[n] = '\0';
  logger(instance->environment, instance->name, (fmi2Status)status, category_name[category],
         message);
}

/* The instance, or NULL and a message where the call is not allowed. */
static Instance *enter(fmi2Component component, const char *call, int phases, int interfaces) {
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

static int sized(Instance *instance, size_t n, int expected) {
  if (n == (size_t)expected) return 1;
  report(instance, STATUS_ERROR, "%lu values where there are %d", (unsigned long)n, expected);
  return 0;
}

/* ---- information and logging ----------------------------------------------------------------- */

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }

const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean loggingOn, size_t nCategories,
                               const fmi2String categories[]) {
  Instance *instance = enter(c, "fmi2SetDebugLogging", ANY_PHASE, ANY_INTERFACE);
  if (!instance || !given(instance, categories, nCategories, "categories")) return fmi2Error;
  int events = nCategories == 0;
  for (size_t i = 0; i < nCategories; i++) {
    int known = 0;
    if (!given(instance, categories[i], 1, "categories")) return fmi2Error;
    for (int k = 0; k < N_CATEGORIES; k++) known |= strcmp(categories[i], category_name[k]) == 0;
    if (!known)
      return (fmi2Status)report(instance, STATUS_ERROR, "there is no log category %.60s",
                                categories[i]);
    events |= strcmp(categories[i], category_name[LOG_EVENTS]) == 0;
  }
  if (events) instance->log_events = loggingOn; /* warnings and errors are always told */
  return fmi2OK;
}

/* ---- life ------------------------------------------------------------------------------------ */

fmi2Component fmi2Instantiate(fmi2String instanceName, fmi2Type fmuType, fmi2String fmuGUID,
                              fmi2String fmuResourceLocation,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                              fmi2Boolean loggingOn) {
  (void)fmuResourceLocation;
  (void)visible;
  if (!functions) return NULL; /* nobody to tell */
  Instance *instance = instance_create(
      instanceName ? instanceName : "",
      fmuType == fmi2ModelExchange ? MODEL_EXCHANGE : CO_SIMULATION);
  if (!instance) return NULL;
  instance->call = "fmi2Instantiate";
  instance->sink = fmi2_log;
  instance->environment = functions->componentEnvironment;
  instance->callback = (void (*)(void))functions->logger;
  instance->log_events = loggingOn;
  const char *fault = !instanceName || !*instanceName ? "the instance has no name"
                      : !fmuGUID                      ? "the argument fmuGUID is NULL"
                      : strcmp(fmuGUID, MODEL_TOKEN)  ? "fmuGUID is not that of this model"
                      : fmuType != fmi2ModelExchange && fmuType != fmi2CoSimulation
                          ? "fmuType is neither model exchange nor co-simulation"
                          : NULL;
  if (!fault) return instance;
  report(instance, STATUS_ERROR, "%s", fault);
  free(instance);
  return NULL;
}

void fmi2FreeInstance(fmi2Component c) { free(c); }

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance,
                               fmi2Real startTime, fmi2Boolean stopTimeDefined, fmi2Real stopTime) {
  Instance *instance = enter(c, "fmi2SetupExperiment", INSTANTIATED, ANY_INTERFACE);
  if (!instance) return fmi2Error;
  return (fmi2Status)set_experiment(instance, toleranceDefined ? &tolerance : NULL, startTime,
                                    stopTimeDefined ? &stopTime : NULL);
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
  Instance *instance = enter(c, "fmi2EnterInitializationMode", INSTANTIATED, ANY_INTERFACE);
  return instance ? (fmi2Status)enter_initialisation(instance) : fmi2Error;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
  Instance *instance = enter(c, "fmi2ExitInitializationMode", INITIALISATION, ANY_INTERFACE);
  return instance ? (fmi2Status)exit_initialisation(instance) : fmi2Error;
}

fmi2Status fmi2Terminate(fmi2Component c) {
  Instance *instance = enter(c, "fmi2Terminate", EVENT | CONTINUOUS | STEP_COMPLETE | STEP_FAILED,
                             ANY_INTERFACE);
  if (!instance) return fmi2Error;
  instance->state.phase = TERMINATED;
  return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c) {
  Instance *instance = enter(c, "fmi2Reset", ANY_PHASE, ANY_INTERFACE);
  if (!instance) return fmi2Error;
  instance_reset(instance);
  return fmi2OK;
}

/* ---- variables ------------------------------------------------------------------------------- */

/* All references are checked before the first is read or set, so that an error changes nothing. */
#define DEFINE_ACCESS(Name, fmi2Type_, type, writable_phases)                                      \
  fmi2Status fmi2Get##Name(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,             \
                           fmi2Type_ value[]) {                                                    \
    Instance *instance = enter(c, "fmi2Get" #Name, READABLE, ANY_INTERFACE);                       \
    if (!instance || !given(instance, vr, nvr, "vr") || !given(instance, value, nvr, "value"))     \
      return fmi2Error;                                                                            \
    for (size_t i = 0; i < nvr; i++)                                                               \
      if (check_reference(instance, vr[i], type) != STATUS_OK) return fmi2Error;                   \
    for (size_t i = 0; i < nvr; i++) {                                                             \
      double number;                                                                               \
      if (get(instance, vr[i], &number) != STATUS_OK) return fmi2Error;                            \
      value[i] = (fmi2Type_)number;                                                                \
    }                                                                                              \
    return fmi2OK;                                                                                 \
  }                                                                                                \
                                                                                                   \
  fmi2Status fmi2Set##Name(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,             \
                           const fmi2Type_ value[]) {                                              \
    Instance *instance = enter(c, "fmi2Set" #Name, writable_phases, ANY_INTERFACE);                \
    if (!instance || !given(instance, vr, nvr, "vr") || !given(instance, value, nvr, "value"))     \
      return fmi2Error;                                                                            \
    for (size_t i = 0; i < nvr; i++)                                                               \
      if (check_set(instance, vr[i], type, (double)value[i]) != STATUS_OK) return fmi2Error;       \
    for (size_t i = 0; i < nvr; i++) store(instance, vr[i], (double)value[i]);                     \
    return fmi2OK;                                                                                 \
  }

DEFINE_ACCESS(Real, fmi2Real, TYPE_REAL, WRITABLE)
DEFINE_ACCESS(Integer, fmi2Integer, TYPE_INTEGER, DISCRETELY_WRITABLE)
DEFINE_ACCESS(Boolean, fmi2Boolean, TYPE_BOOLEAN, DISCRETELY_WRITABLE)

/* The model has no strings. */
static fmi2Status no_strings(Instance *instance, const fmi2ValueReference vr[], size_t nvr,
                             const void *value) {
  if (!instance || !given(instance, vr, nvr, "vr") || !given(instance, value, nvr, "value"))
    return fmi2Error;
  if (nvr == 0) return fmi2OK;
  return (fmi2Status)report(instance, STATUS_ERROR, "value reference %u is no String", vr[0]);
}

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                         fmi2String value[]) {
  return no_strings(enter(c, "fmi2GetString", READABLE, ANY_INTERFACE), vr, nvr, value);
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                         const fmi2String value[]) {
  return no_strings(enter(c, "fmi2SetString", DISCRETELY_WRITABLE, ANY_INTERFACE), vr, nvr, value);
}

/* ---- state of the instance ------------------------------------------------------------------- */

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *FMUstate) {
  Instance *instance = enter(c, "fmi2GetFMUstate", ANY_PHASE, ANY_INTERFACE);
  if (!instance || !given(instance, FMUstate, 1, "FMUstate")) return fmi2Error;
  if (!*FMUstate) *FMUstate = malloc(sizeof(Snapshot));
  if (!*FMUstate) return (fmi2Status)report(instance, STATUS_ERROR, "memory is short");
  snapshot_take(instance, *FMUstate);
  return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate FMUstate) {
  Instance *instance = enter(c, "fmi2SetFMUstate", ANY_PHASE, ANY_INTERFACE);
  if (!instance || !given(instance, FMUstate, 1, "FMUstate") ||
      snapshot_check(instance, FMUstate) != STATUS_OK)
    return fmi2Error;
  snapshot_restore(instance, FMUstate);
  return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *FMUstate) {
  Instance *instance = enter(c, "fmi2FreeFMUstate", ANY_PHASE, ANY_INTERFACE);
  if (!instance || !given(instance, FMUstate, 1, "FMUstate")) return fmi2Error;
  free(*FMUstate);
  *FMUstate = NULL;
  return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate FMUstate, size_t *size) {
  Instance *instance = enter(c, "fmi2SerializedFMUstateSize", ANY_PHASE, ANY_INTERFACE);
  if (!instance || !given(instance, FMUstate, 1, "FMUstate") || !given(instance, size, 1, "size"))
    return fmi2Error;
  *size = sizeof(Snapshot);
  return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate FMUstate, fmi2Byte serializedState[],
                                 size_t size) {
  Instance *instance = enter(c, "fmi2SerializeFMUstate", ANY_PHASE, ANY_INTERFACE);
  if (!instance || !given(instance, FMUstate, 1, "FMUstate") ||
      !given(instance, serializedState, 1, "serializedState") ||
      !sized(instance, size, sizeof(Snapshot)))
    return fmi2Error;
  memcpy(serializedState, FMUstate, sizeof(Snapshot));
  return fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte serializedState[], size_t size,
                                   fmi2FMUstate *FMUstate) {
  Instance *instance = enter(c, "fmi2DeSerializeFMUstate", ANY_PHASE, ANY_INTERFACE);
  Snapshot snapshot;
  if (!instance || !given(instance, serializedState, 1, "serializedState") ||
      !given(instance, FMUstate, 1, "FMUstate") || !sized(instance, size, sizeof snapshot))
    return fmi2Error;
  memcpy(&snapshot, serializedState, sizeof snapshot); /* the bytes need not be aligned */
  if (snapshot_check(instance, &snapshot) != STATUS_OK) return fmi2Error;
  if (!*FMUstate) *FMUstate = malloc(sizeof snapshot);
  if (!*FMUstate) return (fmi2Status)report(instance, STATUS_ERROR, "memory is short");
  memcpy(*FMUstate, &snapshot, sizeof snapshot);
  return fmi2OK;
}

/* ---- derivatives ----------------------------------------------------------------------------- */

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference vUnknown_ref[],
                                        size_t nUnknown, const fmi2ValueReference vKnown_ref[],
                                        size_t nKnown, const fmi2Real dvKnown[],
                                        fmi2Real dvUnknown[]) {
  Instance *instance = enter(c, "fmi2GetDirectionalDerivative", READABLE, ANY_INTERFACE);
  if (!instance || !given(instance, vUnknown_ref, nUnknown, "vUnknown_ref") ||
      !given(instance, dvUnknown, nUnknown, "dvUnknown") ||
      !given(instance, vKnown_ref, nKnown, "vKnown_ref") ||
      !given(instance, dvKnown, nKnown, "dvKnown"))
    return fmi2Error;
  return (fmi2Status)directional(instance, vUnknown_ref, nUnknown, vKnown_ref, nKnown, dvKnown,
                                 dvUnknown);
}
