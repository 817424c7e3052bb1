/* The constants that Python states, too: constants.py. They are compared when the library is
   loaded (library.py). */
#include "learned.h"
#include "searching.h"
#include "timed.h"

#define OWN(name)                                                                                  \
    extern SL_API const double sl_constant_##name;                                                 \
    const double sl_constant_##name = name;
#define PUBLIC(name)                                                                               \
    extern SL_API const double sl_constant_##name;                                                 \
    const double sl_constant_##name = SL_##name;

PUBLIC(VERSION)
PUBLIC(STANDS) PUBLIC(FAILS) PUBLIC(UNRESOLVED) PUBLIC(OUTSIDE) PUBLIC(OVERLAPS) PUBLIC(MEMORY)
PUBLIC(REFUSED) PUBLIC(UNDECIDED) PUBLIC(LOOK)
PUBLIC(SUPPORTED) PUBLIC(CARRIED) PUBLIC(BALANCED)
PUBLIC(PLAIN) PUBLIC(SUPPORT) PUBLIC(QUANTITIES)
OWN(FLOOR) OWN(STATED_TOLERANCE) OWN(TOLERANCE) OWN(ROUNDING) OWN(EDGE) OWN(RESIDUE) OWN(NOISE)
OWN(TIE) OWN(TOUCH) OWN(EVENTS) OWN(SAMPLES) OWN(FAR) OWN(AT_REST)
OWN(LEFT_OUT) OWN(AS_PLANNED) OWN(TURNED)
