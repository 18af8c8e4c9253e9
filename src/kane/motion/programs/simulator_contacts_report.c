/* What each contact does from a time on, on the standard error. */
static void tell_mode(double t, int64_t mode)
{
    (void)fprintf(stderr, "at t = %.17g", t);
    for (int64_t k = 0; k < CONTACTS; k++) {
        (void)fprintf(stderr, "%s %s: %s", (k > 0) ? "," : ":", at_contacts[k], at_words[k][at_digits[mode][k]]);
    }
    (void)fprintf(stderr, "\n");
}

/* Notes modes and events on the standard error, and writes the rows at both ends of each mode and the samples between them. */
static void report(const @NAME@_motion *m, int64_t *printed)
{
    int64_t noted = 0;
    for (int64_t i = 0; i < (int64_t)at_records[0]; i++) {
        const double *row = &at_records[2 + (i * WIDTH)];
        const int64_t mode = (int64_t)row[ROW_MODE];
        const int64_t samples = (int64_t)row[ROW_SAMPLE];
        if ((i > 0) || !m->goes_on) {
            tell_mode(row[ROW_BEGIN], mode);
            print_row(row[ROW_BEGIN], &row[FIRST_STATE]);
        }
        for (int64_t k = (int64_t)row[ROW_FIRST_SAMPLE] + 1; k <= samples; k++) {
            if ((m->times[k] > row[ROW_BEGIN]) && (m->times[k] < row[ROW_END])) {
                print_row(m->times[k], &m->rows[k * N]);
            }
        }
        for (; noted < (int64_t)row[ROW_NOTED]; noted++) {
            (void)fprintf(stderr, "%s at t = %.17g\n", at_names[mode][(int64_t)at_noted[(2 * noted) + 1]], at_noted[2 * noted]);
        }
        if ((row[ROW_EVENT] >= 0.0) || !(row[ROW_END] < m->end)) {
            print_row(row[ROW_END], &row[LAST_STATE]);
        }
        if (row[ROW_OVER] > row[ROW_END]) {
            (void)fprintf(stderr, "rebounds are over at t = %.17g\n", row[ROW_OVER]);
        }
    }
    *printed = (int64_t)m->s[AT_SAMPLE];
}
