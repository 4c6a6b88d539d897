/* FMI 3.0: the functions common to model exchange and co-simulation, which one binary serves; the
 * others are in fmi3_model_exchange.c and fmi3_co_simulation.c.
 *
 * A thin façade. Each function checks that it is allowed now (the states of sections 2.3, 3.2 and
 * 4.2 of the specification), then lets the instance do it. */
#include <stdlib.h>

#include "fmi3Functions.h"
#include "instance.h"

_Static_assert((int)fmi3OK == STATUS_OK && (int)fmi3Warning == STATUS_WARNING &&
                   (int)fmi3Discard == STATUS_DISCARD && (int)fmi3Error == STATUS_ERROR,
               "a Status is cast to fmi3Status");

enum {
  STEP_MODE = STEP_COMPLETE | STEP_FAILED,
  INITIALISED = EVENT | CONTINUOUS | STEP_MODE,
  /* before initialisation start values can be got, inside a step what the importer asked for */
  GETTABLE = READABLE | INSTANTIATED | INTERMEDIATE,
  /* after a step that failed another one may be tried with other inputs */
  SETTABLE = WRITABLE | STEP_FAILED | INTERMEDIATE,
  DISCRETELY_SETTABLE = DISCRETELY_WRITABLE | STEP_FAILED
};

/* What stands between number signs is taken for a variable. */
static void fmi3_log(const Instance *instance, Status status, Category category, const char *text) {
  const fmi3LogMessageCallback logger = (fmi3LogMessageCallback)instance->callback;
  char message[LOG_SIZE];
  if (!logger) return;
  double_characters(text, "#", message);
  logger(instance->environment, (fmi3Status)status, category_name[category], message);
}

/* ---- information and logging ----------------------------------------------------------------- */

const char *fmi3GetVersion(void) { return fmi3Version; }

fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean loggingOn, size_t nCategories,
                               const fmi3String categories[]) {
  Instance *instance = enter(c, "fmi3SetDebugLogging", ANY_PHASE, ANY_INTERFACE);
  if (!instance || !given(instance, categories, nCategories, "categories")) return fmi3Error;
  return (fmi3Status)set_logging(instance, loggingOn, nCategories, categories);
}

/* ---- life ------------------------------------------------------------------------------------ */

/* Not from inside a step, which goes on with the instance. */
void fmi3FreeInstance(fmi3Instance c) {
  if (c && enter(c, "fmi3FreeInstance", ANY_PHASE, ANY_INTERFACE)) free(c);
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean toleranceDefined,
                                       fmi3Float64 tolerance, fmi3Float64 startTime,
                                       fmi3Boolean stopTimeDefined, fmi3Float64 stopTime) {
  Instance *instance = enter(c, "fmi3EnterInitializationMode", INSTANTIATED, ANY_INTERFACE);
  if (!instance) return fmi3Error;
  const Status status = set_experiment(instance, toleranceDefined ? &tolerance : NULL, startTime,
                                       stopTimeDefined ? &stopTime : NULL);
  if (status > STATUS_WARNING) return (fmi3Status)status;
  enter_initialisation(instance);
  return (fmi3Status)status;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance c) {
  Instance *instance = enter(c, "fmi3ExitInitializationMode", INITIALISATION, ANY_INTERFACE);
  return instance ? (fmi3Status)exit_initialisation(instance) : fmi3Error;
}

fmi3Status fmi3EnterEventMode(fmi3Instance c) {
  Instance *instance = enter(c, "fmi3EnterEventMode", CONTINUOUS | STEP_MODE, ANY_INTERFACE);
  if (!instance) return fmi3Error;
  if (instance->interface == CO_SIMULATION && !instance->event_mode)
    return (fmi3Status)report(instance, STATUS_ERROR,
                              "the instance was made with eventModeUsed = false");
  enter_event_mode(instance);
  return fmi3OK;
}

fmi3Status fmi3Terminate(fmi3Instance c) {
  return (fmi3Status)terminate(enter(c, "fmi3Terminate", INITIALISED, ANY_INTERFACE));
}

fmi3Status fmi3Reset(fmi3Instance c) {
  return (fmi3Status)reset(enter(c, "fmi3Reset", ANY_PHASE, ANY_INTERFACE));
}

/* ---- events ---------------------------------------------------------------------------------- */

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *discreteStatesNeedUpdate,
                                    fmi3Boolean *terminateSimulation,
                                    fmi3Boolean *nominalsOfContinuousStatesChanged,
                                    fmi3Boolean *valuesOfContinuousStatesChanged,
                                    fmi3Boolean *nextEventTimeDefined,
                                    fmi3Float64 *nextEventTime) {
  Instance *instance = enter(c, "fmi3UpdateDiscreteStates", EVENT, ANY_INTERFACE);
  EventOutcome outcome = {0};
  if (!instance || !given(instance, discreteStatesNeedUpdate, 1, "discreteStatesNeedUpdate") ||
      !given(instance, terminateSimulation, 1, "terminateSimulation") ||
      !given(instance, nominalsOfContinuousStatesChanged, 1, "nominalsOfContinuousStatesChanged") ||
      !given(instance, valuesOfContinuousStatesChanged, 1, "valuesOfContinuousStatesChanged") ||
      !given(instance, nextEventTimeDefined, 1, "nextEventTimeDefined") ||
      !given(instance, nextEventTime, 1, "nextEventTime"))
    return fmi3Error;
  if (iterate_events(instance, &outcome) != STATUS_OK) return fmi3Error;
  *discreteStatesNeedUpdate = outcome.again;
  *terminateSimulation = fmi3False;
  *nominalsOfContinuousStatesChanged = fmi3False;
  *valuesOfContinuousStatesChanged = outcome.jumped;
  *nextEventTimeDefined = fmi3False;
  *nextEventTime = 0.0;
  return fmi3OK;
}

/* ---- variables ------------------------------------------------------------------------------- */

/* All variables are scalars: as many values as references. */
static Instance *enter_access(fmi3Instance c, const char *call, int phases, size_t n,
                              size_t n_values) {
  Instance *instance = enter(c, call, phases, ANY_INTERFACE);
  return instance && sized(instance, n_values, n) ? instance : NULL;
}

DEFINE_ACCESS(doubles, double)
DEFINE_ACCESS(integers, fmi3Int32)
DEFINE_ACCESS(enumerations, fmi3Int64)
DEFINE_ACCESS(booleans, fmi3Boolean)

#define DEFINE_FMI3_ACCESS(Name, Value, kind, types, settable_phases)                              \
  fmi3Status fmi3Get##Name(fmi3Instance c, const fmi3ValueReference valueReferences[],             \
                           size_t nValueReferences, Value values[], size_t nValues) {              \
    return (fmi3Status)get_##kind(                                                                 \
        enter_access(c, "fmi3Get" #Name, GETTABLE, nValueReferences, nValues), types,              \
        valueReferences, nValueReferences, values);                                                \
  }                                                                                                \
  fmi3Status fmi3Set##Name(fmi3Instance c, const fmi3ValueReference valueReferences[],             \
                           size_t nValueReferences, const Value values[], size_t nValues) {        \
    return (fmi3Status)set_##kind(                                                                 \
        enter_access(c, "fmi3Set" #Name, settable_phases, nValueReferences, nValues), types,       \
        valueReferences, nValueReferences, values);                                                \
  }

DEFINE_FMI3_ACCESS(Float64, fmi3Float64, doubles, TYPE_REAL, SETTABLE)
DEFINE_FMI3_ACCESS(Int32, fmi3Int32, integers, TYPE_INTEGER, DISCRETELY_SETTABLE)
DEFINE_FMI3_ACCESS(Int64, fmi3Int64, enumerations, TYPE_ENUMERATION, DISCRETELY_SETTABLE)
DEFINE_FMI3_ACCESS(Boolean, fmi3Boolean, booleans, TYPE_BOOLEAN, DISCRETELY_SETTABLE)

/* Types of which the model has no variables. */
#define DEFINE_NO_ACCESS(Name, Value)                                                              \
  fmi3Status fmi3Get##Name(fmi3Instance c, const fmi3ValueReference valueReferences[],             \
                           size_t nValueReferences, Value values[], size_t nValues) {              \
    (void)values;                                                                                  \
    return (fmi3Status)none_of(                                                                    \
        enter_access(c, "fmi3Get" #Name, GETTABLE, nValueReferences, nValues), valueReferences,    \
        nValueReferences, #Name);                                                                  \
  }                                                                                                \
  fmi3Status fmi3Set##Name(fmi3Instance c, const fmi3ValueReference valueReferences[],             \
                           size_t nValueReferences, const Value values[], size_t nValues) {        \
    (void)values;                                                                                  \
    return (fmi3Status)none_of(                                                                    \
        enter_access(c, "fmi3Set" #Name, DISCRETELY_SETTABLE, nValueReferences, nValues),          \
        valueReferences, nValueReferences, #Name);                                                 \
  }

DEFINE_NO_ACCESS(Float32, fmi3Float32)
DEFINE_NO_ACCESS(Int8, fmi3Int8)
DEFINE_NO_ACCESS(UInt8, fmi3UInt8)
DEFINE_NO_ACCESS(Int16, fmi3Int16)
DEFINE_NO_ACCESS(UInt16, fmi3UInt16)
DEFINE_NO_ACCESS(UInt32, fmi3UInt32)
DEFINE_NO_ACCESS(UInt64, fmi3UInt64)
DEFINE_NO_ACCESS(String, fmi3String)

fmi3Status fmi3GetBinary(fmi3Instance c, const fmi3ValueReference valueReferences[],
                         size_t nValueReferences, size_t valueSizes[], fmi3Binary values[],
                         size_t nValues) {
  (void)valueSizes;
  (void)values;
  return (fmi3Status)none_of(
      enter_access(c, "fmi3GetBinary", GETTABLE, nValueReferences, nValues), valueReferences,
      nValueReferences, "Binary");
}

fmi3Status fmi3SetBinary(fmi3Instance c, const fmi3ValueReference valueReferences[],
                         size_t nValueReferences, const size_t valueSizes[],
                         const fmi3Binary values[], size_t nValues) {
  (void)valueSizes;
  (void)values;
  return (fmi3Status)none_of(
      enter_access(c, "fmi3SetBinary", DISCRETELY_SETTABLE, nValueReferences, nValues),
      valueReferences, nValueReferences, "Binary");
}

/* ---- clocks, of which there are none --------------------------------------------------------- */

#define NO_CLOCK(name, phases)                                                                     \
  return (fmi3Status)none_of(enter(c, name, phases, ANY_INTERFACE), valueReferences,               \
                             nValueReferences, "Clock")

fmi3Status fmi3GetClock(fmi3Instance c, const fmi3ValueReference valueReferences[],
                        size_t nValueReferences, fmi3Clock values[]) {
  (void)values;
  NO_CLOCK("fmi3GetClock", EVENT);
}

fmi3Status fmi3SetClock(fmi3Instance c, const fmi3ValueReference valueReferences[],
                        size_t nValueReferences, const fmi3Clock values[]) {
  (void)values;
  NO_CLOCK("fmi3SetClock", EVENT);
}

fmi3Status fmi3GetIntervalDecimal(fmi3Instance c, const fmi3ValueReference valueReferences[],
                                  size_t nValueReferences, fmi3Float64 intervals[],
                                  fmi3IntervalQualifier qualifiers[]) {
  (void)intervals;
  (void)qualifiers;
  NO_CLOCK("fmi3GetIntervalDecimal", INITIALISATION | EVENT);
}

fmi3Status fmi3GetIntervalFraction(fmi3Instance c, const fmi3ValueReference valueReferences[],
                                   size_t nValueReferences, fmi3UInt64 counters[],
                                   fmi3UInt64 resolutions[], fmi3IntervalQualifier qualifiers[]) {
  (void)counters;
  (void)resolutions;
  (void)qualifiers;
  NO_CLOCK("fmi3GetIntervalFraction", INITIALISATION | EVENT);
}

fmi3Status fmi3GetShiftDecimal(fmi3Instance c, const fmi3ValueReference valueReferences[],
                               size_t nValueReferences, fmi3Float64 shifts[]) {
  (void)shifts;
  NO_CLOCK("fmi3GetShiftDecimal", INITIALISATION | EVENT);
}

fmi3Status fmi3GetShiftFraction(fmi3Instance c, const fmi3ValueReference valueReferences[],
                                size_t nValueReferences, fmi3UInt64 counters[],
                                fmi3UInt64 resolutions[]) {
  (void)counters;
  (void)resolutions;
  NO_CLOCK("fmi3GetShiftFraction", INITIALISATION | EVENT);
}

fmi3Status fmi3SetIntervalDecimal(fmi3Instance c, const fmi3ValueReference valueReferences[],
                                  size_t nValueReferences, const fmi3Float64 intervals[]) {
  (void)intervals;
  NO_CLOCK("fmi3SetIntervalDecimal", INITIALISATION | EVENT);
}

fmi3Status fmi3SetIntervalFraction(fmi3Instance c, const fmi3ValueReference valueReferences[],
                                   size_t nValueReferences, const fmi3UInt64 counters[],
                                   const fmi3UInt64 resolutions[]) {
  (void)counters;
  (void)resolutions;
  NO_CLOCK("fmi3SetIntervalFraction", INITIALISATION | EVENT);
}

fmi3Status fmi3SetShiftDecimal(fmi3Instance c, const fmi3ValueReference valueReferences[],
                               size_t nValueReferences, const fmi3Float64 shifts[]) {
  (void)shifts;
  NO_CLOCK("fmi3SetShiftDecimal", INITIALISATION);
}

fmi3Status fmi3SetShiftFraction(fmi3Instance c, const fmi3ValueReference valueReferences[],
                                size_t nValueReferences, const fmi3UInt64 counters[],
                                const fmi3UInt64 resolutions[]) {
  (void)counters;
  (void)resolutions;
  NO_CLOCK("fmi3SetShiftFraction", INITIALISATION);
}

/* ---- what the description says is not there -------------------------------------------------- */

static fmi3Status not_there(fmi3Instance c, const char *call, const char *reason) {
  Instance *instance = enter(c, call, ANY_PHASE, ANY_INTERFACE);
  return instance ? (fmi3Status)report(instance, STATUS_ERROR, "%s", reason) : fmi3Error;
}

fmi3Status fmi3EnterConfigurationMode(fmi3Instance c) {
  return not_there(c, "fmi3EnterConfigurationMode", "there are no structural parameters");
}

fmi3Status fmi3ExitConfigurationMode(fmi3Instance c) {
  return not_there(c, "fmi3ExitConfigurationMode", "there are no structural parameters");
}

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance c) {
  return not_there(c, "fmi3EvaluateDiscreteStates", "discrete states are those of the last update");
}

fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance c, fmi3ValueReference valueReference,
                                               size_t *nDependencies) {
  (void)valueReference;
  (void)nDependencies;
  return not_there(c, "fmi3GetNumberOfVariableDependencies",
                   "all variables are scalars; modelDescription.xml has their dependencies");
}

fmi3Status fmi3GetVariableDependencies(fmi3Instance c, fmi3ValueReference dependent,
                                       size_t elementIndicesOfDependent[],
                                       fmi3ValueReference independents[],
                                       size_t elementIndicesOfIndependents[],
                                       fmi3DependencyKind dependencyKinds[], size_t nDependencies) {
  (void)dependent;
  (void)elementIndicesOfDependent;
  (void)independents;
  (void)elementIndicesOfIndependents;
  (void)dependencyKinds;
  (void)nDependencies;
  return not_there(c, "fmi3GetVariableDependencies",
                   "all variables are scalars; modelDescription.xml has their dependencies");
}

fmi3Instance fmi3InstantiateScheduledExecution(
    fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath,
    fmi3Boolean visible, fmi3Boolean loggingOn, fmi3InstanceEnvironment instanceEnvironment,
    fmi3LogMessageCallback logMessage, fmi3ClockUpdateCallback clockUpdate,
    fmi3LockPreemptionCallback lockPreemption, fmi3UnlockPreemptionCallback unlockPreemption) {
  (void)instanceName;
  (void)instantiationToken;
  (void)resourcePath;
  (void)visible;
  (void)clockUpdate;
  (void)lockPreemption;
  (void)unlockPreemption;
  if (loggingOn && logMessage)
    logMessage(instanceEnvironment, fmi3Error, category_name[LOG_ERROR],
               "this FMU is for model exchange and co-simulation, not for scheduled execution");
  return NULL;
}

fmi3Status fmi3ActivateModelPartition(fmi3Instance c, fmi3ValueReference clockReference,
                                      fmi3Float64 activationTime) {
  (void)clockReference;
  (void)activationTime;
  return not_there(c, "fmi3ActivateModelPartition", "the instance is not for scheduled execution");
}

/* ---- state of the instance ------------------------------------------------------------------- */

fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *FMUState) {
  return (fmi3Status)state_get(enter(c, "fmi3GetFMUState", ANY_PHASE, ANY_INTERFACE), FMUState);
}

fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState FMUState) {
  return (fmi3Status)state_set(enter(c, "fmi3SetFMUState", ANY_PHASE, ANY_INTERFACE), FMUState);
}

fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *FMUState) {
  return (fmi3Status)state_free(enter(c, "fmi3FreeFMUState", ANY_PHASE, ANY_INTERFACE), FMUState);
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState FMUState, size_t *size) {
  return (fmi3Status)state_size(
      enter(c, "fmi3SerializedFMUStateSize", ANY_PHASE, ANY_INTERFACE), FMUState, size);
}

fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState FMUState, fmi3Byte serializedState[],
                                 size_t size) {
  return (fmi3Status)state_serialise(enter(c, "fmi3SerializeFMUState", ANY_PHASE, ANY_INTERFACE),
                                     FMUState, serializedState, size);
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte serializedState[], size_t size,
                                   fmi3FMUState *FMUState) {
  return (fmi3Status)state_deserialise(
      enter(c, "fmi3DeserializeFMUState", ANY_PHASE, ANY_INTERFACE), serializedState, size,
      FMUState);
}

/* ---- derivatives ----------------------------------------------------------------------------- */

static int given_pairs(Instance *instance, const Pairs *pairs, const double *seed, size_t n_seed,
                       const double *sensitivity, size_t n_sensitivity) {
  return given(instance, pairs->unknown, pairs->n_unknowns, "unknowns") &&
         given(instance, pairs->known, pairs->n_knowns, "knowns") &&
         given(instance, seed, n_seed, "seed") &&
         given(instance, sensitivity, n_sensitivity, "sensitivity");
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance c, const fmi3ValueReference unknowns[],
                                        size_t nUnknowns, const fmi3ValueReference knowns[],
                                        size_t nKnowns, const fmi3Float64 seed[], size_t nSeed,
                                        fmi3Float64 sensitivity[], size_t nSensitivity) {
  Instance *instance = enter(c, "fmi3GetDirectionalDerivative", READABLE, ANY_INTERFACE);
  const Pairs pairs = {unknowns, knowns, nUnknowns, nKnowns};
  if (!instance || !sized(instance, nSeed, nKnowns) ||
      !sized(instance, nSensitivity, nUnknowns) ||
      !given_pairs(instance, &pairs, seed, nSeed, sensitivity, nSensitivity))
    return fmi3Error;
  return (fmi3Status)directional(instance, &pairs, seed, sensitivity);
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance c, const fmi3ValueReference unknowns[],
                                    size_t nUnknowns, const fmi3ValueReference knowns[],
                                    size_t nKnowns, const fmi3Float64 seed[], size_t nSeed,
                                    fmi3Float64 sensitivity[], size_t nSensitivity) {
  Instance *instance = enter(c, "fmi3GetAdjointDerivative", READABLE, ANY_INTERFACE);
  const Pairs pairs = {unknowns, knowns, nUnknowns, nKnowns};
  if (!instance || !sized(instance, nSeed, nUnknowns) ||
      !sized(instance, nSensitivity, nKnowns) ||
      !given_pairs(instance, &pairs, seed, nSeed, sensitivity, nSensitivity))
    return fmi3Error;
  return (fmi3Status)adjoint(instance, &pairs, seed, sensitivity);
}
