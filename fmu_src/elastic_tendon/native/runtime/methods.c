/* One step of each method, with frozen modes, for the states and their sensitivities.
 *
 * The vector is y = [x, dx/dv_1, ..., dx/dv_m]; each sensitivity obeys s' = f_x s + f_v. Both
 * methods leave the derivative of the numerical solution itself: the sensitivities are exact for
 * the steps taken. Step size control looks at the states alone.
 */
#include <math.h>
#include <string.h>

#include "compilers.h"
#include "solver.h"

#define MOST_ROWS (N_STATES > N_OUTPUTS ? N_STATES : N_OUTPUTS)
#define LENGTH(directions) (N_STATES * (1 + (directions)))

/* ---- inputs and right-hand side -------------------------------------------------------------- */

ALWAYS_INLINE void signal_at(const Signal *signal, double t, double *u) {
  const double d = t - signal->origin;
  for (int i = 0; i < N_INPUTS; i++) {
    const double *c = signal->coefficient[i];
    u[i] = c[0] + d * (c[1] + d * (c[2] + d * c[3]));
  }
}

static void signal_rate(const Signal *signal, double t, double *u_rate) {
  const double d = t - signal->origin;
  for (int i = 0; i < N_INPUTS; i++) {
    const double *c = signal->coefficient[i];
    u_rate[i] = c[1] + d * (2 * c[2] + d * 3 * c[3]);
  }
}

/* result = J[:, states] s + J[:, direction] for a sparse Jacobian by v; direction in v. A state's
 * own column is left out: a sensitivity to an initial state enters through s alone. Inlined, as the
 * pattern is known then and no index is looked up. */
ALWAYS_INLINE void multiply(const Pattern *pattern, const double *nonzeros, const double *s,
                            int direction, int rows, double *result) {
  double sum[MOST_ROWS];
  for (int i = 0; i < rows; i++) sum[i] = 0.0;
#pragma GCC unroll 64
  for (int j = 0; j < N_STATES; j++)
#pragma GCC unroll 64
    for (int k = pattern->columns[j]; k < pattern->columns[j + 1]; k++)
      sum[pattern->rows[k]] += nonzeros[k] * s[j];
  for (int i = 0; i < rows; i++) result[i] = sum[i];
  if (direction < V_PARAMETERS) return;
  for (int k = pattern->columns[direction]; k < pattern->columns[direction + 1]; k++)
    result[pattern->rows[k]] += nonzeros[k];
}

/* Rates of every sensitivity. */
NEVER_INLINE static void multiply_rates(const double *nonzeros, const int *direction,
                                        const double *s, int m, double *result) {
  for (int j = 0; j < m; j++)
    multiply(&rates_jacobian_pattern, nonzeros, s + j * N_STATES, direction[j], N_STATES,
             result + j * N_STATES);
}

/* What the right-hand side does not change within a step. As a local copy it cannot alias the
 * vectors, so the compiler evaluates what depends on parameters alone once for all stages. */
typedef struct {
  Signal signal;
  double p[N_PREPARED], mode[N_MODES];
} Frozen;

ALWAYS_INLINE Frozen freeze(const Solver *s) {
  Frozen frozen = {.signal = s->signal};
  memcpy(frozen.p, s->p, sizeof frozen.p);
  memcpy(frozen.mode, s->motion.mode, sizeof frozen.mode);
  return frozen;
}

ALWAYS_INLINE void rates_at(const Frozen *frozen, const int *direction, double t, const double *y,
                            int m, double *y_rate) {
  double u[N_INPUTS];
  signal_at(&frozen->signal, t, u);
  model_rates(y, u, frozen->p, frozen->mode, y_rate);
  if (m == 0) return;
  double nonzeros[N_RATES_JACOBIAN];
  model_rates_jacobian(y, u, frozen->p, frozen->mode, nonzeros);
  multiply_rates(nonzeros, direction, y + N_STATES, m, y_rate + N_STATES);
}

/* Squared error of the states in units of the tolerance, mean over the states. */
ALWAYS_INLINE double squared_norm(const Solver *s, const double *error, const double *x,
                                  const double *x_new) {
  double sum = 0.0;
  for (int i = 0; i < N_STATES; i++) {
    double size = fabs(x[i]) > fabs(x_new[i]) ? fabs(x[i]) : fabs(x_new[i]);
    size = size > state_nominal[i] ? size : state_nominal[i];
    const double e = error[i] / (s->tolerance * size);
    sum += e * e;
  }
  return N_STATES ? sum / N_STATES : 0.0;
}

/* ---- Dormand-Prince 5(4) -------------------------------------------------------------------- */
/* J. R. Dormand, P. J. Prince, A family of embedded Runge-Kutta formulae, 1980. */

static const double DP_C[7] = {0, 1. / 5, 3. / 10, 4. / 5, 8. / 9, 1, 1};
static const double DP_A[7][6] = {
    {0},
    {1. / 5},
    {3. / 40, 9. / 40},
    {44. / 45, -56. / 15, 32. / 9},
    {19372. / 6561, -25360. / 2187, 64448. / 6561, -212. / 729},
    {9017. / 3168, -355. / 33, 46732. / 5247, 49. / 176, -5103. / 18656},
    {35. / 384, 0, 500. / 1113, 125. / 192, -2187. / 6784, 11. / 84}};
static const double DP_ERROR[7] = {71. / 57600,       0,           -71. / 16695, 71. / 1920,
                                   -17253. / 339200, 22. / 525, -1. / 40};
/* L. F. Shampine, Some practical Runge-Kutta formulas, 1986: x + h sum k_i (D_i1 a + D_i2 a^2...) */
static const double DP_DENSE[7][4] = {
    {1, -8048581381. / 2820520608, 8663915743. / 2820520608, -12715105075. / 11282082432},
    {0, 0, 0, 0},
    {0, 131558114200. / 32700410799, -68118460800. / 10900136933, 87487479700. / 32700410799},
    {0, -1754552775. / 470086768, 14199869525. / 1410260304, -10690763975. / 1880347072},
    {0, 127303824393. / 49829197408, -318862633887. / 49829197408, 701980252875. / 199316789632},
    {0, -282668133. / 205662961, 2019193451. / 616988883, -1453857185. / 822651844},
    {0, 40617522. / 29380423, -110615467. / 29380423, 69997945. / 29380423}};

/* Takes stage k[0] = rates at y as given; leaves k[6] = rates at the new vector.
 * Returns the squared error norm. */
ALWAYS_INLINE double dormand_prince(Solver *s, const double *y, int m, double h, double *k,
                                    double *y_new) {
  const int n = LENGTH(m);
  const Frozen frozen = freeze(s);
#pragma GCC unroll 6
  for (int stage = 1; stage < 7; stage++) {
    /* the newest stage comes last and alone: all else is ready before it */
    const double newest = h * DP_A[stage][stage - 1];
    for (int i = 0; i < n; i++) {
      double sum = 0.0;
#pragma GCC unroll 5
      for (int j = 0; j < stage - 1; j++) sum += DP_A[stage][j] * k[j * n + i];
      y_new[i] = y[i] + h * sum + newest * k[(stage - 1) * n + i];
    }
    rates_at(&frozen, s->direction, s->motion.time + DP_C[stage] * h, y_new, m, k + stage * n);
  }
  s->statistics.rates += 6;
  double error[N_STATES];
  for (int i = 0; i < N_STATES; i++) {
    double sum = 0.0;
    for (int j = 0; j < 7; j++) sum += DP_ERROR[j] * k[j * n + i];
    error[i] = h * sum;
  }
  return squared_norm(s, error, y, y_new);
}

/* ---- Radau IIA, order 5 --------------------------------------------------------------------- */
/* E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, section IV.8. */

#define SQRT6 2.4494897427831781
static const double RADAU_C[3] = {(4 - SQRT6) / 10, (4 + SQRT6) / 10, 1};
static const double RADAU_A[3][3] = {
    {(88 - 7 * SQRT6) / 360, (296 - 169 * SQRT6) / 1800, (-2 + 3 * SQRT6) / 225},
    {(296 + 169 * SQRT6) / 1800, (88 + 7 * SQRT6) / 360, (-2 - 3 * SQRT6) / 225},
    {(16 - SQRT6) / 36, (16 + SQRT6) / 36, 1. / 9}};
static const double RADAU_ERROR[3] = {(-13 - 7 * SQRT6) / 3, (-13 + 7 * SQRT6) / 3, -1. / 3};
#define RADAU_REAL_EIGENVALUE 3.6378342527444957 /* of the inverse of A: 3 + 3^(2/3) - 3^(1/3) */
static const double RADAU_DENSE[3][3] = {
    {13. / 3 + 7 * SQRT6 / 3, -23. / 3 - 22 * SQRT6 / 3, 10. / 3 + 5 * SQRT6},
    {13. / 3 - 7 * SQRT6 / 3, -23. / 3 + 22 * SQRT6 / 3, 10. / 3 - 5 * SQRT6},
    {1. / 3, -8. / 3, 10. / 3}};

#define N3 (3 * N_STATES)

/* What Radau calls is never inlined, which takes long to compile and makes it no faster.
 *
 * LU factors of a dense row-major matrix in place, with row pivoting. Returns 0 if singular. */
NEVER_INLINE static int factorise(double *a, int *pivot, int n) {
  for (int c = 0; c < n; c++) {
    int best = c;
    for (int i = c + 1; i < n; i++)
      if (fabs(a[i * n + c]) > fabs(a[best * n + c])) best = i;
    pivot[c] = best;
    if (!(fabs(a[best * n + c]) > 0)) return 0;
    for (int j = 0; best != c && j < n; j++) {
      const double swap = a[c * n + j];
      a[c * n + j] = a[best * n + j];
      a[best * n + j] = swap;
    }
    for (int i = c + 1; i < n; i++) {
      const double factor = a[i * n + c] /= a[c * n + c];
      for (int j = c + 1; j < n; j++) a[i * n + j] -= factor * a[c * n + j];
    }
  }
  return 1;
}

NEVER_INLINE static void substitute(const double *lu, const int *pivot, int n, double *b) {
  for (int i = 0; i < n; i++) {
    const double swap = b[i];
    b[i] = b[pivot[i]];
    b[pivot[i]] = swap;
  }
  for (int i = 0; i < n; i++)
    for (int j = 0; j < i; j++) b[i] -= lu[i * n + j] * b[j];
  for (int i = n - 1; i >= 0; i--) {
    for (int j = i + 1; j < n; j++) b[i] -= lu[i * n + j] * b[j];
    b[i] /= lu[i * n + i];
  }
}

/* I - h A (x) J, with one Jacobian (column-major) for each stage. */
static void collocation_matrix(double h, double jacobian[3][N_STATES * N_STATES], double *matrix) {
  for (int a = 0; a < 3; a++)
    for (int i = 0; i < N_STATES; i++)
      for (int b = 0; b < 3; b++)
        for (int j = 0; j < N_STATES; j++)
          matrix[(a * N_STATES + i) * N3 + b * N_STATES + j] =
              (a == b && i == j) - h * RADAU_A[a][b] * jacobian[b][j * N_STATES + i];
}

NEVER_INLINE static void jacobian_at(Solver *s, double t, const double *x, double *jacobian) {
  double u[N_INPUTS];
  signal_at(&s->signal, t, u);
  model_rates_by_state(x, u, s->p, s->motion.mode, jacobian);
}

/* Stages z (relative to x) by Newton's method. Returns 0 where it does not converge. */
static int solve_stages(Solver *s, const double *x, double h, const double *lu, const int *pivot,
                        double *z) {
  const double t = s->motion.time;
  const Frozen frozen = freeze(s);
  double f[N3], residual[N3], at[N_STATES], before = INFINITY;
  memset(z, 0, sizeof(double) * N3);
  for (int iteration = 0; iteration < 12; iteration++) {
    for (int a = 0; a < 3; a++) {
      for (int i = 0; i < N_STATES; i++) at[i] = x[i] + z[a * N_STATES + i];
      rates_at(&frozen, NULL, t + RADAU_C[a] * h, at, 0, f + a * N_STATES);
    }
    s->statistics.rates += 3;
    for (int a = 0; a < 3; a++)
      for (int i = 0; i < N_STATES; i++) {
        double sum = 0.0;
        for (int b = 0; b < 3; b++) sum += RADAU_A[a][b] * f[b * N_STATES + i];
        residual[a * N_STATES + i] = h * sum - z[a * N_STATES + i];
      }
    substitute(lu, pivot, N3, residual);
    double change = 0.0;
    for (int i = 0; i < N3; i++) z[i] += residual[i];
    for (int a = 0; a < 3; a++) change += squared_norm(s, residual + a * N_STATES, x, x);
    if (!isfinite(change) || change > 4 * before) return 0;
    if (change < 1e-6 || (change >= before && change < 1e-3)) return 1;
    before = change;
  }
  return 0;
}

/* The sensitivities' stages solve the same collocation equations, which are linear in them. */
NEVER_INLINE static int step_sensitivities(Solver *s, const double *y, int m, double h,
                                           const double *z, double *y_new) {
  const double t = s->motion.time;
  double jacobian[3][N_STATES * N_STATES], matrix[N3 * N3], nonzeros[3][N_RATES_JACOBIAN];
  double at[N_STATES], u[N_INPUTS], forcing[N3], b[N3];
  int pivot[N3];
  for (int a = 0; a < 3; a++) {
    for (int i = 0; i < N_STATES; i++) at[i] = y[i] + z[a * N_STATES + i];
    signal_at(&s->signal, t + RADAU_C[a] * h, u);
    model_rates_jacobian(at, u, s->p, s->motion.mode, nonzeros[a]);
    jacobian_at(s, t + RADAU_C[a] * h, at, jacobian[a]);
  }
  collocation_matrix(h, jacobian, matrix);
  if (!factorise(matrix, pivot, N3)) return 0;
  for (int j = 1; j <= m; j++) {
    const double *column = y + j * N_STATES;
    for (int a = 0; a < 3; a++)
      multiply(&rates_jacobian_pattern, nonzeros[a], column, s->direction[j - 1], N_STATES,
               forcing + a * N_STATES);
    for (int a = 0; a < 3; a++)
      for (int i = 0; i < N_STATES; i++) {
        double sum = 0.0;
        for (int c = 0; c < 3; c++) sum += RADAU_A[a][c] * forcing[c * N_STATES + i];
        b[a * N_STATES + i] = h * sum;
      }
    substitute(matrix, pivot, N3, b);
    for (int i = 0; i < N_STATES; i++) y_new[j * N_STATES + i] = column[i] + b[2 * N_STATES + i];
  }
  return 1;
}

/* Error estimate of Hairer and Wanner, (8.19) and (8.20), filtered by the real eigenvalue. */
NEVER_INLINE static double radau_error(Solver *s, const double *x, const double *x_new, double h,
                                       const double *k, const double *z, const double *jacobian) {
  double matrix[N_STATES * N_STATES], weighted[N_STATES], error[N_STATES], at[N_STATES];
  int pivot[N_STATES];
  for (int i = 0; i < N_STATES; i++)
    for (int j = 0; j < N_STATES; j++)
      matrix[i * N_STATES + j] = (i == j) * RADAU_REAL_EIGENVALUE / h - jacobian[j * N_STATES + i];
  if (!factorise(matrix, pivot, N_STATES)) return INFINITY;
  for (int i = 0; i < N_STATES; i++) {
    weighted[i] = 0.0;
    for (int a = 0; a < 3; a++) weighted[i] += RADAU_ERROR[a] * z[a * N_STATES + i] / h;
    error[i] = k[i] + weighted[i];
  }
  substitute(matrix, pivot, N_STATES, error);
  const double first = squared_norm(s, error, x, x_new);
  if (first <= 1) return first;
  const Frozen frozen = freeze(s);
  for (int i = 0; i < N_STATES; i++) at[i] = x[i] + error[i];
  rates_at(&frozen, NULL, s->motion.time, at, 0, error);
  for (int i = 0; i < N_STATES; i++) error[i] += weighted[i];
  substitute(matrix, pivot, N_STATES, error);
  return squared_norm(s, error, x, x_new);
}

/* Takes k[0] = rates at y; leaves the stages relative to x from k[1] on. Returns the squared
 * error norm, infinite where the step cannot be solved. */
static double radau(Solver *s, const double *y, int m, double h, double *k, double *y_new) {
  double jacobian[3][N_STATES * N_STATES], matrix[N3 * N3];
  int pivot[N3];
  double *z = k + LENGTH(m);
  jacobian_at(s, s->motion.time, y, jacobian[0]);
  memcpy(jacobian[1], jacobian[0], sizeof jacobian[0]);
  memcpy(jacobian[2], jacobian[0], sizeof jacobian[0]);
  collocation_matrix(h, jacobian, matrix);
  if (!factorise(matrix, pivot, N3) || !solve_stages(s, y, h, matrix, pivot, z)) return INFINITY;
  for (int i = 0; i < N_STATES; i++) y_new[i] = y[i] + z[2 * N_STATES + i];
  const double error = radau_error(s, y, y_new, h, k, z, jacobian[0]);
  if (error <= 1 && m > 0 && !step_sensitivities(s, y, m, h, z, y_new)) return INFINITY;
  s->statistics.implicit_steps++;
  return error;
}

/* ---- either method --------------------------------------------------------------------------- */

/* Step of size h from y; returns the squared error norm, > 1 or not finite where too large. */
ALWAYS_INLINE double take_step(Solver *s, const double *y, int m, double h, double *k,
                               double *y_new) {
  return s->motion.implicit ? radau(s, y, m, h, k, y_new)
                            : dormand_prince(s, y, m, h, k, y_new);
}

/* The same as one copy: a step is long code, which takes long to compile. */
NEVER_INLINE static double take_any_step(Solver *s, const double *y, int m, double h, double *k,
                                         double *y_new) {
  return take_step(s, y, m, h, k, y_new);
}

/* States inside a step just taken: x + c_0 a + c_1 a^2 + ..., a in 0..1. */
typedef struct {
  double c[4][N_STATES];
} Dense;

static void dense_fill(Dense *dense, int implicit, double h, const double *k, int n) {
  memset(dense, 0, sizeof *dense);
  for (int i = 0; i < N_STATES; i++)
    if (implicit)
      for (int stage = 0; stage < 3; stage++)
        for (int d = 0; d < 3; d++)
          dense->c[d][i] += k[n + stage * N_STATES + i] * RADAU_DENSE[stage][d];
    else
      for (int stage = 0; stage < 7; stage++)
        for (int d = 0; d < 4; d++) dense->c[d][i] += h * k[stage * n + i] * DP_DENSE[stage][d];
}

static void dense_at(const Dense *dense, const double *x, double a, double *x_inside) {
  for (int i = 0; i < N_STATES; i++)
    x_inside[i] = x[i] + a * (dense->c[0][i] +
                              a * (dense->c[1][i] + a * (dense->c[2][i] + a * dense->c[3][i])));
}
