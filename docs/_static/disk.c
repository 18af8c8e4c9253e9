/*
 * disk: equations of motion. Made by kane 0.1.0.dev0: derive and emit again instead of editing.
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
    DISK_HOISTED = 5,
    DISK_RHS_SIZE = 10
};

/* `value` is the default of a parameter, NAN where there is none. A null pointer follows the last name. */
typedef struct {
    const char *name, *unit, *description;
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
    const double t = x * 0x1.45f306dc9c883p-1 + 6755399441055744.0;
    const double n = t - 6755399441055744.0;
    const double a = n * -0x1.921fb54440000p+0 + x;
    const double r = n * -0x1.68c234c4c0000p-39 + a;
    const double d = r - a;
    const double e = n * 0x1.68c234c4c0000p-39 + d;
    const double tail = n * 0x1.98a2e03707345p-77 + e;
    const double z = r * r;
    const double z2 = z * z;
    const double s56 = z * -0x1.5d93a5acfd57cp-33 + 0x1.ae5e68a2b9cebp-26;
    const double s34 = z * -0x1.71de357b1fe7dp-19 + 0x1.a01a019c161d5p-13;
    const double s12 = z * -0x1.111111110f8a6p-7 + 0x1.5555555555549p-3;
    const double s36 = z2 * s56 + s34;
    const double ps = z2 * s36 + s12;
    const double c56 = z * -0x1.8fae9be8838d4p-37 + 0x1.1ee9ebdb4b1c4p-29;
    const double c34 = z * -0x1.27e4f809c52adp-22 + 0x1.a01a019cb1590p-16;
    const double c12 = z * -0x1.6c16c16c15177p-10 + 0x1.555555555554cp-5;
    const double c36 = z2 * c56 + c34;
    const double pc = z2 * c36 + c12;
    const double w = z * -0.5 + 1.0;
    const double f = 1.0 - w;
    const double g = z * -0.5 + f;
    const double h = r * tail + g;
    const double i = z2 * pc + h;
    const double cosine = w + i;
    const double r3 = r * z;
    const double j = tail * w;
    const double k = r3 * ps + j;
    const double sine = r - k;
    uint64_t n_bits, s_bits, c_bits, change;
    memcpy(&n_bits, &t, sizeof t);
    memcpy(&s_bits, &sine, sizeof sine);
    memcpy(&c_bits, &cosine, sizeof cosine);
    change = ((s_bits ^ c_bits) & (0 - (n_bits & 1))) ^ ((n_bits & 2) << 62);
    s_bits ^= change;
    c_bits ^= change ^ ((n_bits & 1) << 63);
    memcpy(s, &s_bits, sizeof *s);
    memcpy(c, &c_bits, sizeof *c);
}

/* What depends on parameters alone; 7 operations. */
void disk_hoist(const double *p, double *h)
{
    const double R = p[0];
    const double m = p[1];
    const double z1 = R * m;
    const double z2 = z1 * R;
    const double z3 = 0.25 * z2;
    const double z4 = 0.5 * z2;
    const double z5 = 1.25 * z2;
    const double z6 = 1.0 / z5;
    const double z7 = 1.0 / z4;
    h[0] = z1;
    h[1] = z3;
    h[2] = z4;
    h[3] = z6;
    h[4] = z7;
}

/* rhs: 10; 198 operations. */
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
    const double m = p[1];
    const double mu_k = p[2];
    const double g = p[3];
    const double h0 = h[0];
    const double h1 = h[1];
    const double h2 = h[2];
    const double h3 = h[3];
    const double h4 = h[4];
    double z6, z1;
    kane_sincos(q2, &z6, &z1);
    const double z2 = fabs(z1) > 1.1368683772161603e-13 * 1.0 ? z1 : (double)NAN;
    const double z3 = 1.0 / z2;
    const double z4 = u2 * z3;
    const double z5 = -u1;
    const double z7 = z6 * z3;
    const double z8 = u2 * z7;
    const double z9 = z8 - u3;
    const double z10 = -z9;
    const double z11 = R * z7;
    const double z12 = m * z11;
    const double z13 = z12 * z11;
    const double z14 = z13 + h1;
    const double z15 = 1.0 / z14;
    double z16, z19;
    kane_sincos(q1, &z16, &z19);
    const double z17 = z12 * z16;
    const double z18 = z17 * z15;
    const double z20 = z19 * z12;
    const double z21 = z20 * z18;
    const double z22 = z19 * z1;
    const double z23 = h0 * z22;
    const double z24 = z23 * h3;
    const double z25 = z1 * z16;
    const double z26 = h0 * z25;
    const double z27 = z24 * z26;
    const double z28 = z21 - z27;
    const double z29 = z26 * h3;
    const double z30 = z26 * z29;
    const double z31 = z30 - m;
    const double z32 = z20 * z15;
    const double z33 = z32 * z20;
    const double z34 = z31 + z33;
    const double z35 = 1.0 / z34;
    const double z36 = z28 * z35;
    const double z37 = h0 * z6;
    const double z38 = z37 * z29;
    const double z39 = z36 * z38;
    const double z40 = z24 * z37;
    const double z41 = z39 + z40;
    const double z42 = z28 * z36;
    const double z43 = z24 * z23;
    const double z44 = z43 - m;
    const double z45 = z17 * z18;
    const double z46 = z44 + z45;
    const double z47 = z42 - z46;
    const double z48 = 1.0 / z47;
    const double z49 = z41 * z48;
    const double z50 = R * u1;
    const double z51 = z50 * u2;
    const double z52 = z1 * z1;
    const double z53 = u1 / z52;
    const double z54 = z53 * u2;
    const double z55 = R * z54;
    const double z56 = z51 + z55;
    const double z57 = m * z56;
    const double z58 = z57 * z11;
    const double z59 = h1 * u1;
    const double z60 = z8 * z59;
    const double z61 = u3 * h2;
    const double z62 = z61 * u1;
    const double z63 = z60 - z62;
    const double z64 = z58 - z63;
    const double z65 = z64 * z32;
    const double z66 = z8 * R;
    const double z67 = z66 * u2;
    const double z68 = g * z6;
    const double z69 = z68 + z67;
    const double z70 = m * z69;
    const double z71 = z70 * z25;
    const double z72 = z8 * z66;
    const double z73 = z50 * u1;
    const double z74 = z72 + z73;
    const double z75 = z1 * g;
    const double z76 = z74 - z75;
    const double z77 = z76 * m;
    const double z78 = z16 * z6;
    const double z79 = z78 * z77;
    const double z80 = z57 * z19;
    const double z81 = z79 + z80;
    const double z82 = z71 + z81;
    const double z83 = h1 * u2;
    const double z84 = z8 * z83;
    const double z85 = z61 * u2;
    const double z86 = z84 - z85;
    const double z87 = R * z70;
    const double z88 = z86 - z87;
    const double z89 = z88 * z29;
    const double z90 = z82 + z89;
    const double z91 = z65 - z90;
    const double z92 = z36 * z91;
    const double z93 = z22 * z70;
    const double z94 = z19 * z6;
    const double z95 = z77 * z94;
    const double z96 = z57 * z16;
    const double z97 = z95 - z96;
    const double z98 = z93 + z97;
    const double z99 = z24 * z88;
    const double z100 = z99 + z98;
    const double z101 = z64 * z18;
    const double z102 = z100 + z101;
    const double z103 = z92 - z102;
    const double z104 = z49 * z103;
    const double z105 = z38 * z35;
    const double z106 = z105 * z91;
    const double z107 = z37 * h3;
    const double z108 = z88 * z107;
    const double z109 = z108 + z106;
    const double z110 = z104 - z109;
    const double z111 = z1 * z77;
    const double z112 = z70 * z6;
    const double z113 = z112 - z111;
    const double z114 = z113 - z110;
    const double z115 = R * z16;
    const double z116 = z115 * z7;
    const double z117 = z116 * u2;
    const double z118 = z115 * u3;
    const double z119 = z117 - z118;
    const double z120 = z119 - u5;
    const double z121 = z120 * z120;
    const double z122 = z19 * R;
    const double z123 = z122 * z7;
    const double z124 = u2 * z123;
    const double z125 = z124 - u4;
    const double z126 = z122 * u3;
    const double z127 = z126 - z125;
    const double z128 = z127 * z127;
    const double z129 = z121 + z128;
    const double z130 = sqrt(z129);
    const double z131 = 1.0 / z130;
    const double z132 = z115 * z131;
    const double z133 = z132 * mu_k;
    const double z134 = z133 * u3;
    const double z135 = z133 * z7;
    const double z136 = u2 * z135;
    const double z137 = z134 - z136;
    const double z138 = mu_k * z131;
    const double z139 = z138 * u5;
    const double z140 = z139 + z137;
    const double z141 = z16 * z140;
    const double z142 = z138 * u4;
    const double z143 = z122 * z131;
    const double z144 = mu_k * z143;
    const double z145 = z144 * z7;
    const double z146 = u2 * z145;
    const double z147 = z142 - z146;
    const double z148 = z144 * u3;
    const double z149 = z148 + z147;
    const double z150 = z19 * z149;
    const double z151 = z141 + z150;
    const double z152 = z19 * z151;
    const double z153 = z149 * z16;
    const double z154 = z19 * z140;
    const double z155 = z153 - z154;
    const double z156 = z6 * z155;
    const double z157 = z78 * z156;
    const double z158 = z152 + z157;
    const double z159 = z1 * z155;
    const double z160 = z159 * z25;
    const double z161 = z160 + z158;
    const double z162 = z151 * z11;
    const double z163 = z32 * z162;
    const double z164 = z161 - z163;
    const double z165 = z36 * z164;
    const double z166 = z156 * z94;
    const double z167 = z16 * z151;
    const double z168 = z166 - z167;
    const double z169 = z22 * z159;
    const double z170 = z168 + z169;
    const double z171 = z162 * z18;
    const double z172 = z170 + z171;
    const double z173 = z165 + z172;
    const double z174 = z173 * z49;
    const double z175 = z105 * z164;
    const double z176 = z175 - z174;
    const double z177 = 1.0 + z176;
    const double z178 = z114 / z177;
    const double z179 = z178 * z173;
    const double z180 = z179 - z103;
    const double z181 = z180 * z48;
    const double z182 = z36 * z181;
    const double z183 = z178 * z164;
    const double z184 = z91 - z183;
    const double z185 = z184 * z35;
    const double z186 = z182 + z185;
    const double z187 = z186 * z29;
    const double z188 = z24 * z181;
    const double z189 = z88 * h3;
    const double z190 = z189 + z188;
    const double z191 = z190 + z187;
    const double z192 = z181 * z18;
    const double z193 = z178 * z162;
    const double z194 = z64 + z193;
    const double z195 = z194 * z15;
    const double z196 = z192 + z195;
    const double z197 = z32 * z186;
    const double z198 = z196 - z197;
    const double z199 = R * z151;
    const double z200 = z178 * z199;
    const double z201 = z200 * h4;
    const double z202 = -z201;
    const double z203 = -z186;
    out[0] = z4; /* q1' */
    out[1] = z5; /* q2' */
    out[2] = z10; /* q3' */
    out[3] = u4; /* q4' */
    out[4] = u5; /* q5' */
    out[5] = z191; /* u1' */
    out[6] = z198; /* u2' */
    out[7] = z202; /* u3' */
    out[8] = z203; /* u4' */
    out[9] = z181; /* u5' */
}
