/* Parameters of the modes follow from those of the motion. */
static void spread(@NAME@_motion *m)
{
    for (int64_t k = 0; k < (KNOWN * PARAMETERS_OF); k++) {
        if (at_p_from[k] > -0.5) {
            at_ps[k] = m->p[(int64_t)at_p_from[k]];
        }
    }
}

/* What the kernel that leads from mode to mode begins with. */
static void begin_contacts(@NAME@_motion *m)
{
    spread(m);
    at_tolerances[0] = m->atol;
    at_tolerances[1] = m->rtol;
    m->enter = ENTERS;
    m->at_once = AT_ONCE;
    m->kept = -1;
    m->goes_on = false;
}

/* The mode at hand ends at a time t, with the state at hand: at the end of the motion, or where it breaks off. */
static void close_row(@NAME@_motion *m, double t)
{
    double *row = &at_records[2 + ((int64_t)at_records[0] * WIDTH)];
    row[ROW_END] = t;
    row[ROW_EVENT] = -1.0;
    row[ROW_SAMPLE] = m->s[AT_SAMPLE];
    row[ROW_NOTED] = at_records[1];
    row[ROW_OVER] = 0.0;
    for (int64_t k = 0; k < N; k++) {
        row[LAST_STATE + k] = m->y[k];
    }
    at_records[0] += 1.0;
}
