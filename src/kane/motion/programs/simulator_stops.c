/* Adds a time, if it lies within the motion. */
static void add_stop(@NAME@_motion *m, double t)
{
    if ((t > m->start) && (t < m->end) && (m->stop_count < STOPS)) {
        m->stops[m->stop_count] = t;
        m->stop_count++;
    }
}

/* One number of a heap of `count` sinks to its place. */
static void sink(double *values, int64_t at, int64_t count)
{
    int64_t i = at;
    for (int64_t turn = 0; turn < count; turn++) {
        int64_t larger = (2 * i) + 1;
        if ((larger + 1) < count) {
            larger += (values[larger] < values[larger + 1]) ? 1 : 0;
        }
        if ((larger >= count) || (values[larger] <= values[i])) {
            break;
        }
        const double value = values[i];
        values[i] = values[larger];
        values[larger] = value;
        i = larger;
    }
}

/* Numbers in order. */
static void sort(double *values, int64_t count)
{
    for (int64_t k = count / 2; k > 0; k--) {
        sink(values, k - 1, count);
    }
    for (int64_t k = count - 1; k > 0; k--) {
        const double largest = values[0];
        values[0] = values[k];
        values[k] = largest;
        sink(values, 0, k);
    }
}

@FIND_LEVELS@@FIND_PULSES@/* The times at which steps end, in order. */
static void find_stops(@NAME@_motion *m)
{
    @STOPS_BY_LEVELS@
    @STOPS_BY_PULSES@
    sort(m->stops, m->stop_count);
}

