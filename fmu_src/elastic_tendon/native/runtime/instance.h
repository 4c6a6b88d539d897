/* One instance of the model, as any version of FMI sees it.
 *
 * An instance is configuration plus one plain-data State, which is copied to save and to roll
 * back. Variables are addressed by value reference in the generated table `variables`. Calls
 * report through `report`, which names instance, call and time; a call that fails changes nothing.
 */
#ifndef INSTANCE_H
#define INSTANCE_H

#include <stddef.h>
#include <stdint.h>

#include "compilers.h"
#include "solver.h"

/* ---- life of an instance --------------------------------------------------------------------- */

typedef enum { STATUS_OK, STATUS_WARNING, STATUS_DISCARD, STATUS_ERROR } Status;

/* Bits, so that the calls allowed can be masks. */
typedef enum { MODEL_EXCHANGE = 1, CO_SIMULATION = 2 } Interface;
enum { ANY_INTERFACE = MODEL_EXCHANGE | CO_SIMULATION };

typedef enum {
  INSTANTIATED = 1,
  INITIALISATION = 2,
  EVENT = 4,
  CONTINUOUS = 8,
  STEP_COMPLETE = 16,
  STEP_FAILED = 32,
  TERMINATED = 64,
  INTERMEDIATE = 128 /* inside a step, while the importer looks at it */
} Phase;
enum { ANY_PHASE = 127 }; /* but inside a step */

typedef struct {
  Motion motion;               /* time, states, modes and memory of the solver */
  double input[N_INPUTS];
  double input_rate[N_INPUTS]; /* unit of the input per second; co-simulation only */
  double parameter[N_PARAMETERS];
  double start_time, stop_time; /* s; stop_time infinite where there is none */
  double tolerance;
  int experiment_defined;
  int connected[N_INPUTS]; /* 0: the rate of another input is not given, but derived from it */
  int outside_validity; /* as of the last event */
  /* In co-simulation it is derived from inputs at the last point at which they were known, unless
   * their rates were given. */
  int rate_given[N_INPUTS];
  double earlier_time, earlier[N_INPUTS], derived[N_INPUTS];
  int jumped; /* a state has jumped since event mode was entered */
  int judge_velocity; /* whether the model needs motor_velocity is still to be told */
  int velocity_warned; /* has been told, */
  int warned[N_MODES]; /* and that the mode became 1 */
  int last_step; /* Status of the last step, */
  int at_event;  /* and whether it ended at an event */
  int phase;
} State;

/* Everything calculated from a State. */
typedef struct {
  int valid;
  double x[N_STATES], mode[N_MODES], u[N_INPUTS], u_rate[N_INPUTS];
  double rates[N_STATES], outputs[N_OUTPUTS];
} View;

typedef struct Instance Instance;

enum {
  ALL_CATEGORIES = (1 << N_CATEGORIES) - 1,
  ALWAYS_LOGGED = ALL_CATEGORIES & ~(1 << LOG_EVENTS) /* in FMI 2.0, whether debugging or not */
};
/* Takes the finished text; the façade passes it on in its version's manner. */
typedef void LogSink(const Instance *instance, Status status, Category category, const char *text);

/* Lets the importer look and set inputs after each step of the solver. Returns whether it wants to
 * stop, if it may, and then at what time. */
typedef int IntermediateUpdate(const Instance *instance, int may_stop, double *stop);

struct Instance {
  State state;
  Solver solver; /* its motion and signal are scratch: loaded from the state before use */
  double memory[SOLVER_MEMORY(0)];
  double prepared[N_PREPARED]; /* the parameters, as the solver takes them */
  View view;
  int interface;
  int event_mode;   /* co-simulation in which the importer handles events, */
  int early_return; /* and in which a step may end early */
  IntermediateUpdate *intermediate;        /* NULL where the importer does not want any */
  unsigned char is_intermediate[N_VARIABLES]; /* what it may access then */
  const char *call; /* the façade's function being executed, for messages */
  LogSink *sink;
  void *environment;
  void (*callback)(void); /* the importer's logger, of the façade's type, */
  void (*update)(void);   /* and its intermediate update */
  int logged;             /* bits of the categories that are told */
  char name[]; /* last: its length is the importer's choice */
};

/* What event iteration found. */
typedef struct {
  int again, jumped;
} EventOutcome;

/* ---- calls ----------------------------------------------------------------------------------- */

/* NULL where memory is short. The only allocation of an instance. */
static Instance *instance_create(const char *name, int interface);
static void instance_reset(Instance *instance);

/* Log and return the status, so that a call ends with `return report(...)`. */
PRINTS(3, 4)
static Status report(Instance *instance, Status status, const char *format, ...);

/* Switch categories, all where none is named, on or off. */
static Status set_logging(Instance *instance, int on, size_t n, const char *const *categories);

/* Whether the reference exists, is of one of the types and may be accessed now. */
static Status check_reference(Instance *instance, unsigned reference, int types);
/* Whether, besides, the value may be set now. Storing after a check cannot fail. */
static Status check_set(Instance *instance, unsigned reference, int types, double value);
static void store(Instance *instance, unsigned reference, double value);
/* Value of an existing reference. */
static Status get(Instance *instance, unsigned reference, double *value);
/* Whether a variable is outside the range in which the model was validated. */
static Status judge_validity(Instance *instance, int *outside);
/* Value of a state; a start that is calculated is known from initialisation mode on. */
static Status state_value(Instance *instance, int i, double *value);
/* Make view hold what follows from the state. */
static Status look(Instance *instance);

static Status set_experiment(Instance *instance, const double *tolerance, double start,
                             const double *stop);
static Status enter_initialisation(Instance *instance);
static Status exit_initialisation(Instance *instance);

static void enter_event_mode(Instance *instance);

/* Model exchange. */
static Status set_time(Instance *instance, double time);
static Status set_states(Instance *instance, const double *x);
static Status iterate_events(Instance *instance, EventOutcome *outcome);

/* Co-simulation: integrate from a communication point to exactly from + h, or to the event or the
 * wish of the importer that ends the step early. */
static Status step(Instance *instance, double from, double h, int *at_event);

/* Unknowns (outputs, derivatives) by knowns (inputs, states, and parameters that can be set now): the
 * derivative along the direction `seed` in the knowns. */
typedef struct {
  const unsigned *unknown, *known;
  size_t n_unknowns, n_knowns;
} Pairs;
static Status directional(Instance *instance, const Pairs *pairs, const double *seed,
                          double *result);
/* First time derivatives of outputs, from the derivatives of states and inputs. */
static Status output_rates(Instance *instance, const unsigned *output, size_t n, double *result);

/* A State with what tells whether it belongs to this model and kind of instance. */
typedef struct {
  uint32_t magic, version;
  uint64_t size;
  char token[sizeof MODEL_TOKEN];
  int interface;
  State state;
  uint64_t checksum; /* of the bytes before it */
} Snapshot;

static void snapshot_take(const Instance *instance, Snapshot *snapshot);
static Status snapshot_check(Instance *instance, const Snapshot *snapshot);
/* Copies; the snapshot stays as it is. */
static void snapshot_restore(Instance *instance, const Snapshot *snapshot);

#endif
