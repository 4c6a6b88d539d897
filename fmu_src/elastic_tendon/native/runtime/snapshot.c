/* The state of an instance as plain data, for roll-back and for storage. */
#include <math.h>
#include <string.h>

#include "instance.h"

#define SNAPSHOT_MAGIC 0x45544E44u /* also tells the byte order */
#define SNAPSHOT_VERSION 1u

/* FNV-1a: any change of a single byte shows. */
static uint64_t checksum_of(const Snapshot *snapshot) {
  const unsigned char *byte = (const unsigned char *)snapshot;
  uint64_t sum = 14695981039346656037u;
  for (size_t i = 0; i < offsetof(Snapshot, checksum); i++) sum = (sum ^ byte[i]) * 1099511628211u;
  return sum;
}

static void snapshot_take(const Instance *instance, Snapshot *snapshot) {
  memset(snapshot, 0, sizeof *snapshot); /* padding too, so that equal states are equal bytes */
  snapshot->magic = SNAPSHOT_MAGIC;
  snapshot->version = SNAPSHOT_VERSION;
  snapshot->size = sizeof *snapshot;
  memcpy(snapshot->token, MODEL_TOKEN, sizeof snapshot->token);
  snapshot->interface = instance->interface;
  memcpy(&snapshot->state, &instance->state, sizeof snapshot->state);
  snapshot->checksum = checksum_of(snapshot);
}

static int phase_fits(int phase, const Instance *instance) {
  const int of_interface = instance->interface == MODEL_EXCHANGE ? EVENT | CONTINUOUS
                           : instance->event_mode ? EVENT | STEP_COMPLETE | STEP_FAILED
                                                  : STEP_COMPLETE | STEP_FAILED;
  const int one_bit = phase > 0 && (phase & (phase - 1)) == 0;
  return one_bit && (phase & (of_interface | INSTANTIATED | INITIALISATION | TERMINATED));
}

/* Who computes the checksum anew can write any numbers. Those that no call would have stored, and that
 * the solver relies on, are refused; all others lead to motions, or to errors that are told. */
static int numbers_fit(const State *state) {
  const Motion *motion = &state->motion;
  for (unsigned i = 0; i < N_VARIABLES; i++) {
    const VariableInfo *variable = &variables[i];
    if (variable->role != ROLE_PARAMETER) continue;
    const double value = state->parameter[variable->index];
    if (!(isfinite(value) && value >= variable->lower && value <= variable->upper)) return 0;
  }
  return isfinite(motion->time) && isfinite(state->start_time) && motion->judged >= 0 &&
         motion->judged < STEPS_TO_JUDGE && state->tolerance >= SMALLEST_TOLERANCE &&
         state->tolerance <= LARGEST_TOLERANCE && state->last_step >= STATUS_OK &&
         state->last_step <= STATUS_ERROR;
}

static Status snapshot_check(Instance *instance, const Snapshot *snapshot) {
  if (snapshot->magic != SNAPSHOT_MAGIC || snapshot->version != SNAPSHOT_VERSION)
    return report(instance, STATUS_ERROR, "this is no state of an instance of this version");
  if (memcmp(snapshot->token, MODEL_TOKEN, sizeof snapshot->token) != 0)
    return report(instance, STATUS_ERROR, "the state belongs to another model");
  if (snapshot->size != sizeof *snapshot || snapshot->checksum != checksum_of(snapshot))
    return report(instance, STATUS_ERROR, "the state is damaged");
  if (snapshot->interface != instance->interface ||
      !phase_fits(snapshot->state.phase, instance))
    return report(instance, STATUS_ERROR, "the state belongs to another kind of instance");
  if (!numbers_fit(&snapshot->state))
    return report(instance, STATUS_ERROR, "the state has numbers that no instance would have");
  return STATUS_OK;
}

static void snapshot_restore(Instance *instance, const Snapshot *snapshot) {
  memcpy(&instance->state, &snapshot->state, sizeof instance->state);
  instance->view.valid = 0;
}
