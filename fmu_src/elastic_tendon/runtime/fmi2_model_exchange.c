/* FMI 2.0: the functions of model exchange. */
#include <math.h>
#include <string.h>

#include "fmi2Functions.h"
#include "instance.h"

fmi2Status fmi2EnterEventMode(fmi2Component c) {
  Instance *instance = enter(c, "fmi2EnterEventMode", EVENT | CONTINUOUS, MODEL_EXCHANGE);
  if (!instance) return fmi2Error;
  if (instance->state.phase == CONTINUOUS) instance->state.jumped = 0;
  instance->state.phase = EVENT;
  return fmi2OK;
}

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *eventInfo) {
  Instance *instance = enter(c, "fmi2NewDiscreteStates", EVENT, MODEL_EXCHANGE);
  EventOutcome outcome;
  if (!instance || !given(instance, eventInfo, 1, "eventInfo") ||
      iterate_events(instance, &outcome) != STATUS_OK)
    return fmi2Error;
  *eventInfo = (fmi2EventInfo){.newDiscreteStatesNeeded = outcome.again,
                               .valuesOfContinuousStatesChanged = outcome.jumped};
  return fmi2OK;
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) {
  Instance *instance = enter(c, "fmi2EnterContinuousTimeMode", EVENT, MODEL_EXCHANGE);
  if (!instance) return fmi2Error;
  instance->state.phase = CONTINUOUS;
  return fmi2OK;
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
  Instance *instance = enter(c, "fmi2SetContinuousStates", CONTINUOUS, MODEL_EXCHANGE);
  if (!instance || !given(instance, x, 1, "x") || !sized(instance, nx, N_STATES)) return fmi2Error;
  return (fmi2Status)set_states(instance, x);
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real derivatives[], size_t nx) {
  Instance *instance =
      enter(c, "fmi2GetDerivatives", EVENT | CONTINUOUS | TERMINATED, MODEL_EXCHANGE);
  if (!instance || !given(instance, derivatives, 1, "derivatives") ||
      !sized(instance, nx, N_STATES) || look(instance) != STATUS_OK)
    return fmi2Error;
  for (int i = 0; i < N_STATES; i++)
    if (!isfinite(instance->view.rates[i])) /* an integrator may try a shorter step */
      return (fmi2Status)report(instance, STATUS_DISCARD, "the derivative of %s is not finite",
                                state_name(i));
  memcpy(derivatives, instance->view.rates, sizeof instance->view.rates);
  return fmi2OK;
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real eventIndicators[], size_t ni) {
  Instance *instance = enter(c, "fmi2GetEventIndicators",
                             INITIALISATION | EVENT | CONTINUOUS | TERMINATED, MODEL_EXCHANGE);
  if (!instance || !given(instance, eventIndicators, 1, "eventIndicators") ||
      !sized(instance, ni, N_INDICATORS) || look(instance) != STATUS_OK)
    return fmi2Error;
  const View *view = &instance->view;
  model_indicators(view->x, view->u, instance->solver.p, view->mode, eventIndicators);
  return fmi2OK;
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t nx) {
  Instance *instance = enter(c, "fmi2GetContinuousStates",
                             INITIALISATION | EVENT | CONTINUOUS | TERMINATED, MODEL_EXCHANGE);
  if (!instance || !given(instance, x, 1, "x") || !sized(instance, nx, N_STATES)) return fmi2Error;
  for (int i = 0; i < N_STATES; i++)
    if (state_value(instance, i, &x[i]) != STATUS_OK) return fmi2Error;
  return fmi2OK;
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x_nominal[], size_t nx) {
  Instance *instance = enter(c, "fmi2GetNominalsOfContinuousStates",
                             INSTANTIATED | EVENT | CONTINUOUS | TERMINATED, MODEL_EXCHANGE);
  if (!instance || !given(instance, x_nominal, 1, "x_nominal") || !sized(instance, nx, N_STATES))
    return fmi2Error;
  memcpy(x_nominal, state_nominal, sizeof state_nominal);
  return fmi2OK;
}
