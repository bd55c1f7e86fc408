/* Replays samples as replay.c does, through the C code that MATIEC makes of Structured Text (POUS.c, POUS.h). */
#include <stdio.h>
#include <string.h>

#include "iec_std_lib.h"

#include "POUS.h"

TIME __CURRENT_TIME;
BOOL __DEBUG;

#include "POUS.c"

#define L ((int)(sizeof(((COMPENSATION_STEP *)0)->JOINTS.value.table) / sizeof(double)))

int main(void)
{
    static COMPENSATION_STEP block;
    double in[64], out[64];
    COMPENSATION_STEP_init__(&block, 0);
    while (fread(in, sizeof(double), (size_t)(7 + L), stdin) == (size_t)(7 + L)) {
        block.RESTART.value = in[0] != 0.0;
        memcpy(block.JOINTS.value.table, in + 1, sizeof block.JOINTS.value.table);
        memcpy(block.READING.value.table, in + 1 + L, sizeof block.READING.value.table);
        COMPENSATION_STEP_body__(&block);
        out[0] = block.SOLVED.value;
        memcpy(out + 1, block.OFFSETS.value.table, sizeof block.OFFSETS.value.table);
        memcpy(out + 1 + L, block.DEFLECTION.value.table, sizeof block.DEFLECTION.value.table);
        memcpy(out + 7 + L, block.WRENCH.value.table, sizeof block.WRENCH.value.table);
        fwrite(out, sizeof(double), (size_t)(13 + L), stdout);
    }
    fprintf(stderr, "%.32s%.32s\n", (char *)block.HASH_1.value.body, (char *)block.HASH_2.value.body);
    return 0;
}
