/* Margins and pressures in the horizontal plane. Called by features.c and tipping.c. */
#include "learned.h"

#define ROUNDS 6 /* of leaving out points that would pull */

/* Signed distance of a point to the border of a convex hull, positive inside; the nearest point of
   the border, and the way outwards. */
double margin_in(double x, double z, const double (*hull)[2], int32_t count, Edge *nearest) {
    double best = 1e300;
    bool inside = true;
    Edge edge = {0.0, 0.0, 0.0, 0.0};
    for (int32_t k = 0; k < count; k++) {
        const double *a = hull[k], *b = hull[(k + 1) % count];
        double ex = b[0] - a[0], ez = b[1] - a[1], length = root_of(ex * ex + ez * ez);
        if (length < 1e-12) continue;
        double side = (ex * (z - a[1]) - ez * (x - a[0])) / length;
        inside = inside && side >= 0.0;
        double along = (ex * (x - a[0]) + ez * (z - a[1])) / (length * length);
        along = least(1.0, most(0.0, along));
        double px = a[0] + along * ex, pz = a[1] + along * ez;
        double away = root_of((x - px) * (x - px) + (z - pz) * (z - pz));
        if (away < best - 1e-9) {
            best = away;
            edge = (Edge){px, pz, ez / length, -ex / length};
        }
    }
    if (!inside && best > 1e-9) edge.nx = (x - edge.x) / best, edge.nz = (z - edge.z) / best;
    *nearest = edge;
    return inside ? best : -best;
}

/* One round: pressures of the points that press, by least squares; whether some would pull. */
static bool solve(double x, double z, const double (*points)[2], const Part *parts, int32_t count,
                  double *forces) {
    double s = 0.0, sx = 0.0, sz = 0.0, sxx = 0.0, sxz = 0.0, szz = 0.0;
    for (int32_t k = 0; k < count; k++) {
        if (!(forces[k] > 0.0)) continue;
        double a = parts[k].area, u = points[k][0] - x, v = points[k][1] - z;
        s += a;
        sx += a * u, sz += a * v;
        sxx += a * u * u, sxz += a * u * v, szz += a * v * v;
    }
    /* A little ridge keeps points on one line solvable. */
    sxx += 1e-9 * s;
    szz += 1e-9 * s;
    /* [s sx sz; sx sxx sxz; sz sxz szz] (a, b, c) = (1, 0, 0) */
    double c0 = sxx * szz - sxz * sxz, c1 = sxz * sz - sx * szz, c2 = sx * sxz - sxx * sz;
    double det = s * c0 + sx * c1 + sz * c2;
    if (!(size_of(det) > 1e-300)) return false;
    bool pulled = false;
    for (int32_t k = 0; k < count; k++) {
        if (!(forces[k] > 0.0)) continue;
        double rise = c0 + c1 * (points[k][0] - x) + c2 * (points[k][1] - z);
        forces[k] = parts[k].area * rise / det;
        pulled = pulled || forces[k] < -1e-12;
    }
    return pulled;
}

/* Shares of a unit load at (x, z) among points: the evenest pressure that is nowhere below 0.

   A pressure linear in x and z by least squares; points that would pull are left out and it is
   solved again. Where rounds run out, what pulls is cut off and the rest scaled to the load. */
void pressures(double x, double z, const double (*points)[2], const Part *parts, int32_t count,
               double *forces) {
    for (int32_t k = 0; k < count; k++) forces[k] = parts[k].area;
    for (int round = 0; round < ROUNDS; round++)
        if (!solve(x, z, points, parts, count, forces)) break;
    double total = 0.0;
    for (int32_t k = 0; k < count; k++) {
        forces[k] = most(0.0, forces[k]);
        total += forces[k];
    }
    for (int32_t k = 0; k < count; k++)
        forces[k] = total > 0.0 ? forces[k] / total : 1.0 / (double)count;
}

/* Sorts points by x, then by z, as the hull wants them, with their parts unless there are none. */
void sort_points(double (*points)[2], Part *parts, int32_t count) {
    for (int32_t k = 1; k < count; k++) {
        double x = points[k][0], z = points[k][1];
        Part part = parts ? parts[k] : (Part){0.0, 0};
        int32_t at = k;
        for (; at; at--) {
            const double *p = points[at - 1];
            if (!(p[0] > x || (p[0] == x && p[1] > z))) break;
            points[at][0] = p[0], points[at][1] = p[1];
            if (parts) parts[at] = parts[at - 1];
        }
        points[at][0] = x, points[at][1] = z;
        if (parts) parts[at] = part;
    }
}
