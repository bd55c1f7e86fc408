/*
@HEAD@
 */
#ifndef @GUARD@
#define @GUARD@

#define @CAPS@_JOINTS @N_LOGGED@ /* logged joint angles, in this order: @JOINT_NAMES@ */
#define @CAPS@_NODES @N_NODES@
#define @CAPS@_MEMORIES @N_MEMORIES@ /* play operators of friction hysteresis; at least 1 */

/* What one robot's loop keeps from call to call: one for each robot, static or on the stack. */
typedef struct {
    double small[2][@CAPS@_NODES][6]; /* m, rad: nodes' displacements, loaded and under weight alone, node axes */
    double filter[2][6];              /* the filter's two memories, N and N m */
    double memory[@CAPS@_MEMORIES];   /* N m: play operators */
    double wrench[6];                 /* last call's filtered wrench without the tool's weight, N, N m */
    double deflection[6];             /* last call's deflection of the target, m, rad, base axes */
    int started;                      /* 0 before the first call and after a reset */
} @PREFIX@_state;

/* Forget what was: the next sample is taken as having stood for ever. Call it before the first step. */
void @PREFIX@_reset(@PREFIX@_state *state);

/*
 * One cycle. Call it every @CYCLE@ s (the filter's coefficients are for this time).
 *
 * joints   logged joint angles as commanded, rad
 * reading  what the surroundings do to the robot: force (N), then moment (N m), in the axes and about the point that
 *          the head of this file describes
 * offsets  out: to be added to the commanded logged angles, rad
 *
 * Returns 1; 0 where an angle or a reading is no number: offsets are zero then, and the state is reset.
 */
int @PREFIX@_step(@PREFIX@_state *state, const double joints[@CAPS@_JOINTS], const double reading[6],
                  double offsets[@CAPS@_JOINTS]);

/* SHA-256 of the model's numbers, 64 hexadecimal digits, as `stiffcal export` printed it. */
const char *@PREFIX@_model_hash(void);

#endif
