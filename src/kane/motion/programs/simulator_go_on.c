/* Steps, up to `limit`. */
int @NAME@_go_on(@NAME@_motion *m)
{
    if (m->fresh) {
        @ASK_AGAIN@
        aim(m);
    }
    @FORGET@
    const int64_t back = @CALL@;
    int said = @CAPS@_LIMIT;
    if (back == @FULL@) {
        said = @CAPS@_NOTED;
    } else if ((back == @STANDS@) || (back == @RESTS@)) {
        said = @CAPS@_UNDECIDED;
    } else if (back == @LOOK@) {
        said = @LOOKS@;
    } else if (back == @EVENT@) {
        said = @CAPS@_EVENT;
    } else if ((back == @END@) && !(m->s[AT_END] < m->end)) {
        said = @CAPS@_END;
    } else if ((back == @END@) || (back == @LIMIT@)) {
        if (back == @END@) {
            m->s[AT_TIME] = m->s[AT_END] + ((4.0 * @ULPS@.0) * spacing(m->s[AT_END]));
            m->s[AT_TIME_LAG] = 0.0;
            m->fresh = true;
        }
    } else {
        said = @CAPS@_STUCK;
    }
    return said;
}
