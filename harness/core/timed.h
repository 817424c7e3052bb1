/* Loading step by step, where boxes that lose their balance are followed for some time: a model of
   their motion, no simulation. Units, arrays and threads as in steadyload.h. */
#ifndef STEADYLOAD_TIMED_H
#define STEADYLOAD_TIMED_H

#include "internal.h"

/* How boxes are followed: friction of tops and bases (sides have none), gravity [cm/s2], how long
   [s], and the displacement [cm] and the angle [degrees] that count as moved. All 0 or more. */
typedef struct { double friction, gravity, seconds, eps_t, eps_r; } sl_how;

/* How a step ended: SL_STANDS (nothing moves, or the last motion is that with the new box, too),
   SL_FAILS (something is out of balance), SL_UNRESOLVED (rounding hides it, or no search for forces
   ended), SL_UNDECIDED or SL_MEMORY; the step; the box that comes farthest, how far its
   left-bottom-back corner comes along an axis [cm], the angle it turns by [degrees], and the larger
   of the two in units of its threshold: -1 and zeros where no motion was asked for. The loading
   fails where `beyond` is above 1. */
typedef struct { int32_t ended, step, item, unused; double shift, turn, beyond; } sl_moved;

/* A loading, and what is known of it so far: J boxes, P contact patches. Its arrays stay where they
   are until it is freed; those that are not const may be written to. After SL_MEMORY it can only be
   freed. */
typedef struct sl_timed sl_timed;
typedef struct {
    int32_t count, patches;      /* J, P */
    const int32_t *starts, *ends; /* (J) box j stands on the patches starts[j] to ends[j] */
    const int32_t *below;        /* (P) the box that carries there, -1 for the floor */
    const int32_t *above_starts, *above_ends; /* (J) where the boxes that stand on j are in above */
    const int32_t *above;        /* those boxes */
    uint8_t *pressing;           /* (P, 4) corners that pressed when last solved for */
    uint16_t *pushes;            /* (J + 1, J + 1) a bit for every corner and edge of its friction
                                    pyramid that pushed at the last start */
    uint8_t *moves;              /* (J) boxes that vertical forces do not balance */
    int32_t *answers;            /* (J) number of the last motion asked for of the group of the box,
                                    0 for none or where something came in its way */
    uint8_t *solved;             /* (J) boxes that moved then, or were solved for */
    double *farthest;            /* (J, 3, 2) how far corners of those came along every axis,
                                    forwards and backwards [cm] */
    double *beyond;              /* (J) how far something of the group of the box got then, in units
                                    of its threshold */
    int64_t *counts;             /* (2) steps at which the last motion was kept, or asked for */
    double *work;                /* (2) the sum of the squares of the numbers of boxes of all
                                    searches for forces; its limit, infinite at first */
} sl_timed_view;

/* Nothing is placed yet. `margin`: by which contact patches are drawn in on every side [cm], 0 or
   more. The arrays are copied. NULL: no memory, or a count beyond 0 to SL_MOST. */
SL_API sl_timed *sl_timed_new(int32_t count, const double *lower, const double *upper,
                              const double *weights, const double *offsets, const double *floor,
                              double margin);
SL_API void sl_timed_free(sl_timed *timed);
SL_API void sl_timed_look(const sl_timed *timed, sl_timed_view *view);

/* Places boxes from `first` up to, without, `end` until one comes too far or how it ends is not
   known; all before them must have been placed, whatever came of it. Where none comes too far:
   SL_STANDS with the step `end`. Returns found->ended. */
SL_API int32_t sl_timed_first(sl_timed *timed, int32_t first, int32_t end, const sl_how *how,
                              sl_moved *found);

/* The two halves of placing one box. The first returns SL_FAILS where something of the group of the
   new box is out of balance: then `group` (room for J) and `size` are the group, in order, and
   `kept` is 1 where its last motion is that with the new box, too. Else size and kept are 0. */
SL_API int32_t sl_timed_group(sl_timed *timed, int32_t step, int32_t *kept, int32_t *size,
                              int32_t *group);
SL_API int32_t sl_timed_moved(sl_timed *timed, int32_t step, int32_t size, const int32_t *group,
                              const sl_how *how, sl_moved *found);

/* Whether a box on the floor has its centre of mass outside its base, drawn in by a margin [cm]. */
SL_API int32_t sl_timed_is_near_its_edge(const sl_timed *timed, int32_t item, double margin);

/* sl_timed_first of whole layouts, with a limit of work each; many as in sl_judge_many. */
SL_API int32_t sl_first_moved(sl_work *work, int32_t count, const double *lower,
                              const double *upper, const double *weights, const double *offsets,
                              const double *floor, double limit, const sl_how *how,
                              sl_moved *found);
SL_API int32_t sl_first_moved_many(sl_work *work, int32_t layouts, const int32_t *starts,
                                   const double *lower, const double *upper, const double *weights,
                                   const double *offsets, const double *floors, double limit,
                                   const sl_how *how, sl_moved *found);

/* The same without motion: balance step by step, whatever came of the steps before, with forces
   that are solved for of whole groups. Placing returns SL_STANDS, SL_FAILS, SL_UNRESOLVED (then
   nothing has changed), SL_MEMORY or SL_REFUSED; `item` is out of balance, -1 for none. */
typedef struct sl_held sl_held;
SL_API sl_held *sl_held_new(int32_t count, const double *lower, const double *upper,
                            const double *weights, const double *offsets, const double *floor,
                            double margin);
SL_API void sl_held_free(sl_held *held);
SL_API int32_t sl_held_place(sl_held *held, int32_t step, int32_t *item);
/* The boxes joined to one by standing on each other, of those up to it, without those on the floor,
   in order: into `group` (room for J). How many there are, -1 without memory. */
SL_API int32_t sl_held_group(sl_held *held, int32_t step, int32_t *group);

/* The side [cm] below which a box that tips within a time [s] grows so much that its acceleration
   may be rounding. */
SL_API double sl_thin_side(double gravity, double seconds);

/* From here on: for the files of the library alone. */

/* Points where boxes touch others, or soon may: corners of contact patches, on tops and bases and
   on faces at sides, and of patches that close when a gap does. */
typedef struct {
    int32_t count, room;
    int32_t (*pairs)[2];  /* the two bodies, boxes or FLOOR */
    uint8_t *axes;        /* of the normals, which point from the first body to the second */
    double (*planned)[3]; /* where they are while all boxes are where they were planned [cm] */
    double *gaps;         /* how far the faces are apart there now [cm] */
    bool (*pushed)[4];    /* by edge of the friction pyramid, when last solved for */
} Points;

/* Boxes of a group that move, and what they meet. A load has six numbers: force (x, y, z) [kg] and
   its moment about the origin [kg cm]; a way too: displacement [cm] and turn [rad]. */
typedef struct {
    const Boxes *boxes;
    const sl_how *how;
    int32_t step;
    Some group;
    double reach;                      /* gaps up to this may close [cm] */
    uint8_t *role;                     /* of every box */
    bool *within, *listed, *leans;     /* boxes of the group; with points; that carried free ones */
    double (*way)[6], (*farthest)[3][2], (*loads)[6], (*pressed)[6]; /* pressed: at patches */
    Points points;
    /* at this moment */
    int32_t count, *free, *place;      /* free boxes, and the place of each among them, else -1 */
    double (*mass)[6], mean, (*rest)[6]; /* masses and inertias; what forces leave of the weights */
    double (*at)[3];                   /* points */
    int32_t columns, *sources;         /* forces: 4 times the point plus the edge of its pyramid */
    double (*forces)[3], *parts;       /* directions, on the second body, and sizes */
    int32_t (*bodies)[2];              /* places of the free boxes that feel each, -1 for none */
    double (*wrenches)[2][6];          /* what it does to them, scaled by the roots of masses */
} Motion;

struct sl_timed {
    sl_work *work;
    Boxes boxes;
    uint16_t *pushes;
    int32_t *answers;
    bool *solved, *leans;
    double (*farthest)[3][2], *beyond, spent[2];
    int64_t counts[2];
};

#define TOUCH (2.0 * TOLERANCE) /* [cm]: a gap below this is closed while boxes move */
#define EVENTS 40               /* gaps that close, after which a motion is not followed any more */
#define SAMPLES 60              /* times between two events when it is looked for closed gaps */
#define FAR 25.0                /* keeps a light pendulum from overflowing; it has tipped anyway */
#define AT_REST 1e-12           /* share of the largest energy below which a box is at rest */

int begin_to_follow(sl_timed *timed);
int moving_group(sl_timed *timed, int32_t step, bool *kept, Some *group);
int moved_group(sl_timed *timed, int32_t step, Some group, const sl_how *how, sl_moved *found);
int place_next(sl_timed *timed, int32_t step, const sl_how *how, sl_moved *found);
int first_moved(sl_timed *timed, int32_t first, int32_t end, const sl_how *how, sl_moved *found);

int follow(sl_timed *timed, Motion *m);
int make_room_for_points(sl_work *work, Points *points, int64_t room);
int list_points(sl_work *work, Motion *m, int32_t item);
int find_wrenches(sl_work *work, Motion *m);
void put_wrench(double row[6], const double force[3], const double at[3], const double centre[3],
                const double way[6], double sign);
int find_least_forces(sl_work *work, Motion *m);
int drop_rounding(sl_work *work, const Motion *m, double thin);
double thin_side(double gravity, double left);
void merge(int32_t *cluster, int32_t count, int32_t a, int32_t b);
int find_growth(sl_work *work, const Motion *m, const double (*rates)[6], double *growth);
int coast(sl_work *work, Motion *m, const double (*rates)[6], const double *growth, double left,
          double *passed);
int pass_on_loads(sl_work *work, Motion *m, int32_t *failed);

#endif
