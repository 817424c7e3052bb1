/* The margin of balance of a whole layout, sl_margin of steadyload.h, in little more than one pass
   of equilibrium. */
#include "internal.h"

#define FINEST 1e-3   /* [cm] a margin is known so closely */
#define FARTHEST 1e6  /* [cm] beyond this rounding would keep a halving from that */

typedef struct { double (*whole)[4], margin; int32_t at, first; } Search;

static void redraw(Contacts *c, const Search *s, double margin) {
    if (c->size) memcpy(c->patches, s->whole, (size_t)c->size * sizeof *c->patches);
    draw_in(c->patches, c->size, margin);
}

/* Halves the margin of a step that is not balanced there; the items whose forces changed last. */
static int halve(sl_work *work, Boxes *boxes, int32_t step, int32_t item, Search *s, Some *items) {
    double low = 0.0, high = s->margin;
    Mark before = mark(work);
    s->first = item, s->at = step, s->margin = 0.0;
    for (;; free_to(work, before)) {
        redraw(&boxes->contacts, s, s->margin);
        int ended = balance_after(work, boxes, step, &item, items);
        if (ended == SL_MEMORY) return ended;
        if (ended == SL_STANDS) {
            if (high - s->margin <= FINEST) return ended;
            low = s->margin;
        } else if (s->margin == 0.0) {
            s->first = item;
            return ended;
        } else {
            high = s->margin, s->first = item;
        }
        /* The last look is at a margin that holds, whose forces are kept. */
        s->margin = high - low > FINEST ? 0.5 * (low + high) : low;
    }
}

/* Each step is tried at the least margin of the steps before it, whose forces hold at every smaller
   margin, too; only a step that fails there is halved. */
static int search(sl_work *work, Boxes *boxes, Search *s) {
    Contacts *c = &boxes->contacts;
    s->whole = take(work, (uint64_t)c->size, sizeof *s->whole);
    if (!s->whole) return SL_MEMORY;
    if (c->size) memcpy(s->whole, c->patches, (size_t)c->size * sizeof *s->whole);
    redraw(c, s, s->margin);
    Mark before = mark(work);
    for (int32_t step = 0; step < boxes->count; step++, free_to(work, before)) {
        double own = most(inset(boxes, step), 0.0);
        if (c->on_floor[step] && own < s->margin) {
            s->margin = own, s->at = s->first = step;
            redraw(c, s, s->margin);
        }
        Some items = {0, NULL};
        int32_t item;
        int ended = balance_after(work, boxes, step, &item, &items);
        if (ended == SL_MEMORY) return ended;
        if (ended) {
            free_to(work, before);
            ended = halve(work, boxes, step, item, s, &items);
        }
        if (ended) return ended;
        keep_presses(boxes, items, step);
    }
    return SL_STANDS;
}

int32_t sl_margin(sl_work *work, double limit, int32_t count, const double *lower,
                  const double *upper, const double *weights, const double *offsets,
                  const double *floor, sl_finding *found) {
    *found = (sl_finding){SL_REFUSED, count, -1, 0, 0.0};
    if (count < 0 || count > SL_MOST || !(limit >= 0.0 && limit <= FARTHEST)) return SL_REFUSED;
    Mark before = mark(work);
    Boxes boxes = boxes_of(count, lower, upper, weights, offsets, floor);
    Search s = {NULL, limit, -1, -1};
    int ended = lay_out(work, &boxes, 0.0);
    if (!ended) ended = search(work, &boxes, &s);
    free_to(work, before);
    found->step = s.at, found->item = s.first, found->number = ended ? 0.0 : s.margin;
    return found->ended = ended;
}
