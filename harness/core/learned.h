/* Numbers that learned methods judge by: features of every step of a layout, the ranges that
   networks were trained on, and the layers of a network.

   A layout of J boxes is given as in steadyload.h. Row j of what is filled depends on boxes 0 to j
   alone. Matrices are row by row; those of a network are of float. */
#ifndef STEADYLOAD_LEARNED_H
#define STEADYLOAD_LEARNED_H

#include "internal.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The state of a box under what stands on it. Angles are in degrees, 0 to 90; 90 where nothing is
   in the way, and for side and catch of a box that does not tip. */
enum sl_state {
    SL_SHARE,      /* supported share of the base; 1 on the floor */
    SL_SUPPORTERS, /* patches that it stands on; 0 on the floor */
    SL_MARGIN,     /* [cm] of the resultant from the border of the support; 500 on the floor */
    SL_RELATIVE,   /* margin over the shorter horizontal side; 1 on the floor */
    SL_DROP,       /* [cm] free height below a box that nothing supports */
    SL_FREE,       /* angle that it tips by in the time of a label, were there nothing in its way */
    SL_TOUCH,      /* angle at which it first meets something below */
    SL_SIDE,       /* angle at which it meets a box at its side */
    SL_CATCH,      /* angle at which what it met below holds it */
    SL_ANGLE,      /* the lesser of free and catch */
    SL_WAY,        /* [cm] of the corner that gets furthest, the drop included */
    SL_EXCESS,     /* of the greater of angle and way above 10, in halves, -3 to 3 */
    SL_HELD,       /* the lesser of angle and side; 0 where it does not tip */
    SL_TALL,       /* [cm] its height */
    SL_LEVER,      /* [cm] of the resultant about the edge that it tips over */
    SL_LOAD,       /* weight carried over own weight */
    SL_SHORTER,    /* [cm] shorter horizontal side */
    SL_STATE       /* number of these */
};

/* Columns of support: of box j itself, then of the box in the greatest danger among those that step
   j reaches, then over all of these. */
enum sl_column {
    SL_ON_FLOOR,                              /* 1, else 0 */
    SL_OWN,                                   /* its state */
    SL_HEIGHT = SL_OWN + SL_STATE,            /* [cm] of the base above the floor */
    SL_WEIGHT,                                /* over that of the boxes below it; 1 without any */
    SL_MASS_HEIGHT,                           /* of the centre of mass, in shares of its height */
    SL_WORST,                                 /* state of the worst */
    SL_WORST_HEIGHT = SL_WORST + SL_STATE,    /* [cm] */
    SL_LEAST_MARGIN,                          /* [cm] */
    SL_BELOW,                                 /* boxes that carry it */
    SL_UNBALANCED,                            /* boxes with a margin below 0 */
    SL_MOVING,                                /* boxes with an excess above 0 */
    SL_SUPPORT                                /* number of columns: 43 */
};

#define SL_PLAIN 14     /* plain features of a step */
#define SL_QUANTITIES 6 /* of a box, that training has ranges of */

/* Into `features` (J, SL_PLAIN): position, size, offset (columns 0 to 8) and the pallet's size (10
   to 12), x, y, z each, in shares of its longest side; 9, log of the weight [kg] of a box on a
   pallet of one metre at the same density; 13, log of the longest side [m]. `pallet` (3): its
   width, height and depth [cm], above 0. */
SL_API void sl_plain_features(int32_t count, const double *lower, const double *upper,
                              const double *weights, const double *offsets, const double *pallet,
                              float *features);

/* Into `table` (J, SL_SUPPORT): the columns of support. Into `features` (J, SL_SUPPORT): the
   same as networks take them. Angles, ways, loads, sides and heights of boxes, and weights: log
   of the value over 10, of 0.01 at least; all others: their inverse hyperbolic sine. SL_STANDS;
   SL_MEMORY where there is none, or SL_REFUSED with a count below 0 or above SL_MOST: both mean
   nothing then. */
SL_API int32_t sl_support(sl_work *work, int32_t count, const double *lower, const double *upper,
                          const double *weights, const double *offsets, const double *floor,
                          double *table, float *features);

/* Into `quantities` (J, SL_QUANTITIES): the shortest and the longest side [cm], the weight [kg],
   the greatest offset over its side, the heaviest over the lightest box so far, and how far the box
   stands out over the edges of the floor [cm], 0 or more. */
SL_API void sl_quantities(int32_t count, const double *lower, const double *upper,
                          const double *weights, const double *offsets, const double *floor,
                          double *quantities);

/* The number of first boxes whose quantities all lie in `least` to `most` (SL_QUANTITIES each). */
SL_API int32_t sl_inside(int32_t count, const double *quantities, const double *least,
                         const double *most);

/* One LSTM layer of so many cells (`width`) over so many steps. `inward` (columns, 4 width) and
   `recurrent` (width, 4 width): weights of the inputs `rows` (steps, columns) and of the output
   before; `bias` (4 width); gates in the order input, forget, output, cell. `state` (2, width): the
   output and the cells before the first step, and after the last one then. Into `outputs` (steps,
   width). SL_STANDS; SL_MEMORY, or SL_REFUSED with a size below 0 or a width above SL_MOST: then
   nothing is filled. */
SL_API int32_t sl_run_layer(sl_work *work, int32_t steps, int32_t columns, int32_t width,
                            const float *rows, const float *inward, const float *recurrent,
                            const float *bias, float *state, float *outputs);

/* Into `chances` (steps): the probability that a step is unstable, 0 to 1, of the last layer's
   `outputs` (steps, width). `head` (width) and `last`: weights and bias of the logit. */
SL_API void sl_decide(int32_t steps, int32_t width, const float *outputs, const float *head,
                      double last, float *chances);

/* plane.c, in the horizontal plane (x, z) [cm]. */
typedef struct { double x, z, nx, nz; } Edge;        /* a point of a border, the way outwards */
typedef struct { double area; int32_t patch; } Part; /* of a point: the area [cm2] it stands for */

double margin_in(double x, double z, const double (*hull)[2], int32_t count, Edge *nearest);
void pressures(double x, double z, const double (*points)[2], const Part *parts, int32_t count,
               double *forces);
void sort_points(double (*points)[2], Part *parts, int32_t count);

/* tipping.c: boxes 0 to `step`, of which box `i` moves. */
#define FLAT 1e-9 /* [cm2] cross product of two edges below which there is no corner between */

double angle_to_side(const Boxes *boxes, int32_t i, int32_t step, const Edge *edge);
double height_to_fall(const Boxes *boxes, int32_t i, int32_t step);

/* A box that tips: its base at a height, its resultant, the edge that it tips over, and the corners
   of its support's hull. */
typedef struct {
    int32_t i, step, corners;
    double level, x, z;
    Edge edge;
    const double (*hull)[2];
} Tipping;
int angles_to_catch(sl_work *work, const Boxes *boxes, const Tipping *tips, double *touch,
                    double *caught);

#ifdef __cplusplus
}
#endif
#endif
