/* FMI 2.0: the functions of co-simulation. */
#include <math.h>

#include "fmi2Functions.h"
#include "instance.h"

enum { STEPPED = STEP_COMPLETE | STEP_FAILED | TERMINATED };

static Status check_input_rate(Instance *instance, unsigned reference, int order, double value) {
  if (check_reference(instance, reference, TYPE_REAL) != STATUS_OK) return STATUS_ERROR;
  const char *name = variables[reference].name;
  if (variables[reference].role != ROLE_INPUT)
    return report(instance, STATUS_ERROR, "%s is no input", name);
  if (order != 1)
    return report(instance, STATUS_ERROR, "derivative of order %d of %s: only order 1 is used",
                  order, name);
  if (!isfinite(value))
    return report(instance, STATUS_ERROR, "the derivative %g of %s is not finite", value, name);
  return STATUS_OK;
}

static void store_input_rate(Instance *instance, unsigned reference, double value) {
  State *state = &instance->state;
  const int i = variables[reference].index;
  state->input_rate[i] = value;
  state->rate_given[i] = 1;
  instance->view.valid = 0;
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                       const fmi2Integer order[], const fmi2Real value[]) {
  Instance *instance = enter(c, "fmi2SetRealInputDerivatives",
                             INSTANTIATED | INITIALISATION | STEP_COMPLETE, CO_SIMULATION);
  if (!instance || !given(instance, vr, nvr, "vr") || !given(instance, order, nvr, "order") ||
      !given(instance, value, nvr, "value"))
    return fmi2Error;
  for (size_t i = 0; i < nvr; i++)
    if (check_input_rate(instance, vr[i], order[i], value[i]) != STATUS_OK) return fmi2Error;
  for (size_t i = 0; i < nvr; i++) store_input_rate(instance, vr[i], value[i]);
  return fmi2OK;
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                        const fmi2Integer order[], fmi2Real value[]) {
  return (fmi2Status)output_derivatives(
      enter(c, "fmi2GetRealOutputDerivatives", STEPPED, CO_SIMULATION), vr, nvr, order, value);
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real currentCommunicationPoint,
                      fmi2Real communicationStepSize,
                      fmi2Boolean noSetFMUStatePriorToCurrentPoint) {
  (void)noSetFMUStatePriorToCurrentPoint;
  Instance *instance = enter(c, "fmi2DoStep", STEP_COMPLETE, CO_SIMULATION);
  int at_event; /* never: events are handled inside */
  if (!instance) return fmi2Error;
  return (fmi2Status)step(instance, currentCommunicationPoint, communicationStepSize, &at_event);
}

/* Steps are never in progress when fmi2DoStep has returned. */
fmi2Status fmi2CancelStep(fmi2Component c) {
  enter(c, "fmi2CancelStep", 0, CO_SIMULATION);
  return fmi2Error;
}

/* What a status function cannot tell. */
static fmi2Status untold(Instance *instance) {
  return (fmi2Status)report(instance, STATUS_DISCARD, "there is no status of this kind and type");
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind s, fmi2Status *value) {
  Instance *instance = enter(c, "fmi2GetStatus", STEPPED, CO_SIMULATION);
  if (!instance || !given(instance, value, 1, "value")) return fmi2Error;
  if (s != fmi2DoStepStatus) return untold(instance);
  *value = (fmi2Status)instance->state.last_step;
  return fmi2OK;
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind s, fmi2Real *value) {
  Instance *instance = enter(c, "fmi2GetRealStatus", STEPPED, CO_SIMULATION);
  if (!instance || !given(instance, value, 1, "value")) return fmi2Error;
  if (s != fmi2LastSuccessfulTime) return untold(instance);
  *value = instance->state.motion.time;
  return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind s, fmi2Integer *value) {
  (void)s;
  Instance *instance = enter(c, "fmi2GetIntegerStatus", STEPPED, CO_SIMULATION);
  if (!instance || !given(instance, value, 1, "value")) return fmi2Error;
  return untold(instance);
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind s, fmi2Boolean *value) {
  Instance *instance = enter(c, "fmi2GetBooleanStatus", STEPPED, CO_SIMULATION);
  if (!instance || !given(instance, value, 1, "value")) return fmi2Error;
  if (s != fmi2Terminated) return untold(instance);
  *value = fmi2False;
  return fmi2OK;
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind s, fmi2String *value) {
  Instance *instance = enter(c, "fmi2GetStringStatus", STEPPED, CO_SIMULATION);
  if (!instance || !given(instance, value, 1, "value")) return fmi2Error;
  if (s != fmi2PendingStatus) return untold(instance);
  *value = "nothing is pending";
  return fmi2OK;
}
