/* FMI 2.0: the functions of model exchange. */
#include "fmi2Functions.h"
#include "instance.h"

fmi2Status fmi2EnterEventMode(fmi2Component c) {
  Instance *instance = enter(c, "fmi2EnterEventMode", EVENT | CONTINUOUS, MODEL_EXCHANGE);
  if (!instance) return fmi2Error;
  enter_event_mode(instance);
  return fmi2OK;
}

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *eventInfo) {
  Instance *instance = enter(c, "fmi2NewDiscreteStates", EVENT, MODEL_EXCHANGE);
  EventOutcome outcome = {0};
  if (!instance || !given(instance, eventInfo, 1, "eventInfo")) return fmi2Error;
  if (iterate_events(instance, &outcome) != STATUS_OK) return fmi2Error;
  *eventInfo = (fmi2EventInfo){.newDiscreteStatesNeeded = outcome.again,
                               .valuesOfContinuousStatesChanged = outcome.jumped};
  return fmi2OK;
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) {
  return (fmi2Status)enter_continuous_time(
      enter(c, "fmi2EnterContinuousTimeMode", EVENT, MODEL_EXCHANGE));
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c,
                                       fmi2Boolean noSetFMUStatePriorToCurrentPoint,
                                       fmi2Boolean *enterEventMode,
                                       fmi2Boolean *terminateSimulation) {
  (void)noSetFMUStatePriorToCurrentPoint;
  Instance *instance = enter(c, "fmi2CompletedIntegratorStep", CONTINUOUS, MODEL_EXCHANGE);
  if (!instance || !given(instance, enterEventMode, 1, "enterEventMode") ||
      !given(instance, terminateSimulation, 1, "terminateSimulation"))
    return fmi2Error;
  *enterEventMode = fmi2False;
  *terminateSimulation = fmi2False;
  return fmi2OK;
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time) {
  Instance *instance = enter(c, "fmi2SetTime", EVENT | CONTINUOUS, MODEL_EXCHANGE);
  return instance ? (fmi2Status)set_time(instance, time) : fmi2Error;
}

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t nx) {
  return (fmi2Status)set_continuous_states(
      enter(c, "fmi2SetContinuousStates", CONTINUOUS, MODEL_EXCHANGE), x, nx);
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real derivatives[], size_t nx) {
  return (fmi2Status)get_derivatives(
      enter(c, "fmi2GetDerivatives", EVENT | CONTINUOUS | TERMINATED, MODEL_EXCHANGE), derivatives,
      nx);
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real eventIndicators[], size_t ni) {
  return (fmi2Status)get_event_indicators(
      enter(c, "fmi2GetEventIndicators", INITIALISATION | EVENT | CONTINUOUS | TERMINATED,
            MODEL_EXCHANGE),
      eventIndicators, ni);
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t nx) {
  return (fmi2Status)get_continuous_states(
      enter(c, "fmi2GetContinuousStates", INITIALISATION | EVENT | CONTINUOUS | TERMINATED,
            MODEL_EXCHANGE),
      x, nx);
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x_nominal[], size_t nx) {
  return (fmi2Status)get_nominals(
      enter(c, "fmi2GetNominalsOfContinuousStates", INSTANTIATED | EVENT | CONTINUOUS | TERMINATED,
            MODEL_EXCHANGE),
      x_nominal, nx);
}
