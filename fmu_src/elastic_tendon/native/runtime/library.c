/* The whole library as one translation unit, so that the compiler sees the model's equations
 * where the solver calls them. */
#include "model.c"

#include "solver.c"

/* Python's entry has no prefix, so it stays out where models are linked into one program. */
#if !defined(FMI2_FUNCTION_PREFIX) && !defined(FMI3_FUNCTION_PREFIX)
#include "simulate.c"
#endif

#include "variables.c"

#include "instance.c"

#include "stepping.c"

#include "directional.c"

#include "snapshot.c"

#include "facade.c"

#if FMI_VERSION == 2

#include "fmi2.c"

#include "fmi2_model_exchange.c"

#include "fmi2_co_simulation.c"

#else

#include "fmi3_adjoint.c"

#include "fmi3.c"

#include "fmi3_model_exchange.c"

#include "fmi3_co_simulation.c"

#endif
