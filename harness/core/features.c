/* Features of every step, those of learned.h: a row of numbers a box, from the boxes placed by
   then.

   Of support: at step j the weight of box j goes down one way (the evenest pressure that has its
   resultant where it must be), and for every box that it reaches two quantities follow: how far
   inside its support the resultant of its load lies, and, where it lies outside, how far the box
   would tip or fall within the time of a label. No equilibrium is solved: where forces could be
   shared otherwise, this reports an instability that is none. */
#include "elementary.h"
#include "learned.h"

#define SECONDS 0.3    /* [s] that a label gives a box to fall */
#define GRAVITY 980.0  /* [cm/s2] */
#define THRESHOLD 10.0 /* [cm, degrees] of a label: beyond it a box has moved too far */
#define ON_FLOOR 500.0 /* [cm] margin of boxes on the floor */
#define SAFE 90.0      /* degrees: nothing is in the way */
#define REACH (0.5 * GRAVITY * SECONDS * SECONDS)
#define LEAST_OF_LOG 0.01 /* less is none */

static double degrees(double angle) { return angle * (180.0 / PI); }

/* Half units above a label's threshold, between -3 and 3. */
static double excess(double reached) {
    return least(3.0, most(-3.0, 2.0 * (reached - THRESHOLD)));
}

/* All that the steps of a layout need; points are corners of the patches below one box. */
typedef struct {
    const Boxes *boxes;
    double (*state)[SL_STATE];
    double (*points)[2], (*hull)[2], *forces;
    Part *parts;
    int32_t *order; /* boxes placed so far, the highest first */
    bool *reached;
} Steps;

/* Adds the corners of a patch; its area. */
static double add_patch(Steps *s, int32_t *count, const double patch[4], int32_t number) {
    double area = (patch[2] - patch[0]) * (patch[3] - patch[1]);
    for (int corner = 0; corner < 4; corner++) {
        put_corner(patch, corner, s->points[*count]);
        s->parts[(*count)++] = (Part){0.25 * area, number};
    }
    return area;
}

/* The corners of what carries a box, or of what it falls on, sorted; how many. */
static int32_t find_points(Steps *s, int32_t i, int32_t step, double level, bool supported) {
    const Contacts *c = &s->boxes->contacts;
    double *row = s->state[i], covered = 0.0, base[4], top[4], patch[4];
    int32_t count = 0, patches = 0;
    put_base(s->boxes, i, base);
    if (size_of(level) <= TOLERANCE && share(base, s->boxes->floor, patch))
        covered += add_patch(s, &count, patch, FLOOR), patches++;
    int32_t first = supported ? c->starts[i] : 0, end = supported ? c->ends[i] : step + 1;
    for (int32_t at = first; at < end; at++) {
        int32_t k = supported ? c->below[at] : at;
        if (k < 0 || k == i || k > step) continue;
        if (!(size_of(s->boxes->upper[k][1] - level) <= TOLERANCE)) continue;
        put_base(s->boxes, k, top);
        if (share(base, top, patch)) covered += add_patch(s, &count, patch, at), patches++;
    }
    const double *low = s->boxes->lower[i], *high = s->boxes->upper[i];
    if (supported) row[SL_SUPPORTERS] = patches;
    row[SL_SHARE] = (supported ? covered : 0.0) / ((high[0] - low[0]) * (high[2] - low[2]));
    sort_points(s->points, s->parts, count);
    return count;
}

/* How far a box whose resultant lies outside its support tips, into its state. */
static int tip(sl_work *work, Steps *s, const Tipping *tips) {
    const Boxes *boxes = s->boxes;
    const double *low = boxes->lower[tips->i], *high = boxes->upper[tips->i];
    const Edge *edge = &tips->edge;
    double *row = s->state[tips->i];
    double wide = high[0] - low[0], deep = high[2] - low[2], tall = high[1] - low[1];
    /* A box that tips over an edge: (r2 + d2 + h2) a'' = g (d + h a), from rest. */
    double seconds = SECONDS - root_of(2.0 * least(REACH, row[SL_DROP]) / GRAVITY);
    double lever = -row[SL_MARGIN], height = most(1e-6, boxes->centres[tips->i][1] - low[1]);
    double along = size_of(edge->nx) * wide + size_of(edge->nz) * deep;
    double inertia = (along * along + tall * tall) / 12.0 + lever * lever + height * height;
    double rate = most(0.0, seconds) * root_of(GRAVITY * height / inertia);
    double turned = lever / height * (hyperbolic_cosine_of(least(20.0, rate)) - 1.0);
    double free = least(RIGHT, turned);
    double touch, caught, furthest = tall;
    if (angles_to_catch(work, boxes, tips, &touch, &caught)) return SL_MEMORY;
    double angle = least(caught, free);
    for (int corner = 0; corner < 4; corner++) {
        double px = corner < 2 ? low[0] : high[0], pz = corner % 2 ? high[2] : low[2];
        double away = (px - edge->x) * edge->nx + (pz - edge->z) * edge->nz;
        furthest = most(size_of(away), furthest);
    }
    row[SL_FREE] = degrees(free), row[SL_TOUCH] = degrees(touch);
    row[SL_SIDE] = degrees(angle_to_side(boxes, tips->i, tips->step, edge));
    row[SL_CATCH] = degrees(caught), row[SL_ANGLE] = degrees(angle);
    row[SL_WAY] += angle * furthest;
    row[SL_HELD] = least(row[SL_SIDE], row[SL_ANGLE]);
    row[SL_LEVER] = lever;
    return SL_STANDS;
}

/* The force that a box exerts, to the patches that it stands on. */
static void press(Steps *s, double weight, double x, double z, int32_t count) {
    const double (*points)[2] = (const double (*)[2])s->points;
    pressures(x, z, points, s->parts, count, s->forces);
    for (int32_t k = 0; k < count; k++) {
        if (s->parts[k].patch == FLOOR) continue;
        double share = weight * s->forces[k], *onto = s->boxes->presses[s->parts[k].patch];
        onto[0] += share;
        onto[1] += share * points[k][0];
        onto[2] += share * points[k][1];
    }
}

/* True if a box stands on the floor or on another; forces of before are taken off. */
static bool is_carried(const Boxes *boxes, int32_t i, int32_t step) {
    const Contacts *c = &boxes->contacts;
    double base[4], patch[4];
    put_base(boxes, i, base);
    bool carried = boxes->lower[i][1] <= TOLERANCE && share(base, boxes->floor, patch);
    for (int32_t k = c->starts[i]; k < c->ends[i]; k++) {
        double *onto = boxes->presses[k];
        onto[0] = onto[1] = onto[2] = 0.0;
        carried = carried || (c->below[k] >= 0 && c->below[k] != i && c->below[k] <= step);
    }
    return carried;
}

/* Support of box i under its load, into its state; the force it exerts, into the presses. */
static int stand(sl_work *work, Steps *s, int32_t i, int32_t step) {
    const Boxes *boxes = s->boxes;
    const Contacts *c = &boxes->contacts;
    const double *low = boxes->lower[i], *high = boxes->upper[i];
    double *row = s->state[i], load = 0.0, weight = boxes->weights[i];
    double x = weight * boxes->centres[i][0] + 0.0, z = weight * boxes->centres[i][2] + 0.0;
    double own[4];
    put_base(boxes, i, own);
    bool out = stands_out(boxes->floor, own);
    for (int k = 0; k < SL_STATE; k++) row[k] = 0.0;
    row[SL_TOUCH] = row[SL_SIDE] = row[SL_CATCH] = SAFE;
    row[SL_EXCESS] = excess(0.0);
    row[SL_TALL] = high[1] - low[1];
    row[SL_SHORTER] = least(high[2] - low[2], high[0] - low[0]);
    for (int32_t k = c->above_starts[i]; k < c->above_ends[i] && c->above[k] <= step; k++) {
        const double *by = boxes->presses[c->meets[k]];
        load += by[0], weight += by[0];
        x += by[1];
        z += by[2];
    }
    row[SL_LOAD] = load / boxes->weights[i];
    if (low[1] <= TOLERANCE && !out) {
        row[SL_SHARE] = 1.0, row[SL_MARGIN] = ON_FLOOR, row[SL_RELATIVE] = 1.0;
        return SL_STANDS;
    }
    x /= weight;
    z /= weight;
    bool supported = is_carried(boxes, i, step);
    double level = supported ? low[1] : low[1] - height_to_fall(boxes, i, step);
    row[SL_DROP] = low[1] - level;
    row[SL_WAY] = least(REACH, row[SL_DROP]);
    if (level <= (out ? -boxes->floor[4] : 0.0) + TOLERANCE) { /* it falls, and stays upright */
        row[SL_MARGIN] = ON_FLOOR, row[SL_RELATIVE] = 1.0;
        row[SL_EXCESS] = excess(row[SL_WAY]);
        return SL_STANDS;
    }
    int32_t count = find_points(s, i, step, level, supported);
    Tipping tips = {.i = i, .step = step, .level = level, .x = x, .z = z};
    tips.hull = (const double (*)[2])s->hull;
    tips.corners = hull_of((const double (*)[2])s->points, count, s->hull, FLAT);
    row[SL_MARGIN] = margin_in(x, z, tips.hull, tips.corners, &tips.edge);
    row[SL_RELATIVE] = row[SL_MARGIN] / row[SL_SHORTER];
    if (row[SL_MARGIN] < 0.0) {
        if (tip(work, s, &tips)) return SL_MEMORY;
        x = tips.edge.x + 1e-6 * (x - tips.edge.x), z = tips.edge.z + 1e-6 * (z - tips.edge.z);
    }
    row[SL_EXCESS] = excess(most(row[SL_WAY], row[SL_ANGLE]));
    if (supported) press(s, weight, x, z, count);
    return SL_STANDS;
}

/* The state of every box that a step reaches, from the highest; how many, -1 without memory. */
static int32_t go_down(sl_work *work, Steps *s, int32_t step) {
    const Contacts *c = &s->boxes->contacts;
    int32_t at = step, count = 0;
    for (; at && s->boxes->lower[s->order[at - 1]][1] < s->boxes->lower[step][1]; at--)
        s->order[at] = s->order[at - 1];
    s->order[at] = step;
    memset(s->reached, 0, (size_t)step + 1);
    s->reached[step] = true;
    /* Boxes on the new one are lower in number, and may come before it. */
    for (int32_t k = c->above_starts[step]; k < c->above_ends[step] && c->above[k] < step; k++)
        s->reached[c->above[k]] = true;
    for (int32_t place = 0; place <= step; place++) {
        int32_t i = s->order[place];
        bool *is = s->reached + i;
        int32_t k = c->above_starts[i], end = c->above_ends[i];
        for (; !*is && k < end && c->above[k] <= step; k++)
            *is = c->above[k] != i && s->reached[c->above[k]];
        if (!*is) continue;
        count++;
        if (stand(work, s, i, step)) return -1;
    }
    return count;
}

static double danger_of(const double state[SL_STATE]) {
    return most(state[SL_WAY], state[SL_ANGLE]) - 1e-3 * state[SL_MARGIN];
}

/* Columns of a step, of which so many boxes were reached. */
static void fill_row(const Steps *s, int32_t step, int32_t count, double row[SL_SUPPORT]) {
    const Boxes *boxes = s->boxes;
    const Contacts *c = &boxes->contacts;
    const double *low = boxes->lower[step], *high = boxes->upper[step];
    double carriers = 0.0, lowest = 1e300;
    int32_t worst = step, unbalanced = 0, moving = 0;
    row[SL_ON_FLOOR] = low[1] <= TOLERANCE ? 1.0 : 0.0;
    memcpy(row + SL_OWN, s->state[step], sizeof *s->state);
    for (int32_t k = c->starts[step]; k < c->ends[step] && c->below[k] < step; k++)
        if (c->below[k] >= 0) carriers += boxes->weights[c->below[k]];
    row[SL_HEIGHT] = low[1];
    row[SL_WEIGHT] = carriers > 0.0 ? boxes->weights[step] / carriers : 1.0;
    row[SL_MASS_HEIGHT] = (boxes->centres[step][1] - low[1]) / (high[1] - low[1]);
    for (int32_t k = 0; k <= step; k++) {
        if (!s->reached[k]) continue;
        lowest = least(s->state[k][SL_MARGIN], lowest);
        unbalanced += s->state[k][SL_MARGIN] < 0.0;
        moving += s->state[k][SL_EXCESS] > 0.0;
        if (danger_of(s->state[k]) > danger_of(s->state[worst])) worst = k;
    }
    memcpy(row + SL_WORST, s->state[worst], sizeof *s->state);
    row[SL_WORST_HEIGHT] = boxes->lower[worst][1];
    row[SL_LEAST_MARGIN] = lowest, row[SL_BELOW] = count - 1;
    row[SL_UNBALANCED] = unbalanced, row[SL_MOVING] = moving;
}

static int fill_table(sl_work *work, Boxes *boxes, double (*table)[SL_SUPPORT]) {
    uint64_t count = (uint64_t)boxes->count, room = 4 * count + 8;
    if (find_centres(work, boxes) || find_contacts(work, boxes)) return SL_MEMORY;
    boxes->presses = take_zeros(work, (uint64_t)boxes->contacts.size, sizeof *boxes->presses);
    Steps s = {
        .boxes = boxes, .state = take_zeros(work, count, sizeof *s.state),
        .points = take(work, room, sizeof *s.points), .parts = take(work, room, sizeof *s.parts),
        .hull = take(work, 2 * room, sizeof *s.hull), .forces = take(work, room, sizeof *s.forces),
        .order = take(work, count, sizeof *s.order),
        .reached = take(work, count, sizeof *s.reached),
    };
    if (!boxes->presses || !s.state || !s.points || !s.parts || !s.hull || !s.forces || !s.order ||
        !s.reached) return SL_MEMORY;
    for (int32_t step = 0; step < boxes->count; step++) {
        int32_t reached = go_down(work, &s, step);
        if (reached < 0) return SL_MEMORY;
        fill_row(&s, step, reached, table[step]);
    }
    return SL_STANDS;
}

/* True for what networks take the log of, of the state of a box. */
static bool is_log(int state) {
    const int all = 1 << SL_FREE | 1 << SL_TOUCH | 1 << SL_SIDE | 1 << SL_CATCH | 1 << SL_ANGLE |
                    1 << SL_WAY | 1 << SL_HELD | 1 << SL_TALL | 1 << SL_LOAD | 1 << SL_SHORTER;
    return state >= 0 && state < SL_STATE && all >> state & 1;
}

/* A column as networks take it. */
static double feature_of(int column, double value) {
    bool takes_log = is_log(column - SL_OWN) || is_log(column - SL_WORST) || column == SL_WEIGHT;
    if (!takes_log) return hyperbolic_area_of(value);
    return logarithm_of(most(LEAST_OF_LOG, value / THRESHOLD));
}

int32_t sl_support(sl_work *work, int32_t count, const double *lower, const double *upper,
                   const double *weights, const double *offsets, const double *floor,
                   double *table, float *features) {
    if (count < 0 || count > SL_MOST) return SL_REFUSED;
    Boxes boxes = boxes_of(count, lower, upper, weights, offsets, floor);
    Mark before = mark(work);
    int32_t ended = fill_table(work, &boxes, (double (*)[SL_SUPPORT])table);
    free_to(work, before);
    if (ended) return ended;
    for (int32_t j = 0; j < count; j++)
        for (int column = 0; column < SL_SUPPORT; column++)
            *features++ = (float)feature_of(column, *table++);
    return SL_STANDS;
}

void sl_plain_features(int32_t count, const double *lower, const double *upper,
                       const double *weights, const double *offsets, const double *pallet,
                       float *features) {
    double longest = most(pallet[2], most(pallet[1], pallet[0]));
    double scale = logarithm_of(longest / 100.0);
    for (int32_t j = 0; j < count; j++) {
        const double *low = lower + 3 * (size_t)j, *high = upper + 3 * (size_t)j;
        float *row = features + SL_PLAIN * (size_t)j;
        for (int c = 0; c < 3; c++) {
            row[c] = (float)(low[c] / longest);
            row[3 + c] = (float)((high[c] - low[c]) / longest);
            row[6 + c] = (float)(offsets[3 * (size_t)j + (size_t)c] / longest);
            row[10 + c] = (float)(pallet[c] / longest);
        }
        row[9] = (float)(logarithm_of(weights[j]) - 3.0 * scale);
        row[13] = (float)scale;
    }
}

void sl_quantities(int32_t count, const double *lower, const double *upper, const double *weights,
                   const double *offsets, const double *floor, double *quantities) {
    double lightest = 1e300, heaviest = 0.0;
    for (int32_t j = 0; j < count; j++) {
        const double *low = lower + 3 * (size_t)j, *high = upper + 3 * (size_t)j;
        double *row = quantities + SL_QUANTITIES * (size_t)j;
        double shortest = 1e300, longest = 0.0, shift = 0.0;
        lightest = least(weights[j], lightest), heaviest = most(weights[j], heaviest);
        for (int c = 0; c < 3; c++) {
            double side = high[c] - low[c];
            shortest = least(side, shortest), longest = most(side, longest);
            shift = most(size_of(offsets[3 * (size_t)j + (size_t)c]) / side, shift);
        }
        const double base[4] = {low[0], low[2], high[0], high[2]};
        row[0] = shortest, row[1] = longest, row[2] = weights[j];
        row[3] = shift, row[4] = heaviest / lightest, row[5] = most(0.0, out_over(floor, base));
    }
}

int32_t sl_inside(int32_t count, const double *quantities, const double *least,
                  const double *most) {
    for (int32_t j = 0; j < count; j++)
        for (int k = 0; k < SL_QUANTITIES; k++) {
            double value = quantities[SL_QUANTITIES * (size_t)j + (size_t)k];
            if (!(least[k] <= value && value <= most[k])) return j;
        }
    return count;
}
