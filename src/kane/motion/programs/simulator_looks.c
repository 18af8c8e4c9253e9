/*
 * Whether the kernel is to go on where it has asked: a step is taken at whose end dependent speeds hardly follow; one that may have led
 * where they do not follow is taken again, half as long.
 */
static bool goes_on(@NAME@_motion *m)
{
    const double shortest = m->s[AT_SHORTEST] + (@TEN_ROUNDINGS@ * fabs(m->s[AT_TIME]));
    const double left = (m->s[AT_END] - m->s[AT_TIME]) - m->s[AT_TIME_LAG];
    const double half = 0.5 * fmin(fmin(fmax(m->s[AT_STEP], shortest), m->s[AT_LONGEST]), left);
    const bool asked = (m->s[AT_HELD] > 0.0) && !(m->s[AT_LOOKED] > 0.0);
    const bool poorer = asked && (m->s[AT_HELD] == @POORER@) && (m->s[AT_SHARE] <= @UNUSABLE@);
    const bool shorter = asked && !poorer && (half > (@SAME_TIME@ * fmax(fabs(m->s[AT_TIME]), m->s[AT_SPAN])));
    if (poorer) {
        m->s[AT_LOOKED] = 1.0;
    }
    if (shorter) {
        m->s[AT_STEP] = half;
    }
    return poorer || shorter;
}

