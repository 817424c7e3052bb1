/* How far a box that tips, or that nothing supports, gets until something is in its way. Called by
   features.c. */
#include "elementary.h"
#include "learned.h"

/* The angle [rad] at which a box that tips outwards meets one at its side, a right one for none. */
double angle_to_side(const Boxes *boxes, int32_t i, int32_t step, const Edge *edge) {
    const double *low = boxes->lower[i], *high = boxes->upper[i];
    const double way[3] = {edge->nx, 0.0, edge->nz};
    double best = RIGHT;
    for (int32_t k = 0; k <= step; k++) {
        const double *from = boxes->lower[k], *to = boxes->upper[k];
        double top = least(to[1], high[1]);
        if (k == i || top - most(from[1], low[1]) <= TOLERANCE) continue;
        double lever = top - low[1];
        for (int axis = 0; axis < 3; axis += 2) {
            int other = 2 - axis;
            double common = least(to[other], high[other]) - most(from[other], low[other]);
            if (!(common > TOLERANCE && size_of(way[axis]) > 0.3)) continue;
            double gap = way[axis] > 0.0 ? from[axis] - high[axis] : low[axis] - to[axis];
            if (gap >= -TOLERANCE)
                best = least(angle_of(most(0.0, gap), lever * size_of(way[axis])), best);
        }
    }
    return best;
}

/* Height that a box without support can fall [cm]. */
double height_to_fall(const Boxes *boxes, int32_t i, int32_t step) {
    double base[4], top[4], patch[4], low = boxes->lower[i][1];
    put_base(boxes, i, base);
    double gap = share(base, boxes->floor, patch) ? most(0.0, low) : low + boxes->floor[4];
    for (int32_t k = 0; k <= step; k++) {
        double level = boxes->upper[k][1];
        if (k == i || !(level <= low + TOLERANCE)) continue;
        put_base(boxes, k, top);
        if (share(base, top, patch)) gap = least(most(0.0, low - level), gap);
    }
    return gap;
}

/* Puts the tops below a box that it meets when it tips, in the order of angles [rad]; how many. */
static int32_t met_below(const Boxes *boxes, const Tipping *tips, double *angles,
                         double (*patches)[4]) {
    const Edge *edge = &tips->edge;
    double base[4], other[4], patch[4];
    int32_t met = 0;
    put_base(boxes, tips->i, base);
    /* The floor is numbered -1, and the ground beyond its edges -2. */
    for (int32_t k = stands_out(boxes->floor, base) ? -2 : -1; k <= tips->step; k++) {
        if (k == tips->i) continue;
        double top = k == -2 ? -boxes->floor[4] : k == -1 ? 0.0 : boxes->upper[k][1];
        if (top > tips->level - TOLERANCE) continue;
        if (k >= 0) put_base(boxes, k, other);
        const double *below = k == -2 ? base : k == -1 ? boxes->floor : other;
        if (!share(base, below, patch)) continue;
        double far = (patch[edge->nx > 0.0 ? 2 : 0] - edge->x) * edge->nx;
        far += (patch[edge->nz > 0.0 ? 3 : 1] - edge->z) * edge->nz;
        if (!(far > 1e-6)) continue;
        double angle = angle_of(tips->level - top, far);
        int32_t place = met++;
        for (; place && angles[place - 1] > angle; place--)
            angles[place] = angles[place - 1],
            memcpy(patches[place], patches[place - 1], sizeof patch);
        angles[place] = angle;
        memcpy(patches[place], patch, sizeof patch);
    }
    return met;
}

/* The angles [rad] at which a box that tips first meets something below, and is held by it; right
   ones for none. */
int angles_to_catch(sl_work *work, const Boxes *boxes, const Tipping *tips, double *touch,
                    double *caught) {
    uint64_t room = (uint64_t)tips->step + 3, size = 4 * room + (uint64_t)tips->corners;
    Mark before = mark(work);
    double *angles = take(work, room, sizeof *angles);
    double (*patches)[4] = take(work, room, sizeof *patches);
    double (*points)[2] = take(work, size, sizeof *points);
    double (*hull)[2] = take(work, 2 * size + 1, sizeof *hull);
    if (!angles || !patches || !points || !hull) return SL_MEMORY;
    int32_t met = met_below(boxes, tips, angles, patches), count = tips->corners;
    *touch = met ? angles[0] : RIGHT;
    *caught = RIGHT;
    memcpy(points, tips->hull, (size_t)count * sizeof *points);
    for (int32_t k = 0; k < met; k++) {
        for (int corner = 0; corner < 4; corner++) put_corner(patches[k], corner, points[count++]);
        sort_points(points, NULL, count);
        Edge nearest;
        int32_t corners = hull_of((const double (*)[2])points, count, hull, FLAT);
        double margin = margin_in(tips->x, tips->z, (const double (*)[2])hull, corners, &nearest);
        if (margin >= 0.0) {
            *caught = angles[k];
            break;
        }
    }
    free_to(work, before);
    return SL_STANDS;
}
