/* Implicit equations of a model: unknowns w at which its residuals vanish, by Newton's method. */
#ifndef IMPLICIT_H
#define IMPLICIT_H

#include <math.h>
#include <string.h>

#include "compilers.h"

#if N_UNKNOWNS > 0

#define MAX_NEWTON_STEPS 100
#define CLOSE 1e-8 /* relative change after which the error, its square, is rounding */

/* From the guess, so that equal arguments give equal results whatever was solved before. Never
 * inlined, or each function of the model gets its own copy. */
NEVER_INLINE static void solve_implicit(const double *x, const double *u, const double *p,
                                        const double *r, double *w) {
  double next[N_UNKNOWNS];
  model_guess(x, u, p, r, w);
  for (int n = 0; n < MAX_NEWTON_STEPS; n++) {
    double size = 0.0, change = 0.0;
    model_newton(x, u, p, r, w, next);
    for (int i = 0; i < N_UNKNOWNS; i++) {
      size = fmax(size, fabs(next[i]));
      change = fmax(change, fabs(next[i] - w[i]));
    }
    memcpy(w, next, sizeof next);
    if (change <= CLOSE * size) return;
  }
  for (int i = 0; i < N_UNKNOWNS; i++) w[i] = NAN; /* so that what follows is seen to be none */
}

#endif

#endif
