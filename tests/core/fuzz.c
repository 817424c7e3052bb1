/* Any numbers for the public functions of steadyload.h and learned.h: sane stacks, ties, and, in
   two fifths of the layouts, nonsense (NaN, infinities, huge, denormal, negative sizes).

   fuzz [seconds [seed]]: runs so long, says how often calls ended how, and aborts at an answer that
   is none. Built with sanitizers and -DSL_EACH it finds what goes beyond its memory. */
#define _POSIX_C_SOURCE 200112L
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "learned.h"

#define MOST 120 /* boxes */
#define REQUIRE(is) \
    do \
        if (!(is)) fprintf(stderr, "line %d, layout %ld: %s\n", __LINE__, tried, #is), abort(); \
    while (0)

static uint64_t state = 88172645463325252ull;
static long tried, ended[8], moving;

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
    int32_t is = sl_support_table(work, l->count, l->lower, l->upper, l->weights, l->offsets,
                                  l->floor, table);
    REQUIRE(is == SL_STANDS);
    sl_support_features(l->count, table, rows);
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
    REQUIRE(sl_support_table(work, -1, NULL, NULL, NULL, NULL, NULL, NULL) == SL_REFUSED);
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

int main(int argc, char **argv) {
    double seconds = argc > 1 ? atof(argv[1]) : 10.0;
    clock_t begin = clock();
    if (argc > 2) state ^= strtoull(argv[2], NULL, 10);
    sl_work *work = sl_work_new();
    if (!work) return 2;
    for (; (double)(clock() - begin) < seconds * CLOCKS_PER_SEC; tried++) {
        Layout l = draw();
        judge(work, &l);
        learn(work, &l);
        ask(work, l.wild * 0.2);
        if (tried % 5 == 0) load(&l);
        free(l.lower), free(l.upper), free(l.weights), free(l.offsets);
    }
    sl_work_free(work);
    printf("%ld layouts; steps that move: %ld; ended:", tried, moving);
    for (int k = 0; k < 8; k++) printf(" %ld", ended[k]);
    puts("");
    return 0;
}
