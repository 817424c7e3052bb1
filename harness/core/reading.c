/* The contacts of a whole layout, to be read. */
#include "searching.h"

int32_t sl_contacts(sl_work *work, int32_t count, const double *lower, const double *upper,
                    const double *floor, uint8_t *on_floor, int32_t *starts, int32_t *above_starts,
                    int32_t room, int32_t *below, double *patches, int32_t *above) {
    if (count < 0 || count > SL_MOST) return -SL_REFUSED;
    Mark before = mark(work);
    Boxes boxes = boxes_of(count, lower, upper, NULL, NULL, floor);
    const Contacts *c = &boxes.contacts;
    int32_t size = find_contacts(work, &boxes) ? -SL_MEMORY : c->size;
    if (size >= 0) {
        memcpy(starts, c->starts, ((size_t)count + 1) * sizeof *starts);
        memcpy(above_starts, c->above_starts, ((size_t)count + 1) * sizeof *above_starts);
        for (int32_t j = 0; j < count; j++) on_floor[j] = c->on_floor[j];
    }
    if (size > 0 && size <= room) {
        size_t carried = (size_t)c->above_starts[count];
        memcpy(below, c->below, (size_t)size * sizeof *below);
        memcpy(patches, c->patches, (size_t)size * sizeof *c->patches);
        if (carried) memcpy(above, c->above, carried * sizeof *above);
    }
    free_to(work, before);
    return size;
}
