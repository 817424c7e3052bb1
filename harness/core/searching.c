/* Boxes loaded at given places, each as soon as it stands, in nearly the order of a plan: the
   loadings of searching.h, on top of a session. */
#include "searching.h"

#define UNREACHED 9  /* how a box ended that cannot be let down to its place, or may not be there */

/* Turns of boxes, by their numbers: where they were tried and with which margin; how many were
   loaded and how many waited before, and, one turn after the other, which of them waited. */
struct sl_loading {
    sl_session *session;
    /* next to have its turn, how many wait, which is tried next */
    int32_t count, next, stuck, again;
    bool looking;                      /* it is to be said whether the last box stays */
    double (*tried)[5];
    int32_t *loaded, *waited, *order, *waiting, *then;
    int64_t *then_starts, then_room;
};

static bool is_same(const double *one, const double *other) {
    return one[0] == other[0] && one[1] == other[1] && one[2] == other[2] && one[3] == other[3];
}

static bool is_refused(const sl_wishes *wishes, int32_t box, const double *place) {
    for (int32_t k = 0; k < wishes->refused_count; k++) {
        const double *refused = wishes->refused + 5 * (size_t)k;
        if (refused[0] == box && is_same(refused + 1, place)) return true;
    }
    return false;
}

/* The margin of a box at its place; infinite where it may not be there. */
static double margin_of(const sl_boxes *boxes, const sl_wishes *wishes, int32_t box) {
    const double *place = wishes->places + 4 * (size_t)box;
    if (is_refused(wishes, box, place)) return __builtin_inf();
    bool is_moved = !is_same(place, boxes->planned + 4 * (size_t)box);
    return wishes->margins[(is_moved ? (size_t)boxes->count : 0) + (size_t)box];
}

/* A box at a place, as a session has it. */
static void write_box(const sl_boxes *boxes, int32_t box, const double *place, double made[10]) {
    size_t at = 3 * ((place[3] == TURNED ? (size_t)boxes->count : 0) + (size_t)box);
    memcpy(made, place, 3 * sizeof *made);
    memcpy(made + 3, boxes->sides + at, 3 * sizeof *made);
    memcpy(made + 6, boxes->offsets + at, 3 * sizeof *made);
    made[9] = boxes->weights[box];
}

sl_loading *sl_loading_new(const double *limits, int32_t count) {
    uint64_t many = (uint64_t)count + 1;
    sl_loading *l = count < 0 || count > SL_MOST ? NULL : allocate(sizeof *l);
    if (!l) return NULL;
    memset(l, 0, sizeof *l);
    l->count = count, l->again = -1;
    l->session = sl_session_new(limits);
    if (l->session && widen(&l->tried, 0, many, sizeof *l->tried) &&
        widen(&l->loaded, 0, many, sizeof *l->loaded) &&
        widen(&l->waited, 0, many, sizeof *l->waited) &&
        widen(&l->order, 0, many, sizeof *l->order) &&
        widen(&l->waiting, 0, many, sizeof *l->waiting) &&
        widen(&l->then_starts, 0, many, sizeof *l->then_starts)) return l;
    sl_loading_free(l);
    return NULL;
}

void sl_loading_free(sl_loading *l) {
    if (!l) return;
    void *all[] =
        {l->tried, l->loaded, l->waited, l->order, l->waiting, l->then, l->then_starts, l};
    sl_session_free(l->session);
    for (size_t k = 0; k < sizeof all / sizeof *all; k++) free(all[k]);
}

/* Before the turn of a box that had one. */
static void go_back(sl_loading *l, int32_t box) {
    sl_cut(l->session, l->loaded[box]);
    l->stuck = l->waited[box];
    if (l->stuck)
        memcpy(l->waiting, l->then + l->then_starts[box], (size_t)l->stuck * sizeof *l->waiting);
    l->next = box, l->again = -1, l->looking = false;
}

static bool is_for(const sl_loading *l, const sl_boxes *boxes, const sl_wishes *wishes) {
    return boxes->count == l->count && wishes->refused_count >= 0;
}

int32_t sl_load_begin(sl_loading *l, const sl_boxes *boxes, const sl_wishes *wishes,
                      int32_t first) {
    if (!is_for(l, boxes, wishes) || first < 0) return SL_REFUSED;
    if (l->looking && sl_looked_at(l) < first) first = sl_looked_at(l);
    for (int32_t box = 0; box < first && box < l->next; box++)
        if (!is_same(l->tried[box], wishes->places + 4 * (size_t)box) ||
            l->tried[box][4] != margin_of(boxes, wishes, box)) first = box;
    if (first < l->next) go_back(l, first);
    return SL_STANDS;
}

/* Whether a box can be let down to where it was tried. */
static bool is_reachable(const sl_loading *l, const sl_boxes *boxes, int32_t box,
                         const double *at) {
    const sl_session *s = l->session;
    const double *planned = boxes->planned;
    bool as_planned = is_same(l->tried[box], planned + 4 * (size_t)box);
    double x1 = at[0] + at[3], top = at[1] + at[4], z1 = at[2] + at[5];
    for (int32_t k = 0; k < s->boxes.count; k++) {
        const double *low = s->boxes.lower[k], *high = s->boxes.upper[k];
        if (low[1] < top - TOLERANCE) continue;
        double across = least(high[0], x1) - most(low[0], at[0]);
        double along = least(high[2], z1) - most(low[2], at[2]);
        if (least(across, along) <= TOLERANCE) continue;
        int32_t other = l->order[k];
        if (other > box || !as_planned) return false;
        if (!is_same(l->tried[other], planned + 4 * (size_t)other)) return false;
    }
    return true;
}

/* Puts a box on if it stands at its place; how it ended. */
static int put(sl_loading *l, const sl_boxes *boxes, int32_t box) {
    const double *tried = l->tried[box];
    double at[10];
    sl_finding found;
    if (tried[4] == __builtin_inf()) return UNREACHED;
    write_box(boxes, box, tried, at);
    if (!is_reachable(l, boxes, box, at)) return UNREACHED;
    return try_box(l->session, at, SL_BALANCED, tried[4], true, &found);
}

/* Notes whether a box stands that was tried. */
static void note(sl_loading *l, int32_t box, bool stands, bool reorder) {
    if (stands) {
        l->order[l->session->boxes.count - 1] = box;
        if (l->again >= 0) {
            l->stuck--;
            for (int32_t k = l->again; k < l->stuck; k++) l->waiting[k] = l->waiting[k + 1];
        }
        l->again = reorder ? 0 : -1;
    } else if (l->again >= 0) {
        l->again++;
    } else {
        l->waiting[l->stuck++] = box;
    }
}

/* Begins the turn of a box; false without memory. */
static bool begin_turn(sl_loading *l, const sl_boxes *boxes, const sl_wishes *wishes,
                       int32_t box) {
    int64_t start = box ? l->then_starts[box - 1] + l->waited[box - 1] : 0;
    if (start + l->stuck > l->then_room) {
        int64_t room = 2 * (start + l->stuck);
        if (!widen(&l->then, (uint64_t)start, (uint64_t)room, sizeof *l->then)) return false;
        l->then_room = room;
    }
    if (l->stuck) memcpy(l->then + start, l->waiting, (size_t)l->stuck * sizeof *l->then);
    memcpy(l->tried[box], wishes->places + 4 * (size_t)box, 4 * sizeof **l->tried);
    l->tried[box][4] = margin_of(boxes, wishes, box);
    l->then_starts[box] = start, l->waited[box] = l->stuck;
    l->loaded[box] = l->session->boxes.count;
    l->next = box + 1;
    return true;
}

int32_t sl_load(sl_loading *l, const sl_boxes *boxes, const sl_wishes *wishes, int32_t reorder,
                int32_t looks) {
    if (!is_for(l, boxes, wishes) || l->looking) return SL_REFUSED;
    for (;;) {
        int32_t box = l->next;
        if (l->again >= l->stuck) l->again = -1;
        if (l->again >= 0) {
            box = l->waiting[l->again];
        } else {
            if (box == l->count) return SL_STANDS;
            if (!begin_turn(l, boxes, wishes, box)) break;
            if (wishes->places[4 * (size_t)box + 3] == LEFT_OUT) continue;
        }
        int ended = put(l, boxes, box);
        if (ended == SL_MEMORY) break;
        if (ended == SL_STANDS && looks) return l->looking = true, SL_LOOK;
        note(l, box, ended == SL_STANDS, reorder != 0);
    }
    sl_cut(l->session, 0);
    l->next = l->stuck = 0, l->again = -1;
    return SL_MEMORY;
}

int32_t sl_looked_at(const sl_loading *l) {
    if (!l->looking) return -1;
    return l->again >= 0 ? l->waiting[l->again] : l->next - 1;
}

int32_t sl_said(sl_loading *l, int32_t stays, int32_t reorder) {
    int32_t box = sl_looked_at(l);
    if (box < 0) return SL_REFUSED;
    if (!stays) sl_cut(l->session, l->session->boxes.count - 1);
    note(l, box, stays != 0, reorder != 0);
    l->looking = false;
    return SL_STANDS;
}

void sl_loaded(const sl_loading *l, int32_t *order, int32_t *waiting, int32_t *counts) {
    counts[0] = l->session->boxes.count - l->looking, counts[1] = l->stuck;
    if (order && counts[0]) memcpy(order, l->order, (size_t)counts[0] * sizeof *order);
    if (waiting && l->stuck) memcpy(waiting, l->waiting, (size_t)l->stuck * sizeof *waiting);
}

void sl_tried(const sl_loading *l, double *tried) {
    if (l->count) memcpy(tried, l->tried, (size_t)l->count * sizeof *l->tried);
}

int32_t sl_first_standing(sl_loading *l, const sl_boxes *boxes, const sl_wishes *wishes,
                          int32_t box, double margin, int32_t count, const double *places,
                          int32_t most, int32_t *found) {
    int32_t size = 0;
    if (!is_for(l, boxes, wishes) || box < 0 || box >= l->count) return -SL_REFUSED;
    for (int32_t k = 0; k < count && size < most; k++) {
        const double *place = places + 4 * (size_t)k;
        double at[10];
        sl_finding ended;
        if (is_same(place, boxes->planned + 4 * (size_t)box)) continue;
        if (is_refused(wishes, box, place)) continue;
        write_box(boxes, box, place, at);
        try_box(l->session, at, SL_BALANCED, margin, false, &ended);
        if (ended.ended == SL_MEMORY) return -SL_MEMORY;
        if (ended.ended == SL_STANDS) found[size++] = k;
    }
    return size;
}

void sl_cost(const sl_boxes *boxes, const double *places, double *cost) {
    cost[0] = cost[1] = cost[2] = cost[3] = 0.0;
    for (int32_t box = 0; box < boxes->count; box++) {
        const double *place = places + 4 * (size_t)box, *planned = boxes->planned + 4 * (size_t)box;
        const double *own = boxes->sides + 3 * (size_t)box;
        if (place[3] == LEFT_OUT) {
            cost[0] += 1.0, cost[1] += boxes->volumes[box];
        } else if (!is_same(place, planned)) {
            const double *side = own + (place[3] == TURNED ? 3 * (size_t)boxes->count : 0);
            double squares = 0.0;
            for (int axis = 0; axis < 3; axis++) {
                double to = place[axis] + 0.5 * side[axis];
                double way = to - (planned[axis] + 0.5 * own[axis]);
                squares += way * way;
            }
            cost[2] += 1.0, cost[3] += root_of(squares);
        }
    }
}
