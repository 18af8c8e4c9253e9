/* Notes events on the standard error, and writes the samples and, where an event changes the state, the rows before and after it. */
static void report(double *s, const double *times, const double *rows, int64_t *printed)
{
    int64_t noted = 0;
    for (int64_t k = 0; k <= (int64_t)s[AT_JUMPS]; k++) {
        const double *row = at_jumps + k * (2 * N + 2);
        const int last = k == (int64_t)s[AT_JUMPS], ends = last ? (int)s[AT_LOGGED] : (int)row[1];
        int acts = 0;
        for (; *printed <= (int64_t)s[AT_SAMPLE] && (last || times[*printed] < row[0]); ++*printed)
            print_row(times[*printed], rows + *printed * N);
        for (; noted < ends; noted++) {
            const int event = (int)at_log[2 * noted + 1];
            fprintf(stderr, "%s at t = %.17g\n", at_names[event], at_log[2 * noted]);
            acts = acts || at_kinds[event * KINDS] > 2;
        }
        if (last) break;
        print_row(row[0], row + 2);
        if (acts) print_row(row[0], row + 2 + N);
        while (*printed <= (int64_t)s[AT_SAMPLE] && times[*printed] <= row[0]) ++*printed;
    }
    s[AT_LOGGED] = s[AT_JUMPS] = 0;
}

/* The quantities of the events at the start; whether none stands at its threshold, where none is known to have passed it. */
static int begin_events(double *y, double *p, double *r, double *h)
{
    double beside[2 * EVENTS], *hoisted[] = {at_hw, at_hg, at_ht, at_ha};
    for (int k = 0; k < 4; k++) memcpy(hoisted[k], h, sizeof at_hw);
    @NAME@_events(0, y, p, r, h, at_seen);
    @NAME@_glance(0, y, p, r, h, beside);
    for (int k = 0; k < EVENTS; k++) {
        at_largest[k] = fabs(at_seen[k]);
        if (!(fabs(at_seen[k] - at_least[k]) > 16 * DBL_EPSILON * beside[EVENTS + k]) && at_kinds[k * KINDS + 2] > 0) {
            fprintf(stderr, "Expected a start beside the threshold of the event %s, got one on it.\n", at_names[k]);
            return 0;
        }
    }
    return 1;
}
