/* The beginnings, tops and ends of pulses in values at times from the start to the end; `sorted` is room for as many. */
static void add_pulses(@NAME@_motion *m, double *values, double *sorted)
{
    double largest = 0.0;
    int64_t there = 0;
    int64_t runs = 0;
    for (int64_t i = 0; i < PLACES; i++) {
        if (!isfinite(values[i])) {
            return;
        }
        sorted[i] = values[i];
    }
    sort(sorted, PLACES);
    const double middle = sorted[PLACES / 2];
    for (int64_t i = 0; i < PLACES; i++) {
        values[i] = fabs(values[i] - middle);
        largest = fmax(largest, values[i]);
    }
    const double rise = @RISEN@ * largest;
    for (int64_t i = 0; i < PLACES; i++) {
        const bool risen = values[i] > rise;
        const bool before = (i > 0) && (values[(i > 0) ? (i - 1) : 0] > rise);
        there += risen ? 1 : 0;
        runs += (risen && !before) ? 1 : 0;
    }
    if (((double)there > (@SHARE@ * (double)PLACES)) || (runs > MOST_PULSES)) {
        return;
    }
    const int64_t parts = PLACES - 1;
    const double step = (m->end - m->start) / (double)parts;
    int64_t top = -1;
    for (int64_t i = 0; i < PLACES; i++) {
        const bool risen = values[i] > rise;
        const bool ends = (i + 1) == PLACES;
        if (risen && (top < 0)) {
            const int64_t before_it = (i > 0) ? (i - 1) : 0;
            add_stop(m, m->start + ((double)before_it * step));
            top = i;
        }
        if (risen && (values[i] > values[(top < 0) ? i : top])) {
            top = i;
        }
        if ((top >= 0) && (!risen || ends)) {
            add_stop(m, m->start + ((double)top * step));
            add_stop(m, m->start + ((double)i * step));
            top = -1;
        }
    }
}

