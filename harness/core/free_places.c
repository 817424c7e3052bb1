/* Places at which a box would lie on something and overlap nothing, the nearest ones first: those
   of searching.h. */
#include "searching.h"

#define PARTS 1e3     /* of a cm, in which coordinates are that no other box has */
#define ALIKE 1e6     /* distances are alike that are the same in these parts of a cm */
#define EQUAL 1e-6    /* [cm] coordinates that differ by less are one */
#define MOST_PLACES 1000000

typedef struct {
    int32_t count;
    const double (*lower)[3], (*upper)[3], (*centres)[3];
    const sl_wanted *wanted;
} Others;

/* One side of a box; what is beside, below and above it at a height; and room for coordinates. */
typedef struct {
    const Others *others;
    const double *size, *middle, *start;
    bool on_floor;
    int32_t besides, belows, aboves, xs, zs;
    int32_t *beside, *below, *above, *taken, *carried, (*besides_at)[2], (*belows_at)[2];
    double *x, *z;
} Side;

/* To an integer, halves to even; the same with every C library. */
static double rounded(double value) {
    double whole = 0x1p52, size = size_of(value);
    return size < whole ? __builtin_copysign((size + whole) - whole, value) : value;
}

/* A coordinate in decimals that a plan has, rounded to the side where the margin is kept. */
static double in_decimals(double value, bool up) {
    double scaled = value * PARTS + (up ? -1e-6 : 1e-6), whole = rounded(scaled);
    if (up && whole < scaled) whole += 1.0;
    if (!up && whole > scaled) whole -= 1.0;
    return __builtin_copysign(whole, scaled) / PARTS;
}

/* Numbers of keys in ascending order; of equal ones the first comes first. */
static int32_t *ascending(sl_work *work, const double *keys, int32_t count) {
    int32_t *order = take(work, (uint64_t)count, sizeof *order);
    int32_t *other = take(work, (uint64_t)count, sizeof *other);
    if (!order || !other) return NULL;
    for (int32_t k = 0; k < count; k++) order[k] = k;
    for (int64_t wide = 1; wide < count; wide *= 2) {
        for (int64_t first = 0; first < count; first += 2 * wide) {
            int64_t middle = first + wide < count ? first + wide : count;
            int64_t end = middle + wide < count ? middle + wide : count;
            for (int64_t at = first, a = first, b = middle; at < end; at++) {
                bool second = a == middle || (b < end && keys[order[b]] < keys[order[a]]);
                other[at] = second ? order[b++] : order[a++];
            }
        }
        int32_t *made = other;
        other = order, order = made;
    }
    return order;
}

/* Puts a coordinate among others that ascend, if it is new; how many there are then. */
static int32_t with(double *made, int32_t count, double value, double low, double high) {
    int32_t k = count;
    if (!(low <= value && value <= high)) return count;
    while (k > 0 && made[k - 1] > value) k--;
    if (k > 0 && made[k - 1] == value) return count;
    for (int32_t n = count; n > k; n--) made[n] = made[n - 1];
    made[k] = value;
    return count + 1;
}

/* Coordinates along an axis, that where the box was in place of those that are as good. */
static int32_t thinned(double *made, int32_t count, double start) {
    int32_t kept = 0;
    for (int32_t n = 0; n < count; n++) {
        double value = size_of(made[n] - start) < EQUAL ? start : made[n];
        if (kept > 0 && value - made[kept - 1] < EQUAL) {
            if (value == start) made[kept - 1] = value;
        } else {
            made[kept++] = value;
        }
    }
    return kept;
}

/* Puts coordinates along an axis at which something may carry a box, ascending, each once. */
static int32_t coordinates(const Side *s, int axis, double *made) {
    const Others *o = s->others;
    const double *limits = o->wanted->limits, start = s->start[axis];
    double side = s->size[axis], margin = o->wanted->margin, middle = s->middle[axis];
    double low = limits[axis] - TOLERANCE, high = limits[3 + axis] + TOLERANCE;
    if (!s->on_floor) {
        double first = __builtin_inf(), end = -__builtin_inf();
        for (int32_t n = 0; n < s->belows; n++) {
            first = least(o->lower[s->below[n]][axis], first);
            end = most(o->upper[s->below[n]][axis], end);
        }
        low = most(first - side, low), high = least(end + side, high);
    }
    high -= side;
    int32_t count = with(made, 0, start, low, high);
    count = with(made, count, limits[axis], low, high);
    count = with(made, count, limits[3 + axis] - side, low, high);
    if (s->on_floor) {
        double from = limits[6 + axis / 2], to = limits[8 + axis / 2];
        count = with(made, count, from, low, high);
        count = with(made, count, to - side, low, high);
        count = with(made, count, from + margin - middle, low, high);
        count = with(made, count, to - margin - middle, low, high);
    }
    for (int32_t n = 0; n < s->besides; n++) {
        double from = o->lower[s->beside[n]][axis], to = o->upper[s->beside[n]][axis];
        count = with(made, count, from, low, high);
        count = with(made, count, to - side, low, high);
        count = with(made, count, to, low, high);
        count = with(made, count, from - side, low, high);
    }
    for (int32_t n = 0; n < s->belows; n++) {
        double from = o->lower[s->below[n]][axis], to = o->upper[s->below[n]][axis];
        count = with(made, count, from, low, high);
        count = with(made, count, to - side, low, high);
        count = with(made, count, in_decimals(from + margin - middle, true), low, high);
        count = with(made, count, in_decimals(to - margin - middle, false), low, high);
    }
    for (int32_t n = 0; n < s->aboves; n++) {
        double centre = o->centres[s->above[n]][axis];
        count = with(made, count, o->lower[s->above[n]][axis], low, high);
        count = with(made, count, o->upper[s->above[n]][axis] - side, low, high);
        count = with(made, count, in_decimals(centre + margin - side, true), low, high);
        count = with(made, count, in_decimals(centre - margin, false), low, high);
    }
    return thinned(made, count, start);
}

/* Of each of some boxes the first coordinate along z that meets it, and the first behind. */
static void put_ranges(const Side *s, const int32_t *boxes, int32_t count, int32_t (*found)[2]) {
    for (int32_t m = 0; m < count; m++) {
        double from = s->others->lower[boxes[m]][2], to = s->others->upper[boxes[m]][2];
        found[m][0] = found[m][1] = 0;
        for (int32_t n = 0; n < s->zs; n++) {
            if (least(to, s->z[n] + s->size[2]) - most(from, s->z[n]) > TOLERANCE) {
                if (found[m][1] == 0) found[m][0] = n;
                found[m][1] = n + 1;
            } else if (found[m][1] > 0) {
                break;
            }
        }
    }
}

/* Finds the boxes beside, below and above a box at a height. */
static void look_round(Side *s, double y) {
    const Others *o = s->others;
    s->on_floor = y <= TOLERANCE;
    s->besides = s->belows = s->aboves = 0;
    for (int32_t k = 0; k < o->count; k++) {
        double base = o->lower[k][1], top = o->upper[k][1];
        if (least(top, y + s->size[1]) - most(base, y) > TOLERANCE) s->beside[s->besides++] = k;
        else if (size_of(top - y) <= TOLERANCE) s->below[s->belows++] = k;
        else if (size_of(base - y - s->size[1]) <= TOLERANCE) s->above[s->aboves++] = k;
    }
}

/* How many of some boxes meet a column of places; where along z they begin to and cease. */
static int32_t mark_column(const Side *s, double x, const int32_t *boxes, int32_t count,
                           const int32_t (*at)[2], int32_t *marks) {
    const Others *o = s->others;
    int32_t met = 0;
    memset(marks, 0, ((size_t)s->zs + 1) * sizeof *marks);
    for (int32_t m = 0; m < count; m++) {
        const double *low = o->lower[boxes[m]], *high = o->upper[boxes[m]];
        if (!(least(high[0], x + s->size[0]) - most(low[0], x) > TOLERANCE)) continue;
        marks[at[m][0]]++, marks[at[m][1]]--;
        met++;
    }
    return met;
}

/* Adds the places at a height; false where there are as many as are looked for. */
static bool add_places(Side *s, double y, double (*found)[3], int32_t *count) {
    const sl_wanted *wanted = s->others->wanted;
    for (int32_t n = 0; n < s->xs; n++) {
        double x = s->x[n];
        int32_t carriers = mark_column(s, x, s->below, s->belows,
                                       (const int32_t (*)[2])s->belows_at, s->carried);
        if (!s->on_floor && carriers == 0) continue;
        mark_column(s, x, s->beside, s->besides, (const int32_t (*)[2])s->besides_at, s->taken);
        int32_t in_the_way = 0, carrying = s->on_floor;
        for (int32_t m = 0; m < s->zs; m++) {
            double z = s->z[m], across = x - s->start[0], along = z - s->start[2];
            in_the_way += s->taken[m], carrying += s->carried[m];
            if (in_the_way > 0 || carrying == 0) continue;
            if (root_of(across * across + along * along) > wanted->ways[0]) continue;
            if (*count == wanted->most) return false;
            found[*count][0] = x, found[*count][1] = y, found[*count][2] = z;
            ++*count;
        }
    }
    return true;
}

/* Places of a side of a box among others: flush with their faces, or just far enough over their
   edges. Along x and z a place is where the box was; at an end of the contour; flush with a side of
   a box beside, below or above it; or such that its centre of mass lies the margin inside an edge
   of what it lies on, or that of what lies on it inside its own. Along y it lies on the floor or on
   the top of a box. */
static int find_places(sl_work *work, const Others *o, const double *size, const double *middle,
                       const double *start, int32_t level_count, const double *levels,
                       double (*found)[3], int32_t *count) {
    const sl_wanted *wanted = o->wanted;
    Side s = {.others = o, .size = size, .middle = middle, .start = start};
    uint64_t boxes = (uint64_t)o->count, room = 8 + 4 * boxes;
    s.beside = take(work, boxes, sizeof *s.beside), s.below = take(work, boxes, sizeof *s.below);
    s.above = take(work, boxes, sizeof *s.above), s.taken = take(work, room, sizeof *s.taken);
    s.carried = take(work, room, sizeof *s.carried);
    s.besides_at = take(work, boxes, sizeof *s.besides_at);
    s.belows_at = take(work, boxes, sizeof *s.belows_at);
    s.x = take(work, room, sizeof *s.x), s.z = take(work, room, sizeof *s.z);
    *count = 0;
    if (!s.beside || !s.below || !s.above || !s.taken || !s.carried || !s.besides_at ||
        !s.belows_at || !s.x || !s.z) return SL_MEMORY;
    for (int32_t n = 0; n < level_count; n++) {
        double y = levels[n], up = y - start[1];
        if (y + size[1] > wanted->limits[4] + TOLERANCE) continue;
        if (!(wanted->ways[1] <= up && up <= wanted->ways[2])) continue;
        look_round(&s, y);
        if (!s.on_floor && s.belows == 0) continue;
        s.xs = coordinates(&s, 0, s.x);
        if (!s.xs) continue;
        s.zs = coordinates(&s, 2, s.z);
        put_ranges(&s, s.beside, s.besides, s.besides_at);
        put_ranges(&s, s.below, s.belows, s.belows_at);
        if (!add_places(&s, y, found, count)) break;
    }
    return SL_STANDS;
}

/* Whether a place comes before another one that is as far. */
static bool comes_before(const double *one, const double *other, double far, double other_far) {
    const int columns[4] = {1, 0, 2, 3};
    if (rounded(far * ALIKE) != rounded(other_far * ALIKE)) return false;
    for (int k = 0; k < 4; k++)
        if (one[columns[k]] != other[columns[k]]) return one[columns[k]] < other[columns[k]];
    return false;
}

/* The floor and the tops of boxes, each once, those nearest to a height first. */
static double *levels_of(sl_work *work, const Others *o, double height, int32_t *count) {
    uint64_t room = (uint64_t)o->count + 1;
    double *tops = take(work, room, sizeof *tops), *keys = take(work, room, sizeof *keys);
    double *levels = take(work, room, sizeof *levels);
    if (!tops || !keys || !levels) return NULL;
    tops[0] = 0.0;
    for (int32_t k = 0; k < o->count; k++) tops[k + 1] = o->upper[k][1];
    int32_t *order = ascending(work, tops, o->count + 1), size = 0;
    if (!order) return NULL;
    for (int32_t k = 0; k <= o->count; k++)
        if (k == 0 || tops[order[k]] != tops[order[k - 1]]) levels[size++] = tops[order[k]];
    for (int32_t k = 0; k < size; k++) keys[k] = size_of(levels[k] - height);
    order = ascending(work, keys, size);
    if (!order) return NULL;
    for (int32_t k = 0; k < size; k++) tops[k] = levels[order[k]];
    *count = size;
    return tops;
}

/* Places of all sides, as they are found. */
static int find_all(sl_work *work, const Others *o, const double (*sides)[3],
                    const double (*offsets)[3], const double *planned, int32_t turns,
                    double (*places)[4], double *far, int32_t *count) {
    int32_t level_count = 0, size = 0;
    double (*made)[3] = take(work, (uint64_t)o->wanted->most, sizeof *made);
    double *levels = levels_of(work, o, planned[1], &level_count);
    if (!levels || !made) return SL_MEMORY;
    *count = 0;
    for (int32_t turn = 0; turn < turns; turn++) {
        double middle[3], start[3];
        for (int axis = 0; axis < 3; axis++) {
            double side = sides[turn][axis];
            middle[axis] = 0.5 * side + offsets[turn][axis];
            start[axis] = planned[axis];
            if (turn) start[axis] = planned[axis] + 0.5 * sides[0][axis] - 0.5 * side;
        }
        if (find_places(work, o, sides[turn], middle, start, level_count, levels, made, &size))
            return SL_MEMORY;
        for (int32_t k = 0; k < size; k++, ++*count) {
            double squares = 0.0;
            for (int axis = 0; axis < 3; axis++) {
                double way = made[k][axis] - start[axis];
                places[*count][axis] = made[k][axis];
                squares += way * way;
            }
            places[*count][3] = turn;
            far[*count] = root_of(squares);
        }
    }
    return SL_STANDS;
}

/* The nearest places, in order, in `found` and `found_far`. */
static int nearest(sl_work *work, const Others *o, const double (*sides)[3],
                   const double (*offsets)[3], const double *planned, int32_t turns,
                   double (*found)[4], double *found_far, int32_t *count) {
    uint64_t room = (uint64_t)turns * (uint64_t)o->wanted->most;
    double (*places)[4] = take(work, room, sizeof *places), *far = take(work, room, sizeof *far);
    if (!places || !far) return SL_MEMORY;
    int ended = find_all(work, o, sides, offsets, planned, turns, places, far, count);
    if (ended) return ended;
    double *keys = take(work, (uint64_t)*count, sizeof *keys);
    if (!keys) return SL_MEMORY;
    for (int32_t k = 0; k < *count; k++) keys[k] = rounded(far[k] * ALIKE);
    int32_t *order = ascending(work, keys, *count);
    if (!order) return SL_MEMORY;
    for (int32_t k = 1; k < *count; k++) {
        int32_t at = order[k], m = k;
        for (; m > 0 && comes_before(places[at], places[order[m - 1]], far[at], far[order[m - 1]]);
             m--) order[m] = order[m - 1];
        order[m] = at;
    }
    for (int32_t k = 0; k < *count; k++) {
        memcpy(found[k], places[order[k]], sizeof *found);
        found_far[k] = far[order[k]];
    }
    return SL_STANDS;
}

int32_t sl_places_among(sl_work *work, const sl_boxes *boxes, const double *places,
                        const uint8_t *without, int32_t box, const sl_wanted *wanted,
                        int32_t turns, double *found, double *far) {
    int32_t count = boxes->count, others = 0;
    if (count < 0 || count > SL_MOST || wanted->most < 0 || wanted->most > MOST_PLACES || box < 0 ||
        box >= count || turns < 1 || turns > 2) return -SL_REFUSED;
    Mark before = mark(work);
    double (*lower)[3] = take(work, (uint64_t)count, sizeof *lower);
    double (*upper)[3] = take(work, (uint64_t)count, sizeof *upper);
    double (*centres)[3] = take(work, (uint64_t)count, sizeof *centres);
    for (int32_t other = 0; lower && upper && centres && other < count; other++) {
        const double *place = places + 4 * (size_t)other;
        if (other == box || without[other] || place[3] == LEFT_OUT) continue;
        size_t at = 3 * ((place[3] == TURNED ? (size_t)count : 0) + (size_t)other);
        for (size_t axis = 0; axis < 3; axis++) {
            double low = place[axis], high = place[axis] + boxes->sides[at + axis];
            lower[others][axis] = low, upper[others][axis] = high;
            centres[others][axis] = 0.5 * (low + high) + boxes->offsets[at + axis];
        }
        others++;
    }
    double sides[2][3], offsets[2][3];
    for (size_t turn = 0; turn < 2; turn++) {
        size_t at = 3 * (turn * (size_t)count + (size_t)box);
        memcpy(sides[turn], boxes->sides + at, sizeof sides[turn]);
        memcpy(offsets[turn], boxes->offsets + at, sizeof offsets[turn]);
    }
    int32_t made = 0;
    int ended = SL_MEMORY;
    Others o = {others, (const double (*)[3])lower, (const double (*)[3])upper,
                (const double (*)[3])centres, wanted};
    if (lower && upper && centres)
        ended = nearest(work, &o, (const double (*)[3])sides, (const double (*)[3])offsets,
                        boxes->planned + 4 * (size_t)box, turns, (double (*)[4])found, far, &made);
    free_to(work, before);
    return ended ? -ended : made;
}
