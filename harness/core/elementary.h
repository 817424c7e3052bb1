/* Angles, and functions of the library of mathematics, which rounds as it likes in the last
   place. */
#ifndef SL_ELEMENTARY_H
#define SL_ELEMENTARY_H

#include <math.h>

#define PI 3.141592653589793
#define RIGHT (PI / 2.0) /* [rad] */

static inline double sine_of(double a) { return sin(a); }
static inline double hyperbolic_sine_of(double a) { return sinh(a); }
static inline double logarithm_of(double a) { return log(a); }
static inline double hyperbolic_cosine_of(double a) { return cosh(a); }
static inline double hyperbolic_area_of(double a) { return asinh(a); }
static inline double exponential_of(double a) { return exp(a); }
static inline double angle_of(double y, double x) { return atan2(y, x); }

#endif
