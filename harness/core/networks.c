/* Trained networks over one layout: LSTM layers and the decision, step by step. */
#include "elementary.h"
#include "learned.h"

typedef float Four __attribute__((vector_size(16), aligned(4), may_alias)); /* anywhere in memory */

/* Adds vector (count) @ matrix (count, width) to sums (width, a multiple of four), four rows at a
   time; every sum by itself is rounded as in a loop over columns. */
static void add_product(const float *vector, int32_t count, const float *matrix, size_t width,
                        float *sums) {
    int32_t k = 0;
    for (; k + 4 <= count; k += 4, matrix += 4 * width) {
        const float *b = matrix + width, *c = b + width, *d = c + width, *v = vector + k;
        Four all[4];
        for (int n = 0; n < 4; n++) all[n] = (Four){v[n], v[n], v[n], v[n]};
        for (size_t m = 0; m < width; m += 4)
            *(Four *)(sums + m) +=
                all[0] * *(const Four *)(matrix + m) + all[1] * *(const Four *)(b + m) +
                all[2] * *(const Four *)(c + m) + all[3] * *(const Four *)(d + m);
    }
    for (; k < count; k++, matrix += width)
        for (size_t m = 0; m < width; m++) sums[m] += vector[k] * matrix[m];
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
