/* Pendulums that boxes which push each other move as, until a gap closes. Called by motion.c. */
#include "elementary.h"
#include "timed.h"

/* k2 of every free body [1/s2]: that of the bodies that move and push each other. */
int find_growth(sl_work *work, const Motion *m, const double (*rates)[6], double *growth) {
    int32_t count = m->count, *part = take(work, (uint64_t)count, sizeof *part);
    double *gain = take(work, (uint64_t)count, sizeof *gain), top = 1e-300;
    double *energy = take(work, (uint64_t)count, sizeof *energy);
    if (!part || !gain || !energy) return SL_MEMORY;
    for (int32_t n = 0; n < count; n++) {
        const double *u = rates[n], *w = rates[n] + 3;
        gain[n] = m->how->gravity * m->mass[n][0] * (w[0] * u[2] - w[2] * u[0]);
        energy[n] = 0.0;
        for (int c = 0; c < 6; c++) energy[n] += m->mass[n][c] * (rates[n][c] * rates[n][c]);
        top = most(energy[n], top);
        part[n] = n;
    }
    for (int32_t column = 0; column < m->columns; column++) {
        const int32_t *pair = m->bodies[column];
        if (m->parts[column] > 0.0 && pair[0] >= 0 && pair[1] >= 0 &&
            least(energy[pair[1]], energy[pair[0]]) > AT_REST * top)
            merge(part, count, pair[0], pair[1]);
    }
    for (int32_t n = 0; n < count; n++) {
        double gains = 0.0, energies = 0.0;
        for (int32_t k = 0; k < count; k++)
            if (part[k] == part[n]) gains += gain[k], energies += energy[k];
        growth[n] = gains / (energies > 0.0 ? energies : 1.0);
    }
    return SL_STANDS;
}

/* The way of s'' = 1 + k2 s from rest at s = 0; near k2 = 0 it is t2 / 2. */
static double pendulum(double growth, double t) {
    double half = least(FAR, most(1e-6, 0.5 * root_of(size_of(growth)) * t));
    double share = (growth > 0.0 ? hyperbolic_sine_of(half) : sine_of(half)) / half;
    return 0.5 * t * t * (share * share);
}

/* How much the gap of a point changes; `gone` has a last place for bodies at rest. */
static double change_of(const Motion *m, int32_t point, const double along[2], const double *gone) {
    int32_t a = m->points.pairs[point][0], b = m->points.pairs[point][1];
    a = a < 0 ? -1 : m->place[a], b = b < 0 ? -1 : m->place[b];
    return along[0] * gone[a < 0 ? m->count : a] + along[1] * gone[b < 0 ? m->count : b];
}

/* How gaps change: the relative motion of the two bodies along the normal. */
static void put_along(const Motion *m, const double (*rates)[6], double (*along)[2]) {
    for (int32_t k = 0; k < m->points.count; k++) {
        double row[6], normal[3] = {0.0, 0.0, 0.0};
        normal[m->points.axes[k]] = 1.0;
        for (int side = 0; side < 2; side++) {
            int32_t body = m->points.pairs[k][side], n = body < 0 ? -1 : m->place[body];
            along[k][side] = 0.0;
            if (n < 0) continue;
            put_wrench(row, normal, m->at[k], m->boxes->centres[body], m->way[body],
                       side ? 1.0 : -1.0);
            for (int c = 0; c < 6; c++) along[k][side] += row[c] * rates[n][c];
        }
    }
}

/* Moves until a gap closes, or through the time that is left; the time passed [s]. */
int coast(sl_work *work, Motion *m, const double (*rates)[6], const double *growth, double left,
          double *passed) {
    double *gaps = m->points.gaps;
    double (*along)[2] = take(work, (uint64_t)m->points.count, sizeof *along);
    double *gone = take(work, (uint64_t)m->count + 1, sizeof *gone);
    if (!along || !gone) return SL_MEMORY;
    put_along(m, rates, along);
    gone[m->count] = 0.0;
    *passed = left;
    bool closes = false;
    for (int sample = 1; !closes && sample <= SAMPLES; sample++) {
        *passed = left * sample / SAMPLES;
        for (int32_t n = 0; n < m->count; n++) gone[n] = pendulum(growth[n], *passed);
        for (int32_t k = 0; !closes && k < m->points.count; k++)
            closes = gaps[k] > TOUCH && gaps[k] + change_of(m, k, along[k], gone) <= TOUCH;
    }
    for (int32_t k = 0; k < m->points.count; k++) gaps[k] += change_of(m, k, along[k], gone);
    for (int32_t n = 0; n < m->count; n++)
        for (int c = 0; c < 6; c++) m->way[m->free[n]][c] += rates[n][c] * gone[n];
    return SL_STANDS;
}
