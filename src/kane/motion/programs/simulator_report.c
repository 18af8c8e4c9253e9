/* Notes events on the standard error, and writes the samples and, where an event changes the state, the rows before and after it. */
static void report(@NAME@_motion *m, int64_t *printed)
{
    const int64_t jumps = (int64_t)m->s[AT_JUMPS];
    const int64_t sampled = (int64_t)m->s[AT_SAMPLE] + 1;
    int64_t noted = 0;
    int64_t k = *printed;
    for (int64_t jump = 0; jump <= jumps; jump++) {
        const bool last = jump == jumps;
        const double *row = &at_jumps[last ? 0 : (jump * ((2 * N) + 2))];
        const int64_t ends = last ? (int64_t)m->s[AT_LOGGED] : (int64_t)row[1];
        bool acts = false;
        for (; (k < sampled) && (last || (m->times[k] < row[0])); k++) {
            print_row(m->times[k], &m->rows[k * N]);
        }
        for (; noted < ends; noted++) {
            const int64_t event = (int64_t)at_log[(2 * noted) + 1];
            (void)fprintf(stderr, "%s at t = %.17g\n", at_names[event], at_log[2 * noted]);
            acts = acts || (at_kinds[event * KINDS] >= @ACTS@.0);
        }
        if (!last) {
            print_row(row[0], &row[2]);
            if (acts) {
                print_row(row[0], &row[2 + N]);
            }
            for (; (k < sampled) && (m->times[k] <= row[0]); k++) {
                /* the instant of an event */
            }
        }
    }
    *printed = k;
    m->s[AT_LOGGED] = 0.0;
    m->s[AT_JUMPS] = 0.0;
}
