/* Time of one compiled right-hand side, ns: printed for benchmark_simulate.py, which compiles this
 * file together with the model and the solver. Each call depends on the one before, as in a solver. */
#include "simulation.c"

#include <stdio.h>
#include <time.h>

static double now(void) {
  struct timespec t;
  timespec_get(&t, TIME_UTC);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

int main(int argc, char **argv) {
  double p[N_PREPARED], x[N_STATES], u[N_INPUTS] = {0.05}, rate[N_STATES], best = 1e9;
  if (argc != 1 + N_PARAMETERS) return 2;
  for (int i = 0; i < N_PARAMETERS; i++) p[i] = strtod(argv[1 + i], NULL);
  model_prepare(p, p + N_PARAMETERS);
  for (int repetition = 0; repetition < 20; repetition++) {
    memset(x, 0, sizeof x);
    const double begin = now();
    for (int i = 0; i < 1000000; i++) {
      model_rates(x, u, p, mode_start, rate);
      x[0] += 1e-9 * rate[1];
    }
    const double each = (now() - begin) * 1e3;
    if (each < best && isfinite(x[0])) best = each;
  }
  printf("%.2f\n", best);
  return 0;
}
