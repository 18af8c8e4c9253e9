/*
 * disk: equations of motion. Made by kane 0.2.0: derive and emit again instead of editing.
 *
 * Compile:  cc -std=c99 -O2 -fno-math-errno -c disk.c   and link with -lm
 *           Options such as -march=native -ffp-contract=fast give fused multiply-adds: faster, other last digits.
 * Call:     disk_hoist(p, h) once for each set of parameters, with double h[DISK_HOISTED]; then
 *           disk_rhs(t, x, p, r, h, out) with double out[DISK_RHS_SIZE]
 *           for time t, state x, parameters p, inputs r. A pointer to no elements may be null; out overlaps none of
 *           the others. Nothing is kept between calls: threads may call at the same time.
 *
 * A result is NaN where what it is divided by is zero, but for rounding, beside the terms that it is made of:
 *   the rates, which W of q' = W u + X gives divided by cos(q2)
 *
 * t       t, s: time
 *
 * x[0]    q1, rad: yaw
 * x[1]    q2, rad: lean
 * x[2]    q3, rad: spin
 * x[3]    q4, m: contact, along x
 * x[4]    q5, m: contact, along y
 * x[5]    u1, rad/s
 * x[6]    u2, rad/s
 * x[7]    u3, rad/s
 * x[8]    u4, m/s
 * x[9]    u5, m/s
 *
 * p[0]    R, m: radius
 * p[1]    m, kg: mass of the disk
 * p[2]    mu_k, 1: coefficient of sliding friction
 * p[3]    g, m/s^2: acceleration of free fall
 *
 */

#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__) \
    || defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__)
#error "Compile without -ffast-math, -Ofast and the like: infinity, NaN and the order of operations matter here."
#endif
#include <math.h>
#include <stdint.h>
#include <string.h>

#ifdef __cplusplus
extern "C" {
#endif

enum {
    DISK_PARAMETERS = 4,
    DISK_STATES = 10,
    DISK_INPUTS = 0,
    DISK_HOISTED = 1,
    DISK_RHS_SIZE = 10
};

/* `value` is the default of a parameter, NAN where there is none. A null pointer follows the last name. */
typedef struct {
    const char *name;
    const char *unit;
    const char *description;
    double value;
} disk_quantity;
extern const disk_quantity disk_parameters[DISK_PARAMETERS + 1];
extern const disk_quantity disk_state[DISK_STATES + 1];
extern const disk_quantity disk_inputs[DISK_INPUTS + 1];
extern const char *const disk_rhs_labels[DISK_RHS_SIZE + 1];

/* A result is NaN where what it is divided by is zero, but for rounding, beside the terms that it is made of: */
/* the rates, which W of q' = W u + X gives divided by cos(q2) */
void disk_hoist(const double *p, double *h);
void disk_rhs(double t, const double *x, const double *p, const double *r, const double *h, double *out);

#ifdef __cplusplus
}
#endif

const disk_quantity disk_parameters[DISK_PARAMETERS + 1] = {
    {"R", "m", "radius", 0.3},
    {"m", "kg", "mass of the disk", 1.2},
    {"mu_k", "1", "coefficient of sliding friction", 0.25},
    {"g", "m/s^2", "acceleration of free fall", 9.81},
    {0, 0, 0, NAN}
};
const disk_quantity disk_state[DISK_STATES + 1] = {
    {"q1", "rad", "yaw", NAN},
    {"q2", "rad", "lean", NAN},
    {"q3", "rad", "spin", NAN},
    {"q4", "m", "contact, along x", NAN},
    {"q5", "m", "contact, along y", NAN},
    {"u1", "rad/s", "", NAN},
    {"u2", "rad/s", "", NAN},
    {"u3", "rad/s", "", NAN},
    {"u4", "m/s", "", NAN},
    {"u5", "m/s", "", NAN},
    {0, 0, 0, NAN}
};
const disk_quantity disk_inputs[DISK_INPUTS + 1] = {
    {0, 0, 0, NAN}
};
const char *const disk_rhs_labels[DISK_RHS_SIZE + 1] = {
    "q1'",
    "q2'",
    "q3'",
    "q4'",
    "q5'",
    "u1'",
    "u2'",
    "u3'",
    "u4'",
    "u5'",
    0
};

/* Sine and cosine of x, below 1 ulp for |x| <= 262144; the library's beyond. */
static void kane_sincos(double x, double *s, double *c)
{
    if (!(fabs(x) <= 262144.0)) {
        *s = sin(x);
        *c = cos(x);
        return;
    }
    const double t = (x * 0x1.45f306dc9c883p-1) + 6755399441055744.0;
    const double n = t - 6755399441055744.0;
    const double a = (n * -0x1.921fb54440000p+0) + x;
    const double r = (n * -0x1.68c234c4c0000p-39) + a;
    const double d = r - a;
    const double e = (n * 0x1.68c234c4c0000p-39) + d;
    const double tail = (n * 0x1.98a2e03707345p-77) + e;
    const double z = r * r;
    const double z2 = z * z;
    const double s56 = (z * -0x1.5d93a5acfd57cp-33) + 0x1.ae5e68a2b9cebp-26;
    const double s34 = (z * -0x1.71de357b1fe7dp-19) + 0x1.a01a019c161d5p-13;
    const double s12 = (z * -0x1.111111110f8a6p-7) + 0x1.5555555555549p-3;
    const double s36 = (z2 * s56) + s34;
    const double ps = (z2 * s36) + s12;
    const double c56 = (z * -0x1.8fae9be8838d4p-37) + 0x1.1ee9ebdb4b1c4p-29;
    const double c34 = (z * -0x1.27e4f809c52adp-22) + 0x1.a01a019cb1590p-16;
    const double c12 = (z * -0x1.6c16c16c15177p-10) + 0x1.555555555554cp-5;
    const double c36 = (z2 * c56) + c34;
    const double pc = (z2 * c36) + c12;
    const double w = (z * -0.5) + 1.0;
    const double f = 1.0 - w;
    const double g = (z * -0.5) + f;
    const double h = (r * tail) + g;
    const double i = (z2 * pc) + h;
    const double cosine = w + i;
    const double r3 = r * z;
    const double j = tail * w;
    const double k = (r3 * ps) + j;
    const double sine = r - k;
    uint64_t n_bits;
    uint64_t s_bits;
    uint64_t c_bits;
    (void)memcpy((unsigned char *)&n_bits, (const unsigned char *)&t, sizeof t);
    (void)memcpy((unsigned char *)&s_bits, (const unsigned char *)&sine, sizeof sine);
    (void)memcpy((unsigned char *)&c_bits, (const unsigned char *)&cosine, sizeof cosine);
    const uint64_t odd = n_bits & UINT64_C(1);
    const uint64_t mask = (~odd) + UINT64_C(1);
    const uint64_t flip = (n_bits & UINT64_C(2)) << 62U;
    const uint64_t change = ((s_bits ^ c_bits) & mask) ^ flip;
    s_bits ^= change;
    c_bits ^= change ^ (odd << 63U);
    (void)memcpy((unsigned char *)s, (const unsigned char *)&s_bits, sizeof *s);
    (void)memcpy((unsigned char *)c, (const unsigned char *)&c_bits, sizeof *c);
}

/* What depends on parameters alone; 1 operations. */
void disk_hoist(const double *p, double *h)
{
    const double R = p[0];
    const double g = p[3];
    const double z1 = g / R;
    h[0] = z1;
}

/* rhs: 10; 78 operations. */
void disk_rhs(double t, const double *x, const double *p, const double *r, const double *h, double *out)
{
    (void)t;
    (void)r;
    const double q1 = x[0];
    const double q2 = x[1];
    const double u1 = x[5];
    const double u2 = x[6];
    const double u3 = x[7];
    const double u4 = x[8];
    const double u5 = x[9];
    const double R = p[0];
    const double mu_k = p[2];
    const double h0 = h[0];
    double z6;
    double z1;
    kane_sincos(q2, &z6, &z1);
    const double z2 = (fabs(z1) > (1.1368683772161603e-13 * 1.0)) ? z1 : (double)NAN;
    const double z3 = 1.0 / z2;
    const double z4 = u2 * z3;
    const double z5 = -u1;
    const double z7 = z3 * z6;
    const double z8 = u2 * z7;
    const double z9 = u3 - z8;
    const double z10 = R * z9;
    double z11;
    double z15;
    kane_sincos(q1, &z11, &z15);
    const double z12 = z11 * z10;
    const double z13 = u5 + z12;
    const double z14 = z13 * z13;
    const double z16 = z15 * z10;
    const double z17 = u4 + z16;
    const double z18 = z17 * z17;
    const double z19 = z14 + z18;
    const double z20 = sqrt(z19);
    const double z21 = mu_k / z20;
    const double z22 = z17 * z21;
    const double z23 = z11 * z22;
    const double z24 = z13 * z21;
    const double z25 = z15 * z24;
    const double z26 = z23 - z25;
    const double z27 = z1 * z26;
    const double z28 = z6 * z6;
    const double z29 = 0.25 + z28;
    const double z30 = 1.0 / z29;
    const double z31 = z6 * z30;
    const double z32 = z27 * z31;
    const double z33 = 1.0 - z32;
    const double z34 = u2 * z8;
    const double z35 = 0.25 * z34;
    const double z36 = u1 * u1;
    const double z37 = z1 * z36;
    const double z38 = h0 - z37;
    const double z39 = z6 * z38;
    const double z40 = 0.5 * u2;
    const double z41 = z40 * u3;
    const double z42 = z41 + z39;
    const double z43 = z42 - z35;
    const double z44 = z43 * z31;
    const double z45 = z38 - z44;
    const double z46 = z45 / z33;
    const double z47 = z27 * z46;
    const double z48 = z43 - z47;
    const double z49 = z30 * z48;
    const double z50 = -z49;
    const double z51 = u3 + z9;
    const double z52 = u1 * z51;
    const double z53 = z11 * z24;
    const double z54 = z15 * z22;
    const double z55 = z53 + z54;
    const double z56 = 2.0 * z55;
    const double z57 = z56 * z46;
    const double z58 = -z57;
    const double z59 = z34 - z49;
    const double z60 = z1 * z59;
    const double z61 = z8 * z8;
    const double z62 = z61 + z36;
    const double z63 = z6 * z62;
    const double z64 = z60 + z63;
    const double z65 = z11 * z64;
    const double z66 = z22 * z46;
    const double z67 = z7 * z52;
    const double z68 = u1 * u2;
    const double z69 = z3 * z68;
    const double z70 = z69 * z3;
    const double z71 = z70 + z68;
    const double z72 = z71 - z67;
    const double z73 = z15 * z72;
    const double z74 = z73 + z66;
    const double z75 = z74 + z65;
    const double z76 = R * z75;
    const double z77 = -z76;
    const double z78 = z15 * z64;
    const double z79 = z24 * z46;
    const double z80 = z11 * z72;
    const double z81 = z80 + z79;
    const double z82 = z81 - z78;
    const double z83 = R * z82;
    const double z84 = -z83;
    out[0] = z4; /* q1' */
    out[1] = z5; /* q2' */
    out[2] = z9; /* q3' */
    out[3] = u4; /* q4' */
    out[4] = u5; /* q5' */
    out[5] = z50; /* u1' */
    out[6] = z52; /* u2' */
    out[7] = z58; /* u3' */
    out[8] = z77; /* u4' */
    out[9] = z84; /* u5' */
}
