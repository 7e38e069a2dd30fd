/* --- speed and separation monitoring ------------------------------------------------------------ */

/* Person fields: present, distance. */
static const int person_entries[{{ rule.entries | length }}][2] = {
{% for row in rule.entries %}
    { {{ row | join(", ") }} },
{% endfor %}
};

/* Newton's method, from above. */
static double square_root(double x)
{
    double root = x > 1.0 ? x : 1.0;
    int k;
    if (x <= 0.0) {
        return 0.0;
    }
    for (k = 0; k < 64; k++) {
        double next = 0.5 * (root + x / root);
        if (next >= root) {
            break;
        }
        root = next;
    }
    return root;
}

/* The largest speed at which the robot stops before a person who comes at {{ rule.approach_mps }} m/s. */
static float rule_share(const float *observation)
{
    double share = 1.0;
    int i;
    for (i = 0; i < {{ rule.entries | length }}; i++) {
        double spare_m, speed_mps = 0.0;
        if (!((double)observation[person_entries[i][0]] > 0.5)) {
            continue;
        }
        spare_m = (double)observation[person_entries[i][1]] * {{ rule.distance_scale | double }} - {{ rule.radii_m | double }} - {{ rule.margin_m | double }};
        spare_m = spare_m - {{ rule.reach_m | double }} - {{ rule.intrusion_m | double }} - {{ rule.uncertainty_m | double }};
        if (spare_m > 0.0) {
            speed_mps = square_root({{ rule.b_squared | double }} + {{ rule.twice_braking | double }} * spare_m) - {{ rule.b | double }};
        }
        if (speed_mps / {{ rule.nominal_mps | double }} < share) {
            share = speed_mps / {{ rule.nominal_mps | double }};
        }
    }
    return share > 0.0 ? (float)share : 0.0f;
}
