/* The figures of a number: C's library writes them several times faster than a write of Fortran's. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* So many significant figures (1 to 17) of a finite number, correctly rounded, without sign, point or end, and the
   power of ten of the first one. */
void gb_figures(double number, int count, char *figures, int *exponent)
{
    char text[48];
    const char *mark;

    snprintf(text, sizeof text, "%.*e", count - 1, fabs(number));
    mark = strchr(text, 'e'); /* a process that loads the library may have set another point than '.' */
    figures[0] = text[0];
    memcpy(figures + 1, mark - (count - 1), (size_t)(count - 1));
    *exponent = (int)strtol(mark + 1, NULL, 10);
}
