/* What searches for other plans call, and how a session is read; see steadyload.h for units and
   shapes. J boxes, all arrays row by row. Endings are those of sl_ended. */
#ifndef SL_SEARCHING_H
#define SL_SEARCHING_H

#include "internal.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Reading a session. Boxes count from 0, in the order in which they were placed; where there is no
   such box, the answer is -1. */

/* The same in other memory, growing by itself; NULL: there is none left. */
SL_API sl_session *sl_session_copy(const sl_session *session);

/* How many boxes stand out over an edge of the deck. */
SL_API int32_t sl_session_overhung(const sl_session *session);

/* How many patches its memory has room for. */
SL_API int32_t sl_session_room(const sl_session *session);

/* Boxes first to first + count, NULL for what is not wanted: corners [cm] and offsets (count, 3),
   weights [kg] (count). SL_STANDS, or SL_REFUSED where there are not so many boxes. */
SL_API int32_t sl_session_boxes(const sl_session *session, int32_t first, int32_t count,
                                double *lower, double *upper, double *offsets, double *weights);

/* 1 where a box stands on the floor with all of its base, else 0. */
SL_API int32_t sl_session_on_floor(const sl_session *session, int32_t box);

/* The number of patches below a box, of which the first `room` are written: what is below, -1 for
   the floor (room), x0, z0, x1, z1 [cm] (room, 4), and force [kg] and its moments about x and z
   [kg cm] (room, 3; NULL for not wanted). They come in the order in which they came about. */
SL_API int32_t sl_session_below(const sl_session *session, int32_t box, int32_t room,
                                int32_t *below, double *patches, double *presses);

/* The number of boxes on a box, of which the first `room` are written, as they came. */
SL_API int32_t sl_session_above(const sl_session *session, int32_t box, int32_t room,
                                int32_t *above);

/* The number of boxes that share a point with a region, `wider` [cm] on every side; the first
   `room` of them are written, in order. `lower`, `upper` (3). */
SL_API int32_t sl_session_near(const sl_session *session, const double *lower, const double *upper,
                               double wider, int32_t room, int32_t *near);

/* The boxes of a plan: sides [cm] and offsets [cm], as planned and turned by a quarter (2, J, 3),
   weights [kg] (J), places (J, 4), volumes [cm3] (J). A place is a lower corner [cm] and 0 as
   planned, 1 turned, -1 left out. */
typedef struct {
    int32_t count;
    const double *sides, *offsets, *weights, *planned, *volumes;
} sl_boxes;

/* Boxes loaded at given places, each as soon as it stands, in nearly the order of a plan. What was
   loaded last stays: boxes before the first change are not loaded again. `limits` (11) as of
   sl_session_new. NULL: no memory. */
typedef struct sl_loading sl_loading;
SL_API sl_loading *sl_loading_new(const double *limits, int32_t count);
SL_API void sl_loading_free(sl_loading *loading);

/* The session that holds what is loaded: to be read, not to be changed. */
SL_API const sl_session *sl_loading_session(const sl_loading *loading);

/* Places (J, 4) and margins of balance [cm] (J) of all boxes, and places at which a box does not
   stand: its number and the place (R, 5). At another place than planned the margin of a box is at
   least 0.5 cm. */
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
#define SL_LOOK 8
SL_API int32_t sl_load(sl_loading *loading, const sl_boxes *boxes, const sl_wishes *wishes,
                       int32_t reorder, int32_t looks);

/* The box that was put on last, of which it is to be said whether it stays; -1 for none. */
SL_API int32_t sl_looked_at(const sl_loading *loading);

/* Whether that box stays; if not, it is taken off. SL_REFUSED where there is none. */
SL_API int32_t sl_said(sl_loading *loading, int32_t stays, int32_t reorder);

/* The numbers of boxes that are loaded, in order, and of those that wait (J each, or NULL); how many
   of either (2). */
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
   move sideways, and how far up, at least and at most [cm] (3); how far its centre of mass is to lie
   inside the edges of what it lies on [cm], 0 or more; and how many places of a side are looked
   for. */
typedef struct {
    const double *limits, *ways;
    double margin;
    int32_t most;
} sl_wanted;

/* Places of a box of a plan among the others at their places (J, 4), but for those `without` (J
   bytes, not 0 for a box that it may overlap), the nearest first; `turns` 2 where it may be turned,
   else 1. Put in `found` (turns * most, 4), and in `far` (turns * most) how far its middle comes from
   where it was [cm]. How many there are, or -SL_MEMORY, or -SL_REFUSED. */
SL_API int32_t sl_places_among(sl_work *work, const sl_boxes *boxes, const double *places,
                               const uint8_t *without, int32_t box, const sl_wanted *wanted,
                               int32_t turns, double *found, double *far);

/* Lower corners (most, 3), in no order, of places of one side of a box among J others, of which
   corners and centres of mass are given (J, 3): its `size` (3), `middle`: of
   its centre of mass from its lower corner (3), its lower corner before (3), and heights at which it
   may lie, the most wanted ones first. How many, or -SL_MEMORY, or -SL_REFUSED. */
SL_API int32_t sl_free_places(sl_work *work, int32_t count, const double *lower,
                              const double *upper, const double *centres, const double *size,
                              const double *middle, const double *start, const sl_wanted *wanted,
                              int32_t level_count, const double *levels, double *found);

/* Vertical contacts of a layout: boxes that stand on the floor with all of their base, not 0 (J);
   the patches that box j stands on are starts[j] to starts[j + 1] (J + 1), the boxes on it
   above_starts[j] to above_starts[j + 1] (J + 1). For all patches what is below, -1 for the floor
   (room), x0, z0, x1, z1 [cm] (room, 4), and the boxes that are above others (room): both in
   ascending order for every box. How many patches there are, where these are more than `room` none
   are written; or -SL_MEMORY, or -SL_REFUSED. */
SL_API int32_t sl_contacts(sl_work *work, int32_t count, const double *lower, const double *upper,
                           const double *floor, uint8_t *on_floor, int32_t *starts,
                           int32_t *above_starts, int32_t room, int32_t *below, double *patches,
                           int32_t *above);

/* By how much all contact patches of a layout may be drawn in on every side with every step still
   balanced, to 0.001 cm, up to `most` [cm], 0 to 1e6. `found`: the margin is its number, with the step at
   which it is smallest and the item that is the first to lose its balance there, both -1 where it is
   `most`; where a step has no balance at all, how that ended, with the step and the item. */
SL_API int32_t sl_margin(sl_work *work, double most, int32_t count, const double *lower,
                         const double *upper, const double *weights, const double *offsets,
                         const double *floor, sl_finding *found);

/* Forces of least energy of a load that grows: what was found before is changed, not found anew.
   E equations, three a box; C corners. Factors L D L' of the equations: the columns of L (E + 1
   starts), rows of their entries, ascending and behind the column, all values 0, and D (E). Effects
   of unit forces at corners over the roots of how far these yield: columns (C + 1 starts), rows,
   values. `right` (E); `presses` (C bytes): which corners probably press. All is copied. NULL: no
   memory, or numbers that make no such equations. */
typedef struct sl_energy sl_energy;
SL_API sl_energy *sl_energy_new(int32_t equations, const int32_t *starts, const int32_t *rows,
                                const double *diagonal, int32_t corners,
                                const int32_t *column_starts, const int32_t *column_rows,
                                const double *column_values, const double *right,
                                const uint8_t *presses);
SL_API void sl_energy_free(sl_energy *energy);

/* Puts the forces at `count` corners, times the roots of how far they yield, in `pulls` (count);
   what is below 0 is none. `corners` are those of boxes that are there, `some` the equations of the
   same boxes, in order. SL_STANDS, or SL_FAILS where none are found: nothing can be asked any more.
   SL_REFUSED: no such corners or equations, or after it failed. */
SL_API int32_t sl_energy_solve(sl_energy *energy, int32_t count, const int32_t *corners,
                               int32_t some_count, const int32_t *some, double *pulls);

#ifdef __cplusplus
}
#endif

/* What the files of the searches share. */

#define AS_PLANNED 0.0 /* last number of a place */
#define TURNED 1.0
#define LEFT_OUT (-1.0)
#define OF_MOVED 0.5 /* [cm] margin of balance of a box that is not at its place in the plan */

#define SLABS 32         /* of the contour along an axis */
#define ROWS (6 * SLABS) /* words for 64 boxes: see session.c */

typedef struct { int32_t item, patch; double press[3]; } Change;

struct sl_session {
    double limits[11], slabs[3]; /* slabs a cm along x, y, z */
    Boxes boxes;                 /* with room behind those that count */
    int32_t aboves, changes, overhung;
    int32_t room, links;         /* boxes, patches */
    int32_t *rooms, *above_rooms, *begun; /* where the blocks of a box end, its changes begin */
    Change *change;
    uint64_t (*cells)[ROWS];
    sl_work *work;
};

/* How putting on the next box ends; it stays on if it stands and is to `stay`. */
int try_box(sl_session *session, const double *box, int32_t rule, double alpha, bool stay,
            sl_finding *found);

/* An array (address of its pointer) with room for `now` elements, where it had room for `before`. */
bool widen(void *array, uint64_t before, uint64_t now, uint64_t size);

#endif
