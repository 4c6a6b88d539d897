/* Sequences of random calls, legal and illegal, of every function of a façade, for a build with
 * sanitizers. A sequence is the life of an instance, and takes turns with those of two others.
 *
 * fuzz_fmi2.c and fuzz_fmi3.c define, before they include this file, FMI(name) as the function of
 * that name in their version, the functions of the state, whose spelling differs,
 *   GET_STATE SET_STATE FREE_STATE STATE_SIZE SERIALISE DESERIALISE and Byte
 * and ALWAYS_LOGGED, GET_NUMBER, SET_NUMBER and GET_DERIVATIVES. The build defines the sizes of the model:
 *   REFERENCES STATES INDICATORS, and a reference of a type: REAL_ INTEGER_ ENUMERATION_ BOOLEAN_
 * An error must change nothing; what is not OK must be told by a message, safe to print; another
 * instance must not notice; every function must succeed now and then, but those that never may. */
#include <limits.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const int OK = 0, WARNING = 1, DISCARD = 2, ERROR = 3; /* in every version */
enum { SIZE = 8192, LENGTH = 8, TARGETS = 3 };
enum { DOUBLINGS = 10 }; /* a life has 1, 2, 4, ... or 512 calls, or so: 23 on the average */
enum { ENOUGH = 30000 }; /* calls, to see everything happen */

typedef struct {
  void *component;
  int is_slave;
  int logs;      /* bits 1 << status of what is told */
  long told[5];  /* messages by status */
  int nobody;    /* whether the last call was for NULL instead of the instance */
  int inside;    /* a step */
  void *kept;    /* a state */
  char bytes[SIZE];
  size_t size;   /* of the bytes kept */
  char last[SIZE]; /* its state, as bytes, after the last call */
  long left;     /* calls of its life */
} Target;

typedef struct {
  const char *name;
  int (*call)(Target *target);
  int never; /* succeeds */
} Entry;

typedef struct {
  const Entry *calls, *progress; /* all, and those that lead to deeper states */
  unsigned n_calls, n_progress;
  /* a new instance in an empty target; a few wrong ones before */
  void (*instantiate)(Target *target, const char *token);
} Facade;

static const char *const INSTANCE_NAME = "100%s%n#";
/* by status */
static const char *const category_name[4] = {"logEvents", "logStatusWarning", "logStatusDiscard",
                                             "logStatusError"};

/* ---- chance ---------------------------------------------------------------------------------- */

static unsigned long long seed = 1;
static int careful; /* arguments are legal ones */

static unsigned draw(unsigned n) { /* xorshift */
  seed ^= seed << 13;
  seed ^= seed >> 7;
  seed ^= seed << 17;
  return (unsigned)(seed >> 33) % n;
}

/* Once in n times, unless care is taken. */
static int wild(unsigned n) { return !careful && draw(n) == 0; }

#define OR_NULL(pointer) (wild(20) ? NULL : (pointer))

static double number(void) {
  switch (careful ? 9 : draw(25)) {
    case 0: return NAN;
    case 1: return INFINITY;
    case 2: return -1.7e308;
    case 3: return 1.7e308;
    case 4: return 5e-324;
    default: return ((double)draw(2001) - 1000.0) / 1000.0;
  }
}

static void fill(double *values) {
  for (int i = 0; i < LENGTH; i++) values[i] = number();
}

/* Inputs and outputs come first. */
static unsigned reference(void) {
  return careful ? 1 + draw(10) : draw(draw(2) ? 12 : REFERENCES + 3);
}

static unsigned input(void) { return careful ? 1 + draw(3) : reference(); }

static void fill_references(unsigned *references, unsigned legal) {
  for (int i = 0; i < LENGTH; i++) references[i] = careful ? legal : reference();
}

static size_t some(void) { return careful ? 1 + draw(2) : draw(3); }

static int must_fail; /* the call that is being made */

static size_t size_near(size_t n) {
  if (!wild(20)) return n;
  must_fail = 1;
  return n + 1 - 2 * draw(2);
}

static void *handle(Target *t) {
  t->nobody = wild(100);
  must_fail |= t->nobody;
  return t->nobody ? NULL : t->component;
}

/* ---- faults ---------------------------------------------------------------------------------- */

static const char *doing = "";
static long calls_made;

static void fail(const char *what, const char *detail) {
  fprintf(stderr, "%s: %s (%s, call %ld)\n", what, detail, doing, calls_made);
  exit(1);
}

/* `escaped` stands for itself only where it is doubled. */
static void check_message(Target *t, int status, const char *category, const char *message,
                          char escaped) {
  if (status < OK || status > ERROR || strcmp(category, category_name[status]) != 0)
    fail("category", category);
  if (!(t->logs & 1 << status)) fail("a message that is switched off", message);
  for (const char *c = message; *c; c++)
    if (*c == escaped && *++c != escaped) fail("a character that is not doubled", message);
  t->told[status]++;
}

/* ---- state ----------------------------------------------------------------------------------- */

static long forged[2]; /* states: taken, refused */

static size_t serialise(void *component, char *bytes) {
  void *state = NULL;
  size_t size = 0;
  if (GET_STATE(component, &state) != OK || STATE_SIZE(component, state, &size) != OK ||
      size > SIZE || SERIALISE(component, state, (Byte *)bytes, size) != OK ||
      FREE_STATE(component, &state) != OK)
    fail("serialise", "");
  return size;
}

static int call_serialise(Target *t) {
  if (!t->inside) t->size = serialise(t->component, t->bytes);
  return OK;
}

static int call_deserialise(Target *t) {
  char bytes[SIZE + 1];
  void *state = NULL;
  if (t->size == 0 || t->inside) return OK;
  void *const c = handle(t);
  memcpy(bytes, t->bytes, t->size);
  const size_t size = size_near(t->size);
  if (wild(2)) {
    bytes[draw((unsigned)t->size)] ^= (char)(1 << draw(7));
    must_fail = 1;
  }
  int status = DESERIALISE(c, (Byte *)OR_NULL(bytes), size, OR_NULL(&state));
  if (status == OK) status = SET_STATE(c, state);
  free(state); /* as FREE_STATE does, which may be refused here */
  return status;
}

/* The present state with other numbers in one to three places, and a checksum that fits them. */
static int call_forge(Target *t) {
  char bytes[SIZE];
  void *state = NULL;
  uint64_t sum = 14695981039346656037u; /* FNV-1a */
  if (t->inside || draw(4)) return OK;
  const size_t size = serialise(t->component, bytes), end = size - sizeof sum;
  for (unsigned n = 1 + draw(3); n > 0; n--) {
    const double real = number();
    const int whole = draw(2) ? (int)draw(200) - 100 : draw(2) ? INT_MAX : INT_MIN;
    const size_t at = 4 * draw((unsigned)end / 4 - 1); /* where numbers may begin */
    switch (draw(3)) {
      case 0: memcpy(bytes + at, &real, sizeof real); break;
      case 1: memcpy(bytes + at, &whole, sizeof whole); break;
      default: bytes[at + draw(8)] ^= (char)(1 << draw(7));
    }
  }
  for (size_t i = 0; i < end; i++) sum = (sum ^ (unsigned char)bytes[i]) * 1099511628211u;
  memcpy(bytes + end, &sum, sizeof sum);
  int status = DESERIALISE(t->component, (Byte *)bytes, size, &state);
  if (status == OK) status = SET_STATE(t->component, state);
  free(state);
  forged[status != OK]++;
  return status;
}

static int call_serialised_size(Target *t) {
  size_t size;
  return STATE_SIZE(handle(t), t->kept, OR_NULL(&size));
}

static int call_serialise_kept(Target *t) {
  char bytes[SIZE + 1];
  size_t size = 0;
  if (t->inside || !t->kept || STATE_SIZE(t->component, t->kept, &size) != OK) return OK;
  return SERIALISE(handle(t), t->kept, (Byte *)OR_NULL(bytes), size_near(size));
}

static int call_get_state(Target *t) { return GET_STATE(handle(t), OR_NULL(&t->kept)); }

static int call_set_state(Target *t) { return SET_STATE(handle(t), t->kept); }

static int call_free_state(Target *t) { return FREE_STATE(handle(t), OR_NULL(&t->kept)); }

/* ---- calls of one shape in every version ----------------------------------------------------- */

static int call_set_logging(Target *t) {
  const char *names[2] = {NULL};
  const unsigned n = draw(3), on = draw(3) != 0;
  int chosen = n ? 0 : 15;
  for (unsigned i = 0; i < n; i++) {
    const unsigned k = draw(4);
    names[i] = wild(10) ? "no %n" : category_name[k];
    chosen |= 1 << k;
  }
  const int status = FMI(SetDebugLogging)(handle(t), on, n, OR_NULL(names));
  if (status == OK) t->logs = (on ? chosen : t->logs & ~chosen) | ALWAYS_LOGGED;
  return status;
}

static int call_exit_initialisation(Target *t) { return FMI(ExitInitializationMode)(handle(t)); }

static int call_terminate(Target *t) { return draw(40) ? OK : (int)FMI(Terminate)(handle(t)); }

static int call_reset(Target *t) { return draw(40) ? OK : (int)FMI(Reset)(handle(t)); }

static int call_enter_event_mode(Target *t) { return FMI(EnterEventMode)(handle(t)); }

static int call_enter_continuous_time(Target *t) { return FMI(EnterContinuousTimeMode)(handle(t)); }

/* Of the instance; of no consequence. */
static double now(Target *t) {
  const unsigned time = 0;
  double result = 0.0;
  long told[5];
  memcpy(told, t->told, sizeof told);
  GET_NUMBER(t->component, &time, &result);
  memcpy(t->told, told, sizeof told);
  return result;
}

/* A load, or a joint's velocity, that no step bears. */
static int call_overload(Target *t) {
  const unsigned input = LAST_INPUT;
  const double load = 1.7e308;
  return SET_NUMBER(handle(t), &input, &load);
}

static int call_set_time(Target *t) {
  const double time = wild(3) ? number() : now(t) + 1e-3 * fabs(number());
  return FMI(SetTime)(handle(t), time);
}

static int call_set_states(Target *t) {
  double x[STATES + 1];
  for (int i = 0; i <= STATES; i++) x[i] = number();
  const size_t n = size_near(STATES);
  return FMI(SetContinuousStates)(handle(t), OR_NULL(x), n);
}

static int call_get_states(Target *t) {
  double x[STATES + 1];
  return FMI(GetContinuousStates)(handle(t), OR_NULL(x), size_near(STATES));
}

static int call_get_derivatives(Target *t) {
  double rates[STATES + 1];
  return GET_DERIVATIVES(handle(t), OR_NULL(rates), size_near(STATES));
}

static int call_get_nominals(Target *t) {
  double nominals[STATES + 1];
  return FMI(GetNominalsOfContinuousStates)(handle(t), OR_NULL(nominals), size_near(STATES));
}

static int call_get_indicators(Target *t) {
  double z[INDICATORS + 1];
  return FMI(GetEventIndicators)(handle(t), OR_NULL(z), size_near(INDICATORS));
}

/* Step size, s: not more than what takes a moment. */
static double step_size(void) {
  switch (careful ? 9 : draw(12)) {
    case 0: return number();
    case 1: return 1e-13;
    default: return 2e-5 * (1 + draw(500));
  }
}

#define COMMON_CALLS                                                                               \
  {"SetDebugLogging", call_set_logging, 0}, {"Terminate", call_terminate, 0},                      \
  {"Reset", call_reset, 0}, {"serialise", call_serialise, 0},                                      \
  {"SerializedFMUStateSize", call_serialised_size, 0}, {"SerializeFMUState", call_serialise_kept, 0}, \
  {"DeserializeFMUState", call_deserialise, 0}, {"GetFMUState", call_get_state, 0},                \
  {"SetFMUState", call_set_state, 0}, {"FreeFMUState", call_free_state, 0},                        \
  {"forge", call_forge, 0},                                                                        \
  {"overload", call_overload, 0}, {"SetTime", call_set_time, 0},                                   \
  {"SetContinuousStates", call_set_states, 0},                                                     \
  {"GetContinuousStates", call_get_states, 0}, {"derivatives", call_get_derivatives, 0},           \
  {"GetNominalsOfContinuousStates", call_get_nominals, 0},                                         \
  {"GetEventIndicators", call_get_indicators, 0}

#define COMMON_PROGRESS                                                                            \
  {"ExitInitializationMode", call_exit_initialisation, 0},                                         \
  {"EnterEventMode", call_enter_event_mode, 0},                                                    \
  {"EnterContinuousTimeMode", call_enter_continuous_time, 0}

#define COUNT(table) (sizeof(table) / sizeof *(table))

/* ---- the run --------------------------------------------------------------------------------- */

static void renew(const Facade *facade, Target *t, const char *token) {
  doing = "instantiate";
  if (t->component) FREE_STATE(t->component, &t->kept);
  FMI(FreeInstance)(t->component);
  memset(t, 0, sizeof *t);
  careful = 1;
  facade->instantiate(t, token);
  if (!t->component) fail("no instance", token);
  serialise(t->component, t->last);
  t->left = 1L << draw(1 + draw(DOUBLINGS));
}

/* One call, and what must hold after it. */
static int try_call(Target *t, Target *other, const Entry *entry) {
  static char after[SIZE];
  const int logs = t->logs, look_beside = draw(16) == 0;
  long told[5];
  memcpy(told, t->told, sizeof told);
  t->nobody = must_fail = 0;
  doing = entry->name;
  const int status = entry->call(t);
  doing = entry->name;
  if (status < OK || status > ERROR) fail("status", entry->name);
  if ((entry->never || must_fail) && status <= WARNING) fail("succeeds", entry->name);
  const size_t size = serialise(t->component, after);
  if (status == ERROR && memcmp(t->last, after, size) != 0) fail("an error changes", entry->name);
  memcpy(t->last, after, size);
  if (status != OK && !t->nobody && logs & 1 << status && t->told[status] == told[status])
    fail("is not told", entry->name);
  if (look_beside && (serialise(other->component, after), memcmp(other->last, after, size) != 0))
    fail("another instance is changed", entry->name);
  return status;
}

static const Entry *entry_of(const Facade *facade, unsigned k) {
  return k < facade->n_calls ? &facade->calls[k] : &facade->progress[k - facade->n_calls];
}

typedef struct {
  Target targets[TARGETS];
  long succeeded[100], results[4]; /* by call, by status */
} Run;

static int make_call(Run *run, const Facade *facade, unsigned target, unsigned k) {
  Target *other = &run->targets[(target + 1) % TARGETS];
  const int status = try_call(&run->targets[target], other, entry_of(facade, k));
  run->succeeded[k] += status <= WARNING;
  run->results[status]++;
  run->targets[target].left--;
  calls_made++;
  return status;
}

/* Legal calls until one of them leads on. */
static void make_progress(Run *run, const Facade *facade, unsigned target) {
  const unsigned n = facade->n_progress, first = draw(n);
  careful = 1;
  for (unsigned i = 0; i < n; i++)
    if (make_call(run, facade, target, facade->n_calls + (first + i) % n) <= WARNING) return;
  Target *t = &run->targets[target];
  FMI(Reset)(t->component); /* after the end, and past the stop time */
  serialise(t->component, t->last);
}

static void check_coverage(const Run *run, const Facade *facade) {
  for (unsigned k = 0; k < facade->n_calls + facade->n_progress; k++) {
    doing = entry_of(facade, k)->name;
    if (run->succeeded[k] == 0 && !entry_of(facade, k)->never) fail("never succeeds", "");
  }
  for (int status = OK; status <= ERROR; status++)
    if (run->results[status] == 0) fail("a status is never seen", category_name[status]);
}

/* Arguments of the program: token, number of sequences, seed. */
static int fuzz(const Facade *facade, int argc, char **argv) {
  static Run run;
  if (argc != 4 || facade->n_calls + facade->n_progress > COUNT(run.succeeded)) return 2;
  const long sequences = atol(argv[2]);
  long ended = 0;
  seed = 2 * strtoull(argv[3], NULL, 10) + 1; /* never zero */
  for (int i = 0; i < 20; i++) draw(2);       /* nor near it */
  for (int i = 0; i < TARGETS; i++) renew(facade, &run.targets[i], argv[1]);
  while (ended < sequences) {
    const unsigned target = draw(TARGETS);
    if (run.targets[target].left <= 0) {
      renew(facade, &run.targets[target], argv[1]);
      ended++;
    }
    careful = draw(2) == 0;
    if (draw(8) == 0)
      make_progress(&run, facade, target);
    else
      make_call(&run, facade, target, draw(facade->n_calls + facade->n_progress));
  }
  if (calls_made >= ENOUGH) check_coverage(&run, facade);
  for (int i = 0; i < TARGETS; i++) {
    FREE_STATE(run.targets[i].component, &run.targets[i].kept);
    FMI(FreeInstance)(run.targets[i].component);
  }
  printf("%ld sequences, %ld calls: %ld ok, %ld warnings, %ld discarded, %ld errors; %ld of %ld "
         "forged states refused\n",
         ended, calls_made, run.results[OK], run.results[WARNING], run.results[DISCARD],
         run.results[ERROR], forged[1], forged[0] + forged[1]);
  return 0;
}
