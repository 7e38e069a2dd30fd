/* {{ spec }}: see hazbot_policy.h. */
#include "hazbot_policy.h"

{% if has_float_exp or has_double_exp %}
#include <stdint.h>

{% endif %}
{% macro floats(name, values) %}
static const float {{ name }}[{{ values | length }}] = {
{% for row in values | batch(8) %}
    {{ row | map("single") | join(", ") }},
{% endfor %}
};
{% endmacro %}
{% macro doubles(name, values) %}
static const double {{ name }}[{{ values | length }}] = {
{% for row in values | batch(4) %}
    {{ row | map("double") | join(", ") }},
{% endfor %}
};
{% endmacro %}
/* --- observations ------------------------------------------------------------------------------ */

{{ floats("field_low", low) }}
{{ floats("field_high", high) }}
{{ floats("field_scale", scales) }}
/* Bounds of a valid observation. */
{{ floats("valid_low", valid_low) }}
{{ floats("valid_high", valid_high) }}
static float clip(float value, float low, float high)
{
    return value < low ? low : value > high ? high : value;
}

void hazbot_encode(const float fields[HAZBOT_WIDTH], float observation[HAZBOT_WIDTH])
{
    int i;
    for (i = 0; i < HAZBOT_WIDTH; i++) {
        observation[i] = clip(fields[i], field_low[i], field_high[i]) / field_scale[i];
    }
}

/* NaN is not between two bounds. */
static int is_valid(const float observation[HAZBOT_WIDTH])
{
    int i;
    for (i = 0; i < HAZBOT_WIDTH; i++) {
        if (!(observation[i] >= valid_low[i] && observation[i] <= valid_high[i])) {
            return 0;
        }
    }
    return 1;
}

float hazbot_speed_mps(float action)
{
    return HAZBOT_NOMINAL_MPS * 0.5f * (clip(action, -1.0f, 1.0f) + 1.0f);
}

{% if has_float_exp %}
/* --- exp and tanh ------------------------------------------------------------------------------- */

/* exp(x) = 2^n exp(r) with |r| <= ln(2) / 2, and the polynomial of Cephes (Moshier) for exp(r). */
static float exp_of(float x)
{
    union {
        uint32_t bits;
        float value;
    } power;
    float r, p;
    int n;
    x = clip(x, -87.0f, 88.0f);
    n = (int)(x * 1.44269504f + (x < 0.0f ? -0.5f : 0.5f));
    r = x - (float)n * 0.693359375f + (float)n * 2.12194440e-4f;
    p = 1.9875691500e-4f;
    p = p * r + 1.3981999507e-3f;
    p = p * r + 8.3334519073e-3f;
    p = p * r + 4.1665795894e-2f;
    p = p * r + 1.6666665459e-1f;
    p = p * r + 5.0000001201e-1f;
    power.bits = (uint32_t)(n + 127) << 23;
    return (p * r * r + r + 1.0f) * power.value;
}

static float tanh_of(float x)
{
    float size = x < 0.0f ? -x : x;
    float value = size > 9.0f ? 1.0f : 1.0f - 2.0f / (exp_of(2.0f * size) + 1.0f);
    return x < 0.0f ? -value : value;
}

{% endif %}
{% if has_double_exp %}
/* --- exp ---------------------------------------------------------------------------------------- */

/* exp(x) for x <= 0: 2^n exp(r) with |r| <= ln(2) / 2, and the series of exp(r). */
static double exp_of_negative(double x)
{
    union {
        uint64_t bits;
        double value;
    } power;
    double r, p;
    int n, k;
    if (x < -700.0) {
        return 0.0;
    }
    n = (int)(x * 1.4426950408889634 - 0.5);
    r = x - (double)n * 0.69314718036912382 - (double)n * 1.9082149292705877e-10;
    p = 1.0;
    for (k = 13; k > 0; k--) {
        p = p * r / (double)k + 1.0;
    }
    power.bits = (uint64_t)(n + 1023) << 52;
    return p * power.value;
}

{% endif %}
{% if actor %}
/* --- network ------------------------------------------------------------------------------------ */

{% if actor.normalisation %}
{{ floats("mean", actor.mean) }}
{{ floats("deviation", actor.deviation) }}
{% endif %}
{% if memory %}
/* Gates i, f, g, o, from the observation and then the hidden state. */
{{ floats("gate_weight", actor.gate_weight) }}
{{ floats("gate_bias", actor.gate_bias) }}
{% endif %}
{% for layer in actor.layers %}
/* {{ layer.inputs }} to {{ layer.outputs }}, row by row of the inputs */
{{ floats("weight%d" % loop.index0, layer.weight) }}
{{ floats("bias%d" % loop.index0, layer.bias) }}
{% endfor %}
/* y = x W + b, summed in the order of hazbot_gym, four inputs at a time. */
static void apply(const float *x, int inputs, const float *weight, const float *bias, float *y,
                  int outputs)
{
    int fours = inputs - inputs % 4;
    int j, k;
    for (k = 0; k < outputs; k++) {
        y[k] = bias[k];
    }
    for (j = 0; j < fours; j += 4) {
        const float *w = weight + j * outputs;
        for (k = 0; k < outputs; k++) {
            y[k] = y[k] + x[j] * w[k] + x[j + 1] * w[outputs + k] + x[j + 2] * w[2 * outputs + k]
                   + x[j + 3] * w[3 * outputs + k];
        }
    }
    for (j = fours; j < inputs; j++) {
        for (k = 0; k < outputs; k++) {
            y[k] += x[j] * weight[j * outputs + k];
        }
    }
}

{% if actor.layers | length > 1 %}
static void activate(float *x, int size)
{
    int k;
    for (k = 0; k < size; k++) {
        x[k] = {{ "tanh_of(x[k])" if actor.activation == "tanh" else "x[k] > 0.0f ? x[k] : 0.0f" }};
    }
}

{% endif %}
{% if memory %}
static float sigmoid(float x)
{
    return 0.5f * (tanh_of(0.5f * x) + 1.0f);
}

/* One step of the LSTM: `next` from `memory` and x. */
static void remember(const float *x, const hazbot_memory *memory, hazbot_memory *next)
{
    float inputs[HAZBOT_WIDTH + HAZBOT_MEMORY];
    float gates[4 * HAZBOT_MEMORY];
    int k;
    for (k = 0; k < HAZBOT_WIDTH; k++) {
        inputs[k] = x[k];
    }
    for (k = 0; k < HAZBOT_MEMORY; k++) {
        inputs[HAZBOT_WIDTH + k] = memory->hidden[k];
    }
    apply(inputs, HAZBOT_WIDTH + HAZBOT_MEMORY, gate_weight, gate_bias, gates, 4 * HAZBOT_MEMORY);
    for (k = 0; k < HAZBOT_MEMORY; k++) {
        float i = sigmoid(gates[k]);
        float f = sigmoid(gates[HAZBOT_MEMORY + k]);
        float g = tanh_of(gates[2 * HAZBOT_MEMORY + k]);
        float o = sigmoid(gates[3 * HAZBOT_MEMORY + k]);
        next->cell[k] = f * memory->cell[k] + i * g;
        next->hidden[k] = o * tanh_of(next->cell[k]);
    }
}

{% endif %}
/* Write the network's answer in [-1, 1]; return 0 if an output is not finite. */
static int network(const float *observation, float *answer{{ ", const hazbot_memory *memory, hazbot_memory *next" if memory else "" }})
{
{% for layer in actor.layers %}
    float y{{ loop.index0 }}[{{ layer.outputs }}];
{% endfor %}
{% if actor.normalisation %}
    float x[HAZBOT_WIDTH];
{% else %}
    const float *x = observation;
{% endif %}
    int k;
{% if actor.head == "levels" %}
    int best = 0;
{% endif %}
{% if actor.normalisation %}
    for (k = 0; k < HAZBOT_WIDTH; k++) {
        x[k] = clip((observation[k] - mean[k]) / deviation[k], -{{ actor.clip | single }}, {{ actor.clip | single }});
    }
{% endif %}
{% if memory %}
    remember(x, memory, next);
{% endif %}
{% for layer in actor.layers %}
    apply({{ "y%d" % (loop.index0 - 1) if loop.index0 else ("next->hidden" if memory else "x") }}, {{ layer.inputs }}, weight{{ loop.index0 }}, bias{{ loop.index0 }}, y{{ loop.index0 }}, {{ layer.outputs }});
{% if not loop.last %}
    activate(y{{ loop.index0 }}, {{ layer.outputs }});
{% endif %}
{% endfor %}
{% set y = "y%d" % (actor.layers | length - 1) %}
{% set outputs = (actor.layers | last).outputs %}
    for (k = 0; k < {{ outputs }}; k++) {
        if (!({{ y }}[k] >= -3.4e38f && {{ y }}[k] <= 3.4e38f)) {
            return 0;
        }
{% if actor.head == "levels" %}
        if ({{ y }}[k] > {{ y }}[best]) {
            best = k;
        }
{% endif %}
    }
{% if actor.head == "levels" %}
    *answer = 2.0f * ((float)best / {{ [outputs - 1, 1] | max | single }}) - 1.0f;
{% elif actor.head == "squashed" %}
    *answer = tanh_of({{ y }}[0]);
{% else %}
    *answer = clip({{ y }}[0], -1.0f, 1.0f);
{% endif %}
    return 1;
}

{% endif %}
{% if sonar %}
{% include "sonar.c" %}

{% endif %}
{% if rule %}
{% include "rule_%s.c" % rule.kind %}

{% endif %}
/* --- policy ------------------------------------------------------------------------------------- */

{% if has_memory %}
void hazbot_reset(hazbot_memory *memory)
{
{% if memory %}
    int k;
    for (k = 0; k < HAZBOT_MEMORY; k++) {
        memory->hidden[k] = 0.0f;
        memory->cell[k] = 0.0f;
    }
{% endif %}
{% if sonar %}
    memory->has_begun = 0;
{% endif %}
}

{% endif %}
float hazbot_act(const float observation[HAZBOT_WIDTH]{{ ", hazbot_memory *memory" if has_memory else "" }})
{
{% if actor %}
    float answer;
{% endif %}
{% if has_memory %}
    hazbot_memory next;
{% endif %}
{% if sonar %}
    float seen[{{ sonar.width }}];
{% elif rule %}
    const float *seen = observation;
{% endif %}
    if (!is_valid(observation)) {
        return -1.0f;
    }
{% if has_memory %}
    next = *memory;
{% endif %}
{% if actor %}
    if (!network(observation, &answer{{ ", memory, &next" if memory else "" }})) {
        return -1.0f;
    }
{% endif %}
{% if sonar %}
    listen(observation, memory, &next);
    add_people(observation, &next, seen);
{% endif %}
{% if has_memory %}
    *memory = next;
{% endif %}
{% if actor and rule %}
    return clip(2.0f * rule_share(seen) - 1.0f + {{ correction | single }} * answer, -1.0f, 1.0f);
{% elif actor %}
    return answer;
{% else %}
    return 2.0f * rule_share(seen) - 1.0f;
{% endif %}
}
