/* The laws of this folder on a fixed step, for studies that need thousands of runs.
 *
 * Runge-Kutta of order four; a step in which a corner of a law is passed is taken again in small
 * parts, and dry friction stops the joint where its velocity reaches zero. It errs by some 1e-6 rad
 * against `solver`. Only how a damped spring lags in series with a compliant tendon is taken to
 * first order in time, which costs 1e-5 rad, beside hysteresis up to 1e-3. SI units.
 */
#include <math.h>
#include <string.h>

enum { /* in the order of fast.numbers_of */
    JOINT_RADIUS, MOTOR_RADIUS, PRETENSION, INERTIA, DAMPING,
    K1, K2, D1, D2, SQUARE1, SQUARE2, CUBIC1, CUBIC2, ENGAGE1, ENGAGE2, STRING1, STRING2,
    HYSTERESIS1, HYSTERESIS2, YIELD, EXPONENT, CREEP1, CREEP2, TIME_CONSTANT,
    MASS1, MASS2, MASS_DAMPING1, MASS_DAMPING2, COMPLIANCE,
    COULOMB, STATIC, STRIBECK, BRISTLE, BRISTLE_DAMPING, DRAG, CUBE, DIFFERENCE, CONSTANT,
    GRAVITY, GRAVITY_ANGLE,
    STOP_LOWER, STOP_UPPER, STOP_STIFFNESS, STOP_DAMPING,
    WRAP, GAP, ECCENTRICITY, PHASE, MOTOR_OFFSET, MOTOR_SHARE, POSITION, VELOCITY, NUMBERS
};
/* a spring with a mass in its middle is two pieces, else one: LAG and CREEP stand for the upper and
   then the lower side's, from the motor to the joint */
enum { Q, V, BENT, S1, VS1, S2, VS2, LAG, CREEP = LAG + 4, STATES = CREEP + 4 };
enum { PARTS = 128, MOST_RESTS = 8, NEWTON = 12 };

typedef struct { const double *p; double theta, rate, load; int direction; } Now;
typedef struct { double tension, lag_rate, creep_rate; int signature; } Pull;
typedef struct { double q_torque, upper, lower, joint_torque; int signature; } Torques;
typedef struct { double travel, rate; int signature; } Pulley;

typedef struct {
    double k, d, square, cubic, engage, string, friction, yield, exponent, creep, time, compliance;
} Law;
/* `pieces` of one side, in the order of their states, and how far and fast their ends part */
typedef struct { Law law; int pieces; double length[2], rate[2]; } Side;
/* a piece at an elongation: its force without damper, the slope of that at its present memory and
   with what its friction adds, how it fades in time, and the rate of the elongation */
typedef struct { double force, slope, hardness, fading, rate; } Stretched;
/* force of a side at the motor, the rate of that, and how both grow with the pulley's own */
typedef struct { double force, stiffness, change, hardness; } AtMotor;

static Side side_of(const double *p, const double *y, int side, Pulley pulley)
{
    int pieces = p[MASS1 + side] > 0.0 ? 2 : 1;
    double count = pieces, sign = side == 0 ? 1.0 : -1.0;
    double rest = p[PRETENSION] * (1.0 / p[K1 + side] + p[COMPLIANCE]) / count;
    double top = sign * pulley.travel, top_rate = sign * pulley.rate;
    double end = sign * p[JOINT_RADIUS] * y[Q], end_rate = sign * p[JOINT_RADIUS] * y[V];
    double s = y[S1 + 2 * side], vs = y[VS1 + 2 * side];
    /* each piece bears the same force at a part of the elongation */
    Law law = {
        p[K1 + side] * count, p[D1 + side] * count, p[SQUARE1 + side] * count * count,
        p[CUBIC1 + side] * count * count * count,
        p[ENGAGE1 + side] / count, p[STRING1 + side] * count,
        p[HYSTERESIS1 + side], p[YIELD] / count, p[EXPONENT], p[CREEP1 + side] * count,
        p[TIME_CONSTANT], p[COMPLIANCE] / count
    };
    if (pieces == 1)
        return (Side){law, pieces, {rest + top - end}, {top_rate - end_rate}};
    return (Side){law, pieces, {rest + top - s, rest + s - end}, {top_rate - vs, vs - end_rate}};
}

static double yielding(const Law *a, double z, double direction)
{
    return direction * z > 0.0 ? 1.0 - pow(fabs(z), a->exponent) : 1.0;
}

/* slope with what friction adds while the elongation moves in a direction */
static double hardness(const Law *a, double slope, double z, double direction)
{
    return a->friction > 0.0 ? slope + a->friction / a->yield * yielding(a, z, direction) : slope;
}

static Stretched stretched(const Law *a, double e, double rate, double z, double c)
{
    double over = e > a->engage ? a->string : 0.0;
    Stretched out = {
        .force = a->k * e + a->square * e * e + a->cubic * e * e * e + over * (e - a->engage) + a->friction * z
            + a->creep * (e - c),
        .slope = a->k + 2.0 * a->square * e + 3.0 * a->cubic * e * e + over + a->creep,
        .fading = a->creep * (e - c) / a->time
    };
    double drive = rate + a->compliance * out.fading;
    out.hardness = hardness(a, out.slope, z, drive);
    out.rate = drive / (1.0 + a->compliance * out.hardness);
    return out;
}

/* elongation at which a taut piece, its compliance and its damper make `length` */
static double taut_elongation(const Law *a, double length, double rate, double z, double c)
{
    double e = length;
    for (int i = 0; i < NEWTON && a->compliance > 0.0; i++) {
        Stretched at = stretched(a, e, rate, z, c);
        double excess = a->compliance * (at.force + a->d * at.rate) + e - length;
        double step = excess / (1.0 + a->compliance * at.slope);
        e -= step;
        if (fabs(step) < 1e-15) break;
    }
    return e;
}

/* elongation at which a piece has no force of its own */
static double free_elongation(const Law *a, double z, double c)
{
    double e = 0.0;
    for (int i = 0; i < NEWTON; i++) {
        Stretched at = stretched(a, e, 0.0, z, c);
        e -= at.force / at.slope;
        if (fabs(at.force / at.slope) < 1e-15) break;
    }
    return e;
}

static Pull pull_of(const Law *a, double length, double rate, double z, double c)
{
    Pull out = {0};
    double e = taut_elongation(a, length, rate, z, c);
    Stretched at = stretched(a, e, rate, z, c);
    double force = a->compliance > 0.0 ? (length - e) / a->compliance : at.force + a->d * rate;
    double e_rate = at.rate;
    int pushed = a->compliance == 0.0 && at.force > 0.0; /* slack by its damper alone */
    if (force <= 0.0 && !pushed) {
        e_rate = 0.0;
        if (a->creep > 0.0) {
            e = free_elongation(a, z, c);
            at = stretched(a, e, 0.0, z, c);
            e_rate = at.fading / hardness(a, at.slope, z, at.fading);
        }
    }
    out.tension = force > 0.0 ? force : 0.0;
    out.signature = (force > 0.0) | (e > a->engage && a->string > 0.0) << 1;
    if (a->friction > 0.0) {
        out.lag_rate = e_rate / a->yield * yielding(a, z, e_rate);
        out.signature |= (e_rate > 0.0) << 2 | (z > 0.0) << 3;
    }
    if (a->creep > 0.0) out.creep_rate = (e - c) / a->time;
    return out;
}

/* without dampers and before slack cuts it off */
static AtMotor at_motor(const double *p, const double *y, int side, Pulley pulley)
{
    Side s = side_of(p, y, side, pulley);
    double z = y[LAG + 2 * side], c = y[CREEP + 2 * side];
    s.law.d = 0.0;
    double e = taut_elongation(&s.law, s.length[0], s.rate[0], z, c);
    Stretched at = stretched(&s.law, e, s.rate[0], z, c);
    return (AtMotor){
        at.force, at.slope / (1.0 + s.law.compliance * at.slope),
        at.hardness * at.rate - at.fading,
        at.hardness / (1.0 + s.law.compliance * at.hardness)
    };
}

/* where both sides pull a pulley without mass alike, at any place of the play */
static Pulley floating(const double *p, const double *y)
{
    Pulley out = {p[JOINT_RADIUS] * y[Q], p[JOINT_RADIUS] * y[V], 0};
    for (int i = 0; i < NEWTON; i++) {
        AtMotor a = at_motor(p, y, 0, out), b = at_motor(p, y, 1, out);
        double apart = a.force - b.force, parting = a.change - b.change;
        out.travel -= apart / (a.stiffness + b.stiffness);
        out.rate -= parting / (a.hardness + b.hardness);
        if (fabs(apart) < 1e-10 && fabs(parting) < 1e-7) break;
    }
    return out;
}

static Pulley pulley_of(const Now *n, const double *y)
{
    const double *p = n->p;
    double r = p[MOTOR_RADIUS], half = 0.5 * p[GAP] * r, turned = 0.0, wobble = 0.0;
    if (p[ECCENTRICITY] != 0.0) {
        turned = p[ECCENTRICITY] * (sin(n->theta + p[PHASE]) - sin(p[PHASE]));
        wobble = p[ECCENTRICITY] * cos(n->theta + p[PHASE]);
    }
    Pulley out = {r * (n->theta + turned), r * n->rate * (1.0 + wobble), 0};
    if (p[GAP] == 0.0) return out;
    Pulley free = floating(p, y);
    if (fabs(free.travel - out.travel) < half) return free;
    int ahead = free.travel > out.travel;
    out.travel += ahead ? half : -half;
    out.signature = (ahead ? 1 : 2) << 20;
    return out;
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
    double R = p[JOINT_RADIUS], v = y[V], F_joint[2];
    Pulley pulley = pulley_of(n, y);
    Torques out = {.signature = pulley.signature};
    memset(dy, 0, STATES * sizeof *dy);
    for (int i = 0; i < 2; i++) {
        Side side = side_of(p, y, i, pulley);
        double F[2];
        for (int j = 0; j < side.pieces; j++) {
            int piece = 2 * i + j;
            Pull pull =
                pull_of(&side.law, side.length[j], side.rate[j], y[LAG + piece], y[CREEP + piece]);
            F[j] = pull.tension;
            dy[LAG + piece] = pull.lag_rate, dy[CREEP + piece] = pull.creep_rate;
            out.signature |= pull.signature << (4 * piece);
        }
        F_joint[i] = F[side.pieces - 1];
        if (side.pieces == 2) {
            double vs = y[VS1 + 2 * i], mean = 0.5 * (i == 0 ? 1.0 : -1.0) * (pulley.rate + R * v);
            dy[S1 + 2 * i] = vs;
            dy[VS1 + 2 * i] = (F[0] - F[1] - p[MASS_DAMPING1 + i] * (vs - mean)) / p[MASS1 + i];
        }
    }
    out.upper = F_joint[0], out.lower = F_joint[1];
    double torque = R * (out.upper - out.lower) + n->load + p[CONSTANT]
        - (p[DAMPING] + (v > 0.0 ? 0.5 : -0.5) * p[DIFFERENCE]) * v - p[DRAG] * v * fabs(v)
        - p[CUBE] * v * v * v;
    if (p[DIFFERENCE] != 0.0) out.signature |= (v > 0.0) << 19;
    if (p[GRAVITY] != 0.0) torque -= p[GRAVITY] * sin(y[Q] + p[GRAVITY_ANGLE]);
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

typedef struct { const double *theta, *rate, *load, *load_rate; double half_step; } Inputs;

/* value and rate (not where 0) at a share of a piece of a spline, of those at its ends */
static double between(const double *x, const double *v, double h, double s, double *rate)
{
    double a = 1.0 - s, rise = (x[1] - x[0]) / h;
    if (s == 0.0 || s == 1.0) { /* most are */
        if (rate) *rate = v[s == 1.0];
        return x[s == 1.0];
    }
    if (rate) *rate = v[0] * a * (1.0 - 3.0 * s) + v[1] * s * (3.0 * s - 2.0) + 6.0 * s * a * rise;
    return x[0] * a * a * (1.0 + 2.0 * s) + x[1] * s * s * (3.0 - 2.0 * s)
        + h * s * a * (v[0] * a - v[1] * s);
}

static void inputs_at(const Inputs *in, long step, double share, Now *n)
{
    double s = 2.0 * share, h = in->half_step;
    long i = 2 * step;
    if (s >= 1.0) i += 1, s -= 1.0;
    double gain = 1.0 + n->p[MOTOR_SHARE];
    n->theta = between(in->theta + i, in->rate + i, h, s, &n->rate) - n->p[MOTOR_OFFSET];
    n->theta /= gain, n->rate /= gain;
    n->load = between(in->load + i, in->load_rate + i, h, s, 0);
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
    /* springs begin relaxed, their masses in the middle */
    double relaxed[NUMBERS];
    Now without = *n;
    memcpy(relaxed, n->p, sizeof relaxed);
    memset(y, 0, STATES * sizeof *y);
    y[Q] = n->p[POSITION], y[V] = n->p[VELOCITY];
    for (int i = 0; i < 2; i++)
        relaxed[CREEP1 + i] = relaxed[HYSTERESIS1 + i] = relaxed[MASS1 + i] = 0.0;
    without.p = relaxed;
    Pulley pulley = pulley_of(&without, y);
    for (int i = 0; i < 2; i++) {
        Side whole = side_of(relaxed, y, i, pulley);
        double e = taut_elongation(&whole.law, whole.length[0], 0.0, 0.0, 0.0);
        double force = stretched(&whole.law, e, 0.0, 0.0, 0.0).force, sign = i == 0 ? 1.0 : -1.0;
        double share = n->p[MASS1 + i] > 0.0 ? 0.5 : 1.0;
        for (int j = 0; j < 2; j++) y[CREEP + 2 * i + j] = force > 0.0 ? share * e : 0.0;
        y[S1 + 2 * i] = 0.5 * sign * (pulley.travel + n->p[JOINT_RADIUS] * y[Q]);
        y[VS1 + 2 * i] = 0.5 * sign * (pulley.rate + n->p[JOINT_RADIUS] * y[V]);
    }
    n->direction = y[V] > 0.0 ? 1 : y[V] < 0.0 ? -1 : 0;
}

/* Simulate `samples` - 1 intervals of `steps` steps each; `theta`, `rate` (rad, rad/s), `load` and
 * `load_rate` (N m, N m/s) stand at every half step. Fills positions (rad) and joint torques (N m)
 * at the samples; returns 0, or 1 where the joint ran away. */
int fast_simulate(const double *numbers, long samples, long steps, double step_size,
                  const double *theta, const double *rate, const double *load,
                  const double *load_rate, double *position, double *torque)
{
    double y[STATES], dy[STATES];
    Now n = {.p = numbers};
    Inputs in = {theta, rate, load, load_rate, 0.5 * step_size};
    inputs_at(&in, 0, 0.0, &n);
    /* bristles and masses on springs are quicker than the joint */
    int few = numbers[BRISTLE] > 0.0 || numbers[MASS1] > 0.0 ? 8 : 1;
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
