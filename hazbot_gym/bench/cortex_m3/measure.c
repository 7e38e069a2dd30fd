/* Run the golden vectors on a Cortex-M3: largest difference, most timer ticks, depth of the stack. */
#include "hazbot_golden.h"
#include "hazbot_policy.h"
#include "start.h"

#define SYSTICK ((volatile unsigned *)0xE000E010) /* control, reload, value */
#define UNTOUCHED 0xA5A5A5A5u
#define LOOPS 1000000u

extern unsigned bss_end[];
static float actions[HAZBOT_GOLDEN];

static unsigned now(void)
{
    return SYSTICK[2];
}

/* Ticks of a loop of two instructions, which tell how many instructions a tick is. */
static unsigned calibrate(void)
{
    unsigned loops = LOOPS, start = now();
    __asm__ volatile("1: subs %0, #1\n bne 1b" : "+r"(loops) : : "cc");
    return (start - now()) & 0xFFFFFF;
}

/* Act on all vectors, and return the most ticks that one of them took. */
static __attribute__((noinline)) unsigned act(void)
{
    unsigned most = 0;
    int i;
#ifdef HAZBOT_HAS_MEMORY
    static hazbot_memory memory;
#endif
    for (i = 0; i < HAZBOT_GOLDEN; i++) {
        unsigned start, taken;
#ifdef HAZBOT_HAS_MEMORY
        if (golden_starts[i]) {
            hazbot_reset(&memory);
        }
        start = now();
        actions[i] = hazbot_act(golden_observations[i], &memory);
#else
        (void)golden_starts;
        start = now();
        actions[i] = hazbot_act(golden_observations[i]);
#endif
        taken = (start - now()) & 0xFFFFFF;
        most = taken > most ? taken : most;
    }
    return most;
}

int main(void)
{
    unsigned here, ticks, *deepest;
    float largest = 0.0f;
    int i;
    SYSTICK[1] = 0xFFFFFF;
    SYSTICK[2] = 0;
    SYSTICK[0] = 5; /* on, from the processor's clock */
    print("calibration=", calibrate());
    __asm__ volatile("mov %0, sp" : "=r"(here));
    for (deepest = bss_end; deepest < (unsigned *)here - 4; deepest++) {
        *deepest = UNTOUCHED;
    }
    ticks = act();
    for (deepest = bss_end; *deepest == UNTOUCHED; deepest++) {
    }
    print("ticks=", ticks);
#ifdef HAZBOT_HAS_MEMORY
    print("memory=", sizeof(hazbot_memory));
#endif
    print("stack=", here - (unsigned)deepest);
    for (i = 0; i < HAZBOT_GOLDEN; i++) {
        float difference = actions[i] - golden_actions[i];
        difference = difference < 0.0f ? -difference : difference;
        if (!(difference <= largest)) {
            largest = difference;
        }
    }
    print("difference_e9=", (unsigned)(largest * 1e9f));
    return largest <= 1e-5f ? 0 : 1;
}
