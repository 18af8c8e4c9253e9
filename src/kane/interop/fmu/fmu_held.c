enum { MEASURED = 40, CHOSEN = @CHOSEN@, CHOICES = @CHOICES@ };

/* The constraints at the state: what is left of the coordinates' and of the speeds', A (ROWS x SPEEDS) and W (COORDINATES x SPEEDS). */
typedef struct {
    double left[CLOSURES + 1];
    double size[CLOSURES + 1];
    double rate[ROWS + 1];
    double a[(ROWS * SPEEDS) + 1];
    double w[(COORDINATES * SPEEDS) + 1];
} closings;

static void look_at(const unit *i, closings *c)
{
    const @NAME@_motion *m = &i->now.m;
    double out[@HOLDING@];
    (void)memset(c, 0, sizeof *c);
    @NAME@_holding(beside(i), m->y, m->p, m->r, m->h, out);
    const double *entry = &out[(2 * CLOSURES) + ROWS + BRANCHES];
    for (int64_t k = 0; k < CLOSURES; k++) {
        c->left[k] = out[k];
        c->size[k] = out[CLOSURES + k];
    }
    for (int64_t e = 0; e < ENTRIES; e++) {
        c->a[((int64_t)at_held_entry_at[(3 * e) + 1] * SPEEDS) + (int64_t)at_held_entry_at[(3 * e) + 2]] = entry[e];
    }
    for (int64_t e = 0; e < @TURNS@; e++) {
        c->w[((int64_t)at_held_turn_at[2 * e] * SPEEDS) + (int64_t)at_held_turn_at[(2 * e) + 1]] = entry[ENTRIES + e];
    }
    for (int64_t k = 0; k < ROWS; k++) {
        c->rate[k] = out[(2 * CLOSURES) + k];
        for (int64_t j = 0; j < SPEEDS; j++) {
            c->rate[k] += c->a[(k * SPEEDS) + j] * m->y[COORDINATES + j];
        }
    }
}

/* Solves a x = b of n equations in place, with pivots; the least pivot over the largest, 0 where there is none. */
static double solve(double *a, double *b, int64_t n)
{
    double least = (double)INFINITY;
    double most = 0.0;
    for (int64_t k = 0; k < n; k++) {
        int64_t best = k;
        for (int64_t r = k + 1; r < n; r++) {
            best = (fabs(a[(r * n) + k]) > fabs(a[(best * n) + k])) ? r : best;
        }
        const double pivot = a[(best * n) + k];
        least = fmin(least, fabs(pivot));
        most = fmax(most, fabs(pivot));
        if (!(fabs(pivot) > 0.0)) {
            return 0.0;
        }
        for (int64_t j = 0; j < n; j++) {
            const double kept = a[(k * n) + j];
            a[(k * n) + j] = a[(best * n) + j];
            a[(best * n) + j] = kept;
        }
        const double right = b[k];
        b[k] = b[best];
        b[best] = right;
        for (int64_t r = k + 1; r < n; r++) {
            const double share = a[(r * n) + k] / pivot;
            for (int64_t j = k; j < n; j++) {
                a[(r * n) + j] -= share * a[(k * n) + j];
            }
            b[r] -= share * b[k];
        }
    }
    for (int64_t k = n - 1; k >= 0; k--) {
        for (int64_t j = k + 1; j < n; j++) {
            b[k] -= a[(k * n) + j] * b[j];
        }
        b[k] /= a[(k * n) + k];
    }
    return (n > 0) ? (least / most) : 1.0;
}

/* The entries of A of the chosen rows and of the dependent speeds of a choice. */
static void square(const closings *c, const double *dependent, double *a)
{
    for (int64_t k = 0; k < CHOSEN; k++) {
        for (int64_t j = 0; j < CHOSEN; j++) {
            a[(k * CHOSEN) + j] = c->a[((int64_t)at_held_chosen_at[k] * SPEEDS) + (int64_t)dependent[j]];
        }
    }
}

/* The least changes of the free speeds that give the first n of the chosen rows these values; whether there are some. */
static bool least(const closings *c, int64_t n, const double *right, const bool *may, double *out)
{
    double a[(CHOSEN * CHOSEN) + 1];
    double grown[CHOSEN + 1];
    for (int64_t k = 0; k < n; k++) {
        const double *row = &c->a[(int64_t)at_held_chosen_at[k] * SPEEDS];
        for (int64_t l = 0; l < n; l++) {
            const double *other = &c->a[(int64_t)at_held_chosen_at[l] * SPEEDS];
            a[(k * n) + l] = 0.0;
            for (int64_t j = 0; j < SPEEDS; j++) {
                a[(k * n) + l] += may[j] ? (row[j] * other[j]) : 0.0;
            }
        }
        grown[k] = right[k];
    }
    const bool fine = solve(a, grown, n) > 1e-14;
    for (int64_t j = 0; j < SPEEDS; j++) {
        out[j] = 0.0;
        for (int64_t k = 0; (k < n) && fine && may[j]; k++) {
            out[j] += c->a[((int64_t)at_held_chosen_at[k] * SPEEDS) + j] * grown[k];
        }
    }
    return fine;
}

/* The choice of dependent speeds that follow best; the present one unless another is ten times as good. */
static void choose(unit *i)
{
    @NAME@_motion *m = &i->now.m;
    closings c;
    double a[(CHOSEN * CHOSEN) + 1];
    double b[CHOSEN + 1];
    double quality[CHOICES + 1];
    int64_t best = (int64_t)m->p[@CAPS@_PARAMETERS];
    const int64_t own = best;
    if (CHOICES < 2) {
        return;
    }
    look_at(i, &c);
    for (int64_t k = 0; k < CHOICES; k++) {
        for (int64_t j = 0; j < CHOSEN; j++) {
            b[j] = 0.0;
        }
        square(&c, &at_held_dependent[k * CHOSEN], a);
        quality[k] = solve(a, b, CHOSEN);
    }
    for (int64_t k = 0; k < CHOICES; k++) {
        best = (quality[k] > quality[best]) ? k : best;
    }
    if (quality[best] > (10.0 * quality[own])) {
        m->p[@CAPS@_PARAMETERS] = (double)best;
    }
}

/* Euler parameters of unit length. */
static void normalize(unit *i)
{
    @NAME@_motion *m = &i->now.m;
    for (int64_t s = 0; s < @SPHERES@; s++) {
        double square_sum = 0.0;
        for (int64_t k = 0; k < 4; k++) {
            const double e = m->y[(int64_t)at_held_sphere_at[(4 * s) + k]];
            square_sum += e * e;
        }
        for (int64_t k = 0; (k < 4) && (square_sum > 0.0); k++) {
            m->y[(int64_t)at_held_sphere_at[(4 * s) + k]] /= sqrt(square_sum);
        }
    }
}

/* How far the state is off the constraints, over what counts as met at the start. */
static double off(const closings *c, const @NAME@_motion *m)
{
    double most = 0.0;
    double fastest = 0.0;
    for (int64_t j = 0; j < SPEEDS; j++) {
        fastest = fmax(fastest, fabs(m->y[COORDINATES + j]));
    }
    for (int64_t k = 0; k < CLOSURES; k++) {
        most = fmax(most, fabs(c->left[k]) / fmax(c->size[k], 1e-300));
    }
    for (int64_t k = 0; k < ROWS; k++) {
        double speeds = fabs(c->rate[k]);
        for (int64_t j = 0; j < SPEEDS; j++) {
            speeds += fabs(c->a[(k * SPEEDS) + j]) * fastest;
        }
        most = fmax(most, (speeds > 0.0) ? (fabs(c->rate[k]) / speeds) : 0.0);
    }
    return most;
}

/* The state moved onto the constraints by Newton's steps, along those speeds that may change; whether constraints are met. */
static bool onto(unit *i, const bool *may_turn, const bool *may_change)
{
    @NAME@_motion *m = &i->now.m;
    closings c;
    double right[CHOSEN + 1];
    double change[SPEEDS + 1];
    double before = (double)INFINITY;
    int64_t closed = 0;
    for (int64_t k = 0; k < CHOSEN; k++) {
        closed += ((int64_t)at_held_chosen_at[k] < CLOSURES) ? 1 : 0;
    }
    normalize(i);
    for (int turn = 0; turn < MEASURED; turn++) {
        double most = 0.0;
        look_at(i, &c);
        for (int64_t k = 0; k < CLOSURES; k++) {
            most = fmax(most, fabs(c.left[k]) / fmax(c.size[k], 1e-300));
        }
        if (!(most > 0.0) || ((most < 1e-12) && (most >= (0.5 * before)))) {
            break;
        }
        before = most;
        for (int64_t k = 0; k < closed; k++) {
            right[k] = -c.left[(int64_t)at_held_chosen_at[k]];
        }
        if (!least(&c, closed, right, may_turn, change)) {
            break;
        }
        for (int64_t q = 0; q < COORDINATES; q++) {
            for (int64_t j = 0; j < SPEEDS; j++) {
                m->y[q] += c.w[(q * SPEEDS) + j] * change[j];
            }
        }
        normalize(i);
    }
    look_at(i, &c);
    for (int64_t k = 0; k < CHOSEN; k++) {
        right[k] = -c.rate[(int64_t)at_held_chosen_at[k]];
    }
    if (least(&c, CHOSEN, right, may_change, change)) {
        for (int64_t j = 0; j < SPEEDS; j++) {
            m->y[COORDINATES + j] += change[j];
        }
    }
    look_at(i, &c);
    return off(&c, m) <= 1e-9;
}

/*
 * Start values meet the constraints: what was not set follows from what was. First the dependent ones are solved for, then all that were
 * not set, then the dependent ones even if they were set, which a warning says.
 */
static bool assembled(unit *i)
{
    @NAME@_motion *m = &i->now.m;
    bool may_turn[SPEEDS + 1];
    bool may_change[SPEEDS + 1];
    double start[N];
    bool fine = false;
    closings c;
    (void)memcpy(start, m->y, sizeof start);
    normalize(i);
    look_at(i, &c);
    if (off(&c, m) <= 1e-12) {
        return true;
    }
    for (int level = 0; (level < 3) && !fine; level++) {
        for (int64_t j = 0; j < SPEEDS; j++) {
            bool follows = level == 1;
            bool set = false;
            for (int64_t k = 0; k < CHOSEN; k++) {
                follows = follows || ((int64_t)at_held_dependent[k] == j);
            }
            for (int64_t q = 0; q < COORDINATES; q++) {
                set = set || (i->now.touched[q] && (c.w[(q * SPEEDS) + j] != 0.0));
            }
            may_turn[j] = follows && (!set || (level == 2));
            may_change[j] = follows && (!i->now.touched[COORDINATES + j] || (level == 2));
        }
        (void)memcpy(m->y, start, sizeof start);
        fine = onto(i, may_turn, may_change);
        if (fine && (level == 2)) {
            (void)told(i, WARNING, "logStatusWarning", "Start values that were set contradict the constraints: dependent ones were changed.");
        }
    }
    return fine || (failed(i, "Start values that meet the constraints were not found from these: give others, or better guesses."), false);
}

/* Whether an importer's integrator has left the constraints. */
static bool is_off(const unit *i)
{
    closings c;
    look_at(i, &c);
    double length = 0.0;
    for (int64_t s = 0; s < @SPHERES@; s++) {
        double square_sum = 0.0;
        for (int64_t k = 0; k < 4; k++) {
            const double e = i->now.m.y[(int64_t)at_held_sphere_at[(4 * s) + k]];
            square_sum += e * e;
        }
        length = fmax(length, fabs(square_sum - 1.0));
    }
    return fmax(off(&c, &i->now.m), length) > @DRIFT@;
}

/* The state is moved back onto the constraints at an event, where it left them. */
static bool moved_back(unit *i)
{
    bool all[SPEEDS + 1];
    for (int64_t j = 0; j < (SPEEDS + 1); j++) {
        all[j] = true;
    }
    return is_off(i) && onto(i, all, all);
}
