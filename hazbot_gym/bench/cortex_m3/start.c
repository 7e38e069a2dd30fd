/* Start of a program on a bare Cortex-M3, and output over semihosting. */
#include <stddef.h>

#include "start.h"

extern unsigned data_load[], data_start[], data_end[], bss_start[], bss_end[], stack_top[];
int main(void);

static int host(int operation, const void *argument)
{
    register int r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

void print(const char *name, unsigned value)
{
    char digits[12];
    int i = 11;
    digits[i] = 0;
    digits[--i] = '\n';
    do {
        digits[--i] = (char)('0' + value % 10);
        value /= 10;
    } while (value);
    host(4, name); /* SYS_WRITE0 */
    host(4, digits + i);
}

void reset(void)
{
    unsigned *from = data_load, *to;
    for (to = data_start; to < data_end; to++) {
        *to = *from++;
    }
    for (to = bss_start; to < bss_end; to++) {
        *to = 0;
    }
    host(0x18, (const void *)(main() == 0 ? 0x20026 : 0x20023)); /* SYS_EXIT */
    for (;;) {
    }
}

static void fault(void)
{
    print("fault=", 1);
    host(0x18, (const void *)0x20023);
    for (;;) {
    }
}

__attribute__((section(".vectors"), used)) static void *const vectors[16] = {
    stack_top, (void *)reset, (void *)fault, (void *)fault, (void *)fault, (void *)fault,
};

/* What a compiler may call even for freestanding code. */
__attribute__((optimize("no-tree-loop-distribute-patterns")))
void *memcpy(void *to, const void *from, size_t size)
{
    char *a = to;
    const char *b = from;
    while (size--) {
        *a++ = *b++;
    }
    return to;
}

__attribute__((optimize("no-tree-loop-distribute-patterns")))
void *memset(void *to, int value, size_t size)
{
    char *a = to;
    while (size--) {
        *a++ = (char)value;
    }
    return to;
}
