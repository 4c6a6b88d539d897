/* FMI 2.0: the functions common to model exchange and co-simulation, which one binary serves; the
 * others are in fmi2_model_exchange.c and fmi2_co_simulation.c.
 *
 * A thin façade. Each function checks that it is allowed now (the tables of sections 3.2.3 and
 * 4.2.4 of the specification), then lets the instance do it. */
#include <stdlib.h>

#include "fmi2Functions.h"
#include "instance.h"

_Static_assert((int)fmi2OK == STATUS_OK && (int)fmi2Warning == STATUS_WARNING &&
                   (int)fmi2Discard == STATUS_DISCARD && (int)fmi2Error == STATUS_ERROR,
               "a Status is cast to fmi2Status");

/* FMI 2 takes the message for a printf format, which gets no arguments, and what stands between
 * number signs for a variable. */
static void fmi2_log(const Instance *instance, Status status, Category category, const char *text) {
  const fmi2CallbackLogger logger = (fmi2CallbackLogger)instance->callback;
  char message[LOG_SIZE];
  if (!logger) return;
  double_characters(text, "%#", message);
  logger(instance->environment, instance->name, (fmi2Status)status, category_name[category],
         message);
}

/* ---- information and logging ----------------------------------------------------------------- */

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }

const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean loggingOn, size_t nCategories,
                               const fmi2String categories[]) {
  Instance *instance = enter(c, "fmi2SetDebugLogging", ANY_PHASE, ANY_INTERFACE);
  if (!instance || !given(instance, categories, nCategories, "categories") ||
      set_logging(instance, loggingOn, nCategories, categories) != STATUS_OK)
    return fmi2Error;
  instance->logged |= ALWAYS_LOGGED;
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
  Instance *instance = create(instanceName, fmuGUID,
                              fmuType == fmi2ModelExchange ? MODEL_EXCHANGE : CO_SIMULATION,
                              "fmi2Instantiate", loggingOn ? ALL_CATEGORIES : ALWAYS_LOGGED,
                              fmi2_log, functions->componentEnvironment,
                              (void (*)(void))functions->logger);
  if (!instance) return NULL;
  if (fmuType == fmi2ModelExchange || fmuType == fmi2CoSimulation) return instance;
  report(instance, STATUS_ERROR, "fmuType is neither model exchange nor co-simulation");
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
  return (fmi2Status)terminate(enter(
      c, "fmi2Terminate", EVENT | CONTINUOUS | STEP_COMPLETE | STEP_FAILED, ANY_INTERFACE));
}

fmi2Status fmi2Reset(fmi2Component c) {
  return (fmi2Status)reset(enter(c, "fmi2Reset", ANY_PHASE, ANY_INTERFACE));
}

/* ---- variables ------------------------------------------------------------------------------- */

DEFINE_ACCESS(doubles, double)
DEFINE_ACCESS(integers, int)

/* Enumerations are got and set as integers. */
#define DEFINE_FMI2_ACCESS(Name, Value, kind, types, writable_phases)                              \
  fmi2Status fmi2Get##Name(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,             \
                           Value value[]) {                                                        \
    return (fmi2Status)get_##kind(enter(c, "fmi2Get" #Name, READABLE, ANY_INTERFACE), types, vr,   \
                                  nvr, value);                                                     \
  }                                                                                                \
  fmi2Status fmi2Set##Name(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,             \
                           const Value value[]) {                                                  \
    return (fmi2Status)set_##kind(enter(c, "fmi2Set" #Name, writable_phases, ANY_INTERFACE),       \
                                  types, vr, nvr, value);                                          \
  }

DEFINE_FMI2_ACCESS(Real, fmi2Real, doubles, TYPE_REAL, WRITABLE)
DEFINE_FMI2_ACCESS(Integer, fmi2Integer, integers, TYPE_INTEGER | TYPE_ENUMERATION,
                   DISCRETELY_WRITABLE)
DEFINE_FMI2_ACCESS(Boolean, fmi2Boolean, integers, TYPE_BOOLEAN, DISCRETELY_WRITABLE)

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                         fmi2String value[]) {
  (void)value;
  return (fmi2Status)none_of(enter(c, "fmi2GetString", READABLE, ANY_INTERFACE), vr, nvr, "String");
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                         const fmi2String value[]) {
  (void)value;
  return (fmi2Status)none_of(enter(c, "fmi2SetString", DISCRETELY_WRITABLE, ANY_INTERFACE), vr, nvr,
                             "String");
}

/* ---- state of the instance ------------------------------------------------------------------- */

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *FMUstate) {
  return (fmi2Status)state_get(enter(c, "fmi2GetFMUstate", ANY_PHASE, ANY_INTERFACE), FMUstate);
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate FMUstate) {
  return (fmi2Status)state_set(enter(c, "fmi2SetFMUstate", ANY_PHASE, ANY_INTERFACE), FMUstate);
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *FMUstate) {
  return (fmi2Status)state_free(enter(c, "fmi2FreeFMUstate", ANY_PHASE, ANY_INTERFACE), FMUstate);
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate FMUstate, size_t *size) {
  return (fmi2Status)state_size(
      enter(c, "fmi2SerializedFMUstateSize", ANY_PHASE, ANY_INTERFACE), FMUstate, size);
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate FMUstate, fmi2Byte serializedState[],
                                 size_t size) {
  return (fmi2Status)state_serialise(enter(c, "fmi2SerializeFMUstate", ANY_PHASE, ANY_INTERFACE),
                                     FMUstate, serializedState, size);
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte serializedState[], size_t size,
                                   fmi2FMUstate *FMUstate) {
  return (fmi2Status)state_deserialise(
      enter(c, "fmi2DeSerializeFMUstate", ANY_PHASE, ANY_INTERFACE), serializedState, size,
      FMUstate);
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
  const Pairs pairs = {vUnknown_ref, vKnown_ref, nUnknown, nKnown};
  return (fmi2Status)directional(instance, &pairs, dvKnown, dvUnknown);
}
