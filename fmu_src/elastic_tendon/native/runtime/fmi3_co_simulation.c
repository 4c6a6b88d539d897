/* FMI 3.0: the functions of co-simulation. */
#include <stdlib.h>

#include "fmi3Functions.h"
#include "instance.h"

/* The states of the model are known at the end of each internal step; inputs may be set there. */
static int fmi3_intermediate(const Instance *instance, int may_stop, double *stop) {
  const fmi3IntermediateUpdateCallback update = (fmi3IntermediateUpdateCallback)instance->update;
  fmi3Boolean requested = fmi3False;
  update(instance->environment, instance->state.motion.time, fmi3True, fmi3True, fmi3True,
         may_stop != 0, &requested, stop);
  return may_stop && requested;
}

static Status require(Instance *instance, const fmi3ValueReference *reference, size_t n) {
  if (!given(instance, reference, n, "requiredIntermediateVariables")) return STATUS_ERROR;
  for (size_t i = 0; i < n; i++) {
    if (check_reference(instance, reference[i], TYPE_REAL) != STATUS_OK) return STATUS_ERROR;
    const VariableInfo *variable = &variables[reference[i]];
    if (variable->role != ROLE_INPUT && !variable->is_output)
      return report(instance, STATUS_ERROR, "%s is neither input nor output", variable->name);
    instance->is_intermediate[reference[i]] = 1;
  }
  return STATUS_OK;
}

fmi3Instance fmi3InstantiateCoSimulation(
    fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath,
    fmi3Boolean visible, fmi3Boolean loggingOn, fmi3Boolean eventModeUsed,
    fmi3Boolean earlyReturnAllowed, const fmi3ValueReference requiredIntermediateVariables[],
    size_t nRequiredIntermediateVariables, fmi3InstanceEnvironment instanceEnvironment,
    fmi3LogMessageCallback logMessage, fmi3IntermediateUpdateCallback intermediateUpdate) {
  (void)resourcePath;
  (void)visible;
  Instance *instance =
      create(instanceName, instantiationToken, CO_SIMULATION, "fmi3InstantiateCoSimulation",
             loggingOn ? ALL_CATEGORIES : 0, fmi3_log, instanceEnvironment,
             (void (*)(void))logMessage);
  if (!instance) return NULL;
  instance->event_mode = eventModeUsed;
  instance->early_return = earlyReturnAllowed;
  if (intermediateUpdate) {
    instance->intermediate = fmi3_intermediate;
    instance->update = (void (*)(void))intermediateUpdate;
  }
  if (require(instance, requiredIntermediateVariables, nRequiredIntermediateVariables) ==
      STATUS_OK)
    return instance;
  free(instance);
  return NULL;
}

fmi3Status fmi3EnterStepMode(fmi3Instance c) {
  Instance *instance = enter(c, "fmi3EnterStepMode", EVENT, CO_SIMULATION);
  if (!instance) return fmi3Error;
  instance->state.phase = STEP_COMPLETE;
  instance->view.valid = 0;
  return fmi3OK;
}

fmi3Status fmi3GetOutputDerivatives(fmi3Instance c, const fmi3ValueReference valueReferences[],
                                    size_t nValueReferences, const fmi3Int32 orders[],
                                    fmi3Float64 values[], size_t nValues) {
  Instance *instance =
      enter(c, "fmi3GetOutputDerivatives", STEP_MODE | INTERMEDIATE | TERMINATED, CO_SIMULATION);
  if (!instance || !sized(instance, nValues, nValueReferences)) return fmi3Error;
  return (fmi3Status)output_derivatives(instance, valueReferences, nValueReferences, orders,
                                        values);
}

/* After a step that failed the importer may try another one from the last good time on. */
fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 currentCommunicationPoint,
                      fmi3Float64 communicationStepSize,
                      fmi3Boolean noSetFMUStatePriorToCurrentPoint,
                      fmi3Boolean *eventHandlingNeeded, fmi3Boolean *terminateSimulation,
                      fmi3Boolean *earlyReturn, fmi3Float64 *lastSuccessfulTime) {
  (void)noSetFMUStatePriorToCurrentPoint;
  Instance *instance = enter(c, "fmi3DoStep", STEP_MODE, CO_SIMULATION);
  int at_event = 0;
  if (!instance || !given(instance, eventHandlingNeeded, 1, "eventHandlingNeeded") ||
      !given(instance, terminateSimulation, 1, "terminateSimulation") ||
      !given(instance, earlyReturn, 1, "earlyReturn") ||
      !given(instance, lastSuccessfulTime, 1, "lastSuccessfulTime"))
    return fmi3Error;
  const Status status = step(instance, currentCommunicationPoint, communicationStepSize, &at_event);
  const double reached = instance->state.motion.time;
  *eventHandlingNeeded = at_event;
  *terminateSimulation = fmi3False;
  *earlyReturn = status <= STATUS_WARNING &&
                 reached < currentCommunicationPoint + communicationStepSize;
  *lastSuccessfulTime = reached;
  return (fmi3Status)status;
}
