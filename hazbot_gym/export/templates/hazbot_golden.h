/* Golden vectors of {{ spec }}: observations one after another, and the actions in Python.
 * Where a round starts, the memory is reset.
 */
#ifndef HAZBOT_GOLDEN_H
#define HAZBOT_GOLDEN_H

#define HAZBOT_GOLDEN {{ actions | length }}

static const float golden_observations[HAZBOT_GOLDEN][{{ observations[0] | length }}] = {
{% for row in observations %}
    {
{% for part in row | batch(8) %}
        {{ part | map("single") | join(", ") }},
{% endfor %}
    },
{% endfor %}
};

static const unsigned char golden_starts[HAZBOT_GOLDEN] = {
{% for part in starts | batch(16) %}
    {{ part | map("int") | join(", ") }},
{% endfor %}
};

static const float golden_actions[HAZBOT_GOLDEN] = {
{% for part in actions | batch(8) %}
    {{ part | map("single") | join(", ") }},
{% endfor %}
};

#endif
