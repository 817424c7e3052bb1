/* Forces between boxes of which some are free to move, at one moment. Called by motion.c, and of
   one force by pendulums.c. */
#include "elementary.h"
#include "timed.h"

/* A force and its moment about the centre of mass of a body, where that is now. */
void put_wrench(double row[6], const double force[3], const double at[3], const double centre[3],
                const double way[6], double sign) {
    double x = at[0] - centre[0] - way[0], y = at[1] - centre[1] - way[1];
    double z = at[2] - centre[2] - way[2];
    row[0] = sign * force[0], row[1] = sign * force[1], row[2] = sign * force[2];
    row[3] = sign * (y * force[2] - z * force[1]);
    row[4] = sign * (z * force[0] - x * force[2]);
    row[5] = sign * (x * force[1] - y * force[0]);
}

static int edges_at(const Motion *m, int32_t point) {
    return m->points.axes[point] == 1 && m->how->friction > 0.0 ? 4 : 1;
}

/* The effect of a force on the two bodies of a point. */
static void put_column(Motion *m, int32_t column, int32_t point) {
    for (int side = 0; side < 2; side++) {
        int32_t body = m->points.pairs[point][side], n = body < 0 ? -1 : m->place[body];
        double *row = m->wrenches[column][side];
        m->bodies[column][side] = n;
        if (n < 0) continue;
        put_wrench(row, m->forces[column], m->at[point], m->boxes->centres[body], m->way[body],
                   side == 1 ? 1.0 : -1.0);
        for (int c = 0; c < 6; c++) row[c] /= root_of(m->mass[n][c]);
    }
}

/* Forces that closed points can exert. */
int find_wrenches(sl_work *work, Motion *m) {
    const Points *p = &m->points;
    double friction = m->how->friction;
    int64_t count = 0;
    for (int32_t k = 0; k < p->count; k++)
        if (p->gaps[k] <= TOUCH) count += edges_at(m, k);
    if (count > INT32_MAX) return SL_MEMORY;
    m->columns = (int32_t)count;
    m->sources = take(work, (uint64_t)count, sizeof *m->sources);
    m->forces = take_zeros(work, (uint64_t)count, sizeof *m->forces);
    m->bodies = take(work, (uint64_t)count, sizeof *m->bodies);
    m->wrenches = take_zeros(work, (uint64_t)count, sizeof *m->wrenches);
    m->parts = take_zeros(work, (uint64_t)count, sizeof *m->parts);
    if (!m->sources || !m->forces || !m->bodies || !m->wrenches || !m->parts) return SL_MEMORY;
    int32_t column = 0;
    for (int32_t k = 0; k < p->count; k++) {
        if (!(p->gaps[k] <= TOUCH)) continue;
        int edges = edges_at(m, k);
        for (int edge = 0; edge < edges; edge++, column++) {
            double *force = m->forces[column];
            m->sources[column] = 4 * k + edge;
            force[p->axes[k]] = 1.0;
            if (edges == 4) force[edge % 2 == 0 ? 2 : 0] = edge < 2 ? friction : -friction;
            put_column(m, column, k);
        }
    }
    return SL_STANDS;
}

/* Gives all bodies of the cluster of one body the name of that of another. */
void merge(int32_t *cluster, int32_t count, int32_t a, int32_t b) {
    int32_t new = cluster[a], old = cluster[b];
    for (int32_t n = 0; new != old && n < count; n++)
        if (cluster[n] == old) cluster[n] = new;
}

/* The forces between the bodies of a cluster: `row` is six times the place of each in it, `some`
   the columns that it feels. */
static int solve_cluster(sl_work *work, Motion *m, const int32_t *cluster, int32_t name,
                         const int32_t *row, int32_t size, const int32_t *some, int32_t width) {
    if (size > INT32_MAX / 6) return SL_MEMORY;
    double (*columns)[2][6] = take(work, (uint64_t)width, sizeof *columns);
    int32_t (*blocks)[2] = take(work, (uint64_t)width, sizeof *blocks);
    int32_t *likely = take(work, (uint64_t)width, sizeof *likely), likely_count = 0;
    double *target = take_zeros(work, 6 * (uint64_t)size, sizeof *target);
    double *found = take(work, (uint64_t)width, sizeof *found);
    double *left = take(work, 6 * (uint64_t)size, sizeof *left);
    if (!columns || !blocks || !likely || !target || !found || !left) return SL_MEMORY;
    for (int32_t n = 0; n < m->count; n++)
        if (cluster[n] == name) target[row[n] + 1] = root_of(m->mass[n][0]);
    for (int32_t at = 0; at < width; at++) {
        int32_t k = some[at], source = m->sources[k];
        memcpy(columns[at], m->wrenches[k], sizeof *columns);
        for (int side = 0; side < 2; side++)
            blocks[at][side] = m->bodies[k][side] < 0 ? -1 : row[m->bodies[k][side]];
        if (m->points.pushed[source / 4][source % 4]) likely[likely_count++] = at;
    }
    Problem problem = {width, 6 * size, 2, 6, (const double *)columns, (const int32_t *)blocks,
                       target, found, left};
    int ended = least_squares(work, &problem, likely, likely_count);
    if (ended) return ended;
    for (int32_t at = 0; at < width; at++) m->parts[some[at]] = found[at];
    for (int32_t n = 0; n < m->count; n++)
        if (cluster[n] == name) memcpy(m->rest[n], left + row[n], sizeof *m->rest);
    return SL_STANDS;
}

/* Forces that leave the least of the weights of free bodies, and what they leave, both in units of
   a weight of mass 1. Bodies that touch no others that are free are solved for on their own; what
   pushed before is tried first. SL_UNRESOLVED where a search gave up. */
int find_least_forces(sl_work *work, Motion *m) {
    int32_t count = m->count, *cluster = take(work, (uint64_t)count, sizeof *cluster);
    int32_t *row = take(work, (uint64_t)count, sizeof *row);
    int32_t *some = take(work, (uint64_t)m->columns, sizeof *some);
    m->rest = take_zeros(work, (uint64_t)count, sizeof *m->rest);
    if (!cluster || !row || !some || !m->rest) return SL_MEMORY;
    for (int32_t n = 0; n < count; n++) cluster[n] = n;
    for (int32_t k = 0; k < m->columns; k++)
        if (m->bodies[k][0] >= 0 && m->bodies[k][1] >= 0)
            merge(cluster, count, m->bodies[k][0], m->bodies[k][1]);
    for (int32_t name = 0; name < count; name++) {
        int32_t size = 0, width = 0;
        for (int32_t n = 0; n < count; n++)
            if (cluster[n] == name) row[n] = 6 * size++;
        if (size == 0) continue;
        for (int32_t k = 0; k < m->columns; k++) {
            int32_t a = m->bodies[k][0], b = m->bodies[k][1];
            if (cluster[a > b ? a : b] == name) some[width++] = k;
        }
        Mark before = mark(work);
        int ended = solve_cluster(work, m, cluster, name, row, size, some, width);
        if (ended) return ended;
        free_to(work, before);
    }
    return SL_STANDS;
}

/* How fast forces can accelerate any corner of a body, in units of gravity. */
static double corner_rate(const double forces[6], const double mass[6], const double size[3]) {
    double found = 0.0;
    for (int c = 0; c < 3; c++) {
        found += size_of(forces[c]) / root_of(mass[c]);
        found += size_of(forces[3 + c]) / root_of(mass[3 + c]) * size[c];
    }
    return found;
}

/* Lets thin bodies rest whose acceleration is rounding of the forces on them: in a narrow piece,
   which tips fast, it would grow to a fall. */
int drop_rounding(sl_work *work, const Motion *m, double thin) {
    double (*loads)[6] = take_zeros(work, (uint64_t)m->count, sizeof *loads);
    if (!loads) return SL_MEMORY;
    for (int32_t n = 0; n < m->count; n++) loads[n][1] = root_of(m->mass[n][1]);
    for (int32_t column = 0; column < m->columns; column++)
        for (int side = 0; side < 2; side++) {
            int32_t n = m->bodies[column][side];
            for (int c = 0; n >= 0 && c < 6; c++)
                loads[n][c] += m->parts[column] * size_of(m->wrenches[column][side][c]);
        }
    for (int32_t n = 0; n < m->count; n++) {
        const double *low = m->boxes->lower[m->free[n]], *high = m->boxes->upper[m->free[n]];
        double size[3] = {high[0] - low[0], high[1] - low[1], high[2] - low[2]};
        if (!(least(least(size[0], size[1]), size[2]) < thin)) continue;
        double rate = corner_rate(m->rest[n], m->mass[n], size);
        if (rate <= RESIDUE * corner_rate(loads[n], m->mass[n], size))
            memset(m->rest[n], 0, sizeof *m->rest);
    }
    return SL_STANDS;
}

/* The side below which a body that tips within a time grows by more than 1 / RESIDUE: one that tips
   over a side departs as exp(t sqrt(3 g / 2 side)) at most. */
double thin_side(double gravity, double left) {
    double turns = left / logarithm_of(RESIDUE);
    return 1.5 * gravity * (turns * turns);
}
