/* The public functions of timed.h: loadings that are followed (timed.c), or whose balance alone
   is looked at (balance.c). */
#include "timed.h"

static const double *copy_of(sl_work *work, const double *values, int32_t rows, int columns) {
    uint64_t count = (uint64_t)rows * (uint64_t)columns;
    double *made = take(work, count, sizeof *made);
    if (made && count) memcpy(made, values, (size_t)count * sizeof *made);
    return made;
}

/* Lays out copies of the boxes of a layout. */
static int lay_out_copies(sl_work *work, Boxes *boxes, double margin) {
    int32_t count = boxes->count;
    *boxes = boxes_of(
        count, copy_of(work, (const double *)boxes->lower, count, 3),
        copy_of(work, (const double *)boxes->upper, count, 3),
        copy_of(work, boxes->weights, count, 1),
        copy_of(work, (const double *)boxes->offsets, count, 3),
        copy_of(work, boxes->floor, 1, 5));
    bool good = boxes->lower && boxes->upper && boxes->weights && boxes->offsets && boxes->floor;
    return good ? lay_out(work, boxes, margin) : SL_MEMORY;
}

sl_timed *sl_timed_new(int32_t count, const double *lower, const double *upper,
                       const double *weights, const double *offsets, const double *floor,
                       double margin) {
    if (count < 0 || count > SL_MOST) return NULL;
    sl_timed *timed = allocate(sizeof *timed);
    if (!timed) return NULL;
    timed->work = sl_work_new();
    timed->boxes = boxes_of(count, lower, upper, weights, offsets, floor);
    if (timed->work && !lay_out_copies(timed->work, &timed->boxes, margin) &&
        !begin_to_follow(timed)) return timed;
    sl_timed_free(timed);
    return NULL;
}

void sl_timed_free(sl_timed *timed) {
    if (!timed) return;
    sl_work_free(timed->work);
    free(timed);
}

void sl_timed_look(const sl_timed *timed, sl_timed_view *view) {
    const Boxes *boxes = &timed->boxes;
    const Contacts *c = &boxes->contacts;
    *view = (sl_timed_view){
        .count = boxes->count, .patches = c->size, .starts = c->starts, .ends = c->ends,
        .below = c->below, .above_starts = c->above_starts, .above_ends = c->above_ends,
        .above = c->above, .pressing = (uint8_t *)boxes->pressing, .pushes = timed->pushes,
        .moves = (uint8_t *)boxes->moves, .answers = timed->answers,
        .solved = (uint8_t *)timed->solved, .farthest = (double *)timed->farthest,
        .beyond = timed->beyond, .counts = (int64_t *)timed->counts,
        .work = (double *)timed->spent,
    };
}

static bool is_box(const sl_timed *timed, int32_t item) {
    return item >= 0 && item < timed->boxes.count;
}

int32_t sl_timed_first(sl_timed *timed, int32_t first, int32_t end, const sl_how *how,
                       sl_moved *found) {
    *found = (sl_moved){.ended = SL_REFUSED, .step = first, .item = -1};
    if (first < 0 || end < first || end > timed->boxes.count) return SL_REFUSED;
    return first_moved(timed, first, end, how, found);
}

int32_t sl_timed_group(sl_timed *timed, int32_t step, int32_t *kept, int32_t *size,
                       int32_t *group) {
    *kept = *size = 0;
    if (!is_box(timed, step)) return SL_REFUSED;
    Mark before = mark(timed->work);
    Some found;
    bool is_kept;
    int ended = moving_group(timed, step, &is_kept, &found);
    if (ended == SL_FAILS) {
        *kept = is_kept, *size = found.count;
        memcpy(group, found.of, (size_t)found.count * sizeof *group);
    }
    free_to(timed->work, before);
    return ended;
}

int32_t sl_timed_moved(sl_timed *timed, int32_t step, int32_t size, const int32_t *group,
                       const sl_how *how, sl_moved *found) {
    *found = (sl_moved){.ended = SL_REFUSED, .step = step, .item = -1};
    if (!is_box(timed, step) || size < 0 || size > timed->boxes.count) return SL_REFUSED;
    for (int32_t n = 0; n < size; n++)
        if (!is_box(timed, group[n])) return SL_REFUSED;
    Mark before = mark(timed->work);
    Some all = {size, take(timed->work, (uint64_t)size, sizeof *group)};
    if (all.of) {
        if (size) memcpy(all.of, group, (size_t)size * sizeof *group);
        moved_group(timed, step, all, how, found);
    } else found->ended = SL_MEMORY;
    free_to(timed->work, before);
    return found->ended;
}

int32_t sl_timed_is_near_its_edge(const sl_timed *timed, int32_t item, double margin) {
    return is_box(timed, item) && is_near_its_edge(&timed->boxes, item, margin);
}

int32_t sl_first_moved(sl_work *work, int32_t count, const double *lower, const double *upper,
                       const double *weights, const double *offsets, const double *floor,
                       double limit, const sl_how *how, sl_moved *found) {
    *found = (sl_moved){.ended = SL_REFUSED, .step = count, .item = -1};
    if (count < 0 || count > SL_MOST) return SL_REFUSED;
    Mark before = mark(work);
    sl_timed timed = {.work = work};
    timed.boxes = boxes_of(count, lower, upper, weights, offsets, floor);
    found->ended = SL_MEMORY;
    if (!lay_out(work, &timed.boxes, 0.0) && !begin_to_follow(&timed)) {
        timed.spent[1] = limit;
        first_moved(&timed, 0, count, how, found);
    }
    free_to(work, before);
    return found->ended;
}

int32_t sl_first_moved_many(sl_work *work, int32_t layouts, const int32_t *starts,
                            const double *lower, const double *upper, const double *weights,
                            const double *offsets, const double *floors, double limit,
                            const sl_how *how, sl_moved *found) {
    for (int32_t k = 0; k < layouts; k++) {
        int64_t first = starts[k];
        if (first < 0 || starts[k + 1] < first) return SL_REFUSED;
        int32_t ended = sl_first_moved(
            work, starts[k + 1] - starts[k], lower + 3 * first, upper + 3 * first, weights + first,
            offsets + 3 * first, floors + 5 * (int64_t)k, limit, how, found + k);
        if (ended == SL_MEMORY || ended == SL_REFUSED) return ended;
    }
    return SL_STANDS;
}

struct sl_held { sl_work *work; Boxes boxes; };

sl_held *sl_held_new(int32_t count, const double *lower, const double *upper,
                     const double *weights, const double *offsets, const double *floor,
                     double margin) {
    if (count < 0 || count > SL_MOST) return NULL;
    sl_held *held = allocate(sizeof *held);
    if (!held) return NULL;
    held->work = sl_work_new();
    held->boxes = boxes_of(count, lower, upper, weights, offsets, floor);
    if (held->work && !lay_out_copies(held->work, &held->boxes, margin)) {
        held->boxes.solve_all = true;
        return held;
    }
    sl_held_free(held);
    return NULL;
}

void sl_held_free(sl_held *held) {
    if (!held) return;
    sl_work_free(held->work);
    free(held);
}

int32_t sl_held_place(sl_held *held, int32_t step, int32_t *item) {
    Boxes *boxes = &held->boxes;
    *item = -1;
    if (step < 0 || step >= boxes->count) return SL_REFUSED;
    Mark before = mark(held->work);
    Some items;
    int ended = balance_after(held->work, boxes, step, item, &items);
    if (ended == SL_STANDS) {
        keep_presses(boxes, items, step);
        for (int32_t n = 0; n < items.count; n++) boxes->moves[items.of[n]] = false;
    } else if (ended == SL_FAILS) {
        if (join_group(held->work, boxes, step, &items)) ended = SL_MEMORY;
        for (int32_t n = 0; ended == SL_FAILS && n < items.count; n++)
            boxes->moves[items.of[n]] = true;
    }
    free_to(held->work, before);
    return ended;
}

int32_t sl_held_group(sl_held *held, int32_t step, int32_t *group) {
    if (step < 0 || step >= held->boxes.count) return -1;
    Mark before = mark(held->work);
    Some found = {-1, NULL};
    if (join_group(held->work, &held->boxes, step, &found)) found.count = -1;
    else memcpy(group, found.of, (size_t)found.count * sizeof *group);
    free_to(held->work, before);
    return found.count;
}

double sl_thin_side(double gravity, double seconds) { return thin_side(gravity, seconds); }
