/* --- people from echoes ------------------------------------------------------------------------- */

#define SENSORS {{ sonar.sensors | length }}
#define PERIOD_S {{ sonar.period_s | double }}

/* A sensor as it is mounted. */
typedef struct {
    double sine, cosine; /* of its direction */
    double side; /* 1 on the left, -1 on the right */
    double near_m; /* nearer echoes are people */
    double edge_rad; /* of the cone, away from the heading */
    double wall_offset_m;
    unsigned char wall; /* index of the wall on its side */
    unsigned char is_in_front, is_at_side;
} sensor;

static const sensor sensors[SENSORS] = {
{% for each in sonar.sensors %}
    { {{ each.numbers | map("double") | join(", ") }}, {{ each.flags | join(", ") }} },
{% endfor %}
};
/* The sensors that look at the left and at the right wall. */
static const int wall_sensors[2] = { {{ sonar.walls | join(", ") }} };

static double size_of(double x)
{
    return x < 0.0 ? -x : x;
}

/* sin(x) for 0 <= x <= pi / 2: its series. */
static double sine_of(double x)
{
    double term = x, sum = x;
    int k;
    for (k = 2; k < 24; k += 2) {
        term *= -x * x / (double)(k * (k + 1));
        sum += term;
    }
    return sum;
}

/* Whether a reading is that of a side wall, or no echo. */
static int is_wall(const sensor *at, double reading_m, double wall_m, double heading_error_rad)
{
    double edge_rad = at->edge_rad + at->side * heading_error_rad;
    double edge_m;
    if (reading_m > {{ sonar.nothing_m | double }}) {
        return 1;
    }
    if (at->is_at_side) {
        return reading_m > wall_m - {{ sonar.wall_m | double }};
    }
    edge_rad = edge_rad < 0.1 ? 0.1 : edge_rad;
    edge_rad = edge_rad > {{ sonar.quarter_rad | double }} ? {{ sonar.quarter_rad | double }} : edge_rad;
    edge_m = ({{ sonar.mount_m | double }} + wall_m - at->wall_offset_m) / sine_of(edge_rad);
    return size_of(reading_m - edge_m) < {{ sonar.wall_m | double }};
}

/* The state of a sensor's echo after one more reading. */
static hazbot_echo follow(const sensor *at, const hazbot_echo *last, double reading_m, double wall_m,
                          double speed_mps, double yaw_rate_radps, double heading_error_rad)
{
    hazbot_echo next;
    double predicted_m = last->range_m - (last->towards_mps + speed_mps * at->cosine) * PERIOD_S;
    double off_m = reading_m - predicted_m;
    int is_same = size_of(off_m) <= {{ sonar.leap_m | double }};
    int is_carried = off_m > {{ sonar.leap_m | double }} && last->is_person && last->lost_s < {{ sonar.carried_s | double }}
                     && predicted_m > 0.0;
    int is_new = !is_same && !is_carried;
    int wall = !is_carried && is_wall(at, reading_m, wall_m, heading_error_rad);
    int moves, turns_up, may_be_person;
    next.range_m = is_same ? predicted_m + {{ sonar.alpha | double }} * off_m : predicted_m;
    next.range_m = is_new || wall ? reading_m : next.range_m;
    next.towards_mps = last->towards_mps - (is_same ? {{ sonar.beta_per_s | double }} * off_m : 0.0);
    next.towards_mps = is_new || (wall && !at->is_at_side) ? 0.0 : next.towards_mps;
    next.heard = is_new ? 1 : last->heard + (last->heard < 1000 ? is_same : 0);
    moves = next.heard >= {{ sonar.settled }} && size_of(next.towards_mps) > {{ sonar.moving_mps | double }};
    next.steady_s = is_new || moves ? 0.0 : last->steady_s + PERIOD_S;
    turns_up = size_of(yaw_rate_radps) < {{ sonar.turning_radps | double }} && (moves || off_m < -{{ sonar.leap_m | double }});
    may_be_person = !wall && (at->is_at_side || turns_up || (last->is_person && !is_new));
    next.is_person = (may_be_person && next.steady_s < {{ sonar.steady_s | double }}) || is_carried
                     || reading_m < at->near_m;
    next.lost_s = is_carried ? last->lost_s + PERIOD_S : 0.0;
    return next;
}

/* Update the echoes of `next`, which is a copy of `last`, by one observation. */
static void listen(const float *observation, const hazbot_memory *last, hazbot_memory *next)
{
    int i;
    for (i = 0; i < SENSORS; i++) {
        double reading_m = (double)observation[i] * {{ sonar.range_scale | double }};
        if (last->has_begun) {
            next->echoes[i] = follow(&sensors[i], &last->echoes[i], reading_m,
                                     last->side_wall_m[sensors[i].wall],
                                     (double)observation[{{ sonar.speed[0] }}] * {{ sonar.speed[1] | double }},
                                     (double)observation[{{ sonar.yaw_rate[0] }}] * {{ sonar.yaw_rate[1] | double }},
                                     (double)observation[{{ sonar.heading[0] }}] * {{ sonar.heading[1] | double }});
        } else {
            hazbot_echo first = { 0.0, 0.0, 0.0, 0.0, 1, 0 };
            first.range_m = reading_m;
            first.is_person = reading_m < sensors[i].near_m;
            next->echoes[i] = first;
        }
    }
    for (i = 0; i < 2; i++) {
        const hazbot_echo *echo = &next->echoes[wall_sensors[i]];
        if (!last->has_begun || (echo->steady_s >= {{ sonar.steady_s | double }} && echo->range_m < {{ sonar.side_wall_m | double }})) {
            next->side_wall_m[i] = echo->range_m;
        }
    }
    next->has_begun = 1;
}

/* Write the person fields that the rule reads, of the nearest people among the echoes. */
static void add_people(const float *observation, const hazbot_memory *memory, float *seen)
{
    double nearer_m = 1e9, farther_m = 0.0;
    double speed_mps = (double)observation[{{ sonar.speed[0] }}] * {{ sonar.speed[1] | double }};
    int is_taken[SENSORS], straight, slot, i;
    for (i = 0; i < {{ sonar.width }}; i++) {
        seen[i] = i < HAZBOT_WIDTH ? observation[i] : 0.0f;
    }
    for (i = 0; i < SENSORS; i++) {
        double front_m = memory->echoes[i].is_person ? memory->echoes[i].range_m : 1e9;
        is_taken[i] = !memory->echoes[i].is_person;
        if (sensors[i].is_in_front) {
            nearer_m = front_m < nearer_m ? front_m : nearer_m;
            farther_m = front_m > farther_m ? front_m : farther_m;
        }
    }
    straight = farther_m < 1e9 && farther_m < nearer_m + {{ sonar.same_m | double }};
    for (slot = 0; slot < {{ sonar.slots | length }}; slot++) {
        static const int slots[{{ sonar.slots | length }}][{{ sonar.slots[0] | length }}] = {
{% for row in sonar.slots %}
            { {{ row | join(", ") }} },
{% endfor %}
        };
        const int *at = slots[slot];
        const hazbot_echo *echo;
        double range_m, cosine, u;
        int best = -1, is_straight, comes, goes, is_near, has_pattern;
        for (i = 0; i < SENSORS; i++) {
            if (!is_taken[i] && (best < 0 || memory->echoes[i].range_m < memory->echoes[best].range_m)) {
                best = i;
            }
        }
        if (best < 0) {
            return;
        }
        is_taken[best] = 1;
        echo = &memory->echoes[best];
        is_straight = sensors[best].is_in_front && straight;
        cosine = is_straight ? 1.0 : sensors[best].cosine;
        range_m = echo->range_m > 0.0 ? echo->range_m : 0.0;
        u = echo->towards_mps;
        comes = u > {{ sonar.moving_mps | double }};
        goes = u < -{{ sonar.moving_mps | double }};
        is_near = echo->range_m < {{ sonar.near_m | double }} && !goes && is_straight;
        has_pattern = !sensors[best].is_at_side;
        seen[at[0]] = 1.0f;
        seen[at[1]] = (float)((range_m + {{ sonar.to_centre_m | double }}) / {{ sonar.distance_scale | double }});
        seen[at[2]] = (float)(size_of(u) / {{ sonar.walking_scale | double }});
        seen[at[3]] = (float)cosine;
        seen[at[4]] = (float)((u + speed_mps * cosine) / {{ sonar.closing_scale | double }});
        seen[at[5]] = has_pattern && !comes && !goes && !is_near ? 1.0f : 0.0f;
        seen[at[6]] = has_pattern && comes && !is_straight ? 1.0f : 0.0f;
        seen[at[7]] = has_pattern && goes ? 1.0f : 0.0f;
        seen[at[8]] = has_pattern && ((comes && is_straight) || is_near) ? 1.0f : 0.0f;
    }
}
