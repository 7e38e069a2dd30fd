/* --- constant speed ----------------------------------------------------------------------------- */

static float rule_share(const float *observation)
{
    (void)observation;
    return {{ rule.fraction | single }};
}
