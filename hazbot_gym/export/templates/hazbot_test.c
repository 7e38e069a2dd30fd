/* Run the golden vectors of {{ spec }}; the exit code is 0 if all actions are equal within {{ tolerance }}.
 *
 *     cc -std=c99 -Wall -Wextra -Werror -pedantic hazbot_test.c hazbot_policy.c -o hazbot_test
 */
#include <stdio.h>

#include "hazbot_golden.h"
#include "hazbot_policy.h"

int main(void)
{
    float largest = 0.0f;
    int i;
{% if has_memory %}
    hazbot_memory memory;
{% endif %}
    for (i = 0; i < HAZBOT_GOLDEN; i++) {
        float difference;
{% if has_memory %}
        if (golden_starts[i]) {
            hazbot_reset(&memory);
        }
{% else %}
        (void)golden_starts;
{% endif %}
        difference = hazbot_act(golden_observations[i]{{ ", &memory" if has_memory else "" }}) - golden_actions[i];
        difference = difference < 0.0f ? -difference : difference;
        if (!(difference <= largest)) {
            largest = difference;
        }
    }
    printf("%d golden vectors, largest difference %g\n", HAZBOT_GOLDEN, (double)largest);
    return largest <= {{ tolerance | single }} ? 0 : 1;
}
