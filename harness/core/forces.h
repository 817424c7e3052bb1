/* Forces of those who set up the equations themselves. Units, arrays and threads as in
   steadyload.h. */
#ifndef SL_FORCES_H
#define SL_FORCES_H

#include "internal.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Forces [kg] at the corners (x0, z0), (x0, z1), (x1, z0), (x1, z1) of patches that come closest to
   balancing some `items` (size) of J boxes, by solving for all of them: `forces` (patches, 4).
   `used` (patches, 3): of every patch its place in `corners` (places, 4: x0, z0, x1, z1), the box
   above and the one below, -1 for the floor; a box that is none of the items is firm. `grow`: how
   much wider every patch counts on each side [cm]. found->ended and item as of balance, item the
   one that starts fastest; found->number is 1 where the search ended, else 0. Numbers of boxes and
   patches that do not exist are refused. */
SL_API int32_t sl_closest_to_balance(sl_work *work, int32_t count, const double *lower,
                                     const double *upper, const double *weights,
                                     const double *offsets, int32_t size, const int32_t *items,
                                     int32_t patches, const int32_t *used, int32_t places,
                                     const double *corners, double grow, double *forces,
                                     sl_finding *found);

/* The x >= 0 (count) with the least squares of target (rows) less the sum of x times columns
   (count, rows), and what is left over (rows). SL_STANDS, SL_UNRESOLVED where it gave up. */
SL_API int32_t sl_nonnegative_least_squares(sl_work *work, int32_t count, int32_t rows,
                                            const double *columns, const double *target, double *x,
                                            double *residual);

/* Forces of least energy of a load that grows: what was found before is changed, not found anew.
   E equations, three a box; C corners. Factors L D L' of the equations: the columns of L (E + 1
   starts), rows of their entries, ascending and behind the column, all values 0, and D (E). Effects
   of unit forces at corners over the roots of how far these yield: columns (C + 1 starts), rows,
   values. `right` (E); `presses` (C bytes): which corners probably press. All is copied. NULL: no
   memory, or numbers that make no such equations. */
typedef struct sl_energy sl_energy;
SL_API sl_energy *sl_energy_new(int32_t equations, const int32_t *starts, const int32_t *rows,
                                const double *diagonal, int32_t corners,
                                const int32_t *column_starts, const int32_t *column_rows,
                                const double *column_values, const double *right,
                                const uint8_t *presses);
SL_API void sl_energy_free(sl_energy *energy);

/* Puts the forces at `count` corners, times the roots of how far they yield, in `pulls` (count);
   what is below 0 is none. `corners` are those of boxes that are there, `some` the equations of the
   same boxes, in order. SL_STANDS, or SL_FAILS where none are found: nothing can be asked any more.
   SL_REFUSED: no such corners or equations, or after it failed. */
SL_API int32_t sl_energy_solve(sl_energy *energy, int32_t count, const int32_t *corners,
                               int32_t some_count, const int32_t *some, double *pulls);

#ifdef __cplusplus
}
#endif
#endif
