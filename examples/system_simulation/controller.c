/* A joint-position controller as an FMU: FMI 2.0, co-simulation, one file, no globals.

   It moves the joint to a target and back, smoothly. The motor is led ahead of the joint by the
   deflection that the springs need for the motion and for the weight, both tendons taut; what
   remains is left to proportional and derivative feedback:

     motor = r + (J r'' + d r' + T sin r) / K + kp (r - q) + kd (r' - q')

   Outputs follow the inputs at once, so there is no state but the time. */

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

static const char GUID[] = "elastic-tendon-example-joint-controller-1"; /* as in the XML */

/* Value references; inputs, then parameters, then what is calculated. */
enum {
  JOINT_POSITION, JOINT_VELOCITY,
  TARGET_POSITION, TRAVEL_TIME, DWELL_TIME, PROPORTIONAL_GAIN, DERIVATIVE_GAIN,
  STIFFNESS, INERTIA, DAMPING, WEIGHT_TORQUE,
  MOTOR_POSITION, REFERENCE_POSITION,
  N_VALUES
};
enum { N_INPUTS = TARGET_POSITION, N_KNOWN = MOTOR_POSITION };
static const double START[N_KNOWN] = {0, 0, 1.0, 0.2, 0.4, 0.5, 0.02, 40.0, 0.03, 0.16, 0};

/* Where the instance is in its life: which calls are legal. */
typedef enum {
  INSTANTIATED = 1, SET_UP = 2, INITIALISING = 4, STEPPING = 8, TERMINATED = 16
} Phase;

typedef struct {
  char *name;
  fmi2CallbackFunctions callback;
  int logging;
  Phase phase;
  double time, stop_time;
  double value[N_KNOWN];
} Controller;

/* ---- errors ------------------------------------------------------------------------------- */

static fmi2Status refuse(Controller *c, const char *function, const char *format, ...) {
  if (!c || !c->logging || !c->callback.logger) return fmi2Error;
  char text[256];
  va_list arguments;
  const int used = snprintf(text, sizeof text, "%s: ", function);
  va_start(arguments, format);
  vsnprintf(text + used, sizeof text - used, format, arguments);
  va_end(arguments);
  /* whole, because an importer may not expand a format */
  c->callback.logger(c->callback.componentEnvironment, c->name, fmi2Error, "logStatusError", text);
  return fmi2Error;
}

#define REQUIRE(phases)                                                            \
  do {                                                                             \
    if (!component || !(((Controller *)component)->phase & (phases)))              \
      return refuse(component, __func__, "not to be called in this phase");        \
  } while (0)

/* ---- control law -------------------------------------------------------------------------- */

typedef struct {
  double position, velocity, acceleration;
} Reference;

/* Rest, way to the target, rest, way back, and again; each way has the least jerk. */
static Reference reference_at(const double *p, double time) {
  const double half = p[DWELL_TIME] + p[TRAVEL_TIME], span = p[TRAVEL_TIME];
  const double within = fmod(time, 2 * half);
  const int back = within >= half;
  const double s = fmin(fmax((within - back * half - p[DWELL_TIME]) / span, 0), 1);
  const double way = back ? -p[TARGET_POSITION] : p[TARGET_POSITION];
  return (Reference){
      .position = back * p[TARGET_POSITION] + way * s * s * s * (10 + s * (6 * s - 15)),
      .velocity = way * 30 * s * s * (1 - s) * (1 - s) / span,
      .acceleration = way * 60 * s * (1 - s) * (1 - 2 * s) / (span * span),
  };
}

static double motor_position(const double *p, Reference r) {
  const double torque = p[INERTIA] * r.acceleration + p[DAMPING] * r.velocity +
                        p[WEIGHT_TORQUE] * sin(r.position);
  return r.position + torque / p[STIFFNESS] +
         p[PROPORTIONAL_GAIN] * (r.position - p[JOINT_POSITION]) +
         p[DERIVATIVE_GAIN] * (r.velocity - p[JOINT_VELOCITY]);
}

/* ---- life --------------------------------------------------------------------------------- */

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

static void start(Controller *c) {
  c->phase = INSTANTIATED;
  c->time = 0;
  c->stop_time = INFINITY;
  memcpy(c->value, START, sizeof START);
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *callback, fmi2Boolean visible,
                              fmi2Boolean logging) {
  (void)resources, (void)visible;
  if (!name || !*name || !guid || !callback) return NULL;
  Controller *c = calloc(1, sizeof *c);
  char *copy = malloc(strlen(name) + 1);
  if (!c || !copy) return free(c), free(copy), NULL;
  c->name = strcpy(copy, name);
  c->callback = *callback;
  c->logging = 1; /* a refusal here is told in any case */
  const char *fault = type != fmi2CoSimulation ? "only co-simulation is offered"
                      : strcmp(guid, GUID)     ? "the GUID is that of another FMU"
                                               : NULL;
  if (fault) return refuse(c, __func__, "%s", fault), fmi2FreeInstance(c), NULL;
  c->logging = logging;
  start(c);
  return c;
}

void fmi2FreeInstance(fmi2Component component) {
  Controller *c = component;
  if (c) free(c->name);
  free(c);
}

fmi2Status fmi2SetDebugLogging(fmi2Component component, fmi2Boolean logging, size_t n,
                               const fmi2String categories[]) {
  (void)n, (void)categories; /* there is one */
  REQUIRE(INSTANTIATED | SET_UP | INITIALISING | STEPPING | TERMINATED);
  ((Controller *)component)->logging = logging;
  return fmi2OK;
}

fmi2Status fmi2SetupExperiment(fmi2Component component, fmi2Boolean tolerance_defined,
                               fmi2Real tolerance, fmi2Real start_time, fmi2Boolean stop_defined,
                               fmi2Real stop_time) {
  (void)tolerance_defined, (void)tolerance; /* nothing is integrated */
  REQUIRE(INSTANTIATED | SET_UP);
  Controller *c = component;
  if (!isfinite(start_time) || (stop_defined && !(stop_time > start_time)))
    return refuse(c, __func__, "from %g s to %g s", start_time, stop_time);
  c->time = start_time;
  c->stop_time = stop_defined ? stop_time : INFINITY;
  c->phase = SET_UP;
  return fmi2OK;
}

#define CHANGE_OF_PHASE(function, before, after)  \
  fmi2Status function(fmi2Component component) {  \
    REQUIRE(before);                              \
    ((Controller *)component)->phase = after;     \
    return fmi2OK;                                \
  }
CHANGE_OF_PHASE(fmi2EnterInitializationMode, SET_UP, INITIALISING)
CHANGE_OF_PHASE(fmi2ExitInitializationMode, INITIALISING, STEPPING)
CHANGE_OF_PHASE(fmi2Terminate, STEPPING, TERMINATED)

fmi2Status fmi2Reset(fmi2Component component) {
  REQUIRE(INSTANTIATED | SET_UP | INITIALISING | STEPPING | TERMINATED);
  start(component);
  return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component component, fmi2Real time, fmi2Real step, fmi2Boolean no_undo) {
  (void)no_undo;
  REQUIRE(STEPPING);
  Controller *c = component;
  const double rounding = 1e-9 * fmax(1, fabs(time));
  if (!isfinite(time) || !isfinite(step) || step <= 0 || time + step > c->stop_time + rounding)
    return refuse(c, __func__, "no step of %g s can be taken at %g s", step, time);
  c->time = time + step;
  return fmi2OK;
}

/* ---- values ------------------------------------------------------------------------------- */

fmi2Status fmi2GetReal(fmi2Component component, const fmi2ValueReference reference[], size_t n,
                       fmi2Real value[]) {
  REQUIRE(INSTANTIATED | SET_UP | INITIALISING | STEPPING | TERMINATED);
  const Controller *c = component;
  const Reference r = reference_at(c->value, c->time);
  for (size_t i = 0; i < n; i++) {
    if (reference[i] >= N_VALUES)
      return refuse(component, __func__, "there is no value reference %u", reference[i]);
    value[i] = reference[i] == MOTOR_POSITION       ? motor_position(c->value, r)
               : reference[i] == REFERENCE_POSITION ? r.position
                                                    : c->value[reference[i]];
  }
  return fmi2OK;
}

static int is_positive(unsigned reference) {
  return reference == TRAVEL_TIME || reference == DWELL_TIME || reference == STIFFNESS;
}

fmi2Status fmi2SetReal(fmi2Component component, const fmi2ValueReference reference[], size_t n,
                       const fmi2Real value[]) {
  REQUIRE(INSTANTIATED | SET_UP | INITIALISING | STEPPING);
  Controller *c = component;
  const unsigned settable = c->phase == STEPPING ? N_INPUTS : N_KNOWN;
  for (size_t i = 0; i < n; i++) /* all or nothing */
    if (reference[i] >= settable || !isfinite(value[i]) ||
        (is_positive(reference[i]) && value[i] <= 0))
      return refuse(c, __func__, "value reference %u cannot become %g", reference[i], value[i]);
  for (size_t i = 0; i < n; i++) c->value[reference[i]] = value[i];
  return fmi2OK;
}

/* No step is ever pending: the time is all that can be asked for. */
fmi2Status fmi2GetRealStatus(fmi2Component component, const fmi2StatusKind kind, fmi2Real *value) {
  REQUIRE(STEPPING | TERMINATED);
  if (kind != fmi2LastSuccessfulTime) return refuse(component, __func__, "only the time is known");
  *value = ((Controller *)component)->time;
  return fmi2OK;
}

/* ---- what the description says it does not offer ------------------------------------------ */

#define NOT_OFFERED(function, ...) \
  fmi2Status function(__VA_ARGS__) { return refuse(c, __func__, "not offered"); }
/* of other types there are no variables: an empty list is all that can be got and set */
#define NO_VARIABLES(function, qualifier, type)                                      \
  fmi2Status function(fmi2Component c, const fmi2ValueReference r[], size_t n,       \
                      qualifier type value[]) {                                      \
    (void)r, (void)value;                                                            \
    return n ? refuse(c, __func__, "there are only real variables") : fmi2OK;        \
  }
NO_VARIABLES(fmi2GetInteger, , fmi2Integer)
NO_VARIABLES(fmi2GetBoolean, , fmi2Boolean)
NO_VARIABLES(fmi2GetString, , fmi2String)
NO_VARIABLES(fmi2SetInteger, const, fmi2Integer)
NO_VARIABLES(fmi2SetBoolean, const, fmi2Boolean)
NO_VARIABLES(fmi2SetString, const, fmi2String)
NOT_OFFERED(fmi2GetFMUstate, fmi2Component c, fmi2FMUstate *s)
NOT_OFFERED(fmi2SetFMUstate, fmi2Component c, fmi2FMUstate s)
NOT_OFFERED(fmi2FreeFMUstate, fmi2Component c, fmi2FMUstate *s)
NOT_OFFERED(fmi2SerializedFMUstateSize, fmi2Component c, fmi2FMUstate s, size_t *n)
NOT_OFFERED(fmi2SerializeFMUstate, fmi2Component c, fmi2FMUstate s, fmi2Byte b[], size_t n)
NOT_OFFERED(fmi2DeSerializeFMUstate, fmi2Component c, const fmi2Byte b[], size_t n, fmi2FMUstate *s)
NOT_OFFERED(fmi2GetDirectionalDerivative, fmi2Component c, const fmi2ValueReference u[],
            size_t nu, const fmi2ValueReference k[], size_t nk, const fmi2Real dk[], fmi2Real du[])
NOT_OFFERED(fmi2SetRealInputDerivatives, fmi2Component c, const fmi2ValueReference r[],
            size_t n, const fmi2Integer order[], const fmi2Real value[])
NOT_OFFERED(fmi2GetRealOutputDerivatives, fmi2Component c, const fmi2ValueReference r[],
            size_t n, const fmi2Integer order[], fmi2Real value[])
NOT_OFFERED(fmi2CancelStep, fmi2Component c)
NOT_OFFERED(fmi2GetStatus, fmi2Component c, const fmi2StatusKind kind, fmi2Status *value)
NOT_OFFERED(fmi2GetIntegerStatus, fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value)
NOT_OFFERED(fmi2GetBooleanStatus, fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value)
NOT_OFFERED(fmi2GetStringStatus, fmi2Component c, const fmi2StatusKind kind, fmi2String *value)
NOT_OFFERED(fmi2EnterEventMode, fmi2Component c)
NOT_OFFERED(fmi2NewDiscreteStates, fmi2Component c, fmi2EventInfo *info)
NOT_OFFERED(fmi2EnterContinuousTimeMode, fmi2Component c)
NOT_OFFERED(fmi2CompletedIntegratorStep, fmi2Component c, fmi2Boolean no_undo, fmi2Boolean *event,
            fmi2Boolean *end)
NOT_OFFERED(fmi2SetTime, fmi2Component c, fmi2Real time)
NOT_OFFERED(fmi2SetContinuousStates, fmi2Component c, const fmi2Real x[], size_t n)
NOT_OFFERED(fmi2GetDerivatives, fmi2Component c, fmi2Real rates[], size_t n)
NOT_OFFERED(fmi2GetEventIndicators, fmi2Component c, fmi2Real indicators[], size_t n)
NOT_OFFERED(fmi2GetContinuousStates, fmi2Component c, fmi2Real x[], size_t n)
NOT_OFFERED(fmi2GetNominalsOfContinuousStates, fmi2Component c, fmi2Real nominals[], size_t n)
