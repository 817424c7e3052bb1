/* Points where a box touches others, or soon may: on tops and bases, and on faces at sides. Called
   by motion.c. */
#include "timed.h"

/* Room for so many points; those there are stay. */
int make_room_for_points(sl_work *work, Points *points, int64_t room) {
    if (room > INT32_MAX / 4) return SL_MEMORY;
    Points more = {.count = points->count, .room = (int32_t)room};
    more.pairs = take(work, (uint64_t)room, sizeof *more.pairs);
    more.axes = take(work, (uint64_t)room, sizeof *more.axes);
    more.planned = take(work, (uint64_t)room, sizeof *more.planned);
    more.gaps = take(work, (uint64_t)room, sizeof *more.gaps);
    more.pushed = take(work, (uint64_t)room, sizeof *more.pushed);
    if (!more.pairs || !more.axes || !more.planned || !more.gaps || !more.pushed) return SL_MEMORY;
    size_t count = (size_t)points->count;
    if (count) {
        memcpy(more.pairs, points->pairs, count * sizeof *more.pairs);
        memcpy(more.axes, points->axes, count * sizeof *more.axes);
        memcpy(more.planned, points->planned, count * sizeof *more.planned);
        memcpy(more.gaps, points->gaps, count * sizeof *more.gaps);
        memcpy(more.pushed, points->pushed, count * sizeof *more.pushed);
    }
    *points = more;
    return SL_STANDS;
}

/* Puts the four corners of a patch behind the points. */
static void add_corners(Points *p, int32_t first, int32_t second, int axis, const double low[3],
                        const double high[3], double level, double gap) {
    int one = axis == 0 ? 1 : 0, two = axis == 2 ? 1 : 2;
    for (int corner = 0; corner < 4; corner++) {
        int32_t k = p->count++;
        p->pairs[k][0] = first, p->pairs[k][1] = second;
        p->axes[k] = (uint8_t)axis, p->gaps[k] = most(0.0, gap);
        p->planned[k][axis] = level;
        p->planned[k][one] = corner < 2 ? low[one] : high[one];
        p->planned[k][two] = corner % 2 == 0 ? low[two] : high[two];
    }
}

/* Adds the points of a box on the floor, and on the ground that a deck stands on. */
static void add_floor(Motion *m, int32_t item) {
    const double *lower = m->boxes->lower[item], *upper = m->boxes->upper[item];
    const double *floor = m->boxes->floor;
    for (int surface = 0; surface < (floor[4] > 0.0 ? 2 : 1); surface++) {
        double level = surface == 1 ? -floor[4] : 0.0, gap = lower[1] - level, low[3], high[3];
        memcpy(low, lower, sizeof low), memcpy(high, upper, sizeof high);
        if (surface == 0) {
            low[0] = most(floor[0], low[0]), low[2] = most(floor[1], low[2]);
            high[0] = least(floor[2], high[0]), high[2] = least(floor[3], high[2]);
        }
        if (gap <= m->reach && least(high[2] - low[2], high[0] - low[0]) > TOLERANCE)
            add_corners(&m->points, FLOOR, item, 1, low, high, level, gap);
    }
}

/* Adds the points of a box, but for those on boxes that are listed already. */
int list_points(sl_work *work, Motion *m, int32_t item) {
    const double (*lower)[3] = m->boxes->lower, (*upper)[3] = m->boxes->upper;
    int64_t room = (int64_t)m->points.count + 4 * ((int64_t)m->step + 3);
    if (room > m->points.room && make_room_for_points(work, &m->points, 2 * room)) return SL_MEMORY;
    add_floor(m, item);
    for (int32_t other = 0; other <= m->step; other++) {
        if (other == item || m->listed[other]) continue;
        int wide = 0, axis = -1;
        double low[3], high[3];
        for (int c = 0; c < 3; c++) {
            low[c] = most(lower[other][c], lower[item][c]);
            high[c] = least(upper[other][c], upper[item][c]);
            if (high[c] - low[c] > TOLERANCE) wide++;
            else axis = c;
        }
        if (wide != 2) continue;
        double other_middle = lower[other][axis] + upper[other][axis]; /* doubled */
        bool is_first = other_middle > lower[item][axis] + upper[item][axis];
        int32_t first = is_first ? item : other, second = is_first ? other : item;
        double level = upper[first][axis], gap = lower[second][axis] - level;
        if (-TOLERANCE <= gap && gap <= m->reach)
            add_corners(&m->points, first, second, axis, low, high, level, gap);
    }
    m->listed[item] = true;
    return SL_STANDS;
}
