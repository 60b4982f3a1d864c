/* Numbers on their way to memory, past the caches. */
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#ifdef __SSE2__
#include <emmintrin.h>
#endif

/* A store usually fetches the line it changes before it is changed: for numbers that will have left the caches
   before anyone reads them that is a third of what goes to and from memory. Processors without such stores, and
   places that do not begin with a whole vector, get the usual ones. */
void gb_put_aside(const double *numbers, double *place, int count)
{
    int i = 0;

#ifdef __SSE2__
    if ((uintptr_t)place % sizeof(__m128d) == 0)
        for (; i + 1 < count; i += 2)
            _mm_stream_pd(place + i, _mm_loadu_pd(numbers + i));
#endif
    memcpy(place + i, numbers + i, (size_t)(count - i) * sizeof *numbers);
}
