/*
@HEAD@
 *
 * C99; needs math.h alone. No heap, no recursion, no global that changes.
 *
 * Bounded time: every loop below runs a constant number of times, or up to a constant. A call makes SWEEPS sweeps over
 * the nodes, the first after a reset FIRST_SWEEPS; a sweep visits NODES nodes, SPRINGS spring coefficients and LAWS
 * laws twice. The one iteration with a criterion is angle_of_torque (a curve of torque over angle, where the model has
 * one): at most 12 steps of Newton's method and 60 bisections. It cannot need more: the curve's slope is nowhere below
 * LEAST_SLOPE * p1, so that the angle lies between 0 and torque / (LEAST_SLOPE * p1), and 60 bisections leave 2^-60 of
 * this interval, less than the rounding of a double.
 *
 * Symbols: a node is a place that gives: base, joints, links' outboard ends, tool, as far as the model has them. Frames
 * are columns r (rotation, 3 x 3) and p (origin, m) in base axes; "shape" 0 is under load and weight, 1 under weight
 * alone, and the deflection is what lies between both. Second-order rotation within one node is left out.
 */
#include "@HEADER@"

#include <math.h>

#ifdef __FAST_MATH__
#error "compile without -ffast-math: readings that are no number would pass unnoticed"
#endif

#define JOINTS @N_JOINTS@ /* model joints */
#define LOGGED @CAPS@_JOINTS
#define NODES @CAPS@_NODES
#define SPRINGS @N_SPRINGS@
#define LAWS @N_LAWS@
#define WEIGHTS @N_WEIGHTS@
#define BALANCERS @N_BALANCERS@
#define SWEEPS @SWEEPS@
#define FIRST_SWEEPS @FIRST_SWEEPS@
#define DEFORMED @DEFORMED@           /* 0: wrenches on the undeformed chain (first-order form) */
#define MOMENTS_MEASURED @MOMENTS@   /* 0: the reading's moments are not used */
#define AXES_NODE @AXES_NODE@         /* node that the reading's axes move with; -1: the ground */
#define LOAD_NODE @LOAD_NODE@         /* node that the load point moves with */
#define TARGET_NODE @TARGET_NODE@     /* node that the target moves with */
#define LEAST_SLOPE 0.02
#define ENDLESS 1e300

/* From the displaced frame of the node before to the node's own, its joint at zero; m. Last column: origin. */
static const double FIXED[NODES][3][4] = @FIXED@;
/* Model joint that turns before the node, from 0; -1: none. */
static const int JOINT[NODES] = @JOINT@;
/* kg that ride on each displaced node, and mass times place there, kg m, node axes. */
static const double MASS[NODES] = @MASS@;
static const double MASS_MOMENT[NODES][3] = @MASS_MOMENT@;
static const double GRAVITY[3] = @GRAVITY@; /* m/s^2, base axes */
/* Model angle = COUPLING x logged angle + OFFSET, rad. */
static const double COUPLING[JOINTS][LOGGED] = @COUPLING@;
static const double OFFSET[JOINTS] = @OFFSET@;
@SLIDES@static const double LIMITS[LOGGED][2] = @LIMITS@; /* rad, logged angles; 1e300: none */
static const double LARGEST = @LARGEST@;           /* rad, what an offset is cut off at, all joints in proportion */
static const double DAMPING = @DAMPING@;           /* m/rad: directions that move the target less are corrected less */
static const double AXES[3][3] = @AXES@;           /* the reading's axes as columns, axes of AXES_NODE */
static const double LOAD_POINT[3] = @LOAD_POINT@;  /* m, axes of LOAD_NODE */
static const double TARGET[3] = @TARGET@;          /* m, axes of TARGET_NODE */
/* Low-pass of the reading, y = b0 u + z1; b = 1, 0, 0: none. */
static const double B[3] = @B@;
static const double A[2] = @A@;
/* What the tool's weight makes the sensor read, over gravity in its axes; what of it was zeroed, N, N m. */
static const double TOOL[6][3] = @TOOL@;
static const double ZEROED[6] = @ZEROED@;

/* displacement[to] += compliance x load[from]; index = 6 x node + component (three translations, three rotations) */
typedef struct {
    int to;
    int from;
    double compliance; /* m/N, rad/(N m), m/(N m), rad/N */
} spring;
static const spring SPRING[SPRINGS > 0 ? SPRINGS : 1] = @SPRING@;

enum { POLYNOMIAL, CLIPPED, POSITIVE, CROSSING, PLAY, PERIODIC, CUBIC_TORQUE };
/* A law of one load w, the sum of factor x load[index] over its weights; each index moves by factor x its answer. */
typedef struct {
    int form;
    int joint;  /* model joint whose angle it follows, from 0; -1: none */
    int first;  /* its weights */
    int count;
    int memory; /* its play operator; -1: none */
    double n[5];
} law;
static const law LAW[LAWS > 0 ? LAWS : 1] = @LAW@;
typedef struct {
    int index;
    double factor;
} weight;
static const weight WEIGHT[WEIGHTS > 0 ? WEIGHTS : 1] = @WEIGHT@;
/* Balancing springs: node, model joint, anchor and arm (m, joint frame), rate N/m, free length m. */
typedef struct {
    int node;
    int joint;
    double anchor[3];
    double arm[3];
    double rate;
    double free_length;
} balancer;
static const balancer BALANCER[BALANCERS > 0 ? BALANCERS : 1] = @BALANCER@;

static const char HASH[] = "@HASH@";

typedef struct {
    double r[3][3];
    double p[3];
} frame;

typedef struct {
    frame before[2][NODES]; /* before each node's own displacement */
    frame after[2][NODES];
    double cosine[JOINTS];
    double sine[JOINTS];
    double angle[JOINTS];
    double load[2][6 * NODES];   /* what the nodes carry, node axes, N, N m */
    double memory[@CAPS@_MEMORIES]; /* what the last sweep's loads leave in the play operators */
} work;

static double clip(double value, double low, double high)
{
    return value < low ? low : value > high ? high : value;
}

static double curve(const double n[5], double angle)
{
    double inside = clip(angle, n[3], n[4]);
    return inside * (n[0] + inside * (n[1] + inside * n[2])) + LEAST_SLOPE * n[0] * (angle - inside);
}

/* The angle at which the curve reaches a torque: see "bounded time" above. */
static double angle_of_torque(const double n[5], double torque)
{
    double low = 0.0, high = torque / (LEAST_SLOPE * n[0]), angle = torque / n[0];
    int k;
    if (low > high) {
        low = high;
        high = 0.0;
    }
    for (k = 0; k < 72; ++k) {
        double miss = curve(n, angle) - torque;
        double inside = clip(angle, n[3], n[4]);
        double slope = n[0] + inside * (2.0 * n[1] + 3.0 * inside * n[2]);
        double next;
        if (fabs(miss) <= 1e-15 * fabs(torque)) {
            break;
        }
        if (miss < 0.0) {
            low = angle;
        } else {
            high = angle;
        }
        if (slope < LEAST_SLOPE * n[0]) {
            slope = LEAST_SLOPE * n[0];
        }
        next = angle - miss / slope;
        angle = (k >= 12 || next <= low || next >= high) ? 0.5 * (low + high) : next;
    }
    return angle;
}

static double played(double slip, double load, double before)
{
    double value = before > load - slip ? before : load - slip;
    return value < load + slip ? value : load + slip;
}

static double played_from_rest(double slip, double load)
{
    return load - clip(load, -slip, slip);
}

static double answer(const law *of, double load, const double angle[JOINTS])
{
    const double *n = of->n;
    switch (of->form) {
    case POLYNOMIAL:
        return load * (n[0] + load * (n[1] + load * n[2]));
    case CLIPPED:
        return n[0] * clip(load, -n[1], n[1]);
    case POSITIVE:
        return load > 0.0 ? n[0] * load : 0.0;
    case CROSSING:
        return n[0] * tanh(load / n[1]);
    case PERIODIC: {
        double phase = n[2] * (angle[of->joint] - n[3]);
        return (n[0] * cos(phase) + n[1] * sin(phase)) * load;
    }
    case CUBIC_TORQUE:
        return angle_of_torque(n, load);
    default:
        return 0.0;
    }
}

static double balancing_torque(const balancer *of, double angle)
{
    double c = cos(angle), s = sin(angle);
    double x = c * of->arm[0] - s * of->arm[1], y = s * of->arm[0] + c * of->arm[1];
    double dx = x - of->anchor[0], dy = y - of->anchor[1], dz = of->arm[2] - of->anchor[2];
    double length = sqrt(dx * dx + dy * dy + dz * dz);
    return -of->rate * (length - of->free_length) * (y * of->anchor[0] - x * of->anchor[1]) / length;
}

/* Put all frames of one shape where angles and displacements lead. */
static void place(const @PREFIX@_state *state, work *w, int shape)
{
    int k, i, j;
    for (k = 0; k < NODES; ++k) {
        const double (*fixed)[4] = FIXED[k];
        const double *d = state->small[shape][k];
        frame *before = &w->before[shape][k], *after = &w->after[shape][k];
        double local[3][3];
@SLIDES_ORIGIN@        for (i = 0; i < 3; ++i) {
            if (JOINT[k] >= 0) {
                double c = w->cosine[JOINT[k]], s = w->sine[JOINT[k]];
                local[i][0] = fixed[i][0] * c + fixed[i][1] * s;
                local[i][1] = fixed[i][1] * c - fixed[i][0] * s;
            } else {
                local[i][0] = fixed[i][0];
                local[i][1] = fixed[i][1];
            }
            local[i][2] = fixed[i][2];
        }
        for (i = 0; i < 3; ++i) {
            if (k == 0) {
                for (j = 0; j < 3; ++j) {
                    before->r[i][j] = local[i][j];
                }
                before->p[i] = @AT_I@;
            } else {
                const frame *last = &w->after[shape][k - 1];
                for (j = 0; j < 3; ++j) {
                    before->r[i][j] =
                        last->r[i][0] * local[0][j] + last->r[i][1] * local[1][j] + last->r[i][2] * local[2][j];
                }
                before->p[i] = last->p[i] + last->r[i][0] * @AT_0@ + last->r[i][1] * @AT_1@ +
                               last->r[i][2] * @AT_2@;
            }
        }
        if (DEFORMED) {
            for (i = 0; i < 3; ++i) {
                const double *r = before->r[i];
                after->p[i] = before->p[i] + r[0] * d[0] + r[1] * d[1] + r[2] * d[2];
                after->r[i][0] = r[0] + r[1] * d[5] - r[2] * d[4];
                after->r[i][1] = r[1] - r[0] * d[5] + r[2] * d[3];
                after->r[i][2] = r[2] + r[0] * d[4] - r[1] * d[3];
            }
        } else {
            *after = *before;
        }
    }
}

/* The reading's axes in base axes, as columns, on the loaded shape. */
static void reading_axes(const work *w, double axes[3][3])
{
    int i, j;
    for (i = 0; i < 3; ++i) {
        for (j = 0; j < 3; ++j) {
            if (AXES_NODE < 0) {
                axes[i][j] = AXES[i][j];
            } else {
                const double *r = w->after[0][AXES_NODE < 0 ? 0 : AXES_NODE].r[i];
                axes[i][j] = r[0] * AXES[0][j] + r[1] * AXES[1][j] + r[2] * AXES[2][j];
            }
        }
    }
}

/* What the nodes of one shape carry, and their displacements by it. */
static void respond(@PREFIX@_state *state, work *w, int shape)
{
    double force[3] = {0.0, 0.0, 0.0}, moment[3] = {0.0, 0.0, 0.0}, point[3] = {0.0, 0.0, 0.0};
    double mass = 0.0, centre[3] = {0.0, 0.0, 0.0};
    double small[6 * NODES];
    double *load = w->load[shape];
    int k, i;
    if (shape == 0) {
        double axes[3][3];
        const frame *at = &w->after[0][LOAD_NODE];
        reading_axes(w, axes);
        for (i = 0; i < 3; ++i) {
            const double *a = axes[i];
            force[i] = a[0] * state->wrench[0] + a[1] * state->wrench[1] + a[2] * state->wrench[2];
            if (MOMENTS_MEASURED) {
                moment[i] = a[0] * state->wrench[3] + a[1] * state->wrench[4] + a[2] * state->wrench[5];
            }
            point[i] = at->p[i] + at->r[i][0] * LOAD_POINT[0] + at->r[i][1] * LOAD_POINT[1] +
                       at->r[i][2] * LOAD_POINT[2];
        }
    }
    for (k = NODES - 1; k >= 0; --k) {
        const frame *after = &w->after[shape][k], *before = &w->before[shape][k];
        double f[3], m[3], arm[3], lever[3];
        int loaded = shape == 0 && k <= LOAD_NODE;
        mass += MASS[k];
        for (i = 0; i < 3; ++i) {
            const double *r = after->r[i];
            centre[i] += r[0] * MASS_MOMENT[k][0] + r[1] * MASS_MOMENT[k][1] + r[2] * MASS_MOMENT[k][2] +
                         MASS[k] * after->p[i];
            arm[i] = centre[i] - mass * after->p[i];
            lever[i] = point[i] - after->p[i];
            f[i] = mass * GRAVITY[i] + (loaded ? force[i] : 0.0);
        }
        m[0] = arm[1] * GRAVITY[2] - arm[2] * GRAVITY[1];
        m[1] = arm[2] * GRAVITY[0] - arm[0] * GRAVITY[2];
        m[2] = arm[0] * GRAVITY[1] - arm[1] * GRAVITY[0];
        if (loaded) {
            m[0] += moment[0] + lever[1] * force[2] - lever[2] * force[1];
            m[1] += moment[1] + lever[2] * force[0] - lever[0] * force[2];
            m[2] += moment[2] + lever[0] * force[1] - lever[1] * force[0];
        }
        for (i = 0; i < 3; ++i) {
            load[6 * k + i] = before->r[0][i] * f[0] + before->r[1][i] * f[1] + before->r[2][i] * f[2];
            load[6 * k + 3 + i] = before->r[0][i] * m[0] + before->r[1][i] * m[1] + before->r[2][i] * m[2];
        }
    }
    for (k = 0; k < BALANCERS; ++k) {
        const balancer *of = &BALANCER[k];
        double turned = w->angle[of->joint] + (DEFORMED ? state->small[shape][of->node][5] : 0.0);
        load[6 * of->node + 5] += balancing_torque(of, turned);
    }
    for (k = 0; k < 6 * NODES; ++k) {
        small[k] = 0.0;
    }
    for (k = 0; k < SPRINGS; ++k) {
        small[SPRING[k].to] += SPRING[k].compliance * load[SPRING[k].from];
    }
    for (k = 0; k < LAWS; ++k) {
        const law *of = &LAW[k];
        double carried = 0.0, moved;
        for (i = of->first; i < of->first + of->count; ++i) {
            carried += WEIGHT[i].factor * load[WEIGHT[i].index];
        }
        if (of->form == PLAY) {
            double value = played_from_rest(of->n[1], carried);
            if (shape == 0) {
                /* before the first call weight alone has acted, in one move; shape 1 is computed first */
                value = played(of->n[1], carried, state->started ? state->memory[of->memory] : w->memory[of->memory]);
                w->memory[of->memory] = value;
            } else if (!state->started) {
                w->memory[of->memory] = value;
            }
            moved = of->n[0] * value;
        } else {
            moved = answer(of, carried, w->angle);
        }
        for (i = of->first; i < of->first + of->count; ++i) {
            small[WEIGHT[i].index] += WEIGHT[i].factor * moved;
        }
    }
    for (k = 0; k < NODES; ++k) {
        for (i = 0; i < 6; ++i) {
            state->small[shape][k][i] = small[6 * k + i];
        }
    }
}

/* The process wrench: without the tool's weight, filtered. */
static void take(@PREFIX@_state *state, const work *w, const double reading[6])
{
    double axes[3][3], gravity[3];
    int i;
    reading_axes(w, axes);
    for (i = 0; i < 3; ++i) {
        gravity[i] = axes[0][i] * GRAVITY[0] + axes[1][i] * GRAVITY[1] + axes[2][i] * GRAVITY[2];
    }
    for (i = 0; i < 6; ++i) {
        double u = reading[i] - (TOOL[i][0] * gravity[0] + TOOL[i][1] * gravity[1] + TOOL[i][2] * gravity[2]) +
                   ZEROED[i];
        double y;
        if (!state->started) {
            state->filter[0][i] = (1.0 - B[0]) * u;
            state->filter[1][i] = (B[2] - A[1]) * u;
        }
        y = B[0] * u + state->filter[0][i];
        state->filter[0][i] = state->filter[1][i] + B[1] * u - A[0] * y;
        state->filter[1][i] = B[2] * u - A[1] * y;
        state->wrench[i] = y;
    }
}

/*
 * The target's way from the unloaded shape to the loaded one, and how it moves with the joints; halfway between both
 * shapes, where the chain's derivative is exact to the second order.
 */
static void deflect(@PREFIX@_state *state, const work *w, double motion[6][LOGGED])
{
    double target[3];
    int k, i, j;
    for (i = 0; i < 3; ++i) {
        target[i] = 0.0;
        for (j = 0; j < 2; ++j) {
            const frame *at = &w->after[j][TARGET_NODE];
            target[i] += 0.5 * (at->p[i] + at->r[i][0] * TARGET[0] + at->r[i][1] * TARGET[1] + at->r[i][2] * TARGET[2]);
        }
    }
    for (i = 0; i < 6; ++i) {
        state->deflection[i] = 0.0;
        for (j = 0; j < LOGGED; ++j) {
            motion[i][j] = 0.0;
        }
    }
    for (k = 0; k <= TARGET_NODE; ++k) {
        double r[3][3], arm[3], shift[3], turn[3], d[6];
        for (i = 0; i < 6; ++i) {
            d[i] = state->small[0][k][i] - state->small[1][k][i];
        }
        for (i = 0; i < 3; ++i) {
            for (j = 0; j < 3; ++j) {
                r[i][j] = 0.25 * (w->before[0][k].r[i][j] + w->before[1][k].r[i][j] + w->after[0][k].r[i][j] +
                                  w->after[1][k].r[i][j]);
            }
            arm[i] = target[i] - 0.5 * (w->after[0][k].p[i] + w->after[1][k].p[i]);
            shift[i] = r[i][0] * d[0] + r[i][1] * d[1] + r[i][2] * d[2];
            turn[i] = r[i][0] * d[3] + r[i][1] * d[4] + r[i][2] * d[5];
        }
        state->deflection[0] += shift[0] + turn[1] * arm[2] - turn[2] * arm[1];
        state->deflection[1] += shift[1] + turn[2] * arm[0] - turn[0] * arm[2];
        state->deflection[2] += shift[2] + turn[0] * arm[1] - turn[1] * arm[0];
        state->deflection[3] += turn[0];
        state->deflection[4] += turn[1];
        state->deflection[5] += turn[2];
        if (JOINT[k] >= 0) {
            double column[6];
            column[0] = r[1][2] * arm[2] - r[2][2] * arm[1];
            column[1] = r[2][2] * arm[0] - r[0][2] * arm[2];
            column[2] = r[0][2] * arm[1] - r[1][2] * arm[0];
            column[3] = r[0][2];
            column[4] = r[1][2];
            column[5] = r[2][2];
@SLIDES_COLUMN@            for (j = 0; j < LOGGED; ++j) {
                double share = COUPLING[JOINT[k]][j];
                if (share != 0.0) {
                    for (i = 0; i < 6; ++i) {
                        motion[i][j] -= share * column[i];
                    }
                }
            }
        }
    }
}

/* offsets = Mt (M Mt + damping^2)^-1 deflection, M = -(motion of the target per logged angle), by Cholesky's method. */
static int solve(const @PREFIX@_state *state, double motion[6][LOGGED], double offsets[LOGGED])
{
    double c[6][6], x[6], sum = 0.0;
    int i, j, k;
    for (i = 0; i < 6; ++i) {
        for (j = 0; j <= i; ++j) {
            double value = i == j ? DAMPING * DAMPING : 0.0;
            for (k = 0; k < LOGGED; ++k) {
                value += motion[i][k] * motion[j][k];
            }
            for (k = 0; k < j; ++k) {
                value -= c[i][k] * c[j][k];
            }
            if (i == j) {
                if (!(value > 0.0)) {
                    return 0;
                }
                c[i][i] = sqrt(value);
            } else {
                c[i][j] = value / c[j][j];
            }
        }
    }
    for (i = 0; i < 6; ++i) {
        x[i] = state->deflection[i];
        for (k = 0; k < i; ++k) {
            x[i] -= c[i][k] * x[k];
        }
        x[i] /= c[i][i];
    }
    for (i = 5; i >= 0; --i) {
        for (k = i + 1; k < 6; ++k) {
            x[i] -= c[k][i] * x[k];
        }
        x[i] /= c[i][i];
    }
    for (j = 0; j < LOGGED; ++j) {
        offsets[j] = 0.0;
        for (i = 0; i < 6; ++i) {
            offsets[j] += motion[i][j] * x[i];
        }
        sum += offsets[j];
    }
    return isfinite(sum) ? 1 : 0;
}

/* Cut off at the largest correction, all joints in proportion, and at the joint limits. */
static void keep_within(const double joints[LOGGED], double offsets[LOGGED])
{
    double most = 0.0;
    int j;
    for (j = 0; j < LOGGED; ++j) {
        most = fabs(offsets[j]) > most ? fabs(offsets[j]) : most;
    }
    for (j = 0; j < LOGGED; ++j) {
        if (most > LARGEST) {
            offsets[j] *= LARGEST / most;
        }
        offsets[j] = offsets[j] < LIMITS[j][0] - joints[j] ? LIMITS[j][0] - joints[j] : offsets[j];
        offsets[j] = offsets[j] > LIMITS[j][1] - joints[j] ? LIMITS[j][1] - joints[j] : offsets[j];
    }
}

void @PREFIX@_reset(@PREFIX@_state *state)
{
    static const @PREFIX@_state nothing;
    *state = nothing;
}

int @PREFIX@_step(@PREFIX@_state *state, const double joints[@CAPS@_JOINTS], const double reading[6],
                  double offsets[@CAPS@_JOINTS])
{
    work w;
    double motion[6][LOGGED];
    int k, j, sweeps = state->started ? SWEEPS : FIRST_SWEEPS;
    for (k = 0; k < JOINTS; ++k) {
        w.angle[k] = OFFSET[k];
        for (j = 0; j < LOGGED; ++j) {
            w.angle[k] += COUPLING[k][j] * joints[j];
        }
        w.cosine[k] = cos(w.angle[k]);
        w.sine[k] = sin(w.angle[k]);
@SLIDES_ANGLE@    }
    for (k = 0; k < sweeps; ++k) {
        place(state, &w, 0);
        place(state, &w, 1);
        if (k == 0) {
            take(state, &w, reading);
        }
        respond(state, &w, 1);
        respond(state, &w, 0);
    }
    state->started = 1;
    for (k = 0; k < @CAPS@_MEMORIES && @N_PLAYS@ > 0; ++k) {
        state->memory[k] = w.memory[k];
    }
    deflect(state, &w, motion);
    if (!solve(state, motion, offsets)) {
        @PREFIX@_reset(state);
        for (j = 0; j < LOGGED; ++j) {
            offsets[j] = 0.0;
        }
        return 0;
    }
    keep_within(joints, offsets);
    return 1;
}

const char *@PREFIX@_model_hash(void)
{
    return HASH;
}
