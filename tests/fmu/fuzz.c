/* Random legal and illegal calls of every FMI 2 function, for a build with sanitizers.
 *
 * Argument: number of calls. Fails where a call that returns fmi2Error has changed the state, where
 * a message is unsafe as a printf format, or where a function never succeeds. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

#define REFERENCES 34 /* somewhat more than there are */

static unsigned long long seed = 1;

static unsigned draw(unsigned n) { /* xorshift */
  seed ^= seed << 13;
  seed ^= seed >> 7;
  seed ^= seed << 17;
  return (unsigned)(seed >> 33) % n;
}

static int rarely(void) { return draw(20) == 0; }

static double number(void) {
  switch (draw(30)) {
    case 0: return NAN;
    case 1: return INFINITY;
    case 2: return -1e300;
    case 3: return 1e300;
    default: return ((double)draw(2001) - 1000.0) / 1000.0;
  }
}

static void fail(const char *what, const char *detail) {
  fprintf(stderr, "%s: %s\n", what, detail);
  exit(1);
}

static void logger(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status,
                   fmi2String category, fmi2String message, ...) {
  (void)environment, (void)status;
  if (strcmp(name, "100%s%n") != 0 || strncmp(category, "log", 3) != 0) fail("name", name);
  for (const char *c = message; *c; c++)
    if (*c == '%' && *++c != '%') fail("single percent sign", message);
}

enum { SIZE = 4096, LENGTH = 8 };

typedef struct {
  fmi2Component component;
  int type;
  double time;
  fmi2FMUstate kept;
  char bytes[SIZE];
  size_t size; /* of the bytes kept */
} Target;

static size_t serialise(fmi2Component c, char *bytes) {
  fmi2FMUstate state = NULL;
  size_t size = 0;
  if (fmi2GetFMUstate(c, &state) != fmi2OK ||
      fmi2SerializedFMUstateSize(c, state, &size) != fmi2OK || size > SIZE ||
      fmi2SerializeFMUstate(c, state, bytes, size) != fmi2OK ||
      fmi2FreeFMUstate(c, &state) != fmi2OK)
    fail("serialise", "");
  return size;
}

static fmi2Status restore_bytes(Target *t, int damage) {
  char bytes[SIZE];
  fmi2FMUstate state = NULL;
  if (t->size == 0) return fmi2Error;
  memcpy(bytes, t->bytes, t->size);
  if (damage) bytes[draw((unsigned)t->size < 64 ? (unsigned)t->size : 64)] ^= 1;
  fmi2Status status = fmi2DeSerializeFMUstate(t->component, bytes, t->size - rarely(), &state);
  if (status == fmi2OK) status = fmi2SetFMUstate(t->component, state);
  fmi2FreeFMUstate(t->component, &state);
  return status;
}

enum { N_CALLS = 46 };

/* One random call; `which` numbers the functions. */
static fmi2Status call(Target *t, unsigned which) {
  fmi2Component c = rarely() && rarely() ? NULL : t->component;
  fmi2ValueReference vr[LENGTH], other[LENGTH];
  fmi2Real real[LENGTH], result[LENGTH];
  fmi2Integer whole[LENGTH], order[LENGTH];
  fmi2String text[LENGTH] = {0};
  fmi2Boolean flag;
  fmi2EventInfo info;
  fmi2Status status;
  double h;
  const size_t n = 1 + draw(2);
  for (int i = 0; i < LENGTH; i++) {
    vr[i] = draw(REFERENCES);
    other[i] = draw(REFERENCES);
    real[i] = number();
    whole[i] = (int)draw(4);
    order[i] = rarely() ? 2 : 1;
  }
  const int hole = rarely();
  const size_t nx = rarely() ? 3 : 2, nz = rarely() ? 3 : 8;
  switch (which) {
    case 0: return strcmp(fmi2GetTypesPlatform(), "default") ? fmi2Error : fmi2OK;
    case 1: return strcmp(fmi2GetVersion(), "2.0") ? fmi2Error : fmi2OK;
    case 2:
      text[0] = rarely() ? "no%n" : "logEvents";
      return fmi2SetDebugLogging(c, 1, draw(2), hole ? NULL : text);
    case 3:
      t->time = draw(2);
      return fmi2SetupExperiment(c, draw(2), real[0], t->time, draw(4) == 0, 1e3 * real[1]);
    case 4: case 5: return fmi2EnterInitializationMode(c);
    case 6: case 7: return fmi2ExitInitializationMode(c);
    case 8: return rarely() ? fmi2Terminate(c) : fmi2OK;
    case 9: return rarely() ? fmi2Reset(c) : fmi2OK;
    case 10: return fmi2GetReal(c, vr, n, hole ? NULL : result);
    case 11: return fmi2GetInteger(c, vr, 1, hole ? NULL : whole);
    case 12: return fmi2GetBoolean(c, vr, 1, hole ? NULL : whole);
    case 13: return fmi2GetString(c, vr, draw(2), hole ? NULL : text);
    case 14: case 15: return fmi2SetReal(c, hole ? NULL : vr, n, real);
    case 16: return fmi2SetInteger(c, vr, n, hole ? NULL : whole);
    case 17: return fmi2SetBoolean(c, vr, 1, hole ? NULL : whole);
    case 18: return fmi2SetString(c, vr, draw(2), hole ? NULL : text);
    case 19: t->size = serialise(t->component, t->bytes); return fmi2OK;
    case 20: return restore_bytes(t, 0);
    case 21: return restore_bytes(t, 1);
    case 22: return fmi2GetFMUstate(c, hole ? NULL : &t->kept);
    case 23: return fmi2SetFMUstate(c, t->kept);
    case 24: return hole ? fmi2FreeFMUstate(c, &t->kept) : fmi2OK;
    case 25: case 26:
      return fmi2GetDirectionalDerivative(c, vr, n, other, n, real, hole ? NULL : result);
    case 27: return fmi2EnterEventMode(c);
    case 28: case 29: return fmi2NewDiscreteStates(c, hole ? NULL : &info);
    case 30: return fmi2EnterContinuousTimeMode(c);
    case 31: return fmi2CompletedIntegratorStep(c, 1, &flag, hole ? NULL : &flag);
    case 32: return fmi2SetTime(c, fabs(real[0]) + 2);
    case 33: return fmi2SetContinuousStates(c, real, nx);
    case 34: return fmi2GetDerivatives(c, hole ? NULL : result, nx);
    case 35: return fmi2GetEventIndicators(c, result, nz);
    case 36: return fmi2GetContinuousStates(c, result, nx);
    case 37: return fmi2GetNominalsOfContinuousStates(c, result, nx);
    case 38: case 39: return fmi2SetRealInputDerivatives(c, other, n, order, real);
    case 40: return fmi2GetRealOutputDerivatives(c, vr, 1, order, result);
    case 41: case 42:
      h = fabs(real[0]) < 2 || !isfinite(real[0]) ? 1e-3 * real[0] : 0.1; /* 1e300 s take long */
      status = fmi2DoStep(c, t->time, h, 1);
      if (status == fmi2OK) t->time += h;
      return status;
    case 43:
      fmi2CancelStep(c);
      return fmi2GetStatus(c, (fmi2StatusKind)draw(4), (fmi2Status *)whole);
    case 44:
      fmi2GetIntegerStatus(c, fmi2DoStepStatus, whole);
      return fmi2GetRealStatus(c, (fmi2StatusKind)draw(4), result);
    default:
      fmi2GetStringStatus(c, fmi2PendingStatus, text);
      return fmi2GetBooleanStatus(c, fmi2Terminated, whole);
  }
}

static void instantiate(Target *t, const char *token) {
  const fmi2CallbackFunctions functions = {logger, NULL, NULL, NULL, NULL};
  if (t->component) fmi2FreeFMUstate(t->component, &t->kept);
  fmi2FreeInstance(t->component);
  memset(t, 0, sizeof *t);
  t->type = draw(2) ? fmi2ModelExchange : fmi2CoSimulation;
  t->component = fmi2Instantiate("100%s%n", (fmi2Type)t->type, token, "", &functions, 0, 1);
  if (!t->component ||
      fmi2Instantiate("100%s%n", fmi2CoSimulation, "wrong %s", "", &functions, 0, 1) ||
      fmi2Instantiate("x", fmi2CoSimulation, token, "", NULL, 0, 1))
    fail("instantiate", token);
}

int main(int argc, char **argv) {
  const long calls = argc > 2 ? atol(argv[2]) : 0;
  static long succeeded[N_CALLS];
  static char before[SIZE], after[SIZE];
  Target target = {0};
  for (long i = 0; i < calls; i++) {
    if (i % 500 == 0) instantiate(&target, argv[1]);
    const unsigned which = draw(N_CALLS);
    const size_t size = serialise(target.component, before);
    const fmi2Status status = call(&target, which);
    succeeded[which] += status == fmi2OK || status == fmi2Warning;
    serialise(target.component, after);
    if (status == fmi2Error && memcmp(before, after, size) != 0) {
      char detail[40];
      snprintf(detail, sizeof detail, "call %u, number %ld", which, i);
      fail("an error has changed the state", detail);
    }
  }
  for (unsigned which = 0; which < N_CALLS; which++)
    if (succeeded[which] == 0) {
      char detail[20];
      snprintf(detail, sizeof detail, "%u", which);
      fail("a function never succeeds", detail);
    }
  fmi2FreeFMUstate(target.component, &target.kept);
  fmi2FreeInstance(target.component);
  printf("%ld calls\n", calls);
  return 0;
}
