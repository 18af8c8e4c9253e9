/* No event sets the state. */
static status act_on(unit *i, const bool *there, const double *before, bool *changed, bool *ends)
{
    (void)i;
    (void)there;
    (void)before;
    (void)changed;
    (void)ends;
    return DONE;
}

