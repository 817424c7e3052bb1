/* How far a box that tips, or that nothing supports, gets until something is in its way. Called by
   features.c. */
#include "elementary.h"
#include "learned.h"

/* The part of a box's base that the floor lies below. */
Base base_on_floor(const Boxes *boxes, int32_t i) {
    const double *low = boxes->lower[i], *high = boxes->upper[i], *floor = boxes->floor;
    return (Base){max_of(low[0], floor[0]), min_of(high[0], floor[2]),
                  max_of(low[2], floor[1]), min_of(high[2], floor[3])};
}

/* The rectangle that the bases of two boxes share. */
Base base_shared(const Boxes *boxes, int32_t i, int32_t k) {
    const double *low = boxes->lower[i], *high = boxes->upper[i];
    const double *from = boxes->lower[k], *to = boxes->upper[k];
    return (Base){max_of(low[0], from[0]), min_of(high[0], to[0]),
                  max_of(low[2], from[2]), min_of(high[2], to[2])};
}

bool is_area(Base base) { return base.x1 - base.x0 > TOLERANCE && base.z1 - base.z0 > TOLERANCE; }

/* The angle [rad] at which a box that tips outwards meets one at its side, a right one for none. */
double angle_to_side(const Boxes *boxes, int32_t i, int32_t step, const Edge *edge) {
    const double *low = boxes->lower[i], *high = boxes->upper[i];
    const double way[3] = {edge->nx, 0.0, edge->nz};
    double best = RIGHT;
    for (int32_t k = 0; k <= step; k++) {
        const double *from = boxes->lower[k], *to = boxes->upper[k];
        double top = min_of(high[1], to[1]);
        if (k == i || top - max_of(low[1], from[1]) <= TOLERANCE) continue;
        double lever = top - low[1];
        for (int axis = 0; axis < 3; axis += 2) {
            int other = 2 - axis;
            double common = min_of(high[other], to[other]) - max_of(low[other], from[other]);
            if (!(common > TOLERANCE && size_of(way[axis]) > 0.3)) continue;
            double gap = way[axis] > 0.0 ? from[axis] - high[axis] : low[axis] - to[axis];
            if (gap >= -TOLERANCE)
                best = min_of(best, angle_of(max_of(gap, 0.0), lever * size_of(way[axis])));
        }
    }
    return best;
}

/* Height that a box without support can fall [cm]. */
double height_to_fall(const Boxes *boxes, int32_t i, int32_t step) {
    const double *low = boxes->lower[i], *high = boxes->upper[i];
    Base base = base_on_floor(boxes, i);
    bool off = min_of(base.x1 - base.x0, base.z1 - base.z0) <= TOLERANCE;
    double gap = off ? low[1] + boxes->floor[4] : max_of(low[1], 0.0);
    for (int32_t k = 0; k <= step; k++) {
        const double *from = boxes->lower[k], *to = boxes->upper[k];
        if (k == i || !(to[1] <= low[1] + TOLERANCE)) continue;
        double wide = min_of(high[0], to[0]) - max_of(low[0], from[0]);
        double deep = min_of(high[2], to[2]) - max_of(low[2], from[2]);
        if (wide > TOLERANCE && deep > TOLERANCE) gap = min_of(gap, max_of(low[1] - to[1], 0.0));
    }
    return gap;
}

/* Puts the tops below a box that it meets when it tips, in the order of angles [rad]; how many. */
static int32_t met_below(const Boxes *boxes, const Tipping *tips, double *angles, Base *bases) {
    const double *low = boxes->lower[tips->i], *high = boxes->upper[tips->i];
    const Edge *edge = &tips->edge;
    double own[4];
    int32_t met = 0;
    put_base(boxes, tips->i, own);
    /* The floor is numbered -1, and the ground beyond its edges -2. */
    for (int32_t k = stands_out(boxes->floor, own) ? -2 : -1; k <= tips->step; k++) {
        if (k == tips->i) continue;
        Base base = {low[0], high[0], low[2], high[2]};
        double top = k == -2 ? -boxes->floor[4] : k == -1 ? 0.0 : boxes->upper[k][1];
        if (k == -1) base = base_on_floor(boxes, tips->i);
        if (k >= 0) base = base_shared(boxes, tips->i, k);
        if (top > tips->level - TOLERANCE || base.x1 - base.x0 <= TOLERANCE ||
            base.z1 - base.z0 <= TOLERANCE) continue;
        double far = ((edge->nx > 0.0 ? base.x1 : base.x0) - edge->x) * edge->nx;
        far += ((edge->nz > 0.0 ? base.z1 : base.z0) - edge->z) * edge->nz;
        if (!(far > 1e-6)) continue;
        double angle = angle_of(tips->level - top, far);
        int32_t place = met++;
        for (; place && angles[place - 1] > angle; place--)
            angles[place] = angles[place - 1], bases[place] = bases[place - 1];
        angles[place] = angle, bases[place] = base;
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
    Base *bases = take(work, room, sizeof *bases);
    double (*points)[2] = take(work, size, sizeof *points);
    double (*hull)[2] = take(work, 2 * size + 1, sizeof *hull);
    if (!angles || !bases || !points || !hull) return SL_MEMORY;
    int32_t met = met_below(boxes, tips, angles, bases), count = tips->corners;
    *touch = met ? angles[0] : RIGHT;
    *caught = RIGHT;
    memcpy(points, tips->hull, (size_t)count * sizeof *points);
    for (int32_t k = 0; k < met; k++) {
        const double xs[2] = {bases[k].x0, bases[k].x1}, zs[2] = {bases[k].z0, bases[k].z1};
        for (int corner = 0; corner < 4; corner++, count++)
            points[count][0] = xs[corner / 2], points[count][1] = zs[corner % 2];
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
