@GOES_ON@@OPEN@/* What is known of the constraints at the start. */
static int begin_constraints(@NAME@_motion *m)
{
    for (int64_t e = 0; e < ENTRIES; e++) {
        at_held_reach[e] = 0.0;
    }
    m->p[@CAPS@_PARAMETERS] = 0.0;
    at_held_log[0] = 0.0;
    return begin_on_constraints(m);
}
