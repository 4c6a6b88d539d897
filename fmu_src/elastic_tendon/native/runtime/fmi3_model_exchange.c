/* FMI 3.0: the functions of model exchange. */
#include "fmi3Functions.h"
#include "instance.h"

fmi3Instance fmi3InstantiateModelExchange(fmi3String instanceName, fmi3String instantiationToken,
                                          fmi3String resourcePath, fmi3Boolean visible,
                                          fmi3Boolean loggingOn,
                                          fmi3InstanceEnvironment instanceEnvironment,
                                          fmi3LogMessageCallback logMessage) {
  (void)resourcePath;
  (void)visible;
  return create(instanceName, instantiationToken, MODEL_EXCHANGE, "fmi3InstantiateModelExchange",
                loggingOn ? ALL_CATEGORIES : 0, fmi3_log, instanceEnvironment,
                (void (*)(void))logMessage);
}

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance c) {
  return (fmi3Status)enter_continuous_time(
      enter(c, "fmi3EnterContinuousTimeMode", EVENT, MODEL_EXCHANGE));
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance c, fmi3Boolean noSetFMUStatePriorToCurrentPoint,
                                       fmi3Boolean *enterEventMode,
                                       fmi3Boolean *terminateSimulation) {
  (void)noSetFMUStatePriorToCurrentPoint;
  Instance *instance = enter(c, "fmi3CompletedIntegratorStep", CONTINUOUS, MODEL_EXCHANGE);
  if (!instance || !given(instance, enterEventMode, 1, "enterEventMode") ||
      !given(instance, terminateSimulation, 1, "terminateSimulation"))
    return fmi3Error;
  *enterEventMode = fmi3False;
  *terminateSimulation = fmi3False;
  return fmi3OK;
}

fmi3Status fmi3SetTime(fmi3Instance c, fmi3Float64 time) {
  Instance *instance = enter(c, "fmi3SetTime", CONTINUOUS, MODEL_EXCHANGE);
  return instance ? (fmi3Status)set_time(instance, time) : fmi3Error;
}

fmi3Status fmi3SetContinuousStates(fmi3Instance c, const fmi3Float64 continuousStates[],
                                   size_t nContinuousStates) {
  return (fmi3Status)set_continuous_states(
      enter(c, "fmi3SetContinuousStates", CONTINUOUS, MODEL_EXCHANGE), continuousStates,
      nContinuousStates);
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance c, fmi3Float64 derivatives[],
                                             size_t nContinuousStates) {
  return (fmi3Status)get_derivatives(
      enter(c, "fmi3GetContinuousStateDerivatives",
            INITIALISATION | EVENT | CONTINUOUS | TERMINATED, MODEL_EXCHANGE),
      derivatives, nContinuousStates);
}

fmi3Status fmi3GetEventIndicators(fmi3Instance c, fmi3Float64 eventIndicators[],
                                  size_t nEventIndicators) {
  return (fmi3Status)get_event_indicators(
      enter(c, "fmi3GetEventIndicators", INITIALISATION | EVENT | CONTINUOUS | TERMINATED,
            MODEL_EXCHANGE),
      eventIndicators, nEventIndicators);
}

fmi3Status fmi3GetContinuousStates(fmi3Instance c, fmi3Float64 continuousStates[],
                                   size_t nContinuousStates) {
  return (fmi3Status)get_continuous_states(
      enter(c, "fmi3GetContinuousStates", INITIALISATION | EVENT | CONTINUOUS | TERMINATED,
            MODEL_EXCHANGE),
      continuousStates, nContinuousStates);
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance c, fmi3Float64 nominals[],
                                             size_t nContinuousStates) {
  return (fmi3Status)get_nominals(
      enter(c, "fmi3GetNominalsOfContinuousStates",
            INITIALISATION | EVENT | CONTINUOUS | TERMINATED, MODEL_EXCHANGE),
      nominals, nContinuousStates);
}

/* The size of a vector, which never changes. */
static fmi3Status size_of(fmi3Instance c, const char *call, size_t size, size_t *result) {
  Instance *instance = enter(c, call, ANY_PHASE, MODEL_EXCHANGE);
  if (!instance || !given(instance, result, 1, "the number")) return fmi3Error;
  *result = size;
  return fmi3OK;
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance c, size_t *nEventIndicators) {
  return size_of(c, "fmi3GetNumberOfEventIndicators", N_INDICATORS, nEventIndicators);
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance c, size_t *nContinuousStates) {
  return size_of(c, "fmi3GetNumberOfContinuousStates", N_STATES, nContinuousStates);
}
