/* What Python simulates with: the model, the solver and its entry, as in `library.c`, without the
 * functions of FMI, which take long to compile. */
#include "model.c"

#include "solver.c"

#include "simulate.c"

#include "actuators.c"
