/* Forces of least energy of a load that grows, sl_energy of forces.h: what was found before is
   changed, not found anew.

   All forces follow from one multiplier an equation. The factors L D L' of the equations of these
   are kept: a corner that begins or ceases to press changes few columns of L (Gill, Golub, Murray
   and Saunders, Methods for modifying matrix factorizations, 1974, method C1; along the elimination
   tree as in Davis and Hager, Modifying a sparse Cholesky factorization, 1999). */
#include "forces.h"

#define TURNS 30     /* iterations, after which it is given up */
#define ENOUGH 1e-10 /* what an equation may be left with, of what its box bears and stands on */

struct sl_energy {
    int32_t equations, corners;
    int32_t *starts, *rows, *column_starts, *column_rows;
    double *values, *diagonal, *column_values, *right, *multipliers, *work, *rest, *scale;
    bool *presses, *held, failed;
};

static void *copy_of(const void *from, uint64_t count, uint64_t size) {
    void *made = allocate((count + 1) * size);
    if (made && from && count) memcpy(made, from, (size_t)(count * size));
    if (made && !from) memset(made, 0, (size_t)((count + 1) * size));
    return made;
}

/* Whether rows of columns are in range; of a factor they ascend behind the diagonal, and a column
   of effects has one at least. */
static bool are_columns(int32_t columns, const int32_t *starts, const int32_t *rows, int32_t end,
                        bool is_factor) {
    if (starts[0] != 0) return false;
    for (int32_t k = 0; k < columns; k++) /* all before any row is read: callers check the last */
        if (starts[k + 1] < starts[k] + !is_factor) return false;
    for (int32_t k = 0; k < columns; k++) {
        int32_t last = is_factor ? k : -1;
        for (int32_t q = starts[k]; q < starts[k + 1]; q++) {
            if (rows[q] <= last || rows[q] >= end) return false;
            last = is_factor ? rows[q] : -1;
        }
    }
    return true;
}

sl_energy *sl_energy_new(int32_t equations, const int32_t *starts, const int32_t *rows,
                         const double *diagonal, int32_t corners, const int32_t *column_starts,
                         const int32_t *column_rows, const double *column_values,
                         const double *right, const uint8_t *presses) {
    if (equations < 0 || corners < 0 || equations % 3) return NULL;
    if (!are_columns(equations, starts, rows, equations, true)) return NULL;
    if (!are_columns(corners, column_starts, column_rows, equations, false)) return NULL;
    sl_energy *e = copy_of(NULL, 1, sizeof *e);
    if (!e) return NULL;
    uint64_t m = (uint64_t)equations, n = (uint64_t)corners, entries = (uint64_t)starts[equations];
    uint64_t own = (uint64_t)column_starts[corners];
    e->equations = equations, e->corners = corners;
    e->starts = copy_of(starts, m + 1, sizeof *starts);
    e->rows = copy_of(rows, entries, sizeof *rows);
    e->values = copy_of(NULL, entries, sizeof *e->values);
    e->diagonal = copy_of(diagonal, m, sizeof *diagonal);
    e->column_starts = copy_of(column_starts, n + 1, sizeof *column_starts);
    e->column_rows = copy_of(column_rows, own, sizeof *column_rows);
    e->column_values = copy_of(column_values, own, sizeof *column_values);
    e->right = copy_of(right, m, sizeof *right);
    e->multipliers = copy_of(NULL, m, sizeof *right), e->work = copy_of(NULL, m, sizeof *right);
    e->rest = copy_of(NULL, m, sizeof *right), e->scale = copy_of(NULL, m, sizeof *right);
    e->presses = copy_of(NULL, n, sizeof *e->presses), e->held = copy_of(NULL, n, sizeof *e->held);
    for (int32_t c = 0; e->presses && c < corners; c++) e->presses[c] = presses[c] != 0;
    if (e->starts && e->rows && e->values && e->diagonal && e->column_starts && e->column_rows &&
        e->column_values && e->right && e->multipliers && e->work && e->rest && e->scale &&
        e->presses && e->held) return e;
    sl_energy_free(e);
    return NULL;
}

void sl_energy_free(sl_energy *e) {
    if (!e) return;
    void *all[] = {e->starts, e->rows, e->column_starts, e->column_rows, e->values, e->diagonal,
                   e->column_values, e->right, e->multipliers, e->work, e->rest, e->scale,
                   e->presses, e->held, e};
    for (size_t k = 0; k < sizeof all / sizeof *all; k++) free(all[k]);
}

/* Adds a column times itself, or takes it off; false where rounding leaves nothing positive. */
static bool update(sl_energy *e, int32_t corner, double sign) {
    double share = sign;
    int32_t at = e->equations;
    for (int32_t q = e->column_starts[corner]; q < e->column_starts[corner + 1]; q++) {
        e->work[e->column_rows[q]] = e->column_values[q];
        at = e->column_rows[q] < at ? e->column_rows[q] : at;
    }
    for (;;) {
        double value = e->work[at], before = e->diagonal[at];
        e->work[at] = 0.0;
        double now = before + share * value * value;
        if (!(now > 0.0)) return false;
        double turn = share * value / now;
        share *= before / now;
        e->diagonal[at] = now;
        int32_t start = e->starts[at], end = e->starts[at + 1];
        for (int32_t q = start; q < end; q++) {
            int32_t row = e->rows[q];
            e->work[row] -= value * e->values[q];
            e->values[q] += turn * e->work[row];
        }
        if (start == end) return true;
        at = e->rows[start];
    }
}

/* Puts the solution in the place of the right side. */
static void solve(const sl_energy *e, int32_t count, const int32_t *equations, double *right) {
    for (int32_t k = 0; k < count; k++) {
        int32_t j = equations[k];
        double value = right[j];
        for (int32_t q = e->starts[j]; q < e->starts[j + 1]; q++)
            right[e->rows[q]] -= e->values[q] * value;
    }
    for (int32_t k = count - 1; k >= 0; k--) {
        int32_t j = equations[k];
        double value = right[j] / e->diagonal[j];
        for (int32_t q = e->starts[j]; q < e->starts[j + 1]; q++)
            value -= e->values[q] * right[e->rows[q]];
        right[j] = value;
    }
}

/* Takes the forces of the multipliers off the equations; false where factors fail. */
static bool pull(sl_energy *e, bool first, int32_t count, const int32_t *corners, double *pulls) {
    for (int32_t k = 0; k < count; k++) {
        int32_t c = corners[k], start = e->column_starts[c], end = e->column_starts[c + 1];
        double force = 0.0;
        for (int32_t q = start; q < end; q++)
            force += e->column_values[q] * e->multipliers[e->column_rows[q]];
        pulls[k] = force;
        if (!first) e->presses[c] = force > 0.0;
        if (e->presses[c] != e->held[c]) {
            e->held[c] = e->presses[c];
            if (!update(e, c, e->held[c] ? 1.0 : -1.0)) return false;
        }
        if (!e->presses[c]) continue;
        for (int32_t q = start; q < end; q++) {
            double part = e->column_values[q] * force;
            e->rest[e->column_rows[q]] -= part;
            e->scale[e->column_rows[q]] += size_of(part);
        }
    }
    return true;
}

/* By Newton's method. */
static bool find(sl_energy *e, int32_t count, const int32_t *corners, int32_t some_count,
                 const int32_t *some, double *pulls) {
    size_t bytes = (size_t)e->equations * sizeof *e->work;
    memset(e->work, 0, bytes), memset(e->rest, 0, bytes), memset(e->scale, 0, bytes);
    for (int turn = 0; turn < TURNS; turn++) {
        for (int32_t k = 0; k < some_count; k++)
            e->rest[some[k]] = e->scale[some[k]] = e->right[some[k]];
        if (!pull(e, turn == 0, count, corners, pulls)) return false;
        double left = 0.0;
        for (int32_t k = 0; k < some_count; k++) {
            double own = size_of(e->rest[some[k]]) / e->scale[some[k] - some[k] % 3];
            left = own > left ? own : left;
        }
        if (turn > 0 && left <= ENOUGH) return true;
        if (!(left < __builtin_inf())) return false;
        solve(e, some_count, some, e->rest);
        for (int32_t k = 0; k < some_count; k++) e->multipliers[some[k]] += e->rest[some[k]];
    }
    return false;
}

static bool are_below(int32_t count, const int32_t *numbers, int32_t end) {
    for (int32_t k = 0; k < count; k++)
        if (numbers[k] < 0 || numbers[k] >= end) return false;
    return true;
}

int32_t sl_energy_solve(sl_energy *e, int32_t count, const int32_t *corners, int32_t some_count,
                        const int32_t *some, double *pulls) {
    if (e->failed || !are_below(count, corners, e->corners)) return SL_REFUSED;
    if (!are_below(some_count, some, e->equations)) return SL_REFUSED;
    e->failed = !find(e, count, corners, some_count, some, pulls);
    return e->failed ? SL_FAILS : SL_STANDS;
}
