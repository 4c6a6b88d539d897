/* The laws of this folder on a fixed step, for studies that need thousands of runs.
 *
 * Runge-Kutta of order four; a step in which a corner of a law is passed is taken again in small
 * parts, and dry friction stops the joint where its velocity reaches zero. It errs by less than
 * 1e-6 rad against `solver`, which is what recordings are made with. SI units.
 */
#include <math.h>
#include <string.h>

enum { /* in the order of fast.NUMBERS */
    JOINT_RADIUS, MOTOR_RADIUS, PRETENSION, INERTIA, DAMPING,
    K1, K2, D1, D2, CUBIC1, CUBIC2, ENGAGE1, ENGAGE2, STRING1, STRING2,
    HYSTERESIS1, HYSTERESIS2, YIELD, EXPONENT, CREEP1, CREEP2, TIME_CONSTANT,
    MASS1, MASS2, MASS_DAMPING1, MASS_DAMPING2, COMPLIANCE,
    COULOMB, STATIC, STRIBECK, BRISTLE, BRISTLE_DAMPING, DRAG, GRAVITY, GRAVITY_ANGLE,
    STOP_LOWER, STOP_UPPER, STOP_STIFFNESS, STOP_DAMPING,
    WRAP, GAP, ECCENTRICITY, PHASE, MOTOR_OFFSET, POSITION, VELOCITY
};
enum { Q, V, BENT, Z1, Z2, C1, C2, S1, VS1, S2, VS2, STATES };
enum { PARTS = 128, MOST_RESTS = 8 };

typedef struct { const double *p; double theta, rate, load; int direction; } Now;
typedef struct { double tension, lag_rate, creep_rate; int signature; } Pull;
typedef struct { double q_torque, upper, lower, joint_torque; int signature; } Torques;

typedef struct {
    double k, d, cubic, engage, string, friction, yield, exponent, creep, time, compliance;
} Law;

static Law law_of(const double *p, int side, double count)
{
    /* a spring cut in `count` pieces: each bears the same force at a part of the elongation */
    Law law = {
        p[K1 + side] * count, p[D1 + side] * count, p[CUBIC1 + side] * count * count * count,
        p[ENGAGE1 + side] / count, p[STRING1 + side] * count,
        p[HYSTERESIS1 + side], p[YIELD] / count, p[EXPONENT], p[CREEP1 + side] * count,
        p[TIME_CONSTANT], p[COMPLIANCE]
    };
    return law;
}

static double own_force(const Law *a, double e, double z, double c, double *slope)
{
    double over = e > a->engage ? a->string : 0.0;
    *slope = a->k + 3.0 * a->cubic * e * e + over + a->creep;
    return a->k * e + a->cubic * e * e * e + over * (e - a->engage) + a->friction * z
        + a->creep * (e - c);
}

/* elongation at which own force times `compliance` and elongation make `length` (compliance > 0),
   or at which there is no force (0) */
static double balanced(const Law *a, double length, double rate, double z, double c)
{
    double e = a->compliance > 0.0 ? length : 0.0, slope;
    for (int i = 0; i < 12; i++) {
        double force = own_force(a, e, z, c, &slope), step;
        if (a->compliance > 0.0) {
            double damped = a->d * rate / (1.0 + a->compliance * slope);
            step = (a->compliance * (force + damped) + e - length) / (1.0 + a->compliance * slope);
        } else
            step = force / slope;
        e -= step;
        if (fabs(step) < 1e-15) break;
    }
    return e;
}

static Pull pull_of(const Law *a, double length, double rate, double z, double c)
{
    Pull out = {0};
    double slope, e = length, e_rate = rate, force;
    if (a->compliance > 0.0) {
        e = balanced(a, length, rate, z, c);
        force = (length - e) / a->compliance;
        own_force(a, e, z, c, &slope);
        e_rate = rate / (1.0 + a->compliance * slope);
    } else
        force = own_force(a, e, z, c, &slope) + a->d * rate;
    if (force <= 0.0) {
        Law bare = *a;
        bare.compliance = 0.0;
        e_rate = 0.0;
        if (a->creep > 0.0) {
            e = balanced(&bare, 0.0, 0.0, z, c);
            own_force(&bare, e, z, c, &slope);
            if (a->friction > 0.0) slope += a->friction / a->yield;
            e_rate = a->creep * (e - c) / a->time / slope;
        }
    }
    out.tension = force > 0.0 ? force : 0.0;
    out.signature = (force > 0.0) | (e > a->engage && a->string > 0.0) << 1;
    if (a->friction > 0.0)
        out.lag_rate = e_rate / a->yield * (e_rate * z > 0.0 ? 1.0 - pow(fabs(z), a->exponent) : 1.0);
    if (a->friction > 0.0) out.signature |= (e_rate > 0.0) << 2 | (z > 0.0) << 3;
    if (a->creep > 0.0) out.creep_rate = (e - c) / a->time;
    return out;
}

/* travel of the pulley beyond the joint's at which both sides pull alike */
static double imbalance_zero(const double *p, const double *y, const double *rest)
{
    Law upper = law_of(p, 0, 1.0), lower = law_of(p, 1, 1.0);
    double x = 0.0, s1, s2;
    if (p[CUBIC1] == 0.0 && p[HYSTERESIS1] == 0.0 && p[CREEP1] == 0.0 && p[STRING1] == 0.0)
        return 0.0;
    for (int i = 0; i < 12; i++) {
        double difference = own_force(&upper, rest[0] + x, y[Z1], y[C1], &s1)
            - own_force(&lower, rest[1] - x, y[Z2], y[C2], &s2);
        x -= difference / (s1 + s2);
        if (fabs(difference) < 1e-10) break;
    }
    return x;
}

static double stribeck(const double *p, double v)
{
    double share = v / p[STRIBECK];
    return p[COULOMB] + (p[STATIC] - p[COULOMB]) * exp(-share * share);
}

static double guide(const double *p, int direction, double upper, double lower)
{
    double half = sinh(0.5 * p[WRAP]);
    return p[JOINT_RADIUS]
        * (direction * (upper + lower) * sinh(p[WRAP]) - (upper - lower) * 2.0 * half * half);
}

static double dry(const double *p, int direction, double v, double upper, double lower)
{
    double torque = p[BRISTLE] > 0.0 ? 0.0 : direction * stribeck(p, v);
    return p[WRAP] > 0.0 ? torque + guide(p, direction, upper, lower) : torque;
}

static int sticks(const double *p)
{
    return p[WRAP] > 0.0 || (p[BRISTLE] == 0.0 && (p[STATIC] > 0.0 || p[COULOMB] > 0.0));
}

/* rates of all states but the velocity's dry friction; returns the torques on the joint */
static Torques evaluate(const Now *n, const double *y, double *dy)
{
    const double *p = n->p;
    double R = p[JOINT_RADIUS], r = p[MOTOR_RADIUS], v = y[V];
    double rest[2], F_joint[2], F_motor;
    Torques out = {0};
    memset(dy, 0, STATES * sizeof *dy);
    double angle = n->theta, rate = n->rate;
    if (p[ECCENTRICITY] != 0.0) {
        angle += p[ECCENTRICITY] * (sin(n->theta + p[PHASE]) - sin(p[PHASE]));
        rate *= 1.0 + p[ECCENTRICITY] * cos(n->theta + p[PHASE]);
    }
    for (int i = 0; i < 2; i++) rest[i] = p[PRETENSION] * (1.0 / p[K1 + i] + p[COMPLIANCE]);
    double travel = r * angle, travel_rate = r * rate;
    if (p[GAP] > 0.0) {
        double half = 0.5 * p[GAP] * r;
        double free = R * y[Q] + imbalance_zero(p, y, rest);
        if (free > travel + half) travel += half, out.signature |= 1 << 20;
        else if (free < travel - half) travel -= half, out.signature |= 2 << 20;
        else travel = free, travel_rate = R * v;
    }
    for (int i = 0; i < 2; i++) {
        double sign = i == 0 ? 1.0 : -1.0;
        double top = sign * travel, top_rate = sign * travel_rate;
        double end = sign * R * y[Q], end_rate = sign * R * v;
        if (p[MASS1 + i] > 0.0) {
            Law law = law_of(p, i, 2.0);
            double s = y[S1 + 2 * i], vs = y[VS1 + 2 * i], mean = 0.5 * (top_rate + end_rate);
            Pull a = pull_of(&law, 0.5 * rest[i] + top - s, top_rate - vs, 0.0, 0.0);
            Pull b = pull_of(&law, 0.5 * rest[i] + s - end, vs - end_rate, 0.0, 0.0);
            F_motor = a.tension, F_joint[i] = b.tension;
            dy[S1 + 2 * i] = vs;
            dy[VS1 + 2 * i] =
                (F_motor - F_joint[i] - p[MASS_DAMPING1 + i] * (vs - mean)) / p[MASS1 + i];
            out.signature |= (a.signature | b.signature << 4) << (8 * i);
        } else {
            Law law = law_of(p, i, 1.0);
            Pull a = pull_of(&law, rest[i] + top - end, top_rate - end_rate, y[Z1 + i], y[C1 + i]);
            F_joint[i] = a.tension;
            dy[Z1 + i] = a.lag_rate, dy[C1 + i] = a.creep_rate;
            out.signature |= a.signature << (8 * i);
        }
    }
    out.upper = F_joint[0], out.lower = F_joint[1];
    double torque = R * (out.upper - out.lower) + n->load - p[DAMPING] * v - p[DRAG] * v * fabs(v)
        - p[GRAVITY] * sin(y[Q] + p[GRAVITY_ANGLE]);
    if (p[STOP_STIFFNESS] > 0.0) {
        double up = y[Q] - p[STOP_UPPER], down = p[STOP_LOWER] - y[Q], push;
        if (up > 0.0 && (push = p[STOP_STIFFNESS] * up + p[STOP_DAMPING] * v) > 0.0)
            torque -= push, out.signature |= 1 << 16;
        if (down > 0.0 && (push = p[STOP_STIFFNESS] * down - p[STOP_DAMPING] * v) > 0.0)
            torque += push, out.signature |= 1 << 17;
    }
    if (p[BRISTLE] > 0.0) {
        double g = stribeck(p, v);
        dy[BENT] = p[BRISTLE] * (v - fabs(v) * y[BENT] / g);
        torque -= y[BENT] + p[BRISTLE_DAMPING] / p[BRISTLE] * dy[BENT];
        out.signature |= (v > 0.0) << 18;
    }
    out.joint_torque = R * (out.upper - out.lower);
    if (p[WRAP] > 0.0) {
        if (n->direction != 0)
            out.joint_torque -= guide(p, n->direction, out.upper, out.lower);
        else {
            int towards = torque >= 0.0 ? 1 : -1;
            double bound = dry(p, towards, 0.0, out.upper, out.lower);
            double share = bound != 0.0 ? torque / bound : 0.0;
            out.joint_torque -= share * guide(p, towards, out.upper, out.lower);
        }
    }
    out.q_torque = torque;
    if (sticks(p)) {
        if (n->direction == 0) return out; /* held: position and velocity rates stay zero */
        torque -= dry(p, n->direction, v, out.upper, out.lower);
    }
    dy[Q] = v, dy[V] = torque / p[INERTIA];
    return out;
}

typedef struct { const double *theta, *rate, *load; double half_step; } Inputs;

/* inputs between two neighbours of the table at which they stand, by a cubic and a line */
static void inputs_at(const Inputs *in, long step, double share, Now *n)
{
    double s = 2.0 * share, h = in->half_step;
    long i = 2 * step;
    if (s >= 1.0) i += 1, s -= 1.0;
    double a = 1.0 - s;
    const double *x = in->theta + i, *v = in->rate + i;
    if (s == 0.0) n->theta = x[0], n->rate = v[0], n->load = in->load[i];
    else {
        n->theta = x[0] * a * a * (1.0 + 2.0 * s) + x[1] * s * s * (3.0 - 2.0 * s)
            + h * s * a * (v[0] * a - v[1] * s);
        n->rate = v[0] * a + v[1] * s;
        n->load = in->load[i] * a + in->load[i + 1] * s;
    }
    n->theta -= n->p[MOTOR_OFFSET];
}

/* bristles after a travel from `start` on: their law is linear in the travel while g stays */
static double bent(const double *p, const double *start, const double *y)
{
    double travel = y[Q] - start[Q];
    double mean = 0.5 * (stribeck(p, start[V]) + stribeck(p, y[V]));
    double slipping = (travel < 0.0 ? -1.0 : 1.0) * mean;
    return slipping + (start[BENT] - slipping) * exp(-p[BRISTLE] * travel / slipping);
}

static int step_by(const Inputs *in, long step, double from, double to, Now n, double *y)
{
    double k[4][STATES], trial[STATES], h = (to - from) * 2.0 * in->half_step;
    double places[4] = {from, 0.5 * (from + to), 0.5 * (from + to), to};
    double reach[4] = {0.0, 0.5, 0.5, 1.0};
    int first = 0, changed = 0;
    for (int s = 0; s < 4; s++) {
        inputs_at(in, step, places[s], &n);
        for (int j = 0; j < STATES; j++) trial[j] = y[j] + (s ? reach[s] * h * k[s - 1][j] : 0.0);
        if (s && n.p[BRISTLE] > 0.0) trial[BENT] = bent(n.p, y, trial);
        int signature = evaluate(&n, trial, k[s]).signature;
        if (s == 0) first = signature;
        changed |= signature != first;
    }
    for (int j = 0; j < STATES; j++)
        trial[j] = y[j] + h / 6.0 * (k[0][j] + 2.0 * k[1][j] + 2.0 * k[2][j] + k[3][j]);
    if (n.p[BRISTLE] > 0.0) trial[BENT] = bent(n.p, y, trial);
    memcpy(y, trial, sizeof trial);
    return changed;
}

/* which way a joint at rest breaks loose, 0 if friction holds it */
static int breaks_loose(Now n, const double *y)
{
    double dy[STATES];
    n.direction = 0;
    Torques t = evaluate(&n, y, dy);
    for (int direction = -1; direction <= 1; direction += 2)
        if (direction * (t.q_torque - dry(n.p, direction, 0.0, t.upper, t.lower)) > 0.0)
            return direction;
    return 0;
}

/* a part of a step with dry friction: ends where the joint comes to rest */
static int part_of_step(const Inputs *in, long step, double from, double to, Now *n, double *y)
{
    int changed = 0, stick = sticks(n->p);
    for (int rests = 0; rests < MOST_RESTS && from < to; rests++) {
        double before[STATES], reach = to;
        if (stick && n->direction == 0) {
            inputs_at(in, step, from, n);
            n->direction = breaks_loose(*n, y);
        }
        memcpy(before, y, sizeof before);
        changed |= step_by(in, step, from, reach, *n, y);
        if (!stick) return changed;
        if (n->direction == 0) { /* a late break-away is met again in smaller parts */
            inputs_at(in, step, to, n);
            return changed | (breaks_loose(*n, y) != 0);
        }
        if (n->direction * y[V] >= 0.0) return changed;
        double low = from, high = to, at_low = n->direction * before[V];
        double at_high = n->direction * y[V];
        for (int i = 0; i < 6 && high - low > 1e-9; i++) {
            reach = low + (high - low) * (at_low - at_high > 0.0 ? at_low / (at_low - at_high) : 0.5);
            if (reach <= low || reach >= high) reach = 0.5 * (low + high);
            memcpy(y, before, sizeof before);
            step_by(in, step, from, reach, *n, y);
            double speed = n->direction * y[V];
            if (speed >= 0.0) low = reach, at_low = speed;
            else high = reach, at_high = speed;
        }
        y[V] = 0.0;
        from = reach;
        inputs_at(in, step, from, n);
        n->direction = breaks_loose(*n, y);
        changed = 1;
    }
    return changed;
}

static void begin(Now *n, double *y)
{
    const double *p = n->p;
    double R = p[JOINT_RADIUS], r = p[MOTOR_RADIUS];
    memset(y, 0, STATES * sizeof *y);
    y[Q] = p[POSITION], y[V] = p[VELOCITY];
    double travel = r * (n->theta + p[ECCENTRICITY] * (sin(n->theta + p[PHASE]) - sin(p[PHASE])));
    for (int i = 0; i < 2; i++) {
        double sign = i == 0 ? 1.0 : -1.0, slope;
        double length = p[PRETENSION] * (1.0 / p[K1 + i] + p[COMPLIANCE])
            + sign * (travel - R * y[Q]);
        Law law = law_of(p, i, 1.0);
        law.creep = law.friction = 0.0;
        double e = law.compliance > 0.0 ? balanced(&law, length, 0.0, 0.0, 0.0) : length;
        y[C1 + i] = own_force(&law, e, 0.0, 0.0, &slope) > 0.0 ? e : 0.0;
        y[S1 + 2 * i] = 0.5 * sign * (travel + R * y[Q]);
        y[VS1 + 2 * i] = 0.5 * sign * (r * n->rate + R * y[V]);
    }
    n->direction = y[V] > 0.0 ? 1 : y[V] < 0.0 ? -1 : 0;
}

/* Simulate `samples` - 1 intervals of `steps` steps each; `theta`, `rate` (rad, rad/s) and `load`
 * (N m) stand at every half step. Fills positions (rad) and joint torques (N m) at the samples;
 * returns 0, or 1 where the joint ran away. */
int fast_simulate(const double *numbers, long samples, long steps, double step_size,
                  const double *theta, const double *rate, const double *load,
                  double *position, double *torque)
{
    double y[STATES], dy[STATES];
    Now n = {numbers, theta[0] - numbers[MOTOR_OFFSET], rate[0], load[0], 0};
    Inputs in = {theta, rate, load, 0.5 * step_size};
    /* bristles and masses on springs are quicker than the joint */
    int few = numbers[BRISTLE] > 0.0 ? 8 : numbers[MASS1] > 0.0 ? 2 : 1;
    begin(&n, y);
    for (long sample = 0; sample < samples; sample++) {
        inputs_at(&in, sample * steps, 0.0, &n);
        position[sample] = y[Q];
        torque[sample] = evaluate(&n, y, dy).joint_torque;
        if (!(fabs(y[Q]) < 1e3)) return 1;
        if (sample == samples - 1) break;
        for (long i = sample * steps; i < (sample + 1) * steps; i++) {
            double before[STATES];
            Now at = n;
            memcpy(before, y, sizeof y);
            int changed = 0;
            for (int part = 0; part < few; part++)
                changed |= part_of_step(&in, i, (double)part / few, (part + 1.0) / few, &n, y);
            if (!changed) continue;
            memcpy(y, before, sizeof y);
            n = at;
            for (int part = 0; part < PARTS; part++)
                part_of_step(&in, i, (double)part / PARTS, (double)(part + 1) / PARTS, &n, y);
        }
    }
    return 0;
}
