/* Motion of a group of boxes that lost its balance, over a given time: a model, no simulation.

   Rigid boxes, contacts that neither stretch nor give. The model goes from event to event. At every
   event the group is at rest, and its accelerations follow from Gauss' principle of least
   constraint, as the residue of a non-negative least-squares problem for the contact forces. Until
   the next event, a gap that closes and takes all speed away, the boxes that push each other go on
   as one pendulum does (pendulums.c). Boxes that stay at rest are not solved for (carrying.c).
   Called by timed.c. */
#include "timed.h"

/* Mass and moments of inertia of a box. */
static void put_mass(double row[6], double mass, const double lower[3], const double upper[3]) {
    double a = upper[0] - lower[0], b = upper[1] - lower[1], c = upper[2] - lower[2];
    row[0] = row[1] = row[2] = mass;
    row[3] = mass / 12.0 * (b * b + c * c);
    row[4] = mass / 12.0 * (a * a + c * c);
    row[5] = mass / 12.0 * (a * a + b * b);
}

/* The boxes that are free now: masses in units of their mean. */
static int find_free(sl_work *work, Motion *m) {
    const Boxes *boxes = m->boxes;
    int32_t count = 0;
    m->place = take(work, (uint64_t)boxes->count, sizeof *m->place);
    if (!m->place) return SL_MEMORY;
    for (int32_t j = 0; j < boxes->count; j++) m->place[j] = m->role[j] == FREE ? count++ : -1;
    m->count = count, m->mean = 0.0;
    m->free = take(work, (uint64_t)count, sizeof *m->free);
    m->mass = take(work, (uint64_t)count, sizeof *m->mass);
    if (!m->free || !m->mass) return SL_MEMORY;
    for (int32_t j = 0; j < boxes->count; j++)
        if (m->place[j] >= 0) m->free[m->place[j]] = j;
    for (int32_t n = 0; n < count; n++) m->mean += boxes->weights[m->free[n]] / count;
    for (int32_t n = 0; n < count; n++) {
        int32_t j = m->free[n];
        put_mass(m->mass[n], boxes->weights[j] / m->mean, boxes->lower[j], boxes->upper[j]);
    }
    return SL_STANDS;
}

/* Points now: they go with their first body; those on what is at rest stay. */
static int find_positions(sl_work *work, Motion *m) {
    const Points *p = &m->points;
    m->at = take(work, (uint64_t)p->count, sizeof *m->at);
    if (!m->at) return SL_MEMORY;
    for (int32_t k = 0; k < p->count; k++) {
        int32_t body = p->pairs[k][0];
        double *at = m->at[k];
        memcpy(at, p->planned[k], sizeof *m->at);
        if (body < 0 || m->place[body] < 0) continue;
        const double *centre = m->boxes->centres[body], *way = m->way[body], *turn = way + 3;
        double x = at[0] - centre[0], y = at[1] - centre[1], z = at[2] - centre[2];
        at[0] += way[0] + turn[1] * z - turn[2] * y;
        at[1] += way[1] + turn[2] * x - turn[0] * z;
        at[2] += way[2] + turn[0] * y - turn[1] * x;
    }
    return SL_STANDS;
}

/* Adds up the loads of free bodies on those of the group that are at rest. */
static void load_others(Motion *m) {
    memset(m->loads, 0, (size_t)m->boxes->count * sizeof *m->loads);
    for (int32_t column = 0; column < m->columns; column++) {
        if (!(m->parts[column] > 0.0)) continue;
        int32_t k = m->sources[column] / 4;
        const double *at = m->at[k], *force = m->forces[column];
        for (int side = 0; side < 2; side++) {
            int32_t body = m->points.pairs[k][side];
            if (body == FLOOR || m->place[body] >= 0 || !m->within[body]) continue;
            double x = at[0], y = at[1], z = at[2], a = force[0], b = force[1], c = force[2];
            double load[6] = {a, b, c, y * c - z * b, z * a - x * c, x * b - y * a};
            double sign = side == 1 ? 1.0 : -1.0;
            for (int i = 0; i < 6; i++)
                m->loads[body][i] += sign * m->parts[column] * m->mean * load[i];
        }
    }
}

/* Boxes at rest whose load may be another one now: on, below or beside free ones. */
static void wake(Motion *m) {
    const Contacts *c = &m->boxes->contacts;
    double (*presses)[3] = m->boxes->presses;
    for (int32_t item = 0; item <= m->step; item++) {
        if (!m->within[item] || m->role[item] != AT_EASE) continue;
        for (int i = 0; i < 6; i++)
            if (m->loads[item][i] != 0.0) m->role[item] = PENDING;
    }
    for (int32_t n = 0; n < m->count; n++) {
        int32_t item = m->free[n];
        for (int32_t k = c->starts[item]; k < c->ends[item]; k++) {
            int32_t carrier = c->below[k];
            if (carrier == FLOOR || carrier > m->step || !m->within[carrier]) continue;
            if (m->role[carrier] == AT_EASE && presses[k][0] != 0.0) m->role[carrier] = PENDING;
        }
        for (int32_t k = c->above_starts[item]; k < c->above_ends[item]; k++) {
            int32_t other = c->above[k];
            if (other <= m->step && m->role[other] == AT_EASE && presses[c->meets[k]][0] != 0.0)
                m->role[other] = PENDING;
        }
    }
}

/* Forgets what was passed on; free boxes stay so. */
static void forget(Motion *m) {
    for (int32_t j = 0; j < m->boxes->count; j++)
        if (m->role[j] != FREE) m->role[j] = AT_EASE;
}

/* Enlarges how far any corner of a body came along every axis. */
static void put_farthest(double farthest[3][2], const double way[6], const double centre[3],
                         const double lower[3], const double upper[3]) {
    for (int axis = 0; axis < 3; axis++) {
        int b = (axis + 1) % 3, c = (axis + 2) % 3;
        /* Along an axis, a turn moves a corner by t_b l_c - t_c l_b. */
        double tb = way[3 + b], tc = way[3 + c], *own = farthest[axis];
        double one = tb * (lower[c] - centre[c]), two = tb * (upper[c] - centre[c]);
        double three = tc * (lower[b] - centre[b]), four = tc * (upper[b] - centre[b]);
        own[0] = most(way[axis] + most(two, one) - least(four, three), own[0]);
        own[1] = most(-way[axis] - least(two, one) + most(four, three), own[1]);
    }
}

/* The bits of the forces between the bodies of a point at the last start. */
static uint16_t *pushes_at(sl_timed *timed, const Motion *m, int32_t point) {
    size_t rows = (size_t)timed->boxes.count + 1;
    const int32_t *pair = m->points.pairs[point];
    size_t first = pair[0] < 0 ? rows - 1 : (size_t)pair[0];
    return timed->pushes + first * rows + (size_t)pair[1];
}

/* Lists the points of boxes that are free now, with what pushed there at the last start. */
static int list_new_points(sl_timed *timed, Motion *m) {
    int32_t recalled = m->points.count;
    for (int32_t n = 0; n < m->group.count; n++) {
        int32_t item = m->group.of[n];
        if (m->role[item] == FREE && !m->listed[item] && list_points(timed->work, m, item))
            return SL_MEMORY;
    }
    for (int32_t k = recalled; k < m->points.count; k++)
        for (int edge = 0; edge < 4; edge++)
            m->points.pushed[k][edge] = *pushes_at(timed, m, k) >> (4 * (k % 4) + edge) & 1;
    return SL_STANDS;
}

static void note_pushes(sl_timed *timed, const Motion *m) {
    for (int32_t k = 0; k < m->points.count; k++) *pushes_at(timed, m, k) = 0;
    for (int32_t column = 0; column < m->columns; column++)
        if (m->parts[column] > 0.0) {
            int32_t source = m->sources[column];
            *pushes_at(timed, m, source / 4) |= (uint16_t)(1u << source % 16);
        }
}

/* Forces at one moment: boxes at rest are freed until all others can carry what presses on them.
   All that is found is in memory taken behind `top`, which moves as points need more of it. */
static int solve_moment(sl_timed *timed, Motion *m, Mark *top) {
    sl_work *work = timed->work;
    for (;;) {
        int32_t failed;
        free_to(work, *top);
        if (list_new_points(timed, m)) return SL_MEMORY;
        *top = mark(work);
        if (find_free(work, m)) return SL_MEMORY;
        timed->spent[0] += (double)m->count * (double)m->count;
        if (timed->spent[0] > timed->spent[1]) return SL_UNDECIDED;
        if (find_positions(work, m) || find_wrenches(work, m)) return SL_MEMORY;
        int ended = find_least_forces(work, m);
        if (ended) return ended;
        memset(m->points.pushed, 0, (size_t)m->points.count * sizeof *m->points.pushed);
        for (int32_t column = 0; column < m->columns; column++)
            if (m->parts[column] > 0.0)
                m->points.pushed[m->sources[column] / 4][m->sources[column] % 4] = true;
        load_others(m);
        wake(m);
        if (pass_on_loads(work, m, &failed)) return SL_MEMORY;
        if (failed < 0) return SL_STANDS;
        forget(m);
        free_with_those_above(&m->boxes->contacts, m->role, m->step, failed);
    }
}

/* Moves to the next event, or through the time that is left; the time passed. */
static int advance(sl_work *work, Motion *m, double left, double *passed) {
    double gravity = m->how->gravity;
    double (*rates)[6] = take(work, (uint64_t)m->count, sizeof *rates);
    double *growth = take(work, (uint64_t)m->count, sizeof *growth);
    if (!rates || !growth || drop_rounding(work, m, thin_side(gravity, left))) return SL_MEMORY;
    for (int32_t n = 0; n < m->count; n++)
        for (int c = 0; c < 6; c++) rates[n][c] = -gravity * m->rest[n][c] / root_of(m->mass[n][c]);
    if (find_growth(work, m, (const double (*)[6])rates, growth)) return SL_MEMORY;
    return coast(work, m, (const double (*)[6])rates, growth, left, passed);
}

static int take_room(sl_work *work, Motion *m) {
    uint64_t count = (uint64_t)m->boxes->count;
    m->role = take_zeros(work, count, sizeof *m->role);
    m->within = take_zeros(work, count, sizeof *m->within);
    m->listed = take_zeros(work, count, sizeof *m->listed);
    m->leans = take_zeros(work, count, sizeof *m->leans);
    m->way = take_zeros(work, count, sizeof *m->way);
    m->farthest = take_zeros(work, count, sizeof *m->farthest);
    m->loads = take(work, count, sizeof *m->loads);
    m->pressed = take(work, (uint64_t)m->boxes->contacts.size, sizeof *m->pressed);
    if (!m->role || !m->within || !m->listed || !m->leans || !m->way || !m->farthest || !m->loads ||
        !m->pressed) return SL_MEMORY;
    return make_room_for_points(work, &m->points, 64 * (int64_t)m->group.count);
}

/* Follows the boxes of a group that are out of balance, from rest. SL_UNRESOLVED where a search for
   forces did not end, SL_UNDECIDED where more work is not allowed. */
int follow(sl_timed *timed, Motion *m) {
    sl_work *work = timed->work;
    double left = m->how->seconds;
    if (take_room(work, m)) return SL_MEMORY;
    for (int32_t n = 0; n < m->group.count; n++) {
        m->within[m->group.of[n]] = true;
        if (timed->boxes.moves[m->group.of[n]]) m->role[m->group.of[n]] = FREE;
    }
    Mark top = mark(work);
    for (int event = 0; event < EVENTS; event++) {
        double passed;
        int ended = solve_moment(timed, m, &top);
        if (ended) return ended;
        for (int32_t n = 0; n < m->group.count; n++) {
            int32_t item = m->group.of[n];
            m->leans[item] = m->leans[item] || m->role[item] == PASSED || m->role[item] == PENDING;
        }
        forget(m);
        if (event == 0) note_pushes(timed, m);
        if (advance(work, m, left, &passed)) return SL_MEMORY;
        left -= passed;
        for (int32_t n = 0; n < m->count; n++) {
            int32_t item = m->free[n];
            put_farthest(m->farthest[item], m->way[item], m->boxes->centres[item],
                         m->boxes->lower[item], m->boxes->upper[item]);
        }
        if (left <= 0.0) break;
    }
    return SL_STANDS;
}
