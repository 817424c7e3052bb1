/* Boxes at rest, and whether they can carry what moving boxes press on them. Loads are passed on
   one way, from the highest base to the lowest. That proves that boxes stay at rest where it
   succeeds; where it fails nothing is said, and the box has to be solved for. Called by
   motion.c. */
#include "timed.h"

#define LEVEL 1e-12 /* share of a load: horizontal forces and twists below it are rounding */

/* The load of a force downwards at a point, on one edge of the friction pyramid. */
static void put_push(double unit[6], double x, double y, double z, int facet, double friction) {
    double fx = facet == 0 ? friction : facet == 1 ? -friction : 0.0;
    double fz = facet == 2 ? friction : facet == 3 ? -friction : 0.0;
    unit[0] = fx, unit[1] = -1.0, unit[2] = fz;
    unit[3] = y * fz + z;
    unit[4] = z * fx - x * fz;
    unit[5] = -x - y * fx;
}

/* A load as force and moment about a point, the moment in units of a length. */
static void put_about(double row[6], const double load[6], const double point[3], double scale,
                      double reach) {
    double x = point[0], y = point[1], z = point[2];
    row[0] = load[0] * scale, row[1] = load[1] * scale, row[2] = load[2] * scale;
    row[3] = (load[3] - (y * load[2] - z * load[1])) * scale / reach;
    row[4] = (load[4] - (z * load[0] - x * load[2])) * scale / reach;
    row[5] = (load[5] - (x * load[1] - y * load[0])) * scale / reach;
}

/* The k-th way to push on patches: by corner, and by edge of the friction pyramid. */
static void put_unit(double unit[6], const double (*patches)[4], int32_t k, double level,
                     double friction) {
    double at[2];
    put_corner(patches[k / 16], k / 4 % 4, at);
    put_push(unit, at[0], level, at[1], k % 4, friction);
}

/* Passes a load that is not vertical on to patches, inside their friction pyramids. */
static int pass_sideways(sl_work *work, Motion *m, const double load[6], double level,
                         const double (*patches)[4], const int32_t *below, int32_t count) {
    double friction = m->how->friction, down = -load[1], reach = EDGE;
    if (count == 0 || friction == 0.0) return SL_FAILS;
    if (count > INT32_MAX / 16) return SL_MEMORY;
    double point[3] = {(-load[5] - level * load[0]) / down, level,
                       (load[3] - level * load[2]) / down};
    for (int32_t k = 0; k < count; k++)
        for (int side = 0; side < 4; side++)
            reach = most(size_of(patches[k][side] - point[side % 2 ? 2 : 0]), reach);
    int32_t ways = 16 * count;
    double (*columns)[6] = take(work, (uint64_t)ways, sizeof *columns), target[6], rest[6], unit[6];
    double *parts = take(work, (uint64_t)ways, sizeof *parts);
    int32_t *blocks = take_zeros(work, (uint64_t)ways, sizeof *blocks);
    if (!columns || !parts || !blocks) return SL_MEMORY;
    put_about(target, load, point, 1.0 / down, reach);
    for (int32_t k = 0; k < ways; k++) {
        put_unit(unit, patches, k, level, friction);
        put_about(columns[k], unit, point, 1.0, reach);
    }
    Problem problem = {ways, 6, 1, 6, columns[0], blocks, target, parts, rest};
    int ended = least_squares(work, &problem, NULL, 0);
    if (ended == SL_MEMORY) return ended;
    double left = 0.0;
    for (int c = 0; c < 6; c++) left += rest[c] * rest[c];
    if (ended || root_of(left) * reach > 0.1 * EDGE) return SL_FAILS;
    for (int32_t k = 0; k < ways; k++) {
        if (!(parts[k] > 0.0)) continue;
        put_unit(unit, patches, k, level, friction);
        for (int c = 0; c < 6; c++) m->pressed[below[k / 16]][c] += parts[k] * down * unit[c];
    }
    return SL_STANDS;
}

/* Passes a load on to the patches below a box that stand on boxes at rest; SL_FAILS without way. */
static int pass_on(sl_work *work, Motion *m, int32_t item, const double load[6]) {
    const Contacts *c = &m->boxes->contacts;
    double down = -load[1];
    if (!(down > 0.0)) return SL_FAILS;
    int32_t first = c->starts[item], end = c->ends[item], count = 0;
    uint64_t room = (uint64_t)(end - first);
    double (*patches)[4] = take(work, room, sizeof *patches);
    double (*found)[3] = take(work, room, sizeof *found);
    int32_t *below = take(work, room, sizeof *below);
    if (!patches || !found || !below) return SL_MEMORY;
    for (int32_t k = first; k < end; k++) {
        int32_t carrier = c->below[k];
        if (carrier <= m->step && carrier != FLOOR && m->role[carrier] == FREE) continue;
        memset(m->pressed[k], 0, sizeof *m->pressed);
        if (carrier > m->step) continue;
        memcpy(patches[count], c->patches[k], sizeof *patches), below[count++] = k;
    }
    double x = -load[5] / down, z = load[3] / down;
    double sideways = most(size_of(load[2]), size_of(load[0]));
    /* The moment about the vertical, with the force taken at its own point. */
    double twist = load[4] - (z * load[0] - x * load[2]);
    if (!(sideways <= LEVEL * down && size_of(twist) <= LEVEL * down * 100.0))
        return pass_sideways(work, m, load, m->boxes->lower[item][1], (const double (*)[4])patches,
                             below, count);
    int ended = spread(work, down, x, z, (const double (*)[4])patches, count, found);
    for (int32_t k = 0; !ended && k < count; k++) {
        double *own = m->pressed[below[k]];
        own[1] = -found[k][0], own[3] = found[k][2], own[5] = -found[k][1];
    }
    return ended;
}

/* The load on a box at rest: its weight, and what presses on it from above. */
static void put_load(const Motion *m, int32_t item, double load[6]) {
    const Boxes *boxes = m->boxes;
    const Contacts *c = &boxes->contacts;
    double weight = boxes->weights[item];
    memcpy(load, m->loads[item], sizeof *m->loads);
    load[1] -= weight;
    load[3] += weight * boxes->centres[item][2];
    load[5] -= weight * boxes->centres[item][0];
    for (int32_t k = c->above_starts[item]; k < c->above_ends[item]; k++) {
        int32_t other = c->above[k], patch = c->meets[k];
        if (other > m->step || m->role[other] == FREE) continue;
        if (m->role[other] == PASSED) {
            for (int n = 0; n < 6; n++) load[n] += m->pressed[patch][n];
        } else {
            load[1] -= boxes->presses[patch][0];
            load[3] += boxes->presses[patch][2];
            load[5] -= boxes->presses[patch][1];
        }
    }
}

/* The first box at rest for which no way to carry its load was found, -1 where all do: begins with
   those whose role is PENDING; boxes reached become PASSED. */
int pass_on_loads(sl_work *work, Motion *m, int32_t *failed) {
    const Boxes *boxes = m->boxes;
    const Contacts *c = &boxes->contacts;
    for (;;) {
        int32_t item = *failed = highest_pending(boxes, m->role, m->step);
        double load[6];
        if (item < 0) return SL_STANDS;
        m->role[item] = PASSED;
        put_load(m, item, load);
        Mark before = mark(work);
        int ended = pass_on(work, m, item, load);
        if (ended) return ended == SL_FAILS ? SL_STANDS : ended;
        free_to(work, before);
        for (int32_t k = c->starts[item]; k < c->ends[item]; k++) {
            int32_t carrier = c->below[k];
            if (carrier == FLOOR || carrier > m->step || c->on_floor[carrier]) continue;
            bool loaded = m->pressed[k][1] != 0.0 || boxes->presses[k][0] != 0.0;
            if (m->role[carrier] == AT_EASE && loaded) m->role[carrier] = PENDING;
        }
    }
}
