/* Random calls of FMI 2.0; see fuzz.h. */
#include "fmi2Functions.h"

#define FMI(name) fmi2##name
#define GET_STATE fmi2GetFMUstate
#define SET_STATE fmi2SetFMUstate
#define FREE_STATE fmi2FreeFMUstate
#define STATE_SIZE fmi2SerializedFMUstateSize
#define SERIALISE fmi2SerializeFMUstate
#define DESERIALISE fmi2DeSerializeFMUstate
#define GET_NUMBER(c, reference, value) fmi2GetReal(c, reference, 1, value)
#define SET_NUMBER(c, reference, value) fmi2SetReal(c, reference, 1, value)
#define GET_DERIVATIVES fmi2GetDerivatives
#define ALWAYS_LOGGED 14 /* warnings, discarded, errors */
typedef char Byte;

#include "fuzz.h"

static void logger(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status,
                   fmi2String category, fmi2String message, ...) {
  if (strcmp(name, INSTANCE_NAME) != 0) fail("name", name);
  check_message(environment, (int)status, category, message, '%');
}

/* ---- calls ----------------------------------------------------------------------------------- */

static int call_information(Target *t) {
  (void)t;
  return strcmp(fmi2GetTypesPlatform(), "default") || strcmp(fmi2GetVersion(), "2.0");
}

static int call_set_up_experiment(Target *t) {
  const int stops = draw(4) == 0;
  const double tolerance = wild(4) ? number() : draw(8) ? 1e-6 : 1.0;
  return fmi2SetupExperiment(handle(t), draw(2), tolerance, wild(4) ? number() : 0.0, stops, 0.05);
}

static int call_enter_initialisation(Target *t) { return fmi2EnterInitializationMode(handle(t)); }

static int call_get_real(Target *t) {
  unsigned vr[LENGTH];
  double values[LENGTH];
  fill_references(vr, REAL_);
  return fmi2GetReal(handle(t), OR_NULL(vr), some(), OR_NULL(values));
}

static int call_get_integer(Target *t) {
  unsigned vr[LENGTH];
  int values[LENGTH];
  fill_references(vr, INTEGER_);
  return fmi2GetInteger(handle(t), OR_NULL(vr), some(), OR_NULL(values));
}

static int call_get_boolean(Target *t) {
  unsigned vr[LENGTH];
  int values[LENGTH];
  fill_references(vr, BOOLEAN_);
  return fmi2GetBoolean(handle(t), OR_NULL(vr), some(), OR_NULL(values));
}

static int call_get_string(Target *t) {
  unsigned vr[LENGTH];
  fmi2String values[LENGTH];
  fill_references(vr, 0);
  return fmi2GetString(handle(t), OR_NULL(vr), draw(2), OR_NULL(values));
}

static int call_set_real(Target *t) {
  unsigned vr[LENGTH];
  double values[LENGTH];
  fill_references(vr, input());
  fill(values);
  return fmi2SetReal(handle(t), OR_NULL(vr), some(), OR_NULL(values));
}

static int call_set_integer(Target *t) {
  unsigned vr[LENGTH];
  const int values[LENGTH] = {(int)draw(5) - 1, 1};
  fill_references(vr, INTEGER_);
  return fmi2SetInteger(handle(t), OR_NULL(vr), some(), OR_NULL(values));
}

static int call_set_boolean(Target *t) {
  unsigned vr[LENGTH];
  const int values[LENGTH] = {(int)draw(2), 1};
  fill_references(vr, BOOLEAN_);
  return fmi2SetBoolean(handle(t), OR_NULL(vr), some(), OR_NULL(values));
}

static int call_set_string(Target *t) {
  unsigned vr[LENGTH];
  const fmi2String values[LENGTH] = {"%n"};
  fill_references(vr, 0);
  return fmi2SetString(handle(t), OR_NULL(vr), draw(2), OR_NULL(values));
}

static int call_directional(Target *t) {
  unsigned unknown[LENGTH], known[LENGTH];
  double direction[LENGTH], result[LENGTH];
  fill_references(unknown, REAL_);
  fill_references(known, input());
  fill(direction);
  return fmi2GetDirectionalDerivative(handle(t), OR_NULL(unknown), some(), OR_NULL(known), some(),
                                      OR_NULL(direction), OR_NULL(result));
}

static int call_new_discrete_states(Target *t) {
  fmi2EventInfo info;
  return fmi2NewDiscreteStates(handle(t), OR_NULL(&info));
}

static int call_completed_step(Target *t) {
  fmi2Boolean enter, terminate;
  return fmi2CompletedIntegratorStep(handle(t), draw(2), OR_NULL(&enter), OR_NULL(&terminate));
}

static int call_input_derivatives(Target *t) {
  const unsigned vr[] = {input()};
  const int order[] = {wild(8) ? (int)draw(3) : 1};
  const double value[] = {number()};
  return fmi2SetRealInputDerivatives(handle(t), OR_NULL(vr), draw(2), OR_NULL(order),
                                     OR_NULL(value));
}

static int call_output_derivatives(Target *t) {
  const unsigned vr[] = {careful ? REAL_ : reference()};
  const int order[] = {wild(8) ? (int)draw(3) : 1};
  double value[1];
  return fmi2GetRealOutputDerivatives(handle(t), OR_NULL(vr), draw(2), OR_NULL(order),
                                      OR_NULL(value));
}

static int call_step(Target *t) {
  const double time = wild(4) ? number() : now(t);
  return fmi2DoStep(handle(t), time, step_size(), draw(2));
}

static int call_cancel(Target *t) { return fmi2CancelStep(handle(t)); }

static int call_status(Target *t) {
  fmi2Status value;
  return fmi2GetStatus(handle(t), (fmi2StatusKind)draw(4), OR_NULL(&value));
}

static int call_real_status(Target *t) {
  double value;
  return fmi2GetRealStatus(handle(t), (fmi2StatusKind)draw(4), OR_NULL(&value));
}

static int call_integer_status(Target *t) {
  int value;
  return fmi2GetIntegerStatus(handle(t), (fmi2StatusKind)draw(4), OR_NULL(&value));
}

static int call_boolean_status(Target *t) {
  int value;
  return fmi2GetBooleanStatus(handle(t), (fmi2StatusKind)draw(4), OR_NULL(&value));
}

static int call_string_status(Target *t) {
  fmi2String value;
  return fmi2GetStringStatus(handle(t), (fmi2StatusKind)draw(4), OR_NULL(&value));
}

static const Entry calls[] = {
    COMMON_CALLS,
    {"GetTypesPlatform, GetVersion", call_information, 0},
    {"GetReal", call_get_real, 0},
    {"GetInteger", call_get_integer, 0},
    {"GetBoolean", call_get_boolean, 0},
    {"GetString", call_get_string, 0},
    {"SetReal", call_set_real, 0},
    {"SetInteger", call_set_integer, 0},
    {"SetBoolean", call_set_boolean, 0},
    {"SetString", call_set_string, 0},
    {"GetDirectionalDerivative", call_directional, 0},
    {"CompletedIntegratorStep", call_completed_step, 0},
    {"SetRealInputDerivatives", call_input_derivatives, 0},
    {"GetRealOutputDerivatives", call_output_derivatives, 0},
    {"CancelStep", call_cancel, 1},
    {"GetStatus", call_status, 0},
    {"GetRealStatus", call_real_status, 0},
    {"GetIntegerStatus", call_integer_status, 1},
    {"GetBooleanStatus", call_boolean_status, 0},
    {"GetStringStatus", call_string_status, 0},
};

static const Entry progress[] = {
    COMMON_PROGRESS,
    {"SetupExperiment", call_set_up_experiment, 0},
    {"EnterInitializationMode", call_enter_initialisation, 0},
    {"NewDiscreteStates", call_new_discrete_states, 0},
    {"DoStep", call_step, 0},
};

/* ---- instances ------------------------------------------------------------------------------- */

static void instantiate(Target *t, const char *token) {
  const fmi2CallbackFunctions functions = {logger, NULL, NULL, NULL, t};
  const int logging = (int)draw(2);
  t->is_slave = (int)draw(2);
  t->logs = logging ? 15 : ALWAYS_LOGGED;
  if (fmi2Instantiate(INSTANCE_NAME, fmi2CoSimulation, "wrong %s", "", &functions, 0, logging) ||
      fmi2Instantiate(INSTANCE_NAME, fmi2CoSimulation, NULL, "", &functions, 0, logging) ||
      fmi2Instantiate(INSTANCE_NAME, (fmi2Type)7, token, "", &functions, 0, logging) ||
      fmi2Instantiate(INSTANCE_NAME, fmi2CoSimulation, token, NULL, NULL, 0, logging) ||
      t->told[ERROR] != 3)
    fail("instantiate", token);
  t->component = fmi2Instantiate(INSTANCE_NAME, t->is_slave ? fmi2CoSimulation : fmi2ModelExchange,
                                 token, NULL, &functions, 0, logging);
}

int main(int argc, char **argv) {
  const Facade facade = {calls, progress, COUNT(calls), COUNT(progress), instantiate};
  return fuzz(&facade, argc, argv);
}
