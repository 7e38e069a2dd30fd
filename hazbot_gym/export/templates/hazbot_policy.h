/* {{ spec }}: a speed policy of hazbot_gym {{ version }} in C99, made by `hazbot export`.
 *
 * It chooses the speed of a robot along its path. It has no heap, no global state and no library:
 * tanh, exp, sine and square root are written out, and a compiler calls at most memcpy and memset.
 * Compile it without -ffast-math, which would remove the check for NaN.
 *
 * No policy of hazbot_gym has driven a real robot. Use a safety layer that can stop the robot.
 */
#ifndef HAZBOT_POLICY_H
#define HAZBOT_POLICY_H

#define HAZBOT_WIDTH {{ fields | length }}
#define HAZBOT_NOMINAL_MPS {{ nominal_mps | single }} /* speed of action +1 */
#define HAZBOT_PERIOD_S {{ period_s | single }} /* between two decisions */
{% if has_memory %}
#define HAZBOT_HAS_MEMORY 1 /* an answer depends on earlier observations */
{% endif %}
{% if memory %}
#define HAZBOT_MEMORY {{ memory }} /* size of the LSTM */
{% endif %}

/* Entries of an observation, and their units. */
enum hazbot_field {
{% for field in fields %}
    HAZBOT_{{ field.name | upper }} = {{ loop.index0 }}{{ "," if not loop.last else "" }} /* {{ field.unit }}: {{ field.meaning }} */
{% endfor %}
};

{% if sonar %}
/* Filter of one range sensor's echo. */
typedef struct {
    double range_m;
    double towards_mps; /* the source's own speed towards the robot */
    double steady_s; /* time without motion */
    double lost_s; /* time without an echo */
    int heard; /* readings of this source so far */
    int is_person;
} hazbot_echo;

{% endif %}
{% if has_memory %}
/* Memory of a round. */
typedef struct {
{% if memory %}
    float hidden[HAZBOT_MEMORY];
    float cell[HAZBOT_MEMORY];
{% endif %}
{% if sonar %}
    hazbot_echo echoes[{{ sonar.sensors | length }}];
    double side_wall_m[2]; /* the left and the right one */
    int has_begun;
{% endif %}
} hazbot_memory;

/* Begin a round: on a new path, and after a gap between two decisions. */
void hazbot_reset(hazbot_memory *memory);

{% endif %}
/* Encode fields in their units as an observation; values are clipped to their bounds. */
void hazbot_encode(const float fields[HAZBOT_WIDTH], float observation[HAZBOT_WIDTH]);

/* Return the action in [-1, 1]: -1 stop, +1 nominal speed; -1 for an observation out of bounds. */
float hazbot_act(const float observation[HAZBOT_WIDTH]{{ ", hazbot_memory *memory" if has_memory else "" }});

/* Return the speed that an action commands, in m/s. */
float hazbot_speed_mps(float action);

#endif
