/* Derivatives of outputs and state derivatives, from the compiled Jacobians by v = [x; u; p]. */
#include <math.h>
#include <string.h>

#include "instance.h"

/* Change of rates and outputs along a direction in v, modes held. Needs a valid view. */
static void derive(const Instance *instance, const double *direction, double *rates,
                   double *outputs) {
  const View *view = &instance->view;
  const double *p = instance->solver.p;
  double by_rates[N_RATES_JACOBIAN], by_outputs[N_OUTPUTS_JACOBIAN];
  model_rates_jacobian(view->x, view->u, p, view->mode, by_rates);
  model_outputs_jacobian(view->x, view->u, p, view->mode, by_outputs);
  along(&rates_jacobian_pattern, by_rates, direction, N_STATES, rates);
  along(&outputs_jacobian_pattern, by_outputs, direction, N_OUTPUTS, outputs);
}

/* While initialising, states whose start is calculated follow the knowns. Needs a valid view. */
static int starts_follow(const Instance *instance, double *direction) {
  const View *view = &instance->view;
  int calculated[N_STATES];
  double nonzeros[N_STARTS_JACOBIAN];
  if (!find_calculated(instance->state.motion.x, calculated)) return 1;
  model_starts_jacobian(view->x, view->u, instance->solver.p, view->mode, nonzeros);
  return follow_starts(calculated, nonzeros, direction);
}

/* Place of a known in v, or -1. */
static int place(const Instance *instance, unsigned reference) {
  const VariableInfo *variable = &variables[reference];
  switch (variable->role) {
    case ROLE_STATE:
      return isnan(instance->state.motion.x[variable->index]) ? -1 : V_STATES + variable->index;
    case ROLE_INPUT: return V_INPUTS + variable->index;
    case ROLE_PARAMETER:
      return instance->state.phase == INITIALISATION ? V_PARAMETERS + variable->index : -1;
    default: return -1;
  }
}

static Status check_unknowns(Instance *instance, const unsigned *unknown, size_t n) {
  for (size_t i = 0; i < n; i++) {
    if (check_reference(instance, unknown[i], TYPE_REAL) != STATUS_OK) return STATUS_ERROR;
    const VariableInfo *variable = &variables[unknown[i]];
    if (!variable->is_output && variable->role != ROLE_DERIVATIVE)
      return report(instance, STATUS_ERROR, "%s is neither output nor derivative", variable->name);
  }
  return STATUS_OK;
}

static Status check_knowns(Instance *instance, const unsigned *known, size_t n,
                           const double *seed) {
  for (size_t i = 0; i < n; i++) {
    if (check_reference(instance, known[i], TYPE_REAL) != STATUS_OK) return STATUS_ERROR;
    if (place(instance, known[i]) < 0)
      return report(instance, STATUS_ERROR, "nothing can be derived by %s %s",
                    variables[known[i]].name, phase_name(instance->state.phase));
    if (!isfinite(seed[i]))
      return report(instance, STATUS_ERROR, "the seed %g of %s is not finite", seed[i],
                    variables[known[i]].name);
  }
  return STATUS_OK;
}

static double pick(const VariableInfo *variable, const double *direction, const double *rates,
                   const double *outputs) {
  switch (variable->role) {
    case ROLE_STATE: return direction[V_STATES + variable->index];
    case ROLE_DERIVATIVE: return rates[variable->index];
    default: return outputs[variable->index];
  }
}

static Status directional(Instance *instance, const unsigned *unknown, size_t n_unknowns,
                          const unsigned *known, size_t n_knowns, const double *seed,
                          double *result) {
  double direction[V_LENGTH] = {0}, rates[N_STATES], outputs[N_OUTPUTS];
  if (check_unknowns(instance, unknown, n_unknowns) != STATUS_OK ||
      check_knowns(instance, known, n_knowns, seed) != STATUS_OK || look(instance) != STATUS_OK)
    return STATUS_ERROR;
  for (size_t i = 0; i < n_knowns; i++) direction[place(instance, known[i])] += seed[i];
  if (!instance->state.motor_velocity_connected) direction[V_INPUTS + MOTOR_VELOCITY] = 0.0;
  if (!starts_follow(instance, direction))
    return report(instance, STATUS_ERROR, "%s", outcome_text(STARTS_DO_NOT_SETTLE));
  derive(instance, direction, rates, outputs);
  for (size_t i = 0; i < n_unknowns; i++)
    result[i] = pick(&variables[unknown[i]], direction, rates, outputs);
  return STATUS_OK;
}

static Status output_rates(Instance *instance, const unsigned *output, size_t n, double *result) {
  double direction[V_LENGTH] = {0}, rates[N_STATES], outputs[N_OUTPUTS];
  for (size_t i = 0; i < n; i++) {
    if (check_reference(instance, output[i], TYPE_REAL) != STATUS_OK) return STATUS_ERROR;
    if (!variables[output[i]].is_output)
      return report(instance, STATUS_ERROR, "%s is no output", variables[output[i]].name);
  }
  if (look(instance) != STATUS_OK) return STATUS_ERROR;
  memcpy(direction + V_STATES, instance->view.rates, sizeof instance->view.rates);
  memcpy(direction + V_INPUTS, instance->view.u_rate, sizeof instance->view.u_rate);
  derive(instance, direction, rates, outputs);
  for (size_t i = 0; i < n; i++) result[i] = pick(&variables[output[i]], direction, rates, outputs);
  return STATUS_OK;
}
