/* Random calls of FMI 3.0, also from inside steps; see fuzz.h. */
#include "fmi3Functions.h"

#define FMI(name) fmi3##name
#define GET_STATE fmi3GetFMUState
#define SET_STATE fmi3SetFMUState
#define FREE_STATE fmi3FreeFMUState
#define STATE_SIZE fmi3SerializedFMUStateSize
#define SERIALISE fmi3SerializeFMUState
#define DESERIALISE fmi3DeserializeFMUState
#define GET_NUMBER(c, reference, value) fmi3GetFloat64(c, reference, 1, value, 1)
#define SET_NUMBER(c, reference, value) fmi3SetFloat64(c, reference, 1, value, 1)
#define GET_DERIVATIVES fmi3GetContinuousStateDerivatives
#define ALWAYS_LOGGED 0
typedef fmi3Byte Byte;

#include "fuzz.h"

static void logger(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category,
                   fmi3String message) {
  check_message(environment, (int)status, category, message, '#');
}

/* ---- life and steps -------------------------------------------------------------------------- */

static int call_version(Target *t) {
  (void)t;
  return strncmp(fmi3GetVersion(), "3.0", 3) != 0;
}

static int call_enter_initialisation(Target *t) {
  const double tolerance = wild(4) ? number() : draw(8) ? 1e-6 : 1.0, start = wild(4) ? number() : 0.0;
  return fmi3EnterInitializationMode(handle(t), draw(2), tolerance, start, draw(4) == 0, 0.05);
}

static int call_enter_step_mode(Target *t) { return fmi3EnterStepMode(handle(t)); }

static int call_update_discrete_states(Target *t) {
  fmi3Boolean flag[5];
  double time;
  return fmi3UpdateDiscreteStates(handle(t), OR_NULL(&flag[0]), OR_NULL(&flag[1]),
                                  OR_NULL(&flag[2]), OR_NULL(&flag[3]), OR_NULL(&flag[4]),
                                  OR_NULL(&time));
}

static int call_evaluate_discrete_states(Target *t) { return fmi3EvaluateDiscreteStates(handle(t)); }

static int call_completed_step(Target *t) {
  fmi3Boolean enter, terminate;
  return fmi3CompletedIntegratorStep(handle(t), draw(2), OR_NULL(&enter), OR_NULL(&terminate));
}

static int call_step(Target *t) {
  fmi3Boolean event, terminate, early;
  double last;
  const double time = wild(4) ? number() : now(t);
  return fmi3DoStep(handle(t), time, step_size(), draw(2), OR_NULL(&event), OR_NULL(&terminate),
                    OR_NULL(&early), OR_NULL(&last));
}

/* ---- values ---------------------------------------------------------------------------------- */

#define ACCESS(Name, Value, gettable, settable, count, value)                                      \
  static int call_get_##Name(Target *t) {                                                          \
    unsigned vr[LENGTH];                                                                           \
    Value values[LENGTH];                                                                          \
    const size_t n = count;                                                                        \
    fill_references(vr, gettable);                                                                 \
    return fmi3Get##Name(handle(t), OR_NULL(vr), n, OR_NULL(values), size_near(n));                \
  }                                                                                                \
                                                                                                   \
  static int call_set_##Name(Target *t) {                                                          \
    unsigned vr[LENGTH];                                                                           \
    Value values[LENGTH];                                                                          \
    const size_t n = count;                                                                        \
    fill_references(vr, settable);                                                                 \
    for (int i = 0; i < LENGTH; i++) values[i] = (Value)(value);                                   \
    return fmi3Set##Name(handle(t), OR_NULL(vr), n, OR_NULL(values), size_near(n));                \
  }

/* Legal references, and a value; of most types there is no variable, so only none can be got. */
ACCESS(Float64, fmi3Float64, REAL_, input(), some(), number())
ACCESS(Int32, fmi3Int32, INTEGER_, INTEGER_, some(), (int)draw(5) - 1)
ACCESS(Int64, fmi3Int64, ENUMERATION_, ENUMERATION_, some(), (int)draw(5) - 1)
ACCESS(Boolean, fmi3Boolean, BOOLEAN_, BOOLEAN_, some(), draw(2) == 1)
ACCESS(Float32, fmi3Float32, 0, 0, draw(2), 0)
ACCESS(Int8, fmi3Int8, 0, 0, draw(2), 0)
ACCESS(UInt8, fmi3UInt8, 0, 0, draw(2), 0)
ACCESS(Int16, fmi3Int16, 0, 0, draw(2), 0)
ACCESS(UInt16, fmi3UInt16, 0, 0, draw(2), 0)
ACCESS(UInt32, fmi3UInt32, 0, 0, draw(2), 0)
ACCESS(UInt64, fmi3UInt64, 0, 0, draw(2), 0)
ACCESS(String, fmi3String, 0, 0, draw(2), "%n#")

static int call_get_binary(Target *t) {
  const unsigned vr[] = {reference()};
  size_t sizes[1];
  fmi3Binary values[1];
  return fmi3GetBinary(handle(t), OR_NULL(vr), draw(2), sizes, OR_NULL(values), draw(2));
}

static int call_set_binary(Target *t) {
  const unsigned vr[] = {reference()};
  const size_t sizes[1] = {0};
  const fmi3Binary values[1] = {NULL};
  return fmi3SetBinary(handle(t), OR_NULL(vr), draw(2), sizes, OR_NULL(values), draw(2));
}

/* ---- clocks, of which there are none --------------------------------------------------------- */

static const unsigned some_clock[] = {4};

#define CLOCK_CALL(name, ...)                                                                      \
  static int call_##name(Target *t) {                                                              \
    return fmi3##name(handle(t), OR_NULL(some_clock), draw(2), __VA_ARGS__);                       \
  }

CLOCK_CALL(GetClock, NULL)
CLOCK_CALL(SetClock, NULL)
CLOCK_CALL(GetIntervalDecimal, NULL, NULL)
CLOCK_CALL(GetIntervalFraction, NULL, NULL, NULL)
CLOCK_CALL(GetShiftDecimal, NULL)
CLOCK_CALL(GetShiftFraction, NULL, NULL)
CLOCK_CALL(SetIntervalDecimal, NULL)
CLOCK_CALL(SetIntervalFraction, NULL, NULL)
CLOCK_CALL(SetShiftDecimal, NULL)
CLOCK_CALL(SetShiftFraction, NULL, NULL)

/* ---- derivatives and sizes ------------------------------------------------------------------- */

typedef struct {
  unsigned unknown[LENGTH], known[LENGTH];
  double direction[LENGTH], result[LENGTH];
} Pairs;

static void fill_pairs(Pairs *pairs) {
  fill_references(pairs->unknown, REAL_);
  fill_references(pairs->known, input());
  fill(pairs->direction);
}

static int call_directional(Target *t) {
  Pairs p;
  const size_t n = some(), m = some();
  fill_pairs(&p);
  return fmi3GetDirectionalDerivative(handle(t), OR_NULL(p.unknown), n, OR_NULL(p.known), m,
                                      OR_NULL(p.direction), size_near(m), OR_NULL(p.result),
                                      size_near(n));
}

static int call_adjoint(Target *t) {
  Pairs p;
  const size_t n = some(), m = some();
  fill_pairs(&p);
  return fmi3GetAdjointDerivative(handle(t), OR_NULL(p.unknown), n, OR_NULL(p.known), m,
                                  OR_NULL(p.direction), size_near(n), OR_NULL(p.result),
                                  size_near(m));
}

static int call_output_derivatives(Target *t) {
  const unsigned vr[] = {careful ? REAL_ : reference()};
  const fmi3Int32 order[] = {wild(8) ? (int)draw(3) : 1};
  double value[1];
  return fmi3GetOutputDerivatives(handle(t), OR_NULL(vr), 1, OR_NULL(order), OR_NULL(value),
                                  size_near(1));
}

static int call_number_of_indicators(Target *t) {
  size_t n = INDICATORS;
  const int status = fmi3GetNumberOfEventIndicators(handle(t), OR_NULL(&n));
  return n == INDICATORS ? status : -1;
}

static int call_number_of_states(Target *t) {
  size_t n = STATES;
  const int status = fmi3GetNumberOfContinuousStates(handle(t), OR_NULL(&n));
  return n == STATES ? status : -1;
}

/* ---- what is not there ----------------------------------------------------------------------- */

static int call_enter_configuration(Target *t) { return fmi3EnterConfigurationMode(handle(t)); }

static int call_exit_configuration(Target *t) { return fmi3ExitConfigurationMode(handle(t)); }

static int call_number_of_dependencies(Target *t) {
  size_t n;
  return fmi3GetNumberOfVariableDependencies(handle(t), reference(), OR_NULL(&n));
}

static int call_dependencies(Target *t) {
  return fmi3GetVariableDependencies(handle(t), reference(), NULL, NULL, NULL, NULL, 0);
}

static int call_activate(Target *t) {
  return fmi3ActivateModelPartition(handle(t), reference(), number());
}

#define VALUE_CALLS(Name) {"Get" #Name, call_get_##Name, 0}, {"Set" #Name, call_set_##Name, 0}
#define CLOCK_ENTRY(name) {#name, call_##name, 0}

static const Entry calls[] = {
    COMMON_CALLS,
    VALUE_CALLS(Float64),
    VALUE_CALLS(Float32),
    VALUE_CALLS(Int8),
    VALUE_CALLS(UInt8),
    VALUE_CALLS(Int16),
    VALUE_CALLS(UInt16),
    VALUE_CALLS(Int32),
    VALUE_CALLS(UInt32),
    VALUE_CALLS(Int64),
    VALUE_CALLS(UInt64),
    VALUE_CALLS(Boolean),
    VALUE_CALLS(String),
    {"GetBinary", call_get_binary, 0},
    {"SetBinary", call_set_binary, 0},
    CLOCK_ENTRY(GetClock),
    CLOCK_ENTRY(SetClock),
    CLOCK_ENTRY(GetIntervalDecimal),
    CLOCK_ENTRY(GetIntervalFraction),
    CLOCK_ENTRY(GetShiftDecimal),
    CLOCK_ENTRY(GetShiftFraction),
    CLOCK_ENTRY(SetIntervalDecimal),
    CLOCK_ENTRY(SetIntervalFraction),
    CLOCK_ENTRY(SetShiftDecimal),
    CLOCK_ENTRY(SetShiftFraction),
    {"GetVersion", call_version, 0},
    {"EvaluateDiscreteStates", call_evaluate_discrete_states, 1},
    {"CompletedIntegratorStep", call_completed_step, 0},
    {"GetDirectionalDerivative", call_directional, 0},
    {"GetAdjointDerivative", call_adjoint, 0},
    {"GetOutputDerivatives", call_output_derivatives, 0},
    {"GetNumberOfEventIndicators", call_number_of_indicators, 0},
    {"GetNumberOfContinuousStates", call_number_of_states, 0},
    {"EnterConfigurationMode", call_enter_configuration, 1},
    {"ExitConfigurationMode", call_exit_configuration, 1},
    {"GetNumberOfVariableDependencies", call_number_of_dependencies, 1},
    {"GetVariableDependencies", call_dependencies, 1},
    {"ActivateModelPartition", call_activate, 1},
};

static const Entry progress[] = {
    COMMON_PROGRESS,
    {"EnterInitializationMode", call_enter_initialisation, 0},
    {"UpdateDiscreteStates", call_update_discrete_states, 0},
    {"EnterStepMode", call_enter_step_mode, 0},
    {"DoStep", call_step, 0},
};

/* ---- instances ------------------------------------------------------------------------------- */

/* Illegal calls of all kinds inside a step, and wishes to stop. */
static void update(fmi3InstanceEnvironment environment, fmi3Float64 time, fmi3Boolean may_set,
                   fmi3Boolean may_get, fmi3Boolean finished, fmi3Boolean may_stop,
                   fmi3Boolean *wish, fmi3Float64 *stop) {
  Target *t = environment;
  const int was_careful = careful, nobody = t->nobody, failing = must_fail;
  if (!isfinite(time) || !may_set || !may_get || !finished || t->inside) fail("update", "");
  t->inside = 1;
  while (draw(3)) {
    const Entry *entry = draw(4) ? &calls[draw(COUNT(calls))] : &progress[draw(COUNT(progress))];
    const int logs = t->logs;
    const long told = t->told[ERROR];
    careful = draw(2) == 0;
    t->nobody = must_fail = 0;
    const int status = entry->call(t);
    if (status < OK || status > ERROR) fail("status", entry->name);
    if ((entry->never || must_fail) && status <= WARNING) fail("succeeds inside", entry->name);
    if (status == ERROR && !t->nobody && logs & 1 << ERROR && t->told[ERROR] == told)
      fail("is not told inside a step", entry->name);
  }
  if (draw(50) == 0) fmi3FreeInstance(t->component); /* does not */
  t->inside = 0;
  careful = was_careful;
  t->nobody = nobody;
  must_fail = failing;
  *wish = draw(may_stop ? 8 : 2) == 0;
  if (*wish) *stop = time + 1e-3 * number();
}

static void instantiate(Target *t, const char *token) {
  /* an input, the last one, and outputs behind it that are continuous: a torque and a state */
  const unsigned required[] = {1, LAST_INPUT, LAST_INPUT + 1, LAST_INPUT + 3}, wrong[] = {REFERENCES + draw(9)};
  const int logging = draw(4) != 0;
  t->is_slave = draw(3) != 0;
  t->logs = logging ? 15 : 0;
  if (fmi3InstantiateScheduledExecution(INSTANCE_NAME, token, "", 0, logging, t, logger, NULL, NULL,
                                        NULL) ||
      fmi3InstantiateModelExchange(INSTANCE_NAME, "wrong %s#", "", 0, logging, t, logger) ||
      fmi3InstantiateModelExchange(NULL, token, NULL, 0, logging, t, logger) ||
      fmi3InstantiateModelExchange(INSTANCE_NAME, NULL, "", 0, logging, t, NULL) ||
      fmi3InstantiateCoSimulation(INSTANCE_NAME, token, "", 0, logging, 0, 0, wrong, 1, t, logger,
                                  NULL) ||
      fmi3InstantiateCoSimulation(INSTANCE_NAME, token, "", 0, logging, 0, 0, NULL, 1, t, logger,
                                  NULL) ||
      t->told[ERROR] != (logging ? 5 : 0))
    fail("instantiate", token);
  t->component =
      t->is_slave
          ? fmi3InstantiateCoSimulation(INSTANCE_NAME, token, NULL, 0, logging, draw(2), draw(2),
                                        required, 4, t, logger, draw(2) ? update : NULL)
          : fmi3InstantiateModelExchange(INSTANCE_NAME, token, NULL, 0, logging, t, logger);
}

int main(int argc, char **argv) {
  const Facade facade = {calls, progress, COUNT(calls), COUNT(progress), instantiate};
  return fuzz(&facade, argc, argv);
}
