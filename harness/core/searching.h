/* Functions for searches of other plans: boxes loaded at given places, and free places. Units,
   arrays and threads as in steadyload.h. J boxes. Endings are those of sl_ended. */
#ifndef SL_SEARCHING_H
#define SL_SEARCHING_H

#include "internal.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The boxes of a plan: sides [cm] and offsets [cm], as planned and turned by a quarter (2, J, 3),
   weights [kg] (J), places (J, 4), volumes [cm3] (J). A place is a lower corner [cm] and 0 as
   planned, 1 turned, -1 left out. */
typedef struct {
    int32_t count;
    const double *sides, *offsets, *weights, *planned, *volumes;
} sl_boxes;

/* Boxes loaded at given places, each as soon as it stands, in nearly the order of a plan. Boxes
   before the first change are not loaded again. `limits` (11) as of sl_session_new. NULL: no
   memory. */
typedef struct sl_loading sl_loading;
SL_API sl_loading *sl_loading_new(const double *limits, int32_t count);
SL_API void sl_loading_free(sl_loading *loading);

/* Of all boxes: places (J, 4), and margins of balance [cm] at the place in the plan and at any
   other (2, J). And places at which a box does not stand: its number and the place (R, 5). */
typedef struct {
    const double *places, *margins;
    int32_t refused_count;
    const double *refused;
} sl_wishes;

/* Goes back to before the first box that is at another place, or has another margin, than when it
   had its turn, and to before the turn of box `first` at the latest (J: no such). SL_STANDS, or
   SL_REFUSED: other boxes than the loading is for, or wrong numbers. */
SL_API int32_t sl_load_begin(sl_loading *loading, const sl_boxes *boxes, const sl_wishes *wishes,
                             int32_t first);

/* Lets all boxes that had no turn yet have theirs. A box that does not stand waits until others are
   loaded, where the order may change (`reorder`). A box is let down from above: no box loaded
   before may be in the way, unless both are at their places in the plan, where that was so, too.
   SL_STANDS: all had their turn. SL_LOOK: where the caller `looks`, a box was put on, and sl_said
   has to follow. SL_MEMORY: all is taken off. SL_REFUSED: as of sl_load_begin, or not yet said. */
SL_API int32_t sl_load(sl_loading *loading, const sl_boxes *boxes, const sl_wishes *wishes,
                       int32_t reorder, int32_t looks);

/* The box that was put on last, of which it is to be said whether it stays; -1 for none. */
SL_API int32_t sl_looked_at(const sl_loading *loading);

/* Whether that box stays; if not, it is taken off. SL_REFUSED where there is none. */
SL_API int32_t sl_said(sl_loading *loading, int32_t stays, int32_t reorder);

/* The numbers of boxes that are loaded, in order, and of those that wait (J each, or NULL); how
   many of either (2). */
SL_API void sl_loaded(const sl_loading *loading, int32_t *order, int32_t *waiting, int32_t *counts);

/* Where boxes were tried in their turns, and their margins (J, 5); infinite: they may not be there.
   Rows of boxes that had no turn say nothing. */
SL_API void sl_tried(const sl_loading *loading, double *tried);

/* The first of K places (K, 4) at which a box that is not loaded would stand on what is loaded, and
   may be: not that in the plan, nor a refused one. Their numbers are put in `found`, at most
   `most`; how many there are, or -SL_MEMORY, or -SL_REFUSED. Of `wishes` only what is refused
   counts. `margin` [cm]. */
SL_API int32_t sl_first_standing(sl_loading *loading, const sl_boxes *boxes,
                                 const sl_wishes *wishes, int32_t box, double margin, int32_t count,
                                 const double *places, int32_t most, int32_t *found);

/* Boxes that are left out, their volume [cm3], boxes that are elsewhere than in the plan, and how
   far their middles are from where they were, all together [cm]: `cost` (4). */
SL_API void sl_cost(const sl_boxes *boxes, const double *places, double *cost);

/* Where a box may be: contour (lower, upper) and deck (x0, z0, x1, z1) [cm] (10); how far it may
   move sideways, and how far up, at least and at most [cm] (3); how far its centre of mass is to
   lie inside the edges of what it lies on [cm], 0 or more; and how many places of a side are looked
   for. */
typedef struct {
    const double *limits, *ways;
    double margin;
    int32_t most;
} sl_wanted;

/* Places of a box of a plan among the others at their places (J, 4), but for those `without` (J
   bytes, not 0 for a box that it may overlap), the nearest first; `turns` 2 where it may be turned,
   else 1. Put in `found` (turns * most, 4), and in `far` (turns * most) how far its middle comes
   from where it was [cm]. How many there are, or -SL_MEMORY, or -SL_REFUSED. */
SL_API int32_t sl_places_among(sl_work *work, const sl_boxes *boxes, const double *places,
                               const uint8_t *without, int32_t box, const sl_wanted *wanted,
                               int32_t turns, double *found, double *far);

#ifdef __cplusplus
}
#endif

/* Shared by the files of the searches. */

#define AS_PLANNED 0.0 /* last number of a place */
#define TURNED 1.0
#define LEFT_OUT (-1.0)

#endif
