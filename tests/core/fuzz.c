/* Any numbers for the public functions of all headers: sane stacks, ties, and, in two fifths of the
   layouts, nonsense (NaN, infinities, huge, denormal, negative sizes).

   fuzz [seconds [seed]]: runs so long, says how often calls ended how, and aborts at an answer that
   is none. Built with sanitizers and -DSL_EACH it finds what goes beyond its memory. */
#define _POSIX_C_SOURCE 200112L
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "forces.h"
#include "learned.h"
#include "searching.h"
#include "timed.h"

#define MOST 120 /* boxes */
#define REQUIRE(is) \
    do \
        if (!(is)) fprintf(stderr, "line %d, layout %ld: %s\n", __LINE__, tried, #is), abort(); \
    while (0)

static uint64_t state = 88172645463325252ull;
static long tried, ended[SL_LOOK + 1], moving;

static uint64_t bits(void) {
    state ^= state << 13, state ^= state >> 7, state ^= state << 17;
    return state;
}

static double part(void) { return (double)(bits() >> 11) * 0x1p-53; }
static int below(int end) { return (int)(bits() % (uint64_t)end); }

static double wild(void) {
    static const double odd[] = {0, -0.0, NAN, INFINITY, -INFINITY, 1e308, -1e308, 5e-324, 1e-310,
                                 0.01, 0.010001, 1e9, -1e9, 1e154, 1e-160};
    switch (below(4)) {
        case 0: return odd[below(15)];
        case 1: {
            uint64_t any = bits();
            double number;
            memcpy(&number, &any, sizeof number);
            return number;
        }
        case 2: return (double)below(10);
        default: return (part() - 0.3) * 100.0;
    }
}

/* In pieces of their own, so that a sanitizer sees what goes beyond them. */
typedef struct {
    int mode, count;
    double wild; /* chance of a number */
    double *lower, *upper, *weights, *offsets, floor[5];
} Layout;

static void *room(size_t size) {
    void *made = malloc(size ? size : 1);
    if (!made) abort();
    return made;
}

static Layout draw(void) {
    Layout l = {.mode = below(5), .count = below(tried % 50 == 0 ? MOST : 20)};
    size_t n = (size_t)l.count * sizeof(double);
    double unit = l.mode == 2 ? 10.0 : l.mode == 3 ? 1.0 : 0.001;
    l.wild = l.mode == 0 ? 1.0 : l.mode == 1 ? 0.05 : 0.0;
    l.lower = room(3 * n), l.upper = room(3 * n), l.weights = room(n), l.offsets = room(3 * n);
    for (int j = 0; j < l.count; j++) {
        double y = 10.0 * below(4);
        for (int k = 3 * j; k < 3 * j + 3; k++) {
            bool up = k % 3 == 1;
            l.lower[k] = up ? y : floor(part() * 100.0 / unit) * unit;
            l.upper[k] = l.lower[k] + (up ? 10.0 : floor(part() * 60.0 / unit + 1.0) * unit);
            l.offsets[k] = part() < 0.5 ? 0.0 : (part() - 0.5) * 20.0;
            if (part() < l.wild) l.lower[k] = wild();
            if (part() < l.wild) l.upper[k] = wild();
            if (part() < l.wild) l.offsets[k] = wild();
        }
        l.weights[j] = part() < l.wild ? wild() : 1.0 + part() * 30.0;
    }
    const double deck[5] = {0, 0, 120, 80, (double)below(2)};
    for (int c = 0; c < 5; c++) l.floor[c] = part() < l.wild ? wild() : deck[c];
    return l;
}

static void check(const sl_finding *found, int count) {
    REQUIRE(found->ended >= SL_STANDS && found->ended <= SL_REFUSED);
    REQUIRE(found->step >= 0 && found->step <= count);
    REQUIRE(found->item >= -1 && found->item < (count ? count : 1));
    ended[found->ended]++;
}

static void judge(sl_work *work, const Layout *l) {
    for (int rule = 0; rule < 3; rule++) {
        sl_finding found, many[2];
        double alpha = rule == 0 ? part() : rule == 2 && part() < 0.5 ? part() : 0.0;
        if (part() < l->wild) alpha = wild();
        sl_judge(work, rule, alpha, l->count, l->lower, l->upper, l->weights, l->offsets, l->floor,
                 &found);
        check(&found, l->count);
        int half = l->count / 2; /* the same boxes as two layouts: the first half ends as before */
        double floors[10];
        memcpy(floors, l->floor, sizeof l->floor), memcpy(floors + 5, l->floor, sizeof l->floor);
        const int32_t starts[3] = {0, half, l->count};
        int32_t is = sl_judge_many(work, rule, alpha, 2, starts, l->lower, l->upper, l->weights,
                                   l->offsets, floors, many);
        REQUIRE(is == SL_STANDS);
        check(many, half), check(many + 1, l->count - half);
    }
    int32_t none = sl_judge(work, 3, 0.0, l->count, l->lower, l->upper, l->weights, l->offsets,
                            l->floor, &(sl_finding){0});
    REQUIRE(none == SL_REFUSED);
}

/* A session with any numbers: boxes may be wild, overlaps are refused. */
static void load(const Layout *l) {
    double limits[11] = {-5, 0, -5, 125, 200, 85, 0, 0, 120, 80, l->floor[4]};
    for (int c = 0; c < 11; c++)
        if (part() < l->wild * 0.1) limits[c] = wild();
    sl_session *session = sl_session_new(limits);
    if (!session) abort();
    for (int k = 0, most = tried % 250 == 0 ? 300 : 30; k < most; k++) {
        double box[10] = {part() * 110 - 5, 10.0 * below(6), part() * 70 - 5, 1 + part() * 25, 10,
                          1 + part() * 25, 0, 0, 0, 1 + part() * 9};
        if (l->mode == 2)
            for (int c = 0; c < 6; c++)
                box[c] = floor(box[c] / 5) * 5 + (c > 2 && c != 4 ? 5 : 0);
        for (int c = 0; c < 10; c++)
            if (part() < l->wild) box[c] = wild();
        sl_finding found;
        int rule = below(3);
        double alpha = rule == 0 ? 0.7 : rule == 2 && part() < 0.2 ? 0.5 : 0.0;
        int is = below(8) ? sl_place(session, box, rule, alpha, &found) : sl_put(session, box);
        REQUIRE(is >= SL_STANDS && is <= SL_REFUSED);
        ended[is]++;
        int8_t endings[4];
        double places[12];
        for (int c = 0; c < 12; c++) places[c] = part() * 100.0;
        sl_stand(session, box, rule, 0.5, 4, places, endings);
        if (!below(20)) sl_cut(session, below(sl_session_count(session) + 1));
    }
    sl_session_free(session);
}

static void learn(sl_work *work, const Layout *l) {
    size_t n = (size_t)l->count;
    double *table = room(n * SL_SUPPORT * sizeof *table);
    double *quantities = room(n * SL_QUANTITIES * sizeof *quantities);
    float *plain = room(n * SL_PLAIN * sizeof *plain), *rows = room(n * SL_SUPPORT * sizeof *rows);
    double pallet[3] = {120, 200, 80}, least[SL_QUANTITIES], most[SL_QUANTITIES];
    for (int c = 0; c < 3; c++)
        if (part() < l->wild) pallet[c] = wild();
    for (int c = 0; c < SL_QUANTITIES; c++) {
        least[c] = part() < l->wild ? wild() : 0.0, most[c] = part() < l->wild ? wild() : 100.0;
    }
    int32_t is = sl_support(work, l->count, l->lower, l->upper, l->weights, l->offsets,
                            l->floor, table, rows);
    REQUIRE(is == SL_STANDS);
    sl_plain_features(l->count, l->lower, l->upper, l->weights, l->offsets, pallet, plain);
    sl_quantities(l->count, l->lower, l->upper, l->weights, l->offsets, l->floor, quantities);
    int32_t inside = sl_inside(l->count, quantities, least, most);
    REQUIRE(inside >= 0 && inside <= l->count);
    for (size_t k = 0; l->wild == 0.0 && k < n * SL_SUPPORT; k++)
        REQUIRE(isfinite(table[k]) && isfinite(rows[k]));
    for (size_t j = 0; j < n; j++) {
        const double *row = table + j * SL_SUPPORT;
        moving += row[SL_MOVING] > 0.0;
        REQUIRE(row[SL_BELOW] >= 0.0 && row[SL_BELOW] <= (double)j);
        REQUIRE(row[SL_UNBALANCED] <= row[SL_BELOW] + 1.0 && row[SL_MOVING] <= row[SL_BELOW] + 1.0);
    }
    REQUIRE(sl_support(work, -1, NULL, NULL, NULL, NULL, NULL, NULL, NULL) == SL_REFUSED);
    free(table), free(quantities), free(plain), free(rows);
}

static float weight(double chance) {
    return (float)(part() < chance ? wild() : (part() - 0.5) * 4.0);
}

static void ask(sl_work *work, double chance) {
    int32_t steps = below(6), columns = below(9), width = below(23);
    size_t s = (size_t)steps, c = (size_t)columns, w = (size_t)width;
    size_t sizes[8] = {s * c, 4 * w * c, 4 * w * w, 4 * w, 2 * w, s * w, w, s};
    float *of[8]; /* rows, inward, recurrent, bias, state, outputs, head, chances */
    for (int k = 0; k < 8; k++) {
        of[k] = room(sizes[k] * sizeof **of);
        for (size_t m = 0; m < sizes[k]; m++) of[k][m] = weight(chance);
    }
    int32_t is = sl_run_layer(work, steps, columns, width, of[0], of[1], of[2], of[3], of[4],
                              of[5]);
    REQUIRE(is == SL_STANDS);
    sl_decide(steps, width, of[5], of[6], (double)weight(chance), of[7]);
    for (size_t m = 0; m < s; m++)
        REQUIRE((of[7][m] >= 0.0f && of[7][m] <= 1.0f) || (chance > 0.0 && isnan(of[7][m])));
    REQUIRE(sl_run_layer(work, 1, 1, -1, of[0], of[1], of[2], of[3], of[4], of[5]) == SL_REFUSED);
    for (int k = 0; k < 8; k++) free(of[k]);
}

static double any_of(const Layout *l, double sane) { return part() < l->wild ? wild() : sane; }

static double *any_numbers(const Layout *l, size_t count, double least, double most) {
    double *made = room(count * sizeof *made);
    for (size_t k = 0; k < count; k++) made[k] = any_of(l, least + part() * (most - least));
    return made;
}

/* Motions, margins and balance, step by step, from any state that a loading may be in. */
static void with_timed(sl_work *work, const Layout *l) {
    const sl_how how = {any_of(l, part()), any_of(l, 981.0), any_of(l, 0.3), any_of(l, 10.0),
                        any_of(l, 10.0)};
    int32_t size, kept, count = l->count, *group = room(((size_t)count + 1) * sizeof *group);
    sl_moved found;
    sl_finding margin;
    ended[sl_first_moved(work, count, l->lower, l->upper, l->weights, l->offsets, l->floor,
                         below(2) ? 1e3 : 5.0, &how, &found)]++;
    REQUIRE(found.step >= 0 && found.step <= count && found.item >= -1);
    sl_margin(work, any_of(l, 10.0), count, l->lower, l->upper, l->weights, l->offsets, l->floor,
              &margin);
    REQUIRE(margin.item >= -1 && margin.item < (count ? count : 1));
    double drawn_in = below(2) ? 0.0 : any_of(l, part());
    sl_timed *timed = sl_timed_new(count, l->lower, l->upper, l->weights, l->offsets, l->floor,
                                   drawn_in);
    sl_held *held = sl_held_new(count, l->lower, l->upper, l->weights, l->offsets, l->floor,
                                drawn_in);
    if (!timed || !held) abort();
    sl_timed_view view;
    sl_timed_look(timed, &view);
    view.work[1] = 1e3;
    for (int32_t step = 0; step < count; step++) {
        for (int32_t k = 0; k < 4 * view.patches; k++) view.pressing[k] = (uint8_t)below(2);
        for (int32_t k = 0; k < (count + 1) * (count + 1); k++) view.pushes[k] = (uint16_t)bits();
        int32_t at = below(count);
        view.moves[at] = (uint8_t)below(2), view.solved[at] = (uint8_t)below(2);
        view.answers[at] = below(3), view.farthest[6 * at + below(6)] = any_of(l, 10.0 * part());
        int32_t is = sl_timed_group(timed, step, &kept, &size, group);
        REQUIRE(is >= SL_STANDS && is <= SL_UNRESOLVED && size >= 0 && size <= step + 1);
        if (size && !kept) sl_timed_moved(timed, step, size, group, &how, &found);
        sl_timed_is_near_its_edge(timed, step, 0.5);
        REQUIRE(sl_held_place(held, step, &at) <= SL_UNRESOLVED && at >= -1 && at <= step);
        size = sl_held_group(held, step, group);
        REQUIRE(size >= 0 && size <= step + 1);
    }
    sl_timed_first(timed, 0, count, &how, &found);
    REQUIRE(sl_timed_group(timed, count, &kept, &size, group) == SL_REFUSED);
    sl_timed_free(timed), sl_held_free(held), free(group);
}

/* A plan that is loaded, changed, and loaded again. */
static void with_searching(sl_work *work, const Layout *l) {
    size_t n = (size_t)l->count;
    double *sides = any_numbers(l, 6 * n, 5, 30), *offsets = any_numbers(l, 6 * n, -2, 2);
    double *planned = room(4 * n * sizeof *planned), *places = room(4 * n * sizeof *places);
    double *volumes = any_numbers(l, n, 1, 9), *margins = any_numbers(l, 2 * n, 0, 0.5), cost[4];
    double *tried_at = room(5 * n * sizeof *tried_at), *refused = any_numbers(l, 5, 0, 2);
    double limits[11] = {-5, 0, -5, 125, 200, 85, 0, 0, 120, 80, l->floor[4]};
    double ways[3] = {any_of(l, 60), -INFINITY, any_of(l, 40)};
    int32_t *order = room(n * sizeof *order), *waiting = room(n * sizeof *waiting), counts[2];
    uint8_t *without = room(n);
    for (size_t k = 0; k < n; k++) {
        memcpy(planned + 4 * k, l->lower + 3 * k, 3 * sizeof *planned), planned[4 * k + 3] = 0.0;
        if (l->wild == 0.0) sides[3 * k + 1] = sides[3 * (n + k) + 1] = 10.0;
        without[k] = below(5) == 0;
    }
    memcpy(places, planned, 4 * n * sizeof *places);
    const sl_boxes boxes = {l->count, sides, offsets, l->weights, planned, volumes};
    const sl_wishes wishes = {places, margins, 1, refused};
    sl_loading *loading = sl_loading_new(limits, l->count);
    if (!loading) abort();
    for (int turn = 0; l->count && turn < 4; turn++) {
        int32_t box = below(l->count), most = below(40), turns = 1 + below(2), looks = below(2), is;
        REQUIRE(sl_load_begin(loading, &boxes, &wishes, below(l->count + 1)) == SL_STANDS);
        while ((is = sl_load(loading, &boxes, &wishes, turn % 2, looks)) == SL_LOOK) {
            ended[is]++;
            REQUIRE(sl_looked_at(loading) >= 0 && sl_looked_at(loading) < l->count);
            REQUIRE(sl_said(loading, below(3), turn % 2) == SL_STANDS);
        }
        REQUIRE(is == SL_STANDS);
        sl_loaded(loading, order, waiting, counts), sl_tried(loading, tried_at);
        REQUIRE(counts[0] >= 0 && counts[1] >= 0 && counts[0] + counts[1] <= l->count);
        size_t room_for = (size_t)turns * (size_t)most;
        double *free_at = room(4 * room_for * sizeof *free_at);
        double *far = room(room_for * sizeof *far);
        int32_t *standing = room((size_t)most * sizeof *standing);
        const sl_wanted wanted = {limits, ways, any_of(l, 0.5), most};
        int32_t count = sl_places_among(work, &boxes, places, without, box, &wanted, turns,
                                        free_at, far);
        REQUIRE(count >= 0 && count <= turns * most);
        is = sl_first_standing(loading, &boxes, &wishes, box, 0.05, count, free_at, most, standing);
        REQUIRE(is >= 0 && is <= most);
        sl_cost(&boxes, places, cost);
        double *place = places + 4 * box; /* the next turn has the box elsewhere */
        if (count) memcpy(place, free_at + 4 * below(count), 4 * sizeof *place);
        else place[3] = LEFT_OUT;
        if (!below(4)) refused[0] = box, memcpy(refused + 1, place, 4 * sizeof *place);
        free(free_at), free(far), free(standing);
    }
    sl_loading_free(loading);
    free(sides), free(offsets), free(planned), free(places), free(volumes), free(margins);
    free(tried_at), free(refused), free(order), free(waiting), free(without);
}

/* Forces by those who have the equations: of contacts, by least squares, and of least energy. */
static void with_forces(sl_work *work, const Layout *l) {
    size_t n = (size_t)l->count;
    uint8_t *on_floor = room(n);
    int32_t *starts = room((n + 1) * sizeof *starts), *aboves = room((n + 1) * sizeof *aboves);
    int32_t size = sl_contacts(work, l->count, l->lower, l->upper, l->floor, on_floor, starts,
                               aboves, 0, NULL, NULL, NULL);
    REQUIRE(size >= 0);
    size_t many = (size_t)size;
    int32_t *under = room(many * sizeof *under), *above = room(many * sizeof *above);
    int32_t *used = room(3 * many * sizeof *used), *items = room(n * sizeof *items);
    double *patches = room(4 * many * sizeof *patches), *found = room(4 * many * sizeof *found);
    sl_contacts(work, l->count, l->lower, l->upper, l->floor, on_floor, starts, aboves, size, under,
                patches, above);
    for (int32_t j = 0; j < l->count; j++) {
        items[j] = j;
        for (int32_t k = starts[j]; k < starts[j + 1]; k++)
            used[3 * k] = k, used[3 * k + 1] = j, used[3 * k + 2] = under[k];
    }
    if (size && part() < l->wild) used[below(3 * size)] = below(l->count + 2) - 1;
    sl_finding closest;
    sl_closest_to_balance(work, l->count, l->lower, l->upper, l->weights, l->offsets, l->count,
                          items, size, used, size, patches, any_of(l, 1e-5), found, &closest);
    REQUIRE(closest.item >= -1 && closest.item < (l->count ? l->count : 1));
    int32_t columns = below(9), rows = below(9);
    double *matrix = any_numbers(l, (size_t)(columns * rows), -1, 1);
    double *target = any_numbers(l, (size_t)rows, -1, 1);
    double *x = room((size_t)columns * sizeof *x), *rest = room((size_t)rows * sizeof *rest);
    sl_nonnegative_least_squares(work, columns, rows, matrix, target, x, rest);
    for (int32_t k = 0; l->wild == 0.0 && k < columns; k++) REQUIRE(x[k] >= 0.0);
    /* Three equations a box, all joined; each corner is one of two of them. */
    int32_t equations = 3 * below(4), corners = equations ? below(12) : 0, entries = 0;
    int32_t first[13], row[66], own[13], own_rows[24], all[12], there[12];
    double *diagonal = any_numbers(l, (size_t)equations, 1, 2), pulls[12];
    double *values = any_numbers(l, 2 * (size_t)corners, -1, 1);
    double *right = any_numbers(l, (size_t)equations, 0, 5);
    uint8_t presses[12];
    for (int32_t k = 0; k <= equations; k++) {
        first[k] = entries;
        for (int32_t r = k + 1; r < equations; r++) row[entries++] = r;
        if (k < equations) all[k] = k;
    }
    for (int32_t c = 0; c < corners; c++) {
        presses[c] = (uint8_t)below(2), own[c] = 2 * c, there[c] = c;
        own_rows[2 * c] = below(equations);
        own_rows[2 * c + 1] = below(part() < l->wild ? equations + 1 : equations);
    }
    own[corners] = 2 * corners;
    sl_energy *energy = sl_energy_new(equations, first, row, diagonal, corners, own, own_rows,
                                      values, right, presses);
    if (energy) {
        int32_t some = corners ? below(corners + 1) : 0;
        if (sl_energy_solve(energy, some, there, equations, all, pulls) == SL_STANDS)
            sl_energy_solve(energy, corners, there, equations, all, pulls);
        sl_energy_free(energy);
    }
    free(on_floor), free(starts), free(aboves), free(under), free(above), free(used), free(items);
    free(patches), free(found), free(matrix), free(target), free(x), free(rest), free(diagonal);
    free(values), free(right);
}

/* Boxes that are put on and taken off again and again take no more room than once. */
static void load_again(void) {
    const double limits[11] = {0, 0, 0, 120, 200, 80, 0, 0, 120, 80, 0};
    sl_session *session = sl_session_new(limits);
    if (!session) abort();
    int32_t before = session->links;
    for (int turn = 0; turn < 500; turn++) {
        for (int k = 0; k < 7; k++) {
            double low = k ? 10.0 * (k - 1) : 0.0, side = k ? 10.0 : 60.0;
            double box[10] = {low, k ? 10 : 0, 0, side, 10, 10, 0, 0, 0, 1};
            REQUIRE(sl_put(session, box) == SL_STANDS);
        }
        sl_cut(session, 0);
    }
    REQUIRE(session->links == before);
    sl_session_free(session);
}

int main(int argc, char **argv) {
    double seconds = argc > 1 ? atof(argv[1]) : 10.0;
    clock_t begin = clock();
    if (argc > 2) state ^= strtoull(argv[2], NULL, 10);
    sl_work *work = sl_work_new();
    if (!work) return 2;
    for (; (double)(clock() - begin) < seconds * CLOCKS_PER_SEC; tried++) {
        Layout l = draw();
        judge(work, &l);
        if (tried % 4 == 0) learn(work, &l);
        if (tried % 4 == 0) ask(work, l.wild * 0.2);
        if (tried % 8 == 0) load(&l);
        if (tried % 4 == 1) with_timed(work, &l);
        if (tried % 4 == 2) with_searching(work, &l);
        if (tried % 4 == 3) with_forces(work, &l);
        if (tried == 0) load_again();
        free(l.lower), free(l.upper), free(l.weights), free(l.offsets);
    }
    sl_work_free(work);
    printf("%ld layouts; steps that move: %ld; ended:", tried, moving);
    for (int k = 0; k <= SL_LOOK; k++) printf(" %ld", ended[k]);
    puts("");
    return 0;
}
