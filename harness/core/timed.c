/* Loading step by step, where boxes that lose their balance are followed for some time.

   A step is looked at only as far as it changes something. Where the new weight is passed down to
   boxes at rest, and nothing of the group is out of balance, the step is stable. Where something
   is, its motion is asked for; the answer is kept until another group joins it, until a new weight
   is passed down to what moves or to what that leans on, or until a new box touches what moves or
   stands where it came along. Called by timed_api.c; motion.c follows the boxes. */
#include "elementary.h"
#include "timed.h"

/* Makes room for what is known of the motions of a loading that is laid out. */
int begin_to_follow(sl_timed *t) {
    sl_work *work = t->work;
    Boxes *b = &t->boxes;
    uint64_t many = (uint64_t)b->count;
    b->pressing = take_zeros(work, (uint64_t)b->contacts.size, sizeof *b->pressing);
    t->pushes = take_zeros(work, (many + 1) * (many + 1), sizeof *t->pushes);
    t->answers = take_zeros(work, many, sizeof *t->answers);
    t->solved = take_zeros(work, many, sizeof *t->solved);
    t->leans = take_zeros(work, many, sizeof *t->leans);
    t->farthest = take_zeros(work, many, sizeof *t->farthest);
    t->beyond = take_zeros(work, many, sizeof *t->beyond);
    t->counts[0] = t->counts[1] = 0;
    t->spent[0] = 0.0, t->spent[1] = (double)INFINITY;
    bool good = b->pressing && t->pushes && t->answers && t->solved && t->leans && t->farthest &&
                t->beyond;
    return good ? SL_STANDS : SL_MEMORY;
}

/* Whether a box that moved touches the new one, or came as far as that. */
static bool meets(const sl_timed *t, int32_t item, int32_t new) {
    const double *low = t->boxes.lower[item], *high = t->boxes.upper[item];
    const double *new_low = t->boxes.lower[new], *new_high = t->boxes.upper[new];
    for (int axis = 0; axis < 3; axis++) {
        int b = (axis + 1) % 3, c = (axis + 2) % 3;
        if (!(least(high[b], new_high[b]) - most(low[b], new_low[b]) > TOLERANCE &&
              least(high[c], new_high[c]) - most(low[c], new_low[c]) > TOLERANCE)) continue;
        double ahead = new_low[axis] - high[axis], behind = low[axis] - new_high[axis];
        const double *came = t->farthest[item][axis];
        if (-TOLERANCE <= ahead && ahead <= came[0] + 3.0 * TOLERANCE) return true;
        if (-TOLERANCE <= behind && behind <= came[1] + 3.0 * TOLERANCE) return true;
    }
    return false;
}

/* Whether the new weight is passed down by a box. */
static bool is_loaded(const sl_timed *t, int32_t item) {
    const Contacts *c = &t->boxes.contacts;
    for (int32_t k = c->starts[item]; k < c->ends[item]; k++)
        if (t->boxes.changed[k][0] != 0.0) return true;
    return false;
}

/* Whether the last motion of a group is that of the group with its new box, too. */
static bool is_kept(const sl_timed *t, int32_t step, Some group) {
    int32_t answer = 0;
    for (int32_t n = 0; n < group.count; n++) {
        int32_t item = group.of[n];
        if (item != step) {
            if (answer == 0) answer = t->answers[item];
            if (t->answers[item] != answer || answer == 0) return false; /* not joined then */
        }
        if ((t->leans[item] || t->solved[item]) && is_loaded(t, item)) return false;
    }
    return true;
}

static bool any_moves(const sl_timed *t, Some group) {
    for (int32_t n = 0; n < group.count; n++)
        if (t->boxes.moves[group.of[n]]) return true;
    return false;
}

/* Passes the weight of a box down, if nothing stands on it; SL_FAILS where that does not do. */
static int pass_new_down(sl_timed *t, int32_t step) {
    Boxes *boxes = &t->boxes;
    const Contacts *c = &boxes->contacts;
    Some items;
    memset(boxes->changed, 0, (size_t)c->size * sizeof *boxes->changed);
    if (carries_any(c, step)) return SL_FAILS;
    int ended = pass_down(t->work, boxes, step, &items);
    if (!ended) keep_presses(boxes, items, step);
    return ended;
}

/* Places a box: SL_FAILS with its group where something of that is out of balance, and whether its
   last motion is that with the new box, too. */
int moving_group(sl_timed *t, int32_t step, bool *kept, Some *group) {
    const Contacts *c = &t->boxes.contacts;
    *kept = false, group->count = 0;
    for (int32_t item = 0; item < step; item++) /* on the floor or in another group, too */
        if (t->solved[item] && meets(t, item, step)) t->answers[item] = 0;
    if (c->on_floor[step]) return SL_STANDS;
    int passed = pass_new_down(t, step), ended = passed;
    if (passed == SL_MEMORY) return passed;
    Some all = {0, NULL};
    if (join_group(t->work, &t->boxes, step, &all)) return SL_MEMORY;
    if (passed == SL_STANDS) {
        if (!any_moves(t, all)) return SL_STANDS;
        *kept = is_kept(t, step, all);
        for (int32_t n = 0; *kept && n < all.count; n++)
            if (t->answers[all.of[n]] > t->answers[step]) t->answers[step] = t->answers[all.of[n]];
    } else {
        int32_t item;
        ended = balance_group(t->work, &t->boxes, step, all, &item);
        if (ended != SL_FAILS) return ended;
    }
    *group = all;
    return SL_FAILS;
}

/* How far the left-bottom-back corner of a box comes along an axis [cm]. */
static double corner_way(const Motion *m, int32_t item) {
    const double *way = m->way[item], *turn = way + 3;
    const double *low = m->boxes->lower[item], *centre = m->boxes->centres[item];
    double x = low[0] - centre[0], y = low[1] - centre[1], z = low[2] - centre[2];
    double dx = size_of(way[0] + turn[1] * z - turn[2] * y);
    double dy = size_of(way[1] + turn[2] * x - turn[0] * z);
    double dz = size_of(way[2] + turn[0] * y - turn[1] * x);
    return most(dz, most(dy, dx));
}

/* Keeps what a motion said of the boxes of a group; the one that comes farthest. */
static void keep_answer(sl_timed *t, const Motion *m, sl_moved *found) {
    int32_t answer = 0;
    double top = -1.0, eps_t = most(1e-12, m->how->eps_t), eps_r = most(1e-12, m->how->eps_r);
    for (int32_t j = 0; j < t->boxes.count; j++)
        if (t->answers[j] > answer) answer = t->answers[j];
    for (int32_t n = 0; n < m->group.count; n++) { /* of equally far ones the first is named */
        int32_t item = m->group.of[n];
        const double *turn = m->way[item] + 3;
        t->answers[item] = answer + 1;
        t->solved[item] = m->role[item] != AT_EASE;
        t->leans[item] = m->leans[item];
        memcpy(t->farthest[item], m->farthest[item], sizeof *t->farthest);
        double far = corner_way(m, item);
        double angle = most(size_of(turn[2]), most(size_of(turn[1]), size_of(turn[0])));
        angle *= 180.0 / PI;
        double beyond = most(angle / eps_r, far / eps_t);
        if (!(beyond * (1.0 - TIE) > top)) continue;
        found->item = item, found->shift = far, found->turn = least(180.0, angle), top = beyond;
    }
    for (int32_t n = 0; n < m->group.count; n++) t->beyond[m->group.of[n]] = top;
    found->beyond = top;
}

/* Asks for the motion of a group of which something is out of balance. */
int moved_group(sl_timed *t, int32_t step, Some group, const sl_how *how, sl_moved *found) {
    const Boxes *boxes = &t->boxes;
    /* How far a corner can come before its box counts as moved. */
    double turned = 2.0 * sine_of(0.5 * (least(180.0, how->eps_r) * (PI / 180.0)));
    double widest = 0.0;
    for (int32_t n = 0; n < group.count; n++) {
        const double *low = boxes->lower[group.of[n]], *high = boxes->upper[group.of[n]];
        double a = high[0] - low[0], b = high[1] - low[1], c = high[2] - low[2];
        widest = most(a * a + b * b + c * c, widest);
    }
    Motion m = {.boxes = boxes, .how = how, .step = step, .group = group,
                .reach = how->eps_t + turned * root_of(widest)};
    *found = (sl_moved){.step = step, .item = -1};
    found->ended = follow(t, &m);
    if (found->ended == SL_MEMORY) return found->ended;
    t->counts[1]++;
    if (found->ended) return found->ended;
    keep_answer(t, &m, found);
    return found->ended = SL_FAILS;
}

int place_next(sl_timed *t, int32_t step, const sl_how *how, sl_moved *found) {
    bool kept;
    Some group;
    Mark before = mark(t->work);
    *found = (sl_moved){.step = step, .item = -1};
    found->ended = moving_group(t, step, &kept, &group);
    if (found->ended == SL_FAILS) {
        if (!kept) moved_group(t, step, group, how, found);
        else t->counts[0]++, found->ended = SL_STANDS;
    }
    free_to(t->work, before);
    return found->ended;
}

int first_moved(sl_timed *t, int32_t first, int32_t end, const sl_how *how, sl_moved *found) {
    for (int32_t step = first; step < end; step++) {
        int ended = place_next(t, step, how, found);
        if (!(ended == SL_STANDS || ended == SL_FAILS) || found->beyond > 1.0) return ended;
    }
    *found = (sl_moved){.ended = SL_STANDS, .step = end, .item = -1};
    return SL_STANDS;
}
