/* Trained networks over one layout: LSTM layers and the decision, step by step. */
#include "elementary.h"
#include "learned.h"

typedef float Four __attribute__((vector_size(16), aligned(4), may_alias)); /* anywhere in memory */
typedef int32_t Mask __attribute__((vector_size(16)));

static inline Four four_times(float a) { return (Four){a, a, a, a}; }

/* Adds vector (count) @ matrix (count, width) to sums (width, a multiple of four), four rows at a
   time. */
static void add_product(const float *vector, int32_t count, const float *matrix, size_t width,
                        float *sums) {
    int32_t k = 0;
    for (; k + 4 <= count; k += 4, matrix += 4 * width) {
        const float *b = matrix + width, *c = b + width, *d = c + width;
        Four all[4];
        for (int n = 0; n < 4; n++) all[n] = four_times(vector[k + n]);
        for (size_t m = 0; m < width; m += 4)
            *(Four *)(sums + m) +=
                all[0] * *(const Four *)(matrix + m) + all[1] * *(const Four *)(b + m) +
                all[2] * *(const Four *)(c + m) + all[3] * *(const Four *)(d + m);
    }
    for (; k < count; k++, matrix += width) {
        Four all = four_times(vector[k]);
        for (size_t m = 0; m < width; m += 4)
            *(Four *)(sums + m) += all * *(const Four *)(matrix + m);
    }
}

/* The hyperbolic tangent, by Lambert x / (1 + x2 / (3 + x2 / (5 + ...))): its first thirteen terms
   are x times a quotient of two polynomials in x2. Beyond 9 it is 1 in this precision. */
#define FURTHEST 9.0f
#define DEGREE 6
static const float UPPER[DEGREE + 1] = {
    1.0f, 4095.0f, 2552550.0f, 523783260.0f, 41247931725.0f, 1159525191825.0f, 7905853580625.0f,
};
static const float LOWER[DEGREE + 1] = {
    91.0f, 120120.0f, 41351310.0f, 5237832600.0f, 252070693875.0f, 3794809718700.0f,
    7905853580625.0f,
};

/* In place of values, of which there is room for a multiple of four; what is no number stays so. */
static void take_tangents(float *values, size_t count) {
    const Four most = four_times(FURTHEST);
    for (size_t m = 0; m < count; m += 4) {
        Four x = *(const Four *)(values + m);
        Mask over = x > most, under = x < -most;
        x = (Four)(((Mask)x & ~(over | under)) | ((Mask)most & over) | ((Mask)-most & under));
        Four square = x * x, upper = four_times(UPPER[0]), lower = four_times(LOWER[0]);
        for (int k = 1; k <= DEGREE; k++) {
            upper = upper * square + four_times(UPPER[k]);
            lower = lower * square + four_times(LOWER[k]);
        }
        *(Four *)(values + m) = x * upper / lower;
    }
}

int32_t sl_run_layer(sl_work *work, int32_t steps, int32_t columns, int32_t width,
                     const float *rows, const float *inward, const float *recurrent,
                     const float *bias, float *state, float *outputs) {
    if (steps < 0 || columns < 0 || width < 0 || width > SL_MOST) return SL_REFUSED;
    size_t wide = (size_t)width;
    Mark before = mark(work);
    float *gates = take(work, 5 * wide + 3, sizeof *gates), *last = state, *cells = state + wide;
    if (!gates) return SL_MEMORY;
    const float *into = gates, *kept = gates + wide, *out = gates + 2 * wide, *fresh = out + wide;
    float *tangents = gates + 4 * wide; /* of the cells */
    for (int32_t step = 0; step < steps; step++, rows += columns, outputs += wide) {
        memcpy(gates, bias, 4 * wide * sizeof *gates);
        add_product(rows, columns, inward, 4 * wide, gates);
        add_product(last, width, recurrent, 4 * wide, gates);
        /* A sigmoid of x is (1 + tanh(x / 2)) / 2. */
        for (size_t m = 0; m < 3 * wide; m++) gates[m] *= 0.5f;
        take_tangents(gates, 4 * wide);
        for (size_t m = 0; m < 3 * wide; m++) gates[m] = 0.5f * gates[m] + 0.5f;
        for (size_t m = 0; m < wide; m++)
            tangents[m] = cells[m] = kept[m] * cells[m] + into[m] * fresh[m];
        take_tangents(tangents, wide);
        for (size_t m = 0; m < wide; m++) last[m] = out[m] * tangents[m];
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
