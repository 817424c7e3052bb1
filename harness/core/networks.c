/* Trained networks over one layout: LSTM layers and the decision, step by step. */
#include "elementary.h"
#include "learned.h"

typedef float Four __attribute__((vector_size(16), aligned(4), may_alias)); /* anywhere in memory */

static Four four_at(const float *of) { return *(const Four *)of; }

/* Adds vector @ matrix to so many parts of four sums (at most four), at whose columns it begins:
   four rows at a time, every sum rounded as in a loop over rows. */
static inline void add_columns(const float *vector, int32_t count, const float *matrix,
                               size_t width, size_t parts, float *sums) {
    int32_t whole = count - count % 4;
    Four sum[4];
    for (size_t p = 0; p < parts; p++) sum[p] = four_at(sums + 4 * p);
    for (int32_t k = 0; k < whole; k += 4, matrix += 4 * width)
        for (size_t p = 0; p < parts; p++) {
            const float *at = matrix + 4 * p;
            sum[p] += vector[k] * four_at(at) + vector[k + 1] * four_at(at + width) +
                      vector[k + 2] * four_at(at + 2 * width) +
                      vector[k + 3] * four_at(at + 3 * width);
        }
    for (int32_t k = whole; k < count; k++, matrix += width)
        for (size_t p = 0; p < parts; p++) sum[p] += vector[k] * four_at(matrix + 4 * p);
    for (size_t p = 0; p < parts; p++) *(Four *)(sums + 4 * p) = sum[p];
}

/* Adds vector (count) @ matrix (count, width) to sums (width, a multiple of four). */
static void add_product(const float *vector, int32_t count, const float *matrix, size_t width,
                        float *sums) {
    size_t m = 0;
    for (; m + 16 <= width; m += 16) add_columns(vector, count, matrix + m, width, 4, sums + m);
    for (; m < width; m += 4) add_columns(vector, count, matrix + m, width, 1, sums + m);
}

int32_t sl_run_layer(sl_work *work, int32_t steps, int32_t columns, int32_t width,
                     const float *rows, const float *inward, const float *recurrent,
                     const float *bias, float *state, float *outputs) {
    if (steps < 0 || columns < 0 || width < 0 || width > SL_MOST) return SL_REFUSED;
    size_t wide = (size_t)width;
    Mark before = mark(work);
    float *gates = take(work, 4 * wide, sizeof *gates), *last = state, *cells = state + wide;
    if (!gates) return SL_MEMORY;
    const float *into = gates, *kept = gates + wide, *out = gates + 2 * wide, *fresh = out + wide;
    for (int32_t step = 0; step < steps; step++, rows += columns, outputs += wide) {
        memcpy(gates, bias, 4 * wide * sizeof *gates);
        add_product(rows, columns, inward, 4 * wide, gates);
        add_product(last, width, recurrent, 4 * wide, gates);
        for (size_t m = 0; m < 3 * wide; m++)
            gates[m] = 1.0f / (1.0f + exponential_of_float(-gates[m]));
        for (size_t m = 0; m < wide; m++) {
            cells[m] = kept[m] * cells[m] + into[m] * hyperbolic_tangent_of_float(fresh[m]);
            last[m] = out[m] * hyperbolic_tangent_of_float(cells[m]);
        }
        memcpy(outputs, last, wide * sizeof *outputs);
    }
    free_to(work, before);
    return SL_STANDS;
}

void sl_decide(int32_t steps, int32_t width, const float *outputs, const float *head, double last,
               float *chances) {
    for (int32_t step = 0; step < steps && width >= 0; step++, outputs += width) {
        double logit = last;
        for (int32_t m = 0; m < width; m++) logit += (double)(outputs[m] * head[m]);
        chances[step] = (float)(1.0 / (1.0 + exponential_of(-logit)));
    }
}
