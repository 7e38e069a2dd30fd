/* --- the fuzzy strategy ------------------------------------------------------------------------- */

/* Terms: centre, width left, width right; a width of 0 is a shoulder, on which membership is 1. */
static const double distance_terms[{{ rule.distance | length }}][3] = {
{% for row in rule.distance %}
    { {{ row | map("double") | join(", ") }} },
{% endfor %}
};
static const double speed_terms[{{ rule.speed | length }}][3] = {
{% for row in rule.speed %}
    { {{ row | map("double") | join(", ") }} },
{% endfor %}
};
/* Rules: distance term, speed term, pattern, and the share of the nominal speed that is kept. */
static const unsigned char premises[{{ rule.rules | length }}][3] = {
{% for row in rule.rules %}
    { {{ row[0] }}, {{ row[1] }}, {{ row[2] }} },
{% endfor %}
};
{{ doubles("kept_share", rule.kept) }}
/* Person fields: present, distance, speed, cosine of the bearing, closing speed, patterns. */
static const unsigned {{ entry }} person_entries[{{ rule.entries | length }}][{{ rule.entries[0] | length }}] = {
{% for row in rule.entries %}
    { {{ row | join(", ") }} },
{% endfor %}
};
{{ doubles("person_scales", rule.units) }}
static double gauss(double x, double centre, double width)
{
    double z = width == 0.0 ? 0.0 : (x - centre) / width;
    return exp_of_negative(-0.5 * z * z);
}

static double membership(double x, const double term[3])
{
    return gauss(x, term[0], x < term[0] ? term[1] : term[2]);
}

/* Equation 9 of the paper: the mean of the rules' shares, weighted by their premises. */
static double kept_fraction(double distance_m, double speed_mps, int pattern)
{
    double near[{{ rule.distance | length }}], fast[{{ rule.speed | length }}];
    double sum = 0.0, sum_kept = 0.0;
    int i, j;
    if (distance_m <= {{ rule.sensitive_m | double }}) {
        return 0.0;
    }
    if (distance_m > {{ rule.avoidance_m | double }} || pattern < 0) {
        return 1.0;
    }
    for (i = 0; i < {{ rule.distance | length }}; i++) {
        near[i] = membership(distance_m, distance_terms[i]);
    }
    for (i = 0; i < {{ rule.speed | length }}; i++) {
        fast[i] = membership(speed_mps, speed_terms[i]);
    }
    for (j = 0; j < {{ rule.rules | length }}; j++) {
        double m1 = near[premises[j][0]], m2 = fast[premises[j][1]];
{% if rule.pattern_width %}
        double m3 = gauss((double)pattern, (double)premises[j][2], {{ rule.pattern_width | double }});
{% else %}
        double m3 = premises[j][2] == pattern ? 1.0 : 0.0;
{% endif %}
{% if rule.is_product %}
        double w = m1 * m2 * m3;
{% else %}
        double w = m1 < m2 ? m1 : m2;
        w = w < m3 ? w : m3;
{% endif %}
        sum += w;
        sum_kept += w * kept_share[j];
    }
    return sum >= {{ rule.no_rule_weight | double }} ? sum_kept / sum : 1.0;
}

/* The smallest share over all people. */
static float rule_share(const float *observation)
{
    double kept = 1.0;
    int i, k;
    for (i = 0; i < {{ rule.entries | length }}; i++) {
        const unsigned {{ entry }} *at = person_entries[i];
        double away_m = (double)observation[at[1]] * person_scales[1] / {{ rule.scale | double }};
        double speed_mps = (double)observation[at[2]] * person_scales[2];
        double share;
        int pattern = -1;
        if (!((double)observation[at[0]] > 0.5)) {
            continue;
        }
{% if rule.release %}
        if (observation[at[3]] < 0.0f && observation[at[4]] < 0.0f && away_m > {{ rule.released_m | double }}) {
            continue;
        }
{% endif %}
        for (k = {{ rule.patterns }} - 1; k >= 0; k--) {
            pattern = observation[at[5 + k]] > 0.5f ? k : pattern;
        }
{% if rule.horizon_s %}
        away_m = away_m - (double)observation[{{ rule.own_speed }}] * {{ rule.own_speed_scale | double }} * {{ rule.horizon_s | double }} / {{ rule.scale | double }};
{% endif %}
        share = kept_fraction(away_m, speed_mps, pattern);
        kept = share < kept ? share : kept;
    }
    return (float)kept;
}
