/* Adjoint derivatives of FMI 3.0: the gradient, by the knowns, of the unknowns times their seeds. */
#include "instance.h"

/* One known after the other: there are few, and calculated starts are followed as above. */
static Status adjoint(Instance *instance, const Pairs *pairs, const double *seed, double *result) {
  Jacobians of;
  Change change;
  if (check_pairs(instance, pairs) != STATUS_OK ||
      check_seed(instance, pairs->unknown, pairs->n_unknowns, seed) != STATUS_OK ||
      look(instance) != STATUS_OK)
    return STATUS_ERROR;
  jacobians_of(instance, &of);
  for (size_t j = 0; j < pairs->n_knowns; j++) {
    double direction[V_LENGTH] = {0}, sum = 0.0;
    add_known(instance, pairs->known[j], 1.0, direction);
    if (derive(instance, &of, direction, &change) != STATUS_OK) return STATUS_ERROR;
    for (size_t i = 0; i < pairs->n_unknowns; i++)
      sum += seed[i] * pick(&variables[pairs->unknown[i]], &change);
    result[j] = sum;
  }
  return check_result(instance, pairs->known, pairs->n_knowns, result);
}
