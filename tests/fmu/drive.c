/* Drives a model by co-simulation on the platform it is compiled for, and prints what it sees.
 *
 *   drive LIBRARY TOKEN STEPS INPUT VALUE OUTPUT...
 *
 * INPUT (at VALUE throughout) and OUTPUT are value references of real variables. After each step
 * of 1 ms the bits of the outputs are one line. FMI_VERSION is 2 or 3. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if defined(_WIN32)
#include <windows.h>
static void *symbol(const char *library, const char *name) {
  return (void *)GetProcAddress(LoadLibraryA(library), name);
}
#else
#include <dlfcn.h>
static void *symbol(const char *library, const char *name) {
  void *loaded = dlopen(library, RTLD_NOW);
  if (!loaded) fprintf(stderr, "%s\n", dlerror());
  return loaded ? dlsym(loaded, name) : NULL;
}
#endif

#define STEP 1e-3 /* s */
#define MAX_OUTPUTS 16
/* The function of the library, or the end. */
#define CALL(name) ((name##TYPE *)(found = symbol(library, #name), found ? found : (exit(2), found)))

static void show(const double *value, int n) {
  for (int i = 0; i < n; i++) {
    uint64_t bits;
    memcpy(&bits, &value[i], sizeof bits);
    printf("%08lx%08lx%c", (unsigned long)(bits >> 32), (unsigned long)(bits & 0xffffffffu),
           i + 1 < n ? ' ' : '\n');
  }
}

#if FMI_VERSION == 2
#include "fmi2FunctionTypes.h"
typedef fmi2ValueReference Reference;

static void tell(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status,
                 fmi2String category, fmi2String message, ...) {
  (void)environment;
  fprintf(stderr, "%s %d %s %s\n", name, status, category, message);
}

static int run(const char *library, const char *token, int steps, Reference input, double value,
               const Reference *output, int n) {
  void *found;
  double result[MAX_OUTPUTS];
  fmi2CallbackFunctions callbacks = {tell, calloc, free, NULL, NULL};
  fmi2Component c =
      CALL(fmi2Instantiate)("driven", fmi2CoSimulation, token, "", &callbacks, 0, 0);
  if (!c || CALL(fmi2SetupExperiment)(c, 0, 0.0, 0.0, 0, 0.0) ||
      CALL(fmi2SetReal)(c, &input, 1, &value) || CALL(fmi2EnterInitializationMode)(c) ||
      CALL(fmi2ExitInitializationMode)(c))
    return 1;
  for (int i = 0; i < steps; i++) {
    if (CALL(fmi2DoStep)(c, i * STEP, STEP, 1) || CALL(fmi2GetReal)(c, output, n, result))
      return 1;
    show(result, n);
  }
  CALL(fmi2FreeInstance)(c);
  return 0;
}
#else
#include "fmi3FunctionTypes.h"
typedef fmi3ValueReference Reference;

static void tell(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category,
                 fmi3String message) {
  (void)environment;
  fprintf(stderr, "%d %s %s\n", status, category, message);
}

static int run(const char *library, const char *token, int steps, Reference input, double value,
               const Reference *output, int n) {
  void *found;
  double result[MAX_OUTPUTS], last;
  fmi3Boolean event, terminate, early;
  fmi3Instance c = CALL(fmi3InstantiateCoSimulation)("driven", token, "", 0, 0, 0, 0, NULL, 0, NULL,
                                                     tell, NULL);
  if (!c || CALL(fmi3SetFloat64)(c, &input, 1, &value, 1) ||
      CALL(fmi3EnterInitializationMode)(c, 0, 0.0, 0.0, 0, 0.0) ||
      CALL(fmi3ExitInitializationMode)(c))
    return 1;
  for (int i = 0; i < steps; i++) {
    if (CALL(fmi3DoStep)(c, i * STEP, STEP, 1, &event, &terminate, &early, &last) ||
        CALL(fmi3GetFloat64)(c, output, n, result, n))
      return 1;
    show(result, n);
  }
  CALL(fmi3FreeInstance)(c);
  return 0;
}
#endif

int main(int n, char **argument) {
  Reference output[MAX_OUTPUTS];
  const int n_outputs = n - 6;
  if (n_outputs < 1 || n_outputs > MAX_OUTPUTS) return 2;
  for (int i = 0; i < n_outputs; i++) output[i] = (Reference)atoi(argument[6 + i]);
  return run(argument[1], argument[2], atoi(argument[3]), (Reference)atoi(argument[4]),
             atof(argument[5]), output, n_outputs);
}
