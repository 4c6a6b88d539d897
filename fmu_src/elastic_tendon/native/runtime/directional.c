/* Derivatives of outputs and state derivatives, from the compiled Jacobians by v = [x; u; p]. */
#include <math.h>
#include <string.h>

#include "instance.h"

typedef struct {
  double rates[N_RATES_JACOBIAN], outputs[N_OUTPUTS_JACOBIAN], starts[N_STARTS_JACOBIAN + 1];
  int calculated[N_STATES]; /* states that follow the knowns while initialising, */
  int follow;               /* if there are any */
} Jacobians;

/* Change along a direction. */
typedef struct {
  double states[N_STATES], rates[N_STATES], outputs[N_OUTPUTS];
} Change;

/* At the view, which must be valid. */
static void jacobians_of(const Instance *instance, Jacobians *of) {
  const View *view = &instance->view;
  const double *p = instance->solver.p;
  model_rates_jacobian(view->x, view->u, p, view->mode, of->rates);
  model_outputs_jacobian(view->x, view->u, p, view->mode, of->outputs);
  of->follow = find_calculated(instance->state.motion.x, of->calculated);
  if (of->follow) model_starts_jacobian(view->x, view->u, p, view->mode, of->starts);
}

/* Modes held. The direction's calculated states are set. */
static Status derive(Instance *instance, const Jacobians *of, double *direction, Change *change) {
  if (of->follow && !follow_starts(of->calculated, of->starts, direction))
    return report(instance, STATUS_ERROR, "%s", outcome_text[STARTS_DO_NOT_SETTLE]);
  memcpy(change->states, direction + V_STATES, sizeof change->states);
  along(&rates_jacobian_pattern, of->rates, direction, N_STATES, change->rates);
  along(&outputs_jacobian_pattern, of->outputs, direction, N_OUTPUTS, change->outputs);
  return STATUS_OK;
}

static double pick(const VariableInfo *variable, const Change *change) {
  switch (variable->role) {
    case ROLE_STATE: return change->states[variable->index];
    case ROLE_DERIVATIVE: return change->rates[variable->index];
    default: return change->outputs[variable->index];
  }
}

/* ---- unknowns and knowns --------------------------------------------------------------------- */

/* Place of a known in v, or -1. */
static int place(const Instance *instance, unsigned reference) {
  const VariableInfo *variable = &variables[reference];
  switch (variable->role) {
    case ROLE_STATE:
      return isnan(instance->state.motion.x[variable->index]) ? -1 : V_STATES + variable->index;
    case ROLE_INPUT: return V_INPUTS + variable->index;
    case ROLE_PARAMETER:
      return settable(instance, variable) & instance->state.phase ? V_PARAMETERS + variable->index
                                                                  : -1;
    default: return -1;
  }
}

/* A velocity that is not connected changes nothing. */
static void add_known(const Instance *instance, unsigned reference, double seed,
                      double *direction) {
  const int i = place(instance, reference);
  if (i >= V_INPUTS && i < V_PARAMETERS && !instance->state.connected[i - V_INPUTS]) return;
  direction[i] += seed;
}

static int is_unknown(const Instance *instance, const VariableInfo *variable) {
  switch (variable->role) {
    case ROLE_DERIVATIVE: return 1;
    case ROLE_STATE: return variable->is_output || isnan(instance->state.motion.x[variable->index]);
    default: return variable->is_output;
  }
}

static Status check_pairs(Instance *instance, const Pairs *pairs) {
  for (size_t i = 0; i < pairs->n_unknowns; i++) {
    if (check_reference(instance, pairs->unknown[i], TYPE_REAL) != STATUS_OK) return STATUS_ERROR;
    const VariableInfo *variable = &variables[pairs->unknown[i]];
    if (!is_unknown(instance, variable))
      return report(instance, STATUS_ERROR, "%s is no unknown: neither output nor derivative",
                    variable->name);
  }
  for (size_t i = 0; i < pairs->n_knowns; i++) {
    if (check_reference(instance, pairs->known[i], TYPE_REAL) != STATUS_OK) return STATUS_ERROR;
    if (place(instance, pairs->known[i]) < 0)
      return report(instance, STATUS_ERROR, "there is no derivative by %s %s",
                    variables[pairs->known[i]].name, phase_name(instance->state.phase));
  }
  return STATUS_OK;
}

static Status check_seed(Instance *instance, const unsigned *reference, size_t n,
                         const double *seed) {
  for (size_t i = 0; i < n; i++)
    if (!isfinite(seed[i]))
      return report(instance, STATUS_ERROR, "the seed %g of %s is not finite", seed[i],
                    variables[reference[i]].name);
  return STATUS_OK;
}

/* Results of a call, each with the variable that it belongs to. */
static Status check_result(Instance *instance, const unsigned *reference, size_t n,
                           const double *result) {
  for (size_t i = 0; i < n; i++)
    if (!isfinite(result[i]))
      return report(instance, STATUS_DISCARD, "the derivative for %s is not finite",
                    variables[reference[i]].name);
  return STATUS_OK;
}

/* ---- calls ----------------------------------------------------------------------------------- */

static Status directional(Instance *instance, const Pairs *pairs, const double *seed,
                          double *result) {
  double direction[V_LENGTH] = {0};
  Jacobians of;
  Change change;
  if (check_pairs(instance, pairs) != STATUS_OK ||
      check_seed(instance, pairs->known, pairs->n_knowns, seed) != STATUS_OK ||
      look(instance) != STATUS_OK)
    return STATUS_ERROR;
  jacobians_of(instance, &of);
  for (size_t i = 0; i < pairs->n_knowns; i++)
    add_known(instance, pairs->known[i], seed[i], direction);
  if (derive(instance, &of, direction, &change) != STATUS_OK) return STATUS_ERROR;
  for (size_t i = 0; i < pairs->n_unknowns; i++)
    result[i] = pick(&variables[pairs->unknown[i]], &change);
  return check_result(instance, pairs->unknown, pairs->n_unknowns, result);
}

static Status output_rates(Instance *instance, const unsigned *output, size_t n, double *result) {
  double direction[V_LENGTH] = {0};
  Jacobians of;
  Change change;
  for (size_t i = 0; i < n; i++) {
    if (check_reference(instance, output[i], TYPE_REAL) != STATUS_OK) return STATUS_ERROR;
    if (!variables[output[i]].is_output)
      return report(instance, STATUS_ERROR, "%s is no output", variables[output[i]].name);
  }
  if (look(instance) != STATUS_OK) return STATUS_ERROR;
  jacobians_of(instance, &of);
  memcpy(direction + V_STATES, instance->view.rates, sizeof instance->view.rates);
  memcpy(direction + V_INPUTS, instance->view.u_rate, sizeof instance->view.u_rate);
  if (derive(instance, &of, direction, &change) != STATUS_OK) return STATUS_ERROR;
  for (size_t i = 0; i < n; i++) result[i] = pick(&variables[output[i]], &change);
  return check_result(instance, output, n, result);
}
