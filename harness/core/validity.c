/* Which layouts are none: numbers of a box beyond limits, a box outside the contour, boxes that
   overlap. What counts as outside, and as an overlap, counts so in session.c, too. */
#include "internal.h"

static bool is_finite(double a) { return a - a == 0.0; }

static bool is_within(double a, const double limits[2]) { return limits[0] <= a && a <= limits[1]; }

/* A box whose numbers are not allowed; -1 where there is none. */
static int32_t refused(const Boxes *b, const double *sizes, const double limits[4]) {
    for (int32_t j = 0; j < b->count; j++) {
        if (!is_within(b->weights[j], limits + 2)) return j;
        for (int axis = 0; axis < 3; axis++) {
            double side = sizes[3 * (int64_t)j + axis];
            if (!is_finite(b->lower[j][axis]) || !is_within(side, limits)) return j;
            if (!(size_of(b->offsets[j][axis]) <= side / 2.0)) return j;
        }
    }
    return -1;
}

/* The box that stands out of the contour furthest, and the axis along which it does. */
static void put_outside(const Boxes *b, const double contour[6], sl_fault *found) {
    for (int32_t j = 0; j < b->count; j++)
        for (int axis = 0; axis < 3; axis++) {
            double low = b->lower[j][axis], high = b->upper[j][axis];
            double out = most(contour[axis] - low, high - contour[3 + axis]);
            if (!is_inside(contour, axis, low, high) && !(found->ended && out <= found->number))
                *found = (sl_fault){0, SL_OUTSIDE, j, axis, out};
        }
}

/* The two boxes, in order, that overlap most along the axis along which they do so least. */
static void put_overlap(const Boxes *b, sl_fault *found) {
    double deepest = TOLERANCE;
    for (int32_t j = 0; j < b->count; j++)
        for (int32_t k = j + 1; k < b->count; k++) {
            double depth = overlap(b, j, k, 0);
            for (int axis = 1; axis < 3 && depth > deepest; axis++)
                depth = least(depth, overlap(b, j, k, axis));
            if (depth > deepest) *found = (sl_fault){0, SL_OVERLAPS, k, j, deepest = depth};
        }
}

int32_t sl_first_fault(int32_t layouts, const int32_t *starts, const double *lower,
                       const double *upper, const double *sizes, const double *weights,
                       const double *offsets, const double *limits, const double *contours,
                       sl_fault *found) {
    *found = (sl_fault){layouts, SL_STANDS, -1, -1, 0.0};
    for (int32_t k = 0; k < layouts && !found->ended; k++) {
        int64_t first = starts[k];
        if (first < 0 || starts[k + 1] < first) return SL_REFUSED;
        Boxes boxes = boxes_of(starts[k + 1] - starts[k], lower + 3 * first, upper + 3 * first,
                               weights + first, offsets + 3 * first, NULL);
        int32_t item = refused(&boxes, sizes + 3 * first, limits);
        if (item >= 0 || !boxes.count) *found = (sl_fault){0, SL_REFUSED, item, -1, 0.0};
        else put_outside(&boxes, contours + 6 * (int64_t)k, found);
        if (!found->ended) put_overlap(&boxes, found);
        if (found->ended) found->layout = k;
    }
    return SL_STANDS;
}
